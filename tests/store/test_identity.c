/* SPDX-License-Identifier: MIT */
/* A store is never replaced by an empty one, or by another one, unnoticed: files that are moved
 * away, removed, put beside the wrong store, locked or truncated. */
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

static const char *beside(const char *end)
{
    static char path[4][160];
    static int next;
    char *to = path[next++ % 4];
    snprintf(to, sizeof path[0], "%s%s", bed.url, end);
    return to;
}

static bool is_there(const char *end)
{
    return access(beside(end), F_OK) == 0;
}

static void remove_bed(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", bed.folder);
    ck_assert_int_eq(system(command), 0);
}

/* Opening must fail with this code and a message that contains `hint`. */
static void refuse(const char *url, enum pen_code code, const char *hint)
{
    struct pen_status st = {0};
    struct pen_store *store = pen_store_open(url, &st);
    ck_assert_msg(!store, "%s was opened (%s)", url, hint);
    ck_assert_msg(st.code == code, "%s: %s", pen_code_name(st.code), st.msg);
    ck_assert_msg(strstr(st.msg, hint) != NULL, "\"%s\" lacks \"%s\"", st.msg, hint);
}

/* The URL that names the bed's store by its identity; the store stays open. */
static const char *known_url(void)
{
    static char url[160];
    snprintf(url, sizeof url, "store:%s:%s", pen_store_identity(bed.store), bed.url);
    return url;
}

static void submit(struct pen_store *store, int n)
{
    struct store_job in;
    store_job_init(&in, n, 1, 1);
    store_job_submit(store, &in);
}

/* Leaves the files of a process that was killed: its jobs are in the log only. */
static void make_killed_store(void)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_make(&bed);
    pid_t pid = fork();
    if (pid == 0) {
        bed.store = store_bed_handle(&bed);
        for (int n = 0; n < 3; n++)
            submit(bed.store, n);
        _exit(0);
    }
    int status;
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
}

static int64_t count_jobs(struct pen_store *store)
{
    struct pen_counts counts;
    struct pen_status st;
    int64_t sum = 0;
    store_must(pen_store_counts(store, &counts, &st), &st, "counts");
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++)
        sum += counts.jobs[i];
    return sum;
}

START_TEST(test_identity__is_made_once_and_a_backup_has_another)
{
    char identity[PEN_STORE_IDENTITY_BYTES];
    struct pen_backup backup = {0};
    struct pen_status st;
    store_bed_open(&bed);
    snprintf(identity, sizeof identity, "%s", pen_store_identity(bed.store));
    ck_assert_uint_eq(strspn(identity, "0123456789abcdef"), 32);
    struct pen_store *other = pen_store_open(known_url(), &st);
    store_must(other != NULL, &st, "open");
    ck_assert_str_eq(pen_store_identity(other), identity);
    pen_store_close(other);
    store_must(pen_store_backup(bed.url, beside(".backup"), false, &backup, &st), &st, "backup");
    other = pen_store_open(beside(".backup"), &st);
    store_must(other != NULL, &st, "open");
    ck_assert_str_ne(pen_store_identity(other), identity);
    pen_store_close(other);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__a_store_that_is_gone_is_not_made_anew)
{
    static const char *const ends[] = {"-wake", "-wal"};
    store_bed_open(&bed);
    const char *url = known_url();
    pen_store_close(bed.store);
    ck_assert_int_eq(rename(bed.url, beside(".away")), 0);
    refuse(url, PEN_STORAGE, "is gone, and no new one is made");
    ck_assert(!is_there(""));
    refuse(bed.url, PEN_STORAGE, "is missing, but its file ending in -wake is there");
    ck_assert(!is_there(""));
    for (int i = 0; i < 2; i++)
        unlink(beside(ends[i]));
    refuse(url, PEN_STORAGE, "is gone");
    ck_assert(!is_there("") && !is_there("-wake"));
    bed.store = store_bed_handle(&bed); /* to begin anew, its files were removed */
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__a_log_without_its_store_keeps_a_new_one_from_being_made)
{
    make_killed_store();
    ck_assert_int_eq(rename(bed.url, beside(".away")), 0);
    unlink(beside("-wake"));
    refuse(bed.url, PEN_STORAGE, "its file ending in -wal is there");
    ck_assert_int_eq(rename(beside(".away"), bed.url), 0);
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__another_store_is_refused)
{
    struct pen_status st;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    const char *url = known_url();
    pen_store_close(bed.store);
    struct pen_store *other = pen_store_open(beside(".other"), &st);
    store_must(other && pen_store_settle(other, &st), &st, "settle");
    pen_store_close(other);
    ck_assert_int_eq(rename(beside(".other"), bed.url), 0);
    refuse(url, PEN_STORAGE, "another store was put in the place of");
    bed.store = store_bed_handle(&bed);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__a_missing_log_is_noticed)
{
    make_killed_store();
    ck_assert_int_eq(rename(beside("-wal"), beside(".wal")), 0);
    unlink(beside("-shm"));
    struct pen_status st;
    struct pen_backup backup = {0};
    refuse(bed.url, PEN_STORAGE, "-wal, the log of the store's last changes, is missing");
    ck_assert(!is_there("-wal"));
    ck_assert(!pen_store_backup(bed.url, beside(".backup"), false, &backup, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_int_eq(rename(beside(".wal"), beside("-wal")), 0);
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__an_empty_log_is_the_operators_consent)
{
    make_killed_store();
    unlink(beside("-wal"));
    unlink(beside("-shm"));
    refuse(bed.url, PEN_STORAGE, "make an empty file of that name");
    close(open(beside("-wal"), O_WRONLY | O_CREAT, 0600));
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__a_settled_store_needs_no_other_file)
{
    struct pen_status st;
    store_bed_open(&bed);
    submit(bed.store, 1);
    store_must(pen_store_settle(bed.store, &st), &st, "settle");
    pen_store_close(bed.store);
    ck_assert_int_eq(rename(bed.url, beside(".moved")), 0);
    struct pen_store *moved = pen_store_open(beside(".moved"), &st);
    store_must(moved != NULL, &st, "open");
    ck_assert_int_eq(count_jobs(moved), 1);
    pen_store_close(moved);
    remove_bed();
}
END_TEST

/* Settles and closes the bed's store, writes through `other` and closes that: the store must still
 * say that it needs its log, which is left as ".wal". */
static void expect_unsettled(struct pen_store *other)
{
    struct pen_status st;
    store_must(pen_store_settle(bed.store, &st), &st, "settle");
    pen_store_close(bed.store);
    submit(other, 1);
    pen_store_close(other);
    ck_assert_int_eq(rename(beside("-wal"), beside(".wal")), 0);
    refuse(bed.url, PEN_STORAGE, "-wal, the log of the store's last changes, is missing");
}

START_TEST(test_identity__a_store_that_others_use_is_not_settled)
{
    struct pen_status st;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    struct pen_store *other = store_bed_handle(&bed);
    expect_unsettled(other);
    ck_assert_int_eq(rename(beside(".wal"), beside("-wal")), 0);
    bed.store = store_bed_handle(&bed); /* the last one now, which may settle it */
    store_must(pen_store_settle(bed.store, &st), &st, "settle");
    pen_store_close(bed.store);
    unlink(beside("-wal"));
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 1);
    store_bed_close(&bed);
}
END_TEST

/* A process that may make no store makes no folder either. */
START_TEST(test_identity__nothing_is_made_where_the_store_is_gone)
{
    char url[200];
    store_bed_open(&bed);
    snprintf(url, sizeof url, "store:%s:%s/penumbra.db", pen_store_identity(bed.store),
             beside("-folder"));
    refuse(url, PEN_STORAGE, "is gone, and no new one is made");
    snprintf(url, sizeof url, "store::%s/penumbra.db", beside("-folder"));
    refuse(url, PEN_NOT_FOUND, "there is no store");
    ck_assert(!is_there("-folder"));
    store_bed_close(&bed);
}
END_TEST

/* Opens the store by another URL, and checks that it is the bed's. */
static void open_again(const char *url)
{
    struct pen_status st;
    struct pen_store *other = pen_store_open(url, &st);
    store_must(other != NULL, &st, "open");
    ck_assert_str_eq(pen_store_identity(other), pen_store_identity(bed.store));
    ck_assert_str_eq(pen_store_path(other), bed.url);
    pen_store_close(other);
}

START_TEST(test_identity__a_link_leads_to_the_store_with_its_files)
{
    char url[200];
    struct pen_backup backup = {0};
    struct pen_status st;
    store_bed_open(&bed);
    snprintf(url, sizeof url, "store::%s", bed.url);
    open_again(url);
    ck_assert_int_eq(symlink("penumbra.db", beside(".link")), 0);
    ck_assert_int_eq(symlink(".", beside(".folder")), 0);
    open_again(beside(".link"));
    snprintf(url, sizeof url, "%s/penumbra.db.link", beside(".folder"));
    open_again(url);
    ck_assert(!is_there(".link-wake") && !is_there(".link-wal"));
    snprintf(url, sizeof url, "%s/penumbra.db-new", beside(".folder"));
    ck_assert(!pen_store_backup(beside(".link"), url, true, &backup, &st));
    ck_assert_msg(st.code == PEN_USAGE, "%s", st.msg);
    store_must(pen_store_backup(beside(".link"), beside(".backup"), false, &backup, &st), &st,
               "backup");
    store_bed_close(&bed);
}
END_TEST

/* Supervises the store in a process of its own, until this byte is read. */
static pid_t start_supervisor(int until)
{
    int up[2];
    char byte = 0;
    ck_assert_int_eq(pipe(up), 0);
    const pid_t pid = fork();
    if (pid == 0) {
        struct pen_status st;
        struct pen_store *store = store_bed_handle(&bed);
        store_must(pen_store_supervise(store, &st), &st, "supervise");
        if (write(up[1], &byte, 1) != 1 || read(until, &byte, 1) != 1)
            _exit(1);
        pen_store_close(store);
        _exit(0);
    }
    ck_assert_int_eq(read(up[0], &byte, 1), 1);
    close(up[0]);
    close(up[1]);
    return pid;
}

/* Whether this process could supervise the store now. */
static bool may_supervise(void)
{
    struct pen_status st;
    struct pen_store *store = store_bed_handle(&bed);
    const bool may = pen_store_supervise(store, &st);
    ck_assert_msg(may || st.code == PEN_CONFLICT, "%s", st.msg);
    pen_store_close(store);
    return may;
}

START_TEST(test_identity__a_supervisor_is_found_without_the_files_beside_the_store)
{
    int until[2], status;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_make(&bed);
    ck_assert(may_supervise() && pipe(until) == 0);
    const pid_t pid = start_supervisor(until[0]);
    ck_assert(!may_supervise());
    unlink(beside("-wake"));
    ck_assert(!may_supervise());
    ck_assert_int_eq(write(until[1], "", 1), 1);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    ck_assert_int_eq(status, 0);
    ck_assert(may_supervise());
    close(until[0]);
    close(until[1]);
    remove_bed();
}
END_TEST

/* Its lock in the old file does not tell who uses the new one. */
START_TEST(test_identity__a_store_whose_wake_file_was_replaced_is_not_settled)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    unlink(beside("-wake"));
    struct pen_store *other = store_bed_handle(&bed);
    expect_unsettled(other);
    remove_bed();
}
END_TEST

/* SQLite would take the log for this store's own. */
START_TEST(test_identity__the_log_of_another_store_is_not_applied)
{
    struct pen_status st;
    make_killed_store();
    struct pen_store *other = pen_store_open(beside(".other"), &st);
    store_must(other && pen_store_settle(other, &st), &st, "settle");
    pen_store_close(other);
    ck_assert_int_eq(rename(bed.url, beside(".away")), 0);
    ck_assert_int_eq(rename(beside(".other"), bed.url), 0);
    refuse(bed.url, PEN_STORAGE, "-wal seems to be the log of another store than");
    ck_assert_int_eq(rename(beside(".away"), bed.url), 0);
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 3);
    store_bed_close(&bed);
}
END_TEST

/* Submits until the call fails with this message or succeeds. A store tries to recover again within
 * a minute, however long its last try took. */
static void expect_submit(int n, const char *hint)
{
    enum { STEP_US = 50000, STEPS = 90 * 1000000 / STEP_US };
    struct pen_status st = {0};
    bool as_expected = false;
    for (int i = 0; i < STEPS && !as_expected; i++) {
        struct store_job in;
        struct pen_buf answer = {0};
        enum pen_submit_result result;
        store_job_init(&in, n, 1, 1);
        bool ok = pen_store_submit(bed.store, &in.job, &result, &answer, &st);
        pen_buf_release(&answer);
        as_expected = hint ? !ok && strstr(st.msg, hint) : ok;
        ck_assert(!hint || !ok);
        if (!as_expected)
            usleep(STEP_US);
    }
    ck_assert_msg(as_expected, "%s", st.msg);
}

START_TEST(test_identity__a_log_that_is_removed_in_use_takes_no_jobs)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    submit(bed.store, 1);
    ck_assert_int_eq(rename(beside("-wal"), beside(".wal")), 0);
    expect_submit(2, "-wal was moved or removed while it was in use");
    refuse(known_url(), PEN_STORAGE, "is missing");
    ck_assert_int_eq(rename(beside(".wal"), beside("-wal")), 0);
    expect_submit(2, NULL);
    ck_assert_int_eq(count_jobs(bed.store), 2);
    store_bed_close(&bed);
}
END_TEST

/* What it had is copied into the store, so that nothing is lost with its last descriptor. */
START_TEST(test_identity__what_a_removed_log_had_is_saved)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    submit(bed.store, 1);
    unlink(beside("-wal"));
    expect_submit(2, "-wal was moved or removed while it was in use");
    pen_store_close(bed.store);
    close(open(beside("-wal"), O_WRONLY | O_CREAT, 0600));
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 1);
    store_bed_close(&bed);
}
END_TEST

static const char lost_shm[] = "-shm was moved or removed while it was in use";

/* A process that makes another -shm file would write over the others' part of the log. */
START_TEST(test_identity__a_removed_shm_file_takes_no_jobs_and_no_further_process)
{
    struct pen_backup backup = {0};
    struct pen_status st;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    submit(bed.store, 1);
    ck_assert_int_eq(rename(beside("-shm"), beside(".shm")), 0);
    refuse(bed.url, PEN_STORAGE, lost_shm);
    ck_assert(!pen_store_backup(bed.url, beside(".backup"), false, &backup, &st));
    ck_assert_msg(strstr(st.msg, lost_shm), "%s", st.msg);
    ck_assert(!is_there("-shm") && !is_there(".backup"));
    expect_submit(2, lost_shm);
    close(open(beside("-shm"), O_WRONLY | O_CREAT, 0600)); /* another one is no better */
    refuse(bed.url, PEN_STORAGE, lost_shm);
    expect_submit(2, lost_shm);
    ck_assert_int_eq(rename(beside(".shm"), beside("-shm")), 0);
    expect_submit(2, NULL);
    pen_store_close(store_bed_handle(&bed));
    ck_assert_int_eq(count_jobs(bed.store), 2);
    store_bed_close(&bed);
}
END_TEST

/* When all have closed the store, the next one makes the file anew from the log. */
START_TEST(test_identity__a_removed_shm_file_is_made_anew_when_nobody_uses_the_store)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    submit(bed.store, 1);
    unlink(beside("-shm"));
    expect_submit(2, lost_shm);
    pen_store_close(bed.store);
    bed.store = store_bed_handle(&bed);
    expect_submit(2, NULL);
    ck_assert_int_eq(count_jobs(bed.store), 2);
    store_bed_close(&bed);
}
END_TEST

/* A process that is ending keeps its handle a moment longer than it is seen to run. */
START_TEST(test_identity__a_handle_that_is_about_to_go_is_waited_for)
{
    int ready[2];
    char byte = 0;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    submit(bed.store, 1);
    pen_store_close(bed.store);
    ck_assert_int_eq(pipe(ready), 0);
    const pid_t child = fork();
    if (child == 0) {
        const struct timespec pause = {.tv_nsec = 400000000};
        struct pen_status st;
        const bool opened = pen_store_open(bed.url, &st) != NULL;
        const bool told = write(ready[1], &byte, 1) == 1;
        nanosleep(&pause, NULL);
        _exit(opened && told ? 0 : 1);
    }
    close(ready[1]);
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    unlink(beside("-shm"));
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(count_jobs(bed.store), 1);
    int status;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_int_eq(status, 0);
    close(ready[0]);
    store_bed_close(&bed);
}
END_TEST

/* Whoever waits for a lock file that is removed meanwhile must not go on beside the one who has the
 * lock on the next one. */
START_TEST(test_identity__a_lock_file_without_a_name_keeps_nobody_out)
{
    int opened[2];
    char byte = 0;
    store_bed_open(&bed);
    pen_store_close(bed.store);
    const int first = open(beside("-wake"), O_RDWR | O_CREAT, 0600);
    ck_assert(first >= 0 && flock(first, LOCK_EX) == 0 && pipe(opened) == 0);
    const pid_t child = fork();
    if (child == 0) {
        struct pen_status st;
        close(first);
        _exit(pen_store_open(bed.url, &st) && write(opened[1], &byte, 1) == 1 ? 0 : 1);
    }
    close(opened[1]);
    struct pollfd told = {.fd = opened[0], .events = POLLIN};
    ck_assert_int_eq(poll(&told, 1, 300), 0);
    ck_assert_int_eq(unlink(beside("-wake")), 0);
    const int second = open(beside("-wake"), O_RDWR | O_CREAT | O_EXCL, 0600);
    ck_assert(second >= 0 && flock(second, LOCK_EX) == 0);
    close(first);
    ck_assert_int_eq(poll(&told, 1, 300), 0);
    close(second);
    ck_assert_int_eq(read(opened[0], &byte, 1), 1);
    int status;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_int_eq(status, 0);
    close(opened[0]);
    bed.store = store_bed_handle(&bed);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_identity__files_beside_the_store_must_be_files)
{
    static const char *const ends[] = {"-wal", "-shm"};
    char hint[200];
    pen_log_set_level(PEN_LOG_ERROR + 1);
    for (int i = 0; i < 2; i++) {
        store_bed_open(&bed);
        pen_store_close(bed.store);
        ck_assert(unlink(beside(ends[i])) == 0 || !is_there(ends[i]));
        ck_assert_int_eq(mkdir(beside(ends[i]), 0700), 0);
        snprintf(hint, sizeof hint, "%s: it is a folder, not a file", beside(ends[i]));
        refuse(bed.url, PEN_STORAGE, hint);
        ck_assert_int_eq(rmdir(beside(ends[i])), 0);
        close(open(beside("-wal"), O_WRONLY | O_CREAT, 0600)); /* a store may need its log */
        bed.store = store_bed_handle(&bed);
        store_bed_close(&bed);
    }
}
END_TEST

START_TEST(test_identity__a_held_lock_is_an_error_that_names_its_holder)
{
    store_bed_open(&bed);
    int fd = open(beside("-wake"), O_RDWR);
    char hint[64];
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(flock(fd, LOCK_EX), 0);
    snprintf(hint, sizeof hint, "process %ld holds the lock on", (long)getpid());
    refuse(bed.url, PEN_UNAVAILABLE, hint);
    close(fd);
    pen_store_close(store_bed_handle(&bed));
    store_bed_close(&bed);
}
END_TEST

/* Access to a mapped file beyond its end would kill the process. */
START_TEST(test_identity__a_truncated_wake_file_is_filled_again)
{
    struct stat info;
    uint32_t seen = 0;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    submit(bed.store, 1);
    ck_assert_int_eq(truncate(beside("-wake"), 0), 0);
    submit(bed.store, 2);
    ck_assert_int_eq(truncate(beside("-wake"), 0), 0);
    pen_store_wait(bed.store, PEN_SIGNAL_WORK, &seen, 10);
    ck_assert_int_eq(truncate(beside("-wake"), 10), 0);
    pen_store_wake(bed.store, PEN_SIGNAL_WORK);
    ck_assert_int_eq(stat(beside("-wake"), &info), 0);
    ck_assert_int_eq(info.st_size, 4096);
    ck_assert_int_eq(count_jobs(bed.store), 2);
    pen_store_close(store_bed_handle(&bed));
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("identity of a store", test_identity__is_made_once_and_a_backup_has_another,
          test_identity__a_store_that_is_gone_is_not_made_anew,
          test_identity__a_log_without_its_store_keeps_a_new_one_from_being_made,
          test_identity__another_store_is_refused, test_identity__a_missing_log_is_noticed,
          test_identity__an_empty_log_is_the_operators_consent,
          test_identity__a_settled_store_needs_no_other_file,
          test_identity__a_store_that_others_use_is_not_settled,
          test_identity__nothing_is_made_where_the_store_is_gone,
          test_identity__a_link_leads_to_the_store_with_its_files,
          test_identity__a_supervisor_is_found_without_the_files_beside_the_store,
          test_identity__a_store_whose_wake_file_was_replaced_is_not_settled,
          test_identity__the_log_of_another_store_is_not_applied,
          test_identity__a_log_that_is_removed_in_use_takes_no_jobs,
          test_identity__what_a_removed_log_had_is_saved,
          test_identity__a_removed_shm_file_takes_no_jobs_and_no_further_process,
          test_identity__a_removed_shm_file_is_made_anew_when_nobody_uses_the_store,
          test_identity__a_handle_that_is_about_to_go_is_waited_for,
          test_identity__a_lock_file_without_a_name_keeps_nobody_out,
          test_identity__files_beside_the_store_must_be_files,
          test_identity__a_held_lock_is_an_error_that_names_its_holder,
          test_identity__a_truncated_wake_file_is_filled_again)
