/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/cmd_check.h"

#include <stdio.h>

#include "cmd/daemon/config.h"
#include "cmd/report.h"
#include "store/store.h"

struct settings {
    const char *store, *config;
};

static const struct pen_option options[] = {
    {.name = "store",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct settings, store),
     .value = "FILE",
     .env = "PENUMBRA_STORE",
     .help = "the store to check; the daemon's by default"},
    {.name = "config",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct settings, config),
     .value = "FILE",
     .env = "PENUMBRA_CONFIG",
     .help = "the daemon's configuration file, which may name the store"},
    {0}};

static const struct pen_command command = {
    .program = "penumbrad",
    .name = "check",
    .arguments = "",
    .summary = "Looks for damage in the whole store, even while a daemon uses it.",
    .details =
        "Reads every page of the database. The exit code is 8 if it is damaged; the message "
        "names the first damage found. A daemon does the same when it starts, but only for a "
        "third of a second.",
    .options = options,
    .max_args = 0,
};

static int check(const char *path)
{
    struct pen_status st;
    bool finished;
    struct pen_store *store = pen_store_open(path, false, &st);
    const bool ok = store && pen_store_check(store, 0, &finished, &st);
    pen_store_close(store);
    if (!ok)
        return pen_report(command.program, NULL, &st);
    pen_report_say(stdout, "%s: no damage found", path);
    return 0;
}

int pen_check_command(int argc, char **argv)
{
    struct settings settings = {0};
    struct pen_parsed parsed;
    struct pen_config config;
    int code = pen_command_begin(&command, argc, argv, &settings, &parsed);
    if (code >= 0)
        return code;
    code = pen_config_find_store(settings.store, settings.config, &config);
    if (code < 0)
        code = check(config.store);
    pen_config_release(&config);
    return code;
}
