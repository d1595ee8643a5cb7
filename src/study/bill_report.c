/* SPDX-License-Identifier: MIT */
/* The bill as JSON, CSV, Markdown and text. */
#include <math.h>
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

struct pen_bill_cost pen_bill_cost_of(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    const struct pen_row_time *whole = &bill->row[0].time, *own = &row->time;
    const bool spoiled =
        pen_runs_spoiled(&bill->use) || whole->spoiled == whole->runs || own->spoiled == own->runs;
    struct pen_bill_cost cost = {.known = !spoiled && pen_row_time_compare(own, whole) != 0,
                                 .below_ms = -1,
                                 .rays = (double)pen_rays_total(&bill->row[0].rays) -
                                         (double)pen_rays_total(&row->rays)};
    if (cost.known) {
        cost.ms = whole->median - own->median;
        cost.share = cost.ms / whole->median;
    } else if (!spoiled) {
        cost.below_ms = fmax(whole->max * (1 + PEN_LEAST_EFFECT) - own->alone, 0);
    }
    return cost;
}

void pen_bill_write_spoiled(const struct pen_bill *bill, struct pen_buf *out)
{
    pen_runs_use_write(&bill->use,
                       "No cost in time is told. Repeat the bill when nothing else runs, or with "
                       "fewer threads.",
                       out);
}

static json_t *figure_or_null(bool known, double value)
{
    return known ? pen_figure(value) : json_null();
}

static json_t *row_json(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    const struct pen_bill_cost cost = pen_bill_cost_of(bill, row);
    json_t *json = json_pack("{s:s?, s:o, s:o, s:o, s:i, s:o, s:s, s:f, s:f, s:f}", "without",
                             row->effect ? pen_bill_name(row) : NULL, "median_ms",
                             pen_figure(row->time.median), "min_ms", pen_figure(row->time.min),
                             "max_ms", pen_figure(row->time.max), "spoiled", row->time.spoiled,
                             "rays", pen_figure_rays(&row->rays), "kernel", row->kernel, "rmse",
                             row->rmse, "max_error", row->max_error, "flip", row->flip);
    if (!row->effect)
        return json;
    json = pen_json_with(json, "cost_ms", figure_or_null(cost.known, cost.ms));
    json = pen_json_with(json, "cost_share", figure_or_null(cost.known, cost.share));
    if (!cost.known)
        json =
            pen_json_with(json, "cost_below_ms", figure_or_null(cost.below_ms >= 0, cost.below_ms));
    return pen_json_with(json, "cost_rays", json_real(cost.rays));
}

json_t *pen_bill_json(const struct pen_bill *bill, const char *scene)
{
    const struct pen_bill_task *task = bill->task;
    json_t *rows = json_array();
    for (int i = 0; i < bill->rows; i++)
        json_array_append_new(rows, row_json(bill, &bill->row[i]));
    return json_pack("{s:s, s:s, s:s, s:i, s:{s:i, s:i, s:o}, s:o, s:o, s:o}", "kind", "effects",
                     "scene", scene, "view", task->desc->views[task->view].name, "repeats",
                     task->repeats, "timing", "runs", bill->use.runs, "spoiled", bill->use.spoiled,
                     "cpu_share", pen_figure(bill->use.used), "rows",
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
        const struct pen_bill_cost cost = pen_bill_cost_of(bill, r);
        pen_buf_printf(out, "%s,%.4f,%.4f,%.4f,", r->effect ? pen_bill_name(r) : "", r->time.median,
                       r->time.min, r->time.max);
        if (cost.known)
            pen_buf_printf(out, "%.4f,%.5f", cost.ms, cost.share);
        else
            pen_buf_puts(out, r->effect ? "," : "0,0");
        pen_buf_printf(
            out, ",%llu,%llu,%llu,%llu,%.6g,%.6g,%s,%.6g\n", (unsigned long long)r->rays.primary,
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
    const struct pen_bill_cost cost = pen_bill_cost_of(bill, r);
    memset(cell, 0, CELLS * sizeof *cell);
    snprintf(cell[0], sizeof *cell, "%s", pen_bill_name(r));
    snprintf(cell[1], sizeof *cell, "%.1f", r->time.median);
    snprintf(cell[2], sizeof *cell, "%.1f", r->time.min);
    snprintf(cell[3], sizeof *cell, "%.1f", r->time.max);
    if (!r->effect)
        return;
    if (cost.known) {
        snprintf(cell[4], sizeof *cell, "%.1f", cost.ms);
        snprintf(cell[5], sizeof *cell, "%.1f %%", 100 * cost.share);
    } else if (cost.below_ms >= 0) {
        snprintf(cell[4], sizeof *cell, "below %.1f", cost.below_ms);
    }
    snprintf(cell[6], sizeof *cell, "%.0f", cost.rays);
    snprintf(cell[7], sizeof *cell, "%.5f", r->rmse);
    snprintf(cell[8], sizeof *cell, "%.4f", r->flip);
}

static void write_markdown(const struct pen_bill *bill, struct pen_buf *out)
{
    char cell[CELLS][CELL_BYTES];
    if (pen_runs_spoiled(&bill->use)) {
        pen_bill_write_spoiled(bill, out);
        pen_buf_puts(out, "\n\n");
    }
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
    if (pen_runs_spoiled(&bill->use)) {
        pen_bill_write_spoiled(bill, out);
        pen_buf_puts(out, "\n\n");
    }
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
    const bool words = strcmp(format, "md") == 0 || strcmp(format, "text") == 0;
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
    if (words && bill->use.spoiled > 0 && !pen_runs_spoiled(&bill->use)) {
        pen_buf_puts(out, "\n");
        pen_bill_write_spoiled(bill, out);
        pen_buf_puts(out, "\n");
    }
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "out of memory for a report");
}
