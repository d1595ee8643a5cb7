/* SPDX-License-Identifier: MIT */
/* Writing the scenes of the benchmarks as penumbra-scene/1 documents, a value at a time. Calls come
 * in the document's order: scene_begin, materials, lights, objects, scene_end. Numbers are written
 * in 17 digits, so that the reader gets the same doubles. */
#ifndef BENCH_SCENES_SCENE_TEXT_H
#define BENCH_SCENES_SCENE_TEXT_H

#include <stdbool.h>
#include <stdio.h>

#include "math/exact.h"

struct scene_text {
    FILE *out;
    const char *section;  /* the list that is open, "" before the first */
    bool follows;         /* the open list has a member, so that the next one needs a comma */
    const char *material; /* of the objects to come */
};

/* A camera whose picture is a rectangle `width` x `height` at distance 1. */
struct scene_view {
    struct pen_vec3 eye, at, up;
    double width, height;
};

/* A material, in the words of api/scene-format.md; ka is kd. */
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

/* The material of the objects that follow. */
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
