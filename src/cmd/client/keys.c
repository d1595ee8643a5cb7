/* SPDX-License-Identifier: MIT */
#include "cmd/client/keys.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

#include "base/clock.h"

static atomic_int stop_signal; /* set by a signal handler; 0: none has come */

static void note_signal(int signal)
{
    atomic_store(&stop_signal, signal);
}

void pen_keys_begin(struct pen_keys *keys)
{
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = note_signal};
    *keys = (struct pen_keys){.on = false};
    keys->on = isatty(STDIN_FILENO) && tcgetpgrp(STDIN_FILENO) == getpgrp() &&
               tcgetattr(STDIN_FILENO, &keys->before) == 0;
    if (!keys->on)
        return;
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++)
        sigaction(signals[i], &action, NULL);
    struct termios single = keys->before;
    single.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &single);
}

/* Reads the keys that are waiting. Returns false if q is among them, or if there is no terminal any
 * more. */
static bool read_keys(void)
{
    char keys[64];
    ssize_t got = read(STDIN_FILENO, keys, sizeof keys);
    if (got < 0)
        return errno == EINTR || errno == EAGAIN;
    for (ssize_t i = 0; i < got; i++) {
        if (keys[i] == 'q' || keys[i] == 'Q')
            return false;
    }
    return got > 0;
}

bool pen_keys_wait(const struct pen_keys *keys, int milliseconds)
{
    struct pollfd fd = {.fd = keys->on ? STDIN_FILENO : -1, .events = POLLIN};
    int64_t end_ns = pen_clock_ns() + (int64_t)milliseconds * 1000000;
    for (;;) {
        int64_t left_ms = (end_ns - pen_clock_ns()) / 1000000;
        int ready = poll(&fd, 1, left_ms > 0 ? (int)left_ms : 0);
        if (atomic_load(&stop_signal) || (ready > 0 && !read_keys()))
            return false;
        if (left_ms <= 0)
            return true;
    }
}

void pen_keys_end(struct pen_keys *keys)
{
    if (keys->on)
        tcsetattr(STDIN_FILENO, TCSANOW, &keys->before);
    keys->on = false;
    int stopped_by = atomic_load(&stop_signal);
    if (stopped_by) {
        signal(stopped_by, SIG_DFL);
        raise(stopped_by);
    }
}
