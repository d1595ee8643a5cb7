/* SPDX-License-Identifier: MIT */
/* Reads /proc, /sys, /etc/machine-id and the program's own ELF notes. */
#include "study/host.h"

#include <elf.h>
#include <inttypes.h>
#include <link.h>
#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "base/utf8.h"
#include "io/figures.h"

enum { TEXT_BYTES = 128 };

/* The first line of a file; "" if it cannot be read. */
static void read_line(const char *path, char out[TEXT_BYTES])
{
    char line[TEXT_BYTES] = "";
    FILE *file = fopen(path, "re");
    if (file && !fgets(line, sizeof line, file))
        line[0] = '\0';
    if (file)
        fclose(file);
    line[strcspn(line, "\n")] = '\0';
    pen_utf8_copy(out, TEXT_BYTES, line);
}

/* The value of a key in /proc/cpuinfo, for the first processor. */
static void read_cpuinfo(const char *key, char out[TEXT_BYTES])
{
    char line[512];
    FILE *file = fopen("/proc/cpuinfo", "re");
    out[0] = '\0';
    while (file && fgets(line, sizeof line, file)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) != 0 || !colon)
            continue;
        line[strcspn(line, "\n")] = '\0';
        pen_utf8_copy(out, TEXT_BYTES, colon + 1 + strspn(colon + 1, " \t"));
        break;
    }
    if (file)
        fclose(file);
}

/* The machine's id, hashed as machine-id(5) demands: FNV-1a over its text and a name of our own. */
static void hash_machine(char out[TEXT_BYTES])
{
    char text[TEXT_BYTES];
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    out[0] = '\0';
    read_line("/etc/machine-id", text);
    if (!text[0])
        return;
    strncat(text, "penumbra benchmark", sizeof text - strlen(text) - 1);
    for (const char *c = text; *c; c++)
        hash = (hash ^ (unsigned char)*c) * UINT64_C(0x100000001b3);
    snprintf(out, TEXT_BYTES, "%016" PRIx64, hash);
}

/* Finds the build id among the notes of a segment. */
static void find_note(const char *notes, size_t bytes, char out[TEXT_BYTES])
{
    ElfW(Nhdr) note;
    while (bytes >= sizeof note) {
        memcpy(&note, notes, sizeof note);
        const size_t name = (note.n_namesz + 3u) & ~3u, text = (note.n_descsz + 3u) & ~3u;
        if (sizeof note + name + text > bytes)
            return;
        const char *id = notes + sizeof note + name;
        if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == 4 &&
            memcmp(notes + sizeof note, "GNU", 4) == 0) {
            for (size_t i = 0; i < note.n_descsz && 2 * i + 2 < TEXT_BYTES; i++)
                snprintf(out + 2 * i, 3, "%02x", (unsigned)(unsigned char)id[i]);
            return;
        }
        notes = id + text;
        bytes -= sizeof note + name + text;
    }
}

/* Reads the notes of the program, which is the first object that dl_iterate_phdr reports. */
static int read_program(struct dl_phdr_info *info, size_t size, void *out)
{
    (void)size;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *segment = &info->dlpi_phdr[i];
        if (segment->p_type == PT_NOTE)
            find_note((const char *)(info->dlpi_addr + segment->p_vaddr), segment->p_memsz, out);
    }
    return 1;
}

static const char *compiler(void)
{
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "";
#endif
}

json_t *pen_host_json(void)
{
    char id[TEXT_BYTES], microcode[TEXT_BYTES], governor[TEXT_BYTES], build[TEXT_BYTES] = "";
    char machine[TEXT_BYTES] = "";
    struct utsname name;
    hash_machine(id);
    read_cpuinfo("microcode", microcode);
    read_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", governor);
    dl_iterate_phdr(read_program, build);
    const bool named = uname(&name) == 0;
    if (named)
        pen_utf8_copy(machine, sizeof machine, name.nodename);
    json_t *host = pen_figure_host();
    json_t *more =
        json_pack("{s:s, s:s, s:s, s:s, s:o, s:s, s:s}", "name", machine, "id", id, "microcode",
                  microcode, "governor", governor, "kernel",
                  named ? json_sprintf("%s %s", name.sysname, name.release) : json_string(""),
                  "compiler", compiler(), "build", build);
    if (host && (!more || json_object_update(host, more) != 0)) {
        json_decref(host);
        host = NULL;
    }
    json_decref(more);
    return host;
}

double pen_host_steal_ms(void)
{
    unsigned long long ticks;
    FILE *file = fopen("/proc/stat", "re");
    if (!file)
        return -1;
    /* cpu  user nice system idle iowait irq softirq steal */
    const int read = fscanf(file, "cpu %*u %*u %*u %*u %*u %*u %*u %llu", &ticks);
    const long hertz = sysconf(_SC_CLK_TCK);
    fclose(file);
    return read == 1 && hertz > 0 ? (double)ticks * 1000 / (double)hertz : -1;
}

int pen_host_processors(void)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (int)online : 1;
}
