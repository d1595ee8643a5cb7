/* SPDX-License-Identifier: MIT */
/* What penumbra.h promises about the process around the library: its locale, signals, output. */
#include <dirent.h>
#include <fcntl.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "penumbra.h"
#include "support/suite.h"

static char folder[] = "/tmp/penumbra-locale-XXXXXX";

static void remove_folder(void)
{
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    ck_assert_int_eq(system(command), 0);
}

static void write_file(const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fputs(text, file);
    ck_assert_int_eq(fclose(file), 0);
}

/* The ASCII charmap, so that no package with charmaps is needed. */
static void write_charmap(void)
{
    char text[8192];
    int used = snprintf(text, sizeof text,
                        "<code_set_name> ASCII\n<comment_char> %%\n<escape_char> /\nCHARMAP\n");
    for (int i = 0; i < 128; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, "<U%04X> /x%02x c\n", (unsigned)i,
                         (unsigned)i);
    snprintf(text + used, sizeof text - (size_t)used, "END CHARMAP\n");
    write_file("ascii", text);
}

/* Makes a locale named "comma" whose decimal point is a comma; setlocale and newlocale find it. */
static void make_comma_locale(void)
{
    char command[256];
    ck_assert_ptr_nonnull(mkdtemp(folder));
    write_charmap();
    write_file("source", "LC_NUMERIC\ndecimal_point \"<U002C>\"\nthousands_sep \"<U002E>\"\n"
                         "grouping 3;3\nEND LC_NUMERIC\n");
    snprintf(command, sizeof command,
             "cd %s && localedef --no-archive -c -f ./ascii -i ./source ./comma >/dev/null 2>&1",
             folder);
    int warned = system(command); /* of the categories that the source does not have */
    (void)warned;
    setenv("LOCPATH", folder, 1);
}

static void check_decimal_point(const char *wanted)
{
    char text[16];
    snprintf(text, sizeof text, "%g", 1.5);
    ck_assert_str_eq(text, wanted);
}

/* What the library returns for one scene. */
struct results {
    char *settings;
    size_t bytes;
    void *pfm;
    char *statistics, *error;
};

static const char json_scene[] =
    "{\"format\": \"penumbra-scene/1\", \"ambient\": [0.25, 0.5, 0.125],"
    " \"camera\": {\"position\": [0.5, 0, 9.75], \"look_at\": [0, 0, 0], \"fov_degrees\": 37.5},"
    " \"materials\": {\"m\": {\"ka\": 0.75, \"kd\": 5e-1, \"emission\": [0.1, 0.2, 0.3]}},"
    " \"lights\": [{\"type\": \"point\", \"position\": [1.5, 2.5, 3.5], \"intensity\": [1, 1, 1]}],"
    " \"objects\": [{\"type\": \"sphere\", \"center\": [0.25, -0.5, 0], \"radius\": 1.75,"
    " \"material\": \"m\"}],"
    " \"render\": {\"width\": 16, \"height\": 12, \"min_contribution\": 0.0625}}";

static const char xml_scene[] =
    "<scene background-color=\"12.5 25.5 51.25\"><ambient-light color=\"127.5 63.75 31.5\"/>"
    "<camera position=\"0.5 0 9.75\" look-at=\"0 0 0\" fov-degrees=\"37.5\" image=\"16 12\"/>"
    "<geometries><sphere center=\"0.25 -0.5 0\" radius=\"1.75\" ka=\"0.75\"/></geometries></scene>";

/* Renders a scene; its error is that of `bad`, which has a fraction out of range. */
static struct results results_of(const char *text, const char *bad)
{
    struct results out = {0};
    struct penumbra_errors *errors = NULL;
    struct penumbra_error error = {.size = sizeof error};
    struct penumbra_scene *scene = penumbra_scene_load(text, strlen(text), &errors);
    ck_assert_msg(scene != NULL, "%s",
                  penumbra_errors_get(errors, 0, &error) ? error.text : "no error");
    ck_assert(penumbra_scene_set(scene, "min_contribution=0.03125", NULL));
    out.settings = penumbra_scene_settings(scene, NULL);
    struct penumbra_image *image = penumbra_render(scene, NULL, NULL, NULL);
    out.pfm = penumbra_image_encode(image, "pfm", &out.bytes, NULL);
    out.statistics = strdup(penumbra_image_statistics(image));
    penumbra_image_free(image);
    penumbra_scene_free(scene);
    ck_assert_ptr_null(penumbra_scene_load(bad, strlen(bad), &errors));
    ck_assert_int_eq(penumbra_errors_get(errors, 0, &error), 1);
    out.error = strdup(error.text);
    penumbra_errors_free(errors);
    return out;
}

static void release(struct results *results)
{
    penumbra_free(results->settings);
    penumbra_free(results->pfm);
    free(results->statistics);
    free(results->error);
}

/* Whether a comma stands between two digits. The statistics have no lists of numbers. */
static bool has_decimal_comma(const char *text)
{
    for (const char *comma = strchr(text, ','); comma; comma = strchr(comma + 1, ','))
        if (comma > text && comma[-1] >= '0' && comma[-1] <= '9' && comma[1] >= '0' &&
            comma[1] <= '9')
            return true;
    return false;
}

static const struct {
    const char *text, *bad, *found;
} scenes[] = {
    {json_scene,
     "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
     " \"look_at\": [0, 0, 0], \"fov_degrees\": 180.5}}",
     "180.5"},
    {xml_scene,
     "<scene><geometries><sphere center=\"0 0 0\" radius=\"-1.75\"/></geometries></scene>",
     "-1.75"},
};

static void check_locale_changes_nothing(void (*change)(void), void (*check_kept)(void))
{
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) {
        setlocale(LC_ALL, "C");
        uselocale(LC_GLOBAL_LOCALE);
        struct results plain = results_of(scenes[i].text, scenes[i].bad);
        change();
        check_decimal_point("1,5");
        struct results comma = results_of(scenes[i].text, scenes[i].bad);
        check_kept();
        check_decimal_point("1,5");
        ck_assert_str_eq(plain.settings, comma.settings);
        ck_assert_ptr_nonnull(strstr(comma.settings, "0.03125"));
        ck_assert_uint_eq(plain.bytes, comma.bytes);
        ck_assert_mem_eq(plain.pfm, comma.pfm, comma.bytes);
        ck_assert_str_eq(plain.error, comma.error);
        ck_assert_ptr_nonnull(strstr(comma.error, scenes[i].found));
        ck_assert_ptr_nonnull(strchr(comma.statistics, '.'));
        ck_assert_msg(!has_decimal_comma(comma.statistics), "%s", comma.statistics);
        release(&plain);
        release(&comma);
    }
}

static void set_global(void)
{
    ck_assert_ptr_nonnull(setlocale(LC_ALL, "comma"));
}

static void global_is_kept(void)
{
    ck_assert_str_eq(setlocale(LC_ALL, NULL), "comma");
    ck_assert(uselocale((locale_t)0) == LC_GLOBAL_LOCALE);
}

static locale_t own;

static void set_own(void)
{
    ck_assert(uselocale(own) != (locale_t)0);
}

static void own_is_kept(void)
{
    ck_assert(uselocale((locale_t)0) == own);
}

START_TEST(test_process__locale_changes_nothing_and_is_kept)
{
    make_comma_locale();
    check_locale_changes_nothing(set_global, global_is_kept);
    set_global();
    own = duplocale(LC_GLOBAL_LOCALE); /* glibc's newlocale leaks memory if LOCPATH is set */
    ck_assert(own != (locale_t)0);
    check_locale_changes_nothing(set_own, own_is_kept);
    uselocale(LC_GLOBAL_LOCALE);
    freelocale(own);
    remove_folder();
}
END_TEST

/* The programs take no locale from their environment. With LOCPATH set, glibc leaks memory in a
 * call of newlocale by a library that libcurl loads: no such reports. */
START_TEST(test_process__programs_write_decimal_points_in_any_locale)
{
    const char *program = getenv("PENUMBRA_PROGRAM");
    char command[512], line[1024];
    make_comma_locale();
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 LC_ALL=comma %s bench builtin:spheres --set width=8 "
             "--set height=6 --repeats 1"
             " --warmup 0 --matrix threads=1,2 -q --csv -",
             program ? program : "build/penumbra");
    FILE *pipe = popen(command, "r");
    int columns = 0, rows = 0;
    for (; fgets(line, sizeof line, pipe); rows++) {
        int commas = 0;
        for (const char *c = line; *c; c++)
            commas += *c == ',';
        columns = rows == 0 ? commas : columns;
        ck_assert_int_eq(commas, columns);
    }
    ck_assert_int_eq(pclose(pipe), 0);
    ck_assert_int_eq(rows, 3);
    ck_assert_int_gt(columns, 10);
    remove_folder();
}
END_TEST

static void render_small(void (*progress)(void *user, double done), void *user)
{
    struct penumbra_render_options options = {
        .size = sizeof options, .threads = 2, .progress = progress, .user = user};
    struct penumbra_scene *scene = penumbra_scene_load(json_scene, strlen(json_scene), NULL);
    struct penumbra_image *image = penumbra_render(scene, NULL, &options, NULL);
    ck_assert_ptr_nonnull(image);
    penumbra_image_free(image);
    penumbra_scene_free(scene);
}

struct seen {
    pthread_t caller;
    bool other_thread, blocked;
    int calls;
};

static void note_mask(void *user, double done)
{
    struct seen *seen = user;
    sigset_t mask;
    (void)done;
    pthread_sigmask(SIG_SETMASK, NULL, &mask);
    seen->blocked = sigismember(&mask, SIGUSR1) && !sigismember(&mask, SIGUSR2);
    seen->other_thread = !pthread_equal(pthread_self(), seen->caller);
    seen->calls++;
}

static void read_handlers(struct sigaction actions[64])
{
    memset(actions, 0, 64 * sizeof *actions);
    for (int i = 1; i < 64; i++)
        sigaction(i, NULL, &actions[i]);
}

START_TEST(test_process__signals_are_left_alone)
{
    struct sigaction before[64], after[64];
    struct seen seen = {.caller = pthread_self()};
    sigset_t usr1, mask, old;
    sigemptyset(&usr1);
    sigaddset(&usr1, SIGUSR1);
    pthread_sigmask(SIG_BLOCK, &usr1, NULL);
    pthread_sigmask(SIG_SETMASK, NULL, &old);
    read_handlers(before);
    render_small(note_mask, &seen);
    read_handlers(after);
    for (int i = 1; i < 64; i++) {
        ck_assert(before[i].sa_handler == after[i].sa_handler);
        ck_assert_int_eq(before[i].sa_flags, after[i].sa_flags);
    }
    pthread_sigmask(SIG_SETMASK, NULL, &mask);
    for (int i = 1; i < 64; i++)
        ck_assert_int_eq(sigismember(&old, i), sigismember(&mask, i));
    ck_assert_int_gt(seen.calls, 0);
    ck_assert(seen.blocked);
    ck_assert(seen.other_thread);
}
END_TEST

/* The number of this process's open files, or of its threads. */
static int entries(const char *path)
{
    int count = 0;
    DIR *list = opendir(path);
    ck_assert_ptr_nonnull(list);
    while (readdir(list))
        count++;
    closedir(list);
    return count;
}

/* The number of threads once it has stayed the same for 100 ms: the kernel removes a thread's entry
 * a moment after pthread_join has returned. */
static int settled_threads(void)
{
    int threads = entries("/proc/self/task");
    for (int same_ms = 0; same_ms < 100; same_ms++) {
        usleep(1000);
        const int now = entries("/proc/self/task");
        same_ms = now == threads ? same_ms : 0;
        threads = now;
    }
    return threads;
}

/* Waits until there are no more threads than `most`, for 10 s. */
static void wait_for_threads(int most)
{
    for (int tries = 0; tries < 10000 && entries("/proc/self/task") > most; tries++)
        usleep(1000);
    ck_assert_int_le(entries("/proc/self/task"), most);
}

START_TEST(test_process__nothing_is_printed_and_nothing_stays_open)
{
    char path[] = "/tmp/penumbra-output-XXXXXX";
    int file = mkstemp(path), out = dup(1), err = dup(2);
    ck_assert_int_ge(file, 0);
    render_small(NULL, NULL); /* with the first thread a sanitizer may start one of its own */
    fflush(NULL);
    int files = entries("/proc/self/fd"), threads = settled_threads();
    dup2(file, 1);
    dup2(file, 2);
    render_small(NULL, NULL);
    struct penumbra_errors *errors = NULL;
    struct penumbra_scene *scene = penumbra_scene_load("{", 1, &errors);
    penumbra_errors_free(errors);
    fflush(NULL);
    dup2(out, 1);
    dup2(err, 2);
    struct stat info;
    ck_assert_int_eq(fstat(file, &info), 0);
    unlink(path);
    ck_assert_ptr_null(scene);
    ck_assert_int_eq(info.st_size, 0);
    ck_assert_int_eq(entries("/proc/self/fd"), files);
    wait_for_threads(threads);
}
END_TEST

PEN_SUITE("process", test_process__locale_changes_nothing_and_is_kept,
          test_process__programs_write_decimal_points_in_any_locale,
          test_process__signals_are_left_alone,
          test_process__nothing_is_printed_and_nothing_stays_open)
