/* SPDX-License-Identifier: MIT */
/* Writes the scenes of the benchmarks as penumbra-scene/1 documents, value by value. Calls come in
 * the document's order: scene_begin, materials, lights, objects, scene_end. Numbers have 17 digits,
 * so that the reader gets the same doubles. */
#ifndef BENCH_SCENES_SCENE_TEXT_H
#define BENCH_SCENES_SCENE_TEXT_H

#include <stdbool.h>
#include <stdio.h>

#include "math/exact.h"

struct scene_text {
    FILE *out;
    const char *section;  /* the open list; "" before the first list */
    bool follows;         /* the open list has a member, so a comma comes before the next */
    const char *material; /* of the next objects */
};

/* A camera whose picture is a rectangle `width` x `height` at distance 1. */
struct scene_view {
    struct pen_vec3 eye, at, up;
    double width, height;
};

/* A material, with the names of api/scene-format.md; ka equals kd. */
struct scene_look {
    struct pen_vec3 kd, emission;
    double ks, shininess, kt, kr;
    double ior; /* 0 stands for 1 */
};

void scene_begin(struct scene_text *s, const char *name, struct pen_vec3 background,
                 struct pen_vec3 ambient, const struct scene_view *view);
void scene_material(struct scene_text *s, const char *name, struct scene_look look);
/* A point light; radius 0 makes hard shadows. */
void scene_light(struct scene_text *s, struct pen_vec3 position, struct pen_vec3 intensity,
                 double quadratic_attenuation, double radius);

/* Sets the material of the next objects. */
void scene_use(struct scene_text *s, const char *material);
void scene_sphere(struct scene_text *s, struct pen_vec3 center, double radius);
/* Between two points. */
void scene_cylinder(struct scene_text *s, struct pen_vec3 from, struct pen_vec3 to, double radius,
                    bool caps);
/* From the centre of its base to its tip. */
void scene_cone(struct scene_text *s, struct pen_vec3 from, struct pen_vec3 to, double radius);
/* Infinite. */
void scene_tube(struct scene_text *s, struct pen_vec3 origin, struct pen_vec3 axis, double radius);
/* Three points make a triangle, more a polygon. */
void scene_polygon(struct scene_text *s, const struct pen_vec3 *vertex, int count);
void scene_quad(struct scene_text *s, struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c,
                struct pen_vec3 d);
/* The six faces of a box. */
void scene_box(struct scene_text *s, struct pen_vec3 lo, struct pen_vec3 hi);

/* Ends the document; `render` is the text of its render settings. */
void scene_end(struct scene_text *s, const char *render);

#endif
