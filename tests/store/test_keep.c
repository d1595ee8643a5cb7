/* SPDX-License-Identifier: MIT */
/* What a long batch keeps and reports: states and parts, progress, work and estimates, the map of
 * costs; and when it should yield. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job study;
static struct pen_status st;
static int64_t now_ms;

static struct pen_claim begin(int runs)
{
    store_bed_open(&bed);
    now_ms = 1000000000;
    store_bed_set_clock(&bed, &now_ms);
    store_study_init(&study, 1, runs);
    study.job.client = "a";
    store_job_submit(bed.store, &study);
    return store_claim(bed.store, "w");
}

static bool keep(const struct pen_claim *claim, int64_t done, const char *state, bool *outranked)
{
    const struct pen_kept kept = {.done = done, .data = state, .bytes = strlen(state)};
    return pen_store_keep(bed.store, claim, &kept, outranked, &st);
}

static void expect_kept(const struct pen_claim *claim, const char *name, const char *text)
{
    struct pen_buf out = {0};
    store_must(pen_store_kept(bed.store, claim, name, &out, &st), &st, name);
    ck_assert_uint_eq(out.bytes, strlen(text));
    ck_assert_mem_eq(out.data, text, out.bytes);
    pen_buf_release(&out);
}

START_TEST(test_keep__parts_of_any_number_stay_until_they_are_replaced)
{
    enum { PARTS = 40 };
    struct pen_kept_part part[PARTS];
    char name[PARTS][16];
    bool outranked;
    const struct pen_claim claim = begin(10);
    for (int i = 0; i < PARTS; i++) {
        snprintf(name[i], sizeof name[i], "part%d", i);
        part[i] = (struct pen_kept_part){name[i], name[i], strlen(name[i])};
    }
    const struct pen_kept all = {
        .done = 1, .data = "one", .bytes = 3, .parts = part, .part_count = PARTS};
    store_must(pen_store_keep(bed.store, &claim, &all, &outranked, &st), &st, "keep");
    part[7].data = "new";
    part[7].bytes = 3;
    const struct pen_kept one = {.done = 2, .parts = &part[7], .part_count = 1};
    store_must(pen_store_keep(bed.store, &claim, &one, &outranked, &st), &st, "keep");
    expect_kept(&claim, PEN_KEPT_STATE, "one");
    expect_kept(&claim, "part7", "new");
    expect_kept(&claim, "part39", "part39");
    ck_assert(keep(&claim, 3, "two", &outranked));
    expect_kept(&claim, PEN_KEPT_STATE, "two");
    expect_kept(&claim, "part0", "part0");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_keep__goes_with_the_commit)
{
    struct pen_buf out = {0};
    bool outranked;
    const struct pen_claim claim = begin(10);
    ck_assert(keep(&claim, 3, "state", &outranked));
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert(!pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &out, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!keep(&claim, 4, "late", &outranked));
    ck_assert_int_eq(st.code, PEN_STALE);
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_keep__is_refused_beyond_keep_bytes)
{
    static char large[1 << 20];
    struct pen_counts counts;
    bool outranked;
    const struct pen_claim claim = begin(10);
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    const struct pen_retention limits = {.keep_bytes = counts.bytes + 100000};
    store_must(pen_store_set_retention(bed.store, &limits, &st), &st, "limits");
    ck_assert(keep(&claim, 3, "small", &outranked));
    const struct pen_kept kept = {.done = 4, .data = large, .bytes = sizeof large};
    ck_assert(!pen_store_keep(bed.store, &claim, &kept, &outranked, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_RETRY);
    expect_kept(&claim, PEN_KEPT_STATE, "small");
    struct pen_job_record record = store_job_get(bed.store, study.id);
    ck_assert_int_eq(record.done_pixels, 3);
    pen_job_record_release(&record);
    store_bed_close(&bed);
}
END_TEST

static void expect_told(int64_t pixels, int64_t work, int64_t estimate_ms, int64_t told_us)
{
    struct pen_job_record record = store_job_get(bed.store, study.id);
    ck_assert_int_eq(record.done_pixels, pixels);
    ck_assert_int_eq(record.work, work);
    ck_assert_int_eq(record.estimate_ms, estimate_ms);
    ck_assert_int_eq(record.told_us, told_us);
    pen_job_record_release(&record);
}

/* Progress is told once, by whichever call, and does not go back; nor does it with a new holder. */
START_TEST(test_keep__progress_is_told_once_and_does_not_go_back)
{
    bool outranked, held;
    struct pen_claim claim = begin(10);
    expect_told(0, 0, 0, 0);
    claim.spent_us = 1000;
    claim.estimate_ms = 70;
    struct pen_kept progress = {.done = 4};
    store_must(pen_store_keep(bed.store, &claim, &progress, NULL, &st), &st, "progress");
    expect_told(4, PEN_WORK_ALL / 10 * 4, 70, 1000);
    progress.done = 3;
    store_must(pen_store_keep(bed.store, &claim, &progress, NULL, &st), &st, "progress");
    expect_told(4, PEN_WORK_ALL / 10 * 4, 70, 1000);
    claim.work = PEN_WORK_ALL / 2;
    claim.spent_us = 3000;
    ck_assert(keep(&claim, 6, "six", &outranked));
    expect_told(6, PEN_WORK_ALL / 10 * 6, 70, 3000); /* the share of its runs */
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    claim = store_claim(bed.store, "v");
    ck_assert_int_eq(claim.job_spent_us, 3000);
    ck_assert_int_eq(claim.job_work, 0); /* this batch has done it */
    claim.spent_us = 500;
    claim.estimate_ms = 80;
    claim.work = PEN_WORK_ALL / 4;
    store_must(pen_store_heartbeat(bed.store, &claim, STORE_LEASE_MS, &held, &st), &st, "beat");
    ck_assert(held);
    expect_told(6, PEN_WORK_ALL / 10 * 6, 80, 3500);
    claim.spent_us = 900;
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    expect_told(10, PEN_WORK_ALL, 80, 3900);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_keep__the_map_of_costs_is_there_until_the_job_ends)
{
    struct pen_buf map = {0}, out = {0};
    const struct pen_claim claim = begin(10);
    pen_buf_puts(&map, "costs");
    store_must(pen_store_estimate(bed.store, &claim, 1234, &map, &st), &st, "estimate");
    expect_told(0, 0, 1234, 0);
    store_must(pen_store_estimate(bed.store, &claim, 1235, NULL, &st), &st, "estimate");
    store_must(pen_store_cost_map(bed.store, study.id, &out, &st), &st, "map");
    ck_assert_uint_eq(out.bytes, map.bytes);
    ck_assert_mem_eq(out.data, map.data, out.bytes);
    out.bytes = 0;
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_must(pen_store_cost_map(bed.store, study.id, &out, &st), &st, "map");
    ck_assert_uint_eq(out.bytes, 0);
    pen_buf_release(&map);
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

static bool outranked_now(const struct pen_claim *claim)
{
    bool outranked, kept;
    store_must(pen_store_outranked(bed.store, claim, &outranked, &st), &st, "outranked");
    store_must(keep(claim, 1, "state", &kept), &st, "keep");
    ck_assert_int_eq(kept, outranked);
    return outranked;
}

static void submit(int n, int priority)
{
    struct store_job job;
    store_job_init(&job, n, 1, 1);
    job.job.client = "b";
    job.job.priority = priority;
    store_job_submit(bed.store, &job);
}

START_TEST(test_keep__gives_way_at_once_to_a_higher_priority_and_after_a_minute_to_its_own)
{
    const struct pen_claim claim = begin(10);
    ck_assert(!outranked_now(&claim));
    submit(2, -1);
    submit(3, 0);
    ck_assert(!outranked_now(&claim));
    now_ms += 60000;
    ck_assert(outranked_now(&claim));
    now_ms -= 60000;
    submit(4, 1);
    ck_assert(outranked_now(&claim));
    struct pen_claim next = store_claim(bed.store, "v");
    ck_assert_int_eq(store_commit(bed.store, &next), PEN_OK);
    ck_assert(!outranked_now(&claim));
    next = store_claim(bed.store, "v"); /* the one of its own priority */
    now_ms += 60000;
    ck_assert(!outranked_now(&claim));
    /* Handed back, it comes behind what waits at its priority. */
    submit(5, 0);
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    next = store_claim(bed.store, "u");
    ck_assert_int_ne(next.batch, claim.batch);
    next = store_claim(bed.store, "t");
    ck_assert_int_eq(next.batch, claim.batch);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store keep", test_keep__parts_of_any_number_stay_until_they_are_replaced,
          test_keep__goes_with_the_commit, test_keep__is_refused_beyond_keep_bytes,
          test_keep__progress_is_told_once_and_does_not_go_back,
          test_keep__the_map_of_costs_is_there_until_the_job_ends,
          test_keep__gives_way_at_once_to_a_higher_priority_and_after_a_minute_to_its_own)
