/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/worker_exit.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>

#include "base/status.h"

void pen_exit_describe(int wait_status, char *out, size_t bytes)
{
    if (WIFSIGNALED(wait_status)) {
        const char *name = sigabbrev_np(WTERMSIG(wait_status));
        snprintf(out, bytes, "signal %d (SIG%s)", WTERMSIG(wait_status), name ? name : "?");
    } else if (WEXITSTATUS(wait_status) == PEN_EXEC_FAILED) {
        snprintf(out, bytes, "the program could not be started");
    } else {
        snprintf(out, bytes, "exit code %d", WEXITSTATUS(wait_status));
    }
}

static bool is_crash_signal(int signal, bool oom)
{
    switch (signal) {
    case SIGSEGV:
    case SIGBUS:
    case SIGILL:
    case SIGFPE:
    case SIGABRT:
        return true;
    case SIGKILL:
    case SIGTERM:
        return oom;
    default:
        return false;
    }
}

static bool is_crash_exit(int code)
{
    return code != 0 && code != PEN_EXEC_FAILED && code != pen_code_exit(PEN_STORAGE) &&
           code != pen_code_exit(PEN_UNAVAILABLE);
}

enum pen_worker_end pen_exit_worker_end(int wait_status, bool oom)
{
    bool crashed = WIFSIGNALED(wait_status) ? is_crash_signal(WTERMSIG(wait_status), oom)
                                            : is_crash_exit(WEXITSTATUS(wait_status));
    return crashed ? PEN_WORKER_CRASHED : PEN_WORKER_DIED;
}
