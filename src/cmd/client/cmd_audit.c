/* SPDX-License-Identifier: MIT */
/* `penumbra audit`: how many pixels of a picture are wrong, whatever program made it. */
#include <inttypes.h>
#include <stdlib.h>

#include "base/cpu.h"
#include "cmd/client/audit_options.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/scene_input.h"
#include "cmd/client/setting_options.h"
#include "cmd/report.h"
#include "film/picture.h"
#include "io/stats_json.h"
#include "scene/scene.h"
#include "study/hash.h"

struct values {
    const char *view;
    struct pen_option_list set;
    double threshold, max_wrong;
    int audit_pixels, samples, threads;
    bool json;
};

static const struct pen_option options[] = {
    PEN_AUDIT_OPTIONS(struct values, threshold),
    {.name = "samples",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, samples),
     .value = "N",
     .min = 8,
     .max = 1 << 30,
     .help = "samples of each pixel that is rendered again, 4096 by default; take 64 times the "
             "samples of the picture"},
    {.name = "max-wrong",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, max_wrong),
     .value = "P",
     .max = 1,
     .help = "fail if the share of the pixels that may be wrong is larger"},
    PEN_SET_OPTION(struct values),
    PEN_VIEW_OPTION(struct values),
    PEN_RENDER_THREADS_OPTION(struct values),
    PEN_JSON_OPTION(struct values, "print what is found as a line of JSON"),
    {0}};

/* All state of an audit. run() frees what has been allocated, at any stage. */
struct audit {
    const struct values *values;
    struct pen_scene_input input;
    struct pen_scene *scene;
    struct pen_thread_pool *pool;
    struct pen_film *film;
    int view;
};

/* Its errors name the file. */
static struct pen_picture *read_picture(const char *path, struct pen_status *st)
{
    struct pen_source source; /* a path or - */
    struct pen_picture *picture = NULL;
    struct pen_status cause;
    if (pen_source_read(&source, path, 0, &cause))
        picture = pen_picture_read(source.text.data, source.text.bytes, &cause);
    pen_source_release(&source);
    if (!picture)
        pen_fail(st, cause.code, "%.200s: %.200s", path, cause.msg);
    return picture;
}

/* Reads the picture as the film that it may have been made from. */
static bool read_film(struct audit *a, const char *path, struct pen_status *st)
{
    const struct pen_settings *s = &a->input.desc.settings;
    struct pen_picture *picture = NULL;
    double *row = malloc(3 * (size_t)s->width * sizeof *row);
    bool ok = row || pen_fail(st, PEN_NO_MEMORY, "out of memory for a row of pixels");
    ok = ok && (picture = read_picture(path, st)) != NULL;
    if (ok && (pen_picture_width(picture) != s->width || pen_picture_height(picture) != s->height))
        ok = pen_fail(st, PEN_INVALID,
                      "%s: has %d x %d pixels, the scene is rendered with %d x %d; give the "
                      "picture's size by --set width=%d --set height=%d",
                      path, pen_picture_width(picture), pen_picture_height(picture), s->width,
                      s->height, pen_picture_width(picture), pen_picture_height(picture));
    ok = ok && (a->film = pen_film_new(s->width, s->height, st)) != NULL;
    if (ok && s->transfer == PEN_SETTING_DISPLAY)
        pen_picture_set_linear(picture);
    for (int y = 0; ok && y < s->height; y++) {
        float *to = a->film->rgb + 3 * (size_t)y * (size_t)s->width;
        pen_picture_linear_row(picture, y, row);
        for (int i = 0; i < 3 * s->width; i++)
            to[i] = (float)row[i];
    }
    pen_picture_free(picture);
    free(row);
    return ok;
}

static bool prepare(struct audit *a, const char *picture, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc *desc = &a->input.desc;
    if (!pen_set_options_apply(&a->values->set, &desc->settings, st) ||
        !pen_limits_check(&limits, desc, &desc->settings, 1, "", st))
        return false;
    if (a->values->view)
        a->view = pen_scene_input_view(&a->input, a->values->view, st);
    if (a->view < 0 || !read_film(a, picture, st))
        return false;
    desc->build_threads = a->values->threads ? a->values->threads : pen_cpu_count();
    a->scene = pen_scene_freeze(desc, (enum pen_accelerator)desc->settings.accelerator, 0, st);
    a->pool = a->scene ? pen_thread_pool_new(a->values->threads, st) : NULL;
    return a->pool != NULL;
}

static bool audit(struct audit *a, const char *picture, struct pen_status *st)
{
    const struct values *v = a->values;
    struct pen_audit found;
    if (!prepare(a, picture, st))
        return false;
    const struct pen_audit_task task = {.scene = a->scene,
                                        .view = a->view,
                                        .settings = &a->input.desc.settings,
                                        .rgb = a->film->rgb,
                                        .samples = v->samples,
                                        .pixels = (uint64_t)v->audit_pixels,
                                        .threshold = v->threshold,
                                        .seed = pen_audit_seed(a->film)};
    if (!pen_audit_run(a->pool, &task, &found, st))
        return false;
    if (v->json)
        pen_report_line(pen_stats_audit(&found));
    else
        pen_audit_print(&found, picture, stdout);
    return v->max_wrong < 0 || found.bound <= v->max_wrong ||
           pen_fail(st, PEN_DIFFERENT,
                    "up to a share of %.4g of the pixels may be wrong, allowed is %g", found.bound,
                    v->max_wrong);
}

static int report(struct audit *a, char **args)
{
    const bool json = a->values->json;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!pen_scene_input_read(&a->input, args[0], NULL, &errors))
        return pen_report_errors_json(a->input.source.label, json, &errors);
    if (audit(a, args[1], &st))
        return 0;
    pen_source_locate(&a->input.source, &st);
    return pen_report_json(st.at[0] || st.line > 0 ? a->input.source.label : NULL, json, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {.threshold = PEN_AUDIT_THRESHOLD,
                            .max_wrong = -1,
                            .audit_pixels = PEN_AUDIT_PIXELS,
                            .samples = PEN_AUDIT_FOREIGN};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_audit, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct audit a = {.values = &values};
    code = report(&a, parsed.args);
    pen_film_free(a.film);
    pen_thread_pool_free(a.pool);
    pen_scene_free(a.scene);
    pen_scene_input_release(&a.input);
    return code;
}

const struct pen_command pen_command_audit = {
    .program = "penumbra",
    .name = "audit",
    .arguments = "SCENE PICTURE",
    .summary = "Says how many pixels of a picture can be wrong, by rendering some of them again.",
    .details =
        "SCENE is a file, - for standard input, or builtin:NAME. PICTURE is a PNG or PFM file of "
        "it, made by any program. A pixel is wrong if a channel is off by more than --threshold, "
        "0.01 by default, from its converged value at the scene's max_depth and min_contribution. "
        "The pixels are drawn by a hash of the picture. A pixel whose value stays too uncertain "
        "counts as wrong. The rounding of an 8-bit PNG, up to 0.002, counts as an error of the "
        "picture.",
    .options = options,
    .min_args = 2,
    .max_args = 2,
    .run = run,
};
