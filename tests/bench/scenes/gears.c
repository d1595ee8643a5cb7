/* SPDX-License-Identifier: MIT */
/* Meshing gears of 36 teeth in a cubic arrangement, on a mirroring ground. Each has two faces of
 * 144 corners and 144 side walls; every fifth refracts light. */
#include "bench/scenes/haines.h"

enum { TEETH = 36, CORNERS = 4 * TEETH };

static void make_outline(struct pen_vec3 outline[CORNERS], struct pen_vec3 center, double angle,
                         double outer, double inner)
{
    static const double at[4] = {-0.19, 0.19, 0.3, 0.7}; /* of a tooth: its tip, the gap after it */
    for (int i = 0; i < CORNERS; i++) {
        double a = angle + (i / 4 + at[i % 4]) * 2 * HAINES_PI / TEETH;
        double r = i % 4 < 2 ? outer : inner;
        outline[i] = pen_add(center, pen_vec3(r * cos(a), r * sin(a), 0));
    }
}

static void put_gear(struct scene_text *s, struct pen_vec3 center, double angle, double radius,
                     double thickness)
{
    struct pen_vec3 top[CORNERS], bottom[CORNERS];
    make_outline(top, center, angle, 0.995 * radius, 0.9 * radius);
    for (int i = 0; i < CORNERS; i++)
        bottom[i] = pen_sub(top[CORNERS - 1 - i], pen_vec3(0, 0, thickness));
    scene_polygon(s, top, CORNERS);
    for (int i = 0; i < CORNERS; i++) {
        int next = (i + 1) % CORNERS;
        scene_quad(s, top[i], bottom[CORNERS - 1 - i], bottom[CORNERS - 1 - next], top[next]);
    }
    scene_polygon(s, bottom, CORNERS);
}

static void put_gears(struct scene_text *s, int size)
{
    static const char *const colour[4] = {"red", "green", "blue", "yellow"};
    double radius = 1 / (size - (size - 1) * 0.05), apart = radius * 1.9;
    double thickness = fmin(0.1, 1.0 / (2 * size));
    for (int z = 0; z < size; z++) {
        for (int y = 0; y < size; y++) {
            for (int x = 0; x < size; x++) {
                struct pen_vec3 center =
                    pen_vec3(radius - 1 + x * apart, radius - 1 + y * apart, 1 - (double)z / size);
                scene_use(s,
                          (4 * x + 2 * y + z) % 5 == 0 ? "glass" : colour[(x + 2 * y + 3 * z) % 4]);
                put_gear(s, center, HAINES_PI * ((x + y + z) % 2) / TEETH, radius, thickness);
            }
        }
    }
}

void haines_gears(int size)
{
    static const struct pen_vec3 light[5] = {
        {2, 4, 4}, {-2, 4, 3}, {2, -2.5, 2.5}, {-1, -4, 2}, {-1.111, -2.121, 2.626}};
    struct scene_text s;
    haines_begin(&s, "gears", pen_vec3(-1.1, -2.1, 2.6), pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 45);
    haines_shiny(&s, "ground", pen_vec3(1, 0.85, 0.7), 0.3, 0.6, 0.3);
    scene_material(&s, "glass",
                   (struct scene_look){.kd = pen_vec3(0.15, 0.2, 0.2), .kt = 0.8, .ior = 1.1});
    haines_matt(&s, "red", pen_vec3(1, 0.3, 0.2), 1);
    haines_matt(&s, "green", pen_vec3(0.2, 1, 0.4), 1);
    haines_matt(&s, "blue", pen_vec3(0.3, 0.4, 1), 1);
    haines_matt(&s, "yellow", pen_vec3(1, 0.9, 0.2), 1);
    haines_lights(&s, light, 5);
    scene_use(&s, "ground");
    scene_quad(&s, pen_vec3(2, 2, 0), pen_vec3(-2, 2, 0), pen_vec3(-2, -2, 0), pen_vec3(2, -2, 0));
    put_gears(&s, size);
    haines_end(&s);
}
