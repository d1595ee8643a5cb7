/* SPDX-License-Identifier: MIT */
#include "film/internal/flip_colour.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "math/fn.h"

/* Linear RGB to X, Y and Z, which are 1 for white. They are computed from the primaries of Rec.
 * 709, (0.64, 0.33), (0.3, 0.6) and (0.15, 0.06), and the white D65 as (0.31271, 0.32902), the
 * white of FLIP's published values. The fractions are exact. */
static const double to_xyz[3][3] = {
    {10135552 / 23359437.0, 8788810 / 23359437.0, 4435075 / 23359437.0},
    {2613072 / 12288897.0, 8788810 / 12288897.0, 887015 / 12288897.0},
    {1425312 / 80288307.0, 8788810 / 80288307.0, 70074185 / 80288307.0}};

/* The inverse. */
static const double to_rgb[3][3] = {
    {1219569 / 395920.0, -608687 / 395920.0, -214962 / 395920.0},
    {-80960619 / 87888100.0, 164871922 / 87888100.0, 3976797 / 87888100.0},
    {93813 / 1774030.0, -361922 / 1774030.0, 2042139 / 1774030.0}};

static inline double clamp_unit(double value)
{
    return value > 0 ? value < 1 ? value : 1 : 0;
}

static inline double dot(const double row[3], const double v[3])
{
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
}

void pen_flip_opponents(const double rgb[3], double out[3])
{
    const double v[3] = {clamp_unit(rgb[0]), clamp_unit(rgb[1]), clamp_unit(rgb[2])};
    const double y = dot(to_xyz[1], v);
    out[0] = y;
    out[1] = dot(to_xyz[0], v) - y;
    out[2] = y - dot(to_xyz[2], v);
}

/* The cube root of a number from 0.001 to 2, within 1e-14 of it. Division of the bits by three,
 * with the exponent's bias restored, is within 3.3 %. Each step of Halley's method changes an error
 * e to 2 e^3 / 3. */
static inline double cube_root(double x)
{
    uint64_t bits;
    double root;
    memcpy(&bits, &x, sizeof bits);
    bits = bits / 3 + UINT64_C(0x2A9F7893782DA1CE);
    memcpy(&root, &bits, sizeof root);
    for (int step = 0; step < 2; step++) {
        const double cube = root * root * root;
        root *= (cube + 2 * x) / (2 * cube + x);
    }
    return root;
}

/* The function of L*a*b* (CIE 15): a cube root, and a line where that would be too steep. */
static inline double lightness(double t)
{
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? cube_root(t) : t / (3 * delta * delta) + 4.0 / 29;
}

/* X, Y and Z of a colour as adjusted L*a*b*. */
static void adjusted_lab(const double xyz[3], double out[3])
{
    const double x = lightness(xyz[0]), y = lightness(xyz[1]), z = lightness(xyz[2]);
    const double l = 116 * y - 16;
    out[0] = l;
    out[1] = 0.01 * l * (500 * (x - y));
    out[2] = 0.01 * l * (200 * (y - z));
}

static void lab_of_rgb(const double rgb[3], double out[3])
{
    const double xyz[3] = {dot(to_xyz[0], rgb), dot(to_xyz[1], rgb), dot(to_xyz[2], rgb)};
    adjusted_lab(xyz, out);
}

void pen_flip_lab(const double opponents[3], double out[3])
{
    const double y = opponents[0], xyz[3] = {y + opponents[1], y, y - opponents[2]};
    const double rgb[3] = {clamp_unit(dot(to_rgb[0], xyz)), clamp_unit(dot(to_rgb[1], xyz)),
                           clamp_unit(dot(to_rgb[2], xyz))};
    lab_of_rgb(rgb, out);
}

/* HyAB: the difference of lightness plus the distance in the plane of a* and b*, raised to the
 * power q_c = 0.7. */
static double distance(const double a[3], const double b[3])
{
    const double da = a[1] - b[1], db = a[2] - b[2];
    return pen_pow(fabs(a[0] - b[0]) + sqrt(da * da + db * db), 0.7);
}

double pen_flip_colour_error_max(void)
{
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double a[3], b[3];
    lab_of_rgb(green, a);
    lab_of_rgb(blue, b);
    return distance(a, b);
}

/* Errors below p_c = 0.4 of the largest are mapped to the range up to p_t = 0.95, larger errors to
 * the rest. */
double pen_flip_colour_error(const double a[3], const double b[3], double colour_error_max)
{
    const double knee = 0.4 * colour_error_max, d = distance(a, b);
    if (d < knee)
        return 0.95 / knee * d;
    const double error = 0.95 + (d - knee) / (colour_error_max - knee) * (1 - 0.95);
    return error < 1 ? error : 1;
}
