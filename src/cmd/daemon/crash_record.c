/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/crash_record.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

/* The record that on_crash writes. Set once, before the handler is installed. */
static struct pen_trace *crash_trace;

int pen_crash_record_new(void)
{
    int fd = memfd_create("penumbra-trace", MFD_CLOEXEC);
    if (fd >= 0 && ftruncate(fd, (off_t)sizeof(struct pen_trace)) != 0) {
        close(fd);
        fd = -1;
    }
    return fd;
}

struct pen_trace *pen_crash_record_map(int fd)
{
    if (fd < 0)
        return NULL;
    void *trace = mmap(NULL, sizeof(struct pen_trace), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    return trace == MAP_FAILED ? NULL : trace;
}

void pen_crash_record_unmap(struct pen_trace *trace)
{
    if (trace)
        munmap(trace, sizeof *trace);
}

/* SA_RESETHAND: the raised signal has its default effect, as without a handler. */
static void on_crash(int number)
{
    pen_trace_crash(crash_trace);
    raise(number);
}

void pen_crash_record_install(struct pen_trace *trace)
{
    static const int signals[] = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};
    crash_trace = trace;
    pen_log_set_ring(&trace->log);
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++) {
        struct sigaction old, action = {.sa_handler = on_crash};
        action.sa_flags = (int)(SA_RESETHAND | SA_NODEFER | SA_ONSTACK);
        if (sigaction(signals[i], NULL, &old) == 0 && old.sa_handler == SIG_DFL)
            sigaction(signals[i], &action, NULL);
    }
}
