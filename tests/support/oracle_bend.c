/* SPDX-License-Identifier: MIT */
/* The oracle's directions of secondary rays: mirrored, refracted, and blurred. */
#include "support/oracle.h"
#include "support/oracle_parts.h"

/* Snell's law for the part of the direction along the surface, and Fresnel's equations: the mean of
 * the reflectances of light polarised across and in the plane of incidence. */
struct oracle_bend oracle_bend(struct point direction, struct point n, real before, real behind)
{
    real cos_in = -point_dot(direction, n);
    struct point along = point_sum(direction, point_times(n, cos_in));
    struct point away = point_unit(point_sum(along, point_times(n, cos_in)));
    if (before == behind)
        return (struct oracle_bend){false, 0, away, direction};
    along = point_times(along, before / behind);
    if (point_dot(along, along) >= 1)
        return (struct oracle_bend){true, 1, away, direction};
    real cos_out = sqrtl(1 - point_dot(along, along));
    real across = (before * cos_in - behind * cos_out) / (before * cos_in + behind * cos_out);
    real within = (behind * cos_in - before * cos_out) / (behind * cos_in + before * cos_out);
    struct point into = point_unit(point_difference(along, point_times(n, cos_out)));
    return (struct oracle_bend){true, (across * across + within * within) / 2, away, into};
}

/* By Archimedes' theorem on the sphere and the cylinder, 1 - cos of the angle from the middle is
 * uniform. */
struct point oracle_blurred(struct oracle_chance chance, struct point middle, struct point n,
                            real degrees)
{
    const real pi = 3.14159265358979323846264338327950288L;
    real edge = sinl(degrees * pi / 360);
    struct point u = point_across(middle), v = point_cross(middle, u), d = middle;
    bool above = point_dot(middle, n) > 0;
    if (degrees <= 0)
        return middle;
    do {
        real drop = 2 * edge * edge * chance.uniform(chance.user);
        real turn = 2 * pi * chance.uniform(chance.user), wide = sqrtl(drop * (2 - drop));
        d = point_sum(point_times(u, wide * cosl(turn)), point_times(v, wide * sinl(turn)));
        d = point_sum(d, point_times(middle, 1 - drop));
    } while ((point_dot(d, n) > 0) != above);
    return point_unit(d);
}
