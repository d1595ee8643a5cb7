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

/* Starts it on a free port, with leases of `lease_ms`, and waits for its first line. */
bool daemon_start(struct daemon *daemon);

/* Starts a worker of its own beside it. */
pid_t daemon_extra_worker(const struct daemon *daemon);

/* The process id of its "api" or "work" child, 0 if there is none just now. */
pid_t daemon_child(const struct daemon *daemon, const char *role);

/* Kills it, and waits until its children are gone too. Returns false if they are not within 2 s. */
bool daemon_kill(struct daemon *daemon);

/* SIGTERM; waits for its end. Returns false unless it ended well, within 10 s, children too. */
bool daemon_drain(struct daemon *daemon);

/* Waits for the end of a process of ours, at most this long, then kills it. Returns whether it
 * ended by itself with exit code 0. */
bool process_end(pid_t pid, int ms);

/* How many processes run the program; zombies do not count. */
int daemon_processes(const struct daemon *daemon);

void pause_ms(int ms);

#endif
