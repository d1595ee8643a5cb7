/* SPDX-License-Identifier: MIT */
/* Small and bright things, and the beams that may meet them. A beam is all that a pixel's samples
 * can be: the points of the pixel, with a lens each with a point of the lens.
 *
 * A thing is a primitive whose own light is well above white, a small one that is no facet of a
 * surface, or an image of
 * these or of a light in a surface: what samples of a whole beam miss. Four samples miss what
 * covers a tenth of a pixel two times in three, and then all agree: no variance is no evidence. But
 * where it is is known: bounds of its projection. A beam is proven to have no thing in it if
 *  - it meets no bounds, or
 *  - one convex, opaque primitive that is in front of them fills it, or fills the bounds.
 * In all others
 *  - half the samples are drawn from the bounds of the beam's things, each thing the same number.
 *    A sample counts by the inverse of the density with which it was drawn (Veach and Guibas,
 *    SIGGRAPH 95, the balance heuristic): so their weighted mean is that of the beam.
 *  - it remains unseen with a share of at most about 1 / n of its bounds, where n samples of these
 *    were taken: pen_beam_unseen.
 * For small things this is done only where the first samples agree. Beams with many small things
 * are textures, which pixels and their neighbours tell. Where a mirror is blurred, or an image is
 * not computed, samples do not look for it, but what they may not have seen counts.
 *
 * What is large is told by neighbours, which do not agree with a pixel whose samples miss it:
 * unseen_edge in decide.c. Small shadows are not known. */
#ifndef PEN_RENDER_INTERNAL_BEAMS_H
#define PEN_RENDER_INTERNAL_BEAMS_H

#include "base/thread_pool.h"
#include "shade/kernel.h"

struct pen_beams;

/* The things that the beams of a picture may meet: *beams is NULL if none does. It borrows nothing.
 * Owns: free with pen_beams_free. Fails: PEN_NO_MEMORY. */
bool pen_beams_new(const struct pen_kernel_input *input, struct pen_thread_pool *pool,
                   struct pen_beams **beams, struct pen_status *st);
void pen_beams_free(struct pen_beams *beams);

/* The things whose bounds samples of a pixel's beam are drawn from. */
enum pen_beam_things {
    PEN_BEAM_NONE,
    PEN_BEAM_SMALL, /* no bright ones: samples look for them if the first ones agree */
    PEN_BEAM_BRIGHT
};

/* The beams may be NULL. */
enum pen_beam_things pen_beam_things(const struct pen_beams *beams, size_t pixel);

/* Sample `index` of a replicate of a beam that has things. Returns its weight. */
double pen_beam_sample(const struct pen_beams *beams, const struct pen_camera_sample *sample,
                       struct pen_camera_point *at);

/* What a pixel has seen of its beam. */
struct pen_beam_view {
    double samples; /* whose mean is known */
    double times;   /* what is asked for: 1, what is probable; 4, what is possible */
    bool looks;     /* samples look for small things, */
    bool agree;     /* or they do not yet, and agree */
    bool same;      /* all samples so far agree */
};

/* The mean square error of a pixel's encoded values, if what it may not have seen is in it. */
double pen_beam_unseen(const struct pen_beams *beams, size_t pixel, const double linear[3],
                       const struct pen_beam_view *view);

#endif
