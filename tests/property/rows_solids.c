/* SPDX-License-Identifier: MIT */
/* Copies of a solid that groups move, turn, mirror and scale by a power of two, by any distance.
 * Where they overlap, the later in the document counts. */
#include "property/gen.h"
#include "property/rows.h"
#include "scene/solid.h"
#include "support/kit.h"

static struct kit kit;

enum shape { SPHERE, CYLINDER, CONE, WEDGE, SHAPES };
enum { COPIES = 3 };

/* Arguments: the shape, the power of two, the solid's place, axis, radius and height; of each copy
 * the axis and angle of its turn, its move, and whether it is mirrored. */
static void draw_equal(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    const double far = ldexp(1, (int)random_below(r, 31) - 10);
    row_fixed(c, random_below(r, SHAPES));
    row_fixed(c, (int)random_below(r, 41) - 20);
    row_arg3(c, random_vec(r, 1));
    row_arg3(c, random_direction(r));
    row_arg(c, 0.1 + (2 - 0.1) * random_unit(r));
    row_arg(c, 0.1 + (2 - 0.1) * random_unit(r));
    for (int i = 0; i < COPIES; i++) {
        row_fixed(c, random_below(r, 2));
        row_arg3(c, random_direction(r));
        row_arg(c, 0 + (360 - 0) * random_unit(r));
        row_arg3(c, random_vec(r, far));
    }
}

/* A wedge: two triangles and three quadrilaterals. */
static void add_wedge(vec3 at, double radius, double height, int material)
{
    static const int face[5][4] = {
        {0, 2, 1, 0}, {3, 4, 5, 3}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
    vec3 v[6], corner[4];
    for (int i = 0; i < 6; i++)
        v[i] = pen_add(at, pen_vec3(i % 3 == 1 ? radius : 0, i % 3 == 2 ? height : 0,
                                    i < 3 ? 0 : radius + height));
    for (int i = 0; i < 5; i++) {
        for (int k = 0; k < 4; k++)
            corner[k] = v[face[i][k]];
        kit_polygon(&kit, corner, i < 2 ? 3 : 4, material);
    }
}

static void add_shape(enum shape shape, vec3 at, vec3 axis, double radius, double height,
                      int material)
{
    if (shape == SPHERE) {
        kit_sphere(&kit, at, radius, material);
    } else if (shape == WEDGE) {
        add_wedge(at, radius, height, material);
    } else {
        struct pen_object_desc *o = kit_cylinder(&kit, at, axis, radius, height, material);
        o->u.cylinder.caps = true;
        if (shape == CONE) {
            o->kind = PEN_OBJECT_CONE;
            o->u.cone.base = at;
            o->u.cone.axis = axis;
            o->u.cone.radius = radius;
            o->u.cone.top_radius = 0.5 * radius;
            o->u.cone.height = height;
            o->u.cone.caps = true;
        }
    }
}

static void judge_equal(const struct row_case *c, struct row_verdict *v)
{
    int at = 2;
    const enum shape shape = (enum shape)c->arg[0];
    const vec3 place = row_next3(c, &at), axis = row_next3(c, &at);
    const double radius = row_next(c, &at), height = row_next(c, &at);
    if (!(radius > 1e-3 && height > 1e-3 && radius < 1e3 && height < 1e3 &&
          pen_norm1(axis) > 1e-3 && pen_norm1(place) < 1e3)) {
        row_skip(v);
        return;
    }
    kit_init(&kit);
    struct pen_material m = kit_matte(0);
    m.kt = pen_vec3(1, 1, 1);
    for (int i = 0; i < COPIES; i++) {
        const uint32_t first = kit.desc.object_count;
        m.ior = 1.25 + 0.25 * i; /* or faces of copies that touch would be joined */
        m.ior_written = true;
        add_shape(shape, place, axis, radius, height, kit_material(&kit, m));
        const bool mirrored = row_next(c, &at) != 0;
        const vec3 turn = row_next3(c, &at);
        const double angle = row_next(c, &at);
        const vec3 by = row_next3(c, &at);
        if (!(pen_norm1(turn) > 1e-3 && fabs(angle) < 1e3 && pen_norm1(by) < 0x1p30)) {
            row_skip(v);
            return;
        }
        struct pen_transform f = pen_transform_make(ldexp(1, (int)c->arg[1]), turn, angle, by);
        for (int k = 0; k < 3 && mirrored; k++)
            f.m[k][0] = -f.m[k][0];
        kit_group(&kit, first, &f);
    }
    struct pen_scene *scene = kit_freeze(&kit);
    const uint32_t faces = scene->prims.count / COPIES;
    row_tally(v, scene->solids.count == COPIES ? "three solids" : "other numbers");
    row_require(v, scene->solids.count == COPIES, "not as many solids as copies");
    for (uint32_t i = 0; i < COPIES && scene->solids.count == COPIES; i++)
        row_require(v, scene->solids.of_prim[i * faces] == i, "not the later one owns the overlap");
    pen_scene_free(scene);
}

void rows_solids_equal(struct pen_row_run *run)
{
    row_each(run, draw_equal, judge_equal);
}
