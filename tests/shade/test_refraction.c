/* SPDX-License-Identifier: MIT */
/* Where refracted rays end, against Snell's law in 113 bits: behind plates, balls, boxes and
 * prisms, forth and back, and as the index approaches 1. */
#include <math.h>
#include <stdlib.h>

#include "shade/glass.h"
#include "support/suite.h"

#define U 0x1p-53

typedef struct pen_vec3 vec3;

static struct kit kit;

/* A ray through surfaces, in 113 bits. */
struct passage {
    bool clear; /* of edges, and of angles where 1e-16 at a surface becomes much more behind it */
    quad weight;
    struct quad_ray ray;
    struct quad3 reflected; /* by the first surface */
};

static struct passage pass_from(vec3 eye, vec3 direction)
{
    return (struct passage){true, 1, {quad3(eye), quad_unit(quad3(direction))}, {0, 0, 0}};
}

/* Goes on through the surface at t. */
static void pass(struct passage *p, struct quad3 n, quad t, double n1, double n2)
{
    const struct quad_split split = quad_refract(n, p->ray.d, n1, n2);
    p->clear = p->clear && !split.total && split.steep > (quad)0.05;
    if (p->weight == 1)
        p->reflected = split.reflected;
    p->weight *= 1 - split.share;
    p->ray = (struct quad_ray){quad_along(p->ray.o, p->ray.d, t), split.refracted};
}

static void pass_convex(struct passage *p, const struct convex *solid, double ior)
{
    for (int i = 0; i < 2 && p->clear; i++) {
        struct crossing x;
        p->clear = convex_cross(solid, &p->ray, &x, 1e-6);
        if (p->clear)
            pass(p, solid->n[x.face[i]], x.t[i], i == 0 ? 1 : ior, i == 0 ? ior : 1);
    }
}

enum solid_kind { SLAB, BALL, PRISM, SOLIDS };

static void add_slab(struct random *r, double ior, struct convex *truth)
{
    vec3 half[3];
    glass_axes(r, half);
    half[0] = pen_scale(half[0], 2);
    half[1] = pen_scale(half[1], 1.5);
    half[2] = pen_scale(half[2], random_in(r, 0.01, 0.5));
    glass_box(&kit, random_vec(r, 0.5), half, glass_material(&kit, ior), truth);
}

static void add_prism(struct random *r, double ior, struct convex *truth)
{
    static const int faces[] = {0,  1, 2, -1, 3, 5,  4, -1, 0, 3, 4,  1,
                                -1, 1, 4, 5,  2, -1, 2, 5,  3, 0, -1, -1};
    vec3 axis[3], v[6];
    glass_axes(r, axis);
    const vec3 middle = random_vec(r, 0.5);
    for (int i = 0; i < 6; i++) {
        const double turn = 2.1 * (i % 3) + random_in(r, -0.4, 0.4) * (i < 3);
        if (i >= 3) {
            v[i] = pen_along(v[i - 3], axis[2], 3);
            continue;
        }
        v[i] = pen_along(middle, axis[0], 1.5 * cos(turn));
        v[i] = pen_along(pen_along(v[i], axis[1], 1.5 * sin(turn)), axis[2], -1.5);
    }
    glass_solid(&kit, v, faces, middle, glass_material(&kit, ior), truth);
}

struct ball {
    vec3 center;
    double radius, ior;
};

static void pass_sphere(struct passage *p, const struct ball *ball)
{
    const struct quad3 c = quad3(ball->center);
    for (int i = 0; i < 2 && p->clear; i++) {
        quad t[2];
        const struct quad3 f = quad_sub(p->ray.o, c);
        const quad square = quad_dot(f, f) - (quad)ball->radius * ball->radius;
        p->clear = quad_roots(1, quad_dot(f, p->ray.d), square, t) > (quad)1e-6;
        const struct quad3 n = quad_unit(quad_sub(quad_along(p->ray.o, p->ray.d, t[i]), c));
        if (p->clear)
            pass(p, n, t[i], i == 0 ? 1 : ball->ior, i == 0 ? ball->ior : 1);
    }
}

static struct ball add_ball(struct random *r, double ior)
{
    const double radius = random_in(r, 0.5, 2);
    const struct ball ball = {random_vec(r, 0.5), radius, ior};
    kit_sphere(&kit, ball.center, radius, glass_material(&kit, ior));
    return ball;
}

/* The mathematics' way of a ray through a solid of the kind, which is added to the scene. */
static struct passage random_passage(struct random *r, enum solid_kind kind, vec3 eye, vec3 d)
{
    const double ior = random_in(r, 1, 2.5);
    struct passage p = pass_from(eye, d);
    struct convex solid;
    if (kind == BALL) {
        const struct ball ball = add_ball(r, ior);
        pass_sphere(&p, &ball);
        return p;
    }
    if (kind == SLAB)
        add_slab(r, ior, &solid);
    else
        add_prism(r, ior, &solid);
    pass_convex(&p, &solid, ior);
    return p;
}

/* Whether a ray goes to the screen behind the scene, and the first reflected one does not. */
static bool only_refracted(const struct passage *p, const struct glass_screen *screen)
{
    return p->clear && quad_dot(p->ray.d, quad3(screen->n)) < (quad)-0.3 &&
           quad_dot(p->reflected, quad3(screen->n)) > (quad)1e-3;
}

/* A screen behind the middle of the scene, across the way from the eye to there. */
static struct glass_screen screen_behind(struct random *r, vec3 eye)
{
    const vec3 n = pen_normalize(eye);
    return (struct glass_screen){pen_neg(eye), n, glass_beside(r, n), 32};
}

static const double eye_distance = 6;

/* Looks at the middle from somewhere. */
static vec3 look_inward(struct random *r, vec3 *direction)
{
    const vec3 eye = pen_scale(random_direction(r), eye_distance);
    *direction = pen_sub(random_vec(r, 0.8), eye);
    glass_look(&kit, eye, *direction);
    return eye;
}

/* The bar of refraction: a ray through a random solid lands where it should. */
START_TEST(test_refraction__rays_land_where_snell_says)
{
    struct random r = random_begin(511);
    int landed[SOLIDS] = {0};
    const int cases = random_cases(10000);
    for (int i = 0; landed[SLAB] + landed[BALL] + landed[PRISM] < cases; i++) {
        const enum solid_kind kind = (enum solid_kind)(i % SOLIDS);
        vec3 d;
        glass_begin(&kit, 3);
        const vec3 eye = look_inward(&r, &d);
        const struct glass_screen screen = screen_behind(&r, eye);
        const struct passage p = random_passage(&r, kind, eye, d);
        if (!only_refracted(&p, &screen))
            continue;
        const struct landing l = glass_land(&kit, &screen);
        const double want = glass_truth(&screen, &p.ray);
        ck_assert_uint_eq(l.rays.reflection + l.rays.transmission, 4);
        ck_assert_msg(fabs(l.at - want) <= 1e-12 * eye_distance,
                      "case %d, solid %d: %.17g, not %.17g", i, kind, l.at, want);
        ck_assert_double_le(fabs(l.weight - (double)p.weight), 1e-12);
        landed[kind]++;
    }
    for (int i = 0; i < SOLIDS; i++)
        ck_assert_int_gt(landed[i], cases / 10);
}
END_TEST

/* H108: plates across one axis, one behind the other. */
enum { PLATES = 1000 };
static struct pen_object_desc plates[PLATES + 1]; /* and the screen */

/* Returns where the last one ends. */
static double make_plates(struct random *r, vec3 axis)
{
    int material[50];
    double at = 0;
    glass_begin(&kit, 2 * PLATES + 1);
    for (int i = 0; i < 50; i++)
        material[i] = glass_material(&kit, random_in(r, 1, 2.5));
    for (int i = 0; i < PLATES; i++) {
        const double thick = random_in(r, 0.001, 0.05);
        kit.desc.object_count = 0;
        plates[i] = *kit_cylinder(&kit, pen_scale(axis, at), axis, 30, thick,
                                  material[random_below(r, 50)]);
        at += thick + random_in(r, 0.001, 0.02);
    }
    return at;
}

/* Where the ray lands on a screen behind the plates. */
static double land_behind_plates(const struct glass_screen *screen)
{
    kit.desc.objects = kit.objects;
    kit.desc.object_count = 0;
    plates[PLATES] = *glass_add_screen(&kit, screen);
    kit.desc.objects = plates;
    kit.desc.object_count = PLATES + 1;
    kit.desc.primitive_count = PLATES + 1;
    const struct landing l = glass_landed(&kit, screen);
    ck_assert_uint_eq(l.rays.unmatched_exits, 0);
    ck_assert(l.weight > 0);
    kit.desc.material_count--;
    return l.at;
}

START_TEST(test_refraction__h108_direction_behind_1000_plates)
{
    struct random r = random_begin(512);
    const double far = 1e4;
    for (int i = 0; i < random_cases(8); i++) {
        const vec3 axis = i % 8 == 5 ? random_direction(&r) : pen_vec3(0, 0, i & 1 ? -1 : 1);
        const double end = make_plates(&r, axis);
        const vec3 across = glass_beside(&r, axis);
        const double slope = i == 1 ? 0 : random_in(&r, 0.05, 1);
        const vec3 d = pen_normalize(pen_along(axis, across, slope));
        glass_look(&kit, pen_along(pen_scale(axis, -1), across, -0.5 * end * slope), d);
        double at[2];
        for (int k = 0; k < 2; k++) {
            const vec3 middle = pen_along(pen_scale(axis, end + k * far), across, k * far * slope);
            at[k] = land_behind_plates(&(struct glass_screen){middle, axis, across, 100});
        }
        ck_assert_msg(fabs(at[1] - at[0]) / far <= PLATES * 4 * U, "case %d: off by %g u", i,
                      fabs(at[1] - at[0]) / far / U);
    }
}
END_TEST

/* Where a ray lands in both directions of a screen. */
static vec3 land_in_space(struct glass_screen screen)
{
    const double x = glass_land(&kit, &screen).at;
    const vec3 first = screen.along;
    screen.along = pen_cross(screen.n, first);
    const double y = glass_land(&kit, &screen).at;
    return pen_along(pen_along(screen.point, first, x), screen.along, y);
}

/* H109: what leaves a ball, looked at from behind, is where the eye was. */
START_TEST(test_refraction__h109_a_path_through_a_ball_and_back)
{
    struct random r = random_begin(513);
    for (int i = 0; i < random_cases(2000);) {
        vec3 d;
        glass_begin(&kit, 3);
        const vec3 eye = look_inward(&r, &d);
        struct glass_screen screen = screen_behind(&r, eye);
        const struct ball ball = add_ball(&r, random_in(&r, 1, 2.5));
        struct passage p = pass_from(eye, d);
        pass_sphere(&p, &ball);
        if (!only_refracted(&p, &screen))
            continue;
        const vec3 near = land_in_space(screen);
        screen.point = pen_scale(eye, -2);
        const vec3 far = land_in_space(screen);
        p = pass_from(near, pen_sub(near, far));
        pass_sphere(&p, &ball);
        screen.n = pen_neg(screen.n);
        screen.point = eye;
        if (!only_refracted(&p, &screen))
            continue;
        glass_look(&kit, near, pen_sub(near, far));
        const double beside = pen_length(pen_sub(land_in_space(screen), eye));
        ck_assert_msg(beside <= 1e-12 * 3 * eye_distance, "case %d: %g beside", i, beside);
        i++;
    }
}
END_TEST

/* H110: a scene of glass in front of a slope of light. `hidden` adds a ball that refracts, behind
 * the eye. */
static struct pen_scene *glass_in_light(double ior, bool hidden)
{
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 24;
    kit.settings.min_contribution = 0;
    kit.settings.max_depth = 6;
    kit.desc.ambient = kit.desc.background = pen_vec3(0.25, 0.5, 1);
    const int glass = glass_material(&kit, ior);
    kit.materials[glass].kt = pen_vec3(0.9, 0.8, 0.7);
    kit.materials[glass].kr = pen_vec3(0.1, 0.1, 0);
    kit.materials[glass].kd = pen_vec3(0.1, 0.1, 0.2);
    kit_sphere(&kit, pen_vec3(-1, 0.5, 0), 2, glass);
    kit_cylinder(&kit, pen_vec3(1, -2, 0), pen_vec3(0, 1, 0.5), 1, 3, glass);
    const vec3 half[3] = {{1, 0.25, 0}, {-0.25, 1, 0}, {0, 0, 1}};
    glass_box(&kit, pen_vec3(0.5, 1, 1), half, glass, NULL);
    kit_sphere(&kit, pen_vec3(0, 0, 12), 0.25, glass_material(&kit, hidden ? 1.5 : 1));
    kit_point(&kit, pen_vec3(3, 3, 8), pen_vec3(1, 1, 1));
    glass_add_screen(&kit, &(struct glass_screen){{0, 0, -5}, {0, 0, 1}, {0.6, 0.8, 0}, 16});
    return kit_freeze(&kit);
}

START_TEST(test_refraction__h110_index_1_is_no_refraction)
{
    struct pen_scene *without = glass_in_light(1, false), *with = glass_in_light(1, true);
    const unsigned more =
        pen_scene_effects(with, 0, &kit.settings) & ~pen_scene_effects(without, 0, &kit.settings);
    ck_assert_uint_eq(more, PEN_FX_REFRACTION);
    float *a = kit_film(without, &kit.settings, 1), *b = kit_film(with, &kit.settings, 1);
    ck_assert_mem_eq(a, b, sizeof(float) * 3 * 24 * 24);
    free(a);
    free(b);
    pen_scene_free(without);
    pen_scene_free(with);
}
END_TEST

/* The mean and the largest difference of the pixels of two scenes. */
static double difference(const struct pen_scene *a, const struct pen_scene *b, double *most)
{
    struct pen_ray_counts counts;
    struct pen_status st;
    double sum = 0, p[3], q[3];
    *most = 0;
    for (int i = 0; i < 24 * 24; i++) {
        ck_assert(pen_render_pixel(a, 0, &kit.settings, i % 24, i / 24, p, &counts, &st));
        ck_assert(pen_render_pixel(b, 0, &kit.settings, i % 24, i / 24, q, &counts, &st));
        for (int c = 0; c < 3; c++) {
            sum += fabs(p[c] - q[c]) / (3 * 24 * 24);
            *most = fmax(*most, fabs(p[c] - q[c]));
        }
    }
    return sum;
}

START_TEST(test_refraction__h110_as_the_index_goes_to_1)
{
    struct pen_scene *limit = glass_in_light(1, false);
    for (double off = 1e-3; off >= 1e-12; off /= 10) {
        for (int side = -1; side <= 1; side += 2) {
            struct pen_scene *scene = glass_in_light(1 + side * off, false);
            double most;
            const double mean = difference(limit, scene, &most);
            ck_assert_msg(mean <= off && most <= 100 * off, "%g: mean %g, most %g", off, mean,
                          most);
            ck_assert_double_gt(mean, 0.01 * off);
            pen_scene_free(scene);
        }
    }
    pen_scene_free(limit);
}
END_TEST

/* H111: a ball of index 2 focuses on its back. A ray at height h meets the back at
 * sin(2 asin(h / 2) - asin h), which is -h^3 / 8 and a term of h^5. */
START_TEST(test_refraction__h111_a_ball_lens)
{
    const double behind = 1e-11;
    for (double h = 0.2; h > 1e-6; h /= 2) {
        glass_begin(&kit, 3);
        kit_sphere(&kit, pen_vec3(0, 0, 0), 1, glass_material(&kit, 2));
        glass_look(&kit, pen_vec3(0, h, 3), pen_vec3(0, 0, -1));
        const struct landing l = glass_land(
            &kit, &(struct glass_screen){{0, 0, -1 - behind}, {0, 0, 1}, {0, 1, 0}, 0.25});
        const double back = sin(2 * asin(h / 2) - asin(h)), drop = 1 - cos(asin(back));
        const double most = h * (2 * behind + 2 * drop) + 1e-15;
        ck_assert_msg(fabs(l.at - back) <= most, "height %g: at %g, want %g", h, l.at, back);
        ck_assert(fabs(l.at) <= h * h * h / 4 + 1e-11 * h + 1e-15);
        ck_assert_double_le(fabs(l.weight - 64. / 81), h * h);
    }
}
END_TEST

PEN_SUITE("refraction", test_refraction__rays_land_where_snell_says,
          test_refraction__h108_direction_behind_1000_plates,
          test_refraction__h109_a_path_through_a_ball_and_back,
          test_refraction__h110_index_1_is_no_refraction,
          test_refraction__h110_as_the_index_goes_to_1, test_refraction__h111_a_ball_lens)
