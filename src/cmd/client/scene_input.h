/* SPDX-License-Identifier: MIT */
/* The scene that a command renders without a daemon: the document and its description. */
#ifndef PEN_CMD_CLIENT_SCENE_INPUT_H
#define PEN_CMD_CLIENT_SCENE_INPUT_H

#include "cmd/files.h"

struct pen_scene_input {
    struct pen_source source;
    struct pen_arena *arena;
    struct pen_scene_desc desc; /* in the arena */
    double parse_ms; /* of making the description from the text, or from the model's file */
};

/* Reads the scene `name`: the path of a scene or a model, `-`, or `builtin:NAME`. `options` may be
 * NULL.
 * Owns: release *input in any case.
 * Fails: false with errors->count > 0; input->source.label names the document. */
bool pen_scene_input_read(struct pen_scene_input *input, const char *name,
                          const struct pen_model_options *options, struct pen_errors *errors);

/* Returns the index of the view of that name.
 * Fails: -1 and PEN_NOT_FOUND, with the nearest name. */
int pen_scene_input_view(const struct pen_scene_input *input, const char *name,
                         struct pen_status *st);

/* Prints the reader's notes about the scene, as warnings on standard error. */
void pen_scene_input_warn(const struct pen_scene_input *input);

void pen_scene_input_release(struct pen_scene_input *input);

#endif
