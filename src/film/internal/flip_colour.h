/* SPDX-License-Identifier: MIT */
/* The colours of FLIP. Colours are filtered as opponents: luminance Y, and the differences X - Y
 * (red and green) and Y - Z (blue and yellow), where X, Y and Z of white are 1. They are YCxCz of
 * the paper without its factors and its offset, which a filter with sum 1 does not change. Colours
 * are compared in CIE L*a*b* after Hunt's adjustment, which multiplies chroma by lightness.
 * Source: Andersson et al. 2020 (flip_filters.h): the colour pipeline. */
#ifndef PEN_FILM_INTERNAL_FLIP_COLOUR_H
#define PEN_FILM_INTERNAL_FLIP_COLOUR_H

/* Converts linear RGB of Rec. 709 to opponents. Components are clamped to [0, 1]; NaN counts as 0.
 */
void pen_flip_opponents(const double rgb[3], double out[3]);

/* Converts opponents to adjusted L*a*b*, after clamping to the colours of a display. */
void pen_flip_lab(const double opponents[3], double out[3]);

/* The largest difference of two colours, that of green and blue, raised to the power of
 * pen_flip_colour_error. */
double pen_flip_colour_error_max(void);

/* The error of two adjusted colours, from 0 to 1. */
double pen_flip_colour_error(const double a[3], const double b[3], double colour_error_max);

#endif
