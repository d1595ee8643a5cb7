/* SPDX-License-Identifier: MIT */
/* Mutated requests: those of cases.h, and requests to every route of the daemon. */
#ifndef TESTS_LOAD_REQUESTS_H
#define TESTS_LOAD_REQUESTS_H

#include <stddef.h>

#include "support/random.h"

enum { LOAD_TEXT_BYTES = 65536 };

struct load_text {
    char data[LOAD_TEXT_BYTES];
    size_t bytes;
};

struct load_names {
    const char *job, *token; /* the id of a job, a client's token */
};

/* Writes one to four requests, each mutated in up to six places. */
void load_mutate(struct load_text *all, const struct load_names *names, struct random *random);

#endif
