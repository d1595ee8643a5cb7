/* SPDX-License-Identifier: MIT */
/* The bill as JSON, CSV, Markdown and text. */
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

/* One row of a table, with these marks between and around its cells. */
static void write_row(const struct pen_bill *bill, const struct pen_bill_row *r, const char *form,
                      struct pen_buf *out)
{
    char cost[24] = "", share[24] = "", rays[24] = "", rmse[24] = "", flip[24] = "";
    if (r->effect) {
        snprintf(cost, sizeof cost, "%.1f", pen_bill_cost_ms(bill, r));
        snprintf(share, sizeof share, "%.1f %%", 100 * pen_bill_share(bill, r));
        snprintf(rays, sizeof rays, "%.0f", pen_bill_rays(bill, r));
        snprintf(rmse, sizeof rmse, "%.5f", r->rmse);
        snprintf(flip, sizeof flip, "%.4f", r->flip);
    }
    pen_buf_printf(out, form, pen_bill_name(r), r->median_ms, r->min_ms, r->max_ms, cost, share,
                   rays, rmse, flip);
}

static void write_table(const struct pen_bill *bill, bool markdown, struct pen_buf *out)
{
    static const char text[] = "%-22s %9.1f %9.1f %9.1f %9s %8s %12s %9s %8s\n",
                      md[] = "| %s | %.1f | %.1f | %.1f | %s | %s | %s | %s | %s |\n";
    if (markdown)
        pen_buf_puts(out,
                     "| without | ms | least | most | it costs ms | of all | rays | RMSE | FLIP |\n"
                     "|---|---:|---:|---:|---:|---:|---:|---:|---:|\n");
    else
        pen_buf_printf(out, "%-22s %9s %9s %9s %9s %8s %12s %9s %8s\n", "without", "ms", "least",
                       "most", "costs ms", "of all", "rays", "RMSE", "FLIP");
    for (int i = 0; i < bill->rows; i++)
        write_row(bill, &bill->row[i], markdown ? md : text, out);
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
    else
        write_table(bill, strcmp(format, "md") == 0, out);
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "out of memory for a report");
}
