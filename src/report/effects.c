/* SPDX-License-Identifier: MIT */
/* The contents of a bill's report. */
#include "report/internal/kind.h"

static void write_answer(const json_t *report, struct pen_buf *out)
{
    const json_t *whole = pen_report_row(report, 0);
    if (pen_write_spoiled(report,
                          "No cost in time is told. Repeat the bill when nothing else "
                          "runs, or with fewer threads.",
                          out))
        pen_buf_puts(out, "\n");
    pen_buf_printf(out,
                   "All effects: %.1f ms (%.1f to %.1f), median of %.0f, at %.0f \xC3\x97 %.0f "
                   "pixels.\n",
                   pen_report_number(whole, "median_ms"), pen_report_number(whole, "min_ms"),
                   pen_report_number(whole, "max_ms"), pen_report_number(report, "repeats"),
                   pen_report_number(report, "render.width"),
                   pen_report_number(report, "render.height"));
}

static void write_notes(const json_t *report, struct pen_buf *out)
{
    pen_buf_puts(out, "Each effect is left out in turn, and the renders are interleaved. An effect "
                      "costs the whole time less the time without it. Costs need not add up: an "
                      "effect may hide behind another, or make others dearer. RMSE and FLIP tell "
                      "how far the picture without the effect is from the whole one.\n");
    if (pen_report_row_count(report) == 1)
        pen_buf_puts(out, "The scene calls for no effect.\n");
    pen_write_host(report, out);
    pen_write_shared(report, out);
}

static void write_without(const json_t *row, struct pen_buf *out)
{
    const char *effect = pen_report_string(row, "without");
    pen_buf_puts(out, *effect ? effect : "all effects");
}

/* Appends the cost of the effect. If the times with and without it are not distinguished, an upper
 * bound. */
static void write_cost(const json_t *row, struct pen_buf *out)
{
    if (pen_report_has_number(row, "cost_ms"))
        pen_buf_printf(out, "%.1f", pen_report_number(row, "cost_ms"));
    else if (pen_report_has_number(row, "cost_below_ms"))
        pen_buf_printf(out, "below %.1f", pen_report_number(row, "cost_below_ms"));
}

static void write_share(const json_t *row, struct pen_buf *out)
{
    if (pen_report_has_number(row, "cost_share"))
        pen_buf_printf(out, "%.1f %%", 100 * pen_report_number(row, "cost_share"));
}

static const struct pen_column columns[] = {
    {"without", "without", "without", .cell = PEN_CELL_TEXT, .write = write_without},
    {"median_ms", "ms", "median_ms", .cell = PEN_CELL_TENTH},
    {"min_ms", "range", "min_ms", .cell = PEN_CELL_TENTH, .to = "max_ms"},
    {"max_ms", NULL, "max_ms", .cell = PEN_CELL_NUMBER},
    {"spoiled", NULL, "spoiled", .cell = PEN_CELL_NUMBER},
    {"cost_ms", "costs ms", "cost_ms", .write = write_cost},
    {"cost_below_ms", NULL, "cost_below_ms", .cell = PEN_CELL_NUMBER},
    {"cost_share", "of all", "cost_share", .write = write_share},
    {"cost_rays", "costs rays", "cost_rays", .cell = PEN_CELL_COUNT},
    {"primary", NULL, "rays.primary", .cell = PEN_CELL_NUMBER},
    {"shadow", NULL, "rays.shadow", .cell = PEN_CELL_NUMBER},
    {"reflection", NULL, "rays.reflection", .cell = PEN_CELL_NUMBER},
    {"transmission", NULL, "rays.transmission", .cell = PEN_CELL_NUMBER},
    {"rmse", "RMSE", "rmse", .cell = PEN_CELL_SHORT},
    {"max_error", "largest", "max_error", .cell = PEN_CELL_SHORT},
    {"flip", "FLIP", "flip", .cell = PEN_CELL_SHORT},
    {"kernel", NULL, "kernel", .cell = PEN_CELL_TEXT},
    {0}};

const struct pen_report_kind pen_kind_effects = {.name = "effects",
                                                 .title = "What each effect costs",
                                                 .columns = columns,
                                                 .caption = "The scene without each effect",
                                                 .answer = write_answer,
                                                 .notes = write_notes};
