/* SPDX-License-Identifier: MIT */
/* The audit of a view: by the worker that ends the view, before its commit. The result is a part of
 * the batch's statistics. */
#include "jobs/internal/batch.h"

#include "study/hash.h"

bool pen_batch_audit(struct pen_batch_context *context, const struct pen_claim *claim,
                     const struct pen_film *film, struct pen_audit *audit, bool *done,
                     struct pen_status *st)
{
    struct pen_scene_times times;
    const struct pen_settings *s = &context->request.settings;
    const char *view = pen_stored_request_view(&context->request, claim->view);
    struct pen_audit_task task = {.settings = s,
                                  .rgb = film->rgb,
                                  .adaptive = context->adaptive,
                                  .cancel = pen_heartbeat_cancel_flag(context->heart)};
    *done = pen_stored_request_audit(&context->request, &task.pixels, &task.threshold);
    if (!*done)
        return true;
    task.scene = pen_scene_cache_get(context->scenes, context->store, claim,
                                     (enum pen_accelerator)s->accelerator, &times, st);
    if (!task.scene)
        return false;
    task.view = view ? pen_scene_find_view(task.scene, view) : -1;
    task.seed = pen_audit_seed(film);
    return task.view >= 0 ? pen_audit_run(context->pool, &task, audit, st)
                          : pen_fail(st, PEN_INTERNAL, "the scene has no view %d", claim->view);
}
