/* SPDX-License-Identifier: MIT */
/* `penumbra bench --history DIR`: the reports of a folder as a history. */
#ifndef PEN_CMD_CLIENT_BENCH_HISTORY_H
#define PEN_CMD_CLIENT_BENCH_HISTORY_H

#include <stdbool.h>

#include "cmd/options.h"

struct pen_bench_history {
    const char *folder;
    const char *scene; /* only reports of this scene; NULL: all must be of one scene */
    const struct pen_option_list *output; /* files, .html or .json */
    double least_effect;
    bool json, quiet;
};

/* Reads the files of the folder that end in .json, and writes the history of the reports of
 * benchmarks among them. Names the other files on standard error. Returns the exit code. */
int pen_bench_history(const struct pen_bench_history *history);

#endif
