/* SPDX-License-Identifier: MIT */
/* Tiles are done in nearly the order of the batch. The thread packs a run of them, a slice of the
 * store's, as soon as all of the run and all before it are done; what is left when the last tile
 * is done is at most about one slice. It sleeps while there is nothing to pack. */
#include "jobs/internal/packing.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "jobs/internal/jobs.h"

struct pen_packing {
    const struct pen_store_observer *observer;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t more, idle;
    struct pen_pixels *pixels; /* the thread's while active, else the caller's */
    float *tiles;              /* of one slice; likewise */
    size_t tiles_pixels;       /* what it has room for */
    struct pen_tile_run run;   /* set while not active */
    int slice_tiles;           /* likewise */
    unsigned char *done;       /* guarded by lock; by tile from run.first on */
    int done_capacity;
    int ready, packed;       /* guarded by lock; so many tiles from run.first on are done, packed */
    bool active, drop, quit; /* guarded by lock */
    bool failed;             /* guarded by lock; with status */
    struct pen_status status;
    struct pen_store_call spent; /* the thread's; on this batch */
};

static int64_t thread_cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* The end of the slice after `packed`. */
static int slice_end(const struct pen_packing *p)
{
    int left = p->run.count - p->packed;
    return p->packed + (left < p->slice_tiles ? left : p->slice_tiles);
}

static bool pack_slice(struct pen_packing *p, int first, int count, struct pen_status *st)
{
    int64_t wall_ns = pen_clock_ns(), cpu_ns = thread_cpu_ns();
    pen_tiles_gather(p->run.settings, first, count, p->run.image, p->tiles);
    bool ok =
        pen_pixels_add(p->pixels, p->tiles, pen_tiles_pixels(p->run.settings, first, count), st);
    p->spent.wall_ns += pen_clock_ns() - wall_ns;
    p->spent.cpu_ns += thread_cpu_ns() - cpu_ns;
    return ok;
}

static void finish(struct pen_packing *p)
{
    if (p->observer)
        p->observer->called(p->observer->user, &p->spent);
    p->active = false;
    pthread_cond_signal(&p->idle);
}

/* Packs the next slice, or waits for it. Called and returns with the lock held. */
static void step(struct pen_packing *p)
{
    int begin = p->packed, end = slice_end(p);
    if (p->drop || p->failed || begin == p->run.count) {
        finish(p);
        return;
    }
    if (p->ready < end) {
        pthread_cond_wait(&p->more, &p->lock);
        return;
    }
    struct pen_status st;
    pthread_mutex_unlock(&p->lock);
    bool ok = pack_slice(p, p->run.first + begin, end - begin, &st);
    pthread_mutex_lock(&p->lock);
    p->packed = end;
    if (!ok) {
        p->failed = true;
        p->status = st;
    }
}

static void *work(void *user)
{
    struct pen_packing *p = user;
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

struct pen_packing *pen_packing_new(const struct pen_store_observer *observer,
                                    struct pen_status *st)
{
    struct pen_packing *p = calloc(1, sizeof *p);
    struct pen_pixels *pixels = p ? pen_pixels_new() : NULL;
    if (pixels) {
        p->observer = observer;
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
    pen_fail(st, PEN_NO_MEMORY, "no memory for the thread that packs pixels");
    pen_pixels_free(pixels);
    free(p);
    return NULL;
}

void pen_packing_free(struct pen_packing *p)
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

/* Of the largest tile. */
static int64_t tile_pixels(const struct pen_settings *s)
{
    return (int64_t)(s->tile < s->width ? s->tile : s->width) *
           (s->tile < s->height ? s->tile : s->height);
}

static bool make_room(struct pen_packing *p, const struct pen_tile_run *run, struct pen_status *st)
{
    int tiles = p->slice_tiles < run->count ? p->slice_tiles : run->count;
    size_t pixels = (size_t)tiles * (size_t)tile_pixels(run->settings);
    if (pixels > p->tiles_pixels) {
        free(p->tiles);
        p->tiles = pixels <= SIZE_MAX / 3 / sizeof *p->tiles ? malloc(pixels * 3 * sizeof *p->tiles)
                                                             : NULL;
        p->tiles_pixels = p->tiles ? pixels : 0;
    }
    if (run->count > p->done_capacity) {
        free(p->done);
        p->done = malloc((size_t)run->count);
        p->done_capacity = p->done ? run->count : 0;
    }
    return (p->tiles && p->done) || pen_fail(st, PEN_NO_MEMORY, "no memory to pack pixels");
}

bool pen_packing_begin(struct pen_packing *p, const struct pen_tile_run *run, struct pen_status *st)
{
    int64_t each = tile_pixels(run->settings);
    p->slice_tiles = each < PEN_PIXELS_SLICE ? (int)(PEN_PIXELS_SLICE / each) : 1;
    if (!make_room(p, run, st))
        return false;
    pen_pixels_begin(p->pixels);
    memset(p->done, 0, (size_t)run->count);
    pthread_mutex_lock(&p->lock);
    p->run = *run;
    p->ready = p->packed = 0;
    p->failed = p->drop = false;
    p->spent = (struct pen_store_call){.name = "pack"};
    p->active = true;
    pthread_mutex_unlock(&p->lock);
    return true;
}

void pen_packing_tile_done(void *packing, struct pen_rect rect)
{
    struct pen_packing *p = packing;
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

static void wait_until_idle(struct pen_packing *p, bool drop)
{
    pthread_mutex_lock(&p->lock);
    p->drop = drop;
    pthread_cond_signal(&p->more);
    while (p->active)
        pthread_cond_wait(&p->idle, &p->lock);
    pthread_mutex_unlock(&p->lock);
}

bool pen_packing_end(struct pen_packing *p, const struct pen_pixels **packed, struct pen_status *st)
{
    wait_until_idle(p, false);
    *packed = p->pixels;
    if (p->failed)
        *st = p->status;
    return !p->failed;
}

void pen_packing_drop(struct pen_packing *p)
{
    wait_until_idle(p, true);
}
