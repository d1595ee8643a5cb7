/* SPDX-License-Identifier: MIT */
#include "support/world.h"

#include <check.h>

void world_clear(struct world *w)
{
    w->corners = 0;
    if (w->arena)
        pen_arena_reset(w->arena);
    w->prims = (struct pen_prims){.ref = w->ref,
                                  .sphere = w->sphere,
                                  .plane = w->plane,
                                  .triangle = w->triangle,
                                  .polygon = w->polygon,
                                  .infinite_cylinder = w->infinite_cylinder,
                                  .cylinder = w->cylinder,
                                  .cone = w->cone};
}

static uint32_t add(struct world *w, uint32_t kind)
{
    uint32_t index = w->prims.kind_count[kind]++;
    ck_assert(w->prims.count < WORLD_MAX);
    w->ref[w->prims.count].kind = kind & 15u;
    w->ref[w->prims.count].index = index & 0x0fffffffu;
    w->prims.count++;
    return index;
}

static uint32_t last(const struct world *w)
{
    return w->prims.count - 1;
}

uint32_t world_sphere(struct world *w, struct pen_vec3 c, double r)
{
    ck_assert(pen_sphere_make(&w->sphere[add(w, PEN_PRIM_SPHERE)], c, r));
    return last(w);
}

uint32_t world_plane(struct world *w, struct pen_vec3 point, struct pen_vec3 normal)
{
    ck_assert(pen_plane_make(&w->plane[add(w, PEN_PRIM_PLANE)], point, normal));
    return last(w);
}

uint32_t world_triangle(struct world *w, struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c)
{
    a = pen_without_less(a, PEN_LEAST);
    b = pen_without_less(b, PEN_LEAST);
    c = pen_without_less(c, PEN_LEAST);
    ck_assert(pen_triangle_make(&w->triangle[add(w, PEN_PRIM_TRIANGLE)], a, b, c));
    return last(w);
}

uint32_t world_polygon(struct world *w, const struct pen_vec3 *v, uint32_t count)
{
    struct pen_vec3 *own = &w->corner[w->corners];
    w->corners += count;
    ck_assert(w->corners <= 8 * WORLD_MAX);
    for (uint32_t i = 0; i < count; i++)
        own[i] = pen_without_less(v[i], PEN_LEAST);
    struct pen_polygon *polygon = &w->polygon[add(w, PEN_PRIM_POLYGON)];
    if (!w->arena)
        w->arena = pen_arena_new(0);
    ck_assert(pen_polygon_make(polygon, own, count) && pen_polygon_cut(polygon, w->arena));
    return last(w);
}

uint32_t world_infinite_cylinder(struct world *w, struct pen_vec3 origin, struct pen_vec3 axis,
                                 double r)
{
    ck_assert(pen_infinite_cylinder_make(&w->infinite_cylinder[add(w, PEN_PRIM_INFINITE_CYLINDER)],
                                         origin, axis, r));
    return last(w);
}

uint32_t world_cylinder(struct world *w, struct pen_vec3 base, struct pen_vec3 axis, double r,
                        double h, bool caps)
{
    ck_assert(pen_cylinder_make(&w->cylinder[add(w, PEN_PRIM_CYLINDER)], base, axis, r, h, caps));
    return last(w);
}

uint32_t world_cone(struct world *w, struct pen_vec3 base, struct pen_vec3 axis,
                    const double radius[2], double h, bool caps)
{
    ck_assert(
        pen_cone_make(&w->cone[add(w, PEN_PRIM_CONE)], base, axis, radius[0], radius[1], h, caps));
    return last(w);
}

void world_box(struct world *w, struct pen_vec3 lo, struct pen_vec3 hi)
{
    static const int face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (int f = 0; f < 6; f++) {
        struct pen_vec3 v[4];
        for (int i = 0; i < 4; i++) {
            int c = face[f][i];
            v[i] = pen_vec3(c & 1 ? hi.x : lo.x, c & 2 ? hi.y : lo.y, c & 4 ? hi.z : lo.z);
        }
        world_polygon(w, v, 4);
    }
}

/* Makes a planar, star-shaped polygon around c. */
static void random_polygon(struct world *w, struct random *random, struct pen_vec3 c, double size)
{
    static const double circle[8][2] = {{1, 0},  {0.7, 0.7},   {0, 1},  {-0.7, 0.7},
                                        {-1, 0}, {-0.7, -0.7}, {0, -1}, {0.7, -0.7}};
    struct pen_vec3 n = random_direction(random);
    struct pen_vec3 x = pen_normalize(pen_cross(n, random_direction(random)));
    struct pen_vec3 y = pen_cross(n, x), v[8];
    uint32_t step = 1 + random_below(random, 2), count = 0;
    for (uint32_t i = 0; i < 8; i += step) {
        double r = random_in(random, 0.2, 1) * size;
        v[count++] = pen_along(pen_along(c, x, r * circle[i][0]), y, r * circle[i][1]);
    }
    world_polygon(w, v, count);
}

void world_random(struct world *w, struct random *random, uint32_t count, double size)
{
    for (uint32_t i = 0; i < count; i++) {
        struct pen_vec3 c = random_vec(random, 1);
        double s = size * random_in(random, 0.1, 1);
        struct pen_vec3 a = pen_along(c, random_direction(random), s), d = random_direction(random);
        switch (random_below(random, 16)) {
        case 0:
            world_plane(w, c, d);
            break;
        case 1:
            world_infinite_cylinder(w, c, d, 0.1 * s);
            break;
        case 2:
        case 3:
        case 4:
            world_cylinder(w, c, d, 0.3 * s, s, random_below(random, 2));
            break;
        case 5:
        case 6:
        case 7:
            world_sphere(w, c, s);
            break;
        case 8:
        case 9:
        case 10:
            random_polygon(w, random, c, s);
            break;
        case 11:
            world_box(w, c, pen_add(c, pen_vec3(s, 2 * s, s)));
            break;
        default:
            world_triangle(w, c, a, pen_along(c, d, s));
        }
    }
}

void world_bent(struct world *w, struct random *random, uint32_t count, double size)
{
    static const double outline[6][2] = {{1, 0},  {.5, .9},   {-.2, .1},
                                         {-1, 0}, {-.5, -.9}, {.4, -1}};
    for (uint32_t i = 0; i < count; i++) {
        struct pen_vec3 v[6], o = random_vec(random, 1), n = random_direction(random);
        struct pen_vec3 x = pen_normalize(pen_cross(n, random_direction(random)));
        struct pen_vec3 y = pen_cross(n, x);
        double off = size * exp2(random_in(random, -44, -20));
        for (int k = 0; k < 6; k++) {
            v[k] = pen_along(o, x, size * outline[k][0]);
            v[k] = pen_along(pen_along(v[k], y, size * outline[k][1]), n,
                             random_in(random, -off, off));
        }
        world_polygon(w, v, 6);
    }
}

struct pen_ray world_ray(struct pen_vec3 o, struct pen_vec3 d)
{
    struct pen_ray ray;
    ck_assert(pen_ray_make(&ray, o, d));
    return ray;
}

struct pen_origin_surface world_origin_surface(const struct world *w, struct pen_hit hit,
                                               struct pen_vec3 p, struct pen_vec3 v, bool through)
{
    return (struct pen_origin_surface){.prim = hit.prim,
                                       .part = hit.part,
                                       .through = through,
                                       .toward = pen_neg(v),
                                       .bound = pen_prim_rounding(&w->prims, hit.prim, p)};
}

struct pen_hit world_nearest(const struct world *w, const struct pen_ray *ray,
                             const struct pen_origin_surface *origin,
                             const struct pen_t_interval *interval)
{
    struct pen_hit best = {interval->tmax, PEN_NO_PRIM, 255};
    struct pen_intersections c;
    for (uint32_t prim = 0; prim < w->prims.count; prim++) {
        pen_prim_intersect(&w->prims, prim, ray, origin, &c);
        for (int i = 0; i < c.count; i++) {
            struct pen_hit h = {c.t[i], prim, c.part[i]};
            if (pen_hit_before(interval->after, h) && pen_hit_before(h, best))
                best = h;
        }
    }
    return best;
}

int world_intersections(const struct world *w, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin, double tmax, struct pen_hit *hit,
                        int room)
{
    int count = 0;
    struct pen_t_interval interval = {pen_after_start, tmax};
    for (;; count++) {
        interval.after = world_nearest(w, ray, origin, &interval);
        if (interval.after.prim == PEN_NO_PRIM)
            return count;
        if (count < room)
            hit[count] = interval.after;
    }
}

int world_count(const struct world *w, struct pen_vec3 o, struct pen_vec3 d)
{
    struct pen_ray ray = world_ray(o, d);
    return world_intersections(w, &ray, &pen_origin_none, INFINITY, NULL, 0);
}

void world_bumpy(struct world *w, struct random *random, struct pen_vec3 middle)
{
    enum { STACKS = 16, SLICES = 14 };
    static struct pen_vec3 grid[STACKS + 1][SLICES];
    for (int i = 0; i <= STACKS; i++) {
        for (int j = 0; j < SLICES; j++) {
            double theta = 3.14159265358979 * i / STACKS, phi = 6.28318530717959 * j / SLICES;
            struct pen_vec3 d = pen_vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
            bool pole = i == 0 || i == STACKS;
            if (pole)
                d = pen_vec3(0, 0, i == 0 ? 1 : -1);
            grid[i][j] = pole && j > 0 ? grid[i][0] : pen_along(middle, d, random_in(random, 1, 6));
        }
    }
    world_clear(w);
    for (int i = 0; i < STACKS; i++) {
        for (int j = 0; j < SLICES; j++) {
            int k = (j + 1) % SLICES;
            if (i < STACKS - 1)
                world_triangle(w, grid[i][j], grid[i + 1][j], grid[i + 1][k]);
            if (i > 0)
                world_triangle(w, grid[i][j], grid[i + 1][k], grid[i][k]);
        }
    }
}
