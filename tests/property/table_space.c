/* SPDX-License-Identifier: MIT */
/* Rays that leave surfaces, coincidence, scale, boxes: H059 to H099. */
#include <stddef.h>

#include "property/rows.h"

const struct row row_table_space[] = {
    {
        .id = "H059",
        .name = "h059_leave_round",
        .what = "from a hit on a sphere, tube or cylinder of radius 1e-6 to 1e6 at offsets 0 to "
                "1e9: no intersection outward, exactly one inward",
        .oracle = "sign of the chord; undecided only within 8u",
        .run = rows_self_intersection_round,
        .full = 9000000,
    },
    {
        .id = "H060",
        .name = "h060_leave_flat",
        .what =
            "from a hit on a triangle, a polygon or a plane of size e^-8 to e^8 at offsets 0 to "
            "1e9: it is not hit again",
        .oracle = "count = 0",
        .run = rows_self_intersection_flat,
        .full = 5000000,
    },
    {
        .id = "H061",
        .name = "h061_way_out",
        .what = "inward from the surface, t is -2 b / a within 4 ulp; from or to a cap within 32u "
                "(r + h)",
        .oracle = "113 bits",
        .run = rows_way_out,
        .full = 6000000,
    },
    {
        .id = "H062",
        .name = "h062_dihedral",
        .what =
            "two triangles at 10^-k rad, k up to 12: from one, into the wedge, the other is hit",
        .oracle = "construction",
        .run = rows_wedge,
    },
    {
        .id = "H063",
        .name = "h063_thin_shell",
        .what =
            "an opaque sphere in a glass one with gaps of 4e-5 to 64u of the coordinates: it is "
            "always seen, and "
            "nothing hits itself",
        .oracle = "order of spheres",
        .run = rows_shell,
    },
    {
        .id = "H068 H069",
        .name = "h068_coincident",
        .what =
            "of two coincident primitives the first in the document is hit, by the tree too; a ray "
            "that starts on it hits the second at its start if it goes through, else not",
        .oracle = "document order",
        .run = rows_twins,
    },
    {
        .id = "H068 H070 H133",
        .name = "layers_gap",
        .what = "stacks of 2 to 4 coincident sheets, planes, tiles and caps, see-through, mirrors "
                "or opaque, lit and seen from any side: contact is the limit of a gap of 1e-7 in "
                "which the earlier in the document is nearer the viewer",
        .oracle = "the picture with the gap",
        .run = rows_layers_gap,
        .full = 20000,
        .check = 150,
    },
    {
        .id = "H057 H058 H068 H133",
        .name = "layers_paid",
        .what = "light to an opaque layer and from it pays each layer before it once each way, at "
                "seams of tiles too, and no later one",
        .oracle = "closed form",
        .run = rows_layers_paid,
        .full = 20000,
        .check = 200,
    },
    {
        .id = "H068 H132",
        .name = "layers_below",
        .what = "a clear sheet in contact with an opaque one does not let light from below "
                "through: the visible share of a disk light that the plane cuts",
        .oracle = "area of a circle's segment",
        .run = rows_layers_below,
        .full = 10000,
        .check = 100,
    },
    {
        .id = "H070 H133",
        .name = "layers_first",
        .what = "of surfaces in one plane with different vertices the first in the document is "
                "seen in every pixel",
        .oracle = "document order",
        .run = rows_layers_first,
        .full = 20000,
        .check = 200,
    },
    {
        .id = "H069 H133",
        .name = "layers_round",
        .what = "equal spheres, tubes, cylinders, cones: the light of each, through those before "
                "it in the document",
        .oracle = "closed form",
        .run = rows_layers_round,
        .full = 20000,
        .check = 100,
    },
    {
        .id = "H070",
        .name = "h070_coplanar_overlap",
        .what =
            "coplanar squares that overlap: the hit is right, and the same by tree and by brute "
            "force",
        .oracle = "exact winding; brute force",
        .run = rows_overlap,
    },
    {
        .id = "H071",
        .name = "h071_touching_spheres",
        .what =
            "spheres that touch: intersections at 1, 3, 3, 5 in document order; the common tangent "
            "misses both; scaled by 2^-200 to 2^200",
        .oracle = "closed form",
        .run = rows_touching,
        .full = 10000,
        .check = 600,
    },
    {
        .id = "H072",
        .name = "h072_stacked_glass",
        .what = "64 parallel sheets of glass in any document order: the product of their "
                "transmittances, the same bits with and without a tree",
        .oracle = "product in order of distance",
        .run = rows_stack,
        .full = 20000,
        .check = 100,
    },
    {
        .id = "H143",
        .name = "o1_transform",
        .what = "maps that flatten space or leave it by ulps: refused only if the determinant is "
                "exactly 0, the right side outside, a plane's normal within 16 u",
        .oracle = "exact determinant and cofactors by expansions",
        .run = rows_map,
    },
    {
        .id = "H147",
        .name = "h147_equal_solids",
        .what =
            "copies of a closed solid of any kind, moved, turned, mirrored and scaled by 2^k in "
            "groups: the later in the document owns where they overlap",
        .oracle = "the order of the document",
        .run = rows_solids_equal,
    },
    {
        .id = "H148",
        .name = "h148_joints",
        .what = "lines along the joints of capped cylinders and cones that stand on each other, "
                "also those that rounding sets apart: they meet the column, and exactly one part "
                "where the joint is shared exactly",
        .oracle = "construction",
        .run = rows_joints,
    },
    {
        .id = "H074",
        .name = "h074_scaled",
        .what =
            "every kind of primitive and a ray times 2^k, k in -200 ... 200, the direction with it "
            "or not: the same intersections",
        .oracle = "itself, bit for bit",
        .run = rows_scaled,
    },
    {
        .id = "H074 H084",
        .name = "h074_picture",
        .what = "a random scene times 2^k, k in -200 ... 200, attenuation constant: the same "
                "picture",
        .oracle = "itself, bit for bit",
        .run = rows_picture_scaled,
        .full = 4000,
        .check = 60,
    },
    {
        .id = "H075",
        .name = "h075_picture",
        .what =
            "a random scene times 1e-6, 1e-3, 1e3, 1e9: at most one pixel in a thousand differs "
            "by 1e-3",
        .oracle = "itself",
        .run = rows_picture_decimal,
        .full = 400,
        .check = 8,
    },
    {
        .id = "H076",
        .name = "h076_moved",
        .what = "coordinates that are multiples of 2^-12, moved by 2^20 and 2^30: the same "
                "intersections",
        .oracle = "itself, bit for bit",
        .run = rows_moved,
    },
    {
        .id = "H076",
        .name = "h076_picture",
        .what = "a random scene of dyadic coordinates moved by 2^20 and 2^30: the same picture",
        .oracle = "itself, bit for bit",
        .run = rows_picture_moved,
        .full = 4000,
        .check = 60,
    },
    {
        .id = "H077",
        .name = "h077_cornell",
        .what =
            "a Cornell box of size 1 moved by 1e6 to 1e9: at most 4 pixels of 4096 differ by "
            "1e-3 (another primitive), of the others the root mean square is at most ulp(offset) "
            "over a pixel's size",
        .oracle = "itself",
        .run = rows_picture_cornell,
        .full = 400,
        .check = 8,
    },
    {
        .id = "H078",
        .name = "h078_mirrored",
        .what =
            "any coordinates negated: the same intersections, their points and normals the images, "
            "off the borders of flat primitives; all kinds but triangles",
        .oracle = "itself, bit for bit",
        .run = rows_mirrored,
    },
    {
        .id = "H078",
        .name = "h078_mirrored_triangle",
        .what = "the same for triangles, with their corners in any order",
        .oracle = "itself, bit for bit",
        .run = rows_mirrored_triangle,
    },
    {
        .id = "H078",
        .name = "h078_picture",
        .what = "a mirrored scene gives the mirrored picture except for 2 pixels",
        .oracle = "itself, bit for bit",
        .run = rows_picture_mirrored,
        .full = 4000,
        .check = 60,
    },
    {
        .id = "H079",
        .name = "h079_permuted",
        .what = "spheres, tubes and polygons with axes permuted: hit or miss the same, t "
                "within 2 ulp",
        .oracle = "itself",
        .run = rows_permuted,
    },
    {
        .id = "H079",
        .name = "h079_permuted_sums",
        .what = "the same for triangles, cylinders and planes",
        .oracle = "itself",
        .run = rows_permuted_sums,
    },
    {
        .id = "H079 H140",
        .name = "h079_permuted_tied",
        .what = "the same for rays whose direction has three components of equal size, so that no "
                "axis is the longest, and for triangles whose edges have the same extents along "
                "the axes in another order",
        .oracle = "itself",
        .run = rows_permuted_tied,
    },
    {
        .id = "H080",
        .name = "h080_rotation",
        .what = "a point in the penumbra of a straight edge under a disk light, in any pose: the "
                "visible share of the disk",
        .oracle = "closed form, 5 sigma",
        .run = rows_pose,
        .full = 1000,
        .check = 20,
    },
    {
        .id = "H081",
        .name = "h081_mixed_scale",
        .what = "a sphere of 1e-6 that rests on one of 1e9, seen from 1e-5, in a frame at the "
                "contact: it is seen, and so is its shadow, outside BE(16)",
        .oracle = "113-bit class",
        .run = rows_mixed,
    },
    {
        .id = "H082",
        .name = "h082_far_camera",
        .what = "a sphere seen from up to 1e8: hit or miss wrong only where |b/r - 1| <= 4u D/r",
        .oracle = "113-bit class",
        .run = rows_far_camera,
    },
    {
        .id = "H083",
        .name = "h083_planet",
        .what = "the horizon of a planet: rays begin to hit it within an ulp of the direction",
        .oracle = "113-bit class at d and its neighbours",
        .run = rows_planet,
    },
    {
        .id = "H085",
        .name = "h085_subnormal",
        .what = "a subnormal component of the direction changes nothing but t by 4 ulp",
        .oracle = "itself without it",
        .run = rows_subnormal,
    },
    {
        .id = "H086",
        .name = "h086_signed_zeros",
        .what =
            "26 directions along axes and diagonals, zeros of either sign, from box faces moved "
            "by -1, 0, +1 ulp: no false miss, and signs of zeros change nothing",
        .oracle = "brute force, exact slabs",
        .run = rows_signed_zeros,
    },
    {
        .id = "H091",
        .name = "h091_boxes",
        .what = "rays at and from corners, edges and faces of boxes at offsets 0 to 1e9: no false "
                "miss",
        .oracle = "brute force; exact slabs, BE(8)",
        .run = rows_boxes,
        .full = 12000000,
    },
    {
        .id = "H091",
        .name = "h091_planes",
        .what =
            "every box that any of the accelerators stores contains the primitives and boxes in it",
        .oracle = "extents from the primitives' definitions, 64 bits",
        .run = rows_planes,
    },
    {
        .id = "H091",
        .name = "h091_vanishing",
        .what =
            "coordinates of primitives and rays down to the least subnormal, beside ones of unit "
            "size: the structures of all builders hit what brute force hits",
        .oracle = "brute force, bit for bit",
        .run = rows_vanishing,
    },
    {
        .id = "H092",
        .name = "h092_flat_boxes",
        .what = "boxes without thickness around axis-parallel rectangles: hit iff the rectangle is",
        .oracle = "brute force, bit for bit",
        .run = rows_flat_boxes,
    },
    {
        .id = "H093",
        .name = "h093_on_faces",
        .what = "rays that start on faces, edges and corners of boxes, inward, along and outward",
        .oracle = "brute force; exact slabs, BE(8)",
        .run = rows_on_faces,
    },
    {
        .id = "H094",
        .name = "h094_tmax",
        .what =
            "tmax equal to t of an intersection includes it, an ulp less does not, by tree and by "
            "brute force",
        .oracle = "brute force, bit for bit",
        .run = rows_tmax,
    },
    {
        .id = "H094",
        .name = "h094_shadow_span",
        .what = "a shadow ray that starts or ends exactly on a sphere is not blocked there, one "
                "that ends an ulp behind it is",
        .oracle = "exact sign of a product of dyadic vectors",
        .run = rows_span,
    },
    {
        .id = "H095 H096",
        .name = "h095_trees",
        .what =
            "random mixed scenes, paths of three rays: the structures of all builders and brute "
            "force find the same (t, primitive, part), and agree on shadows",
        .oracle = "brute force, bit for bit",
        .run = rows_paths,
        .full = 2000000,
    },
    {
        .id = "H097",
        .name = "h097_copies",
        .what =
            "up to 1e5 copies of one triangle: the tree is less than 64 deep, the first is hit, "
            "then each",
        .oracle = "document order",
        .run = rows_copies,
        .full = 2000,
        .check = 20,
    },
    {
        .id = "H098",
        .name = "h098_unbounded",
        .what = "planes and tubes beside 1e5 triangles: the tree hits what brute force hits",
        .oracle = "brute force, bit for bit",
        .run = rows_crowd,
        .full = 3000,
        .check = 100,
    },
    {
        .id = "H099",
        .name = "h099_few",
        .what = "none, one or a few primitives: the same hits as brute force",
        .oracle = "brute force, bit for bit",
        .run = rows_few,
    },
    {.id = NULL},
};
