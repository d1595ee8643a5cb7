/* SPDX-License-Identifier: MIT */
/* A second renderer, written apart from the first and as plainly as the pages allow: long double,
 * every ray against every primitive, no tree, no tricks, scenes read straight from JSON. What the
 * two agree on is unlikely to be wrong in both. It shares no code with Penumbra.
 *
 * It knows one sample per pixel and straight transmission, takes soft lights by many points of its
 * own choice, and trusts its input. */
#ifndef TESTS_SUPPORT_ORACLE_H
#define TESTS_SUPPORT_ORACLE_H

struct oracle_scene;

/* Reads a scene file for one of its views (NULL: the scene's own camera). Owns: free with
 * oracle_free. Returns NULL if the file cannot be read or says something not known here. */
struct oracle_scene *oracle_load(const char *path, const char *view);
void oracle_free(struct oracle_scene *scene);

/* The colour through the middle of pixel (x, y) of an image of this size. */
void oracle_pixel(const struct oracle_scene *scene, int width, int height, int x, int y,
                  double rgb[3]);

#endif
