/* SPDX-License-Identifier: MIT */
/* `penumbra bench --history DIR`: the reports of a folder as a history. */
#ifndef PEN_CMD_CLIENT_BENCH_HISTORY_H
#define PEN_CMD_CLIENT_BENCH_HISTORY_H

#include "cmd/client/report_output.h"

struct pen_bench_history {
    const char *folder;
    const char *scene; /* only reports of this scene; NULL: all must be of one scene */
    struct pen_report_output output;
    double least_effect;
};

/* Reads the files of the folder that end in .json, and writes the history of the reports of
 * benchmarks among them. Names the other files on standard error. Returns the exit code. */
int pen_bench_history(const struct pen_bench_history *history);

#endif
