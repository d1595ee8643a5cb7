/* SPDX-License-Identifier: MIT */
#include "report/values.h"

#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const json_t *pen_report_member(const json_t *object, const char *path)
{
    while (object && *path) {
        const size_t length = strcspn(path, ".");
        object = json_is_array(object) && isdigit((unsigned char)*path)
                     ? json_array_get(object, (size_t)atoi(path))
                     : json_object_getn(object, path, length);
        path += length + (path[length] == '.');
    }
    return object;
}

double pen_report_number(const json_t *object, const char *path)
{
    return json_number_value(pen_report_member(object, path));
}

bool pen_report_has_number(const json_t *object, const char *path)
{
    return json_is_number(pen_report_member(object, path));
}

int pen_report_whole(const json_t *object, const char *path)
{
    const double number = pen_report_number(object, path);
    return number >= 0 && number <= INT_MAX ? (int)number : -1;
}

const char *pen_report_string(const json_t *object, const char *path)
{
    const char *text = json_string_value(pen_report_member(object, path));
    return text ? text : "";
}

size_t pen_report_row_count(const json_t *report)
{
    return json_array_size(json_object_get(report, "rows"));
}

const json_t *pen_report_row(const json_t *report, size_t row)
{
    return json_array_get(json_object_get(report, "rows"), row);
}

void pen_write_value(const json_t *value, struct pen_buf *out)
{
    if (json_is_string(value)) {
        pen_buf_puts(out, json_string_value(value));
        return;
    }
    char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(15));
    pen_buf_puts(out, text ? text : "");
    free(text);
}

/* Writes digits with a space between groups of three, counted from the end. A number of four digits
 * has no space. */
static void write_grouped(const char *digits, struct pen_buf *out)
{
    const size_t length = strlen(digits);
    for (size_t i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0 && length > 4)
            pen_buf_puts(out, " ");
        pen_buf_add(out, &digits[i], 1);
    }
}

void pen_write_count(double value, struct pen_buf *out)
{
    char text[64];
    if (!(value < 1e15 && value > -1e15)) {
        pen_buf_printf(out, "%g", value);
        return;
    }
    snprintf(text, sizeof text, "%.0f", value < 0 ? -value : value);
    pen_buf_puts(out, value < 0 ? "-" : "");
    write_grouped(text, out);
}

void pen_write_number(double value, struct pen_buf *out)
{
    const int digits = value == 0 ? 0 : value < 1 ? 3 : value < 10 ? 2 : value < 100 ? 1 : 0;
    if (digits > 0 && value > -1e15)
        pen_buf_printf(out, "%.*f", digits, value);
    else
        pen_write_count(value, out);
}

/* Writes the number of threads that worked on a row, and the setting if it differs: "2", "all 2",
 * "2 of 8". */
static void write_threads(const json_t *row, struct pen_buf *out)
{
    const int used = pen_report_whole(row, "threads"),
              requested = pen_report_whole(row, "settings.threads");
    if (requested == used || !pen_report_has_number(row, "threads"))
        pen_buf_printf(out, "%d", requested);
    else if (requested == 0)
        pen_buf_printf(out, "all %d", used);
    else
        pen_buf_printf(out, "%d of %d", used, requested);
}

/* Whether a setting has no effect beside the others: a target error of 0, or a number of samples if
 * there is a target error. */
static bool is_silent(const json_t *settings, const char *key, const json_t *value)
{
    static const char *const samples[] = {"samples_per_pixel", "lens_samples", "light_samples",
                                          "blur_samples"};
    if (strcmp(key, "target_error") == 0)
        return json_number_value(value) == 0;
    for (int i = 0; i < 4; i++)
        if (strcmp(key, samples[i]) == 0)
            return pen_report_number(settings, "target_error") > 0;
    return false;
}

/* Writes settings. `row` is the row that they belong to; NULL: no row. */
static void write_settings(const json_t *settings, const json_t *row, struct pen_buf *out)
{
    const char *key, *separator = "";
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)settings, key, value)
    {
        if (is_silent(settings, key, value))
            continue;
        pen_buf_printf(out, "%s%s ", separator, key);
        if (row && strcmp(key, "threads") == 0)
            write_threads(row, out);
        else
            pen_write_value(value, out);
        separator = ", ";
    }
}

void pen_write_settings(const json_t *settings, struct pen_buf *out)
{
    write_settings(settings, NULL, out);
}

void pen_write_row_name(const json_t *row, struct pen_buf *out)
{
    const size_t before = out->bytes;
    write_settings(json_object_get(row, "settings"), row, out);
    if (out->bytes == before)
        pen_buf_puts(out, "the scene's settings");
}

void pen_write_ratio(const json_t *ratio, struct pen_buf *out)
{
    if (!pen_report_has_number(ratio, "median"))
        return;
    pen_buf_printf(out, "%.3f", pen_report_number(ratio, "median"));
    if (pen_report_has_number(ratio, "low") && pen_report_has_number(ratio, "high"))
        pen_buf_printf(out, " (%.3f\xE2\x80\x93%.3f)", pen_report_number(ratio, "low"),
                       pen_report_number(ratio, "high"));
}

/* The plural ending of a noun: "s" unless count is 1. */
static const char *plural(int count)
{
    return count == 1 ? "" : "s";
}

void pen_write_host(const json_t *report, struct pen_buf *out)
{
    static const char *const parts[][2] = {{"kernel ", "host.kernel"},
                                           {"microcode ", "host.microcode"},
                                           {"governor ", "host.governor"},
                                           {"", "host.compiler"},
                                           {"build ", "host.build"}};
    const int cores = pen_report_whole(report, "host.cores"),
              threads = pen_report_whole(report, "pool_threads");
    const char *name = pen_report_string(report, "host.name");
    pen_buf_printf(out, "%s%s%s, %s, %d core%s", name, *name ? ": " : "",
                   pen_report_string(report, "host.cpu"), pen_report_string(report, "host.isa"),
                   cores, plural(cores));
    if (pen_report_has_number(report, "pool_threads"))
        pen_buf_printf(out, ", %d thread%s in the pool", threads, plural(threads));
    pen_buf_printf(out, ", Penumbra %s", pen_report_string(report, "host.version"));
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        if (*pen_report_string(report, parts[i][1]))
            pen_buf_printf(out, ", %s%s", parts[i][0], pen_report_string(report, parts[i][1]));
    if (pen_report_has_number(report, "calibration.median_ms"))
        pen_buf_printf(out, ", calibration %.3g ms",
                       pen_report_number(report, "calibration.median_ms"));
    if (pen_report_has_number(report, "load_average.before"))
        pen_buf_printf(out, "; load average %.2f before",
                       pen_report_number(report, "load_average.before"));
    if (pen_report_has_number(report, "load_average.after"))
        pen_buf_printf(out, ", %.2f after", pen_report_number(report, "load_average.after"));
    pen_buf_puts(out, "\n");
}

bool pen_write_spoiled(const json_t *report, const char *withheld, struct pen_buf *out)
{
    const double runs = pen_report_number(report, "timing.runs"),
                 spoiled = pen_report_number(report, "timing.spoiled");
    if (!(spoiled > 0))
        return false;
    pen_buf_printf(out,
                   "%.0f of %.0f runs are spoiled: other programs used the processors, of which "
                   "the runs had %.0f %% (mean). %s",
                   spoiled, runs, 100 * pen_report_number(report, "timing.cpu_share"),
                   2 * spoiled > runs ? withheld : "The times of these runs are left out.");
    return true;
}

void pen_write_list(const json_t *list, const char *begin, struct pen_buf *out)
{
    size_t i;
    json_t *item;
    json_array_foreach(list, i, item)
    {
        const char *text = json_string_value(item);
        pen_buf_printf(out, "%s%s\n", begin, text ? text : "");
    }
}

void pen_write_shared(const json_t *report, struct pen_buf *out)
{
    pen_buf_puts(out, "Settings of all rows: ");
    pen_write_settings(json_object_get(report, "render"), out);
    pen_buf_puts(out, "\n");
}
