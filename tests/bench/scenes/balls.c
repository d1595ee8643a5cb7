/* SPDX-License-Identifier: MIT */
/* The sphere flake. A sphere carries nine spheres of a third of its radius, each of these carries
 * nine more, and so on; below them is a floor. The nine touch their sphere at the directions of
 * three triples. A triple is three corners of a cuboctahedron, tilted so that it is symmetric about
 * its middle. The triples are a third of a turn apart about the direction from the parent. */
#include "bench/scenes/haines.h"

static void make_directions(struct pen_vec3 direction[9])
{
    double d = sqrt(0.5);
    struct pen_vec3 corner[3] = {pen_vec3(d, d, 0), pen_vec3(d, 0, -d), pen_vec3(0, d, -d)};
    struct pen_vec3 tilt = pen_vec3(d, -d, 0), z = pen_vec3(0, 0, 1);
    for (int i = 0; i < 9; i++)
        direction[i] = haines_turn(haines_turn(corner[i % 3], tilt, asin(2 / sqrt(6.0))), z,
                                   i / 3 * 2 * HAINES_PI / 3);
}

/* v, given about the z axis, turned the short way so that z becomes `to`. */
static struct pen_vec3 about(struct pen_vec3 v, struct pen_vec3 to)
{
    if (to.z >= 0.9999)
        return v;
    if (to.z <= -0.9999)
        return haines_turn(v, pen_vec3(0, 1, 0), HAINES_PI);
    return haines_turn(v, pen_normalize(pen_vec3(-to.y, to.x, 0)), acos(to.z));
}

static void grow(struct scene_text *s, const struct pen_vec3 direction[9], int depth,
                 struct pen_vec3 center, double radius, struct pen_vec3 up)
{
    scene_sphere(s, center, radius);
    if (depth == 0)
        return;
    for (int i = 0; i < 9; i++) {
        struct pen_vec3 d = about(direction[i], up);
        grow(s, direction, depth - 1, pen_along(center, d, radius * 4 / 3), radius / 3, d);
    }
}

void haines_balls(int size)
{
    static const struct pen_vec3 light[3] = {{4, 3, 2}, {1, -4, 4}, {-3, 1, 5}};
    struct scene_text s;
    struct pen_vec3 direction[9];
    haines_begin(&s, "balls", pen_vec3(2.1, 1.3, 1.7), pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 45);
    haines_matt(&s, "floor", pen_vec3(1, 0.75, 0.33), 0.8);
    haines_shiny(&s, "ball", pen_vec3(1, 0.9, 0.7), 0.5, 0.5, 0.5);
    haines_lights(&s, light, 3);
    scene_use(&s, "floor");
    scene_quad(&s, pen_vec3(12, 12, -0.5), pen_vec3(-12, 12, -0.5), pen_vec3(-12, -12, -0.5),
               pen_vec3(12, -12, -0.5));
    scene_use(&s, "ball");
    make_directions(direction);
    grow(&s, direction, size, pen_vec3(0, 0, 0), 0.5, pen_vec3(0, 0, 1));
    haines_end(&s);
}
