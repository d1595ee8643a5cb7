/* SPDX-License-Identifier: MIT */
/* The block kernel: the pixels of a block, rendered together in waves of up to 64 rays, with the
 * same bits as the pixel kernel (kernel_body.h).
 *
 * The camera rays are the first wave. A wave (block_wave.h) puts its transmitted and reflected
 * paths on two stacks, from which the next waves are taken. When both are empty, each pixel adds up
 * the radiance of its surfaces (block_scratch.h). The pixel kernel renders deferred pixel samples.
 * If many camera rays of a block meet an effect that its kernel leaves out, the block kernel with
 * all effects renders the block. */
#ifndef PEN_SHADE_INTERNAL_BLOCK_BODY_H
#define PEN_SHADE_INTERNAL_BLOCK_BODY_H

#include <string.h>

#include "shade/internal/block_points.h"
#include "shade/internal/block_wave.h"

/* Puts the path of a finished camera ray into the wave. */
static ALWAYS_INLINE void block_begin_path(struct pen_block_scratch *b, struct block_path *wave,
                                           int pixel, int32_t record)
{
    wave->path.origin = pen_origin_none;
    wave->path.after = pen_after_start;
    wave->path.weight = pen_vec3(1, 1, 1);
    wave->path.depth = 0;
    wave->path.node = 1;
    wave->record = record;
    wave->pixel = (uint8_t)pixel;
    b->wave[b->count++] = wave;
}

/* Begins the packet with the camera rays, which are in its arrays. */
static ALWAYS_INLINE void block_begin_packet(struct pen_block_scratch *b)
{
    struct pen_ray_packet *packet = &b->packet;
    packet->live = block_all_paths(b);
    packet->rays.along_x &= packet->live;
    packet->rays.along_y &= packet->live;
    packet->rays.forward &= packet->live;
    pen_ray_packet_start(packet);
    pen_ray_packet_start_on(packet, PEN_NO_PRIM, packet->live);
    for (int i = 0; i < b->count; i++) {
        packet->origin[i] = &pen_origin_none;
        packet->bound[i] = -1;
        packet->after[i] = pen_after_start;
    }
}

/* Makes the camera rays of LANES pixels, from `first` on. */
static ALWAYS_INLINE lane_mask block_rays_of(const struct pen_kernel_input *input,
                                             const struct block_points *at, int first,
                                             struct lanes_ray *rays, const unsigned fx)
{
    struct lanes_camera_point point = {.x = lanes_load(at->x + first),
                                       .y = lanes_load(at->y + first)};
    if (has_lens(input, fx)) {
        point.lens_x = lanes_load(at->lens_x + first);
        point.lens_y = lanes_load(at->lens_y + first);
    }
    return camera_rays(input, &point, rays, fx);
}

/* Makes the camera rays through points of the block's pixels. The first paths of the pool are
 * theirs, in whole groups of LANES. */
static ALWAYS_INLINE void block_camera_rays(const struct pen_kernel_input *input,
                                            const struct pen_kernel_scratch *scratch,
                                            struct pen_block_scratch *b,
                                            const struct block_points *at, int pixels,
                                            const unsigned fx)
{
    b->count = b->record_count = 0;
    b->transmitted.count = b->reflected.count = b->unused.count = 0;
    b->used = BLOCK_PIXELS;
    pen_ray_array_begin(&b->packet.rays);
    for (int first = 0; first < pixels; first += LANES) {
        struct pen_ray *ray[LANES];
        struct lanes_ray rays;
        for (int i = 0; i < LANES; i++)
            ray[i] = &b->pool[first + i].path.ray;
        const unsigned made = lane_mask_bits(block_rays_of(input, at, first, &rays, fx));
        lanes_ray_put(&rays, ray);
        lanes_ray_array_put(&rays, &b->packet.rays, first);
        for (int i = first; i < first + LANES && i < pixels; i++) {
            const int32_t record = block_record_new(b, i); /* number i */
            if (made >> (i - first) & 1)
                block_begin_path(b, &b->pool[i], i, record);
            else
                b->deferred |= UINT64_C(1) << i;
        }
    }
    for (int i = 0; refracts(input->scene, fx) && i < b->count; i++)
        media_of_camera_ray(input, block_media(scratch, b->wave[i]), b->wave[i]->path.ray.o);
    if (b->count < pixels)
        block_set_packet(b); /* without the rays that could not be made */
    else
        block_begin_packet(b);
}

/* Renders the sample of one pixel with the pixel kernel. */
static ALWAYS_INLINE struct pen_vec3
block_sample_alone(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   const struct block_points *at, int i, struct pen_ray_counts *counts,
                   pen_kernel_sample_fn *alone, const unsigned fx)
{
    const struct pen_block_scratch *b = scratch->block;
    scratch->key.x = (uint32_t)b->x[i];
    scratch->key.y = (uint32_t)b->y[i];
    if ((fx & FX_SAMPLED) && (fx & PEN_FX_ANTI_ALIASING)) {
        scratch->key.pixel_sample = b->pixel_sample[i];
        scratch->ray = b->ray[i];
    }
    struct pen_camera_point point = {.x = at->x[i], .y = at->y[i]};
    if (has_lens(input, fx))
        point.lens = (struct pen_point2){at->lens_x[i], at->lens_y[i]};
    return (input->full ? input->full->sample : alone)(input, scratch, point, counts);
}

/* Up to this number of samples, the pixel kernel repeats them faster than a block kernel repeats
 * all. */
enum { BLOCK_FEW = 4 };

/* Whether too many samples of the traced first wave meet an effect that this kernel leaves out. */
static ALWAYS_INLINE bool block_meets_left_out(const struct pen_kernel_input *input,
                                               const struct pen_block_scratch *b, const unsigned fx)
{
    return (leaves_out(input, PEN_FX_SKY, fx) || leaves_out(input, PEN_FX_PATTERNS, fx)) &&
           __builtin_popcountll(b->deferred) > BLOCK_FEW;
}

/* Renders one sample of every pixel: its radiance in c. `alone` renders deferred samples. Returns
 * false, with nothing done, if `may_refuse` and the kernel with all effects should render them. */
static ALWAYS_INLINE bool block_samples(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch,
                                        const struct block_points *at, int pixels,
                                        struct pen_vec3 *c, struct pen_ray_counts *counts,
                                        pen_kernel_sample_fn *alone, bool may_refuse,
                                        const unsigned fx)
{
    struct pen_block_scratch *b = scratch->block;
    const struct pen_ray_counts none = {.primary = 0};
    b->deferred = 0;
    for (int i = 0; i < pixels; i++) {
        b->counts[i] = none;
        b->surfaces[i] = 0;
    }
    block_camera_rays(input, scratch, b, at, pixels, fx);
    block_trace(input, b, fx);
    if (may_refuse && block_meets_left_out(input, b, fx))
        return false;
    block_wave(input, scratch, b, fx);
    while ((fx & FX_SECONDARY) && (b->transmitted.count > 0 || b->reflected.count > 0)) {
        block_take(b, b->transmitted.count > 0 ? &b->transmitted : &b->reflected);
        block_set_packet(b);
        block_trace(input, b, fx);
        block_wave(input, scratch, b, fx);
    }
    for (int i = 0; i < pixels; i++) {
        if (b->deferred >> i & 1) {
            c[i] = block_sample_alone(input, scratch, at, i, counts, alone, fx);
            continue;
        }
        const struct pen_vec3 zero = {0, 0, 0};
        c[i] = block_sum(b, i, zero);
        pen_ray_counts_add(counts, &b->counts[i]);
    }
    return true;
}

/* The pixels of a block along a Z-order curve. So 4 or 16 pixels in sequence are near one another,
 * and so are their rays.
 * Source: Morton, 1966. */
#define PIXELS_4(n) (n), (n) + 1, (n) + 8, (n) + 9
#define PIXELS_16(n) PIXELS_4(n), PIXELS_4(n + 2), PIXELS_4(n + 16), PIXELS_4(n + 18)
static const uint8_t block_z_order[BLOCK_PIXELS] = {PIXELS_16(0), PIXELS_16(4), PIXELS_16(32),
                                                    PIXELS_16(36)};
#undef PIXELS_4
#undef PIXELS_16
_Static_assert(PEN_BLOCK_SIDE == 8, "pixel n is in row n / 8 and column n % 8");

/* Numbers the pixels of a block that are in the rectangle. Returns their number. */
static ALWAYS_INLINE int block_order(struct pen_block_scratch *b, struct pen_rect rect)
{
    int pixels = 0;
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const int x = block_z_order[i] % 8, y = block_z_order[i] / 8;
        if (x >= rect.width || y >= rect.height)
            continue;
        b->x[pixels] = rect.x + x;
        b->y[pixels++] = rect.y + y;
    }
    return pixels;
}

static ALWAYS_INLINE void block_set_point(struct block_points *points, int i,
                                          const struct pen_camera_point *at)
{
    points->x[i] = at->x;
    points->y[i] = at->y;
    points->lens_x[i] = at->lens.x;
    points->lens_y[i] = at->lens.y;
}

/* Renders samples of replicates, as the block's pixels: their radiances. */
static ALWAYS_INLINE void kernel_samples(const struct pen_kernel_input *input,
                                         struct pen_kernel_scratch *scratch,
                                         const struct pen_camera_sample *samples, int count,
                                         struct pen_vec3 *c, struct pen_ray_counts *counts,
                                         pen_kernel_sample_fn *alone, const unsigned fx)
{
    if (!(fx & PEN_FX_ANTI_ALIASING))
        return; /* a kernel without anti-aliasing renders no replicates */
    struct pen_block_scratch *b = scratch->block;
    struct block_points at;
    struct block_sequences sequences;
    for (int i = 0; i < count; i++) {
        b->x[i] = samples[i].x;
        b->y[i] = samples[i].y;
        b->pixel_sample[i] = PEN_SAMPLE_REPLICATE + samples[i].replicate;
        b->ray[i] = samples[i].index;
    }
    block_begin_sequences(input, b, b->pixel_sample, count, &sequences, fx);
    memcpy(sequences.index, b->ray, (size_t)count * sizeof *b->ray);
    block_set_points(input, &sequences, count, SEVERAL_SAMPLES, &at, fx);
    for (int i = 0; i < count; i++)
        if (samples[i].at)
            block_set_point(&at, i, samples[i].at);
    if (fx & FX_SAMPLED)
        scratch->key = replicate_key(input, &samples[0]);
    if (input->trace->nearest_packet &&
        !block_samples(input, scratch, &at, count, c, counts, alone, true, fx)) {
        input->full->samples(input, scratch, samples, count, c, counts);
        return;
    }
    counts->primary += (uint64_t)count;
    for (int i = 0; !input->trace->nearest_packet && i < count; i++)
        c[i] = block_sample_alone(input, scratch, &at, i, counts, alone, fx);
    for (int i = 0; i < count; i++) {
        if (fits_film(c[i]))
            continue;
        counts->dropped_samples++;
        c[i] = no_sample();
    }
}

/* Writes a pixel of the block. */
static ALWAYS_INLINE void block_put(const struct pen_block_scratch *b, struct pen_rect rect,
                                    double (*rgb)[3], int i, struct pen_vec3 c)
{
    double *out = rgb[(b->y[i] - rect.y) * rect.width + b->x[i] - rect.x];
    out[0] = c.x;
    out[1] = c.y;
    out[2] = c.z;
}

/* Renders the pixels of a block, as kernel_pixel; `alone` is the pixel kernel of the same effects.
 * The mean of one sample is the sample: it is a sum that began with 0, so adding it to 0 changes no
 * bit. */
static ALWAYS_INLINE void kernel_block(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, struct pen_rect rect,
                                       double (*rgb)[3], struct pen_ray_counts *counts,
                                       pen_kernel_sample_fn *alone, const unsigned fx)
{
    struct pen_block_scratch *b = scratch->block;
    const int pixels = block_order(b, rect);
    const struct pen_vec3 zero = {0, 0, 0};
    struct pen_vec3 sum[BLOCK_PIXELS], c[BLOCK_PIXELS];
    struct block_points at;
    int kept[BLOCK_PIXELS];
    struct block_sequences sequences;
    static const uint32_t the_only[BLOCK_PIXELS];
    const int samples = pixel_samples(input, fx);
    const bool centres = samples == 1 && !has_lens(input, fx);
    if (!centres)
        block_begin_sequences(input, b, the_only, pixels, &sequences, fx);
    for (int i = 0; (fx & PEN_FX_ANTI_ALIASING) && i < pixels; i++) {
        sum[i] = zero;
        kept[i] = 0;
    }
    if (fx & FX_SAMPLED)
        scratch->key =
            (struct pen_sample_key){.seed = input->settings->seed, .purpose = PEN_PURPOSE_LIGHT};
    for (int k = 0; k < samples; k++) {
        for (int i = 0; !centres && i < pixels; i++)
            sequences.index[i] = (uint32_t)k;
        if (centres)
            block_set_centres(b, pixels, &at);
        else
            block_set_points(input, &sequences, pixels, samples, &at, fx);
        for (int i = 0; (fx & FX_SAMPLED) && (fx & PEN_FX_ANTI_ALIASING) && i < pixels; i++) {
            b->pixel_sample[i] = (uint32_t)k;
            b->ray[i] = 0;
        }
        if (!block_samples(input, scratch, &at, pixels, c, counts, alone, k == 0, fx)) {
            input->full->block(input, scratch, rect, rgb, counts);
            return;
        }
        counts->primary += (uint64_t)pixels;
        for (int i = 0; i < pixels; i++) {
            const bool fits = fits_film(c[i]);
            counts->dropped_samples += !fits;
            if (!(fx & PEN_FX_ANTI_ALIASING)) {
                block_put(b, rect, rgb, i, fits ? c[i] : zero);
            } else if (fits) {
                sum[i] = pen_add(sum[i], c[i]);
                kept[i]++;
            }
        }
    }
    for (int i = 0; (fx & PEN_FX_ANTI_ALIASING) && i < pixels; i++) {
        const double n = kept[i];
        block_put(b, rect, rgb, i,
                  kept[i] ? pen_vec3(sum[i].x / n, sum[i].y / n, sum[i].z / n) : zero);
    }
}

#endif
