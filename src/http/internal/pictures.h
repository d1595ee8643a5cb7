/* SPDX-License-Identifier: MIT */
/* The large answers. Those that are being sent share a memory budget. An answer beyond it is
 * refused, unless it is the only one. Pictures are kept within the same budget. All clients of a
 * picture share one copy. A picture without a reader is dropped if another answer needs its memory.
 *
 * Only results of jobs that have succeeded are kept, because they never change. The caller checks
 * that the job still exists.
 *
 * Threads: any. */
#ifndef PEN_HTTP_INTERNAL_PICTURES_H
#define PEN_HTTP_INTERNAL_PICTURES_H

#include <stdbool.h>

#include "http/internal/reply.h"
#include "jobs/jobs.h"

struct pictures;

/* A picture with its media type and entity tag. */
struct picture {
    struct blob *blob;
    char type[40];
    char etag[72];
};

/* Fails: NULL when out of memory. */
struct pictures *pen_http_pictures_new(size_t budget_bytes);
void pen_http_pictures_free(struct pictures *pictures); /* NULL is allowed */

/* Gets a kept picture of a job.
 * Owns: the caller has a reference to out->blob. */
bool pen_http_pictures_find(struct pictures *pictures, const char *job,
                            const struct pen_image_query *query, struct picture *out);

/* Keeps a picture: takes the contents of an image and counts it. If another thread has kept the
 * same picture, *out is that one.
 * Owns: as pen_http_pictures_find.
 * Fails: PEN_UNAVAILABLE (the budget is used up), PEN_NO_MEMORY. */
bool pen_http_pictures_take(struct pictures *pictures, const char *job,
                            const struct pen_image_query *query, struct pen_image *image,
                            struct picture *out, struct pen_status *st);

/* Counts an answer against the budget, if it is large and not counted yet. NULL is allowed.
 * Fails: PEN_UNAVAILABLE (the budget is used up). */
bool pen_http_pictures_count(struct pictures *pictures, struct blob *blob, struct pen_status *st);

#endif
