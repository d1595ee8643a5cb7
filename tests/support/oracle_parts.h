/* SPDX-License-Identifier: MIT */
/* The types and functions that the files of the oracle share. */
#ifndef TESTS_SUPPORT_ORACLE_PARTS_H
#define TESTS_SUPPORT_ORACLE_PARTS_H

#include <math.h>
#include <stdbool.h>

typedef long double real;

struct point {
    real x, y, z;
};

static inline struct point point_sum(struct point a, struct point b)
{
    return (struct point){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline struct point point_difference(struct point a, struct point b)
{
    return (struct point){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline struct point point_times(struct point a, real s)
{
    return (struct point){a.x * s, a.y * s, a.z * s};
}
/* Component by component: colours. */
static inline struct point point_product(struct point a, struct point b)
{
    return (struct point){a.x * b.x, a.y * b.y, a.z * b.z};
}
static inline real point_dot(struct point a, struct point b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct point point_cross(struct point a, struct point b)
{
    return (struct point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline real point_length(struct point a)
{
    return sqrtl(point_dot(a, a));
}
static inline struct point point_unit(struct point a)
{
    return point_times(a, 1 / point_length(a));
}
/* A unit vector perpendicular to a unit vector. */
static inline struct point point_across(struct point n)
{
    struct point other = fabsl(n.x) < 0.5L ? (struct point){1, 0, 0} : (struct point){0, 1, 0};
    return point_unit(point_cross(n, other));
}
static inline real point_largest(struct point a)
{
    return fmaxl(a.x, fmaxl(a.y, a.z));
}

struct ray {
    struct point from, direction; /* direction: unit */
};

struct oracle_material {
    struct point emission, ka, kd, ks, kt, kr;
    real shininess, ior;
    bool ior_written;
    real reflection_blur, transmission_blur; /* half-angles of cones in degrees */
};

enum oracle_kind {
    ORACLE_SPHERE,
    ORACLE_PLANE,
    ORACLE_RING,
    ORACLE_INFINITE_CYLINDER,
    ORACLE_CYLINDER,
    ORACLE_CONE
};

/* A primitive in world space. */
struct oracle_primitive {
    enum oracle_kind kind;
    struct oracle_material material;
    struct point origin; /* the centre, a point of the plane or axis, or the centre of the base */
    struct point
        axis; /* unit: of the infinite cylinder or cylinder; the normal of a flat primitive */
    real radius, height;
    real top; /* radius of a cone at its height */
    bool caps;
    int count; /* corners of a triangle or polygon */
    struct point *corners;
    const struct json_t *written; /* the material in the document: a name or an object */
    int solid;                    /* the first primitive of the solid it belongs to; -1: none */
    int solid_end;                /* of that first one: after the solid's last primitive */
    real solid_volume;            /* of that first one */
};

enum oracle_light_kind { ORACLE_DIRECTIONAL, ORACLE_POINT, ORACLE_SPOT };

struct oracle_light {
    enum oracle_light_kind kind;
    struct point intensity, position, direction; /* direction: unit */
    real kc, kl, kq, beam_exponent;
    real radius; /* of the disk; directional: at distance 1 */
    bool shadows;
};

struct oracle_scene {
    struct point background, ambient;     /* with a sky: its horizon */
    struct point zenith, nadir, sky_up;   /* without one, background; sky_up: unit */
    struct point eye, forward, right, up; /* unit frame */
    real distance, plane_width, plane_height;
    real aperture, focus; /* aperture 0: a pinhole */
    bool square_pixels;   /* the plane's width follows the image's shape */
    int max_depth;
    real min_contribution;
    real tie;  /* distances that differ by less count as the same place */
    real step; /* from a surface to the points whose index counts as that of its sides */
    struct json_t *document;
    int body_count, body_capacity, light_count;
    struct oracle_primitive *primitives;
    struct oracle_light *lights;
};

/* Finds the distances along a ray, also behind its start, at which it meets a primitive. Returns
 * their number. */
int oracle_body_roots(const struct oracle_primitive *b, struct ray ray, real t[4]);

/* Finds the solids: sets `solid` of every primitive, and `step`. */
void oracle_solids_find(struct oracle_scene *s);

/* The index of refraction at a point. */
real oracle_index_at(const struct oracle_scene *s, struct point p);

/* What a boundary between two indices does with a ray. */
struct oracle_bend {
    bool bent;               /* the indices differ */
    real reflected;          /* Fresnel's reflectance: 1 at total internal reflection */
    struct point away, into; /* unit: mirrored, and refracted if `reflected` is below 1 */
};

/* `n`: the unit normal on the side the ray comes from. */
struct oracle_bend oracle_bend(struct point direction, struct point n, real before, real behind);

/* A source of random numbers in [0, 1). */
struct oracle_chance {
    double (*uniform)(void *user);
    void *user;
};

/* Returns a random unit vector less than `degrees` from `middle`, on the same side of the plane
 * across n, uniform in solid angle. With 0 degrees it is the middle itself. */
struct point oracle_blurred(struct oracle_chance chance, struct point middle, struct point n,
                            real degrees);

#endif
