/* SPDX-License-Identifier: MIT */
/* A reader of server-sent events (WHATWG HTML, section 9.2) that takes bytes as they arrive. It
 * ignores unknown fields, as the standard requires. */
#ifndef PEN_CMD_CLIENT_SSE_H
#define PEN_CMD_CLIENT_SSE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"

/* Called for each whole event. */
typedef void pen_sse_fn(void *user, const char *type, const char *data);

/* Set `each` and `user`, and last_id to resume an earlier stream; all other members begin as
 * zero. */
struct pen_sse {
    pen_sse_fn *each;
    void *user;
    char last_id[32]; /* of the last event passed to `each`; "": none */

    char type[32], id[32]; /* of the event being read */
    struct pen_buf line, data;
    int events; /* passed to `each` so far */
};

void pen_sse_release(struct pen_sse *sse);

/* Reads the next bytes. Returns false when out of memory. */
bool pen_sse_feed(struct pen_sse *sse, const char *bytes, size_t count);

#endif
