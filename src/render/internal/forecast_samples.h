/* SPDX-License-Identifier: MIT */
/* The numbers of samples of a pre-render that is to end by a time. A pixel may have a thousand
 * million samples, and is not interrupted: so its rays are bounded beforehand, by taking fewer
 * samples. Camera rays go first: the rays of a picture are proportional to them. */
#ifndef PEN_RENDER_INTERNAL_FORECAST_SAMPLES_H
#define PEN_RENDER_INTERNAL_FORECAST_SAMPLES_H

#include "scene/scene.h"

/* How many times fewer are taken of each; 1: as many as the settings say. */
struct pen_forecast_samples {
    double camera, light, blur;
};

/* Lowers the numbers of samples in *settings, which have no target error, so that a pixel traces at
 * most so many rays; but not below 2 camera rays, 16 points on a light and 16 rays of a cone, or
 * what they are. Mirrors and glass are not counted, which only rays tell. */
struct pen_forecast_samples pen_forecast_samples_cut(const struct pen_scene *scene, int view,
                                                     double rays, struct pen_settings *settings);

/* The rays of a pixel, of kind 1 (shadow), 2 (reflection) or 3 (transmission), whose paths do not
 * fork and meet what traces them at every depth; 0 if the scene has nothing that does. */
double pen_forecast_path_rays(const struct pen_scene *scene, int view,
                              const struct pen_settings *settings, int kind);

#endif
