/* SPDX-License-Identifier: MIT */
/* The memory and the time of reading models: allocations that fail, the peak of honest and of
 * hostile files, and the slowest files that we know. */
#include <dlfcn.h>
#include <malloc.h>
#include <math.h>

#include "base/clock.h"
#include "support/models.h"
#include "support/random.h"

/* This program's malloc: it fails on request and, in a build without sanitizers, whose runtime
 * allocates before it can count, it counts bytes. */
static size_t live, peak;
static long fail_after = -1; /* allocations; negative: none fails */
static bool refused;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
static void count(size_t more)
{
    (void)more;
}
#define malloc_usable_size(memory) (0 * (size_t)(memory))
#else
static void count(size_t more)
{
    live += more;
    peak = live > peak ? live : peak;
}

typedef void (*release)(void *);

void free(void *memory)
{
    static release system_free;
    if (!system_free) {
        void *found = dlsym(RTLD_NEXT, "free");
        memcpy(&system_free, &found, sizeof found);
    }
    if (memory)
        live -= malloc_usable_size(memory);
    system_free(memory);
}
#endif

typedef void *(*reallocate)(void *, size_t);

#define UNWATCHED __attribute__((no_sanitize("address"), no_sanitize("thread")))

UNWATCHED static void *allocate(void *old, size_t bytes)
{
    static reallocate system_realloc;
    if (!system_realloc) {
        void *found = dlsym(RTLD_NEXT, "realloc");
        memcpy(&system_realloc, &found, sizeof found);
    }
    if (fail_after >= 0 && fail_after-- == 0) {
        fail_after = 0;
        refused = true;
        return NULL;
    }
    const size_t before = old ? malloc_usable_size(old) : 0;
    void *memory = system_realloc(old, bytes);
    if (memory)
        count(malloc_usable_size(memory) - before);
    return memory;
}

UNWATCHED void *malloc(size_t bytes)
{
    return allocate(NULL, bytes);
}

UNWATCHED void *realloc(void *old, size_t bytes)
{
    return allocate(old, bytes);
}

static const char obj[] = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv .2 .3 0\nv 0 0 1\nvn 0 0 1\n"
                          "usemtl a\nf 1//1 2//1 3//1 4//1\nusemtl b\nf -1 1 2\n";
static const char ply[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
    "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float "
    "nz\nelement face 1\nproperty list int int vertex_index\nend_header\n0 0 0 "
    "0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n.2 .3 0 0 0 1\n4 0 1 2 3\n";
static const char stl[] =
    "solid\nfacet\nouter loop\nvertex 100 0 0\nvertex 101 0 0\nvertex 100 1 0\n"
    "endloop\nendfacet\nendsolid\n";

START_TEST(test_model_memory__any_failed_allocation_is_reported_as_such)
{
    static const struct {
        enum pen_model_kind kind;
        const char *text;
    } files[] = {{PEN_MODEL_OBJ, obj}, {PEN_MODEL_PLY, ply}, {PEN_MODEL_STL, stl}};
    char mtl[1000] = "newmtl a\nKd 1 0 0\nnewmtl b\n";
    struct model r = {.mtl = mtl};
    for (int i = 0; i < 70; i++)
        strcat(mtl, "newmtl b\n");
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        long n = 0;
        for (bool again = true; again; n++) {
            refused = false;
            fail_after = n;
            bool ok = model_text(&r, files[i].kind, files[i].text);
            fail_after = -1;
            again = refused;
            ck_assert_msg(ok != refused && (ok || r.st.code == PEN_NO_MEMORY), "file %zu, %ld: %s",
                          i, n, r.st.msg);
        }
        ck_assert_int_gt(n, 6);
    }
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_memory__too_many_materials_are_refused)
{
    enum { COUNT = 100000 };
    char *mtl = malloc(COUNT * 7 + 1);
    struct model r = {.mtl = mtl};
    for (int i = 0; i < COUNT; i++)
        memcpy(mtl + 7 * i, "newmtl\n", 8);
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, obj));
    ck_assert_int_eq(r.st.code, PEN_TOO_LARGE);
    free(mtl);
}
END_TEST

/* Reads `bytes` bytes at `text` and returns the most memory that this took. */
static size_t read_peak(struct pen_errors *notes, struct pen_status *st, enum pen_model_kind kind,
                        const char *text, size_t bytes, bool *ok)
{
    const struct pen_model_file file = {text, bytes, kind, 0, NULL, NULL};
    struct pen_model m;
    const size_t before = peak = live;
    *notes = (struct pen_errors){0};
    *ok = pen_model_read(&file, &m, notes, st);
    pen_model_release(&m);
    ck_assert_uint_eq(live, before);
    return peak - before;
}

/* A file whose text repeats; `faces` of it. */
struct repeated {
    enum pen_model_kind kind;
    const char *head, *line, *end;
    bool honest; /* it must be read */
};

static size_t write_repeated(char *out, size_t bytes, const struct repeated *file)
{
    const size_t head = strlen(file->head), line = strlen(file->line);
    size_t n = head;
    memcpy(out, file->head, head);
    for (; n + line + 200 < bytes; n += line)
        memcpy(out + n, file->line, line);
    strcpy(out + n, file->end);
    return n + strlen(file->end);
}

#define CORNERS "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 0 0\nv 3 0 0\n"
#define FACET                                                                                      \
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"          \
    "endfacet\n"

static const struct repeated worst[] = {
    {PEN_MODEL_OBJ, CORNERS, "f 1 2 3\n", "", true},
    {PEN_MODEL_OBJ, CORNERS, "f 1 2 4 3\n", "", false},
    {PEN_MODEL_OBJ, CORNERS "f 1 2 3\n", "f 1 2 5\n", "", true},
    {PEN_MODEL_OBJ, CORNERS, "f 1 2 5 6\n", "f 1 2 3\n", false},
    {PEN_MODEL_OBJ, CORNERS "v 1e-30 1e-30 1e-30\nv 1e10 1e10 1e10\nv 3 3 3\n", "f -1 -2 -3\n", "",
     false},
    {PEN_MODEL_OBJ, CORNERS "f 1 2 3\n", "\n", "", true},
    {PEN_MODEL_OBJ, CORNERS "f 1 2 3\n", "x\\\n", "", true},
    {PEN_MODEL_OBJ, "", "v 0 0 1\n", "v 1 1 0\nv 2 0 0\nf -1 -2 -3\n", true},
    {PEN_MODEL_OBJ, CORNERS, "v 1e-44 3e37 7e-39\n", "f 1 2 3\n", true},
    {PEN_MODEL_OBJ, CORNERS, "v 16777217 16777219 3\n", "f 1 2 3\n", true},
    {PEN_MODEL_OBJ, CORNERS "f 1 2 3\n", "usemtl none\nf 1 2 3\n", "", true},
    {PEN_MODEL_OBJ, CORNERS "f 1 2 3", " 1 2", "\n", false},
    {PEN_MODEL_STL, "solid\n", FACET, "endsolid\n", true},
    {PEN_MODEL_PLY, "ply\nformat ascii 1.0\n", "a\n", "end_header\n", false},
    {PEN_MODEL_PLY, "ply\nformat ascii 1.0\n", "comment\n", "element x 1\nend_header\n", false},
};

/* Polygons of many corners, which take the square of their number in steps. */
static size_t write_stars(char *out, size_t bytes, uint32_t count)
{
    size_t n = 0;
    for (uint32_t i = 0; i < count; i++)
        n += (size_t)sprintf(out + n, "v %.9g %.9g 0\n",
                             (double)i / count * (i < count / 2 ? 1 : -2) + (i < count / 2 ? 0 : 2),
                             0.9 * (i % 2) + (i < count / 2 ? 0 : 1));
    while (n + 8 * count < bytes) {
        n += (size_t)sprintf(out + n, "f");
        for (uint32_t i = 0; i < count; i++)
            n += (size_t)sprintf(out + n, " %u", i + 1);
        n += (size_t)sprintf(out + n, "\n");
    }
    return n;
}

/* Binary STL whose vertices all differ. */
static size_t write_stl(char *out, size_t bytes)
{
    struct random random = random_begin(7);
    const uint32_t count = (uint32_t)((bytes - 84) / 50);
    memset(out, 0, bytes);
    for (int i = 0; i < 4; i++)
        out[80 + i] = (char)(count >> (8 * i));
    for (uint32_t t = 0; t < count; t++)
        for (size_t i = 0; i < 9; i++) {
            float x = (float)random_unit(&random);
            memcpy(out + 84 + 50 * (size_t)t + 12 + 4 * i, &x, sizeof x);
        }
    return 84 + 50 * (size_t)count;
}

static void check_read(const char *text, size_t bytes, enum pen_model_kind kind, int honest, int i)
{
    struct pen_errors notes;
    struct pen_status st = {0};
    bool ok;
    const int64_t from = pen_clock_cpu_ns();
    const size_t most = read_peak(&notes, &st, kind, text, bytes, &ok);
    const double seconds = (double)(pen_clock_cpu_ns() - from) * 1e-9;
    /* An array may be longer by what the allocator rounds up, and notes are short. */
    ck_assert_msg(most <= 4 * bytes + (1 << 20) + 4096, "file %d: %zu bytes for %zu", i, most,
                  bytes);
    ck_assert_msg(ok || !honest, "file %d: %s", i, st.msg);
    ck_assert_msg(!suite_timed() || seconds <= 1 * (double)bytes / 1e7, "file %d: %.3f s", i,
                  seconds);
}

START_TEST(test_model_memory__stays_below_four_times_the_file_and_a_mebibyte)
{
    const size_t bytes = suite_timed() ? 10000000 : 1000000;
    char *text = malloc(bytes + 100000);
    const int kinds = (int)(sizeof worst / sizeof worst[0]);
    for (int i = 0; i < kinds; i++)
        check_read(text, write_repeated(text, bytes, &worst[i]), worst[i].kind, worst[i].honest, i);
    for (int i = 0; i < 3; i++)
        check_read(text, write_stars(text, bytes, (uint32_t[]){300, 1000, 4000}[i]), PEN_MODEL_OBJ,
                   false, kinds + i);
    check_read(text, write_stl(text, bytes), PEN_MODEL_STL, true, kinds + 3);
    free(text);
}
END_TEST

PEN_SUITE("io/model_memory", test_model_memory__any_failed_allocation_is_reported_as_such,
          test_model_memory__too_many_materials_are_refused,
          test_model_memory__stays_below_four_times_the_file_and_a_mebibyte)
