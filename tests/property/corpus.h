/* SPDX-License-Identifier: MIT */
/* Stored cases: cases that failed once, and the worst cases found. They are in a sorted text file,
 * one case a line: the row's name, then its arguments. Fixed arguments are decimals, the others hex
 * floats. */
#ifndef TESTS_PROPERTY_CORPUS_H
#define TESTS_PROPERTY_CORPUS_H

#include "property/row.h"

enum { CORPUS_PER_ROW = 12, CORPUS_MAX = 2048 };

struct corpus_line {
    char name[ROW_NAME];
    struct row_case c;
};

struct corpus {
    int count;
    struct corpus_line line[CORPUS_MAX];
};

/* Reads a file; a missing file is an empty corpus. Returns the number of the first line that is no
 * case, or 0. */
int corpus_read(struct corpus *corpus, const char *path);

/* Returns case number i of a row; NULL after the last. */
const struct row_case *corpus_case(const struct corpus *corpus, const char *row, int i);

/* Adds a case, unless the corpus has it or the row has CORPUS_PER_ROW cases. */
void corpus_add(struct corpus *corpus, const char *row, const struct row_case *c);

/* Forgets the cases of a row. */
void corpus_drop(struct corpus *corpus, const char *row);

/* Writes the file, sorted. */
bool corpus_write(struct corpus *corpus, const char *path);

#endif
