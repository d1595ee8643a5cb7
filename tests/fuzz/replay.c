/* SPDX-License-Identifier: MIT */
/* Gives the named files to a fuzz target, in a build without libFuzzer. */
#include <stdio.h>

#include "fuzz/fuzz.h"

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        FILE *file = fopen(argv[i], "rb");
        uint8_t *bytes = malloc(1 << 22);
        must(file && bytes);
        size_t size = fread(bytes, 1, 1 << 22, file);
        uint8_t *exact = malloc(size ? size : 1); /* so that a read behind the end is found */
        must(exact != NULL);
        memcpy(exact, bytes, size);
        free(bytes);
        fclose(file);
        printf("%s\n", argv[i]); /* the last one printed is the one that fails */
        fflush(stdout);
        LLVMFuzzerTestOneInput(exact, size);
        free(exact);
    }
    return 0;
}
