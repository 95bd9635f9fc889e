/* meshes.h - random numbers, meshes and committed scenes for tests. Include it after pt.h and test.h. All is static inline,
   since no compiler minds when such a function goes unused. */
#ifndef MESHES_H
#define MESHES_H

/* As in pt.h: what tests compute to compare with must not be fused to a b + c either, which compilers like to do on ARM. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* ---- random numbers and vectors in double ---- */

typedef struct v3 { double x, y, z; } v3;
static inline v3 v3_of(double x, double y, double z) { v3 v; v.x = x; v.y = y; v.z = z; return v; }
static inline v3 v3_from(pt_vec3 a) { return v3_of((double)a.x, (double)a.y, (double)a.z); }
static inline pt_vec3 v3_float(v3 a) { return pt_v3((float)a.x, (float)a.y, (float)a.z); }
/* To float and back. volatile, since gcc 12 -O2 loses the rounding where it vectorises the two conversions. */
static inline double rounded(double x) { volatile float f = (float)x; return (double)f; }
static inline v3 v3_rounded(v3 a) { return v3_of(rounded(a.x), rounded(a.y), rounded(a.z)); }
static inline v3 v3_add(v3 a, v3 b) { return v3_of(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline v3 v3_sub(v3 a, v3 b) { return v3_of(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline v3 v3_scale(v3 a, double s) { return v3_of(a.x * s, a.y * s, a.z * s); }
static inline double v3_dot(v3 a, v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline v3 v3_cross(v3 a, v3 b) { return v3_of(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
static inline double v3_length(v3 a) { return sqrt(v3_dot(a, a)); }
static inline v3 v3_unit(v3 a) { return v3_scale(a, 1 / v3_length(a)); }

static inline double uniform(pt_rng *r) { return pt_rng_u32(r) * (1.0 / 4294967296.0); }             /* [0,1) */
static inline double between(pt_rng *r, double a, double b) { return a + (b - a) * uniform(r); }
static inline uint32_t below(pt_rng *r, size_t n) { return (uint32_t)((uint64_t)pt_rng_u32(r) * n >> 32); }
static inline double magnitude(pt_rng *r, double least, double most) {           /* log-uniform */
    return least * pow(most / least, uniform(r));
}
static inline v3 ball(pt_rng *r) {                       /* in the unit ball */
    v3 v;
    do v = v3_of(between(r, -1, 1), between(r, -1, 1), between(r, -1, 1)); while (!(v3_dot(v, v) <= 1 && v3_dot(v, v) > 1e-6));
    return v;
}
static inline v3 direction(pt_rng *r) { return v3_unit(ball(r)); }

/* ---- meshes ---- */

typedef struct mesh { float *p; uint32_t *i; size_t vertices, indices; } mesh;
static inline mesh mesh_new(size_t vertices, size_t triangles) {
    mesh m;
    m.p = (float *)calloc(3 * vertices + 1, sizeof(float));
    m.i = (uint32_t *)calloc(3 * triangles + 1, sizeof(uint32_t));
    m.vertices = m.indices = 0;
    if (!m.p || !m.i) { printf("out of memory\n"); exit(1); }
    return m;
}
static inline void mesh_free(mesh *m) { free(m->p); free(m->i); memset(m, 0, sizeof *m); }
static inline uint32_t mesh_vertex(mesh *m, double x, double y, double z) {
    float *p = m->p + 3 * m->vertices;
    p[0] = (float)x; p[1] = (float)y; p[2] = (float)z;
    return (uint32_t)m->vertices++;
}
static inline void mesh_triangle(mesh *m, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *i = m->i + m->indices;
    i[0] = a; i[1] = b; i[2] = c;
    m->indices += 3;
}
static inline v3 mesh_at(const mesh *m, uint32_t vertex) {
    const float *p = m->p + 3 * vertex;
    return v3_of((double)p[0], (double)p[1], (double)p[2]);
}
static inline v3 mesh_corner(const mesh *m, size_t triangle, size_t corner) { return mesh_at(m, m->i[3 * triangle + corner % 3]); }
static inline void mesh_add_triangle(mesh *m, v3 a, v3 b, v3 c) {      /* with vertices of its own */
    uint32_t i = mesh_vertex(m, a.x, a.y, a.z), j = mesh_vertex(m, b.x, b.y, b.z), k = mesh_vertex(m, c.x, c.y, c.z);
    mesh_triangle(m, i, j, k);
}
static inline void mesh_move(mesh *m, double scale, v3 by) {
    size_t i;
    for (i = 0; i < m->vertices; i++) {
        v3 p = v3_add(v3_scale(mesh_at(m, (uint32_t)i), scale), by);
        m->p[3 * i] = (float)p.x; m->p[3 * i + 1] = (float)p.y; m->p[3 * i + 2] = (float)p.z;
    }
}
/* A rotation matrix about a random axis, by rows. */
static inline void rotation(pt_rng *r, v3 row[3]) {
    v3 a = direction(r), b = direction(r);
    row[0] = a;
    row[1] = v3_unit(v3_cross(a, b));
    row[2] = v3_cross(row[0], row[1]);
}
static inline v3 rotate(const v3 row[3], v3 p) { return v3_of(v3_dot(row[0], p), v3_dot(row[1], p), v3_dot(row[2], p)); }
static inline void mesh_rotate(mesh *m, const v3 row[3]) {
    size_t i;
    for (i = 0; i < m->vertices; i++) {
        v3 p = rotate(row, mesh_at(m, (uint32_t)i));
        m->p[3 * i] = (float)p.x; m->p[3 * i + 1] = (float)p.y; m->p[3 * i + 2] = (float)p.z;
    }
}
/* The cube [-1,1]^3, each face n x n squares of two triangles whose diagonals turn at random; corners are shared. */
static inline mesh mesh_cube(uint32_t n, pt_rng *r) {
    mesh m = mesh_new((size_t)(n + 1) * (n + 1) * (n + 1), (size_t)12 * n * n);
    uint32_t *at = (uint32_t *)calloc((size_t)(n + 1) * (n + 1) * (n + 1), sizeof *at), f, i, j, k;
    if (!at) exit(1);
    for (i = 0; i <= n; i++) for (j = 0; j <= n; j++) for (k = 0; k <= n; k++)
        if (i == 0 || j == 0 || k == 0 || i == n || j == n || k == n)
            at[(i * (n + 1) + j) * (n + 1) + k] = mesh_vertex(&m, 2.0 * i / n - 1, 2.0 * j / n - 1, 2.0 * k / n - 1);
    for (f = 0; f < 6; f++) for (i = 0; i < n; i++) for (j = 0; j < n; j++) {
        uint32_t v[4], q;
        for (q = 0; q < 4; q++) {
            uint32_t c[3];
            c[f / 2] = f % 2 ? n : 0;
            c[(f / 2 + 1) % 3] = i + (q == 1 || q == 2);
            c[(f / 2 + 2) % 3] = j + (q >= 2);
            v[f % 2 ? q : 3 - q] = at[(c[0] * (n + 1) + c[1]) * (n + 1) + c[2]];
        }
        q = r ? pt_rng_u32(r) & 1 : 0;
        mesh_triangle(&m, v[q], v[q + 1], v[q + 2]);
        mesh_triangle(&m, v[q], v[q + 2], v[(q + 3) % 4]);
    }
    free(at);
    return m;
}
/* A sphere of radius 1: the cube above blown up, its vertices moved in and out by up to `bump`. */
static inline mesh mesh_blob(uint32_t n, double bump, pt_rng *r) {
    mesh m = mesh_cube(n, r);
    size_t i;
    for (i = 0; i < m.vertices; i++) {
        v3 p = v3_unit(mesh_at(&m, (uint32_t)i));
        p = v3_scale(p, 1 + between(r, -bump, bump));
        m.p[3 * i] = (float)p.x; m.p[3 * i + 1] = (float)p.y; m.p[3 * i + 2] = (float)p.z;
    }
    return m;
}

/* ---- scenes ---- */

static inline pt_shape add_mesh(pt_scene *s, const mesh *m) {
    pt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = m->p; d.vertex_count = m->vertices; d.indices = m->i; d.index_count = m->indices;
    return pt_add_mesh(s, &d);
}
static inline pt_scene *committed(pt_scene *s) {
    if (pt_scene_commit(s) != PT_OK) FAIL("commit: %s", pt_scene_error(s));
    return s;
}
static inline pt_scene *scene_of(const mesh *m) {
    pt_scene *s = pt_scene_create(NULL);
    add_mesh(s, m);
    return committed(s);
}
static inline pt_ray ray_of(v3 org, v3 dir) {
    pt_ray r;
    memset(&r, 0, sizeof r);
    r.org = v3_float(org);
    r.dir = v3_float(dir);
    return r;
}

/* ---- brute force: every primitive, by the definition of nearest and the rule for ties ---- */

static inline void brute_geometry(const pti_geometry *g, const pti_ray *r, pti_hit *hit, uint32_t instance, uint32_t instance_prim) {
    size_t i;
    uint32_t k;
    for (i = 0; i < g->shape_count; i++) {
        const pti_shape *s = g->shapes + i;
        if (s->kind == PTI_INSTANCE) {
            pti_instance moved;
            const pti_instance *in = pti_instance_at(&s->as.instance, r->time, &moved);
            pti_ray local;
            pti_ray_prepare(&local, pti_xform_point(&in->to_local, pt_v3(r->org[0], r->org[1], r->org[2])),
                            pti_xform_vector(&in->to_local, pt_v3(r->dir[0], r->dir[1], r->dir[2])), r->tmin, r->time, 0);
            brute_geometry(in->of, &local, hit, (uint32_t)i + 1, s->first);
            continue;
        }
        for (k = 0; k < s->count; k++) {
            uint32_t prim = s->first + k, outer = instance ? instance_prim : prim;
            float t, u = 0, v = 0;
            if (s->kind == PTI_MESH) {
                pti_packet p;
                pti_lanes at;
                pt_vec3 c[3];
                int corner;
                memset(&p, 0, sizeof p);
                pti_mesh_triangle(&s->as.mesh, k, c);
                if (pti_is_zero3(pti_cross(pti_sub(c[1], c[0]), pti_sub(c[2], c[0])))) continue;
                for (corner = 0; corner < 3; corner++) {
                    p.v[corner][0][0] = c[corner].x; p.v[corner][1][0] = c[corner].y; p.v[corner][2][0] = c[corner].z;
                }
                if (!pti_triangle(&p, 0, r, &at)) continue;
                t = at.t[0]; u = at.V[0] / at.det[0]; v = at.W[0] / at.det[0];
            } else if (s->kind == PTI_SPHERE) {
                if (!pti_sphere_hit(&s->as.sphere, r, FLT_MAX, &t)) continue;
            } else {
                pt_ray ray;
                pt_vertex x;
                memset(&x, 0, sizeof x);
                ray.org = pt_v3(r->org[0], r->org[1], r->org[2]);
                ray.dir = pt_v3(r->dir[0], r->dir[1], r->dir[2]);
                ray.tmin = r->tmin; ray.tmax = FLT_MAX; ray.time = r->time;
                if (!s->as.user.vtable.intersect(s->as.user.user, &ray, &x)) continue;
                t = x.t; u = x.u; v = x.v;
            }
            if (!(t > r->tmin) || !(t < hit->t || (t == hit->t && hit->found
                && (outer < hit->outer || (outer == hit->outer && prim < hit->prim))))) continue;
            hit->found = 1; hit->t = t; hit->u = u; hit->v = v;
            hit->outer = outer; hit->prim = prim; hit->instance = instance;
            hit->shape = s->kind == PTI_MESH ? 0 : (uint32_t)i + 1;
        }
    }
}
static inline int same_hit(const pti_hit *a, const pti_hit *b) {
    if (a->found != b->found) return 0;
    return !a->found || (!memcmp(&a->t, &b->t, 4) && !memcmp(&a->u, &b->u, 4) && !memcmp(&a->v, &b->v, 4)
                         && a->outer == b->outer && a->prim == b->prim && a->instance == b->instance && a->shape == b->shape);
}
#endif
