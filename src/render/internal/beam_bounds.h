/* SPDX-License-Identifier: MIT */
/* The bounds of things in the beams of pixels: beams.c finds them, beam_samples.c draws from them.
 */
#ifndef PEN_RENDER_INTERNAL_BEAM_BOUNDS_H
#define PEN_RENDER_INTERNAL_BEAM_BOUNDS_H

#include "math/scale.h"
#include "render/internal/beams.h"
#include "render/internal/projection.h"
#include "render/transfer.h"

/* The smaller of two numbers, none of which is NaN. */
static inline double pen_smaller(double a, double b)
{
    return a < b ? a : b;
}

#define PEN_BEAM_PI 3.14159265358979323846

/* The part of a beam's samples that is drawn from the bounds of things. */
#define PEN_BEAM_PART 0.5

/* Bounds of a thing in one beam. With a lens: a rectangle, which moves with the point of the lens,
 * and the part of the lens from which it can be in the pixel. */
struct bounds {
    size_t pixel;
    struct pen_point2 corner, a, b; /* of a parallelogram, from the pixel's corner on: its edges */
    struct pen_shear shear;
    struct pen_point2 lens_lo, lens_hi;
    double share; /* of the beam */
    float light[3];
    float most; /* above 0: seen in a blurred mirror, by at most this part of its rays */
    bool small;
};

/* The things of a beam. */
struct met {
    float blurred[3],
        most[3];           /* of bright ones in a blurred mirror: 1 / n of it, but at most `most` */
    float light[3], share; /* of bright ones: with n samples 1 / n of the sums is unseen */
    float small_light[3], small_share; /* of small ones, as their bounds have them */
};

struct pen_beams {
    int width, height;
    bool lens, any;
    uint64_t seed;
    enum pen_transfer transfer;
    struct met *met;       /* by pixel */
    struct bounds *bounds; /* sorted by pixel */
    size_t count, room;
    uint32_t *first; /* bounds of pixel i are first[i] to first[i + 1] - 1 */
};

#endif
