/* SPDX-License-Identifier: MIT */
/* Interrupted accuracy studies and bills of effects. When their worker is killed, the next worker
 * continues from the kept state, unless it is damaged. A job of higher priority comes between two
 * runs. All parts of the report that do not depend on time are as without interruption. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/jobs.h"
#include "support/random.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

static const char urgent[] = "{\"scene\": \"builtin:spheres\", \"priority\": 5,"
                             " \"render\": {\"width\": 16, \"height\": 12}}";

/* A time that no run takes, in ms: the mark of a changed state. */
#define MARK "0.001"

/* A study. */
struct kind {
    const char *members; /* of the job, beside its scene */
    int rows;            /* of the report */
    int done;            /* runs after which the first row has a time that counts, and the study
                          * is not at its end by far */
    const char *times;   /* members of a row that depend on time, with commas around each */
};

/* The target is met by the last row alone, whatever its time is. */
static const struct kind kinds[] = {
    {"\"kind\": \"accuracy\", \"render\": {\"width\": 56, \"height\": 42, \"tile\": 16},"
     " \"ladder\": {\"samples_per_pixel\": [4, 16, 64]}, \"seeds\": 10,"
     " \"target\": {\"metric\": \"rmse\", \"value\": 0.003},",
     4, 4 + 2 + 1,
     ",expected_ms,runs_ms,spoiled_runs,median_ms,min_ms,max_ms,threads,pareto,efficiency,"},
    {"\"kind\": \"effects\", \"render\": {\"width\": 56, \"height\": 42, \"tile\": 16,"
     " \"samples_per_pixel\": 64}, \"repeats\": 6,",
     6, 6 + 2, ",median_ms,min_ms,max_ms,spoiled,cost_ms,cost_share,cost_below_ms,"}};
static const struct kind *kind; /* the one that is tested */

static const char *body(void)
{
    static char text[8192];
    snprintf(text, sizeof text, "{%s \"scene\": %s}", kind->members, jobs_scene(""));
    return text;
}

static json_t *json_of(const struct pen_buf *text)
{
    json_t *json = json_loadb((const char *)text->data, text->bytes, 0, NULL);
    ck_assert_ptr_nonnull(json);
    return json;
}

static bool enough(const struct pen_buf *state)
{
    json_t *json = json_of(state);
    const bool is = json_integer_value(json_object_get(json, "done")) >= kind->done;
    json_decref(json);
    return is;
}

/* The report of the job when it is done; nothing is kept then. */
static json_t *finish(void)
{
    struct pen_image report;
    struct pen_status st;
    char name[24];
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(!jobs_has_kept(&bed, id, PEN_KEPT_STATE));
    for (int i = 0; i < kind->rows + 2; i++) {
        snprintf(name, sizeof name, "picture-%d", i);
        ck_assert(!jobs_has_kept(&bed, id, name));
    }
    store_must(pen_jobs_report(bed.jobs, id, "json", &report, &st), &st, "report");
    json_t *json = json_of(&report.bytes);
    pen_buf_release(&report.bytes);
    return json;
}

/* Whether the report has the time of the mark, in the first row. */
static bool is_marked(const json_t *report)
{
    const json_t *row = json_array_get(json_object_get(report, "rows"), 0);
    return json_number_value(json_object_get(row, "min_ms")) == strtod(MARK, NULL) ||
           json_number_value(json_array_get(json_object_get(row, "runs_ms"), 0)) ==
               strtod(MARK, NULL);
}

/* Removes what depends on time. */
static void strip(json_t *report)
{
    size_t i;
    json_t *row, *value;
    const char *key;
    void *next;
    char member[64];
    json_object_del(report, "began_at");
    json_object_del(report, "forecast");
    json_object_del(report, "calibration");
    json_object_del(report, "timing");
    json_object_del(json_object_get(report, "reference"), "render_ms");
    json_array_foreach(json_object_get(report, "rows"), i, row)
    {
        json_object_foreach_safe(row, next, key, value)
        {
            snprintf(member, sizeof member, ",%s,", key);
            if (strstr(kind->times, member))
                json_object_del(row, key);
        }
    }
    ck_assert_int_eq((int)json_array_size(json_object_get(report, "rows")), kind->rows);
}

/* Checks that the report, which is released, is that of a study without an interruption. */
static void check_report(json_t *report)
{
    const char *key;
    json_t *value;
    jobs_submit(&bed, body(), id);
    json_t *whole = finish();
    /* While others use the processors, nothing is recommended. */
    if (json_is_null(json_object_get(report, "recommended")))
        json_object_del(whole, "recommended");
    if (json_is_null(json_object_get(whole, "recommended")))
        json_object_del(whole, "recommended");
    strip(report);
    strip(whole);
    json_object_foreach(whole, key, value)
    {
        char *a = json_dumps(value, JSON_ENCODE_ANY | JSON_SORT_KEYS),
             *b = json_dumps(json_object_get(report, key), JSON_ENCODE_ANY | JSON_SORT_KEYS);
        ck_assert_msg(strcmp(a, b) == 0, "%s: %.900s\nand not %.900s", key, b, a);
        free(a);
        free(b);
    }
    json_decref(report);
    json_decref(whole);
}

/* The state with the mark as the time of the first run of the first row. */
static char *marked(const struct pen_buf *state)
{
    json_t *json = json_of(state);
    json_t *row = json_array_get(json_object_get(json, "rows"), 0),
           *first = json_array_get(json_object_get(row, "runs"), 0);
    ck_assert_int_eq(json_object_set_new(first, "ms", json_loads(MARK, JSON_DECODE_ANY, NULL)), 0);
    char *text = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(json);
    return text;
}

static void check_goes_on(const struct kind *tested)
{
    kind = tested;
    struct pen_buf state = jobs_begin_and_kill(&bed, body(), id, PEN_KEPT_STATE, enough);
    char *text = marked(&state);
    jobs_put_kept(&bed, id, PEN_KEPT_STATE, text, strlen(text));
    pen_buf_release(&state);
    free(text);
    jobs_worker_start(&bed);
    json_t *report = finish();
    ck_assert(is_marked(report));
    check_report(report);
    jobs_bed_close(&bed);
}

/* How a state or a picture is damaged. */
enum damage { CUT_STATE, NO_STATE, OTHER_BUILD, CUT_PICTURE, CHANGED_PICTURE, DAMAGES };

static void damage(enum damage damage, char *state)
{
    struct pen_buf picture = jobs_wait_kept(&bed, id, "picture-0");
    size_t bytes = strlen(state);
    char *build = strstr(state, "\"build\":\"");
    switch (damage) {
    case CUT_STATE:
        bytes -= 1;
        break;
    case NO_STATE:
        bytes = 0;
        break;
    case OTHER_BUILD:
        build[strlen("\"build\":\"")] ^= 1;
        break;
    case CUT_PICTURE:
        jobs_put_kept(&bed, id, "picture-0", picture.data, picture.bytes - 4);
        break;
    case CHANGED_PICTURE:
        picture.data[5] ^= 1;
        jobs_put_kept(&bed, id, "picture-0", picture.data, picture.bytes);
        break;
    case DAMAGES:
        break;
    }
    jobs_put_kept(&bed, id, PEN_KEPT_STATE, state, bytes);
    pen_buf_release(&picture);
}

static void check_not_used(const struct kind *tested, enum damage done)
{
    kind = tested;
    struct pen_buf state = jobs_begin_and_kill(&bed, body(), id, PEN_KEPT_STATE, enough);
    char *text = marked(&state);
    damage(done, text);
    pen_buf_release(&state);
    free(text);
    jobs_worker_start(&bed);
    json_t *report = finish();
    ck_assert(!is_marked(report));
    json_decref(report);
    jobs_bed_close(&bed);
}

/* All damages, or every second one of them, from `first` on: both kinds are read by the same
 * code. */
static void check_damages(const struct kind *tested, int first)
{
    for (int i = random_all() ? 0 : first; i < DAMAGES; i += random_all() ? 1 : 2)
        check_not_used(tested, (enum damage)i);
}

/* How many runs are kept; -1: nothing is. */
static json_int_t kept_runs(void)
{
    struct pen_buf state = {0};
    struct pen_status st;
    if (!pen_store_artefact(bed.bed.store, id, 0, "kept", PEN_KEPT_STATE, &state, &st))
        return -1;
    json_t *json = json_of(&state);
    const json_int_t done = json_integer_value(json_object_get(json, "done"));
    json_decref(json);
    pen_buf_release(&state);
    return done;
}

static void check_gives_way(const struct kind *tested)
{
    enum { URGENT = 3 };
    char others[URGENT][PEN_ID_BYTES];
    kind = tested;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, body(), id);
    struct pen_buf state = jobs_wait_kept(&bed, id, PEN_KEPT_STATE);
    pen_buf_release(&state);
    json_int_t before = kept_runs();
    for (int i = 0; i < URGENT; i++) {
        jobs_submit(&bed, urgent, others[i]);
        ck_assert_int_eq(jobs_wait(&bed, others[i]), PEN_JOB_SUCCEEDED);
        const json_int_t after = kept_runs();
        ck_assert(after >= before || /* it has not begun again */
                  pen_job_state_ended(store_job_state(bed.bed.store, id)));
        before = after;
    }
    json_t *report = finish();
    for (int i = 0; i < URGENT; i++)
        ck_assert(jobs_did_not_wait(&bed, others[i], id));
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    check_report(report);
    jobs_bed_close(&bed);
}

START_TEST(test_study_kept__next_worker_goes_on_with_a_study)
{
    check_goes_on(&kinds[0]);
}
END_TEST

START_TEST(test_study_kept__job_of_higher_priority_comes_between_two_runs_of_a_study)
{
    check_gives_way(&kinds[0]);
}
END_TEST

START_TEST(test_study_kept__damaged_study_is_not_used)
{
    check_damages(&kinds[0], 0);
}
END_TEST

START_TEST(test_study_kept__next_worker_goes_on_with_a_bill)
{
    check_goes_on(&kinds[1]);
}
END_TEST

START_TEST(test_study_kept__job_of_higher_priority_comes_between_two_runs_of_a_bill)
{
    check_gives_way(&kinds[1]);
}
END_TEST

START_TEST(test_study_kept__damaged_bill_is_not_used)
{
    check_damages(&kinds[1], 1);
}
END_TEST

PEN_SUITE("study kept", test_study_kept__next_worker_goes_on_with_a_study,
          test_study_kept__job_of_higher_priority_comes_between_two_runs_of_a_study,
          test_study_kept__damaged_study_is_not_used,
          test_study_kept__next_worker_goes_on_with_a_bill,
          test_study_kept__job_of_higher_priority_comes_between_two_runs_of_a_bill,
          test_study_kept__damaged_bill_is_not_used)
