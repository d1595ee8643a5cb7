/* SPDX-License-Identifier: MIT */
/* The kernel: the radiance of a pixel, by the equations of src/shade/README.md. `fx` is a constant
 * in every compiled kernel (kernel_list.h). So a kernel contains only the effects of its mask and
 * tests none of them at run time.
 *
 * The tree of paths under a camera ray is traversed without recursion. At a surface the reflected
 * path is put on a stack and the transmitted path continues. When a path ends, the path on top of
 * the stack continues. A path puts at most one other path on the stack at each surface it shades,
 * and paths on top are deeper than the others. So max_depth entries are enough. If paths fork, the
 * tree grows as 2^max_depth, so it is truncated after a number of surfaces: pen_tree_surfaces_max.
 * Kernels without both kinds of secondary rays do not count, since their one path is shorter.
 *
 * All kernels sum in the same order, so that all give the same bits. It is: the surfaces of a pixel
 * sample in the order of the traversal; at each surface emission, ambient light, then the lights in
 * document order, times the path's weight. A term that a mask leaves out would be 0, and adding 0
 * to a sum that began with 0 changes no bit of it. */
#ifndef PEN_SHADE_INTERNAL_KERNEL_BODY_H
#define PEN_SHADE_INTERNAL_KERNEL_BODY_H

#include "shade/internal/background.h"
#include "shade/internal/blur.h"
#include "shade/internal/pixel_sample.h"
#include "shade/internal/secondary_rays.h"
#include "shade/internal/soft_shadow.h"

_Static_assert(LANES == 1, "the pixel kernel shades one point at a time");

/* The radiance that surface s sends to the path's viewer: emission, ambient light (only for primary
 * rays), and the lights. */
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

/* Counts the paths that the end of the tree truncates: those on the stack, which are reflected
 * paths without blur, and the transmitted path that would continue. They are counted as rays but
 * not traced. */
static ALWAYS_INLINE void count_truncated(const struct pen_kernel_input *input,
                                          const struct pen_kernel_scratch *scratch,
                                          struct pen_ray_counts *counts, int waiting,
                                          bool continues, const unsigned fx)
{
    uint64_t reflected = (uint64_t)waiting, transmitted = continues;
    if (blurs(input, fx)) {
        reflected = 0;
        for (int i = 0; i < waiting; i++) {
            reflected += scratch->blurred[i].reflected ? scratch->blurred[i].left : 0;
            transmitted += scratch->blurred[i].reflected ? 0 : scratch->blurred[i].left;
        }
    }
    counts->reflection -= reflected;
    counts->transmission -= transmitted;
    counts->truncated_paths += reflected + transmitted;
}

/* Computes reflection and refraction at the surface of the path; `deeper` if there is a next ray.
 */
static ALWAYS_INLINE void pixel_refract(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, const struct path *path,
                                        const struct surface *s, bool deeper,
                                        struct refraction *bend, struct pen_ray_counts *counts,
                                        const unsigned fx)
{
    const struct pen_scene *scene = input->scene;
    refraction_begin(bend, s, scene, fx);
    scratch->several = false;
    if (deeper && refracts(scene, fx) && !is_black(bend->kt[0])) {
        const struct solid_point at = {s->hit[0], lanes3_at(s->p, 0), lanes_at(s->bound, 0),
                                       lane_mask_bits(s->outside) != 0};
        struct solid_interface several;
        scratch->several = pen_solids_coincide(input, scratch, path, &at, &several);
        if (scratch->several) {
            bend->index[0] = several.index;
            bend->beyond[0] = several.beyond;
            bend->kt[0] = several.kt;
            counts->unmatched_exits += several.unmatched;
        } else {
            refraction_cross(bend, scene, s, 0, media_at(scratch, media_of_path(scratch)), counts);
        }
    }
    refraction_end(bend, s, scene, fx);
}

/* Sets the media of the transmitted path, which continues as the path. */
static ALWAYS_INLINE void pixel_pass(const struct pen_kernel_input *input,
                                     struct pen_kernel_scratch *scratch, const struct surface *s)
{
    struct media *media = media_at(scratch, media_of_path(scratch));
    if (scratch->several)
        media_copy(media, media_at(scratch, media_behind(scratch)));
    else
        refraction_pass(input->scene, s, 0, media);
}

/* Finds the path's next hit. Coincident surfaces are met in document order. Those that coincide
 * with the surface that the ray starts on are already in order, by their t. A refracted ray has
 * passed the surfaces of solids among the latter. */
static ALWAYS_INLINE bool path_nearest(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, const struct path *path,
                                       struct pen_hit *hit, const unsigned fx)
{
    struct pen_t_interval interval = {path->after, INFINITY};
    const uint32_t *first = input->scene->layer_first;
    if (scratch->layers.any)
        return pen_layers_next(input, &scratch->layers, path, hit);
    do {
        if (!input->trace->nearest(input->scene->accel, &path->ray, &path->origin, &interval, hit))
            return false;
        interval.after = *hit;
    } while (refracts(input->scene, fx) && has_passed_layer(input->scene, path, *hit));
    if (first && first[hit->prim] != first[hit->prim + 1] && hit->t > PEN_LAST_LAYER_T)
        pen_layers_begin(input, &scratch->layers, path, hit);
    return true;
}

/* The contribution of a path to its pixel sample, if this radiance arrives along it. */
static ALWAYS_INLINE struct pen_vec3 path_adds(const struct path *path, struct pen_vec3 radiance,
                                               const unsigned fx)
{
    const struct pen_vec3 weighted = pen_mul(path->weight, radiance);
    return fx & FX_BLUR ? pen_scale(weighted, path->share) : weighted;
}

/* Puts the paths that the surface reflects on the stack. Returns the stack's new height. */
static ALWAYS_INLINE int pixel_reflect(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, const struct path *path,
                                       const struct surface *s, const struct refraction *bend,
                                       int waiting, struct pen_ray_counts *counts,
                                       const unsigned fx)
{
    struct path *reflected = &scratch->waiting[waiting];
    unsigned made = paths_reflected(input, s, bend, &path, 1, fx);
    if (made)
        made = paths_reflect(input, s, bend, made, &path, &reflected, fx);
    if (!made)
        return waiting;
    if (refracts(input->scene, fx))
        media_copy(media_at(scratch, (size_t)waiting), media_at(scratch, media_of_path(scratch)));
    counts->reflection += blurs(input, fx) ? blur_push(input, scratch, (size_t)waiting, s,
                                                       blur_at(input, s, 0, fx).reflection, true)
                                           : 1;
    return waiting + 1;
}

/* Puts the transmitted path, which would continue, on the stack if it is blurred. It is not blurred
 * if rounding decides on which side of the surface it is. Returns whether it is on the stack. */
static ALWAYS_INLINE bool pixel_blur_transmitted(const struct pen_kernel_input *input,
                                                 struct pen_kernel_scratch *scratch,
                                                 const struct path *path, const struct surface *s,
                                                 int waiting, struct pen_ray_counts *counts,
                                                 const unsigned fx)
{
    const double spread = blurs(input, fx) ? blur_at(input, s, 0, fx).transmission : 0;
    if (!(spread > 0) || !lane_mask_bits(surface_mirrors(s)))
        return false;
    struct path *blurred = &scratch->waiting[waiting];
    *blurred = *path;
    if (path->after.t > 0) { /* it continues straight on */
        pen_ray_make(&blurred->ray, lanes3_at(s->p, 0), lanes3_at(s->v, 0));
        blurred->origin = surface_origin(s, 0, true);
        blurred->after = pen_after_start;
    }
    if (refracts(input->scene, fx))
        media_copy(media_at(scratch, (size_t)waiting), media_at(scratch, media_of_path(scratch)));
    counts->transmission += blur_push(input, scratch, (size_t)waiting, s, spread, false);
    return true;
}

/* Takes the path on top of the stack as the path to trace. */
static ALWAYS_INLINE void pixel_pop(const struct pen_kernel_input *input,
                                    struct pen_kernel_scratch *scratch, int *waiting,
                                    struct path *path, const unsigned fx)
{
    if (refracts(input->scene, fx))
        media_copy(media_at(scratch, media_of_path(scratch)),
                   media_at(scratch, (size_t)*waiting - 1));
    if (blurs(input, fx))
        blur_pop(scratch, waiting, path);
    else
        *path = scratch->waiting[--*waiting];
    scratch->layers.any = false;
}

/* Looks for a corner at the path's hit. */
static ALWAYS_INLINE void look_for_corner(const struct pen_prims *prims, struct corner *corner,
                                          const struct path *path, const struct surface *s)
{
    const uint32_t left = path->origin.prim;
    if (path->depth == 0 && corner->moves == 0)
        corner->bound = lanes_at(s->bound, 0);
    if (path->depth > 0 && lane_mask_bits(s->corner) && corner->moves < CORNER_MOVES)
        corner->met = (corner->moves == 0 || lanes_at(s->unsure, 0) > 1) &&
                      pen_prim_flat(pen_prim_kind(prims, s->hit[0].prim)) && left != PEN_NO_PRIM &&
                      pen_prim_flat(pen_prim_kind(prims, left));
}

/* The radiance that arrives along the camera ray through a point of the image; if the ray has been
 * moved, through a point beside it. */
static ALWAYS_INLINE struct pen_vec3 trace_tree(const struct pen_kernel_input *input,
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
    if ((fx & FX_SECONDARY) && scratch->corner.met &&
        !pen_corner_move(&scratch->corner, input, ray))
        return sum;
    path.origin = pen_origin_none;
    path.after = pen_after_start;
    path.weight = pen_vec3(1, 1, 1);
    path.depth = 0;
    path.node = 1;
    path.share = 1;
    if (refracts(scene, fx))
        media_of_camera_ray(input, media_at(scratch, media_of_path(scratch)), path.ray.o);
    const bool forks =
        ((fx & PEN_FX_MIRROR) && (fx & PEN_FX_TRANSMISSION)) || (fx & PEN_FX_REFRACTION);
    if (forks)
        scratch->surfaces_left = scratch->surfaces_max;
    scratch->layers.any = false;
    for (int waiting = 0;;) {
        struct pen_hit hit;
        bool continues = false;
        if (!path_nearest(input, scratch, &path, &hit, fx)) {
            if (fx & PEN_FX_SKY)
                scratch->met |= PEN_FX_SKY;
            sum = pen_add(sum, path_adds(&path, background_seen(scene, &path.ray, fx), fx));
        } else {
            const struct path *const at_hit = &path;
            struct surface s;
            s.hit[0] = hit;
            surface_at(&s, scene, &at_hit, 1, fx);
            if (!lane_mask_bits(s.finite))
                return no_sample();
            if (fx & FX_SECONDARY)
                look_for_corner(&scene->prims, &scratch->corner, &path, &s);
            if ((fx & FX_SECONDARY) && scratch->corner.met)
                return sum;
            if ((fx & PEN_FX_PATTERNS) && prim_is_patterned(scene, hit.prim))
                scratch->met |= PEN_FX_PATTERNS;
            if (fx & FX_SAMPLED)
                scratch->key.node = path.node;
            struct pen_vec3 here = shade_surface(input, scratch, &s, path.depth == 0, counts, fx);
            sum = pen_add(sum, path_adds(&path, here, fx));
            bool deeper = path.depth + 1 < input->settings->max_depth;
            struct refraction bend;
            if (fx & PEN_FX_REFRACTION)
                pixel_refract(input, scratch, &path, &s, deeper, &bend, counts, fx);
            if ((fx & (PEN_FX_MIRROR | PEN_FX_REFRACTION)) && deeper)
                waiting = pixel_reflect(input, scratch, &path, &s, &bend, waiting, counts, fx);
            continues = (fx & PEN_FX_TRANSMISSION) && deeper &&
                        path_transmit(input, &path, &s, &bend, 0, fx);
            if (continues && refracts(scene, fx))
                pixel_pass(input, scratch, &s);
            if ((fx & PEN_FX_REFRACTION) && continues && !bend.straight)
                scratch->layers.any = false;
            if (continues &&
                pixel_blur_transmitted(input, scratch, &path, &s, waiting, counts, fx)) {
                continues = false;
                waiting++;
            }
            counts->transmission += continues;
            if (forks && --scratch->surfaces_left == 0) {
                count_truncated(input, scratch, counts, waiting, continues, fx);
                waiting = continues = 0;
            }
        }
        if (continues)
            continue;
        if (waiting == 0)
            return sum;
        pixel_pop(input, scratch, &waiting, &path, fx);
    }
}

/* The same, with the camera ray moved aside from corners. Rays of the last attempt count. */
static ALWAYS_INLINE struct pen_vec3 trace_paths(const struct pen_kernel_input *input,
                                                 struct pen_kernel_scratch *scratch,
                                                 struct pen_camera_point at,
                                                 struct pen_ray_counts *counts, const unsigned fx)
{
    struct corner *corner = &scratch->corner;
    const struct pen_ray_counts before = *counts;
    corner->moves = 0;
    corner->met = false;
    for (;;) {
        const struct pen_vec3 c = trace_tree(input, scratch, at, counts, fx);
        if (!(fx & FX_SECONDARY) || !corner->met)
            return c;
        *counts = before;
        corner->met = ++corner->moves < CORNER_MOVES;
    }
}

/* The mean of a pixel's samples. Samples that the film cannot hold are left out of the mean and
 * counted. */
static ALWAYS_INLINE void kernel_pixel(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, int x, int y,
                                       double rgb[3], struct pen_ray_counts *counts,
                                       pen_kernel_sample_fn *sample, const unsigned fx)
{
    const int samples = pixel_samples(input, fx);
    const struct pixel_scrambling scrambling = pixel_scrambling(input, samples, x, y, fx);
    if (fx & FX_SAMPLED)
        scratch->key = (struct pen_sample_key){.seed = input->settings->seed,
                                               .x = (uint32_t)x,
                                               .y = (uint32_t)y,
                                               .purpose = PEN_PURPOSE_LIGHT};
    scratch->ray = 0;
    struct pen_vec3 sum = {0, 0, 0};
    int kept = 0;
    for (int i = 0; i < samples; i++) {
        struct pen_camera_point at = camera_point(input, &scrambling, samples, i, fx);
        at.x += x;
        at.y += y;
        counts->primary++;
        if (fx & FX_SAMPLED)
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
