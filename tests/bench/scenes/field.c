/* SPDX-License-Identifier: MIT */
#include "bench/scenes/parlour.h"
#include "bench/scenes/scene_text.h"
#include "support/random.h"

static void begin(struct scene_text *s, const char *name, struct pen_vec3 eye)
{
    struct scene_view view = {eye, pen_vec3(0, 0, 0), pen_vec3(0, 1, 0), 0.8, 0.6};
    scene_begin(s, name, pen_vec3(0.1, 0.15, 0.3), pen_vec3(0.2, 0.2, 0.2), &view);
    scene_material(s, "matt",
                   (struct scene_look){.kd = pen_vec3(0.7, 0.6, 0.5), .ks = 0.2, .shininess = 30});
    scene_light(s, pen_vec3(3, 5, 4), pen_vec3(1, 1, 1), 0, 0);
    scene_use(s, "matt");
}

void field(int size)
{
    struct scene_text s;
    struct random r = random_begin(17);
    begin(&s, "field", pen_vec3(0.3, 0.5, 2.5));
    double radius = 1.2 / sqrt(size);
    for (int i = 0; i < size; i++)
        scene_sphere(&s, random_vec(&r, 1), radius);
    scene_end(&s, "\"width\": 400, \"height\": 300");
}

static void begin_floor(struct scene_text *s, const char *name)
{
    begin(s, name, pen_vec3(0.5, 1.5, 4));
    scene_quad(s, pen_vec3(-3, -0.5, -3), pen_vec3(-3, -0.5, 3), pen_vec3(3, -0.5, 3),
               pen_vec3(3, -0.5, -3));
}

/* Where thing i of `size` - 1 stands. */
static struct pen_vec3 place(int i, int size)
{
    return pen_vec3(3.0 * i / size - 1.5, 0, i % 2 ? 0.3 : -0.3);
}

void row(int size)
{
    struct scene_text s;
    begin_floor(&s, "row");
    for (int i = 1; i < size; i++)
        scene_sphere(&s, place(i, size), 1.0 / size);
    scene_end(&s, "\"width\": 800, \"height\": 600");
}

void tubes(int size)
{
    struct scene_text s;
    begin_floor(&s, "tubes");
    for (int i = 1; i < size; i++)
        scene_tube(&s, place(i, size), pen_vec3(i % 3 - 1, 2, i % 5 - 2), 0.4 / size);
    scene_end(&s, "\"width\": 800, \"height\": 600");
}

void cones(int size)
{
    struct scene_text s;
    begin_floor(&s, "cones");
    for (int i = 1; i < size; i++) {
        const struct pen_vec3 base = place(i, size);
        scene_cone(&s, base, pen_vec3(base.x, 2.0 / size, base.z), 1.0 / size);
    }
    scene_end(&s, "\"width\": 800, \"height\": 600");
}
