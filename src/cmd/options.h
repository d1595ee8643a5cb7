/* SPDX-License-Identifier: MIT */
/* Command lines as tables. An option is one row; parsing, the help text, the environment variable
 * and the configuration key follow from it. Both programs use this parser.
 *
 * It accepts `--name value`, `--name=value`, `-o value`, `-ovalue`, options and arguments in any
 * order, and `--` before arguments that begin with a dash. `-` alone is an argument. Names cannot
 * be abbreviated, so a new option never makes the command line of a script ambiguous. */
#ifndef PEN_CMD_OPTIONS_H
#define PEN_CMD_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

enum pen_option_kind {
    PEN_OPTION_FLAG,   /* bool */
    PEN_OPTION_TEXT,   /* const char * */
    PEN_OPTION_CHOICE, /* const char *, one of choices[] */
    PEN_OPTION_INT,    /* int in min…max */
    PEN_OPTION_NUMBER, /* double in min…max */
    PEN_OPTION_LIST    /* struct pen_option_list: may be given several times */
};

enum { PEN_OPTION_LIST_MAX = 64 };

struct pen_option_list {
    int count;
    const char *item[PEN_OPTION_LIST_MAX];
};

/* One option. Its value is written at `offset` of the command's structure of values. */
struct pen_option {
    const char *name; /* without dashes; NULL ends a table */
    char letter;      /* short form, 0: none */
    enum pen_option_kind kind;
    size_t offset;
    const char *value; /* the value's name in help, "FILE"; NULL for a flag */
    const char *help;
    double min, max;            /* of integers and numbers */
    const char *const *choices; /* ends with NULL */
    const char *env;            /* environment variable, NULL: none */
    bool hidden;                /* from a supervisor to its children: not in the help or the file */
};

enum { PEN_OPTIONS_MAX = 64 };

/* A program, or one subcommand of a program. */
struct pen_command {
    const char *program;
    const char *name;      /* NULL: the program itself */
    const char *arguments; /* for the usage line, "SCENE -o OUT" */
    const char *summary;   /* one line */
    const char *details;   /* more for --help, may be NULL */
    const struct pen_option *options;
    int min_args, max_args;            /* max_args -1: any number */
    bool daemon_optional;              /* works without a daemon, although it has --server */
    int (*run)(int argc, char **argv); /* argv[0] is the command's name; returns an exit code */
};

/* The parts of a command line besides the values of options. */
struct pen_parsed {
    bool help, version;
    uint64_t set;   /* bit i: row i was given */
    uint64_t typed; /* bit i: on the command line, not by the environment */
    int count;      /* of args */
    char **args;    /* within argv */
};
_Static_assert(PEN_OPTIONS_MAX <= 64, "pen_parsed.set has a bit for each row");

/* Parses argv[1…] into values, which have the defaults. Stops at --help and --version, without
 * checking the rest.
 * Owns: values point into argv; argv is reordered.
 * Fails: PEN_USAGE. */
bool pen_options_parse(const struct pen_command *command, int argc, char **argv, void *values,
                       struct pen_parsed *parsed, struct pen_status *st);

/* Sets one value; `where` names its origin in messages ("--threads", "PENUMBRA_THREADS").
 * Fails: PEN_USAGE; the message has the value found and the allowed values. */
bool pen_option_set(const struct pen_option *option, const char *where, const char *text,
                    void *values, struct pen_status *st);

/* Sets the rows that `parsed` does not have yet from their environment variables, and marks them in
 * `parsed`. An empty variable counts as absent.
 * Fails: PEN_USAGE. */
bool pen_options_from_env(const struct pen_command *command, void *values,
                          struct pen_parsed *parsed, struct pen_status *st);

/* Writes which values an option takes, for messages: "an integer from 0 to 1024". */
void pen_option_allowed(const struct pen_option *option, char *out, size_t bytes);

/* Returns the index of the row of that name, hidden or not; -1 if there is none. */
int pen_option_find(const struct pen_option *options, const char *name);

/* Returns the visible option name nearest to a misspelt name, or NULL. */
const char *pen_option_nearest(const struct pen_option *options, const char *name);

/* Returns true if an option was given on the command line. */
bool pen_option_typed(const struct pen_command *command, const struct pen_parsed *parsed,
                      const char *name);

/* Prints the help text, made from the table. */
void pen_options_help(const struct pen_command *command, FILE *out);

/* Parses the command line and the environment; prints help, version or an error. Returns -1 if the
 * command should continue, otherwise the exit code. */
int pen_command_begin(const struct pen_command *command, int argc, char **argv, void *values,
                      struct pen_parsed *parsed);

#endif
