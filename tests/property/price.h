/* SPDX-License-Identifier: MIT */
/* What the robust tests cost, per ray and primitive, against plain ones. */
#ifndef TESTS_PROPERTY_PRICE_H
#define TESTS_PROPERTY_PRICE_H

#include <stdbool.h>

enum { PRICE_MAX = 32 };

struct price {
    const char *primitive, *method;
    double ns;           /* median of interleaved runs */
    double instructions; /* by callgrind; 0: not counted */
};

/* Times every method; returns how many. */
int price_measure(struct price out[PRICE_MAX]);

/* Runs method number i for `calls` tests and nothing else, for callgrind. False: no such method. */
bool price_run(int i, long calls);

/* Fills in the instructions, by running this program under callgrind, if that is there. */
void price_count(const char *program, struct price out[PRICE_MAX], int count);

#endif
