/* SPDX-License-Identifier: MIT */
/* Rooms that stand on a floor 1e2 to 1e12 times as wide. From inside they are black. Outside, on
 * the lit side, there is no shadow at the foot of their walls. */
#include <math.h>

#include "property/body.h"
#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

enum { SIDE = 16, WALLS_MAX = 8 };

static struct kit kit;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

enum floor {
    FLOOR_PLANE,
    FLOOR_QUAD,
    FLOOR_SPLIT, /* two triangles, whose seam may pass under the room */
    FLOOR_FAN,   /* four triangles around a point in the room */
    FLOOR_NGON,  /* of 3 to 12 corners */
    FLOOR_COUNT
};

/* A case: which floor, how wide in sizes; size, offset, window in sizes, how near to a wall the eye
 * is, surfaces in a path, seed. */
struct standing {
    enum floor floor;
    double wide, size, offset, window, near, depth;
    struct random r;
    struct body_pose pose;
    bool exact;    /* the floor is z = 0, and rounding does not change that */
    double margin; /* in sizes: more than coordinates are rounded by */
    int walls, material;
    double poke, high; /* how far walls reach below the floor and above it */
    vec3 foot[WALLS_MAX];
};

static void draw_floor(struct row_draw *d, struct row_case *c, double window)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(d->index % FLOOR_COUNT));
    row_fixed(c, gen_power(r, 2, 12));
    row_fixed(c, random_below(r, 2) ? 1 : gen_power(r, -8, 8));
    row_fixed(c, random_below(r, 2) ? 0 : gen_power(r, 0, 9));
    row_fixed(c, gen_power(r, -14, window));
    row_fixed(c, gen_power(r, -10, 0));
    row_fixed(c, 1 + random_below(r, 10));
    row_fixed(c, (double)(random_bits(r) >> 40));
}

static vec3 put(const struct standing *s, vec3 p)
{
    return body_place(&s->pose, p);
}

/* Walls end at the floor where both are told exactly, else they reach through it. */
static void make_standing(const struct row_case *c, struct standing *s)
{
    *s = (struct standing){.floor = (enum floor)c->arg[0],
                           .wide = c->arg[1],
                           .size = c->arg[2],
                           .offset = c->arg[3],
                           .window = c->arg[4],
                           .near = c->arg[5],
                           .depth = c->arg[6],
                           .r = {(uint64_t)c->arg[7] * 0x9e3779b97f4a7c15u + 135, 0}};
    struct random *r = &s->r;
    s->pose = body_pose(r, s->size, s->offset);
    s->exact = s->offset == 0 && s->pose.z.x == 0 && s->pose.z.y == 0;
    s->margin = body_rounding(&s->pose);
    if (s->floor != FLOOR_PLANE)
        s->margin += 64 * 0x1p-53 * s->wide;
    s->poke = s->exact && random_below(r, 2) ? 0 : s->margin + gen_power(r, -3, 0);
    s->walls = 3 + (int)random_below(r, WALLS_MAX - 2);
    s->high = random_in(r, .3, 1.5);
    double turn = random_below(r, 2) ? 0 : random_in(r, 0, 2 * pi);
    for (int i = 0; i < s->walls; i++) {
        double angle = turn + 2 * pi * i / s->walls;
        s->foot[i] = pen_vec3(cos(angle), sin(angle), 0);
    }
}

static void add_polygon(const struct standing *s, const vec3 *v, int count, bool split)
{
    vec3 w[16];
    for (int i = 0; i < count; i++)
        w[i] = s->pose.group ? v[i] : put(s, v[i]);
    if (!split)
        kit_polygon(&kit, w, (uint32_t)count, s->material);
    for (int i = 1; split && i + 1 < count; i++)
        kit_triangle(&kit, w[0], w[i], w[i + 1], s->material);
}

static void add_room(struct standing *s)
{
    vec3 lid[WALLS_MAX];
    bool split = random_below(&s->r, 2);
    for (int i = 0; i < s->walls; i++) {
        vec3 a = s->foot[i], b = s->foot[(i + 1) % s->walls];
        lid[i] = pen_vec3(a.x, a.y, s->high);
        const vec3 wall[4] = {
            {a.x, a.y, -s->poke}, {b.x, b.y, -s->poke}, {b.x, b.y, s->high}, {a.x, a.y, s->high}};
        add_polygon(s, wall, 4, split);
    }
    add_polygon(s, lid, s->walls, split);
}

/* The room may be anywhere on the floor, or where the diagonals of the floor meet. */
static void add_wide_floor(struct standing *s)
{
    struct random *r = &s->r;
    int count = s->floor == FLOOR_NGON ? 3 + (int)random_below(r, 10) : 4;
    double turn = random_below(r, 2) ? pi / 4 : random_in(r, 0, 2 * pi), a = random_in(r, 0, 7);
    double shift = random_below(r, 2) ? random_in(r, 0, .4) * s->wide : 0;
    vec3 corner[16], by = pen_vec3(shift * cos(a), shift * sin(a), 0), inner = pen_vec3(0, 0, 0);
    for (int i = 0; i < count; i++) {
        double angle = turn + 2 * pi * i / count;
        vec3 v = pen_vec3(s->wide * cos(angle), s->wide * sin(angle), 0);
        corner[i] = pen_add(v, by);
    }
    if (random_below(r, 2))
        inner = pen_vec3(random_in(r, -.3, .3), random_in(r, -.3, .3), 0);
    if (s->floor == FLOOR_PLANE)
        kit_plane(&kit, s->pose.group ? inner : put(s, inner),
                  s->pose.group ? pen_vec3(0, 0, 1) : s->pose.z, s->material);
    else if (s->floor != FLOOR_FAN)
        add_polygon(s, corner, count, s->floor == FLOOR_SPLIT);
    for (int i = 0; s->floor == FLOOR_FAN && i < 4; i++) {
        const vec3 v[3] = {corner[i], corner[(i + 1) % 4], inner};
        add_polygon(s, v, 3, true);
    }
}

/* The floor before the room or behind it in document order; both in a group, or neither. */
static void add_both(struct standing *s)
{
    bool first = random_below(&s->r, 2);
    if (first)
        add_wide_floor(s);
    add_room(s);
    if (!first)
        add_wide_floor(s);
    struct pen_transform transform = body_transform(&s->pose);
    if (s->pose.group)
        kit_group(&kit, 0, &transform);
}

static void begin_picture(struct standing *s)
{
    struct random *r = &s->r;
    shot_begin(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.settings.light_samples = 4;
    kit.settings.max_depth = (int)s->depth;
    kit.settings.min_contribution = 0;
    double ks = .5 * random_below(r, 3), kr = .5 * random_below(r, 3);
    struct pen_material m = kit_matte(.5);
    m.ks = pen_vec3(ks, ks, ks);
    m.kr = pen_vec3(kr, kr, kr);
    m.shininess = random_below(r, 2) ? 10 : 200;
    s->material = kit_material(&kit, m);
}

/* ---- Inside ---- */

/* In the floor's plane beside the room, just above or below it; under the room; anywhere. */
static void add_point_outside(struct standing *s)
{
    struct random *r = &s->r;
    double angle = random_in(r, 0, 2 * pi), from = 1 + 2 * s->margin + gen_power(r, -9, 0);
    double far = random_below(r, 2) ? from : gen_power(r, .1, 8), up = gen_power(r, -14, 0);
    vec3 p = pen_vec3(far * cos(angle), far * sin(angle), 0);
    uint32_t how = random_below(r, 4);
    if (how == 1)
        p.z = up;
    else if (how == 2)
        p.z = -up;
    else if (how == 3)
        p = pen_vec3(random_in(r, -1, 1), random_in(r, -1, 1),
                     -2 * s->margin - gen_power(r, -12, 6));
    struct pen_light_desc *light = kit_point(&kit, put(s, p), pen_vec3(1, 1, 1));
    if (how == 3 && random_below(r, 2))
        light->radius = .9 * (-p.z - 2 * s->margin) * s->size;
}

/* A direction along the floor or along a wall, or nearly so; or any. */
static void add_sun(struct standing *s)
{
    struct random *r = &s->r;
    int i = (int)random_below(r, (uint32_t)s->walls);
    vec3 d = random_direction(r);
    vec3 edge = pen_normalize(pen_sub(s->foot[(i + 1) % s->walls], s->foot[i]));
    if (random_below(r, 2))
        d.z = random_below(r, 2) ? 0 : gen_power(r, -17, -5) * (random_below(r, 2) ? 1 : -1);
    else if (random_below(r, 2))
        d = pen_along(edge, pen_vec3(0, 0, 1), random_in(r, -1, 1));
    struct pen_light_desc *light = kit_directional(&kit, body_turn(&s->pose, d), pen_vec3(1, 1, 1));
    if (random_below(r, 3) == 0)
        light->angular_radius = gen_power(r, -8, 1.9);
}

/* A place on the room's inner surface: a foot, a corner, an edge, the floor, a wall. */
static vec3 inner_place(struct standing *s)
{
    struct random *r = &s->r;
    int i = (int)random_below(r, (uint32_t)s->walls), k = (i + 1) % s->walls;
    double along = random_below(r, 2) ? 0 : random_unit(r);
    vec3 p = pen_along(s->foot[i], pen_sub(s->foot[k], s->foot[i]), along);
    switch (random_below(r, 4)) {
    case 0: /* the floor */
        return pen_scale(p, random_unit(r));
    case 1: /* a wall */
        p.z = s->high * random_unit(r);
        return p;
    case 2:
        p.z = s->high;
        return p;
    default:
        return p;
    }
}

/* Polygons whose corners are rounded off their plane are known to that rounding everywhere. Where
 * that is not fine enough for the picture, it warns. */
static int lit_of(const struct standing *s, struct row_verdict *v)
{
    int lit = shot_lit(film);
    if (lit > 0 && (s->floor == FLOOR_QUAD || s->floor == FLOOR_NGON) && shot_warns(&kit)) {
        row_tally(v, "lit, with the warning, on a floor that its corners do not tell so finely");
        lit = 0;
    }
    return lit;
}

static void judge_inside(const struct row_case *c, struct row_verdict *v)
{
    struct standing s;
    make_standing(c, &s);
    begin_picture(&s);
    add_both(&s);
    kit.desc.background = pen_vec3(1, 1, 1);
    for (int i = 0; i < 3; i++) {
        if (random_below(&s.r, 2))
            add_sun(&s);
        else
            add_point_outside(&s);
    }
    vec3 middle = pen_vec3(0, 0, .5 * s.high), to = inner_place(&s), at = inner_place(&s);
    double share = random_below(&s.r, 2) ? s.near : random_in(&s.r, .1, 1);
    vec3 eye = pen_along(to, pen_sub(middle, to), share);
    if (.2 * s.high * share < 4 * s.margin) {
        row_skip(v);
        return;
    }
    shot_look(&kit, put(&s, eye), put(&s, at), s.window * s.size);
    if (!(pen_norm1(kit.view.camera.direction) > 0)) {
        row_skip(v);
        return;
    }
    double rays = shot_take(&kit, film);
    row_measure(v, "lit pixels of a room on a wide floor", lit_of(&s, v), 0);
    row_measure(v, "shadow rays of a case", rays, -1);
}

static void draw_inside(struct row_draw *d, struct row_case *c)
{
    draw_floor(d, c, .5);
}

void rows_floor_rooms(struct pen_row_run *run)
{
    row_each(run, draw_inside, judge_inside);
}

/* ---- Outside ---- */

/* Three lights on the side of a wall, seen from `at` on its foot: low or high over the floor. */
static void add_lights_before(struct standing *s, vec3 at, vec3 edge, vec3 out)
{
    struct random *r = &s->r;
    for (int n = 0; n < 3; n++) {
        vec3 to = pen_along(out, edge, random_in(r, -1, 1));
        to.z = random_below(r, 3) ? gen_power(r, -6.3, 0) : 1;
        double far = fmax(gen_power(r, 1, 8), 2 * s->margin / to.z); /* above the floor */
        if (random_below(r, 2))
            kit_directional(&kit, pen_neg(body_turn(&s->pose, to)), pen_vec3(1, 1, 1));
        else
            kit_point(&kit, put(s, pen_along(at, to, far)), pen_vec3(1, 1, 1));
    }
}

static int different_pixels(void)
{
    int count = 0;
    for (int p = 0; p < SIDE * SIDE; p++)
        count += film[3 * p] != other[3 * p];
    return count;
}

/* Nothing but a wall near its foot and the floor before it is seen, and neither shades the
 * other. */
static void judge_foot(const struct row_case *c, struct row_verdict *v)
{
    struct standing s;
    make_standing(c, &s);
    begin_picture(&s);
    add_both(&s);
    struct random *r = &s.r;
    kit.settings.max_depth = 1;
    int i = (int)random_below(r, (uint32_t)s.walls), k = (i + 1) % s.walls;
    vec3 edge = pen_normalize(pen_sub(s.foot[k], s.foot[i]));
    vec3 out = pen_cross(edge, pen_vec3(0, 0, 1));
    vec3 at = pen_along(s.foot[i], pen_sub(s.foot[k], s.foot[i]), random_in(r, .3, .7));
    add_lights_before(&s, at, edge, out);
    vec3 eye = pen_along(pen_along(at, out, gen_power(r, -1, 1)), edge, random_in(r, -.1, .1));
    eye.z = s.high * random_in(r, .1, .9);
    shot_look(&kit, put(&s, eye), put(&s, at), s.window * s.size);
    shot_take(&kit, film);
    for (int n = 0; n < 3; n++)
        kit.lights[n].shadows = false;
    shot_take(&kit, other);
    row_measure(v, "pixels shaded at the foot of a wall", different_pixels(), 0);
    row_measure(v, "lit pixels at the foot of a wall", shot_lit(film), -1);
}

static void draw_foot(struct row_draw *d, struct row_case *c)
{
    draw_floor(d, c, -1);
}

void rows_floor_foot(struct pen_row_run *run)
{
    row_each(run, draw_foot, judge_foot);
}
