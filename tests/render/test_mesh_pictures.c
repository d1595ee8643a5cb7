/* SPDX-License-Identifier: MIT */
/* A scene with meshes renders to the bytes of the same scene with its triangles one by one: with
 * several materials, one of them glass, mirrors, soft shadows, coincident faces, things that
 * touch, and groups; with every accelerator. */
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

enum { WIDTH = 40, HEIGHT = 30 };
enum { STACKS = 6, SLICES = 8, VERTICES = (STACKS + 1) * SLICES, TRIANGLES = 2 * STACKS * SLICES };

static struct kit kit[2]; /* with triangles, with a mesh */
static float vertex[3 * VERTICES];
static uint32_t corner[3 * (TRIANGLES + 4)];
static uint16_t material_of[TRIANGLES + 4];
static int material[3];
static struct pen_mesh_desc mesh;

/* A bumpy ball of three materials. Some of its triangles are there twice. */
static void make_ball(struct random *r, bool glass)
{
    mesh = (struct pen_mesh_desc){.vertex = vertex,
                                  .corner = corner,
                                  .vertex_count = VERTICES,
                                  .shift = {0.5, 0, -0.25},
                                  .exponent = 1,
                                  .material_of = glass ? NULL : material_of,
                                  .material = material,
                                  .material_count = 3};
    for (uint32_t i = 0; i < VERTICES; i++) {
        const double theta = 3.14159265 * (i / SLICES) / STACKS,
                     phi = 6.2831853 * (i % SLICES) / SLICES;
        const double size = random_in(r, 0.8, 1);
        vertex[3 * i] = (float)(size * sin(theta) * cos(phi));
        vertex[3 * i + 1] = (float)(size * sin(theta) * sin(phi));
        vertex[3 * i + 2] = (float)(size * cos(theta));
    }
    for (int k = 0; k < 3; k++) { /* the poles */
        for (uint32_t j = 1; j < SLICES; j++) {
            vertex[3 * j + (uint32_t)k] = vertex[k];
            vertex[3 * (STACKS * SLICES + j) + (uint32_t)k] =
                vertex[3 * STACKS * SLICES + (uint32_t)k];
        }
    }
    uint32_t *to = corner;
    for (uint32_t i = 0; i < STACKS; i++) {
        for (uint32_t j = 0; j < SLICES; j++) {
            const uint32_t a = i * SLICES + j, b = i * SLICES + (j + 1) % SLICES, c = a + SLICES,
                           d = b + SLICES;
            const uint32_t one[3] = {a, c, d}, two[3] = {a, d, b};
            if (i < STACKS - 1)
                for (int k = 0; k < 3; k++)
                    *to++ = one[k];
            if (i > 0)
                for (int k = 0; k < 3; k++)
                    *to++ = two[k];
        }
    }
    for (uint32_t k = 0; k < 12 && !glass; k++)
        *to++ = corner[60 + k / 3 * 3 + (k + 1) % 3];
    mesh.triangle_count = (uint32_t)(to - corner) / 3;
    for (uint32_t i = 0; i < mesh.triangle_count; i++)
        material_of[i] = (uint16_t)random_below(r, 3);
}

/* Adds the mesh to the second scene, and its triangles to the first. */
static void add_mesh(void)
{
    struct pen_object_desc *o = kit_sphere(&kit[1], pen_vec3(0, 0, 0), 1, -1);
    o->kind = PEN_OBJECT_MESH;
    o->u.mesh = &mesh;
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        struct pen_vec3 v[3];
        pen_mesh_desc_triangle(&mesh, i, v);
        kit_triangle(&kit[0], v[0], v[1], v[2], material[mesh.material_of ? material_of[i] : 0]);
    }
}

static void begin(struct kit *k, bool glass)
{
    kit_init(k);
    k->settings.width = WIDTH;
    k->settings.height = HEIGHT;
    material[0] = kit_material(k, kit_matte(.7));
    material[1] = kit_material(k, kit_matte(.3));
    material[2] = kit_material(k, kit_glow(.1, .2, .3));
    k->materials[material[1]].kr = pen_vec3(.5, .4, .3);
    if (glass) {
        k->materials[material[0]].kt = pen_vec3(.8, .9, .9);
        k->materials[material[0]].ior = 1.5;
        k->materials[material[0]].ior_written = true;
    }
    kit_sphere(k, pen_vec3(-2, 1, 0), 1, material[1]);
}

static void end(struct kit *k, int scene)
{
    kit_plane(k, pen_vec3(0, -1.5, 0), pen_vec3(0, 1, 0), material[0]);
    kit_sheet(k, -3, 6, material[1]);
    kit_point(k, pen_vec3(3, 5, 6), pen_vec3(1, 1, 1))->radius = scene & 2 ? .5 : 0;
    kit_directional(k, pen_vec3(1, -1, -2), pen_vec3(.3, .3, .3));
}

static void make_scenes(struct random *r, int scene)
{
    const bool glass = scene % 3 == 0;
    make_ball(r, glass);
    for (int i = 0; i < 2; i++)
        begin(&kit[i], glass);
    add_mesh();
    for (int i = 0; i < 2; i++) {
        const struct pen_transform turn =
            pen_transform_make(.5, pen_vec3(0, 0, 1), 0, pen_vec3(1, 0, 0));
        if (scene & 1)
            kit_group(&kit[i], 1, &turn);
        end(&kit[i], scene);
    }
}

static void check_equal(int scene)
{
    for (int accel = 0; accel < PEN_ACCEL_COUNT; accel++) {
        float *film[2];
        for (int i = 0; i < 2; i++) {
            kit[i].settings.accelerator = accel;
            struct pen_scene *frozen = kit_freeze(&kit[i]);
            film[i] = kit_film(frozen, &kit[i].settings, 1 + i);
            pen_scene_free(frozen);
        }
        int lit = 0;
        for (int p = 0; p < 3 * WIDTH * HEIGHT; p++) {
            lit += film[0][p] > 0;
            ck_assert_msg(film[0][p] == film[1][p], "scene %d, accelerator %d, number %d", scene,
                          accel, p);
        }
        ck_assert_int_gt(lit, WIDTH * HEIGHT);
        free(film[0]);
        free(film[1]);
    }
}

START_TEST(test_mesh_pictures__are_those_of_triangles)
{
    struct random r = random_begin(533);
    for (int scene = 0; scene < 6; scene++) {
        make_scenes(&r, scene);
        check_equal(scene);
    }
}
END_TEST

/* Adds the triangles of the mesh, which a transform has rounded to floats, to the first scene. */
static void add_rounded(const struct pen_scene *from)
{
    const struct pen_mesh *frozen = &from->prims.mesh[0];
    for (uint32_t i = 0; i < frozen->count; i++) {
        struct pen_vec3 v[3];
        pen_mesh_corners(frozen, i, v);
        for (int k = 0; k < 3; k++)
            v[k] = pen_along(from->center, v[k], exp2(from->exponent));
        kit_triangle(&kit[0], v[0], v[1], v[2], material[mesh.material_of ? material_of[i] : 0]);
    }
}

START_TEST(test_mesh_pictures__turned_meshes_are_their_rounded_triangles)
{
    struct random r = random_begin(534);
    for (int scene = 0; scene < 6; scene++) {
        const bool glass = scene % 3 == 0;
        const struct pen_transform turn = pen_transform_make(
            scene & 1 ? .4 : -.4, random_direction(&r), random_in(&r, 0, 360), pen_vec3(1, 0, 0));
        make_ball(&r, glass);
        begin(&kit[1], glass);
        kit_sphere(&kit[1], pen_vec3(0, 0, 0), 1, -1)->kind = PEN_OBJECT_MESH;
        kit[1].objects[1].u.mesh = &mesh;
        kit_group(&kit[1], 1, &turn);
        end(&kit[1], scene);
        begin(&kit[0], glass);
        struct pen_scene *frozen = kit_freeze(&kit[1]);
        add_rounded(frozen);
        pen_scene_free(frozen);
        end(&kit[0], scene);
        check_equal(scene);
    }
}
END_TEST

PEN_SUITE("mesh_pictures", test_mesh_pictures__are_those_of_triangles,
          test_mesh_pictures__turned_meshes_are_their_rounded_triangles)
