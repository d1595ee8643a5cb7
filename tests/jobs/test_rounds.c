/* SPDX-License-Identifier: MIT */
/* Jobs with a target error. When their worker dies, the next worker continues from the kept state,
 * also within a round. A job of higher priority comes between two rounds or tiles. */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "render/adaptive_state.h"
#include "study/host.h"
#include "support/jobs.h"
#include "support/random.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES], other[PEN_ID_BYTES];

static const char lengthy[] =
    "{\"scene\": \"builtin:lens\", \"views\": [\"middle\"], \"render\": {\"width\": 64,"
    " \"height\": 48, \"tile\": 8, \"target_error\": 0.003, \"max_samples\": 65536}}";
enum { WIDTH = 64, HEIGHT = 48, TILE = 8 };
static const char urgent[] = "{\"scene\": \"builtin:spheres\", \"priority\": 5,"
                             " \"render\": {\"width\": 16, \"height\": 12}}";

/* The pixels of the job when it is done. */
static struct pen_buf finish(void)
{
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(!jobs_has_kept(&bed, id, PEN_KEPT_STATE)); /* is of no more use */
    return jobs_image(&bed, id, "middle", "pfm");
}

static struct pen_buf whole_picture(void)
{
    jobs_submit(&bed, lengthy, id);
    return finish();
}

/* The interrupted job gives the same picture as one that is not interrupted. */
static void check_finished_picture(void)
{
    struct pen_buf picture = finish(), whole = whole_picture();
    ck_assert_uint_eq(picture.bytes, whole.bytes);
    ck_assert_mem_eq(picture.data, whole.data, whole.bytes);
    pen_buf_release(&picture);
    pen_buf_release(&whole);
}

START_TEST(test_rounds__killed_worker_loses_no_round_that_is_kept)
{
    struct pen_buf state = jobs_begin_and_kill(&bed, lengthy, id, PEN_KEPT_STATE, NULL);
    pen_buf_release(&state);
    jobs_worker_start(&bed);
    check_finished_picture();
    jobs_bed_close(&bed);
}
END_TEST

/* A state that has been changed changes the picture, so it is what the next worker goes on with;
 * one that is not whole is not used. */
START_TEST(test_rounds__next_worker_goes_on_with_what_is_kept)
{
    for (int cut = 0; cut < 2; cut++) {
        struct pen_buf state = jobs_begin_and_kill(&bed, lengthy, id, PEN_KEPT_STATE, NULL);
        /* The last pixel's first sum comes before the pixels' marks. */
        double *red = (double *)(void *)(state.data + state.bytes - WIDTH * HEIGHT - 64);
        *red += 0.01;
        jobs_put_kept(&bed, id, PEN_KEPT_STATE, state.data, state.bytes - (size_t)cut);
        pen_buf_release(&state);
        jobs_worker_start(&bed);
        struct pen_buf picture = finish(), whole = whole_picture();
        ck_assert_uint_eq(picture.bytes, whole.bytes);
        ck_assert((memcmp(picture.data, whole.data, whole.bytes) == 0) == (cut == 1));
        pen_buf_release(&picture);
        pen_buf_release(&whole);
        jobs_bed_close(&bed);
    }
}
END_TEST

/* Workers of a test wait at gates: before the pixels of the third row of tiles and of the last,
 * until that gate is open. They are closed again in each process that is forked. */
enum gate { NO_GATE, MIDDLE_GATE, LAST_GATE };
static atomic_int open_gate, at_gate, pixels_begun;
static int free_pixels; /* that pass all gates first */

static bool wants_gates(void *user, const char *job_name)
{
    (void)user;
    (void)job_name;
    return true;
}

static bool pass_gates(void *user, int x, int y)
{
    const int row = y / TILE;
    const int gate = row >= HEIGHT / TILE - 1 ? LAST_GATE : row >= 2 ? MIDDLE_GATE : NO_GATE;
    (void)user;
    (void)x;
    if (atomic_fetch_add(&pixels_begun, 1) < free_pixels)
        return true;
    /* What comes before the gates takes longer than a worker waits until it keeps its state. */
    if (gate == NO_GATE && atomic_load(&open_gate) == NO_GATE)
        usleep((useconds_t)(20 * random_fewer()));
    while (gate > atomic_load(&open_gate)) {
        atomic_store(&at_gate, gate);
        usleep(1000);
    }
    return true;
}

static const struct pen_worker_fault gates = {.wanted = wants_gates, .pixel = pass_gates};

static void wait_for_gate(enum gate gate)
{
    for (int i = 0; i < 60000 && atomic_load(&at_gate) < (int)gate; i++)
        usleep(1000);
    ck_assert_int_eq(atomic_load(&at_gate), gate);
}

/* What a state tells of the rounds. */
static struct pen_adaptive_stats rounds_of(const struct pen_buf *state)
{
    struct pen_settings settings = pen_settings_default();
    settings.width = WIDTH;
    settings.height = HEIGHT;
    settings.tile = TILE;
    settings.target_error = 0.003;
    struct pen_status st;
    struct pen_adaptive *adaptive = pen_adaptive_new(&settings, &st);
    struct pen_render_stats stats;
    float *rgb = calloc((size_t)3 * WIDTH * HEIGHT, sizeof *rgb);
    json_t *host = pen_host_json();
    const char *build = json_string_value(json_object_get(host, "build"));
    store_must(pen_adaptive_load(adaptive, state->data, state->bytes, build, &stats, rgb, &st), &st,
               "load");
    json_decref(host);
    free(rgb);
    free(stats.tile_ms);
    pen_adaptive_free(adaptive);
    return stats.adaptive;
}

/* A state that was kept within a round, when some tiles were done and not the last row. */
static void assert_within_round(const struct pen_buf *state, int round)
{
    const struct pen_adaptive_stats a = rounds_of(state);
    ck_assert_int_eq(a.rounds, round);
    ck_assert_int_gt(a.round[round].tiles, 0);
    ck_assert_int_le(a.round[round].tiles, WIDTH / TILE * (HEIGHT / TILE - 1));
}

/* How many pixels the job tells that it has done. */
static int pixels_done(void)
{
    json_t *job = jobs_get(&bed, id), *progress = json_object_get(job, "progress");
    const int done = (int)json_integer_value(json_object_get(progress, "done"));
    ck_assert_int_eq(json_integer_value(json_object_get(progress, "total")), WIDTH * HEIGHT);
    json_decref(job);
    return done;
}

/* If the next worker began the round again, tiles that are done would get other samples; if it did
 * not use the state, a change of that would not be seen. */
START_TEST(test_rounds__worker_killed_within_a_round_goes_on_inside_it)
{
    for (int changed = 0; changed < 2; changed++) {
        bed.fault = &gates;
        struct pen_buf state = jobs_begin_and_kill(&bed, lengthy, id, PEN_KEPT_STATE, NULL);
        assert_within_round(&state, 0);
        if (changed)
            *(double *)(void *)(state.data + state.bytes - WIDTH * HEIGHT - 64) += 0.01;
        jobs_put_kept(&bed, id, PEN_KEPT_STATE, state.data, state.bytes);
        pen_buf_release(&state);
        bed.fault = NULL;
        jobs_worker_start(&bed);
        struct pen_buf picture = finish(), whole = whole_picture();
        ck_assert_uint_eq(picture.bytes, whole.bytes);
        ck_assert((memcmp(picture.data, whole.data, whole.bytes) == 0) == !changed);
        pen_buf_release(&picture);
        pen_buf_release(&whole);
        jobs_bed_close(&bed);
    }
}
END_TEST

static void check_between_two_tiles(int round)
{
    free_pixels = round * WIDTH * HEIGHT; /* the first round takes all */
    atomic_store(&pixels_begun, 0);
    atomic_store(&open_gate, NO_GATE);
    atomic_store(&at_gate, NO_GATE);
    bed.fault = &gates;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, lengthy, id);
    wait_for_gate(MIDDLE_GATE);
    jobs_submit(&bed, urgent, other);
    usleep(600000); /* a worker looks for such jobs every half second */
    atomic_store(&open_gate, MIDDLE_GATE);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    struct pen_buf state = jobs_wait_kept(&bed, id, PEN_KEPT_STATE);
    assert_within_round(&state, round);
    pen_buf_release(&state);
    ck_assert((pixels_done() > 0) == (round > 0));
    ck_assert_int_lt(pixels_done(), WIDTH * HEIGHT);
    atomic_store(&open_gate, LAST_GATE);
    check_finished_picture();
    ck_assert_int_eq(pixels_done(), WIDTH * HEIGHT);
    jobs_bed_close(&bed);
    bed.fault = NULL;
}

START_TEST(test_rounds__job_of_higher_priority_comes_between_two_tiles)
{
    check_between_two_tiles(0);
    check_between_two_tiles(1);
}
END_TEST

START_TEST(test_rounds__job_of_higher_priority_comes_between_two_rounds)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, lengthy, id);
    struct pen_buf state = jobs_wait_kept(&bed, id, PEN_KEPT_STATE);
    pen_buf_release(&state);
    jobs_submit(&bed, urgent, other);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    struct pen_buf picture = finish();
    pen_buf_release(&picture);
    ck_assert(jobs_did_not_wait(&bed, other, id));
    check_finished_picture();
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_rounds__that_take_longer_than_allowed_end)
{
    static const char endless[] =
        "{\"scene\": \"builtin:lens\", \"views\": [\"middle\"], \"render\": {\"width\": 64,"
        " \"height\": 48, \"tile\": 8, \"target_error\": 0.0001, \"max_samples\": 65536}}";
    jobs_bed_open(&bed);
    bed.max_seconds = 1;
    jobs_worker_start(&bed);
    jobs_submit(&bed, endless, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    json_t *job = jobs_get(&bed, id);
    const char *detail =
        json_string_value(json_object_get(json_object_get(job, "error"), "detail"));
    ck_assert_ptr_nonnull(detail);
    ck_assert_ptr_nonnull(strstr(detail, "not done after the 1 s that this daemon allows"));
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

/* A job with a budget gives way as one with a target does, and has used up what it had rendered. */
START_TEST(test_rounds__budget_gives_way_and_goes_on_with_the_rest)
{
    static const char timed[] =
        "{\"scene\": \"builtin:lens\", \"views\": [\"middle\"], \"budget_seconds\": 4,"
        " \"render\": {\"width\": 64, \"height\": 48, \"tile\": 8, \"max_samples\": 65536}}";
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, timed, id);
    struct pen_buf state = jobs_wait_kept(&bed, id, PEN_KEPT_STATE);
    pen_buf_release(&state);
    usleep(2000000);
    jobs_submit(&bed, urgent, other);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(jobs_did_not_wait(&bed, other, id));
    struct pen_status st;
    json_t *stats = pen_jobs_stats(bed.jobs, id, &st);
    double render_ms;
    ck_assert_int_eq(json_unpack(stats, "{s:{s:F}}", "timing", "render_ms", &render_ms), 0);
    json_decref(stats);
    ck_assert_double_gt(render_ms, 2000);
    ck_assert_timed(render_ms < 5500); /* 6000 if it had begun anew */
    jobs_bed_close(&bed);
}
END_TEST

/* What it has spent on giving way may come above what is allowed. */
START_TEST(test_rounds__budget_that_is_allowed_is_not_expected_to_take_too_long)
{
    jobs_bed_open(&bed);
    jobs_submit(&bed,
                "{\"scene\": \"builtin:spheres\", \"budget_seconds\": 0.5,"
                " \"render\": {\"width\": 16, \"height\": 12}}",
                id);
    store_run_sql(&bed.bed, "UPDATE job SET spent_us = 20000000, done_pixels = total_pixels / 2",
                  NULL, 0);
    bed.max_seconds = 12;
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("rounds", test_rounds__killed_worker_loses_no_round_that_is_kept,
          test_rounds__next_worker_goes_on_with_what_is_kept,
          test_rounds__worker_killed_within_a_round_goes_on_inside_it,
          test_rounds__job_of_higher_priority_comes_between_two_rounds,
          test_rounds__job_of_higher_priority_comes_between_two_tiles,
          test_rounds__that_take_longer_than_allowed_end,
          test_rounds__budget_that_is_allowed_is_not_expected_to_take_too_long,
          test_rounds__budget_gives_way_and_goes_on_with_the_rest)
