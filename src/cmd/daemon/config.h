/* SPDX-License-Identifier: MIT */
/* The daemon's configuration: one table of options. Each option is also an environment variable and
 * a key of the JSON file. The command line overrides the environment, which overrides the file,
 * which overrides the defaults. Every value is checked, even if another source overrides it. */
#ifndef PEN_CMD_DAEMON_CONFIG_H
#define PEN_CMD_DAEMON_CONFIG_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/log.h"
#include "cmd/daemon/access.h"
#include "cmd/daemon/listen.h"
#include "cmd/options.h"

/* Bounds of jobs that the operator sets. 0 means no bound, the bound of pen_limits_default, or what
 * the help of its option says. */
struct pen_job_limits {
    int timeout; /* seconds */
    int seconds; /* longest expected time */
    int pixels;  /* of a view */
    int samples; /* of a pixel */
    int priority;
    int queue, client_queue; /* queued and running jobs: in all, of one address */
};

struct pen_config {
    const char *listen; /* NULL under --role worker */
    const char *store, *role, *file, *log_file, *log_format, *log_level;
    struct pen_access access;
    int threads, memory_limit; /* memory_limit: MiB; 0: three quarters of the machine's */
    struct pen_job_limits max; /* what a job may ask for */
    int keep_days, keep_jobs;  /* 0: without limit */
    const char *keep_bytes;    /* a number of bytes, with K, M, G or T; NULL: without limit */
    int until_idle;            /* seconds without work after which a worker ends; 0: never */
    /* From a supervisor to a child, on its command line. All members above are in the child's
     * environment (pen_options_to_env). */
    int control_fd;              /* -1: this process is no child */
    int listen_fd;               /* of an api; -1: none */
    int trace_fd, dead_trace_fd; /* -1: none */
    int signal_slot;             /* see pen_store_signals_join */
    const char *worker_name;     /* a worker's id in the store */
    /* Of the worker's predecessor: its id, its end as text, and "crashed" or "died". NULL: none. */
    const char *dead_worker, *dead_how, *dead_end;

    int64_t keep_bytes_max;     /* keep_bytes as a number; 0: without limit */
    struct pen_address address; /* of `listen` */
    json_t *document;           /* the file; texts of the configuration point into it */
    char *default_store;
};

/* The options of penumbrad. */
extern const struct pen_command pen_command_daemon;

/* Reads all sources and checks every value. Returns -1 if the program should continue. Otherwise it
 * has printed help, version or errors, and returns the exit code. It may be called again with the
 * same arguments, to read environment and file again.
 * Owns: release *config in any case. */
int pen_config_load(struct pen_config *config, int argc, char **argv);
void pen_config_release(struct pen_config *config);

/* Return true if the role serves HTTP, and if it renders. At least one of them is true. */
bool pen_config_serves(const struct pen_config *config);
bool pen_config_renders(const struct pen_config *config);

/* Finds the store as the daemon does, for a command beside it. The command may name the store or
 * the daemon's configuration file (NULL: neither). Returns as pen_config_load.
 * Owns: release *config in any case. */
int pen_config_find_store(const char *store, const char *file, struct pen_config *config);

struct pen_log_target {
    const char *level, *format, *file; /* file NULL or "": standard error as it is */
};

/* Sets the log's level, format and file. Each call opens the file again, so a rotated file is
 * closed. Standard error then writes to the file.
 * Fails: PEN_IO. */
bool pen_config_log(const struct pen_log_target *target, struct pen_status *st);

#endif
