/* SPDX-License-Identifier: MIT */
/* Encodes a film as a file. An 8- or 16-bit code is floor(max * clamp(encode(v)) + 0.5), where
 * encode is the sRGB transfer function or the identity.
 *
 *   transfer   encode    the PNG says         so a screen shows
 *   srgb       sRGB      sRGB                 the light of the value
 *   linear     identity  gamma 1              the same, in fewer steps
 *   display    identity  sRGB, and a text     the value itself, as in programs whose colours are
 *                        transfer=display     those of the screen
 *
 * The bytes of a file are a pure function of the pixels and the options: there are no time stamps,
 * and the compression is fixed. */
#ifndef PEN_FILM_ENCODE_H
#define PEN_FILM_ENCODE_H

#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "base/status.h"
#include "film/film.h"

enum pen_transfer { PEN_TRANSFER_SRGB, PEN_TRANSFER_LINEAR, PEN_TRANSFER_DISPLAY };

/* The text chunk of a PNG file whose codes are screen values. */
#define PEN_TRANSFER_KEY "transfer"
#define PEN_TRANSFER_TEXT "display"

/* The sRGB transfer function (IEC 61966-2-1) of a linear value, not clamped. Error: below 1e-15 for
 * values up to 1. */
double pen_encode_srgb(double linear);

/* The inverse of pen_encode_srgb. */
double pen_decode_srgb(double encoded);

/* encode(v) clamped to [0, 1]; 0 for NaN. */
double pen_encode_unit(double linear, enum pen_transfer transfer);

/* The same within 5e-9, without computing a power, for error estimates. */
double pen_encode_unit_near(double linear, enum pen_transfer transfer);

/* Encodes `count` values as codes of 8 or of 16 bits, by the formula above.
 * Cost: an 8-bit code takes about 3 ns, by a table of the exact steps. A 16-bit code takes about 5
 * ns; one in a thousand takes a pen_pow. */
void pen_encode_8(const float *linear, size_t count, enum pen_transfer transfer,
                  unsigned char *out);
void pen_encode_16(const float *linear, size_t count, enum pen_transfer transfer, uint16_t *out);

struct pen_png_options {
    int bits; /* 8 or 16 */
    enum pen_transfer transfer;
    /* width * height values; 0 for a pixel that is not rendered yet. With a mask the file has an
     * alpha channel: these pixels are transparent black, all others opaque. NULL: no alpha channel.
     */
    const unsigned char *mask;
    const char *description; /* ASCII, for a text chunk of that name; NULL: none */
};

/* A PNG file whose rows are written when they are finished, from the top. Its bytes do not depend
 * on the number of rows that are written at a time.
 * Threads: one call at a time; each may come from another thread. */
struct pen_png_writer;

/* Begins a file, which is appended to `out`. The film's pixels, the mask and `out` must stay valid
 * until pen_png_free; pixels are read when their row is written.
 * Owns: free with pen_png_free, also to abandon a file.
 * Fails: NULL; PEN_NO_MEMORY. */
struct pen_png_writer *pen_png_begin(const struct pen_film *film,
                                     const struct pen_png_options *options, struct pen_buf *out,
                                     struct pen_status *st);

/* Writes the rows before row `end` that are not written yet. pen_png_end reports errors. */
void pen_png_rows(struct pen_png_writer *writer, int end);

/* Writes the rest of the file.
 * Fails: PEN_NO_MEMORY, PEN_INTERNAL, also from earlier calls; `out` may then hold a part of the
 * file. */
bool pen_png_end(struct pen_png_writer *writer, struct pen_status *st);

/* Frees a writer. NULL is allowed. */
void pen_png_free(struct pen_png_writer *writer);

/* Appends a PNG file of a finished film to `out`.
 * Fails: PEN_NO_MEMORY, PEN_INTERNAL; `out` may then hold a part of the file. */
bool pen_png_write(const struct pen_film *film, const struct pen_png_options *options,
                   struct pen_buf *out, struct pen_status *st);

/* Appends a PFM file: the film's own values, little-endian, bottom row first.
 * Fails: as pen_png_write. */
bool pen_pfm_write(const struct pen_film *film, struct pen_buf *out, struct pen_status *st);

/* Writes the same file in the memory of the film, for large pictures. pen_pfm_begin fills `out`,
 * which is empty, and makes `film` refer to the pixels in it, which are not set yet. The caller
 * sets all of them. Then pen_pfm_end gives them the order of the file.
 * Owns: the caller releases `out`, which contains the film's pixels.
 * Fails: as pen_film_new; pen_pfm_end: PEN_NO_MEMORY (one row). */
bool pen_pfm_begin(int width, int height, struct pen_buf *out, struct pen_film *film,
                   struct pen_status *st);
bool pen_pfm_end(struct pen_film *film, struct pen_buf *out, struct pen_status *st);

#endif
