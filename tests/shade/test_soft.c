/* SPDX-License-Identifier: MIT */
/* Soft shadows against closed forms and limits. The part of a disk light of radius R that is seen
 * past a straight edge, h R from its centre, is v(h) = (acos h - h sqrt(1 - h^2)) / pi. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "math/frame.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* Mean and its standard error. */
struct mean {
    double sum, squares;
    int count;
};

static void mean_add(struct mean *m, double x)
{
    m->sum += x;
    m->squares += x * x;
    m->count++;
}

static double mean_of(const struct mean *m)
{
    return m->sum / m->count;
}

static double mean_error(const struct mean *m)
{
    double variance = m->squares / m->count - mean_of(m) * mean_of(m);
    return sqrt(fmax(variance, 0) / (m->count - 1));
}

/* Within five standard errors; where all agree, within rounding. */
static void assert_mean(const struct mean *m, double want, const char *what)
{
    double off = mean_of(m) - want, allowed = 5 * mean_error(m) + 1e-12;
    ck_assert_msg(fabs(off) <= allowed, "%s: mean %.9g, want %.9g, 5 sigma %.3g", what, mean_of(m),
                  want, allowed);
}

static double seen_past_edge(double h)
{
    return (acos(h) - h * sqrt(1 - h * h)) / M_PI;
}

static const double light_height = 8, light_radius = 1.5;

/* A white floor seen at the origin from the side, and a disk light above it: brightness is T(p).
 * Nothing is before the light yet. */
static struct pen_light_desc *floor_and_disk(void)
{
    kit_init(&kit);
    kit.view.camera.position = pen_vec3(0, -6, 3);
    kit.view.camera.direction = pen_vec3(0, 6, -3);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(1)));
    struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 0, light_height), pen_vec3(1, 1, 1));
    light->radius = light_radius;
    return light;
}

/* A half-plane half way up whose edge, turned by an angle, leaves v(h) of the disk to be seen. */
static void half_plane(double h, double angle, int material)
{
    vec3 out = {cos(angle), sin(angle), 0}, along = {-sin(angle), cos(angle), 0};
    vec3 edge = pen_along(pen_vec3(0, 0, light_height / 2), out, h * light_radius / 2);
    vec3 back = pen_along(edge, out, -100);
    const vec3 v[] = {pen_along(edge, along, -100), pen_along(edge, along, 100),
                      pen_along(back, along, 100), pen_along(back, along, -100)};
    kit_polygon(&kit, v, 4, material);
}

static vec3 pixel_of(const struct pen_scene *scene, int x, int y, struct pen_ray_counts *rays)
{
    struct pen_status st;
    double rgb[3];
    ck_assert(pen_render_pixel(scene, 0, &kit.settings, x, y, rgb, rays, &st));
    return pen_vec3(rgb[0], rgb[1], rgb[2]);
}

static vec3 pixel_with_seed(const struct pen_scene *scene, uint64_t seed)
{
    struct pen_ray_counts rays;
    kit.settings.seed = seed;
    return pixel_of(scene, 0, 0, &rays);
}

START_TEST(test_soft__h121_half_plane)
{
    static const double heights[] = {-0.95, -0.5, 0, 0.25, 0.8};
    for (int pattern = PEN_PATTERN_SOBOL; pattern <= PEN_PATTERN_RANDOM; pattern++)
        for (int n = 16; n <= 64; n += 48)
            for (size_t i = 0; i < sizeof heights / sizeof heights[0]; i++) {
                floor_and_disk();
                half_plane(heights[i], 0.3 + (double)i, -1);
                kit.settings.light_samples = n;
                kit.settings.light_pattern = pattern;
                struct pen_scene *scene = kit_freeze(&kit);
                struct mean m = {0};
                for (uint64_t seed = 0; seed < 600; seed++)
                    mean_add(&m, pixel_with_seed(scene, seed).x);
                pen_scene_free(scene);
                char what[64];
                snprintf(what, sizeof what, "pattern %d, n %d, h %g", pattern, n, heights[i]);
                assert_mean(&m, seen_past_edge(heights[i]), what);
            }
}
END_TEST

/* Root mean square error over edges at any place and angle, each under its own seed. */
static double edge_rmse(int pattern, int n)
{
    enum { EDGES = 400 };
    struct random random = random_begin(121);
    double squares = 0;
    for (uint64_t e = 0; e < EDGES; e++) {
        double h = random_in(&random, -1, 1);
        floor_and_disk();
        half_plane(h, random_in(&random, 0, 2 * M_PI), -1);
        kit.settings.light_samples = n;
        kit.settings.light_pattern = pattern;
        struct pen_scene *scene = kit_freeze(&kit);
        double off = pixel_with_seed(scene, e).x - seen_past_edge(h);
        pen_scene_free(scene);
        squares += off * off;
    }
    return sqrt(squares / EDGES);
}

/* Published for these patterns: 0.75 for scrambled Sobol' points, 0.73 for the jittered grid in a
 * circle, 0.5 for random points. */
START_TEST(test_soft__h121_converges_with_the_slope_of_its_pattern)
{
    static const double slopes[] = {
        [PEN_PATTERN_SOBOL] = 0.75, [PEN_PATTERN_GRID] = 0.73, [PEN_PATTERN_RANDOM] = 0.5};
    static const double at_256[] = {
        [PEN_PATTERN_SOBOL] = 5.5e-3, [PEN_PATTERN_GRID] = 9.7e-3, [PEN_PATTERN_RANDOM] = 2.4e-2};
    for (int pattern = PEN_PATTERN_SOBOL; pattern <= PEN_PATTERN_RANDOM; pattern++) {
        double few = edge_rmse(pattern, 16), some = edge_rmse(pattern, 256);
        double many = edge_rmse(pattern, 1024), slope = log(few / many) / log(64);
        printf("pattern %d: rmse %.3g at 16, %.3g at 256, %.3g at 1024, slope -%.3f\n", pattern,
               few, some, many, slope);
        ck_assert_double_eq_tol(slope, slopes[pattern], 0.08);
        ck_assert_double_lt(some, 1.2 * at_256[pattern]);
        ck_assert_double_gt(some, 0.7 * at_256[pattern]);
    }
}
END_TEST

/* A sphere under the disk: T is 0 exactly in the umbra, 1 exactly beyond the penumbra, and between
 * them elsewhere, with at most the pixel on the border in doubt. */
START_TEST(test_soft__h122_umbra_of_a_sphere)
{
    enum { WIDTH = 240 };
    const double r = 2, a = 4, half = 14;
    floor_and_disk();
    kit_sphere(&kit, pen_vec3(0, 0, a), r, -1);
    kit.settings.width = WIDTH;
    kit.settings.height = 1;
    kit.settings.light_samples = 4096;
    kit.view.camera.position = pen_vec3(0, -40, 6);
    kit.view.camera.direction = pen_vec3(0, 40, -6);
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = hypot(40, 6);
    kit.view.camera.plane_width = 2 * half;
    kit.view.camera.plane_height = 1e-3;
    struct pen_scene *scene = kit_freeze(&kit);
    int kinds[3] = {0}, last = -1, borders = 0;
    for (int x = 0; x < WIDTH; x++) {
        vec3 p = {2 * half * ((x + 0.5) / WIDTH - 0.5), 0, 0}, s = {0, 0, a};
        vec3 to_light = pen_sub(pen_vec3(0, 0, light_height), p), to_sphere = pen_sub(s, p);
        double d = pen_length(to_light), e = pen_length(to_sphere);
        double apart = acos(fmin(1, pen_dot(to_light, to_sphere) / (d * e)));
        double disk = atan(light_radius / d), cap = asin(r / e);
        int kind = apart + disk <= cap ? 0 : apart >= cap + disk ? 2 : 1;
        struct pen_ray_counts rays;
        double t = pixel_of(scene, x, 0, &rays).x * d / light_height;
        int found = t == 0 ? 0 : fabs(t - 1) < 1e-12 ? 2 : 1;
        borders += last >= 0 && kind != last;
        kinds[kind]++;
        if (found != kind) { /* only beside a border: the next pixel is of the kind found */
            vec3 q = {p.x + (p.x > 0 ? -1 : 1) * (found < kind ? 1 : -1) * 2 * half / WIDTH, 0, 0};
            double dq = pen_length(pen_sub(pen_vec3(0, 0, light_height), q));
            double eq = pen_length(pen_sub(s, q));
            double next = acos(fmin(
                1, pen_dot(pen_sub(pen_vec3(0, 0, light_height), q), pen_sub(s, q)) / (dq * eq)));
            double disk_q = atan(light_radius / dq), cap_q = asin(r / eq);
            int beside = next + disk_q <= cap_q ? 0 : next >= cap_q + disk_q ? 2 : 1;
            ck_assert_msg(beside == found, "pixel %d: found %d, kind %d, t %.9g", x, found, kind,
                          t);
        }
        last = kind;
    }
    pen_scene_free(scene);
    ck_assert_int_eq(borders, 4);
    for (int kind = 0; kind < 3; kind++)
        ck_assert_int_gt(kinds[kind], 20);
}
END_TEST

typedef long double real;

static real product(vec3 a, vec3 b)
{
    return (real)a.x * b.x + (real)a.y * b.y + (real)a.z * b.z;
}

/* How far a frame is from orthonormal and right-handed, in units of 2^-53. */
static double frame_off(vec3 n)
{
    struct pen_across f = pen_across(n);
    vec3 w = {(double)((real)f.u.y * f.v.z - (real)f.u.z * f.v.y),
              (double)((real)f.u.z * f.v.x - (real)f.u.x * f.v.z),
              (double)((real)f.u.x * f.v.y - (real)f.u.y * f.v.x)};
    real off[] = {sqrtl(product(f.u, f.u)) - 1,
                  sqrtl(product(f.v, f.v)) - 1,
                  product(f.u, f.v),
                  product(f.u, n),
                  product(f.v, n),
                  w.x - n.x,
                  w.y - n.y,
                  w.z - n.z};
    double most = 0;
    for (size_t i = 0; i < sizeof off / sizeof off[0]; i++)
        most = fmax(most, (double)fabsl(off[i]) * 0x1p53);
    return most;
}

START_TEST(test_soft__h123_frame_near_every_axis)
{
    struct random random = random_begin(123);
    double worst = 0;
    for (int i = 0; i < 200000; i++) {
        vec3 n = random_direction(&random);
        if (i % 2) { /* near an axis, a plane of two axes, or the diagonal */
            double near = pow(10, -random_in(&random, 1, 20));
            n = pen_vec3(random_below(&random, 3) - 1., random_below(&random, 3) - 1.,
                         random_below(&random, 3) - 1.);
            n = pen_add(n, random_vec(&random, near));
            if (pen_norm1(n) < 0.5)
                continue;
            n = pen_normalize(n);
        }
        double off = frame_off(n);
        ck_assert_msg(off <= 4, "seed %llu, n %a %a %a: %.2f u", (unsigned long long)random.seed,
                      n.x, n.y, n.z, off);
        worst = fmax(worst, off);
    }
    for (int axis = 0; axis < 6; axis++) {
        double s = axis % 2 ? -1 : 1;
        ck_assert_double_eq(frame_off(pen_vec3(axis / 2 == 0 ? s : 0., axis / 2 == 1 ? s : 0.,
                                               axis / 2 == 2 ? s : -0.)),
                            0);
    }
    printf("worst frame: %.2f u\n", worst);
}
END_TEST

/* Rotates the scene so that the light, which was at +z, is in another direction. */
static void turn_scene(vec3 axis, double degrees)
{
    struct pen_transform f = pen_transform_make(1, axis, degrees, pen_vec3(0, 0, 0));
    for (uint32_t i = 0; i < kit.vertex_count; i++)
        kit.vertices[i] = pen_transform_point(&f, kit.vertices[i]);
    for (uint32_t i = 0; i < kit.desc.light_count; i++) {
        kit.lights[i].position = pen_transform_point(&f, kit.lights[i].position);
        kit.lights[i].direction = pen_transform_vector(&f, kit.lights[i].direction);
    }
    for (uint32_t i = 0; i < kit.desc.object_count; i++) {
        struct pen_object_desc *o = &kit.objects[i];
        if (o->kind == PEN_OBJECT_PLANE)
            o->u.plane.normal = pen_transform_vector(&f, o->u.plane.normal);
        else if (o->kind == PEN_OBJECT_SPHERE)
            o->u.sphere.center = pen_transform_point(&f, o->u.sphere.center);
    }
    struct pen_camera_desc *c = &kit.view.camera;
    c->position = pen_transform_point(&f, c->position);
    c->direction = pen_transform_vector(&f, c->direction);
    c->up = pen_transform_vector(&f, c->up);
}

/* The light straight along an axis or a hair off it: the frame's worst places. */
START_TEST(test_soft__h123_penumbra_with_the_light_along_an_axis)
{
    static const vec3 axes[] = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}};
    static const double degrees[] = {0, 90, 180, 270, 90, 270};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++) {
            struct mean m = {0};
            floor_and_disk();
            half_plane(0.3, 0.5, -1);
            turn_scene(axes[i], degrees[i] + (k - 1) * 5e-8); /* 1e-9 */
            struct pen_scene *scene = kit_freeze(&kit);
            for (uint64_t seed = 0; seed < 400; seed++)
                mean_add(&m, pixel_with_seed(scene, seed).x);
            pen_scene_free(scene);
            assert_mean(&m, seen_past_edge(0.3), "along an axis");
        }
}
END_TEST

START_TEST(test_soft__h124_radius_zero_is_a_hard_shadow)
{
    kit_medley(&kit);
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        kit.lights[i].radius = kit.lights[i].angular_radius = 0;
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings) & PEN_FX_SOFT_SHADOWS, 0);
    int pixels = kit.settings.width * kit.settings.height;
    float *hard = kit_film(scene, &kit.settings, 1);
    pen_scene_free(scene);
    /* The others are the same picture with disks so small that they are points. */
    for (uint32_t i = 0; i < kit.desc.light_count; i++) {
        kit.lights[i].radius = 1e-12;
        kit.lights[i].angular_radius = 1e-12;
    }
    scene = kit_freeze(&kit);
    float *tiny = kit_film(scene, &kit.settings, 1);
    pen_scene_free(scene);
    int different = 0;
    for (int i = 0; i < 3 * pixels; i++) {
        ck_assert(isfinite(tiny[i]));
        different += fabsf(tiny[i] - hard[i]) > 1e-6f;
    }
    ck_assert_int_eq(different, 0);
    free(hard);
    free(tiny);
}
END_TEST

START_TEST(test_soft__h124_enormous_lights_stay_finite)
{
    static const double radii[] = {1e3, 1e9, 1e30, 1e100};
    for (size_t i = 0; i < sizeof radii / sizeof radii[0]; i++) {
        struct mean m = {0};
        floor_and_disk()->radius = radii[i];
        kit.lights[0].position = pen_vec3(3, 0, 4); /* the horizon halves so wide a disk */
        kit.settings.light_samples = 64;
        struct pen_scene *scene = kit_freeze(&kit);
        double lit = 4. / 5; /* the cosine */
        for (uint64_t seed = 0; seed < 200; seed++)
            mean_add(&m, pixel_with_seed(scene, seed).x / lit);
        pen_scene_free(scene);
        double h = -5 * lit / (radii[i] * 0.6); /* where the floor cuts the disk */
        /* An edge so near a diameter divides the net evenly, so its spread is no measure. */
        ck_assert_double_eq_tol(mean_of(&m), seen_past_edge(h), 2e-3);
    }
}
END_TEST

START_TEST(test_soft__h124_a_radius_beyond_numbers_is_refused)
{
    floor_and_disk()->radius = 1e100;
    kit_sphere(&kit, pen_vec3(0, 0, -1e-30), 1e-30, -1);
    kit.view.camera.position = pen_vec3(0, -6e-30, 3e-30);
    kit.lights[0].position = pen_vec3(0, 0, 1e-30);
    struct pen_status st = {0};
    ck_assert(pen_scene_freeze(&kit.desc, PEN_ACCEL_AUTO, 0, &st) == NULL);
    ck_assert_int_eq(st.code, PEN_INVALID);
    ck_assert_str_eq(st.at, "/lights/0/radius");
}
END_TEST

/* The samples depend on the direction of the scene; their mean must not. */
START_TEST(test_soft__h080_rotation)
{
    enum { ROTATIONS = 1000 };
    struct random random = random_begin(80);
    struct mean all = {0}, reference = {0};
    for (int i = -40; i < ROTATIONS; i++) {
        floor_and_disk();
        kit_sphere(&kit, pen_vec3(1.1, 0.2, 5), 0.5, -1);
        half_plane(-0.4, 2, -1);
        kit_sphere(&kit, pen_vec3(0.2, 0.5, 3), 0.25, -1);
        if (i >= 0)
            turn_scene(random_direction(&random), random_in(&random, 0, 360));
        kit.settings.light_samples = i < 0 ? 4096 : 32;
        struct pen_scene *scene = kit_freeze(&kit);
        mean_add(i < 0 ? &reference : &all, pixel_with_seed(scene, (uint64_t)(i + 1000)).x);
        pen_scene_free(scene);
    }
    double off = mean_of(&all) - mean_of(&reference);
    double sigma = hypot(mean_error(&all), mean_error(&reference));
    ck_assert_double_gt(mean_of(&all), 0.1);
    ck_assert_double_lt(mean_of(&all), 0.9);
    ck_assert_msg(fabs(off) < 5 * sigma, "seed %llu: mean %.6f, reference %.6f, 5 sigma %.2g",
                  (unsigned long long)random.seed, mean_of(&all), mean_of(&reference), 5 * sigma);
}
END_TEST

START_TEST(test_soft__h125_coloured_shadow)
{
    enum { WIDTH = 200 };
    struct pen_material glass = kit_matte(0);
    glass.kt = pen_vec3(1, 0, 0.5);
    floor_and_disk();
    kit.lights[0].radius = 0.25;
    kit_sphere(&kit, pen_vec3(0, 0, 4), 1, kit_material(&kit, glass));
    kit.settings.width = WIDTH;
    kit.settings.height = 1;
    kit.settings.light_samples = 64;
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = hypot(6, 3);
    kit.view.camera.plane_width = 12;
    kit.view.camera.plane_height = 1e-3;
    struct pen_scene *scene = kit_freeze(&kit);
    int inside = 0, rim = 0, outside = 0;
    for (int x = 0; x < WIDTH; x++) {
        struct pen_ray_counts rays;
        vec3 c = pixel_of(scene, x, 0, &rays);
        ck_assert_uint_eq(rays.shadow, 64);
        if (c.y == c.x) {
            outside++;
            ck_assert(c.z == c.x);
        } else if (c.y == 0) {
            inside++;
            ck_assert(c.z == 0.25 * c.x);
        } else {
            rim++;
            ck_assert_double_gt(c.z, 0.25 * c.x);
            ck_assert_double_lt(c.z, c.x);
            ck_assert_double_eq_tol(c.z, 0.25 * c.x + 0.75 * c.y, 1e-12);
        }
    }
    pen_scene_free(scene);
    ck_assert_int_gt(inside, 30);
    ck_assert_int_gt(outside, 60);
    ck_assert_int_gt(rim, 8);
}
END_TEST

START_TEST(test_soft__h117_light_at_the_point)
{
    for (int soft = 0; soft <= 1; soft++) {
        struct pen_ray_counts rays;
        floor_and_disk()->radius = soft;
        kit.lights[0].position = pen_vec3(0, 0, 0); /* on the surface, where it is seen */
        vec3 c = kit_pixel(&kit, 0, 0, &rays);
        ck_assert(c.x == 0 && c.y == 0 && c.z == 0);
        ck_assert_uint_eq(rays.shadow, 0);
        kit.lights[0].position = pen_vec3(0, 0, -1e-9); /* under the plane */
        ck_assert(kit_pixel(&kit, 0, 0, &rays).x == 0);
        ck_assert_uint_eq(rays.shadow, 0);
        floor_and_disk()->radius = 0.25 * soft; /* inside a sphere */
        kit_sphere(&kit, pen_vec3(0, 0, light_height), 0.5, -1);
        ck_assert(kit_pixel(&kit, 0, 0, &rays).x == 0);
        ck_assert_uint_gt(rays.shadow, 0);
    }
}
END_TEST

PEN_SUITE("soft", test_soft__h121_half_plane,
          test_soft__h121_converges_with_the_slope_of_its_pattern,
          test_soft__h122_umbra_of_a_sphere, test_soft__h123_frame_near_every_axis,
          test_soft__h123_penumbra_with_the_light_along_an_axis,
          test_soft__h124_radius_zero_is_a_hard_shadow, test_soft__h124_enormous_lights_stay_finite,
          test_soft__h124_a_radius_beyond_numbers_is_refused, test_soft__h080_rotation,
          test_soft__h125_coloured_shadow, test_soft__h117_light_at_the_point)
