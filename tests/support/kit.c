/* SPDX-License-Identifier: MIT */
#include "support/kit.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

void kit_init(struct kit *kit)
{
    memset(kit, 0, sizeof *kit);
    kit->settings = pen_settings_default();
    kit->settings.width = kit->settings.height = 1;
    kit->view = (struct pen_view_desc){
        .name = "main",
        .camera = {.position = {0, 0, 10},
                   .direction = {0, 0, -1},
                   .up = {0, 1, 0},
                   .fov_degrees = 50},
    };
    kit->desc = (struct pen_scene_desc){
        .name = "",
        .view_count = 1,
        .views = &kit->view,
        .materials = kit->materials,
        .lights = kit->lights,
        .objects = kit->objects,
    };
}

int kit_material(struct kit *kit, struct pen_material material)
{
    ck_assert_uint_lt(kit->desc.material_count, KIT_MATERIALS);
    kit->materials[kit->desc.material_count] = material;
    return (int)kit->desc.material_count++;
}

struct pen_material kit_matte(double kd)
{
    struct pen_material m = pen_material_default();
    m.ka = pen_vec3(0, 0, 0);
    m.kd = pen_vec3(kd, kd, kd);
    return m;
}

struct pen_material kit_glow(double r, double g, double b)
{
    struct pen_material m = kit_matte(0);
    m.emission = pen_vec3(r, g, b);
    return m;
}

static struct pen_object_desc *add(struct kit *kit, enum pen_object_kind kind, int material)
{
    ck_assert_uint_lt(kit->desc.object_count, KIT_OBJECTS);
    struct pen_object_desc *o = &kit->objects[kit->desc.object_count++];
    *o = (struct pen_object_desc){.kind = kind, .material = material};
    kit->desc.primitive_count++;
    return o;
}

struct pen_object_desc *kit_sphere(struct kit *kit, struct pen_vec3 center, double radius,
                                   int material)
{
    struct pen_object_desc *o = add(kit, PEN_OBJECT_SPHERE, material);
    o->u.sphere.center = center;
    o->u.sphere.radius = radius;
    return o;
}

struct pen_object_desc *kit_plane(struct kit *kit, struct pen_vec3 point, struct pen_vec3 normal,
                                  int material)
{
    struct pen_object_desc *o = add(kit, PEN_OBJECT_PLANE, material);
    o->u.plane.point = point;
    o->u.plane.normal = normal;
    return o;
}

struct pen_object_desc *kit_polygon(struct kit *kit, const struct pen_vec3 *vertices,
                                    uint32_t count, int material)
{
    ck_assert_uint_le(kit->vertex_count + count, KIT_VERTICES);
    struct pen_object_desc *o =
        add(kit, count == 3 ? PEN_OBJECT_TRIANGLE : PEN_OBJECT_POLYGON, material);
    o->u.polygon.count = count;
    o->u.polygon.vertices = &kit->vertices[kit->vertex_count];
    memcpy(o->u.polygon.vertices, vertices, count * sizeof *vertices);
    kit->vertex_count += count;
    return o;
}

struct pen_object_desc *kit_triangle(struct kit *kit, struct pen_vec3 a, struct pen_vec3 b,
                                     struct pen_vec3 c, int material)
{
    const struct pen_vec3 v[] = {a, b, c};
    return kit_polygon(kit, v, 3, material);
}

struct pen_object_desc *kit_sheet(struct kit *kit, double z, double half, int material)
{
    const struct pen_vec3 v[] = {
        {-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
    return kit_polygon(kit, v, 4, material);
}

struct pen_object_desc *kit_tube(struct kit *kit, struct pen_vec3 origin, struct pen_vec3 axis,
                                 double radius, int material)
{
    struct pen_object_desc *o = add(kit, PEN_OBJECT_INFINITE_CYLINDER, material);
    o->u.infinite_cylinder.origin = origin;
    o->u.infinite_cylinder.axis = axis;
    o->u.infinite_cylinder.radius = radius;
    return o;
}

struct pen_object_desc *kit_cylinder(struct kit *kit, struct pen_vec3 base, struct pen_vec3 axis,
                                     double radius, double height, int material)
{
    struct pen_object_desc *o = add(kit, PEN_OBJECT_CYLINDER, material);
    o->u.cylinder.base = base;
    o->u.cylinder.axis = axis;
    o->u.cylinder.radius = radius;
    o->u.cylinder.height = height;
    o->u.cylinder.caps = true;
    return o;
}

struct pen_object_desc *kit_mesh(struct kit *kit, const struct pen_mesh_desc *mesh, int material)
{
    ck_assert_uint_lt(kit->mesh_count, KIT_MESHES);
    struct pen_mesh_desc *own = &kit->meshes[kit->mesh_count];
    int *own_material = &kit->mesh_material[kit->mesh_count++];
    *own_material = material;
    *own = *mesh;
    own->material = own_material;
    own->material_count = 1;
    struct pen_object_desc *o = add(kit, PEN_OBJECT_MESH, -1);
    o->u.mesh = own;
    kit->desc.primitive_count += mesh->triangle_count - 1;
    return o;
}

struct pen_object_desc *kit_smooth(struct kit *kit, struct pen_vec3 center, int material)
{
    static const float vertex[] = {.5f,  .5f, .5f,  -.5f, -.5f, .5f,
                                   -.5f, .5f, -.5f, .5f,  -.5f, -.5f};
    static const uint32_t corner[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const struct pen_mesh_desc mesh = {.vertex_count = 4,
                                       .triangle_count = 4,
                                       .vertex = vertex,
                                       .corner = corner,
                                       .normal = vertex,
                                       .normal_count = 4,
                                       .shift = {center.x, center.y, center.z}};
    return kit_mesh(kit, &mesh, material);
}

/* The group's objects move to the end of the array, behind those of the top level. */
struct pen_object_desc *kit_group(struct kit *kit, uint32_t first,
                                  const struct pen_transform *transform)
{
    uint32_t count = kit->desc.object_count - first;
    kit->parked += count;
    ck_assert_uint_le(kit->desc.object_count + kit->parked, KIT_OBJECTS);
    struct pen_object_desc *members = &kit->objects[KIT_OBJECTS - kit->parked];
    memmove(members, &kit->objects[first], count * sizeof *members);
    kit->desc.object_count = first + 1;
    struct pen_object_desc *group = &kit->objects[first];
    *group = (struct pen_object_desc){.kind = PEN_OBJECT_GROUP, .material = -1};
    group->u.group.count = count;
    group->u.group.objects = members;
    group->u.group.has_transform = transform != NULL;
    if (transform)
        group->u.group.transform = *transform;
    return group;
}

static struct pen_light_desc *add_light(struct kit *kit, enum pen_light_kind kind,
                                        struct pen_vec3 intensity)
{
    ck_assert_uint_lt(kit->desc.light_count, KIT_LIGHTS);
    struct pen_light_desc *light = &kit->lights[kit->desc.light_count++];
    *light = (struct pen_light_desc){.kind = kind,
                                     .shadows = true,
                                     .intensity = intensity,
                                     .attenuation = {1, 0, 0},
                                     .beam_exponent = 1};
    return light;
}

struct pen_light_desc *kit_point(struct kit *kit, struct pen_vec3 position,
                                 struct pen_vec3 intensity)
{
    struct pen_light_desc *light = add_light(kit, PEN_LIGHT_POINT, intensity);
    light->position = position;
    return light;
}

struct pen_light_desc *kit_directional(struct kit *kit, struct pen_vec3 direction,
                                       struct pen_vec3 intensity)
{
    struct pen_light_desc *light = add_light(kit, PEN_LIGHT_DIRECTIONAL, intensity);
    light->direction = direction;
    return light;
}

struct pen_light_desc *kit_spot(struct kit *kit, struct pen_vec3 position,
                                struct pen_vec3 direction, struct pen_vec3 intensity)
{
    struct pen_light_desc *light = add_light(kit, PEN_LIGHT_SPOT, intensity);
    light->position = position;
    light->direction = direction;
    return light;
}

struct pen_scene *kit_freeze(struct kit *kit)
{
    struct pen_status st = {0};
    enum pen_accelerator kind = (enum pen_accelerator)kit->settings.accelerator;
    struct pen_scene *scene = pen_scene_freeze(&kit->desc, kind, 0, &st);
    ck_assert_msg(scene != NULL, "%s: %s", st.at, st.msg);
    return scene;
}

struct pen_vec3 kit_pixel(struct kit *kit, int x, int y, struct pen_ray_counts *rays)
{
    struct pen_scene *scene = kit_freeze(kit);
    struct pen_ray_counts unused;
    struct pen_status st;
    double rgb[3];
    ck_assert(pen_render_pixel(scene, 0, &kit->settings, x, y, rgb, rays ? rays : &unused, &st));
    pen_scene_free(scene);
    return pen_vec3(rgb[0], rgb[1], rgb[2]);
}

float *kit_film(const struct pen_scene *scene, const struct pen_settings *settings, int threads)
{
    struct pen_status st = {0};
    struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
    ck_assert_msg(pool != NULL, "%s", st.msg);
    size_t pixels = (size_t)settings->width * (size_t)settings->height;
    float *rgb = calloc(pixels * 3, sizeof *rgb);
    struct pen_render_task task = {
        .scene = scene, .settings = settings, .tile_count = -1, .rgb = rgb};
    struct pen_render_stats stats;
    ck_assert_msg(pen_render_run(pool, &task, &stats, &st), "%s", st.msg);
    pen_thread_pool_free(pool);
    return rgb;
}

static void medley_materials(struct kit *kit, int number[6])
{
    struct pen_material wall = kit_matte(0.7), shiny = kit_matte(0.4), glass = kit_matte(0.05);
    struct pen_material mirror = kit_matte(0.1), veil = kit_matte(0.2);
    wall.ka = pen_vec3(1, 1, 1);
    shiny.kd = pen_vec3(0.6, 0.3, 0.1);
    shiny.ks = pen_vec3(0.4, 0.4, 0.4);
    shiny.shininess = 35.5;
    glass.ks = pen_vec3(0.5, 0.5, 0.5);
    glass.shininess = 200;
    glass.kt = pen_vec3(0.8, 0.9, 0.6);
    glass.kr = pen_vec3(0.1, 0.1, 0.1);
    mirror.kr = pen_vec3(0.8, 0.7, 0.7);
    veil.kt = pen_vec3(0.5, 0, 0.7);
    number[0] = kit_material(kit, wall);
    number[1] = kit_material(kit, shiny);
    number[2] = kit_material(kit, glass);
    number[3] = kit_material(kit, mirror);
    number[4] = kit_material(kit, veil);
    number[5] = kit_material(kit, kit_glow(0.9, 0.6, 0.2));
}

void kit_medley(struct kit *kit)
{
    kit_init(kit);
    int m[6];
    medley_materials(kit, m);
    kit->settings.width = 40;
    kit->settings.height = 30;
    kit->desc.background = pen_vec3(0.05, 0.1, 0.25);
    kit->desc.ambient = pen_vec3(0.05, 0.04, 0.03);
    kit->view.camera.position = pen_vec3(0.5, 2.25, 9);
    kit->view.camera.direction = pen_vec3(0, -0.25, -1);
    kit_plane(kit, pen_vec3(0, -1, 0), pen_vec3(0, 1, 0), m[3]);
    kit_tube(kit, pen_vec3(-3, 0, -4), pen_vec3(0.25, 1, 0), 0.375, m[1]);
    kit_sphere(kit, pen_vec3(0, 0.5, 0), 1.5, m[2]);
    kit_sphere(kit, pen_vec3(0.25, 0.5, 0), 0.5, m[1]);
    kit_sphere(kit, pen_vec3(2.5, 0, 1), 1, m[1]);
    kit_cylinder(kit, pen_vec3(-2.5, -1, 1), pen_vec3(0, 1, 0.125), 0.5, 2, m[0]);
    kit_cylinder(kit, pen_vec3(3, -1, -2), pen_vec3(0, 1, 0), 0.75, 3, m[2])->u.cylinder.caps =
        false;
    const struct pen_vec3 wall[] = {{-6, -1, -5}, {6, -1, -5}, {6, 5, -5}, {1, 5, -5},
                                    {0, 2, -5},   {-1, 5, -5}, {-6, 5, -5}};
    kit_polygon(kit, wall, 7, m[0]);
    const struct pen_vec3 veil[] = {{-2, -1, 2}, {1, -1, 3}, {1, 1.5, 3}, {-2, 1.5, 2}};
    kit_polygon(kit, veil, 4, m[4]);
    kit_triangle(kit, pen_vec3(-1, -1, 4), pen_vec3(1, -1, 4), pen_vec3(0, 0, 4.5), m[5]);
    kit_point(kit, pen_vec3(0, 0.5, 1.25), pen_vec3(3, 2, 1))->attenuation[2] = 0.125;
    kit_directional(kit, pen_vec3(1, -2, -1.5), pen_vec3(0.5, 0.5, 0.6));
    struct pen_light_desc *spot =
        kit_spot(kit, pen_vec3(-4, 5, 4), pen_vec3(4, -5, -5), pen_vec3(2, 2, 2));
    spot->beam_exponent = 7.5;
    spot->radius = 0.75;
    kit_directional(kit, pen_vec3(-1, -1, -3), pen_vec3(0.25, 0.25, 0.125))->angular_radius = 4;
    kit->settings.light_samples = 5;
}

void kit_map_points(struct kit *kit, kit_point_fn *map, double by)
{
    for (uint32_t i = 0; i < kit->vertex_count; i++)
        kit->vertices[i] = map(kit->vertices[i], by);
    for (uint32_t i = 0; i < kit->desc.light_count; i++)
        kit->lights[i].position = map(kit->lights[i].position, by);
    kit->view.camera.position = map(kit->view.camera.position, by);
    for (uint32_t i = 0; i < kit->desc.object_count; i++) {
        struct pen_object_desc *o = &kit->objects[i];
        if (o->kind == PEN_OBJECT_SPHERE)
            o->u.sphere.center = map(o->u.sphere.center, by);
        else if (o->kind == PEN_OBJECT_PLANE)
            o->u.plane.point = map(o->u.plane.point, by);
        else if (o->kind == PEN_OBJECT_INFINITE_CYLINDER)
            o->u.infinite_cylinder.origin = map(o->u.infinite_cylinder.origin, by);
        else if (o->kind == PEN_OBJECT_CYLINDER)
            o->u.cylinder.base = map(o->u.cylinder.base, by);
    }
}

void kit_scale_lengths(struct kit *kit, double s)
{
    for (uint32_t i = 0; i < kit->desc.light_count; i++) {
        kit->lights[i].attenuation[1] /= s;
        kit->lights[i].attenuation[2] /= s * s;
        kit->lights[i].radius *= s;
    }
    for (uint32_t i = 0; i < kit->desc.object_count; i++) {
        struct pen_object_desc *o = &kit->objects[i];
        if (o->kind == PEN_OBJECT_SPHERE)
            o->u.sphere.radius *= s;
        else if (o->kind == PEN_OBJECT_INFINITE_CYLINDER)
            o->u.infinite_cylinder.radius *= s;
        else if (o->kind == PEN_OBJECT_CYLINDER) {
            o->u.cylinder.radius *= s;
            o->u.cylinder.height *= s;
        }
    }
}

struct pen_vec3 kit_times(struct pen_vec3 p, double by)
{
    return pen_scale(p, by);
}

struct pen_vec3 kit_moved(struct pen_vec3 p, double by)
{
    return pen_vec3(p.x + by, p.y - 3 * by, p.z + 0.5 * by);
}

struct pen_vec3 kit_mirrored(struct pen_vec3 p, double by)
{
    return pen_vec3(by * p.x, p.y, p.z);
}

void kit_mirror_directions(struct kit *kit)
{
    kit->view.camera.direction.x *= -1;
    for (uint32_t i = 0; i < kit->desc.light_count; i++)
        kit->lights[i].direction.x *= -1;
    for (uint32_t i = 0; i < kit->desc.object_count; i++) {
        struct pen_object_desc *o = &kit->objects[i];
        if (o->kind == PEN_OBJECT_PLANE)
            o->u.plane.normal.x *= -1;
        else if (o->kind == PEN_OBJECT_INFINITE_CYLINDER)
            o->u.infinite_cylinder.axis.x *= -1;
        else if (o->kind == PEN_OBJECT_CYLINDER)
            o->u.cylinder.axis.x *= -1;
    }
}
