/* SPDX-License-Identifier: MIT */
/* The first two phases of a request (see request.h): checking its head, and receiving its body.
 *
 * Threads: that of the connection. */
#ifndef PEN_HTTP_INTERNAL_ADMIT_H
#define PEN_HTTP_INTERNAL_ADMIT_H

#include <stdbool.h>
#include <stddef.h>

struct request;

/* Checks request line, header fields and token. Afterwards the request is in PHASE_BODY; or, if it
 * is answered, in PHASE_ANSWERED, and its body must not be read.
 * `head_bytes`: the length of the head. */
void pen_http_request_admit(struct request *request, size_t head_bytes);

/* Receives a part of the body. Returns false if the body is longer than allowed, or memory is
 * missing; the request is answered then, and nothing more of the body may be read. */
bool pen_http_request_receive(struct request *request, const char *data, size_t bytes);

#endif
