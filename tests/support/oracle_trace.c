/* SPDX-License-Identifier: MIT */
/* The oracle's optics: the shading model of src/shade/README.md in long double; every ray is tested
 * against every primitive. */
#include <stdint.h>

#include "support/oracle.h"
#include "support/oracle_parts.h"

/* A place on a ray, ordered by distance and then by the document. */
struct place {
    real t;
    int prim; /* -1: the ray's own start */
};

static struct point ray_at(struct ray ray, real t)
{
    return point_sum(ray.from, point_times(ray.direction, t));
}

static int sphere_roots(const struct oracle_primitive *b, struct ray ray, real t[2])
{
    struct point m = point_difference(b->origin, ray.from);
    real middle = point_dot(m, ray.direction);
    struct point off = point_difference(m, point_times(ray.direction, middle));
    real half = b->radius * b->radius - point_dot(off, off);
    if (half < 0)
        return 0;
    t[0] = middle - sqrtl(half);
    t[1] = middle + sqrtl(half);
    return 2;
}

/* The side of an infinite cylinder or cylinder, as if infinite. */
static int side_roots(const struct oracle_primitive *b, struct ray ray, real t[2])
{
    struct point m = point_difference(ray.from, b->origin);
    struct point flat_way =
        point_difference(ray.direction, point_times(b->axis, point_dot(ray.direction, b->axis)));
    struct point flat_m = point_difference(m, point_times(b->axis, point_dot(m, b->axis)));
    real speed = point_length(flat_way);
    if (speed < 1e-15L)
        return 0;
    struct point u = point_times(flat_way, 1 / speed);
    real middle = -point_dot(flat_m, u);
    struct point off = point_sum(flat_m, point_times(u, middle));
    real half = b->radius * b->radius - point_dot(off, off);
    if (half < 0)
        return 0;
    t[0] = (middle - sqrtl(half)) / speed;
    t[1] = (middle + sqrtl(half)) / speed;
    return 2;
}

static int plane_root(struct point origin, struct point normal, struct ray ray, real t[1])
{
    real slope = point_dot(ray.direction, normal);
    if (slope == 0)
        return 0;
    t[0] = point_dot(point_difference(origin, ray.from), normal) / slope;
    return 1;
}

static int cylinder_roots(const struct oracle_primitive *b, struct ray ray, real t[4])
{
    real side[2];
    int n = 0;
    for (int i = 0, found = side_roots(b, ray, side); i < found; i++) {
        real h = point_dot(point_difference(ray_at(ray, side[i]), b->origin), b->axis);
        if (h >= 0 && h <= b->height)
            t[n++] = side[i];
    }
    for (int end = 0; end < 2 && b->caps; end++) {
        struct point center = point_sum(b->origin, point_times(b->axis, end ? b->height : 0));
        if (!plane_root(center, b->axis, ray, t + n))
            continue;
        struct point off = point_difference(ray_at(ray, t[n]), center);
        if (point_dot(off, off) <= b->radius * b->radius)
            n++;
    }
    return n;
}

/* Even-odd rule, seen along the normal's longest axis. */
static bool ring_holds(const struct oracle_primitive *b, struct point p)
{
    real nx = fabsl(b->axis.x), ny = fabsl(b->axis.y), nz = fabsl(b->axis.z);
    bool drop_x = nx >= ny && nx >= nz, drop_y = !drop_x && ny >= nz;
    bool inside = false;
    real pu = drop_x ? p.y : p.x, pv = drop_x || drop_y ? p.z : p.y;
    for (int i = 0, j = b->count - 1; i < b->count; j = i++) {
        struct point c = b->corners[i], d = b->corners[j];
        real cu = drop_x ? c.y : c.x, cv = drop_x || drop_y ? c.z : c.y;
        real du = drop_x ? d.y : d.x, dv = drop_x || drop_y ? d.z : d.y;
        if ((cv > pv) != (dv > pv) && pu < (du - cu) * (pv - cv) / (dv - cv) + cu)
            inside = !inside;
    }
    return inside;
}

/* The radius of a cone at height h: negative beyond its apex. */
static real cone_radius(const struct oracle_primitive *b, real h)
{
    return b->radius + (b->top - b->radius) * h / b->height;
}

/* Intersections with a cone: where the squared distance from the axis is the squared radius,
 * between base and top; then the caps. */
static int cone_roots(const struct oracle_primitive *b, struct ray ray, real t[4])
{
    struct point m = point_difference(ray.from, b->origin);
    real h = point_dot(m, b->axis), climb = point_dot(ray.direction, b->axis);
    real grow = (b->top - b->radius) / b->height * climb, r = cone_radius(b, h);
    struct point u = point_difference(ray.direction, point_times(b->axis, climb));
    struct point f = point_difference(m, point_times(b->axis, h));
    real qa = point_dot(u, u) - grow * grow, qb = point_dot(u, f) - grow * r;
    real qc = point_dot(f, f) - r * r, disc = qb * qb - qa * qc;
    int n = 0;
    for (int sign = -1; disc >= 0 && sign <= 1; sign += 2) {
        real q = -qb + sign * sqrtl(disc);
        t[n] = fabsl(qa) > 1e-15L ? q / qa : -qc / (2 * qb);
        real at = h + t[n] * climb;
        n += at >= 0 && at <= b->height && (sign < 0 || fabsl(qa) > 1e-15L);
    }
    for (int end = 0; end < 2 && b->caps; end++) {
        struct point center = point_sum(b->origin, point_times(b->axis, end ? b->height : 0));
        if (!plane_root(center, b->axis, ray, t + n))
            continue;
        struct point off = point_difference(ray_at(ray, t[n]), center);
        n += point_length(off) < (end ? b->top : b->radius);
    }
    return n;
}

int oracle_body_roots(const struct oracle_primitive *b, struct ray ray, real t[4])
{
    switch (b->kind) {
    case ORACLE_SPHERE:
        return sphere_roots(b, ray, t);
    case ORACLE_INFINITE_CYLINDER:
        return side_roots(b, ray, t);
    case ORACLE_CYLINDER:
        return cylinder_roots(b, ray, t);
    case ORACLE_CONE:
        return cone_roots(b, ray, t);
    case ORACLE_PLANE:
        return plane_root(b->origin, b->axis, ray, t);
    case ORACLE_RING:
        return plane_root(b->origin, b->axis, ray, t) && ring_holds(b, ray_at(ray, t[0]));
    }
    return 0;
}

static bool comes_after(real t, int prim, struct place place, real tie)
{
    if (place.prim < 0)
        return t > tie;
    return t > place.t + tie || (t >= place.t - tie && prim > place.prim);
}

/* The first place on the ray after another one. */
static bool next_hit(const struct oracle_scene *s, struct ray ray, struct place after,
                     struct place *hit)
{
    hit->prim = -1;
    for (int i = 0; i < s->body_count; i++) {
        real t[4];
        int n = oracle_body_roots(&s->primitives[i], ray, t);
        for (int k = 0; k < n; k++)
            if (comes_after(t[k], i, after, s->tie) && (hit->prim < 0 || t[k] < hit->t - s->tie)) {
                hit->t = t[k];
                hit->prim = i;
            }
    }
    return hit->prim >= 0;
}

static struct point normal_at(const struct oracle_primitive *b, struct point p, real tie)
{
    struct point m = point_difference(p, b->origin);
    real h = point_dot(m, b->axis);
    if (b->kind == ORACLE_PLANE || b->kind == ORACLE_RING)
        return b->axis;
    if (b->kind == ORACLE_SPHERE)
        return point_unit(m);
    struct point out = point_difference(m, point_times(b->axis, h));
    if (b->kind == ORACLE_CYLINDER && b->caps && point_length(out) < b->radius - tie &&
        (fabsl(h) <= tie || fabsl(h - b->height) <= tie))
        return b->axis;
    if (b->kind == ORACLE_CONE) {
        if (b->caps && ((fabsl(h) <= tie && point_length(out) < b->radius - tie) ||
                        (fabsl(h - b->height) <= tie && point_length(out) < b->top - tie)))
            return b->axis;
        return point_unit(point_difference(point_unit(out),
                                           point_times(b->axis, (b->top - b->radius) / b->height)));
    }
    return point_unit(out);
}

/* The product of kt over all primitives strictly between p and the light. `reach` is HUGE_VALL for
 * a directional light. */
static struct point transmittance(const struct oracle_scene *s, struct point p,
                                  struct point direction, real reach)
{
    struct point clear = {1, 1, 1};
    struct ray ray = {p, direction};
    for (int i = 0; i < s->body_count; i++) {
        real t[4];
        int n = oracle_body_roots(&s->primitives[i], ray, t);
        for (int k = 0; k < n; k++)
            if (t[k] > s->tie && t[k] < reach - s->tie)
                clear = point_product(clear, s->primitives[i].material.kt);
    }
    return clear;
}

/* T(p) of a light with a disk, from points in a sunflower pattern, which has equal areas per point
 * and nothing in common with the renderer's sampling. `direction` is the unit direction to the
 * disk's centre, `reach` the distance. */
static struct point disk_transmittance(const struct oracle_scene *s,
                                       const struct oracle_light *light,
                                       const struct oracle_material *m, struct point p,
                                       struct point n, struct point direction, real reach)
{
    enum { POINTS = 640 };
    const real golden_turn = 2.39996322972865332223155550663361385L;
    bool far = light->kind == ORACLE_DIRECTIONAL;
    struct point u = point_across(direction), v = point_cross(direction, u), sum = {0, 0, 0};
    for (int i = 0; i < POINTS; i++) {
        real r = light->radius * sqrtl((i + 0.5L) / POINTS), turn = i * golden_turn;
        struct point to = point_times(direction, far ? 1 : reach);
        to = point_sum(to, point_times(u, r * cosl(turn)));
        to = point_sum(to, point_times(v, r * sinl(turn)));
        real length = far ? HUGE_VALL : point_length(to);
        struct point t = transmittance(s, p, point_unit(to), length);
        if (point_dot(n, to) <= 0) /* this light comes from behind the surface at p */
            t = point_product(t, m->kt);
        sum = point_sum(sum, t);
    }
    return point_times(sum, 1.0L / POINTS);
}

static real power(real base, real exponent)
{
    return base <= 0 ? 0 : powl(base, exponent);
}

static struct point light_at(const struct oracle_scene *s, const struct oracle_light *light,
                             const struct oracle_material *m, struct point p, struct point n,
                             struct point v)
{
    struct point none = {0, 0, 0}, l = light->direction, arriving = light->intensity;
    real reach = HUGE_VALL;
    if (light->kind != ORACLE_DIRECTIONAL) {
        l = point_difference(p, light->position);
        reach = point_length(l);
        l = point_times(l, 1 / reach);
        real fade = light->kc + light->kl * reach + light->kq * reach * reach;
        if (light->kind == ORACLE_SPOT)
            fade /= power(point_dot(light->direction, l), light->beam_exponent);
        arriving = point_times(arriving, 1 / fade);
    }
    real facing = point_dot(n, l);
    if (facing >= 0)
        return none;
    struct point r = point_difference(l, point_times(n, 2 * facing));
    struct point term = point_sum(point_times(m->kd, -facing),
                                  point_times(m->ks, power(-point_dot(v, r), m->shininess)));
    struct point direction = point_times(l, -1);
    if (light->shadows && light->radius > 0)
        arriving = point_product(arriving, disk_transmittance(s, light, m, p, n, direction, reach));
    else if (light->shadows)
        arriving = point_product(arriving, transmittance(s, p, direction, reach));
    return point_product(arriving, term);
}

/* The state of a path. */
struct progress {
    struct place after;
    int depth; /* surfaces shaded before */
    struct point weight;
    struct oracle_chance chance;
};

static struct point seen(const struct oracle_scene *s, struct ray ray, struct progress path);

/* The colour that a secondary ray adds, multiplied by its factor. */
static struct point secondary(const struct oracle_scene *s, struct ray ray, struct progress path,
                              struct point factor)
{
    struct point none = {0, 0, 0};
    path.weight = point_product(path.weight, factor);
    path.depth++;
    real most = point_largest(path.weight);
    if (path.depth >= s->max_depth || most <= 0 || most < s->min_contribution)
        return none;
    return point_product(factor, seen(s, ray, path));
}

static struct point sky_seen(const struct oracle_scene *s, struct point direction)
{
    real sine = point_dot(point_unit(direction), s->sky_up);
    struct point pole = sine > 0 ? s->zenith : s->nadir;
    real high = sine > 0 ? sine : -sine;
    return point_sum(point_times(s->background, 1 - high), point_times(pole, high));
}

/* All that is at one place of a ray. Surfaces of solids there are one boundary: the first in the
 * document shades, and every kt multiplies. Other surfaces are met one after another. */
struct boundary {
    int last; /* primitive */
    struct point kt;
};

static struct boundary boundary_at(const struct oracle_scene *s, struct ray ray, struct place hit)
{
    struct boundary found = {hit.prim, s->primitives[hit.prim].material.kt};
    for (int i = hit.prim + 1; i < s->body_count && s->primitives[hit.prim].solid >= 0; i++) {
        real t[4];
        int n = oracle_body_roots(&s->primitives[i], ray, t);
        bool here = false;
        for (int k = 0; k < n; k++)
            here = here || fabsl(t[k] - hit.t) <= s->tie;
        if (here && s->primitives[i].solid >= 0) {
            found.last = i;
            found.kt = point_product(found.kt, s->primitives[i].material.kt);
        }
    }
    return found;
}

/* How a surface bends the ray that meets it at p: only one of a solid does. */
static struct oracle_bend bend_at(const struct oracle_scene *s, const struct oracle_primitive *b,
                                  struct ray ray, struct point p, struct point n)
{
    if (b->solid < 0)
        return oracle_bend(ray.direction, n, 1, 1);
    struct point step = point_times(n, s->step);
    real before = oracle_index_at(s, point_sum(p, step));
    real behind = oracle_index_at(s, point_difference(p, step));
    return oracle_bend(ray.direction, n, before, behind);
}

/* What a surface itself sends along the ray. */
static struct point own_light(const struct oracle_scene *s, const struct oracle_material *m,
                              struct point p, struct point n, struct point direction, bool primary)
{
    struct point sum = m->emission;
    if (primary)
        sum = point_sum(sum, point_product(s->ambient, m->ka));
    for (int i = 0; i < s->light_count; i++)
        sum = point_sum(sum, light_at(s, &s->lights[i], m, p, n, direction));
    return sum;
}

/* A ray that keeps its direction is still the same ray, so that it meets what is at the same place
 * later in the document. One with a new direction starts at p, and does too. */
static struct point seen(const struct oracle_scene *s, struct ray ray, struct progress path)
{
    struct place hit;
    if (!next_hit(s, ray, path.after, &hit))
        return sky_seen(s, ray.direction);
    const struct oracle_primitive *b = &s->primitives[hit.prim];
    const struct oracle_material *m = &b->material;
    struct point p = ray_at(ray, hit.t), n = normal_at(b, p, s->tie);
    if (point_dot(n, ray.direction) > 0)
        n = point_times(n, -1);
    struct point sum = own_light(s, m, p, n, ray.direction, path.depth == 0);

    const struct boundary all = boundary_at(s, ray, hit);
    const struct oracle_bend bend = bend_at(s, b, ray, p, n);
    struct progress through = path, away = path;
    through.after = (struct place){hit.t, all.last};
    if (bend.bent || m->transmission_blur > 0) {
        ray.from = p;
        ray.direction = oracle_blurred(path.chance, bend.into, n, m->transmission_blur);
        through.after.t = 0;
    }
    struct point into = point_times(all.kt, 1 - bend.reflected);
    sum = point_sum(sum, secondary(s, ray, through, into));
    away.after = (struct place){0, -1};
    ray.from = p;
    ray.direction = oracle_blurred(path.chance, bend.away, n, m->reflection_blur);
    struct point back = point_sum(m->kr, point_times(all.kt, bend.reflected));
    return point_sum(sum, secondary(s, ray, away, back));
}

/* Random numbers for callers that have none: a linear congruential generator (Knuth, MMIX). */
static double own_uniform(void *user)
{
    uint64_t *state = user;
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

/* A lens bends all rays from one point of the image to where the ray through its middle meets the
 * plane in focus. */
void oracle_sample(const struct oracle_scene *s, int width, int height,
                   const struct oracle_camera_point *at, double rgb[3])
{
    real w = s->square_pixels ? s->plane_height * width / height : s->plane_width;
    real right = w * (at->x / (real)width - 0.5L);
    real up = s->plane_height * (0.5L - at->y / (real)height);
    struct point straight =
        point_sum(point_times(s->forward, s->distance),
                  point_sum(point_times(s->right, right), point_times(s->up, up)));
    struct point aside = point_sum(point_times(s->right, s->aperture * at->lens_x),
                                   point_times(s->up, s->aperture * at->lens_y));
    struct point start = point_sum(s->eye, aside);
    struct point focus = point_sum(s->eye, point_times(straight, s->focus / s->distance));
    struct point direction = s->aperture > 0 ? point_difference(focus, start) : straight;
    uint64_t state = (uint64_t)llrint(at->x * 4096) * 2654435761u + (uint64_t)llrint(at->y * 4096);
    struct oracle_chance chance = {at->uniform, at->user};
    if (!at->uniform)
        chance = (struct oracle_chance){own_uniform, &state};
    struct progress begin = {{0, -1}, 0, {1, 1, 1}, chance};
    struct point c = seen(s, (struct ray){start, point_unit(direction)}, begin);
    rgb[0] = (double)c.x;
    rgb[1] = (double)c.y;
    rgb[2] = (double)c.z;
}

void oracle_pixel(const struct oracle_scene *s, int width, int height, int x, int y, double rgb[3])
{
    const struct oracle_camera_point middle = {.x = x + 0.5, .y = y + 0.5};
    oracle_sample(s, width, height, &middle, rgb);
}
