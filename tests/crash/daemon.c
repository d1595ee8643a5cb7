/* SPDX-License-Identifier: MIT */
#include "daemon.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"

void pause_ms(int ms)
{
    struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    nanosleep(&time, NULL);
}

int daemon_patience(void)
{
    if (!getenv("PEN_TIMED")) /* see tests/support/suite.h */
        return 20;
    return getenv("PEN_FEWER") ? 4 : 1; /* see tests/support/random.h */
}

/* Starts the program with standard output to `out` and standard error to the log. */
static pid_t spawn(const struct daemon *daemon, char *const *arguments, int out)
{
    pid_t pid = fork();
    if (pid != 0)
        return pid;
    int log = open(daemon->log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(out, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execv(daemon->program, arguments);
    _exit(127);
}

bool daemon_start(struct daemon *daemon)
{
    char keep[16];
    snprintf(keep, sizeof keep, "%d", DAEMON_KEEP_JOBS);
    char *arguments[] = {
        "penumbrad", "--listen",    "127.0.0.1:0", "--store", (char *)(uintptr_t)daemon->store,
        "--threads", "2",           "--log-level", "debug",   "--trusted-proxy",
        "127.0.0.1", "--keep-jobs", keep,          NULL};
    int ends[2], port = 0;
    char line[256] = "";
    if (pipe2(ends, O_CLOEXEC) != 0)
        return false;
    daemon->pid = spawn(daemon, arguments, ends[1]);
    close(ends[1]);
    FILE *out = fdopen(ends[0], "r");
    bool ok = fgets(line, sizeof line, out) &&
              sscanf(line, "listening on http://127.0.0.1:%d", &port) == 1;
    fclose(out);
    atomic_store(&daemon->port, port);
    return ok;
}

/* Whether the process has blocked SIGTERM, which it waits for by a descriptor then. */
static bool waits_for_sigterm(pid_t pid)
{
    char path[40], line[200];
    unsigned long long blocked = 0;
    snprintf(path, sizeof path, "/proc/%d/status", (int)pid);
    FILE *file = fopen(path, "re");
    while (file && fgets(line, sizeof line, file) && sscanf(line, "SigBlk: %llx", &blocked) != 1)
        ;
    if (file)
        fclose(file);
    return blocked >> (SIGTERM - 1) & 1;
}

struct daemon daemon_extra_worker(const struct daemon *daemon)
{
    char *arguments[] = {
        "penumbrad", "--role", "worker", "--store", (char *)(uintptr_t)daemon->store,
        "--threads", "1",      NULL};
    return (struct daemon){.pid = spawn(daemon, arguments, STDOUT_FILENO)};
}

void daemon_wait_for_worker(pid_t pid)
{
    for (int i = 0; i < 1000 * daemon_patience() && !waits_for_sigterm(pid); i++)
        pause_ms(10);
}

void daemon_show_log(const struct daemon *daemon)
{
    char command[400];
    fflush(stdout);
    snprintf(command, sizeof command, "tail -n 20 '%s'", daemon->log);
    if (system(command) != 0)
        printf("no log\n");
}

/* A process from /proc. */
struct process {
    pid_t pid, parent;
    char name[32], state;
};

static bool read_process(const char *entry, struct process *process)
{
    char path[300], line[512];
    snprintf(path, sizeof path, "/proc/%s/stat", entry);
    FILE *file = fopen(path, "re");
    if (!file)
        return false;
    bool ok = fgets(line, sizeof line, file) &&
              sscanf(line, "%d (%31[^)]) %c %d", &process->pid, process->name, &process->state,
                     &process->parent) == 4;
    fclose(file);
    return ok;
}

/* Counts the processes for which `want` returns true, without zombies; *last is one of them. */
static int find(bool (*want)(const void *user, const struct process *process), const void *user,
                pid_t *last)
{
    DIR *dir = opendir("/proc");
    int count = 0;
    for (struct dirent *entry; dir && (entry = readdir(dir)) != NULL;) {
        struct process process;
        if (entry->d_name[0] < '1' || entry->d_name[0] > '9' ||
            !read_process(entry->d_name, &process) || process.state == 'Z' || !want(user, &process))
            continue;
        count++;
        *last = process.pid;
    }
    if (dir)
        closedir(dir);
    return count;
}

struct wanted_child {
    pid_t parent;
    char name[32];
};

static bool is_child(const void *user, const struct process *process)
{
    const struct wanted_child *child = user;
    return process->parent == child->parent && strcmp(process->name, child->name) == 0;
}

pid_t daemon_child(const struct daemon *daemon, const char *role)
{
    struct wanted_child child = {.parent = daemon->pid};
    pid_t pid = 0;
    snprintf(child.name, sizeof child.name, "penumbrad-%s", role);
    if (daemon->pid)
        find(is_child, &child, &pid);
    return pid;
}

/* Whether a file of /proc/PID has the store's path. */
static bool names_store(const struct daemon *daemon, pid_t pid, const char *name)
{
    char path[64], text[16384];
    snprintf(path, sizeof path, "/proc/%d/%s", (int)pid, name);
    FILE *file = fopen(path, "re");
    size_t bytes = file ? fread(text, 1, sizeof text, file) : 0;
    if (file)
        fclose(file);
    return memmem(text, bytes, daemon->store, strlen(daemon->store)) != NULL;
}

/* Whether the process is a daemon on this test's store; others may run on the same machine. A
 * supervisor has it on its command line, its children in their environment. */
static bool uses_our_store(const void *user, const struct process *process)
{
    return strncmp(process->name, "penumbrad", 9) == 0 &&
           (names_store(user, process->pid, "cmdline") ||
            names_store(user, process->pid, "environ"));
}

int daemon_processes(const struct daemon *daemon)
{
    pid_t last;
    return find(uses_our_store, daemon, &last);
}

void daemon_reap_others(pid_t kept)
{
    siginfo_t info;
    for (;;) {
        info.si_pid = 0;
        if (waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == 0 ||
            info.si_pid == kept)
            return;
        waitpid(info.si_pid, NULL, 0);
    }
}

/* How long children may outlive their supervisor: they end themselves after a second, but may be
 * held up, and LeakSanitizer looks through all memory of a process that has ended. A drain takes
 * 10 s at most, or DRAIN_MS where processes are held up. Only one of more than LONG_DRAIN_MS ends
 * without waiting for children, which it has killed. */
enum { CHILD_END_MS = 15000, LONG_DRAIN_MS = 9000, DRAIN_MS = 15000 };

static bool gone(pid_t pid)
{
    return pid == 0 || kill(pid, 0) != 0;
}

static bool both_gone(pid_t one, pid_t two, int ms)
{
    int64_t until_ns = pen_clock_ns() + (int64_t)ms * 1000000;
    for (;;) {
        daemon_reap_others(0);
        if (gone(one) && gone(two))
            return true;
        if (pen_clock_ns() > until_ns)
            return false;
        pause_ms(5);
    }
}

bool daemon_kill(struct daemon *daemon)
{
    pid_t api = daemon_child(daemon, "api"), worker = daemon_child(daemon, "work");
    kill(daemon->pid, SIGKILL);
    waitpid(daemon->pid, NULL, 0);
    daemon->pid = 0;
    return both_gone(api, worker, CHILD_END_MS * daemon_patience());
}

/* Waits for the end of a child of this process, at most `ms`, then kills it. Returns whether it
 * ended by itself with exit code 0. */
static bool ends_well(pid_t pid, int ms)
{
    int status = 0;
    int64_t until_ns = pen_clock_ns() + (int64_t)ms * 1000000;
    while (waitpid(pid, &status, WNOHANG) == 0) {
        if (pen_clock_ns() > until_ns)
            kill(pid, SIGKILL);
        pause_ms(5);
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool daemon_drain(struct daemon *daemon)
{
    pid_t api = daemon_child(daemon, "api"), worker = daemon_child(daemon, "work");
    const int64_t begun_ns = pen_clock_ns();
    kill(daemon->pid, SIGTERM);
    bool well = ends_well(daemon->pid, DRAIN_MS * daemon_patience());
    bool was_long = pen_clock_ns() - begun_ns > LONG_DRAIN_MS * INT64_C(1000000);
    daemon->pid = 0;
    return both_gone(api, worker, was_long ? CHILD_END_MS * daemon_patience() : 0) && well;
}
