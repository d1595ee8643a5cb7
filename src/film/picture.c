/* SPDX-License-Identifier: MIT */
/* Pictures in memory: returns rows, encoded or linear, for every type of samples. */
#include "film/internal/picture.h"

#include <stdlib.h>
#include <string.h>

#include "film/encode.h"

static const size_t sample_bytes[] = {
    [PICTURE_8] = 1, [PICTURE_16] = sizeof(uint16_t), [PICTURE_FLOAT] = sizeof(float)};

struct pen_picture *pen_picture_new(int64_t width, int64_t height, int channels,
                                    enum picture_kind kind, struct pen_status *st)
{
    if (width < 1 || height < 1) {
        pen_fail(st, PEN_SYNTAX, "the picture has no pixels");
        return NULL;
    }
    if (width > PEN_FILM_PIXELS_MAX || height > PEN_FILM_PIXELS_MAX ||
        width * height > PEN_FILM_PIXELS_MAX) {
        pen_fail(st, PEN_TOO_LARGE, "the picture has more than %d pixels", PEN_FILM_PIXELS_MAX);
        return NULL;
    }
    struct pen_picture *picture = calloc(1, sizeof *picture);
    void *samples = calloc((size_t)(width * height), (size_t)channels * sample_bytes[kind]);
    if (!picture || !samples) {
        free(picture);
        free(samples);
        pen_fail(st, PEN_NO_MEMORY, "no memory for the picture's pixels");
        return NULL;
    }
    *picture = (struct pen_picture){.width = (int)width,
                                    .height = (int)height,
                                    .channels = channels,
                                    .kind = kind,
                                    .transfer = kind == PICTURE_FLOAT ? PEN_TRANSFER_LINEAR
                                                                      : PEN_TRANSFER_SRGB,
                                    .samples = samples,
                                    .owned = samples};
    for (int code = 0; kind == PICTURE_8 && code < 256; code++)
        picture->decoded[code] = pen_decode_srgb(code / 255.0);
    return picture;
}

struct pen_picture *pen_picture_of_film(const struct pen_film *film, enum pen_transfer transfer,
                                        struct pen_status *st)
{
    struct pen_picture *picture = calloc(1, sizeof *picture);
    if (!picture) {
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
        return NULL;
    }
    *picture = (struct pen_picture){
        .width = film->width,
        .height = film->height,
        .channels = 3,
        .kind = PICTURE_FLOAT,
        .transfer = transfer == PEN_TRANSFER_DISPLAY ? transfer : PEN_TRANSFER_LINEAR,
        .samples = film->rgb};
    return picture;
}

struct pen_picture *pen_picture_take_film(struct pen_film *film, enum pen_transfer transfer,
                                          struct pen_status *st)
{
    struct pen_picture *picture = pen_picture_of_film(film, transfer, st);
    if (picture) {
        picture->owned = film->rgb;
        film->rgb = NULL;
    }
    pen_film_free(film);
    return picture;
}

void pen_picture_set_linear(struct pen_picture *picture)
{
    picture->transfer = PEN_TRANSFER_LINEAR;
}

bool pen_picture_match(struct pen_picture *a, struct pen_picture *b)
{
    if (a->transfer == b->transfer)
        return false;
    const size_t bytes =
        (size_t)a->width * (size_t)a->height * (size_t)a->channels * sample_bytes[a->kind];
    const bool same = a->kind == b->kind && a->channels == b->channels && a->width == b->width &&
                      a->height == b->height && memcmp(a->samples, b->samples, bytes) == 0;
    const struct pen_picture *shown = a->transfer == PEN_TRANSFER_DISPLAY ? a : b,
                             *other = shown == a ? b : a;
    if (same || (shown->transfer == PEN_TRANSFER_DISPLAY &&
                 (other->kind == PICTURE_FLOAT || other->transfer == PEN_TRANSFER_SRGB)))
        a->transfer = b->transfer = PEN_TRANSFER_DISPLAY;
    return same;
}

void pen_picture_free(struct pen_picture *picture)
{
    if (!picture)
        return;
    free(picture->owned);
    free(picture);
}

int pen_picture_width(const struct pen_picture *picture)
{
    return picture->width;
}

int pen_picture_height(const struct pen_picture *picture)
{
    return picture->height;
}

/* The index of a pixel's first sample. */
static size_t first_sample(const struct pen_picture *picture, int x, int y)
{
    return ((size_t)y * (size_t)picture->width + (size_t)x) * (size_t)picture->channels;
}

/* The index of the next sample that is not alpha. */
static size_t next_colour(const struct pen_picture *picture, size_t sample)
{
    return sample + 1 + (picture->channels == 4 && sample % 4 == 2);
}

/* A part of a row as in the file: integers divided by their maximum, floats unchanged. */
static void stored_part(const struct pen_picture *picture, struct pen_picture_part part,
                        double *out)
{
    const size_t count = (size_t)part.count * 3;
    size_t at = first_sample(picture, part.x, part.y);
    const unsigned char *codes = picture->samples;
    const uint16_t *wide = picture->samples;
    const float *values = picture->samples;
    switch (picture->kind) {
    case PICTURE_8:
        for (size_t i = 0; i < count; i++, at = next_colour(picture, at))
            out[i] = codes[at] / 255.0;
        break;
    case PICTURE_16:
        for (size_t i = 0; i < count; i++, at = next_colour(picture, at))
            out[i] = wide[at] / 65535.0;
        break;
    case PICTURE_FLOAT:
        for (size_t i = 0; i < count; i++)
            out[i] = (double)values[at + i];
        break;
    }
}

void pen_picture_encoded_part(const struct pen_picture *picture, struct pen_picture_part part,
                              double *out)
{
    const bool linear = picture->transfer == PEN_TRANSFER_LINEAR;
    stored_part(picture, part, out);
    if (!linear && picture->kind != PICTURE_FLOAT)
        return;
    for (size_t i = 0; i < (size_t)part.count * 3; i++)
        out[i] = pen_encode_unit(out[i], linear ? PEN_TRANSFER_SRGB : PEN_TRANSFER_DISPLAY);
}

/* A part of a row of 8-bit screen codes, by the table. */
static void decoded_part(const struct pen_picture *picture, struct pen_picture_part part,
                         double *out)
{
    const unsigned char *codes = picture->samples;
    size_t at = first_sample(picture, part.x, part.y);
    for (size_t i = 0; i < (size_t)part.count * 3; i++, at = next_colour(picture, at))
        out[i] = picture->decoded[codes[at]];
}

void pen_picture_alpha_row(const struct pen_picture *picture, int y, double *out)
{
    const unsigned char *codes = picture->samples;
    const uint16_t *wide = picture->samples;
    size_t at = first_sample(picture, 0, y) + 3;
    for (int x = 0; x < picture->width; x++, at += 4) {
        if (picture->channels == 3)
            out[x] = 1;
        else
            out[x] = picture->kind == PICTURE_16 ? wide[at] / 65535.0 : codes[at] / 255.0;
    }
}

bool pen_picture_is_pfm(const struct pen_picture *picture)
{
    return picture->kind == PICTURE_FLOAT && picture->owned;
}

void pen_picture_linear_part(const struct pen_picture *picture, struct pen_picture_part part,
                             double *out)
{
    if (picture->transfer == PEN_TRANSFER_LINEAR) {
        stored_part(picture, part, out);
        return;
    }
    if (picture->kind == PICTURE_8) {
        decoded_part(picture, part, out);
        return;
    }
    pen_picture_encoded_part(picture, part, out);
    for (size_t i = 0; i < (size_t)part.count * 3; i++)
        out[i] = pen_decode_srgb(out[i]);
}

void pen_picture_encoded_row(const struct pen_picture *picture, int y, double *out)
{
    pen_picture_encoded_part(picture, (struct pen_picture_part){0, y, picture->width}, out);
}

void pen_picture_linear_row(const struct pen_picture *picture, int y, double *out)
{
    pen_picture_linear_part(picture, (struct pen_picture_part){0, y, picture->width}, out);
}
