/* SPDX-License-Identifier: MIT */
/* Every thread has a place for the tile that it has begun. One word of it contains the tile and the
 * number of blocks taken. Adding 1 takes a block and returns its tile, so other threads can take
 * blocks at any time.
 *
 * Other threads do so only when the task has no tile left. From then on no place gets another tile,
 * so `left` and `spent_ns` belong to the same tile as the block. A tile is taken and its place
 * filled under one lock. So a thread that sees that no tile is left finds all tiles in their
 * places. */
#include "render/internal/tile_queue.h"

#include <pthread.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdlib.h>

/* It has its own cache line, because its thread writes to it at each block. */
struct pen_begun_tile {
    /* The tile, and below it in BLOCK_BITS the number of blocks taken. Atomic: a thread that takes
     * a block acquires everything stored before the tile was put here. */
    alignas(64) atomic_uint_least64_t taken;
    atomic_llong spent_ns; /* by the blocks that are done; atomic: ordered by `left` */
    atomic_int left; /* blocks not done yet; atomic: the last to be done acquires the others */
};

/* A tile has fewer blocks than 2^31 even if its blocks are single pixels. Each thread that finds no
 * block left adds 1 to the number at most once for each tile. So the number never overflows into
 * the tile. */
enum { BLOCK_BITS = 32 };

struct pen_tile_queue {
    const struct pen_render_task *task;
    const struct pen_settings *settings;
    int threads;
    pthread_mutex_t lock;
    int next_tile, end_tile; /* guarded by lock */
    struct pen_begun_tile *begun;
};

/* The number of blocks that cover `pixels` along one axis. */
static int blocks_along(int pixels)
{
    return (pixels + PEN_BLOCK_SIDE - 1) / PEN_BLOCK_SIDE;
}

static int blocks_of(struct pen_rect tile)
{
    return blocks_along(tile.width) * blocks_along(tile.height);
}

static struct pen_rect rect_of(const struct pen_settings *s, int tile)
{
    return pen_tile_rect(s->width, s->height, s->tile, tile);
}

int pen_tile_queue_threads(const struct pen_settings *settings, int first_tile, int end_tile,
                           int most)
{
    int blocks = 0;
    for (int tile = first_tile; tile < end_tile && blocks < most; tile++)
        blocks += blocks_of(rect_of(settings, tile));
    return blocks < most ? blocks : most;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

/* Block number `block` of a tile, row by row. */
static struct pen_rect block_rect(struct pen_rect tile, int block)
{
    const int columns = blocks_along(tile.width);
    const int x = block % columns * PEN_BLOCK_SIDE, y = block / columns * PEN_BLOCK_SIDE;
    return (struct pen_rect){tile.x + x, tile.y + y, smaller(tile.width - x, PEN_BLOCK_SIDE),
                             smaller(tile.height - y, PEN_BLOCK_SIDE)};
}

/* A place without a tile: one whose blocks are all taken. */
static const uint64_t no_tile = INT32_MAX;

struct pen_tile_queue *pen_tile_queue_new(const struct pen_render_task *task, int end_tile,
                                          int threads)
{
    struct pen_tile_queue *queue = calloc(1, sizeof *queue);
    struct pen_begun_tile *begun =
        aligned_alloc(alignof(struct pen_begun_tile), (size_t)threads * sizeof *begun);
    if (!queue || !begun) {
        free(queue);
        free(begun);
        return NULL;
    }
    queue->task = task;
    queue->settings = task->settings;
    queue->threads = threads;
    queue->next_tile = task->first_tile;
    queue->end_tile = end_tile;
    queue->begun = begun;
    pthread_mutex_init(&queue->lock, NULL);
    for (int i = 0; i < threads; i++)
        atomic_init(&begun[i].taken, no_tile);
    return queue;
}

void pen_tile_queue_free(struct pen_tile_queue *queue)
{
    if (!queue)
        return;
    pthread_mutex_destroy(&queue->lock);
    free(queue->begun);
    free(queue);
}

/* The next block of a place, given its value `taken`. Returns false if it has none. */
static bool block_at(const struct pen_tile_queue *queue, uint64_t taken,
                     struct pen_tile_block *block)
{
    const int tile = (int)(taken >> BLOCK_BITS);
    const struct pen_rect rect = rect_of(queue->settings, tile);
    const uint32_t number = (uint32_t)taken;
    if (number >= (uint32_t)blocks_of(rect))
        return false;
    block->tile = tile;
    block->rect = block_rect(rect, (int)number);
    return true;
}

static bool take_from(const struct pen_tile_queue *queue, int thread, struct pen_tile_block *block)
{
    block->of = &queue->begun[thread];
    return block_at(queue, atomic_load_explicit(&block->of->taken, memory_order_relaxed), block) &&
           block_at(queue, atomic_fetch_add_explicit(&block->of->taken, 1, memory_order_acquire),
                    block);
}

/* Whether the task pauses before the next tile. Called with the lock held. */
static bool pauses(const struct pen_tile_queue *queue)
{
    const struct pen_render_task *task = queue->task;
    return task->pause && queue->next_tile > task->first_tile && task->pause(task->pause_user);
}

/* Begins the next tile. Returns false if there is none. */
static bool begin_tile(struct pen_tile_queue *queue, int thread)
{
    struct pen_begun_tile *begun = &queue->begun[thread];
    pthread_mutex_lock(&queue->lock);
    if (queue->next_tile < queue->end_tile && pauses(queue))
        queue->end_tile = queue->next_tile;
    const bool any = queue->next_tile < queue->end_tile;
    if (any) {
        const int tile = queue->next_tile++;
        atomic_store_explicit(&begun->spent_ns, 0, memory_order_relaxed);
        atomic_store_explicit(&begun->left, blocks_of(rect_of(queue->settings, tile)),
                              memory_order_relaxed);
        atomic_store_explicit(&begun->taken, (uint64_t)tile << BLOCK_BITS, memory_order_release);
    }
    pthread_mutex_unlock(&queue->lock);
    return any;
}

bool pen_tile_queue_take(struct pen_tile_queue *queue, int thread, struct pen_tile_block *block)
{
    do {
        if (take_from(queue, thread, block))
            return true;
    } while (begin_tile(queue, thread));
    for (int i = 1; i < queue->threads; i++) {
        if (take_from(queue, (thread + i) % queue->threads, block))
            return true;
    }
    return false;
}

bool pen_tile_queue_done(struct pen_tile_block *block, int64_t block_ns, int64_t *tile_ns)
{
    struct pen_begun_tile *of = block->of;
    atomic_fetch_add_explicit(&of->spent_ns, block_ns, memory_order_relaxed);
    if (atomic_fetch_sub_explicit(&of->left, 1, memory_order_acq_rel) != 1)
        return false;
    *tile_ns = atomic_load_explicit(&of->spent_ns, memory_order_relaxed);
    return true;
}

int pen_tile_queue_end(const struct pen_tile_queue *queue)
{
    return queue->end_tile;
}
