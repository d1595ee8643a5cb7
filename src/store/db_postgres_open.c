/* SPDX-License-Identifier: MIT */
/* Opens a PostgreSQL database: connects, checks the server, makes the tables. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "base/log.h"
#include "store/internal/engines.h"
#include "store/internal/postgres.h"
#include "store/internal/schema.h"

enum { VERSION_MIN = 130000, LOCK = 0x50454e55 /* "PENU": for making the tables */ };

/* A stopped process holds a lock for at most 10 s. A statement waits for a lock for at most 5 s. */
static const char settings[] = "SET idle_in_transaction_session_timeout = 10000; "
                               "SET lock_timeout = 5000; SET statement_timeout = 60000; "
                               "SET client_min_messages = error";

static void copy_line(char *to, size_t size, const char *from)
{
    snprintf(to, size, "%.*s", (int)strcspn(from, "\n"), from);
}

/* libpq would print it. */
static void ignore_notice(void *unused, const char *text)
{
    (void)unused;
    (void)text;
}

PGconn *pen_postgres_connect(const char *url, char *text, size_t size)
{
    static const char *const names[] = {"fallback_application_name",
                                        "connect_timeout",
                                        "tcp_user_timeout",
                                        "keepalives_idle",
                                        "keepalives_interval",
                                        "keepalives_count",
                                        "client_encoding",
                                        "dbname",
                                        NULL};
    const char *const values[] = {"penumbrad", "5", "20000", "10", "5", "2", "UTF8", url, NULL};
    PGconn *conn = PQconnectdbParams(names, values, 1);
    PQsetNoticeProcessor(conn, ignore_notice, NULL);
    PGresult *result = PQstatus(conn) == CONNECTION_OK ? PQexec(conn, settings) : NULL;
    const bool ok = PQresultStatus(result) == PGRES_COMMAND_OK;
    PQclear(result);
    if (ok)
        return conn;
    copy_line(text, size, conn ? PQerrorMessage(conn) : "out of memory");
    PQfinish(conn);
    return NULL;
}

/* libpq gives the reason only as text. */
static bool fail_connect(const char *text, struct pen_status *st)
{
    static const struct {
        const char *found, *found_too, *advice;
    } advices[] = {
        {"database", "does not exist", "make it: createdb -E UTF8 NAME"},
        {"role", "does not exist", "make the user: createuser NAME"},
        {"password", "", "libpq takes it from PENUMBRA_STORE, PGPASSWORD, PGPASSFILE or ~/.pgpass"},
        {"no pg_hba.conf entry", "", "let the server's pg_hba.conf admit this user and host"},
        {"permission denied", "", "let the database's owner GRANT CONNECT to this user"},
        {"too many", "", "raise max_connections, or the user's limit (deploy/FARM.md)"},
        {"certificate", "", "see sslmode and sslrootcert in the store's URL (deploy/FARM.md)"},
        {"translate host name", "", "check the host's name in the store's URL"},
        {"accepting connections", "", "let its owner allow connections"},
        {"", "", "check the host and the port in the store's URL, and that PostgreSQL runs there"}};
    size_t i = 0;
    while (!strstr(text, advices[i].found) || !strstr(text, advices[i].found_too))
        i++;
    return pen_fail(st, PEN_STORAGE, "cannot connect to the database: %s; %s", text,
                    advices[i].advice);
}

static bool fail_sql(PGconn *conn, struct pen_status *st)
{
    char text[256];
    copy_line(text, sizeof text, PQerrorMessage(conn));
    return pen_fail(st, PEN_STORAGE, "the database: %s%s", text,
                    strstr(text, "denied for schema")
                        ? "; let its owner GRANT CREATE ON SCHEMA public TO this user"
                    : strstr(text, "denied") ? "; connect as the user that has made the tables"
                    : strstr(text, "already exists")
                        ? "; make a database for Penumbra alone, with createdb -E UTF8 NAME"
                        : "");
}

/* A password with unencoded special characters could appear in a message as a part of something
 * else. */
static bool check_url(const char *url, struct pen_status *st)
{
    char *error = NULL;
    PQconninfoOption *options = PQconninfoParse(url, &error);
    bool ok = options != NULL, split = pen_store_has_password(url);
    for (const PQconninfoOption *o = options; ok && o->keyword; o++)
        ok = strcmp(o->keyword, "host") != 0 || !o->val || !strchr(o->val, '@');
    if (!ok && split)
        pen_fail(st, PEN_STORAGE,
                 "the store's URL cannot be read: write %%, @, / and : of the password as %%25, "
                 "%%40, %%2F and %%3A");
    else if (!ok)
        pen_fail(st, PEN_STORAGE,
                 "the store's URL cannot be read: %.*s; write postgresql://USER@HOST/DATABASE",
                 error ? (int)strcspn(error, "\n") : 0, error ? error : "");
    PQconninfoFree(options);
    PQfreemem(error);
    return ok;
}

/* Finds out whether two connections share a server process, as behind a pooler in transaction
 * mode. */
static bool check_pooler(const char *url, PGconn *conn, int pid, struct pen_status *st)
{
    static const char sql[] = "SELECT pg_backend_pid()";
    char text[256];
    if (pid == PQbackendPID(conn))
        return true;
    PGconn *other = pen_postgres_connect(url, text, sizeof text);
    if (!other)
        return fail_connect(text, st);
    PGresult *first = PQexec(conn, sql), *second = PQexec(other, sql);
    const bool same = PQntuples(first) == 1 && PQntuples(second) == 1 &&
                      strcmp(PQgetvalue(first, 0, 0), PQgetvalue(second, 0, 0)) == 0;
    PQclear(first);
    PQclear(second);
    PQfinish(other);
    return !same ||
           pen_fail(st, PEN_STORAGE,
                    "the database is behind a pooler in transaction mode: connect to PostgreSQL "
                    "itself, or let the pooler use session mode");
}

/* Checks the server; with `warns`, logs risky settings. *tables: the store's tables exist. */
static bool check_server(const char *url, PGconn *conn, bool warns, bool *tables,
                         struct pen_status *st)
{
    PGresult *result =
        PQexec(conn, "SELECT current_setting('server_version_num'), pg_is_in_recovery(), "
                     "getdatabaseencoding(), current_setting('fsync'), "
                     "current_setting('synchronous_commit'), to_regclass('meta') IS NOT NULL, "
                     "pg_backend_pid(), current_setting('server_version')");
    if (PQntuples(result) != 1) {
        PQclear(result);
        return fail_sql(conn, st);
    }
    const int version = atoi(PQgetvalue(result, 0, 0)), pid = atoi(PQgetvalue(result, 0, 6));
    bool ok = true;
    *tables = PQgetvalue(result, 0, 5)[0] == 't';
    if (version < VERSION_MIN)
        ok = pen_fail(st, PEN_STORAGE, "PostgreSQL %s is too old: the store needs version 13",
                      PQgetvalue(result, 0, 7));
    else if (PQgetvalue(result, 0, 1)[0] == 't')
        ok = pen_fail(st, PEN_STORAGE,
                      "the database is a standby, which only reads: connect to the primary, or add "
                      "target_session_attrs=read-write to the URL");
    else if (strcmp(PQgetvalue(result, 0, 2), "UTF8") != 0)
        ok = pen_fail(st, PEN_STORAGE,
                      "the database has the encoding %s, the store needs UTF8: make another one "
                      "with createdb -E UTF8 -T template0 NAME",
                      PQgetvalue(result, 0, 2));
    else if (warns && (strcmp(PQgetvalue(result, 0, 3), "off") == 0 ||
                       strcmp(PQgetvalue(result, 0, 4), "off") == 0))
        pen_log(PEN_LOG_WARN,
                "the database has fsync or synchronous_commit off: a power failure may lose jobs");
    PQclear(result);
    return ok && check_pooler(url, conn, pid, st);
}

/* The statements that schema.sql lacks for PostgreSQL. Rows of `batch` and `job` change often, and
 * values are already compressed. now_ms() is the server's clock; tests set another one. */
static const char more_schema[] =
    "ALTER TABLE batch SET (fillfactor = 70, autovacuum_vacuum_scale_factor = 0, "
    "autovacuum_vacuum_threshold = 1000);"
    "ALTER TABLE job SET (fillfactor = 70, autovacuum_vacuum_scale_factor = 0, "
    "autovacuum_vacuum_threshold = 1000);"
    "ALTER TABLE object SET (autovacuum_vacuum_scale_factor = 0, "
    "autovacuum_vacuum_threshold = 1000);"
    "ALTER TABLE part SET (autovacuum_vacuum_scale_factor = 0, "
    "autovacuum_vacuum_threshold = 1000, toast.autovacuum_vacuum_scale_factor = 0, "
    "toast.autovacuum_vacuum_threshold = 4000);"
    "ALTER TABLE part ALTER COLUMN data SET STORAGE EXTERNAL;"
    "CREATE FUNCTION now_ms() RETURNS BIGINT LANGUAGE SQL AS $$ SELECT coalesce("
    "CAST(nullif(current_setting('penumbra.now_ms', true), '') AS BIGINT), "
    "CAST(floor(extract(epoch FROM clock_timestamp()) * 1000) AS BIGINT)) $$;";

static const struct pen_word words[] = {
    {"{identity}", "BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY"},
    {"{bytes}", "BYTEA"},
    {"{table options}", ""},
    {NULL, NULL}};

/* Runs statements without parameters. *answer (may be NULL) is true if the first value of the last
 * statement is true. */
static bool run(PGconn *conn, const char *sql, bool *answer, struct pen_status *st)
{
    PGresult *result = PQexec(conn, sql);
    const ExecStatusType status = PQresultStatus(result);
    const bool ok = status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
    if (answer)
        *answer = ok && PQntuples(result) == 1 && PQgetvalue(result, 0, 0)[0] == 't';
    PQclear(result);
    return ok || fail_sql(conn, st);
}

/* Reads a catalogue table, because to_regclass() may miss tables that another process has just
 * made. */
static const char there_sql[] = "SELECT EXISTS (SELECT 1 FROM pg_tables WHERE tablename = 'meta' "
                                "AND schemaname = current_schema())";

/* Makes the tables, unless another process has made them meanwhile. */
static bool make_tables(PGconn *conn, struct pen_status *st)
{
    struct pen_buf text = {0};
    bool there;
    char lock[64];
    snprintf(lock, sizeof lock, "BEGIN; SELECT pg_advisory_xact_lock(%d)", LOCK);
    pen_schema_write(words, &text);
    pen_buf_printf(&text,
                   "%s INSERT INTO meta (name, value) VALUES ('schema_version', '%d'); COMMIT",
                   more_schema, PEN_SCHEMA_VERSION);
    bool ok = (!text.failed || pen_fail(st, PEN_NO_MEMORY, "no memory for the store's tables")) &&
              run(conn, lock, NULL, st) && run(conn, there_sql, &there, st) &&
              run(conn, there ? "COMMIT" : (const char *)text.data, NULL, st);
    pen_buf_release(&text);
    return ok;
}

static bool check_version(PGconn *conn, struct pen_status *st)
{
    PGresult *result = PQexec(conn, "SELECT value FROM meta WHERE name = 'schema_version'");
    const char *state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
    const bool denied = state && strcmp(state, "42501") == 0;
    const int version = PQntuples(result) == 1 ? atoi(PQgetvalue(result, 0, 0)) : 0;
    PQclear(result);
    if (denied)
        return fail_sql(conn, st);
    if (version == 0)
        return pen_fail(st, PEN_STORAGE,
                        "the database has tables of another program: make one "
                        "for Penumbra alone, with createdb -E UTF8 NAME");
    return version == PEN_SCHEMA_VERSION ||
           pen_fail(st, PEN_STORAGE,
                    "the database has a store of version %d; this build reads version %d alone",
                    version, PEN_SCHEMA_VERSION);
}

static bool prepare(const char *url, PGconn *conn, bool make, struct pen_status *st)
{
    bool tables = false;
    if (!check_server(url, conn, make, &tables, st))
        return false;
    if (!tables && !make)
        return pen_fail(st, PEN_NOT_FOUND, "the database has no store yet");
    return (tables || make_tables(conn, st)) && check_version(conn, st);
}

struct pen_db *pen_postgres_open(const char *url, bool make, struct pen_status *st)
{
    struct pen_postgres *pg = calloc(1, sizeof *pg);
    char text[256] = "";
    if (!pg || !(pg->url = strdup(url))) {
        free(pg);
        pen_fail(st, PEN_NO_MEMORY, "no memory for a store");
        return NULL;
    }
    pg->base.engine = &pen_postgres_engine;
    pg->connection = 1;
    pg->conn = check_url(url, st) ? pen_postgres_connect(url, text, sizeof text) : NULL;
    if (pg->conn ? prepare(url, pg->conn, make, st) && PQenterPipelineMode(pg->conn)
                 : text[0] && fail_connect(text, st)) {
        if (!make) /* not in a process that ends soon, or whose children listen */
            pen_postgres_listen(url);
        return &pg->base;
    }
    pen_db_close(&pg->base);
    return NULL;
}
