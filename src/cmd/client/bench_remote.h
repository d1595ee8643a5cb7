/* SPDX-License-Identifier: MIT */
/* A benchmark that a daemon runs: makes its job, follows it to its end and fetches its report. */
#ifndef PEN_CMD_CLIENT_BENCH_REMOTE_H
#define PEN_CMD_CLIENT_BENCH_REMOTE_H

#include "cmd/client/http_client.h"
#include "cmd/files.h"

struct pen_bench_remote {
    struct pen_client *client;
    const struct pen_source *source; /* a scene, checked */
    const json_t *members;           /* of the job, but for the scene */
    bool quiet, json;                /* as the options */
};

/* Runs the benchmark; prints the job's id on standard error unless quiet, and errors. A job that
 * failed ends in the exit code of the same failure in this process. If this process is ended, the
 * job goes on. Owns: the caller json_decref()s *report. Returns the exit code. */
int pen_bench_remote_run(const struct pen_bench_remote *remote, json_t **report);

#endif
