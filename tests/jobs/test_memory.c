/* SPDX-License-Identifier: MIT */
/* Out of memory at any allocation. Every call reports it and leaks nothing (the run with sanitizers
 * checks that). It leaves a sound store, in which the same call then succeeds. */
#include <stdio.h>
#include <string.h>

#include "report/report.h"
#include "support/alloc.h"
#include "support/jobs.h"
#include "support/store_rows.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

/* One call that either does all of its work or fails. */
typedef bool work_fn(struct pen_status *st);

/* Repeats the call and lets one more allocation succeed each time, until none is refused. */
static void starve(const char *name, work_fn *work)
{
    for (long n = 0; n < 1000000; n++) {
        struct pen_status st = {0};
        alloc_fail_after(n);
        bool ok = work(&st);
        if (!alloc_succeed()) {
            ck_assert_msg(ok, "%s: %s", name, st.msg);
            return;
        }
        ck_assert_msg(ok || st.code != PEN_OK, "%s: no code after %ld", name, n);
        ck_assert_msg(ok || st.code == PEN_NO_MEMORY || st.code == PEN_STORAGE,
                      "%s after %ld: %s: %s", name, n, pen_code_name(st.code), st.msg);
    }
    ck_abort_msg("%s never succeeds", name);
}

static bool first_error(bool ok, const struct pen_errors *errors, struct pen_status *st)
{
    if (!ok)
        *st = errors->item[0];
    return ok;
}

static bool submit(const char *body, const char *key, struct pen_status *st)
{
    struct pen_submission in = {.body = body, .bytes = strlen(body), .idempotency_key = key};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    bool ok = pen_jobs_submit(bed.jobs, &in, &out, &errors);
    if (ok)
        memcpy(id, out.id, sizeof id);
    pen_buf_release(&out.answer);
    return first_error(ok, &errors, st);
}

static bool work_submit(struct pen_status *st)
{
    static const char body[] =
        "{\"name\": \"n\", \"labels\": {\"a\": \"b\"}, \"timeout_seconds\": 3, \"views\": "
        "[\"main\"],"
        " \"scene\": {\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
        " \"look_at\": [0, 0, 0]}, \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0],"
        " \"radius\": 1}]}, \"render\": {\"width\": 9, \"height\": 9}}";
    return submit(body, "k", st);
}

static bool work_submit_benchmark(struct pen_status *st)
{
    static const char body[] =
        "{\"kind\": \"benchmark\", \"matrix\": {\"accelerator\": [\"none\", \"auto\"], "
        "\"threads\": "
        "[1, 2]}, \"repeats\": 1, \"warmup\": 0, \"baseline\": {\"threads\": 2},"
        " \"scene\": {\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
        " \"look_at\": [0, 0, 0]}, \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0],"
        " \"radius\": 1}]}, \"render\": {\"width\": 9, \"height\": 9}}";
    return submit(body, "b", st);
}

static const char *form; /* of the report */

static bool work_report(struct pen_status *st)
{
    struct pen_image report;
    bool ok = pen_jobs_report(bed.jobs, id, form, &report, st);
    pen_buf_release(&report.bytes);
    return ok;
}

static bool work_refuse(struct pen_status *st)
{
    static const char body[] = "{\"scene\": \"builtin:romm\", \"lables\": {}, \"views\": []}";
    struct pen_submission in = {.body = body, .bytes = sizeof body - 1};
    struct pen_errors errors = {0};
    json_t *answer = NULL;
    bool accepted = pen_jobs_validate(bed.jobs, &in, &answer, &errors);
    json_t *problem = pen_problem_list(&errors);
    bool ok = !accepted && problem && errors.count > 0 && errors.item[0].code == PEN_NOT_FOUND;
    if (!ok)
        pen_fail(st, PEN_NO_MEMORY, "no memory");
    json_decref(problem);
    return ok;
}

static bool work_get(struct pen_status *st)
{
    struct pen_job_snapshot snapshot;
    if (!pen_jobs_get(bed.jobs, id, &snapshot, st))
        return false;
    json_decref(snapshot.json);
    return true;
}

static bool work_list(struct pen_status *st)
{
    struct pen_list_query query = {.state = -1, .limit = 1};
    json_t *list = pen_jobs_list(bed.jobs, &query, st);
    json_decref(list);
    return list != NULL;
}

static bool work_sheet(struct pen_status *st)
{
    struct pen_image_query query = {.view = "all", .format = "png16"};
    struct pen_image image;
    bool ok = pen_jobs_image(bed.jobs, id, &query, &image, st);
    pen_buf_release(&image.bytes);
    return ok;
}

static bool work_pfm(struct pen_status *st)
{
    struct pen_image_query query = {.format = "pfm"};
    struct pen_image image;
    bool ok = pen_jobs_image(bed.jobs, id, &query, &image, st);
    pen_buf_release(&image.bytes);
    return ok;
}

static bool work_preview(struct pen_status *st)
{
    struct pen_image image;
    bool ok = pen_jobs_preview(bed.jobs, id, NULL, &image, st);
    pen_buf_release(&image.bytes);
    return ok;
}

static bool work_stats(struct pen_status *st)
{
    json_t *stats = pen_jobs_stats(bed.jobs, id, st);
    json_decref(stats);
    return stats != NULL;
}

static bool work_scene(struct pen_status *st)
{
    struct pen_buf scene = {0};
    bool ok = pen_store_scene(pen_jobs_store(bed.jobs), id, &scene, st);
    pen_buf_release(&scene);
    return ok;
}

static bool work_open(struct pen_status *st)
{
    struct pen_limits limits = {0};
    struct pen_jobs *jobs = pen_jobs_open(bed.bed.url, &limits, st);
    pen_jobs_close(jobs);
    return jobs != NULL;
}

START_TEST(test_memory__calls_fail_cleanly_and_then_succeed)
{
    jobs_bed_open(&bed);
    starve("open", work_open);
    starve("submit", work_submit);
    ck_assert_int_eq(store_contradictions(bed.bed.url), 0);
    starve("refuse", work_refuse);
    starve("get", work_get);
    starve("list", work_list);
    starve("scene", work_scene);
    starve("preview", work_preview);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    starve("pfm", work_pfm);
    starve("sheet", work_sheet);
    starve("stats", work_stats);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_memory__benchmark_calls_fail_cleanly_too)
{
    jobs_bed_open(&bed);
    starve("submit", work_submit_benchmark);
    ck_assert_int_eq(store_contradictions(bed.bed.url), 0);
    starve("get", work_get);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    starve("stats", work_stats);
    for (int i = 0; pen_report_formats[i]; i++) {
        form = pen_report_formats[i];
        starve(form, work_report);
    }
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("memory", test_memory__calls_fail_cleanly_and_then_succeed,
          test_memory__benchmark_calls_fail_cleanly_too)
