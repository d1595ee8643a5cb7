/* SPDX-License-Identifier: MIT */
/* Accelerators on inputs that are hard for them, compared with trying every primitive. */
#include <stdlib.h>

#include "support/isa.h"
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

static struct world world;

/* Every kind, and manual with groups. */
enum { TREES = PEN_ACCEL_COUNT + 1 };

struct tree {
    struct pen_arena *arena;
    const struct pen_accel *accel[TREES];
};

/* Halves of halves as groups, down to single primitives. */
static void halve(uint32_t begin, uint32_t end, struct pen_groups *groups,
                  struct pen_group_range *interval, uint32_t room)
{
    if (end - begin < 2 || groups->count == room)
        return;
    interval[groups->count++] = (struct pen_group_range){begin, end};
    halve(begin, begin + (end - begin) / 2, groups, interval, room);
    halve(begin + (end - begin) / 2, end, groups, interval, room);
}

static struct tree plant(const struct pen_prims *prims)
{
    enum { GROUPS = 5000 };
    static struct pen_group_range interval[GROUPS];
    struct pen_groups groups = {interval, 0};
    struct pen_status st;
    struct tree tree = {.arena = pen_arena_new(0)};
    halve(0, prims->count, &groups, interval, GROUPS);
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        tree.accel[kind] = pen_accel_build(prims, (enum pen_accelerator)kind, tree.arena, &st);
    tree.accel[PEN_ACCEL_COUNT] = pen_accel_build_manual(prims, &groups, tree.arena, &st);
    for (int i = 0; i < TREES; i++) {
        ck_assert(tree.accel[i]);
        ck_assert_uint_le(pen_accel_get_stats(tree.accel[i])->depth, 64);
    }
    return tree;
}

/* Compares all kinds and variants with brute force; returns the hit's primitive. */
static uint32_t same(const struct tree *tree, const struct world *w, vec3 o, vec3 d, double tmax)
{
    struct pen_ray ray = world_ray(o, d);
    struct pen_t_interval interval = {pen_after_start, tmax};
    struct pen_hit truth = world_nearest(w, &ray, &pen_origin_none, &interval);
    for (int i = 0; i < TREES * isa_count(); i++) {
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)(i / TREES));
        struct pen_hit hit = {0, PEN_NO_PRIM, 0};
        ops->nearest(tree->accel[i % TREES], &ray, &pen_origin_none, &interval, &hit);
        ck_assert_msg(hit.prim == truth.prim && (hit.prim == PEN_NO_PRIM || hit.t == truth.t),
                      "%d, %s: o %a %a %a d %a %a %a: %u, not %u", i % TREES, ops->name, o.x, o.y,
                      o.z, d.x, d.y, d.z, hit.prim, truth.prim);
    }
    return truth.prim;
}

/* H099: none, one, two; infinite only. */
START_TEST(test_tree__h099_hardly_anything)
{
    for (int n = 0; n < 8; n++) {
        world_clear(&world);
        if (n & 1)
            world_sphere(&world, pen_vec3(0, 0, 0), 1);
        if (n & 2)
            world_triangle(&world, pen_vec3(-1, -1, 2), pen_vec3(1, -1, 2), pen_vec3(0, 1, 2));
        if (n & 4)
            world_plane(&world, pen_vec3(0, 0, 3), pen_vec3(0, 0, 1));
        struct tree tree = plant(&world.prims);
        uint32_t first = same(&tree, &world, pen_vec3(0, 0, -5), pen_vec3(0, 0, 1), INFINITY);
        ck_assert((first == PEN_NO_PRIM) == (n == 0));
        same(&tree, &world, pen_vec3(0, 0, -5), pen_vec3(0, 1, 0), INFINITY);
        same(&tree, &world, pen_vec3(0, 0, 9), pen_vec3(0, 0, -1), INFINITY);
        pen_arena_free(tree.arena);
    }
}
END_TEST

/* Many primitives, more than a world holds. */
static struct pen_triangle *many;
static struct pen_prim_ref *refs;

static struct pen_prims crowd(uint32_t count)
{
    many = calloc(count, sizeof *many);
    refs = calloc(count, sizeof *refs);
    ck_assert(many && refs);
    for (uint32_t i = 0; i < count; i++) {
        refs[i].kind = PEN_PRIM_TRIANGLE;
        refs[i].index = i & 0x0fffffffu;
    }
    struct pen_prims prims = {.count = count, .ref = refs, .triangle = many};
    prims.kind_count[PEN_PRIM_TRIANGLE] = count;
    return prims;
}

/* H097: copies of one triangle: the tree ends, and the first copy is met. */
START_TEST(test_tree__h097_identical_centroids)
{
    const int N = random_some(100000, 33333);
    struct pen_prims prims = crowd((uint32_t)N);
    for (int i = 0; i < N; i++)
        ck_assert(
            pen_triangle_make(&many[i], pen_vec3(.1, 0, 0), pen_vec3(1, 0, 0), pen_vec3(0, 1, .3)));
    struct tree tree = plant(&prims);
    for (int i = 0; i < TREES * isa_count(); i++) {
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)(i / TREES));
        const struct pen_accel *accel = tree.accel[i % TREES];
        struct pen_ray ray = world_ray(pen_vec3(.4, .3, 2), pen_vec3(0, 0, -1));
        struct pen_t_interval interval = {pen_after_start, INFINITY};
        struct pen_hit hit;
        ck_assert(ops->nearest(accel, &ray, &pen_origin_none, &interval, &hit));
        ck_assert_uint_eq(hit.prim, 0);
        for (uint32_t k = 1; k < 20; k++) { /* and then each of the others, in order */
            interval.after = hit;
            ck_assert(ops->nearest(accel, &ray, &pen_origin_none, &interval, &hit));
            ck_assert_uint_eq(hit.prim, k);
        }
    }
    pen_arena_free(tree.arena);
    free(many);
    free(refs);
}
END_TEST

/* Sizes and places over sixty powers of two: depth stays bounded. */
START_TEST(test_tree__geometric_scales)
{
    const int N = random_some(20000, 6666);
    struct random r = random_begin(97);
    struct pen_prims prims = crowd((uint32_t)N);
    for (int i = 0; i < N; i++) {
        double s = ldexp(1, -(int)random_below(&r, 60));
        vec3 c = pen_scale(random_direction(&r), s);
        ck_assert(pen_triangle_make(&many[i], c, pen_along(c, random_direction(&r), .1 * s),
                                    pen_along(c, random_direction(&r), .1 * s)));
    }
    struct tree tree = plant(&prims);
    struct pen_origin_surface origin = pen_origin_none;
    for (int i = 0; i < random_some(200, 66); i++) {
        struct pen_ray ray = world_ray(random_vec(&r, 1), random_direction(&r));
        struct pen_t_interval interval = {pen_after_start, INFINITY};
        struct pen_hit truth = {INFINITY, PEN_NO_PRIM, 0}, hit = truth;
        for (uint32_t k = 0; k < (uint32_t)N; k++) {
            double t;
            if (pen_triangle_root(&many[k], &ray, &t) && t > 0 && t < truth.t)
                truth = (struct pen_hit){t, k, 0};
        }
        for (int k = 0; k < TREES; k++) {
            hit = (struct pen_hit){INFINITY, PEN_NO_PRIM, 0};
            pen_trace_ops_get(pen_cpu_isa())
                ->nearest(tree.accel[k], &ray, &origin, &interval, &hit);
            ck_assert(hit.prim == truth.prim);
        }
    }
    pen_arena_free(tree.arena);
    free(many);
    free(refs);
}
END_TEST

/* H098: planes and infinite cylinders beside a tree. */
START_TEST(test_tree__h098_unbounded_mix)
{
    struct random r = random_begin(98);
    world_clear(&world);
    for (int i = 0; i < 3; i++) {
        world_plane(&world, random_vec(&r, 1), random_direction(&r));
        world_infinite_cylinder(&world, random_vec(&r, 1), random_direction(&r), .1);
    }
    for (int i = 0; i < 1500; i++) {
        vec3 c = random_vec(&r, 1);
        world_triangle(&world, c, pen_add(c, random_vec(&r, .1)), pen_add(c, random_vec(&r, .1)));
    }
    struct tree tree = plant(&world.prims);
    for (int i = 0; i < random_some(2000, 666); i++)
        same(&tree, &world, random_vec(&r, 2), random_direction(&r), INFINITY);
    pen_arena_free(tree.arena);
}
END_TEST

/* Boxes of six squares whose faces are their own bounds, on a grid or anywhere. */
static void boxes(struct random *r, vec3 at, bool dyadic)
{
    world_clear(&world);
    for (int i = 0; i < 12; i++) {
        vec3 c = random_vec(r, 4), s = pen_vec3(random_in(r, .1, 2), random_in(r, .1, 2), 1);
        if (dyadic) {
            c = pen_vec3(round(c.x), round(c.y), round(c.z));
            s = pen_vec3(1, 2, .5);
        }
        c = pen_add(c, at);
        world_box(&world, c, pen_add(c, s));
    }
}

/* A corner, or a point of an edge or of a face, of some box; moved by a few ulps at times. */
static vec3 adversarial_point(struct random *r)
{
    static const int step[] = {0, 0, 0, 1, -1, 2, -64};
    const struct pen_polygon *p = &world.polygon[random_below(r, world.prims.count)];
    double x = random_below(r, 2) ? random_below(r, 2) : random_unit(r);
    double y = random_below(r, 2) ? random_below(r, 2) : random_unit(r);
    vec3 q =
        pen_along(pen_along(p->v[0], pen_sub(p->v[1], p->v[0]), x), pen_sub(p->v[3], p->v[0]), y);
    return pen_vec3(random_nudge(q.x, step[random_below(r, 7)]),
                    random_nudge(q.y, step[random_below(r, 7)]),
                    random_nudge(q.z, step[random_below(r, 7)]));
}

/* H091, H092, H093, H086: rays at and from corners, edges and faces of flat boxes, parallel to axes
 * with both zeros, far from the origin: they miss nothing that brute force finds. */
START_TEST(test_tree__h091_h092_h093_no_false_box_misses)
{
    static const double far[] = {0, 1e3, 1e6, 1e9};
    struct random r = random_begin(91);
    int hits = 0;
    for (int scene = 0; scene < random_some(60, 20); scene++) {
        double k = far[_i];
        boxes(&r, pen_vec3(k, -.37 * k, .7 * k), scene & 1);
        struct tree tree = plant(&world.prims);
        for (int i = 0; i < 300; i++) {
            vec3 p = adversarial_point(&r), q = adversarial_point(&r);
            vec3 d = i % 3 ? pen_sub(q, p) : random_direction(&r);
            if (i % 3 == 2)
                p = pen_sub(p, pen_scale(d, random_in(&r, 0, 3)));
            if (random_below(&r, 3) == 0) { /* along axes and diagonals */
                const double sign[] = {0.0, -0.0, 1, -1, 0.0, -0.0};
                d = pen_vec3(sign[random_below(&r, 6)], sign[random_below(&r, 6)],
                             sign[random_below(&r, 6)]);
            }
            if (random_below(&r, 20) == 0)
                d.y = random_below(&r, 2) ? 5e-324 : -1e-310;
            struct pen_ray ray;
            if (pen_ray_make(&ray, p, d))
                hits += same(&tree, &world, p, d, INFINITY) != PEN_NO_PRIM;
        }
        pen_arena_free(tree.arena);
    }
    ck_assert_int_gt(hits, random_some(2000, 666));
}
END_TEST

/* H094: t of an intersection on a face of a box is within tmax, one ulp less is not. */
START_TEST(test_tree__h094_tmax_equality)
{
    struct random r = random_begin(94);
    boxes(&r, pen_vec3(0, 0, 0), true);
    struct tree tree = plant(&world.prims);
    for (int i = 0; i < random_some(2000, 666); i++) {
        vec3 o = random_vec(&r, 9), d = pen_sub(adversarial_point(&r), o);
        struct pen_ray ray = world_ray(o, d);
        struct pen_t_interval interval = {pen_after_start, INFINITY};
        struct pen_hit hit = world_nearest(&world, &ray, &pen_origin_none, &interval);
        if (hit.prim == PEN_NO_PRIM)
            continue;
        ck_assert_uint_eq(same(&tree, &world, o, d, hit.t), hit.prim);
        ck_assert_uint_eq(same(&tree, &world, o, d, nextafter(hit.t, 0)), PEN_NO_PRIM);
    }
    pen_arena_free(tree.arena);
}
END_TEST

START_TEST(test_tree__failures_are_reported)
{
    struct pen_status st;
    world_clear(&world);
    for (int i = 0; i < 100; i++)
        world_sphere(&world, pen_vec3(i, 0, 0), 1);
    struct pen_arena *small = pen_arena_new(4096), *large = pen_arena_new(0);
    ck_assert(!pen_accel_build(&world.prims, PEN_ACCEL_AUTO, small, &st));
    ck_assert_int_eq(st.code, PEN_NO_MEMORY);
    const struct pen_accel *accel = pen_accel_build(&world.prims, PEN_ACCEL_AUTO, large, &st);
    const struct pen_accel_stats *stats = pen_accel_get_stats(accel);
    ck_assert(stats->kind == PEN_ACCEL_AUTO && stats->nodes > 1 && stats->leaves >= 25);
    ck_assert(stats->bytes > 0 && stats->bytes <= pen_arena_used(large));
    ck_assert(stats->sah_cost > 1 && stats->sah_cost < 25 && stats->depth >= 1);
    pen_arena_free(small);
    pen_arena_free(large);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("tree");
    TCase *tcase = tcase_create("tree");
    tcase_set_timeout(tcase, 300);
    tcase_add_test(tcase, test_tree__h099_hardly_anything);
    tcase_add_test(tcase, test_tree__h097_identical_centroids);
    tcase_add_test(tcase, test_tree__geometric_scales);
    tcase_add_test(tcase, test_tree__h098_unbounded_mix);
    tcase_add_loop_test(tcase, test_tree__h091_h092_h093_no_false_box_misses, 0, 4);
    tcase_add_test(tcase, test_tree__h094_tmax_equality);
    tcase_add_test(tcase, test_tree__failures_are_reported);
    suite_add_tcase(suite, tcase);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}
