/* SPDX-License-Identifier: MIT */
/* A second renderer, written independently of the first one and as simply as possible: long double,
 * every ray against every primitive, no tree, scenes read directly from JSON. A picture on which
 * the two agree is unlikely to be wrong in both. It shares no code with Penumbra.
 *
 * It has straight transmission, and a lens where the caller chooses its points, samples soft lights
 * at many points of its own, and does not check its input. */
#ifndef TESTS_SUPPORT_ORACLE_H
#define TESTS_SUPPORT_ORACLE_H

struct oracle_scene;

/* Reads a scene file for one of its views (NULL: the scene's own camera). Owns: free with
 * oracle_free. Returns NULL if the file cannot be read or has something that the oracle lacks. */
struct oracle_scene *oracle_load(const char *path, const char *view);
void oracle_free(struct oracle_scene *scene);

/* The colour through the middle of pixel (x, y) of an image of this size. */
void oracle_pixel(const struct oracle_scene *scene, int width, int height, int x, int y,
                  double rgb[3]);

/* Where a camera ray passes: the image, in pixels from its top left corner, and the lens, in
 * coordinates on the unit disk. */
struct oracle_camera_point {
    double x, y, lens_x, lens_y;
};

/* The colour along one camera ray. */
void oracle_sample(const struct oracle_scene *scene, int width, int height,
                   const struct oracle_camera_point *at, double rgb[3]);

#endif
