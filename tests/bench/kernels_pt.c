/* kernels_pt.c - pt.h for kernels.c, as the path tracer calls it: prepare a ray, trace it. Compiled twice, with different flags,
   hence KERNELS_NAME. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#ifdef PT_HEADER
#include PT_HEADER
#else
#include "../../pt.h"
#endif
#include "kernels.h"

typedef struct built { pt_scene *scene, *inner[2]; double bytes; pti_trace_function *trace; } built;

static void *count_alloc(void *user, size_t size, size_t align) { *(double *)user += (double)size; return pti_default_alloc(NULL, size, align); }
static void count_free(void *user, void *p, size_t size) { *(double *)user -= (double)size; pti_default_free(NULL, p, size); }

static void kernels_destroy(void *p) {
    built *b = (built *)p;
    pt_scene_destroy(b->scene);
    pt_scene_destroy(b->inner[0]); pt_scene_destroy(b->inner[1]);
    free(b);
}
static void add_part(pt_scene *s, const kernel_part *p) {
    pt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = p->positions; d.vertex_count = p->vertices;
    d.indices = p->indices; d.index_count = 3 * p->triangles;
    d.borrow = 1;
    pt_add_mesh(s, &d);
}
static void *kernels_build(const kernel_scene *s, const char *isa, int threads) {
    built *b = (built *)calloc(1, sizeof *b);
    pt_scene_desc d;
    double before;
    int k;
    size_t i;
    memset(&d, 0, sizeof d);
    d.allocator.alloc = count_alloc; d.allocator.free = count_free; d.allocator.user = &b->bytes;
#ifndef PT_NO_BUILD_THREADS
    d.threads = threads;
#else
    (void)threads;
#endif
#ifdef KERNELS_QUALITY
    d.quality = KERNELS_QUALITY;
#endif
    b->scene = pt_scene_create(&d);
    before = b->bytes;
    for (k = 0; k < s->parts; k++) {
        const kernel_part *p = &s->part[k];
        if (!p->copies) { add_part(b->scene, p); continue; }
        b->inner[k] = pt_scene_create(&d);
        add_part(b->inner[k], p);
        pt_scene_commit(b->inner[k]);
        for (i = 0; i < p->copies; i++) {
            pt_xform x;
            memcpy(x.m, p->transforms + 12 * i, sizeof x.m);
            pt_add_instance(b->scene, b->inner[k], &x);
        }
    }
    if (pt_scene_commit(b->scene) != PT_OK || (isa && !pti_isa_supported(pti_isa_by_name(isa)))) { kernels_destroy(b); return NULL; }
    b->bytes -= before;
    b->trace = pti_trace_for(isa ? pti_isa_by_name(isa) : pti_isa_best());
    return b;
}
#ifdef PT_HEADER
#define kernels_refit NULL                               /* an older one may have none */
#else
static void kernels_refit(void *p) { pt_scene_refit(((built *)p)->scene); }
#endif
static double kernels_bytes(void *p) { return ((built *)p)->bytes; }

/* as in pti_path_trace */
static inline void trace(const built *b, const kernel_ray *rays, size_t n, float *t, int any) {
    size_t i;
    for (i = 0; i < n; i++) {
        pti_ray r;
        pti_hit hit;
        const kernel_ray *k = rays + i;
        pt_vec3 org = pt_v3(k->org[0], k->org[1], k->org[2]), dir = pt_v3(k->dir[0], k->dir[1], k->dir[2]);
#if defined PT_HEADER && !defined PTI_ROWS               /* an older one may know no better */
        pti_ray_prepare(&r, org, dir, k->tmin, 0);
#else
        pti_ray_enter(&r, &b->scene->geometry.bvh, org, dir, k->tmin, 0);
#endif
        pti_hit_init(&hit, k->tmax);
        b->trace(&b->scene->geometry, &r, &hit, any);
        t[i] = any ? (float)hit.found : hit.found ? hit.t : FLT_MAX;
    }
}
static void kernels_closest(void *p, const kernel_ray *rays, size_t n, float *t) { trace((built *)p, rays, n, t, 0); }
static void kernels_any(void *p, const kernel_ray *rays, size_t n, float *t) { trace((built *)p, rays, n, t, 1); }

#define NAME_(x) #x
#define NAME(x) NAME_(x)
const kernel_library KERNELS_NAME = { NAME(KERNELS_NAME), kernels_build, kernels_bytes, kernels_closest, kernels_any, kernels_destroy,
                                       kernels_refit };
