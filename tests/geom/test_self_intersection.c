/* SPDX-License-Identifier: MIT */
/* Rays that start on surfaces do not meet the surface on which they start, and meet all others. */
#include <check.h>

#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

/* A random power of ten. */
static double power_of_ten(struct random *r, double least, double most)
{
    return pow(10, random_in(r, least, most));
}

static const double offsets[] = {0, 1e3, 1e6, 1e9}, radii[] = {1e-6, 1, 1e6};

/* A convex round primitive of kind `kind` (0 sphere, 1 infinite cylinder, 2 cylinder) as primitive
 * 0. */
static void make_round(struct random *r, int kind, double size, double far)
{
    vec3 at = pen_scale(pen_vec3(1, -.5, .25), far);
    world_clear(&world);
    if (kind == 0)
        world_sphere(&world, at, size);
    else if (kind == 1)
        world_infinite_cylinder(&world, at, random_direction(r), size);
    else
        world_cylinder(&world, at, random_direction(r), size, size * random_in(r, .5, 3), true);
}

/* Shoots at primitive 0 from a few sizes away until a ray hits; returns the start of the next
 * ray. */
static vec3 meet(struct random *r, double size, vec3 at, struct pen_hit *hit, vec3 *v)
{
    for (;;) {
        vec3 o = pen_along(at, random_direction(r), 5 * size);
        vec3 to = pen_add(at, random_vec(r, size));
        *v = pen_sub(to, o);
        struct pen_ray ray;
        if (!pen_ray_make(&ray, o, *v))
            continue;
        struct pen_t_interval interval = {pen_after_start, INFINITY};
        *hit = world_nearest(&world, &ray, &pen_origin_none, &interval);
        if (hit->prim != PEN_NO_PRIM)
            return pen_prim_point(&world.prims, *hit, &ray);
    }
}

/* The t at which the ray from p comes out of primitive 0, in quad, with p taken as a point of the
 * part. */
static quad way_out(int kind, struct pen_hit hit, vec3 p, vec3 d)
{
    const struct pen_cylinder_side *s =
        kind == 1 ? &world.infinite_cylinder[0].round : &world.cylinder[0].round;
    if (kind == 0) {
        struct quad3 f = quad_sub(quad3(p), quad3(world.sphere[0].c));
        return -2 * quad_dot(f, quad3(d)) / quad_dot(quad3(d), quad3(d));
    }
    struct quad3 a = quad3(s->a), f = quad_sub(quad3(p), quad3(s->q)), m = quad_cross(quad3(d), a);
    struct quad3 n = quad_cross(f, a);
    quad chord = -2 * quad_dot(m, n) / quad_dot(m, m);
    if (kind == 1)
        return chord;
    quad da = quad_dot(quad3(d), a), fa = quad_dot(f, a);
    quad top = (quad)world.cylinder[0].h * quad_sqrt(quad_dot(a, a));
    quad cap = da > 0 ? (top - fa) / da : -fa / da;
    if (hit.part != PEN_PART_SIDE) {
        quad side[2];
        cap = da > 0 ? top / da : -top / da;
        chord = 0;
        if (quad_tube(s->q, s->a, s->r, p, d, side) > 0)
            chord = side[1];
    }
    return chord < cap ? chord : cap;
}

/* H059, H061: no self-intersections outward, exactly one inward, to 4 ulp of -2 b / a. */
START_TEST(test_self_intersection__h059_h061_round_primitives)
{
    struct random r = random_begin(59);
    int inward = 0;
    for (int i = 0; i < 3600; i++) {
        int kind = i % 3;
        double size = radii[i / 3 % 3], far = offsets[i / 9 % 4];
        make_round(&r, kind, size, far);
        struct pen_hit hit, again[3];
        vec3 v, p = meet(&r, size, pen_scale(pen_vec3(1, -.5, .25), far), &hit, &v);
        vec3 n = pen_prim_normal(&world.prims, hit, p);
        for (int k = 0; k < 20; k++) {
            vec3 d = random_direction(&r);
            bool in = pen_dot(d, n) < 0;
            if (fabs(pen_dot(d, n)) < 1e-6)
                continue;
            struct pen_origin_surface origin = world_origin_surface(&world, hit, p, v, in);
            struct pen_ray ray = world_ray(p, d);
            int count = world_intersections(&world, &ray, &origin, INFINITY, again, 3);
            ck_assert_msg(count == in, "kind %d r %g at %g: %d intersections; seed %llu", kind,
                          size, far, count, (unsigned long long)r.seed);
            inward += in;
            if (!in || far > 1e3 * size) /* there the point is far off its surface */
                continue;
            quad truth = way_out(kind, hit, p, d);
            bool chord = kind < 2 || (hit.part == PEN_PART_SIDE && again[0].part == PEN_PART_SIDE);
            double ulps = quad_ulps(again[0].t, truth);
            vec3 m = pen_prim_normal(&world.prims, again[0], pen_along(p, d, again[0].t));
            double error = (double)quad_abs(again[0].t - truth) * fabs(pen_dot(m, d));
            ck_assert_msg(chord ? ulps <= 4 : error <= 32 * PEN_U * (4 * size + far),
                          "kind %d r %g at %g: %g ulp, %g", kind, size, far, ulps, error / size);
        }
    }
    ck_assert_int_gt(inward, 30000);
}
END_TEST

/* H060: flat primitives never meet themselves, of any size. */
START_TEST(test_self_intersection__h060_flat_primitives)
{
    struct random r = random_begin(60);
    for (int i = 0; i < 2000; i++) {
        double size = exp(random_in(&r, -8, 8));
        vec3 v[4];
        v[0] = random_vec(&r, 10);
        vec3 e = random_direction(&r), w = pen_cross(e, random_direction(&r));
        v[1] = pen_along(v[0], e, size);
        v[2] = pen_along(v[1], w, size);
        v[3] = pen_along(v[0], w, size);
        world_clear(&world);
        if (i & 1)
            world_triangle(&world, v[0], v[1], v[2]);
        else
            world_polygon(&world, v, 4);
        struct pen_hit hit;
        vec3 from, p = meet(&r, size, pen_along(v[0], e, .5 * size), &hit, &from);
        for (int k = 0; k < 20; k++) {
            struct pen_ray ray = world_ray(p, random_direction(&r));
            struct pen_origin_surface origin = world_origin_surface(&world, hit, p, from, k & 1);
            ck_assert_int_eq(world_intersections(&world, &ray, &origin, INFINITY, NULL, 0), 0);
        }
    }
}
END_TEST

/* Whether a ray from p on primitive `prim`, seen from `eye`, towards d meets anything. */
static bool blocked(uint32_t prim, vec3 eye, vec3 p, vec3 d)
{
    struct pen_hit on = {1, prim, PEN_PART_SIDE};
    vec3 n = pen_prim_normal(&world.prims, on, p), v = pen_sub(p, eye);
    bool through = (pen_dot(n, d) > 0) != (pen_dot(n, v) < 0);
    struct pen_origin_surface origin = world_origin_surface(&world, on, p, v, through);
    struct pen_ray ray = world_ray(p, d);
    return world_intersections(&world, &ray, &origin, INFINITY, NULL, 0) > 0;
}

/* H062: two triangles at 10^-k rad; a ray from one into the wedge meets the other. */
START_TEST(test_self_intersection__h062_dihedral)
{
    int smallest = 0;
    for (int k = 0; k <= 14; k++) {
        double angle = pow(10, -k);
        bool all = true;
        world_clear(&world);
        world_triangle(&world, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), pen_vec3(0, 0, 1));
        world_triangle(&world, pen_vec3(0, 0, 0), pen_vec3(1, sin(angle), 0), pen_vec3(0, 0, 1));
        struct random r = random_begin(62);
        for (int i = 0; i < 1000; i++) {
            vec3 p = pen_vec3(random_in(&r, .2, .6), 0, random_in(&r, .05, .15));
            vec3 to = pen_vec3(.5 * p.x, p.x * sin(angle), p.z); /* across the other face */
            vec3 eye = pen_vec3(1.5, .5 * sin(angle), .1);
            all = all && blocked(0, eye, p, pen_sub(to, p));
        }
        if (!all)
            break;
        smallest = k;
    }
    ck_assert_msg(smallest >= 12, "holds down to 1e-%d", smallest);
}
END_TEST

/* H063: an opaque sphere inside a glass one, with gaps down to 64u. */
START_TEST(test_self_intersection__h063_thin_shell)
{
    static const double gaps[] = {4e-5, 1e-8, 1e-12, 64 * PEN_U};
    struct random r = random_begin(63);
    for (int g = 0; g < 4; g++) {
        world_clear(&world);
        world_sphere(&world, pen_vec3(0, 0, 0), 1);
        world_sphere(&world, pen_vec3(0, 0, 0), 1 + gaps[g]);
        for (int i = 0; i < 2500; i++) {
            vec3 u = random_direction(&r), o = pen_scale(u, 3), v = pen_sub(random_vec(&r, .5), o);
            struct pen_ray ray = world_ray(o, v);
            struct pen_hit hit[4];
            int n = world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 4);
            ck_assert(n == 4 && hit[0].prim == 1 && hit[1].prim == 0);
            /* A ray into the glass meets the inner sphere next. */
            vec3 p = pen_prim_point(&world.prims, hit[0], &ray);
            vec3 d = pen_along(pen_normalize(v), random_direction(&r), .1);
            struct pen_origin_surface origin = world_origin_surface(&world, hit[0], p, v, true);
            struct pen_ray bent = world_ray(p, d);
            n = world_intersections(&world, &bent, &origin, INFINITY, hit, 4);
            ck_assert_msg(n == 3 && hit[0].prim == 0, "gap %g: %d", gaps[g], n);
            /* A ray outward from the inner sphere meets the glass, and nothing else. */
            p = pen_prim_point(&world.prims, hit[0], &bent);
            origin = world_origin_surface(&world, hit[0], p, d, false);
            bent = world_ray(
                p, pen_along(pen_sphere_normal(&world.sphere[0], p), random_direction(&r), .9));
            n = world_intersections(&world, &bent, &origin, INFINITY, hit, 4);
            ck_assert_msg(n == 1 && hit[0].prim == 1, "gap %g: %d outward", gaps[g], n);
        }
    }
}
END_TEST

static const vec3 square[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const vec3 turned[4] = {{-1, 1, 0}, {1, 1, 0}, {1, -1, 0}, {-1, -1, 0}};

/* H068, H069: of coincident primitives the first in the document is hit. A ray that starts there
 * does not meet the other on the near side, and meets it at its start when it goes through. */
START_TEST(test_self_intersection__h068_h069_coincident)
{
    struct random r = random_begin(68);
    for (int i = 0; i < 10000; i++) {
        int kind = i % 5;
        vec3 c = random_vec(&r, .3), a = random_direction(&r), flat[4];
        for (int k = 0; k < 4; k++)
            flat[k] = pen_add(square[k], c);
        world_clear(&world);
        for (int k = 0; k < 2; k++) {
            if (kind == 0)
                world_polygon(&world, k ? turned : square, 4);
            else if (kind == 1)
                world_polygon(&world, flat, 4);
            else if (kind == 2)
                world_sphere(&world, c, .7);
            else if (kind == 3)
                world_cylinder(&world, c, a, .5, .6, true);
            else
                world_infinite_cylinder(&world, c, a, .5);
        }
        vec3 v, d = random_direction(&r);
        struct pen_hit hit, next[5];
        vec3 p = meet(&r, .5, c, &hit, &v);
        ck_assert_uint_eq(hit.prim, 0);
        vec3 n = pen_prim_normal(&world.prims, hit, p);
        bool through = (pen_dot(n, d) > 0) != (pen_dot(n, v) < 0);
        struct pen_origin_surface origin = world_origin_surface(&world, hit, p, v, through);
        struct pen_ray ray = world_ray(p, d);
        int count = world_intersections(&world, &ray, &origin, INFINITY, next, 5);
        bool in = kind > 1 && pen_dot(n, d) < 0;
        ck_assert_msg(count == through + (in ? 2 : 0), "kind %d: %d intersections %s; seed %llu",
                      kind, count, in ? "inward" : "outward", (unsigned long long)r.seed);
        if (through)
            ck_assert(next[0].prim == 1 && next[0].t < PEN_LAST_LAYER_T);
        if (in) /* the ray comes out of both at once, of the first in the document first */
            ck_assert(next[through].t == next[through + 1].t && next[through].prim == 0 &&
                      next[through + 1].prim == 1);
    }
}
END_TEST

/* H071: spheres that touch in a point. */
START_TEST(test_self_intersection__h071_touching_spheres)
{
    struct pen_hit hit[5];
    world_clear(&world);
    world_sphere(&world, pen_vec3(1, 0, 0), 1);
    world_sphere(&world, pen_vec3(-1, 0, 0), 1);
    struct pen_ray ray = world_ray(pen_vec3(-3, 0, 0), pen_vec3(1, 0, 0));
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 5), 4);
    ck_assert(hit[0].t == 1 && hit[1].t == 3 && hit[2].t == 3 && hit[3].t == 5);
    ck_assert(hit[1].prim == 0 && hit[2].prim == 1);
    ck_assert_int_eq(world_count(&world, pen_vec3(0, -1, 0), pen_vec3(0, 1, 0)), 0);
    /* At the contact each sphere blocks the other's ray. */
    ck_assert(blocked(0, pen_vec3(0, 1, 0), pen_vec3(0, 0, 0), pen_vec3(-1, .001, 0)));
}
END_TEST

/* A point of the box's face f (as world_box numbers them) that is often on its edges or corners. */
static vec3 on_face(struct random *r, int f)
{
    const struct pen_polygon *pg = &world.polygon[f];
    double x = random_below(r, 2) ? random_unit(r) : random_below(r, 5) / 4.;
    double y = random_below(r, 2) ? random_unit(r) : random_below(r, 5) / 4.;
    vec3 e = pen_sub(pg->v[1], pg->v[0]), g = pen_sub(pg->v[3], pg->v[0]);
    return pen_along(pen_along(pg->v[0], e, x), g, y);
}

/* Outside of a box, at faces, edges and corners alike, no part of the box blocks a ray that goes
 * outward from a face, wherever the face is seen from; nor does a flush neighbour. */
START_TEST(test_self_intersection__convex_edges_and_seams_cast_no_shadow)
{
    struct random r = random_begin(65);
    for (int i = 0; i < 20000; i++) {
        vec3 c = random_vec(&r, 1);
        world_clear(&world);
        world_box(&world, c, pen_add(c, pen_vec3(.3, .4, .5)));
        if (i & 1)
            world_box(&world, pen_add(c, pen_vec3(.3, 0, .1)), pen_add(c, pen_vec3(.6, .4, .4)));
        int f = i & 1 ? 3 : (int)random_below(&r, 6); /* the flush face is +y */
        vec3 p = on_face(&r, f), n = world.polygon[f].facet.n;
        vec3 out = random_direction(&r), eye = random_direction(&r);
        out = pen_dot(out, n) < 0 ? pen_neg(out) : out;
        eye = pen_dot(eye, n) < 0 ? pen_neg(eye) : eye;
        ck_assert_msg(!blocked((uint32_t)f, pen_add(p, eye), p, out),
                      "ray %d from face %d; seed %llu", i, f, (unsigned long long)r.seed);
    }
}
END_TEST

/* H065: a box on the floor: from the floor at its foot, rays into the box are blocked, and rays
 * away from it are free. The foot of the left side is x = 0. */
START_TEST(test_self_intersection__h065_resting_box)
{
    struct random r = random_begin(66);
    for (int i = 0; i < 10000; i++) {
        double y = random_in(&r, -1, 1);
        const vec3 floor[4] = {{-5, y, -5}, {-5, y, 5}, {5, y, 5}, {5, y, -5}};
        world_clear(&world);
        if (i & 1)
            world_polygon(&world, floor, 4);
        else
            world_plane(&world, floor[0], pen_vec3(0, 1, 0));
        world_box(&world, pen_vec3(0, y, -1), pen_vec3(1, y + 1, 1));
        vec3 p = pen_vec3(i & 2 ? 0 : -random_unit(&r) * 1e-15, y, random_in(&r, -.9, .9));
        vec3 eye = pen_add(p, pen_vec3(-1, random_in(&r, .1, 2), random_in(&r, -1, 1)));
        vec3 side = pen_vec3(0, random_in(&r, .01, 1), random_in(&r, -.3, .3));
        ck_assert_msg(blocked(0, eye, p, pen_add(side, pen_vec3(1, 0, 0))), "into, %d", i);
        ck_assert_msg(!blocked(0, eye, p, pen_add(side, pen_vec3(-1, 0, 0))), "away, %d", i);
    }
}
END_TEST

/* In the corner of a room, exactly on a wall's foot and beside it, walls block rays. From the sides
 * that face the room nothing blocks rays back into it. */
START_TEST(test_self_intersection__corners_stop_rays)
{
    struct random r = random_begin(67);
    for (int i = 0; i < 10000; i++) {
        vec3 a = random_direction(&r), b = pen_normalize(pen_cross(a, random_direction(&r)));
        vec3 c = pen_cross(a, b), o = random_vec(&r, 1); /* floor normal a; walls b and c */
        vec3 e = pen_along(o, b, 2), f = pen_along(o, c, 2), g = pen_along(o, a, 2);
        const vec3 ground[4] = {o, e, pen_along(e, c, 2), f};
        const vec3 wall[4] = {o, g, pen_along(g, c, 2), f},
                   other[4] = {o, e, pen_along(e, a, 2), g};
        world_clear(&world);
        world_polygon(&world, ground, 4);
        world_polygon(&world, wall, 4);
        world_polygon(&world, other, 4);
        /* Some way off the wall, from a hair to an inch. */
        double off = pow(10, random_in(&r, -14, -1)), along = random_in(&r, .1, 1);
        vec3 p = pen_along(pen_along(o, b, off), c, along);
        vec3 eye = pen_add(p, pen_add(a, pen_add(pen_scale(b, random_in(&r, .1, 1)), c)));
        vec3 up = pen_along(pen_scale(a, random_in(&r, .1, 1)), c, random_in(&r, 0, .1));
        ck_assert_msg(blocked(0, eye, p, pen_sub(up, b)), "into the wall from %g", off);
        ck_assert_msg(!blocked(0, eye, p, pen_add(up, b)), "back from %g", off);
    }
}
END_TEST

/* A column of two cylinders: from its lower side, at and just below the joint, and off the side by
 * rounding, rays that go outward do not meet the upper cylinder within the rim of its cap. */
START_TEST(test_self_intersection__joint_of_a_column)
{
    struct random r = random_begin(68);
    for (int i = 0; i < 20000; i++) {
        world_clear(&world);
        world_cylinder(&world, pen_vec3(0, 0, -1), pen_vec3(0, 0, 1), 1, 1, true);
        world_cylinder(&world, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 1, 1, true);
        vec3 p = pen_vec3(1 - random_unit(&r) * 8 * PEN_U, 0, -power_of_ten(&r, -15, -9));
        vec3 out = pen_vec3(power_of_ten(&r, -6.5, 0), random_in(&r, -1, 1), random_unit(&r));
        vec3 eye = pen_vec3(random_in(&r, 1, 3), random_in(&r, -1, 1), random_in(&r, -1, 1));
        ck_assert_msg(!blocked(0, eye, p, out), "ray %d, seed %llu", i, (unsigned long long)r.seed);
    }
}
END_TEST

/* A face that ends flush with a surface, and rises over it only far away by the rounding of a
 * corner, does not stop a ray that passes its border within the bounds. */
START_TEST(test_self_intersection__far_corner_lifted_by_rounding)
{
    struct random r = random_begin(69);
    for (int i = 0; i < 20000; i++) {
        double lift = power_of_ten(&r, -13, -11), y = 1 + power_of_ten(&r, -9, -5);
        const vec3 top[4] = {{-1, 1, 0}, {0, 1, 0}, {0, 2, 0}, {-1, 2, 0}};
        const vec3 face[4] = {{0, 1, 0}, {0, 2, lift}, {0, 2, -1}, {0, 1, -1}};
        world_clear(&world);
        world_polygon(&world, top, 4);
        world_polygon(&world, face, 4);
        vec3 p = pen_vec3(-power_of_ten(&r, -13, -9), y, -4 * PEN_U * random_unit(&r));
        vec3 d = pen_vec3(1, random_in(&r, -1, 1), power_of_ten(&r, -6, -2));
        vec3 eye = pen_add(p, pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 1));
        ck_assert_msg(!blocked(0, eye, p, d), "ray %d, seed %llu", i, (unsigned long long)r.seed);
    }
}
END_TEST

PEN_SUITE("self_intersection", test_self_intersection__h059_h061_round_primitives,
          test_self_intersection__h060_flat_primitives, test_self_intersection__h062_dihedral,
          test_self_intersection__h063_thin_shell, test_self_intersection__h068_h069_coincident,
          test_self_intersection__h071_touching_spheres,
          test_self_intersection__convex_edges_and_seams_cast_no_shadow,
          test_self_intersection__h065_resting_box, test_self_intersection__corners_stop_rays,
          test_self_intersection__joint_of_a_column,
          test_self_intersection__far_corner_lifted_by_rounding)
