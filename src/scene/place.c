/* SPDX-License-Identifier: MIT */
/* Placing primitives, and the local frame around them.
 *
 * The frame is taken from the points that primitives are anchored at and, apart from those, from
 * their radii and heights: sums of the two would round differently when a scene is moved, and the
 * frame would not move with it. */
#include "scene/internal/place.h"

#include "scene/internal/unit.h"

static bool finite_vec(struct pen_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void place_sphere(const struct pen_object_desc *o, struct pen_placed *p)
{
    p->kind = PEN_PRIM_SPHERE;
    p->point = o->u.sphere.center;
    p->radius = o->u.sphere.radius;
}

static void place_plane(const struct pen_object_desc *o, struct pen_placed *p)
{
    p->kind = PEN_PRIM_PLANE;
    p->point = o->u.plane.point;
    p->direction = o->u.plane.normal;
}

static void place_tube(const struct pen_object_desc *o, struct pen_placed *p)
{
    p->kind = PEN_PRIM_INFINITE_CYLINDER;
    p->point = o->u.infinite_cylinder.origin;
    p->direction = o->u.infinite_cylinder.axis;
    p->radius = o->u.infinite_cylinder.radius;
}

static void place_cylinder(const struct pen_object_desc *o, struct pen_placed *p)
{
    p->kind = PEN_PRIM_CYLINDER;
    p->point = o->u.cylinder.base;
    p->direction = o->u.cylinder.axis;
    p->radius = o->u.cylinder.radius;
    p->height = o->u.cylinder.height;
    p->caps = o->u.cylinder.caps;
}

static void place_loop(const struct pen_object_desc *o, struct pen_placed *p)
{
    p->kind = o->kind == PEN_OBJECT_TRIANGLE ? PEN_PRIM_TRIANGLE : PEN_PRIM_POLYGON;
    p->count = o->u.polygon.count;
    p->vertices = o->u.polygon.vertices;
}

static void place_as_written(const struct pen_object_desc *o, struct pen_placed *p)
{
    *p = (struct pen_placed){.material = o->material};
    switch (o->kind) {
    case PEN_OBJECT_SPHERE:
        place_sphere(o, p);
        break;
    case PEN_OBJECT_PLANE:
        place_plane(o, p);
        break;
    case PEN_OBJECT_INFINITE_CYLINDER:
        place_tube(o, p);
        break;
    case PEN_OBJECT_CYLINDER:
        place_cylinder(o, p);
        break;
    case PEN_OBJECT_TRIANGLE:
    case PEN_OBJECT_POLYGON:
        place_loop(o, p);
        break;
    case PEN_OBJECT_GROUP: /* the walk enters groups */
        break;
    }
}

static bool move_loop(const struct pen_transform *f, struct pen_vec3 *buffer, struct pen_placed *p)
{
    bool mirrored = pen_transform_det(f) < 0, finite = true;
    for (uint32_t i = 0; i < p->count; i++) {
        struct pen_vec3 v = pen_transform_point(f, p->vertices[i]);
        finite = finite && finite_vec(v);
        buffer[mirrored ? p->count - 1 - i : i] = v;
    }
    p->vertices = buffer;
    return finite;
}

static bool move_plane(const struct pen_transform *f, struct pen_placed *p)
{
    p->point = pen_transform_point(f, p->point);
    p->direction = pen_transform_normal(f, unit_of(p->direction));
    return finite_vec(p->point) && finite_vec(p->direction) && unit_max(p->direction) > 0;
}

static bool move_quadric(const struct pen_transform *f, double scale, struct pen_placed *p)
{
    p->point = pen_transform_point(f, p->point);
    p->radius *= scale;
    p->height *= scale;
    bool ok = finite_vec(p->point) && isfinite(p->radius) && isfinite(p->height) && p->radius > 0;
    if (p->kind == PEN_PRIM_SPHERE)
        return ok;
    p->direction = pen_transform_vector(f, unit_of(p->direction));
    return ok && finite_vec(p->direction) && unit_max(p->direction) > 0;
}

bool pen_place_primitive(const struct pen_walk_primitive *body, struct pen_vec3 *buffer,
                         struct pen_placed *placed, struct pen_status *st)
{
    place_as_written(body->object, placed);
    if (!body->moved)
        return true;
    bool flat = placed->count > 0 || placed->kind == PEN_PRIM_PLANE;
    if (!flat && !body->similar)
        return pen_fail(st, PEN_INVALID,
                        "a sphere, cylinder or tube can be turned, moved, mirrored and scaled, but "
                        "not stretched: the transforms around it are not a similarity");
    bool ok = placed->count > 0                ? move_loop(body->transform, buffer, placed)
              : placed->kind == PEN_PRIM_PLANE ? move_plane(body->transform, placed)
                                               : move_quadric(body->transform, body->scale, placed);
    if (!ok)
        return pen_fail(st, PEN_INVALID, "the transforms around it leave the range of numbers");
    return true;
}

struct pen_survey pen_survey_empty(void)
{
    return (struct pen_survey){.finite = pen_box_empty(), .infinite = pen_box_empty()};
}

void pen_survey_add(struct pen_survey *survey, const struct pen_placed *placed)
{
    survey->kind_count[placed->kind]++;
    survey->total++;
    if (placed->kind == PEN_PRIM_POLYGON)
        survey->polygon_vertices += placed->count;
    double reach = placed->radius + placed->height;
    if (pen_prim_infinite(placed->kind)) {
        survey->infinite = pen_box_add_point(survey->infinite, placed->point);
        survey->infinite_reach = pen_larger(survey->infinite_reach, reach);
        return;
    }
    survey->finite_reach = pen_larger(survey->finite_reach, reach);
    if (placed->count == 0)
        survey->finite = pen_box_add_point(survey->finite, placed->point);
    for (uint32_t i = 0; i < placed->count; i++)
        survey->finite = pen_box_add_point(survey->finite, placed->vertices[i]);
}

/* The multiple of 2^exponent next to x, halves upward: unlike halves to even, this moves with x
 * when x moves by any multiple. */
static double nearest_multiple(double x, int exponent)
{
    double steps = pen_scale2(x, -exponent);
    if (!(fabs(steps) < 0x1p52))
        return x; /* is one already */
    double low = floor(steps);
    return pen_scale2(steps - low >= 0.5 ? low + 1 : low, exponent);
}

bool pen_local_frame_make(const struct pen_survey *survey, const struct pen_camera_frame *cameras,
                          uint32_t camera_count, struct pen_local_frame *frame)
{
    struct pen_box box = survey->finite;
    double reach = survey->finite_reach;
    if (!(box.lo.x <= box.hi.x)) {
        box = survey->infinite;
        reach = survey->infinite_reach;
        for (uint32_t i = 0; i < camera_count; i++)
            box = pen_box_add_point(box, cameras[i].eye);
    }
    double extent = unit_max(pen_sub(box.hi, box.lo)) + 2 * reach;
    if (extent == 0)
        extent = pen_larger(unit_max(box.lo), 1);
    if (!isfinite(extent))
        return false;
    struct pen_vec3 middle = pen_box_center(box);
    frame->exponent = pen_exponent(extent);
    frame->center = pen_vec3(nearest_multiple(middle.x, frame->exponent),
                             nearest_multiple(middle.y, frame->exponent),
                             nearest_multiple(middle.z, frame->exponent));
    return true;
}

struct pen_vec3 pen_local_point(const struct pen_local_frame *frame, struct pen_vec3 p)
{
    return unit_shift(pen_sub(p, frame->center), frame->exponent);
}

double pen_local_length(const struct pen_local_frame *frame, double length)
{
    return pen_scale2(length, -frame->exponent);
}
