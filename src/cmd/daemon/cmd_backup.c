/* SPDX-License-Identifier: MIT */
/* `penumbrad backup FILE`: copies the store, even while a daemon uses it. The daemon's own
 * configuration names the store. */
#include "cmd/daemon/cmd_backup.h"

#include <inttypes.h>
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

static int back_up(const char *store, const char *file, bool replace)
{
    struct pen_backup backup;
    struct pen_status st;
    if (!pen_store_backup(store, file, replace, &backup, &st))
        return pen_report(command.program, NULL, &st);
    printf("%s: %" PRId64 " jobs, %" PRId64 " bytes, from %s\n", file, backup.jobs, backup.bytes,
           store);
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
