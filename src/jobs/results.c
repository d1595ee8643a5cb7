/* SPDX-License-Identifier: MIT */
/* Pictures of jobs.
 *   - The PNG of a view is stored with the view's last commit.
 *   - Other formats, and the contact sheet of all views, are made from the committed pixels.
 *   - A smaller picture is made from the PNG.
 *   - The preview has the pixels that are committed when it is requested. */
#include <stdlib.h>
#include <string.h>

#include "film/picture.h"
#include "film/shrink.h"
#include "jobs/comparison.h"
#include "jobs/internal/ids.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/members.h"
#include "jobs/internal/stats.h"
#include "jobs/internal/stored_request.h"
#include "jobs/internal/view_pixels.h"
#include "render/layer_file.h"
#include "render/transfer.h"

enum { ALL_VIEWS = -1, SHEET_PIXELS_MAX = 16 * 1024 * 1024 };

enum { FORMAT_PNG, FORMAT_PNG16, FORMAT_PFM, FORMAT_COUNT };
const char *const pen_image_formats[FORMAT_COUNT + 1] = {
    [FORMAT_PNG] = "png", [FORMAT_PNG16] = "png16", [FORMAT_PFM] = "pfm"};
static const char *const media_types[FORMAT_COUNT] = {[FORMAT_PNG] = "image/png",
                                                      [FORMAT_PNG16] = "image/png",
                                                      [FORMAT_PFM] = "image/x-portable-floatmap"};

/* A request for a picture, with its names looked up in the job. */
struct wanted {
    const char *id;
    struct pen_stored_request request;
    int view; /* index in the job; ALL_VIEWS: the contact sheet */
    enum pen_layer layer;
    int format; /* FORMAT_… */
};

static bool read_job(struct pen_jobs *jobs, const char *id, struct pen_stored_request *request,
                     enum pen_job_state *state, struct pen_status *st)
{
    struct pen_job_record job;
    if (!pen_store_job(jobs->store, id, &job, st))
        return false;
    *state = job.state;
    bool ok = pen_stored_request_read(job.request, request, st);
    pen_job_record_release(&job);
    if (!ok || !pen_job_kind_has_report(request->kind))
        return ok;
    const char *kind = pen_job_kinds[request->kind];
    pen_stored_request_release(request);
    return pen_fail(st, PEN_NOT_FOUND, "job %s is of kind \"%s\": it has a report and no picture",
                    id, kind);
}

static bool resolve_view(struct wanted *want, const char *name, bool sheet, struct pen_status *st)
{
    want->view = 0;
    if (!name)
        return true;
    want->view = ALL_VIEWS;
    if (sheet && strcmp(name, "all") == 0)
        return true;
    want->view = pen_stored_request_find_view(&want->request, name);
    return want->view >= 0 ||
           pen_fail(st, PEN_NOT_FOUND, "job %s has no view \"%.60s\"; its first is \"%s\"",
                    want->id, name, pen_stored_request_view(&want->request, 0));
}

static bool resolve_layer(struct wanted *want, const char *name, struct pen_status *st)
{
    want->layer = name ? pen_layer_find(name) : PEN_LAYER_BEAUTY;
    if (want->layer == PEN_LAYER_COUNT)
        return pen_fail(st, PEN_USAGE,
                        "layer must be one of beauty, cost, samples, depth, normal, albedo; found "
                        "\"%.60s\"",
                        name);
    return (want->request.layers >> want->layer & 1) ||
           pen_fail(st, PEN_NOT_FOUND, "the layer \"%s\" was not requested", name);
}

static bool resolve_format(struct wanted *want, const struct pen_image_query *query,
                           struct pen_status *st)
{
    const char *format = query->format;
    want->format = format ? pen_name_index(format, pen_image_formats) : FORMAT_PNG;
    if (want->format < 0)
        return pen_fail(st, PEN_USAGE, "format must be one of png, png16, pfm; found \"%.60s\"",
                        format);
    return query->max_edge == 0 || want->format == FORMAT_PNG ||
           pen_fail(st, PEN_USAGE,
                    "max_edge makes a small png; the format \"%s\" has every pixel, so it must "
                    "not be given with max_edge",
                    format);
}

/* Reads a stored layer. */
static bool load_layer(struct pen_jobs *jobs, const struct wanted *want, int view,
                       struct pen_film *film, struct pen_status *st)
{
    struct pen_buf file = {0};
    bool ok = pen_store_artefact(jobs->store, want->id, view, pen_layer_name(want->layer), "pfm",
                                 &file, st);
    if (ok && !pen_pfm_load(file.data, file.bytes, film, st))
        ok = pen_fail(st, PEN_STORAGE, "a layer of job %s is damaged", want->id);
    pen_buf_release(&file);
    return ok;
}

static bool load_view(struct pen_jobs *jobs, const struct wanted *want, int view,
                      struct pen_film *film, struct pen_status *st)
{
    int64_t filled = 0;
    if (want->layer != PEN_LAYER_BEAUTY)
        return load_layer(jobs, want, view, film, st);
    if (!pen_view_pixels_load(jobs->store, want->id, view, &want->request.settings, film, NULL,
                              NULL, &filled, st))
        return false;
    return filled == (int64_t)film->width * film->height ||
           pen_fail(st, PEN_STORAGE, "job %s lacks pixels of a view", want->id);
}

/* Copies a view into its cell of a contact sheet, whose corner is at x0, y0. Each pixel of the cell
 * is the mean of shrink × shrink pixels of the view. */
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

/* The layout of a contact sheet: cells in a grid as square as the number of views allows, with
 * black gaps between them. If the sheet is too large, all views are shrunk by the same integer
 * factor. */
struct sheet_layout {
    int columns, rows, shrink, gap;
    int width, height;             /* of a cell */
    int sheet_width, sheet_height; /* all in pixels */
};

static struct sheet_layout sheet_layout_of(const struct pen_stored_request *request)
{
    struct sheet_layout layout = {.columns = 1};
    while (layout.columns * layout.columns < request->view_count)
        layout.columns++;
    layout.rows = (request->view_count + layout.columns - 1) / layout.columns;
    do {
        layout.shrink++;
        layout.width = request->settings.width / layout.shrink;
        layout.height = request->settings.height / layout.shrink;
        layout.gap = 1 + layout.width / 128;
        layout.sheet_width = (layout.width + layout.gap) * layout.columns - layout.gap;
        layout.sheet_height = (layout.height + layout.gap) * layout.rows - layout.gap;
    } while ((double)layout.sheet_width * layout.sheet_height > SHEET_PIXELS_MAX &&
             layout.width > 1 && layout.height > 1);
    return layout;
}

static struct pen_film *make_sheet(struct pen_jobs *jobs, const struct wanted *want,
                                   struct pen_status *st)
{
    const struct pen_settings *s = &want->request.settings;
    struct sheet_layout layout = sheet_layout_of(&want->request);
    struct pen_film *sheet = pen_film_new(layout.sheet_width, layout.sheet_height, st);
    struct pen_film *view = sheet ? pen_film_new(s->width, s->height, st) : NULL;
    bool ok = view != NULL;
    for (int i = 0; ok && i < want->request.view_count; i++) {
        ok = load_view(jobs, want, i, view, st);
        if (ok)
            shrink_into(view, layout.shrink, i % layout.columns * (layout.width + layout.gap),
                        i / layout.columns * (layout.height + layout.gap), sheet);
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
    const struct pen_settings *s = &want->request.settings;
    struct pen_film *film = pen_film_new(s->width, s->height, st);
    if (film && load_view(jobs, want, want->view, film, st))
        return film;
    pen_film_free(film);
    return NULL;
}

static bool encode(const struct wanted *want, const struct pen_film *film, struct pen_buf *out,
                   struct pen_status *st)
{
    const struct pen_settings *s = &want->request.settings;
    const char *format = pen_image_formats[want->format];
    const struct pen_layer_task task = {
        .settings = s, .layer = want->layer, .cost = want->request.cost};
    double white;
    return want->layer == PEN_LAYER_BEAUTY ? pen_view_encode(film, s, format, out, st)
                                           : pen_layer_encode(&task, film, format, out, &white, st);
}

/* The PFM of a view is made in the memory of its pixels. */
static bool make_pfm(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                     struct pen_status *st)
{
    const struct pen_settings *s = &want->request.settings;
    struct pen_film film;
    const bool ok = pen_pfm_begin(s->width, s->height, out, &film, st) &&
                    load_view(jobs, want, want->view, &film, st) && pen_pfm_end(&film, out, st);
    if (!ok)
        pen_buf_release(out);
    return ok;
}

static bool make_picture(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                         struct pen_status *st)
{
    if (want->format == FORMAT_PFM && want->view != ALL_VIEWS)
        return make_pfm(jobs, want, out, st);
    struct pen_film *film =
        want->view == ALL_VIEWS ? make_sheet(jobs, want, st) : make_view(jobs, want, st);
    bool ok = film && encode(want, film, out, st);
    pen_film_free(film);
    return ok;
}

/* Gets the stored picture, or makes it. */
static bool get_picture(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                        struct pen_status *st)
{
    const char *format = pen_image_formats[want->format], *layer = pen_layer_name(want->layer);
    if (pen_store_artefact(jobs->store, want->id, want->view, layer, format, out, st))
        return true;
    return st->code == PEN_NOT_FOUND && make_picture(jobs, want, out, st);
}

/* Replaces a PNG whose longer edge exceeds max_edge pixels by a smaller PNG. */
static bool shrink(struct pen_buf *png, int max_edge, struct pen_status *st)
{
    const struct pen_png_options options = {.bits = 8, .transfer = PEN_TRANSFER_SRGB};
    struct pen_picture *picture = pen_picture_read(png->data, png->bytes, st);
    if (!picture)
        return false;
    bool ok = true;
    if (pen_picture_width(picture) > max_edge || pen_picture_height(picture) > max_edge) {
        struct pen_film *film = pen_picture_shrink(picture, max_edge, st);
        pen_buf_release(png);
        ok = film && pen_png_write(film, &options, png, st);
        pen_film_free(film);
    }
    pen_picture_free(picture);
    return ok;
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
    return pen_fail(st, PEN_CONFLICT, "job %s is %s; only a job that succeeded has its picture%s",
                    id, pen_job_state_name(state),
                    pen_job_state_ended(state) ? ""
                                               : ". The preview shows what is rendered so far");
}

bool pen_jobs_image(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                    struct pen_image *out, struct pen_status *st)
{
    struct wanted want = {.id = id};
    enum pen_job_state state;
    *out = (struct pen_image){0};
    if (!resolve_format(&want, query, st) || !read_job(jobs, id, &want.request, &state, st))
        return false;
    bool ok = resolve_layer(&want, query->layer, st) &&
              resolve_view(&want, query->view, true, st) && check_succeeded(id, state, st) &&
              get_picture(jobs, &want, &out->bytes, st) &&
              (query->max_edge == 0 || shrink(&out->bytes, query->max_edge, st)) &&
              fill_image(out, media_types[want.format]);
    pen_stored_request_release(&want.request);
    if (!ok)
        pen_buf_release(&out->bytes);
    return ok;
}

/* Reads a view of a job that has succeeded, with the values of its PFM file. */
static struct pen_picture *read_view(struct pen_jobs *jobs, const char *id, const char *view,
                                     struct pen_status *st)
{
    struct wanted want = {.id = id, .layer = PEN_LAYER_BEAUTY};
    enum pen_job_state state;
    struct pen_picture *picture = NULL;
    if (!read_job(jobs, id, &want.request, &state, st))
        return NULL;
    if (resolve_view(&want, view, false, st) && check_succeeded(id, state, st)) {
        struct pen_film *film = make_view(jobs, &want, st);
        const enum pen_transfer transfer = pen_settings_transfer(&want.request.settings);
        picture = film ? pen_picture_take_film(film, transfer, st) : NULL;
    }
    pen_stored_request_release(&want.request);
    return picture;
}

bool pen_jobs_compare(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                      struct pen_image *out, struct pen_status *st)
{
    const bool map = query->format && strcmp(query->format, "png") == 0;
    *out = (struct pen_image){0};
    struct pen_picture *a = read_view(jobs, id, query->view, st);
    struct pen_picture *b = a ? read_view(jobs, query->with, query->view, st) : NULL;
    bool ok = b != NULL;
    if (ok && !pen_picture_same_size(a, b, st)) {
        st->code = PEN_CONFLICT; /* of the two jobs */
        ok = false;
    }
    ok = ok && pen_comparison_write(a, b, map, &out->bytes, st) &&
         fill_image(out, map ? media_types[FORMAT_PNG] : "application/json");
    pen_picture_free(a);
    pen_picture_free(b);
    if (!ok)
        pen_buf_release(&out->bytes);
    return ok;
}

static bool make_preview(struct pen_jobs *jobs, const struct wanted *want, struct pen_buf *out,
                         struct pen_status *st)
{
    const struct pen_settings *s = &want->request.settings;
    int64_t filled;
    struct pen_film *film = pen_film_new(s->width, s->height, st);
    unsigned char *mask = film ? calloc((size_t)s->width, (size_t)s->height) : NULL;
    if (film && !mask)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a preview");
    struct pen_png_options options = {
        .bits = 8, .transfer = pen_settings_transfer(s), .mask = mask};
    bool ok =
        mask &&
        pen_view_pixels_load(jobs->store, want->id, want->view, s, film, mask, NULL, &filled, st) &&
        pen_png_write(film, &options, out, st);
    free(mask);
    pen_film_free(film);
    return ok;
}

bool pen_jobs_preview(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                      struct pen_image *out, struct pen_status *st)
{
    static const struct pen_image_query none = {0};
    struct wanted want = {.id = id};
    enum pen_job_state state;
    *out = (struct pen_image){0};
    if (!read_job(jobs, id, &want.request, &state, st))
        return false;
    query = query ? query : &none;
    bool ok = resolve_view(&want, query->view, false, st) &&
              make_preview(jobs, &want, &out->bytes, st) &&
              fill_image(out, media_types[FORMAT_PNG]);
    pen_stored_request_release(&want.request);
    if (!ok)
        pen_buf_release(&out->bytes);
    return ok;
}

/* Returns the statistics that a removed job has left. */
static json_t *removed_stats(struct pen_jobs *jobs, const char *id, struct pen_status *st)
{
    struct pen_buf text = {0};
    json_t *stats = NULL;
    if (pen_store_removed_stats(jobs->store, id, &text, st)) {
        stats = json_loadb((const char *)text.data, text.bytes, 0, NULL);
        if (!stats)
            pen_fail(st, PEN_STORAGE, "the stored statistics of job %s are damaged", id);
    }
    pen_buf_release(&text);
    return stats;
}

static json_t *read_stats(struct pen_jobs *jobs, const char *id, bool so_far, struct pen_status *st)
{
    struct pen_job_record job;
    if (!pen_store_job(jobs->store, id, &job, st))
        return st->code == PEN_GONE ? removed_stats(jobs, id, st) : NULL;
    json_t *stats = NULL;
    if (so_far || pen_job_state_ended(job.state))
        stats = pen_stats_of_job(jobs->store, &job, st);
    else
        pen_fail(st, PEN_CONFLICT, "job %s is %s; it has statistics when it has ended", id,
                 pen_job_state_name(job.state));
    pen_job_record_release(&job);
    return stats;
}

json_t *pen_jobs_stats(struct pen_jobs *jobs, const char *id, struct pen_status *st)
{
    return read_stats(jobs, id, false, st);
}

json_t *pen_jobs_stats_so_far(struct pen_jobs *jobs, const char *id, struct pen_status *st)
{
    return read_stats(jobs, id, true, st);
}
