/* SPDX-License-Identifier: MIT */
/* `penumbra render`: renders a scene to a picture in this process, without a daemon. The reader,
 * the renderer and the encoders are those of the daemon's worker, so the bytes are the same. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "cmd/client/audit_options.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/output.h"
#include "cmd/client/pixel_report.h"
#include "cmd/client/progress.h"
#include "cmd/client/rounds_options.h"
#include "cmd/client/scene_input.h"
#include "cmd/client/setting_options.h"
#include "cmd/report.h"
#include "film/film.h"
#include "io/figures.h"
#include "io/stats_json.h"
#include "render/layer_file.h"
#include "render/render.h"
#include "scene/empty_view.h"
#include "scene/scene.h"
#include "study/hash.h"

struct values {
    const char *output, *format, *view, *layer, *cost, *stats, *pixel;
    struct pen_option_list set;
    const char *repeat;
    double audit, budget;
    int audit_pixels, threads;
    struct pen_model_options model;
    bool quiet, json;
};

static const struct pen_option options[] = {
    PEN_OUTPUT_OPTION(struct values, "OUT",
                      "the picture's file; its ending, .png or .pfm, gives the format"),
    PEN_FORMAT_OPTION(struct values, "png|png16|pfm", pen_output_formats),
    PEN_SET_OPTION(struct values),
    PEN_VIEW_OPTION(struct values),
    PEN_MODEL_OPTIONS(struct values),
    {.name = "layer",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, layer),
     .value = "NAME",
     .choices = pen_layer_names,
     .help = "what to write: beauty (the picture), cost or samples of each pixel, or depth, normal "
             "or albedo of the surface in it. PFM has numbers, PNG a picture of them"},
    {.name = "cost",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, cost),
     .value = "time|tests",
     .choices = pen_cost_names,
     .help = "what --layer cost is: nanoseconds, the default, or box and primitive tests"},
    PEN_RENDER_THREADS_OPTION(struct values),
    {.name = "stats",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, stats),
     .value = "FILE",
     .help = "write times and ray counts to FILE, as JSON"},
    PEN_ROUNDS_OPTIONS(struct values),
    PEN_AUDIT_OPTIONS(struct values, audit),
    {.name = "pixel",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, pixel),
     .value = "X,Y",
     .help = "print that pixel in full precision; without -o and --stats only that pixel is "
             "rendered"},
    PEN_QUIET_OPTION(struct values,
                     "no progress bar and no closing line, which only a terminal shows"),
    PEN_JSON_OPTION(struct values, "print the result as a line of JSON"),
    {0}};

/* All state of a render. release() frees what has been allocated, at any stage. */
struct render {
    const struct values *values;
    const char *format; /* of the output */
    enum pen_layer layer;
    int pixel_x, pixel_y;
    struct pen_scene_input input;
    int view; /* its index in the scene */
    struct pen_scene *scene;
    bool has_precision;
    struct pen_scene_precision precision; /* of the view */
    struct pen_thread_pool *pool;
    struct pen_film *film;
    struct pen_adaptive *adaptive; /* with a target error */
    struct pen_render_stats stats;
    struct pen_audit audit; /* with --audit */
    int64_t start_ns;
    struct pen_rounds_wanted rounds;
    struct pen_buf encoded;
    struct pen_output picture; /* its bytes are `encoded` */
    double build_ms, encode_ms, total_ms;
    struct pen_progress progress;
    int tiles, tiles_done;
};

static double ms_since(int64_t start_ns)
{
    return (double)(pen_clock_ns() - start_ns) * 1e-6;
}

static bool check_layer(struct render *r, struct pen_status *st)
{
    const struct values *v = r->values;
    r->layer = v->layer ? pen_layer_find(v->layer) : PEN_LAYER_BEAUTY;
    if (v->cost && r->layer != PEN_LAYER_COST)
        return pen_fail(st, PEN_USAGE, "--cost: needs --layer cost");
    if (r->layer == PEN_LAYER_BEAUTY)
        return true;
    if (!v->output)
        return pen_fail(st, PEN_USAGE, "--layer %s: needs -o OUT", v->layer);
    if (v->stats || v->pixel)
        return pen_fail(st, PEN_USAGE, "--layer %s: has no %s, which is of the beauty", v->layer,
                        v->stats ? "--stats" : "--pixel");
    return true;
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
    if (v->repeat && (v->budget >= 0 || v->set.count > 0))
        return pen_fail(st, PEN_USAGE,
                        "--%s: does not go with --repeat, whose statistics have all settings",
                        v->budget >= 0 ? "budget" : "set");
    if ((v->budget >= 0 || v->repeat) && v->layer)
        return pen_fail(st, PEN_USAGE, "--layer: does not go with --%s",
                        v->repeat ? "repeat" : "budget");
    if (v->output && v->stats && strcmp(v->output, v->stats) == 0)
        return pen_fail(st, PEN_USAGE, "--stats: is the same as -o, \"%s\"", v->stats);
    if (v->pixel && !pen_pixel_parse(v->pixel, &r->pixel_x, &r->pixel_y, st))
        return false;
    return check_layer(r, st);
}

/* Checks before the work that the results can be written. */
static bool check_files(const struct render *r, struct pen_status *st)
{
    const struct values *v = r->values;
    return (!v->output || pen_file_check(v->output, st)) &&
           (!v->stats || pen_file_check(v->stats, st));
}

/* Applies the command line's settings and view to the scene. */
static bool apply_options(struct render *r, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc *desc = &r->input.desc;
    const struct values *v = r->values;
    const char *view = v->view;
    if (!pen_set_options_apply(&v->set, &desc->settings, st) ||
        !pen_rounds_begin(&r->rounds, &r->input, v->budget, v->repeat, r->start_ns, st) ||
        !pen_limits_check(&limits, desc, &desc->settings, 1, "", st))
        return false;
    r->view = view ? pen_scene_input_view(&r->input, view, st) : 0;
    return r->view >= 0;
}

static bool freeze(struct render *r, struct pen_status *st)
{
    int64_t start = pen_clock_ns();
    r->input.desc.build_threads = r->values->threads ? r->values->threads : pen_cpu_count();
    enum pen_accelerator kind = (enum pen_accelerator)r->input.desc.settings.accelerator;
    r->scene = pen_scene_freeze(&r->input.desc, kind, 0, st);
    r->build_ms = ms_since(start);
    return r->scene != NULL;
}

/* Warns of a view in which nothing is visible. */
static void check_empty(const struct render *r)
{
    const struct pen_settings *s = &r->input.desc.settings;
    char text[PEN_MSG_BYTES];
    if (pen_view_empty_warning(r->scene, r->view, s->width, s->height, text, sizeof text))
        pen_report_say(stderr, "penumbra: %s: view \"%s\": warning: %s", r->input.source.label,
                       r->scene->views[r->view].name, text);
}

/* Measures how well doubles resolve the scene in this view, and warns if that is too coarse. */
static void check_precision(struct render *r)
{
    const struct pen_settings *s = &r->input.desc.settings;
    char text[PEN_MSG_BYTES];
    r->has_precision = pen_scene_precision(r->scene, r->view, s->width, s->height, &r->precision);
    if (r->has_precision && pen_precision_warning(&r->precision, text, sizeof text))
        pen_report_say(stderr, "penumbra: %s: view \"%s\": warning: %s", r->input.source.label,
                       r->scene->views[r->view].name, text);
    if (r->has_precision && pen_thinness_warning(&r->precision, text, sizeof text))
        pen_report_say(stderr, "penumbra: %s: primitive %u: warning: %s", r->input.source.label,
                       (unsigned)r->precision.thin_prim, text);
}

/* Warns of samples that are missing in the picture. */
static void check_dropped(const struct render *r, const struct pen_ray_counts *rays)
{
    char text[PEN_MSG_BYTES];
    if (pen_dropped_warning(rays, text, sizeof text))
        pen_report_say(stderr, "penumbra: %s: view \"%s\": warning: %s", r->input.source.label,
                       r->scene->views[r->view].name, text);
}

static void tile_done(void *user, struct pen_rect rect)
{
    struct render *r = user;
    (void)rect;
    r->tiles_done++;
    pen_progress_show(&r->progress, (double)r->tiles_done / r->tiles, -1);
}

/* The error falls as the number of samples to the power of -0.625 (render/adaptive.c). */
static void round_done(void *user, const struct pen_round *round)
{
    struct render *r = user;
    const double target = r->input.desc.settings.target_error;
    if (round->high > 0)
        pen_progress_show(&r->progress, fmin(1, pow(target / round->high, 1.6)), -1);
}

static bool render_view(struct render *r, struct pen_status *st)
{
    const struct pen_settings *settings = &r->input.desc.settings;
    if (!(r->film = pen_film_new(settings->width, settings->height, st)) ||
        !(r->pool = pen_thread_pool_new(r->values->threads, st)) ||
        (r->format &&
         !pen_output_begin(&r->picture, r->format, r->film, settings, &r->encoded, st)))
        return false;
    r->tiles = pen_tile_count(settings->width, settings->height, settings->tile);
    struct pen_render_task task = {.scene = r->scene,
                                   .view = r->view,
                                   .settings = settings,
                                   .tile_count = -1,
                                   .rgb = r->film->rgb,
                                   .tile_done = tile_done,
                                   .user = r,
                                   .round_done = round_done,
                                   .deadline_ns = r->rounds.deadline_ns,
                                   .repeat = r->rounds.repeat,
                                   .rows_done = r->format ? pen_output_rows : NULL,
                                   .rows_user = &r->picture,
                                   .keep_tile_ms = true};
    pen_progress_begin(&r->progress, r->input.source.label, r->values->quiet);
    bool ok = pen_settings_adaptive(settings)
                  ? (r->adaptive = pen_adaptive_new(settings, st)) &&
                        pen_render_rounds(r->pool, &task, r->adaptive, &r->stats, st)
                  : pen_render_run(r->pool, &task, &r->stats, st);
    pen_progress_end(&r->progress);
    return ok;
}

/* Renders some pixels of the picture again, and prints how many pixels can be wrong. */
static bool audit_view(struct render *r, struct pen_status *st)
{
    if (r->values->audit < 0)
        return true;
    const struct pen_audit_task task = {.scene = r->scene,
                                        .view = r->view,
                                        .settings = &r->input.desc.settings,
                                        .rgb = r->film->rgb,
                                        .adaptive = r->adaptive,
                                        .pixels = (uint64_t)r->values->audit_pixels,
                                        .threshold = r->values->audit,
                                        .seed = pen_audit_seed(r->film)};
    if (!pen_audit_run(r->pool, &task, &r->audit, st))
        return false;
    if (!r->values->quiet && !r->values->json)
        pen_audit_print(&r->audit, r->input.source.label, stderr);
    return true;
}

/* Warns that a part of the picture is missing. */
static void warn_truncated(const struct render *r)
{
    const struct pen_settings sampling = pen_settings_sampling(&r->input.desc.settings);
    if (r->stats.rays.truncated_paths)
        pen_report_say(
            stderr,
            "penumbra: %s: view \"%s\": warning: %" PRIu64
            " paths are cut off, because their pixel samples have %d surfaces; lower max_depth "
            "or raise min_contribution",
            r->input.source.label, r->scene->views[r->view].name, r->stats.rays.truncated_paths,
            pen_tree_surfaces_max(&sampling, pen_effects_blur(r->stats.effects)));
}

/* Warns that some surfaces of solids are missing, or that the eye is on a surface. */
static void warn_unmatched(const struct render *r)
{
    if (r->stats.rays.unmatched_exits)
        pen_report_say(stderr,
                       "penumbra: %s: view \"%s\": warning: %" PRIu64
                       " paths leave a solid that they have not entered; penumbra validate names "
                       "the solids that do not close",
                       r->input.source.label, r->scene->views[r->view].name,
                       r->stats.rays.unmatched_exits);
}

static enum pen_cost cost_of(const struct render *r)
{
    const char *cost = r->values->cost;
    return cost && strcmp(cost, pen_cost_names[PEN_COST_TESTS]) == 0 ? PEN_COST_TESTS
                                                                     : PEN_COST_TIME;
}

/* Prints the value that white has in a layer of numbers; the file has it as text. */
static void print_layer(const struct render *r, double white)
{
    const char *name = pen_layer_name(r->layer);
    if (r->values->json)
        pen_report_line(json_pack("{s:s?, s:s?, s:s, s:s, s:o}", "output", r->values->output,
                                  "format", r->format, "view", r->scene->views[r->view].name,
                                  "layer", name, "white", pen_figure(white)));
    else if (white > 0 && !r->values->quiet)
        pen_report_say(stderr, "penumbra: %s: %s: white is %.6g%s", r->input.source.label, name,
                       white,
                       r->layer != PEN_LAYER_COST     ? ""
                       : cost_of(r) == PEN_COST_TESTS ? " tests per pixel"
                                                      : " nanoseconds per pixel");
}

/* The last line on a terminal: "room.png 1000×1400, 0.9 s, 6.8 M rays". */
static void print_closing_line(const struct render *r)
{
    const struct pen_settings *s = &r->input.desc.settings;
    const struct values *v = r->values;
    const struct pen_ray_counts *rays = &r->stats.rays;
    char took[16], count[16];
    if (!v->output || v->quiet || v->json || !isatty(STDERR_FILENO))
        return;
    double seconds = ms_since(r->start_ns) * 1e-3;
    if (seconds < 60)
        snprintf(took, sizeof took, seconds < 0.1 ? "%.3f s" : "%.1f s", seconds);
    else
        pen_progress_time(seconds, took);
    pen_progress_count(
        (double)(rays->primary + rays->shadow + rays->reflection + rays->transmission), count);
    pen_report_say(stderr, "%s %d×%d, %s%s%s%s",
                   strcmp(v->output, "-") == 0 ? "standard output" : v->output, s->width, s->height,
                   took, rays->primary ? ", " : "", rays->primary ? count : "",
                   rays->primary ? " rays" : "");
}

static bool write_layer(struct render *r, struct pen_status *st)
{
    const struct pen_settings *s = &r->input.desc.settings;
    double white = 0;
    if (!(r->film = pen_film_new(s->width, s->height, st)) ||
        !(r->pool = pen_thread_pool_new(r->values->threads, st)))
        return false;
    const struct pen_layer_task task = {.scene = r->scene,
                                        .view = r->view,
                                        .settings = s,
                                        .layer = r->layer,
                                        .cost = cost_of(r),
                                        .rgb = r->film->rgb};
    if (!pen_layer_render(r->pool, &task, st) ||
        !pen_layer_encode(&task, r->film, r->format, &r->encoded, &white, st) ||
        !pen_file_write(r->values->output, r->encoded.data, r->encoded.bytes, st))
        return false;
    print_layer(r, white);
    print_closing_line(r);
    return true;
}

static bool write_picture(struct render *r, struct pen_status *st)
{
    if (!pen_output_end(&r->picture, st))
        return false;
    r->encode_ms = ms_since(r->stats.done_ns);
    return pen_file_write(r->values->output, r->encoded.data, r->encoded.bytes, st);
}

static json_t *make_stats(const struct render *r)
{
    struct pen_stats_input in = {.parse_ms = r->input.parse_ms,
                                 .build_ms = r->build_ms,
                                 .encode_ms = r->encode_ms,
                                 .total_ms = r->total_ms,
                                 .render = &r->stats,
                                 .accel = pen_accel_get_stats(r->scene->accel),
                                 .precision = r->has_precision ? &r->precision : NULL,
                                 .audit = r->values->audit >= 0 ? &r->audit : NULL,
                                 .scene = r->scene,
                                 .scene_bytes =
                                     pen_scene_bytes(r->scene) + pen_arena_used(r->input.arena),
                                 .settings = &r->input.desc.settings,
                                 .scene_sha256 = r->rounds.scene_sha256};
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
    const struct pen_settings *s = &r->input.desc.settings;
    pen_report_line(json_pack("{s:s?, s:s?, s:s, s:i, s:i, s:o}", "output", r->values->output,
                              "format", r->format, "view", r->scene->views[r->view].name, "width",
                              s->width, "height", s->height, "stats", make_stats(r)));
}

/* Renders one pixel. With a target error this follows the picture, on which the pixel's samples
 * depend. */
static bool show_pixel(struct render *r, struct pen_status *st)
{
    const struct pen_settings *s = &r->input.desc.settings;
    if (r->pixel_x >= s->width || r->pixel_y >= s->height)
        return pen_fail(st, PEN_USAGE, "--pixel: found \"%s\", allowed is 0 to %d, 0 to %d",
                        r->values->pixel, s->width - 1, s->height - 1);
    struct pen_pixel pixel = {
        .x = r->pixel_x, .y = r->pixel_y, .view = r->scene->views[r->view].name};
    if (r->adaptive
            ? !pen_render_refined_pixel(r->scene, r->view, r->adaptive, pixel.x, pixel.y, pixel.rgb,
                                        &pixel.rays, st)
            : !pen_render_pixel(r->scene, r->view, s, pixel.x, pixel.y, pixel.rgb, &pixel.rays, st))
        return false;
    check_dropped(r, &pixel.rays);
    if (r->values->json)
        pen_report_exact(pen_pixel_json(&pixel, s));
    else
        pen_pixel_print(&pixel, s);
    return true;
}

/* Renders and writes the results that the options ask for: a pixel, a picture, statistics. */
static bool make_results(struct render *r, int64_t start_ns, struct pen_status *st)
{
    const struct values *v = r->values;
    pen_scene_input_warn(&r->input);
    check_empty(r);
    check_precision(r);
    if (r->layer != PEN_LAYER_BEAUTY)
        return write_layer(r, st);
    const bool adaptive = pen_settings_adaptive(&r->input.desc.settings);
    if (v->pixel && !adaptive && !show_pixel(r, st))
        return false;
    if (!v->output && !v->stats && !adaptive)
        return true;
    if (!render_view(r, st) || (v->pixel && adaptive && !show_pixel(r, st)))
        return false;
    check_dropped(r, &r->stats.rays);
    if (adaptive)
        pen_rounds_tell(&r->stats.adaptive, r->input.source.label, r->scene->views[r->view].name,
                        v->quiet || v->json);
    if (!v->output && !v->stats)
        return true;
    if (v->output && !write_picture(r, st))
        return false;
    if (!audit_view(r, st))
        return false;
    r->total_ms = ms_since(start_ns);
    warn_truncated(r);
    warn_unmatched(r);
    if (v->stats && !write_stats(r, st))
        return false;
    if (v->json)
        print_result(r);
    print_closing_line(r);
    return true;
}

static void release(struct render *r)
{
    free(r->stats.tile_ms);
    free(r->rounds.repeat);
    pen_output_release(&r->picture);
    pen_film_free(r->film);
    pen_adaptive_free(r->adaptive);
    pen_buf_release(&r->encoded);
    pen_thread_pool_free(r->pool);
    pen_scene_free(r->scene);
    pen_scene_input_release(&r->input);
}

static int render(struct render *r, const char *name)
{
    int64_t start = pen_clock_ns();
    r->start_ns = start;
    bool json = r->values->json;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!check_values(r, &st))
        return pen_report_json(NULL, json, &st);
    if (!pen_scene_input_read(&r->input, name, &r->values->model, &errors))
        return pen_report_errors_json(r->input.source.label, json, &errors);
    if (apply_options(r, &st) && check_files(r, &st) && freeze(r, &st) &&
        make_results(r, start, &st))
        return 0;
    pen_source_locate(&r->input.source, &st);
    return pen_report_json(st.at[0] || st.line > 0 ? r->input.source.label : NULL, json, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {.audit = -1, .budget = -1, .audit_pixels = PEN_AUDIT_PIXELS};
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
               "not at all; - is standard output, a PNG unless --format says otherwise. The bytes "
               "of the picture do not depend on the "
               "number of threads, and are the same from a daemon.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
