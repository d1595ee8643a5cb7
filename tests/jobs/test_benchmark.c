/* SPDX-License-Identifier: MIT */
/* Benchmark specs: the errors and their places, the rows that a matrix makes, the limits. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "jobs/bench_spec.h"
#include "support/suite.h"

static struct pen_bench_spec spec;
static struct pen_errors errors;

static bool read_text(const char *text)
{
    struct pen_settings base = pen_settings_default();
    json_error_t error;
    json_t *members = json_loads(text, 0, &error);
    ck_assert_msg(members != NULL, "%s: %s", error.text, text);
    errors = (struct pen_errors){0};
    bool ok = pen_bench_spec_read(members, &base, &spec, &errors);
    json_decref(members);
    ck_assert_msg(ok == (errors.count == 0), "%s", text);
    return ok;
}

static void read_good(const char *text)
{
    if (!read_text(text))
        ck_abort_msg("%s: %s: %s", text, errors.item[0].at, errors.item[0].msg);
}

struct bad {
    const char *text;
    enum pen_code code;
    const char *at, *words;
};

static const struct bad bad_members[] = {
    {"{\"matrix\": []}", PEN_INVALID, "/matrix", "found an empty array"},
    {"{\"matrix\": {\"threads\": 1}}", PEN_INVALID, "/matrix/threads", "found 1"},
    {"{\"matrix\": {\"threads\": []}}", PEN_INVALID, "/matrix/threads", "one or more values"},
    {"{\"matrix\": {\"accelerator\": [\"none\", \"auto\", \"automatic\"]}}", PEN_INVALID,
     "/matrix/accelerator/2", "found the string \"automatic\""},
    {"{\"matrix\": {\"threads\": [1, -1]}}", PEN_INVALID, "/matrix/threads/1", "found -1"},
    {"{\"matrix\": {\"thread\": [1, 2]}}", PEN_INVALID, "/matrix/thread",
     "did you mean \"threads\"?"},
    {"{\"matrix\": {\"a/b\": [1, 2]}}", PEN_INVALID, "/matrix/a~1b", "unknown key"},
    {"{\"matrix\": {\"threads\": [1, 2, 1]}}", PEN_INVALID, "/matrix/threads/2", "twice"},
    {"{\"matrix\": {\"precision\": [\"fast\"]}}", PEN_UNSUPPORTED, "/matrix/precision/0",
     "not supported yet"},
    {"{\"repeats\": 0}", PEN_INVALID, "/repeats", "from 1 to 100, found 0"},
    {"{\"repeats\": 101}", PEN_INVALID, "/repeats", "from 1 to 100"},
    {"{\"repeats\": 1.5}", PEN_INVALID, "/repeats", "found 1.5"},
    {"{\"repeats\": 1e300}", PEN_INVALID, "/repeats", "integer"},
    {"{\"repeats\": null}", PEN_INVALID, "/repeats", "found null"},
    {"{\"warmup\": -1}", PEN_INVALID, "/warmup", "from 0 to 10"},
    {"{\"warmup\": 11}", PEN_INVALID, "/warmup", "from 0 to 10"},
    {"{\"interval\": 0}", PEN_INVALID, "/interval", "above 0 and at most 1, found 0"},
    {"{\"interval\": \"0.1\"}", PEN_INVALID, "/interval", "found the string"},
    {"{\"budget_seconds\": 86401}", PEN_INVALID, "/budget_seconds", "at most 86400"},
    {"{\"least_effect\": -0.1}", PEN_INVALID, "/least_effect", "from 0 to 1, found -0.1"},
    {"{\"order_seed\": 2147483648}", PEN_INVALID, "/order_seed", "from 0 to 2147483647"},
    {"{\"interval\": 0.1, \"repeats\": 9}", PEN_INVALID, "/repeats", "beside interval"},
    {"{\"budget_seconds\": 1, \"repeats\": 9}", PEN_INVALID, "/repeats", "beside interval"},
    {"{\"matrix\": {\"threads\": [1]}, \"baseline\": 1}", PEN_INVALID, "/baseline", "found 1"},
    {"{\"matrix\": {\"threads\": [1]}, \"baseline\": {\"threads\": 2}}", PEN_INVALID,
     "/baseline/threads", "one of the matrix's values, found 2"},
    {"{\"matrix\": {\"threads\": [1]}, \"baseline\": {\"tile\": 8}}", PEN_INVALID, "/baseline/tile",
     "must be a key of the matrix"},
};

START_TEST(test_benchmark__errors_name_their_place)
{
    for (size_t i = 0; i < sizeof bad_members / sizeof bad_members[0]; i++) {
        const struct bad *bad = &bad_members[i];
        ck_assert_msg(!read_text(bad->text), "accepted: %s", bad->text);
        const struct pen_status *st = &errors.item[0];
        ck_assert_msg(errors.count == 1, "%s: %zu errors", bad->text, errors.count);
        ck_assert_msg(st->code == bad->code, "%s: %s", bad->text, pen_code_name(st->code));
        ck_assert_msg(strcmp(st->at, bad->at) == 0, "%s: at %s", bad->text, st->at);
        ck_assert_msg(strstr(st->msg, bad->words) != NULL, "%s: %s", bad->text, st->msg);
        pen_bench_spec_release(&spec);
    }
}
END_TEST

START_TEST(test_benchmark__all_errors_are_collected)
{
    ck_assert(!read_text("{\"matrix\": {\"threads\": [1, \"x\", -1], \"tile\": [0]},"
                         " \"repeats\": 0, \"warmup\": 99}"));
    ck_assert_uint_eq(errors.count, 5);
    pen_bench_spec_release(&spec);
}
END_TEST

START_TEST(test_benchmark__defaults_are_one_row_three_repeats_one_warmup)
{
    read_good("{}");
    ck_assert_int_eq(spec.row_count, 1);
    ck_assert_int_eq(spec.repeats, 3);
    ck_assert_int_eq(spec.warmup, 1);
    ck_assert_int_eq(spec.baseline, 0);
    pen_bench_spec_release(&spec);
}
END_TEST

START_TEST(test_benchmark__interval_and_budget_imply_each_other)
{
    read_good("{}");
    ck_assert(spec.interval == 0 && spec.least_effect == 0.02);
    pen_bench_spec_release(&spec);
    read_good("{\"interval\": 0.05}");
    ck_assert(spec.interval == 0.05 && spec.budget_s == 60);
    pen_bench_spec_release(&spec);
    read_good("{\"budget_seconds\": 7, \"least_effect\": 0, \"order_seed\": 5}");
    struct pen_bench bench = pen_bench_of_spec(&spec);
    ck_assert(bench.interval == 0.02 && bench.budget_ms == 7000);
    ck_assert(bench.least_effect == 0 && bench.order_seed == 5);
    pen_bench_spec_release(&spec);
}
END_TEST

START_TEST(test_benchmark__members_of_a_spec_read_back_as_the_spec)
{
    static const char *const texts[] = {
        "{\"matrix\": {\"threads\": [1, 2]}, \"baseline\": {\"threads\": 2}, \"repeats\": 7}",
        "{\"matrix\": {\"threads\": [1, 2]}, \"interval\": 0.01, \"budget_seconds\": 9,"
        " \"warmup\": 0, \"least_effect\": 0.5}"};
    for (int i = 0; i < 2; i++) {
        read_good(texts[i]);
        struct pen_bench_spec first = spec;
        json_t *members =
            pen_bench_spec_members(&first, json_pack("{s:O}", "matrix", first.matrix));
        char *text = json_dumps(members, 0);
        read_good(text);
        ck_assert(spec.baseline == first.baseline && spec.repeats == first.repeats);
        ck_assert(spec.warmup == first.warmup && spec.interval == first.interval);
        ck_assert(spec.budget_s == first.budget_s && spec.order_seed == first.order_seed);
        ck_assert(spec.least_effect == first.least_effect);
        free(text);
        json_decref(members);
        pen_bench_spec_release(&first);
        pen_bench_spec_release(&spec);
    }
}
END_TEST

START_TEST(test_benchmark__rows_follow_the_order_of_the_document)
{
    static const struct {
        int tile, threads, accelerator;
    } rows[] = {{8, 1, PEN_ACCEL_NONE},  {8, 1, PEN_ACCEL_AUTO},  {8, 0, PEN_ACCEL_NONE},
                {8, 0, PEN_ACCEL_AUTO},  {32, 1, PEN_ACCEL_NONE}, {32, 1, PEN_ACCEL_AUTO},
                {32, 0, PEN_ACCEL_NONE}, {32, 0, PEN_ACCEL_AUTO}};
    read_good("{\"matrix\": {\"tile\": [8, 32], \"threads\": [1, 0],"
              " \"accelerator\": [\"none\", \"auto\"]}}");
    ck_assert_int_eq(spec.row_count, 8);
    for (int i = 0; i < 8; i++) {
        ck_assert_int_eq(spec.rows[i].settings.tile, rows[i].tile);
        ck_assert_int_eq(spec.rows[i].settings.threads, rows[i].threads);
        ck_assert_int_eq(spec.rows[i].settings.accelerator, rows[i].accelerator);
        ck_assert_int_eq(spec.rows[i].settings.width, 800);
    }
    char *chosen = json_dumps(spec.rows[5].varied, 0);
    ck_assert_str_eq(chosen, "{\"tile\": 32, \"threads\": 1, \"accelerator\": \"auto\"}");
    free(chosen);
    pen_bench_spec_release(&spec);
}
END_TEST

START_TEST(test_benchmark__baseline_is_the_first_row_that_matches)
{
    read_good("{\"matrix\": {\"accelerator\": [\"none\", \"auto\"], \"threads\": [1, 0]},"
              " \"baseline\": {\"accelerator\": \"auto\"}}");
    ck_assert_int_eq(spec.baseline, 2);
    pen_bench_spec_release(&spec);
    read_good("{\"matrix\": {\"accelerator\": [\"none\", \"auto\"], \"threads\": [1, 0]},"
              " \"baseline\": {\"threads\": 0, \"accelerator\": \"auto\"}}");
    ck_assert_int_eq(spec.baseline, 3);
    pen_bench_spec_release(&spec);
}
END_TEST

/* A spec with 2 thread counts and `seeds` seeds, as text. */
static const char *many_seeds(int seeds)
{
    static char text[8192];
    int used = snprintf(text, sizeof text,
                        "{\"warmup\": 0, \"repeats\": 1,"
                        " \"matrix\": {\"threads\": [1, 2], \"seed\": [0");
    for (int i = 1; i < seeds; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, ", %d", i);
    snprintf(text + used, sizeof text - (size_t)used, "]}}");
    return text;
}

START_TEST(test_benchmark__rows_are_capped)
{
    read_good(many_seeds(PEN_BENCH_ROWS_MAX / 2));
    ck_assert_int_eq(spec.row_count, PEN_BENCH_ROWS_MAX);
    pen_bench_spec_release(&spec);
    ck_assert(!read_text(many_seeds(PEN_BENCH_ROWS_MAX / 2 + 1)));
    ck_assert_str_eq(errors.item[0].at, "/matrix");
    ck_assert_ptr_nonnull(strstr(errors.item[0].msg, "makes 258 rows, at most 256"));
    pen_bench_spec_release(&spec);
}
END_TEST

/* Checks a spec against limits, for a scene without lights and one view. */
static bool check(const char *text, const struct pen_limits *limits, struct pen_status *st)
{
    struct pen_view_desc view = {.name = "main"};
    struct pen_scene_desc desc = {.view_count = 1, .views = &view};
    read_good(text);
    bool ok = pen_bench_spec_check(&spec, limits, &desc, 1, st);
    pen_bench_spec_release(&spec);
    return ok;
}

START_TEST(test_benchmark__work_of_all_runs_together_is_bounded)
{
    static const char text[] =
        "{\"repeats\": 5, \"warmup\": 2, \"matrix\": {\"width\": [100, 300], \"height\": [10]}}";
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    limits.work = (5 + 2 + 1) * 4000.0;
    if (!check(text, &limits, &st))
        ck_abort_msg("%s", st.msg);
    limits.work -= 1;
    ck_assert(!check(text, &limits, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.at, "/matrix");
    /* The twin of the first row, of 1000 pixels, is run, too; the budget bounds all other repeats.
     */
    static const char until[] = "{\"interval\": 0.02, \"warmup\": 2, \"matrix\": "
                                "{\"width\": [100, 300], \"height\": [10]}}";
    limits.work = (1 + 2 + 1) * 4000.0 + (1 + 2) * 1000.0;
    if (!check(until, &limits, &st))
        ck_abort_msg("%s", st.msg);
    limits.work -= 1;
    ck_assert(!check(until, &limits, &st));
}
END_TEST

START_TEST(test_benchmark__kept_pictures_are_bounded)
{
    /* One picture is kept for each seed; both thread counts give the same one. */
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    limits.pixels_per_view = 3 * 800 * 600;
    if (!check(many_seeds(3), &limits, &st))
        ck_abort_msg("%s", st.msg);
    ck_assert(!check(many_seeds(4), &limits, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_ptr_nonnull(strstr(st.msg, "1920000 pixels together, at most 1440000"));
}
END_TEST

PEN_SUITE("benchmark", test_benchmark__errors_name_their_place,
          test_benchmark__all_errors_are_collected,
          test_benchmark__defaults_are_one_row_three_repeats_one_warmup,
          test_benchmark__interval_and_budget_imply_each_other,
          test_benchmark__members_of_a_spec_read_back_as_the_spec,
          test_benchmark__rows_follow_the_order_of_the_document,
          test_benchmark__baseline_is_the_first_row_that_matches, test_benchmark__rows_are_capped,
          test_benchmark__work_of_all_runs_together_is_bounded,
          test_benchmark__kept_pictures_are_bounded)
