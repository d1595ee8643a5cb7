/* SPDX-License-Identifier: MIT */
/* Where committed pixels lie. A batch is a run of tiles in the order of rows, so it covers at most
 * three rectangles: the end of a row of tiles, whole rows, and the beginning of a row. */
#include "jobs/internal/jobs.h"
#include "render/render.h"

struct telling {
    const struct pen_job_plan *plan;
    pen_job_tile_fn *each;
    void *user;
    bool odd; /* a batch did not fit the image */
};

/* Tiles in the first rectangle of a run that begins in column `column`. */
static int tiles_in_one(int column, int count, int across)
{
    if (column == 0 && count >= across)
        return count - count % across;
    return count < across - column ? count : across - column;
}

static bool tell_batch(void *user, const struct pen_commit_record *commit)
{
    struct telling *telling = user;
    const struct pen_settings *s = &telling->plan->settings;
    int total = pen_tile_count(s->width, s->height, s->tile);
    int across = pen_tile_count(s->width, 1, s->tile);
    int first = commit->first_tile, left = commit->tile_count;
    struct pen_job_tile tile = {.revision = commit->revision,
                                .view = pen_job_plan_view(telling->plan, commit->view)};
    telling->odd = !tile.view || first < 0 || left < 0 || first > total || left > total - first;
    if (telling->odd)
        return false;
    while (left > 0) {
        int count = tiles_in_one(first % across, left, across);
        struct pen_rect from = pen_tile_rect(s->width, s->height, s->tile, first);
        struct pen_rect to = pen_tile_rect(s->width, s->height, s->tile, first + count - 1);
        tile.part++;
        tile.x = from.x;
        tile.y = from.y;
        tile.width = to.x + to.width - from.x;
        tile.height = to.y + to.height - from.y;
        if (!telling->each(telling->user, &tile))
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
    struct pen_job_plan plan;
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    bool ok = pen_job_plan_read(job.request, &plan, st);
    pen_job_record_release(&job);
    if (!ok)
        return false;
    struct telling telling = {.plan = &plan, .each = each, .user = user};
    ok = pen_store_commits(jobs->store, id, after, tell_batch, &telling, st);
    json_decref(plan.request);
    if (ok && telling.odd)
        ok = pen_fail(st, PEN_STORAGE, "job %s has pixels that its image lacks", id);
    return ok;
}
