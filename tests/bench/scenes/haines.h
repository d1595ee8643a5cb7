/* SPDX-License-Identifier: MIT */
/* The parts that the scenes of Haines' Standard Procedural Databases share. They are the sky, the
 * view and the lights. The picture is square: 513 x 513 eye rays through the corners of 512 x 512
 * pixels. A path has at most five surfaces, and no cut-off. The number of lights sets their
 * intensity. A generator follows the rules that he published: sizes, positions, recursion, view and
 * lights. Each has his size factor as its parameter. With the default there are as many primitives
 * as fit below 10 000.
 * Source: Haines, "A proposal for standard graphics environments", IEEE CG&A 7(11), 1987; rules and
 * counts of rays in the databases' Readme, version 3.14, 2005. */
#ifndef BENCH_SCENES_HAINES_H
#define BENCH_SCENES_HAINES_H

#include "bench/scenes/scene_text.h"

#define HAINES_PI 3.14159265358979323846

/* Begins a scene with the view `from` `at`. `degrees` is the angle between the first and the last
 * eye ray of a row. */
void haines_begin(struct scene_text *s, const char *name, struct pen_vec3 from, struct pen_vec3 at,
                  struct pen_vec3 up, double degrees);
/* Writes lights of equal intensity sqrt(n) / (2 n). */
void haines_lights(struct scene_text *s, const struct pen_vec3 *position, int count);
/* Write a matt material, and a material that also reflects. */
void haines_matt(struct scene_text *s, const char *name, struct pen_vec3 colour, double kd);
void haines_shiny(struct scene_text *s, const char *name, struct pen_vec3 colour, double kd,
                  double kr, double ks);
void haines_end(struct scene_text *s);

/* Turns a vector about an axis of unit length by an angle in radians, right-handed. */
struct pen_vec3 haines_turn(struct pen_vec3 v, struct pen_vec3 axis, double angle);

void haines_balls(int size);
void haines_gears(int size);
void haines_lattice(int size);
void haines_mount(int size);
void haines_rings(int size);
void haines_teapot(int size);
void haines_tetra(int size);

#endif
