/* SPDX-License-Identifier: MIT */
/* A worker on a disk with too little space for a job's result. It keeps the result, and stores it
 * when there is space. Needs root's rights; without them nothing is tested. */
#include <unistd.h>

#include "support/jobs.h"
#include "support/small_disk.h"
#include "support/store_rows.h"
#include "support/suite.h"

static struct jobs_bed bed;

static bool open_small_disk(int mib)
{
    store_bed_make(&bed.bed);
    if (!small_disk_mount(bed.bed.folder, mib))
        return false;
    jobs_bed_open(&bed);
    return true;
}

static void close_small_disk(void)
{
    jobs_worker_stop(&bed);
    pen_jobs_close(bed.jobs);
    ck_assert_int_eq(store_contradictions(bed.bed.url), 0);
    pen_store_close(bed.bed.store);
    small_disk_unmount(bed.bed.folder);
}

/* `body`: a job whose batch is more than can be stored. */
static void wait_for_space(const char *body)
{
    enum { DISK_MIB = 128, FREE_BYTES = 3 << 19, FULL_US = 3000000 };
    char id[PEN_ID_BYTES];
    if (!open_small_disk(DISK_MIB))
        return;
    jobs_submit(&bed, body, id);
    small_disk_fill(bed.bed.folder, FREE_BYTES);
    bed.batch_ms = 600000; /* however slow the build, it is one batch and not several that fit */
    jobs_worker_start(&bed);
    while (store_job_state(bed.bed.store, id) == PEN_JOB_QUEUED)
        usleep(10000);
    usleep(FULL_US);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_RUNNING);
    small_disk_free(bed.bed.folder);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    close_small_disk();
}

START_TEST(test_small_disk__large_picture_waits_for_space)
{
    wait_for_space("{\"scene\": \"builtin:patterns\", \"render\":"
                   " {\"width\": 900, \"height\": 700, \"samples_per_pixel\": 1}}");
}
END_TEST

/* Layers are stored before the commit. */
START_TEST(test_small_disk__large_layer_waits_for_space)
{
    wait_for_space("{\"scene\": \"builtin:spheres\", \"layers\":"
                   " [\"beauty\", \"depth\"], \"render\":"
                   " {\"width\": 400, \"height\": 400, \"samples_per_pixel\": 1}}");
}
END_TEST

PEN_SUITE("worker on a small disk", test_small_disk__large_picture_waits_for_space,
          test_small_disk__large_layer_waits_for_space)
