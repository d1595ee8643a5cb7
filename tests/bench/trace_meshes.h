/* SPDX-License-Identifier: MIT */
/* Meshes and rays for bench_trace. */
#ifndef TESTS_BENCH_TRACE_MESHES_H
#define TESTS_BENCH_TRACE_MESHES_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* A mesh in one place, as numbers of a file. */
struct trace_mesh {
    float *vertex;
    uint32_t *corner, vertices, triangles;
    float eye[3], at[3];
};

/* A ray as Embree reads it; t in units of d. */
struct trace_ray {
    float o[3], d[3], tmax;
};

static inline void *trace_need(void *p)
{
    if (!p) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return p;
}

/* xorshift64*: numbers in 0 ... 1. */
static inline float trace_random(void)
{
    static uint64_t s = 88172645463325252u;
    s ^= s << 13;
    s ^= s >> 7;
    s ^= s << 17;
    return (float)(s >> 40) * 0x1p-24f;
}

/* A point of a bumpy sphere, or of a bumpy torus. */
static inline void trace_bumpy(float p[3], float u, float v, int torus)
{
    const float a = u * 6.2831853f;
    if (torus) {
        const float b = v * 6.2831853f, r = 0.35f + 0.03f * sinf(30 * a) * sinf(12 * b);
        p[0] = (0.9f + r * cosf(b)) * cosf(a);
        p[1] = r * sinf(b);
        p[2] = (0.9f + r * cosf(b)) * sinf(a);
    } else {
        const float b = v * 3.14159265f;
        const float r =
            1 + 0.06f * sinf(23 * a) * sinf(17 * b) + 0.02f * sinf(71 * a + 3 * sinf(40 * b));
        p[0] = r * cosf(a) * sinf(b);
        p[1] = r * cosf(b);
        p[2] = r * sinf(a) * sinf(b);
    }
}

/* A grid of n times m patches, bent to a sphere or, in 64 copies, to tori. */
static inline struct trace_mesh trace_grid(uint32_t n, uint32_t m, int torus)
{
    const uint32_t copies = torus ? 64 : 1;
    struct trace_mesh mesh = {.vertices = (n + 1) * (m + 1) * copies,
                              .triangles = 2 * n * m * copies};
    mesh.vertex = trace_need(malloc(3 * sizeof(float) * (mesh.vertices + (size_t)2)));
    mesh.corner = trace_need(malloc(3 * sizeof(uint32_t) * mesh.triangles));
    float *to = mesh.vertex;
    uint32_t *corner = mesh.corner;
    for (uint32_t c = 0; c < copies; c++) {
        const uint32_t base = (uint32_t)(to - mesh.vertex) / 3;
        for (uint32_t i = 0; i <= n; i++)
            for (uint32_t j = 0; j <= m; j++, to += 3) {
                trace_bumpy(to, (float)i / (float)n, (float)j / (float)m, torus);
                to[0] += torus ? ((float)(c % 8) - 3.5f) * 2.8f : 0;
                to[2] += torus ? ((float)(c / 8) - 3.5f) * 2.8f : 0;
            }
        for (uint32_t i = 0; i < n; i++)
            for (uint32_t j = 0; j < m; j++) {
                const uint32_t a = base + i * (m + 1) + j, d = a + m + 1;
                const uint32_t two[6] = {a, a + 1, d, a + 1, d + 1, d};
                for (int k = 0; k < 6; k++)
                    *corner++ = two[k];
            }
    }
    return mesh;
}

/* Triangles at random. */
static inline struct trace_mesh trace_soup(uint32_t count)
{
    struct trace_mesh mesh = {.vertices = 3 * count, .triangles = count};
    mesh.vertex = trace_need(malloc(3 * sizeof(float) * (mesh.vertices + (size_t)2)));
    mesh.corner = trace_need(malloc(3 * sizeof(uint32_t) * count));
    for (uint32_t t = 0; t < count; t++) {
        float c[3];
        for (int a = 0; a < 3; a++)
            c[a] = 6 * trace_random() - 3;
        for (uint32_t k = 0; k < 3; k++) {
            mesh.corner[3 * t + k] = 3 * t + k;
            for (uint32_t a = 0; a < 3; a++)
                mesh.vertex[9 * (size_t)t + 3 * k + a] = c[a] + 0.12f * (trace_random() - .5f);
        }
    }
    return mesh;
}

static inline void trace_set_view(struct trace_mesh *mesh, float x, float y, float z, float at)
{
    mesh->eye[0] = x;
    mesh->eye[1] = y;
    mesh->eye[2] = z;
    mesh->at[0] = mesh->at[2] = 0;
    mesh->at[1] = at;
}

#endif
