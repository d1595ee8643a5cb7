/* SPDX-License-Identifier: MIT */
/* What the routes do, one function each. */
#ifndef HTTP_HANDLERS_H
#define HTTP_HANDLERS_H

#include "routes.h"

route_handler handle_submit, handle_list, handle_job, handle_cancel, handle_delete;
route_handler handle_image, handle_preview, handle_stats, handle_scene;
route_handler handle_validate, handle_scenes, handle_builtin, handle_api_file;
route_handler handle_healthz, handle_readyz;
route_quick quick_job;

#endif
