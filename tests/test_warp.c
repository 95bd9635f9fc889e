/* >>warp: every sample against its density, solid angles against closed forms, strata against their images. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"

static void two(pt_rng *rng, float *u, float *v) { *u = pt_rng_float(rng); *v = pt_rng_float(rng); }

/* ---- disk, cones and what is made of them ---- */

static int disk_sample(void *ctx, pt_rng *rng, float xy[2]) {
    float u, v;
    (void)ctx;
    two(rng, &u, &v);
    pti_sample_disk(u, v, &xy[0], &xy[1]);
    return 1;
}
static double disk_pdf(void *ctx, float x, float y) {
    (void)ctx;
    return (double)x * x + (double)y * y <= 1 + 1e-6 ? pti_pdf_disk() : 0;
}
static void disk(void) {
    chi2_square_desc d;
    memset(&d, 0, sizeof d);
    d.sample = disk_sample; d.pdf = disk_pdf;
    d.x0 = d.y0 = -1.01; d.x1 = d.y1 = 1.01;
    chi2_square(&d);
}

typedef struct round_shape { pt_vec3 (*sample)(float u, float v); double (*pdf)(pt_vec3 w); float cone; } round_shape;
static int round_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    const round_shape *r = (const round_shape *)ctx;
    float u, v;
    two(rng, &u, &v);
    *wi = r->sample ? r->sample(u, v) : pti_sample_cone(r->cone, u, v);
    return 1;
}
static double round_pdf(void *ctx, pt_vec3 w) {
    const round_shape *r = (const round_shape *)ctx;
    double z = w.z - 1.0, h = ((double)w.x * w.x + (double)w.y * w.y + z * z) / 2;      /* 1 - cos */
    if (r->pdf) return r->pdf(w);
    return h <= r->cone * (1 + 1e-5) ? pti_pdf_cone(r->cone) : 0;
}
static double cosine_pdf(pt_vec3 w)     { return pti_pdf_cosine(w.z); }
static double hemisphere_pdf(pt_vec3 w) { return pti_pdf_hemisphere(w.z); }
static double sphere_pdf(pt_vec3 w)     { (void)w; return pti_pdf_sphere(); }

static void hemispheres_and_spheres(void) {
    static round_shape shapes[] = { { pti_sample_cosine, cosine_pdf, 0 }, { pti_sample_hemisphere, hemisphere_pdf, 0 },
                                    { pti_sample_sphere, sphere_pdf, 0 }, { NULL, NULL, 2 }, { NULL, NULL, 1 } };
    chi2_directions_desc d;
    int k, tilt;
    for (k = 0; k < 5; k++)
        for (tilt = 0; tilt < 3; tilt++) {
            test_case("shape %d, grid %d", k, tilt);
            memset(&d, 0, sizeof d);
            d.sample = round_sample; d.pdf = round_pdf; d.ctx = &shapes[k];
            d.ax = tilt * 0.7; d.ay = tilt * 0.4; d.az = tilt == 2 ? -0.3 : 1;
            d.seed = (uint64_t)tilt;
            chi2_directions(&d);
        }
    CHECK(pti_pdf_cosine(-0.5f) == 0 && pti_pdf_cosine(0) == 0 && pti_pdf_hemisphere(-1e-3f) == 0);
}
static void cones(void) {
    static const float sizes[] = { 1.5f, 0.3f, 0.01f, 1e-4f, 1e-6f, 1e-8f };
    chi2_directions_desc d;
    round_shape shape = { NULL, NULL, 0 };
    int k, tilt;
    for (k = 0; k < 6; k++)
        for (tilt = 0; tilt < 2; tilt++) {
            double angle = acos(1 - (double)sizes[k]);
            test_case("1 - cos = %g, grid %d", (double)sizes[k], tilt);
            memset(&d, 0, sizeof d);
            shape.cone = sizes[k];
            d.sample = round_sample; d.pdf = round_pdf; d.ctx = &shape;
            d.zoom = tilt ? fmin(1 - cos(fmin(1.5 * angle, 3.1)), 2) : sizes[k] * 1.001;  /* all of it, and its rim */
            if (sizes[k] < 1e-5f) d.zoom = angle * angle * (tilt ? 1.125 : 0.5005);
            d.ax = tilt ? sin(angle * 0.4) : 0; d.az = cos(tilt ? angle * 0.4 : 0);
            if (sizes[k] < 1e-7f) d.tolerance = 0.01;    /* a float's last place is 1/2000 of the angle */
            chi2_directions(&d);
        }
}

/* ---- spherical triangles ---- */

typedef struct dvec { double x, y, z; } dvec;
static dvec dv(double x, double y, double z) { dvec v; v.x = x; v.y = y; v.z = z; return v; }
static dvec dof3(pt_vec3 a) { return dv(a.x, a.y, a.z); }
static dvec dsub(dvec a, dvec b) { return dv(a.x - b.x, a.y - b.y, a.z - b.z); }
static double ddot(dvec a, dvec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static dvec dcross(dvec a, dvec b) { return dv(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
static dvec dunit(dvec a) { double l = sqrt(ddot(a, a)); return dv(a.x / l, a.y / l, a.z / l); }
/* By another formula than the header's, in double: the sum of the angles less pi; each from edges, by atan2. */
static double corner_angle(dvec a, dvec b, dvec c) {
    dvec t = dcross(dsub(b, a), a), s = dcross(dsub(c, a), a);
    return atan2(sqrt(ddot(dcross(t, s), dcross(t, s))), ddot(t, s));
}
static double angles_less_pi(dvec a, dvec b, dvec c) {
    return corner_angle(a, b, c) + corner_angle(b, c, a) + corner_angle(c, a, b) - STATS_PI;
}

typedef struct triangle { pt_vec3 a, b, c; float S; double slack; dvec n[3]; } triangle;   /* n: into it, from each side */
static triangle triangle_of(dvec a, dvec b, dvec c) {
    triangle t;
    dvec p[3];
    int k;
    a = dunit(a); b = dunit(b); c = dunit(c);
    t.a = pti_normalize(pt_v3((float)a.x, (float)a.y, (float)a.z));
    t.b = pti_normalize(pt_v3((float)b.x, (float)b.y, (float)b.z));
    t.c = pti_normalize(pt_v3((float)c.x, (float)c.y, (float)c.z));
    t.S = pti_triangle_solid_angle(t.a, t.b, t.c);
    t.slack = 2e-7;                                      /* rounding of what is drawn */
    p[0] = dof3(t.a); p[1] = dof3(t.b); p[2] = dof3(t.c);
    for (k = 0; k < 3; k++) {
        dvec q = p[k], e = dsub(p[(k + 1) % 3], q);
        t.n[k] = dunit(dcross(q, e));
        if (ddot(t.n[k], p[(k + 2) % 3]) < 0) t.n[k] = dv(-t.n[k].x, -t.n[k].y, -t.n[k].z);
    }
    return t;
}
static int triangle_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    const triangle *t = (const triangle *)ctx;
    float u, v;
    two(rng, &u, &v);
    *wi = pti_sample_triangle(t->a, t->b, t->c, t->S, u, v);
    return 1;
}
static double triangle_pdf(void *ctx, pt_vec3 w) {
    const triangle *t = (const triangle *)ctx;
    int k;
    for (k = 0; k < 3; k++) if (ddot(t->n[k], dof3(w)) < -t->slack) return 0;
    return pti_pdf_triangle(t->S);
}
static double distance2(dvec a, dvec b) { dvec d = dsub(a, b); return ddot(d, d); }
static void triangle_test(triangle t, uint64_t seed) {
    chi2_directions_desc d;
    dvec a = dof3(t.a), b = dof3(t.b), c = dof3(t.c), m = dunit(dv(a.x + b.x + c.x, a.y + b.y + c.y, a.z + b.z + c.z));
    double reach = sqrt(fmax(distance2(a, m), fmax(distance2(b, m), distance2(c, m))));
    double around = sqrt(distance2(a, b)) + sqrt(distance2(b, c)) + sqrt(distance2(c, a));
    memset(&d, 0, sizeof d);
    d.sample = triangle_sample; d.pdf = triangle_pdf; d.ctx = &t; d.seed = seed; d.n = 40000;
    d.ax = m.x + 0.2 * reach; d.ay = m.y - 0.1 * reach; d.az = m.z + 0.1 * reach;          /* off its middle */
    d.zoom = reach < 1 ? 0.5 * reach * reach * 1.7 : 2;
    d.tolerance = 0.002 + 1.5 * around * t.slack / t.S;                /* the slack widens it by so much */
    chi2_directions(&d);
}
static void triangles_of_all_shapes(void) {
    static const struct { const char *name; double p[9]; } shapes[] = {
        { "octant",       { 1, 0, 0,  0, 1, 0,  0, 0, 1 } },
        { "left-handed",  { 1, 0, 0,  0, 0, 1,  0, 1, 0 } },
        { "near 2 pi",    { 1, 0, 0.01,  -0.5, 0.87, 0.01,  -0.5, -0.87, 0.01 } },
        { "nearer",       { 1, 0, 0.0005,  -0.3, 0.87, 0.0003,  -0.5, -0.87, 0.0004 } },
        { "beyond pi",    { 1, 0.1, 0.2,  -0.9, 0.3, 0.3,  0.1, -1, 0.1 } },
        { "half a lune",  { 1, 0, 0,  -1, 0.02, 0.1,  0, 1, 0.3 } },
        { "one short",    { 1, 0, 0,  0.999, 0.02, 0,  0, 0.5, 1 } },
        { "sliver, long", { 1, 0, 0,  0, 1, 0.002,  -0.5, 0.5, 0 } },
        { "sliver",       { 1, 0, 1,  1, 0.001, 1,  1, 0, 0 } },
        { "obtuse",       { 1, 0, 1,  0, 0.02, 1,  -1, 0, 1 } },
        { "its obtuse corner first", { 0, 0.02, 1,  1, 0, 1,  -1, 0, 1 } },
        { "its obtuse corner last",  { 1, 0, 1,  -1, 0, 1,  0, 0.02, 1 } } };
    int k;
    for (k = 0; k < (int)(sizeof shapes / sizeof shapes[0]); k++) {
        const double *p = shapes[k].p;
        test_case("%s", shapes[k].name);
        triangle_test(triangle_of(dv(p[0], p[1], p[2]), dv(p[3], p[4], p[5]), dv(p[6], p[7], p[8])), (uint64_t)k);
    }
}
static triangle random_triangle(pt_rng *rng, double size) {
    double p[12];
    int k;
    for (k = 0; k < 12; k++) p[k] = pt_rng_float(rng) * 2 - 1;
    if (size > 0) for (k = 0; k < 9; k++) p[k] = p[9 + k % 3] + size * p[k];
    return triangle_of(dv(p[0], p[1], p[2]), dv(p[3], p[4], p[5]), dv(p[6], p[7], p[8]));
}
/* Down to 1e-8 sr: there a float direction's last place is a thousandth of the triangle. */
static void triangles_of_all_sizes(void) {
    static const double sizes[] = { 0, 0, 0, 0, 0.5, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4 };
    pt_rng rng;
    int k, i;
    pt_rng_seed(&rng, 1, 3);
    for (k = 0; k < 11; k++)
        for (i = 0; i < 2; i++) {
            triangle t = random_triangle(&rng, sizes[k]);
            if (t.S < 0.1 * sizes[k] * sizes[k]) { i--; continue; }    /* slivers have their own test */
            test_case("size %g, number %d, S = %g", sizes[k], i, (double)t.S);
            triangle_test(t, (uint64_t)k);
        }
}
/* Where (u, v) goes is where Arvo's map would put it: undone in double, the numbers come back. */
static void triangle_map_is_arvos(void) {
    static const double sizes[] = { 0, 0.1, 0.01, 1e-3, 1e-4 };
    pt_rng rng;
    int k, i;
    pt_rng_seed(&rng, 2, 3);
    for (k = 0; k < 5; k++)
        for (i = 0; i < 4000; i++) {
            triangle t = random_triangle(&rng, sizes[k]);
            dvec a = dof3(t.a), b = dof3(t.b), c = dof3(t.c), w, m;
            float u, v;
            double S = angles_less_pi(a, b, c), allowed = sizes[k] > 0 ? 2e-6 / sizes[k] : 1e-5;
            if (S < (sizes[k] > 0 ? 0.3 * sizes[k] * sizes[k] : 0.3) || S > 5) continue;
            two(&rng, &u, &v);
            v = v * 0.9f + 0.1f;                         /* on b itself, u cannot come back */
            w = dunit(dof3(pti_sample_triangle(t.a, t.b, t.c, t.S, u, v)));
            m = dunit(dcross(dcross(b, w), dcross(c, a)));             /* where the arc from b meets a c */
            if (ddot(m, a) + ddot(m, c) < 0) m = dv(-m.x, -m.y, -m.z);
            test_case("size %g, S = %g", sizes[k], S);
            CHECK_NEAR(angles_less_pi(a, b, m) / S, u, 5 * allowed);
            CHECK_NEAR(distance2(b, w) / distance2(b, m), v, 5 * allowed);
        }
}
static void triangle_solid_angles(void) {
    pt_rng rng;
    int k, i;
    float S;
    triangle t = triangle_of(dv(1, 0, 0), dv(0, 1, 0), dv(0, 0, 1));
    CHECK_NEAR(t.S, STATS_PI / 2, 2e-7);
    t = triangle_of(dv(1, 0, 0), dv(-1, 1e-3, 0), dv(0, 0, 1));       /* a quarter of the sphere, nearly */
    CHECK_NEAR(t.S, STATS_PI, 2e-3);
    t = triangle_of(dv(1, 1, 1), dv(1, -1, 1), dv(1, 1, -1));         /* half a cube's face */
    CHECK_NEAR(t.S, STATS_PI / 3, 5e-7);
    t = triangle_of(dv(1, 0, 0), dv(-0.5, 0.8660254, 0), dv(-0.5, -0.8660254, 0));
    CHECK_NEAR(t.S, 2 * STATS_PI, 1e-6);                 /* all round the equator */
    t = triangle_of(dv(1, 0, 0), dv(1, 0, 0), dv(0, 1, 0));
    CHECK(t.S == 0);
    t = triangle_of(dv(0, 0, 1), dv(1e-4, 0, 1), dv(0, 1e-4, 1));
    CHECK_NEAR(t.S / 5e-9, 1, 1e-6);
    pt_rng_seed(&rng, 3, 3);
    for (i = 0; i < 20000; i++) {
        double size = pow(10, -(i % 5));
        t = random_triangle(&rng, i % 5 ? size : 0);
        if (i % 5 && t.S < 0.02 * size * size) continue;
        S = (float)angles_less_pi(dof3(t.a), dof3(t.b), dof3(t.c));
        /* the corners' own rounding, and that three angles less pi is wrong by some 1e-15 */
        test_case("size %g", size);
        CHECK_NEAR(t.S / S, 1, 1e-5 + 1e-14 / t.S + (i % 5 ? 0 : 5e-6 / t.S));
        S = pti_triangle_solid_angle(t.c, t.b, t.a);     /* no matter from where, and which way round */
        CHECK_NEAR(S / t.S, 1, 1e-5 + (i % 5 ? 0 : 5e-6 / t.S));
    }
    for (i = 0; i < 500; i++) {                          /* a tetrahedron around the eye: four faces are the whole sphere */
        dvec p[4], n;
        double sum = 0;
        int inside = 1;
        for (k = 0; k < 4; k++) p[k] = dof3(pti_sub(stats_uniform3(&rng), pt_v3(0.5f, 0.5f, 0.5f)));
        for (k = 0; k < 4; k++) {
            n = dcross(dsub(p[(k + 1) % 4], p[k]), dsub(p[(k + 2) % 4], p[k]));
            inside = inside && ddot(n, dsub(p[(k + 3) % 4], p[k])) * -ddot(n, p[k]) > 0;
            sum += triangle_of(p[k], p[(k + 1) % 4], p[(k + 2) % 4]).S;
        }
        if (inside) CHECK_NEAR(sum, 4 * STATS_PI, 2e-5);
        else CHECK(sum < 4 * STATS_PI + 2e-5);
    }
}

/* ---- rectangles ---- */

typedef struct rectangle { pti_rect_frame frame; pti_rect r; float S; dvec corner, x, y, n; double slack; } rectangle;
static rectangle rectangle_of(dvec o, dvec corner, dvec x, dvec y) {
    rectangle q;
    q.corner = dsub(corner, o);
    q.frame = pti_rect_frame_of(pt_v3((float)x.x, (float)x.y, (float)x.z), pt_v3((float)y.x, (float)y.y, (float)y.z));
    q.r = pti_rect_seen_from(&q.frame, pt_v3((float)q.corner.x, (float)q.corner.y, (float)q.corner.z));
    q.S = pti_rect_solid_angle(&q.r);
    q.x = x; q.y = y;
    q.n = dcross(x, y);
    q.slack = 1e-5 + 1e-7 / fmin(sqrt(ddot(x, x)), sqrt(ddot(y, y)));  /* rounding of what is drawn */
    return q;
}
static int rectangle_at(void *ctx, float u, float v, pt_vec3 *w) {
    const rectangle *q = (const rectangle *)ctx;
    pti_rect r = q->r;
    r.frame = &q->frame;                                 /* rectangles are passed by value */
    *w = pti_normalize(pti_sample_rect(&r, q->S, u, v));
    return 1;
}
static int rectangle_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    float u, v;
    two(rng, &u, &v);
    return rectangle_at(ctx, u, v, wi);
}
static double rectangle_pdf(void *ctx, pt_vec3 w) {
    const rectangle *q = (const rectangle *)ctx;
    dvec d = dof3(w), p;
    double t = ddot(q->corner, q->n) / ddot(d, q->n), u, v;
    if (!(t > 0) || t > 1e30) return 0;
    p = dsub(dv(d.x * t, d.y * t, d.z * t), q->corner);
    u = ddot(p, q->x) / ddot(q->x, q->x);
    v = ddot(p, q->y) / ddot(q->y, q->y);
    return u >= -q->slack && u <= 1 + q->slack && v >= -q->slack && v <= 1 + q->slack ? pti_pdf_rect(q->S) : 0;
}
static const struct { const char *name; double o[3], c[3], x[3], y[3], zoom; } rectangles[] = {
    { "a cube's face",   { 0, 0, 0 }, { 1, -1, -1 }, { 0, 2, 0 }, { 0, 0, 2 }, 0 },
    { "from its back",   { 0, 0, 0 }, { 1, -1, -1 }, { 0, 0, 2 }, { 0, 2, 0 }, 0 },
    { "turned",          { 0.3, 0.1, -0.2 }, { 1, 1, 0 }, { -1, 1, 0.5 }, { 1, 0.5, 1 }, 0 },
    { "near 2 pi",       { 0.5, 0.5, 0.001 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, 0 },
    { "huge",            { 3, 2, 1 }, { -1000, -1000, 0 }, { 2000, 0, 0 }, { 0, 2000, 0 }, 0 },
    { "grazing",         { -1, 0.5, 0.01 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, 0.3 },
    { "more grazing",    { -1, 0.5, 0.0005 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, 0.3 },
    { "above an edge",   { 0, 0.5, 0.1 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, 0 },
    { "above a corner",  { 0, 0, 0.1 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, 0 },
    { "a strip",         { 0.5, 0.0005, 1 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0.001, 0 }, 0.3 },
    { "a strip, grazing", { -0.5, 0.3, 0.1 }, { 0, 0, 0 }, { 0, 1, 0 }, { 0.002, 0, 0 }, 0.5 },
    { "1e-4 sr",         { 1, 2, 3 }, { 0, 0, 0 }, { 0.04, 0, 0 }, { 0, 0.04, 0 }, 2e-4 },
    { "1e-6 sr",         { 1, 2, 3 }, { 0, 0, 0 }, { 0.004, 0, 0 }, { 0, 0.004, 0 }, 2e-6 },
    { "1e-7 sr",         { 0.3, 2, -3 }, { 0, 0, 0 }, { 0, 0.0015, 0 }, { 0, 0, 0.0015 }, 2e-7 } };
#define RECTANGLES ((int)(sizeof rectangles / sizeof rectangles[0]))
static rectangle rectangle_number(int k) {
    const double *o = rectangles[k].o, *c = rectangles[k].c, *x = rectangles[k].x, *y = rectangles[k].y;
    return rectangle_of(dv(o[0], o[1], o[2]), dv(c[0], c[1], c[2]), dv(x[0], x[1], x[2]), dv(y[0], y[1], y[2]));
}
static void rectangles_of_all_shapes(void) {
    int k;
    for (k = 0; k < RECTANGLES; k++) {
        rectangle q = rectangle_number(k);
        chi2_directions_desc d;
        dvec m = dv(q.corner.x + (q.x.x + q.y.x) / 2, q.corner.y + (q.x.y + q.y.y) / 2, q.corner.z + (q.x.z + q.y.z) / 2);
        test_case("%s, S = %g", rectangles[k].name, (double)q.S);
        memset(&d, 0, sizeof d);
        d.sample = rectangle_sample; d.pdf = rectangle_pdf; d.ctx = &q; d.seed = (uint64_t)k; d.n = 40000;
        d.zoom = rectangles[k].zoom;
        m = dunit(m);
        d.ax = m.x; d.ay = m.y; d.az = m.z;
        if (d.zoom == 0) d.ax += 0.3;
        else d.ay += 0.1 * sqrt(d.zoom);
        if (q.S < 1e-3f) { q.slack = 4e-7 / sqrt(q.S); d.tolerance = 0.002 + 5 * q.slack; }
        chi2_directions(&d);
    }
}
static void rectangle_solid_angles(void) {
    pt_rng rng;
    int i, k;
    rectangle q = rectangle_number(0);
    CHECK_NEAR(q.S, 2 * STATS_PI / 3, 3e-7);             /* one of six */
    q = rectangle_number(1);
    CHECK_NEAR(q.S, 2 * STATS_PI / 3, 3e-7);
    q = rectangle_of(dv(0, 0, 1), dv(0, 0, 0), dv(1, 0, 0), dv(0, 1, 0));
    CHECK_NEAR(q.S, asin(0.5), 1e-7);                    /* above a corner: asin(a b / sqrt((a^2 + d^2)(b^2 + d^2))) */
    q = rectangle_of(dv(50, 50, 1e-4), dv(0, 0, 0), dv(100, 0, 0), dv(0, 100, 0));
    CHECK_NEAR(q.S, 2 * STATS_PI, 2e-5);
    q = rectangle_of(dv(0, 0, 100), dv(-0.01, -0.01, 0), dv(0.02, 0, 0), dv(0, 0.02, 0));
    CHECK_NEAR(q.S / 4e-8, 1, 1e-5);                     /* area over distance squared */
    q = rectangle_of(dv(-1, 0.5, 0), dv(0, 0, 0), dv(1, 0, 0), dv(0, 1, 0));
    CHECK(q.S == 0);                                     /* edge-on */
    pt_rng_seed(&rng, 4, 3);
    for (i = 0; i < 5000; i++) {                         /* ever farther, ever more grazing: never negative, never 2 pi */
        double far = pow(10, i % 9), z = far * pow(10, -(i % 7) * 1.5), l2, expected;
        pt_vec3 at = stats_uniform3(&rng);
        dvec c = dv((at.x * 2 - 1) * far, (at.y * 2 - 1) * far, -z);
        q = rectangle_of(dv(0, 0, 0), c, dv(1e-3, 0, 0), dv(0, 1e-3, 0));
        if (fmin(fabs(c.x), fabs(c.y)) < 0.01 * far) continue;
        l2 = ddot(c, c);
        expected = 1e-6 * z / (l2 * sqrt(l2));
        test_case("at %g, height %g", far, z);
        CHECK(q.S >= 0);
        CHECK_NEAR(q.S, expected, expected * (5e-3 / fmin(fabs(c.x), fabs(c.y)) + 1e-3 / z + 1e-5) + 2e-15);
    }
    test_case("six faces");
    for (i = 0; i < 2000; i++) {                         /* a box around the eye: six faces are the whole sphere */
        double lo[3], hi[3], sum = 0;
        for (k = 0; k < 3; k++) { lo[k] = -pt_rng_float(&rng) - 0.01; hi[k] = pt_rng_float(&rng) + 0.01; }
        for (k = 0; k < 6; k++) {
            double c[3], x[3] = { 0, 0, 0 }, y[3] = { 0, 0, 0 };
            int a = k / 2, b = (a + 1) % 3, e = (a + 2) % 3;
            memcpy(c, lo, sizeof c);
            if (k & 1) c[a] = hi[a];
            x[b] = hi[b] - lo[b];
            y[e] = hi[e] - lo[e];
            sum += rectangle_of(dv(0, 0, 0), dv(c[0], c[1], c[2]), dv(x[0], x[1], x[2]), dv(y[0], y[1], y[2])).S;
        }
        CHECK_NEAR(sum, 4 * STATS_PI, 1e-5);
    }
    test_case("two triangles");
    for (i = 0; i < 2000; i++) {
        double lx = pt_rng_float(&rng) + 0.01, ly = pt_rng_float(&rng) + 0.01, two_of;
        pt_vec3 at = stats_uniform3(&rng);
        dvec c = dv(at.x * 4 - 2, at.y * 4 - 2, at.z + 0.1);
        q = rectangle_of(dv(0, 0, 0), c, dv(lx, 0, 0), dv(0, ly, 0));
        two_of = triangle_of(c, dv(c.x + lx, c.y, c.z), dv(c.x, c.y + ly, c.z)).S
               + triangle_of(dv(c.x + lx, c.y, c.z), dv(c.x, c.y + ly, c.z), dv(c.x + lx, c.y + ly, c.z)).S;
        CHECK_NEAR(two_of / q.S, 1, 5e-5);
    }
}

/* ---- tables ---- */

static void tables(void) {
    static const struct { int n; float value[9]; } cases[] = {
        { 1, { 3 } }, { 1, { 0 } }, { 4, { 1, 2, 3, 4 } }, { 4, { 0, 0, 5, 0 } }, { 5, { 0, 0, 0, 0, 0 } },
        { 3, { 0, 1, 0 } },
        { 9, { 1e-6f, 0, 1, 0, 0, 1e6f, 3, 0, 0 } }, { 7, { 1, 0, 1, 0, 1, 0, 1 } }, { 2, { 1e-30f, 1e-30f } },
        { 8, { 1e30f, 2e30f, 0, 1e30f, 3e38f, 3e38f, 3e38f, 0 } } };
    pt_rng rng;
    int k, i;
    pt_rng_seed(&rng, 5, 3);
    for (k = 0; k < (int)(sizeof cases / sizeof cases[0]); k++) {
        int n = cases[k].n, cell, wrong = 0;
        float table[10];
        double sum = 0, total = 0;
        stats_cell cells[9];
        test_case("table %d", k);
        pti_table_build(table, cases[k].value, n);
        CHECK(table[0] == 0 && table[n] == 1);
        for (i = 0; i < n; i++) sum += cases[k].value[i];
        for (i = 0; i < n; i++) {
            double p = sum > 0 ? cases[k].value[i] / sum : 1.0 / n;
            CHECK_NEAR(pti_pdf_table(table, n, i), p * n, 1e-6 * n);
            if (p == 0) CHECK(pti_pdf_table(table, n, i) == 0);
            total += pti_pdf_table(table, n, i) / (double)n;
            cells[i].observed = 0;
            cells[i].expected = 100000 * p;
        }
        CHECK_NEAR(total, 1, 1e-6);
        for (i = 0; i < 100002; i++) {
            float u = i < 100000 ? pt_rng_float(&rng) : i == 100000 ? 0 : 0.99999994f;
            float x = pti_sample_table(table, n, u, &cell);
            if (!(x >= 0 && x < 1 && (int)(x * (float)n) == cell && pti_pdf_table(table, n, cell) > 0)) wrong++;
            else if (i < 100000) cells[cell].observed++;
        }
        CHECK_EQ_INT(wrong, 0);
        CHECK_P(stats_chi2(cells, n));
    }
}
/* The place drawn is in the cell drawn, to the last bit: rounding must not carry it into a neighbour with density 0. */
static void table_places(void) {
    static const int sizes[] = { 3, 49, 100, 256, 1000, 4096, 16384 };
    static float value[16384], table[16385];
    int k, i, cell;
    for (k = 0; k < 7; k++) {
        int n = sizes[k], wrong = 0, falling = 0;
        float last = -1;
        for (i = 0; i < n; i++) value[i] = (float)(i % 3 == 1 ? 0 : 1 + i % 7);
        pti_table_build(table, value, n);
        for (i = 0; i < 1 << 24; i += i < 1 << 12 || i > (1 << 24) - (1 << 12) ? 1 : 61) {
            float x = pti_sample_table(table, n, (float)i / 16777216, &cell);
            wrong += !(x >= 0 && x < 1 && (int)(x * (float)n) == cell && value[cell] > 0);
            falling += (int)(x * (float)n) < (int)(last * (float)n);   /* strata stay in order */
            last = x;
        }
        test_case("%d cells", n);
        CHECK_EQ_INT(wrong, 0);
        CHECK_EQ_INT(falling, 0);
    }
}
typedef struct grid { float rows[16], cells[16 * 16]; pti_table2 t; } grid;
static void grid_build(grid *g, const float *value, int width, int height) {       /* as the environment light does */
    float sums[16];
    int x, y;
    g->t.rows = g->rows; g->t.cells = g->cells; g->t.width = width; g->t.height = height;
    for (y = 0; y < height; y++) {
        sums[y] = 0;
        for (x = 0; x < width; x++) sums[y] += value[y * width + x];
        pti_table_build(g->cells + y * (width + 1), value + y * width, width);
    }
    pti_table_build(g->rows, sums, height);
}
static int grid_sample(void *ctx, pt_rng *rng, float xy[2]) {
    float u, v;
    two(rng, &u, &v);
    pti_sample_table2(&((grid *)ctx)->t, u, v, &xy[0], &xy[1]);
    return 1;
}
static double grid_pdf(void *ctx, float x, float y) { return pti_pdf_table2(&((grid *)ctx)->t, x, y); }
static void tables_in_two_dimensions(void) {
    static const struct { int width, height; float value[20]; } cases[] = {
        { 4, 3, { 1, 2, 3, 4, 0, 0, 0, 0, 0, 9, 0, 1 } },              /* a row of zeros */
        { 3, 5, { 0, 0, 0, 0, 0, 0, 0, 0, 1, 5, 0, 0, 0, 0, 0 } },
        { 5, 3, { 0 } },                                               /* all zero: uniform */
        { 1, 4, { 1, 0, 2, 3 } },
        { 7, 2, { 1e-3f, 0, 100, 0, 1e-3f, 0, 3, 1, 1, 1, 1, 1, 1, 1 } } };
    static grid g;
    chi2_square_desc d;
    int k, x, y;
    for (k = 0; k < 5; k++) {
        int w = cases[k].width, h = cases[k].height;
        double sum = 0;
        grid_build(&g, cases[k].value, w, h);
        test_case("table %d, %d x %d", k, w, h);
        memset(&d, 0, sizeof d);
        d.sample = grid_sample; d.pdf = grid_pdf; d.ctx = &g;
        d.cells_x = w * (20 / w + 1); d.cells_y = h * (20 / h + 1);
        d.seed = (uint64_t)k;
        chi2_square(&d);
        for (x = 0; x < w * h; x++) sum += cases[k].value[x];
        for (y = 0; y < h; y++)
            for (x = 0; x < w; x++)
                CHECK_NEAR(pti_pdf_table2(&g.t, ((float)x + 0.5f) / (float)w, ((float)y + 0.5f) / (float)h),
                           sum > 0 ? cases[k].value[y * w + x] / sum * w * h : 1, 1e-5);
        CHECK(pti_pdf_table2(&g.t, 1, 1) >= 0 && pti_pdf_table2(&g.t, -0.1f, 2) >= 0);     /* the nearest cell's */
    }
}

/* ---- strata ---- */

static int by_place(const void *a, const void *b) { return memcmp(a, b, sizeof(pt_vec3)); }
/* The middles of an n x n grid land all on different places, all of them where the density is positive; so do the corners
   of the unit square, as far as [0,1) has any. */
#define SIDE 48
static void strata_test(int (*sample)(void *, float, float, pt_vec3 *), double (*pdf)(void *, pt_vec3), void *ctx) {
    static const float ends[] = { 0, 1e-7f, 0.5f, 0.99999994f };
    static pt_vec3 at[SIDE * SIDE];
    int i, j, outside = 0, same = 0;
    for (i = 0; i < SIDE; i++) for (j = 0; j < SIDE; j++) {
        pt_vec3 *w = &at[i * SIDE + j];
        sample(ctx, ((float)i + 0.5f) / SIDE, ((float)j + 0.5f) / SIDE, w);
        *w = pti_add(*w, pt_v3(0, 0, 0));                /* no -0 */
        outside += !(pdf(ctx, *w) > 0);
    }
    qsort(at, SIDE * SIDE, sizeof at[0], by_place);
    for (i = 1; i < SIDE * SIDE; i++) same += !memcmp(&at[i], &at[i - 1], sizeof at[0]);
    CHECK_EQ_INT(outside, 0);
    CHECK_EQ_INT(same, 0);
    for (i = 0; i < 16; i++) {
        pt_vec3 w;
        sample(ctx, ends[i / 4], ends[i % 4], &w);
        CHECK(pti_finite3(w));
        CHECK_NEAR(pti_length(w), 1, 1e-6);
        CHECK(pdf(ctx, w) >= 0);
    }
}
static int disk_at(void *ctx, float u, float v, pt_vec3 *w) { (void)ctx; *w = pti_sample_cosine(u, v); return 1; }
static double lifted_pdf(void *ctx, pt_vec3 w) { (void)ctx; return pti_pdf_cosine(w.z); }
static int cone_at(void *ctx, float u, float v, pt_vec3 *w) {
    *w = pti_sample_cone(((round_shape *)ctx)->cone, u, v);
    return 1;
}
static int triangle_at(void *ctx, float u, float v, pt_vec3 *w) {
    triangle *t = (triangle *)ctx;
    *w = pti_sample_triangle(t->a, t->b, t->c, t->S, u, v);
    return 1;
}
static void strata_stay_strata(void) {
    static const float sizes[] = { 2, 1, 0.01f, 1e-4f, 1e-6f };
    pt_rng rng;
    int k;
    test_case("disk and cosine");
    strata_test(disk_at, lifted_pdf, NULL);
    for (k = 0; k < 5; k++) {
        round_shape shape = { NULL, NULL, 0 };
        shape.cone = sizes[k];
        test_case("cone %g", (double)sizes[k]);
        strata_test(cone_at, round_pdf, &shape);
    }
    pt_rng_seed(&rng, 6, 3);
    for (k = 0; k < 40; k++) {
        triangle t = random_triangle(&rng, k < 10 ? 0 : pow(10, -(k % 4)));
        if (t.S < 1e-6f) continue;
        test_case("triangle %d, S = %g", k, (double)t.S);
        strata_test(triangle_at, triangle_pdf, &t);
    }
    for (k = 0; k < RECTANGLES; k++) {
        rectangle q = rectangle_number(k);
        if (q.S < 1e-3f) q.slack = 4e-7 / sqrt(q.S);
        test_case("rectangle: %s", rectangles[k].name);
        strata_test(rectangle_at, rectangle_pdf, &q);
    }
}
/* Equal areas stay connected: a disk's stratum is convex-ish, so its corners and its middle stay close together. */
static void strata_stay_compact(void) {
    double worst = 0;
    int i, j, k;
    for (i = 0; i < 32; i++) for (j = 0; j < 32; j++) {
        float x[5], y[5];
        for (k = 0; k < 4; k++) pti_sample_disk(((float)i + (k & 1)) / 32, ((float)j + (k >> 1)) / 32, &x[k], &y[k]);
        pti_sample_disk(((float)i + 0.5f) / 32, ((float)j + 0.5f) / 32, &x[4], &y[4]);
        for (k = 0; k < 4; k++) worst = fmax(worst, sqrt((x[k] - x[4]) * (x[k] - x[4]) + (y[k] - y[4]) * (y[k] - y[4])));
    }
    CHECK(worst < 2.0 / 32);                             /* a square's half diagonal would be 1.41 / 32 */
}

void test_warp(void) {
    RUN(disk); RUN(hemispheres_and_spheres); RUN(cones);
    RUN(triangle_solid_angles); RUN(triangles_of_all_shapes); RUN(triangles_of_all_sizes); RUN(triangle_map_is_arvos);
    RUN(rectangle_solid_angles); RUN(rectangles_of_all_shapes);
    RUN(tables); RUN(table_places); RUN(tables_in_two_dimensions); RUN(strata_stay_strata); RUN(strata_stay_compact);
}
