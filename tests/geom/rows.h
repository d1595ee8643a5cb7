/* SPDX-License-Identifier: MIT */
/* Boundary cases as tables: rays, and the points where they should meet the primitives of a
 * world. */
#ifndef TESTS_GEOM_ROWS_H
#define TESTS_GEOM_ROWS_H

#include <check.h>

#include "support/world.h"

typedef struct pen_vec3 vec3;

/* One ray, and the points where it meets the world. */
struct row {
    vec3 o, d;
    int count;
    vec3 point[2];
};

/* The end of a row without intersections, or with one. */
#define NONE                                                                                       \
    0,                                                                                             \
    {                                                                                              \
        {0, 0, 0},                                                                                 \
        {                                                                                          \
            0, 0, 0                                                                                \
        }                                                                                          \
    }
#define ONE(...)                                                                                   \
    1,                                                                                             \
    {                                                                                              \
        {__VA_ARGS__},                                                                             \
        {                                                                                          \
            0, 0, 0                                                                                \
        }                                                                                          \
    }

/* Checks one ray: the number of intersections, unless the row marks it as unsure, and the last
 * points. Their components may be off by `ulps` ulps of 4. */
static inline void row_check(const struct world *w, const struct pen_origin_surface *origin,
                             const struct row *row, int number, double ulps)
{
    struct pen_hit hit[2];
    struct pen_ray ray = world_ray(row->o, row->d);
    int count = world_intersections(w, &ray, origin, INFINITY, hit, 2);
    ck_assert_msg(count == row->count, "row %d: %d intersections, not %d", number, count,
                  row->count);
    for (int k = 0; k < count; k++) {
        vec3 p = pen_along(ray.o, ray.d, hit[k].t), off = pen_sub(p, row->point[k]);
        double most = 8 * PEN_U * ulps;
        ck_assert_msg(fabs(off.x) <= most && fabs(off.y) <= most && fabs(off.z) <= most,
                      "row %d: (%a %a %a)", number, p.x, p.y, p.z);
    }
}

static inline void rows_check(const struct world *w, const struct row *row, int rows, double ulps)
{
    for (int i = 0; i < rows; i++)
        row_check(w, &pen_origin_none, &row[i], i, ulps);
}

/* Checks rays that start on the side of primitive 0, reached from outside. */
static inline void rows_check_leaving(const struct world *w, const struct row *row, int rows,
                                      double ulps)
{
    for (int i = 0; i < rows; i++) {
        struct pen_hit on = {0, 0, PEN_PART_SIDE};
        vec3 n = pen_prim_normal(&w->prims, on, row[i].o);
        bool through = pen_dot(n, row[i].d) < 0;
        struct pen_origin_surface origin =
            world_origin_surface(w, on, row[i].o, pen_neg(n), through);
        row_check(w, &origin, &row[i], i, ulps);
    }
}

#define ROWS(rows) (int)(sizeof(rows) / sizeof((rows)[0]))

#endif
