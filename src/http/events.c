/* SPDX-License-Identifier: MIT */
/* Writing events. A text holds the tiles of all commits after the cursor, then the job. */
#include "http/internal/events.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

enum {
    IDS = PEN_JOB_TILE_PARTS + 1, /* ids of one revision */
    TILES_MAX = 256               /* tiles in one text */
};

struct event_cursor pen_http_events_begin(const char *last_event_id,
                                          const struct snapshot *snapshot)
{
    struct event_cursor cursor = {0};
    enum { DIGITS = 18 };
    size_t length = last_event_id ? strlen(last_event_id) : 0;
    if (length == 0 || length > DIGITS || strspn(last_event_id, "0123456789") != length)
        return cursor;
    cursor.id = strtoll(last_event_id, NULL, 10);
    if (cursor.id > IDS * snapshot->revision)
        cursor.id = 0;
    return cursor;
}

bool pen_http_events_are_complete(const struct event_cursor *cursor,
                                  const struct snapshot *snapshot)
{
    return cursor->id == IDS * snapshot->revision && pen_job_state_ended(snapshot->state);
}

struct writing {
    struct pen_buf *text;
    int64_t id;       /* of the last event in text */
    int64_t revision; /* the last revision to write */
    int tiles;        /* in text so far */
    bool full;        /* TILES_MAX was reached */
};

static bool write_tile(void *user, const struct pen_job_tile *tile)
{
    struct writing *writing = user;
    int64_t id = IDS * (tile->revision - 1) + tile->part;
    if (tile->revision > writing->revision)
        return false;
    if (id <= writing->id)
        return true;
    writing->full = writing->tiles++ == TILES_MAX;
    if (writing->full)
        return false;
    json_t *json = json_pack("{s:s, s:i, s:i, s:i, s:i}", "view", tile->view, "x", tile->x, "y",
                             tile->y, "width", tile->width, "height", tile->height);
    char *data = json ? json_dumps(json, JSON_COMPACT) : NULL;
    if (!data ||
        !pen_buf_printf(writing->text, "event: tile\nid: %" PRId64 "\ndata: %s\n\n", id, data))
        writing->text->failed = true;
    free(data);
    json_decref(json);
    writing->id = id;
    return !writing->text->failed;
}

/* Appends the event about the job. The job's JSON is one line and includes its line end. */
static void write_job(const struct snapshot *snapshot, const struct event_cursor *cursor,
                      struct pen_buf *text)
{
    bool same = cursor->job_sent && cursor->state == snapshot->state;
    const struct pen_buf *json = &snapshot->json->content;
    pen_buf_printf(text, "event: %s\nid: %" PRId64 "\ndata: ", same ? "progress" : "state",
                   IDS * snapshot->revision);
    pen_buf_add(text, json->data, json->bytes);
    pen_buf_puts(text, "\n");
}

bool pen_http_events_write(const struct snapshot *snapshot, struct pen_jobs *jobs,
                           struct event_cursor *cursor, struct pen_buf *text, struct pen_status *st)
{
    struct writing writing = {.text = text, .id = cursor->id, .revision = snapshot->revision};
    bool behind = cursor->id < IDS * snapshot->revision;
    if (cursor->job_sent && !behind)
        return true;
    if (behind && !pen_jobs_tiles(jobs, snapshot->id, cursor->id / IDS, write_tile, &writing, st))
        return false;
    if (!writing.full)
        write_job(snapshot, cursor, text);
    if (text->failed)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the events of a job");
    cursor->id = writing.id;
    cursor->more = writing.full;
    if (writing.full)
        return true;
    cursor->id = IDS * snapshot->revision;
    cursor->job_sent = true;
    cursor->state = snapshot->state;
    return true;
}
