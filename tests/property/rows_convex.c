/* SPDX-License-Identifier: MIT */
/* Convex solids seen from outside under one light. Parts that face the light and the viewer are lit
 * as without shadows. Parts beyond the light's horizon are black. The oracle shoots and shades in
 * long double. */
#include <math.h>

#include "property/body.h"
#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

enum { SIDE = 16, SOLIDS = 3, FACES = BODY_FACES + 3 };

static const double horizon = 0x1p-22;

static struct kit kit;
static float film[3 * SHOT_PIXELS];

/* ---- Solids that stand on each other without a gap, so that they are one convex solid ---- */

enum solid_kind {
    SOLID_FLAT = BODY_TETRAHEDRON + 1, /* the kinds below are single bodies */
    SOLID_STACK = SOLID_FLAT,          /* two prisms */
    SOLID_SPHERE,
    SOLID_CYLINDER,
    SOLID_CONE,
    SOLID_CUT_CONE,
    SOLID_COLUMN,  /* two cylinders */
    SOLID_PENCIL,  /* a cylinder with a cone on it */
    SOLID_CAPSULE, /* a cylinder between spheres */
    SOLID_KINDS
};

enum { HIDES_BASE = 1, HIDES_TOP = 2 };

struct solid {
    struct body b;
    struct body_pose pose;
    int hidden; /* which of its first two faces, or caps, the others cover */
};

struct solids {
    struct solid of[SOLIDS];
    int count;
};

/* Another solid of the same kind of body, at a height over the first one's middle. */
static struct solid *next_solid(struct solids *s, double z, int hidden)
{
    struct solid *next = &s->of[s->count++];
    if (next != &s->of[0])
        *next = s->of[0];
    next->pose.o = body_place(&s->of[0].pose, pen_vec3(0, 0, z));
    next->hidden = hidden;
    return next;
}

static void cut_prism(struct solids *s, double at)
{
    struct body *low = &s->of[0].b, *high = &next_solid(s, 0, HIDES_BASE)->b;
    s->of[0].hidden = HIDES_TOP;
    for (int i = 0; i < low->vertices; i++)
        *(low->v[i].z > 0 ? &low->v[i].z : &high->v[i].z) = at;
}

static void make_round_solids(struct solids *s, enum solid_kind kind, struct random *r)
{
    static const enum body_kind body[] = {BODY_SPHERE,   BODY_CYLINDER, BODY_CONE,    BODY_CUT_CONE,
                                          BODY_CYLINDER, BODY_CYLINDER, BODY_CYLINDER};
    struct solid *first = &s->of[0];
    body_make(&first->b, body[kind - SOLID_SPHERE], r, 1);
    double h = first->b.h;
    if (kind == SOLID_COLUMN) {
        first->hidden = HIDES_TOP;
        struct body *b = &next_solid(s, h * 1.5, HIDES_BASE)->b;
        b->h = b->half.z = h / 2;
    } else if (kind == SOLID_PENCIL) {
        first->hidden = HIDES_TOP;
        struct body *b = &next_solid(s, h * 1.5, HIDES_BASE)->b;
        b->kind = BODY_CONE;
        b->h = b->half.z = h / 2;
        b->top = random_below(r, 2) ? 0 : b->r * random_in(r, .1, .9);
    } else if (kind == SOLID_CAPSULE) {
        first->hidden = HIDES_TOP | HIDES_BASE;
        next_solid(s, h, 0)->b.kind = BODY_SPHERE;
        next_solid(s, -h, 0)->b.kind = BODY_SPHERE;
        for (int i = 1; i < 3; i++)
            s->of[i].b.h = s->of[i].b.half.z = first->b.r;
    }
}

static void make_solids(struct solids *s, enum solid_kind kind, struct random *r, double size,
                        double offset)
{
    struct solid *first = &s->of[0];
    s->count = 1;
    first->hidden = 0;
    bool stack = kind == SOLID_STACK;
    if (kind > SOLID_STACK)
        make_round_solids(s, kind, r);
    else
        body_make(&first->b, stack ? BODY_PRISM : (enum body_kind)kind, r, 1);
    first->pose = body_pose(r, size, offset);
    for (int i = 1; i < s->count; i++) { /* the poses before were not the last ones */
        double z = i == 2 ? -first->b.h : kind == SOLID_CAPSULE ? first->b.h : first->b.h * 1.5;
        s->of[i].pose = first->pose;
        s->of[i].pose.o = body_place(&first->pose, pen_vec3(0, 0, z));
    }
    if (stack)
        cut_prism(s, random_below(r, 2) ? 0 : random_in(r, -.3, .3));
}

/* ---- The oracle ---- */

typedef long double real;

struct lvec {
    real x, y, z;
};

static struct lvec lv(vec3 a)
{
    return (struct lvec){a.x, a.y, a.z};
}

static struct lvec l_sub(struct lvec a, struct lvec b)
{
    return (struct lvec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static struct lvec l_along(struct lvec a, struct lvec d, real t)
{
    return (struct lvec){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}

static real l_dot(struct lvec a, struct lvec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct lvec l_cross(struct lvec a, struct lvec b)
{
    return (struct lvec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static struct lvec l_unit(struct lvec a)
{
    real s = 1 / sqrtl(l_dot(a, a));
    return (struct lvec){a.x * s, a.y * s, a.z * s};
}

/* A convex surface: a plane at c with normal n; or the side of a cone about the axis n, of radius r
 * at c, that grows by `slope`; or a sphere. Its inside is where its height is below 0. */
enum surface { PLANE, SIDE_OF_CONE, SPHERE };

struct face {
    enum surface surface;
    bool hidden;
    struct lvec c, n;
    real r, slope;
};

struct shape {
    struct face face[FACES];
    int count;
};

static real height(const struct face *f, struct lvec p)
{
    struct lvec q = l_sub(p, f->c);
    if (f->surface == PLANE)
        return l_dot(q, f->n);
    if (f->surface == SPHERE)
        return sqrtl(l_dot(q, q)) - f->r;
    real s = l_dot(q, f->n);
    struct lvec across = l_along(q, f->n, -s);
    return (sqrtl(l_dot(across, across)) - f->r - f->slope * s) / sqrtl(1 + f->slope * f->slope);
}

/* The radius of the circle about the axis through p; of a plane, infinite. */
static real radius_at(const struct face *f, struct lvec p)
{
    struct lvec q = l_sub(p, f->c);
    if (f->surface == PLANE)
        return INFINITY;
    if (f->surface == SIDE_OF_CONE)
        q = l_along(q, f->n, -l_dot(q, f->n));
    return sqrtl(l_dot(q, q));
}

static struct lvec normal(const struct face *f, struct lvec p)
{
    struct lvec q = l_sub(p, f->c);
    if (f->surface == PLANE)
        return f->n;
    if (f->surface == SPHERE)
        return l_unit(q);
    return l_unit(l_along(l_unit(l_along(q, f->n, -l_dot(q, f->n))), f->n, -f->slope));
}

/* The part of the line inside: cuts [t[0], t[1]]. */
static void cut(const struct face *f, struct lvec o, struct lvec d, real t[2])
{
    struct lvec q = l_sub(o, f->c);
    if (f->surface == PLANE) {
        real along = l_dot(d, f->n), at = -l_dot(q, f->n) / along;
        if (along < 0)
            t[0] = fmaxl(t[0], at);
        else if (along > 0)
            t[1] = fminl(t[1], at);
        else if (l_dot(q, f->n) > 0)
            t[1] = -INFINITY;
        return;
    }
    real da = f->surface == SPHERE ? 0 : l_dot(d, f->n), qa = l_dot(q, f->n);
    qa = f->surface == SPHERE ? 0 : qa;
    real grow = 1 + f->slope * f->slope, w = f->r + f->slope * qa;
    real a = l_dot(d, d) - grow * da * da;
    real b = l_dot(q, d) - qa * da - f->slope * da * w, c = l_dot(q, q) - qa * qa - w * w;
    real disc = b * b - a * c;
    if (a == 0 || !(disc > 0)) {
        if (!(a < 0))
            t[1] = -INFINITY;
        return;
    }
    real h = sqrtl(disc), u = -b - copysignl(h, b), lo = u / a, hi = c / u;
    if (lo > hi) {
        real other = lo;
        lo = hi;
        hi = other;
    }
    if (a > 0) {
        t[0] = fmaxl(t[0], lo);
        t[1] = fminl(t[1], hi);
    } else if (f->slope * da > 0) { /* into the wide end of the nappe */
        t[0] = fmaxl(t[0], hi);
    } else {
        t[1] = fminl(t[1], lo);
    }
}

static void flat_shape(const struct solid *s, struct shape *out)
{
    for (int f = 0; f < s->b.faces; f++) {
        const int *c = s->b.corner[f];
        struct lvec v[3];
        for (int i = 0; i < 3; i++)
            v[i] = lv(body_vertex(&s->b, &s->pose, c[i * (s->b.corners[f] / 3)]));
        out->face[out->count++] =
            (struct face){PLANE, f < 2 && (s->hidden >> f & 1),
                          v[0],  l_unit(l_cross(l_sub(v[1], v[0]), l_sub(v[2], v[0]))),
                          0,     0};
    }
}

static void shape_of(const struct solid *s, struct shape *out)
{
    const struct body *b = &s->b;
    out->count = 0;
    if (b->kind <= BODY_LAST_CROSSING) {
        flat_shape(s, out);
        return;
    }
    struct lvec axis = l_unit(lv(body_turn(&s->pose, pen_vec3(0, 0, 1)))), c = lv(s->pose.o);
    real size = s->pose.size, h = size * b->h, slope = (b->top - (real)b->r) / (2 * b->h);
    if (b->kind == BODY_SPHERE) {
        out->face[out->count++] = (struct face){SPHERE, false, c, axis, size * b->r, 0};
        return;
    }
    out->face[out->count++] =
        (struct face){SIDE_OF_CONE, false, c, axis, size * (b->r + (real)b->top) / 2, slope};
    out->face[out->count++] = (struct face){PLANE,
                                            s->hidden & HIDES_BASE,
                                            l_along(c, axis, -h),
                                            (struct lvec){-axis.x, -axis.y, -axis.z},
                                            0,
                                            0};
    out->face[out->count++] =
        (struct face){PLANE, s->hidden & HIDES_TOP, l_along(c, axis, h), axis, 0, 0};
}

/* ---- A case ---- */

struct scene {
    struct solids solids;
    struct shape shape[SOLIDS];
    real rounding; /* how far anything may be off, scene units */
    bool directional;
    struct lvec light; /* towards it, or where it is */
    real kd, ks, shininess;
};

/* What the renderer may find at a place of a face: from least to most. */
struct allowed {
    real least, most;
};

/* In between are values within the rounding of the light's angle to the surface. */
static struct allowed shade(const struct scene *s, const struct face *f, struct lvec p,
                            struct lvec view)
{
    struct lvec n = normal(f, p), v = l_unit(view);
    struct lvec q = s->directional ? s->light : l_sub(s->light, p);
    real far = sqrtl(l_dot(q, q)), sine = l_dot(n, q) / far;
    real off = 4e-19L + (s->directional ? 0x1p-50L : s->rounding / far);
    off += f->surface == PLANE ? s->rounding / s->solids.of[0].pose.size
                               : s->rounding / radius_at(f, p) * 4;
    if (sine < .999L * horizon - off)
        return (struct allowed){0, 0};
    real mirror = 2 * sine * l_dot(n, v) * -1 + l_dot(v, q) / far; /* -v.r */
    real light = s->kd * sine;
    if (mirror > 0)
        light += s->ks * powl(fminl(mirror, 1), s->shininess);
    real slack = (1 + s->shininess) * (off * 16 + 1e-9L) + 1e-6L * light;
    real band = 1.001L * fmaxl(horizon, 4 * off) + off;
    return (struct allowed){sine > band ? fmaxl(light - slack, 1e-30L) : 0, light + slack};
}

enum seen { SEEN_NOTHING, SEEN_RIGHT, SEEN_SHADED, SEEN_LIT, SEEN_WRONG };

/* Judges one pixel: shot from o along d. Between round solids rounding may leave a gap, through
 * which a hidden cap is seen. */
static enum seen judge_pixel(const struct scene *s, struct lvec o, struct lvec d, real found)
{
    real t[2] = {INFINITY, 0}, speed = sqrtl(l_dot(d, d));
    for (int i = 0; i < s->solids.count; i++) {
        real in[2] = {0, INFINITY};
        for (int f = 0; f < s->shape[i].count; f++)
            cut(&s->shape[i].face[f], o, d, in);
        if (in[0] < in[1] && in[0] < t[0]) {
            t[0] = in[0];
            t[1] = in[1];
        }
    }
    struct lvec p = l_along(o, d, t[0]);
    real off = 4 * s->rounding + t[0] * speed * 0x1p-48L;
    if (!(t[0] > 0 && t[0] < INFINITY) || (t[1] - t[0]) * speed < 1e6L * off)
        return SEEN_NOTHING;
    struct allowed all = {INFINITY, 0};
    for (int i = 0; i < s->solids.count; i++) {
        bool at = true;
        for (int f = 0; f < s->shape[i].count; f++)
            at = at && height(&s->shape[i].face[f], p) < off;
        for (int f = 0; at && f < s->shape[i].count; f++) {
            const struct face *face = &s->shape[i].face[f];
            if (height(face, p) < -off)
                continue;
            if (face->hidden && s->shape[i].face[0].surface == PLANE)
                continue; /* shares its corners with the one it covers: no gap */
            if (l_dot(normal(face, p), d) > -1e-4L * speed || radius_at(face, p) < 1e3L * off)
                return SEEN_NOTHING; /* on the outline, or at the apex */
            struct allowed one = shade(s, face, p, d);
            all.least = face->hidden ? 0 : fminl(all.least, one.least);
            all.most = fmaxl(all.most, one.most);
        }
    }
    if (all.least == INFINITY)
        return SEEN_NOTHING;
    if (found >= all.least && found <= all.most)
        return SEEN_RIGHT;
    return found == 0 ? SEEN_SHADED : all.most == 0 ? SEEN_LIT : SEEN_WRONG;
}

/* Shoots again what shot_look set up. */
static void judge_film(const struct scene *s, struct row_verdict *v)
{
    static const char *const name[] = {"pixels skipped", "pixels that are right",
                                       "false shadows on a convex solid",
                                       "lit pixels beyond the horizon", "pixels of other light"};
    const struct pen_camera_desc *camera = &kit.view.camera;
    struct lvec forward = l_unit(lv(camera->direction));
    struct lvec right = l_unit(l_cross(forward, lv(camera->up))), up = l_cross(right, forward);
    int count[5] = {0};
    for (int i = 0; i < SIDE * SIDE; i++) {
        real x = (i % SIDE + .5L) / SIDE - .5L, y = .5L - (i / SIDE + .5L) / SIDE;
        struct lvec d = {camera->plane_distance * forward.x, camera->plane_distance * forward.y,
                         camera->plane_distance * forward.z};
        d = l_along(l_along(d, right, x * camera->plane_width), up, y * camera->plane_width);
        count[judge_pixel(s, lv(camera->position), d, film[3 * i])]++;
    }
    for (int i = 0; i < 5; i++)
        row_measure(v, name[i], count[i], i < 2 ? -1 : 0);
}

/* Arguments: solid; size; offset in sizes; the sine of the light over the place looked at; its
 * distance in sizes, 0 for a directional light; the eye's distance, its height, the window; whether
 * seams are looked at; the seed. */
static void draw_solid(struct row_draw *d, struct row_case *c, bool grazing)
{
    struct random *r = &d->random;
    double sine = random_below(r, 2) ? gen_power(r, -7, -.1) : random_in(r, 0, 1);
    if (grazing)
        sine = gen_power(r, -17, -5) * (random_below(r, 2) ? 1 : -1);
    if (grazing && random_below(r, 4) == 0)
        sine = random_below(r, 2) ? 0 : horizon * random_in(r, .9, 1.1);
    int kind = (int)(d->index % SOLID_KINDS);
    double offset = gen_offset(r);
    row_fixed(c, kind);
    row_fixed(c, gen_power(r, -8, 8));
    row_fixed(c, kind < SOLID_COLUMN ? offset : 0); /* rounding makes ledges between round solids */
    row_fixed(c, sine);
    row_fixed(c, random_below(r, 2) ? 0 : gen_power(r, grazing ? -8 : -2, 8));
    row_fixed(c, gen_power(r, -1, 1.5));
    row_fixed(c, random_in(r, .05, 1));
    row_fixed(c, gen_power(r, -13, .5));
    row_fixed(c, random_below(r, 2));
    row_fixed(c, (double)(random_bits(r) >> 40));
}

static bool outside(const struct solids *s, const struct body_pose *pose, vec3 p, real far)
{
    /* in the coordinates of each solid; p in those of the first */
    for (int i = 0; i < s->count; i++) {
        vec3 by = pen_sub(s->of[i].pose.o, pose->o), q = p;
        q.z -= pen_dot(by, body_turn(pose, pen_vec3(0, 0, 1))) / pose->size;
        if (!(-body_depth(&s->of[i].b, q) > (double)far))
            return false;
    }
    return true;
}

static void add_light(struct scene *s, const struct body_pose *pose, vec3 to, vec3 p, double far)
{
    vec3 one = pen_vec3(1, 1, 1);
    s->directional = far == 0;
    if (far == 0)
        kit_directional(&kit, pen_neg(body_turn(pose, to)), one);
    else
        kit_point(&kit, body_place(pose, pen_along(p, to, far)), one);
    s->light = far == 0 ? lv(pen_neg(kit.lights[0].direction)) : lv(kit.lights[0].position);
}

static void begin_scene(struct scene *s, struct random *r)
{
    static const double share[] = {0, .5, 1}, power[] = {1, 10, 200};
    struct pen_material m = kit_matte(share[1 + random_below(r, 2)]);
    double ks = share[random_below(r, 3)];
    m.ks = pen_vec3(ks, ks, ks);
    m.shininess = power[random_below(r, 3)];
    s->kd = m.kd.x;
    s->ks = ks;
    s->shininess = m.shininess;
    shot_begin(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    int material = kit_material(&kit, m);
    for (int i = 0; i < s->solids.count; i++) {
        body_add(&s->solids.of[i].b, &s->solids.of[i].pose, &kit, material);
        shape_of(&s->solids.of[i], &s->shape[i]);
    }
}

static void judge_solid(const struct row_case *c, struct row_verdict *v)
{
    static struct scene s;
    struct random r = {(uint64_t)c->arg[9] * 0x9e3779b97f4a7c15u + 66, 0};
    double sine = c->arg[3], far = c->arg[4], size = c->arg[1];
    make_solids(&s.solids, (enum solid_kind)c->arg[0], &r, size, c->arg[2]);
    const struct body_pose *pose = &s.solids.of[0].pose;
    struct solid *which = &s.solids.of[random_below(&r, (uint32_t)s.solids.count)];
    begin_scene(&s, &r);
    vec3 n, x, y, p = body_surface(&which->b, &r, &n);
    vec3 up = pen_vec3(
        0, 0, pen_dot(pen_sub(which->pose.o, pose->o), body_turn(pose, pen_vec3(0, 0, 1))) / size);
    gen_frame(&r, n, &x, &y);
    add_light(&s, pose, pen_along(pen_scale(x, sqrt(1 - sine * sine)), n, sine), pen_add(p, up),
              far);
    vec3 at = pen_add(c->arg[8] > 0 ? body_seam(&which->b, &r) : p, up);
    vec3 eye = pen_along(pen_along(at, n, c->arg[5] * c->arg[6]), random_direction(&r),
                         c->arg[5] * (1 - c->arg[6]));
    vec3 light = pen_along(pen_add(p, up), pen_along(pen_scale(x, 1), n, sine), far);
    double rounding = body_rounding(pose) + (far > 1e3 ? 0 : 0x1p-48 * far);
    s.rounding = rounding * size;
    if (!outside(&s.solids, pose, eye, 4 * rounding) || sine > 1 ||
        (far > 0 && !outside(&s.solids, pose, light, 4 * rounding))) {
        row_skip(v);
        return;
    }
    shot_look(&kit, body_place(pose, eye), body_place(pose, at), c->arg[7] * size);
    shot_take(&kit, film);
    judge_film(&s, v);
}

static void draw_lit(struct row_draw *d, struct row_case *c)
{
    draw_solid(d, c, false);
}

void rows_convex_lit(struct pen_row_run *run)
{
    row_each(run, draw_lit, judge_solid);
}

static void draw_horizon(struct row_draw *d, struct row_case *c)
{
    draw_solid(d, c, true);
}

void rows_convex_horizon(struct pen_row_run *run)
{
    row_each(run, draw_horizon, judge_solid);
}
