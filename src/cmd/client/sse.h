/* SPDX-License-Identifier: MIT */
/* Reads server-sent events out of bytes as they come. What is not understood is passed over, as
 * the standard wants it. */
#ifndef PEN_CMD_CLIENT_SSE_H
#define PEN_CMD_CLIENT_SSE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"

/* An event. */
typedef void pen_sse_fn(void *user, const char *type, const char *data);

/* All zeros but for `each` and `user` at first; last_id may be set to that of an earlier stream. */
struct pen_sse {
    pen_sse_fn *each;
    void *user;
    char last_id[32]; /* of the last event given out; "": none */

    char type[32], id[32]; /* of the event being read */
    struct pen_buf line, data;
    int events; /* given out so far */
};

void pen_sse_release(struct pen_sse *sse);

/* Takes the next bytes. Returns false when out of memory. */
bool pen_sse_feed(struct pen_sse *sse, const char *bytes, size_t count);

#endif
