/* >>bsdf: diffuse, mirror and glass against their formulas in double; furnaces; users' BSDFs. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "surfaces.h"

/* A scene that has one material, and that material. */
static const pti_material *material_of(pt_scene *s, pt_material m) { return commit(s) ? s->materials + m.id : s->materials; }
static pt_vec3 turned(pt_vec3 n, double degrees) {       /* n, tilted by that much */
    pt_vec3 t, b;
    pti_basis(n, &t, &b);
    return pti_normalize(pti_madd(t, (float)sin(degrees * STATS_PI / 180), pti_scale(n, (float)cos(degrees * STATS_PI / 180))));
}

/* ---- diffuse ---- */

static void diffuse_directions(void) {
    static const double cosine[] = { 1, 0.6, 0.05, 1e-5 }, tilt[] = { 0, 25, 60, 85 };
    pt_scene *s = pt_scene_create(NULL);
    const pti_material *m = material_of(s, diffuse(s, 0.7f));
    bounce b;
    int i, k, side;
    for (i = 0; i < 4; i++) for (k = 0; k < 4; k++) for (side = -1; side < 2; side += 2) {
        pt_vec3 ng = pti_normalize(pt_v3(0.3f, 0.8f, -0.5f)), t, u, wo;
        double total;
        pti_basis(ng, &t, &u);
        wo = pti_madd(ng, (float)(side * cosine[i]), pti_scale(t, (float)(-side * sqrt(1 - cosine[i] * cosine[i]))));      /* away from the tilt */
        bounce_at(&b, m, vertex_of(wo, ng, turned(ng, tilt[k])));
        total = (1 + (double)pti_dot(b.x.ng, b.x.ns)) / 2;
        test_case("cosine %g, normal tilted by %g, side %d", cosine[i], tilt[k], side);
        CHECK(pti_dot(b.x.ns, b.x.wo) * (float)side > 0);
        chi2_directions(&(chi2_directions_desc){ .sample = bounce_sample, .pdf = bounce_pdf, .ctx = &b, .total = total > 1 - 1e-6 ? 1 : total,
                                                 .ax = side * b.x.ns.x, .ay = side * b.x.ns.y, .az = side * b.x.ns.z, .zoom = 1, .n = 20000,
                                                 .tolerance = 0.004 });
    }
    pt_scene_destroy(s);
}
static void diffuse_values(void) {                       /* f = albedo / pi on the same side, 0 on the other; reciprocal */
    pt_scene *s = pt_scene_create(NULL);
    pt_material id = pt_add_material(s, &(pt_material_desc){ .color = { 0.2f, 0.5f, 0.8f } });
    const pti_material *m = material_of(s, id);
    pt_rng rng;
    int i, tested = 0;
    pt_rng_seed(&rng, 1, 2);
    for (i = 0; i < 20000; i++) {
        pt_vec3 ng = stats_direction(&rng), ns = i & 1 ? ng : turned(ng, 50 * pt_rng_float(&rng)), a = stats_direction(&rng), b = stats_direction(&rng);
        pt_vertex x = vertex_of(a, ng, ns), y = vertex_of(b, ng, ns);
        pt_vec3 there = eval_of(m, &x, b), back = eval_of(m, &y, a);
        double ca = fabs(pti_dot(ns, a)), cb = fabs(pti_dot(ns, b)), side = pti_dot(ng, a) * pti_dot(ng, b);
        if (fabs(side) < 1e-5) continue;
        if (side < 0) { CHECK(pti_is_zero3(there) && pti_is_zero3(back)); continue; }
        if (pti_dot(ns, a) * pti_dot(ng, a) < 2e-3f || pti_dot(ns, b) * pti_dot(ng, b) < 2e-3f) continue;         /* bent */
        tested++;
        CHECK_NEAR(there.x / cb, 0.2 / STATS_PI, 1e-4); CHECK_NEAR(there.z / cb, 0.8 / STATS_PI, 1e-4);
        CHECK_NEAR(there.y / cb, back.y / ca, 1e-4);
        CHECK_NEAR(pdf_of(m, &x, b), cb / STATS_PI, 1e-6);
    }
    CHECK(tested > 5000);
    pt_scene_destroy(s);
}

/* ---- mirror and glass, in double ---- */

typedef struct vec { double x, y, z; } vec;
static vec vec_of(pt_vec3 v) { vec r; r.x = v.x; r.y = v.y; r.z = v.z; return r; }
static double dot_of(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec sum_of(double a, vec u, double b, vec v) {
    vec r;
    r.x = a * u.x + b * v.x; r.y = a * u.y + b * v.y; r.z = a * u.z + b * v.z;
    return r;
}
static vec unit_of(vec v) { return sum_of(1 / sqrt(dot_of(v, v)), v, 0, v); }
static double apart(pt_vec3 a, vec b) { vec d = sum_of(1, vec_of(a), -1, b); return sqrt(dot_of(d, d)); }

static void mirrors_reflect(void) {
    pt_scene *s = pt_scene_create(NULL);
    const pti_material *m = material_of(s, mirror(s, 0.3f));
    pt_rng rng;
    int i, bent = 0;
    pt_rng_seed(&rng, 4, 1);
    for (i = 0; i < 20000; i++) {
        pt_vec3 ng = stats_direction(&rng), ns = i & 1 ? ng : turned(ng, 60 * pt_rng_float(&rng));
        pt_vertex x = vertex_of(stats_direction(&rng), ng, ns);
        vec n = unit_of(vec_of(x.ns)), wo = unit_of(vec_of(x.wo)), wi = sum_of(2 * dot_of(n, wo), n, -1, wo);
        double side = dot_of(vec_of(x.ng), wo), least, c, k;
        vec up;
        pt_scatter out;
        CHECK(sample_of(m, &x, 0.3f, 0.4f, 0.5f, &out) && out.delta && out.pdf == 1);
        if (fabs(side) < 1e-5) continue;
        up = sum_of(side < 0 ? -1 : 1, vec_of(x.ng), 0, wi);
        least = fmin(0.01, 0.9 * fabs(side));
        if (dot_of(up, wi) < least) {                    /* into the surface: lifted above the horizon */
            wi = unit_of(sum_of(1, wi, least - dot_of(up, wi), up));
            n = unit_of(sum_of(1, wi, 1, wo));
            bent++;
        }
        CHECK(apart(out.wi, wi) < 2e-6 / fmax(dot_of(n, wo), 1e-3));
        CHECK(pti_same_side(&x, x.wo, out.wi));
        c = fabs(dot_of(n, wo)); k = pow(1 - c, 5);
        CHECK_NEAR(out.f.x, 0.3f + (1 - 0.3f) * k, 2e-6 / fmax(dot_of(n, wo), 0.01));
        CHECK(pdf_of(m, &x, out.wi) == 0 && pti_is_zero3(eval_of(m, &x, out.wi)));
    }
    CHECK(bent > 100);
    pt_scene_destroy(s);
}
static double fresnel_of(double cos_i, double eta) {     /* Fresnel 1823; 1 beyond the critical angle */
    double sin_t = sqrt(1 - cos_i * cos_i) / eta, cos_t, s, p;
    if (sin_t >= 1) return 1;
    cos_t = sqrt(1 - sin_t * sin_t);
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return (s * s + p * p) / 2;
}
static void fresnel(void) {
    static const double ior[] = { 1.0001, 1.33, 1.5, 2.4, 10, 1 / 1.0001, 1 / 1.33, 1 / 1.5, 1 / 2.4, 0.1 };
    int i, k;
    for (i = 0; i < 10; i++) for (k = 1; k <= 4000; k++) {
        float c = (float)(k <= 2000 ? k / 2000.0 : pow(10, -6 * (k - 2000) / 2000.0)), eta = (float)ior[i], cos_t;
        double f = pti_fresnel(c, eta, &cos_t), critical = eta < 1 ? sqrt(1 - (double)eta * eta) : 0, st2 = (1 - (double)c * c) / eta / eta;
        test_case("ior %g, cosine %g", ior[i], (double)c);
        if (eta < 1 && fabs((double)c - critical) < 1e-5) continue;      /* a step: either is right */
        CHECK(f >= 0 && f <= 1);
        CHECK_NEAR(f, fresnel_of(c, eta), fabs(c - critical) < 1e-2 ? 3e-3 : 6e-6);
        CHECK(cos_t >= 0);
        if (st2 < 1) CHECK_NEAR(cos_t * cos_t, 1 - st2, 1e-6 / (eta < 1 ? (double)eta * eta : 1));
        else CHECK(f == 1 && cos_t == 0);
    }
    for (k = 1; k <= 1000; k++) {                        /* 1: nothing there, at any angle */
        float cos_t, c = powf(10, -4 * (float)k / 1000);
        CHECK(pti_fresnel(c, 1, &cos_t) < 1e-12f && fabsf(cos_t - c) <= 1e-6f * c);
    }
}
static void glass_refracts(void) {
    static const float ior[] = { 1.01f, 1.33f, 1.5f, 2.4f, 0.7f };
    pt_rng rng;
    int i, k, total = 0, inside = 0;
    pt_rng_seed(&rng, 6, 1);
    for (k = 0; k < 5; k++) {
        pt_scene *s = pt_scene_create(NULL);
        const pti_material *m = material_of(s, glass(s, ior[k]));
        for (i = 0; i < 10000; i++) {
            pt_vec3 ng = stats_direction(&rng);
            pt_vertex x = vertex_of(stats_direction(&rng), ng, ng), y;
            vec n = unit_of(vec_of(x.ng)), wo = unit_of(vec_of(x.wo)), wi, along;
            double c = dot_of(n, wo), eta = ior[k], f, sin_i, ft = 0, fr = 0, pt = 0, pr = 0;
            pt_scatter out, back;
            if (fabs(c) < 2e-3) continue;
            if (c < 0) { n = sum_of(-1, n, 0, n); c = -c; eta = 1 / eta; inside++; }
            f = fresnel_of(c, eta);
            sin_i = sqrt(1 - c * c);
            test_case("ior %g, eta %g, cosine %g", (double)ior[k], eta, c);
            if (f > 1e-7 && sample_of(m, &x, 0, 0.3f, 0.5f, &out)) {
                wi = sum_of(2 * c, n, -1, wo);
                CHECK(apart(out.wi, wi) < 1e-6 && out.delta);
                CHECK_NEAR(out.f.y, out.pdf, 1e-7);
                fr = out.f.y; pr = out.pdf;
            }
            if (fabs(sin_i / eta - 1) < 1e-3) continue;
            CHECK_NEAR(fr, f, 1e-4 * f + 2e-6);
            CHECK(sample_of(m, &x, 0.99999994f, 0.3f, 0.5f, &out));
            if (sin_i > eta) {                           /* totally reflected */
                CHECK(pti_same_side(&x, x.wo, out.wi) && out.pdf == 1 && out.f.x == 1);
                total++;
                continue;
            }
            CHECK(!pti_same_side(&x, x.wo, out.wi) && out.delta);
            wi = vec_of(out.wi);
            along = sum_of(1, wi, -dot_of(wi, n), n);
            CHECK_NEAR(sqrt(dot_of(along, along)) * eta, sin_i, 2e-6);               /* Snell */
            CHECK_NEAR(apart(out.wi, sum_of(-1 / eta, sum_of(1, wo, -c, n), -sqrt(1 - sin_i * sin_i / eta / eta), n)), 0, 2e-5);
            ft = out.f.y; pt = out.pdf;
            CHECK_NEAR(pr + pt, 1, 1e-6);
            CHECK_NEAR(fr + ft * eta * eta, 1, 2e-6 * (1 + eta * eta));              /* nothing is lost */
            y = vertex_of(out.wi, ng, ng);               /* and back: the same way, the same share */
            CHECK(sample_of(m, &y, 0.99999994f, 0.3f, 0.5f, &back));
            CHECK(apart(back.wi, wo) < 5e-5 + 6e-7 / c);
            CHECK_NEAR(back.f.y / (eta * eta), ft * eta * eta, 1e-5 + 2e-6 * (1 + eta * eta) / c);      /* steep where grazing */
        }
        pt_scene_destroy(s);
    }
    CHECK(total > 3000 && inside > 15000);
}
/* Glass of index 1 is not there: down to a cosine of 1e-4, and in pictures. */
static void ior_one_disappears(void) {
    pt_scene *s = pt_scene_create(NULL);
    const pti_material *m = material_of(s, glass(s, 1));
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 9, 1);
    for (i = 0; i < 20000; i++) {
        pt_vec3 ng = stats_direction(&rng), t, b, wo;
        float c = powf(10, -4 * pt_rng_float(&rng)) * (i & 1 ? -1.0f : 1.0f);
        pt_vertex x;
        pt_scatter out;
        pti_basis(ng, &t, &b);
        wo = pti_madd(ng, c, pti_scale(t, sqrtf(1 - c * c)));
        x = vertex_of(wo, ng, ng);
        CHECK(sample_of(m, &x, i & 2 ? 0 : pt_rng_float(&rng), 0, 0, &out));
        test_case("cosine %g", (double)c);
        if (fabsf(c) < 2e-3f) {                          /* a normal bent a little; the direction stays all the same */
            CHECK(pti_dot(out.wi, x.wo) < -0.99999f);
        } else CHECK(apart(out.wi, sum_of(-1, vec_of(x.wo), 0, vec_of(x.wo))) < 1e-6);
        CHECK_NEAR(out.f.x, 1, 1e-6);
        CHECK_NEAR(out.pdf, 1, 1e-6);
    }
    pt_scene_destroy(s);
}
static pt_vec3 gradient(void *user, pt_vec3 d) { (void)user; return pt_v3(1 + d.x, 1.2f + d.y, 1.5f - d.z); }
static void ior_one_in_a_picture(void) {
    static float with[48 * 48 * 3], without[48 * 48 * 3];
    int k, i;
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(1, 2, 5), pt_v3(0, 0, 0), 40, 48, 8);
        double worst = 0;
        pt_add_light(s, &(pt_light_desc){ .radiance = gradient });
        if (k == 1) pt_add_sphere(s, pt_v3(0, 0, 0), 1, glass(s, 1));
        if (k == 2) pt_add_box(s, pt_v3(-1, -0.5f, -0.7f), pt_v3(0.6f, 1, 1), NULL, glass(s, 1));
        if (k == 3) torus(s, pt_v3(0, 0, 0), 1, 0.4f, glass(s, 1));
        if (commit(s) && render(s, &d, k ? with : without, NULL) && k) {
            for (i = 0; i < 48 * 48 * 3; i++) worst = fmax(worst, fabs((double)with[i] - without[i]));
            test_case("shape %d", k);
            CHECK_NEAR(worst, 0, 2e-5);
        }
        pt_scene_destroy(s);
    }
}

/* ---- every kind of surface ---- */

#define ROUGHS 5
static const float roughs[ROUGHS] = { 0.05f, 0.15f, 0.4f, 0.8f, 1 };
/* All kinds of all roughnesses in one scene, which is built once, by whoever comes first: the tables take their time. */
static pt_scene *gallery;
static pt_material gallery_id[SURFACE_KINDS][ROUGHS];
static const pti_material *in_gallery(int kind, int rough) {
    int k, r;
    if (!gallery) {
        gallery = pt_scene_create(NULL);
        for (k = 0; k < SURFACE_KINDS; k++) for (r = 0; r < ROUGHS; r++) gallery_id[k][r] = add_surface(gallery, k, roughs[r]);
        commit(gallery);
    }
    return gallery->materials + gallery_id[kind][rough].id;
}
/* The samples and the density are one thing, which integrates to what is not lost: over the whole sphere and, where lobes
   are narrow, close to their middle. */
static void every_surface_samples_its_pdf(void) {
    static const double cosine[] = { 0.8, 0.25, 0.02 };
    int kind, r, k, side;
    for (kind = 0; kind < SURFACE_KINDS; kind++) for (r = 0; r < ROUGHS; r++)
        for (k = 0; k < 3; k++) for (side = 1; side >= -1; side -= 2) {
            double least = (double)(roughs[r] * roughs[r]), total;
            bounce b;
            albedo a;
            if (side < 0 && !(surface_transmits(kind) && k < 2)) continue;
            if ((kind <= TRANSLUCENT && r) || (kind > TRANSLUCENT && (kind + r + k) % 2)) continue;      /* every other one: time */
            bounce_at(&b, in_gallery(kind, r), vertex_at(side * cosine[k], 0.7));
            a = albedo_of(&b, 1, 1 << 14);
            test_case("%s of roughness %g, cosine %g", surface_names[kind], (double)roughs[r], side * cosine[k]);
            CHECK(a.bad == 0);
            total = 1 - fmax(a.lost + a.deltas, 3e-5);
            chi2_directions(&(chi2_directions_desc){ .sample = bounce_sample, .pdf = bounce_pdf, .ctx = &b, .total = total, .n = 3000,
                                                     .cells_phi = 10, .az = (double)side, .seed = (uint64_t)k, .tolerance = 0.004 });
            if (r < 2 && kind >= METAL && kind != FUZZY && k < 2) {
                pt_vec3 m = pti_mirrored(b.x.wo, pt_v3(0, 0, (float)side));
                chi2_directions(&(chi2_directions_desc){ .sample = bounce_sample, .pdf = bounce_pdf, .ctx = &b, .total = total, .n = 3000,
                                                         .cells_phi = 10, .ax = m.x, .ay = m.y, .az = m.z, .zoom = 20 * least * least, .partial = 1, .seed = 9, .tolerance = 0.004 });
            }
        }
}

/* f(wo, wi) = f(wi, wo), and with radiance squeezed inside of glass f(wo, wi) / n_o^2 = f(wi, wo) / n_i^2. Not so where layers
   leave to what is below them what they do not reflect from wo. */
static void reciprocity(void) {
    static const surface_kind kinds[] = { LAMBERT, ROUGH_DIFFUSE, METAL, METAL_ANISO, METAL_TURNED, GOLD, THIN, GLASS, GLASS_LOW, GLASS_INVERSE, GLASS_ANISO, PLASTIC, MIXED };
    enum { N = sizeof kinds / sizeof kinds[0] };
    int i, r, k;
    for (i = 0; i < N; i++) for (r = 0; r < ROUGHS; r++) {
        const pti_material *m = in_gallery((int)kinds[i], r);
        double ior = kinds[i] == MIXED ? 1.5 : kinds[i] >= GLASS && kinds[i] <= GLASS_ANISO ? (double)m->desc.ior : 1;
        int tested = 0, seen = 0;
        pt_rng rng;
        pt_rng_seed(&rng, 8, 8);
        test_case("%s of roughness %g", surface_names[kinds[i]], (double)roughs[r]);
        for (k = 0; k < 3000; k++) {
            pt_vec3 a = stats_direction(&rng), b = stats_direction(&rng), u = stats_uniform3(&rng), there, back;
            pt_vertex x = vertex_of(a, pt_v3(0, 0, 1), pt_v3(0, 0, 1)), y;
            pt_scatter out;
            double f, g;
            if (k & 1 && sample_of(m, &x, u.x, u.y, u.z, &out) && !out.delta) b = out.wi;
            if (fabsf(a.z) < 0.02f || fabsf(b.z) < 0.02f) continue;
            y = vertex_of(b, pt_v3(0, 0, 1), pt_v3(0, 0, 1));
            there = eval_of(m, &x, b);
            back = eval_of(m, &y, a);
            f = (double)there.y / fabs((double)b.z) / (a.z < 0 ? ior * ior : 1);
            g = (double)back.y / fabs((double)a.z) / (b.z < 0 ? ior * ior : 1);
            tested++;
            seen += f > 0;
            if (!(fabs(f - g) <= 4e-3 * (fabs(f) + fabs(g)) + 1e-6)) FAIL("cosines %g and %g: %g, but back %g", (double)a.z, (double)b.z, f, g);
        }
        CHECK(tested > 2000 && seen > 500);
    }
}
static void thin_panes_have_no_inside(void) {            /* the same from both sides, smooth and rough */
    pt_scene *s = pt_scene_create(NULL);
    pt_material smooth = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .thin = 1 });
    pt_material whole = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { 1, 1, 1 }, .thin = 1, .transmission = 1 });
    int k, i;
    if (commit(s)) for (k = 0; k < 2; k++) for (i = 1; i < 100; i++) {
        pt_vertex x = vertex_at(i / 100.0, 0.4), y = vertex_at(-i / 100.0, 0.4);
        const pti_material *m = s->materials + (k ? whole : smooth).id;
        double c = (double)x.wo.z, F = fresnel_of(c, 1.5), R = 2 * F / (1 + F);
        pt_scatter a, b;
        test_case("cosine %g", c);
        CHECK(sample_of(m, &x, 0, 0, 0, &a) && sample_of(m, &y, 0, 0, 0, &b));
        CHECK_NEAR(a.f.x, R, 1e-5); CHECK_NEAR(b.f.x, R, 1e-5);
        CHECK(a.wi.z > 0 && b.wi.z < 0);
        CHECK(sample_of(m, &x, 0.99999994f, 0, 0, &a) && sample_of(m, &y, 0.99999994f, 0, 0, &b));
        CHECK_NEAR(a.f.x, 1 - R, 1e-5); CHECK_NEAR(b.f.x, 1 - R, 1e-5);
        CHECK(apart(a.wi, vec_of(pti_neg(x.wo))) < 1e-6 && apart(b.wi, vec_of(pti_neg(y.wo))) < 1e-6);
    }
    pt_scene_destroy(s);
}
/* No weight f / p is much above the albedo: what is drawn seldom must be dim. */
static void weights_are_even(void) {
    static const double cosine[] = { 0.95, 0.5, 0.1 };
    pt_scene *s = pt_scene_create(NULL);
    pt_material hardly[2];
    int kind, r, k;
    for (k = 0; k < 2; k++)                              /* a little metal, rough and smooth */
        hardly[k] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.8f, 0.8f, 0.8f }, .roughness = 0.5f * (float)k, .metallic = 0.02f });
    if (commit(s)) for (k = 0; k < 3; k++) {
        for (kind = 0; kind < SURFACE_KINDS + 2; kind++) for (r = 0; r < ROUGHS; r++) {
            bounce b;
            albedo a;
            if (kind >= SURFACE_KINDS && r) continue;
            bounce_at(&b, kind < SURFACE_KINDS ? in_gallery(kind, r) : s->materials + hardly[kind - SURFACE_KINDS].id, vertex_at(cosine[k], 0.7));
            a = albedo_of(&b, 1, 1024);
            test_case("%s of roughness %g, cosine %g", kind < SURFACE_KINDS ? surface_names[kind] : "a little metal", (double)roughs[r], cosine[k]);
            if (!CHECK(a.square <= (kind < SURFACE_KINDS ? 2.2 : 1.2) * a.radiance * a.radiance)) FAIL("albedo %g, mean square %g", a.radiance, a.square);
        }
    }
    pt_scene_destroy(s);
}

/* However a normal map tilts the normal, a white surface is not black: what it sends on is more than half. So it is where the
   mesh's own shading normals lean, for what is diffuse, smooth or goes through; rough metal loses all that would go into the
   surface. */
static void tilted_normals_are_not_black(void) {
    static const struct { double least; pt_material_desc d; } all[] = {
        { 0.7, { .color = { 1, 1, 1 } } }, { 0.6, { .color = { 1, 1, 1 }, .roughness = 1 } }, { 0.99, { .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 } } },
        { 0.5, { .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 }, .roughness = 0.1f } }, { 0.5, { .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 }, .roughness = 0.3f } },
        { 0.5, { .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 }, .roughness = 0.6f } }, { 0.5, { .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 }, .roughness = 1 } },
        { 0.99, { .bsdf = PT_BSDF_DIELECTRIC } }, { 0.5, { .bsdf = PT_BSDF_DIELECTRIC, .roughness = 0.3f } }, { 0.5, { .bsdf = PT_BSDF_DIELECTRIC, .roughness = 1 } },
        { 0.7, { .bsdf = PT_BSDF_PRINCIPLED, .color = { 1, 1, 1 } } }, { 0.7, { .bsdf = PT_BSDF_PRINCIPLED, .color = { 1, 1, 1 }, .roughness = 0.3f } },
        { 0.5, { .bsdf = PT_BSDF_PRINCIPLED, .color = { 1, 1, 1 }, .roughness = 1, .sheen = 1 } } };
    enum { N = sizeof all / sizeof all[0] };
    pt_scene *s = pt_scene_create(NULL);
    pt_material id[N][4];
    int i, t, k, j, map;
    for (i = 0; i < N; i++) for (t = 0; t < 4; t++) {
        pt_material_desc d = all[i].d;
        double tilt = 20 * t * STATS_PI / 180;
        float p[3];
        p[0] = (float)(0.5 + 0.5 * sin(tilt)); p[1] = 0.5f; p[2] = (float)(0.5 + 0.5 * cos(tilt));
        if (t) d.normal_texture = pt_add_texture(s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 3, .bits = 32, .pixels = p });
        id[i][t] = pt_add_material(s, &d);
    }
    if (commit(s)) for (i = 0; i < N; i++) for (map = 0; map < 2; map++) for (t = 1; t < 4; t++) for (k = 0; k < 5; k++) for (j = 0; j < 4; j++) {
        double cosine = k ? 0.24 * k : 0.02, tilt = 20 * t * STATS_PI / 180;
        pt_vertex x = vertex_at(cosine, j * STATS_PI / 3);
        bounce b;
        albedo a;
        x.tangent = pt_v3(1, 0, 0);
        if (!map) x = vertex_of(x.wo, x.ng, pt_v3((float)sin(tilt), 0, (float)cos(tilt)));
        bounce_at(&b, s->materials + id[i][map ? t : 0].id, x);
        a = albedo_of(&b, 1.5, 256);
        test_case("material %d, %s tilted by %d degrees, wo's cosine %g, turned by %d", i, map ? "map" : "normal", 20 * t, cosine, 60 * j);
        CHECK(a.flux >= all[i].least && a.flux < 1.03);
    }
    pt_scene_destroy(s);
}

/* ---- nothing is NaN ---- */

static float extreme(pt_rng *rng) {                      /* in [0,1), often at or near an end */
    float u = pt_rng_float(rng);
    int k = (int)(pt_rng_u32(rng) % 4);
    return k == 0 ? 0 : k == 1 ? 0.99999994f : k == 2 ? u * 1e-6f : u;
}
static pt_vec3 extreme_direction(pt_rng *rng) {
    pt_vec3 d = stats_direction(rng);
    uint32_t k = pt_rng_u32(rng) % 8;
    if (k & 1) d.x *= 1e-6f;
    if (k & 2) d.y *= 1e-20f;
    if (k == 7) d.z = d.x = 0;
    return pti_dot(d, d) > 1e-30f ? pti_normalize(d) : pt_v3(0, 0, -1);
}
static int sane(float x) { return x >= 0 && x < 1e13f; }
/* A material of any kind with numbers anywhere, ends most of all. What costs a table is chosen from a few. */
static pt_material_desc any_material(pt_rng *rng) {
    static const float ior[] = { 1.5f, 1, 1.000001f, 100, 0.01f, 1.02f, 0 }, index[][2] = { { 0, 0 }, { 0, 3 }, { 1000, 1000 }, { 1, 1e-20f }, { 0.1f, 4 } };
    static const pt_bsdf kinds[] = { PT_BSDF_DIFFUSE, PT_BSDF_CONDUCTOR, PT_BSDF_DIELECTRIC, PT_BSDF_PRINCIPLED, PT_BSDF_PRINCIPLED, PT_BSDF_PRINCIPLED };
    pt_material_desc d;
    uint32_t k = pt_rng_u32(rng) % 5, l = pt_rng_u32(rng) % 5;
    memset(&d, 0, sizeof d);
    d.bsdf = kinds[pt_rng_u32(rng) % 6];
#define ANY(name) { float u = pt_rng_float(rng); uint32_t c = pt_rng_u32(rng) % 6; d.name = c == 0 ? 1 : c == 1 ? u * 1e-6f : c == 2 ? 1 - u * 1e-6f : c == 3 ? u : c == 4 ? u * 0.02f : 0; }
    PTI_NUMBERS(ANY) ANY(transparency) ANY(color.x) ANY(color.y) ANY(color.z) ANY(sheen_color.x) ANY(sheen_color.y) ANY(sheen_color.z) ANY(sheen_roughness)
#undef ANY
    d.roughness_y = pt_rng_u32(rng) % 4 ? 0 : d.bsdf == PT_BSDF_PRINCIPLED && d.metallic == 0 && !d.thin ? d.roughness_y : d.roughness;
    d.rotation_deg = pt_rng_float(rng) * 360;
    d.ior = ior[pt_rng_u32(rng) % 7]; d.coat_ior = pt_rng_u32(rng) % 2 ? 0 : 100;
    d.abbe = pt_rng_u32(rng) % 3 ? 0 : 1 + 30 * pt_rng_float(rng);
    d.eta = pt_v3(index[k][0], index[l][0], 1.2f); d.k = pt_v3(index[k][1], index[l][1], 0);
    d.thin = pt_rng_u32(rng) % 3 == 0;
    if (d.metallic > 0 && d.roughness_y != d.roughness) d.roughness_y = 0;
    return d;
}
/* ng, ns, wo and wi as they come, or the same, opposite, nearly perpendicular ... */
static pt_vertex any_vertex(pt_rng *rng) {
    pt_vec3 ng = extreme_direction(rng), ns = extreme_direction(rng), t, b, wo = extreme_direction(rng);
    float tilt = powf(10, -8 * pt_rng_float(rng));
    pt_vertex x;
    pti_basis(ng, &t, &b);
    switch (pt_rng_u32(rng) % 6) {
    case 0: ns = ng; break;
    case 1: ns = pti_neg(ng); break;
    case 2: ns = pti_madd(ng, tilt, t); break;
    case 3: ns = pti_neg(wo); break;
    case 4: ns = pti_madd(t, tilt, ng); break;
    default: break;
    }
    switch (pt_rng_u32(rng) % 4) {
    case 0: wo = pti_madd(ng, tilt, b); break;           /* grazing */
    case 1: wo = pti_madd(ng, -tilt, b); break;
    case 2: wo = pti_madd(t, tilt, ng); break;           /* straight */
    default: break;
    }
    x = vertex_of(wo, ng, ns);
    x.tangent = extreme_direction(rng);                  /* perpendicular to ns, as in pti_vertex_coordinates */
    x.tangent = pti_normalize(pti_madd(x.ns, -pti_dot(x.ns, x.tangent), x.tangent));
    if (!(fabsf(pti_dot(x.tangent, x.ns)) < 1e-5f) || pti_is_zero3(x.tangent)) pti_basis(x.ns, &x.tangent, &b);
    x.dpdu = pt_rng_u32(rng) % 4 ? t : pt_v3(0, 0, 0); x.dpdv = pt_rng_u32(rng) % 4 ? b : pti_scale(t, 1e-20f);
    x.u = pt_rng_float(rng) * 100 - 50; x.v = pt_rng_float(rng);
    x.wavelength = pt_rng_u32(rng) % 2 ? 0 : 390 + 320 * pt_rng_float(rng);
    return x;
}
/* One evaluation each of sample, of f and p at what was drawn, and of f and p anywhere; 0, after saying what, if one is senseless. */
static int one_is_sane(const pti_material *m, pt_rng *rng) {
    static pti_surface surface;
    pt_vertex x = any_vertex(rng);
    pt_vec3 wi = extreme_direction(rng), f;
    uint32_t u[3];
    pt_scatter out;
    float sum = 0, p;
    int i, k, drawn;
    for (i = 0; i < 3; i++) { double e = (double)extreme(rng); u[i] = e > 0.9999 ? 0xffffffffu : (uint32_t)(e * 4294967296.0); }
    memset(&out, 0, sizeof out);
    pti_surface_at(m, &x, &surface);
    for (i = 0; i < surface.count; i++) sum += surface.lobes[i].share;
    if (surface.count && !(fabsf(sum - 1) < 1e-5f && surface.delta >= 0 && surface.delta < 1.00001f)) return FAIL("shares add up to %g, deltas to %g", (double)sum, (double)surface.delta);
    drawn = pti_surface_sample(&surface, u[0], u[1], u[2], &out);
    if (drawn && !(fabsf(pti_length(out.wi) - 1) < 1e-5f)) return FAIL("wi %g %g %g is %.8g long, delta %d", (double)out.wi.x, (double)out.wi.y, (double)out.wi.z, (double)pti_length(out.wi), out.delta);
    if (drawn && out.delta && !(sane(out.f.x) && sane(out.f.y) && sane(out.f.z) && out.pdf >= 0 && out.pdf <= 1.00001f))
        return FAIL("delta: f %g %g %g, pdf %g", (double)out.f.x, (double)out.f.y, (double)out.f.z, (double)out.pdf);
    for (k = 0; k < 2; k++) {
        if (k && !(drawn && !out.delta)) break;
        p = pti_surface_eval(&surface, k ? out.wi : wi, &f);
        if (!(sane(f.x) && sane(f.y) && sane(f.z) && sane(p)))
            return FAIL("bsdf %d, wo %g %g %g, ng %g %g %g, ns %g %g %g, wi %g %g %g: f %g %g %g, p %g", (int)m->desc.bsdf, (double)x.wo.x, (double)x.wo.y, (double)x.wo.z,
                        (double)x.ng.x, (double)x.ng.y, (double)x.ng.z, (double)x.ns.x, (double)x.ns.y, (double)x.ns.z, (double)(k ? out.wi : wi).x,
                        (double)(k ? out.wi : wi).y, (double)(k ? out.wi : wi).z, (double)f.x, (double)f.y, (double)f.z, (double)p);
        if (pti_largest(f) > 1e-37f && !(p > 0)) return FAIL("bsdf %d: f %g, but p %g (cosines %g, %g)", (int)m->desc.bsdf, (double)pti_largest(f), (double)p, (double)x.wo.z, (double)wi.z);
    }
    return 1;
}
static void no_nans(void) {
    enum { MATERIALS = 400 };
    const char *more = getenv("TEST_EVALUATIONS");       /* times a million */
    pt_scene *s = pt_scene_create(NULL);
    pt_material id[MATERIALS];
    pt_texture map[3];
    pt_rng rng;
    long i, n = more ? 330000L * atol(more) : 700000, fine = 0;
    pt_rng_seed(&rng, 5, 5);
    for (i = 0; i < 3; i++) {
        float noise[8 * 8 * 3];
        int k;
        for (k = 0; k < 8 * 8 * 3; k++) noise[k] = pt_rng_float(&rng);
        map[i] = pt_add_texture(s, &(pt_texture_desc){ .width = 8, .height = 8, .channels = 3, .bits = 32, .pixels = noise });
    }
    for (i = 0; i < MATERIALS; i++) {
        pt_material_desc d = any_material(&rng);
        if (i % 4 == 0) d.normal_texture = map[0];
        if (i % 8 == 1) d.bump_texture = map[1];
        if (i % 8 == 2) d.roughness_texture = map[2];
        if (i > 20 && i % 10 == 3) {
            d.bsdf = PT_BSDF_MIX;
            d.a = id[i - 10 + (int)(pt_rng_u32(&rng) % 10)]; d.b = id[i - 10 + (int)(pt_rng_u32(&rng) % 10)];
            if (s->materials[d.a.id].lobes + s->materials[d.b.id].lobes >= PTI_LOBES) d.a = d.b = id[0];
        }
        id[i] = pt_add_material(s, &d);
    }
    if (commit(s)) for (i = 0; i < n; i++) {
        int k = (int)(pt_rng_u32(&rng) % MATERIALS);
        test_case("material %d, ior %g, roughness %g", k, (double)s->materials[id[k].id].desc.ior, (double)s->materials[id[k].id].desc.roughness);
        fine += one_is_sane(s->materials + id[k].id, &rng);
    }
    CHECK(fine == n);
    pt_scene_destroy(s);
}

/* ---- users' BSDFs ---- */

static pt_vec3 own_eval(void *user, const pt_vertex *x, pt_vec3 wi) {              /* diffuse, in our own words */
    float c = pti_dot(pti_dot(x->ns, x->wo) < 0 ? pti_neg(x->ns) : x->ns, wi), p = c > 0 ? c * (1 / PTI_PI) : 0.0f;
    if (!(pti_dot(x->ng, x->wo) * pti_dot(x->ng, wi) > 0)) p = 0;
    return pti_scale(*(const pt_vec3 *)user, p);
}
static float own_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    pt_vec3 one = pt_v3(1, 1, 1);
    (void)user;
    return own_eval(&one, x, wi).x;
}
static int own_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    pt_vec3 n = pti_dot(x->ns, x->wo) < 0 ? pti_neg(x->ns) : x->ns, t, b, c = pti_sample_cosine(u[0], u[1]);
    (void)user;
    pti_basis(n, &t, &b);
    out->wi = pti_to_world(t, b, n, c);
    return 1;
}
static const pt_bsdf_vtable own = { own_eval, own_pdf, own_sample, NULL };
static pt_material user_material(pt_scene *s, const pt_bsdf_vtable *v, void *user) {
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_USER, .vtable = v, .user = user });
}
static void user_diffuse_is_diffuse(void) {
    static float rgb[2][32 * 32 * 3];
    static pt_vec3 color = { 0.2f, 0.7f, 0.9f };
    int lights, k, i;
    for (lights = 0; lights < 3; lights++) {
        for (k = 0; k < 2; k++) {
            pt_scene *s = pt_scene_create(NULL);
            pt_render_desc d = view(pt_v3(2, 3, 5), pt_v3(0, 0.5f, 0), 50, 32, 16);
            pt_material m = k ? user_material(s, &own, &color) : pt_add_material(s, &(pt_material_desc){ .color = color });
            pt_add_quad(s, pt_v3(-5, 0, -5), pt_v3(0, 0, 10), pt_v3(10, 0, 0), m);
            torus(s, pt_v3(0, 0.5f, 0), 1, 0.4f, m);
            pt_add_light(s, &(pt_light_desc){ .radiance = gradient });
            if (lights > 0) pt_add_sphere(s, pt_v3(0, 2, 0), 0.4f, lamp(s, 5, 0));
            if (lights > 1) pt_add_sphere(s, pt_v3(-2, 1, 0), 0.4f, lamp(s, 3, 0));
            if (commit(s)) render(s, &d, rgb[k], NULL);
            pt_scene_destroy(s);
        }
        test_case("%d lights", lights);
        for (k = 0; k < 3; k++) {
            stats_moments difference = { 0, 0, 0 };
            for (i = 0; i < 32 * 32; i++) stats_push(&difference, (double)rgb[0][3 * i + k] - (double)rgb[1][3 * i + k]);
            CHECK_P(stats_t_test(&difference, 0));
        }
        CHECK(rgb[0][3 * 32 * 16] > 0);
    }
}
/* Half mirror, half diffuse. */
static pt_vec3 half_eval(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; return pti_scale(pt_v3(1, 1, 1), 0.5f * own_pdf(NULL, x, wi)); }
static float half_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; return 0.5f * own_pdf(NULL, x, wi); }
static float half_delta(void *user, const pt_vertex *x) { (void)user; (void)x; return 0.5f; }
static int half_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    if (u[2] >= 0.5f) return own_sample(user, x, u, out);
    out->wi = pti_mirrored(x->wo, pti_dot(x->ns, x->wo) < 0 ? pti_neg(x->ns) : x->ns);
    out->f = pt_v3(0.5f, 0.5f, 0.5f);
    out->pdf = 0.5f;
    out->delta = 1;
    return 1;
}
static const pt_bsdf_vtable half_mirror = { half_eval, half_pdf, half_sample, half_delta };
static void half_mirror_agrees(void) {
    int k;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 1, 3), pt_v3(0, 0, 0), 1, 16, 256);
        stats_moments a, b;
        pt_add_quad(s, pt_v3(-5, 0, -5), pt_v3(0, 0, 10), pt_v3(10, 0, 0), user_material(s, &half_mirror, NULL));
        pt_add_quad(s, pt_v3(-1, 1, -4), pt_v3(2, 0, 0), pt_v3(0, 1.5f, 0), lamp(s, 3, 0));      /* also seen in the mirror */
        if (k > 0) pt_add_sphere(s, pt_v3(1, 1, 1), 0.5f, lamp(s, 3, 0));
        if (k > 1) pt_add_light(s, &(pt_light_desc){ .radiance = gradient });
        if (commit(s)) {
            a = render_pixels(s, &d);
            d.weights.bsdf = 1; d.seed = 7;
            b = render_pixels(s, &d);
            test_case("scene %d", k);
            CHECK(stats_error(&a) < 0.01 * a.mean && stats_error(&b) < 0.01 * b.mean);
            CHECK_P(stats_welch_test(&a, &b));
            d.weights.lights = 9; d.weights.environment = 3; d.seed = 8;
            a = render_pixels(s, &d);
            CHECK_P(stats_welch_test(&a, &b));
        }
        pt_scene_destroy(s);
    }
}

/* ---- furnaces: in a sky of radiance 1, what scatters all light is not to be seen ---- */

static pt_vec3 one_sky(void *user, pt_vec3 d) { (void)user; (void)d; return pt_v3(1, 1, 1); }
static void furnaces(void) {
    static pt_vec3 white = { 1, 1, 1 };
    int kind, shape;
    for (kind = 0; kind < 7; kind++) for (shape = 0; shape < 3; shape++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(1, 2, 3), pt_v3(0, 0, 0), 30, 24, 64);
        stats_moments m;
        pt_material id = kind < 2 ? diffuse(s, 1) : kind == 2 ? mirror(s, 1) : kind == 3 ? glass(s, 1.5f) : kind == 4 ? glass(s, 2.4f)
                       : user_material(s, kind == 5 ? &half_mirror : &own, &white);
        if (shape == 0) pt_add_sphere(s, pt_v3(0, 0, 0), 1, id);
        if (shape == 1) pt_add_box(s, pt_v3(-1, -0.5f, -0.7f), pt_v3(0.6f, 1, 1), NULL, id);
        if (shape == 2) torus(s, pt_v3(0, 0, 0), 1, 0.4f, id);
        if (kind == 1) pt_add_light(s, &(pt_light_desc){ .radiance = one_sky });     /* with a density of its own */
        else sky(s, 1);
        d.max_depth = 1000;
        if (kind == 1) { d.width = d.height = 10; d.spp = shape == 2 ? 8192 : 2048; }
        if (commit(s)) {
            m = render_pixels(s, &d);
            test_case("kind %d, shape %d", kind, shape);
            check_mean(&m, 1);
            CHECK_NEAR(m.mean, 1, 1e-3);
        }
        pt_scene_destroy(s);
    }
}

/* ---- BSDFs that return NaN ---- */

static pt_vec3 nan_eval(void *user, const pt_vertex *x, pt_vec3 wi) { (void)x; (void)wi; return pt_v3(*(const float *)user, 0.5f, 0.5f); }
static int nan_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    float bad = *(const float *)user;
    own_sample(user, x, u, out);
    out->f = pt_v3(0.5f, bad, 0.5f);
    out->pdf = 1;
    return out->delta = 1;
}
static float nan_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)x; (void)wi; return *(const float *)user; }
static int nan_direction(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    (void)x; (void)u;
    out->wi = pt_v3(*(const float *)user, 1, 0);
    return 1;
}
static pt_vec3 no_eval(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return pt_v3(0, 0, 0); }
static float no_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return 0; }
static float always(void *user, const pt_vertex *x) { (void)user; (void)x; return 1; }
static void bad_bsdfs(void) {
    static const pt_bsdf_vtable bad[] = { { nan_eval, own_pdf, own_sample, NULL }, { no_eval, no_pdf, nan_sample, always },
                                          { own_eval, nan_pdf, own_sample, NULL }, { nan_eval, own_pdf, nan_direction, NULL } };
    static float rgb[16 * 16 * 3], value[3];
    int k, v, i;
    value[0] = (float)nan(""); value[1] = HUGE_VALF; value[2] = -1;
    for (k = 0; k < 4; k++) for (v = 0; v < 3; v++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 5), pt_v3(0, 0, 0), 40, 16, 16);
        pt_stats stats;
        int finite = 1, on = 0;
        if (k >= 2 && v) { pt_scene_destroy(s); continue; }
        pt_add_sphere(s, pt_v3(0, 0, 0), 1, user_material(s, bad + k, &value[v]));
        sky(s, 1);
        if (commit(s) && render(s, &d, rgb, &stats)) {
            test_case("bsdf %d, value %g", k, (double)value[v]);
            for (i = 0; i < 16 * 16 * 3; i++) { finite &= rgb[i] >= 0 && rgb[i] <= 1.0001f; on += rgb[i] == 0; }
            CHECK(finite);
            CHECK(rgb[0] == 1);                          /* beside it */
            if (k < 2) CHECK(on > 100 && stats.discarded * 3 >= (uint64_t)on * 16 && stats.discarded < stats.paths / 2);
        }
        pt_scene_destroy(s);
    }
}

void test_bsdf(void) {
    RUN(diffuse_directions);
    RUN(diffuse_values);
    RUN(mirrors_reflect);
    RUN(fresnel);
    RUN(glass_refracts);
    RUN(ior_one_disappears);
    RUN(ior_one_in_a_picture);
    RUN(every_surface_samples_its_pdf);
    RUN(reciprocity);
    RUN(thin_panes_have_no_inside);
    RUN(weights_are_even);
    RUN(tilted_normals_are_not_black);
    RUN(no_nans);
    RUN(user_diffuse_is_diffuse);
    RUN(half_mirror_agrees);
    RUN(furnaces);
    RUN(bad_bsdfs);
    pt_scene_destroy(gallery);
    gallery = NULL;
}
