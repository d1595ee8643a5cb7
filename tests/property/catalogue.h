/* SPDX-License-Identifier: MIT */
/* The catalogue of hard cases H001 to H149: what each is, and where it is tested. Rows of the suite
 * say themselves which cases they are (struct row, id); here are the tests elsewhere, and the
 * reasons for what has none. test_catalogue.c fails for a case that has neither. */
#ifndef TESTS_PROPERTY_CATALOGUE_H
#define TESTS_PROPERTY_CATALOGUE_H

#include <stdio.h>

#include "property/row.h"

enum { CATALOGUE_FIRST = 1, CATALOGUE_LAST = 149 };

/* A hard case. */
struct catalogue_case {
    const char *what;
    /* Tests beside the rows, with spaces between: test_… is one of libcheck's, what has a slash is
     * a script. "" if there is none. */
    const char *tests;
    enum row_status status; /* ROW_PENDING: a feature, or the rest of the tests, is still to come */
    const char *why;        /* for what is not tested, or not all of it; NULL: nothing to say */
};

/* Case H0<number>, from CATALOGUE_FIRST to CATALOGUE_LAST. */
const struct catalogue_case *catalogue_case(int number);

/* Whether a row is of case H0<number>. */
bool catalogue_has(const struct row *row, int number);

/* "tested", "pending", "does not apply". */
const char *catalogue_status(const struct catalogue_case *c);

/* The catalogue as a table, for the three reports. */
void catalogue_markdown(FILE *f);
void catalogue_json(FILE *f);
void catalogue_html(FILE *f);

#endif
