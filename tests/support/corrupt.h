/* SPDX-License-Identifier: MIT */
/* Random changes of a text, like those of typing, cutting, pasting and transmission, for property
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

/* The pieces of a language that are inserted at random. */
struct corrupt_kind {
    const char *const *piece;
    size_t count;
};

/* Reads a file, which may fill at most half of the buffer. The test fails if it cannot be read. */
void corrupt_read(const char *path, struct corrupt_text *text);

/* Makes one change: inserts a piece or a byte, removes a part or copies it elsewhere, or changes a
 * byte or a digit. */
void corrupt(struct random *random, struct corrupt_text *text, const struct corrupt_kind *kind);

#endif
