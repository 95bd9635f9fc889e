/* kernels_scenes.h - the scenes that kernels.c races on, and random numbers for its rays. */
#ifndef KERNELS_SCENES_H
#define KERNELS_SCENES_H
#include "kernels.h"

/* cornell, bunny, arch, blobs, instances, grow and a number of triangles; 0 = there is none, or its file is not here */
int  scene_make(kernel_scene *s, const char *name);
void scene_free(kernel_scene *s);
void scene_blob(kernel_part *m, const double center[3], double radius, int n, double bump, uint32_t seed);   /* closed */

static inline uint32_t random_hash(uint32_t x) { x = (x ^ x >> 16) * 0x7feb352du; x = (x ^ x >> 15) * 0x846ca68bu; return x ^ x >> 16; }
typedef struct kernel_random { uint32_t state; } kernel_random;
static inline kernel_random random_seed(uint32_t seed) { kernel_random r; r.state = random_hash(seed + 0x9e3779b9u); return r; }
static inline float random_float(kernel_random *r) { return (float)(random_hash(r->state += 0x9e3779b9u) >> 8) / 16777216; }
#endif
