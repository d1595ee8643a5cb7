/* SPDX-License-Identifier: MIT */
/* Reads, lists, cancels and deletes jobs; returns their scenes and the built-in scenes. */
#include "jobs/internal/jobs.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/builtin.h"
#include "jobs/internal/ids.h"
#include "jobs/internal/job_json.h"

struct pen_jobs *pen_jobs_open(const char *store_url, const struct pen_limits *limits,
                               struct pen_status *st)
{
    if (!pen_ids_init(st))
        return NULL;
    struct pen_jobs *jobs = calloc(1, sizeof *jobs);
    if (!jobs) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for a handle on the jobs");
        return NULL;
    }
    jobs->limits = *limits;
    jobs->store = pen_store_open(store_url, false, st);
    if (jobs->store)
        return jobs;
    free(jobs);
    return NULL;
}

void pen_jobs_close(struct pen_jobs *jobs)
{
    if (!jobs)
        return;
    pen_store_close(jobs->store);
    free(jobs);
}

struct pen_store *pen_jobs_store(struct pen_jobs *jobs)
{
    return jobs->store;
}

/* Takes the record. */
static bool make_snapshot(struct pen_job_record *job, struct pen_job_snapshot *out,
                          struct pen_status *st)
{
    *out = (struct pen_job_snapshot){
        .json = pen_job_json(job, st), .state = job->state, .revision = job->revision};
    pen_job_record_release(job);
    return out->json != NULL;
}

bool pen_jobs_get(struct pen_jobs *jobs, const char *id, struct pen_job_snapshot *out,
                  struct pen_status *st)
{
    struct pen_job_record job;
    return pen_store_job(jobs->store, id, &job, st) && make_snapshot(&job, out, st);
}

bool pen_jobs_state(struct pen_jobs *jobs, const char *id, enum pen_job_state *state,
                    int64_t *revision, struct pen_status *st)
{
    struct pen_job_record job;
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    *state = job.state;
    *revision = job.revision;
    pen_job_record_release(&job);
    return true;
}

/* A cursor is the letter j and the number of the last job on its page. The letter shows clients
 * that it is not a number to compute with. */
static bool read_cursor(const char *cursor, int64_t *below, struct pen_status *st)
{
    char *end = NULL;
    *below = 0;
    if (!cursor)
        return true;
    if (cursor[0] == 'j' && cursor[1] >= '1' && cursor[1] <= '9' && strlen(cursor) <= 19)
        *below = strtoll(cursor + 1, &end, 10);
    if (end && *end == '\0')
        return true;
    return pen_fail(st, PEN_USAGE, "cursor must be the value that a list gave as `next`");
}

enum { LABEL_BYTES = 4 * 200 + 1 }; /* a key of 200 characters, and its end */

/* Splits "key:value". */
static bool read_label(const char *label, char key[LABEL_BYTES], struct pen_job_filter *filter,
                       struct pen_status *st)
{
    const char *colon = label ? strchr(label, ':') : NULL;
    if (!label)
        return true;
    if (!colon || colon == label || colon - label >= LABEL_BYTES)
        return pen_fail(st, PEN_USAGE, "label must be a key, a colon and a value, found \"%.60s\"",
                        label);
    snprintf(key, LABEL_BYTES, "%.*s", (int)(colon - label), label);
    filter->label_key = key;
    filter->label_value = colon + 1;
    return true;
}

/* Size of the stored texts of a page. With some 700 bytes for the state of each job, 500 jobs make
 * 1 MiB of JSON. */
enum { PAGE_TEXT_BYTES = 640 << 10 };

/* Returns how many of these jobs a page has: at most `limit`, at most PAGE_TEXT_BYTES of texts, but
 * always the first. */
static int page_count(const struct pen_job_record *jobs, int count, int limit)
{
    size_t bytes = 0;
    int page = 0;
    while (page < count && page < limit) {
        bytes += pen_job_record_text_bytes(&jobs[page]);
        if (page > 0 && bytes > PAGE_TEXT_BYTES)
            break;
        page++;
    }
    return page;
}

/* Makes a page of the first `page` jobs. The list has one job more if another page follows. */
static json_t *list_json(const struct pen_job_record *jobs, int count, int page,
                         struct pen_status *st)
{
    json_t *list = json_array(), *next = json_null();
    for (int i = 0; list && i < page; i++) {
        json_t *job = pen_job_json(&jobs[i], st);
        if (!job) {
            json_decref(list);
            return NULL;
        }
        json_array_append_new(list, job);
    }
    if (count > page) {
        char cursor[32];
        snprintf(cursor, sizeof cursor, "j%" PRId64, jobs[page - 1].number);
        next = json_string(cursor);
    }
    json_t *answer =
        json_pack("{s:o, s:o}", "jobs", pen_json_all(list, (size_t)page), "next", next);
    if (!answer)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a list of jobs");
    return answer;
}

/* Adds the number of jobs in each state; takes the answer. */
static json_t *with_counts(json_t *answer, struct pen_store *store, struct pen_status *st)
{
    int64_t jobs[PEN_JOB_STATE_COUNT];
    if (!pen_store_job_counts(store, jobs, st)) {
        json_decref(answer);
        return NULL;
    }
    json_t *counts = json_object();
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++)
        counts = pen_json_with(counts, pen_job_state_name((enum pen_job_state)i),
                               json_integer((json_int_t)jobs[i]));
    answer = pen_json_with(answer, "counts", counts);
    if (!answer)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a list of jobs");
    return answer;
}

json_t *pen_jobs_list(struct pen_jobs *jobs, const struct pen_list_query *query,
                      struct pen_status *st)
{
    struct pen_job_filter filter = {.state = query->state,
                                    .kind = query->kind,
                                    .name = query->name,
                                    .limit = query->limit + 1,
                                    .text_bytes = PAGE_TEXT_BYTES};
    struct pen_job_record *list;
    char key[LABEL_BYTES];
    int count;
    if (query->limit < 1 || query->limit > 500) {
        pen_fail(st, PEN_USAGE, "limit must be 1 to 500");
        return NULL;
    }
    if (!read_cursor(query->cursor, &filter.below, st) ||
        !read_label(query->label, key, &filter, st) ||
        !pen_store_jobs(jobs->store, &filter, &list, &count, st))
        return NULL;
    json_t *answer = list_json(list, count, page_count(list, count, query->limit), st);
    pen_job_records_free(list, count);
    return answer && !query->cursor ? with_counts(answer, jobs->store, st) : answer;
}

bool pen_jobs_cancel(struct pen_jobs *jobs, const char *id, const char *client,
                     struct pen_job_snapshot *out, struct pen_status *st)
{
    struct pen_job_record job;
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    const bool ended = pen_job_state_ended(job.state);
    if (ended && pen_store_check_client(jobs->store, id, client, st))
        return make_snapshot(&job, out, st);
    pen_job_record_release(&job);
    if (ended || !pen_store_cancel(jobs->store, id, client, st) || !pen_jobs_get(jobs, id, out, st))
        return false;
    out->cancelled_now = out->state == PEN_JOB_CANCELLED;
    return true;
}

bool pen_jobs_delete(struct pen_jobs *jobs, const char *id, const char *client, bool keep_stats,
                     struct pen_status *st)
{
    json_t *stats = keep_stats ? pen_jobs_stats(jobs, id, st) : NULL;
    /* A job that had not ended will have statistics soon, even if it has ended meanwhile. */
    if (keep_stats && !stats && st->code == PEN_CONFLICT)
        return pen_store_check_client(jobs->store, id, client, st) &&
               pen_fail(st, PEN_CONFLICT, "job %s has not ended; cancel it before deleting it", id);
    if (keep_stats && !stats && st->code != PEN_STORAGE)
        return false; /* the job does not exist, or the next try may read them */
    char *text = stats ? json_dumps(stats, PEN_JSON_STORED) : NULL;
    json_decref(stats);
    if (stats && !text)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
    /* Statistics that cannot be read are damaged and not worth keeping. If the store cannot be
     * read, it removes nothing either. */
    bool ok = pen_store_delete(jobs->store, id, client, keep_stats && !text ? "{}" : text, st);
    free(text);
    return ok;
}

/* Returns the number of primitives in a list of objects, including groups. The recursion is not
 * bounded, so only built-in scenes are allowed. */
static size_t primitive_count(const json_t *objects)
{
    size_t count = 0, i;
    json_t *object;
    json_array_foreach(objects, i, object)
    {
        const json_t *inner = json_object_get(object, "objects");
        count += inner ? primitive_count(inner) : 1;
    }
    return count;
}

/* Makes the list entry of a built-in scene. */
static json_t *builtin_json(size_t i)
{
    const char *name = pen_builtin_name(i);
    size_t bytes = 0;
    const char *text = pen_builtin_text(i, &bytes);
    json_t *document = json_loadb(text, bytes, 0, NULL);
    json_t *entry = json_pack("{s:s, s:s, s:I, s:I, s:s+}", "name", name, "title",
                              pen_builtin_summary(i), "bytes", (json_int_t)bytes, "objects",
                              (json_int_t)primitive_count(json_object_get(document, "objects")),
                              "href", "/v1/scenes/", name);
    json_decref(document);
    return entry;
}

json_t *pen_jobs_scenes(void)
{
    json_t *list = json_array();
    for (size_t i = 0; i < pen_builtin_count(); i++)
        json_array_append_new(list, builtin_json(i));
    return json_pack("{s:o}", "scenes", pen_json_all(list, pen_builtin_count()));
}
