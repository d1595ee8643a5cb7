/* SPDX-License-Identifier: MIT */
/* Removed jobs. They are gone at once. Their rows are removed in slices, also after a kill in
 * between. Their statistics stay. */
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/store.h"
#include "support/store_rows.h"
#include "support/suite.h"

static struct store_bed bed;

static void expect_code(bool ok, const struct pen_status *st, enum pen_code code, const char *what)
{
    ck_assert_msg(!ok && st->code == code, "%s: %s: %s", what, ok ? "ok" : pen_code_name(st->code),
                  ok ? "" : st->msg);
}

static struct pen_claim claim_job(struct store_job *in, int n)
{
    store_job_init(in, n, 2, 3);
    store_job_submit(bed.store, in);
    return store_claim(bed.store, "w");
}

static void put_layers(const struct pen_claim *claim, int count, size_t bytes)
{
    struct pen_status st;
    char layer[24];
    unsigned char *data = malloc(bytes);
    ck_assert_ptr_nonnull(data);
    for (int i = 0; i < count; i++) {
        memset(data, i, bytes);
        snprintf(layer, sizeof layer, "layer%d", i);
        store_must(pen_store_artefact_put(bed.store, claim, layer, "pfm", data, bytes, &st), &st,
                   "put");
    }
    free(data);
}

/* A job that has succeeded, with so many layers. */
static void finish_job(struct store_job *in, int n, int layers, size_t bytes)
{
    const struct pen_claim claim = claim_job(in, n);
    put_layers(&claim, layers, bytes);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_work_off(bed.store, "w");
}

static bool read_nothing(void *user, const struct pen_batch_stats *batch)
{
    (void)batch;
    ++*(int *)user;
    return true;
}

START_TEST(test_removal__every_call_about_a_removed_job_says_gone)
{
    struct store_job in;
    struct pen_status st = {0};
    struct pen_job_record job;
    struct pen_buf out = {0};
    int calls = 0;
    store_bed_open(&bed);
    finish_job(&in, 1, 1, 1000);
    store_must(pen_store_delete(bed.store, in.id, NULL, "{\"rays\": 7}", &st), &st, "delete");
    for (int purged = 0; purged < 2; purged++) {
        struct pen_store *s = bed.store;
        expect_code(pen_store_job(s, in.id, &job, &st), &st, PEN_GONE, "job");
        expect_code(pen_store_scene(s, in.id, &out, &st), &st, PEN_GONE, "scene");
        expect_code(pen_store_cancel(s, in.id, NULL, &st), &st, PEN_GONE, "cancel");
        expect_code(pen_store_stats(s, in.id, read_nothing, &calls, &st), &st, PEN_GONE, "stats");
        expect_code(pen_store_artefact(s, in.id, 0, "beauty", "png", &out, &st), &st, PEN_GONE,
                    "picture");
        expect_code(pen_store_delete(s, in.id, NULL, "{}", &st), &st, PEN_GONE, "delete again");
        store_purge_slices(s);
    }
    ck_assert_int_eq(calls, 0);
    ck_assert_uint_eq(out.bytes, 0);
    store_must(pen_store_removed_stats(bed.store, in.id, &out, &st), &st, "statistics");
    ck_assert_str_eq((char *)out.data, "{\"rays\": 7}");
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_removal__statistics_are_dropped_on_demand_and_forgotten_with_age)
{
    static const int64_t day_ms = 86400000;
    int64_t now_ms = 1000 * day_ms;
    struct store_job job[3];
    struct pen_status st = {0};
    struct pen_buf out = {0};
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &now_ms);
    for (int i = 0; i < 3; i++)
        finish_job(&job[i], i, 0, 0);
    store_must(pen_store_delete(bed.store, job[0].id, NULL, NULL, &st), &st, "delete");
    expect_code(pen_store_removed_stats(bed.store, job[0].id, &out, &st), &st, PEN_GONE, "none");
    expect_code(pen_store_delete(bed.store, job[0].id, NULL, NULL, &st), &st, PEN_GONE, "again");
    store_must(pen_store_delete(bed.store, job[1].id, NULL, "{}", &st), &st, "delete");
    store_must(pen_store_delete(bed.store, job[1].id, NULL, NULL, &st), &st, "drop");
    expect_code(pen_store_removed_stats(bed.store, job[1].id, &out, &st), &st, PEN_GONE, "dropped");
    store_must(pen_store_delete(bed.store, job[2].id, NULL, "{}", &st), &st, "delete");
    store_purge_slices(bed.store);
    expect_code(pen_store_removed_stats(bed.store, job[0].id, &out, &st), &st, PEN_GONE, "young");
    for (int day = 0; day < 2; day++) {
        now_ms += day_ms * 3 / 4;
        store_purge_slices(bed.store);
    }
    expect_code(pen_store_removed_stats(bed.store, job[0].id, &out, &st), &st, PEN_NOT_FOUND,
                "old");
    store_must(pen_store_removed_stats(bed.store, job[2].id, &out, &st), &st, "kept");
    for (int64_t at = 0; at < 5 * 366; at++) { /* a jump of more than a day would let ages wait */
        now_ms += day_ms * 9 / 10;
        store_purge_slices(bed.store);
    }
    store_must(pen_store_removed_stats(bed.store, job[2].id, &out, &st), &st, "kept");
    for (int64_t at = 0; at < 366; at++) {
        now_ms += day_ms * 9 / 10;
        store_purge_slices(bed.store);
    }
    expect_code(pen_store_removed_stats(bed.store, job[2].id, &out, &st), &st, PEN_NOT_FOUND,
                "five years");
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_removal__statistics_have_an_eighth_of_keep_bytes_and_the_oldest_go)
{
    enum { JOBS = 8, TEXT = 2000 };
    static char text[TEXT + 1];
    const struct pen_retention limits = {.keep_bytes = 8 * 4 * (TEXT + 512)};
    int64_t now_ms = 1000000000;
    struct store_job job[JOBS];
    struct pen_status st = {0};
    struct pen_buf out = {0};
    memset(text, ' ', TEXT);
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &now_ms);
    for (int i = 0; i < JOBS; i++) {
        finish_job(&job[i], i, 0, 0);
        now_ms += 1000;
        store_must(pen_store_delete(bed.store, job[i].id, NULL, text, &st), &st, "delete");
    }
    store_must(pen_store_set_retention(bed.store, &limits, &st), &st, "limits");
    store_purge_slices(bed.store);
    for (int i = 0; i < JOBS; i++) {
        out.bytes = 0;
        const bool kept = pen_store_removed_stats(bed.store, job[i].id, &out, &st);
        ck_assert_msg(kept == (i >= JOBS - 4), "job %d: %s", i, kept ? "kept" : st.msg);
        ck_assert(kept || st.code == PEN_GONE);
    }
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_removal__a_removed_job_is_neither_listed_nor_counted)
{
    struct store_job in[3];
    struct pen_status st = {0};
    struct pen_counts counts;
    struct pen_job_filter filter = {.state = -1, .limit = 10};
    struct pen_job_record *jobs;
    int count;
    store_bed_open(&bed);
    for (int n = 0; n < 3; n++)
        finish_job(&in[n], n, 0, 0);
    store_must(pen_store_delete(bed.store, in[1].id, NULL, NULL, &st), &st, "delete");
    for (int by_state = 0; by_state < 2; by_state++) {
        filter.state = by_state ? PEN_JOB_SUCCEEDED : -1;
        store_must(pen_store_jobs(bed.store, &filter, &jobs, &count, &st), &st, "list");
        ck_assert_int_eq(count, 2);
        ck_assert_str_eq(jobs[0].id, in[2].id);
        ck_assert_str_eq(jobs[1].id, in[0].id);
        pen_job_records_free(jobs, count);
    }
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    ck_assert_int_eq(counts.jobs[PEN_JOB_SUCCEEDED], 2);
    store_bed_close(&bed);
}
END_TEST

static int64_t file_bytes(void)
{
    struct pen_counts counts;
    struct pen_status st;
    struct stat info;
    if (bed.schema[0]) {
        store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
        return counts.bytes;
    }
    ck_assert_int_eq(stat(bed.url, &info), 0);
    return (int64_t)info.st_size;
}

/* By another handle: a reader's function must not use the reader's. */
static bool remove_now(void *user, int first_tile, int tile_count, const float *rgb, int64_t pixels)
{
    struct pen_status st;
    struct pen_store *store = store_bed_handle(&bed);
    (void)first_tile, (void)tile_count, (void)rgb, (void)pixels;
    store_must(pen_store_delete(store, user, NULL, NULL, &st), &st, "delete");
    store_purge_slices(store);
    pen_store_close(store);
    return true;
}

/* Its first pixels are not taken for all of them. */
START_TEST(test_removal__a_job_that_goes_while_it_is_read_is_gone)
{
    struct store_job in;
    struct pen_status st = {0};
    store_bed_open(&bed);
    finish_job(&in, 1, 0, 0);
    expect_code(pen_store_pixels(bed.store, in.id, 0, remove_now, in.id, &st), &st, PEN_GONE,
                "pixels");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_removal__a_large_job_goes_in_many_slices_and_its_space_returns)
{
    enum { LAYERS = 12, MIB = 1 << 20 };
    struct store_job in, other;
    struct pen_status st = {0};
    store_bed_open(&bed);
    finish_job(&other, 2, 0, 0);
    finish_job(&in, 1, LAYERS, 3 * MIB);
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    ck_assert_int_gt(store_purge_slices(bed.store), LAYERS / 2);
    ck_assert_int_lt(file_bytes(), MIB);
    ck_assert_int_eq(store_job_state(bed.store, other.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

/* A document goes with the last job that has it. */
START_TEST(test_removal__a_scene_goes_with_its_last_job)
{
    struct store_job job[2];
    struct pen_status st = {0};
    store_bed_open(&bed);
    for (int i = 0; i < 2; i++)
        finish_job(&job[i], 8 * i, 0, 0);
    ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM scene"), 1);
    for (int i = 0; i < 2; i++) {
        store_must(pen_store_delete(bed.store, job[i].id, NULL, NULL, &st), &st, "delete");
        store_purge_slices(bed.store);
        ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM scene"), 1 - i);
    }
    ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM object"), 0);
    ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM part"), 0);
    store_bed_close(&bed);
}
END_TEST

/* Values that were being written when their worker died, and what a later value has replaced. */
START_TEST(test_removal__values_that_nobody_uses_go)
{
    enum { BYTES = 3 << 20 };
    struct store_job in;
    struct pen_status st = {0};
    int64_t now_ms = 1000000000;
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &now_ms);
    const struct pen_claim claim = claim_job(&in, 1);
    put_layers(&claim, 1, BYTES);
    put_layers(&claim, 1, BYTES);
    store_change(bed.url,
                 "INSERT INTO object SELECT 999, job, view, batch, attempt, layer, format, 0, "
                 "bytes, checksum, touched_ms FROM object WHERE layer = 'layer0' "
                 "AND state = 1",
                 NULL, 0);
    store_purge_slices(bed.store);
    ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM object WHERE state <> 1"), 1);
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    now_ms += 61000;
    store_purge_slices(bed.store);
    ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM object WHERE state <> 1"), 0);
    ck_assert_int_eq(store_value(bed.url, "SELECT count(*) FROM part"), 3 + 1);
    store_bed_close(&bed);
}
END_TEST

/* Removes the job and some slices of it, and dies without notice. */
static void die_in_between(const char *id, int slices)
{
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0) {
        struct pen_status st;
        bool more, ok;
        struct pen_store *store = store_bed_handle(&bed);
        ok = pen_store_delete(store, id, NULL, "{}", &st);
        for (int i = 0; ok && i < slices; i++)
            ok = pen_store_purge(store, &more, &st);
        raise(ok ? SIGKILL : SIGTERM);
    }
    int status;
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    ck_assert_int_eq(WTERMSIG(status), SIGKILL);
}

START_TEST(test_removal__goes_on_after_a_kill)
{
    for (int slices = 0; slices < 6; slices++) {
        struct store_job in;
        struct pen_buf out = {0};
        struct pen_status st = {0};
        struct pen_job_record job;
        store_bed_open(&bed);
        finish_job(&in, 1, 2, 5 << 20);
        pen_store_close(bed.store);
        die_in_between(in.id, slices);
        bed.store = store_bed_handle(&bed);
        ck_assert_int_eq(store_contradictions(bed.url), 0);
        expect_code(pen_store_job(bed.store, in.id, &job, &st), &st, PEN_GONE, "job");
        store_purge_slices(bed.store);
        store_must(pen_store_removed_stats(bed.store, in.id, &out, &st), &st, "statistics");
        ck_assert_int_lt(file_bytes(), 1 << 20);
        pen_buf_release(&out);
        store_bed_close(&bed);
    }
}
END_TEST

static atomic_bool purged;

/* Pauses after a slice for as long as that took, as the housekeeper does. */
static void *purge_on(void *arg)
{
    int64_t *longest_ns = arg;
    struct pen_status st;
    struct pen_store *store = store_bed_handle(&bed);
    for (bool more = true; more;) {
        const int64_t begun_ns = pen_clock_ns();
        store_must(pen_store_purge(store, &more, &st), &st, "slice");
        const int64_t took_ns = pen_clock_ns() - begun_ns;
        *longest_ns = took_ns > *longest_ns ? took_ns : *longest_ns;
        usleep((useconds_t)(took_ns / 1000) + 1000);
    }
    pen_store_close(store);
    atomic_store(&purged, true);
    return NULL;
}

START_TEST(test_removal__of_a_gigabyte_holds_no_submit_for_a_tenth_of_a_second)
{
    enum { LAYERS = 64, BYTES = 16 << 20 };
    struct store_job in, small;
    struct pen_status st = {0};
    pthread_t thread;
    int64_t longest_ns = 0, slice_ns = 0;
    int submits = 0;
    store_bed_open(&bed);
    finish_job(&in, 0, LAYERS, BYTES);
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    ck_assert_int_eq(pthread_create(&thread, NULL, purge_on, &slice_ns), 0);
    for (; !atomic_load(&purged); submits++) {
        store_job_init(&small, submits + 1, 1, 1);
        const int64_t begun_ns = pen_clock_ns();
        store_job_submit(bed.store, &small);
        const int64_t took_ns = pen_clock_ns() - begun_ns;
        longest_ns = took_ns > longest_ns ? took_ns : longest_ns;
    }
    pthread_join(thread, NULL);
    printf("%d submits beside it, the longest %.1f ms; the longest slice %.1f ms\n", submits,
           (double)longest_ns / 1e6, (double)slice_ns / 1e6);
    ck_assert_int_gt(submits, 10);
    ck_assert_int_le(longest_ns, 100000000);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("removed jobs", test_removal__every_call_about_a_removed_job_says_gone,
          test_removal__statistics_are_dropped_on_demand_and_forgotten_with_age,
          test_removal__statistics_have_an_eighth_of_keep_bytes_and_the_oldest_go,
          test_removal__a_removed_job_is_neither_listed_nor_counted,
          test_removal__a_large_job_goes_in_many_slices_and_its_space_returns,
          test_removal__a_scene_goes_with_its_last_job, test_removal__values_that_nobody_uses_go,
          test_removal__a_job_that_goes_while_it_is_read_is_gone,
          test_removal__goes_on_after_a_kill, PEN_TIMED,
          test_removal__of_a_gigabyte_holds_no_submit_for_a_tenth_of_a_second)
