/* SPDX-License-Identifier: MIT */
/* Cells are taken in scattered order, so that the cells that are done by a deadline are spread over
 * the whole view. */
#include "render/cost_map.h"

#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "math/fn.h"
#include "math/sample.h"
#include "render/internal/forecast_samples.h"
#include "render/internal/kernel_input.h"
#include "render/render.h"

/* Numbers of cells of a job. MOST_CELLS limits the size of a stored map. Up to MANY_CELLS, blocks
 * take fewer camera rays. Up to FEW_CELLS they are smaller, although a ray costs more there. */
enum { MOST_CELLS = 1024, MANY_CELLS = 512, FEW_CELLS = 160 };

/* The most rays of all cells: some ten seconds of two threads. A pixel takes at most its share of
 * them, as estimated from the numbers of samples. */
static const double RAYS_MAX = 4e7;

static const double CELL_STEP = 0.618;

/* Steps of stored shares per octave, below the largest share. */
enum { STEPS_AN_OCTAVE = 16 };

struct sampler {
    const struct pen_forecast_task *task;
    struct pen_cost_map *map;
    struct pen_settings sampling;
    struct pen_kernel_input input; /* of the view at index `view` */
    struct pen_kernel kernel;
    struct pen_kernel_scratch **scratch; /* by thread */
    int view, threads, side, step;
    int64_t end_ns; /* time after which no more cells of the view are begun; 0: none */
    double pixels;  /* number that a view may take, with all samples */
    double fewer;   /* divisor of the samples in blocks of the view */
    double excess;  /* factor by which that may be too much, for all views */
    atomic_int next;
};

static int part_of(int length, int i, int n)
{
    return (int)((int64_t)length * i / n);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double most(double a, double b)
{
    return a > b ? a : b;
}

static int cells_of_view(const struct pen_cost_map *map)
{
    return map->columns * map->rows;
}

static int cells_of(const struct pen_cost_map *map)
{
    return map->views * cells_of_view(map);
}

/* A cell of a view. */
static struct pen_rect cell_rect(const struct pen_cost_map *map, int column, int row)
{
    const int x = part_of(map->width, column, map->columns),
              y = part_of(map->height, row, map->rows);
    return (struct pen_rect){x, y, part_of(map->width, column + 1, map->columns) - x,
                             part_of(map->height, row + 1, map->rows) - y};
}

/* Divides a view into nearly square cells: at most this number, and at most the number of its
 * pixels. */
static void cut_view(struct pen_cost_map *map, double cells)
{
    const double side = sqrt((double)map->width * map->height / most(1, cells));
    map->columns = (int)most(1, least(map->width, floor(map->width / side)));
    map->rows = (int)most(1, least(map->height, floor(map->height / side)));
}

static int camera_samples(const struct sampler *s, int view)
{
    const bool lens = s->task->scene->views[view].camera.aperture_radius > 0;
    const struct pen_settings sampling = pen_settings_sampling(s->task->settings);
    return pen_camera_samples(lens, &sampling);
}

/* Chooses cells and blocks: the number that PEN_COST_MAP_PART of the work allows in the view with
 * the fewest camera rays. Blocks may leave out some of these. */
static void choose_cells(struct sampler *s, const int *view)
{
    struct pen_cost_map *map = s->map;
    const double all = most(1, MOST_CELLS / map->views), many = most(1, MANY_CELLS / map->views),
                 few = most(1, FEW_CELLS / map->views);
    double fewer = 1;
    int camera = camera_samples(s, view[0]);
    for (int i = 1; i < map->views; i++)
        camera = smaller(camera, camera_samples(s, view[i]));
    s->pixels = (double)map->width * map->height / PEN_COST_MAP_PART;
    s->side = PEN_BLOCK_SIDE;
    if (s->pixels < many * s->side * s->side)
        fewer = camera / ceil(camera * s->pixels / (many * s->side * s->side));
    while (s->side > 1 && s->pixels * fewer < few * s->side * s->side)
        s->side /= 2;
    cut_view(map, least(all, floor(s->pixels * fewer / (s->side * s->side))));
}

/* Chooses the number of samples in the blocks of a view. */
static void choose_samples(struct sampler *s, int view)
{
    const int camera = camera_samples(s, view);
    const double blocks = (double)cells_of_view(s->map) * s->side * s->side;
    const int taken = smaller(camera, (int)ceil(camera * s->pixels / blocks));
    s->sampling = pen_settings_sampling(s->task->settings);
    if (taken < camera)
        s->sampling.samples_per_pixel = s->sampling.lens_samples = taken;
    const struct pen_forecast_samples times = pen_forecast_samples_cut(
        s->task->scene, view, RAYS_MAX / (blocks * s->map->views), &s->sampling);
    s->fewer = (double)camera / taken * times.camera * times.light * times.blur;
    s->excess = most(s->excess, times.light * times.blur);
}

static bool is_cancelled(const struct sampler *s)
{
    return s->task->cancel && atomic_load_explicit(s->task->cancel, memory_order_relaxed);
}

/* A block at a random place in a cell. */
static struct pen_rect block_in(const struct sampler *s, struct pen_rect cell, int number)
{
    const int width = smaller(s->side, cell.width), height = smaller(s->side, cell.height);
    const uint64_t hash = pen_mix64((uint64_t)number);
    const int x = (int)((hash >> 33) % (uint64_t)(cell.width - width + 1)),
              y = (int)((pen_mix64(hash) >> 33) % (uint64_t)(cell.height - height + 1));
    return (struct pen_rect){cell.x + x, cell.y + y, width, height};
}

/* Puts the time of all pixels of a cell into the map. */
static void time_cell(struct sampler *s, int thread, int cell)
{
    struct pen_cost_map *map = s->map;
    const int number = s->view * cells_of_view(map) + cell;
    const struct pen_rect all = cell_rect(map, cell % map->columns, cell / map->columns),
                          block = block_in(s, all, number);
    double rgb[PEN_BLOCK_SIDE * PEN_BLOCK_SIDE][3];
    struct pen_ray_counts rays = {.primary = 0};
    if (s->task->pixel_begins)
        s->task->pixel_begins(s->task->pixel_user, thread, block.x, block.y);
    const int64_t begun_ns = pen_clock_thread_ns();
    pen_render_block(&s->kernel, &s->input, s->scratch[thread], block, rgb, &rays);
    const double ns = (double)(pen_clock_thread_ns() - begun_ns);
    map->cell[number] =
        ns * s->fewer * all.width * all.height / ((double)block.width * block.height);
}

static void time_cells(void *user, int thread)
{
    struct sampler *s = user;
    const int cells = cells_of_view(s->map);
    bool warm = false;
    int i;
    while ((i = atomic_fetch_add_explicit(&s->next, 1, memory_order_relaxed)) < cells &&
           !is_cancelled(s) && (i == 0 || s->end_ns == 0 || pen_clock_ns() < s->end_ns)) {
        const int cell = (int)((int64_t)i * s->step % cells);
        if (!warm) /* the first block of a thread also waits for memory that later blocks find in
                      caches */
            time_cell(s, thread, cell);
        warm = true;
        time_cell(s, thread, cell);
    }
}

/* Times the cells of the view with this number in the scene. */
static bool time_view(struct pen_thread_pool *pool, struct sampler *s, int view)
{
    const int64_t end_ns = s->task->deadline_ns;
    bool ok = true;
    choose_samples(s, view);
    s->input = pen_kernel_input_of(s->task->scene, view, &s->sampling);
    s->kernel = pen_kernel_choose(&s->input, (int64_t)s->sampling.width * s->sampling.height,
                                  pen_cpu_isa());
    s->end_ns =
        end_ns ? pen_clock_between(pen_clock_ns(), end_ns, 1.0 / (s->map->views - s->view)) : 0;
    atomic_store(&s->next, 0);
    for (int i = 0; i < s->threads; i++)
        ok = (s->scratch[i] = pen_kernel_scratch_new(&s->input)) && ok;
    if (ok)
        pen_thread_pool_run(pool, s->threads, time_cells, s);
    for (int i = 0; i < s->threads; i++)
        pen_kernel_scratch_free(s->scratch[i]);
    return ok;
}

static int common_divisor(int a, int b)
{
    return b == 0 ? a : common_divisor(b, a % b);
}

static bool time_views(struct pen_thread_pool *pool, struct sampler *s, const int *view)
{
    const int cells = cells_of_view(s->map);
    s->step = (int)(CELL_STEP * cells) + 1;
    while (common_divisor(s->step, cells) > 1)
        s->step++;
    s->scratch = calloc((size_t)s->threads, sizeof *s->scratch);
    s->map->cell = calloc((size_t)cells_of(s->map), sizeof *s->map->cell);
    bool ok = s->scratch && s->map->cell;
    for (; ok && s->view < s->map->views && !is_cancelled(s); s->view++)
        ok = time_view(pool, s, view[s->view]);
    free(s->scratch);
    return ok;
}

/* Turns times into shares, and estimates the time of all pixels. Its error comes from the
 * differences of neighbouring cells, as in forecast.c. */
static void normalise(const struct sampler *s)
{
    struct pen_cost_map *map = s->map;
    const int cells = cells_of(map);
    double ns = 0, squares = 0, before = 0, done = 0;
    for (int i = 0; i < cells; i++) {
        if (map->cell[i] <= 0)
            continue;
        squares += done > 0 ? (map->cell[i] - before) * (map->cell[i] - before) : map->cell[i];
        before = map->cell[i];
        ns += before;
        done++;
    }
    const double mean = done > 0 ? ns / done : 0, all_ns = mean * cells,
                 off_ns =
                     done > 1 ? 1.96 * cells * sqrt(squares / (2 * (done - 1)) / done) : all_ns,
                 to_ms = 1e-6 / s->threads, excess = s->excess;
    map->time_ms = (struct pen_estimate){all_ns * to_ms, most(0, all_ns - off_ns) * to_ms / excess,
                                         (all_ns + off_ns) * to_ms};
    for (int i = 0; i < cells; i++)
        map->cell[i] = all_ns > 0 ? (map->cell[i] > 0 ? map->cell[i] : mean) / all_ns : 1.0 / cells;
}

bool pen_cost_map_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       const int *view, int view_count, struct pen_cost_map *map,
                       struct pen_status *st)
{
    const struct pen_settings *settings = task->settings;
    struct sampler s = {
        .task = task, .map = map, .excess = 1, .threads = pen_render_threads(pool, settings)};
    *map = (struct pen_cost_map){
        .views = view_count, .width = settings->width, .height = settings->height};
    choose_cells(&s, view);
    const bool ok = time_views(pool, &s, view);
    if (ok && !is_cancelled(&s)) {
        normalise(&s);
        return true;
    }
    pen_cost_map_release(map);
    return ok ? pen_fail(st, PEN_CANCELLED, "the cost map was cancelled")
              : pen_fail(st, PEN_NO_MEMORY, "no memory for a cost map");
}

void pen_cost_map_release(struct pen_cost_map *map)
{
    free(map->cell);
    map->cell = NULL;
}

static double overlap(int a, int a_length, int b, int b_length)
{
    const int end = smaller(a + a_length, b + b_length), begin = a > b ? a : b;
    return end > begin ? end - begin : 0;
}

/* The first of n parts of a length that can contain a place at or after `at`. */
static int part_at(int length, int at, int n)
{
    const int part = (int)((int64_t)at * n / length);
    return part > 0 ? part - 1 : 0;
}

double pen_cost_map_share(const struct pen_cost_map *map, int view, struct pen_rect rect)
{
    const int right = rect.x + rect.width, below = rect.y + rect.height;
    double share = 0;
    if (!map->cell)
        return (double)rect.width * rect.height / ((double)map->width * map->height * map->views);
    for (int row = part_at(map->height, rect.y, map->rows);
         row < map->rows && part_of(map->height, row, map->rows) < below; row++)
        for (int column = part_at(map->width, rect.x, map->columns);
             column < map->columns && part_of(map->width, column, map->columns) < right; column++) {
            const struct pen_rect cell = cell_rect(map, column, row);
            const double common = overlap(rect.x, rect.width, cell.x, cell.width) *
                                  overlap(rect.y, rect.height, cell.y, cell.height);
            share += map->cell[view * cells_of_view(map) + row * map->columns + column] * common /
                     ((double)cell.width * cell.height);
        }
    return share;
}

/* The head of a stored map: views, columns and rows, of two bytes each. Then follows one byte for
 * each cell. */
enum { HEAD_BYTES = 6 };
_Static_assert(HEAD_BYTES + MOST_CELLS <= PEN_COST_MAP_BYTES, "a map fits");

static const double ln_2 = 0x1.62e42fefa39efp-1;

bool pen_cost_map_save(const struct pen_cost_map *map, struct pen_buf *out)
{
    const int cells = cells_of(map), head[] = {map->views, map->columns, map->rows};
    unsigned char bytes[PEN_COST_MAP_BYTES];
    double largest = 0;
    if (cells > MOST_CELLS)
        return false;
    for (int i = 0; i < HEAD_BYTES; i++)
        bytes[i] = (unsigned char)(head[i / 2] >> 8 * (i % 2));
    for (int i = 0; i < cells; i++)
        largest = most(largest, map->cell[i]);
    for (int i = 0; i < cells; i++) {
        const double octaves = map->cell[i] > 0 ? pen_ln(largest / map->cell[i]) / ln_2 : UINT8_MAX;
        bytes[HEAD_BYTES + i] = (unsigned char)least(UINT8_MAX, round(STEPS_AN_OCTAVE * octaves));
    }
    return pen_buf_add(out, bytes, (size_t)(HEAD_BYTES + cells));
}

bool pen_cost_map_load(const unsigned char *data, size_t bytes, struct pen_cost_map *map)
{
    struct pen_cost_map read = *map;
    double sum = 0;
    if (bytes < HEAD_BYTES || bytes > PEN_COST_MAP_BYTES)
        return false;
    read.columns = data[2] | data[3] << 8;
    read.rows = data[4] | data[5] << 8;
    if ((data[0] | data[1] << 8) != map->views || read.columns > map->width ||
        read.rows > map->height || read.columns * read.rows < 1 ||
        (int64_t)map->views * read.columns * read.rows != (int64_t)bytes - HEAD_BYTES)
        return false;
    read.cell = malloc((bytes - HEAD_BYTES) * sizeof *read.cell);
    if (!read.cell)
        return false;
    for (int i = 0; i < cells_of(&read); i++)
        sum += read.cell[i] = pen_exp(-ln_2 * data[HEAD_BYTES + i] / STEPS_AN_OCTAVE);
    for (int i = 0; i < cells_of(&read); i++)
        read.cell[i] /= sum;
    free(map->cell);
    *map = read;
    return true;
}
