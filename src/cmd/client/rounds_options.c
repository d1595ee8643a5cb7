/* SPDX-License-Identifier: MIT */
#include "cmd/client/rounds_options.h"

#include <inttypes.h>
#include <stdlib.h>

#include "cmd/report.h"
#include "io/stats_json.h"

static bool read_repeat(struct pen_rounds_wanted *rounds, struct pen_scene_input *input,
                        const char *path, struct pen_status *st)
{
    struct pen_source source;
    struct pen_status cause;
    const struct pen_limits limits = pen_limits_default();
    json_t *stats = NULL;
    rounds->repeat = calloc(1, sizeof *rounds->repeat);
    if (!rounds->repeat)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the rounds to be repeated");
    const bool ok = pen_source_read(&source, path, 0, &cause) &&
                    (stats = pen_json_parse((const char *)source.text.data, source.text.bytes,
                                            &limits, &cause)) &&
                    pen_stats_rounds_read(stats, rounds->scene_sha256, &input->desc.settings,
                                          rounds->repeat, &cause);
    pen_source_release(&source);
    json_decref(stats);
    return ok || pen_fail(st, cause.code, "--repeat %.200s: %.300s", path, cause.msg);
}

bool pen_rounds_begin(struct pen_rounds_wanted *rounds, struct pen_scene_input *input,
                      double budget, const char *repeat, int64_t start_ns, struct pen_status *st)
{
    struct pen_settings *s = &input->desc.settings;
    /* Encoding and writing are a part of the budget. They take some 0.3 microseconds a pixel. */
    const double after_ns = 300.0 * s->width * s->height;
    pen_hash_text(input->source.text.data, input->source.text.bytes, rounds->scene_sha256);
    if (repeat)
        return read_repeat(rounds, input, repeat, st);
    if (budget < 0)
        return true;
    rounds->deadline_ns = start_ns + (int64_t)(budget * 1e9 - after_ns);
    if (!pen_settings_adaptive(s))
        s->target_error = PEN_TARGET_NONE;
    return true;
}

void pen_rounds_tell(const struct pen_adaptive_stats *adaptive, const char *label, const char *view,
                     bool quiet)
{
    const struct pen_round *last = &adaptive->round[adaptive->rounds - 1];
    char text[PEN_MSG_BYTES];
    if (pen_unproven_warning(adaptive, text, sizeof text))
        pen_report_say(stderr, "penumbra: %s: view \"%s\": warning: %s", label, view, text);
    if (!adaptive->met && !adaptive->timed)
        pen_report_say(
            stderr,
            "penumbra: %s: view \"%s\": warning: the estimated error is %.4g (%.4g to %.4g), "
            "above the target of %.4g: max_samples keeps %" PRIu64
            " pixels from having more samples",
            label, view, last->error, last->low, last->high, adaptive->target, adaptive->capped);
    else if (!quiet)
        pen_report_say(
            stderr, "penumbra: %s: estimated error %.4g (%.4g to %.4g) with %.3g samples per pixel",
            label, last->error, last->low, last->high, adaptive->samples.mean);
}
