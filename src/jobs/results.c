/* SPDX-License-Identifier: MIT */
/* Pictures of jobs. The PNG of a view is stored with the job's last commit; the other formats, and
 * the contact sheet of all views, are made from the committed pixels when they are first asked
 * for, and stored then. The preview is made anew each time: it is of a moment. */
#include <stdlib.h>
#include <string.h>

#include "jobs/internal/jobs.h"

enum { ALL_VIEWS = -1, SHEET_PIXELS_MAX = 16 * 1024 * 1024 };

static const char beauty[] = "beauty";

static const char *const formats[] = {"png", "png16", "pfm"};
static const char *const types[] = {"image/png", "image/png", "image/x-portable-floatmap"};

/* What is asked for, resolved against the job. */
struct wanted {
    const char *id;
    struct pen_job_plan plan;
    int view; /* ALL_VIEWS: the contact sheet */
    int format;
};

static bool read_job(struct pen_jobs *jobs, const char *id, struct pen_job_plan *plan,
                     enum pen_job_state *state, struct pen_status *st)
{
    struct pen_job_record job;
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    *state = job.state;
    bool ok = pen_job_plan_read(job.request, plan, st);
    pen_job_record_release(&job);
    if (!ok || !plan->benchmark)
        return ok;
    json_decref(plan->request);
    return pen_fail(st, PEN_NOT_FOUND, "job %s is a benchmark: it has a report and no picture", id);
}

static bool resolve_view(struct wanted *want, const char *name, bool sheet, struct pen_status *st)
{
    want->view = 0;
    if (!name)
        return true;
    want->view = ALL_VIEWS;
    if (sheet && strcmp(name, "all") == 0)
        return true;
    want->view = pen_job_plan_find_view(&want->plan, name);
    return want->view >= 0 ||
           pen_fail(st, PEN_NOT_FOUND, "job %s has no view \"%.60s\"; its first is \"%s\"",
                    want->id, name, pen_job_plan_view(&want->plan, 0));
}

static bool resolve_layer(const char *layer, struct pen_status *st)
{
    static const char *const layers[] = {"beauty", "cost", "samples", "depth", "normal"};
    if (!layer || strcmp(layer, beauty) == 0)
        return true;
    for (size_t i = 1; i < sizeof layers / sizeof layers[0]; i++) {
        if (strcmp(layer, layers[i]) == 0)
            return pen_fail(st, PEN_NOT_FOUND, "the layer \"%s\" was not requested", layer);
    }
    return pen_fail(st, PEN_USAGE,
                    "layer must be one of beauty, cost, samples, depth, normal; found \"%.60s\"",
                    layer);
}

static bool resolve_format(struct wanted *want, const char *format, struct pen_status *st)
{
    for (want->format = 0; want->format < 3; want->format++) {
        if (!format || strcmp(format, formats[want->format]) == 0)
            return true;
    }
    return pen_fail(st, PEN_USAGE, "format must be one of png, png16, pfm; found \"%.60s\"",
                    format);
}

static bool load_view(struct pen_jobs *jobs, const struct wanted *want, int view,
                      struct pen_film *film, struct pen_status *st)
{
    int64_t filled = 0;
    if (!pen_canvas_load(jobs->store, want->id, view, &want->plan.settings, film, NULL, &filled,
                         st))
        return false;
    return filled == (int64_t)film->width * film->height ||
           pen_fail(st, PEN_STORAGE, "job %s lacks pixels of a view", want->id);
}

/* Puts a view into its cell of a sheet, `shrink` pixels averaged to one in each direction. */
static void shrink_into(const struct pen_film *view, int shrink, int x0, int y0,
                        struct pen_film *sheet)
{
    int width = view->width / shrink, height = view->height / shrink;
    double share = 1.0 / ((double)shrink * shrink);
    for (int i = 0; i < width * height * 3; i++) {
        int x = i / 3 % width, y = i / 3 / width, c = i % 3;
        double sum = 0;
        for (int k = 0; k < shrink * shrink; k++) {
            size_t from = (size_t)(y * shrink + k / shrink) * (size_t)view->width +
                          (size_t)(x * shrink + k % shrink);
            sum += (double)view->rgb[3 * from + (size_t)c];
        }
        size_t to = (size_t)(y0 + y) * (size_t)sheet->width + (size_t)(x0 + x);
        sheet->rgb[3 * to + (size_t)c] = (float)(sum * share);
    }
}

/* Places of views on a contact sheet: as square a grid as fits, with black gaps between the views,
 * and these shrunk by a whole number where the sheet would become too large. */
struct grid {
    int columns, rows, shrink, gap;
    int width, height;             /* of a cell */
    int sheet_width, sheet_height; /* all in pixels */
};

static struct grid plan_grid(const struct pen_job_plan *plan)
{
    struct grid grid = {.columns = 1};
    while (grid.columns * grid.columns < plan->view_count)
        grid.columns++;
    grid.rows = (plan->view_count + grid.columns - 1) / grid.columns;
    do {
        grid.shrink++;
        grid.width = plan->settings.width / grid.shrink;
        grid.height = plan->settings.height / grid.shrink;
        grid.gap = 1 + grid.width / 128;
        grid.sheet_width = (grid.width + grid.gap) * grid.columns - grid.gap;
        grid.sheet_height = (grid.height + grid.gap) * grid.rows - grid.gap;
    } while ((double)grid.sheet_width * grid.sheet_height > SHEET_PIXELS_MAX && grid.width > 1 &&
             grid.height > 1);
    return grid;
}

static struct pen_film *make_sheet(struct pen_jobs *jobs, const struct wanted *want,
                                   struct pen_status *st)
{
    const struct pen_settings *s = &want->plan.settings;
    struct grid grid = plan_grid(&want->plan);
    struct pen_film *sheet = pen_film_new(grid.sheet_width, grid.sheet_height, st);
    struct pen_film *view = sheet ? pen_film_new(s->width, s->height, st) : NULL;
    bool ok = view != NULL;
    for (int i = 0; ok && i < want->plan.view_count; i++) {
        ok = load_view(jobs, want, i, view, st);
        if (ok)
            shrink_into(view, grid.shrink, i % grid.columns * (grid.width + grid.gap),
                        i / grid.columns * (grid.height + grid.gap), sheet);
    }
    pen_film_free(view);
    if (ok)
        return sheet;
    pen_film_free(sheet);
    return NULL;
}

static struct pen_film *make_view(struct pen_jobs *jobs, const struct wanted *want,
                                  struct pen_status *st)
{
    const struct pen_settings *s = &want->plan.settings;
    struct pen_film *film = pen_film_new(s->width, s->height, st);
    if (film && load_view(jobs, want, want->view, film, st))
        return film;
    pen_film_free(film);
    return NULL;
}

static bool make_picture(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                         struct pen_status *st)
{
    struct pen_film *film =
        want->view == ALL_VIEWS ? make_sheet(jobs, want, st) : make_view(jobs, want, st);
    bool ok = film && pen_canvas_encode(film, &want->plan.settings, formats[want->format], out, st);
    pen_film_free(film);
    return ok;
}

/* The stored picture, or a new one, which is then stored. That it cannot be stored, because the
 * disk is full or the job was just deleted, is no reason not to answer. */
static bool get_picture(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                        struct pen_status *st)
{
    struct pen_status ignored;
    if (pen_store_artefact(jobs->store, want->id, want->view, beauty, formats[want->format], out,
                           st))
        return true;
    if (st->code != PEN_NOT_FOUND || !make_picture(jobs, want, out, st))
        return false;
    pen_store_artefact_put(jobs->store, want->id, want->view, beauty, formats[want->format],
                           out->data, out->bytes, &ignored);
    return true;
}

static bool fill_image(struct pen_image *image, const char *type)
{
    strcpy(image->type, type);
    pen_etag_make(image->bytes.data, image->bytes.bytes, image->etag);
    return true;
}

static bool check_succeeded(const char *id, enum pen_job_state state, struct pen_status *st)
{
    if (state == PEN_JOB_SUCCEEDED)
        return true;
    return pen_fail(st, PEN_CONFLICT, "job %s is %s; only a succeeded job has its picture%s", id,
                    pen_job_state_name(state),
                    pen_job_state_ended(state) ? "" : ", see preview meanwhile");
}

bool pen_jobs_image(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                    struct pen_image *out, struct pen_status *st)
{
    struct wanted want = {.id = id};
    enum pen_job_state state;
    *out = (struct pen_image){0};
    if (!resolve_format(&want, query->format, st) || !read_job(jobs, id, &want.plan, &state, st))
        return false;
    bool ok = resolve_layer(query->layer, st) && resolve_view(&want, query->view, true, st) &&
              check_succeeded(id, state, st) && get_picture(jobs, &want, &out->bytes, st) &&
              fill_image(out, types[want.format]);
    json_decref(want.plan.request);
    if (!ok)
        pen_buf_release(&out->bytes);
    return ok;
}

static bool make_preview(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                         struct pen_status *st)
{
    const struct pen_settings *s = &want->plan.settings;
    int64_t filled;
    struct pen_film *film = pen_film_new(s->width, s->height, st);
    unsigned char *mask = film ? calloc((size_t)s->width, (size_t)s->height) : NULL;
    if (film && !mask)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a preview");
    struct pen_png_options options = {.bits = 8, .transfer = pen_canvas_transfer(s), .mask = mask};
    bool ok = mask &&
              pen_canvas_load(jobs->store, want->id, want->view, s, film, mask, &filled, st) &&
              pen_png_write(film, &options, out, st);
    free(mask);
    pen_film_free(film);
    return ok;
}

bool pen_jobs_preview(struct pen_jobs *jobs, const char *id, const char *view,
                      struct pen_image *out, struct pen_status *st)
{
    struct wanted want = {.id = id};
    enum pen_job_state state;
    *out = (struct pen_image){0};
    if (!read_job(jobs, id, &want.plan, &state, st))
        return false;
    bool ok = resolve_view(&want, view, false, st) && make_preview(jobs, &want, &out->bytes, st) &&
              fill_image(out, types[0]);
    json_decref(want.plan.request);
    if (!ok)
        pen_buf_release(&out->bytes);
    return ok;
}

json_t *pen_jobs_stats(struct pen_jobs *jobs, const char *id, struct pen_status *st)
{
    struct pen_job_record job;
    if (!pen_store_job(jobs->store, id, &job, st))
        return NULL;
    json_t *stats = NULL;
    if (pen_job_state_ended(job.state))
        stats = pen_stats_of_job(jobs->store, &job, st);
    else
        pen_fail(st, PEN_CONFLICT, "job %s is %s; its statistics come when it has ended", id,
                 pen_job_state_name(job.state));
    pen_job_record_release(&job);
    return stats;
}
