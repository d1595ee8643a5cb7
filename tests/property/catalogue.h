/* SPDX-License-Identifier: MIT */
/* The catalogue of hard cases H001 to H149: what each is, and where it is tested. Rows of the suite
 * name their cases themselves (struct row, id). Here are the tests elsewhere, and the reasons for
 * cases without a test. test_catalogue.c fails for a case that has neither. */
#ifndef TESTS_PROPERTY_CATALOGUE_H
#define TESTS_PROPERTY_CATALOGUE_H

#include <stdio.h>

#include "property/row.h"

enum { CATALOGUE_FIRST = 1, CATALOGUE_LAST = 149 };

/* A hard case. */
struct catalogue_case {
    const char *what;
    /* Tests besides the rows, with spaces between them: test_… is a libcheck test, a name with a
     * slash is a script. "" if there is none. */
    const char *tests;
    enum row_status status; /* ROW_PENDING: a feature, or the rest of the tests, is still missing */
    const char *why;        /* for a case that is not tested, or not completely; NULL: no remark */
};

/* Returns case H0<number>, from CATALOGUE_FIRST to CATALOGUE_LAST. */
const struct catalogue_case *catalogue_case(int number);

/* Returns true if a row is of case H0<number>. */
bool catalogue_has(const struct row *row, int number);

/* "tested", "pending", "does not apply". */
const char *catalogue_status(const struct catalogue_case *c);

/* Writes the catalogue as a table, for the three reports. */
void catalogue_markdown(FILE *f);
void catalogue_json(FILE *f);
void catalogue_html(FILE *f);

#endif
