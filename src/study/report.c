/* SPDX-License-Identifier: MIT */
/* The table of formats, and the two short ones: JSON and CSV. */
#include "study/report.h"

#include <stdlib.h>
#include <string.h>

#include "study/internal/report_formats.h"
#include "study/internal/report_values.h"

const char *const pen_bench_report_formats[] = {"json", "csv", "md", "html", NULL};

void pen_report_write_json(const json_t *report, struct pen_buf *out)
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
static const struct pen_csv_column columns[] = {
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
    {0}};

static void write_csv(const json_t *report, struct pen_buf *out)
{
    pen_report_write_csv(report, columns, out);
}

static const struct {
    const char *name, *media_type;
    void (*write)(const json_t *report, struct pen_buf *out);
} formats[] = {{"json", "application/json", pen_report_write_json},
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
