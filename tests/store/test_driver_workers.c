/* SPDX-License-Identifier: MIT */
/* Contract of a driver: the list of workers, and the locks by which the living are ready from the
 * dead. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/driver.h"

static struct driver_bed bed;

static void put(const char *id, int threads, int64_t now_ms)
{
    struct pen_worker_new worker = {
        .id = id, .host = "host", .pid = 4000000000, .threads = threads, .lease_ms = 1000};
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, worker_put, &worker, now_ms);
    DRIVER_RUN(bed.driver, commit);
}

/* The list, with its texts, until the next call. */
static struct pen_worker_record *list(int *count)
{
    static struct pen_arena *arena;
    struct pen_worker_record *rows;
    pen_arena_free(arena);
    arena = pen_arena_new(0);
    DRIVER_DO(bed.driver, worker_list, arena, &rows, count);
    return rows;
}

START_TEST(test_driver_workers__are_listed_oldest_first_with_what_they_hold)
{
    int count = -1;
    driver_bed_open(&bed, _i);
    list(&count);
    ck_assert_int_eq(count, 0);
    struct driver_job job = driver_submit_new(bed.driver, 1, 2, 2, 0);
    put("b", 2, 500);
    put("a", 3, 600);
    driver_lease(bed.driver, job.batch[3], 7, "a", 1650); /* as if seen at 650 */
    driver_lease(bed.driver, job.batch[1], 1, "a", 1200); /* extended before that */
    struct pen_worker_record *rows = list(&count);
    ck_assert_int_eq(count, 3);
    ck_assert_str_eq(rows[0].id, "b");
    ck_assert_ptr_null(rows[0].job_id);
    ck_assert_str_eq(rows[0].host, "host");
    ck_assert_int_eq(rows[0].pid, 4000000000);
    ck_assert_int_eq(rows[0].threads, 2);
    ck_assert_int_eq(rows[0].started_ms, 500);
    ck_assert_int_eq(rows[0].seen_ms, 500);
    for (int i = 1; i < 3; i++) {
        ck_assert_str_eq(rows[i].id, "a");
        ck_assert_str_eq(rows[i].job_id, "01900000-0000-7000-8000-000000000001");
        ck_assert_str_eq(rows[i].view, i == 1 ? "a" : "b"); /* the names of the job's views */
        ck_assert_int_eq(rows[i].batch, job.batch[i == 1 ? 1 : 3]);
        ck_assert_int_eq(rows[i].attempt, i == 1 ? 1 : 7);
        ck_assert_int_eq(rows[i].kind, PEN_BATCH_RENDER);
        ck_assert_int_eq(rows[i].pixels, 16);
        ck_assert_int_eq(rows[i].seen_ms, i == 1 ? 600 : 650);
    }
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_workers__put_again_are_seen_again)
{
    int count;
    driver_bed_open(&bed, _i);
    put("a", 3, 600);
    put("a", 5, 900);
    struct pen_worker_record *rows = list(&count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(rows[0].started_ms, 600);
    ck_assert_int_eq(rows[0].seen_ms, 900);
    ck_assert_int_eq(rows[0].threads, 5);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_workers__are_removed_by_id_or_by_age)
{
    int count;
    driver_bed_open(&bed, _i);
    put("a", 1, 100);
    put("b", 1, 200);
    put("c", 1, 300);
    put("d", 1, 400);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, worker_remove, "c");
    DRIVER_DO(bed.driver, worker_remove, "nobody");
    DRIVER_DO(bed.driver, workers_remove, 200);
    DRIVER_RUN(bed.driver, commit);
    struct pen_worker_record *rows = list(&count);
    ck_assert_int_eq(count, 2);
    ck_assert_str_eq(rows[0].id, "b");
    ck_assert_str_eq(rows[1].id, "d");
    driver_bed_close(&bed);
}
END_TEST

/* The ids after one, in a page of at most so many, as one text. */
static void expect_ids(const char *after, int capacity, const char *expected)
{
    struct pen_arena *arena = pen_arena_new(0);
    const char *ids[8];
    char text[32] = "";
    int count = -1;
    DRIVER_DO(bed.driver, worker_id_page, after, arena, ids, capacity, &count);
    ck_assert_int_le(count, capacity);
    for (int i = 0; i < count; i++)
        strcat(text, ids[i]);
    ck_assert_str_eq(text, expected);
    pen_arena_free(arena);
}

START_TEST(test_driver_workers__ids_are_of_all_on_the_list_and_all_with_leases)
{
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 4, 0);
    expect_ids("", 8, "");
    put("b", 1, 100);
    put("d", 1, 100);
    driver_lease(bed.driver, job.batch[0], 1, "c", 1000);
    driver_lease(bed.driver, job.batch[1], 1, "a", 1000);
    driver_lease(bed.driver, job.batch[2], 1, "b", 1000);
    driver_lease(bed.driver, job.batch[3], 1, "b", 1000);
    expect_ids("", 8, "abcd");
    expect_ids("", 2, "ab");
    expect_ids("b", 2, "cd");
    expect_ids("d", 2, "");
    driver_bed_close(&bed);
}
END_TEST

static bool lives(struct pen_driver *driver, const char *id)
{
    bool alive = false;
    DRIVER_DO(driver, worker_lives, id, &alive);
    return alive;
}

static void expect_taken(struct pen_driver *driver, const char *id)
{
    struct pen_status st = {0};
    ck_assert(!driver->ops->worker_lock(driver, id, &st));
    ck_assert_msg(st.code == PEN_CONFLICT, "%s", st.msg);
}

START_TEST(test_driver_workers__lock_lasts_as_long_as_its_handle)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    ck_assert(!lives(bed.driver, "w"));
    DRIVER_DO(bed.driver, worker_lock, "w");
    ck_assert(lives(bed.driver, "w"));
    ck_assert(lives(other, "w"));
    ck_assert(!lives(other, "x"));
    expect_taken(other, "w");
    DRIVER_DO(other, worker_lock, "x");
    ck_assert(lives(bed.driver, "x"));
    other->ops->close(other);
    ck_assert(!lives(bed.driver, "x"));
    ck_assert(lives(bed.driver, "w")); /* closing another handle has left it */
    DRIVER_DO(bed.driver, worker_lock, "x");
    ck_assert(lives(bed.driver, "w"));
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_workers__lock_outlives_transactions)
{
    driver_bed_open(&bed, _i);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, worker_lock, "w");
    bed.driver->ops->rollback(bed.driver);
    ck_assert(lives(bed.driver, "w"));
    put("w", 1, 100);
    ck_assert(lives(bed.driver, "w"));
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_workers__lock_ends_at_once_with_its_process)
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
        DRIVER_DO(driver, worker_lock, "w");
        if (write(ready[1], "x", 1) != 1)
            _exit(1);
        for (;;)
            pause();
    }
    close(ready[1]); /* a child that fails ends the read */
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    bed.driver = driver_bed_handle(&bed);
    ck_assert(lives(bed.driver, "w"));
    expect_taken(bed.driver, "w");
    ck_assert_int_eq(kill(pid, SIGKILL), 0);
    ck_assert_int_eq(waitpid(pid, NULL, 0), pid);
    ck_assert(!lives(bed.driver, "w"));
    DRIVER_DO(bed.driver, worker_lock, "w");
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: workers", test_driver_workers__are_listed_oldest_first_with_what_they_hold,
             test_driver_workers__put_again_are_seen_again,
             test_driver_workers__are_removed_by_id_or_by_age,
             test_driver_workers__ids_are_of_all_on_the_list_and_all_with_leases,
             test_driver_workers__lock_lasts_as_long_as_its_handle,
             test_driver_workers__lock_outlives_transactions,
             test_driver_workers__lock_ends_at_once_with_its_process)
