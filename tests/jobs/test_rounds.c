/* SPDX-License-Identifier: MIT */
/* Jobs with a target error: when their worker dies, the next one goes on after the last round that
 * was kept; and a job of higher priority comes between two rounds. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/jobs.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES], other[PEN_ID_BYTES];
static struct pen_status st;

static const char lengthy[] =
    "{\"scene\": \"builtin:lens\", \"views\": [\"middle\"], \"render\": {\"width\": 64,"
    " \"height\": 48, \"target_error\": 0.001, \"max_samples\": 65536}}";
static const char urgent[] = "{\"scene\": \"builtin:spheres\", \"priority\": 5,"
                             " \"render\": {\"width\": 16, \"height\": 12}}";

/* What the job has kept. The test fails if there is nothing within a minute, or the job ends. */
static struct pen_buf wait_for_state(void)
{
    struct pen_buf state = {0};
    for (int i = 0; i < 6000; i++) {
        if (pen_store_artefact(bed.bed.store, id, 0, "kept", "state", &state, &st))
            return state;
        ck_assert_msg(!pen_job_state_ended(store_job_state(bed.bed.store, id)), "it has ended");
        usleep(10000);
    }
    ck_abort_msg("nothing is kept");
}

static bool has_state(void)
{
    struct pen_buf state = {0};
    const bool has = pen_store_artefact(bed.bed.store, id, 0, "kept", "state", &state, &st);
    pen_buf_release(&state);
    return has;
}

/* Begins the job in a worker that is killed when it has kept something. */
static struct pen_buf begin_and_kill(void)
{
    int status, opened;
    store_bed_make(&bed.bed);
    const pid_t pid = jobs_worker_fork(&bed);
    jobs_bed_open(&bed);
    jobs_submit(&bed, lengthy, id);
    struct pen_buf state = wait_for_state();
    kill(pid, SIGKILL);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    pen_buf_release(&state);
    state = wait_for_state(); /* it may have kept more since */
    store_must(pen_store_expire_leases(bed.bed.store, "doomed:1:1", &opened, &st), &st, "expire");
    ck_assert_int_eq(opened, 1);
    return state;
}

/* The pixels of the job when it is done. */
static struct pen_buf finish(void)
{
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(!has_state()); /* is of no more use */
    return jobs_image(&bed, id, "middle", "pfm");
}

static struct pen_buf whole_picture(void)
{
    jobs_submit(&bed, lengthy, id);
    return finish();
}

/* The interrupted job gives the same picture as one that is not interrupted. */
static void check_finished_picture(void)
{
    struct pen_buf picture = finish(), whole = whole_picture();
    ck_assert_uint_eq(picture.bytes, whole.bytes);
    ck_assert_mem_eq(picture.data, whole.data, whole.bytes);
    pen_buf_release(&picture);
    pen_buf_release(&whole);
}

START_TEST(test_rounds__killed_worker_loses_no_round_that_is_kept)
{
    struct pen_buf state = begin_and_kill();
    pen_buf_release(&state);
    jobs_worker_start(&bed);
    check_finished_picture();
    jobs_bed_close(&bed);
}
END_TEST

/* A state that has been changed changes the picture, so it is what the next worker goes on with;
 * one that is not whole is not used. */
START_TEST(test_rounds__next_worker_goes_on_with_what_is_kept)
{
    for (int cut = 0; cut < 2; cut++) {
        struct pen_buf state = begin_and_kill();
        double *red = (double *)(void *)(state.data + state.bytes - 64); /* of the last pixel */
        *red += 1000;
        store_must(pen_store_artefact_put(bed.bed.store, id, 0, "kept", "state", state.data,
                                          state.bytes - (size_t)cut, &st),
                   &st, "put");
        pen_buf_release(&state);
        jobs_worker_start(&bed);
        struct pen_buf picture = finish(), whole = whole_picture();
        ck_assert_uint_eq(picture.bytes, whole.bytes);
        ck_assert((memcmp(picture.data, whole.data, whole.bytes) == 0) == (cut == 1));
        pen_buf_release(&picture);
        pen_buf_release(&whole);
        jobs_bed_close(&bed);
    }
}
END_TEST

START_TEST(test_rounds__job_of_higher_priority_comes_between_two_rounds)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, lengthy, id);
    struct pen_buf state = wait_for_state();
    pen_buf_release(&state);
    jobs_submit(&bed, urgent, other);
    ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_RUNNING);
    check_finished_picture();
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("rounds", test_rounds__killed_worker_loses_no_round_that_is_kept,
          test_rounds__next_worker_goes_on_with_what_is_kept,
          test_rounds__job_of_higher_priority_comes_between_two_rounds)
