/* SPDX-License-Identifier: MIT */
/* Locks of workers: the leases of a killed worker are released at once, those of a living worker
 * never, also when the file of the locks is removed or replaced under it. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "support/store.h"
#include "support/suite.h"

static const char worker[] = "0123456789abcdef0123456789abcdef";

static struct store_bed bed;

/* A worker in a process of its own that holds one lease. */
struct holder {
    pid_t pid;
    int up[2], down[2]; /* pipes from it and to it */
};

/* In the holder's process: exits with 0 if its commit is accepted. */
static _Noreturn void hold(const struct holder *holder, int64_t lease_ms)
{
    struct pen_status st;
    struct pen_claim claim = {0};
    bool found = false;
    char byte = 0;
    struct pen_store *store = store_bed_handle(&bed);
    store_must(pen_store_worker_lock(store, worker, &st), &st, "lock");
    store_worker_seen(store, worker);
    store_must(pen_store_claim(store, worker, lease_ms, &claim, &found, &st), &st, "claim");
    if (!found || write(holder->up[1], &byte, 1) != 1 || read(holder->down[0], &byte, 1) != 1)
        _exit(2);
    enum pen_code code = store_commit(store, &claim);
    pen_store_close(store);
    _exit(code == PEN_OK ? 0 : 1);
}

/* Makes a store with a job and starts a process that holds its first batch. Opens no handle: none
 * must be carried across the fork. */
static struct holder start_holder(struct store_job *in, int batches, int64_t lease_ms)
{
    struct holder holder;
    char byte;
    store_bed_make(&bed);
    struct pen_store *store = store_bed_handle(&bed);
    store_job_init(in, 1, 1, batches);
    store_job_submit(store, in);
    pen_store_close(store);
    ck_assert(pipe(holder.up) == 0 && pipe(holder.down) == 0);
    holder.pid = fork();
    ck_assert_int_ge(holder.pid, 0);
    if (holder.pid == 0)
        hold(&holder, lease_ms);
    ck_assert_int_eq(read(holder.up[0], &byte, 1), 1);
    return holder;
}

static int wait_for(const struct holder *holder)
{
    int status;
    ck_assert_int_eq(waitpid(holder->pid, &status, 0), holder->pid);
    for (int i = 0; i < 2; i++) {
        close(holder->up[i]);
        close(holder->down[i]);
    }
    return status;
}

static void kill_holder(const struct holder *holder)
{
    kill(holder->pid, SIGKILL);
    ck_assert(WIFSIGNALED(wait_for(holder)));
}

static bool commits(const struct holder *holder)
{
    ck_assert_int_eq(write(holder->down[1], "", 1), 1);
    int status = wait_for(holder);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static int release_dead(void)
{
    struct pen_status st;
    int opened = -1;
    store_must(pen_store_release_dead(bed.store, &opened, &st), &st, "release dead");
    return opened;
}

static bool count_worker(void *user, const struct pen_worker_record *record)
{
    *(int *)user += strcmp(record->id, worker) == 0;
    return true;
}

static int listed(void)
{
    struct pen_status st;
    int count = 0;
    store_must(pen_store_workers(bed.store, count_worker, &count, &st), &st, "workers");
    return count;
}

START_TEST(test_worker_lock__killed_worker_loses_its_leases_at_once)
{
    struct store_job in;
    struct holder holder = start_holder(&in, 1, 3600000);
    store_bed_open(&bed);
    ck_assert_int_eq(release_dead(), 0);
    ck_assert_int_eq(listed(), 1);
    kill_holder(&holder);
    ck_assert_int_eq(release_dead(), 1);
    ck_assert_int_eq(listed(), 0);
    ck_assert_int_eq(release_dead(), 0);
    struct pen_claim claim = store_claim(bed.store, "v");
    ck_assert_int_eq(claim.attempt, 2);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

static const char *lock_file(void)
{
    static char path[128];
    snprintf(path, sizeof path, "%s-wake", bed.url);
    return path;
}

/* Ways in which the file is lost: removed; removed and made anew by the next handle; replaced by
 * another file. */
enum { REMOVED, MADE_ANEW, REPLACED, WAYS };

static void lose_lock_file(int way)
{
    char other[160];
    snprintf(other, sizeof other, "%s-other", bed.url);
    if (way == REMOVED)
        store_bed_open(&bed);
    if (way == REPLACED) {
        FILE *file = fopen(other, "wb");
        ck_assert(file && fclose(file) == 0);
        ck_assert_int_eq(rename(other, lock_file()), 0);
    } else {
        ck_assert_int_eq(unlink(lock_file()), 0);
    }
    if (way != REMOVED)
        store_bed_open(&bed);
    ck_assert_int_eq(access(lock_file(), F_OK) == 0, way != REMOVED);
}

START_TEST(test_worker_lock__living_worker_keeps_its_leases_without_the_file)
{
    for (int way = 0; way < WAYS; way++) {
        struct store_job in;
        struct holder holder = start_holder(&in, 1, 3600000);
        lose_lock_file(way);
        ck_assert_msg(release_dead() == 0, "way %d", way);
        ck_assert_msg(listed() == 1, "way %d", way);
        ck_assert_msg(commits(&holder), "way %d", way);
        ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
        store_bed_close(&bed);
    }
}
END_TEST

START_TEST(test_worker_lock__leases_expire_where_nobody_can_tell_who_lives)
{
    for (int way = 0; way < WAYS; way++) {
        struct store_job in;
        struct pen_status st;
        int opened = 0;
        struct holder holder = start_holder(&in, 1, 300);
        lose_lock_file(way);
        kill_holder(&holder);
        ck_assert_msg(release_dead() == 0, "way %d", way);
        nanosleep(&(struct timespec){.tv_nsec = 400000000}, NULL);
        store_must(pen_store_expire_leases(bed.store, NULL, &opened, &st), &st, "expire");
        ck_assert_msg(opened == 1, "way %d", way);
        store_work_off(bed.store, "v");
        ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
        store_bed_close(&bed);
    }
}
END_TEST

/* Leases of a store that an earlier schema has left: their holders have no rows. */
START_TEST(test_worker_lock__holder_without_a_row_is_judged_by_its_lock)
{
    struct store_job in;
    struct pen_status st;
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    store_claim(bed.store, worker);
    store_must(pen_store_worker_lock(bed.store, worker, &st), &st, "lock");
    store_claim(bed.store, "gone");
    ck_assert_int_eq(release_dead(), 1);
    pen_store_close(bed.store);
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(release_dead(), 1);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_worker_lock__is_of_one_handle)
{
    struct pen_status st;
    store_bed_open(&bed);
    struct pen_store *other = store_bed_handle(&bed);
    store_must(pen_store_worker_lock(other, worker, &st), &st, "lock");
    ck_assert(!pen_store_worker_lock(bed.store, worker, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    store_must(pen_store_worker_lock(bed.store, "another", &st), &st, "lock");
    pen_store_close(other);
    store_must(pen_store_worker_lock(bed.store, worker, &st), &st, "lock");
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store worker lock", test_worker_lock__killed_worker_loses_its_leases_at_once,
          test_worker_lock__living_worker_keeps_its_leases_without_the_file,
          test_worker_lock__leases_expire_where_nobody_can_tell_who_lives,
          test_worker_lock__holder_without_a_row_is_judged_by_its_lock,
          test_worker_lock__is_of_one_handle)
