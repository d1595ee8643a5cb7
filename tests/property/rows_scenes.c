/* SPDX-License-Identifier: MIT */
/* Random scenes of primitives of every kind, many of which touch or coincide. Every way of
 * rendering gives the same film and the same numbers of rays. */
#include <stdlib.h>
#include <string.h>

#include "property/gen.h"
#include "property/rows.h"
#include "support/isa.h"
#include "support/kit.h"

enum { SIDE_MOST = 24, MATERIALS = 6, VALUES_MOST = 3 * SIDE_MOST * SIDE_MOST };

static struct kit kit;

/* Places are on a grid of halves, and sizes are halves: so things touch and coincide. */
static double half(struct random *r, int from, int to)
{
    return .5 * (from + (int)random_below(r, (uint32_t)(to - from + 1)));
}

static vec3 place(struct random *r)
{
    double x = half(r, -4, 4), y = half(r, -4, 4);
    return pen_vec3(x, y, half(r, -4, 4));
}

static vec3 axis(struct random *r)
{
    return random_below(r, 3) ? gen_axial(r) : random_direction(r);
}

static double one_of(struct random *r, double a, double b, double c)
{
    double of[3] = {a, b, c};
    return of[random_below(r, 3)];
}

static struct pen_material draw_material(struct random *r, bool glass, bool refracting)
{
    struct pen_material m = kit_matte(one_of(r, .3, .8, 1));
    double ks = one_of(r, 0, 0, .5), kr = one_of(r, 0, 0, .6), kt = one_of(r, 0, 0, .7);
    if (glass)
        kt = random_in(r, .5, 1);
    m.ks = pen_vec3(ks, ks, .5 * ks);
    m.kr = pen_vec3(kr, .9 * kr, kr);
    m.kt = pen_vec3(kt, kt, .8 * kt);
    m.shininess = one_of(r, 1, 10, 77.7);
    m.ior = refracting ? one_of(r, 1, 1.5, 1.25) : 1;
    m.reflection_blur = refracting ? one_of(r, 0, 0, 20) : 0;
    m.transmission_blur = refracting ? one_of(r, 0, 0, 80) : 0;
    return m;
}

static void add_flat(struct random *r, int material)
{
    vec3 at = place(r), e = gen_dyadic3(r, 2), f = gen_dyadic3(r, 2), v[6];
    int count = 3 + (int)random_below(r, 2);
    while (pen_norm1(pen_cross(e, f)) < .25) {
        e = gen_dyadic3(r, 2);
        f = gen_dyadic3(r, 2);
    }
    if (random_below(r, 2)) { /* along the axes */
        int k = (int)random_below(r, 3);
        e = pen_vec3(k == 0, k == 1, k == 2);
        f = pen_scale(pen_vec3(k == 2, k == 0, k == 1), 2);
    }
    v[0] = at;
    v[1] = pen_add(at, e);
    v[2] = pen_add(v[1], f);
    v[3] = pen_add(at, f);
    if (random_below(r, 4) == 0) { /* a corner turned inwards */
        v[4] = pen_along(pen_along(at, e, .25), f, .5);
        count = 5;
    }
    if (count == 3)
        kit_triangle(&kit, v[0], v[1], v[2], material);
    else
        kit_polygon(&kit, v, (uint32_t)count, material);
}

static void add_round(struct random *r, int material)
{
    vec3 at = place(r), a = axis(r);
    double radius = half(r, 1, 3), h = half(r, 1, 4), top = half(r, 0, 3);
    struct pen_object_desc *o;
    switch (random_below(r, 8)) {
    case 0:
        kit_tube(&kit, at, a, .5 * radius, material);
        return;
    case 1:
    case 2:
        kit_sphere(&kit, at, radius, material);
        return;
    default:
        o = kit_cylinder(&kit, at, a, radius, h, material);
        o->u.cylinder.caps = random_below(r, 3) > 0;
        if (random_below(r, 2) || top == radius)
            return;
        o->kind = PEN_OBJECT_CONE;
        o->u.cone.base = at;
        o->u.cone.axis = a;
        o->u.cone.radius = radius;
        o->u.cone.top_radius = top;
        o->u.cone.height = h;
        o->u.cone.caps = random_below(r, 3) > 0;
    }
}

static void add_object(struct random *r, int material)
{
    uint32_t first = kit.desc.object_count, what = random_below(r, 10);
    if (what == 0) {
        vec3 at = place(r);
        kit_plane(&kit, at, axis(r), material);
    } else if (what < 5)
        add_flat(r, material);
    else
        add_round(r, material);
    if (random_below(r, 6) == 0) {
        vec3 about = random_direction(r);
        struct pen_transform turn =
            pen_transform_make(1, about, 15 * half(r, 0, 6), pen_vec3(0, 0, 0));
        kit_group(&kit, first, &turn);
    }
}

static void add_light(struct random *r)
{
    struct pen_light_desc *light;
    vec3 at = place(r);
    switch (random_below(r, 3)) {
    case 0:
        light = kit_point(&kit, at, pen_vec3(1, .9, .8));
        break;
    case 1:
        light = kit_directional(&kit, axis(r), pen_vec3(.5, .6, .7));
        light->angular_radius = random_below(r, 3) ? 0 : 3;
        return;
    default:
        light = kit_spot(&kit, at, random_direction(r), pen_vec3(1, 1, 1));
        light->beam_exponent = 2;
    }
    light->radius = one_of(r, 0, .25, 1);
}

static void make_scene(struct random *r)
{
    int material[MATERIALS], things = 2 + (int)random_below(r, 23);
    bool glass = random_below(r, 4) == 0; /* shadow rays pass many surfaces */
    bool refracting = random_below(r, 3) == 0;
    kit_init(&kit);
    for (int i = 0; i < MATERIALS; i++)
        material[i] = kit_material(&kit, draw_material(r, glass, refracting));
    for (int i = 0; i < things; i++) {
        struct random before = *r;
        add_object(r, material[random_below(r, MATERIALS)]);
        if (random_below(r, 4) == 0) /* once more, in the same place */
            add_object(&before, material[random_below(r, MATERIALS)]);
    }
    for (uint32_t i = 1 + random_below(r, 3); i > 0; i--)
        add_light(r);
    kit.desc.background = pen_vec3(.1, .2, .3);
    kit.view.camera.position = place(r);
    kit.view.camera.position.z = random_below(r, 3) ? 8 : 1;
    kit.view.camera.direction = pen_sub(place(r), kit.view.camera.position);
    struct pen_vec3 *view = &kit.view.camera.direction;
    bool along_up = view->x == 0 && view->z == 0;
    if (random_below(r, 2) || along_up) /* rays through edges of the grid */
        *view = pen_vec3(0, 0, -1);
    kit.settings.width = 1 + (int)random_below(r, SIDE_MOST);
    kit.settings.height = 1 + (int)random_below(r, SIDE_MOST);
    kit.settings.samples_per_pixel = random_below(r, 4) ? 1 : 2;
    kit.settings.light_samples = random_below(r, 6) ? 3 : 40;
    kit.settings.blur_samples = 3;
    kit.settings.max_depth = 1 + (int)random_below(r, 5);
}

/* A way to render a scene. */
struct means {
    int isa, accelerator, threads, tile;
    bool pixel_by_pixel;
};

/* Renders into film; false if that fails. */
static bool render(const struct pen_scene *scene, const struct means *by, float *film,
                   struct pen_ray_counts *rays)
{
    static struct pen_thread_pool *pool[2];
    struct pen_status st;
    struct pen_render_stats stats = {.threads = 0};
    struct pen_thread_pool **of = &pool[by->threads > 1];
    if (!*of)
        *of = pen_thread_pool_new(by->threads, &st);
    kit.settings.tile = by->tile;
    isa_force(by->isa);
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = -1,
                                   .rgb = film,
                                   .pixel_by_pixel = by->pixel_by_pixel};
    memset(film, 0, VALUES_MOST * sizeof *film);
    bool ok = *of && pen_render_run(*of, &task, &stats, &st);
    isa_release();
    *rays = stats.rays;
    return ok;
}

/* Renders the binary64 values that a film is rounded from, pixel by pixel; false if that fails. */
static bool render_unrounded(const struct pen_scene *scene, int isa, double *film)
{
    struct pen_ray_counts rays;
    struct pen_status st;
    bool ok = true;
    memset(film, 0, VALUES_MOST * sizeof *film);
    isa_force(isa);
    for (int y = 0; y < kit.settings.height; y++) {
        for (int x = 0; x < kit.settings.width; x++)
            ok = pen_render_pixel(scene, 0, &kit.settings, x, y,
                                  film + 3 * (y * kit.settings.width + x), &rays, &st) &&
                 ok;
    }
    isa_release();
    return ok;
}

_Static_assert(PEN_ACCEL_AUTO == 0, "rendered first");

/* How many binary64 values differ from those of the scene's first render. Films of floats hide in
 * which order a disk packet multiplies; these packets exist with `auto` only. */
static int unrounded_that_differ(const struct pen_scene *scene, int accelerator, bool *ok)
{
    static double truth[VALUES_MOST], film[VALUES_MOST];
    int renders = accelerator == PEN_ACCEL_AUTO ? isa_count() : accelerator == PEN_ACCEL_NONE;
    int count = 0;
    for (int isa = 0; isa < renders; isa++) {
        bool first = accelerator == PEN_ACCEL_AUTO && isa == 0;
        double *into = first ? truth : film;
        *ok = render_unrounded(scene, isa, into) && *ok;
        for (int i = 0; i < VALUES_MOST; i++)
            count += memcmp(&into[i], &truth[i], sizeof *into) != 0;
    }
    return count;
}

static int values_that_differ(const float *a, const float *b)
{
    int count = 0;
    for (int i = 0; i < VALUES_MOST; i++)
        count += memcmp(&a[i], &b[i], sizeof *a) != 0;
    return count;
}

static void draw_seed(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, (double)(random_bits(&d->random) >> 40));
}

static void judge_scene(const struct row_case *c, struct row_verdict *v)
{
    static const int tile[] = {5, 16, 64};
    static float truth[VALUES_MOST], film[VALUES_MOST];
    struct random r = {(uint64_t)c->arg[0] * 0x9e3779b97f4a7c15u + 11, 0};
    struct pen_ray_counts rays = {.primary = 0};
    int values = 0, unrounded = 0, counts = 0, lit = 0, renders = 0;
    bool ok = true;
    make_scene(&r);
    for (int accelerator = 0; accelerator < PEN_ACCEL_COUNT; accelerator++) {
        kit.settings.accelerator = accelerator;
        struct pen_scene *scene = kit_freeze(&kit);
        for (int i = 0; i < 6 * isa_count(); i++, renders++) {
            int threads = (i + i / 6 + accelerator) % 2 ? 3 : 1;
            struct means by = {i / 6, accelerator, threads, tile[i % 3], i % 6 < 3};
            struct pen_ray_counts got;
            ok = render(scene, &by, renders ? film : truth, &got) && ok;
            if (renders == 0)
                rays = got;
            else
                values += values_that_differ(film, truth);
            counts += memcmp(&got, &rays, sizeof got) != 0;
        }
        unrounded += unrounded_that_differ(scene, accelerator, &ok);
        pen_scene_free(scene);
    }
    for (int i = 0; i < VALUES_MOST; i++)
        lit += truth[i] != 0;
    row_require(v, ok, "a render fails");
    row_measure(v, "values that differ", values, 0);
    row_measure(v, "values that differ before they are rounded", unrounded, 0);
    row_measure(v, "numbers of rays that differ", counts, 0);
    row_measure(v, "ways to render the scene", renders, -1);
    row_measure(v, "values above 0", lit, -1);
}

void rows_scenes_same(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_scene);
}
