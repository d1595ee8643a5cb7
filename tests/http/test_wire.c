/* SPDX-License-Identifier: MIT */
/* Heads and bodies in chunks as bytes, without a connection: what is read, what is refused, and
 * that it does not matter where the bytes are cut. */
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "http/wire.h"
#include "support/suite.h"

#define COUNT(rows) (sizeof(rows) / sizeof(rows)[0])

/* Parses a head. Returns the status; the caller frees *text, into which *head points. */
static int parse(const char *raw, struct pen_head *head, char **text)
{
    struct pen_head_scan scan = {0};
    struct pen_status st;
    size_t bytes;
    ck_assert_int_eq(pen_head_find(raw, strlen(raw), &scan, &bytes), PEN_HEAD_WHOLE);
    *text = strdup(raw);
    return pen_head_parse(*text, bytes, head, &st);
}

START_TEST(test_wire__head_is_found_wherever_it_is_cut)
{
    static const char raw[] = "\r\n\r\nGET / HTTP/1.1\r\nHost: a\r\nX:\r\n\r\nGET /next";
    const size_t whole = strlen(raw) - strlen("GET /next");
    for (size_t cut = 0; cut < whole; cut++) {
        struct pen_head_scan scan = {0};
        size_t bytes = 0;
        ck_assert_int_eq(pen_head_find(raw, cut, &scan, &bytes), PEN_HEAD_PART);
        ck_assert_int_eq(pen_head_find(raw, sizeof raw - 1, &scan, &bytes), PEN_HEAD_WHOLE);
        ck_assert_uint_eq(bytes, whole);
    }
    struct pen_head_scan scan = {0};
    size_t bytes;
    ck_assert_int_eq(pen_head_find("GET /\n", 6, &scan, &bytes), PEN_HEAD_BAD);
    scan = (struct pen_head_scan){0};
    ck_assert_int_eq(pen_head_find("\n", 1, &scan, &bytes), PEN_HEAD_BAD);
}
END_TEST

START_TEST(test_wire__head_is_split)
{
    struct pen_head head;
    char *text;
    ck_assert_int_eq(
        parse("\r\nPATCH /a?b=%20 HTTP/1.0\r\nHost:a:1\r\nX-Y: \t b  c\t \r\nZ:\r\n\r\n", &head,
              &text),
        0);
    ck_assert_str_eq(head.method, "PATCH");
    ck_assert_str_eq(head.target, "/a?b=%20");
    ck_assert_int_eq(head.minor, 0);
    ck_assert_int_eq(head.field_count, 3);
    ck_assert_str_eq(head.field[0].name, "Host");
    ck_assert_str_eq(head.field[0].value, "a:1");
    ck_assert_str_eq(head.field[1].value, "b  c");
    ck_assert_str_eq(head.field[2].value, "");
    free(text);
}
END_TEST

START_TEST(test_wire__heads_announce_bodies_also_when_malformed)
{
    static const struct {
        const char *raw;
        bool announces;
    } rows[] = {{"GET / HTTP/1.1\r\nHost: a\r\n\r\n", false},
                {"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\n", true},
                {"POST / HTTP/1.1\r\ntransfer-ENCODING: chunked\r\n\r\n", true},
                {"POST / HTTP/1.1\r\nHost : a\r\ncontent-length : 5\r\n\r\n", true},
                {"POST\r\nContent-Length\r\n\r\n", true},
                {"GET /Content-Length HTTP/1.1\r\nX: Transfer-Encoding\r\n\r\n", false},
                {"\x16\x03\x01\r\n\r\n", false},
                {"\r\n\r\nContent-Lengt\r\n\r\n", false}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        /* in a block of its own, so that reading beyond the head is found */
        const size_t bytes = strlen(rows[i].raw);
        char *head = malloc(bytes);
        memcpy(head, rows[i].raw, bytes);
        ck_assert_msg(pen_head_announces_body(head, bytes) == rows[i].announces, "%s", rows[i].raw);
        free(head);
    }
}
END_TEST

START_TEST(test_wire__wrong_heads_are_refused)
{
    static const struct {
        const char *raw;
        int status;
    } rows[] = {{"GET / HTTP/1.1\r\nHost : a\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nHost\t: a\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nHost: a\r\n b\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\n\tHost: a\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nHost: a\rb\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nHost: \x7f\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\n:\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nHost\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nH(st: a\r\n\r\n", 400},
                {" GET / HTTP/1.1\r\n\r\n", 400},
                {"GET\t/ HTTP/1.1\r\n\r\n", 400},
                {"GET  / HTTP/1.1\r\n\r\n", 400},
                {"GET / HTTP/1.1 \r\n\r\n", 400},
                {"GET / HTTP/11\r\n\r\n", 400},
                {"GET / HTTP/1.10\r\n\r\n", 400},
                {"GET / FTP/1.1\r\n\r\n", 400},
                {"GET /\r\n\r\n", 400},
                {"/\r\n\r\n", 400},
                {"GET / HTTP/0.9\r\n\r\n", 505},
                {"GET / HTTP/2.0\r\n\r\n", 505},
                {"GET / HTTP/1.2\r\nHost: \xc3\xa9\r\n\r\n", 0}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pen_head head;
        char *text;
        int status = parse(rows[i].raw, &head, &text);
        ck_assert_msg(status == rows[i].status, "%s: %d", rows[i].raw, status);
        free(text);
    }
}
END_TEST

START_TEST(test_wire__zero_bytes_are_refused)
{
    static const char raw[] = "GET / HTTP/1.1\r\nX: a\0b\r\n\r\n";
    for (size_t i = 0; i < sizeof raw - 5; i++) {
        char text[sizeof raw];
        struct pen_head head;
        struct pen_status st;
        memcpy(text, raw, sizeof raw);
        text[sizeof "GET / HTTP/1.1\r\nX: a" - 1] = '-';
        if (text[i] == '\r' || text[i] == '\n')
            continue;
        text[i] = '\0';
        ck_assert_msg(pen_head_parse(text, sizeof raw - 1, &head, &st) == 400, "at %zu", i);
    }
}
END_TEST

START_TEST(test_wire__fields_are_bounded)
{
    struct pen_buf raw = {0};
    struct pen_head head;
    char *text;
    pen_buf_puts(&raw, "GET / HTTP/1.1\r\n");
    for (int i = 0; i <= PEN_HEAD_FIELDS; i++)
        pen_buf_printf(&raw, "X-%d: %d\r\n", i, i);
    pen_buf_puts(&raw, "\r\n");
    ck_assert_int_eq(parse((const char *)raw.data, &head, &text), 431);
    free(text);
    pen_buf_release(&raw);
}
END_TEST

/* Decodes a body in pieces of at most `piece` bytes. Returns whether all chunks were read, and the
 * number of bytes that were read. */
static bool decode(const char *raw, size_t piece, struct pen_buf *out, size_t *read)
{
    struct pen_chunks chunks = {0};
    size_t bytes = strlen(raw);
    *read = 0;
    pen_buf_add(out, "", 0);
    while (*read < bytes && chunks.state != PEN_CHUNKS_TRAILER) {
        const char *data;
        size_t count;
        size_t part = bytes - *read < piece ? bytes - *read : piece;
        ptrdiff_t used = pen_chunks_read(&chunks, raw + *read, part, &data, &count);
        if (used <= 0)
            return false;
        if (count > 0)
            pen_buf_add(out, data, count);
        *read += (size_t)used;
    }
    return chunks.state == PEN_CHUNKS_TRAILER;
}

START_TEST(test_wire__chunks_are_joined_wherever_they_are_cut)
{
    static const char raw[] = "5\r\nhello\r\n0A;name=\"x\"\r\n, world: x\r\n000\r\nX: y\r\n\r\nGET";
    for (size_t piece = 1; piece < sizeof raw; piece++) {
        struct pen_buf out = {0};
        size_t read;
        ck_assert(decode(raw, piece, &out, &read));
        ck_assert_str_eq((const char *)out.data, "hello, world: x");
        ck_assert_str_eq(raw + read, "X: y\r\n\r\nGET");
        pen_buf_release(&out);
    }
}
END_TEST

START_TEST(test_wire__wrong_chunks_are_refused)
{
    static const char *const rows[] = {"\r\n",        "x\r\n",          "5\nhello\r\n",
                                       "5\rhello",    "5\r\nhello5",    "5\r\nhello\n0\r\n\r\n",
                                       " 5\r\n",      "-5\r\n",         "0x5\r\n",
                                       ";x\r\n",      "5\r\nhello\r\r", "fffffffffffffffff\r\n",
                                       "0\nX: y\r\n", "1 2\x01\r\n"};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pen_buf out = {0};
        size_t read;
        ck_assert_msg(!decode(rows[i], 1000, &out, &read) && read < strlen(rows[i]), "%s", rows[i]);
        pen_buf_release(&out);
    }
}
END_TEST

START_TEST(test_wire__trailers_are_read_as_fields_of_a_head)
{
    static const struct {
        const char *raw;
        int status;
    } rows[] = {{"\r\n", 0},
                {"X: y\r\nExpires:\r\n\r\n", 0},
                {"X : y\r\n\r\n", 400},
                {" X: y\r\n\r\n", 400},
                {"X: y\r\n z\r\n\r\n", 400},
                {"garbage\r\n\r\n", 400},
                {"X: y\rz\r\n\r\n", 400},
                {"Content-Length: 5\r\n\r\n", 400},
                {"X: y\r\ntransfer-encoding: chunked\r\n\r\n", 400}};
    struct pen_status st;
    size_t bytes;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pen_head_scan scan = {.begun = true};
        ck_assert_int_eq(pen_head_find(rows[i].raw, strlen(rows[i].raw), &scan, &bytes),
                         PEN_HEAD_WHOLE);
        int status = pen_trailer_check(rows[i].raw, bytes, &st);
        ck_assert_msg(status == rows[i].status, "%s: %d", rows[i].raw, status);
    }
    static const char zero[] = "X: a\0b\r\n\r\n";
    ck_assert_int_eq(pen_trailer_check(zero, sizeof zero - 1, &st), 400);
    struct pen_buf many = {0};
    for (int i = 0; i <= PEN_HEAD_FIELDS; i++)
        pen_buf_puts(&many, "X: y\r\n");
    pen_buf_puts(&many, "\r\n");
    ck_assert_int_eq(pen_trailer_check((const char *)many.data, many.bytes, &st), 431);
    ck_assert_str_eq(st.msg, "there are more than 100 header fields");
    pen_buf_release(&many);
}
END_TEST

START_TEST(test_wire__tokens_of_a_list)
{
    ck_assert(pen_list_has_token("close", "close"));
    ck_assert(pen_list_has_token("Keep-Alive, Close", "close"));
    ck_assert(pen_list_has_token(" a ,\tclose ", "close"));
    ck_assert(!pen_list_has_token("closed, enclose", "close"));
    ck_assert(!pen_list_has_token("", "close"));
}
END_TEST

PEN_SUITE("wire", test_wire__head_is_found_wherever_it_is_cut, test_wire__head_is_split,
          test_wire__heads_announce_bodies_also_when_malformed, test_wire__wrong_heads_are_refused,
          test_wire__zero_bytes_are_refused, test_wire__fields_are_bounded,
          test_wire__chunks_are_joined_wherever_they_are_cut, test_wire__wrong_chunks_are_refused,
          test_wire__trailers_are_read_as_fields_of_a_head, test_wire__tokens_of_a_list)
