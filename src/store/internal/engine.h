/* SPDX-License-Identifier: MIT */
/* The part of db.h that an engine implements. A connection of an engine begins with a struct
 * pen_db, and its statements begin with a struct pen_rows. */
#ifndef PEN_STORE_INTERNAL_ENGINE_H
#define PEN_STORE_INTERNAL_ENGINE_H

#include <stdarg.h>

#include "store/db.h"

struct pen_engine {
    void (*close)(struct pen_db *db);
    bool (*begin)(struct pen_db *db, enum pen_db_access access, struct pen_status *st);
    bool (*end)(struct pen_db *db, bool ok, struct pen_status *st);
    /* `waits`: the caller needs the rows or their number. */
    struct pen_rows *(*start)(struct pen_db *db, struct pen_status *st, bool waits, const char *sql,
                              const char *types, va_list args);
    bool (*next)(struct pen_rows *rows);
    bool (*done)(struct pen_rows *rows);
    int64_t (*changed)(struct pen_rows *rows);
    int64_t (*integer)(struct pen_rows *rows, int column);
    const char *(*text)(struct pen_rows *rows, int column);
    const void *(*bytes)(struct pen_rows *rows, int column, size_t *bytes);
    bool (*now)(struct pen_db *db, int64_t *now_ms, struct pen_status *st);
    void (*wait)(struct pen_db *db, uint32_t *seen, int timeout_ms);
    void (*wake)(struct pen_db *db);
    bool (*space)(struct pen_db *db, int64_t *used, int64_t *left, struct pen_status *st);
    bool (*give_reserve)(struct pen_db *db); /* NULL: there is no reserve */
    /* NULL: the database does it by itself. */
    bool (*maintain)(struct pen_db *db, int64_t bytes, bool *more, struct pen_status *st);
    bool (*check)(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st);
};

struct pen_db {
    const struct pen_engine *engine;
    bool in; /* a transaction has begun */
    enum pen_db_access access;
    int64_t begun_ns;         /* when the transaction began */
    struct pen_status failed; /* the first failed call of the transaction */
    struct pen_db_trouble trouble;
    struct pen_status broken;      /* the first I/O error or damage; code PEN_OK: there was none */
    int64_t (*now_ms)(void *user); /* NULL: the store's own clock */
    void *now_user;
};

struct pen_rows {
    struct pen_db *db;
    struct pen_status *st;
    bool ok;
};

/* Notes the failure of a call within a transaction; later calls fail with the same status. Returns
 * false. */
bool pen_db_failed(struct pen_db *db, const struct pen_status *st);

#endif
