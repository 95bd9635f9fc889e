/* >>microfacet: GGX's distribution, visible normals, Fresnel, tables of albedos. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "surfaces.h"

/* ---- visible normals ---- */

typedef struct ggx { pt_vec3 wo; float ax, ay; } ggx;
static int ggx_sample(void *ctx, pt_rng *rng, pt_vec3 *m) {
    const ggx *g = (const ggx *)ctx;
    float u = pt_rng_float(rng), v = pt_rng_float(rng);
    *m = pti_sample_ggx(g->wo, g->ax, g->ay, u, v);
    return 1;
}
static double ggx_pdf(void *ctx, pt_vec3 m) {
    const ggx *g = (const ggx *)ctx;
    return m.z > 0 ? (double)pti_pdf_ggx(g->wo, m, g->ax, g->ay) : 0;
}
static void visible_normals(void) {
    static const float alpha[][2] = { { 1, 1 }, { 0.5f, 0.5f }, { 0.1f, 0.1f }, { 0.02f, 0.02f }, { 0.9f, 0.1f }, { 0.05f, 0.6f } };
    static const double cosine[] = { 1, 0.7, 0.2, 0.02 };
    int i, k;
    for (i = 0; i < 6; i++) for (k = 0; k < 4; k++) {
        ggx g = { { 0, 0, 0 }, 0, 0 };
        double most = (double)alpha[i][alpha[i][1] > alpha[i][0]];
        g.wo = direction_at(cosine[k], 0.7); g.ax = alpha[i][0]; g.ay = alpha[i][1];
        test_case("alpha %g %g, cosine %g", (double)g.ax, (double)g.ay, cosine[k]);
        chi2_directions(&(chi2_directions_desc){ .sample = ggx_sample, .pdf = ggx_pdf, .ctx = &g, .zoom = 1, .n = 20000, .seed = 1 });
        if (most < 0.2)
            chi2_directions(&(chi2_directions_desc){ .sample = ggx_sample, .pdf = ggx_pdf, .ctx = &g, .zoom = 4 * most * most, .partial = 1, .n = 20000, .seed = 2 });
    }
}
/* D is a distribution of areas: the integral of D m.z is 1, and that of D (w.m)+ is w.z / G1(w) (Heitz 2014, eq. 14 and 19). */
static void distribution(void) {
    static const float alpha[][2] = { { 1, 1 }, { 0.4f, 0.4f }, { 0.9f, 0.2f } };
    static const double cosine[] = { 1, 0.6, 0.1 };
    int i, k, a, b;
    for (i = 0; i < 3; i++) for (k = 0; k < 3; k++) {
        pt_vec3 w = direction_at(cosine[k], 0.4);
        double area = 0, seen = 0;
        for (a = 0; a < 800; a++) for (b = 0; b < 800; b++) {
            double t = (a + 0.5) / 800, z = 1 - t * t, phi = 2 * STATS_PI * (b + 0.5) / 800;    /* denser at the pole */
            pt_vec3 m = direction_at(z, phi);
            double d = (double)pti_ggx_d(m, alpha[i][0], alpha[i][1]) * 2 * t * 2 * STATS_PI / 640000, c = (double)pti_dot(w, m);
            area += d * z;
            if (c > 0) seen += d * c;
        }
        test_case("alpha %g %g, cosine %g", (double)alpha[i][0], (double)alpha[i][1], cosine[k]);
        CHECK_NEAR(area, 1, 1e-4);
        CHECK_NEAR(seen, cosine[k] * (1 + (double)pti_ggx_lambda(w, alpha[i][0], alpha[i][1])), 1e-4);
    }
}

/* ---- Fresnel ---- */

/* Of a complex index, in complex arithmetic written out: r = (cos i - n cos t) / (cos i + n cos t) and its like, with
   n cos t = sqrt(n^2 - sin^2 i). */
static double metal_of(double c, double eta, double k) {
    double s2 = 1 - c * c, re = eta * eta - k * k - s2, im = 2 * eta * k, l = sqrt(re * re + im * im);
    double a = sqrt((l + re) / 2), b = sqrt(fmax((l - re) / 2, 0));      /* n cos t = a + i b */
    double n2r = eta * eta - k * k, n2i = 2 * eta * k, pr, pi, qr, qi, s, p;
    s = ((c - a) * (c - a) + b * b) / ((c + a) * (c + a) + b * b);
    pr = n2r * c - a; pi = n2i * c - b; qr = n2r * c + a; qi = n2i * c + b;
    p = (pr * pr + pi * pi) / (qr * qr + qi * qi);
    return (s + p) / 2;
}
static void fresnel_of_metals(void) {
    static const double index[][2] = { { 0.14, 3.98 }, { 1.44, 1.6 }, { 0.2, 0.01 }, { 2.5, 4 }, { 1.5, 1e-6 }, { 100, 100 }, { 0.01, 7 } };
    int i, k;
    for (i = 0; i < 7; i++) {
        double eta = (double)(float)index[i][0], ka = (double)(float)index[i][1];
        for (k = 1; k <= 1000; k++) {
            float c = (float)k / 1000;
            test_case("index %g + i %g, cosine %g", eta, ka, (double)c);
            CHECK_NEAR(pti_fresnel_metal(c, (float)eta, (float)ka), metal_of(c, eta, ka), 2e-5);
        }
        CHECK_NEAR(pti_fresnel_metal(1, (float)eta, (float)ka), ((eta - 1) * (eta - 1) + ka * ka) / ((eta + 1) * (eta + 1) + ka * ka), 5e-6);
    }
    for (k = 1; k <= 1000; k++) {                        /* without k: a dielectric */
        float c = (float)k / 1000, cos_t;
        CHECK_NEAR(pti_fresnel_metal(c, 1.5f, 0), pti_fresnel(c, 1.5f, &cos_t), 1e-5);
    }
}
static void fresnel_mean(void) {
    static const double ior[] = { 1.1, 1.5, 2.4, 4, 1 / 1.5 };
    int i, k;
    for (i = 0; i < 5; i++) {
        double sum = 0;
        float cos_t;
        for (k = 0; k < 100000; k++) { double mu = (k + 0.5) / 100000; sum += (double)pti_fresnel((float)mu, (float)ior[i], &cos_t) * 2 * mu / 100000; }
        test_case("ior %g", ior[i]);
        CHECK_NEAR(pti_fresnel_mean((float)ior[i]), sum, 3e-3);
    }
}

/* ---- tables ---- */

/* E against many random samples of one bounce; the mean against the sum of E 2 mu dmu over the table. */
static double one_bounce(pt_vec3 wo, float ax, float ay, int n) {
    pt_rng rng;
    double sum = 0;
    int i;
    pt_rng_seed(&rng, 3, 9);
    for (i = 0; i < n; i++) {
        float u = pt_rng_float(&rng), v = pt_rng_float(&rng), lambda = 1 + pti_ggx_lambda(wo, ax, ay);
        pt_vec3 wi = pti_mirrored(wo, pti_sample_ggx(wo, ax, ay, u, v));
        if (wi.z > 0) sum += (double)(lambda / (lambda + pti_ggx_lambda(wi, ax, ay)));
    }
    return sum / n;
}
static void tables_of_albedo(void) {
    static pti_albedo round, stretched;
    static const double cosine[] = { 0.03, 0.2, 0.5, 0.9 };
    static const float rough[] = { 0.3f, 0.62f, 1 };
    int i, k;
    pti_albedo_build(&round);
    stretched.ax = 0.64f; stretched.ay = 0.09f;
    pti_albedo_build(&stretched);
    for (k = 0; k < 4; k++) {
        double phi = 0.9;
        for (i = 0; i < 3; i++) {
            test_case("roughness %g, cosine %g", (double)rough[i], cosine[k]);
            CHECK_NEAR(pti_albedo_at(&round.total[0], (float)cosine[k], rough[i] * (PTI_ALBEDO - 1)),
                       one_bounce(direction_at(cosine[k], 0.7), pti_alpha(rough[i]), pti_alpha(rough[i]), 100000), 5e-3);
        }
        test_case("stretched, cosine %g", cosine[k]);
        CHECK_NEAR(pti_albedo_at(&stretched.total[0], (float)cosine[k], (float)(phi / (STATS_PI / 2) * (PTI_ALBEDO - 1))),
                   one_bounce(direction_at(cosine[k], phi), 0.64f, 0.09f, 100000), 5e-3);
    }
    for (i = 0; i < 3; i++) {
        double sum = 0, row = (double)rough[i] * (PTI_ALBEDO - 1);
        for (k = 0; k < 10000; k++) { double mu = (k + 0.5) / 10000; sum += (double)pti_albedo_at(&round.total[0], (float)mu, (float)row) * 2 * mu / 10000; }
        test_case("roughness %g", (double)rough[i]);
        CHECK_NEAR(pti_albedo_mean_at(&round.total[0], (float)row / (PTI_ALBEDO - 1)), sum, 1e-4);
    }
    CHECK_NEAR(pti_albedo_at(&round.total[0], 1, PTI_ALBEDO - 1), 1 - log(2), 1e-3);     /* from above, alpha 1: mu = wi.z has the density */
    CHECK_NEAR(one_bounce(pt_v3(0, 0, 1), 1, 1, 100000), 1 - log(2), 5e-3);              /* 1/2, G2 / G1 is 2 mu / (1 + mu) */
}
typedef struct lost_light { const pti_albedo_table *t; float row; } lost_light;
static int lost_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    const lost_light *l = (const lost_light *)ctx;
    float u = pt_rng_float(rng), v = pt_rng_float(rng);
    *wi = direction_at((double)pti_sample_lost(l->t, l->row, v), 2 * STATS_PI * (double)u);
    return 1;
}
static double lost_pdf(void *ctx, pt_vec3 wi) {
    const lost_light *l = (const lost_light *)ctx;
    return wi.z > 0 ? (double)pti_pdf_lost(l->t, l->row, wi.z) : 0;
}
static void lost_directions(void) {
    static pti_albedo round;
    static const float row[] = { 0, 0.6f, 1, 7.3f, 7.8f, 31 };
    lost_light l;
    int i;
    pti_albedo_build(&round);
    for (i = 0; i < 6; i++) {
        l.t = &round.total[0]; l.row = row[i];
        test_case("row %g", (double)row[i]);
        chi2_directions(&(chi2_directions_desc){ .sample = lost_sample, .pdf = lost_pdf, .ctx = &l, .zoom = 1, .n = 20000, .tolerance = 0.004 });
    }
}

void test_microfacet(void) {
    RUN(distribution);
    RUN(visible_normals);
    RUN(fresnel_of_metals);
    RUN(fresnel_mean);
    RUN(tables_of_albedo);
    RUN(lost_directions);
}
