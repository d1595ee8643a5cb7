/* SPDX-License-Identifier: MIT */
/* Backups. A copy is whole although other processes write meanwhile. It is checked, gets its name
 * last, and replaces a file only if asked to. */
#include <dirent.h>
#include <errno.h>
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

#include "base/log.h"
#include "support/faults.h"
#include "support/store.h"
#include "support/store_rows.h"
#include "support/suite.h"

static struct store_bed bed;
static char file[128];

static void open_bed(void)
{
    store_bed_open(&bed);
    snprintf(file, sizeof file, "%s/backup.db", bed.folder);
}

static void submit(int n)
{
    struct store_job in;
    store_job_init(&in, n, 1, 3);
    store_job_submit(bed.store, &in);
}

static struct pen_backup must_back_up(bool replace)
{
    struct pen_backup backup = {0};
    struct pen_status st;
    store_must(pen_store_backup(bed.url, file, replace, &backup, &st), &st, "backup");
    return backup;
}

static void refuse(enum pen_code code, const char *hint)
{
    struct pen_backup backup = {0};
    struct pen_status st = {0};
    ck_assert(!pen_store_backup(bed.url, file, false, &backup, &st));
    ck_assert_msg(st.code == code, "%s: %s", pen_code_name(st.code), st.msg);
    ck_assert_msg(strstr(st.msg, hint) != NULL, "\"%s\" lacks \"%s\"", st.msg, hint);
}

/* The folder holds no unfinished copy. */
static void expect_no_parts(void)
{
    DIR *dir = opendir(bed.folder);
    ck_assert_ptr_nonnull(dir);
    for (struct dirent *entry; (entry = readdir(dir)) != NULL;)
        ck_assert_msg(!strstr(entry->d_name, ".part-"), "%s is left over", entry->d_name);
    closedir(dir);
}

static int jobs_in(struct pen_store *store)
{
    struct pen_status st;
    struct pen_job_filter filter = {.state = -1, .limit = 10000};
    struct pen_job_record *jobs;
    int count = 0;
    store_must(pen_store_jobs(store, &filter, &jobs, &count, &st), &st, "list");
    pen_job_records_free(jobs, count);
    return count;
}

START_TEST(test_sqlite_backup__is_a_store_of_one_file)
{
    struct stat info;
    char log[140];
    open_bed();
    for (int n = 0; n < 5; n++)
        submit(n);
    store_claim(bed.store, "w");
    struct pen_backup backup = must_back_up(false);
    ck_assert_int_eq(backup.jobs, 5);
    ck_assert_int_eq(stat(file, &info), 0);
    ck_assert_int_eq(info.st_size, backup.bytes);
    ck_assert_int_eq(info.st_mode & 0777, 0600);
    snprintf(log, sizeof log, "%s-wal", file);
    ck_assert_msg(access(log, F_OK) != 0, "%s", log);
    expect_no_parts();
    struct pen_status st;
    ck_assert_int_eq(store_contradictions(file), 0);
    struct pen_store *copy = pen_store_open(file, false, &st);
    store_must(copy != NULL, &st, "open the copy");
    ck_assert_int_eq(jobs_in(copy), 5);
    const struct pen_worker_death death = {.worker = "w", .end = PEN_WORKER_LEFT};
    int opened;
    store_must(pen_store_worker_ended(copy, &death, &opened, &st), &st, "ended");
    ck_assert_int_eq(opened, 1);
    ck_assert_int_eq(store_work_off(copy, "x"), 5 * 4);
    pen_store_close(copy);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_sqlite_backup__replaces_only_what_it_may)
{
    struct stat before, after;
    char name[128];
    open_bed();
    submit(1);
    must_back_up(false);
    ck_assert_int_eq(stat(file, &before), 0);
    refuse(PEN_CONFLICT, "is there already");
    submit(2);
    ck_assert_int_eq(stat(file, &after), 0);
    ck_assert_uint_eq(after.st_ino, before.st_ino);
    ck_assert_int_eq(must_back_up(true).jobs, 2);
    memcpy(name, file, sizeof name);
    memcpy(file, bed.url, sizeof bed.url);
    refuse(PEN_USAGE, "is the store itself");
    snprintf(file, sizeof file, "%s-wal", bed.url);
    refuse(PEN_USAGE, "is the store itself");
    memcpy(file, bed.folder, sizeof bed.folder);
    refuse(PEN_USAGE, "is a folder");
    snprintf(file, sizeof file, "%s/no/such/folder", bed.folder);
    refuse(PEN_IO, "No such file");
    expect_no_parts();
    store_bed_close(&bed);
}
END_TEST

static atomic_bool stop;
static atomic_int acknowledged;

static void *write_on(void *arg)
{
    struct pen_store *store = store_bed_handle(&bed);
    (void)arg;
    for (int n = 1000; !atomic_load(&stop); n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 3);
        store_job_submit(store, &in);
        atomic_fetch_add(&acknowledged, 1);
        struct pen_claim claim = store_claim(store, "w");
        ck_assert_int_eq(store_commit(store, &claim), PEN_OK);
    }
    pen_store_close(store);
    return NULL;
}

START_TEST(test_sqlite_backup__under_load_has_what_was_acknowledged_before)
{
    enum { BACKUPS = 8 };
    pthread_t writer;
    open_bed();
    ck_assert_int_eq(pthread_create(&writer, NULL, write_on, NULL), 0);
    for (int i = 0; i < 60000 && atomic_load(&acknowledged) == 0; i++)
        usleep(1000);
    int last = 0;
    for (int i = 0; i < BACKUPS; i++) {
        struct pen_status st;
        usleep(100000);
        int before = atomic_load(&acknowledged);
        struct pen_backup backup = must_back_up(true);
        ck_assert_int_ge(backup.jobs, before);
        ck_assert_int_ge(before, last);
        last = before;
        ck_assert_int_eq(store_contradictions(file), 0);
        struct pen_store *copy = pen_store_open(file, false, &st);
        store_must(copy != NULL, &st, "open the copy");
        ck_assert_int_eq(jobs_in(copy), backup.jobs);
        pen_store_close(copy);
    }
    ck_assert_int_gt(last, 0);
    atomic_store(&stop, true);
    pthread_join(writer, NULL);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_sqlite_backup__of_nothing_or_of_a_damaged_store_is_refused)
{
    open_bed();
    for (int n = 0; n < 20; n++)
        submit(n);
    pen_store_close(bed.store);
    FILE *store = fopen(bed.url, "r+b");
    ck_assert_ptr_nonnull(store);
    fseek(store, 5 * 8192, SEEK_SET);
    for (int i = 0; i < 8192; i++)
        fputc(0x5a, store);
    fclose(store);
    refuse(PEN_STORAGE, "damaged");
    ck_assert_int_ne(access(file, F_OK), 0);
    unlink(bed.url);
    refuse(PEN_NOT_FOUND, "there is no store");
    ck_assert_int_ne(access(bed.url, F_OK), 0); /* the call has made no store */
    expect_no_parts();
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", bed.folder);
    ck_assert_int_eq(system(command), 0);
}
END_TEST

/* The disk fails while the copy is written, at every write in turn. */
START_TEST(test_sqlite_backup__that_cannot_be_written_leaves_nothing)
{
    static const int errors[] = {ENOSPC, EIO};
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install();
    open_bed();
    for (int n = 0; n < 5; n++)
        submit(n);
    for (int i = 0; i < 2; i++) {
        for (long n = 1;; n++) {
            struct pen_backup backup = {0};
            struct pen_status st = {0};
            struct fault_plan plan = {
                .calls = FAULT_WRITE, .mode = FAULT_FROM, .n = n, .error = errors[i]};
            faults_arm(&plan);
            bool ok = pen_store_backup(bed.url, file, true, &backup, &st);
            if (faults_disarm() == 0) {
                store_must(ok, &st, "backup");
                ck_assert_int_gt(n, 5);
                break;
            }
            ck_assert(!ok);
            ck_assert_msg(st.code == (errors[i] == ENOSPC ? PEN_STORAGE_FULL : PEN_IO),
                          "%ld: %s: %s", n, pen_code_name(st.code), st.msg);
            ck_assert_msg(strstr(st.msg, file) != NULL, "%s", st.msg);
            ck_assert_int_eq(access(file, F_OK), i == 0 ? -1 : 0); /* as before */
            expect_no_parts();
        }
    }
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_sqlite_backup__that_is_stopped_leaves_nothing)
{
    atomic_bool now = true;
    struct pen_backup backup = {.stop = &now};
    struct pen_status st = {0};
    open_bed();
    submit(1);
    ck_assert(!pen_store_backup(bed.url, file, false, &backup, &st));
    ck_assert_msg(st.code == PEN_TIMEOUT && strstr(st.msg, "stopped"), "%s", st.msg);
    ck_assert_int_ne(access(file, F_OK), 0);
    expect_no_parts();
    atomic_store(&now, false);
    store_must(pen_store_backup(bed.url, file, false, &backup, &st), &st, "backup");
    store_bed_close(&bed);
}
END_TEST

static int make_part(void)
{
    char path[160];
    snprintf(path, sizeof path, "%s.part-new", file);
    const int fd = open(path, O_RDWR | O_CREAT, 0600);
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(write(fd, "pages", 5), 5);
    return fd;
}

/* What a killed process has left is written over; what a living one writes is not touched. */
START_TEST(test_sqlite_backup__takes_over_what_a_killed_one_left)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_len = 1};
    open_bed();
    submit(1);
    close(make_part());
    must_back_up(false);
    expect_no_parts();
    unlink(file);
    int fd = make_part();
    ck_assert_int_eq(fcntl(fd, F_OFD_SETLK, &lock), 0);
    refuse(PEN_CONFLICT, "another backup");
    pen_store_backup_remove_left(file);
    char text[5];
    ck_assert_int_eq(pread(fd, text, sizeof text, 0), 5);
    ck_assert_mem_eq(text, "pages", 5);
    close(fd);
    pen_store_backup_remove_left(file);
    expect_no_parts();
    store_bed_close(&bed);
}
END_TEST

static int64_t file_time_ns(const char *path)
{
    struct stat info;
    ck_assert_int_eq(stat(path, &info), 0);
    return (int64_t)info.st_mtim.tv_sec * 1000000000 + info.st_mtim.tv_nsec;
}

/* The store's files are left as they are: a log that a killed daemon left is not copied. */
START_TEST(test_sqlite_backup__only_reads_the_store)
{
    char log[140];
    open_bed();
    submit(1);
    snprintf(log, sizeof log, "%s-wal", bed.url);
    pen_store_close(bed.store);
    const pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0) {
        store_bed_open(&bed);
        submit(2);
        _exit(0);
    }
    ck_assert_int_eq(waitpid(child, NULL, 0), child);
    const int64_t before = file_time_ns(bed.url), log_before = file_time_ns(log);
    ck_assert_int_eq(must_back_up(false).jobs, 2);
    ck_assert_int_eq(file_time_ns(bed.url), before);
    ck_assert_int_eq(file_time_ns(log), log_before);
    ck_assert_int_eq(chmod(bed.url, 0400), 0);
    ck_assert_int_eq(must_back_up(true).jobs, 2);
    ck_assert_int_eq(chmod(bed.url, 0600), 0);
    bed.store = store_bed_handle(&bed);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("backup", test_sqlite_backup__that_is_stopped_leaves_nothing,
          test_sqlite_backup__takes_over_what_a_killed_one_left,
          test_sqlite_backup__only_reads_the_store, test_sqlite_backup__is_a_store_of_one_file,
          test_sqlite_backup__replaces_only_what_it_may,
          test_sqlite_backup__under_load_has_what_was_acknowledged_before,
          test_sqlite_backup__of_nothing_or_of_a_damaged_store_is_refused,
          test_sqlite_backup__that_cannot_be_written_leaves_nothing)
