/* SPDX-License-Identifier: MIT */
/* The page of a report: the template, in which the report's parts replace {{NAME}}. The parts are
 * escaped HTML. In the data, `<` is written as \u003c, so that no data ends the element. */
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "report/internal/kind.h"
#include "report/report.h"

enum {
    PICTURE_WIDTH = 640,
    HASH_TEXT = sodium_base64_ENCODED_LEN(crypto_hash_sha256_BYTES, sodium_base64_VARIANT_ORIGINAL)
};
_Static_assert(PEN_REPORT_SOURCE_BYTES >= HASH_TEXT + sizeof "'sha256-'", "a source fits");

static const struct pen_embedded_file *file_of(const char *name)
{
    const struct pen_embedded_file *file = pen_report_files;
    while (strcmp(file->name, name) != 0) /* all callers pass a name that exists */
        file++;
    return file;
}

static void write_source(const char *name, char out[PEN_REPORT_SOURCE_BYTES])
{
    const struct pen_embedded_file *file = file_of(name);
    unsigned char hash[crypto_hash_sha256_BYTES];
    char text[HASH_TEXT];
    crypto_hash_sha256(hash, file->data, file->bytes);
    sodium_bin2base64(text, sizeof text, hash, sizeof hash, sodium_base64_VARIANT_ORIGINAL);
    snprintf(out, PEN_REPORT_SOURCE_BYTES, "'sha256-%s'", text);
}

void pen_report_sources(char script[PEN_REPORT_SOURCE_BYTES], char style[PEN_REPORT_SOURCE_BYTES])
{
    write_source("report.js", script);
    write_source("report.css", style);
}

const char *pen_report_policy(void)
{
    static _Thread_local char policy[80 + 2 * PEN_REPORT_SOURCE_BYTES];
    char script[PEN_REPORT_SOURCE_BYTES], style[PEN_REPORT_SOURCE_BYTES];
    if (!policy[0]) {
        pen_report_sources(script, style);
        snprintf(policy, sizeof policy,
                 "default-src 'none'; script-src %s; style-src %s; img-src data:", script, style);
    }
    return policy;
}

/* The input of a page. */
struct page {
    const struct pen_report_kind *kind;
    const json_t *report;
    const struct pen_buf *figures;
};

static void write_data(const struct page *page, struct pen_buf *out)
{
    char *text = json_dumps(page->report, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(15));
    out->failed |= !text;
    for (const char *c = text; c && *c; c++)
        pen_buf_puts(out, *c == '<' ? "\\u003c" : (const char[]){*c, '\0'});
    free(text);
}

static void write_title(const struct page *page, struct pen_buf *out)
{
    pen_buf_printf(out, "%s: ", page->kind->title);
    pen_layout_text(PEN_LAYOUT_HTML, pen_report_string(page->report, "scene"), out);
}

static void write_policy(const struct page *page, struct pen_buf *out)
{
    (void)page;
    pen_layout_text(PEN_LAYOUT_HTML, pen_report_policy(), out);
}

static void write_style(const struct page *page, struct pen_buf *out)
{
    (void)page;
    pen_buf_puts(out, (const char *)file_of("report.css")->data);
}

static void write_script(const struct page *page, struct pen_buf *out)
{
    (void)page;
    pen_buf_puts(out, (const char *)file_of("report.js")->data);
}

static void write_answer(const struct page *page, struct pen_buf *out)
{
    pen_layout_lines(PEN_LAYOUT_HTML, page->kind->answer, page->report, out);
}

static void write_tables(const struct page *page, struct pen_buf *out)
{
    const json_t *comparison = json_object_get(page->report, "comparison");
    pen_layout_tables(PEN_LAYOUT_HTML, page->kind, page->report, out);
    if (!comparison)
        return;
    pen_layout_tables(PEN_LAYOUT_HTML, &pen_kind_comparison, comparison, out);
    pen_layout_lines(PEN_LAYOUT_HTML, pen_kind_comparison.notes, comparison, out);
}

static void write_notes(const struct page *page, struct pen_buf *out)
{
    pen_layout_lines(PEN_LAYOUT_HTML, page->kind->notes, page->report, out);
}

static void write_figures(const struct page *page, struct pen_buf *out)
{
    if (page->figures)
        pen_buf_add(out, page->figures->data, page->figures->bytes);
}

static const struct {
    const char *name;
    void (*write)(const struct page *page, struct pen_buf *out);
} parts[] = {{"title", write_title},     {"policy", write_policy}, {"style", write_style},
             {"answer", write_answer},   {"tables", write_tables}, {"notes", write_notes},
             {"figures", write_figures}, {"data", write_data},     {"script", write_script}};

void pen_page_write(const struct pen_report_kind *kind, const json_t *report,
                    const struct pen_buf *figures, struct pen_buf *out)
{
    const struct page page = {kind, report, figures};
    const char *text = (const char *)file_of("report.html")->data, *begin;
    for (; (begin = strstr(text, "{{")) != NULL; text = strstr(begin, "}}") + 2) {
        size_t part = 0;
        pen_buf_add(out, text, (size_t)(begin - text));
        while (strncmp(begin + 2, parts[part].name, strlen(parts[part].name)) != 0)
            part++;
        parts[part].write(&page, out);
    }
    pen_buf_puts(out, text);
}

/* Makes a smaller picture, each pixel of which is the mean of n x n pixels. Fails: false when out
 * of memory. */
static bool shrink(const struct pen_film *film, int n, struct pen_film *out)
{
    const int width = film->width / n, height = film->height / n;
    *out = (struct pen_film){width, height,
                             malloc(3 * (size_t)width * (size_t)height * sizeof(float))};
    for (int i = 0; out->rgb && i < 3 * width * height; i++) {
        const int c = i % 3, x = i / 3 % width * n, y = i / 3 / width * n;
        double sum = 0;
        for (int k = 0; k < n * n; k++)
            sum += (double)film
                       ->rgb[3 * ((size_t)(y + k / n) * (size_t)film->width + (size_t)(x + k % n)) +
                             (size_t)c];
        out->rgb[i] = (float)(sum / (n * n));
    }
    return out->rgb != NULL;
}

static void write_base64(const struct pen_buf *bytes, struct pen_buf *out)
{
    const size_t size = sodium_base64_encoded_len(bytes->bytes, sodium_base64_VARIANT_ORIGINAL);
    char *text = malloc(size);
    if (text)
        pen_buf_puts(out, sodium_bin2base64(text, size, bytes->data, bytes->bytes,
                                            sodium_base64_VARIANT_ORIGINAL));
    out->failed |= !text;
    free(text);
}

static void write_png(const struct pen_film *film, const struct pen_report_figure *figure,
                      struct pen_buf *out)
{
    const struct pen_png_options options = {.bits = 8, .transfer = figure->transfer};
    struct pen_buf png = {0};
    struct pen_status ignored;
    const bool ok = pen_png_write(film, &options, &png, &ignored);
    pen_buf_printf(out, "<figure class=\"%s\" data-row=\"%d\"><img alt=\"", figure->class,
                   figure->row);
    pen_layout_text(PEN_LAYOUT_HTML, figure->caption, out);
    pen_buf_printf(out, "\" width=\"%d\" height=\"%d\" src=\"data:image/png;base64,", film->width,
                   film->height);
    if (ok)
        write_base64(&png, out);
    pen_buf_puts(out, "\"><figcaption>");
    pen_layout_text(PEN_LAYOUT_HTML, figure->caption, out);
    pen_buf_puts(out, "</figcaption></figure>\n");
    pen_buf_release(&png);
    out->failed |= !ok;
}

void pen_report_figure(const struct pen_report_figure *figure, struct pen_buf *out)
{
    const struct pen_film *film = figure->film;
    const int n = (film->width + PICTURE_WIDTH - 1) / PICTURE_WIDTH;
    struct pen_film small;
    if (n <= 1 || film->height < n) {
        write_png(film, figure, out);
        return;
    }
    if (shrink(film, n, &small))
        write_png(&small, figure, out);
    else
        out->failed = true;
    free(small.rgb);
}
