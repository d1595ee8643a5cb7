/* SPDX-License-Identifier: MIT */
/* The scenes of scenes/ and tests/golden/scenes/, and their frames by a given kernel. */
#ifndef TESTS_SUPPORT_SCENE_FILES_H
#define TESTS_SUPPORT_SCENE_FILES_H

#include "scene/scene.h"
#include "shade/kernel.h"

/* Returns true if a proof tries everything, as `make effects-proof` does (PEN_PROOF=full in the
 * environment). Otherwise it is one of many tests and tries a part. */
bool proof_in_full(void);

/* Calls `each` with a scene, or with every scene of tests/golden/scenes and, if asked for, of
 * scenes; it may change the description. Returns the number of scenes. A file that is no scene ends
 * the process. */
typedef void scene_file_fn(const char *path, struct pen_scene_desc *desc, void *user);
void scene_file_with(const char *path, scene_file_fn *each, void *user);
int scene_files_each(bool built_in, scene_file_fn *each, void *user);

/* Makes pictures at most `width` pixels wide and as much lower, with few samples. */
void scene_file_shrink(struct pen_settings *settings, int width);

/* Freezes a description. Ends the process if that fails. */
struct pen_scene *scene_file_freeze(const char *path, const struct pen_scene_desc *desc);

/* Makes the input that the renderer gives a kernel. */
struct pen_kernel_input frame_input(const struct pen_scene *scene, int view,
                                    const struct pen_settings *settings, enum pen_isa isa);

/* The whole frame, 3 doubles per pixel, by the block kernel or by the pixel kernel; free() it. */
double *frame_by_blocks(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                        struct pen_ray_counts *rays);
double *frame_by_pixels(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                        struct pen_ray_counts *rays);

#endif
