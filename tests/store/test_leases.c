/* SPDX-License-Identifier: MIT */
/* Claims and what a worker does under them: their order, fences, duplicates, expired leases,
 * pictures, progress. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

static void open_with_job(struct store_job *job, int views, int batches)
{
    store_bed_open(&bed);
    store_job_init(job, 1, views, batches);
    store_job_submit(bed.store, job);
}

static void sleep_ms(int ms)
{
    struct timespec pause = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    nanosleep(&pause, NULL);
}

static struct pen_claim claim_for(const char *worker, int64_t lease_ms)
{
    struct pen_status st;
    struct pen_claim claim;
    bool found = false;
    store_must(pen_store_claim(bed.store, worker, lease_ms, &claim, &found, &st), &st, "claim");
    ck_assert(found);
    return claim;
}

static int expire(const char *dead_worker)
{
    struct pen_status st;
    int opened = -1;
    store_must(pen_store_expire_leases(bed.store, dead_worker, &opened, &st), &st, "expire");
    return opened;
}

static bool held(struct pen_claim *claim)
{
    struct pen_status st;
    bool answer = false;
    store_must(pen_store_heartbeat(bed.store, claim, 60000, &answer, &st), &st, "heartbeat");
    return answer;
}

START_TEST(test_leases__claim_describes_its_batch)
{
    struct store_job in;
    store_bed_open(&bed);
    store_job_init(&in, 3, 2, 2);
    in.job.timeout_ms = 7000;
    store_job_submit(bed.store, &in);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(claim.attempt, 1);
    ck_assert_int_eq(claim.kind, PEN_BATCH_RENDER);
    ck_assert_str_eq(claim.job_id, in.id);
    ck_assert_int_eq(claim.view, 0);
    ck_assert_int_eq(claim.first_tile, 0);
    ck_assert_int_eq(claim.tile_count, 1);
    ck_assert_int_eq(claim.pixels, 16);
    ck_assert_int_eq(claim.view_batches, 2);
    ck_assert_mem_eq(claim.scene_sha256, in.sha256, 32);
    ck_assert_int_eq(claim.submitted_ms, in.job.created_ms);
    ck_assert_int_eq(claim.started_ms, claim.claimed_ms);
    ck_assert_int_eq(claim.timeout_ms, 7000);
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_RUNNING);
    ck_assert_int_eq(job.started_ms, claim.claimed_ms);
    ck_assert_int_eq(job.revision, 2);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    sleep_ms(5);
    struct pen_claim next = store_claim(bed.store, "w");
    ck_assert_int_eq(next.first_tile, 1);
    ck_assert_int_eq(next.started_ms, claim.started_ms);
    ck_assert_int_gt(next.claimed_ms, claim.claimed_ms);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__larger_priority_first_then_older_jobs)
{
    static const int priority[5] = {0, -5, 7, 0, 7};
    static const int order[5] = {2, 4, 0, 3, 1};
    store_bed_open(&bed);
    struct store_job in[5];
    for (int n = 0; n < 5; n++) {
        store_job_init(&in[n], n, 1, 2);
        in[n].job.priority = priority[n];
        store_job_submit(bed.store, &in[n]);
    }
    for (int i = 0; i < 10; i++) {
        struct pen_claim claim = store_claim(bed.store, "w");
        ck_assert_str_eq(claim.job_id, in[order[i / 2]].id);
        ck_assert_int_eq(claim.first_tile, i % 2);
    }
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__assemble_batch_comes_before_younger_jobs)
{
    store_bed_open(&bed);
    struct store_job old, young;
    store_job_init(&old, 1, 1, 2);
    store_job_init(&young, 2, 1, 2);
    store_job_submit(bed.store, &old);
    store_job_submit(bed.store, &young);
    for (int i = 0; i < 2; i++) {
        struct pen_claim claim = store_claim(bed.store, "w");
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    }
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(claim.kind, PEN_BATCH_ASSEMBLE);
    ck_assert_str_eq(claim.job_id, old.id);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__nothing_to_claim_is_no_error)
{
    store_bed_open(&bed);
    struct pen_status st;
    struct pen_claim claim;
    bool found = true;
    store_must(pen_store_claim(bed.store, "w", 1000, &claim, &found, &st), &st, "claim");
    ck_assert(!found);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__stale_attempt_is_refused_and_changes_nothing)
{
    struct store_job in;
    open_with_job(&in, 1, 2);
    struct pen_claim slow = claim_for("slow", 1);
    sleep_ms(10);
    ck_assert_int_eq(expire(NULL), 1);
    struct pen_claim quick = claim_for("quick", 60000);
    ck_assert_int_eq(quick.batch, slow.batch);
    ck_assert_int_eq(quick.attempt, slow.attempt + 1);
    ck_assert(!held(&slow));
    ck_assert(held(&quick));
    ck_assert_int_eq(store_commit(bed.store, &slow), PEN_STALE);
    struct pen_status st;
    ck_assert(!pen_store_fail(bed.store, &slow, "{}", &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    store_must(pen_store_release(bed.store, &slow, &st), &st, "release");
    ck_assert(held(&quick));
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_RUNNING);
    ck_assert_int_eq(job.done_pixels, 0);
    pen_job_record_release(&job);
    ck_assert_int_eq(store_commit(bed.store, &quick), PEN_OK);
    ck_assert_int_eq(store_commit(bed.store, &slow), PEN_STALE);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__commit_again_is_a_duplicate_that_changes_nothing)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    struct pen_job_record before = store_job_get(bed.store, in.id);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    struct pen_job_record after = store_job_get(bed.store, in.id);
    ck_assert_int_eq(after.revision, before.revision);
    ck_assert_int_eq(after.done_pixels, 16);
    ck_assert_int_eq(after.state, PEN_JOB_SUCCEEDED);
    pen_job_record_release(&before);
    pen_job_record_release(&after);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__lease_that_has_run_out_still_commits_until_it_is_expired)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_claim claim = claim_for("w", 1);
    sleep_ms(10);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert_int_eq(expire(NULL), 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__heartbeat_keeps_a_lease_alive)
{
    struct store_job in;
    int64_t time_ms = INT64_C(1800000000000);
    open_with_job(&in, 1, 1);
    store_bed_set_clock(&bed, &time_ms);
    struct pen_claim claim = claim_for("w", 300);
    struct pen_status st;
    for (int i = 0; i < 12; i++) {
        bool answer = false;
        time_ms += 250;
        store_must(pen_store_heartbeat(bed.store, &claim, 300, &answer, &st), &st, "heartbeat");
        ck_assert(answer);
        ck_assert_int_eq(expire(NULL), 0);
    }
    time_ms += 299;
    ck_assert_int_eq(expire(NULL), 0);
    time_ms += 2;
    ck_assert_int_eq(expire(NULL), 1);
    ck_assert(!held(&claim));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__expire_opens_the_batches_of_a_dead_worker_alone)
{
    struct store_job in;
    open_with_job(&in, 1, 4);
    struct pen_claim one = claim_for("dead", 60000), two = claim_for("alive", 60000);
    struct pen_claim three = claim_for("dead", 60000);
    ck_assert_int_eq(expire(NULL), 0);
    ck_assert_int_eq(expire("dead"), 2);
    ck_assert_int_eq(expire("dead"), 0);
    ck_assert(!held(&one));
    ck_assert(held(&two));
    ck_assert(!held(&three));
    ck_assert_int_eq(store_commit(bed.store, &two), PEN_OK);
    store_work_off(bed.store, "next");
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__release_gives_back_without_charge)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_status st;
    struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    struct pen_claim again = store_claim(bed.store, "w");
    ck_assert_int_eq(again.batch, claim.batch);
    ck_assert_int_eq(again.attempt, 2);
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_RUNNING);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__cancelled_while_leased_refuses_the_commit)
{
    struct store_job in;
    open_with_job(&in, 1, 2);
    struct pen_status st;
    struct pen_claim one = store_claim(bed.store, "w"), two = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &one), PEN_OK);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    ck_assert(!held(&two));
    ck_assert_int_eq(store_commit(bed.store, &two), PEN_STALE);
    ck_assert_int_eq(expire("w"), 0);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 0);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_CANCELLED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__failed_batch_ends_its_job_with_the_error)
{
    struct store_job in;
    open_with_job(&in, 2, 2);
    struct pen_status st;
    struct pen_claim one = store_claim(bed.store, "w"), two = store_claim(bed.store, "w");
    store_must(pen_store_fail(bed.store, &one, "{\"title\": \"no\"}", &st), &st, "fail");
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_FAILED);
    ck_assert_str_eq(job.error, "{\"title\": \"no\"}");
    ck_assert_int_gt(job.finished_ms, 0);
    pen_job_record_release(&job);
    ck_assert_int_eq(store_commit(bed.store, &two), PEN_STALE);
    ck_assert(!pen_store_fail(bed.store, &one, "{}", &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__deleted_job_leaves_its_worker_stale)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_status st;
    struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    ck_assert(!held(&claim));
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    /* Numbers are never used twice, so the old claim does not fit the next job's batch. */
    struct store_job next;
    store_job_init(&next, 2, 1, 1);
    store_job_submit(bed.store, &next);
    struct pen_claim fresh = store_claim(bed.store, "w");
    ck_assert_int_ne(fresh.batch, claim.batch);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__last_commit_of_a_view_adds_its_assemble_batch)
{
    struct store_job in;
    open_with_job(&in, 2, 3);
    struct pen_status st;
    struct pen_buf picture = {0};
    int assembled = 0;
    for (int i = 0; i < 8; i++) {
        ck_assert_int_eq(store_job_state(bed.store, in.id),
                         i == 0 ? PEN_JOB_QUEUED : PEN_JOB_RUNNING);
        struct pen_claim claim = store_claim(bed.store, "w");
        if (claim.kind == PEN_BATCH_ASSEMBLE) {
            assembled++;
            ck_assert_int_eq(claim.view_batches, 3);
            ck_assert(
                !pen_store_artefact(bed.store, in.id, claim.view, "beauty", "png", &picture, &st));
            ck_assert_int_eq(st.code, PEN_NOT_FOUND);
        }
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    }
    ck_assert_int_eq(assembled, 2);
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(job.done_pixels, job.total_pixels);
    ck_assert_int_gt(job.finished_ms, 0);
    ck_assert_int_eq(job.revision, 10);
    pen_job_record_release(&job);
    for (int view = 0; view < 2; view++)
        store_must(pen_store_artefact(bed.store, in.id, view, "beauty", "png", &picture, &st), &st,
                   "picture");
    ck_assert_str_eq((char *)picture.data, "picturepicture");
    pen_buf_release(&picture);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__view_does_not_end_without_its_picture)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_status st;
    float rgb[48] = {0};
    struct pen_claim claim = store_claim(bed.store, "w");
    struct pen_result result = {.rgb = rgb, .pixels = 16, .stats = "{}"};
    ck_assert(!pen_store_commit(bed.store, &claim, &result, &st));
    ck_assert_int_eq(st.code, PEN_INTERNAL);
    result.pixels = 15;
    ck_assert(!pen_store_commit(bed.store, &claim, &result, &st));
    ck_assert_int_eq(st.code, PEN_INTERNAL);
    ck_assert(held(&claim));
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__commit_also_claims_the_next_batch)
{
    struct store_job in;
    open_with_job(&in, 1, 2);
    struct pen_status st;
    float rgb[48] = {0};
    struct pen_result result = {.rgb = rgb, .pixels = 16, .stats = "{}"};
    struct pen_claim one = store_claim(bed.store, "w");
    struct pen_next next = {.worker = "w", .lease_ms = 60000};
    store_must(pen_store_commit_and_claim(bed.store, &one, &result, &next, &st), &st, "commit");
    ck_assert(next.found);
    ck_assert_int_eq(next.claim.first_tile, 1);
    struct pen_claim two = next.claim;
    store_must(pen_store_commit_and_claim(bed.store, &two, &result, &next, &st), &st, "commit");
    ck_assert(next.found);
    ck_assert_int_eq(next.claim.kind, PEN_BATCH_ASSEMBLE);
    ck_assert_int_eq(store_commit(bed.store, &next.claim), PEN_OK);
    /* A duplicate commit claims too, if a batch is open. */
    store_must(pen_store_commit_and_claim(bed.store, &two, &result, &next, &st), &st, "commit");
    ck_assert(!next.found);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__stale_commit_claims_nothing)
{
    struct store_job in, other;
    open_with_job(&in, 1, 1);
    struct pen_status st;
    float rgb[48] = {0};
    struct pen_result result = {.rgb = rgb, .pixels = 16, .stats = "{}"};
    struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    store_job_init(&other, 2, 1, 1);
    store_job_submit(bed.store, &other);
    struct pen_next next = {.worker = "w", .lease_ms = 60000};
    ck_assert(!pen_store_commit_and_claim(bed.store, &claim, &result, &next, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    ck_assert(!next.found);
    ck_assert_int_eq(store_job_state(bed.store, other.id), PEN_JOB_QUEUED);
    store_bed_close(&bed);
}
END_TEST

/* Values that a lossy store would change: signs of zero, NaN, infinities, denormals. */
static void hard_pixels(float rgb[48], int tile)
{
    static const float hard[] = {0.0f, -0.0f, 1e-42f, INFINITY, -INFINITY, NAN, 1.0f / 3.0f, 65504};
    for (int i = 0; i < 48; i++)
        rgb[i] = i < 8 ? hard[i] : (float)(tile * 48 + i) * 0.7f;
}

static bool compare_pixels(void *user, int first_tile, int tile_count, const float *rgb,
                           int64_t pixels)
{
    float expected[48];
    int *next = user;
    ck_assert_int_eq(first_tile, (*next)++);
    ck_assert_int_eq(tile_count, 1);
    ck_assert_int_eq(pixels, 16);
    hard_pixels(expected, first_tile);
    ck_assert_mem_eq(rgb, expected, sizeof expected);
    return first_tile < 1;
}

START_TEST(test_leases__pixels_come_back_bit_for_bit_in_order_of_tiles)
{
    struct store_job in;
    open_with_job(&in, 1, 3);
    struct pen_status st;
    struct pen_claim claim[3];
    for (int i = 0; i < 3; i++)
        claim[i] = store_claim(bed.store, "w");
    for (int i = 2; i >= 0; i--) {
        float rgb[48];
        hard_pixels(rgb, claim[i].first_tile);
        struct pen_result result = {.rgb = rgb, .pixels = 16, .stats = "{}"};
        store_must(pen_store_commit(bed.store, &claim[i], &result, &st), &st, "commit");
    }
    int next = 0;
    store_must(pen_store_pixels(bed.store, in.id, 0, compare_pixels, &next, &st), &st, "pixels");
    ck_assert_int_eq(next, 2);
    store_must(pen_store_pixels(bed.store, in.id, 1, compare_pixels, &next, &st), &st, "pixels");
    ck_assert_int_eq(next, 2);
    store_bed_close(&bed);
}
END_TEST

static bool append_stats(void *user, const struct pen_batch_stats *batch)
{
    char *text = user;
    size_t used = strlen(text);
    snprintf(text + used, 64 - used, "%d%d%s ", batch->view, (int)batch->kind, batch->stats);
    return true;
}

START_TEST(test_leases__statistics_of_finished_batches_are_listed)
{
    struct store_job in;
    open_with_job(&in, 1, 2);
    struct pen_status st;
    float rgb[48] = {0};
    struct pen_claim claim = store_claim(bed.store, "w");
    struct pen_result result = {.rgb = rgb, .pixels = 16, .stats = "first"};
    char text[64] = "";
    store_must(pen_store_stats(bed.store, in.id, append_stats, text, &st), &st, "stats");
    ck_assert_str_eq(text, "");
    store_must(pen_store_commit(bed.store, &claim, &result, &st), &st, "commit");
    store_work_off(bed.store, "w");
    store_must(pen_store_stats(bed.store, in.id, append_stats, text, &st), &st, "stats");
    ck_assert_str_eq(text, "00first 00{} 01{} ");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__picture_put_again_replaces_the_first)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_status st;
    struct pen_buf out = {0};
    const struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_artefact_put(bed.store, &claim, "beauty", "pfm", "one", 3, &st), &st,
               "put");
    store_must(pen_store_artefact_put(bed.store, &claim, "beauty", "pfm", "three", 5, &st), &st,
               "put");
    store_must(pen_store_artefact_put(bed.store, &claim, "depth", "pfm", "", 0, &st), &st, "put");
    store_must(pen_store_artefact(bed.store, in.id, 0, "beauty", "pfm", &out, &st), &st, "get");
    store_must(pen_store_artefact(bed.store, in.id, 0, "depth", "pfm", &out, &st), &st, "get");
    ck_assert_str_eq((char *)out.data, "three");
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

/* The time that has been added to a job, as its next claim is told. */
static int64_t spent_before(const struct store_job *in)
{
    struct pen_claim claim = store_claim(bed.store, "other");
    struct pen_status st;
    ck_assert_str_eq(claim.job_id, in->id);
    ck_assert_int_eq(claim.spent_us, 0);
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    return claim.job_spent_us;
}

START_TEST(test_leases__time_is_added_once_by_heartbeats_commits_and_releases)
{
    struct store_job in;
    struct pen_status st;
    open_with_job(&in, 1, 3);
    struct pen_claim claim = claim_for("w", 1);
    ck_assert_int_eq(claim.job_spent_us, 0);
    claim.spent_us = 4000;
    ck_assert(held(&claim)); /* the lease is short, so it is extended */
    ck_assert_int_eq(spent_before(&in), 4000);
    claim.spent_us = 9000;
    ck_assert(held(&claim)); /* only read */
    ck_assert_int_eq(spent_before(&in), 4000);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert_int_eq(spent_before(&in), 9000);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK); /* a duplicate */
    ck_assert_int_eq(spent_before(&in), 9000);
    claim = claim_for("w", 1000);
    claim.spent_us = 500;
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert_int_eq(spent_before(&in), 9500);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__time_of_a_lost_claim_is_what_its_last_heartbeat_told)
{
    struct store_job in;
    open_with_job(&in, 1, 1);
    struct pen_claim claim = claim_for("w", 1);
    claim.spent_us = 7000;
    ck_assert(held(&claim));
    ck_assert_int_eq(expire("w"), 1);
    ck_assert_int_eq(spent_before(&in), 7000);
    claim.spent_us = 90000;
    ck_assert(!held(&claim));
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    ck_assert_int_eq(spent_before(&in), 7000);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__heartbeat_tells_the_time_of_other_workers)
{
    struct store_job in;
    open_with_job(&in, 1, 2);
    struct pen_claim claim = claim_for("w", 1), other = claim_for("v", 1);
    claim.spent_us = 3000;
    ck_assert(held(&claim));
    ck_assert_int_eq(claim.job_spent_us, 0);
    ck_assert(held(&other));
    ck_assert_int_eq(other.job_spent_us, 3000);
    other.spent_us = 50;
    ck_assert_int_eq(store_commit(bed.store, &other), PEN_OK);
    ck_assert(held(&claim));
    ck_assert_int_eq(claim.job_spent_us, 50);
    store_bed_close(&bed);
}
END_TEST

static void expect_work(const char *id, int64_t work, int64_t estimate_ms, int64_t told_us)
{
    struct pen_job_record job = store_job_get(bed.store, id);
    ck_assert_int_eq(job.work, work);
    ck_assert_int_eq(job.estimate_ms, estimate_ms);
    ck_assert_int_eq(job.told_us, told_us);
    pen_job_record_release(&job);
    store_audit_clean(bed.store);
}

/* The map goes with the end of its job; what a lost claim told goes when another tells. */
START_TEST(test_leases__work_is_that_which_each_batch_told_last)
{
    struct store_job in;
    struct pen_status st;
    const struct pen_buf map = {.data = (unsigned char *)"map", .bytes = 3};
    struct pen_buf read = {0};
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    struct pen_claim first = store_claim(bed.store, "w"), second = store_claim(bed.store, "v");
    store_must(pen_store_estimate(bed.store, &first, 900, &map, &st), &st, "estimate");
    ck_assert(held(&first)); /* tells nothing */
    expect_work(in.id, 0, 900, 0);
    first.work = PEN_WORK_ALL / 4;
    first.estimate_ms = 800;
    first.spent_us = 100;
    ck_assert(held(&first));
    expect_work(in.id, PEN_WORK_ALL / 4, 800, 100);
    ck_assert(held(&second));
    ck_assert_int_eq(second.job_work, PEN_WORK_ALL / 4);
    store_must(pen_store_release(bed.store, &first, &st), &st, "release");
    expect_work(in.id, PEN_WORK_ALL / 4, 800, 100);
    first = store_claim(bed.store, "w");
    ck_assert_int_eq(first.job_work, 0);
    first.work = PEN_WORK_ALL / 8;
    first.estimate_ms = 700;
    ck_assert(held(&first));
    expect_work(in.id, PEN_WORK_ALL / 8, 700, 100);
    ck_assert_int_eq(store_commit(bed.store, &first), PEN_OK); /* of half of the pixels */
    expect_work(in.id, PEN_WORK_ALL / 2, 700, 100);
    store_must(pen_store_cost_map(bed.store, in.id, &read, &st), &st, "map");
    ck_assert_mem_eq(read.data, "map", read.bytes);
    ck_assert_uint_eq(read.bytes, 3);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    expect_work(in.id, PEN_WORK_ALL / 2, 700, 100);
    pen_buf_release(&read);
    store_must(pen_store_cost_map(bed.store, in.id, &read, &st), &st, "map");
    ck_assert_uint_eq(read.bytes, 0);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store leases", test_leases__claim_describes_its_batch,
          test_leases__larger_priority_first_then_older_jobs,
          test_leases__assemble_batch_comes_before_younger_jobs,
          test_leases__nothing_to_claim_is_no_error,
          test_leases__stale_attempt_is_refused_and_changes_nothing,
          test_leases__commit_again_is_a_duplicate_that_changes_nothing,
          test_leases__lease_that_has_run_out_still_commits_until_it_is_expired,
          test_leases__heartbeat_keeps_a_lease_alive,
          test_leases__expire_opens_the_batches_of_a_dead_worker_alone,
          test_leases__release_gives_back_without_charge,
          test_leases__cancelled_while_leased_refuses_the_commit,
          test_leases__failed_batch_ends_its_job_with_the_error,
          test_leases__deleted_job_leaves_its_worker_stale,
          test_leases__last_commit_of_a_view_adds_its_assemble_batch,
          test_leases__view_does_not_end_without_its_picture,
          test_leases__commit_also_claims_the_next_batch, test_leases__stale_commit_claims_nothing,
          test_leases__pixels_come_back_bit_for_bit_in_order_of_tiles,
          test_leases__statistics_of_finished_batches_are_listed,
          test_leases__picture_put_again_replaces_the_first,
          test_leases__time_is_added_once_by_heartbeats_commits_and_releases,
          test_leases__time_of_a_lost_claim_is_what_its_last_heartbeat_told,
          test_leases__heartbeat_tells_the_time_of_other_workers,
          test_leases__work_is_that_which_each_batch_told_last)
