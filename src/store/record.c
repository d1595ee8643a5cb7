/* SPDX-License-Identifier: MIT */
/* What a job's record owns. */
#include <stdlib.h>
#include <string.h>

#include "store/store.h"

void pen_job_record_release(struct pen_job_record *job)
{
    free(job->kind);
    free(job->request);
    free(job->error);
    job->kind = job->request = job->error = NULL;
}

size_t pen_job_record_text_bytes(const struct pen_job_record *job)
{
    return (job->request ? strlen(job->request) : 0) + (job->error ? strlen(job->error) : 0);
}

void pen_job_records_free(struct pen_job_record *jobs, int count)
{
    for (int i = 0; i < count; i++)
        pen_job_record_release(&jobs[i]);
    free(jobs);
}
