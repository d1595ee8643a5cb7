/* SPDX-License-Identifier: MIT */
/* A cubic lattice in the unit cube: shiny spheres, and matt cylinders from each to its neighbours.
 * The eye is inside. Source: Costa's scene of the Standard Procedural Databases. */
#include "bench/scenes/haines.h"

/* A cylinder from a sphere to the next one along an axis, begun and ended inside the spheres. */
static void put_rod(struct scene_text *s, struct pen_vec3 at, struct pen_vec3 step, double inset,
                    double radius)
{
    static const char *const colour[3] = {"red", "green", "blue"};
    double length = step.x + step.y + step.z;
    struct pen_vec3 unit = pen_scale(step, 1 / length);
    scene_use(s, colour[step.x > 0 ? 0 : step.y > 0 ? 1 : 2]);
    scene_cylinder(s, pen_along(at, unit, inset), pen_along(at, unit, length - inset), radius,
                   false);
}

static void put_node(struct scene_text *s, int size, int x, int y, int z)
{
    double step = 1.0 / size, ball = step / 4, rod = step / 16;
    double inset = ball * (1 - sqrt(rod / ball)) * 0.99;
    struct pen_vec3 at = pen_vec3((double)x / size, (double)y / size, (double)z / size);
    scene_use(s, "ball");
    scene_sphere(s, at, ball);
    if (x < size)
        put_rod(s, at, pen_vec3(step, 0, 0), inset, rod);
    if (y < size)
        put_rod(s, at, pen_vec3(0, step, 0), inset, rod);
    if (z < size)
        put_rod(s, at, pen_vec3(0, 0, step), inset, rod);
}

void haines_lattice(int size)
{
    static const struct pen_vec3 light[6] = {{2, 0.5, 0.5},  {-1, 0.5, 0.5}, {0.5, 2, 0.5},
                                             {0.5, -1, 0.5}, {0.5, 0.5, 2},  {0.5, 0.5, -1}};
    double across = (size / 2 + 0.5) / size, down = 1.0 / (2 * size);
    struct scene_text s;
    haines_begin(&s, "lattice", pen_vec3(across, 1, 1 - down), pen_vec3(across, -1, -1 - down),
                 pen_vec3(0.2, 1, 0), 60);
    haines_shiny(&s, "ball", pen_vec3(0.9, 0.9, 0.9), 0.5, 0.5, 0.5);
    haines_matt(&s, "red", pen_vec3(0.9, 0.1, 0.1), 0.99);
    haines_matt(&s, "green", pen_vec3(0.1, 0.9, 0.1), 0.99);
    haines_matt(&s, "blue", pen_vec3(0.1, 0.1, 0.9), 0.99);
    haines_lights(&s, light, 6);
    for (int x = 0; x <= size; x++) {
        for (int y = 0; y <= size; y++) {
            for (int z = 0; z <= size; z++)
                put_node(&s, size, x, y, z);
        }
    }
    haines_end(&s);
}
