/* SPDX-License-Identifier: MIT */
/* The elementary functions of one number: those of math/lanes_fn.h with one lane. */
#include "math/fn.h"

#include "math/lanes_fn.h"

_Static_assert(LANES == 1, "this file is compiled for the base instruction set");

double pen_exp(double x)
{
    return lanes_exp(x);
}

double pen_ln(double x)
{
    return lanes_ln(x);
}

double pen_pow(double x, double y)
{
    return lanes_pow(x, y);
}

void pen_sincos(double x, double *sine, double *cosine)
{
    lanes_sincos(x, sine, cosine);
}

void pen_sincos_deg(double degrees, double *sine, double *cosine)
{
    lanes_sincos_deg(degrees, sine, cosine);
}
