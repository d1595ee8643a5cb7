/* SPDX-License-Identifier: MIT */
/* The functions of the rows, by file. */
#ifndef TESTS_PROPERTY_ROWS_H
#define TESTS_PROPERTY_ROWS_H

#include "property/row.h"

/* The parts of the table, in its order; each ends with a row without an id. */
extern const struct row row_table_flat[], row_table_space[], row_table_roots[], row_table_light[],
    row_table_rooms[], row_table_same[], row_table_cone[];

/* rows_watertight.c */
void rows_bumpy(struct pen_row_run *run);
void rows_sheet(struct pen_row_run *run);

/* rows_meshes.c */
void rows_meshes(struct pen_row_run *run);

/* rows_round.c */
void rows_sphere_roots(struct pen_row_run *run);
void rows_sphere_grazing(struct pen_row_run *run);
void rows_tube_roots(struct pen_row_run *run);
void rows_tube_grazing(struct pen_row_run *run);
void rows_tube_far(struct pen_row_run *run);
void rows_cylinder_roots(struct pen_row_run *run);
void rows_cylinder_caps(struct pen_row_run *run);
void rows_cylinder_grazing(struct pen_row_run *run);
void rows_oracle(struct pen_row_run *run);

/* rows_cone.c */
void rows_cone_roots(struct pen_row_run *run);
void rows_cone_mapped(struct pen_row_run *run);
void rows_cone_left(struct pen_row_run *run);
void rows_cone_boxes(struct pen_row_run *run);
void rows_cone_trees(struct pen_row_run *run);

/* rows_closed.c, rows_outlines.c */
void rows_embree(struct pen_row_run *run);
void rows_fan(struct pen_row_run *run);
void rows_tiling(struct pen_row_run *run);
void rows_star(struct pen_row_run *run);
void rows_bent(struct pen_row_run *run);
void rows_bent_rooms(struct pen_row_run *run);
void rows_bent_foot(struct pen_row_run *run);
void rows_circle(struct pen_row_run *run);
void rows_circle_area(struct pen_row_run *run);
void rows_huge_small(struct pen_row_run *run);
void rows_glass_cube(struct pen_row_run *run);

/* rows_flat.c, rows_degenerate.c */
void rows_antisymmetry(struct pen_row_run *run);
void rows_over_floor(struct pen_row_run *run);
void rows_roles(struct pen_row_run *run);
void rows_triangle(struct pen_row_run *run);
void rows_needle(struct pen_row_run *run);
void rows_needle_grazed(struct pen_row_run *run);
void rows_triangle_grazed(struct pen_row_run *run);
void rows_grazed(struct pen_row_run *run);
void rows_polygon(struct pen_row_run *run);
void rows_degenerate(struct pen_row_run *run);
void rows_pbrt(struct pen_row_run *run);
void rows_edge_on(struct pen_row_run *run);
void rows_plane(struct pen_row_run *run);

/* rows_self_intersection.c, rows_coincident.c */
void rows_self_intersection_round(struct pen_row_run *run);
void rows_self_intersection_flat(struct pen_row_run *run);
void rows_way_out(struct pen_row_run *run);
void rows_wedge(struct pen_row_run *run);
void rows_shell(struct pen_row_run *run);
void rows_twins(struct pen_row_run *run);
void rows_overlap(struct pen_row_run *run);
void rows_touching(struct pen_row_run *run);

/* rows_layers.c */
void rows_layers_gap(struct pen_row_run *run);
void rows_layers_paid(struct pen_row_run *run);
void rows_layers_below(struct pen_row_run *run);
void rows_layers_first(struct pen_row_run *run);
void rows_layers_round(struct pen_row_run *run);

/* rows_boxes.c, rows_trees.c */
void rows_signed_zeros(struct pen_row_run *run);
void rows_boxes(struct pen_row_run *run);
void rows_flat_boxes(struct pen_row_run *run);
void rows_vanishing(struct pen_row_run *run);
void rows_on_faces(struct pen_row_run *run);
void rows_tmax(struct pen_row_run *run);
void rows_paths(struct pen_row_run *run);
void rows_copies(struct pen_row_run *run);
void rows_crowd(struct pen_row_run *run);
void rows_few(struct pen_row_run *run);

/* rows_scale.c, rows_range.c */
void rows_scaled(struct pen_row_run *run);
void rows_moved(struct pen_row_run *run);
void rows_mirrored(struct pen_row_run *run);
void rows_mirrored_triangle(struct pen_row_run *run);
void rows_permuted(struct pen_row_run *run);
void rows_round_rooms(struct pen_row_run *run);
void rows_round_beside(struct pen_row_run *run);
void rows_round_lid(struct pen_row_run *run);
void rows_dented_rooms(struct pen_row_run *run);
void rows_round_foot(struct pen_row_run *run);
void rows_round_front(struct pen_row_run *run);
void rows_permuted_sums(struct pen_row_run *run);
void rows_permuted_tied(struct pen_row_run *run);
void rows_mixed(struct pen_row_run *run);
void rows_far_camera(struct pen_row_run *run);
void rows_planet(struct pen_row_run *run);
void rows_subnormal(struct pen_row_run *run);

/* rows_pictures.c */
void rows_stack(struct pen_row_run *run);
void rows_picture_scaled(struct pen_row_run *run);
void rows_picture_decimal(struct pen_row_run *run);
void rows_picture_moved(struct pen_row_run *run);
void rows_picture_cornell(struct pen_row_run *run);
void rows_picture_mirrored(struct pen_row_run *run);
void rows_pose(struct pen_row_run *run);

/* rows_needle.c, rows_transform.c */
void rows_thin(struct pen_row_run *run);
void rows_map(struct pen_row_run *run);
void rows_solids_equal(struct pen_row_run *run);

/* rows_joints.c */
void rows_joints(struct pen_row_run *run);

/* rows_light_points.c */
void rows_grid_points(struct pen_row_run *run);

/* rows_contact.c, rows_light.c */
void rows_contact(struct pen_row_run *run);
void rows_resting(struct pen_row_run *run);
void rows_acne(struct pen_row_run *run);
void rows_room(struct pen_row_run *run);
void rows_seam(struct pen_row_run *run);
void rows_crossing(struct pen_row_run *run);
void rows_inside(struct pen_row_run *run);
void rows_outside(struct pen_row_run *run);

/* rows_corners.c */
void rows_corners(struct pen_row_run *run);
void rows_corner_chains(struct pen_row_run *run);
void rows_corner_obtuse(struct pen_row_run *run);
void rows_corner_blocks(struct pen_row_run *run);
void rows_corner_furnaces(struct pen_row_run *run);
void rows_corner_rooms(struct pen_row_run *run);

/* rows_rooms.c */
void rows_rooms_flat(struct pen_row_run *run);
void rows_rooms_crossing(struct pen_row_run *run);
void rows_rooms_round(struct pen_row_run *run);
void rows_rooms_mixed(struct pen_row_run *run);
void rows_rooms_thin(struct pen_row_run *run);
void rows_rooms_same(struct pen_row_run *run);

/* rows_scenes.c */
void rows_scenes_same(struct pen_row_run *run);

/* rows_horizon.c, rows_convex.c */
void rows_horizon_walls(struct pen_row_run *run);
void rows_horizon_disk(struct pen_row_run *run);
void rows_convex_lit(struct pen_row_run *run);
void rows_convex_horizon(struct pen_row_run *run);

/* rows_floors.c */
void rows_floor_rooms(struct pen_row_run *run);
void rows_floor_foot(struct pen_row_run *run);

/* rows_films.c */
void rows_films_threads(struct pen_row_run *run);
void rows_films_tiles(struct pen_row_run *run);
void rows_films_accelerators(struct pen_row_run *run);
void rows_films_sets(struct pen_row_run *run);
void rows_films_plain(struct pen_row_run *run);
void rows_films_states(struct pen_row_run *run);

/* rows_paths.c */
void rows_path_tree(struct pen_row_run *run);
void rows_tree_ways(struct pen_row_run *run);

/* rows_planes.c, rows_span.c */
void rows_planes(struct pen_row_run *run);
void rows_span(struct pen_row_run *run);

#endif
