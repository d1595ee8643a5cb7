/* SPDX-License-Identifier: MIT */
/* Threads take rows of blocks, 8 pixels high, of a tile from a counter, tile after tile. Each pixel
 * is a pure function of its place, except for measured times. */
#include "render/layers.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "render/internal/counter.h"
#include "render/internal/kernel_input.h"
#include "render/internal/refine.h"
#include "shade/first_hit.h"

enum { BLOCK_PIXELS = PEN_BLOCK_SIDE * PEN_BLOCK_SIDE };

/* The working memory of a thread. */
struct worker {
    struct pen_kernel_scratch *scratch; /* for times and tests; else NULL */
    struct pen_counter *counter;
    struct pen_kernel_scratch *counting; /* that of the counter */
};

struct job {
    const struct pen_layer_task *task;
    const struct pen_adaptive *adaptive; /* with a target error */
    struct pen_kernel_input input;
    const struct pen_kernel *kernel;
    struct worker *worker; /* by thread */
    int threads;
    struct pen_layer_tiles *tiles;
    pthread_mutex_t lock;
    int64_t next; /* guarded by lock; the next row of blocks to begin */
};

const char *const pen_layer_names[PEN_LAYER_COUNT + 1] = {
    [PEN_LAYER_BEAUTY] = "beauty", [PEN_LAYER_COST] = "cost",     [PEN_LAYER_SAMPLES] = "samples",
    [PEN_LAYER_DEPTH] = "depth",   [PEN_LAYER_NORMAL] = "normal", [PEN_LAYER_ALBEDO] = "albedo"};
const char *const pen_cost_names[] = {[PEN_COST_TIME] = "time", [PEN_COST_TESTS] = "tests", NULL};

const char *pen_layer_name(enum pen_layer layer)
{
    return layer < PEN_LAYER_COUNT ? pen_layer_names[layer] : "unknown";
}

enum pen_layer pen_layer_find(const char *name)
{
    int layer = 0;
    while (layer < PEN_LAYER_COUNT && strcmp(name, pen_layer_names[layer]) != 0)
        layer++;
    return (enum pen_layer)layer;
}

static const struct pen_pixel_sums *sums_at(const struct job *job, int x, int y)
{
    return &job->adaptive->sums[(size_t)y * (size_t)job->task->settings->width + (size_t)x];
}

/* The number of camera rays of a pixel. */
static double samples_at(const struct job *job, int x, int y)
{
    if (job->adaptive)
        return sums_at(job, x, y)->samples;
    return pen_camera_samples(job->input.lens.open, job->task->settings);
}

/* The value of a pixel in the layers that do not depend on its work. */
static struct pen_vec3 value_at(const struct job *job, int x, int y)
{
    const struct pen_vec3 none = {0, 0, 0}, one = {1, 1, 1};
    struct pen_first_hit hit;
    if (job->task->layer == PEN_LAYER_SAMPLES)
        return pen_scale(one, samples_at(job, x, y));
    if (!pen_first_hit(&job->input, x, y, &hit))
        return none;
    if (job->task->layer == PEN_LAYER_DEPTH)
        return pen_scale(one, hit.distance);
    if (job->task->layer == PEN_LAYER_NORMAL)
        return pen_scale(pen_add(hit.normal, one), 0.5);
    return hit.albedo;
}

static const struct pen_beams *beams_at(const struct job *job, int x, int y)
{
    return pen_adaptive_beams(job->adaptive,
                              (size_t)y * (size_t)job->task->settings->width + (size_t)x);
}

/* Traces the samples of a block of pixels as a render does. */
static void trace_block(const struct job *job, const struct pen_kernel_input *input,
                        struct pen_kernel_scratch *scratch, struct pen_rect block)
{
    struct pen_ray_counts rays = {.primary = 0};
    double rgb[BLOCK_PIXELS][3];
    struct pen_sample_range ranges[BLOCK_PIXELS];
    struct pen_pixel_sums sums[BLOCK_PIXELS] = {{.samples = 0}};
    int count = 0;
    if (!job->adaptive) {
        pen_render_block(job->kernel, input, scratch, block, rgb, &rays);
        return;
    }
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const int x = pen_z_order_x(i), y = pen_z_order_x(i >> 1);
        if (x < block.width && y < block.height) {
            ranges[count] =
                (struct pen_sample_range){.x = block.x + x,
                                          .y = block.y + y,
                                          .end = sums_at(job, block.x + x, block.y + y)->samples,
                                          .sums = &sums[count],
                                          .beams = beams_at(job, block.x + x, block.y + y)};
            count++;
        }
    }
    pen_trace_samples(job->kernel, input, scratch, ranges, count, &rays);
}

/* The box and primitive tests of a pixel. */
static double tests_at(const struct job *job, const struct worker *worker, int x, int y)
{
    struct pen_test_counts before = {0, 0}, after = {0, 0};
    pen_counter_add(worker->counter, &before);
    trace_block(job, pen_counter_input(worker->counter), worker->counting,
                (struct pen_rect){x, y, 1, 1});
    pen_counter_add(worker->counter, &after);
    return (double)(after.boxes - before.boxes + after.primitives - before.primitives);
}

/* The time of a block in nanoseconds. It is processor time, so other programs do not affect it. */
static double time_of(const struct job *job, const struct worker *worker, struct pen_rect block)
{
    const int64_t begun = pen_clock_thread_ns();
    trace_block(job, &job->input, worker->scratch, block);
    return (double)(pen_clock_thread_ns() - begun);
}

static void put(const struct job *job, int x, int y, struct pen_vec3 v)
{
    const size_t row = (size_t)(y - job->task->first_row);
    float *to = job->task->rgb + 3 * (row * (size_t)job->task->settings->width + (size_t)x);
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
}

/* The costs of the pixels of a block: their tests, or their shares of its time. */
static void cost_block(const struct job *job, const struct worker *worker, struct pen_rect block)
{
    double tests[BLOCK_PIXELS], sum = 0, factor = 1;
    const int pixels = block.width * block.height;
    for (int i = 0; i < pixels; i++) {
        tests[i] = tests_at(job, worker, block.x + i % block.width, block.y + i / block.width);
        sum += tests[i];
    }
    if (job->task->cost == PEN_COST_TIME) {
        for (int i = 0; i < pixels && sum == 0; i++)
            tests[i] = 1; /* nothing to test: equal shares */
        factor = time_of(job, worker, block) / (sum > 0 ? sum : pixels);
    }
    for (int i = 0; i < pixels; i++) {
        const double cost = tests[i] * factor;
        put(job, block.x + i % block.width, block.y + i / block.width, pen_vec3(cost, cost, cost));
    }
}

static void layer_block(const struct job *job, const struct worker *worker, struct pen_rect block)
{
    if (job->task->layer == PEN_LAYER_COST) {
        cost_block(job, worker, block);
        return;
    }
    for (int y = block.y; y < block.y + block.height; y++)
        for (int x = block.x; x < block.x + block.width; x++)
            put(job, x, y, value_at(job, x, y));
}

static bool stopped(const struct pen_layer_task *task)
{
    return task->cancel && atomic_load_explicit(task->cancel, memory_order_relaxed);
}

/* The number of rows of blocks in a tile that is not cut off by the image's edge. */
static int rows_of_tile(const struct pen_settings *s)
{
    const int height = s->tile < s->height ? s->tile : s->height;
    return (height + PEN_BLOCK_SIDE - 1) / PEN_BLOCK_SIDE;
}

/* Takes the next row of blocks, whose tile counts as done: every begun tile is finished, unless the
 * layer is cancelled. Returns false if there is none, or if the caller pauses. */
static bool take_row(struct job *job, struct pen_rect *row)
{
    const struct pen_settings *s = job->task->settings;
    struct pen_layer_tiles *tiles = job->tiles;
    const int rows = rows_of_tile(s);
    pthread_mutex_lock(&job->lock);
    const int tile = (int)(job->next / rows), number = (int)(job->next % rows);
    const bool begins = number == 0 && tile < tiles->count;
    bool more = tile < tiles->count;
    if (begins && tile > 0 && tiles->pause && tiles->pause(tiles->pause_user)) {
        tiles->count = tile; /* later calls find no more either */
        more = false;
    }
    job->next += more;
    pthread_mutex_unlock(&job->lock);
    if (!more)
        return false;
    *row = pen_tile_rect(s->width, s->height, s->tile, tiles->first + tile);
    const int below = number * PEN_BLOCK_SIDE, left = row->height - below;
    row->y += below;
    row->height =
        left < PEN_BLOCK_SIDE ? left : PEN_BLOCK_SIDE; /* 0 or less in a tile that is cut off */
    return true;
}

static void work(void *user, int index)
{
    struct job *job = user;
    struct pen_rect row;
    if (job->task->layer == PEN_LAYER_COST) /* the first access to memory would count */
        time_of(job, &job->worker[index], (struct pen_rect){0, 0, 1, 1});
    while (!stopped(job->task) && take_row(job, &row)) {
        for (int x = 0; row.height > 0 && x < row.width && !stopped(job->task);
             x += PEN_BLOCK_SIDE) {
            const int left = row.width - x, width = left < PEN_BLOCK_SIDE ? left : PEN_BLOCK_SIDE;
            layer_block(job, &job->worker[index],
                        (struct pen_rect){row.x + x, row.y, width, row.height});
        }
    }
}

static bool make_worker(const struct job *job, struct worker *worker)
{
    if (job->task->layer != PEN_LAYER_COST)
        return true;
    worker->scratch = pen_kernel_scratch_new(&job->input);
    worker->counter = pen_counter_new(&job->input);
    if (worker->counter)
        worker->counting = pen_kernel_scratch_new(pen_counter_input(worker->counter));
    return worker->scratch && worker->counting;
}

static bool run(struct pen_thread_pool *pool, struct job *job, struct pen_status *st)
{
    job->worker = calloc((size_t)job->threads, sizeof *job->worker);
    bool ok = job->worker != NULL;
    for (int i = 0; ok && i < job->threads; i++)
        ok = make_worker(job, &job->worker[i]);
    if (ok)
        pen_thread_pool_run(pool, job->threads, work, job);
    for (int i = 0; job->worker && i < job->threads; i++) {
        pen_kernel_scratch_free(job->worker[i].scratch);
        pen_kernel_scratch_free(job->worker[i].counting);
        pen_counter_free(job->worker[i].counter);
    }
    free(job->worker);
    if (!ok)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the light paths of a layer");
    return !stopped(job->task) || pen_fail(st, PEN_CANCELLED, "cancelled");
}

/* The state of a render with a target error, for layers that depend on it.
 * Owns: *own, if the task has none. */
static bool find_state(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                       struct pen_adaptive **own, struct pen_status *st)
{
    const bool depends = task->layer == PEN_LAYER_SAMPLES || task->layer == PEN_LAYER_COST;
    struct pen_render_task all = {.scene = task->scene,
                                  .view = task->view,
                                  .settings = task->settings,
                                  .tile_count = -1,
                                  .rgb = task->rgb, /* becomes the layer afterwards */
                                  .cancel = task->cancel};
    struct pen_render_stats stats;
    *own = NULL;
    if (task->adaptive || !depends || !pen_settings_adaptive(task->settings))
        return true;
    *own = pen_adaptive_new(task->settings, st);
    return *own && pen_render_rounds(pool, &all, *own, &stats, st);
}

bool pen_layer_render_tiles(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                            struct pen_layer_tiles *tiles, struct pen_status *st)
{
    const struct pen_settings sampling = pen_settings_sampling(task->settings);
    struct pen_adaptive *own;
    bool ok = find_state(pool, task, &own, st);
    struct job job = {.task = task,
                      .adaptive = own ? own : task->adaptive,
                      .input = pen_kernel_input_of(task->scene, task->view, &sampling),
                      .tiles = tiles,
                      .lock = PTHREAD_MUTEX_INITIALIZER};
    job.kernel = pen_kernel_select(job.input.effects, pen_cpu_isa());
    job.threads = pen_render_threads(pool, task->settings);
    ok = ok && run(pool, &job, st);
    pthread_mutex_destroy(&job.lock);
    pen_adaptive_free(own);
    return ok;
}

bool pen_layer_render(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                      struct pen_status *st)
{
    const struct pen_settings *s = task->settings;
    struct pen_layer_tiles all = {.count = pen_tile_count(s->width, s->height, s->tile)};
    return pen_layer_render_tiles(pool, task, &all, st);
}

double pen_layer_work(enum pen_layer layer, enum pen_cost cost)
{
    if (layer != PEN_LAYER_COST)
        return 0;
    return cost == PEN_COST_TIME ? 4 : 3;
}

/* Black, blue, red, yellow, white: each brighter than the one before it. */
static void heat(double share, float *rgb)
{
    static const double at[][3] = {
        {0, 0, 0.02}, {0.15, 0.05, 0.5}, {0.75, 0.1, 0.3}, {1, 0.6, 0.1}, {1, 1, 0.9}};
    const int last = sizeof at / sizeof at[0] - 1;
    const double place = share < 1 ? share * last : last;
    const int below = place < last ? (int)place : last - 1;
    for (int c = 0; c < 3; c++)
        rgb[c] = (float)(at[below][c] + (place - below) * (at[below + 1][c] - at[below][c]));
}

/* The largest value; for depths, the least above 0. */
static double value_of_white(enum pen_layer layer, const float *rgb, size_t pixels)
{
    double best = 0;
    for (size_t i = 0; i < pixels; i++) {
        const double v = (double)rgb[3 * i];
        const bool nearer = v > 0 && (best == 0 || v < best);
        if (layer == PEN_LAYER_DEPTH ? nearer : v > best)
            best = v;
    }
    return best;
}

double pen_layer_show(enum pen_layer layer, float *rgb, size_t pixels)
{
    if (layer != PEN_LAYER_COST && layer != PEN_LAYER_SAMPLES && layer != PEN_LAYER_DEPTH)
        return 0;
    const double white = value_of_white(layer, rgb, pixels);
    for (size_t i = 0; i < pixels; i++) {
        float *to = &rgb[3 * i];
        const double v = (double)to[0];
        if (layer == PEN_LAYER_COST)
            heat(v > 0 ? sqrt(sqrt(v / white)) : 0, to);
        else
            to[0] = to[1] = to[2] = (float)(v <= 0                     ? 0
                                            : layer == PEN_LAYER_DEPTH ? white / v
                                                                       : v / white);
    }
    return white;
}
