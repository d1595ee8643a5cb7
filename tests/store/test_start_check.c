/* SPDX-License-Identifier: MIT */
/* The check at the start of a daemon: it reads a part of a large store, and still finds a file that
 * was cut off, a damaged table of jobs, and a damaged log. */
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"
#include "support/store.h"
#include "support/suite.h"

enum { MIB = 1 << 20, PICTURES = 18 };

static struct store_bed bed;

static void open_large(void)
{
    static char picture[4 * MIB];
    struct store_job in;
    struct pen_status st;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_open(&bed);
    for (int n = 0; n < 40; n++) {
        store_job_init(&in, n, 1, 2);
        store_job_submit(bed.store, &in);
    }
    for (int view = 0; view < PICTURES; view++) {
        picture[0] = (char)view;
        store_put(bed.store,
                  &(struct store_artefact){in.id, view, "depth", "pfm", picture, sizeof picture});
    }
    store_must(pen_store_settle(bed.store, &st), &st, "settle");
    store_must(pen_store_check_start(bed.store, &st), &st, "check");
    pen_store_close(bed.store);
}

/* Opening or the check must find damage. */
static void expect_damage(const char *what)
{
    struct pen_status st = {0};
    struct pen_store *store = pen_store_open(bed.url, &st);
    bool ok = store && pen_store_check_start(store, &st);
    pen_store_close(store);
    ck_assert_msg(!ok && st.code == PEN_STORAGE && strstr(st.msg, "damaged"), "%s: %s", what,
                  ok ? "found nothing" : st.msg);
}

static void remove_bed(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", bed.folder);
    ck_assert_int_eq(system(command), 0);
}

START_TEST(test_start_check__finds_a_large_file_that_was_cut_off)
{
    struct stat info;
    open_large();
    ck_assert_int_eq(stat(bed.url, &info), 0);
    ck_assert_int_gt(info.st_size, 64 * MIB);
    ck_assert_int_eq(truncate(bed.url, (info.st_size / 4096 - 100) * 4096), 0);
    expect_damage("a file that was cut off");
    remove_bed();
}
END_TEST

/* The tables of jobs and batches are within the first pages, written before the pictures. */
START_TEST(test_start_check__finds_damaged_tables_of_a_large_store)
{
    char page[4096];
    open_large();
    memset(page, 0x5a, sizeof page);
    int fd = open(bed.url, O_WRONLY);
    ck_assert_int_ge(fd, 0);
    for (int i = 3; i < 24; i++)
        ck_assert_int_eq(pwrite(fd, page, sizeof page, i * 4096), (ssize_t)sizeof page);
    close(fd);
    expect_damage("tables");
    remove_bed();
}
END_TEST

/* A reader of an older state keeps the log from being copied, so that the file is shorter than its
 * pages say, and yet whole. */
START_TEST(test_start_check__a_large_store_in_use_is_not_called_damaged)
{
    static const char picture[100000];
    struct pen_status st;
    sqlite3 *reader;
    open_large();
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(sqlite3_open_v2(bed.url, &reader, SQLITE_OPEN_READWRITE, NULL), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(reader, "BEGIN; SELECT count(*) FROM job", NULL, NULL, NULL),
                     SQLITE_OK);
    struct store_job in;
    store_job_init(&in, 0, 1, 2);
    store_put(bed.store,
              &(struct store_artefact){in.id, 0, "normal", "pfm", picture, sizeof picture});
    store_must(pen_store_check_start(bed.store, &st), &st, "check in use");
    ck_assert_int_eq(sqlite3_exec(reader, "COMMIT", NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(reader);
    store_must(pen_store_check_start(bed.store, &st), &st, "check");
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("the check at a start", test_start_check__finds_a_large_file_that_was_cut_off,
          test_start_check__finds_damaged_tables_of_a_large_store,
          test_start_check__a_large_store_in_use_is_not_called_damaged)
