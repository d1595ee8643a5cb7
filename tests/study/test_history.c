/* SPDX-License-Identifier: MIT */
/* Histories: change points of simulated times, the order of reports, separate hosts, and the
 * output. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/report.h"
#include "study/history.h"
#include "support/random.h"
#include "support/suite.h"

enum { POINTS_MAX = 60, REPORTS_MAX = 40 };

static struct pen_status st;

/* Values around `level`, 1 % up and down. */
static void fill(struct random *r, double *values, int first, int end, double level)
{
    for (int i = first; i < end; i++)
        values[i] = level * random_in(r, 0.99, 1.01);
}

START_TEST(test_history__steps_are_found_where_they_are)
{
    struct random r = random_begin(20261124);
    double values[POINTS_MAX];
    int at[POINTS_MAX];
    for (int trial = 0; trial < 100; trial++) {
        const int first = 8 + (int)random_below(&r, 12), second = 40 - (int)random_below(&r, 12);
        fill(&r, values, 0, first, 100);
        fill(&r, values, first, second, 105);
        fill(&r, values, second, 50, 98);
        ck_assert_int_eq(pen_history_changes(values, 50, 0.02, at), 2);
        ck_assert_int_eq(at[0], first);
        ck_assert_int_eq(at[1], second);
    }
}
END_TEST

START_TEST(test_history__chance_is_taken_for_a_change_in_about_one_history_of_twenty)
{
    enum { TRIALS = 600 };
    struct random r = random_begin(7);
    double values[POINTS_MAX];
    int at[POINTS_MAX], found = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        fill(&r, values, 0, 20, 100);
        found += pen_history_changes(values, 20, 0, at) > 0;
    }
    /* The mean is 30. Each of these limits is exceeded once in 10 000 times. */
    ck_assert_msg(found >= 12 && found <= 52, "%d of %d, seed %llu", found, (int)TRIALS,
                  (unsigned long long)r.seed);
}
END_TEST

START_TEST(test_history__small_and_few_changes_do_not_count)
{
    struct random r = random_begin(3);
    double values[POINTS_MAX];
    int at[POINTS_MAX];
    fill(&r, values, 0, 10, 100);
    fill(&r, values, 10, 20, 104);
    ck_assert_int_eq(pen_history_changes(values, 20, 0.02, at), 1);
    ck_assert_int_eq(at[0], 10);
    ck_assert_int_eq(pen_history_changes(values, 20, 0.06, at), 0);
    ck_assert_int_eq(pen_history_changes(values + 6, 7, 0.02, at), 0);
    ck_assert_int_eq(pen_history_changes(values + 6, 8, 0.02, at), 1);
    ck_assert_int_eq(pen_history_changes(values, 0, 0.02, at), 0);
}
END_TEST

/* Report `number` of a scene: one row with 10 runs of `ms`. */
static json_t *report(int number, const char *scene, const char *cpu, double ms)
{
    char time[40];
    json_t *runs = json_array();
    snprintf(time, sizeof time, "2026-01-%02dT00:00:00.000Z", number + 1);
    for (int i = 0; i < 10; i++)
        json_array_append_new(runs, json_real(ms + 0.001 * i));
    return json_pack("{s:s, s:s, s:s, s:{s:i}, s:{s:s, s:s}, s:{s:f}, s:[{s:{s:i}, s:o, s:[]}]}",
                     "kind", "benchmark", "scene", scene, "began_at", time, "render", "width", 80,
                     "host", "cpu", cpu, "build", "<b>", "calibration", "median_ms", 2.0, "rows",
                     "settings", "threads", 1, "runs_ms", runs, "spoiled_runs");
}

static json_t *reports[REPORTS_MAX];

static void release(int count)
{
    for (int i = 0; i < count; i++)
        json_decref(reports[i]);
}

static json_t *at_path(const json_t *history, const char *list, size_t i)
{
    return json_array_get(json_object_get(history, list), i);
}

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

START_TEST(test_history__reports_are_in_the_order_of_time)
{
    static const int order[] = {4, 1, 3, 0, 2};
    for (int i = 0; i < 5; i++)
        reports[i] = report(order[i], "room", "A", 100 + order[i]);
    json_t *history = pen_history_new(reports, 5, 0.02, &st);
    ck_assert_ptr_nonnull(history);
    const json_t *points = json_object_get(at_path(history, "rows", 0), "points");
    ck_assert_uint_eq(json_array_size(points), 5);
    for (size_t i = 0; i < 5; i++) {
        const json_t *point = json_array_get(points, i);
        ck_assert_double_eq_tol(number(point, "median_ms"), 100.0045 + (double)i, 1e-9);
        ck_assert_double_eq_tol(number(point, "low_ms"), 100.001 + (double)i, 1e-9);
        ck_assert_double_eq_tol(number(point, "high_ms"), 100.008 + (double)i, 1e-9);
        ck_assert_double_eq_tol(number(point, "calibrated"), (100.0045 + (double)i) / 2, 1e-9);
        ck_assert(number(point, "report") == (double)i);
    }
    json_decref(history);
    release(5);
}
END_TEST

START_TEST(test_history__another_host_is_no_change_and_hides_none)
{
    for (int i = 0; i < 30; i++) {
        const bool other = i % 3 == 2;
        reports[i] = report(i, "room", other ? "B" : "A", other ? 150 : i < 15 ? 100 : 110);
    }
    json_t *history = pen_history_new(reports, 30, 0.02, &st);
    const json_t *row = at_path(history, "rows", 0), *changes = json_object_get(row, "changes");
    ck_assert_uint_eq(json_array_size(json_object_get(history, "hosts")), 2);
    ck_assert_uint_eq(json_array_size(changes), 1);
    const json_t *change = json_array_get(changes, 0);
    ck_assert(number(change, "point") == 15);
    ck_assert_double_eq_tol(number(change, "ratio"), 1.1, 1e-4);
    struct pen_buf text = {0};
    ck_assert(pen_report_write(history, "text", NULL, &text, &st));
    ck_assert_ptr_nonnull(strstr((char *)text.data,
                                 "change at 2026-01-16 build <b>: 110 ms, before "
                                 "100 ms, +10.0 %"));
    pen_buf_release(&text);
    json_decref(history);
    release(30);
}
END_TEST

START_TEST(test_history__page_has_all_points_and_no_markup_of_reports)
{
    for (int i = 0; i < 20; i++)
        reports[i] = report(i, "<script>", "<img src=x>", i < 10 ? 100 : 120);
    json_object_set_new(reports[0], "began_at", json_string("2000</svg>"));
    json_array_append_new(
        json_object_get(reports[3], "rows"),
        json_pack("{s:{s:s}, s:[f]}", "settings", "threads", "</h2><b>", "runs_ms", 1.5));
    json_t *history = pen_history_new(reports, 20, 0.02, &st);
    struct pen_buf text = {0};
    ck_assert(pen_report_write(history, "html", NULL, &text, &st));
    const char *page = (const char *)text.data;
    int points = 0;
    for (const char *c = page; (c = strstr(c, "<tr><th scope=\"row\"")) != NULL; c++)
        points++;
    ck_assert_int_eq(points, 21);
    ck_assert_ptr_nonnull(strstr(page, "+20.0 %"));
    ck_assert_ptr_nonnull(strstr(page, "&lt;script&gt;"));
    ck_assert_ptr_null(strstr(page, "<script>\""));
    ck_assert_ptr_null(strstr(page, "<img"));
    ck_assert_ptr_null(strstr(page, "<b>"));
    ck_assert_ptr_null(strstr(page, "2000</svg>"));
    pen_buf_release(&text);
    json_decref(history);
    release(20);
}
END_TEST

START_TEST(test_history__is_of_one_scene)
{
    reports[0] = report(0, "room", "A", 1);
    reports[1] = report(1, "forest", "A", 1);
    ck_assert_ptr_null(pen_history_new(reports, 2, 0.02, &st));
    ck_assert_int_eq(st.code, PEN_INVALID);
    ck_assert_ptr_nonnull(strstr(st.msg, "\"room\" and \"forest\""));
    ck_assert_ptr_null(pen_history_new(reports, 0, 0.02, &st));
    release(2);
}
END_TEST

PEN_SUITE("history", test_history__steps_are_found_where_they_are,
          test_history__chance_is_taken_for_a_change_in_about_one_history_of_twenty,
          test_history__small_and_few_changes_do_not_count,
          test_history__reports_are_in_the_order_of_time,
          test_history__another_host_is_no_change_and_hides_none,
          test_history__page_has_all_points_and_no_markup_of_reports, test_history__is_of_one_scene)
