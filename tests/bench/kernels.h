/* kernels.h - what kernels.c asks of a library that it races: one table a library. */
#ifndef KERNELS_H
#define KERNELS_H
#include <stddef.h>
#include <stdint.h>

typedef struct kernel_ray { float org[3], tmin, dir[3], tmax; } kernel_ray;          /* dir has unit length; hits: tmin < t < tmax */

/* Triangles, one part after the other. Each part stands in the world as it is, or once for each of its transforms (3 rows of 4). */
typedef struct kernel_part {
    float *positions;    size_t vertices, vertex_room;
    uint32_t *indices;   size_t triangles, triangle_room;
    float *transforms;   size_t copies;
} kernel_part;
typedef struct kernel_scene {
    char name[16];
    kernel_part part[2];
    int parts;
    float eye[3], at[3], fov;                            /* degrees, of width and height */
    float light[3][3];                                   /* a parallelogram: corner, two edges */
} kernel_scene;

/* A loop over rays in the order given, one at a time; t is FLT_MAX where nothing was hit, any is 0 or 1. */
typedef struct kernel_library {
    const char *name;
    void  *(*build)(const kernel_scene *s, const char *isa, int threads);      /* isa NULL: the best. NULL: failed */
    double (*bytes)(void *built);                        /* that tracing needs */
    void   (*closest)(void *built, const kernel_ray *rays, size_t n, float *t);
    void   (*any)(void *built, const kernel_ray *rays, size_t n, float *t);
    void   (*destroy)(void *built);
    void   (*refit)(void *built);                        /* the same vertices again; NULL: not raced */
} kernel_library;
#endif
