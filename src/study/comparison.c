/* SPDX-License-Identifier: MIT */
#include "study/comparison.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "io/json_build.h"
#include "report/values.h"
#include "study/internal/report_rows.h"
#include "study/verdict.h"

/* The error probability of each of two medians, so that their quotient errs with 5 %. */
static const double alpha = 0.025;

bool pen_comparison_check(const json_t *report, struct pen_status *st)
{
    const char *kind = pen_report_string(report, "kind");
    if (!json_is_object(report) || !*kind)
        return pen_fail(st, PEN_INVALID,
                        "must be a report as JSON, an object with \"kind\": \"benchmark\" or "
                        "\"accuracy\"");
    if (strcmp(kind, "benchmark") != 0 && strcmp(kind, "accuracy") != 0)
        return pen_fail_at(st, PEN_INVALID, "/kind",
                           "must be \"benchmark\" or \"accuracy\": reports of no other kind can be "
                           "compared, found \"%.60s\"",
                           kind);
    return pen_report_row_count(report) > 0 ||
           pen_fail_at(st, PEN_INVALID, "/rows", "must have one row or more, found none");
}

/* The settings of a row; an empty object if it has none. */
static json_t *settings_of(const json_t *row)
{
    const json_t *settings = json_object_get(row, "settings");
    return json_is_object(settings) ? json_copy((json_t *)(uintptr_t)settings) : json_object();
}

/* The first row of a report that has these settings and is not taken; -1: none. */
static int find_row(const json_t *report, const json_t *settings, const bool *taken)
{
    for (size_t i = 0; i < pen_report_row_count(report); i++) {
        json_t *here = pen_bench_all_settings(report, pen_report_row(report, i));
        const bool found = !taken[i] && pen_bench_settings_agree(settings, here);
        json_decref(here);
        if (found)
            return (int)i;
    }
    return -1;
}

static json_t *host_differences(const json_t *before, const json_t *after)
{
    json_t *list = json_array();
    size_t count = 0;
    for (int i = 0; pen_bench_host_members[i]; i++) {
        const json_t *a =
            json_object_get(json_object_get(before, "host"), pen_bench_host_members[i]);
        const json_t *b =
            json_object_get(json_object_get(after, "host"), pen_bench_host_members[i]);
        if (json_equal(a, b) || (!a && !b))
            continue;
        json_array_append_new(list, json_string(pen_bench_host_members[i]));
        count++;
    }
    return pen_json_all(list, count);
}

static const char *const counters[] = {"rays.primary",      "rays.shadow", "rays.reflection",
                                       "rays.transmission", "tests.boxes", "tests.primitives"};

/* The counters that both rows have with different values. */
static json_t *counter_differences(const json_t *before, const json_t *after)
{
    json_t *list = json_array();
    size_t count = 0;
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++) {
        const json_t *a = pen_report_member(before, counters[i]);
        const json_t *b = pen_report_member(after, counters[i]);
        if (!json_is_integer(a) || !json_is_integer(b) || json_equal(a, b))
            continue;
        json_array_append_new(
            list, json_pack("{s:s, s:O, s:O}", "counter", counters[i], "before", a, "after", b));
        count++;
    }
    return pen_json_all(list, count);
}

/* "same", "different", "unknown". */
static const char *compare_pictures(const json_t *before, const json_t *after)
{
    const char *a = pen_report_string(before, "picture_hash");
    const char *b = pen_report_string(after, "picture_hash");
    if (!*a || !*b)
        return "unknown";
    return strcmp(a, b) == 0 ? "same" : "different";
}

static bool noise_differs(const json_t *report)
{
    const char *verdict = pen_report_string(report, "noise.verdict");
    return strcmp(verdict, "faster") == 0 || strcmp(verdict, "slower") == 0;
}

/* Two reports, and the two rows that are compared. */
struct pair {
    const json_t *before, *after;
    const json_t *row_before, *row_after;
    bool same_host;
};

/* The reason why a pair of rows has no verdict, independent of its times; "" if there is none. */
static const char *obstacle(const struct pair *pair)
{
    if (!pair->same_host)
        return "the reports are of different hosts";
    if (pen_report_number(pair->row_before, "threads") !=
        pen_report_number(pair->row_after, "threads"))
        return "the rows ran on different numbers of threads";
    if (noise_differs(pair->before) || noise_differs(pair->after))
        return "in one of the reports the baseline's twin differs from the baseline";
    return "";
}

static const char *why_undecided(const struct pen_confidence *ratio)
{
    if (ratio->count < PEN_PAIRS_MIN)
        return "one of the reports has fewer than 10 runs";
    return ratio->bounded ? "the interval is too wide" : "too many runs are spoiled";
}

static json_t *interval_json(const struct pen_confidence *ratio)
{
    return json_pack("{s:f, s:o, s:o}", "median", ratio->median, "low",
                     ratio->bounded ? json_real(ratio->low) : json_null(), "high",
                     ratio->bounded ? json_real(ratio->high) : json_null());
}

/* The factor by which the host of the later report is slower, from the calibrations; 0 if one is
 * missing. */
static double host_ratio(const struct pair *pair)
{
    const double before = pen_report_number(pair->before, "calibration.median_ms");
    const double after = pen_report_number(pair->after, "calibration.median_ms");
    return before > 0 && after > 0 ? after / before : 0;
}

/* The verdict on a pair. The times and the calibrated times must give the same verdict. If they do
 * not, the speed of the host changed between the reports, as on virtual machines by some percent.
 */
static enum pen_verdict judge(const struct pair *pair, const struct pen_confidence *ratio,
                              const char **reason)
{
    const double least = pen_report_number(pair->after, "least_effect");
    const double host = host_ratio(pair);
    const enum pen_verdict verdict = pen_verdict_of(ratio, least);
    struct pen_confidence calibrated = *ratio;
    *reason = verdict == PEN_VERDICT_UNDECIDED ? why_undecided(ratio) : "";
    if (!(host > 0) || verdict == PEN_VERDICT_UNDECIDED)
        return verdict;
    calibrated.low /= host;
    calibrated.high /= host;
    if (pen_verdict_of(&calibrated, least) == verdict)
        return verdict;
    *reason = "the calibrated ratio says otherwise: the host's own speed has changed";
    return PEN_VERDICT_UNDECIDED;
}

/* {rmse: [before, after], flip: […]} of rows of accuracy studies; else null. */
static json_t *errors_json(const struct pair *pair)
{
    static const char *const metrics[] = {"rmse", "flip"};
    json_t *errors = json_object();
    for (int i = 0; i < 2; i++) {
        const json_t *before = json_object_get(pair->row_before, metrics[i]),
                     *after = json_object_get(pair->row_after, metrics[i]);
        /* The rmse of a benchmark compares a row with another row. */
        if (pen_report_member(pair->row_before, "runs") && json_is_number(before) &&
            json_is_number(after))
            errors = pen_json_with(errors, metrics[i], json_pack("[O, O]", before, after));
    }
    if (json_object_size(errors) > 0)
        return errors;
    json_decref(errors);
    return json_null();
}

static json_t *compare_rows(const struct pair *pair)
{
    const struct pen_confidence before = pen_bench_row_times(pair->row_before, alpha),
                                after = pen_bench_row_times(pair->row_after, alpha);
    const struct pen_confidence ratio = pen_confidence_quotient(&after, &before);
    const char *picture = compare_pictures(pair->row_before, pair->row_after);
    const char *reason = obstacle(pair), *undecided;
    const double host = host_ratio(pair);
    enum pen_verdict verdict = judge(pair, &ratio, &undecided);
    if (*reason)
        verdict = PEN_VERDICT_UNDECIDED;
    else if (strcmp(picture, "different") == 0)
        verdict = PEN_VERDICT_DIFFERENT_PICTURE;
    else
        reason = undecided;
    return json_pack(
        "{s:o, s:o, s:f, s:f, s:o, s:o, s:s, s:s, s:s, s:o, s:o}", "settings",
        settings_of(pair->row_after), "threads",
        json_integer((json_int_t)pen_report_number(pair->row_after, "threads")), "before_ms",
        before.median, "after_ms", after.median, "ratio", interval_json(&ratio), "calibrated_ratio",
        host > 0 ? json_real(ratio.median / host) : json_null(), "verdict",
        pen_verdict_name(verdict), "reason", reason, "picture", picture, "differences",
        counter_differences(pair->row_before, pair->row_after), "errors", errors_json(pair));
}

static bool check_same_scene(const json_t *before, const json_t *after, struct pen_status *st)
{
    static const char *const members[] = {"scene", "primitives", "views", "view"};
    const char *kind = pen_report_string(before, "kind");
    if (strcmp(kind, pen_report_string(after, "kind")) != 0)
        return pen_fail(st, PEN_INVALID, "the reports are of different kinds: %.80s and %.80s",
                        kind, pen_report_string(after, "kind"));
    for (int i = 0; i < 4; i++) {
        struct pen_buf a = {0}, b = {0};
        const json_t *in_before = json_object_get(before, members[i]);
        const json_t *in_after = json_object_get(after, members[i]);
        if (in_before == in_after || json_equal(in_before, in_after))
            continue;
        pen_write_value(in_before, &a);
        pen_write_value(in_after, &b);
        pen_fail(st, PEN_INVALID, "the reports are of different scenes: %s is %.80s and %.80s",
                 members[i], a.data ? (char *)a.data : "", b.data ? (char *)b.data : "");
        pen_buf_release(&a);
        pen_buf_release(&b);
        return false;
    }
    return true;
}

static json_t *identity_json(const json_t *report)
{
    return json_pack("{s:s, s:s, s:s}", "began_at", pen_report_string(report, "began_at"),
                     "version", pen_report_string(report, "host.version"), "build",
                     pen_report_string(report, "host.build"));
}

/* Compares the rows that both reports have, and lists the rows that only one has. Returns false
 * when out of memory. */
static bool match_rows(struct pair *pair, bool *taken, json_t *rows, json_t *missing, json_t *added)
{
    bool ok = rows && missing && added;
    for (size_t i = 0; ok && i < pen_report_row_count(pair->before); i++) {
        pair->row_before = pen_report_row(pair->before, i);
        json_t *settings = pen_bench_all_settings(pair->before, pair->row_before);
        const int found = find_row(pair->after, settings, taken);
        json_decref(settings);
        if (found < 0) {
            ok = json_array_append_new(missing, settings_of(pair->row_before)) == 0;
            continue;
        }
        taken[found] = true;
        pair->row_after = pen_report_row(pair->after, (size_t)found);
        ok = json_array_append_new(rows, compare_rows(pair)) == 0;
    }
    for (size_t i = 0; ok && i < pen_report_row_count(pair->after); i++) {
        const json_t *row = pen_report_row(pair->after, i);
        if (!taken[i])
            ok = json_array_append_new(added, settings_of(row)) == 0;
    }
    return ok;
}

/* Numbers of rows that differ. */
struct totals {
    size_t pictures, unknown, counters;
    int slower;
};

static struct totals count_rows(const json_t *rows)
{
    struct totals totals = {0};
    size_t i;
    json_t *row;
    json_array_foreach(rows, i, row)
    {
        const char *picture = pen_report_string(row, "picture");
        totals.pictures += strcmp(picture, "different") == 0;
        totals.unknown += strcmp(picture, "unknown") == 0;
        totals.counters += json_array_size(json_object_get(row, "differences")) > 0;
        totals.slower += strcmp(pen_report_string(row, "verdict"), "slower") == 0;
    }
    return totals;
}

static json_t *comparison_json(const struct pair *pair, json_t *hosts, json_t *rows,
                               json_t *missing, json_t *added)
{
    const struct totals totals = count_rows(rows);
    return json_pack("{s:s, s:s, s:o, s:o, s:O, s:O, s:O, s:O, s:s, s:s, s:i}", "kind",
                     "comparison", "scene", pen_report_string(pair->after, "scene"), "before",
                     identity_json(pair->before), "after", identity_json(pair->after),
                     "host_differences", hosts, "rows", rows, "missing", missing, "added", added,
                     "counters", totals.counters > 0 ? "different" : "same", "pictures",
                     totals.pictures > 0                       ? "different"
                     : totals.unknown == json_array_size(rows) ? "unknown"
                                                               : "same",
                     "slower", totals.slower);
}

json_t *pen_comparison_new(const json_t *before, const json_t *after, struct pen_status *st)
{
    struct pair pair = {.before = before, .after = after};
    if (!check_same_scene(before, after, st))
        return NULL;
    json_t *rows = json_array(), *missing = json_array(), *added = json_array();
    json_t *hosts = host_differences(before, after), *out = NULL;
    bool *taken = calloc(pen_report_row_count(after) + 1, sizeof *taken);
    pair.same_host = json_array_size(hosts) == 0;
    const bool ok = hosts && taken && match_rows(&pair, taken, rows, missing, added);
    if (ok && json_array_size(rows) > 0)
        out = comparison_json(&pair, hosts, rows, missing, added);
    if (ok && json_array_size(rows) == 0)
        pen_fail(st, PEN_INVALID, "no row of the one report has the settings of one of the other");
    else if (!out)
        pen_fail(st, PEN_NO_MEMORY, "no memory to compare reports");
    free(taken);
    json_decref(rows);
    json_decref(missing);
    json_decref(added);
    json_decref(hosts);
    return out;
}

bool pen_comparison_judge(const json_t *comparison, bool time, struct pen_status *st)
{
    const int slower = (int)pen_report_number(comparison, "slower");
    if (strcmp(pen_report_string(comparison, "counters"), "different") == 0)
        return pen_fail(st, PEN_DIFFERENT, "the reports differ in what the runs counted");
    if (strcmp(pen_report_string(comparison, "pictures"), "different") == 0)
        return pen_fail(st, PEN_DIFFERENT, "the reports differ in their pictures");
    return !time || slower == 0 ||
           pen_fail(st, PEN_DIFFERENT, "%d row%s slower", slower, slower == 1 ? " is" : "s are");
}
