/* SPDX-License-Identifier: MIT */
/* Eyes on and in glass. On its surface they see what eyes beside it see. In a bubble they know the
 * glass around it, even if its faces barely fail to meet. */
#include <math.h>
#include <stdlib.h>

#include "shade/glass.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* A sky, so that a colour tells where a ray goes. */
static void begin(int surfaces)
{
    glass_begin(&kit, surfaces);
    kit.desc.background = pen_vec3(0.5, 0.2, 0.6);
    kit.desc.has_sky = true;
    kit.desc.sky = (struct pen_sky){{1, 0, 0.1}, {0, 1, 0.3}, pen_vec3(0.3, 0.9, -0.2)};
}

static vec3 seen_from(vec3 eye, vec3 d, struct pen_ray_counts *rays)
{
    glass_look(&kit, eye, d);
    return kit_pixel(&kit, 0, 0, rays);
}

/* What the eye sees is what it sees a little beside its place, in one direction at least. */
static void assert_seen(vec3 eye, vec3 d, const char *what, int i)
{
    struct pen_ray_counts rays, beside;
    const vec3 here = seen_from(eye, d, &rays);
    double least = INFINITY;
    for (int k = 0; k < 27; k++) {
        const vec3 by = pen_vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        const vec3 other = seen_from(pen_along(eye, by, 1e-9), d, &beside);
        const double off = pen_norm1(pen_sub(here, other));
        if (k != 13 && off < least)
            least = off;
    }
    ck_assert_msg(least <= 1e-6, "%s %d: off by %g", what, i, least);
    ck_assert_msg(rays.unmatched_exits == 0, "%s %d: an exit without entry", what, i);
}

/* A point on a cylinder around z from -1 to 1, or on a cone with its apex there. */
static vec3 on_round(struct random *r, bool cone, int part)
{
    const double angle = random_in(r, 0, 6.3), z = part == 0   ? random_in(r, -1, 1)
                                                   : part == 1 ? -1
                                                               : 1;
    const double most = cone ? (1 - z) / 2 : 1, radius = part == 0 ? most : most * random_unit(r);
    return pen_vec3(radius * cos(angle), radius * sin(angle), z);
}

START_TEST(test_eyes__h149_on_round_glass)
{
    struct random r = random_begin(571);
    for (int i = 0; i < random_cases(600); i++) {
        const int m = (begin(6), glass_material(&kit, random_in(&r, 1.1, 2)));
        const vec3 z = {0, 0, 1}, foot = {0, 0, -1};
        vec3 eye = random_direction(&r);
        if (i % 3 == 0) {
            kit_sphere(&kit, pen_vec3(0, 0, 0), 1, m);
        } else {
            struct pen_object_desc *o = kit_cylinder(&kit, foot, z, 1, 2, m);
            o->u.cylinder.caps = true;
            if (i % 3 == 2) {
                o->kind = PEN_OBJECT_CONE;
                o->u.cone.base = foot;
                o->u.cone.axis = z;
                o->u.cone.radius = 1;
                o->u.cone.top_radius = 0;
                o->u.cone.height = 2;
                o->u.cone.caps = true;
            }
            eye = on_round(&r, i % 3 == 2, i / 3 % (i % 3 == 2 ? 2 : 3)); /* not at an apex */
        }
        assert_seen(eye, random_direction(&r), "round glass", i);
    }
}
END_TEST

/* On faces, edges and corners of boxes, and on the common face of two. */
START_TEST(test_eyes__h149_on_boxes)
{
    struct random r = random_begin(572);
    for (int i = 0; i < random_cases(600); i++) {
        vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, eye = {0, 0, 0};
        begin(6);
        if (i & 1)
            glass_axes(&r, axis);
        glass_box(&kit, eye, axis, glass_material(&kit, random_in(&r, 1.1, 2)), NULL);
        if (i & 2)
            glass_box(&kit, pen_scale(axis[0], 2), axis,
                      glass_material(&kit, random_in(&r, 1.1, 2)), NULL);
        for (int k = 0; k < 3; k++)
            eye = pen_along(eye, axis[k], k == 0 || i >> (1 + k) & 1 ? 1 : random_in(&r, -1, 1));
        assert_seen(eye, random_direction(&r), "boxes", i);
    }
}
END_TEST

/* A lens that lies in a face. */
START_TEST(test_eyes__h149_lens_on_a_face)
{
    static const vec3 half[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    struct pen_ray_counts rays;
    begin(6);
    glass_box(&kit, pen_vec3(0, 0, 0), half, glass_material(&kit, 1.5), NULL);
    kit.view.camera.aperture_radius = 0.25;
    kit.view.camera.focus_distance = 4;
    kit.settings.lens_samples = 16;
    const vec3 on = seen_from(pen_vec3(0, 0, 1), pen_vec3(0.1, 0.2, -1), &rays);
    ck_assert_uint_eq(rays.unmatched_exits, 0);
    const vec3 before = seen_from(pen_vec3(0, 0, 1 + 1e-9), pen_vec3(0.1, 0.2, -1), &rays);
    const vec3 behind = seen_from(pen_vec3(0, 0, 1 - 1e-9), pen_vec3(0.1, 0.2, -1), &rays);
    ck_assert(pen_norm1(pen_sub(on, before)) < 1e-6 || pen_norm1(pen_sub(on, behind)) < 1e-6);
}
END_TEST

/* A box whose front is cut at a point of its upper edge, which the top does not know. */
static void add_cut_box(const vec3 axis[3], double at, int material)
{
    vec3 v[10];
    for (int i = 0; i < 8; i++) {
        v[i] = pen_vec3(0, 0, 0);
        for (int k = 0; k < 3; k++)
            v[i] = pen_along(v[i], axis[k], i >> k & 1 ? 1 : -1);
    }
    v[8] = pen_along(pen_scale(v[6], at), v[7], 1 - at);
    static const int faces[] = {0,  2, 3, 1, -1, 0,  1, 5, 4, -1, 2, 6, 7, 3,  -1, 0, 4, 6,  2,
                                -1, 1, 3, 7, 5,  -1, 4, 5, 8, -1, 4, 8, 6, -1, 5,  7, 8, -1, -1};
    glass_solid(&kit, v, faces, pen_vec3(0, 0, 0), material, NULL);
}

START_TEST(test_eyes__h149_bubble_among_t_junctions)
{
    struct random r = random_begin(573);
    for (int i = 0; i < random_cases(300); i++) {
        vec3 axis[3];
        struct pen_ray_counts rays;
        glass_axes(&r, axis);
        const vec3 eye = random_vec(&r, 0.25), d = random_direction(&r);
        const double at = random_in(&r, 0.2, 0.8);
        vec3 seen[2];
        for (int cut = 0; cut < 2; cut++) {
            begin(6);
            const int glass = glass_material(&kit, 1.5), air = glass_material(&kit, 1);
            kit.materials[air].ior_written = true;
            if (cut)
                add_cut_box(axis, at, glass);
            else
                glass_box(&kit, pen_vec3(0, 0, 0), axis, glass, NULL);
            if (i & 1) /* else the eye is in the glass itself */
                kit_sphere(&kit, pen_vec3(0, 0, 0), 0.6, air);
            seen[cut] = seen_from(eye, d, &rays);
            ck_assert_msg(rays.unmatched_exits == 0, "case %d, cut %d", i, cut);
        }
        ck_assert_msg(pen_norm1(pen_sub(seen[0], seen[1])) < 1e-9, "case %d", i);
    }
}
END_TEST

/* A pane that does not close has no inside. */
START_TEST(test_eyes__h149_behind_a_pane)
{
    struct pen_ray_counts rays;
    begin(2);
    kit_sheet(&kit, 0, 5, glass_material(&kit, 1.5));
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_eq(scene->solids.count, 1);
    ck_assert(!pen_solid_contains(&scene->prims, &scene->solids, 0, pen_vec3(0, 0, 0)));
    pen_scene_free(scene);
    seen_from(pen_vec3(0, 0, -1), pen_vec3(0, 0, 1), &rays);
    ck_assert_uint_eq(rays.unmatched_exits, 1);
}
END_TEST

PEN_SUITE("eyes", test_eyes__h149_on_round_glass, test_eyes__h149_on_boxes,
          test_eyes__h149_lens_on_a_face, test_eyes__h149_bubble_among_t_junctions,
          test_eyes__h149_behind_a_pane)
