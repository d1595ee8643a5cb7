/* SPDX-License-Identifier: MIT */
/* One lock for all requests; it is held to change two flags and to call libmicrohttpd once. */
#include "http/internal/suspend.h"

#include <microhttpd.h>

#include "http/internal/http.h"
#include "http/internal/request.h"

bool pen_http_suspend(struct request *request)
{
    pthread_mutex_t *lock = &request->http->suspend_lock;
    pthread_mutex_lock(lock);
    bool suspend = !request->resume_pending;
    request->resume_pending = false;
    if (suspend) {
        request->suspended = true;
        MHD_suspend_connection(request->connection);
    }
    pthread_mutex_unlock(lock);
    return suspend;
}

void pen_http_resume(struct request *request)
{
    pthread_mutex_t *lock = &request->http->suspend_lock;
    pthread_mutex_lock(lock);
    if (request->suspended) {
        request->suspended = false;
        MHD_resume_connection(request->connection);
    } else {
        request->resume_pending = true;
    }
    pthread_mutex_unlock(lock);
}
