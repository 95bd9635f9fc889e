/* kernels_embree.c - Embree 3 for kernels.c: rtcIntersect1 and rtcOccluded1, denormals flushed as its manual asks. */
#include <embree3/rtcore.h>
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>
#include "kernels.h"

typedef struct built { RTCDevice device; RTCScene scene, inner[2]; long long bytes; } built;

static bool count_bytes(void *user, ssize_t bytes, bool post) {
    (void)post;
    __atomic_add_fetch((long long *)user, (long long)bytes, __ATOMIC_RELAXED);
    return 1;
}
static RTCScene scene_new(const built *b, enum RTCBuildQuality quality, int robust) {
    RTCScene s = rtcNewScene(b->device);
    rtcSetSceneBuildQuality(s, quality);
    if (robust) rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST);
    return s;
}
static void add_part(const built *b, RTCScene s, const kernel_part *p, enum RTCBuildQuality quality) {
    RTCGeometry g = rtcNewGeometry(b->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(g, quality);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, p->positions, 0, 12, p->vertices);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, p->indices, 0, 12, p->triangles);
    rtcCommitGeometry(g);
    rtcAttachGeometry(s, g);
    rtcReleaseGeometry(g);
}
static void *build(const kernel_scene *s, const char *isa, int threads, enum RTCBuildQuality quality, int robust) {
    built *b = (built *)calloc(1, sizeof *b);
    char config[64];
    size_t i;
    int k;
    if (isa && !strcmp(isa, "scalar")) isa = "avx2";     /* it has no scalar code */
    snprintf(config, sizeof config, "threads=%d%s%s", threads, isa ? ",isa=" : "", isa ? isa : "");
    b->device = rtcNewDevice(config);
    rtcSetDeviceMemoryMonitorFunction(b->device, count_bytes, &b->bytes);
    b->scene = scene_new(b, quality, robust);
    for (k = 0; k < s->parts; k++) {
        const kernel_part *p = &s->part[k];
        if (!p->copies) { add_part(b, b->scene, p, quality); continue; }
        b->inner[k] = scene_new(b, quality, robust);
        add_part(b, b->inner[k], p, quality);
        rtcCommitScene(b->inner[k]);
        for (i = 0; i < p->copies; i++) {
            RTCGeometry g = rtcNewGeometry(b->device, RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetGeometryInstancedScene(g, b->inner[k]);
            rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, p->transforms + 12 * i);
            rtcCommitGeometry(g);
            rtcAttachGeometry(b->scene, g);
            rtcReleaseGeometry(g);
        }
    }
    rtcCommitScene(b->scene);
    return b;
}
static void destroy(void *p) {
    built *b = (built *)p;
    rtcReleaseScene(b->scene);
    if (b->inner[0]) rtcReleaseScene(b->inner[0]);
    if (b->inner[1]) rtcReleaseScene(b->inner[1]);
    rtcReleaseDevice(b->device);
    free(b);
}
static double bytes(void *p) { return (double)((built *)p)->bytes; }

static inline void ray_set(struct RTCRay *r, const kernel_ray *k) {
    r->org_x = k->org[0]; r->org_y = k->org[1]; r->org_z = k->org[2]; r->tnear = k->tmin;
    r->dir_x = k->dir[0]; r->dir_y = k->dir[1]; r->dir_z = k->dir[2]; r->time = 0;
    r->tfar = k->tmax; r->mask = 0xffffffffu; r->id = 0; r->flags = 0;
}
static void closest(void *p, const kernel_ray *rays, size_t n, float *t) {
    const built *b = (const built *)p;
    struct RTCIntersectContext context;
    unsigned mode = _mm_getcsr();
    size_t i;
    _mm_setcsr(mode | 0x8040);
    rtcInitIntersectContext(&context);
    for (i = 0; i < n; i++) {
        struct RTCRayHit q;
        ray_set(&q.ray, rays + i);
        q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(b->scene, &context, &q);
        t[i] = q.hit.geomID == RTC_INVALID_GEOMETRY_ID ? FLT_MAX : q.ray.tfar;
    }
    _mm_setcsr(mode);
}
static void any(void *p, const kernel_ray *rays, size_t n, float *t) {
    const built *b = (const built *)p;
    struct RTCIntersectContext context;
    unsigned mode = _mm_getcsr();
    size_t i;
    _mm_setcsr(mode | 0x8040);
    rtcInitIntersectContext(&context);
    for (i = 0; i < n; i++) {
        struct RTCRay q;
        ray_set(&q, rays + i);
        rtcOccluded1(b->scene, &context, &q);
        t[i] = q.tfar < 0;
    }
    _mm_setcsr(mode);
}

static void *build_default(const kernel_scene *s, const char *isa, int threads) { return build(s, isa, threads, RTC_BUILD_QUALITY_MEDIUM, 0); }
static void *build_robust(const kernel_scene *s, const char *isa, int threads) { return build(s, isa, threads, RTC_BUILD_QUALITY_MEDIUM, 1); }
static void *build_best(const kernel_scene *s, const char *isa, int threads) { return build(s, isa, threads, RTC_BUILD_QUALITY_HIGH, 0); }
const kernel_library embree        = { "embree",        build_default, bytes, closest, any, destroy, NULL };
const kernel_library embree_robust = { "embree_robust", build_robust,  bytes, closest, any, destroy, NULL };
const kernel_library embree_best   = { "embree_best",   build_best,    bytes, closest, any, destroy, NULL };
