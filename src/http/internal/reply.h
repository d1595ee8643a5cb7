/* SPDX-License-Identifier: MIT */
/* A reply: status, header fields and a body that may be shared.
 *
 * Invariant: once `failed` is set (out of memory) the other members do not matter; the client gets
 * 503 without a body. */
#ifndef PEN_HTTP_INTERNAL_REPLY_H
#define PEN_HTTP_INTERNAL_REPLY_H

#include <jansson.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "base/status.h"

/* Reference-counted bytes: one cached body may be sent to many clients at once. From
 * PEN_BLOB_FILE_BYTES on they are in an unlinked file that is mapped into memory. The system can
 * write such bytes out when it needs the memory.
 * Threads: any. */
struct blob {
    atomic_int refs; /* atomic: acquire-release, so that the thread that frees sees all reads */
    struct pen_buf content;
    bool is_mapped; /* content.data is a mapping of a file */
    /* The sum that includes its bytes while it exists; NULL: none. atomic: relaxed, a sum */
    atomic_size_t *sum;
    /* These bytes compressed, for a file that many clients request; NULL: not kept. */
    struct blob *gzip;
};

enum { PEN_BLOB_FILE_BYTES = 64 << 10 };

/* Makes a blob of the contents of a buffer. The buffer is empty afterwards, even after a failure.
 * Fails: NULL when out of memory, or if the buffer has failed. */
struct blob *pen_http_blob_take(struct pen_buf *content);

/* Counts the blob's bytes in *sum while the blob exists. */
void pen_http_blob_count(struct blob *blob, atomic_size_t *sum);
struct blob *pen_http_blob_ref(struct blob *blob);
void pen_http_blob_unref(struct blob *blob); /* NULL is allowed */

/* Compresses a blob with gzip, or uses the kept result. Returns a reference.
 * Fails: NULL when out of memory. */
struct blob *pen_http_blob_gzip(struct blob *blob);

/* Makes a blob of JSON text with a line end.
 * Fails: NULL when out of memory. */
struct blob *pen_http_blob_json(const json_t *json);

/* Writes a strong entity tag, quoted: a hash of the bytes. */
enum { ETAG_BYTES = 40 };
void pen_http_etag(const struct pen_buf *content, char etag[ETAG_BYTES]);

enum { REPLY_FIELDS = 10 };

struct reply {
    int status;          /* 0: not set yet */
    struct blob *body;   /* NULL: none */
    size_t first, bytes; /* the part of the body that is sent */
    struct reply_field {
        const char *name;
        char *value;
    } field[REPLY_FIELDS];
    int field_count;
    bool streaming; /* an event stream, or HEAD of one: `body` is NULL, the length unknown */
    bool failed;
};

/* Frees what the reply owns; it is then empty. */
void pen_http_reply_release(struct reply *reply);

/* Adds a header field. When out of memory, or after REPLY_FIELDS fields, `failed` is set. */
void pen_http_reply_field(struct reply *reply, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Removes the field at a place. */
void pen_http_reply_remove(struct reply *reply, int place);

/* Sets status and body, and takes the blob. A NULL blob stands for a failed allocation. */
void pen_http_reply_body(struct reply *reply, int status, struct blob *blob, const char *type);

/* Answers with a problem document, as pen_http_reply_body. Adds Retry-After if trying again helps.
 */
void pen_http_reply_problem(struct reply *reply, int status, struct blob *text);

#endif
