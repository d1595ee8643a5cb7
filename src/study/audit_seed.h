/* SPDX-License-Identifier: MIT */
/* The seed of an audit. */
#ifndef PEN_STUDY_AUDIT_SEED_H
#define PEN_STUDY_AUDIT_SEED_H

#include "film/film.h"

/* The first 8 bytes of the SHA-256 of a film's pixels: binary32 values, row by row from the top. It
 * changes with every bit of them, so that nobody knows it before the picture is done. */
uint64_t pen_audit_seed(const struct pen_film *film);

#endif
