/* SPDX-License-Identifier: MIT */
/* Submit: keys, repeated submits, quotas, many batches. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job;

static enum pen_submit_result submit(const char *answer)
{
    struct pen_buf first = {0};
    struct pen_status st;
    enum pen_submit_result result;
    store_must(pen_store_submit(bed.store, &job.job, &result, &first, &st), &st, "submit");
    ck_assert_str_eq(first.data ? (const char *)first.data : "", answer);
    pen_buf_release(&first);
    return result;
}

static enum pen_code refused(void)
{
    struct pen_buf first = {0};
    struct pen_status st;
    enum pen_submit_result result;
    ck_assert(!pen_store_submit(bed.store, &job.job, &result, &first, &st));
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    return st.code;
}

START_TEST(test_submit__a_key_repeats_the_first_answer_and_refuses_another_body)
{
    static const unsigned char body[2][32] = {{1}, {2}};
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 1);
    job.job.idempotency_key = "k";
    job.job.body_sha256 = body[0];
    job.job.answer = "first";
    ck_assert_int_eq(submit(""), PEN_SUBMIT_CREATED);
    store_job_init(&job, 2, 1, 1);
    job.job.idempotency_key = "k";
    job.job.body_sha256 = body[0];
    job.job.answer = "second";
    ck_assert_int_eq(submit("first"), PEN_SUBMIT_REPEATED);
    job.job.body_sha256 = body[1];
    ck_assert_int_eq(submit(""), PEN_SUBMIT_REUSED);
    job.job.client = "other";
    ck_assert_int_eq(submit(""), PEN_SUBMIT_CREATED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__an_id_is_known_or_in_conflict)
{
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 1);
    ck_assert_int_eq(submit(""), PEN_SUBMIT_CREATED);
    ck_assert_int_eq(submit(""), PEN_SUBMIT_KNOWN);
    job.job.request = "{}";
    ck_assert_int_eq(refused(), PEN_CONFLICT);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__quotas_count_unfinished_jobs)
{
    store_bed_open(&bed);
    for (int i = 1; i <= 3; i++) {
        store_job_init(&job, i, 1, 1);
        job.job.client = i < 3 ? "a" : "b";
        job.job.client_queue_max = 2;
        ck_assert_int_eq(submit(""), PEN_SUBMIT_CREATED);
    }
    store_job_init(&job, 4, 1, 1);
    job.job.client = "a";
    job.job.client_queue_max = 2;
    ck_assert_int_eq(refused(), PEN_QUOTA);
    job.job.client = "b";
    job.job.queue_max = 3;
    ck_assert_int_eq(refused(), PEN_QUOTA);
    store_work_off(bed.store, "w");
    ck_assert_int_eq(submit(""), PEN_SUBMIT_CREATED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__16384_batches_take_half_a_second)
{
    enum { BATCHES = 16384 };
    struct pen_batch_new *batches = calloc(BATCHES, sizeof *batches);
    ck_assert_ptr_nonnull(batches);
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 1);
    for (int i = 0; i < BATCHES; i++)
        batches[i] = (struct pen_batch_new){.first_tile = i, .tile_count = 1, .pixels = 16};
    job.job.batches = batches;
    job.job.batch_count = BATCHES;
    const int64_t begun_ns = pen_clock_ns();
    ck_assert_int_eq(submit(""), PEN_SUBMIT_CREATED);
    const double s = (double)(pen_clock_ns() - begun_ns) / 1e9;
    printf("a submit of 16,384 batches: %.3f s\n", s);
    ck_assert_double_le(s, 0.5);
    free(batches);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store submit", test_submit__a_key_repeats_the_first_answer_and_refuses_another_body,
          test_submit__an_id_is_known_or_in_conflict, test_submit__quotas_count_unfinished_jobs,
          PEN_TIMED, test_submit__16384_batches_take_half_a_second)
