/* SPDX-License-Identifier: MIT */
/* Freezing: primitives under transforms, the local frame, materials, lights, groups, and errors. */
#include <dlfcn.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/freeze_without_rays.h"
#include "support/alloc.h"
#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* A point of the frozen scene in scene units. */
static vec3 global(const struct pen_scene *scene, vec3 p)
{
    return pen_add(pen_scale(p, ldexp(1, scene->exponent)), scene->center);
}

static double global_length(const struct pen_scene *scene, double length)
{
    return ldexp(length, scene->exponent);
}

static void assert_close(vec3 got, double x, double y, double z)
{
    const double tolerance = 1e-14 * (1 + fabs(x) + fabs(y) + fabs(z));
    ck_assert_msg(pen_norm1(pen_sub(got, pen_vec3(x, y, z))) <= tolerance,
                  "(%.17g %.17g %.17g), want (%g %g %g)", got.x, got.y, got.z, x, y, z);
}

static struct pen_transform turn(double scale, double degrees, vec3 translate)
{
    return pen_transform_make(scale, pen_vec3(0, 0, 1), degrees, translate);
}

START_TEST(test_freeze__primitives_are_numbered_depth_first)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 1, 0), -1);
    kit_sphere(&kit, pen_vec3(1, 0, 0), 1, -1);
    kit_group(&kit, 2, NULL); /* the group of one sphere and, below, of a triangle */
    kit_triangle(&kit, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), pen_vec3(0, 1, 0), -1);
    kit_group(&kit, 2, NULL);
    kit_tube(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 1, -1);
    struct pen_scene *scene = kit_freeze(&kit);
    static const uint32_t kinds[] = {PEN_PRIM_SPHERE, PEN_PRIM_PLANE, PEN_PRIM_SPHERE,
                                     PEN_PRIM_TRIANGLE, PEN_PRIM_INFINITE_CYLINDER};
    static const uint32_t indices[] = {0, 0, 1, 0, 0};
    ck_assert_uint_eq(scene->prims.count, 5);
    for (int i = 0; i < 5; i++) {
        ck_assert_uint_eq(scene->prims.ref[i].kind, kinds[i]);
        ck_assert_uint_eq(scene->prims.ref[i].index, indices[i]);
    }
    ck_assert_uint_eq(scene->prims.kind_count[PEN_PRIM_SPHERE], 2);
    assert_close(global(scene, scene->prims.sphere[1].c), 1, 0, 0);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_freeze__quadrics_under_similarities)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(1, 0, 0), 0.5, -1);
    kit_cylinder(&kit, pen_vec3(1, 0, 0), pen_vec3(5, 0, 0), 0.5, 2, -1);
    kit_tube(&kit, pen_vec3(0, 1, 0), pen_vec3(0, 3, 0), 0.25, -1);
    struct pen_transform inner = turn(2, 90, pen_vec3(10, 0, 0));
    kit_group(&kit, 0, &inner);
    struct pen_transform outer = turn(1, 0, pen_vec3(0, 0, 7));
    kit_group(&kit, 0, &outer);
    struct pen_scene *scene = kit_freeze(&kit);
    const struct pen_prims *prims = &scene->prims;
    assert_close(global(scene, prims->sphere[0].c), 10, 2, 7);
    ck_assert_double_eq_tol(global_length(scene, prims->sphere[0].r), 1, 1e-15);
    assert_close(global(scene, prims->cylinder[0].round.q), 10, 2, 7);
    vec3 axis = pen_normalize(prims->cylinder[0].round.a);
    assert_close(axis, 0, 1, 0);
    ck_assert_double_eq_tol(global_length(scene, prims->cylinder[0].round.r), 1, 1e-15);
    ck_assert_double_eq_tol(global_length(scene, prims->cylinder[0].h), 4, 1e-15);
    assert_close(pen_normalize(prims->infinite_cylinder[0].round.a), -1, 0, 0);
    ck_assert_double_eq_tol(global_length(scene, prims->infinite_cylinder[0].round.r), 0.5, 1e-15);
    pen_scene_free(scene);
}
END_TEST

/* Outward normals where rays along `d` from far off first meet the primitives. */
static vec3 outward(const struct pen_scene *scene, vec3 from, vec3 d)
{
    struct pen_ray ray;
    struct pen_hit hit;
    struct pen_t_interval span = {pen_after_start, INFINITY};
    vec3 o = pen_scale(pen_sub(from, scene->center), ldexp(1, -scene->exponent));
    ck_assert(pen_ray_make(&ray, o, d));
    ck_assert(pen_trace_ops_get(PEN_ISA_BASE)
                  ->nearest(scene->accel, &ray, &pen_origin_none, &span, &hit));
    return pen_prim_normal(&scene->prims, hit, pen_prim_point(&scene->prims, hit, &ray));
}

START_TEST(test_freeze__mirrors_keep_the_outside)
{
    struct pen_transform mirror = {{{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    struct pen_transform stretched = {{{-2, 0.5, 0, 1}, {0, 1, 0, 0}, {0, 0.25, 3, 0}}};
    for (int flat = 0; flat < 3; flat++)
        for (int stretch = 0; stretch < 2; stretch++) {
            kit_init(&kit);
            const vec3 quad[] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
            if (flat == 0)
                kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), -1);
            else
                kit_polygon(&kit, quad, flat == 1 ? 3 : 4, -1);
            struct pen_transform *f = stretch ? &stretched : &mirror;
            kit_group(&kit, 0, f);
            struct pen_scene *scene = kit_freeze(&kit);
            vec3 inside = pen_transform_point(f, pen_vec3(0.25, -0.25, 0));
            vec3 above = pen_transform_point(f, pen_vec3(0.25, -0.25, 1));
            vec3 n = outward(scene, above, pen_sub(inside, above));
            ck_assert_double_gt(pen_dot(n, pen_sub(above, inside)), 0);
            vec3 x = pen_transform_vector(f, pen_vec3(1, 0, 0));
            vec3 y = pen_transform_vector(f, pen_vec3(0, 1, 0));
            ck_assert_double_eq_tol(pen_dot(n, x), 0, 1e-15);
            ck_assert_double_eq_tol(pen_dot(n, y), 0, 1e-15);
            pen_scene_free(scene);
        }
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(3, 0, 0), 1, -1);
    kit_group(&kit, 0, &mirror);
    struct pen_scene *scene = kit_freeze(&kit);
    assert_close(outward(scene, pen_vec3(-9, 0, 0), pen_vec3(1, 0, 0)), -1, 0, 0);
    assert_close(global(scene, scene->prims.sphere[0].c), -3, 0, 0);
    pen_scene_free(scene);
}
END_TEST

static void assert_freeze_fails(enum pen_code code, const char *at, const char *message)
{
    struct pen_status st = {0};
    ck_assert(pen_scene_freeze(&kit.desc, PEN_ACCEL_NONE, 0, &st) == NULL);
    ck_assert_int_eq(st.code, code);
    ck_assert_str_eq(st.at, at);
    ck_assert_msg(strstr(st.msg, message) != NULL, "%s", st.msg);
}

START_TEST(test_freeze__refuses_stretched_quadrics)
{
    kit_init(&kit);
    kit_sheet(&kit, 0, 1, -1);
    kit_sheet(&kit, 1, 1, -1);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    struct pen_transform f = {{{1, 0, 0, 0}, {0, 1.5, 0, 0}, {0, 0, 1, 0}}};
    kit_group(&kit, 1, &f);
    assert_freeze_fails(PEN_INVALID, "/objects/1/objects/1", "similarity");
}
END_TEST

/* Only the composition of all transforms counts. */
START_TEST(test_freeze__a_stretch_that_is_undone_is_accepted)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(1, 1, 0), 1, -1);
    struct pen_transform wide = {{{2, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    struct pen_transform narrow = {{{0.5, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    kit_group(&kit, 0, &wide);
    kit_group(&kit, 0, &narrow);
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert(global_length(scene, scene->prims.sphere[0].r) == 1);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_freeze__refuses_what_doubles_cannot_hold)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(1e308, 0, 0), 1, -1);
    kit_sphere(&kit, pen_vec3(-1e308, 0, 0), 1, -1);
    assert_freeze_fails(PEN_INVALID, "", "larger");
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1e-300, -1);
    kit_sphere(&kit, pen_vec3(1, 0, 0), 1, -1);
    assert_freeze_fails(PEN_INVALID, "/objects/0", "too small");
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1e-150, -1);
    kit.view.camera.position = pen_vec3(0, 0, 1e-149);
    kit_point(&kit, pen_vec3(1e200, 0, 0), pen_vec3(1, 1, 1));
    assert_freeze_fails(PEN_INVALID, "/lights/0/position", "too far");
    kit.desc.light_count = 0;
    kit.view.camera.position = pen_vec3(0, 1e200, 0);
    assert_freeze_fails(PEN_INVALID, "", "\"main\"");
    kit.view.camera = (struct pen_camera_desc){.direction = {0, 1, 0}, .up = {0, 1, 0}};
    assert_freeze_fails(PEN_INVALID, "/up", "parallel");
}
END_TEST

/* A needle keeps its normal; one whose width is lost where a group moves it stays a primitive, with
 * a normal across it. What is moved to a single point is refused. */
START_TEST(test_freeze__needles)
{
    const vec3 quad[] = {{0, 0, 0}, {.5, -1e-40, 0}, {1, 0, 0}, {.5, 1e-40, 0}};
    const struct pen_transform move = turn(1, 0, pen_vec3(3, 3, 0));
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(7, 3, 1), .1, -1);
    kit_triangle(&kit, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), pen_vec3(.5, 1e-40, 0), -1);
    kit_polygon(&kit, quad, 4, -1);
    kit_triangle(&kit, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), pen_vec3(.5, 1e-40, 0), -1);
    kit_polygon(&kit, quad, 4, -1);
    kit_group(&kit, 3, &move);
    struct pen_scene *scene = kit_freeze(&kit);
    const struct pen_prims *prims = &scene->prims;
    ck_assert(prims->triangle[0].facet.n.z == 1 && prims->polygon[0].facet.n.z == 1);
    ck_assert(prims->triangle[1].facet.n.x == 0 &&
              fabs(pen_length(prims->triangle[1].facet.n) - 1) < 1e-15);
    ck_assert(prims->polygon[1].facet.n.x == 0 &&
              fabs(pen_length(prims->polygon[1].facet.n) - 1) < 1e-15);
    pen_scene_free(scene);
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(7, 3, 1), .1, -1);
    kit_triangle(&kit, pen_vec3(0, 0, 0), pen_vec3(1e-40, 0, 0), pen_vec3(0, 1e-40, 0), -1);
    kit_group(&kit, 1, &move);
    assert_freeze_fails(PEN_INVALID, "/objects/1/objects/0", "too small");
}
END_TEST

START_TEST(test_freeze__deep_groups)
{
    enum { DEPTH = 200000 };
    kit_init(&kit);
    struct pen_object_desc *chain = calloc(DEPTH, sizeof *chain);
    for (int i = 0; i < DEPTH - 1; i++) {
        chain[i].kind = PEN_OBJECT_GROUP;
        chain[i].u.group.count = 1;
        chain[i].u.group.objects = &chain[i + 1];
        chain[i].u.group.has_transform = true;
        chain[i].u.group.transform = turn(1, 0, pen_vec3(0.25, 0, 0));
    }
    chain[DEPTH - 1].kind = PEN_OBJECT_SPHERE;
    chain[DEPTH - 1].material = -1;
    chain[DEPTH - 1].u.sphere.radius = 1;
    kit.desc.objects = chain;
    kit.desc.object_count = 1;
    struct pen_scene *scene = kit_freeze(&kit);
    assert_close(global(scene, scene->prims.sphere[0].c), 0.25 * (DEPTH - 1), 0, 0);
    pen_scene_free(scene);
    free(chain);
}
END_TEST

START_TEST(test_freeze__materials_and_lights)
{
    kit_init(&kit);
    struct pen_material m = kit_matte(0.5);
    m.kt = pen_vec3(0, 0, 0.5);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, kit_material(&kit, m));
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    kit_point(&kit, pen_vec3(0, 0, 5), pen_vec3(0, 0, 0));
    kit_spot(&kit, pen_vec3(0, 0, 5), pen_vec3(0, 0, -7), pen_vec3(0, 1, 0))->shadows = false;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_material none = pen_material_default();
    ck_assert(memcmp(&scene->materials[scene->prim_material[0]], &none, sizeof none) == 0);
    ck_assert_uint_eq(scene->prim_material[1], 0);
    ck_assert_int_eq(scene->see_through[0], 0);
    ck_assert_int_ne(scene->see_through[1], 0);
    ck_assert(scene->any_see_through);
    ck_assert_uint_eq(scene->light_count, 1); /* the black one is not there */
    ck_assert_uint_eq(scene->light_index[0], 1);
    ck_assert(!scene->lights[0].shadows);
    assert_close(global(scene, scene->lights[0].position), 0, 0, 5);
    assert_close(scene->lights[0].direction, 0, 0, -1);
    ck_assert_int_eq(pen_scene_find_view(scene, "main"), 0);
    ck_assert_int_eq(pen_scene_find_view(scene, "Main"), -1);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_freeze__local_frame_is_about_one)
{
    for (int k = -900; k <= 900; k += 100) {
        kit_init(&kit);
        double s = ldexp(1, k);
        kit_sphere(&kit, pen_vec3(100 * s, 100 * s, 100 * s), 1.5 * s, -1);
        kit_sphere(&kit, pen_vec3(103 * s, 101 * s, 100 * s), 0.5 * s, -1);
        kit.view.camera.position = pen_vec3(100 * s, 100 * s, 120 * s);
        struct pen_scene *scene = kit_freeze(&kit);
        ck_assert_int_eq(scene->exponent, k + 3);
        for (int i = 0; i < 2; i++) {
            vec3 c = scene->prims.sphere[i].c;
            ck_assert(fabs(c.x) <= 1 && fabs(c.y) <= 1 && fabs(c.z) <= 1);
        }
        vec3 steps = pen_scale(scene->center, ldexp(1, -(k + 3)));
        ck_assert(steps.x == floor(steps.x) && steps.y == floor(steps.y));
        pen_scene_free(scene);
    }
}
END_TEST

/* If the middle is half-way between two multiples, the same one is chosen after every move. */
START_TEST(test_freeze__local_frame_moves_along)
{
    for (int k = -5; k <= 5; k++) {
        kit_init(&kit);
        kit_sphere(&kit, pen_vec3(4 * k + 0.5, 0, 0), 0.25, -1);
        kit_sphere(&kit, pen_vec3(4 * k + 3.5, 0, 0), 0.25, -1);
        struct pen_scene *scene = kit_freeze(&kit);
        ck_assert_int_eq(scene->exponent, 2);
        ck_assert(scene->center.x == 4 * k + 4);
        ck_assert(scene->prims.sphere[0].c.x == -0.875);
        pen_scene_free(scene);
    }
}
END_TEST

START_TEST(test_freeze__scenes_without_finite_primitives)
{
    kit_init(&kit);
    struct pen_scene *scene = kit_freeze(&kit); /* nothing at all */
    ck_assert_uint_eq(scene->prims.count, 0);
    ck_assert_uint_eq(scene->effects, 0);
    pen_scene_free(scene);
    kit.view.camera.position = pen_vec3(1e6, 2e6, 10);
    kit_plane(&kit, pen_vec3(1e6, 2e6, 0), pen_vec3(0, 0, 1), -1);
    scene = kit_freeze(&kit);
    ck_assert_int_eq(scene->exponent, 4); /* the plane's point and the eye are 10 apart */
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_freeze__memory_cap_is_an_error)
{
    kit_medley(&kit);
    struct pen_scene *scene = kit_freeze(&kit);
    size_t used = pen_arena_used(scene->arena);
    pen_scene_free(scene);
    for (size_t cap = 1; cap < used; cap += 1 + cap / 3) {
        struct pen_status st = {0};
        ck_assert(pen_scene_freeze(&kit.desc, PEN_ACCEL_AUTO, cap, &st) == NULL);
        ck_assert_int_eq(st.code, PEN_NO_MEMORY);
    }
    struct pen_status st;
    scene = pen_scene_freeze(&kit.desc, PEN_ACCEL_AUTO, used, &st);
    ck_assert(scene != NULL);
    pen_scene_free(scene);
}
END_TEST

/* Freezes with the n-th allocation failing, for every n; returns how many there are. */
static long allocations(enum pen_accelerator kind)
{
    for (long n = 0;; n++) {
        struct pen_status st = {0};
        alloc_fail_after(n);
        struct pen_scene *scene = pen_scene_freeze(&kit.desc, kind, 0, &st);
        bool refused = alloc_succeed();
        ck_assert_int_eq(scene == NULL, refused);
        pen_scene_free(scene);
        if (!refused)
            return n;
        ck_assert_int_eq(st.code, PEN_NO_MEMORY);
    }
}

START_TEST(test_freeze__every_allocation_may_fail)
{
    kit_medley(&kit);
    struct pen_transform f = turn(2, 30, pen_vec3(1, 2, 3));
    kit_group(&kit, 2, &f);
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        ck_assert_int_gt(allocations((enum pen_accelerator)kind), 3);
    /* Groups are collected only for the accelerator that uses them. */
    ck_assert_int_gt(allocations(PEN_ACCEL_MANUAL), allocations(PEN_ACCEL_CBR));
}
END_TEST

static struct pen_accel_stats stats_of(enum pen_accelerator kind)
{
    struct pen_status st;
    struct pen_scene *scene = pen_scene_freeze(&kit.desc, kind, 0, &st);
    ck_assert(scene != NULL);
    struct pen_accel_stats stats = *pen_accel_get_stats(scene->accel);
    ck_assert(stats.kind == kind);
    pen_scene_free(scene);
    return stats;
}

/* A sphere, a group of a sphere, a plane and a group of two spheres, a sphere. */
static void nested_groups(void)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    kit_sphere(&kit, pen_vec3(3, 0, 0), 1, -1);
    kit_plane(&kit, pen_vec3(0, -1, 0), pen_vec3(0, 1, 0), -1);
    kit_sphere(&kit, pen_vec3(6, 0, 0), 1, -1);
    kit_sphere(&kit, pen_vec3(9, 0, 0), 1, -1);
    kit_group(&kit, 3, NULL);
    struct pen_transform up = turn(1, 30, pen_vec3(0, 3, 0));
    kit_group(&kit, 1, &up);
    kit_sphere(&kit, pen_vec3(12, 0, 0), 1, -1);
}

START_TEST(test_freeze__groups_are_the_structure_of_manual)
{
    nested_groups();
    struct pen_accel_stats s = stats_of(PEN_ACCEL_MANUAL);
    ck_assert_uint_eq(s.nodes, 3);
    ck_assert_uint_eq(s.leaves, 5); /* the plane has no box */
    ck_assert_uint_eq(s.depth, 3);
    s = stats_of(PEN_ACCEL_CBR);
    ck_assert_uint_eq(s.nodes, 1);
    ck_assert_uint_eq(s.leaves, 5);
    ck_assert_uint_eq(s.depth, 1);
    kit_group(&kit, 0, NULL); /* all in one, and that in another: a box each */
    kit_group(&kit, 0, NULL);
    s = stats_of(PEN_ACCEL_MANUAL);
    ck_assert_uint_eq(s.nodes, 5);
    ck_assert_uint_eq(s.depth, 5);
}
END_TEST

START_TEST(test_freeze__manual_without_groups_is_cbr)
{
    kit_medley(&kit);
    struct pen_accel_stats manual = stats_of(PEN_ACCEL_MANUAL), cbr = stats_of(PEN_ACCEL_CBR);
    ck_assert_uint_eq(manual.nodes, 1);
    ck_assert_uint_eq(manual.leaves, cbr.leaves);
    ck_assert_uint_eq(manual.bytes, cbr.bytes);
    ck_assert(manual.sah_cost == cbr.sah_cost);
}
END_TEST

/* Groups next to each other, empty ones, and groups that begin with a group. */
START_TEST(test_freeze__groups_side_by_side)
{
    kit_init(&kit);
    struct pen_object_desc pair[2], inner, groups[4];
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    pair[0] = pair[1] = kit.objects[0];
    pair[1].u.sphere.center.x = 5;
    inner = (struct pen_object_desc){.kind = PEN_OBJECT_GROUP, .material = -1};
    inner.u.group.objects = pair;
    inner.u.group.count = 2;
    for (int i = 0; i < 4; i++) { /* two hold the same array, one a group, one nothing */
        groups[i] = inner;
        groups[i].u.group.objects = i == 3 ? &inner : i == 1 ? NULL : pair;
        groups[i].u.group.count = i == 3 ? 1 : i == 1 ? 0 : 2;
    }
    kit.desc.objects = groups;
    kit.desc.object_count = 4;
    struct pen_accel_stats s = stats_of(PEN_ACCEL_MANUAL);
    ck_assert_uint_eq(s.nodes, 1 + 3 + 1);
    ck_assert_uint_eq(s.leaves, 6);
    ck_assert_uint_eq(s.depth, 3);
}
END_TEST

/* ---- H037: rays of a 3 x 3 view plane against one primitive: how many intersections in all ----
 */

static int all_crossings(void)
{
    kit.settings.width = kit.settings.height = 3;
    kit.view.camera.position = pen_vec3(0, 0, 0);
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = 1;
    kit.view.camera.plane_width = kit.view.camera.plane_height = 3;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_pinhole p = pen_scene_pinhole(scene, 0, 3, 3);
    int n = 0;
    for (int i = 0; i < 9; i++) {
        vec3 d = pen_along(p.middle, p.dx, i % 3 + 0.5 - p.half_width);
        struct pen_ray ray;
        ck_assert(pen_ray_make(&ray, p.eye, pen_along(d, p.dy, i / 3 + 0.5 - p.half_height)));
        struct pen_t_interval span = {pen_after_start, INFINITY};
        while (pen_trace_ops_get(PEN_ISA_BASE)
                   ->nearest(scene->accel, &ray, &pen_origin_none, &span, &span.after))
            n++;
    }
    pen_scene_free(scene);
    return n;
}

START_TEST(test_freeze__h037_intersections_of_a_small_view_plane)
{
    static const struct {
        double z, r;
        int crossings;
    } spheres[] = {{-3, 1, 2}, {-2.5, 2.5, 18}, {-2, 2, 10}, {0, 4, 9}, {1, 0.5, 0}};
    for (int i = 0; i < 5; i++) {
        kit_init(&kit);
        kit_sphere(&kit, pen_vec3(0, 0, spheres[i].z), spheres[i].r, -1);
        if (spheres[i].r == 2.5 || spheres[i].r == 2) /* these are seen from half a unit behind */
            kit.objects[0].u.sphere.center.z -= 0.5;
        ck_assert_int_eq(all_crossings(), spheres[i].crossings);
    }
    static const vec3 normals[] = {{0, 0, 1}, {0, -1, 2}, {0, -1, 1}};
    static const int plane_crossings[] = {9, 9, 6};
    for (int i = 0; i < 3; i++) {
        kit_init(&kit);
        kit_plane(&kit, pen_vec3(0, 0, -5), normals[i], -1);
        ck_assert_int_eq(all_crossings(), plane_crossings[i]);
    }
    kit_init(&kit);
    kit_triangle(&kit, pen_vec3(0, 1, -2), pen_vec3(1, -1, -2), pen_vec3(-1, -1, -2), -1);
    ck_assert_int_eq(all_crossings(), 1);
    kit_init(&kit);
    kit_triangle(&kit, pen_vec3(0, 20, -2), pen_vec3(1, -1, -2), pen_vec3(-1, -1, -2), -1);
    ck_assert_int_eq(all_crossings(), 2);
}
END_TEST

enum { LATTICE = 13 };

/* The balls of a lattice are of one size, and many are cut by any plane of the lattice. */
static void make_lattice(struct pen_object_desc ball[LATTICE * LATTICE * LATTICE])
{
    kit_init(&kit);
    const struct pen_object_desc first = *kit_sphere(&kit, pen_vec3(0, 0, 0), .25, -1);
    for (int i = 0; i < LATTICE * LATTICE * LATTICE; i++) {
        ball[i] = first;
        ball[i].u.sphere.center =
            pen_vec3(i % LATTICE, i / LATTICE % LATTICE, i / (LATTICE * LATTICE));
    }
    kit.desc.objects = ball;
    kit.desc.object_count = LATTICE * LATTICE * LATTICE;
    kit.desc.primitive_count = kit.desc.object_count;
}

/* Places where primitives may coincide are only where some do. */
START_TEST(test_freeze__layers_of_a_lattice)
{
    static struct pen_object_desc ball[LATTICE * LATTICE * LATTICE];
    make_lattice(ball);
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_eq(scene->prims.count, LATTICE * LATTICE * LATTICE);
    ck_assert_ptr_null(scene->layer_first);
    pen_scene_free(scene);

    make_lattice(ball);
    ball[7].u.sphere.center = ball[1000].u.sphere.center;
    scene = kit_freeze(&kit);
    const uint32_t *first = scene->layer_first;
    ck_assert_ptr_nonnull(first);
    ck_assert_uint_eq(first[scene->prims.count], 2);
    ck_assert_uint_eq(scene->layer_place[first[7]].partner, 1000);
    ck_assert_uint_eq(scene->layer_place[first[1000]].partner, 7);
    pen_scene_free(scene);
}
END_TEST

enum { PILE = 400, PILE_PLACES = 16 };

/* Triangles in one place. */
static void make_pile(struct pen_object_desc triangle[PILE])
{
    kit_init(&kit);
    const struct pen_object_desc first =
        *kit_triangle(&kit, pen_vec3(0, 1, 0), pen_vec3(1, -1, 0), pen_vec3(-1, -1, 0), -1);
    for (int i = 0; i < PILE; i++)
        triangle[i] = first;
    kit.desc.objects = triangle;
    kit.desc.object_count = PILE;
    kit.desc.primitive_count = PILE;
}

/* Of many partners the first have a place each, and all others one; more are not kept while they
 * are being found, either. */
START_TEST(test_freeze__layers_of_a_pile)
{
    static struct pen_object_desc triangle[PILE];
    make_pile(triangle);
    alloc_take_largest();
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_lt(alloc_take_largest(), 1 << 20);
    for (uint32_t i = 0; i < PILE; i++) {
        const struct pen_layer_place *place = &scene->layer_place[scene->layer_first[i]];
        ck_assert_uint_eq(scene->layer_first[i + 1] - scene->layer_first[i], PILE_PLACES);
        for (uint32_t k = 0; k < PILE_PLACES; k++) {
            const uint32_t partner = k == PILE_PLACES - 1 ? PEN_NO_PRIM : k < i ? k : k + 1;
            ck_assert_uint_eq(place[k].partner, partner);
        }
    }
    const size_t used = pen_arena_used(scene->arena);
    pen_scene_free(scene);

    struct pen_status st = {0};
    scene = pen_scene_freeze(&kit.desc, PEN_ACCEL_AUTO, used, &st);
    ck_assert(scene != NULL);
    pen_scene_free(scene);
    for (size_t cap = used - 1; cap > 1000; cap -= cap / 3) {
        ck_assert(pen_scene_freeze(&kit.desc, PEN_ACCEL_AUTO, cap, &st) == NULL);
        ck_assert_int_eq(st.code, PEN_NO_MEMORY);
    }
}
END_TEST

/* What only rays need is left out. */
START_TEST(test_freeze__without_rays)
{
    static struct pen_object_desc triangle[PILE];
    struct pen_status st = {0};
    make_pile(triangle);
    struct pen_scene *scene = pen_scene_freeze_without_rays(&kit.desc, &st);
    ck_assert(scene != NULL);
    ck_assert_uint_eq(scene->prims.count, PILE);
    ck_assert_uint_eq(scene->view_count, 1);
    ck_assert_ptr_null(scene->layer_first);
    ck_assert_ptr_null(scene->accel);
    pen_scene_free(scene);
}
END_TEST

PEN_SUITE("freeze", test_freeze__primitives_are_numbered_depth_first,
          test_freeze__quadrics_under_similarities, test_freeze__mirrors_keep_the_outside,
          test_freeze__refuses_stretched_quadrics,
          test_freeze__a_stretch_that_is_undone_is_accepted,
          test_freeze__refuses_what_doubles_cannot_hold, test_freeze__needles,
          test_freeze__deep_groups, test_freeze__materials_and_lights,
          test_freeze__local_frame_is_about_one, test_freeze__local_frame_moves_along,
          test_freeze__scenes_without_finite_primitives, test_freeze__memory_cap_is_an_error,
          test_freeze__every_allocation_may_fail, test_freeze__groups_are_the_structure_of_manual,
          test_freeze__manual_without_groups_is_cbr, test_freeze__groups_side_by_side,
          test_freeze__h037_intersections_of_a_small_view_plane, test_freeze__layers_of_a_lattice,
          test_freeze__layers_of_a_pile, test_freeze__without_rays)
