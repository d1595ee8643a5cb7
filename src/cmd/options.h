/* SPDX-License-Identifier: MIT */
/* Command lines as tables: an option is one row, and parsing, the help text, environment
 * variables and configuration keys all follow from it. Both programs share this parser.
 *
 * Accepted: `--name value`, `--name=value`, `-o value`, `-ovalue`, options and arguments in any
 * order, `--` before arguments that begin with a dash; `-` alone is an argument. Names are not
 * abbreviated: a script that works today works with the options of tomorrow. */
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

/* One option. The value is written at `offset` of the command's values structure. */
struct pen_option {
    const char *name; /* without dashes; NULL ends a table */
    char letter;      /* short form, 0: none */
    enum pen_option_kind kind;
    size_t offset;
    const char *value; /* how help names the value, "FILE"; NULL for a flag */
    const char *help;
    double min, max;            /* of numbers */
    const char *const *choices; /* NULL-terminated */
    const char *env;            /* environment variable, NULL: none */
    bool hidden;                /* between the programs themselves: not in help, env or file */
};

enum { PEN_OPTIONS_MAX = 64 };

/* A program, or one subcommand of a program. */
struct pen_command {
    const char *program;
    const char *name;      /* NULL: the program itself */
    const char *arguments; /* as usage shows them, e.g. "SCENE -o OUT" */
    const char *summary;   /* one line */
    const char *details;   /* more for --help, may be NULL */
    const struct pen_option *options;
    int min_args, max_args;            /* max_args -1: any number */
    int (*run)(int argc, char **argv); /* argv[0] is the command's name; returns an exit code */
};

/* What a command line said besides the values. */
struct pen_parsed {
    bool help, version;
    uint64_t set; /* bit i: row i was given */
    int count;
    char **args; /* within argv */
};

/* Parses argv[1…] into values, which holds the defaults. With --help or --version the rest is not
 * checked. Owns: values point into argv; argv is reordered. Fails: PEN_USAGE. */
bool pen_options_parse(const struct pen_command *command, int argc, char **argv, void *values,
                       struct pen_parsed *parsed, struct pen_status *st);

/* Writes one value; `where` names its origin in messages ("--threads", "PENUMBRA_THREADS").
 * Fails: PEN_USAGE, saying what was found and what is allowed. */
bool pen_option_set(const struct pen_option *option, const char *where, const char *text,
                    void *values, struct pen_status *st);

/* Takes the environment variables of all rows that `parsed` does not have yet, and marks them
 * there. An empty variable counts as absent. Fails: PEN_USAGE. */
bool pen_options_from_env(const struct pen_command *command, void *values,
                          struct pen_parsed *parsed, struct pen_status *st);

/* What values an option takes, for messages and help: "an integer from 0 to 1024". */
void pen_option_allowed(const struct pen_option *option, char *out, size_t bytes);

/* The row whose name this is, or -1; hidden rows are found too. */
int pen_option_find(const struct pen_option *options, const char *name);

/* The visible option name nearest to a misspelt one, or NULL. */
const char *pen_option_nearest(const struct pen_option *options, const char *name);

/* Prints the help text, made from the table. */
void pen_options_help(const struct pen_command *command, FILE *out);

/* Parses, takes the environment, and answers --help, --version and errors. Returns -1 to go on,
 * or the exit code to end with. */
int pen_command_begin(const struct pen_command *command, int argc, char **argv, void *values,
                      struct pen_parsed *parsed);

#endif
