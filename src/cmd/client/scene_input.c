/* SPDX-License-Identifier: MIT */
#include "cmd/client/scene_input.h"

#include <string.h>

#include "base/clock.h"
#include "cmd/report.h"
#include "io/message.h"

/* If the document is a job, reports that, instead of what it lacks to be a scene. */
static void explain_job(const struct pen_source *source, struct pen_errors *errors)
{
    bool job = false;
    for (size_t i = 0; i < errors->count && !source->xml; i++)
        job = job || strcmp(errors->item[i].at, "/scene") == 0;
    if (!job)
        return;
    *errors = (struct pen_errors){0};
    struct pen_status st;
    pen_fail_at(&st, PEN_INVALID, "/scene",
                "must be a scene, found a job, which has one; `penumbra submit` takes jobs");
    pen_errors_add(errors, &st);
}

bool pen_scene_input_read(struct pen_scene_input *input, const char *name,
                          const struct pen_model_options *options, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    *input = (struct pen_scene_input){0};
    int64_t start_ns = pen_clock_ns();
    bool ok = pen_source_read_scene(&input->source, name, options, &st);
    if (ok && !(input->arena = pen_arena_new(0)))
        ok = pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    if (!ok) {
        pen_errors_add(errors, &st);
        return false;
    }
    if (!input->source.models.known_name)
        start_ns = pen_clock_ns();
    ok = pen_source_scene(&input->source, &limits, input->arena, &input->desc, errors);
    input->parse_ms = (double)(pen_clock_ns() - start_ns) * 1e-6;
    if (!ok)
        explain_job(&input->source, errors);
    return ok;
}

int pen_scene_input_view(const struct pen_scene_input *input, const char *name,
                         struct pen_status *st)
{
    enum { NAMES_MAX = 64 }; /* names that a misspelt name is compared with */
    const char *names[NAMES_MAX + 1] = {NULL};
    for (uint32_t i = 0; i < input->desc.view_count; i++) {
        if (strcmp(input->desc.views[i].name, name) == 0)
            return (int)i;
        if (i < NAMES_MAX)
            names[i] = input->desc.views[i].name;
    }
    const char *near = pen_nearest_name(name, names);
    pen_fail(st, PEN_NOT_FOUND, "no view \"%s\", %s is \"%s\"", name,
             near ? "nearest" : "the first", near ? near : names[0]);
    return -1;
}

void pen_scene_input_warn(const struct pen_scene_input *input)
{
    for (uint32_t i = 0; i < input->desc.note_count; i++) {
        const struct pen_status *note = &input->desc.notes[i];
        if (note->line > 0)
            pen_report_say(stderr, "penumbra: %s:%d:%d: warning: %s", input->source.label,
                           note->line, note->column, note->msg);
        else
            pen_report_say(stderr, "penumbra: %s: %s: warning: %s", input->source.label, note->at,
                           note->msg);
    }
}

void pen_scene_input_release(struct pen_scene_input *input)
{
    pen_arena_free(input->arena);
    pen_source_release(&input->source);
}
