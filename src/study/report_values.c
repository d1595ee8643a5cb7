/* SPDX-License-Identifier: MIT */
/* The accessors first, then the texts, then the columns of the two tables. */
#include "study/internal/report_values.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const json_t *pen_bench_report_member(const json_t *object, const char *path)
{
    while (object && *path) {
        size_t length = strcspn(path, ".");
        object = json_object_getn(object, path, length);
        path += length + (path[length] == '.');
    }
    return object;
}

double pen_bench_report_number(const json_t *object, const char *path)
{
    return json_number_value(pen_bench_report_member(object, path));
}

/* -1 if the member is no number from 0 to INT_MAX. */
static int whole_number(const json_t *object, const char *path)
{
    double number = pen_bench_report_number(object, path);
    return number >= 0 && number <= INT_MAX ? (int)number : -1;
}

static bool is_number(const json_t *object, const char *path)
{
    return json_is_number(pen_bench_report_member(object, path));
}

const char *pen_bench_report_string(const json_t *object, const char *path)
{
    const char *text = json_string_value(pen_bench_report_member(object, path));
    return text ? text : "";
}

size_t pen_bench_report_row_count(const json_t *report)
{
    return json_array_size(json_object_get(report, "rows"));
}

const json_t *pen_bench_report_row(const json_t *report, size_t row)
{
    return json_array_get(json_object_get(report, "rows"), row);
}

void pen_bench_write_value(const json_t *value, struct pen_buf *out)
{
    if (json_is_string(value)) {
        pen_buf_puts(out, json_string_value(value));
        return;
    }
    char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(15));
    pen_buf_puts(out, text ? text : "");
    free(text);
}

/* Digits with a separator between groups of three, counted from the end. Four digits stay together.
 */
static void write_grouped(const char *digits, const char *separator, struct pen_buf *out)
{
    size_t length = strlen(digits);
    for (size_t i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0 && length > 4)
            pen_buf_puts(out, separator);
        pen_buf_add(out, &digits[i], 1);
    }
}

void pen_bench_write_number(double value, const char *separator, struct pen_buf *out)
{
    char text[64];
    int digits = value == 0 ? 0 : value < 1 ? 3 : value < 10 ? 2 : value < 100 ? 1 : 0;
    snprintf(text, sizeof text, "%.*f", digits, value);
    if (digits > 0 || !(value < 1e15))
        pen_buf_puts(out, text);
    else
        write_grouped(text, separator, out);
}

void pen_bench_write_threads(const json_t *row, struct pen_buf *out)
{
    const json_t *setting = pen_bench_report_member(row, "settings.threads");
    int used = whole_number(row, "threads"), requested = whole_number(row, "settings.threads");
    if (!setting || requested == used)
        pen_buf_printf(out, "%d", used);
    else if (requested == 0)
        pen_buf_printf(out, "all %d", used);
    else
        pen_buf_printf(out, "%d of %d", used, requested);
}

void pen_bench_write_row_name(const json_t *row, struct pen_buf *out)
{
    const char *key, *separator = "";
    json_t *value;
    size_t before = out->bytes;
    json_object_foreach((json_t *)(uintptr_t)json_object_get(row, "settings"), key, value)
    {
        pen_buf_puts(out, separator);
        separator = ", ";
        if (strcmp(key, "threads") == 0) {
            pen_bench_write_threads(row, out);
            pen_buf_puts(out,
                         pen_bench_report_number(row, "threads") == 1 ? " thread" : " threads");
            continue;
        }
        if (!json_is_string(value))
            pen_buf_printf(out, "%s ", key);
        pen_bench_write_value(value, out);
    }
    if (out->bytes == before)
        pen_buf_puts(out, "the scene's settings");
}

static void write_picture(const json_t *row, struct pen_buf *out)
{
    int with = whole_number(row, "compared_with");
    if (with == whole_number(row, "row"))
        pen_buf_puts(out, "reference");
    else if (json_is_true(pen_bench_report_member(row, "identical")))
        pen_buf_printf(out, "identical to row %d", with);
    else
        pen_buf_printf(out, "max %.3g, rmse %.3g from row %d",
                       pen_bench_report_number(row, "max_difference"),
                       pen_bench_report_number(row, "rmse"), with);
}

void pen_bench_write_ratio(const json_t *ratio, struct pen_buf *out)
{
    if (!is_number(ratio, "median"))
        return;
    pen_buf_printf(out, "%.3f", pen_bench_report_number(ratio, "median"));
    if (is_number(ratio, "low") && is_number(ratio, "high"))
        pen_buf_printf(out, " (%.3f\xE2\x80\x93%.3f)", pen_bench_report_number(ratio, "low"),
                       pen_bench_report_number(ratio, "high"));
}

void pen_bench_write_method(const json_t *report, struct pen_buf *out)
{
    int repeats = whole_number(report, "repeats");
    int warmup = whole_number(report, "warmup");
    pen_buf_printf(out,
                   "Milliseconds to build the tree and render%s, median of %d run%s of each row, "
                   "interleaved in a random order (least and largest beside it)",
                   json_array_size(json_object_get(report, "views")) > 1 ? " all views" : "",
                   repeats, repeats == 1 ? "" : "s");
    if (warmup > 0)
        pen_buf_printf(out, ", after %d that %s not counted", warmup, warmup == 1 ? "is" : "are");
    pen_buf_puts(out, ". Time ratio: a row's time over that of the baseline, median of the pairs "
                      "of one repeat, with its 95 % interval");
    if (is_number(report, "least_effect"))
        pen_buf_printf(out, "; what differs by less than %g %% counts as the same",
                       pen_bench_report_number(report, "least_effect") * 100);
    pen_buf_puts(out, ".");
}

/* Why the repeats ended, if they were to go on until the intervals are narrow. */
static void write_end(const json_t *report, struct pen_buf *out)
{
    const char *end = pen_bench_report_string(report, "ended_by");
    if (!is_number(report, "interval"))
        return;
    if (strcmp(end, "budget") == 0)
        pen_buf_printf(out, " The budget of %g s ended before all intervals were",
                       pen_bench_report_number(report, "budget_seconds"));
    else
        pen_buf_printf(out, " %s intervals %s",
                       strcmp(end, "interval") == 0 ? "All" : "After the most repeats not all",
                       strcmp(end, "interval") == 0 ? "are" : "were");
    pen_buf_printf(out, " as narrow as %g.", pen_bench_report_number(report, "interval"));
}

void pen_bench_write_noise(const json_t *report, struct pen_buf *out)
{
    const json_t *noise = json_object_get(report, "noise");
    if (is_number(noise, "median")) {
        pen_buf_puts(out, "Noise floor: the baseline against itself ");
        pen_bench_write_ratio(noise, out);
        if (is_number(noise, "half_width"))
            pen_buf_printf(out, ", that is \xC2\xB1%.2g %%",
                           pen_bench_report_number(noise, "half_width") * 100);
        pen_buf_puts(out, ".");
    } else {
        pen_buf_puts(out, "Noise floor: not measured, which takes 10 repeats or an interval.");
    }
    write_end(report, out);
}

/* Appends ", NAMEvalue" if the report has such a text. */
static void write_part(const json_t *report, const char *name, const char *path,
                       struct pen_buf *out)
{
    const char *text = pen_bench_report_string(report, path);
    if (*text)
        pen_buf_printf(out, ", %s%s", name, text);
}

void pen_bench_write_host(const json_t *report, struct pen_buf *out)
{
    int cores = whole_number(report, "host.cores"), threads = whole_number(report, "pool_threads");
    const char *name = pen_bench_report_string(report, "host.name");
    pen_buf_printf(out, "%s%s%s, %s, %d core%s, %d thread%s in the pool, Penumbra %s", name,
                   *name ? ": " : "", pen_bench_report_string(report, "host.cpu"),
                   pen_bench_report_string(report, "host.isa"), cores, cores == 1 ? "" : "s",
                   threads, threads == 1 ? "" : "s",
                   pen_bench_report_string(report, "host.version"));
    write_part(report, "kernel ", "host.kernel", out);
    write_part(report, "microcode ", "host.microcode", out);
    write_part(report, "governor ", "host.governor", out);
    write_part(report, "", "host.compiler", out);
    write_part(report, "build ", "host.build", out);
    if (is_number(report, "calibration.median_ms"))
        pen_buf_printf(out, ", calibration %.3g ms",
                       pen_bench_report_number(report, "calibration.median_ms"));
    if (is_number(report, "load_average.before"))
        pen_buf_printf(out, "; load average %.2f before",
                       pen_bench_report_number(report, "load_average.before"));
    if (is_number(report, "load_average.after"))
        pen_buf_printf(out, ", %.2f after", pen_bench_report_number(report, "load_average.after"));
}

static const char separator[] = " ";

static void write_number(const json_t *row, const char *path, struct pen_buf *out)
{
    if (is_number(row, path))
        pen_bench_write_number(pen_bench_report_number(row, path), separator, out);
}

static void write_range(const json_t *row, struct pen_buf *out)
{
    write_number(row, "min_ms", out);
    pen_buf_puts(out, "\xE2\x80\x93");
    write_number(row, "max_ms", out);
}

void pen_bench_write_speedup(const json_t *row, struct pen_buf *out)
{
    double times = pen_bench_report_number(row, "speedup");
    pen_buf_printf(out, "%.*f\xC3\x97", times < 0.1 ? 3 : times < 100 ? 2 : 0, times);
}

static void write_row_ratio(const json_t *row, struct pen_buf *out)
{
    pen_bench_write_ratio(json_object_get(row, "ratio"), out);
}

static void write_verdict(const json_t *row, struct pen_buf *out)
{
    pen_buf_puts(out, pen_bench_report_string(row, "verdict"));
}

static void write_hash(const json_t *row, struct pen_buf *out)
{
    pen_buf_puts(out, pen_bench_report_string(row, "picture_hash"));
}

static void write_count(const json_t *row, const char *path, struct pen_buf *out)
{
    char text[32];
    if (!is_number(row, path))
        return;
    snprintf(text, sizeof text, "%.0f", pen_bench_report_number(row, path));
    write_grouped(text, separator, out);
}

void pen_bench_column_write(const struct pen_bench_column *column, const json_t *row,
                            struct pen_buf *out)
{
    if (column->write)
        column->write(row, out);
    else if (column->count)
        write_count(row, column->count, out);
    else
        write_number(row, column->number, out);
}

const struct pen_bench_column pen_bench_time_columns[] = {
    {"median ms", .number = "median_ms"},
    {"range", .write = write_range},
    {"speed-up", .write = pen_bench_write_speedup},
    {"time ratio", .write = write_row_ratio},
    {"verdict", .write = write_verdict, .words = true},
    {"Mray/s", .number = "mrays_per_second"},
    {"boxes/ray", .number = "accelerator.box_tests_per_ray"},
    {"primitives/ray", .number = "accelerator.primitive_tests_per_ray"},
    {"build ms", .number = "build_ms"},
    {"cpu ms", .number = "cpu_ms"},
    {"picture", .write = write_picture, .words = true},
    {"picture hash", .write = write_hash, .words = true},
    {0}};

const struct pen_bench_column pen_bench_ray_columns[] = {
    {"primary rays", .count = "rays.primary"},    {"shadow", .count = "rays.shadow"},
    {"reflection", .count = "rays.reflection"},   {"transmission", .count = "rays.transmission"},
    {"all rays", .count = "rays.total"},          {"nodes", .count = "accelerator.nodes"},
    {"leaves", .count = "accelerator.leaves"},    {"depth", .count = "accelerator.depth"},
    {"tree bytes", .count = "accelerator.bytes"}, {0}};
