/* SPDX-License-Identifier: MIT */
/* Rows of a store that tests read, and that the interface does not show. */
#ifndef TESTS_SUPPORT_STORE_ROWS_H
#define TESTS_SUPPORT_STORE_ROWS_H

#include "store/store.h"

struct store_batch {
    int64_t number, pixels;
    enum pen_batch_kind kind;
    enum pen_batch_state state;
    int view, first_tile, tile_count;
    bool alone; /* quarantined */
};

/* Reads at most `most` batches of a job, by view and first tile; returns their number. */
int store_batches(const char *url, const char *id, struct store_batch *batch, int most);

/* Returns the result of a statement whose result is one number. */
int64_t store_value(const char *url, const char *sql);

/* Runs a statement without results, with a blob (or NULL) for $1. */
void store_change(const char *url, const char *sql, const void *blob, size_t bytes);

/* Looks for contradictions between rows: missing owners, states that exclude each other, wrong
 * sums. Prints each; returns their number. */
int store_contradictions(const char *url);

#endif
