/* SPDX-License-Identifier: MIT */
/* The stored form of a batch's pixels. The first byte names the form:
 *
 *   0x02   the form that this build writes. After the byte come slices, each of
 *            pixels   32 bits, lowest byte first
 *            bytes    32 bits, length of the frame
 *            frame    zstd, of 4 planes of 3 * pixels bytes
 *
 * How values become planes:
 *   1. Each float is taken as a 32-bit integer. The integer of the same channel of the previous
 *      pixel is subtracted (0 before the first pixel of a slice).
 *   2. The sign of the difference moves to the lowest bit.
 *   3. Plane k holds byte k of all differences: red, green, blue, red, …
 * The planes of the high bytes are nearly zero. The planes of the low bytes are noise, which zstd
 * skips quickly. A slice fits the processor's cache.
 *
 * Level: on the built-in room at 1000x1400, zstd's level -1 takes two thirds of the time of level 1
 * and produces 0.394 of the size instead of 0.392. From level -5 on, the size grows faster than the
 * time falls, because every byte is written twice: to the log and to the file. */
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "store/internal/compress.h"

enum { LEVEL = -1, FORM = 0x02, PIXEL_BYTES = 12, HEAD_BYTES = 8 };
_Static_assert(PIXEL_BYTES == 3 * sizeof(float), "a pixel is three floats");

struct pen_pixels {
    struct pen_compressor *compressor;
    unsigned char *planes; /* of one slice */
    struct pen_buf encoded;
};

struct pen_pixels *pen_pixels_new(void)
{
    struct pen_pixels *pixels = calloc(1, sizeof *pixels);
    if (!pixels)
        return NULL;
    pixels->compressor = pen_compressor_new(LEVEL);
    pixels->planes = malloc((size_t)PEN_PIXELS_SLICE * PIXEL_BYTES);
    if (pixels->compressor && pixels->planes)
        return pixels;
    pen_pixels_free(pixels);
    return NULL;
}

void pen_pixels_free(struct pen_pixels *pixels)
{
    if (!pixels)
        return;
    pen_compressor_free(pixels->compressor);
    free(pixels->planes);
    pen_buf_release(&pixels->encoded);
    free(pixels);
}

/* Writes `count` values as four planes of `count` bytes each. */
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
    if (!pen_compress(pixels->compressor, pixels->planes, count * PIXEL_BYTES, &frame, st))
        return false;
    put_32(head, (uint32_t)count);
    put_32(head + 4, (uint32_t)frame.bytes);
    pen_buf_add(&pixels->encoded, head, sizeof head);
    return pen_buf_add(&pixels->encoded, frame.data, frame.bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for encoded pixels");
}

bool pen_pixels_encode(struct pen_pixels *pixels, const float *rgb, int64_t count,
                       struct pen_bytes *out, struct pen_status *st)
{
    static const unsigned char form = FORM;
    pixels->encoded.bytes = 0;
    pixels->encoded.failed = false;
    pen_buf_add(&pixels->encoded, &form, 1);
    while (count > 0) {
        const int64_t n = count < PEN_PIXELS_SLICE ? count : PEN_PIXELS_SLICE;
        if (!add_slice(pixels, rgb, (size_t)n, st))
            return false;
        rgb += 3 * n;
        count -= n;
    }
    *out = (struct pen_bytes){pixels->encoded.data, pixels->encoded.bytes};
    return true;
}

static bool damaged(struct pen_status *st, const char *how)
{
    return pen_fail(st, PEN_STORAGE, "stored pixels are damaged: %s", how);
}

/* Decompresses a frame; fails unless it has `bytes` bytes. */
static bool decode_planes(struct pen_compressor *compressor, const unsigned char *frame,
                          size_t frame_bytes, size_t bytes, const unsigned char **planes,
                          struct pen_status *st)
{
    struct pen_bytes out;
    if (!pen_decompress(compressor, frame, frame_bytes, &out, st))
        return false;
    *planes = out.data;
    return out.bytes == bytes || damaged(st, "a frame has the wrong number of bytes");
}

static bool decode_slices(struct pen_compressor *compressor, const struct pen_bytes *in, float *rgb,
                          uint64_t count, struct pen_status *st)
{
    const unsigned char *at = in->data, *end = at + in->bytes, *planes;
    at++; /* the form */
    while (end - at > HEAD_BYTES) {
        uint32_t pixels = get_32(at), bytes = get_32(at + 4);
        at += HEAD_BYTES;
        if (pixels > count || bytes > (size_t)(end - at))
            return damaged(st, "a slice has more pixels or bytes than are left");
        if (!decode_planes(compressor, at, bytes, (size_t)pixels * PIXEL_BYTES, &planes, st))
            return false;
        join(planes, 3 * (size_t)pixels, rgb);
        at += bytes;
        rgb += 3 * (size_t)pixels;
        count -= pixels;
    }
    return (at == end && count == 0) || damaged(st, "pixels are missing, or bytes follow them");
}

bool pen_pixels_decode(struct pen_compressor *compressor, const struct pen_bytes *in, float *rgb,
                       int64_t count, struct pen_status *st)
{
    int form = in->bytes > 0 ? *(const unsigned char *)in->data : 0;
    return form == FORM ? decode_slices(compressor, in, rgb, (uint64_t)count, st)
                        : damaged(st, "their form is unknown");
}
