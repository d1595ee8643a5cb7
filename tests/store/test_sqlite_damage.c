/* SPDX-License-Identifier: MIT */
/* Damaged files. Every page of a store is overwritten in turn, and headers, lengths and permissions
 * are wrong. Opening or the check refuses each with a message that names the file, and leaves it
 * unchanged. Damage that is found in use breaks the handle. A check ends when its time is up. */
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "support/faults.h"
#include "support/store.h"
#include "support/suite.h"

enum { PAGE_BYTES = 8192, FILE_BYTES_MAX = 1 << 22, JOBS = 12 };

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
    const bool empty = before->bytes < 0 && now.bytes == 0; /* a log without anything */
    ck_assert_msg(empty || now.bytes == before->bytes, "%s had %ld bytes and has %ld", path,
                  before->bytes, now.bytes);
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
    bool finished;
    struct pen_store *store = pen_store_open(bed.url, false, &st);
    bool ok = store && pen_store_check(store, 0, &finished, &st);
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
    const struct pen_claim claim = store_claim(bed.store, "w");
    store_must(
        pen_store_artefact_put(bed.store, &claim, "depth", "pfm", picture, sizeof picture, &st),
        &st, "put");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_work_off(bed.store, "w");
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

START_TEST(test_sqlite_damage__every_page_of_every_table_and_index)
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

START_TEST(test_sqlite_damage__headers)
{
    struct content good = make_store();
    with_header(&good, 68, 0x00000007);
    refuse("application id", "not a Penumbra store");
    memcpy(good.data, "SQLite format 4", 16);
    write_content(bed.url, good.data, (size_t)good.bytes);
    refuse("magic", "not a Penumbra store");
    clear_up(&good);
}
END_TEST

START_TEST(test_sqlite_damage__lengths)
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
    refuse("cut within the header", "damaged");
    write_content(bed.url, "", 0);
    refuse("empty", "not a Penumbra store");
    write_content(bed.url, "a diary\n", 8);
    refuse("a text", "not a Penumbra store");
    clear_up(&good);
}
END_TEST

START_TEST(test_sqlite_damage__not_a_file)
{
    struct pen_status st;
    struct content good = make_store();
    unlink(bed.url);
    ck_assert_int_eq(mkdir(bed.url, 0700), 0);
    ck_assert_ptr_null(pen_store_open(bed.url, false, &st));
    ck_assert_msg(strstr(st.msg, "is not a file") != NULL, "%s", st.msg);
    rmdir(bed.url);
    ck_assert_int_eq(mkfifo(bed.url, 0600), 0);
    ck_assert_ptr_null(pen_store_open(bed.url, false, &st));
    ck_assert_msg(strstr(st.msg, "is not a file") != NULL, "%s", st.msg);
    clear_up(&good);
}
END_TEST

/* In a process that is not root, since root may open any file. */
START_TEST(test_sqlite_damage__no_permission)
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
            struct pen_store *store = pen_store_open(bed.url, false, &st);
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

/* A page that a process reads is damaged: it is told to end, and copies nothing from its log. */
START_TEST(test_sqlite_damage__found_in_use_breaks_the_handle)
{
    struct content good = make_store();
    struct pen_status st = {0};
    struct store_job in;
    struct pen_job_record record;
    store_job_init(&in, 1, 1, 1);
    for (long at = PAGE_BYTES; at < good.bytes; at += PAGE_BYTES)
        memset(good.data + at, 0x5a, PAGE_BYTES);
    bed.store = store_bed_handle(&bed);
    write_content(bed.url, good.data, (size_t)good.bytes);
    ck_assert(!pen_store_job(bed.store, in.id, &record, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_msg(strstr(st.msg, "damaged") && strstr(st.msg, bed.url), "%s", st.msg);
    ck_assert(pen_store_is_broken(bed.store, NULL));
    pen_store_close(bed.store);
    struct content after = read_content(bed.url);
    ck_assert_mem_eq(after.data, good.data, (size_t)good.bytes);
    free(after.data);
    clear_up(&good);
}
END_TEST

START_TEST(test_sqlite_damage__a_check_ends_when_its_time_is_up)
{
    enum { LAYERS = 48, BYTES = 4 << 20, SHORT_MS = 2, LONG_MS = 100000 };
    struct pen_status st;
    struct store_job in;
    bool finished;
    char layer[24];
    char *data = calloc(1, BYTES);
    faults_install(); /* its syncs are quick */
    store_bed_open(&bed);
    store_job_init(&in, 1, 1, 2);
    store_job_submit(bed.store, &in);
    const struct pen_claim claim = store_claim(bed.store, "w");
    for (int i = 0; i < LAYERS; i++) {
        snprintf(layer, sizeof layer, "layer%d", i);
        store_must(pen_store_artefact_put(bed.store, &claim, layer, "pfm", data, BYTES, &st), &st,
                   "put");
    }
    free(data);
    int64_t begun_ns = 0, short_ns = 0;
    finished = true;
    for (int i = 0; i < 50 && finished; i++) { /* a busy machine may be late to interrupt it */
        begun_ns = pen_clock_ns();
        store_must(pen_store_check(bed.store, SHORT_MS, &finished, &st), &st, "short");
        short_ns = pen_clock_ns() - begun_ns;
    }
    ck_assert(!finished);
    ck_assert(!pen_store_is_broken(bed.store, NULL));
    begun_ns = pen_clock_ns();
    store_must(pen_store_check(bed.store, LONG_MS, &finished, &st), &st, "long");
    const int64_t long_ns = pen_clock_ns() - begun_ns;
    ck_assert(finished);
    printf("%.1f ms of %.1f ms\n", (double)short_ns / 1e6, (double)long_ns / 1e6);
    ck_assert_int_lt(long_ns, LONG_MS * INT64_C(500000));
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("damaged stores", test_sqlite_damage__every_page_of_every_table_and_index,
          test_sqlite_damage__headers, test_sqlite_damage__lengths, test_sqlite_damage__not_a_file,
          test_sqlite_damage__no_permission, test_sqlite_damage__found_in_use_breaks_the_handle,
          test_sqlite_damage__a_check_ends_when_its_time_is_up)
