/* SPDX-License-Identifier: MIT */
/* Interlocked rings. A figure has six pentagonal rings, each of five cylinders joined by spheres.
 * They lie in the six planes through the middles of a dodecahedron's edges. Figures form a pyramid
 * whose layers are squares of 1, 4, 9 ... figures, seen from above its tip, with a wall behind. */
#include "bench/scenes/haines.h"

enum { RINGS = 6, CORNERS = 5 };

static const double thick = 0.07412; /* the radius at which the rings just touch */

/* The rings' corners; the figure fits a sphere of radius 1. */
static void make_figure(struct pen_vec3 corner[RINGS][CORNERS])
{
    struct pen_vec3 x = pen_vec3(1, 0, 0), z = pen_vec3(0, 0, 1);
    double between_faces = 2 * acos(cos(HAINES_PI / 3) / sin(HAINES_PI / 5));
    for (int i = 0; i < CORNERS; i++) {
        double a = i * 2 * HAINES_PI / 5;
        corner[0][i] = pen_scale(pen_vec3(cos(a), sin(a), 0), 1 / (1 + thick));
        struct pen_vec3 tilted = haines_turn(corner[0][i], x, between_faces);
        for (int ring = 1; ring < RINGS; ring++)
            corner[ring][i] = haines_turn(tilted, z, HAINES_PI * (2 * ring - 1) / 5);
    }
}

static void put_figure(struct scene_text *s, struct pen_vec3 corner[RINGS][CORNERS],
                       struct pen_vec3 at)
{
    static const char *const colour[RINGS] = {"red", "green", "blue", "cyan", "magenta", "yellow"};
    for (int ring = 0; ring < RINGS; ring++) {
        scene_use(s, colour[ring]);
        for (int i = 0; i < CORNERS; i++) {
            struct pen_vec3 from = pen_add(corner[ring][i], at),
                            to = pen_add(corner[ring][(i + CORNERS - 1) % CORNERS], at);
            scene_cylinder(s, from, to, thick, false);
            scene_sphere(s, from, thick);
        }
    }
}

static void put_materials(struct scene_text *s)
{
    haines_matt(s, "wall", pen_vec3(1, 1, 1), 1);
    haines_shiny(s, "red", pen_vec3(1, 0, 0), 0.5, 0.2, 0.3);
    haines_shiny(s, "green", pen_vec3(0, 1, 0), 0.5, 0.2, 0.3);
    haines_shiny(s, "blue", pen_vec3(0, 0, 1), 0.5, 0.2, 0.3);
    haines_shiny(s, "cyan", pen_vec3(0, 1, 1), 0.5, 0.2, 0.3);
    haines_shiny(s, "magenta", pen_vec3(1, 0, 1), 0.5, 0.2, 0.3);
    haines_shiny(s, "yellow", pen_vec3(1, 1, 0), 0.5, 0.2, 0.3);
}

void haines_rings(int size)
{
    double apart = 1 / sin(HAINES_PI / 8); /* of two layers: as far as the eye is from the first */
    struct pen_vec3 eye = pen_vec3(-1, -apart, 0.5), corner[RINGS][CORNERS];
    const struct pen_vec3 light[3] = {{3, -apart, 3}, {-4, -apart, 1}, {2, -apart, -4}};
    double behind = apart * (size + 1), half = 1.01 * (behind - eye.y) * tan(HAINES_PI / 8);
    struct scene_text s;
    haines_begin(&s, "rings", eye, pen_vec3(-1, 1 - apart, 0.5), pen_vec3(0, 0, 1), 45);
    put_materials(&s);
    haines_lights(&s, light, 3);
    scene_use(&s, "wall");
    scene_quad(&s, pen_vec3(eye.x + half, behind, eye.z + half),
               pen_vec3(eye.x - half, behind, eye.z + half),
               pen_vec3(eye.x - half, behind, eye.z - half),
               pen_vec3(eye.x + half, behind, eye.z - half));
    make_figure(corner);
    for (int layer = 0; layer < size; layer++) {
        for (int z = 0; z <= layer; z++) {
            for (int x = 0; x <= layer; x++)
                put_figure(&s, corner, pen_vec3(2 * x - layer, apart * (layer + 1), 2 * z - layer));
        }
    }
    haines_end(&s);
}
