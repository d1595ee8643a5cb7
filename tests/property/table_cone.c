/* SPDX-License-Identifier: MIT */
/* Cones. */
#include <stddef.h>

#include "property/rows.h"

const struct row row_table_cone[] = {
    {
        .id = "O1 cone",
        .name = "o1_cone",
        .what =
            "cones of any shape, aimed at sides, caps, rims and the apex, along the axis and the "
            "side: t within 16 ulp or 4u (|f| + size) towards the part; no wrong hit or miss "
            "outside BE(8)",
        .oracle = "113-bit roots; class by growing and shrinking the cone",
        .run = rows_cone_roots,
    },
    {
        .id = "H078 H079 cone",
        .name = "cone_mapped",
        .what =
            "a mirrored or scaled cone has the same intersections to the last bit; with permuted "
            "axes the same ones, t within 32 ulp or 8u (|f| + size)",
        .oracle = "the cone as it was",
        .run = rows_cone_mapped,
    },
    {
        .id = "H059 cone",
        .name = "cone_left",
        .what =
            "a ray that starts on a cone does not hit it again outwards, and hits it once inwards",
        .oracle = "the normal at the point",
        .run = rows_cone_left,
    },
    {
        .id = "H091 cone",
        .name = "cone_boxes",
        .what = "the box holds the cone and reaches at most 128 u beyond it",
        .oracle = "113-bit support function",
        .run = rows_cone_boxes,
    },
    {
        .id = "H095 H096 cone",
        .name = "cone_trees",
        .what =
            "paths among cones: every tree, both variants, and shadow rays agree with brute force",
        .oracle = "all primitives, one by one",
        .run = rows_cone_trees,
    },
    {.id = NULL},
};
