/* SPDX-License-Identifier: MIT */
/* The files that are embedded in the program: the API definition, the scene schema, the built-in
 * scenes and the page. Their blobs and entity tags are made once, at start.
 *
 * Threads: any, after the start. */
#ifndef PEN_HTTP_INTERNAL_STATIC_FILES_H
#define PEN_HTTP_INTERNAL_STATIC_FILES_H

#include "base/status.h"
#include "http/internal/reply.h"

struct static_file {
    char name[64]; /* "openapi.yaml"; "scenes" is the list, "scenes/room" a built-in scene,
                    * "page/app.js" a file of the page */
    const char *type;
    const char *policy; /* Content-Security-Policy; NULL: not HTML */
    char etag[ETAG_BYTES];
    struct blob *blob;
};

struct static_files;

/* Fails: PEN_NO_MEMORY. */
struct static_files *pen_http_static_files_new(struct pen_status *st);
void pen_http_static_files_free(struct static_files *files); /* NULL is allowed */

/* Finds a file by its name. NULL: there is none. */
const struct static_file *pen_http_static_files_find(const struct static_files *files,
                                                     const char *name);

#endif
