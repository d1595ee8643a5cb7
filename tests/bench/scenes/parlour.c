/* SPDX-License-Identifier: MIT */
#include "bench/scenes/parlour.h"

#include "bench/scenes/scene_text.h"

static void box(struct scene_text *s, const char *material, struct pen_vec3 lo, struct pen_vec3 hi)
{
    scene_use(s, material);
    scene_box(s, lo, hi);
}

static void upright(struct scene_text *s, const char *material, struct pen_vec3 foot, double radius,
                    double height)
{
    scene_use(s, material);
    scene_cylinder(s, foot, pen_add(foot, pen_vec3(0, height, 0)), radius, true);
}

static void ball(struct scene_text *s, const char *material, double x, double y, double z,
                 double radius)
{
    scene_use(s, material);
    scene_sphere(s, pen_vec3(x, y, z), radius);
}

static void put_walls(struct scene_text *s)
{
    scene_use(s, "floor");
    scene_quad(s, pen_vec3(-150, 0, -200), pen_vec3(-150, 0, 260), pen_vec3(150, 0, 260),
               pen_vec3(150, 0, -200));
    scene_use(s, "ceiling");
    scene_quad(s, pen_vec3(-150, 240, -200), pen_vec3(150, 240, -200), pen_vec3(150, 240, 260),
               pen_vec3(-150, 240, 260));
    scene_use(s, "wall");
    scene_quad(s, pen_vec3(-150, 0, -200), pen_vec3(150, 0, -200), pen_vec3(150, 240, -200),
               pen_vec3(-150, 240, -200));
    scene_quad(s, pen_vec3(-150, 0, 260), pen_vec3(-150, 0, -200), pen_vec3(-150, 240, -200),
               pen_vec3(-150, 240, 260));
    scene_quad(s, pen_vec3(150, 0, -200), pen_vec3(150, 0, 260), pen_vec3(150, 240, 260),
               pen_vec3(150, 240, -200));
}

static void put_furniture(struct scene_text *s)
{
    box(s, "wood", pen_vec3(-50, 40, 10), pen_vec3(40, 44, 80)); /* a table */
    for (int i = 0; i < 4; i++)
        upright(s, "iron", pen_vec3(i % 2 ? 35 : -45, 0, i / 2 ? 75 : 15), 2, 40);
    box(s, "dark wood", pen_vec3(-60, 0, -195), pen_vec3(60, 70, -150)); /* a sideboard */
    box(s, "cloth", pen_vec3(70, 15, -60), pen_vec3(130, 40, 0));        /* an armchair */
    box(s, "cloth", pen_vec3(70, 40, -72), pen_vec3(130, 95, -60));
    box(s, "cloth", pen_vec3(60, 15, -72), pen_vec3(70, 60, 0));
    box(s, "cloth", pen_vec3(130, 15, -72), pen_vec3(140, 60, 0));
    box(s, "red", pen_vec3(-40, 70, -185), pen_vec3(-15, 76, -165)); /* books */
    box(s, "blue", pen_vec3(-38, 76, -184), pen_vec3(-17, 81, -166));
}

static void put_lamp(struct scene_text *s)
{
    upright(s, "iron", pen_vec3(-110, 0, -120), 16, 3);
    upright(s, "iron", pen_vec3(-110, 3, -120), 1.5, 132);
    scene_use(s, "shade");
    scene_cylinder(s, pen_vec3(-110, 125, -120), pen_vec3(-110, 165, -120), 22, false);
    ball(s, "bulb", -110, 145, -120, 6.5);
}

/* A rectangle in the plane z, facing the camera. */
static void frame(struct scene_text *s, double x0, double y0, double x1, double y1, double z)
{
    scene_quad(s, pen_vec3(x0, y0, z), pen_vec3(x1, y0, z), pen_vec3(x1, y1, z),
               pen_vec3(x0, y1, z));
}

/* A picture on the left wall. */
static void hang(struct scene_text *s, const char *material, double x, double y0, double y1,
                 double z0, double z1)
{
    scene_use(s, material);
    scene_quad(s, pen_vec3(x, y0, z0), pen_vec3(x, y0, z1), pen_vec3(x, y1, z1),
               pen_vec3(x, y1, z0));
}

static void put_small_things(struct scene_text *s)
{
    static const double fruit[6][3] = {{-20, 50, 40}, {-8, 50, 44},  {-14, 50, 52},
                                       {-26, 50, 50}, {-17, 60, 46}, {20, 50, 30}};
    static const char *const skin[3] = {"red", "green", "glass"};
    for (int i = 0; i < 6; i++)
        ball(s, skin[i % 3], fruit[i][0], fruit[i][1], fruit[i][2], 6);
    scene_use(s, "mirror");
    frame(s, -40, 95, 40, 185, -199);
    scene_use(s, "gold");
    frame(s, -44, 91, 44, 95, -198);
    frame(s, -44, 185, 44, 189, -198);
    frame(s, -44, 95, -40, 185, -198);
    frame(s, 40, 95, 44, 185, -198);
    hang(s, "gold", -149, 90, 160, -60, 40);
    hang(s, "blue", -148, 95, 155, -55, 35);
    upright(s, "glass", pen_vec3(20, 70, -172), 7, 26);
    ball(s, "green", 20, 106, -172, 11);
    ball(s, "gold", -50, 76, -172, 6);
}

/* 17 spheres and cylinders below the ceiling, and a stool of six. */
static void put_more(struct scene_text *s)
{
    upright(s, "gold", pen_vec3(0, 190, 60), 1.5, 50);
    ball(s, "gold", 0, 188, 60, 6);
    for (int i = 0; i < 5; i++) {
        double x = 30 * cos(1.2566370614359172 * i), z = 60 + 30 * sin(1.2566370614359172 * i);
        scene_use(s, "gold");
        scene_cylinder(s, pen_vec3(0, 188, 60), pen_vec3(x, 182, z), 1, true);
        upright(s, "ceiling", pen_vec3(x, 182, z), 2, 12);
        ball(s, "bulb", x, 197, z, 3);
    }
    for (int i = 0; i < 4; i++)
        upright(s, "wood", pen_vec3(i % 2 ? -85 : -105, 0, i / 2 ? 40 : 20), 1.5, 34);
    upright(s, "cloth", pen_vec3(-95, 34, 30), 18, 5);
    ball(s, "glass", -95, 49, 30, 10);
}

static void put_material(struct scene_text *s, const char *name, struct pen_vec3 kd, double ks,
                         double shininess)
{
    scene_material(s, name, (struct scene_look){.kd = kd, .ks = ks, .shininess = shininess});
}

static void put_materials(struct scene_text *s)
{
    scene_material(
        s, "floor",
        (struct scene_look){.kd = pen_vec3(0.45, 0.33, 0.22), .shininess = 1, .kr = 0.15});
    put_material(s, "ceiling", pen_vec3(0.6, 0.6, 0.58), 0, 1);
    put_material(s, "wall", pen_vec3(0.55, 0.57, 0.52), 0, 1);
    put_material(s, "wood", pen_vec3(0.5, 0.33, 0.16), 0.2, 40);
    put_material(s, "dark wood", pen_vec3(0.3, 0.17, 0.09), 0.2, 40);
    put_material(s, "iron", pen_vec3(0.1, 0.1, 0.11), 0.5, 60);
    put_material(s, "cloth", pen_vec3(0.55, 0.3, 0.08), 0, 1);
    put_material(s, "red", pen_vec3(0.6, 0.1, 0.08), 0.3, 60);
    put_material(s, "green", pen_vec3(0.15, 0.45, 0.2), 0.3, 60);
    put_material(s, "blue", pen_vec3(0.1, 0.2, 0.5), 0, 1);
    put_material(s, "gold", pen_vec3(0.5, 0.38, 0.12), 0.5, 50);
    scene_material(s, "glass",
                   (struct scene_look){
                       .kd = pen_vec3(0.05, 0.05, 0.05), .ks = 0.6, .shininess = 120, .kt = 0.75});
    scene_material(
        s, "bulb",
        (struct scene_look){.emission = pen_vec3(0.6, 0.5, 0.3), .shininess = 1, .kt = 0.9});
    scene_material(s, "shade",
                   (struct scene_look){.emission = pen_vec3(0.2, 0.15, 0.08),
                                       .kd = pen_vec3(0.1, 0.1, 0.1),
                                       .shininess = 1,
                                       .kt = 0.7});
    scene_material(s, "mirror", (struct scene_look){.ks = 0.5, .shininess = 300, .kr = 0.85});
}

static void begin(struct scene_text *s, const char *name, double height)
{
    struct scene_view view = {pen_vec3(40, 120, 420), pen_vec3(-5, 92, 0), pen_vec3(0, 1, 0), 0.62,
                              height};
    scene_begin(s, name, pen_vec3(0, 0, 0), pen_vec3(0.1, 0.1, 0.12), &view);
    put_materials(s);
}

static void put_room(struct scene_text *s)
{
    put_walls(s);
    put_furniture(s);
    put_lamp(s);
    put_small_things(s);
}

void parlour_soft(int size)
{
    struct scene_text s;
    (void)size;
    begin(&s, "soft-room", 0.93);
    scene_light(&s, pen_vec3(-110, 145, -120), pen_vec3(1, 0.8, 0.55), 0.00002, 6);
    scene_light(&s, pen_vec3(30, 215, 120), pen_vec3(0.75, 0.75, 0.8), 0.00001, 12);
    put_room(&s);
    scene_end(&s, "\"width\": 400, \"height\": 600, \"light_pattern\": \"grid\", "
                  "\"light_samples\": 225");
}

void parlour_hard(int size)
{
    struct scene_text s;
    (void)size;
    begin(&s, "parlour", 0.868);
    scene_light(&s, pen_vec3(-110, 145, -120), pen_vec3(1, 0.8, 0.55), 0.00002, 0);
    scene_light(&s, pen_vec3(30, 215, 120), pen_vec3(0.6, 0.6, 0.65), 0.00001, 0);
    scene_light(&s, pen_vec3(0, 180, 60), pen_vec3(0.4, 0.35, 0.25), 0.00001, 0);
    put_room(&s);
    put_more(&s);
    scene_end(&s, "\"width\": 1000, \"height\": 1400");
}
