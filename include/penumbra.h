/* SPDX-License-Identifier: MIT */
/* libpenumbra: a ray tracer to embed. A scene goes in as JSON or XML text; a picture and statistics
 * come out. README.md ("Embedding it") shows how to compile and link.
 *
 *     struct penumbra_errors *errors = NULL;
 *     struct penumbra_scene *scene = penumbra_scene_builtin("room", &errors);
 *     struct penumbra_image *image = scene ? penumbra_render(scene, NULL, NULL, &errors) : NULL;
 *     size_t bytes;
 *     void *png = image ? penumbra_image_encode(image, "png", &bytes, &errors) : NULL;
 *
 * Errors: a function that can fail returns NULL or 0 and, if its argument `errors` is not NULL,
 * stores a new object in *errors, which the caller frees with penumbra_errors_free. On success
 * *errors is left as it was. A failed call changes nothing else: a scene stays usable. No other
 * argument may be NULL unless its function allows it.
 *
 * Binary compatibility: scenes, images and errors are opaque. The other structures begin with
 * `size`, which the caller sets to sizeof; a later version appends members and neither reads nor
 * writes beyond the size it was given. Functions are only ever added while the SONAME stays.
 *
 * Threads: calls on different objects may run at the same time in any number of threads. Calls on
 * one scene must not overlap. An image and an error list do not change, so any number of threads
 * may read one.
 *
 * The process around it: the library installs no signal handlers and changes no signal mask; render
 * threads are made with the mask of the thread that calls penumbra_render. It does not call
 * setlocale, and no locale changes what it reads or writes. It keeps the calling thread's locale
 * and floating-point environment, and whatever these are, the picture is the same. It prints
 * nothing and never ends the process. It opens no files but some of /proc and /sys and a source
 * of random numbers (for hashing of keys), and reads one environment variable: PENUMBRA_ISA=base,
 * avx2 or avx512 takes these instructions, if the processor has them, for the same picture.
 *
 * Pictures: the same scene and settings give the same bits on every machine, for any number of
 * threads, and from the programs `penumbra` and `penumbrad`. */
#ifndef PENUMBRA_H
#define PENUMBRA_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define PENUMBRA_API __attribute__((visibility("default")))
#else
#define PENUMBRA_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

struct penumbra_scene;  /* a scene and its render settings */
struct penumbra_image;  /* a rendered picture and its statistics */
struct penumbra_errors; /* one or more errors */

/* The version of this header: 10000 * major + 100 * minor + patch. */
#define PENUMBRA_VERSION_NUMBER 100

/* The version of the library that is linked, for example "0.1.0".
 * Owns: the text is constant. */
PENUMBRA_API const char *penumbra_version(void);

/* ---- Scenes ---- */

/* Reads a scene from text in memory: XML if it begins with `<`, else JSON. It checks the whole
 * text; limits are those of `penumbra render`.
 * Owns: free the scene with penumbra_scene_free. Nothing of `text` is kept.
 * Fails: NULL; every error has its place, see struct penumbra_error. */
PENUMBRA_API struct penumbra_scene *penumbra_scene_load(const char *text, size_t bytes,
                                                        struct penumbra_errors **errors);

/* Makes a scene that comes with the library.
 * Owns: free with penumbra_scene_free. Fails: NULL; "not-found" if there is none of that name. */
PENUMBRA_API struct penumbra_scene *penumbra_scene_builtin(const char *name,
                                                           struct penumbra_errors **errors);

/* The name of built-in scene number `index`, from 0; NULL behind the last.
 * Owns: the text is constant. */
PENUMBRA_API const char *penumbra_builtin_name(size_t index);

/* Frees a scene. NULL is allowed. Images rendered from it stay valid. */
PENUMBRA_API void penumbra_scene_free(struct penumbra_scene *scene);

/* The name of view number `index`, from 0; NULL behind the last. A scene has at least one view; the
 * first is what penumbra_render takes by default. Owns: the scene. */
PENUMBRA_API const char *penumbra_scene_view(const struct penumbra_scene *scene, size_t index);

/* Changes one render setting, as `penumbra render --set KEY=VALUE` does: "width=640",
 * "accelerator=median". penumbra-scene(5) lists the settings.
 * Fails: 0; "usage" or "unsupported"; the message names the key. Returns 1 on success. */
PENUMBRA_API int penumbra_scene_set(struct penumbra_scene *scene, const char *assignment,
                                    struct penumbra_errors **errors);

/* All render settings as a JSON object, like `render` in a scene document.
 * Owns: free the text with penumbra_free. Fails: NULL; "no-memory". */
PENUMBRA_API char *penumbra_scene_settings(const struct penumbra_scene *scene,
                                           struct penumbra_errors **errors);

/* ---- Rendering ---- */

/* What rendering one view takes at most, from counts alone: nothing is built or traced. */
struct penumbra_estimate {
    size_t size;          /* set by the caller: sizeof(struct penumbra_estimate) */
    int width, height;    /* pixels */
    uint64_t primitives;  /* those in groups included */
    double rays;          /* upper bound of primary rays and of the shadow rays of what these hit */
    int secondary;        /* 1: reflected or transmitted rays may come on top; settings max_depth
                           * and min_contribution limit them */
    uint64_t image_bytes; /* of the image, exactly */
    uint64_t scene_bytes; /* upper bound of what the scene and its acceleration structure take */
};

/* Fills *estimate. Returns 1. Fails: 0; "too-large" if the settings go beyond the limits on pixels
 * or rays, "usage" if `size` is wrong. */
PENUMBRA_API int penumbra_scene_estimate(const struct penumbra_scene *scene,
                                         struct penumbra_estimate *estimate,
                                         struct penumbra_errors **errors);

/* How to render. A zero in any member but `size` means the default.
 * Threads: `progress` and `cancel` are called from render threads, never from the thread that calls
 * penumbra_render, and one call of either at a time. They must return (no longjmp, no C++
 * exception), and must not call functions of this library on the scene that is being rendered. */
struct penumbra_render_options {
    size_t size; /* set by the caller: sizeof(struct penumbra_render_options) */
    /* Render threads, at most 1024; 0: one per processor. The setting `threads` may lower it. */
    int threads;
    /* Called after each tile with the fraction that is done, above 0 and up to 1. */
    void (*progress)(void *user, double done);
    /* Called about every 10 ms, and after each tile; returns nonzero to stop the rendering. Not
     * called while the acceleration structure is built. */
    int (*cancel)(void *user);
    void *user;
};

/* Renders one view of a scene; returns when it is done. The first call builds the acceleration
 * structure, and later ones use it again unless the setting `accelerator` has changed.
 * `view` is the name of a view, or NULL for the first; `options` may be NULL.
 * Owns: free the image with penumbra_image_free; it keeps nothing of the scene.
 * Fails: NULL; "not-found" (no such view), "invalid-scene", "too-large", "cancelled", "no-memory",
 * "usage" (wrong options). */
PENUMBRA_API struct penumbra_image *penumbra_render(struct penumbra_scene *scene, const char *view,
                                                    const struct penumbra_render_options *options,
                                                    struct penumbra_errors **errors);

/* ---- Images ---- */

/* The pixels: *height rows of *width * 3 floats, the top row first, without gaps. They are linear
 * RGB, 1 is display white, larger values are possible. width and height may be NULL.
 * Owns: the image. */
PENUMBRA_API const float *penumbra_image_pixels(const struct penumbra_image *image, int *width,
                                                int *height);

/* The image as a file in memory, of *bytes bytes: "png" (8 bits), "png16" or "pfm". A PNG has the
 * transfer function of the setting `transfer`; a PFM holds the pixels as they are.
 * Owns: free with penumbra_free. Fails: NULL; "usage" (unknown format), "no-memory". */
PENUMBRA_API void *penumbra_image_encode(const struct penumbra_image *image, const char *format,
                                         size_t *bytes, struct penumbra_errors **errors);

/* Times, counts of rays and more as a JSON object: what `penumbra render --stats` writes.
 * Owns: the image. */
PENUMBRA_API const char *penumbra_image_statistics(const struct penumbra_image *image);

/* Frees an image. NULL is allowed. */
PENUMBRA_API void penumbra_image_free(struct penumbra_image *image);

/* ---- Errors ---- */

/* One error. Owns: the texts belong to the list. */
struct penumbra_error {
    size_t size;         /* set by the caller: sizeof(struct penumbra_error) */
    const char *code;    /* kind: "syntax", "invalid-scene", "not-found", … as in the HTTP API */
    const char *message; /* one sentence without a full stop, UTF-8 */
    const char *pointer; /* JSON Pointer into a JSON scene, or "" */
    int line, column;    /* place in XML or malformed JSON, from 1; 0 where there is none */
    const char *text;    /* place and message in one line */
};

/* The number of errors found, of which the first 20 are kept; 0 for NULL. */
PENUMBRA_API size_t penumbra_errors_count(const struct penumbra_errors *errors);

/* Fills *error with error number `index`, from 0. Returns 1, or 0 if there is none, or it was not
 * kept, or `size` is wrong, or `errors` is NULL. */
PENUMBRA_API int penumbra_errors_get(const struct penumbra_errors *errors, size_t index,
                                     struct penumbra_error *error);

/* Frees a list of errors. NULL is allowed. */
PENUMBRA_API void penumbra_errors_free(struct penumbra_errors *errors);

/* ---- Memory ---- */

/* Frees what penumbra_scene_settings and penumbra_image_encode return. NULL is allowed. */
PENUMBRA_API void penumbra_free(void *memory);

#ifdef __cplusplus
}
#endif

#endif
