/* SPDX-License-Identifier: MIT */
/* Reads a scene of any size from standard input, because the benchmarks' scenes may exceed the
 * limits of the programs. */
#ifndef BENCH_LOAD_SCENE_H
#define BENCH_LOAD_SCENE_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "io/scene_json.h"

_Noreturn static inline void bench_fail(const char *what)
{
    fprintf(stderr, "not done: %s\n", what);
    exit(1);
}

static inline char *bench_read(size_t *bytes)
{
    size_t capacity = 1 << 20;
    char *text = malloc(capacity);
    *bytes = 0;
    while (text) {
        *bytes += fread(text + *bytes, 1, capacity - *bytes, stdin);
        if (*bytes < capacity)
            return text;
        char *more = realloc(text, capacity *= 2);
        if (!more)
            free(text);
        text = more;
    }
    bench_fail("out of memory");
}

/* Reads a scene; ends the program if the text is no scene.
 * Owns: the arena has everything that the description points to. */
static inline struct pen_scene_desc bench_load(const char *text, size_t bytes,
                                               struct pen_arena *arena)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0};
    struct pen_scene_desc desc;
    limits.body_bytes = limits.parsed_bytes = SIZE_MAX;
    limits.objects = UINT32_MAX;
    if (!arena || !pen_scene_load(text, bytes, &limits, arena, &desc, &errors))
        bench_fail("not a scene; `penumbra validate` says why");
    return desc;
}

#endif
