/* SPDX-License-Identifier: MIT */
/* Reads what submit.c has stored. A text that cannot be read was damaged in the store, so every
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

/* Reads the members beside kind, views and settings. Returns true if a submit allows their
 * numbers. */
static bool read_members(struct pen_stored_request *request)
{
    const json_t *json = request->json, *audit = json_object_get(json, "audit"),
                 *layers = json_object_get(json, "layers"),
                 *tile = json_object_get(json, "tile_edge");
    const char *cost = json_string_value(json_object_get(json, "cost"));
    const json_int_t pixels = json_integer_value(json_object_get(audit, "pixels")),
                     edge = tile ? json_integer_value(tile) : request->settings.tile;
    const double threshold = json_number_value(json_object_get(audit, "threshold"));
    request->layers = 1U << PEN_LAYER_BEAUTY;
    for (size_t i = 0; i < json_array_size(layers); i++) {
        const char *name = json_string_value(json_array_get(layers, i));
        request->layers |= name ? 1U << pen_layer_find(name) : 0;
    }
    const bool tests = cost && strcmp(cost, pen_cost_names[PEN_COST_TESTS]) == 0;
    request->cost = tests ? PEN_COST_TESTS : PEN_COST_TIME;
    request->audit = audit != NULL;
    request->audit_pixels = (uint64_t)pixels;
    request->audit_threshold = threshold;
    request->budget_s = json_number_value(json_object_get(json, "budget_seconds"));
    request->bound_rays = json_number_value(json_object_get(json, "bound_rays"));
    request->repeats = (int)json_integer_value(json_object_get(json, "repeats"));
    request->analyze = json_is_true(json_object_get(json, "analyze"));
    if (edge < 1 || edge > request->settings.tile)
        return false;
    request->settings.tile = (int)edge; /* of the job's batches */
    return request->budget_s >= 0 && request->repeats >= 0 &&
           (!audit ||
            (pixels >= 1 && pixels <= PEN_AUDIT_PIXELS_MAX && threshold > 0 && threshold < 1));
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
    if (known && request->view_count > 0 && render &&
        pen_settings_read(render, "/render", &request->settings, &errors) && read_members(request))
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

int pen_stored_request_find_view(const struct pen_stored_request *request, const char *name)
{
    for (int view = 0; view < request->view_count; view++) {
        const char *here = pen_stored_request_view(request, view);
        if (here && strcmp(here, name) == 0)
            return view;
    }
    return -1;
}
