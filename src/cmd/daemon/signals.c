/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/signals.h"

#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <sys/signalfd.h>

static sigset_t handled(void)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGHUP);
    return set;
}

void pen_signals_hold(void)
{
    sigset_t set = handled();
    pthread_sigmask(SIG_BLOCK, &set, NULL);
}

void pen_signals_hold_alone(void)
{
    sigset_t set = handled();
    pthread_sigmask(SIG_SETMASK, &set, NULL);
}

int pen_signals_open(void)
{
    sigset_t set = handled();
    sigaddset(&set, SIGCHLD);
    signal(SIGPIPE, SIG_IGN);
    errno = pthread_sigmask(SIG_BLOCK, &set, NULL);
    return errno ? -1 : signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}
