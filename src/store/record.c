/* SPDX-License-Identifier: MIT */
/* Release of what a job's record owns. */
#include <stdlib.h>

#include "store/store.h"

void pen_job_record_release(struct pen_job_record *job)
{
    free(job->kind);
    free(job->request);
    free(job->error);
    job->kind = job->request = job->error = NULL;
}

void pen_job_records_free(struct pen_job_record *jobs, int count)
{
    for (int i = 0; i < count; i++)
        pen_job_record_release(&jobs[i]);
    free(jobs);
}
