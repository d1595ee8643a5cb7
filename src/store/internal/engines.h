/* SPDX-License-Identifier: MIT */
/* Opens and copies a database of each engine (db.h). */
#ifndef PEN_STORE_INTERNAL_ENGINES_H
#define PEN_STORE_INTERNAL_ENGINES_H

#include "store/db.h"

struct pen_db *pen_sqlite_open(const char *path, bool make, struct pen_status *st);
bool pen_sqlite_backup(const char *path, const char *file, bool replace, struct pen_backup *out,
                       struct pen_status *st);

/* Opens a PostgreSQL database.
 * Fails: PEN_STORAGE with what is wrong with the database and what to do about it. */
struct pen_db *pen_postgres_open(const char *url, bool make, struct pen_status *st);

#endif
