/* SPDX-License-Identifier: MIT */
/* The samples of a pixel: their points on the image and on the lens, their camera rays, and the
 * values that the film can hold. */
#ifndef PEN_SHADE_INTERNAL_PIXEL_SAMPLE_H
#define PEN_SHADE_INTERNAL_PIXEL_SAMPLE_H

#include <float.h>

#include "geom/ray_lanes.h"
#include "shade/internal/surface.h"

/* The scramblings of a pixel's sampled points. */
struct pixel_scrambling {
    uint64_t image, lens;
};

/* Whether camera rays start on a lens. A kernel with lenses also renders pinholes. */
static ALWAYS_INLINE bool has_lens(const struct pen_kernel_input *input, const unsigned fx)
{
    return (fx & PEN_FX_DEPTH_OF_FIELD) && input->lens.open;
}

/* The number of camera rays of each pixel. */
static ALWAYS_INLINE int pixel_samples(const struct pen_kernel_input *input, const unsigned fx)
{
    return fx & PEN_FX_ANTI_ALIASING ? pen_camera_samples(has_lens(input, fx), input->settings) : 1;
}

static ALWAYS_INLINE struct pixel_scrambling
pixel_scrambling(const struct pen_kernel_input *input, int samples, int x, int y, const unsigned fx)
{
    struct pixel_scrambling s = {0, 0};
    struct pen_sample_key key = {.seed = input->settings->seed, .x = (uint32_t)x, .y = (uint32_t)y};
    key.purpose = PEN_PURPOSE_PIXEL;
    if (samples > 1)
        s.image = pen_sample_hash(&key);
    key.purpose = PEN_PURPOSE_LENS;
    if (has_lens(input, fx))
        s.lens = pen_sample_hash(&key);
    return s;
}

/* The key of a sample of a replicate, for its points on lights and in cones. */
static ALWAYS_INLINE struct pen_sample_key replicate_key(const struct pen_kernel_input *input,
                                                         const struct pen_camera_sample *sample)
{
    return (struct pen_sample_key){.seed = input->settings->seed,
                                   .x = (uint32_t)sample->x,
                                   .y = (uint32_t)sample->y,
                                   .pixel_sample = PEN_SAMPLE_REPLICATE + sample->replicate,
                                   .purpose = PEN_PURPOSE_LIGHT};
}

/* Point i of a pixel's samples, from its top left corner. With one sample, it is the pixel's
 * centre. */
static ALWAYS_INLINE struct pen_camera_point camera_point(const struct pen_kernel_input *input,
                                                          const struct pixel_scrambling *s,
                                                          int samples, int i, const unsigned fx)
{
    const struct pen_point2 centre = {0.5, 0.5};
    const struct pen_point2 at = samples > 1 ? pen_sobol2(s->image, (uint32_t)i) : centre;
    struct pen_camera_point point = {.x = at.x, .y = at.y};
    if (has_lens(input, fx))
        point.lens = pen_disk_of_square(pen_sobol2(s->lens, (uint32_t)i));
    return point;
}

enum { SEVERAL_SAMPLES = 2 }; /* any number above 1: a replicate's points are never the centre */

/* Points of the image and the lens, LANES at a time. */
struct lanes_camera_point {
    lanes x, y, lens_x, lens_y;
};

/* Makes the camera rays through points. Returns the lanes that have one. */
static ALWAYS_INLINE lane_mask camera_rays(const struct pen_kernel_input *input,
                                           const struct lanes_camera_point *at,
                                           struct lanes_ray *rays, const unsigned fx)
{
    const struct pen_pinhole *pinhole = &input->pinhole;
    const struct lanes3 eye = lanes3_splat(pinhole->eye);
    struct lanes3 d = lanes3_along(lanes3_splat(pinhole->middle), lanes3_splat(pinhole->dx),
                                   at->x - pinhole->half_width);
    d = lanes3_along(d, lanes3_splat(pinhole->dy), at->y - pinhole->half_height);
    if (!has_lens(input, fx))
        return lanes_ray_of(rays, eye, d);
    const struct lanes3 right = lanes3_scale(lanes3_splat(input->lens.right), at->lens_x);
    const struct lanes3 aside = lanes3_along(right, lanes3_splat(input->lens.up), at->lens_y);
    d = lanes3_sub(lanes3_scale(d, lanes_splat(input->lens.focus)), aside);
    return lanes_ray_of(rays, lanes3_add(eye, aside), d);
}

static ALWAYS_INLINE bool fits_film(struct pen_vec3 c)
{
    return fabs(c.x) <= FLT_MAX && fabs(c.y) <= FLT_MAX && fabs(c.z) <= FLT_MAX;
}

#endif
