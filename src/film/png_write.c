/* SPDX-License-Identifier: MIT */
/* Writes PNG through libpng, into memory, as many rows at a time as are finished. libpng reports
 * errors by longjmp. The only function that calls setjmp keeps all its state behind one pointer, so
 * no local variable is stale afterwards. After an error libpng is not called again.
 *
 * Compression is chosen for speed, because a person waits for the picture: the Paeth filter for
 * every row, then run-length matches only (Z_RLE). On rendered pictures this is about as fast as
 * zlib's fastest level and up to a fifth smaller. zlib's default level takes three times as long.
 * The choice is fixed, so for one version of zlib the bytes are fixed too. */
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "film/encode.h"

struct pen_png_writer {
    struct pen_film film;
    struct pen_png_options options;
    struct pen_buf *out;
    int rows; /* written so far */
    bool failed;
    struct pen_status status; /* if failed */
    png_structp png;
    png_infop info;
    unsigned char *row; /* one row as written to the file */
    uint16_t *wide;     /* for 16 bits: the row's codes before they are split into bytes */
};

static void on_error(png_structp png, png_const_charp message)
{
    struct pen_png_writer *w = png_get_error_ptr(png);
    bool memory = w->out->failed || strstr(message, "emory");
    pen_fail(&w->status, memory ? PEN_NO_MEMORY : PEN_INTERNAL, "cannot write PNG: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static void on_bytes(png_structp png, png_bytep data, size_t bytes)
{
    struct pen_png_writer *w = png_get_io_ptr(png);
    if (!pen_buf_add(w->out, data, bytes))
        png_error(png, "out of memory");
}

static void on_flush(png_structp png)
{
    (void)png;
}

static void encode_row(struct pen_png_writer *w, int y)
{
    size_t count = (size_t)w->film.width * 3;
    const float *rgb = w->film.rgb + (size_t)y * count;
    if (w->options.bits == 8) {
        pen_encode_8(rgb, count, w->options.transfer, w->row);
        return;
    }
    pen_encode_16(rgb, count, w->options.transfer, w->wide);
    for (size_t i = 0; i < count; i++) {
        w->row[2 * i] = (unsigned char)(w->wide[i] >> 8);
        w->row[2 * i + 1] = (unsigned char)w->wide[i];
    }
}

/* Converts a row of RGB to RGBA in place, starting at its end. */
static void add_alpha(struct pen_png_writer *w, int y)
{
    size_t width = (size_t)w->film.width, value = w->options.bits == 8 ? 1 : 2;
    const unsigned char *mask = w->options.mask + (size_t)y * width;
    for (size_t x = width; x-- > 0;) {
        unsigned char *to = w->row + x * 4 * value;
        memmove(to, w->row + x * 3 * value, 3 * value);
        memset(to + 3 * value, 0xFF, value);
        if (!mask[x])
            memset(to, 0, 4 * value);
    }
}

static void add_text(struct pen_png_writer *w, const char *key, const char *value)
{
    const png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE,
                           .key = (png_charp)(uintptr_t)key,
                           .text = (png_charp)(uintptr_t)value};
    png_set_text(w->png, w->info, &text, 1);
}

static void write_header(struct pen_png_writer *w)
{
    png_set_IHDR(w->png, w->info, (png_uint_32)w->film.width, (png_uint_32)w->film.height,
                 w->options.bits, w->options.mask ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (w->options.transfer == PEN_TRANSFER_LINEAR)
        png_set_gAMA_fixed(w->png, w->info, PNG_GAMMA_LINEAR);
    else
        png_set_sRGB_gAMA_and_cHRM(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (w->options.transfer == PEN_TRANSFER_DISPLAY)
        add_text(w, PEN_TRANSFER_KEY, PEN_TRANSFER_TEXT);
    if (w->options.description)
        add_text(w, "Description", w->options.description);
    png_set_filter(w->png, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
    png_set_compression_strategy(w->png, Z_RLE);
    png_write_info(w->png, w->info);
}

static void write_rows(struct pen_png_writer *w, int end)
{
    for (; w->rows < end; w->rows++) {
        encode_row(w, w->rows);
        if (w->options.mask)
            add_alpha(w, w->rows);
        png_write_row(w->png, w->row);
    }
}

/* The parts of a file. */
enum part { PART_HEADER, PART_ROWS, PART_END };

/* Writes a part; for rows, those before `end`. libpng reports errors by jumping back to here. */
static void write_part(struct pen_png_writer *w, enum part part, int end)
{
    if (w->failed)
        return;
    w->failed = true;
    if (setjmp(png_jmpbuf(w->png)))
        return;
    if (part == PART_HEADER)
        write_header(w);
    else if (part == PART_ROWS)
        write_rows(w, end);
    else
        png_write_end(w->png, NULL);
    w->failed = false;
}

struct pen_png_writer *pen_png_begin(const struct pen_film *film,
                                     const struct pen_png_options *options, struct pen_buf *out,
                                     struct pen_status *st)
{
    const size_t width = (size_t)film->width;
    struct pen_png_writer *w = calloc(1, sizeof *w);
    if (w) {
        *w = (struct pen_png_writer){.film = *film, .options = *options, .out = out};
        w->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, w, on_error, on_warning);
        w->info = w->png ? png_create_info_struct(w->png) : NULL;
        w->row = malloc(width * 8);
        w->wide = malloc(width * 3 * sizeof *w->wide);
    }
    if (!w || !w->info || !w->row || !w->wide) {
        pen_png_free(w);
        pen_fail(st, PEN_NO_MEMORY, "no memory to write PNG");
        return NULL;
    }
    png_set_write_fn(w->png, w, on_bytes, on_flush);
    write_part(w, PART_HEADER, 0);
    return w;
}

void pen_png_rows(struct pen_png_writer *writer, int end)
{
    write_part(writer, PART_ROWS, end);
}

bool pen_png_end(struct pen_png_writer *writer, struct pen_status *st)
{
    write_part(writer, PART_ROWS, writer->film.height);
    write_part(writer, PART_END, 0);
    if (writer->failed)
        *st = writer->status;
    return !writer->failed;
}

void pen_png_free(struct pen_png_writer *writer)
{
    if (!writer)
        return;
    png_destroy_write_struct(&writer->png, &writer->info);
    free(writer->row);
    free(writer->wide);
    free(writer);
}

bool pen_png_write(const struct pen_film *film, const struct pen_png_options *options,
                   struct pen_buf *out, struct pen_status *st)
{
    struct pen_png_writer *writer = pen_png_begin(film, options, out, st);
    bool ok = writer && pen_png_end(writer, st);
    pen_png_free(writer);
    return ok;
}
