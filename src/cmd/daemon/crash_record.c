/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/crash_record.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

/* For the signal handler: where to note the crash. Set once, before the handler is installed. */
static struct pen_trace *watched;

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

/* The second time the signal has its default effect, as if there had been no handler. */
static void on_crash(int number)
{
    pen_trace_crash(watched);
    raise(number);
}

void pen_crash_record_install(struct pen_trace *trace)
{
    static const int crashes[] = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};
    watched = trace;
    pen_log_set_ring(&trace->log);
    for (size_t i = 0; i < sizeof crashes / sizeof crashes[0]; i++) {
        struct sigaction old, action = {.sa_handler = on_crash};
        action.sa_flags = (int)(SA_RESETHAND | SA_NODEFER | SA_ONSTACK);
        if (sigaction(crashes[i], NULL, &old) == 0 && old.sa_handler == SIG_DFL)
            sigaction(crashes[i], &action, NULL);
    }
}
