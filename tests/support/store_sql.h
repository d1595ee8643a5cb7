/* SPDX-License-Identifier: MIT */
/* The file of a store in SQLite, changed behind the store's back. */
#ifndef TESTS_SUPPORT_STORE_SQL_H
#define TESTS_SUPPORT_STORE_SQL_H

#include <stddef.h>

#include "support/store.h"

/* Runs one statement without results, with a blob (or NULL) for its first parameter. */
void store_run_sql(const struct store_bed *bed, const char *sql, const void *blob, size_t bytes);

/* Takes the file of a store, which no handle has open, back to an earlier schema. */
void store_downgrade(const char *file, int version);

/* The version of its schema. */
int store_schema_version(const char *file);

#endif
