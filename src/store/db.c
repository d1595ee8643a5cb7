/* SPDX-License-Identifier: MIT */
/* A connection (db.h): the part that all engines share, and the choice of the engine. */
#include <stdio.h>
#include <string.h>

#include "base/buf.h"
#include "base/clock.h"
#include "store/internal/counters.h"
#include "store/internal/engine.h"
#include "store/internal/engines.h"
#include "store/internal/schema.h"

bool pen_store_is_postgres(const char *url)
{
    return strncmp(url, "postgresql://", 13) == 0 || strncmp(url, "postgres://", 11) == 0;
}

bool pen_store_has_postgres(void)
{
#ifdef PEN_FARM
    return true;
#else
    return false;
#endif
}

/* Finds the end of a URL's user and password: the last "@" before its parameters. NULL: it has
 * neither. */
static const char *end_of_user(const char *url)
{
    return memrchr(url, '@', strcspn(url, "?"));
}

bool pen_store_has_password(const char *url)
{
    const char *end = end_of_user(url), *query = strchr(url, '?');
    return pen_store_is_postgres(url) &&
           ((end && memchr(strstr(url, "://") + 3, ':', (size_t)(end - strstr(url, "://") - 3))) ||
            (query && strstr(query, "password=")));
}

void pen_store_label(const char *url, char label[PEN_STORE_LABEL_BYTES])
{
    const char *end = pen_store_is_postgres(url) ? end_of_user(url) : NULL;
    const char *user = end ? strstr(url, "://") + 3 : url;
    const size_t shown = end ? (size_t)(user - url) + strcspn(user, ":@") : 0;
    const char *rest = end ? end : url;
    snprintf(label, PEN_STORE_LABEL_BYTES, "%.*s%.*s", (int)shown, url,
             (int)(pen_store_is_postgres(url) ? strcspn(rest, "?") : strlen(rest)), rest);
}

void pen_schema_write(const struct pen_word *words, struct pen_buf *out)
{
    const char *at = (const char *)pen_store_schema[0].data;
    while (*at) {
        const struct pen_word *word = words;
        while (word->word && strncmp(at, word->word, strlen(word->word)) != 0)
            word++;
        if (word->word)
            pen_buf_puts(out, word->text);
        else
            pen_buf_add(out, at, 1);
        at += word->word ? strlen(word->word) : 1;
    }
}

struct pen_db *pen_db_open(const char *url, bool make, struct pen_status *st)
{
    if (!pen_store_is_postgres(url))
        return pen_sqlite_open(url, make, st);
#ifdef PEN_FARM
    return pen_postgres_open(url, make, st);
#else
    pen_fail(st, PEN_UNSUPPORTED, "this build has no PostgreSQL: build it with make FARM=1");
    return NULL;
#endif
}

bool pen_db_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                   struct pen_status *st)
{
    if (pen_store_is_postgres(url))
        return pen_fail(st, PEN_UNSUPPORTED,
                        "a store in PostgreSQL is copied with PostgreSQL's own pg_basebackup or "
                        "pg_dump");
    return pen_sqlite_backup(url, file, replace, out, st);
}

void pen_db_close(struct pen_db *db)
{
    if (db)
        db->engine->close(db);
}

struct pen_db_trouble pen_db_trouble(const struct pen_db *db)
{
    return db->trouble;
}

bool pen_db_is_broken(const struct pen_db *db, struct pen_status *why)
{
    if (why)
        *why = db->broken;
    return db->broken.code != PEN_OK;
}

bool pen_db_begin(struct pen_db *db, enum pen_db_access access, struct pen_status *st)
{
    db->trouble = (struct pen_db_trouble){0};
    db->failed.code = PEN_OK;
    db->begun_ns = pen_clock_ns();
    db->access = access;
    db->in = db->engine->begin(db, access, st);
    return db->in;
}

bool pen_db_end(struct pen_db *db, bool ok, struct pen_status *st)
{
    if (!db->in)
        return false;
    if (db->failed.code != PEN_OK) {
        *st = db->failed;
        ok = false;
    }
    ok = db->engine->end(db, ok, st);
    db->in = false;
    pen_timing_add(db->access == PEN_DB_READ ? PEN_TIMING_READ : PEN_TIMING_WRITE,
                   (pen_clock_ns() - db->begun_ns) / 1000);
    return ok;
}

bool pen_db_failed(struct pen_db *db, const struct pen_status *st)
{
    if (db->in && db->failed.code == PEN_OK)
        db->failed = *st;
    return false;
}

static struct pen_rows *start(struct pen_db *db, struct pen_status *st, bool waits, const char *sql,
                              const char *types, va_list args)
{
    if (db->in && db->failed.code != PEN_OK) {
        *st = db->failed;
        return NULL;
    }
    if (!db->in)
        db->trouble = (struct pen_db_trouble){0};
    return db->engine->start(db, st, waits, sql, types, args);
}

struct pen_rows *pen_db_rows(struct pen_db *db, struct pen_status *st, const char *sql,
                             const char *types, ...)
{
    va_list args;
    va_start(args, types);
    struct pen_rows *rows = start(db, st, true, sql, types, args);
    va_end(args);
    return rows;
}

bool pen_db_run(struct pen_db *db, struct pen_status *st, int64_t *changed, const char *sql,
                const char *types, ...)
{
    va_list args;
    va_start(args, types);
    struct pen_rows *rows = start(db, st, changed != NULL, sql, types, args);
    va_end(args);
    while (pen_db_next(rows)) {
    }
    if (changed)
        *changed = rows && rows->ok ? db->engine->changed(rows) : 0;
    return pen_db_done(rows);
}

bool pen_db_value(struct pen_db *db, struct pen_status *st, int64_t *value, const char *sql,
                  const char *types, ...)
{
    va_list args;
    va_start(args, types);
    struct pen_rows *rows = start(db, st, true, sql, types, args);
    va_end(args);
    *value = pen_db_next(rows) ? pen_db_int(rows, 0) : 0;
    return pen_db_done(rows);
}

bool pen_db_next(struct pen_rows *rows)
{
    return rows && rows->ok && rows->db->engine->next(rows);
}

bool pen_db_done(struct pen_rows *rows)
{
    return rows && rows->db->engine->done(rows);
}

int64_t pen_db_int(struct pen_rows *rows, int column)
{
    return rows->db->engine->integer(rows, column);
}

const char *pen_db_text(struct pen_rows *rows, int column)
{
    return rows->db->engine->text(rows, column);
}

const void *pen_db_bytes(struct pen_rows *rows, int column, size_t *bytes)
{
    return rows->db->engine->bytes(rows, column, bytes);
}

bool pen_db_now(struct pen_db *db, int64_t *now_ms, struct pen_status *st)
{
    return db->engine->now(db, now_ms, st);
}

void pen_db_set_clock(struct pen_db *db, int64_t (*now_ms)(void *user), void *user)
{
    db->now_ms = now_ms;
    db->now_user = user;
}

void pen_db_wait(struct pen_db *db, uint32_t *seen, int timeout_ms)
{
    db->engine->wait(db, seen, timeout_ms);
}

void pen_db_wake(struct pen_db *db)
{
    db->engine->wake(db);
}

bool pen_db_space(struct pen_db *db, int64_t *used, int64_t *left, struct pen_status *st)
{
    return db->engine->space(db, used, left, st);
}

bool pen_db_give_reserve(struct pen_db *db)
{
    return db->engine->give_reserve && db->engine->give_reserve(db);
}

bool pen_db_maintain(struct pen_db *db, int64_t bytes, bool *more, struct pen_status *st)
{
    *more = false;
    return !db->engine->maintain || db->engine->maintain(db, bytes, more, st);
}

bool pen_db_check(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st)
{
    return db->engine->check(db, limit_ms, finished, st);
}
