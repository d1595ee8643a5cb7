/* SPDX-License-Identifier: MIT */
/* Bodies compressed with gzip (RFC 1952). */
#ifndef PEN_HTTP_INTERNAL_ENCODING_H
#define PEN_HTTP_INTERNAL_ENCODING_H

#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"

struct request;

/* Decompresses. Stops as soon as the result is longer than `limit`, which bounds the cost. Fails:
 * PEN_SYNTAX (not gzip, or cut short), PEN_TOO_LARGE, PEN_NO_MEMORY; *out is empty then. */
bool pen_http_gunzip(const void *data, size_t bytes, size_t limit, struct pen_buf *out,
                     struct pen_status *st);

/* Compresses. Returns false when out of memory; *out is empty then. */
bool pen_http_gzip(const void *data, size_t bytes, struct pen_buf *out);

/* Decompresses the body of a request, if it is compressed. Returns false after a failure; the
 * request is then answered. */
bool pen_http_request_decode(struct request *request);

/* Compresses the body of an answer if the client accepts gzip, the body is text, and it is not
 * small. A compressed body has another entity tag. */
void pen_http_request_encode(struct request *request);

#endif
