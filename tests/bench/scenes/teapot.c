/* SPDX-License-Identifier: MIT */
/* Newell's teapot with a bottom, on a board of size x size squares. Each of its 32 Bezier patches
 * is cut into size x size x 2 triangles. The patches are described by what generates them: profiles
 * turned about the z axis in four quarters, and the halves of handle and spout, mirrored. */
#include "bench/scenes/haines.h"

/* Four points (radius, z) of a profile, and how far along its tangent a quarter circle's inner
 * control point is for them. */
struct profile {
    double point[4][2], reach[4];
    double side; /* the sign of y in the first quarter */
};

static const struct profile turned[6] = {
    {{{1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4}}, {0.56, 0.56, 0.56, 0.56}, -1},
    {{{1.5, 2.4}, {1.75, 1.875}, {2, 1.35}, {2, 0.9}}, {0.56, 0.56, 0.56, 0.56}, -1},
    {{{2, 0.9}, {2, 0.45}, {1.5, 0.225}, {1.5, 0.15}}, {0.56, 0.56, 0.56, 0.56}, -1},
    {{{0, 3.15}, {0.8, 3.15}, {0, 2.85}, {0.2, 2.7}},
     {0, 0.5625, 0, 0.56},
     -1}, /* the lid's knob */
    {{{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}}, {0.56, 0.56, 0.56, 0.56}, -1},
    {{{0, 0}, {1.425, 0}, {1.5, 0.075}, {1.5, 0.15}}, {0, 0.56, 0.56, 0.56}, 1}, /* the bottom */
};

/* Rows of half a tube: two points (x, z) in the plane y = 0, and how far the row bulges from it. */
struct half_tube {
    double row[4][5];
};

static const struct half_tube mirrored[4] = {
    {{{-1.6, 2.025, -1.5, 2.25, 0.3},
      {-2.3, 2.025, -2.5, 2.25, 0.3},
      {-2.7, 2.025, -3, 2.25, 0.3},
      {-2.7, 1.8, -3, 1.8, 0.3}}},
    {{{-2.7, 1.8, -3, 1.8, 0.3},
      {-2.7, 1.575, -3, 1.35, 0.3},
      {-2.5, 1.125, -2.65, 0.9375, 0.3},
      {-2, 0.9, -1.9, 0.6, 0.3}}},
    {{{1.7, 1.425, 1.7, 0.6, 0.66},
      {2.6, 1.425, 3.1, 0.825, 0.66},
      {2.3, 2.1, 2.4, 2.025, 0.25},
      {2.7, 2.4, 3.3, 2.4, 0.25}}},
    {{{2.7, 2.4, 3.3, 2.4, 0.25},
      {2.8, 2.475, 3.525, 2.49375, 0.25},
      {2.9, 2.475, 3.45, 2.5125, 0.15},
      {2.8, 2.4, 3.2, 2.4, 0.15}}},
};

struct patch {
    struct pen_vec3 control[4][4];
};

static struct patch turn_profile(const struct profile *profile, int quarter)
{
    struct patch patch;
    for (int r = 0; r < 4; r++) {
        double radius = profile->point[r][0], z = profile->point[r][1];
        double in = radius * profile->reach[r], side = profile->side;
        const struct pen_vec3 arc[4] = {
            {radius, 0, z}, {radius, side * in, z}, {in, side * radius, z}, {0, side * radius, z}};
        for (int c = 0; c < 4; c++)
            patch.control[r][c] =
                haines_turn(arc[c], pen_vec3(0, 0, 1), side * quarter * HAINES_PI / 2);
    }
    return patch;
}

static struct patch half_of(const struct half_tube *tube, bool other)
{
    struct patch patch;
    for (int r = 0; r < 4; r++) {
        const double *w = tube->row[r];
        const struct pen_vec3 arc[4] = {{w[0], 0, w[1]},
                                        {w[0], other ? w[4] : -w[4], w[1]},
                                        {w[2], other ? w[4] : -w[4], w[3]},
                                        {w[2], 0, w[3]}};
        for (int c = 0; c < 4; c++)
            patch.control[r][c] = arc[other ? 3 - c : c];
    }
    return patch;
}

static struct pen_vec3 point_of(const struct patch *patch, double s, double t)
{
    double bs[4] = {(1 - s) * (1 - s) * (1 - s), 3 * s * (1 - s) * (1 - s), 3 * s * s * (1 - s),
                    s * s * s};
    double bt[4] = {(1 - t) * (1 - t) * (1 - t), 3 * t * (1 - t) * (1 - t), 3 * t * t * (1 - t),
                    t * t * t};
    struct pen_vec3 sum = pen_vec3(0, 0, 0);
    for (int r = 0; r < 4; r++) {
        for (int c = 0; c < 4; c++)
            sum = pen_along(sum, patch->control[r][c], bs[r] * bt[c]);
    }
    return sum;
}

/* Triangles at the tips of lid and bottom that have two corners on the axis are left out. */
static void put_triangle(struct scene_text *s, struct pen_vec3 a, struct pen_vec3 b,
                         struct pen_vec3 c)
{
    struct pen_vec3 v[3] = {a, b, c};
    int on_axis = 0;
    for (int i = 0; i < 3; i++)
        on_axis += fabs(v[i].x) < 1e-4 && fabs(v[i].y) < 1e-4;
    if (on_axis < 2)
        scene_polygon(s, v, 3);
}

static void put_patch(struct scene_text *s, struct patch patch, int size)
{
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++) {
            double s0 = (double)i / size, s1 = (double)(i + 1) / size;
            double t0 = (double)j / size, t1 = (double)(j + 1) / size;
            struct pen_vec3 a = point_of(&patch, s0, t0), b = point_of(&patch, s0, t1),
                            c = point_of(&patch, s1, t1), d = point_of(&patch, s1, t0);
            put_triangle(s, a, b, c);
            put_triangle(s, c, d, a);
        }
    }
}

static void put_board(struct scene_text *s, int size)
{
    double edge = 8.0 / size;
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++) {
            double x = -4 + i * edge, y = -4 + j * edge;
            scene_use(s, (i + j) % 2 ? "white" : "grey");
            scene_quad(s, pen_vec3(x, y, 0), pen_vec3(x + edge, y, 0),
                       pen_vec3(x + edge, y + edge, 0), pen_vec3(x, y + edge, 0));
        }
    }
}

void haines_teapot(int size)
{
    static const struct pen_vec3 light[2] = {{-3.1, 9.8, 12.1}, {11.3, 5.1, 8.8}};
    struct scene_text s;
    haines_begin(&s, "teapot", pen_vec3(4.86, 7.2, 5.4), pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 45);
    haines_shiny(&s, "glaze", pen_vec3(1, 0.5, 0.1), 0.75, 0.25, 0.25);
    haines_shiny(&s, "white", pen_vec3(1, 1, 1), 0.5, 0.5, 0.5);
    haines_shiny(&s, "grey", pen_vec3(0.5, 0.5, 0.5), 0.5, 0.5, 0.5);
    haines_lights(&s, light, 2);
    put_board(&s, size);
    scene_use(&s, "glaze");
    for (int p = 0; p < 6; p++) {
        for (int quarter = 0; quarter < 4; quarter++)
            put_patch(&s, turn_profile(&turned[p], quarter), size);
    }
    for (int p = 0; p < 4; p++) {
        put_patch(&s, half_of(&mirrored[p], false), size);
        put_patch(&s, half_of(&mirrored[p], true), size);
    }
    haines_end(&s);
}
