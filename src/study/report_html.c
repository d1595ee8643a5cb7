/* SPDX-License-Identifier: MIT */
/* A report as one page of HTML without scripts or references to other files. Its colours are light
 * or dark as the reader's browser prefers. */
#include "study/internal/html.h"
#include "study/internal/report_formats.h"
#include "study/internal/table.h"

static const char style[] =
    ":root{color-scheme:light dark;--ink:#1b1f24;--soft:#5a6370;--line:#d6dbe1;--paper:#fff;"
    "--bar:#3573b9;--base:#8a94a3;--mark:#1b1f24}"
    "@media(prefers-color-scheme:dark){:root{--ink:#e7eaee;--soft:#a3adb9;--line:#39424d;"
    "--paper:#14181d;--bar:#5b9ae0;--base:#77818f;--mark:#f2f4f6}}"
    "body{margin:0 auto;padding:1.5rem;max-width:78rem;color:var(--ink);background:var(--paper);"
    "font:16px/1.5 system-ui,sans-serif}"
    "h1{font-size:1.6rem;margin:0 0 .3rem}h2{font-size:1.15rem;margin:2rem 0 .5rem}"
    "p{margin:.4rem 0}.soft{color:var(--soft)}"
    "figure{margin:1.5rem "
    "0;overflow-x:auto}svg{width:100%;min-width:40rem;max-width:62rem;height:auto;"
    "font:14px system-ui,sans-serif}"
    "svg text{fill:var(--ink)}svg .tick{fill:var(--soft);font-size:12px}"
    "svg .figure{font-variant-numeric:tabular-nums}"
    "svg .grid{stroke:var(--line)}svg .bar{fill:var(--bar)}svg .base{fill:var(--base)}"
    ".small "
    "svg{min-width:0;max-width:36rem}svg.key{width:.8em;min-width:0;height:.8em}.ideal{stroke:var(-"
    "-soft);stroke-dasharray:4 4;"
    "fill:none}.curve{fill:none;stroke-width:2}.c0{--c:var(--bar)}.c1{--c:#c2620e}.c2{--c:#2f8f4e}"
    ".c3{--c:#9a4fc0}.c4{--c:#b8324f}.c5{--c:#7a7a1f}.curve{stroke:var(--c)}circle{fill:var(--c)}"
    "svg .whisker{stroke:var(--mark);stroke-width:1.5;fill:none}"
    ".wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums;"
    "font-size:.88rem}figcaption{color:var(--soft);font-size:.88rem}"
    "th,td{padding:.25rem .55rem;border-bottom:1px solid var(--line);text-align:right;"
    "white-space:nowrap}"
    "th{font-weight:600;color:var(--soft)}.w{text-align:left}"
    "caption{text-align:left;color:var(--soft);padding-bottom:.3rem}";

/* A paragraph with the text that `write` appends. */
static void write_paragraph(const json_t *report, const char *class,
                            void (*write)(const json_t *report, struct pen_buf *out),
                            struct pen_buf *out)
{
    struct pen_buf text = {0};
    write(report, &text);
    pen_buf_printf(out, "<p class=\"%s\">", class);
    pen_html_escape_buf(&text, out);
    pen_buf_puts(out, "</p>\n");
}

static void write_cells(const struct pen_bench_table *table, size_t row, struct pen_buf *out)
{
    pen_buf_puts(out, "<tr>");
    for (size_t column = 0; column < table->columns; column++) {
        const char *tag = row == 0 || column == 0 ? "th" : "td";
        pen_buf_printf(out, "<%s%s%s>", tag, table->is_text[column] ? " class=\"w\"" : "",
                       row == 0      ? " scope=\"col\""
                       : column == 0 ? " scope=\"row\""
                                     : "");
        pen_html_escape(pen_bench_table_cell(table, row, column), out);
        pen_buf_printf(out, "</%s>", tag);
    }
    pen_buf_puts(out, "</tr>\n");
}

static void write_table(const json_t *report, const struct pen_bench_column *columns,
                        const char *caption, struct pen_buf *out)
{
    struct pen_bench_table table;
    bool ok = pen_bench_table_init(report, columns, &table);
    pen_buf_printf(out,
                   "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"%s\"><table>"
                   "<caption>%s</caption>\n<thead>",
                   caption, caption);
    for (size_t row = 0; ok && row < table.rows; row++) {
        write_cells(&table, row, out);
        if (row == 0)
            pen_buf_puts(out, "</thead>\n<tbody>");
    }
    pen_buf_puts(out, "</tbody></table></div>\n");
    pen_bench_table_release(&table);
    out->failed |= !ok;
}

static void write_notes(const json_t *report, struct pen_buf *out)
{
    const json_t *notes = json_object_get(report, "notes");
    size_t i;
    json_t *note;
    if (json_array_size(notes) == 0)
        return;
    pen_buf_puts(out, "<h2>Notes</h2>\n<ul>");
    json_array_foreach(notes, i, note)
    {
        pen_buf_puts(out, "<li>");
        pen_html_escape(json_string_value(note) ? json_string_value(note) : "", out);
        pen_buf_puts(out, "</li>");
    }
    pen_buf_puts(out, "</ul>\n");
}

/* The settings that all rows share. */
static void write_settings(const json_t *report, struct pen_buf *out)
{
    const char *key, *separator = "";
    json_t *value;
    struct pen_buf text = {0};
    json_object_foreach((json_t *)(uintptr_t)json_object_get(report, "render"), key, value)
    {
        pen_buf_printf(&text, "%s%s ", separator, key);
        pen_bench_write_value(value, &text);
        separator = ", ";
    }
    pen_buf_puts(out, "<h2>Settings of all rows</h2>\n<p>");
    pen_html_escape_buf(&text, out);
    pen_buf_puts(out, "</p>\n");
}

void pen_bench_page_begin(const char *title, const char *of, struct pen_buf *out)
{
    pen_buf_puts(out, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    pen_buf_printf(out, "<title>%s: ", title);
    pen_html_escape(of, out);
    pen_buf_printf(out, "</title>\n<style>%s</style>\n</head>\n<body>\n<h1>%s: ", style, title);
    pen_html_escape(of, out);
    pen_buf_puts(out, "</h1>\n");
}

void pen_bench_report_write_html(const json_t *report, struct pen_buf *out)
{
    pen_bench_page_begin("Benchmark", pen_bench_report_string(report, "scene"), out);
    write_paragraph(report, "soft", pen_bench_write_method, out);
    write_paragraph(report, "soft", pen_bench_write_noise, out);
    pen_buf_puts(out, "<figure>");
    pen_bench_chart_write(report, out);
    pen_buf_puts(out, "<figcaption>Bar: median. Whisker: least to largest. Grey: the row that "
                      "speed-ups refer to.</figcaption></figure>\n");
    pen_bench_scaling_write(report, out);
    write_table(report, pen_bench_time_columns, "Times, tests and pictures", out);
    pen_buf_puts(out, "<h2>Rays and trees</h2>\n");
    write_table(report, pen_bench_ray_columns, "Rays by kind, and the accelerator", out);
    write_notes(report, out);
    pen_buf_puts(out, "<h2>Machine</h2>\n");
    write_paragraph(report, "", pen_bench_write_host, out);
    write_settings(report, out);
    pen_buf_puts(out, "</body>\n</html>\n");
}
