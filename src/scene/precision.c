/* SPDX-License-Identifier: MIT */
/* The resolution of a scene's coordinates compared with its pixels. Primitives are measured in the
 * local frame, where nothing over- or underflows. Only the results are converted to scene units. */
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

/* The way from p to a box, as sizes along the axes. */
static struct pen_vec3 box_gap(struct pen_box box, struct pen_vec3 p)
{
    return pen_vec3(gap(box.lo.x, box.hi.x, p.x), gap(box.lo.y, box.hi.y, p.y),
                    gap(box.lo.z, box.hi.z, p.z));
}

static double box_distance(struct pen_box box, struct pen_vec3 p)
{
    return pen_length(box_gap(box, p));
}

/* The box around a primitive. For one with an outline, the box around its corners, without the
 * margin of pen_prim_bounds for the rounding of rays. */
static struct pen_box box_of(const struct pen_prims *prims, uint32_t prim)
{
    struct pen_triangle room;
    const struct pen_outline line = pen_prim_outline(prims, prim, &room);
    if (line.count == 0)
        return pen_prim_bounds(prims, prim);
    struct pen_box box = pen_box_empty();
    for (uint32_t i = 0; i < line.count; i++)
        box = pen_box_add_point(box, line.v[i]);
    return box;
}

/* A lower bound of the distance of a primitive's surface. */
static double distance_of(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    struct pen_triangle room;
    const struct pen_kind_functions *fn = pen_prim_row(prims, prim)->fn;
    return fn->distance ? fn->distance(pen_prim_self(prims, prim, &room), p)
                        : box_distance(box_of(prims, prim), p);
}

static double side(struct pen_box box)
{
    return box.lo.x <= box.hi.x ? vec_max_abs(pen_sub(box.hi, box.lo)) : 0;
}

static struct pen_box box_of_triangle(const struct pen_vec3 v[3])
{
    return pen_box_add_point(pen_box_add_point((struct pen_box){v[0], v[0]}, v[1]), v[2]);
}

static struct pen_box all_bounds(const struct pen_prims *prims)
{
    struct pen_box all = pen_box_empty();
    for (uint32_t i = 0; i < prims->count; i++) {
        const struct pen_mesh *mesh = pen_prim_mesh(prims, i);
        if (mesh) {
            all = pen_box_union(all, pen_mesh_box(mesh));
            i += mesh->count - 1;
        } else if (!pen_prim_infinite(pen_prim_kind(prims, i)))
            all = pen_box_union(all, box_of(prims, i));
    }
    return all;
}

/* The same for the triangles of a mesh, if it is below `least`. */
static double nearest_of_mesh(const struct pen_mesh *mesh, struct pen_vec3 eye, double least)
{
    for (uint32_t i = 0; i < mesh->count; i++) {
        struct pen_vec3 v[3];
        pen_mesh_corners(mesh, i, v);
        const struct pen_box box = box_of_triangle(v);
        const struct pen_vec3 off = box_gap(box, eye);
        if (pen_dot(off, off) >= least * least)
            continue;
        const double distance = pen_larger(pen_length(off), NEAREST_PART * side(box));
        least = distance < least ? distance : least;
    }
    return least;
}

/* The distance from the eye to the nearest primitive. */
static double nearest(const struct pen_prims *prims, double extent, struct pen_vec3 eye)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < prims->count; i++) {
        const struct pen_mesh *mesh = pen_prim_mesh(prims, i);
        if (mesh) {
            least = nearest_of_mesh(mesh, eye, least);
            i += mesh->count - 1;
            continue;
        }
        double distance = distance_of(prims, i, eye);
        double size = pen_prim_infinite(pen_prim_kind(prims, i)) ? extent : side(box_of(prims, i));
        distance = pen_larger(distance, NEAREST_PART * size);
        least = distance < least ? distance : least;
    }
    return least;
}

/* The corner farthest from p. */
static struct pen_vec3 farthest(struct pen_outline line, struct pen_vec3 p)
{
    struct pen_vec3 far = p;
    double most = 0;
    for (uint32_t i = 0; i < line.count; i++) {
        struct pen_vec3 e = pen_sub(line.v[i], p);
        if (pen_dot(e, e) > most) {
            most = pen_dot(e, e);
            far = line.v[i];
        }
    }
    return far;
}

/* Twice the area of an outline: the length of its vector area. */
static double double_area(struct pen_outline line)
{
    struct pen_vec3 sum = pen_vec3(0, 0, 0);
    for (uint32_t i = 1; i + 1 < line.count; i++)
        sum = pen_add(sum,
                      pen_cross(pen_sub(line.v[i], line.v[0]), pen_sub(line.v[i + 1], line.v[0])));
    return pen_length(sum);
}

static void order(double a, double b, double *width, double *length)
{
    *width = a < b ? a : b;
    *length = a < b ? b : a;
}

/* Measures the width and the length of a primitive. Cylinder or cone: the smaller and the larger of
 * height and diameter. Triangle: its least height and its longest edge. Polygon: its area over the
 * distance between far corners, and that distance. Other kinds are as wide as long. */
static void measure(const struct pen_prims *prims, uint32_t prim, double *width, double *length)
{
    struct pen_triangle room;
    const struct pen_outline line = pen_prim_outline(prims, prim, &room);
    const void *self = pen_prim_self(prims, prim, &room);
    *width = *length = 1;
    if (line.count > 0) {
        struct pen_vec3 end = farthest(line, line.v[0]);
        *length = pen_length(pen_sub(farthest(line, end), end));
        *width = double_area(line) / *length * (line.count == 3 ? 1 : 0.5);
    } else if (pen_prim_kind(prims, prim) == PEN_PRIM_CYLINDER) {
        const struct pen_cylinder *c = self;
        order(2 * c->round.r, c->h, width, length);
    } else if (pen_prim_kind(prims, prim) == PEN_PRIM_CONE) {
        const struct pen_cone *c = self;
        order(2 * c->hull.round.r, c->hull.h, width, length);
    }
}

/* Whether a triangle may be thinner than `thinness`: its area is compared with the square of its
 * longest edge. The rounding of both is below 2^-40 of that square. */
static bool may_be_thinner(const struct pen_vec3 v[3], double thinness)
{
    const struct pen_vec3 e = pen_sub(v[1], v[0]), f = pen_sub(v[2], v[0]), g = pen_sub(v[2], v[1]);
    const struct pen_vec3 n = pen_cross(e, f);
    const double most =
        (thinness + 0x1p-40) * pen_larger(pen_larger(pen_dot(e, e), pen_dot(f, f)), pen_dot(g, g));
    return pen_dot(n, n) < most * most;
}

/* Finds the narrowest primitive, in local lengths. */
static void find_narrowest(const struct pen_prims *prims, struct pen_scene_precision *out)
{
    out->thinness = out->thin_width = out->thin_length = 1;
    out->thin_prim = 0;
    const struct pen_mesh *mesh = NULL;
    for (uint32_t i = 0; i < prims->count; i++) {
        double width, length;
        struct pen_vec3 v[3];
        if (!mesh || i - mesh->first == mesh->count)
            mesh = pen_prim_mesh(prims, i);
        if (mesh)
            pen_mesh_corners(mesh, i - mesh->first, v);
        if (mesh && !may_be_thinner(v, out->thinness))
            continue;
        measure(prims, i, &width, &length);
        if (width < out->thinness * length) {
            out->thinness = width / length;
            out->thin_prim = i;
            out->thin_width = width;
            out->thin_length = length;
        }
    }
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
    find_narrowest(&scene->prims, out);
    out->thin_width = pen_scale2(out->thin_width, scene->exponent);
    out->thin_length = pen_scale2(out->thin_length, scene->exponent);
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

bool pen_thinness_warning(const struct pen_scene_precision *precision, char *out, size_t bytes)
{
    /* A width at the limit in the document may be rounded below it. */
    if (!(precision->thinness < PEN_PRECISION_THIN * (1 - 0x1p-10)))
        return false;
    snprintf(out, bytes,
             "is %.3g wide and %.3g long: %.2g of its length, and below %.2g (2^-30) a closed body "
             "may leak light and shade itself; make it thicker, or leave it out",
             precision->thin_width, precision->thin_length, precision->thinness,
             PEN_PRECISION_THIN);
    return true;
}
