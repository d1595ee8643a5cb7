/* SPDX-License-Identifier: MIT */
/* The functions of store.h: each checks the store's health, calls the policy, gives signals and
 * tells the observer. Signals are given after the transaction, so that a reader who wakes up sees
 * the change. Also here: the choice of the driver. */
#include "store/store.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "store/internal/health.h"
#include "store/internal/policy.h"

/* zstd's level for scene documents. They are written once. */
enum { DOCUMENT_LEVEL = 1 };

static bool has_prefix(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

static bool is_file(const char *url, struct pen_status *st)
{
    if (has_prefix(url, "postgres://") || has_prefix(url, "postgresql://"))
        return pen_fail(st, PEN_UNSUPPORTED,
                        "a PostgreSQL store is known, not supported yet; give the path of a file");
    return url[0] != '\0' || pen_fail(st, PEN_USAGE, "the store needs the path of a file");
}

/* The path in a URL. *wanted: the identity in the URL, as pen_sqlite_open takes it; `identity`
 * holds its text. */
static const char *read_url(const char *url, char identity[PEN_STORE_IDENTITY_BYTES],
                            const char **wanted)
{
    static const char prefix[] = "store:";
    const size_t digits = PEN_STORE_IDENTITY_BYTES - 1;
    const char *at = url + sizeof prefix - 1;
    *wanted = NULL;
    if (!has_prefix(url, prefix))
        return url;
    const size_t length = strcspn(at, ":");
    if (at[length] != ':' || (length != 0 && length != digits))
        return url;
    memcpy(identity, at, length);
    identity[length] = '\0';
    *wanted = identity;
    return at + length + 1;
}

static struct pen_driver *open_driver(struct pen_store *store, const char *url,
                                      struct pen_status *st)
{
    const char *wanted, *path = read_url(url, store->identity, &wanted);
    return pen_sqlite_open(path, wanted, st);
}

struct pen_store *pen_store_open(const char *url, struct pen_status *st)
{
    if (!is_file(url, st))
        return NULL;
    struct pen_store *store = calloc(1, sizeof *store);
    if (store)
        store->compressor = pen_compressor_new(DOCUMENT_LEVEL);
    if (!store || !store->compressor)
        pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    else
        store->driver = open_driver(store, url, st);
    if (!store || !store->driver) {
        pen_store_close(store);
        return NULL;
    }
    pen_health_begin(store);
    return store;
}

bool pen_store_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                      struct pen_status *st)
{
    return is_file(url, st) && pen_sqlite_backup(url, file, replace, out, st);
}

void pen_store_backup_remove_left(const char *file)
{
    pen_sqlite_backup_remove_left(file);
}

void pen_store_close(struct pen_store *store)
{
    if (!store)
        return;
    if (store->driver)
        store->driver->ops->close(store->driver);
    pen_compressor_free(store->compressor);
    pen_pixels_free(store->pixels);
    pen_buf_release(&store->blob);
    free(store->rgb);
    free(store);
}

void pen_store_observe(struct pen_store *store, const struct pen_store_observer *observer)
{
    store->observer = observer;
}

/* The state at the beginning of a call that an observer is told of; name is NULL without one. */
struct call_start {
    const char *name;
    int64_t transactions, wall_ns, cpu_ns;
};

static struct call_start begin(const struct pen_store *store, const char *name)
{
    if (!store->observer)
        return (struct call_start){0};
    return (struct call_start){.name = name,
                               .transactions = store->driver->transactions,
                               .wall_ns = pen_clock_ns(),
                               .cpu_ns = pen_clock_thread_ns()};
}

static bool end(const struct pen_store *store, const struct call_start *start, bool ok)
{
    if (!start->name)
        return ok;
    struct pen_store_call call = {.name = start->name,
                                  .transactions = store->driver->transactions - start->transactions,
                                  .wall_ns = pen_clock_ns() - start->wall_ns,
                                  .cpu_ns = pen_clock_thread_ns() - start->cpu_ns};
    store->observer->called(store->observer->user, &call);
    return ok;
}

/* A call of the policy is `enter(store, need, st) && leave(store, &start, CALL)`, see health.h. */
static bool enter(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    if (store->depth == 0) {
        store->outcome_unknown = store->lacks_space = false;
        store->driver->wanted_bytes = 0;
    }
    return pen_health_enter(store, need, st);
}

static void give_signals(struct pen_store *store)
{
    struct pen_driver *driver = store->driver;
    if (store->work)
        driver->ops->wake(driver, PEN_SIGNAL_WORK);
    if (store->changed)
        driver->ops->wake(driver, PEN_SIGNAL_CHANGES);
    store->work = store->changed = false;
}

/* Notes faults, gives signals, tells the observer (start: NULL if it is not told of this call) and
 * returns the call's result. */
static bool leave(struct pen_store *store, const struct call_start *start, bool ok)
{
    if (pen_health_exit(store))
        give_signals(store);
    return start ? end(store, start, ok) : ok;
}

/* After a call that stores a result of a job: notes whether that waits for space. */
static bool note_space(struct pen_store *store, const char *id, bool ok)
{
    store->lacks_space = !ok && store->driver->wanted_bytes > 0;
    if (store->lacks_space) {
        snprintf(store->waiting, sizeof store->waiting, "%s", id);
        pen_health_want(store, store->driver->wanted_bytes);
    } else if (strcmp(store->waiting, id) == 0) {
        store->waiting[0] = '\0';
        pen_health_want(store, 0);
    }
    return ok;
}

bool pen_store_lacks_space(const struct pen_store *store)
{
    return store->lacks_space;
}

enum pen_failure pen_store_failure(const struct pen_store *store, const struct pen_status *st)
{
    if (store->outcome_unknown)
        return PEN_FAILURE_UNKNOWN;
    bool temporary = st->code == PEN_UNAVAILABLE || st->code == PEN_STORAGE_FULL ||
                     st->code == PEN_STORAGE || st->code == PEN_NO_MEMORY;
    return temporary ? PEN_FAILURE_RETRY : PEN_FAILURE_REFUSED;
}

bool pen_store_now(struct pen_store *store, int64_t *now_ms, struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, store->driver->ops->now(store->driver, now_ms, st));
}

bool pen_store_check(struct pen_store *store, struct pen_status *st)
{
    if (!enter(store, PEN_NEED_CHECK, st) ||
        !leave(store, NULL, store->driver->ops->check(store->driver, st)))
        return false;
    pen_health_check_passed(store);
    return true;
}

const char *pen_store_identity(const struct pen_store *store)
{
    return store->driver->ops->identity(store->driver);
}

const char *pen_store_path(const struct pen_store *store)
{
    return store->driver->name;
}

bool pen_store_settle(struct pen_store *store, struct pen_status *st)
{
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, NULL, store->driver->ops->settle(store->driver, st));
}

bool pen_store_check_start(struct pen_store *store, struct pen_status *st)
{
    if (!enter(store, PEN_NEED_CHECK, st) ||
        !leave(store, NULL, store->driver->ops->check_start(store->driver, st)))
        return false;
    pen_health_check_passed(store);
    return true;
}

bool pen_store_probe(struct pen_store *store, struct pen_status *st)
{
    return enter(store, PEN_NEED_SPACE, st) &&
           leave(store, NULL, store->driver->ops->probe(store->driver, st));
}

bool pen_store_intake(struct pen_store *store, struct pen_status *st)
{
    return enter(store, PEN_NEED_SPACE, st) &&
           leave(store, NULL,
                 pen_policy_intake(store, st) && store->driver->ops->probe(store->driver, st));
}

bool pen_store_reserve(struct pen_store *store, struct pen_status *st)
{
    return store->driver->ops->reserve_make(store->driver, st);
}

static bool submit(struct pen_store *store, const struct pen_job_new *job,
                   enum pen_submit_result *result, struct pen_buf *first_answer,
                   struct pen_status *st)
{
    struct call_start start = begin(store, "submit");
    return enter(store, PEN_NEED_SPACE, st) &&
           leave(store, &start,
                 pen_policy_intake(store, st) &&
                     pen_policy_submit(store, job, result, first_answer, st));
}

/* Whether the store has the answer to this submit already. */
static bool was_submitted(struct pen_store *store, const struct pen_job_new *job,
                          enum pen_submit_result *result, struct pen_buf *first_answer)
{
    struct pen_status ignored;
    bool known = false;
    return enter(store, PEN_NEED_READ, &ignored) &&
           leave(store, NULL,
                 pen_policy_submitted(store, job, result, first_answer, &known, &ignored)) &&
           known;
}

bool pen_store_submit(struct pen_store *store, const struct pen_job_new *job,
                      enum pen_submit_result *result, struct pen_buf *first_answer,
                      struct pen_status *st)
{
    return submit(store, job, result, first_answer, st) ||
           (st->code == PEN_STORAGE_FULL && was_submitted(store, job, result, first_answer));
}

bool pen_store_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                   struct pen_status *st)
{
    struct call_start start = begin(store, "job");
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, &start, pen_policy_job(store, id, job, st));
}

bool pen_store_queue(struct pen_store *store, struct pen_queue *queue, struct pen_status *st)
{
    *queue = (struct pen_queue){0};
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, store->driver->ops->queue(store->driver, queue, st));
}

bool pen_store_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                    struct pen_job_record **jobs, int *count, struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_jobs(store, filter, jobs, count, st));
}

bool pen_store_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, store->driver->ops->job_counts(store->driver, counts, st));
}

bool pen_store_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                     struct pen_status *st)
{
    struct call_start start = begin(store, "scene");
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, &start, pen_policy_scene(store, id, scene, st));
}

/* After a call that frees space, or leads to it, has failed: whether the disk is full, and the call
 * may be repeated. First the log is copied into the store, so that it can be written from its
 * beginning again, which takes no space. Then parts of the reserve are moved into the store's own
 * files, until it is used up. */
static bool may_repeat(struct pen_store *store, int *tries, const struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_status ignored;
    if (st->code != PEN_STORAGE_FULL || store->outcome_unknown || driver->closed ||
        !enter(store, PEN_NEED_WRITE, &ignored))
        return false;
    const bool first = (*tries)++ == 0, again = first || driver->ops->reserve_move(driver);
    if (!first && again)
        pen_log(PEN_LOG_WARN, "the disk of the store %s is full: its reserve is used to free space",
                driver->name);
    if (again)
        driver->ops->restart_log(driver, first);
    return leave(store, NULL, again);
}

bool pen_store_check_client(struct pen_store *store, const char *id, const char *client,
                            struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_check_client(store, id, client, st));
}

static bool cancel(struct pen_store *store, const char *id, const char *client,
                   struct pen_status *st)
{
    struct call_start start = begin(store, "cancel");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_cancel(store, id, client, st));
}

bool pen_store_cancel(struct pen_store *store, const char *id, const char *client,
                      struct pen_status *st)
{
    int tries = 0;
    bool ok;
    do
        ok = cancel(store, id, client, st);
    while (!ok && may_repeat(store, &tries, st));
    return ok;
}

static bool remove_job(struct pen_store *store, const char *id, const char *client,
                       const char *stats, struct pen_status *st)
{
    struct call_start start = begin(store, "delete");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_delete(store, id, client, stats, st));
}

bool pen_store_delete(struct pen_store *store, const char *id, const char *client,
                      const char *stats, struct pen_status *st)
{
    int tries = 0;
    bool ok;
    do
        ok = remove_job(store, id, client, stats, st);
    while (!ok && may_repeat(store, &tries, st));
    return ok;
}

bool pen_store_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                             struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_removed_stats(store, id, stats, st));
}

bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                     struct pen_claim *claim, bool *found, struct pen_status *st)
{
    struct call_start start = begin(store, "claim");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_claim(store, worker, lease_ms, claim, found, st));
}

bool pen_store_commit_and_claim(struct pen_store *store, const struct pen_claim *claim,
                                const struct pen_result *result, struct pen_next *next,
                                struct pen_status *st)
{
    struct call_start start = begin(store, "commit");
    return enter(store, PEN_NEED_GROW, st) &&
           leave(
               store, &start,
               note_space(store, claim->job_id, pen_policy_commit(store, claim, result, next, st)));
}

bool pen_store_commit(struct pen_store *store, const struct pen_claim *claim,
                      const struct pen_result *result, struct pen_status *st)
{
    return pen_store_commit_and_claim(store, claim, result, NULL, st);
}

bool pen_store_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                        struct pen_status *st)
{
    struct call_start start = begin(store, "progress");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_progress(store, claim, done, st));
}

bool pen_store_keep(struct pen_store *store, const struct pen_claim *claim,
                    const struct pen_kept *kept, bool *outranked, struct pen_status *st)
{
    struct call_start start = begin(store, "keep");
    return enter(store, PEN_NEED_GROW, st) &&
           leave(store, &start, pen_policy_keep(store, claim, kept, outranked, st));
}

bool pen_store_keep_part(struct pen_store *store, const struct pen_claim *claim,
                         const struct pen_kept_part *part, struct pen_status *st)
{
    return enter(store, PEN_NEED_GROW, st) &&
           leave(store, NULL, pen_policy_keep_part(store, claim, part, st));
}

bool pen_store_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    int64_t now_ms;
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL,
                 driver->ops->now(driver, &now_ms, st) &&
                     pen_outranked(driver, claim, now_ms, outranked, st));
}

bool pen_store_kept(struct pen_store *store, const struct pen_claim *claim, const char *name,
                    struct pen_buf *out, struct pen_status *st)
{
    return pen_store_artefact(store, claim->job_id, claim->view, PEN_KEPT_LAYER, name, out, st);
}

bool pen_store_estimate(struct pen_store *store, const struct pen_claim *claim, int64_t estimate_ms,
                        const struct pen_buf *cost_map, struct pen_status *st)
{
    struct call_start start = begin(store, "estimate");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_estimate(store, claim, estimate_ms, cost_map, st));
}

bool pen_store_cost_map(struct pen_store *store, const char *id, struct pen_buf *out,
                        struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, store->driver->ops->job_cost_map(store->driver, id, out, st));
}

bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st)
{
    struct call_start start = begin(store, "release");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_release(store, claim, st));
}

bool pen_store_set_back(struct pen_store *store, const struct pen_claim *claim, const char *error,
                        bool always, bool *set_back, struct pen_status *st)
{
    struct call_start start = begin(store, "set_back");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_set_back(store, claim, error, always, set_back, st));
}

bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st)
{
    struct call_start start = begin(store, "fail");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_fail(store, claim, error, st));
}

bool pen_store_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st)
{
    struct call_start start = begin(store, "heartbeat");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_heartbeat(store, claim, lease_ms, held, st));
}

bool pen_store_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                             struct pen_status *st)
{
    struct call_start start = begin(store, "expire_leases");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_expire_leases(store, dead_worker, opened, st));
}

bool pen_store_release_dead(struct pen_store *store, int *opened, struct pen_status *st)
{
    struct call_start start = begin(store, "release_dead");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_release_dead(store, opened, st));
}

bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st)
{
    struct call_start start = begin(store, "worker_ended");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_worker_ended(store, death, opened, st));
}

bool pen_store_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                      void *user, struct pen_status *st)
{
    struct call_start start = begin(store, "pixels");
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, &start, pen_policy_pixels(store, id, view, each, user, st));
}

bool pen_store_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                     struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_stats(store, id, each, user, st));
}

bool pen_store_batches(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                       struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_batches(store, id, each, user, st));
}

bool pen_store_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                       void *user, struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_commits(store, id, after, each, user, st));
}

bool pen_store_worker_lock(struct pen_store *store, const char *id, struct pen_status *st)
{
    return store->driver->ops->worker_lock(store->driver, id, st);
}

bool pen_store_supervise(struct pen_store *store, struct pen_status *st)
{
    return store->driver->ops->supervise(store->driver, st);
}

bool pen_store_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                           struct pen_status *st)
{
    struct call_start start = begin(store, "worker_seen");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_worker_seen(store, worker, st));
}

bool pen_store_worker_gone(struct pen_store *store, const char *id, struct pen_status *st)
{
    struct call_start start = begin(store, "worker_gone");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_worker_gone(store, id, st));
}

bool pen_store_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                       struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_workers(store, each, user, st));
}

bool pen_store_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                        const char *format, struct pen_buf *out, struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_artefact(store, id, view, layer, format, out, st));
}

bool pen_store_artefact_put(struct pen_store *store, const struct pen_claim *claim,
                            const char *layer, const char *format, const void *data, size_t bytes,
                            struct pen_status *st)
{
    return enter(store, PEN_NEED_GROW, st) &&
           leave(store, NULL,
                 note_space(store, claim->job_id,
                            pen_policy_artefact_put(store, claim, layer, format, data, bytes, st)));
}

void pen_store_delegate_checkpoints(struct pen_store *store)
{
    store->driver->delegates_checkpoints = true;
}

bool pen_store_checkpoint_due(const struct pen_store *store)
{
    return store->driver->checkpoint_due;
}

bool pen_store_checkpoint(struct pen_store *store, struct pen_status *st)
{
    struct call_start start = begin(store, "checkpoint");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, store->driver->ops->checkpoint(store->driver, st));
}

bool pen_store_purge(struct pen_store *store, int64_t key_age_ms, int64_t stats_age_ms,
                     struct pen_status *st)
{
    struct call_start start = begin(store, "purge");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_purge(store, key_age_ms, stats_age_ms, st));
}

static bool purge_slice(struct pen_store *store, bool *more, struct pen_status *st)
{
    struct call_start start = begin(store, "purge_slice");
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, &start, pen_policy_purge_slice(store, more, st));
}

bool pen_store_purge_slice(struct pen_store *store, bool *more, struct pen_status *st)
{
    int tries = 0;
    bool ok;
    *more = false;
    do
        ok = purge_slice(store, more, st);
    while (!ok && *more && may_repeat(store, &tries, st));
    return ok;
}

bool pen_store_scrub(struct pen_store *store, struct pen_scrub *scrub, bool *more,
                     struct pen_status *st)
{
    *more = false;
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_scrub(store, scrub, more, st));
}

bool pen_store_set_retention(struct pen_store *store, const struct pen_retention *retention,
                             struct pen_status *st)
{
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, NULL, pen_policy_set_retention(store, retention, st));
}

bool pen_store_retention(struct pen_store *store, struct pen_retention *out, struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_retention(store, out, st));
}

bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st)
{
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, NULL, pen_policy_expired(store, id, found, st));
}

bool pen_store_cache_put(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, const void *data, size_t bytes, struct pen_status *st)
{
    const struct pen_artefact_key key = {.view = view, .layer = layer, .format = format};
    return enter(store, PEN_NEED_GROW, st) &&
           leave(store, NULL, pen_policy_cache_put(store, id, &key, data, bytes, st));
}

bool pen_store_evict(struct pen_store *store, bool *more, struct pen_status *st)
{
    return enter(store, PEN_NEED_WRITE, st) &&
           leave(store, NULL, pen_policy_evict(store, more, st));
}

void pen_store_set_clock(struct pen_store *store, int64_t (*now_ms)(void *user), void *user)
{
    store->driver->clock = now_ms;
    store->driver->clock_user = user;
}

bool pen_store_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                     struct pen_status *st)
{
    return enter(store, PEN_NEED_READ, st) &&
           leave(store, NULL, pen_policy_audit(store, each, user, found, st));
}

void pen_store_wait(struct pen_store *store, enum pen_signal signal, uint32_t *seen, int timeout_ms)
{
    store->driver->ops->wait(store->driver, signal, seen, timeout_ms);
}

void pen_store_wake(struct pen_store *store, enum pen_signal signal)
{
    store->driver->ops->wake(store->driver, signal);
}
