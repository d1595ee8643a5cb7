/* SPDX-License-Identifier: MIT */
/* A second renderer, written independently of the first one and as simply as possible: long double,
 * every ray against every primitive, no tree, scenes read directly from JSON. A picture on which
 * the two agree is unlikely to be wrong in both. It shares no code with Penumbra.
 *
 * It refracts: at each surface it asks anew which solids hold the points just before and just
 * behind it. It has a lens and blurred secondary rays where the caller chooses the points and the
 * random numbers, samples soft lights at many points of its own, has no patterns, cuts no path off
 * but at max_depth and min_contribution, and does not check its input. */
#ifndef TESTS_SUPPORT_ORACLE_H
#define TESTS_SUPPORT_ORACLE_H

struct oracle_scene;

/* Reads a scene file for one of its views (NULL: the scene's own camera). Owns: free with
 * oracle_free. Returns NULL if the file cannot be read or has something that the oracle lacks. */
struct oracle_scene *oracle_load(const char *path, const char *view);
void oracle_free(struct oracle_scene *scene);

/* The colour through the middle of pixel (x, y) of an image of this size. Where rays are blurred,
 * that is one sample, always the same for the same pixel. */
void oracle_pixel(const struct oracle_scene *scene, int width, int height, int x, int y,
                  double rgb[3]);

/* Where a camera ray passes: the image, in pixels from its top left corner, and the lens, in
 * coordinates on the unit disk. `uniform` returns independent random numbers in [0, 1) and is
 * called with `user`; without it, the numbers are a function of x and y. */
struct oracle_camera_point {
    double x, y, lens_x, lens_y;
    double (*uniform)(void *user);
    void *user;
};

/* The colour along one camera ray. Each blurred secondary ray has one random direction, so the mean
 * of many calls approaches the mean over all directions. */
void oracle_sample(const struct oracle_scene *scene, int width, int height,
                   const struct oracle_camera_point *at, double rgb[3]);

#endif
