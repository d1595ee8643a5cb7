/* SPDX-License-Identifier: MIT */
/* What the scenes of Haines' Standard Procedural Databases have in common: the sky, the square
 * picture of 513 x 513 eye rays through the corners of 512 x 512 pixels, five surfaces to a path
 * and no cut-off, and lights whose number sets their intensity. A generator is written from the
 * rules that he published: sizes, positions, recursion, view and lights. Each takes his size
 * factor; at the default there are as many primitives as fit below 10 000. Source: Haines, "A
 * proposal for standard graphics environments", IEEE CG&A 7(11), 1987; rules and counts of rays in
 * the databases' Readme, version 3.14, 2005. */
#ifndef BENCH_SCENES_HAINES_H
#define BENCH_SCENES_HAINES_H

#include "bench/scenes/scene_text.h"

#define HAINES_PI 3.14159265358979323846

/* Begins a scene with the view `from` `at`. `degrees` is the angle between the first eye ray of a
 * row and the last. */
void haines_begin(struct scene_text *s, const char *name, struct pen_vec3 from, struct pen_vec3 at,
                  struct pen_vec3 up, double degrees);
/* Lights of equal intensity sqrt(n) / (2 n). */
void haines_lights(struct scene_text *s, const struct pen_vec3 *position, int count);
/* A matt material, and one that also reflects. */
void haines_matt(struct scene_text *s, const char *name, struct pen_vec3 colour, double kd);
void haines_shiny(struct scene_text *s, const char *name, struct pen_vec3 colour, double kd,
                  double kr, double ks);
void haines_end(struct scene_text *s);

/* A vector turned about an axis of unit length by an angle in radians, right-handed. */
struct pen_vec3 haines_turn(struct pen_vec3 v, struct pen_vec3 axis, double angle);

void haines_balls(int size);
void haines_gears(int size);
void haines_lattice(int size);
void haines_mount(int size);
void haines_rings(int size);
void haines_teapot(int size);
void haines_tetra(int size);

#endif
