/* SPDX-License-Identifier: MIT */
/* The output of the programs: errors as one line each on standard error and, with --json, as a
 * problem document on standard output; JSON; the version; the table of exit codes. */
#ifndef PEN_CMD_REPORT_H
#define PEN_CMD_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/buf.h"
#include "base/status.h"

/* Prints `PROGRAM: FILE: place: message`; file may be NULL. Returns the error's exit code. */
int pen_report(const char *program, const char *file, const struct pen_status *st);

/* Prints every error of the list, and how many more there were. Returns the exit code of the first.
 */
int pen_report_errors(const char *program, const char *file, const struct pen_errors *errors);

/* The same for the program penumbra, with the problem document on standard output if `json`. */
int pen_report_json(const char *file, bool json, const struct pen_status *st);
int pen_report_errors_json(const char *file, bool json, const struct pen_errors *errors);

/* Prints formatted text as one line, with a line feed behind it, as it may be shown on a terminal:
 * names from scenes, files and servers cannot control it (base/utf8.h). pen_report_show prints a
 * text of several lines so. */
void pen_report_say(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
void pen_report_show(FILE *out, const char *text);

/* Prints a JSON value as one line on standard output. Numbers have 15 digits, so that a value
 * rounded to thousandths is printed as such; pen_report_exact prints 17, which read back as the
 * same doubles. Owns: takes over the caller's reference. */
void pen_report_line(json_t *value);
void pen_report_exact(json_t *value);

/* Appends a JSON value as indented lines, ending in a line feed. Fails: PEN_NO_MEMORY. */
bool pen_report_text(const json_t *value, struct pen_buf *out, struct pen_status *st);

/* Prints "penumbra 0.1.0" on standard output. */
void pen_report_version(const char *program);

/* Prints the table of exit codes, for --help. */
void pen_report_exit_codes(FILE *out);

/* Flushes standard output. Returns `code`, or if that is 0 and the output was lost, the exit code
 * of PEN_IO. */
int pen_report_finish(const char *program, int code);

#endif
