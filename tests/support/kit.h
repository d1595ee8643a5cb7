/* SPDX-License-Identifier: MIT */
/* Builds small scenes in code and renders their pixels. A kit is large: keep it static. */
#ifndef TESTS_SUPPORT_KIT_H
#define TESTS_SUPPORT_KIT_H

#include "render/render.h"
#include "scene/scene.h"

enum {
    KIT_OBJECTS = 256,
    KIT_MATERIALS = 64,
    KIT_LIGHTS = 16,
    KIT_VERTICES = 2048,
    KIT_MESHES = 4
};

struct kit {
    struct pen_scene_desc desc; /* a test may change it before kit_freeze */
    struct pen_settings settings;
    struct pen_view_desc view;
    struct pen_object_desc objects[KIT_OBJECTS];
    struct pen_material materials[KIT_MATERIALS];
    struct pen_light_desc lights[KIT_LIGHTS];
    struct pen_vec3 vertices[KIT_VERTICES];
    uint32_t vertex_count;
    struct pen_mesh_desc meshes[KIT_MESHES];
    int mesh_material[KIT_MESHES];
    uint32_t mesh_count;
    uint32_t parked; /* objects inside groups, at the end of the array */
};

/* Makes an empty scene of 1 x 1 pixel, black, seen from (0, 0, 10) along -z. */
void kit_init(struct kit *kit);

/* Adds a material and returns its number. */
int kit_material(struct kit *kit, struct pen_material material);

/* Return materials of one grey property, ambient 0. */
struct pen_material kit_matte(double kd);
struct pen_material kit_glow(double r, double g, double b); /* emission only */

/* Add an object at the top level. The test may change the returned object further. */
struct pen_object_desc *kit_sphere(struct kit *kit, struct pen_vec3 center, double radius,
                                   int material);
struct pen_object_desc *kit_plane(struct kit *kit, struct pen_vec3 point, struct pen_vec3 normal,
                                  int material);
struct pen_object_desc *kit_triangle(struct kit *kit, struct pen_vec3 a, struct pen_vec3 b,
                                     struct pen_vec3 c, int material);
struct pen_object_desc *kit_polygon(struct kit *kit, const struct pen_vec3 *vertices,
                                    uint32_t count, int material);
struct pen_object_desc *kit_tube(struct kit *kit, struct pen_vec3 origin, struct pen_vec3 axis,
                                 double radius, int material);
struct pen_object_desc *kit_cylinder(struct kit *kit, struct pen_vec3 base, struct pen_vec3 axis,
                                     double radius, double height, int material);

/* Adds a copy of a mesh, with this material. */
struct pen_object_desc *kit_mesh(struct kit *kit, const struct pen_mesh_desc *mesh, int material);

/* Adds a tetrahedron of edges of about 1 whose normals are those of the sphere around it. */
struct pen_object_desc *kit_smooth(struct kit *kit, struct pen_vec3 center, int material);

/* A square with sides of 2 `half`, perpendicular to the z axis and centred on it, facing +z. */
struct pen_object_desc *kit_sheet(struct kit *kit, double z, double half, int material);

/* Moves all objects from number `first` on into one group with a transform. */
struct pen_object_desc *kit_group(struct kit *kit, uint32_t first,
                                  const struct pen_transform *transform);

/* Add a light that casts shadows and has no attenuation. */
struct pen_light_desc *kit_point(struct kit *kit, struct pen_vec3 position,
                                 struct pen_vec3 intensity);
struct pen_light_desc *kit_directional(struct kit *kit, struct pen_vec3 direction,
                                       struct pen_vec3 intensity);
struct pen_light_desc *kit_spot(struct kit *kit, struct pen_vec3 position,
                                struct pen_vec3 direction, struct pen_vec3 intensity);

/* Applies a map to every point of the scene. Lengths and directions do not change. */
typedef struct pen_vec3 kit_point_fn(struct pen_vec3 p, double by);
void kit_map_points(struct kit *kit, kit_point_fn *map, double by);

/* Maps for kit_map_points:
 *   kit_times      multiplies by a number
 *   kit_moved      moves by a number along x, and by multiples of it along y and z
 *   kit_mirrored   multiplies x by a number, -1 for a mirror image; kit_mirror_directions then
 *                  mirrors the directions */
struct pen_vec3 kit_times(struct pen_vec3 p, double by);
struct pen_vec3 kit_moved(struct pen_vec3 p, double by);
struct pen_vec3 kit_mirrored(struct pen_vec3 p, double by);
void kit_mirror_directions(struct kit *kit);

/* Multiplies lengths by s and adapts the attenuation of lights. So a scene whose points are scaled
 * too looks the same. */
void kit_scale_lengths(struct kit *kit, double s);

/* Freezes the scene with the accelerator of the settings. The test fails if that fails. */
struct pen_scene *kit_freeze(struct kit *kit);

/* Freezes the scene, renders pixel (x, y) and frees the scene. */
struct pen_vec3 kit_pixel(struct kit *kit, int x, int y, struct pen_ray_counts *rays);

/* Returns the film of a frozen scene's first view; free() it. */
float *kit_film(const struct pen_scene *scene, const struct pen_settings *settings, int threads);

/* Makes a scene with every kind of primitive and light, glass, mirrors, hard and soft shadows, with
 * 40 x 30 pixels. */
void kit_medley(struct kit *kit);

#endif
