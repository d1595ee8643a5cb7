/* SPDX-License-Identifier: MIT */
#include "child.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pen/base/clock.h"
#include "pen/base/log.h"
#include "roles.h"

/* A process that lived so long was no crash at the start. */
static const int64_t stable_ns = INT64_C(10) * 1000000000;
static const int64_t first_pause_ns = INT64_C(100) * 1000000;
static const int64_t longest_pause_ns = INT64_C(5) * 1000000000;

enum { ARGUMENTS_MAX = 32, EXEC_FAILED = 127 };

void pen_child_init(struct pen_child *child, const char *role)
{
    *child = (struct pen_child){.role = role, .control_fd = -1};
}

/* The child's command line: everything the supervisor found out, nothing left to look up. */
struct arguments {
    int count;
    char *list[ARGUMENTS_MAX + 1];
    char threads[16], listen[16], control[16];
};

static void add(struct arguments *arguments, const char *option, const char *value)
{
    if (!value || !*value || arguments->count + 2 > ARGUMENTS_MAX)
        return;
    arguments->list[arguments->count++] = (char *)(uintptr_t)option;
    arguments->list[arguments->count++] = (char *)(uintptr_t)value;
}

static void make_arguments(struct arguments *arguments, const struct pen_child *child,
                           const struct pen_config *config, int control_fd, int listen_fd)
{
    static char program[] = "penumbrad";
    *arguments = (struct arguments){.count = 1, .list = {program}};
    snprintf(arguments->threads, sizeof arguments->threads, "%d", config->threads);
    snprintf(arguments->control, sizeof arguments->control, "%d", control_fd);
    snprintf(arguments->listen, sizeof arguments->listen, "%d", listen_fd);
    add(arguments, "--role", child->role);
    add(arguments, "--store", config->store);
    add(arguments, "--threads", arguments->threads);
    add(arguments, "--log-level", config->log_level);
    add(arguments, "--log-format", config->log_format);
    add(arguments, "--log-file", config->log_file);
    add(arguments, "--internal-control-fd", arguments->control);
    if (listen_fd >= 0)
        add(arguments, "--internal-listen-fd", arguments->listen);
    add(arguments, "--internal-worker-name", child->name);
    add(arguments, "--internal-dead-worker", child->dead_name);
    arguments->list[arguments->count] = NULL;
}

/* In the new process. Its standard output is not the supervisor's: who reads the first line there
 * must not wait for a child that lives on. If the supervisor dies while this one is stopped, it is
 * continued, so that it sees the end of the control channel and ends. */
static _Noreturn void become(const struct arguments *arguments, int control_fd, int listen_fd)
{
    sigset_t none;
    sigemptyset(&none);
    int null = open("/dev/null", O_RDWR);
    if (null >= 0) {
        dup2(null, STDIN_FILENO);
        dup2(null, STDOUT_FILENO);
    }
    prctl(PR_SET_PDEATHSIG, SIGCONT);
    fcntl(control_fd, F_SETFD, 0);
    if (listen_fd >= 0)
        fcntl(listen_fd, F_SETFD, 0);
    sigprocmask(SIG_SETMASK, &none, NULL);
    execv("/proc/self/exe", arguments->list);
    _exit(EXEC_FAILED);
}

int64_t pen_child_settles_ns(const struct pen_child *child)
{
    return child->pid && child->failures > 0 ? child->started_ns + stable_ns : INT64_MAX;
}

void pen_child_settle(struct pen_child *child)
{
    if (pen_clock_ns() >= pen_child_settles_ns(child))
        child->failures = 0;
}

/* Sets the next start. Returns the pause until then. */
static int64_t schedule(struct pen_child *child)
{
    int64_t pause = 0;
    if (child->failures > 0)
        pause = child->failures > 6 ? longest_pause_ns : first_pause_ns << (child->failures - 1);
    if (pause > longest_pause_ns)
        pause = longest_pause_ns;
    child->failures++;
    child->start_at_ns = pen_clock_ns() + pause;
    return pause;
}

void pen_child_start(struct pen_child *child, const struct pen_config *config, int listen_fd)
{
    int pair[2];
    long long start_ms = (long long)pen_clock_wall_ms();
    child->started_ns = pen_clock_ns();
    child->ready = child->stopping = child->killed = false;
    pid_t pid = -1;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) == 0) {
        pid = fork();
        if (pid == 0) {
            struct arguments arguments;
            if (strcmp(child->role, "worker") == 0)
                pen_worker_name(getpid(), start_ms, child->name, sizeof child->name);
            make_arguments(&arguments, child, config, pair[1], listen_fd);
            become(&arguments, pair[1], listen_fd);
        }
        int cause = errno;
        close(pair[1]);
        if (pid < 0)
            close(pair[0]);
        errno = cause;
    }
    if (pid < 0) {
        pen_log(PEN_LOG_ERROR, "cannot start the %s process: %s", child->role, strerror(errno));
        schedule(child);
        return;
    }
    child->pid = pid;
    child->control_fd = pair[0];
    if (strcmp(child->role, "worker") == 0)
        pen_worker_name(pid, start_ms, child->name, sizeof child->name);
    pen_log(PEN_LOG_DEBUG, "started the %s process %d", child->role, (int)pid);
}

static void describe_end(int wait_status, char *out, size_t bytes)
{
    if (WIFSIGNALED(wait_status)) {
        const char *name = sigabbrev_np(WTERMSIG(wait_status));
        snprintf(out, bytes, "signal %d (SIG%s)", WTERMSIG(wait_status), name ? name : "?");
    } else if (WEXITSTATUS(wait_status) == EXEC_FAILED) {
        snprintf(out, bytes, "the program could not be started");
    } else {
        snprintf(out, bytes, "exit code %d", WEXITSTATUS(wait_status));
    }
}

void pen_child_ended(struct pen_child *child, int wait_status)
{
    bool expected = child->stopping && WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0;
    int64_t lived_ns = pen_clock_ns() - child->started_ns;
    int pid = (int)child->pid;
    pen_child_settle(child);
    describe_end(wait_status, child->last_end, sizeof child->last_end);
    if (child->control_fd >= 0)
        close(child->control_fd);
    child->control_fd = -1;
    child->pid = 0;
    /* One that was never ready held no leases, and has swept none. */
    if (child->ready && !expected)
        memcpy(child->dead_name, child->name, sizeof child->dead_name);
    child->ready = false;
    if (child->stopping) {
        child->failures = 0;
        child->start_at_ns = pen_clock_ns();
        pen_log(expected ? PEN_LOG_INFO : PEN_LOG_WARN, "the %s process %d ended: %s", child->role,
                pid, child->last_end);
        return;
    }
    int64_t pause_ns = schedule(child);
    pen_log(PEN_LOG_WARN,
            "the %s process %d ended: %s, after %.1f s; starting it again in %.1f s (%d in a row)",
            child->role, pid, child->last_end, (double)lived_ns * 1e-9, (double)pause_ns * 1e-9,
            child->failures);
}
