/* SPDX-License-Identifier: MIT */
/* The media of a path: solids inside others, solids that overlap, touch and coincide, eyes inside
 * them, and surfaces that do not close. */
#include <math.h>

#include "shade/glass.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

static const vec3 middle = {0, 0, 0};

/* Balls around one point, the largest first. */
struct balls {
    int count;
    double radius[4], ior[4];
};

/* The index within a radius: that of the last ball that is larger. */
static double index_within(const struct balls *b, double radius)
{
    double ior = 1;
    for (int i = 0; i < b->count; i++)
        ior = b->radius[i] >= radius ? b->ior[i] : ior;
    return ior;
}

/* Goes on through a sphere around the middle: from without at its first point, or from within. */
static void pass_sphere(struct quad_ray *ray, quad *weight, double radius, double n1, double n2,
                        bool inward)
{
    quad t[2] = {0, 0};
    const quad square = quad_dot(ray->o, ray->o) - (quad)radius * radius;
    quad_roots(1, quad_dot(ray->o, ray->d), square, t);
    ray->o = quad_along(ray->o, ray->d, t[inward ? 0 : 1]);
    const struct quad_split split = quad_refract(quad_unit(ray->o), ray->d, n1, n2);
    *weight *= 1 - split.share;
    ray->d = split.refracted;
}

/* A ray through balls, from the first one with `from` on, which is 0 for an eye outside. Balls of
 * equal radius have one surface. Returns the number of surfaces. */
static int pass_balls(const struct balls *b, int from, struct quad_ray *ray, quad *weight)
{
    int surfaces = 0;
    for (int i = from; i < 2 * b->count; i++) {
        const bool inward = i < b->count;
        const int k = inward ? i : 2 * b->count - 1 - i;
        const double radius = b->radius[k];
        if (k > 0 && b->radius[k - 1] == radius)
            continue;
        const double outside = index_within(b, nextafter(radius, 9)),
                     inside = index_within(b, radius);
        surfaces++;
        if (outside != inside)
            pass_sphere(ray, weight, radius, inward ? outside : inside, inward ? inside : outside,
                        inward);
    }
    return surfaces;
}

/* Radii that are equal may differ by an ulp: the surfaces coincide all the same. */
static void add_balls(const struct balls *b, bool nudged)
{
    for (int i = 0; i < b->count; i++) {
        const bool equal = i > 0 && b->radius[i - 1] == b->radius[i];
        kit_sphere(&kit, middle, random_nudge(b->radius[i], -(nudged && equal)),
                   glass_material(&kit, b->ior[i]));
    }
}

static void assert_lands(const struct landing *l, double want, quad weight, double off, int i)
{
    ck_assert_msg(fabs(l->at - want) <= off, "case %d: at %.17g, want %.17g", i, l->at, want);
    ck_assert_msg(fabs(l->weight - (double)weight) <= 1e-12, "case %d: weight %.17g, want %.17g", i,
                  l->weight, (double)weight);
    ck_assert_msg(l->rays.unmatched_exits == 0, "case %d", i);
}

/* A glass with a hollow and a drink in it: the drink larger than the hollow, equal to it, smaller;
 * and a ball in the drink. */
static struct balls random_glass(struct random *r, int i)
{
    static const double gaps[] = {1e-3, 1e-12, 0, -1e-12, -1e-3, 1e-8, 1e-10};
    const double gap = gaps[i % 7];
    struct balls b = {4, {1, 0.8, 0.8, 0.3}, {1.5, 1.0003, 1.33, 1.1}};
    b.radius[gap > 0 ? 2 : 1] -= fabs(gap);
    if (gap < 0) { /* the drink is larger, so the hollow comes after it */
        b.radius[1] = 0.8;
        b.radius[2] = 0.8 + gap;
        b.ior[1] = 1.33;
        b.ior[2] = 1.0003;
    } else {
        b.radius[1] = 0.8;
    }
    for (int k = 0; k < 4; k++)
        b.ior[k] *= random_in(r, 0.999, 1.001);
    return b;
}

/* A ray that passes near the middle, so that what a ball reflects goes back. */
static struct quad_ray aim(struct random *r, double distance, struct glass_screen *screen)
{
    const vec3 eye = pen_scale(random_direction(r), distance), n = pen_normalize(eye);
    const vec3 d =
        pen_sub(pen_scale(glass_beside(r, n), random_in(r, 0, fmin(0.15, 0.15 * distance))), eye);
    glass_look(&kit, eye, d);
    *screen = (struct glass_screen){pen_scale(n, -3), n, glass_beside(r, n), 16};
    return (struct quad_ray){quad3(eye), quad_unit(quad3(d))};
}

/* H114: water in glass, up to films as thin as rounding. */
START_TEST(test_media__h114_balls_in_balls)
{
    struct random r = random_begin(551);
    for (int i = 0; i < random_some(7000, 7000 / 4); i++) {
        struct glass_screen screen;
        quad weight = 1;
        const struct balls b = random_glass(&r, i);
        glass_begin(&kit, 300);
        struct quad_ray ray = aim(&r, 3, &screen);
        kit.settings.max_depth = pass_balls(&b, 0, &ray, &weight) + 1;
        add_balls(&b, i / 7 & 1);
        const struct landing l = glass_land(&kit, &screen);
        assert_lands(&l, glass_truth(&screen, &ray), weight, 1e-12, i);
    }
}
END_TEST

/* H115: the eye in balls, at the middle of them, and anywhere. */
START_TEST(test_media__h115_eye_in_balls)
{
    struct random r = random_begin(552);
    for (int i = 0; i < random_some(5000, 5000 / 4); i++) {
        struct glass_screen screen;
        quad weight = 1;
        const struct balls b = random_glass(&r, 0);
        const int in = 1 + i % 4; /* how many balls the eye is in */
        const double inner = in < 4 ? b.radius[in] : 0, outer = b.radius[in - 1];
        const double distance = i % 5 ? random_in(&r, inner + 1e-6, outer - 1e-6) : 0;
        glass_begin(&kit, 300);
        struct quad_ray ray = aim(&r, distance > 0 ? distance : 1, &screen);
        if (in < 4 && distance == 0)
            continue;
        if (distance == 0) {
            const vec3 d = random_direction(&r);
            glass_look(&kit, middle, d);
            ray = (struct quad_ray){quad3(middle), quad_unit(quad3(d))};
            screen.point = pen_scale(d, 3);
            screen.n = d;
            screen.along = glass_beside(&r, d);
        }
        kit.settings.max_depth = pass_balls(&b, in, &ray, &weight) + 1;
        add_balls(&b, i / 7 & 1);
        const struct landing l = glass_land(&kit, &screen);
        assert_lands(&l, glass_truth(&screen, &ray), weight, 1e-12, i);
    }
}
END_TEST

/* Many rays through balls and cylinders that are off centre, overlap, touch or share a wall: every
 * one leaves only what it has entered, and no light is lost. */
START_TEST(test_media__h114_any_glasses)
{
    static const double gaps[] = {1e-3, 1e-12, 0, -1e-12, -1e-3};
    struct random r = random_begin(553);
    for (int i = 0; i < random_cases(1000); i++) {
        const double gap = gaps[i % 5];
        glass_begin(&kit, 8);
        kit.desc.background = pen_vec3(1, 1, 1);
        kit.settings.width = kit.settings.height = 10;
        kit.view.camera.fov_degrees = 40;
        const int glass = glass_material(&kit, 1.5), drink = glass_material(&kit, 1.33),
                  ball = glass_material(&kit, random_in(&r, 1, 2)),
                  air = glass_material(&kit, 1.0003);
        const vec3 axis = i & 1 ? pen_vec3(0, 1, 0) : random_direction(&r);
        kit_cylinder(&kit, pen_scale(axis, -1), axis, 1, 2, glass);
        kit_cylinder(&kit, pen_scale(axis, -0.8), axis, 0.8, 1.8, air);
        kit_cylinder(&kit, pen_scale(axis, -0.8), axis, 0.8 - gap, 1.5, drink);
        kit_sphere(&kit, random_vec(&r, 0.5), random_in(&r, 0.1, 0.6), ball);
        kit_sphere(&kit, pen_vec3(0, 0, 1.5 + gap), 0.5, glass);
        glass_look(&kit, pen_vec3(0.5, 0.3, 4.1), pen_vec3(-0.5, -0.3, -4));
        struct pen_scene *scene = kit_freeze(&kit);
        for (int k = 0; k < 100; k++) {
            struct pen_ray_counts counts;
            struct pen_status st;
            double rgb[3];
            ck_assert(pen_render_pixel(scene, 0, &kit.settings, k % 10, k / 10, rgb, &counts, &st));
            ck_assert_msg(counts.unmatched_exits == 0, "case %d, pixel %d", i, k);
            ck_assert_msg(rgb[0] <= 1 + 1e-12, "case %d, pixel %d: %.17g", i, k, rgb[0]);
        }
        pen_scene_free(scene);
    }
}
END_TEST

/* Boxes behind one another along z, that touch with equal faces, or share only their front. */
static void add_boxes(const double ior[3], const double end[4], bool one_front)
{
    for (int i = 0; i < 3; i++) {
        const double front = end[one_front ? 0 : i], half = (front - end[i + 1]) / 2;
        const double side = one_front ? 2 - 0.5 * i : 1;
        const vec3 edges[3] = {{side, 0, 0}, {0, side, 0}, {0, 0, half}};
        struct pen_material m = glass_of(ior[i]);
        m.shininess += i; /* a material of its own */
        glass_box(&kit, pen_vec3(0, 0, front - half), edges, kit_material(&kit, m), NULL);
    }
}

/* Where a ray lands behind plates of some indices: the mathematics. */
static quad pass_plates(struct quad_ray *ray, const double *ior, const double *end, int count)
{
    const struct quad3 z = {0, 0, 1};
    quad weight = 1;
    for (int i = 0; i <= count; i++) {
        ray->o = quad_along(ray->o, ray->d, (end[i] - ray->o.z) / ray->d.z);
        const double n1 = i > 0 ? ior[i - 1] : 1, n2 = i < count ? ior[i] : 1;
        if (n1 == n2)
            continue;
        const struct quad_split split = quad_refract(z, ray->d, n1, n2);
        weight *= 1 - split.share;
        ray->d = split.refracted;
    }
    return weight;
}

/* H114: three boxes with common faces, of equal and of different indices: each common face is one
 * surface. And three boxes inside each other with one front: the smallest tells the index, and
 * where it ends, the next. */
START_TEST(test_media__h114_common_faces)
{
    static const double iors[][3] = {{1.5, 1.5, 1.5}, {1.5, 1.25, 1.75}, {1.5, 1.5, 2}};
    static const double end[4] = {0.75, 0.25, -0.25, -0.75};
    static const double nested_end[4] = {0.75, -0.75, -0.25, 0.25};
    struct random r = random_begin(554);
    for (int i = 0; i < random_some(3000, 3000 / 4); i++) {
        const double *ior = iors[i / 2 % 3];
        const bool nested = i & 1;
        const double reversed[3] = {ior[2], ior[1], ior[0]};
        const vec3 eye = pen_vec3(random_in(&r, -0.3, 0.3), random_in(&r, -0.3, 0.3), 2);
        const vec3 d = pen_vec3(random_in(&r, -0.2, 0.2), random_in(&r, -0.2, 0.2), -1);
        struct glass_screen screen = {{0, 0, -2}, {0, 0, 1}, {1, 0, 0}, 4};
        screen.along = glass_beside(&r, screen.n);
        glass_begin(&kit, 5);
        glass_look(&kit, eye, d);
        add_boxes(ior, nested ? nested_end : end, nested);
        struct quad_ray ray = {quad3(eye), quad_unit(quad3(d))};
        const quad weight = pass_plates(&ray, nested ? reversed : ior, end, 3);
        const struct landing l = glass_land(&kit, &screen);
        assert_lands(&l, glass_truth(&screen, &ray), weight, 1e-12, i);
    }
}
END_TEST

/* A box across the z axis. */
static void add_plate(double side, double front, double back, int material)
{
    const vec3 edges[3] = {{side, 0, 0}, {0, side, 0}, {0, 0, (front - back) / 2}};
    glass_box(&kit, pen_vec3(0, 0, (front + back) / 2), edges, material, NULL);
}

/* H114: a ray that enters a larger box while it is in a smaller one stays in the index of that. And
 * two boxes of one material, with a wall each where they touch, are one. */
START_TEST(test_media__h114_overlaps_and_double_walls)
{
    static const double end[4] = {0.75, 0.25, -0.25, -0.75}, ior[3] = {1.25, 1.25, 1.75};
    static const double one[3] = {1.5, 1.5, 1.5};
    struct random r = random_begin(556);
    for (int i = 0; i < random_cases(1000); i++) {
        const bool overlap = i & 1;
        const vec3 eye = pen_vec3(random_in(&r, -0.3, 0.3), random_in(&r, -0.3, 0.3), 2);
        const vec3 d = pen_vec3(random_in(&r, -0.2, 0.2), random_in(&r, -0.2, 0.2), -1);
        const struct glass_screen screen = {{0, 0, -2}, {0, 0, 1}, {0, 1, 0}, 4};
        struct quad_ray ray = {quad3(eye), quad_unit(quad3(d))};
        glass_begin(&kit, overlap ? 5 : 4);
        glass_look(&kit, eye, d);
        const int m = glass_material(&kit, overlap ? 1.25 : 1.5);
        const int behind = overlap ? glass_material(&kit, 1.75) : m;
        for (int k = 0; k < 2; k++) { /* in both orders */
            if (k == (i >> 1 & 1))
                add_plate(1, end[0], end[overlap ? 2 : 1], m);
            else
                add_plate(overlap ? 2 : 1, end[1], end[3], behind);
        }
        const quad weight = pass_plates(&ray, overlap ? ior : one, end, 3);
        const struct landing l = glass_land(&kit, &screen);
        assert_lands(&l, glass_truth(&screen, &ray), weight, 1e-12, i);
    }
}
END_TEST

/* Each surface that transmits makes both rays; at one that reflects all there is one. */
START_TEST(test_media__rays_of_surfaces)
{
    struct pen_ray_counts rays;
    for (int surfaces = 1; surfaces <= 12; surfaces++) {
        glass_begin(&kit, surfaces);
        kit_sphere(&kit, middle, 1, glass_material(&kit, 1.5));
        glass_look(&kit, pen_vec3(0.1, 0.2, 5), pen_vec3(0, 0, -1));
        kit_pixel(&kit, 0, 0, &rays);
        ck_assert_uint_eq(rays.reflection, (uint64_t)surfaces - 1);
        ck_assert_uint_eq(rays.transmission, (uint64_t)surfaces - 1);
    }
    static const int faces[] = {0,  1, 2, -1, 3, 5,  4, -1, 0, 3, 4,  1,
                                -1, 1, 4, 5,  2, -1, 2, 5,  3, 0, -1, -1};
    const vec3 v[] = {{0, -1, 0}, {2, -1, 0}, {0, -1, -2}, {0, 1, 0}, {2, 1, 0}, {0, 1, -2}};
    glass_begin(&kit, 3); /* in through the front, and to the long side at 45 degrees */
    glass_solid(&kit, v, faces, pen_vec3(0.5, 0, -0.5), glass_material(&kit, 1.5), NULL);
    glass_look(&kit, pen_vec3(0.8, 0.1, 5), pen_vec3(0, 0, -1));
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.transmission, 1);
    ck_assert_uint_eq(rays.reflection, 2);
}
END_TEST

/* A pane that does not close: in from its outward side, out from the other. */
START_TEST(test_media__one_pane)
{
    struct random r = random_begin(555);
    for (int i = 0; i < random_some(2000, 2000 / 4); i++) {
        const bool back = i & 1;
        const double sign = back ? -1 : 1, ior = random_in(&r, 1.1, 1.6);
        const vec3 d = pen_vec3(random_in(&r, -0.5, 0.5), random_in(&r, -0.5, 0.5), -sign);
        const vec3 eye = pen_vec3(0, 0, 2 * sign), far = pen_vec3(0, 0, -2 * sign);
        glass_begin(&kit, 2);
        glass_look(&kit, eye, d);
        kit_sheet(&kit, 0, 5, glass_material(&kit, ior));
        struct glass_screen screen = {far, {0, 0, 1}, {1, 0, 0}, 4};
        struct quad_ray ray = {quad3(eye), quad_unit(quad3(d))};
        ray.o = quad_along(ray.o, ray.d, -ray.o.z / ray.d.z);
        const struct quad_split split =
            quad_refract((struct quad3){0, 0, 1}, ray.d, back ? ior : 1, back ? 1 : ior);
        ray.d = split.refracted;
        struct landing l = glass_land(&kit, &screen);
        ck_assert_uint_eq(l.rays.unmatched_exits, back);
        l.rays.unmatched_exits = 0;
        assert_lands(&l, glass_truth(&screen, &ray), 1 - split.share, 1e-12, i);
    }
}
END_TEST

/* H115: a lens that is partly inside glass. Each of its points is inside or not. A ball keeps the
 * rays from near its surface that are reflected totally. */
START_TEST(test_media__h115_lens_partly_inside)
{
    for (int i = 0; i < 4; i++) {
        struct pen_ray_counts rays;
        glass_begin(&kit, 1000);
        kit.desc.background = pen_vec3(1, 1, 1);
        const vec3 half[3] = {{1, 0.1, 0}, {-0.1, 1, 0}, {0, 0, 1}};
        const int m = glass_material(&kit, 1.3);
        if (i & 1)
            glass_box(&kit, pen_vec3(1, 0, 10), half, m, NULL);
        else
            kit_sphere(&kit, pen_vec3(1, 0, 10), 1, m);
        if (i & 2)
            kit_cylinder(&kit, pen_vec3(0.1, -2, 9.6), pen_vec3(0, 1, 0), 0.5, 4,
                         glass_material(&kit, 1.1));
        kit.view.camera.aperture_radius = 0.5;
        kit.view.camera.focus_distance = 7;
        kit.settings.lens_samples = 256;
        const vec3 c = kit_pixel(&kit, 0, 0, &rays);
        ck_assert_uint_eq(rays.primary, 256);
        ck_assert_uint_eq(rays.unmatched_exits, 0);
        ck_assert_uint_eq(rays.dropped_samples, 0);
        ck_assert_msg(c.x <= 1 + 1e-12 && c.x > (i & 1 ? 0.9 : 0.5), "case %d: %.17g", i, c.x);
        ck_assert_uint_gt(rays.transmission, 256);
    }
}
END_TEST

/* A ball that touches its glass from inside, all around, is seen where they touch as if there were
 * a gap, or as if it were in front, since rounding decides which of the two is met first. */
START_TEST(test_media__h149_ball_touches_its_glass)
{
    struct random r = random_begin(557);
    for (int i = 0; i < random_cases(1000); i++) {
        const vec3 axis = i & 1 ? pen_vec3(0, 1, 0) : random_direction(&r);
        const double radius = i & 2 ? 1 : random_in(&r, 0.2, 5), ior = random_in(&r, 1.1, 2);
        const vec3 out = glass_beside(&r, axis), aside = random_vec(&r, radius);
        const vec3 eye = pen_add(pen_scale(out, 6 * radius), aside);
        vec3 seen[2];
        for (int gap = 0; gap < 2; gap++) {
            struct pen_ray_counts rays;
            glass_begin(&kit, 5);
            kit.desc.background = pen_vec3(0, 1, 0);
            kit_cylinder(&kit, pen_scale(axis, -4 * radius), axis, radius, 8 * radius,
                         glass_material(&kit, ior))
                ->u.cylinder.caps = true;
            kit_sphere(&kit, middle, gap ? radius * (1 - 1e-9) : radius,
                       kit_material(&kit, kit_glow(1, 0, 0)));
            glass_look(&kit, eye, pen_sub(pen_scale(out, radius), eye));
            seen[gap] = kit_pixel(&kit, 0, 0, &rays);
        }
        const bool first = seen[0].x == 1 && seen[0].y == 0;
        ck_assert_msg(first || pen_norm1(pen_sub(seen[0], seen[1])) < 1e-6,
                      "case %d: %g %g, not %g %g", i, seen[0].x, seen[0].y, seen[1].x, seen[1].y);
    }
}
END_TEST

PEN_SUITE("media", test_media__h114_balls_in_balls, test_media__h115_eye_in_balls,
          test_media__h114_any_glasses, test_media__h149_ball_touches_its_glass,
          test_media__h114_common_faces, test_media__h114_overlaps_and_double_walls,
          test_media__rays_of_surfaces, test_media__one_pane, test_media__h115_lens_partly_inside)
