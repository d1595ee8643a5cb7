/* SPDX-License-Identifier: MIT */
/* The films of the golden scenes, rendered in ways that must not matter. They are compared with
 * tests/golden/hashes.txt, which is read from the current folder. */
#ifndef TESTS_PROPERTY_FILMS_H
#define TESTS_PROPERTY_FILMS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* The order in which a film's tiles are rendered. */
enum films_order {
    FILMS_AT_ONCE, /* as the pool takes them */
    FILMS_SHUFFLED /* one by one, in an order drawn from `seed` */
};

struct films_variant {
    int threads, tile; /* tile 0: one tile for all */
    int accelerator;   /* enum pen_accelerator */
    enum films_order order;
    uint64_t seed;
    bool cut;         /* cancelled in the middle, then the unfinished tiles */
    const char *isa;  /* PENUMBRA_ISA; NULL: none */
    unsigned strange; /* bits set in MXCSR before anything is made; 0: none */
};

/* Returns the number of films in the table; 0 if it cannot be read. */
int films_count(void);

/* Returns true if film `i`, rendered in this way, has the hash of the table; else `why` is the
 * reason. */
bool films_match(int i, const struct films_variant *variant, char *why, size_t bytes);

/* The file of film i. */
const char *films_scene(int i);

/* Prints a line for film i: a hash of its binary64 values before rounding, scene, view. Prints an
 * error and returns false if the film cannot be rendered. */
bool films_print_accumulators(int i, FILE *out);

#endif
