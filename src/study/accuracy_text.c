/* SPDX-License-Identifier: MIT */
/* The report of an accuracy study as text, CSV, Markdown and JSON. */
#include <string.h>

#include "study/accuracy.h"
#include "study/internal/accuracy_words.h"
#include "study/internal/report_formats.h"
#include "study/internal/table.h"

typedef void words_fn(const json_t *report, struct pen_buf *out);

/* The words as a line of plain text. */
static void write_line(const json_t *report, words_fn *words, struct pen_buf *out)
{
    struct pen_buf text = {0};
    words(report, &text);
    pen_bench_write_plain(text.data ? (const char *)text.data : "", out);
    pen_buf_puts(out, "\n");
    out->failed |= text.failed;
    pen_buf_release(&text);
}

static void write_text(const json_t *report, struct pen_buf *out)
{
    size_t i;
    json_t *member;
    const bool spoiled = pen_accuracy_is_spoiled(report);
    if (spoiled) {
        write_line(report, pen_accuracy_write_answer, out);
        pen_buf_puts(out, "\n");
    }
    pen_bench_write_text_table(report, pen_accuracy_columns, out);
    pen_buf_puts(out, "\n");
    if (!spoiled) {
        write_line(report, pen_accuracy_write_answer, out);
        pen_buf_puts(out, "\n");
    }
    json_array_foreach(json_object_get(report, "convergence"), i, member)
    {
        write_line(member, pen_accuracy_write_slope, out);
    }
    write_line(report, pen_accuracy_write_method, out);
    write_line(report, pen_accuracy_write_reference, out);
    write_line(report, pen_accuracy_write_forecast, out);
    write_line(report, pen_bench_write_host, out);
    json_array_foreach(json_object_get(report, "left_out"), i, member)
    {
        pen_buf_puts(out, "left out: ");
        pen_bench_write_plain(json_string_value(member) ? json_string_value(member) : "", out);
        pen_buf_puts(out, "\n");
    }
}

static void write_markdown(const json_t *report, struct pen_buf *out)
{
    size_t i;
    json_t *member;
    pen_buf_puts(out, "# Accuracy: ");
    pen_bench_write_markdown(pen_bench_report_string(report, "scene"), out);
    pen_buf_puts(out, "\n");
    pen_bench_write_markdown_paragraph(report, pen_accuracy_write_answer, out);
    pen_buf_puts(out, "\n");
    pen_bench_write_markdown_table(report, pen_accuracy_columns, out);
    json_array_foreach(json_object_get(report, "convergence"), i, member)
    {
        pen_bench_write_markdown_paragraph(member, pen_accuracy_write_slope, out);
    }
    pen_bench_write_markdown_paragraph(report, pen_accuracy_write_method, out);
    pen_bench_write_markdown_paragraph(report, pen_accuracy_write_reference, out);
    pen_bench_write_markdown_paragraph(report, pen_accuracy_write_forecast, out);
    pen_bench_write_markdown_paragraph(report, pen_bench_write_host, out);
    json_array_foreach(json_object_get(report, "left_out"), i, member)
    {
        pen_buf_puts(out, i ? "- left out: " : "\n- left out: ");
        pen_bench_write_markdown(json_string_value(member) ? json_string_value(member) : "", out);
        pen_buf_puts(out, "\n");
    }
}

static const struct pen_csv_column csv_columns[] = {{"runs", "runs"},
                                                    {"median_ms", "median_ms"},
                                                    {"min_ms", "min_ms"},
                                                    {"max_ms", "max_ms"},
                                                    {"rays_primary", "rays.primary"},
                                                    {"rays_shadow", "rays.shadow"},
                                                    {"rays_reflection", "rays.reflection"},
                                                    {"rays_transmission", "rays.transmission"},
                                                    {"rays_total", "rays.total"},
                                                    {"rmse", "rmse"},
                                                    {"relative_mse", "relative_mse"},
                                                    {"psnr", "psnr"},
                                                    {"ssim", "ssim"},
                                                    {"flip", "flip"},
                                                    {"max_error", "max_error"},
                                                    {"efficiency", "efficiency"},
                                                    {"pareto", "pareto"},
                                                    {"resolved", "resolved"},
                                                    {"rmse_below", "rmse_below"},
                                                    {0}};

bool pen_accuracy_write(const json_t *report, const char *format, struct pen_buf *out,
                        struct pen_status *st)
{
    if (strcmp(format, "json") == 0)
        pen_report_write_json(report, out);
    else if (strcmp(format, "csv") == 0)
        pen_report_write_csv(report, csv_columns, out);
    else if (strcmp(format, "md") == 0)
        write_markdown(report, out);
    else
        write_text(report, out);
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "out of memory for a report");
}
