/* SPDX-License-Identifier: MIT */
/* The contents of the opaque objects of penumbra.h, for the files of module embed. The module has
 * no header directly under src/embed; other modules and programs use the modules below it directly.
 */
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
    struct pen_scene *frozen; /* NULL until the first rendering */
    enum pen_accelerator built; /* the accelerator with which `frozen` was built */
    double parse_ms, build_ms;  /* times that no image's statistics contain yet */
};

/* The state of the calling thread that pen_embed_enter has changed. */
struct pen_embed_caller {
    fenv_t environment;
    locale_t plain;  /* locale "C" */
    locale_t locale; /* the caller's */
};

/* Sets the default floating-point environment and the locale "C" for the calling thread alone, so
 * that neither changes a picture or a text. The function pen_embed_leave restores the caller's. In
 * glibc the locale "C" is a constant, so it takes no memory and the call cannot fail. */
void pen_embed_enter(struct pen_embed_caller *caller);
void pen_embed_leave(const struct pen_embed_caller *caller);

/* Creates an error list for the caller of the public function. Returns false. `errors` may be NULL.
 * Fails: out of memory gives a constant list that says so. */
bool pen_embed_fail(struct penumbra_errors **errors, const struct pen_status *st);
bool pen_embed_fail_list(struct penumbra_errors **errors, const struct pen_errors *list);

/* Copies the members of a structure that the caller's `size` covers to *out, which is `known` bytes
 * long. The rest of *out becomes zero. Returns false if the size is less than a size_t, or if a
 * member that this version does not know is not zero. */
bool pen_embed_take(const void *given, void *out, size_t known);

/* Copies *from, which is `known` bytes long, to a structure of the caller, up to its `size`, which
 * is not changed. Returns false if that is less than a size_t. */
bool pen_embed_give(const void *from, size_t known, void *to);

/* The buffer's bytes as memory for penumbra_free. The buffer becomes empty. */
void *pen_embed_detach(struct pen_buf *buf);

#endif
