/* SPDX-License-Identifier: MIT */
/* Picks the form; CSV, which is short, is here too. */
#include "study/report.h"

#include <stdlib.h>
#include <string.h>

#include "study/internal/read.h"

const char *const pen_study_forms[] = {"json", "csv", "md", "html", NULL};

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

static const struct {
    const char *form, *type;
    void (*write)(const json_t *report, struct pen_buf *out);
} forms[] = {{"json", "application/json", write_json},
             {"csv", "text/csv; charset=utf-8", pen_study_csv},
             {"md", "text/markdown; charset=utf-8", pen_study_markdown},
             {"html", "text/html; charset=utf-8", pen_study_html}};
enum { FORMS = sizeof forms / sizeof forms[0] };

static int find(const char *form)
{
    int i = 0;
    while (i < FORMS && strcmp(forms[i].form, form) != 0)
        i++;
    return i;
}

const char *pen_study_media_type(const char *form)
{
    int i = find(form);
    return i < FORMS ? forms[i].type : "application/octet-stream";
}

bool pen_study_write(const json_t *report, const char *form, struct pen_buf *out,
                     struct pen_status *st)
{
    int i = find(form);
    if (i == FORMS)
        return pen_fail(st, PEN_INTERNAL, "there is no report as %s", form);
    forms[i].write(report, out);
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
}

/* The columns of a CSV file behind the row's number and its settings. */
static const char *const columns[][2] = {
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
};
enum { COLUMNS = sizeof columns / sizeof columns[0] };

/* One cell, in quotes where RFC 4180 wants them. */
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
        pen_write_value(value, &text);
    write_cell(text.data ? (const char *)text.data : "", out);
    out->failed |= text.failed;
    pen_buf_release(&text);
}

void pen_study_csv(const json_t *report, struct pen_buf *out)
{
    const char *key;
    json_t *value;
    const json_t *first = pen_study_at(pen_study_row(report, 0), "settings");
    pen_buf_puts(out, "row");
    json_object_foreach((json_t *)(uintptr_t)first, key, value)
    {
        pen_buf_puts(out, ",");
        write_cell(key, out);
    }
    for (int i = 0; i < COLUMNS; i++)
        pen_buf_printf(out, ",%s", columns[i][0]);
    for (size_t row = 0; row < pen_study_row_count(report); row++) {
        pen_buf_printf(out, "\n%zu", row);
        json_object_foreach((json_t *)(uintptr_t)first, key, value)
        {
            pen_buf_puts(out, ",");
            write_value_cell(
                json_object_get(pen_study_at(pen_study_row(report, row), "settings"), key), out);
        }
        for (int i = 0; i < COLUMNS; i++) {
            pen_buf_puts(out, ",");
            write_value_cell(pen_study_at(pen_study_row(report, row), columns[i][1]), out);
        }
    }
    pen_buf_puts(out, "\n");
}
