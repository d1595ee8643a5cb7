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

/* The ended jobs that the daemon keeps. It also takes X-Forwarded-For. */
enum { DAEMON_KEEP_JOBS = 8 };

/* How many times as long as usual to wait: builds with sanitizers are slow. */
int daemon_patience(void);

/* Starts the daemon on a free port and waits for its first line. Returns whether that has come. */
bool daemon_start(struct daemon *daemon);

/* Starts a supervisor of one more worker on the same store. Its `pid` is also what daemon_child and
 * daemon_kill take. */
struct daemon daemon_extra_worker(const struct daemon *daemon);

/* Waits, at most 10 s times the patience, until that supervisor waits for SIGTERM, which would end
 * it at once before. */
void daemon_wait_for_worker(pid_t pid);

/* Prints the last lines of the log of all processes. */
void daemon_show_log(const struct daemon *daemon);

/* The process id of the "api" or "work" child, 0 if there is none at the moment. */
pid_t daemon_child(const struct daemon *daemon, const char *role);

/* Kills the supervisor, and waits for the end of its children. Returns false after 15 s. */
bool daemon_kill(struct daemon *daemon);

/* Sends SIGTERM and waits. Returns whether the daemon ended in its time with exit code 0, and its
 * children too. It takes 10 s at most, to which come those that processes are held up for. */
bool daemon_drain(struct daemon *daemon);

/* The number of processes that run the daemon on this store, without zombies. */
int daemon_processes(const struct daemon *daemon);

/* Reaps zombies that this process has inherited from killed processes, except `kept`. */
void daemon_reap_others(pid_t kept);

void pause_ms(int ms);

#endif
