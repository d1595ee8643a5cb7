/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/notify.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/log.h"

/* Connects to a socket by its path, or by its abstract name if it begins with '@'. Returns -1 with
 * errno after a failure. */
static int connect_to(const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const size_t length = strlen(name);
    if ((name[0] != '/' && name[0] != '@') || length >= sizeof address.sun_path) {
        errno = EINVAL;
        return -1;
    }
    memcpy(address.sun_path, name, length);
    if (name[0] == '@')
        address.sun_path[0] = '\0';
    const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const socklen_t bytes = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + length);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, bytes) == 0)
        return fd;
    const int cause = errno;
    if (fd >= 0)
        close(fd);
    errno = cause;
    return -1;
}

/* Returns the time of $WATCHDOG_USEC, if it is meant for this process. */
static int64_t read_watchdog(void)
{
    const char *usec = getenv("WATCHDOG_USEC"), *pid = getenv("WATCHDOG_PID");
    if (!usec || (pid && strtoll(pid, NULL, 10) != getpid()))
        return 0;
    const long long us = strtoll(usec, NULL, 10);
    return us > 0 && us < INT64_MAX / 1000 ? us * 1000 : 0;
}

void pen_notify_open(struct pen_notify *notify)
{
    const char *name = getenv("NOTIFY_SOCKET");
    *notify = (struct pen_notify){.fd = -1};
    if (name && *name) {
        notify->fd = connect_to(name);
        if (notify->fd < 0)
            pen_log(PEN_LOG_WARN, "cannot reach the service manager at %s: %s", name,
                    strerror(errno));
    }
    if (notify->fd >= 0)
        notify->watchdog_ns = read_watchdog();
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    unsetenv("WATCHDOG_PID");
}

void pen_notify_close(struct pen_notify *notify)
{
    if (notify->fd >= 0)
        close(notify->fd);
    notify->fd = -1;
}

bool pen_notify_send(const struct pen_notify *notify, const char *message)
{
    return notify->fd < 0 ||
           send(notify->fd, message, strlen(message), MSG_NOSIGNAL | MSG_DONTWAIT) >= 0 ||
           (errno != EAGAIN && errno != ENOBUFS);
}
