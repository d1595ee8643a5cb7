/* SPDX-License-Identifier: MIT */
/* The limits on pixels and work, which depend on how a scene is rendered and on counts alone. */
#include "io/scene_json.h"

#include <math.h>

struct pen_limits pen_limits_default(void)
{
    return (struct pen_limits){.body_bytes = (size_t)16 << 20,
                               .parsed_bytes = (size_t)384 << 20,
                               .nesting = 64,
                               .objects = 1000000,
                               .pixels_per_view = 64000000,
                               .views = 64,
                               .work = 1e13};
}

/* The most shadow rays to one light per shaded point. */
static double shadow_rays(const struct pen_light_desc *light, const struct pen_settings *settings)
{
    if (!light->shadows)
        return 0;
    if (!pen_light_desc_soft(light))
        return 1;
    double edge = ceil(sqrt(settings->light_samples)); /* cells along an edge of the grid */
    return settings->light_pattern == PEN_PATTERN_GRID ? edge * edge : settings->light_samples;
}

double pen_work_per_pixel(const struct pen_scene_desc *desc, const struct pen_settings *settings)
{
    double samples = settings->samples_per_pixel, shadows = 0;
    bool lens = false;
    for (uint32_t i = 0; i < desc->view_count; i++)
        lens |= desc->views[i].camera.aperture_radius > 0;
    if (lens && settings->lens_samples > samples)
        samples = settings->lens_samples;
    if (settings->target_error > 0 && settings->max_samples > samples)
        samples = settings->max_samples;
    for (uint32_t i = 0; i < desc->light_count; i++)
        shadows += shadow_rays(&desc->lights[i], settings);
    return samples * (1 + shadows);
}

bool pen_limits_check(const struct pen_limits *limits, const struct pen_scene_desc *desc,
                      const struct pen_settings *settings, uint32_t views, const char *at,
                      struct pen_status *st)
{
    double pixels = (double)settings->width * settings->height;
    double work = views * pixels * pen_work_per_pixel(desc, settings);
    if (pixels > (double)limits->pixels_per_view)
        return pen_fail_at(
            st, PEN_TOO_LARGE, at, "%d x %d are %.0f pixels in a view, at most %llu are allowed",
            settings->width, settings->height, pixels, (unsigned long long)limits->pixels_per_view);
    if (work > limits->work)
        return pen_fail_at(st, PEN_TOO_LARGE, at,
                           "%u view%s of %d x %d pixels with these samples and lights take up to "
                           "%.3g primary and shadow rays, at most %.3g are allowed",
                           views, views == 1 ? "" : "s", settings->width, settings->height, work,
                           limits->work);
    return true;
}
