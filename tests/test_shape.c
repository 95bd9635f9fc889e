/* >>shape: what rays hit, against double precision; no gaps between triangles; how far a hit lies from its surface, and that
   the next ray gets away from it. Also pti_vertex_fill and pti_spawn, the parts of >>kernel that those bounds are about. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "meshes.h"

#define ULP (1.0 / 16777216)                             /* 2^-24, the rounding of one operation */

/* ---- triangles against double ---- */

/* The corners as pti_triangle sees them, in double. margin: how far the ray is inside the triangle, as a multiple of what
   rounding may change; below -1 it is surely outside, above 1 surely inside. t: of the plane. */
typedef struct exact { double margin, t, height, scale; } exact;
static double axis_of(v3 a, int k) { return k == 0 ? a.x : k == 1 ? a.y : a.z; }
static exact exact_triangle(const v3 c[3], const pt_ray *ray, double t_float) {
    v3 org = v3_from(ray->org), dir = v3_from(ray->dir), n = v3_cross(v3_sub(c[1], c[0]), v3_sub(c[2], c[0]));
    double ax = fabs(dir.x), ay = fabs(dir.y), az = fabs(dir.z), x[3], y[3], U[3], sum, most = 0;
    int kz = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2, kx = (kz + 1) % 3, ky = (kz + 2) % 3, k;
    exact e;
    for (k = 0; k < 3; k++) {
        v3 d = v3_sub(c[k], org);
        x[k] = axis_of(d, kx) - axis_of(dir, kx) / axis_of(dir, kz) * axis_of(d, kz);
        y[k] = axis_of(d, ky) - axis_of(dir, ky) / axis_of(dir, kz) * axis_of(d, kz);
        most = fmax(most, fmax(fabs(d.x), fmax(fabs(d.y), fabs(d.z))));
    }
    for (k = 0; k < 3; k++) U[k] = x[(k + 2) % 3] * y[(k + 1) % 3] - y[(k + 2) % 3] * x[(k + 1) % 3];
    sum = U[0] + U[1] + U[2];
    e.margin = HUGE_VAL;
    for (k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        double error = 6 * ULP * most * (hypot(x[i], y[i]) + hypot(x[j], y[j])) + 1e-300;
        e.margin = fmin(e.margin, (sum < 0 ? -U[k] : U[k]) / error);
    }
    e.t = v3_dot(v3_sub(c[0], org), n) / v3_dot(dir, n);
    e.height = v3_dot(v3_sub(v3_add(org, v3_scale(dir, t_float)), c[0]), v3_unit(n));
    e.scale = most;
    return e;
}
static int float_triangle(const v3 c[3], const pt_ray *ray, float *t, float *u, float *v) {
    pti_packet p;
    pti_lanes at;
    pti_ray r;
    int k;
    memset(&p, 0, sizeof p);
    for (k = 0; k < 3; k++) {
        p.v[k][0][0] = (float)c[k].x; p.v[k][1][0] = (float)c[k].y; p.v[k][2][0] = (float)c[k].z;
    }
    pti_ray_prepare(&r, ray->org, ray->dir, ray->tmin, 0, 0);
    if (!pti_triangle(&p, 0, &r, &at)) return 0;
    *t = at.t[0]; *u = at.V[0] / at.det[0]; *v = at.W[0] / at.det[0];
    return 1;
}
static void random_triangle(pt_rng *r, int kind, v3 c[3]) {
    double size = magnitude(r, 0.1, 10);
    v3 at = v3_scale(ball(r), 2), along = v3_scale(direction(r), size);
    int k;
    for (k = 0; k < 3; k++) c[k] = v3_add(at, v3_scale(ball(r), size));
    switch (kind) {
    case 1: c[1] = v3_add(c[0], along); c[2] = v3_add(c[0], v3_add(v3_scale(along, uniform(r)), v3_scale(ball(r), 1e-4))); break;
    case 2: for (k = 0; k < 3; k++) c[k] = v3_scale(c[k], 1e8); break;
    case 3: for (k = 0; k < 3; k++) c[k] = v3_scale(c[k], 1e-8); break;
    case 4: for (k = 0; k < 3; k++) c[k] = v3_add(c[k], v3_of(1e4, -2e4, 3e4)); break;
    case 5: for (k = 0; k < 3; k++) c[k] = v3_add(v3_scale(c[k], 1e-4), v3_of(0.1, 0.2, 0.3)); break;
    }
    for (k = 0; k < 3; k++) c[k] = v3_rounded(c[k]);
}
static void triangles_against_double(void) {
    static const char *names[] = { "random", "needle", "huge", "tiny", "far", "small" };
    pt_rng r;
    int kind, i;
    pt_rng_seed(&r, 1, 1);
    for (kind = 0; kind < 6; kind++) {
        int hits = 0, wrong = 0, close = 0;
        double worst = 0, worst_uv = 0;
        for (i = 0; i < 60000; i++) {
            v3 c[3], to, org;
            double b = uniform(&r), a = uniform(&r) * (1 - b), size, d = magnitude(&r, 0.01, 100);
            float t = 0, u = 0, v = 0;
            pt_ray ray;
            exact e;
            int hit;
            random_triangle(&r, kind, c);
            size = v3_length(v3_sub(c[1], c[0]));
            to = v3_add(c[0], v3_add(v3_scale(v3_sub(c[1], c[0]), a), v3_scale(v3_sub(c[2], c[0]), b)));
            if (i % 3 == 0) to = v3_add(to, v3_scale(ball(&r), size));
            org = v3_add(to, v3_scale(direction(&r), size * d));
            ray = ray_of(org, v3_scale(v3_sub(to, org), magnitude(&r, 1e-3, 1e3)));
            hit = float_triangle(c, &ray, &t, &u, &v);
            e = exact_triangle(c, &ray, (double)t);
            if (fabs(e.margin) <= 1) close++;
            if (hit ? e.margin < -1 : e.margin > 1 && e.t > 0) wrong++;
            if (!hit) continue;
            hits++;
            if (e.margin > 1 && kind != 1) worst = fmax(worst, fabs(e.height) / (ULP * e.scale));   /* else there is no plane to speak of */
            if (!(u >= 0 && v >= 0 && (double)u + (double)v <= 1 + 4 * ULP)) worst_uv++;
        }
        test_case("%s", names[kind]);
        CHECK_EQ_INT(wrong, 0);
        CHECK(hits > 20000);
        CHECK(close < 30000);                            /* else nothing has been looked at */
        if (!CHECK(worst < 24)) FAIL("a hit is off the plane by %g ulp of its distance", worst);
        CHECK(worst_uv == 0);
    }
}
static void degenerate_triangles(void) {
    pt_rng r;
    int i, hits = 0, odd = 0;
    pt_rng_seed(&r, 2, 1);
    for (i = 0; i < 200000; i++) {
        v3 c[3];
        float t = 0, u = 0, v = 0;
        double s = magnitude(&r, 1e-12, 1e10);
        pt_ray ray;
        mesh m;
        pt_scene *scene;
        pt_vertex x;
        random_triangle(&r, 0, c);
        switch (i % 5) {
        case 0: c[1] = c[0]; break;                      /* an edge, or a point */
        case 1: c[2] = c[1] = c[0]; break;
        case 2: c[1] = v3_scale(c[0], 2); c[2] = v3_scale(c[0], 4); break;                     /* a line through the origin */
        case 3: c[0].x = c[1].x = c[2].x; c[0].y = c[1].y = c[2].y; break;                     /* along an axis */
        case 4: c[2] = v3_rounded(v3_scale(v3_add(c[0], c[1]), 0.5)); break;            /* nearly */
        }
        for (int k = 0; k < 3; k++) c[k] = v3_rounded(v3_scale(c[k], s));
        ray = ray_of(v3_scale(ball(&r), 10 * s), v3_of(0, 0, 0));
        ray.dir = v3_float(v3_sub(c[i % 3], v3_from(ray.org)));
        if (float_triangle(c, &ray, &t, &u, &v) && !(t > 0 && t < 1e30f && u >= 0 && v >= 0)) odd++;
        if (i % 50 > 4) continue;
        m = mesh_new(3, 1);
        mesh_add_triangle(&m, c[0], c[1], c[2]);
        scene = scene_of(&m);
        if (pt_intersect(scene, &ray, &x)) {
            if (i % 5 != 4 && i % 5 != 2) hits++;        /* those have no area at all, not even by rounding */
            if (!(fabsf(pti_length(x.ng) - 1) < 1e-5f && pti_finite3(x.p) && pti_finite3(x.tangent) && pti_finite(x.error))) odd++;
        }
        pt_scene_destroy(scene);
        mesh_free(&m);
    }
    CHECK_EQ_INT(hits, 0);
    CHECK_EQ_INT(odd, 0);
}

/* A tiny triangle in one packet with a large floor: rays that pass it by, metres away, must not hit it. Far from the ray its
   corners fall together in the rounding, and what is left of U, V and W is noise. */
static void no_hits_from_afar(void) {
    pt_rng r;
    double size, half;
    pt_rng_seed(&r, 12, 1);
    for (size = 1e-2; size > 1e-8; size /= 10)
        for (half = 10; half <= 1000; half *= 10) {
            mesh m = mesh_new(9, 3);
            pt_scene *s;
            int i, stray = 0, hits = 0;
            mesh_add_triangle(&m, v3_of(-half, 0, -half), v3_of(half, 0, half), v3_of(half, 0, -half));
            mesh_add_triangle(&m, v3_of(-half, 0, -half), v3_of(-half, 0, half), v3_of(half, 0, half));
            mesh_add_triangle(&m, v3_of(0.1, 1, 0.2), v3_of(0.1 + size, 1, 0.2), v3_of(0.1, 1 + size, 0.2 + size));
            s = scene_of(&m);
            for (i = 0; i < 5000; i++) {
                v3 to = v3_of(between(&r, -half, half), 0, between(&r, -half, half)), org = v3_add(to, v3_of(between(&r, -3, 3), 5, between(&r, -3, 3)));
                pt_ray ray = ray_of(org, v3_sub(to, org));
                pt_vertex x;
                if (fabs(org.x) < 4 || !pt_intersect(s, &ray, &x)) continue;
                hits++;
                stray += x.prim == 2;
            }
            test_case("%g m beside %g m", size, half);
            CHECK_EQ_INT(stray, 0);
            CHECK(hits > 1000);
            pt_scene_destroy(s);
            mesh_free(&m);
        }
}

/* ---- watertight ---- */

static void tilt_zero(pt_rng *r, pt_vec3 *d) {           /* zeros get a sign */
    if (d->x == 0 && below(r, 2)) d->x = -0.0f;
    if (d->y == 0 && below(r, 2)) d->y = -0.0f;
    if (d->z == 0 && below(r, 2)) d->z = -0.0f;
}
/* A point on an edge of a triangle, or a corner, as a float. */
static v3 edge_point(pt_rng *r, const mesh *m) {
    size_t triangle = below(r, m->indices / 3), k = below(r, 3);
    v3 a = mesh_corner(m, triangle, k), b = mesh_corner(m, triangle, k + 1);
    double at = below(r, 4) ? uniform(r) : 0;
    return v3_rounded(v3_add(a, v3_scale(v3_sub(b, a), at)));
}
/* Rays that start in the middle half of a star-shaped mesh, or close below its surface, and look at its edges. */
static int leaks_from_inside(const mesh *m, v3 center, double radius, int n, pt_rng *r) {
    pt_scene *s = scene_of(m);
    int leaks = 0;
    while (n--) {
        v3 to = edge_point(r, m), org = v3_add(center, v3_scale(ball(r), 0.4 * radius));
        pt_ray ray;
        pt_vertex x;
        if (n % 4 == 0) org = v3_add(to, v3_scale(v3_sub(org, to), magnitude(r, 1e-4 + 64 * ULP * v3_length(center) / radius, 1)));
        ray = ray_of(org, v3_scale(v3_sub(to, v3_rounded(org)), n % 2 ? 1 : magnitude(r, 1e-3, 1e3)));
        leaks += !pt_intersect(s, &ray, &x);
    }
    pt_scene_destroy(s);
    return leaks;
}
/* Rays from outside, towards edges that face them: what they hit first must not be the far side. */
static int leaks_from_outside(const mesh *m, v3 center, double radius, double nearest, double farthest, int n, pt_rng *r) {
    pt_scene *s = scene_of(m);
    int leaks = 0;
    while (n) {
        v3 to = edge_point(r, m), out = v3_sub(to, center), org = v3_scale(direction(r), radius * magnitude(r, nearest, farthest));
        double distance;
        pt_ray ray;
        pt_vertex x;
        org = v3_rounded(v3_add(center, org));
        if (v3_dot(v3_unit(out), v3_unit(v3_sub(org, to))) < 0.6) continue;
        n--;
        distance = v3_length(v3_sub(to, org));
        ray = ray_of(org, v3_scale(v3_sub(to, org), n % 2 ? 1 : 1 / distance));
        if (!pt_intersect(s, &ray, &x) || (double)x.t * v3_length(v3_from(ray.dir)) > distance + 0.9 * radius) leaks++;
    }
    pt_scene_destroy(s);
    return leaks;
}
static void watertight_blobs(void) {
    static const double moved[3] = { 1000, 1100, 1200 };
    pt_rng r;
    int i;
    pt_rng_seed(&r, 3, 1);
    for (i = 0; i < 6; i++) {
        mesh m = mesh_blob(i % 3 == 0 ? 4 : 10, 0.02, &r);
        v3 center = v3_of(0, 0, 0);
        double radius = i == 2 ? 1e-3 : i == 3 ? 1e5 : 1;
        if (i % 2) center = v3_scale(v3_of(moved[0], moved[1], moved[2]), radius);
        mesh_move(&m, radius, center);
        test_case("blob %d", i);
        CHECK_EQ_INT(leaks_from_inside(&m, center, radius, 50000, &r), 0);
        CHECK_EQ_INT(leaks_from_outside(&m, center, radius, 1.5, 100, 40000, &r), 0);
        CHECK_EQ_INT(leaks_from_outside(&m, center, radius, 1e5, 1e6, 10000, &r), 0);
        mesh_free(&m);
    }
}
/* Axis-parallel rays and diagonals through the vertices of a cube's grid, from grid points inside and from outside. */
static int leaks_in_grid(pt_rng *r, uint32_t n, v3 at, int rays, int denormal) {
    mesh m = mesh_cube(n, r);
    pt_scene *s;
    int leaks = 0;
    mesh_move(&m, 1, at);
    s = scene_of(&m);
    while (rays--) {
        pt_ray ray;
        pt_vertex x;
        v3 p = v3_of(2.0 * (1 + below(r, n - 1)) / n - 1, 2.0 * (1 + below(r, n - 1)) / n - 1, 2.0 * (1 + below(r, n - 1)) / n - 1);
        v3 d = v3_of((int)below(r, 3) - 1, (int)below(r, 3) - 1, (int)below(r, 3) - 1);
        int outside = rays % 2;
        if (d.x == 0 && d.y == 0 && d.z == 0) continue;
        if (rays % 8 == 0) p = v3_scale(p, 0.5);         /* half a cell off */
        if (outside) {                                   /* straight onto a face, from a whole number of cells away */
            int k = (int)below(r, 3), side = below(r, 2) ? 1 : -1;
            double *c = k == 0 ? &p.x : k == 1 ? &p.y : &p.z;
            d = v3_of(k == 0 ? -side : 0, k == 1 ? -side : 0, k == 2 ? -side : 0);
            *c = side * (1 + magnitude(r, 1e-3, 1e3));
        }
        ray = ray_of(v3_add(p, at), d);
        if (denormal && ray.dir.x == 0) ray.dir.x = below(r, 2) ? 1e-40f : -1e-40f;
        if (denormal && ray.dir.y == 0) ray.dir.y = below(r, 2) ? 1e-45f : -1e-30f;
        tilt_zero(r, &ray.dir);
        ray.dir = pti_scale(ray.dir, (float)magnitude(r, 1e-3, 1e3));
        if (!pt_intersect(s, &ray, &x)) { leaks++; continue; }
        if (outside && pti_dot(x.ng, ray.dir) > 0) leaks++;            /* through the near side, out of the far one */
    }
    pt_scene_destroy(s);
    mesh_free(&m);
    return leaks;
}
static void watertight_cubes(void) {
    pt_rng r;
    int k;
    pt_rng_seed(&r, 4, 1);
    for (k = 0; k < 4; k++) {
        v3 at = k & 1 ? v3_of(1000, 1100, 1200) : v3_of(0, 0, 0);
        mesh m;
        test_case("cube %d", k);
        CHECK_EQ_INT(leaks_in_grid(&r, 16, at, 60000, k & 2), 0);
        CHECK_EQ_INT(leaks_in_grid(&r, 2, at, 30000, k & 2), 0);
        m = mesh_cube(k & 2 ? 16 : 2, &r);
        if (k & 2) { v3 row[3]; rotation(&r, row); mesh_rotate(&m, row); }
        mesh_move(&m, 1, at);
        CHECK_EQ_INT(leaks_from_inside(&m, at, 1, 50000, &r), 0);
        mesh_free(&m);
    }
}

/* ---- spheres against double ---- */

static void spheres_against_double(void) {
    pt_rng r;
    int i, hits = 0, wrong = 0, misses = 0;
    pt_rng_seed(&r, 5, 1);
    for (i = 0; i < 200000; i++) {
        double size = magnitude(&r, 1e-8, 1e8), far = magnitude(&r, 1e-3, 1e5), b, dd, closest, radius, t_want, disc;
        v3 c = v3_scale(ball(&r), i % 3 ? 0 : size * 100), org, d, o;
        pti_sphere s;
        pti_ray ray;
        float t;
        int hit;
        s.center = v3_float(c);
        s.radius = (float)size;
        c = v3_from(s.center); radius = (double)s.radius;
        org = v3_add(c, v3_scale(direction(&r), i % 4 == 0 ? size : i % 4 == 1 ? size * uniform(&r) : size * (1 + far)));
        d = v3_sub(v3_add(c, v3_scale(ball(&r), 1.5 * size)), org);
        d = v3_scale(d, i % 2 ? 1 / v3_length(d) : 1);
        org = v3_rounded(org); d = v3_rounded(d);
        pti_ray_prepare(&ray, v3_float(org), v3_float(d), 0, 0, 0);
        hit = pti_sphere_hit(&s, &ray, FLT_MAX, &t);
        o = v3_sub(org, c);
        dd = v3_dot(d, d);
        b = -v3_dot(o, d) / dd;
        closest = v3_length(v3_add(o, v3_scale(d, b)));
        if (fabs(closest / radius - 1) < 1e-6 * (1 + 1e-9 * v3_length(o) / radius)) continue;  /* too close to call */
        disc = sqrt(fmax(0, radius * radius - closest * closest) / dd);
        if (fabs(v3_length(o) / radius - 1) < 1e-6) {    /* on the surface: which root is it? both are right */
            if (hit && fabs((double)t - (b + disc)) > 1e-6 * disc + 1e-6 * radius && fabs((double)t - (b - disc)) > 1e-6 * disc + 1e-6 * radius) wrong++;
            continue;
        }
        t_want = b - disc > 0 ? b - disc : b + disc;
        if (closest > radius || t_want < 0) { wrong += hit; misses++; continue; }
        hits++;
        if (!hit || fabs((double)t / t_want - 1) > 2 * ULP + 1e-9 * disc / t_want * 1e3) wrong++;
    }
    CHECK_EQ_INT(wrong, 0);
    CHECK(hits > 50000);
    CHECK(misses > 10000);
}
/* A user walks along a ray with tmin = the last t: it must find both sides of a sphere, and then nothing. */
static void sphere_walk(void) {
    pt_rng r;
    int i, wrong = 0;
    pt_rng_seed(&r, 6, 1);
    for (i = 0; i < 5000; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_material none = { 0 };
        pt_ray ray;
        pt_vertex x;
        v3 org = v3_scale(direction(&r), between(&r, 2, 10));
        int n = 0;
        pt_add_sphere(s, pt_v3(0, 0, 0), 1, none);
        pt_scene_commit(s);
        ray = ray_of(org, v3_sub(v3_scale(ball(&r), 0.9), org));
        while (n < 4 && pt_intersect(s, &ray, &x)) { ray.tmin = x.t; n++; }
        wrong += n != 2;
        pt_scene_destroy(s);
    }
    CHECK_EQ_INT(wrong, 0);
}

/* ---- vertices ---- */

static v3 transform(const pt_xform *x, v3 p) {
    const float *m = x->m;
    return v3_of((double)m[0] * p.x + (double)m[1] * p.y + (double)m[2] * p.z + (double)m[3],
                 (double)m[4] * p.x + (double)m[5] * p.y + (double)m[6] * p.z + (double)m[7],
                 (double)m[8] * p.x + (double)m[9] * p.y + (double)m[10] * p.z + (double)m[11]);
}
static pt_xform random_xform(pt_rng *r, int kind) {
    v3 row[3];
    double sx = 1, sy = 1, sz = 1, move = 10;
    pt_xform x;
    int k;
    rotation(r, row);
    if (kind == 1) sx = -1;                                                              /* mirror */
    if (kind == 2) { sx = magnitude(r, 1e-2, 1e2); sy = magnitude(r, 1e-2, 1e2); }       /* non-uniform */
    if (kind == 3) row[1] = v3_add(row[1], v3_scale(row[0], between(r, -3, 3)));         /* shear */
    if (kind == 4) move = 1e4;                                                           /* far */
    if (kind == 5) { sx = sy = sz = magnitude(r, 1e-3, 1e3); move = 1e4; }
    for (k = 0; k < 3; k++) {
        x.m[4 * k] = (float)(row[k].x * sx); x.m[4 * k + 1] = (float)(row[k].y * sy); x.m[4 * k + 2] = (float)(row[k].z * sz);
        x.m[4 * k + 3] = (float)between(r, -move, move);
    }
    return x;
}
#define XFORMS 6
static const char *xform_names[XFORMS] = { "rotation", "mirror", "non-uniform scale", "shear", "far", "far and scaled" };

/* p within x.error of the plane (or the sphere), in double; normals and tangents unit and where they belong. */
static void vertices_on_triangles(void) {
    pt_rng r;
    int kind, i;
    pt_rng_seed(&r, 7, 1);
    for (kind = 0; kind < XFORMS; kind++) {
        double worst = 0, worst_uv = 0, worst_n = 0, worst_t = 0, worst_unit = 0;
        int hits = 0, flipped = 0;
        for (i = 0; i < 2500; i++) {
            pt_xform xf = random_xform(&r, kind);
            float p[9], uv[6];
            v3 c[3], w[3], n, nw, to, org, du;
            pt_mesh_desc d;
            pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
            pt_ray ray;
            pt_vertex x;
            double b = uniform(&r), a = uniform(&r) * (1 - b), size, where = magnitude(&r, 0.1, 1000), mirror;
            int k;
            for (k = 0; k < 3; k++) {
                c[k] = v3_rounded(v3_add(v3_scale(ball(&r), 1), v3_of(where, 0, -where)));
                p[3 * k] = (float)c[k].x; p[3 * k + 1] = (float)c[k].y; p[3 * k + 2] = (float)c[k].z;
                uv[2 * k] = (float)uniform(&r); uv[2 * k + 1] = (float)uniform(&r);
                w[k] = transform(&xf, c[k]);
            }
            n = v3_cross(v3_sub(c[1], c[0]), v3_sub(c[2], c[0]));
            size = v3_length(v3_sub(w[1], w[0])) + v3_length(v3_sub(w[2], w[0]));
            memset(&d, 0, sizeof d);
            d.positions = p; d.vertex_count = 3; d.uvs = uv;
            pt_add_mesh(inner, &d);
            committed(inner);
            pt_add_instance(s, inner, &xf);
            committed(s);
            to = v3_add(w[0], v3_add(v3_scale(v3_sub(w[1], w[0]), a), v3_scale(v3_sub(w[2], w[0]), b)));
            org = v3_add(to, v3_scale(direction(&r), size * magnitude(&r, 0.1, 10)));
            ray = ray_of(org, v3_sub(to, org));
            mirror = pti_xform_det(&xf) < 0 ? -1 : 1;
            nw = v3_unit(v3_scale(v3_cross(v3_sub(w[1], w[0]), v3_sub(w[2], w[0])), mirror));
            if (v3_length(n) > 1e-2 && pt_intersect(s, &ray, &x)) {
                double det, error = (double)x.error, fine = v3_length(v3_cross(v3_sub(w[1], w[0]), v3_sub(w[2], w[0]))) / (size * size);
                v3 q = v3_from(x.p), e1 = v3_sub(w[1], w[0]), e2 = v3_sub(w[2], w[0]);
                hits++;
                worst = fmax(worst, fabs(v3_dot(v3_sub(q, w[0]), nw)) / error);
                worst_unit = fmax(worst_unit, fabs(v3_length(v3_from(x.ng)) - 1));
                worst_unit = fmax(worst_unit, fabs(v3_length(v3_from(x.ns)) - 1));
                worst_unit = fmax(worst_unit, fabs(v3_length(v3_from(x.tangent)) - 1));
                worst_unit = fmax(worst_unit, fabs(v3_dot(v3_from(x.ns), v3_from(x.tangent))));
                flipped += v3_dot(v3_from(x.ng), nw) < 0;
                if (fine > 1e-2) worst_n = fmax(worst_n, v3_length(v3_sub(v3_from(x.ng), nw)));
                if (fine > 1e-2 && fabsf(pti_dot(x.ng, x.wo)) > 0.1f) worst_uv = fmax(worst_uv, fabs((double)x.u - ((double)uv[0] + a * (double)(uv[2] - uv[0]) + b * (double)(uv[4] - uv[0]))));
                det = (double)(uv[2] - uv[0]) * (double)(uv[5] - uv[1]) - (double)(uv[3] - uv[1]) * (double)(uv[4] - uv[0]);
                du = v3_scale(v3_sub(v3_scale(e1, (double)(uv[5] - uv[1])), v3_scale(e2, (double)(uv[3] - uv[1]))), det > 0 ? 1 : -1);
                if (fine > 1e-2 && fabs(det) > 1e-2 && fabs(v3_dot(v3_unit(du), nw)) < 0.9 && fabsf(pti_dot(x.ng, x.wo)) > 0.01f)
                    worst_t = fmax(worst_t, v3_length(v3_sub(v3_from(x.tangent), v3_unit(du))));
            }
            pt_scene_destroy(s);
            pt_scene_destroy(inner);
        }
        test_case("%s", xform_names[kind]);
        CHECK(hits > 1000);
        CHECK_EQ_INT(flipped, 0);
        if (!CHECK(worst < 1)) FAIL("off the plane by %g times x.error", worst);
        CHECK_NEAR(worst_unit, 0, 1e-6);
        CHECK_NEAR(worst_n, 0, 1e-3);
        CHECK_NEAR(worst_uv, 0, kind == 5 ? 1 : kind == 4 ? 0.3 : 1e-2);
        CHECK_NEAR(worst_t, 0, 1e-2);
    }
}
static void vertices_on_spheres(void) {
    pt_rng r;
    int kind, i;
    pt_rng_seed(&r, 8, 1);
    for (kind = -1; kind < XFORMS; kind++) {
        double worst = 0, worst_unit = 0;
        int hits = 0, inwards = 0;
        for (i = 0; i < 2500; i++) {
            pt_xform xf = pti_xform_or_identity(NULL), inverse;
            pt_material none = { 0 };
            double radius = magnitude(&r, 1e-3, 1e3), where = radius * magnitude(&r, 1e-2, 1e2), local, grow;
            v3 c = v3_rounded(v3_scale(direction(&r), where)), p, to, org, q;
            pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
            pt_ray ray;
            pt_vertex x;
            if (kind >= 0) xf = random_xform(&r, kind);
            pti_xform_invert(&xf, &inverse);
            pt_add_sphere(inner, v3_float(c), (float)radius, none);
            committed(inner);
            if (kind >= 0) pt_add_instance(s, inner, &xf);
            committed(s);
            to = transform(&xf, v3_add(c, v3_scale(ball(&r), radius)));
            org = v3_add(to, v3_sub(transform(&xf, v3_add(c, v3_scale(direction(&r), radius * magnitude(&r, 2, 100)))), transform(&xf, c)));
            ray = ray_of(org, v3_sub(to, org));
            if (pt_intersect(kind < 0 ? inner : s, &ray, &x)) {
                v3 n, e[3], q_local;
                double m[9], det;
                int k;
                hits++;
                q = v3_from(x.p);
                /* back into the instance, exactly: by solving with the forward transform in double */
                for (k = 0; k < 9; k++) m[k] = (double)xf.m[k / 3 * 4 + k % 3];
                q = v3_sub(q, v3_of((double)xf.m[3], (double)xf.m[7], (double)xf.m[11]));
                e[0] = v3_of(m[0], m[3], m[6]); e[1] = v3_of(m[1], m[4], m[7]); e[2] = v3_of(m[2], m[5], m[8]);
                det = v3_dot(e[0], v3_cross(e[1], e[2]));
                q_local = v3_of(v3_dot(q, v3_cross(e[1], e[2])) / det, v3_dot(q, v3_cross(e[2], e[0])) / det, v3_dot(q, v3_cross(e[0], e[1])) / det);
                p = v3_sub(q_local, c);
                local = v3_length(p) - radius;
                n = v3_unit(p);                          /* distances to the surface grow by 1 / |M^-T n| */
                grow = 1 / v3_length(v3_scale(v3_add(v3_add(v3_scale(v3_cross(e[1], e[2]), n.x), v3_scale(v3_cross(e[2], e[0]), n.y)), v3_scale(v3_cross(e[0], e[1]), n.z)), 1 / det));
                worst = fmax(worst, fabs(local) * grow / (double)x.error);
                worst_unit = fmax(worst_unit, fabs(v3_length(v3_from(x.ng)) - 1));
                worst_unit = fmax(worst_unit, fabs(v3_length(v3_from(x.tangent)) - 1));
                worst_unit = fmax(worst_unit, fabs(v3_dot(v3_from(x.tangent), v3_from(x.ns))));
                if (radius * pow(fabs(det), 1.0 / 3) > 1e-2) inwards += v3_dot(v3_from(x.ng), v3_scale(v3_add(v3_add(v3_scale(v3_cross(e[1], e[2]), n.x), v3_scale(v3_cross(e[2], e[0]), n.y)), v3_scale(v3_cross(e[0], e[1]), n.z)), 1 / det)) < 0;
            }
            pt_scene_destroy(s);
            pt_scene_destroy(inner);
        }
        test_case("%s", kind < 0 ? "no instance" : xform_names[kind]);
        CHECK(hits > 1000);
        CHECK_EQ_INT(inwards, 0);
        if (!CHECK(worst < 1)) FAIL("off the sphere by %g times x.error", worst);
        CHECK_NEAR(worst_unit, 0, 1e-6);
    }
}
/* A user's plane y = 0, 2 x 2 wide, solved as anyone would. */
static void plane_bounds(void *user, pt_vec3 *lo, pt_vec3 *hi) { (void)user; *lo = pt_v3(-1, 0, -1); *hi = pt_v3(1, 0, 1); }
static int plane_hit(void *user, const pt_ray *ray, pt_vertex *x) {
    (void)user;
    if (ray->dir.y == 0) return 0;
    x->t = -ray->org.y / ray->dir.y;
    x->ng = pt_v3(0, 1, 0);
    return x->t > ray->tmin && x->t < ray->tmax && fabsf(ray->org.x + x->t * ray->dir.x) <= 1 && fabsf(ray->org.z + x->t * ray->dir.z) <= 1;
}
static void vertices_on_user_shapes(void) {
    pt_shape_vtable v;
    pt_material none = { 0 };
    pt_scene *s = pt_scene_create(NULL);
    pt_rng r;
    double worst = 0;
    int i, hits = 0;
    v.bounds = plane_bounds; v.intersect = plane_hit;
    pt_add_user_shape(s, &v, NULL, none);
    committed(s);
    pt_rng_seed(&r, 9, 1);
    for (i = 0; i < 20000; i++) {
        double distance = magnitude(&r, 1, 1e4);
        v3 org = v3_scale(direction(&r), distance), to = v3_of(between(&r, -1, 1), 0, between(&r, -1, 1));
        pt_ray ray = ray_of(org, v3_unit(v3_sub(to, org)));
        pt_vertex x;
        if (i % 4 == 0) { to = v3_scale(to, 1e-3); ray = ray_of(org, v3_unit(v3_sub(to, org))); }
        if (fabs(org.y) < 0.01 * distance || !pt_intersect(s, &ray, &x)) continue;
        hits++;
        worst = fmax(worst, fabs((double)x.p.y) / (double)x.error);
    }
    CHECK(hits > 10000);
    if (!CHECK(worst < 1)) FAIL("off the plane by %g times x.error", worst);
    pt_scene_destroy(s);
}

/* ---- the next ray gets away ---- */

#define FACTORS 5
static const float factors[FACTORS] = { 1, 0.5f, 0.25f, 0.125f, 1.0f / 16 };
typedef struct escapes { long rays, caught[FACTORS]; } escapes;
/* From x into n random directions of the half space of `normal`, a third of them grazing, with the offset cut to a part. A hit
   on a surface that lies nowhere above its own tangent plane is wrong at any distance. */
static void escape(const pt_scene *s, const pt_vertex *hit, v3 normal, int n, pt_rng *r, escapes *e) {
    int k;
    while (n--) {
        v3 d = direction(r);
        pt_vertex x = *hit;
        pt_ray ray;
        if (n % 3 == 0) d = v3_unit(v3_add(v3_cross(normal, direction(r)), v3_scale(normal, magnitude(r, 1e-7, 1e-1))));
        if (v3_dot(d, normal) < 0) d = v3_scale(d, -1);
        memset(&ray, 0, sizeof ray);
        ray.dir = v3_float(d);
        if (!(v3_dot(v3_from(ray.dir), normal) > 3e-7) || !(pti_dot(ray.dir, x.ng) > 0)) continue;
        e->rays++;
        for (k = 0; k < FACTORS; k++) {
            x.error = hit->error * factors[k];
            ray.org = pti_spawn(&x, ray.dir);
            e->caught[k] += pt_occluded(s, &ray);
        }
    }
}
static void check_escapes(const escapes *e) {
    CHECK(e->rays > 10000);
    CHECK_EQ_INT(e->caught[0], 0);
    if (getenv("PT_TEST_FACTORS"))                       /* how much of the offset is needed */
        printf("    %ld rays, caught at 1, 1/2, 1/4, 1/8, 1/16 of x.error: %ld %ld %ld %ld %ld\n", e->rays, e->caught[0], e->caught[1],
               e->caught[2], e->caught[3], e->caught[4]);
}
static void escape_from_planes(void) {
    pt_rng r;
    int kind, i;
    pt_rng_seed(&r, 10, 1);
    for (kind = 0; kind < 4; kind++) {
        escapes e = { 0, { 0 } };
        for (i = 0; i < 2000; i++) {
            double half = kind == 0 ? 1 : kind == 1 ? 1000 : magnitude(&r, 1e-3, 1e3);
            v3 row[3], c[4], n, to, org, at = v3_of(0, 0, 0);
            mesh m = mesh_new(4, 2);
            pt_scene *s;
            pt_ray ray;
            pt_vertex x;
            int k;
            rotation(&r, row);
            if (kind == 2) at = v3_scale(direction(&r), 1e4);
            if (kind == 3) { row[0] = v3_of(1, 0, 0); row[1] = v3_of(0, 1, 0); row[2] = v3_of(0, 0, 1); at.z = between(&r, -100, 100); }
            for (k = 0; k < 4; k++) {
                c[k] = v3_add(at, v3_add(v3_scale(row[0], k == 0 || k == 3 ? -half : half), v3_scale(row[1], k < 2 ? -half : half)));
                mesh_vertex(&m, c[k].x, c[k].y, c[k].z);
            }
            mesh_triangle(&m, 0, 1, 2);
            if (i % 2) mesh_triangle(&m, 0, 2, 3);       /* one, or two that are coplanar but for rounding */
            s = scene_of(&m);
            for (k = 0; k < 10; k++) {                   /* much of it near the middle, where the coordinates are small */
                double spread = half * (kind == 1 || k % 2 ? magnitude(&r, 1e-5, 0.9) : 0.9);
                to = v3_add(at, v3_add(v3_scale(row[0], between(&r, -spread, spread)), v3_scale(row[1], between(&r, -spread, spread))));
                org = v3_add(to, v3_scale(direction(&r), magnitude(&r, 1e-2, 1e3)));
                ray = ray_of(org, v3_sub(to, org));
                if (!pt_intersect(s, &ray, &x)) continue;
                n = v3_unit(v3_cross(v3_sub(mesh_corner(&m, x.prim, 1), mesh_corner(&m, x.prim, 0)),
                                     v3_sub(mesh_corner(&m, x.prim, 2), mesh_corner(&m, x.prim, 0))));
                if (k % 2) n = v3_scale(n, -1);
                if (!(i % 2)) escape(s, &x, n, 12, &r, &e);
                else {                                   /* its other half is tilted by rounding, so nothing that grazes */
                    int j;
                    for (j = 0; j < 12; j++) {
                        v3 d = direction(&r);
                        if (v3_dot(d, n) < 1e-3) continue;
                        ray = ray_of(v3_of(0, 0, 0), d);
                        ray.org = pti_spawn(&x, ray.dir);
                        e.rays++;
                        e.caught[0] += pt_occluded(s, &ray);
                    }
                }
            }
            pt_scene_destroy(s);
            mesh_free(&m);
        }
        test_case("plane %d", kind);
        check_escapes(&e);
    }
}
static void escape_from_convex(void) {
    pt_rng r;
    int kind, i;
    pt_rng_seed(&r, 11, 1);
    for (kind = -2; kind < XFORMS; kind++) {             /* -2: cube, -1: sphere, else instances of cube and sphere */
        escapes e = { 0, { 0 } };
        for (i = 0; i < 600; i++) {
            v3 row[3], to, org;
            pt_xform xf = pti_xform_or_identity(NULL);
            pt_material none = { 0 };
            int ball_shape = kind == -1 || (kind >= 0 && i % 2), k;
            double size = magnitude(&r, 1e-2, 1e2);
            v3 center = v3_rounded(v3_scale(ball(&r), i % 3 ? 0 : 100));
            mesh m = mesh_cube(1, NULL);
            pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
            rotation(&r, row);
            if (i % 2) mesh_rotate(&m, row);
            mesh_move(&m, size, center);
            if (kind >= 0) xf = random_xform(&r, kind);
            if (ball_shape) pt_add_sphere(inner, v3_float(center), (float)size, none);
            else add_mesh(inner, &m);
            committed(inner);
            pt_add_instance(s, inner, &xf);
            committed(s);
            for (k = 0; k < 20; k++) {
                pt_ray ray;
                pt_vertex x;
                v3 n;
                const pt_scene *seen = kind < 0 ? inner : s;
                to = transform(&xf, v3_add(center, v3_scale(ball(&r), 0.5 * size)));
                org = transform(&xf, v3_add(center, v3_scale(direction(&r), size * magnitude(&r, 2, 100))));
                ray = ray_of(org, v3_sub(to, org));
                if (!pt_intersect(seen, &ray, &x) || pti_dot(x.ng, x.wo) <= 0) continue;
                n = v3_from(x.ng);
                escape(seen, &x, n, 20, &r, &e);
            }
            pt_scene_destroy(s);
            pt_scene_destroy(inner);
            mesh_free(&m);
        }
        test_case("%s", kind == -2 ? "cube" : kind == -1 ? "sphere" : xform_names[kind]);
        check_escapes(&e);
    }
}

void test_shape(void) {
    RUN(triangles_against_double);
    RUN(degenerate_triangles);
    RUN(no_hits_from_afar);
    RUN(watertight_blobs);
    RUN(watertight_cubes);
    RUN(spheres_against_double);
    RUN(sphere_walk);
    RUN(vertices_on_triangles);
    RUN(vertices_on_spheres);
    RUN(vertices_on_user_shapes);
    RUN(escape_from_planes);
    RUN(escape_from_convex);
}
