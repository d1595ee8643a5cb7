/* SPDX-License-Identifier: MIT */
/* The project's own exp, ln, pow, sin and cos, so that a picture does not depend on the machine's
 * libm. Each is a fixed sequence of IEEE operations (+ - * and integer operations). It gives the
 * same bits on every machine, with every compiler and optimisation level. Error bounds are relative
 * to the exact result, in ulp of the result, and are tested against __float128. So a result is at
 * most one double away from the correctly rounded one.
 *
 * Worst error found in 1e7 arguments per function, hard ranges included (tests/math/test_fn.c,
 * PEN_N=1000000): exp 0.57, ln 0.501, pow 0.57, sincos 0.80, sincos_deg 0.81.
 *
 * Subnormal results of exp and pow round twice. The first rounding, to 53 bits, is within the 0.57
 * ulp above, at most 0.285 of the spacing 2^-1074. The second, to that spacing, is at most 0.5 of
 * it. So the error is below 0.79 times 2^-1074 (0.76 found), and a result may be 2^-1074 away from
 * the correctly rounded one. In ulp of a double with 53 bits this is no bound, because the spacing
 * is 2^-1074 for any small result. */
#ifndef PEN_MATH_FN_H
#define PEN_MATH_FN_H

/* e^x. Error: <= 1 ulp; below 0.79 times 2^-1074 if the result is subnormal. Overflows to +inf,
 * underflows to 0; NaN gives NaN. */
double pen_exp(double x);

/* Natural logarithm. Error: <= 1 ulp. 0 gives -inf, negative and NaN give NaN. */
double pen_ln(double x);

/* The shading model's power: x^y for x > 0, y >= 0; 0 if x <= 0 (for any y); 1 if y is 0 and x > 0.
 * Error: <= 1 ulp, also for x near 1 and y up to 1e6 and beyond; below 0.79 times 2^-1074 if the
 * result is subnormal. */
double pen_pow(double x, double y);

/* Sine and cosine. Error: <= 1 ulp for |x| <= 2^20. Outside that range the results are NaN.
 * Units: radians. */
void pen_sincos(double x, double *sine, double *cosine);

/* Sine and cosine, exact at multiples of 90 (and of 30 and 60 if the result is representable).
 * Error: <= 1 ulp for |degrees| <= 2^20, after exact reduction in degrees. Outside that range the
 * results are NaN.
 * Units: degrees. */
void pen_sincos_deg(double degrees, double *sine, double *cosine);

#endif
