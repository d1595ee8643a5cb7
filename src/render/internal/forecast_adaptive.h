/* SPDX-License-Identifier: MIT */
/* Forecasts of renders with a target error. */
#ifndef PEN_RENDER_INTERNAL_FORECAST_ADAPTIVE_H
#define PEN_RENDER_INTERNAL_FORECAST_ADAPTIVE_H

#include "render/forecast.h"

static inline struct pen_estimate pen_estimate_scaled(struct pen_estimate e, double times)
{
    return (struct pen_estimate){e.expected * times, e.low * times, e.high * times};
}

/* Extends a forecast of the pilot to all rounds if there is a target error.
 * Fails: as pen_forecast_make. */
bool pen_forecast_add_rounds(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                             struct pen_forecast *out, struct pen_status *st);

#endif
