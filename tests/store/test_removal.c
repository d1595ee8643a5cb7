/* SPDX-License-Identifier: MIT */
/* Removed jobs: they are gone at once, their rows go in slices, also after a kill in between, and
 * their statistics stay. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;

static void expect_code(bool ok, const struct pen_status *st, enum pen_code code, const char *what)
{
    ck_assert_msg(!ok && st->code == code, "%s: %s: %s", what, ok ? "ok" : pen_code_name(st->code),
                  ok ? "" : st->msg);
}

/* A job that has succeeded, with a picture of so many bytes beside its own. */
static void finish_job(struct store_job *in, int n, size_t bytes)
{
    store_job_init(in, n, 2, 3);
    store_job_submit(bed.store, in);
    store_work_off(bed.store, "w");
    void *picture = calloc(1, bytes);
    ck_assert_ptr_nonnull(picture);
    for (int view = 0; bytes && view < 2; view++)
        store_put(bed.store,
                  &(struct store_artefact){in->id, view, "beauty", "pfm", picture, bytes});
    free(picture);
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
    finish_job(&in, 1, 1000);
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
        ck_assert(strstr(st.msg, "only its statistics are left") != NULL);
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
    enum { HOUR_MS = 3600000 };
    struct store_job first, second, third;
    struct pen_status st = {0};
    struct pen_buf out = {0};
    store_bed_open(&bed);
    finish_job(&first, 1, 0);
    finish_job(&second, 2, 0);
    finish_job(&third, 3, 0);
    store_must(pen_store_delete(bed.store, first.id, NULL, NULL, &st), &st, "delete");
    expect_code(pen_store_removed_stats(bed.store, first.id, &out, &st), &st, PEN_GONE, "none");
    expect_code(pen_store_delete(bed.store, first.id, NULL, NULL, &st), &st, PEN_GONE, "again");
    store_must(pen_store_delete(bed.store, second.id, NULL, "{}", &st), &st, "delete");
    store_must(pen_store_delete(bed.store, second.id, NULL, NULL, &st), &st, "drop");
    expect_code(pen_store_removed_stats(bed.store, second.id, &out, &st), &st, PEN_GONE, "dropped");
    store_must(pen_store_delete(bed.store, third.id, NULL, "{}", &st), &st, "delete");
    store_must(pen_store_purge(bed.store, -1000, -1000, &st), &st, "purge");
    expect_code(pen_store_removed_stats(bed.store, first.id, &out, &st), &st, PEN_GONE, "whole");
    store_purge_slices(bed.store);
    store_must(pen_store_purge(bed.store, HOUR_MS, HOUR_MS, &st), &st, "purge");
    expect_code(pen_store_removed_stats(bed.store, first.id, &out, &st), &st, PEN_GONE, "young");
    store_must(pen_store_purge(bed.store, -1000, HOUR_MS, &st), &st, "purge");
    expect_code(pen_store_removed_stats(bed.store, first.id, &out, &st), &st, PEN_NOT_FOUND, "old");
    store_must(pen_store_removed_stats(bed.store, third.id, &out, &st), &st, "kept");
    store_must(pen_store_purge(bed.store, -1000, -1000, &st), &st, "purge");
    expect_code(pen_store_removed_stats(bed.store, third.id, &out, &st), &st, PEN_NOT_FOUND, "old");
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

/* Schema 15 has no clients of removed jobs. */
START_TEST(test_removal__statistics_of_an_earlier_schema_are_of_no_client)
{
    struct store_job in;
    struct pen_status st = {0};
    store_bed_open(&bed);
    finish_job(&in, 1, 0);
    store_must(pen_store_delete(bed.store, in.id, NULL, "{}", &st), &st, "delete");
    store_purge_slices(bed.store);
    pen_store_close(bed.store);
    store_downgrade(bed.url, 15);
    store_run_sql(&bed, "UPDATE meta SET value = 0 WHERE name = 'log'", NULL, 0); /* it is gone */
    bed.store = store_bed_handle(&bed);
    expect_code(pen_store_delete(bed.store, in.id, "address:10.0.0.1", NULL, &st), &st,
                PEN_FORBIDDEN, "drop");
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "drop");
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
        finish_job(&in[n], n, 0);
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
    struct stat info;
    ck_assert_int_eq(stat(bed.url, &info), 0);
    return (int64_t)info.st_size;
}

/* Every slice is small: a large job takes many, and its space is returned by others. */
static bool remove_now(void *user, int first_tile, int tile_count, const float *rgb, int64_t pixels)
{
    struct pen_status st;
    (void)first_tile, (void)tile_count, (void)rgb, (void)pixels;
    store_must(pen_store_delete(bed.store, user, NULL, NULL, &st), &st, "delete");
    store_purge_slices(bed.store);
    return true;
}

/* It is not damaged. */
START_TEST(test_removal__a_job_that_goes_while_it_is_read_is_not_found)
{
    struct store_job in;
    struct pen_status st = {0};
    store_bed_open(&bed);
    finish_job(&in, 1, 0);
    expect_code(pen_store_pixels(bed.store, in.id, 0, remove_now, in.id, &st), &st, PEN_NOT_FOUND,
                "pixels");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_removal__a_large_job_goes_in_many_slices_and_its_space_returns)
{
    enum { PICTURES = 12, MIB = 1 << 20 };
    struct store_job in, other;
    struct pen_status st = {0};
    static char picture[3 * MIB];
    store_bed_open(&bed);
    finish_job(&other, 2, 0);
    finish_job(&in, 1, 0);
    for (int i = 0; i < PICTURES; i++) {
        picture[0] = (char)i;
        store_put(bed.store,
                  &(struct store_artefact){in.id, i, "beauty", "pfm", picture, sizeof picture});
    }
    store_must(pen_store_checkpoint(bed.store, &st), &st, "checkpoint");
    ck_assert_int_gt(file_bytes(), PICTURES * 3 * MIB);
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    ck_assert_int_gt(store_purge_slices(bed.store), PICTURES / 2);
    ck_assert_int_lt(file_bytes(), 2 * MIB);
    ck_assert_int_eq(store_job_state(bed.store, other.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

/* Free pages are found in a list, which must not become long: what is freed goes back to the file
 * system while more is removed. */
START_TEST(test_removal__space_returns_while_more_is_removed)
{
    enum { PICTURES = 8, BYTES = 4 << 20, PAGES_MAX = (8 << 20) / 4096 + 2 * BYTES / 4096 };
    struct store_job in;
    struct pen_status st = {0};
    bool more = true;
    store_bed_open(&bed);
    finish_job(&in, 1, 0);
    char *picture = calloc(1, BYTES);
    ck_assert_ptr_nonnull(picture);
    for (int i = 0; i < PICTURES; i++)
        store_put(bed.store, &(struct store_artefact){in.id, i, "beauty", "pfm", picture, BYTES});
    free(picture);
    const int all = store_number(bed.url, "PRAGMA page_count");
    int most = 0;
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    while (more) {
        store_must(pen_store_purge_slice(bed.store, &more, &st), &st, "slice");
        const int free_pages = store_number(bed.url, "PRAGMA freelist_count");
        most = free_pages > most ? free_pages : most;
    }
    ck_assert_int_gt(all, PICTURES * (BYTES / 4096));
    ck_assert_int_gt(most, PAGES_MAX / 2);
    ck_assert_int_le(most, PAGES_MAX);
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
            ok = pen_store_purge_slice(store, &more, &st);
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
        store_bed_open(&bed);
        finish_job(&in, 1, 5 << 20);
        pen_store_close(bed.store);
        die_in_between(in.id, slices);
        bed.store = store_bed_handle(&bed);
        store_audit_clean(bed.store);
        struct pen_job_record job;
        expect_code(pen_store_job(bed.store, in.id, &job, &st), &st, PEN_GONE, "job");
        store_purge_slices(bed.store);
        store_must(pen_store_removed_stats(bed.store, in.id, &out, &st), &st, "statistics");
        store_must(pen_store_checkpoint(bed.store, &st), &st, "checkpoint");
        ck_assert_int_lt(file_bytes(), 1 << 20);
        pen_buf_release(&out);
        store_bed_close(&bed);
    }
}
END_TEST

PEN_SUITE("removed jobs", test_removal__every_call_about_a_removed_job_says_gone,
          test_removal__statistics_are_dropped_on_demand_and_forgotten_with_age,
          test_removal__statistics_of_an_earlier_schema_are_of_no_client,
          test_removal__a_removed_job_is_neither_listed_nor_counted,
          test_removal__a_large_job_goes_in_many_slices_and_its_space_returns,
          test_removal__space_returns_while_more_is_removed,
          test_removal__a_job_that_goes_while_it_is_read_is_not_found,
          test_removal__goes_on_after_a_kill)
