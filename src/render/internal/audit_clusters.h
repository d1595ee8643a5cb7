/* SPDX-License-Identifier: MIT */
/* The places of an audit's wrong pixels. The picture is divided into cells. A cell stores how many
 * of its audited pixels are wrong, and their bounds. Cells with wrong pixels that touch each other,
 * also at a corner, are a cluster. So clusters do not depend on the order of the pixels. */
#ifndef PEN_RENDER_INTERNAL_AUDIT_CLUSTERS_H
#define PEN_RENDER_INTERNAL_AUDIT_CLUSTERS_H

#include "render/audit.h"

/* Records that pixel `at` is wrong, in a picture of the size in the settings. */
void pen_audit_note_wrong(struct pen_audit_cell cells[PEN_AUDIT_CELLS],
                          const struct pen_settings *settings, size_t at);

/* Sets the clusters of an audit. `pixels` of the pixels `drawn` are audited. */
void pen_audit_find_clusters(const struct pen_audit_cell cells[PEN_AUDIT_CELLS],
                             const struct pen_settings *settings, const size_t *drawn,
                             struct pen_audit *audit);

#endif
