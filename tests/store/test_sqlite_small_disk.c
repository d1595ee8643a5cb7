/* SPDX-License-Identifier: MIT */
/* A disk of 128 MiB that fills up. New jobs are refused below 64 MiB; running jobs continue. On a
 * full disk a commit fails and may be repeated. Cancels and deletes use the space of the reserve,
 * which is made again. Needs root's rights; without them nothing is tested. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"
#include "support/small_disk.h"
#include "support/store.h"
#include "support/store_rows.h"
#include "support/suite.h"

enum { MIB = 1 << 20, DISK_MIB = 128, RESERVE = 16 * MIB, INTAKE = 64 * MIB };

static struct store_bed bed;
static struct store_job job[8];
static int64_t now_ms;

/* A store with a reserve, and so many jobs of one batch. */
static bool begin(int jobs)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    store_bed_make(&bed);
    if (!small_disk_mount(bed.folder, DISK_MIB))
        return false;
    store_bed_open(&bed);
    now_ms = 1000000000;
    store_bed_set_clock(&bed, &now_ms);
    store_purge_slices(bed.store);
    for (int i = 0; i < jobs; i++) {
        store_job_init(&job[i], i, 1, 1);
        store_job_submit(bed.store, &job[i]);
    }
    return true;
}

static void end(void)
{
    struct pen_status st;
    bool finished;
    now_ms += 61000; /* what was being written goes */
    store_purge_slices(bed.store);
    store_must(pen_store_check(bed.store, 0, &finished, &st), &st, "check");
    ck_assert_int_eq(store_contradictions(bed.url), 0);
    pen_store_close(bed.store);
    small_disk_unmount(bed.folder);
}

static int64_t reserve_bytes(void)
{
    char path[128];
    struct stat info;
    snprintf(path, sizeof path, "%s-reserve", bed.url);
    return stat(path, &info) == 0 ? (int64_t)info.st_blocks * 512 : 0;
}

static enum pen_code submit(int n)
{
    struct store_job in;
    struct pen_status st = {0};
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    store_job_init(&in, n, 1, 1);
    const bool ok = pen_store_submit(bed.store, &in.job, &result, &answer, &st);
    ck_assert_msg(ok || pen_store_failure(bed.store, &st) == PEN_FAILURE_RETRY, "%s", st.msg);
    pen_buf_release(&answer);
    return ok ? PEN_OK : st.code;
}

static enum pen_code intake(void)
{
    struct pen_status st = {0};
    return pen_store_intake(bed.store, &st) ? PEN_OK : st.code;
}

START_TEST(test_sqlite_small_disk__takes_no_job_below_64_mib_and_ends_those_that_run)
{
    if (!begin(1))
        return;
    ck_assert_int_eq(reserve_bytes(), RESERVE);
    const struct pen_claim claim = store_claim(bed.store, "w");
    small_disk_fill(bed.folder, INTAKE + MIB);
    ck_assert_int_eq(intake(), PEN_OK);
    ck_assert_int_eq(submit(10), PEN_OK);
    small_disk_fill(bed.folder, INTAKE - MIB);
    ck_assert_int_eq(intake(), PEN_STORAGE_FULL);
    ck_assert_int_eq(submit(11), PEN_STORAGE_FULL);
    ck_assert_int_eq(submit(10), PEN_OK); /* it was submitted before */
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    small_disk_free(bed.folder);
    ck_assert_int_eq(submit(11), PEN_OK);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 2);
    end();
}
END_TEST

/* Fills the disk, and what the log still has of its own. */
static enum pen_code commit_until_full(struct pen_claim *claim)
{
    static char picture[8 * MIB];
    static const float rgb[STORE_JOB_TILE * STORE_JOB_TILE * 3];
    const struct pen_result result = {.rgb = rgb,
                                      .pixels = claim->pixels,
                                      .stats = "{}",
                                      .layer = "beauty",
                                      .format = "png",
                                      .artefact = picture,
                                      .artefact_bytes = sizeof picture};
    struct pen_status st = {0};
    const bool ok = pen_store_commit(bed.store, claim, &result, NULL, &st);
    ck_assert_msg(ok || pen_store_failure(bed.store, &st) == PEN_FAILURE_RETRY, "%s", st.msg);
    ck_assert(!pen_store_is_broken(bed.store, NULL));
    return ok ? PEN_OK : st.code;
}

START_TEST(test_sqlite_small_disk__a_commit_without_space_may_be_repeated)
{
    if (!begin(2))
        return;
    struct pen_claim large = store_claim(bed.store, "w"), small = store_claim(bed.store, "w");
    small_disk_fill(bed.folder, 2 * MIB);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(commit_until_full(&large), PEN_STORAGE_FULL);
    ck_assert_int_eq(store_job_state(bed.store, job[0].id), PEN_JOB_RUNNING);
    store_purge_slices(bed.store); /* what it has written goes again */
    small_disk_free(bed.folder);
    ck_assert_int_eq(store_commit(bed.store, &small), PEN_OK);
    ck_assert_int_eq(commit_until_full(&large), PEN_OK);
    ck_assert_int_eq(store_job_state(bed.store, job[0].id), PEN_JOB_SUCCEEDED);
    end();
}
END_TEST

START_TEST(test_sqlite_small_disk__a_full_one_lets_jobs_be_cancelled_and_removed)
{
    enum { JOBS = 4 };
    struct pen_status st;
    if (!begin(JOBS))
        return;
    struct pen_claim claim = store_claim(bed.store, "w");
    small_disk_fill(bed.folder, 20 * MIB);
    while (commit_until_full(&claim) == PEN_OK)
        claim = store_claim(bed.store, "w");
    small_disk_fill(bed.folder, 0);
    ck_assert_int_eq(reserve_bytes(), RESERVE);
    for (int i = 0; i < JOBS; i++) {
        store_must(pen_store_cancel(bed.store, job[i].id, NULL, &st), &st, "cancel");
        store_must(pen_store_delete(bed.store, job[i].id, NULL, "{}", &st), &st, "delete");
    }
    ck_assert_int_eq(reserve_bytes(), 0);
    store_purge_slices(bed.store);
    ck_assert_int_eq(reserve_bytes(), 0); /* there is too little space for it */
    small_disk_free(bed.folder);
    store_purge_slices(bed.store);
    ck_assert_int_eq(reserve_bytes(), RESERVE);
    ck_assert_int_eq(submit(10), PEN_OK);
    end();
}
END_TEST

START_TEST(test_sqlite_small_disk__jobs_are_removed_after_a_start_on_a_full_one)
{
    struct pen_status st;
    if (!begin(1))
        return;
    pen_store_close(bed.store);
    small_disk_fill(bed.folder, 0);
    bed.store = store_bed_handle(&bed);
    store_bed_set_clock(&bed, &now_ms);
    store_must(pen_store_cancel(bed.store, job[0].id, NULL, &st), &st, "cancel");
    store_must(pen_store_delete(bed.store, job[0].id, NULL, NULL, &st), &st, "delete");
    small_disk_free(bed.folder);
    end();
}
END_TEST

PEN_SUITE("store on a small disk",
          test_sqlite_small_disk__takes_no_job_below_64_mib_and_ends_those_that_run,
          test_sqlite_small_disk__a_commit_without_space_may_be_repeated,
          test_sqlite_small_disk__a_full_one_lets_jobs_be_cancelled_and_removed,
          test_sqlite_small_disk__jobs_are_removed_after_a_start_on_a_full_one)
