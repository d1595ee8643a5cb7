/* SPDX-License-Identifier: MIT */
/* A connection to PostgreSQL (db.h). A connection prepares each statement once and sends statements
 * in pipeline mode. Within a transaction it does not wait for a statement whose result nobody
 * needs; if such a statement fails, a later call fails. After a lost connection, the next
 * transaction connects again. */
#include <endian.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "store/internal/postgres.h"
#include "store/internal/signals.h"

enum {
    PARAMETERS = 16,
    TEXT_BYTES = 8192,
    PAUSE_MIN_MS = 250,
    PAUSE_MAX_MS = 5000,
    INT8 = 20, /* object ids of types (PostgreSQL's pg_type.dat) */
    BYTEA = 17,
    TEXT = 25
};

static struct pen_postgres *of(struct pen_db *db)
{
    return (struct pen_postgres *)db;
}

static bool fail(struct pen_postgres *pg, enum pen_code code, enum pen_failure failure,
                 const char *text, struct pen_status *st)
{
    pg->base.trouble = (struct pen_db_trouble){.code = code, .failure = failure};
    pen_fail(st, code, "the database: %.*s", (int)strcspn(text, "\n"), text);
    return pen_db_failed(&pg->base, st);
}

/* The transaction is rolled back, unless the connection was lost while it was being committed. */
static bool fail_connection(struct pen_postgres *pg, bool commits, struct pen_status *st)
{
    char text[256];
    snprintf(text, sizeof text, "%s", PQerrorMessage(pg->conn));
    PQfinish(pg->conn);
    pg->conn = NULL;
    pg->sent_count = 0;
    return fail(pg, PEN_UNAVAILABLE, commits ? PEN_FAILURE_UNKNOWN : PEN_FAILURE_RETRY,
                text[0] ? text : "the connection was lost", st);
}

/* Classifies an error by its SQLSTATE. Errors that may pass can be retried. */
static bool fail_result(struct pen_postgres *pg, const PGresult *result, struct pen_status *st)
{
    static const struct {
        const char *state; /* or its beginning */
        enum pen_code code;
    } codes[] = {{"40", PEN_UNAVAILABLE},     /* deadlock, serialization */
                 {"55", PEN_UNAVAILABLE},     /* a lock was not available in time */
                 {"57", PEN_UNAVAILABLE},     /* cancelled, shut down */
                 {"25P03", PEN_UNAVAILABLE},  /* idle in a transaction for too long */
                 {"25006", PEN_UNAVAILABLE},  /* read only: a standby */
                 {"23505", PEN_UNAVAILABLE},  /* another transaction has just added this row */
                 {"08", PEN_UNAVAILABLE},     /* connection */
                 {"53100", PEN_STORAGE_FULL}, /* disk full */
                 {"53200", PEN_NO_MEMORY},    {"53", PEN_UNAVAILABLE}, /* too many connections */
                 {"58", PEN_STORAGE},                                  /* I/O error */
                 {"XX", PEN_STORAGE}};                                 /* damage */
    const char *state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
    const char *text = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
    enum pen_code code = state ? PEN_INTERNAL : PEN_UNAVAILABLE;
    for (size_t i = 0; state && i < sizeof codes / sizeof *codes; i++) {
        if (strncmp(state, codes[i].state, strlen(codes[i].state)) == 0) {
            code = codes[i].code;
            break;
        }
    }
    return fail(pg, code,
                code == PEN_INTERNAL || code == PEN_STORAGE ? PEN_FAILURE_REFUSED
                                                            : PEN_FAILURE_RETRY,
                text ? text : PQresultErrorMessage(result), st);
}

/* Connects again if the connection was lost, after a pause that doubles with each failure. */
static bool connect_again(struct pen_postgres *pg, struct pen_status *st)
{
    if (pg->conn)
        return true;
    if (pen_clock_ns() >= pg->again_ns) {
        pg->conn = pen_postgres_connect(pg->url, pg->away, sizeof pg->away);
        if (pg->conn)
            PQenterPipelineMode(pg->conn);
        pg->connection++;
        pg->pause_ms = pg->conn ? 0 : pg->pause_ms == 0 ? PAUSE_MIN_MS : 2 * pg->pause_ms;
        pg->pause_ms = pg->pause_ms < PAUSE_MAX_MS ? pg->pause_ms : PAUSE_MAX_MS;
        pg->again_ns = pen_clock_ns() + pg->pause_ms * 1000000;
    }
    return pg->conn || fail(pg, PEN_UNAVAILABLE, PEN_FAILURE_RETRY, pg->away, st);
}

/* Takes the result of one statement; false: the connection is lost. */
static bool take(struct pen_postgres *pg, const struct pen_postgres_sent *sent, PGresult **error)
{
    PGresult *result = PQgetResult(pg->conn), *end;
    if (!result)
        return false;
    const ExecStatusType status = PQresultStatus(result);
    const bool ok = status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
    if (!ok && sent->prepares)
        sent->rows->prepared = 0;
    if (ok && sent->keeps)
        sent->rows->result = result;
    else if (status == PGRES_FATAL_ERROR && !*error)
        *error = result;
    else
        PQclear(result);
    while ((end = PQgetResult(pg->conn)) != NULL) /* NULL ends a statement's results */
        PQclear(end);
    return PQstatus(pg->conn) == CONNECTION_OK;
}

/* Reads the results of all sent statements. Fails with the first error among them. */
static bool receive(struct pen_postgres *pg, bool commits, struct pen_status *st)
{
    PGresult *error = NULL;
    bool there = PQpipelineSync(pg->conn) == 1;
    for (int i = 0; there && i < pg->sent_count; i++)
        there = take(pg, &pg->sent[i], &error);
    pg->sent_count = 0;
    PGresult *sync = there ? PQgetResult(pg->conn) : NULL;
    there = there && PQresultStatus(sync) == PGRES_PIPELINE_SYNC;
    PQclear(sync);
    const bool ok = there && !error;
    if (!there)
        fail_connection(pg, commits, st);
    else if (error)
        fail_result(pg, error, st);
    PQclear(error);
    return ok;
}

/* Makes room for two statements more. */
static bool make_room(struct pen_postgres *pg, struct pen_status *st)
{
    return pg->sent_count + 2 <= PEN_POSTGRES_PENDING || receive(pg, false, st);
}

static bool send_command(struct pen_postgres *pg, const char *sql, struct pen_status *st)
{
    if (!make_room(pg, st))
        return false;
    if (PQsendQueryParams(pg->conn, sql, 0, NULL, NULL, NULL, NULL, 1) != 1)
        return fail_connection(pg, false, st);
    pg->sent[pg->sent_count++] = (struct pen_postgres_sent){0};
    return true;
}

/* Tests set another clock, which now_ms() reads from a setting of the connection. */
static bool send_clock(struct pen_postgres *pg, struct pen_status *st)
{
    char sql[96];
    if (!pg->base.now_ms)
        return true;
    snprintf(sql, sizeof sql, "SELECT set_config('penumbra.now_ms', '%lld', false)",
             (long long)pg->base.now_ms(pg->base.now_user));
    return send_command(pg, sql, st);
}

static bool begin(struct pen_db *db, enum pen_db_access access, struct pen_status *st)
{
    struct pen_postgres *pg = of(db);
    return connect_again(pg, st) &&
           send_command(pg,
                        access == PEN_DB_READ ? "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY"
                                              : "BEGIN ISOLATION LEVEL READ COMMITTED",
                        st) &&
           send_clock(pg, st) &&
           (access != PEN_DB_PART || send_command(pg, "SET LOCAL synchronous_commit = off", st));
}

static bool end(struct pen_db *db, bool ok, struct pen_status *st)
{
    struct pen_postgres *pg = of(db);
    struct pen_status ignored;
    if (ok && send_command(pg, "COMMIT", st) && receive(pg, db->access != PEN_DB_READ, st))
        return true;
    const struct pen_db_trouble trouble = db->trouble;
    if (pg->conn && send_command(pg, "ROLLBACK", &ignored))
        receive(pg, false, &ignored);
    db->trouble = trouble;
    return false;
}

/* Returns the text with PostgreSQL's words in place of the words in braces. */
static const char *substitute(const char *sql, char text[TEXT_BYTES])
{
    static const char word[] = "{skip_locked}", with[] = "FOR UPDATE SKIP LOCKED";
    size_t used = 0;
    for (const char *at; (at = strstr(sql, word)) != NULL; sql = at + sizeof word - 1)
        used +=
            (size_t)snprintf(text + used, TEXT_BYTES - used, "%.*s%s", (int)(at - sql), sql, with);
    snprintf(text + used, TEXT_BYTES - used, "%s", sql);
    return text;
}

static struct pen_postgres_rows *find(struct pen_postgres *pg, const char *sql)
{
    const size_t first = ((uintptr_t)sql >> 4) % PEN_POSTGRES_STATEMENTS;
    for (size_t i = 0; i < PEN_POSTGRES_STATEMENTS; i++) {
        struct pen_postgres_rows *rows = &pg->statements[(first + i) % PEN_POSTGRES_STATEMENTS];
        if (!rows->sql)
            rows->sql = sql;
        if (rows->sql == sql)
            return rows;
    }
    return NULL;
}

static void name_of(const struct pen_postgres *pg, const struct pen_postgres_rows *rows,
                    char name[16])
{
    snprintf(name, 16, "s%d", (int)(rows - pg->statements));
}

static bool send_prepare(struct pen_postgres *pg, struct pen_postgres_rows *rows, const char *types,
                         struct pen_status *st)
{
    char text[TEXT_BYTES], name[16];
    Oid oids[PARAMETERS];
    int count = 0;
    if (rows->prepared == pg->connection)
        return true;
    for (; types[count]; count++)
        oids[count] = types[count] == 'i' ? INT8 : types[count] == 't' ? TEXT : BYTEA;
    name_of(pg, rows, name);
    if (PQsendPrepare(pg->conn, name, substitute(rows->sql, text), count, oids) != 1)
        return fail_connection(pg, false, st);
    pg->sent[pg->sent_count++] = (struct pen_postgres_sent){.rows = rows, .prepares = true};
    rows->prepared = pg->connection;
    return true;
}

static bool send_statement(struct pen_postgres *pg, struct pen_postgres_rows *rows, bool keeps,
                           const char *types, va_list args, struct pen_status *st)
{
    const char *values[PARAMETERS];
    int lengths[PARAMETERS], formats[PARAMETERS], count = 0;
    int64_t numbers[PARAMETERS];
    char name[16];
    for (; types[count]; count++) {
        formats[count] = 1;
        if (types[count] == 'i') {
            numbers[count] = (int64_t)htobe64((uint64_t)va_arg(args, int64_t));
            values[count] = (const char *)&numbers[count];
            lengths[count] = sizeof numbers[count];
        } else {
            values[count] = va_arg(args, const char *);
            lengths[count] = types[count] == 'b'     ? (int)va_arg(args, size_t)
                             : values[count] != NULL ? (int)strlen(values[count])
                                                     : 0;
        }
    }
    name_of(pg, rows, name);
    if (PQsendQueryPrepared(pg->conn, name, count, values, lengths, formats, 1) != 1)
        return fail_connection(pg, false, st);
    pg->sent[pg->sent_count++] = (struct pen_postgres_sent){.rows = rows, .keeps = keeps};
    return true;
}

static struct pen_rows *start(struct pen_db *db, struct pen_status *st, bool waits, const char *sql,
                              const char *types, va_list args)
{
    struct pen_postgres *pg = of(db);
    struct pen_postgres_rows *rows = find(pg, sql);
    if (!rows) {
        pen_fail(st, PEN_INTERNAL, "more than %d statements", PEN_POSTGRES_STATEMENTS);
        return NULL;
    }
    PQclear(rows->result);
    rows->result = NULL;
    rows->row = -1;
    rows->base = (struct pen_rows){.db = db, .st = st, .ok = true};
    waits = waits || !db->in;
    return (db->in || (connect_again(pg, st) && send_clock(pg, st))) && make_room(pg, st) &&
                   send_prepare(pg, rows, types, st) &&
                   send_statement(pg, rows, waits, types, args, st) &&
                   (!waits || receive(pg, false, st))
               ? &rows->base
               : NULL;
}

static bool next(struct pen_rows *base)
{
    struct pen_postgres_rows *rows = (struct pen_postgres_rows *)base;
    return rows->result && ++rows->row < PQntuples(rows->result);
}

static bool done(struct pen_rows *base)
{
    struct pen_postgres_rows *rows = (struct pen_postgres_rows *)base;
    PQclear(rows->result);
    rows->result = NULL;
    return base->ok;
}

static int64_t changed(struct pen_rows *base)
{
    const struct pen_postgres_rows *rows = (struct pen_postgres_rows *)base;
    return strtoll(PQcmdTuples(rows->result), NULL, 10);
}

/* Integers have four or eight bytes, the highest first. */
static int64_t integer(struct pen_rows *base, int column)
{
    const struct pen_postgres_rows *rows = (struct pen_postgres_rows *)base;
    const char *at = PQgetvalue(rows->result, rows->row, column);
    uint64_t eight;
    uint32_t four;
    if (PQgetisnull(rows->result, rows->row, column))
        return 0;
    if (PQgetlength(rows->result, rows->row, column) == (int)sizeof eight) {
        memcpy(&eight, at, sizeof eight);
        return (int64_t)be64toh(eight);
    }
    memcpy(&four, at, sizeof four);
    return (int32_t)be32toh(four);
}

static const char *text(struct pen_rows *base, int column)
{
    const struct pen_postgres_rows *rows = (struct pen_postgres_rows *)base;
    return PQgetisnull(rows->result, rows->row, column)
               ? NULL
               : PQgetvalue(rows->result, rows->row, column);
}

static const void *bytes(struct pen_rows *base, int column, size_t *size)
{
    const struct pen_postgres_rows *rows = (struct pen_postgres_rows *)base;
    *size = (size_t)PQgetlength(rows->result, rows->row, column);
    return text(base, column);
}

static bool now(struct pen_db *db, int64_t *now_ms, struct pen_status *st)
{
    if (!db->now_ms)
        return pen_db_value(db, st, now_ms, "SELECT now_ms()", "");
    *now_ms = db->now_ms(db->now_user);
    return true;
}

/* The file of a table does not shrink. So the sum of the stored values is taken, plus the size of
 * empty tables with their indexes. */
static bool space(struct pen_db *db, int64_t *used, int64_t *left, struct pen_status *st)
{
    *left = INT64_MAX;
    return !used ||
           pen_db_value(db, st, used,
                        "SELECT CAST(coalesce(sum(bytes), 0) + 327680 AS BIGINT) FROM object", "");
}

/* Nothing is checked when the store is opened: PostgreSQL finds damage when it reads. */
static bool check(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st)
{
    (void)db;
    *finished = true;
    return limit_ms > 0 || pen_fail(st, PEN_UNSUPPORTED,
                                    "a store in PostgreSQL is checked with PostgreSQL's own "
                                    "pg_amcheck");
}

static void close_connection(struct pen_db *db)
{
    struct pen_postgres *pg = of(db);
    for (int i = 0; i < PEN_POSTGRES_STATEMENTS; i++)
        PQclear(pg->statements[i].result);
    PQfinish(pg->conn);
    free(pg->url);
    free(pg);
}

static void wait_change(struct pen_db *db, uint32_t *seen, int timeout_ms)
{
    pen_postgres_listen(of(db)->url);
    pen_signals_wait(seen, timeout_ms);
}

static void wake(struct pen_db *db)
{
    (void)db;
    pen_signals_raise();
    pen_postgres_notify();
}

const struct pen_engine pen_postgres_engine = {.close = close_connection,
                                               .begin = begin,
                                               .end = end,
                                               .start = start,
                                               .next = next,
                                               .done = done,
                                               .changed = changed,
                                               .integer = integer,
                                               .text = text,
                                               .bytes = bytes,
                                               .now = now,
                                               .wait = wait_change,
                                               .wake = wake,
                                               .space = space,
                                               .check = check};
