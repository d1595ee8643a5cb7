/* SPDX-License-Identifier: MIT */
/* Hashes of pictures and scenes. */
#ifndef PEN_STUDY_HASH_H
#define PEN_STUDY_HASH_H

#include "film/film.h"

/* The seed of an audit: the first 8 bytes of the SHA-256 of a film's pixels. The pixels are hashed
 * as binary32 values, row by row from the top. Each bit of the picture changes the seed, so the
 * seed cannot be known before the picture is finished. */
uint64_t pen_audit_seed(const struct pen_film *film);

/* The SHA-256 of a text, in hexadecimal digits. */
enum { PEN_HASH_TEXT_BYTES = 65 };
void pen_hash_text(const void *text, size_t bytes, char out[PEN_HASH_TEXT_BYTES]);

#endif
