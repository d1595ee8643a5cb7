/* SPDX-License-Identifier: MIT */
/* Reports of jobs. The JSON is stored with the job's commit. The other formats are made from it at
 * each request. Pages of kinds "accuracy" and "effects" have pictures, so they are stored too. An
 * explanation has only JSON. */
#include <string.h>

#include "jobs/internal/ids.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/kind.h"
#include "report/report.h"

/* Fails unless the job is of a kind that has a report in this format, and has succeeded. */
static bool check_job(const struct pen_job_record *job, const char *form, enum pen_job_kind *kind,
                      struct pen_status *st)
{
    if (!pen_job_kind_of_name(job->kind, kind) || !pen_job_kind_has_report(*kind))
        return pen_fail(st, PEN_NOT_FOUND, "job %s is of kind \"%s\", which has no report", job->id,
                        job->kind);
    if (job->state != PEN_JOB_SUCCEEDED)
        return pen_fail(st, PEN_CONFLICT, "job %s is %s; only a job that succeeded has its report",
                        job->id, pen_job_state_name(job->state));
    return *kind != PEN_KIND_EXPLAIN || strcmp(form, PEN_REPORT_FORMAT) == 0 ||
           pen_fail(st, PEN_ACCEPT, "job %s is of kind \"%s\", whose report is application/json",
                    job->id, job->kind);
}

/* Replaces the report's JSON in *bytes by another format. */
static bool convert(const char *id, const char *form, struct pen_buf *bytes, struct pen_status *st)
{
    json_error_t error;
    json_t *report = json_loadb((const char *)bytes->data, bytes->bytes, 0, &error);
    pen_buf_release(bytes);
    bool ok = report ? pen_report_write(report, form, NULL, bytes, st)
                     : pen_fail(st, PEN_STORAGE, "the stored report of job %s is damaged: %s", id,
                                error.text);
    json_decref(report);
    return ok;
}

bool pen_jobs_report(struct pen_jobs *jobs, const char *id, const char *form, struct pen_image *out,
                     struct pen_status *st)
{
    struct pen_job_record job;
    *out = (struct pen_image){0};
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    enum pen_job_kind kind;
    bool ok = check_job(&job, form, &kind, st);
    pen_job_record_release(&job);
    const bool is_page = strcmp(form, "html") == 0 && ok && kind != PEN_KIND_BENCHMARK;
    const char *stored = is_page ? form : PEN_REPORT_FORMAT;
    ok = ok && pen_store_artefact(jobs->store, id, 0, PEN_REPORT_LAYER, stored, &out->bytes, st);
    if (ok && strcmp(form, stored) != 0)
        ok = convert(id, form, &out->bytes, st);
    if (!ok) {
        pen_buf_release(&out->bytes);
        return false;
    }
    strcpy(out->type, pen_report_media_type(form));
    pen_etag_make(out->bytes.data, out->bytes.bytes, out->etag);
    return true;
}
