/* SPDX-License-Identifier: MIT */
/* The rows, in the order of the catalogue. */
#include "property/rows.h"

static const struct row bumpy = {
    .id = "H038 H039",
    .name = "h038_watertight",
    .what = "a closed surface of 420 triangles is crossed an odd number of times from inside, at "
            "offsets 0, 1e6 and 1e9",
    .oracle = "parity",
    .run = rows_bumpy,
    .full = 4000000,
};

static const struct row sheet = {
    .id = "H050 H057",
    .name = "h050_folded_sheet",
    .what = "a folded sheet of triangles and concave polygons is crossed exactly once, at offsets "
            "0, 1e6 and 1e9",
    .oracle = "count = 1",
    .run = rows_sheet,
    .full = 4000000,
};

static const struct row embree = {
    .id = "H040",
    .name = "h040_embree",
    .what = "Embree's sphere and square of 200 x 200 squares each at (148376, 1234, -223423): "
            "no leak, no double hit, at random, corners and edges",
    .oracle = "count",
    .run = rows_embree,
};

static const struct row antisymmetry = {
    .id = "H041",
    .name = "h041_antisymmetry",
    .what = "dop(P, Q) and dop(Q, P) have opposite signs, and the right ones",
    .oracle = "exact sign by expansions",
    .run = rows_antisymmetry,
};

static const struct row roles = {
    .id = "H042",
    .name = "h042_roles",
    .what = "an outline begun at another vertex or reversed gives the same hit and the same t: "
            "every vertex plays every role",
    .oracle = "the body itself, bit for bit",
    .run = rows_roles,
};

static const struct row needle = {
    .id = "H043",
    .name = "h043_needle",
    .what = "triangles of aspect down to 1e-12: hit or miss outside BE(8) right, t within 16 u",
    .oracle = "exact winding; 113-bit plane",
    .run = rows_needle,
};

static const struct row triangle = {
    .id = "O1 triangle",
    .name = "o1_triangle",
    .what = "ordinary triangles, up to 1e9 from the origin: the same",
    .oracle = "exact winding; 113-bit plane",
    .run = rows_triangle,
};

static const struct row fan = {
    .id = "H044",
    .name = "h044_needle_fan",
    .what = "1000 triangles of apex angle 1e-7 that share a vertex: a ray at the vertex or a "
            "shared edge meets one",
    .oracle = "count = 1",
    .run = rows_fan,
    .full = 200000,
    .check = 3000,
};

static const struct row degenerate = {
    .id = "H045",
    .name = "h045_degenerate",
    .what = "triangles whose vertices lie on one line are refused, all others made, whatever "
            "their size; t is a number",
    .oracle = "exact cross product",
    .run = rows_degenerate,
};

static const struct row pbrt = {
    .id = "H046",
    .name = "h046_pbrt",
    .what = "pbrt's bad case and its neighbours within ulps: no hit",
    .oracle = "exact winding",
    .run = rows_pbrt,
};

static const struct row grazed = {
    .id = "H047",
    .name = "h047_grazing_thin",
    .what = "a thin triangle at 0.52 degrees in random poses: hit or miss outside BE(8) right, "
            "t among the depths of the vertices",
    .oracle = "exact winding; 113-bit depths",
    .run = rows_grazed,
};

static const struct row edge_on = {
    .id = "H048",
    .name = "h048_edge_on",
    .what = "a ray in the triangle's plane: no hit where the shear is exact, else t among the "
            "depths of the vertices",
    .oracle = "exact lattice",
    .run = rows_edge_on,
};

static const struct row tiling = {
    .id = "H049",
    .name = "h049_tiling",
    .what = "64 x 64 squares split both ways: each lattice point belongs to one triangle",
    .oracle = "count = 1",
    .run = rows_tiling,
};

static const struct row star = {
    .id = "H052",
    .name = "h052_star",
    .what = "a concave star and the triangles in its notches: one is met, and the right one",
    .oracle = "count = 1; exact winding",
    .run = rows_star,
};

static const struct row polygon = {
    .id = "O1 polygon",
    .name = "o1_polygon",
    .what = "concave outlines: hit or miss outside BE(8) right, t among the depths of the "
            "vertices, within 8 u of the plane",
    .oracle = "exact winding; 113-bit plane",
    .run = rows_polygon,
};

static const struct row bent = {
    .id = "H054",
    .name = "h054_bent",
    .what = "a sheet of squares with vertices off their planes by 1e-7 has no cracks",
    .oracle = "count = 1",
    .run = rows_bent,
};

static const struct row circle = {
    .id = "H055",
    .name = "h055_circle",
    .what = "a circle of 10 000 corners and its complement: one is met at corners and the "
            "middles of edges",
    .oracle = "count = 1",
    .run = rows_circle,
    .full = 50000,
    .check = 2000,
};

static const struct row circle_area = {
    .id = "H055",
    .name = "h055_circle_area",
    .what = "the share of random rays that meet the circle of 10 000 corners is its area",
    .oracle = "closed form, 5 sigma",
    .run = rows_circle_area,
    .full = 40,
    .check = 2,
};

static const struct row huge_small = {
    .id = "H056",
    .name = "h056_huge_beside_small",
    .what = "a tetrahedron with edges of 1e6 and 1e-6: a line through a point inside meets two "
            "faces",
    .oracle = "exact inside; count = 2",
    .run = rows_huge_small,
};

static const struct row glass_cube = {
    .id = "H058",
    .name = "h058_glass_cube",
    .what = "a shadow ray from outside at edges and corners of a glass cube of 12 triangles "
            "passes two of them or none",
    .oracle = "count",
    .run = rows_glass_cube,
};

static const struct row plane = {
    .id = "H087 O1 plane",
    .name = "h087_plane",
    .what = "planes met at any angle down to 1e-300: the class is exact, t a number, the point "
            "within 8 u of the plane",
    .oracle = "113 bits",
    .run = rows_plane,
};

static const struct row t_junction = {
    .id = "H051",
    .name = "h051_t_junction",
    .what = "a vertex that rests on a long edge",
    .status = ROW_INAPPLICABLE,
    .why = "input is never repaired: validate warns of T-junctions (tests/io/test_warnings.c)",
};

static const struct row bow_tie = {
    .id = "H053",
    .name = "h053_bow_tie",
    .what = "a self-crossing outline",
    .status = ROW_INAPPLICABLE,
    .why = "self-crossing outlines are refused (tests/scene/test_polygon_check.c)",
};

static const char roots_oracle[] = "113-bit roots; class by growing and shrinking the body";

static const struct row oracle = {
    .id = "O1",
    .name = "o1_oracle",
    .what = "the oracle's roots in 113 bits agree with roots in 400 bits to 2^-6 ulp",
    .oracle = "MPFR, textbook formula (skipped where MPFR was not there at build time)",
    .run = rows_oracle,
    .full = 10000,
    .check = 1000,
};

static const struct row sphere_roots = {
    .id = "O1 sphere",
    .name = "o1_sphere",
    .what = "passing within 0.9 r: t within 5 ulp from 2 r on, else within 8u (|f| + r); no wrong "
            "hit or miss outside BE(8)",
    .oracle = roots_oracle,
    .run = rows_sphere_roots,
};

static const struct row sphere_grazing = {
    .id = "O1 sphere",
    .name = "o1_sphere_grazing",
    .what = "the same where the ray passes beyond 0.9 r, to tangents within 1e-16",
    .oracle = roots_oracle,
    .run = rows_sphere_grazing,
    .known = "t of grazing rays: the square root of a discriminant that keeps few digits",
};

static const struct row tube_roots = {
    .id = "O1 tube",
    .name = "o1_tube",
    .what = "axis near the origin, passing within 0.9 r, at any angle to the axis: t within 16 ulp "
            "from 2 r on, else "
            "within 8u (|f| + r); no wrong hit or miss outside BE(8)",
    .oracle = roots_oracle,
    .run = rows_tube_roots,
};

static const struct row tube_grazing = {
    .id = "O1 tube",
    .name = "o1_tube_grazing",
    .what = "the same where the ray passes beyond 0.9 r",
    .oracle = roots_oracle,
    .run = rows_tube_grazing,
    .known = "t of grazing rays: the square root of a discriminant that keeps few digits",
};

static const struct row tube_far = {
    .id = "O1 tube",
    .name = "o1_tube_far",
    .what = "the same for thin tubes about 1 from the origin, and others up to 1e9 from it",
    .oracle = roots_oracle,
    .run = rows_tube_far,
    .known = "the point of the axis near the origin is rounded to double when a tube is made",
};

static const struct row cylinder_caps = {
    .id = "O1 cylinder",
    .name = "o1_cylinder_caps",
    .what = "crossings of the caps: t within 16 ulp from 2 r on, else within 8u (|f| + r)",
    .oracle = roots_oracle,
    .run = rows_cylinder_caps,
    .known = "t of a cap loses digits where the ray starts near its plane or runs along it",
};

static const struct row cylinder_roots = {
    .id = "O1 cylinder",
    .name = "o1_cylinder",
    .what = "capped cylinders, aimed at sides, caps and rims: hit or miss, and t of the side, as "
            "for tubes",
    .oracle = roots_oracle,
    .run = rows_cylinder_roots,
};

static const struct row cylinder_grazing = {
    .id = "O1 cylinder",
    .name = "o1_cylinder_grazing",
    .what = "the same where the ray passes the axis beyond 0.9 r",
    .oracle = roots_oracle,
    .run = rows_cylinder_grazing,
    .known = "t of grazing rays: the square root of a discriminant that keeps few digits",
};

static const struct row needle_grazed = {
    .id = "H043",
    .name = "h043_needle_grazed",
    .what = "the same for rays within 0.1 rad of the needle's plane",
    .oracle = "113-bit plane",
    .run = rows_needle_grazed,
    .known = "t of rays nearly in the plane",
};

static const struct row triangle_grazed = {
    .id = "O1 triangle",
    .name = "o1_triangle_grazed",
    .what = "the same for rays within 0.1 rad of the triangle's plane",
    .oracle = "113-bit plane",
    .run = rows_triangle_grazed,
    .known = "t of rays nearly in the plane",
};

static const struct row leave_round = {
    .id = "H059",
    .name = "h059_leave_round",
    .what = "from a hit on a sphere, tube or cylinder of radius 1e-6 to 1e6 at offsets 0 to "
            "1e9: no crossing outward, exactly one inward",
    .oracle = "sign of the chord; undecided only within 8u",
    .run = rows_leave_round,
    .full = 9000000,
};

static const struct row leave_flat = {
    .id = "H060",
    .name = "h060_leave_flat",
    .what = "from a hit on a triangle, a polygon or a plane of size e^-8 to e^8 at offsets 0 to "
            "1e9: it is not met again",
    .oracle = "count = 0",
    .run = rows_leave_flat,
    .full = 5000000,
};

static const struct row way_out = {
    .id = "H061",
    .name = "h061_way_out",
    .what = "inward from the surface, t is -2 b / a within 4 ulp; from or to a cap within 32u "
            "(r + h)",
    .oracle = "113 bits",
    .run = rows_way_out,
    .full = 6000000,
};

static const struct row wedge = {
    .id = "H062",
    .name = "h062_dihedral",
    .what = "two triangles at 10^-k rad, k up to 12: from one, into the wedge, the other is met",
    .oracle = "construction",
    .run = rows_wedge,
};

static const struct row shell = {
    .id = "H063",
    .name = "h063_thin_shell",
    .what = "an opaque sphere in a glass one with gaps of 4e-5 to 64u of the coordinates: it is "
            "always seen, and "
            "nothing meets itself",
    .oracle = "order of spheres",
    .run = rows_shell,
};

static const struct row twins = {
    .id = "H068 H069",
    .name = "h068_coincident",
    .what = "of two coincident bodies the first in the document is met, by the tree too; on "
            "leaving it neither is met at the start",
    .oracle = "document order",
    .run = rows_twins,
};

static const struct row overlap = {
    .id = "H070",
    .name = "h070_coplanar_overlap",
    .what = "coplanar squares that overlap: what is met is there, and is the same by tree and "
            "by trying all",
    .oracle = "exact winding; brute force",
    .run = rows_overlap,
};

static const struct row touching = {
    .id = "H071",
    .name = "h071_touching_spheres",
    .what = "spheres that touch: crossings at 1, 3, 3, 5 in document order; the common tangent "
            "misses both; scaled by 2^-200 to 2^200",
    .oracle = "closed form",
    .run = rows_touching,
    .full = 10000,
    .check = 600,
};

static const struct row signed_zeros = {
    .id = "H086",
    .name = "h086_signed_zeros",
    .what = "26 directions along axes and diagonals, zeros of either sign, from box faces moved "
            "by -1, 0, +1 ulp: no false miss, and signs of zeros change nothing",
    .oracle = "brute force, exact slabs",
    .run = rows_signed_zeros,
};

static const struct row boxes = {
    .id = "H091",
    .name = "h091_boxes",
    .what = "rays at and from corners, edges and faces of boxes at offsets 0 to 1e9: no false "
            "miss",
    .oracle = "brute force; exact slabs, BE(8)",
    .run = rows_boxes,
    .full = 12000000,
};

static const struct row flat_boxes = {
    .id = "H092",
    .name = "h092_flat_boxes",
    .what = "boxes without thickness around axis-parallel rectangles: hit iff the rectangle is",
    .oracle = "brute force, bit for bit",
    .run = rows_flat_boxes,
};

static const struct row on_faces = {
    .id = "H093",
    .name = "h093_on_faces",
    .what = "rays that start on faces, edges and corners of boxes, inward, along and outward",
    .oracle = "brute force; exact slabs, BE(8)",
    .run = rows_on_faces,
};

static const struct row tmax = {
    .id = "H094",
    .name = "h094_tmax",
    .what = "tmax equal to t of a crossing includes it, an ulp less does not, by tree and by "
            "trying all",
    .oracle = "brute force, bit for bit",
    .run = rows_tmax,
};

static const struct row paths = {
    .id = "H095 H096",
    .name = "h095_trees",
    .what = "random mixed scenes, paths of three rays: the tree, the list and trying all meet "
            "the same (t, primitive, part), and say the same of shadows",
    .oracle = "brute force, bit for bit",
    .run = rows_paths,
    .full = 2000000,
};

static const struct row copies = {
    .id = "H097",
    .name = "h097_copies",
    .what = "up to 1e5 copies of one triangle: the tree is less than 64 deep, the first is met, "
            "then each",
    .oracle = "document order",
    .run = rows_copies,
    .full = 2000,
    .check = 20,
};

static const struct row crowd = {
    .id = "H098",
    .name = "h098_unbounded",
    .what = "planes and tubes beside 1e5 triangles: the tree meets what trying all meets",
    .oracle = "brute force, bit for bit",
    .run = rows_crowd,
    .full = 3000,
    .check = 100,
};

static const struct row few = {
    .id = "H099",
    .name = "h099_few",
    .what = "none, one or a few primitives: what trying all says",
    .oracle = "brute force, bit for bit",
    .run = rows_few,
    .full = 200000,
};

static const struct row builders = {
    .id = "H096",
    .name = "h096_builders",
    .what = "the same picture with the builders cbr, manual and median",
    .status = ROW_PENDING,
    .why = "these builders are still to come; h095_trees compares those that are there",
};

static const struct row scaled = {
    .id = "H074",
    .name = "h074_scaled",
    .what = "every kind of body and a ray times 2^k, k in -200 ... 200, the direction with it "
            "or not: the same crossings",
    .oracle = "itself, bit for bit",
    .run = rows_scaled,
};

static const struct row moved = {
    .id = "H076",
    .name = "h076_moved",
    .what = "coordinates that are multiples of 2^-12, moved by 2^20 and 2^30: the same "
            "crossings",
    .oracle = "itself, bit for bit",
    .run = rows_moved,
};

static const struct row mirrored = {
    .id = "H078",
    .name = "h078_mirrored",
    .what = "any coordinates negated: the same crossings, off the borders of flat bodies; all "
            "kinds but triangles",
    .oracle = "itself, bit for bit",
    .run = rows_mirrored,
};

static const struct row turned = {
    .id = "H079",
    .name = "h079_permuted",
    .what = "spheres, tubes and polygons with axes permuted: hit or miss the same, t "
            "within 2 ulp",
    .oracle = "itself",
    .run = rows_turned,
};

static const struct row mixed = {
    .id = "H081",
    .name = "h081_mixed_scale",
    .what = "a sphere of 1e-6 that rests on one of 1e9, seen from 1e-5, in a frame at the "
            "contact: it is seen, and so is its shadow, outside BE(16)",
    .oracle = "113-bit class",
    .run = rows_mixed,
};

static const struct row far_camera = {
    .id = "H082",
    .name = "h082_far_camera",
    .what = "a sphere seen from up to 1e8: hit or miss wrong only where |b/r - 1| <= 4u D/r",
    .oracle = "113-bit class",
    .run = rows_far_camera,
};

static const struct row planet = {
    .id = "H083",
    .name = "h083_planet",
    .what = "the horizon of a planet: rays begin to meet it within an ulp of the direction",
    .oracle = "113-bit class at d and its neighbours",
    .run = rows_planet,
    .known = "grazing rays are decided by a discriminant that keeps few digits",
};

static const struct row subnormal = {
    .id = "H085",
    .name = "h085_subnormal",
    .what = "a subnormal component of the direction changes nothing but t by 4 ulp",
    .oracle = "itself without it",
    .run = rows_subnormal,
};

static const struct row mirrored_triangle = {
    .id = "H078",
    .name = "h078_mirrored_triangle",
    .what = "the same for triangles",
    .oracle = "itself, bit for bit",
    .run = rows_mirrored_triangle,
    .known = "t of a triangle depends on the order of its corners' coordinates",
};

static const struct row turned_sums = {
    .id = "H079",
    .name = "h079_permuted_sums",
    .what = "the same for triangles, cylinders and planes",
    .oracle = "itself",
    .run = rows_turned_sums,
    .known = "t of triangles, caps and planes: sums of three terms, reordered, differ by more",
};

static const struct row stack = {
    .id = "H072",
    .name = "h072_stacked_glass",
    .what = "64 parallel sheets of glass in any document order: the product of their "
            "transmittances, the same bits with and without a tree",
    .oracle = "product in order of distance",
    .run = rows_stack,
    .full = 20000,
    .check = 100,
};

static const struct row picture_scaled = {
    .id = "H074 H084",
    .name = "h074_picture",
    .what = "a random scene times 2^k, k in -200 ... 200, attenuation constant: the same "
            "picture",
    .oracle = "itself, bit for bit",
    .run = rows_picture_scaled,
    .full = 4000,
    .check = 60,
};

static const struct row picture_decimal = {
    .id = "H075",
    .name = "h075_picture",
    .what = "a random scene times 1e-6, 1e-3, 1e3, 1e9: at most one pixel in a thousand differs "
            "by 1e-3",
    .oracle = "itself",
    .run = rows_picture_decimal,
    .full = 400,
    .check = 8,
};

static const struct row picture_moved = {
    .id = "H076",
    .name = "h076_picture",
    .what = "a random scene of dyadic coordinates moved by 2^20 and 2^30: the same picture",
    .oracle = "itself, bit for bit",
    .run = rows_picture_moved,
    .full = 4000,
    .check = 60,
};

static const struct row picture_cornell = {
    .id = "H077",
    .name = "h077_cornell",
    .what = "a Cornell box of size 1 moved by 1e6 to 1e9: root mean square error at most "
            "ulp(offset) over a pixel's size, at most 4 pixels of 4096 another body",
    .oracle = "itself",
    .run = rows_picture_cornell,
    .full = 400,
    .check = 8,
};

static const struct row picture_mirrored = {
    .id = "H078",
    .name = "h078_picture",
    .what = "a mirrored scene gives the mirrored picture but for 2 pixels",
    .oracle = "itself, bit for bit",
    .run = rows_picture_mirrored,
    .full = 4000,
    .check = 60,
};

static const struct row pose = {
    .id = "H080",
    .name = "h080_rotation",
    .what = "a point in the penumbra of a straight edge under a disk light, in any pose: the "
            "visible share of the disk",
    .oracle = "closed form, 5 sigma",
    .run = rows_pose,
    .full = 1000,
    .check = 20,
};

const struct row *const row_table[] = {
    &bumpy,
    &embree,
    &antisymmetry,
    &roles,
    &needle,
    &needle_grazed,
    &fan,
    &degenerate,
    &pbrt,
    &grazed,
    &edge_on,
    &tiling,
    &sheet,
    &t_junction,
    &star,
    &bow_tie,
    &bent,
    &circle,
    &circle_area,
    &huge_small,
    &glass_cube,
    &plane,
    &leave_round,
    &leave_flat,
    &way_out,
    &wedge,
    &shell,
    &twins,
    &overlap,
    &touching,
    &stack,
    &scaled,
    &picture_scaled,
    &picture_decimal,
    &moved,
    &picture_moved,
    &picture_cornell,
    &mirrored,
    &mirrored_triangle,
    &picture_mirrored,
    &turned,
    &turned_sums,
    &pose,
    &mixed,
    &far_camera,
    &planet,
    &subnormal,
    &signed_zeros,
    &boxes,
    &flat_boxes,
    &on_faces,
    &tmax,
    &paths,
    &builders,
    &copies,
    &crowd,
    &few,
    &oracle,
    &sphere_roots,
    &sphere_grazing,
    &tube_roots,
    &tube_grazing,
    &tube_far,
    &cylinder_roots,
    &cylinder_caps,
    &cylinder_grazing,
    &triangle,
    &triangle_grazed,
    &polygon,
};
const int row_table_count = sizeof row_table / sizeof row_table[0];
