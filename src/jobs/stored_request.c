/* SPDX-License-Identifier: MIT */
/* Reading what submit.c has stored. A text that cannot be read was damaged in the store, so every
 * error here is PEN_STORAGE. */
#include "jobs/internal/stored_request.h"

#include <string.h>

#include "io/scene_json.h"

json_t *pen_stored_json(const char *text, struct pen_status *st)
{
    json_error_t error;
    json_t *json = text ? json_loads(text, 0, &error) : json_null();
    if (!json)
        pen_fail(st, PEN_STORAGE, "a stored job is damaged: %s", error.text);
    return json;
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
    request->benchmark = kind && strcmp(kind, "benchmark") == 0;
    request->view_count = (int)json_array_size(json_object_get(request->json, "views"));
    json_t *render = json_object_get(request->json, "render");
    if (request->view_count > 0 && render &&
        pen_settings_read(render, "/render", &request->settings, &errors))
        return true;
    pen_stored_request_release(request);
    return pen_fail(st, PEN_STORAGE, "a stored job is damaged: %s",
                    errors.count ? errors.item[0].msg : "no views or settings");
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
