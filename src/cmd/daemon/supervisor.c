/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/supervisor.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "cmd/daemon/child.h"
#include "cmd/daemon/control.h"
#include "cmd/daemon/notify.h"
#include "cmd/daemon/roles.h"
#include "cmd/daemon/signals.h"
#include "cmd/option_values.h"

/* When a drain kills the children, in seconds after the signal, and how often it checks them. */
static const int64_t second_ns = 1000000000;
enum { KILL_WORKER_S = 7, KILL_API_S = 9, DRAIN_CHECK_MS = 20 };
_Static_assert(KILL_WORKER_S * 1000 > PEN_DRAIN_WORKER_MS, "a worker gives its batch back first");
/* When a drain ends without waiting for a process that not even SIGKILL has ended. */
static const int64_t longest_drain_ns = 9700000000;
/* The number of ends in a row (child.h) from which on it is a crash loop and the daemon is not
 * ready. */
enum { CRASH_LOOP = 3 };
/* The children's slots for signals of the store. */
enum { SLOT_API, SLOT_WORKER, SLOTS };

struct supervisor {
    const struct pen_config *first; /* the configuration at the start */
    struct pen_config reloaded;     /* of the last SIGHUP; owns texts that `now` points to */
    struct pen_config now;          /* the configuration for children */
    int argc;
    char **argv;
    int listen_fd, signal_fd;
    struct pen_child api, worker;
    bool draining;
    int64_t drain_ns;              /* when it began */
    char state[PEN_CONTROL_BYTES]; /* the last "state" message to the api */
    struct pen_notify notify;
    bool told_ready; /* the service manager */
    int64_t ping_ns; /* when the children are next asked whether they answer */
};

/* Writes why a child does not work: it has ended because of an I/O error, or is in a crash loop. */
static void describe_failure(const struct pen_child *child, char *text, size_t size)
{
    if (child->fault[0])
        snprintf(text, size, "the %s process ended, and is started again: %s", child->role,
                 child->fault);
    else if (child->failures >= CRASH_LOOP)
        snprintf(text, size,
                 "the %s process ended %d times in a row, soon after its start%s, the last time "
                 "by %s",
                 child->role, child->failures, child->blamed_count ? " or over different jobs" : "",
                 child->last_end);
}

/* Sends the api the reason why the daemon is not ready, or an empty reason. It is an I/O error, a
 * worker in a crash loop, or ends of the api's predecessors, which a new api process does not know.
 * Without `always` it is sent only if it has changed. */
static void send_state(struct supervisor *s, bool always)
{
    char text[sizeof s->state] = "state ";
    char *rest = text + strlen(text);
    size_t size = sizeof text - strlen(text);
    describe_failure(&s->api, rest, size);
    describe_failure(&s->worker, rest, size);
    if (!always && strcmp(text, s->state) == 0)
        return;
    memcpy(s->state, text, sizeof text);
    pen_control_send(s->api.control_fd, text);
}

/* Returns true if a child handles its events, or is starting or ending, which other limits
 * bound. */
static bool answers(const struct pen_child *child)
{
    return !child->pid || !child->ready || child->stopping || child->answered;
}

/* Returns true if a child that the role has is there and works. */
static bool is_up(const struct pen_child *child)
{
    return child->ready || child->start_at_ns == INT64_MAX;
}

static void ping(struct pen_child *child)
{
    if (child->stopping) /* it is not to be woken */
        return;
    child->answered = false;
    pen_control_send(child->control_fd, "ping");
}

/* Notifies the service manager when the daemon is ready. After that it reports three times within
 * the watchdog's time that the children answer. If a child does not answer it reports nothing, so
 * that the manager restarts the daemon. */
static void notify_manager(struct supervisor *s)
{
    const int64_t now = pen_clock_ns();
    if (!s->told_ready && is_up(&s->api) && is_up(&s->worker))
        s->told_ready = pen_notify_send(&s->notify, "READY=1"); /* if not, in the next round */
    if (!s->told_ready || s->notify.watchdog_ns == 0 || now < s->ping_ns)
        return;
    if (answers(&s->api) && answers(&s->worker))
        pen_notify_send(&s->notify, "WATCHDOG=1");
    ping(&s->api);
    ping(&s->worker);
    s->ping_ns = now + s->notify.watchdog_ns / 3;
}

static void start_if_due(struct supervisor *s, struct pen_child *child, int listen_fd)
{
    if (child->pid || s->draining || pen_clock_ns() < child->start_at_ns)
        return;
    pen_child_start(child, &s->now, listen_fd);
}

static void stop_child(struct pen_child *child)
{
    if (!child->pid || child->stopping)
        return;
    child->stopping = true;
    pen_control_send(child->control_fd, "stop");
}

static void kill_child(struct pen_child *child)
{
    if (!child->pid || child->killed)
        return;
    child->killed = true;
    pen_log(PEN_LOG_WARN, "the %s process %d does not end: killing it", child->role,
            (int)child->pid);
    kill(child->pid, SIGKILL);
}

static void begin_drain(struct supervisor *s)
{
    if (s->draining) { /* a second signal: end at once */
        kill_child(&s->worker);
        kill_child(&s->api);
        return;
    }
    pen_log(PEN_LOG_INFO, "draining");
    pen_notify_send(&s->notify, "STOPPING=1");
    s->draining = true;
    s->drain_ns = pen_clock_ns();
    pen_control_send(s->api.control_fd, "drain");
    stop_child(&s->worker);
}

static void advance_drain(struct supervisor *s)
{
    int64_t since = pen_clock_ns() - s->drain_ns;
    if (since > KILL_WORKER_S * second_ns)
        kill_child(&s->worker);
    if (!s->worker.pid || since > KILL_WORKER_S * second_ns)
        stop_child(&s->api);
    if (since > KILL_API_S * second_ns)
        kill_child(&s->api);
}

/* Returns true if the option applies when the configuration is read again. */
static bool is_reloadable(const struct pen_option *option)
{
    return strcmp(option->name, "threads") == 0 || strncmp(option->name, "log-", 4) == 0;
}

/* Reads the configuration again, and applies the settings of the log and the number of threads. A
 * wrong configuration changes nothing. */
static void reload(struct supervisor *s)
{
    struct pen_config fresh;
    struct pen_status st;
    if (pen_config_load(&fresh, s->argc, s->argv) >= 0) {
        pen_log(PEN_LOG_ERROR, "the new configuration is wrong, the old one stays");
        pen_config_release(&fresh);
        return;
    }
    for (const struct pen_option *option = pen_command_daemon.options; option->name; option++) {
        if (!is_reloadable(option) && !pen_option_same(option, s->first, &fresh))
            pen_log(PEN_LOG_WARN, "%s changes only when the daemon is started again", option->name);
    }
    bool other_threads = s->now.threads != fresh.threads;
    s->now.threads = fresh.threads;
    s->now.log_level = fresh.log_level;
    s->now.log_format = fresh.log_format;
    s->now.log_file = fresh.log_file;
    pen_config_release(&s->reloaded);
    s->reloaded = fresh;
    struct pen_log_target target = {
        .level = fresh.log_level, .format = fresh.log_format, .file = fresh.log_file};
    if (!pen_config_log(&target, &st))
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
    char text[PEN_CONTROL_BYTES];
    snprintf(text, sizeof text, "log %s %s %s", fresh.log_level, fresh.log_format,
             fresh.log_file ? fresh.log_file : "");
    pen_control_send(s->api.control_fd, text);
    pen_control_send(s->worker.control_fd, text);
    if (other_threads)
        stop_child(&s->worker);
    pen_log(PEN_LOG_INFO, "configuration read again");
}

static void reap(struct supervisor *s)
{
    int status;
    for (pid_t pid; (pid = waitpid(-1, &status, WNOHANG)) > 0;) {
        if (pid == s->api.pid)
            pen_child_ended(&s->api, status);
        else if (pid == s->worker.pid)
            pen_child_ended(&s->worker, status);
    }
}

static void handle_signals(struct supervisor *s)
{
    struct signalfd_siginfo info;
    while (read(s->signal_fd, &info, sizeof info) == (ssize_t)sizeof info) {
        if (info.ssi_signo == SIGTERM || info.ssi_signo == SIGINT)
            begin_drain(s);
        else if (info.ssi_signo == SIGHUP && !s->draining)
            reload(s);
    }
}

static void handle_message(struct supervisor *s, struct pen_child *child, const char *text)
{
    if (strcmp(text, "pong") == 0)
        child->answered = true;
    if (strncmp(text, "fault ", 6) == 0)
        pen_child_fault(child, text + 6);
    if (strcmp(text, "idle") == 0 && !s->draining) {
        pen_log(PEN_LOG_INFO, "no work for %d s", s->now.until_idle);
        begin_drain(s);
    }
    if (strcmp(text, "ready") != 0)
        return;
    pen_child_ready(child);
    if (child == &s->api)
        send_state(s, true);
}

/* Handles all of them, because the messages of an ending process come before its end. */
static void handle_messages(struct supervisor *s, struct pen_child *child)
{
    char text[PEN_CONTROL_BYTES];
    ssize_t got;
    while ((got = recv(child->control_fd, text, sizeof text - 1, MSG_DONTWAIT)) > 0) {
        text[got] = '\0';
        handle_message(s, child, text);
    }
    if (got < 0 && (errno == EAGAIN || errno == EINTR))
        return;
    close(child->control_fd); /* the child is ending; SIGCHLD follows */
    child->control_fd = -1;
}

/* Returns the time until the next start, ping or check of a child's failures is due. It is short
 * while draining. */
static int wait_ms(const struct supervisor *s)
{
    if (s->draining)
        return DRAIN_CHECK_MS;
    const struct pen_child *children[] = {&s->api, &s->worker};
    int64_t next = s->told_ready && s->notify.watchdog_ns ? s->ping_ns : INT64_MAX;
    const int64_t now = pen_clock_ns();
    for (int i = 0; i < 2; i++) {
        const struct pen_child *child = children[i];
        int64_t at = child->pid ? pen_child_check_at_ns(child) : child->start_at_ns;
        next = at < next ? at : next;
    }
    if (next == INT64_MAX)
        return -1;
    return next <= now ? 0 : (int)((next - now) / 1000000) + 1;
}

static void handle_events(struct supervisor *s)
{
    enum { SIGNALS, API, WORKER, COUNT };
    struct pollfd fds[COUNT] = {[SIGNALS] = {.fd = s->signal_fd, .events = POLLIN},
                                [API] = {.fd = s->api.control_fd, .events = POLLIN},
                                [WORKER] = {.fd = s->worker.control_fd, .events = POLLIN}};
    if (poll(fds, COUNT, wait_ms(s)) <= 0)
        return;
    if (fds[API].revents)
        handle_messages(s, &s->api);
    if (fds[WORKER].revents)
        handle_messages(s, &s->worker);
    if (fds[SIGNALS].revents) {
        handle_signals(s);
        reap(s);
    }
}

static bool open_signals(struct supervisor *s, struct pen_status *st)
{
    s->signal_fd = pen_signals_open();
    return s->signal_fd >= 0 ||
           pen_fail(st, PEN_IO, "cannot wait for signals: %s", strerror(errno));
}

static void run(struct supervisor *s)
{
    for (;;) {
        start_if_due(s, &s->api, s->listen_fd);
        start_if_due(s, &s->worker, -1);
        pen_child_reset_failures(&s->api);
        pen_child_reset_failures(&s->worker);
        send_state(s, false);
        notify_manager(s);
        if (s->draining)
            advance_drain(s);
        if (s->draining &&
            ((!s->api.pid && !s->worker.pid) || pen_clock_ns() - s->drain_ns > longest_drain_ns))
            return;
        handle_events(s);
    }
}

int pen_supervisor_run(const struct pen_config *config, int argc, char **argv, int listen_fd)
{
    struct supervisor s = {
        .first = config, .now = *config, .argc = argc, .argv = argv, .listen_fd = listen_fd};
    struct pen_status st;
    pen_child_init(&s.api, "api", SLOT_API, pen_config_serves(config));
    pen_child_init(&s.worker, "worker", SLOT_WORKER, pen_config_renders(config));
    if (!open_signals(&s, &st) || !pen_store_signals_make(SLOTS, &st)) {
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
        return pen_code_exit(st.code);
    }
    pen_notify_open(&s.notify);
    run(&s);
    pen_notify_close(&s.notify);
    close(s.signal_fd);
    pen_config_release(&s.reloaded);
    pen_log(PEN_LOG_INFO, "ended");
    return 0;
}
