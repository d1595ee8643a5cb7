/* SPDX-License-Identifier: MIT */
/* Distributes the tiles of a task to its threads, in blocks of PEN_BLOCK_SIDE x PEN_BLOCK_SIDE
 * pixels. A thread takes the next tile of the task and then its blocks, one by one. When no tile is
 * left, it takes blocks of tiles that other threads have begun, so no thread waits longer than one
 * block takes. A tile is done when all its blocks are, by any threads.
 *
 * Threads: a thread takes blocks for its own number in the run. */
#ifndef PEN_RENDER_INTERNAL_TILE_QUEUE_H
#define PEN_RENDER_INTERNAL_TILE_QUEUE_H

#include <stdint.h>

#include "render/render.h"

struct pen_tile_queue;
struct pen_begun_tile;

/* Makes a queue of the tiles of a task up to end_tile - 1, or until it pauses, for this number of
 * threads.
 * Owns: free with pen_tile_queue_free.
 * Fails: NULL when out of memory. */
struct pen_tile_queue *pen_tile_queue_new(const struct pen_render_task *task, int end_tile,
                                          int threads);
void pen_tile_queue_free(struct pen_tile_queue *queue);

/* A block that a thread has taken. */
struct pen_tile_block {
    int tile;
    struct pen_rect rect;
    struct pen_begun_tile *of;
};

/* Takes the next block. Returns false if no block is left. */
bool pen_tile_queue_take(struct pen_tile_queue *queue, int thread, struct pen_tile_block *block);

/* Records that a block is rendered, and its time. Returns true if its tile is now done. Then
 * *tile_ns is the total time of the tile's blocks, and all its pixels can be read. */
bool pen_tile_queue_done(struct pen_tile_block *block, int64_t block_ns, int64_t *tile_ns);

/* The first tile that is not handed out: end_tile, or the tile before which the task paused.
 * Threads: only when no other thread uses the queue. */
int pen_tile_queue_end(const struct pen_tile_queue *queue);

/* The number of threads that these tiles can keep busy: the number of their blocks, but at most
 * `most`. */
int pen_tile_queue_threads(const struct pen_settings *settings, int first_tile, int end_tile,
                           int most);

#endif
