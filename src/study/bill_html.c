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
    pen_buf_printf(out, "<figcaption>%s: %.1f ms</figcaption></figure>\n", name, row->median_ms);
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
    pen_page_begin("What each effect costs", scene, out);
    pen_buf_printf(
        out,
        "<p class=\"soft\">%d × %d pixels. All effects: %.1f ms (%.1f to %.1f), "
        "median of %d. Each effect is left out in turn; the runs are interleaved. What the "
        "effects cost need not add up: one may hide behind another, or make others dearer. "
        "A bar as wide as the page is the whole time.</p>\n",
        bill->task->settings->width, bill->task->settings->height, whole->median_ms, whole->min_ms,
        whole->max_ms, bill->task->repeats);
    write_effects(bill, out);
    if (bill->rows == 1)
        pen_buf_puts(out, "<p>The scene calls for no effect.</p>\n");
    pen_page_end(out);
}
