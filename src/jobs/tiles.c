/* SPDX-License-Identifier: MIT */
/* The rectangles of committed pixels. A batch is a run of tiles in row order, so it covers at most
 * three rectangles: the end of a row of tiles, whole rows, and the beginning of a row. */
#include "jobs/internal/jobs.h"
#include "jobs/internal/stored_request.h"
#include "render/render.h"

struct listing {
    const struct pen_stored_request *request;
    pen_job_tile_fn *each;
    void *user;
    bool outside; /* a batch lies outside the image: the store is damaged */
};

/* Returns the number of tiles in the first rectangle of a run of `count` tiles that begins in
 * column `column`. A row has `across` tiles. */
static int tiles_in_first_rect(int column, int count, int across)
{
    if (column == 0 && count >= across)
        return count - count % across;
    return count < across - column ? count : across - column;
}

static bool list_batch(void *user, const struct pen_commit_record *commit)
{
    struct listing *listing = user;
    const struct pen_settings *s = &listing->request->settings;
    int total = pen_tile_count(s->width, s->height, s->tile);
    int across = pen_tile_count(s->width, 1, s->tile);
    int first = commit->first_tile, left = commit->tile_count;
    struct pen_job_tile tile = {.revision = commit->revision,
                                .view = pen_stored_request_view(listing->request, commit->view)};
    listing->outside = !tile.view || first < 0 || left < 0 || first > total || left > total - first;
    if (listing->outside)
        return false;
    while (left > 0) {
        int count = tiles_in_first_rect(first % across, left, across);
        struct pen_rect from = pen_tile_rect(s->width, s->height, s->tile, first);
        struct pen_rect to = pen_tile_rect(s->width, s->height, s->tile, first + count - 1);
        tile.part++;
        tile.x = from.x;
        tile.y = from.y;
        tile.width = to.x + to.width - from.x;
        tile.height = to.y + to.height - from.y;
        if (!listing->each(listing->user, &tile))
            return false;
        first += count;
        left -= count;
    }
    return true;
}

bool pen_jobs_tiles(struct pen_jobs *jobs, const char *id, int64_t after, pen_job_tile_fn *each,
                    void *user, struct pen_status *st)
{
    struct pen_job_record job;
    struct pen_stored_request request;
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    bool ok = pen_stored_request_read(job.request, &request, st);
    pen_job_record_release(&job);
    if (!ok)
        return false;
    struct listing listing = {.request = &request, .each = each, .user = user};
    ok = pen_store_commits(jobs->store, id, after, list_batch, &listing, st);
    pen_stored_request_release(&request);
    if (ok && listing.outside)
        ok = pen_fail(st, PEN_STORAGE, "job %s has pixels outside its image", id);
    return ok;
}
