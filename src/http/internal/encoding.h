/* SPDX-License-Identifier: MIT */
/* Bodies compressed with gzip (RFC 1952). */
#ifndef PEN_HTTP_INTERNAL_ENCODING_H
#define PEN_HTTP_INTERNAL_ENCODING_H

#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"

struct request;

/* Decompresses gzip. Stops when the result exceeds `limit`, which bounds the cost. After a failure
 * *out is empty.
 * Fails: PEN_SYNTAX (not gzip, or incomplete), PEN_TOO_LARGE, PEN_NO_MEMORY. */
bool pen_http_gunzip(const void *data, size_t bytes, size_t limit, struct pen_buf *out,
                     struct pen_status *st);

/* Compresses to gzip. Returns false when out of memory; *out is then empty. */
bool pen_http_gzip(const void *data, size_t bytes, struct pen_buf *out);

/* Decompresses the body of a request, if it is compressed. Returns false after a failure; the
 * request is then answered. */
bool pen_http_request_decode(struct request *request);

/* Compresses the body of an answer if the client accepts gzip, the body is text, and it is not
 * small. A compressed body has another entity tag. */
void pen_http_request_encode(struct request *request);

#endif
