/* SPDX-License-Identifier: MIT */
#include "film/error_map.h"

#include "film/encode.h"

enum { CONTROL_POINTS = 16, STEPS = 256 };

/* sRGB codes of the colour map magma at 0, 1/15, … 1. Between them, linear interpolation is within
 * 3/255 of the whole table.
 * Source: van der Walt and Smith, the colour maps of Matplotlib 1.5, dedicated to the public domain
 * (CC0). */
static const unsigned char magma[CONTROL_POINTS][3] = {
    {0, 0, 4},       {11, 9, 36},     {32, 17, 75},    {59, 15, 112},
    {87, 21, 126},   {114, 31, 129},  {140, 41, 129},  {168, 50, 125},
    {196, 60, 117},  {222, 73, 104},  {241, 96, 93},   {250, 127, 94},
    {254, 159, 109}, {254, 191, 132}, {253, 222, 160}, {252, 253, 191}};

/* The linear colours of all steps. */
static void make_colours(float colour[STEPS][3])
{
    for (int i = 0; i < STEPS; i++) {
        const double at = (double)i * (CONTROL_POINTS - 1) / (STEPS - 1);
        const int point = at < CONTROL_POINTS - 1 ? (int)at : CONTROL_POINTS - 2;
        for (int c = 0; c < 3; c++) {
            const double low = magma[point][c], high = magma[point + 1][c],
                         code = low + (high - low) * (at - point);
            colour[i][c] = (float)pen_decode_srgb(code / 255);
        }
    }
}

struct pen_film *pen_error_map(const float *errors, int width, int height, enum pen_error_map kind,
                               struct pen_status *st)
{
    struct pen_film *film = pen_film_new(width, height, st);
    float colour[STEPS][3];
    if (!film)
        return NULL;
    make_colours(colour);
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
        const int step = (int)((double)errors[i] * (STEPS - 1) + 0.5);
        for (int c = 0; c < 3; c++)
            film->rgb[3 * i + (size_t)c] =
                kind == PEN_ERROR_MAP_COLOURS ? colour[step][c] : errors[i];
    }
    return film;
}
