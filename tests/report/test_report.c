/* SPDX-License-Identifier: MIT */
/* Reports in all formats: their contents, the escaping of markup, and that any JSON value can be
 * written. */
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/report.h"
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
    ck_assert(pen_report_write(report, format, NULL, &out, &st));
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
    has(text,
        "row,accelerator,threads,threads_worked,median_ms,min_ms,max_ms,speedup,ratio,ratio_low,"
        "ratio_high,pairs,spoiled_pairs,verdict,");
    has(text, "\n0,none,1,1,12345.678,12000.0,13000.5,1.0,");
    has(text, "\n1,auto,0,2,123.5,123.5,130.5,100.25,0.01,0.009,0.011,12,1,faster,,,,0.5,,");
    has(text, ",identical,max_difference,rmse,picture_hash\n");
    has(text, ",7,8,,,");
    has(text, ",false,0.125,0.03125,00ff\n");
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
    has(text, "| 0 | accelerator none, threads 1 | 12 346 | 12 000\xE2\x80\x93"
              "13 000 | 1.00\xC3\x97 |");
    has(text, "| 1 | accelerator auto, threads all 2 | 124 | 124\xE2\x80\x93"
              "130 | 100\xC3\x97 | 0.010 (0.009\xE2\x80\x93"
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
    lacks(text, "<script>alert");
    lacks(text, "<img");
    lacks(text, "<b ");
    lacks(text, "onclick=\"");
    has(text, "&lt;script&gt;alert(1)&lt;/script&gt;");
    has(text, "\\u003cscript>alert(1)\\u003c/script>");
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
    for (const char *c = write_as(report, "text"); *c; c++)
        ck_assert((unsigned char)*c >= 0x20 || *c == '\n');
    json_decref(report);
}
END_TEST

/* What stands between two texts, the first of them in `page`. The caller frees it. */
static char *between(const char *page, const char *begin, const char *end)
{
    const char *from = strstr(page, begin);
    ck_assert_msg(from != NULL, "no %s", begin);
    from += strlen(begin);
    const char *to = strstr(from, end);
    ck_assert_ptr_nonnull(to);
    return strndup(from, (size_t)(to - from));
}

START_TEST(test_report__page_is_self_contained_and_runs_its_script_alone)
{
    static const char *const parts[][3] = {{"<script>", "</script>", "script-src 'sha256-"},
                                           {"<style>", "</style>", "style-src 'sha256-"}};
    static const char *const outside[] = {"src=\"", "url(", "@import", "href", "innerHTML"};
    json_t *report = report_with("room", "123.5");
    const char *text = write_as(report, "html");
    for (size_t i = 0; i < sizeof outside / sizeof outside[0]; i++)
        lacks(text, outside[i]);
    has(text, "<html lang=\"en\">");
    has(text, "prefers-color-scheme: dark");
    has(text, "content=\"default-src &#39;none&#39;; script-src ");
    for (int i = 0; i < 2; i++) {
        char *part = between(text, parts[i][0], parts[i][1]);
        char *hash = between(pen_report_policy(), parts[i][2], "'");
        unsigned char bytes[crypto_hash_sha256_BYTES];
        char wanted[64];
        crypto_hash_sha256(bytes, (const unsigned char *)part, strlen(part));
        sodium_bin2base64(wanted, sizeof wanted, bytes, sizeof bytes,
                          sodium_base64_VARIANT_ORIGINAL);
        ck_assert_str_eq(hash, wanted);
        free(hash);
        free(part);
    }
    json_decref(report);
}
END_TEST

START_TEST(test_report__page_has_the_report_as_data)
{
    json_t *report = report_with("a < b", "123.5");
    char *data = between(write_as(report, "html"), "id=\"data\">", "</script>");
    json_t *again = json_loads(data, 0, NULL);
    ck_assert_ptr_null(strchr(data, '<'));
    ck_assert(json_equal(report, again));
    json_decref(again);
    free(data);
    json_decref(report);
}
END_TEST

START_TEST(test_report__row_with_a_target_error_is_named_by_that)
{
    json_t *report =
        json_pack("{s:s, s:[{s:{s:i, s:f}, s:f}, {s:{s:i, s:f}, s:f}]}", "kind", "accuracy", "rows",
                  "settings", "samples_per_pixel", 4, "target_error", 0., "median_ms", 1.,
                  "settings", "samples_per_pixel", 1, "target_error", 0.01, "median_ms", 2.);
    const char *text = write_as(report, "md");
    has(text, "| 0 | samples\\_per\\_pixel 4 |");
    has(text, "| 1 | target\\_error 0.01 |");
    has(write_as(report, "csv"), "\n1,1,0.01,");
    json_decref(report);
}
END_TEST

START_TEST(test_report__of_every_kind_has_a_table)
{
    static const char *const kinds[] = {"benchmark", "accuracy", "effects", "history",
                                        "comparison"};
    for (int i = 0; i < 5; i++) {
        json_t *report =
            json_pack("{s:s, s:s, s:[{s:f, s:[{s:i, s:f}]}]}", "kind", kinds[i], "scene", "room",
                      "rows", "median_ms", 12.5, "points", "report", 0, "median_ms", 12.5);
        if (i < 4)
            has(write_as(report, "md"), "| 12.5 |");
        has(write_as(report, "html"), "<th scope=\"col\">row</th>");
        has(write_as(report, "html"), ": room</title>");
        json_decref(report);
    }
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

START_TEST(test_report__any_json_can_be_written)
{
    struct random r = random_begin(41);
    for (int i = 0; i < 2000; i++) {
        json_t *report = any_value(&r, 5);
        for (int format = 0; pen_report_formats[format]; format++) {
            struct pen_status st;
            pen_buf_release(&out);
            ck_assert_msg(pen_report_write(report, pen_report_formats[format], NULL, &out, &st),
                          "PEN_SEED=%llu: %s", (unsigned long long)r.seed, st.msg);
        }
        json_decref(report);
    }
}
END_TEST

PEN_SUITE("report", test_report__noise_floor_and_end_of_the_repeats_are_told,
          test_report__csv_has_a_line_for_each_row,
          test_report__csv_quotes_separators_and_line_feeds, test_report__json_reads_back_as_itself,
          test_report__markdown_has_rounded_times_and_ratios,
          test_report__text_from_a_scene_is_escaped, test_report__text_has_no_control_characters,
          test_report__page_is_self_contained_and_runs_its_script_alone,
          test_report__page_has_the_report_as_data,
          test_report__row_with_a_target_error_is_named_by_that,
          test_report__of_every_kind_has_a_table, test_report__any_json_can_be_written)
