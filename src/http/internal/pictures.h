/* SPDX-License-Identifier: MIT */
/* The pictures in memory: those that are being sent, one copy for all clients that read the same
 * one, and some that were sent lately. All together have a budget. When it is used up, a client is
 * told to come back for a large picture; small ones go on, from a reserve.
 *
 * Only the pictures of jobs that have succeeded are kept: they never change. The caller looks
 * whether the job is still there.
 *
 * Threads: any. */
#ifndef PEN_HTTP_INTERNAL_PICTURES_H
#define PEN_HTTP_INTERNAL_PICTURES_H

#include <stdbool.h>
#include <stddef.h>

#include "http/internal/reply.h"
#include "jobs/jobs.h"

struct pictures;

/* A picture with its media type and entity tag. */
struct picture {
    struct blob *blob;
    char type[40];
    char etag[72];
};

/* Which picture: as in struct pen_image_query; NULL is the default. */
struct picture_key {
    const char *job, *view, *layer, *format;
};

/* Fails: NULL when out of memory. */
struct pictures *pen_http_pictures_new(void);
void pen_http_pictures_free(struct pictures *pictures); /* NULL is allowed */

/* Gets a picture that is in memory. Owns: the caller has a reference to out->blob. */
bool pen_http_pictures_find(struct pictures *pictures, const struct picture_key *key,
                            struct picture *out);

/* Takes a picture that was read, and counts it. With a key it may be found from now on; if another
 * thread has read the same one meanwhile, *out is that. Owns: as pen_http_pictures_find. Fails:
 * PEN_UNAVAILABLE (the budget is used up), PEN_NO_MEMORY. */
bool pen_http_pictures_take(struct pictures *pictures, const struct picture_key *key,
                            struct pen_image *image, struct picture *out, struct pen_status *st);

#endif
