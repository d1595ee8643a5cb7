/* SPDX-License-Identifier: MIT */
/* Writes the errors of failed jobs, and logs them. */
#include "jobs/internal/failure.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "jobs/internal/job_json.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/stored_request.h"

enum { LOG_LINES = 12, LOG_BYTES = 4096 };

/* Where a job failed: the batch, and the pixel in it. x < 0: the pixel is not known. */
struct place {
    const struct pen_claim *claim;
    int x, y;
};

static struct place place_of(const struct pen_claim *claim, const struct pen_trace *trace)
{
    struct place place = {.claim = claim};
    if (!trace || claim->kind == PEN_BATCH_ASSEMBLE || !pen_trace_where(trace, &place.x, &place.y))
        place.x = place.y = -1;
    return place;
}

/* Appends a text, quoted for a shell. */
static void add_quoted(struct pen_buf *out, const char *text)
{
    pen_buf_puts(out, "'");
    for (; *text; text++)
        pen_buf_printf(out, *text == '\'' ? "'\\''" : "%c", *text);
    pen_buf_puts(out, "'");
}

/* Appends the value of a setting in the form of the command line: words without quotes. */
static void add_value(struct pen_buf *out, const json_t *value)
{
    char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(17));
    const char *word = json_string_value(value);
    pen_buf_puts(out, word ? word : text ? text : "");
    free(text);
}

/* Appends values with commas between them. */
static void add_values(struct pen_buf *out, const json_t *value)
{
    if (!json_is_array(value))
        add_value(out, value);
    for (size_t i = 0; i < json_array_size(value); i++) {
        pen_buf_puts(out, i ? "," : "");
        add_value(out, json_array_get(value, i));
    }
}

/* Appends a member of the request as options. An object gives an option for each of its members,
 * KEY=VALUE,… */
static void add_option(struct pen_buf *out, const char *option, const json_t *member)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)member, key, value)
    {
        pen_buf_printf(out, " --%s %s=", option, key);
        add_values(out, value);
    }
    if (json_is_true(member))
        pen_buf_printf(out, " --%s", option);
    if (!json_is_number(member))
        return;
    pen_buf_printf(out, " --%s ", option);
    add_value(out, member);
}

/* Appends the options of a study, for the members that it has. */
static void add_study(struct pen_buf *out, const json_t *request)
{
    static const struct {
        const char *key, *option;
    } members[] = {{"matrix", "matrix"},
                   {"ladder", "ladder"},
                   {"product", "product"},
                   {"reference", "reference"},
                   {"repeats", "repeats"},
                   {"warmup", "warmup"},
                   {"interval", "interval"},
                   {"budget_seconds", "budget"},
                   {"least_effect", "least-effect"},
                   {"order_seed", "order-seed"},
                   {"seeds", "seeds"},
                   {"analyze", "analyze"}};
    const json_t *target = json_object_get(request, "target");
    for (size_t i = 0; i < sizeof members / sizeof members[0]; i++)
        add_option(out, members[i].option, json_object_get(request, members[i].key));
    if (!target)
        return;
    pen_buf_printf(out, " --target %s=", json_string_value(json_object_get(target, "metric")));
    add_value(out, json_object_get(target, "value"));
}

/* Appends --view options: all views of a study, else the batch's view. */
static void add_views(struct pen_buf *out, const struct place *place,
                      const struct pen_stored_request *request)
{
    bool all = place->claim->kind == PEN_BATCH_STUDY;
    for (int i = 0; i < request->view_count; i++) {
        const char *view = pen_stored_request_view(request, i);
        if (!all && i != place->claim->view)
            continue;
        pen_buf_puts(out, " --view ");
        add_quoted(out, view ? view : "");
    }
}

/* Returns the command line that repeats the failure. */
static json_t *repeat_json(const struct place *place, const struct pen_stored_request *request)
{
    struct pen_buf line = {0};
    const bool study = place->claim->kind == PEN_BATCH_STUDY;
    pen_buf_printf(&line, "curl -s \"$PENUMBRA_URL/v1/jobs/%s/scene\" | penumbra %s -",
                   place->claim->job_id,
                   request->kind == PEN_KIND_BENCHMARK ? "bench" : pen_job_kinds[request->kind]);
    add_views(&line, place, request);
    /* All settings, because the scene's own may differ from the job's. */
    add_option(&line, "set", json_object_get(request->json, "render"));
    if (study)
        add_study(&line, request->json);
    else if (place->x >= 0)
        pen_buf_printf(&line, " --pixel %d,%d", place->x, place->y);
    else
        pen_buf_puts(&line, " -o out.png");
    json_t *json = line.failed ? NULL : json_string((const char *)line.data);
    pen_buf_release(&line);
    return json;
}

static void log_failure(const struct pen_claim *claim, const char *error)
{
    struct pen_log_about about = pen_claim_about(claim);
    json_t *problem = json_loads(error, 0, NULL);
    const char *detail = json_string_value(json_object_get(problem, "detail"));
    const char *repeat = json_string_value(json_object_get(problem, "repeat"));
    pen_log_about(PEN_LOG_WARN, &about, "the job failed: %s", detail ? detail : "no memory");
    if (repeat)
        pen_log_about(PEN_LOG_WARN, &about, "to see it again: %s", repeat);
    json_decref(problem);
}

/* Adds the members with the place of the failure: batch, pixel, and the command line that repeats
 * it. */
static void add_place(json_t *problem, const struct place *place, struct pen_store *store)
{
    const struct pen_claim *claim = place->claim;
    struct pen_job_record job;
    struct pen_stored_request request;
    struct pen_status st;
    json_object_set_new(problem, "batch",
                        json_pack("{s:i, s:i, s:i, s:I}", "view", claim->view, "first_tile",
                                  claim->first_tile, "tile_count", claim->tile_count, "attempt",
                                  (json_int_t)claim->attempt));
    if (place->x >= 0)
        json_object_set_new(problem, "pixel", json_pack("[i, i]", place->x, place->y));
    if (claim->kind == PEN_BATCH_ASSEMBLE || !pen_store_job(store, claim->job_id, &job, &st))
        return;
    bool known = pen_stored_request_read(job.request, &request, &st);
    pen_job_record_release(&job);
    if (!known)
        return;
    json_object_set_new(problem, "repeat", repeat_json(place, &request));
    pen_stored_request_release(&request);
}

static char *write_problem(struct pen_store *store, const struct place *place, json_t *problem)
{
    if (problem)
        add_place(problem, place, store);
    char *text = problem ? json_dumps(problem, PEN_JSON_STORED) : NULL;
    json_decref(problem);
    return text;
}

static const char *at_pixel(const struct place *place, char *out, size_t bytes)
{
    out[0] = '\0';
    if (place->x >= 0)
        snprintf(out, bytes, ", near pixel %d,%d", place->x, place->y);
    return out;
}

bool pen_failure_store(struct pen_store *store, const struct pen_claim *claim,
                       const struct pen_status *why, const struct pen_trace *trace,
                       struct pen_status *st)
{
    struct pen_status timeout;
    struct place place = place_of(claim, trace);
    char where[48];
    if (!why)
        pen_fail(&timeout, PEN_TIMEOUT, "the job took longer than its timeout_seconds, %g%s",
                 (double)claim->timeout_ms / 1000, at_pixel(&place, where, sizeof where));
    char *error = write_problem(store, &place, pen_problem(why ? why : &timeout));
    const bool ok = error ? pen_store_fail(store, claim, error, st)
                          : pen_fail(st, PEN_NO_MEMORY, "no memory for an error");
    if (ok)
        log_failure(claim, error);
    free(error);
    return ok;
}

/* The last lines of the worker's log, as a JSON array. */
static json_t *log_json(const struct pen_trace *trace)
{
    char text[LOG_BYTES], *rest = text;
    json_t *list = json_array();
    pen_log_ring_last(&trace->log, LOG_LINES, text, sizeof text);
    for (char *line; (line = strsep(&rest, "\n")) != NULL;) {
        if (*line)
            json_array_append_new(list, json_string(line));
    }
    return list;
}

struct death {
    const struct pen_worker_report *report;
    struct pen_store *store;
    struct pen_claim claim; /* out: of the job that failed */
    char *error;            /* out: NULL if none did */
};

/* Makes the error of a job whose workers died; called by the store. */
static char *death_error(void *user, const struct pen_claim *claim, int charges)
{
    struct death *death = user;
    const struct pen_worker_report *report = death->report;
    struct place place = place_of(claim, report->trace);
    struct pen_status why;
    char where[48], name[16] = "";
    int number = 0;
    pen_fail(&why, PEN_RENDER_FAILED,
             "%d worker process%s in a row died over this job alone, the last by %s, at %s of view "
             "%d%s",
             charges, charges == 1 ? "" : "es", report->how,
             claim->kind == PEN_BATCH_ASSEMBLE ? "the picture"
             : claim->kind == PEN_BATCH_STUDY  ? "a run"
                                               : "tiles",
             claim->view, at_pixel(&place, where, sizeof where));
    json_t *problem = pen_problem(&why);
    if (problem && sscanf(report->how, "signal %*d (%15[A-Z0-9])", name) == 1)
        json_object_set_new(problem, "signal", json_string(name));
    else if (problem && sscanf(report->how, "exit code %d", &number) == 1)
        json_object_set_new(problem, "exit_code", json_integer(number));
    if (problem && report->trace)
        json_object_set_new(problem, "log", log_json(report->trace));
    char *error = write_problem(death->store, &place, problem);
    free(death->error);
    death->error = error ? strdup(error) : NULL;
    death->claim = *claim;
    return error;
}

bool pen_jobs_worker_ended(struct pen_store *store, const struct pen_worker_report *report,
                           int *opened, struct pen_status *st)
{
    struct death user = {.report = report, .store = store};
    struct pen_worker_death death = {
        .worker = report->worker, .end = report->end, .error = death_error, .user = &user};
    bool ok = pen_store_worker_ended(store, &death, opened, st);
    if (ok && user.error)
        log_failure(&user.claim, user.error);
    free(user.error);
    return ok;
}
