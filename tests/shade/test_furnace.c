/* SPDX-License-Identifier: MIT */
/* H113: convex solids of clear glass in light that is everywhere the same. A pixel shows this
 * light, less the light that max_depth cuts off: the light that is still inside the glass. It has a
 * closed form for a ball. For a solid with flat faces it follows the exact ray. */
#include <math.h>

#include "shade/glass.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

enum { SIDE = 33 }; /* odd: the middle pixel looks exactly ahead */
static double film[SIDE * SIDE];

static void furnace_begin(int surfaces)
{
    glass_begin(&kit, surfaces);
    kit.desc.background = pen_vec3(1, 1, 1);
    kit.settings.width = kit.settings.height = SIDE;
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = 10;
    kit.view.camera.plane_width = kit.view.camera.plane_height = 3.3;
}

/* The direction of a pixel's ray, for the camera that looks along -z. */
static vec3 pixel_direction(int x, int y)
{
    const double step = 3.3 / SIDE;
    return pen_vec3((x - SIDE / 2) * step, (SIDE / 2 - y) * step, -10);
}

/* Renders the film. No path may leave a solid that it has not entered. */
static void furnace_render(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_ray_counts counts;
    struct pen_status st;
    double rgb[3];
    for (int i = 0; i < SIDE * SIDE; i++) {
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, i % SIDE, i / SIDE, rgb, &counts, &st));
        ck_assert_msg(counts.unmatched_exits == 0, "pixel %d, %d", i % SIDE, i / SIDE);
        ck_assert_uint_eq(counts.dropped_samples + counts.truncated_paths, 0);
        ck_assert_double_eq(rgb[0], rgb[2]);
        film[i] = rgb[0];
    }
    pen_scene_free(scene);
}

/* What is left inside a ball after some surfaces; negative for a ray near its rim, or past it. */
static quad ball_left(vec3 d, double radius, double ior, int surfaces)
{
    quad t[2] = {0, 0};
    const vec3 eye = kit.view.camera.position;
    const struct quad_ray ray = {quad3(eye), quad_unit(quad3(d))};
    const quad square = quad_dot(ray.o, ray.o) - (quad)radius * radius;
    if (!(quad_roots(1, quad_dot(ray.o, ray.d), square, t) >= (quad)1e-3))
        return -1;
    const struct quad3 n = quad_unit(quad_along(ray.o, ray.d, t[0]));
    const quad share = quad_refract(n, ray.d, 1, ior).share;
    quad left = surfaces > 1 ? 1 - share : 1;
    for (int i = 2; i < surfaces; i++)
        left *= share;
    return left;
}

START_TEST(test_furnace__h113_ball)
{
    for (int surfaces = 1; surfaces <= 11; surfaces += random_stride()) {
        const double ior = 1.2 + 0.1 * surfaces;
        int inside = 0;
        furnace_begin(surfaces);
        kit_sphere(&kit, pen_vec3(0, 0, 0), 1.3, glass_material(&kit, ior));
        furnace_render();
        for (int i = 0; i < SIDE * SIDE; i++) {
            const quad left = ball_left(pixel_direction(i % SIDE, i / SIDE), 1.3, ior, surfaces);
            inside += left >= 0;
            ck_assert_msg(left < 0 || fabs(film[i] - (double)(1 - left)) <= 1e-13,
                          "pixel %d, %d: %.17g", i % SIDE, i / SIDE, film[i]);
        }
        ck_assert_int_gt(inside, SIDE * SIDE / 3);
    }
}
END_TEST

enum shape {
    BALL,
    CYLINDER,
    FRUSTUM,
    CONE,
    HEAD_ON,
    DIAGONAL,
    TIP_ON,
    ANY_CUBE,
    TETRAHEDRON,
    TRIANGLES,
    SHAPES
};

static void add_cone(double top, int material)
{
    struct pen_object_desc *o =
        kit_cylinder(&kit, pen_vec3(0, -1, 0), pen_vec3(0.1, 1, 0.3), 1, 2, material);
    o->kind = PEN_OBJECT_CONE;
    o->u.cone.caps = true;
    o->u.cone.base = pen_vec3(0, -1, 0);
    o->u.cone.axis = pen_vec3(0.1, 1, 0.3);
    o->u.cone.radius = 1.1;
    o->u.cone.top_radius = top;
    o->u.cone.height = 2;
}

/* A cube that is seen from its front; over an edge, along which the middle column looks; over a
 * corner, at which the middle pixel looks; from anywhere. */
static void add_cube(enum shape shape, int material, struct convex *truth)
{
    const double s = sqrt(0.5), t = sqrt(1 / 3.), w = sqrt(1 / 6.);
    struct random r = random_begin(521);
    vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (shape == DIAGONAL) {
        axis[0] = pen_vec3(s, 0, s);
        axis[2] = pen_vec3(-s, 0, s);
    } else if (shape == TIP_ON) {
        axis[0] = pen_vec3(2 * w, 0, t);
        axis[1] = pen_vec3(-w, s, t);
        axis[2] = pen_vec3(-w, -s, t);
    } else if (shape == ANY_CUBE) {
        glass_axes(&r, axis);
    }
    for (int i = 0; i < 3; i++)
        axis[i] = pen_scale(axis[i], 0.8);
    glass_box(&kit, pen_vec3(0, 0, 0), axis, material, truth);
}

static void add_tetrahedron(int material, struct convex *truth)
{
    static const int faces[] = {0, 1, 2, -1, 0, 3, 1, -1, 1, 3, 2, -1, 2, 3, 0, -1, -1};
    const vec3 v[] = {{1, 1, 1.01}, {-1.1, -1.05, 0.99}, {-1, 1, -1}, {1.1, -1, -1}};
    glass_solid(&kit, v, faces, pen_vec3(0, 0, 0), material, truth);
}

/* The cube that is seen from its front, of twelve triangles. */
static void add_triangles(int material, struct convex *truth)
{
    static const int faces[] = {0, 1,  3,  -1, 0, 3,  2,  -1, 4, 6,  7,  -1, 4, 7,  5,  -1, 0,
                                4, 5,  -1, 0,  5, 1,  -1, 2,  3, 7,  -1, 2,  7, 6,  -1, 0,  2,
                                6, -1, 0,  6,  4, -1, 1,  5,  7, -1, 1,  7,  3, -1, -1};
    vec3 v[8];
    for (int i = 0; i < 8; i++)
        v[i] = pen_vec3(i & 1 ? 0.8 : -0.8, i & 2 ? 0.8 : -0.8, i & 4 ? 0.8 : -0.8);
    add_cube(HEAD_ON, material, truth);
    kit.desc.object_count = kit.vertex_count = 0;
    kit.desc.primitive_count = 0;
    glass_solid(&kit, v, faces, pen_vec3(0, 0, 0), material, NULL);
}

static void add_shape(enum shape shape, double ior, struct convex *truth)
{
    const int m = glass_material(&kit, ior);
    if (shape == BALL)
        kit_sphere(&kit, pen_vec3(0, 0, 0), 1.3, m);
    else if (shape == CYLINDER)
        kit_cylinder(&kit, pen_vec3(-0.2, -1, 0), pen_vec3(0.3, 1, 0.5), 0.8, 2, m);
    else if (shape == FRUSTUM || shape == CONE)
        add_cone(shape == CONE ? 0 : 0.4, m);
    else if (shape == TETRAHEDRON)
        add_tetrahedron(m, truth);
    else if (shape == TRIANGLES)
        add_triangles(m, truth);
    else
        add_cube(shape, m, truth);
}

START_TEST(test_furnace__h113_flat_faces)
{
    for (int shape = HEAD_ON; shape < SHAPES; shape++) {
        int inside = 0;
        for (int surfaces = 1; surfaces <= 11; surfaces += 2 * random_stride()) {
            struct convex solid = {.count = 0};
            furnace_begin(surfaces);
            const double ior = 1.3 + 0.05 * surfaces;
            add_shape((enum shape)shape, ior, &solid);
            furnace_render();
            for (int i = 0; i < SIDE * SIDE; i++) {
                bool sure = true;
                const struct quad_ray ray = {quad3(kit.view.camera.position),
                                             quad_unit(quad3(pixel_direction(i % SIDE, i / SIDE)))};
                const quad left = convex_left(&solid, ray, ior, surfaces, &sure);
                inside += sure;
                ck_assert_msg(!sure || fabs(film[i] - (double)(1 - left)) <= 1e-12,
                              "shape %d, %d surfaces, pixel %d, %d: %.17g, want %.17g", shape,
                              surfaces, i % SIDE, i / SIDE, film[i], (double)(1 - left));
            }
        }
        ck_assert_int_gt(inside, SIDE * SIDE / random_stride());
    }
}
END_TEST

/* The lengths of paths that are compared: from 2 to 11, and 2000. */
static int next_length(int surfaces)
{
    if (surfaces >= 11)
        return surfaces < 2000 ? 2000 : 2001;
    return surfaces + random_fewer() < 11 ? surfaces + random_fewer() : 11;
}

/* Deeper paths lack less, and nothing shows more than there is. Edges and corners do not matter:
 * every pixel goes to 1. */
START_TEST(test_furnace__h113_deeper_paths_lack_less)
{
    static double last[SIDE * SIDE];
    for (int shape = 0; shape < SHAPES; shape++) {
        int trapped = 0;
        for (int surfaces = 2; surfaces <= 2000; surfaces = next_length(surfaces)) {
            struct convex unused;
            furnace_begin(surfaces);
            add_shape((enum shape)shape, 1.5, &unused);
            furnace_render();
            for (int i = 0; i < SIDE * SIDE; i++) {
                ck_assert_msg(film[i] <= 1 + 1e-13, "shape %d, pixel %d: %.17g", shape, i, film[i]);
                ck_assert_msg(surfaces == 2 || film[i] >= last[i] - 1e-13, "shape %d, pixel %d",
                              shape, i);
                last[i] = film[i];
            }
        }
        for (int i = 0; i < SIDE * SIDE; i++)
            trapped += film[i] < 1 - 1e-9;
        ck_assert_int_eq(trapped, 0);
    }
}
END_TEST

/* By how much a number is outside the range of two others. */
static double beyond(double x, double a, double b)
{
    return fmax(0, fmax(x - fmax(a, b), fmin(a, b) - x));
}

/* There are no seams: no pixel is brighter or darker than those on both sides of it. Paths
 * of two surfaces lack what goes through the first: slowly changing on
 * flat faces, while at the rim of round ones it has a peak along the rim. */
START_TEST(test_furnace__h113_no_seams)
{
    for (int shape = 0; shape < SHAPES; shape++) {
        struct convex unused;
        furnace_begin(2);
        add_shape((enum shape)shape, 1.5, &unused);
        furnace_render();
        for (int y = 1; y < SIDE - 1; y++) {
            for (int x = 1; x < SIDE - 1; x++) {
                const double *at = &film[y * SIDE + x];
                const double row = beyond(at[0], at[1], at[-1]);
                const double column = beyond(at[0], at[SIDE], at[-SIDE]);
                if (fmax(fmax(at[1], at[-1]), fmax(at[SIDE], at[-SIDE])) == 1)
                    continue; /* beside the shape */
                const double most = shape < HEAD_ON ? fmin(row, column) : fmax(row, column);
                ck_assert_msg(most <= 0.01, "shape %d, pixel %d, %d: %g", shape, x, y, most);
            }
        }
    }
}
END_TEST

/* Looks from anywhere at an edge or a corner of a cube, exactly or within rounding. */
static void look_at_edge(struct random *r, int i)
{
    vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (i & 1)
        glass_axes(r, axis);
    const vec3 edge = pen_add(axis[0], axis[1]);
    const vec3 at = pen_along(edge, axis[2], i & 2 ? 1 : random_in(r, -1, 1));
    const vec3 eye = pen_scale(random_direction(r), i & 4 ? 50 : 3);
    furnace_begin(300);
    kit.settings.width = kit.settings.height = 1;
    glass_box(&kit, pen_vec3(0, 0, 0), axis, glass_material(&kit, random_in(r, 1.02, 2.5)), NULL);
    glass_look(&kit, eye, pen_sub(at, eye));
}

/* No ray is caught in a cube by meeting its edge. A ray that grazes takes many surfaces to leave
 * it: after k of them at most 1 / k is still inside. */
START_TEST(test_furnace__h113_rays_at_edges)
{
    struct random r = random_begin(522);
    for (int i = 0; i < random_cases(20000); i++) {
        struct pen_ray_counts counts;
        look_at_edge(&r, i);
        const vec3 c = kit_pixel(&kit, 0, 0, &counts);
        ck_assert_msg(c.x <= 1 + 1e-13 && c.x >= 0.99, "case %d: %.17g", i, c.x);
    }
}
END_TEST

PEN_SUITE("furnace", test_furnace__h113_ball, test_furnace__h113_flat_faces,
          test_furnace__h113_deeper_paths_lack_less, test_furnace__h113_no_seams,
          test_furnace__h113_rays_at_edges)
