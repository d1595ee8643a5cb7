/* SPDX-License-Identifier: MIT */
/* What the fuzz targets share. A target is a function over any bytes, which ends the process if a
 * promise of the program does not hold. libFuzzer calls it with inputs that it makes (`make fuzz`),
 * and replay.c with the kept ones (check_corpus.sh). */
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

/* The bytes with a zero byte behind them. Owns: the caller frees it. */
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
