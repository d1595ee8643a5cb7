/* SPDX-License-Identifier: MIT */
/* Rows of light and shadow. */
#include <stddef.h>

#include "property/rows.h"

const struct row row_table_light[] = {
    {
        .id = "H064",
        .name = "h064_contact_shadow",
        .what =
            "a ball of .05 on a floor, scaled by 2^-20 to 2^20, light at 45 degrees and others: "
            "the area of its shadow, lit and dark on either side of it, none lit at the contact",
        .oracle = "closed form: an ellipse, 1 percent",
        .run = rows_contact,
        .full = 5000,
        .check = 100,
    },
    {
        .id = "H065",
        .name = "h065_resting_box",
        .what = "pictures of the foot of a box on a floor, the light behind the box: no lit pixel",
        .oracle = "black",
        .run = rows_resting,
        .full = 100000,
        .check = 300,
    },
    {
        .id = "H066",
        .name = "h066_acne",
        .what =
            "a single convex primitive, lit at 89.999 degrees and down to 1e-12 rad, tubes along "
            "their axis too, and from inside: the same picture as without shadows",
        .oracle = "itself, bit for bit",
        .run = rows_acne,
        .full = 200000,
        .check = 700,
    },
    {
        .id = "H073",
        .name = "h073_closed_room",
        .what = "pictures of a closed room of mirrors, quads or triangles, at offsets up to 1e6, "
                "lights and background outside, from whole walls to 1e-7 of a seam: black",
        .oracle = "black",
        .run = rows_room,
        .full = 4000,
        .check = 40,
    },
    {
        .id = "H073",
        .name = "h073_at_seams",
        .what = "the same from 1e-7 to 1e-14 of a seam, where everything lies within rounding",
        .oracle = "black",
        .run = rows_seam,
        .full = 20000,
        .check = 300,
    },
    {
        .id = "H073",
        .name = "h073_crossing_walls",
        .what = "the same where the walls are planes, or quads that cross each other",
        .oracle = "black",
        .run = rows_crossing,
        .full = 20000,
        .check = 150,
    },
    {
        .id = "H073",
        .name = "h073_light_inside",
        .what = "the same rooms at their seams, with lights inside: as without shadows",
        .oracle = "itself, bit for bit",
        .run = rows_inside,
        .full = 4000,
        .check = 40,
    },
    {
        .id = "H066",
        .name = "h066_convex_edges",
        .what = "the same boxes from outside, from 1e-7 to 1e-14 of an edge: as without shadows",
        .oracle = "itself, bit for bit",
        .run = rows_outside,
        .full = 4000,
        .check = 40,
    },
    {
        .id = "H112 H146",
        .name = "h112_path_tree",
        .what = "paths that fork at 2 to 12 parallel sheets, to depths of 1 to 3000: the pixel and "
                "its rays are those of the tree in depth-first order, cut after 2048 surfaces or "
                "max_depth, and paths cut off are counted",
        .oracle = "a recursion over the numbers of the sheets, bit for bit",
        .run = rows_path_tree,
        .full = 50000,
        .check = 1500,
    },
    {
        .id = "H112 H146",
        .name = "h112_tree_ways",
        .what = "balls that reflect and transmit, to depths of 20 to 60, with 1, 2 and 8 threads, "
                "tiles of 1, 2 and 32, baseline and wider vectors, three accelerators, and in two "
                "parts: "
                "the same film and the same counts, whether trees are cut or not",
        .oracle = "itself, bit for bit",
        .run = rows_tree_ways,
        .full = 1000,
        .check = 4,
    },
    {
        .id = "H121 H141",
        .name = "h121_grid_points",
        .what =
            "the points of a light by `grid`, and their number: those of the first drawing that "
            "has any in the disk",
        .oracle = "the definition of the cells' points",
        .run = rows_grid_points,
    },
    {
        .id = "H073 H138",
        .name = "h073_round_rooms",
        .what =
            "closed rooms of open cylinders and cones with lids of polygons, cylinders and "
            "cones, mirrors, of any size, at offsets to 1e9 sizes, lights outside, from 1e-3 to "
            "1e-12 "
            "of a rim: black",
        .oracle = "black",
        .run = rows_round_rooms,
        .full = 9000,
        .check = 90,
    },
    {
        .id = "H073 H138",
        .name = "round_beside",
        .what =
            "the same where an open cylinder ends at another one, or at a closed one, of equal "
            "radius, at offsets to 1e9 sizes, where their axes are rounded apart: black, or the "
            "precision warning",
        .oracle = "black",
        .run = rows_round_beside,
        .full = 4000,
        .check = 20,
    },
    {
        .id = "H066 H138",
        .name = "h066_round_lid",
        .what = "convex solids of open cylinders and cones, quads and cones as lids, from 1e-7 to "
                "1e-12 of a rim, lit at 45 degrees and down to 3e-7 rad: as without shadows",
        .oracle = "itself, bit for bit",
        .run = rows_round_lid,
        .full = 9000,
        .check = 90,
    },
    {
        .id = "H073 H139",
        .name = "h073_dented_rooms",
        .what = "the same for closed rooms with dents, and for shallow ones of polygons of up to "
                "64 corners, at their edges and corners",
        .oracle = "black",
        .run = rows_dented_rooms,
        .full = 9000,
        .check = 30,
    },
    {
        .id = "H065 H138",
        .name = "h065_round_foot",
        .what = "the foot of cylinders and cones, open or not, on a floor, the light behind them: "
                "no lit pixel",
        .oracle = "black",
        .run = rows_round_foot,
        .full = 9000,
        .check = 90,
    },
    {
        .id = "H066 H138",
        .name = "round_front",
        .what = "the foot of closed and open cylinders and cones on a floor, and the floor before "
                "it, lit "
                "from the front down to 1e-6 rad: as without shadows",
        .oracle = "itself, bit for bit",
        .run = rows_round_front,
        .full = 9000,
        .check = 90,
    },
    {.id = NULL},
};
