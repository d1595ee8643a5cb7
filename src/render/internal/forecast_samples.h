/* SPDX-License-Identifier: MIT */
/* The numbers of samples of a pre-render with a deadline. A pixel may have a thousand million
 * samples and is not interrupted. So its rays are limited beforehand, by fewer samples. Camera rays
 * are reduced first, because the rays of a picture are proportional to them. */
#ifndef PEN_RENDER_INTERNAL_FORECAST_SAMPLES_H
#define PEN_RENDER_INTERNAL_FORECAST_SAMPLES_H

#include "scene/scene.h"

/* The divisors of the numbers of samples; 1: as in the settings. */
struct pen_forecast_samples {
    double camera, light, blur;
};

/* Lowers the numbers of samples in *settings, which have no target error, so that a pixel traces at
 * most `rays` rays. They stay at 2 camera rays, 16 points on a light and 16 rays of a cone, or at
 * their own number if that is smaller. Mirrors and glass are not counted, because only tracing
 * shows their rays. */
struct pen_forecast_samples pen_forecast_samples_cut(const struct pen_scene *scene, int view,
                                                     double rays, struct pen_settings *settings);

/* The rays of a pixel of kind 1 (shadow), 2 (reflection) or 3 (transmission). The count assumes
 * that paths do not fork and meet a surface that sends such rays at every depth. 0 if the scene has
 * no such surface. */
double pen_forecast_path_rays(const struct pen_scene *scene, int view,
                              const struct pen_settings *settings, int kind);

#endif
