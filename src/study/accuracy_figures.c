/* SPDX-License-Identifier: MIT */
/* The pictures of an accuracy study's page. Each error map has its own scale, so that small errors
 * can be seen. The caption gives the scale. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/error_map.h"
#include "render/transfer.h"
#include "report/report.h"
#include "report/values.h"
#include "study/accuracy.h"

static const double shown_share =
    0.995; /* share of the pixels whose errors fit the scale of a map */

static struct pen_film film_of(const struct pen_accuracy *accuracy, const float *rgb)
{
    const struct pen_settings *s = accuracy->task->settings;
    return (struct pen_film){s->width, s->height, (float *)(uintptr_t)rgb};
}

static enum pen_transfer transfer_of(const struct pen_accuracy *accuracy)
{
    return pen_settings_transfer(accuracy->task->settings);
}

static int by_value(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The error at the end of a map's scale: 1, 2 or 5 times a power of ten, above nearly all errors.
 * Sorts the errors. */
static double scale_of(float *errors, size_t count)
{
    qsort(errors, count, sizeof *errors, by_value);
    const double most = fmax((double)errors[(size_t)(shown_share * (double)(count - 1))], 0.001),
                 power = pow(10, floor(log10(most))), digit = most / power;
    return fmin((digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10) * power, 1);
}

static bool write_map(const struct pen_accuracy *accuracy, int row, struct pen_buf *out,
                      struct pen_status *st)
{
    const struct pen_settings *s = accuracy->task->settings;
    const struct pen_study_pair pair = {s, accuracy->row[row].rgb, accuracy->reference.rgb};
    const size_t count = (size_t)s->width * (size_t)s->height;
    float *errors = malloc(2 * count * sizeof *errors);
    double ignored[PEN_METRIC_COUNT];
    char caption[80];
    struct pen_film *film = NULL;
    if (!errors)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for an error map");
    if (pen_study_measure(&pair, ignored, errors, st)) {
        memcpy(errors + count, errors, count * sizeof *errors);
        const double scale = scale_of(errors + count, count);
        for (size_t i = 0; i < count; i++)
            errors[i] = fminf(errors[i] / (float)scale, 1);
        snprintf(caption, sizeof caption, "Error map: black is 0, pale yellow a FLIP of %g or more",
                 scale);
        film = pen_error_map(errors, s->width, s->height, PEN_ERROR_MAP_COLOURS, st);
    }
    if (film)
        pen_report_figure(&(struct pen_report_figure){"map", row, film, PEN_TRANSFER_SRGB, caption},
                          out);
    free(errors);
    pen_film_free(film);
    return film != NULL;
}

/* "Row 2, light_samples 64: 231 ms, RMSE 0.0031, FLIP 0.012" */
static void write_caption(const json_t *report, int number, struct pen_buf *out)
{
    const json_t *row = pen_report_row(report, (size_t)number);
    pen_buf_printf(out, "Row %d, ", number);
    pen_write_row_name(row, out);
    pen_buf_puts(out, ": ");
    pen_write_number(pen_report_number(row, "median_ms"), out);
    if (json_is_true(json_object_get(row, "resolved")))
        pen_buf_printf(out, " ms, RMSE %.3g, FLIP %.3g", pen_report_number(row, "rmse"),
                       pen_report_number(row, "flip"));
    else
        pen_buf_printf(out, " ms, RMSE below %.3g", pen_report_number(row, "rmse_below"));
    if (pen_report_has_number(report, "recommended.row") &&
        pen_report_whole(report, "recommended.row") == number)
        pen_buf_puts(out, " (meets the target)");
}

static void write_row(const struct pen_accuracy *accuracy, const json_t *report, int row,
                      struct pen_buf *out)
{
    const struct pen_film film = film_of(accuracy, accuracy->row[row].rgb);
    struct pen_buf caption = {0};
    write_caption(report, row, &caption);
    pen_report_figure(&(struct pen_report_figure){"picture", row, &film, transfer_of(accuracy),
                                                  caption.data ? (const char *)caption.data : ""},
                      out);
    out->failed |= caption.failed;
    pen_buf_release(&caption);
}

static void write_cost(const struct pen_accuracy *accuracy, struct pen_buf *out)
{
    const struct pen_film film = film_of(accuracy, accuracy->cost);
    char caption[120];
    if (!accuracy->cost)
        return;
    snprintf(caption, sizeof caption,
             "The time of each pixel in row %d, by its fourth root: black is 0, white is "
             "%.3g \xC2\xB5s",
             accuracy->cost_row, accuracy->cost_most / 1000);
    pen_report_figure(&(struct pen_report_figure){"cost", -1, &film, PEN_TRANSFER_LINEAR, caption},
                      out);
}

bool pen_accuracy_figures(const struct pen_accuracy *accuracy, const json_t *report,
                          struct pen_buf *out, struct pen_status *st)
{
    const struct pen_film reference = film_of(accuracy, accuracy->reference.rgb);
    bool ok = true;
    pen_report_figure(&(struct pen_report_figure){"reference", -1, &reference,
                                                  transfer_of(accuracy), "The reference"},
                      out);
    for (int i = 0; ok && i < accuracy->task->row_count; i++) {
        if (accuracy->row[i].runs == 0)
            continue;
        write_row(accuracy, report, i, out);
        ok = write_map(accuracy, i, out, st);
    }
    write_cost(accuracy, out);
    return ok && (!out->failed || pen_fail(st, PEN_NO_MEMORY, "no memory for a report"));
}
