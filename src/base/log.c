/* SPDX-License-Identifier: MIT */
/* Each line is written in one write(), so that lines of processes and threads that share standard
 * error do not mix. A pipe keeps a write of up to PIPE_BUF (4096) bytes whole; longer lines are
 * cut. Control characters are escaped and invalid UTF-8 is replaced, so that no input can forge a
 * line. */
#include "base/log.h"

#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/internal/log_writer.h"
#include "base/utf8.h"

enum { NAME_BYTES = 16, MESSAGE_BYTES = 2048, LINE_BYTES = PEN_LOG_LINE_BYTES };

/* A line has fewer than 256 bytes besides the message and the fields; the rest is for the escaped
 * message. */
enum { FIELDS_BYTES = 288, ESCAPED_BYTES = LINE_BYTES - 256 - FIELDS_BYTES };

static struct {
    atomic_int level; /* atomic: relaxed, as a line may use the old level */
    atomic_bool json; /* atomic: relaxed, as level */
    pthread_mutex_t lock;
    char name[NAME_BYTES];     /* guarded by lock */
    struct pen_log_ring *ring; /* guarded by lock */
    atomic_bool has_ring;      /* atomic: relaxed, lets lines below the level return early */
} settings = {.level = PEN_LOG_INFO, .lock = PTHREAD_MUTEX_INITIALIZER};

void pen_log_set_level(enum pen_log_level level)
{
    atomic_store_explicit(&settings.level, (int)level, memory_order_relaxed);
}

void pen_log_set_json(bool json)
{
    atomic_store_explicit(&settings.json, json, memory_order_relaxed);
}

void pen_log_set_name(const char *name)
{
    pthread_mutex_lock(&settings.lock);
    pen_utf8_copy(settings.name, sizeof settings.name, name);
    pthread_mutex_unlock(&settings.lock);
}

void pen_log_set_ring(struct pen_log_ring *ring)
{
    pthread_mutex_lock(&settings.lock);
    settings.ring = ring;
    pthread_mutex_unlock(&settings.lock);
    atomic_store_explicit(&settings.has_ring, ring != NULL, memory_order_relaxed);
}

static void append_to_ring(const char *line, size_t bytes)
{
    pthread_mutex_lock(&settings.lock);
    struct pen_log_ring *ring = settings.ring;
    if (ring) {
        size_t at = atomic_load_explicit(&ring->written, memory_order_relaxed);
        for (size_t i = 0; i < bytes; i++)
            ring->text[(at + i) % PEN_LOG_RING_BYTES] = line[i];
        atomic_store_explicit(&ring->written, at + bytes, memory_order_relaxed);
    }
    pthread_mutex_unlock(&settings.lock);
}

void pen_log_ring_last(const struct pen_log_ring *ring, int lines, char *out, size_t bytes)
{
    size_t end = atomic_load_explicit(&ring->written, memory_order_relaxed);
    size_t most = bytes - 1 < PEN_LOG_RING_BYTES ? bytes - 1 : PEN_LOG_RING_BYTES;
    size_t length = end < most ? end : most;
    for (size_t i = 0; i < length; i++)
        out[i] = ring->text[(end - length + i) % PEN_LOG_RING_BYTES];
    out[length] = '\0';
    const char *from = out;
    if (length < end) { /* the first line may be incomplete */
        const char *newline = strchr(out, '\n');
        from = newline ? newline + 1 : out + length;
    }
    int surplus = -lines;
    for (const char *c = from; *c; c++)
        surplus += *c == '\n';
    for (; surplus > 0; surplus--)
        from = strchr(from, '\n') + 1;
    memmove(out, from, strlen(from) + 1);
}

static const char *level_name(enum pen_log_level level)
{
    static const char *const names[] = {[PEN_LOG_DEBUG] = "debug",
                                        [PEN_LOG_INFO] = "info",
                                        [PEN_LOG_WARN] = "warn",
                                        [PEN_LOG_ERROR] = "error"};
    return (unsigned)level < sizeof names / sizeof names[0] ? names[level] : "error";
}

/* Copies text with hidden characters escaped as in JSON, because a log may be read on a terminal.
 * If `quoted`, quotes and backslashes are escaped too. Text that does not fit is cut between
 * characters. */
static void escape(char out[ESCAPED_BYTES], const char *text, bool quoted)
{
    size_t used = 0;
    for (size_t length; *text; text += length) {
        char piece[PEN_UTF8_SHOWN_BYTES];
        length = pen_utf8_show_char(text, strnlen(text, 4), piece);
        if (quoted && (*text == '"' || *text == '\\'))
            snprintf(piece, sizeof piece, "\\%c", *text);
        size_t bytes = strlen(piece);
        if (used + bytes >= ESCAPED_BYTES)
            break;
        memcpy(out + used, piece, bytes);
        used += bytes;
    }
    out[used] = '\0';
}

static bool is_id(const char *text)
{
    enum { LONGEST = 64 };
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    size_t length = text ? strspn(text, plain) : 0;
    return length > 0 && length <= LONGEST && text[length] == '\0';
}

/* Formats the fields, which are before the message in JSON and after it in text. */
static void write_fields(char out[FIELDS_BYTES], const struct pen_log_about *about, bool json)
{
    const struct {
        const char *name, *id;
        int64_t number;
    } fields[] = {{.name = "job", .id = about->job},
                  {.name = "batch", .number = about->batch},
                  {.name = "attempt", .number = about->attempt},
                  {.name = "request", .id = about->request}};
    size_t used = 0;
    out[0] = '\0';
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        char *to = out + used;
        int length = 0;
        if (is_id(fields[i].id))
            length = snprintf(to, FIELDS_BYTES - used, json ? "\"%s\":\"%s\"," : " %s=%s",
                              fields[i].name, fields[i].id);
        else if (fields[i].number)
            length = snprintf(to, FIELDS_BYTES - used, json ? "\"%s\":%lld," : " %s=%lld",
                              fields[i].name, (long long)fields[i].number);
        used += (size_t)length;
    }
}

/* Formats a line. Returns its length. */
static int format_line(char line[LINE_BYTES], enum pen_log_level level,
                       const struct pen_log_about *about, const char *message)
{
    bool json = atomic_load_explicit(&settings.json, memory_order_relaxed);
    char stamp[25], name[NAME_BYTES], process[6 * NAME_BYTES], text[ESCAPED_BYTES],
        fields[FIELDS_BYTES];
    pen_clock_format(pen_clock_wall_ms(), stamp);
    pthread_mutex_lock(&settings.lock);
    memcpy(name, settings.name, sizeof name);
    pthread_mutex_unlock(&settings.lock);
    escape(text, name, json);
    pen_utf8_copy(process, sizeof process, text);
    escape(text, message, json);
    write_fields(fields, about, json);
    const char *shown_level = level_name(level);
    long pid = (long)getpid();
    if (!json)
        return snprintf(line, LINE_BYTES, "%s %-5s %s[%ld] %s%s\n", stamp, shown_level, process,
                        pid, text, fields);
    return snprintf(line, LINE_BYTES,
                    "{\"time\":\"%s\",\"level\":\"%s\",\"process\":\"%s\",\"pid\":%ld,"
                    "%s\"message\":\"%s\"}\n",
                    stamp, shown_level, process, pid, fields, text);
}

void pen_log_write(const char *lines, size_t bytes)
{
    while (bytes > 0) {
        const ssize_t written = write(STDERR_FILENO, lines, bytes);
        if (written < 0 && errno != EINTR)
            return;
        lines += written > 0 ? written : 0;
        bytes -= written > 0 ? (size_t)written : 0;
    }
}

static void write_line(enum pen_log_level level, const struct pen_log_about *about,
                       const char *format, va_list args)
{
    bool shown = (int)level >= atomic_load_explicit(&settings.level, memory_order_relaxed);
    if (!shown && !atomic_load_explicit(&settings.has_ring, memory_order_relaxed))
        return;
    int saved_errno = errno;
    char raw[MESSAGE_BYTES], message[MESSAGE_BYTES], line[LINE_BYTES];
    int length = vsnprintf(raw, sizeof raw, format, args);
    if (length >= 0) {
        pen_utf8_copy(message, sizeof message, raw);
        const size_t bytes = (size_t)format_line(line, level, about, message);
        append_to_ring(line, bytes);
        if (shown && !pen_log_writer_take(line, bytes))
            pen_log_write(line, bytes);
    }
    errno = saved_errno;
}

void pen_log(enum pen_log_level level, const char *format, ...)
{
    static const struct pen_log_about nothing = {0};
    va_list args;
    va_start(args, format);
    write_line(level, &nothing, format, args);
    va_end(args);
}

void pen_log_about(enum pen_log_level level, const struct pen_log_about *about, const char *format,
                   ...)
{
    va_list args;
    va_start(args, format);
    write_line(level, about, format, args);
    va_end(args);
}
