/* SPDX-License-Identifier: MIT */
/* Text with changes of the kind that typing, cutting, pasting and transmission make, for property
 * tests of readers. */
#ifndef TESTS_SUPPORT_CORRUPT_H
#define TESTS_SUPPORT_CORRUPT_H

#include <stddef.h>

#include "support/random.h"

enum { CORRUPT_BYTES = 1 << 16 };

struct corrupt_text {
    char data[CORRUPT_BYTES];
    size_t bytes;
};

/* What a language is made of: inserted here and there. */
struct corrupt_kind {
    const char *const *piece;
    size_t count;
};

/* Reads a file, at most half of what there is room for; the test fails if it cannot. */
void corrupt_read(const char *path, struct corrupt_text *text);

/* One change: a piece or a byte put in, a part taken out or put in again elsewhere, a byte or a
 * digit changed. */
void corrupt(struct random *random, struct corrupt_text *text, const struct corrupt_kind *kind);

#endif
