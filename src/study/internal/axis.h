/* SPDX-License-Identifier: MIT */
/* The axes of charts. */
#ifndef PEN_STUDY_INTERNAL_AXIS_H
#define PEN_STUDY_INTERNAL_AXIS_H

#include <stdbool.h>

/* Maps values to places. Values beyond the ends are moved to the ends. */
struct pen_axis {
    double low, high;  /* values at the ends; above 0 if logarithmic */
    double first, end; /* their places, pixels of the view box */
    bool logarithmic;
};

double pen_axis_place(const struct pen_axis *axis, double value);

/* The distance between ticks over a range: 1, 2 or 5 times a power of ten, so that at most `most`
 * fit. */
double pen_axis_step(double range, int most);

#endif
