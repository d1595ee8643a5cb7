/* SPDX-License-Identifier: MIT */
/* Retention by age, number and bytes; clocks that jump. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/suite.h"

static const int64_t day_ms = 86400000;
static struct store_bed bed;
static struct store_job jobs[4];
static struct pen_status st;
static int64_t now_ms;

/* So many jobs that have ended, a second one after another. */
static void begin(int count)
{
    store_bed_open(&bed);
    now_ms = INT64_C(1800000000000);
    store_bed_set_clock(&bed, &now_ms);
    for (int i = 0; i < count; i++) {
        store_job_init(&jobs[i], i + 1, 1, 1);
        store_job_submit(bed.store, &jobs[i]);
        now_ms += 1000;
        ck_assert_int_eq(store_work_off(bed.store, "w"), 1);
    }
}

static void keep(int64_t keep_ms, int64_t keep_bytes, int64_t keep_jobs)
{
    const struct pen_retention limits = {keep_ms, keep_bytes, keep_jobs};
    store_must(pen_store_set_retention(bed.store, &limits, &st), &st, "limits");
}

static void purge(void)
{
    bool more = true;
    while (more)
        store_must(pen_store_purge(bed.store, &more, &st), &st, "purge");
}

/* Removes what is expired; returns how many, and expects the oldest ends first. */
static int expire(int first)
{
    char id[PEN_ID_BYTES];
    bool found = true;
    int count = 0;
    while (found) {
        store_must(pen_store_expired(bed.store, id, &found, &st), &st, "expired");
        if (!found)
            break;
        ck_assert_str_eq(id, jobs[first + count++].id);
        store_must(pen_store_delete(bed.store, id, NULL, "{}", &st), &st, "delete");
        purge();
    }
    return count;
}

START_TEST(test_retention__by_number_after_a_minute_those_that_ended_first)
{
    begin(4);
    keep(0, 0, 1);
    ck_assert_int_eq(expire(0), 0);
    now_ms += 62000;
    ck_assert_int_eq(expire(0), 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__by_age_waits_a_day_after_the_clock_has_jumped)
{
    begin(2);
    keep(day_ms / 2, 0, 0);
    purge();
    now_ms += day_ms * 3;
    ck_assert_int_eq(expire(0), 0);
    purge();
    ck_assert_int_eq(expire(0), 0);
    now_ms += day_ms - 1000;
    purge();
    ck_assert_int_eq(expire(0), 0);
    now_ms += 2000;
    ck_assert_int_eq(expire(0), 2);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__a_store_that_is_full_refuses_jobs_and_removes_ended_ones)
{
    enum pen_submit_result result;
    struct pen_buf answer = {0};
    begin(1);
    keep(0, 300 << 10, 0);
    store_job_init(&jobs[1], 2, 1, 1);
    jobs[1].view[0].width = jobs[1].view[0].height = 1000;
    ck_assert(!pen_store_submit(bed.store, &jobs[1].job, &result, &answer, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    keep(0, 1 << 10, 0);
    ck_assert(!pen_store_intake(bed.store, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert_int_eq(expire(0), 1);
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__by_age_those_that_ended_first)
{
    begin(4); /* they end a second after another */
    keep(day_ms, 0, 0);
    for (int i = 0; i < 4; i++) { /* a jump of more than a day would let ages wait */
        purge();
        now_ms += day_ms / 4;
    }
    now_ms -= 1999;
    ck_assert_int_eq(expire(0), 2);
    now_ms += 1000;
    ck_assert_int_eq(expire(2), 1);
    keep(0, 0, 0);
    now_ms += day_ms;
    ck_assert_int_eq(expire(3), 0);
    store_bed_close(&bed);
}
END_TEST

/* A picture of 1 MiB for each; the store may hold about two and a half of them. */
START_TEST(test_retention__by_bytes_those_that_ended_first_until_an_eighth_is_free)
{
    enum { BYTES = 1 << 20 };
    static unsigned char data[BYTES];
    struct pen_counts counts;
    begin(0);
    for (int i = 0; i < 4; i++) {
        store_job_init(&jobs[i], i + 1, 1, 1);
        store_job_submit(bed.store, &jobs[i]);
        const struct pen_claim claim = store_claim(bed.store, "w");
        store_must(
            pen_store_artefact_put(bed.store, &claim, "depth", "pfm", data, sizeof data, &st), &st,
            "put");
        now_ms += 1000;
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    }
    keep(0, 3 * BYTES, 0);
    ck_assert_int_eq(expire(0), 2); /* above the limit, none is kept for its minute */
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    ck_assert_int_lt(counts.bytes, 3 * BYTES - 3 * BYTES / 8);
    keep(0, counts.bytes + counts.bytes / 8, 0); /* above 7/8 of the limit */
    ck_assert_int_eq(expire(2), 0);
    now_ms += 62000;
    ck_assert_int_eq(expire(2), 1);
    ck_assert_int_eq(store_job_state(bed.store, jobs[3].id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__never_removes_a_job_that_has_not_ended)
{
    begin(1);
    store_job_init(&jobs[1], 2, 1, 1);
    store_job_submit(bed.store, &jobs[1]);
    keep(1, 1, 1);
    now_ms += day_ms / 2;
    purge();
    ck_assert_int_eq(expire(0), 1);
    ck_assert_int_eq(store_job_state(bed.store, jobs[1].id), PEN_JOB_QUEUED);
    store_bed_close(&bed);
}
END_TEST

/* Jobs of a clock that was a year ahead go in their turn: they ended when that was noticed. */
START_TEST(test_retention__an_end_in_the_future_counts_as_now)
{
    begin(1);
    now_ms += 365 * day_ms;
    for (int i = 1; i < 3; i++) {
        store_job_init(&jobs[i], i + 1, 1, 1);
        store_job_submit(bed.store, &jobs[i]);
        ck_assert_int_eq(store_work_off(bed.store, "w"), 1);
    }
    now_ms -= 365 * day_ms;
    keep(0, 0, 1);
    purge();
    now_ms += 10000;
    store_job_init(&jobs[3], 4, 1, 1);
    store_job_submit(bed.store, &jobs[3]);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 1);
    now_ms += 62000;
    ck_assert_int_eq(expire(0), 3);
    ck_assert_int_eq(store_job_state(bed.store, jobs[3].id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

/* Half of the limit is for what has ended, unless there is one unfinished job alone. */
START_TEST(test_retention__unfinished_jobs_are_expected_to_take_half_of_the_limit)
{
    enum { PIXELS = 100000, JOB = 10 * PIXELS, LAYERED = 34 * PIXELS };
    enum pen_submit_result result;
    struct pen_buf answer = {0};
    begin(0);
    keep(0, 6 * JOB, 0);
    for (int i = 0; i < 4; i++) {
        store_job_init(&jobs[i], i + 1, 1, 1);
        jobs[i].view[0].width = PIXELS;
        jobs[i].view[0].height = 1;
    }
    for (int i = 0; i < 3; i++)
        store_job_submit(bed.store, &jobs[i]);
    ck_assert(!pen_store_submit(bed.store, &jobs[3].job, &result, &answer, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_RETRY);
    for (int i = 0; i < 3; i++)
        store_must(pen_store_cancel(bed.store, jobs[i].id, NULL, &st), &st, "cancel");
    jobs[3].job.request = "{\"layers\": [\"beauty\", \"depth\", \"normal\"]}";
    keep(0, LAYERED, 0);
    ck_assert(!pen_store_submit(bed.store, &jobs[3].job, &result, &answer, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    keep(0, LAYERED + (1 << 20), 0);
    store_job_submit(bed.store, &jobs[3]);
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

/* A job that was refused for lack of space has two minutes to come again: until then retention
 * makes room for it. */
START_TEST(test_retention__makes_room_for_a_job_that_was_refused)
{
    enum { PIXELS = 20000, BYTES = 10 * PIXELS };
    enum pen_submit_result result;
    struct pen_buf answer = {0};
    static const char picture[100000];
    struct pen_counts counts;
    begin(0);
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    ck_assert_int_le(counts.bytes, 320 << 10); /* what retention.c expects of an empty store */
    store_job_init(&jobs[0], 1, 1, 1);
    store_job_submit(bed.store, &jobs[0]);
    const struct pen_claim claim = store_claim(bed.store, "w");
    store_must(
        pen_store_artefact_put(bed.store, &claim, "depth", "pfm", picture, sizeof picture, &st),
        &st, "put");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    now_ms += 62000;
    purge();
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    keep(0, counts.bytes + BYTES - 1, 0);
    store_job_init(&jobs[1], 2, 1, 1);
    jobs[1].view[0].width = PIXELS;
    jobs[1].view[0].height = 1;
    for (int i = 0; i < 2; i++) {
        ck_assert_int_eq(expire(0), 0);
        ck_assert(!pen_store_submit(bed.store, &jobs[1].job, &result, &answer, &st));
        ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
        now_ms += i == 0 ? 121000 : 119000;
    }
    ck_assert_int_eq(expire(0), 1);
    store_job_submit(bed.store, &jobs[1]);
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store retention", test_retention__makes_room_for_a_job_that_was_refused,
          test_retention__by_number_after_a_minute_those_that_ended_first,
          test_retention__by_age_waits_a_day_after_the_clock_has_jumped,
          test_retention__by_age_those_that_ended_first,
          test_retention__by_bytes_those_that_ended_first_until_an_eighth_is_free,
          test_retention__never_removes_a_job_that_has_not_ended,
          test_retention__an_end_in_the_future_counts_as_now,
          test_retention__unfinished_jobs_are_expected_to_take_half_of_the_limit,
          test_retention__a_store_that_is_full_refuses_jobs_and_removes_ended_ones)
