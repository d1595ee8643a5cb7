/* SPDX-License-Identifier: MIT */
/* The parts that all fuzz targets share. A target is a function of any bytes, which ends the
 * process if the program breaks a promise. libFuzzer calls it with its own inputs (`make fuzz`).
 * replay.c calls it with the stored inputs (check_corpus.sh). */
#ifndef PEN_TESTS_FUZZ_H
#define PEN_TESTS_FUZZ_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void must(int holds)
{
    if (!holds)
        abort();
}

/* Returns the bytes with a zero byte after them.
 * Owns: the caller frees it. */
static inline char *fuzz_text(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1);
    must(text != NULL);
    if (size > 0)
        memcpy(text, data, size);
    text[size] = '\0';
    return text;
}

#endif
