/* SPDX-License-Identifier: MIT */
/* A small disk for a test: a tmpfs in a mount namespace of the test's own, which takes root's
 * rights. */
#ifndef TESTS_SUPPORT_SMALL_DISK_H
#define TESTS_SUPPORT_SMALL_DISK_H

#include <stdbool.h>
#include <stdint.h>

/* Mounts a disk of so many MiB on a folder. Returns false, says so and removes the folder, where
 * that is not allowed: then nothing can be tested. Call it before there are threads. */
bool small_disk_mount(const char *folder, int mib);

/* Unmounts it and removes the folder, in which no file may be open. */
void small_disk_unmount(const char *folder);

/* Fills the disk with a file, up to so many bytes; 0: all of it. small_disk_free removes that. */
void small_disk_fill(const char *folder, int64_t but_bytes);
void small_disk_free(const char *folder);

#endif
