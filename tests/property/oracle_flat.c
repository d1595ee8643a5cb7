/* SPDX-License-Identifier: MIT */
/* Planes in 113 bits. */
#include "property/oracle_quad.h"

static struct quad3 normal_of(const struct pen_vec3 v[3])
{
    return q_cross(q_sub(q3(v[1]), q3(v[0])), q_sub(q3(v[2]), q3(v[0])));
}

static bool meet(struct quad3 p, struct quad3 n, struct oracle_ray ray, struct truth *t)
{
    quad nd = q_dot(n, q3(ray.d));
    if (nd == 0)
        return false;
    *t = q_truth(q_dot(n, q_sub(p, q3(ray.o))) / nd);
    return true;
}

bool oracle_plane(const struct pen_vec3 v[3], struct oracle_ray ray, struct truth *t)
{
    return meet(q3(v[0]), normal_of(v), ray, t);
}

bool oracle_plane_at(struct pen_vec3 p, struct pen_vec3 n, struct oracle_ray ray, struct truth *t)
{
    return meet(q3(p), q3(n), ray, t);
}

double oracle_flat_residual(const struct pen_vec3 v[3], struct oracle_ray ray, double t)
{
    struct quad3 n = normal_of(v), f = q_sub(q3(ray.o), q3(v[0]));
    quad off = q_abs(q_dot(n, q_along(f, q3(ray.d), t))) / q_length(n), reach = 0;
    for (int i = 0; i < 3; i++) {
        quad length = q_length(q_sub(q3(v[i]), q3(ray.o)));
        reach = length > reach ? length : reach;
    }
    return (double)(off / (U * (reach + q_abs(t) * q_length(q3(ray.d)))));
}

double oracle_flat_cosine(const struct pen_vec3 v[3], struct oracle_ray ray)
{
    struct quad3 n = normal_of(v), d = q3(ray.d);
    return (double)(q_abs(q_dot(n, d)) / (q_length(n) * q_length(d)));
}

bool oracle_depth_between(const struct pen_vec3 *v, int count, struct oracle_ray ray, double t,
                          double k)
{
    struct quad3 d = q3(ray.d);
    quad lo = (quad)INFINITY, hi = -(quad)INFINITY, size = 0;
    for (int i = 0; i < count; i++) {
        struct quad3 f = q_sub(q3(v[i]), q3(ray.o));
        quad depth = q_dot(f, d) / q_dot(d, d), length = q_length(f) / q_length(d);
        lo = depth < lo ? depth : lo;
        hi = depth > hi ? depth : hi;
        size = length > size ? length : size;
    }
    return t >= lo - k * U * size && t <= hi + k * U * size;
}
