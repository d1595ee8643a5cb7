/* SPDX-License-Identifier: MIT */
/* The points of the image and the lens for the camera rays of a block's pixels, LANES pixels at a
 * time: the points of camera_point, with the same bits. */
#ifndef PEN_SHADE_INTERNAL_BLOCK_POINTS_H
#define PEN_SHADE_INTERNAL_BLOCK_POINTS_H

#include <string.h>

#include "math/sample_lanes.h"
#include "shade/internal/block_scratch.h"
#include "shade/internal/pixel_sample.h"

/* Sets the points of pixels to their centres. Fills up the last group of LANES. */
static ALWAYS_INLINE void block_set_centres(const struct pen_block_scratch *b, int pixels,
                                            struct block_points *at)
{
    for (int i = 0; i < pixels; i++) {
        at->x[i] = 0.5 + b->x[i];
        at->y[i] = 0.5 + b->y[i];
    }
    for (int i = pixels; i % LANES != 0; i++)
        at->x[i] = at->y[i] = 0;
}

/* The data from which the points of a block's pixels are computed, by pixel. The arrays have room
 * for whole groups of LANES. */
struct block_sequences {
    double x[BLOCK_PIXELS], y[BLOCK_PIXELS]; /* the pixel's top left corner */
    uint64_t image[BLOCK_PIXELS],
        lens[BLOCK_PIXELS];       /* scramblings; that of the lens only if there is one */
    uint32_t index[BLOCK_PIXELS]; /* in the sequence */
};

static ALWAYS_INLINE lane_words block_words(const uint64_t *from)
{
    lane_words words;
    memcpy(&words, from, sizeof words);
    return words;
}

static ALWAYS_INLINE lane_halves block_halves(const uint32_t *from)
{
    lane_halves halves;
    memcpy(&halves, from, sizeof halves);
    return halves;
}

/* Sets the points of pixels with this number of samples each. With one sample, the point is the
 * pixel's centre. Sets whole groups of LANES, because they are read as such. */
static ALWAYS_INLINE void block_set_points(const struct pen_kernel_input *input,
                                           const struct block_sequences *s, int pixels, int samples,
                                           struct block_points *at, const unsigned fx)
{
    for (int i = 0; i < pixels; i += LANES) {
        const lane_halves index = block_halves(s->index + i);
        struct lanes_point2 image = {lanes_splat(0.5), lanes_splat(0.5)};
        if (samples > 1)
            image = lanes_sobol2_each(block_words(s->image + i), index);
        lanes_store(at->x + i, image.x + lanes_load(s->x + i));
        lanes_store(at->y + i, image.y + lanes_load(s->y + i));
        if (!has_lens(input, fx))
            continue;
        const struct lanes_point2 lens =
            lanes_disk_of_square(lanes_sobol2_each(block_words(s->lens + i), index));
        lanes_store(at->lens_x + i, lens.x);
        lanes_store(at->lens_y + i, lens.y);
    }
}

/* Begins the sequences of a block's pixels: sets all members but the index. `sequence` is the
 * pixel_sample of their keys (math/sample.h), by pixel. */
static ALWAYS_INLINE void block_begin_sequences(const struct pen_kernel_input *input,
                                                const struct pen_block_scratch *b,
                                                const uint32_t *sequence, int pixels,
                                                struct block_sequences *s, const unsigned fx)
{
    uint64_t pixel[BLOCK_PIXELS] = {0}, number[BLOCK_PIXELS] = {0};
    memset(s, 0, sizeof *s);
    for (int i = 0; i < pixels; i++) {
        s->x[i] = b->x[i];
        s->y[i] = b->y[i];
        pixel[i] = (uint64_t)(uint32_t)b->y[i] << 32 | (uint32_t)b->x[i];
        number[i] = sequence[i];
    }
    for (int i = 0; i < pixels; i += LANES) {
        const lane_words shared = lanes_sample_hash(input->settings->seed, block_words(pixel + i),
                                                    block_words(number + i));
        const lane_words image = lanes_sample_purpose(shared, PEN_PURPOSE_PIXEL);
        const lane_words lens = lanes_sample_purpose(shared, PEN_PURPOSE_LENS);
        memcpy(s->image + i, &image, sizeof image);
        if (has_lens(input, fx))
            memcpy(s->lens + i, &lens, sizeof lens);
    }
}

#endif
