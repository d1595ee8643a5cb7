/* SPDX-License-Identifier: MIT */
/* Damaged files: every page of a store is overwritten in turn, and headers, lengths, logs, schema
 * and permissions are wrong. The store must refuse each with a message that has what was found,
 * where, and what to do, and must leave the file and its log as they were. Damage that is met while
 * the store is in use is not served. */
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/log.h"
#include "support/store.h"
#include "support/suite.h"

enum { PAGE_BYTES = 4096, FILE_BYTES_MAX = 1 << 22, JOBS = 12 };

static struct store_bed bed;
static char log_path[128];

struct content {
    unsigned char *data;
    long bytes; /* -1: there is no file */
};

static struct content read_content(const char *path)
{
    struct content content = {.bytes = -1};
    FILE *file = fopen(path, "rb");
    if (!file)
        return content;
    content.data = malloc(FILE_BYTES_MAX);
    ck_assert_ptr_nonnull(content.data);
    content.bytes = (long)fread(content.data, 1, FILE_BYTES_MAX, file);
    ck_assert_int_lt(content.bytes, FILE_BYTES_MAX);
    fclose(file);
    return content;
}

static void write_content(const char *path, const void *data, size_t bytes)
{
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(data, 1, bytes, file), bytes);
    fclose(file);
}

static void expect_content(const char *path, struct content *before)
{
    struct content now = read_content(path);
    ck_assert_msg(now.bytes == before->bytes, "%s had %ld bytes and has %ld", path, before->bytes,
                  now.bytes);
    if (now.bytes > 0)
        ck_assert_msg(memcmp(now.data, before->data, (size_t)now.bytes) == 0, "%s changed", path);
    free(now.data);
    free(before->data);
}

/* As a daemon does at its start: opening or the check must fail with a message that contains `hint`
 * and names the file, and must change nothing. */
static void refuse(const char *what, const char *hint)
{
    struct pen_status st = {0};
    struct content file = read_content(bed.url), log = read_content(log_path);
    struct pen_store *store = pen_store_open(bed.url, &st);
    bool ok = store && pen_store_check(store, &st);
    pen_store_close(store);
    ck_assert_msg(!ok, "%s: found nothing", what);
    ck_assert_msg(st.code == PEN_STORAGE, "%s: %s: %s", what, pen_code_name(st.code), st.msg);
    ck_assert_msg(strstr(st.msg, hint) && strstr(st.msg, bed.url), "%s: \"%s\" lacks \"%s\"", what,
                  st.msg, hint);
    expect_content(bed.url, &file);
    expect_content(log_path, &log);
}

/* A closed store with rows in all tables, several pages of each. */
static struct content make_store(void)
{
    static char picture[20000] = "a picture";
    struct pen_status st;
    struct store_job in;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    snprintf(log_path, sizeof log_path, "%s-wal", bed.url);
    for (int n = 0; n < JOBS; n++) {
        static const unsigned char body[32];
        char key[16];
        struct pen_buf answer = {0};
        enum pen_submit_result result;
        snprintf(key, sizeof key, "key %d", n);
        store_job_init(&in, n, 2, 8);
        in.job.idempotency_key = key;
        in.job.body_sha256 = body;
        in.job.answer = "{}";
        store_must(pen_store_submit(bed.store, &in.job, &result, &answer, &st), &st, "submit");
        pen_buf_release(&answer);
    }
    store_work_off(bed.store, "w");
    store_put(bed.store,
              &(struct store_artefact){in.id, 0, "beauty", "pfm", picture, sizeof picture});
    store_worker_seen(bed.store, "w");
    pen_store_close(bed.store);
    return read_content(bed.url);
}

static void clear_up(struct content *good)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", bed.folder);
    ck_assert_int_eq(system(command), 0);
    free(good->data);
}

/* A row of SQLite's table dbstat: overwrites the page, which must be noticed. */
static int each_page(void *user, int columns, char **value, char **name)
{
    const struct content *good = user;
    char what[128];
    long at = (strtol(value[0], NULL, 10) - 1) * PAGE_BYTES;
    (void)columns;
    (void)name;
    unsigned char *bad = malloc((size_t)good->bytes);
    ck_assert_ptr_nonnull(bad);
    /* An overflow page holds a part of one value; SQLite can check only the link on it. */
    bool value_only = strcmp(value[2], "overflow") == 0;
    for (int fill = value_only ? 0x5a : 0; fill <= 0x5a; fill += 0x5a) {
        memcpy(bad, good->data, (size_t)good->bytes);
        memset(bad + at, fill, PAGE_BYTES);
        write_content(bed.url, bad, (size_t)good->bytes);
        snprintf(what, sizeof what, "page %s of %s, filled with %02x", value[0], value[1], fill);
        refuse(what, "damaged");
    }
    free(bad);
    return 0;
}

START_TEST(test_damage__every_page_of_every_table_and_index)
{
    sqlite3 *db;
    char path[160];
    struct content good = make_store();
    snprintf(path, sizeof path, "%s/copy", bed.folder);
    write_content(path, good.data, (size_t)good.bytes);
    ck_assert_int_eq(sqlite3_open(path, &db), SQLITE_OK);
    ck_assert_int_eq(
        sqlite3_exec(db, "SELECT pageno, name, pagetype FROM dbstat", each_page, &good, NULL),
        SQLITE_OK);
    sqlite3_close(db);
    clear_up(&good);
}
END_TEST

/* Changes 4 bytes of the header, big endian. */
static void with_header(const struct content *good, int at, unsigned value)
{
    for (int i = 0; i < 4; i++)
        good->data[at + i] = (unsigned char)(value >> (24 - 8 * i));
    write_content(bed.url, good->data, (size_t)good->bytes);
}

START_TEST(test_damage__headers)
{
    struct content good = make_store();
    unsigned version = good.data[63];
    with_header(&good, 68, 0x00000007);
    refuse("application id", "another program");
    with_header(&good, 68, 0x50656e6d);
    with_header(&good, 60, 1000);
    refuse("newer schema", "newer Penumbra (schema 1000");
    with_header(&good, 60, 0);
    refuse("no schema", "version 0");
    with_header(&good, 60, 2);
    refuse("older schema than it has", "not of schema 2");
    with_header(&good, 60, 0xffffffff);
    refuse("negative schema", "version -1");
    with_header(&good, 60, version);
    memcpy(good.data, "SQLite format 4", 16);
    write_content(bed.url, good.data, (size_t)good.bytes);
    refuse("magic", "not a Penumbra store");
    clear_up(&good);
}
END_TEST

START_TEST(test_damage__lengths)
{
    struct content good = make_store();
    static const double parts[] = {0.9, 0.5, 0.1};
    for (int i = 0; i < 3; i++) {
        long pages = (long)(parts[i] * (double)good.bytes / PAGE_BYTES);
        write_content(bed.url, good.data, (size_t)pages * PAGE_BYTES);
        refuse("whole pages cut off", "damaged");
        write_content(bed.url, good.data, (size_t)pages * PAGE_BYTES + 1000);
        refuse("cut within a page", "damaged");
    }
    write_content(bed.url, good.data, 50);
    refuse("cut within the header", "not a Penumbra store");
    write_content(bed.url, "", 0);
    refuse("empty", "is empty");
    write_content(bed.url, "a diary\n", 8);
    refuse("a text", "not a Penumbra store");
    clear_up(&good);
}
END_TEST

/* The version is right, but a column is missing. */
START_TEST(test_damage__schema_that_is_not_of_its_version)
{
    sqlite3 *db;
    struct content good = make_store();
    ck_assert_int_eq(sqlite3_open(bed.url, &db), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(db, "DROP TABLE worker", NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
    write_content(log_path, "", 0); /* this connection, the last one, has removed it */
    refuse("a missing table", "not of the version");
    clear_up(&good);
}
END_TEST

START_TEST(test_damage__not_a_file)
{
    struct pen_status st;
    struct content good = make_store();
    unlink(bed.url);
    ck_assert_int_eq(mkdir(bed.url, 0700), 0);
    ck_assert_ptr_null(pen_store_open(bed.url, &st));
    ck_assert_msg(strstr(st.msg, "it is a folder") != NULL, "%s", st.msg);
    rmdir(bed.url);
    ck_assert_int_eq(mkfifo(bed.url, 0600), 0);
    ck_assert_ptr_null(pen_store_open(bed.url, &st));
    ck_assert_msg(strstr(st.msg, "device or pipe") != NULL, "%s", st.msg);
    clear_up(&good);
}
END_TEST

/* In a process that is not root, since root may open any file. */
START_TEST(test_damage__no_permission)
{
    enum { SKIPPED = 77 };
    struct content good = make_store();
    static const mode_t modes[] = {0444, 0200, 0};
    bool skipped = false;
    ck_assert_int_eq(chmod(bed.folder, 0777), 0);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(chmod(bed.url, modes[i]), 0);
        pid_t pid = fork();
        if (pid == 0) {
            struct pen_status st = {0};
            if (geteuid() == 0 && setuid(65534) != 0)
                _exit(SKIPPED);
            struct pen_store *store = pen_store_open(bed.url, &st);
            _exit(!store && st.code == PEN_STORAGE && strstr(st.msg, "Permission denied") ? 0 : 1);
        }
        int status;
        ck_assert_int_eq(waitpid(pid, &status, 0), pid);
        skipped = WIFEXITED(status) && WEXITSTATUS(status) == SKIPPED;
        ck_assert_msg(skipped || (WIFEXITED(status) && WEXITSTATUS(status) == 0), "mode %o: %x",
                      (unsigned)modes[i], (unsigned)status);
    }
    if (skipped)
        suite_skip("setuid", "root cannot become another user here");
    ck_assert_int_eq(chmod(bed.url, 0600), 0); /* this process may be no root either */
    struct content now = read_content(bed.url);
    ck_assert_int_eq(now.bytes, good.bytes);
    ck_assert_mem_eq(now.data, good.data, (size_t)good.bytes);
    free(now.data);
    clear_up(&good);
}
END_TEST

/* The files that a killed process leaves: the last jobs are only in the log. */
static void make_killed_store(struct content *file, struct content *log)
{
    store_bed_make(&bed);
    snprintf(log_path, sizeof log_path, "%s-wal", bed.url);
    pid_t pid = fork();
    if (pid == 0) {
        struct store_job in;
        bed.store = store_bed_handle(&bed);
        for (int n = 0; n < 6; n++) {
            store_job_init(&in, n, 1, 1);
            store_job_submit(bed.store, &in);
        }
        _exit(0);
    }
    int status;
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    pen_log_set_level(PEN_LOG_ERROR + 1);
    *file = read_content(bed.url);
    *log = read_content(log_path);
    ck_assert_int_gt(log->bytes, 32);
}

static void put_log(const struct content *file, const void *data, size_t bytes)
{
    char shm[128];
    snprintf(shm, sizeof shm, "%s-shm", bed.url);
    unlink(shm);
    write_content(bed.url, file->data, (size_t)file->bytes);
    write_content(log_path, data, bytes);
}

static int jobs_found(void)
{
    struct pen_status st;
    struct pen_job_filter filter = {.state = -1, .limit = 100};
    struct pen_job_record *jobs;
    int count = 0;
    bed.store = store_bed_handle(&bed);
    store_must(pen_store_check(bed.store, &st), &st, "check");
    store_must(pen_store_jobs(bed.store, &filter, &jobs, &count, &st), &st, "list");
    pen_job_records_free(jobs, count);
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
    return count;
}

START_TEST(test_damage__logs)
{
    struct content file, log;
    make_killed_store(&file, &log);
    size_t bytes = (size_t)log.bytes;
    unsigned char *bad = malloc(bytes + 1);
    ck_assert_ptr_nonnull(bad);
    for (size_t i = 0; i < bytes; i++)
        bad[i] = (unsigned char)(i * 167 + 13);
    put_log(&file, bad, bytes);
    refuse("a log of garbage",
           "-wal, the log of the store's last changes, is damaged (its header)");
    memcpy(bad, log.data, bytes);
    bad[17] ^= 1;
    put_log(&file, bad, bytes);
    refuse("a salt of the log", "its header");
    for (size_t at = 32; at < bytes / 2; at += 1237) {
        memcpy(bad, log.data, bytes);
        bad[at] ^= 0x40;
        put_log(&file, bad, bytes);
        refuse("a byte of an early frame", "before its end");
    }
    free(bad);
    clear_up(&file);
    free(log.data);
}
END_TEST

/* A crash may tear the last transaction of a log: that is no damage. */
START_TEST(test_damage__torn_logs_are_no_damage)
{
    struct content file, log;
    make_killed_store(&file, &log);
    static const unsigned char zero[32];
    put_log(&file, zero, sizeof zero);
    ck_assert_int_eq(jobs_found(), 0);
    put_log(&file, log.data, 20);
    ck_assert_int_eq(jobs_found(), 0);
    int last = 0;
    for (long bytes = 32; bytes <= log.bytes; bytes += 2060) {
        put_log(&file, log.data, (size_t)bytes);
        int found = jobs_found();
        ck_assert_int_ge(found, last);
        last = found;
    }
    put_log(&file, log.data, (size_t)log.bytes);
    ck_assert_int_eq(jobs_found(), 6);
    log.data[log.bytes - 100] ^= 1; /* in the last transaction, which a crash may tear */
    put_log(&file, log.data, (size_t)log.bytes);
    ck_assert_int_eq(jobs_found(), 5);
    clear_up(&file);
    free(log.data);
}
END_TEST

static void overwrite(const struct content *content, long from)
{
    int fd = open(bed.url, O_WRONLY);
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(pwrite(fd, content->data + from, (size_t)(content->bytes - from), from),
                     content->bytes - from);
    close(fd);
}

/* A store tries to recover again within a minute, however long its last try took. */
enum { STEP_US = 100000, RECOVERY_STEPS = 90 * 1000000 / STEP_US };

/* While handles are open, all pages after the first are overwritten, and later restored. */
START_TEST(test_damage__found_in_use_is_not_served_until_it_is_gone)
{
    struct pen_status st = {0};
    struct store_job in;
    struct pen_job_record job;
    struct content good = make_store(), bad = read_content(bed.url);
    bed.store = store_bed_handle(&bed);
    struct pen_store *other = store_bed_handle(&bed);
    memset(bad.data + PAGE_BYTES, 0x5a, (size_t)bad.bytes - PAGE_BYTES);
    overwrite(&bad, PAGE_BYTES);
    store_job_init(&in, 1, 1, 1);
    ck_assert(!pen_store_job(bed.store, in.id, &job, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_msg(strstr(st.msg, "damaged") && strstr(st.msg, "restore a backup"), "%s", st.msg);
    st = (struct pen_status){0};
    ck_assert(
        !pen_store_job(other, in.id, &job, &st)); /* this handle has not met the damage itself */
    ck_assert_msg(strstr(st.msg, "damaged") != NULL, "%s", st.msg);
    ck_assert(!pen_store_cancel(other, in.id, NULL, &st));
    ck_assert(!pen_store_probe(other, &st));
    overwrite(&good, 0);
    bool served = false;
    for (int i = 0; i < RECOVERY_STEPS && !served; i++) {
        served = pen_store_job(other, in.id, &job, &st);
        usleep(STEP_US);
    }
    store_must(served, &st, "job");
    pen_job_record_release(&job);
    store_must(pen_store_probe(bed.store, &st), &st, "probe");
    pen_store_close(other);
    store_bed_close(&bed);
    free(good.data);
    free(bad.data);
}
END_TEST

static bool submit_one(int n, struct pen_status *st)
{
    struct store_job in;
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    store_job_init(&in, n, 1, 1);
    bool ok = pen_store_submit(bed.store, &in.job, &result, &answer, st);
    pen_buf_release(&answer);
    return ok;
}

static void expect_refusal(int n, const char *hint)
{
    struct pen_status st = {0};
    for (int i = 0; i < RECOVERY_STEPS && !strstr(st.msg, hint); i++) {
        ck_assert(!submit_one(n, &st));
        ck_assert_int_eq(st.code, PEN_STORAGE);
        usleep(STEP_US);
    }
    ck_assert_msg(strstr(st.msg, hint) != NULL, "\"%s\" lacks \"%s\"", st.msg, hint);
}

/* Jobs written to a file without a name would vanish with the process. */
START_TEST(test_damage__file_that_loses_its_name_takes_no_jobs)
{
    char away[128], command[300];
    struct pen_status st = {0};
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    snprintf(away, sizeof away, "%s/away", bed.folder);
    store_must(submit_one(1, &st), &st, "submit");
    ck_assert_int_eq(rename(bed.url, away), 0);
    expect_refusal(2, "was moved or removed");
    snprintf(command, sizeof command, "cp %s %s", away, bed.url);
    ck_assert_int_eq(system(command), 0);
    expect_refusal(2, "another file was put in the place");
    ck_assert_int_eq(rename(away, bed.url), 0);
    bool ok = false;
    for (int i = 0; i < RECOVERY_STEPS && !ok; i++) {
        ok = submit_one(2, &st);
        usleep(STEP_US);
    }
    store_must(ok, &st, "submit");
    ck_assert_int_eq(store_work_off(bed.store, "w"), 2);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store damage", test_damage__every_page_of_every_table_and_index, test_damage__headers,
          test_damage__lengths, test_damage__schema_that_is_not_of_its_version,
          test_damage__not_a_file, test_damage__no_permission, test_damage__logs,
          test_damage__torn_logs_are_no_damage,
          test_damage__found_in_use_is_not_served_until_it_is_gone,
          test_damage__file_that_loses_its_name_takes_no_jobs)
