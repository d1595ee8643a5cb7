/* SPDX-License-Identifier: MIT */
/* Lists and their cursors, get, cancel, delete, built-in scenes, and problem documents. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

static json_t *list(const struct pen_list_query *query)
{
    struct pen_status st;
    json_t *answer = pen_jobs_list(bed.jobs, query, &st);
    store_must(answer != NULL, &st, "list");
    return answer;
}

/* The names of the jobs on a page, one letter each. */
static void names_of(const json_t *page, char *out)
{
    const json_t *jobs = json_object_get(page, "jobs");
    size_t count = json_array_size(jobs);
    for (size_t i = 0; i < count; i++)
        out[i] = json_string_value(json_object_get(json_array_get(jobs, i), "name"))[0];
    out[count] = '\0';
}

static void submit_named(char name)
{
    char body[4200];
    snprintf(body, sizeof body, "{\"name\": \"%c\", \"scene\": %s}", name, jobs_scene(""));
    jobs_submit(&bed, body, id);
}

START_TEST(test_list__pages_follow_one_another_without_gaps)
{
    char names[16], cursor[32];
    jobs_bed_open(&bed);
    for (char name = 'a'; name <= 'g'; name++)
        submit_named(name);
    struct pen_list_query query = {.state = -1, .limit = 3};
    json_t *page = list(&query);
    names_of(page, names);
    ck_assert_str_eq(names, "gfe");
    snprintf(cursor, sizeof cursor, "%s", json_string_value(json_object_get(page, "next")));
    json_decref(page);
    submit_named('x');
    query.cursor = cursor;
    query.limit = 2;
    page = list(&query);
    names_of(page, names);
    ck_assert_str_eq(names, "dc");
    snprintf(cursor, sizeof cursor, "%s", json_string_value(json_object_get(page, "next")));
    json_decref(page);
    page = list(&query);
    names_of(page, names);
    ck_assert_str_eq(names, "ba");
    ck_assert(json_is_null(json_object_get(page, "next")));
    json_decref(page);
    jobs_bed_close(&bed);
}
END_TEST

/* The first page counts all jobs of the store, whatever it is filtered by. */
START_TEST(test_list__counts_jobs_by_state)
{
    static const char *const states[] = {"queued", "running", "succeeded", "failed", "cancelled"};
    static const int expected[] = {4, 0, 0, 0, 2};
    struct pen_job_snapshot job;
    struct pen_status st;
    jobs_bed_open(&bed);
    for (char name = 'a'; name <= 'g'; name++) {
        submit_named(name);
        if (name > 'd') {
            ck_assert(pen_jobs_cancel(bed.jobs, id, NULL, &job, &st));
            json_decref(job.json);
        }
    }
    ck_assert(pen_jobs_delete(bed.jobs, id, NULL, false, &st));
    struct pen_list_query query = {.state = PEN_JOB_QUEUED, .name = "a", .limit = 1};
    json_t *page = list(&query), *counts = json_object_get(page, "counts");
    ck_assert_uint_eq(json_object_size(counts), 5);
    for (int i = 0; i < 5; i++)
        ck_assert_int_eq(json_integer_value(json_object_get(counts, states[i])), expected[i]);
    json_decref(page);
    query.cursor = "j2";
    page = list(&query);
    ck_assert_ptr_null(json_object_get(page, "counts"));
    json_decref(page);
    jobs_bed_close(&bed);
}
END_TEST

/* The jobs of all pages are those of the store, and no page is empty or long. */
START_TEST(test_list__a_page_ends_at_a_mebibyte)
{
    enum { JOBS = 150, VALUE = 200, LABELS = 32 };
    struct pen_buf labels = {0};
    char cursor[32] = "", last[PEN_ID_BYTES] = "";
    int count = 0, pages = 0;
    jobs_bed_open(&bed);
    for (int i = 0; i < LABELS; i++)
        pen_buf_printf(&labels, "%s\"%d\": \"%0*d\"", i ? ", " : "", i, VALUE, i);
    for (int i = 0; i < JOBS; i++) {
        struct pen_buf body = {0};
        pen_buf_printf(&body, "{\"labels\": {%s}, \"scene\": %s}", (const char *)labels.data,
                       jobs_scene(", \"render\": {\"width\": 1, \"height\": 1}"));
        ck_assert(!body.failed);
        jobs_submit(&bed, (const char *)body.data, id);
        pen_buf_release(&body);
    }
    do {
        struct pen_list_query query = {
            .state = -1, .limit = 500, .cursor = cursor[0] ? cursor : NULL};
        json_t *page = list(&query);
        const json_t *jobs = json_object_get(page, "jobs");
        ck_assert_uint_gt(json_array_size(jobs), 0);
        ck_assert_uint_lt(json_dumpb(page, NULL, 0, JSON_COMPACT), 1 << 20);
        for (size_t i = 0; i < json_array_size(jobs); i++) {
            const char *here = json_string_value(json_object_get(json_array_get(jobs, i), "id"));
            ck_assert_str_ne(here, last);
            snprintf(last, sizeof last, "%s", here);
        }
        count += (int)json_array_size(jobs);
        pages++;
        const char *next = json_string_value(json_object_get(page, "next"));
        snprintf(cursor, sizeof cursor, "%s", next ? next : "");
        json_decref(page);
    } while (cursor[0]);
    ck_assert_int_eq(count, JOBS);
    ck_assert_int_eq(pages, 2);
    pen_buf_release(&labels);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_list__state_filters)
{
    char names[16];
    struct pen_status st;
    jobs_bed_open(&bed);
    for (char name = 'a'; name <= 'd'; name++) {
        submit_named(name);
        if (name % 2)
            store_must(pen_store_cancel(bed.bed.store, id, NULL, &st), &st, "cancel");
    }
    struct pen_list_query query = {.state = PEN_JOB_CANCELLED, .limit = 500, .kind = "render"};
    json_t *page = list(&query);
    names_of(page, names);
    ck_assert_str_eq(names, "ca");
    json_decref(page);
    jobs_bed_close(&bed);
}
END_TEST

static void submit_labelled(char name, const char *labels)
{
    char body[4200];
    snprintf(body, sizeof body, "{\"name\": \"%c\", \"labels\": {%s}, \"scene\": %s}", name, labels,
             jobs_scene(""));
    jobs_submit(&bed, body, id);
}

static void expect_names(const struct pen_list_query *query, const char *expected)
{
    char names[16];
    json_t *page = list(query);
    names_of(page, names);
    ck_assert_str_eq(names, expected);
    json_decref(page);
}

START_TEST(test_list__name_and_label_filter)
{
    struct pen_status st;
    jobs_bed_open(&bed);
    submit_labelled('a', "\"shot\": \"12\", \"a.b\\\"c\": \"x:y\"");
    submit_labelled('b', "\"shot\": \"13\"");
    submit_labelled('a', "\"shots\": \"12\"");
    submit_labelled('c', "\"shot\": \"12\"");
    struct pen_list_query query = {.state = -1, .limit = 9};
    query.label = "shot:12";
    expect_names(&query, "ca");
    query.name = "a";
    expect_names(&query, "a");
    query.state = PEN_JOB_RUNNING;
    expect_names(&query, "");
    query.state = PEN_JOB_QUEUED;
    query.label = "a.b\"c:x:y";
    expect_names(&query, "a");
    query.label = NULL;
    expect_names(&query, "aa");
    query.label = "shot";
    ck_assert_ptr_null(pen_jobs_list(bed.jobs, &query, &st));
    ck_assert_int_eq(st.code, PEN_USAGE);
    jobs_bed_close(&bed);
}
END_TEST

/* The numbers of the jobs of which the batches are claimed, in this order, as digits. */
static void claim_all(bool labelled, char order[32])
{
    enum { JOBS = 4, VIEWS = 3 };
    char ids[JOBS][PEN_ID_BYTES], body[4400];
    int n = 0;
    jobs_bed_open(&bed);
    for (int i = 0; i < JOBS; i++) {
        snprintf(body, sizeof body,
                 "{\"labels\": {\"frame\": \"%d\"}, \"scene\": %s, \"render\": {\"width\": 4,"
                 " \"height\": 4}}",
                 labelled ? i : 0,
                 jobs_scene(", \"views\": [{\"name\": \"a\"}, {\"name\": \"b\"},"
                            " {\"name\": \"c\"}]"));
        jobs_submit(&bed, body, ids[i]);
    }
    for (; n < JOBS * VIEWS; n++) {
        struct pen_claim claim = store_claim(bed.bed.store, "w");
        claim.spent_us = 1000000;
        ck_assert_int_eq(store_commit(bed.bed.store, &claim), PEN_OK);
        for (int i = 0; i < JOBS; i++)
            order[n] = strcmp(claim.job_id, ids[i]) ? order[n] : (char)('0' + i);
    }
    order[n] = '\0';
    jobs_bed_close(&bed);
}

/* Four frames of three views, with a label for each frame and with the same label for all. */
START_TEST(test_list__labels_do_not_affect_the_order_of_jobs)
{
    char same[32] = "", each[32] = "";
    claim_all(false, same);
    claim_all(true, each);
    ck_assert_str_eq(each, same);
    ck_assert_msg(strrchr(each, '0') - each < 8, "the first job ends late: %s", each);
}
END_TEST

START_TEST(test_list__wrong_cursors_and_limits_are_refused)
{
    static const char *const bad[] = {
        "", "1", "j", "j0", "jx", "j1x", "j-1", "j99999999999999999999", "J1"};
    struct pen_status st;
    jobs_bed_open(&bed);
    struct pen_list_query query = {.state = -1, .limit = 5};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        query.cursor = bad[i];
        ck_assert_msg(!pen_jobs_list(bed.jobs, &query, &st), "accepted %s", bad[i]);
        ck_assert_int_eq(st.code, PEN_USAGE);
    }
    query.cursor = NULL;
    query.limit = 0;
    ck_assert(!pen_jobs_list(bed.jobs, &query, &st));
    query.limit = 501;
    ck_assert(!pen_jobs_list(bed.jobs, &query, &st));
    ck_assert_int_eq(st.code, PEN_USAGE);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_list__cancel_and_delete_follow_the_state)
{
    struct pen_job_snapshot snapshot;
    struct pen_status st;
    jobs_bed_open(&bed);
    submit_named('a');
    ck_assert(!pen_jobs_delete(bed.jobs, id, NULL, true, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    for (int i = 0; i < 2; i++) {
        store_must(pen_jobs_cancel(bed.jobs, id, NULL, &snapshot, &st), &st, "cancel");
        ck_assert_int_eq(snapshot.state, PEN_JOB_CANCELLED);
        ck_assert_int_eq(snapshot.revision, 2);
        ck_assert_ptr_nonnull(json_string_value(json_object_get(snapshot.json, "finished_at")));
        json_decref(snapshot.json);
    }
    store_must(pen_jobs_delete(bed.jobs, id, NULL, true, &st), &st, "delete");
    ck_assert(!pen_jobs_get(bed.jobs, id, &snapshot, &st));
    ck_assert_int_eq(st.code, PEN_GONE);
    ck_assert(!pen_jobs_cancel(bed.jobs, id, NULL, &snapshot, &st));
    ck_assert_int_eq(st.code, PEN_GONE);
    jobs_bed_close(&bed);
}
END_TEST

static void expect_forbidden(const char *client)
{
    struct pen_job_snapshot snapshot;
    struct pen_status st = {0};
    ck_assert(!pen_jobs_cancel(bed.jobs, id, client, &snapshot, &st));
    ck_assert_int_eq(st.code, PEN_FORBIDDEN);
    ck_assert_ptr_nonnull(strstr(st.msg, "a token of scope admin may"));
    for (int keep_stats = 0; keep_stats < 2; keep_stats++) {
        ck_assert(!pen_jobs_delete(bed.jobs, id, client, keep_stats, &st));
        ck_assert_int_eq(st.code, PEN_FORBIDDEN);
    }
}

START_TEST(test_list__only_the_client_of_a_job_changes_it)
{
    const char *body = jobs_scene("");
    const struct pen_submission in = {.body = body, .bytes = strlen(body), .client = "token:a"};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    struct pen_job_snapshot snapshot;
    struct pen_status st;
    jobs_bed_open(&bed);
    ck_assert(pen_jobs_submit(bed.jobs, &in, &out, &errors));
    memcpy(id, out.id, sizeof id);
    pen_buf_release(&out.answer);
    for (int i = 0; i < 2; i++) {
        expect_forbidden("token:b");
        store_must(pen_jobs_cancel(bed.jobs, id, "token:a", &snapshot, &st), &st, "cancel");
        ck_assert_int_eq(snapshot.revision, 2);
        ck_assert(snapshot.cancelled_now == (i == 0));
        json_decref(snapshot.json);
    }
    expect_forbidden("token:b");
    store_must(pen_jobs_delete(bed.jobs, id, "token:a", true, &st), &st, "delete");
    ck_assert(!pen_jobs_delete(bed.jobs, id, "token:b", false, &st));
    ck_assert_int_eq(st.code, PEN_FORBIDDEN);
    store_must(pen_jobs_delete(bed.jobs, id, "token:a", false, &st), &st, "drop");
    jobs_bed_close(&bed);
}
END_TEST

/* The estimate belongs to the revision: reading the same revision later gives the same. */
START_TEST(test_list__progress_is_frozen_per_revision)
{
    static float rgb[64 * 64 * 3];
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_submit(&bed,
                jobs_scene(", \"render\": {\"width\": 64, \"height\": 64, \"tile\": 16,"
                           " \"samples_per_pixel\": 2000}"),
                id);
    struct pen_claim claim = store_claim(bed.bed.store, "w");
    struct pen_result result = {.rgb = rgb, .pixels = claim.pixels, .stats = "{}"};
    struct timespec pause = {.tv_nsec = 30000000};
    nanosleep(&pause, NULL);
    store_must(pen_store_commit(bed.bed.store, &claim, &result, NULL, &st), &st, "commit");
    json_t *first = jobs_get(&bed, id);
    nanosleep(&pause, NULL);
    json_t *again = jobs_get(&bed, id);
    ck_assert(json_equal(first, again));
    const json_t *progress = json_object_get(first, "progress");
    double done = json_number_value(json_object_get(progress, "done"));
    double eta = json_number_value(json_object_get(progress, "eta_seconds"));
    ck_assert(done == (double)claim.pixels);
    ck_assert(json_number_value(json_object_get(progress, "fraction")) == done / 4096);
    ck_assert(eta >= 0.029 * (4096 - done) / done);
    json_decref(first);
    json_decref(again);
    jobs_bed_close(&bed);
}
END_TEST

static double eta_of(void)
{
    json_t *job = jobs_get(&bed, id);
    const json_t *eta = json_object_get(json_object_get(job, "progress"), "eta_seconds");
    const double seconds = json_is_null(eta) ? -1 : json_number_value(eta);
    json_decref(job);
    return seconds;
}

/* What workers are expected to spend on the job, less what they have spent when they told it; as
 * much longer as it took until then, since they may have had a part of the time. */
static void check_eta(double spent_s)
{
    static float rgb[64 * 64 * 3];
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_submit(&bed,
                jobs_scene(", \"render\": {\"width\": 64, \"height\": 64, \"tile\": 16,"
                           " \"samples_per_pixel\": 2000}"),
                id);
    struct pen_claim claim = store_claim(bed.bed.store, "w");
    ck_assert(eta_of() == -1);
    store_must(pen_store_estimate(bed.bed.store, &claim, 8000000, NULL, &st), &st, "estimate");
    ck_assert(eta_of() == 8000);
    struct pen_result result = {
        .rgb = rgb, .pixels = claim.pixels, .work = PEN_WORK_ALL / 4, .stats = "{}"};
    claim.spent_us = (int64_t)(spent_s * 1e6);
    claim.estimate_ms = 6000000;
    store_must(pen_store_commit(bed.bed.store, &claim, &result, NULL, &st), &st, "commit");
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    const double took = (double)(job.elapsed_us - job.queue_us) / 1e6,
                 sharing = spent_s > 0 ? took / spent_s : 1, wanted = (6000 - spent_s) * sharing;
    ck_assert(fabs(eta_of() - wanted) <= 1e-6 * wanted);
    ck_assert_int_eq(job.work, PEN_WORK_ALL / 4);
    pen_job_record_release(&job);
    jobs_bed_close(&bed);
}

START_TEST(test_list__first_eta_is_the_estimate_of_the_worker)
{
    check_eta(0);
    check_eta(0.002); /* a part of what has passed */
}
END_TEST

/* A job whose bound is above three seconds gets a map of its work before its first pixels, a small
 * one does not. */
START_TEST(test_list__only_long_jobs_get_a_cost_map)
{
    static const char *const renders[] = {
        ", \"render\": {\"width\": 64, \"height\": 64, \"tile\": 16}",
        ", \"render\": {\"width\": 2000, \"height\": 1500, \"samples_per_pixel\": 18}"};
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < 2; i++) {
        jobs_submit(&bed, jobs_scene(renders[i]), id);
        struct pen_job_record job = store_job_get(bed.bed.store, id);
        while (job.done_pixels == 0) {
            pen_job_record_release(&job);
            usleep(1000);
            job = store_job_get(bed.bed.store, id);
        }
        struct pen_buf map = {0};
        store_must(pen_store_cost_map(bed.bed.store, id, &map, &st), &st, "map");
        ck_assert_int_eq(map.bytes > 0, i == 1);
        pen_buf_release(&map);
        pen_job_record_release(&job);
    }
    struct pen_job_snapshot snapshot;
    store_must(pen_jobs_cancel(bed.jobs, id, NULL, &snapshot, &st), &st, "cancel");
    json_decref(snapshot.json);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_list__built_in_scenes_are_listed_by_name)
{
    json_t *answer = pen_jobs_scenes();
    const json_t *scenes = json_object_get(answer, "scenes");
    bool room = false;
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *scene = json_array_get(scenes, i);
        ck_assert_ptr_nonnull(json_string_value(json_object_get(scene, "title")));
        if (strcmp(json_string_value(json_object_get(scene, "name")), "room") != 0)
            continue;
        room = true; /* all of its primitives are in nine groups */
        ck_assert_int_gt(json_integer_value(json_object_get(scene, "objects")), 400);
    }
    ck_assert(room);
    json_decref(answer);
}
END_TEST

static void expect_text(const json_t *object, const char *key, const char *text)
{
    const char *found = json_string_value(json_object_get(object, key));
    ck_assert_msg(found && strcmp(found, text) == 0, "%s: %s", key, found ? found : "missing");
}

START_TEST(test_list__problem_of_one_status)
{
    struct pen_status st;
    pen_fail(&st, PEN_STORAGE_FULL, "the store is full");
    json_t *problem = pen_problem(&st);
    expect_text(problem, "type", "urn:penumbra:problem:storage-full");
    expect_text(problem, "title", "Storage full");
    expect_text(problem, "detail", "the store is full");
    ck_assert_int_eq(json_integer_value(json_object_get(problem, "status")), 507);
    ck_assert_ptr_null(json_object_get(problem, "errors"));
    json_decref(problem);
    pen_fail_line(&st, PEN_SYNTAX, 3, 14, "a comma is missing");
    problem = pen_problem(&st);
    const json_t *error = json_array_get(json_object_get(problem, "errors"), 0);
    ck_assert_int_eq(json_integer_value(json_object_get(error, "line")), 3);
    ck_assert_int_eq(json_integer_value(json_object_get(error, "column")), 14);
    ck_assert_ptr_null(json_object_get(error, "pointer"));
    json_decref(problem);
}
END_TEST

/* The text is what jansson would write, whatever is in the message. */
START_TEST(test_list__problem_is_written_as_json)
{
    struct pen_status st;
    struct pen_buf text = {0};
    char hostile[80] = "\"a\\b/\x7f\xC3\xA9\xF0\x9D\x84\x9E\xE2\x80\xAE<>";
    for (size_t c = 1, end = strlen(hostile); c < ' '; c++)
        hostile[end++] = (char)c;
    pen_fail_at(&st, PEN_INVALID, hostile, "%s", hostile);
    ck_assert(pen_problem_write(&text, &st, 418, "id-1"));
    json_t *problem = json_loadb((const char *)text.data, text.bytes, 0, NULL);
    ck_assert_ptr_nonnull(problem);
    char *again = json_dumps(problem, JSON_COMPACT);
    ck_assert_uint_eq(strlen(again) + 1, text.bytes); /* and a line end */
    ck_assert_int_eq(memcmp(again, text.data, strlen(again)), 0);
    expect_text(problem, "detail", hostile);
    expect_text(problem, "request_id", "id-1");
    expect_text(json_array_get(json_object_get(problem, "errors"), 0), "pointer", hostile);
    ck_assert_int_eq(json_integer_value(json_object_get(problem, "status")), 418);
    free(again);
    json_decref(problem);
    pen_buf_release(&text);
}
END_TEST

START_TEST(test_list__problem_of_several_errors)
{
    struct pen_errors errors = {0};
    struct pen_status st;
    for (int i = 0; i < 25; i++) {
        char at[32];
        snprintf(at, sizeof at, "/objects/%d", i);
        pen_fail_at(&st, PEN_INVALID, i ? at : "", "wrong");
        pen_errors_add(&errors, &st);
    }
    json_t *problem = pen_problem_list(&errors);
    const json_t *list_of = json_object_get(problem, "errors");
    ck_assert_uint_eq(json_array_size(list_of), PEN_ERRORS_MAX);
    expect_text(json_array_get(list_of, 0), "pointer", "");
    expect_text(json_array_get(list_of, 19), "pointer", "/objects/19");
    expect_text(json_array_get(list_of, 19), "detail", "wrong");
    expect_text(problem, "detail", "25 errors, the first 20 are listed");
    ck_assert_int_eq(json_integer_value(json_object_get(problem, "status")), 422);
    json_decref(problem);
}
END_TEST

START_TEST(test_list__workers_are_shown_with_host_and_work)
{
    struct pen_status st;
    jobs_bed_open(&bed);
    struct pen_worker_new eight = {.id = "eight", .threads = 8, .lease_ms = 60000};
    store_must(pen_store_worker_seen(bed.bed.store, &eight, &st), &st, "seen");
    store_worker_seen(bed.bed.store, "odd");
    jobs_submit(&bed, jobs_scene(", \"render\": {\"width\": 24, \"height\": 18}"), id);
    struct pen_claim claim = store_claim(bed.bed.store, "odd");
    json_t *answer = pen_jobs_workers(bed.jobs, &st);
    json_t *list = json_object_get(answer, "workers");
    ck_assert_uint_eq(json_array_size(list), 2);
    json_t *first = json_array_get(list, 0), *second = json_array_get(list, 1);
    char host[256];
    ck_assert_int_eq(gethostname(host, sizeof host), 0);
    ck_assert_str_eq(json_string_value(json_object_get(first, "host")), host);
    ck_assert_int_eq(json_integer_value(json_object_get(first, "pid")), getpid());
    ck_assert_int_eq(json_integer_value(json_object_get(first, "threads")), 8);
    ck_assert_uint_eq(json_array_size(json_object_get(first, "batches")), 0);
    ck_assert_str_eq(json_string_value(json_object_get(first, "name")), "eight");
    ck_assert_str_eq(json_string_value(json_object_get(second, "name")), "odd");
    json_t *batch = json_array_get(json_object_get(second, "batches"), 0);
    ck_assert_str_eq(json_string_value(json_object_get(batch, "job")), id);
    ck_assert_str_eq(json_string_value(json_object_get(batch, "kind")), "render");
    ck_assert_int_eq(json_integer_value(json_object_get(batch, "batch")), claim.batch);
    json_decref(answer);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("list", test_list__pages_follow_one_another_without_gaps, test_list__counts_jobs_by_state,
          test_list__a_page_ends_at_a_mebibyte, test_list__state_filters,
          test_list__name_and_label_filter, test_list__labels_do_not_affect_the_order_of_jobs,
          test_list__wrong_cursors_and_limits_are_refused,
          test_list__cancel_and_delete_follow_the_state,
          test_list__only_the_client_of_a_job_changes_it,
          test_list__progress_is_frozen_per_revision,
          test_list__first_eta_is_the_estimate_of_the_worker,
          test_list__only_long_jobs_get_a_cost_map, test_list__built_in_scenes_are_listed_by_name,
          test_list__problem_of_one_status, test_list__problem_is_written_as_json,
          test_list__problem_of_several_errors, test_list__workers_are_shown_with_host_and_work)
