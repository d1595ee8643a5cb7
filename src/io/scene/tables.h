/* SPDX-License-Identifier: MIT */
/* The tables of the format's keys, one per object, defined beside the code that reads the object.
 * The XML parser makes its attributes from the same tables, so XML has an attribute for every key
 * and for no other. */
#ifndef PEN_IO_SCENE_TABLES_H
#define PEN_IO_SCENE_TABLES_H

#include "io/scene/reader.h"

extern const struct pen_field pen_scene_fields[], pen_view_fields[], pen_settings_fields[];
extern const struct pen_field pen_sky_fields[];
extern const struct pen_field pen_camera_fields[];
extern const struct pen_field pen_camera_rotate_fields[], pen_camera_orbit_fields[];
extern const struct pen_field pen_material_fields[];
/* For a pattern in place of a colour (emission), or of a factor. */
extern const struct pen_field pen_colour_pattern_fields[], pen_factor_pattern_fields[];
extern const struct pen_field pen_directional_fields[], pen_point_fields[], pen_spot_fields[];
extern const struct pen_field pen_sphere_fields[], pen_plane_fields[];
extern const struct pen_field pen_polygon_fields[]; /* for triangles, too */
extern const struct pen_field pen_infinite_cylinder_fields[], pen_cylinder_fields[];
extern const struct pen_field pen_cone_fields[], pen_group_fields[];
extern const struct pen_field pen_mesh_fields[];
extern const struct pen_field pen_transform_fields[], pen_transform_rotate_fields[];

#endif
