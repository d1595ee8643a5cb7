/* SPDX-License-Identifier: MIT */
/* Hands out the tiles of a task to its threads, in blocks of PEN_BLOCK_SIDE x PEN_BLOCK_SIDE
 * pixels. A thread takes the next tile of the task and then its blocks, one by one. When no tile is
 * left it takes blocks of the tiles that other threads have begun, so that no thread waits longer
 * than one block takes. A tile is done when all its blocks are, whoever rendered them.
 *
 * Threads: a thread takes blocks for the number it has in the run. */
#ifndef PEN_RENDER_INTERNAL_TILE_QUEUE_H
#define PEN_RENDER_INTERNAL_TILE_QUEUE_H

#include <stdint.h>

#include "render/render.h"

struct pen_tile_queue;
struct pen_begun_tile;

/* The tiles of a task up to end_tile - 1, or until it pauses, for that many threads. Owns: free
 * with pen_tile_queue_free. Fails: NULL when out of memory. */
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

/* Notes that a block is rendered, and the time it took. Returns whether its tile is done with it;
 * then *tile_ns is the time that all its blocks took together, and the pixels of all of them can be
 * read. */
bool pen_tile_queue_done(struct pen_tile_block *block, int64_t block_ns, int64_t *tile_ns);

/* The first tile that is not handed out: end_tile, or the one before which the task has paused.
 * Threads: call it when no other thread uses the queue. */
int pen_tile_queue_end(const struct pen_tile_queue *queue);

/* How many threads these tiles can keep busy: as many as they have blocks, and at most `most`. */
int pen_tile_queue_threads(const struct pen_settings *settings, int first_tile, int end_tile,
                           int most);

#endif
