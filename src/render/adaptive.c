/* SPDX-License-Identifier: MIT */
/* The state of an adaptive render, and its estimates. */
#include "render/adaptive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "film/encode.h"
#include "render/internal/beams.h"
#include "render/transfer.h"

static size_t pixels_of(const struct pen_adaptive *a)
{
    return (size_t)a->settings->width * (size_t)a->settings->height;
}

/* The bytes of a state's arrays per pixel. The arrays with the strictest alignment are first. */
enum {
    BYTES_PER_PIXEL = sizeof(struct pen_pixel_sums) + sizeof(struct pen_pixel_estimate) +
                      3 * sizeof(float) + sizeof(uint16_t) + sizeof(unsigned char)
};

struct pen_adaptive *pen_adaptive_new(const struct pen_settings *settings, struct pen_status *st)
{
    struct pen_adaptive *a = calloc(1, sizeof *a);
    const size_t pixels = (size_t)settings->width * (size_t)settings->height;
    void *arrays = pen_memory_large_zeroed(pixels * BYTES_PER_PIXEL);
    if (a && arrays) {
        a->settings = settings;
        a->sampling = pen_settings_sampling(settings);
        a->sums = arrays;
        a->estimates = (struct pen_pixel_estimate *)(a->sums + pixels);
        a->errors = (float *)(a->estimates + pixels);
        a->unseen = a->errors + pixels;
        a->things = a->unseen + pixels;
        a->priority = (uint16_t *)(a->things + pixels);
        a->wanted = (unsigned char *)(a->priority + pixels);
        memset(a->wanted, 1, pixels);
        return a;
    }
    free(a);
    free(arrays);
    pen_fail(st, PEN_NO_MEMORY, "out of memory for the samples of %d x %d pixels", settings->width,
             settings->height);
    return NULL;
}

void pen_adaptive_free(struct pen_adaptive *a)
{
    if (!a)
        return;
    pen_beams_free(a->beams);
    free(a->sums);
    free(a->slices);
    free(a);
}

void pen_pixel_double(struct pen_pixel_sums *sums)
{
    for (int c = 0; c < 3; c++) {
        sums->sum[0][c] += sums->sum[1][c];
        sums->sum[1][c] = 0;
    }
    sums->kept[0] += sums->kept[1];
    sums->kept[1] = 0;
}

void pen_pixel_mean(const struct pen_pixel_sums *sums, double rgb[3])
{
    const double kept = sums->kept[0] + sums->kept[1], each = kept > 0 ? 1 / kept : 0;
    for (int c = 0; c < 3; c++)
        rgb[c] = (sums->sum[0][c] + sums->sum[1][c]) * each;
}

/* The mean square error of one encoded value, from those of the halves. It is the variance of their
 * mean, plus the square of the error that the curve of the transfer function adds. */
static double channel_error(const double encoded[2], double of_mean)
{
    const double apart = (encoded[0] - encoded[1]) / 2;
    const double curved = of_mean - (encoded[0] + encoded[1]) / 2;
    return apart * apart + curved * curved;
}

void pen_adaptive_estimate(struct pen_adaptive *a, size_t pixel, float rgb[3])
{
    const struct pen_pixel_sums *sums = &a->sums[pixel];
    const enum pen_transfer transfer = pen_settings_transfer(a->settings);
    const double each[2] = {sums->kept[0] > 0 ? 1.0 / sums->kept[0] : 0,
                            sums->kept[1] > 0 ? 1.0 / sums->kept[1] : 0};
    double mean[3], error = 0;
    pen_pixel_mean(sums, mean);
    for (int c = 0; c < 3; c++) {
        const double value = pen_encode_unit_near(mean[c], transfer);
        double encoded[2];
        for (int half = 0; half < 2; half++)
            encoded[half] = sums->kept[half] > 0
                                ? pen_encode_unit_near(sums->sum[half][c] * each[half], transfer)
                                : value;
        error += channel_error(encoded, value);
        a->estimates[pixel].value[c] = (float)value;
        rgb[c] = (float)mean[c];
    }
    a->estimates[pixel].error = (float)(error / 3);
}

bool pen_pixel_same(const struct pen_adaptive *a, size_t pixel)
{
    static const double apart = 1.0 / 512;
    return (double)a->estimates[pixel].error <= apart * apart;
}

bool pen_pixel_agrees(const struct pen_adaptive *a, size_t pixel)
{
    return a->sums[pixel].looks == PEN_LOOKS_UNDECIDED && pen_pixel_same(a, pixel);
}

const struct pen_beams *pen_adaptive_beams(const struct pen_adaptive *a, size_t pixel)
{
    const enum pen_beam_things things = pen_beam_things(a->beams, pixel);
    return things == PEN_BEAM_BRIGHT ||
                   (things == PEN_BEAM_SMALL && a->sums[pixel].looks == PEN_LOOKS)
               ? a->beams
               : NULL;
}

uint32_t pen_adaptive_begin_pixel(struct pen_adaptive *a, size_t pixel)
{
    struct pen_pixel_sums *sums = &a->sums[pixel];
    if (sums->samples == 0)
        return pen_settings_pilot(a->settings);
    if (sums->looks == PEN_LOOKS_UNDECIDED) {
        const bool looks =
            pen_beam_things(a->beams, pixel) == PEN_BEAM_SMALL && pen_pixel_agrees(a, pixel);
        if (looks)
            *sums = (struct pen_pixel_sums){.looks = PEN_LOOKS};
        else
            sums->looks = PEN_LOOKS_NOT;
        if (looks)
            return 2 * pen_settings_pilot(a->settings);
    }
    sums->before = a->estimates[pixel].error;
    return sums->samples;
}

struct pen_sample_spread pen_adaptive_spread(const struct pen_adaptive *a)
{
    uint64_t by_log[33] = {0}, pixels = pixels_of(a), seen = 0, sum = 0;
    struct pen_sample_spread spread = {.mean = 0};
    for (size_t i = 0; i < pixels; i++) {
        const uint32_t n = a->sums[i].samples;
        by_log[n > 0 ? 32 - __builtin_clz(n) : 0]++;
        sum += n + (a->sums[i].looks == PEN_LOOKS ? pen_settings_pilot(a->settings) : 0);
    }
    spread.mean = (double)sum / (double)pixels;
    for (int i = 0; i < 33; i++) {
        const uint32_t n = i > 0 ? UINT32_C(1) << (i - 1) : 0;
        if (by_log[i] == 0)
            continue;
        if (seen == 0)
            spread.least = n;
        if (2 * seen < pixels)
            spread.median = n;
        if (20 * seen < 19 * pixels)
            spread.p95 = n;
        spread.most = n;
        seen += by_log[i];
    }
    return spread;
}
