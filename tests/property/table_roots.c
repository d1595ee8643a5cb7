/* SPDX-License-Identifier: MIT */
/* Intersections against 113 bits: oracle O1. */
#include <stddef.h>

#include "property/rows.h"

static const char roots_oracle[] = "113-bit roots; class by growing and shrinking the primitive";

const struct row row_table_roots[] = {
    {
        .id = "O1",
        .name = "o1_oracle",
        .what = "the oracle's roots in 113 bits agree with roots in 400 bits to 2^-6 ulp",
        .oracle = "MPFR, textbook formula; not compared if MPFR was missing at build time",
        .run = rows_oracle,
        .full = 10000,
        .check = 1000,
    },
    {
        .id = "O1 sphere",
        .name = "o1_sphere",
        .what =
            "passing within 0.9 r: t within 5 ulp from 2 r on, else within 8u (|f| + r); no wrong "
            "hit or miss outside BE(8)",
        .oracle = roots_oracle,
        .run = rows_sphere_roots,
    },
    {
        .id = "O1 sphere",
        .name = "o1_sphere_grazing",
        .what = "the same where the ray passes beyond 0.9 r, to tangents within 1e-16",
        .oracle = roots_oracle,
        .run = rows_sphere_grazing,
    },
    {
        .id = "O1 tube",
        .name = "o1_tube",
        .what =
            "axis near the origin, passing within 0.9 r, at any angle to the axis: t within 16 ulp "
            "from 2 r on, else "
            "within 8u (|f| + r); no wrong hit or miss outside BE(8)",
        .oracle = roots_oracle,
        .run = rows_tube_roots,
    },
    {
        .id = "O1 tube",
        .name = "o1_tube_grazing",
        .what = "the same where the ray passes beyond 0.9 r",
        .oracle = roots_oracle,
        .run = rows_tube_grazing,
    },
    {
        .id = "O1 tube",
        .name = "o1_tube_far",
        .what = "the same for thin tubes about 1 from the origin, and others up to 1e9 from it",
        .oracle = roots_oracle,
        .run = rows_tube_far,
    },
    {
        .id = "O1 cylinder",
        .name = "o1_cylinder",
        .what =
            "capped cylinders, aimed at sides, caps and rims: hit or miss, and t of the side, as "
            "for tubes",
        .oracle = roots_oracle,
        .run = rows_cylinder_roots,
    },
    {
        .id = "O1 cylinder",
        .name = "o1_cylinder_caps",
        .what = "intersections of the caps: t within 16 ulp from 2 r on, else within 8u (|f| + r)",
        .oracle = roots_oracle,
        .run = rows_cylinder_caps,
    },
    {
        .id = "O1 cylinder",
        .name = "o1_cylinder_grazing",
        .what = "the same where the ray passes the axis beyond 0.9 r",
        .oracle = roots_oracle,
        .run = rows_cylinder_grazing,
    },
    {
        .id = "O1 triangle",
        .name = "o1_triangle",
        .what = "ordinary triangles, up to 1e9 from the origin: the same",
        .oracle = "exact winding; 113-bit plane",
        .run = rows_triangle,
    },
    {
        .id = "O1 triangle",
        .name = "o1_triangle_grazed",
        .what = "the same for rays within 0.1 rad of the triangle's plane",
        .oracle = "113-bit plane",
        .run = rows_triangle_grazed,
    },
    {
        .id = "O1 polygon",
        .name = "o1_polygon",
        .what = "concave outlines: hit or miss outside BE(8) right, t among the depths of the "
                "vertices, within 8 u of the plane",
        .oracle = "exact winding; 113-bit plane",
        .run = rows_polygon,
    },
    {.id = NULL},
};
