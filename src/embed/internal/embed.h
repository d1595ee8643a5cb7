/* SPDX-License-Identifier: MIT */
/* What the files of room embed share: the contents of the opaque objects of penumbra.h. The room
 * has no door under src/; other rooms and programs use the rooms below it directly. */
#ifndef PEN_EMBED_INTERNAL_EMBED_H
#define PEN_EMBED_INTERNAL_EMBED_H

#include <fenv.h>
#include <locale.h>

#include "base/buf.h"
#include "io/document.h"
#include "penumbra.h"
#include "scene/scene.h"

struct penumbra_scene {
    struct pen_arena *arena;    /* holds what `desc` points to */
    struct pen_scene_desc desc; /* with the settings */
    struct pen_buf xml;       /* the text if it was XML, to locate errors of freezing; else empty */
    struct pen_scene *frozen; /* NULL until it is rendered first */
    enum pen_accelerator built; /* the accelerator that `frozen` was built with */
    double parse_ms, build_ms;  /* of work that no image's statistics contain yet */
};

/* What pen_embed_enter has changed in the calling thread. */
struct pen_embed_caller {
    fenv_t environment;
    locale_t plain;  /* locale "C" */
    locale_t locale; /* the caller's */
};

/* Sets the default floating-point environment and the locale "C" for the calling thread alone, so
 * that neither changes a picture or a text; pen_embed_leave restores the caller's. glibc has the
 * locale "C" as a constant, so it costs no memory and the call cannot fail. */
void pen_embed_enter(struct pen_embed_caller *caller);
void pen_embed_leave(const struct pen_embed_caller *caller);

/* Creates an error list for the caller of the public function. Returns false.
 * Fails: out of memory gives a constant list that says so. `errors` may be NULL. */
bool pen_embed_fail(struct penumbra_errors **errors, const struct pen_status *st);
bool pen_embed_fail_list(struct penumbra_errors **errors, const struct pen_errors *list);

/* Reads the members of a structure that the caller's `size` covers into *out, which is `known`
 * bytes long; the rest of *out becomes zero. Returns false if the size is less than a size_t, or if
 * a member that this version does not know is not zero. */
bool pen_embed_take(const void *given, void *out, size_t known);

/* Copies *from, which is `known` bytes long, to a structure of the caller, up to its `size`, which
 * stays. Returns false if that is less than a size_t. */
bool pen_embed_give(const void *from, size_t known, void *to);

/* A buffer's bytes as memory for penumbra_free; the buffer becomes empty. */
void *pen_embed_detach(struct pen_buf *buf);

#endif
