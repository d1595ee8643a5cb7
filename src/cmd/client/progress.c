/* SPDX-License-Identifier: MIT */
#include "cmd/client/progress.h"

#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/utf8.h"

static const int64_t redraw_ns = 100 * 1000 * 1000;

void pen_progress_begin(struct pen_progress *progress, const char *label, bool quiet)
{
    *progress =
        (struct pen_progress){.on = !quiet && isatty(STDERR_FILENO), .start_ns = pen_clock_ns()};
    pen_utf8_show(progress->label, sizeof progress->label, label);
}

void pen_progress_time(double seconds, char out[16])
{
    if (!(seconds >= 0 && seconds < 360000)) {
        snprintf(out, 16, "-:--");
        return;
    }
    int s = (int)(seconds + 0.5);
    if (s >= 3600)
        snprintf(out, 16, "%d:%02d:%02d", s / 3600, s / 60 % 60, s % 60);
    else
        snprintf(out, 16, "%d:%02d", s / 60, s % 60);
}

void pen_progress_count(double count, char out[16])
{
    static const char *const units[] = {"", " k", " M", " G", " T", " P"};
    size_t unit = 0;
    for (; count >= 999.5 && unit + 1 < sizeof units / sizeof units[0]; unit++)
        count /= 1000;
    snprintf(out, 16, unit > 0 && count < 99.95 ? "%.1f%s" : "%.0f%s", count, units[unit]);
}

void pen_progress_text(const char *label, double fraction, double eta_seconds, int columns,
                       char *out, size_t bytes)
{
    char left[16], bar[64];
    pen_progress_time(eta_seconds, left);
    fraction = fraction < 0 ? 0 : fraction > 1 ? 1 : fraction;
    int space = columns - (int)strlen(label) - 24;
    int width = space > 40 ? 40 : space;
    if (width < 8) {
        snprintf(out, bytes, "%3d %%  %s left", (int)(fraction * 100), left);
        return;
    }
    int full = (int)(fraction * width);
    memset(bar, ' ', (size_t)width);
    memset(bar, '#', (size_t)full);
    bar[width] = '\0';
    snprintf(out, bytes, "%s [%s] %3d %%  %s left", label, bar, (int)(fraction * 100), left);
}

static void draw(const char *text)
{
    fprintf(stderr, "\r\033[K%s", text);
    fflush(stderr);
}

/* Returns true if it is time to draw: `always`, or redraw_ns after the last time. Notes the time if
 * so. */
static bool due(struct pen_progress *progress, bool always)
{
    int64_t now = pen_clock_ns();
    if (!progress->on || (!always && progress->drawn_ns && now - progress->drawn_ns < redraw_ns))
        return false;
    progress->drawn_ns = now;
    return true;
}

void pen_progress_show(struct pen_progress *progress, double fraction, double eta_seconds)
{
    if (!due(progress, fraction >= 1))
        return;
    struct winsize size;
    int columns = 80;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        columns = size.ws_col;
    double spent = (double)(progress->drawn_ns - progress->start_ns) * 1e-9;
    if (eta_seconds < 0 && fraction > 0)
        eta_seconds = spent * (1 - fraction) / fraction;
    char text[256];
    pen_progress_text(progress->label, fraction, eta_seconds, columns - 1, text, sizeof text);
    draw(text);
}

void pen_progress_note(struct pen_progress *progress, const char *note)
{
    if (!due(progress, true))
        return;
    char text[256], shown[181];
    pen_utf8_show(shown, sizeof shown, note);
    snprintf(text, sizeof text, "%.63s: %s", progress->label, shown);
    draw(text);
}

void pen_progress_end(struct pen_progress *progress)
{
    if (progress->on && progress->drawn_ns)
        draw("");
    progress->on = false;
}
