/* SPDX-License-Identifier: MIT */
/* A benchmark that a daemon runs. Makes its job, follows it to its end and fetches its report. */
#ifndef PEN_CMD_CLIENT_BENCH_REMOTE_H
#define PEN_CMD_CLIENT_BENCH_REMOTE_H

#include "cmd/client/http_client.h"
#include "cmd/files.h"

struct pen_bench_remote {
    struct pen_client *client;
    struct pen_source *source; /* a scene, checked */
    const json_t *members;     /* of the job, without the scene */
    bool quiet, json;          /* values of these options */
};

/* Runs the benchmark. Prints errors and, unless quiet, the job's id on standard error. If the job
 * fails, the exit code is that of the same failure in this process. If this process is ended, the
 * job continues. Returns the exit code.
 * Owns: the caller calls json_decref() for *report. */
int pen_bench_remote_run(const struct pen_bench_remote *remote, json_t **report);

#endif
