/* SPDX-License-Identifier: MIT */
/* Small and bright things, and the beams that may meet them. A pixel's beam is the set of all its
 * possible samples: the points of the pixel, with a lens each with a point of the lens.
 *
 * A thing is something that samples of a whole beam miss. It is a primitive whose own light is well
 * above white, a small primitive that is no facet of a surface, or an image of these or of a light
 * in a surface. Four samples miss a thing that covers a tenth of a pixel two times in three, and
 * then all four agree: no variance is no evidence. But the place of a thing is known, by the bounds
 * of its projection. A beam is proven to have no thing in it if
 *  - it meets no bounds, or
 *  - one convex, opaque primitive in front of them fills the beam, or fills the bounds.
 * In all other beams
 *  - half the samples are drawn from the bounds of the beam's things, the same number for each
 *    thing. A sample counts by the inverse of the density with which it was drawn (Veach and
 *    Guibas, SIGGRAPH 95, the balance heuristic). So their weighted mean is that of the beam.
 *  - a thing remains unseen with a share of at most about 1 / n of its bounds, where n samples of
 *    these were taken: pen_beam_unseen.
 * For small things this is done only if the first samples agree. Beams with many small things are
 * textures, which pixels and their neighbours show. If a mirror is blurred, or an image is not
 * computed, samples do not look for it, but the light that they may have missed counts.
 *
 * Large features are seen by neighbours, which differ from a pixel whose samples miss the feature:
 * unseen_edge in decide.c. Small shadows are not detected. */
#ifndef PEN_RENDER_INTERNAL_BEAMS_H
#define PEN_RENDER_INTERNAL_BEAMS_H

#include "base/thread_pool.h"
#include "shade/kernel.h"

struct pen_beams;

/* Finds the things that the beams of a picture may meet; *beams is NULL if there are none. *beams
 * borrows nothing.
 * Owns: free with pen_beams_free.
 * Fails: PEN_NO_MEMORY. */
bool pen_beams_new(const struct pen_kernel_input *input, struct pen_thread_pool *pool,
                   struct pen_beams **beams, struct pen_status *st);
void pen_beams_free(struct pen_beams *beams);

/* The things from whose bounds the samples of a pixel's beam are drawn. */
enum pen_beam_things {
    PEN_BEAM_NONE,
    PEN_BEAM_SMALL, /* no bright ones: samples look for them if the first samples agree */
    PEN_BEAM_BRIGHT
};

/* The things of a pixel's beam. `beams` may be NULL. */
enum pen_beam_things pen_beam_things(const struct pen_beams *beams, size_t pixel);

/* Draws sample `index` of a replicate of a beam that has things. Returns its weight. */
double pen_beam_sample(const struct pen_beams *beams, const struct pen_camera_sample *sample,
                       struct pen_camera_point *at);

/* The samples of a pixel's beam. */
struct pen_beam_view {
    double samples; /* number of samples in the mean */
    double times;   /* 1 for the probable error, 4 for the possible error */
    bool looks;     /* samples look for small things, */
    bool agree;     /* or they do not yet, and they agree */
    bool same;      /* all samples so far agree */
};

/* The mean square error of a pixel's encoded values if the light that it may have missed is in it.
 */
double pen_beam_unseen(const struct pen_beams *beams, size_t pixel, const double linear[3],
                       const struct pen_beam_view *view);

#endif
