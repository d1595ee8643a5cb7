/* SPDX-License-Identifier: MIT */
/* The store as a file: which files are opened, and which are refused and left unchanged. The file
 * and its log stay small. Many processes may use it at once. */
#include <fcntl.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/faults.h"
#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;

static void write_file(const char *path, const void *data, size_t bytes)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(write(fd, data, bytes), (ssize_t)bytes);
    close(fd);
}

static unsigned char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    unsigned char *data = malloc(1 << 24);
    ck_assert_ptr_nonnull(data);
    *bytes = fread(data, 1, 1 << 24, file);
    fclose(file);
    return data;
}

static void remove_bed(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", bed.folder);
    ck_assert_int_eq(system(command), 0);
    bed = (struct store_bed){0};
}

/* Opening must fail with a message that contains `hint`, and leave the file unchanged. */
static void refuse(const char *hint)
{
    struct pen_status st = {0};
    size_t before_bytes, after_bytes;
    unsigned char *before = read_file(bed.url, &before_bytes);
    struct pen_store *store = pen_store_open(bed.url, false, &st);
    if (store) {
        bool finished;
        ck_assert(!pen_store_check(store, 0, &finished, &st));
        pen_store_close(store);
    }
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_msg(strstr(st.msg, hint) != NULL, "\"%s\" lacks \"%s\"", st.msg, hint);
    unsigned char *after = read_file(bed.url, &after_bytes);
    ck_assert_uint_eq(after_bytes, before_bytes);
    ck_assert_mem_eq(after, before, before_bytes);
    free(before);
    free(after);
}

/* A bed whose store is closed, with one finished job in it. */
static void closed_bed(void)
{
    struct store_job in;
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    store_work_off(bed.store, "w");
    pen_store_close(bed.store);
}

START_TEST(test_sqlite_file__what_was_stored_is_there_after_reopening)
{
    closed_bed();
    bed.store = store_bed_handle(&bed);
    struct store_job in;
    store_job_init(&in, 1, 1, 2);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_sqlite_file__folders_are_made_and_all_is_private)
{
    store_bed_open(&bed);
    char folder[160], url[256];
    snprintf(folder, sizeof folder, "%s/state/penumbra", bed.folder);
    snprintf(url, sizeof url, "%s/p.db", folder);
    struct pen_status st;
    umask(0);
    struct pen_store *store = pen_store_open(url, true, &st);
    bool more;
    store_must(store != NULL, &st, "open");
    store_must(pen_store_purge(store, &more, &st), &st, "purge"); /* makes the reserve */
    static const char *const names[] = {"", "-wal", "-shm", "-reserve"};
    struct stat info;
    for (int i = 0; i < 4; i++) {
        char path[300];
        snprintf(path, sizeof path, "%s%s", url, names[i]);
        ck_assert_msg(stat(path, &info) == 0, "%s is missing", path);
        ck_assert_msg((info.st_mode & 0777) == 0600, "%s is %o", path, info.st_mode & 0777);
    }
    ck_assert_int_eq(stat(folder, &info), 0);
    ck_assert_int_eq(info.st_mode & 0777, 0700);
    pen_store_close(store);
    pen_store_close(bed.store);
    remove_bed();
}
END_TEST

START_TEST(test_sqlite_file__other_files_are_refused_and_left)
{
    store_bed_open(&bed);
    pen_store_close(bed.store);
    write_file(bed.url, "a diary\n", 8);
    refuse("not a Penumbra store");
    static unsigned char foreign[4096] = "SQLite format 3";
    foreign[16] = 16; /* page size 4096 */
    foreign[71] = 7;  /* application id */
    write_file(bed.url, foreign, sizeof foreign);
    refuse("not a Penumbra store");
    write_file(bed.url, "", 0);
    refuse("not a Penumbra store");
    remove_bed();
}
END_TEST

START_TEST(test_sqlite_file__another_schema_is_refused_with_both_versions_and_left)
{
    char hint[64];
    closed_bed();
    const int own = store_number(bed.url, "PRAGMA user_version");
    for (int other = own - 1; other <= own + 1; other += 2) {
        snprintf(hint, sizeof hint, "PRAGMA user_version = %d", other);
        store_run_sql(&bed, hint, NULL, 0);
        snprintf(hint, sizeof hint, "of version %d; this build reads version %d", other, own);
        refuse(hint);
    }
    remove_bed();
}
END_TEST

START_TEST(test_sqlite_file__damage_is_found_and_left)
{
    closed_bed();
    size_t bytes;
    unsigned char *data = read_file(bed.url, &bytes);
    ck_assert_uint_gt(bytes, 8 * 8192);
    memset(data + 5 * 8192, 0x5a, 8192);
    write_file(bed.url, data, bytes);
    refuse("damaged");
    write_file(bed.url, data, bytes / 2);
    refuse("damaged");
    memset(data, 0, 4096);
    write_file(bed.url, data, bytes);
    refuse("is damaged");
    free(data);
    remove_bed();
}
END_TEST

START_TEST(test_sqlite_file__folder_that_cannot_be_made_is_an_error)
{
    store_bed_open(&bed);
    char url[128];
    snprintf(url, sizeof url, "%s/sub/p.db", bed.url);
    struct pen_status st;
    ck_assert_ptr_null(pen_store_open(url, true, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    store_bed_close(&bed);
}
END_TEST

static int64_t file_bytes(const char *suffix)
{
    char path[160];
    struct stat info;
    snprintf(path, sizeof path, "%s%s", bed.url, suffix);
    return stat(path, &info) == 0 ? (int64_t)info.st_size : 0;
}

static atomic_bool readers_stop;

static bool read_slowly(void *user, const struct pen_batch_stats *batch)
{
    (void)user;
    (void)batch;
    usleep(4000);
    return false;
}

static void *read_on(void *job)
{
    struct pen_status st;
    struct pen_store *store = store_bed_handle(&bed);
    while (!atomic_load(&readers_stop))
        store_must(pen_store_stats(store, job, read_slowly, NULL, &st), &st, "read");
    pen_store_close(store);
    return NULL;
}

/* There is always a reader, so the log begins anew only if somebody waits for readers. */
START_TEST(test_sqlite_file__log_stays_bounded_with_readers_all_the_time)
{
    enum { READERS = 4, SUBMITS = 3000 };
    pthread_t reader[READERS];
    struct store_job first, in;
    struct pen_status st;
    int64_t largest = 0, now_ms = 1;
    bool more;
    faults_install(); /* its syncs are quick */
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &now_ms);
    store_job_init(&first, 0, 1, 1);
    store_job_submit(bed.store, &first);
    store_work_off(bed.store, "w");
    for (int i = 0; i < READERS; i++)
        ck_assert_int_eq(pthread_create(&reader[i], NULL, read_on, first.id), 0);
    for (int i = 1; i <= SUBMITS; i++) {
        store_job_init(&in, i, 1, 1);
        store_job_submit(bed.store, &in);
        if (i % 100 == 0)
            store_must(pen_store_purge(bed.store, &more, &st), &st, "purge");
        if (file_bytes("-wal") > largest)
            largest = file_bytes("-wal");
    }
    atomic_store(&readers_stop, true);
    for (int i = 0; i < READERS; i++)
        pthread_join(reader[i], NULL);
    printf("the log grew to %lld bytes\n", (long long)largest);
    ck_assert_int_gt(largest, 4 << 20); /* else the test would show nothing */
    ck_assert_int_lt(largest, 80 << 20);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_sqlite_file__space_of_deleted_jobs_is_given_back)
{
    store_bed_open(&bed);
    struct pen_status st;
    struct store_job in;
    static char document[1 << 20];
    unsigned seed = 1;
    for (size_t i = 0; i < sizeof document; i++)
        document[i] = (char)((seed = seed * 1103515245 + 12345) >> 16);
    for (int n = 0; n < 8; n++) {
        store_job_init(&in, n, 1, 1);
        in.job.scene = document;
        in.job.scene_bytes = sizeof document - (size_t)n;
        store_job_submit(bed.store, &in);
    }
    for (int n = 0; n < 8; n++) {
        store_job_init(&in, n, 1, 1);
        store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
        store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    }
    store_purge_slices(bed.store);
    ck_assert_msg(file_bytes("") < 1 << 20, "the store still has %lld bytes",
                  (long long)file_bytes(""));
    store_bed_close(&bed);
}
END_TEST

/* One worker process: claims and commits until nothing is left; exits with the number of batches
 * it got, or 255. */
static void work_and_exit(int number)
{
    char name[16];
    snprintf(name, sizeof name, "w%d", number);
    struct pen_status st;
    struct pen_store *store = pen_store_open(bed.url, false, &st);
    int done = 0;
    int64_t serial = 0;
    for (bool found = store != NULL; found;) {
        struct pen_claim claim;
        if (!pen_store_claim(store, name, 60000, ++serial, &claim, &found, &st) ||
            (found && store_commit(store, &claim) != PEN_OK))
            _exit(255);
        done += found;
    }
    pen_store_close(store);
    _exit(store ? done : 255);
}

START_TEST(test_sqlite_file__processes_share_the_work_without_doing_any_twice)
{
    enum { WORKERS = 6, JOBS = 30, BATCHES = 8 };
    store_bed_open(&bed);
    for (int n = 0; n < JOBS; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, BATCHES);
        store_job_submit(bed.store, &in);
    }
    pen_store_close(bed.store);
    pid_t pid[WORKERS];
    for (int i = 0; i < WORKERS; i++) {
        pid[i] = fork();
        ck_assert_int_ge(pid[i], 0);
        if (pid[i] == 0)
            work_and_exit(i);
    }
    int total = 0;
    for (int i = 0; i < WORKERS; i++) {
        int status;
        ck_assert_int_eq(waitpid(pid[i], &status, 0), pid[i]);
        ck_assert(WIFEXITED(status));
        ck_assert_int_ne(WEXITSTATUS(status), 255);
        total += WEXITSTATUS(status);
    }
    bed.store = store_bed_handle(&bed);
    /* A worker that finds no open batch may leave before an assemble batch is added. */
    total += store_work_off(bed.store, "last");
    ck_assert_int_eq(total, JOBS * (BATCHES + 1));
    for (int n = 0; n < JOBS; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 1);
        ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
    }
    store_bed_close(&bed);
}
END_TEST

static void *open_and_submit(void *arg)
{
    struct store_job in;
    struct pen_store *store = store_bed_handle(&bed);
    store_job_init(&in, (int)(intptr_t)arg, 1, 1);
    store_job_submit(store, &in);
    pen_store_close(store);
    return NULL;
}

START_TEST(test_sqlite_file__many_may_open_a_new_store_at_once)
{
    enum { THREADS = 8 };
    for (int try = 0; try < 5; try++) {
        store_bed_make(&bed);
        pthread_t thread[THREADS];
        for (int i = 0; i < THREADS; i++)
            ck_assert_int_eq(pthread_create(&thread[i], NULL, open_and_submit, (void *)(intptr_t)i),
                             0);
        for (int i = 0; i < THREADS; i++)
            pthread_join(thread[i], NULL);
        bed.store = store_bed_handle(&bed);
        ck_assert_int_eq(store_work_off(bed.store, "w"), THREADS);
        store_bed_close(&bed);
    }
}
END_TEST

/* Another program keeps the database locked for writing. */
START_TEST(test_sqlite_file__a_locked_store_is_read_and_a_write_gives_up_after_ten_seconds)
{
    struct pen_status st;
    struct store_job in;
    sqlite3 *other;
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 1);
    store_job_submit(bed.store, &in);
    ck_assert_int_eq(sqlite3_open_v2(bed.url, &other, SQLITE_OPEN_READWRITE, NULL), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(other, "BEGIN IMMEDIATE", NULL, NULL, NULL), SQLITE_OK);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_QUEUED);
    const int64_t begun_ns = pen_clock_ns();
    ck_assert(!pen_store_cancel(bed.store, in.id, NULL, &st));
    const double s = (double)(pen_clock_ns() - begun_ns) / 1e9;
    ck_assert_msg(s > 9 && s < 60, "it took %.1f s", s);
    ck_assert_int_eq(st.code, PEN_UNAVAILABLE);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_RETRY);
    ck_assert(!pen_store_is_broken(bed.store, NULL));
    ck_assert_int_eq(sqlite3_exec(other, "ROLLBACK", NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(other);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store file",
          test_sqlite_file__a_locked_store_is_read_and_a_write_gives_up_after_ten_seconds,
          test_sqlite_file__what_was_stored_is_there_after_reopening,
          test_sqlite_file__folders_are_made_and_all_is_private,
          test_sqlite_file__other_files_are_refused_and_left,
          test_sqlite_file__another_schema_is_refused_with_both_versions_and_left,
          test_sqlite_file__damage_is_found_and_left,
          test_sqlite_file__folder_that_cannot_be_made_is_an_error,
          test_sqlite_file__log_stays_bounded_with_readers_all_the_time,
          test_sqlite_file__space_of_deleted_jobs_is_given_back,
          test_sqlite_file__processes_share_the_work_without_doing_any_twice,
          test_sqlite_file__many_may_open_a_new_store_at_once)
