/* SPDX-License-Identifier: MIT */
/* What a program says on its way out: errors as one line each on standard error, and as a problem
 * document on standard output where --json asks for it; the exit code is the error's. */
#ifndef PEN_CMD_REPORT_H
#define PEN_CMD_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/buf.h"
#include "base/status.h"

/* Prints `PROGRAM: FILE: place: message`; file may be NULL. Returns the exit code. */
int pen_report(const char *program, const char *file, const struct pen_status *st);

/* Prints every error kept, and how many there are besides. Returns the first one's exit code. */
int pen_report_errors(const char *program, const char *file, const struct pen_errors *errors);

/* As pen_report and pen_report_errors, with the problem document on standard output if json. */
int pen_report_json(const char *file, bool json, const struct pen_status *st);
int pen_report_errors_json(const char *file, bool json, const struct pen_errors *errors);

/* Prints one JSON value as a line on standard output, and drops the caller's reference. Numbers
 * have 15 digits: what was rounded to thousandths looks it. pen_report_exact writes 17, which
 * read back are the same doubles. */
void pen_report_line(json_t *value);
void pen_report_exact(json_t *value);

/* A JSON value as lines for people to read, ending in a line feed. Fails: PEN_NO_MEMORY. */
bool pen_report_text(const json_t *value, struct pen_buf *out, struct pen_status *st);

/* "penumbra 0.1.0" on standard output. */
void pen_report_version(const char *program);

/* The table of exit codes, for --help. */
void pen_report_exit_codes(FILE *out);

/* Flushes standard output. Returns `code`, or an error's exit code if what was printed got lost.
 */
int pen_report_finish(const char *program, int code);

#endif
