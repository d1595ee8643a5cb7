/* SPDX-License-Identifier: MIT */
/* Stores that earlier versions left behind when they were killed, one of each schema: what is in
 * them and how they were made is in tests/store/kept/README.md. Each is opened and migrated, its
 * live jobs are finished by a worker, and every picture is compared with a fresh render. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zstd.h>

#include "base/clock.h"
#include "base/log.h"
#include "support/jobs.h"
#include "support/random.h"
#include "support/store_sql.h"
#include "support/suite.h"

enum {
    SCHEMAS = 16,
    FIRST_WITH_BENCHMARKS = 6,
    FIRST_WITH_LOCK_FILES = 9,
    FIRST_WITH_SHARES = 12,
    LAST_WITH_ADDRESSES = 15,
    FILE_BYTES = 1 << 20
};

/* The jobs of every kept store, by number. */
static const struct {
    const char *name;
    enum pen_job_state kept, finished;
    const char *views[2]; /* to be compared */
} kept_jobs[] = {
    {"done", PEN_JOB_SUCCEEDED, PEN_JOB_SUCCEEDED, {"main"}},
    {"failed", PEN_JOB_FAILED, PEN_JOB_FAILED, {NULL}},
    {"half", PEN_JOB_RUNNING, PEN_JOB_SUCCEEDED, {"main"}},
    {"queued", PEN_JOB_QUEUED, PEN_JOB_SUCCEEDED, {"main"}},
    {"views", PEN_JOB_QUEUED, PEN_JOB_SUCCEEDED, {"front", "side"}},
    {"cancelled", PEN_JOB_CANCELLED, PEN_JOB_CANCELLED, {NULL}},
    {"benchmark", PEN_JOB_QUEUED, PEN_JOB_SUCCEEDED, {NULL}},
};
enum { JOBS = (int)(sizeof kept_jobs / sizeof kept_jobs[0]), HALF = 2, QUEUED = 3 };

static const char *const formats[] = {"png", "pfm"};
enum { FORMATS = 2 };

static int jobs_in(int schema)
{
    return schema < FIRST_WITH_BENCHMARKS ? JOBS - 1 : JOBS;
}

static size_t read_file(const char *name, void *to, size_t capacity)
{
    char path[100];
    snprintf(path, sizeof path, "tests/store/kept/%s", name);
    FILE *file = fopen(path, "rb");
    ck_assert_msg(file != NULL, "%s", path);
    size_t bytes = fread(to, 1, capacity, file);
    fclose(file);
    ck_assert_uint_lt(bytes, capacity);
    return bytes;
}

/* A bed whose folder has the kept store in the place of its own, not yet opened. */
static void decompress(struct store_bed *bed, int schema)
{
    static char compressed[FILE_BYTES], file[FILE_BYTES];
    char name[40];
    store_bed_make(bed);
    snprintf(name, sizeof name, "schema-%d.db.zst", schema);
    size_t bytes = read_file(name, compressed, sizeof compressed);
    bytes = ZSTD_decompress(file, sizeof file, compressed, bytes);
    ck_assert_msg(!ZSTD_isError(bytes), "%s", name);
    int fd = open(bed->url, O_WRONLY | O_CREAT | O_EXCL, 0600);
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(write(fd, file, bytes), (ssize_t)bytes);
    close(fd);
    ck_assert_int_eq(store_schema_version(bed->url), schema);
}

/* The ids of a store's jobs in the order of their numbers, in each the state expected. */
static void list(struct pen_store *store, int schema, bool finished, char id[][PEN_ID_BYTES])
{
    struct pen_job_filter filter = {.state = -1, .limit = 20};
    struct pen_job_record *jobs;
    struct pen_status st;
    int count;
    store_must(pen_store_jobs(store, &filter, &jobs, &count, &st), &st, "list");
    ck_assert_int_eq(count, jobs_in(schema));
    for (int i = 0; i < count; i++) {
        const struct pen_job_record *job = &jobs[count - 1 - i];
        enum pen_job_state state = finished ? kept_jobs[i].finished : kept_jobs[i].kept;
        ck_assert_int_eq(job->number, i + 1);
        ck_assert_msg(job->state == state, "schema %d, job %s: %s", schema, kept_jobs[i].name,
                      pen_job_state_name(job->state));
        ck_assert_int_eq(job->error != NULL, state == PEN_JOB_FAILED);
        memcpy(id[i], job->id, PEN_ID_BYTES);
    }
    pen_job_records_free(jobs, count);
}

/* The batches of the job that is half done. */
struct half {
    int64_t leased;
    int count[PEN_BATCH_STATE_COUNT];
};

static bool note_batch(void *user, const struct pen_batch_record *batch)
{
    struct half *half = user;
    half->count[batch->state]++;
    if (batch->state == PEN_BATCH_LEASED)
        half->leased = batch->batch;
    return true;
}

static struct half batches_of_half(struct pen_store *store, const char *id)
{
    struct half half = {0};
    struct pen_status st;
    store_must(pen_store_batches(store, id, note_batch, &half, &st), &st, "batches");
    ck_assert_int_eq(half.count[PEN_BATCH_OPEN], 1);
    ck_assert_int_eq(half.count[PEN_BATCH_LEASED], 1);
    ck_assert_int_eq(half.count[PEN_BATCH_DONE], 1);
    return half;
}

/* Makes addresses begin to wait now: who has waited for long goes before jobs of higher priority.
 */
static void renew_waiting(const struct store_bed *bed, int schema)
{
    char sql[100];
    snprintf(sql, sizeof sql, "UPDATE peer SET waiting_since_ms = %lld",
             (long long)pen_clock_wall_ms());
    if (schema >= FIRST_WITH_SHARES)
        store_run_sql(bed, sql, NULL, 0);
}

/* The lease in the file ran out long ago: it is opened by its time, and the next claim gets it. */
static void check_expired(int schema)
{
    struct store_bed bed = {0};
    struct pen_status st;
    char id[JOBS][PEN_ID_BYTES];
    int opened = -1;
    decompress(&bed, schema);
    renew_waiting(&bed, schema);
    store_bed_open(&bed);
    list(bed.store, schema, false, id);
    struct half half = batches_of_half(bed.store, id[HALF]);
    store_must(pen_store_expire_leases(bed.store, NULL, &opened, &st), &st, "expire");
    ck_assert_int_eq(opened, 1);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_str_eq(claim.job_id, id[HALF]); /* it has the highest priority */
    ck_assert_int_eq(claim.batch, half.leased);
    ck_assert_int_eq(claim.attempt, 2);
    store_bed_close(&bed);
}

START_TEST(test_kept__expired_lease_is_claimed_again)
{
    for (int schema = 1; schema <= SCHEMAS; schema++)
        check_expired(schema);
}
END_TEST

/* Makes the lease in the file last and its job young, as if the daemon had been killed just now: a
 * job's time would be up a day after the store was made. The file in which its worker held a lock,
 * known by its inode since schema 9, is another one here. */
static void renew_lease(const struct store_bed *bed, int schema)
{
    char sql[100];
    snprintf(sql, sizeof sql, "UPDATE batch SET lease_until_ms = %lld WHERE state = 1",
             (long long)pen_clock_wall_ms() + 3600000);
    store_run_sql(bed, sql, NULL, 0);
    snprintf(sql, sizeof sql, "UPDATE job SET started_ms = %lld WHERE state = 1",
             (long long)pen_clock_wall_ms());
    store_run_sql(bed, sql, NULL, 0);
    if (schema >= FIRST_WITH_LOCK_FILES)
        store_run_sql(bed, "UPDATE worker SET lock_file = NULL", NULL, 0);
}

struct pictures {
    struct pen_buf picture[JOBS][2][FORMATS];
};

static void fetch(struct jobs_bed *bed, int schema, char id[][PEN_ID_BYTES], struct pictures *out)
{
    for (int i = 0; i < jobs_in(schema); i++) {
        for (int k = 0; k < 2 * FORMATS; k++) {
            const char *view = kept_jobs[i].views[k / FORMATS];
            if (view)
                out->picture[i][k / FORMATS][k % FORMATS] =
                    jobs_image(bed, id[i], view, formats[k % FORMATS]);
        }
    }
}

static void release(struct pictures *pictures)
{
    for (int i = 0; i < JOBS; i++) {
        for (int k = 0; k < 2 * FORMATS; k++)
            pen_buf_release(&pictures->picture[i][k / FORMATS][k % FORMATS]);
    }
}

/* Renders all jobs that have pictures, in a new store. */
static void render_fresh(struct pictures *out)
{
    static char body[10000];
    struct jobs_bed bed = {0};
    char name[40], id[JOBS][PEN_ID_BYTES];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < JOBS; i++) {
        if (!kept_jobs[i].views[0])
            continue;
        snprintf(name, sizeof name, "%s.json", kept_jobs[i].name);
        body[read_file(name, body, sizeof body)] = '\0';
        jobs_submit(&bed, body, id[i]);
        ck_assert_int_eq(jobs_wait(&bed, id[i]), PEN_JOB_SUCCEEDED);
    }
    fetch(&bed, SCHEMAS, id, out);
    jobs_bed_close(&bed);
}

static void compare(int schema, const struct pictures *got, const struct pictures *expected)
{
    int compared = 0;
    for (int i = 0; i < JOBS; i++) {
        for (int k = 0; k < 2 * FORMATS; k++) {
            const struct pen_buf *a = &got->picture[i][k / FORMATS][k % FORMATS];
            const struct pen_buf *b = &expected->picture[i][k / FORMATS][k % FORMATS];
            bool same = a->bytes == b->bytes && (!a->bytes || !memcmp(a->data, b->data, a->bytes));
            ck_assert_msg(same, "schema %d: %s.%s differs", schema, kept_jobs[i].name,
                          formats[k % FORMATS]);
            compared += a->bytes > 0;
        }
    }
    ck_assert_int_eq(compared, 5 * FORMATS);
}

/* A daemon that starts opens the leases of the dead, though they last; a worker does the rest. */
static void finish(int schema, const struct pictures *fresh)
{
    struct jobs_bed bed = {0};
    struct pictures got = {0};
    struct pen_status st;
    char id[JOBS][PEN_ID_BYTES];
    int opened = -1;
    decompress(&bed.bed, schema);
    renew_lease(&bed.bed, schema);
    jobs_bed_open(&bed);
    list(bed.bed.store, schema, false, id);
    store_must(pen_store_expire_leases(bed.bed.store, NULL, &opened, &st), &st, "expire");
    ck_assert_int_eq(opened, 0);
    store_must(pen_store_release_dead(bed.bed.store, &opened, &st), &st, "release");
    ck_assert_int_eq(opened, 1);
    jobs_worker_start(&bed);
    for (int i = 0; i < jobs_in(schema); i++)
        jobs_wait(&bed, id[i]);
    list(bed.bed.store, schema, true, id);
    fetch(&bed, schema, id, &got);
    compare(schema, &got, fresh);
    release(&got);
    jobs_bed_close(&bed);
}

START_TEST(test_kept__live_jobs_finish_with_the_pictures_of_a_fresh_render)
{
    struct pictures fresh = {0};
    pen_log_set_level(PEN_LOG_ERROR);
    render_fresh(&fresh);
    for (int schema = 1; schema <= SCHEMAS; schema += random_all() ? 1 : 2)
        finish(schema, &fresh);
    release(&fresh);
}
END_TEST

static enum pen_submit_result submit_again(struct pen_store *store, int n, const char *client)
{
    static const unsigned char other_body[32];
    struct store_job in;
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    struct pen_status st;
    store_job_init(&in, n, 1, 1);
    in.job.client = client;
    in.job.idempotency_key = kept_jobs[0].name;
    in.job.body_sha256 = other_body;
    in.job.answer = "{}";
    store_must(pen_store_submit(store, &in.job, &result, &answer, &st), &st, "submit");
    pen_buf_release(&answer);
    return result;
}

/* Jobs were submitted from 127.0.0.1, each with its name for a key. */
START_TEST(test_kept__addresses_become_clients_of_jobs_and_keys)
{
    struct store_bed bed = {0};
    struct pen_status st = {0};
    char id[JOBS][PEN_ID_BYTES];
    decompress(&bed, LAST_WITH_ADDRESSES);
    store_bed_open(&bed);
    list(bed.store, LAST_WITH_ADDRESSES, false, id);
    ck_assert(!pen_store_cancel(bed.store, id[QUEUED], "address:127.0.0.2", &st));
    ck_assert_int_eq(st.code, PEN_FORBIDDEN);
    store_must(pen_store_cancel(bed.store, id[QUEUED], "address:127.0.0.1", &st), &st, "cancel");
    ck_assert_int_eq(submit_again(bed.store, 1, "address:127.0.0.1"), PEN_SUBMIT_REUSED);
    ck_assert_int_eq(submit_again(bed.store, 2, "address:127.0.0.2"), PEN_SUBMIT_CREATED);
    store_bed_close(&bed);
}
END_TEST

/* An earlier schema without a kept store would be one that no test has seen migrate. */
START_TEST(test_kept__there_is_a_store_of_every_earlier_schema)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    ck_assert_int_le(store_schema_version(bed.url), SCHEMAS + 1);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("stores of earlier schemas", test_kept__expired_lease_is_claimed_again,
          test_kept__live_jobs_finish_with_the_pictures_of_a_fresh_render,
          test_kept__addresses_become_clients_of_jobs_and_keys,
          test_kept__there_is_a_store_of_every_earlier_schema)
