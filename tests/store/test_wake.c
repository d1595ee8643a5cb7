/* SPDX-License-Identifier: MIT */
/* Signals: a wait ends when another thread or process changes the store, or when its time is up. */
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

/* A wait that a signal should end lasts MISSED_MS if the signal is missed, and less than SOON_MS if
 * not, also on a machine that is slow. */
enum { MISSED_MS = 1000 * SUITE_HANG_S, SOON_MS = MISSED_MS - 20000 };

/* Waits up to MISSED_MS; returns the ms it took. */
static int64_t time_to_wake(uint32_t seen)
{
    const int64_t begun_ns = pen_clock_ns();
    const uint32_t before = seen;
    pen_store_wait(bed.store, &seen, MISSED_MS);
    ck_assert_uint_ne(seen, before);
    ck_assert_uint_eq(seen, pen_store_changes());
    return (pen_clock_ns() - begun_ns) / 1000000;
}

START_TEST(test_wake__waiting_ends_when_time_is_up)
{
    store_bed_open(&bed);
    uint32_t seen = pen_store_changes();
    const int64_t begun_ns = pen_clock_ns();
    pen_store_wait(bed.store, &seen, 50);
    ck_assert_int_ge((pen_clock_ns() - begun_ns) / 1000000, 50);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_wake__a_signal_given_before_the_wait_ends_it_at_once)
{
    store_bed_open(&bed);
    const uint32_t seen = pen_store_changes();
    pen_store_wake(bed.store);
    ck_assert_int_lt(time_to_wake(seen), SOON_MS);
    store_bed_close(&bed);
}
END_TEST

static void *submit_later(void *arg)
{
    struct store_job in;
    struct pen_store *store = store_bed_handle(&bed);
    usleep(50000);
    store_job_init(&in, *(const int *)arg, 1, 1);
    store_job_submit(store, &in);
    pen_store_close(store);
    return NULL;
}

START_TEST(test_wake__a_submit_of_another_thread_ends_a_wait)
{
    pthread_t thread;
    int job = 1;
    store_bed_open(&bed);
    const uint32_t seen = pen_store_changes();
    ck_assert_int_eq(pthread_create(&thread, NULL, submit_later, &job), 0);
    ck_assert_int_lt(time_to_wake(seen), SOON_MS);
    pthread_join(thread, NULL);
    store_bed_close(&bed);
}
END_TEST

/* A child with a slot of its own submits as soon as it is told to. */
static void submit_when_told(int go, int job)
{
    char byte;
    pen_store_signals_join(1);
    if (read(go, &byte, 1) != 1)
        _exit(1);
    submit_later(&job);
    _exit(0);
}

START_TEST(test_wake__a_submit_of_another_process_ends_a_wait)
{
    struct pen_status st;
    int go[2];
    store_bed_open(&bed);
    pen_store_close(bed.store);
    store_must(pen_store_signals_make(2, &st), &st, "signals");
    for (int round = 0; round < 2; round++) { /* the second time, the child was started again */
        ck_assert_int_eq(pipe(go), 0);
        const pid_t pid = fork();
        ck_assert_int_ge(pid, 0);
        if (pid == 0)
            submit_when_told(go[0], round + 1);
        if (round == 0)
            pen_store_signals_join(0);
        bed.store = store_bed_handle(&bed);
        uint32_t seen = pen_store_changes();
        pen_store_wait(bed.store, &seen, 10); /* nobody looks without a signal here */
        seen = pen_store_changes();
        ck_assert_int_eq(write(go[1], "", 1), 1);
        ck_assert_int_lt(time_to_wake(seen), SOON_MS);
        ck_assert_int_eq(waitpid(pid, NULL, 0), pid);
        pen_store_close(bed.store);
    }
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 2);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store wake", test_wake__waiting_ends_when_time_is_up,
          test_wake__a_signal_given_before_the_wait_ends_it_at_once,
          test_wake__a_submit_of_another_thread_ends_a_wait,
          test_wake__a_submit_of_another_process_ends_a_wait)
