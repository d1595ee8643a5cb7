/* SPDX-License-Identifier: MIT */
/* Forecasts of renders with a target error. */
#ifndef PEN_RENDER_INTERNAL_FORECAST_ADAPTIVE_H
#define PEN_RENDER_INTERNAL_FORECAST_ADAPTIVE_H

#include "render/forecast.h"

/* What a ray takes, with all that rounds take: of processors, and by the clock if every thread has
 * one for itself. */
struct pen_forecast_ray {
    double cpu_ms, ms;
};

/* By which factor the camera rays of all rounds exceed those of the pilot, and what a ray takes.
 * Fails: as pen_forecast_make. */
bool pen_forecast_growth(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                         struct pen_estimate *growth, struct pen_forecast_ray *ray,
                         struct pen_status *st);

#endif
