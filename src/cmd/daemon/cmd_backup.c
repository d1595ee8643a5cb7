/* SPDX-License-Identifier: MIT */
/* `penumbrad backup FILE`: copies the store, which a daemon may use meanwhile. The daemon's own
 * configuration names the store.
 *
 * A killed process cannot remove its unfinished copy. So a child makes the copy. If the child is
 * killed, its parent removes the copy. If the parent is killed, the kernel sends SIGTERM to the
 * child, which removes the copy itself. If both are killed at once, the next backup to that name
 * removes it. */
#include "cmd/daemon/cmd_backup.h"

#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cmd/daemon/config.h"
#include "cmd/report.h"
#include "store/store.h"

struct settings {
    const char *store, *config;
    bool replace;
};

static const struct pen_option options[] = {
    {.name = "store",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct settings, store),
     .value = "FILE",
     .env = "PENUMBRA_STORE",
     .help = "the store to copy; the daemon's by default"},
    {.name = "config",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct settings, config),
     .value = "FILE",
     .env = "PENUMBRA_CONFIG",
     .help = "the daemon's configuration file, which may name the store"},
    {.name = "replace",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct settings, replace),
     .help = "replace an existing file, once the new backup is complete"},
    {0}};

static const struct pen_command command = {
    .program = "penumbrad",
    .name = "backup",
    .arguments = "FILE",
    .summary = "Copies the store into one file while the daemon runs and takes jobs.",
    .details = "The copy is the state of the store at one moment. It is checked and flushed to "
               "disk before it gets its name. To restore it: stop the daemon, wait until none of "
               "its processes is left, replace the store by the copy, remove the store's -wal and "
               "-shm files if there are any, start the daemon. Unfinished jobs are then "
               "continued.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
};

static const int stopping[] = {SIGTERM, SIGINT, SIGHUP};
enum { STOPPING = sizeof stopping / sizeof stopping[0] };

static atomic_bool stop;       /* set by a signal handler, for which it is lock-free */
static atomic_int stop_signal; /* the signal */

static void note_signal(int signal)
{
    atomic_store(&stop_signal, signal);
    atomic_store(&stop, true);
}

static bool is_ignored(int signal)
{
    struct sigaction action;
    return sigaction(signal, NULL, &action) == 0 && action.sa_handler == SIG_IGN;
}

/* Makes the signals that end a program stop the backup, which then removes its unfinished file. */
static void catch_signals(void)
{
    const struct sigaction action = {.sa_handler = note_signal, .sa_flags = SA_RESTART};
    for (int i = 0; i < STOPPING; i++) {
        if (!is_ignored(stopping[i]))
            sigaction(stopping[i], &action, NULL);
    }
}

/* Ends the process as the signal would have. */
static void end_by(int number)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, number);
    signal(number, SIG_DFL);
    sigprocmask(SIG_UNBLOCK, &set, NULL);
    raise(number);
}

static int back_up(const char *store, const char *file, bool replace)
{
    struct pen_backup backup = {.stop = &stop};
    struct pen_status st;
    if (!pen_store_backup(store, file, replace, &backup, &st)) {
        int code = pen_report(command.program, NULL, &st);
        if (atomic_load(&stop))
            end_by(atomic_load(&stop_signal));
        return code;
    }
    pen_report_say(stdout, "%s: %" PRId64 " jobs, %" PRId64 " bytes, from %s", file, backup.jobs,
                   backup.bytes, store);
    return 0;
}

/* Blocks the signals that end a program, unless they are ignored, and SIGCHLD. */
static void hold_signals(sigset_t *held, sigset_t *before)
{
    sigemptyset(held);
    sigaddset(held, SIGCHLD);
    signal(SIGCHLD, SIG_DFL);
    for (int i = 0; i < STOPPING; i++) {
        if (!is_ignored(stopping[i]))
            sigaddset(held, stopping[i]);
    }
    sigprocmask(SIG_BLOCK, held, before);
}

/* In the child. */
static int back_up_for(pid_t parent, const sigset_t *mask, const char *store, const char *file,
                       bool replace)
{
    catch_signals();
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) /* the parent was killed before that */
        note_signal(SIGTERM);
    sigprocmask(SIG_SETMASK, mask, NULL);
    return back_up(store, file, replace);
}

/* Passes signals on to the child until it has ended, and ends in the same way. */
static int attend(pid_t child, const sigset_t *held, const char *file)
{
    int status = 0, number;
    while (waitpid(child, &status, WNOHANG) == 0) {
        number = sigwaitinfo(held, NULL);
        if (number > 0 && number != SIGCHLD)
            kill(child, number);
    }
    if (WIFEXITED(status))
        return WEXITSTATUS(status);
    pen_store_backup_remove_left(file);
    number = WTERMSIG(status);
    if (!sigismember(held, number))
        pen_report_say(stderr, "%s: the process that made the backup was ended by a signal (%s)",
                       command.program, strsignal(number));
    end_by(number);
    return 128 + number;
}

/* The child returns like the caller, so that its output is flushed. */
static int back_up_attended(const char *store, const char *file, bool replace)
{
    sigset_t held, before;
    const pid_t parent = getpid();
    hold_signals(&held, &before);
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0)
        return back_up_for(parent, &before, store, file, replace);
    if (child > 0)
        return attend(child, &held, file);
    struct pen_status st;
    pen_fail(&st, PEN_UNAVAILABLE, "cannot start a process: %s", strerror(errno));
    return pen_report(command.program, NULL, &st);
}

int pen_backup_command(int argc, char **argv)
{
    struct settings settings = {0};
    struct pen_parsed parsed;
    struct pen_config config;
    int code = pen_command_begin(&command, argc, argv, &settings, &parsed);
    if (code >= 0)
        return code;
    code = pen_config_find_store(settings.store, settings.config, &config);
    if (code < 0)
        code = back_up_attended(config.store, parsed.args[0], settings.replace);
    pen_config_release(&config);
    return code;
}
