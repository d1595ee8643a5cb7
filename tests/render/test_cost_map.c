/* SPDX-License-Identifier: MIT */
/* The arithmetic of cost maps, and the cost of measuring one. */
#include <math.h>
#include <stdlib.h>

#include "render/cost_map.h"
#include "support/kit.h"
#include "support/suite.h"

/* Two views of 10 x 6 pixels, each of 2 x 2 cells. */
static double cells[] = {0.05, 0.1, 0.15, 0.2, 0.4, 0.05, 0.03, 0.02};
static const struct pen_cost_map known = {
    .views = 2, .width = 10, .height = 6, .columns = 2, .rows = 2, .cell = cells};

static void expect_share(const struct pen_cost_map *map, int view, struct pen_rect rect,
                         double share)
{
    ck_assert_double_eq_tol(pen_cost_map_share(map, view, rect), share, 1e-12);
}

START_TEST(test_cost_map__share_is_that_of_the_cells_below_a_rectangle)
{
    expect_share(&known, 0, (struct pen_rect){0, 0, 5, 3}, 0.05);
    expect_share(&known, 1, (struct pen_rect){5, 0, 5, 3}, 0.05);
    expect_share(&known, 1, (struct pen_rect){0, 0, 10, 6}, 0.5);
    /* Parts of all four. */
    expect_share(&known, 0, (struct pen_rect){4, 1, 3, 3},
                 (0.05 * 2 + 0.1 * 4 + 0.15 * 1 + 0.2 * 2) / 15);
    expect_share(&known, 0, (struct pen_rect){3, 2, 0, 3}, 0);
}
END_TEST

/* However the picture is cut into tiles, and without a map. */
START_TEST(test_cost_map__tiles_have_all_work)
{
    static const struct pen_cost_map none = {.views = 2, .width = 10, .height = 6};
    const struct pen_cost_map *const maps[] = {&known, &none};
    for (int edge = 1; edge <= 11; edge++)
        for (int m = 0; m < 2; m++) {
            double sum = 0;
            for (int view = 0; view < 2; view++)
                for (int i = 0; i < pen_tile_count(10, 6, edge); i++)
                    sum += pen_cost_map_share(maps[m], view, pen_tile_rect(10, 6, edge, i));
            ck_assert_double_eq_tol(sum, 1, 1e-12);
        }
    expect_share(&none, 1, (struct pen_rect){2, 2, 3, 4}, 0.1);
}
END_TEST

START_TEST(test_cost_map__saved_map_is_read_again)
{
    struct pen_buf bytes = {0};
    struct pen_cost_map map = {.views = 2, .width = 10, .height = 6};
    ck_assert(pen_cost_map_save(&known, &bytes));
    ck_assert(pen_cost_map_load(bytes.data, bytes.bytes, &map));
    ck_assert_int_eq(map.columns * map.rows, 4);
    double sum = 0;
    for (int i = 0; i < 8; i++) {
        sum += map.cell[i];
        ck_assert(fabs(log2(map.cell[i] / cells[i])) < 1.0 / 16);
    }
    ck_assert_double_eq_tol(sum, 1, 1e-12);
    pen_cost_map_release(&map);
    pen_buf_release(&bytes);
}
END_TEST

START_TEST(test_cost_map__bytes_of_no_such_map_are_refused)
{
    struct pen_buf bytes = {0};
    struct pen_cost_map map = {.views = 2, .width = 10, .height = 6},
                        narrow = {.views = 2, .width = 1, .height = 6},
                        single = {.views = 1, .width = 10, .height = 6};
    ck_assert(pen_cost_map_save(&known, &bytes));
    for (size_t i = 0; i < bytes.bytes; i++)
        ck_assert(!pen_cost_map_load(bytes.data, i, &map));
    ck_assert(!pen_cost_map_load(bytes.data, bytes.bytes, &narrow));
    ck_assert(!pen_cost_map_load(bytes.data, bytes.bytes, &single));
    for (int at = 0; at < 6; at++) { /* of its head */
        bytes.data[at] ^= 0x81;
        ck_assert(!pen_cost_map_load(bytes.data, bytes.bytes, &map));
        bytes.data[at] ^= 0x81;
    }
    ck_assert_ptr_null(map.cell);
    pen_buf_release(&bytes);
}
END_TEST

static void count_block(void *user, int thread, int x, int y)
{
    (void)thread;
    (void)x;
    (void)y;
    atomic_fetch_add((atomic_int *)user, 1);
}

/* Measures pictures of a sheet that fills the lower half, under many lights. */
static struct pen_cost_map measure(int width, int height, int samples, int *blocks)
{
    static struct kit kit;
    static const int views[] = {0};
    struct pen_status st;
    struct pen_cost_map map;
    atomic_int count = 0;
    kit_init(&kit);
    kit.settings.width = width;
    kit.settings.height = height;
    kit.settings.samples_per_pixel = samples;
    kit.settings.light_samples = 400;
    kit_polygon(&kit,
                (struct pen_vec3[]){{-100, -100, 0}, {100, -100, 0}, {100, 0, 0}, {-100, 0, 0}}, 4,
                kit_material(&kit, kit_matte(1)));
    for (int i = 0; i < KIT_LIGHTS; i++)
        kit_point(&kit, (struct pen_vec3){i - 8, -3, 5}, (struct pen_vec3){1, 1, 1})->radius = 1;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    const struct pen_forecast_task task = {.scene = scene,
                                           .settings = &kit.settings,
                                           .pixel_begins = count_block,
                                           .pixel_user = &count};
    ck_assert(pen_cost_map_make(pool, &task, views, 1, &map, &st));
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    *blocks = atomic_load(&count);
    return map;
}

START_TEST(test_cost_map__measured_map_tells_where_the_work_is)
{
    int blocks;
    struct pen_cost_map map = measure(160, 160, 1, &blocks);
    ck_assert(pen_cost_map_share(&map, 0, (struct pen_rect){0, 0, 160, 72}) < 0.3);
    ck_assert(pen_cost_map_share(&map, 0, (struct pen_rect){0, 88, 160, 72}) > 0.6);
    ck_assert(map.time_ms.low <= map.time_ms.expected && map.time_ms.expected > 0);
    pen_cost_map_release(&map);
}
END_TEST

/* And there are cells enough, also of a small picture. */
START_TEST(test_cost_map__measuring_takes_two_per_cent_at_most)
{
    static const int sizes[][3] = {{640, 480, 1}, {1500, 1000, 1}, {100, 80, 1}, {64, 64, 64}};
    for (int i = 0; i < 4; i++) {
        const double pixels = (double)sizes[i][0] * sizes[i][1];
        int blocks;
        struct pen_cost_map map = measure(sizes[i][0], sizes[i][1], sizes[i][2], &blocks);
        ck_assert_int_ge(blocks, map.columns * map.rows);
        ck_assert_int_ge(blocks, 60);
        if (sizes[i][2] == 1 && pixels > 1e6) /* blocks are whole */
            ck_assert(64.0 * blocks <= 0.02 * pixels);
        pen_cost_map_release(&map);
    }
}
END_TEST

PEN_SUITE("cost maps", test_cost_map__share_is_that_of_the_cells_below_a_rectangle,
          test_cost_map__tiles_have_all_work, test_cost_map__saved_map_is_read_again,
          test_cost_map__bytes_of_no_such_map_are_refused,
          test_cost_map__measured_map_tells_where_the_work_is,
          test_cost_map__measuring_takes_two_per_cent_at_most)
