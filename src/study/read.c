/* SPDX-License-Identifier: MIT */
#include "study/internal/read.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const json_t *pen_study_at(const json_t *object, const char *path)
{
    while (object && *path) {
        size_t length = strcspn(path, ".");
        object = json_object_getn(object, path, length);
        path += length + (path[length] == '.');
    }
    return object;
}

double pen_study_number(const json_t *object, const char *path)
{
    return json_number_value(pen_study_at(object, path));
}

int pen_study_count(const json_t *object, const char *path)
{
    double number = pen_study_number(object, path);
    return number >= 0 && number <= INT_MAX ? (int)number : -1;
}

bool pen_study_has(const json_t *object, const char *path)
{
    return json_is_number(pen_study_at(object, path));
}

const char *pen_study_text(const json_t *object, const char *path)
{
    const char *text = json_string_value(pen_study_at(object, path));
    return text ? text : "";
}

size_t pen_study_row_count(const json_t *report)
{
    return json_array_size(json_object_get(report, "rows"));
}

const json_t *pen_study_row(const json_t *report, size_t row)
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

/* Digits with a gap before every third from the end. */
static void write_grouped(const char *digits, const char *gap, struct pen_buf *out)
{
    size_t length = strlen(digits);
    for (size_t i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0 && length > 4)
            pen_buf_puts(out, gap);
        pen_buf_add(out, &digits[i], 1);
    }
}

void pen_write_figure(double value, const char *gap, struct pen_buf *out)
{
    char text[64];
    int digits = value == 0 ? 0 : value < 1 ? 3 : value < 10 ? 2 : value < 100 ? 1 : 0;
    snprintf(text, sizeof text, "%.*f", digits, value);
    if (digits > 0 || !(value < 1e15))
        pen_buf_puts(out, text);
    else
        write_grouped(text, gap, out);
}

void pen_write_threads(const json_t *row, struct pen_buf *out)
{
    const json_t *asked = pen_study_at(row, "settings.threads");
    int worked = pen_study_count(row, "threads"), wanted = pen_study_count(row, "settings.threads");
    if (!asked || wanted == worked)
        pen_buf_printf(out, "%d", worked);
    else if (wanted == 0)
        pen_buf_printf(out, "all %d", worked);
    else
        pen_buf_printf(out, "%d of %d", worked, wanted);
}

void pen_write_row_name(const json_t *row, struct pen_buf *out)
{
    const char *key, *gap = "";
    json_t *value;
    size_t before = out->bytes;
    json_object_foreach((json_t *)(uintptr_t)json_object_get(row, "settings"), key, value)
    {
        pen_buf_puts(out, gap);
        gap = ", ";
        if (strcmp(key, "threads") == 0) {
            pen_write_threads(row, out);
            pen_buf_puts(out, pen_study_number(row, "threads") == 1 ? " thread" : " threads");
            continue;
        }
        if (!json_is_string(value))
            pen_buf_printf(out, "%s ", key);
        pen_write_value(value, out);
    }
    if (out->bytes == before)
        pen_buf_puts(out, "the scene's settings");
}

void pen_write_picture(const json_t *row, struct pen_buf *out)
{
    int with = pen_study_count(row, "compared_with");
    if (with == pen_study_count(row, "row"))
        pen_buf_puts(out, "reference");
    else if (json_is_true(pen_study_at(row, "identical")))
        pen_buf_printf(out, "identical to row %d", with);
    else
        pen_buf_printf(out, "max %.3g, rmse %.3g from row %d",
                       pen_study_number(row, "max_difference"), pen_study_number(row, "rmse"),
                       with);
}

void pen_write_method(const json_t *report, struct pen_buf *out)
{
    int repeats = pen_study_count(report, "repeats");
    int warmup = pen_study_count(report, "warmup");
    pen_buf_printf(out,
                   "Milliseconds to build the tree and render%s, median of %d interleaved run%s of "
                   "each row (least and largest beside it)",
                   json_array_size(json_object_get(report, "views")) > 1 ? " all views" : "",
                   repeats, repeats == 1 ? "" : "s");
    if (warmup > 0)
        pen_buf_printf(out, ", after %d that %s not counted", warmup, warmup == 1 ? "is" : "are");
    pen_buf_puts(out, ".");
}

void pen_write_host(const json_t *report, struct pen_buf *out)
{
    pen_buf_printf(out, "%s, %s, %d cores, %d threads in the pool, Penumbra %s",
                   pen_study_text(report, "host.cpu"), pen_study_text(report, "host.isa"),
                   pen_study_count(report, "host.cores"), pen_study_count(report, "pool_threads"),
                   pen_study_text(report, "host.version"));
    if (pen_study_has(report, "load_average.before"))
        pen_buf_printf(out, "; load average %.2f before",
                       pen_study_number(report, "load_average.before"));
    if (pen_study_has(report, "load_average.after"))
        pen_buf_printf(out, ", %.2f after", pen_study_number(report, "load_average.after"));
}

static const char gap[] = " ";

static void figure(const json_t *row, const char *path, struct pen_buf *out)
{
    if (pen_study_has(row, path))
        pen_write_figure(pen_study_number(row, path), gap, out);
}

static void write_median(const json_t *row, struct pen_buf *out)
{
    figure(row, "median_ms", out);
}

static void write_range(const json_t *row, struct pen_buf *out)
{
    figure(row, "min_ms", out);
    pen_buf_puts(out, "\xE2\x80\x93");
    figure(row, "max_ms", out);
}

static void write_speedup(const json_t *row, struct pen_buf *out)
{
    double times = pen_study_number(row, "speedup");
    pen_buf_printf(out, "%.*f\xC3\x97", times < 0.1 ? 3 : times < 100 ? 2 : 0, times);
}

static void write_rate(const json_t *row, struct pen_buf *out)
{
    figure(row, "mrays_per_second", out);
}

static void write_boxes(const json_t *row, struct pen_buf *out)
{
    figure(row, "accelerator.box_tests_per_ray", out);
}

static void write_primitives(const json_t *row, struct pen_buf *out)
{
    figure(row, "accelerator.primitive_tests_per_ray", out);
}

static void write_cpu(const json_t *row, struct pen_buf *out)
{
    figure(row, "cpu_ms", out);
}

static void write_build(const json_t *row, struct pen_buf *out)
{
    figure(row, "build_ms", out);
}

const struct pen_column pen_time_columns[] = {
    {"median ms", write_median},    {"range", write_range},
    {"speed-up", write_speedup},    {"Mray/s", write_rate},
    {"boxes/ray", write_boxes},     {"bodies/ray", write_primitives},
    {"build ms", write_build},      {"cpu ms", write_cpu},
    {"picture", pen_write_picture}, {0}};

static void count(const json_t *row, const char *path, struct pen_buf *out)
{
    char text[32];
    if (!pen_study_has(row, path))
        return;
    snprintf(text, sizeof text, "%.0f", pen_study_number(row, path));
    write_grouped(text, gap, out);
}

static void write_primary(const json_t *row, struct pen_buf *out)
{
    count(row, "rays.primary", out);
}

static void write_shadow(const json_t *row, struct pen_buf *out)
{
    count(row, "rays.shadow", out);
}

static void write_reflection(const json_t *row, struct pen_buf *out)
{
    count(row, "rays.reflection", out);
}

static void write_transmission(const json_t *row, struct pen_buf *out)
{
    count(row, "rays.transmission", out);
}

static void write_total(const json_t *row, struct pen_buf *out)
{
    count(row, "rays.total", out);
}

static void write_nodes(const json_t *row, struct pen_buf *out)
{
    count(row, "accelerator.nodes", out);
}

static void write_leaves(const json_t *row, struct pen_buf *out)
{
    count(row, "accelerator.leaves", out);
}

static void write_depth(const json_t *row, struct pen_buf *out)
{
    count(row, "accelerator.depth", out);
}

static void write_bytes(const json_t *row, struct pen_buf *out)
{
    count(row, "accelerator.bytes", out);
}

const struct pen_column pen_ray_columns[] = {
    {"primary rays", write_primary},  {"shadow", write_shadow},
    {"reflection", write_reflection}, {"transmission", write_transmission},
    {"all rays", write_total},        {"nodes", write_nodes},
    {"leaves", write_leaves},         {"depth", write_depth},
    {"tree bytes", write_bytes},      {0}};
