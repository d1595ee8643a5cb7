/* SPDX-License-Identifier: MIT */
/* Submit: stores the key, the scene document, the job, its views and its batches in one transaction
 * (README.md, "Submit"). Unique constraints alone tell whether a key, a document or a job is stored
 * already. The document is compressed before the transaction, unless it is stored already, so that
 * the write lock is held for writing only. */
#include <pthread.h>
#include <string.h>
#include <time.h>

#include "store/internal/policy.h"

enum {
    MANY_BATCHES = 256, /* more take longer to store than most transactions: 5 ms and more */
    PAUSE_NS = 5000000  /* longer than others sleep while they wait for the write lock */
};

/* Jobs of many batches are stored one after the other, with a pause after each. So who else wants
 * to write (another thread, or a worker) waits for one of them, however many there are. */
static pthread_mutex_t many_batches = PTHREAD_MUTEX_INITIALIZER;

struct submission {
    const struct pen_job_new *job;
    struct pen_bytes document;
    bool compressed;
    enum pen_submit_result result;
    struct pen_buf *first_answer;
};

/* Where the key is stored already: compares the body it came with, and reads the first answer. */
static bool find_key(struct pen_store *store, struct submission *in, bool *found,
                     struct pen_status *st)
{
    unsigned char body[32];
    size_t before = in->first_answer->bytes;
    if (!store->driver->ops->key_get(store->driver, pen_job_client(in->job),
                                     in->job->idempotency_key, body, in->first_answer, found, st))
        return false;
    if (!*found)
        return true;
    bool same = memcmp(body, in->job->body_sha256, sizeof body) == 0;
    in->result = same ? PEN_SUBMIT_REPEATED : PEN_SUBMIT_REUSED;
    if (!same)
        in->first_answer->bytes = before;
    return true;
}

static bool add_key(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    struct pen_key_row key = {.client = pen_job_client(in->job),
                              .key = in->job->idempotency_key,
                              .body_sha256 = in->job->body_sha256,
                              .answer = in->job->answer};
    bool added, found;
    if (!store->driver->ops->now(store->driver, &key.created_ms, st) ||
        !store->driver->ops->key_add(store->driver, &key, &added, st))
        return false;
    if (added)
        return true;
    return find_key(store, in, &found, st) &&
           (found || pen_fail(st, PEN_UNAVAILABLE, "the idempotency key was removed meanwhile"));
}

static bool compress(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    in->compressed = in->compressed || pen_compress(store->compressor, in->job->scene,
                                                    in->job->scene_bytes, &in->document, st);
    return in->compressed;
}

static bool insert_scene(struct pen_store *store, struct submission *in, int64_t *number,
                         bool *added, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    if (!compress(store, in, st))
        return false;
    struct pen_blob_start start = pen_blob_begin(in->document.data, in->document.bytes);
    if (!driver->ops->scene_add(driver, in->job->scene_sha256, &start, number, added, st))
        return false;
    return !*added || pen_blob_finish(store, PEN_BLOB_SCENE, *number, in->document.data,
                                      in->document.bytes, st);
}

static bool add_scene(struct pen_store *store, struct submission *in, int64_t *number,
                      struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    const unsigned char *sha256 = in->job->scene_sha256;
    bool found, added;
    if (!driver->ops->scene_find(driver, sha256, number, &found, st))
        return false;
    if (found)
        return true;
    if (!insert_scene(store, in, number, &added, st))
        return false;
    if (added)
        return true;
    return driver->ops->scene_find(driver, sha256, number, &found, st) &&
           (found || pen_fail(st, PEN_UNAVAILABLE, "the scene document was removed meanwhile"));
}

/* A job with this id is stored already: by an earlier try of this submit, or it is another job. */
static bool compare_known(struct pen_store *store, struct submission *in, int64_t scene,
                          struct pen_status *st)
{
    struct pen_job_row row;
    bool found;
    if (!store->driver->ops->job_get(store->driver, in->job->id, &row, &found, st))
        return false;
    bool same = found && row.scene == scene && strcmp(row.record.kind, in->job->kind) == 0 &&
                strcmp(row.record.request, in->job->request) == 0;
    if (found)
        pen_job_record_release(&row.record);
    in->result = PEN_SUBMIT_KNOWN;
    return same ||
           pen_fail(st, PEN_CONFLICT, "there is another job %s; take a new id", in->job->id);
}

static bool add_view(struct pen_store *store, const struct pen_job_new *job, int64_t number,
                     int view, struct pen_status *st)
{
    int batches = 0;
    for (int i = 0; i < job->batch_count; i++)
        batches += job->batches[i].view == view;
    if (batches == 0)
        return pen_fail(st, PEN_INTERNAL, "view %d of a new job has no batch", view);
    return store->driver->ops->view_add(store->driver, number, view, &job->views[view], batches,
                                        st);
}

static bool add_parts(struct pen_store *store, const struct pen_job_new *job, int64_t number,
                      struct pen_status *st)
{
    for (int i = 0; i < job->view_count; i++) {
        if (!add_view(store, job, number, i, st))
            return false;
    }
    for (int i = 0; i < job->batch_count; i++) {
        struct pen_batch_add add = {.job = number, .batch = job->batches[i]};
        bool added;
        if (!store->driver->ops->batch_add(store->driver, &add, &added, st))
            return false;
    }
    return true;
}

/* client: whose jobs were counted; NULL: all were. */
static bool too_many(int64_t jobs, const char *client, int64_t most, struct pen_status *st)
{
    return pen_fail(st, PEN_QUOTA, "%lld job%s%s%s %s, at most %lld %s allowed; try again later",
                    (long long)jobs, jobs == 1 ? "" : "s", client ? " of client " : "",
                    client ? client : "", jobs == 1 ? "waits or runs" : "wait or run",
                    (long long)most, most == 1 ? "is" : "are");
}

/* Fails if this job would be one too many. */
static bool check_queue(struct pen_store *store, const struct pen_job_new *job,
                        struct pen_status *st)
{
    int64_t all, of_client;
    if (job->queue_max == 0 && job->client_queue_max == 0)
        return true;
    if (!store->driver->ops->queue_lengths(store->driver, pen_job_client(job), &all, &of_client,
                                           st))
        return false;
    if (job->queue_max > 0 && all > job->queue_max)
        return too_many(all - 1, NULL, job->queue_max, st);
    if (job->client_queue_max > 0 && of_client > job->client_queue_max)
        return too_many(of_client - 1, pen_job_client(job), job->client_queue_max, st);
    return true;
}

static bool add_job(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    const struct pen_job_new *job = in->job;
    int64_t scene, number, pixels = 0;
    bool added;
    for (int i = 0; i < job->batch_count; i++)
        pixels += job->batches[i].pixels;
    if (!add_scene(store, in, &scene, st) ||
        !store->driver->ops->job_add(store->driver, job, scene, pixels, &number, &added, st))
        return false;
    if (!added)
        return compare_known(store, in, scene, st);
    if (!check_queue(store, job, st))
        return false;
    store->work = store->changed = true;
    return add_parts(store, job, number, st) && pen_admit_bytes(store, number, st);
}

static bool write_submission(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct submission *in = arg;
    in->result = PEN_SUBMIT_CREATED;
    if (in->job->idempotency_key && !add_key(store, in, st))
        return false;
    return in->result != PEN_SUBMIT_CREATED || add_job(store, in, st);
}

static bool write_many(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    const struct timespec pause = {.tv_nsec = PAUSE_NS};
    pthread_mutex_lock(&many_batches);
    const bool ok = pen_store_write(store, write_submission, in, st);
    nanosleep(&pause, NULL);
    pthread_mutex_unlock(&many_batches);
    return ok;
}

static bool write_job(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    return in->job->batch_count > MANY_BATCHES ? write_many(store, in, st)
                                               : pen_store_write(store, write_submission, in, st);
}

bool pen_policy_submit(struct pen_store *store, const struct pen_job_new *job,
                       enum pen_submit_result *result, struct pen_buf *first_answer,
                       struct pen_status *st)
{
    struct submission in = {.job = job, .first_answer = first_answer};
    int64_t scene;
    bool found;
    if (!store->driver->ops->scene_find(store->driver, job->scene_sha256, &scene, &found, st) ||
        (!found && !compress(store, &in, st)) || !write_job(store, &in, st))
        return false;
    *result = in.result;
    return true;
}

bool pen_policy_submitted(struct pen_store *store, const struct pen_job_new *job,
                          enum pen_submit_result *result, struct pen_buf *first_answer, bool *known,
                          struct pen_status *st)
{
    struct submission in = {.job = job, .first_answer = first_answer};
    struct pen_job_key stored;
    int64_t scene;
    if (job->idempotency_key
            ? !find_key(store, &in, known, st)
            : !store->driver->ops->job_find(store->driver, job->id, &stored, known, st))
        return false;
    if (*known && !job->idempotency_key &&
        (!store->driver->ops->scene_find(store->driver, job->scene_sha256, &scene, known, st) ||
         (*known && !compare_known(store, &in, scene, st))))
        return false;
    *result = in.result;
    return true;
}
