/* SPDX-License-Identifier: MIT */
/* What a caller knows after a call: counts by state, a submit that is repeated, the class of a
 * failure; and content of more than one range of a blob. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/log.h"
#include "support/faults.h"
#include "support/random.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

static struct pen_counts counts(void)
{
    struct pen_counts now;
    struct pen_status st;
    store_must(pen_store_counts(bed.store, &now, &st), &st, "counts");
    return now;
}

static void expect_counts(const int64_t jobs[PEN_JOB_STATE_COUNT], int64_t open, int64_t leased)
{
    struct pen_counts now = counts();
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_msg(now.jobs[s] == jobs[s], "%s: %lld", pen_job_state_name((enum pen_job_state)s),
                      (long long)now.jobs[s]);
    ck_assert_int_eq(now.open_batches, open);
    ck_assert_int_eq(now.leased_batches, leased);
}

/* In the order of enum pen_job_state: queued, running, succeeded, failed, cancelled. */
START_TEST(test_outcomes__counts_follow_every_change_of_state)
{
    struct store_job in[3];
    struct pen_status st;
    store_bed_open(&bed);
    expect_counts((const int64_t[]){0, 0, 0, 0, 0}, 0, 0);
    for (int n = 0; n < 3; n++) {
        store_job_init(&in[n], n, 1, 2);
        store_job_submit(bed.store, &in[n]);
    }
    expect_counts((const int64_t[]){3, 0, 0, 0, 0}, 6, 0);
    struct pen_claim first = store_claim(bed.store, "w"), second = store_claim(bed.store, "w");
    expect_counts((const int64_t[]){2, 1, 0, 0, 0}, 4, 2);
    ck_assert_int_eq(store_commit(bed.store, &first), PEN_OK);
    ck_assert_int_eq(store_commit(bed.store, &second), PEN_OK);
    expect_counts((const int64_t[]){2, 1, 0, 0, 0}, 5, 0); /* with the assemble batch */
    first = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &first), PEN_OK);
    expect_counts((const int64_t[]){2, 0, 1, 0, 0}, 4, 0);
    first = store_claim(bed.store, "w");
    expect_counts((const int64_t[]){1, 1, 1, 0, 0}, 3, 1);
    store_must(pen_store_fail(bed.store, &first, "{}", &st), &st, "fail");
    expect_counts((const int64_t[]){1, 0, 1, 1, 0}, 2, 0);
    store_must(pen_store_cancel(bed.store, in[2].id, NULL, &st), &st, "cancel");
    expect_counts((const int64_t[]){0, 0, 1, 1, 1}, 0, 0);
    store_must(pen_store_delete(bed.store, in[0].id, NULL, NULL, &st), &st, "delete");
    expect_counts((const int64_t[]){0, 0, 0, 1, 1}, 0, 0);
    store_bed_close(&bed);
}
END_TEST

static bool submit(const struct store_job *in, enum pen_submit_result *result,
                   struct pen_status *st)
{
    struct pen_buf answer = {0};
    bool ok = pen_store_submit(bed.store, &in->job, result, &answer, st);
    ck_assert_uint_eq(answer.bytes, 0);
    pen_buf_release(&answer);
    return ok;
}

static void expect_known(const struct store_job *in)
{
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    struct pen_job_record before = store_job_get(bed.store, in->id);
    struct pen_status st;
    store_must(submit(in, &result, &st), &st, "submit again");
    ck_assert_int_eq(result, PEN_SUBMIT_KNOWN);
    struct pen_job_record after = store_job_get(bed.store, in->id);
    ck_assert_int_eq(after.state, before.state);
    ck_assert_int_eq(after.revision, before.revision);
    ck_assert_int_eq(after.number, before.number);
    pen_job_record_release(&before);
    pen_job_record_release(&after);
}

START_TEST(test_outcomes__submit_repeated_with_the_same_job_is_known)
{
    struct store_job in;
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    expect_known(&in);
    expect_counts((const int64_t[]){1, 0, 0, 0, 0}, 2, 0);
    struct pen_claim claim = store_claim(bed.store, "w");
    expect_known(&in);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_work_off(bed.store, "w");
    expect_known(&in);
    expect_counts((const int64_t[]){0, 0, 1, 0, 0}, 0, 0);
    store_bed_close(&bed);
}
END_TEST

/* The caller takes another id; nothing of the refused job stays, nor its scene document. */
static void expect_conflict(const struct store_job *in)
{
    enum pen_submit_result result;
    struct pen_status st = {0};
    ck_assert(!submit(in, &result, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    expect_counts((const int64_t[]){1, 0, 0, 0, 0}, 2, 0);
    store_audit_clean(bed.store);
}

START_TEST(test_outcomes__submit_of_another_job_with_the_id_is_a_conflict)
{
    static const unsigned char body[32] = {1};
    struct store_job first, other;
    struct pen_buf scene = {0};
    struct pen_status st;
    store_bed_open(&bed);
    store_job_init(&first, 1, 1, 2);
    store_job_submit(bed.store, &first);
    store_job_init(&other, 1, 1, 1);
    other.job.request = "{\"name\": \"other\"}";
    expect_conflict(&other);
    store_job_init(&other, 1, 1, 1);
    other.job.kind = "effects";
    expect_conflict(&other);
    store_job_init(&other, 1, 1, 1);
    other.sha256[5] = 7;
    other.job.scene = "{\"scene\": \"other\"}";
    other.job.scene_bytes = strlen(other.job.scene);
    other.job.idempotency_key = "k"; /* the key is not kept either */
    other.job.body_sha256 = body;
    other.job.answer = "{}";
    expect_conflict(&other);
    memcpy(other.id, "02", 2);
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    store_must(submit(&other, &result, &st), &st, "submit");
    ck_assert_int_eq(result, PEN_SUBMIT_CREATED);
    store_must(pen_store_scene(bed.store, first.id, &scene, &st), &st, "scene");
    ck_assert_str_eq((const char *)scene.data, first.scene);
    pen_buf_release(&scene);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_outcomes__refused_calls_have_done_nothing_and_will_not)
{
    struct store_job in;
    struct pen_status st = {0};
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    ck_assert(!pen_store_cancel(bed.store, "nobody", NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    ck_assert(!pen_store_delete(bed.store, in.id, NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert(!pen_store_estimate(bed.store, &claim, 1, NULL, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    ck_assert(!pen_store_progress(bed.store, &claim, 1, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    store_bed_close(&bed);
}
END_TEST

static void open_faulty(void)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install();
    store_bed_open(&bed);
}

static void break_disk(enum fault_call call, int error)
{
    faults_arm(&(struct fault_plan){.calls = call, .mode = FAULT_FROM, .n = 1, .error = error});
}

/* Repeats a call while it fails as one that may be tried again, for 90 s: a store tries to recover
 * again within a minute, however long its last try took. */
#define REPEAT(call)                                                                               \
    for (int tries = 0; !(call); tries++) {                                                        \
        ck_assert_msg(tries < 4500, "%s", st.msg);                                                 \
        ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_RETRY);                    \
        nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);                                  \
    }

START_TEST(test_outcomes__full_disk_is_worth_another_try)
{
    struct store_job in;
    struct pen_job_record job;
    struct pen_status st = {0};
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    open_faulty();
    store_job_init(&in, 1, 1, 1);
    break_disk(FAULT_WRITE, ENOSPC);
    ck_assert(!submit(&in, &result, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_RETRY);
    ck_assert(!submit(&in, &result, &st)); /* refused before it is tried */
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_RETRY);
    ck_assert_int_gt(faults_disarm(), 0);
    ck_assert(!pen_store_job(bed.store, in.id, &job, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    REPEAT(submit(&in, &result, &st));
    ck_assert_int_eq(result, PEN_SUBMIT_CREATED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_outcomes__submit_of_unknown_outcome_is_repeated)
{
    struct store_job in;
    struct pen_job_record job;
    struct pen_status st = {0};
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    open_faulty();
    store_job_init(&in, 1, 1, 2);
    break_disk(FAULT_SYNC, EIO);
    ck_assert(!submit(&in, &result, &st));
    ck_assert_int_gt(faults_disarm(), 0);
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_UNKNOWN);
    ck_assert(!pen_store_job(bed.store, "nobody", &job, &st)); /* the class is the last call's */
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    REPEAT(submit(&in, &result, &st));
    ck_assert(result == PEN_SUBMIT_CREATED || result == PEN_SUBMIT_KNOWN);
    expect_counts((const int64_t[]){1, 0, 0, 0, 0}, 2, 0);
    store_bed_close(&bed);
}
END_TEST

static bool commit(const struct pen_claim *claim, struct pen_status *st)
{
    static const float rgb[STORE_JOB_TILE * STORE_JOB_TILE * 3];
    struct pen_result result = {.rgb = rgb, .pixels = claim->pixels, .stats = "{}"};
    return pen_store_commit(bed.store, claim, &result, st);
}

START_TEST(test_outcomes__commit_of_unknown_outcome_is_repeated)
{
    struct store_job in;
    struct pen_status st = {0};
    open_faulty();
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    struct pen_claim claim = store_claim(bed.store, "w");
    break_disk(FAULT_SYNC, EIO);
    ck_assert(!commit(&claim, &st));
    ck_assert_int_gt(faults_disarm(), 0);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_UNKNOWN);
    REPEAT(commit(&claim, &st));
    ck_assert(commit(&claim, &st)); /* a duplicate */
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.done_pixels, 16);
    pen_job_record_release(&job);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 2);
    store_bed_close(&bed);
}
END_TEST

enum { MIB = 1 << 20, LARGEST = 3 * MIB + 11 };
static unsigned char noise[LARGEST];

static void make_noise(uint64_t seed)
{
    struct random random = random_begin(seed);
    for (size_t i = 0; i < sizeof noise; i++)
        noise[i] = (unsigned char)random_bits(&random);
}

START_TEST(test_outcomes__large_scene_documents_are_given_back)
{
    static const size_t sizes[] = {MIB - 40, MIB, 2 * MIB + 1, LARGEST}; /* hardly compressed */
    struct pen_status st;
    store_bed_open(&bed);
    for (int i = 0; i < 4; i++) {
        struct store_job in;
        struct pen_buf scene = {0};
        make_noise((uint64_t)i);
        store_job_init(&in, i, 1, 1);
        in.job.scene = noise;
        in.job.scene_bytes = sizes[i];
        store_job_submit(bed.store, &in);
        store_must(pen_store_scene(bed.store, in.id, &scene, &st), &st, "scene");
        ck_assert_uint_eq(scene.bytes, sizes[i]);
        ck_assert_mem_eq(scene.data, noise, sizes[i]);
        pen_buf_release(&scene);
    }
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_outcomes__large_artefacts_are_given_back)
{
    static const size_t sizes[] = {MIB - 1, MIB, MIB + 1, 2 * MIB, LARGEST, 5};
    struct store_job in;
    struct pen_status st;
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 1);
    store_job_submit(bed.store, &in);
    for (int i = 0; i < 6; i++) { /* each in the place of the one before */
        struct pen_buf got = {0};
        make_noise((uint64_t)(10 + i));
        store_put(bed.store, &(struct store_artefact){in.id, 0, "beauty", "pfm", noise, sizes[i]});
        store_must(pen_store_artefact(bed.store, in.id, 0, "beauty", "pfm", &got, &st), &st, "get");
        ck_assert_uint_eq(got.bytes, sizes[i]);
        ck_assert_mem_eq(got.data, noise, sizes[i]);
        pen_buf_release(&got);
    }
    store_bed_close(&bed);
}
END_TEST

enum { EDGE = 500, LARGE_PIXELS = EDGE * EDGE };
static float large[LARGE_PIXELS * 3];

static bool compare_pixels(void *user, int first_tile, int tile_count, const float *rgb,
                           int64_t pixels)
{
    (void)first_tile;
    (void)tile_count;
    ck_assert_int_eq(pixels, LARGE_PIXELS);
    ck_assert_mem_eq(rgb, large, sizeof large);
    ++*(int *)user;
    return true;
}

START_TEST(test_outcomes__large_batches_of_pixels_are_given_back)
{
    struct random random = random_begin(20);
    struct store_job in;
    struct pen_status st;
    struct pen_result result = {.rgb = large,
                                .pixels = LARGE_PIXELS,
                                .stats = "{}",
                                .layer = "beauty",
                                .format = "png",
                                .artefact = noise,
                                .artefact_bytes = LARGEST};
    int batches = 0;
    make_noise(21);
    for (int i = 0; i < LARGE_PIXELS * 3; i++)
        large[i] = (float)random_unit(&random);
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 1);
    in.view[0].width = in.view[0].height = EDGE;
    in.batch[0].pixels = LARGE_PIXELS;
    store_job_submit(bed.store, &in);
    struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_commit(bed.store, &claim, &result, &st), &st, "commit");
    store_must(pen_store_pixels(bed.store, in.id, 0, compare_pixels, &batches, &st), &st, "pixels");
    ck_assert_int_eq(batches, 1);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store outcomes", test_outcomes__counts_follow_every_change_of_state,
          test_outcomes__submit_repeated_with_the_same_job_is_known,
          test_outcomes__submit_of_another_job_with_the_id_is_a_conflict,
          test_outcomes__refused_calls_have_done_nothing_and_will_not,
          test_outcomes__full_disk_is_worth_another_try,
          test_outcomes__submit_of_unknown_outcome_is_repeated,
          test_outcomes__commit_of_unknown_outcome_is_repeated,
          test_outcomes__large_scene_documents_are_given_back,
          test_outcomes__large_artefacts_are_given_back,
          test_outcomes__large_batches_of_pixels_are_given_back)
