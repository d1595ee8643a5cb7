/* SPDX-License-Identifier: MIT */
/* `penumbra render`: a scene to a picture in this process, without a daemon; the same reader,
 * renderer and encoders as the daemon's worker, hence the same bytes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "cmd/client/commands.h"
#include "cmd/client/output.h"
#include "cmd/client/pixel_report.h"
#include "cmd/client/progress.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "film/film.h"
#include "io/stats_json.h"
#include "render/render.h"
#include "scene/scene.h"

struct values {
    const char *output, *format, *view, *layer, *stats, *pixel;
    struct pen_option_list set;
    int threads;
    bool quiet, json;
};

static const struct pen_option options[] = {
    {.name = "output",
     .letter = 'o',
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, output),
     .value = "OUT",
     .help = "where the picture goes; .png or .pfm by its ending"},
    {.name = "format",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, format),
     .value = "png|png16|pfm",
     .choices = pen_output_formats,
     .help = "whatever the ending of OUT says"},
    {.name = "set",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, set),
     .value = "KEY=VALUE",
     .help = "a render setting, over what the scene says; may be repeated"},
    {.name = "view",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, view),
     .value = "NAME",
     .help = "which view of the scene, the first by default"},
    {.name = "layer",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, layer),
     .value = "NAME",
     .choices = pen_output_layers,
     .help = "beauty, the only one so far"},
    {.name = "threads",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, threads),
     .value = "N",
     .max = 1024,
     .help = "starts exactly that many; 0, the default, is one per core"},
    {.name = "stats",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, stats),
     .value = "FILE",
     .help = "writes times and ray counts there, as JSON"},
    {.name = "pixel",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, pixel),
     .value = "X,Y",
     .help =
         "prints that pixel in full precision; without -o and --stats nothing else is rendered"},
    {.name = "quiet",
     .letter = 'q',
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, quiet),
     .help = "no progress bar"},
    {.name = "json",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, json),
     .help = "print the result as a line of JSON"},
    {0}};

/* Everything one render holds; released whole, whatever was reached. */
struct render {
    const struct values *values;
    const char *format; /* of the output */
    int pixel_x, pixel_y;
    struct pen_source source;
    struct pen_arena *arena;
    struct pen_scene_desc desc; /* in the arena */
    struct pen_scene *scene;
    int view;
    struct pen_scene_precision precision; /* of the view, if `measured` */
    bool measured;
    struct pen_thread_pool *pool;
    struct pen_film *film;
    struct pen_render_stats stats;
    struct pen_buf encoded;
    double parse_ms, build_ms, encode_ms, total_ms;
    struct pen_progress progress;
    int tiles, tiles_done;
};

static double ms_since(int64_t start_ns)
{
    return (double)(pen_clock_ns() - start_ns) * 1e-6;
}

static bool check_values(struct render *r, struct pen_status *st)
{
    const struct values *v = r->values;
    if (!v->output && !v->stats && !v->pixel)
        return pen_fail(st, PEN_USAGE, "missing -o OUT (or --stats FILE, or --pixel X,Y)");
    if (v->format && !v->output)
        return pen_fail(st, PEN_USAGE, "--format: needs -o OUT");
    if (v->output && strcmp(v->output, "-") == 0 && (v->json || v->pixel))
        return pen_fail(st, PEN_USAGE, "-o -: standard output is also what --json and --pixel use");
    if (v->output && !(r->format = pen_output_format(v->output, v->format, st)))
        return false;
    if (v->output && v->stats && strcmp(v->output, v->stats) == 0)
        return pen_fail(st, PEN_USAGE, "--stats: is the same as -o, \"%s\"", v->stats);
    if (v->pixel && !pen_pixel_parse(v->pixel, &r->pixel_x, &r->pixel_y, st))
        return false;
    return pen_output_layer_check(v->layer, st);
}

/* A picture that cannot be written is not worth rendering. */
static bool check_files(const struct render *r, struct pen_status *st)
{
    const struct values *v = r->values;
    return (!v->output || pen_file_check(v->output, st)) &&
           (!v->stats || pen_file_check(v->stats, st));
}

/* Text to description. Errors of the document go to `errors`. */
static bool read_scene(struct render *r, const char *name, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    bool ok = pen_source_read(&r->source, name, limits.body_bytes, &st);
    if (ok && !(r->arena = pen_arena_new(0)))
        ok = pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    if (!ok) {
        pen_errors_add(errors, &st);
        return false;
    }
    int64_t start = pen_clock_ns();
    ok = pen_source_scene(&r->source, &limits, r->arena, &r->desc, errors);
    r->parse_ms = ms_since(start);
    return ok;
}

/* The command line's settings over the scene's. */
static bool apply_settings(struct render *r, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    const struct values *v = r->values;
    for (int i = 0; i < v->set.count; i++) {
        if (!pen_output_set(&r->desc.settings, v->set.item[i], st))
            return false;
    }
    return pen_limits_check(&limits, &r->desc, &r->desc.settings, 1, "", st);
}

static bool find_view(struct render *r, struct pen_status *st)
{
    const char *name = r->values->view;
    if (!name || (r->view = pen_scene_find_view(r->scene, name)) >= 0) /* else view 0 */
        return true;
    enum { MANY = 64 };
    const char *names[MANY + 1];
    uint32_t count = r->scene->view_count < MANY ? r->scene->view_count : MANY;
    for (uint32_t i = 0; i < count; i++)
        names[i] = r->scene->views[i].name;
    names[count] = NULL;
    const char *near = pen_nearest_name(name, names);
    return pen_fail(st, PEN_NOT_FOUND, "no view \"%s\", %s is \"%s\"", name,
                    near ? "nearest" : "the first", near ? near : names[0]);
}

static bool freeze(struct render *r, struct pen_status *st)
{
    int64_t start = pen_clock_ns();
    enum pen_accelerator kind = (enum pen_accelerator)r->desc.settings.accelerator;
    if (!(r->scene = pen_scene_freeze(&r->desc, kind, 0, st)))
        return false;
    r->build_ms = ms_since(start);
    return find_view(r, st);
}

/* Says so if the scene asks for more than numbers give. */
static void measure(struct render *r)
{
    const struct pen_settings *s = &r->desc.settings;
    char text[PEN_MSG_BYTES];
    r->measured = pen_scene_precision(r->scene, r->view, s->width, s->height, &r->precision);
    if (r->measured && pen_precision_warning(&r->precision, text, sizeof text))
        fprintf(stderr, "penumbra: %s: view \"%s\": warning: %s\n", r->source.label,
                r->scene->views[r->view].name, text);
}

static void tile_done(void *user, struct pen_rect rect)
{
    struct render *r = user;
    (void)rect;
    r->tiles_done++;
    pen_progress_show(&r->progress, (double)r->tiles_done / r->tiles, -1);
}

static bool render_view(struct render *r, struct pen_status *st)
{
    const struct pen_settings *settings = &r->desc.settings;
    if (!(r->film = pen_film_new(settings->width, settings->height, st)) ||
        !(r->pool = pen_thread_pool_new(r->values->threads, st)))
        return false;
    r->tiles = pen_tile_count(settings->width, settings->height, settings->tile);
    struct pen_render_task task = {.scene = r->scene,
                                   .view = r->view,
                                   .settings = settings,
                                   .tile_count = -1,
                                   .rgb = r->film->rgb,
                                   .tile_done = tile_done,
                                   .user = r,
                                   .keep_tile_ms = true};
    pen_progress_begin(&r->progress, r->source.label, r->values->quiet);
    bool ok = pen_render_run(r->pool, &task, &r->stats, st);
    pen_progress_end(&r->progress);
    return ok;
}

static bool write_picture(struct render *r, struct pen_status *st)
{
    int64_t start = pen_clock_ns();
    if (!pen_output_encode(r->format, r->film, &r->desc.settings, &r->encoded, st))
        return false;
    r->encode_ms = ms_since(start);
    return pen_file_write(r->values->output, r->encoded.data, r->encoded.bytes, st);
}

static json_t *make_stats(const struct render *r)
{
    struct pen_stats_input in = {.parse_ms = r->parse_ms,
                                 .build_ms = r->build_ms,
                                 .encode_ms = r->encode_ms,
                                 .total_ms = r->total_ms,
                                 .render = &r->stats,
                                 .accel = pen_accel_get_stats(r->scene->accel),
                                 .precision = r->measured ? &r->precision : NULL};
    return pen_stats_json(&in);
}

static bool write_stats(const struct render *r, struct pen_status *st)
{
    json_t *stats = make_stats(r);
    struct pen_buf text = {0};
    bool ok = pen_report_text(stats, &text, st) &&
              pen_file_write(r->values->stats, text.data, text.bytes, st);
    pen_buf_release(&text);
    json_decref(stats);
    return ok;
}

static void print_result(const struct render *r)
{
    const struct pen_settings *s = &r->desc.settings;
    pen_report_line(json_pack("{s:s?, s:s?, s:s, s:i, s:i, s:o}", "output", r->values->output,
                              "format", r->format, "view", r->scene->views[r->view].name, "width",
                              s->width, "height", s->height, "stats", make_stats(r)));
}

static bool show_pixel(struct render *r, struct pen_status *st)
{
    const struct pen_settings *s = &r->desc.settings;
    if (r->pixel_x >= s->width || r->pixel_y >= s->height)
        return pen_fail(st, PEN_USAGE, "--pixel: found \"%s\", allowed is 0 to %d, 0 to %d",
                        r->values->pixel, s->width - 1, s->height - 1);
    struct pen_pixel pixel = {
        .x = r->pixel_x, .y = r->pixel_y, .view = r->scene->views[r->view].name};
    if (!pen_render_pixel(r->scene, r->view, s, pixel.x, pixel.y, pixel.rgb, &pixel.rays, st))
        return false;
    if (r->values->json)
        pen_report_exact(pen_pixel_json(&pixel, s));
    else
        pen_pixel_print(&pixel, s);
    return true;
}

/* What is wanted of the frozen scene. */
static bool carry_out(struct render *r, int64_t start_ns, struct pen_status *st)
{
    const struct values *v = r->values;
    measure(r);
    if (v->pixel && !show_pixel(r, st))
        return false;
    if (!v->output && !v->stats)
        return true;
    if (!render_view(r, st) || (v->output && !write_picture(r, st)))
        return false;
    r->total_ms = ms_since(start_ns);
    if (v->stats && !write_stats(r, st))
        return false;
    if (v->json)
        print_result(r);
    return true;
}

static void release(struct render *r)
{
    free(r->stats.tile_ms);
    pen_film_free(r->film);
    pen_buf_release(&r->encoded);
    pen_thread_pool_free(r->pool);
    pen_scene_free(r->scene);
    pen_arena_free(r->arena);
    pen_source_release(&r->source);
}

static int render(struct render *r, const char *name)
{
    int64_t start = pen_clock_ns();
    bool json = r->values->json;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!check_values(r, &st))
        return pen_report_json(NULL, json, &st);
    if (!read_scene(r, name, &errors))
        return pen_report_errors_json(r->source.label, json, &errors);
    if (apply_settings(r, &st) && check_files(r, &st) && freeze(r, &st) && carry_out(r, start, &st))
        return 0;
    pen_source_locate(&r->source, &st);
    return pen_report_json(st.at[0] || st.line > 0 ? r->source.label : NULL, json, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {0};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_render, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct render r = {.values = &values};
    code = render(&r, parsed.args[0]);
    release(&r);
    return code;
}

const struct pen_command pen_command_render = {
    .program = "penumbra",
    .name = "render",
    .arguments = "SCENE -o OUT",
    .summary = "Renders a scene, without a daemon.",
    .details = "SCENE is a file, - for standard input, or builtin:NAME. OUT is written whole or "
               "not at all; - is standard output. The picture is the same bytes for any number "
               "of threads, and from a daemon.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
