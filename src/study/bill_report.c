/* SPDX-License-Identifier: MIT */
/* The report of a bill as JSON, and its pictures. */
#include <math.h>
#include <stdio.h>

#include "io/figures.h"
#include "io/json_build.h"
#include "io/settings_json.h"
#include "render/transfer.h"
#include "report/report.h"
#include "study/bill.h"

static const char *name_of(const struct pen_bill_row *row)
{
    return row->effect ? pen_effect_name(__builtin_ctz(row->effect)) : "all effects";
}

/* The cost of a row's effect. */
struct cost {
    bool known; /* the times with and without the effect are distinguished */
    /* If known: the time, and its share of the whole time. */
    double ms, share;
    /* If not known: an upper bound of the time; below 0 if runs are spoiled, so that there is none.
     */
    double below_ms;
    double rays;
};

static struct cost cost_of(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    const struct pen_row_time *whole = &bill->row[0].time, *own = &row->time;
    const bool spoiled =
        pen_runs_spoiled(&bill->use) || whole->spoiled == whole->runs || own->spoiled == own->runs;
    struct cost cost = {.known = !spoiled && pen_row_time_compare(own, whole) != 0,
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

static json_t *figure_or_null(bool known, double value)
{
    return known ? pen_figure(value) : json_null();
}

static json_t *row_json(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    const struct cost cost = cost_of(bill, row);
    json_t *json =
        json_pack("{s:s?, s:o, s:o, s:o, s:i, s:o, s:s, s:f, s:f, s:f}", "without",
                  row->effect ? name_of(row) : NULL, "median_ms", pen_figure(row->time.median),
                  "min_ms", pen_figure(row->time.min), "max_ms", pen_figure(row->time.max),
                  "spoiled", row->time.spoiled, "rays", pen_figure_rays(&row->rays), "kernel",
                  row->kernel, "rmse", row->rmse, "max_error", row->max_error, "flip", row->flip);
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
                     "scene", scene, "view", task->frame.desc->views[task->view].name, "repeats",
                     task->repeats, "timing", "runs", bill->use.runs, "spoiled", bill->use.spoiled,
                     "cpu_share", pen_figure(bill->use.used), "rows",
                     pen_json_all(rows, (size_t)bill->rows), "render",
                     pen_settings_json(task->settings), "host", pen_figure_host());
}

/* "without mirror: 12.3 ms" */
static void write_figure(const struct pen_bill *bill, int row, struct pen_buf *out)
{
    const struct pen_settings *s = bill->task->settings;
    const struct pen_film film = {s->width, s->height, bill->row[row].rgb};
    char caption[80];
    snprintf(caption, sizeof caption, "%s%s: %.1f ms", row > 0 ? "without " : "",
             name_of(&bill->row[row]), bill->row[row].time.median);
    pen_report_figure(&(struct pen_report_figure){row > 0 ? "picture" : "reference", row, &film,
                                                  pen_settings_transfer(s), caption},
                      out);
}

void pen_bill_figures(const struct pen_bill *bill, struct pen_buf *out)
{
    for (int row = 0; row < bill->rows; row++)
        write_figure(bill, row, out);
}
