/* SPDX-License-Identifier: MIT */
/* The bounds of things in the beams of pixels: beams.c finds them, beam_samples.c draws samples
 * from them. */
#ifndef PEN_RENDER_INTERNAL_BEAM_BOUNDS_H
#define PEN_RENDER_INTERNAL_BEAM_BOUNDS_H

#include "math/scale.h"
#include "render/internal/beams.h"
#include "render/internal/projection.h"
#include "render/transfer.h"

/* The smaller of two numbers; neither is NaN. */
static inline double pen_smaller(double a, double b)
{
    return a < b ? a : b;
}

#define PEN_BEAM_PI 3.14159265358979323846

/* The part of a beam's samples that is drawn from the bounds of things. */
#define PEN_BEAM_PART 0.5

/* The least shininess whose highlights are things. */
#define PEN_BEAM_NARROW 100

/* Bounds of a thing in one beam. With a lens: a rectangle that moves with the point of the lens,
 * and the part of the lens from which the thing can be in the pixel. */
struct bounds {
    size_t pixel;
    struct pen_point2 corner, a,
        b; /* a parallelogram, relative to the pixel's corner: a corner and its edges */
    struct pen_shear shear;
    struct pen_point2 lens_lo, lens_hi;
    double share; /* of the beam */
    float light[3];
    float near; /* least depth of the thing, in lengths of the pinhole's `middle` */
    float most; /* above 0: seen in a blurred mirror, by at most this share of its rays */
    bool small;
    bool deep; /* of a surface that may show things at unknown places: pen_beam_add_depths */
};

/* A thing, while its beams are found. */
struct thing {
    struct pen_hull hull;
    struct pen_shear shear;
    struct bounds bounds; /* the members that all its bounds share */
    double fall; /* above 0: its light falls from the middle of the polygon to this part of it at
                    the border, by a normal distribution */
};

/* The things of a beam. */
struct met {
    /* Bright things in a blurred mirror: 1 / n of `blurred`, but at most `most`. */
    float blurred[3], most[3];
    float light[3], share; /* bright things: with n samples, 1 / n of these sums is unseen */
    float deep[3];         /* the brightest thing that is shown at an unknown place */
    float small_light[3], small_share; /* small things, by their bounds */
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

/* Adds the light that a surface may show at an unknown place in a beam. */
static inline void pen_beam_add_depth(struct met *met, const struct bounds *b)
{
    for (int c = 0; c < 3; c++)
        met->deep[c] = met->deep[c] > b->light[c] ? met->deep[c] : b->light[c];
}

static inline double pen_beam_largest(struct pen_vec3 c)
{
    return pen_larger(c.x, pen_larger(c.y, c.z));
}

/* Whether a primitive's own light is bright enough to make it a thing at any size. */
bool pen_beam_bright(const struct pen_scene *scene, uint32_t prim);

/* An upper bound of the visible light of a primitive. */
struct pen_vec3 pen_beam_light(const struct pen_scene *scene, uint32_t prim);

/* An upper bound of a light's contribution in a box, for a reflectance of 1. */
struct pen_vec3 pen_beam_light_within(const struct pen_light *light, struct pen_box box);

/* Adds the thing to all beams that may meet it. Returns false when out of memory. */
bool pen_beam_add_thing(struct pen_beams *beams, const struct thing *thing);

/* Sets the shares of hidden bounds to 0: those that another primitive is in front of
 * (beam_hidden.c).
 * Threads: as pen_render_run. */
void pen_beam_hide(struct pen_beams *beams, const struct pen_kernel_input *input,
                   struct pen_thread_pool *pool);

/* The least depth at which a box may be seen, with a margin for rounding. */
float pen_beam_depth(const struct pen_kernel_input *input, struct pen_box box);

/* Adds the things that surfaces may show at places that are not computed (beam_depths.c). Returns
 * false when out of memory. */
bool pen_beam_add_depths(struct pen_beams *beams, const struct pen_kernel_input *input);

/* Adds the images of things in surfaces (beam_images.c). Returns false when out of memory. */
bool pen_beam_add_images(struct pen_beams *beams, const struct pen_kernel_input *input);

#endif
