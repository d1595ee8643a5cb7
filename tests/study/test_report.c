/* SPDX-License-Identifier: MIT */
/* Reports in all formats: their contents, the escaping of markup, and that any JSON value can be
 * written. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/report.h"
#include "support/random.h"
#include "support/suite.h"

static struct pen_buf out;

/* A report of two rows. The words in capitals are replaced, see report_with. */
static const char sample[] =
    "{\"kind\": \"benchmark\", \"scene\": \"SCENE\", \"views\": [\"main\"], \"repeats\": 3,"
    " \"warmup\": 1, \"baseline\": 0, \"render\": {\"width\": 800}, \"rows\": ["
    "{\"row\": 0, \"settings\": {\"accelerator\": \"none\", \"threads\": 1}, \"threads\": 1,"
    " \"median_ms\": 12345.678, \"min_ms\": 12000.0, \"max_ms\": 13000.5, \"speedup\": 1.0,"
    " \"rays\": {\"primary\": 1400000, \"shadow\": 5, \"total\": 1400005},"
    " \"accelerator\": {\"box_tests_per_ray\": 0.0, \"primitive_tests_per_ray\": 419.5},"
    " \"compared_with\": 0, \"identical\": true, \"max_difference\": 0.0, \"rmse\": 0.0},"
    "{\"row\": 1, \"settings\": {\"accelerator\": \"auto\", \"threads\": 0}, \"threads\": 2,"
    " \"median_ms\": FAST, \"min_ms\": FAST, \"max_ms\": 130.5, \"speedup\": 100.25,"
    " \"compared_with\": 0, \"identical\": false, \"max_difference\": 0.125, \"rmse\": 0.03125,"
    " \"ratio\": {\"median\": 0.01, \"low\": 0.009, \"high\": 0.011, \"pairs\": 12, \"spoiled\": "
    "1},"
    " \"verdict\": \"faster\", \"cpu_share\": 0.5, \"steal_ms\": null, \"picture_hash\": \"00ff\","
    " \"tests\": {\"boxes\": 7, \"primitives\": 8}}],"
    " \"notes\": [\"NOTE\"], \"host\": {\"name\": \"CPU\", \"cpu\": \"CPU\", \"isa\": \"avx2\", "
    "\"cores\": 2,"
    " \"version\": \"0.1.0\"}, \"pool_threads\": 2}";

static void replace(char *text, size_t bytes, const char *word, const char *by)
{
    char copy[4096];
    for (char *at; (at = strstr(text, word)) != NULL;) {
        snprintf(copy, sizeof copy, "%.*s%s%s", (int)(at - text), text, by, at + strlen(word));
        snprintf(text, bytes, "%s", copy);
    }
}

/* The sample with `text` for SCENE, NOTE and CPU, and `fast` for FAST. Both are inserted into JSON
 * as they are. */
static json_t *report_with(const char *text, const char *fast)
{
    char document[4096];
    snprintf(document, sizeof document, "%s", sample);
    replace(document, sizeof document, "SCENE", text);
    replace(document, sizeof document, "NOTE", text);
    replace(document, sizeof document, "CPU", text);
    replace(document, sizeof document, "FAST", fast);
    json_error_t error;
    json_t *report = json_loads(document, 0, &error);
    ck_assert_msg(report != NULL, "%s at %s", error.text, document + error.position);
    return report;
}

static const char *write_as(const json_t *report, const char *format)
{
    struct pen_status st;
    pen_buf_release(&out);
    ck_assert(pen_report_write(report, format, &out, &st));
    return (const char *)out.data;
}

static void has(const char *text, const char *part)
{
    ck_assert_msg(strstr(text, part) != NULL, "no %s in %s", part, text);
}

static void lacks(const char *text, const char *part)
{
    ck_assert_msg(strstr(text, part) == NULL, "there is %s", part);
}

START_TEST(test_report__csv_has_a_line_for_each_row)
{
    json_t *report = report_with("room", "123.5");
    const char *text = write_as(report, "csv");
    has(text, "row,accelerator,threads,threads_worked,median_ms,min_ms,max_ms,speedup,");
    has(text, "\n0,none,1,1,12345.678,12000.0,13000.5,1.0,");
    has(text, "\n1,auto,0,2,123.5,123.5,130.5,100.25,");
    has(text, ",rmse,ratio,ratio_low,ratio_high,pairs,spoiled_pairs,verdict,cpu_share,steal_ms,"
              "box_tests,primitive_tests,picture_hash\n");
    has(text, ",false,0.125,0.03125,0.01,0.009,0.011,12,1,faster,0.5,,7,8,00ff\n");
    int lines = 0, commas = 0, first = 0;
    for (const char *c = text; *c; c++) {
        commas += *c == ',';
        if (*c == '\n') {
            first = lines++ ? first : commas;
            ck_assert_int_eq(commas, first);
            commas = 0;
        }
    }
    ck_assert_int_eq(lines, 3);
    json_decref(report);
}
END_TEST

START_TEST(test_report__csv_quotes_separators_and_line_feeds)
{
    json_t *report = report_with("room", "123.5");
    json_t *row = json_array_get(json_object_get(report, "rows"), 0);
    json_object_set_new(json_object_get(row, "settings"), "accelerator",
                        json_string("a \"b\", c\nd"));
    has(write_as(report, "csv"), "\n0,\"a \"\"b\"\", c\nd\",1,1,");
    json_decref(report);
}
END_TEST

START_TEST(test_report__json_reads_back_as_itself)
{
    json_t *report = report_with("room", "0.1");
    json_t *again = json_loads(write_as(report, "json"), 0, NULL);
    ck_assert(json_equal(report, again));
    json_decref(again);
    json_decref(report);
}
END_TEST

START_TEST(test_report__markdown_has_rounded_times_and_ratios)
{
    json_t *report = report_with("room", "123.5");
    const char *text = write_as(report, "md");
    has(text, "# Benchmark: room\n");
    has(text, "| 0 | none | 1 | 12 346 | 12 000\xE2\x80\x93"
              "13 000 | 1.00\xC3\x97 |");
    has(text, "| 1 | auto | all 2 | 124 | 124\xE2\x80\x93"
              "130 | 100\xC3\x97 |");
    has(text, "| 0.010 (0.009\xE2\x80\x93"
              "0.011) | faster |");
    has(text, "| max 0.125, rmse 0.0312 from row 0 | 00ff |");
    has(text, "1 400 000");
    has(text, "\nroom: room, avx2, 2 cores, 2 threads in the pool");
    json_decref(report);
}
END_TEST

START_TEST(test_report__noise_floor_and_end_of_the_repeats_are_told)
{
    json_t *report = report_with("room", "123.5");
    has(write_as(report, "md"), "Noise floor: not measured");
    json_object_set_new(report, "noise",
                        json_pack("{s:f, s:f, s:f, s:f}", "median", 1.001, "low", 0.99, "high",
                                  1.012, "half_width", 0.011));
    json_object_set_new(report, "interval", json_real(0.02));
    json_object_set_new(report, "budget_seconds", json_real(9));
    json_object_set_new(report, "ended_by", json_string("budget"));
    static const char *const formats[] = {"md", "html"};
    for (int i = 0; i < 2; i++) {
        const char *text = write_as(report, formats[i]);
        has(text, "the baseline against itself 1.001 (0.990\xE2\x80\x93"
                  "1.012), that is \xC2\xB1"
                  "1.1 %.");
        has(text, "The budget of 9 s ended before all intervals were as narrow as 0.02.");
    }
    json_object_set_new(report, "ended_by", json_string("interval"));
    has(write_as(report, "html"), "All intervals are as narrow as 0.02.");
    json_decref(report);
}
END_TEST

START_TEST(test_report__text_from_a_scene_is_escaped)
{
    static const char evil[] =
        "</title></svg><script>alert(1)</script><img src=x onerror='x'>&amp;`*_[a](b)|\\n# h\\\"";
    json_t *report = report_with(evil, "123.5");
    json_t *row = json_array_get(json_object_get(report, "rows"), 0);
    json_object_set_new(json_object_get(row, "settings"), "accelerator",
                        json_string("<b onclick=\"x\">"));
    const char *text = write_as(report, "html");
    lacks(text, "<script");
    lacks(text, "<img");
    lacks(text, "<b ");
    lacks(text, "onclick=\"");
    has(text, "&lt;script&gt;alert(1)&lt;/script&gt;");
    has(text, "&amp;amp;");
    has(text, "onerror=&#39;x&#39;");
    text = write_as(report, "md");
    lacks(text, "<script");
    lacks(text, "\n# h");
    lacks(text, "[a](");
    has(text, "\\|");
    json_decref(report);
}
END_TEST

START_TEST(test_report__text_has_no_control_characters)
{
    json_t *report = report_with("\\u001b[2Jroom\\u0007", "123.5");
    struct pen_buf text = {0};
    pen_bench_report_write_text(report, &text);
    ck_assert(!text.failed);
    for (const unsigned char *c = text.data; *c; c++)
        ck_assert(*c >= 0x20 || *c == '\n');
    pen_buf_release(&text);
    json_decref(report);
}
END_TEST

START_TEST(test_report__page_is_self_contained)
{
    json_t *report = report_with("room", "123.5");
    const char *text = write_as(report, "html");
    static const char *const outside[] = {"http:", "https:", "src=", "url(", "@import", "href"};
    for (size_t i = 0; i < sizeof outside / sizeof outside[0]; i++)
        lacks(text, outside[i]);
    has(text, "<html lang=\"en\">");
    has(text, "prefers-color-scheme:dark");
    has(text, "role=\"img\" aria-labelledby=\"chart-title chart-desc\"");
    has(text, "<title id=\"chart-title\">");
    has(text, "<desc id=\"chart-desc\">none, 1 thread: 12346 ms. auto, all 2 threads: 124 ms. ");
    json_decref(report);
}
END_TEST

START_TEST(test_report__axis_is_logarithmic_where_times_spread_widely)
{
    json_t *report = report_with("room", "123.5");
    has(write_as(report, "html"), "logarithmic axis");
    json_decref(report);
    report = report_with("room", "5000.5");
    json_t *row = json_array_get(json_object_get(report, "rows"), 1);
    json_object_set_new(row, "max_ms", json_real(5001));
    lacks(write_as(report, "html"), "logarithmic axis");
    json_decref(report);
}
END_TEST

/* The number after the next `before`, as in width="12.5"; moves *text to it. */
static double next_number(const char **text, const char *before)
{
    const char *at = strstr(*text, before);
    ck_assert_msg(at != NULL, "no %s", before);
    *text = at + strlen(before);
    return strtod(*text, NULL);
}

START_TEST(test_report__bars_are_as_long_as_the_times)
{
    json_t *report = report_with("room", "6172.839");
    json_t *row = json_array_get(json_object_get(report, "rows"), 1);
    json_object_set_new(row, "max_ms", json_real(7000));
    const char *text = write_as(report, "html");
    double first = next_number(&text, "<rect class=\"bar base\"");
    first = next_number(&text, "width=\"");
    double second = next_number(&text, "<rect class=\"bar\"");
    second = next_number(&text, "width=\"");
    ck_assert_double_eq_tol(first, 2 * second, 0.2);
    json_decref(report);
}
END_TEST

/* Any JSON value, with the keys of a report at random places. */
static json_t *any_value(struct random *r, int depth)
{
    static const char *const keys[] = {"rows",  "settings", "row",       "median_ms", "min_ms",
                                       "notes", "host",     "threads",   "rays",      "scene",
                                       "views", "baseline", "identical", "speedup",   "max_ms"};
    switch (random_below(r, depth > 0 ? 8 : 5)) {
    case 0:
        return json_null();
    case 1:
        return json_integer((json_int_t)random_bits(r));
    case 2:
        return json_real(random_in(r, -1e300, 1e300));
    case 3:
        return json_string("<a\\\"&'|\xC3\xA9>");
    case 4:
        return json_boolean(random_below(r, 2));
    case 5: {
        json_t *list = json_array();
        for (uint64_t n = random_below(r, 4); n > 0; n--)
            json_array_append_new(list, any_value(r, depth - 1));
        return list;
    }
    default: {
        json_t *object = json_object();
        for (uint64_t n = random_below(r, 9); n > 0; n--)
            json_object_set_new(object, keys[random_below(r, 15)], any_value(r, depth - 1));
        return object;
    }
    }
}

/* A report of rows with 1, 2 and `most` threads, whose times are 100, 60 and 30 ms, each twice. */
static json_t *threads_report(double most)
{
    const double threads[] = {1, 2, most}, ms[] = {100, 60, 30};
    json_t *rows = json_array();
    for (int i = 0; i < 3; i++)
        json_array_append_new(rows, json_pack("{s:i, s:{s:f}, s:f, s:[f, f]}", "row", i, "settings",
                                              "threads", threads[i], "threads", threads[i],
                                              "runs_ms", ms[i], ms[i] * 0.5));
    json_array_set_new(json_object_get(json_array_get(rows, 0), "runs_ms"), 1, json_real(50));
    return json_pack("{s:s, s:o}", "kind", "benchmark", "rows", rows);
}

START_TEST(test_report__speed_up_is_drawn_over_threads)
{
    json_t *report = threads_report(4);
    const char *at = write_as(report, "html");
    double x[3], y[3];
    has(at, "<h2>Threads</h2>");
    has(at, "; 2 threads: 1.67 times; 4 threads: 3.33 times.");
    for (int i = 0; i < 3; i++) {
        at = strstr(at, "<circle cx=");
        ck_assert_ptr_nonnull(at);
        ck_assert_int_eq(sscanf(at, "<circle cx=\"%lf\" cy=\"%lf\"", &x[i], &y[i]), 2);
        at++;
    }
    /* Both axes are linear and begin at 0. */
    ck_assert_double_eq_tol((x[2] - x[1]) / (x[1] - x[0]), 2, 0.02);
    ck_assert_double_eq_tol((y[0] - y[2]) / (y[0] - y[1]), (100. / 30 - 1) / (100. / 60 - 1), 0.05);
    json_decref(report);
    report = threads_report(64);
    at = write_as(report, "html");
    has(at, "both axes logarithmic");
    json_decref(report);
}
END_TEST

START_TEST(test_report__no_chart_of_threads_without_two_numbers_of_them)
{
    json_t *report = report_with("room", "123.5"); /* the accelerators differ, too */
    lacks(write_as(report, "html"), "<h2>Threads</h2>");
    json_decref(report);
    static const double wrong[] = {0, -5, 1e300, 0.5};
    for (int i = 0; i < 4; i++) {
        report = threads_report(wrong[i]);
        has(write_as(report, "html"), "; 2 threads: 1.67 times. </desc>");
        json_decref(report);
    }
}
END_TEST

START_TEST(test_report__any_json_can_be_written)
{
    struct random r = random_begin(41);
    for (int i = 0; i < 2000; i++) {
        json_t *report = any_value(&r, 5);
        for (int format = 0; pen_report_formats[format]; format++) {
            struct pen_status st;
            pen_buf_release(&out);
            ck_assert_msg(
                pen_report_write(report, pen_report_formats[format], &out, &st),
                "PEN_SEED=%llu: %s", (unsigned long long)r.seed, st.msg);
        }
        json_decref(report);
    }
}
END_TEST

PEN_SUITE("report", test_report__speed_up_is_drawn_over_threads,
          test_report__no_chart_of_threads_without_two_numbers_of_them,
          test_report__noise_floor_and_end_of_the_repeats_are_told,
          test_report__csv_has_a_line_for_each_row,
          test_report__csv_quotes_separators_and_line_feeds, test_report__json_reads_back_as_itself,
          test_report__markdown_has_rounded_times_and_ratios,
          test_report__text_from_a_scene_is_escaped, test_report__text_has_no_control_characters,
          test_report__page_is_self_contained,
          test_report__axis_is_logarithmic_where_times_spread_widely,
          test_report__bars_are_as_long_as_the_times, test_report__any_json_can_be_written)
