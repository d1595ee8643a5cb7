/* SPDX-License-Identifier: MIT */
/* The output of `penumbra render --pixel X,Y`: all values of one pixel. */
#ifndef PEN_CMD_CLIENT_PIXEL_REPORT_H
#define PEN_CMD_CLIENT_PIXEL_REPORT_H

#include <jansson.h>
#include <stdbool.h>

#include "render/render.h"

struct pen_pixel {
    int x, y;
    const char *view;
    double rgb[3]; /* linear, before rounding to the film's binary32 */
    struct pen_ray_counts rays;
};

/* Reads "X,Y", both ≥ 0.
 * Fails: PEN_USAGE. */
bool pen_pixel_parse(const char *text, int *x, int *y, struct pen_status *st);

/* Prints the pixel as text, in full precision and as hexadecimal floats. */
void pen_pixel_print(const struct pen_pixel *pixel, const struct pen_settings *settings);

/* Makes the same as JSON.
 * Owns: the caller calls json_decref().
 * Fails: NULL when out of memory. */
json_t *pen_pixel_json(const struct pen_pixel *pixel, const struct pen_settings *settings);

#endif
