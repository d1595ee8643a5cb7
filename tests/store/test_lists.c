/* SPDX-License-Identifier: MIT */
/* Lists of jobs by name, label, kind and state, together and apart, and what reading them costs. */
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>

#include "store/sqlite/sqlite.h"
#include "store/store.h"
#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;

static void submit(int number, const char *request)
{
    struct store_job in;
    store_job_init(&in, number, 1, 1);
    in.job.request = request;
    in.job.kind = number % 2 ? "render" : "benchmark";
    store_job_submit(bed.store, &in);
}

/* Jobs 1 to 6; those with even numbers are benchmarks. The last one is cancelled. */
static void submit_all(void)
{
    static const char *const requests[] = {
        "{\"name\": \"a\", \"labels\": {\"shot\": \"12\", \"name\": \"b\"}}",
        "{\"name\": \"a\", \"labels\": {\"shot\": \"13\"}}",
        "{\"name\": \"b\", \"labels\": {}}",
        "{\"labels\": {\"shot\": \"12\", \"\": \"empty\"}}",
        "{\"name\": \"\", \"labels\": {\"shot:12\": \"\"}}",
        "{\"name\": \"a\", \"labels\": {\"shot\": \"12\"}}",
    };
    struct store_job last;
    struct pen_status st;
    for (int i = 0; i < 6; i++)
        submit(i + 1, requests[i]);
    store_job_init(&last, 6, 1, 1);
    ck_assert(pen_store_cancel(bed.store, last.id, NULL, &st));
}

/* Checks that a list has the jobs with these numbers, one digit each. */
static void expect_list(const struct pen_job_filter *filter, const char *numbers)
{
    struct pen_job_record *jobs;
    struct pen_status st;
    char found[16] = "";
    int count;
    store_must(pen_store_jobs(bed.store, filter, &jobs, &count, &st), &st, "list");
    for (int i = 0; i < count; i++)
        for (int n = 1; n <= 6; n++) {
            struct store_job job;
            store_job_init(&job, n, 1, 1);
            if (strcmp(job.id, jobs[i].id) == 0)
                snprintf(found + strlen(found), sizeof found - strlen(found), "%d", n);
        }
    pen_job_records_free(jobs, count);
    ck_assert_msg(strcmp(found, numbers) == 0,
                  "name %s, label %s: %s, kind %s, state %d: %s instead of %s",
                  filter->name ? filter->name : "-", filter->label_key ? filter->label_key : "-",
                  filter->label_value ? filter->label_value : "-",
                  filter->kind ? filter->kind : "-", filter->state, found, numbers);
}

static void expect_lists(void)
{
    static const struct {
        const char *name, *key, *value, *kind;
        int state;
        const char *numbers;
    } rows[] = {
        {NULL, NULL, NULL, NULL, -1, "654321"},
        {"a", NULL, NULL, NULL, -1, "621"},
        {"b", NULL, NULL, NULL, -1, "3"}, /* not the label of that name */
        {"", NULL, NULL, NULL, -1, "5"},
        {"c", NULL, NULL, NULL, -1, ""},
        {NULL, "shot", "12", NULL, -1, "641"},
        {NULL, "shot", "1", NULL, -1, ""},
        {NULL, "", "empty", NULL, -1, "4"},
        {NULL, "shot:12", "", NULL, -1, "5"},
        {NULL, "name", "b", NULL, -1, "1"},
        {"a", "shot", "12", NULL, -1, "61"},
        {"b", "shot", "12", NULL, -1, ""},
        {NULL, NULL, NULL, "benchmark", -1, "642"},
        {"a", NULL, NULL, "benchmark", -1, "62"},
        {NULL, "shot", "12", "render", -1, "1"},
        {NULL, NULL, NULL, NULL, PEN_JOB_CANCELLED, "6"},
        {"a", NULL, NULL, NULL, PEN_JOB_QUEUED, "21"},
        {NULL, "shot", "12", NULL, PEN_JOB_CANCELLED, "6"},
        {NULL, NULL, NULL, "render", PEN_JOB_CANCELLED, ""},
        {"a", "shot", "12", "benchmark", PEN_JOB_CANCELLED, "6"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pen_job_filter filter = {.state = rows[i].state,
                                        .kind = rows[i].kind,
                                        .name = rows[i].name,
                                        .label_key = rows[i].key,
                                        .label_value = rows[i].value,
                                        .limit = 100};
        expect_list(&filter, rows[i].numbers);
    }
}

START_TEST(test_lists__have_the_jobs_that_meet_all_conditions)
{
    store_bed_open(&bed);
    submit_all();
    expect_lists();
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_lists__go_on_below_a_number)
{
    store_bed_open(&bed);
    submit_all();
    struct pen_job_filter filter = {.state = -1, .name = "a", .below = 6, .limit = 1};
    expect_list(&filter, "2");
    filter = (struct pen_job_filter){
        .state = -1, .label_key = "shot", .label_value = "12", .below = 4, .limit = 9};
    expect_list(&filter, "1");
    store_bed_close(&bed);
}
END_TEST

/* Jobs of a store that had no such lists, one of whose requests has been damaged. */
START_TEST(test_lists__find_the_jobs_of_earlier_schemas)
{
    enum { BEFORE = 12 };
    struct pen_status st;
    store_bed_open(&bed);
    submit_all();
    submit(7, "{\"name\": \"a\"}");
    store_must(pen_store_settle(bed.store, &st), &st, "settle");
    pen_store_close(bed.store);
    store_run_sql(&bed, "UPDATE job SET request = '{\"na' WHERE number = 7", NULL, 0);
    store_downgrade(bed.url, BEFORE);
    bed.store = store_bed_handle(&bed);
    expect_lists();
    store_bed_close(&bed);
}
END_TEST

/* Checks that a statement begins by finding rows of an index, goes on without reading a whole
 * table, and sorts nothing. */
static void expect_plan(sqlite3 *db, enum pen_sqlite_sql sql, const char *begins)
{
    char text[8192];
    sqlite3_stmt *stmt;
    int rows = 0;
    snprintf(text, sizeof text, "EXPLAIN QUERY PLAN %s", pen_sqlite_sql_text(sql));
    ck_assert_int_eq(sqlite3_prepare_v2(db, text, -1, &stmt, NULL), SQLITE_OK);
    for (; sqlite3_step(stmt) == SQLITE_ROW; rows++) {
        const char *step = (const char *)sqlite3_column_text(stmt, 3);
        ck_assert_msg(rows > 0 || strstr(step, begins), "%s: begins by %s", text, step);
        ck_assert_msg(strncmp(step, "SCAN", 4) != 0 && !strstr(step, "TEMP B-TREE"), "%s: %s", text,
                      step);
    }
    ck_assert_int_gt(rows, 0);
    sqlite3_finalize(stmt);
}

START_TEST(test_lists__read_no_jobs_but_those_of_their_kind_name_state_or_label)
{
    sqlite3 *db;
    store_bed_open(&bed);
    ck_assert_int_eq(sqlite3_open(bed.url, &db), SQLITE_OK);
    expect_plan(db, SQL_JOB_LIST, "INTEGER PRIMARY KEY (rowid<?)");
    expect_plan(db, SQL_JOB_LIST_STATE, "job_by_state (state=? AND number<?)");
    expect_plan(db, SQL_JOB_LIST_KIND, "job_by_kind (kind=? AND number<?)");
    expect_plan(db, SQL_JOB_LIST_NAME, "PRIMARY KEY (key=? AND value=? AND job<?)");
    expect_plan(db, SQL_JOB_LIST_LABEL, "PRIMARY KEY (key=? AND value=? AND job<?)");
    sqlite3_close(db);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_lists__forget_a_job_that_is_deleted)
{
    struct store_job last;
    struct pen_status st;
    store_bed_open(&bed);
    submit_all();
    store_job_init(&last, 6, 1, 1);
    store_must(pen_store_delete(bed.store, last.id, NULL, NULL, &st), &st, "delete");
    struct pen_job_filter filter = {.state = -1, .name = "a", .limit = 9};
    expect_list(&filter, "21");
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store lists", test_lists__have_the_jobs_that_meet_all_conditions,
          test_lists__go_on_below_a_number, test_lists__find_the_jobs_of_earlier_schemas,
          test_lists__read_no_jobs_but_those_of_their_kind_name_state_or_label,
          test_lists__forget_a_job_that_is_deleted)
