/* SPDX-License-Identifier: MIT */
/* Requests whose head or framing is right, doubtful or wrong. */
#ifndef TESTS_LOAD_CASES_H
#define TESTS_LOAD_CASES_H

#include <stddef.h>

enum load_due {
    DUE_ANSWER,  /* 200 */
    DUE_ANY,     /* a server may be strict or not */
    DUE_REFUSAL, /* a refusal; the end of the request is known, so the next request may follow */
    DUE_END,     /* a refusal, and no answer to later bytes */
    DUE_SIZE,    /* the same; a front may accept it, because it sends the length that it has read */
    DUE_LONG     /* 431, 414 for a target, or the end of the connection */
};

struct load_case {
    const char *name;
    enum load_due due;
    const char *text; /* may contain '\0' */
    size_t bytes;
    size_t filler; /* the '~' in the text stands for this number of letters */
};

#define LOAD_HOST "Host: localhost\r\n"
#define LOAD_GET "GET /healthz HTTP/1.1\r\n"
#define LOAD_GOOD LOAD_GET LOAD_HOST "\r\n"

extern const struct load_case load_cases[];
extern const size_t load_case_count;

enum { LOAD_CASE_MAX = 65536 };

/* Writes the bytes of a case, at most LOAD_CASE_MAX. Returns their number. */
size_t load_case_write(const struct load_case *item, char *out);

#endif
