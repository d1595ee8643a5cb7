/* SPDX-License-Identifier: MIT */
/* The report of a benchmark as a page. */
#include "study/internal/page.h"
#include "study/internal/report_formats.h"

void pen_bench_report_write_html(const json_t *report, struct pen_buf *out)
{
    pen_page_begin("Benchmark", pen_bench_report_string(report, "scene"), out);
    pen_page_paragraph(report, "soft", pen_bench_write_method, out);
    pen_page_paragraph(report, "soft", pen_bench_write_noise, out);
    pen_buf_puts(out, "<figure>");
    pen_bench_chart_write(report, out);
    pen_buf_puts(out, "<figcaption>Bar: median. Whisker: least to largest. Grey: the row that "
                      "speed-ups refer to.</figcaption></figure>\n");
    pen_bench_scaling_write(report, out);
    pen_page_table(report, pen_bench_time_columns, "Times, tests and pictures", out);
    pen_buf_puts(out, "<h2>Rays and trees</h2>\n");
    pen_page_table(report, pen_bench_ray_columns, "Rays by kind, and the accelerator", out);
    pen_page_list(json_object_get(report, "notes"), "Notes", out);
    pen_buf_puts(out, "<h2>Machine</h2>\n");
    pen_page_paragraph(report, "", pen_bench_write_host, out);
    pen_page_settings(json_object_get(report, "render"), "Settings of all rows", out);
    pen_page_end(out);
}
