/* SPDX-License-Identifier: MIT */
#include "property/shape.h"

#include <string.h>

#include "property/gen.h"
#include "property/oracle.h"

static struct world world; /* of the shape that was crossed last */
static struct pen_ray shot;

const char *const shape_kind_name[SHAPE_KINDS] = {"sphere",   "tube",    "cylinder",
                                                  "triangle", "polygon", "plane"};

static const enum pen_prim_kind prim_kind[SHAPE_KINDS] = {
    PEN_PRIM_SPHERE,   PEN_PRIM_INFINITE_CYLINDER, PEN_PRIM_CYLINDER,
    PEN_PRIM_TRIANGLE, PEN_PRIM_POLYGON,           PEN_PRIM_PLANE};

int shape_points(enum shape_kind kind)
{
    return kind == SHAPE_TRIANGLE ? 3 : kind == SHAPE_POLYGON ? 4 : 1;
}

void shape_put(struct row_case *c, const struct shape *s)
{
    row_fixed(c, s->kind);
    for (int i = 0; i < shape_points(s->kind); i++)
        row_arg3(c, s->p[i]);
    row_arg3(c, s->a);
    row_arg(c, s->r);
    row_arg(c, s->h);
    row_arg3(c, s->o);
    row_arg3(c, s->d);
}

bool shape_get(const struct row_case *c, int *at, struct shape *s)
{
    s->kind = (enum shape_kind)row_next(c, at);
    if (s->kind >= SHAPE_KINDS)
        return false;
    for (int i = 0; i < shape_points(s->kind); i++)
        s->p[i] = row_next3(c, at);
    s->a = row_next3(c, at);
    s->r = fabs(row_next(c, at));
    s->h = fabs(row_next(c, at));
    s->o = row_next3(c, at);
    s->d = row_next3(c, at);
    return true;
}

vec3 shape_snap(vec3 p, bool snapped)
{
    return snapped ? pen_vec3(ldexp(nearbyint(ldexp(p.x, 12)), -12),
                              ldexp(nearbyint(ldexp(p.y, 12)), -12),
                              ldexp(nearbyint(ldexp(p.z, 12)), -12))
                   : p;
}

struct shape shape_draw(struct random *r, enum shape_kind kind, bool snapped)
{
    struct shape s = {.kind = kind};
    vec3 at = shape_snap(random_vec(r, 2), snapped), x, y;
    s.a = random_below(r, 4) ? random_direction(r) : gen_axial(r);
    s.r = random_in(r, .1, 1);
    s.h = random_in(r, .2, 2);
    gen_frame(r, pen_normalize(s.a), &x, &y);
    s.p[0] = at;
    s.p[1] = shape_snap(pen_along(at, x, random_in(r, .5, 1)), snapped);
    s.p[2] = shape_snap(pen_along(s.p[1], y, random_in(r, .5, 1)), snapped);
    s.p[3] = pen_add(at, pen_sub(s.p[2], s.p[1]));
    vec3 to = pen_add(at, random_vec(r, .8));
    if (kind == SHAPE_TRIANGLE || kind == SHAPE_POLYGON) {
        double i = random_below(r, 3) ? random_unit(r) : random_below(r, 3) / 2.;
        to = pen_along(pen_along(at, pen_sub(s.p[1], at), i), pen_sub(s.p[2], s.p[1]),
                       i * random_unit(r));
    }
    s.o = shape_snap(pen_along(at, random_direction(r), gen_power(r, 0, 1)), snapped);
    s.d = gen_toward(r, s.o, to);
    return s;
}

const struct shape_map shape_map_identity = {{1, 1, 1}, {0, 0, 0}, 0, 1};

vec3 shape_map_way(const struct shape_map *m, vec3 v)
{
    v = pen_mul(v, m->sign);
    return m->turn == 0 ? v : m->turn == 1 ? pen_vec3(v.y, v.z, v.x) : pen_vec3(v.z, v.x, v.y);
}

vec3 shape_map_point(const struct shape_map *m, vec3 p)
{
    return pen_add(pen_scale(shape_map_way(m, p), m->factor), m->shift);
}

struct shape shape_mapped(const struct shape_map *m, const struct shape *s)
{
    struct shape t = *s;
    for (int i = 0; i < 4; i++)
        t.p[i] = shape_map_point(m, s->p[i]);
    t.a = shape_map_way(m, s->a);
    t.r = s->r * m->factor;
    t.h = s->h * m->factor;
    t.o = shape_map_point(m, s->o);
    t.d = shape_map_way(m, s->d);
    return t;
}

bool shape_cross(const struct shape *s, struct pen_intersections *out)
{
    bool made = false;
    world_clear(&world);
    world.prims.count = 1;
    world.ref[0].kind = (uint32_t)prim_kind[s->kind] & 15u;
    world.ref[0].index = 0;
    switch (s->kind) {
    case SHAPE_SPHERE:
        made = pen_sphere_make(&world.sphere[0], s->p[0], s->r);
        break;
    case SHAPE_INFINITE_CYLINDER:
        made = pen_infinite_cylinder_make(&world.infinite_cylinder[0], s->p[0], s->a, s->r);
        break;
    case SHAPE_CYLINDER:
        made = pen_cylinder_make(&world.cylinder[0], s->p[0], s->a, s->r, s->h, true);
        break;
    case SHAPE_TRIANGLE:
        made = pen_triangle_make(&world.triangle[0], s->p[0], s->p[1], s->p[2]);
        break;
    case SHAPE_POLYGON:
        memcpy(world.corner, s->p, sizeof s->p);
        made = pen_polygon_make(&world.polygon[0], world.corner, 4);
        break;
    case SHAPE_PLANE:
        made = pen_plane_make(&world.plane[0], s->p[0], s->a);
        break;
    case SHAPE_KINDS:
        return false;
    }
    if (!made || !pen_ray_make(&shot, s->o, s->d))
        return false;
    pen_prim_intersect(&world.prims, 0, &shot, &pen_origin_none, out);
    return true;
}

void shape_at(const struct pen_intersections *x, int i, vec3 *point, vec3 *normal)
{
    struct pen_hit hit = {x->t[i], 0, x->part[i]};
    *point = pen_prim_point(&world.prims, hit, &shot);
    *normal = pen_prim_normal(&world.prims, hit, *point);
}

void shape_require_equal(struct row_verdict *v, enum shape_kind kind,
                         const struct pen_intersections *a, const struct pen_intersections *b,
                         double factor)
{
    if (a->count != b->count) {
        row_fail(v, "%s: %d intersections became %d", shape_kind_name[kind], a->count, b->count);
        return;
    }
    for (int i = 0; i < a->count; i++) {
        if (a->t[i] * factor != b->t[i])
            row_fail(v, "%s: t = %a became %a", shape_kind_name[kind], a->t[i], b->t[i]);
        if (a->part[i] != b->part[i])
            row_fail(v, "%s: the part changed", shape_kind_name[kind]);
    }
}

bool shape_on_border(const struct shape *s)
{
    bool unsure = false;
    if (s->kind == SHAPE_TRIANGLE || s->kind == SHAPE_POLYGON)
        oracle_winding(s->p, shape_points(s->kind), (struct oracle_ray){s->o, s->d}, 8, &unsure);
    return unsure;
}
