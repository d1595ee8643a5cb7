/* SPDX-License-Identifier: MIT */
/* Rows of the option tables that several subcommands share. Each macro takes the type of the
 * command's values; the member has the option's name. */
#ifndef PEN_CMD_CLIENT_COMMON_OPTIONS_H
#define PEN_CMD_CLIENT_COMMON_OPTIONS_H

#include "cmd/options.h"
#include "jobs/bench_spec.h"

#define PEN_QUIET_OPTION(values, text)                                                             \
    {                                                                                              \
        .name = "quiet", .letter = 'q', .kind = PEN_OPTION_FLAG,                                   \
        .offset = offsetof(values, quiet), .help = text                                            \
    }

#define PEN_JSON_OPTION(values, text)                                                              \
    {                                                                                              \
        .name = "json", .kind = PEN_OPTION_FLAG, .offset = offsetof(values, json), .help = text    \
    }

#define PEN_OUTPUT_OPTION(values, word, text)                                                      \
    {                                                                                              \
        .name = "output", .letter = 'o', .kind = PEN_OPTION_TEXT,                                  \
        .offset = offsetof(values, output), .value = word, .help = text                            \
    }

/* `names` is how help lists the formats, `list` the array of them. */
#define PEN_FORMAT_OPTION(values, names, list)                                                     \
    {                                                                                              \
        .name = "format", .kind = PEN_OPTION_CHOICE, .offset = offsetof(values, format),           \
        .value = names, .choices = list, .help = "the format, instead of the one that OUT ends in" \
    }

#define PEN_SET_OPTION(values)                                                                     \
    {                                                                                              \
        .name = "set", .kind = PEN_OPTION_LIST, .offset = offsetof(values, set),                   \
        .value = "KEY=VALUE", .help = "a render setting, overrides the scene's; may be repeated"   \
    }

#define PEN_VIEW_OPTION(values)                                                                    \
    {                                                                                              \
        .name = "view", .kind = PEN_OPTION_TEXT, .offset = offsetof(values, view),                 \
        .value = "NAME", .help = "which view of the scene, the first by default"                   \
    }

#define PEN_THREADS_OPTION(values, text)                                                           \
    {                                                                                              \
        .name = "threads", .kind = PEN_OPTION_INT, .offset = offsetof(values, threads),            \
        .value = "N", .max = 1024, .help = text                                                    \
    }

#define PEN_RENDER_THREADS_OPTION(values)                                                          \
    PEN_THREADS_OPTION(values, "how many render threads; 0, the default, is one per core")

/* matrix, repeats, warmup and baseline. `prefix` begins their help texts. */
#define PEN_BENCH_OPTIONS(values, prefix)                                                          \
    {.name = "matrix",                                                                             \
     .letter = 'm',                                                                                \
     .kind = PEN_OPTION_LIST,                                                                      \
     .offset = offsetof(values, matrix),                                                           \
     .value = "KEY=VALUE,…",                                                                       \
     .help = prefix "values of a render setting to compare; may be repeated, every combination "   \
                    "is a row"},                                                                   \
        {.name = "repeats",                                                                        \
         .kind = PEN_OPTION_INT,                                                                   \
         .offset = offsetof(values, repeats),                                                      \
         .value = "N",                                                                             \
         .min = 1,                                                                                 \
         .max = PEN_BENCH_REPEATS_MAX,                                                             \
         .help = prefix "timed runs of each row, 3 by default"},                                   \
        {.name = "warmup",                                                                         \
         .kind = PEN_OPTION_INT,                                                                   \
         .offset = offsetof(values, warmup),                                                       \
         .value = "N",                                                                             \
         .max = PEN_BENCH_WARMUP_MAX,                                                              \
         .help = prefix "runs of each row before the timed ones, 1 by default"},                   \
    {                                                                                              \
        .name = "baseline", .kind = PEN_OPTION_TEXT, .offset = offsetof(values, baseline),         \
        .value = "KEY=VALUE,…",                                                                    \
        .help = prefix "the row that speed-ups refer to, the first by default"                     \
    }

#endif
