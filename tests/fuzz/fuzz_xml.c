/* SPDX-License-Identifier: MIT */
/* Any bytes as a scene in XML. Checks that
 *   - nothing leaks;
 *   - an accepted scene, written as JSON, is accepted again, and then written to the same bytes;
 *   - every error has a place. */
#include "fuzz/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0}, notes = {0};
    struct pen_document document;
    struct pen_scene_desc desc;
    struct pen_status st = {0};
    struct pen_arena *arena = pen_arena_new(0);
    bool parsed = pen_document_parse((const char *)data, size, true, &limits, &document, &st);
    must(parsed || (st.line > 0 && st.column > 0));
    if (parsed && pen_document_read(&document, &limits, arena, &desc, &errors)) {
        pen_scene_warnings(document.json, "", &desc, &notes);
        for (size_t i = 0; i < notes.count; i++)
            pen_document_locate(&document, &notes.item[i]);
        check_written(&document);
    } else if (parsed) {
        must(errors.count > 0);
    }
    for (size_t i = 0; i < errors.count; i++)
        must(errors.item[i].line > 0 && errors.item[i].column > 0);
    pen_document_release(&document);
    pen_arena_free(arena);
    return 0;
}
