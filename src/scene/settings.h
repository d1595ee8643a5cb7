/* SPDX-License-Identifier: MIT */
/* Render settings: the `render` object of a scene or a job. Names, defaults and ranges are those of
 * api/scene-format.md. The reader in module io applies the precedence of several such objects. */
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

/* The most surfaces that a pixel sample shades. If a material both reflects and transmits, paths
 * fork at every surface, and a tree of paths may have 2^max_depth - 1 surfaces. Surfaces beyond the
 * 2048th, in depth-first order, are cut off; a tree of max_depth 11 is whole. A path that does not
 * fork is never cut, so the bound is max_depth if that is larger. If rays are blurred, each of the
 * first rays may begin such a tree. */
enum { PEN_TREE_SURFACES = 2048 };

static inline int pen_tree_surfaces_max(const struct pen_settings *settings, bool blurred)
{
    const int most =
        settings->max_depth > PEN_TREE_SURFACES ? settings->max_depth : PEN_TREE_SURFACES;
    const int rays = blurred ? settings->blur_samples : 1;
    return rays <= INT_MAX / most ? most * rays : INT_MAX;
}

/* The samples with which every pixel begins when there is a target error, a power of two. Two is
 * the least number that gives an error estimate; with a target below 0.01 it is four. Four samples
 * miss fewer details that are smaller than a pixel. For a coarse picture, two more samples would
 * take as long as the rest of the render. */
uint32_t pen_settings_pilot(const struct pen_settings *settings);

/* The target of a render that has only a deadline: it cannot be reached. */
#define PEN_TARGET_NONE 1e-9

/* Whether the settings request a target error instead of numbers of samples. */
static inline bool pen_settings_adaptive(const struct pen_settings *settings)
{
    return settings->target_error > 0;
}

/* The settings with the effective numbers of samples; with a target error, those with which each
 * pixel begins. Points on lights and rays of cones are per camera ray. The result has no target
 * error. */
struct pen_settings pen_settings_sampling(const struct pen_settings *settings);

/* Presets: sets of settings. */
enum pen_quality { PEN_QUALITY_DRAFT, PEN_QUALITY_GOOD, PEN_QUALITY_FINAL, PEN_QUALITY_REFERENCE };
void pen_settings_set_quality(struct pen_settings *settings, enum pen_quality quality);

/* The defaults of api/scene-format.md. */
struct pen_settings pen_settings_default(void);

/* The accelerator's name: "auto", "none", … */
const char *pen_accelerator_name(enum pen_accelerator kind);

#endif
