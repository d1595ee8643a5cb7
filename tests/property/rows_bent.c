/* SPDX-License-Identifier: MIT */
/* Polygons with vertices off their plane, as far as the reader accepts. Rooms made of them are
 * black. Where a wall stands on such a floor, no lit place is dark. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

enum { CORNERS = 12 };

static struct kit kit;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

/* The scene of one case: a floor of `count` corners around an upright axis, of radii .5 to 1. */
struct scene {
    struct random r;
    vec3 x, y, up, o;
    double size, window, near;
    int count, material;
    vec3 floor[CORNERS], ceiling[CORNERS];
};

/* Arguments: seed, size, offset in sizes, how far corners are off, and in sizes the window and the
 * eye's distance. */
static void draw(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(random_bits(r) >> 40));
    row_fixed(c, gen_power(r, -8, 8));
    row_fixed(c, random_below(r, 2) ? 0 : gen_offset(r));
    row_fixed(c, random_below(r, 4) ? gen_power(r, -7.5, -6.5) : gen_power(r, -16, -7));
    row_fixed(c, gen_power(r, -8, -2));
    row_fixed(c, gen_power(r, -6, -1));
}

/* A corner of the floor or of the ceiling, moved by up to `off` upwards or in any direction. */
static vec3 corner(struct scene *s, double angle, double radius, double z, double off)
{
    vec3 v = pen_along(pen_scale(s->x, radius * cos(angle)), s->y, radius * sin(angle));
    vec3 by = random_below(&s->r, 2) ? s->up : random_direction(&s->r);
    v = pen_along(pen_along(v, s->up, z), by, random_in(&s->r, -off, off));
    return pen_along(s->o, v, s->size);
}

/* All corners are off the plane, or one is. */
static void make(struct scene *s, const struct row_case *c)
{
    *s = (struct scene){.r = {(uint64_t)c->arg[0] * 0x9e3779b97f4a7c15u + 54, 0},
                        .size = c->arg[1],
                        .window = c->arg[4],
                        .near = c->arg[5]};
    struct random *r = &s->r;
    double off = c->arg[3];
    bool one = random_below(r, 2);
    s->up = random_below(r, 3) ? random_direction(r) : pen_vec3(0, 1, 0);
    gen_frame(r, s->up, &s->x, &s->y);
    s->o = gen_offset3(c->arg[2] * s->size);
    s->count = 4 + (int)random_below(r, CORNERS - 3);
    for (int i = 0; i < s->count; i++) {
        double angle = 2 * pi * (i + random_in(r, -.2, .2)) / s->count;
        double radius = random_in(r, .5, 1), by = one && i > 0 ? 0 : off;
        s->floor[i] = corner(s, angle, radius, 0, by);
        s->ceiling[i] = corner(s, angle, radius, .8, by);
    }
    shot_begin(&kit);
    kit.settings.light_samples = 4;
    kit.settings.max_depth = 3;
    kit.settings.min_contribution = 0;
}

static vec3 between(vec3 a, vec3 b, double share)
{
    return pen_along(a, pen_sub(b, a), share);
}

/* The wall between corner i and the next, up to the ceiling. */
static void add_wall(const struct scene *s, int i)
{
    int k = (i + 1) % s->count;
    const vec3 v[4] = {s->floor[i], s->floor[k], s->ceiling[k], s->ceiling[i]};
    kit_polygon(&kit, v, 4, s->material);
}

/* From a point q of a wall's foot: the eye is up and in front of it by shares of its distance. */
static void look(struct scene *s, vec3 q, vec3 front)
{
    vec3 d = pen_along(pen_scale(s->up, gen_power(&s->r, -2, 0)), front, random_in(&s->r, .1, 1));
    vec3 eye = pen_along(q, pen_normalize(d), s->near * s->size);
    double window = s->window < .3 * s->near ? s->window : .3 * s->near;
    shot_look(&kit, eye, q, window * s->size);
}

/* Whether the window is too narrow for the coordinates' rounding. */
static bool is_too_fine(const struct scene *s, vec3 q)
{
    return !(fmin(s->window, s->near) * s->size > 0x1p-44 * pen_norm1(q));
}

/* ---- Closed rooms ---- */

/* Lights outside: anywhere, or along the floor and a little below it. */
static void add_lights(struct scene *s)
{
    struct random *r = &s->r;
    vec3 one = pen_vec3(1, 1, 1), along = pen_cross(s->up, random_direction(r));
    vec3 low = pen_along(pen_normalize(along), s->up, random_in(r, -1, 1) * gen_power(r, -9, -5));
    kit_directional(&kit, random_direction(r), one);
    kit_directional(&kit, pen_neg(low), one);
    kit_point(&kit, pen_along(s->o, low, s->size * gen_power(r, .5, 3)), one);
    vec3 far = pen_scale(random_direction(r), s->size * random_in(r, 3, 30));
    kit_point(&kit, pen_add(s->o, far), one)->radius = s->size;
    kit.desc.background = one;
}

static void judge_room(const struct row_case *c, struct row_verdict *v)
{
    struct scene s;
    make(&s, c);
    struct pen_material m = kit_matte(.5);
    m.ks = m.kr = pen_vec3(.5, .5, .5);
    m.shininess = 10;
    s.material = kit_material(&kit, m);
    kit_polygon(&kit, s.floor, (uint32_t)s.count, s.material);
    kit_polygon(&kit, s.ceiling, (uint32_t)s.count, s.material);
    for (int i = 0; i < s.count; i++)
        add_wall(&s, i);
    add_lights(&s);
    int i = (int)random_below(&s.r, (uint32_t)s.count), k = (i + 1) % s.count;
    vec3 q =
        random_below(&s.r, 2) ? s.floor[i] : between(s.floor[i], s.floor[k], random_in(&s.r, 0, 1));
    vec3 axis = pen_sub(s.o, q);
    kit.settings.width = kit.settings.height = SHOT_SIDE / 2;
    if (is_too_fine(&s, q)) {
        row_skip(v);
        return;
    }
    look(&s, q, pen_normalize(axis));
    double rays = shot_take(&kit, film);
    row_measure(v, "lit pixels in a room of bent walls", shot_lit(film), 0);
    row_measure(v, "shadow rays of a case", rays, -1);
}

void rows_bent_rooms(struct pen_row_run *run)
{
    row_each(run, draw, judge_room);
}

/* ---- A wall's foot ---- */

/* A wall across the floor, reaching below it by more than the corners are off. Returns the middle
 * of its foot. */
static vec3 add_across(struct scene *s, vec3 front, double off)
{
    vec3 side = pen_cross(front, s->up),
         q = pen_along(s->o, front, s->size * random_in(&s->r, 0, .1));
    vec3 v[4];
    for (int i = 0; i < 4; i++) {
        double along = i == 0 || i == 3 ? -.3 : .3, z = i < 2 ? -3 * off : .8;
        v[i] = pen_along(pen_along(q, side, along * s->size), s->up, z * s->size);
    }
    kit_polygon(&kit, v, 4, s->material);
    return q;
}

/* The same bits with no accelerator, by base instructions. */
static void judge_same(struct row_verdict *v)
{
    const char *isa = getenv("PENUMBRA_ISA");
    kit.settings.accelerator = PEN_ACCEL_NONE;
    if (!isa)
        setenv("PENUMBRA_ISA", "base", 1);
    shot_take(&kit, other);
    if (!isa)
        unsetenv("PENUMBRA_ISA");
    row_measure(v, "whether another way gives other pixels", memcmp(film, other, sizeof film) != 0,
                0);
}

/* The wall stands on an edge of the floor, or across it. Light comes from the front. The background
 * is black, and so is what a gap under the wall shows. */
static void judge_foot(const struct row_case *c, struct row_verdict *v)
{
    struct scene s;
    make(&s, c);
    struct random *r = &s.r;
    s.material = kit_material(&kit, kit_matte(1));
    kit_polygon(&kit, s.floor, (uint32_t)s.count, s.material);
    int i = (int)random_below(r, (uint32_t)s.count), k = (i + 1) % s.count;
    vec3 q = between(s.floor[i], s.floor[k], random_in(r, .4, .6));
    vec3 front = pen_normalize(pen_cross(s.up, pen_sub(s.floor[k], s.floor[i])));
    if (random_below(r, 3))
        add_wall(&s, i);
    else {
        q = add_across(&s, front, c->arg[3] + 0x1p-50 * c->arg[2]);
        s.near = s.near > 1e-4 ? s.near : 1e-4; /* else the eye may be below the floor's middle */
    }
    if (is_too_fine(&s, q)) {
        row_skip(v);
        return;
    }
    vec3 aside = pen_scale(pen_cross(front, s.up), random_in(r, -1, 1));
    vec3 sun = pen_along(pen_along(aside, s.up, random_in(r, .5, 2)), front, 1);
    if (random_below(r, 2))
        kit_directional(&kit, pen_neg(sun), pen_vec3(1, 1, 1));
    else
        kit_point(&kit, pen_along(q, sun, s.size * random_in(r, .2, 20)), pen_vec3(1, 1, 1))
            ->radius = random_below(r, 2) * .01 * s.size;
    look(&s, q, front);
    shot_take(&kit, film);
    row_measure(v, "dark pixels at a wall's foot on a bent floor", SHOT_PIXELS - shot_lit(film), 0);
    if ((uint64_t)c->arg[0] % 8 == 0)
        judge_same(v);
}

void rows_bent_foot(struct pen_row_run *run)
{
    row_each(run, draw, judge_foot);
}
