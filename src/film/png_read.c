/* SPDX-License-Identifier: MIT */
/* Reads PNG files, also hostile ones. libpng checks the format. This file limits the memory that a
 * file may request. It turns every failure into an error without a leak, also a failure that libpng
 * reports by longjmp. For this, all state is behind one pointer, which the function that calls
 * setjmp does not change. */
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "film/internal/picture.h"

/* The most bytes of a chunk without pixels, and the most such chunks kept. */
enum { CHUNK_BYTES_MAX = 1 << 20, CHUNKS_MAX = 16 };

struct reader {
    const unsigned char *bytes;
    size_t left;
    struct pen_status *st;
    png_structp png;
    png_infop info;
    struct pen_picture *picture;
    int passes; /* over all rows: several if interlaced */
};

static void on_error(png_structp png, png_const_charp message)
{
    struct reader *r = png_get_error_ptr(png);
    enum pen_code code = strstr(message, "emory") ? PEN_NO_MEMORY : PEN_SYNTAX;
    pen_fail(r->st, code, "cannot read PNG: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static void on_bytes(png_structp png, png_bytep out, size_t count)
{
    struct reader *r = png_get_io_ptr(png);
    if (count > r->left)
        png_error(png, "the file ends too early");
    memcpy(out, r->bytes, count);
    r->bytes += count;
    r->left -= count;
}

/* Makes libpng convert every kind of pixel to RGB or RGBA of 8 or 16 bits. */
static void convert_to_rgb(struct reader *r)
{
    png_set_palette_to_rgb(r->png);
    if (png_get_color_type(r->png, r->info) == PNG_COLOR_TYPE_GRAY)
        png_set_expand_gray_1_2_4_to_8(r->png);
    png_set_gray_to_rgb(r->png);
    png_set_tRNS_to_alpha(r->png);
    const uint16_t one = 1;
    if (*(const unsigned char *)&one == 1)
        png_set_swap(r->png); /* PNG is big-endian; samples have the machine's byte order */
    r->passes = png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
}

/* The transfer function that the file states; without one, sRGB. */
static enum pen_transfer read_transfer(const struct reader *r)
{
    int intent, count = 0;
    png_fixed_point gamma;
    png_textp text = NULL;
    png_get_text(r->png, r->info, &text, &count);
    for (int i = 0; i < count; i++) {
        if (strcmp(text[i].key, PEN_TRANSFER_KEY) == 0 && text[i].text &&
            strcmp(text[i].text, PEN_TRANSFER_TEXT) == 0)
            return PEN_TRANSFER_DISPLAY;
    }
    const bool linear = !png_get_sRGB(r->png, r->info, &intent) &&
                        png_get_gAMA_fixed(r->png, r->info, &gamma) && gamma == PNG_GAMMA_LINEAR;
    return linear ? PEN_TRANSFER_LINEAR : PEN_TRANSFER_SRGB;
}

/* Makes the picture, once the header has been read. */
static bool make_picture(struct reader *r)
{
    bool wide = png_get_bit_depth(r->png, r->info) == 16;
    int64_t width = png_get_image_width(r->png, r->info);
    int64_t height = png_get_image_height(r->png, r->info);
    const bool alpha = png_get_color_type(r->png, r->info) & PNG_COLOR_MASK_ALPHA ||
                       png_get_valid(r->png, r->info, PNG_INFO_tRNS);
    r->picture =
        pen_picture_new(width, height, alpha ? 4 : 3, wide ? PICTURE_16 : PICTURE_8, r->st);
    if (!r->picture)
        return false;
    r->picture->transfer = read_transfer(r);
    return true;
}

/* Reads row by row. An array of row pointers for png_read_image would take more memory than the
 * pixels of a narrow picture. */
static void read_rows(struct reader *r)
{
    const int sample_bytes = r->picture->kind == PICTURE_16 ? 2 : 1;
    const size_t row_bytes =
        (size_t)r->picture->width * (size_t)(r->picture->channels * sample_bytes);
    if (png_get_rowbytes(r->png, r->info) != row_bytes)
        png_error(r->png, "unexpected size of a row");
    for (int pass = 0; pass < r->passes; pass++) {
        for (int y = 0; y < r->picture->height; y++)
            png_read_row(r->png, (png_bytep)r->picture->owned + (size_t)y * row_bytes, NULL);
    }
}

/* libpng reports errors by jumping back to here. */
static bool read_all(struct reader *r)
{
    if (setjmp(png_jmpbuf(r->png)))
        return false;
    png_set_read_fn(r->png, r, on_bytes);
    png_set_user_limits(r->png, PNG_UINT_31_MAX,
                        PNG_UINT_31_MAX); /* make_picture checks lower limits */
    png_set_chunk_malloc_max(r->png, CHUNK_BYTES_MAX);
    png_set_chunk_cache_max(r->png, CHUNKS_MAX);
    png_read_info(r->png, r->info);
    if (!make_picture(r)) /* before libpng allocates a row: this checks the size */
        return false;
    convert_to_rgb(r);
    read_rows(r);
    png_read_end(r->png, NULL);
    return true;
}

struct pen_picture *pen_png_read(const unsigned char *bytes, size_t count, struct pen_status *st)
{
    struct reader r = {.bytes = bytes, .left = count, .st = st};
    r.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, on_error, on_warning);
    r.info = r.png ? png_create_info_struct(r.png) : NULL;
    bool ok = false;
    if (r.info)
        ok = read_all(&r);
    else
        pen_fail(st, PEN_NO_MEMORY, "no memory to read PNG");
    png_destroy_read_struct(&r.png, &r.info, NULL);
    if (ok)
        return r.picture;
    pen_picture_free(r.picture);
    return NULL;
}
