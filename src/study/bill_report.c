/* SPDX-License-Identifier: MIT */
/* The bill as JSON, CSV, Markdown and text. */
#include <stdio.h>
#include <string.h>

#include "io/figures.h"
#include "io/json_build.h"
#include "io/settings_json.h"
#include "study/internal/bill_formats.h"
#include "study/report.h"

const char *pen_bill_name(const struct pen_bill_row *row)
{
    return row->effect ? pen_effect_name(__builtin_ctz(row->effect)) : "all effects";
}

double pen_bill_cost_ms(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    return bill->row[0].median_ms - row->median_ms;
}

double pen_bill_share(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    const double whole = bill->row[0].median_ms;
    return whole > 0 ? pen_bill_cost_ms(bill, row) / whole : 0;
}

static uint64_t rays_of(const struct pen_bill_row *row)
{
    return row->rays.primary + row->rays.shadow + row->rays.reflection + row->rays.transmission;
}

double pen_bill_rays(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    return (double)rays_of(&bill->row[0]) - (double)rays_of(row);
}

static json_t *row_json(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    json_t *json =
        json_pack("{s:s?, s:o, s:o, s:o, s:o, s:s, s:f, s:f, s:f}", "without",
                  row->effect ? pen_bill_name(row) : NULL, "median_ms", pen_figure(row->median_ms),
                  "min_ms", pen_figure(row->min_ms), "max_ms", pen_figure(row->max_ms), "rays",
                  pen_figure_rays(&row->rays), "kernel", row->kernel, "rmse", row->rmse,
                  "max_error", row->max_error, "flip", row->flip);
    json_t *cost = json_pack("{s:o, s:o, s:f}", "cost_ms", pen_figure(pen_bill_cost_ms(bill, row)),
                             "cost_share", pen_figure(pen_bill_share(bill, row)), "cost_rays",
                             pen_bill_rays(bill, row));
    if (!json || !cost || (row->effect && json_object_update(json, cost) != 0)) {
        json_decref(json);
        json = NULL;
    }
    json_decref(cost);
    return json;
}

json_t *pen_bill_json(const struct pen_bill *bill, const char *scene)
{
    const struct pen_bill_task *task = bill->task;
    json_t *rows = json_array();
    for (int i = 0; i < bill->rows; i++)
        json_array_append_new(rows, row_json(bill, &bill->row[i]));
    return json_pack("{s:s, s:s, s:s, s:i, s:o, s:o, s:o}", "kind", "effects", "scene", scene,
                     "view", task->desc->views[task->view].name, "repeats", task->repeats, "rows",
                     pen_json_all(rows, (size_t)bill->rows), "render",
                     pen_settings_json(task->settings), "host", pen_figure_host());
}

static void write_json(const struct pen_bill *bill, const char *scene, struct pen_buf *out)
{
    json_t *json = pen_bill_json(bill, scene);
    char *text = json ? json_dumps(json, JSON_INDENT(2) | JSON_REAL_PRECISION(15)) : NULL;
    if (text)
        pen_buf_printf(out, "%s\n", text);
    out->failed |= !text;
    free(text);
    json_decref(json);
}

static void write_csv(const struct pen_bill *bill, struct pen_buf *out)
{
    pen_buf_puts(out,
                 "without,median_ms,min_ms,max_ms,cost_ms,cost_share,primary,shadow,reflection,"
                 "transmission,rmse,max_error,kernel,flip\n");
    for (int i = 0; i < bill->rows; i++) {
        const struct pen_bill_row *r = &bill->row[i];
        pen_buf_printf(
            out, "%s,%.4f,%.4f,%.4f,%.4f,%.5f,%llu,%llu,%llu,%llu,%.6g,%.6g,%s,%.6g\n",
            r->effect ? pen_bill_name(r) : "", r->median_ms, r->min_ms, r->max_ms,
            pen_bill_cost_ms(bill, r), pen_bill_share(bill, r), (unsigned long long)r->rays.primary,
            (unsigned long long)r->rays.shadow, (unsigned long long)r->rays.reflection,
            (unsigned long long)r->rays.transmission, r->rmse, r->max_error, r->kernel, r->flip);
    }
}

/* The cells of a row of a table, as text. */
enum { CELLS = 9, CELL_BYTES = 24 };
static const char *const titles[CELLS] = {"without", "ms",   "least", "most", "costs ms",
                                          "of all",  "rays", "RMSE",  "FLIP"};

static void make_cells(const struct pen_bill *bill, const struct pen_bill_row *r,
                       char cell[CELLS][CELL_BYTES])
{
    memset(cell, 0, CELLS * sizeof *cell);
    snprintf(cell[0], sizeof *cell, "%s", pen_bill_name(r));
    snprintf(cell[1], sizeof *cell, "%.1f", r->median_ms);
    snprintf(cell[2], sizeof *cell, "%.1f", r->min_ms);
    snprintf(cell[3], sizeof *cell, "%.1f", r->max_ms);
    if (!r->effect)
        return;
    snprintf(cell[4], sizeof *cell, "%.1f", pen_bill_cost_ms(bill, r));
    snprintf(cell[5], sizeof *cell, "%.1f %%", 100 * pen_bill_share(bill, r));
    snprintf(cell[6], sizeof *cell, "%.0f", pen_bill_rays(bill, r));
    snprintf(cell[7], sizeof *cell, "%.5f", r->rmse);
    snprintf(cell[8], sizeof *cell, "%.4f", r->flip);
}

static void write_markdown(const struct pen_bill *bill, struct pen_buf *out)
{
    char cell[CELLS][CELL_BYTES];
    for (int i = 0; i < CELLS; i++)
        pen_buf_printf(out, "| %s%s", titles[i], i + 1 < CELLS ? " " : " |\n");
    for (int i = 0; i < CELLS; i++)
        pen_buf_printf(out, "%s%s", i == 0 ? "|---" : "|---:", i + 1 < CELLS ? "" : "|\n");
    for (int row = 0; row < bill->rows; row++) {
        make_cells(bill, &bill->row[row], cell);
        for (int i = 0; i < CELLS; i++)
            pen_buf_printf(out, "| %s%s", cell[i], i + 1 < CELLS ? " " : " |\n");
    }
}

/* A line with the first cell and some of the others. */
static void write_line(const char *first, const char *const *cell, int count, struct pen_buf *out)
{
    pen_buf_printf(out, "%-22s", first);
    for (int i = 0; i < count; i++)
        pen_buf_printf(out, " %10s", cell[i]);
    pen_buf_puts(out, "\n");
}

/* Two tables, the second below the first, since one would be wider than 80 columns. */
static void write_text(const struct pen_bill *bill, struct pen_buf *out)
{
    enum { PARTS = 2 };
    static const int begin[PARTS + 1] = {1, 6, CELLS};
    char cell[CELLS][CELL_BYTES];
    const char *cells[CELLS];
    for (int part = 0; part < PARTS; part++) {
        const int first = begin[part], count = begin[part + 1] - first;
        pen_buf_puts(out, part ? "\n" : "");
        write_line(titles[0], titles + first, count, out);
        for (int row = 0; row < bill->rows; row++) {
            make_cells(bill, &bill->row[row], cell);
            for (int i = 0; i < count; i++)
                cells[i] = cell[first + i];
            if (part == 0 || bill->row[row].effect)
                write_line(cell[0], cells, count, out);
        }
    }
}

bool pen_bill_write(const struct pen_bill *bill, const char *scene, const char *format,
                    struct pen_buf *out, struct pen_status *st)
{
    if (strcmp(format, "json") == 0)
        write_json(bill, scene, out);
    else if (strcmp(format, "csv") == 0)
        write_csv(bill, out);
    else if (strcmp(format, "html") == 0)
        pen_bill_write_html(bill, scene, out);
    else if (strcmp(format, "md") == 0)
        write_markdown(bill, out);
    else
        write_text(bill, out);
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "out of memory for a report");
}
