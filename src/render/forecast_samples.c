/* SPDX-License-Identifier: MIT */
#include "render/internal/forecast_samples.h"

#include <math.h>

enum { CAMERA_LEAST = 2, LIGHT_LEAST = 16, BLUR_LEAST = 16 };

/* A pixel's camera rays, the rays of cones, and the shadow rays from what they hit. */
static double work_of(const struct pen_scene *scene, int view, const struct pen_settings *s)
{
    const bool lens = scene->views[view].camera.aperture_radius > 0;
    const bool blurred = pen_effects_blur(pen_scene_effects(scene, view, s));
    double each = 1;
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].shadows)
            each += scene->lights[i].soft ? s->light_samples : 1;
    return (double)pen_camera_samples(lens, s) * each * (blurred ? s->blur_samples : 1);
}

/* Divides a number of samples by at most `excess`. Returns by what it did. */
static double cut(int *samples, int least, double excess)
{
    const int all = *samples;
    const double wanted = ceil(all / excess);
    if (excess <= 1 || all <= least)
        return 1;
    *samples = wanted > least ? (int)wanted : least;
    return (double)all / *samples;
}

struct pen_forecast_samples pen_forecast_samples_cut(const struct pen_scene *scene, int view,
                                                     double rays, struct pen_settings *s)
{
    struct pen_forecast_samples times = {1, 1, 1};
    const unsigned effects = pen_scene_effects(scene, view, s);
    int camera = pen_camera_samples(scene->views[view].camera.aperture_radius > 0, s);
    times.camera = cut(&camera, CAMERA_LEAST, work_of(scene, view, s) / rays);
    if (times.camera > 1)
        s->samples_per_pixel = s->lens_samples = camera;
    if (effects & PEN_FX_SOFT_SHADOWS)
        times.light = cut(&s->light_samples, LIGHT_LEAST, work_of(scene, view, s) / rays);
    if (pen_effects_blur(effects))
        times.blur = cut(&s->blur_samples, BLUR_LEAST, work_of(scene, view, s) / rays);
    return times;
}
