/* SPDX-License-Identifier: MIT */
/* PFM, Debevec's portable float map: "PF", width, height and a scale, whose sign states the byte
 * order (negative: little-endian), then rows of binary32 triples from the bottom up. "Pf" is grey.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/encode.h"
#include "film/internal/picture.h"

static void put_little_endian(unsigned char *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++)
        to[i] = (unsigned char)(bits >> 8 * i);
}

bool pen_pfm_write(const struct pen_film *film, struct pen_buf *out, struct pen_status *st)
{
    size_t count = (size_t)film->width * 3;
    pen_buf_printf(out, "PF\n%d %d\n-1.0\n", film->width, film->height);
    for (int y = film->height - 1; y >= 0; y--) {
        const float *row = film->rgb + (size_t)y * count;
        unsigned char bytes[4 * 3 * 64];
        for (size_t i = 0; i < count;) {
            size_t part = count - i < 3 * 64 ? count - i : 3 * 64;
            for (size_t j = 0; j < part; j++)
                put_little_endian(bytes + 4 * j, row[i + j]);
            pen_buf_add(out, bytes, 4 * part);
            i += part;
        }
    }
    return !out->failed || pen_fail(st, PEN_NO_MEMORY, "no memory to write PFM");
}

/* What remains of a file being read. */
struct input {
    const unsigned char *at;
    size_t left;
};

static bool is_space(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Reads the next word and the one white space after it. False if the word is longer than `bytes`
 * allows or no white space follows. */
static bool next_word(struct input *in, char *word, size_t bytes)
{
    size_t length = 0;
    while (in->left > 0 && is_space(*in->at))
        in->at++, in->left--;
    while (in->left > 0 && !is_space(*in->at) && length + 1 < bytes) {
        word[length++] = (char)*in->at;
        in->at++, in->left--;
    }
    word[length] = '\0';
    if (length == 0 || in->left == 0 || !is_space(*in->at))
        return false;
    in->at++, in->left--;
    return true;
}

static bool next_number(struct input *in, double *value)
{
    char word[32], *end;
    if (!next_word(in, word, sizeof word))
        return false;
    *value = strtod(word, &end);
    return *end == '\0' && isfinite(*value);
}

static float get_float(const unsigned char *from, bool little)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= (uint32_t)from[little ? i : 3 - i] << 8 * i;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Fills the samples from the file's rows, which run from the bottom up; `channels` 1 is grey.
 * Returns false if a value is not finite. */
static bool fill(struct pen_picture *picture, const unsigned char *data, size_t channels,
                 double scale)
{
    float *out = picture->owned;
    size_t width = (size_t)picture->width, height = (size_t)picture->height;
    for (size_t y = 0; y < height; y++) {
        const unsigned char *row = data + (height - 1 - y) * width * channels * 4;
        for (size_t i = 0; i < width * 3; i++) {
            const unsigned char *from = row + 4 * (channels == 3 ? i : i / 3);
            *out = (float)((double)get_float(from, scale < 0) * fabs(scale));
            if (!isfinite(*out++))
                return false;
        }
    }
    return true;
}

struct pen_picture *pen_pfm_read(const unsigned char *bytes, size_t count, struct pen_status *st)
{
    struct input in = {.at = bytes, .left = count};
    char magic[3];
    double width, height, scale;
    if (!next_word(&in, magic, sizeof magic) || !next_number(&in, &width) ||
        !next_number(&in, &height) || !next_number(&in, &scale) || scale == 0 ||
        !(width >= 1 && width <= INT32_MAX && width == floor(width)) ||
        !(height >= 1 && height <= INT32_MAX && height == floor(height))) {
        pen_fail(st, PEN_SYNTAX, "cannot read PFM: its head is not PF, width, height and scale");
        return NULL;
    }
    size_t channels = magic[1] == 'F' ? 3 : 1;
    uint64_t pixels = (uint64_t)width * (uint64_t)height;
    if (pixels <= PEN_FILM_PIXELS_MAX && in.left != pixels * channels * 4) {
        pen_fail(st, PEN_SYNTAX, "cannot read PFM: %zu bytes of pixels where %llu belong", in.left,
                 (unsigned long long)(pixels * channels * 4));
        return NULL;
    }
    struct pen_picture *picture =
        pen_picture_new((int64_t)width, (int64_t)height, PICTURE_FLOAT, st);
    if (!picture || fill(picture, in.at, channels, scale))
        return picture;
    pen_picture_free(picture);
    pen_fail(st, PEN_SYNTAX, "cannot read PFM: a value is not finite");
    return NULL;
}
