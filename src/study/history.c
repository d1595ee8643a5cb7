/* SPDX-License-Identifier: MIT */
#include "study/history.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "io/json_build.h"
#include "report/values.h"
#include "study/internal/report_rows.h"
#include "study/verdict.h"

/* A row of the history in progress. */
struct series {
    json_t *settings;     /* all settings, from the first report */
    const json_t *report; /* the first */
    json_t *points;
};

struct maker {
    json_t **reports; /* in chronological order; borrowed */
    int count;
    double least_effect;
    int *host; /* by report: an index into `hosts` */
    json_t *hosts;
    struct series *series;
    int series_count;
};

static int by_time(const void *a, const void *b)
{
    const json_t *x = *(json_t *const *)a, *y = *(json_t *const *)b;
    return strcmp(pen_report_string(x, "began_at"), pen_report_string(y, "began_at"));
}

static bool is_host(const json_t *a, const json_t *b)
{
    for (int i = 0; pen_bench_host_members[i]; i++) {
        const json_t *x = json_object_get(a, pen_bench_host_members[i]);
        const json_t *y = json_object_get(b, pen_bench_host_members[i]);
        if (x != y && !json_equal(x, y))
            return false;
    }
    return true;
}

/* Gives each host of the reports a number. Returns false when out of memory. */
static bool number_hosts(struct maker *m)
{
    for (int i = 0; i < m->count; i++) {
        const json_t *host = json_object_get(m->reports[i], "host");
        const int known = (int)json_array_size(m->hosts);
        int h = 0;
        while (h < known && !is_host(host, json_array_get(m->hosts, (size_t)h)))
            h++;
        json_t *copy = h < known              ? NULL
                       : json_is_object(host) ? json_copy((json_t *)(uintptr_t)host)
                                              : json_object();
        if (h == known && json_array_append_new(m->hosts, copy) != 0)
            return false;
        m->host[i] = h;
    }
    return true;
}

static bool same_scene(const json_t *a, const json_t *b)
{
    const json_t *x = json_object_get(a, "primitives"), *y = json_object_get(b, "primitives");
    const json_t *v = json_object_get(a, "views"), *w = json_object_get(b, "views");
    return (x == y || json_equal(x, y)) && (v == w || json_equal(v, w));
}

/* The series that a row belongs to; made if there is none. NULL when out of memory. */
static struct series *series_of(struct maker *m, const json_t *report, const json_t *row)
{
    json_t *settings = pen_bench_all_settings(report, row);
    int s = 0;
    while (s < m->series_count && !(same_scene(m->series[s].report, report) &&
                                    pen_bench_settings_agree(m->series[s].settings, settings)))
        s++;
    if (s < m->series_count) {
        json_decref(settings);
        return &m->series[s];
    }
    struct series *grown = realloc(m->series, (size_t)(s + 1) * sizeof *grown);
    if (grown)
        m->series = grown;
    if (!grown || !settings) {
        json_decref(settings);
        return NULL;
    }
    grown[s] = (struct series){.settings = settings, .report = report, .points = json_array()};
    m->series_count++;
    return &grown[s];
}

static json_t *point_json(const struct maker *m, int number, const json_t *row)
{
    const struct pen_confidence times = pen_bench_row_times(row, 0.05);
    const double calibration = pen_report_number(m->reports[number], "calibration.median_ms");
    return json_pack("{s:i, s:f, s:o, s:o, s:o}", "report", number, "median_ms", times.median,
                     "low_ms", times.bounded ? json_real(times.low) : json_null(), "high_ms",
                     times.bounded ? json_real(times.high) : json_null(), "calibrated",
                     calibration > 0 ? json_real(times.median / calibration) : json_null());
}

/* Returns false when out of memory. */
static bool add_report(struct maker *m, int number)
{
    const json_t *report = m->reports[number];
    for (size_t i = 0; i < pen_report_row_count(report); i++) {
        const json_t *row = pen_report_row(report, i);
        struct series *series = series_of(m, report, row);
        if (!series || json_array_append_new(series->points, point_json(m, number, row)) != 0)
            return false;
    }
    return true;
}

/* The points of a series that come from one host: their medians and their numbers. Returns how many
 * there are. */
static int points_of_host(const struct maker *m, const json_t *points, int host, double *values,
                          int *numbers)
{
    size_t i;
    json_t *point;
    int count = 0;
    json_array_foreach(points, i, point)
    {
        const int report = (int)pen_report_number(point, "report");
        if (m->host[report] != host)
            continue;
        values[count] = pen_report_number(point, "median_ms");
        numbers[count++] = (int)i;
    }
    return count;
}

/* Scratch space for the points of one series. */
struct scratch {
    double *values;
    int *numbers, *at;
};

/* Appends the change points among the points of one host. */
static bool add_changes(const struct maker *m, const json_t *points, int host, struct scratch *s,
                        json_t *changes)
{
    const int count = points_of_host(m, points, host, s->values, s->numbers);
    const int found = pen_history_changes(s->values, count, m->least_effect, s->at);
    bool ok = found >= 0;
    double before = found > 0 ? pen_median(s->values, s->at[0]) : 0;
    for (int i = 0; ok && i < found; i++) {
        const int end = i + 1 < found ? s->at[i + 1] : count;
        const double after = pen_median(s->values + s->at[i], end - s->at[i]);
        ok = json_array_append_new(changes,
                                   json_pack("{s:i, s:f, s:f, s:f}", "point", s->numbers[s->at[i]],
                                             "before_ms", before, "after_ms", after, "ratio",
                                             before > 0 ? after / before : 0)) == 0;
        before = after;
    }
    return ok;
}

static json_t *changes_json(const struct maker *m, const json_t *points)
{
    const size_t count = json_array_size(points) + 1;
    struct scratch s = {.values = calloc(count, sizeof *s.values),
                        .numbers = calloc(count, sizeof *s.numbers),
                        .at = calloc(count, sizeof *s.at)};
    json_t *changes = json_array();
    bool ok = s.values && s.numbers && s.at && changes;
    for (int host = 0; ok && host < (int)json_array_size(m->hosts); host++)
        ok = add_changes(m, points, host, &s, changes);
    free(s.values);
    free(s.numbers);
    free(s.at);
    if (ok)
        return changes;
    json_decref(changes);
    return NULL;
}

static json_t *rows_json(const struct maker *m)
{
    json_t *rows = json_array();
    for (int s = 0; s < m->series_count; s++)
        json_array_append_new(rows, json_pack("{s:O, s:O, s:o}", "settings", m->series[s].settings,
                                              "points", m->series[s].points, "changes",
                                              changes_json(m, m->series[s].points)));
    return pen_json_all(rows, (size_t)m->series_count);
}

static json_t *reports_json(const struct maker *m)
{
    json_t *list = json_array();
    for (int i = 0; i < m->count; i++) {
        const json_t *r = m->reports[i];
        json_array_append_new(
            list, json_pack("{s:s, s:s, s:s, s:i}", "began_at", pen_report_string(r, "began_at"),
                            "version", pen_report_string(r, "host.version"), "build",
                            pen_report_string(r, "host.build"), "host", m->host[i]));
    }
    return pen_json_all(list, (size_t)m->count);
}

/* Removes the settings in which all rows are equal. */
static void keep_differences(struct maker *m)
{
    const char *key;
    json_t *value;
    void *next;
    json_t *shared = m->series_count > 0 ? json_copy(m->series[0].settings) : NULL;
    for (int s = 1; s < m->series_count; s++) {
        json_object_foreach_safe(shared, next, key, value)
        {
            const json_t *other = json_object_get(m->series[s].settings, key);
            if (!other || !json_equal(value, other))
                json_object_del(shared, key);
        }
    }
    for (int s = 0; s < m->series_count; s++) {
        json_object_foreach(shared, key, value)
        {
            json_object_del(m->series[s].settings, key);
        }
    }
    json_decref(shared);
}

static json_t *make(struct maker *m)
{
    bool ok = m->host && m->hosts && number_hosts(m);
    for (int i = 0; ok && i < m->count; i++)
        ok = add_report(m, i);
    if (!ok)
        return NULL;
    keep_differences(m);
    return json_pack("{s:s, s:s, s:f, s:O, s:o, s:o}", "kind", "history", "scene",
                     pen_report_string(m->reports[0], "scene"), "least_effect", m->least_effect,
                     "hosts", m->hosts, "reports", reports_json(m), "rows", rows_json(m));
}

static bool check(json_t *const *reports, int count, struct pen_status *st)
{
    if (count == 0)
        return pen_fail(st, PEN_INVALID, "there is no report of a benchmark");
    for (int i = 1; i < count; i++) {
        const char *first = pen_report_string(reports[0], "scene");
        const char *here = pen_report_string(reports[i], "scene");
        if (strcmp(first, here) != 0)
            return pen_fail(st, PEN_INVALID,
                            "there are reports of several scenes, such as \"%.80s\" and "
                            "\"%.80s\": name one",
                            first, here);
    }
    return true;
}

json_t *pen_history_new(json_t *const *reports, int count, double least_effect,
                        struct pen_status *st)
{
    struct maker m = {.count = count, .least_effect = least_effect};
    json_t *history = NULL;
    if (!check(reports, count, st))
        return NULL;
    m.reports = calloc((size_t)count, sizeof *m.reports);
    m.host = calloc((size_t)count, sizeof *m.host);
    m.hosts = json_array();
    if (m.reports) {
        memcpy(m.reports, reports, (size_t)count * sizeof *reports);
        qsort(m.reports, (size_t)count, sizeof *m.reports, by_time);
        history = make(&m);
    }
    for (int s = 0; s < m.series_count; s++) {
        json_decref(m.series[s].settings);
        json_decref(m.series[s].points);
    }
    free(m.series);
    free(m.reports);
    free(m.host);
    json_decref(m.hosts);
    if (!history)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a history of %d reports", count);
    return history;
}
