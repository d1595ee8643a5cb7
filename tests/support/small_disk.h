/* SPDX-License-Identifier: MIT */
/* A small disk for a test: a tmpfs in the test's own mount namespace. It needs root's rights. */
#ifndef TESTS_SUPPORT_SMALL_DISK_H
#define TESTS_SUPPORT_SMALL_DISK_H

#include <stdbool.h>
#include <stdint.h>

/* Mounts a disk of `mib` MiB on a folder. If that is not allowed, it says so, removes the folder
 * and returns false; then the test cannot run. Call it before there are threads. */
bool small_disk_mount(const char *folder, int mib);

/* Unmounts the disk and removes the folder. No file in it may be open. */
void small_disk_unmount(const char *folder);

/* Fills the disk with a file, but leaves `but_bytes` free. small_disk_free removes the file. */
void small_disk_fill(const char *folder, int64_t but_bytes);
void small_disk_free(const char *folder);

#endif
