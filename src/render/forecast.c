/* SPDX-License-Identifier: MIT */
/* The image is cut into cells of equal size, row by row, and one pixel of each is drawn by a hash
 * of the cell's number. A cell's pixels are alike more often than not, so the sum over cells is
 * known better than from as many independent pixels: its variance is estimated from the differences
 * of neighbouring cells (the successive-difference estimator of stratified sampling; Wolter,
 * "Introduction to Variance Estimation", 2007, 8.2). */
#include "render/forecast.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/clock.h"
#include "math/sample.h"
#include "render/internal/forecast_adaptive.h"
#include "render/internal/kernel_input.h"
#include "render/render.h"
#include "shade/first_hit.h"

enum { BLOCKS = 96, KINDS = 4 };
_Static_assert(PEN_FORECAST_CELLS + BLOCKS * PEN_BLOCK_SIDE * PEN_BLOCK_SIDE ==
                   PEN_FORECAST_QUICK_PIXELS,
               "all pixels of a quick forecast");

struct forecast {
    const struct pen_forecast_task *task;
    const struct pen_settings *settings;
    struct pen_kernel_input input;
    const struct pen_kernel *kernel;
    struct pen_kernel_scratch **scratch; /* by thread */
    int threads, columns, rows;          /* of cells */
    double (*rays)[KINDS];               /* by cell */
    double block_ns[BLOCKS], block_rays[BLOCKS];
    atomic_bool *seen; /* as in pen_forecast; relaxed */
    atomic_int next;
};

/* A number from lo to hi - 1. */
static int drawn(uint64_t hash, int lo, int hi)
{
    return lo + (int)((hash >> 33) % (uint64_t)(hi > lo ? hi - lo : 1));
}

/* Begin of part i of n of a length. */
static int part_of(int length, int i, int n)
{
    return (int)((int64_t)length * i / n);
}

static bool is_cancelled(const struct forecast *f)
{
    return f->task->cancel && atomic_load_explicit(f->task->cancel, memory_order_relaxed);
}

static void begin_pixel(const struct forecast *f, int thread, int x, int y)
{
    if (f->task->pixel_begins)
        f->task->pixel_begins(f->task->pixel_user, thread, x, y);
}

static void note_seen(const struct forecast *f, int x, int y)
{
    struct pen_first_hit hit;
    if (pen_first_hit(&f->input, x, y, &hit))
        atomic_store_explicit(&f->seen[hit.prim], true, memory_order_relaxed);
}

static void count_cell(struct forecast *f, int thread, int cell)
{
    const struct pen_settings *s = f->settings;
    const int column = cell % f->columns, row = cell / f->columns;
    const uint64_t hash = pen_mix64((uint64_t)cell);
    const int x = drawn(hash, part_of(s->width, column, f->columns),
                        part_of(s->width, column + 1, f->columns));
    const int y = drawn(pen_mix64(hash), part_of(s->height, row, f->rows),
                        part_of(s->height, row + 1, f->rows));
    struct pen_ray_counts rays = {.primary = 0};
    double rgb[3];
    begin_pixel(f, thread, x, y);
    f->kernel->pixel(&f->input, f->scratch[thread], x, y, rgb, &rays);
    note_seen(f, x, y);
    f->rays[cell][0] = (double)rays.primary;
    f->rays[cell][1] = (double)rays.shadow;
    f->rays[cell][2] = (double)rays.reflection;
    f->rays[cell][3] = (double)rays.transmission;
}

static void count_cells(void *user, int thread)
{
    struct forecast *f = user;
    const int cells = f->columns * f->rows;
    int cell;
    while ((cell = atomic_fetch_add_explicit(&f->next, 1, memory_order_relaxed)) < cells &&
           !is_cancelled(f))
        count_cell(f, thread, cell);
}

/* Times a block somewhere in part n of the image's blocks. */
static void time_block(struct forecast *f, int thread, int n)
{
    const struct pen_settings *s = f->settings;
    const int all = pen_tile_count(s->width, s->height, PEN_BLOCK_SIDE);
    const int at =
        drawn(pen_mix64((uint64_t)n + 77), part_of(all, n, BLOCKS), part_of(all, n + 1, BLOCKS));
    const struct pen_rect rect = pen_tile_rect(s->width, s->height, PEN_BLOCK_SIDE, at);
    double rgb[PEN_BLOCK_SIDE * PEN_BLOCK_SIDE][3];
    struct pen_ray_counts rays = {.primary = 0};
    begin_pixel(f, thread, rect.x, rect.y);
    const int64_t begun = pen_clock_thread_ns();
    pen_render_block(f->kernel, &f->input, f->scratch[thread], rect, rgb, &rays);
    f->block_ns[n] = (double)(pen_clock_thread_ns() - begun);
    f->block_rays[n] = (double)(rays.primary + rays.shadow + rays.reflection + rays.transmission);
}

static void time_blocks(void *user, int thread)
{
    struct forecast *f = user;
    int n;
    while ((n = atomic_fetch_add_explicit(&f->next, 1, memory_order_relaxed)) < BLOCKS &&
           !is_cancelled(f))
        time_block(f, thread, n);
}

/* The sum over the image, from the sum over the cells: `kind` KINDS is all of them. */
static struct pen_estimate estimate(const struct forecast *f, int kind)
{
    const int cells = f->columns * f->rows;
    const double pixels = (double)f->settings->width * f->settings->height;
    double sum = 0, squares = 0, before = 0;
    for (int i = 0; i < cells; i++) {
        const double *r = f->rays[i];
        const double v = kind < KINDS ? r[kind] : r[0] + r[1] + r[2] + r[3];
        sum += v;
        if (i > 0)
            squares += (v - before) * (v - before);
        before = v;
    }
    /* A part of the pixels that is not small is known, and adds no error. */
    const double unknown = 1 - cells / pixels;
    const double variance = cells > 1 ? squares / (2.0 * (cells - 1)) / cells * unknown : 0;
    const double mean = sum / cells, off = 1.96 * sqrt(variance > 0 ? variance : 0);
    return (struct pen_estimate){mean * pixels, (mean - off > 0 ? mean - off : 0) * pixels,
                                 (mean + off) * pixels};
}

/* The time of a ray is that of all blocks together; the spread of that ratio gives its interval. */
static struct pen_estimate estimate_time(const struct forecast *f, const struct pen_estimate *total)
{
    double ns = 0, rays = 0, squares = 0;
    for (int i = 0; i < BLOCKS; i++) {
        ns += f->block_ns[i];
        rays += f->block_rays[i];
    }
    const double each = rays > 0 ? ns / rays : 0;
    for (int i = 0; i < BLOCKS; i++) {
        const double off = f->block_ns[i] - each * f->block_rays[i];
        squares += off * off;
    }
    const double relative = ns > 0 ? 1.96 * sqrt(squares) / ns : 0;
    const double share =
        total->expected > 0 ? (total->high - total->expected) / total->expected : 0;
    const double ms = total->expected * each * 1e-6 / f->threads,
                 off = sqrt(relative * relative + share * share);
    return (struct pen_estimate){ms, off < 1 ? ms * (1 - off) : 0, ms * (1 + off)};
}

/* As many cells as asked for, nearly square, but no more than pixels. */
static void cut(struct forecast *f)
{
    const double width = f->settings->width, height = f->settings->height;
    const bool least = f->task->quick || width * height * 0.01 < PEN_FORECAST_CELLS;
    const double wanted = least ? PEN_FORECAST_CELLS : width * height * 0.01;
    const double side = wanted < width * height ? sqrt(width * height / wanted) : 1;
    f->columns = (int)ceil(width / side);
    f->rows = (int)ceil(height / side);
    if (f->columns > f->settings->width)
        f->columns = f->settings->width;
    if (f->rows > f->settings->height)
        f->rows = f->settings->height;
}

static bool make_scratch(struct forecast *f)
{
    f->scratch = calloc((size_t)f->threads, sizeof *f->scratch);
    f->rays = calloc((size_t)f->columns * (size_t)f->rows, sizeof *f->rays);
    f->seen = calloc(f->input.scene->prims.count + 1, sizeof *f->seen);
    for (int i = 0; f->scratch && i < f->threads; i++)
        if (!(f->scratch[i] = pen_kernel_scratch_new(&f->input)))
            return false;
    return f->scratch && f->rays && f->seen;
}

static void release(struct forecast *f)
{
    for (int i = 0; f->scratch && i < f->threads; i++)
        pen_kernel_scratch_free(f->scratch[i]);
    free(f->scratch);
    free(f->rays);
    free(f->seen);
}

static void run(struct pen_thread_pool *pool, struct forecast *f, struct pen_forecast *out)
{
    const double film = 3.0 * sizeof(float) * f->settings->width * f->settings->height;
    pen_thread_pool_run(pool, f->threads, count_cells, f);
    atomic_store(&f->next, 0);
    pen_thread_pool_run(pool, f->threads, time_blocks, f);
    out->primary = estimate(f, 0);
    out->shadow = estimate(f, 1);
    out->reflection = estimate(f, 2);
    out->transmission = estimate(f, 3);
    out->total = estimate(f, KINDS);
    out->time_ms = estimate_time(f, &out->total);
    out->memory_bytes = film + (double)pen_arena_used(f->input.scene->arena) +
                        (double)f->threads * (double)f->kernel->block_bytes;
    out->pixels = f->columns * f->rows;
    out->kernel = f->kernel->name;
    out->effects = f->input.effects;
    out->seen = f->seen;
    f->seen = NULL;
}

static double both_off(double a, double b)
{
    return sqrt(a * a + b * b);
}

/* The product of two estimates that are off independently. */
static struct pen_estimate product(struct pen_estimate a, struct pen_estimate b)
{
    const double expected = a.expected * b.expected;
    if (!(expected > 0))
        return (struct pen_estimate){0, 0, a.high * b.high};
    const double down = both_off(1 - a.low / a.expected, 1 - b.low / b.expected);
    const double up = both_off(a.high / a.expected - 1, b.high / b.expected - 1);
    return (struct pen_estimate){expected, down < 1 ? expected * (1 - down) : 0,
                                 expected * (1 + up)};
}

/* Extends a forecast of the pilot to all rounds. */
static bool add_rounds(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       struct pen_forecast *out, struct pen_status *st)
{
    struct pen_estimate growth, ray = out->time_ms;
    double ray_ms;
    if (!pen_settings_adaptive(task->settings))
        return true;
    if (!pen_forecast_growth(pool, task, &growth, &ray_ms, st))
        return false;
    struct pen_estimate *const all[] = {&out->primary, &out->shadow, &out->reflection,
                                        &out->transmission, &out->total};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        *all[i] = product(*all[i], growth);
    const double scale = ray.expected > 0 ? ray_ms / ray.expected : 0;
    ray = (struct pen_estimate){ray_ms, ray.low * scale, ray.high * scale};
    out->time_ms = product(out->total, ray);
    const double pixels = (double)task->settings->width * task->settings->height;
    out->memory_bytes += pixels * (double)(sizeof(struct pen_pixel_sums) +
                                           sizeof(struct pen_pixel_estimate) + sizeof(float) + 1);
    return true;
}

bool pen_forecast_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       struct pen_forecast *out, struct pen_status *st)
{
    const int64_t begun = pen_clock_ns();
    const struct pen_settings sampling = pen_settings_sampling(task->settings);
    struct forecast f = {.task = task,
                         .settings = &sampling,
                         .input = pen_kernel_input_of(task->scene, task->view, &sampling),
                         .threads = pen_render_threads(pool, task->settings)};
    f.kernel = pen_kernel_select(f.input.effects, pen_cpu_isa());
    cut(&f);
    const bool ok = make_scratch(&f);
    if (ok)
        run(pool, &f, out);
    release(&f);
    if (!ok)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the light paths of a forecast");
    if (is_cancelled(&f) ? pen_fail(st, PEN_CANCELLED, "the forecast was cancelled")
                         : add_rounds(pool, task, out, st)) {
        out->spent_ms = (double)(pen_clock_ns() - begun) * 1e-6;
        return true;
    }
    pen_forecast_release(out);
    return false;
}

void pen_forecast_release(struct pen_forecast *forecast)
{
    free(forecast->seen);
    forecast->seen = NULL;
}
