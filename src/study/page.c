/* SPDX-License-Identifier: MIT */
#include "study/internal/page.h"

#include <stdlib.h>

#include "study/internal/html.h"
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
    "caption{text-align:left;color:var(--soft);padding-bottom:.3rem}"
    "section{border-top:1px solid var(--line);padding:1rem 0}section h2{margin:0}"
    "div.bar{background:var(--bar);height:.9rem;min-width:1px;margin:.3rem 0}"
    ".pair{display:flex;flex-wrap:wrap;gap:.8rem}.pair figure{margin:.4rem 0;max-width:100%}"
    "img{max-width:100%;height:auto;display:block}.answer{font-size:1.1rem;font-weight:600}"
    ".dot{fill:var(--base)}.front{fill:var(--bar)}.best{fill:none;stroke:var(--mark);stroke-width:"
    "1.5}.key{display:inline-block;width:.8em;height:.8em;background:var(--c)}"
    ".pair .small{flex:1 1 22rem}"
    ".crop img{width:18rem;image-rendering:pixelated}"
    ".choose label{display:inline-block;padding:.3rem .6rem;margin:.15rem;border:1px solid "
    "var(--line);border-radius:.3rem;cursor:pointer}.choose input{position:absolute;opacity:0}"
    ".choose input:checked+label{border-color:var(--bar);box-shadow:inset 0 0 0 1px var(--bar)}"
    ".choose input:focus-visible+label{outline:2px solid var(--mark)}"
    ".rows{display:flex;flex-wrap:wrap;gap:0 1.5rem}"
    "@media print{.choose input,.choose label{display:none}figure,section,svg{break-inside:avoid}"
    ".wide{overflow:visible}}";

void pen_page_begin(const char *title, const char *of, struct pen_buf *out)
{
    pen_buf_puts(out, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    pen_buf_printf(out, "<title>%s: ", title);
    pen_html_escape(of, out);
    pen_buf_printf(out, "</title>\n<style>%s</style>\n</head>\n<body>\n<h1>%s: ", style, title);
    pen_html_escape(of, out);
    pen_buf_puts(out, "</h1>\n");
}

void pen_page_paragraph(const json_t *report, const char *class, pen_page_words *words,
                        struct pen_buf *out)
{
    struct pen_buf text = {0};
    words(report, &text);
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

void pen_page_table(const json_t *report, const struct pen_bench_column *columns,
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

void pen_page_list(const json_t *sentences, const char *heading, struct pen_buf *out)
{
    size_t i;
    json_t *sentence;
    if (json_array_size(sentences) == 0)
        return;
    pen_buf_printf(out, "<h2>%s</h2>\n<ul>", heading);
    json_array_foreach(sentences, i, sentence)
    {
        pen_buf_puts(out, "<li>");
        pen_html_escape(json_string_value(sentence) ? json_string_value(sentence) : "", out);
        pen_buf_puts(out, "</li>");
    }
    pen_buf_puts(out, "</ul>\n");
}

void pen_page_settings(const json_t *render, const char *heading, struct pen_buf *out)
{
    const char *key, *separator = "";
    json_t *value;
    struct pen_buf text = {0};
    json_object_foreach((json_t *)(uintptr_t)render, key, value)
    {
        pen_buf_printf(&text, "%s%s ", separator, key);
        pen_bench_write_value(value, &text);
        separator = ", ";
    }
    pen_buf_printf(out, "<h2>%s</h2>\n<p>", heading);
    pen_html_escape_buf(&text, out);
    pen_buf_puts(out, "</p>\n");
}
