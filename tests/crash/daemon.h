/* SPDX-License-Identifier: MIT */
/* The daemon under test and its processes. */
#ifndef TESTS_CRASH_DAEMON_H
#define TESTS_CRASH_DAEMON_H

#include <stdatomic.h>
#include <stdbool.h>
#include <sys/types.h>

struct daemon {
    const char *program, *store, *log; /* paths */
    pid_t pid;                         /* 0: not running */
    atomic_int port;
};

/* The number of ended jobs that the daemon keeps. It also accepts X-Forwarded-For. */
enum { DAEMON_KEEP_JOBS = 8 };

/* Returns the factor for waiting times: builds with sanitizers are slow. */
int daemon_patience(void);

/* Starts the daemon on a free port and waits for its first line. Returns true if this line has
 * come. */
bool daemon_start(struct daemon *daemon);

/* Starts a supervisor of one more worker on the same store. daemon_child and daemon_kill also
 * accept its `pid`. */
struct daemon daemon_extra_worker(const struct daemon *daemon);

/* Waits until this supervisor waits for SIGTERM, which would end it at once before. Waits at most
 * 10 s times the patience. */
void daemon_wait_for_worker(pid_t pid);

/* Prints the last lines of the log of all processes. */
void daemon_show_log(const struct daemon *daemon);

/* Returns the process id of the "api" or "work" child; 0 if there is none now. */
pid_t daemon_child(const struct daemon *daemon, const char *role);

/* Kills the supervisor, and waits for the end of its children. Returns false after 15 s. */
bool daemon_kill(struct daemon *daemon);

/* Sends SIGTERM and waits. Returns true if the daemon and its children have ended in time, the
 * daemon with exit code 0. They have 10 s, plus the time for which processes are stopped. */
bool daemon_drain(struct daemon *daemon);

/* The number of processes that run the daemon on this store, without zombies. */
int daemon_processes(const struct daemon *daemon);

/* Reaps zombies that this process has inherited from killed processes, except `kept`. */
void daemon_reap_others(pid_t kept);

void pause_ms(int ms);

#endif
