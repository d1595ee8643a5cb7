/* SPDX-License-Identifier: MIT */
/* The bill as one page of HTML without scripts or references: for each effect a bar of its time,
 * and the picture without it beside the whole one. Colours are light or dark as the browser
 * prefers. */
#include <math.h>
#include <stdlib.h>

#include "film/encode.h"
#include "io/figures.h"
#include "study/internal/bill_formats.h"
#include "study/internal/html.h"

enum { PICTURE_WIDTH = 480 };

static const char style[] =
    ":root{color-scheme:light dark;--ink:#1b1f24;--soft:#5a6370;--line:#d6dbe1;--paper:#fff;"
    "--bar:#3573b9}"
    "@media(prefers-color-scheme:dark){:root{--ink:#e7eaee;--soft:#a3adb9;--line:#39424d;"
    "--paper:#14181d;--bar:#5b9ae0}}"
    "body{margin:0 auto;padding:1.5rem;max-width:78rem;color:var(--ink);background:var(--paper);"
    "font:16px/1.5 system-ui,sans-serif}"
    "h1{font-size:1.6rem;margin:0 0 .3rem}p{margin:.4rem 0}.soft{color:var(--soft)}"
    "section{border-top:1px solid var(--line);padding:1rem 0}"
    "h2{font-size:1.15rem;margin:0}.bar{background:var(--bar);height:.9rem;min-width:1px;margin:."
    "3rem 0}"
    ".pair{display:flex;flex-wrap:wrap;gap:.8rem}figure{margin:.4rem 0;max-width:100%}"
    "figcaption{color:var(--soft);font-size:.88rem}img{max-width:100%;height:auto;display:block}";

/* Appends bytes in base 64 (RFC 4648). */
static void write_base64(const unsigned char *bytes, size_t count, struct pen_buf *out)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < count; i += 3) {
        const size_t left = count - i;
        const unsigned long group = (unsigned long)bytes[i] << 16 |
                                    (left > 1 ? (unsigned long)bytes[i + 1] << 8 : 0) |
                                    (left > 2 ? bytes[i + 2] : 0);
        const char text[5] = {digit[group >> 18], digit[group >> 12 & 63],
                              left > 1 ? digit[group >> 6 & 63] : '=',
                              left > 2 ? digit[group & 63] : '=', 0};
        pen_buf_puts(out, text);
    }
}

/* The mean of n x n pixels, in place; the film gets the new size. */
static void shrink(struct pen_film *film, int n)
{
    const int width = film->width / n, height = film->height / n;
    for (int i = 0; i < 3 * width * height; i++) {
        const int c = i % 3, x = i / 3 % width * n, y = i / 3 / width * n;
        double sum = 0;
        for (int k = 0; k < n * n; k++)
            sum += (double)film
                       ->rgb[3 * ((size_t)(y + k / n) * (size_t)film->width + (size_t)(x + k % n)) +
                             (size_t)c];
        film->rgb[i] = (float)(sum / (n * n));
    }
    film->width = width;
    film->height = height;
}

static void write_picture(const struct pen_bill *bill, const struct pen_bill_row *row,
                          struct pen_buf *out)
{
    const struct pen_settings *s = bill->task->settings;
    const size_t values = 3 * (size_t)s->width * (size_t)s->height;
    struct pen_film film = {s->width, s->height, malloc(values * sizeof(float))};
    const struct pen_png_options options = {
        .bits = 8,
        .transfer = s->transfer == PEN_SETTING_LINEAR ? PEN_TRANSFER_LINEAR : PEN_TRANSFER_SRGB};
    struct pen_status st;
    struct pen_buf png = {0};
    for (size_t i = 0; film.rgb && i < values; i++)
        film.rgb[i] = row->rgb[i];
    const int n = (s->width + PICTURE_WIDTH - 1) / PICTURE_WIDTH;
    if (film.rgb && n > 1 && s->height >= n)
        shrink(&film, n);
    if (!film.rgb || !pen_png_write(&film, &options, &png, &st)) {
        out->failed = true;
    } else {
        pen_buf_printf(out,
                       "<figure><img alt=\"%s%s\" width=\"%d\" height=\"%d\" "
                       "src=\"data:image/png;base64,",
                       row->effect ? "without " : "", pen_bill_name(row), film.width, film.height);
        write_base64(png.data, png.bytes, out);
        pen_buf_printf(out, "\"><figcaption>%s%s: %.1f ms</figcaption></figure>\n",
                       row->effect ? "without " : "", pen_bill_name(row), row->median_ms);
    }
    pen_buf_release(&png);
    free(film.rgb);
}

/* Whether runs of one row differ by more than the two rows do. */
static bool is_noise(const struct pen_bill *bill, const struct pen_bill_row *row)
{
    const double cost = fabs(pen_bill_cost_ms(bill, row));
    const double whole = bill->row[0].max_ms - bill->row[0].min_ms, own = row->max_ms - row->min_ms;
    return cost < (whole > own ? whole : own);
}

static void write_effect(const struct pen_bill *bill, const struct pen_bill_row *row,
                         struct pen_buf *out)
{
    const double share = pen_bill_share(bill, row);
    pen_buf_printf(
        out,
        "<section><h2>%s</h2>\n<div class=\"bar\" style=\"width:%.1f%%\"></div>\n"
        "<p>costs %.1f ms, %.1f %% of the whole (%.1f ms without it, %.1f to %.1f)%s, and %.0f "
        "rays; the picture changes by an RMSE of %.5f, at most %.3f, and a FLIP of %.4f.</p>\n"
        "<div class=\"pair\">",
        pen_bill_name(row), 100 * (share > 0 ? share < 1 ? share : 1 : 0),
        pen_bill_cost_ms(bill, row), 100 * share, row->median_ms, row->min_ms, row->max_ms,
        is_noise(bill, row) ? ", less than the runs of one scene differ by" : "",
        pen_bill_rays(bill, row), row->rmse, row->max_error, row->flip);
    write_picture(bill, row, out);
    write_picture(bill, &bill->row[0], out);
    pen_buf_puts(out, "</div></section>\n");
}

/* The effects, the dearest first. */
static void write_effects(const struct pen_bill *bill, struct pen_buf *out)
{
    const struct pen_bill_row *order[PEN_FX_COUNT + 1];
    for (int i = 1; i < bill->rows; i++) {
        int at = i;
        for (; at > 1 && bill->row[i].median_ms < order[at - 1]->median_ms; at--)
            order[at] = order[at - 1];
        order[at] = &bill->row[i];
    }
    for (int i = 1; i < bill->rows; i++)
        write_effect(bill, order[i], out);
}

void pen_bill_write_html(const struct pen_bill *bill, const char *scene, struct pen_buf *out)
{
    const struct pen_bill_row *whole = &bill->row[0];
    pen_buf_puts(out, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                      "<title>Effects: ");
    pen_html_escape(scene, out);
    pen_buf_printf(
        out, "</title>\n<style>%s</style>\n</head>\n<body>\n<h1>What each effect costs: ", style);
    pen_html_escape(scene, out);
    pen_buf_printf(
        out,
        "</h1>\n<p class=\"soft\">%d × %d pixels. All effects: %.1f ms (%.1f to %.1f), "
        "median of %d. Each effect is left out in turn; the runs are interleaved. What the "
        "effects cost need not add up: one may hide behind another, or make others dearer. "
        "A bar as wide as the page is the whole time.</p>\n",
        bill->task->settings->width, bill->task->settings->height, whole->median_ms, whole->min_ms,
        whole->max_ms, bill->task->repeats);
    write_effects(bill, out);
    if (bill->rows == 1)
        pen_buf_puts(out, "<p>The scene calls for no effect.</p>\n");
    pen_buf_puts(out, "</body>\n</html>\n");
}
