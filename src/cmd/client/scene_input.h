/* SPDX-License-Identifier: MIT */
/* The scene that a command without a daemon renders: the document and its description. */
#ifndef PEN_CMD_CLIENT_SCENE_INPUT_H
#define PEN_CMD_CLIENT_SCENE_INPUT_H

#include "cmd/files.h"

struct pen_scene_input {
    struct pen_source source;
    struct pen_arena *arena;
    struct pen_scene_desc desc; /* in the arena */
    double parse_ms;            /* from text to description, without reading the file */
};

/* Reads the scene `name`: a path, `-`, or `builtin:NAME`. Owns: release *input in any case.
 * Fails: returns false with errors->count > 0; input->source.label names the document. */
bool pen_scene_input_read(struct pen_scene_input *input, const char *name,
                          struct pen_errors *errors);

/* The index of the view of that name. Returns -1 after PEN_NOT_FOUND, with the nearest name. */
int pen_scene_input_view(const struct pen_scene_input *input, const char *name,
                         struct pen_status *st);

/* Prints what the reader has noted about the scene, as warnings on standard error. */
void pen_scene_input_warn(const struct pen_scene_input *input);

void pen_scene_input_release(struct pen_scene_input *input);

#endif
