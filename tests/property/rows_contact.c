/* SPDX-License-Identifier: MIT */
/* Shadows that begin where primitives touch the floor. */
#include <math.h>

#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"
#include "support/world.h"

static const double pi = 3.14159265358979323846;

static struct kit kit;
static struct world world;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

/* Toward a direction of some azimuth and height over the plane y = 0, in radians. */
static vec3 toward(double azimuth, double height)
{
    return pen_vec3(cos(azimuth) * cos(height), sin(height), sin(azimuth) * cos(height));
}

/* ---- H064: the shadow of a ball that touches the floor is an ellipse around the contact ---- */

/* Arguments: radius, floor (0 plane, 1 polygon), x of the contact in radii; azimuth and height of
 * the light, the same of the camera. */
static void draw_contact(struct row_draw *d, struct row_case *c)
{
    static const double x[] = {0, 0x1p14, 0x1p24};
    struct random *r = &d->random;
    row_fixed(c, .05 * exp2((int)random_below(r, 41) - 20));
    row_fixed(c, random_below(r, 2));
    row_fixed(c, x[random_below(r, 3)]);
    row_fixed(c, random_in(r, 0, 2 * pi));
    row_fixed(c, random_below(r, 2) ? pi / 4 : random_in(r, .2, 1.4));
    row_fixed(c, random_in(r, 0, 2 * pi));
    row_fixed(c, random_in(r, .3, 1.4));
}

struct contact {
    double r, x;
    bool polygon;
    vec3 light; /* towards it; unit */
    vec3 eye;
};

static struct contact read_contact(const struct row_case *c)
{
    struct contact k = {
        c->arg[0], c->arg[2] * c->arg[0], c->arg[1] > 0, toward(c->arg[3], c->arg[4]), {0, 0, 0}};
    k.eye = pen_add(pen_vec3(k.x, 0, 0), pen_scale(toward(c->arg[5], c->arg[6]), 20 * k.r));
    return k;
}

static void floor_corners(const struct contact *k, vec3 corner[4])
{
    double half = 1000 * k->r;
    for (int i = 0; i < 4; i++) /* with its normal along y */
        corner[i] = pen_vec3(k->x + (i == 1 || i == 2 ? half : -half), 0, i < 2 ? half : -half);
}

/* 1 in the shadow, 0 outside, -1 too close to its border to say; (x, z) from the contact. The
 * ellipse: semi-axes r / sin and r, its middle r / tan behind the contact. */
static int in_ellipse(const struct contact *k, double x, double z)
{
    double across = sqrt(k->light.x * k->light.x + k->light.z * k->light.z);
    double u = -(x * k->light.x + z * k->light.z) / across;
    double w = (x * k->light.z - z * k->light.x) / across;
    double a = (u - k->r * across / k->light.y) / (k->r / k->light.y), b = w / k->r;
    double f = a * a + b * b - 1;
    return fabs(f) < 1e-6 ? -1 : f < 0;
}

/* Whether the place (x, z) from the contact is shaded; found on the floor as by a ray from above.
 */
static bool shaded(const struct contact *k, double x, double z)
{
    struct pen_hit hit[4], on = {0, PEN_NO_PRIM, 0};
    struct pen_ray down = world_ray(pen_vec3(k->x + x, 4 * k->r, z), pen_vec3(0, -1, 0));
    int count = world_intersections(&world, &down, &pen_origin_none, INFINITY, hit, 4);
    for (int i = 0; i < count && i < 4; i++)
        if (hit[i].prim == 0)
            on = hit[i];
    if (on.prim != 0)
        return false;
    vec3 p = pen_prim_point(&world.prims, on, &down);
    struct pen_origin_surface origin = world_origin_surface(&world, on, p, down.d, false);
    struct pen_ray ray = world_ray(p, k->light);
    return world_intersections(&world, &ray, &origin, INFINITY, NULL, 0) > 0;
}

enum { GRID = 100 };

/* The area by counting, and each place against the ellipse. */
static void judge_area(const struct contact *k, struct row_verdict *v)
{
    double across = sqrt(k->light.x * k->light.x + k->light.z * k->light.z);
    double a = k->r / k->light.y, middle = k->r * across / k->light.y, cell = 2.1 / GRID;
    int dark = 0, wrong = 0;
    for (int i = 0; i < GRID; i++)
        for (int j = 0; j < GRID; j++) {
            double u = middle + a * (cell * (i + .5) - 1.05), w = k->r * (cell * (j + .5) - 1.05);
            double x = (-u * k->light.x + w * k->light.z) / across;
            double z = (-u * k->light.z - w * k->light.x) / across;
            bool is = shaded(k, x, z);
            int want = in_ellipse(k, x, z);
            dark += is;
            wrong += want >= 0 && is != want;
        }
    row_measure(v, "area of the shadow [percent off]", 100 * fabs(dark * cell * cell / pi - 1), 1);
    row_measure(v, "places on the wrong side of the ellipse", wrong, 0);
}

/* However near the contact, and at it: dark. */
static void judge_nearness(const struct contact *k, struct row_verdict *v)
{
    int light = 0;
    double focus = k->r * (1 - sqrt(k->light.x * k->light.x + k->light.z * k->light.z));
    for (int power = 0; power <= 16; power++)
        for (int turn = 0; turn < 8; turn++) {
            double far = power == 16 ? 0 : .9 * focus * pow(10, -power), angle = turn * pi / 4;
            light += !shaded(k, far * cos(angle), far * sin(angle));
        }
    row_measure(v, "lit places next to the contact", light, 0);
}

/* Pixels of the floor are lit or dark as the ellipse says; those of the ball are not asked. */
static void judge_pixels(const struct contact *k, struct row_verdict *v)
{
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_pinhole p = pen_scene_pinhole(scene, 0, SHOT_SIDE, SHOT_SIDE);
    vec3 eye = pen_sub(k->eye, pen_vec3(k->x, 0, 0));
    int wrong = 0;
    shot_take(&kit, film);
    for (int i = 0; i < SHOT_PIXELS; i++) {
        vec3 d = pen_along(p.middle, p.dx, i % SHOT_SIDE + .5 - p.half_width);
        d = pen_normalize(pen_along(d, p.dy, i / SHOT_SIDE + .5 - p.half_height));
        vec3 to = pen_sub(pen_vec3(0, k->r, 0), eye);
        double past = pen_length(pen_cross(to, d)) / k->r, t = -eye.y / d.y;
        int want = in_ellipse(k, eye.x + t * d.x, eye.z + t * d.z);
        if (past > 1 + 1e-6 && d.y < 0 && want >= 0)
            wrong += (film[3 * i] > 0) == want;
    }
    pen_scene_free(scene);
    row_measure(v, "pixels of the floor lit or dark wrongly", wrong, 0);
}

static void judge_contact(const struct row_case *c, struct row_verdict *v)
{
    struct contact k = read_contact(c);
    vec3 corner[4], ball = pen_vec3(k.x, k.r, 0), up = pen_vec3(0, 1, 0);
    floor_corners(&k, corner);
    shot_begin(&kit);
    int matte = kit_material(&kit, kit_matte(1));
    world_clear(&world);
    if (k.polygon) {
        world_polygon(&world, corner, 4);
        kit_polygon(&kit, corner, 4, matte);
    } else {
        world_plane(&world, pen_vec3(0, 0, 0), up);
        kit_plane(&kit, pen_vec3(0, 0, 0), up, matte);
    }
    world_sphere(&world, ball, k.r);
    kit_sphere(&kit, ball, k.r, matte);
    kit_directional(&kit, pen_neg(k.light), pen_vec3(1, 1, 1));
    shot_look(&kit, k.eye, pen_vec3(k.x, 0, 0), 8 * k.r);
    judge_area(&k, v);
    judge_nearness(&k, v);
    judge_pixels(&k, v);
}

void rows_contact(struct pen_row_run *run)
{
    row_each(run, draw_contact, judge_contact);
}

/* ---- H065: between a box on the floor and its shadow no pixel is lit ---- */

/* Arguments: size, floor, turn of the box, where along the edge, height of the light and its turn
 * from the edge, height of the camera and its turn, how wide the window is. */
static void draw_resting(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, gen_power(r, -6, 6));
    row_fixed(c, random_below(r, 2));
    row_fixed(c, random_below(r, 4) ? random_in(r, 0, 2 * pi) : random_below(r, 4) * pi / 2);
    row_fixed(c, random_below(r, 2) ? .5 : random_in(r, .3, .7));
    row_fixed(c, random_in(r, .2, 1.4));
    row_fixed(c, random_in(r, -1, 1));
    row_fixed(c, random_in(r, .1, 1.4));
    row_fixed(c, random_in(r, -1, 1));
    row_fixed(c, gen_power(r, -12, -2.7));
}

/* A box with its base in y = 0: corners of the base, and how high it is. */
static void kit_prism(const vec3 base[4], double high, int material)
{
    vec3 top[4], turned[4];
    for (int i = 0; i < 4; i++) {
        top[i] = pen_add(base[i], pen_vec3(0, high, 0));
        turned[3 - i] = base[i];
    }
    kit_polygon(&kit, turned, 4, material);
    kit_polygon(&kit, top, 4, material);
    for (int i = 0; i < 4; i++) {
        const vec3 side[4] = {base[i], base[(i + 1) % 4], top[(i + 1) % 4], top[i]};
        kit_polygon(&kit, side, 4, material);
    }
}

static void judge_resting(const struct row_case *c, struct row_verdict *v)
{
    double size = c->arg[0], turn = c->arg[2];
    vec3 base[4], e = pen_vec3(cos(turn), 0, sin(turn)), m = pen_vec3(-sin(turn), 0, cos(turn));
    for (int i = 0; i < 4; i++) /* edge 0 to 1 is the one looked at; m points away from the box */
        base[i] = pen_along(pen_scale(e, i == 1 || i == 2 ? size : 0), m, i < 2 ? 0 : -size);
    vec3 q = pen_scale(e, c->arg[3] * size);
    vec3 flat[4];
    for (int i = 0; i < 4; i++)
        flat[i] = pen_vec3((i == 1 || i == 2 ? 50 : -50) * size, 0, (i < 2 ? 50 : -50) * size);
    shot_begin(&kit);
    int matte = kit_material(&kit, kit_matte(1));
    if (c->arg[1] > 0)
        kit_polygon(&kit, flat, 4, matte);
    else
        kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 1, 0), matte);
    kit_prism(base, size, matte);
    double azimuth = atan2(m.z, m.x);
    vec3 light = toward(azimuth + pi + c->arg[5], c->arg[4]);
    kit_directional(&kit, pen_neg(light), pen_vec3(1, 1, 1));
    shot_look(&kit, pen_along(q, toward(azimuth + c->arg[7], c->arg[6]), 5 * size), q,
              c->arg[8] * size);
    shot_take(&kit, film);
    kit.lights[0].shadows = false;
    shot_take(&kit, other);
    if (shot_lit(other) == 0) {
        row_skip(v);
        return;
    }
    row_measure(v, "lit pixels at the foot of a box", shot_lit(film), 0);
}

void rows_resting(struct pen_row_run *run)
{
    row_each(run, draw_resting, judge_resting);
}
