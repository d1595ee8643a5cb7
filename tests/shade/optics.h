/* SPDX-License-Identifier: MIT */
/* Snell's law, Fresnel's equations and convex solids in __float128, from the equations. */
#ifndef TESTS_SHADE_OPTICS_H
#define TESTS_SHADE_OPTICS_H

#include <stdbool.h>

#include "geom/quad.h"

static inline struct quad3 quad_scale(struct quad3 a, quad s)
{
    return (struct quad3){a.x * s, a.y * s, a.z * s};
}

static inline struct quad3 quad_along(struct quad3 a, struct quad3 d, quad t)
{
    return (struct quad3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}

static inline quad quad_length(struct quad3 a)
{
    return quad_sqrt(quad_dot(a, a));
}

static inline struct quad3 quad_unit(struct quad3 a)
{
    return quad_scale(a, 1 / quad_length(a));
}

/* A ray; d is unit. */
struct quad_ray {
    struct quad3 o, d;
};

/* What a surface does with a ray. */
struct quad_split {
    bool total;
    quad share; /* that is reflected */
    quad steep; /* the lesser of the cosines on both sides */
    struct quad3 refracted, reflected;
};

/* n: unit, on either side; the ray goes from index n1 to n2. */
static inline struct quad_split quad_refract(struct quad3 n, struct quad3 d, quad n1, quad n2)
{
    struct quad_split to = {.share = 1};
    const quad along = quad_dot(n, d), c = quad_abs(along), e = n1 / n2;
    const quad square = 1 - e * e * (1 - c * c);
    to.reflected = quad_along(d, n, -2 * along);
    to.total = square <= 0;
    if (to.total)
        return to;
    const quad t = quad_sqrt(square);
    const quad s = (e * c - t) / (e * c + t), p = (c - e * t) / (c + e * t);
    to.share = (s * s + p * p) / 2;
    to.steep = c < t ? c : t;
    to.refracted = quad_along(quad_scale(d, e), n, (e * c - t) * (along < 0 ? 1 : -1));
    return to;
}

/* Returns the distance at which a ray meets a plane. */
static inline quad quad_plane(struct quad3 point, struct quad3 n, const struct quad_ray *ray)
{
    return quad_dot(quad_sub(point, ray->o), n) / quad_dot(n, ray->d);
}

enum { CONVEX_FACES = 8 };

/* A convex solid: the points below all of its planes. */
struct convex {
    int count;
    struct quad3 point[CONVEX_FACES], n[CONVEX_FACES]; /* outward, unit */
};

/* Adds the plane of three points; `inner` is inside. */
static inline void convex_add(struct convex *solid, const struct pen_vec3 v[3],
                              struct pen_vec3 inner)
{
    const struct quad3 a = quad3(v[0]);
    const struct quad3 n =
        quad_unit(quad_cross(quad_sub(quad3(v[1]), a), quad_sub(quad3(v[2]), a)));
    const bool turned = quad_dot(n, quad_sub(quad3(inner), a)) > 0;
    solid->point[solid->count] = a;
    solid->n[solid->count++] = quad_scale(n, turned ? -1 : 1);
}

/* Where the line of a ray enters and leaves a convex solid, and through which planes. False if it
 * misses the solid, or if an edge is nearer than `margin`. */
struct crossing {
    quad t[2];
    int face[2];
};

static inline bool convex_cross(const struct convex *solid, const struct quad_ray *ray,
                                struct crossing *x, double margin)
{
    quad second[2] = {-1e9, 1e9};
    x->t[0] = -1e9;
    x->t[1] = 1e9;
    for (int i = 0; i < solid->count; i++) {
        const quad slope = quad_dot(solid->n[i], ray->d);
        const int side = slope > 0;
        const quad t = quad_plane(solid->point[i], solid->n[i], ray);
        if (side ? t < x->t[1] : t > x->t[0]) {
            second[side] = x->t[side];
            x->t[side] = t;
            x->face[side] = i;
        } else if (side ? t < second[1] : t > second[0]) {
            second[side] = t;
        }
    }
    return x->t[1] - x->t[0] > margin && x->t[0] - second[0] > margin &&
           second[1] - x->t[1] > margin;
}

/* Returns the part of light from outside along a ray that is still inside a convex solid after some
 * surfaces. In light that is the same everywhere, a path of that many surfaces lacks this part.
 * *sure is cleared if an edge is near. */
static inline quad convex_left(const struct convex *solid, struct quad_ray ray, double ior,
                               int surfaces, bool *sure)
{
    struct crossing x;
    if (!convex_cross(solid, &ray, &x, 1e-7)) {
        *sure = false;
        return 0;
    }
    struct quad_split split = quad_refract(solid->n[x.face[0]], ray.d, 1, ior);
    quad weight = surfaces > 1 ? 1 - split.share : 1;
    ray = (struct quad_ray){quad_along(ray.o, ray.d, x.t[0]), split.refracted};
    for (int i = 2; i < surfaces; i++) {
        *sure = *sure && convex_cross(solid, &ray, &x, 1e-7);
        split = quad_refract(solid->n[x.face[1]], ray.d, ior, 1);
        weight *= split.share;
        ray = (struct quad_ray){quad_along(ray.o, ray.d, x.t[1]), split.reflected};
    }
    return weight;
}

#endif
