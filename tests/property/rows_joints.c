/* SPDX-License-Identifier: MIT */
/* Columns of capped cylinders and cones that stand on each other: a line along a joint, to an eye
 * or a light, meets the column. */
#include <math.h>

#include "math/scale.h"
#include "property/gen.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "support/kit.h"

static struct kit kit;

enum { PARTS_MAX = 3 };

/* Arguments: whether all numbers are dyadic, so that parts share their joints exactly; the number
 * of parts and which are cones, turned, and the joint that is looked at; the axis, the foot, the
 * offset of the document; radius and height of each part; the ray's angle about the axis, how far
 * it passes the axis in radii, its distance in radii, and its units beside the joint. */
static void draw_joints(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    const bool dyadic = random_below(r, 3) == 0;
    const double offset = dyadic || random_below(r, 2) ? 0 : gen_power(r, 0, 9);
    row_fixed(c, dyadic);
    row_fixed(c, 2 + random_below(r, PARTS_MAX - 1));
    row_fixed(c, random_below(r, 1 << PARTS_MAX));
    row_fixed(c, random_below(r, 1 << PARTS_MAX));
    row_fixed(c, random_below(r, 2));
    row_fixed(c, offset);
    row_arg3(c, dyadic || random_below(r, 3) == 0 ? gen_axial(r) : random_direction(r));
    row_arg3(c, dyadic ? gen_dyadic3(r, 4) : random_vec(r, 1));
    for (int i = 0; i < PARTS_MAX; i++) {
        row_arg(c, dyadic ? 1 + random_below(r, 32) / 16.0 : gen_power(r, -1, 1));
        row_arg(c, dyadic ? 1 + random_below(r, 32) / 16.0 : gen_power(r, -1, 1));
    }
    row_arg(c, random_in(r, 0, 6.3));
    row_arg(c, dyadic ? gen_dyadic(r, 14) / 16 : random_in(r, -.9, .9));
    row_arg(c, random_in(r, 1.5, 20));
    row_arg(c, dyadic ? 0 : (double)random_below(r, 5) - 2);
}

/* A part from `foot` up to `head`; a turned one is told from its head down. A cone is cut. */
static void add_part(vec3 foot, vec3 head, vec3 axis, double radius, double height, bool cone,
                     bool turned)
{
    vec3 base = turned ? head : foot;
    if (turned)
        axis = pen_neg(axis);
    struct pen_object_desc *o = kit_cylinder(&kit, base, axis, radius, height, 0);
    o->u.cylinder.caps = true;
    if (cone) {
        o->kind = PEN_OBJECT_CONE;
        o->u.cone.base = base;
        o->u.cone.axis = axis;
        o->u.cone.radius = radius;
        o->u.cone.top_radius = radius;
        o->u.cone.height = height;
        o->u.cone.caps = true;
        *(turned ? &o->u.cone.top_radius : &o->u.cone.radius) = 1.5 * radius;
    }
}

/* A line across the axis at the height of a point, that passes it within some of the least radius
 * of the parts there, and begins some of the largest away. */
static bool ray_past(const struct pen_scene *scene, vec3 at, vec3 axis, const struct row_case *c,
                     int arg, double least, double most, struct pen_ray *ray)
{
    const double angle = row_next(c, &arg), pass = row_next(c, &arg), far = row_next(c, &arg),
                 units = row_next(c, &arg);
    if (!(far > 1 && far < 1e3 && fabs(pass) < 0.95 && fabs(units) < 3))
        return false;
    vec3 x, y;
    struct random unused = {1, 0};
    gen_frame(&unused, axis, &x, &y);
    vec3 d = pen_along(pen_scale(x, cos(angle)), y, sin(angle)), side = pen_cross(axis, d);
    if (c->arg[0] != 0) { /* along an axis of the document, exactly */
        const bool along_x = axis.x == 0, level = pass < 0;
        d = pen_vec3(along_x && level, !along_x || (!level && axis.y == 0), 0);
        if (along_x && !level && axis.z == 0)
            d = pen_vec3(0, 0, 1);
        side = pen_cross(axis, d);
    }
    vec3 o = pen_along(pen_along(at, side, pass * least), d, -far * most);
    o = pen_along(o, axis, units * PEN_U * pen_norm1(o));
    const vec3 local = pen_sub(o, scene->center);
    return pen_ray_make(ray, pen_scale(local, ldexp(1, -scene->exponent)), d);
}

static void judge_joints(const struct row_case *c, struct row_verdict *v)
{
    int at = 6;
    const bool dyadic = c->arg[0] != 0;
    const int parts = (int)c->arg[1], cones = (int)c->arg[2], turned = (int)c->arg[3];
    const int joint = (int)c->arg[4] % (parts - 1);
    vec3 axis = row_next3(c, &at), foot = row_next3(c, &at), seam = foot;
    if (!(pen_norm1(axis) > 1e-3) || !(pen_norm1(foot) < 1e3)) {
        row_skip(v);
        return;
    }
    if (dyadic)
        axis = axis.x != 0   ? pen_vec3(axis.x > 0 ? 1 : -1, 0, 0)
               : axis.y != 0 ? pen_vec3(0, axis.y > 0 ? 1 : -1, 0)
                             : pen_vec3(0, 0, axis.z > 0 ? 1 : -1);
    axis = pen_normalize(axis);
    foot = pen_add(foot, gen_offset3(c->arg[5]));
    double least = INFINITY, most = 0;
    kit_init(&kit);
    kit_material(&kit, kit_matte(1));
    for (int i = 0; i < PARTS_MAX; i++) {
        const double radius = row_next(c, &at), height = row_next(c, &at);
        if (!(radius > 1e-3 && radius < 1e3 && height > 1e-3 && height < 1e3)) {
            row_skip(v);
            return;
        }
        if (i >= parts)
            continue;
        const vec3 head = pen_along(foot, axis, height);
        add_part(foot, head, axis, radius, height, cones >> i & 1, turned >> i & 1);
        if (i == joint || i == joint + 1) {
            least = radius < least ? radius : least;
            most = pen_larger(most, 1.5 * radius);
        }
        if (i == joint)
            seam = head;
        foot = head;
    }
    struct pen_scene *scene = kit_freeze(&kit);
    const struct primitives_tree tree = {NULL, scene->accel};
    struct pen_ray ray;
    bool alike;
    if (!ray_past(scene, seam, axis, c, at, least, most, &ray)) {
        row_skip(v);
        pen_scene_free(scene);
        return;
    }
    const struct pen_hit hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    row_tally(v, dyadic ? "joints shared exactly" : "joints rounded apart");
    row_require(v, alike, "instruction sets differ");
    row_require(v, hit.prim != PEN_NO_PRIM, "a line along a joint passes between the parts");
    if (dyadic)
        primitives_require(v, primitives_walk(&tree, &ray, 8), 2);
    pen_scene_free(scene);
}

void rows_joints(struct pen_row_run *run)
{
    row_each(run, draw_joints, judge_joints);
}
