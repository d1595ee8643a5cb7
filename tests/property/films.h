/* SPDX-License-Identifier: MIT */
/* The films of the golden scenes, rendered by any variant that must not matter: they are held
 * against tests/golden/hashes.txt, read from the folder that the program runs in. */
#ifndef TESTS_PROPERTY_FILMS_H
#define TESTS_PROPERTY_FILMS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* The order in which a film's tiles are rendered. */
enum films_order {
    FILMS_AT_ONCE, /* as the pool takes them */
    FILMS_SHUFFLED /* one by one, in the order that `seed` says */
};

struct films_variant {
    int threads, tile; /* tile 0: one tile for all */
    int accelerator;   /* enum pen_accelerator */
    enum films_order order;
    uint64_t seed;
    bool cut;         /* cancelled in the middle, then the tiles that were not done */
    const char *isa;  /* PENUMBRA_ISA; NULL: none */
    unsigned strange; /* bits set in MXCSR before anything is made; 0: none */
};

/* How many films the table names; 0 if it cannot be read. */
int films_count(void);

/* Whether film `i`, rendered by that variant, has the hash of the table; why says what is wrong. */
bool films_match(int i, const struct films_variant *variant, char *why, size_t bytes);

/* The file of film i. */
const char *films_scene(int i);

/* Prints a line for film i: a hash of the binary64 values that it is rounded from, scene, view.
 * False if the film cannot be rendered, which it says. */
bool films_print_accumulators(int i, FILE *out);

#endif
