/* SPDX-License-Identifier: MIT */
#include "cmd/client/audit_options.h"

#include <inttypes.h>

#include "cmd/report.h"

void pen_audit_print(const struct pen_audit *audit, const char *label, FILE *out)
{
    pen_report_say(
        out,
        "penumbra: %s: with 95 %% confidence at most %.3g %% of the pixels are off by more than "
        "%g (%" PRIu64 " audited, %" PRIu64 " wrong, %" PRIu64 " undecided)",
        label, 100 * audit->bound, audit->threshold, audit->pixels, audit->wrong, audit->undecided);
    for (int i = 0; i < audit->clusters; i++) {
        const struct pen_audit_cluster *c = &audit->cluster[i];
        pen_report_say(out,
                       "penumbra: %s: %" PRIu64 " of %" PRIu64
                       " audited pixels are wrong in columns %d to %d, rows %d to %d",
                       label, c->wrong, c->pixels, c->rect.x, c->rect.x + c->rect.width - 1,
                       c->rect.y, c->rect.y + c->rect.height - 1);
    }
}
