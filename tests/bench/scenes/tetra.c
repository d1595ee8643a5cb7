/* SPDX-License-Identifier: MIT */
/* The tetrahedral pyramid: a tetrahedron of four tetrahedra half as large, each of these of four
 * more. A tetrahedron's corners are those of a cube whose signs have the product 1. */
#include "bench/scenes/haines.h"

static struct pen_vec3 corner(struct pen_vec3 center, double half, int i)
{
    static const int sign[4][3] = {{-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}, {1, 1, 1}};
    return pen_add(center, pen_scale(pen_vec3(sign[i][0], sign[i][1], sign[i][2]), half));
}

static void grow(struct scene_text *s, int depth, struct pen_vec3 center, double half)
{
    static const int face[4][3] = {{0, 1, 2}, {3, 2, 1}, {2, 3, 0}, {1, 0, 3}};
    for (int i = 0; i < 4; i++) {
        if (depth > 1) {
            grow(s, depth - 1, corner(center, half / 2, i), half / 2);
        } else {
            struct pen_vec3 v[3];
            for (int k = 0; k < 3; k++)
                v[k] = corner(center, half, face[i][k]);
            scene_polygon(s, v, 3);
        }
    }
}

void haines_tetra(int size)
{
    static const struct pen_vec3 light[1] = {{2, -18, -5}};
    double up = sqrt(2.0 / 3);
    struct scene_text s;
    haines_begin(&s, "tetra", pen_vec3(1.022846, -3.177154, -2.174512),
                 pen_vec3(-0.004103, -0.004103, 0.216539), pen_vec3(-up, -up, up), 45);
    haines_matt(&s, "red", pen_vec3(1, 0.2, 0.2), 1);
    haines_lights(&s, light, 1);
    scene_use(&s, "red");
    grow(&s, size, pen_vec3(0, 0, 0), 1);
    haines_end(&s);
}
