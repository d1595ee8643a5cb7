/* SPDX-License-Identifier: MIT */
/* Reads a submission: a job or a bare scene; its scene, views, settings, limits. */
#include "jobs/internal/request.h"

#include <stdio.h>
#include <string.h>

#include "io/builtin.h"
#include "jobs/internal/members.h"
#include "render/audit.h"
#include "render/layers.h"
#include "study/bill.h"

static const char builtin_prefix[] = "builtin:";

/* The default timeout, a day, so that no job holds a worker for ever. */
enum { TIMEOUT_S = 24 * 60 * 60 };

/* The priority of an explanation without a render, because it is short and a client waits for
 * it. */
enum { EXPLAIN_PRIORITY = 100 };

static void fail_unknown_scene(const char *name, struct pen_errors *errors)
{
    pen_request_fail(errors, PEN_NOT_FOUND, "", "scene", "there is no built-in scene \"%.60s\"%s",
                     name, pen_did_you_mean(pen_builtin_nearest(name)).text);
}

/* Parses a scene that is a separate text. `text` must outlive the request. */
static void read_own(struct pen_request *request, const char *text, size_t bytes, bool xml,
                     const struct pen_limits *limits, struct pen_errors *errors)
{
    struct pen_status st;
    if (!pen_document_parse(text, bytes, xml, limits, &request->own, &st))
        pen_errors_add(errors, &st);
    request->has = &request->own;
    request->scene = request->own.json;
    request->scene_text = text;
    request->scene_bytes = bytes;
}

/* Finds and parses the scene that "builtin:NAME" names. */
static void find_builtin(struct pen_request *request, const char *text,
                         const struct pen_limits *limits, struct pen_errors *errors)
{
    const char *name = text + strlen(builtin_prefix);
    size_t bytes = 0;
    const char *document = pen_builtin_find(name, &bytes);
    if (!document) {
        fail_unknown_scene(name, errors);
        return;
    }
    read_own(request, document, bytes, false, limits, errors);
}

/* Fails because the body is neither a job nor a scene. If a key looks misspelt, the error suggests
 * the right key. */
static void fail_neither(const struct pen_request *request, struct pen_errors *errors)
{
    static const char *const names[] = {"scene", "format", NULL};
    const char *key;
    json_t *value;
    json_object_foreach(request->body, key, value)
    {
        const char *near = pen_nearest_name(key, names);
        if (near) {
            pen_request_fail(errors, PEN_INVALID, "", key, "unknown key%s",
                             pen_did_you_mean(near).text);
            return;
        }
    }
    pen_request_fail(errors, PEN_INVALID, "", NULL,
                     "must be a job, an object with \"scene\", or a scene, an object with "
                     "\"format\"; found %s",
                     json_is_object(request->body) ? "neither key" : pen_found(request->body).text);
}

/* Finds the scene document in the body, or the built-in scene that the body names. request->scene
 * stays NULL after an error. */
static void find_scene(struct pen_request *request, const struct pen_submission *in,
                       const struct pen_limits *limits, struct pen_errors *errors)
{
    const json_t *scene = json_object_get(request->body, "scene");
    const char *text = json_string_value(scene);
    request->bare = !scene && json_object_get(request->body, "format");
    request->scene_at = request->bare ? "" : "/scene";
    if (request->bare) {
        request->scene = request->body;
        request->scene_text = in->body;
        request->scene_bytes = in->bytes;
    } else if (json_is_object(scene)) {
        request->scene = scene;
        request->scene_text = pen_json_member(in->body, in->bytes, "scene", &request->scene_bytes);
    } else if (text && strncmp(text, builtin_prefix, strlen(builtin_prefix)) == 0) {
        find_builtin(request, text, limits, errors);
    } else if (text && pen_text_is_xml(text, json_string_length(scene))) {
        read_own(request, text, json_string_length(scene), true, limits, errors);
    } else if (scene) {
        pen_request_fail(errors, PEN_INVALID, "", "scene",
                         "must be a scene, \"builtin:\" and a name, or a scene in XML as a string, "
                         "found %s",
                         pen_found(scene).text);
    } else {
        fail_neither(request, errors);
    }
}

/* Returns the index of the scene's view that entry i of `views` names; -1 after an error. */
static int find_view(struct pen_request *request, const json_t *list, size_t i,
                     struct pen_errors *errors)
{
    const char *name = json_string_value(json_array_get(list, i));
    for (uint32_t v = 0; name && v < request->desc.view_count; v++) {
        if (strcmp(request->desc.views[v].name, name) == 0)
            return (int)v;
    }
    const char *names[65] = {NULL};
    for (uint32_t v = 0; v < request->desc.view_count && v < 64; v++)
        names[v] = request->desc.views[v].name;
    pen_request_fail(errors, PEN_INVALID, "/views", pen_position(i).text,
                     "must be the name of a view of the scene, such as \"%s\", found %s%s",
                     names[0], pen_found(json_array_get(list, i)).text,
                     pen_did_you_mean(name ? pen_nearest_name(name, names) : NULL).text);
    return -1;
}

static void read_views(struct pen_request *request, const json_t *list, struct pen_errors *errors)
{
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count < 1 || count > request->desc.view_count) {
        pen_request_fail(errors, PEN_INVALID, "", "views",
                         "must be an array of names of views, at least 1 and not more than the "
                         "scene has, %u; found %s",
                         request->desc.view_count, pen_found(list).text);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        int view = find_view(request, list, i, errors);
        for (int k = 0; view >= 0 && k < request->view_count; k++) {
            if (request->views[k] == view)
                pen_request_fail(errors, PEN_INVALID, "", "views", "names \"%s\" twice",
                                 request->desc.views[view].name);
        }
        if (view >= 0)
            request->views[request->view_count++] = view;
    }
}

/* Fills request->views with the views that the job names, else with all views of the scene. A job
 * about a single view gets the first. */
static bool choose_views(struct pen_request *request, struct pen_errors *errors)
{
    uint32_t count = request->desc.view_count;
    const json_t *list = request->bare ? NULL : json_object_get(request->body, "views");
    request->views = pen_arena_alloc(request->arena, count, sizeof *request->views);
    if (!request->views) {
        pen_request_fail(errors, PEN_NO_MEMORY, "", NULL, "no memory for %u views", count);
        return false;
    }
    if (list) {
        read_views(request, list, errors);
        if (request->budget_seconds > 0 && request->view_count > 1)
            pen_request_fail(errors, PEN_INVALID, "", "views",
                             "must name one view for a job with budget_seconds, found %d",
                             request->view_count);
        else if (pen_job_kind_has_one_view(request->kind) && request->view_count > 1)
            pen_request_fail(errors, PEN_INVALID, "", "views",
                             "must name one view for a job of kind \"%s\", found %d",
                             pen_job_kinds[request->kind], request->view_count);
        return true;
    }
    if (pen_job_kind_has_one_view(request->kind) || request->budget_seconds > 0)
        count = 1;
    for (uint32_t v = 0; v < count; v++)
        request->views[request->view_count++] = (int)v;
    return true;
}

/* Writes the JSON Pointer to the settings that an error about limits concerns: the job's `render`
 * if it has one, else the scene's. */
static void limits_place(const struct pen_request *request, char *at, size_t bytes)
{
    if (!request->bare && json_object_get(request->body, "render"))
        snprintf(at, bytes, "/render");
    else
        snprintf(at, bytes, "%s%s", request->scene_at,
                 json_object_get(request->scene, "render") ? "/render" : "");
}

double pen_request_layer_work(const struct pen_request *request)
{
    return request->cost_layer ? pen_layer_work(PEN_LAYER_COST, request->cost) : 0;
}

/* Returns the time of a view's audit, as a multiple of the time of its pixels. With a target error
 * it is approximate: exact if a pixel then has at least 16 samples, else the audit takes longer. */
static double audit_work(const struct pen_request *request)
{
    const struct pen_settings *s = &request->settings, sampling = pen_settings_sampling(s);
    const double pixels = (double)s->width * s->height,
                 audited = request->audit_pixels < pixels ? request->audit_pixels : pixels,
                 own = pen_settings_adaptive(s)
                           ? (double)PEN_AUDIT_LEAST / PEN_AUDIT_TIMES
                           : pen_camera_samples(pen_desc_has_lens(&request->desc), &sampling),
                 again = PEN_AUDIT_TIMES * own > PEN_AUDIT_LEAST ? PEN_AUDIT_TIMES * own
                                                                 : PEN_AUDIT_LEAST;
    return audited / pixels * again / own;
}

/* Checks the expected time of a render's pixels with its layers and audits. */
static bool check_extras_time(const struct pen_request *request, const struct pen_limits *limits,
                              const char *at, struct pen_status *st)
{
    const struct pen_settings *s = &request->settings, sampling = pen_settings_sampling(s);
    const double work = pen_request_layer_work(request) + audit_work(request),
                 rays = (double)request->view_count * s->width * s->height *
                        pen_work_per_pixel(&request->desc, &sampling);
    return work == 0 || pen_limits_check_time(limits, rays * (1 + work), at, st);
}

static bool is_within_limits(const struct pen_request *request, const struct pen_limits *limits,
                             struct pen_status *st)
{
    char at[16];
    const struct pen_scene_desc *desc = &request->desc;
    limits_place(request, at, sizeof at);
    if (request->kind == PEN_KIND_BENCHMARK)
        return pen_bench_spec_check(&request->spec, limits, desc, request->view_count, st);
    if (request->kind == PEN_KIND_ACCURACY) {
        struct pen_accuracy_task task = pen_accuracy_of_spec(&request->accuracy);
        task.frame.desc = desc;
        task.settings = &request->settings;
        task.limits = *limits;
        return pen_accuracy_check(&task, at, st);
    }
    if (request->kind == PEN_KIND_EFFECTS)
        return pen_bill_check(limits, desc, request->views[0], &request->settings, request->repeats,
                              at, st);
    return pen_limits_check(limits, desc, &request->settings, (uint32_t)request->view_count, at,
                            st) &&
           check_extras_time(request, limits, at, st);
}

/* Returns the budget of a request, in seconds; NULL if it has none. */
static double *budget_of(struct pen_request *request)
{
    return request->kind == PEN_KIND_RENDER      ? &request->budget_seconds
           : request->kind == PEN_KIND_BENCHMARK ? &request->spec.budget_s
           : request->kind == PEN_KIND_ACCURACY  ? &request->accuracy.budget_s
                                                 : NULL;
}

/* Bounds the budget: with the layers and the audit that follow it, it must not exceed the time that
 * the operator allows a job. A default budget is reduced to this time. */
static void bound_budget(struct pen_request *request, const struct pen_limits *limits,
                         struct pen_errors *errors)
{
    double *budget = budget_of(request);
    const json_t *value = request->bare ? NULL : json_object_get(request->body, "budget_seconds");
    const double extra = request->kind == PEN_KIND_RENDER
                             ? pen_request_layer_work(request) + audit_work(request)
                             : 0,
                 most = limits->seconds / (1 + extra);
    if (!budget || limits->seconds <= 0 || *budget <= most)
        return;
    if (value)
        pen_request_fail(errors, PEN_INVALID, "", "budget_seconds",
                         "must be a number above 0, at most %g, which this daemon allows "
                         "%s(--max-seconds), found %s",
                         most, extra > 0 ? "beside the layer cost and the audit " : "",
                         pen_found(value).text);
    else
        *budget = most;
}

static void check_limits(struct pen_request *request, const struct pen_limits *limits,
                         struct pen_errors *errors)
{
    struct pen_status st;
    struct pen_limits allowed = *limits;
    if (request->explain && !request->analyze)
        allowed.seconds = 0; /* it is not rendered, so a client may ask how long it would take */
    if (is_within_limits(request, &allowed, &st))
        return;
    pen_document_locate(request->has, &st);
    pen_errors_add(errors, &st);
}

static void read_scene(struct pen_request *request, const struct pen_limits *limits,
                       struct pen_errors *errors)
{
    const json_t *render = request->bare ? NULL : json_object_get(request->body, "render");
    bool ok = request->has->xml
                  ? pen_document_read(request->has, limits, request->arena, &request->desc, errors)
                  : pen_scene_read(request->scene, request->scene_at, limits, request->arena,
                                   &request->desc, errors);
    request->settings = ok ? request->desc.settings : pen_settings_default();
    if (render)
        pen_settings_read(render, "/render", &request->settings, errors);
    if (request->budget_seconds > 0 && !pen_settings_adaptive(&request->settings))
        request->settings.target_error = PEN_TARGET_NONE;
    if (request->kind == PEN_KIND_BENCHMARK)
        pen_bench_spec_read(request->body, &request->settings, &request->spec, errors);
    if (request->kind == PEN_KIND_ACCURACY)
        pen_accuracy_spec_read(request->body, ok ? &request->desc : NULL, &request->settings,
                               &request->accuracy, errors);
    if (request->kind == PEN_KIND_EFFECTS)
        pen_repeats_read(request->body, &request->repeats, errors);
    bound_budget(request, limits, errors);
    if (ok && choose_views(request, errors) && errors->count == 0)
        check_limits(request, limits, errors);
}

bool pen_request_read(const struct pen_submission *in, const struct pen_limits *limits,
                      struct pen_request *out, struct pen_errors *errors)
{
    struct pen_status st;
    int timeout_s = limits->timeout_seconds;
    *out = (struct pen_request){.explain = in->explain,
                                .kind = in->explain ? PEN_KIND_EXPLAIN : PEN_KIND_RENDER,
                                .max_attempts = 3,
                                .timeout_max_s = timeout_s,
                                .priority_max = limits->priority};
    out->timeout_ms = (int64_t)1000 * (timeout_s < TIMEOUT_S ? timeout_s : TIMEOUT_S);
    bool parsed = pen_document_parse(in->body, in->bytes, in->xml, limits, &out->document, &st);
    out->body = parsed ? out->document.json : NULL;
    out->has = &out->document;
    out->arena = out->body ? pen_arena_new(0) : NULL;
    if (out->body && !out->arena)
        pen_fail(&st, PEN_NO_MEMORY, "no memory to read a scene");
    if (!out->arena) {
        pen_errors_add(errors, &st);
        return false;
    }
    find_scene(out, in, limits, errors);
    if (!out->bare && json_object_get(out->body, "scene"))
        pen_request_keys_read(out, errors);
    if (out->explain && !json_object_get(out->body, "priority"))
        out->priority = out->analyze ? 0 : EXPLAIN_PRIORITY;
    if (out->priority > limits->priority)
        out->priority = limits->priority; /* of an explanation, or of a job without the key */
    if (out->scene)
        read_scene(out, limits, errors);
    return errors->count == 0;
}

void pen_request_release(struct pen_request *request)
{
    pen_arena_free(request->arena);
    pen_document_release(&request->document);
    pen_bench_spec_release(&request->spec);
    pen_accuracy_spec_release(&request->accuracy);
    pen_document_release(&request->own);
    *request = (struct pen_request){0};
}
