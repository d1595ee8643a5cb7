/* SPDX-License-Identifier: MIT */
#include "http/internal/encoding.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/message.h"

enum {
    PART_BYTES = 64 << 10,
    GZIP_BITS = 15 + 16,    /* zlib's code for gzip */
    LEVEL = 5,              /* higher levels take twice the time for reports that are 2 % smaller */
    SMALL_BYTES = 1400,     /* one packet */
    LARGE_BYTES = 32 << 20, /* would occupy a thread for too long */
};

/* Decompresses all members of a gzip file. */
static bool inflate_all(z_stream *stream, size_t limit, struct pen_buf *out, struct pen_status *st)
{
    unsigned char *part = malloc(PART_BYTES);
    int result = part ? Z_OK : Z_MEM_ERROR;
    while (result == Z_OK) {
        stream->next_out = part;
        stream->avail_out = PART_BYTES;
        result = inflate(stream, Z_NO_FLUSH);
        size_t got = PART_BYTES - stream->avail_out;
        if (result != Z_OK && result != Z_STREAM_END)
            break;
        if (out->bytes + got > limit) {
            free(part);
            return pen_fail(st, PEN_TOO_LARGE,
                            "the body has more than %zu bytes when it is decompressed", limit);
        }
        if (!pen_buf_add(out, part, got))
            result = Z_MEM_ERROR;
        else if (result == Z_STREAM_END && stream->avail_in > 0)
            result = inflateReset(stream);
    }
    free(part);
    if (result == Z_MEM_ERROR)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to decompress the body");
    return result == Z_STREAM_END ||
           pen_fail(st, PEN_SYNTAX, "the body is not gzip as its Content-Encoding says");
}

bool pen_http_gunzip(const void *data, size_t bytes, size_t limit, struct pen_buf *out,
                     struct pen_status *st)
{
    z_stream stream = {.next_in = (Bytef *)data, .avail_in = (uInt)bytes};
    if (inflateInit2(&stream, GZIP_BITS) != Z_OK)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to decompress the body");
    bool ok = inflate_all(&stream, limit, out, st);
    inflateEnd(&stream);
    if (!ok)
        pen_buf_release(out);
    return ok;
}

bool pen_http_gzip(const void *data, size_t bytes, struct pen_buf *out)
{
    z_stream stream = {.next_in = (Bytef *)data, .avail_in = (uInt)bytes};
    if (deflateInit2(&stream, LEVEL, Z_DEFLATED, GZIP_BITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return false;
    size_t most = deflateBound(&stream, (uLong)bytes);
    unsigned char *text = malloc(most);
    stream.next_out = text;
    stream.avail_out = (uInt)most;
    bool ok = text && deflate(&stream, Z_FINISH) == Z_STREAM_END &&
              pen_buf_add(out, text, most - stream.avail_out);
    free(text);
    deflateEnd(&stream);
    if (!ok)
        pen_buf_release(out);
    return ok;
}

bool pen_http_request_decode(struct request *request)
{
    const size_t limit = request->http->limits.body_bytes;
    struct pen_buf plain = {0};
    struct pen_status st;
    if (!request->fields.content_encoding || request->body.bytes == 0)
        return true;
    bool ok = pen_http_gunzip(request->body.data, request->body.bytes, limit, &plain, &st);
    if (ok && !pen_http_request_count_body(request, plain.bytes))
        ok =
            pen_fail(&st, PEN_UNAVAILABLE, "there is no memory for this body now; try again later");
    if (!ok) {
        pen_buf_release(&plain);
        pen_http_request_fail(request, &st);
        return false;
    }
    pen_buf_release(&request->body);
    request->body = plain;
    request->fields.content_encoding = NULL;
    return true;
}

/* The index of the header field; -1: the reply has none. */
static int find_field(const struct reply *reply, const char *name)
{
    for (int i = 0; i < reply->field_count; i++) {
        if (strcmp(reply->field[i].name, name) == 0)
            return i;
    }
    return -1;
}

/* Changes the entity tag. A strong tag identifies the bytes that are sent, so compressed bytes have
 * their own tag. */
static void change_tag(struct reply *reply)
{
    const int at = find_field(reply, "ETag");
    if (at < 0)
        return;
    const char *tag = reply->field[at].value;
    pen_http_reply_field(reply, "ETag", "%.*s" PEN_GZIP_TAG "\"", (int)strlen(tag) - 1, tag);
    pen_http_reply_remove(reply, at);
}

/* Whether compression makes the body smaller. Pictures are compressed already. */
static bool is_compressible(const struct reply *reply)
{
    const int type = find_field(reply, "Content-Type");
    return !reply->failed && reply->body && type >= 0 &&
           (strncmp(reply->field[type].value, "image/", 6) != 0 ||
            strcmp(reply->field[type].value, "image/svg+xml") == 0);
}

void pen_http_request_encode(struct request *request)
{
    struct reply *reply = &request->reply;
    if (!is_compressible(reply))
        return;
    if (find_field(reply, "Vary") < 0)
        pen_http_reply_field(reply, "Vary", "Accept-Encoding");
    if (reply->bytes < SMALL_BYTES || reply->bytes > LARGE_BYTES ||
        !pen_encoding_is_gzip(request->fields.accept_encoding))
        return;
    if (reply->status == 304) { /* a 304 has no body */
        change_tag(reply);
        return;
    }
    struct blob *gzip = pen_http_blob_gzip(reply->body);
    if (!gzip)
        return; /* the plain body is sent instead */
    pen_http_blob_unref(reply->body);
    reply->body = gzip;
    reply->bytes = gzip->content.bytes;
    pen_http_reply_field(reply, "Content-Encoding", "gzip");
    change_tag(reply);
}
