/* SPDX-License-Identifier: MIT */
/* The file of a store in SQLite, changed behind the store's back. */
#ifndef TESTS_SUPPORT_STORE_SQL_H
#define TESTS_SUPPORT_STORE_SQL_H

#include <stddef.h>

#include "support/store.h"

/* Runs one statement without results, with a blob (or NULL) for its first parameter. */
void store_run_sql(const struct store_bed *bed, const char *sql, const void *blob, size_t bytes);

#endif
