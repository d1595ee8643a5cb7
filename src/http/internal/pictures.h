/* SPDX-License-Identifier: MIT */
/* The large answers, pictures and scenes: those that are being sent, one copy for all clients that
 * read the same one, and some that were sent lately.
 *
 * All answers, and what making pictures takes, have one budget. Memory is reserved before a picture
 * is made. If there is none, the client is told to come back. A picture that takes more than the
 * whole budget has a place beside it, for one at a time.
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

/* Memory that is set aside for a picture; all zero: none. */
struct picture_room {
    size_t bytes;
    bool alone; /* in the place beside the budget */
};

/* Sets memory aside, as much as room->bytes says; if need be, drops pictures that nobody reads.
 * Owns: give the room to pen_http_pictures_take or pen_http_pictures_give_up. Fails:
 * PEN_UNAVAILABLE (the budget, or the place beside it, is used up); *room is all zero then. */
bool pen_http_pictures_reserve(struct pictures *pictures, struct picture_room *room,
                               struct pen_status *st);
void pen_http_pictures_give_up(struct pictures *pictures, struct picture_room *room);

/* Takes a picture that was made in `room` (NULL: none was reserved), gives the room back, and
 * counts the picture. With a key it may be found from now on; if another thread has taken the same
 * one meanwhile, *out is that. The caller's image and room are empty afterwards. Owns: as
 * pen_http_pictures_find. Fails: PEN_UNAVAILABLE (the budget is used up), PEN_NO_MEMORY. */
bool pen_http_pictures_take(struct pictures *pictures, const struct picture_key *key,
                            struct pen_image *image, struct picture_room *room, struct picture *out,
                            struct pen_status *st);

/* Counts an answer that is no picture, if it is large. Fails: PEN_UNAVAILABLE (the budget is used
 * up). */
bool pen_http_pictures_count(struct pictures *pictures, struct blob *blob, struct pen_status *st);

#endif
