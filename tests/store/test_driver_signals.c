/* SPDX-License-Identifier: MIT */
/* Contract of a driver: waiting for a signal and waking those who wait, between threads and between
 * processes; the words and the lock that a store's health is shared by. */
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/driver.h"
#include "support/suite.h"

static struct driver_bed bed;

static uint32_t counter(struct pen_driver *driver, enum pen_signal signal)
{
    uint32_t seen = UINT32_MAX;
    driver->ops->wait(driver, signal, &seen, 0);
    return seen;
}

/* A wait that a signal should end lasts MISSED_MS if the signal is missed, and less than SOON_MS if
 * not, also on a machine that is slow. */
enum { MISSED_MS = 1000 * SUITE_HANG_S, SOON_MS = MISSED_MS - 20000 };

/* Waits up to MISSED_MS for a signal after `seen`; returns the ms it took. */
static int64_t time_to_wake(struct pen_driver *driver, enum pen_signal signal, uint32_t seen)
{
    int64_t begin = pen_clock_ns();
    uint32_t before = seen;
    driver->ops->wait(driver, signal, &seen, MISSED_MS);
    ck_assert_uint_ne(seen, before);
    return (pen_clock_ns() - begin) / 1000000;
}

START_TEST(test_driver_signals__wait_without_a_signal_ends_in_time)
{
    driver_bed_open(&bed, _i);
    uint32_t seen = counter(bed.driver, PEN_SIGNAL_WORK), before = seen;
    int64_t begin = pen_clock_ns();
    bed.driver->ops->wait(bed.driver, PEN_SIGNAL_WORK, &seen, 50);
    int64_t took_ms = (pen_clock_ns() - begin) / 1000000;
    ck_assert(seen != before || took_ms >= 50); /* a counter may change without a signal */
    ck_assert_int_lt(took_ms, SOON_MS);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_signals__signal_given_before_the_wait_is_not_missed)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    uint32_t seen = counter(bed.driver, PEN_SIGNAL_CHANGES);
    other->ops->wake(other, PEN_SIGNAL_CHANGES);
    ck_assert_int_lt(time_to_wake(bed.driver, PEN_SIGNAL_CHANGES, seen), SOON_MS);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_signals__signals_are_told_apart)
{
    bool apart = false;
    driver_bed_open(&bed, _i);
    for (int i = 0; i < 5 && !apart; i++) { /* a counter may change without a signal, but seldom */
        uint32_t work = counter(bed.driver, PEN_SIGNAL_WORK);
        uint32_t changes = counter(bed.driver, PEN_SIGNAL_CHANGES), before = changes;
        bed.driver->ops->wake(bed.driver, PEN_SIGNAL_WORK);
        ck_assert_int_lt(time_to_wake(bed.driver, PEN_SIGNAL_WORK, work), SOON_MS);
        bed.driver->ops->wait(bed.driver, PEN_SIGNAL_CHANGES, &changes, 20);
        apart = changes == before;
    }
    ck_assert(apart);
    driver_bed_close(&bed);
}
END_TEST

/* A thread that waits with a handle. */
struct waiter {
    struct pen_driver *driver;
    uint32_t seen;
    int64_t took_ms;
};

static void *wait_for_work(void *arg)
{
    struct waiter *waiter = arg;
    waiter->took_ms = time_to_wake(waiter->driver, PEN_SIGNAL_WORK, waiter->seen);
    return NULL;
}

/* Starts threads that wait, each with its handle, and gives them time to begin. */
static void start(pthread_t *thread, struct waiter *waiter, int count)
{
    for (int i = 0; i < count; i++) {
        waiter[i].seen = counter(waiter[i].driver, PEN_SIGNAL_WORK);
        ck_assert_int_eq(pthread_create(&thread[i], NULL, wait_for_work, &waiter[i]), 0);
    }
    usleep(100000);
}

static void join(const pthread_t *thread, const struct waiter *waiter, int count)
{
    for (int i = 0; i < count; i++) {
        pthread_join(thread[i], NULL);
        ck_assert_int_lt(waiter[i].took_ms, SOON_MS);
    }
}

START_TEST(test_driver_signals__wake_ends_the_waits_of_all_threads)
{
    enum { WAITERS = 3 };
    pthread_t thread[WAITERS];
    struct waiter waiter[WAITERS];
    driver_bed_open(&bed, _i);
    for (int i = 0; i < WAITERS; i++)
        waiter[i].driver = driver_bed_handle(&bed);
    start(thread, waiter, WAITERS);
    bed.driver->ops->wake(bed.driver, PEN_SIGNAL_WORK);
    join(thread, waiter, WAITERS);
    for (int i = 0; i < WAITERS; i++)
        waiter[i].driver->ops->close(waiter[i].driver);
    driver_bed_close(&bed);
}
END_TEST

/* One thread waits with a handle while another works with it, and wakes it with it. */
START_TEST(test_driver_signals__handle_in_use_may_wait_and_be_woken)
{
    pthread_t thread;
    driver_bed_open(&bed, _i);
    struct waiter waiter = {.driver = bed.driver};
    start(&thread, &waiter, 1);
    driver_submit_new(bed.driver, 1, 1, 1, 0);
    bed.driver->ops->wake(bed.driver, PEN_SIGNAL_WORK);
    join(&thread, &waiter, 1);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_signals__wake_reaches_other_processes)
{
    int ready[2];
    char byte;
    driver_bed_open(&bed, _i);
    bed.driver->ops->close(bed.driver);
    ck_assert_int_eq(pipe(ready), 0);
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0) {
        struct pen_driver *driver = driver_bed_handle(&bed);
        uint32_t seen = counter(driver, PEN_SIGNAL_WORK);
        if (write(ready[1], "x", 1) != 1)
            _exit(1);
        _exit(time_to_wake(driver, PEN_SIGNAL_WORK, seen) < 10000 ? 0 : 2);
    }
    int status;
    bed.driver = driver_bed_handle(&bed);
    close(ready[1]); /* a child that fails ends the read */
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    usleep(100000);
    bed.driver->ops->wake(bed.driver, PEN_SIGNAL_WORK);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    ck_assert_int_eq(status, 0);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_signals__health_words_are_zero_at_first_and_shared)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    _Atomic uint32_t *mine = bed.driver->ops->health_words(bed.driver);
    _Atomic uint32_t *theirs = other->ops->health_words(other);
    for (uint32_t i = 0; i < PEN_HEALTH_WORDS; i++) {
        ck_assert_uint_eq(atomic_load(&mine[i]), 0);
        atomic_store(&mine[i], 100 + i);
        ck_assert_uint_eq(atomic_load(&theirs[i]), 100 + i);
    }
    bed.driver->ops->wake(bed.driver, PEN_SIGNAL_WORK);
    bed.driver->ops->wake(bed.driver, PEN_SIGNAL_CHANGES);
    for (uint32_t i = 0; i < PEN_HEALTH_WORDS; i++) /* they are no counters of signals */
        ck_assert_uint_eq(atomic_load(&theirs[i]), 100 + i);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_signals__repair_is_locked_by_one)
{
    int mine = -1, theirs = -1;
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    ck_assert(bed.driver->ops->repair_lock(bed.driver, &mine));
    ck_assert(!other->ops->repair_lock(other, &theirs));
    bed.driver->ops->repair_unlock(bed.driver, mine);
    ck_assert(other->ops->repair_lock(other, &theirs));
    ck_assert(!bed.driver->ops->repair_lock(bed.driver, &mine));
    other->ops->repair_unlock(other, theirs);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

/* Waits for a byte of `go`, takes the lock, writes a byte to `ready`, and keeps the lock. */
static void lock_and_stay(const int go[2], const int ready[2])
{
    struct pen_driver *driver = driver_bed_handle(&bed);
    char byte;
    int lock;
    if (read(go[0], &byte, 1) != 1 || !driver->ops->repair_lock(driver, &lock) ||
        write(ready[1], "x", 1) != 1)
        _exit(1);
    for (;;)
        pause();
}

START_TEST(test_driver_signals__repair_lock_ends_with_its_process)
{
    int go[2], ready[2], lock = -1;
    char byte;
    driver_bed_open(&bed, _i);
    bed.driver->ops->close(bed.driver);
    ck_assert_int_eq(pipe(go), 0);
    ck_assert_int_eq(pipe(ready), 0);
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0)
        lock_and_stay(go, ready);
    close(ready[1]);
    bed.driver = driver_bed_handle(&bed); /* before: a driver may open no handle during a repair */
    ck_assert_int_eq(write(go[1], "x", 1), 1);
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    ck_assert(!bed.driver->ops->repair_lock(bed.driver, &lock));
    ck_assert_int_eq(kill(pid, SIGKILL), 0);
    ck_assert_int_eq(waitpid(pid, NULL, 0), pid);
    ck_assert(bed.driver->ops->repair_lock(bed.driver, &lock));
    bed.driver->ops->repair_unlock(bed.driver, lock);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: signals", test_driver_signals__wait_without_a_signal_ends_in_time,
             test_driver_signals__signal_given_before_the_wait_is_not_missed,
             test_driver_signals__signals_are_told_apart,
             test_driver_signals__wake_ends_the_waits_of_all_threads,
             test_driver_signals__handle_in_use_may_wait_and_be_woken,
             test_driver_signals__wake_reaches_other_processes,
             test_driver_signals__health_words_are_zero_at_first_and_shared,
             test_driver_signals__repair_is_locked_by_one,
             test_driver_signals__repair_lock_ends_with_its_process)
