/* SPDX-License-Identifier: MIT */
/* A fractal mountain behind a pyramid of four glass spheres. A square of the mountain is cut in
 * four. The middles of its edges and its own middle are moved up or down by normal deviates
 * (Carpenter's method). The generator of these is seeded again at each place, with the place. */
#include "bench/scenes/haines.h"

struct mountain {
    struct scene_text *s;
    int size;
    double cell, roughness;
};

/* A normal deviate: the polar method on pairs of a linear congruential generator (Press et al.,
 * "Numerical Recipes", gasdev and the quick generator with modulus 134456). */
static double deviate(const struct mountain *m, int x, int y)
{
    int up = 7 - m->size;
    unsigned long hash = up >= 0 ? (unsigned long)x << up : 0;
    unsigned long seed = 21 + ((hash + ((unsigned long)y << (15 - m->size))) & 0xffff);
    double a, b, r;
    do {
        unsigned long first = (28411 + seed * 8121) % 134456;
        seed = (28411 + first * 8121) % 134456;
        a = (double)first * 2 / 134456 - 1;
        b = (double)seed * 2 / 134456 - 1;
        r = a * a + b * b;
    } while (r >= 1);
    return a * sqrt(-2 * log(r) / r);
}

static void put_cell(const struct mountain *m, int x, int y, const double z[4])
{
    struct pen_vec3 v[5];
    for (int i = 0; i < 4; i++)
        v[i] = pen_vec3(-1 + (x + (i == 1 || i == 2)) * m->cell, -1 + (y + i / 2) * m->cell, z[i]);
    v[4] = v[0];
    scene_polygon(m->s, v, 3);
    scene_polygon(m->s, v + 2, 3);
}

/* A square of `width` cells, with the heights of its corners in the order of its outline. */
static void grow(const struct mountain *m, int width, int x, int y, const double z[4])
{
    int half = width / 2;
    if (width == 1) {
        put_cell(m, x, y, z);
        return;
    }
    double rise = half * m->cell * m->roughness, edge[4];
    const int at[4][2] = {
        {x + half, y}, {x + width, y + half}, {x + half, y + width}, {x, y + half}};
    for (int i = 0; i < 4; i++)
        edge[i] = (z[i] + z[(i + 1) % 4]) / 2 + rise * deviate(m, at[i][0], at[i][1]);
    double middle =
        (z[0] + z[1] + z[2] + z[3]) / 4 + 1.4142136 * rise * deviate(m, x + half, y + half);
    grow(m, half, x, y, (const double[4]){z[0], edge[0], middle, edge[3]});
    grow(m, half, x + half, y, (const double[4]){edge[0], z[1], edge[1], middle});
    grow(m, half, x + half, y + half, (const double[4]){middle, edge[1], z[2], edge[2]});
    grow(m, half, x, y + half, (const double[4]){edge[3], middle, edge[2], z[3]});
}

static void put_spheres(struct scene_text *s)
{
    struct pen_vec3 center = pen_vec3(-0.8, 0.8, 1), up = pen_vec3(0, 0, 0.17 * sqrt(1.5));
    struct pen_vec3 axis = pen_normalize(pen_vec3(1, 1, 0));
    struct pen_vec3 down = haines_turn(up, axis, acos(-1.0 / 3));
    scene_sphere(s, pen_add(center, up), 0.17);
    for (int i = 0; i < 3; i++)
        scene_sphere(
            s, pen_add(center, haines_turn(down, pen_vec3(0, 0, 1), i * 2 * HAINES_PI / 3)), 0.17);
}

void haines_mount(int size)
{
    static const struct pen_vec3 light[1] = {{-100, -100, 100}};
    static const double level[4] = {0};
    struct scene_text s;
    haines_begin(&s, "mount", pen_vec3(-1.6, 1.6, 1.7), pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 45);
    scene_material(&s, "glass",
                   (struct scene_look){.kd = pen_vec3(0.1, 0.1, 0.1),
                                       .ks = 0.4,
                                       .shininess = 30,
                                       .kt = 0.9,
                                       .kr = 0.1,
                                       .ior = 1.5});
    haines_matt(&s, "rock", pen_vec3(0.5, 0.45, 0.35), 1);
    haines_lights(&s, light, 1);
    scene_use(&s, "glass");
    put_spheres(&s);
    scene_use(&s, "rock");
    double ratio = 2 / pow(2, 1 / 1.2); /* fractal dimension 2.2 */
    struct mountain m = {&s, size, 2.0 / (1 << size), sqrt(ratio * ratio - 1)};
    grow(&m, 1 << size, 0, 0, level);
    haines_end(&s);
}
