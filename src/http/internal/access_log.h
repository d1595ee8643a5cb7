/* SPDX-License-Identifier: MIT */
/* What the log says of a request that has ended: a line at level info if it has changed the store,
 * at level warn if it failed (5xx other than 503), else at level debug: clients decide how many
 * requests are read or refused, and they must not fill the log. Refused and failed requests are
 * counted for /metrics.
 * Threads: any. */
#ifndef PEN_HTTP_INTERNAL_ACCESS_LOG_H
#define PEN_HTTP_INTERNAL_ACCESS_LOG_H

#include <stdbool.h>
#include <stdint.h>

struct request;

/* `streamed`: bytes of its event stream; complete: the whole answer was sent. */
void pen_http_access_log_add(const struct request *request, uint64_t streamed, bool complete);

#endif
