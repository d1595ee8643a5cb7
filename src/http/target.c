/* SPDX-License-Identifier: MIT */
/* Request targets are split first and decoded afterwards. So an encoded slash stays inside its
 * segment, and an encoded ampersand inside its value. */
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "http/message.h"

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Decodes in place. In a query a plus sign stands for a space. An encoded zero byte would end the
 * text early, so it counts as a malformed encoding. */
static bool decode(char *text, bool in_query)
{
    char *out = text;
    for (const char *in = text; *in; in++) {
        if (*in == '%') {
            int high = hex_digit(in[1]), low = high < 0 ? -1 : hex_digit(in[2]);
            if (low < 0 || (high == 0 && low == 0))
                return false;
            *out++ = (char)(high << 4 | low);
            in += 2;
        } else {
            *out++ = in_query && *in == '+' ? ' ' : *in;
        }
    }
    *out = '\0';
    return true;
}

/* Skips "http://authority", which a server must accept too (RFC 9112, section 3.2.2), and stores
 * the authority. Returns the path. */
static char *skip_authority(char *text, struct pen_target *target)
{
    char *rest = text;
    if (strncasecmp(text, "http://", 7) == 0)
        rest += 7;
    else if (strncasecmp(text, "https://", 8) == 0)
        rest += 8;
    else
        return text;
    char *path = rest + strcspn(rest, "/?");
    /* The authority is moved down by one byte, over the slash before it, to make room for its
     * terminating zero. */
    memmove(rest - 1, rest, (size_t)(path - rest));
    path[-1] = '\0';
    target->authority = rest - 1;
    return path;
}

static bool split_path(char *path, struct pen_target *target)
{
    if (*path == '\0' || strcmp(path, "/") == 0)
        return true;
    for (char *segment = path + 1, *next; segment; segment = next) {
        next = strchr(segment, '/');
        if (next)
            *next++ = '\0';
        if (!decode(segment, false))
            return false;
        if (target->segment_count < PEN_SEGMENTS_MAX)
            target->segment[target->segment_count] = segment;
        target->segment_count++;
    }
    return true;
}

static bool split_query(char *query, struct pen_target *target, struct pen_status *st)
{
    for (char *next; query && *query; query = next) {
        next = strchr(query, '&');
        if (next)
            *next++ = '\0';
        if (*query == '\0')
            continue;
        if (target->param_count == PEN_PARAMS_MAX)
            return pen_fail(st, PEN_USAGE, "more than %d query parameters", PEN_PARAMS_MAX);
        char *value = strchr(query, '=');
        if (value)
            *value++ = '\0';
        if (!decode(query, true) || (value && !decode(value, true)))
            return pen_fail(st, PEN_SYNTAX,
                            "malformed percent-encoding, or an encoded zero byte, in the query");
        target->param[target->param_count++] =
            (struct pen_param){.name = query, .value = value ? value : ""};
    }
    return true;
}

bool pen_target_parse(const char *raw, struct pen_target *target, struct pen_status *st)
{
    *target = (struct pen_target){0};
    target->text = strdup(raw);
    if (!target->text)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the request target");
    char *path = skip_authority(target->text, target);
    char *query = strchr(path, '?');
    if (query)
        *query++ = '\0';
    if (*path != '/' && !(target->authority && *path == '\0'))
        return pen_fail(st, PEN_SYNTAX, "the request target is not a path");
    if (!split_path(path, target))
        return pen_fail(st, PEN_SYNTAX,
                        "malformed percent-encoding, or an encoded zero byte, in the path");
    return split_query(query, target, st);
}

void pen_target_release(struct pen_target *target)
{
    free(target->text);
    *target = (struct pen_target){0};
}

bool pen_target_matches(const struct pen_target *target, const char *template, const char **arg)
{
    *arg = NULL;
    int i = 0;
    for (const char *at = template; *at == '/' && at[1]; i++) {
        size_t length = strcspn(++at, "/");
        if (i == target->segment_count || i == PEN_SEGMENTS_MAX)
            return false;
        const char *segment = target->segment[i];
        if (*at == '{')
            *arg = segment;
        else if (strlen(segment) != length || memcmp(segment, at, length) != 0)
            return false;
        at += length;
    }
    return i == target->segment_count;
}

const char *pen_target_param(const struct pen_target *target, const char *name)
{
    for (int i = 0; i < target->param_count; i++) {
        if (strcmp(target->param[i].name, name) == 0)
            return target->param[i].value;
    }
    return NULL;
}
