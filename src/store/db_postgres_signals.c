/* SPDX-License-Identifier: MIT */
/* Signals between the processes of all hosts. A thread of each process uses NOTIFY and LISTEN on
 * its own connection. A signal is only a hint: without signals, the thread lets this process look
 * once a second. */
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "store/internal/postgres.h"
#include "store/internal/signals.h"

enum { LOOK_MS = 1000, NOTIFY_MS = 100, PAUSE_MIN_MS = 250, PAUSE_MAX_MS = 5000 };

static pthread_once_t once = PTHREAD_ONCE_INIT;
static struct {
    char *url;
    int kick; /* an eventfd that wakes the thread */
    atomic_bool runs, wanted;
} notifier = {.kick = -1};

/* Receives until the connection is lost. */
static void serve(PGconn *conn)
{
    int64_t sent_ns = 0, looked_ns = pen_clock_ns();
    for (;;) {
        const int64_t now_ns = pen_clock_ns(), since_ms = (now_ns - sent_ns) / 1000000;
        const bool wanted = atomic_load(&notifier.wanted);
        if (wanted && since_ms >= NOTIFY_MS) {
            atomic_store(&notifier.wanted, false);
            PQclear(PQexec(conn, "NOTIFY penumbra"));
            sent_ns = now_ns;
        }
        if ((now_ns - looked_ns) / 1000000 >= LOOK_MS) {
            pen_signals_raise();
            looked_ns = now_ns;
        }
        struct pollfd polled[] = {{.fd = PQsocket(conn), .events = POLLIN},
                                  {.fd = notifier.kick, .events = POLLIN}};
        const bool waits = wanted && since_ms < NOTIFY_MS;
        poll(polled, waits ? 1 : 2, waits ? NOTIFY_MS - (int)since_ms : LOOK_MS);
        uint64_t value;
        if (polled[1].revents)
            (void)!read(notifier.kick, &value, sizeof value);
        if (PQconsumeInput(conn) != 1 || PQstatus(conn) != CONNECTION_OK)
            return;
        for (PGnotify *got; (got = PQnotifies(conn)) != NULL; PQfreemem(got)) {
            if (got->be_pid != PQbackendPID(conn))
                pen_signals_raise();
        }
    }
}

static void *run(void *unused)
{
    char text[256];
    for (int64_t pause_ms = PAUSE_MIN_MS;;
         pause_ms = 2 * pause_ms < PAUSE_MAX_MS ? 2 * pause_ms : PAUSE_MAX_MS) {
        PGconn *conn = pen_postgres_connect(notifier.url, text, sizeof text);
        PGresult *result = conn ? PQexec(conn, "LISTEN penumbra") : NULL;
        if (PQresultStatus(result) == PGRES_COMMAND_OK) {
            pause_ms = PAUSE_MIN_MS / 2;
            serve(conn);
        }
        PQclear(result);
        PQfinish(conn);
        pen_signals_raise();
        nanosleep(&(struct timespec){pause_ms / 1000, pause_ms % 1000 * 1000000}, NULL);
    }
    return unused;
}

/* The thread ends with the process. It blocks signals of the operating system, which other threads
 * handle. If it cannot start, a wait looks by itself. */
static void start_thread(void)
{
    pthread_t thread;
    sigset_t all, before;
    sigfillset(&all);
    notifier.kick = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    if (notifier.kick >= 0 && notifier.url && pthread_create(&thread, NULL, run, NULL) == 0) {
        pthread_detach(thread);
        atomic_store(&notifier.runs, true);
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

void pen_postgres_listen(const char *url)
{
    static atomic_flag named = ATOMIC_FLAG_INIT;
    if (!atomic_flag_test_and_set(&named))
        notifier.url = strdup(url);
    pthread_once(&once, start_thread);
}

void pen_postgres_notify(void)
{
    static const uint64_t one = 1;
    if (!atomic_load(&notifier.runs))
        return;
    atomic_store(&notifier.wanted, true);
    (void)!write(notifier.kick, &one, sizeof one);
}
