/* SPDX-License-Identifier: MIT */
/* The options --budget and --repeat of `penumbra render`, and its line about a target error. */
#ifndef PEN_CMD_CLIENT_ROUNDS_OPTIONS_H
#define PEN_CMD_CLIENT_ROUNDS_OPTIONS_H

#include "cmd/client/scene_input.h"
#include "cmd/options.h"
#include "render/render.h"
#include "study/hash.h"

#define PEN_ROUNDS_OPTIONS(values)                                                                 \
    {.name = "budget",                                                                             \
     .kind = PEN_OPTION_NUMBER,                                                                    \
     .offset = offsetof(values, budget),                                                           \
     .value = "SECONDS",                                                                           \
     .max = 1e6,                                                                                   \
     .help = "make the best picture in this time. Two such renders differ, but --repeat makes "    \
             "the same picture from the --stats of the first"},                                    \
    {                                                                                              \
        .name = "repeat", .kind = PEN_OPTION_TEXT, .offset = offsetof(values, repeat),             \
        .value = "STATS",                                                                          \
        .help =                                                                                    \
            "repeat a render with a budget from its statistics: the picture has the same bytes"    \
    }

/* The rounds of a render that the options ask for. */
struct pen_rounds_wanted {
    int64_t deadline_ns;               /* with --budget; else 0 */
    struct pen_adaptive_stats *repeat; /* with --repeat; free() it */
    char scene_sha256[PEN_HASH_TEXT_BYTES];
};

/* Reads the options, and changes the scene's settings accordingly. A `budget` below 0 and a
 * `repeat` of NULL were not given; start_ns is when the command began.
 * Fails: PEN_INVALID, PEN_CONFLICT, and as reading a file; the message names the option. */
bool pen_rounds_begin(struct pen_rounds_wanted *rounds, struct pen_scene_input *input,
                      double budget, const char *repeat, int64_t start_ns, struct pen_status *st);

/* Prints on standard error how good a picture is. If it misses its target, this is a warning; else
 * it is printed unless quiet. */
void pen_rounds_tell(const struct pen_adaptive_stats *adaptive, const char *label, const char *view,
                     bool quiet);

#endif
