/* SPDX-License-Identifier: MIT */
/* The table of formats, and the two short ones: JSON and CSV. */
#include "study/report.h"

#include <stdlib.h>
#include <string.h>

#include "study/internal/report_formats.h"
#include "study/internal/report_values.h"

const char *const pen_bench_report_formats[] = {"json", "csv", "md", "html", NULL};

static void write_json(const json_t *report, struct pen_buf *out)
{
    char *text = json_dumps(report, JSON_ENCODE_ANY | JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    if (!text)
        out->failed = true;
    else
        pen_buf_puts(out, text);
    pen_buf_puts(out, "\n");
    free(text);
}

/* The columns of a CSV file after the row's number and its settings. */
static const struct {
    const char *title, *path;
} columns[] = {
    {"threads_worked", "threads"},
    {"median_ms", "median_ms"},
    {"min_ms", "min_ms"},
    {"max_ms", "max_ms"},
    {"speedup", "speedup"},
    {"build_ms", "build_ms"},
    {"render_ms", "render_ms"},
    {"cpu_ms", "cpu_ms"},
    {"rays_primary", "rays.primary"},
    {"rays_shadow", "rays.shadow"},
    {"rays_reflection", "rays.reflection"},
    {"rays_transmission", "rays.transmission"},
    {"rays_total", "rays.total"},
    {"mrays_per_second", "mrays_per_second"},
    {"box_tests_per_ray", "accelerator.box_tests_per_ray"},
    {"primitive_tests_per_ray", "accelerator.primitive_tests_per_ray"},
    {"nodes", "accelerator.nodes"},
    {"leaves", "accelerator.leaves"},
    {"depth", "accelerator.depth"},
    {"tree_bytes", "accelerator.bytes"},
    {"sah_cost", "accelerator.sah_cost"},
    {"tree_build_ms", "accelerator.build_ms"},
    {"kernel", "kernel"},
    {"compared_with", "compared_with"},
    {"identical", "identical"},
    {"max_difference", "max_difference"},
    {"rmse", "rmse"},
    {"ratio", "ratio.median"},
    {"ratio_low", "ratio.low"},
    {"ratio_high", "ratio.high"},
    {"pairs", "ratio.pairs"},
    {"spoiled_pairs", "ratio.spoiled"},
    {"verdict", "verdict"},
    {"cpu_share", "cpu_share"},
    {"steal_ms", "steal_ms"},
    {"box_tests", "tests.boxes"},
    {"primitive_tests", "tests.primitives"},
    {"picture_hash", "picture_hash"},
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0] };

/* One cell, in quotes where RFC 4180 requires them. */
static void write_cell(const char *text, struct pen_buf *out)
{
    if (!strpbrk(text, ",\"\r\n")) {
        pen_buf_puts(out, text);
        return;
    }
    pen_buf_puts(out, "\"");
    for (; *text; text++)
        pen_buf_printf(out, *text == '"' ? "\"\"" : "%c", *text);
    pen_buf_puts(out, "\"");
}

static void write_value_cell(const json_t *value, struct pen_buf *out)
{
    struct pen_buf text = {0};
    if (value && !json_is_null(value))
        pen_bench_write_value(value, &text);
    write_cell(text.data ? (const char *)text.data : "", out);
    out->failed |= text.failed;
    pen_buf_release(&text);
}

/* `keys` are the settings of the first row; all rows have the same keys. */
static void write_csv_row(const json_t *row, size_t number, const json_t *keys, struct pen_buf *out)
{
    const char *key;
    json_t *value;
    pen_buf_printf(out, "\n%zu", number);
    json_object_foreach((json_t *)(uintptr_t)keys, key, value)
    {
        pen_buf_puts(out, ",");
        write_value_cell(json_object_get(pen_bench_report_member(row, "settings"), key), out);
    }
    for (int i = 0; i < COLUMN_COUNT; i++) {
        pen_buf_puts(out, ",");
        write_value_cell(pen_bench_report_member(row, columns[i].path), out);
    }
}

static void write_csv(const json_t *report, struct pen_buf *out)
{
    const char *key;
    json_t *value;
    const json_t *keys = pen_bench_report_member(pen_bench_report_row(report, 0), "settings");
    pen_buf_puts(out, "row");
    json_object_foreach((json_t *)(uintptr_t)keys, key, value)
    {
        pen_buf_puts(out, ",");
        write_cell(key, out);
    }
    for (int i = 0; i < COLUMN_COUNT; i++)
        pen_buf_printf(out, ",%s", columns[i].title);
    for (size_t row = 0; row < pen_bench_report_row_count(report); row++)
        write_csv_row(pen_bench_report_row(report, row), row, keys, out);
    pen_buf_puts(out, "\n");
}

static const struct {
    const char *name, *media_type;
    void (*write)(const json_t *report, struct pen_buf *out);
} formats[] = {{"json", "application/json", write_json},
               {"csv", "text/csv; charset=utf-8", write_csv},
               {"md", "text/markdown; charset=utf-8", pen_bench_report_write_markdown},
               {"html", "text/html; charset=utf-8", pen_bench_report_write_html}};
enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };
_Static_assert(sizeof pen_bench_report_formats / sizeof pen_bench_report_formats[0] ==
                   FORMAT_COUNT + 1,
               "each format has a name in the public list and a row here");

static int find_format(const char *format)
{
    int i = 0;
    while (i < FORMAT_COUNT && strcmp(formats[i].name, format) != 0)
        i++;
    return i;
}

const char *pen_bench_report_media_type(const char *format)
{
    int i = find_format(format);
    return i < FORMAT_COUNT ? formats[i].media_type : "application/octet-stream";
}

bool pen_bench_report_write(const json_t *report, const char *format, struct pen_buf *out,
                            struct pen_status *st)
{
    int i = find_format(format);
    if (i == FORMAT_COUNT)
        return pen_fail(st, PEN_INTERNAL, "there is no report as %s", format);
    formats[i].write(report, out);
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
}
