/* SPDX-License-Identifier: MIT */
/* Packets of rays give the answers of single rays, bit for bit: for every kind of primitive, every
 * instruction set, and any number of rays, with primitives that touch and coincide. */
#include <stdio.h>
#include <string.h>

#include "accel/internal/test_doors.h"
#include "support/isa.h"
#include "support/rooms.h"
#include "support/suite.h"
#include "support/twin.h"

static struct world world;
static struct twin twin;
static const struct pen_prims *traced = &world.prims; /* or the twin's, with meshes */
static uint8_t see_through[WORLD_MAX];

/* Rays of a packet, and what they start on. */
struct rays {
    int count;
    struct pen_ray ray[PEN_RAY_PACKET_MAX];
    struct pen_origin_surface origin[PEN_RAY_PACKET_MAX];
    struct pen_hit after[PEN_RAY_PACKET_MAX];
};

static void add(struct rays *rays, struct pen_vec3 o, struct pen_vec3 d,
                const struct pen_origin_surface *origin)
{
    if (!pen_ray_make(&rays->ray[rays->count], o, d))
        return;
    rays->origin[rays->count] = *origin;
    rays->after[rays->count++] = pen_after_start;
}

static void begin(const struct rays *rays, struct pen_ray_packet *packet)
{
    packet->live = 0;
    pen_ray_array_begin(&packet->rays);
    pen_ray_packet_start(packet);
    for (int i = 0; i < rays->count; i++) {
        packet->live |= UINT64_C(1) << i;
        pen_ray_array_set(&packet->rays, i, &rays->ray[i]);
        pen_ray_packet_start_ray(packet, i, &rays->origin[i]);
        packet->after[i] = rays->after[i];
    }
}

static const char *place_of(const struct pen_ray *ray)
{
    static char text[200];
    snprintf(text, sizeof text, "o %a %a %a d %a %a %a", ray->o.x, ray->o.y, ray->o.z, ray->d.x,
             ray->d.y, ray->d.z);
    return text;
}

/* Compares the nearest hits, and returns the rays that have one; their hits are in hit[]. */
static uint64_t nearest(const struct pen_accel *accel, const struct pen_trace_ops *ops,
                        const struct rays *rays, struct pen_hit hit[PEN_RAY_PACKET_MAX])
{
    static struct pen_ray_packet packet;
    begin(rays, &packet);
    const uint64_t met = ops->nearest_packet(accel, &packet);
    for (int i = 0; i < rays->count; i++) {
        const struct pen_t_interval interval = {rays->after[i], INFINITY};
        const bool found = ops->nearest(accel, &rays->ray[i], &rays->origin[i], &interval, &hit[i]);
        ck_assert_msg((met >> i & 1) == found, "%s: met %d, alone %d", place_of(&rays->ray[i]),
                      (int)(met >> i & 1), found);
        const struct pen_hit h = packet.hit[i];
        ck_assert_msg(!found || (h.t == hit[i].t && h.prim == hit[i].prim && h.part == hit[i].part),
                      "%s: %a %u.%u, alone %a %u.%u", place_of(&rays->ray[i]), h.t, h.prim, h.part,
                      hit[i].t, hit[i].prim, hit[i].part);
    }
    return met;
}

static void shadow(const struct pen_accel *accel, const struct pen_trace_ops *ops,
                   const struct rays *rays, const struct pen_vec3 *light, const uint8_t *transmit,
                   uint32_t last)
{
    static struct pen_ray_packet packet;
    static struct pen_shadow query[PEN_RAY_PACKET_MAX], alone;
    const struct pen_shadow fresh = {.tmax = light ? 1 : INFINITY,
                                     .to_point = light != NULL,
                                     .see_through = transmit,
                                     .last_occluder = PEN_NO_PRIM};
    begin(rays, &packet);
    packet.last_occluder = last;
    packet.to_point = light != NULL;
    packet.see_through = transmit;
    packet.queries = query;
    if (light)
        packet.light = *light;
    const uint64_t blocked = ops->shadow_packet(accel, &packet);
    for (int i = 0; i < rays->count; i++) {
        alone = fresh;
        const bool b = ops->shadow(accel, &rays->ray[i], &rays->origin[i], &alone);
        ck_assert_msg((blocked >> i & 1) == b, "%s: blocked %d, alone %d", place_of(&rays->ray[i]),
                      (int)(blocked >> i & 1), b);
        if (b)
            continue;
        if (!(packet.recorded >> i & 1)) {
            ck_assert(!alone.overflow && alone.count == 0);
            continue;
        }
        ck_assert(query[i].overflow == alone.overflow);
        if (alone.overflow)
            continue;
        ck_assert_int_eq(query[i].count, alone.count);
        for (int k = 0; k < alone.count; k++)
            ck_assert(query[i].hit[k].t == alone.hit[k].t &&
                      query[i].hit[k].prim == alone.hit[k].prim &&
                      query[i].hit[k].part == alone.hit[k].part);
    }
}

/* The ways on from where rays have met something. */
enum turn { TO_LIGHT, ALONG_LIGHT, MIRRORED, ANYWHERE, TURN_COUNT };

/* Rays from the points of hits. */
static void turn(struct random *r, const struct rays *from, const struct pen_hit *hit, uint64_t met,
                 enum turn way, struct pen_vec3 light, struct rays *out)
{
    /* Points may be known less well than these. */
    const double worse = random_below(r, 3) ? 1 : exp2(random_in(r, 0, 16));
    out->count = 0;
    for (; met; met &= met - 1) {
        const int i = __builtin_ctzll(met);
        const struct pen_ray *ray = &from->ray[i];
        const struct pen_vec3 p = pen_prim_point(&world.prims, hit[i], ray);
        const struct pen_vec3 n = pen_prim_normal(&world.prims, hit[i], p);
        struct pen_origin_surface origin =
            pen_origin_at(&world.prims, ray, &from->origin[i], hit[i], p);
        struct pen_vec3 d = light;
        origin.bound *= worse;
        if (way == TO_LIGHT)
            d = pen_sub(light, p);
        else if (way == MIRRORED)
            d = pen_along(ray->d, n, -2 * pen_dot(n, ray->d));
        else if (way == ANYWHERE)
            d = random_direction(r);
        origin.through = (pen_dot(d, n) > 0) != (pen_dot(origin.toward, n) > 0);
        add(out, p, d, &origin);
    }
}

/* Compares all queries on packets that follow from one of rays. */
static void follow(struct random *r, const struct pen_accel *accel, const struct pen_trace_ops *ops,
                   const struct rays *rays, int depth)
{
    struct pen_hit hit[PEN_RAY_PACKET_MAX];
    const uint64_t met = nearest(accel, ops, rays, hit);
    if (!met || depth == 0)
        return;
    struct rays next = *rays;
    for (int i = 0; i < next.count; i++)
        if (met >> i & 1)
            next.after[i] = hit[i];
    nearest(accel, ops, &next, hit);
    for (int k = 0; k < 2; k++) {
        const uint32_t last = random_below(r, world.prims.count + 1);
        struct pen_vec3 light = random_vec(r, k ? 2 : 1);
        if (random_below(r, 3) == 0) /* on a surface */
            light = pen_prim_point(&world.prims, hit[__builtin_ctzll(met)],
                                   &rays->ray[__builtin_ctzll(met)]);
        turn(r, rays, hit, met, TO_LIGHT, light, &next);
        shadow(accel, ops, &next, &light, k ? see_through : NULL, last);
        light = random_direction(r);
        if (random_below(r, 3) == 0)
            light = pen_vec3(round(light.x), round(light.y), 1);
        turn(r, rays, hit, met, ALONG_LIGHT, light, &next);
        shadow(accel, ops, &next, NULL, k ? NULL : see_through, last);
        turn(r, rays, hit, met, k ? MIRRORED : ANYWHERE, light, &next);
        follow(r, accel, ops, &next, depth - 1);
    }
}

/* A corner of a primitive, a point of one of its edges, or a point of its box. */
static struct pen_vec3 aim(struct random *r)
{
    const uint32_t prim = random_below(r, world.prims.count);
    struct pen_triangle room;
    const struct pen_outline line = pen_prim_outline(&world.prims, prim, &room);
    if (line.count > 0) {
        const uint32_t i = random_below(r, line.count);
        const struct pen_vec3 a = line.v[i], b = line.v[i + 1 < line.count ? i + 1 : 0];
        return pen_along(a, pen_sub(b, a), random_below(r, 9) / 8.);
    }
    if (pen_prim_infinite(world.prims.ref[prim].kind))
        return random_vec(r, 1);
    const struct pen_box box = pen_prim_bounds(&world.prims, prim);
    const unsigned bits = random_below(r, 27);
    const double x = (bits % 3) / 2., y = (bits / 3 % 3) / 2., z = (bits / 9) / 2.;
    return pen_vec3(box.lo.x + x * (box.hi.x - box.lo.x), box.lo.y + y * (box.hi.y - box.lo.y),
                    box.lo.z + z * (box.hi.z - box.lo.z));
}

/* Most packets are full: those of few rays and many candidates are traced ray by ray. */
static int packet_count(struct random *r)
{
    return random_below(r, 4) ? PEN_RAY_PACKET_MAX : 1 + (int)random_below(r, PEN_RAY_PACKET_MAX);
}

/* Rays from an eye through points about `at`; widths from a whole picture to some ulps. */
static void look(struct random *r, struct pen_vec3 eye, struct pen_vec3 at, struct rays *out)
{
    const double width = exp2(random_in(r, -45, 0));
    const int count = packet_count(r);
    out->count = 0;
    for (int i = 0; i < count; i++)
        add(out, eye, pen_sub(pen_along(at, random_vec(r, 1), width), eye), &pen_origin_none);
}

/* From a point beside a seam, rays that pass the seam within rounding: the self-intersection rule
 * decides what they meet. */
static void graze(struct random *r, struct pen_vec3 eye, struct rays *out)
{
    const struct pen_vec3 seam = aim(r);
    const struct pen_vec3 at = pen_along(seam, random_direction(r), exp2(random_in(r, -45, -27)));
    struct pen_ray ray;
    out->count = 0;
    if (!pen_ray_make(&ray, eye, pen_sub(at, eye)))
        return;
    const struct pen_t_interval interval = {pen_after_start, INFINITY};
    const struct pen_hit hit = world_nearest(&world, &ray, &pen_origin_none, &interval);
    if (hit.prim == PEN_NO_PRIM)
        return;
    const struct stand s = world_stand(&world, &ray, &pen_origin_none, hit);
    const int count = packet_count(r);
    for (int i = 0; i < count; i++) {
        const struct pen_vec3 to =
            pen_along(seam, random_direction(r), exp2(random_in(r, -53, -48)));
        add(out, s.p, pen_scale(pen_sub(to, s.p), exp2(random_in(r, 0, 48))), &s.origin);
    }
}

static void each_isa(struct random *r, struct pen_vec3 eye, struct pen_vec3 at)
{
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    const enum pen_accelerator kind = random_below(r, 8) ? PEN_ACCEL_AUTO : PEN_ACCEL_MEDIAN;
    const struct pen_accel *accel = pen_accel_build_generic(traced, kind, 0, arena, &st);
    ck_assert(accel);
    struct rays rays;
    for (int k = 0; k < 8; k++) {
        if (k < 4)
            look(r, eye, k ? aim(r) : at, &rays);
        else
            graze(r, eye, &rays);
        for (int isa = 0; isa < isa_count(); isa++) {
            struct random same = *r;
            const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)isa);
            if (k >= 4)
                shadow(accel, ops, &rays, NULL, k & 1 ? see_through : NULL, PEN_NO_PRIM);
            follow(&same, accel, ops, &rays, k < 4 ? 2 : 1);
        }
        random_bits(r);
    }
    pen_arena_free(arena);
}

START_TEST(test_accel__ray_packets_in_random_scenes)
{
    struct random r = random_begin(301);
    for (int scene = 0; scene < random_cases(200); scene++) {
        world_clear(&world);
        world_random(&world, &r, 1 + random_below(&r, 60), random_in(&r, 0.02, 1));
        for (int i = 0; i < (scene & 3); i++) { /* as large as the rounding of where they are */
            const double size = exp2(random_in(&r, -54, -20));
            world_sphere(&world, random_vec(&r, 1), size);
            world_cylinder(&world, random_vec(&r, 1), random_direction(&r), size, size, i & 1);
        }
        if (scene % 3 == 0)
            world_cone(&world, random_vec(&r, 1), random_direction(&r), (const double[2]){.3, 0},
                       .5, random_below(&r, 2));
        if (scene % 5 == 0)
            world_bent(&world, &r, 5, random_in(&r, .1, 1));
        for (uint32_t i = 0; i < world.prims.count; i++)
            see_through[i] = random_below(&r, 3) != 0;
        each_isa(&r, random_vec(&r, 3), random_vec(&r, 1));
    }
}
END_TEST

/* Boxes on a lattice: faces that touch and coincide, rays along edges, diagonals and axes. */
START_TEST(test_accel__ray_packets_on_a_lattice)
{
    struct random r = random_begin(302);
    for (int scene = 0; scene < random_cases(150); scene++) {
        world_clear(&world);
        for (int i = 0; i < 10; i++) {
            struct pen_vec3 a = random_vec(&r, 2.5);
            a = pen_vec3(round(a.x), round(a.y), round(a.z));
            world_box(&world, a, pen_add(a, pen_vec3(1, 1, .5)));
            world_cylinder(&world, a, pen_vec3(0, 0, 1), .5, 1, random_below(&r, 2));
            world_sphere(&world, pen_along(a, pen_vec3(.5, .5, 1), 1), .5);
        }
        if (scene & 1)
            world_plane(&world, pen_vec3(0, 0, -1), pen_vec3(0, 0, 1));
        for (uint32_t i = 0; i < world.prims.count; i++)
            see_through[i] = random_below(&r, 3) == 0;
        struct pen_vec3 eye = random_vec(&r, 4);
        eye = pen_vec3(round(eye.x), round(eye.y), round(2 * eye.z) / 2);
        if (scene & 2) /* beside the lattice */
            eye = pen_along(eye, random_vec(&r, 1), exp2(random_in(&r, -20, -2)));
        each_isa(&r, eye, pen_add(eye, pen_vec3(1, 1, 1)));
    }
}
END_TEST

/* Rooms whose walls meet, cross and are round, seen at their seams. */
START_TEST(test_accel__ray_packets_in_rooms)
{
    struct random r = random_begin(303);
    static const double offsets[] = {0, 1e3, 1e6};
    for (int i = 0; i < random_cases(180); i++) {
        const enum world_room room = (enum world_room)(i % ROOM_COUNT);
        const struct pen_vec3 eye = world_room(&world, &r, room, offsets[i / ROOM_COUNT % 3]);
        for (uint32_t k = 0; k < world.prims.count; k++)
            see_through[k] = k == 6 && room == ROOM_PANE;
        if (i & 1)
            world_cylinder(&world, eye, random_direction(&r), .1, .1, true);
        each_isa(&r, i & 2 ? eye : pen_along(eye, random_direction(&r), .1), aim(&r));
    }
}
END_TEST

/* Meshes with other primitives before, between and behind them. */
START_TEST(test_accel__ray_packets_on_meshes)
{
    struct random r = random_begin(304);
    for (int scene = 0; scene < random_cases(60); scene++) {
        twin_clear(&twin, &world);
        for (int i = 0; i < 2; i++) {
            world_random(&world, &r, random_below(&r, 8), random_in(&r, 0.02, 1));
            twin_take(&twin);
            twin_mesh_begin(&twin, i ? random_vec(&r, 1) : pen_vec3(0, 0, 0), i ? 0.5 : 1);
            if (random_below(&r, 3))
                twin_ball(&twin, &r, 2 + random_below(&r, 8), 3 + random_below(&r, 8));
            else
                twin_hills(&twin, &r, 2 + random_below(&r, 8));
            twin_mesh_end(&twin);
        }
        world_sphere(&world, random_vec(&r, 1), .3);
        twin_take(&twin);
        for (uint32_t i = 0; i < pen_prim_slots(&twin.prims); i++)
            see_through[i] = random_below(&r, 3) != 0;
        traced = &twin.prims;
        each_isa(&r, random_vec(&r, 3), random_vec(&r, 1));
        traced = &world.prims;
    }
}
END_TEST

static const struct pen_accel *build_for_packets(struct pen_arena *arena)
{
    struct pen_status st;
    const struct pen_accel *accel =
        pen_accel_build_choice(&world.prims, PEN_AUTO_PACKETS, arena, &st);
    ck_assert(accel);
    return accel;
}

/* Follows the same rays with every instruction set. */
static void each_isa_follows(struct random *r, const struct pen_accel *accel,
                             const struct rays *rays)
{
    for (int isa = 0; isa < isa_count(); isa++) {
        struct random same = *r;
        follow(&same, accel, pen_trace_ops_get((enum pen_isa)isa), rays, 1);
    }
    random_bits(r);
}

/* Rays through points near one edge of a primitive, from the eye or from near it. */
static void look_along_edge(struct random *r, struct pen_vec3 eye, double width, struct rays *out)
{
    struct pen_triangle room;
    const struct pen_outline line =
        pen_prim_outline(&world.prims, random_below(r, world.prims.count), &room);
    const uint32_t k = random_below(r, line.count);
    const struct pen_vec3 a = line.v[k], e = pen_sub(line.v[k + 1 < line.count ? k + 1 : 0], a);
    const double apart = random_below(r, 2) ? .01 : 0;
    out->count = 0;
    for (int i = 0; i < PEN_RAY_PACKET_MAX; i++) {
        const struct pen_vec3 o = pen_along(eye, random_vec(r, 1), apart);
        const struct pen_vec3 at = pen_along(a, e, random_in(r, 0, 1));
        add(out, o, pen_sub(pen_along(at, random_vec(r, 1), width), o), &pen_origin_none);
    }
}

/* Rays from the eye through points near the circle in which a cylinder's side meets its top: base,
 * axis of length 1, radius; height 1. */
static void look_along_rim(struct random *r, struct pen_vec3 eye, const struct pen_vec3 cylinder[2],
                           double radius, double width, struct rays *out)
{
    const struct pen_vec3 middle = pen_add(cylinder[0], cylinder[1]);
    out->count = 0;
    for (int i = 0; i < PEN_RAY_PACKET_MAX; i++) {
        const struct pen_vec3 u = pen_normalize(pen_cross(cylinder[1], random_direction(r)));
        const struct pen_vec3 at = pen_along(middle, u, radius);
        add(out, eye, pen_sub(pen_along(at, random_vec(r, 1), width), eye), &pen_origin_none);
    }
}

/* Full packets of rays that pass four edges at distances of 2^width[0] to 2^width[1], and from
 * there on. */
static void each_isa_along_edges(struct random *r, struct pen_vec3 eye, const double width[2])
{
    struct pen_arena *arena = pen_arena_new(0);
    const struct pen_accel *accel = build_for_packets(arena);
    for (int k = 0; k < 4; k++) {
        struct rays rays;
        look_along_edge(r, eye, exp2(random_in(r, width[0], width[1])), &rays);
        each_isa_follows(r, accel, &rays);
    }
    pen_arena_free(arena);
}

/* Edges that triangles share, and on which they stand on a floor, within rounding. */
START_TEST(test_accel__ray_packets_along_edges)
{
    struct random r = random_begin(306);
    for (int i = 0; i < random_cases(60); i++) {
        struct pen_vec3 v[4], top = pen_vec3(random_in(&r, -.3, .3), random_in(&r, -.3, .3), 1);
        const struct pen_vec3 floor[4] = {pen_vec3(-4, -4, 0), pen_vec3(4, -4, 0),
                                          pen_vec3(4, 4, 0), pen_vec3(-4, 4, 0)};
        world_clear(&world);
        for (int k = 0; k < 4; k++)
            v[k] = pen_vec3(random_in(&r, .5, 1) * (k == 0 || k == 3 ? -1 : 1),
                            random_in(&r, .5, 1) * (k < 2 ? -1 : 1), 0);
        for (int k = 0; k < 4; k++)
            world_triangle(&world, v[k], v[(k + 1) % 4], top);
        world_polygon(&world, floor, 4);
        memset(see_through, i & 1, sizeof see_through);
        struct pen_vec3 eye = random_vec(&r, 3);
        eye.z = fabs(eye.z) + .5;
        each_isa_along_edges(&r, eye, (const double[2]){-56, -46});
    }
}
END_TEST

/* Outlines with one corner on an edge of a square, or pressed in by so little that they are nearly
 * convex. */
START_TEST(test_accel__ray_packets_at_nearly_convex_outlines)
{
    struct random r = random_begin(304);
    for (int i = 0; i < random_cases(40); i++) {
        const double z = random_in(&r, -1, 1), in = exp2(random_in(&r, -45, -30));
        const struct pen_vec3 v[5] = {pen_vec3(-1, -1, z), pen_vec3(0, i & 1 ? in - 1 : -1, z),
                                      pen_vec3(1, -1, z), pen_vec3(1, 1, z), pen_vec3(-1, 1, z)};
        world_clear(&world);
        world_polygon(&world, v, 5);
        see_through[0] = i & 2;
        each_isa(&r, pen_vec3(random_in(&r, -2, 2), random_in(&r, -2, 2), random_in(&r, -9, 9)),
                 pen_vec3(0, -1, z));
        each_isa_along_edges(&r, pen_along(v[0], random_vec(&r, 1), .1),
                             (const double[2]){-43, -38});
    }
}
END_TEST

/* Rays along n through the points `from` to `to` from p in direction u, as near one another as the
 * rounding of p, and their shadows. */
static void each_isa_along(struct random *r, struct pen_vec3 p, struct pen_vec3 n,
                           struct pen_vec3 u, const double from_to[2])
{
    struct pen_arena *arena = pen_arena_new(0);
    const struct pen_accel *accel = build_for_packets(arena);
    struct rays rays = {.count = 0};
    struct pen_hit hit[PEN_RAY_PACKET_MAX];
    for (int i = 0; i < PEN_RAY_PACKET_MAX; i++) {
        const struct pen_vec3 at = pen_along(p, u, random_in(r, from_to[0], from_to[1]));
        add(&rays, pen_along(at, n, -3), n, &pen_origin_none);
    }
    for (int isa = 0; isa < isa_count(); isa++) {
        nearest(accel, pen_trace_ops_get((enum pen_isa)isa), &rays, hit);
        shadow(accel, pen_trace_ops_get((enum pen_isa)isa), &rays, NULL, NULL, PEN_NO_PRIM);
    }
    pen_arena_free(arena);
}

/* Rays that touch a sphere or a cylinder within rounding, where they meet a plane too; and rays at
 * cylinders as thin as the rounding of where they are. */
START_TEST(test_accel__ray_packets_at_round_borders)
{
    struct random r = random_begin(305);
    for (int i = 0; i < random_cases(200); i++) {
        const struct pen_vec3 c = random_vec(&r, 1), n = random_direction(&r);
        const struct pen_vec3 u = pen_normalize(pen_cross(n, random_direction(&r)));
        const struct pen_vec3 a = pen_cross(n, u);
        const double size = exp2(random_in(&r, -10, 0)), off = exp2(random_in(&r, -48, -20));
        world_clear(&world);
        if (i & 1) {
            const double thin = exp2(random_in(&r, -53, -46));
            world_cylinder(&world, pen_along(c, a, -.5), a, thin, 1, i & 2);
            each_isa_along(&r, c, n, u, (const double[2]){-1.5 * thin, 1.5 * thin});
            continue;
        }
        if (i & 2)
            world_sphere(&world, c, size);
        else
            world_cylinder(&world, pen_along(c, a, -.5), a, size, 1, i & 4);
        world_plane(&world, c, n);
        each_isa_along(&r, c, n, u, (const double[2]){size * (1 - off), size * (1 + off)});
    }
}
END_TEST

/* Rays that pass where a cylinder's side meets its top, within rounding. */
START_TEST(test_accel__ray_packets_along_rims)
{
    struct random r = random_begin(307);
    for (int i = 0; i < random_cases(60); i++) {
        const struct pen_vec3 cylinder[2] = {random_vec(&r, 1), random_direction(&r)};
        const double radius = exp2(random_in(&r, -6, 1));
        world_clear(&world);
        world_cylinder(&world, cylinder[0], cylinder[1], radius, 1, i & 1);
        see_through[0] = i & 2;
        struct pen_arena *arena = pen_arena_new(0);
        const struct pen_accel *accel = build_for_packets(arena);
        for (int k = 0; k < 4; k++) {
            struct rays rays;
            look_along_rim(&r, random_vec(&r, 4), cylinder, radius, exp2(random_in(&r, -58, -46)),
                           &rays);
            each_isa_follows(&r, accel, &rays);
        }
        pen_arena_free(arena);
    }
}
END_TEST

PEN_SUITE("ray_packet", test_accel__ray_packets_along_edges, test_accel__ray_packets_along_rims,
          test_accel__ray_packets_at_round_borders, test_accel__ray_packets_in_random_scenes,
          test_accel__ray_packets_on_a_lattice, test_accel__ray_packets_in_rooms,
          test_accel__ray_packets_on_meshes, test_accel__ray_packets_at_nearly_convex_outlines)
