/* SPDX-License-Identifier: MIT */
/* The keys of the format's objects, each table beside the code that reads its object. They are
 * shared so that XML has an attribute for every key there is, and for no other. */
#ifndef PEN_IO_SCENE_TABLES_H
#define PEN_IO_SCENE_TABLES_H

#include "io/scene/reader.h"

extern const struct pen_field pen_scene_fields[], pen_view_fields[], pen_settings_fields[];
extern const struct pen_field pen_camera_fields[];
extern const struct pen_field pen_camera_rotate_fields[], pen_camera_orbit_fields[];
extern const struct pen_field pen_material_fields[];
extern const struct pen_field pen_directional_fields[], pen_point_fields[], pen_spot_fields[];
extern const struct pen_field pen_sphere_fields[], pen_plane_fields[];
extern const struct pen_field pen_polygon_fields[]; /* of triangles, too */
extern const struct pen_field pen_infinite_cylinder_fields[], pen_cylinder_fields[];
extern const struct pen_field pen_cone_fields[], pen_group_fields[];
extern const struct pen_field pen_transform_fields[], pen_transform_rotate_fields[];

#endif
