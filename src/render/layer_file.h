/* SPDX-License-Identifier: MIT */
/* Layers as files. */
#ifndef PEN_RENDER_LAYER_FILE_H
#define PEN_RENDER_LAYER_FILE_H

#include "base/buf.h"
#include "film/film.h"
#include "render/layers.h"

/* Appends the file of a layer, which is in film->rgb, as "png", "png16" or "pfm". PFM has the
 * numbers. PNG has the picture that pen_layer_show makes of them, in place. Its Description states
 * the number that white represents; *white is that number, else 0.
 * Fails: PEN_NO_MEMORY. */
bool pen_layer_encode(const struct pen_layer_task *task, const struct pen_film *film,
                      const char *format, struct pen_buf *out, double *white,
                      struct pen_status *st);

#endif
