/* SPDX-License-Identifier: MIT */
/* The part that the targets for scenes share. */
#ifndef PEN_TESTS_FUZZ_SCENE_H
#define PEN_TESTS_FUZZ_SCENE_H

#include "fuzz/fuzz.h"
#include "io/document.h"

/* Checks that an accepted scene, written as JSON, is accepted again, and then written to the same
 * bytes. */
static inline void check_written(const struct pen_document *document)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0};
    struct pen_scene_desc desc;
    struct pen_status st;
    struct pen_buf out = {0}, again = {0};
    struct pen_arena *arena = pen_arena_new(0);
    must(pen_json_write(document->json, &out));
    json_t *json = pen_json_parse((char *)out.data, out.bytes, &limits, &st);
    must(json && pen_scene_read(json, "", &limits, arena, &desc, &errors));
    must(pen_json_write(json, &again));
    must(again.bytes == out.bytes && memcmp(again.data, out.data, out.bytes) == 0);
    pen_buf_release(&again);
    json_decref(json);
    pen_arena_free(arena);
    pen_buf_release(&out);
}

#endif
