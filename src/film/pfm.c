/* SPDX-License-Identifier: MIT */
/* PFM, Debevec's portable float map: "PF", width, height and a scale. The sign of the scale states
 * the byte order (negative: little-endian). Then follow rows of binary32 triples from the bottom
 * up. "Pf" is grey. */
#include <math.h>
#include <stdio.h>
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

/* The offset of the pixels while they are set: after the longest head, aligned. */
enum { PIXELS_AT = 64 };

bool pen_pfm_begin(int width, int height, struct pen_buf *out, struct pen_film *film,
                   struct pen_status *st)
{
    if (width < 1 || height < 1)
        return pen_fail(st, PEN_INVALID, "an image of %d x %d pixels has none", width, height);
    if ((int64_t)width * height > PEN_FILM_PIXELS_MAX)
        return pen_fail(st, PEN_TOO_LARGE, "%d x %d are more than %d pixels", width, height,
                        PEN_FILM_PIXELS_MAX);
    const size_t bytes = (size_t)width * (size_t)height * 3 * sizeof(float);
    unsigned char *data = malloc(PIXELS_AT + bytes + 1);
    if (!data)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %d x %d pixels", width, height);
    *out = (struct pen_buf){
        .data = data, .bytes = PIXELS_AT + bytes, .capacity = PIXELS_AT + bytes + 1};
    *film = (struct pen_film){
        .width = width, .height = height, .rgb = (float *)(void *)(data + PIXELS_AT)};
    return true;
}

/* Converts a row of the film to one of the file, in place. */
static void make_little_endian(float *row, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const float value = row[i];
        put_little_endian((unsigned char *)&row[i], value);
    }
}

bool pen_pfm_end(struct pen_film *film, struct pen_buf *out, struct pen_status *st)
{
    const size_t count = (size_t)film->width * 3, height = (size_t)film->height;
    const size_t bytes = count * height * sizeof(float);
    float *spare = malloc(count * sizeof *spare);
    if (!spare)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to write PFM");
    for (size_t y = 0; y < height; y++)
        make_little_endian(film->rgb + y * count, count);
    for (size_t y = 0; y < height / 2; y++) {
        float *upper = film->rgb + y * count, *lower = film->rgb + (height - 1 - y) * count;
        memcpy(spare, upper, count * sizeof *spare);
        memcpy(upper, lower, count * sizeof *spare);
        memcpy(lower, spare, count * sizeof *spare);
    }
    free(spare);
    const int head =
        snprintf((char *)out->data, PIXELS_AT, "PF\n%d %d\n-1.0\n", film->width, film->height);
    memmove(out->data + head, out->data + PIXELS_AT, bytes);
    out->bytes = (size_t)head + bytes;
    out->data[out->bytes] = '\0';
    film->rgb = NULL;
    return true;
}

/* The rest of a file that is being read. */
struct input {
    const unsigned char *at;
    size_t left;
};

static bool is_space(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Reads the next word and the one white space after it. Returns false if the word does not fit into
 * `bytes` or no white space follows. */
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

/* A PFM file whose head was read. */
struct pfm {
    int64_t width, height;
    size_t channels; /* 1: grey */
    double scale;
    const unsigned char *rows; /* from the bottom up */
};

/* Reads the head, and checks that the number of pixels that it states follows. */
static bool read_head(const unsigned char *bytes, size_t count, struct pfm *pfm,
                      struct pen_status *st)
{
    struct input in = {.at = bytes, .left = count};
    char magic[3];
    double width, height, scale;
    if (!next_word(&in, magic, sizeof magic) || !next_number(&in, &width) ||
        !next_number(&in, &height) || !next_number(&in, &scale) || scale == 0 ||
        !(width >= 1 && width <= INT32_MAX && width == floor(width)) ||
        !(height >= 1 && height <= INT32_MAX && height == floor(height)))
        return pen_fail(st, PEN_SYNTAX,
                        "cannot read PFM: its head is not PF, width, height and scale");
    size_t channels = magic[1] == 'F' ? 3 : 1;
    uint64_t pixels = (uint64_t)width * (uint64_t)height;
    if (pixels <= PEN_FILM_PIXELS_MAX && in.left != pixels * channels * 4)
        return pen_fail(st, PEN_SYNTAX, "cannot read PFM: %zu bytes of pixels where %llu belong",
                        in.left, (unsigned long long)(pixels * channels * 4));
    *pfm = (struct pfm){.width = (int64_t)width,
                        .height = (int64_t)height,
                        .channels = channels,
                        .scale = scale,
                        .rows = in.at};
    return true;
}

/* Fills `out` from the file's rows. */
static bool fill(const struct pfm *pfm, float *out, struct pen_status *st)
{
    const size_t width = (size_t)pfm->width, height = (size_t)pfm->height;
    for (size_t y = 0; y < height; y++) {
        const unsigned char *row = pfm->rows + (height - 1 - y) * width * pfm->channels * 4;
        for (size_t i = 0; i < width * 3; i++) {
            const unsigned char *from = row + 4 * (pfm->channels == 3 ? i : i / 3);
            *out = (float)((double)get_float(from, pfm->scale < 0) * fabs(pfm->scale));
            if (!isfinite(*out++))
                return pen_fail(st, PEN_SYNTAX, "cannot read PFM: a value is not finite");
        }
    }
    return true;
}

struct pen_picture *pen_pfm_read(const unsigned char *bytes, size_t count, struct pen_status *st)
{
    struct pfm pfm;
    if (!read_head(bytes, count, &pfm, st))
        return NULL;
    struct pen_picture *picture = pen_picture_new(pfm.width, pfm.height, 3, PICTURE_FLOAT, st);
    if (!picture || fill(&pfm, picture->owned, st))
        return picture;
    pen_picture_free(picture);
    return NULL;
}

bool pen_pfm_load(const void *data, size_t bytes, struct pen_film *film, struct pen_status *st)
{
    struct pfm pfm;
    if (bytes < 2 || memcmp(data, "PF", 2) != 0)
        return pen_fail(st, PEN_SYNTAX, "cannot read PFM: it does not begin with PF");
    if (!read_head(data, bytes, &pfm, st))
        return false;
    if (pfm.width != film->width || pfm.height != film->height)
        return pen_fail(st, PEN_SYNTAX, "the PFM has %lld x %lld pixels where %d x %d belong",
                        (long long)pfm.width, (long long)pfm.height, film->width, film->height);
    return fill(&pfm, film->rgb, st);
}
