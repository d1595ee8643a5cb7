/* SPDX-License-Identifier: MIT */
#include "support/small_disk.h"

#include <check.h>
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "support/suite.h"

enum { PAGE_BYTES = 4096 };

bool small_disk_mount(const char *folder, int mib)
{
    char size[32];
    snprintf(size, sizeof size, "size=%dm", mib);
    if (unshare(CLONE_NEWNS) == 0 && mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0 &&
        mount("none", folder, "tmpfs", 0, size) == 0)
        return true;
    suite_skip("mount", strerror(errno));
    rmdir(folder);
    return false;
}

void small_disk_unmount(const char *folder)
{
    ck_assert_int_eq(umount(folder), 0);
    ck_assert_int_eq(rmdir(folder), 0);
}

static void ballast(const char *folder, char path[128])
{
    snprintf(path, 128, "%s/ballast", folder);
}

static int64_t free_bytes(const char *folder)
{
    struct statvfs info;
    ck_assert_int_eq(statvfs(folder, &info), 0);
    return (int64_t)info.f_bavail * (int64_t)info.f_frsize;
}

void small_disk_fill(const char *folder, int64_t but_bytes)
{
    static char zeros[PAGE_BYTES];
    char path[128];
    ballast(folder, path);
    const int fd = open(path, O_WRONLY | O_CREAT | O_APPEND, 0600);
    ck_assert_int_ge(fd, 0);
    while (free_bytes(folder) > but_bytes && write(fd, zeros, sizeof zeros) > 0)
        continue;
    close(fd);
}

void small_disk_free(const char *folder)
{
    char path[128];
    ballast(folder, path);
    ck_assert_int_eq(unlink(path), 0);
}
