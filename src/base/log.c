/* SPDX-License-Identifier: MIT */
/* One line is one write(), so lines of processes and threads that share standard error do not
 * mix (a pipe keeps writes of up to PIPE_BUF, 4096 bytes, whole: longer lines are cut). Control
 * characters and invalid UTF-8 in a message are escaped: no input can forge a line. */
#include "pen/base/log.h"

#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "pen/base/clock.h"
#include "pen/base/utf8.h"

enum { NAME_BYTES = 16, MESSAGE_BYTES = 2048, LINE_BYTES = 4096 };

/* Room an escaped message may take: what the line needs besides is less than this reserve. */
enum { ESCAPED_BYTES = LINE_BYTES - 256 };

static struct {
    atomic_int level; /* atomic: relaxed, a late change of level loses nothing */
    atomic_bool json; /* atomic: relaxed, as level */
    pthread_mutex_t lock;
    char name[NAME_BYTES]; /* guarded by lock */
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

static const char *level_name(enum pen_log_level level)
{
    static const char *const names[] = {"debug", "info", "warn", "error"};
    return (unsigned)level < sizeof names / sizeof names[0] ? names[level] : "error";
}

/* Copies text, escaping as JSON does control characters and, if quoted is set, quotes and
 * backslashes. Cuts between characters where out would overflow. */
static void escape(char out[ESCAPED_BYTES], const char *text, bool quoted)
{
    size_t used = 0;
    for (size_t length; *text; text += length) {
        char piece[8];
        length = pen_utf8_char(text, strnlen(text, 4));
        unsigned char c = (unsigned char)*text;
        if (c < 0x20 || c == 0x7F)
            snprintf(piece, sizeof piece, c == '\n' ? "\\n" : "\\u%04x", c);
        else if (quoted && (c == '"' || c == '\\'))
            snprintf(piece, sizeof piece, "\\%c", c);
        else
            snprintf(piece, sizeof piece, "%.*s", (int)length, text);
        size_t bytes = strlen(piece);
        if (used + bytes >= ESCAPED_BYTES)
            break;
        memcpy(out + used, piece, bytes);
        used += bytes;
    }
    out[used] = '\0';
}

static int compose(char line[LINE_BYTES], enum pen_log_level level, const char *message)
{
    bool json = atomic_load_explicit(&settings.json, memory_order_relaxed);
    char when[25], name[NAME_BYTES], who[6 * NAME_BYTES], text[ESCAPED_BYTES];
    pen_clock_format(pen_clock_wall_ms(), when);
    pthread_mutex_lock(&settings.lock);
    memcpy(name, settings.name, sizeof name);
    pthread_mutex_unlock(&settings.lock);
    escape(text, name, json);
    pen_utf8_copy(who, sizeof who, text);
    escape(text, message, json);
    const char *what = level_name(level);
    long pid = (long)getpid();
    if (!json)
        return snprintf(line, LINE_BYTES, "%s %-5s %s[%ld] %s\n", when, what, who, pid, text);
    return snprintf(line, LINE_BYTES,
                    "{\"time\":\"%s\",\"level\":\"%s\",\"process\":\"%s\",\"pid\":%ld,"
                    "\"message\":\"%s\"}\n",
                    when, what, who, pid, text);
}

void pen_log(enum pen_log_level level, const char *format, ...)
{
    if ((int)level < atomic_load_explicit(&settings.level, memory_order_relaxed))
        return;
    int saved_errno = errno;
    char raw[MESSAGE_BYTES], message[MESSAGE_BYTES], line[LINE_BYTES];
    va_list args;
    va_start(args, format);
    int length = vsnprintf(raw, sizeof raw, format, args);
    va_end(args);
    if (length >= 0) {
        pen_utf8_copy(message, sizeof message, raw);
        int bytes = compose(line, level, message);
        ssize_t written;
        do
            written = write(STDERR_FILENO, line, (size_t)bytes);
        while (written < 0 && errno == EINTR);
    }
    errno = saved_errno;
}
