/* SPDX-License-Identifier: MIT */
/* Reports of earlier benchmarks: reading them from files and daemons, and comparing two reports. */
#ifndef PEN_CMD_CLIENT_REPORT_SOURCE_H
#define PEN_CMD_CLIENT_REPORT_SOURCE_H

#include <jansson.h>
#include <stdbool.h>

#include "cmd/client/http_client.h"

/* Reads a report of a benchmark. `name` is a file, -, or the URL of a job or of its report
 * (http://HOST/v1/jobs/ID). It may also be a job's id, which is looked up at the daemon `remote`
 * (NULL: an id is a file's name). The token is sent only to remote->server.
 * Owns: the caller calls json_decref() for *report.
 * Fails: as pen_source_read, pen_client_json, pen_comparison_check. */
bool pen_report_source_read(const char *name, const struct pen_remote *remote, json_t **report,
                            struct pen_errors *errors);

/* Returns true if a file begins like a JSON object. */
bool pen_report_source_is_json(const char *path);

struct pen_report_compare {
    const char *before, *after; /* files */
    bool time;                  /* a slower row counts as a difference too */
    bool json, quiet;
};

/* Compares two reports and prints the result. Returns the exit code. */
int pen_report_compare(const struct pen_report_compare *compare);

#endif
