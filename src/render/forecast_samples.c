/* SPDX-License-Identifier: MIT */
#include "render/internal/forecast_samples.h"

#include <math.h>

enum { CAMERA_LEAST = 2, LIGHT_LEAST = 16, BLUR_LEAST = 16 };

/* A pixel's camera rays, each with the rays of a cone. */
static double paths_of(const struct pen_scene *scene, int view, const struct pen_settings *s)
{
    const bool lens = scene->views[view].camera.aperture_radius > 0;
    const bool blurred = pen_effects_blur(pen_scene_effects(scene, view, s));
    return (double)pen_camera_samples(lens, s) * (blurred ? s->blur_samples : 1);
}

/* The same, plus the shadow rays from their hits. */
static double work_of(const struct pen_scene *scene, int view, const struct pen_settings *s)
{
    double each = 1;
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].shadows)
            each += scene->lights[i].soft ? s->light_samples : 1;
    return paths_of(scene, view, s) * each;
}

/* Divides a number of samples by at most `excess`. Returns the divisor used. */
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

double pen_forecast_path_rays(const struct pen_scene *scene, int view,
                              const struct pen_settings *settings, int kind)
{
    static const unsigned traced_for[] = {0, PEN_FX_HARD_SHADOWS | PEN_FX_SOFT_SHADOWS,
                                          PEN_FX_MIRROR | PEN_FX_GLOSSY |
                                              PEN_FX_REFRACTION, /* glass reflects, too */
                                          PEN_FX_TRANSMISSION | PEN_FX_REFRACTION | PEN_FX_FROSTED};
    const double paths = paths_of(scene, view, settings), depth = settings->max_depth;
    if (!(pen_scene_effects(scene, view, settings) & traced_for[kind]))
        return 0;
    return kind == 1 ? depth * (work_of(scene, view, settings) - paths) : (depth - 1) * paths;
}
