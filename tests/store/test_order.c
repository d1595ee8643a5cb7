/* SPDX-License-Identifier: MIT */
/* The order of batches (src/store/README.md, Order): whose batch is claimed next. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "support/faults.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static int jobs;

/* Submits jobs of one view with so many batches, at a priority. Returns the number of the first. */
static int submit(const char *client, int priority, int count, int batches)
{
    struct store_job job;
    const int first = jobs;
    for (int i = 0; i < count; i++) {
        store_job_init(&job, jobs++, 1, batches);
        job.job.client = client;
        job.job.priority = priority;
        store_job_submit(bed.store, &job);
    }
    return first;
}

static void cancel(int first, int count)
{
    struct store_job job;
    struct pen_status st;
    for (int i = first; i < first + count; i++) {
        store_job_init(&job, i, 1, 1);
        store_must(pen_store_cancel(bed.store, job.id, NULL, &st), &st, "cancel");
    }
}

/* Claims and commits a batch; returns the number of its job. */
static int serve(void)
{
    const struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    return atoi(claim.job_id + 24);
}

static void serve_many(int count)
{
    for (int i = 0; i < count; i++)
        serve();
}

/* How many claims it takes until a job has one. */
static int claims_until(int job)
{
    int claims = 1;
    while (serve() != job)
        claims++;
    return claims;
}

static void begin(void)
{
    jobs = 0;
    store_bed_open(&bed);
}

START_TEST(test_order__a_client_that_was_served_much_has_no_debt)
{
    begin();
    submit("a", 0, 500, 1);
    serve_many(500);
    submit("b", 0, 300, 1);
    ck_assert_int_le(claims_until(submit("a", 0, 1, 1)), 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__a_cancelled_backlog_leaves_nothing)
{
    begin();
    submit("a", 0, 500, 1);
    cancel(0, 490);
    serve_many(10);
    submit("b", 0, 300, 1);
    ck_assert_int_le(claims_until(submit("a", 0, 1, 1)), 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__a_low_priority_that_waits_changes_nothing_above_it)
{
    begin();
    int of_b = 0;
    submit("a", 0, 50, 1);
    submit("b", 5, 250, 1);
    serve_many(50); /* 200 are left */
    submit("c", 5, 250, 1);
    for (int i = 0; i < 200; i++) {
        const int job = serve();
        ck_assert_int_ge(job, 50);
        of_b += job < 300;
    }
    ck_assert_int_ge(of_b, 98);
    ck_assert_int_le(of_b, 102);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__own_jobs_of_low_priority_do_not_hold_a_high_one)
{
    begin();
    submit("a", 0, 300, 1);
    submit("b", 5, 100, 1);
    ck_assert_int_le(claims_until(submit("a", 5, 1, 1)), 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__one_job_after_another_gets_a_third_to_a_half)
{
    begin();
    int of_a = 0, mine;
    submit("b", 0, 200, 1);
    mine = submit("a", 0, 1, 1);
    for (int i = 0; i < 120; i++) {
        if (serve() != mine)
            continue;
        of_a++;
        mine = submit("a", 0, 1, 1);
    }
    ck_assert_int_ge(of_a, 39);
    ck_assert_int_le(of_a, 61);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__a_new_client_waits_twice_for_each_other_one)
{
    enum { CLIENTS = 7 };
    char name[CLIENTS][16];
    begin();
    for (int i = 0; i < CLIENTS; i++) {
        snprintf(name[i], sizeof name[i], "c%d", i);
        submit(name[i], 0, 40, 1);
    }
    serve_many(40);
    ck_assert_int_le(claims_until(submit("new", 0, 1, 1)), 2 * CLIENTS + 1);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__a_batch_that_is_handed_back_takes_a_new_turn)
{
    struct pen_status st;
    begin();
    submit("a", 0, 3, 1);
    const struct pen_claim claim = store_claim(bed.store, "w");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert_int_eq(serve(), 1);
    ck_assert_int_eq(serve(), 2);
    ck_assert_int_eq(serve(), 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_order__the_queue_tells_open_jobs_in_the_order_of_claims)
{
    struct pen_queue queue;
    struct pen_status st;
    begin();
    submit("a", 0, 4, 2);
    submit("b", 0, 2, 1);
    submit("b", 1, 1, 1);
    store_must(pen_store_queue(bed.store, &queue, &st), &st, "queue");
    ck_assert_uint_eq(queue.ids.bytes, 7 * PEN_ID_BYTES);
    ck_assert_int_eq(atoi((const char *)queue.ids.data + 24), serve());
    pen_buf_release(&queue.ids);
    store_bed_close(&bed);
}
END_TEST

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median of what a call takes. */
enum { TIMES = 101 };
static double median_ms(void (*call)(int i))
{
    static double ms[TIMES];
    for (int i = 0; i < TIMES; i++) {
        const int64_t begun_ns = pen_clock_ns();
        call(i);
        ms[i] = (double)(pen_clock_ns() - begun_ns) / 1e6;
    }
    qsort(ms, TIMES, sizeof ms[0], compare);
    return ms[TIMES / 2];
}

static void call_claim(int i)
{
    (void)i;
    store_claim(bed.store, "w");
}

static void call_submit(int i)
{
    (void)i;
    submit("new", 0, 1, 1);
}

static void call_queue(int i)
{
    struct pen_queue queue;
    struct pen_status st;
    (void)i;
    store_must(pen_store_queue(bed.store, &queue, &st), &st, "queue");
    pen_buf_release(&queue.ids);
}

static void list(const struct pen_job_filter *filter)
{
    struct pen_job_record *list;
    struct pen_status st;
    int count;
    store_must(pen_store_jobs(bed.store, filter, &list, &count, &st), &st, "list");
    pen_job_records_free(list, count);
}

static void call_list(int i)
{
    (void)i;
    list(&(struct pen_job_filter){.state = -1, .limit = 20});
}

static void call_list_rare(int i)
{
    static const struct pen_job_filter rare[] = {
        {.state = PEN_JOB_FAILED, .limit = 20},
        {.state = -1, .kind = "benchmark", .limit = 20},
        {.state = -1, .name = "other", .limit = 20},
        {.state = PEN_JOB_QUEUED, .label_key = "a", .label_value = "b", .limit = 20},
    };
    list(&rare[i % 4]);
}

static void call_expire(int i)
{
    struct pen_status st;
    int opened;
    (void)i;
    store_must(pen_store_expire_leases(bed.store, &opened, &st), &st, "expire");
}

/* On a disk whose syncs are quick: this is what the store adds to them. */
START_TEST(test_order__a_claim_among_24000_waiting_jobs_takes_a_millisecond)
{
    enum { CLIENTS = 1000, EACH = 24 };
    static const struct {
        const char *name;
        void (*call)(int i);
        double most_ms;
    } calls[] = {{"claim", call_claim, 1},
                 {"submit", call_submit, 5},
                 {"list", call_list, 5},
                 {"list of few", call_list_rare, 1},
                 {"expire leases", call_expire, 1},
                 {"queue", call_queue, 20}};
    char name[16];
    faults_install();
    begin();
    for (int i = 0; i < CLIENTS * EACH; i++) {
        snprintf(name, sizeof name, "c%d", i % CLIENTS);
        submit(name, 0, 1, 1);
    }
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++) {
        const double ms = median_ms(calls[i].call);
        printf("among 24,000 jobs, %s: %.3f ms\n", calls[i].name, ms);
        ck_assert_double_le(ms, calls[i].most_ms);
    }
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store order", test_order__a_client_that_was_served_much_has_no_debt,
          test_order__a_cancelled_backlog_leaves_nothing,
          test_order__a_low_priority_that_waits_changes_nothing_above_it,
          test_order__own_jobs_of_low_priority_do_not_hold_a_high_one,
          test_order__one_job_after_another_gets_a_third_to_a_half,
          test_order__a_new_client_waits_twice_for_each_other_one,
          test_order__a_batch_that_is_handed_back_takes_a_new_turn,
          test_order__the_queue_tells_open_jobs_in_the_order_of_claims, PEN_TIMED,
          test_order__a_claim_among_24000_waiting_jobs_takes_a_millisecond)
