/* SPDX-License-Identifier: MIT */
/* Files are written and read back. Codes follow the formula, and PNG chunks state the transfer
 * function. Every kind of PNG that other programs write is read. Damaged and hostile files end in
 * an error. */
#include <math.h>
#include <png.h>
#include <stdbool.h>
#include <string.h>

#include "film/encode.h"
#include "film/metrics.h"
#include "film/picture.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

enum { W = 13, H = 9, COUNT = W * H * 3 };

static float pixels[COUNT];

static struct pen_film make_film(void)
{
    struct random r = random_begin(1);
    for (int i = 0; i < COUNT; i++)
        pixels[i] = (float)random_in(&r, -0.1, 1.3);
    pixels[0] = 0, pixels[1] = 1, pixels[2] = 4;
    return (struct pen_film){W, H, pixels};
}

static struct pen_buf write_png(const struct pen_film *film, struct pen_png_options options)
{
    struct pen_buf out = {0};
    struct pen_status st;
    ck_assert_msg(pen_png_write(film, &options, &out, &st), "%s", st.msg);
    return out;
}

/* Finds a chunk's data in a PNG, or NULL. */
static const unsigned char *chunk(const struct pen_buf *png, const char *name)
{
    for (size_t at = 8; at + 12 <= png->bytes;) {
        const unsigned char *p = png->data + at;
        size_t length = (size_t)p[0] << 24 | (size_t)p[1] << 16 | (size_t)p[2] << 8 | p[3];
        if (memcmp(p + 4, name, 4) == 0)
            return p + 8;
        at += length + 12;
    }
    return NULL;
}

static struct pen_picture *read_back(const struct pen_buf *file)
{
    struct pen_status st;
    struct pen_picture *picture = pen_picture_read(file->data, file->bytes, &st);
    ck_assert_msg(picture != NULL, "%s", st.msg);
    return picture;
}

START_TEST(test_files__png_holds_the_codes_of_the_formula)
{
    struct pen_film film = make_film();
    for (int i = 0; i < 4; i++) {
        struct pen_png_options options = {
            .bits = i & 1 ? 16 : 8, .transfer = i & 2 ? PEN_TRANSFER_LINEAR : PEN_TRANSFER_SRGB};
        double max = i & 1 ? 65535 : 255;
        struct pen_buf out = write_png(&film, options);
        struct pen_picture *picture = read_back(&out);
        ck_assert(pen_picture_width(picture) == W && pen_picture_height(picture) == H);
        for (int y = 0; y < H; y++) {
            double encoded[W * 3], linear[W * 3];
            pen_picture_encoded_row(picture, y, encoded);
            pen_picture_linear_row(picture, y, linear);
            for (int x = 0; x < W * 3; x++) {
                double v = (double)pixels[y * W * 3 + x];
                double code = floor(max * pen_encode_unit(v, options.transfer) + 0.5) / max;
                double own = options.transfer == PEN_TRANSFER_LINEAR ? linear[x] : encoded[x];
                double other = options.transfer == PEN_TRANSFER_LINEAR ? encoded[x] : linear[x];
                double converted = options.transfer == PEN_TRANSFER_LINEAR
                                       ? pen_encode_unit(code, PEN_TRANSFER_SRGB)
                                       : pen_decode_srgb(code);
                ck_assert_msg(own == code && other == converted, "kind %d, row %d: %g for %g", i, y,
                              own, v);
            }
        }
        pen_picture_free(picture);
        pen_buf_release(&out);
    }
}
END_TEST

/* A file whose codes are values for a screen says so in a text, which our reader obeys; to others
 * it is sRGB. Pictures that have the same samples under other tags are found equal. */
START_TEST(test_files__values_for_a_screen_stay_as_they_are)
{
    const struct pen_png_options display = {.bits = 8, .transfer = PEN_TRANSFER_DISPLAY};
    struct pen_film film = make_film();
    struct pen_buf shown = write_png(&film, display),
                   linear = write_png(
                       &film, (struct pen_png_options){.bits = 8, .transfer = PEN_TRANSFER_LINEAR});
    ck_assert(chunk(&shown, "sRGB") && chunk(&shown, "gAMA") && chunk(&shown, "cHRM"));
    ck_assert_mem_eq(chunk(&shown, "gAMA"), "\x00\x00\xB1\x8F", 4);
    ck_assert_mem_eq(chunk(&shown, "tEXt"), "transfer\0display", 16);
    struct pen_status st;
    struct pen_picture *a = pen_picture_read(shown.data, shown.bytes, &st),
                       *b = pen_picture_read(linear.data, linear.bytes, &st),
                       *numbers = pen_picture_of_film(&film, PEN_TRANSFER_LINEAR, &st);
    double row[2][3 * W];
    struct pen_difference d;
    for (int y = 0; y < H; y++) {
        pen_picture_encoded_row(a, y, row[0]);
        pen_picture_linear_row(b, y, row[1]);
        ck_assert_mem_eq(row[0], row[1], sizeof row[0]);
        pen_picture_linear_row(a, y, row[1]);
        for (int i = 0; i < 3 * W; i++)
            ck_assert(row[1][i] == pen_decode_srgb(row[0][i]));
    }
    ck_assert(pen_picture_compare(a, b, 0, &d, &st) && d.rmse > 0.01);
    ck_assert(!pen_picture_match(a, numbers) && pen_picture_compare(a, numbers, 0, &d, &st));
    ck_assert(d.max_error <= 0.5 / 255 + 1e-9);
    ck_assert(pen_picture_match(a, b) && pen_picture_compare(a, b, 0, &d, &st) && d.rmse == 0);
    pen_picture_free(a);
    pen_picture_free(b);
    pen_picture_free(numbers);
    pen_buf_release(&shown);
    pen_buf_release(&linear);
}
END_TEST

START_TEST(test_files__png_states_its_transfer)
{
    struct pen_film film = make_film();
    struct pen_buf srgb = write_png(&film, (struct pen_png_options){.bits = 8});
    struct pen_buf linear =
        write_png(&film, (struct pen_png_options){.bits = 16, .transfer = PEN_TRANSFER_LINEAR});
    ck_assert(chunk(&srgb, "sRGB") && chunk(&srgb, "gAMA") && chunk(&srgb, "cHRM"));
    ck_assert(!chunk(&linear, "sRGB") && chunk(&linear, "gAMA"));
    ck_assert_mem_eq(chunk(&srgb, "gAMA"), "\x00\x00\xB1\x8F", 4);
    ck_assert_mem_eq(chunk(&linear, "gAMA"), "\x00\x01\x86\xA0", 4);
    ck_assert_mem_eq(chunk(&srgb, "IHDR"), "\0\0\0\x0D\0\0\0\x09\x08\x02\0\0\0", 13);
    ck_assert_mem_eq(chunk(&linear, "IHDR"), "\0\0\0\x0D\0\0\0\x09\x10\x02\0\0\0", 13);
    ck_assert(!chunk(&srgb, "tIME") && !chunk(&srgb, "tEXt"));
    struct pen_buf again = write_png(&film, (struct pen_png_options){.bits = 8});
    ck_assert(again.bytes == srgb.bytes && memcmp(again.data, srgb.data, srgb.bytes) == 0);
    pen_buf_release(&again);
    pen_buf_release(&srgb);
    pen_buf_release(&linear);
}
END_TEST

START_TEST(test_files__pixels_not_rendered_yet_are_transparent)
{
    struct pen_film film = make_film();
    unsigned char mask[W * H];
    for (int i = 0; i < W * H; i++)
        mask[i] = i % 3 == 0;
    for (int bits = 8; bits <= 16; bits += 8) {
        struct pen_buf out = write_png(&film, (struct pen_png_options){.bits = bits, .mask = mask});
        png_image image = {.version = PNG_IMAGE_VERSION};
        unsigned char rgba[W * H * 4], plain[3];
        ck_assert(png_image_begin_read_from_memory(&image, out.data, out.bytes));
        image.format = PNG_FORMAT_RGBA;
        ck_assert(png_image_finish_read(&image, NULL, rgba, 0, NULL));
        for (int i = 0; i < W * H; i++) {
            pen_encode_8(pixels + 3 * i, 3, PEN_TRANSFER_SRGB, plain);
            if (!mask[i])
                ck_assert_mem_eq(rgba + 4 * i, "\0\0\0\0", 4);
            else
                ck_assert(rgba[4 * i + 3] == 255 && abs(rgba[4 * i] - plain[0]) <= 1 &&
                          abs(rgba[4 * i + 1] - plain[1]) <= 1 &&
                          abs(rgba[4 * i + 2] - plain[2]) <= 1);
        }
        pen_picture_free(read_back(&out));
        pen_buf_release(&out);
    }
}
END_TEST

START_TEST(test_files__pfm_keeps_every_bit)
{
    struct pen_film film = make_film();
    struct pen_buf out = {0};
    struct pen_status st;
    ck_assert(pen_pfm_write(&film, &out, &st));
    ck_assert_mem_eq(out.data, "PF\n13 9\n-1.0\n", 13);
    ck_assert_uint_eq(out.bytes, 13 + 4 * COUNT);
    /* The first value of the file is the bottom row's, little-endian. */
    uint32_t bits = (uint32_t)out.data[13] | (uint32_t)out.data[14] << 8 |
                    (uint32_t)out.data[15] << 16 | (uint32_t)out.data[16] << 24;
    ck_assert_mem_eq(&bits, &pixels[(H - 1) * W * 3], 4);
    struct pen_picture *picture = read_back(&out);
    for (int y = 0; y < H; y++) {
        double linear[W * 3], encoded[W * 3];
        pen_picture_linear_row(picture, y, linear);
        pen_picture_encoded_row(picture, y, encoded);
        for (int x = 0; x < W * 3; x++) {
            double v = (double)pixels[y * W * 3 + x];
            ck_assert(linear[x] == v && encoded[x] == pen_encode_unit(v, PEN_TRANSFER_SRGB));
        }
    }
    pen_picture_free(picture);
    pen_buf_release(&out);
}
END_TEST

/* Made in the memory of the film, it has the same bytes; and it fills a film of its size only. */
START_TEST(test_files__pfm_is_made_in_place)
{
    struct pen_film film = make_film(), made, read = {.width = W, .height = H};
    struct pen_buf out = {0}, in_place = {0};
    struct pen_status st;
    float values[COUNT];
    ck_assert(pen_pfm_write(&film, &out, &st));
    ck_assert(pen_pfm_begin(W, H, &in_place, &made, &st));
    memcpy(made.rgb, film.rgb, sizeof values);
    ck_assert(pen_pfm_end(&made, &in_place, &st));
    ck_assert_uint_eq(in_place.bytes, out.bytes);
    ck_assert_mem_eq(in_place.data, out.data, out.bytes + 1);
    read.rgb = values;
    ck_assert(pen_pfm_load(out.data, out.bytes, &read, &st));
    ck_assert_mem_eq(values, film.rgb, sizeof values);
    ck_assert(!pen_pfm_load(out.data, out.bytes - 1, &read, &st));
    ck_assert_int_eq(st.code, PEN_SYNTAX);
    read.width = H;
    read.height = W;
    ck_assert(!pen_pfm_load(out.data, out.bytes, &read, &st));
    ck_assert_int_eq(st.code, PEN_SYNTAX);
    ck_assert(!pen_pfm_load("QF", 2, &read, &st));
    pen_buf_release(&in_place);
    ck_assert(!pen_pfm_begin(0, 1, &in_place, &made, &st) && st.code == PEN_INVALID);
    ck_assert(!pen_pfm_begin(1 << 20, 65, &in_place, &made, &st) && st.code == PEN_TOO_LARGE);
    pen_buf_release(&out);
}
END_TEST

START_TEST(test_files__pfm_of_other_programs_is_read)
{
    const struct {
        const char *head, *data;
        size_t bytes;
        double red, blue;
    } rows[] = {{"PF\n1 1\n1.0\n", "\x3F\0\0\0\x3F\x80\0\0\x40\0\0\0", 12, 0.5, 2},
                {"PF 1 1 -2\r", "\0\0\0\x3F\0\0\x80\x3F\0\0\0\x40", 12, 1, 4},
                {"Pf\n1\t1\n-1\n", "\0\0\x80\x3F", 4, 1, 1},
                {"Pf\n1 1\n+1e0\n", "\x3F\x80\0\0", 4, 1, 1}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pen_buf file = {0};
        double linear[3];
        pen_buf_puts(&file, rows[i].head);
        pen_buf_add(&file, rows[i].data, rows[i].bytes);
        struct pen_picture *picture = read_back(&file);
        pen_picture_linear_row(picture, 0, linear);
        ck_assert_msg(linear[0] == rows[i].red && linear[2] == rows[i].blue, "row %zu: %g %g", i,
                      linear[0], linear[2]);
        pen_picture_free(picture);
        pen_buf_release(&file);
    }
}
END_TEST

static void expect_error(const void *bytes, size_t count, enum pen_code code)
{
    struct pen_status st = {PEN_OK, 0, 0, "", ""};
    ck_assert_ptr_null(pen_picture_read(bytes, count, &st));
    ck_assert_msg(st.code == code && st.msg[0], "%s: %s", pen_code_name(st.code), st.msg);
}

START_TEST(test_files__damaged_pfm_is_refused)
{
    const char *const damaged[] = {"PF\n1 1\n",
                                   "PF\n1 1\n-1.0",
                                   "PF\n1 1\n-1.0\n",
                                   "PF\n1 1\n-1.0\n12345678901",
                                   "PF\n1 1\n-1.0\n1234567890123",
                                   "PF\n0 1\n-1.0\n",
                                   "PF\n1 -1\n-1.0\n123456789012",
                                   "PF\n1.5 1\n-1.0\n123456789012",
                                   "PF\n1 1\n0\n123456789012",
                                   "PF\n1 1\nnan\n123456789012",
                                   "PF\n1 1\n-inf\n123456789012",
                                   "PF\nx 1\n-1.0\n123456789012",
                                   "PFM1 1\n-1.0\n123456789012",
                                   "PF\n1 1\n1111111111111111111111111111111111111111111\n1234",
                                   "PF\n1e30 1\n-1.0\n123456789012",
                                   "PF\n2147483647 2147483648\n-1.0\n123456789012",
                                   "Pf\n1 1\n-1.0\n\xFF\xFF\xFF\xFF",
                                   "PF\n1 1\n-1e30\n1234567890~~",
                                   "PF "};
    for (size_t i = 0; i < sizeof damaged / sizeof damaged[0]; i++)
        expect_error(damaged[i], strlen(damaged[i]), PEN_SYNTAX);
    const char *const large[] = {"PF\n8193 8192\n-1.0\n", "PF\n2147483647 2147483647\n-1.0\n",
                                 "PF\n1 2147483647\n-1.0\n"};
    for (size_t i = 0; i < sizeof large / sizeof large[0]; i++)
        expect_error(large[i], strlen(large[i]), PEN_TOO_LARGE);
    const char *const others[] = {
        "", "P", "PF", "P6\n1 1\n255\nabc", "\xFF\xD8\xFF", "{}", "\x89PNG\r\n\x1A"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        expect_error(others[i], strlen(others[i]), PEN_MEDIA_TYPE);
}
END_TEST

static void append(png_structp png, png_bytep data, size_t bytes)
{
    pen_buf_add(png_get_io_ptr(png), data, bytes);
}

struct kind {
    int type, bits;
    bool interlaced, transparent;
};

/* The value of a channel of a pixel in a test picture of that kind: a hash of its place. */
static unsigned sample(const struct kind *kind, int x, int y, int channel)
{
    unsigned max = kind->type == PNG_COLOR_TYPE_PALETTE ? 3u : (1u << kind->bits) - 1;
    return ((unsigned)(x * 7919 + y * 104729 + channel * 31) * 2654435761u >> 7) % (max + 1);
}

static const png_color palette[4] = {{1, 2, 3}, {100, 110, 120}, {255, 0, 7}, {50, 60, 70}};

/* A PNG of that kind, W x H, with the values of `sample`; it does not state a transfer function. */
static struct pen_buf write_kind(const struct kind *kind)
{
    struct pen_buf out = {0};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &out, append, NULL);
    png_set_IHDR(png, info, W, H, kind->bits, kind->type,
                 kind->interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, 0, 0);
    if (kind->type == PNG_COLOR_TYPE_PALETTE)
        png_set_PLTE(png, info, palette, 4);
    if (kind->transparent) {
        const png_color_16 key = {0, 1, 1, 1, 1};
        png_set_tRNS(png, info, (png_const_bytep) "\0\x80\xFF\x10", 4, &key);
    }
    png_write_info(png, info);
    int channels = png_get_channels(png, info);
    static unsigned char data[H][W * 4 * 2];
    png_bytep rows[H];
    memset(data, 0, sizeof data);
    for (int y = 0; y < H; y++) {
        rows[y] = data[y];
        for (int i = 0; i < W * channels; i++) {
            unsigned value = sample(kind, i / channels, y, i % channels);
            int bit = i * kind->bits;
            if (kind->bits == 16)
                data[y][2 * i] = (unsigned char)(value >> 8),
                            data[y][2 * i + 1] = (unsigned char)value;
            else
                data[y][bit / 8] |= (unsigned char)(value << (8 - kind->bits - bit % 8));
        }
    }
    png_write_image(png, rows);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    return out;
}

static const struct kind kinds[] = {
    {PNG_COLOR_TYPE_GRAY, 1, false, false},        {PNG_COLOR_TYPE_GRAY, 2, true, false},
    {PNG_COLOR_TYPE_GRAY, 4, false, true},         {PNG_COLOR_TYPE_GRAY, 8, true, true},
    {PNG_COLOR_TYPE_GRAY, 16, false, true},        {PNG_COLOR_TYPE_GRAY_ALPHA, 8, true, false},
    {PNG_COLOR_TYPE_GRAY_ALPHA, 16, false, false}, {PNG_COLOR_TYPE_PALETTE, 2, false, false},
    {PNG_COLOR_TYPE_PALETTE, 4, true, true},       {PNG_COLOR_TYPE_PALETTE, 8, false, true},
    {PNG_COLOR_TYPE_RGB, 8, true, true},           {PNG_COLOR_TYPE_RGB, 16, true, false},
    {PNG_COLOR_TYPE_RGB_ALPHA, 8, false, false},   {PNG_COLOR_TYPE_RGB_ALPHA, 16, true, false}};

enum { KINDS = sizeof kinds / sizeof kinds[0] };

static double expected(const struct kind *kind, int x, int y, int channel)
{
    if (kind->type == PNG_COLOR_TYPE_PALETTE) {
        const png_color *c = &palette[sample(kind, x, y, 0)];
        return (channel == 0 ? c->red : channel == 1 ? c->green : c->blue) / 255.0;
    }
    bool grey = !(kind->type & PNG_COLOR_MASK_COLOR);
    return sample(kind, x, y, grey ? 0 : channel) / (double)((1u << kind->bits) - 1);
}

static double expected_alpha(const struct kind *kind, int x, int y)
{
    static const int of_palette[4] = {0, 0x80, 0xFF, 0x10};
    const bool grey = !(kind->type & PNG_COLOR_MASK_COLOR);
    if (kind->type & PNG_COLOR_MASK_ALPHA)
        return sample(kind, x, y, grey ? 1 : 3) / (double)((1u << kind->bits) - 1);
    if (!kind->transparent)
        return 1;
    if (kind->type == PNG_COLOR_TYPE_PALETTE)
        return of_palette[sample(kind, x, y, 0)] / 255.0;
    for (int c = 0; c < (grey ? 1 : 3); c++)
        if (sample(kind, x, y, c) != 1)
            return 1;
    return 0;
}

START_TEST(test_files__every_kind_of_png_is_read)
{
    for (int k = 0; k < KINDS; k++) {
        struct pen_buf file = write_kind(&kinds[k]);
        struct pen_picture *picture = read_back(&file);
        for (int y = 0; y < H; y++) {
            double row[W * 3], alpha[W];
            pen_picture_encoded_row(picture, y, row);
            pen_picture_alpha_row(picture, y, alpha);
            for (int x = 0; x < W; x++)
                ck_assert_msg(alpha[x] == expected_alpha(&kinds[k], x, y), "kind %d at %d %d: %g",
                              k, x, y, alpha[x]);
            for (int x = 0; x < W * 3; x++) {
                double want = expected(&kinds[k], x / 3, y, x % 3);
                ck_assert_msg(fabs(row[x] - want) < 1e-15, "kind %d at %d %d: %g, not %g", k, x, y,
                              row[x], want);
            }
        }
        pen_picture_free(picture);
        pen_buf_release(&file);
    }
}
END_TEST

static uint32_t crc(const unsigned char *p, size_t bytes)
{
    uint32_t c = 0xFFFFFFFFu;
    for (size_t i = 0; i < bytes; i++) {
        c ^= p[i];
        for (int k = 0; k < 8; k++)
            c = c & 1 ? 0xEDB88320u ^ c >> 1 : c >> 1;
    }
    return ~c;
}

/* Recomputes the checksums, so that the decoders see the damaged data. */
static void repair_checksums(unsigned char *png, size_t bytes)
{
    for (size_t at = 8; at + 12 <= bytes;) {
        unsigned char *p = png + at;
        size_t length = (size_t)p[0] << 24 | (size_t)p[1] << 16 | (size_t)p[2] << 8 | p[3];
        if (length > bytes - at - 12)
            return;
        uint32_t c = crc(p + 4, length + 4);
        for (int i = 0; i < 4; i++)
            p[8 + length + (size_t)i] = (unsigned char)(c >> (24 - 8 * i));
        at += length + 12;
    }
}

/* Reads a copy that ends where its allocation ends, so that a sanitizer detects reads beyond. */
static bool try_read(const unsigned char *bytes, size_t count)
{
    struct pen_status st = {PEN_OK, 0, 0, "", ""};
    unsigned char *copy = malloc(count ? count : 1);
    memcpy(copy, bytes, count);
    struct pen_picture *picture = pen_picture_read(copy, count, &st);
    if (!picture && (st.code == PEN_OK || st.code == PEN_INTERNAL || !st.msg[0]))
        ck_abort_msg("%s: %s", pen_code_name(st.code), st.msg);
    if (picture) {
        double *row = malloc((size_t)pen_picture_width(picture) * 3 * sizeof *row);
        for (int y = 0; y < pen_picture_height(picture) && y < 100; y++)
            pen_picture_encoded_row(picture, y, row);
        free(row);
    }
    bool ok = picture != NULL;
    pen_picture_free(picture);
    free(copy);
    return ok;
}

START_TEST(test_files__every_truncated_png_is_refused)
{
    for (int k = 0; k < KINDS; k++) {
        struct pen_buf file = write_kind(&kinds[k]);
        for (size_t bytes = 0; bytes < file.bytes; bytes++) {
            if (try_read(file.data, bytes))
                ck_abort_msg("kind %d is read from %zu of %zu bytes", k, bytes, file.bytes);
        }
        ck_assert(try_read(file.data, file.bytes));
        pen_buf_release(&file);
    }
}
END_TEST

START_TEST(test_files__damaged_files_end_in_an_error_or_a_picture)
{
    struct random r = random_begin(7);
    struct pen_film film = make_film();
    struct pen_buf files[KINDS + 1] = {0};
    struct pen_status st;
    for (int k = 0; k < KINDS; k++)
        files[k] = write_kind(&kinds[k]);
    ck_assert(pen_pfm_write(&film, &files[KINDS], &st));
    int read = 0;
    for (int i = 0; i < 30000; i++) {
        const struct pen_buf *file = &files[random_below(&r, KINDS + 1)];
        unsigned char copy[4096];
        ck_assert_uint_lt(file->bytes, sizeof copy);
        memcpy(copy, file->data, file->bytes);
        uint32_t changes = 1 + random_below(&r, 4);
        for (uint32_t c = 0; c < changes; c++) {
            uint32_t place = random_below(&r, random_below(&r, 2) ? 64 : (uint32_t)file->bytes);
            if (random_below(&r, 2))
                copy[place] = (unsigned char)random_bits(&r);
            else
                copy[place] = (unsigned char)(copy[place] ^ 1 << random_below(&r, 8));
        }
        if (random_below(&r, 8))
            repair_checksums(copy, file->bytes);
        read += try_read(copy, file->bytes);
    }
    ck_assert_msg(read > 1000 && read < 29000, "%d of 30000 were read", read);
    for (int k = 0; k <= KINDS; k++)
        pen_buf_release(&files[k]);
}
END_TEST

/* A small file that claims to be huge is refused, without taking memory or time. */
START_TEST(test_files__png_size_is_bounded)
{
    struct pen_buf file = write_kind(&kinds[10]);
    unsigned char *ihdr = (unsigned char *)chunk(&file, "IHDR");
    memcpy(ihdr, "\x7F\xFF\xFF\xFF\x7F\xFF\xFF\xFF", 8);
    repair_checksums(file.data, file.bytes);
    expect_error(file.data, file.bytes, PEN_TOO_LARGE);
    memcpy(ihdr, "\0\0\x20\x01\0\0\x20\0", 8);
    repair_checksums(file.data, file.bytes);
    expect_error(file.data, file.bytes, PEN_TOO_LARGE);
    memcpy(ihdr, "\0\0\x20\0\0\0\x20\0",
           8); /* the largest size allowed, but the pixels are missing */
    repair_checksums(file.data, file.bytes);
    expect_error(file.data, file.bytes, PEN_SYNTAX);
    memcpy(ihdr, "\0\0\0\0\0\0\0\1", 8);
    repair_checksums(file.data, file.bytes);
    expect_error(file.data, file.bytes, PEN_SYNTAX);
    pen_buf_release(&file);
}
END_TEST

START_TEST(test_files__every_failed_allocation_is_an_error)
{
    struct pen_film film = make_film();
    struct pen_png_options options = {.bits = 16};
    struct pen_buf png = write_png(&film, options), pfm = {0};
    struct pen_status st;
    ck_assert(pen_pfm_write(&film, &pfm, &st));
    for (int work = 0; work < 4; work++) {
        bool refused = true;
        for (long n = 0; refused; n++) {
            struct pen_buf out = {0};
            struct pen_picture *picture = NULL;
            st.code = PEN_OK;
            alloc_fail_after(n);
            bool ok = work == 0   ? pen_png_write(&film, &options, &out, &st)
                      : work == 1 ? pen_pfm_write(&film, &out, &st)
                      : work == 2 ? (picture = pen_picture_read(png.data, png.bytes, &st)) != NULL
                                  : (picture = pen_picture_read(pfm.data, pfm.bytes, &st)) != NULL;
            refused = alloc_succeed();
            ck_assert_msg(ok == !refused, "work %d, allocation %ld: %d", work, n, ok);
            ck_assert_msg(ok || st.code == PEN_NO_MEMORY, "work %d, allocation %ld: %s", work, n,
                          st.msg);
            pen_picture_free(picture);
            pen_buf_release(&out);
            ck_assert_int_lt(n, 1000);
        }
    }
    pen_buf_release(&png);
    pen_buf_release(&pfm);
}
END_TEST

PEN_SUITE("files", test_files__png_holds_the_codes_of_the_formula,
          test_files__png_states_its_transfer, test_files__values_for_a_screen_stay_as_they_are,
          test_files__pixels_not_rendered_yet_are_transparent, test_files__pfm_keeps_every_bit,
          test_files__pfm_is_made_in_place, test_files__pfm_of_other_programs_is_read,
          test_files__damaged_pfm_is_refused, test_files__every_kind_of_png_is_read,
          test_files__every_truncated_png_is_refused,
          test_files__damaged_files_end_in_an_error_or_a_picture, test_files__png_size_is_bounded,
          test_files__every_failed_allocation_is_an_error)
