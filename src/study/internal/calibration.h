/* SPDX-License-Identifier: MIT */
/* A fixed computation. Its time makes times of different hosts comparable. */
#ifndef PEN_STUDY_INTERNAL_CALIBRATION_H
#define PEN_STUDY_INTERNAL_CALIBRATION_H

/* Intersects fixed rays with fixed spheres, and returns the time in ms. The work is always the same
 * and takes some milliseconds. It runs on the calling thread, in plain C and double precision. It
 * measures how fast a processor does a ray tracer's arithmetic. It does not measure caches, memory
 * or the number of cores.
 * Units: ms. */
double pen_calibration_run(void);

#endif
