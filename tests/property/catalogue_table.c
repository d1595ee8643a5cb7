/* SPDX-License-Identifier: MIT */
/* The hard cases by number. The rows of the suite name the cases that they test. */
#include "property/catalogue.h"

static const struct catalogue_case cases[CATALOGUE_LAST + 1] = {
    [1] = {"plane through three points: unit normal, across both edges",
           "test_plane__h001_normal_of_three_points", ROW_TESTED, NULL},
    [2] = {"planes through repeated points are refused",
           "test_plane__h002_repeated_points_are_refused "
           "test_boundary__h002_planes_through_repeated_points",
           ROW_TESTED, NULL},
    [3] = {"planes through points on a line are refused",
           "test_plane__h003_points_on_a_line_are_refused "
           "test_boundary__h003_planes_through_points_on_a_line",
           ROW_TESTED, NULL},
    [4] = {"a plane hit, and rays that turn away from it",
           "test_plane__h004_met_and_turned_away_from", ROW_TESTED, NULL},
    [5] = {"rays parallel to a plane", "test_plane__h005_parallel_rays", ROW_TESTED, NULL},
    [6] = {"rays that start on a plane", "test_plane__h006_rays_that_start_on_it", ROW_TESTED,
           NULL},
    [7] = {"tmax of a plane is inclusive", "test_plane__h007_tmax_is_inclusive", ROW_TESTED, NULL},
    [8] = {"the normal of a sphere", "test_sphere__h008_normal", ROW_TESTED, NULL},
    [9] = {"a sphere from inside", "test_sphere__h009_from_inside", ROW_TESTED, NULL},
    [10] = {"a sphere missed, or behind the ray", "test_sphere__h010_missed_or_behind", ROW_TESTED,
            NULL},
    [11] = {"a sphere hit twice, the nearer point first",
            "test_sphere__h011_two_intersections_near_first", ROW_TESTED, NULL},
    [12] = {"a tangent of a sphere is a miss", "test_sphere__h012_a_tangent_is_a_miss", ROW_TESTED,
            NULL},
    [13] = {"rays that start on a sphere", "test_sphere__h013_start_on_it", ROW_TESTED, NULL},
    [14] = {"a ray from the centre of a sphere, with tmax", "test_sphere__h014_start_at_the_centre",
            ROW_TESTED, NULL},
    [15] = {"tmax of a sphere", "test_sphere__h015_tmax", ROW_TESTED, NULL},
    [16] = {"the normal of a tube, and on its axis", "test_infinite_cylinder__h016_normal",
            ROW_TESTED, NULL},
    [17] = {"rays parallel to a tube", "test_infinite_cylinder__h017_parallel_rays", ROW_TESTED,
            NULL},
    [18] = {"rays outside a tube", "test_infinite_cylinder__h018_outside", ROW_TESTED, NULL},
    [19] = {"tangents of a tube", "test_infinite_cylinder__h019_tangent", ROW_TESTED, NULL},
    [20] = {"rays that start on a tube, inward", "test_infinite_cylinder__h020_start_on_it_inward",
            ROW_TESTED, NULL},
    [21] = {"a tube from inside", "test_infinite_cylinder__h021_from_inside", ROW_TESTED, NULL},
    [22] = {"rays that start on a tube, outward",
            "test_infinite_cylinder__h022_start_on_it_outward", ROW_TESTED, NULL},
    [23] = {"tmax of a tube", "test_infinite_cylinder__h023_tmax", ROW_TESTED, NULL},
    [24] = {"a tube has no end, wherever its origin is given",
            "test_infinite_cylinder__h024_has_no_head "
            "test_infinite_cylinder__h024_far_heads_of_slanted_tubes",
            ROW_TESTED, NULL},
    [25] = {"normals of a cylinder; at the rim the cap wins",
            "test_cylinder__h025_normals_go_by_part "
            "test_cylinder__h025_at_a_rim_the_cap_wins",
            ROW_TESTED, NULL},
    [26] = {"tmax of a cylinder", "test_cylinder__h026_tmax", ROW_TESTED, NULL},
    [27] = {"polygons in another order, off their plane, concave",
            "test_polygon__h027_any_outline_with_an_area "
            "test_boundary__h027_polygons",
            ROW_TESTED, NULL},
    [28] = {"polygons with a vertex on a side, or repeated",
            "test_polygon__h028_vertex_on_a_side "
            "test_boundary__h028_polygons",
            ROW_TESTED, NULL},
    [29] = {"the normal of a polygon", "test_polygon__h029_normal", ROW_TESTED, NULL},
    [30] = {"a square hit inside, beside, on a side, at a corner; tmax",
            "test_polygon__h030_inside_outside_and_rim", ROW_TESTED, NULL},
    [31] = {"the rest of its rim; neighbours get the complement",
            "test_polygon__h031_the_rest_of_the_rim", ROW_TESTED, NULL},
    [32] = {"a triangle hit inside, beside, on its rim; tmax",
            "test_triangle__h032_inside_rim_and_outside", ROW_TESTED, NULL},
    [33] = {"intersections of several primitives: how many, in which order",
            "test_collections__h033_intersections_of_several_primitives "
            "test_collections__h033_equal_distances",
            ROW_TESTED, NULL},
    [34] = {"the nearest of several, wherever it is in the document",
            "test_collections__h034_nearest_wherever_it_is_in_the_document", ROW_TESTED, NULL},
    [35] = {"zero vectors: values, not errors, but no directions",
            "test_vec3__h035_zero_is_a_vector "
            "test_exact__h035_cross_of_parallels_is_zero "
            "test_boundary__h035_directions_of_length_zero",
            ROW_TESTED, NULL},
    [36] = {"rays of a 3 x 3 and a 4 x 4 view plane; up along the view",
            "test_camera__h036_classic_view_planes "
            "test_camera__h036_refuses_what_gives_no_frame",
            ROW_TESTED, NULL},
    [37] = {"intersections of a 3 x 3 view plane with one primitive",
            "test_freeze__h037_intersections_of_a_small_view_plane", ROW_TESTED, NULL},
    [38] = {"a closed surface of 420 triangles is watertight",
            "test_watertight__h038_h039_bumpy_sphere", ROW_TESTED, NULL},
    [39] = {"the same 1e6 and 1e9 from the origin", "test_watertight__h038_h039_bumpy_sphere",
            ROW_TESTED, NULL},
    [40] = {"Embree's sphere and plane far from the origin", "test_watertight__h040_h058_cube",
            ROW_TESTED, NULL},
    [41] = {"the difference of products is antisymmetric", "test_exact__h041_dop_is_antisymmetric",
            ROW_TESTED, NULL},
    [42] = {"a vertex is the same point in every role",
            "test_triangle__h042_roles "
            "test_exact__h042_a_vertex_in_every_role",
            ROW_TESTED, NULL},
    [43] = {"needles of any aspect", "test_triangle__h043_needles", ROW_TESTED, NULL},
    [44] = {"a fan of needles that share a vertex", "test_watertight__h044_needle_fan", ROW_TESTED,
            NULL},
    [45] = {"triangles without area", "test_triangle__h045_degenerate", ROW_TESTED, NULL},
    [46] = {"pbrt's bad case", "test_triangle__h046_pbrt_bad_case", ROW_TESTED, NULL},
    [47] = {"thin triangles hit at a grazing angle", "test_triangle__h047_grazing", ROW_TESTED,
            NULL},
    [48] = {"rays in a triangle's plane", "test_triangle__h048_edge_on", ROW_TESTED, NULL},
    [49] = {"a coplanar tiling, through its lattice points",
            "test_watertight__h049_coplanar_tiling", ROW_TESTED, NULL},
    [50] = {"an edge shared by triangles, convex and concave polygons",
            "test_watertight__h050_h057_folded_sheet_of_all_kinds", ROW_TESTED, NULL},
    [51] = {"a vertex that rests on a long edge",
            "test_warnings__h051_every_vertex_inside_an_edge_is_found", ROW_TESTED,
            "input is never repaired: validate warns of T-junctions"},
    [52] = {"a concave star", "test_polygon__h052_concave_star", ROW_TESTED, NULL},
    [53] = {"an outline that crosses itself",
            "test_polygon_check__h053_refuses_crossings_and_touches", ROW_TESTED,
            "refused, so no ray can hit it"},
    [54] = {"a polygon slightly off its plane",
            "test_polygon_check__h054_planar_within_a_millionth", ROW_TESTED, NULL},
    [55] = {"a polygon of 10 000 corners", "test_polygon__h055_ten_thousand_corners", ROW_TESTED,
            NULL},
    [56] = {"a huge triangle beside a tiny one", "test_watertight__h056_huge_beside_small",
            ROW_TESTED, NULL},
    [57] = {"a sheet of glass dims once at its edges",
            "test_watertight__h050_h057_folded_sheet_of_all_kinds", ROW_TESTED, NULL},
    [58] = {"a glass cube of triangles dims twice or not at all", "test_watertight__h040_h058_cube",
            ROW_TESTED, NULL},
    [59] = {"no ray that leaves a round primitive hits it again",
            "test_self_intersection__h059_h061_round_primitives", ROW_TESTED, NULL},
    [60] = {"no ray that leaves a flat primitive hits it again",
            "test_self_intersection__h060_flat_primitives", ROW_TESTED, NULL},
    [61] = {"the intersection on the far side is kept",
            "test_self_intersection__h059_h061_round_primitives", ROW_TESTED, NULL},
    [62] = {"two triangles at angles down to 1e-12", "test_self_intersection__h062_dihedral",
            ROW_TESTED, NULL},
    [63] = {"a primitive within a thin shell of glass", "test_self_intersection__h063_thin_shell",
            ROW_TESTED, NULL},
    [64] = {"the shadow of a small ball touches it", "", ROW_TESTED, NULL},
    [65] = {"the shadow of a box begins where it stands",
            "test_self_intersection__h065_resting_box "
            "test_shadow__h065_shadow_begins_at_the_wall",
            ROW_TESTED, NULL},
    [66] = {"no acne under grazing light", "", ROW_TESTED, NULL},
    [67] = {"the terminator of meshes with vertex normals", "", ROW_PENDING,
            "meshes with vertex normals are not supported yet"},
    [68] = {"two surfaces that coincide: the first of the document",
            "test_self_intersection__h068_h069_coincident", ROW_TESTED, NULL},
    [69] = {"the same facing away from each other", "test_self_intersection__h068_h069_coincident",
            ROW_TESTED, NULL},
    [70] = {"two surfaces that overlap in one plane", "", ROW_TESTED, NULL},
    [71] = {"spheres that touch", "test_self_intersection__h071_touching_spheres", ROW_TESTED,
            NULL},
    [72] = {"64 sheets of glass", "", ROW_TESTED, NULL},
    [73] = {"no light in a closed room",
            "test_seams__h073_no_way_out_of_a_closed_room "
            "test_seams__h073_no_way_out_of_a_drum "
            "test_seams__h073_light_round_the_foot_of_a_wall "
            "test_seams__h073_the_way_before_tells_the_side "
            "test_accel__h073_seams",
            ROW_TESTED, NULL},
    [74] = {"a scene times a power of two",
            "test_invariance__h074_scaled_by_powers_of_two "
            "test_sphere__h074_power_of_two_scale",
            ROW_TESTED, NULL},
    [75] = {"a scene times a power of ten", "", ROW_TESTED, NULL},
    [76] = {"a scene moved by an exact distance", "test_invariance__h076_moved_by_exact_distances",
            ROW_TESTED, NULL},
    [77] = {"a room moved by 1e6 to 1e9", "test_precision__h077_a_picture_is_right_unless_it_warns",
            ROW_TESTED, NULL},
    [78] = {"a scene in a mirror", "test_invariance__h078_seen_in_a_mirror", ROW_TESTED, NULL},
    [79] = {"a scene with its axes permuted", "", ROW_TESTED, NULL},
    [80] = {"a soft shadow in any pose", "test_soft__h080_rotation", ROW_TESTED, NULL},
    [81] = {"a sphere of 1e-6 on one of 1e9",
            "test_precision__h081_h082_h083_scale_is_judged_by_the_pixel", ROW_TESTED, NULL},
    [82] = {"a camera far away", "test_precision__h081_h082_h083_scale_is_judged_by_the_pixel",
            ROW_TESTED, NULL},
    [83] = {"the horizon of a planet",
            "test_sphere__h083_horizon_of_a_planet "
            "test_precision__h081_h082_h083_scale_is_judged_by_the_pixel",
            ROW_TESTED, NULL},
    [84] = {"a scene all tiny, all huge", "", ROW_TESTED, NULL},
    [85] = {"subnormal components of directions",
            "test_sphere__h085_subnormal_directions "
            "test_accel__h085_hairs_beside_surfaces",
            ROW_TESTED, NULL},
    [86] = {"zeros of either sign in directions", "test_tree__h091_h092_h093_no_false_box_misses",
            ROW_TESTED, NULL},
    [87] = {"planes hit at angles down to 1e-300",
            "test_plane__h087_grazing_rays_have_finite_intersections_or_none", ROW_TESTED, NULL},
    [88] = {"invalid rays: not finite, or without a direction",
            "test_ray__h088_poisoned_rays_are_refused "
            "test_kernel__h088_rays_that_are_none_are_refused_and_counted "
            "test_kernel__h088_nothing_goes_on_from_a_point_that_is_none",
            ROW_TESTED, NULL},
    [89] = {"numbers in a scene that are not finite", "test_boundary__h089_no_numbers", ROW_TESTED,
            NULL},
    [90] = {"light that overflows",
            "test_light__h090_overflow_is_dropped_and_counted "
            "test_light__h090_strongest_light_at_the_least_distance",
            ROW_TESTED, NULL},
    [91] = {"no false miss of a box", "test_tree__h091_h092_h093_no_false_box_misses", ROW_TESTED,
            NULL},
    [92] = {"boxes without thickness", "test_tree__h091_h092_h093_no_false_box_misses", ROW_TESTED,
            NULL},
    [93] = {"rays that start on boxes", "test_tree__h091_h092_h093_no_false_box_misses", ROW_TESTED,
            NULL},
    [94] = {"tmax at an intersection on a box", "test_tree__h094_tmax_equality", ROW_TESTED, NULL},
    [95] = {"the tree hits what brute force hits", "test_accel__h095_equals_brute_force",
            ROW_TESTED, NULL},
    [96] = {"the same hits with every builder",
            "test_accel__h095_equals_brute_force "
            "test_render__same_film_for_threads_tiles_and_accelerators",
            ROW_TESTED, NULL},
    [97] = {"primitives with the same centre", "test_tree__h097_identical_centroids", ROW_TESTED,
            NULL},
    [98] = {"infinite primitives beside many finite ones", "test_tree__h098_unbounded_mix",
            ROW_TESTED, NULL},
    [99] = {"no primitive, or a few", "test_tree__h099_hardly_anything", ROW_TESTED, NULL},
    [100] = {"the same picture for any number of threads",
             "test_render__same_film_for_threads_tiles_and_accelerators", ROW_TESTED, NULL},
    [101] = {"the same picture for any tiles, in any order, resumed",
             "test_render__same_film_for_threads_tiles_and_accelerators "
             "test_render__ranges_of_tiles_make_the_whole "
             "test_worker__killed_in_mid_job_another_finishes_with_the_same_bytes "
             "tests/crash/check_crash.sh",
             ROW_TESTED, NULL},
    [102] = {"the same picture by every instruction set",
             "test_count__variants_agree "
             "test_kernel__every_kernel_gives_the_same_bits "
             "test_disk_packet__packets_equal_single_rays",
             ROW_TESTED, NULL},
    [103] = {"the same picture from any compiler",
             "test_golden__films_are_those_of_the_table "
             "test_fn__bits_are_the_same_everywhere "
             "tests/property/matrix.sh",
             ROW_TESTED, NULL},
    [104] = {"no function of libm decides a pixel",
             "deploy/lint.sh "
             "tests/property/check_same.sh "
             "test_fn__bits_are_the_same_everywhere",
             ROW_TESTED, NULL},
    [105] = {"threads whose arithmetic is not the default",
             "test_render__h105_changed_arithmetic_is_counted_and_reset "
             "test_render__h105_default_arithmetic_in_every_thread",
             ROW_TESTED, NULL},
    [106] = {"samples in several parts", "", ROW_INAPPLICABLE,
             "the samples of a pixel are never divided: a job is divided by pixels"},
    [107] = {"the critical angle", "test_snell__h107_at_the_critical_angle", ROW_TESTED, NULL},
    [108] = {"parallel plates", "test_refraction__h108_direction_behind_1000_plates", ROW_TESTED,
             NULL},
    [109] = {"a path through glass and back",
             "test_refraction__h109_a_path_through_a_ball_and_back", ROW_TESTED, NULL},
    [110] = {"glass that neither refracts nor dims, and the limit of the index towards 1",
             "test_paths__h110_glass_keeps_the_ray "
             "test_refraction__h110_index_1_is_no_refraction "
             "test_refraction__h110_as_the_index_goes_to_1",
             ROW_TESTED, NULL},
    [111] = {"a ball lens", "test_refraction__h111_a_ball_lens", ROW_TESTED, NULL},
    [112] = {"two mirrors that face each other", "test_paths__h112_mirror_pair", ROW_TESTED, NULL},
    [113] = {"primitives that lose no light, in light that is everywhere the same",
             "test_paths__h113_furnace "
             "test_furnace__h113_ball "
             "test_furnace__h113_flat_faces "
             "test_furnace__h113_deeper_paths_lack_less "
             "test_furnace__h113_no_seams "
             "test_furnace__h113_rays_at_edges",
             ROW_TESTED, NULL},
    [114] = {"surfaces of glass at one distance are one event; solids that are nested or touch",
             "test_paths__h114_coincident_glass_in_document_order "
             "test_shadow__h114_coincident_sheets_in_document_order "
             "test_media__h114_balls_in_balls "
             "test_media__h114_any_glasses "
             "test_media__h114_common_faces "
             "test_media__h114_overlaps_and_double_walls",
             ROW_TESTED, NULL},
    [115] = {"a camera inside glass",
             "test_paths__h115_camera_in_glass "
             "test_media__h115_eye_in_balls "
             "test_media__h115_lens_partly_inside",
             ROW_TESTED, NULL},
    [116] = {"the edge of a spot",
             "test_light__h116_nothing_behind_a_spot "
             "test_light__h116_edge_of_a_spot",
             ROW_TESTED, NULL},
    [117] = {"a light exactly at the point, inside a sphere, under a plane",
             "test_light__h117_light_at_the_point "
             "test_light__h117_light_inside_an_opaque_sphere "
             "test_soft__h117_light_at_the_point",
             ROW_TESTED, NULL},
    [118] = {"a disk light in the plane of a wall", "", ROW_INAPPLICABLE,
             "lights are disks that face the point; they have no side"},
    [119] = {"a light of the shape of a primitive", "", ROW_INAPPLICABLE,
             "lights have no geometry that could shade them"},
    [120] = {"a point inside a spherical light", "", ROW_INAPPLICABLE,
             "lights are disks; there is no inside"},
    [121] = {"the penumbra of a straight edge",
             "test_soft__h121_half_plane "
             "test_soft__h121_converges_with_the_slope_of_its_pattern "
             "test_light_points__h121_means_of_the_grid",
             ROW_TESTED, NULL},
    [122] = {"the umbra of a sphere", "test_soft__h122_umbra_of_a_sphere", ROW_TESTED, NULL},
    [123] = {"a disk light along any axis",
             "test_soft__h123_frame_near_every_axis "
             "test_soft__h123_penumbra_with_the_light_along_an_axis",
             ROW_TESTED, NULL},
    [124] = {"tiny and huge lights",
             "test_soft__h124_radius_zero_is_a_hard_shadow "
             "test_soft__h124_enormous_lights_stay_finite "
             "test_soft__h124_a_radius_beyond_numbers_is_refused",
             ROW_TESTED, NULL},
    [125] = {"a coloured shadow", "test_soft__h125_coloured_shadow", ROW_TESTED, NULL},
    [126] = {"a quad in the plane of focus", "test_lens__h126_in_focus_as_sharp_as_a_pinhole",
             ROW_TESTED, NULL},
    [127] = {"a lens without an aperture", "test_lens__h127_no_aperture_is_a_pinhole", ROW_TESTED,
             NULL},
    [128] = {"glossy reflection without blur", "test_gloss__h128_no_blur_is_a_mirror", ROW_TESTED,
             NULL},
    [129] = {"a light within rounding of a wall's plane, along it, far away in it or behind the "
             "next wall",
             "test_horizon__flat test_horizon__near_light", ROW_TESTED, NULL},
    [130] = {"a light within rounding of the tangent plane of a round surface",
             "test_horizon__small_sphere test_horizon__apex_from_outside "
             "test_horizon__apex_from_inside",
             ROW_TESTED, NULL},
    [131] = {"a disk light that the horizon cuts", "test_horizon__disk", ROW_TESTED, NULL},
    [132] = {"a see-through sheet in the plane of an opaque floor, light from below", "",
             ROW_TESTED, NULL},
    [133] = {"coincident surfaces as layers in document order: as with a gap of 1e-7", "",
             ROW_TESTED, NULL},
    [134] = {"a polygon with a vertex off its plane, at a wall's foot",
             "test_polygon__h134_cut_the_same_way test_polygon__h134_not_cut "
             "test_polygon__h134_met_once test_polygon__h134_left test_polygon__h134_valley "
             "test_polygon__h134_layers",
             ROW_TESTED, NULL},
    [135] = {"a floor up to 1e12 times the room", "", ROW_TESTED, NULL},
    [136] = {"a camera 1e-16 above a floor", "", ROW_TESTED, NULL},
    [137] = {"rooms as thin as 2^-30 of their width; thinner primitives get a warning",
             "test_precision__h137_what_is_thinner_than_can_be_tested_warns", ROW_TESTED, NULL},
    [138] = {"coincident rims of open cylinders and cones; a cylinder's foot on a floor", "",
             ROW_TESTED, NULL},
    [139] = {"dented rooms, and rooms of prisms with shallow edges", "", ROW_TESTED, NULL},
    [140] = {"rays whose components are equal in size, with the axes renamed", "", ROW_TESTED,
             NULL},
    [141] = {"a grid of few light points", "test_light_points__h121_means_of_the_grid", ROW_TESTED,
             NULL},
    [142] = {"triangles and polygons of aspect 1e-40", "", ROW_TESTED, NULL},
    [143] = {"a matrix that is nearly singular", "test_transform__orientation_is_exact", ROW_TESTED,
             NULL},
    [144] = {"samples that the film cannot hold are said, not only counted", "tests/cmd/render.sh",
             ROW_TESTED, NULL},
    [145] = {"exp and pow where the result is subnormal",
             "test_fn__exp_is_within_its_bound test_fn__pow_is_within_its_bound", ROW_TESTED, NULL},
    [146] = {"paths that fork at every surface, to any depth", "tests/e2e/bounds.sh", ROW_TESTED,
             NULL},
    [147] = {"equal solids that overlap, wherever groups move them", "", ROW_TESTED, NULL},
    [148] = {"a line in the plane of two caps that touch", "test_cylinder__h148_half_open_caps",
             ROW_TESTED, NULL},
    [149] =
        {"an eye on a surface of glass, in a bubble of glass with T-junctions, and a ball in "
         "contact with the glass around it",
         "test_eyes__h149_on_round_glass test_eyes__h149_on_boxes test_eyes__h149_lens_on_a_face "
         "test_eyes__h149_bubble_among_t_junctions test_eyes__h149_behind_a_pane",
         ROW_TESTED, NULL},
};

const struct catalogue_case *catalogue_case(int number)
{
    return &cases[number];
}
