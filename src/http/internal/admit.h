/* SPDX-License-Identifier: MIT */
/* The first two phases of a request (see request.h): checking its head, and taking its body. */
#ifndef PEN_HTTP_INTERNAL_ADMIT_H
#define PEN_HTTP_INTERNAL_ADMIT_H

#include <stdbool.h>
#include <stddef.h>

struct request;

/* Checks request line and header fields. Afterwards the request is in PHASE_BODY; or, if it is
 * refused, in PHASE_DISCARD when its body is to be read before the answer, else in PHASE_ANSWERED.
 */
void pen_http_request_admit(struct request *request);

/* Takes a part of the body. Returns false if the body is longer than allowed: close the
 * connection. */
bool pen_http_request_receive(struct request *request, const char *data, size_t bytes);

#endif
