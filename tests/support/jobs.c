/* SPDX-License-Identifier: MIT */
#include "support/jobs.h"

#include <check.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/random.h"
#include "support/suite.h"

void jobs_bed_open(struct jobs_bed *bed)
{
    *bed = (struct jobs_bed){.bed = bed->bed, .fault = bed->fault};
    store_bed_open(&bed->bed);
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    bed->jobs = pen_jobs_open(bed->bed.url, &limits, &st);
    store_must(bed->jobs != NULL, &st, "jobs");
}

void jobs_bed_close(struct jobs_bed *bed)
{
    if (bed->working)
        jobs_worker_stop(bed);
    pen_jobs_close(bed->jobs);
    store_bed_close(&bed->bed);
}

static void *work(void *user)
{
    struct jobs_bed *bed = user;
    struct pen_worker_options options = {.store_url = bed->bed.url,
                                         .id = "test:1:1",
                                         .threads = 2,
                                         .keep_ms = random_fewer(),
                                         .max_seconds = bed->max_seconds,
                                         .batch_ms = bed->batch_ms,
                                         .fault = bed->fault,
                                         .stuck = bed->stuck};
    struct pen_status st;
    bool ok = pen_worker_run(&options, &bed->stop, &st);
    if (!ok)
        fprintf(stderr, "worker: %s\n", st.msg);
    return ok ? bed : NULL;
}

void jobs_worker_start(struct jobs_bed *bed)
{
    atomic_store(&bed->stop, false);
    ck_assert_int_eq(pthread_create(&bed->thread, NULL, work, bed), 0);
    bed->working = true;
}

void jobs_worker_stop(struct jobs_bed *bed)
{
    void *ok = NULL;
    atomic_store(&bed->stop, true);
    pen_store_wake(bed->bed.store);
    pthread_join(bed->thread, &ok);
    bed->working = false;
    ck_assert_ptr_nonnull(ok);
}

pid_t jobs_worker_fork(const struct jobs_bed *bed)
{
    pen_store_close(store_bed_handle(&bed->bed)); /* a worker makes no store */
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0) {
        struct pen_worker_options options = {.store_url = bed->bed.url,
                                             .id = "doomed:1:1",
                                             .threads = 2,
                                             .keep_ms = random_fewer(),
                                             .batch_ms = bed->batch_ms,
                                             .fault = bed->fault};
        atomic_bool stop = false;
        struct pen_status st;
        pen_worker_run(&options, &stop, &st);
        _exit(1);
    }
    return pid;
}

void jobs_submit(struct jobs_bed *bed, const char *body, char id[PEN_ID_BYTES])
{
    struct pen_submission in = {.body = body, .bytes = strlen(body)};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    if (!pen_jobs_submit(bed->jobs, &in, &out, &errors))
        ck_abort_msg("refused: %s: %s", errors.item[0].at, errors.item[0].msg);
    memcpy(id, out.id, PEN_ID_BYTES);
    pen_buf_release(&out.answer);
}

static bool read_kept(struct jobs_bed *bed, const char *id, const char *name, struct pen_buf *kept)
{
    char layer[64];
    struct pen_status st;
    snprintf(layer, sizeof layer, "kept:%s", name);
    return pen_store_artefact(bed->bed.store, id, 0, layer, "kept", kept, &st);
}

bool jobs_has_kept(struct jobs_bed *bed, const char *id, const char *name)
{
    struct pen_buf kept = {0};
    const bool has = read_kept(bed, id, name, &kept);
    pen_buf_release(&kept);
    return has;
}

struct pen_buf jobs_wait_kept(struct jobs_bed *bed, const char *id, const char *name)
{
    struct pen_buf kept = {0};
    for (int i = 0; i < 6000; i++) {
        if (read_kept(bed, id, name, &kept))
            return kept;
        ck_assert_msg(!pen_job_state_ended(store_job_state(bed->bed.store, id)), "it has ended");
        usleep(10000);
    }
    ck_abort_msg("nothing is kept");
}

void jobs_put_kept(struct jobs_bed *bed, const char *id, const char *name, const void *data,
                   size_t bytes)
{
    char layer[64];
    snprintf(layer, sizeof layer, "kept:%s", name);
    store_put(bed->bed.store, &(struct store_artefact){id, 0, layer, "kept", data, bytes});
}

/* Waits until what is kept is enough, for four minutes at most. */
static void wait_enough(struct jobs_bed *bed, const char *id, const char *name,
                        bool (*enough)(const struct pen_buf *kept))
{
    for (int i = 0; i < 24000; i++) {
        struct pen_buf kept = jobs_wait_kept(bed, id, name);
        const bool done = !enough || enough(&kept);
        pen_buf_release(&kept);
        if (done)
            return;
        usleep(10000);
    }
    ck_abort_msg("not enough is kept");
}

struct pen_buf jobs_begin_and_kill(struct jobs_bed *bed, const char *body, char id[PEN_ID_BYTES],
                                   const char *name, bool (*enough)(const struct pen_buf *kept))
{
    int status;
    store_bed_make(&bed->bed);
    const pid_t pid = jobs_worker_fork(bed);
    jobs_bed_open(bed);
    jobs_submit(bed, body, id);
    wait_enough(bed, id, name, enough);
    kill(pid, SIGKILL);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    ck_assert_int_eq(store_worker_died(bed->bed.store, "doomed:1:1"), 1);
    return jobs_wait_kept(bed, id, name); /* it may have kept more since */
}

enum pen_job_state jobs_wait(struct jobs_bed *bed, const char *id)
{
    const int64_t until_ns = pen_clock_ns() + INT64_C(1000000000) * SUITE_HANG_S;
    uint32_t seen = 0;
    while (pen_clock_ns() < until_ns) {
        enum pen_job_state state = store_job_state(bed->bed.store, id);
        if (pen_job_state_ended(state))
            return state;
        pen_store_wait(bed->bed.store, &seen, 100);
    }
    ck_abort_msg("job %s does not end", id);
}

bool jobs_did_not_wait(struct jobs_bed *bed, const char *first, const char *second)
{
    struct pen_job_record a = store_job_get(bed->bed.store, first),
                          b = store_job_get(bed->bed.store, second);
    const bool answer = a.finished_ms < b.finished_ms || a.created_ms > b.finished_ms;
    pen_job_record_release(&a);
    pen_job_record_release(&b);
    return answer;
}

json_t *jobs_get(struct jobs_bed *bed, const char *id)
{
    struct pen_job_snapshot snapshot;
    struct pen_status st;
    store_must(pen_jobs_get(bed->jobs, id, &snapshot, &st), &st, "get");
    return snapshot.json;
}

struct pen_buf jobs_image(struct jobs_bed *bed, const char *id, const char *view,
                          const char *format)
{
    struct pen_image_query query = {.view = view, .format = format};
    struct pen_image image;
    struct pen_status st;
    store_must(pen_jobs_image(bed->jobs, id, &query, &image, &st), &st, "image");
    return image.bytes;
}

const char *jobs_scene(const char *more)
{
    static char text[4096];
    snprintf(text, sizeof text,
             "{\"format\": \"penumbra-scene/1\", \"ambient\": [0.1, 0.1, 0.1],"
             " \"camera\": {\"position\": [0, 1, 10], \"look_at\": [0, 0, 0]},"
             " \"lights\": [{\"type\": \"point\", \"intensity\": [5, 5, 5],"
             " \"position\": [3, 6, 4], \"attenuation\": [1, 0, 0.01]}],"
             " \"objects\": ["
             "{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 2,"
             " \"material\": {\"kd\": 0.6, \"ks\": 0.4, \"shininess\": 20, \"kr\": 0.3}},"
             "{\"type\": \"plane\", \"point\": [0, -2, 0], \"normal\": [0, 1, 0],"
             " \"material\": {\"kd\": [0.2, 0.5, 0.3]}}]%s}",
             more);
    return text;
}
