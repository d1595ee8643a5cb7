/* SPDX-License-Identifier: MIT */
/* Inside room jobs: the handle, and what several of its files use. */
#ifndef PEN_JOBS_INTERNAL_JOBS_H
#define PEN_JOBS_INTERNAL_JOBS_H

#include "base/log.h"
#include "film/encode.h"
#include "film/film.h"
#include "io/json_build.h"
#include "jobs/jobs.h"
#include "scene/settings.h"

struct pen_jobs {
    struct pen_store *store;
    struct pen_limits limits;
};

/* How JSON is written wherever it is stored: every double reads back as itself. */
#define PEN_JSON_STORED (JSON_COMPACT | JSON_REAL_PRECISION(17))

/* ids.c: a new UUIDv7 (RFC 9562) for a time; SHA-256. pen_ids_init must have been called. */
bool pen_ids_init(struct pen_status *st);
void pen_id_make(int64_t wall_ms, char out[PEN_ID_BYTES]);
void pen_sha256(const void *data, size_t bytes, unsigned char out[32]);

/* What a line of the log about a claim names. */
static inline struct pen_log_about pen_claim_about(const struct pen_claim *claim)
{
    return (struct pen_log_about){
        .job = claim->job_id, .batch = claim->batch, .attempt = claim->attempt};
}

/* A strong entity tag, quoted: a hash of the bytes. */
void pen_etag_make(const void *data, size_t bytes, char out[72]);

/* problems.c: {pointer, detail}, or {line, column, detail} where the text has lines. */
json_t *pen_problem_place(const struct pen_status *st);

/* job_json.c: the job object of http-api.md from a stored job. Fails: PEN_STORAGE (the stored
 * request is no JSON), PEN_NO_MEMORY. */
json_t *pen_job_json(const struct pen_job_record *job, struct pen_status *st);

/* Where the report of a job is kept, among its artefacts. */
#define PEN_REPORT_LAYER "report"
#define PEN_REPORT_FORMAT "json"

/* canvas.c: pixels between the order of tiles, in which they are committed, and that of rows.
 * Copies the tiles of a batch out of an image, or into one. */
void pen_tiles_gather(const struct pen_settings *settings, int first, int count, const float *image,
                      float *tiles);
void pen_tiles_scatter(const struct pen_settings *settings, int first, int count,
                       const float *tiles, float *image);

/* Pixels of tiles first … first + count - 1. */
int64_t pen_tiles_pixels(const struct pen_settings *settings, int first, int count);

/* Fills an image with what is committed of a view; sets mask (may be NULL) to 1 where it is.
 * Returns the pixels filled in *filled. */
bool pen_canvas_load(struct pen_store *store, const char *id, int view,
                     const struct pen_settings *settings, struct pen_film *film,
                     unsigned char *mask, int64_t *filled, struct pen_status *st);

/* The transfer function that settings ask for. */
enum pen_transfer pen_canvas_transfer(const struct pen_settings *settings);

/* Encodes a film in one of the formats png, png16, pfm. */
bool pen_canvas_encode(const struct pen_film *film, const struct pen_settings *settings,
                       const char *format, struct pen_buf *out, struct pen_status *st);

/* stats_merge.c: one statistics object out of those of all committed batches. */
json_t *pen_stats_of_job(struct pen_store *store, const struct pen_job_record *job,
                         struct pen_status *st);

/* The parts of a stored request (job_json.c made it) that rendering and results need. */
struct pen_job_plan {
    json_t *request; /* owns the names below; json_decref() it */
    struct pen_settings settings;
    int view_count;
    bool benchmark;
};
bool pen_job_plan_read(const char *request, struct pen_job_plan *plan, struct pen_status *st);
const char *pen_job_plan_view(const struct pen_job_plan *plan, int view);
int pen_job_plan_find_view(const struct pen_job_plan *plan, const char *name);

#endif
