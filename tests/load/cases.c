/* SPDX-License-Identifier: MIT */
#include "load/cases.h"

#include <string.h>

#define H LOAD_HOST
#define GET LOAD_GET
#define POST "POST /v1/validate HTTP/1.1\r\n" H
#define CHUNKED POST "Transfer-Encoding: chunked\r\n\r\n"
#define CASE(due, name, text)                                                                      \
    {                                                                                              \
        name, due, text, sizeof text - 1, 0                                                        \
    }
#define LONG(name, text, filler)                                                                   \
    {                                                                                              \
        name, DUE_LONG, text, sizeof text - 1, filler                                              \
    }

const struct load_case load_cases[] = {
    CASE(DUE_ANSWER, "good GET", GET H "\r\n"),
    CASE(DUE_ANSWER, "no space behind colon", GET "Host:localhost\r\n\r\n"),
    CASE(DUE_ANY, "folded field", GET H "X-A: a\r\n b\r\n\r\n"),
    CASE(DUE_REFUSAL, "space before colon", GET H "X-A : a\r\n\r\n"),
    CASE(DUE_ANY, "zero in a value", GET H "X-A: a\0b\r\n\r\n"),
    CASE(DUE_ANY, "LF line ends", "GET /healthz HTTP/1.1\nHost: localhost\n\n"),
    CASE(DUE_REFUSAL, "bare CR in a value", GET H "X-A: a\rX-B: b\r\n\r\n"),
    CASE(DUE_REFUSAL, "no Host", GET "\r\n"),
    CASE(DUE_REFUSAL, "two Hosts", GET H "Host: other\r\n\r\n"),
    CASE(DUE_ANY, "field without colon", GET H "nonsense\r\n\r\n"),
    CASE(DUE_REFUSAL, "space in target", "GET /heal thz HTTP/1.1\r\n" H "\r\n"),
    CASE(DUE_ANY, "HTTP/2.0", "GET /healthz HTTP/2.0\r\n" H "\r\n"),
    CASE(DUE_END, "lengths 5, 6", POST "Content-Length: 5\r\nContent-Length: 6\r\n\r\n12345"),
    CASE(DUE_ANY, "lengths 5, 5", POST "Content-Length: 5\r\nContent-Length: 5\r\n\r\n12345"),
    CASE(DUE_END, "length +5", POST "Content-Length: +5\r\n\r\n12345"),
    CASE(DUE_END, "length 5, chunked",
         POST "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n12345\r\n0\r\n\r\n"),
    CASE(DUE_END, "xchunked, length",
         POST "Content-Length: 5\r\nTransfer-Encoding: xchunked\r\n\r\n12345"),
    CASE(DUE_END, "gzip, chunked",
         POST "Transfer-Encoding: gzip, chunked\r\n\r\n5\r\n12345\r\n0\r\n\r\n"),
    CASE(DUE_ANY, "chunked, folded",
         POST "Transfer-Encoding:\r\n chunked\r\n\r\n5\r\n12345\r\n0\r\n\r\n"),
    CASE(DUE_ANY, "good chunks", CHUNKED "5\r\n12345\r\n0\r\n\r\n"),
    CASE(DUE_ANY, "chunk extension", CHUNKED "5;a=b\r\n12345\r\n0\r\n\r\n"),
    CASE(DUE_ANY, "chunk lines end in LF", CHUNKED "5\n12345\n0\n\n"),
    CASE(DUE_SIZE, "chunk size 5 x", CHUNKED "5 x\r\n12345\r\n0\r\n\r\n"),
    CASE(DUE_END, "chunk size 2^64", CHUNKED "10000000000000005\r\n12345\r\n0\r\n\r\n"),
    LONG("target of 20 KiB", "GET /~ HTTP/1.1\r\n" H "\r\n", 20480),
    LONG("target of 60 KiB", "GET /~ HTTP/1.1\r\n" H "\r\n", 61440),
    LONG("field of 60 KiB", GET H "X-A: ~\r\n\r\n", 61440),
    CASE(DUE_END, "TLS hello", "\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03\r\n\r\n"),
};
const size_t load_case_count = sizeof load_cases / sizeof load_cases[0];

size_t load_case_write(const struct load_case *item, char *out)
{
    size_t written = 0;
    for (size_t i = 0; i < item->bytes; i++) {
        if (item->filler && item->text[i] == '~') {
            memset(out + written, 'a', item->filler);
            written += item->filler;
        } else {
            out[written++] = item->text[i];
        }
    }
    return written;
}
