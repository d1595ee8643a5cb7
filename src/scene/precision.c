/* SPDX-License-Identifier: MIT */
/* The resolution of a scene's coordinates compared with its pixels. Primitives are measured in the
 * local frame, where nothing over- or underflows; only the results are converted to scene units. */
#include "scene/precision.h"

#include <stdio.h>

#include "math/scale.h"
#include "scene/internal/vec.h"

/* The least distance at which a primitive is assumed to be seen, relative to its size. */
#define NEAREST_PART 0x1p-10

static double gap(double lo, double hi, double x)
{
    return x < lo ? lo - x : x > hi ? x - hi : 0;
}

static double box_distance(struct pen_box box, struct pen_vec3 p)
{
    return pen_length(pen_vec3(gap(box.lo.x, box.hi.x, p.x), gap(box.lo.y, box.hi.y, p.y),
                               gap(box.lo.z, box.hi.z, p.z)));
}

/* The box around a primitive; of one with an outline, the box around its corners, without the
 * margin that pen_prim_bounds leaves for the rounding of rays. */
static struct pen_box box_of(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_outline line = pen_prim_outline(prims, prim);
    if (line.count == 0)
        return pen_prim_bounds(prims, prim);
    struct pen_box box = pen_box_empty();
    for (uint32_t i = 0; i < line.count; i++)
        box = pen_box_add_point(box, line.v[i]);
    return box;
}

/* A lower bound of how far the surface of a primitive is. */
static double distance_of(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    const struct pen_kind_functions *fn = pen_prim_row(prims, prim)->fn;
    return fn->distance ? fn->distance(pen_prim_self(prims, prim), p)
                        : box_distance(box_of(prims, prim), p);
}

static double side(struct pen_box box)
{
    return box.lo.x <= box.hi.x ? vec_max_abs(pen_sub(box.hi, box.lo)) : 0;
}

static struct pen_box all_bounds(const struct pen_prims *prims)
{
    struct pen_box all = pen_box_empty();
    for (uint32_t i = 0; i < prims->count; i++) {
        if (!pen_prim_infinite(prims->ref[i].kind))
            all = pen_box_union(all, box_of(prims, i));
    }
    return all;
}

/* The distance from the eye to the nearest primitive. */
static double nearest(const struct pen_prims *prims, double extent, struct pen_vec3 eye)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < prims->count; i++) {
        double distance = distance_of(prims, i, eye);
        double size = pen_prim_infinite(prims->ref[i].kind) ? extent : side(box_of(prims, i));
        distance = pen_larger(distance, NEAREST_PART * size);
        least = distance < least ? distance : least;
    }
    return least;
}

static struct pen_vec3 to_scene(const struct pen_scene *scene, struct pen_vec3 local)
{
    return pen_add(scene->center, vec_scale2_down(local, -scene->exponent));
}

/* The width of a pixel at unit distance from the eye. */
static double pixel_angle(const struct pen_pinhole *pinhole)
{
    double dx = pen_length(pinhole->dx), dy = pen_length(pinhole->dy);
    return (dx < dy ? dx : dy) / pen_length(pinhole->middle);
}

static bool usable(const struct pen_scene_precision *p)
{
    return isfinite(p->extent) && isfinite(p->coordinate_max) && p->coordinate_max > 0 &&
           p->ulp > 0 && p->pixel_footprint > 0 && isfinite(p->pixel_footprint) &&
           isfinite(p->resolution);
}

bool pen_scene_precision(const struct pen_scene *scene, int view, int width, int height,
                         struct pen_scene_precision *out)
{
    struct pen_pinhole pinhole = pen_scene_pinhole(scene, view, width, height);
    struct pen_box box = all_bounds(&scene->prims);
    double extent = side(box);
    double away = nearest(&scene->prims, extent, pinhole.eye);
    struct pen_vec3 lo = scene->center, hi = scene->center, eye = scene->views[view].frame.eye;
    if (box.lo.x <= box.hi.x) {
        lo = to_scene(scene, box.lo);
        hi = to_scene(scene, box.hi);
    }
    out->extent = pen_scale2(extent, scene->exponent);
    out->coordinate_max =
        pen_larger(pen_larger(vec_max_abs(lo), vec_max_abs(hi)), vec_max_abs(eye));
    out->ulp = pen_scale2(1, pen_exponent(out->coordinate_max) - 53);
    out->pixel_footprint = pen_scale2(away * pixel_angle(&pinhole), scene->exponent);
    out->resolution = out->pixel_footprint / out->ulp;
    return scene->prims.count > 0 && usable(out);
}

bool pen_precision_warning(const struct pen_scene_precision *precision, char *out, size_t bytes)
{
    if (!(precision->resolution < PEN_PRECISION_ENOUGH))
        return false;
    snprintf(
        out, bytes,
        "coordinates reach to %.3g, where numbers are %.2g apart, and a pixel at the nearest "
        "primitive is %.2g wide: %.3g of their steps, below %g rounding may show; put the scene "
        "nearer to the origin, or leave out what is far away",
        precision->coordinate_max, precision->ulp, precision->pixel_footprint,
        precision->resolution, PEN_PRECISION_ENOUGH);
    return true;
}
