/* SPDX-License-Identifier: MIT */
/* Jobs as readers see them: a job, lists, counts; cancel and delete. */
#include <string.h>

#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job;

static void submit(int n, const char *client, const char *kind, const char *request)
{
    store_job_init(&job, n, 1, 1);
    job.job.client = client;
    job.job.kind = kind;
    job.job.request = request;
    store_job_submit(bed.store, &job);
}

/* The last digits of the ids of a list. */
static void expect_list(const struct pen_job_filter *filter, const char *digits)
{
    struct pen_job_record *list;
    struct pen_status st;
    int count;
    store_must(pen_store_jobs(bed.store, filter, &list, &count, &st), &st, "list");
    ck_assert_int_eq(count, (int)strlen(digits));
    for (int i = 0; i < count; i++)
        ck_assert_int_eq(list[i].id[PEN_ID_BYTES - 2], digits[i]);
    pen_job_records_free(list, count);
}

static enum pen_code cancel(const char *client)
{
    struct pen_status st;
    return pen_store_cancel(bed.store, job.id, client, &st) ? PEN_OK : st.code;
}

static enum pen_code delete (const char *client, const char *stats) {
    struct pen_status st;
    return pen_store_delete(bed.store, job.id, client, stats, &st) ? PEN_OK : st.code;
}

START_TEST(test_jobs__lists_have_those_that_meet_all_conditions)
{
    store_bed_open(&bed);
    submit(1, "a", "render", "{\"name\": \"x\", \"labels\": {\"show\": \"one\"}}");
    submit(2, "a", "benchmark", "{\"name\": \"y\", \"labels\": {\"show\": \"one\"}}");
    submit(3, "b", "render", "{\"name\": \"x\", \"labels\": {\"show\": \"two\"}}");
    cancel(NULL);
    expect_list(&(struct pen_job_filter){.state = -1, .limit = 9}, "321");
    expect_list(&(struct pen_job_filter){.state = -1, .limit = 2}, "32");
    expect_list(&(struct pen_job_filter){.state = -1, .limit = 9, .below = 3}, "21");
    expect_list(&(struct pen_job_filter){.state = PEN_JOB_QUEUED, .limit = 9}, "21");
    expect_list(&(struct pen_job_filter){.state = PEN_JOB_CANCELLED, .limit = 9}, "3");
    expect_list(&(struct pen_job_filter){.state = -1, .kind = "render", .limit = 9}, "31");
    expect_list(&(struct pen_job_filter){.state = -1, .name = "x", .limit = 9}, "31");
    expect_list(
        &(struct pen_job_filter){
            .state = -1, .label_key = "show", .label_value = "one", .limit = 9},
        "21");
    expect_list(&(struct pen_job_filter){.state = -1, .limit = 9, .text_bytes = 1}, "32");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__cancel_ends_batches_and_leaves_ended_jobs)
{
    struct pen_counts counts;
    struct pen_status st;
    store_bed_open(&bed);
    submit(1, "a", "render", "{}");
    ck_assert_int_eq(cancel("b"), PEN_FORBIDDEN);
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    ck_assert_int_eq(counts.jobs[PEN_JOB_QUEUED], 1);
    ck_assert_int_eq(counts.open_batches, 1);
    ck_assert_int_eq(counts.oldest_queued_ms, job.job.created_ms);
    const struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(cancel("a"), PEN_OK);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    struct pen_job_record record = store_job_get(bed.store, job.id);
    const int64_t revision = record.revision;
    ck_assert_int_eq(record.state, PEN_JOB_CANCELLED);
    pen_job_record_release(&record);
    ck_assert_int_eq(cancel(NULL), PEN_OK);
    record = store_job_get(bed.store, job.id);
    ck_assert_int_eq(record.revision, revision);
    pen_job_record_release(&record);
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    ck_assert_int_eq(counts.open_batches + counts.leased_batches, 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__delete_leaves_statistics_until_a_second_one_drops_them)
{
    struct pen_buf stats = {0};
    struct pen_status st;
    struct pen_job_record record;
    store_bed_open(&bed);
    submit(1, "a", "render", "{}");
    ck_assert_int_eq(delete ("a", "{}"), PEN_CONFLICT);
    cancel("a");
    ck_assert(!pen_store_removed_stats(bed.store, job.id, &stats, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert_int_eq(delete ("b", "{}"), PEN_FORBIDDEN);
    ck_assert_int_eq(delete ("a", "{}"), PEN_OK);
    ck_assert(!pen_store_job(bed.store, job.id, &record, &st));
    ck_assert_int_eq(st.code, PEN_GONE);
    expect_list(&(struct pen_job_filter){.state = -1, .limit = 9}, "");
    ck_assert_int_eq(delete ("a", "{}"), PEN_GONE);
    store_must(pen_store_removed_stats(bed.store, job.id, &stats, &st), &st, "statistics");
    ck_assert_str_eq((const char *)stats.data, "{}");
    ck_assert_int_eq(delete ("b", NULL), PEN_FORBIDDEN);
    ck_assert_int_eq(delete ("a", NULL), PEN_OK);
    ck_assert_int_eq(delete ("a", NULL), PEN_GONE);
    ck_assert(!pen_store_removed_stats(bed.store, job.id, &stats, &st));
    ck_assert_int_eq(st.code, PEN_GONE);
    pen_buf_release(&stats);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store jobs", test_jobs__lists_have_those_that_meet_all_conditions,
          test_jobs__cancel_ends_batches_and_leaves_ended_jobs,
          test_jobs__delete_leaves_statistics_until_a_second_one_drops_them)
