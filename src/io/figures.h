/* SPDX-License-Identifier: MIT */
/* The measurements of a render as JSON, in the form of all reports and statistics.
 * Owns: each function returns a new value, which the caller json_decref()s.
 * Fails: NULL when out of memory. */
#ifndef PEN_IO_FIGURES_H
#define PEN_IO_FIGURES_H

#include <jansson.h>

#include "render/render.h"

/* A number rounded to millionths, so that milliseconds are exact to the nanosecond. */
json_t *pen_figure(double value);

/* An error of a picture, rounded to millionths. */
json_t *pen_figure_error(double error);

/* {primary, shadow, reflection, transmission, total}: counts of rays. */
json_t *pen_figure_rays(const struct pen_ray_counts *rays);

/* Millions of rays per second. */
json_t *pen_figure_rate(const struct pen_ray_counts *rays, double render_ms);

/* {kind, nodes, leaves, depth, bytes, sah_cost, build_ms}; for `auto` also choice and
 * expected_costs; box_tests_per_ray and primitive_tests_per_ray if the render counted intersection
 * tests. */
json_t *pen_figure_accelerator(const struct pen_accel_stats *accel,
                               const struct pen_render_stats *stats);

/* The names of the effects in a mask of PEN_FX_ bits, as an array of strings. */
json_t *pen_figure_effects(unsigned effects);

/* {cpu, isa, cores, version}: the machine and the version of Penumbra. */
json_t *pen_figure_host(void);

#endif
