/* SPDX-License-Identifier: MIT */
/* Rays that start on a surface where an earlier ray ended. They do not meet the surface where they
 * leave it, and meet all others. */
#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"

static struct world world;
static struct primitives_tree tree;

enum kind { SPHERE, TUBE, CYLINDER, TRIANGLE, POLYGON, PLANE };

static struct oracle_round primitive_of(const struct row_case *c, int *at, enum kind kind)
{
    struct oracle_round b = {.c = row_next3(c, at)};
    if (kind != SPHERE)
        b.a = row_next3(c, at);
    b.r = fabs(row_next(c, at));
    if (kind == CYLINDER)
        b.h = fabs(row_next(c, at));
    return b;
}

static bool lengths_are_sane(const struct oracle_round *b, enum kind kind)
{
    return b->r >= 1e-30 && b->r <= 1e30 && (kind == SPHERE || pen_norm1(b->a) > 1e-30) &&
           (kind != CYLINDER || (b->h >= 1e-30 && b->h <= 1e30));
}

static void make_round(const struct oracle_round *b, enum kind kind)
{
    if (kind == SPHERE)
        world_sphere(&world, b->c, b->r);
    else if (kind == TUBE)
        world_infinite_cylinder(&world, b->c, b->a, b->r);
    else
        world_cylinder(&world, b->c, b->a, b->r, b->h, true);
}

/* What a ray meets first, where, and the normal there. */
struct meeting {
    struct pen_hit hit;
    vec3 p, n, v; /* v: the ray's direction */
};

static bool meet(vec3 o, vec3 d, struct meeting *m)
{
    struct pen_ray ray;
    if (primitives_intersections(&world, o, d, &m->hit) <= 0 || !pen_ray_make(&ray, o, d))
        return false;
    m->p = pen_prim_point(&world.prims, m->hit, &ray);
    m->n = pen_prim_normal(&world.prims, m->hit, m->p);
    m->v = d;
    return pen_norm1(m->p) < 1e60;
}

/* The intersections of a ray that goes on from there; -1 for no ray. */
static int origin(const struct meeting *m, vec3 d, struct pen_hit *hit, int room)
{
    struct pen_ray ray;
    bool through = (pen_dot(m->n, d) > 0) != (pen_dot(m->n, m->v) < 0);
    struct pen_origin_surface on = world_origin_surface(&world, m->hit, m->p, m->v, through);
    if (!pen_ray_make(&ray, m->p, d))
        return -1;
    return world_intersections(&world, &ray, &on, INFINITY, hit, room);
}

/* H059, H061: radii 1e-6 to 1e6, offsets 0 to 1e9. Arguments: kind; primitive; first ray; next
 * direction.
 */
static void draw_round_at(struct random *r, enum kind kind, double offset, struct row_case *c)
{
    static const double radii[] = {1e-6, 1, 1e6};
    double radius = random_below(r, 2) ? radii[random_below(r, 3)] : gen_power(r, -6, 6);
    vec3 at = gen_offset3(offset), axis = random_below(r, 4) ? random_direction(r) : gen_axial(r);
    vec3 o = pen_along(at, random_direction(r), 5 * radius);
    row_fixed(c, kind);
    row_arg3(c, at);
    if (kind != SPHERE)
        row_arg3(c, axis);
    row_arg(c, radius);
    if (kind == CYLINDER)
        row_arg(c, radius * random_in(r, .5, 3));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, pen_add(at, random_vec(r, radius))));
    row_arg3(c, random_below(r, 8) ? random_direction(r) : gen_axial(r));
}

static void draw_round(struct row_draw *d, struct row_case *c)
{
    draw_round_at(&d->random, (enum kind)(d->index % 3), gen_offset(&d->random), c);
}

static void draw_round_near(struct row_draw *d, struct row_case *c)
{
    draw_round_at(&d->random, (enum kind)(d->index % 3), 0, c);
}

struct departure {
    enum kind kind;
    struct oracle_round b;
    struct meeting from;
    struct oracle_ray line;
    struct pen_hit hit[3];
    int count;
};

static bool depart(const struct row_case *c, struct departure *x)
{
    int at = 0;
    x->kind = (enum kind)row_next(c, &at);
    if (x->kind > CYLINDER)
        return false;
    x->b = primitive_of(c, &at, x->kind);
    vec3 o = row_next3(c, &at), d = row_next3(c, &at), next = row_next3(c, &at);
    if (!lengths_are_sane(&x->b, x->kind))
        return false;
    world_clear(&world);
    make_round(&x->b, x->kind);
    if (!meet(o, d, &x->from))
        return false;
    x->line = (struct oracle_ray){x->from.p, next};
    x->count = origin(&x->from, next, x->hit, 3);
    return x->count >= 0;
}

/* Inward +1, outward -1, 0 where the rounding of the point itself decides. */
static int goes_in(const struct departure *x)
{
    vec3 d = x->line.d, f = pen_sub(x->line.o, x->b.c);
    double speed = pen_length(d), slack = 0x1p-50 * (pen_norm1(x->line.o) + pen_norm1(x->b.c));
    double along = pen_dot(f, d), a = pen_dot(x->b.a, x->b.a);
    slack += 0x1p-50 * (pen_length(f) + x->b.r);
    if (x->from.hit.part != PEN_PART_SIDE) {
        double da = pen_dot(d, x->b.a) * (x->from.hit.part == PEN_PART_BASE ? 1 : -1);
        return fabs(da) <= 0x1p-50 * speed * sqrt(a) ? 0 : da > 0 ? 1 : -1;
    }
    if (x->kind != SPHERE)
        along -= pen_dot(f, x->b.a) * pen_dot(d, x->b.a) / a;
    return fabs(along) <= slack * speed ? 0 : along < 0 ? 1 : -1;
}

static void judge_departure(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[] = {"sphere", "tube", "cylinder"};
    struct departure x;
    if (!depart(c, &x)) {
        row_skip(v);
        return;
    }
    int in = goes_in(&x);
    row_tally(v, name[x.kind]);
    row_tally(v, in > 0 ? "inward" : in < 0 ? "outward" : "along, within rounding of the point");
    if (in == 0)
        row_require(v, x.count <= 1, "met itself along the surface");
    else if (x.count > (in > 0))
        row_fail(v, "%s met itself: %d intersections %s", name[x.kind], x.count,
                 in > 0 ? "inward" : "outward");
    else if (x.count < (in > 0))
        row_fail(v, "%s: the exit was missed", name[x.kind]);
}

void rows_self_intersection_round(struct pen_row_run *run)
{
    row_each(run, draw_round, judge_departure);
}

/* H061: t of the exit. */
static void judge_way_out(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[] = {"sphere, exit [ulp]", "tube, exit [ulp]",
                                       "cylinder, side to side [ulp]"};
    struct departure x;
    if (!depart(c, &x) || goes_in(&x) <= 0) {
        row_skip(v);
        return;
    }
    if (!row_require(v, x.count == 1, "not exactly one exit"))
        return;
    struct truth t = oracle_chord(&x.b, x.line);
    enum oracle_part part = (enum oracle_part)x.from.hit.part, at = ORACLE_SIDE;
    if (x.kind == CYLINDER && !oracle_way_out(&x.b, part, x.line, &t, &at))
        return;
    if (part == ORACLE_SIDE && at == ORACLE_SIDE) {
        row_measure(v, name[x.kind], truth_ulps(x.hit[0].t, t), 4);
        return;
    }
    /* Through a cap, or from one: across or along the axis within 8u of the primitive's size. */
    vec3 d = x.line.d, a = x.b.a;
    double speed = at == ORACLE_SIDE ? pen_length(pen_cross(d, a)) : fabs(pen_dot(d, a));
    double error = truth_error(x.hit[0].t, t) * speed / pen_length(a);
    row_measure(v, "cylinder, through a cap [u(r+h)]", error / (0x1p-53 * (x.b.r + x.b.h)), 32);
}

void rows_way_out(struct pen_row_run *run)
{
    row_each(run, draw_round_near, judge_way_out);
}

/* H060: flat primitives of sizes e^-8 to e^8, and planes. Arguments: kind, corner, two edges, first
 * ray, next direction. */
static void draw_flat(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    enum kind kind = (enum kind)(TRIANGLE + d->index % 3);
    double size = exp(random_in(r, -8, 8));
    vec3 at = pen_add(random_vec(r, size), gen_offset3(gen_offset(r))), e = random_direction(r);
    vec3 f = pen_cross(e, random_direction(r));
    row_fixed(c, kind);
    row_arg3(c, at);
    row_arg3(c, pen_scale(e, size));
    row_arg3(c, pen_scale(f, size));
    vec3 to =
        pen_along(pen_along(at, e, size * random_in(r, .1, .5)), f, size * random_in(r, .1, .4));
    vec3 o = pen_along(to, random_direction(r), size * gen_power(r, -1, 2));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, to));
    row_arg3(c, random_below(r, 4) ? random_direction(r) : random_below(r, 2) ? e : gen_axial(r));
}

static bool make_flat(enum kind kind, vec3 at, vec3 e, vec3 f)
{
    struct pen_triangle probe;
    vec3 v[4] = {at, pen_add(at, e), pen_add(pen_add(at, e), f), pen_add(at, f)};
    world_clear(&world);
    if (!pen_triangle_make(&probe, v[0], v[1], v[2]) ||
        !pen_triangle_make(&probe, v[2], v[3], v[0]))
        return false;
    if (kind == TRIANGLE)
        world_triangle(&world, v[0], v[1], v[2]);
    else if (kind == PLANE)
        world_plane(&world, at, probe.facet.n);
    else if (!pen_polygon_make(&world.polygon[0], v, 4))
        return false;
    else
        world_polygon(&world, v, 4);
    return true;
}

static void judge_flat(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[] = {"triangle", "polygon", "plane"};
    int at = 0;
    enum kind kind = (enum kind)row_next(c, &at);
    vec3 p = row_next3(c, &at), e = row_next3(c, &at), f = row_next3(c, &at);
    vec3 o = row_next3(c, &at), d = row_next3(c, &at);
    struct meeting m;
    if (kind < TRIANGLE || kind > PLANE || !make_flat(kind, p, e, f) || !meet(o, d, &m)) {
        row_skip(v);
        return;
    }
    int count = origin(&m, row_next3(c, &at), NULL, 0);
    row_tally(v, name[kind - TRIANGLE]);
    if (count > 0)
        row_fail(v, "%s met itself", name[kind - TRIANGLE]);
}

void rows_self_intersection_flat(struct pen_row_run *run)
{
    row_each(run, draw_flat, judge_flat);
}

/* H062: two triangles that share an edge at 10^-k rad, in any pose; from one, into the wedge, the
 * other is met. Arguments: k; origin; the direction of the edge, that of the first face across it;
 * where on the face; where to. */
static void draw_wedge(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 e = random_direction(r), x, y;
    gen_frame(r, e, &x, &y);
    row_fixed(c, random_below(r, 15));
    row_arg3(c, random_below(r, 2) ? pen_vec3(0, 0, 0) : random_vec(r, 1));
    row_arg3(c, e);
    row_arg3(c, x);
    row_arg(c, random_in(r, .2, .6));
    row_arg(c, random_in(r, .05, .15));
    row_arg(c, random_in(r, .3, .7));
}

static void judge_wedge(const struct row_case *c, struct row_verdict *v)
{
    static const char *const lost[] = {"lost at 1e-13 rad", "lost at 1e-14 rad"};
    int i = 0, k = (int)row_next(c, &i);
    vec3 at = row_next3(c, &i), e = row_next3(c, &i), x = row_next3(c, &i), y = pen_cross(e, x);
    double angle = pow(10, -k), across = row_next(c, &i), along = row_next(c, &i);
    double part = row_next(c, &i);
    if (k < 0 || k > 14 || fabs(pen_length(e) - 1) > .01 || fabs(pen_length(x) - 1) > .01 ||
        fabs(pen_dot(e, x)) > .01 || !(across > .1 && along > 0 && across + along < .9) ||
        !(part > .2 && part < .8)) {
        row_skip(v);
        return;
    }
    vec3 up = pen_along(pen_scale(x, cos(angle)), y, sin(angle));
    world_clear(&world);
    world_triangle(&world, at, pen_add(at, x), pen_add(at, e));
    world_triangle(&world, at, pen_add(at, up), pen_add(at, e));
    vec3 p = pen_along(pen_along(at, x, across), e, along);
    vec3 over = pen_along(pen_along(at, up, across * part), e, along); /* on the other face */
    vec3 to = pen_add(over, pen_sub(over, p)), eye = pen_along(pen_along(p, x, .7), y, .35 * angle);
    struct meeting m = {{1, 0, PEN_PART_SIDE}, p, world.triangle[0].facet.n, pen_sub(p, eye)};
    m.p = pen_facet_project(&world.triangle[0].facet, p);
    /* Told what is true: the ray goes up into the wedge, and came from there. */
    struct pen_origin_surface on = world_origin_surface(&world, m.hit, m.p, m.v, false);
    struct pen_ray ray;
    if (!pen_ray_make(&ray, m.p, pen_sub(to, m.p))) {
        row_skip(v);
        return;
    }
    bool held = world_intersections(&world, &ray, &on, INFINITY, NULL, 0) == 1;
    row_tally(v, k <= 12 ? "tried at 1 to 1e-12 rad" : "tried at 1e-13 and 1e-14 rad");
    if (!held && k > 12)
        row_tally(v, lost[k - 13]);
    else if (!held)
        row_fail(v, "the other face is not met at 1e-%d rad", k);
}

void rows_wedge(struct pen_row_run *run)
{
    row_each(run, draw_wedge, judge_wedge);
}

/* H063: an opaque sphere inside a glass one, with gaps from 4e-5 down to 64u: of the radius, and of
 * the coordinates where the spheres are off the origin, since points have no more digits there. */
static void draw_shell(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    static const double gap[] = {4e-5, 1e-8, 1e-12, 64 * 0x1p-53};
    double radius = random_below(r, 2) ? 1 : gen_power(r, -3, 3);
    vec3 at = random_below(r, 2) ? pen_vec3(0, 0, 0) : random_vec(r, 4 * radius);
    row_fixed(c, gap[random_below(r, 4)]);
    row_arg3(c, at);
    row_arg(c, radius);
    vec3 o = pen_along(at, random_direction(r), 3 * radius);
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, pen_add(at, random_vec(r, .5 * radius))));
    row_arg3(c, pen_scale(random_direction(r), .1));
    row_arg3(c, random_direction(r));
}

static void judge_shell(const struct row_case *c, struct row_verdict *v)
{
    int i = 0;
    double gap = row_next(c, &i);
    vec3 at = row_next3(c, &i);
    double r = fabs(row_next(c, &i));
    vec3 o = row_next3(c, &i), d = row_next3(c, &i), bend = row_next3(c, &i);
    vec3 out = row_next3(c, &i), f = pen_sub(at, o);
    struct meeting m;
    struct pen_hit hit[4];
    double off = pen_length(pen_cross(f, d)) / pen_length(d);
    if (!(r > 1e-9 && r < 1e9) || !(gap >= 64 * 0x1p-53) || !(pen_norm1(at) < 16 * r) ||
        !(off < .9 * r) || !(pen_dot(f, d) > 0 && pen_length(f) > 2 * r) ||
        !(pen_length(bend) < .11) || !(pen_length(out) < 1.1)) {
        row_skip(v);
        return;
    }
    world_clear(&world);
    world_sphere(&world, at, r);
    world_sphere(&world, at, r + gap * (r + pen_norm1(at)));
    if (!meet(o, d, &m) || !row_require(v, m.hit.prim == 1, "the glass is not met first"))
        return;
    /* Bent a little into the glass; the inner sphere is next, unless it is grazed. */
    vec3 in = pen_along(pen_normalize(d), bend, 1);
    int count = origin(&m, in, hit, 4);
    if (pen_dot(in, m.n) > -.3)
        return;
    row_require(v, count == 3 && hit[0].prim == 0, "the inner sphere is not seen");
    struct meeting inner = m;
    struct pen_ray ray;
    if (!v->failed && pen_ray_make(&ray, m.p, in)) {
        inner.hit = hit[0];
        inner.p = pen_prim_point(&world.prims, hit[0], &ray);
        inner.n = pen_prim_normal(&world.prims, hit[0], inner.p);
        inner.v = in;
        vec3 away = pen_along(inner.n, out, .9);
        count = origin(&inner, away, hit, 4);
        row_require(v, count == 1 && hit[0].prim == 1, "outward the glass alone is met");
    }
}

void rows_shell(struct pen_row_run *run)
{
    row_each(run, draw_shell, judge_shell);
}

/* H068, H069: two equal primitives, the second turned round if it is flat; from afar a
 * ray hits the first in the document; a ray that starts on it hits the second at the start if it
 * goes through, and both at the exit. */
static void draw_twins(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(d->index % 5));
    row_fixed(c, random_below(r, 2)); /* turned round */
    vec3 at = random_vec(r, 2), o = pen_along(at, random_direction(r), 5);
    row_arg3(c, at);
    row_arg3(c, random_below(r, 2) ? random_direction(r) : gen_axial(r));
    row_arg3(c, random_direction(r));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, pen_add(at, random_vec(r, .4))));
    row_arg3(c, random_direction(r));
}

static bool add_twins(enum kind kind, bool turned, vec3 at, vec3 a, vec3 b)
{
    vec3 x = pen_cross(a, b), y = pen_cross(a, x);
    if (!(pen_norm1(y) > .1) || pen_norm1(a) > 4)
        return false;
    vec3 v[4] = {at, pen_add(at, x), pen_add(pen_add(at, x), y), pen_add(at, y)};
    vec3 w[4] = {v[3], v[2], v[1], v[0]};
    struct pen_polygon probe;
    struct oracle_round prim = {at, kind == SPHERE ? pen_vec3(0, 0, 0) : a, .7, .6};
    if (!pen_polygon_make(&probe, v, 4))
        return false;
    world_clear(&world);
    /* Numbers 7 and 9 among others that are out of the way. */
    for (int i = 0; i < 10; i++) {
        if (i != 7 && i != 9)
            world_sphere(&world, pen_vec3(100, 100 + i, 100), .25);
        else if (kind == POLYGON)
            world_polygon(&world, turned && i == 9 ? w : v, 4);
        else if (kind == TRIANGLE)
            world_triangle(&world, v[0], turned && i == 9 ? v[2] : v[1],
                           turned && i == 9 ? v[1] : v[2]);
        else
            make_round(&prim, kind);
    }
    return true;
}

static void judge_twins(const struct row_case *c, struct row_verdict *v)
{
    int i = 0;
    enum kind kind = (enum kind)row_next(c, &i);
    bool turned = row_next(c, &i) != 0, alike;
    vec3 at = row_next3(c, &i), a = row_next3(c, &i), b = row_next3(c, &i);
    vec3 o = row_next3(c, &i), d = row_next3(c, &i), next = row_next3(c, &i);
    struct meeting m;
    struct pen_hit hit[5];
    struct pen_ray ray;
    if (kind > POLYGON || pen_norm1(at) > 20 || pen_norm1(o) > 40 || !(pen_norm1(next) > .1) ||
        !add_twins(kind, turned, at, a, b) || !meet(o, d, &m) || m.hit.prim < 7 ||
        !pen_ray_make(&ray, o, d)) {
        row_skip(v);
        return;
    }
    row_require(v, m.hit.prim == 7, "not the first in the document");
    primitives_build(&tree, &world.prims);
    struct pen_hit by_tree = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    row_require(v, alike && by_tree.prim == 7, "by the tree, not the first in the document");
    int count = origin(&m, next, hit, 5);
    bool in = kind <= CYLINDER && pen_dot(m.n, next) < 0;
    int through = (pen_dot(m.n, next) > 0) != (pen_dot(m.n, m.v) < 0);
    if (fabs(pen_dot(m.n, next)) < 1e-6 || fabs(pen_dot(m.n, m.v)) < 1e-6)
        return;
    while (count > 0 && hit[count - 1].prim != 7 && hit[count - 1].prim != 9)
        count--; /* the others, far behind */
    if (count != through + (in ? 2 : 0))
        row_fail(v, "%d intersections on leaving %s", count, in ? "inward" : "outward");
    else if (through && (hit[0].prim != 9 || hit[0].t > PEN_LAST_LAYER_T))
        row_fail(v, "the second is not met at the start");
    else if (in)
        row_require(v,
                    hit[through].t == hit[through + 1].t && hit[through].prim == 7 &&
                        hit[through + 1].prim == 9,
                    "the exit is not one event in document order");
}

void rows_twins(struct pen_row_run *run)
{
    row_each(run, draw_twins, judge_twins);
}
