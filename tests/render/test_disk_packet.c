/* SPDX-License-Identifier: MIT */
/* Disk packets give the same bits as single shadow rays. Soft lights are rendered with a tree,
 * which traces packets, and without a tree, which traces single rays. Pixels and ray counts must be
 * equal. The random scenes are hard on purpose. Most coordinates are small integers, so lights are
 * in planes, on axes and at centres; primitives touch and coincide; points are on edges of other
 * primitives. */
#include <stdlib.h>
#include <string.h>

#include "support/isa.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* A coordinate in [-half, half]: usually an integer, in one case of eight any number near it. */
static double coordinate(struct random *r, int half)
{
    double whole = (double)random_below(r, (uint32_t)(2 * half + 1)) - half;
    return random_below(r, 8) ? whole : whole + random_in(r, -0.5, 0.5);
}

static vec3 point(struct random *r, int half)
{
    double x = coordinate(r, half), y = coordinate(r, half);
    return pen_vec3(x, y, coordinate(r, half));
}

static vec3 direction(struct random *r)
{
    for (;;) {
        vec3 v = random_below(r, 2) ? point(r, 1) : random_direction(r);
        if (pen_norm1(v) > 0)
            return v;
    }
}

static int material(struct random *r)
{
    struct pen_material m = kit_matte(0.5);
    if (random_below(r, 3) == 0)
        m.kt = pen_vec3(0.5 * random_below(r, 2), 0.75, 0.3);
    if (random_below(r, 5) == 0)
        m.kr = pen_vec3(0.5, 0.25, 0);
    return kit_material(&kit, m);
}

/* A triangle, a parallelogram, or a pentagon, which may be concave. */
static void add_flat(struct random *r)
{
    vec3 p = point(r, 4), a = direction(r), b = direction(r);
    double size = 1 + random_below(r, 4);
    if (pen_norm1(pen_cross(a, b)) < 0.1)
        return;
    a = pen_scale(a, size);
    b = pen_scale(b, size);
    vec3 v[5] = {p, pen_add(p, a), pen_add(pen_add(p, a), b), pen_add(p, b), p};
    uint32_t count = 3 + random_below(r, 3);
    if (count == 5) /* the last corner: outside the middle of an edge, on it, or inside */
        v[4] = pen_along(pen_along(p, b, 0.5), a, 0.25 * (random_below(r, 3) - 1.));
    kit_polygon(&kit, v, count, material(r));
}

/* A polygon in the shape of a comb, with many concave corners. */
static void add_comb(struct random *r)
{
    vec3 v[24], p = point(r, 4), a = pen_scale(direction(r), 4), b = pen_scale(direction(r), 3);
    uint32_t teeth = 3 + random_below(r, 19);
    if (pen_norm1(pen_cross(a, b)) < 1)
        return;
    v[0] = p;
    v[1] = pen_add(p, a);
    for (uint32_t i = 0; i <= teeth; i++)
        v[2 + i] = pen_along(pen_along(p, a, 1 - (double)i / teeth), b, i % 2 ? 0.25 : 1);
    kit_polygon(&kit, v, teeth + 3, material(r));
}

static void add_primitive(struct random *r)
{
    switch (random_below(r, 9)) {
    case 8:
        add_comb(r);
        break;
    case 0:
    case 1:
        kit_sphere(&kit, point(r, 4), 0.5 * (1 + random_below(r, 4)), material(r));
        break;
    case 2:
    case 3:
        kit_cylinder(&kit, point(r, 4), direction(r), 0.5 * (1 + random_below(r, 3)),
                     1 + random_below(r, 4), material(r))
            ->u.cylinder.caps = random_below(r, 3);
        break;
    case 4:
        if (random_below(r, 4) == 0)
            kit_plane(&kit, point(r, 5), direction(r), material(r));
        else if (random_below(r, 8) == 0)
            kit_tube(&kit, point(r, 5), direction(r), 0.5, material(r));
        break;
    default:
        add_flat(r);
    }
}

/* A light's position: anywhere, or exactly at the centre of a primitive. */
static vec3 light_position(struct random *r)
{
    const struct pen_object_desc *o = &kit.objects[random_below(r, kit.desc.object_count)];
    if (random_below(r, 2) && o->kind == PEN_OBJECT_SPHERE)
        return o->u.sphere.center;
    if (random_below(r, 4) && o->kind == PEN_OBJECT_CYLINDER)
        return pen_along(o->u.cylinder.base, pen_normalize(o->u.cylinder.axis),
                         0.5 * o->u.cylinder.height);
    return point(r, 5);
}

static void add_light(struct random *r)
{
    struct pen_light_desc *light;
    if (random_below(r, 3))
        light = kit_point(&kit, light_position(r), pen_vec3(1, 1, 1));
    else
        light = kit_directional(&kit, direction(r), pen_vec3(1, 1, 1));
    light->radius = random_below(r, 4) ? 0.25 * (1 + random_below(r, 6)) : 1e-3;
    light->angular_radius = random_in(r, 0.1, 30);
}

static void any_scene(struct random *r)
{
    kit_init(&kit);
    kit.settings.width = 20;
    kit.settings.height = 15;
    kit.settings.light_samples = 1 + (int)random_below(r, 90);
    kit.settings.light_pattern = (int)random_below(r, 3);
    kit.settings.max_depth = 3;
    kit.view.camera.position = pen_vec3(coordinate(r, 3), coordinate(r, 3), 12);
    kit_sphere(&kit, point(r, 4), 1, material(r));
    for (uint32_t i = 0, primitives = 2 + random_below(r, 30); i < primitives; i++)
        add_primitive(r);
    for (uint32_t i = 0, lights = 1 + random_below(r, 3); i < lights; i++)
        add_light(r);
}

struct film {
    double rgb[20 * 15][3];
    struct pen_ray_counts rays;
};

static void render(struct film *film, enum pen_accelerator accelerator)
{
    struct pen_status st;
    struct pen_ray_counts rays;
    kit.settings.accelerator = (int)accelerator;
    struct pen_scene *scene = kit_freeze(&kit);
    film->rays = (struct pen_ray_counts){0};
    for (int i = 0; i < 20 * 15; i++) {
        ck_assert(
            pen_render_pixel(scene, 0, &kit.settings, i % 20, i / 20, film->rgb[i], &rays, &st));
        film->rays.shadow += rays.shadow;
        film->rays.transmission += rays.transmission;
        film->rays.reflection += rays.reflection;
    }
    pen_scene_free(scene);
}

static void compare(const struct film *want, const struct film *got, const char *what,
                    unsigned long long state)
{
    for (int i = 0; i < 20 * 15; i++) {
        if (memcmp(want->rgb[i], got->rgb[i], sizeof want->rgb[i]) != 0)
            ck_abort_msg("%s, state %llu: pixel %d,%d is %.17g %.17g %.17g, by single rays "
                         "%.17g %.17g %.17g",
                         what, state, i % 20, i / 20, got->rgb[i][0], got->rgb[i][1],
                         got->rgb[i][2], want->rgb[i][0], want->rgb[i][1], want->rgb[i][2]);
    }
    if (memcmp(&want->rays, &got->rays, sizeof got->rays) != 0)
        ck_abort_msg("%s, state %llu: %llu shadow rays, single rays %llu", what, state,
                     (unsigned long long)got->rays.shadow, (unsigned long long)want->rays.shadow);
}

START_TEST(test_disk_packet__packets_equal_single_rays)
{
    struct random random = random_begin(77);
    const char *many = getenv("PEN_N");
    int scenes = many ? atoi(many) : random_some(250, 90);
    static struct film single, packets;
    for (int i = 0; i < scenes; i++) {
        unsigned long long state = random.state;
        any_scene(&random);
        render(&single, PEN_ACCEL_NONE);
        for (int isa = 0; isa < isa_count(); isa++) {
            isa_force(isa);
            render(&packets, PEN_ACCEL_AUTO);
            compare(&single, &packets, pen_isa_name((enum pen_isa)isa), state);
        }
        isa_release();
    }
}
END_TEST

PEN_SUITE("disk_packet", test_disk_packet__packets_equal_single_rays)
