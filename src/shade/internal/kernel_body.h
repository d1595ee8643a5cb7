/* SPDX-License-Identifier: MIT */
/* The kernel: the radiance of a pixel, by the equations of src/shade/README.md. `fx` is a constant
 * in every compiled kernel (kernel_list.h), so that each holds only the effects of its mask and
 * tests none of them at run time.
 *
 * The tree of paths under a camera ray is traversed without recursion. At a surface the reflected
 * path is put on a stack and the transmitted path goes on; when a path ends, the path on top of the
 * stack continues. A path puts at most one other on the stack for each surface it shades, and paths
 * on top are deeper than those below, so max_depth entries are enough. Where paths fork, the tree
 * grows as 2^max_depth, so it is cut after a number of surfaces: pen_tree_surfaces_max. Kernels
 * without both kinds of secondary rays do not count, since their one path is shorter.
 *
 * All kernels sum in this order, so that all give the same bits: the surfaces of a pixel sample in
 * the order of the traversal; at each surface emission, ambient, then the lights in document order,
 * times the path's weight. What a mask leaves out is a term that would be 0, and adding 0 to a sum
 * that began with 0 changes no bit of it. */
#ifndef PEN_SHADE_INTERNAL_KERNEL_BODY_H
#define PEN_SHADE_INTERNAL_KERNEL_BODY_H

#include "shade/internal/background.h"
#include "shade/internal/pixel_sample.h"
#include "shade/internal/secondary_rays.h"
#include "shade/internal/soft_shadow.h"

_Static_assert(LANES == 1, "the pixel kernel shades one point at a time");

/* The radiance that surface s sends to the path's viewer: emission, ambient light (for primary rays
 * only) and the lights. */
static ALWAYS_INLINE struct pen_vec3 shade_surface(const struct pen_kernel_input *input,
                                                   struct pen_kernel_scratch *scratch,
                                                   const struct surface *s, bool primary,
                                                   struct pen_ray_counts *counts, const unsigned fx)
{
    const struct pen_scene *scene = input->scene;
    struct pen_vec3 sum = lanes3_at(light_emitted(scene, s, primary, fx), 0);
    const lane_mask lit = surface_lit(s);
    const uint32_t lights = lane_mask_bits(lit) ? scene->light_count : 0;
    for (uint32_t i = 0; i < lights; i++) {
        struct arriving_light arriving;
        light_unshadowed(&arriving, &scene->lights[i], s, lit, fx);
        if (!lane_mask_bits(arriving.arrives))
            continue;
        struct pen_vec3 term = lanes3_at(arriving.term, 0);
        arriving.light = i;
        if ((fx & PEN_FX_HARD_SHADOWS) && scene->lights[i].shadows) {
            struct pen_vec3 t;
            if ((fx & PEN_FX_SOFT_SHADOWS) && scene->lights[i].soft) {
                t = soft_transmittance(input, scratch, s, 0, &arriving, counts, fx);
            } else {
                counts->shadow++;
                t = hard_transmittance(input, scratch, s, 0, &arriving, fx);
            }
            if (is_black(t))
                continue;
            term = pen_mul(term, t);
        }
        sum = pen_add(sum, term);
    }
    return sum;
}

/* Counts the paths that the end of the tree cuts off: those on the stack, all reflected, and the
 * transmitted one that would go on. They have been counted as rays, and are not traced. */
static ALWAYS_INLINE void count_truncated(struct pen_ray_counts *counts, int waiting,
                                          bool continues)
{
    counts->reflection -= (uint64_t)waiting;
    counts->transmission -= continues;
    counts->truncated_paths += (uint64_t)waiting + continues;
}

/* The path's next hit. Where surfaces may coincide they are met in document order; those that
 * coincide with the surface that the ray starts on are in order by their t. */
static ALWAYS_INLINE bool path_nearest(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, const struct path *path,
                                       struct pen_hit *hit)
{
    const struct pen_t_interval interval = {path->after, INFINITY};
    const uint32_t *first = input->scene->layer_first;
    if (scratch->layers.any)
        return pen_layers_next(input, &scratch->layers, path, hit);
    if (!input->trace->nearest(input->scene->accel, &path->ray, &path->origin, &interval, hit))
        return false;
    if (first && first[hit->prim] != first[hit->prim + 1] && hit->t > PEN_LAST_LAYER_T)
        pen_layers_begin(input, &scratch->layers, path, hit);
    return true;
}

/* The radiance that arrives along the camera ray through a point of the image. */
static ALWAYS_INLINE struct pen_vec3 trace_paths(const struct pen_kernel_input *input,
                                                 struct pen_kernel_scratch *scratch,
                                                 struct pen_camera_point at,
                                                 struct pen_ray_counts *counts, const unsigned fx)
{
    const struct pen_scene *scene = input->scene;
    struct pen_vec3 sum = {0, 0, 0};
    struct path path;
    struct pen_ray *const ray = &path.ray;
    struct lanes_ray rays;
    const struct lanes_camera_point point = {at.x, at.y, at.lens.x, at.lens.y};
    if (!lane_mask_bits(camera_rays(input, &point, &rays, fx)))
        return no_sample();
    lanes_ray_put(&rays, &ray);
    path.origin = pen_origin_none;
    path.after = pen_after_start;
    path.weight = pen_vec3(1, 1, 1);
    path.depth = 0;
    path.node = 1;
    const bool forks = (fx & PEN_FX_MIRROR) && (fx & PEN_FX_TRANSMISSION);
    if (forks)
        scratch->surfaces_left = scratch->surfaces_max;
    scratch->layers.any = false;
    for (int waiting = 0;;) {
        struct pen_hit hit;
        bool continues = false;
        if (!path_nearest(input, scratch, &path, &hit)) {
            sum = pen_add(sum, pen_mul(path.weight, background_seen(scene, &path.ray, fx)));
        } else {
            const struct path *const at_hit = &path;
            struct surface s;
            s.hit[0] = hit;
            surface_at(&s, scene, &at_hit, 1, fx);
            if (!lane_mask_bits(s.finite))
                return no_sample();
            if (fx & PEN_FX_SOFT_SHADOWS)
                scratch->key.node = path.node;
            struct pen_vec3 here = shade_surface(input, scratch, &s, path.depth == 0, counts, fx);
            sum = pen_add(sum, pen_mul(path.weight, here));
            bool deeper = path.depth + 1 < input->settings->max_depth;
            if ((fx & PEN_FX_MIRROR) && deeper) {
                struct path *reflected = &scratch->waiting[waiting];
                unsigned made = paths_reflected(input, &s, &at_hit, 1, fx);
                if (made)
                    made = paths_reflect(input, &s, made, &at_hit, &reflected, fx);
                counts->reflection += made;
                waiting += (int)made;
            }
            continues =
                (fx & PEN_FX_TRANSMISSION) && deeper && path_transmit(input, &path, &s, 0, fx);
            counts->transmission += continues;
            if (forks && --scratch->surfaces_left == 0) {
                count_truncated(counts, waiting, continues);
                waiting = continues = 0;
            }
        }
        if (continues)
            continue;
        if (waiting == 0)
            return sum;
        path = scratch->waiting[--waiting];
        scratch->layers.any = false;
    }
}

/* The mean of a pixel's samples. Samples that the film cannot hold are left out and counted. */
static ALWAYS_INLINE void kernel_pixel(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, int x, int y,
                                       double rgb[3], struct pen_ray_counts *counts,
                                       pen_kernel_sample_fn *sample, const unsigned fx)
{
    const int samples = pixel_samples(input, fx);
    const struct pixel_scrambling scrambling = pixel_scrambling(input, samples, x, y, fx);
    if (fx & PEN_FX_SOFT_SHADOWS)
        scratch->key = (struct pen_sample_key){.seed = input->settings->seed,
                                               .x = (uint32_t)x,
                                               .y = (uint32_t)y,
                                               .purpose = PEN_PURPOSE_LIGHT};
    struct pen_vec3 sum = {0, 0, 0};
    int kept = 0;
    for (int i = 0; i < samples; i++) {
        struct pen_camera_point at = camera_point(input, &scrambling, samples, i, fx);
        at.x += x;
        at.y += y;
        counts->primary++;
        if (fx & PEN_FX_SOFT_SHADOWS)
            scratch->key.pixel_sample = (uint32_t)i;
        struct pen_vec3 c = sample(input, scratch, at, counts);
        if (!fits_film(c)) {
            counts->dropped_samples++;
            continue;
        }
        sum = pen_add(sum, c);
        kept++;
    }
    rgb[0] = kept ? sum.x / kept : 0;
    rgb[1] = kept ? sum.y / kept : 0;
    rgb[2] = kept ? sum.z / kept : 0;
}

#endif
