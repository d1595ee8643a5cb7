/* SPDX-License-Identifier: MIT */
/* Declarations that the files db_postgres*.c share. */
#ifndef PEN_STORE_INTERNAL_POSTGRES_H
#define PEN_STORE_INTERNAL_POSTGRES_H

#include <libpq-fe.h>

#include "store/internal/engine.h"

enum {
    PEN_POSTGRES_STATEMENTS = 512, /* slots of a table by address; about 150 are used */
    PEN_POSTGRES_PENDING = 64      /* statements that may be sent before a result is read */
};

struct pen_postgres_rows {
    struct pen_rows base;
    const char *sql;  /* NULL: the slot is free */
    int64_t prepared; /* the connection that prepared it; 0: none */
    PGresult *result;
    int row;
};

/* A statement that was sent, and whose result has not been read. */
struct pen_postgres_sent {
    struct pen_postgres_rows *rows; /* NULL: a command without a slot */
    bool prepares, keeps;           /* keeps: its result is kept for its rows */
};

struct pen_postgres {
    struct pen_db base;
    char *url;
    PGconn *conn;       /* in pipeline mode; NULL: the connection was lost */
    int64_t connection; /* counts connections */
    int64_t again_ns;   /* when the next attempt to connect may begin */
    int64_t pause_ms;   /* pause after a failed attempt */
    char away[256];     /* why the last attempt failed */
    struct pen_postgres_rows statements[PEN_POSTGRES_STATEMENTS];
    struct pen_postgres_sent sent[PEN_POSTGRES_PENDING];
    int sent_count;
};

extern const struct pen_engine pen_postgres_engine;

/* Connects, and sets what each connection needs. Returns NULL if that failed; `text` then has
 * libpq's message without its end of line. */
PGconn *pen_postgres_connect(const char *url, char *text, size_t size);

/* Starts the thread of this process that receives signals of other processes and sends signals to
 * them. Does nothing if it runs already. The thread uses the database of the first call. */
void pen_postgres_listen(const char *url);

/* Lets this thread signal a change to other processes soon. It sends at most ten signals a second.
 * Without the thread, other processes look once a second. */
void pen_postgres_notify(void);

#endif
