/* SPDX-License-Identifier: MIT */
/* The contents of the report of an accuracy study. */
#include <math.h>
#include <string.h>

#include "report/internal/kind.h"

static const char *title_of(const char *metric)
{
    static const char *const titles[][2] = {{"rmse", "RMSE"}, {"relative_mse", "relative MSE"},
                                            {"psnr", "PSNR"}, {"ssim", "SSIM"},
                                            {"flip", "FLIP"}, {"max_error", "largest error"}};
    for (size_t i = 0; i < sizeof titles / sizeof titles[0]; i++)
        if (strcmp(titles[i][0], metric) == 0)
            return titles[i][1];
    return "no metric";
}

/* Whether larger values of a metric are better. */
static bool rises(const char *metric)
{
    return strcmp(metric, "psnr") == 0 || strcmp(metric, "ssim") == 0;
}

/* "--set light_samples=64 --set light_pattern=grid" */
static void write_options(const json_t *settings, struct pen_buf *out)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)settings, key, value)
    {
        pen_buf_printf(out, " --set %s=", key);
        pen_write_value(value, out);
    }
}

/* The row that is nearest to the target; NULL if no row's error is known. */
static const json_t *nearest(const json_t *report, const char *metric)
{
    const json_t *best = NULL;
    for (size_t i = 0; i < pen_report_row_count(report); i++) {
        const json_t *row = pen_report_row(report, i);
        if (!json_is_number(json_object_get(row, metric)))
            continue;
        const double here = pen_report_number(row, metric), there = pen_report_number(best, metric);
        if (!best || (rises(metric) ? here > there : here < there))
            best = row;
    }
    return best;
}

static void write_row(const json_t *row, struct pen_buf *out)
{
    pen_write_row_name(row, out);
    pen_buf_printf(out, " (row %.0f, ", pen_report_number(row, "row"));
    pen_write_number(pen_report_number(row, "median_ms"), out);
    pen_buf_puts(out, " ms)");
}

static bool is_spoiled(const json_t *report)
{
    return 2 * pen_report_number(report, "timing.spoiled") >
           pen_report_number(report, "timing.runs");
}

static void write_spoiled(const json_t *report, struct pen_buf *out)
{
    pen_write_spoiled(report,
                      "No row is recommended. Repeat the study when nothing else runs, or "
                      "with fewer threads.",
                      out);
}

static void write_recommended(const json_t *report, const json_t *row, struct pen_buf *out)
{
    const char *metric = pen_report_string(report, "target.metric");
    pen_buf_printf(out, "The cheapest row with %s %s %g in 95 %% of its runs: ", title_of(metric),
                   rises(metric) ? "at least" : "at most",
                   pen_report_number(report, "target.value"));
    write_row(row, out);
    pen_buf_puts(out, ". To get it:");
    write_options(json_object_get(row, "settings"), out);
}

/* "; samples_per_pixel 43 would be needed, with which a picture is expected to take 2.1 s" */
static void write_needed(const json_t *report, struct pen_buf *out)
{
    const json_t *settings = pen_report_member(report, "needed.settings");
    if (!settings)
        return;
    pen_buf_puts(out, ": ");
    pen_write_settings(settings, out);
    pen_buf_printf(out, " would be needed, with which a picture is expected to take %.2g s",
                   pen_report_number(report, "needed.expected_ms") / 1000);
}

static void write_answer(const json_t *report, struct pen_buf *out)
{
    const char *metric = pen_report_string(report, "target.metric");
    const json_t *number = pen_report_member(report, "recommended.row");
    if (json_is_integer(number) && json_integer_value(number) >= 0) {
        write_recommended(report, pen_report_row(report, (size_t)json_integer_value(number)), out);
        return;
    }
    if (is_spoiled(report)) {
        write_spoiled(report, out);
        return;
    }
    pen_buf_printf(out, "None %s the target, %s %g in 95 %% of its runs, in %g s",
                   rises(metric) ? "above" : "below", title_of(metric),
                   pen_report_number(report, "target.value"),
                   pen_report_number(report, "budget_seconds"));
    write_needed(report, out);
    const json_t *row = nearest(report, metric);
    if (row) {
        pen_buf_puts(out, ". The nearest, with ");
        pen_buf_printf(out, "%.3g, is ", pen_report_number(row, metric));
        write_row(row, out);
    }
    pen_buf_puts(out, ".");
}

static void write_method(const json_t *report, struct pen_buf *out)
{
    const double seeds = pen_report_number(report, "seeds");
    pen_buf_puts(out, "Times are of rendering, without building the tree: ");
    if (seeds == 1)
        pen_buf_puts(out, "of one run of each row, in a random order. ");
    else
        pen_buf_printf(out,
                       "medians of up to %.0f runs with different seeds, interleaved in a random "
                       "order. ",
                       seeds);
    pen_buf_puts(out, "Errors are medians over the seeds, against the reference; spreads are from "
                      "5 to 95 %. Efficiency is 1 / (MSE · s). Rows that times do not distinguish "
                      "are distinguished by their rays. ");
    if (!is_spoiled(report))
        write_spoiled(report, out);
}

static void write_reference(const json_t *report, struct pen_buf *out)
{
    static const char *const keys[] = {"samples_per_pixel", "light_samples", "blur_samples",
                                       "lens_samples",      "max_depth",     "min_contribution"};
    const double error = pen_report_number(report, "reference.error");
    const char *separator = "";
    pen_buf_puts(out, "Reference: the mean of two renders with seeds of their own and ");
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        char path[64];
        snprintf(path, sizeof path, "reference.settings.%s", keys[i]);
        pen_buf_printf(out, "%s%s %g", separator, keys[i], pen_report_number(report, path));
        separator = ", ";
    }
    if (error > 0) {
        pen_buf_printf(out,
                       ". Its own error, half of the difference of the two, is %.2g (RMSE); rows "
                       "below twice that are unresolved.",
                       error);
    } else {
        pen_buf_puts(out, ". The two are equal: nothing in it is sampled at random.");
    }
    if (pen_report_number(report, "reference.settings.samples_per_pixel") == 1)
        pen_buf_puts(out, " All rows and the reference see the scene through the pixels' centres: "
                          "jagged edges are not part of the error.");
}

/* Appends the reason why a study took `times` as long as expected. */
static void write_overrun(const json_t *report, double times, struct pen_buf *out)
{
    const double used = pen_report_number(report, "timing.cpu_share"),
                 factor = pen_report_number(report, "reference.factor");
    pen_buf_printf(out, " That is %.3g times as long: ", times);
    if (used > 0 && used < 0.95)
        pen_buf_printf(out, "other programs used the processors, of which the study had %.0f %%.",
                       100 * used);
    else if (factor > 8)
        pen_buf_printf(out,
                       "the reference was made again, with %g times the samples of the longest "
                       "row.",
                       factor);
    else
        pen_buf_puts(out, "the forecast, which renders a few pixels of each row, was too low.");
}

static void write_forecast(const json_t *report, struct pen_buf *out)
{
    const double expected = pen_report_number(report, "forecast.expected_seconds"),
                 high = pen_report_number(report, "forecast.high"),
                 actual = pen_report_number(report, "forecast.actual"),
                 budget = pen_report_number(report, "budget_seconds");
    pen_buf_printf(out, "Expected to take %.3g s (%.3g to %.3g); took %.3g s, of at most %g s.",
                   expected, pen_report_number(report, "forecast.low"), high, actual, budget);
    if (expected > 0 && actual > fmin(fmax(1.5 * expected, high), 1.1 * budget))
        write_overrun(report, actual / fmin(expected, budget), out);
}

/* The error that a number of samples reduces. */
static const char *error_of_setting(const char *setting)
{
    static const char *const errors[][2] = {
        {"samples_per_pixel", "edges"},
        {"lens_samples", "edges and what is out of focus"},
        {"light_samples", "soft shadows"},
        {"blur_samples", "blurred reflections and frosted glass"}};
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++)
        if (strcmp(errors[i][0], setting) == 0)
            return errors[i][1];
    return setting;
}

/* Appends which error remains when more samples of one setting do not reduce it. */
static void write_floor(const json_t *series, const json_t *floor, struct pen_buf *out)
{
    const json_t *settings = json_object_get(floor, "settings");
    const char *own = pen_report_string(series, "setting"), *key, *separator = "";
    json_t *value;
    pen_buf_printf(out,
                   ": the error stays at %.2g, however many there are. %.0f %% of what is left"
                   " (of its square) does not come from %s",
                   pen_report_number(floor, "rmse"), 100 * pen_report_number(floor, "share"),
                   error_of_setting(own));
    json_object_foreach((json_t *)(uintptr_t)settings, key, value)
    {
        pen_buf_printf(out, "%s%s", *separator ? " or " : ", but from ", error_of_setting(key));
        separator = ", ";
    }
    if (json_object_size(settings) > 0) {
        pen_buf_puts(out, ", which take more than ");
        pen_write_settings(settings, out);
    }
    pen_buf_puts(out, ".");
}

static void write_power(const json_t *series, struct pen_buf *out)
{
    const json_t *interval = json_object_get(series, "interval");
    const double slope = pen_report_number(series, "slope"),
                 digit = slope < 0 ? pow(10, -1 / slope) : HUGE_VAL;
    pen_buf_printf(out,
                   ": the error is proportional to N to the power of %.2f (95 %%: %.2f to %.2f; "
                   "expected: %.2f)",
                   slope, json_number_value(json_array_get(interval, 0)),
                   json_number_value(json_array_get(interval, 1)),
                   pen_report_number(series, "expected"));
    if (digit < 1e6)
        pen_buf_printf(out, "; one more digit takes %.2g times the samples", digit);
    pen_buf_puts(out, ".");
}

static void write_slope(const json_t *series, struct pen_buf *out)
{
    const json_t *floor = json_object_get(series, "floor");
    struct pen_buf with = {0};
    pen_write_settings(json_object_get(series, "with"), &with);
    pen_buf_printf(out, "%s%s%s", pen_report_string(series, "setting"), with.bytes ? " with " : "",
                   with.bytes ? (const char *)with.data : "");
    out->failed |= with.failed;
    pen_buf_release(&with);
    if (json_is_object(floor))
        write_floor(series, floor, out);
    else
        write_power(series, out);
}

/* Writes all lines after the tables. */
static void write_notes(const json_t *report, struct pen_buf *out)
{
    static pen_words_fn *const words[] = {write_method, write_reference, write_forecast};
    size_t i;
    json_t *series;
    json_array_foreach(json_object_get(report, "convergence"), i, series)
    {
        write_slope(series, out);
        pen_buf_puts(out, "\n");
    }
    for (i = 0; i < sizeof words / sizeof words[0]; i++) {
        words[i](report, out);
        pen_buf_puts(out, "\n");
    }
    pen_write_list(json_object_get(report, "left_out"), "left out: ", out);
    pen_write_host(report, out);
    pen_write_shared(report, out);
}

static void write_lead(const json_t *report, struct pen_buf *out)
{
    write_answer(report, out);
    pen_buf_puts(
        out, "\nFLIP tells how different two pictures look, from 0 (equal) to 1, as the mean of "
             "all pixels. At 0.02 one sees grain in soft shadows and blurred parts, and the "
             "rest looks equal.\n");
}

/* Appends the error, or its bound if the row is unresolved. */
static void write_rmse(const json_t *row, struct pen_buf *out)
{
    const bool unresolved = json_is_false(json_object_get(row, "resolved"));
    const char *key = unresolved ? "rmse_below" : "rmse";
    if (pen_report_has_number(row, key))
        pen_buf_printf(out, "%s%.3g", unresolved ? "below " : "", pen_report_number(row, key));
}

static void write_remark(const json_t *row, struct pen_buf *out)
{
    const size_t spoiled = json_array_size(json_object_get(row, "spoiled_runs"));
    const char *separator = "";
    if (!(pen_report_number(row, "runs") > 0)) {
        pen_buf_puts(out, "left out");
        return;
    }
    if (json_is_false(json_object_get(row, "resolved"))) {
        pen_buf_puts(out, "unresolved");
        separator = ", ";
    }
    if (json_is_true(json_object_get(row, "pareto"))) {
        pen_buf_printf(out, "%son the front", separator);
        separator = ", ";
    }
    if (spoiled > 0)
        pen_buf_printf(out, "%s%zu of %.0f spoiled", separator, spoiled,
                       pen_report_number(row, "runs"));
}

static const struct pen_column columns[] = {
    {"runs", NULL, "runs", .cell = PEN_CELL_NUMBER},
    {"median_ms", "ms", "median_ms", .cell = PEN_CELL_NUMBER},
    {"min_ms", "range", "min_ms", .to = "max_ms"},
    {"max_ms", NULL, "max_ms", .cell = PEN_CELL_NUMBER},
    {"rays_primary", NULL, "rays.primary", .cell = PEN_CELL_NUMBER},
    {"rays_shadow", NULL, "rays.shadow", .cell = PEN_CELL_NUMBER},
    {"rays_reflection", NULL, "rays.reflection", .cell = PEN_CELL_NUMBER},
    {"rays_transmission", NULL, "rays.transmission", .cell = PEN_CELL_NUMBER},
    {"rays_total", "rays", "rays.total", .cell = PEN_CELL_COUNT},
    {"rmse", "RMSE", "rmse", .write = write_rmse},
    {"rmse_5",
     "5\xE2\x80\x93"
     "95 %",
     "spread.rmse.0", .cell = PEN_CELL_SHORT, .to = "spread.rmse.1"},
    {"rmse_95", NULL, "spread.rmse.1", .cell = PEN_CELL_NUMBER},
    {"relative_mse", "relative MSE", "relative_mse", .cell = PEN_CELL_SHORT},
    {"psnr", "PSNR", "psnr", .cell = PEN_CELL_TENTH},
    {"ssim", "SSIM", "ssim", .cell = PEN_CELL_FOURTH},
    {"flip", "FLIP", "flip", .cell = PEN_CELL_SHORT},
    {"max_error", "largest", "max_error", .cell = PEN_CELL_SHORT},
    {"efficiency", "efficiency", "efficiency", .cell = PEN_CELL_NUMBER},
    {"pareto", "remark", "pareto", .cell = PEN_CELL_TEXT, .write = write_remark},
    {"resolved", NULL, "resolved", .cell = PEN_CELL_NUMBER},
    {"rmse_below", NULL, "rmse_below", .cell = PEN_CELL_NUMBER},
    {0}};

const struct pen_report_kind pen_kind_accuracy = {.name = "accuracy",
                                                  .title = "Accuracy",
                                                  .columns = columns,
                                                  .caption = "All rows",
                                                  .answer = write_lead,
                                                  .notes = write_notes};
