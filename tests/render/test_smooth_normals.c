/* SPDX-License-Identifier: MIT */
/* Smooth normals of meshes, by their definition in src/shade/README.md: the radiance of a
 * tessellated sphere, computed here in long double from the triangles; which lights count; and what
 * has no consequence. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/isa.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/scene_files.h"
#include "support/suite.h"

enum {
    STACKS = 12,
    SLICES = 20,
    VERTICES = (STACKS + 1) * SLICES,
    TRIANGLES = 2 * STACKS * SLICES
};
enum { SIDE = 48 };

static struct kit kit;
static float vertex[3 * VERTICES], normal[3 * VERTICES];
static uint32_t corner[3 * TRIANGLES], corner_normal[3 * TRIANGLES];
static struct pen_mesh_desc ball;

static void add_triangle(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *to = corner + 3 * ball.triangle_count++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

/* A sphere of radius 2 with its own normals, of lengths from 1 to 2. Its triangles are those of a
 * coarse net. */
static void make_ball(void)
{
    ball = (struct pen_mesh_desc){.vertex = vertex,
                                  .vertex_count = VERTICES,
                                  .corner = corner,
                                  .normal = normal,
                                  .normal_count = VERTICES};
    for (uint32_t i = 0; i < VERTICES; i++) {
        const double theta = acos(-1) * (i / SLICES) / STACKS,
                     phi = 2 * acos(-1) * (i % SLICES) / SLICES;
        const double n[3] = {sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)};
        for (uint32_t k = 0; k < 3; k++) {
            vertex[3 * i + k] = (float)(2 * n[k]);
            normal[3 * i + k] = (float)((1 + i % 5 / 4.0) * n[k]);
        }
    }
    for (uint32_t i = 0; i < STACKS; i++) {
        for (uint32_t j = 0; j < SLICES; j++) {
            const uint32_t a = i * SLICES + j, b = i * SLICES + (j + 1) % SLICES;
            if (i < STACKS - 1)
                add_triangle(a, b + SLICES, a + SLICES);
            if (i > 0)
                add_triangle(a, b, b + SLICES);
        }
    }
}

/* A view of the ball under a point light that casts no shadow. */
static void ball_scene(void)
{
    make_ball();
    kit_init(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.view.camera.fov_degrees = 26;
    struct pen_material m = kit_matte(0.7);
    m.kd = pen_vec3(0.7, 0.5, 0.3);
    m.ks = pen_vec3(0.3, 0.4, 0.5);
    m.shininess = 15;
    kit_mesh(&kit, &ball, kit_material(&kit, m));
    kit_point(&kit, pen_vec3(5, 6, 8), pen_vec3(1, 1, 1))->shadows = false;
}

/* ---- the oracle, in long double ---- */

struct real3 {
    long double x, y, z;
};

static struct real3 minus(struct real3 a, struct real3 b)
{
    return (struct real3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static struct real3 along(struct real3 a, struct real3 d, long double t)
{
    return (struct real3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}

static long double dot(struct real3 a, struct real3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct real3 cross(struct real3 a, struct real3 b)
{
    return (struct real3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static struct real3 unit(struct real3 a)
{
    return along((struct real3){0, 0, 0}, a, 1 / sqrtl(dot(a, a)));
}

static struct real3 real_of(struct pen_vec3 a)
{
    return (struct real3){a.x, a.y, a.z};
}

static struct real3 at(const float *array, uint32_t i)
{
    return (struct real3){array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}

struct seen {
    long double t, inside; /* inside: the least barycentric coordinate */
    struct real3 p, geometric, shading;
};

/* The nearest triangle of the ball that the ray meets, with both normals on the viewer's side. */
static bool see(struct real3 o, struct real3 d, struct seen *out)
{
    out->t = INFINITY;
    for (uint32_t i = 0; i < 3 * ball.triangle_count; i += 3) {
        const struct real3 a = at(vertex, corner[i]), e = minus(at(vertex, corner[i + 1]), a),
                           f = minus(at(vertex, corner[i + 2]), a), g = cross(e, f);
        const long double gd = dot(g, d), t = dot(g, minus(a, o)) / gd, side = gd < 0 ? 1 : -1;
        const struct real3 p = along(o, d, t), q = minus(p, a);
        const long double u = dot(cross(q, f), g) / dot(g, g), v = dot(cross(e, q), g) / dot(g, g);
        const long double least = fminl(fminl(u, v), 1 - u - v);
        if (least < 0 || t >= out->t)
            continue;
        const struct real3 n[3] = {unit(at(normal, corner[i])), unit(at(normal, corner[i + 1])),
                                   unit(at(normal, corner[i + 2]))};
        struct real3 mix = along((struct real3){0, 0, 0}, n[0], 1 - u - v);
        mix = along(along(mix, n[1], u), n[2], v);
        *out = (struct seen){t, least, p, unit(along((struct real3){0, 0, 0}, g, side)), unit(mix)};
        if (dot(out->shading, out->geometric) < 0)
            out->shading = minus((struct real3){0, 0, 0}, out->shading);
    }
    return out->t < INFINITY;
}

/* The radiance that the light brings, in one channel; the least cosine between the light and a
 * normal in *cosine. */
static long double reflected(const struct seen *s, struct real3 d, double kd, double ks,
                             double shininess, long double *cosine)
{
    const struct real3 l = unit(minus(s->p, real_of(kit.lights[0].position))), v = unit(d);
    const long double nl = dot(s->shading, l);
    *cosine = fminl(-dot(s->geometric, l), -nl);
    if (*cosine <= 0)
        return 0;
    const struct real3 r = along(l, s->shading, -2 * nl);
    const long double mirror = -dot(v, r);
    return kd * -nl + ks * (mirror > 0 ? powl(mirror, shininess) : 0);
}

/* Numbers of a picture: compared channels, lit and black ones, and lit ones with a highlight where
 * the shading normal points away from the viewer. */
struct tally {
    int compared, lit, dark, away;
};

/* Compares the picture with the formula, and its diffuse part with that of the sphere itself. */
static struct tally compare_ball(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    const struct pen_pinhole pinhole = pen_scene_pinhole(scene, 0, SIDE, SIDE);
    const struct pen_material *m = &kit.materials[0];
    const long double unit_length = ldexpl(1, scene->exponent);
    const struct real3 eye = along(real_of(scene->center), real_of(pinhole.eye), unit_length);
    struct tally tally = {0};
    for (int i = 0; i < SIDE * SIDE; i++) {
        const struct real3 d = along(along(real_of(pinhole.middle), real_of(pinhole.dx),
                                           (i % SIDE + 0.5L) - pinhole.half_width),
                                     real_of(pinhole.dy), (i / SIDE + 0.5L) - pinhole.half_height);
        struct seen s;
        long double cosine;
        if (!see(eye, d, &s) || s.inside < 1e-9)
            continue;
        double rgb[3];
        struct pen_ray_counts rays;
        struct pen_status st;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, i % SIDE, i / SIDE, rgb, &rays, &st));
        for (int k = 0; k < 3; k++) {
            const double kd = pen_component(m->kd, k), ks = pen_component(m->ks, k);
            const long double want = reflected(&s, d, kd, ks, m->shininess, &cosine);
            if (fabsl(cosine) < 1e-6)
                continue;
            ck_assert_msg(fabsl(rgb[k] - want) < 1e-11, "pixel %d: %.17g, not %.17Lg", i, rgb[k],
                          want);
            tally.compared++;
            tally.lit += want > 0.1;
            tally.dark += want == 0;
            tally.away += dot(s.shading, d) > 0 && want > kd * cosine + 0.01;
        }
        struct seen round = s;
        round.shading = round.geometric = unit(s.p);
        const long double sphere = reflected(&round, d, 1, 0, 1, &cosine);
        const double diffuse = (rgb[0] / 0.3 - rgb[1] / 0.4) / (0.7 / 0.3 - 0.5 / 0.4);
        if (cosine > 0.2)
            ck_assert_msg(fabsl(diffuse - sphere) < 0.005, "pixel %d: %g, not %Lg", i, diffuse,
                          sphere);
    }
    pen_scene_free(scene);
    return tally;
}

START_TEST(test_smooth_normals__are_the_mix_at_the_point)
{
    ball_scene();
    const struct tally whole = compare_ball();
    ck_assert_int_gt(whole.compared, 3000);
    ck_assert_int_gt(whole.lit, 1500);
    ck_assert_int_gt(whole.dark, 100);
    /* A part of the outline, with light from behind. */
    ball_scene();
    kit.view.camera.position = pen_vec3(1.564, 0, 9.877);
    kit.view.camera.direction = pen_vec3(0.434, 0, -9.79);
    kit.view.camera.fov_degrees = 2;
    kit.lights[0].position = pen_vec3(5, 2, -4);
    kit.materials[0].shininess = 2;
    const struct tally outline = compare_ball();
    ck_assert_int_gt(outline.compared, 1000);
    ck_assert_int_gt(outline.away, 100);
}
END_TEST

/* ---- lights and normals of one triangle ---- */

static const float triangle_vertex[] = {-4, -3, 0, 4, -3, 0, 0, 5, 0};
static const uint32_t triangle_corner[] = {0, 1, 2};
static float triangle_normal[9];

/* The radiance at the middle of a triangle in the plane z = 0 whose normals are n. The light comes
 * from `to_light`. */
static struct pen_vec3 triangle(struct pen_vec3 n, struct pen_vec3 to_light, bool point)
{
    const struct pen_mesh_desc mesh = {.vertex = triangle_vertex,
                                       .vertex_count = 3,
                                       .corner = triangle_corner,
                                       .triangle_count = 1,
                                       .normal = triangle_normal,
                                       .normal_count = 3};
    for (int i = 0; i < 9; i += 3) {
        triangle_normal[i] = (float)n.x;
        triangle_normal[i + 1] = (float)n.y;
        triangle_normal[i + 2] = (float)n.z;
    }
    kit_init(&kit);
    struct pen_material m = kit_matte(0.5);
    m.ks = pen_vec3(0.5, 0.5, 0.5);
    m.shininess = 0; /* the whole highlight, as far as it goes */
    kit_mesh(&kit, &mesh, kit_material(&kit, m));
    if (point)
        kit_point(&kit, pen_scale(to_light, 10), pen_vec3(1, 1, 1));
    else
        kit_directional(&kit, pen_neg(to_light), pen_vec3(1, 1, 1));
    return kit_pixel(&kit, 0, 0, NULL);
}

/* The direction with this elevation over the x axis, in degrees. */
static struct pen_vec3 elevated(double degrees)
{
    const double radians = degrees * acos(-1) / 180;
    return pen_vec3(cos(radians), 0, sin(radians));
}

START_TEST(test_smooth_normals__light_is_above_both)
{
    for (int point = 0; point < 2; point++) {
        for (int elevation = -85; elevation < 270; elevation += 15) {
            for (int tilt = 10; tilt < 180; tilt += 17) {
                const struct pen_vec3 n = elevated(tilt), l = elevated(elevation + 0.5);
                const double nl = pen_dot(n, l);
                const struct pen_vec3 got = triangle(n, l, point);
                const bool above = l.z > 0 && nl > 0;
                ck_assert_msg(above == (got.x > 0), "light at %d, normal at %d: %g", elevation,
                              tilt, got.x);
                if (above && 2 * nl * n.z - l.z <= 0) /* no highlight */
                    ck_assert_msg(fabs(got.x - 0.5 * nl) < 1e-6, "light at %d, normal at %d: %g",
                                  elevation, tilt, got.x);
                if (above && 2 * nl * n.z - l.z > 0)
                    ck_assert_msg(fabs(got.x - 0.5 * nl - 0.5) < 1e-6, "with highlight: %g", got.x);
                /* The sign does not matter. */
                const struct pen_vec3 opposite = triangle(pen_neg(n), l, point);
                ck_assert(opposite.x == got.x);
            }
        }
    }
}
END_TEST

START_TEST(test_smooth_normals__that_tell_nothing_leave_the_triangle_flat)
{
    static const struct pen_vec3 none[] = {{0, 0, 0}, {1, 0, 0}, {0, -3e20, 0}};
    static const uint32_t missing[] = {0, PEN_NO_NORMAL, 2};
    const struct pen_vec3 l = elevated(40), flat = triangle(pen_vec3(0, 0, 1), l, false);
    ck_assert(flat.x > 0.8);
    for (int i = 0; i < 3; i++)
        ck_assert(triangle(none[i], l, false).x == flat.x);
    ck_assert(triangle(pen_vec3(0, 0, 1e-30), l, false).x == flat.x);
    ck_assert(triangle(pen_vec3(1, 0, 1), l, false).x != flat.x);
    kit.meshes[0].corner_normal = missing;
    ck_assert(kit_pixel(&kit, 0, 0, NULL).x == flat.x);
    kit.meshes[0].corner_normal = triangle_corner;
    triangle_normal[0] = triangle_normal[2] = 0;
    ck_assert(kit_pixel(&kit, 0, 0, NULL).x == flat.x);
}
END_TEST

/* ---- bits ---- */

static float *film_of(int threads)
{
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, threads);
    pen_scene_free(scene);
    return film;
}

static void same(const float *a, const float *b)
{
    const size_t pixels = (size_t)(kit.settings.width * kit.settings.height);
    ck_assert_mem_eq(a, b, 3 * pixels * sizeof *a);
}

START_TEST(test_smooth_normals__bits_do_not_depend_on_how)
{
    ball_scene();
    kit_smooth(&kit, pen_vec3(1, 1, 3), 0);
    kit_sphere(&kit, pen_vec3(-1, -1, 2), 0.5, 0);
    kit.lights[0].shadows = true;
    kit_directional(&kit, pen_vec3(1, -0.5, -1), pen_vec3(0.5, 0.5, 0.5))->angular_radius = 3;
    kit.settings.light_samples = 4;
    kit.settings.samples_per_pixel = 2;
    kit.settings.width = kit.settings.height = 18;
    float *want = film_of(1);
    for (int accelerator = 0; accelerator < PEN_ACCEL_COUNT; accelerator++) {
        kit.settings.accelerator = accelerator;
        float *film = film_of(3);
        same(film, want);
        free(film);
    }
    /* Numbers by corner that are those of the vertices. */
    kit.meshes[0].corner_normal = corner;
    float *film = film_of(2);
    same(film, want);
    free(film);
    /* Normals in another order. */
    static float reversed[3 * VERTICES];
    for (uint32_t i = 0; i < VERTICES; i++)
        memcpy(reversed + 3 * i, normal + 3 * (VERTICES - 1 - i), 3 * sizeof *normal);
    for (uint32_t i = 0; i < 3 * ball.triangle_count; i++)
        corner_normal[i] = VERTICES - 1 - corner[i];
    kit.meshes[0].corner_normal = corner_normal;
    kit.meshes[0].normal = reversed;
    film = film_of(2);
    same(film, want);
    free(film);
    free(want);
}
END_TEST

/* A frame by blocks, by pixels, and of every instruction set, in every kernel that has the effect.
 */
START_TEST(test_smooth_normals__bits_are_those_of_every_kernel)
{
    ball_scene();
    kit_sphere(&kit, pen_vec3(-1, -1, 2), 0.5, 0);
    kit.lights[0].shadows = true;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_kernel_input input = frame_input(scene, 0, &kit.settings, PEN_ISA_BASE);
    const struct pen_kernel *kernel = pen_kernel_select(input.effects, PEN_ISA_BASE);
    struct pen_ray_counts want_rays, rays;
    ck_assert_str_eq(kernel->name, "hard+smooth+normals/base");
    double *want = frame_by_pixels(kernel, &input, &want_rays);
    int compared = 0;
    for (int isa = 0; isa < isa_count(); isa++) {
        input.trace = pen_trace_ops_get((enum pen_isa)isa);
        for (int i = 0; (kernel = pen_kernel_at(i, (enum pen_isa)isa)) != NULL; i++) {
            if (input.effects & ~kernel->effects)
                continue;
            double *got = frame_by_blocks(kernel, &input, &rays);
            ck_assert_msg(memcmp(got, want, 3 * SIDE * SIDE * sizeof *got) == 0, "%s",
                          kernel->name);
            ck_assert_mem_eq(&rays, &want_rays, sizeof rays);
            free(got);
            compared++;
        }
    }
    ck_assert_int_eq(compared, 2 * isa_count());
    free(want);
    pen_scene_free(scene);
}
END_TEST

/* ---- transforms ---- */

/* A normal stays perpendicular to what it was perpendicular to, at its own corner. */
START_TEST(test_smooth_normals__follow_transforms)
{
    struct random random = random_begin(54);
    for (int i = 0; i < 40; i++) {
        struct pen_transform f = pen_transform_identity();
        for (int k = 0; k < 9; k++)
            f.m[k / 3][k % 3] += random_in(&random, -1.5, 1.5);
        if (!pen_transform_invertible(&f))
            continue;
        ball_scene();
        if (i % 2) {
            memcpy(corner_normal, corner, sizeof corner);
            kit.meshes[0].corner_normal = corner_normal;
        }
        kit_group(&kit, 0, &f);
        struct pen_scene *scene = kit_freeze(&kit);
        const struct pen_mesh *mesh = &scene->prims.mesh[0];
        ck_assert_int_eq(mesh->corner_normal != NULL, i % 2);
        for (uint32_t c = 0; c < 3 * mesh->count; c++) {
            const bool mirrored = pen_transform_orientation(&f) < 0;
            const uint32_t from = mirrored ? c / 3 * 3 + 2 - c % 3 : c;
            const float *n = mesh->normal + 3 * (size_t)(mesh->corner_normal ? mesh->corner_normal
                                                                             : mesh->corner)[c];
            const struct pen_vec3 moved = pen_vec3((double)n[0], (double)n[1], (double)n[2]);
            const struct real3 own = at(normal, corner[from]);
            const struct real3 other = {0.3L, -0.5L, 0.8L}, across = cross(own, other),
                               second = cross(own, across);
            const struct pen_vec3 u = pen_transform_vector(&f, pen_vec3((double)across.x,
                                                                        (double)across.y,
                                                                        (double)across.z)),
                                  v = pen_transform_vector(&f, pen_vec3((double)second.x,
                                                                        (double)second.y,
                                                                        (double)second.z));
            ck_assert(fabs(pen_length(moved) - 1) < 1e-6);
            ck_assert(fabs(pen_dot(moved, u)) < 1e-6 * pen_length(u));
            ck_assert(fabs(pen_dot(moved, v)) < 1e-6 * pen_length(v));
        }
        pen_scene_free(scene);
    }
}
END_TEST

/* A scale by a power of two keeps the file's normals. */
START_TEST(test_smooth_normals__are_not_copied_without_need)
{
    const struct pen_transform twice =
        pen_transform_make(2, pen_vec3(0, 1, 0), 0, pen_vec3(1, 2, 3));
    ball_scene();
    kit_group(&kit, 0, &twice);
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_ptr_eq(scene->prims.mesh[0].normal, normal);
    ck_assert_ptr_eq(scene->prims.mesh[0].corner, corner);
    pen_scene_free(scene);
}
END_TEST

PEN_SUITE("smooth_normals", test_smooth_normals__are_the_mix_at_the_point,
          test_smooth_normals__light_is_above_both,
          test_smooth_normals__that_tell_nothing_leave_the_triangle_flat,
          test_smooth_normals__bits_do_not_depend_on_how,
          test_smooth_normals__bits_are_those_of_every_kernel,
          test_smooth_normals__follow_transforms, test_smooth_normals__are_not_copied_without_need)
