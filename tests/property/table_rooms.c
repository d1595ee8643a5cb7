/* SPDX-License-Identifier: MIT */
/* Rows of closed rooms, of the horizon, and of convex bodies. */
#include <stddef.h>

#include "property/rows.h"

const struct row row_table_rooms[] = {
    {
        .id = "H073 H139",
        .name = "rooms_flat",
        .what =
            "closed rooms of flat walls (boxes, prisms, pyramids, dented ones, whole or split), "
            "sizes 1e-8 to 1e8, offsets to 1e9 sizes, lights outside in walls' planes and near "
            "seams: black",
        .oracle = "black",
        .run = rows_rooms_flat,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H073",
        .name = "rooms_crossing",
        .what =
            "the same where walls cross, are planes, or are boxes themselves (these at offsets: "
            "black, or with the warning)",
        .oracle = "black",
        .run = rows_rooms_crossing,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H073",
        .name = "rooms_round",
        .what = "the same inside a sphere, a cylinder, a cone",
        .oracle = "black",
        .run = rows_rooms_round,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H073 H138",
        .name = "rooms_mixed",
        .what = "the same where surfaces of several kinds close the room: open cylinders and cones "
                "with sheets, planes or flat cylinders for lids",
        .oracle = "black",
        .run = rows_rooms_mixed,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H073 H137",
        .name = "rooms_thin",
        .what = "the same in boxes and prisms of 2^-1 to 2^-30 of their width",
        .oracle = "black",
        .run = rows_rooms_thin,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H073 H135",
        .name = "floor_rooms",
        .what = "rooms of 3 to 8 walls on a floor 1e2 to 1e12 times as wide (a plane, a quad, "
                "triangles, a polygon), lights in its plane and under it: black",
        .oracle = "black",
        .run = rows_floor_rooms,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H066 H135",
        .name = "floor_foot",
        .what = "the same from outside, at the foot of a wall that faces the lights: as without "
                "shadows",
        .oracle = "convex",
        .run = rows_floor_foot,
        .full = 50000,
        .check = 300,
    },
    {
        .id = "H096 H102",
        .name = "rooms_same",
        .what = "the same rooms, some with a light inside: the same picture with every accelerator "
                "and with base instructions",
        .oracle = "itself, bit for bit",
        .run = rows_rooms_same,
        .full = 20000,
        .check = 200,
    },
    {
        .id = "H073 H129",
        .name = "horizon_walls",
        .what =
            "a room of six polygons in a turned group, highlights, a light along a wall, in its "
            "plane 1e2 to 1e8 away, 1e-14 to 1e-9 over it behind the next wall, or within rounding "
            "of it just beyond its edge: black",
        .oracle = "black",
        .run = rows_horizon_walls,
        .full = 50000,
        .check = 1000,
    },
    {
        .id = "H121 H131",
        .name = "horizon_disk",
        .what =
            "a disk light that the horizon of a floor or a sphere cuts: samples within 2^-22 of "
            "it bring nothing and cast no ray, those below it bring kt",
        .oracle = "closed form, 2 percent",
        .run = rows_horizon_disk,
        .full = 5000,
        .check = 200,
    },
    {
        .id = "H066",
        .name = "convex_lit",
        .what =
            "convex solids of every kind, and ones that stand on each other without a gap, seen "
            "from outside under one light: what faces the light by more than 2^-22 is lit as "
            "without shadows, what does not is black",
        .oracle = "shaded in long double",
        .run = rows_convex_lit,
        .full = 50000,
        .check = 1000,
    },
    {
        .id = "H066 H130",
        .name = "convex_horizon",
        .what = "the same with the light within 1e-5 of the tangent plane where one looks",
        .oracle = "shaded in long double",
        .run = rows_convex_horizon,
        .full = 50000,
        .check = 1000,
    },
    {
        .id = "H073 H113",
        .name = "corners",
        .what =
            "edges and vertices of mirrored wedges, corners and rooms, of 3 to 90 degrees, at "
            "scales, turns and parities: what the eye sees 1e-6 beside it, on one side at least",
        .oracle = "itself, beside the edge",
        .run = rows_corners,
        .full = 1500000,
        .check = 500,
    },
    {
        .id = "H073 H113",
        .name = "corner_chains",
        .what =
            "the same of rooms and prisms of glass, seen in a mirror, through glass, far from the "
            "document's origin, or so that one path meets several corners",
        .oracle = "itself, beside the edge",
        .run = rows_corner_chains,
        .full = 1200000,
        .check = 500,
    },
    {
        .id = "H073 H113",
        .name = "corner_obtuse",
        .what = "the same at edges of more than 90 degrees",
        .oracle = "itself, beside the edge",
        .known = "where a path is mirrored once at each of several such edges, the faces it meets "
                 "are right one by one, but not what one eye sees",
        .run = rows_corner_obtuse,
        .full = 100000,
        .check = 500,
    },
    {
        .id = "H073 H113",
        .name = "corner_blocks",
        .what = "the same by blocks and by single pixels",
        .oracle = "itself, bit for bit",
        .run = rows_corner_blocks,
        .full = 1000000,
        .check = 1000,
    },
    {
        .id = "H113",
        .name = "corner_furnaces",
        .what = "there, closed mirrored rooms and prisms of glass that emit what they keep are as "
                "bright as their surroundings, but for what max_depth cuts",
        .oracle = "closed form",
        .run = rows_corner_furnaces,
        .full = 1500000,
        .check = 60,
    },
    {
        .id = "H073",
        .name = "corner_rooms",
        .what = "closed mirrored rooms, their edges and vertices seen from 1e-12 to 1e-1 of a "
                "wall: black",
        .oracle = "black",
        .run = rows_corner_rooms,
        .full = 1000000,
        .check = 1000,
    },
    {.id = NULL},
};
