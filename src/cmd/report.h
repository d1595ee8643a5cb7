/* SPDX-License-Identifier: MIT */
/* The output of the programs. Errors are lines on standard error and, with --json, a problem
 * document on standard output. Other output is JSON, the version and the table of exit codes. */
#ifndef PEN_CMD_REPORT_H
#define PEN_CMD_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/buf.h"
#include "base/status.h"

/* Prints `PROGRAM: FILE: place: message`; file may be NULL. Returns the error's exit code. */
int pen_report(const char *program, const char *file, const struct pen_status *st);

/* Prints every error of the list, and the number of errors that the list left out. Returns the exit
 * code of the first error. */
int pen_report_errors(const char *program, const char *file, const struct pen_errors *errors);

/* Print errors for the program penumbra. If `json`, the problem document is on standard output. */
int pen_report_json(const char *file, bool json, const struct pen_status *st);
int pen_report_errors_json(const char *file, bool json, const struct pen_errors *errors);

/* Prints formatted text as one line, with a line feed, in a form that is safe on a terminal: names
 * from scenes, files and servers cannot control it (base/utf8.h). pen_report_show prints a text of
 * several lines in this form. */
void pen_report_say(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
void pen_report_show(FILE *out, const char *text);

/* Prints a JSON value as one line on standard output. Numbers have 15 digits, so a value rounded to
 * thousandths is printed as such. pen_report_exact prints 17 digits, which read back as the same
 * doubles.
 * Owns: takes the caller's reference. */
void pen_report_line(json_t *value);
void pen_report_exact(json_t *value);

/* Appends a JSON value as indented lines, ending in a line feed.
 * Fails: PEN_NO_MEMORY. */
bool pen_report_text(const json_t *value, struct pen_buf *out, struct pen_status *st);

/* Prints "penumbra 0.1.0" on standard output. */
void pen_report_version(const char *program);

/* Prints the table of exit codes, for --help. */
void pen_report_exit_codes(FILE *out);

/* Flushes standard output. Returns `code`. If `code` is 0 and the output was lost, returns the exit
 * code of PEN_IO. */
int pen_report_finish(const char *program, int code);

#endif
