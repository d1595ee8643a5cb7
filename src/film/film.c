/* SPDX-License-Identifier: MIT */
/* Films and their hash. */
#include "film/film.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

struct pen_film *pen_film_new(int width, int height, struct pen_status *st)
{
    if (width < 1 || height < 1) {
        pen_fail(st, PEN_INVALID, "an image of %d x %d pixels has none", width, height);
        return NULL;
    }
    if ((int64_t)width * height > PEN_FILM_PIXELS_MAX) {
        pen_fail(st, PEN_TOO_LARGE, "%d x %d are more than %d pixels", width, height,
                 PEN_FILM_PIXELS_MAX);
        return NULL;
    }
    struct pen_film *film = malloc(sizeof *film);
    float *rgb = pen_memory_large_zeroed((size_t)width * (size_t)height * 3 * sizeof *rgb);
    if (!film || !rgb) {
        free(film);
        free(rgb);
        pen_fail(st, PEN_NO_MEMORY, "no memory for %d x %d pixels", width, height);
        return NULL;
    }
    *film = (struct pen_film){.width = width, .height = height, .rgb = rgb};
    return film;
}

void pen_film_free(struct pen_film *film)
{
    if (!film)
        return;
    free(film->rgb);
    free(film);
}

/* Mixes 64 bits into the hash. For a given word this is a bijection of the hash, so different
 * hashes stay different. */
static uint64_t mix(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * UINT64_C(0x9E3779B97F4A7C15);
    return hash ^ hash >> 32;
}

static uint32_t float_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

uint64_t pen_film_hash(const struct pen_film *film)
{
    size_t count = (size_t)film->width * (size_t)film->height * 3;
    uint64_t hash = mix((uint64_t)film->width << 32 | (uint32_t)film->height, count);
    size_t i = 0;
    for (; i + 1 < count; i += 2) {
        uint64_t low = float_bits(film->rgb[i]), high = float_bits(film->rgb[i + 1]);
        hash = mix(hash, high << 32 | low);
    }
    if (i < count)
        hash = mix(hash, float_bits(film->rgb[i]));
    return mix(hash, 0);
}
