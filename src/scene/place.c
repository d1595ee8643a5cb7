/* SPDX-License-Identifier: MIT */
/* Placing primitives, and the local frame around them.
 *
 * The frame is taken from the points that primitives are anchored at and, apart from those, from
 * their radii and heights: sums of the two would round differently when a scene is moved, and the
 * frame would not move with it. */
#include "scene/internal/place.h"

#include "scene/internal/vec.h"

static bool finite_vec(struct pen_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static struct pen_prim_source source_of(const struct pen_object_desc *o)
{
    switch (o->kind) {
    case PEN_OBJECT_SPHERE:
        return (struct pen_prim_source){.point = o->u.sphere.center,
                                        .length = {[PEN_RADIUS] = o->u.sphere.radius}};
    case PEN_OBJECT_PLANE:
        return (struct pen_prim_source){.point = o->u.plane.point, .direction = o->u.plane.normal};
    case PEN_OBJECT_INFINITE_CYLINDER:
        return (struct pen_prim_source){.point = o->u.infinite_cylinder.origin,
                                        .direction = o->u.infinite_cylinder.axis,
                                        .length = {[PEN_RADIUS] = o->u.infinite_cylinder.radius}};
    case PEN_OBJECT_CYLINDER:
        return (struct pen_prim_source){
            .point = o->u.cylinder.base,
            .direction = o->u.cylinder.axis,
            .length = {[PEN_RADIUS] = o->u.cylinder.radius, [PEN_HEIGHT] = o->u.cylinder.height},
            .caps = o->u.cylinder.caps};
    case PEN_OBJECT_CONE:
        return (struct pen_prim_source){.point = o->u.cone.base,
                                        .direction = o->u.cone.axis,
                                        .length = {[PEN_RADIUS] = o->u.cone.radius,
                                                   [PEN_TOP_RADIUS] = o->u.cone.top_radius,
                                                   [PEN_HEIGHT] = o->u.cone.height},
                                        .caps = o->u.cone.caps};
    case PEN_OBJECT_TRIANGLE:
    case PEN_OBJECT_POLYGON:
        return (struct pen_prim_source){.count = o->u.polygon.count,
                                        .vertices = o->u.polygon.vertices};
    case PEN_OBJECT_GROUP: /* the walk enters groups */
        break;
    }
    return (struct pen_prim_source){0};
}

static bool move_loop(const struct pen_transform *f, struct pen_vec3 *buffer,
                      struct pen_prim_source *p)
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

static bool move_plane(const struct pen_transform *f, struct pen_prim_source *p)
{
    p->point = pen_transform_point(f, p->point);
    p->direction = pen_transform_normal(f, vec_normalize(p->direction));
    return finite_vec(p->point) && finite_vec(p->direction) && vec_max_abs(p->direction) > 0;
}

/* A sphere has no direction to turn. */
static bool move_round(const struct pen_transform *f, double scale, struct pen_prim_source *p)
{
    p->point = pen_transform_point(f, p->point);
    bool ok = finite_vec(p->point);
    for (int i = 0; i < PEN_LENGTHS; i++) {
        p->length[i] *= scale;
        ok = ok && isfinite(p->length[i]);
    }
    ok = ok && p->length[PEN_RADIUS] > 0;
    if (vec_max_abs(p->direction) == 0)
        return ok;
    p->direction = pen_transform_vector(f, vec_normalize(p->direction));
    return ok && finite_vec(p->direction) && vec_max_abs(p->direction) > 0;
}

bool pen_place_primitive(const struct pen_desc_iter_item *item, struct pen_vec3 *buffer,
                         struct pen_placed *placed, struct pen_status *st)
{
    const struct pen_object_desc *object = item->object;
    struct pen_prim_source *from = &placed->from;
    *placed = (struct pen_placed){.kind = (enum pen_prim_kind)object->kind,
                                  .material = object->material,
                                  .from = source_of(object)};
    if (!item->moved)
        return true;
    bool flat = pen_prim_flat(placed->kind);
    if (!flat && !item->similar)
        return pen_fail(
            st, PEN_INVALID,
            "a sphere, cylinder, cone or tube can be turned, moved, mirrored and scaled, but "
            "not stretched: the transforms around it are not a similarity");
    bool ok = pen_prim_outlined(placed->kind) ? move_loop(item->transform, buffer, from)
              : flat                          ? move_plane(item->transform, from)
                                              : move_round(item->transform, item->scale, from);
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
    const struct pen_prim_source *from = &placed->from;
    survey->kind_count[placed->kind]++;
    survey->total++;
    if (pen_kinds[placed->kind].fn->keeps_vertices)
        survey->kept_vertices += from->count;
    double reach = pen_larger(from->length[PEN_RADIUS], from->length[PEN_TOP_RADIUS]) +
                   from->length[PEN_HEIGHT];
    if (pen_prim_infinite(placed->kind)) {
        survey->infinite = pen_box_add_point(survey->infinite, from->point);
        survey->infinite_reach = pen_larger(survey->infinite_reach, reach);
        return;
    }
    survey->finite_reach = pen_larger(survey->finite_reach, reach);
    if (from->count == 0)
        survey->finite = pen_box_add_point(survey->finite, from->point);
    for (uint32_t i = 0; i < from->count; i++)
        survey->finite = pen_box_add_point(survey->finite, from->vertices[i]);
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
    double extent = vec_max_abs(pen_sub(box.hi, box.lo)) + 2 * reach;
    if (extent == 0)
        extent = pen_larger(vec_max_abs(box.lo), 1);
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
    return vec_scale2_down(pen_sub(p, frame->center), frame->exponent);
}

double pen_local_length(const struct pen_local_frame *frame, double length)
{
    return pen_scale2(length, -frame->exponent);
}
