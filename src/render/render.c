/* SPDX-License-Identifier: MIT */
/* Rendering a task: threads draw tiles from one counter, row by row from the top left, and write
 * their pixels where they belong. A pixel is a pure function of its place, so who draws which tile
 * when changes nothing but the time; nothing else is shared but the calls of tile_done. */
#include "render/render.h"

#include <fenv.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "base/thread_pool.h"
#include "render/internal/counter.h"

/* What one thread did; written by that thread alone, read when all are done. */
struct part {
    const struct pen_kernel_input *input; /* the run's, or that of `counter` */
    struct pen_counter *counter;          /* NULL unless tests are counted */
    struct pen_kernel_scratch *scratch;
    struct pen_ray_counts rays;
    int64_t begun_ns, done_ns, cpu_ns;
    int tiles;
};

struct run {
    const struct pen_render_task *task;
    struct pen_kernel_input input;
    const struct pen_kernel *kernel;
    int last_tile;
    atomic_int next_tile; /* relaxed: only its value matters, tiles share nothing */
    struct part *parts;
    int threads;
    double *tile_ms;           /* by tile from first_tile on; may be NULL */
    pthread_mutex_t done_lock; /* one call of tile_done at a time */
};

static int64_t thread_cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static bool cancelled(const struct pen_render_task *task)
{
    return task->cancel && atomic_load_explicit(task->cancel, memory_order_relaxed);
}

/* Made in default arithmetic, whatever the calling thread's is. */
static struct pen_kernel_input kernel_input(const struct pen_scene *scene, int view,
                                            const struct pen_settings *settings)
{
    fenv_t caller;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    struct pen_kernel_input input = {
        .scene = scene,
        .settings = settings,
        .pinhole = pen_scene_pinhole(scene, view, settings->width, settings->height),
        .effects = pen_scene_effects(scene, settings),
        .trace = pen_trace_ops_get(pen_cpu_isa()),
    };
    fesetenv(&caller);
    return input;
}

/* Renders one tile; false if cancelled on the way. */
static bool render_tile(const struct run *run, int thread, struct pen_rect rect)
{
    const struct pen_render_task *task = run->task;
    struct part *part = &run->parts[thread];
    for (int y = rect.y; y < rect.y + rect.height; y++) {
        float *out = task->rgb + 3 * ((size_t)y * (size_t)task->settings->width + (size_t)rect.x);
        for (int x = rect.x; x < rect.x + rect.width; x++, out += 3) {
            double rgb[3];
            if (cancelled(task))
                return false;
            if (task->pixel_begins)
                task->pixel_begins(task->pixel_user, thread, x, y);
            run->kernel->pixel(part->input, part->scratch, x, y, rgb, &part->rays);
            for (int c = 0; c < 3; c++)
                out[c] = (float)rgb[c];
        }
    }
    return true;
}

static void tile_finished(struct run *run, struct pen_rect rect)
{
    if (!run->task->tile_done)
        return;
    pthread_mutex_lock(&run->done_lock);
    run->task->tile_done(run->task->user, rect);
    pthread_mutex_unlock(&run->done_lock);
}

static void render_part(void *user, int index)
{
    struct run *run = user;
    struct part *part = &run->parts[index];
    const struct pen_settings *settings = run->task->settings;
    int64_t cpu = thread_cpu_ns();
    part->begun_ns = part->done_ns = pen_clock_ns();
    for (;;) {
        int tile = atomic_fetch_add_explicit(&run->next_tile, 1, memory_order_relaxed);
        if (tile >= run->last_tile)
            break;
        struct pen_rect rect =
            pen_tile_rect(settings->width, settings->height, settings->tile, tile);
        int64_t begun = pen_clock_ns();
        if (!render_tile(run, index, rect))
            break;
        part->done_ns = pen_clock_ns();
        part->tiles++;
        if (run->tile_ms)
            run->tile_ms[tile - run->task->first_tile] = (double)(part->done_ns - begun) * 1e-6;
        tile_finished(run, rect);
    }
    part->cpu_ns = thread_cpu_ns() - cpu;
}

static void add_counts(struct pen_ray_counts *sum, const struct pen_ray_counts *part)
{
    sum->primary += part->primary;
    sum->shadow += part->shadow;
    sum->reflection += part->reflection;
    sum->transmission += part->transmission;
    sum->dropped_samples += part->dropped_samples;
}

/* Sums up what the threads did. Returns the number of tiles done. */
static int gather(const struct run *run, struct pen_render_stats *stats)
{
    int64_t begun = INT64_MAX, done = 0, cpu = 0;
    int tiles = 0;
    for (int i = 0; i < run->threads; i++) {
        const struct part *part = &run->parts[i];
        add_counts(&stats->rays, &part->rays);
        begun = part->begun_ns < begun ? part->begun_ns : begun;
        done = part->done_ns > done ? part->done_ns : done;
        cpu += part->cpu_ns;
        tiles += part->tiles;
        if (part->counter)
            pen_counter_add(part->counter, &stats->tests);
    }
    stats->tests_counted = run->task->count_tests;
    stats->render_ms = (double)(done - begun) * 1e-6;
    stats->cpu_ms = (double)cpu * 1e-6;
    stats->threads = run->threads;
    stats->kernel = run->kernel->name;
    stats->effects = run->input.effects;
    return tiles;
}

static bool make_parts(struct run *run, struct pen_status *st)
{
    run->parts = calloc((size_t)run->threads, sizeof *run->parts);
    if (!run->parts)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for %d render threads", run->threads);
    for (int i = 0; i < run->threads; i++) {
        struct part *part = &run->parts[i];
        part->input = &run->input;
        if (run->task->count_tests) {
            part->counter = pen_counter_new(&run->input);
            part->input = part->counter ? pen_counter_input(part->counter) : NULL;
        }
        part->scratch = part->input ? pen_kernel_scratch_new(part->input) : NULL;
        if (!part->scratch)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory for the paths of a render thread");
    }
    return true;
}

static void free_parts(struct run *run)
{
    for (int i = 0; run->parts && i < run->threads; i++) {
        pen_kernel_scratch_free(run->parts[i].scratch);
        pen_counter_free(run->parts[i].counter);
    }
    free(run->parts);
}

static bool run_tiles(struct pen_thread_pool *pool, struct run *run, struct pen_render_stats *stats,
                      struct pen_status *st)
{
    int wanted = run->last_tile - run->task->first_tile;
    if (run->task->keep_tile_ms) {
        run->tile_ms = calloc((size_t)wanted + 1, sizeof *run->tile_ms);
        if (!run->tile_ms)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory for the times of %d tiles", wanted);
    }
    if (!make_parts(run, st))
        return false;
    stats->float_resets = pen_thread_pool_run(pool, run->threads, render_part, run);
    stats->tile_count = (uint32_t)gather(run, stats);
    if (stats->tile_count < (uint32_t)wanted)
        return pen_fail(st, PEN_CANCELLED, "cancelled after %u of %d tiles", stats->tile_count,
                        wanted);
    stats->tile_ms = run->tile_ms;
    return true;
}

/* How many threads work on a task: what the settings ask for, if the pool has them, and no more
 * than there are tiles. */
static int threads_for(const struct pen_thread_pool *pool, int asked, int tiles)
{
    int threads = pen_thread_pool_size(pool);
    if (asked > 0 && asked < threads)
        threads = asked;
    if (tiles < threads)
        threads = tiles;
    return threads > 1 ? threads : 1;
}

bool pen_render_run(struct pen_thread_pool *pool, const struct pen_render_task *task,
                    struct pen_render_stats *stats, struct pen_status *st)
{
    const struct pen_settings *settings = task->settings;
    int total = pen_tile_count(settings->width, settings->height, settings->tile);
    int first = task->first_tile;
    int count = task->tile_count < 0 ? total - first : task->tile_count;
    *stats = (struct pen_render_stats){0};
    if (first < 0 || first > total || count > total - first)
        return pen_fail(st, PEN_INTERNAL, "tiles %d to %d of an image with %d", first,
                        first + count - 1, total);
    struct run run = {
        .task = task,
        .input = kernel_input(task->scene, task->view, settings),
        .last_tile = first + count,
        .threads = threads_for(pool, settings->threads, count),
        .done_lock = PTHREAD_MUTEX_INITIALIZER,
    };
    atomic_init(&run.next_tile, first);
    run.kernel = pen_kernel_select(run.input.effects, pen_cpu_isa());
    bool ok = run_tiles(pool, &run, stats, st);
    free_parts(&run);
    if (!ok)
        free(run.tile_ms);
    pthread_mutex_destroy(&run.done_lock);
    return ok;
}

bool pen_render_pixel(const struct pen_scene *scene, int view, const struct pen_settings *settings,
                      int x, int y, double rgb[3], struct pen_ray_counts *rays,
                      struct pen_status *st)
{
    struct pen_kernel_input input = kernel_input(scene, view, settings);
    struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(&input);
    if (!scratch)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the paths of a pixel");
    fenv_t caller;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    *rays = (struct pen_ray_counts){0};
    pen_kernel_select(input.effects, pen_cpu_isa())->pixel(&input, scratch, x, y, rgb, rays);
    fesetenv(&caller);
    pen_kernel_scratch_free(scratch);
    return true;
}
