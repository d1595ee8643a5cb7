/* SPDX-License-Identifier: MIT */
/* SSIM: the structural similarity of two pictures. It uses the luma 0.2126 R + 0.7152 G + 0.0722 B
 * (Rec. 709) of sRGB-encoded values in [0, 1], not quantised. It is computed in each window of 11 x
 * 11 pixels with Gaussian weights of deviation 1.5 px, with K1 = 0.01, K2 = 0.03 and L = 1. The
 * result is the mean over all windows inside the picture.
 *
 * A side shorter than 11 pixels has one window position. Its weights are cut to the side, centred
 * and normalised; its variance is then of fewer pixels. NaN counts as 0. Exchanging the pictures
 * changes no bit. Sums run in a fixed order, so the result is the same on every machine.
 *
 * Source: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to
 * Structural Similarity", IEEE Trans. Image Process. 13(4), 2004, section III. */
#ifndef PEN_FILM_SSIM_H
#define PEN_FILM_SSIM_H

#include "base/status.h"
#include "film/picture.h"

/* Computes the SSIM, always from -1 to 1; 1 if and only if the lumas are equal, up to rounding.
 * Fails: PEN_INVALID (different sizes), PEN_NO_MEMORY.
 * Cost: about 0.1 us per pixel, and 0.3 MB. */
bool pen_picture_ssim(const struct pen_picture *a, const struct pen_picture *b, double *out,
                      struct pen_status *st);

#endif
