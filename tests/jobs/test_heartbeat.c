/* SPDX-License-Identifier: MIT */
/* The heartbeat and render threads that do not stop. Threads that work on are stuck. Threads that
 * got no processor are not, however busy the rest of the process and of the machine is. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

#include "base/clock.h"
#include "jobs/internal/heartbeat.h"
#include "support/store.h"
#include "support/suite.h"

/* Threads that use no processor count as stuck after ten seconds. */
enum { THREADS = 4, BUSY_MS = 1500, IDLE_MS = 10000, WAIT_MS = 60000, STEP_MS = 10 };

static struct store_bed bed;
static struct pen_thread_pool *pool;
static struct pen_heartbeat *heart;
static pthread_t runner;
static struct store_job job;
static atomic_bool works, done;
static atomic_int reports;
static atomic_llong worked_ns, worked_at_report_ns;

static void report(void *user)
{
    (void)user;
    if (atomic_fetch_add(&reports, 1) == 0)
        atomic_store(&worked_at_report_ns, atomic_load(&worked_ns));
}

static void pause_ms(int ms)
{
    const struct timespec pause = {.tv_nsec = ms * 1000000L};
    nanosleep(&pause, NULL);
}

/* Render threads that do not stop when they are told to. One of them works at times. */
static void work_on(void *user, int index)
{
    (void)user;
    while (!atomic_load(&done)) {
        if (index == 1 && atomic_load(&works))
            atomic_store(&worked_ns, pen_clock_thread_ns());
        else
            pause_ms(STEP_MS);
    }
}

static void *run(void *user)
{
    pen_thread_pool_run(pool, THREADS, work_on, user);
    return NULL;
}

static void begin(void)
{
    static struct pen_worker_options options;
    enum pen_submit_result result;
    struct pen_status st;
    store_bed_open(&bed);
    store_job_init(&job, 0, 1, 1);
    store_must(pen_store_submit(bed.store, &job.job, &result, NULL, &st), &st, "submit");
    const struct pen_claim claim = store_claim(bed.store, "w");
    options = (struct pen_worker_options){.store_url = bed.url, .stuck = report};
    pool = pen_thread_pool_new(THREADS, &st);
    heart = pool ? pen_heartbeat_new(&options, pool, STORE_LEASE_MS, NULL, NULL, &st) : NULL;
    store_must(heart != NULL, &st, "heartbeat");
    pen_heartbeat_begin(heart, &claim, NULL);
    ck_assert_int_eq(pthread_create(&runner, NULL, run, NULL), 0);
}

/* Cancels the job; the render threads have been told to stop then. */
static void cancel(void)
{
    struct pen_status st;
    store_must(pen_store_cancel(bed.store, job.id, NULL, &st), &st, "cancel");
    for (int ms = 0; ms < WAIT_MS && !atomic_load(pen_heartbeat_cancel_flag(heart)); ms += STEP_MS)
        pause_ms(STEP_MS);
    ck_assert(atomic_load(pen_heartbeat_cancel_flag(heart)));
}

static void finish(void)
{
    atomic_store(&done, true);
    pthread_join(runner, NULL);
    ck_assert_int_eq(pen_heartbeat_end(heart), PEN_CLAIM_LOST);
    pen_heartbeat_free(heart);
    pen_thread_pool_free(pool);
    store_bed_close(&bed);
}

/* Waits until the render thread has worked for so long. */
static void wait_for_work(int ms)
{
    const long long until_ns = atomic_load(&worked_ns) + ms * 1000000LL;
    while (atomic_load(&worked_ns) < until_ns)
        pause_ms(STEP_MS);
}

static void wait_for_report(void)
{
    for (int ms = 0; ms < WAIT_MS && atomic_load(&reports) == 0; ms += STEP_MS)
        pause_ms(STEP_MS);
    ck_assert_int_gt(atomic_load(&reports), 0);
}

START_TEST(test_heartbeat__threads_that_work_on_are_stuck_soon)
{
    atomic_store(&works, true);
    begin();
    cancel();
    const long long told_ns = atomic_load(&worked_ns);
    wait_for_report();
    const long long ms = (atomic_load(&worked_at_report_ns) - told_ns) / 1000000;
    printf("# reported after %lld ms of work\n", ms);
    ck_assert_int_lt(ms, IDLE_MS / 2);
    finish();
}
END_TEST

/* What they did before they were told to stop does not count, nor what other threads do. */
START_TEST(test_heartbeat__threads_without_a_processor_are_not_stuck)
{
    atomic_store(&works, true);
    begin();
    wait_for_work(BUSY_MS / 2);
    atomic_store(&works, false);
    pause_ms(10 * STEP_MS);
    cancel();
    const int64_t told_ns = pen_clock_ns(), busy_ns = pen_clock_thread_ns();
    while (pen_clock_thread_ns() - busy_ns < BUSY_MS * INT64_C(1000000))
        continue;
    const int count = atomic_load(&reports);
    if ((pen_clock_ns() - told_ns) / 1000000 < IDLE_MS - 1000)
        ck_assert_int_eq(count, 0);
    finish();
}
END_TEST

/* While the worker waits for the store, it has no render threads that could be stuck. */
START_TEST(test_heartbeat__no_thread_is_stuck_while_the_clock_is_stopped)
{
    atomic_store(&works, true);
    begin();
    pen_heartbeat_pause(heart);
    cancel();
    wait_for_work(BUSY_MS);
    ck_assert_int_eq(atomic_load(&reports), 0);
    pen_heartbeat_resume(heart);
    wait_for_report();
    finish();
}
END_TEST

PEN_SUITE("heartbeat", test_heartbeat__threads_that_work_on_are_stuck_soon,
          test_heartbeat__threads_without_a_processor_are_not_stuck,
          test_heartbeat__no_thread_is_stuck_while_the_clock_is_stopped)
