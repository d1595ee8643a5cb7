/* SPDX-License-Identifier: MIT */
/* A mesh is met exactly where its triangles are met that are stored one by one: in every
 * accelerator, with every instruction set, by rays that look for its margins. */
#include <stdio.h>

#include "accel/internal/test_doors.h"
#include "support/isa.h"
#include "support/suite.h"
#include "support/twin.h"

static struct world stored;
static struct twin twin;

/* Every accelerator, and the tree whether or not `auto` chooses it. */
enum { TREE = PEN_ACCEL_COUNT, ACCELS };

struct variants {
    struct pen_arena *arena;
    const struct pen_accel *accel[ACCELS];
};

static struct variants build(const struct pen_prims *prims)
{
    struct pen_status st;
    struct variants v = {.arena = pen_arena_new(0)};
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        v.accel[kind] = pen_accel_build(prims, (enum pen_accelerator)kind, v.arena, &st);
    v.accel[TREE] = pen_accel_build_choice(prims, PEN_AUTO_TREE, v.arena, &st);
    for (int i = 0; i < ACCELS; i++)
        ck_assert(v.accel[i]);
    return v;
}

/* What a ray is, for messages. */
static const char *words_of(const struct pen_ray *ray)
{
    static char words[200];
    snprintf(words, sizeof words, "o %a %a %a d %a %a %a", ray->o.x, ray->o.y, ray->o.z, ray->d.x,
             ray->d.y, ray->d.z);
    return words;
}

static struct pen_hit nearest(const struct variants *v, const struct pen_ray *ray,
                              const struct pen_origin_surface *origin,
                              const struct pen_t_interval *interval)
{
    const struct pen_hit truth = world_nearest(&stored, ray, origin, interval);
    for (int i = 0; i < ACCELS * isa_count(); i++) {
        struct pen_hit hit = {0, PEN_NO_PRIM, 0};
        const bool found = pen_trace_ops_get((enum pen_isa)(i / ACCELS))
                               ->nearest(v->accel[i % ACCELS], ray, origin, interval, &hit);
        ck_assert_msg(found == (truth.prim != PEN_NO_PRIM) &&
                          (!found || (hit.t == truth.t && hit.prim == truth.prim)),
                      "variant %d: %s from %d: %a %u, not %a %u", i, words_of(ray),
                      (int)origin->prim, hit.t, hit.prim, truth.t, truth.prim);
    }
    return truth;
}

static void shadow(const struct variants *v, const struct pen_ray *ray,
                   const struct pen_origin_surface *origin, double tmax, const uint8_t *see_through)
{
    const bool to_point = tmax == 1;
    const double bound = pen_ray_end_bound(ray->o, ray->d);
    struct pen_t_interval from = {pen_after_start, INFINITY};
    bool blocked = false;
    int count = 0;
    while (!blocked && count < PEN_SHADOW_MAX) {
        const struct pen_hit hit = from.after = world_nearest(&stored, ray, origin, &from);
        if (hit.prim == PEN_NO_PRIM || hit.t >= tmax)
            break;
        if (to_point && pen_prim_ends_ray(&stored.prims, hit, ray, tmax, bound))
            continue;
        blocked = !pen_see_through(&twin.prims, see_through, hit.prim);
        count++;
    }
    for (int i = 0; i < ACCELS * isa_count(); i++) {
        struct pen_shadow query = {.tmax = tmax,
                                   .to_point = to_point,
                                   .see_through = see_through,
                                   .last_occluder = PEN_NO_PRIM};
        const bool met = pen_trace_ops_get((enum pen_isa)(i / ACCELS))
                             ->shadow(v->accel[i % ACCELS], ray, origin, &query);
        if (count == PEN_SHADOW_MAX)
            continue;
        ck_assert_msg(met == blocked, "variant %d: %s from %d to %a: blocked %d", i, words_of(ray),
                      (int)origin->prim, tmax, met);
    }
}

/* Some scene of meshes and other primitives. Its largest coordinates are about `reach`. */
static void random_scene(struct random *r, double *reach)
{
    twin_clear(&twin, &stored);
    *reach = 2;
    if (random_below(r, 2)) {
        world_random(&stored, r, random_below(r, 20), random_in(r, 0.02, 1));
        twin_take(&twin);
    }
    const uint32_t meshes = 1 + random_below(r, 3);
    for (uint32_t i = 0; i < meshes; i++) {
        const double unit = exp2((double)random_below(r, 3) * (random_below(r, 2) ? -1 : 1) *
                                 (random_below(r, 4) ? 1 : 12));
        const struct pen_vec3 shift = random_below(r, 3) == 0
                                          ? pen_vec3(0, 0, 0)
                                          : random_vec(r, unit * exp2(random_in(r, -3, 3)));
        *reach = *reach > 16 * unit ? *reach : 16 * unit;
        twin_mesh_begin(&twin, shift, unit);
        switch (random_below(r, 4)) {
        case 0:
            twin_hills(&twin, r, 2 + random_below(r, 8));
            break;
        case 1:
            twin_soup(&twin, r, 1 + random_below(r, 60), exp2(random_in(r, -20, 0)));
            break;
        default:
            twin_ball(&twin, r, 2 + random_below(r, 8), 3 + random_below(r, 8));
            break;
        }
        twin_mesh_end(&twin);
        if (random_below(r, 3) == 0)
            world_random(&stored, r, random_below(r, 4), random_in(r, 0.02, 1));
        twin_take(&twin);
    }
}

/* A point of a random triangle: a vertex, a point of an edge, or one of its inside. */
static struct pen_vec3 aim(struct random *r)
{
    const uint32_t count = stored.prims.kind_count[PEN_PRIM_TRIANGLE];
    const struct pen_triangle *tri = &stored.triangle[random_below(r, count)];
    struct pen_vec3 p = tri->v[random_below(r, 3)];
    const uint32_t how = random_below(r, 3);
    for (uint32_t i = 0; i < how; i++) {
        const struct pen_vec3 q = tri->v[random_below(r, 3)];
        p = pen_along(p, pen_sub(q, p), random_below(r, 2) ? 0.5 : random_in(r, 0, 1));
    }
    return p;
}

/* A path whose rays are aimed at borders, within some rounding, from near and from far away. */
static void follow(struct random *r, const struct variants *v, double reach,
                   const uint8_t *see_through)
{
    struct pen_origin_surface origin = pen_origin_none;
    const double far = random_below(r, 2) ? 4 : exp2(random_in(r, -6, 45));
    struct pen_vec3 o = random_vec(r, reach * far);
    for (int bounce = 0; bounce < 4; bounce++) {
        struct pen_vec3 at = aim(r), d;
        if (random_below(r, 2))
            at = pen_along(at, random_direction(r), reach * exp2(random_in(r, -60, -3)));
        d = random_below(r, 5) ? pen_sub(at, o) : random_direction(r);
        d = pen_scale(d, exp2(random_in(r, -2, 2)));
        struct pen_ray ray;
        if (!pen_ray_make(&ray, o, d))
            return;
        struct pen_t_interval interval = {pen_after_start, random_below(r, 3) ? INFINITY : 1};
        const struct pen_hit hit = nearest(v, &ray, &origin, &interval);
        shadow(v, &ray, &origin, random_below(r, 2) ? 1 : INFINITY,
               random_below(r, 2) ? see_through : NULL);
        if (hit.prim == PEN_NO_PRIM)
            return;
        interval.after = hit;
        nearest(v, &ray, &origin, &interval);
        interval = (struct pen_t_interval){pen_after_start, hit.t};
        nearest(v, &ray, &origin, &interval);
        interval.tmax = nextafter(hit.t, 0);
        nearest(v, &ray, &origin, &interval);
        o = pen_prim_point(&stored.prims, hit, &ray);
        origin = world_origin_surface(&stored, hit, o, pen_scale(d, hit.t), false);
        if (random_below(r, 4) == 0)
            origin = pen_origin_none;
    }
}

START_TEST(test_mesh__equals_its_triangles)
{
    struct random r = random_begin(531);
    static uint8_t see_through[WORLD_MAX];
    for (int scene = 0; scene < random_some(400, 20); scene++) {
        double reach;
        random_scene(&r, &reach);
        if (stored.prims.kind_count[PEN_PRIM_TRIANGLE] == 0)
            continue;
        for (uint32_t i = 0; i < pen_prim_slots(&twin.prims); i++)
            see_through[i] = random_below(&r, 3) == 0;
        const struct variants v = build(&twin.prims);
        for (int i = 0; i < 100; i++)
            follow(&r, &v, reach, see_through);
        pen_arena_free(v.arena);
    }
}
END_TEST

static struct pen_test_counts count_tests(const struct pen_accel *accel, enum pen_isa isa,
                                          const struct pen_ray *ray)
{
    const struct pen_trace_ops *ops = pen_trace_count_ops_get(isa);
    const struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_shadow query = {.tmax = 1, .last_occluder = PEN_NO_PRIM};
    struct pen_test_counts counts = {0};
    struct pen_accel *view = pen_accel_count_new(accel, &counts);
    struct pen_hit hit;
    ops->nearest(view, ray, &pen_origin_none, &interval, &hit);
    ops->shadow(view, ray, &pen_origin_none, &query);
    pen_accel_count_free(view);
    return counts;
}

START_TEST(test_mesh__counts_are_those_of_every_instruction_set)
{
    struct random r = random_begin(533);
    uint64_t tests = 0;
    for (int scene = 0; scene < random_some(400, 20); scene++) {
        double reach;
        random_scene(&r, &reach);
        if (stored.prims.kind_count[PEN_PRIM_TRIANGLE] == 0)
            continue;
        const struct variants v = build(&twin.prims);
        for (int i = 0; i < 40 * ACCELS; i++) {
            const struct pen_accel *accel = v.accel[i % ACCELS];
            const struct pen_vec3 o = random_vec(&r, reach * exp2(random_in(&r, -6, 20)));
            struct pen_ray ray;
            if (!pen_ray_make(&ray, o, pen_sub(aim(&r), o)))
                continue;
            const struct pen_test_counts a = count_tests(accel, PEN_ISA_BASE, &ray);
            for (int isa = 1; isa < isa_count(); isa++) {
                const struct pen_test_counts b = count_tests(accel, (enum pen_isa)isa, &ray);
                ck_assert_msg(a.boxes == b.boxes && a.primitives == b.primitives,
                              "accelerator %d, set %d: %s: %llu %llu, not %llu %llu", i % ACCELS,
                              isa, words_of(&ray), (unsigned long long)b.boxes,
                              (unsigned long long)b.primitives, (unsigned long long)a.boxes,
                              (unsigned long long)a.primitives);
            }
            tests += a.primitives;
        }
        pen_arena_free(v.arena);
    }
    ck_assert_uint_gt(tests, 0);
}
END_TEST

/* Each primitive has the same slot data, bounds, normal and outline as its stored twin. */
START_TEST(test_mesh__primitives_are_the_same)
{
    struct random r = random_begin(532);
    for (int scene = 0; scene < random_some(100, 20); scene++) {
        double reach;
        random_scene(&r, &reach);
        for (uint32_t i = 0; i < twin.prims.count; i++) {
            struct pen_triangle rooms[2];
            const struct pen_outline a = pen_prim_outline(&stored.prims, i, &rooms[0]),
                                     b = pen_prim_outline(&twin.prims, i, &rooms[1]);
            const struct pen_hit hit = {1, i, PEN_PART_SIDE};
            const struct pen_vec3 p = pen_vec3(.1, .2, .3),
                                  m = pen_prim_normal(&stored.prims, hit, p),
                                  n = pen_prim_normal(&twin.prims, hit, p);
            ck_assert_uint_eq(pen_prim_kind(&stored.prims, i), pen_prim_kind(&twin.prims, i));
            ck_assert(memcmp(&m, &n, sizeof m) == 0);
            ck_assert_uint_eq(a.count, b.count);
            ck_assert(a.count == 0 || memcmp(a.v, b.v, a.count * sizeof *a.v) == 0);
            ck_assert(a.extent == b.extent);
            if (pen_prim_infinite(pen_prim_kind(&twin.prims, i)))
                continue;
            const struct pen_box s = pen_prim_bounds(&stored.prims, i),
                                 t = pen_prim_bounds(&twin.prims, i);
            ck_assert(memcmp(&s, &t, sizeof s) == 0);
        }
    }
}
END_TEST

PEN_SUITE("mesh", test_mesh__primitives_are_the_same, test_mesh__equals_its_triangles,
          test_mesh__counts_are_those_of_every_instruction_set)
