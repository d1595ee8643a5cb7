/* SPDX-License-Identifier: MIT */
/* The kinds of reports, and the formats. */
#include "report/report.h"

#include <stdlib.h>
#include <string.h>

#include "report/internal/kind.h"

const char *const pen_report_formats[] = {"json", "csv", "md", "html", NULL};

const char *pen_report_media_type(const char *format)
{
    static const char *const types[] = {"application/json", "text/csv; charset=utf-8",
                                        "text/markdown; charset=utf-8", "text/html; charset=utf-8"};
    for (int i = 0; pen_report_formats[i]; i++)
        if (strcmp(pen_report_formats[i], format) == 0)
            return types[i];
    return "application/octet-stream";
}

static const struct pen_report_kind *kind_of(const json_t *report)
{
    static const struct pen_report_kind *const kinds[] = {&pen_kind_benchmark, &pen_kind_accuracy,
                                                          &pen_kind_effects, &pen_kind_history,
                                                          &pen_kind_comparison};
    for (size_t i = 1; i < sizeof kinds / sizeof kinds[0]; i++)
        if (strcmp(pen_report_string(report, "kind"), kinds[i]->name) == 0)
            return kinds[i];
    return kinds[0];
}

static void write_json(const json_t *report, struct pen_buf *out)
{
    char *text = json_dumps(report, JSON_ENCODE_ANY | JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    pen_buf_printf(out, "%s\n", text ? text : "");
    out->failed |= !text;
    free(text);
}

static void write_words(enum pen_layout layout, const json_t *report, struct pen_buf *out)
{
    const struct pen_report_kind *kind = kind_of(report);
    const json_t *comparison = json_object_get(report, "comparison");
    if (layout == PEN_LAYOUT_MARKDOWN) {
        pen_buf_printf(out, "# %s: ", kind->title);
        pen_layout_text(layout, pen_report_string(report, "scene"), out);
        pen_buf_puts(out, "\n\n");
    }
    pen_layout_lines(layout, kind->answer, report, out);
    pen_buf_puts(out, layout == PEN_LAYOUT_TEXT && kind->answer ? "\n" : "");
    pen_layout_tables(layout, kind, report, out);
    pen_layout_lines(layout, kind->notes, report, out);
    if (comparison && kind == &pen_kind_benchmark) {
        pen_buf_puts(out, layout == PEN_LAYOUT_TEXT ? "\n" : "");
        write_words(layout, comparison, out);
    }
}

bool pen_report_write(const json_t *report, const char *format, const struct pen_buf *figures,
                      struct pen_buf *out, struct pen_status *st)
{
    const struct pen_report_kind *kind = kind_of(report);
    if (strcmp(format, "json") == 0)
        write_json(report, out);
    else if (strcmp(format, "csv") == 0)
        pen_csv_write(kind, report, out);
    else if (strcmp(format, "html") == 0)
        pen_page_write(kind, report, figures, out);
    else if (strcmp(format, "md") == 0)
        write_words(PEN_LAYOUT_MARKDOWN, report, out);
    else if (strcmp(format, "text") == 0)
        write_words(PEN_LAYOUT_TEXT, report, out);
    else
        return pen_fail(st, PEN_INTERNAL, "there is no report as %s", format);
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
}
