/* SPDX-License-Identifier: MIT */
#include "cmd/options.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cmd/report.h"
#include "io/message.h"
#include "io/settings_json.h"

int pen_option_find(const struct pen_option *options, const char *name)
{
    for (int i = 0; options[i].name; i++) {
        if (strcmp(options[i].name, name) == 0)
            return i;
    }
    return -1;
}

bool pen_option_typed(const struct pen_command *command, const struct pen_parsed *parsed,
                      const char *name)
{
    return parsed->typed >> pen_option_find(command->options, name) & 1;
}

static int find_letter(const struct pen_option *options, char letter)
{
    for (int i = 0; options[i].name; i++) {
        if (options[i].letter == letter)
            return i;
    }
    return -1;
}

const char *pen_option_nearest(const struct pen_option *options, const char *name)
{
    static const char *const always[] = {"help", "version"};
    const char *names[PEN_OPTIONS_MAX + 3];
    int count = 0;
    for (int i = 0; options[i].name && count < PEN_OPTIONS_MAX; i++) {
        if (!options[i].hidden)
            names[count++] = options[i].name;
    }
    names[count++] = always[0];
    names[count++] = always[1];
    names[count] = NULL;
    return pen_nearest_name(name, names);
}

void pen_option_allowed(const struct pen_option *option, char *out, size_t bytes)
{
    size_t used = 0;
    switch (option->kind) {
    case PEN_OPTION_FLAG:
        snprintf(out, bytes, "true or false");
        break;
    case PEN_OPTION_TEXT:
    case PEN_OPTION_LIST:
        snprintf(out, bytes, "%s", option->value);
        break;
    case PEN_OPTION_INT:
        snprintf(out, bytes, "an integer from %.0f to %.0f", option->min, option->max);
        break;
    case PEN_OPTION_NUMBER:
        snprintf(out, bytes, "a number from %g to %g", option->min, option->max);
        break;
    case PEN_OPTION_CHOICE:
        out[0] = '\0';
        for (int i = 0; option->choices[i] && used < bytes; i++) {
            const char *comma = i == 0 ? "" : option->choices[i + 1] ? ", " : " or ";
            int more = snprintf(out + used, bytes - used, "%s%s", comma, option->choices[i]);
            used += more > 0 ? (size_t)more : 0;
        }
        break;
    }
}

static bool wrong_value(const struct pen_option *option, const char *where, const char *text,
                        struct pen_status *st)
{
    char allowed[256];
    pen_option_allowed(option, allowed, sizeof allowed);
    return pen_fail(st, PEN_USAGE, "%s: found \"%s\", allowed is %s", where, text, allowed);
}

/* Reads a finite number within the row's range, with nothing after it. */
static bool read_number(const struct pen_option *option, const char *text, double *value)
{
    char *end;
    errno = 0;
    *value = strtod(text, &end);
    return end != text && *end == '\0' && !errno && isfinite(*value) && *value >= option->min &&
           *value <= option->max;
}

static bool read_int(const struct pen_option *option, const char *text, int *value)
{
    char *end;
    errno = 0;
    long number = strtol(text, &end, 10);
    if (end == text || *end || errno || number < INT_MIN || number > INT_MAX)
        return false;
    *value = (int)number;
    return *value >= option->min && *value <= option->max;
}

static bool read_flag(const char *text, bool *value)
{
    *value = strcmp(text, "true") == 0 || strcmp(text, "1") == 0;
    return *value || strcmp(text, "false") == 0 || strcmp(text, "0") == 0;
}

static bool is_choice(const struct pen_option *option, const char *text)
{
    for (int i = 0; option->choices[i]; i++) {
        if (strcmp(option->choices[i], text) == 0)
            return true;
    }
    return false;
}

static bool list_add(struct pen_option_list *list, const char *where, const char *text,
                     struct pen_status *st)
{
    if (list->count >= PEN_OPTION_LIST_MAX)
        return pen_fail(st, PEN_USAGE, "%s: given more than %d times", where, PEN_OPTION_LIST_MAX);
    list->item[list->count++] = text;
    return true;
}

bool pen_option_set(const struct pen_option *option, const char *where, const char *text,
                    void *values, struct pen_status *st)
{
    void *field = (char *)values + option->offset;
    double number;
    switch (option->kind) {
    case PEN_OPTION_FLAG:
        return read_flag(text, field) || wrong_value(option, where, text, st);
    case PEN_OPTION_INT:
        return read_int(option, text, field) || wrong_value(option, where, text, st);
    case PEN_OPTION_NUMBER:
        if (!read_number(option, text, &number))
            return wrong_value(option, where, text, st);
        *(double *)field = number;
        return true;
    case PEN_OPTION_LIST:
        return list_add(field, where, text, st);
    case PEN_OPTION_CHOICE:
        if (!is_choice(option, text))
            return wrong_value(option, where, text, st);
        break;
    case PEN_OPTION_TEXT:
        break;
    }
    *(const char **)field = text;
    return true;
}

/* The state of the parser. */
struct scan {
    const struct pen_command *command;
    int argc, next; /* next: index in argv of the next word */
    char **argv;
    void *values;
    struct pen_parsed *parsed;
};

static bool unknown_option(const struct pen_command *command, const char *name,
                           struct pen_status *st)
{
    const char *near = pen_option_nearest(command->options, name);
    if (near)
        return pen_fail(st, PEN_USAGE, "unknown option --%s, nearest is --%s", name, near);
    const char *setting = NULL;
    if (pen_option_find(command->options, "set") >= 0)
        setting = pen_settings_nearest(name);
    if (setting)
        return pen_fail(st, PEN_USAGE, "unknown option --%s; %s is a setting: --set %s=VALUE", name,
                        strcmp(name, setting) == 0 ? "it" : setting, setting);
    return pen_fail(st, PEN_USAGE, "unknown option --%s, see --help", name);
}

/* Takes the option of row i. `attached` is the text after `=` or after the letter; NULL: the value
 * is the next word. */
static bool take_option(struct scan *scan, int i, const char *where, const char *attached,
                        struct pen_status *st)
{
    const struct pen_option *option = &scan->command->options[i];
    uint64_t bit = (uint64_t)1 << i;
    if (scan->parsed->set & bit && option->kind != PEN_OPTION_LIST &&
        option->kind != PEN_OPTION_FLAG)
        return pen_fail(st, PEN_USAGE, "%s: given twice", where);
    scan->parsed->set |= bit;
    scan->parsed->typed |= bit;
    if (option->kind == PEN_OPTION_FLAG && !attached)
        attached = "true";
    if (!attached && scan->next < scan->argc && strncmp(scan->argv[scan->next], "--", 2) != 0)
        attached = scan->argv[scan->next++];
    if (!attached)
        return pen_fail(st, PEN_USAGE, "%s: needs a value, %s", where, option->value);
    return pen_option_set(option, where, attached, scan->values, st);
}

static bool take_long(struct scan *scan, const char *word, struct pen_status *st)
{
    char name[64], where[70];
    const char *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : strlen(word);
    if (length >= sizeof name)
        return pen_fail(st, PEN_USAGE, "unknown option --%.60s…, see --help", word);
    memcpy(name, word, length);
    name[length] = '\0';
    if (!equals && strcmp(name, "help") == 0)
        return scan->parsed->help = true;
    if (!equals && strcmp(name, "version") == 0)
        return scan->parsed->version = true;
    int i = pen_option_find(scan->command->options, name);
    if (i < 0)
        return unknown_option(scan->command, name, st);
    snprintf(where, sizeof where, "--%s", name);
    return take_option(scan, i, where, equals ? equals + 1 : NULL, st);
}

/* Reports a word after a single dash that is the name of an option, or whose first letter is no
 * option. A dash is missing. */
static bool unknown_long(const struct pen_command *command, const char *word, struct pen_status *st)
{
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
    const char *near = pen_option_find(command->options, name) >= 0
                           ? name
                           : pen_option_nearest(command->options, name);
    if (near)
        return pen_fail(st, PEN_USAGE, "unknown option -%s, nearest is --%s", name, near);
    return pen_fail(st, PEN_USAGE, "unknown option -%s, see --help", name);
}

static bool take_short(struct scan *scan, const char *word, struct pen_status *st)
{
    char where[3] = {'-', word[0], '\0'};
    if (strcmp(word, "h") == 0)
        return scan->parsed->help = true;
    int i = find_letter(scan->command->options, word[0]);
    if (word[1] && (i < 0 || pen_option_find(scan->command->options, word) >= 0))
        return unknown_long(scan->command, word, st);
    if (i < 0)
        return pen_fail(st, PEN_USAGE, "unknown option -%s, see --help", word);
    if (word[1] && scan->command->options[i].kind == PEN_OPTION_FLAG)
        return pen_fail(st, PEN_USAGE, "%s: takes no value, found \"%s\"", where, word + 1);
    return take_option(scan, i, where, word[1] ? word + 1 : NULL, st);
}

static bool check_count(const struct pen_command *command, const struct pen_parsed *parsed,
                        struct pen_status *st)
{
    if (parsed->count < command->min_args)
        return pen_fail(st, PEN_USAGE, "missing argument, usage: %s %s %s", command->program,
                        command->name ? command->name : "", command->arguments);
    if (command->max_args >= 0 && parsed->count > command->max_args)
        return pen_fail(st, PEN_USAGE, "unexpected argument \"%s\"",
                        parsed->args[command->max_args]);
    return true;
}

bool pen_options_parse(const struct pen_command *command, int argc, char **argv, void *values,
                       struct pen_parsed *parsed, struct pen_status *st)
{
    *parsed = (struct pen_parsed){.args = argv + 1};
    struct scan scan = {.command = command,
                        .argc = argc,
                        .next = 1,
                        .argv = argv,
                        .values = values,
                        .parsed = parsed};
    bool options_over = false;
    while (scan.next < argc) {
        char *word = argv[scan.next++];
        bool ok = true;
        if (options_over || word[0] != '-' || word[1] == '\0')
            parsed->args[parsed->count++] = word; /* count < scan.next: no unread word is lost */
        else if (strcmp(word, "--") == 0)
            options_over = true;
        else if (word[1] == '-')
            ok = take_long(&scan, word + 2, st);
        else
            ok = take_short(&scan, word + 1, st);
        if (!ok)
            return false;
        if (parsed->help || parsed->version)
            return true;
    }
    return check_count(command, parsed, st);
}

bool pen_options_from_env(const struct pen_command *command, void *values,
                          struct pen_parsed *parsed, struct pen_status *st)
{
    for (int i = 0; command->options[i].name; i++) {
        const struct pen_option *option = &command->options[i];
        const char *text = option->env ? getenv(option->env) : NULL;
        uint64_t bit = (uint64_t)1 << i;
        if (!text || !*text || parsed->set & bit)
            continue;
        if (!pen_option_set(option, option->env, text, values, st))
            return false;
        parsed->set |= bit;
    }
    return true;
}

/* Returns the number of characters in the first `bytes` bytes of UTF-8. */
static int width_of(const char *text, size_t bytes)
{
    int width = 0;
    for (size_t i = 0; i < bytes; i++)
        width += (text[i] & 0xC0) != 0x80;
    return width;
}

/* Prints text wrapped at 96 columns. All lines but the first are indented; the first begins at
 * `column`. */
static void print_wrapped(FILE *out, const char *text, int indent, int column)
{
    while (*text) {
        size_t bytes = strcspn(text, " \n");
        int length = width_of(text, bytes);
        if (column > indent && column + 1 + length > 96) {
            fprintf(out, "\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            fputc(' ', out);
            column++;
        }
        fprintf(out, "%.*s", (int)bytes, text);
        column += length;
        text += bytes;
        if (*text == '\n') {
            fprintf(out, "\n%*s", text[1] ? indent : 0, "");
            column = indent;
        }
        if (*text)
            text++;
    }
    fputc('\n', out);
}

static int label_width(const struct pen_option *option)
{
    int value = option->value ? 1 + width_of(option->value, strlen(option->value)) : 0;
    return 8 + (int)strlen(option->name) + value;
}

static void help_option(const struct pen_option *option, int indent, FILE *out)
{
    char letter[5] = "    ";
    if (option->letter)
        snprintf(letter, sizeof letter, "-%c, ", option->letter);
    fprintf(out, "  %s--%s%s%s%*s", letter, option->name, option->value ? " " : "",
            option->value ? option->value : "", indent - label_width(option), "");
    char text[512], env[64] = "";
    if (option->env)
        snprintf(env, sizeof env, " [%s]", option->env);
    snprintf(text, sizeof text, "%s%s", option->help, env);
    print_wrapped(out, text, indent, indent);
}

void pen_options_help(const struct pen_command *command, FILE *out)
{
    static const struct pen_option always[] = {
        {.name = "help", .letter = 'h', .help = "print this text"},
        {.name = "version", .help = "print the version"},
    };
    int indent = label_width(&always[1]);
    for (const struct pen_option *o = command->options; o->name; o++) {
        if (!o->hidden && label_width(o) > indent)
            indent = label_width(o);
    }
    indent += 2;
    fprintf(out, "Usage: %s%s%s%s%s [options]\n\n", command->program, command->name ? " " : "",
            command->name ? command->name : "", *command->arguments ? " " : "", command->arguments);
    print_wrapped(out, command->summary, 0, 0);
    if (command->details) {
        fputc('\n', out);
        print_wrapped(out, command->details, 0, 0);
    }
    fputs("\nOptions:\n", out);
    for (const struct pen_option *o = command->options; o->name; o++) {
        if (!o->hidden)
            help_option(o, indent, out);
    }
    help_option(&always[0], indent, out);
    help_option(&always[1], indent, out);
    fputc('\n', out);
    pen_report_exit_codes(out);
}

int pen_command_begin(const struct pen_command *command, int argc, char **argv, void *values,
                      struct pen_parsed *parsed)
{
    struct pen_status st;
    if (!pen_options_parse(command, argc, argv, values, parsed, &st))
        return pen_report(command->program, NULL, &st);
    if (parsed->help) {
        pen_options_help(command, stdout);
        return 0;
    }
    if (parsed->version) {
        pen_report_version(command->program);
        return 0;
    }
    if (!pen_options_from_env(command, values, parsed, &st))
        return pen_report(command->program, NULL, &st);
    return -1;
}
