/* SPDX-License-Identifier: MIT */
/* What retention.c and its neighbours share. All within a transaction. */
#ifndef PEN_STORE_INTERNAL_RETENTION_H
#define PEN_STORE_INTERNAL_RETENTION_H

#include "store/internal/handle.h"

/* A number by its name in `meta`; 0: there is none. */
bool pen_meta_get(struct pen_store *store, const char *name, int64_t *value, struct pen_status *st);
bool pen_meta_set(struct pen_store *store, const char *name, int64_t value, struct pen_status *st);

/* A text in `meta`. */
bool pen_meta_put(struct pen_store *store, const char *name, const char *text,
                  struct pen_status *st);

/* Fails with PEN_STORAGE_FULL if keep_bytes does not allow so many bytes that a batch keeps. */
bool pen_admit_kept(struct pen_store *store, int64_t bytes, struct pen_status *st);

/* Whether removal by age waits, because the clock has jumped ahead. */
bool pen_ages_wait(struct pen_store *store, int64_t now_ms, bool *wait, struct pen_status *st);

#endif
