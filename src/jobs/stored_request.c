/* SPDX-License-Identifier: MIT */
/* Reading what submit.c has stored. A text that cannot be read was damaged in the store, so every
 * error here is PEN_STORAGE. */
#include "jobs/internal/stored_request.h"

#include <string.h>

#include "io/scene_json.h"
#include "render/audit.h"

json_t *pen_stored_json(const char *text, struct pen_status *st)
{
    json_error_t error;
    json_t *json = text ? json_loads(text, 0, &error) : json_null();
    if (!json)
        pen_fail(st, PEN_STORAGE, "a stored job is damaged: %s", error.text);
    return json;
}

/* Whether the numbers are of those that a submit allows. */
static bool has_valid_numbers(const struct pen_stored_request *request)
{
    uint64_t pixels;
    double threshold;
    const double budget = pen_stored_request_budget(request);
    const int repeats = pen_stored_request_repeats(request);
    if (pen_stored_request_audit(request, &pixels, &threshold) &&
        !(pixels >= 1 && pixels <= PEN_AUDIT_PIXELS_MAX && threshold > 0 && threshold < 1))
        return false;
    return budget >= 0 && repeats >= 0;
}

/* The tiles of the job's batches: those of the settings in jobs of earlier versions, and in studies
 * that measure. */
static bool read_tile(struct pen_stored_request *request)
{
    const json_t *edge = json_object_get(request->json, "tile_edge");
    const json_int_t tile = json_integer_value(edge);
    if (!edge)
        return true;
    request->settings.tile = tile >= 1 && tile <= request->settings.tile ? (int)tile : 0;
    return request->settings.tile > 0;
}

bool pen_stored_request_read(const char *text, struct pen_stored_request *request,
                             struct pen_status *st)
{
    struct pen_errors errors = {0};
    *request = (struct pen_stored_request){.settings = pen_settings_default()};
    request->json = pen_stored_json(text, st);
    if (!request->json)
        return false;
    const char *kind = json_string_value(json_object_get(request->json, "kind"));
    const bool known = pen_job_kind_of_name(kind, &request->kind);
    request->view_count = (int)json_array_size(json_object_get(request->json, "views"));
    json_t *render = json_object_get(request->json, "render");
    if (known && request->view_count > 0 && render && has_valid_numbers(request) &&
        pen_settings_read(render, "/render", &request->settings, &errors) && read_tile(request))
        return true;
    pen_stored_request_release(request);
    return pen_fail(st, PEN_STORAGE, "a stored job is damaged: %s",
                    errors.count ? errors.item[0].msg
                                 : "no kind, views or settings, or a wrong number");
}

void pen_stored_request_release(struct pen_stored_request *request)
{
    json_decref(request->json);
    request->json = NULL;
}

const char *pen_stored_request_view(const struct pen_stored_request *request, int view)
{
    return json_string_value(json_array_get(json_object_get(request->json, "views"), (size_t)view));
}

bool pen_stored_request_layer(const struct pen_stored_request *request, enum pen_layer layer)
{
    const json_t *list = json_object_get(request->json, "layers");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *name = json_string_value(json_array_get(list, i));
        if (name && strcmp(name, pen_layer_name(layer)) == 0)
            return true;
    }
    return layer == PEN_LAYER_BEAUTY;
}

/* Jobs of earlier versions have none. */
enum pen_cost pen_stored_request_cost(const struct pen_stored_request *request)
{
    const char *cost = json_string_value(json_object_get(request->json, "cost"));
    const bool tests = cost && strcmp(cost, pen_cost_names[PEN_COST_TESTS]) == 0;
    return tests ? PEN_COST_TESTS : PEN_COST_TIME;
}

bool pen_stored_request_audit(const struct pen_stored_request *request, uint64_t *pixels,
                              double *threshold)
{
    const json_t *audit = json_object_get(request->json, "audit");
    *pixels = (uint64_t)json_integer_value(json_object_get(audit, "pixels"));
    *threshold = json_number_value(json_object_get(audit, "threshold"));
    return audit != NULL;
}

double pen_stored_request_budget(const struct pen_stored_request *request)
{
    return json_number_value(json_object_get(request->json, "budget_seconds"));
}

double pen_stored_request_bound_rays(const struct pen_stored_request *request)
{
    return json_number_value(json_object_get(request->json, "bound_rays"));
}

int pen_stored_request_repeats(const struct pen_stored_request *request)
{
    return (int)json_integer_value(json_object_get(request->json, "repeats"));
}

bool pen_stored_request_analyze(const struct pen_stored_request *request)
{
    return json_is_true(json_object_get(request->json, "analyze"));
}

int pen_stored_request_find_view(const struct pen_stored_request *request, const char *name)
{
    for (int view = 0; view < request->view_count; view++) {
        const char *here = pen_stored_request_view(request, view);
        if (here && strcmp(here, name) == 0)
            return view;
    }
    return -1;
}
