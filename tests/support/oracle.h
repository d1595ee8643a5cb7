/* SPDX-License-Identifier: MIT */
/* A second renderer, written independently of the first and as simply as possible: long double,
 * every ray against every primitive, no tree, scenes read directly from JSON. It shares no code
 * with Penumbra. A picture on which both agree is unlikely to be wrong in both.
 *
 * It refracts: at each surface it looks up which solids contain the points just before and just
 * behind it. For a lens and for blurred secondary rays, the caller chooses the points and the
 * random numbers. It samples soft lights at many points of its own. It has no patterns, cuts paths
 * off only at max_depth and min_contribution, and does not check its input. */
#ifndef TESTS_SUPPORT_ORACLE_H
#define TESTS_SUPPORT_ORACLE_H

struct oracle_scene;

/* Reads a scene file for one of its views (NULL: the scene's own camera). Returns NULL if the file
 * cannot be read or uses a feature that the oracle lacks.
 * Owns: free with oracle_free. */
struct oracle_scene *oracle_load(const char *path, const char *view);
void oracle_free(struct oracle_scene *scene);

/* Returns the colour through the middle of pixel (x, y) of an image of this size. If rays are
 * blurred, it is one sample, always the same for the same pixel. */
void oracle_pixel(const struct oracle_scene *scene, int width, int height, int x, int y,
                  double rgb[3]);

/* The path of a camera ray: a point of the image, in pixels from its top left corner, and a point
 * of the lens, on the unit disk. `uniform` returns independent random numbers in [0, 1) and is
 * called with `user`. Without it, the numbers are a function of x and y. */
struct oracle_camera_point {
    double x, y, lens_x, lens_y;
    double (*uniform)(void *user);
    void *user;
};

/* Returns the colour along one camera ray. Each blurred secondary ray has one random direction, so
 * the mean of many calls approaches the mean over all directions. */
void oracle_sample(const struct oracle_scene *scene, int width, int height,
                   const struct oracle_camera_point *at, double rgb[3]);

#endif
