/* SPDX-License-Identifier: MIT */
/* The program `penumbra`: finds the subcommand and runs it. */
#include <stdio.h>
#include <string.h>

#include "cmd/client/commands.h"
#include "cmd/report.h"
#include "io/message.h"

static const struct pen_command *const commands[] = {
    &pen_command_render,   &pen_command_validate, &pen_command_compare, &pen_command_scenes,
    &pen_command_convert,  &pen_command_bench,    &pen_command_effects, &pen_command_explain,
    &pen_command_accuracy, &pen_command_audit,    &pen_command_submit,  &pen_command_wait,
    &pen_command_fetch,    &pen_command_list,     &pen_command_top,     &pen_command_stats,
    &pen_command_cancel,   &pen_command_delete,
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

/* A command that talks to a daemon has the option --server. */
static bool needs_daemon(const struct pen_command *command)
{
    return !command->daemon_optional && pen_option_find(command->options, "server") >= 0;
}

static void print_commands(FILE *out, bool with_daemon)
{
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (needs_daemon(commands[i]) == with_daemon)
            fprintf(out, "  %-10s %s\n", commands[i]->name, commands[i]->summary);
    }
}

static void print_help(FILE *out)
{
    fputs(
        "Usage: penumbra COMMAND …\n\n"
        "Renders scenes, in this process or through a daemon. `penumbra help COMMAND` describes a "
        "command.\n\n"
        "Without a daemon:\n",
        out);
    print_commands(out, false);
    fputs("\nWith a daemon (--server URL or PENUMBRA_URL, default http://127.0.0.1:8080):\n", out);
    print_commands(out, true);
    fputs("\n", out);
    pen_report_exit_codes(out);
}

static int unknown_command(const char *word)
{
    const char *names[COMMAND_COUNT + 1];
    for (int i = 0; i < COMMAND_COUNT; i++)
        names[i] = commands[i]->name;
    names[COMMAND_COUNT] = NULL;
    struct pen_status st;
    const char *near = pen_nearest_name(word, names);
    if (near)
        pen_fail(&st, PEN_USAGE, "unknown command \"%s\", nearest is \"%s\"", word, near);
    else
        pen_fail(&st, PEN_USAGE, "unknown command \"%s\", see penumbra --help", word);
    return pen_report("penumbra", NULL, &st);
}

static const struct pen_command *find_command(const char *word)
{
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(word, commands[i]->name) == 0)
            return commands[i];
    }
    return NULL;
}

/* `penumbra help render` is `penumbra render --help`. */
static int help_of(const char *word, const char *more)
{
    struct pen_status st;
    const struct pen_command *command = find_command(word);
    if (!command)
        return unknown_command(word);
    if (more) {
        pen_fail(&st, PEN_USAGE, "help: found \"%s\" and \"%s\", allowed is one command", word,
                 more);
        return pen_report("penumbra", NULL, &st);
    }
    pen_options_help(command, stdout);
    return 0;
}

static int run(int argc, char **argv)
{
    const char *word = argc > 1 ? argv[1] : NULL;
    if (!word) {
        print_help(stderr);
        return pen_code_exit(PEN_USAGE);
    }
    const struct pen_command *command = find_command(word);
    if (command)
        return command->run(argc - 1, argv + 1);
    if (strcmp(word, "help") == 0 && argc > 2)
        return help_of(argv[2], argv[3]);
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0)
        print_help(stdout);
    else if (strcmp(word, "--version") == 0)
        pen_report_version("penumbra");
    else
        return unknown_command(word);
    return 0;
}

int main(int argc, char **argv)
{
    return pen_report_finish("penumbra", run(argc, argv));
}
