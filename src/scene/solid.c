/* SPDX-License-Identifier: MIT */
#include "scene/solid.h"

#include <math.h>

/* The number of times a ray leaves a primitive's inside minus the number it enters it. */
static int times_left(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                      bool turned)
{
    struct pen_intersections met = {.count = 0};
    int left = 0;
    pen_prim_intersect_line(prims, prim, ray, &met);
    const bool flat = pen_prim_flat(pen_prim_kind(prims, prim));
    for (int i = 0; i < met.count; i++) {
        if (!(met.t[i] > 0))
            continue;
        bool outward = i + 1 == met.count; /* for a closed round primitive, the last one */
        if (flat) {
            const struct pen_hit hit = {met.t[i], prim, met.part[i]};
            const struct pen_vec3 x = pen_along(ray->o, ray->d, hit.t);
            outward = (pen_dot(pen_prim_normal(prims, hit, x), ray->d) > 0) != turned;
        }
        left += outward ? 1 : -1;
    }
    return left;
}

static bool box_contains(const struct pen_box *b, struct pen_vec3 p)
{
    return p.x >= b->lo.x && p.x <= b->hi.x && p.y >= b->lo.y && p.y <= b->hi.y && p.z >= b->lo.z &&
           p.z <= b->hi.z;
}

static double length(struct pen_vec3 a)
{
    return sqrt(pen_dot(a, a));
}

/* A sum of angles, each less than half a turn. (c, s) is its direction; `turns` counts how often it
 * has passed half a turn. */
struct angle_sum {
    double c, s;
    int turns;
};

/* Adds the angle of a direction. */
static void add_angle(struct angle_sum *sum, double c, double s)
{
    const double re = sum->c * c - sum->s * s, im = sum->c * s + sum->s * c;
    const double norm = sqrt(re * re + im * im);
    if (norm == 0)
        return;
    sum->turns += (s > 0 && sum->s >= 0 && im < 0) - (s < 0 && sum->s < 0 && im >= 0);
    sum->c = re / norm;
    sum->s = im / norm;
}

/* Adds half the solid angle of a triangle as seen from the origin; it is positive as seen from
 * behind.
 * Source: van Oosterom, Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng.
 * 30(2), 1983. */
static void add_triangle(struct angle_sum *sum, struct pen_vec3 a, struct pen_vec3 b,
                         struct pen_vec3 c)
{
    const double la = length(a), lb = length(b), lc = length(c);
    add_angle(sum, la * lb * lc + pen_dot(a, b) * lc + pen_dot(a, c) * lb + pen_dot(b, c) * la,
              pen_dot(a, pen_cross(b, c)));
}

/* Whether faces surround p: then their generalised winding number is 1, and half of their solid
 * angles is a whole turn.
 * Source: Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized
 * winding numbers", ACM Trans. Graph. 32(4), 2013. */
static bool surrounds(const struct pen_prims *prims, const struct pen_solids *solids,
                      const struct pen_solid *s, struct pen_vec3 p)
{
    struct pen_triangle room;
    struct angle_sum half = {1, 0, 0};
    for (uint32_t i = 0; i < s->count; i++) {
        const struct pen_outline line = pen_prim_outline(prims, solids->prim[s->first + i], &room);
        const struct pen_vec3 a = pen_sub(line.v[0], p);
        for (uint32_t k = 1; k + 1 < line.count; k++)
            add_triangle(&half, a, pen_sub(line.v[k], p), pen_sub(line.v[k + 1], p));
    }
    return half.turns == 1 && half.c > 0 && fabs(half.s) < 1e-6;
}

bool pen_solid_contains(const struct pen_prims *prims, const struct pen_solids *solids,
                        uint32_t solid, struct pen_vec3 p)
{
    const struct pen_solid *s = &solids->at[solid];
    struct pen_ray ray;
    int left = 0;
    if (!box_contains(&s->box, p) ||
        !pen_ray_make(&ray, p, pen_vec3(0.5377, 0.7193, 0.4397))) /* any direction */
        return false;
    if (!s->closed)
        return surrounds(prims, solids, s, p);
    for (uint32_t i = 0; i < s->count; i++) {
        const uint32_t prim = solids->prim[s->first + i];
        left += times_left(prims, prim, &ray, solids->turned[prim]);
    }
    return left > 0;
}
