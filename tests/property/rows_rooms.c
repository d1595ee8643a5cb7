/* SPDX-License-Identifier: MIT */
/* Rooms closed by surfaces of every kind, with mirrors and highlights. The lights are outside,
 * where rounding decides: near walls, in their planes, tangent to round walls. The rooms are
 * black. */
#include <math.h>
#include <stdlib.h>

#include "property/body.h"
#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

enum { SIDE = 16 };

static struct kit kit;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

/* A case. All that is not here follows from the seed. */
struct room {
    double kind, size, offset, thin, window, near, depth, lights, furniture, seed;
};

static void draw_any(struct row_draw *d, struct row_case *c, int first, int last, double thin)
{
    struct random *r = &d->random;
    row_fixed(c, first + (double)(d->index % (uint64_t)(last - first + 1)));
    row_fixed(c, gen_power(r, -8, 8));
    row_fixed(c, gen_offset(r));
    row_fixed(c, thin);
    row_fixed(c, gen_power(r, -14, .5));   /* the window, in sizes */
    row_fixed(c, gen_power(r, -10, 0));    /* the eye from a wall, as a share of the way to it */
    row_fixed(c, 1 + random_below(r, 10)); /* surfaces in a path */
    row_fixed(c, 7);                       /* which of three lights there are */
    row_fixed(c, random_below(r, 3) == 0); /* things in the room */
    row_fixed(c, (double)(random_bits(r) >> 40));
}

static struct room read_room(const struct row_case *c)
{
    int i = 0;
    struct room m;
    m.kind = row_next(c, &i);
    m.size = row_next(c, &i);
    m.offset = row_next(c, &i);
    m.thin = row_next(c, &i);
    m.window = row_next(c, &i);
    m.near = row_next(c, &i);
    m.depth = row_next(c, &i);
    m.lights = row_next(c, &i);
    m.furniture = row_next(c, &i);
    m.seed = row_next(c, &i);
    return m;
}

static double pick(struct random *r, double a, double b, double c)
{
    double of[3] = {a, b, c};
    return of[random_below(r, 3)];
}

static struct pen_material draw_material(struct random *r)
{
    struct pen_material m = kit_matte(pick(r, 0, .5, 1));
    double ks = pick(r, 0, .5, 1), kr = pick(r, 0, .5, 1);
    m.ks = pen_vec3(ks, ks, ks);
    m.kr = pen_vec3(kr, kr, kr);
    m.shininess = random_below(r, 4) ? pick(r, 1, 10, 200) : random_in(r, 0, 3);
    return m;
}

/* ---- Lights outside ---- */

/* A direction that lies in the tangent plane at a place of the surface, or nearly so. */
static vec3 tangent(const struct body *b, struct random *r, vec3 *p, vec3 *n)
{
    static const double degrees[] = {0, 90, 180, 32};
    vec3 x, y;
    *p = body_surface(b, r, n);
    gen_frame(r, *n, &x, &y);
    if (random_below(r, 2)) { /* along an edge, a wall, the axis */
        vec3 e = pen_sub(b->kind <= BODY_LAST_CROSSING ? b->v[random_below(r, 8) % 4] : *p, *p);
        e = pen_along(e, *n, -pen_dot(e, *n));
        vec3 u = random_below(r, 2) && pen_norm1(e) > 1e-3 ? e : pen_cross(*n, pen_vec3(0, 0, 1));
        if (pen_norm1(u) > 1e-3) {
            double s, k, a = degrees[random_below(r, 4)] * pi / 180;
            s = sin(a);
            k = cos(a);
            u = pen_normalize(u);
            x = pen_along(pen_scale(u, k), pen_cross(*n, u), s);
        }
    }
    double tilt = random_below(r, 3) ? gen_power(r, -17, -6) : 0;
    return pen_along(x, *n, random_below(r, 2) ? tilt : -tilt);
}

static void add_directional(const struct body *b, const struct body_pose *pose, struct random *r)
{
    vec3 p, n, d = random_direction(r);
    if (random_below(r, 4))
        d = tangent(b, r, &p, &n);
    struct pen_light_desc *light =
        kit_directional(&kit, pen_neg(body_turn(pose, d)), pen_vec3(1, 1, 1));
    if (random_below(r, 3) == 0)
        light->angular_radius = random_below(r, 2) ? gen_power(r, -8, 1.9) : 1;
}

/* A place outside: anywhere, beside a wall, in a wall's tangent plane, just above that and behind
 * another wall, beside a seam. */
static vec3 place_outside(const struct body *b, struct random *r)
{
    vec3 p, n, dir = body_direction(b, r);
    uint32_t how = random_below(r, 5);
    if (how == 0)
        return pen_scale(dir, body_reach(b, dir) * (1 + gen_power(r, -3, 4)));
    if (how == 1)
        return pen_scale(dir, body_reach(b, dir) * (1 + gen_power(r, -12, -1)));
    if (how == 2)
        return pen_scale(body_seam(b, r), 1 + gen_power(r, -12, 1));
    vec3 along = tangent(b, r, &p, &n);
    p = pen_along(p, along, random_below(r, 2) ? gen_power(r, 2, 8) : gen_power(r, -1, 1));
    return pen_along(p, n, how == 3 ? 0 : -gen_power(r, -14, -6));
}

/* Whether a place stays outside, with `far` between, however it is rounded. Between the faces of a
 * thick wall it is outside the room too, but not beside one of the faces. */
static bool stays_outside(const struct body *b, const struct body_pose *pose, vec3 p, double far)
{
    double need = 4 * body_rounding(pose) + 64 * 0x1p-53 * pen_norm1(p);
    if (b->kind == BODY_THICK) {
        double t = b->over;
        vec3 q = pen_vec3(fabs(p.x), fabs(p.y), fabs(p.z)), h = b->half;
        double to[6] = {q.x - h.x,     q.y - h.y,     q.z - h.z,
                        q.x - h.x - t, q.y - h.y - t, q.z - h.z - t};
        for (int i = 0; i < 6; i++)
            if (fabs(to[i]) < need)
                return false;
    }
    /* on a sheet or lid, at the foot of the wall outside */
    if (b->kind > BODY_LAST_ROUND && fabs(fabs(p.z) - b->h) < need + far)
        return false;
    return -body_depth(b, p) > need + far;
}

static void add_positional(const struct body *b, const struct body_pose *pose, struct random *r)
{
    vec3 p = place_outside(b, r), one = pen_vec3(1, 1, 1);
    bool spot = random_below(r, 4) == 0, soft = random_below(r, 3) == 0;
    double radius = soft ? random_in(r, .1, .9) * fmax(0, -body_depth(b, p)) : 0;
    if (!stays_outside(b, pose, p, radius))
        return;
    vec3 at = body_place(pose, p), to = body_turn(pose, pen_neg(p));
    struct pen_light_desc *light = spot ? kit_spot(&kit, at, to, one) : kit_point(&kit, at, one);
    light->beam_exponent = pick(r, 0, 1, 10);
    light->radius = radius * pose->size;
}

static void add_lights(const struct body *b, const struct body_pose *pose, struct random *r,
                       int which)
{
    for (int i = 0; i < 3; i++) {
        struct random own = {random_bits(r), 0};
        if (!(which >> i & 1))
            continue;
        if (random_below(&own, 2))
            add_directional(b, pose, &own);
        else
            add_positional(b, pose, &own);
    }
}

/* ---- Inside ---- */

/* Spheres, boxes and cylinders, some of them glass or resting on the walls' side of the room. */
static void add_furniture(const struct body *b, const struct body_pose *pose, struct random *r)
{
    for (int i = 0; i < 3; i++) {
        struct pen_material m = draw_material(r);
        if (random_below(r, 3) == 0)
            m.kt = pen_vec3(.5, .8, .5);
        int material = kit_material(&kit, m);
        vec3 dir = body_direction(b, r), axis = random_direction(r);
        double radius = b->thin * random_in(r, .1, .5), s = pose->size;
        vec3 p = body_place(pose, pen_scale(dir, random_in(r, .2, 1) * body_reach(b, dir)));
        if (random_below(r, 2))
            kit_sphere(&kit, p, s * radius, material);
        else
            kit_cylinder(&kit, p, axis, s * radius, 2 * s * radius, material);
    }
}

/* The eye, in the body's coordinates; false if rounding could put it outside. */
static bool place_eye(const struct body *b, const struct body_pose *pose, struct random *r,
                      double near, vec3 *eye)
{
    vec3 n, to = random_below(r, 2) ? body_seam(b, r) : body_surface(b, r, &n);
    double share = random_below(r, 2) ? near : random_in(r, .2, 1);
    *eye = pen_scale(to, 1 - share);
    return body_depth(b, *eye) > body_rounding(pose);
}

/* Makes the scene of a case; false if it is none. */
static bool make_room(const struct row_case *c)
{
    struct room m = read_room(c);
    struct random r = {(uint64_t)m.seed * 0x9e3779b97f4a7c15u + 73, 0};
    static struct body b;
    vec3 eye;
    body_make(&b, (enum body_kind)m.kind, &r, m.thin);
    if (m.offset > 0)
        body_overlap(&b);
    struct body_pose pose = body_pose(&r, m.size, m.offset);
    shot_begin(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.settings.light_samples = 4;
    kit.settings.max_depth = (int)m.depth;
    kit.settings.min_contribution = 0;
    kit.desc.background = pen_vec3(1, 1, 1);
    body_add(&b, &pose, &kit, kit_material(&kit, draw_material(&r)));
    struct random light_random = {random_bits(&r), 0}, furniture_random = {random_bits(&r), 0};
    add_lights(&b, &pose, &light_random, (int)m.lights);
    if (m.furniture > 0)
        add_furniture(&b, &pose, &furniture_random);
    vec3 at = body_seam(&b, &r);
    if (!place_eye(&b, &pose, &r, m.near, &eye) ||
        !(pen_norm1(pen_sub(body_place(&pose, at), body_place(&pose, eye))) > 0)) {
        return false;
    }
    shot_look(&kit, body_place(&pose, eye), body_place(&pose, at), m.window * m.size);
    return true;
}

/* Boxes that stand on each other share no corners. Far from the origin of the document these are
 * rounded, so that there are gaps between them: no room is closed then, and the picture warns. */
static void judge_room(const struct row_case *c, struct row_verdict *v)
{
    if (!make_room(c)) {
        row_skip(v);
        return;
    }
    double rays = shot_take(&kit, film);
    int lit = shot_lit(film);
    if (lit > 0 && read_room(c).kind == BODY_THICK && read_room(c).offset > 0 && shot_warns(&kit)) {
        row_tally(v, "lit, with the warning, between boxes that rounding has moved apart");
        lit = 0;
    }
    row_measure(v, "lit pixels in a closed room", lit, 0);
    row_measure(v, "shadow rays of a case", rays, -1);
}

static void draw_flat(struct row_draw *d, struct row_case *c)
{
    draw_any(d, c, 0, BODY_LAST_FLAT, 1);
}

void rows_rooms_flat(struct pen_row_run *run)
{
    row_each(run, draw_flat, judge_room);
}

static void draw_crossing(struct row_draw *d, struct row_case *c)
{
    draw_any(d, c, BODY_LAST_FLAT + 1, BODY_LAST_CROSSING, 1);
}

void rows_rooms_crossing(struct pen_row_run *run)
{
    row_each(run, draw_crossing, judge_room);
}

static void draw_round(struct row_draw *d, struct row_case *c)
{
    draw_any(d, c, BODY_LAST_CROSSING + 1, BODY_LAST_ROUND, 1);
}

void rows_rooms_round(struct pen_row_run *run)
{
    row_each(run, draw_round, judge_room);
}

static void draw_mixed(struct row_draw *d, struct row_case *c)
{
    draw_any(d, c, BODY_LAST_ROUND + 1, BODY_LAST_MIXED, 1);
}

void rows_rooms_mixed(struct pen_row_run *run)
{
    row_each(run, draw_mixed, judge_room);
}

/* Boxes and prisms of 2^-1 to 2^-30 of their width. */
static void draw_thin(struct row_draw *d, struct row_case *c)
{
    draw_any(d, c, BODY_BOX, BODY_SPLIT_PRISM, exp2(-1 - (double)(d->index / 4 % 30)));
    c->arg[2] = 0;
}

static void judge_thin(const struct row_case *c, struct row_verdict *v)
{
    static const char *const lit[] = {"lit at 2^-1 to 2^-5",   "lit at 2^-6 to 2^-10",
                                      "lit at 2^-11 to 2^-15", "lit at 2^-16 to 2^-20",
                                      "lit at 2^-21 to 2^-25", "lit at 2^-26 to 2^-30"};
    int k = (int)(-log2(c->arg[3]) - .5) / 5;
    judge_room(c, v);
    if (v->failed && k >= 0 && k < 6)
        row_tally(v, lit[k]);
}

void rows_rooms_thin(struct pen_row_run *run)
{
    row_each(run, draw_thin, judge_thin);
}

/* ---- The same bits in every way, also where everything lies within rounding ---- */

static int different_pixels(void)
{
    int count = 0;
    for (int i = 0; i < 3 * SHOT_PIXELS; i += 3)
        count += film[i] != other[i] || film[i + 1] != other[i + 1] || film[i + 2] != other[i + 2];
    return count;
}

static void draw_same(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    bool crossing = random_below(r, 2); /* where walls reach beyond the edge that is looked at */
    double thin = random_below(r, 4) ? 1 : 0x1p-8;
    draw_any(d, c, crossing ? BODY_CROSSING : 0, crossing ? BODY_CROSSING : BODY_LAST_MIXED, thin);
    if (random_below(r, 4))
        c->arg[4] = gen_power(r, -14, -11);
}

static void judge_same(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[] = {"pixels that differ with no accelerator",
                                       "pixels that differ with a list of boxes",
                                       "pixels that differ with median splits"};
    static const enum pen_accelerator kind[] = {PEN_ACCEL_NONE, PEN_ACCEL_CBR, PEN_ACCEL_MEDIAN};
    const char *isa = getenv("PENUMBRA_ISA");
    if (!make_room(c)) {
        row_skip(v);
        return;
    }
    kit.settings.width = kit.settings.height = SIDE / 2;
    if ((uint64_t)c->arg[9] & 1) /* a light inside, so that pictures are not only black */
        kit_point(&kit, pen_along(kit.view.camera.position, kit.view.camera.direction, .1),
                  pen_vec3(1, 1, 1))
            ->radius = (uint64_t)c->arg[9] & 2 ? .01 * c->arg[1] : 0;
    shot_take(&kit, film);
    for (int i = 0; i < 3; i++) {
        kit.settings.accelerator = (int)kind[i];
        shot_take(&kit, other);
        row_measure(v, name[i], different_pixels(), 0);
    }
    kit.settings.accelerator = PEN_ACCEL_AUTO;
    if (isa)
        return;
    setenv("PENUMBRA_ISA", "base", 1);
    shot_take(&kit, other);
    unsetenv("PENUMBRA_ISA");
    row_measure(v, "pixels that differ with base instructions", different_pixels(), 0);
}

void rows_rooms_same(struct pen_row_run *run)
{
    row_each(run, draw_same, judge_same);
}
