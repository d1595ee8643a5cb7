/* SPDX-License-Identifier: MIT */
/* `penumbrad backup FILE`: copies the store, even while a daemon uses it. The daemon's own
 * configuration names the store. */
#include "cmd/daemon/cmd_backup.h"

#include <inttypes.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>

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

/* Finds the store as the daemon does. Returns as pen_config_load. Owns: release *config in any
 * case. */
static int find_store(const struct settings *settings, struct pen_config *config)
{
    static char program[] = "penumbrad", store[] = "--store", file[] = "--config";
    char *argv[6] = {program};
    int argc = 1;
    if (settings->store) {
        argv[argc++] = store;
        argv[argc++] = (char *)(uintptr_t)settings->store;
    }
    if (settings->config) {
        argv[argc++] = file;
        argv[argc++] = (char *)(uintptr_t)settings->config;
    }
    return pen_config_load(config, argc, argv);
}

static atomic_bool stop;       /* set by a signal handler, which it is lock-free for */
static atomic_int stop_signal; /* the signal */

static void note_signal(int signal)
{
    atomic_store(&stop_signal, signal);
    atomic_store(&stop, true);
}

/* Lets the signals that end a program stop the backup, which then removes its unfinished file. */
static void catch_signals(void)
{
    static const int signals[] = {SIGTERM, SIGINT, SIGHUP};
    struct sigaction action = {.sa_handler = note_signal, .sa_flags = SA_RESTART}, before;
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++) {
        if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
            sigaction(signals[i], &action, NULL);
    }
}

/* Ends the process as the signal would have. */
static void end_by_signal(void)
{
    if (!atomic_load(&stop))
        return;
    signal(atomic_load(&stop_signal), SIG_DFL);
    raise(atomic_load(&stop_signal));
}

static int back_up(const char *store, const char *file, bool replace)
{
    struct pen_backup backup = {.stop = &stop};
    struct pen_status st;
    catch_signals();
    if (!pen_store_backup(store, file, replace, &backup, &st)) {
        int code = pen_report(command.program, NULL, &st);
        end_by_signal();
        return code;
    }
    pen_report_say(stdout, "%s: %" PRId64 " jobs, %" PRId64 " bytes, from %s", file, backup.jobs,
                   backup.bytes, store);
    return 0;
}

int pen_backup_command(int argc, char **argv)
{
    struct settings settings = {0};
    struct pen_parsed parsed;
    struct pen_config config;
    int code = pen_command_begin(&command, argc, argv, &settings, &parsed);
    if (code >= 0)
        return code;
    code = find_store(&settings, &config);
    if (code < 0)
        code = back_up(config.store, parsed.args[0], settings.replace);
    pen_config_release(&config);
    return code;
}
