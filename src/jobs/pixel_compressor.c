/* SPDX-License-Identifier: MIT */
/* The store keeps pixels in slices of PEN_PIXELS_SLICE; here a slice is a run of whole tiles. Tiles
 * are finished in nearly the order of the batch. The thread compresses a slice as soon as all tiles
 * up to its end are finished, so about one slice at most is left when the last tile is finished.
 * The thread sleeps while there is nothing to compress. */
#include "jobs/internal/pixel_compressor.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "jobs/internal/view_pixels.h"

struct pen_pixel_compressor {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t more, idle;
    struct pen_pixels *pixels; /* used by the thread while active, else by the caller */
    float *tiles;              /* of one slice; likewise */
    size_t tiles_pixels;       /* the capacity of tiles */
    struct pen_tile_run run;   /* set while not active; its count, which may be cut, is guarded by
                                * lock */
    int slice_tiles;           /* likewise */
    unsigned char *done;       /* guarded by lock; done[i]: tile run.first + i is finished */
    int done_capacity;
    int ready;      /* guarded by lock; tiles before run.first + ready are finished */
    int compressed; /* guarded by lock; tiles before run.first + compressed are compressed */
    bool active, cancel, quit; /* guarded by lock */
    bool failed;               /* guarded by lock; with status */
    struct pen_status status;
};

/* The end of the next slice, in tiles from run.first on. */
static int slice_end(const struct pen_pixel_compressor *p)
{
    int left = p->run.count - p->compressed;
    return p->compressed + (left < p->slice_tiles ? left : p->slice_tiles);
}

static bool compress_slice(struct pen_pixel_compressor *p, int first, int count,
                           struct pen_status *st)
{
    pen_tiles_gather(p->run.settings, first, count, p->run.image, p->tiles);
    return pen_pixels_add(p->pixels, p->tiles, pen_tiles_pixels(p->run.settings, first, count), st);
}

static void finish(struct pen_pixel_compressor *p)
{
    p->active = false;
    pthread_cond_signal(&p->idle);
}

/* Compresses the next slice, or waits for it. Called and returns with the lock held. */
static void step(struct pen_pixel_compressor *p)
{
    int begin = p->compressed, end = slice_end(p);
    if (p->cancel || p->failed || begin == p->run.count) {
        finish(p);
        return;
    }
    if (p->ready < end) {
        pthread_cond_wait(&p->more, &p->lock);
        return;
    }
    struct pen_status st;
    pthread_mutex_unlock(&p->lock);
    bool ok = compress_slice(p, p->run.first + begin, end - begin, &st);
    pthread_mutex_lock(&p->lock);
    p->compressed = end;
    if (!ok) {
        p->failed = true;
        p->status = st;
    }
}

static void *work(void *user)
{
    struct pen_pixel_compressor *p = user;
    pthread_mutex_lock(&p->lock);
    while (!p->quit) {
        if (p->active)
            step(p);
        else
            pthread_cond_wait(&p->more, &p->lock);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

struct pen_pixel_compressor *pen_pixel_compressor_new(struct pen_status *st)
{
    struct pen_pixel_compressor *p = calloc(1, sizeof *p);
    struct pen_pixels *pixels = p ? pen_pixels_new() : NULL;
    if (pixels) {
        p->pixels = pixels;
        pthread_mutex_init(&p->lock, NULL);
        pthread_cond_init(&p->more, NULL);
        pthread_cond_init(&p->idle, NULL);
        if (pthread_create(&p->thread, NULL, work, p) == 0)
            return p;
        pthread_cond_destroy(&p->idle);
        pthread_cond_destroy(&p->more);
        pthread_mutex_destroy(&p->lock);
    }
    pen_fail(st, PEN_NO_MEMORY, "no memory for the thread that compresses pixels");
    pen_pixels_free(pixels);
    free(p);
    return NULL;
}

void pen_pixel_compressor_free(struct pen_pixel_compressor *p)
{
    if (!p)
        return;
    pthread_mutex_lock(&p->lock);
    p->quit = true;
    pthread_cond_signal(&p->more);
    pthread_mutex_unlock(&p->lock);
    pthread_join(p->thread, NULL);
    pthread_cond_destroy(&p->idle);
    pthread_cond_destroy(&p->more);
    pthread_mutex_destroy(&p->lock);
    pen_pixels_free(p->pixels);
    free(p->tiles);
    free(p->done);
    free(p);
}

/* Pixels of the largest tile. */
static int64_t tile_pixels(const struct pen_settings *s)
{
    return (int64_t)(s->tile < s->width ? s->tile : s->width) *
           (s->tile < s->height ? s->tile : s->height);
}

static bool reserve(struct pen_pixel_compressor *p, const struct pen_tile_run *run,
                    struct pen_status *st)
{
    int tiles = p->slice_tiles < run->count ? p->slice_tiles : run->count;
    size_t pixels = (size_t)tiles * (size_t)tile_pixels(run->settings);
    if (pixels > p->tiles_pixels) {
        free(p->tiles);
        p->tiles = pixels <= SIZE_MAX / 3 / sizeof *p->tiles
                       ? pen_memory_large(pixels * 3 * sizeof *p->tiles)
                       : NULL;
        p->tiles_pixels = p->tiles ? pixels : 0;
    }
    if (run->count > p->done_capacity) {
        free(p->done);
        p->done = malloc((size_t)run->count);
        p->done_capacity = p->done ? run->count : 0;
    }
    return (p->tiles && p->done) || pen_fail(st, PEN_NO_MEMORY, "no memory to compress pixels");
}

bool pen_pixel_compressor_begin(struct pen_pixel_compressor *p, const struct pen_tile_run *run,
                                struct pen_status *st)
{
    int64_t each = tile_pixels(run->settings);
    p->slice_tiles = each < PEN_PIXELS_SLICE ? (int)(PEN_PIXELS_SLICE / each) : 1;
    if (!reserve(p, run, st))
        return false;
    pen_pixels_begin(p->pixels);
    memset(p->done, 0, (size_t)run->count);
    pthread_mutex_lock(&p->lock);
    p->run = *run;
    p->ready = p->compressed = 0;
    p->failed = p->cancel = false;
    p->active = true;
    pthread_mutex_unlock(&p->lock);
    return true;
}

void pen_pixel_compressor_tile_done(void *compressor, struct pen_rect rect)
{
    struct pen_pixel_compressor *p = compressor;
    const struct pen_settings *s = p->run.settings;
    int tile = rect.y / s->tile * pen_tile_count(s->width, 1, s->tile) + rect.x / s->tile;
    pthread_mutex_lock(&p->lock);
    p->done[tile - p->run.first] = 1;
    while (p->ready < p->run.count && p->done[p->ready])
        p->ready++;
    if (p->ready >= slice_end(p))
        pthread_cond_signal(&p->more);
    pthread_mutex_unlock(&p->lock);
}

void pen_pixel_compressor_cut(struct pen_pixel_compressor *p, int count)
{
    pthread_mutex_lock(&p->lock);
    p->run.count = count;
    pthread_cond_signal(&p->more);
    pthread_mutex_unlock(&p->lock);
}

static void wait_until_idle(struct pen_pixel_compressor *p, bool cancel)
{
    pthread_mutex_lock(&p->lock);
    p->cancel = cancel;
    pthread_cond_signal(&p->more);
    while (p->active)
        pthread_cond_wait(&p->idle, &p->lock);
    pthread_mutex_unlock(&p->lock);
}

bool pen_pixel_compressor_end(struct pen_pixel_compressor *p, const struct pen_pixels **encoded,
                              struct pen_status *st)
{
    wait_until_idle(p, false);
    *encoded = p->pixels;
    if (p->failed)
        *st = p->status;
    return !p->failed;
}

void pen_pixel_compressor_cancel(struct pen_pixel_compressor *p)
{
    wait_until_idle(p, true);
}
