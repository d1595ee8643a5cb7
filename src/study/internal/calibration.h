/* SPDX-License-Identifier: MIT */
/* A fixed computation, by whose time the times of different hosts are put into proportion. */
#ifndef PEN_STUDY_INTERNAL_CALIBRATION_H
#define PEN_STUDY_INTERNAL_CALIBRATION_H

/* Intersects fixed rays with fixed spheres on the calling thread, in plain C and double precision:
 * always the same work, some milliseconds. It tells how fast a processor computes what a ray tracer
 * computes; of caches, memory and the number of cores it tells nothing. Returns the time it took.
 * Units: ms. */
double pen_calibration_run(void);

#endif
