/* SPDX-License-Identifier: MIT */
/* Accepted and refused submissions, with the code, place and words of each error; idempotency keys;
 * the object of an accepted job. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/jobs.h"
#include "support/store_rows.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

/* S stands for a good scene. */
struct bad {
    const char *body;
    enum pen_code code;
    const char *at, *words;
};

static const struct bad bad_bodies[] = {
    {"", PEN_SYNTAX, "", ""},
    {"{\"scene\": ", PEN_SYNTAX, "", ""},
    {"{\"scene\": S, \"scene\": S}", PEN_SYNTAX, "", ""},
    {"[]", PEN_INVALID, "", "found an empty array"},
    {"17", PEN_INVALID, "", "object"},
    {"{}", PEN_INVALID, "", "found neither"},
    {"{\"scne\": \"builtin:room\"}", PEN_INVALID, "/scne", "did you mean \"scene\"?"},
    {"{\"formt\": \"penumbra-scene/1\"}", PEN_INVALID, "/formt", "did you mean \"format\"?"},
    {"{\"kind\": \"render\"}", PEN_INVALID, "", "\"scene\""},
    {"{\"scene\": 5}", PEN_INVALID, "/scene", "found 5"},
    {"{\"scene\": \"room\"}", PEN_INVALID, "/scene", "builtin:"},
    {"{\"scene\": \"builtin:rooom\"}", PEN_NOT_FOUND, "/scene", "did you mean \"room\"?"},
    {"{\"scene\": \"builtin:\"}", PEN_NOT_FOUND, "/scene", "no built-in scene"},
    {"{\"scene\": {\"format\": \"penumbra-scene/1\"}}", PEN_INVALID, "/scene", "camera"},
    {"{\"format\": \"penumbra-scene/1\"}", PEN_INVALID, "", "camera"},
    {"{\"scene\": S, \"kind\": \"render\", \"prioritiy\": 1}", PEN_INVALID, "/prioritiy",
     "did you mean \"priority\"?"},
    {"{\"scene\": S, \"a/b~c\": 1}", PEN_INVALID, "/a~1b~0c",
     "unknown key in a job; the keys here are scene, kind, render, views, priority, name, labels, "
     "layers, cost, audit, max_attempts, timeout_seconds, budget_seconds"},
    {"{\"scene\": S, \"fog\": 1, \"kind\": \"effects\"}", PEN_INVALID, "/fog",
     "layers, max_attempts, timeout_seconds, repeats"},
    {"{\"scene\": S, \"width\": 8}", PEN_INVALID, "/width",
     "it is a setting: write {\"render\": {\"width\": …}}"},
    {"{\"scene\": S, \"prio\": 1}", PEN_INVALID, "/prio", "did you mean \"priority\"?"},
    {"{\"scene\": S, \"kind\": \"rendr\"}", PEN_INVALID, "/kind", "did you mean \"render\"?"},
    {"{\"scene\": S, \"budget_seconds\": 86401}", PEN_INVALID, "/budget_seconds",
     "above 0, at most 86400, found 86401"},
    {"{\"scene\": S, \"kind\": 3}", PEN_INVALID, "/kind",
     "must be one of render, benchmark, accuracy, effects, found 3"},
    {"{\"scene\": S, \"kind\": \"benchmark\", \"matrix\": {\"tile\": [8, 0]}}", PEN_INVALID,
     "/matrix/tile/1", "found 0"},
    {"{\"scene\": S, \"kind\": \"benchmark\", \"matrix\": {\"width\": [8, 70000]},"
     " \"render\": {\"height\": 60000}}",
     PEN_TOO_LARGE, "/matrix", "pixels"},
    {"{\"scene\": S, \"kind\": \"accuracy\", \"ladder\": {\"light_samples\": [0]}}", PEN_INVALID,
     "/ladder/light_samples/0", "found 0"},
    {"{\"scene\": S, \"kind\": \"accuracy\", \"ladder\": {\"max_depth\": [1, 2, 3]},"
     " \"render\": {\"width\": 5000, \"height\": 5000}}",
     PEN_TOO_LARGE, "/render", "pictures to be compared have"},
    {"{\"scene\": S, \"kind\": \"explain\"}", PEN_INVALID, "/kind", "POST /v1/explain"},
    {"{\"scene\": S, \"analyze\": true}", PEN_INVALID, "/analyze",
     "belongs to jobs of kind \"explain\""},
    {"{\"scene\": S, \"kind\": \"effects\", \"repeats\": 0}", PEN_INVALID, "/repeats",
     "from 1 to 100, found 0"},
    {"{\"scene\": S, \"kind\": \"effects\", \"warmup\": 1}", PEN_INVALID, "/warmup",
     "belongs to jobs of kind \"benchmark\""},
    {"{\"scene\": S, \"repeats\": 1}", PEN_INVALID, "/repeats",
     "belongs to jobs of kind \"benchmark\" or \"effects\""},
    {"{\"scene\": S, \"kind\": \"effects\", \"repeats\": 100,"
     " \"render\": {\"width\": 5000, \"height\": 5000, \"samples_per_pixel\": 500}}",
     PEN_TOO_LARGE, "/render", "renders together take up to"},
    {"{\"scene\": S, \"kind\": \"effects\", \"repeats\": 1,"
     " \"render\": {\"width\": 5000, \"height\": 7000}}",
     PEN_TOO_LARGE, "/render", "pictures to be compared have"},
    {"{\"scene\": S, \"matrix\": {}}", PEN_INVALID, "/matrix",
     "belongs to jobs of kind \"benchmark\""},
    {"{\"scene\": S, \"ladder\": {}}", PEN_INVALID, "/ladder",
     "belongs to jobs of kind \"accuracy\""},
    {"{\"scene\": S, \"priority\": 101}", PEN_INVALID, "/priority", "from -100 to 100, found 101"},
    {"{\"scene\": S, \"priority\": -101}", PEN_INVALID, "/priority", "from -100 to 100"},
    {"{\"scene\": S, \"priority\": 0.5}", PEN_INVALID, "/priority", "integer"},
    {"{\"scene\": S, \"priority\": \"1\"}", PEN_INVALID, "/priority", "found the string \"1\""},
    {"{\"scene\": S, \"max_attempts\": 0}", PEN_INVALID, "/max_attempts", "from 1 to 10"},
    {"{\"scene\": S, \"max_attempts\": 11}", PEN_INVALID, "/max_attempts", "from 1 to 10"},
    {"{\"scene\": S, \"timeout_seconds\": 0}", PEN_INVALID, "/timeout_seconds", "above 0"},
    {"{\"scene\": S, \"timeout_seconds\": -1}", PEN_INVALID, "/timeout_seconds", "above 0"},
    {"{\"scene\": S, \"timeout_seconds\": null}", PEN_INVALID, "/timeout_seconds", "found null"},
    {"{\"scene\": S, \"name\": 3}", PEN_INVALID, "/name", "found 3"},
    {"{\"scene\": S, \"labels\": []}", PEN_INVALID, "/labels", "found an empty array"},
    {"{\"scene\": S, \"labels\": {\"a\": 1}}", PEN_INVALID, "/labels/a", "found 1"},
    {"{\"scene\": S, \"labels\": {\"\": \"x\"}}", PEN_INVALID, "/labels/",
     "a key of 1 to 200 characters without a colon, which lists take for its end, found \"\""},
    {"{\"scene\": S, \"labels\": {\"a:b\": \"x\"}}", PEN_INVALID, "/labels/a:b", "without a colon"},
    {"{\"scene\": S, \"layers\": \"beauty\"}", PEN_INVALID, "/layers", "found the string"},
    {"{\"scene\": S, \"layers\": []}", PEN_INVALID, "/layers", "array"},
    {"{\"scene\": S, \"layers\": [\"beuty\"]}", PEN_INVALID, "/layers/0",
     "did you mean \"beauty\"?"},
    {"{\"scene\": S, \"layers\": [\"beauty\", \"cost\"], \"cost\": \"rays\"}", PEN_INVALID, "/cost",
     "time"},
    {"{\"scene\": S, \"kind\": \"benchmark\", \"cost\": \"time\"}", PEN_INVALID, "/cost", "render"},
    {"{\"scene\": S, \"layers\": [\"beauty\", \"beauty\"]}", PEN_INVALID, "/layers/1",
     "\"beauty\" is there twice"},
    {"{\"scene\": S, \"views\": \"main\"}", PEN_INVALID, "/views", "array"},
    {"{\"scene\": S, \"views\": []}", PEN_INVALID, "/views", "array"},
    {"{\"scene\": S, \"views\": [\"mian\"]}", PEN_INVALID, "/views/0", "did you mean \"main\"?"},
    {"{\"scene\": S, \"views\": [\"all\"]}", PEN_INVALID, "/views/0", "found the string \"all\""},
    {"{\"scene\": S, \"views\": [7]}", PEN_INVALID, "/views/0", "such as \"main\", found 7"},
    {"{\"scene\": S, \"render\": {\"width\": 0}}", PEN_INVALID, "/render/width", ""},
    {"{\"scene\": S, \"render\": {\"widht\": 10}}", PEN_INVALID, "/render/widht", "width"},
    {"{\"scene\": S, \"render\": {\"precision\": \"fast\"}}", PEN_UNSUPPORTED, "/render/precision",
     ""},
    {"{\"scene\": S, \"render\": {\"width\": 10000, \"height\": 10000}}", PEN_TOO_LARGE, "/render",
     ""},
    {"{\"scene\": S, \"render\": {\"samples_per_pixel\": 2000000000}}", PEN_TOO_LARGE, "/render",
     ""},
};

static bool submit(const char *body, const char *key, struct pen_submitted *out,
                   struct pen_errors *errors)
{
    struct pen_submission in = {.body = body, .bytes = strlen(body), .idempotency_key = key};
    *errors = (struct pen_errors){0};
    return pen_jobs_submit(bed.jobs, &in, out, errors);
}

/* Puts the scene where the S is. */
static char *expand(const char *body)
{
    const char *scene = jobs_scene("");
    char *text = malloc(strlen(body) + 2 * strlen(scene) + 1), *to = text;
    for (; *body; body++) {
        if (*body == 'S')
            to += sprintf(to, "%s", scene);
        else
            *to++ = *body;
    }
    *to = '\0';
    return text;
}

static void expect_nothing_stored(void)
{
    struct pen_list_query query = {.state = -1, .limit = 10};
    struct pen_status st;
    json_t *list = pen_jobs_list(bed.jobs, &query, &st);
    ck_assert_uint_eq(json_array_size(json_object_get(list, "jobs")), 0);
    json_decref(list);
}

START_TEST(test_submit__each_bad_body_is_refused_at_its_place)
{
    jobs_bed_open(&bed);
    for (size_t i = 0; i < sizeof bad_bodies / sizeof bad_bodies[0]; i++) {
        const struct bad *bad = &bad_bodies[i];
        struct pen_submitted out;
        struct pen_errors errors;
        char *body = expand(bad->body);
        ck_assert_msg(!submit(body, NULL, &out, &errors), "accepted: %s", bad->body);
        const struct pen_status *e = &errors.item[0];
        ck_assert_msg(e->code == bad->code, "%s: %s: %s", bad->body, pen_code_name(e->code),
                      e->msg);
        ck_assert_msg(strcmp(e->at, bad->at) == 0, "%s: at %s: %s", bad->body, e->at, e->msg);
        ck_assert_msg(strstr(e->msg, bad->words) != NULL, "%s: %s", bad->body, e->msg);
        ck_assert_msg(e->code != PEN_SYNTAX || e->line > 0, "%s: no line", bad->body);
        free(body);
    }
    expect_nothing_stored();
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__errors_of_job_and_scene_are_collected)
{
    static const char body[] =
        "{\"priority\": 1000, \"scene\": {\"format\": \"penumbra-scene/1\", \"camera\":"
        " {\"position\": [0, 0, 1], \"look_at\": [0, 0, 0]}, \"objects\": [{\"type\": \"sphere\","
        " \"center\": [0, 0, 0], \"radius\": -1}]}, \"render\": {\"tile\": 0}}";
    struct pen_submitted out;
    struct pen_errors errors;
    jobs_bed_open(&bed);
    ck_assert(!submit(body, NULL, &out, &errors));
    ck_assert_uint_eq(errors.count, 3);
    ck_assert_str_eq(errors.item[0].at, "/priority");
    ck_assert_str_eq(errors.item[1].at, "/scene/objects/0/radius");
    ck_assert_str_eq(errors.item[2].at, "/render/tile");
    jobs_bed_close(&bed);
}
END_TEST

/* Opens another handle, with this limit on timeouts, and submits the body there. */
static bool submit_with_limit(int timeout_seconds, const char *body, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_submitted out;
    struct pen_submission in = {.body = body, .bytes = strlen(body)};
    struct pen_status st;
    limits.timeout_seconds = timeout_seconds;
    struct pen_jobs *jobs = pen_jobs_open(bed.bed.url, &limits, &st);
    store_must(jobs != NULL, &st, "open");
    *errors = (struct pen_errors){0};
    bool ok = pen_jobs_submit(jobs, &in, &out, errors);
    if (ok)
        memcpy(id, out.id, sizeof id);
    pen_buf_release(&out.answer);
    pen_jobs_close(jobs);
    return ok;
}

static void check_timeout(double seconds)
{
    json_t *job = jobs_get(&bed, id);
    ck_assert_double_eq(json_number_value(json_object_get(job, "timeout_seconds")), seconds);
    json_decref(job);
}

START_TEST(test_submit__timeouts_are_those_that_the_operator_allows)
{
    struct pen_errors errors;
    char body[8192];
    jobs_bed_open(&bed);
    ck_assert(submit_with_limit(60, jobs_scene(""), &errors));
    check_timeout(60); /* a bare scene */
    snprintf(body, sizeof body, "{\"scene\": %s}", jobs_scene(""));
    ck_assert(submit_with_limit(60, body, &errors));
    check_timeout(60);
    ck_assert(submit_with_limit(100000, body, &errors));
    check_timeout(86400);
    snprintf(body, sizeof body, "{\"timeout_seconds\": 60, \"scene\": %s}", jobs_scene(""));
    ck_assert(submit_with_limit(60, body, &errors));
    check_timeout(60);
    snprintf(body, sizeof body, "{\"timeout_seconds\": 60.5, \"scene\": %s}", jobs_scene(""));
    ck_assert(!submit_with_limit(60, body, &errors));
    ck_assert_int_eq(errors.item[0].code, PEN_INVALID);
    ck_assert_str_eq(errors.item[0].at, "/timeout_seconds");
    ck_assert_str_eq(errors.item[0].msg, "must be a number above 0, at most 60, which this daemon "
                                         "allows, found 60.5");
    ck_assert(submit_with_limit(61, body, &errors));
    check_timeout(60.5);
    jobs_bed_close(&bed);
}
END_TEST

/* Rays that take no time without forking paths, and too much with them. */
START_TEST(test_submit__exploding_paths_count_as_work)
{
    static const char scene[] =
        "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9], \"look_at\":"
        " [0, 0, 0]}, \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1,"
        " \"material\": {\"kr\": %d, \"kt\": 1}}]}";
    struct pen_submitted out;
    struct pen_errors errors;
    char text[400], body[800];
    jobs_bed_open(&bed);
    for (int kr = 0; kr < 2; kr++) {
        snprintf(text, sizeof text, scene, kr);
        snprintf(body, sizeof body,
                 "{\"render\": {\"width\": 2500, \"height\": 2000, \"samples_per_pixel\":"
                 " 1000, \"max_depth\": 60}, \"scene\": %s}",
                 text);
        ck_assert(submit(body, NULL, &out, &errors) == (kr == 0));
        if (kr == 0)
            pen_buf_release(&out.answer);
    }
    ck_assert_int_eq(errors.item[0].code, PEN_TOO_LARGE);
    ck_assert_str_eq(errors.item[0].at, "/render");
    ck_assert_ptr_nonnull(strstr(errors.item[0].msg, "lower it to 10,"));
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__too_many_bytes_and_labels_are_refused)
{
    struct pen_submitted out;
    struct pen_errors errors;
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    jobs_bed_open(&bed);
    limits.body_bytes = 100;
    struct pen_jobs *small = pen_jobs_open(bed.bed.url, &limits, &st);
    struct pen_submission in = {.body = jobs_scene(""), .bytes = strlen(jobs_scene(""))};
    errors = (struct pen_errors){0};
    ck_assert(!pen_jobs_submit(small, &in, &out, &errors));
    ck_assert_int_eq(errors.item[0].code, PEN_TOO_LARGE);
    pen_jobs_close(small);
    char body[8192];
    int n =
        snprintf(body, sizeof body, "{\"scene\": %s, \"labels\": {\"k0\": \"\"", jobs_scene(""));
    for (int i = 1; i <= 32; i++)
        n += snprintf(body + n, sizeof body - (size_t)n, ", \"k%d\": \"v\"", i);
    snprintf(body + n, sizeof body - (size_t)n, "}}");
    ck_assert(!submit(body, NULL, &out, &errors));
    ck_assert_str_eq(errors.item[0].at, "/labels");
    n = snprintf(body, sizeof body, "{\"scene\": %s, \"name\": \"", jobs_scene(""));
    memset(body + n, 'x', 201);
    strcpy(body + n + 201, "\"}");
    ck_assert(!submit(body, NULL, &out, &errors));
    ck_assert_str_eq(errors.item[0].at, "/name");
    strcpy(body + n + 200, "\"}");
    jobs_submit(&bed, body, id);
    jobs_bed_close(&bed);
}
END_TEST

/* A job whose labels are `count` control characters in all, a hundred in each; an even count. */
static void write_labels(struct pen_buf *body, int count)
{
    pen_buf_printf(body, "{\"scene\": %s, \"labels\": {", jobs_scene(""));
    for (int i = 0; i < count; i++)
        pen_buf_printf(body,
                       i % 100 ? "\\u0001"
                       : i     ? "\", \"k%d\": \"\\u0001"
                               : "\"k%d\": \"\\u0001",
                       i / 100);
    pen_buf_puts(body, "\"}, \"name\": \"n\"}");
    ck_assert(!body->failed);
}

/* A control character is one for the client, and six bytes in every answer. */
START_TEST(test_submit__name_and_labels_are_bounded_together)
{
    struct pen_submitted out;
    struct pen_errors errors;
    jobs_bed_open(&bed);
    for (int many = 0; many < 2; many++) {
        struct pen_buf body = {0};
        write_labels(&body, many ? 1400 : 1300);
        const bool ok = submit((const char *)body.data, NULL, &out, &errors);
        ck_assert_msg(ok == !many, "%s", ok ? "" : errors.item[0].msg);
        if (!ok) {
            ck_assert_uint_eq(errors.count, 1);
            ck_assert_str_eq(errors.item[0].at, "/labels");
            /* {"k0":"…", … "k13":"…"} and "n" */
            ck_assert_ptr_nonnull(strstr(errors.item[0].msg, "at most 8192 bytes"));
            ck_assert_ptr_nonnull(strstr(errors.item[0].msg, "found 8520"));
        }
        pen_buf_release(&out.answer);
        pen_buf_release(&body);
    }
    jobs_bed_close(&bed);
}
END_TEST

/* Writes text of `count` times U+00FC, of two bytes. */
static int write_umlauts(char *out, int count)
{
    for (int i = 0; i < count; i++)
        memcpy(out + 2 * i, "\xC3\xBC", 3);
    return 2 * count;
}

/* As the schema counts, in characters. */
START_TEST(test_submit__lengths_are_those_of_characters)
{
    static const struct {
        int name, label, key, idempotency;
        const char *at; /* NULL: accepted */
    } cases[] = {{200, 200, 200, 255, NULL},
                 {201, 1, 1, 1, "/name"},
                 {1, 201, 1, 1, "/labels/"},
                 {1, 1, 201, 1, "/labels/"},
                 {1, 1, 1, 256, ""}};
    jobs_bed_open(&bed);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct pen_submitted out = {0};
        struct pen_errors errors;
        char body[8192], key[600];
        int n = snprintf(body, sizeof body, "{\"scene\": %s, \"name\": \"", jobs_scene(""));
        n += write_umlauts(body + n, cases[i].name);
        n += snprintf(body + n, 100, "\", \"labels\": {\"");
        n += write_umlauts(body + n, cases[i].key);
        n += snprintf(body + n, 100, "\": \"");
        n += write_umlauts(body + n, cases[i].label);
        snprintf(body + n, 100, "\"}}");
        write_umlauts(key, cases[i].idempotency);
        bool ok = submit(body, key, &out, &errors);
        ck_assert_msg(ok == !cases[i].at, "case %zu: %s", i, errors.item[0].msg);
        if (!ok)
            ck_assert_int_eq(strncmp(errors.item[0].at, cases[i].at, strlen(cases[i].at)), 0);
        pen_buf_release(&out.answer);
    }
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__xml_is_a_bare_scene_and_is_returned_as_sent)
{
    static const char xml[] = "<scene name='x'><render width='8' height='6'/><geometries>"
                              "<sphere center='0 0 -9' radius='2'/></geometries></scene>";
    struct pen_submission in = {.body = xml, .bytes = sizeof xml - 1, .xml = true};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    struct pen_status st;
    struct pen_buf scene = {0};
    jobs_bed_open(&bed);
    ck_assert(pen_jobs_submit(bed.jobs, &in, &out, &errors));
    json_t *job = json_loadb((char *)out.answer.data, out.answer.bytes, 0, NULL);
    const json_t *render = json_object_get(job, "render");
    ck_assert_int_eq(json_integer_value(json_object_get(render, "width")), 8);
    ck_assert_str_eq(json_string_value(json_object_get(render, "transfer")), "display");
    store_must(pen_store_scene(pen_jobs_store(bed.jobs), out.id, &scene, &st), &st, "scene");
    ck_assert_str_eq((char *)scene.data, xml);
    json_decref(job);
    pen_buf_release(&scene);
    pen_buf_release(&out.answer);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__xml_errors_have_lines)
{
    static const char wide[] = "<scene>\n <camera position='0 0 9' look-at='0 0 0' "
                               "image='9000 9000'/></scene>";
    struct pen_submission in = {.body = wide, .bytes = sizeof wide - 1, .xml = true};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    jobs_bed_open(&bed);
    ck_assert(!pen_jobs_submit(bed.jobs, &in, &out, &errors));
    ck_assert_uint_eq(errors.count, 1);
    ck_assert_int_eq(errors.item[0].code, PEN_TOO_LARGE);
    ck_assert_int_eq(errors.item[0].line, 2);
    ck_assert_int_eq(errors.item[0].column, 2);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__xml_may_be_a_string_in_a_job)
{
    static const char good[] = "{\"scene\": \" <scene><render width='8' height='6'/></scene>\", "
                               "\"render\": {\"width\": 4}}";
    static const char wrong[] = "{\"scene\": \"<scene>\\n <camra/></scene>\"}";
    struct pen_submission in = {.body = good, .bytes = sizeof good - 1};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    jobs_bed_open(&bed);
    ck_assert(pen_jobs_submit(bed.jobs, &in, &out, &errors));
    json_t *job = json_loadb((char *)out.answer.data, out.answer.bytes, 0, NULL);
    const json_t *render = json_object_get(job, "render");
    ck_assert_int_eq(json_integer_value(json_object_get(render, "width")), 4);
    ck_assert_int_eq(json_integer_value(json_object_get(render, "height")), 6);
    json_decref(job);
    pen_buf_release(&out.answer);
    in = (struct pen_submission){.body = wrong, .bytes = sizeof wrong - 1};
    ck_assert(!pen_jobs_submit(bed.jobs, &in, &out, &errors));
    ck_assert_int_eq(errors.item[0].line, 2); /* of the text in the string */
    ck_assert_int_eq(errors.item[0].column, 2);
    jobs_bed_close(&bed);
}
END_TEST

static const char *text_of(const json_t *job, const char *key)
{
    return json_string_value(json_object_get(job, key));
}

static double number_of(const json_t *job, const char *key)
{
    return json_number_value(json_object_get(job, key));
}

START_TEST(test_submit__bare_scene_is_a_job_with_defaults)
{
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(", \"render\": {\"width\": 30, \"height\": 20, \"seed\": 7}"), id);
    json_t *job = jobs_get(&bed, id);
    ck_assert_str_eq(text_of(job, "id"), id);
    ck_assert_str_eq(text_of(job, "state"), "queued");
    ck_assert_str_eq(text_of(job, "kind"), "render");
    ck_assert(json_is_null(json_object_get(job, "name")));
    ck_assert_uint_eq(json_object_size(json_object_get(job, "labels")), 0);
    ck_assert(number_of(job, "priority") == 0);
    ck_assert(number_of(job, "max_attempts") == 3);
    ck_assert(number_of(job, "attempts") == 0);
    ck_assert(number_of(job, "revision") == 1);
    ck_assert(number_of(job, "timeout_seconds") == 86400);
    ck_assert(json_is_null(json_object_get(job, "started_at")));
    ck_assert(json_is_null(json_object_get(job, "finished_at")));
    ck_assert(json_is_null(json_object_get(job, "error")));
    ck_assert_uint_eq(strlen(text_of(job, "created_at")), 24);
    json_t *views = json_object_get(job, "views"), *layers = json_object_get(job, "layers");
    ck_assert_uint_eq(json_array_size(views), 1);
    ck_assert_str_eq(json_string_value(json_array_get(views, 0)), "main");
    ck_assert_uint_eq(json_array_size(layers), 1);
    ck_assert_str_eq(json_string_value(json_array_get(layers, 0)), "beauty");
    json_t *progress = json_object_get(job, "progress"), *render = json_object_get(job, "render");
    ck_assert(number_of(progress, "done") == 0);
    ck_assert(number_of(progress, "total") == 600);
    ck_assert(number_of(progress, "fraction") == 0);
    ck_assert(json_is_null(json_object_get(progress, "eta_seconds")));
    ck_assert(number_of(render, "width") == 30);
    ck_assert(number_of(render, "seed") == 7);
    ck_assert(number_of(render, "light_samples") == 16);
    ck_assert_str_eq(text_of(render, "accelerator"), "auto");
    json_t *links = json_object_get(job, "links");
    char expected[80];
    snprintf(expected, sizeof expected, "/v1/jobs/%s/image", id);
    ck_assert_str_eq(text_of(links, "image"), expected);
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

static bool has_text(const json_t *list, const char *text)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        if (strcmp(json_string_value(json_array_get(list, i)), text) == 0)
            return true;
    }
    return false;
}

START_TEST(test_submit__job_keys_are_kept_and_render_overrides_the_scene)
{
    char body[8192];
    jobs_bed_open(&bed);
    snprintf(
        body, sizeof body,
        "{\"scene\": %s, \"priority\": -7.0, \"name\": \"n\\u00e4chtlich\", \"labels\":"
        " {\"shot\": \"12\"}, \"max_attempts\": 5, \"timeout_seconds\": 1.5, \"kind\":"
        " \"render\", \"layers\": [\"beauty\"], \"views\": [\"b\"], \"render\": {\"height\":"
        " 40, \"samples_per_pixel\": 4, \"accelerator\": \"none\", \"transfer\": \"linear\"}}",
        jobs_scene(", \"views\": [{\"name\": \"a\"}, {\"name\": \"b\"}], \"render\": {\"width\":"
                   " 20, \"height\": 30}"));
    jobs_submit(&bed, body, id);
    json_t *job = jobs_get(&bed, id), *render = json_object_get(job, "render");
    ck_assert(number_of(job, "priority") == -7);
    ck_assert_str_eq(text_of(job, "name"), "n\xc3\xa4"
                                           "chtlich");
    ck_assert_str_eq(text_of(json_object_get(job, "labels"), "shot"), "12");
    ck_assert(number_of(job, "max_attempts") == 5);
    ck_assert(number_of(job, "timeout_seconds") == 1.5);
    ck_assert_uint_eq(json_array_size(json_object_get(job, "views")), 1);
    ck_assert(has_text(json_object_get(job, "views"), "b"));
    ck_assert(number_of(render, "width") == 20);
    ck_assert(number_of(render, "height") == 40);
    ck_assert(number_of(render, "samples_per_pixel") == 4);
    ck_assert_str_eq(text_of(render, "accelerator"), "none");
    ck_assert_str_eq(text_of(render, "transfer"), "linear");
    ck_assert(number_of(json_object_get(job, "progress"), "total") == 800);
    const json_t *effects = json_object_get(job, "effects");
    ck_assert(has_text(effects, "ambient") && has_text(effects, "hard_shadows"));
    ck_assert(has_text(effects, "mirror") && has_text(effects, "specular"));
    ck_assert(has_text(effects, "anti_aliasing") && !has_text(effects, "transmission"));
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

/* The settings in an answer can be sent back, and give the same answer. */
START_TEST(test_submit__effective_settings_read_back_as_themselves)
{
    struct pen_errors errors = {0};
    jobs_bed_open(&bed);
    jobs_submit(
        &bed,
        jobs_scene(", \"render\": {\"width\": 31, \"height\": 21, \"samples_per_pixel\": 3,"
                   " \"light_samples\": 5, \"light_pattern\": \"grid\", \"blur_samples\": 6,"
                   " \"lens_samples\": 7, \"max_depth\": 8, \"min_contribution\": 0.1,"
                   " \"max_samples\": 9, \"accelerator\": \"none\", \"transfer\":"
                   " \"linear\", \"seed\": 9007199254740992, \"tile\": 10, \"threads\": 2}"),
        id);
    json_t *job = jobs_get(&bed, id);
    struct pen_settings s = pen_settings_default();
    ck_assert(pen_settings_read(json_object_get(job, "render"), "", &s, &errors));
    ck_assert(s.width == 31 && s.height == 21 && s.samples_per_pixel == 3 && s.light_samples == 5);
    ck_assert(s.light_pattern == PEN_PATTERN_GRID && s.blur_samples == 6 && s.lens_samples == 7);
    ck_assert(s.max_depth == 8 && s.min_contribution == 0.1 && s.max_samples == 9);
    ck_assert(s.accelerator == PEN_ACCEL_NONE && s.transfer == PEN_SETTING_LINEAR);
    ck_assert(s.seed == 9007199254740992u && s.tile == 10 && s.threads == 2);
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__answer_is_the_stored_job)
{
    struct pen_submitted out;
    struct pen_errors errors;
    jobs_bed_open(&bed);
    ck_assert(submit(jobs_scene(""), NULL, &out, &errors));
    json_t *answer = json_loads((char *)out.answer.data, 0, NULL);
    json_t *job = jobs_get(&bed, out.id);
    ck_assert(json_equal(answer, job));
    json_decref(answer);
    json_decref(job);
    pen_buf_release(&out.answer);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__scene_is_returned_as_sent)
{
    const char *scene = jobs_scene("");
    struct pen_status st;
    struct pen_buf out = {0};
    char body[4200];
    jobs_bed_open(&bed);
    jobs_submit(&bed, scene, id);
    store_must(pen_store_scene(pen_jobs_store(bed.jobs), id, &out, &st), &st, "scene");
    ck_assert_str_eq((char *)out.data, scene);
    pen_buf_release(&out);
    snprintf(body, sizeof body, "{\"scene\": %s}", scene);
    jobs_submit(&bed, body, id);
    store_must(pen_store_scene(pen_jobs_store(bed.jobs), id, &out, &st), &st, "scene");
    json_t *sent = json_loads(scene, 0, NULL), *stored = json_loads((char *)out.data, 0, NULL);
    ck_assert(json_equal(sent, stored));
    json_decref(sent);
    json_decref(stored);
    pen_buf_release(&out);
    jobs_submit(&bed, "{\"scene\": \"builtin:spheres\"}", id);
    store_must(pen_store_scene(pen_jobs_store(bed.jobs), id, &out, &st), &st, "scene");
    ck_assert_ptr_nonnull(strstr((char *)out.data, "penumbra-scene/1"));
    pen_buf_release(&out);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__key_repeats_the_answer_and_refuses_another_body)
{
    struct pen_submitted first, again;
    struct pen_errors errors;
    char text[4096];
    jobs_bed_open(&bed);
    snprintf(text, sizeof text, "%s", jobs_scene(""));
    ck_assert(submit(text, "key-1", &first, &errors));
    ck_assert(submit(text, "key-1", &again, &errors));
    ck_assert_str_eq(first.id, again.id);
    ck_assert_uint_eq(first.answer.bytes, again.answer.bytes);
    ck_assert_mem_eq(first.answer.data, again.answer.data, first.answer.bytes);
    pen_buf_release(&again.answer);
    ck_assert(!submit(jobs_scene(", \"name\": \"other\""), "key-1", &again, &errors));
    ck_assert_int_eq(errors.item[0].code, PEN_INVALID);
    ck_assert_str_eq(errors.item[0].at, "");
    ck_assert(submit(text, "key-2", &again, &errors));
    ck_assert_str_ne(first.id, again.id);
    pen_buf_release(&first.answer);
    pen_buf_release(&again.answer);
    ck_assert(!submit(text, "", &again, &errors));
    ck_assert_int_eq(errors.item[0].code, PEN_USAGE);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__key_is_of_its_client)
{
    const char *body = jobs_scene("");
    struct pen_submission in = {.body = body, .bytes = strlen(body), .idempotency_key = "k"};
    struct pen_submitted out[3];
    struct pen_errors errors = {0};
    jobs_bed_open(&bed);
    for (int i = 0; i < 3; i++) {
        in.client = i == 1 ? "address:10.0.0.1" : "token:a";
        ck_assert(pen_jobs_submit(bed.jobs, &in, &out[i], &errors));
        pen_buf_release(&out[i].answer);
    }
    ck_assert_str_ne(out[0].id, out[1].id);
    ck_assert(!out[1].repeated && out[2].repeated);
    ck_assert_str_eq(out[0].id, out[2].id);
    jobs_bed_close(&bed);
}
END_TEST

/* Of a job of many kinds of members, after it has ended; and the key costs the store little. */
START_TEST(test_submit__first_answer_is_made_again_from_the_job)
{
    struct pen_submitted first, again;
    struct pen_errors errors;
    struct pen_status st;
    char body[16384];
    jobs_bed_open(&bed);
    int n =
        snprintf(body, sizeof body,
                 "{\"scene\": %s, \"name\": \"\\u00fc\", \"timeout_seconds\": 12.1, \"layers\":"
                 " [\"beauty\", \"cost\"], \"audit\": {\"pixels\": 9}, \"render\": {\"width\": 9,"
                 " \"height\": 7, \"target_error\": 0.0123}, \"labels\": {\"k\": \"\"",
                 jobs_scene(""));
    for (int i = 1; i < 32; i++)
        n += snprintf(body + n, sizeof body - (size_t)n, ", \"k%d\": \"%0*d\"", i, 200, i);
    snprintf(body + n, sizeof body - (size_t)n, "}}");
    ck_assert_msg(submit(body, "key-1", &first, &errors), "%s: %s", errors.item[0].at,
                  errors.item[0].msg);
    ck_assert_uint_gt(first.answer.bytes, 32 * 200);
    ck_assert(pen_store_cancel(bed.bed.store, first.id, NULL, &st));
    ck_assert(submit(body, "key-1", &again, &errors));
    ck_assert_str_eq(again.id, first.id);
    ck_assert_uint_eq(again.answer.bytes, first.answer.bytes);
    ck_assert_mem_eq(again.answer.data, first.answer.data, first.answer.bytes);
    pen_buf_release(&again.answer);
    pen_buf_release(&first.answer);
    store_run_sql(&bed.bed, "SELECT key FROM key WHERE length(answer) > 100", NULL, 0);
    ck_assert(pen_jobs_delete(bed.jobs, first.id, NULL, true, &st));
    ck_assert(!submit(body, "key-1", &again, &errors));
    ck_assert_int_eq(errors.item[0].code, PEN_GONE);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__ids_are_uuids_of_their_time_in_order)
{
    char last[PEN_ID_BYTES] = "";
    jobs_bed_open(&bed);
    for (int i = 0; i < 5; i++) {
        jobs_submit(&bed, jobs_scene(""), id);
        ck_assert_uint_eq(strlen(id), 36);
        ck_assert_int_eq(id[14], '7');
        ck_assert_ptr_nonnull(strchr("89ab", id[19]));
        ck_assert_uint_eq(strspn(id, "0123456789abcdef-"), 36);
        ck_assert_int_le(strncmp(last, id, 13), 0);
        memcpy(last, id, sizeof last);
    }
    jobs_bed_close(&bed);
}
END_TEST

/* The batches of a view, one after the other, hold all of its tiles. */
struct cover {
    int view, next_tile;
    int64_t pixels;
};

static void check_cover(struct cover *cover, const struct store_batch *batch)
{
    if (batch->view != cover->view)
        *cover = (struct cover){.view = batch->view, .pixels = cover->pixels};
    ck_assert_int_eq(batch->first_tile, cover->next_tile);
    ck_assert_int_gt(batch->tile_count, 0);
    cover->next_tile += batch->tile_count;
    cover->pixels += batch->pixels;
}

START_TEST(test_submit__batches_cover_every_tile_once)
{
    static const int sizes[][3] = {{1, 1, 32},     {33, 31, 32},  {800, 600, 32}, {999, 777, 7},
                                   {640, 480, 64}, {5, 9000, 16}, {9000, 5, 3},   {97, 89, 100}};
    char body[4096];
    jobs_bed_open(&bed);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        snprintf(body, sizeof body,
                 ", \"views\": [{\"name\": \"a\"}, {\"name\": \"b\"}], \"render\": {\"width\": %d,"
                 " \"height\": %d, \"tile\": %d, \"samples_per_pixel\": 50}",
                 sizes[i][0], sizes[i][1], sizes[i][2]);
        jobs_submit(&bed, jobs_scene(body), id);
        static struct store_batch batch[20000];
        struct cover cover = {0};
        const int count = store_batches(bed.bed.url, id, batch, 20000);
        for (int k = 0; k < count; k++)
            check_cover(&cover, &batch[k]);
        ck_assert_int_eq(cover.view, 1);
        const int edge = sizes[i][2] < 64 ? sizes[i][2] : 64;
        ck_assert_int_eq(cover.next_tile, pen_tile_count(sizes[i][0], sizes[i][1], edge));
        ck_assert_int_eq(cover.pixels, (int64_t)2 * sizes[i][0] * sizes[i][1]);
    }
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_submit__validate_gives_the_same_errors_and_stores_nothing)
{
    json_t *answer = NULL;
    jobs_bed_open(&bed);
    for (size_t i = 0; i < sizeof bad_bodies / sizeof bad_bodies[0]; i++) {
        struct pen_errors errors = {0};
        char *body = expand(bad_bodies[i].body);
        struct pen_submission in = {.body = body, .bytes = strlen(body)};
        ck_assert(!pen_jobs_validate(bed.jobs, &in, &answer, &errors));
        ck_assert_ptr_null(answer);
        ck_assert_int_eq(errors.item[0].code, bad_bodies[i].code);
        free(body);
    }
    struct pen_errors errors = {0};
    struct pen_submission in = {.body = jobs_scene(""), .bytes = strlen(jobs_scene(""))};
    ck_assert(pen_jobs_validate(NULL, &in, &answer, &errors));
    ck_assert(json_is_true(json_object_get(answer, "valid")));
    ck_assert(json_is_array(json_object_get(answer, "warnings")));
    json_decref(answer);
    expect_nothing_stored();
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("submit", test_submit__each_bad_body_is_refused_at_its_place,
          test_submit__errors_of_job_and_scene_are_collected,
          test_submit__too_many_bytes_and_labels_are_refused,
          test_submit__name_and_labels_are_bounded_together,
          test_submit__lengths_are_those_of_characters,
          test_submit__timeouts_are_those_that_the_operator_allows,
          test_submit__exploding_paths_count_as_work,
          test_submit__xml_is_a_bare_scene_and_is_returned_as_sent,
          test_submit__xml_errors_have_lines, test_submit__xml_may_be_a_string_in_a_job,
          test_submit__bare_scene_is_a_job_with_defaults,
          test_submit__job_keys_are_kept_and_render_overrides_the_scene,
          test_submit__effective_settings_read_back_as_themselves,
          test_submit__answer_is_the_stored_job, test_submit__scene_is_returned_as_sent,
          test_submit__key_repeats_the_answer_and_refuses_another_body,
          test_submit__key_is_of_its_client, test_submit__first_answer_is_made_again_from_the_job,
          test_submit__ids_are_uuids_of_their_time_in_order,
          test_submit__batches_cover_every_tile_once,
          test_submit__validate_gives_the_same_errors_and_stores_nothing)
