/* SPDX-License-Identifier: MIT */
/* Renders a task. Threads take blocks of tiles from a queue and write their pixels into the image.
 * A pixel is a pure function of its position, so the thread that renders it affects only the time.
 * Threads share nothing else, except that calls of tile_done and of rows_done are serialised. */
#include "render/render.h"

#include <fenv.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/thread_pool.h"
#include "render/internal/counter.h"
#include "render/internal/kernel_input.h"
#include "render/internal/refine.h"
#include "render/internal/row_order.h"
#include "render/internal/tile_queue.h"

/* The work of one thread. Only that thread writes it; others read it when all are done. */
struct thread_work {
    const struct pen_kernel_input *input; /* the run's, or the counter's */
    struct pen_counter *counter;          /* NULL unless tests are counted */
    struct pen_kernel_scratch *scratch;
    struct pen_ray_counts rays;
    int64_t begun_ns, done_ns, left_ns, cpu_ns; /* done_ns: its last block; left_ns: its return */
    int tiles;
};

struct run {
    const struct pen_render_task *task;
    struct pen_kernel_input input;
    struct pen_kernel kernel;
    int end_tile; /* the first tile after the task's */
    struct pen_tile_queue *queue;
    struct pen_row_order *rows; /* NULL if the task does not request it */
    struct thread_work *work;   /* by thread */
    int threads;
    int64_t called_ns;         /* when the threads were called */
    double *tile_ms;           /* by tile, from first_tile on; NULL if not kept */
    pthread_mutex_t done_lock; /* one call of tile_done at a time */
};

static bool cancelled(const struct pen_render_task *task)
{
    return task->cancel && atomic_load_explicit(task->cancel, memory_order_relaxed);
}

struct pen_kernel_input pen_kernel_input_of(const struct pen_scene *scene, int view,
                                            const struct pen_settings *settings)
{
    fenv_t caller;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    struct pen_kernel_input input = {
        .scene = scene,
        .view = &scene->views[view],
        .settings = settings,
        .pinhole = pen_scene_pinhole(scene, view, settings->width, settings->height),
        .effects = pen_scene_effects(scene, view, settings),
        .trace = pen_trace_ops_get(pen_cpu_isa()),
    };
    input.lens = pen_scene_lens(scene, view, &input.pinhole);
    fesetenv(&caller);
    return input;
}

void pen_render_block(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                      struct pen_kernel_scratch *scratch, struct pen_rect block, double (*rgb)[3],
                      struct pen_ray_counts *rays)
{
    if (input->trace->nearest_packet) {
        kernel->block(input, scratch, block, rgb, rays);
        return;
    }
    for (int i = 0; i < block.width * block.height; i++)
        kernel->pixel(input, scratch, block.x + i % block.width, block.y + i / block.width, rgb[i],
                      rays);
}

/* As pen_render_block, for the film; calls pixel_begins for each pixel first. */
static void render_block(const struct run *run, int thread, struct pen_rect block)
{
    const struct pen_render_task *task = run->task;
    struct thread_work *work = &run->work[thread];
    double rgb[PEN_BLOCK_SIDE * PEN_BLOCK_SIDE][3];
    const bool together = work->input->trace->nearest_packet && !task->pixel_by_pixel;
    const int pixels = block.width * block.height;
    for (int i = 0; i < pixels; i++) {
        const int x = block.x + i % block.width, y = block.y + i / block.width;
        if (task->pixel_begins)
            task->pixel_begins(task->pixel_user, thread, x, y);
        if (!together)
            run->kernel.pixel(work->input, work->scratch, x, y, rgb[i], &work->rays);
    }
    if (together)
        run->kernel.block(work->input, work->scratch, block, rgb, &work->rays);
    for (int i = 0; i < pixels; i++) {
        const int x = block.x + i % block.width, y = block.y + i / block.width;
        float *out = task->rgb + 3 * ((size_t)y * (size_t)task->settings->width + (size_t)x);
        for (int c = 0; c < 3; c++)
            out[c] = (float)rgb[i][c];
    }
}

static void report_tile(struct run *run, struct pen_rect rect)
{
    if (!run->task->tile_done)
        return;
    pthread_mutex_lock(&run->done_lock);
    run->task->tile_done(run->task->user, rect);
    pthread_mutex_unlock(&run->done_lock);
}

static void finish_tile(struct run *run, int tile, int64_t spent_ns)
{
    const struct pen_settings *settings = run->task->settings;
    if (run->tile_ms)
        run->tile_ms[tile - run->task->first_tile] = (double)spent_ns * 1e-6;
    report_tile(run, pen_tile_rect(settings->width, settings->height, settings->tile, tile));
}

static void render_blocks(void *user, int index)
{
    struct run *run = user;
    struct thread_work *work = &run->work[index];
    struct pen_tile_block block;
    int64_t cpu = pen_clock_thread_ns(), tile_ns;
    work->begun_ns = work->done_ns = pen_clock_ns();
    while (!cancelled(run->task) && pen_tile_queue_take(run->queue, index, &block)) {
        int64_t begun = pen_clock_ns();
        if (run->task->adaptive)
            pen_refine_block(run->task, &run->kernel, work->input, work->scratch, block.rect, index,
                             &work->rays);
        else
            render_block(run, index, block.rect);
        work->done_ns = pen_clock_ns();
        if (pen_tile_queue_done(&block, work->done_ns - begun, &tile_ns)) {
            work->tiles++;
            finish_tile(run, block.tile, tile_ns);
        }
        if (run->rows)
            pen_row_order_block_done(run->rows, block.rect);
    }
    work->cpu_ns = pen_clock_thread_ns() - cpu;
    work->left_ns = pen_clock_ns();
}

/* Sums the threads' work. Returns the number of tiles done. */
static int sum_work(const struct run *run, struct pen_render_stats *stats)
{
    int64_t begun = INT64_MAX, done = 0, cpu = 0, present = 0;
    int tiles = 0;
    for (int i = 0; i < run->threads; i++) {
        const struct thread_work *work = &run->work[i];
        pen_ray_counts_add(&stats->rays, &work->rays);
        begun = work->begun_ns < begun ? work->begun_ns : begun;
        done = work->done_ns > done ? work->done_ns : done;
        cpu += work->cpu_ns;
        present += work->left_ns - run->called_ns;
        tiles += work->tiles;
        if (work->counter)
            pen_counter_add(work->counter, &stats->tests);
    }
    stats->tests_counted = run->task->count_tests;
    stats->done_ns = done;
    stats->render_ms = (double)(done - begun) * 1e-6;
    stats->cpu_ms = (double)cpu * 1e-6;
    stats->thread_ms = (double)present * 1e-6;
    stats->threads = run->threads;
    stats->kernel = run->kernel.name;
    stats->effects = run->input.effects;
    return tiles;
}

static bool make_queue(struct run *run, struct pen_status *st)
{
    const struct pen_render_task *task = run->task;
    run->queue = pen_tile_queue_new(task, run->end_tile, run->threads);
    if (task->rows_done)
        run->rows = pen_row_order_new(task->settings, task->rows_done, task->rows_user);
    return (run->queue && (run->rows || !task->rows_done)) ||
           pen_fail(st, PEN_NO_MEMORY, "out of memory for the order of tiles");
}

static bool make_work(struct run *run, struct pen_status *st)
{
    run->work = calloc((size_t)run->threads, sizeof *run->work);
    if (!run->work)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for %d render threads", run->threads);
    for (int i = 0; i < run->threads; i++) {
        struct thread_work *work = &run->work[i];
        work->input = &run->input;
        if (run->task->count_tests) {
            work->counter = pen_counter_new(&run->input);
            work->input = work->counter ? pen_counter_input(work->counter) : NULL;
        }
        work->scratch = work->input ? pen_kernel_scratch_new(work->input) : NULL;
        if (!work->scratch)
            return pen_fail(st, PEN_NO_MEMORY,
                            "out of memory for the light paths of a render thread");
    }
    return true;
}

static void free_work(struct run *run)
{
    for (int i = 0; run->work && i < run->threads; i++) {
        pen_kernel_scratch_free(run->work[i].scratch);
        pen_counter_free(run->work[i].counter);
    }
    free(run->work);
    pen_tile_queue_free(run->queue);
    pen_row_order_free(run->rows);
}

static bool run_tiles(struct pen_thread_pool *pool, struct run *run, struct pen_render_stats *stats,
                      struct pen_status *st)
{
    int tiles = run->end_tile - run->task->first_tile;
    if (run->task->keep_tile_ms) {
        run->tile_ms = calloc((size_t)tiles + 1, sizeof *run->tile_ms);
        if (!run->tile_ms)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory for the times of %d tiles", tiles);
    }
    if (!make_queue(run, st) || !make_work(run, st))
        return false;
    run->called_ns = pen_clock_ns();
    stats->float_resets = pen_thread_pool_run(pool, run->threads, render_blocks, run);
    stats->tile_count = (uint32_t)sum_work(run, stats);
    tiles = pen_tile_queue_end(run->queue) - run->task->first_tile;
    if (stats->tile_count < (uint32_t)tiles)
        return pen_fail(st, PEN_CANCELLED, "cancelled after %u of %d tiles", stats->tile_count,
                        tiles);
    stats->tile_ms = run->tile_ms;
    return true;
}

/* In the settings, 0 means all threads of the pool. */
int pen_render_threads(const struct pen_thread_pool *pool, const struct pen_settings *settings)
{
    const int asked = settings->threads, all = pen_thread_pool_size(pool);
    return asked > 0 && asked < all ? asked : all;
}

/* The number of threads for a task: no more than there are blocks of pixels. */
static int threads_for(const struct pen_thread_pool *pool, const struct pen_settings *settings,
                       int first_tile, int end_tile)
{
    const int threads =
        pen_tile_queue_threads(settings, first_tile, end_tile, pen_render_threads(pool, settings));
    return threads > 1 ? threads : 1;
}

bool pen_render_run(struct pen_thread_pool *pool, const struct pen_render_task *task,
                    struct pen_render_stats *stats, struct pen_status *st)
{
    const struct pen_settings *settings = task->settings;
    if (pen_settings_adaptive(settings) && !task->adaptive)
        return pen_render_to_target(pool, task, stats, st);
    int total = pen_tile_count(settings->width, settings->height, settings->tile);
    int first = task->first_tile;
    int count = task->tile_count < 0 ? total - first : task->tile_count;
    *stats = (struct pen_render_stats){0};
    if (first < 0 || first > total || count > total - first)
        return pen_fail(st, PEN_INTERNAL, "tiles %d to %d of an image with %d", first,
                        first + count - 1, total);
    struct run run = {
        .task = task,
        .input = pen_kernel_input_of(task->scene, task->view,
                                     task->adaptive ? &task->adaptive->sampling : settings),
        .end_tile = first + count,
        .threads = threads_for(pool, settings, first, first + count),
        .done_lock = PTHREAD_MUTEX_INITIALIZER,
    };
    const int64_t whole = (int64_t)settings->width * settings->height,
                  tiles = (int64_t)count * settings->tile * settings->tile;
    run.kernel = pen_kernel_choose(&run.input, tiles < whole ? tiles : whole, pen_cpu_isa());
    bool ok = run_tiles(pool, &run, stats, st);
    free_work(&run);
    if (!ok)
        free(run.tile_ms);
    pthread_mutex_destroy(&run.done_lock);
    return ok;
}

/* Renders a pixel. If `refined` is above 0, with this number of samples, in the rounds that lead to
 * them from the pilot's number, because the order of the sum affects its last bits. */
static bool render_pixel(const struct pen_kernel_input *input, int x, int y, uint32_t pilot,
                         uint32_t refined, const struct pen_beams *beams, double rgb[3],
                         struct pen_ray_counts *rays, struct pen_status *st)
{
    struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(input);
    const struct pen_kernel *kernel = pen_kernel_select(input->effects, pen_cpu_isa());
    if (!scratch)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the light paths of a pixel");
    fenv_t caller;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    *rays = (struct pen_ray_counts){0};
    if (refined == 0) {
        kernel->pixel(input, scratch, x, y, rgb, rays);
    } else {
        struct pen_pixel_sums sums = {.samples = 0};
        for (uint32_t end = pilot; end <= refined; end *= 2) {
            const struct pen_sample_range range = {
                .x = x, .y = y, .first = sums.samples, .end = end, .sums = &sums, .beams = beams};
            pen_trace_samples(kernel, input, scratch, &range, 1, rays);
        }
        pen_pixel_mean(&sums, rgb);
    }
    fesetenv(&caller);
    pen_kernel_scratch_free(scratch);
    return true;
}

bool pen_render_pixel(const struct pen_scene *scene, int view, const struct pen_settings *settings,
                      int x, int y, double rgb[3], struct pen_ray_counts *rays,
                      struct pen_status *st)
{
    const struct pen_kernel_input input = pen_kernel_input_of(scene, view, settings);
    return render_pixel(&input, x, y, 0, 0, NULL, rgb, rays, st);
}

bool pen_render_refined_pixel(const struct pen_scene *scene, int view,
                              const struct pen_adaptive *adaptive, int x, int y, double rgb[3],
                              struct pen_ray_counts *rays, struct pen_status *st)
{
    const struct pen_kernel_input input = pen_kernel_input_of(scene, view, &adaptive->sampling);
    const size_t at = (size_t)y * (size_t)adaptive->settings->width + (size_t)x;
    const uint32_t pilot = pen_settings_pilot(adaptive->settings);
    const uint32_t first = adaptive->sums[at].looks == PEN_LOOKS ? 2 * pilot : pilot;
    return render_pixel(&input, x, y, first, adaptive->sums[at].samples,
                        pen_adaptive_beams(adaptive, at), rgb, rays, st);
}

bool pen_dropped_warning(const struct pen_ray_counts *rays, char *text, size_t bytes)
{
    if (rays->dropped_samples == 0)
        return false;
    snprintf(text, bytes,
             "%llu of %llu pixel samples are brighter than a picture can hold (3.4e38), or no "
             "number; they are left out of their pixels, and a pixel with no other sample is "
             "black: lower intensities, emission or ambient light, and give a light that is near a "
             "surface an attenuation with kc > 0",
             (unsigned long long)rays->dropped_samples, (unsigned long long)rays->primary);
    return true;
}
