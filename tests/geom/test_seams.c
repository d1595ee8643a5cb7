/* SPDX-License-Identifier: MIT */
/* H073: no light enters a closed room at its seams. Rays are aimed at edges and corners. Rays then
 * start at the computed hit point, wherever rounding puts it. No ray back into the room gets out,
 * and no ray to a point inside is blocked. */
#include <check.h>

#include "geom/rows.h"
#include "support/rooms.h"
#include "support/suite.h"

static struct world world;

static const double offsets[] = {0, 1e3, 1e6};

enum { WAYS_ON = 6 };

/* Whether the ray meets something opaque, which is everything except a pane. */
static bool stopped(enum world_room room, const struct pen_ray *ray,
                    const struct pen_origin_surface *origin, double tmax)
{
    struct pen_hit hit[WAYS_ON];
    int count = world_intersections(&world, ray, origin, tmax, hit, WAYS_ON);
    for (int i = 0; i < count && i < WAYS_ON; i++) {
        if (room != ROOM_PANE || hit[i].prim < world.prims.count - 1)
            return true;
    }
    return false;
}

/* Continues from s in a random direction to the next hit; false if there is none. */
static bool bounce(struct random *r, struct stand *s)
{
    struct pen_origin_surface origin;
    struct pen_ray ray = world_ray(s->p, stand_turn(s, r, false, &origin));
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit = world_nearest(&world, &ray, &origin, &interval);
    if (hit.prim == PEN_NO_PRIM)
        return false;
    *s = world_stand(&world, &ray, &origin, hit);
    return true;
}

/* The hit of a ray from `eye` that is aimed at a seam. */
static struct stand look(struct random *r, vec3 eye)
{
    struct pen_ray ray = world_ray(eye, pen_sub(world_aim(&world, r), eye));
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit = world_nearest(&world, &ray, &pen_origin_none, &interval);
    ck_assert_uint_ne(hit.prim, PEN_NO_PRIM);
    return world_stand(&world, &ray, &pen_origin_none, hit);
}

/* d projected into the plane of some wall, as far as rounding allows. */
static vec3 along_wall(struct random *r, vec3 d)
{
    struct pen_hit wall = {0, random_below(r, world.prims.count), PEN_PART_SIDE};
    vec3 n = pen_prim_normal(&world.prims, wall, pen_vec3(0, 0, 0));
    return pen_along(d, n, -pen_dot(d, n));
}

START_TEST(test_seams__h073_no_way_out_of_a_closed_room)
{
    struct random r = random_begin(73);
    int rays = 0, leaks = 0;
    for (int i = 0; i < 360; i++) {
        enum world_room room = (enum world_room)(i % ROOM_COUNT);
        vec3 inside = world_room(&world, &r, room, offsets[i / ROOM_COUNT % 3]);
        for (int k = 0; k < 40; k++) {
            struct stand s = look(&r, inside);
            for (int b = 0; b < 3; b++) {
                for (int j = 0; j < 3; j++, rays++) { /* lights outside */
                    struct pen_origin_surface origin;
                    bool pane = room == ROOM_PANE && s.hit.prim == world.prims.count - 1;
                    vec3 d = stand_turn(&s, &r, pane && j == 0, &origin);
                    vec3 flat = along_wall(&r, d);
                    if (j == 1 && pen_dot(flat, s.n) > .1)
                        d = pen_normalize(flat);
                    struct pen_ray ray = world_ray(s.p, pen_scale(d, random_in(&r, 4, 9)));
                    leaks += !stopped(room, &ray, &origin, 1);
                }
                if (!bounce(&r, &s)) {
                    leaks++;
                    break;
                }
            }
        }
    }
    ck_assert_int_gt(rays, 100000);
    ck_assert_msg(leaks == 0, "%d leaks of %d rays; seed %llu", leaks, rays,
                  (unsigned long long)r.seed);
}
END_TEST

START_TEST(test_seams__light_inside_a_convex_room_is_seen)
{
    struct random r = random_begin(74);
    for (int i = 0; i < 180; i++) {
        enum world_room room = (enum world_room)(i % ROOM_CONVEX_COUNT);
        vec3 inside = world_room(&world, &r, room, offsets[i / ROOM_CONVEX_COUNT % 3]);
        for (int k = 0; k < 40; k++) {
            struct stand s = look(&r, inside);
            vec3 light = pen_along(inside, random_direction(&r), .1);
            struct pen_ray ray = world_ray(s.p, pen_sub(light, s.p));
            ck_assert_msg(!stopped(room, &ray, &s.origin, 1), "room %d, ray %d; seed %llu", room, k,
                          (unsigned long long)r.seed);
        }
    }
}
END_TEST

/* An open cylinder between two lids that are wider than it: the seam is a rim of the cylinder, and
 * inside the lids. */
START_TEST(test_seams__h073_no_way_out_of_a_drum)
{
    struct random r = random_begin(75);
    int rays = 0, leaks = 0;
    for (int i = 0; i < 300; i++) {
        double far = offsets[i % 3], radius = random_in(&r, .5, 1), h = random_in(&r, .5, 2);
        vec3 at = pen_vec3(far, -.5 * far, .25 * far), a = random_direction(&r);
        vec3 e = pen_normalize(pen_cross(a, random_direction(&r))), g = pen_cross(a, e);
        world_clear(&world);
        world_cylinder(&world, at, a, radius, h, false);
        for (int lid = 0; lid < 2; lid++) {
            vec3 v[4], c = pen_along(at, a, lid * h);
            for (int k = 0; k < 4; k++)
                v[k] = pen_along(pen_along(c, e, k & 2 ? 2 : -2), g, (k + 1) & 2 ? 2 : -2);
            world_polygon(&world, v, 4);
        }
        vec3 inside = pen_along(at, a, .4 * h);
        for (int k = 0; k < 60; k++) {
            double phi = random_in(&r, 0, 6.3);
            vec3 rim = pen_along(pen_along(at, e, radius * cos(phi)), g, radius * sin(phi));
            rim = pen_along(rim, a, k & 1 ? h : 0);
            struct pen_ray ray = world_ray(inside, pen_sub(rim, inside));
            struct pen_t_interval interval = {pen_after_start, INFINITY};
            struct pen_hit hit = world_nearest(&world, &ray, &pen_origin_none, &interval);
            if (hit.prim == PEN_NO_PRIM || hit.t > 1.01) /* not quite the rim: a gap of some ulps */
                continue;
            struct stand s = world_stand(&world, &ray, &pen_origin_none, hit);
            for (int j = 0; j < 4; j++, rays++) {
                struct pen_origin_surface origin;
                vec3 d = stand_turn(&s, &r, false, &origin);
                ray = world_ray(s.p, pen_scale(d, random_in(&r, 6, 9)));
                leaks += !stopped(ROOM_BOX, &ray, &origin, 1);
            }
        }
    }
    ck_assert_int_gt(rays, 50000);
    ck_assert_msg(leaks == 0, "%d leaks of %d rays; seed %llu", leaks, rays,
                  (unsigned long long)r.seed);
}
END_TEST

/* A point one ulp below a floor, and a light that is still below it where the next wall stands: the
 * wall on the floor is met, a wall that goes down from the floor's edge is not. */
START_TEST(test_seams__h073_light_round_the_foot_of_a_wall)
{
    for (int up = 0; up < 2; up++) {
        double z = up ? 1 : -1;
        const vec3 floor[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        const vec3 wall[4] = {{1, -1, 0}, {1, 1, 0}, {1, 1, z}, {1, -1, z}};
        world_clear(&world);
        struct pen_hit hit = {2, world_polygon(&world, floor, 4), PEN_PART_SIDE};
        world_polygon(&world, wall, 4);
        for (double far = 0x1p-46; far < 0x1p-25; far *= 2) { /* how far away the wall is */
            vec3 p = pen_vec3(1 - far, .25, -PEN_U), v = pen_vec3(.5, .25, -.5);
            struct pen_origin_surface origin = world_origin_surface(&world, hit, p, v, false);
            struct pen_ray ray = world_ray(p, pen_vec3(1, 0, .5 * PEN_U / far));
            int met = world_intersections(&world, &ray, &origin, 1, NULL, 0);
            ck_assert_msg(met == up, "wall at %a, upward %d: %d met", far, up, met);
        }
    }
}
END_TEST

/* Two path segments along the foot of a wall: if neither began beside it, the side of the wall is
 * that where the first began. */
START_TEST(test_seams__h073_the_way_before_tells_the_side)
{
    const vec3 floor[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    const vec3 wall[4] = {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}};
    world_clear(&world);
    struct pen_hit hit = {1, world_polygon(&world, floor, 4), PEN_PART_SIDE};
    world_polygon(&world, wall, 4);
    for (int side = -1; side <= 1; side += 2) {
        vec3 p = pen_vec3(1, .25, 0), along = pen_vec3(2 * side * PEN_U, .1, -.1);
        struct pen_origin_surface origin = world_origin_surface(&world, hit, p, along, false);
        origin.before = pen_vec3(side * .5, 0, .5);
        for (int to = -1; to <= 1; to += 2) {
            struct pen_ray ray = world_ray(p, pen_vec3(.5 * to, 0, .5));
            int met = world_intersections(&world, &ray, &origin, INFINITY, NULL, 0);
            ck_assert_msg(met == (to != side), "from %d to %d: %d met", side, to, met);
        }
    }
}
END_TEST

PEN_SUITE("seams", test_seams__h073_no_way_out_of_a_closed_room,
          test_seams__h073_no_way_out_of_a_drum, test_seams__light_inside_a_convex_room_is_seen,
          test_seams__h073_light_round_the_foot_of_a_wall,
          test_seams__h073_the_way_before_tells_the_side)
