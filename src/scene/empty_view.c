/* SPDX-License-Identifier: MIT */
/* A primitive is invisible if it lies behind the eye, or wholly beyond one side of the pyramid of
 * camera rays. An infinite plane is beyond no side. It is invisible if the eye is on one side of it
 * and no ray goes towards it. */
#include "scene/empty_view.h"

#include <stdio.h>

#include "scene/internal/vec.h"

enum { SIDES = 4 };

/* The rays of a view, in the local frame. */
struct pyramid {
    struct pen_vec3 eye, forward;
    struct pen_vec3 corner[SIDES]; /* the directions of its edges */
    /* By side: a point p with n.(p - eye) < -beyond is beyond it. n is a unit vector. */
    struct pen_vec3 n[SIDES];
    double beyond[SIDES];
    double rounding; /* of places, a generous bound */
    bool lens;
};

/* Rays through a lens of radius R meet in the focal plane, at distance f, inside the pyramid of the
 * pinhole. Let m be the inward normal of a side of the pyramid. At distance s the rays satisfy m.(p
 * - eye) >= -R (1 + s / f). This is a side that leans outward. */
static void open_lens(struct pyramid *v, const struct pen_lens *lens, double middle)
{
    const double radius = pen_length(lens->right), share = radius / (lens->focus * middle);
    v->lens = lens->open;
    for (int i = 0; i < SIDES && lens->open; i++) {
        const struct pen_vec3 leaning = pen_along(v->n[i], v->forward, share);
        v->n[i] = vec_normalize(leaning);
        v->beyond[i] += radius / pen_length(leaning);
    }
}

static struct pyramid pyramid_of(const struct pen_scene *scene, int view, int width, int height)
{
    const struct pen_pinhole p = pen_scene_pinhole(scene, view, width, height);
    const struct pen_lens lens = pen_scene_lens(scene, view, &p);
    const struct pen_vec3 x = pen_scale(p.dx, p.half_width), y = pen_scale(p.dy, p.half_height);
    struct pyramid v = {.eye = p.eye, .forward = vec_normalize(p.middle)};
    v.corner[0] = pen_add(p.middle, pen_add(x, y));
    v.corner[1] = pen_add(p.middle, pen_sub(y, x));
    v.corner[2] = pen_sub(p.middle, pen_add(x, y));
    v.corner[3] = pen_add(p.middle, pen_sub(x, y));
    v.rounding = 0x1p-30 * (1 + vec_max_abs(v.eye));
    for (int i = 0; i < SIDES; i++) {
        const struct pen_vec3 m = pen_cross(v.corner[i], v.corner[(i + 1) % SIDES]);
        v.n[i] = vec_normalize(pen_dot(m, p.middle) < 0 ? pen_neg(m) : m);
        v.beyond[i] = v.rounding;
    }
    open_lens(&v, &lens, pen_length(p.middle));
    return v;
}

static bool plane_is_seen(const struct pen_plane *plane, const struct pyramid *v)
{
    const double height = pen_dot(plane->n, pen_sub(v->eye, plane->q));
    if (v->lens || fabs(height) <= v->rounding)
        return true;
    for (int i = 0; i < SIDES; i++)
        if (pen_dot(plane->n, v->corner[i]) * height < 0)
            return true;
    return false;
}

/* Whether a primitive may be visible. *behind: it is invisible because it is behind the eye. */
static bool may_be_seen(const struct pen_prims *prims, uint32_t prim, const struct pyramid *v,
                        bool *behind)
{
    struct pen_triangle room;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    const struct pen_kind_functions *fn = pen_kinds[ref.kind].fn;
    const void *self = pen_prim_self(prims, prim, &room);
    *behind = false;
    if (ref.kind == PEN_PRIM_PLANE)
        return plane_is_seen(self, v);
    *behind = fn->reach(self, v->forward, v->eye) < -v->rounding;
    for (int i = 0; i < SIDES && !*behind; i++)
        if (fn->reach(self, v->n[i], v->eye) < -v->beyond[i])
            return false;
    return !*behind;
}

/* The middle of the finite primitives, in scene units; false if there are none. */
static bool middle_of(const struct pen_scene *scene, struct pen_vec3 *out)
{
    struct pen_box all = pen_box_empty();
    for (uint32_t i = 0; i < scene->prims.count; i++)
        if (!pen_prim_infinite(pen_prim_kind(&scene->prims, i)))
            all = pen_box_union(all, pen_prim_bounds(&scene->prims, i));
    if (!(all.lo.x <= all.hi.x))
        return false;
    *out = pen_add(scene->center, vec_scale2_down(pen_box_center(all), -scene->exponent));
    return true;
}

bool pen_view_empty_warning(const struct pen_scene *scene, int view, int width, int height,
                            char *out, size_t bytes)
{
    const struct pyramid v = pyramid_of(scene, view, width, height);
    bool all_behind = true, behind;
    struct pen_vec3 middle;
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        if (may_be_seen(&scene->prims, i, &v, &behind))
            return false;
        all_behind = all_behind && behind;
    }
    if (scene->prims.count == 0)
        return false;
    const char *where = all_behind ? "all objects are behind the camera"
                                   : "all objects are behind the camera or beside the picture";
    if (middle_of(scene, &middle))
        snprintf(out, bytes, "nothing is visible: %s; look at their middle, [%.4g, %.4g, %.4g]",
                 where, middle.x, middle.y, middle.z);
    else
        snprintf(out, bytes, "nothing is visible: %s; turn the camera towards them", where);
    return true;
}
