/* SPDX-License-Identifier: MIT */
/* The image is divided into cells of equal size, row by row. A hash of the cell's number draws one
 * pixel of each. A cell's pixels are usually alike, so the sum over cells has a smaller error than
 * that of as many independent pixels. Its variance is estimated from the differences of
 * neighbouring cells (the successive-difference estimator of stratified sampling; Wolter,
 * "Introduction to Variance Estimation", 2007, 8.2).
 *
 * With a deadline, cells and blocks are taken in scattered order, so that those that are done by
 * then are spread over the whole image. */
#include "render/forecast.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/clock.h"
#include "math/fn.h"
#include "math/sample.h"
#include "render/internal/forecast_adaptive.h"
#include "render/internal/forecast_samples.h"
#include "render/internal/kernel_input.h"
#include "render/render.h"
#include "shade/first_hit.h"

enum { BLOCKS = 96, KINDS = 4 };

/* The most rays of a pre-render with a deadline: some ten seconds of two threads. A pixel takes at
 * most its share of them, as estimated from the numbers of samples. */
static const double RAYS_MAX = 4e7;

/* The variation of the processor time of the same work while other programs share caches, memory
 * and clock. In 64 renders of eight scenes at two sizes, beside programs that used 0 to 3/4 of the
 * processors, the time was 0.78 to 1.14 times the expected one. */
static const double MACHINE_OFF = 0.15;

/* Steps of scattered orders: for blocks, a number that has no common divisor with theirs; for
 * cells, a part of their number. */
enum { BLOCK_STEP = 59 };
static const double CELL_STEP = 0.618;

_Static_assert(PEN_FORECAST_CELLS + BLOCKS * PEN_BLOCK_SIDE * PEN_BLOCK_SIDE ==
                   PEN_FORECAST_QUICK_PIXELS,
               "all pixels of a quick forecast");

struct forecast {
    const struct pen_forecast_task *task;
    const struct pen_settings *settings;
    struct pen_kernel_input input;
    struct pen_kernel kernel;
    struct pen_kernel_scratch **scratch; /* by thread */
    int threads, columns, rows;          /* of cells */
    int cell_step, block_step;           /* distance to the next cell or block in order */
    int side;                            /* of a block, in pixels */
    int64_t until_ns; /* time after which no more cells or blocks are begun; 0: none */
    struct pen_forecast_samples samples;
    double (*rays)[KINDS];                       /* by cell; 0 for a cell that is not done */
    double block_ns[BLOCKS], block_rays[BLOCKS]; /* the same */
    atomic_llong thread_ns, cpu_ns;              /* of all threads; relaxed */
    atomic_bool *seen;                           /* as in pen_forecast; relaxed */
    atomic_int next;
};

/* A number from lo to hi - 1. */
static int drawn(uint64_t hash, int lo, int hi)
{
    return lo + (int)((hash >> 33) % (uint64_t)(hi > lo ? hi - lo : 1));
}

/* The begin of part i of n of a length. */
static int part_of(int length, int i, int n)
{
    return (int)((int64_t)length * i / n);
}

static bool is_cancelled(const struct forecast *f)
{
    return f->task->cancel && atomic_load_explicit(f->task->cancel, memory_order_relaxed);
}

/* Whether to begin no more cells or blocks; `begun` is the number begun. */
static bool is_over(const struct forecast *f, int begun)
{
    return is_cancelled(f) || (begun > 0 && f->until_ns != 0 && pen_clock_ns() >= f->until_ns);
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
    f->kernel.pixel(&f->input, f->scratch[thread], x, y, rgb, &rays);
    note_seen(f, x, y);
    f->rays[cell][0] = (double)rays.primary;
    f->rays[cell][1] = (double)rays.shadow;
    f->rays[cell][2] = (double)rays.reflection;
    f->rays[cell][3] = (double)rays.transmission;
}

/* A thread's time, and the processor time in it. */
struct watch {
    int64_t ns, cpu_ns;
};

static struct watch watch_begin(void)
{
    return (struct watch){pen_clock_ns(), pen_clock_thread_ns()};
}

static void watch_end(struct forecast *f, const struct watch *begun)
{
    const struct watch now = watch_begin();
    atomic_fetch_add_explicit(&f->thread_ns, now.ns - begun->ns, memory_order_relaxed);
    atomic_fetch_add_explicit(&f->cpu_ns, now.cpu_ns - begun->cpu_ns, memory_order_relaxed);
}

static void count_cells(void *user, int thread)
{
    struct forecast *f = user;
    const struct watch watch = watch_begin();
    const int cells = f->columns * f->rows;
    int i;
    while ((i = atomic_fetch_add_explicit(&f->next, 1, memory_order_relaxed)) < cells &&
           !is_over(f, i))
        count_cell(f, thread, (int)((int64_t)i * f->cell_step % cells));
    watch_end(f, &watch);
}

/* Times a block at a random place in part n of the image's blocks. */
static void time_block(struct forecast *f, int thread, int n)
{
    const struct pen_settings *s = f->settings;
    const int all = pen_tile_count(s->width, s->height, PEN_BLOCK_SIDE);
    const int at =
        drawn(pen_mix64((uint64_t)n + 77), part_of(all, n, BLOCKS), part_of(all, n + 1, BLOCKS));
    struct pen_rect rect = pen_tile_rect(s->width, s->height, PEN_BLOCK_SIDE, at);
    rect.width = rect.width < f->side ? rect.width : f->side;
    rect.height = rect.height < f->side ? rect.height : f->side;
    double rgb[PEN_BLOCK_SIDE * PEN_BLOCK_SIDE][3];
    struct pen_ray_counts rays = {.primary = 0};
    begin_pixel(f, thread, rect.x, rect.y);
    const int64_t begun = pen_clock_thread_ns();
    pen_render_block(&f->kernel, &f->input, f->scratch[thread], rect, rgb, &rays);
    f->block_ns[n] = (double)(pen_clock_thread_ns() - begun);
    f->block_rays[n] = (double)(rays.primary + rays.shadow + rays.reflection + rays.transmission);
}

static void time_blocks(void *user, int thread)
{
    struct forecast *f = user;
    const struct watch watch = watch_begin();
    int i;
    while ((i = atomic_fetch_add_explicit(&f->next, 1, memory_order_relaxed)) < BLOCKS &&
           !is_over(f, i))
        time_block(f, thread, i * f->block_step % BLOCKS);
    watch_end(f, &watch);
}

/* The number of rays of a kind that one ray of the pre-render represents; `kind` KINDS is all of
 * them. With fewer points on lights or rays of cones, all rays that follow from these may be left
 * out. */
static double times(const struct forecast *f, int kind)
{
    const double blur = f->samples.blur, by_kind[] = {1, f->samples.light * blur, blur, blur};
    return f->samples.camera * by_kind[kind];
}

/* The factor by which that may be too many. */
static double excess(const struct forecast *f, int kind)
{
    return (kind < KINDS ? times(f, kind) : times(f, 1)) / f->samples.camera;
}

static int done_cells(const struct forecast *f)
{
    int done = 0;
    for (int i = 0; i < f->columns * f->rows; i++)
        done += f->rays[i][0] > 0;
    return done;
}

/* The most rays of a kind that the image may have if no finished pixel has one. */
static double unseen(const struct forecast *f, int kind, int done)
{
    const double pixels = (double)f->settings->width * f->settings->height,
                 share = 1 - pen_exp(pen_ln(0.025) / done);
    return done < pixels
               ? share * pixels * times(f, kind) *
                     pen_forecast_path_rays(f->task->scene, f->task->view, f->settings, kind)
               : 0;
}

/* The sum over the image, from the sum over the finished cells. */
static struct pen_estimate estimate(const struct forecast *f, int kind)
{
    const int cells = f->columns * f->rows, done = done_cells(f);
    const double pixels = (double)f->settings->width * f->settings->height;
    double sum = 0, squares = 0, before = 0;
    for (int i = 0, seen = 0; i < cells; i++) {
        const double *r = f->rays[i];
        double v = 0;
        if (r[0] == 0)
            continue;
        for (int k = 0; k < KINDS; k++)
            v += k == kind || kind == KINDS ? r[k] * times(f, k) : 0;
        sum += v;
        if (seen++ > 0)
            squares += (v - before) * (v - before);
        before = v;
    }
    /* If the finished pixels are a large part of all, that part is known and adds no error. */
    const bool known = f->samples.camera * f->samples.light * f->samples.blur == 1;
    const double unknown = known ? 1 - done / pixels : 1, mean = sum / done;
    const double alone = cells > 1 ? mean * mean : 0; /* one cell of several gives no variance */
    const double variance = done > 1 ? squares / (2.0 * (done - 1)) / done * unknown : alone;
    const double off = 1.96 * sqrt(variance > 0 ? variance : 0);
    if (sum == 0 && kind < KINDS)
        return (struct pen_estimate){0, 0, unseen(f, kind, done)};
    const double low = mean - off > 0 ? mean - off : 0;
    return (struct pen_estimate){mean * pixels, low * pixels / excess(f, kind),
                                 (mean + off) * pixels};
}

/* The processor time of a ray: the ratio over all blocks together. The spread of that ratio gives
 * its interval. */
static struct pen_estimate estimate_time(const struct forecast *f, const struct pen_estimate *total)
{
    double ns = 0, rays = 0, squares = 0, done = 0;
    for (int i = 0; i < BLOCKS; i++) {
        ns += f->block_ns[i];
        rays += f->block_rays[i];
        done += f->block_rays[i] > 0;
    }
    const double each = rays > 0 ? ns / rays : 0;
    for (int i = 0; i < BLOCKS; i++) {
        const double off = f->block_ns[i] - each * f->block_rays[i];
        squares += off * off;
    }
    if (done < BLOCKS)
        squares = done > 1 ? squares * done / (done - 1) : ns * ns;
    const double relative = ns > 0 ? 1.96 * sqrt(squares) / ns : 0;
    const double share =
        total->expected > 0 ? (total->high - total->expected) / total->expected : 0;
    const double ms = total->expected * each * 1e-6;
    const double off = sqrt(relative * relative + share * share + MACHINE_OFF * MACHINE_OFF),
                 low = off < 1 ? ms * (1 - off) : 0;
    return (struct pen_estimate){ms, low / excess(f, KINDS), ms * (1 + off)};
}

/* Divides the image into the requested number of cells, nearly square, but at most one per pixel.
 */
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

static int common_divisor(int a, int b)
{
    return b == 0 ? a : common_divisor(b, a % b);
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

static double least(double a, double b)
{
    return a < b ? a : b;
}

/* Sets scattered orders of cells and blocks, and fewer samples for pixels with very many. */
static void bound(struct forecast *f, struct pen_settings *sampling)
{
    const double pixels = (double)sampling->width * sampling->height,
                 block = PEN_BLOCK_SIDE * PEN_BLOCK_SIDE;
    const double taken = least(pixels, PEN_FORECAST_CELLS) + BLOCKS * least(pixels, block);
    const int cells = f->columns * f->rows;
    f->samples =
        pen_forecast_samples_cut(f->task->scene, f->task->view, RAYS_MAX / taken, sampling);
    f->block_step = BLOCK_STEP;
    f->cell_step = (int)(CELL_STEP * cells) + 1;
    while (common_divisor(f->cell_step, cells) > 1)
        f->cell_step++;
}

/* The end of a part of the remaining time; 0 without a deadline. */
static int64_t part_of_time(const struct forecast *f, double part)
{
    const int64_t deadline_ns = f->task->deadline_ns;
    return deadline_ns == 0 ? 0 : pen_clock_between(pen_clock_ns(), deadline_ns, part);
}

/* Makes blocks smaller if a thread would not finish two of them in time. The time of a pixel is
 * estimated from the cells, which took `ns` of all threads. */
static void choose_side(struct forecast *f, int64_t ns)
{
    const double pixel_ns = (double)ns * f->threads / done_cells(f),
                 left_ns = (double)(f->until_ns - pen_clock_ns());
    while (f->until_ns != 0 && f->side > 1 && 2 * f->side * f->side * pixel_ns > left_ns)
        f->side /= 2;
}

/* Cells take half of the time, blocks the other half. Rounds, if any, take half of all. */
static void pre_render(struct pen_thread_pool *pool, struct forecast *f)
{
    const double part = pen_settings_adaptive(f->task->settings) ? 0.25 : 0.5;
    const int64_t begun_ns = pen_clock_ns();
    const int64_t blocks_until_ns = part_of_time(f, 2 * part);
    f->until_ns = part_of_time(f, part);
    pen_thread_pool_run(pool, f->threads, count_cells, f);
    f->until_ns = blocks_until_ns;
    if (!is_cancelled(f))
        choose_side(f, pen_clock_ns() - begun_ns);
    atomic_store(&f->next, 0);
    pen_thread_pool_run(pool, f->threads, time_blocks, f);
}

static void run(struct pen_thread_pool *pool, struct forecast *f, struct pen_forecast *out)
{
    const double film = 3.0 * sizeof(float) * f->settings->width * f->settings->height;
    struct pen_estimate *const of_kind[KINDS] = {&out->primary, &out->shadow, &out->reflection,
                                                 &out->transmission};
    pre_render(pool, f);
    for (int kind = 0; kind < KINDS; kind++)
        *of_kind[kind] = estimate(f, kind);
    out->total = estimate(f, KINDS);
    for (int kind = 1; kind < KINDS; kind++)
        out->total.high += of_kind[kind]->expected == 0 ? of_kind[kind]->high : 0;
    out->cpu_ms = estimate_time(f, &out->total);
    out->time_ms = pen_estimate_scaled(out->cpu_ms, 1.0 / f->threads);
    const double had = (double)atomic_load(&f->cpu_ns), took = (double)atomic_load(&f->thread_ns);
    out->used = had < took && had > 0 ? had / took : 1;
    out->memory_bytes = film + (double)pen_arena_used(f->input.scene->arena) +
                        (double)f->threads * (double)f->kernel.block_bytes;
    out->pixels = done_cells(f);
    out->kernel = f->kernel.name;
    out->effects = f->input.effects;
    out->seen = f->seen;
    f->seen = NULL;
}

bool pen_forecast_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       struct pen_forecast *out, struct pen_status *st)
{
    const int64_t begun = pen_clock_ns();
    struct pen_settings sampling = pen_settings_sampling(task->settings);
    struct forecast f = {.task = task,
                         .settings = &sampling,
                         .cell_step = 1,
                         .block_step = 1,
                         .side = PEN_BLOCK_SIDE,
                         .samples = {1, 1, 1},
                         .threads = pen_render_threads(pool, task->settings)};
    cut(&f);
    if (task->deadline_ns != 0)
        bound(&f, &sampling);
    f.input = pen_kernel_input_of(task->scene, task->view, &sampling);
    f.kernel =
        pen_kernel_choose(&f.input, (int64_t)sampling.width * sampling.height, pen_cpu_isa());
    const bool ok = make_scratch(&f);
    if (ok)
        run(pool, &f, out);
    release(&f);
    if (!ok)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the light paths of a forecast");
    if (is_cancelled(&f) ? pen_fail(st, PEN_CANCELLED, "the forecast was cancelled")
                         : pen_forecast_add_rounds(pool, task, out, st)) {
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
