/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/config_file.h"

#include <stdlib.h>
#include <string.h>

#include "cmd/files.h"
#include "io/scene_json.h"

/* Copies a name with every `from` replaced by `to`. An option's `-` is `_` in the file's keys. */
static void translate(const char *name, char from, char to, char *out, size_t bytes)
{
    snprintf(out, bytes, "%s", name);
    for (char *c = out; *c; c++)
        *c = *c == from ? to : *c;
}

static bool unknown_key(const char *key, const char *pointer, struct pen_status *st)
{
    char name[64], near_key[64];
    translate(key, '_', '-', name, sizeof name);
    const char *near = pen_option_nearest(pen_command_daemon.options, name);
    if (!near || strcmp(near, "help") == 0 || strcmp(near, "version") == 0)
        return pen_fail_at(st, PEN_USAGE, pointer, "unknown key");
    translate(near, '-', '_', near_key, sizeof near_key);
    return pen_fail_at(st, PEN_USAGE, pointer, "unknown key, nearest is \"%s\"", near_key);
}

/* Sets an option from a value of the file: a number for an integer option, true or false for a
 * flag, a string for any other. Returns true if the value is allowed. */
static bool set_from_json(const struct pen_option *option, const json_t *value, void *values)
{
    char number[32];
    const char *text = json_string_value(value);
    struct pen_status ignored;
    if (option->kind == PEN_OPTION_INT) {
        if (!json_is_integer(value))
            return false;
        snprintf(number, sizeof number, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
        text = number;
    }
    if (option->kind == PEN_OPTION_FLAG)
        text = json_is_true(value) ? "true" : json_is_false(value) ? "false" : NULL;
    return text && pen_option_set(option, "", text, values, &ignored);
}

static bool read_key(const char *key, const json_t *value, struct pen_config *config,
                     struct pen_parsed *parsed, struct pen_status *st)
{
    char name[64], pointer[96], allowed[256];
    const struct pen_option *options = pen_command_daemon.options;
    struct pen_config scratch = *config;
    snprintf(pointer, sizeof pointer, "/%.80s", key);
    translate(key, '_', '-', name, sizeof name);
    int i = strchr(key, '-') ? -1 : pen_option_find(options, name);
    if (i < 0 || options[i].hidden || strcmp(name, "config") == 0)
        return unknown_key(key, pointer, st);
    bool overridden = parsed->set >> i & 1;
    if (set_from_json(&options[i], value, overridden ? &scratch : config)) {
        parsed->set |= (uint64_t)1 << i;
        return true;
    }
    char *found = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT);
    const bool literal = options[i].kind == PEN_OPTION_INT || options[i].kind == PEN_OPTION_FLAG;
    pen_option_allowed(&options[i], allowed, sizeof allowed);
    pen_fail_at(st, PEN_USAGE, pointer, "found %.80s, allowed is %s%s", found ? found : "?",
                literal ? "" : "a string: ", allowed);
    free(found);
    return false;
}

/* Adds an error of the configuration file, always as PEN_USAGE. So a wrong configuration has the
 * exit code of a wrong command line. */
static bool fail_config(struct pen_errors *errors, struct pen_status *st)
{
    st->code = PEN_USAGE;
    pen_errors_add(errors, st);
    return false;
}

bool pen_config_read_file(struct pen_config *config, struct pen_parsed *parsed,
                          struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_buf text = {0};
    struct pen_status st;
    if (pen_file_read(config->file, limits.body_bytes, &text, &st))
        config->document = pen_json_parse((const char *)text.data, text.bytes, &limits, &st);
    pen_buf_release(&text);
    if (!config->document)
        return fail_config(errors, &st);
    if (!json_is_object(config->document)) {
        pen_fail(&st, PEN_USAGE, "not a JSON object");
        return fail_config(errors, &st);
    }
    const char *key;
    json_t *value;
    json_object_foreach(config->document, key, value)
    {
        if (!read_key(key, value, config, parsed, &st))
            fail_config(errors, &st);
    }
    return errors->count == 0;
}
