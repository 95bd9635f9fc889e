/* >>kernel: every instruction set finds the same, to the bit, and no box that matters is passed by. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "meshes.h"
#include "stats.h"
#include "scenes.h"

#if defined(PTI_X86)
PTI_AVX2 static uint32_t boxes_avx2(const pti_node *n, const pti_ray *r, float limit, float enter[PTI_WIDTH]) {
    __m256 where, missed;
    missed = pti_boxes_avx2(n, r, limit, &where);
    _mm256_storeu_ps(enter, where);
    return (uint32_t)_mm256_movemask_ps(missed) ^ 0xffu;
}
#endif
typedef struct kernels { const char *name; int isa; pti_boxes_kernel *boxes; pti_triangles_kernel *triangles; } kernels;
static const kernels all_kernels[] = {
    { "scalar", PTI_SCALAR_ISA, pti_boxes_scalar, pti_triangles_scalar },
#if defined(PTI_X86)
    { "sse2", PTI_SSE2_ISA, pti_boxes_sse2, pti_triangles_sse2 },
    { "avx2", PTI_AVX2_ISA, boxes_avx2, pti_triangles_avx2 },
#elif defined(PTI_NEON)
    { "neon", PTI_NEON_ISA, pti_boxes_neon, pti_triangles_neon },
#endif
};
#define KERNELS ((int)(sizeof all_kernels / sizeof all_kernels[0]))

static int there[KERNELS];                               /* asked once: cpuid is slow in a virtual machine */

static uint32_t bits_of(float x) { uint32_t b; memcpy(&b, &x, sizeof b); return b; }

/* A ray of every odd kind: zeros of both signs, denormals, short and long, from grid points and from afar. */
static pt_ray odd_ray(pt_rng *r, v3 center, double size) {
    v3 org = v3_add(center, v3_scale(ball(r), size * magnitude(r, 0.1, 1000))), to = v3_add(center, v3_scale(ball(r), 0.6 * size));
    pt_ray ray;
    float *d, length = (float)magnitude(r, 1e-6, 1e6);
    int k;
    if (below(r, 3) == 0) org = v3_add(center, v3_scale(v3_of((int)below(r, 5) - 2, (int)below(r, 5) - 2, (int)below(r, 5) - 2), 0.5 * size));
    ray = ray_of(org, v3_sub(to, v3_rounded(org)));
    d = &ray.dir.x;
    if (below(r, 3) == 0)
        for (k = 0; k < 3; k++)
            switch (below(r, 6)) {
            case 0: d[k] = 0; break;
            case 1: d[k] = -0.0f; break;
            case 2: d[k] = below(r, 2) ? 1e-42f : -1e-45f; break;
            case 3: d[k] *= 1e-18f; break;
            }
    if (pti_largest_abs(ray.dir) < 1e-9f * (float)size) ray.dir = pt_v3(0, (float)size, 0);
    ray.dir = pti_scale(ray.dir, below(r, 2) ? length / pti_largest_abs(ray.dir) : 1);
    if (below(r, 4) == 0) ray.tmin = (float)uniform(r);
    if (below(r, 4) == 0) ray.tmax = ray.tmin + (float)magnitude(r, 0.1, 10);
    return ray;
}

/* ---- whole traversals ---- */

static void trace_both(const pt_scene *s, int k, const pti_ray *p, float tmax, pti_hit *nearest, pti_hit *any) {
    pti_hit_init(nearest, tmax); pti_hit_init(any, tmax);
    pti_trace_for(all_kernels[k].isa)(&s->geometry, p, nearest, 0);
    pti_trace_for(all_kernels[k].isa)(&s->geometry, p, any, 1);
}

static void compare_traces(const pt_scene *s, v3 center, double size, int n, pt_rng *r) {
    int k, wrong[KERNELS] = { 0 }, hits = 0, i = n;
    while (i--) {
        pt_ray ray = odd_ray(r, center, size);
        pti_ray p;
        pti_hit first[2];
        pti_ray_prepare(&p, ray.org, ray.dir, ray.tmin, 0, 0);
        for (k = 0; k < KERNELS; k++) {
            pti_hit hit, any;
            if (!there[k]) continue;
            trace_both(s, k, &p, ray.tmax, &hit, &any);
            if (k == 0) { first[0] = hit; first[1] = any; hits += hit.found; }
            wrong[k] += !same_hit(&first[0], &hit) || first[1].found != any.found || any.found != hit.found;
        }
    }
    for (k = 0; k < KERNELS; k++) if (!CHECK(wrong[k] == 0)) FAIL("%s: %d of %d rays differ from scalar", all_kernels[k].name, wrong[k], n);
    if (!CHECK(hits > n / 20)) FAIL("%d hits of %d", hits, n);
}
static void all_isas_trace_the_same(void) {
    pt_rng r;
    int k;
    pt_rng_seed(&r, 1, 3);
    for (k = 0; k < 6; k++) {
        static const double sizes[6] = { 1, 1, 1e-6, 1e7, 1, 100 };
        mesh m = k == 0 ? mesh_cube(8, &r) : mesh_blob(k == 1 ? 2 : 12, k == 4 ? 0.3 : 0.02, &r);
        v3 at = k == 4 ? v3_of(1000, -1100, 1200) : v3_of(0, 0, 0);
        pt_scene *s;
        mesh_move(&m, sizes[k], at);
        s = scene_of(&m);
        test_case("mesh %d", k);
        compare_traces(s, at, sizes[k], 30000, &r);
        pt_scene_destroy(s);
        mesh_free(&m);
    }
}
static void all_isas_trace_two_levels_the_same(void) {
    pt_rng r;
    int k, i;
    pt_rng_seed(&r, 2, 3);
    for (k = 0; k < 3; k++) {
        mesh m = mesh_blob(6, 0.1, &r), cube = mesh_cube(4, &r);
        pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
        pt_material none = { 0 };
        add_mesh(inner, &m);
        for (i = 0; i < 5; i++) pt_add_sphere(inner, v3_float(v3_scale(ball(&r), 2)), 0.2f, none);
        committed(inner);
        for (i = 0; i < 40; i++) {
            v3 row[3];
            pt_xform x;
            int j;
            rotation(&r, row);
            for (j = 0; j < 3; j++) {
                double scale = (k == 1 ? magnitude(&r, 1e-3, 10) : 0.2) * (j == 1 && i % 2 ? -1 : 1);
                x.m[4 * j] = (float)(row[j].x * scale); x.m[4 * j + 1] = (float)(row[j].y * scale); x.m[4 * j + 2] = (float)(row[j].z * scale);
                x.m[4 * j + 3] = (float)between(&r, -1, 1);
            }
            if (k == 2) { x = pti_xform_or_identity(NULL); x.m[3] = (float)(i % 5 - 2) * 2; x.m[7] = (float)(i / 5 % 3) * 2; }  /* a grid that touches */
            pt_add_instance(s, inner, &x);
            if (i % 10 == 0) pt_add_instance(s, inner, &x);
        }
        add_mesh(s, &cube);
        committed(s);
        test_case("two levels %d", k);
        compare_traces(s, v3_of(0, 0, 0), k == 2 ? 4 : 1.5, 20000, &r);
        pt_scene_destroy(s); pt_scene_destroy(inner);
        mesh_free(&m); mesh_free(&cube);
    }
}

/* ---- triangles ---- */

static void all_triangle_kernels_are_the_same(void) {
    pt_rng r;
    int i, k, lane, corner, axis, wrong[KERNELS] = { 0 }, hits = 0;
    pt_rng_seed(&r, 3, 3);
    for (i = 0; i < 200000; i++) {
        pti_packet p;
        pti_ray ray;
        pt_ray o = odd_ray(&r, v3_of(0, 0, 0), 1);
        double size = i % 7 ? magnitude(&r, 1e-3, 10) : 3e-8;          /* the latter: rounding is all there is */
        float tmax = below(&r, 2) ? FLT_MAX : (float)uniform(&r);
        uint32_t first = 0;
        pti_lanes want, got;
        memset(&p, 0, sizeof p);
        for (lane = 0; lane < PTI_LANES - (int)below(&r, 3); lane++) {
            v3 at = v3_scale(ball(&r), 0.5);
            for (corner = 0; corner < 3; corner++) {
                v3 c = v3_add(at, v3_scale(ball(&r), size));
                if (i % 3 == 0) c = v3_of(floor(2 * c.x + 0.5) / 2, floor(2 * c.y + 0.5) / 2, floor(2 * c.z + 0.5) / 2); /* on the grid of origins */
                p.v[corner][0][lane] = (float)c.x; p.v[corner][1][lane] = (float)c.y; p.v[corner][2][lane] = (float)c.z;
            }
            if (i % 100 == 1) for (corner = 0; corner < 3; corner++) for (axis = 0; axis < 3; axis++) p.v[corner][axis][lane] *= i % 200 == 1 ? 1e30f : 1e-30f;
        }
        if (i % 2) o.dir = pti_sub(pt_v3(p.v[0][0][0], p.v[0][1][0], p.v[0][2][0]), o.org);    /* through a corner */
        pti_ray_prepare(&ray, o.org, o.dir, o.tmin, 0, 0);
        for (k = 0; k < KERNELS; k++) {
            uint32_t mask;
            memset(&got, 0, sizeof got);
            if (!there[k]) continue;
            mask = all_kernels[k].triangles(&p, &ray, tmax, &got);
            if (k == 0) { first = mask; want = got; hits += mask != 0; }
            wrong[k] += mask != first;
            for (lane = 0; lane < PTI_LANES; lane++)
                if (mask >> lane & 1 && (bits_of(want.t[lane]) != bits_of(got.t[lane]) || bits_of(want.V[lane]) != bits_of(got.V[lane])
                    || bits_of(want.W[lane]) != bits_of(got.W[lane]) || bits_of(want.det[lane]) != bits_of(got.det[lane]) || !(got.t[lane] > ray.tmin && got.t[lane] <= tmax))) wrong[k]++;
        }
    }
    for (k = 0; k < KERNELS; k++) if (!CHECK(wrong[k] == 0)) FAIL("%s: %d differ from scalar", all_kernels[k].name, wrong[k]);
    CHECK(hits > 20000);
}

/* ---- boxes ---- */

/* Where the true ray enters and leaves a box, in double: closed, so that touching counts. */
static int enters(const float lo[3], const float hi[3], const pt_ray *ray, double tmax, double *t0) {
    const float *o = &ray->org.x, *d = &ray->dir.x;
    double t1 = tmax;
    int k;
    *t0 = (double)ray->tmin;
    for (k = 0; k < 3; k++) {
        double a, b;
        if (d[k] == 0) {
            if (o[k] < lo[k] || o[k] > hi[k]) return 0;
            continue;
        }
        a = ((double)lo[k] - (double)o[k]) / (double)d[k];
        b = ((double)hi[k] - (double)o[k]) / (double)d[k];
        *t0 = fmax(*t0, fmin(a, b));
        t1 = fmin(t1, fmax(a, b));
    }
    return *t0 <= t1;
}
static void box_kernels_are_conservative(void) {
    pt_rng r;
    int i, j, k, missed[KERNELS] = { 0 }, late[KERNELS] = { 0 }, met = 0, passed_by = 0, extra = 0;
    pt_rng_seed(&r, 4, 3);
    for (i = 0; i < 200000; i++) {
        pti_node n;
        double size = magnitude(&r, 1e-6, 1e6), entry[PTI_WIDTH];
        v3 center = below(&r, 2) ? v3_of(0, 0, 0) : v3_scale(ball(&r), 1000 * size);
        pt_ray o = odd_ray(&r, center, size);
        float tmax = below(&r, 2) ? FLT_MAX : (float)magnitude(&r, 1e-3, 1e3), *org = &o.org.x;
        uint32_t must = 0;
        int used = 1 + (int)below(&r, PTI_WIDTH), axis;
        pti_bounds nowhere = pti_bounds_empty();
        pti_ray ray;
        for (j = 0; j < PTI_WIDTH; j++) {
            float lo[3], hi[3];
            v3 c = v3_add(center, v3_scale(ball(&r), 0.6 * size)), h = v3_scale(v3_of(uniform(&r), uniform(&r), uniform(&r)), 0.5 * size);
            pti_bounds b;
            if (i % 3 == 0) h = v3_scale(h, magnitude(&r, 1e-6, 1));
            if (below(&r, 4) == 0) h.x = 0;              /* flat */
            if (below(&r, 8) == 0) h.y = 0;
            if (i % 5 == 0) { c = v3_add(center, v3_scale(v3_of((int)below(&r, 3) - 1, (int)below(&r, 3) - 1, (int)below(&r, 3) - 1), 0.5 * size)); h = v3_of(size / 2, size / 2, size / 2); }
            b.lo = v3_float(v3_sub(c, h)); b.hi = v3_float(v3_add(c, h));
            if (below(&r, 8) == 0) b.lo.x = org[0];      /* the origin on a plane */
            if (below(&r, 8) == 0) b.hi.y = org[1];
            if (below(&r, 8) == 0) b.hi.z = org[2];
            if (b.lo.x > b.hi.x || b.lo.y > b.hi.y || b.lo.z > b.hi.z || j >= used) { pti_node_set(&n, j, &nowhere, PTI_NONE); continue; }
            pti_node_set(&n, j, &b, (uint32_t)j);
            for (axis = 0; axis < 3; axis++) { lo[axis] = n.plane[2 * axis][j]; hi[axis] = n.plane[2 * axis + 1][j]; }
            must |= (uint32_t)enters(lo, hi, &o, (double)tmax, &entry[j]) << j;
        }
        pti_ray_prepare(&ray, o.org, o.dir, o.tmin, 0, 0);
        for (k = 0; k < KERNELS; k++) {
            float enter[PTI_WIDTH];
            uint32_t mask;
            if (!there[k]) continue;
            mask = all_kernels[k].boxes(&n, &ray, tmax * PTI_WIDEN, enter);
            missed[k] += (must & ~mask) != 0;
            for (j = 0; j < PTI_WIDTH; j++) {
                if (n.child[j] == PTI_NONE) { extra += mask >> j & 1; continue; }
                if (must >> j & 1 && mask >> j & 1 && (double)enter[j] > entry[j] * (double)PTI_WIDEN + 1e-45) late[k]++;
                if (k == 0) { met += must >> j & 1; passed_by += !(mask >> j & 1); }
            }
        }
    }
    for (k = 0; k < KERNELS; k++) {
        if (!CHECK(missed[k] == 0)) FAIL("%s misses a box %d times", all_kernels[k].name, missed[k]);
        if (!CHECK(late[k] == 0)) FAIL("%s enters too late %d times, which may hide a nearer hit", all_kernels[k].name, late[k]);
    }
    CHECK_EQ_INT(extra, 0);                              /* unused children are never met */
    CHECK(met > 20000 && passed_by > 100000);            /* nor are all the others */
}
/* Many rays at once are as many single ones, on triangles, spheres, in instances; those that can not be among them. */
static void many_rays_at_once(void) {
    enum { N = 4000 };
    static pt_ray rays[N];
    static pt_hit hits[N];
    static unsigned char occluded[N];
    pt_rng r;
    mesh m;
    pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
    pt_xform x;
    int i, wrong = 0, found = 0, in_instance = 0;
    pt_rng_seed(&r, 10, 3);
    m = mesh_blob(6, 0.1, &r);
    x = pti_xform_or_identity(NULL);
    x.m[3] = 2;
    CHECK_EQ_INT(pt_intersect_all(s, rays, N, hits), 0);         /* not committed */
    CHECK(hits[N - 1].t > FLT_MAX);
    add_mesh(inner, &m);
    committed(inner);
    pt_add_sphere(s, pt_v3(-2, 0, 0), 1, (pt_material){ 0 });
    add_mesh(s, &m);
    pt_add_instance(s, inner, &x);
    committed(s);
    for (i = 0; i < N; i++) rays[i] = odd_ray(&r, v3_of(0, 0, 0), 3);
    rays[7].dir = pt_v3(0, 0, 0);
    found = (int)pt_intersect_all(s, rays, N, hits);
    CHECK_EQ_INT(pt_occluded_all(s, rays, N, occluded), found);
    for (i = 0; i < N; i++) {
        pt_vertex v;
        int hit = pt_intersect(s, rays + i, &v);
        found -= hit;
        wrong += occluded[i] != hit || (hits[i].shape.id != 0) != hit || (hits[i].t < FLT_MAX) != hit;
        if (!hit) continue;
        in_instance += v.instance.id != 0;
        wrong += hits[i].t != v.t || hits[i].prim != v.prim || hits[i].shape.id != v.shape.id || hits[i].instance.id != v.instance.id;
        if (v.shape.id != 1 || v.instance.id) wrong += hits[i].u != v.u || hits[i].v != v.v;     /* no mesh here has uvs */
    }
    CHECK_EQ_INT(wrong, 0);
    CHECK_EQ_INT(found, 0);
    CHECK(in_instance > 50);
    CHECK_EQ_INT(hits[7].shape.id, 0);
    CHECK_EQ_INT(pt_intersect_all(NULL, rays, 1, hits), 0);
    CHECK_EQ_INT(pt_occluded_all(s, NULL, 1, occluded), 0);
    pt_scene_destroy(s); pt_scene_destroy(inner);
    mesh_free(&m);
}
/* Rays that can not be: nothing is found, nothing hangs. */
static void senseless_rays(void) {
    pt_rng r;
    mesh m;
    pt_scene *s;
    pt_material none = { 0 };
    int i, found = 0;
    pt_rng_seed(&r, 5, 3);
    m = mesh_blob(4, 0.1, &r);
    s = pt_scene_create(NULL);
    add_mesh(s, &m);
    pt_add_sphere(s, pt_v3(3, 0, 0), 1, none);
    committed(s);
    for (i = 0; i < 5000; i++) {
        pt_ray ray = odd_ray(&r, v3_of(0, 0, 0), 1);
        pt_vertex x;
        volatile float zero = 0;
        float bad = i % 3 == 0 ? zero / zero : i % 3 == 1 ? 1 / zero : -1 / zero;
        switch (below(&r, 5)) {
        case 0: ray.dir = pt_v3(0, -0.0f, 0); break;
        case 1: ray.dir.y = bad; break;
        case 2: ray.org.z = bad; break;
        case 3: ray.org = pt_v3(bad, bad, bad); break;
        case 4: ray.dir = pt_v3(bad, bad, bad); break;
        }
        found += pt_intersect(s, &ray, &x);
    }
    CHECK_EQ_INT(found, 0);
    pt_scene_destroy(s);
    mesh_free(&m);
}
/* Directions of any length find the same triangle. */
static void any_length_of_direction(void) {
    pt_rng r;
    mesh m;
    pt_scene *s;
    int i, e, wrong = 0;
    pt_rng_seed(&r, 6, 3);
    m = mesh_blob(8, 0.1, &r);
    s = scene_of(&m);
    for (i = 0; i < 2000; i++)
        for (e = -100; e <= 60; e += 10) {               /* powers of two, so that nothing rounds differently */
            v3 org = v3_scale(direction(&r), 5);
            pt_ray ray = ray_of(org, v3_sub(v3_scale(ball(&r), 0.8), org));
            pt_vertex x, y;
            int hit;
            if (i % 4 == 0) { ray.org.x = 0.25f; ray.dir.x = 0; }
            hit = pt_intersect(s, &ray, &x);
            ray.dir = pti_scale(ray.dir, (float)ldexp(1, e));
            wrong += pt_intersect(s, &ray, &y) != hit;
            if (hit) wrong += x.prim != y.prim || x.p.x != y.p.x || (double)y.t != ldexp((double)x.t, -e);
        }
    CHECK_EQ_INT(wrong, 0);
    pt_scene_destroy(s);
    mesh_free(&m);
}

/* ---- motion ---- */

static pt_xform moved_a_bit(pt_rng *r, const pt_xform *from, double turn) {    /* every coefficient, not too far */
    pt_xform x = *from;
    int i;
    for (i = 0; i < 12; i++) x.m[i] += (float)between(r, -1, 1) * (i % 4 == 3 ? 1 : (float)turn);
    return x;
}
static pt_xform small_pose(pt_rng *r) {
    pt_xform x;
    v3 row[3];
    int j;
    rotation(r, row);
    for (j = 0; j < 3; j++) {
        x.m[4 * j] = (float)(0.2 * row[j].x); x.m[4 * j + 1] = (float)(0.2 * row[j].y); x.m[4 * j + 2] = (float)(0.2 * row[j].z);
        x.m[4 * j + 3] = (float)between(r, -1, 1);
    }
    return x;
}
/* Where reciprocals or distances come near to infinity, all instruction sets say the same, and none looks where nothing is. */
static void next_to_infinity(void) {
    pt_rng r;
    mesh m;
    pt_scene *inner, *s;
    int i, k, wrong = 0, found = 0;
    pt_rng_seed(&r, 8, 3);
    m = mesh_blob(8, 0.1, &r);
    inner = scene_of(&m);
    s = pt_scene_create(NULL);
    for (i = 0; i < 20; i++) {
        pt_xform x = small_pose(&r);
        pt_add_instance(s, inner, &x);
    }
    if (!committed(s)) return;
    for (i = 0; i < 3000; i++) {
        pt_ray ray = ray_of(v3_scale(ball(&r), magnitude(&r, 1e-3, 1e30)), v3_of(0, 0, 0));
        double length = magnitude(&r, 1e-45, 1e-30);
        float t = 0;
        int expected = 0;
        ray.dir = v3_float(v3_scale(direction(&r), length));
        if (below(&r, 2)) ray.org = v3_float(v3_scale(ball(&r), 3));
        if (pti_is_zero3(ray.dir)) continue;
        for (k = 0; k < KERNELS; k++) {
            pti_ray p;
            pti_hit hit;
            int hits;
            if (!there[k]) continue;
            pti_ray_prepare(&p, ray.org, ray.dir, ray.tmin, 0, 0);
            pti_hit_init(&hit, ray.tmax);
            hits = pti_trace_for(all_kernels[k].isa)(&s->geometry, &p, &hit, 0);
            if (k == 0) { expected = hits; t = hit.t; found += hits; }
            wrong += hits != expected || (hits && hit.t != t);
        }
    }
    CHECK_EQ_INT(wrong, 0);
    CHECK(found > 50);
    pt_scene_destroy(s);
    pt_scene_destroy(inner);
    mesh_free(&m);
}

/* At many times: all instruction sets find what brute force does, any hit agrees, and some of them depend on the time. */
static void moving_instances_match_brute_force(void) {
    pt_rng r;
    mesh m;
    pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
    int i, k, wrong = 0, hits = 0, moving = 0, changed = 0;
    pt_rng_seed(&r, 7, 3);
    m = mesh_blob(2, 0.2, &r);
    add_mesh(inner, &m);
    pt_add_sphere(inner, pt_v3(0.5f, 1.5f, 0), 0.3f, (pt_material){ 0 });
    committed(inner);
    for (i = 0; i < 30; i++) {
        pt_xform a = small_pose(&r), b = moved_a_bit(&r, &a, 0.03);
        CHECK((i % 3 ? pt_add_moving_instance(s, inner, &a, &b) : pt_add_instance(s, inner, &a)).id != 0);
    }
    committed(s);
    for (i = 0; i < 3000; i++) {
        pt_ray ray = odd_ray(&r, v3_of(0, 0, 0), 1.5);
        float time = i % 10 == 0 ? 0 : i % 10 == 1 ? 1 : i % 10 == 2 ? -3 : i % 10 == 3 ? 7 : (float)uniform(&r);
        pti_ray p;
        pti_hit want, other;
        pti_ray_prepare(&p, ray.org, ray.dir, ray.tmin, time, 0);
        pti_hit_init(&want, ray.tmax);
        brute_geometry(&s->geometry, &p, &want, 0, 0);
        hits += want.found;
        moving += want.found && want.instance % 3 != 1;
        for (k = 0; k < KERNELS; k++) {
            pti_hit hit, any;
            if (!there[k]) continue;
            trace_both(s, k, &p, ray.tmax, &hit, &any);
            wrong += !same_hit(&want, &hit) || any.found != want.found;
        }
        pti_ray_prepare(&p, ray.org, ray.dir, ray.tmin, time < 0.5f ? 0.75f : 0.25f, 0);
        pti_hit_init(&other, ray.tmax);
        pti_trace_for(PTI_SCALAR_ISA)(&s->geometry, &p, &other, 0);
        changed += !same_hit(&want, &other);
    }
    CHECK_EQ_INT(wrong, 0);
    CHECK(hits > 300 && moving > 200 && changed > 100);
    pt_scene_destroy(s); pt_scene_destroy(inner);
    mesh_free(&m);
}
/* At a fixed time a moving instance is, to the bit, a still one with that transform: hits, normals, coordinates, error. */
static void moving_instances_equal_still_ones(void) {
    static const float times[] = { 0, 0.125f, 0.3f, 0.5f, 0.99f, 1, -1, 2 };
    pt_rng r;
    mesh m;
    int k, i, j;
    pt_rng_seed(&r, 8, 3);
    m = mesh_blob(4, 0.2, &r);
    for (k = 0; k < 8; k++) {
        pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL), *still = pt_scene_create(NULL);
        int wrong = 0, hits = 0;
        float t = times[k] < 0 ? 0 : times[k] > 1 ? 1 : times[k];
        add_mesh(inner, &m);
        pt_add_sphere(inner, pt_v3(0.5f, 1.5f, 0), 0.3f, (pt_material){ 0 });
        committed(inner);
        for (i = 0; i < 10; i++) {
            pt_xform a = small_pose(&r), b = moved_a_bit(&r, &a, 0.03), x;
            for (j = 0; j < 12; j++) x.m[j] = (1 - t) * a.m[j] + t * b.m[j];
            pt_add_moving_instance(s, inner, &a, &b);
            pt_add_instance(still, inner, &x);
        }
        committed(s); committed(still);
        for (i = 0; i < 3000; i++) {
            pt_ray ray = odd_ray(&r, v3_of(0, 0, 0), 1.5);
            pt_vertex x, y;
            int hit;
            ray.time = times[k];
            hit = pt_intersect(s, &ray, &x);
            wrong += pt_intersect(still, &ray, &y) != hit;
            if (!hit) continue;
            hits++;
            wrong += memcmp(&x, &y, sizeof x) != 0;
            CHECK(x.time == times[k]);
        }
        test_case("time %g", (double)times[k]);
        CHECK_EQ_INT(wrong, 0);
        CHECK(hits > 300);
        pt_scene_destroy(s); pt_scene_destroy(still); pt_scene_destroy(inner);
    }
    mesh_free(&m);
}
/* A glowing square, as wide as a pixel, that slides over it and on: it covers the pixel for half the time that it takes to
   move by two widths, as a triangle function of the place; seen once directly, once in a mirror, where the second ray of the
   path must have the first one's time. And its emitters are in no light tree. */
static void a_sliding_square(void) {
    static float rgb[8 * 8 * 3];
    int k, x, i;
    for (k = 0; k < 3; k++) {
        pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
        pt_xform a = pti_xform_or_identity(NULL), b = a;
        pt_render_desc d = view(pt_v3(0, 0, 5), pt_v3(0, 0, 0), 0, 8, 1024);
        d.camera.projection = PT_CAMERA_ORTHOGRAPHIC; d.camera.height = 8;       /* a pixel is a metre */
        d.camera.shutter_close = k == 2 ? 0.5f : 1;
        a.m[3] = -1; b.m[3] = k == 2 ? 3.0f : 1;         /* during the shutter from x = -1 to 1 */
        pt_add_quad(inner, pt_v3(0, -8, k == 1 ? 9.0f : 0), pt_v3(1, 0, 0), pt_v3(0, 16, 0), lamp(inner, 1, 1));
        if (k == 1) {                                    /* behind the eye, and a mirror before it */
            pt_add_quad(s, pt_v3(-8, -8, 0), pt_v3(16, 0, 0), pt_v3(0, 16, 0), mirror(s, 1));
        }
        if (commit(inner)) {
            CHECK_EQ_INT(inner->lights.count, 1);
            CHECK(pt_add_moving_instance(s, inner, &a, &b).id != 0);
            test_case("case %d", k);
            if (commit(s) && render(s, &d, rgb, NULL)) {
                CHECK_EQ_INT(s->lights.count, 0);
                for (x = 0; x < 8; x++) {
                    double lo = x - 4, want = 0, got = 0;
                    for (i = 0; i < 1000; i++) {         /* the share of the pixel that is covered, over time */
                        double p = -1 + 2 * (i + 0.5) / 1000;
                        want += fmax(0, fmin(lo, p) + 1 - fmax(lo, p)) / 1000;
                    }
                    for (i = 0; i < 8; i++) got += (double)rgb[3 * (8 * i + x)] / 8;
                    CHECK_NEAR(got, want, 0.004);
                    if (x == 4) CHECK_NEAR(got, 0.5, 0.004);
                }
            }
        }
        pt_scene_destroy(s); pt_scene_destroy(inner);
    }
}
/* A floor under a moving lamp in a closed form: the mean over time of the irradiance under a small bright sphere. */
static void light_of_a_moving_lamp(void) {
    pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
    pt_xform a = pti_xform_or_identity(NULL), b = a;
    pt_render_desc d = view_down(pt_v3(0, 0, 0), 16, 1024);
    stats_moments m;
    double want = 0;
    int i;
    pt_add_sphere(inner, pt_v3(0, 2, 0), 0.5f, lamp(inner, 10, 0));
    a.m[3] = -3; b.m[3] = 2;
    pt_add_quad(s, pt_v3(-9, 0, 9), pt_v3(18, 0, 0), pt_v3(0, 0, -18), diffuse(s, 0.5f));
    d.camera.shutter_close = 1;
    for (i = 0; i < 10000; i++) {                        /* E = pi L (R / D)^2 cos */
        double x = -3 + 5 * (i + 0.5) / 10000, d2 = x * x + 4;
        want += 10 * 0.25 / d2 * 2 / sqrt(d2) * 0.5 / 10000;
    }
    if (commit(inner)) {
        pt_add_moving_instance(s, inner, &a, &b);
        if (commit(s)) {
            m = render_pixels(s, &d);
            CHECK(stats_error(&m) < 0.01 * want);
            CHECK_P(stats_t_test(&m, want));
        }
    }
    pt_scene_destroy(s); pt_scene_destroy(inner);
}
/* Transforms that are flat somewhere on the way are refused, wherever that is; others are not. */
static void flat_on_the_way(void) {
    pt_scene *inner = pt_scene_create(NULL);
    pt_rng r;
    int i, refused = 0, wrong = 0;
    torus(inner, pt_v3(0, 0, 0), 1, 0.3f, (pt_material){ 0 });
    committed(inner);
    pt_rng_seed(&r, 9, 3);
    for (i = 0; i < 800; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_xform a = small_pose(&r), b = i % 2 ? small_pose(&r) : moved_a_bit(&r, &a, 0.2);
        double first = 0, least = 1;
        int k, ok;
        for (k = 0; k <= 400; k++) {
            pt_xform x = pti_xform_between(&a, &b, (float)k / 400);
            double det = pti_xform_det(&x);
            if (k == 0) first = det;
            least = fmin(least, det / first);
        }
        ok = pt_add_moving_instance(s, inner, &a, &b).id != 0;
        if (!ok) { CHECK(strstr(pt_scene_error(s), "pt_add_moving_instance") && strstr(pt_scene_error(s), "without an inverse")); refused++; }
        if (fabs(least) > 1e-4) wrong += ok != (least > 0);
        pt_scene_destroy(s);
    }
    CHECK_EQ_INT(wrong, 0);
    if (!CHECK(refused > 50 && refused < 700)) FAIL("%d refused", refused);
    for (i = 0; i < 6; i++) {
        static const float angle[] = { 0, 30, 90, 170, 180, 180.001f };
        pt_scene *s = pt_scene_create(NULL);
        pt_xform a = pti_xform_or_identity(NULL), b = a;
        double t = (double)angle[i] * STATS_PI / 180;
        b.m[0] = b.m[10] = (float)cos(t); b.m[2] = (float)sin(t); b.m[8] = (float)-sin(t);
        test_case("%g degrees", (double)angle[i]);
        CHECK((pt_add_moving_instance(s, inner, &a, &b).id != 0) == (i < 4));        /* half a turn is flat half way, a double root */
        pt_scene_destroy(s);
        s = pt_scene_create(NULL);
        b = a; b.m[0] = i % 2 ? -1.0f : 1e-6f;           /* mirrored; made a sheet, almost */
        CHECK((pt_add_moving_instance(s, inner, &a, &b).id != 0) == (i % 2 == 0));
        pt_scene_destroy(s);
    }
    for (i = 0; i < 24; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_xform a = pti_xform_or_identity(NULL), b = a;
        (i < 12 ? &a : &b)->m[i % 12] = (float)HUGE_VAL;
        CHECK_EQ_INT(pt_add_moving_instance(s, inner, &a, &b).id, 0);
        CHECK(strstr(pt_scene_error(s), i < 12 ? "from must be finite" : "to must be finite") != NULL);
        pt_scene_destroy(s);
    }
    pt_scene_destroy(inner);
}

void test_kernel(void) {
    int k;
    for (k = 0; k < KERNELS; k++) there[k] = pti_isa_supported(all_kernels[k].isa);
    RUN(all_isas_trace_the_same);
    RUN(all_isas_trace_two_levels_the_same);
    RUN(all_triangle_kernels_are_the_same);
    RUN(box_kernels_are_conservative);
    RUN(many_rays_at_once);
    RUN(senseless_rays);
    RUN(any_length_of_direction);
    RUN(next_to_infinity);
    RUN(moving_instances_match_brute_force);
    RUN(moving_instances_equal_still_ones);
    RUN(a_sliding_square);
    RUN(light_of_a_moving_lamp);
    RUN(flat_on_the_way);
}
