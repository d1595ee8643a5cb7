/* SPDX-License-Identifier: MIT */
/* Glossy reflection and frosted transmission: one ray is replaced by the mean of rays in a cone
 * around it. They are uniform in solid angle in the part of the cone that is on the ray's side of
 * the surface.
 *
 * The first surface of a path that blurs sends blur_samples rays; later ones send one each, because
 * more would multiply. From there on, a path's `share` is 1 over blur_samples. The share is
 * separate from the weight, which decides whether a path continues: a blurred ray has the weight of
 * a single ray.
 *
 * The rays still to be traced are one entry of the pixel kernel's stack, with their number. So the
 * stack grows by at most two entries at a surface, for any blur_samples. */
#ifndef PEN_SHADE_INTERNAL_BLUR_H
#define PEN_SHADE_INTERNAL_BLUR_H

#include "shade/internal/surface.h"

/* Whether rays are blurred. A kernel with blur also renders scenes without it. */
static ALWAYS_INLINE bool blurs(const struct pen_kernel_input *input, const unsigned fx)
{
    return (fx & FX_BLUR) && pen_effects_blur(input->effects);
}

/* The cones of a lane's surface. */
static ALWAYS_INLINE struct pen_blur blur_at(const struct pen_kernel_input *input,
                                             const struct surface *s, int lane, const unsigned fx)
{
    struct pen_blur b = input->scene->blurs[s->material[lane]];
    if (!(fx & PEN_FX_GLOSSY))
        b.reflection = 0;
    if (!(fx & PEN_FX_FROSTED))
        b.transmission = 0;
    return b;
}

/* Sets *path to the next blurred ray of an entry of the stack. */
void pen_blur_next(struct pen_kernel_scratch *scratch, size_t entry, struct path *path);

/* The number of rays that a surface sends if it blurs. */
static ALWAYS_INLINE uint32_t blur_rays(const struct pen_kernel_input *input,
                                        const struct path *path)
{
    return path->share < 1 ? 1 : (uint32_t)input->settings->blur_samples;
}

/* Puts a path on the stack. waiting[entry] is set, and its ray is the axis of the cone; `spread` is
 * as in struct pen_blur. Returns the number of rays. */
static ALWAYS_INLINE uint32_t blur_push(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, size_t entry,
                                        const struct surface *s, double spread, bool reflected)
{
    struct path *path = &scratch->waiting[entry];
    struct blurred *b = &scratch->blurred[entry];
    *b = (struct blurred){.left = 1};
    if (!(spread > 0))
        return 1;
    const uint32_t rays = blur_rays(input, path);
    b->next = scratch->ray * rays;
    b->left = rays;
    b->spread = spread;
    b->side = reflected ? lanes3_at(s->n, 0) : pen_neg(lanes3_at(s->n, 0));
    b->least = lanes_at(s->grazing_sine, 0);
    b->reflected = reflected;
    b->key = scratch->key;
    b->key.light = 0;
    b->key.purpose = reflected ? PEN_PURPOSE_REFLECTION : PEN_PURPOSE_TRANSMISSION;
    path->share = path->share / rays;
    return rays;
}

/* Takes the next path from the top of the stack. */
static ALWAYS_INLINE void blur_pop(struct pen_kernel_scratch *scratch, int *waiting,
                                   struct path *path)
{
    const size_t top = (size_t)*waiting - 1;
    struct blurred *b = &scratch->blurred[top];
    *path = scratch->waiting[top];
    if (b->spread > 0)
        pen_blur_next(scratch, top, path);
    if (--b->left == 0)
        --*waiting;
}

#endif
