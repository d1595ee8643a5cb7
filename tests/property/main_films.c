/* SPDX-License-Identifier: MIT */
/* films [PART…]: prints a line for each golden film of this build: the hash of the binary64 values
 * before rounding, scene, view. With PARTs, only films whose scene contains one of them. Prints
 * each film that differs from the table; exit status 1 if there is any. */
#include "property/films.h"

#include <string.h>

static bool wanted(int film, char **parts)
{
    bool any = !*parts;
    for (; *parts && !any; parts++)
        any = strstr(films_scene(film), *parts) != NULL;
    return any;
}

int main(int argc, char **argv)
{
    (void)argc;
    const struct films_variant variant = {.threads = 2, .tile = 16};
    int different = 0;
    for (int i = 0; i < films_count(); i++) {
        char why[240];
        if (!wanted(i, argv + 1))
            continue;
        if (!films_print_accumulators(i, stdout))
            return 1;
        if (films_match(i, &variant, why, sizeof why))
            continue;
        fprintf(stderr, "films: %s\n", why);
        different++;
    }
    return films_count() == 0 || different > 0;
}
