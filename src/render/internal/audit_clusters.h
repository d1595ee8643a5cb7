/* SPDX-License-Identifier: MIT */
/* Where the wrong pixels of an audit are. The picture is cut into cells, which note how many of
 * their audited pixels are wrong, and the bounds of these. Cells that have some and touch each
 * other, also at a corner, are a cluster. So clusters do not depend on the order of the pixels. */
#ifndef PEN_RENDER_INTERNAL_AUDIT_CLUSTERS_H
#define PEN_RENDER_INTERNAL_AUDIT_CLUSTERS_H

#include "render/audit.h"

/* Notes that pixel `at` of a picture of that size is wrong. */
void pen_audit_note_wrong(struct pen_audit_cell cells[PEN_AUDIT_CELLS],
                          const struct pen_settings *settings, size_t at);

/* Sets the clusters of an audit, with `pixels` of the `drawn` ones, which are audited. */
void pen_audit_find_clusters(const struct pen_audit_cell cells[PEN_AUDIT_CELLS],
                             const struct pen_settings *settings, const size_t *drawn,
                             struct pen_audit *audit);

#endif
