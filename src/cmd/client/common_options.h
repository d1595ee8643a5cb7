/* SPDX-License-Identifier: MIT */
/* Rows of the option tables that several subcommands share. Each macro takes the type of the
 * command's values; the member has the name of the option. */
#ifndef PEN_CMD_CLIENT_COMMON_OPTIONS_H
#define PEN_CMD_CLIENT_COMMON_OPTIONS_H

#include <limits.h>

#include "cmd/options.h"
#include "jobs/accuracy_spec.h"
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

/* `names` is the list of formats for help, `list` the array of formats. */
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

/* The values of a benchmark's options. A number below 0 was not given. */
struct pen_bench_values {
    struct pen_option_list matrix, baseline;
    int repeats, warmup, order_seed;
    double interval, budget, least_effect;
};

#define PEN_BENCH_VALUES                                                                           \
    {                                                                                              \
        .repeats = -1, .warmup = -1, .order_seed = -1, .interval = -1, .budget = -1,               \
        .least_effect = -1                                                                         \
    }

/* The options of a benchmark; `values` has them in a member `bench`. Their help texts begin with
 * `prefix`, and that of --budget with `budget_text`. `baseline_text` is added to the help of
 * --baseline. */
#define PEN_BENCH_OPTIONS(values, prefix, baseline_text, budget_text)                              \
    {.name = "matrix",                                                                             \
     .letter = 'm',                                                                                \
     .kind = PEN_OPTION_LIST,                                                                      \
     .offset = offsetof(values, bench.matrix),                                                     \
     .value = "KEY=VALUE,…",                                                                       \
     .help = prefix "values of a render setting to compare; may be repeated, every combination "   \
                    "is a row"},                                                                   \
        {.name = "repeats",                                                                        \
         .kind = PEN_OPTION_INT,                                                                   \
         .offset = offsetof(values, bench.repeats),                                                \
         .value = "N",                                                                             \
         .min = 1,                                                                                 \
         .max = PEN_BENCH_REPEATS_MAX,                                                             \
         .help = prefix "timed runs of each row, 3 by default"},                                   \
        {.name = "warmup",                                                                         \
         .kind = PEN_OPTION_INT,                                                                   \
         .offset = offsetof(values, bench.warmup),                                                 \
         .value = "N",                                                                             \
         .max = PEN_BENCH_WARMUP_MAX,                                                              \
         .help = prefix "runs of each row before the timed ones, 1 by default"},                   \
        {.name = "interval",                                                                       \
         .kind = PEN_OPTION_NUMBER,                                                                \
         .offset = offsetof(values, bench.interval),                                               \
         .value = "W",                                                                             \
         .max = 1,                                                                                 \
         .help = prefix "instead of --repeats: run until the 95 % interval of each row's ratio "   \
                        "to the baseline is at most W wide (0.02 with --budget alone)"},           \
        {.name = "budget",                                                                         \
         .kind = PEN_OPTION_NUMBER,                                                                \
         .offset = offsetof(values, bench.budget),                                                 \
         .value = "SECONDS",                                                                       \
         .max = PEN_BENCH_BUDGET_MAX_S,                                                            \
         .help = budget_text "with --interval: begin no run later than this, 60 by default"},      \
        {.name = "least-effect",                                                                   \
         .kind = PEN_OPTION_NUMBER,                                                                \
         .offset = offsetof(values, bench.least_effect),                                           \
         .value = "E",                                                                             \
         .max = 1,                                                                                 \
         .help = prefix "the smallest difference that makes a row faster or slower, 0.02 (2 %) "   \
                        "by default"},                                                             \
        {.name = "order-seed",                                                                     \
         .kind = PEN_OPTION_INT,                                                                   \
         .offset = offsetof(values, bench.order_seed),                                             \
         .value = "N",                                                                             \
         .max = INT_MAX,                                                                           \
         .help = prefix "seed of the random order of runs; by default a new seed each time"},      \
    {                                                                                              \
        .name = "baseline", .kind = PEN_OPTION_LIST, .offset = offsetof(values, bench.baseline),   \
        .value = "KEY=VALUE,…",                                                                    \
        .help = prefix "the row that speed-ups refer to, the first by default" baseline_text       \
    }

/* The values of an accuracy study's options. */
struct pen_accuracy_values {
    struct pen_option_list ladder, reference;
    const char *target;
    int seeds; /* below 0: not given */
    bool product;
};

/* The options of an accuracy study, without the budget; `values` has them in a member `accuracy`.
 * Their help texts begin with `prefix`. */
#define PEN_ACCURACY_OPTIONS(values, prefix)                                                       \
    {.name = "ladder",                                                                             \
     .kind = PEN_OPTION_LIST,                                                                      \
     .offset = offsetof(values, accuracy.ladder),                                                  \
     .value = "KEY=VALUE,…",                                                                       \
     .help = prefix "values of a setting to try one at a time; may be repeated. By default the "   \
                    "kinds of samples that the scene calls for"},                                  \
        {.name = "product",                                                                        \
         .kind = PEN_OPTION_FLAG,                                                                  \
         .offset = offsetof(values, accuracy.product),                                             \
         .help = prefix "try every combination of the values"},                                    \
        {.name = "reference",                                                                      \
         .kind = PEN_OPTION_LIST,                                                                  \
         .offset = offsetof(values, accuracy.reference),                                           \
         .value = "KEY=VALUE",                                                                     \
         .help = prefix "a setting of the reference, which otherwise has 8 to 128 times the "      \
                        "samples of the longest row; may be repeated"},                            \
        {.name = "target",                                                                         \
         .kind = PEN_OPTION_TEXT,                                                                  \
         .offset = offsetof(values, accuracy.target),                                              \
         .value = "METRIC=VALUE",                                                                  \
         .help = prefix                                                                            \
         "the error that the cheapest row must meet, flip=0.02 by default; metrics are "           \
         "rmse, relative_mse, psnr, ssim, flip, max_error"},                                       \
    {                                                                                              \
        .name = "seeds", .kind = PEN_OPTION_INT, .offset = offsetof(values, accuracy.seeds),       \
        .value = "N", .min = 1, .max = PEN_ACCURACY_SEEDS_MAX,                                     \
        .help = prefix "runs of each row, with different seeds, 5 by default"                      \
    }

#endif
