/* SPDX-License-Identifier: MIT */
/* Every accelerator and every compiled variant gives the same intersections as trying all
 * primitives, bit for bit. */
#include "accel/internal/test_doors.h"
#include "support/isa.h"
#include "support/rooms.h"
#include "support/suite.h"

static struct world world;

/* Every accelerator, manual with groups and without; every accelerator once more with some kinds of
 * primitives in generic blocks; and the tree, whether or not `auto` chooses it. */
enum { GENERIC = PEN_ACCEL_COUNT + 1, TREE = GENERIC + PEN_ACCEL_COUNT, ACCELS };

/* Every accelerator with every instruction set. */
struct variants {
    struct pen_arena *arena;
    const struct pen_accel *accel[ACCELS];
};

/* Random groups of the world's primitives, in order, nested; some are empty, some equal. */
static void random_groups(struct random *random, uint32_t begin, uint32_t end, int depth,
                          struct pen_group_range *group, uint32_t *count)
{
    while (begin < end && *count < WORLD_MAX) {
        uint32_t inner = begin + random_below(random, end - begin + 1);
        if (depth == 0 || random_below(random, 3) == 0) {
            begin += 1 + random_below(random, 5);
            continue;
        }
        group[(*count)++] = (struct pen_group_range){begin, inner};
        random_groups(random, begin, inner, depth - 1, group, count);
        begin = inner + random_below(random, 2);
    }
}

static struct variants build(const struct world *w, struct random *random)
{
    static struct pen_group_range group[WORLD_MAX];
    struct pen_status st;
    struct variants variants = {.arena = pen_arena_new(0)};
    struct pen_groups groups = {group, 0};
    random_groups(random, 0, w->prims.count, 8, group, &groups.count);
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        variants.accel[kind] =
            pen_accel_build(&w->prims, (enum pen_accelerator)kind, variants.arena, &st);
    variants.accel[PEN_ACCEL_COUNT] =
        pen_accel_build_manual(&w->prims, &groups, variants.arena, &st);
    unsigned kinds = (1u << PEN_PRIM_KIND_COUNT) - 1;
    if (random_below(random, 2))
        kinds &= random_below(random, kinds + 1);
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        variants.accel[GENERIC + kind] = pen_accel_build_generic(
            &w->prims, (enum pen_accelerator)kind, kinds, variants.arena, &st);
    variants.accel[TREE] = pen_accel_build_choice(&w->prims, PEN_AUTO_TREE, variants.arena, &st);
    for (int i = 0; i < ACCELS; i++)
        ck_assert(variants.accel[i]);
    return variants;
}

/* Variants are the accelerators with each instruction set. */
static const struct pen_trace_ops *ops_of(int variant)
{
    return pen_trace_ops_get((enum pen_isa)(variant / ACCELS));
}

/* Compares one nearest query; returns the hit. */
static struct pen_hit nearest(const struct world *w, const struct variants *variants,
                              const struct pen_ray *ray, const struct pen_origin_surface *origin,
                              const struct pen_t_interval *interval)
{
    struct pen_hit truth = world_nearest(w, ray, origin, interval);
    for (int i = 0; i < ACCELS * isa_count(); i++) {
        struct pen_hit hit = {0, PEN_NO_PRIM, 0};
        bool found = ops_of(i)->nearest(variants->accel[i % ACCELS], ray, origin, interval, &hit);
        ck_assert_msg(
            found == (truth.prim != PEN_NO_PRIM) &&
                (!found || (hit.t == truth.t && hit.prim == truth.prim && hit.part == truth.part)),
            "variant %d: o %a %a %a d %a %a %a: %a %u.%u, not %a %u.%u", i, ray->o.x, ray->o.y,
            ray->o.z, ray->d.x, ray->d.y, ray->d.z, hit.t, hit.prim, hit.part, truth.t, truth.prim,
            truth.part);
    }
    return truth;
}

/* Compares one shadow query with a walk over all intersections; true if the ray is blocked. The
 * hint last_occluder must not matter: each primitive is tried in turn. */
static bool shadow(const struct world *w, const struct variants *variants,
                   const struct pen_ray *ray, const struct pen_origin_surface *origin,
                   const uint8_t *see_through)
{
    static uint32_t last;
    bool blocked = false;
    int count = 0;
    struct pen_hit kept[PEN_SHADOW_MAX];
    struct pen_t_interval interval = {pen_after_start, nextafter(1, 0)};
    for (;;) {
        struct pen_hit h = world_nearest(w, ray, origin, &interval);
        if (h.prim == PEN_NO_PRIM)
            break;
        if (!see_through || !see_through[h.prim]) {
            blocked = true;
            break;
        }
        if (count < PEN_SHADOW_MAX)
            kept[count] = h;
        count++;
        interval.after = h;
    }
    for (int i = 0; i < ACCELS * isa_count(); i++) {
        struct pen_shadow query = {.tmax = 1, .see_through = see_through};
        query.last_occluder =
            i % ACCELS == 0 && w->prims.count ? last++ % w->prims.count : PEN_NO_PRIM;
        bool b = ops_of(i)->shadow(variants->accel[i % ACCELS], ray, origin, &query);
        ck_assert_msg(b == blocked, "variant %d: blocked %d, not %d", i, b, blocked);
        if (blocked)
            continue;
        ck_assert(query.overflow == (count > PEN_SHADOW_MAX));
        if (query.overflow)
            continue;
        ck_assert_int_eq(query.count, count);
        for (int k = 0; k < count; k++)
            ck_assert(query.hit[k].t == kept[k].t && query.hit[k].prim == kept[k].prim &&
                      query.hit[k].part == kept[k].part);
    }
    return blocked;
}

/* A path of a few bounces through the world, comparing every query on it. */
static void follow_path(struct random *random, const struct variants *variants,
                        const uint8_t *see_through)
{
    struct pen_origin_surface origin = pen_origin_none;
    struct pen_vec3 o = random_vec(random, 2), d = random_direction(random);
    if (random_below(random, 4) == 0)
        o = pen_vec3(round(4 * o.x) / 4, round(4 * o.y) / 4, round(4 * o.z) / 4);
    if (random_below(random, 4) == 0)
        d = pen_vec3(round(d.x), round(d.y), round(d.z) == 0 ? 1 : round(d.z));
    for (int bounce = 0; bounce < 4; bounce++) {
        struct pen_ray ray = world_ray(o, d);
        struct pen_t_interval interval = {pen_after_start, random_below(random, 3) ? INFINITY : 1};
        shadow(&world, variants, &ray, &origin, see_through);
        shadow(&world, variants, &ray, &origin, NULL);
        struct pen_hit hit = nearest(&world, variants, &ray, &origin, &interval);
        if (hit.prim == PEN_NO_PRIM)
            return;
        interval.after = hit;
        nearest(&world, variants, &ray, &origin, &interval);
        interval = (struct pen_t_interval){pen_after_start, hit.t}; /* H094: tmax is inclusive */
        nearest(&world, variants, &ray, &origin, &interval);
        interval.tmax = nextafter(hit.t, 0);
        nearest(&world, variants, &ray, &origin, &interval);
        o = pen_prim_point(&world.prims, hit, &ray);
        origin = world_origin_surface(&world, hit, o, pen_scale(d, hit.t), false);
        struct pen_vec3 n = pen_prim_normal(&world.prims, hit, o);
        struct pen_vec3 next = random_direction(random);
        origin.through = (pen_dot(next, n) > 0) != (pen_dot(origin.toward, n) > 0);
        d = next;
    }
}

/* Cones for a world: pointed or truncated, capped or open, either way up. */
static void add_cones(struct random *random, uint32_t count, double size)
{
    for (uint32_t i = 0; i < count; i++) {
        double top = random_below(random, 2) ? 0 : random_in(random, .1, .9);
        const double radius[2] = {size, size * top};
        struct pen_vec3 base = random_vec(random, 1);
        world_cone(&world, base, random_direction(random), radius, random_in(random, .3, 3) * size,
                   random_below(random, 2));
    }
}

START_TEST(test_accel__h095_equals_brute_force)
{
    struct random random = random_begin(2);
    static uint8_t see_through[WORLD_MAX];
    for (int scene = 0; scene < random_some(150, 50); scene++) {
        world_clear(&world);
        world_random(&world, &random, random_below(&random, 60), random_in(&random, 0.02, 1));
        if (scene & 1)
            add_cones(&random, 1 + random_below(&random, 20), random_in(&random, 0.02, 1));
        if (scene & 2)
            world_bent(&world, &random, 1 + random_below(&random, 20), random_in(&random, 0.02, 1));
        for (uint32_t i = 0; i < world.prims.count; i++)
            see_through[i] = random_below(&random, 8) != 0;
        struct variants variants = build(&world, &random);
        for (int i = 0; i < 60; i++)
            follow_path(&random, &variants, see_through);
        pen_arena_free(variants.arena);
    }
}
END_TEST

/* A path that is aimed at a seam of a closed room, and the queries on it. H073: nothing
 * opaque lets it out. Rays go on through what is see-through. */
static void follow_seam(struct random *r, const struct variants *variants, struct pen_vec3 o,
                        bool convex, const uint8_t *see_through)
{
    struct pen_origin_surface origin = pen_origin_none;
    struct pen_vec3 at = world_aim(&world, r);
    if (convex && random_below(r, 2)) /* beside it: borders are passed near where the next starts */
        at = pen_along(at, random_direction(r), exp2(random_in(r, -48, -24)));
    struct pen_vec3 d = pen_sub(at, o);
    for (int bounce = 0; bounce < 3; bounce++) {
        struct pen_ray ray = world_ray(o, d);
        struct pen_t_interval interval = {pen_after_start, INFINITY};
        struct pen_hit hit = nearest(&world, variants, &ray, &origin, &interval);
        ck_assert_msg(hit.prim != PEN_NO_PRIM, "no way out; seed %llu",
                      (unsigned long long)r->seed);
        struct stand s = world_stand(&world, &ray, &origin, hit);
        d = stand_turn(&s, r, see_through[hit.prim], &origin);
        o = s.p;
        ray = world_ray(o, pen_scale(d, 9));
        ck_assert_msg(shadow(&world, variants, &ray, &origin, see_through),
                      "no light in; seed %llu", (unsigned long long)r->seed);
    }
}

/* From a point beside a seam, rays that pass it within rounding, seen from inside or outside. */
static void graze_seam(struct random *r, const struct variants *variants, struct pen_vec3 eye)
{
    struct pen_vec3 seam = world_aim(&world, r);
    struct pen_vec3 at = pen_along(seam, random_direction(r), exp2(random_in(r, -45, -27)));
    struct pen_ray ray = world_ray(eye, pen_sub(at, eye));
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit = nearest(&world, variants, &ray, &pen_origin_none, &interval);
    if (hit.prim == PEN_NO_PRIM)
        return;
    struct stand s = world_stand(&world, &ray, &pen_origin_none, hit);
    for (int i = 0; i < 4; i++) {
        struct pen_vec3 to = pen_along(seam, random_direction(r), exp2(random_in(r, -53, -48)));
        struct pen_vec3 d = pen_scale(pen_sub(to, s.p), exp2(random_in(r, 0, 48)));
        if (!pen_ray_make(&ray, s.p, d)) /* it has no direction */
            continue;
        shadow(&world, variants, &ray, &s.origin, NULL);
        nearest(&world, variants, &ray, &s.origin, &interval);
    }
}

START_TEST(test_accel__h073_seams)
{
    struct random r = random_begin(73);
    static const double offsets[] = {0, 1e3, 1e6};
    for (int i = 0; i < random_some(180, 60); i++) {
        static uint8_t see_through[WORLD_MAX];
        enum world_room room = (enum world_room)(i % ROOM_COUNT);
        struct pen_vec3 eye = world_room(&world, &r, room, offsets[i / ROOM_COUNT % 3]);
        see_through[6] = room == ROOM_PANE;
        if (i & 1) /* something else in the leaves */
            world_cylinder(&world, eye, random_direction(&r), .1, .1, true);
        if (i & 2)
            world_cone(&world, eye, random_direction(&r), (const double[2]){.1, 0}, .1, true);
        struct variants variants = build(&world, &r);
        for (int k = 0; k < 40; k++)
            follow_seam(&r, &variants, eye, room < ROOM_CONVEX_COUNT, see_through);
        for (int k = 0; k < 100; k++)
            graze_seam(&r, &variants, k & 1 ? eye : pen_along(eye, random_direction(&r), 4));
        pen_arena_free(variants.arena);
    }
}
END_TEST

/* A coordinate that is as often as not too small to be told from 0. */
static double tiny(struct random *r)
{
    static const double size[] = {0,      5e-324, 1e-323, 1e-310, 2e-308, 1e-300, 1e-200,
                                  1e-136, 1e-135, 1e-100, 1e-45,  1e-40,  1e-38,  1e-17};
    double x = size[random_below(r, 14)] * (1 + random_unit(r));
    switch (random_below(r, 4)) {
    case 0:
        return (double)random_below(r, 9) / 2 - 2;
    case 1:
        return random_in(r, -2, 2);
    default:
        return random_below(r, 2) ? -x : x;
    }
}

static struct pen_vec3 tiny3(struct random *r)
{
    double x = tiny(r), y = tiny(r);
    return pen_vec3(x, y, tiny(r));
}

/* H085, H093: from a hair beside flat primitives on a lattice, along and through them. */
START_TEST(test_accel__h085_hairs_beside_surfaces)
{
    struct random r = random_begin(85);
    for (int scene = 0; scene < random_some(60, 20); scene++) {
        world_clear(&world);
        for (int i = 0; i < 12; i++) {
            struct pen_vec3 a = random_vec(&r, 2.5);
            a = pen_vec3(round(a.x), round(a.y), round(a.z));
            world_box(&world, a, pen_add(a, pen_vec3(1, 1, .5)));
            world_triangle(&world, a, pen_add(a, pen_vec3(1, 0, 1)), pen_add(a, pen_vec3(0, 1, 1)));
        }
        struct variants variants = build(&world, &r);
        for (int i = 0; i < 300; i++) {
            struct pen_vec3 o = tiny3(&r), d = tiny3(&r);
            struct pen_ray ray;
            struct pen_t_interval interval = {pen_after_start, INFINITY};
            if (pen_ray_make(&ray, o, d))
                nearest(&world, &variants, &ray, &pen_origin_none, &interval);
        }
        pen_arena_free(variants.arena);
    }
}
END_TEST

PEN_SUITE("same", test_accel__h085_hairs_beside_surfaces, test_accel__h095_equals_brute_force,
          test_accel__h073_seams)
