/* SPDX-License-Identifier: MIT */
/* The limits on pixels and work, which depend only on the settings and on counts. */
#include "io/scene_json.h"

#include <math.h>

#include "scene/scene.h"

struct pen_limits pen_limits_default(void)
{
    return (struct pen_limits){.body_bytes = (size_t)16 << 20,
                               .parsed_bytes = (size_t)384 << 20,
                               .nesting = 64,
                               .objects = 1000000,
                               .pixels_per_view = 64000000,
                               .views = 64,
                               .work = 1e13,
                               .timeout_seconds = 1000000000,
                               .priority = 100};
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

/* The rays of one camera ray and of the shadow rays from its hits. */
static double work_per_sample(const struct pen_scene_desc *desc,
                              const struct pen_settings *settings)
{
    const struct pen_settings sampling = pen_settings_sampling(settings);
    double shadows = 0;
    for (uint32_t i = 0; i < desc->light_count; i++)
        shadows += shadow_rays(&desc->lights[i], &sampling);
    return 1 + shadows;
}

double pen_work_per_pixel(const struct pen_scene_desc *desc, const struct pen_settings *settings)
{
    return pen_camera_samples(pen_desc_has_lens(desc), settings) * work_per_sample(desc, settings);
}

/* The most surfaces that a path's tree has where paths fork. */
static double tree_surfaces(const struct pen_settings *settings)
{
    int most = pen_tree_surfaces_max(settings, false), tree = 1;
    for (int depth = 1; depth < settings->max_depth && tree < most; depth++)
        tree = 2 * tree + 1;
    return tree < most ? tree : most;
}

/* The largest max_depth with which such samples shade at most this number of surfaces. */
static int depth_for(double surfaces)
{
    int depth = 1;
    if (surfaces >= PEN_TREE_SURFACES)
        return (int)surfaces;
    for (double tree = 3; tree <= surfaces; tree = 2 * tree + 1)
        depth++;
    return depth;
}

/* Fails because rays are blurred. `rays` is the number without blur, which is not too large. */
static bool fail_blur(const struct pen_limits *limits, const struct pen_settings *settings,
                      double rays, double surfaces, const char *at, struct pen_status *st)
{
    return pen_fail_at(
        st, PEN_TOO_LARGE, at,
        "the views take up to %.3g rays, at most %.3g are allowed: a material blurs, "
        "so that %.3g primary and shadow rays become %.3g times as many with "
        "blur_samples %d and max_depth %d; lower these, or take fewer pixels or "
        "samples",
        rays * surfaces, limits->work, rays, surfaces, settings->blur_samples, settings->max_depth);
}

/* Fails because paths fork. `rays` is the number without forks, which is not too large. */
static bool fail_forks(const struct pen_limits *limits, const struct pen_settings *settings,
                       double rays, const char *at, struct pen_status *st)
{
    double surfaces = tree_surfaces(settings);
    return pen_fail_at(
        st, PEN_TOO_LARGE, at,
        "the views take up to %.3g rays, at most %.3g are allowed: a material has both kr and "
        "kt, or refracts, so that paths fork, and %.3g primary and shadow rays become %.0f times "
        "as many with max_depth %d; lower it to %d, or take fewer pixels or samples",
        rays * surfaces, limits->work, rays, surfaces, settings->max_depth,
        depth_for(limits->work / rays));
}

/* Refuses settings that exclude each other. */
static bool check_together(const struct pen_settings *settings, const char *at,
                           struct pen_status *st)
{
    const int pilot = (int)pen_settings_pilot(settings);
    if (!pen_settings_adaptive(settings))
        return true;
    if (settings->light_pattern == PEN_PATTERN_GRID)
        return pen_fail_at(st, PEN_INVALID, at,
                           "light_pattern is \"grid\", whose points cannot be continued as "
                           "target_error asks; allowed with it are \"sobol\" and \"random\"");
    if (settings->max_samples < pilot)
        return pen_fail_at(
            st, PEN_INVALID, at,
            "max_samples is %d; allowed with this target_error is %d or more, with which "
            "each pixel begins",
            settings->max_samples, pilot);
    return true;
}

bool pen_limits_check_time(const struct pen_limits *limits, double rays, const char *at,
                           struct pen_status *st)
{
    if (limits->seconds <= 0 || rays <= limits->seconds * limits->rays_per_second)
        return true;
    const double seconds = rays / limits->rays_per_second;
    return pen_fail_at(
        st, PEN_TOO_LARGE, at,
        "it is expected to take at least %.0f s (%.3g hours): %.3g primary and shadow "
        "rays at %.2g a second; this daemon allows %.0f s; take fewer pixels, samples "
        "or lights, or ask its operator for more (--max-seconds)",
        seconds, seconds / 3600, rays, limits->rays_per_second, limits->seconds);
}

/* Checks the number of samples of a pixel that the operator allows. */
static bool check_samples(const struct pen_limits *limits, const struct pen_settings *settings,
                          const char *at, struct pen_status *st)
{
    const bool adaptive = pen_settings_adaptive(settings);
    const int samples = adaptive ? settings->max_samples : settings->samples_per_pixel;
    return limits->samples == 0 || samples <= limits->samples ||
           pen_fail_at(st, PEN_TOO_LARGE, at, "%s is %d, this daemon allows at most %d",
                       adaptive ? "max_samples" : "samples_per_pixel", samples, limits->samples);
}

bool pen_limits_check(const struct pen_limits *limits, const struct pen_scene_desc *desc,
                      const struct pen_settings *settings, uint32_t views, const char *at,
                      struct pen_status *st)
{
    double pixels = (double)settings->width * settings->height;
    if (!check_together(settings, at, st) || !check_samples(limits, settings, at, st))
        return false;
    double rays = views * pixels * pen_work_per_pixel(desc, settings);
    if (pixels > (double)limits->pixels_per_view)
        return pen_fail_at(
            st, PEN_TOO_LARGE, at, "%d x %d are %.0f pixels in a view, at most %llu are allowed",
            settings->width, settings->height, pixels, (unsigned long long)limits->pixels_per_view);
    if (rays > limits->work)
        return pen_fail_at(st, PEN_TOO_LARGE, at,
                           "%u view%s of %d x %d pixels with these samples and lights take up to "
                           "%.3g primary and shadow rays, at most %.3g are allowed",
                           views, views == 1 ? "" : "s", settings->width, settings->height, rays,
                           limits->work);
    /* Only now the objects are read, because there may be a million. With a target error, only the
     * samples with which pixels begin count with the largest trees. If all samples did, no picture
     * could be accepted. */
    const struct pen_settings sampling = pen_settings_sampling(settings);
    const double tree = tree_surfaces(settings), blurred = sampling.blur_samples;
    rays = views * pixels * pen_work_per_pixel(desc, &sampling);
    if (!pen_limits_check_time(limits, rays, at, st))
        return false;
    if (rays * tree > limits->work && pen_desc_forks(desc))
        return fail_forks(limits, settings, rays, at, st);
    if (rays * tree * blurred > limits->work &&
        pen_effects_blur(pen_desc_effects(desc, settings))) {
        const double surfaces = (pen_desc_forks(desc) ? tree : 1) * blurred;
        if (rays * surfaces > limits->work)
            return fail_blur(limits, &sampling, rays, surfaces, at, st);
    }
    return true;
}
