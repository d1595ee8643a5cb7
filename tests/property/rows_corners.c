/* SPDX-License-Identifier: MIT */
/* Corners of mirrors and of glass: a ray through the edge of two faces, or through a vertex, sees
 * what it sees beside it. All light depends only on the direction, and all faces are flat. So
 * parallel rays see equal values unless they meet other faces. */
#include <math.h>

#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

static struct kit kit;

enum { SIDES_MAX = 6, ASIDE = 64, ASIDE_FINE = 0x10000, BLOCK = 3, FACES_MAX = SIDES_MAX + 2 };

/* A prism in its own coordinates, about 1 in size, along z from -1 to 1, or half as long: the
 * corners of its base run counter-clockwise. */
struct prism {
    int sides;
    vec3 base[SIDES_MAX];
    double half;
    vec3 axis[3];
    double size, offset;
    double first; /* the first of its faces in the document; they run on from there */
    bool backward;
    bool turned;
};

struct corner_case {
    double kind, size, offset, turned, order, depth, seed, obtuse;
    double near; /* the eye from a wall, as a share of the way to the edge; 0: anywhere */
};

enum kind { WEDGE, CORNER, ROOM, ROOM_MIRRORED, GLASS, GLASS_OUTSIDE, KINDS };

static void draw_kinds(struct row_draw *d, struct row_case *c, int first, int count, bool moved,
                       bool obtuse)
{
    struct random *r = &d->random;
    row_fixed(c, first + (double)(d->index % (uint64_t)count));
    row_fixed(c, random_below(r, 2) ? 1 : gen_power(r, -8, 8));
    row_fixed(c, !moved || random_below(r, 4) ? 0 : random_below(r, 2) ? 1 : 1e3);
    row_fixed(c, random_below(r, 3) != 0);
    row_fixed(c, random_below(r, 64));
    row_fixed(c, 2 + random_below(r, 9));
    row_fixed(c, (double)(random_bits(r) >> 40));
    row_fixed(c, obtuse);
    row_fixed(c, 0);
}

static void draw(struct row_draw *d, struct row_case *c)
{
    draw_kinds(d, c, 0, KINDS, true, d->index / KINDS % 2);
}

/* Those that are seen directly. */
static void draw_direct(struct row_draw *d, struct row_case *c)
{
    draw_kinds(d, c, 0, ROOM + 1, false, false);
}

/* Those that may follow one another on a path, or that are far from the document's origin. */
static void draw_chained(struct row_draw *d, struct row_case *c)
{
    draw_kinds(d, c, ROOM, KINDS - ROOM, true, false);
}

static void draw_obtuse(struct row_draw *d, struct row_case *c)
{
    draw_kinds(d, c, 0, KINDS, false, true);
}

static void draw_rooms(struct row_draw *d, struct row_case *c)
{
    draw_kinds(d, c, ROOM, 1, false, d->index % 2);
    c->arg[c->count - 1] = gen_power(&d->random, -12, -1);
}

static struct corner_case read(const struct row_case *c)
{
    int i = 0;
    struct corner_case m;
    m.kind = row_next(c, &i);
    m.size = row_next(c, &i);
    m.offset = row_next(c, &i);
    m.turned = row_next(c, &i);
    m.order = row_next(c, &i);
    m.depth = row_next(c, &i);
    m.seed = row_next(c, &i);
    m.obtuse = row_next(c, &i);
    m.near = row_next(c, &i);
    return m;
}

static vec3 turn(const struct prism *p, vec3 v)
{
    return pen_along(pen_along(pen_scale(p->axis[0], v.x), p->axis[1], v.y), p->axis[2], v.z);
}

static vec3 place(const struct prism *p, vec3 v)
{
    return pen_scale(pen_add(turn(p, v), gen_offset3(p->offset)), p->size);
}

/* In degrees, up to 90 or above. */
static double any_angle(struct random *r, bool obtuse)
{
    static const double some[] = {90, 60, 45, 30, 36, 72, 22.5, 80}, more[] = {120, 135, 108, 150};
    if (obtuse)
        return random_below(r, 4) ? more[random_below(r, 4)] : random_in(r, 90, 150);
    return random_below(r, 4) ? some[random_below(r, 8)] : random_in(r, 3, 90);
}

/* The base: a square, a triangle with two or three equal sides; obtuse ones, a regular polygon. */
static void make_base(struct prism *p, struct random *r, bool obtuse)
{
    const double a = any_angle(r, obtuse) * pi / 360;
    p->sides = 3 + (int)random_below(r, 2) + 2 * obtuse;
    for (int i = 0; i < p->sides; i++) {
        const double at = 2 * pi * (i + .5 * (p->sides == 4)) / p->sides;
        p->base[i] = pen_vec3(cos(at) * sqrt(2), sin(at) * sqrt(2), 0);
        if (p->sides == 4)
            p->base[i] = pen_vec3(i == 0 || i == 3 ? 1 : -1, i < 2 ? 1 : -1, 0);
    }
    if (random_below(r, 3) == 0) {
        p->sides = 3;
        p->base[0] = pen_vec3(0, -sin(a), 0);
        p->base[1] = pen_vec3(cos(a), 0, 0);
        p->base[2] = pen_vec3(0, sin(a), 0);
    }
}

static void make_prism(struct prism *p, struct random *r, const struct corner_case *m)
{
    *p = (struct prism){.half = random_below(r, 2) ? 1 : .5,
                        .axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                        .size = m->size,
                        .offset = m->offset};
    make_base(p, r, m->obtuse > 0);
    if (m->turned > 0) {
        p->axis[2] = random_direction(r);
        gen_frame(r, p->axis[2], &p->axis[0], &p->axis[1]);
    }
}

static int faces(const struct prism *p)
{
    return p->sides + 2;
}

static vec3 face_normal(const struct prism *p, int i)
{
    if (i >= p->sides)
        return pen_vec3(0, 0, i == p->sides ? 1 : -1);
    const vec3 e = pen_sub(p->base[(i + 1) % p->sides], p->base[i]);
    return pen_normalize(pen_vec3(e.y, -e.x, 0));
}

static vec3 corner_of(const struct prism *p, int i, double z)
{
    return pen_vec3(p->base[i % p->sides].x, p->base[i % p->sides].y, z * p->half);
}

/* A point of the face, whatever its material is. */
static vec3 face_point(const struct prism *p, int i)
{
    return i >= p->sides ? pen_vec3(0, 0, i == p->sides ? p->half : -p->half) : corner_of(p, i, 1);
}

static void add_face(const struct prism *p, int i, int material, bool backward)
{
    vec3 v[SIDES_MAX];
    int count = i < p->sides ? 4 : p->sides;
    for (int k = 0; k < count; k++) {
        if (i < p->sides)
            v[k] = place(p, corner_of(p, i + (k == 1 || k == 2), k < 2 ? -1 : 1));
        else
            v[k] =
                place(p, corner_of(p, i == p->sides ? k : count - 1 - k, i == p->sides ? 1 : -1));
    }
    for (int k = 0; backward && k < count / 2; k++) {
        const vec3 swapped = v[k];
        v[k] = v[count - 1 - k];
        v[count - 1 - k] = swapped;
    }
    kit_polygon(&kit, v, (uint32_t)count, material);
}

static int any_mirror(struct random *r)
{
    struct pen_material m = kit_glow(random_unit(r), random_unit(r), random_unit(r));
    m.kr = pen_vec3(random_unit(r), random_in(r, .3, .9), random_below(r, 4) ? .8 : 1);
    return kit_material(&kit, m);
}

/* The faces, in the order and with the parities of a case. */
static void add_faces(const struct prism *p, struct random *r, const struct corner_case *m)
{
    const bool glass = m->kind >= GLASS;
    const int count = m->kind == WEDGE ? 2 : m->kind == CORNER ? 3 : faces(p);
    const int order = (int)m->order;
    struct pen_material clear = kit_matte(0);
    clear.kt = pen_vec3(1, 1, 1);
    clear.ior = random_below(r, 2) ? 1.5 : random_in(r, 1.1, 2.4);
    if (glass)
        kit_material(&kit, clear);
    for (int k = 0; k < count; k++) {
        int i = (order & 1 ? count - 1 - k : k) + order / 8;
        i %= count;
        if (count == 3 && i == 2)
            i = p->sides; /* a cap */
        const int material = glass ? 0 : any_mirror(r);
        if (m->kind == WEDGE || m->kind == CORNER)
            kit_plane(&kit, place(p, face_point(p, i)),
                      pen_scale(turn(p, face_normal(p, i)), order & 2 ? 1 : -1), material);
        else
            add_face(p, i, material, !glass && order & 4);
    }
}

/* A point of an edge of two faces that are there; sometimes a vertex. */
static vec3 edge_point(const struct prism *p, struct random *r, const struct corner_case *m)
{
    const int at = m->kind <= CORNER ? 1 : (int)random_below(r, (uint32_t)p->sides);
    const double z = random_below(r, 3)   ? random_below(r, 2) ? 0 : random_in(r, -1, 1)
                       : random_below(r, 2) ? 1
                                          : -1;
    vec3 e = corner_of(p, at, m->kind == CORNER && random_below(r, 2) ? 1 : z);
    if (m->kind >= ROOM && random_below(r, 3) == 0) { /* of a cap */
        const double k = random_below(r, 2) ? .5 : random_unit(r),
                     end = random_below(r, 2) ? 1 : -1;
        const vec3 a = corner_of(p, at, end), b = corner_of(p, at + 1, end);
        e = pen_along(a, pen_sub(b, a), k);
    }
    return e;
}

/* Whether a place is inside, and away from all faces. */
static bool is_inside(const struct prism *p, vec3 v)
{
    for (int i = 0; i < faces(p); i++)
        if (pen_dot(face_normal(p, i), pen_sub(face_point(p, i), v)) < 1e-3)
            return false;
    return true;
}

/* A place inside. */
static vec3 inside(const struct prism *p, struct random *r)
{
    vec3 v = pen_vec3(0, 0, random_below(r, 2) ? 0 : random_in(r, -.8, .8) * p->half);
    double sum = 0, weight[SIDES_MAX];
    const bool middle = random_below(r, 3) == 0;
    for (int i = 0; i < p->sides; i++)
        sum += weight[i] = middle ? 1 : random_in(r, .05, 1);
    for (int i = 0; i < p->sides; i++)
        v = pen_along(v, p->base[i], weight[i] / sum);
    return v;
}

/* Where a ray from inside leaves; *n is the outward normal there. */
static vec3 leave(const struct prism *p, vec3 o, vec3 d, vec3 *n)
{
    double first = INFINITY;
    for (int i = 0; i < faces(p); i++) {
        const vec3 m = face_normal(p, i);
        const double dm = pen_dot(m, d), t = pen_dot(m, pen_sub(face_point(p, i), o)) / dm;
        if (dm > 0 && t < first) {
            first = t;
            *n = m;
        }
    }
    return pen_along(o, d, first);
}

/* An eye that sees the edge: directly, in a mirror, or through a face of glass. False if none
 * can. */
static bool place_eye(const struct prism *p, struct random *r, const struct corner_case *m,
                      double ior, vec3 *eye, vec3 *at)
{
    const vec3 e = edge_point(p, r, m), o = inside(p, r);
    vec3 n, d = pen_normalize(pen_sub(o, e));
    *at = e;
    *eye = o;
    if (m->near > 0) {
        const vec3 behind = leave(p, o, d, &n);
        *eye = pen_along(behind, pen_sub(e, behind), m->near);
    }
    if (m->kind <= ROOM)
        return true;
    if (m->kind == GLASS_OUTSIDE) {
        *eye = pen_scale(pen_sub(e, pen_scale(o, .5)), 4);
        return true;
    }
    const vec3 q = leave(p, o, d, &n);
    const double nd = pen_dot(n, d);
    *at = q;
    if (m->kind == ROOM_MIRRORED) {
        const vec3 back = pen_along(d, n, -2 * nd);
        *eye = pen_scale(pen_add(q, leave(p, q, back, &n)), .5);
        return is_inside(p, *eye);
    }
    const double k = 1 - ior * ior * (1 - nd * nd);
    if (!(k > 1e-3))
        return false;
    *eye = pen_along(q, pen_along(pen_scale(d, ior), n, sqrt(k) - ior * nd), 3);
    return true;
}

static bool value(vec3 eye, vec3 d, double rgb[3])
{
    struct pen_ray_counts counts;
    struct pen_status st;
    kit.view.camera.position = eye;
    kit.view.camera.direction = d;
    struct pen_scene *scene = kit_freeze(&kit);
    const bool ok = pen_render_pixel(scene, 0, &kit.settings, 0, 0, rgb, &counts, &st);
    pen_scene_free(scene);
    return ok;
}

static bool equal(const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        if (!(fabs(a[i] - b[i]) <= 1e-9 * (1 + fabs(b[i]))))
            return false;
    return true;
}

/* Makes the scene; false if the case is none. */
static bool make(const struct row_case *c, vec3 *eye, vec3 *d, vec3 *x, vec3 *y)
{
    const struct corner_case m = read(c);
    struct random r = {(uint64_t)m.seed * 0x9e3779b97f4a7c15u + 49, 0};
    struct prism p;
    vec3 at;
    if (!(m.kind >= 0 && m.kind < KINDS && m.size >= 1e-9 && m.size <= 1e9 && m.depth >= 1 &&
          m.depth <= 16 && m.order >= 0 && m.order < 64 && m.offset >= 0 && m.offset <= 1e3))
        return false;
    shot_begin(&kit);
    kit.settings.width = kit.settings.height = 1;
    kit.settings.max_depth = (int)m.depth;
    kit.settings.min_contribution = 0;
    kit.desc.background = pen_vec3(.5, .5, .5);
    kit.desc.has_sky = true;
    kit.desc.sky.up = pen_vec3(0, 1, 0);
    kit.desc.sky.zenith = pen_vec3(.1, .3, .9);
    kit.desc.sky.nadir = pen_vec3(.9, .4, .1);
    make_prism(&p, &r, &m);
    add_faces(&p, &r, &m);
    if (!place_eye(&p, &r, &m, kit.materials[0].ior, eye, &at))
        return false;
    *eye = place(&p, *eye);
    *d = pen_sub(place(&p, at), *eye);
    if (!(pen_length(*d) > 1e-2 * m.size))
        return false;
    kit.view.camera.up = fabs(d->y) > .9 * pen_length(*d) ? pen_vec3(1, 0, 0) : pen_vec3(0, 1, 0);
    gen_frame(&r, pen_normalize(*d), x, y);
    return true;
}

/* Whether an eye moved aside in some of `ways` directions sees that value. */
static bool seen_beside(const double here[3], vec3 eye, vec3 d, vec3 x, vec3 y, int ways)
{
    double beside[3];
    for (int i = 0; i < ways; i++) {
        const double a = 2 * pi * (i % 2 ? i / 2 + ways / 2 : i / 2) / ways;
        const vec3 o = pen_along(pen_along(eye, x, cos(a)), y, sin(a));
        if (value(o, d, beside) && equal(here, beside))
            return true;
    }
    return false;
}

static void judge(const struct row_case *c, struct row_verdict *v)
{
    vec3 eye, d, x, y;
    double here[3];
    if (!make(c, &eye, &d, &x, &y)) {
        row_skip(v);
        return;
    }
    if (!row_require(v, value(eye, d, here), "not rendered"))
        return;
    x = pen_scale(x, 1e-6 * read(c).size);
    y = pen_scale(y, 1e-6 * read(c).size);
    if (seen_beside(here, eye, d, x, y, ASIDE))
        return;
    row_tally(v, "seen from less than 6 degrees only");
    row_require(v, seen_beside(here, eye, d, x, y, ASIDE_FINE), "seen from nowhere beside it");
}

void rows_corners(struct pen_row_run *run)
{
    row_each(run, draw_direct, judge);
}

void rows_corner_obtuse(struct pen_row_run *run)
{
    row_each(run, draw_obtuse, judge);
}

void rows_corner_chains(struct pen_row_run *run)
{
    row_each(run, draw_chained, judge);
}

/* A block and single pixels, round the edge. */
static void judge_blocks(const struct row_case *c, struct row_verdict *v)
{
    static float film[3 * SHOT_PIXELS];
    vec3 eye, d, x, y;
    if (!make(c, &eye, &d, &x, &y)) {
        row_skip(v);
        return;
    }
    kit.settings.width = kit.settings.height = BLOCK;
    kit.view.camera.position = eye;
    kit.view.camera.direction = d;
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = 1;
    kit.view.camera.plane_width = kit.view.camera.plane_height = 1e-6;
    shot_take(&kit, film);
    struct pen_scene *scene = kit_freeze(&kit);
    for (int i = 0; i < BLOCK * BLOCK; i++) {
        double rgb[3];
        struct pen_ray_counts counts;
        struct pen_status st;
        if (!row_require(
                v,
                pen_render_pixel(scene, 0, &kit.settings, i % BLOCK, i / BLOCK, rgb, &counts, &st),
                "not rendered"))
            break;
        for (int k = 0; k < 3; k++)
            row_require(v, film[3 * i + k] == (float)rgb[k], "a block has other bits");
    }
    pen_scene_free(scene);
}

void rows_corner_blocks(struct pen_row_run *run)
{
    row_each(run, draw, judge_blocks);
}

/* What a surface keeps, it emits: all is 1, but for what the depth cuts. */
static void judge_furnace(const struct row_case *c, struct row_verdict *v)
{
    vec3 eye, d, x, y;
    double rgb[3];
    const struct corner_case m = read(c);
    if (m.kind < ROOM || !make(c, &eye, &d, &x, &y)) {
        row_skip(v);
        return;
    }
    for (int i = 0; i < FACES_MAX; i++) {
        struct pen_material *at = &kit.materials[i];
        at->emission = pen_vec3(.25, .25, .25);
        *(m.kind >= GLASS ? &at->kt : &at->kr) = pen_vec3(.75, .75, .75);
    }
    kit.desc.has_sky = false;
    kit.desc.background = pen_vec3(1, 1, 1);
    if (!row_require(v, value(eye, d, rgb), "not rendered"))
        return;
    row_measure(v, "too bright", rgb[0] - 1, 1e-12);
    row_measure(v, "lost", 1 - rgb[0] - pow(.75, m.depth), 1e-12);
}

void rows_corner_furnaces(struct pen_row_run *run)
{
    row_each(run, draw, judge_furnace);
}

/* The surroundings are bright, the walls are not. */
static void judge_room(const struct row_case *c, struct row_verdict *v)
{
    vec3 eye, d, x, y;
    double rgb[3];
    if (!make(c, &eye, &d, &x, &y)) {
        row_skip(v);
        return;
    }
    for (int i = 0; i < FACES_MAX; i++)
        kit.materials[i].emission = pen_vec3(0, 0, 0);
    if (row_require(v, value(eye, d, rgb), "not rendered"))
        row_measure(v, "light in a closed room", rgb[0] + rgb[1] + rgb[2], 0);
}

void rows_corner_rooms(struct pen_row_run *run)
{
    row_each(run, draw_rooms, judge_room);
}
