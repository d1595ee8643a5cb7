/* SPDX-License-Identifier: MIT */
/* Shared bodies, and building replies. */
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

/* Opens a file without a name in $TMPDIR. Returns -1 on failure. */
static int open_unlinked(void)
{
    const char *folder = getenv("TMPDIR");
    return open(folder && *folder ? folder : "/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
}

/* Moves large contents into a mapped file. On failure they stay in memory. */
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
    pen_http_blob_unref(blob->gzip);
    if (blob->is_mapped)
        munmap(blob->content.data, blob->content.bytes);
    else
        pen_buf_release(&blob->content);
    free(blob);
}

struct blob *pen_http_blob_gzip(struct blob *blob)
{
    struct pen_buf text = {0};
    if (blob->gzip)
        return pen_http_blob_ref(blob->gzip);
    return pen_http_gzip(blob->content.data, blob->content.bytes, &text) ? pen_http_blob_take(&text)
                                                                         : NULL;
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
    free(reply->field[place].value);
    reply->field[place] = reply->field[--reply->field_count];
}

void pen_http_reply_release(struct reply *reply)
{
    while (reply->field_count > 0)
        pen_http_reply_remove(reply, reply->field_count - 1);
    pen_http_blob_unref(reply->body);
    reply->status = 0;
    reply->body = NULL;
    reply->first = reply->bytes = 0;
    reply->streaming = reply->failed = false;
}

void pen_http_reply_field(struct reply *reply, const char *name, const char *format, ...)
{
    char *value = NULL;
    va_list args;
    va_start(args, format);
    if (!strchr(format, '%')) /* nearly all formats; the two calls below take a third of the time */
        value = strdup(format);
    else if (strcmp(format, "%s") == 0)
        value = strdup(va_arg(args, const char *));
    else if (vasprintf(&value, format, args) < 0)
        value = NULL;
    va_end(args);
    if (value && reply->field_count < REPLY_FIELDS) {
        reply->field[reply->field_count++] = (struct reply_field){name, value};
        return;
    }
    free(value);
    reply->failed = true;
}

void pen_http_reply_body(struct reply *reply, int status, struct blob *blob, const char *type)
{
    reply->status = status;
    reply->failed = reply->failed || !blob;
    reply->body = blob;
    reply->first = 0;
    reply->bytes = blob ? blob->content.bytes : 0;
    pen_http_reply_field(reply, "Content-Type", "%s", type);
}

void pen_http_reply_problem(struct reply *reply, int status, struct blob *text)
{
    pen_http_reply_release(reply);
    pen_http_reply_body(reply, status, text, "application/problem+json");
    pen_http_reply_field(reply, "Cache-Control", "no-store");
    if (status == 429 || status == 503 || status == 507)
        pen_http_reply_field(reply, "Retry-After", "2");
}
