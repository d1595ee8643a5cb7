/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/child.h"

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

#include "base/clock.h"
#include "base/log.h"
#include "cmd/daemon/crash_record.h"
#include "cmd/daemon/oom.h"
#include "cmd/daemon/signals.h"
#include "cmd/daemon/worker_exit.h"
#include "cmd/option_values.h"

/* Life times from which on a process counts as stable. stable_ns: it did not crash at its start.
 * stable_fault_ns: a successor of a process with an I/O error works, because it could open the
 * store. */
static const int64_t stable_ns = INT64_C(10) * 1000000000, stable_fault_ns = 2000000000;
/* How often the supervisor checks whether a worker has done enough. */
static const int64_t check_ns = INT64_C(250) * 1000000;
static const int64_t first_pause_ns = INT64_C(100) * 1000000;
static const int64_t longest_pause_ns = INT64_C(5) * 1000000000, longest_fault_ns = 2000000000;

enum { ARGUMENTS_MAX = 22 };

void pen_child_init(struct pen_child *child, const char *role, int signal_slot, bool wanted)
{
    *child = (struct pen_child){.role = role,
                                .signal_slot = signal_slot,
                                .control_fd = -1,
                                .trace_fd = -1,
                                .start_at_ns = wanted ? 0 : INT64_MAX,
                                .dead = {.trace_fd = -1}};
}

static bool is_worker(const struct pen_child *child)
{
    return strcmp(child->role, "worker") == 0;
}

static void close_fd(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

/* The child's command line: its role, and what only its supervisor knows. */
struct arguments {
    int count;
    char *list[ARGUMENTS_MAX + 1];
    char control[16], listen[16], slot[16], trace[16], dead_trace[16];
};

static void add(struct arguments *arguments, const char *option, const char *value)
{
    if (!*value || arguments->count + 2 > ARGUMENTS_MAX)
        return;
    arguments->list[arguments->count++] = (char *)(uintptr_t)option;
    arguments->list[arguments->count++] = (char *)(uintptr_t)value;
}

/* Adds a descriptor or a slot; a number below 0 is left out. */
static void add_number(struct arguments *arguments, const char *option, int number, char text[16])
{
    snprintf(text, 16, "%d", number);
    if (number >= 0)
        add(arguments, option, text);
}

static void make_arguments(struct arguments *arguments, const struct pen_child *child,
                           int control_fd, int listen_fd)
{
    static char program[] = "penumbrad";
    *arguments = (struct arguments){.count = 1, .list = {program}};
    add(arguments, "--role", child->role);
    add_number(arguments, "--internal-control-fd", control_fd, arguments->control);
    add_number(arguments, "--internal-listen-fd", listen_fd, arguments->listen);
    add_number(arguments, "--internal-signal-slot", child->signal_slot, arguments->slot);
    add_number(arguments, "--internal-trace-fd", child->trace_fd, arguments->trace);
    add(arguments, "--internal-worker-name", child->name);
    if (!child->dead.name[0])
        return;
    add(arguments, "--internal-dead-worker", child->dead.name);
    add(arguments, "--internal-dead-how", child->dead.how);
    add(arguments, "--internal-dead-end",
        child->dead.end == PEN_WORKER_CRASHED ? "crashed" : "died");
    add_number(arguments, "--internal-dead-trace-fd", child->dead.trace_fd, arguments->dead_trace);
}

/* Puts the configuration into the environment. Other users can read a command line but not the
 * environment, and the address of a store may have a password. The configuration file is left out,
 * because its values are in the environment. A worker does not get the options of serving. */
static bool set_environment(const struct pen_child *child, const struct pen_config *config)
{
    struct pen_config own = *config;
    own.role = child->role;
    own.file = NULL;
    if (is_worker(child)) {
        own.listen = NULL;
        own.access = (struct pen_access){0};
    }
    return pen_options_to_env(&pen_command_daemon, &own);
}

/* Runs in the new process.
 *   - Standard output becomes /dev/null. So a program that reads the supervisor's first line there
 *     need not wait for a child that lives longer.
 *   - If the supervisor dies while this process is stopped, the kernel continues this process
 *     (SIGCONT). It then sees the closed control channel and ends. */
static _Noreturn void exec_child(const struct pen_child *child, const struct pen_config *config,
                                 int control_fd, int listen_fd)
{
    const int kept[] = {control_fd, listen_fd, child->trace_fd, child->dead.trace_fd};
    struct arguments arguments;
    int null = open("/dev/null", O_RDWR);
    if (null >= 0) {
        dup2(null, STDIN_FILENO);
        dup2(null, STDOUT_FILENO);
    }
    prctl(PR_SET_PDEATHSIG, SIGCONT);
    for (size_t i = 0; i < sizeof kept / sizeof kept[0]; i++) {
        if (kept[i] >= 0)
            fcntl(kept[i], F_SETFD, 0);
    }
    pen_signals_hold_alone();
    make_arguments(&arguments, child, control_fd, listen_fd);
    if (set_environment(child, config))
        execv("/proc/self/exe", arguments.list);
    _exit(PEN_EXEC_FAILED);
}

/* Returns the time from which on the child counts as stable. */
static int64_t stable_at(const struct pen_child *child)
{
    const bool works = child->fault[0] && !child->has_fault && child->ready;
    return child->started_ns + (works ? stable_fault_ns : stable_ns);
}

int64_t pen_child_check_at_ns(const struct pen_child *child)
{
    if (!child->pid || child->failures == 0)
        return INT64_MAX;
    const int64_t stable_at_ns = stable_at(child);
    const int64_t check_at_ns = child->trace ? pen_clock_ns() + check_ns : stable_at_ns;
    return check_at_ns < stable_at_ns ? check_at_ns : stable_at_ns;
}

void pen_child_reset_failures(struct pen_child *child)
{
    const bool stable = child->pid && pen_clock_ns() >= stable_at(child);
    if (stable ||
        (child->trace && atomic_load_explicit(&child->trace->proven, memory_order_relaxed)))
        child->failures = child->blamed_count = 0;
    if (child->failures == 0 && !child->has_fault)
        child->fault[0] = '\0';
}

void pen_child_fault(struct pen_child *child, const char *why)
{
    snprintf(child->fault, sizeof child->fault, "%s", why);
    child->has_fault = true;
}

/* Counts the crash over a job. Returns false if a crash over this job was counted before. */
static bool blame(struct pen_child *child, const char *job)
{
    for (int i = 0; i < child->blamed_count && i < PEN_CHILD_BLAMED; i++)
        if (strcmp(child->blamed[i], job) == 0)
            return false;
    memcpy(child->blamed[child->blamed_count++ % PEN_CHILD_BLAMED], job, PEN_ID_BYTES);
    return true;
}

/* Returns true if the end of a process counts, see child.h. Call it after keep_death_report. */
static bool end_counts(struct pen_child *child, int wait_status)
{
    char job[PEN_ID_BYTES] = "";
    if (child->trace && child->ready)
        memcpy(job, child->trace->job, sizeof job - 1);
    if (!job[0])
        return true;
    if (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0)
        return false;
    return child->dead.end != PEN_WORKER_CRASHED || blame(child, job);
}

/* Sets the time of the next start, and adds the failure if it counts. Returns the pause until
 * then. */
static int64_t schedule_restart(struct pen_child *child, bool counts)
{
    const int64_t longest_ns = child->fault[0] ? longest_fault_ns : longest_pause_ns;
    int64_t pause = 0;
    if (counts && child->failures > 0)
        pause = child->failures > 6 ? longest_ns : first_pause_ns << (child->failures - 1);
    if (pause > longest_ns)
        pause = longest_ns;
    child->failures += counts;
    child->start_at_ns = pen_clock_ns() + pause;
    return pause;
}

/* Makes the parts that each worker process has for itself: its id in the store, its crash
 * record. */
static void prepare_worker(struct pen_child *child)
{
    close_fd(&child->trace_fd);
    pen_crash_record_unmap(child->trace);
    child->trace_fd = pen_crash_record_new();
    child->trace = pen_crash_record_map(child->trace_fd);
    child->oom_kills = pen_oom_kills();
    pen_worker_id_make(child->name);
}

void pen_child_start(struct pen_child *child, const struct pen_config *config, int listen_fd)
{
    int pair[2];
    child->started_ns = pen_clock_ns();
    child->ready = child->stopping = child->killed = child->has_fault = false;
    pid_t pid = -1;
    if (is_worker(child))
        prepare_worker(child);
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) == 0) {
        pid = fork();
        if (pid == 0)
            exec_child(child, config, pair[1], listen_fd);
        int cause = errno;
        close(pair[1]);
        if (pid < 0)
            close(pair[0]);
        errno = cause;
    }
    if (pid < 0) {
        pen_log(PEN_LOG_ERROR, "cannot start the %s process: %s", child->role, strerror(errno));
        schedule_restart(child, true);
        return;
    }
    child->pid = pid;
    child->control_fd = pair[0];
    pen_log(PEN_LOG_DEBUG, "started the %s process %d", child->role, (int)pid);
}

void pen_child_ready(struct pen_child *child)
{
    child->ready = child->answered = true;
    child->dead.name[0] = '\0';
    close_fd(&child->dead.trace_fd);
}

/* Keeps for the next worker which worker has ended, and how. */
static void keep_death_report(struct pen_child *child, int wait_status)
{
    bool oom = is_worker(child) && pen_oom_kills() > child->oom_kills;
    memcpy(child->dead.name, child->name, sizeof child->dead.name);
    memcpy(child->dead.how, child->last_end, sizeof child->dead.how);
    child->dead.end = child->killed ? PEN_WORKER_DIED : pen_exit_worker_end(wait_status, oom);
    close_fd(&child->dead.trace_fd);
    child->dead.trace_fd = child->trace_fd;
    child->trace_fd = -1;
    if (oom)
        pen_log(PEN_LOG_WARN, "the kernel's OOM killer ran during the worker's life");
}

void pen_child_ended(struct pen_child *child, int wait_status)
{
    bool expected = child->stopping && WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0;
    int64_t lived_ns = pen_clock_ns() - child->started_ns;
    int pid = (int)child->pid;
    pen_child_reset_failures(child);
    pen_exit_describe(wait_status, child->last_end, sizeof child->last_end);
    if (child->control_fd >= 0)
        close(child->control_fd);
    child->control_fd = -1;
    child->pid = 0;
    /* A worker that was never ready held no leases and released none. */
    if (child->ready && !expected)
        keep_death_report(child, wait_status);
    const bool counts = end_counts(child, wait_status);
    child->ready = false;
    if (child->stopping) {
        child->failures = child->blamed_count = 0;
        child->start_at_ns = pen_clock_ns();
        pen_log(expected ? PEN_LOG_INFO : PEN_LOG_WARN, "the %s process %d ended: %s", child->role,
                pid, child->last_end);
        return;
    }
    int64_t pause_ns = schedule_restart(child, counts);
    pen_log(
        PEN_LOG_WARN,
        "the %s process %d ended: %s, after %.1f s; starting it again in %.1f s (%d in a row%s)",
        child->role, pid, child->last_end, (double)lived_ns * 1e-9, (double)pause_ns * 1e-9,
        child->failures, counts ? "" : "; this one is charged to its job");
}
