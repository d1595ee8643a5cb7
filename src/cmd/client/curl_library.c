/* SPDX-License-Identifier: MIT */
#include "cmd/client/curl_library.h"

#include <dlfcn.h>
#include <string.h>

/* The name contains the version of the binary interface, which has been 4 since 2006. */
static const char library[] = "libcurl.so.4";

/* Finds a function. ISO C has no cast from the object pointer that dlsym returns to a function
 * pointer, so its bytes are copied to `function`. */
static bool find(void *handle, const char *name, void *function, struct pen_status *st)
{
    void *found = dlsym(handle, name);
    memcpy(function, &found, sizeof found);
    return found || pen_fail(st, PEN_NETWORK, "%s has no function %s", library, name);
}

bool pen_curl_load(struct pen_curl *curl, struct pen_status *st)
{
    void *handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    if (!handle)
        return pen_fail(st, PEN_NETWORK, "talking to a daemon needs libcurl: %s", dlerror());
    bool ok = true;
#define FIND(name) ok = ok && find(handle, "curl_" #name, &curl->name, st);
    PEN_CURL_FUNCTIONS(FIND)
#undef FIND
    return ok;
}
