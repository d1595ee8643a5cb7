/* SPDX-License-Identifier: MIT */
/* Applies the transforms of groups to primitives. */
#include "scene/internal/scene_prim.h"

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
    case PEN_OBJECT_MESH:
    case PEN_OBJECT_GROUP: /* never: the iterator returns primitives only */
        break;
    }
    return (struct pen_prim_source){0};
}

static bool move_loop(const struct pen_transform *f, struct pen_vec3 *buffer,
                      struct pen_prim_source *p)
{
    bool mirrored = pen_transform_orientation(f) < 0, finite = true;
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

/* Transforms a quadric. A sphere has no direction. */
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

bool pen_scene_prim_make(const struct pen_desc_iter_item *item, struct pen_vec3 *buffer,
                         struct pen_scene_prim *scene_prim, struct pen_status *st)
{
    const struct pen_object_desc *object = item->object;
    struct pen_prim_source *from = &scene_prim->from;
    *scene_prim = (struct pen_scene_prim){.kind = (enum pen_prim_kind)object->kind,
                                          .material = object->material,
                                          .moved_by = item->moved ? item->transform : NULL,
                                          .from = source_of(object)};
    if (object->kind == PEN_OBJECT_MESH) {
        scene_prim->kind = PEN_PRIM_TRIANGLE;
        scene_prim->mesh = object->u.mesh;
        return true;
    }
    scene_prim->own = from->vertices;
    if (!item->moved)
        return true;
    bool flat = pen_prim_flat(scene_prim->kind);
    if (!flat && !item->similar)
        return pen_fail(
            st, PEN_INVALID,
            "a sphere, cylinder, cone or tube can be turned, moved, mirrored and scaled, but "
            "not stretched: the transforms around it are not a similarity");
    bool ok = pen_prim_outlined(scene_prim->kind) ? move_loop(item->transform, buffer, from)
              : flat                              ? move_plane(item->transform, from)
                                                  : move_round(item->transform, item->scale, from);
    if (!ok)
        return pen_fail(st, PEN_INVALID, "the transforms around it leave the range of numbers");
    return true;
}
