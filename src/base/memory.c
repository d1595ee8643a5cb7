/* SPDX-License-Identifier: MIT */
/* Asks for huge pages. Reads and resets the kernel's peak of the resident set through /proc. */
#include "base/memory.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

enum { LARGE_BYTES = 1 << 20, HUGE_PAGE = 1 << 21 }; /* of x86-64 and most others */

void *pen_memory_large(size_t bytes)
{
    if (bytes < LARGE_BYTES || bytes > SIZE_MAX / 2)
        return malloc(bytes > 0 ? bytes : 1);
    const size_t whole = (bytes + HUGE_PAGE - 1) & ~(size_t)(HUGE_PAGE - 1);
    void *memory = aligned_alloc(HUGE_PAGE, whole);
    if (memory)
        (void)madvise(memory, whole, MADV_HUGEPAGE); /* without huge pages it is only slower */
    return memory;
}

void *pen_memory_large_zeroed(size_t bytes)
{
    void *memory = pen_memory_large(bytes);
    return memory ? memset(memory, 0, bytes) : NULL;
}

void pen_memory_peak_reset(void)
{
    int fd = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return;
    /* "5" resets the peak of the resident set, see proc(5). If the write fails, the peak remains
     * the one since the process began. */
    ssize_t written = write(fd, "5", 1);
    (void)written;
    close(fd);
}

int64_t pen_memory_peak_bytes(void)
{
    char text[4096];
    int fd = open("/proc/self/status", O_RDONLY | O_CLOEXEC);
    ssize_t n = fd >= 0 ? read(fd, text, sizeof text - 1) : 0;
    if (fd >= 0)
        close(fd);
    text[n > 0 ? n : 0] = '\0';
    const char *peak = strstr(text, "VmHWM:");
    if (peak)
        return strtoll(peak + strlen("VmHWM:"), NULL, 10) * 1024;
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (int64_t)usage.ru_maxrss * 1024 : 0;
}
