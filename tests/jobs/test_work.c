/* SPDX-License-Identifier: MIT */
/* The work that readers see between two reports of it; jobs with a budget. */
#include <math.h>
#include <unistd.h>

#include "jobs/internal/work.h"
#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

START_TEST(test_work__follows_the_pace_and_stays_below_what_is_begun)
{
    const struct pen_work work = {.done = 0.25, .begun = 0.5, .per_ms = 0.001};
    double before = 0;
    for (int ms = 0; ms < 100000; ms += 10) {
        const double now = pen_work_after(&work, ms);
        ck_assert(now > before && now < 0.75);
        if (ms <= 250)
            ck_assert_double_eq_tol(now, 0.25 + 0.001 * ms, 1e-12);
        ck_assert(now - before <= 0.0100001 || ms == 0);
        before = now;
    }
    ck_assert(before > 0.74);
}
END_TEST

START_TEST(test_work__of_a_budget_is_the_share_of_its_time)
{
    const struct pen_work work = {.done = 0.125, .begun = INFINITY, .per_ms = 1.0 / 8000};
    for (int ms = 0; ms <= 7000; ms += 500)
        ck_assert_double_eq_tol(pen_work_after(&work, ms), 0.125 + ms / 8000.0, 1e-12);
}
END_TEST

START_TEST(test_work__without_a_pace_or_a_begin_is_what_is_known)
{
    const struct pen_work idle = {.done = 0.5, .begun = 0.25}, all = {.done = 0.5, .per_ms = 1};
    ck_assert(pen_work_after(&idle, 1000) == 0.5);
    ck_assert(pen_work_after(&all, 0) == 0.5 && pen_work_after(&all, 1000) == 0.5);
}
END_TEST

START_TEST(test_work__estimate_counts_less_the_more_is_done)
{
    ck_assert(pen_work_pace(0, 0, 0) == 0);
    ck_assert_double_eq_tol(1 / pen_work_pace(0, 0, 4000), 4000, 1e-9);
    ck_assert_double_eq_tol(1 / pen_work_pace(0.25, 2000, 0), 8000, 1e-9);
    /* It took twice as long as expected. */
    double before = 4000;
    for (double done = 0.1; done <= 1; done += 0.1) {
        const double all_ms = 1 / pen_work_pace(done, 8000 * done, 4000);
        ck_assert(all_ms > before && all_ms < 8000);
        before = all_ms;
    }
    ck_assert(before > 7500);
    ck_assert_int_eq(pen_work_estimate_ms(3000, 0.25, 1.0 / 8000), 9000);
    ck_assert_int_eq(pen_work_estimate_ms(3000, 1.25, 1.0 / 8000), 3000);
    ck_assert_int_eq(pen_work_estimate_ms(0, 1, 1), 1);
    ck_assert_int_eq(pen_work_estimate_ms(3000, 0.5, 0), 0);
}
END_TEST

/* The time left is the budget's, whatever of the picture is done by then. */
START_TEST(test_work__job_with_a_budget_tells_the_time_that_its_budget_has_left)
{
    enum { BUDGET_MS = 2000 };
    int told = 0;
    int64_t last = 0;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed,
                "{\"scene\": \"builtin:spheres\", \"budget_seconds\": 2,"
                " \"render\": {\"width\": 40, \"height\": 30}}",
                id);
    for (;;) {
        struct pen_job_record job = store_job_get(bed.bed.store, id);
        const bool ended = pen_job_state_ended(job.state);
        const double left_ms = (double)job.estimate_ms - (double)job.told_us / 1000,
                     share = (double)job.work / PEN_WORK_ALL;
        if (!ended && job.done_pixels < job.total_pixels && job.told_us > last) {
            ck_assert(share <= 1);
            /* It is rounded; a state that is kept since may have raised the share. */
            const double off_ms = left_ms - (1 - share) * BUDGET_MS;
            ck_assert(off_ms >= -2);
            last = job.told_us;
            told += off_ms <= 2;
        }
        pen_job_record_release(&job);
        if (ended)
            break;
        usleep(5000);
    }
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_SUCCEEDED);
    ck_assert_int_ge(told, 1);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("work", test_work__follows_the_pace_and_stays_below_what_is_begun,
          test_work__of_a_budget_is_the_share_of_its_time,
          test_work__without_a_pace_or_a_begin_is_what_is_known,
          test_work__estimate_counts_less_the_more_is_done,
          test_work__job_with_a_budget_tells_the_time_that_its_budget_has_left)
