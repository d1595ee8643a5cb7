/* SPDX-License-Identifier: MIT */
/* The report of an accuracy study as a page: the answer first, then the plots, the pictures of the
 * rows to choose from, all rows side by side, the table, and what it cost. The chooser is a group
 * of radio buttons, so that it needs no script and the arrow keys move through the rows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/error_map.h"
#include "film/flip.h"
#include "render/transfer.h"
#include "study/accuracy.h"
#include "study/accuracy_summary.h"
#include "study/internal/accuracy_plot.h"
#include "study/internal/accuracy_words.h"
#include "study/internal/html.h"
#include "study/internal/page.h"

enum { LARGE = 560, SMALL = 240, CROP = 96, CROP_SHOWN = 288 };

/* What the page is made of. */
struct page {
    const struct pen_accuracy *accuracy;
    const json_t *report;
    float **map;        /* FLIP's error of each pixel, by row; NULL: the row was left out */
    int crop_x, crop_y; /* of the part that is shown enlarged */
    int crop_w, crop_h;
    int order[PEN_ACCURACY_ROWS_MAX], count; /* the rows of the front, by time */
    struct pen_buf *out;
};

static struct pen_film film_of(const struct page *page, const float *rgb)
{
    const struct pen_settings *s = page->accuracy->task->settings;
    return (struct pen_film){s->width, s->height, (float *)(uintptr_t)rgb};
}

static const json_t *row_of(const struct page *page, int row)
{
    return pen_bench_report_row(page->report, (size_t)row);
}

static size_t pixels_of(const struct page *page)
{
    const struct pen_settings *s = page->accuracy->task->settings;
    return (size_t)s->width * (size_t)s->height;
}

/* FLIP's error of each pixel of a row's picture. */
static bool make_map(const struct page *page, int row, float *errors, struct pen_status *st)
{
    const struct pen_film a = film_of(page, page->accuracy->row[row].rgb),
                          b = film_of(page, page->accuracy->reference.rgb);
    struct pen_picture *left =
        pen_picture_of_film(&a, pen_settings_transfer(page->accuracy->task->settings), st);
    struct pen_picture *right =
        left ? pen_picture_of_film(&b, pen_settings_transfer(page->accuracy->task->settings), st)
             : NULL;
    struct pen_flip flip;
    const bool ok = right && pen_picture_flip(left, right, errors, &flip, st);
    pen_picture_free(left);
    pen_picture_free(right);
    return ok;
}

static bool make_maps(struct page *page, struct pen_status *st)
{
    const struct pen_accuracy_task *task = page->accuracy->task;
    page->map = calloc((size_t)task->row_count, sizeof *page->map);
    bool ok = page->map != NULL;
    for (int i = 0; ok && i < task->row_count; i++) {
        if (page->accuracy->row[i].runs == 0)
            continue;
        page->map[i] = malloc(pixels_of(page) * sizeof *page->map[i]);
        if (page->map[i] && !make_map(page, i, page->map[i], st))
            return false;
        ok = page->map[i] != NULL;
    }
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for the error maps");
}

static double map_sum(const struct page *page, const float *map, int x0, int y0)
{
    const int width = page->accuracy->task->settings->width;
    double sum = 0;
    for (int y = y0; y < y0 + page->crop_h; y++)
        for (int x = x0; x < x0 + page->crop_w; x++)
            sum += (double)map[(size_t)y * (size_t)width + (size_t)x];
    return sum;
}

/* The part of the picture in which the first row that was run is farthest off: there rows differ
 * most. */
static void choose_crop(struct page *page)
{
    const struct pen_settings *s = page->accuracy->task->settings;
    const float *map = page->map[page->accuracy->stats_row];
    double most = -1;
    page->crop_w = s->width < CROP ? s->width : CROP;
    page->crop_h = s->height < CROP ? s->height : CROP;
    for (int y = 0; y + page->crop_h <= s->height; y += CROP / 4) {
        for (int x = 0; x + page->crop_w <= s->width; x += CROP / 4) {
            const double sum = map_sum(page, map, x, y);
            if (sum > most) {
                most = sum;
                page->crop_x = x;
                page->crop_y = y;
            }
        }
    }
}

static double time_of(const struct page *page, int row)
{
    return pen_bench_report_number(row_of(page, row), "median_ms");
}

/* The rows of the front, by time. */
static void sort_front(struct page *page)
{
    for (int i = 0; i < page->accuracy->task->row_count; i++) {
        if (!json_is_true(json_object_get(row_of(page, i), "pareto")))
            continue;
        int at = page->count++;
        for (; at > 0 && time_of(page, page->order[at - 1]) > time_of(page, i); at--)
            page->order[at] = page->order[at - 1];
        page->order[at] = i;
    }
}

/* "light_samples 64: 231 ms, RMSE 0.0031, FLIP 0.012" */
static void write_caption(const struct page *page, int row, struct pen_buf *out)
{
    const json_t *json = row_of(page, row);
    struct pen_buf text = {0};
    pen_buf_printf(&text, "Row %d, ", row);
    pen_accuracy_write_settings(json_object_get(json, "settings"), &text);
    pen_buf_puts(&text, ": ");
    pen_bench_write_number(time_of(page, row), "\xE2\x80\xAF", &text);
    pen_buf_puts(&text, " ms");
    if (json_is_true(json_object_get(json, "resolved"))) {
        pen_buf_puts(&text, ", RMSE ");
        pen_accuracy_write_error(pen_bench_report_number(json, "rmse"), &text);
        pen_buf_puts(&text, ", FLIP ");
        pen_accuracy_write_error(pen_bench_report_number(json, "flip"), &text);
    } else {
        pen_buf_puts(&text, ", RMSE below ");
        pen_accuracy_write_error(pen_bench_report_number(json, "rmse_below"), &text);
    }
    if (pen_accuracy_is_recommended(page->report, json))
        pen_buf_puts(&text, " (meets the target)");
    pen_html_escape_buf(&text, out);
}

static void write_picture(const struct page *page, const float *rgb, int width, const char *caption)
{
    const struct pen_film film = film_of(page, rgb);
    pen_buf_puts(page->out, "<figure>");
    pen_page_picture(&film, pen_settings_transfer(page->accuracy->task->settings), width, caption,
                     page->out);
    pen_buf_printf(page->out, "<figcaption>%s</figcaption></figure>\n", caption);
}

static void write_map(const struct page *page, int row, int width, const char *caption)
{
    const struct pen_settings *s = page->accuracy->task->settings;
    struct pen_status ignored;
    struct pen_film *film =
        pen_error_map(page->map[row], s->width, s->height, PEN_ERROR_MAP_COLOURS, &ignored);
    pen_buf_puts(page->out, "<figure>");
    if (film)
        pen_page_picture(film, PEN_TRANSFER_SRGB, width, caption, page->out);
    else
        page->out->failed = true;
    pen_buf_printf(page->out, "<figcaption>%s</figcaption></figure>\n", caption);
    pen_film_free(film);
}

/* The part of a picture that is shown enlarged. */
static void write_crop(const struct page *page, const float *rgb, const char *caption)
{
    const size_t width = (size_t)page->accuracy->task->settings->width,
                 line = 3 * (size_t)page->crop_w;
    struct pen_film crop = {page->crop_w, page->crop_h,
                            malloc(line * (size_t)page->crop_h * sizeof(float))};
    for (int y = 0; crop.rgb && y < page->crop_h; y++)
        memcpy(crop.rgb + (size_t)y * line,
               rgb + 3 * ((size_t)(page->crop_y + y) * width + (size_t)page->crop_x),
               line * sizeof(float));
    pen_buf_puts(page->out, "<figure class=\"crop\">");
    if (crop.rgb)
        pen_page_picture(&crop, pen_settings_transfer(page->accuracy->task->settings), CROP_SHOWN,
                         caption, page->out);
    else
        page->out->failed = true;
    pen_buf_printf(page->out, "<figcaption>%s</figcaption></figure>\n", caption);
    free(crop.rgb);
}

/* The row that the chooser shows first: the recommended one, or the last. */
static int first_shown(const struct page *page)
{
    for (int i = 0; i < page->count; i++)
        if (pen_accuracy_is_recommended(page->report, row_of(page, page->order[i])))
            return i;
    return page->count - 1;
}

/* The style that shows the picture of the button that is pressed. */
static void write_chooser_style(const struct page *page)
{
    pen_buf_puts(page->out, "<style>@media screen{.shown{display:none}");
    for (int i = 0; i < page->count; i++)
        pen_buf_printf(page->out, "%s#choose%d:checked~.shown%d", i ? "," : "", i, i);
    pen_buf_puts(page->out, "{display:block}}</style>\n");
}

static void write_buttons(const struct page *page)
{
    const int first = first_shown(page);
    for (int i = 0; i < page->count; i++) {
        const json_t *row = row_of(page, page->order[i]);
        pen_buf_printf(page->out,
                       "<input type=\"radio\" name=\"choose\" id=\"choose%d\"%s>"
                       "<label for=\"choose%d\"><b>",
                       i, i == first ? " checked" : "", i);
        pen_bench_write_number(time_of(page, page->order[i]), "\xE2\x80\xAF", page->out);
        pen_buf_puts(page->out, " ms</b> ");
        if (json_is_number(json_object_get(row, "flip"))) {
            pen_buf_puts(page->out, "FLIP ");
            pen_accuracy_write_error(pen_bench_report_number(row, "flip"), page->out);
        } else {
            pen_buf_puts(page->out, "unresolved");
        }
        pen_buf_puts(page->out, "</label>\n");
    }
}

static void write_chooser(const struct page *page)
{
    write_chooser_style(page);
    pen_buf_puts(page->out,
                 "<h2>What more time buys</h2>\n<p class=\"soft\">The rows on the Pareto "
                 "front, from the quickest to the most accurate. The error map is "
                 "black where a pixel looks right, and pale yellow where it is wholly "
                 "wrong (FLIP). The enlarged part is where the first row is farthest "
                 "off.</p>\n<div class=\"choose\">");
    write_buttons(page);
    for (int i = 0; i < page->count; i++) {
        const int row = page->order[i];
        const float *rgb = page->accuracy->row[row].rgb;
        pen_buf_printf(page->out, "<div class=\"shown shown%d\"><p>", i);
        write_caption(page, row, page->out);
        pen_buf_puts(page->out, "</p>\n<div class=\"pair\">");
        write_picture(page, rgb, LARGE, "picture");
        write_map(page, row, LARGE, "error map");
        write_crop(page, rgb, "enlarged");
        write_crop(page, page->accuracy->reference.rgb, "the reference there");
        pen_buf_puts(page->out, "</div></div>\n");
    }
    pen_buf_puts(page->out, "</div>\n");
}

static void write_side_by_side(const struct page *page)
{
    pen_buf_puts(page->out, "<h2>All rows side by side</h2>\n<div class=\"rows\">");
    for (int i = 0; i < page->accuracy->task->row_count; i++) {
        if (page->accuracy->row[i].runs == 0)
            continue;
        pen_buf_puts(page->out, "<section><p>");
        write_caption(page, i, page->out);
        pen_buf_puts(page->out, "</p>\n<div class=\"pair\">");
        write_picture(page, page->accuracy->row[i].rgb, SMALL, "picture");
        write_map(page, i, SMALL, "error map");
        pen_buf_puts(page->out, "</div></section>\n");
    }
    pen_buf_puts(page->out, "<section><p>Reference</p>\n<div class=\"pair\">");
    write_picture(page, page->accuracy->reference.rgb, SMALL, "picture");
    pen_buf_puts(page->out, "</div></section></div>\n");
}

static void write_time_plot(const struct page *page, const char *metric)
{
    pen_buf_puts(page->out, "<figure class=\"small\">");
    pen_accuracy_plot_time(page->report, metric, false, page->out);
    pen_buf_printf(page->out,
                   "<figcaption>%s against time. Each point is a row, labelled by %s; whiskers: "
                   "least to largest time, 5 to 95 %% of the errors. The line is the Pareto "
                   "front: rows that no other row beats in both. Grey rows are beaten. A triangle "
                   "is a row whose error lies somewhere below it. Ringed: the cheapest row that "
                   "meets the target.</figcaption></figure>\n",
                   pen_accuracy_metric_title(metric),
                   json_object_size(json_object_get(row_of(page, 0), "settings")) == 1
                       ? "its setting"
                       : "its number in the table");
}

static void write_convergence(const struct page *page)
{
    const json_t *list = json_object_get(page->report, "convergence");
    size_t i;
    json_t *series;
    if (json_array_size(list) == 0)
        return;
    pen_buf_puts(page->out, "<h2>How fast errors fall</h2>\n<figure class=\"small\">");
    pen_accuracy_plot_convergence(page->report, page->out);
    pen_buf_puts(page->out, "<figcaption>RMSE against the number of samples N, and the line that "
                            "fits it best, with its slope.</figcaption></figure>\n<ul>");
    json_array_foreach(list, i, series)
    {
        struct pen_buf text = {0};
        pen_accuracy_write_slope(series, &text);
        pen_buf_printf(page->out, "<li class=\"c%zu\"><span class=\"key\"></span> ", i % 6);
        pen_html_escape_buf(&text, page->out);
        pen_buf_puts(page->out, "</li>\n");
    }
    pen_buf_puts(page->out, "</ul>\n");
}

static void write_cost(const struct page *page)
{
    const struct pen_accuracy *a = page->accuracy;
    const struct pen_film film = film_of(page, a->cost);
    if (!a->cost)
        return;
    pen_buf_printf(page->out, "<h2>Where the time goes</h2>\n<figure>");
    pen_page_picture(&film, PEN_TRANSFER_LINEAR, LARGE, "time of each pixel", page->out);
    pen_buf_printf(page->out,
                   "<figcaption>The time of each pixel in row %d, by its fourth root: black is "
                   "0, white is %.3g \xC2\xB5s.</figcaption></figure>\n",
                   a->cost_row, a->cost_most / 1000);
}

static void write_page(struct page *page)
{
    struct pen_buf *out = page->out;
    pen_page_begin("Accuracy", pen_bench_report_string(page->report, "scene"), out);
    pen_page_paragraph(page->report, "answer", pen_accuracy_write_answer, out);
    pen_buf_puts(out, "<div class=\"pair\">");
    write_time_plot(page, "rmse");
    write_time_plot(page, "flip");
    pen_buf_puts(out, "</div>\n");
    pen_page_table(page->report, pen_accuracy_columns, "All rows", out);
    write_chooser(page);
    write_convergence(page);
    write_side_by_side(page);
    write_cost(page);
    pen_buf_puts(out, "<h2>How this was measured</h2>\n");
    pen_page_paragraph(page->report, "", pen_accuracy_write_method, out);
    pen_page_paragraph(page->report, "", pen_accuracy_write_reference, out);
    pen_page_paragraph(page->report, "", pen_accuracy_write_forecast, out);
    pen_page_list(json_object_get(page->report, "left_out"), "Left out", out);
    pen_buf_puts(out, "<h2>Machine</h2>\n");
    pen_page_paragraph(page->report, "", pen_bench_write_host, out);
    pen_page_settings(json_object_get(page->report, "render"), "Settings of the scene", out);
    pen_page_end(out);
}

bool pen_accuracy_write_html(const struct pen_accuracy *accuracy, const json_t *report,
                             struct pen_buf *out, struct pen_status *st)
{
    struct page page = {.accuracy = accuracy, .report = report, .out = out};
    bool ok = make_maps(&page, st);
    if (ok) {
        choose_crop(&page);
        sort_front(&page);
        write_page(&page);
        ok = !out->failed || pen_fail(st, PEN_NO_MEMORY, "out of memory for a report");
    }
    for (int i = 0; page.map && i < accuracy->task->row_count; i++)
        free(page.map[i]);
    free(page.map);
    return ok;
}

bool pen_accuracy_write_svg(const json_t *report, struct pen_buf *out, struct pen_status *st)
{
    pen_accuracy_plot_time(report, "rmse", true, out);
    pen_buf_puts(out, "\n");
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "out of memory for a plot");
}
