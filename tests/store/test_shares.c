/* SPDX-License-Identifier: MIT */
/* Shares: who is served next, by workers that render nothing and only tell how long they took. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

enum { SECOND_US = 1000000, JOBS_MAX = 1000 };

static struct store_bed bed;
static int next_job;

/* What jobs of one kind have got. A job's number is its place among all; `of` maps it to a kind. */
static int of[JOBS_MAX];
static int64_t got_us[4];

static bool submit_job(int kind, const char *client, int batches, int priority, int64_t queue_max,
                       int64_t client_max, struct pen_status *st)
{
    struct store_job in;
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    ck_assert_int_lt(next_job, JOBS_MAX);
    store_job_init(&in, next_job, 1, batches);
    in.job.client = client;
    in.job.priority = priority;
    in.job.queue_max = queue_max;
    in.job.client_queue_max = client_max;
    of[next_job] = kind;
    bool ok = pen_store_submit(bed.store, &in.job, &result, &answer, st);
    next_job += ok;
    pen_buf_release(&answer);
    return ok;
}

static void submit(int kind, const char *client, int batches)
{
    struct pen_status st;
    store_must(submit_job(kind, client, batches, 0, 0, 0, &st), &st, "submit");
}

static void submit_many(int count, int kind, const char *client)
{
    for (int i = 0; i < count; i++)
        submit(kind, client, 1);
}

static void open_bed(void)
{
    store_bed_open(&bed);
    next_job = 0;
    memset(got_us, 0, sizeof got_us);
}

/* The number of a job with this id. */
static int number_of(const char *id)
{
    int number = -1;
    ck_assert_int_eq(sscanf(id, "01900000-0000-7000-8000-%d", &number), 1);
    return number;
}

static int kind_of(const struct pen_claim *claim)
{
    return of[number_of(claim->job_id)];
}

/* Claims and commits a batch that takes us[kind]; returns the kind of its job. */
static int serve(const int64_t us[4])
{
    struct pen_claim claim = store_claim(bed.store, "w");
    const int kind = kind_of(&claim);
    claim.spent_us = us[kind];
    got_us[kind] += us[kind];
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    return kind;
}

static const int64_t seconds[4] = {SECOND_US, SECOND_US, SECOND_US, SECOND_US};

static void serve_many(int count, const int64_t us[4])
{
    for (int i = 0; i < count; i++)
        serve(us);
}

static void expect_about(int64_t got, int64_t wanted, int64_t off)
{
    ck_assert_msg(got >= wanted - off && got <= wanted + off, "got %lld us, expected %lld +- %lld",
                  (long long)got, (long long)wanted, (long long)off);
}

START_TEST(test_shares__clients_get_the_same_time_whatever_they_queue)
{
    open_bed();
    submit_many(200, 0, "10.0.0.1");
    submit_many(20, 1, "10.0.0.2");
    serve_many(30, seconds);
    expect_about(got_us[1], 15 * SECOND_US, SECOND_US);
    store_bed_close(&bed);
}
END_TEST

/* One client cancels its jobs as soon as a worker has had them for 0.2 s, before the worker has
 * told what they take; the other one's take 0.1 s. They get the same time all the same. */
START_TEST(test_shares__a_job_that_is_cancelled_has_taken_what_its_worker_had_not_told_yet)
{
    enum { CANCELLED = 4, EACH_MS = 200 };
    const int64_t tenth_us = SECOND_US / 10;
    struct pen_status st;
    open_bed();
    store_worker_seen(bed.store, "w");
    submit_many(60, 1, "10.0.0.2");
    for (int cancelled = 0; cancelled < CANCELLED;) {
        submit(0, "10.0.0.1", 1);
        const int64_t begun_ns = pen_clock_ns();
        struct pen_claim claim = store_claim(bed.store, "w");
        for (; kind_of(&claim) == 1; claim = store_claim(bed.store, "w")) {
            claim.spent_us = tenth_us;
            got_us[1] += tenth_us;
            ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
        }
        const struct timespec pause = {.tv_nsec = EACH_MS * 1000000L};
        nanosleep(&pause, NULL);
        store_must(pen_store_cancel(bed.store, claim.job_id, NULL, &st), &st, "cancel");
        if (++cancelled < CANCELLED) /* the last one's time has not been made up for */
            got_us[0] += (pen_clock_ns() - begun_ns) / 1000;
    }
    ck_assert_msg(got_us[1] >= (CANCELLED - 1) * EACH_MS * 1000 - 2 * tenth_us &&
                      got_us[1] <= got_us[0] + 2 * tenth_us,
                  "%lld us and %lld us", (long long)got_us[0], (long long)got_us[1]);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_shares__it_is_time_that_is_shared_not_batches)
{
    const int64_t us[4] = {10 * SECOND_US, SECOND_US};
    open_bed();
    submit_many(20, 0, "10.0.0.1");
    submit_many(120, 1, "10.0.0.2");
    serve_many(88, us);
    expect_about(got_us[0], got_us[1], 10 * SECOND_US);
    ck_assert_int_ge(got_us[0], 70 * SECOND_US);
    store_bed_close(&bed);
}
END_TEST

/* A client is not owed what it did not ask for while it was away. */
START_TEST(test_shares__time_that_was_not_asked_for_is_not_owed)
{
    open_bed();
    submit_many(140, 0, "10.0.0.1");
    serve_many(100, seconds);
    submit_many(40, 1, "10.0.0.2");
    serve_many(40, seconds);
    expect_about(got_us[0], 120 * SECOND_US, SECOND_US);
    expect_about(got_us[1], 20 * SECOND_US, SECOND_US);
    store_bed_close(&bed);
}
END_TEST

/* A batch of hours, which could not be divided, is forgotten but for ten minutes. */
START_TEST(test_shares__debts_are_bounded)
{
    const int64_t us[4] = {36000 * INT64_C(1000000), 60 * SECOND_US};
    open_bed();
    submit(0, "10.0.0.1", 1);
    submit_many(40, 1, "10.0.0.2");
    while (got_us[0] == 0)
        serve(us);
    submit(2, "10.0.0.1", 1);
    int waited = 0;
    while (serve(us) != 2)
        waited++;
    ck_assert_int_ge(waited, 8);
    ck_assert_int_le(waited, 12);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_shares__short_jobs_share_with_the_long_one_before_them)
{
    open_bed();
    submit(0, "10.0.0.1", 8); /* eight batches of 5 s */
    submit_many(30, 1, "10.0.0.1");
    const int64_t us[4] = {5 * SECOND_US, SECOND_US};
    while (got_us[1] < 30 * SECOND_US && got_us[0] < 40 * SECOND_US)
        serve(us);
    expect_about(got_us[0], got_us[1], 10 * SECOND_US);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_shares__long_job_is_not_starved_by_short_ones_that_keep_coming)
{
    open_bed();
    submit(0, "10.0.0.1", 8);
    for (int i = 0; i < 60 && got_us[0] < 8 * SECOND_US; i++) {
        submit(1, "10.0.0.1", 1);
        submit(1, "10.0.0.1", 1);
        serve(seconds);
    }
    ck_assert_int_eq(got_us[0], 8 * SECOND_US);
    expect_about(got_us[1], 8 * SECOND_US, 3 * SECOND_US);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_shares__what_waits_long_comes_before_higher_priorities_once)
{
    struct pen_status st;
    open_bed();
    for (int i = 0; i < 20; i++)
        store_must(submit_job(1, "10.0.0.1", 1, 10, 0, 0, &st), &st, "submit");
    submit_many(5, 0, "10.0.0.2");
    serve_many(3, seconds);
    ck_assert_int_eq(got_us[0], 0);
    /* A priority for each minute: 9 are not enough, 11 are. */
    store_run_sql(&bed,
                  "UPDATE peer SET waiting_since_ms = waiting_since_ms - 9 * 60000"
                  " WHERE priority = 0",
                  NULL, 0);
    ck_assert_int_eq(serve(seconds), 1);
    store_run_sql(&bed,
                  "UPDATE peer SET waiting_since_ms = waiting_since_ms - 2 * 60000"
                  " WHERE priority = 0",
                  NULL, 0);
    ck_assert_int_eq(serve(seconds), 0);
    ck_assert_int_eq(serve(seconds), 1);
    store_bed_close(&bed);
}
END_TEST

static int64_t time_ms;

/* Of two batches, the one that waits while the other one is rendered comes first. */
START_TEST(test_shares__time_in_which_a_batch_is_rendered_is_not_waited)
{
    struct pen_status st;
    time_ms = INT64_C(1800000000000);
    open_bed();
    store_bed_set_clock(&bed, &time_ms);
    submit_many(5, 0, "10.0.0.2");
    time_ms += 130000;
    for (int i = 0; i < 5; i++)
        store_must(submit_job(1, "10.0.0.1", 1, 1, 0, 0, &st), &st, "submit");
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(kind_of(&claim), 0);
    claim.spent_us = 130 * SECOND_US;
    time_ms += 130000;
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert_int_eq(serve(seconds), 1);
    store_bed_close(&bed);
}
END_TEST

static bool outranked(const struct pen_claim *claim)
{
    struct pen_status st;
    bool yes;
    store_must(pen_store_outranked(bed.store, claim, &yes, &st), &st, "outranked");
    return yes;
}

/* Of two clients that have waited for two minutes, each gets a batch while a long one goes on:
 * which has five seconds between them. */
START_TEST(test_shares__long_batch_gives_way_to_what_has_waited_long)
{
    struct pen_status st;
    time_ms = INT64_C(1800000000000);
    open_bed();
    store_bed_set_clock(&bed, &time_ms);
    store_must(submit_job(1, "10.0.0.1", 1, 1, 0, 0, &st), &st, "submit");
    submit(0, "10.0.0.2", 1);
    submit(0, "10.0.0.3", 1);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(kind_of(&claim), 1);
    time_ms += 119000;
    ck_assert(!outranked(&claim));
    time_ms += 2000;
    for (int i = 0; i < 2; i++) {
        ck_assert(outranked(&claim));
        store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
        ck_assert_int_eq(serve(seconds), 0);
        claim = store_claim(bed.store, "w");
        ck_assert_int_eq(kind_of(&claim), 1);
        ck_assert(!outranked(&claim));
        time_ms += 6000;
    }
    ck_assert(!outranked(&claim));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_shares__many_that_wait_long_take_every_other_batch)
{
    struct pen_status st;
    char client[24];
    open_bed();
    for (int i = 0; i < 8; i++)
        store_must(submit_job(1, "10.0.0.1", 1, 1, 0, 0, &st), &st, "submit");
    for (int i = 0; i < 8; i++) {
        snprintf(client, sizeof client, "10.0.1.%d", i);
        submit(0, client, 1);
    }
    store_run_sql(&bed, "UPDATE peer SET waiting_since_ms = 0 WHERE priority = 0", NULL, 0);
    for (int i = 0; i < 8; i++)
        ck_assert_int_eq(serve(seconds), i % 2);
    store_bed_close(&bed);
}
END_TEST

/* Beside a job, two newcomers wait at any time, of one batch each: it gets a third. */
START_TEST(test_shares__new_clients_that_keep_coming_starve_nobody)
{
    const int64_t us[4] = {5 * SECOND_US, SECOND_US};
    char client[40];
    open_bed();
    submit(0, "10.0.0.1", 10);
    int missing = 2;
    for (int i = 0; i < 400 && got_us[0] < 50 * SECOND_US; i++) {
        for (; missing > 0; missing--) {
            snprintf(client, sizeof client, "10.1.%d.%d", i, missing);
            submit(1, client, 1);
        }
        missing = serve(us);
    }
    ck_assert_int_eq(got_us[0], 50 * SECOND_US);
    expect_about(got_us[1], 100 * SECOND_US, 15 * SECOND_US);
    store_bed_close(&bed);
}
END_TEST

static void expect_refused(const char *client, int64_t queue_max, int64_t client_max,
                           const char *words)
{
    struct pen_status st = {0};
    ck_assert(!submit_job(0, client, 1, 0, queue_max, client_max, &st));
    ck_assert_int_eq(st.code, PEN_QUOTA);
    ck_assert_msg(strstr(st.msg, words) != NULL, "%s", st.msg);
}

START_TEST(test_shares__queue_is_bounded_in_all_and_for_each_client)
{
    struct pen_status st;
    open_bed();
    submit_many(1, 0, "10.0.0.1");
    expect_refused("10.0.0.2", 1, 0, "1 job waits or runs, at most 1 is allowed");
    expect_refused("10.0.0.1", 0, 1, "1 job of client 10.0.0.1 waits or runs, at most 1 is");
    submit_many(2, 0, "10.0.0.1");
    submit_many(2, 0, "10.0.0.2");
    expect_refused("10.0.0.1", 0, 3, "3 jobs of client 10.0.0.1 wait or run, at most 3");
    expect_refused("10.0.0.3", 5, 3, "5 jobs wait or run, at most 5");
    store_must(submit_job(0, "10.0.0.2", 1, 0, 6, 3, &st), &st, "one more");
    serve_many(1, seconds);
    store_must(submit_job(0, "10.0.0.1", 1, 0, 6, 3, &st), &st, "one has ended");
    store_bed_close(&bed);
}
END_TEST

/* The queue, as numbers of jobs. */
static int read_queue(int number[JOBS_MAX])
{
    struct pen_queue queue;
    struct pen_status st;
    store_must(pen_store_queue(bed.store, &queue, &st), &st, "queue");
    const int count = (int)(queue.ids.bytes / PEN_ID_BYTES);
    ck_assert_int_lt(count, JOBS_MAX);
    for (int i = 0; i < count; i++)
        number[i] = number_of((const char *)queue.ids.data + i * PEN_ID_BYTES);
    pen_buf_release(&queue.ids);
    return count;
}

/* Jobs of one batch, of three clients and of two priorities. */
static int submit_mixture(void)
{
    struct pen_status st;
    submit_many(7, 0, "10.0.0.1");
    submit_many(9, 1, "10.0.0.2");
    submit_many(1, 2, "10.0.0.3");
    for (int i = 0; i < 3; i++)
        store_must(submit_job(3, "10.0.0.2", 1, 7, 0, 0, &st), &st, "submit");
    return next_job;
}

/* Each job that begins was the first of the queue, and began near the place that it had at first.
 */
START_TEST(test_shares__the_queue_is_in_the_order_in_which_jobs_begin)
{
    int queue[JOBS_MAX], first_place[JOBS_MAX] = {0};
    open_bed();
    const int count = submit_mixture();
    ck_assert_int_eq(read_queue(queue), count);
    for (int i = 0; i < count; i++)
        first_place[queue[i]] = i + 1;
    for (int turn = 1; turn <= count; turn++) {
        ck_assert_int_eq(read_queue(queue), count + 1 - turn);
        struct pen_claim claim = store_claim(bed.store, "w");
        const int number = number_of(claim.job_id);
        ck_assert_msg(queue[0] == number, "turn %d: job %d began, not %d", turn, number, queue[0]);
        ck_assert_int_le(abs(first_place[number] - turn), 2);
        claim.spent_us = SECOND_US;
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    }
    ck_assert_int_eq(read_queue(queue), 0);
    store_bed_close(&bed);
}
END_TEST

/* The queue without its list of jobs. */
static struct pen_queue read_facts(void)
{
    struct pen_queue queue;
    struct pen_status st;
    store_must(pen_store_queue(bed.store, &queue, &st), &st, "queue");
    pen_buf_release(&queue.ids);
    return queue;
}

static void expect_in_hand(int64_t running, int64_t hand_us)
{
    const struct pen_queue queue = read_facts();
    ck_assert_int_eq(queue.running, running);
    ck_assert_int_eq(queue.hand_us, hand_us);
}

/* What is left of the batch in hand is known by its job's estimate or rate. */
START_TEST(test_shares__the_queue_tells_what_is_left_of_the_batches_in_hand)
{
    struct pen_status st;
    open_bed();
    submit_many(1, 0, "10.0.0.1");
    store_worker_seen(bed.store, "w");
    struct pen_claim claim = store_claim(bed.store, "w");
    expect_in_hand(1, 0);
    store_must(pen_store_estimate(bed.store, &claim, 9000, NULL, &st), &st, "estimate");
    expect_in_hand(0, 9 * SECOND_US);
    store_run_sql(&bed, "UPDATE job SET spent_us = 4000000", NULL, 0);
    expect_in_hand(0, 5 * SECOND_US);
    store_run_sql(&bed, "UPDATE job SET estimate_ms = 80000000", NULL, 0);
    expect_in_hand(0, 60 * SECOND_US);
    store_run_sql(&bed, "UPDATE job SET estimate_ms = 0, done_pixels = total_pixels / 4", NULL, 0);
    expect_in_hand(0, 12 * SECOND_US);
    store_run_sql(&bed, "UPDATE job SET done_pixels = 0, spent_us = 0", NULL, 0);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    expect_in_hand(0, 0);
    store_bed_close(&bed);
}
END_TEST

static void expect_facts(int64_t running, int64_t workers, int64_t job_us)
{
    const struct pen_queue queue = read_facts();
    ck_assert_int_eq(queue.running, running);
    ck_assert_int_eq(queue.workers, workers);
    ck_assert_int_eq(queue.job_us, job_us);
}

/* The first 20 jobs take 9 s each, the last 50 take 2 s, but for some that take no time. */
START_TEST(test_shares__the_queue_tells_what_the_last_50_jobs_took_and_the_workers_of_now)
{
    const int64_t us[4] = {9 * SECOND_US, 2 * SECOND_US};
    open_bed();
    submit_many(20, 0, "10.0.0.1");
    store_worker_seen(bed.store, "w");
    expect_facts(0, 1, 0);
    serve_many(20, us);
    expect_facts(0, 1, 9 * SECOND_US);
    submit_many(25, 1, "10.0.0.1");
    serve_many(25, us);
    submit_many(5, 2, "10.0.0.1");
    serve_many(5, us);
    submit_many(25, 1, "10.0.0.1");
    serve_many(25, us);
    expect_facts(0, 1, 2 * SECOND_US);
    store_worker_seen(bed.store, "v");
    expect_facts(0, 2, 2 * SECOND_US);
    submit_many(3, 1, "10.0.0.1");
    struct pen_claim claim = store_claim(bed.store, "w");
    expect_facts(1, 2, 2 * SECOND_US);
    store_run_sql(&bed, "UPDATE worker SET seen_ms = seen_ms - 2 * lease_ms", NULL, 0);
    expect_facts(1, 1, 2 * SECOND_US); /* one has a lease */
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    expect_facts(0, 0, 2 * SECOND_US);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("shares", test_shares__the_queue_tells_what_is_left_of_the_batches_in_hand,
          test_shares__the_queue_tells_what_the_last_50_jobs_took_and_the_workers_of_now,
          test_shares__the_queue_is_in_the_order_in_which_jobs_begin,
          test_shares__clients_get_the_same_time_whatever_they_queue,
          test_shares__a_job_that_is_cancelled_has_taken_what_its_worker_had_not_told_yet,
          test_shares__it_is_time_that_is_shared_not_batches,
          test_shares__time_that_was_not_asked_for_is_not_owed, test_shares__debts_are_bounded,
          test_shares__short_jobs_share_with_the_long_one_before_them,
          test_shares__long_job_is_not_starved_by_short_ones_that_keep_coming,
          test_shares__what_waits_long_comes_before_higher_priorities_once,
          test_shares__time_in_which_a_batch_is_rendered_is_not_waited,
          test_shares__long_batch_gives_way_to_what_has_waited_long,
          test_shares__many_that_wait_long_take_every_other_batch,
          test_shares__new_clients_that_keep_coming_starve_nobody,
          test_shares__queue_is_bounded_in_all_and_for_each_client)
