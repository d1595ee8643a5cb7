/* SPDX-License-Identifier: MIT */
/* The file of a SQLite store, read or changed without the store's knowledge. */
#ifndef TESTS_SUPPORT_STORE_SQL_H
#define TESTS_SUPPORT_STORE_SQL_H

#include <stddef.h>

#include "support/store.h"

/* Runs one statement without results, with a blob (or NULL) for its first parameter. */
void store_run_sql(const struct store_bed *bed, const char *sql, const void *blob, size_t bytes);

/* Returns the result of a statement whose result is one number. */
int store_number(const char *file, const char *sql);

#endif
