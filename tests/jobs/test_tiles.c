/* SPDX-License-Identifier: MIT */
/* The rectangles of commits: together they cover the image, each pixel once. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/jobs.h"
#include "support/suite.h"

enum { WIDTH = 203, HEIGHT = 150 };

struct painted {
    unsigned char times[2][WIDTH * HEIGHT]; /* how often each pixel was covered, by view */
    int rectangles, parts, left;
    int64_t revision, first_revision;
};

static bool paint(void *user, const struct pen_job_tile *tile)
{
    struct painted *painted = user;
    bool same = tile->revision == painted->revision;
    ck_assert_int_ge(tile->revision, painted->revision);
    ck_assert_int_eq(tile->part, same ? painted->parts + 1 : 1);
    ck_assert_int_le(tile->part, PEN_JOB_TILE_PARTS);
    ck_assert_int_gt(tile->width, 0);
    ck_assert_int_gt(tile->height, 0);
    ck_assert(tile->x >= 0 && tile->y >= 0);
    ck_assert(tile->x + tile->width <= WIDTH && tile->y + tile->height <= HEIGHT);
    int view = strcmp(tile->view, "left") == 0 ? 0 : 1;
    ck_assert_str_eq(tile->view, view ? "right" : "left");
    for (int y = tile->y; y < tile->y + tile->height; y++)
        for (int x = tile->x; x < tile->x + tile->width; x++)
            painted->times[view][y * WIDTH + x]++;
    painted->parts = tile->part;
    painted->revision = tile->revision;
    if (painted->rectangles++ == 0)
        painted->first_revision = tile->revision;
    return --painted->left != 0;
}

static void list(struct jobs_bed *bed, const char *id, int64_t after, struct painted *painted)
{
    struct pen_status st;
    int left = painted->left;
    *painted = (struct painted){.left = left};
    store_must(pen_jobs_tiles(bed->jobs, id, after, paint, painted, &st), &st, "tiles");
}

static void submit(struct jobs_bed *bed, char id[PEN_ID_BYTES])
{
    jobs_submit(bed,
                "{\"format\": \"penumbra-scene/1\","
                " \"camera\": {\"position\": [0, 1, 10], \"look_at\": [0, 0, 0]},"
                " \"views\": [{\"name\": \"left\"}, {\"name\": \"right\"}],"
                " \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 2}],"
                " \"render\": {\"width\": 203, \"height\": 150, \"tile\": 14,"
                " \"samples_per_pixel\": 512}}",
                id);
}

START_TEST(test_tiles__cover_the_image_once)
{
    static struct jobs_bed bed;
    static struct painted painted;
    char id[PEN_ID_BYTES];
    jobs_bed_open(&bed);
    submit(&bed, id);
    list(&bed, id, 0, &painted);
    ck_assert_int_eq(painted.rectangles, 0);
    int batches = store_work_off(bed.bed.store, "w");
    ck_assert_int_gt(batches, 4);
    list(&bed, id, 0, &painted);
    ck_assert_int_gt(painted.rectangles, batches);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        ck_assert(painted.times[0][i] == 1 && painted.times[1][i] == 1);

    int all = painted.rectangles;
    list(&bed, id, painted.first_revision, &painted);
    ck_assert_int_lt(painted.rectangles, all);
    ck_assert_int_ge(painted.rectangles, all - PEN_JOB_TILE_PARTS);
    list(&bed, id, painted.revision, &painted);
    ck_assert_int_eq(painted.rectangles, 0);
    painted.left = 2;
    list(&bed, id, 0, &painted);
    ck_assert_int_eq(painted.rectangles, 2);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_tiles__of_an_unknown_job_are_not_found)
{
    static struct jobs_bed bed;
    static struct painted painted;
    struct pen_status st;
    jobs_bed_open(&bed);
    ck_assert(!pen_jobs_tiles(bed.jobs, "nobody", 0, paint, &painted, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("tiles of jobs", test_tiles__cover_the_image_once,
          test_tiles__of_an_unknown_job_are_not_found)
