/* SPDX-License-Identifier: MIT */
/* The heartbeat and render threads that do not stop: those that work on are stuck, and those that
 * got no processor are not, however busy the rest of the process and of the machine is. */
#include <pthread.h>
#include <stdatomic.h>

#include "base/clock.h"
#include "jobs/internal/heartbeat.h"
#include "support/store.h"
#include "support/suite.h"

enum { IDLE_MS = 3000, WAIT_MS = 60000, STEP_MS = 10 };

static struct store_bed bed;
static struct pen_thread_pool *pool;
static struct pen_heartbeat *heart;
static pthread_t runner;
static atomic_bool done;
static atomic_int reports;

static void report(void *user)
{
    (void)user;
    atomic_fetch_add(&reports, 1);
}

static void pause_ms(int ms)
{
    const struct timespec pause = {.tv_nsec = ms * 1000000L};
    nanosleep(&pause, NULL);
}

/* Render threads that are told to stop and do not: one that uses a processor, and some that do
 * not get any. */
static void work_on(void *user, int index)
{
    const bool *works = user;
    while (!atomic_load(&done))
        if (!*works || index != 1)
            pause_ms(STEP_MS);
}

static void *run(void *works)
{
    pen_thread_pool_run(pool, pen_thread_pool_size(pool), work_on, works);
    return NULL;
}

/* Cancels a job while it is rendered. */
static void begin(bool *works)
{
    static struct pen_worker_options options;
    struct pen_status st;
    struct store_job job;
    enum pen_submit_result result;
    store_bed_open(&bed);
    store_job_init(&job, 0, 1, 1);
    store_must(pen_store_submit(bed.store, &job.job, &result, NULL, &st), &st, "submit");
    const struct pen_claim claim = store_claim(bed.store, "w");
    options = (struct pen_worker_options){.store_url = bed.url, .stuck = report};
    pool = pen_thread_pool_new(4, &st);
    heart = pen_heartbeat_new(&options, pool, STORE_LEASE_MS, &st);
    store_must(pool && heart, &st, "heartbeat");
    pen_heartbeat_begin(heart, &claim, NULL);
    ck_assert_int_eq(pthread_create(&runner, NULL, run, works), 0);
    store_must(pen_store_cancel(bed.store, job.id, &st), &st, "cancel");
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

START_TEST(test_heartbeat__threads_that_work_on_are_stuck)
{
    bool works = true;
    begin(&works);
    for (int ms = 0; ms < WAIT_MS && atomic_load(&reports) == 0; ms += STEP_MS)
        pause_ms(STEP_MS);
    ck_assert_int_gt(atomic_load(&reports), 0);
    finish();
}
END_TEST

START_TEST(test_heartbeat__threads_without_a_processor_are_not_stuck)
{
    bool works = false;
    begin(&works);
    for (int64_t end_ns = pen_clock_ns() + IDLE_MS * INT64_C(1000000); pen_clock_ns() < end_ns;)
        continue; /* this thread takes the processor instead */
    ck_assert_int_eq(atomic_load(&reports), 0);
    finish();
}
END_TEST

PEN_SUITE("heartbeat", test_heartbeat__threads_that_work_on_are_stuck,
          test_heartbeat__threads_without_a_processor_are_not_stuck)
