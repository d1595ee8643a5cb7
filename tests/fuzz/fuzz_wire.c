/* SPDX-License-Identifier: MIT */
/* Any bytes as what a connection receives. The first byte says how the rest is cut into pieces, as
 * the network may cut it anywhere, and the second what it is: the head of a request, a body in
 * chunks, the trailer of one, or a compressed body. */
#include "base/buf.h"
#include "fuzz/fuzz.h"
#include "http/internal/encoding.h"
#include "http/wire.h"

enum { HEAD, CHUNKS, GZIP, TRAILER, SUBJECTS };

/* The length of the next piece: from 1 to 256 bytes, or all that is left. */
static size_t piece(unsigned *cut, size_t left)
{
    *cut = *cut * 1103515245u + 12345u;
    const size_t bytes = 1 + ((*cut >> 16) & 255) % (1 + (*cut >> 28) * 16);
    return bytes < left ? bytes : left;
}

/* Finds the end of a head or trailer, which is where it is if all comes at once. Returns its
 * length, 0 if there is none. */
static size_t find(const char *text, size_t size, int trailer, unsigned cut)
{
    struct pen_head_scan whole = {.begun = trailer}, parts = whole;
    size_t bytes = 0, bytes_of_parts = 0;
    const enum pen_head_found found = pen_head_find(text, size, &whole, &bytes);
    enum pen_head_found then = PEN_HEAD_PART;
    for (size_t at = 0; at < size && then == PEN_HEAD_PART;) {
        at += piece(&cut, size - at);
        then = pen_head_find(text, at, &parts, &bytes_of_parts);
    }
    must(found == then);
    must(found != PEN_HEAD_WHOLE || (bytes > 0 && bytes == bytes_of_parts && bytes <= size));
    return found == PEN_HEAD_WHOLE ? bytes : 0;
}

static void check_head(const uint8_t *data, size_t size, unsigned cut)
{
    char *text = fuzz_text(data, size);
    const size_t bytes = find(text, size, 0, cut);
    struct pen_head head;
    struct pen_status st = {0};
    const int status = bytes ? pen_head_parse(text, bytes, &head, &st) : 400;
    must(status == 0 || status == 400 || status == 431 || status == 505);
    must(status == 0 || bytes == 0 || st.msg[0]);
    if (status == 0) {
        must(head.method[0] && head.target[0] && (head.minor == 0 || head.minor == 1));
        must(head.field_count >= 0 && head.field_count <= PEN_HEAD_FIELDS);
        for (int i = 0; i < head.field_count; i++) {
            must(head.field[i].name[0] && !strpbrk(head.field[i].name, " \t:\r\n"));
            must(!strpbrk(head.field[i].value, "\r\n"));
            pen_list_has_token(head.field[i].value, "close");
        }
    }
    free(text);
}

/* A trailer is checked as it is, and stays so. */
static void check_trailer(const uint8_t *data, size_t size, unsigned cut)
{
    char *text = fuzz_text(data, size);
    const size_t bytes = find(text, size, 1, cut);
    struct pen_status st = {0};
    if (bytes > 0 && bytes <= PEN_TRAILER_BYTES) {
        const int status = pen_trailer_check(text, bytes, &st);
        must(status == 0 || ((status == 400 || status == 431) && st.msg[0]));
        must(memcmp(text, data, size) == 0);
    }
    free(text);
}

/* Decodes a body in chunks; returns whether its framing is right as far as it goes. */
static int decode(const char *text, size_t size, int at_once, unsigned cut, struct pen_buf *out,
                  size_t *used)
{
    struct pen_chunks chunks = {0};
    size_t at = 0, end = 0;
    while (at < size && chunks.state != PEN_CHUNKS_TRAILER) {
        const char *part;
        size_t bytes;
        if (at == end)
            end += at_once ? size - at : piece(&cut, size - at);
        const ptrdiff_t got = pen_chunks_read(&chunks, text + at, end - at, &part, &bytes);
        if (got < 0)
            return 0;
        must((size_t)got <= end - at && bytes <= (size_t)got);
        must(got > 0 || chunks.state == PEN_CHUNKS_TRAILER);
        if (bytes > 0)
            must(part >= text + at && part + bytes <= text + at + got);
        pen_buf_add(out, part, bytes);
        at += (size_t)got;
    }
    *used = at;
    return 1;
}

static void check_chunks(const uint8_t *data, size_t size, unsigned cut)
{
    char *text = fuzz_text(data, size);
    struct pen_buf whole = {0}, parts = {0};
    size_t used = 0, used_of_parts = 0;
    const int ok = decode(text, size, 1, 0, &whole, &used);
    must(ok == decode(text, size, 0, cut, &parts, &used_of_parts));
    must(!ok || (used == used_of_parts && whole.bytes == parts.bytes &&
                 (whole.bytes == 0 || memcmp(whole.data, parts.data, whole.bytes) == 0)));
    pen_buf_release(&whole);
    pen_buf_release(&parts);
    free(text);
}

/* What was decompressed keeps to the limit, and is the same after it was compressed again. */
static void check_gzip(const uint8_t *data, size_t size)
{
    enum { LIMIT = 1 << 20 };
    struct pen_buf plain = {0}, packed = {0}, again = {0};
    struct pen_status st = {0};
    if (pen_http_gunzip(data, size, LIMIT, &plain, &st)) {
        must(plain.bytes <= LIMIT);
        must(pen_http_gzip(plain.data, plain.bytes, &packed));
        must(pen_http_gunzip(packed.data, packed.bytes, LIMIT, &again, &st));
        must(again.bytes == plain.bytes &&
             (plain.bytes == 0 || memcmp(again.data, plain.data, plain.bytes) == 0));
    } else {
        must(plain.bytes == 0 && st.msg[0]);
    }
    pen_buf_release(&plain);
    pen_buf_release(&packed);
    pen_buf_release(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 2)
        return 0;
    const unsigned cut = data[0];
    switch (data[1] % SUBJECTS) {
    case HEAD:
        check_head(data + 2, size - 2, cut);
        break;
    case CHUNKS:
        check_chunks(data + 2, size - 2, cut);
        break;
    case GZIP:
        check_gzip(data + 2, size - 2);
        break;
    case TRAILER:
        check_trailer(data + 2, size - 2, cut);
        break;
    }
    return 0;
}
