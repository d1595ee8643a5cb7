/* SPDX-License-Identifier: MIT */
#include "bench/scenes/haines.h"

void haines_begin(struct scene_text *s, const char *name, struct pen_vec3 from, struct pen_vec3 at,
                  struct pen_vec3 up, double degrees)
{
    /* The middles of 513 pixels are the corners of 512: the picture is wider by a pixel. */
    double width = 2 * tan(degrees * HAINES_PI / 360) * 513 / 512;
    struct scene_view view = {from, at, up, width, width};
    scene_begin(s, name, pen_vec3(0.078, 0.361, 0.753), pen_vec3(0.2, 0.2, 0.2), &view);
}

void haines_lights(struct scene_text *s, const struct pen_vec3 *position, int count)
{
    double one = sqrt(count) / (2 * count);
    for (int i = 0; i < count; i++)
        scene_light(s, position[i], pen_vec3(one, one, one), 0, 0);
}

void haines_matt(struct scene_text *s, const char *name, struct pen_vec3 colour, double kd)
{
    scene_material(s, name, (struct scene_look){.kd = pen_scale(colour, kd), .shininess = 1});
}

void haines_shiny(struct scene_text *s, const char *name, struct pen_vec3 colour, double kd,
                  double kr, double ks)
{
    scene_material(
        s, name,
        (struct scene_look){.kd = pen_scale(colour, kd), .ks = ks, .shininess = 30, .kr = kr});
}

void haines_end(struct scene_text *s)
{
    scene_end(s, "\"width\": 513, \"height\": 513, \"max_depth\": 5, \"min_contribution\": 0");
}

struct pen_vec3 haines_turn(struct pen_vec3 v, struct pen_vec3 axis, double angle)
{
    struct pen_vec3 along = pen_scale(axis, pen_dot(axis, v)), off = pen_sub(v, along);
    return pen_add(along,
                   pen_add(pen_scale(off, cos(angle)), pen_scale(pen_cross(axis, v), sin(angle))));
}
