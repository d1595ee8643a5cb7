/* SPDX-License-Identifier: MIT */
#include "cmd/client/sse.h"

#include <stdio.h>
#include <string.h>

void pen_sse_release(struct pen_sse *sse)
{
    pen_buf_release(&sse->line);
    pen_buf_release(&sse->data);
}

static bool dispatch(struct pen_sse *sse)
{
    if (sse->data.bytes > 0) {
        if (!pen_buf_add(&sse->data, "", 1))
            return false;
        memcpy(sse->last_id, sse->id, sizeof sse->id);
        sse->events++;
        sse->each(sse->user, sse->type[0] ? sse->type : "message", (const char *)sse->data.data);
    }
    sse->type[0] = '\0';
    sse->data.bytes = 0;
    return true;
}

/* Takes a line without its line feed. An empty line ends the event. */
static bool take_line(struct pen_sse *sse, char *line)
{
    if (!*line)
        return dispatch(sse);
    char *value = strchr(line, ':');
    if (value)
        *value++ = '\0';
    else
        value = line + strlen(line);
    value += *value == ' ';
    if (strcmp(line, "event") == 0)
        snprintf(sse->type, sizeof sse->type, "%s", value);
    else if (strcmp(line, "id") == 0)
        snprintf(sse->id, sizeof sse->id, "%s", value);
    else if (strcmp(line, "data") == 0)
        return (sse->data.bytes == 0 || pen_buf_puts(&sse->data, "\n")) &&
               pen_buf_puts(&sse->data, value);
    return true;
}

bool pen_sse_feed(struct pen_sse *sse, const char *bytes, size_t count)
{
    if (!sse->id[0])
        memcpy(sse->id, sse->last_id, sizeof sse->id);
    for (const char *end; count > 0; count -= (size_t)(end - bytes), bytes = end) {
        const char *newline = memchr(bytes, '\n', count);
        end = newline ? newline + 1 : bytes + count;
        if (!pen_buf_add(&sse->line, bytes, (size_t)((newline ? newline : end) - bytes)))
            return false;
        if (!newline)
            continue;
        if (sse->line.bytes > 0 && sse->line.data[sse->line.bytes - 1] == '\r')
            sse->line.bytes--;
        if (!pen_buf_add(&sse->line, "", 1) || !take_line(sse, (char *)sse->line.data))
            return false;
        sse->line.bytes = 0;
    }
    return true;
}
