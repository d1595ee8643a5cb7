/* SPDX-License-Identifier: MIT */
#include "cmd/files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/builtin.h"

static bool fail_errno(struct pen_status *st, enum pen_code code, const char *doing,
                       const char *path)
{
    return pen_fail(st, code, "cannot %s %s: %s", doing, path, strerror(errno));
}

/* Reads a descriptor to its end. */
static bool read_all(int fd, const char *label, size_t max_bytes, struct pen_buf *out,
                     struct pen_status *st)
{
    enum { CHUNK = 1 << 16 };
    char chunk[CHUNK];
    for (;;) {
        ssize_t got = read(fd, chunk, sizeof chunk);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return fail_errno(st, PEN_IO, "read", label);
        if (got == 0)
            break;
        if (max_bytes && out->bytes + (size_t)got > max_bytes)
            return pen_fail(st, PEN_TOO_LARGE, "larger than the limit of %zu bytes", max_bytes);
        if (!pen_buf_add(out, chunk, (size_t)got))
            return pen_fail(st, PEN_NO_MEMORY, "out of memory reading %s", label);
    }
    if (!pen_buf_add(out, "", 0))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory reading %s", label);
    return true;
}

bool pen_file_read(const char *path, size_t max_bytes, struct pen_buf *out, struct pen_status *st)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return pen_fail(st, errno == ENOENT || errno == ENOTDIR ? PEN_NOT_FOUND : PEN_IO,
                        "cannot open: %s", strerror(errno));
    bool ok = read_all(fd, path, max_bytes, out, st);
    close(fd);
    return ok;
}

static bool fail_builtin(const char *name, struct pen_status *st)
{
    const char *near = pen_builtin_nearest(name);
    if (near)
        return pen_fail(st, PEN_NOT_FOUND, "no built-in scene \"%s\", nearest is \"%s\"", name,
                        near);
    return pen_fail(st, PEN_NOT_FOUND, "no built-in scene \"%s\", see penumbra scenes", name);
}

bool pen_name_ends_in(const char *name, const char *ending)
{
    size_t length = strlen(name), tail = strlen(ending);
    return length > tail && strcasecmp(name + length - tail, ending) == 0;
}

static bool read_builtin(struct pen_source *source, const char *name, struct pen_status *st)
{
    size_t bytes;
    const char *text = pen_builtin_find(name, &bytes);
    if (!text)
        return fail_builtin(name, st);
    if (!pen_buf_add(&source->text, text, bytes))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    return true;
}

/* The name's ending decides; without a known ending, the text. */
static bool is_xml(const char *name, const struct pen_buf *text)
{
    return pen_name_ends_in(name, ".xml") ||
           (!pen_name_ends_in(name, ".json") &&
            pen_text_is_xml((const char *)text->data, text->bytes));
}

bool pen_source_read(struct pen_source *source, const char *name, size_t max_bytes,
                     struct pen_status *st)
{
    static const char builtin[] = "builtin:";
    *source = (struct pen_source){.label = name};
    if (strncmp(name, builtin, sizeof builtin - 1) == 0)
        return read_builtin(source, name + sizeof builtin - 1, st);
    if (strcmp(name, "-") == 0) {
        source->label = "standard input";
        if (!read_all(STDIN_FILENO, source->label, max_bytes, &source->text, st))
            return false;
    } else if (!pen_file_read(name, max_bytes, &source->text, st)) {
        return false;
    }
    source->xml = is_xml(name, &source->text);
    return true;
}

/* Fails for formats of models that are not read, whose bytes would be refused as JSON. */
static bool is_readable(const char *name, struct pen_status *st)
{
    static const char *const others[] = {".fbx", ".gltf", ".glb",   ".dae", ".3ds", ".3mf",
                                         ".off", ".usd",  ".blend", ".stp", ".step"};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && i < sizeof others / sizeof *others; i++)
        if (strcasecmp(dot, others[i]) == 0)
            return pen_fail(
                st, PEN_INVALID,
                "models are read as PLY, OBJ and STL, not as %s; save it as one of these",
                others[i]);
    return true;
}

bool pen_source_read_scene(struct pen_source *source, const char *name,
                           const struct pen_model_options *options, struct pen_status *st)
{
    const struct pen_limits limits = pen_limits_default();
    const bool is_file = strcmp(name, "-") != 0 && strncmp(name, "builtin:", 8) != 0;
    const bool is_model = is_file && pen_model_kind_of_name(name) != PEN_MODEL_NONE;
    struct pen_models models;
    *source = (struct pen_source){.label = name};
    if (is_file && !is_readable(name, st))
        return false;
    if (!is_model && !pen_source_read(source, name, limits.body_bytes, st))
        return false;
    if (!pen_model_files_open(is_file ? name : NULL, options, &models, st))
        return false;
    source->models = models;
    const char *slash = strrchr(name, '/');
    return !is_model ||
           pen_models_scene(&source->models, slash ? slash + 1 : name,
                            options && options->up ? options->up[0] : '\0', &source->text, st);
}

bool pen_source_scene(struct pen_source *source, const struct pen_limits *limits,
                      struct pen_arena *arena, struct pen_scene_desc *desc,
                      struct pen_errors *errors)
{
    struct pen_limits allowed = *limits;
    const char *text = source->text.data ? (const char *)source->text.data : "";
    allowed.models = source->models.fetch ? &source->models : NULL;
    return pen_document_load(text, source->text.bytes, source->xml, &allowed, arena, desc, errors);
}

json_t *pen_source_json(struct pen_source *source, const struct pen_limits *limits,
                        struct pen_errors *errors)
{
    struct pen_limits allowed = *limits;
    struct pen_document document = {0};
    struct pen_scene_desc desc;
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    const char *text = source->text.data ? (const char *)source->text.data : "";
    allowed.models = source->models.fetch ? &source->models : NULL;
    bool parsed = arena != NULL || pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    parsed =
        parsed && pen_document_parse(text, source->text.bytes, source->xml, limits, &document, &st);
    if (!parsed)
        pen_errors_add(errors, &st);
    bool ok = parsed && pen_document_read(&document, &allowed, arena, &desc, errors);
    json_t *json = ok ? json_incref(document.json) : NULL;
    pen_document_release(&document);
    pen_arena_free(arena);
    return json;
}

void pen_source_locate(const struct pen_source *source, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    if (source->xml && st->at[0])
        pen_text_locate((const char *)source->text.data, source->text.bytes, &limits, st);
}

void pen_source_release(struct pen_source *source)
{
    pen_model_files_release(&source->models);
    pen_buf_release(&source->text);
}

static bool write_all(int fd, const char *data, size_t bytes)
{
    while (bytes > 0) {
        ssize_t put = write(fd, data, bytes);
        if (put < 0 && errno == EINTR)
            continue;
        if (put < 0)
            return false;
        data += put;
        bytes -= (size_t)put;
    }
    return true;
}

/* Writes to a file that cannot be replaced: a pipe, a terminal, a device. */
static bool write_directly(const char *path, const void *data, size_t bytes, struct pen_status *st)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return fail_errno(st, PEN_IO, "open", path);
    bool ok = write_all(fd, data, bytes);
    if (!ok)
        fail_errno(st, PEN_IO, "write", path);
    if (close(fd) != 0 && ok)
        ok = fail_errno(st, PEN_IO, "write", path);
    return ok;
}

/* Flushes the folder of `path`, which puts the rename on disk. Errors are ignored, because some
 * file systems cannot flush a folder. */
static void flush_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    int fd = folder ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    free(folder);
}

/* Creates a new file with that mode; `name` ends in XXXXXX, which is replaced. */
static int create_beside(char *name, mode_t mode)
{
    int fd = mkostemp(name, O_CLOEXEC);
    if (fd >= 0)
        fchmod(fd, mode);
    return fd;
}

/* Creates the file that replaces `old` (NULL: there is none). If the owner cannot be kept, it is
 * the user, because only root can give files away. */
static int create_like(char *name, const struct stat *old)
{
    mode_t mask = umask(0);
    umask(mask);
    int fd = create_beside(name, old ? old->st_mode & 07777 : 0666 & ~mask);
    if (fd >= 0 && old && geteuid() == 0 && fchown(fd, old->st_uid, old->st_gid) != 0)
        errno = 0;
    return fd;
}

/* `durable`: afterwards the contents and the rename are on the disk. */
static bool replace(const char *path, const struct stat *old, const void *data, size_t bytes,
                    bool durable, struct pen_status *st)
{
    char *name = NULL;
    if (asprintf(&name, "%s.XXXXXX", path) < 0)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    int fd = create_like(name, old);
    bool ok = fd >= 0 && write_all(fd, data, bytes) && (!durable || fsync(fd) == 0);
    int cause = errno;
    if (fd >= 0 && close(fd) != 0 && ok) {
        ok = false;
        cause = errno;
    }
    if (ok && rename(name, path) != 0) {
        ok = false;
        cause = errno;
    }
    if (!ok && fd >= 0)
        unlink(name);
    free(name);
    if (ok && durable)
        flush_folder(path);
    errno = cause;
    return ok || fail_errno(st, PEN_IO, "write", path);
}

static bool fail_folder(const char *path, struct pen_status *st)
{
    return pen_fail(st, PEN_IO, "cannot write %s: it is a folder", path);
}

static bool check_beside(const char *path, struct pen_status *st)
{
    char *name = NULL;
    if (asprintf(&name, "%s.XXXXXX", path) < 0)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    int fd = create_beside(name, 0600);
    int cause = errno;
    if (fd >= 0) {
        close(fd);
        unlink(name);
    }
    free(name);
    errno = cause;
    return fd >= 0 || fail_errno(st, PEN_IO, "write", path);
}

bool pen_file_check(const char *path, struct pen_status *st)
{
    struct stat info;
    if (strcmp(path, "-") == 0)
        return true;
    if (stat(path, &info) != 0 || S_ISREG(info.st_mode))
        return check_beside(path, st);
    if (S_ISDIR(info.st_mode))
        return fail_folder(path, st);
    return access(path, W_OK) == 0 || fail_errno(st, PEN_IO, "write", path);
}

static bool write_file(const char *path, const void *data, size_t bytes, bool durable,
                       struct pen_status *st)
{
    struct stat info;
    if (strcmp(path, "-") == 0)
        return write_all(STDOUT_FILENO, data, bytes) || fail_errno(st, PEN_IO, "write", "-");
    if (stat(path, &info) == 0) {
        if (S_ISDIR(info.st_mode))
            return fail_folder(path, st);
        if (!S_ISREG(info.st_mode))
            return write_directly(path, data, bytes, st);
        char *target = realpath(path, NULL); /* replaces the target of a link, not the link */
        bool ok = replace(target ? target : path, &info, data, bytes, durable, st);
        free(target);
        return ok;
    }
    return replace(path, NULL, data, bytes, durable, st);
}

bool pen_file_write(const char *path, const void *data, size_t bytes, struct pen_status *st)
{
    return write_file(path, data, bytes, false, st);
}

bool pen_file_write_durable(const char *path, const void *data, size_t bytes, struct pen_status *st)
{
    return write_file(path, data, bytes, true, st);
}
