/* SPDX-License-Identifier: MIT */
/* The defaults of render settings and materials, from the tables of api/scene-format.md. */
#include "scene/settings.h"
#include "scene/desc.h"

struct pen_settings pen_settings_default(void)
{
    return (struct pen_settings){
        .width = 800,
        .height = 600,
        .samples_per_pixel = 1,
        .light_samples = 16,
        .light_pattern = PEN_PATTERN_SOBOL,
        .blur_samples = 16,
        .lens_samples = 16,
        .max_samples = 4096,
        .max_depth = 10,
        .min_contribution = 0.001,
        .target_error = 0,
        .precision = PEN_PRECISION_ROBUST,
        .accelerator = PEN_ACCEL_AUTO,
        .transfer = PEN_SETTING_SRGB,
        .seed = 0,
        .tile = 32,
        .threads = 0,
    };
}

void pen_settings_set_quality(struct pen_settings *s, enum pen_quality quality)
{
    static const double targets[] = {[PEN_QUALITY_DRAFT] = 0,
                                     [PEN_QUALITY_GOOD] = 0.02,
                                     [PEN_QUALITY_FINAL] = 0.005,
                                     [PEN_QUALITY_REFERENCE] = 0.001};
    s->target_error = targets[quality];
    s->light_pattern = PEN_PATTERN_SOBOL;
    if (quality == PEN_QUALITY_DRAFT) {
        s->samples_per_pixel = 1;
        s->light_samples = s->blur_samples = s->lens_samples = 4;
    }
    if (quality == PEN_QUALITY_REFERENCE) {
        s->max_samples = 65536;
        s->min_contribution = 0.0001;
    }
}

/* With a target error: points on each light, and rays of each cone, per camera ray. All points of a
 * pixel are one sequence. If a light is partly hidden, 16 shadow rays take about a tenth to a half
 * of the time of the rest of a path (accel/disk_packet.h). A blurred ray takes as long as a path.
 */
enum { ADAPTIVE_LIGHT_SAMPLES = 16, ADAPTIVE_BLUR_SAMPLES = 4 };

uint32_t pen_settings_pilot(const struct pen_settings *settings)
{
    static const double fine = 0.01;
    return settings->target_error < fine ? 4 : 2;
}

struct pen_settings pen_settings_sampling(const struct pen_settings *settings)
{
    struct pen_settings s = *settings;
    if (!pen_settings_adaptive(settings))
        return s;
    s.target_error = 0;
    s.samples_per_pixel = s.lens_samples = (int)pen_settings_pilot(settings);
    s.light_samples = ADAPTIVE_LIGHT_SAMPLES;
    s.blur_samples = ADAPTIVE_BLUR_SAMPLES;
    return s;
}

struct pen_material pen_material_default(void)
{
    return (struct pen_material){
        .ka = {1, 1, 1},
        .shininess = 1,
        .ior = 1,
    };
}

const char *pen_accelerator_name(enum pen_accelerator kind)
{
    switch (kind) {
    case PEN_ACCEL_AUTO:
        return "auto";
    case PEN_ACCEL_NONE:
        return "none";
    case PEN_ACCEL_CBR:
        return "cbr";
    case PEN_ACCEL_MANUAL:
        return "manual";
    case PEN_ACCEL_MEDIAN:
        return "median";
    }
    return "unknown";
}
