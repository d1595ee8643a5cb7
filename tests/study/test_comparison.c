/* SPDX-License-Identifier: MIT */
/* Comparisons of reports: matching of rows, differences, verdicts. Any JSON can be compared. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/report.h"
#include "study/comparison.h"
#include "support/random.h"
#include "support/suite.h"

static struct pen_status st;

/* A row of `count` runs around `ms`. */
static json_t *row(int threads, double ms, int count)
{
    json_t *runs = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(runs, json_real(ms * (1 + 0.0001 * i)));
    return json_pack("{s:{s:i}, s:i, s:o, s:[], s:{s:i, s:i}, s:{s:i, s:i}, s:s}", "settings",
                     "threads", threads, "threads", threads, "runs_ms", runs, "spoiled_runs",
                     "rays", "primary", 100, "shadow", 200, "tests", "boxes", 300, "primitives",
                     400, "picture_hash", "00ff");
}

/* A report of rows with 1 and 2 threads. */
static json_t *report(double ms, int count)
{
    return json_pack("{s:s, s:s, s:i, s:[s], s:{s:i}, s:f, s:{s:s, s:s}, s:{s:f}, s:s, s:[o, o]}",
                     "kind", "benchmark", "scene", "room", "primitives", 7, "views", "main",
                     "render", "width", 80, "least_effect", 0.02, "host", "cpu", "A", "kernel", "K",
                     "calibration", "median_ms", 2.0, "began_at", "2026-11-24T00:00:00.000Z",
                     "rows", row(1, 2 * ms, count), row(2, ms, count));
}

static json_t *row_of(json_t *report, int i)
{
    return json_array_get(json_object_get(report, "rows"), (size_t)i);
}

static json_t *compare(const json_t *before, const json_t *after)
{
    json_t *out = pen_comparison_new(before, after, &st);
    ck_assert_msg(out != NULL, "%s", st.msg);
    return out;
}

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

START_TEST(test_comparison__verdict_is_that_of_the_interval_of_both_medians)
{
    static const struct {
        double after;
        int count;
        const char *verdict, *reason;
    } cases[] = {{105, 20, "slower", ""},
                 {100.5, 20, "same", ""},
                 {95, 20, "faster", ""},
                 {102, 20, "undecided", "the interval is too wide"},
                 {105, 9, "undecided", "fewer than 10 runs"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        json_t *before = report(100, 20), *after = report(cases[i].after, cases[i].count);
        json_t *comparison = compare(before, after);
        for (int r = 0; r < 2; r++) {
            ck_assert_str_eq(text_of(row_of(comparison, r), "verdict"), cases[i].verdict);
            ck_assert_ptr_nonnull(
                strstr(text_of(row_of(comparison, r), "reason"), cases[i].reason));
        }
        ck_assert(pen_comparison_judge(comparison, false, &st));
        ck_assert(pen_comparison_judge(comparison, true, &st) == (i != 0));
        json_decref(comparison);
        json_decref(after);
        json_decref(before);
    }
    ck_assert_int_eq(st.code, PEN_DIFFERENT);
    ck_assert_str_eq(st.msg, "2 rows are slower");
}
END_TEST

/* The report of an accuracy study with one row. */
static json_t *study(double rmse, const char *hash)
{
    return json_pack("{s:s, s:s, s:i, s:s, s:{s:i}, s:f, s:{s:s}, s:[{s:{s:i}, s:i, s:i, s:[f, f], "
                     "s:{s:i}, s:s, s:f, s:f}]}",
                     "kind", "accuracy", "scene", "room", "primitives", 7, "view", "main", "render",
                     "width", 80, "least_effect", 0.02, "host", "cpu", "A", "rows", "settings",
                     "light_samples", 4, "threads", 2, "runs", 2, "runs_ms", 10.0, 11.0, "rays",
                     "primary", 100, "picture_hash", hash, "rmse", rmse, "flip", 2 * rmse);
}

START_TEST(test_comparison__accuracy_studies_have_errors_of_both)
{
    json_t *before = study(0.25, "0a"), *after = study(0.125, "0b");
    ck_assert(pen_comparison_check(before, &st));
    json_t *comparison = compare(before, after);
    json_t *wanted = json_pack("{s:[f, f], s:[f, f]}", "rmse", 0.25, 0.125, "flip", 0.5, 0.25);
    ck_assert(json_equal(json_object_get(row_of(comparison, 0), "errors"), wanted));
    ck_assert(!pen_comparison_judge(comparison, false, &st)); /* the pictures differ */
    struct pen_buf text = {0};
    ck_assert(pen_report_write(comparison, "text", NULL, &text, &st));
    ck_assert_ptr_nonnull(strstr((const char *)text.data, "0.25\xE2\x80\x93"
                                                          "0.125"));
    pen_buf_release(&text);
    json_decref(comparison);
    comparison = compare(before, before);
    ck_assert(pen_comparison_judge(comparison, true, &st));
    json_t *benchmark = report(100, 20);
    ck_assert_ptr_null(pen_comparison_new(before, benchmark, &st));
    ck_assert_ptr_nonnull(strstr(st.msg, "of different kinds: accuracy and benchmark"));
    json_t *same = compare(benchmark, benchmark);
    ck_assert(json_is_null(json_object_get(row_of(same, 0), "errors")));
    json_decref(same);
    json_decref(benchmark);
    json_decref(comparison);
    json_decref(wanted);
    json_decref(after);
    json_decref(before);
}
END_TEST

START_TEST(test_comparison__interval_has_the_extremes_of_both_at_half_the_error)
{
    json_t *before = report(100, 10), *after = report(200, 10);
    json_t *comparison = compare(before, after);
    const json_t *ratio = json_object_get(row_of(comparison, 1), "ratio");
    /* Of 10 values, the interval has the second and the second last as ends: an error of 2.1 %. */
    const double low = 200 * 1.0001 / (100 * 1.0008), high = 200 * 1.0008 / (100 * 1.0001);
    ck_assert_double_eq_tol(json_real_value(json_object_get(ratio, "low")), low, 1e-12);
    ck_assert_double_eq_tol(json_real_value(json_object_get(ratio, "high")), high, 1e-12);
    json_decref(comparison);
    json_decref(after);
    json_decref(before);
}
END_TEST

START_TEST(test_comparison__hosts_that_differ_have_a_calibrated_ratio_and_no_verdict)
{
    json_t *before = report(100, 20), *after = report(50, 20);
    json_object_set_new(json_object_get(after, "host"), "cpu", json_string("B"));
    json_object_set_new(json_object_get(after, "calibration"), "median_ms", json_real(1));
    json_t *comparison = compare(before, after);
    ck_assert_uint_eq(json_array_size(json_object_get(comparison, "host_differences")), 1);
    const json_t *first = row_of(comparison, 0);
    ck_assert_str_eq(text_of(first, "verdict"), "undecided");
    ck_assert_ptr_nonnull(strstr(text_of(first, "reason"), "different hosts"));
    ck_assert_double_eq_tol(json_real_value(json_object_get(first, "calibrated_ratio")), 1, 1e-12);
    struct pen_buf text = {0};
    ck_assert(pen_report_write(comparison, "text", NULL, &text, &st));
    ck_assert_ptr_nonnull(strstr((char *)text.data, "different hosts, by cpu:"));
    pen_buf_release(&text);
    json_decref(comparison);
    json_decref(after);
    json_decref(before);
}
END_TEST

START_TEST(test_comparison__times_and_calibrated_times_must_agree)
{
    json_t *before = report(100, 20), *after = report(105, 20);
    json_object_set_new(json_object_get(after, "calibration"), "median_ms", json_real(2.08));
    json_t *comparison = compare(before, after);
    const json_t *first = row_of(comparison, 0);
    ck_assert_str_eq(text_of(first, "verdict"), "undecided");
    ck_assert_ptr_nonnull(strstr(text_of(first, "reason"), "host's own speed"));
    json_decref(comparison);
    json_object_set_new(json_object_get(after, "calibration"), "median_ms", json_real(2.02));
    comparison = compare(before, after);
    ck_assert_str_eq(text_of(row_of(comparison, 0), "verdict"), "slower");
    json_decref(comparison);
    json_decref(after);
    json_decref(before);
}
END_TEST

START_TEST(test_comparison__one_count_or_picture_more_is_a_difference)
{
    static const char *const counters[][2] = {
        {"rays", "primary"}, {"rays", "shadow"}, {"tests", "boxes"}, {"tests", "primitives"}};
    json_t *before = report(100, 20);
    for (int i = 0; i < 5; i++) {
        json_t *after = report(90, 20), *changed = row_of(after, 1);
        json_t *group = i < 4 ? json_object_get(changed, counters[i][0]) : changed;
        json_object_set_new(group, i < 4 ? counters[i][1] : "picture_hash",
                            i < 4 ? json_integer(401) : json_string("00fe"));
        json_t *comparison = compare(before, after);
        ck_assert(!pen_comparison_judge(comparison, false, &st));
        ck_assert_int_eq(st.code, PEN_DIFFERENT);
        ck_assert_ptr_nonnull(strstr(st.msg, i < 4 ? "counted" : "pictures"));
        ck_assert_str_eq(text_of(row_of(comparison, 1), "verdict"),
                         i < 4 ? "faster" : "different picture");
        struct pen_buf text = {0};
        ck_assert(pen_report_write(comparison, "text", NULL, &text, &st));
        ck_assert_ptr_nonnull(
            strstr((char *)text.data, i < 4 ? " before, 401 after" : "DIFFERENT"));
        pen_buf_release(&text);
        json_decref(comparison);
        json_decref(after);
    }
    json_decref(before);
}
END_TEST

START_TEST(test_comparison__rows_are_matched_by_their_settings)
{
    json_t *before = report(100, 20), *after = report(100, 20);
    json_t *rows = json_object_get(after, "rows");
    json_array_insert_new(rows, 0, row(4, 50, 20)); /* a row is added, and the others move */
    json_array_remove(rows, 1);                     /* the row of 1 thread is missing */
    json_object_set_new(json_object_get(before, "render"), "later", json_true());
    json_t *comparison = compare(before, after);
    ck_assert_uint_eq(json_array_size(json_object_get(comparison, "rows")), 1);
    char *settings = json_dumps(json_object_get(row_of(comparison, 0), "settings"), JSON_COMPACT);
    char *missing = json_dumps(json_object_get(comparison, "missing"), JSON_COMPACT);
    char *added = json_dumps(json_object_get(comparison, "added"), JSON_COMPACT);
    ck_assert_str_eq(settings, "{\"threads\":2}");
    ck_assert_str_eq(missing, "[{\"threads\":1}]");
    ck_assert_str_eq(added, "[{\"threads\":4}]");
    free(settings);
    free(missing);
    free(added);
    json_decref(comparison);
    json_object_set_new(json_object_get(after, "render"), "width", json_integer(81));
    ck_assert_ptr_null(pen_comparison_new(before, after, &st));
    ck_assert_ptr_nonnull(strstr(st.msg, "no row"));
    json_object_set_new(after, "scene", json_string("forest"));
    ck_assert_ptr_null(pen_comparison_new(before, after, &st));
    ck_assert_ptr_nonnull(strstr(st.msg, "different scenes: scene is room and forest"));
    json_decref(after);
    json_decref(before);
}
END_TEST

START_TEST(test_comparison__a_host_that_differs_from_itself_gives_no_verdict)
{
    json_t *before = report(100, 20), *after = report(200, 20);
    json_object_set_new(before, "noise", json_pack("{s:s}", "verdict", "slower"));
    json_t *comparison = compare(before, after);
    ck_assert_str_eq(text_of(row_of(comparison, 0), "verdict"), "undecided");
    ck_assert_ptr_nonnull(strstr(text_of(row_of(comparison, 0), "reason"), "twin"));
    json_decref(comparison);
    json_decref(after);
    json_decref(before);
}
END_TEST

/* Replaces a random part of a value. */
static json_t *spoil(struct random *r, json_t *value)
{
    static const char *const others[] = {"null", "[]", "{}", "\"\\u0007\"", "-1", "1e308", "[1]"};
    if (random_below(r, 4) == 0 || json_array_size(value) + json_object_size(value) == 0)
        return json_loads(others[random_below(r, 7)], JSON_DECODE_ANY, NULL);
    json_t *copy = json_copy(value);
    if (json_is_array(copy)) {
        const size_t i = random_below(r, (uint32_t)json_array_size(copy));
        json_array_set_new(copy, i, spoil(r, json_array_get(copy, i)));
        return copy;
    }
    void *at = json_object_iter(copy);
    for (uint32_t skip = random_below(r, (uint32_t)json_object_size(copy)); skip > 0; skip--)
        at = json_object_iter_next(copy, at);
    json_object_iter_set_new(copy, at, spoil(r, json_object_iter_value(at)));
    return copy;
}

START_TEST(test_comparison__any_json_can_be_compared)
{
    struct random r = random_begin(20261124);
    int compared = 0;
    for (int i = 0; i < random_cases(4000); i++) {
        json_t *before = report(100, 12), *whole = report(101, 12), *after = spoil(&r, whole);
        json_t *comparison = NULL;
        struct pen_buf text = {0};
        if (pen_comparison_check(after, &st))
            comparison = pen_comparison_new(before, after, &st);
        if (comparison) {
            ck_assert(pen_report_write(comparison, "text", NULL, &text, &st));
            for (size_t c = 0; c < text.bytes; c++)
                ck_assert(text.data[c] >= 0x20 || text.data[c] == '\n');
            compared++;
        } else {
            ck_assert_msg(st.code == PEN_INVALID, "seed %llu: %s", (unsigned long long)r.seed,
                          st.msg);
        }
        pen_buf_release(&text);
        json_decref(comparison);
        json_decref(after);
        json_decref(whole);
        json_decref(before);
    }
    ck_assert_int_gt(compared, random_cases(4000) / 4);
}
END_TEST

PEN_SUITE("comparison", test_comparison__verdict_is_that_of_the_interval_of_both_medians,
          test_comparison__accuracy_studies_have_errors_of_both,
          test_comparison__interval_has_the_extremes_of_both_at_half_the_error,
          test_comparison__hosts_that_differ_have_a_calibrated_ratio_and_no_verdict,
          test_comparison__times_and_calibrated_times_must_agree,
          test_comparison__one_count_or_picture_more_is_a_difference,
          test_comparison__rows_are_matched_by_their_settings,
          test_comparison__a_host_that_differs_from_itself_gives_no_verdict,
          test_comparison__any_json_can_be_compared)
