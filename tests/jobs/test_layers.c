/* SPDX-License-Identifier: MIT */
/* Layers of jobs: made in the batches of their tiles, or after the rounds of a view with a target
 * error; put together from parts, kept across a worker's death, and interrupted by jobs of higher
 * priority. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "film/film.h"
#include "render/adaptive_state.h"
#include "study/host.h"
#include "support/jobs.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES], other[PEN_ID_BYTES];

static const char *const names[] = {"cost", "samples", "depth", "normal", "albedo"};
enum { LAYERS = sizeof names / sizeof names[0] };

static const char all[] =
    "{\"scene\": \"builtin:glass\", \"layers\": [\"beauty\", \"cost\", \"samples\", \"depth\","
    " \"normal\", \"albedo\"], \"cost\": \"tests\", \"render\": {\"width\": 61, \"height\": 45,"
    " \"tile\": 12}}";
static const char urgent[] = "{\"scene\": \"builtin:spheres\", \"priority\": 5,"
                             " \"render\": {\"width\": 16, \"height\": 12}}";

static int count_of(const char *sql)
{
    return store_number(bed.bed.url, sql);
}

static struct pen_buf layer_of(const char *job, const char *layer)
{
    struct pen_image_query query = {.layer = layer, .format = "pfm"};
    struct pen_image image;
    struct pen_status st;
    store_must(pen_jobs_image(bed.jobs, job, &query, &image, &st), &st, layer);
    return image.bytes;
}

static void check_same(const char *layer)
{
    struct pen_buf one = layer_of(id, layer), two = layer_of(other, layer);
    ck_assert_uint_eq(one.bytes, two.bytes);
    ck_assert_msg(memcmp(one.data, two.data, one.bytes) == 0, "%s differs", layer);
    pen_buf_release(&one);
    pen_buf_release(&two);
}

/* Both jobs have the same picture and layers, and nothing is left of the parts. */
static void check_same_layers(void)
{
    check_same("beauty");
    for (int i = 0; i < LAYERS; i++)
        check_same(names[i]);
    ck_assert_int_eq(
        count_of("SELECT count(*) FROM object WHERE layer LIKE 'kept:%' AND state = 1"), 0);
}

static int render_batches(void)
{
    return count_of("SELECT count(*) FROM batch WHERE kind = 0");
}

/* Makes the job in one batch. */
static void make_whole(char job[PEN_ID_BYTES])
{
    const int before = render_batches();
    bed.batch_ms = 0;
    jobs_worker_start(&bed);
    jobs_submit(&bed, all, job);
    ck_assert_int_eq(jobs_wait(&bed, job), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    ck_assert_int_eq(render_batches(), before + 1);
}

/* A worker that has a millisecond for a batch makes a few tiles in each. */
START_TEST(test_layers__many_batches_make_the_same_as_one)
{
    jobs_bed_open(&bed);
    make_whole(other);
    bed.batch_ms = 1;
    jobs_worker_start(&bed);
    jobs_submit(&bed, all, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    ck_assert_int_gt(render_batches(), 3);
    check_same_layers();
    jobs_bed_close(&bed);
}
END_TEST

/* Batches of a job with these layers, of which a worker has 3 ms for each. */
static int batches_of(const char *layers)
{
    char body[400];
    const int before = render_batches();
    snprintf(body, sizeof body,
             "{\"scene\": \"builtin:glass\", \"layers\": [%s], \"cost\": \"tests\","
             " \"render\": {\"width\": 128, \"height\": 96, \"tile\": 8}}",
             layers);
    jobs_submit(&bed, body, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    return render_batches() - before;
}

/* The first layer decides how many tiles a batch has: no other one throws away what that has made.
 */
START_TEST(test_layers__more_layers_do_not_cut_batches_again)
{
    jobs_bed_open(&bed);
    bed.batch_ms = 3;
    jobs_worker_start(&bed);
    const int alone = batches_of("\"cost\""),
              with_others = batches_of("\"cost\", \"depth\", \"normal\"");
    ck_assert_int_gt(alone, 1);
    ck_assert_msg(with_others <= 3 * alone + 5, "%d batches instead of %d", with_others, alone);
    jobs_bed_close(&bed);
}
END_TEST

static void stop_after_batches(const char *body, int batches)
{
    const int before = count_of("SELECT count(*) FROM batch WHERE kind = 0 AND state = 2");
    bed.batch_ms = 1;
    jobs_worker_start(&bed);
    jobs_submit(&bed, body, id);
    while (count_of("SELECT count(*) FROM batch WHERE kind = 0 AND state = 2") < before + batches)
        ck_assert(!pen_job_state_ended(store_job_state(bed.bed.store, id)));
    jobs_worker_stop(&bed);
    ck_assert(!pen_job_state_ended(store_job_state(bed.bed.store, id)));
}

static void finish(void)
{
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
}

/* Parts that are missing, as of batches that an earlier version has rendered, or not whole. */
START_TEST(test_layers__parts_that_cannot_be_used_are_rendered_again)
{
    static const char *const harms[] = {
        "UPDATE object SET state = 2 WHERE layer LIKE 'kept:%'",
        "UPDATE object SET state = 2 WHERE layer LIKE 'kept:%' AND layer NOT LIKE '%-0'"};
    for (int i = 0; i < 3; i++) {
        jobs_bed_open(&bed);
        make_whole(other);
        stop_after_batches(all, 2);
        ck_assert(jobs_has_kept(&bed, id, "cost-0"));
        if (i < 2)
            store_run_sql(&bed.bed, harms[i], NULL, 0);
        else
            jobs_put_kept(&bed, id, "cost-0", "\xff\xff\xff\xff****", 8);
        finish();
        check_same_layers();
        jobs_bed_close(&bed);
    }
}
END_TEST

/* A part that is changed changes the layer: so it is what the layer is made from. */
START_TEST(test_layers__batches_that_are_done_are_not_made_again)
{
    jobs_bed_open(&bed);
    make_whole(other);
    stop_after_batches(all, 2);
    struct pen_buf part = jobs_wait_kept(&bed, id, "cost-0");
    const float value = 12345;
    memcpy(part.data + 2 * sizeof(uint32_t), &value, sizeof value);
    jobs_put_kept(&bed, id, "cost-0", part.data, part.bytes);
    pen_buf_release(&part);
    finish();
    struct pen_buf layer = layer_of(id, "cost"), whole = layer_of(other, "cost");
    const size_t top_left = layer.bytes - (size_t)61 * 3 * sizeof(float);
    float found;
    memcpy(&found, layer.data + top_left, sizeof found);
    ck_assert_float_eq(found, value);
    memcpy(layer.data + top_left, whole.data + top_left, 3 * sizeof found);
    ck_assert_mem_eq(layer.data, whole.data, whole.bytes);
    pen_buf_release(&layer);
    pen_buf_release(&whole);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_layers__cancel_drops_the_parts)
{
    struct pen_job_snapshot snapshot;
    struct pen_status st;
    jobs_bed_open(&bed);
    stop_after_batches(all, 2);
    ck_assert(jobs_has_kept(&bed, id, "cost-0"));
    store_must(pen_jobs_cancel(bed.jobs, id, NULL, &snapshot, &st), &st, "cancel");
    json_decref(snapshot.json);
    ck_assert_int_eq(
        count_of("SELECT count(*) FROM object WHERE layer LIKE 'kept:%' AND state = 1"), 0);
    jobs_bed_close(&bed);
}
END_TEST

/* The map of costs takes several times as long as the picture; both are made batch by batch, so
 * that a job of higher priority waits for one batch at most. */
START_TEST(test_layers__job_of_higher_priority_comes_between_two_batches)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed,
                "{\"scene\": \"builtin:room\", \"layers\": [\"beauty\", \"cost\"],"
                " \"render\": {\"width\": 240, \"height\": 240, \"samples_per_pixel\": 16}}",
                id);
    ck_assert_int_ge(render_batches(), 3);
    while (count_of("SELECT count(*) FROM batch WHERE kind = 0 AND state = 2") < 1)
        ck_assert(!pen_job_state_ended(store_job_state(bed.bed.store, id)));
    jobs_submit(&bed, urgent, other);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(jobs_did_not_wait(&bed, other, id));
    jobs_bed_close(&bed);
}
END_TEST

static const char lengthy[] =
    "{\"scene\": \"builtin:lens\", \"views\": [\"middle\"], \"layers\": [\"beauty\", \"cost\","
    " \"samples\"], \"cost\": \"tests\", \"render\": {\"width\": 64, \"height\": 48, \"tile\": 8,"
    " \"target_error\": 0.01, \"max_samples\": 65536}}";
enum { WIDTH = 64, HEIGHT = 48, TILE = 8 };

/* Whether a state is what the last round has left, which is kept with the first tiles of a layer.
 */
static bool has_ended(const struct pen_buf *state)
{
    struct pen_settings settings = pen_settings_default();
    settings.width = WIDTH;
    settings.height = HEIGHT;
    settings.tile = TILE;
    settings.target_error = 0.01;
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
    return stats.adaptive.ended;
}

static void check_rounds_layers(void)
{
    jobs_submit(&bed, lengthy, other);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    check_same("beauty");
    check_same("cost");
    check_same("samples");
}

static json_t *stats_of(const char *job)
{
    struct pen_status st;
    json_t *stats = pen_jobs_stats(bed.jobs, job, &st);
    ck_assert_ptr_nonnull(stats);
    return stats;
}

/* The rounds are not made again, and their statistics are those of a job that nothing interrupts.
 */
START_TEST(test_layers__worker_killed_after_the_rounds_goes_on_with_the_layer)
{
    for (int changed = 0; changed < 2; changed++) {
        struct pen_buf state = jobs_begin_and_kill(&bed, lengthy, id, PEN_KEPT_STATE, has_ended);
        pen_buf_release(&state);
        struct pen_buf part = jobs_wait_kept(&bed, id, "cost-0");
        const float value = 12345;
        if (changed) {
            memcpy(part.data + 2 * sizeof(uint32_t), &value, sizeof value);
            jobs_put_kept(&bed, id, "cost-0", part.data, part.bytes);
        }
        pen_buf_release(&part);
        jobs_worker_start(&bed);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        ck_assert(!jobs_has_kept(&bed, id, PEN_KEPT_STATE));
        ck_assert(!jobs_has_kept(&bed, id, "cost-0"));
        if (changed) {
            struct pen_buf layer = layer_of(id, "cost");
            float found;
            memcpy(&found, layer.data + layer.bytes - (size_t)WIDTH * 3 * sizeof found,
                   sizeof found);
            ck_assert_float_eq(found, value);
            pen_buf_release(&layer);
        } else {
            check_rounds_layers();
            json_t *one = stats_of(id), *two = stats_of(other);
            static const char *const same[] = {"rays", "adaptive", "kernel", "effects"};
            for (int i = 0; i < 4; i++)
                ck_assert_msg(
                    json_equal(json_object_get(one, same[i]), json_object_get(two, same[i])), "%s",
                    same[i]);
            json_decref(one);
            json_decref(two);
        }
        jobs_bed_close(&bed);
    }
}
END_TEST

START_TEST(test_layers__job_of_higher_priority_comes_between_tiles_after_the_rounds)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, lengthy, id);
    struct pen_buf part = jobs_wait_kept(&bed, id, "cost-0");
    pen_buf_release(&part);
    jobs_submit(&bed, urgent, other);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    json_t *job = jobs_get(&bed, id), *progress = json_object_get(job, "progress");
    const double done = json_number_value(json_object_get(progress, "fraction"));
    json_decref(job);
    ck_assert_double_gt(done, 0.25); /* the rounds are a quarter, with the tests of the pixels */
    ck_assert_double_lt(done, 1);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(jobs_did_not_wait(&bed, other, id));
    check_rounds_layers();
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("layers", test_layers__many_batches_make_the_same_as_one,
          test_layers__more_layers_do_not_cut_batches_again,
          test_layers__parts_that_cannot_be_used_are_rendered_again,
          test_layers__batches_that_are_done_are_not_made_again,
          test_layers__cancel_drops_the_parts,
          test_layers__job_of_higher_priority_comes_between_two_batches,
          test_layers__worker_killed_after_the_rounds_goes_on_with_the_layer,
          test_layers__job_of_higher_priority_comes_between_tiles_after_the_rounds)
