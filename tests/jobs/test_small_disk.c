/* SPDX-License-Identifier: MIT */
/* A worker on a disk with too little space for one job's result: it goes on with others, and stores
 * that result when there is space. Takes root's rights; without them nothing is tested. */
#include "support/jobs.h"
#include "support/small_disk.h"
#include "support/suite.h"

static struct jobs_bed bed;

static bool open_small_disk(int mib)
{
    struct pen_status st;
    store_bed_make(&bed.bed);
    if (!small_disk_mount(bed.bed.folder, mib))
        return false;
    jobs_bed_open(&bed);
    store_must(pen_store_reserve(bed.bed.store, &st), &st, "reserve");
    return true;
}

static void close_small_disk(void)
{
    jobs_worker_stop(&bed);
    pen_jobs_close(bed.jobs);
    store_audit_clean(bed.bed.store);
    pen_store_close(bed.bed.store);
    small_disk_unmount(bed.bed.folder);
}

/* `large`: a job whose batch is more than can be stored. Another one is submitted while the worker
 * is at it. */
static void wait_for_space(const char *large)
{
    enum { DISK_MIB = 64, FREE_BYTES = 3 << 19 };
    static const char small[] =
        "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 16, \"height\": 12}}";
    char large_id[PEN_ID_BYTES], small_id[PEN_ID_BYTES];
    if (!open_small_disk(DISK_MIB))
        return;
    jobs_submit(&bed, large, large_id);
    jobs_submit(&bed, small, small_id);
    small_disk_fill(bed.bed.folder, FREE_BYTES);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, small_id), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(store_job_state(bed.bed.store, large_id), PEN_JOB_RUNNING);
    small_disk_free(bed.bed.folder);
    ck_assert_int_eq(jobs_wait(&bed, large_id), PEN_JOB_SUCCEEDED);
    struct pen_job_record job = store_job_get(bed.bed.store, large_id);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    close_small_disk();
}

START_TEST(test_small_disk__large_picture_waits_and_others_go_on)
{
    wait_for_space("{\"scene\": \"builtin:patterns\", \"priority\": 5, \"render\":"
                   " {\"width\": 900, \"height\": 700, \"samples_per_pixel\": 1}}");
}
END_TEST

/* Layers are stored before the commit. */
START_TEST(test_small_disk__large_layer_waits_and_others_go_on)
{
    wait_for_space("{\"scene\": \"builtin:spheres\", \"priority\": 5, \"layers\":"
                   " [\"beauty\", \"depth\"], \"render\":"
                   " {\"width\": 400, \"height\": 400, \"samples_per_pixel\": 1}}");
}
END_TEST

PEN_SUITE("worker on a small disk", test_small_disk__large_picture_waits_and_others_go_on,
          test_small_disk__large_layer_waits_and_others_go_on)
