/* SPDX-License-Identifier: MIT */
#include "shade/first_hit.h"

#include "math/scale.h"
#include "shade/internal/patterns.h"
#include "shade/internal/scratch.h"

static bool first_hit(const struct pen_kernel_input *input, struct path *path, int x, int y,
                      struct pen_hit *hit)
{
    const struct pen_pinhole *pinhole = &input->pinhole;
    const struct pen_t_interval all = {pen_after_start, INFINITY};
    const struct pen_vec3 row =
        pen_along(pinhole->middle, pinhole->dx, x + 0.5 - pinhole->half_width);
    struct layers layers;
    path->origin = pen_origin_none;
    if (!pen_ray_make(&path->ray, pinhole->eye,
                      pen_along(row, pinhole->dy, y + 0.5 - pinhole->half_height)) ||
        !input->trace->nearest(input->scene->accel, &path->ray, &path->origin, &all, hit))
        return false;
    if (input->scene->layer_first)
        pen_layers_begin(input, &layers, path, hit);
    return true;
}

bool pen_first_hit(const struct pen_kernel_input *input, int x, int y, struct pen_first_hit *out)
{
    const struct pen_scene *scene = input->scene;
    struct path path;
    struct pen_hit hit;
    if (!first_hit(input, &path, x, y, &hit))
        return false;
    const struct pen_vec3 p = pen_prim_point(&scene->prims, hit, &path.ray);
    const struct pen_vec3 n = pen_prim_normal_seen(&scene->prims, hit, p, path.ray.d);
    const double bound = pen_origin_at(&scene->prims, &path.ray, &path.origin, hit, p).bound;
    out->prim = hit.prim;
    out->distance = pen_scale2(pen_length(pen_sub(p, path.ray.o)), scene->exponent);
    out->normal = pen_dot(n, path.ray.d) > 0 ? pen_neg(n) : n;
    out->albedo = pen_material_at(scene, hit.prim, p, bound).kd;
    return isfinite(out->distance) && isfinite(pen_norm1(n));
}
