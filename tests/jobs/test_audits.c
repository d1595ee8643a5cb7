/* SPDX-License-Identifier: MIT */
/* Audits of jobs. Their progress is kept across a worker's death, and jobs of higher priority come
 * between two pixels. For a view of one batch, a view of several, and a view with a target
 * error. */
#include <string.h>

#include "render/audit.h"
#include "support/jobs.h"
#include "support/random.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES], other[PEN_ID_BYTES];

#define AUDITED(render)                                                                            \
    "{\"scene\": \"builtin:lens\", \"views\": [\"middle\"], \"audit\": {\"pixels\": 600,"          \
    " \"threshold\": 0.02}, \"render\": {\"width\": 32, \"height\": 24, \"tile\": 8, " render "}}"
static const char *const bodies[] = {AUDITED("\"samples_per_pixel\": 16"),
                                     AUDITED("\"target_error\": 0.02")};
static const char urgent[] = "{\"scene\": \"builtin:spheres\", \"priority\": 5,"
                             " \"render\": {\"width\": 16, \"height\": 12}}";
enum { WHOLE, ROUNDS, PARTS, SHAPES };

/* A worker that has a millisecond for a batch makes several of a view. */
static const char *body_of(int shape)
{
    bed.batch_ms = shape == PARTS ? 1 : 0;
    return bodies[shape == ROUNDS];
}

/* The audit in the statistics of a job that has ended well. */
static json_t *audit_of(const char *job)
{
    struct pen_status st;
    ck_assert_int_eq(jobs_wait(&bed, job), PEN_JOB_SUCCEEDED);
    ck_assert(!jobs_has_kept(&bed, job, "audit"));
    json_t *stats = pen_jobs_stats(bed.jobs, job, &st),
           *audit = json_deep_copy(json_object_get(stats, "audit"));
    ck_assert_ptr_nonnull(audit);
    json_decref(stats);
    return audit;
}

/* The audit of the same job, which nothing interrupts. */
static void check_same_audit(json_t *audit, const char *body)
{
    char again[PEN_ID_BYTES];
    jobs_submit(&bed, body, again);
    json_t *whole = audit_of(again);
    ck_assert_msg(json_equal(audit, whole), "%s", json_dumps(audit, 0));
    json_decref(whole);
    json_decref(audit);
}

START_TEST(test_audits__job_of_higher_priority_comes_between_two_pixels)
{
    for (int shape = 0; shape < SHAPES; shape++) {
        if (shape == ROUNDS && !random_all()) /* gives way by the same code as WHOLE */
            continue;
        jobs_bed_open(&bed);
        const char *body = body_of(shape);
        jobs_worker_start(&bed);
        jobs_submit(&bed, body, id);
        struct pen_buf part = jobs_wait_kept(&bed, id, "audit");
        pen_buf_release(&part);
        jobs_submit(&bed, urgent, other);
        json_t *audit = audit_of(id);
        ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
        ck_assert(jobs_did_not_wait(&bed, other, id));
        check_same_audit(audit, body);
        jobs_bed_close(&bed);
    }
}
END_TEST

/* What is kept is the seed, and how many pixels are done, are left, are wrong and are undecided,
 * then where: a hundred more that are wrong are there in the end, with another seed they are
 * not. */
START_TEST(test_audits__next_worker_goes_on_with_what_is_kept)
{
    for (int shape = 0; shape < 2 * SHAPES; shape++) {
        struct {
            uint64_t seed;
            struct pen_audit_progress progress;
        } kept;
        const bool another_seed = shape >= SHAPES;
        const char *body = body_of(shape % SHAPES);
        struct pen_buf part = jobs_begin_and_kill(&bed, body, id, "audit", NULL);
        bed.max_seconds = 120; /* which count from the claim, in a new worker, too */
        ck_assert_uint_eq(part.bytes, sizeof kept);
        memcpy(&kept, part.data, sizeof kept);
        pen_buf_release(&part);
        ck_assert_uint_gt(kept.progress.done, 0);
        ck_assert_uint_eq(kept.progress.done + kept.progress.left, 600);
        kept.progress.wrong += 100;
        kept.seed += another_seed;
        jobs_put_kept(&bed, id, "audit", &kept, sizeof kept);
        jobs_worker_start(&bed);
        json_t *audit = audit_of(id);
        const json_int_t wrong = json_integer_value(json_object_get(audit, "wrong"));
        if (!another_seed)
            json_object_set_new(audit, "wrong", json_integer(wrong - 100));
        json_object_set_new(audit, "bound", json_null());
        jobs_submit(&bed, body, other);
        json_t *whole = audit_of(other);
        json_object_set_new(whole, "bound", json_null());
        ck_assert(json_equal(audit, whole));
        json_decref(audit);
        json_decref(whole);
        jobs_bed_close(&bed);
    }
}
END_TEST

PEN_SUITE("audits", test_audits__job_of_higher_priority_comes_between_two_pixels,
          test_audits__next_worker_goes_on_with_what_is_kept)
