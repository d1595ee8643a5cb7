/* SPDX-License-Identifier: MIT */
/* Flat primitives and surfaces made of them: H038 to H058, H087. */
#include <stddef.h>

#include "property/rows.h"

const struct row row_table_flat[] = {
    {
        .id = "H038 H039",
        .name = "h038_watertight",
        .what =
            "a closed surface of 420 triangles is crossed an odd number of times from inside, at "
            "offsets 0, 1e6 and 1e9",
        .oracle = "parity",
        .run = rows_bumpy,
        .full = 4000000,
    },
    {
        .id = "H038 H039",
        .name = "mesh_closed",
        .what = "a closed mesh, thin, tiny or turned, is crossed an odd number of times from "
                "inside, an even number of times from up to 2^45 sizes away",
        .oracle = "parity",
        .run = rows_meshes,
        .full = 4000000,
        .check = 100000,
    },
    {
        .id = "H040",
        .name = "h040_embree",
        .what = "Embree's sphere and square of 200 x 200 squares each at (148376, 1234, -223423): "
                "no leak, no double hit, at random, corners and edges",
        .oracle = "count",
        .run = rows_embree,
    },
    {
        .id = "H041",
        .name = "h041_antisymmetry",
        .what = "dop(P, Q) and dop(Q, P) have opposite signs, and the right ones",
        .oracle = "exact sign by expansions",
        .run = rows_antisymmetry,
    },
    {
        .id = "H042",
        .name = "h042_roles",
        .what = "an outline begun at another vertex or reversed gives the same hit and the same t: "
                "every vertex plays every role",
        .oracle = "the primitive itself, bit for bit",
        .run = rows_roles,
    },
    {
        .id = "H047 H136",
        .name = "over_floor",
        .what =
            "from 1e-30 to 1 above a floor of triangles or a quad, 1 to 1e12 wide, the floor is "
            "met, t within 6 u",
        .oracle = "the floor is y = 0",
        .run = rows_over_floor,
    },
    {
        .id = "H043",
        .name = "h043_needle",
        .what = "triangles of aspect down to 1e-12: hit or miss outside BE(8) right, t within 16 u",
        .oracle = "exact winding; 113-bit plane",
        .run = rows_needle,
    },
    {
        .id = "H043",
        .name = "h043_needle_grazed",
        .what = "the same for rays within 0.1 rad of the needle's plane",
        .oracle = "113-bit plane",
        .run = rows_needle_grazed,
    },
    {
        .id = "H043 H142",
        .name = "h043_needle_thin",
        .what =
            "triangles and quadrilaterals of aspect 1e-10 to 1e-60: made if their exact area is "
            "not 0, the normal within 16 u, hit or miss right along an axis, else outside BE(8)",
        .oracle = "exact area, normal and winding by expansions",
        .run = rows_thin,
    },
    {
        .id = "H044",
        .name = "h044_needle_fan",
        .what = "1000 triangles of apex angle 1e-7 that share a vertex: a ray at the vertex or a "
                "shared edge hits one",
        .oracle = "count = 1",
        .run = rows_fan,
    },
    {
        .id = "H045",
        .name = "h045_degenerate",
        .what = "triangles whose vertices lie on one line are refused, all others of any size are "
                "made; t is a number",
        .oracle = "exact cross product",
        .run = rows_degenerate,
    },
    {
        .id = "H046",
        .name = "h046_pbrt",
        .what = "pbrt's bad case and its neighbours within ulps: no hit",
        .oracle = "exact winding",
        .run = rows_pbrt,
    },
    {
        .id = "H047",
        .name = "h047_grazing_thin",
        .what = "a thin triangle at 0.52 degrees in random poses: hit or miss outside BE(8) right, "
                "t among the depths of the vertices",
        .oracle = "exact winding; 113-bit depths",
        .run = rows_grazed,
    },
    {
        .id = "H048",
        .name = "h048_edge_on",
        .what = "a ray in the triangle's plane: no hit where the shear is exact, else t among the "
                "depths of the vertices",
        .oracle = "exact lattice",
        .run = rows_edge_on,
    },
    {
        .id = "H049",
        .name = "h049_tiling",
        .what = "64 x 64 squares split both ways: each lattice point belongs to one triangle",
        .oracle = "count = 1",
        .run = rows_tiling,
    },
    {
        .id = "H050 H057",
        .name = "h050_folded_sheet",
        .what =
            "a folded sheet of triangles and concave polygons is crossed exactly once, at offsets "
            "0, 1e6 and 1e9",
        .oracle = "count = 1",
        .run = rows_sheet,
        .full = 4000000,
    },
    {
        .id = "H051",
        .name = "h051_t_junction",
        .what = "a vertex that rests on a long edge",
        .status = ROW_INAPPLICABLE,
        .why = "input is never repaired: validate warns of T-junctions (tests/io/test_warnings.c)",
    },
    {
        .id = "H052",
        .name = "h052_star",
        .what =
            "a concave star and the triangles in its notches: exactly one is hit, the right one",
        .oracle = "count = 1; exact winding",
        .run = rows_star,
    },
    {
        .id = "H053",
        .name = "h053_bow_tie",
        .what = "a self-crossing outline",
        .status = ROW_INAPPLICABLE,
        .why = "self-crossing outlines are refused (tests/scene/test_polygon_check.c)",
    },
    {
        .id = "H054",
        .name = "h054_bent",
        .what = "a sheet of squares with vertices off their planes by 1e-7 has no cracks",
        .oracle = "count = 1",
        .run = rows_bent,
    },
    {
        .id = "H134",
        .name = "bent_rooms",
        .what = "rooms whose floor, ceiling and walls are polygons with corners up to 1e-6 of "
                "their size off the plane, seen at a wall's foot: black",
        .oracle = "black",
        .run = rows_bent_rooms,
        .full = 20000,
        .check = 150,
    },
    {
        .id = "H134",
        .name = "bent_foot",
        .what = "at the foot of a wall on such a floor, all is lit that faces the light",
        .oracle = "nothing stands between",
        .run = rows_bent_foot,
        .full = 20000,
        .check = 200,
    },
    {
        .id = "H055",
        .name = "h055_circle",
        .what =
            "a circle of 10 000 corners and its complement: exactly one is hit at corners and at "
            "the middles of edges",
        .oracle = "count = 1",
        .run = rows_circle,
    },
    {
        .id = "H055",
        .name = "h055_circle_area",
        .what = "the share of random rays that hit the circle of 10 000 corners is its area",
        .oracle = "closed form, 5 sigma",
        .run = rows_circle_area,
        .full = 40,
        .check = 2,
    },
    {
        .id = "H056",
        .name = "h056_huge_beside_small",
        .what = "a tetrahedron with edges of 1e6 and 1e-6: a line through a point inside hits two "
                "faces",
        .oracle = "exact inside; count = 2",
        .run = rows_huge_small,
    },
    {
        .id = "H058",
        .name = "h058_glass_cube",
        .what = "a shadow ray from outside at edges and corners of a glass cube of 12 triangles "
                "passes two of them or none",
        .oracle = "count",
        .run = rows_glass_cube,
    },
    {
        .id = "H087 O1 plane",
        .name = "h087_plane",
        .what = "planes hit at any angle down to 1e-300: the class is exact, t a number, the point "
                "within 8 u of the plane",
        .oracle = "113 bits",
        .run = rows_plane,
    },
    {.id = NULL},
};
