/* SPDX-License-Identifier: MIT */
/* The daemon's configuration: one table of options, each also an environment variable and a key
 * of the JSON file. Command line wins over environment, environment over file, file over default;
 * every value is checked, also one that another source overrides. */
#ifndef PEN_CMD_DAEMON_CONFIG_H
#define PEN_CMD_DAEMON_CONFIG_H

#include <jansson.h>
#include <stdbool.h>

#include "base/log.h"
#include "cmd/daemon/listen.h"
#include "cmd/options.h"

struct pen_config {
    const char *listen, *store, *role, *tokens, *file, *log_file, *log_format, *log_level;
    int threads, memory_limit; /* memory_limit: MiB, 0: most of the machine's */
    /* Given by a supervisor to its children only; such a process takes nothing from environment
     * and file, since the supervisor has done so and hands everything over. */
    int listen_fd, control_fd;   /* -1: none */
    int trace_fd, dead_trace_fd; /* -1: none */
    const char *worker_name, *dead_worker, *dead_how, *dead_end;

    struct pen_address address; /* of `listen` */
    json_t *document;           /* texts from the file point into it */
    char *default_store;
};

/* What penumbrad takes. */
extern const struct pen_command pen_command_daemon;

/* Reads all sources and checks the whole. Returns -1 to go on, or the exit code to end with
 * (--help, --version, errors, which are printed). May be called again with the same arguments,
 * to look at environment and file anew. Owns: release *config in any case. */
int pen_config_load(struct pen_config *config, int argc, char **argv);
void pen_config_release(struct pen_config *config);

/* Points the log where the configuration says: level, form, file (standard error becomes it,
 * opened anew each time, so that rotated files are let go). Fails: PEN_IO. */
struct pen_log_target {
    const char *level, *format, *file; /* file NULL or "": standard error as it is */
};
bool pen_config_log(const struct pen_log_target *target, struct pen_status *st);

#endif
