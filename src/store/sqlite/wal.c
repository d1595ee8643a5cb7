/* SPDX-License-Identifier: MIT */
/* Looks for damage in the write-ahead log. SQLite reads the log up to the first frame whose
 * checksum is wrong, and takes the rest for the torn end of a transaction that was never committed.
 * After a crash that is right. But a log that was damaged later silently loses committed
 * transactions the same way. The two cases differ:
 *
 *  - The header is written and synced before the first commit. So a header that is neither zero nor
 *    has the right checksum was overwritten.
 *  - A transaction is synced before the next one begins, and checksums continue from one
 *    transaction to the next. Suppose a frame is wrong, and in a chain of checksums restarted
 *    behind it two commits follow each other. Then the first of the two was complete on the disk
 *    once, and the wrong frame before it is damage. A failed or torn transaction leaves a chain
 *    with one commit at most, since no transaction was ever built on it.
 *
 * Source: SQLite, "Database File Format", section 4, the write-ahead log. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "store/sqlite/sqlite.h"

enum { HEADER_BYTES = 32, FRAME_HEADER_BYTES = 24, TRIES = 3 };
static const uint32_t magic_little = 0x377f0682; /* checksums of little-endian words; +1: big */

struct wal {
    int fd;
    uint32_t page_bytes;
    bool big_endian;
    unsigned char salts[8];
    uint32_t sum[2];
    unsigned char *frame; /* header and page */
};

static uint32_t word_at(const unsigned char *bytes, bool big_endian)
{
    uint32_t b[4] = {bytes[0], bytes[1], bytes[2], bytes[3]};
    return big_endian ? b[0] << 24 | b[1] << 16 | b[2] << 8 | b[3]
                      : b[3] << 24 | b[2] << 16 | b[1] << 8 | b[0];
}

static void add_sum(struct wal *wal, const unsigned char *data, size_t bytes)
{
    for (size_t i = 0; i < bytes; i += 8) {
        wal->sum[0] += word_at(data + i, wal->big_endian) + wal->sum[1];
        wal->sum[1] += word_at(data + i + 4, wal->big_endian) + wal->sum[0];
    }
}

static bool has_sum(const struct wal *wal, const unsigned char *data)
{
    return word_at(data, true) == wal->sum[0] && word_at(data + 4, true) == wal->sum[1];
}

enum verdict { WAL_GOOD, WAL_BAD_HEADER, WAL_BAD_FRAME, WAL_UNREADABLE, WAL_NO_MEMORY };

/* Reads the header; *any: frames may follow. */
static enum verdict read_header(struct wal *wal, bool *any)
{
    static const unsigned char zero[HEADER_BYTES];
    unsigned char header[HEADER_BYTES];
    ssize_t got = pread(wal->fd, header, sizeof header, 0);
    *any = false;
    if (got < 0)
        return WAL_UNREADABLE;
    if (got < HEADER_BYTES || memcmp(header, zero, sizeof zero) == 0)
        return WAL_GOOD;
    uint32_t magic = word_at(header, true);
    wal->big_endian = magic & 1;
    wal->page_bytes = word_at(header + 8, true);
    wal->sum[0] = wal->sum[1] = 0;
    add_sum(wal, header, 24);
    if ((magic & ~1u) != magic_little || !has_sum(wal, header + 24) || wal->page_bytes < 512 ||
        wal->page_bytes > 65536)
        return WAL_BAD_HEADER;
    memcpy(wal->salts, header + 16, sizeof wal->salts);
    *any = true;
    return WAL_GOOD;
}

/* Reads frame i; returns false at the end. *ours: the frame belongs to this generation of the log,
 * *commit: it ends a transaction. */
static bool read_frame(const struct wal *wal, int64_t i, bool *ours, bool *commit)
{
    size_t bytes = FRAME_HEADER_BYTES + wal->page_bytes;
    ssize_t got = pread(wal->fd, wal->frame, bytes, HEADER_BYTES + i * (int64_t)bytes);
    if (got != (ssize_t)bytes)
        return false;
    *ours = memcmp(wal->frame + 8, wal->salts, sizeof wal->salts) == 0;
    *commit = word_at(wal->frame + 4, true) != 0;
    return true;
}

/* Continues the chain of checksums by the frame; tells whether the frame has that checksum. */
static bool continues_chain(struct wal *wal)
{
    add_sum(wal, wal->frame, 8);
    add_sum(wal, wal->frame + FRAME_HEADER_BYTES, wal->page_bytes);
    return has_sum(wal, wal->frame + 16);
}

/* Restarts the chain from the checksum that the frame states. */
static void begin_chain(struct wal *wal)
{
    wal->sum[0] = word_at(wal->frame + 16, true);
    wal->sum[1] = word_at(wal->frame + 20, true);
}

static enum verdict read_frames(struct wal *wal)
{
    bool ours, commit, broken = false;
    int commits = 0; /* in the present chain, behind the first wrong frame */
    for (int64_t i = 0; read_frame(wal, i, &ours, &commit); i++) {
        if (!continues_chain(wal) || !ours) {
            broken = true;
            commits = 0;
            begin_chain(wal);
        }
        commits += broken && ours && commit;
        if (commits == 2)
            return WAL_BAD_FRAME;
    }
    return WAL_GOOD;
}

static enum verdict check_file(const char *path)
{
    struct wal wal = {.fd = open(path, O_RDONLY | O_CLOEXEC)};
    bool any;
    if (wal.fd < 0)
        return errno == ENOENT ? WAL_GOOD : WAL_UNREADABLE;
    enum verdict verdict = read_header(&wal, &any);
    if (any) {
        wal.frame = malloc(FRAME_HEADER_BYTES + wal.page_bytes);
        verdict = wal.frame ? read_frames(&wal) : WAL_NO_MEMORY;
        free(wal.frame);
    }
    int error = errno;
    close(wal.fd);
    errno = error;
    return verdict;
}

bool pen_sqlite_check_log(struct pen_sqlite_store *store, struct pen_status *st)
{
    char path[PEN_SQLITE_PATH_BYTES];
    pen_sqlite_path(store, "-wal", path);
    enum verdict verdict = check_file(path);
    /* Other handles may be writing, so a log that seems damaged is read again. */
    for (int i = 1; i < TRIES && (verdict == WAL_BAD_HEADER || verdict == WAL_BAD_FRAME); i++)
        verdict = check_file(path);
    switch (verdict) {
    case WAL_GOOD:
        break;
    case WAL_UNREADABLE:
        return pen_sqlite_io_error(store, SQLITE_IOERR_READ, errno, st);
    case WAL_NO_MEMORY:
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    case WAL_BAD_HEADER:
    case WAL_BAD_FRAME:
        return pen_sqlite_damaged(store, st,
                                  "%s, the log of the store's last changes, is damaged (%s)", path,
                                  verdict == WAL_BAD_HEADER ? "its header" : "before its end");
    }
    return true;
}
