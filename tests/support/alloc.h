/* SPDX-License-Identifier: MIT */
/* Allocations that fail on request. One file of a test program includes this header, which defines
 * the program's malloc, calloc, realloc and aligned_alloc; they call the system's functions. A test
 * lets the n-th allocation fail for every n until its work succeeds:
 *
 *     for (long n = 0; ; n++) {
 *         alloc_fail_after(n);
 *         bool ok = work();
 *         if (!alloc_succeed()) break;      // nothing was refused: ok must be true
 *         // ok must be false, and nothing leaked
 *     }
 */
#ifndef TESTS_SUPPORT_ALLOC_H
#define TESTS_SUPPORT_ALLOC_H

#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static struct {
    bool armed, refused, one_thread;
    long left;
    pthread_t thread; /* the only one, if one_thread */
} alloc_state;

/* For work that starts threads. A sanitizer's runtime allocates in each thread, and ends the
 * process if it cannot. So in such a build only the calling thread's allocations fail. */
static inline void alloc_spare_new_threads(void)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    alloc_state.one_thread = true;
    alloc_state.thread = pthread_self();
#endif
}

/* The largest allocation since the last call. */
static size_t alloc_largest_bytes;

static inline size_t alloc_take_largest(void)
{
    const size_t largest = alloc_largest_bytes;
    alloc_largest_bytes = 0;
    return largest;
}

/* Lets n allocations succeed, then all fail until alloc_succeed. */
static inline void alloc_fail_after(long n)
{
    alloc_state.left = n;
    alloc_state.refused = false;
    alloc_state.armed = true;
}

/* Makes allocations succeed again. Returns true if one was refused since alloc_fail_after. */
static inline bool alloc_succeed(void)
{
    alloc_state.armed = false;
    return alloc_state.refused;
}

/* The start-up of the sanitizers calls these functions too, before their instrumentation works. */
#define ALLOC_UNWATCHED __attribute__((no_sanitize("thread"), no_sanitize("address")))

ALLOC_UNWATCHED static bool alloc_refuse(size_t bytes)
{
    if (bytes > alloc_largest_bytes)
        alloc_largest_bytes = bytes;
    if (!alloc_state.armed ||
        (alloc_state.one_thread && !pthread_equal(pthread_self(), alloc_state.thread)) ||
        alloc_state.left-- > 0)
        return false;
    return alloc_state.refused = true;
}

/* Finds the system's function of this name. ISO C has no cast from the object pointer that dlsym
 * returns to a function pointer. */
#define ALLOC_SYSTEM(type, name)                                                                   \
    static type system_##name;                                                                     \
    if (!system_##name) {                                                                          \
        void *found = dlsym(RTLD_NEXT, #name);                                                     \
        memcpy(&system_##name, &found, sizeof found);                                              \
    }

typedef void *(*alloc_one)(size_t);
typedef void *(*alloc_two)(size_t, size_t);
typedef void *(*alloc_again)(void *, size_t);

ALLOC_UNWATCHED void *malloc(size_t bytes)
{
    ALLOC_SYSTEM(alloc_one, malloc)
    return alloc_refuse(bytes) ? NULL : system_malloc(bytes);
}

ALLOC_UNWATCHED void *calloc(size_t count, size_t size)
{
    ALLOC_SYSTEM(alloc_two, calloc)
    return alloc_refuse(count * size) ? NULL : system_calloc(count, size);
}

ALLOC_UNWATCHED void *realloc(void *old, size_t bytes)
{
    ALLOC_SYSTEM(alloc_again, realloc)
    return alloc_refuse(bytes) ? NULL : system_realloc(old, bytes);
}

ALLOC_UNWATCHED void *aligned_alloc(size_t alignment, size_t bytes)
{
    ALLOC_SYSTEM(alloc_two, aligned_alloc)
    return alloc_refuse(bytes) ? NULL : system_aligned_alloc(alignment, bytes);
}

#endif
