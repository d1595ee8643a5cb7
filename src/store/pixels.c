/* SPDX-License-Identifier: MIT */
/* The stored form of a batch's pixels. Its first byte tells which:
 *
 *   0x02   this build's: after the byte, slices, each
 *            pixels   32 bits, the lowest byte first
 *            bytes    32 bits, of the frame
 *            frame    zstd, of 4 planes of 3 * pixels bytes
 *   0x28   the one before: one zstd frame (this is its first byte) of 3 times 4 planes of `pixels`
 *          bytes, one channel after the other. It is read for as long as stores have it.
 *
 * Of each value the difference to the same channel of the pixel before is kept (in a slice, the
 * first pixel's to 0), as integers of the floats' bits, the sign moved to the lowest bit; plane k
 * holds byte k of all differences, red, green, blue, red …. The planes of the high bytes are nearly
 * zero, and those of the low ones are noise that zstd passes over quickly. Slices let packing begin
 * while a batch is still being rendered, and stay in the processor's cache.
 *
 * On the built-in room at 1000x1400 zstd's level -1 takes two thirds of the time of level 1 and
 * makes 0.394 of the size instead of 0.392; from -5 on the pixels grow faster than the time for
 * them falls, since every byte is also written twice, into the log and from there into the file. */
#include "store/pixels.h"

#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "store/internal/compress.h"

enum { LEVEL = -1, FORM = 0x02, FORM_BEFORE = 0x28, PIXEL_BYTES = 12, HEAD_BYTES = 8 };

struct pen_pixels {
    struct pen_compressor *packer;
    unsigned char *planes; /* of one slice */
    struct pen_buf packed;
    int64_t count;
};

struct pen_pixels *pen_pixels_new(void)
{
    struct pen_pixels *pixels = calloc(1, sizeof *pixels);
    if (!pixels)
        return NULL;
    pixels->packer = pen_compressor_new(LEVEL);
    pixels->planes = malloc((size_t)PEN_PIXELS_SLICE * PIXEL_BYTES);
    if (pixels->packer && pixels->planes)
        return pixels;
    pen_pixels_free(pixels);
    return NULL;
}

void pen_pixels_free(struct pen_pixels *pixels)
{
    if (!pixels)
        return;
    pen_compressor_free(pixels->packer);
    free(pixels->planes);
    pen_buf_release(&pixels->packed);
    free(pixels);
}

void pen_pixels_begin(struct pen_pixels *pixels)
{
    static const unsigned char form = FORM;
    pixels->packed.bytes = 0;
    pixels->packed.failed = false;
    pixels->count = 0;
    pen_buf_add(&pixels->packed, &form, 1);
}

int64_t pen_pixels_count(const struct pen_pixels *pixels)
{
    return pixels->count;
}

struct pen_bytes pen_pixels_encoded(const struct pen_pixels *pixels)
{
    return (struct pen_bytes){pixels->packed.data, pixels->packed.bytes};
}

/* Splits `count` values into four planes of as many bytes. */
static void split(const float *restrict values, size_t count, unsigned char *restrict planes)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t bits, before = 0, difference;
        memcpy(&bits, &values[i], sizeof bits);
        if (i >= 3)
            memcpy(&before, &values[i - 3], sizeof before);
        difference = bits - before;
        difference = difference << 1 ^ (0 - (difference >> 31));
        planes[i] = (unsigned char)difference;
        planes[count + i] = (unsigned char)(difference >> 8);
        planes[2 * count + i] = (unsigned char)(difference >> 16);
        planes[3 * count + i] = (unsigned char)(difference >> 24);
    }
}

static uint32_t value_at(const unsigned char *planes, size_t count, size_t i)
{
    uint32_t difference = planes[i] | (uint32_t)planes[count + i] << 8 |
                          (uint32_t)planes[2 * count + i] << 16 |
                          (uint32_t)planes[3 * count + i] << 24;
    return difference >> 1 ^ (0 - (difference & 1));
}

/* The inverse of split. */
static void join(const unsigned char *planes, size_t count, float *values)
{
    uint32_t before[3] = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        uint32_t bits = before[0] + value_at(planes, count, i);
        before[0] = before[1];
        before[1] = before[2];
        before[2] = bits;
        memcpy(&values[i], &bits, sizeof bits);
    }
}

/* The same for one channel of the form before; its values are a pixel apart. */
static void join_channel(const unsigned char *planes, size_t pixels, float *values)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < pixels; i++) {
        bits += value_at(planes, pixels, i);
        memcpy(&values[3 * i], &bits, sizeof bits);
    }
}

static void put_32(unsigned char *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (unsigned char)(value >> 8 * i);
}

static uint32_t get_32(const unsigned char *from)
{
    return from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 | (uint32_t)from[3] << 24;
}

static bool add_slice(struct pen_pixels *pixels, const float *rgb, size_t count,
                      struct pen_status *st)
{
    unsigned char head[HEAD_BYTES];
    struct pen_bytes frame;
    split(rgb, 3 * count, pixels->planes);
    if (!pen_compress(pixels->packer, pixels->planes, count * PIXEL_BYTES, &frame, st)) {
        pixels->packed.failed = true;
        return false;
    }
    put_32(head, (uint32_t)count);
    put_32(head + 4, (uint32_t)frame.bytes);
    pen_buf_add(&pixels->packed, head, sizeof head);
    if (!pen_buf_add(&pixels->packed, frame.data, frame.bytes))
        return pen_fail(st, PEN_NO_MEMORY, "no memory for packed pixels");
    pixels->count += (int64_t)count;
    return true;
}

bool pen_pixels_add(struct pen_pixels *pixels, const float *rgb, int64_t count,
                    struct pen_status *st)
{
    if (pixels->packed.failed)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for packed pixels");
    while (count > 0) {
        int64_t n = count < PEN_PIXELS_SLICE ? count : PEN_PIXELS_SLICE;
        if (!add_slice(pixels, rgb, (size_t)n, st))
            return false;
        rgb += 3 * n;
        count -= n;
    }
    return true;
}

static bool damaged(struct pen_status *st, const char *how)
{
    return pen_fail(st, PEN_STORAGE, "stored pixels are damaged: %s", how);
}

/* Unpacks what must become `bytes` bytes. */
static bool unpack_planes(struct pen_compressor *packer, const unsigned char *frame,
                          size_t frame_bytes, size_t bytes, const unsigned char **planes,
                          struct pen_status *st)
{
    struct pen_bytes out;
    if (!pen_decompress(packer, frame, frame_bytes, &out, st))
        return false;
    *planes = out.data;
    return out.bytes == bytes || damaged(st, "not as many as there should be");
}

static bool unpack_slices(struct pen_compressor *packer, const struct pen_bytes *in, float *rgb,
                          uint64_t count, struct pen_status *st)
{
    const unsigned char *at = in->data, *end = at + in->bytes, *planes;
    at++; /* the form */
    while (end - at > HEAD_BYTES) {
        uint32_t pixels = get_32(at), bytes = get_32(at + 4);
        at += HEAD_BYTES;
        if (pixels > count || bytes > (size_t)(end - at))
            return damaged(st, "a slice is too large");
        if (!unpack_planes(packer, at, bytes, (size_t)pixels * PIXEL_BYTES, &planes, st))
            return false;
        join(planes, 3 * (size_t)pixels, rgb);
        at += bytes;
        rgb += 3 * (size_t)pixels;
        count -= pixels;
    }
    return (at == end && count == 0) || damaged(st, "some are missing");
}

static bool unpack_form_before(struct pen_compressor *packer, const struct pen_bytes *in,
                               float *rgb, size_t count, struct pen_status *st)
{
    const unsigned char *planes;
    if (!unpack_planes(packer, in->data, in->bytes, count * PIXEL_BYTES, &planes, st))
        return false;
    for (size_t channel = 0; channel < 3; channel++)
        join_channel(planes + 4 * channel * count, count, rgb + channel);
    return true;
}

bool pen_pixels_decode(struct pen_compressor *packer, const struct pen_bytes *in, float *rgb,
                       int64_t count, struct pen_status *st)
{
    int form = in->bytes > 0 ? *(const unsigned char *)in->data : 0;
    if (form == FORM)
        return unpack_slices(packer, in, rgb, (uint64_t)count, st);
    if (form == FORM_BEFORE)
        return unpack_form_before(packer, in, rgb, (size_t)count, st);
    return damaged(st, "their form is not known");
}
