/* SPDX-License-Identifier: MIT */
/* Rectangles of pixels. */
#ifndef PEN_MATH_RECT_H
#define PEN_MATH_RECT_H

struct pen_rect {
    int x, y, width, height; /* from the top left pixel */
};

#endif
