/* SPDX-License-Identifier: MIT */
/* `penumbra explain`: which effects a scene calls for, and what a render will take. */
#include <stdio.h>
#include <stdlib.h>

#include "base/cpu.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/scene_input.h"
#include "cmd/client/setting_options.h"
#include "cmd/report.h"
#include "film/film.h"
#include "study/explain.h"

struct values {
    const char *view;
    struct pen_option_list set;
    int threads;
    bool analyze, json;
};

static const struct pen_option options[] = {
    {.name = "analyze",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, analyze),
     .help = "render the scene too, and show its figures beside the estimates"},
    PEN_SET_OPTION(struct values),
    PEN_VIEW_OPTION(struct values),
    PEN_RENDER_THREADS_OPTION(struct values),
    PEN_JSON_OPTION(struct values, "print the explanation as a line of JSON"),
    {0}};

/* All state of an explanation. run() frees what has been allocated, at any stage. */
struct explain {
    const struct values *values;
    struct pen_scene_input input;
    struct pen_scene *scene;
    struct pen_thread_pool *pool;
    int view;
    struct pen_forecast forecast;
    struct pen_film *film;
    struct pen_render_stats stats;
};

static bool prepare(struct explain *e, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc *desc = &e->input.desc;
    if (!pen_set_options_apply(&e->values->set, &desc->settings, st) ||
        !pen_limits_check(&limits, desc, &desc->settings, 1, "", st))
        return false;
    if (e->values->view)
        e->view = pen_scene_input_view(&e->input, e->values->view, st);
    if (e->view < 0)
        return false;
    desc->build_threads = e->values->threads ? e->values->threads : pen_cpu_count();
    e->scene = pen_scene_freeze(desc, (enum pen_accelerator)desc->settings.accelerator, 0, st);
    e->pool = e->scene ? pen_thread_pool_new(e->values->threads, st) : NULL;
    return e->pool != NULL;
}

static bool forecast(struct explain *e, struct pen_status *st)
{
    const struct pen_forecast_task task = {
        .scene = e->scene, .view = e->view, .settings = &e->input.desc.settings};
    return pen_forecast_make(e->pool, &task, &e->forecast, st);
}

static bool analyze(struct explain *e, struct pen_status *st)
{
    const struct pen_settings *s = &e->input.desc.settings;
    if (!e->values->analyze)
        return true;
    if (!(e->film = pen_film_new(s->width, s->height, st)))
        return false;
    const struct pen_render_task task = {
        .scene = e->scene, .view = e->view, .settings = s, .tile_count = -1, .rgb = e->film->rgb};
    return pen_render_run(e->pool, &task, &e->stats, st);
}

static void print_explanation(const struct explain *e)
{
    const struct pen_explain_task task = {.desc = &e->input.desc,
                                          .settings = &e->input.desc.settings,
                                          .view = e->view,
                                          .forecast = &e->forecast,
                                          .actual = e->values->analyze ? &e->stats : NULL};
    json_t *json = pen_explain_json(&task);
    struct pen_buf text = {0};
    if (e->values->json) {
        pen_report_line(json);
        return;
    }
    if (json)
        pen_explain_write_text(json, &text);
    if (pen_buf_add(&text, "", 1))
        pen_report_show(stdout, (const char *)text.data);
    pen_buf_release(&text);
    json_decref(json);
}

static int explain(struct explain *e, const char *name)
{
    const bool json = e->values->json;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!pen_scene_input_read(&e->input, name, NULL, &errors))
        return pen_report_errors_json(e->input.source.label, json, &errors);
    if (!prepare(e, &st) || !forecast(e, &st) || !analyze(e, &st)) {
        pen_source_locate(&e->input.source, &st);
        return pen_report_json(st.at[0] || st.line > 0 ? e->input.source.label : NULL, json, &st);
    }
    print_explanation(e);
    return 0;
}

static int run(int argc, char **argv)
{
    struct values values = {0};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_explain, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct explain e = {.values = &values};
    code = explain(&e, parsed.args[0]);
    pen_forecast_release(&e.forecast);
    pen_film_free(e.film);
    pen_thread_pool_free(e.pool);
    pen_scene_free(e.scene);
    pen_scene_input_release(&e.input);
    return code;
}

const struct pen_command pen_command_explain = {
    .program = "penumbra",
    .name = "explain",
    .arguments = "SCENE",
    .summary = "Says which effects a scene calls for and why, and what it will take.",
    .details = "SCENE is a file, - for standard input, or builtin:NAME. Rays, time and memory are "
               "estimated by a pre-render of one pixel in a hundred, at least 4096, with 95 % "
               "intervals. The processor time is that of all threads. The time by the clock is "
               "given for the present load, and for an idle machine.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
