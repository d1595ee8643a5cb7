/* SPDX-License-Identifier: MIT */
/* The bill as one page of HTML without scripts or references: for each effect a bar of its time,
 * and the picture without it beside the whole one. Colours are light or dark as the browser
 * prefers. */
#include <math.h>

#include "io/figures.h"
#include "render/transfer.h"
#include "study/internal/bill_formats.h"
#include "study/internal/page.h"

enum { PICTURE_WIDTH = 480 };

static void write_picture(const struct pen_bill *bill, const struct pen_bill_row *row,
                          struct pen_buf *out)
{
    const struct pen_settings *s = bill->task->settings;
    const struct pen_film film = {s->width, s->height, row->rgb};
    char name[80];
    snprintf(name, sizeof name, "%s%s", row->effect ? "without " : "", pen_bill_name(row));
    pen_buf_puts(out, "<figure>");
    pen_page_picture(&film, pen_settings_transfer(s), PICTURE_WIDTH, name, out);
    pen_buf_printf(out, "<figcaption>%s: %.1f ms</figcaption></figure>\n", name, row->time.median);
}

static void write_cost(const struct pen_bill_cost *cost, struct pen_buf *out)
{
    if (cost->known)
        pen_buf_printf(out, "costs %.1f ms, %.1f %% of the whole", cost->ms, 100 * cost->share);
    else if (cost->below_ms >= 0)
        pen_buf_printf(out, "costs less than %.1f ms, which these runs do not distinguish",
                       cost->below_ms);
    else
        pen_buf_puts(out, "costs a time that spoiled runs do not tell");
}

static void write_effect(const struct pen_bill *bill, const struct pen_bill_row *row,
                         struct pen_buf *out)
{
    const struct pen_bill_cost cost = pen_bill_cost_of(bill, row);
    const double share = fmin(fmax(cost.share, 0), 1);
    pen_buf_printf(out,
                   "<section><h2>%s</h2>\n<div class=\"bar\" style=\"width:%.1f%%\"></div>\n<p>",
                   pen_bill_name(row), 100 * share);
    write_cost(&cost, out);
    pen_buf_printf(
        out,
        " (%.1f ms without it, %.1f to %.1f), and %.0f rays; the picture changes by an RMSE of "
        "%.5f, at most %.3f, and a FLIP of %.4f.</p>\n<div class=\"pair\">",
        row->time.median, row->time.min, row->time.max, cost.rays, row->rmse, row->max_error,
        row->flip);
    write_picture(bill, row, out);
    write_picture(bill, &bill->row[0], out);
    pen_buf_puts(out, "</div></section>\n");
}

/* Whether the scene is cheaper without a row's effect than without another's. */
static bool is_cheaper(const struct pen_bill_row *row, const struct pen_bill_row *than)
{
    return pen_row_cost_compare(&row->time, &row->rays, &than->time, &than->rays) < 0;
}

/* The effects, the dearest first. */
static void write_effects(const struct pen_bill *bill, struct pen_buf *out)
{
    const struct pen_bill_row *order[PEN_FX_COUNT + 1];
    for (int i = 1; i < bill->rows; i++) {
        int at = i;
        for (; at > 1 && is_cheaper(&bill->row[i], order[at - 1]); at--)
            order[at] = order[at - 1];
        order[at] = &bill->row[i];
    }
    for (int i = 1; i < bill->rows; i++)
        write_effect(bill, order[i], out);
}

void pen_bill_write_html(const struct pen_bill *bill, const char *scene, struct pen_buf *out)
{
    const struct pen_bill_row *whole = &bill->row[0];
    pen_page_begin("What each effect costs", scene, out);
    if (bill->use.spoiled > 0) {
        pen_buf_puts(out, "<p>");
        pen_bill_write_spoiled(bill, out);
        pen_buf_puts(out, "</p>\n");
    }
    pen_buf_printf(
        out,
        "<p class=\"soft\">%d × %d pixels. All effects: %.1f ms (%.1f to %.1f), "
        "median of %d. Each effect is left out in turn; the runs are interleaved. What the "
        "effects cost need not add up: one may hide behind another, or make others dearer. "
        "A bar as wide as the page is the whole time.</p>\n",
        bill->task->settings->width, bill->task->settings->height, whole->time.median,
        whole->time.min, whole->time.max, bill->task->repeats);
    write_effects(bill, out);
    if (bill->rows == 1)
        pen_buf_puts(out, "<p>The scene calls for no effect.</p>\n");
    pen_page_end(out);
}
