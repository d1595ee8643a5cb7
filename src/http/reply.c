/* SPDX-License-Identifier: MIT */
/* Building replies, and applying If-None-Match and Range to them. */
#include "http/internal/reply.h"

#include <fcntl.h>
#include <sodium.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "http/internal/encoding.h"
#include "http/message.h"

/* A file that has no name, in $TMPDIR. -1: there is none. */
static int open_unlinked(void)
{
    const char *folder = getenv("TMPDIR");
    return open(folder && *folder ? folder : "/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
}

/* Moves large contents into a mapped file. Where that fails they stay as they are. */
static void map_content(struct blob *blob)
{
    struct pen_buf *content = &blob->content;
    const int fd = content->bytes >= PEN_BLOB_FILE_BYTES ? open_unlinked() : -1;
    if (fd < 0)
        return;
    size_t written = 0;
    ssize_t n = 1;
    while (written < content->bytes && n > 0) {
        n = write(fd, content->data + written, content->bytes - written);
        written += n > 0 ? (size_t)n : 0;
    }
    void *mapped =
        written == content->bytes ? mmap(NULL, written, PROT_READ, MAP_SHARED, fd, 0) : MAP_FAILED;
    close(fd);
    if (mapped == MAP_FAILED)
        return;
    free(content->data);
    content->data = mapped;
    blob->is_mapped = true;
}

struct blob *pen_http_blob_take(struct pen_buf *content)
{
    struct blob *blob = content->failed ? NULL : malloc(sizeof *blob);
    if (!blob) {
        pen_buf_release(content);
        return NULL;
    }
    *blob = (struct blob){.content = *content};
    atomic_init(&blob->refs, 1);
    pen_buf_init(content);
    map_content(blob);
    return blob;
}

void pen_http_blob_count(struct blob *blob, atomic_size_t *sum)
{
    if (!blob || !sum)
        return;
    blob->sum = sum;
    atomic_fetch_add_explicit(sum, blob->content.bytes, memory_order_relaxed);
}

struct blob *pen_http_blob_ref(struct blob *blob)
{
    atomic_fetch_add_explicit(&blob->refs, 1, memory_order_relaxed);
    return blob;
}

void pen_http_blob_unref(struct blob *blob)
{
    if (!blob || atomic_fetch_sub_explicit(&blob->refs, 1, memory_order_acq_rel) != 1)
        return;
    if (blob->sum)
        atomic_fetch_sub_explicit(blob->sum, blob->content.bytes, memory_order_relaxed);
    pen_http_blob_unref(atomic_load_explicit(&blob->gzip, memory_order_acquire));
    if (blob->is_mapped)
        munmap(blob->content.data, blob->content.bytes);
    else
        pen_buf_release(&blob->content);
    free(blob);
}

struct blob *pen_http_blob_gzip(struct blob *blob)
{
    struct blob *gzip = atomic_load_explicit(&blob->gzip, memory_order_acquire);
    struct pen_buf text = {0};
    if (gzip)
        return pen_http_blob_ref(gzip);
    if (!pen_http_gzip(blob->content.data, blob->content.bytes, &text) ||
        !(gzip = pen_http_blob_take(&text)))
        return NULL;
    pen_http_blob_count(gzip, blob->sum);
    struct blob *other = NULL;
    if (atomic_compare_exchange_strong_explicit(&blob->gzip, &other, gzip, memory_order_acq_rel,
                                                memory_order_acquire))
        return pen_http_blob_ref(gzip);
    pen_http_blob_unref(gzip); /* another thread was quicker */
    return pen_http_blob_ref(other);
}

static int append(const char *text, size_t bytes, void *content)
{
    return pen_buf_add(content, text, bytes) ? 0 : -1;
}

struct blob *pen_http_blob_json(const json_t *json)
{
    /* 15 digits: a number that was sent as 0.1 comes back as 0.1. */
    const size_t flags = JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(15);
    struct pen_buf text = {0};
    if (json_dump_callback(json, append, &text, flags) != 0 || !pen_buf_puts(&text, "\n"))
        text.failed = true;
    return pen_http_blob_take(&text);
}

void pen_http_etag(const struct pen_buf *content, char etag[ETAG_BYTES])
{
    enum { HASH_BYTES = 16 };
    unsigned char hash[HASH_BYTES];
    char hex[2 * HASH_BYTES + 1];
    crypto_generichash(hash, sizeof hash, content->data, content->bytes, NULL, 0);
    sodium_bin2hex(hex, sizeof hex, hash, sizeof hash);
    snprintf(etag, ETAG_BYTES, "\"%s\"", hex);
}

void pen_http_reply_remove(struct reply *reply, int place)
{
    char *value = reply->field[place].value;
    if (value < reply->text || value >= reply->text + REPLY_TEXT)
        free(value);
    reply->field[place] = reply->field[--reply->field_count];
}

void pen_http_reply_release(struct reply *reply)
{
    while (reply->field_count > 0)
        pen_http_reply_remove(reply, reply->field_count - 1);
    pen_http_blob_unref(reply->body);
    reply->status = 0;
    reply->body = NULL;
    reply->first = reply->bytes = reply->used = 0;
    reply->streaming = reply->failed = false;
}

/* Adds a field whose value has so many bytes, with its zero. Returns where the value goes; NULL:
 * out of memory, or of fields. */
static char *add_field(struct reply *reply, const char *name, size_t bytes)
{
    const bool fits = bytes <= REPLY_TEXT - reply->used;
    char *value = fits ? reply->text + reply->used : malloc(bytes);
    if (!value || reply->field_count == REPLY_FIELDS) {
        if (!fits)
            free(value);
        reply->failed = true;
        return NULL;
    }
    reply->used += fits ? bytes : 0;
    reply->field[reply->field_count++] = (struct reply_field){name, value};
    return value;
}

void pen_http_reply_field(struct reply *reply, const char *name, const char *format, ...)
{
    char text[REPLY_TEXT];
    va_list args;
    va_start(args, format);
    const int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    const size_t bytes = length < 0 ? 1 : (size_t)length + 1;
    char *value = add_field(reply, name, bytes);
    if (!value)
        return;
    if (bytes <= sizeof text) {
        memcpy(value, text, bytes);
        return;
    }
    va_start(args, format);
    vsnprintf(value, bytes, format, args);
    va_end(args);
}

/* Adds a header field without formatting it. */
static void reply_constant(struct reply *reply, const char *name, const char *value)
{
    const size_t bytes = strlen(value) + 1;
    char *copy = add_field(reply, name, bytes);
    if (copy)
        memcpy(copy, value, bytes);
}

void pen_http_reply_body(struct reply *reply, int status, struct blob *blob, const char *type)
{
    reply->status = status;
    reply->failed = reply->failed || !blob;
    reply->body = blob;
    reply->first = 0;
    reply->bytes = blob ? blob->content.bytes : 0;
    reply_constant(reply, "Content-Type", type);
}

void pen_http_reply_json(struct reply *reply, int status, json_t *json)
{
    pen_http_reply_body(reply, status, json ? pen_http_blob_json(json) : NULL, "application/json");
    json_decref(json);
}

static void reply_problem(struct reply *reply, int status, struct blob *text)
{
    pen_http_reply_release(reply);
    pen_http_reply_body(reply, status, text, "application/problem+json");
    reply_constant(reply, "Cache-Control", "no-store");
    if (status == 429 || status == 503 || status == 507)
        reply_constant(reply, "Retry-After", "2");
}

void pen_http_reply_problem(struct reply *reply, int status, struct pen_buf *text)
{
    reply_problem(reply, status, pen_http_blob_take(text));
}

void pen_http_reply_problem_json(struct reply *reply, json_t *problem)
{
    const int status = (int)json_integer_value(json_object_get(problem, "status"));
    reply_problem(reply, status, problem ? pen_http_blob_json(problem) : NULL);
    json_decref(problem);
}

/* The range that a request selects. If-Range must hold an equal tag, byte by byte; a date never
 * matches, since the server sends no dates to compare with. */
static enum pen_range_kind granted_range(const struct reply_conditions *conditions,
                                         const char *etag, size_t size, uint64_t *first,
                                         uint64_t *count)
{
    const bool weak = strncmp(etag, "W/", 2) == 0; /* never If-Range's (RFC 9110, 13.1.5) */
    if (!conditions->range ||
        (conditions->if_range && (weak || strcmp(conditions->if_range, etag) != 0)))
        return PEN_RANGE_WHOLE;
    return pen_range_parse(conditions->range, size, first, count);
}

bool pen_http_reply_content(struct reply *reply, struct blob *blob, const char *type,
                            const char *etag, const struct reply_conditions *conditions)
{
    if (conditions->if_none_match && pen_etag_known(conditions->if_none_match, etag)) {
        /* The body is not sent, but the Content-Length of a 304 is that of the 200. */
        pen_http_reply_body(reply, 304, blob, type);
        pen_http_reply_field(reply, "ETag", "%s", etag);
        return true;
    }
    uint64_t first, count;
    size_t size = blob ? blob->content.bytes : 0;
    enum pen_range_kind range = granted_range(conditions, etag, size, &first, &count);
    if (range == PEN_RANGE_OUTSIDE) {
        pen_http_blob_unref(blob);
        return false;
    }
    pen_http_reply_body(reply, range == PEN_RANGE_PART ? 206 : 200, blob, type);
    pen_http_reply_field(reply, "ETag", "%s", etag);
    if (range == PEN_RANGE_PART) {
        reply->first = (size_t)first;
        reply->bytes = (size_t)count;
        pen_http_reply_field(reply, "Content-Range", "bytes %zu-%zu/%zu", reply->first,
                             reply->first + reply->bytes - 1, size);
    }
    return true;
}
