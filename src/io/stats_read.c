/* SPDX-License-Identifier: MIT */
/* Reads the data to repeat a render that a deadline ended, from its statistics. */
#include <string.h>

#include "io/scene_json.h"
#include "io/stats_json.h"

static bool fail_missing(const char *what, struct pen_status *st)
{
    return pen_fail(st, PEN_INVALID,
                    "has no %s: these are not the statistics of a render with a budget", what);
}

static bool read_round(const json_t *json, struct pen_round *round)
{
    const json_t *level = json_object_get(json, "level"), *tiles = json_object_get(json, "tiles"),
                 *pixels = json_object_get(json, "pixels");
    round->level = (int)json_integer_value(level);
    round->tiles = (int)json_integer_value(tiles);
    round->pixels = (uint64_t)json_integer_value(pixels);
    return json_is_integer(level) && json_is_integer(tiles) && json_is_integer(pixels) &&
           round->level >= 0 && json_integer_value(tiles) >= 0;
}

bool pen_stats_rounds_read(const json_t *stats, const char *scene_sha256,
                           struct pen_settings *settings, struct pen_adaptive_stats *rounds,
                           struct pen_status *st)
{
    const json_t *render = json_object_get(stats, "render");
    const char *sha256 = json_string_value(json_object_get(stats, "scene_sha256"));
    const json_t *list = json_object_get(json_object_get(stats, "adaptive"), "rounds");
    const size_t count = json_array_size(list);
    /* Statistics of the first rule have no number. */
    const json_t *number = json_object_get(json_object_get(stats, "adaptive"), "rule");
    const json_int_t rule = number ? json_integer_value(number) : 1;
    struct pen_errors errors = {0};
    *rounds = (struct pen_adaptive_stats){.timed = true, .rounds = (int)count};
    if (!sha256 || !render)
        return fail_missing(sha256 ? "render" : "scene_sha256", st);
    if (count < 1 || count > PEN_ROUNDS_MAX)
        return fail_missing("adaptive.rounds", st);
    if (rule != PEN_ADAPTIVE_RULE)
        return pen_fail(st, PEN_CONFLICT,
                        "has the rounds of rule %lld for a target error; this version has rule %d, "
                        "which gives other pictures",
                        (long long)rule, PEN_ADAPTIVE_RULE);
    for (size_t i = 0; i < count; i++)
        if (!read_round(json_array_get(list, i), &rounds->round[i]))
            return fail_missing("level, tiles and pixels in a round", st);
    if (!pen_settings_read(render, "/render", settings, &errors))
        return pen_fail(st, PEN_INVALID, "at %s: %s", errors.item[0].at, errors.item[0].msg);
    return strcmp(sha256, scene_sha256) == 0 ||
           pen_fail(st, PEN_CONFLICT,
                    "is of another scene: its SHA-256 is %.16s…, that of the scene given %.16s…",
                    sha256, scene_sha256);
}
