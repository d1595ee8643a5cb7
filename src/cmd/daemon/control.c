/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/control.h"

#include <errno.h>
#include <poll.h>
#include <stdint.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"

void pen_control_send(int fd, const char *text)
{
    if (fd >= 0)
        (void)send(fd, text, strlen(text), MSG_DONTWAIT | MSG_NOSIGNAL);
}

bool pen_event_source_open(struct pen_event_source *source, int control_fd, struct pen_status *st)
{
    *source = (struct pen_event_source){.control_fd = control_fd,
                                        .end_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    if (source->end_fd >= 0)
        return true;
    pen_fail(st, PEN_IO, "cannot wait for events: %s", strerror(errno));
    pen_event_source_close(source);
    return false;
}

static void close_fd(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

void pen_event_source_close(struct pen_event_source *source)
{
    close_fd(&source->end_fd);
    close_fd(&source->control_fd);
}

void pen_event_source_work_ended(const struct pen_event_source *source)
{
    uint64_t one = 1;
    ssize_t put = write(source->end_fd, &one, sizeof one);
    (void)put; /* it cannot fail, because the counter is incremented once */
}

/* If the text is "WORD" or "WORD REST", copies the rest and returns true. */
static bool take_word(const char *text, const char *word, char rest[PEN_CONTROL_BYTES])
{
    size_t length = strlen(word);
    if (strncmp(text, word, length) != 0 || (text[length] && text[length] != ' '))
        return false;
    const char *from = text + length + (text[length] == ' ');
    memmove(rest, from, strlen(from) + 1);
    return true;
}

static bool take_message(struct pen_event_source *source, struct pen_event *event)
{
    static const struct {
        const char *word;
        enum pen_event_kind kind;
    } words[] = {{"drain", PEN_EVENT_DRAIN},
                 {"stop", PEN_EVENT_STOP},
                 {"log", PEN_EVENT_LOG},
                 {"state", PEN_EVENT_STATE}};
    char text[PEN_CONTROL_BYTES];
    ssize_t got = recv(source->control_fd, text, sizeof text - 1, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR))
        return false;
    if (got <= 0) {
        close_fd(&source->control_fd);
        event->kind = PEN_EVENT_LOST;
        return true;
    }
    text[got] = '\0';
    if (strcmp(text, "ping") == 0)
        pen_control_send(source->control_fd, "pong");
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (take_word(text, words[i].word, event->text)) {
            event->kind = words[i].kind;
            return true;
        }
    }
    return false;
}

void pen_event_source_next(struct pen_event_source *source, int timeout_ms, struct pen_event *event)
{
    const int64_t end_ns = pen_clock_ns() + (int64_t)timeout_ms * 1000000;
    *event = (struct pen_event){.kind = PEN_EVENT_TIMEOUT};
    enum { END, CONTROL, COUNT };
    struct pollfd fds[COUNT] = {[END] = {.fd = source->end_fd, .events = POLLIN},
                                [CONTROL] = {.fd = source->control_fd, .events = POLLIN}};
    for (;;) {
        const int64_t left_ns = end_ns - pen_clock_ns();
        const int wait_ms = left_ns > 0 ? (int)((left_ns + 999999) / 1000000) : 0;
        int count = poll(fds, COUNT, timeout_ms < 0 ? timeout_ms : wait_ms);
        if (count == 0)
            return;
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0) {
            event->kind = PEN_EVENT_STOP; /* poll is broken, so there is no way to wait */
            return;
        }
        if (fds[END].revents) {
            event->kind = PEN_EVENT_WORK_END;
            return;
        }
        if (fds[CONTROL].revents && take_message(source, event))
            return;
    }
}
