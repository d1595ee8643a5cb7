/* SPDX-License-Identifier: MIT */
/* Shadows where there must be none, and light where there must be none: acne, closed rooms. */
#include <math.h>

#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

static struct kit kit;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

/* Takes the picture, and then the other one, without shadows; returns how many pixels differ.
 * *rays: how many shadow rays the first has. */
static int take_both(int lights, double *rays)
{
    int shaded = 0;
    *rays = shot_take(&kit, film);
    for (int i = 0; i < lights; i++)
        kit.lights[i].shadows = false;
    shot_take(&kit, other);
    for (int i = 0; i < SHOT_PIXELS; i++)
        shaded += film[3 * i] != other[3 * i];
    return shaded;
}

/* ---- H066: a convex primitive alone does not shade itself ---- */

enum acne {
    ACNE_PLANE,
    ACNE_POLYGON,
    ACNE_SPHERE,
    ACNE_TUBE,
    ACNE_CYLINDER,
    ACNE_INSIDE_SPHERE,
    ACNE_INSIDE_TUBE,
    ACNE_COUNT
};

/* Arguments: primitive, size, offset, how far the light is from grazing, the camera's distance, its
 * height over the surface, the window, how far inside along an infinite cylinder; then unit
 * vectors: the normal where the camera looks, the axis across it, and a place inside. */
static void draw_acne(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    double size = gen_power(r, -6, 6), offset = gen_offset(r);
    vec3 n = random_direction(r), x, y;
    gen_frame(r, n, &x, &y);
    row_fixed(c, (double)(d->index % ACNE_COUNT));
    row_fixed(c, size);
    row_fixed(c, offset * 1e-9 > size ? 0 : offset);
    row_fixed(c, random_below(r, 2) ? pi / 180 * .001 : gen_power(r, -12, 0));
    row_fixed(c, random_in(r, .5, 10));
    row_fixed(c, gen_power(r, -3, -.01));
    row_fixed(c, gen_power(r, -6, 1));
    row_fixed(c, gen_power(r, 0, 4));
    row_arg3(c, n);
    row_arg3(c, x);
    row_arg3(c, random_direction(r));
    row_arg(c, random_below(r, 2) ? 0 : random_in(r, -pi, pi)); /* of the light about the normal */
}

struct acne_case {
    int prim;
    double size, offset, grazing, far, height, window, along, turn;
    vec3 n, x, y, any, p, c;
};

static bool read_acne(const struct row_case *c, struct acne_case *a)
{
    int at = 0;
    a->prim = (int)row_next(c, &at);
    a->size = row_next(c, &at);
    a->offset = row_next(c, &at);
    a->grazing = row_next(c, &at);
    a->far = row_next(c, &at);
    a->height = row_next(c, &at);
    a->window = row_next(c, &at);
    a->along = row_next(c, &at);
    a->n = row_next3(c, &at);
    a->x = row_next3(c, &at);
    a->any = row_next3(c, &at);
    a->turn = row_next(c, &at);
    a->y = pen_cross(a->n, a->x);
    a->c = gen_offset3(a->offset);
    a->p = pen_along(a->c, a->n, a->size);
    return fabs(pen_dot(a->n, a->n) - 1) < 1e-9 && fabs(pen_dot(a->x, a->x) - 1) < 1e-9 &&
           fabs(pen_dot(a->n, a->x)) < 1e-9 && fabs(pen_dot(a->any, a->any) - 1) < 1e-9 &&
           fabs(a->turn) < 4;
}

/* The primitive, which has p on it and n as normal there. */
static void acne_primitive(const struct acne_case *a)
{
    int matte = kit_material(&kit, kit_matte(1));
    vec3 corner[4];
    for (int i = 0; i < 4; i++)
        corner[i] = pen_along(pen_along(a->p, a->x, (i == 1 || i == 2 ? 30 : -30) * a->size), a->y,
                              (i < 2 ? -30 : 30) * a->size);
    if (a->prim == ACNE_PLANE)
        kit_plane(&kit, a->p, a->n, matte);
    else if (a->prim == ACNE_POLYGON)
        kit_polygon(&kit, corner, 4, matte);
    else if (a->prim == ACNE_SPHERE || a->prim == ACNE_INSIDE_SPHERE)
        kit_sphere(&kit, a->c, a->size, matte);
    else if (a->prim == ACNE_CYLINDER)
        kit_cylinder(&kit, pen_along(a->c, a->x, -a->size), a->x, a->size, 2 * a->size, matte);
    else
        kit_tube(&kit, a->c, a->x, a->size, matte);
}

/* From outside: the light barely over the surface at p, along the axis of infinite cylinders or at
 * any angle to it. */
static void acne_outside(const struct acne_case *a)
{
    vec3 flat = pen_along(pen_scale(a->x, cos(a->turn)), a->y, sin(a->turn));
    vec3 light = pen_along(pen_scale(flat, cos(a->grazing)), a->n, sin(a->grazing));
    vec3 side = pen_along(a->any, a->n, -pen_dot(a->any, a->n));
    vec3 eye = pen_along(pen_along(a->p, side, a->far * a->size), a->n,
                         a->height * a->far * a->size + a->offset * 1e-12);
    kit_directional(&kit, pen_neg(light), pen_vec3(1, 1, 1));
    shot_look(&kit, eye, a->p, a->window * a->size * a->height);
}

/* From inside: of an infinite cylinder, a light far along it, and a place between. */
static void acne_inside(const struct acne_case *a)
{
    double along = a->prim == ACNE_INSIDE_TUBE ? a->along : 0;
    vec3 light = pen_along(pen_along(a->c, a->any, .4 * a->size), a->x, along * a->size);
    kit_point(&kit, light, pen_vec3(1, 1, 1));
    shot_look(&kit, pen_along(a->c, a->any, -.3 * a->size),
              pen_along(a->p, a->x, .5 * along * a->size), a->window * a->size * .1);
}

static void judge_acne(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[ACNE_COUNT] = {
        "self-shaded pixels of a plane",    "self-shaded pixels of a polygon",
        "self-shaded pixels of a sphere",   "self-shaded pixels of a tube",
        "self-shaded pixels of a cylinder", "self-shaded pixels in a sphere",
        "self-shaded pixels in a tube",
    };
    struct acne_case a;
    if (!read_acne(c, &a)) {
        row_skip(v);
        return;
    }
    shot_begin(&kit);
    acne_primitive(&a);
    if (a.prim >= ACNE_INSIDE_SPHERE)
        acne_inside(&a);
    else
        acne_outside(&a);
    double rays;
    int shaded = take_both(1, &rays);
    row_measure(v, name[a.prim], shaded, 0);
    row_measure(v, "pixels that face the light", shot_lit(other), -1);
}

void rows_acne(struct pen_row_run *run)
{
    row_each(run, draw_acne, judge_acne);
}

/* ---- H073: a closed room with mirrors for walls, light all around it, and none inside ---- */

/* Walls: quads or triangles that share their corners, quads that cross each other, planes. */
enum walls { WALLS_QUADS, WALLS_TRIANGLES, WALLS_CROSSING, WALLS_PLANES };

/* Arguments: the walls, seed of the room, offset, the window, what is looked at. */
static void draw_window(struct row_draw *d, struct row_case *c, double from, double to,
                        enum walls walls)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(walls + random_below(r, 2)));
    row_fixed(c, (double)(random_bits(r) >> 40));
    row_fixed(c, gen_offset(r) / 1e3);
    row_fixed(c, gen_power(r, from, to));
    row_fixed(c, random_below(r, 24));
}

static void draw_room(struct row_draw *d, struct row_case *c)
{
    draw_window(d, c, -7, .5, WALLS_QUADS);
}

static void draw_seam(struct row_draw *d, struct row_case *c)
{
    draw_window(d, c, -14, -7, WALLS_QUADS);
}

static void draw_crossing(struct row_draw *d, struct row_case *c)
{
    draw_window(d, c, -14, -7, WALLS_CROSSING);
}

static void add_wall(enum walls walls, const vec3 v[4], int material)
{
    vec3 middle = pen_scale(pen_add(v[0], v[2]), .5), far[4];
    for (int i = 0; i < 4; i++)
        far[i] = pen_along(v[i], pen_sub(v[i], middle), .5);
    if (walls == WALLS_TRIANGLES) {
        kit_triangle(&kit, v[0], v[1], v[2], material);
        kit_triangle(&kit, v[0], v[2], v[3], material);
    } else if (walls == WALLS_PLANES) {
        kit_plane(&kit, v[0], pen_cross(pen_sub(v[1], v[0]), pen_sub(v[3], v[0])), material);
    } else {
        kit_polygon(&kit, walls == WALLS_CROSSING ? far : v, 4, material);
    }
}

/* The walls; returns a place on an edge, or the corner that ends it. */
static vec3 make_room(const struct row_case *c, struct random *r)
{
    static const int wall[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                   {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    vec3 corner[8], n = random_direction(r), x, y, o = gen_offset3(c->arg[2]);
    double high = random_in(r, 1, 2), wide = random_in(r, 1, 2);
    gen_frame(r, random_below(r, 2) ? n : pen_vec3(0, 0, 1), &x, &y);
    n = pen_cross(x, y);
    for (int i = 0; i < 8; i++)
        corner[i] = pen_along(pen_along(pen_along(o, x, i & 1 ? 1 : -1), y, i & 2 ? wide : -1), n,
                              i & 4 ? high : -1);
    struct pen_material m = kit_matte(.5);
    m.kr = pen_vec3(.5, .5, .5);
    int mirror = kit_material(&kit, m);
    for (int w = 0; w < 6; w++) {
        vec3 v[4];
        for (int i = 0; i < 4; i++)
            v[i] = corner[wall[w][i]];
        add_wall((enum walls)c->arg[0], v, mirror);
    }
    int seam = (int)c->arg[4];
    vec3 from = corner[wall[seam / 4][seam % 4]], to = corner[wall[seam / 4][(seam + 1) % 4]];
    double share = random_below(r, 3) ? random_unit(r) : 0;
    return pen_along(from, pen_sub(to, from), share);
}

/* A room, and three surfaces of every path in it; returns the place to look at. */
static vec3 begin_room(const struct row_case *c, struct random *r)
{
    shot_begin(&kit);
    kit.settings.light_samples = 4;
    kit.settings.max_depth = 3;
    kit.settings.min_contribution = 0;
    return make_room(c, r);
}

static struct random room_random(const struct row_case *c)
{
    return (struct random){(uint64_t)c->arg[1] * 0x9e3779b97f4a7c15u + 73, 0};
}

static void judge_room(const struct row_case *c, struct row_verdict *v)
{
    struct random r = room_random(c);
    vec3 at = begin_room(c, &r), o = gen_offset3(c->arg[2]);
    kit.desc.background = pen_vec3(1, 1, 1);
    kit_directional(&kit, random_direction(&r), pen_vec3(1, 1, 1));
    kit_point(&kit, pen_along(o, random_direction(&r), random_in(&r, 5, 50)), pen_vec3(1, 1, 1));
    kit_point(&kit, pen_along(o, random_direction(&r), 5), pen_vec3(1, 1, 1))->radius = 1;
    shot_look(&kit, pen_along(o, random_direction(&r), .5), at, c->arg[3]);
    double rays = shot_take(&kit, film);
    row_measure(v, "lit pixels in a closed room", shot_lit(film), 0);
    row_measure(v, "shadow rays of a case", rays, -1);
}

void rows_room(struct pen_row_run *run)
{
    row_each(run, draw_room, judge_room);
}

void rows_seam(struct pen_row_run *run)
{
    row_each(run, draw_seam, judge_room);
}

void rows_crossing(struct pen_row_run *run)
{
    row_each(run, draw_crossing, judge_room);
}

/* The other side of it: what rounding decides at a seam must not put out a light in the room. */
static void judge_inside(const struct row_case *c, struct row_verdict *v)
{
    struct random r = room_random(c);
    vec3 at = begin_room(c, &r), o = gen_offset3(c->arg[2]);
    for (int i = 0; i < 3; i++) {
        vec3 where = pen_along(o, random_direction(&r), random_in(&r, 0, .9));
        kit_point(&kit, where, pen_vec3(1, 1, 1))->radius = i == 2 ? .05 : 0;
    }
    shot_look(&kit, pen_along(o, random_direction(&r), .5), at, c->arg[3]);
    double rays;
    int shaded = take_both(3, &rays);
    row_measure(v, "shaded pixels in an empty room", shaded, 0);
    row_measure(v, "shadow rays of a case", rays, -1);
}

/* The room from outside: a convex primitive shades nothing. */
static void judge_outside(const struct row_case *c, struct row_verdict *v)
{
    struct random r = room_random(c);
    vec3 at = begin_room(c, &r), o = gen_offset3(c->arg[2]);
    for (int i = 0; i < 3; i++)
        kit_directional(&kit, random_direction(&r), pen_vec3(1, 1, 1));
    vec3 eye = pen_along(pen_along(o, pen_sub(at, o), 4), random_direction(&r), 3);
    shot_look(&kit, eye, at, c->arg[3]);
    double rays;
    int shaded = take_both(3, &rays);
    row_measure(v, "shaded pixels of a convex primitive", shaded, 0);
    row_measure(v, "shadow rays of a case", rays, -1);
}

void rows_outside(struct pen_row_run *run)
{
    row_each(run, draw_seam, judge_outside);
}

void rows_inside(struct pen_row_run *run)
{
    row_each(run, draw_seam, judge_inside);
}
