/* SPDX-License-Identifier: MIT */
/* Render settings: the `render` object of a scene or a job. Names, defaults and ranges are those
 * of api/scene-format.md; the reader in room io applies the precedence of several such objects. */
#ifndef PEN_SCENE_SETTINGS_H
#define PEN_SCENE_SETTINGS_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#include "accel/accel.h"

enum pen_transfer_name { PEN_SETTING_SRGB, PEN_SETTING_LINEAR, PEN_SETTING_DISPLAY };
enum pen_light_pattern { PEN_PATTERN_SOBOL, PEN_PATTERN_GRID, PEN_PATTERN_RANDOM };
enum pen_precision { PEN_PRECISION_ROBUST, PEN_PRECISION_FAST };

struct pen_settings {
    int width, height;     /* pixels */
    int samples_per_pixel; /* 1: the pixel's centre */
    int light_samples;     /* shadow rays per soft light and shaded point */
    int light_pattern;     /* enum pen_light_pattern */
    int blur_samples, lens_samples, max_samples;
    int max_depth;           /* a path shades at most this many surfaces */
    double min_contribution; /* weight below which a secondary ray is not traced */
    double target_error;     /* of the picture, see render/adaptive.h; 0: fixed sample counts */
    int precision;           /* enum pen_precision */
    int accelerator;         /* enum pen_accelerator */
    int transfer;            /* enum pen_transfer_name */
    uint64_t seed;
    int tile;    /* tile edge, pixels */
    int threads; /* threads of the pool that may work on the render; 0: all */
};

/* The most surfaces that a pixel sample shades. Where a material both reflects and transmits, paths
 * fork at every surface, and a tree of them may have 2^max_depth - 1 surfaces. What lies beyond the
 * 2048th, in depth-first order, is cut off; a tree of max_depth 11 is whole. A path that does not
 * fork is never cut, so the bound is max_depth where that is larger. Where rays are blurred, each
 * of the first ones may begin such a tree. */
enum { PEN_TREE_SURFACES = 2048 };

static inline int pen_tree_surfaces_max(const struct pen_settings *settings, bool blurred)
{
    const int most =
        settings->max_depth > PEN_TREE_SURFACES ? settings->max_depth : PEN_TREE_SURFACES;
    const int rays = blurred ? settings->blur_samples : 1;
    return rays <= INT_MAX / most ? most * rays : INT_MAX;
}

/* The samples with which every pixel begins with a target error: two, the least from which an error
 * can be told, or four with a target below 0.01. A finer picture is to miss fewer of the things
 * that are smaller than a pixel; for a coarse one, two samples more would take as long as all the
 * rest. A power of two. */
uint32_t pen_settings_pilot(const struct pen_settings *settings);

/* The target of a render that has only a time: out of reach. */
#define PEN_TARGET_NONE 1e-9

/* Whether the settings ask for a target error instead of numbers of samples. */
static inline bool pen_settings_adaptive(const struct pen_settings *settings)
{
    return settings->target_error > 0;
}

/* The settings with the numbers of samples that are in force: with a target error, those with which
 * each pixel begins; points on lights and rays of cones are for each camera ray. The result has no
 * target error. */
struct pen_settings pen_settings_sampling(const struct pen_settings *settings);

/* Presets: sets of settings. */
enum pen_quality { PEN_QUALITY_DRAFT, PEN_QUALITY_GOOD, PEN_QUALITY_FINAL, PEN_QUALITY_REFERENCE };
void pen_settings_set_quality(struct pen_settings *settings, enum pen_quality quality);

/* The defaults of api/scene-format.md. */
struct pen_settings pen_settings_default(void);

/* "auto", "none", … */
const char *pen_accelerator_name(enum pen_accelerator kind);

#endif
