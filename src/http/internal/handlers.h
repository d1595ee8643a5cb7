/* SPDX-License-Identifier: MIT */
/* The handlers of the routes, one line or two for each handle_*.c. */
#ifndef PEN_HTTP_INTERNAL_HANDLERS_H
#define PEN_HTTP_INTERNAL_HANDLERS_H

#include "http/internal/routes.h"

route_handler pen_http_handle_submit, pen_http_handle_list, pen_http_handle_job,
    pen_http_handle_cancel, pen_http_handle_delete, pen_http_handle_explain;
route_handler pen_http_handle_image, pen_http_handle_preview, pen_http_handle_stats,
    pen_http_handle_scene, pen_http_handle_report;
route_handler pen_http_handle_events;
route_handler pen_http_handle_validate, pen_http_handle_file, pen_http_handle_workers;
route_handler pen_http_handle_healthz, pen_http_handle_readyz, pen_http_handle_metrics;
route_quick pen_http_quick_job, pen_http_quick_refusal;

#endif
