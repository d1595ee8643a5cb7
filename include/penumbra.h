/* SPDX-License-Identifier: MIT */
/* libpenumbra: a ray tracer to embed. A scene goes in as JSON or XML text; a picture and statistics
 * come out. include/README.md shows how to compile and link.
 *
 *     struct penumbra_errors *errors = NULL;
 *     struct penumbra_scene *scene = penumbra_scene_builtin("room", &errors);
 *     struct penumbra_image *image = scene ? penumbra_render(scene, NULL, NULL, &errors) : NULL;
 *     size_t bytes;
 *     void *png = image ? penumbra_image_encode(image, "png", &bytes, &errors) : NULL;
 *
 * Errors: a function that can fail returns NULL or 0. If its argument `errors` is not NULL, it then
 * stores a new object in *errors, which the caller frees with penumbra_errors_free. A successful
 * call leaves *errors as it was. A failed call changes nothing else, and its scene stays usable. An
 * argument may be NULL only where its function allows it.
 *
 * Binary compatibility: scenes, images and errors are opaque. Every other structure begins with
 * `size`, which the caller sets to its sizeof. A later version appends members, and accesses no
 * byte beyond the given size. While the SONAME stays, functions are only added.
 *
 * Threads: calls on different objects may run at the same time in any number of threads. Calls on
 * one scene must not overlap. Images and error lists do not change, so any number of threads may
 * read one.
 *
 * The process around it: the library installs no signal handlers and changes no signal mask. Render
 * threads have the signal mask of the thread that calls penumbra_render. The library does not call
 * setlocale, prints nothing and never ends the process. The calling thread keeps its locale and its
 * floating-point environment. Neither of them changes the picture, or what the library reads and
 * writes. The library opens no files except some of /proc and /sys, and a source of random numbers
 * to hash keys. The program gives it the bytes of models. It reads one environment variable,
 * PENUMBRA_ISA. Its values base, avx2 and avx512 select instructions, if the processor has them;
 * the picture is the same.
 *
 * Pictures: the same scene and settings give the same bits on every machine and with any number of
 * threads. The programs `penumbra` and `penumbrad` give these bits too. */
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
struct penumbra_file;   /* a file of which the program gives the bytes */

/* The version of this header: 10000 * major + 100 * minor + patch. */
#define PENUMBRA_VERSION_NUMBER 100

/* The version of the library that is linked, for example "0.1.0".
 * Owns: the text is constant. */
PENUMBRA_API const char *penumbra_version(void);

/* ---- Scenes ---- */

/* Reads a scene from text in memory: XML if it begins with `<`, else JSON. It checks the whole
 * text; the limits are those of `penumbra render`.
 * Owns: free the scene with penumbra_scene_free. The scene keeps nothing of `text`.
 * Fails: NULL. Every error has its place, see struct penumbra_error. */
PENUMBRA_API struct penumbra_scene *penumbra_scene_load(const char *text, size_t bytes,
                                                        struct penumbra_errors **errors);

/* The models of scenes: where their bytes come from, and how to read them. A zero in any member
 * except `size` means the default. */
struct penumbra_models {
    size_t size; /* set by the caller: sizeof(struct penumbra_models) */
    /* Gives the bytes of a file with penumbra_file_append, and returns nonzero; returns 0 if it
     * cannot. The file is a model (PLY, OBJ or STL) or an MTL. `name` is a path inside the folder
     * of the scene: relative, with / between folders, without "..". It may be a link. NULL: scenes
     * that name files are refused. The call must return (no longjmp, no C++ exception). */
    int (*read)(void *user, const char *name, struct penumbra_file *file);
    void *user;
    uint32_t max_triangles; /* of one model; 0: 20 million */
    int up; /* for penumbra_scene_model: 'y' or 'z'; 0: z of a name that ends in .stl, else y */
};

/* Appends bytes to the file, as often as needed. Returns 1.
 * Owns: the file keeps nothing of `data`.
 * Fails: 0 if memory runs out; the callback should then return 0. */
PENUMBRA_API int penumbra_file_append(struct penumbra_file *file, const void *data, size_t bytes);

/* Reads a scene as penumbra_scene_load does. The scene may name model files.
 * Owns: as penumbra_scene_load.
 * Fails: also "usage" (wrong members of *models), "not-found" (the callback returned 0),
 * "forbidden" (a name leads out of the folder). */
PENUMBRA_API struct penumbra_scene *penumbra_scene_read(const char *text, size_t bytes,
                                                        const struct penumbra_models *models,
                                                        struct penumbra_errors **errors);

/* Makes the scene of a model, as `penumbra render bunny.ply` does: with a camera, lights, and grey
 * material if the model has none. The end of the name gives the kind: .ply, .obj or .stl.
 * Owns: free with penumbra_scene_free.
 * Fails: as penumbra_scene_read. */
PENUMBRA_API struct penumbra_scene *penumbra_scene_model(const char *name,
                                                         const struct penumbra_models *models,
                                                         struct penumbra_errors **errors);

/* Makes a built-in scene.
 * Owns: free with penumbra_scene_free.
 * Fails: NULL; "not-found" if no built-in scene has this name. */
PENUMBRA_API struct penumbra_scene *penumbra_scene_builtin(const char *name,
                                                           struct penumbra_errors **errors);

/* The name of built-in scene number `index`, from 0; NULL after the last.
 * Owns: the text is constant. */
PENUMBRA_API const char *penumbra_builtin_name(size_t index);

/* Frees a scene. NULL is allowed. Images rendered from it stay valid. */
PENUMBRA_API void penumbra_scene_free(struct penumbra_scene *scene);

/* The name of view number `index`, from 0; NULL after the last. A scene has at least one view;
 * penumbra_render takes the first by default.
 * Owns: the text belongs to the scene. */
PENUMBRA_API const char *penumbra_scene_view(const struct penumbra_scene *scene, size_t index);

/* Changes one render setting, as `penumbra render --set KEY=VALUE` does: "width=640",
 * "accelerator=median". penumbra-scene(5) lists the settings. Returns 1 on success.
 * Fails: 0; "usage" or "unsupported". The message names the key. */
PENUMBRA_API int penumbra_scene_set(struct penumbra_scene *scene, const char *assignment,
                                    struct penumbra_errors **errors);

/* All render settings as a JSON object, like `render` in a scene document.
 * Owns: free the text with penumbra_free. Fails: NULL; "no-memory". */
PENUMBRA_API char *penumbra_scene_settings(const struct penumbra_scene *scene,
                                           struct penumbra_errors **errors);

/* ---- Rendering ---- */

/* Upper bounds for rendering one view. They come from counts: nothing is built or traced. */
struct penumbra_estimate {
    size_t size;          /* set by the caller: sizeof(struct penumbra_estimate) */
    int width, height;    /* pixels */
    uint64_t primitives;  /* groups included */
    double rays;          /* upper bound: primary rays, and the shadow rays of their hits */
    int secondary;        /* 1: reflected or transmitted rays may be added; settings max_depth and
                             min_contribution limit them */
    uint64_t image_bytes; /* exact size of the image */
    uint64_t scene_bytes; /* upper bound for the scene and its acceleration structure */
};

/* Fills *estimate. Returns 1.
 * Fails: 0; "too-large" if the settings exceed the limits on pixels or rays, "usage" if `size` is
 * wrong. */
PENUMBRA_API int penumbra_scene_estimate(const struct penumbra_scene *scene,
                                         struct penumbra_estimate *estimate,
                                         struct penumbra_errors **errors);

/* How to render. A zero in any member except `size` means the default.
 * Threads: render threads call `progress` and `cancel`; the thread that calls penumbra_render never
 * does. Only one call of either runs at a time. The calls must return (no longjmp, no C++
 * exception). They must not call functions of this library on the scene that is being rendered. */
struct penumbra_render_options {
    size_t size; /* set by the caller: sizeof(struct penumbra_render_options) */
    /* Number of render threads, at most 1024; 0: one per processor. The setting `threads` may lower
     * it. */
    int threads;
    /* Called after each tile with the fraction done, above 0 and up to 1. */
    void (*progress)(void *user, double done);
    /* Called about every 10 ms and after each tile; returns nonzero to stop rendering. Not called
     * while the acceleration structure is built. */
    int (*cancel)(void *user);
    void *user;
};

/* Renders one view of a scene; returns when it is done. The first call builds the acceleration
 * structure. Later calls use it again unless the setting `accelerator` has changed. `view` is the
 * name of a view, or NULL for the first; `options` may be NULL.
 * Owns: free the image with penumbra_image_free; it keeps nothing of the scene.
 * Fails: NULL; "not-found" (no such view), "invalid-scene", "too-large", "cancelled", "no-memory",
 * "usage" (wrong options). */
PENUMBRA_API struct penumbra_image *penumbra_render(struct penumbra_scene *scene, const char *view,
                                                    const struct penumbra_render_options *options,
                                                    struct penumbra_errors **errors);

/* ---- Images ---- */

/* The pixels: *height rows of *width * 3 floats, the top row first, without gaps. They are linear
 * RGB; 1 is display white, and larger values are possible. width and height may be NULL.
 * Owns: the array belongs to the image. */
PENUMBRA_API const float *penumbra_image_pixels(const struct penumbra_image *image, int *width,
                                                int *height);

/* The image as a file in memory, of *bytes bytes: "png" (8 bits), "png16" or "pfm". A PNG has the
 * transfer function of the setting `transfer`; a PFM holds the pixels unchanged.
 * Owns: free with penumbra_free.
 * Fails: NULL; "usage" (unknown format), "no-memory". */
PENUMBRA_API void *penumbra_image_encode(const struct penumbra_image *image, const char *format,
                                         size_t *bytes, struct penumbra_errors **errors);

/* Times, ray counts and more as a JSON object: the output of `penumbra render --stats`.
 * Owns: the text belongs to the image. */
PENUMBRA_API const char *penumbra_image_statistics(const struct penumbra_image *image);

/* Frees an image. NULL is allowed. */
PENUMBRA_API void penumbra_image_free(struct penumbra_image *image);

/* ---- Errors ---- */

/* One error.
 * Owns: the texts belong to the list. */
struct penumbra_error {
    size_t size;         /* set by the caller: sizeof(struct penumbra_error) */
    const char *code;    /* kind: "syntax", "invalid-scene", "not-found", … as in the HTTP API */
    const char *message; /* one sentence without a full stop, UTF-8 */
    const char *pointer; /* JSON Pointer into a JSON scene, or "" */
    int line, column;    /* place in XML or malformed JSON, from 1; 0 if there is none */
    const char *text;    /* place and message in one line */
};

/* The number of errors found; 0 for NULL. The list keeps the first 20. */
PENUMBRA_API size_t penumbra_errors_count(const struct penumbra_errors *errors);

/* Fills *error with error number `index`, from 0. Returns 1. Returns 0 if there is no such error,
 * the list did not keep it, `size` is wrong or `errors` is NULL. */
PENUMBRA_API int penumbra_errors_get(const struct penumbra_errors *errors, size_t index,
                                     struct penumbra_error *error);

/* Frees a list of errors. NULL is allowed. */
PENUMBRA_API void penumbra_errors_free(struct penumbra_errors *errors);

/* ---- Memory ---- */

/* Frees a result of penumbra_scene_settings or penumbra_image_encode. NULL is allowed. */
PENUMBRA_API void penumbra_free(void *memory);

#ifdef __cplusplus
}
#endif

#endif
