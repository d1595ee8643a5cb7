/* SPDX-License-Identifier: MIT */
/* Representations that never change while the process lives: the API definition, the scene schema
 * and the built-in scenes. Made once at start. */
#ifndef PEN_HTTP_INTERNAL_STATICS_H
#define PEN_HTTP_INTERNAL_STATICS_H

#include "base/status.h"
#include "http/internal/reply.h"

struct static_file {
    char name[64]; /* "openapi.yaml"; "scenes" is the list, "scenes/room" a built-in scene */
    const char *type;
    char etag[ETAG_BYTES];
    struct blob *blob;
};

struct statics;

/* Fails: PEN_NO_MEMORY. */
struct statics *pen_http_statics_new(struct pen_status *st);
void pen_http_statics_free(struct statics *statics); /* NULL is allowed */

/* The file of that name, or NULL. */
const struct static_file *pen_http_statics_find(const struct statics *statics, const char *name);

#endif
