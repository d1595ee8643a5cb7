/* SPDX-License-Identifier: MIT */
/* The cost of the robust tests, per ray and primitive, beside plain tests. */
#ifndef TESTS_PROPERTY_PRICE_H
#define TESTS_PROPERTY_PRICE_H

#include <stdbool.h>

enum { PRICE_MAX = 32 };

struct price {
    const char *primitive, *method;
    double ns;           /* median of interleaved runs */
    double instructions; /* by callgrind; 0: not counted */
};

/* Times every method; returns their number. */
int price_measure(struct price out[PRICE_MAX]);

/* Runs only method number i for `calls` tests, for callgrind. Returns false if there is no such
 * method. */
bool price_run(int i, long calls);

/* Fills in the instructions by running this program under callgrind, if that is installed. */
void price_count(const char *program, struct price out[PRICE_MAX], int count);

#endif
