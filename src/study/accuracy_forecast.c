/* SPDX-License-Identifier: MIT */
/* The forecast of an accuracy study, and the rows that it leaves out. */
#include <stdio.h>

#include "render/forecast.h"
#include "study/internal/accuracy_run.h"

/* The forecast of one run of a row, and the time that it took to make. */
struct row_forecast {
    struct pen_estimate ms;
    double spent_ms;
};

static bool forecast_row(struct pen_accuracy_state *state, int row, struct row_forecast *out,
                         struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    const struct pen_forecast_task forecast_task = {.scene = state->scene,
                                                    .view = task->view,
                                                    .settings = &task->rows[row].settings,
                                                    .quick = true,
                                                    .cancel = task->frame.cancel,
                                                    .pixel_begins = task->frame.pixel_begins,
                                                    .pixel_user = task->frame.pixel_user};
    struct pen_forecast forecast;
    if (!pen_forecast_make(task->frame.pool, &forecast_task, &forecast, st))
        return false;
    *out = (struct row_forecast){forecast.time_ms, forecast.spent_ms};
    pen_forecast_release(&forecast);
    return true;
}

/* The rays of a row, from its counts of samples. For a row with a target error, those of its pilot.
 */
static double work_of(const struct pen_accuracy_task *task, int row)
{
    const struct pen_settings s = pen_settings_sampling(&task->rows[row].settings);
    return pen_work_per_pixel(task->frame.desc, &s);
}

/* Sorts the rows by their work, the least first. */
static void order_by_work(const struct pen_accuracy_task *task, int *order)
{
    for (int i = 0; i < task->row_count; i++) {
        int at = i;
        for (; at > 0 && work_of(task, order[at - 1]) > work_of(task, i); at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

/* Scales the forecast of one row to a row that has `times` as much work. */
static struct row_forecast scaled(const struct row_forecast *forecast, double times)
{
    return (struct row_forecast){
        {forecast->ms.expected * times, forecast->ms.low * times, forecast->ms.high * times},
        forecast->spent_ms * times};
}

static void add_forecast(struct pen_accuracy_forecast *sum, const struct pen_estimate *ms,
                         int times)
{
    sum->expected_ms += times * ms->expected;
    sum->low_ms += times * ms->low;
    sum->high_ms += times * ms->high;
}

/* Forecasts all rows, by rising work. If the forecast of a row would take more than a tenth of the
 * budget, the forecast of the row before is scaled by work instead. The time of the reference is
 * PEN_ACCURACY_REFERENCE_RUNS times that of the most expensive row. */
static bool make_forecast(struct pen_accuracy_state *state, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    struct row_forecast last = {{0, 0, 0}, 0}, dearest = last;
    int order[PEN_ACCURACY_ROWS_MAX];
    order_by_work(task, order);
    for (int i = 0; i < task->row_count; i++) {
        const int row = order[i];
        struct row_forecast here =
            i > 0 ? scaled(&last, work_of(task, row) / work_of(task, order[i - 1])) : last;
        if (here.spent_ms <= task->budget_ms / 10 && !forecast_row(state, row, &here, st))
            return false;
        state->out->row[row].expected_ms = here.ms.expected;
        add_forecast(&state->out->forecast, &here.ms, task->seeds);
        if (here.ms.expected > dearest.ms.expected)
            dearest = here;
        last = here;
    }
    add_forecast(&state->out->forecast, &dearest.ms, PEN_ACCURACY_REFERENCE_RUNS);
    if (task->forecast)
        task->forecast(task->frame.user, &state->out->forecast);
    return true;
}

/* Leaves out the most expensive rows until the others fit the budget. They fit if one run of each
 * leaves enough time for the reference. It is expected to take as long as two runs of the most
 * expensive row, and may use half of the remaining time. One row always stays. */
static bool choose_rows(struct pen_accuracy_state *state, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    struct pen_accuracy_row_result *rows = state->out->row;
    for (int i = 0; i < task->row_count; i++)
        rows[i].wanted = true;
    for (int left = task->row_count; left > 1; left--) {
        double sum = 0;
        int dearest = -1;
        for (int i = 0; i < task->row_count; i++) {
            if (!rows[i].wanted)
                continue;
            sum += rows[i].expected_ms;
            if (dearest < 0 || rows[i].expected_ms > rows[dearest].expected_ms)
                dearest = i;
        }
        if (sum + 4 * rows[dearest].expected_ms <= pen_accuracy_left_ms(state))
            return true;
        char why[80];
        snprintf(why, sizeof why, "one run is expected to take %.3g s",
                 rows[dearest].expected_ms / 1000);
        rows[dearest].wanted = false;
        if (!pen_accuracy_leave_out(state, dearest, why, st))
            return false;
    }
    return true;
}

bool pen_accuracy_plan(struct pen_accuracy_state *state, struct pen_status *st)
{
    return make_forecast(state, st) && choose_rows(state, st);
}
