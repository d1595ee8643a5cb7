/* SPDX-License-Identifier: MIT */
/* Renders a built-in scene to a PNG file with libpenumbra; valid C11 and C++.
 *
 *     cc -o embed embed.c $(pkg-config --cflags --libs penumbra)
 *     ./embed room room.png */
#include <penumbra.h>
#include <stdio.h>

static int fail(struct penumbra_errors *errors)
{
    struct penumbra_error error;
    error.size = sizeof error;
    for (size_t i = 0; penumbra_errors_get(errors, i, &error); i++)
        fprintf(stderr, "embed: %s\n", error.text);
    penumbra_errors_free(errors);
    return 1;
}

int main(int argc, char **argv)
{
    struct penumbra_errors *errors = NULL;
    if (argc != 3)
        return fputs("usage: embed SCENE FILE.png\n", stderr), 2;
    struct penumbra_scene *scene = penumbra_scene_builtin(argv[1], &errors);
    struct penumbra_image *image = scene ? penumbra_render(scene, NULL, NULL, &errors) : NULL;
    size_t bytes = 0;
    void *png = image ? penumbra_image_encode(image, "png", &bytes, &errors) : NULL;
    penumbra_image_free(image);
    penumbra_scene_free(scene);
    if (!png)
        return fail(errors);
    FILE *file = fopen(argv[2], "wb");
    int written = file && fwrite(png, 1, bytes, file) == bytes;
    written = file && fclose(file) == 0 && written;
    penumbra_free(png);
    return written ? 0 : (perror(argv[2]), 1);
}
