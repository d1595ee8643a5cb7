/* SPDX-License-Identifier: MIT */
/* The report as one page that needs no other file: the table, and a picture of each distribution of
 * errors. */
#include <math.h>
#include <string.h>

#include "property/catalogue.h"
#include "property/oracle.h"
#include "property/report.h"

static const char style[] =
    "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport "
    "content='width=device-width'><title>Penumbra: stability</title><style>\n"
    ":root{color-scheme:light dark;--ink:#1d2430;--paper:#fff;--line:#d5dae2;--bar:#3b6ea8;"
    "--bad:#b3261e;--good:#1b7a3d;--soft:#6b7482}\n"
    "@media(prefers-color-scheme:dark){:root{--ink:#e4e8ee;--paper:#14171c;--line:#343b46;"
    "--bar:#7fb0e6;--bad:#ff8a80;--good:#7bd69a;--soft:#9aa4b2}}\n"
    "body{font:15px/1.45 system-ui,sans-serif;color:var(--ink);background:var(--paper);"
    "max-width:1180px;margin:2em auto;padding:0 1em}\n"
    "table{border-collapse:collapse;width:100%;font-size:13px}td,th{border-bottom:1px solid "
    "var(--line);padding:.35em .5em;text-align:left;vertical-align:top}\n"
    "td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}"
    ".bad{color:var(--bad);font-weight:600}.good{color:var(--good)}.soft{color:var(--soft)}\n"
    "code{font-size:12px;overflow-wrap:anywhere}figure{display:inline-block;margin:.5em 1em "
    "1em 0;width:360px;vertical-align:top}figcaption{font-size:12px}svg{width:360px;height:150px}\n"
    "svg text{font-size:10px;fill:var(--soft)}svg rect{fill:var(--bar)}svg rect.over{fill:"
    "var(--bad)}svg line{stroke:var(--line)}svg line.bound{stroke:var(--bad);stroke-dasharray:3 2}"
    "</style>\n";

static void put_text(FILE *f, const char *text)
{
    for (; text && *text; text++) {
        if (*text == '<')
            fputs("&lt;", f);
        else if (*text == '&')
            fputs("&amp;", f);
        else
            fputc(*text, f);
    }
}

static void put_row(FILE *f, const struct report_row *row)
{
    const struct row *r = row->row;
    const char *verdict = report_verdict(row);
    const char *class = report_failed(row) ? "bad" : row->ran ? "good" : "soft";
    fprintf(f, "<tr><td>%s<td>", r->id);
    put_text(f, r->what);
    fputs("<td>", f);
    put_text(f, r->status == ROW_TESTED ? r->oracle : "");
    fprintf(f, "<td class=n>%llu<td class=n>%llu<td class=%s>%s",
            (unsigned long long)row->result.tried, (unsigned long long)row->result.failures, class,
            verdict);
    if (r->why || r->known) {
        fputs(": ", f);
        put_text(f, r->why ? r->why : r->known);
    }
    fprintf(f, "<td class=n>%.1f\n", row->result.cpu_s);
}

enum { LEFT = 34, RIGHT = 350, TOP = 8, BOTTOM = 124 };

/* The height of a count's logarithm; one case is still seen. */
static double height(double decades, double top)
{
    return (BOTTOM - TOP) * (0.05 + 0.95 * decades / top);
}

/* The place of a value: the axis runs from the first bin to the last in use. */
static double place(int bin, int last)
{
    return LEFT + (double)(RIGHT - LEFT) * bin / (last + 1);
}

static int bin_at(double value)
{
    int bin = 0;
    while (bin + 1 < ROW_BINS && row_bin_begin(bin + 1) <= value)
        bin++;
    return bin;
}

static int last_bin(const struct row_series *s)
{
    int last = bin_at(s->bound > 1 ? s->bound : 1) + 3;
    for (int i = 0; i < ROW_BINS; i++)
        if (s->bin[i] && i > last)
            last = i;
    return last < ROW_BINS ? last : ROW_BINS - 1;
}

static void put_axis(FILE *f, int last, double top)
{
    fprintf(f, "<line x1=%d y1=%d x2=%d y2=%d />", LEFT, BOTTOM, RIGHT, BOTTOM);
    int step = last > 80 ? 32 : last > 40 ? 16 : 8;
    for (int bin = 1; bin <= last; bin += step) {
        int power = (bin - 1) / 4 - 8;
        fprintf(f,
                "<text x=%.1f y=%d text-anchor=middle>2<tspan dy=-3 font-size=8>%d</tspan></text>",
                place(bin, last), BOTTOM + 14, power);
    }
    for (double decade = 0; decade <= top; decade += top > 4 ? 2 : 1) {
        double y = BOTTOM - height(decade, top);
        fprintf(f, "<text x=%d y=%.1f text-anchor=end>1e%.0f</text>", LEFT - 4, y + 3, decade);
    }
}

/* Counts on a logarithmic scale over errors on a logarithmic scale. */
static void put_picture(FILE *f, const struct row_series *s)
{
    int last = last_bin(s);
    double top = 1;
    for (int i = 0; i < ROW_BINS; i++)
        if (s->bin[i] && log10((double)s->bin[i]) > top)
            top = log10((double)s->bin[i]);
    fputs("<svg viewBox='0 0 360 150' role=img>", f);
    put_axis(f, last, top);
    for (int i = 0; i <= last; i++) {
        if (s->bin[i] == 0)
            continue;
        double high = height(log10((double)s->bin[i]), top);
        bool over = s->bound >= 0 && row_bin_begin(i) >= s->bound;
        fprintf(f, "<rect%s x=%.1f y=%.1f width=%.1f height=%.1f />", over ? " class=over" : "",
                place(i, last), BOTTOM - high, place(i + 1, last) - place(i, last) - .5, high);
    }
    if (s->bound >= 0) {
        int at = bin_at(s->bound);
        double low = row_bin_begin(at), x = place(at, last);
        if (at > 0 && s->bound > low)
            x += 4 * log2(s->bound / low) * (RIGHT - LEFT) / (last + 1);
        fprintf(f, "<line class=bound x1=%.1f y1=%d x2=%.1f y2=%d />", x, TOP, x, BOTTOM);
    }
    fputs("</svg>", f);
}

static void put_series(FILE *f, const struct report_row *row, const struct row_series *s)
{
    char text[4096];
    row_print(text, sizeof text, &s->worst);
    fputs("<figure>", f);
    put_picture(f, s);
    fprintf(f, "<figcaption><b>%s</b> ", row->row->id);
    put_text(f, s->name);
    fprintf(f, "<br>%llu values, median %.3g, 99.9 %% %.3g, <span class=%s>max %.4g</span>",
            (unsigned long long)s->count, row_quantile(s, .5), row_quantile(s, .999),
            s->over ? "bad" : "good", s->max);
    if (s->bound >= 0)
        fprintf(f, ", bound %g", s->bound);
    fprintf(f,
            "<details><summary>worst case</summary><code>%s</code></details></figcaption>"
            "</figure>\n",
            text);
}

static void put_failures(FILE *f, const struct report_row *row)
{
    char text[4096];
    if (row->result.crashed)
        fprintf(f, "<p class=bad>%s: a process ended by a signal or an assertion</p>\n",
                row->row->id);
    for (int i = 0; i < row->result.kept_count; i++) {
        const struct row_kept *k = &row->result.kept[i];
        row_print(text, sizeof text, &k->small);
        fprintf(f, "<p><b>%s</b> ", row->row->id);
        put_text(f, k->why);
        fprintf(f, "<br><code>%s %s</code></p>\n", row->row->name, text);
    }
}

static void put_prices(FILE *f, const struct report *report)
{
    if (report->prices == 0)
        return;
    fputs(
        "<h2>Cost</h2><p>Of one ray and one primitive: a ray is tested against a list of "
        "primitives in the cache, and the nearest hit is kept. ns are medians of interleaved runs "
        "on a shared machine.</p><table><tr>"
        "<th>primitive<th>method<th>ns<th>instructions\n",
        f);
    for (int i = 0; i < report->prices; i++) {
        const struct price *p = &report->price[i];
        fprintf(f, "<tr><td>%s<td>%s<td class=n>%.2f<td class=n>", p->primitive, p->method, p->ns);
        fprintf(f, p->instructions > 0 ? "%.1f\n" : "–\n", p->instructions);
    }
    fputs("</table>\n", f);
}

void report_html(const struct report *report, FILE *f)
{
    struct report_sums s = report_sum(report);
    fputs(style, f);
    fprintf(
        f,
        "<h1>Stability</h1><p>%d rows tested, <span class=%s>%d failed</span>; %d pending, %d do "
        "not apply. %llu cases, %llu failures. Seed %llu, %.0f s of processor time; oracle: "
        "%s.</p><table><tr><th>id<th>what<th>oracle<th>cases<th>failures<th>verdict<th>s\n",
        s.tested, s.failed ? "bad" : "good", s.failed, s.pending, s.inapplicable,
        (unsigned long long)s.tried, (unsigned long long)s.failures,
        (unsigned long long)report->seed, s.cpu_s, oracle_arithmetic());
    for (int i = 0; i < report->rows; i++)
        put_row(f, &report->row[i]);
    fputs("</table><h2>Failures, in their smallest form</h2>\n", f);
    for (int i = 0; i < report->rows; i++)
        put_failures(f, &report->row[i]);
    fputs(s.failed ? "" : "<p>None.</p>\n", f);
    fputs("<h2>Errors</h2><p>The number of values (upwards, logarithmic) with each error (to the "
          "right, logarithmic; the first column is exact or below 2<sup>-8</sup>). The dashed line "
          "is "
          "the bound.</p>\n",
          f);
    for (int i = 0; i < report->rows; i++)
        for (int k = 0; k < report->row[i].result.series_count; k++)
            put_series(f, &report->row[i], &report->row[i].result.series[k]);
    catalogue_html(f);
    put_prices(f, report);
    fputs("</html>\n", f);
}
