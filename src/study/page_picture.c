/* SPDX-License-Identifier: MIT */
/* Pictures within pages. */
#include <stdlib.h>

#include "study/internal/html.h"
#include "study/internal/page.h"

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

/* The mean of n x n pixels each. Fails: false when out of memory. */
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

static void write_png(const struct pen_film *film, enum pen_transfer transfer, const char *alt,
                      struct pen_buf *out)
{
    const struct pen_png_options options = {.bits = 8, .transfer = transfer};
    struct pen_buf png = {0};
    struct pen_status ignored;
    const bool ok = pen_png_write(film, &options, &png, &ignored);
    pen_buf_puts(out, "<img alt=\"");
    pen_html_escape(alt, out);
    pen_buf_printf(out, "\" width=\"%d\" height=\"%d\" src=\"data:image/png;base64,", film->width,
                   film->height);
    if (ok)
        write_base64(png.data, png.bytes, out);
    pen_buf_puts(out, "\">");
    pen_buf_release(&png);
    out->failed |= !ok;
}

void pen_page_picture(const struct pen_film *film, enum pen_transfer transfer, int width,
                      const char *alt, struct pen_buf *out)
{
    struct pen_film small;
    const int n = (film->width + width - 1) / width;
    if (n <= 1 || film->height < n) {
        write_png(film, transfer, alt, out);
        return;
    }
    if (shrink(film, n, &small))
        write_png(&small, transfer, alt, out);
    else
        out->failed = true;
    free(small.rgb);
}
