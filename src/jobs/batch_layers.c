/* SPDX-License-Identifier: MIT */
/* The layers of a view beside its picture: rendered by the worker that ends the view, before its
 * commit, and stored as PFM. A worker that renders them again, because the commit failed, replaces
 * them. */
#include "jobs/internal/batch.h"

#include "render/layers.h"

static bool store_layer(struct pen_batch_context *context, const struct pen_claim *claim,
                        const struct pen_layer_task *task, const struct pen_film *film,
                        struct pen_status *st)
{
    struct pen_buf file = {0};
    const bool ok = pen_layer_render(context->pool, task, st) && pen_pfm_write(film, &file, st) &&
                    pen_batch_store(context, claim, pen_layer_name(task->layer), "pfm", &file, st);
    pen_buf_release(&file);
    return ok;
}

static bool render_layer(struct pen_batch_context *context, const struct pen_claim *claim,
                         const struct pen_scene *scene, enum pen_layer layer, struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    const char *view = pen_stored_request_view(&context->request, claim->view);
    struct pen_film *film = pen_film_new(s->width, s->height, st);
    if (!film)
        return false;
    const struct pen_layer_task task = {.scene = scene,
                                        .view = view ? pen_scene_find_view(scene, view) : -1,
                                        .settings = s,
                                        .layer = layer,
                                        .cost = pen_stored_request_cost(&context->request),
                                        .rgb = film->rgb,
                                        .cancel = pen_heartbeat_cancel_flag(context->heart),
                                        .adaptive = context->adaptive};
    const bool ok = task.view >= 0
                        ? store_layer(context, claim, &task, film, st)
                        : pen_fail(st, PEN_INTERNAL, "the scene has no view %d", claim->view);
    pen_film_free(film);
    return ok;
}

static bool has_layers(const struct pen_batch_context *context)
{
    for (int layer = PEN_LAYER_BEAUTY + 1; layer < PEN_LAYER_COUNT; layer++)
        if (pen_stored_request_layer(&context->request, (enum pen_layer)layer))
            return true;
    return false;
}

bool pen_batch_layers(struct pen_batch_context *context, const struct pen_claim *claim,
                      struct pen_status *st)
{
    struct pen_scene_times times;
    const struct pen_settings *s = &context->request.settings;
    if (!has_layers(context))
        return true;
    const struct pen_scene *scene = pen_scene_cache_get(
        context->scenes, context->store, claim, (enum pen_accelerator)s->accelerator, &times, st);
    bool ok = scene != NULL;
    for (int layer = PEN_LAYER_BEAUTY + 1; ok && layer < PEN_LAYER_COUNT; layer++)
        if (pen_stored_request_layer(&context->request, (enum pen_layer)layer))
            ok = render_layer(context, claim, scene, (enum pen_layer)layer, st);
    return ok;
}
