/* SPDX-License-Identifier: MIT */
#include "cmd/client/keys.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

#include "base/clock.h"

static const int signals[PEN_KEYS_SIGNALS] = {SIGINT, SIGTERM, SIGHUP};
static atomic_int stop_signal; /* set by a signal handler; 0: no signal */

static void note_signal(int signal)
{
    atomic_store(&stop_signal, signal);
}

void pen_keys_begin(struct pen_keys *keys)
{
    struct sigaction action = {.sa_handler = note_signal};
    *keys = (struct pen_keys){.on = false};
    keys->on = isatty(STDIN_FILENO) && tcgetpgrp(STDIN_FILENO) == getpgrp() &&
               tcgetattr(STDIN_FILENO, &keys->before) == 0;
    if (!keys->on)
        return;
    sigset_t held;
    sigemptyset(&held);
    for (int i = 0; i < PEN_KEYS_SIGNALS; i++)
        sigaddset(&held, signals[i]);
    sigprocmask(SIG_BLOCK, &held, &keys->mask_before);
    for (int i = 0; i < PEN_KEYS_SIGNALS; i++)
        sigaction(signals[i], &action, &keys->actions_before[i]);
    struct termios single = keys->before;
    single.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &single);
}

/* Reads the waiting keys. Returns false if q is among them, or if the terminal is gone. */
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

/* The signals are blocked except during the wait. So a signal between two waits ends the next wait
 * at once. With handlers alone, a signal just before a wait would be noticed only at its end. */
bool pen_keys_wait(const struct pen_keys *keys, int milliseconds)
{
    struct pollfd fd = {.fd = keys->on ? STDIN_FILENO : -1, .events = POLLIN};
    int64_t end_ns = pen_clock_ns() + (int64_t)milliseconds * 1000000;
    for (;;) {
        int64_t left_ns = end_ns - pen_clock_ns();
        if (left_ns < 0)
            left_ns = 0;
        struct timespec left = {.tv_sec = left_ns / 1000000000, .tv_nsec = left_ns % 1000000000};
        int ready = ppoll(&fd, 1, &left, keys->on ? &keys->mask_before : NULL);
        if (atomic_load(&stop_signal) || (ready > 0 && !read_keys()))
            return false;
        if (left_ns == 0)
            return true;
    }
}

void pen_keys_end(struct pen_keys *keys)
{
    if (!keys->on)
        return;
    keys->on = false;
    tcsetattr(STDIN_FILENO, TCSANOW, &keys->before);
    sigprocmask(SIG_SETMASK, &keys->mask_before, NULL); /* a pending signal is noted here */
    for (int i = 0; i < PEN_KEYS_SIGNALS; i++)
        sigaction(signals[i], &keys->actions_before[i], NULL);
    int stopped_by = atomic_load(&stop_signal);
    if (stopped_by)
        raise(stopped_by);
}
