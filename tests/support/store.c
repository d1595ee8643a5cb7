/* SPDX-License-Identifier: MIT */
#include "support/store.h"

#include <check.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void store_must(bool ok, const struct pen_status *st, const char *what)
{
    if (!ok)
        ck_abort_msg("%s: %s (%s)", what, st->msg, pen_code_name(st->code));
}

struct pen_store *store_bed_handle(const struct store_bed *bed)
{
    struct pen_status st;
    struct pen_store *store = pen_store_open(bed->url, true, &st);
    store_must(store != NULL, &st, "open");
    return store;
}

/* Runs psql on the database of tests/support/postgres.sh. */
__attribute__((format(printf, 1, 0))) static void run_sql(const char *format, const char *name)
{
    char sql[128], command[256];
    snprintf(sql, sizeof sql, format, name);
    snprintf(command, sizeof command, "psql -qXtd test -c '%s' 2>&1", sql);
    ck_assert_msg(system(command) == 0, "%s failed", command);
}

/* Each bed of PostgreSQL has a schema of its own, named as its folder. */
void store_bed_make(struct store_bed *bed)
{
    const char *engine = getenv("PEN_STORE_ENGINE");
    const bool postgres = engine && strcmp(engine, "postgres") == 0;
    ck_assert_msg(!engine || postgres || strcmp(engine, "sqlite") == 0, "no engine is called %s",
                  engine);
    *bed = (struct store_bed){0};
    snprintf(bed->folder, sizeof bed->folder, "/tmp/penumbra-test-XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(bed->folder));
    snprintf(bed->url, sizeof bed->url, "%s/penumbra.db", bed->folder);
    if (!postgres)
        return;
    snprintf(bed->schema, sizeof bed->schema, "t%s", strrchr(bed->folder, '-') + 1);
    run_sql("CREATE SCHEMA %s", bed->schema);
    snprintf(bed->url, sizeof bed->url, "postgresql:///test?options=-csearch_path%%3D%s",
             bed->schema);
}

void store_bed_open(struct store_bed *bed)
{
    if (!bed->folder[0])
        store_bed_make(bed);
    bed->store = store_bed_handle(bed);
}

static int64_t read_time(void *time_ms)
{
    return *(const int64_t *)time_ms;
}

void store_bed_set_clock(const struct store_bed *bed, int64_t *time_ms)
{
    pen_store_set_clock(bed->store, read_time, time_ms);
}

/* The store has no damage. */
static void check(struct pen_store *store)
{
    struct pen_status st;
    bool finished = false;
    store_must(pen_store_check(store, 0, &finished, &st), &st, "check");
    ck_assert(finished);
}

static void remove_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    ck_assert_ptr_nonnull(dir);
    char path[400];
    for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] != '.')
            unlink(path);
    }
    closedir(dir);
    ck_assert_int_eq(rmdir(folder), 0);
}

void store_bed_close(struct store_bed *bed)
{
    if (!bed->schema[0])
        check(bed->store);
    pen_store_close(bed->store);
    if (bed->schema[0])
        run_sql("SET client_min_messages = error; DROP SCHEMA %s CASCADE", bed->schema);
    remove_folder(bed->folder);
    *bed = (struct store_bed){0};
}

void store_job_init(struct store_job *job, int n, int views, int batches)
{
    static const char *const names[8] = {"a", "b", "c", "d", "e", "f", "g", "h"};
    *job = (struct store_job){0};
    snprintf(job->id, sizeof job->id, "01900000-0000-7000-8000-%012d", n);
    snprintf(job->scene, sizeof job->scene, "{\"scene\": %d}", n % 8);
    job->sha256[0] = (unsigned char)(n % 8);
    for (int v = 0; v < views; v++) {
        job->view[v] = (struct pen_view_new){names[v], STORE_JOB_TILE * batches, STORE_JOB_TILE};
        for (int b = 0; b < batches; b++)
            job->batch[v * batches + b] =
                (struct pen_batch_new){.view = v,
                                       .first_tile = b,
                                       .tile_count = 1,
                                       .pixels = STORE_JOB_TILE * STORE_JOB_TILE};
    }
    job->job = (struct pen_job_new){
        .id = job->id,
        .created_ms = 1000 + n,
        .kind = "render",
        .request = "{\"name\": \"test\"}",
        .scene = job->scene,
        .scene_bytes = strlen(job->scene),
        .scene_sha256 = job->sha256,
        .max_attempts = 3,
        .view_count = views,
        .views = job->view,
        .batch_count = views * batches,
        .batches = job->batch,
    };
}

void store_study_init(struct store_job *job, int n, int runs)
{
    store_job_init(job, n, 1, 1);
    job->job.kind = "benchmark";
    job->batch[0] = (struct pen_batch_new){.pixels = runs, .kind = PEN_BATCH_STUDY};
}

void store_job_submit(struct pen_store *store, const struct store_job *job)
{
    struct pen_status st;
    struct pen_buf answer = {0};
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    store_must(pen_store_submit(store, &job->job, &result, &answer, &st), &st, "submit");
    ck_assert_int_eq(result, PEN_SUBMIT_CREATED);
    pen_buf_release(&answer);
}

/* Each claim of a test is a new one. */
static int64_t next_serial(void)
{
    static int64_t serial;
    return ++serial;
}

struct pen_claim store_claim(struct pen_store *store, const char *worker)
{
    struct pen_status st;
    struct pen_claim claim = {0};
    bool found = false;
    store_must(pen_store_claim(store, worker, STORE_LEASE_MS, next_serial(), &claim, &found, &st),
               &st, "claim");
    ck_assert(found);
    return claim;
}

enum pen_code store_commit(struct pen_store *store, const struct pen_claim *claim)
{
    struct pen_status st = {0};
    size_t values = (size_t)claim->pixels * 3;
    float *rgb = malloc(values * sizeof *rgb + 1);
    ck_assert_ptr_nonnull(rgb);
    for (size_t i = 0; i < values; i++)
        rgb[i] = (float)claim->first_tile + (float)i / 64;
    struct pen_result result = {.stats = "{}"};
    if (claim->kind == PEN_BATCH_RENDER) {
        result.rgb = rgb;
        result.pixels = claim->pixels;
    }
    if (claim->kind == PEN_BATCH_STUDY) {
        result.layer = "report";
        result.format = "json";
        result.artefact = "{}";
        result.artefact_bytes = strlen("{}");
    } else if (claim->kind == PEN_BATCH_ASSEMBLE || claim->view_batches == 1) {
        result.layer = "beauty";
        result.format = "png";
        result.artefact = "picture";
        result.artefact_bytes = strlen("picture");
    }
    enum pen_code code = pen_store_commit(store, claim, &result, NULL, &st) ? PEN_OK : st.code;
    free(rgb);
    return code;
}

int store_work_off(struct pen_store *store, const char *worker)
{
    struct pen_status st;
    for (int count = 0;; count++) {
        struct pen_claim claim;
        bool found = false;
        store_must(
            pen_store_claim(store, worker, STORE_LEASE_MS, next_serial(), &claim, &found, &st), &st,
            "claim");
        if (!found)
            return count;
        ck_assert_int_eq(store_commit(store, &claim), PEN_OK);
    }
}

int store_worker_died(struct pen_store *store, const char *id)
{
    const struct pen_worker_death death = {.worker = id, .end = PEN_WORKER_DIED};
    struct pen_status st;
    int opened = 0;
    store_must(pen_store_worker_ended(store, &death, &opened, &st), &st, "a worker's end");
    return opened;
}

int store_purge_slices(struct pen_store *store)
{
    struct pen_status st;
    int slices = 0;
    for (bool more = true; more; slices += more)
        store_must(pen_store_purge(store, &more, &st), &st, "slice");
    return slices;
}

void store_worker_seen(struct pen_store *store, const char *id)
{
    struct pen_status st;
    struct pen_worker_new worker = {.id = id, .threads = 2, .lease_ms = STORE_LEASE_MS};
    store_must(pen_store_worker_seen(store, &worker, &st), &st, "seen");
}

struct pen_job_record store_job_get(struct pen_store *store, const char *id)
{
    struct pen_status st;
    struct pen_job_record job;
    store_must(pen_store_job(store, id, &job, &st), &st, "get");
    return job;
}

enum pen_job_state store_job_state(struct pen_store *store, const char *id)
{
    struct pen_job_record job = store_job_get(store, id);
    enum pen_job_state state = job.state;
    pen_job_record_release(&job);
    return state;
}
