/* SPDX-License-Identifier: MIT */
/* Forecasts of renders with a target error. */
#ifndef PEN_RENDER_INTERNAL_FORECAST_ADAPTIVE_H
#define PEN_RENDER_INTERNAL_FORECAST_ADAPTIVE_H

#include "render/forecast.h"

/* By which factor the camera rays of all rounds exceed those of the pilot, and the milliseconds by
 * the clock that a ray takes with all that rounds take. Fails: as pen_forecast_make.
 */
bool pen_forecast_growth(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                         struct pen_estimate *growth, double *ray_ms, struct pen_status *st);

#endif
