/* SPDX-License-Identifier: MIT */
/* Boxes and trees: rays aimed where a box test may lose them. A tree must give the result of trying
 * every primitive, bit for bit. If an exact slab test hits by more than rounding, the box must be
 * found. */
#include <math.h>

#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"

static struct world world;
static struct primitives_tree tree, other; /* of the other builders one after the other, by scene */

enum { BOXES = 12 };
static vec3 low[BOXES], high[BOXES];

enum flavour { SOLID, FLAT };

/* Boxes of six squares, or axis-parallel rectangles whose boxes have no thickness, on a grid or
 * anywhere. */
static void build(enum flavour flavour, double scene, double offset)
{
    static double built[3] = {-1, -1, -1};
    struct random r = {(uint64_t)scene * 0x9e3779b97f4a7c15u + 91, 0};
    vec3 at = gen_offset3(offset);
    if (built[0] == (double)flavour && built[1] == scene && built[2] == offset)
        return;
    built[0] = (double)flavour;
    built[1] = scene;
    built[2] = offset;
    world_clear(&world);
    for (int i = 0; i < BOXES; i++) {
        bool dyadic = (uint64_t)scene & 1;
        vec3 c = pen_add(at, dyadic ? gen_dyadic3(&r, 4) : random_vec(&r, 4));
        vec3 s =
            dyadic ? pen_vec3(1, 2, .5) : pen_vec3(random_in(&r, .1, 2), random_in(&r, .1, 2), 1);
        low[i] = c;
        high[i] = pen_add(c, s);
        if (flavour == SOLID) {
            world_box(&world, low[i], high[i]);
            continue;
        }
        int flat = i % 3;
        double *end = flat == 0 ? &high[i].x : flat == 1 ? &high[i].y : &high[i].z;
        *end = pen_component(c, flat);
        vec3 h = high[i], v[4] = {c, c, h, c};
        v[1] = flat == 0 ? pen_vec3(c.x, h.y, c.z) : pen_vec3(h.x, c.y, c.z);
        v[3] = flat == 2 ? pen_vec3(c.x, h.y, c.z) : pen_vec3(c.x, c.y, h.z);
        world_polygon(&world, v, 4);
    }
    primitives_build(&tree, &world.prims);
    primitives_build_kind(&other, &world.prims,
                          (enum pen_accelerator)(1 + (uint64_t)scene / 4 % (PEN_ACCEL_COUNT - 1)));
}

static void draw_scene(struct row_draw *d, struct row_case *c)
{
    static const double offsets[] = {0, 1e3, 1e6, 1e9};
    uint64_t scene = d->index / 256;
    row_fixed(c, (double)scene);
    row_fixed(c, offsets[scene % 4]);
}

/* A corner of box i, or a point of an edge or a face of it, moved by a few ulps at times. */
static vec3 box_point(struct random *r, int i)
{
    double x[3];
    for (int k = 0; k < 3; k++) {
        double a = pen_component(low[i], k), b = pen_component(high[i], k);
        uint32_t what = random_below(r, 5);
        x[k] = what < 2 ? a : what < 4 ? b : a + (b - a) * random_unit(r);
    }
    return gen_nudged(r, pen_vec3(x[0], x[1], x[2]));
}

static vec3 ray_direction(struct random *r, vec3 o, vec3 to)
{
    vec3 d = random_below(r, 3) ? gen_toward(r, o, to) : gen_axial(r);
    if (random_below(r, 20) == 0)
        d.y = random_below(r, 2) ? 5e-324 : -1e-310;
    return d;
}

/* From boxes and from around them, at corners, edges and faces. Arguments: scene, offset, which box
 * is aimed at, o, d. */
static void draw_aimed(struct row_draw *d, struct row_case *c, enum flavour flavour)
{
    struct random *r = &d->random;
    draw_scene(d, c);
    build(flavour, c->arg[0], c->arg[1]);
    int i = (int)random_below(r, BOXES);
    vec3 to = box_point(r, i);
    vec3 o = random_below(r, 2) ? box_point(r, (int)random_below(r, BOXES))
                                : pen_add(to, random_vec(r, 6));
    row_fixed(c, i);
    vec3 direction = ray_direction(r, o, to);
    if (random_below(r, 3) == 0) /* so that an axial ray still meets the point */
        o = pen_sub(to, pen_scale(direction, pen_norm1(direction) < 10 ? random_in(r, 0, 3) : 0));
    row_arg3(c, o);
    row_arg3(c, direction);
}

static void draw_boxes(struct row_draw *d, struct row_case *c)
{
    draw_aimed(d, c, SOLID);
}

static void draw_flat_boxes(struct row_draw *d, struct row_case *c)
{
    draw_aimed(d, c, FLAT);
}

static bool same_hit(struct pen_hit a, struct pen_hit b)
{
    return a.prim == b.prim && (a.prim == PEN_NO_PRIM || (a.t == b.t && a.part == b.part));
}

/* Both variants of the tree against trying all, up to tmax; *first is what is met. */
static void require_same(struct row_verdict *v, const struct pen_ray *ray, double tmax,
                         struct pen_hit *first)
{
    bool alike;
    struct pen_t_interval interval = {pen_after_start, tmax};
    *first = world_nearest(&world, ray, &pen_origin_none, &interval);
    for (int i = 0; i < 2; i++) {
        const struct primitives_tree *by = i ? &other : &tree;
        struct pen_hit hit = primitives_nearest(by, ray, &pen_origin_none, tmax, &alike);
        row_require(v, alike, "instruction sets differ");
        if (!same_hit(hit, *first))
            row_fail(v, "%s: %s meets %d, trying all meets %d",
                     hit.prim == PEN_NO_PRIM ? "false miss" : "another",
                     i ? "another builder's structure" : "the tree", (int)hit.prim,
                     (int)first->prim);
    }
}

/* Whether the ray starts outside the box and passes through it by more than 8u of the coordinates,
 * exactly. */
static bool surely_hit(int i, const struct pen_ray *ray)
{
    vec3 o = ray->o, lo = low[i], hi = high[i];
    double size = pen_norm1(o) + pen_norm1(lo) + pen_norm1(hi), s = 8 * 0x1p-53 * size;
    vec3 slack = pen_vec3(s, s, s), a = pen_add(lo, slack), b = pen_sub(hi, slack);
    bool inside = o.x >= lo.x - s && o.x <= hi.x + s && o.y >= lo.y - s && o.y <= hi.y + s &&
                  o.z >= lo.z - s && o.z <= hi.z + s;
    if (inside || !(a.x < b.x && a.y < b.y && a.z < b.z))
        return false;
    return oracle_slab(a, b, (struct oracle_ray){o, ray->d}, INFINITY);
}

static void judge_boxes_of(const struct row_case *c, struct row_verdict *v, enum flavour flavour)
{
    int at = 0;
    double scene = row_next(c, &at), offset = row_next(c, &at);
    int box = (int)row_next(c, &at);
    vec3 o = row_next3(c, &at);
    struct pen_ray ray;
    struct pen_hit first;
    if (!pen_ray_make(&ray, o, row_next3(c, &at)) || box < 0 || box >= BOXES) {
        row_skip(v);
        return;
    }
    build(flavour, scene, offset);
    require_same(v, &ray, INFINITY, &first);
    row_tally(v, first.prim == PEN_NO_PRIM ? "past everything" : "hit");
    if (flavour == SOLID && surely_hit(box, &ray)) {
        row_tally(v, "box hit for sure by exact slabs");
        row_require(v, first.prim != PEN_NO_PRIM, "false miss of a box that is hit for sure");
    }
}

static void judge_boxes(const struct row_case *c, struct row_verdict *v)
{
    judge_boxes_of(c, v, SOLID);
}

static void judge_flat_boxes(const struct row_case *c, struct row_verdict *v)
{
    judge_boxes_of(c, v, FLAT);
}

void rows_boxes(struct pen_row_run *run)
{
    row_each(run, draw_boxes, judge_boxes);
}

void rows_flat_boxes(struct pen_row_run *run)
{
    row_each(run, draw_flat_boxes, judge_flat_boxes);
}

/* H093: origins exactly on faces, edges and corners, going inward, along and outward. */
static void draw_on_faces(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    draw_scene(d, c);
    build(SOLID, c->arg[0], c->arg[1]);
    int i = (int)random_below(r, BOXES), place = (int)random_below(r, 26);
    place += place >= 13; /* 27 places of a box but for the middle */
    double x[3];
    for (int k = 0; k < 3; k++, place /= 3) {
        double a = pen_component(low[i], k), b = pen_component(high[i], k);
        x[k] = place % 3 == 0 ? a : place % 3 == 2 ? b : a + (b - a) * random_unit(r);
    }
    row_fixed(c, i);
    row_arg3(c, pen_vec3(x[0], x[1], x[2]));
    row_arg3(c, random_below(r, 2) ? gen_axial(r) : random_direction(r));
}

void rows_on_faces(struct pen_row_run *run)
{
    row_each(run, draw_on_faces, judge_boxes);
}

/* H086: the 26 directions along axes and diagonals with zeros of either sign, from box faces moved
 * by an ulp or none: no false miss, and the sign of a zero changes nothing. */
static void draw_signed_zeros(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    draw_scene(d, c);
    build(SOLID, c->arg[0], c->arg[1]);
    int i = (int)random_below(r, BOXES), direction = (int)random_below(r, 26);
    direction += direction >= 13;
    double x[3], u[3];
    for (int k = 0; k < 3; k++, direction /= 3) {
        double a = pen_component(low[i], k), b = pen_component(high[i], k);
        u[k] = direction % 3 - 1;
        x[k] = random_below(r, 2)
                   ? random_nudge(random_below(r, 2) ? a : b, (int)random_below(r, 3) - 1)
                   : a + (b - a) * random_unit(r);
        if (u[k] != 0)
            x[k] -= u[k] * 8 * random_below(r, 2);
    }
    row_fixed(c, i);
    row_arg3(c, pen_vec3(x[0], x[1], x[2]));
    row_arg3(c, pen_vec3(u[0], u[1], u[2]));
}

static void judge_signed_zeros(const struct row_case *c, struct row_verdict *v)
{
    int at = 3;
    vec3 o = row_next3(c, &at), d = row_next3(c, &at);
    struct pen_hit first, again;
    struct pen_ray ray;
    judge_boxes(c, v);
    if (v->skipped)
        return;
    if (!pen_ray_make(&ray, o, d))
        return;
    require_same(v, &ray, INFINITY, &first);
    for (int signs = 0; signs < 8; signs++) {
        vec3 e = {d.x == 0 && signs & 1 ? -0.0
                  : d.x == 0            ? 0.0
                                        : d.x,
                  d.y == 0 && signs & 2 ? -0.0
                  : d.y == 0            ? 0.0
                                        : d.y,
                  d.z == 0 && signs & 4 ? -0.0
                  : d.z == 0            ? 0.0
                                        : d.z};
        if (!pen_ray_make(&ray, o, e))
            continue;
        require_same(v, &ray, INFINITY, &again);
        row_require(v, same_hit(first, again), "the sign of a zero changes what is met");
    }
}

void rows_signed_zeros(struct pen_row_run *run)
{
    row_each(run, draw_signed_zeros, judge_signed_zeros);
}

/* H094: tmax equal to t of an intersection on a box's face includes it, an ulp less does not. */
static void judge_tmax(const struct row_case *c, struct row_verdict *v)
{
    int at = 3;
    vec3 o = row_next3(c, &at);
    struct pen_ray ray;
    struct pen_hit hit, again;
    if (!pen_ray_make(&ray, o, row_next3(c, &at))) {
        row_skip(v);
        return;
    }
    build(SOLID, c->arg[0], c->arg[1]);
    require_same(v, &ray, INFINITY, &hit);
    if (hit.prim == PEN_NO_PRIM)
        return;
    row_tally(v, "hit");
    require_same(v, &ray, hit.t, &again);
    row_require(v, same_hit(hit, again), "tmax = t does not include the intersection");
    require_same(v, &ray, nextafter(hit.t, 0), &again);
    row_require(v, again.prim == PEN_NO_PRIM, "tmax below t includes the intersection");
}

void rows_tmax(struct pen_row_run *run)
{
    row_each(run, draw_boxes, judge_tmax);
}
