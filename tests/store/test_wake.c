/* SPDX-License-Identifier: MIT */
/* Signals: which calls give which, across processes, and without the file that carries them. */
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

static uint32_t count(enum pen_signal signal)
{
    uint32_t seen = UINT32_MAX;
    pen_store_wait(bed.store, signal, &seen, 0);
    return seen;
}

static void pause_ms(unsigned ms)
{
    usleep(ms * 1000);
}

/* A wait that a signal should end lasts MISSED_MS if the signal is missed, and less than SOON_MS if
 * not, also on a machine that is slow. */
enum { MISSED_MS = 1000 * SUITE_HANG_S, SOON_MS = MISSED_MS - 20000 };

/* Waits up to MISSED_MS; returns the ms it took. */
static int64_t time_to_wake(struct pen_store *store, enum pen_signal signal, uint32_t seen)
{
    int64_t begin = pen_clock_ns();
    uint32_t before = seen;
    pen_store_wait(store, signal, &seen, MISSED_MS);
    ck_assert_uint_ne(seen, before);
    return (pen_clock_ns() - begin) / 1000000;
}

START_TEST(test_wake__waiting_ends_when_time_is_up)
{
    store_bed_open(&bed);
    uint32_t seen = count(PEN_SIGNAL_WORK);
    int64_t begin = pen_clock_ns();
    pen_store_wait(bed.store, PEN_SIGNAL_WORK, &seen, 50);
    int64_t took = (pen_clock_ns() - begin) / 1000000;
    ck_assert_int_ge(took, 50);
    ck_assert_int_lt(took, SOON_MS);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_wake__signal_given_before_the_wait_ends_it_at_once)
{
    store_bed_open(&bed);
    uint32_t seen = count(PEN_SIGNAL_CHANGES);
    pen_store_wake(bed.store, PEN_SIGNAL_CHANGES);
    ck_assert_int_lt(time_to_wake(bed.store, PEN_SIGNAL_CHANGES, seen), SOON_MS);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_wake__submit_in_another_process_wakes_a_waiting_worker)
{
    int go[2];
    char byte = 0;
    ck_assert_int_eq(pipe(go), 0);
    store_bed_make(&bed);
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0) {
        struct store_job in;
        struct pen_store *store = store_bed_handle(&bed);
        store_job_init(&in, 1, 1, 1);
        if (read(go[0], &byte, 1) != 1)
            _exit(1);
        pause_ms(100);
        store_job_submit(store, &in);
        pen_store_close(store);
        _exit(0);
    }
    store_bed_open(&bed);
    uint32_t seen = count(PEN_SIGNAL_WORK);
    ck_assert_int_eq(write(go[1], &byte, 1), 1);
    ck_assert_int_lt(time_to_wake(bed.store, PEN_SIGNAL_WORK, seen), SOON_MS);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 1);
    waitpid(pid, NULL, 0);
    store_bed_close(&bed);
}
END_TEST

struct tally {
    uint32_t work, changes;
};

static struct tally take(void)
{
    return (struct tally){count(PEN_SIGNAL_WORK), count(PEN_SIGNAL_CHANGES)};
}

/* Whether the counters have grown since `last`, which becomes the present. */
static void expect(struct tally *last, bool work, bool changes, const char *what)
{
    struct tally now = take();
    ck_assert_msg((now.work != last->work) == work, "%s: work", what);
    ck_assert_msg((now.changes != last->changes) == changes, "%s: changes", what);
    *last = now;
}

START_TEST(test_wake__each_call_gives_the_signals_of_what_it_changed)
{
    store_bed_open(&bed);
    struct pen_status st;
    struct store_job in;
    int opened;
    struct tally last = take();
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    expect(&last, true, true, "submit");
    struct pen_claim one = store_claim(bed.store, "w");
    expect(&last, false, true, "first claim");
    struct pen_claim two = store_claim(bed.store, "w");
    expect(&last, false, false, "second claim");
    ck_assert_int_eq(store_commit(bed.store, &one), PEN_OK);
    expect(&last, false, true, "commit");
    store_must(pen_store_release(bed.store, &two, &st), &st, "release");
    expect(&last, true, false, "release");
    two = store_claim(bed.store, "w");
    store_must(pen_store_expire_leases(bed.store, "w", &opened, &st), &st, "expire");
    expect(&last, true, false, "expire");
    store_must(pen_store_expire_leases(bed.store, "w", &opened, &st), &st, "expire");
    expect(&last, false, false, "expire nothing");
    two = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &two), PEN_OK);
    expect(&last, true, true, "commit that adds the assemble batch");
    ck_assert_int_eq(store_commit(bed.store, &two), PEN_OK);
    expect(&last, false, false, "duplicate commit");
    ck_assert(!pen_store_delete(bed.store, in.id, NULL, NULL, &st));
    expect(&last, false, false, "refused delete");
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    expect(&last, false, true, "cancel");
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    expect(&last, false, false, "cancel again");
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    expect(&last, false, true, "delete");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_wake__file_missing_short_or_unusable_is_no_failure)
{
    store_bed_open(&bed);
    pen_store_close(bed.store);
    char path[128];
    snprintf(path, sizeof path, "%s-wake", bed.url);
    for (int i = 0; i < 2; i++) {
        if (i == 0)
            ck_assert_int_eq(unlink(path), 0);
        else
            ck_assert_int_eq(truncate(path, 3), 0);
        bed.store = store_bed_handle(&bed);
        uint32_t seen = count(PEN_SIGNAL_WORK);
        pen_store_wake(bed.store, PEN_SIGNAL_WORK);
        ck_assert_uint_eq(count(PEN_SIGNAL_WORK), seen + 1);
        pen_store_close(bed.store);
    }
    bed.store = store_bed_handle(&bed);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store wake", test_wake__waiting_ends_when_time_is_up,
          test_wake__signal_given_before_the_wait_ends_it_at_once,
          test_wake__submit_in_another_process_wakes_a_waiting_worker,
          test_wake__each_call_gives_the_signals_of_what_it_changed,
          test_wake__file_missing_short_or_unusable_is_no_failure)
