/* SPDX-License-Identifier: MIT */
/* Studies: which worker gets one and what else it may hold, their progress, the death of their
 * worker; what batches of all kinds keep. */
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;
static struct pen_status st;
static struct store_job first, second, study;

enum { RUNS = 12 };

static bool claim_any(const char *worker, struct pen_claim *claim)
{
    bool found = false;
    store_must(pen_store_claim(bed.store, worker, 60000, claim, &found, &st), &st, "claim");
    return found;
}

static void submit_study(int n)
{
    store_study_init(&study, n, RUNS);
    store_job_submit(bed.store, &study);
}

static void submit_job(struct store_job *job, int n, int batches)
{
    store_job_init(job, n, 1, batches);
    store_job_submit(bed.store, job);
}

static void progress(const struct pen_claim *claim, int64_t done)
{
    store_must(pen_store_progress(bed.store, claim, done, &st), &st, "progress");
}

START_TEST(test_studies__commit_stores_the_report_and_ends_the_job)
{
    struct pen_buf report = {0};
    store_bed_open(&bed);
    submit_study(1);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(claim.kind, PEN_BATCH_STUDY);
    ck_assert_int_eq(claim.pixels, RUNS);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    struct pen_job_record job = store_job_get(bed.store, study.id);
    ck_assert_int_eq(job.state, PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(job.done_pixels, RUNS);
    ck_assert_int_eq(job.total_pixels, RUNS);
    pen_job_record_release(&job);
    store_must(pen_store_artefact(bed.store, study.id, 0, "report", "json", &report, &st), &st,
               "report");
    pen_buf_release(&report);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__commit_without_a_report_is_refused)
{
    struct pen_result empty = {.stats = "{}"};
    store_bed_open(&bed);
    submit_study(1);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert(!pen_store_commit(bed.store, &claim, &empty, &st));
    ck_assert_int_eq(st.code, PEN_INTERNAL);
    ck_assert_int_eq(store_job_state(bed.store, study.id), PEN_JOB_RUNNING);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__worker_holds_nothing_beside_one)
{
    struct pen_claim claim, other;
    store_bed_open(&bed);
    submit_study(1);
    submit_job(&first, 2, 2);
    claim = store_claim(bed.store, "w");
    ck_assert_int_eq(claim.kind, PEN_BATCH_STUDY);
    ck_assert(!claim_any("w", &other));
    ck_assert(claim_any("v", &other)); /* another worker may have it */
    ck_assert_int_eq(other.kind, PEN_BATCH_RENDER);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert(claim_any("w", &other));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__next_study_waits_for_an_idle_worker)
{
    struct pen_claim held, more, claim;
    store_bed_open(&bed);
    submit_job(&first, 1, 2);
    submit_study(2);
    submit_job(&second, 3, 1);
    held = store_claim(bed.store, "w");
    more = store_claim(bed.store, "w");
    /* The third job must wait behind the study: a busy worker would never become idle for it. */
    ck_assert(!claim_any("w", &claim));
    ck_assert_int_eq(store_commit(bed.store, &held), PEN_OK);
    ck_assert(!claim_any("w", &claim));
    ck_assert_int_eq(store_commit(bed.store, &more), PEN_OK);
    claim = store_claim(bed.store, "w");
    ck_assert_int_eq(claim.kind, PEN_BATCH_ASSEMBLE); /* of the first job */
    ck_assert(!claim_any("w", &more));
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    claim = store_claim(bed.store, "w");
    ck_assert_int_eq(claim.kind, PEN_BATCH_STUDY);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__next_claim_of_a_commit_may_be_one)
{
    struct pen_next next = {.worker = "w", .lease_ms = 60000};
    struct pen_result result = {.stats = "{}", .layer = "report", .format = "json"};
    store_bed_open(&bed);
    submit_study(1);
    store_study_init(&first, 2, 3);
    store_job_submit(bed.store, &first);
    struct pen_claim claim = store_claim(bed.store, "w");
    result.artefact = "{}";
    result.artefact_bytes = 2;
    store_must(pen_store_commit_and_claim(bed.store, &claim, &result, &next, &st), &st, "commit");
    ck_assert(next.found);
    ck_assert_int_eq(next.claim.kind, PEN_BATCH_STUDY);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__progress_is_seen_and_fenced)
{
    store_bed_open(&bed);
    submit_study(1);
    struct pen_claim claim = store_claim(bed.store, "w");
    progress(&claim, 5);
    struct pen_job_record job = store_job_get(bed.store, study.id);
    ck_assert_int_eq(job.done_pixels, 5);
    int64_t revision = job.revision;
    pen_job_record_release(&job);
    store_audit_clean(bed.store);
    progress(&claim, 7);
    job = store_job_get(bed.store, study.id);
    ck_assert_int_eq(job.done_pixels, 7);
    ck_assert_int_eq(job.revision, revision + 1);
    pen_job_record_release(&job);
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert(!pen_store_progress(bed.store, &claim, 8, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    struct pen_claim again = store_claim(bed.store, "v");
    progress(&again, 0);
    ck_assert(!pen_store_progress(bed.store, &claim, 9, &st));
    job = store_job_get(bed.store, study.id);
    ck_assert_int_eq(job.done_pixels, 0);
    pen_job_record_release(&job);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    ck_assert_int_eq(store_commit(bed.store, &again), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

static bool keep(const struct pen_claim *claim, int64_t done, const char *text)
{
    const struct pen_kept kept = {.done = done, .data = text, .bytes = strlen(text)};
    bool outranked = false;
    store_must(pen_store_keep(bed.store, claim, &kept, &outranked, &st), &st, "keep");
    return outranked;
}

/* What is kept under a name; NULL: nothing. */
static void expect_part(const struct pen_claim *claim, const char *name, const char *text)
{
    struct pen_buf kept = {0};
    if (!text) {
        ck_assert(!pen_store_kept(bed.store, claim, name, &kept, &st));
        ck_assert_int_eq(st.code, PEN_NOT_FOUND);
        return;
    }
    store_must(pen_store_kept(bed.store, claim, name, &kept, &st), &st, name);
    ck_assert_uint_eq(kept.bytes, strlen(text));
    ck_assert_mem_eq(kept.data, text, kept.bytes);
    pen_buf_release(&kept);
}

static void expect_kept(const struct pen_claim *claim, const char *text)
{
    expect_part(claim, PEN_KEPT_STATE, text);
}

START_TEST(test_studies__what_is_kept_is_there_for_the_next_worker)
{
    struct pen_buf none = {0};
    store_bed_open(&bed);
    submit_study(1);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert(!pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &none, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!keep(&claim, 3, "three"));
    ck_assert(!keep(&claim, 5, "five"));
    struct pen_job_record job = store_job_get(bed.store, study.id);
    ck_assert_int_eq(job.done_pixels, 5);
    pen_job_record_release(&job);
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    struct pen_claim again = store_claim(bed.store, "v");
    expect_kept(&again, "five");
    const struct pen_kept late = {.done = 7, .data = "late", .bytes = 4};
    bool outranked;
    ck_assert(!pen_store_keep(bed.store, &claim, &late, &outranked, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    expect_kept(&again, "five");
    store_audit_clean(bed.store);
    ck_assert_int_eq(store_commit(bed.store, &again), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__parts_stay_until_they_are_replaced_or_committed)
{
    const struct pen_kept_part both[] = {{"a", "one", 3}, {"b", "two", 3}};
    const struct pen_kept_part later[] = {{"b", "three", 5}};
    struct pen_kept kept = {.data = "1", .bytes = 1, .parts = both, .part_count = 2};
    bool outranked;
    store_bed_open(&bed);
    submit_study(1);
    const struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_keep(bed.store, &claim, &kept, &outranked, &st), &st, "keep");
    kept = (struct pen_kept){.data = "2", .bytes = 1, .parts = later, .part_count = 1};
    store_must(pen_store_keep(bed.store, &claim, &kept, &outranked, &st), &st, "keep");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    const struct pen_claim again = store_claim(bed.store, "v");
    kept.parts = both;
    ck_assert(!pen_store_keep(bed.store, &claim, &kept, &outranked, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    expect_kept(&again, "2");
    expect_part(&again, "a", "one");
    expect_part(&again, "b", "three");
    ck_assert_int_eq(store_commit(bed.store, &again), PEN_OK);
    expect_part(&again, PEN_KEPT_STATE, NULL);
    expect_part(&again, "a", NULL);
    expect_part(&again, "b", NULL);
    store_bed_close(&bed);
}
END_TEST

/* Parts without a state leave the state that there is. */
START_TEST(test_studies__state_stays_if_parts_alone_are_kept)
{
    const struct pen_kept_part part = {"a", "one", 3};
    const struct pen_kept parts = {.done = -1, .parts = &part, .part_count = 1};
    bool outranked;
    store_bed_open(&bed);
    submit_study(1);
    const struct pen_claim claim = store_claim(bed.store, "w");
    keep(&claim, 2, "state");
    store_must(pen_store_keep(bed.store, &claim, &parts, &outranked, &st), &st, "keep");
    expect_kept(&claim, "state");
    expect_part(&claim, "a", "one");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

static bool keep_part(const struct pen_claim *claim, const char *name, const char *text)
{
    const struct pen_kept_part part = {name, text, strlen(text)};
    return pen_store_keep_part(bed.store, claim, &part, &st);
}

/* Parts of results are there for the batch that assembles the picture, and end with its view. Each
 * is a large object, so that they are removed in slices. */
START_TEST(test_studies__parts_of_results_stay_until_the_view_ends)
{
    store_bed_open(&bed);
    submit_job(&first, 1, 2);
    const struct pen_claim lost = store_claim(bed.store, "w");
    ck_assert(keep_part(&lost, "0", "zero"));
    store_must(pen_store_release(bed.store, &lost, &st), &st, "release");
    ck_assert(!keep_part(&lost, "0", "late"));
    ck_assert_int_eq(st.code, PEN_STALE);
    const struct pen_claim again = store_claim(bed.store, "w");
    ck_assert(keep_part(&again, "0", "again"));
    ck_assert_int_eq(store_commit(bed.store, &again), PEN_OK);
    const struct pen_claim other = store_claim(bed.store, "w");
    ck_assert(keep_part(&other, "1", "one"));
    ck_assert_int_eq(store_commit(bed.store, &other), PEN_OK);
    const struct pen_claim assemble = store_claim(bed.store, "w");
    ck_assert_int_eq(assemble.kind, PEN_BATCH_ASSEMBLE);
    expect_part(&assemble, "0", "again");
    expect_part(&assemble, "1", "one");
    ck_assert_int_eq(
        store_number(bed.url, "SELECT count(*) FROM artefact WHERE object IS NOT NULL"), 2);
    ck_assert_int_eq(store_commit(bed.store, &assemble), PEN_OK);
    expect_part(&assemble, "0", NULL);
    expect_part(&assemble, "1", NULL);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__keeping_tells_of_batches_of_higher_priority)
{
    store_bed_open(&bed);
    submit_study(1);
    struct pen_claim claim = store_claim(bed.store, "w");
    submit_job(&first, 2, 1); /* of the same priority */
    ck_assert(!keep(&claim, 1, "a"));
    store_job_init(&second, 3, 1, 1);
    second.job.priority = 1;
    store_job_submit(bed.store, &second);
    ck_assert(keep(&claim, 2, "b"));
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    struct pen_claim next = store_claim(bed.store, "w");
    ck_assert_str_eq(next.job_id, second.id);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__cancel_in_the_middle_leaves_a_sound_store)
{
    bool held = true;
    store_bed_open(&bed);
    submit_study(1);
    struct pen_claim claim = store_claim(bed.store, "w");
    progress(&claim, 5);
    store_must(pen_store_cancel(bed.store, study.id, NULL, &st), &st, "cancel");
    store_must(pen_store_heartbeat(bed.store, &claim, 60000, &held, &st), &st, "heartbeat");
    ck_assert(!held);
    ck_assert(!pen_store_progress(bed.store, &claim, 6, &st));
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    store_bed_close(&bed);
}
END_TEST

static char *death_error(void *user, const struct pen_claim *claim, int charges)
{
    (void)user;
    ck_assert_int_eq(claim->kind, PEN_BATCH_STUDY);
    ck_assert_int_eq(charges, 3);
    return strdup("{}");
}

START_TEST(test_studies__crashes_are_charged_although_progress_was_stored)
{
    struct pen_worker_death death = {
        .worker = "w", .end = PEN_WORKER_CRASHED, .error = death_error};
    int opened;
    store_bed_open(&bed);
    submit_study(1);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(store_job_state(bed.store, study.id),
                         i == 0 ? PEN_JOB_QUEUED : PEN_JOB_RUNNING);
        struct pen_claim claim = store_claim(bed.store, "w");
        progress(&claim, 3 + i);
        store_must(pen_store_worker_ended(bed.store, &death, &opened, &st), &st, "ended");
    }
    ck_assert_int_eq(store_job_state(bed.store, study.id), PEN_JOB_FAILED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_studies__store_of_an_earlier_schema_takes_them_once_migrated)
{
    store_bed_open(&bed);
    int current = store_schema_version(bed.url);
    ck_assert_int_ge(current, 6);
    submit_job(&first, 1, 2);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    pen_store_close(bed.store);
    store_downgrade(bed.url, 5);
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(store_schema_version(bed.url), current);
    submit_study(2);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 3);
    ck_assert_int_eq(store_job_state(bed.store, first.id), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(store_job_state(bed.store, study.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("studies", test_studies__commit_stores_the_report_and_ends_the_job,
          test_studies__commit_without_a_report_is_refused,
          test_studies__worker_holds_nothing_beside_one,
          test_studies__next_study_waits_for_an_idle_worker,
          test_studies__next_claim_of_a_commit_may_be_one,
          test_studies__progress_is_seen_and_fenced,
          test_studies__what_is_kept_is_there_for_the_next_worker,
          test_studies__parts_stay_until_they_are_replaced_or_committed,
          test_studies__state_stays_if_parts_alone_are_kept,
          test_studies__parts_of_results_stay_until_the_view_ends,
          test_studies__keeping_tells_of_batches_of_higher_priority,
          test_studies__cancel_in_the_middle_leaves_a_sound_store,
          test_studies__crashes_are_charged_although_progress_was_stored,
          test_studies__store_of_an_earlier_schema_takes_them_once_migrated)
