/* SPDX-License-Identifier: MIT */
/* Closed rooms with round, dented and shallow walls, and round things on a floor. They are seen
 * from so near that the whole picture is within rounding of a seam. */
#include <math.h>

#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

static struct kit kit;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

/* The frame of a scene of one case: a point is put(x, y, z). */
struct place {
    struct random r;
    vec3 x, y, z, o;
    double size, window;
    int material;
};

static vec3 put(const struct place *at, double x, double y, double z)
{
    vec3 v = pen_along(pen_along(pen_scale(at->x, x), at->y, y), at->z, z);
    return pen_along(at->o, v, at->size);
}

/* A point at an angle about the axis z. */
static vec3 around(const struct place *at, double radius, double angle, double z)
{
    return put(at, radius * cos(angle), radius * sin(angle), z);
}

/* Arguments: kind of scene, seed, size, offset in sizes, the window in sizes. */
static void draw_place(struct row_draw *d, struct row_case *c, uint32_t kinds, double window)
{
    struct random *r = &d->random;
    double offset = random_below(r, 2) ? 0 : gen_power(r, 0, 9);
    row_fixed(c, (double)(d->index % kinds));
    row_fixed(c, (double)(random_bits(r) >> 40));
    row_fixed(c, random_below(r, 2) ? 1 : gen_power(r, -8, 8));
    row_fixed(c, offset);
    row_fixed(c, gen_power(r, -12, window));
}

static struct place begin_place(const struct row_case *c)
{
    struct place at = {.r = {(uint64_t)c->arg[1] * 0x9e3779b97f4a7c15u + 74, 0}};
    vec3 n = random_below(&at.r, 3) ? random_direction(&at.r) : pen_vec3(0, 0, 1);
    gen_frame(&at.r, n, &at.x, &at.y);
    at.z = n;
    at.size = c->arg[2];
    at.o = gen_offset3(c->arg[3] * c->arg[2]);
    at.window = c->arg[4] * at.size;
    shot_begin(&kit);
    kit.settings.light_samples = 4;
    kit.settings.max_depth = 3;
    kit.settings.min_contribution = 0;
    struct pen_material m = kit_matte(.5);
    m.kr = pen_vec3(.5, .5, .5);
    at.material = kit_material(&kit, m);
    return at;
}

/* Takes the picture of the inside, with light everywhere outside. */
static void take_black(struct place *at, vec3 eye, vec3 seam, struct row_verdict *v)
{
    kit.desc.background = pen_vec3(1, 1, 1);
    kit_directional(&kit, random_direction(&at->r), pen_vec3(1, 1, 1));
    vec3 far = pen_scale(random_direction(&at->r), random_in(&at->r, 5, 50) * at->size);
    kit_point(&kit, pen_add(at->o, far), pen_vec3(1, 1, 1));
    vec3 near = pen_scale(random_direction(&at->r), 6 * at->size);
    kit_point(&kit, pen_add(at->o, near), pen_vec3(1, 1, 1))->radius = at->size;
    shot_look(&kit, eye, seam, at->window);
    row_measure(v, "shadow rays of a case", shot_take(&kit, film), -1);
}

/* The same, which must be black. */
static void judge_black(struct place *at, vec3 eye, vec3 seam, const char *name,
                        struct row_verdict *v)
{
    take_black(at, eye, seam, v);
    row_measure(v, name, shot_lit(film), 0);
}

/* ---- rooms with round walls ---- */

enum round_room {
    ROUND_QUADS,     /* an open cylinder between quads */
    ROUND_NGONS,     /* the same between polygons of many corners, a little wider */
    ROUND_LIDS,      /* the same between cylinders of the same radius */
    ROUND_WIDE_LIDS, /* the same between wider cylinders */
    ROUND_ROOFS,     /* the same between open cones */
    ROUND_PENCIL,    /* the same between closed cones */
    ROUND_STACKED,   /* two open cylinders, one on the other, between quads */
    ROUND_SPINDLE,   /* two open cones, base on base */
    ROUND_FRUSTUM,   /* an open truncated cone between quads */
    ROUND_COUNT
};

static void add_cylinder(const struct place *at, double z, double radius, double high, bool caps)
{
    vec3 axis = high < 0 ? pen_neg(at->z) : at->z;
    kit_cylinder(&kit, put(at, 0, 0, z), axis, radius * at->size, fabs(high) * at->size,
                 at->material)
        ->u.cylinder.caps = caps;
}

/* From z up, or down if high < 0. */
static void add_cone(const struct place *at, double z, double radius, double top, double high,
                     bool caps)
{
    vec3 axis = high < 0 ? pen_neg(at->z) : at->z;
    struct pen_object_desc *o = kit_cylinder(&kit, put(at, 0, 0, z), axis, radius * at->size,
                                             fabs(high) * at->size, at->material);
    o->kind = PEN_OBJECT_CONE;
    o->u.cone.base = put(at, 0, 0, z);
    o->u.cone.axis = axis;
    o->u.cone.radius = radius * at->size;
    o->u.cone.top_radius = top * at->size;
    o->u.cone.height = fabs(high) * at->size;
    o->u.cone.caps = caps;
}

static void add_ngon(const struct place *at, int n, double radius, double z)
{
    vec3 v[64];
    for (int i = 0; i < n; i++)
        v[i] = around(at, radius, 2 * pi * i / n, z);
    kit_polygon(&kit, v, (uint32_t)n, at->material);
}

/* A lid at z; if it has a height, it reaches to z + high. */
static void add_lid(const struct place *at, enum round_room room, double radius, double z,
                    double high)
{
    if (room == ROUND_NGONS)
        add_ngon(at, 60, 1.01 * radius, z);
    else if (room == ROUND_LIDS)
        add_cylinder(at, z, radius, high, true);
    else if (room == ROUND_WIDE_LIDS)
        add_cylinder(at, z, 1.5 * radius, high, true);
    else if (room == ROUND_ROOFS || room == ROUND_SPINDLE)
        add_cone(at, z, radius, 0, high, false);
    else if (room == ROUND_PENCIL)
        add_cone(at, z, radius, 0, high, true);
    else
        add_ngon(at, 4, 2 * radius, z);
}

static const char *const round_name[ROUND_COUNT] = {
    "lit pixels between quads",      "lit pixels between polygons",
    "lit pixels between cylinders",  "lit pixels between wider cylinders",
    "lit pixels between open cones", "lit pixels between closed cones",
    "lit pixels at a joint",         "lit pixels of two open cones",
    "lit pixels of an open cone",
};

/* Cylinders of equal radius share no numbers, nor does a base with its floor: far from the origin
 * of the document they are rounded apart, so that there is a gap. The picture then warns. */
static void judge_gap(const struct row_case *c, int wrong, const char *name, struct row_verdict *v)
{
    if (wrong > 0 && c->arg[3] > 0 && shot_warns(&kit)) {
        row_tally(v, "with the warning: a gap between surfaces that rounding has moved apart");
        wrong = 0;
    }
    row_measure(v, name, wrong, 0);
}

/* Whether the room has a round lid, or neighbour, of the cylinder's own radius. */
static bool has_equal_radii(enum round_room room)
{
    return room == ROUND_LIDS || room == ROUND_PENCIL || room == ROUND_STACKED;
}

static void draw_round(struct row_draw *d, struct row_case *c)
{
    draw_place(d, c, ROUND_COUNT, -3);
    if (has_equal_radii((enum round_room)c->arg[0]))
        c->arg[3] = 0; /* elsewhere rounding puts equal cylinders beside each other */
}

/* Turns the axis to that of the document: the middle of a lid then is that of the rim below, bit
 * for bit. Elsewhere they are rounded apart, and a camera ray may pass between them. */
static void stand_upright(struct place *at)
{
    at->z = pen_vec3(0, 0, 1);
    gen_frame(&at->r, at->z, &at->x, &at->y);
}

static void judge_round(const struct row_case *c, struct row_verdict *v)
{
    enum round_room room = (enum round_room)c->arg[0];
    struct place at = begin_place(c);
    if (room == ROUND_PENCIL)
        stand_upright(&at);
    double radius = random_in(&at.r, .5, 1), high = random_in(&at.r, .5, 2), angle, seam = high;
    double top = room == ROUND_FRUSTUM ? .6 * radius : radius, up = random_below(&at.r, 2);
    if (room == ROUND_SPINDLE)
        high = 0;
    else if (room == ROUND_FRUSTUM)
        add_cone(&at, 0, radius, top, high, false);
    else
        add_cylinder(&at, 0, radius, room == ROUND_STACKED ? .5 * high : high, false);
    if (room == ROUND_STACKED)
        add_cylinder(&at, .5 * high, radius, .5 * high, false);
    add_lid(&at, room, radius, 0, -random_in(&at.r, .1, 1));
    add_lid(&at, room, top, high, random_in(&at.r, .1, 1));
    angle = random_in(&at.r, 0, 2 * pi);
    seam = room == ROUND_STACKED ? .5 * high : up * high;
    double reach = up > 0 ? top : radius;
    vec3 eye = around(&at, random_in(&at.r, 0, .4) * top, random_in(&at.r, 0, 7),
                      high * random_in(&at.r, .2, .8));
    vec3 aim = around(&at, reach, angle, seam);
    if (!has_equal_radii(room)) {
        judge_black(&at, eye, aim, round_name[room], v);
        return;
    }
    take_black(&at, eye, aim, v);
    judge_gap(c, shot_lit(film), round_name[room], v);
}

void rows_round_rooms(struct pen_row_run *run)
{
    row_each(run, draw_round, judge_round);
}

static void draw_beside(struct row_draw *d, struct row_case *c)
{
    static const enum round_room room[] = {ROUND_LIDS, ROUND_PENCIL, ROUND_STACKED};
    draw_place(d, c, 3, -3);
    c->arg[0] = room[(int)c->arg[0]];
}

void rows_round_beside(struct pen_row_run *run)
{
    row_each(run, draw_beside, judge_round);
}

/* ---- from outside: surfaces that end at a common rim do not shade each other ---- */

/* The closed rooms above that are convex and share the numbers of their rims. */
static const enum round_room convex_room[] = {ROUND_QUADS, ROUND_ROOFS, ROUND_SPINDLE,
                                              ROUND_FRUSTUM};

static const char *const lid_name[] = {
    "shaded pixels of a quad on an open cylinder", "shaded pixels of open cones on a cylinder",
    "shaded pixels of two open cones", "shaded pixels of quads on an open cone"};

static void draw_lid(struct row_draw *d, struct row_case *c)
{
    draw_place(d, c, sizeof convex_room / sizeof *convex_room, -7);
    c->arg[3] = 0;
}

/* The light of all three suns on a face whose normal at the seam is n, not normalised. */
static double lit_face(vec3 n)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double cosine = -pen_dot(pen_normalize(kit.lights[i].direction), pen_normalize(n));
        sum += cosine > 0 ? .5 * cosine : 0;
    }
    return sum;
}

/* The pixels of `film` that are not as in `other`, which has no shadows. A pixel that is not as
 * bright as either face there shows a rim from behind, where it reaches out by its rounding: what
 * shades that is not judged. */
static int shaded(const double face[2], struct row_verdict *v)
{
    int count = 0, behind = 0;
    for (int i = 0; i < SHOT_PIXELS; i++) {
        double seen = other[3 * i];
        bool outer = fabs(seen - face[0]) < 1e-5 || fabs(seen - face[1]) < 1e-5;
        behind += !outer && seen > 0;
        count += outer && film[3 * i] != other[3 * i];
    }
    row_measure(v, "pixels that show a rim from behind", behind, SHOT_SIDE);
    return count;
}

/* The normal of a side that narrows by `in` over a height of `high`, which may be negative; not
 * normalised. */
static vec3 side_normal(const struct place *at, double angle, double in, double high)
{
    vec3 away = pen_along(pen_scale(at->x, cos(angle)), at->y, sin(angle));
    return pen_along(pen_scale(away, fabs(high)), at->z, high < 0 ? -in : in);
}

static void judge_lid(const struct row_case *c, struct row_verdict *v)
{
    struct place at = begin_place(c);
    enum round_room room = convex_room[(int)c->arg[0]];
    double radius = random_in(&at.r, .5, 1), high = random_in(&at.r, .5, 2);
    double angle = random_in(&at.r, 0, 2 * pi), top = radius;
    double low = -random_in(&at.r, .1, 1), up = random_in(&at.r, .1, 1), face[2];
    if (room == ROUND_SPINDLE)
        high = 0;
    else if (room == ROUND_FRUSTUM)
        add_cone(&at, 0, radius, top = .6 * radius, high, false);
    else
        add_cylinder(&at, 0, radius, high, false);
    add_lid(&at, room, radius, 0, low);
    add_lid(&at, room, top, high, up);
    kit.settings.max_depth = 1;
    for (int i = 0; i < 3; i++) {
        double turn = random_in(&at.r, 0, 2 * pi), rise = i ? gen_power(&at.r, -6.5, 0) : 1;
        vec3 flat = pen_along(pen_scale(at.x, cos(turn)), at.y, sin(turn));
        kit_directional(&kit, pen_neg(pen_along(flat, at.z, rise)), pen_vec3(1, 1, 1));
    }
    vec3 eye = around(&at, 5, angle + random_in(&at.r, -.5, .5), high + random_in(&at.r, .5, 5));
    shot_look(&kit, eye, around(&at, top, angle, high), at.window);
    shot_take(&kit, film);
    bool cones = room == ROUND_ROOFS || room == ROUND_SPINDLE;
    face[0] = lit_face(cones ? side_normal(&at, angle, top, up) : at.z);
    face[1] = lit_face(room == ROUND_SPINDLE ? side_normal(&at, angle, top, low)
                                             : side_normal(&at, angle, radius - top, high));
    for (int i = 0; i < 3; i++)
        kit.lights[i].shadows = false;
    shot_take(&kit, other);
    row_measure(v, lid_name[(int)c->arg[0]], shaded(face, v), 0);
}

void rows_round_lid(struct pen_row_run *run)
{
    row_each(run, draw_lid, judge_lid);
}

/* ---- rooms with dents, and shallow ones ---- */

enum dented_room {
    DENTED_STAR,   /* a prism over a star */
    DENTED_FOLDED, /* a box with a dent or a bulge in each face */
    DENTED_BALL,   /* a ball of triangles with corners at random depths */
    SHALLOW_PRISM, /* a prism over a polygon of many corners, perhaps thin */
    SHALLOW_LENS,  /* two low pyramids over such a polygon */
    SHALLOW_LOW_PRISM,
    DENTED_COUNT
};

struct edge {
    vec3 from, to;
};

static void add_triangle(struct place *at, vec3 a, vec3 b, vec3 c)
{
    bool turn = random_below(&at->r, 2);
    kit_triangle(&kit, a, turn ? c : b, turn ? b : c, at->material);
}

static void add_wall(struct place *at, vec3 a, vec3 b, vec3 c, vec3 d)
{
    const vec3 v[4] = {a, b, c, d};
    kit_polygon(&kit, v, 4, at->material);
}

/* A prism over an outline around the axis, every second corner at `dent` of the radius. */
static struct edge add_prism(struct place *at, int n, double dent, double high)
{
    vec3 low[64], top[64];
    for (int i = 0; i < n; i++) {
        low[i] = around(at, i & 1 ? dent : 1, 2 * pi * i / n, -high);
        top[i] = around(at, i & 1 ? dent : 1, 2 * pi * i / n, high);
    }
    for (int i = 0; i < n; i++)
        add_wall(at, low[i], low[(i + 1) % n], top[(i + 1) % n], top[i]);
    kit_polygon(&kit, low, (uint32_t)n, at->material);
    kit_polygon(&kit, top, (uint32_t)n, at->material);
    uint32_t i = random_below(&at->r, (uint32_t)n), k = (i + 1) % (uint32_t)n;
    switch (random_below(&at->r, 3)) {
    case 0:
        return (struct edge){low[i], low[k]};
    case 1:
        return (struct edge){top[i], top[k]};
    default:
        return (struct edge){low[i], top[i]};
    }
}

static struct edge add_lens(struct place *at, int n, double high)
{
    vec3 rim[64], tip[2] = {put(at, 0, 0, -high), put(at, 0, 0, high)};
    for (int i = 0; i < n; i++)
        rim[i] = around(at, 1, 2 * pi * i / n, 0);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 2; k++)
            add_triangle(at, rim[i], rim[(i + 1) % n], tip[k]);
    uint32_t i = random_below(&at->r, (uint32_t)n), k = (i + 1) % (uint32_t)n;
    if (random_below(&at->r, 2))
        return (struct edge){rim[i], rim[k]};
    return (struct edge){rim[i], tip[random_below(&at->r, 2)]};
}

static vec3 cube_corner(const struct place *at, int face, int c, double depth)
{
    double p[3];
    p[face / 2] = (face & 1 ? 1 : -1) * (c < 4 ? 1 : depth);
    p[(face / 2 + 1) % 3] = c == 4 ? 0 : c == 1 || c == 2 ? 1 : -1;
    p[(face / 2 + 2) % 3] = c == 4 ? 0 : c >= 2 ? 1 : -1;
    return put(at, p[0], p[1], p[2]);
}

static struct edge add_folded(struct place *at)
{
    struct edge seam = {{0, 0, 0}, {0, 0, 0}};
    uint32_t chosen = random_below(&at->r, 24);
    bool rim = random_below(&at->r, 2);
    for (int face = 0; face < 6; face++) {
        double depth = random_in(&at->r, .7, 1.3);
        vec3 tip = cube_corner(at, face, 4, depth);
        for (int c = 0; c < 4; c++) {
            vec3 a = cube_corner(at, face, c, 0), b = cube_corner(at, face, (c + 1) % 4, 0);
            add_triangle(at, a, b, tip);
            if ((uint32_t)(4 * face + c) == chosen)
                seam = (struct edge){a, rim ? b : tip};
        }
    }
    return seam;
}

static struct edge add_ball(struct place *at)
{
    enum { STACKS = 6, SLICES = 8 };
    vec3 grid[STACKS + 1][SLICES];
    for (int i = 0; i <= STACKS; i++)
        for (int j = 0; j < SLICES; j++) {
            double theta = pi * i / STACKS, phi = 2 * pi * j / SLICES;
            double size = random_in(&at->r, 1, 1.3), s = i % STACKS ? size * sin(theta) : 0;
            grid[i][j] = put(at, s * cos(phi), s * sin(phi), size * cos(theta));
            if (i % STACKS == 0)
                grid[i][j] = grid[i][0];
        }
    for (int i = 0; i < STACKS; i++)
        for (int j = 0; j < SLICES; j++) {
            int k = (j + 1) % SLICES;
            if (i < STACKS - 1)
                add_triangle(at, grid[i][j], grid[i + 1][j], grid[i + 1][k]);
            if (i > 0)
                add_triangle(at, grid[i][j], grid[i + 1][k], grid[i][k]);
        }
    uint32_t i = random_below(&at->r, STACKS), j = random_below(&at->r, SLICES);
    return (struct edge){grid[i][j], grid[i + 1][(j + random_below(&at->r, 2)) % SLICES]};
}

static void draw_dented(struct row_draw *d, struct row_case *c)
{
    draw_place(d, c, DENTED_COUNT, -3);
}

static struct edge make_dented(struct place *at, enum dented_room room, double *high)
{
    static const int corners[] = {6, 8, 16, 64};
    int n = corners[random_below(&at->r, 4)];
    *high = 1;
    switch (room) {
    case DENTED_STAR:
        return add_prism(at, n, random_in(&at->r, .5, .95), 1);
    case DENTED_FOLDED:
        return add_folded(at);
    case DENTED_BALL:
        return add_ball(at);
    case SHALLOW_PRISM:
        return add_prism(at, n, 1, 1);
    case SHALLOW_LENS:
        *high = gen_power(&at->r, -6, 0);
        return add_lens(at, n, *high);
    case SHALLOW_LOW_PRISM:
    case DENTED_COUNT:
        break;
    }
    *high = gen_power(&at->r, -6, 0);
    return add_prism(at, n, 1, *high);
}

static const char *const dented_name[DENTED_COUNT] = {
    "lit pixels in a star",  "lit pixels in a folded box", "lit pixels in a ball",
    "lit pixels in a prism", "lit pixels in a lens",       "lit pixels in a low prism",
};

static void judge_dented(const struct row_case *c, struct row_verdict *v)
{
    struct place at = begin_place(c);
    double high;
    struct edge e = make_dented(&at, (enum dented_room)c->arg[0], &high);
    double share = random_below(&at.r, 3) ? random_unit(&at.r) : random_below(&at.r, 2);
    vec3 seam = pen_along(e.from, pen_sub(e.to, e.from), share);
    vec3 eye = around(&at, random_in(&at.r, 0, .2), random_in(&at.r, 0, 7),
                      high * random_in(&at.r, -.3, .3));
    judge_black(&at, eye, seam, dented_name[(int)c->arg[0]], v);
}

void rows_dented_rooms(struct pen_row_run *run)
{
    row_each(run, draw_dented, judge_dented);
}

/* ---- the foot of something round on a floor, the light behind it ---- */

enum foot { FOOT_CLOSED, FOOT_OPEN, FOOT_CONE, FOOT_OPEN_CONE, FOOT_COUNT };

static void draw_foot(struct row_draw *d, struct row_case *c)
{
    draw_place(d, c, FOOT_COUNT, -7);
}

static bool is_open(enum foot foot)
{
    return foot == FOOT_OPEN || foot == FOOT_OPEN_CONE;
}

static bool is_straight(enum foot foot)
{
    return foot == FOOT_CLOSED || foot == FOOT_OPEN;
}

static void add_floor(struct place *at)
{
    if (random_below(&at->r, 2))
        kit_plane(&kit, at->o, at->z, at->material);
    else
        add_ngon(at, 4, 100, 0);
}

/* A cylinder, or a cone whose radius at the top is `top` times that of its foot. */
static void add_foot(const struct place *at, enum foot foot, double radius, double top)
{
    if (is_straight(foot))
        add_cylinder(at, 0, radius, 4, !is_open(foot));
    else
        add_cone(at, 0, radius, top * radius, 4, !is_open(foot));
}

/* A sun, and a lamp of that radius in the same direction. */
static void add_lights(const struct place *at, double turn, double slope, double radius)
{
    vec3 flat = pen_along(pen_scale(at->x, cos(turn)), at->y, sin(turn));
    kit_directional(&kit, pen_neg(pen_along(flat, at->z, slope)), pen_vec3(1, 1, 1));
    vec3 lamp = put(at, 20 * cos(turn), 20 * sin(turn), 20 * slope);
    kit_point(&kit, lamp, pen_vec3(1, 1, 1))->radius = radius * at->size;
}

/* Takes the picture of the foot, and that without shadows. The eye is `up` over the floor. */
static void take_foot(struct place *at, double radius, double angle, double aside, double up)
{
    kit.settings.max_depth = 1;
    shot_look(&kit, around(at, 6, angle + aside, up), around(at, radius, angle, 0), at->window);
    shot_take(&kit, film);
    kit.lights[0].shadows = kit.lights[1].shadows = false;
    shot_take(&kit, other);
}

static void judge_foot(const struct row_case *c, struct row_verdict *v)
{
    struct place at = begin_place(c);
    enum foot foot = (enum foot)c->arg[0];
    double angle = random_in(&at.r, 0, 2 * pi), radius = random_in(&at.r, .5, 1);
    bool straight = is_straight(foot);
    add_floor(&at);
    add_foot(&at, foot, radius, straight || random_below(&at.r, 2) ? 1.5 : .8);
    /* Behind the foot as seen from the axis. A narrowing cone's side must not see it. */
    double slope = straight ? gen_power(&at.r, -1, .5) : random_in(&at.r, .1, .9);
    double turn = angle + pi + (straight ? 1.3 : .8) * random_in(&at.r, -1, 1);
    add_lights(&at, turn, slope, 1);
    double aside = random_in(&at.r, -.5, .5), up = gen_power(&at.r, -2, .7);
    take_foot(&at, radius, angle, aside, up);
    if (shot_lit(other) == 0) {
        row_skip(v);
        return;
    }
    static const char *const name[FOOT_COUNT] = {
        "lit pixels at a cylinder", "lit pixels at an open cylinder", "lit pixels at a cone",
        "lit pixels at an open cone"};
    row_measure(v, name[foot], shot_lit(film), 0);
}

/* The same with the light before it: foot and floor are as without shadows. Something closed is
 * looked at from a sine of 1/8 and more over the floor, see "Where it ends" in
 * src/geom/SELF_INTERSECTION.md. */
static void judge_front(const struct row_case *c, struct row_verdict *v)
{
    struct place at = begin_place(c);
    enum foot foot = (enum foot)c->arg[0];
    double angle = random_in(&at.r, 0, 2 * pi), radius = random_in(&at.r, .5, 1);
    add_floor(&at);
    add_foot(&at, foot, radius, is_straight(foot) ? 1 : random_in(&at.r, 0, .9));
    double turn = angle + 1.5 * random_in(&at.r, -1, 1), slope = gen_power(&at.r, -6, .5);
    add_lights(&at, turn, slope, random_below(&at.r, 2) ? 0 : .01 * slope);
    double up = gen_power(&at.r, is_open(foot) ? -2 : -.1, .7), aside = random_in(&at.r, -.5, .5);
    take_foot(&at, radius, angle, aside, up);
    int differ = 0;
    for (int i = 0; i < SHOT_PIXELS; i++)
        differ += film[3 * i] != other[3 * i];
    static const char *const name[FOOT_COUNT] = {
        "shaded pixels before a cylinder", "shaded pixels before an open cylinder",
        "shaded pixels before a cone", "shaded pixels before an open cone"};
    if (is_open(foot))
        row_measure(v, name[foot], differ, 0);
    else
        judge_gap(c, differ, name[foot], v);
}

void rows_round_front(struct pen_row_run *run)
{
    row_each(run, draw_foot, judge_front);
}

void rows_round_foot(struct pen_row_run *run)
{
    row_each(run, draw_foot, judge_foot);
}
