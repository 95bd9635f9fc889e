/* >>medium: phase functions against their densities, flights against closed forms, furnaces, agreement of all ways to find light. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "agreement.h"
#include "flights.h"

static const pt_shape everywhere = { 0 };
static const pt_material no_material = { 0 };
static pt_medium_desc grey_medium(float sigma_a, float sigma_s) {
    pt_medium_desc d;
    memset(&d, 0, sizeof d);
    d.sigma_a = pt_v3(sigma_a, sigma_a, sigma_a);
    d.sigma_s = pt_v3(sigma_s, sigma_s, sigma_s);
    return d;
}
static pt_volume fill_box(pt_scene *s, float lo, float hi, const pt_medium_desc *d) {
    return pt_add_volume(s, pt_add_box(s, pt_v3(lo, lo, lo), pt_v3(hi, hi, hi), NULL, no_material), pt_add_medium(s, d));
}

/* ---- phase functions ---- */

typedef struct phase_case { const char *name; pt_medium_desc d; double zoom; double ax, az; } phase_case;
typedef struct phase_ctx { pti_phase phase; pt_vertex x; } phase_ctx;
static int sample_phase(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    phase_ctx *c = (phase_ctx *)ctx;
    uint32_t a = pt_rng_u32(rng), b = pt_rng_u32(rng);
    return pti_phase_sample(&c->phase, &c->x, a, b, wi);
}
static double pdf_phase(void *ctx, pt_vec3 wi) {
    phase_ctx *c = (phase_ctx *)ctx;
    return pti_phase_pdf(&c->phase, &c->x, wi);
}
/* A user's: twice as much into the upper half as into the lower one. */
static float up_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    (void)user; (void)x;
    return pti_pdf_sphere() * (wi.y > 0 ? 4.0f : 2.0f) / 3;
}
static int up_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    float a = u[0] < 2.0f / 3 ? u[0] * 1.5f : u[0] * 3 - 2;
    (void)user; (void)x;
    *wi = pti_sample_sphere(a, u[1]);
    if ((wi->y > 0) != (u[0] < 2.0f / 3)) wi->y = -wi->y;
    return 1;
}
static void phases_fit_their_densities(void) {
    static const phase_case cases[] = {
        { "isotropic",    { .g = 0 }, 2, 0, 1 },
        { "HG 0.5",       { .g = 0.5f }, 2, 0, 1 },
        { "HG -0.7",      { .g = -0.7f }, 2, 0, 1 },
        { "HG 0.95",      { .g = 0.95f }, 2, 0, 1 },
        { "HG 0.99",      { .g = 0.99f }, 0.01, 0, 1 },
        { "HG -0.99",     { .g = -0.99f }, 0.01, 0, -1 },
        { "Rayleigh",     { .phase = PT_PHASE_RAYLEIGH }, 2, 0, 1 },
        { "two lobes",    { .phase = PT_PHASE_TWO_LOBES, .g = 0.8f, .g2 = -0.4f, .mix = 0.3f }, 2, 0, 1 },
        { "Draine",       { .phase = PT_PHASE_DRAINE, .g = 0.6f, .alpha = 28 }, 2, 0, 1 },
        { "Draine back",  { .phase = PT_PHASE_DRAINE, .g = -0.3f, .alpha = 1000 }, 2, 0, 1 },
        { "Draine 0.002", { .phase = PT_PHASE_DRAINE, .g = 0.002f, .alpha = 10 }, 2, 0, 1 },
        { "Draine 1e-4",  { .phase = PT_PHASE_DRAINE, .g = 1e-4f, .alpha = 10 }, 2, 0, 1 },
        { "droplets 5",   { .phase = PT_PHASE_DROPLETS, .droplet_um = 5 }, 2, 0, 1 },
        { "droplets 20",  { .phase = PT_PHASE_DROPLETS }, 0.002, 0, 1 },
        { "droplets 50",  { .phase = PT_PHASE_DROPLETS, .droplet_um = 50 }, 2, 1, 0 },
        { "user's",       { .phase = PT_PHASE_USER, .phase_pdf = up_pdf, .phase_sample = up_sample }, 2, 0, 1 },
    };
    size_t i;
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        phase_ctx c;
        chi2_directions_desc d;
        test_case("%s", cases[i].name);
        memset(&c.x, 0, sizeof c.x);
        c.x.wo = pti_normalize(i % 2 ? pt_v3(0.3f, -0.5f, 0.8f) : pt_v3(0, 0, -1));
        pti_phase_init(&c.phase, &cases[i].d);
        memset(&d, 0, sizeof d);
        d.sample = sample_phase; d.pdf = pdf_phase; d.ctx = &c;
        d.seed = i;
        if (cases[i].zoom < 2 || cases[i].ax == 0) {         /* about the way on, or about the way back */
            d.ax = -cases[i].az * (double)c.x.wo.x; d.ay = -cases[i].az * (double)c.x.wo.y; d.az = -cases[i].az * (double)c.x.wo.z;
        } else d.ax = 1;
        d.zoom = cases[i].zoom < 2 ? cases[i].zoom : 0;
        d.partial = cases[i].zoom < 2;
        chi2_directions(&d);
    }
}
/* The glow round lamps in fog, of one lamp, of three: what is drawn, over its density, fills all octants alike, and rings about
   the first lamp. (The density's poles are too sharp for a grid.) */
static void halos_fit_their_density(void) {
    static const pti_halos halos = { 3, { { { 0, 2, 0 }, 3, 0.2f }, { { 1, 0, 0.5f }, 1, 0.5f }, { { -0.02f, 0, 0.01f }, 0.1f, 1 }, { { 0, 0, 0 }, 0, 0 } } };
    int n, k, i;
    for (n = 1; n <= 3; n += 2) {
        pti_halos h = halos;
        pt_vertex x;
        pt_rng rng;
        stats_moments m[12];
        test_case("%d lamps", n);
        memset(m, 0, sizeof m);
        memset(&x, 0, sizeof x);
        pt_rng_seed(&rng, 8, (uint64_t)n);
        h.count = n;
        for (i = 0; i < 400000; i++) {
            float u[2];
            double p;
            pt_vec3 wi;
            u[0] = pt_rng_float(&rng); u[1] = pt_rng_float(&rng);
            if (!CHECK(pti_halo_sample(&h, &x, u, &wi))) return;
            p = (double)pti_halo_pdf(&h, &x, wi);
            for (k = 0; k < 8; k++) stats_push(m + k, (wi.x > 0) + 2 * (wi.y > 0) + 4 * (wi.z > 0) == k ? 1 / p : 0);
            for (k = 0; k < 4; k++) stats_push(m + 8 + k, wi.y > 0.5f * (float)k - 1 && wi.y <= 0.5f * (float)k - 0.5f ? 1 / p : 0);
        }
        for (k = 0; k < 12; k++) {
            CHECK_P(stats_t_test(m + k, STATS_PI * (k < 8 ? 0.5 : 1)));
            CHECK(stats_error(m + k) < 0.01 * m[k].mean);
        }
        CHECK(pti_halo_importance(&h, &x) > 0.02f && pti_halo_importance(&h, &x) < 1);
    }
}
/* Means of the cosine: g for HG; for Draine g (1 + alpha (3 + 2 g^2) / 5) / (1 + alpha (1 + 2 g^2) / 3). */
static void mean_cosines(void) {
    static const float g[] = { 0, 0.3f, -0.6f, 0.9f, 0.99f, 0.62f }, alpha[] = { 0, 0, 0, 0, 0, 28 };
    int i, k;
    for (i = 0; i < 6; i++) {
        stats_moments m = { 0, 0, 0 };
        double a = alpha[i], h = g[i], want = h * (1 + a * (3 + 2 * h * h) / 5) / (1 + a * (1 + 2 * h * h) / 3);
        for (k = 0; k < 100000; k++)
            stats_push(&m, (h < 0 ? -1 : 1) * (1 - (double)pti_sample_draine(fabsf(g[i]), alpha[i], ((float)k + 0.5f) / 100000)));
        test_case("g %g, alpha %g", h, a);
        CHECK_NEAR(m.mean, want, 2e-4);
    }
}

/* ---- flights against closed forms ---- */

static void check_flown(const flown *f, double T) {
    CHECK(!f->wrong);
    CHECK_P(stats_count_test(f->passed, f->n, T));
    CHECK_P(stats_t_test(&f->T, T) > 0 || fabs(f->T.mean - T) < 2e-6 ? (stats_variance(&f->T) < 1e-12 ? 1.0 : stats_t_test(&f->T, T)) : 0.0);
}
/* The unit box, once through along x, for each way to track. */
static void transmittance_of_a_box(void) {
    static float grid[16 * 3 * 2], blocks[40];
    int k, i, x;
    for (i = 0; i < 6; i++) for (x = 0; x < 16; x++) grid[i * 16 + x] = ((float)x + 0.5f) / 16;
    for (x = 0; x < 40; x++) blocks[x] = x % 20 < 10 ? 0.0f : x < 20 ? 1.0f : 2.0f;
    for (k = 0; k < 7; k++) {
        static const char *names[] = { "constant", "grid", "voxels", "function", "function with bounds", "bumps", "blocks" };
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0.5f, 1.5f);
        double tau = 2;
        flown f;
        test_case("%s", names[k]);
        if (k == 1 || k == 2) { d.grid = grid; d.nx = 16; d.ny = 3; d.nz = 2; d.nearest = k == 2; tau = 1; }
        if (k == 3 || k == 4) { d.density = ramp; d.density_max = k == 3 ? 2.5f : 1.1f; d.density_bound = k == 4 ? ramp_bound : NULL; tau = 1; }
        if (k == 5) { d.density = bumps; d.density_max = 1; tau = 2 * bumps_tau(); }
        if (k == 6) { d.grid = blocks; d.nx = 40; d.ny = d.nz = 1; d.nearest = 1; tau = 2 * 0.75; }
        fill_box(s, 0, 1, &d);
        if (!commit(s)) return;
        fly(s, pt_v3(-1, 0.3f, 0.6f), pt_v3(1, 0, 0), 100, 400000, &f);
        check_flown(&f, exp(-tau));
        fly(s, pt_v3(2, 0.3f, 0.6f), pt_v3(-1, 0, 0), 100, 100000, &f);
        check_flown(&f, exp(-tau));
        if (k != 1) { pt_scene_destroy(s); continue; }
        fly(s, pt_v3(0.25f, 0.3f, 0.6f), pt_v3(1, 0, 0), 0.5f, 400000, &f);      /* from inside, to a surface inside */
        check_flown(&f, exp(-2 * (0.75 * 0.75 - 0.25 * 0.25) / 2));
        fly(s, pt_v3(-0.5f, -0.25f, 0.4f), pt_v3(3, 1, 0), 100, 400000, &f);     /* y is above 0 for x > 0.25 */
        check_flown(&f, exp(-2 * sqrt(10.0) / 3 * (1 - 0.25 * 0.25) / 2));
        pt_scene_destroy(s);
    }
}
/* Trilinear: the optical depth along any ray, by quadrature. */
static void transmittance_of_a_grid(void) {
    static float grid[20 * 17 * 9];
    static const float rays[5][6] = { { -1, 0.2f, 0.3f, 1, 0.1f, 0.05f }, { 0.5f, -1, 0.5f, 0.01f, 1, 0.02f }, { 0.1f, 0.1f, 2, 0.2f, 0.3f, -1 },
                                      { 2, 2, 2, -1, -1.05f, -0.95f }, { 0.5f, 0.5f, 0.5f, -0.3f, 0.2f, 0.9f } };
    pt_scene *s = pt_scene_create(NULL);
    pt_medium_desc d = grey_medium(0.25f, 1.25f);
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 3, 3);
    for (i = 0; i < 20 * 17 * 9; i++) { float u = pt_rng_float(&rng); grid[i] = i / 340 % 4 == 1 || u < 0.5f ? 0 : u * u * 5; }
    d.grid = grid; d.nx = 20; d.ny = 17; d.nz = 9;
    fill_box(s, 0, 1, &d);
    if (!commit(s)) return;
    for (k = 0; k < 5; k++) {
        pt_vec3 o = pt_v3(rays[k][0], rays[k][1], rays[k][2]), dir = pti_normalize(pt_v3(rays[k][3], rays[k][4], rays[k][5]));
        double tau = 0;
        flown f;
        for (i = 0; i < 400000; i++) {
            pt_vec3 p = pti_madd(dir, ((float)i + 0.5f) * (4.0f / 400000), o);
            if (p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1 && p.z >= 0 && p.z <= 1) tau += 1.5 * (double)pti_grid_density(s->media, 0, p) * 4 / 400000;
        }
        test_case("ray %d, tau %g", k, tau);
        CHECK(tau > 0.5);
        fly(s, o, dir, 100, 400000, &f);
        check_flown(&f, exp(-tau));
    }
    pt_scene_destroy(s);
}
/* No density is above its cell's majorant, where single voxels stand out; and most cells between them are empty. */
static void majorants_hold(void) {
    static float grid[40 * 33 * 17];
    pt_scene *s = pt_scene_create(NULL);
    pt_medium_desc d = grey_medium(0, 1);
    pt_rng rng;
    int i, k, empty = 0;
    pt_rng_seed(&rng, 4, 4);
    for (i = 0; i < 40 * 33 * 17; i += 97) grid[i] = i % 5 ? 0 : 1 + pt_rng_float(&rng);
    d.grid = grid; d.nx = 40; d.ny = 33; d.nz = 17;
    for (k = 0; k < 2; k++) {
        d.nearest = k;
        fill_box(s, 0, 1, &d);
    }
    if (!commit(s)) return;
    for (i = 0; i < 400000; i++) {
        pt_vec3 u = stats_uniform3(&rng);
        const pti_volume *v = s->volumes.all + i % 2;
        int c[3], j;
        for (j = 0; j < 3; j++) c[j] = pti_voxel_index(pti_axis(u, j) * (float)v->cells[j], v->cells[j]);
        if (!CHECK(pti_grid_density(v->medium, 0, u) <= v->majorants[(c[2] * v->cells[1] + c[1]) * v->cells[0] + c[0]] * 1.000001f)) break;
    }
    for (i = 0; i < 5 * 5 * 3; i++) empty += s->volumes.all[0].majorants[i] <= 0;
    CHECK(empty > 5);
    pt_scene_destroy(s);
}
/* Bounds of all kinds: lengths inside by closed forms, from outside and from inside. */
static double ring_length(double x, double r, double R) {           /* along z through a torus of tube r, in its plane, off by x */
    double a = R + r > x ? sqrt((R + r) * (R + r) - x * x) : 0, b = R - r > x ? sqrt((R - r) * (R - r) - x * x) : 0;
    return 2 * (a - b);
}
static void bounds_of_all_kinds(void) {
    static const pt_xform turned = { { 0, 0, 2, 1,  0, 0.5f, 0, 0.2f,  -1, 0, 0, 3 } };
    static const pt_xform start = { { 1, 0, 0, 9,  0, 1, 0, 0,  0, 0, 1, 0 } }, stop = { { 1, 0, 0, -9,  0, 1, 0, 0,  0, 0, 2, 0 } };
    int k;
    for (k = 0; k < 9; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0, 0.7f);
        pt_medium m = pt_add_medium(s, &d);
        pt_vec3 org = pt_v3(0.1f, 0.2f, -5), dir = pt_v3(0, 0, 1);
        double length = 0, tolerance = 0;
        flown f;
        test_case("bounds %d", k);
        if (k == 0) { pt_add_volume(s, pt_add_sphere(s, pt_v3(0.1f, 0.2f, 1), 1.5f, no_material), m); length = 3; }
        if (k == 1) { pt_add_volume(s, pt_add_sphere(s, pt_v3(0.1f, 0.2f, 1), 1.5f, no_material), m); org.z = 1.5f; length = 1; }
        if (k == 2) { pt_add_volume(s, pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), &turned, no_material), m); length = 2; org = pt_v3(0, 0.3f, -5); }
        if (k == 3 || k == 4) {                                     /* concave: in, out, in, out */
            torus(s, pt_v3(0, 0, 0), 1, 0.4f, no_material);
            pt_add_volume(s, pti_last_shape(s), m);
            org = k == 3 ? pt_v3(0.3f, 0.001f, -5) : pt_v3(0.3f, 0.001f, -0.9f);
            length = ring_length(0.3, 0.4, 1) / (k == 3 ? 1 : 2);
            if (k == 4) length += sqrt(1.4 * 1.4 - 0.09) - 0.9 - length + (0.9 - sqrt(0.36 - 0.09)), length = sqrt(1.96 - 0.09) - sqrt(0.36 - 0.09) + 0.9 - sqrt(0.36 - 0.09);
            tolerance = 0.02;                                       /* it is made of 24 x 12 flat pieces */
        }
        if (k == 5 || k == 6) {                                     /* an instance, and a volume in an instance */
            pt_shape b = pt_add_box(inner, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, no_material);
            if (k == 6) pt_add_volume(inner, b, pt_add_medium(inner, &d));
            commit(inner);
            b = pt_add_instance(s, inner, &turned);
            if (k == 5) pt_add_volume(s, b, m);
            org = pt_v3(0, 0.3f, -5);
            length = 2;
        }
        if (k == 7) { pt_add_volume(s, everywhere, m); length = 10; }
        if (k == 8) {                                               /* in motion: half-way, it is there, and 1.5 as long */
            pt_add_volume(inner, pt_add_sphere(inner, pt_v3(0.1f, 0.2f, 0), 1, no_material), pt_add_medium(inner, &d));
            commit(inner);
            pt_add_moving_instance(s, inner, &start, &stop);
            length = 3;
        }
        fly_time = k == 8 ? 0.5f : 0;
        if (!commit(s)) return;
        fly(s, org, dir, k == 7 ? 10 : 100, 100000, &f);
        if (tolerance > 0) CHECK_NEAR(-log(f.T.mean) / 0.7, length, tolerance);
        else CHECK_NEAR(-log(f.T.mean) / 0.7, length, 1e-5);
        if (tolerance > 0) CHECK_P(stats_count_test(f.passed, f.n, f.T.mean));
        else CHECK_P(stats_count_test(f.passed, f.n, exp(-0.7 * length)));
        CHECK(s->geometry.bvh.root == PTI_NONE);                    /* nothing is left of them to meet */
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
    fly_time = 0;
}
/* Two that overlap are their sum; each is hit in proportion to what it has. Then a hundred of them, by their tree. */
static void overlapping_volumes_add_up(void) {
    static const float ramp_grid[4] = { 0, 1, 2, 3 };
    pt_scene *s = pt_scene_create(NULL);
    pt_medium_desc a = grey_medium(0.2f, 0.8f), b = grey_medium(0, 0.5f);
    double t1, t2, tau = 0;
    flown f;
    int k;
    b.grid = ramp_grid; b.nx = 4; b.ny = b.nz = 1; b.nearest = 1;
    fill_box(s, 0, 1, &a);
    fill_box(s, 0, 1, &b);
    if (!commit(s)) return;
    fly(s, pt_v3(-1, 0.5f, 0.5f), pt_v3(1, 0, 0), 100, 1000000, &f);
    check_flown(&f, exp(-1 - 0.75));
    for (t1 = t2 = 0, k = 0; k < 4; k++) {               /* expected hits of each, a quarter after the other */
        double sum = 1 + 0.5 * k, part = exp(-tau) * (1 - exp(-sum / 4)) / sum;
        t1 += part; t2 += part * 0.5 * k; tau += sum / 4;
    }
    CHECK_P(stats_count_test(f.hits[0], f.n, t1));
    CHECK_P(stats_count_test(f.hits[1], f.n, t2));
    pt_scene_destroy(s);
    s = pt_scene_create(NULL);
    a = grey_medium(0, 0.01f);
    for (k = 0; k < 100; k++) fill_box(s, -0.01f * (float)(k + 1), 0.01f * (float)(k + 1), &a);
    if (!commit(s)) return;
    fly(s, pt_v3(-3, 0.001f, 0.002f), pt_v3(1, 0, 0), 100, 100000, &f);
    check_flown(&f, exp(-0.01 * 0.02 * 5050));
    fly(s, pt_v3(0, 0.001f, 0.002f), pt_v3(1, 0, 0), 0.5f, 100000, &f);
    check_flown(&f, exp(-0.01 * (0.01 * 50 * 51 / 2 + 50 * 0.5)));
    fly(s, pt_v3(3, 0.001f, 0.002f), pt_v3(1, 0, 0), 100, 100, &f);
    CHECK(f.passed == f.n);
    pt_scene_destroy(s);
}
/* The marches' own expectation: prod (1 - sigma step). At tau 1 in 10 steps that is 5.2 % too little, at 3, 43 %. */
static void marches_are_as_biased_as_they_say(void) {
    static const float tau[] = { 1, 3, 0.5f, 1 };
    static const int steps[] = { 10, 10, 4, 700 };
    int k, way;
    for (way = 0; way < 2; way++) for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0.3f * tau[k], 0.7f * tau[k]);
        double want = pow(1 - (double)tau[k] / steps[k], steps[k]);
        flown f;
        test_case("march %d, tau %g in %d steps", way, (double)tau[k], steps[k]);
        d.tracking = way ? PT_TRACK_MARCH_CDF : PT_TRACK_MARCH;
        d.step = 1 / (float)steps[k] * 1.000001f;
        fill_box(s, 0, 1, &d);
        if (!commit(s)) return;
        fly(s, pt_v3(-1, 0.5f, 0.5f), pt_v3(1, 0, 0), 100, k == 3 ? 40000 : 400000, &f);
        CHECK_P(stats_count_test(f.passed, f.n, want));
        CHECK_NEAR(f.T.mean, want, k == 3 ? 5e-5 : 1e-5);
        if (k == 0) CHECK_NEAR(want / exp(-1.0) - 1, -0.052, 5e-4);
        if (k == 1) CHECK_NEAR(want / exp(-3.0) - 1, -0.43, 5e-3);
        fly(s, pt_v3(-3000, 0.5f, 0.5f), pt_v3(1, 0, 0), 4000, 1000, &f);
        if (k == 3) CHECK_NEAR(f.T.mean, want, 0.01 * want);            /* from afar, where floats are coarse */
        pt_scene_destroy(s);
    }
}


/* Bounds of densities are bounds for marches, too. */
static float half_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; (void)hi; return 0.5f; }
static float half_dense(void *user, pt_vec3 p) { (void)user; (void)p; return 0.5f; }
static void marches_keep_bounds(void) {
    int way, k;
    for (way = 0; way < 2; way++) for (k = 0; k < 2; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0.5f, 1.5f);
        flown f;
        test_case("march %d, %s", way, k ? "above its bound" : "within");
        d.tracking = way ? PT_TRACK_MARCH_CDF : PT_TRACK_MARCH;
        d.step = 0.1000001f;
        d.density = k ? ramp : half_dense; d.density_max = 1; d.density_bound = half_bound;
        fill_box(s, 0, 1, &d);
        if (!commit(s)) return;
        fly(s, pt_v3(-1, 0.5f, 0.5f), pt_v3(1, 0, 0), 100, 100000, &f);
        if (k) CHECK(f.wrong);
        else { CHECK(!f.wrong); CHECK_P(stats_count_test(f.passed, f.n, pow(0.9, 10))); }
        pt_scene_destroy(s);
    }
}

/* ---- furnaces, and what is known of scattering in depth ---- */

/* A lossless box under a white sky is white, whatever scatters in it how; from outside, and from inside. */
static void furnaces_are_white(void) {
    static const float grid[24] = { 0, 3, 1, 0.2f, 2, 0, 0.5f, 1,  1, 1, 0, 0, 3, 2, 0.1f, 0,  0, 0, 0, 2, 0, 1, 2, 0.3f };
    static const char *names[] = { "isotropic", "forwards", "backwards", "Rayleigh", "droplets", "user's", "grid", "function",
                                   "chromatic", "chromatic grid", "no red", "two", "march", "two lobes", "Draine", "droplets of 50",
                                   "a grid a channel", "chromatic march", "two chromatic marches", "chromatic march of long steps" };
    int k, inside;
    for (k = 0; k < 20; k++) for (inside = 0; inside < 2; inside++) {
        int colored = (k >= 8 && k < 12) || k >= 16;
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0, 2), e = grey_medium(0, 1);
        pt_render_desc v = view(inside ? pt_v3(0.2f, 0.1f, 0.3f) : pt_v3(3, 2, 4), pt_v3(0, 0, 0), inside ? 120 : 20, 16, colored ? 128 : 16);
        stats_moments m[3];
        pt_stats stats;
        static float rgb[16 * 16 * 3];
        int i, c;
        test_case("%s, %s", names[k], inside ? "inside" : "outside");
        memset(m, 0, sizeof m);
        v.max_depth = 100000;
        if (k == 1) d.g = 0.9f;
        if (k == 2) d.g = -0.6f;
        if (k == 3) d.phase = PT_PHASE_RAYLEIGH;
        if (k == 4) d.phase = PT_PHASE_DROPLETS;
        if (k == 5) { d.phase = PT_PHASE_USER; d.phase_pdf = up_pdf; d.phase_sample = up_sample; }
        if (k == 6 || k == 9 || k == 12) { d.grid = grid; d.nx = d.ny = d.nz = 2; }
        if (k == 7) { d.density = bumps; d.density_max = 1; }
        if (k >= 8 && k < 11) d.sigma_s = k < 10 ? pt_v3(0.5f, 1.5f, 3) : pt_v3(0, 1, 2);
        if (k == 11) e.sigma_s = pt_v3(2, 0.5f, 1), d.density = bumps, d.density_max = 1, d.sigma_s = pt_v3(1, 2, 3);
        if (k == 12) { d.tracking = PT_TRACK_MARCH; d.step = 0.05f; }
        if (k == 13) { d.phase = PT_PHASE_TWO_LOBES; d.g = 0.8f; d.g2 = -0.5f; d.mix = 0.3f; }
        if (k == 14) { d.phase = PT_PHASE_DRAINE; d.g = 0.6f; d.alpha = 30; }
        if (k == 15) { d.phase = PT_PHASE_DROPLETS; d.droplet_um = 50; }
        if (k == 16) { d.grid = grid; d.nx = d.ny = d.nz = 2; d.grid_channels = 3; }
        if (k >= 17) { d.sigma_s = pt_v3(0.5f, 2, 6); d.tracking = PT_TRACK_MARCH_CDF; d.step = 0.1f; }
        if (k == 19) d.step = 0.3f;                      /* some channels hit in each step */
        if (k == 18) { d.tracking = e.tracking = PT_TRACK_MARCH; e.sigma_s = pt_v3(2, 0.5f, 1); e.step = 0.07f; }
        fill_box(s, -1, 1, &d);
        if (k == 11 || k == 18) pt_add_volume(s, pt_add_sphere(s, pt_v3(0.5f, 0, 0), 1, no_material), pt_add_medium(s, &e));
        sky(s, 1);
        if (!commit(s) || !render(s, &v, rgb, &stats)) return;
        for (i = 0; i < 256; i++) for (c = 0; c < 3; c++) stats_push(&m[c], rgb[3 * i + c]);
        CHECK_EQ_INT(stats.discarded, 0);
        CHECK(stats.rays > (uint64_t)(256 * v.spp * (inside ? 2 : 1.5)));      /* it did scatter */
        for (c = 0; c < 3; c++) {
            if (colored) { CHECK_P(stats_t_test(&m[c], 1)); CHECK(stats_error(&m[c]) < 0.01); }
            else CHECK(fabs(m[c].mean - 1) < 1e-5 && stats_variance(&m[c]) < 1e-8);       /* each path is white */
        }
        pt_scene_destroy(s);
    }
}
/* Chandrasekhar's half space: see flights.h. */
static void half_space_albedo(void) {
    static const float albedo[] = { 0.5f, 0.9f, 0.99f }, mu[] = { 1, 0.4f };
    int i, k;
    for (i = 0; i < 3; i++) for (k = 0; k < 2; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(1 - albedo[i], albedo[i]);
        float sine = sqrtf(1 - mu[k] * mu[k]);
        pt_render_desc v = view(pt_v3(sine * 1000, mu[k] * 1000, 0), pt_v3(0, 0, 0), 0.01f, 64, i < 1 ? 160 : i < 2 ? 80 : 16);
        double want = 1 - sqrt(1 - (double)albedo[i]) * chandrasekhar_h((double)albedo[i], (double)mu[k]);
        stats_moments m;
        v.max_depth = 1000000;
        v.camera.up = pt_v3(0, 0, 1);
        v.seed = (uint64_t)i;
        pt_add_volume(s, pt_add_box(s, pt_v3(-10000, -10000, -10000), pt_v3(10000, 0, 10000), NULL, no_material), pt_add_medium(s, &d));
        sky(s, 1);
        if (!commit(s)) return;
        m = render_pixels(s, &v);
        test_case("albedo %g at %g: %g, should be %g", (double)albedo[i], (double)mu[k], m.mean, want);
        CHECK_P(stats_t_test(&m, want));
        CHECK_NEAR(m.mean, want, 0.005 * want);
        CHECK(stats_error(&m) < 0.002 * want);
        pt_scene_destroy(s);
    }
}
/* Absorption alone makes no noise: a white sky through coloured glass, a slab of smoke, and lamps behind. */
static void absorption_is_exact(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_medium_desc d = grey_medium(0, 0);
    static float rgb[8 * 8 * 3];
    pt_render_desc v = view(pt_v3(0, 0, 50), pt_v3(0, 0, 0), 0.01f, 8, 4);
    int i;
    d.sigma_a = pt_v3(0.1f, 1, 2);
    fill_box(s, -1, 1, &d);
    sky(s, 2);
    if (!commit(s) || !render(s, &v, rgb, NULL)) return;
    for (i = 0; i < 64; i++) {
        CHECK_NEAR(rgb[3 * i], 2 * exp(-0.2), 1e-5); CHECK_NEAR(rgb[3 * i + 1], 2 * exp(-2.0), 1e-5); CHECK_NEAR(rgb[3 * i + 2], 2 * exp(-4.0), 1e-5);
    }
    pt_scene_destroy(s);
}
/* A glowing slab of depth l: epsilon (1 - exp(-sigma l)) / sigma; without sigma, epsilon l. As a grid and with a function. */
static float halves(void *user, pt_vec3 p) { (void)user; return p.z > 0 ? 1.0f : 0.5f; }
static pt_vec3 red_above(void *user, pt_vec3 p) { (void)user; return p.z > 0 ? pt_v3(1, 0, 0) : pt_v3(0, 2, 0); }
static void glow_of_a_slab(void) {
    static const float grid[2] = { 0.5f, 1 }, three[6] = { 0.5f, 1,  1, 0,  0.25f, 0.25f };
    static float cells[32];                              /* nothing, then 0.1, then 1: in majorants of their own */
    int k;
    for (k = 8; k < 32; k++) cells[k] = k < 24 ? 0.1f : 1;
    for (k = 0; k < 9; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0.5f, k == 1 ? 0.3f : 0);
        pt_render_desc v = view(pt_v3(0, 0, 50), pt_v3(0, 0, 0), 0.01f, 32, k == 1 ? 1 : 256);
        stats_moments m[3];
        static float rgb[32 * 32 * 3];
        double want[3], sigma;
        int i, c;
        test_case("slab %d", k);
        memset(m, 0, sizeof m);
        v.max_depth = k == 1 ? 1 : 0;
        d.emission = pt_v3(3, 2, 1);
        if (k == 2) { d.grid = grid; d.nx = d.ny = 1; d.nz = 2; d.nearest = 1; }
        if (k == 3) { d.density = halves; d.density_max = 1; }
        if (k == 4) d.sigma_a = pt_v3(0, 0, 0);
        if (k == 5) d.sigma_a = pt_v3(0.1f, 1, 4);
        if (k == 6) d.glow = red_above;
        if (k == 7) { d.grid = cells; d.nx = d.ny = 1; d.nz = 32; d.nearest = 1; }
        if (k == 8) { d.grid = three; d.nx = d.ny = 1; d.nz = 2; d.nearest = 1; d.grid_channels = 3; }
        fill_box(s, -1, 1, &d);
        if (!commit(s) || !render(s, &v, rgb, NULL)) return;
        for (i = 0; i < 1024; i++) for (c = 0; c < 3; c++) stats_push(&m[c], rgb[3 * i + c]);
        for (c = 0; c < 3; c++) {
            sigma = 0.5 + (k == 1 ? 0.3 : 0);
            if (k == 5) sigma = c == 0 ? 0.1 : c == 1 ? 1 : 4;
            want[c] = (3 - c) * (k == 4 ? 2 : (1 - exp(-2 * sigma)) / sigma);
            if (k == 2 || k == 3) want[c] = (3 - c) * ((1 - exp(-0.5)) + exp(-0.5) * (1 - exp(-0.25))) / 0.5;
            if (k == 7) want[c] = (3 - c) * ((1 - exp(-0.25)) + exp(-0.25) * (1 - exp(-0.05))) / 0.5;
            if (k == 8) want[c] = (3 - c) * (1 - exp(-0.5 * (double)(three[2 * c] + three[2 * c + 1]))) / 0.5;
            if (k == 6) want[c] = c == 0 ? 3 * (1 - exp(-0.5)) / 0.5 : c == 1 ? 4 * exp(-0.5) * (1 - exp(-0.5)) / 0.5 : 0;
        }
        if (k == 1) { CHECK(m[0].mean > want[0]); pt_scene_destroy(s); continue; }       /* and what glow is scattered here */
        for (c = 0; c < 3; c++) if (want[c] > 0) { CHECK_P(stats_t_test(&m[c], want[c])); CHECK(stats_error(&m[c]) < 0.005 * want[c]); } else CHECK(m[c].mean == 0);
        pt_scene_destroy(s);
    }
}

/* At the rim of a mesh, seen from afar, the wall that a ray enters by may seem to lie behind the one it leaves by: which once meant
   that it had been inside all the way. No chord of the octahedron is longer than 2. */
static void rims_far_away_do_not_glow(void) {
    static const float p[18] = { 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1 };
    static const uint32_t index[24] = { 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5 };
    static float rgb[128 * 128 * 3];
    int far;
    for (far = 0; far < 2; far++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0, 0);
        pt_render_desc v = view(pt_v3(far ? 1000.0f : 2, far ? 200.0f : 1, far ? 1100.0f : 2), pt_v3(0, 0, 0), far ? 0.1f : 50.0f, 128, 64);
        float most = 0;
        int i;
        test_case(far ? "1500 m away" : "3 m away");
        d.emission = pt_v3(1, 1, 1);
        pt_add_volume(s, pt_add_mesh(s, &(pt_mesh_desc){ .positions = p, .vertex_count = 6, .indices = index, .index_count = 24 }),
                      pt_add_medium(s, &d));
        if (!commit(s) || !render(s, &v, rgb, NULL)) return;
        for (i = 0; i < 128 * 128 * 3; i++) most = pti_max(most, rgb[i]);
        CHECK(most > 1.2f && most <= 2.001f);
        pt_scene_destroy(s);
    }
}
/* What glows far off, 300 mean free paths of it or without an end, in light that fades: epsilon / sigma, a channel. By itself; in
   dark fog; with a channel that meets nothing; on a grid. */
static void far_glow_is_seen(void) {
    static const char *names[] = { "everywhere", "box", "in dark fog", "a clear channel", "grid" };
    static const float one[1] = { 1 };
    int k, i, c;
    for (k = 0; k < 5; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0, 0), dark = grey_medium(0.25f, 0);
        pt_render_desc v = view(pt_v3(0, 0, k == 1 || k == 4 ? 400.0f : 0.0f), pt_v3(0, 0, -1), 20, 16, 256);
        float want[3] = { 2, 1, 0.5f };
        stats_moments m[3];
        static float rgb[16 * 16 * 3];
        test_case(names[k]);
        memset(m, 0, sizeof m);
        d.sigma_a = pt_v3(0.25f, 0.5f, 1);
        d.emission = pt_v3(0.5f, 0.5f, 0.5f);
        if (k == 2) { d.sigma_a = pt_v3(0, 0, 0); want[1] = want[2] = 2; }
        if (k == 3) {                                    /* a furnace, but for red: sigma_a = epsilon */
            d.sigma_a = d.emission = pt_v3(0, 0.1f, 0.1f);
            d.sigma_s = pt_v3(0, 0.02f, 0.02f);
            want[0] = 0; want[1] = want[2] = 1;
        }
        if (k == 4) { d.grid = one; d.nx = d.ny = d.nz = 1; }
        if (k == 1 || k == 4) fill_box(s, -300, 300, &d); else pt_add_volume(s, everywhere, pt_add_medium(s, &d));
        if (k == 2) pt_add_volume(s, everywhere, pt_add_medium(s, &dark));
        if (!commit(s) || !render(s, &v, rgb, NULL)) return;
        for (i = 0; i < 256; i++) for (c = 0; c < 3; c++) stats_push(&m[c], rgb[3 * i + c]);
        for (c = 0; c < 3; c++) {
            if (want[c] == 0) { CHECK(m[c].mean == 0); continue; }
            CHECK_P(stats_t_test(&m[c], want[c]));
            CHECK(stats_error(&m[c]) < 0.02 * want[c]);
        }
        pt_scene_destroy(s);
    }
}

/* Beside a lamp, in fog through which blue comes nowhere: what scatters once, by quadrature. */
static void lamp_in_fog_deep_for_blue(void) {
    static const float blue[3] = { 3, 12, 40 };
    int k, i, c;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc m = grey_medium(0, 0);
        pt_light_desc l;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(1, 0, -10), 0.01f, 8, 1024);
        double sigma[3] = { 0.3, 0.1, 0 }, end, dx = 1 / sqrt(101.0), dz = -10 / sqrt(101.0), t, x, z, r, want[3] = { 0, 0, 0 };
        stats_moments got[3];
        float rgb[8 * 8 * 3];
        test_case("blue %g", blue[k]);
        memset(&l, 0, sizeof l);
        memset(got, 0, sizeof got);
        sigma[2] = blue[k];
        m.sigma_s = pt_v3(0.3f, 0.1f, blue[k]);
        l.kind = PT_LIGHT_POINT; l.position = pt_v3(0, 0, -10); l.radius = 0.005f; l.color = pt_v3(100, 100, 100);
        pt_add_volume(s, pt_add_sphere(s, pt_v3(0, 0, -5), 8, no_material), pt_add_medium(s, &m));
        pt_add_light(s, &l);
        d.max_depth = 1;
        if (!commit(s) || !render(s, &d, rgb, NULL)) return;
        end = -5 * dz + sqrt(25 * dz * dz - 25 + 64);
        for (i = 0; i < 100000; i++) {
            t = (i + 0.5) * 1e-5 * end; x = dx * t; z = dz * t + 10;
            r = sqrt(x * x + z * z);
            for (c = 0; c < 3; c++)
                want[c] += 1e-5 * end * sigma[c] * exp(-sigma[c] * (t + r)) / (4 * STATS_PI) * 100 / (4 * STATS_PI * r * r);
        }
        for (i = 0; i < 64; i++) for (c = 0; c < 3; c++) stats_push(&got[c], rgb[3 * i + c]);
        for (c = 0; c < 2; c++) { CHECK_P(stats_t_test(&got[c], want[c])); CHECK(stats_error(&got[c]) < 0.02 * want[c]); }
        CHECK(got[2].mean < 1e-6);
        pt_scene_destroy(s);
    }
}

/* A ball that glows and absorbs nothing lights what is d below its middle as a point would: epsilon V / d^2. As a ball, as a grid
   with much of nothing about it, as a function with bounds, as an instance. And it is aimed at: noise is small. */
static float in_ball(void *user, pt_vec3 p) { (void)user; p.y -= 2; return pti_dot(p, p) < 0.09f ? 1.0f : 0.0f; }
static float ball_bound(void *user, pt_vec3 lo, pt_vec3 hi) {
    pt_vec3 p = pti_max3(pti_min3(pt_v3(0, 2, 0), hi), lo);
    return in_ball(user, p);
}
static void fire_lights_a_floor(void) {
    static float cells[40 * 40 * 40];
    static const double most[4] = { 0.008, 0.035, 0.012, 0.008 };    /* not aimed at: 0.02 to 0.04 */
    int k, i, count = 0;
    for (i = 0; i < 64000; i++) {                        /* in the cube of [-1,1]^3 about the middle: a voxel is 0.05 wide */
        float x = (float)(i % 40) - 19.5f, y = (float)(i / 40 % 40) - 19.5f, z = (float)(i / 1600) - 19.5f;
        count += (cells[i] = x * x + y * y + z * z < 36 ? 1.0f : 0.0f) > 0;
    }
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner = pt_scene_create(NULL), *of = k == 3 ? inner : s;
        pt_medium_desc m = grey_medium(0, 0);
        pt_xform up = { { 1, 0, 0, 0,  0, 1, 0, 1,  0, 0, 1, 0 } };
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 32, 64);
        stats_moments got;
        double V = k == 1 ? count * 1.25e-4 : 4 * STATS_PI / 3 * 0.027, want = 0.8 / STATS_PI * 5 * V / 4;
        test_case("fire %d", k);
        m.emission = pt_v3(5, 5, 5);
        if (k == 1) { m.grid = cells; m.nx = m.ny = m.nz = 40; m.nearest = 1; }
        if (k == 2) { m.density = in_ball; m.density_max = 1; m.density_bound = ball_bound; }
        if (k == 0 || k == 3) pt_add_volume(of, pt_add_sphere(of, pt_v3(0, k ? 1 : 2, 0), 0.3f, no_material), pt_add_medium(of, &m));
        else pt_add_volume(s, pt_add_box(s, pt_v3(-1, 1, -1), pt_v3(1, 3, 1), NULL, no_material), pt_add_medium(s, &m));
        if (k == 3 && commit(inner)) pt_add_instance(s, inner, &up);
        floor_of(s, 5, diffuse(s, 0.8f));
        if (!commit(s)) return;
        got = render_pixels(s, &d);
        CHECK_P(stats_t_test(&got, want));
        CHECK(stats_error(&got) < most[k] * want);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}

/* What scatters and glows: marches of short steps see what exact flights do, no farther than they come. */
static void marches_glow_as_far_as_they_come(void) {
    double exact = 0;
    int k;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(1, 2);
        pt_render_desc v = view(pt_v3(0, 0.3f, 4), pt_v3(0, 0, 0), 15, 16, 256);
        stats_moments m;
        test_case("tracking %d", k);
        d.emission = pt_v3(1, 1, 1);
        d.tracking = (pt_tracking)k;
        d.step = 0.01f;
        fill_box(s, -1, 1, &d);
        v.max_depth = 1000;
        if (!commit(s)) return;
        m = render_pixels(s, &v);
        if (k == 0) exact = m.mean;
        CHECK(exact > 0.5);
        CHECK_NEAR(m.mean, exact, 0.03 * exact);         /* their bias: 1.5 % here */
        pt_scene_destroy(s);
    }
}
/* Seven candles, and thirty, more than are aimed at one by one: each lights the floor below as a point would, without much noise. */
static void many_fires_light_a_floor(void) {
    static const int candles[2] = { 7, 30 };
    static const double most[2] = { 0.015, 0.015 };    /* not aimed at: 0.04, 0.018 */
    int i, k;
    for (i = 0; i < 2; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc m = grey_medium(0, 0);
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 32, 64);
        stats_moments got;
        double want = 0;
        m.emission = pt_v3(5, 5, 5);
        for (k = 0; k < candles[i]; k++) {
            double x = 1.5 * cos(k), z = 1.5 * sin(k), d2 = x * x + 4 + z * z;
            pt_add_volume(s, pt_add_sphere(s, pt_v3((float)x, 2, (float)z), 0.1f, no_material), pt_add_medium(s, &m));
            want += 0.8 / STATS_PI * 5 * (4 * STATS_PI / 3 * 0.001) * 2 / (d2 * sqrt(d2));
        }
        floor_of(s, 5, diffuse(s, 0.8f));
        if (!commit(s)) return;
        test_case("%d candles", candles[i]);
        got = render_pixels(s, &d);
        CHECK_P(stats_t_test(&got, want));
        CHECK(stats_error(&got) < most[i] * want);
        if (getenv("PT_TEST_FACTORS")) printf("    error %.4f\n", stats_error(&got) / want);
        pt_scene_destroy(s);
    }
}

/* ---- agreement of naive, mixture, NEE and NEE to all ---- */

static const struct { const char *name; pt_integrator integrator; pt_weights weights; } ways[] = {
    { "naive",   PT_INTEGRATOR_MIXTURE, { 1, 0, 0 } },
    { "mixture", PT_INTEGRATOR_MIXTURE, { 0, 0, 0 } },
    { "nee",     PT_INTEGRATOR_NEE,     { 0, 0, 0 } },
    { "nee all", PT_INTEGRATOR_NEE_ALL, { 0, 0, 0 } },
};
static void ways_agree(const char *name, scene_builder *build, int naive_spp) {
    stats_moments reference[BLOCKS], m[BLOCKS];
    int k;
    memset(reference, 0, sizeof reference);
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, k ? 32 : naive_spp);
        char what[100];
        inner = build(s, &d);
        d.weights = ways[k].weights;
        d.integrator = ways[k].integrator;
        memset(m, 0, sizeof m);
        if (!commit(s)) return;
        push_blocks(k ? m : reference, s, &d, k ? 24 : 32, (uint64_t)(1000 * (k + 2)));
        snprintf(what, sizeof what, "%s, naive and %s", name, ways[k].name);
        if (k) compare_blocks(what, m, reference);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
static pt_scene *lamp_in_fog(pt_scene *s, pt_render_desc *d) {
    pt_medium_desc m = grey_medium(0.05f, 0.25f);
    m.g = 0.5f;
    floor_of(s, 5, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(0, 1, 0), 0.5f, lamp(s, 5, 0));
    pt_add_volume(s, everywhere, pt_add_medium(s, &m));
    d->camera.eye = pt_v3(0, 1.5f, 4); d->camera.target = pt_v3(0, 0.7f, 0);
    return NULL;
}
static pt_scene *juice_in_glass(pt_scene *s, pt_render_desc *d) {
    pt_medium_desc m = grey_medium(0, 1);
    m.sigma_a = pt_v3(0.1f, 1, 3);
    floor_of(s, 5, diffuse(s, 0.5f));
    pt_add_box(s, pt_v3(-0.6f, 0.01f, -0.6f), pt_v3(0.6f, 1.4f, 0.6f), NULL,
               pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.33f, .inside = pt_add_medium(s, &m) }));
    quad(s, -1.5f, 2.5f, -1.5f, 3, 0, 0, 0, 0, 3, lamp(s, 3, 0));
    sky(s, 0.3f);
    d->camera.eye = pt_v3(0, 1.5f, 4); d->camera.target = pt_v3(0, 0.6f, 0);
    return NULL;
}
static pt_scene *mesh_in_two_media(pt_scene *s, pt_render_desc *d) {
    pt_medium_desc a = grey_medium(0.1f, 0.6f), b = grey_medium(0, 0);
    b.sigma_s = pt_v3(0.9f, 0.5f, 0.2f); b.sigma_a = pt_v3(0, 0.3f, 0.1f);
    b.g = -0.4f;
    floor_of(s, 5, diffuse(s, 0.5f));
    torus(s, pt_v3(0, 0.7f, 0), 0.8f, 0.3f, colored(s, 0.8f, 0.5f, 0.3f));
    pt_add_volume(s, pt_add_box(s, pt_v3(-1, 0.2f, -1), pt_v3(0.5f, 1.2f, 1), NULL, no_material), pt_add_medium(s, &a));
    pt_add_volume(s, pt_add_sphere(s, pt_v3(0.3f, 0.5f, 0.4f), 0.9f, no_material), pt_add_medium(s, &b));
    quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, lamp(s, 2, 1));
    sunny(s, 0.3f, 0);
    d->camera.eye = pt_v3(0, 1.5f, 4); d->camera.target = pt_v3(0, 0.6f, 0);
    return NULL;
}
static pt_scene *smoke_of(pt_scene *s, pt_render_desc *d, int channels) {
    static float grid[3 * 24 * 24 * 24];
    pt_medium_desc m = grey_medium(0, 0);
    int x, y, z;
    for (x = 0; x < 2 * 24 * 24 * 24; x++) grid[24 * 24 * 24 + x] = x / 200 % 4 ? 0.3f : 1.5f;       /* green and blue, of three */
    for (z = 0; z < 24; z++) for (y = 0; y < 24; y++) for (x = 0; x < 24; x++) {
        float a = (float)x - 11.5f, b = (float)y - 11.5f, c = (float)z - 11.5f, r = sqrtf(a * a + b * b + c * c) / 12;
        grid[(z * 24 + y) * 24 + x] = r < 0.9f && (x / 4 + y / 5 + z / 3) % 3 ? (1 - r) * 2 : 0;
    }
    m.sigma_s = pt_v3(4, 2, 1); m.sigma_a = pt_v3(0.2f, 0.1f, 1);
    m.g = 0.3f;
    m.grid = grid; m.nx = m.ny = m.nz = 24; m.grid_channels = channels;
    floor_of(s, 5, diffuse(s, 0.5f));
    pt_add_volume(s, pt_add_box(s, pt_v3(-1, 0.1f, -1), pt_v3(1, 2, 1), NULL, no_material), pt_add_medium(s, &m));
    quad(s, 1.5f, 0.2f, -1, 0, 0, 2, 0, 1.5f, 0, lamp(s, 3, 1));
    sunny(s, 0.5f, 0);
    d->camera.eye = pt_v3(0, 1.5f, 4.5f); d->camera.target = pt_v3(0, 0.8f, 0);
    return NULL;
}
static pt_scene *chromatic_smoke(pt_scene *s, pt_render_desc *d) { return smoke_of(s, d, 1); }
static pt_scene *smoke_a_channel(pt_scene *s, pt_render_desc *d) { return smoke_of(s, d, 3); }
static pt_scene *inside_a_cloud(pt_scene *s, pt_render_desc *d) {
    pt_medium_desc m = grey_medium(0.02f, 1);
    m.density = bumps; m.density_max = 1;
    m.g = 0.6f;
    pt_add_volume(s, pt_add_sphere(s, pt_v3(0, 0, 0), 2, no_material), pt_add_medium(s, &m));
    pt_add_sphere(s, pt_v3(0.5f, 0, 0), 0.4f, diffuse(s, 0.7f));
    sunny(s, 1, 1);
    d->camera.eye = pt_v3(0, 0.2f, 1.5f); d->camera.target = pt_v3(0, 0, 0); d->camera.vfov_deg = 70;
    return NULL;
}
/* A ring, a placed ball in motion, a turned box of fire; a lamp inside of one, users' densities everywhere. */
static pt_scene *many_bounds(pt_scene *s, pt_render_desc *d) {
    static const float fire[3 * 4 * 3] = { 0, 1, 0, 2, 3, 1, 1, 2, 1, 0, 1, 0,  0, 2, 0, 3, 4, 2, 2, 2, 1, 0, 0, 0,  0, 0, 0, 1, 1, 1, 0, 1, 0, 0, 0, 0 };
    static const pt_xform from = { { 1, 0, 0, -1,  0, 1, 0, 0.8f,  0, 0, 1, 0.5f } }, to = { { 1, 0, 0, -1,  0, 1.5f, 0, 1,  0, 0, 1, 0.5f } };
    static const pt_xform turned = { { 0.7f, -0.7f, 0, 1,  0.7f, 0.7f, 0, 0.6f,  0, 0, 1, 0 } };
    pt_scene *inner = pt_scene_create(NULL);
    pt_medium_desc a = grey_medium(0.2f, 2), b = grey_medium(0.5f, 0.5f), c = grey_medium(0.4f, 0.1f);
    b.sigma_s.z = 2; b.phase = PT_PHASE_DROPLETS;
    c.emission = pt_v3(0.6f, 0.3f, 0.1f); c.grid = fire; c.nx = 3; c.ny = 4; c.nz = 3;
    pt_add_volume(inner, pt_add_sphere(inner, pt_v3(0, 0, 0), 0.5f, no_material), pt_add_medium(inner, &b));
    commit(inner);
    pt_add_moving_instance(s, inner, &from, &to);
    torus(s, pt_v3(0, 0.5f, 0), 0.8f, 0.3f, no_material);
    pt_add_volume(s, pti_last_shape(s), pt_add_medium(s, &a));
    pt_add_volume(s, pt_add_box(s, pt_v3(-0.4f, -0.4f, -0.4f), pt_v3(0.4f, 0.4f, 0.4f), &turned, no_material), pt_add_medium(s, &c));
    floor_of(s, 5, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(0.8f, 0.5f, 0), 0.2f, lamp(s, 3, 0));
    quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, lamp(s, 2, 1));
    add_sphere(s, 0.1f);
    d->camera.eye = pt_v3(0, 2, 3.5f); d->camera.target = pt_v3(0, 0.4f, 0);
    d->camera.shutter_close = 1;
    return inner;
}
/* A ball of droplets in the sun, which is wide, so that it can be hit by chance. */
static pt_scene *sunlit_droplets(pt_scene *s, pt_render_desc *d) {
    pt_medium_desc m = grey_medium(0.05f, 3);
    m.phase = PT_PHASE_TWO_LOBES; m.g = 0.8f; m.g2 = -0.3f; m.mix = 0.2f;
    m.density = bumps; m.density_max = 1;
    pt_add_volume(s, pt_add_sphere(s, pt_v3(0, 0, 0), 1, no_material), pt_add_medium(s, &m));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { 0.2f, -0.5f, 1 }, .color = { 3, 3, 3 }, .radius_deg = 8 });
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { 0.5f, -1, -1 }, .color = { 1, 1, 1 }, .radius_deg = 8 });
    sky(s, 0.1f);
    d->camera.eye = pt_v3(0, 0.5f, 4); d->camera.target = pt_v3(0, 0, 0);
    return NULL;
}
#define AGREES(name, build, spp) static void name(void) { ways_agree(#build, build, spp); }
AGREES(agrees_on_a_lamp_in_fog, lamp_in_fog, 192)
AGREES(agrees_on_juice, juice_in_glass, 128)
AGREES(agrees_on_a_mesh_in_two_media, mesh_in_two_media, 96)
AGREES(agrees_on_smoke, chromatic_smoke, 96)
AGREES(agrees_on_smoke_a_channel, smoke_a_channel, 96)
AGREES(agrees_inside_a_cloud, inside_a_cloud, 96)
AGREES(agrees_on_many_bounds, many_bounds, 128)
AGREES(agrees_on_droplets, sunlit_droplets, 512)
/* The aureole's density: what is drawn at one of its particles, over the density, fills octants alike. */
static void aureoles_fit_their_density(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, 1);
    stats_moments m[8];
    pt_vertex x;
    pt_rng rng;
    int i, k;
    sunlit_droplets(s, &d);
    if (!commit(s)) return;
    memset(m, 0, sizeof m);
    memset(&x, 0, sizeof x);
    CHECK(pti_aureole_importance(s, &x) == 0);
    x.volume.id = 1;
    x.wo = pt_v3(1, 0, 0);
    CHECK(pti_aureole_importance(s, &x) == 1);
    pt_rng_seed(&rng, 9, 9);
    for (i = 0; i < 1000000; i++) {
        float u[2];
        pt_vec3 wi;
        double p;
        u[0] = pt_rng_float(&rng); u[1] = pt_rng_float(&rng);
        if (!CHECK(pti_aureole_sample(s, &x, u, &wi))) return;
        p = (double)pti_aureole_pdf(s, &x, wi);
        for (k = 0; k < 8; k++) stats_push(m + k, (wi.x > 0) + 2 * (wi.y > 0) + 4 * (wi.z > 0) == k ? 1 / p : 0);
    }
    for (k = 0; k < 8; k++) { CHECK_P(stats_t_test(m + k, STATS_PI / 2)); CHECK(stats_error(m + k) < 0.02 * m[k].mean); }
    pt_scene_destroy(s);
}

/* ---- rendering: bits, limits, warnings ---- */

/* The same bits for any tile, number of threads and instruction set. */
static void bits_are_the_same(void) {
    static float a[24 * 24 * 3], b[24 * 24 * 3];
    static const char *isas[] = { "scalar", "sse2", "avx2", "neon" };
    scene_builder *builders[] = { many_bounds, chromatic_smoke, mesh_in_two_media };
    int k, i;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 24, 4);
        inner = builders[k](s, &d);
        if (!commit(s) || !render(s, &d, a, NULL)) return;
        d.tile = 5; d.threads = 3;
        if (render(s, &d, b, NULL)) CHECK(!memcmp(a, b, sizeof a));
        for (i = 0; i < 4; i++) {
            if (!pti_isa_supported(pti_isa_by_name(isas[i]))) continue;
            d.isa = isas[i];
            if (render(s, &d, b, NULL)) CHECK(!memcmp(a, b, sizeof a));
        }
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
/* A limit of one diffuse event is single scattering. */
static void limits_count_scattering(void) {
    static float one[16 * 16 * 3], deep[16 * 16 * 3], diffuse_one[16 * 16 * 3];
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 16, 32);
    double sum[3] = { 0, 0, 0 };
    int i;
    mesh_in_two_media(s, &d);
    if (!commit(s)) return;
    d.weights.bsdf = d.weights.lights = d.weights.environment = 1;
    render(s, &d, deep, NULL);
    d.max_depth = 1;
    render(s, &d, one, NULL);
    d.max_depth = 0; d.max_diffuse = 1;
    render(s, &d, diffuse_one, NULL);
    for (i = 0; i < 768; i++) { sum[0] += (double)deep[i]; sum[1] += (double)one[i]; sum[2] += (double)diffuse_one[i]; }
    CHECK_NEAR(sum[1], sum[2], 0.01 * sum[1]);
    CHECK(sum[0] > 1.1 * sum[1]);
    pt_scene_destroy(s);
}
/* A function above its maximum is noticed: counted, discarded, said once. */
typedef struct heard { int times; char text[300]; } heard;
static void hear(void *user, pt_result code, const char *message) {
    heard *h = (heard *)user;
    (void)code;
    h->times++;
    snprintf(h->text, sizeof h->text, "%s", message);
}
static float nan_density(void *user, pt_vec3 p) { (void)user; return p.x > 0.5f ? NAN : 0.5f; }
static float hardly_any(void *user, pt_vec3 p) { (void)user; (void)p; return 1e-9f; }
static void too_dense_functions_are_noticed(void) {
    static const struct { float (*density)(void *user, pt_vec3 p); float most, sigma_s; int fine; } cases[] = {
        { ramp, 0.8f, 2, 0 }, { ramp, 1, 2, 1 }, { nan_density, 0.8f, 2, 0 }, { hardly_any, 1e12f, 2, 0 },      /* would fly for years */
        { ramp, 0.8f, 0, 0 }, { nan_density, 0.8f, 0, 0 }, { hardly_any, 1e12f, 0, 0 },     /* only darkens: never hit, but looked at */
        { NULL, 0, 2, 0 } };                             /* a march of tiny steps */
    int k;
    for (k = 0; k < (int)(sizeof cases / sizeof *cases); k++) {
        heard h = { 0, "" };
        pt_scene *s = pt_scene_create(&(pt_scene_desc){ .logger = { hear, &h } });
        pt_medium_desc d = grey_medium(0.5f, cases[k].sigma_s);
        pt_render_desc v = view(pt_v3(3, 2, 4), pt_v3(0.5f, 0.5f, 0.5f), 20, cases[k].most > 1 ? 4 : 16, 4);
        pt_stats stats = { 0 };
        static float rgb[16 * 16 * 3];
        d.density = cases[k].density;
        d.density_max = cases[k].most;
        if (!d.density) { d.tracking = PT_TRACK_MARCH; d.step = 1e-9f; }
        fill_box(s, 0, 1, &d);
        sky(s, 1);
        if (!commit(s) || !render(s, &v, rgb, &stats)) return;
        CHECK((stats.exceeded > 0) == !cases[k].fine);
        CHECK(stats.discarded == stats.exceeded && stats.exceeded < 16 * 16 * 4);
        CHECK_EQ_INT(h.times, !cases[k].fine);
        CHECK(cases[k].fine || strstr(h.text, "density_max"));
        pt_scene_destroy(s);
    }
}
/* What is refused, and in which words. */
static float low_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; (void)hi; return 3; }
static float negative_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; (void)hi; return -1; }
static float nan_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; (void)hi; return NAN; }
static pt_vec3 no_glow(void *user, pt_vec3 p) { (void)user; (void)p; return pt_v3(0, 0, 0); }
static void bad_input_is_refused(void) {
    static const float grid[2] = { 1, -1 }, fine_grid[2] = { 1, 1 }, grid_a_channel[6] = { 1, 1, 1, 1, 1, -1 };
    static const char *words[] = { "sigma_a", "sigma_s", "emission", "g must", "g2 must", "mix must", "alpha must", "droplet_um",
        "phase is no", "phase_pdf", "only one", "density_max", "without a density", "nx must", "voxel (1, 0, 0)", "tracking is no",
        "step above 0", "needs bounds", "no medium", "medium 7", "shape, 9", "inside", "at most density_max", "NULL", "g must", "needs bounds",
        "grid_channels must", "voxel (1, 0, 0)", "grid is NULL", "at most density_max",
        "at least 0", "without a density", "which is zero", "grid is NULL", "are for PT_PHASE_USER" };
    int k;
    for (k = 0; k < (int)(sizeof words / sizeof *words); k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(1, 1);
        pt_medium m;
        pt_shape box = pt_add_box(s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), NULL, no_material);
        test_case("case %d, %s", k, words[k]);
        if (k == 0) d.sigma_a.y = -1;
        if (k == 1) d.sigma_s.z = NAN;
        if (k == 2) d.emission.x = HUGE_VALF;
        if (k == 3) d.g = 1;
        if (k == 4) d.g2 = -1;
        if (k == 5) d.mix = 2;
        if (k == 6) d.alpha = -1;
        if (k == 7) d.droplet_um = 3;
        if (k == 8) d.phase = (pt_phase)17;
        if (k == 9) d.phase = PT_PHASE_USER;
        if (k == 10) { d.grid = fine_grid; d.density = ramp; }
        if (k == 11) d.density = ramp;
        if (k == 12) d.density_bound = ramp_bound;
        if (k == 13) d.grid = fine_grid;
        if (k == 14) { d.grid = grid; d.nx = 2; d.ny = d.nz = 1; }
        if (k == 15) d.tracking = (pt_tracking)3;
        if (k == 16 || k == 25) d.tracking = PT_TRACK_MARCH;
        if (k == 25) d.step = 1;
        if (k == 17) { d.grid = fine_grid; d.nx = 2; d.ny = d.nz = 1; }
        if (k == 22) { d.density = ramp; d.density_max = 1; d.density_bound = low_bound; }
        if (k == 24) d.g = NAN;
        if (k == 26) { d.grid = fine_grid; d.nx = d.ny = d.nz = 1; d.grid_channels = 2; }
        if (k == 27) { d.grid = grid_a_channel; d.nx = 2; d.ny = d.nz = 1; d.grid_channels = 3; }
        if (k == 28) d.nx = d.ny = d.nz = 2;
        if (k == 29) { d.density = ramp; d.density_max = 1; d.density_bound = nan_bound; }
        if (k == 30) { d.density = ramp; d.density_max = 1; d.density_bound = negative_bound; }
        if (k == 31) d.density_max = 1;
        if (k == 32) d.glow = no_glow;
        if (k == 33) d.grid_channels = 3;
        if (k == 34) d.phase_pdf = up_pdf;
        m = pt_add_medium(s, k == 23 ? NULL : &d);
        if (k == 17 || k == 25) pt_add_volume(s, everywhere, m);
        if (k == 18) m.id = 0;
        if (k == 19) m.id = 7;
        if (k == 20) box.id = 9;
        if (k == 21) pt_add_material(s, &(pt_material_desc){ .inside = { 5 } });
        if (k >= 18) pt_add_volume(s, box, m);
        CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_ARG);
        if (!strstr(pt_scene_error(s), words[k]) && k != 20) FAIL("it says: %s", pt_scene_error(s));
        CHECK(k != 20 || strstr(pt_scene_error(s), "bounds"));
        pt_scene_destroy(s);
    }
}
/* The n-th allocation fails, for every n: nothing leaks, and nothing is read that is not there. */
typedef struct miser { int left; size_t live; } miser;
static void *miser_alloc(void *user, size_t size, size_t align) {
    miser *m = (miser *)user;
    void *p;
    if (m->left-- <= 0) return NULL;
    p = pti_default_alloc(NULL, size, align);
    if (p) m->live += size;
    return p;
}
static void miser_free(void *user, void *p, size_t size) { ((miser *)user)->live -= size; pti_default_free(NULL, p, size); }
static void memory_runs_out(void) {
    int n, done = 0;
    for (n = 0; n < 400 && !done; n++) {
        miser m = { n, 0 };
        pt_scene *s = pt_scene_create(&(pt_scene_desc){ .allocator = { miser_alloc, miser_free, &m } });
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, 1);
        pt_scene *inner = s ? many_bounds(s, &d) : NULL;
        if (s) chromatic_smoke(s, &d);
        done = s && pt_scene_commit(s) == PT_OK;
        if (s && !done) CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_MEMORY);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
        CHECK(m.live == 0);
    }
    CHECK(done && n > 20);
}

/* Weights make up for how distances were drawn: the mean of weight x g(t), over hits of volume k, is the integral of
   g sigma_s,k,i T_i, and over those that pass, T_i: for grey and for chromatic media of all kinds, with and without lamps to
   aim at, whatever q is. Volumes: a box of [-1,1]^3, a ball of radius 1.2, everywhere; the ray goes along x from -2 to 3. */
typedef struct weigh_case { const char *name; int chromatic, kind, aims; pt_vec3 q; } weigh_case;
static const float weigh_grid[6] = { 0.5f, 1,  1, 0.25f,  0, 2 };        /* red, green, blue */
static double weigh_density(const weigh_case *c, int volume, int channel, double x) {
    if (volume == 0 && c->kind == 3) return fabs(x) < 1 ? (double)weigh_grid[2 * channel + (x > 0)] : 0;
    if (volume == 0) return fabs(x) < 1 ? (c->kind == 1 ? (x < 0 ? 0.5 : 1) : c->kind == 2 ? (x > 0.1 ? x : 0.2) : 1) : 0;
    return volume == 1 ? fabs(x) < 1.2 : 1;
}
static float weigh_function(void *user, pt_vec3 p) { (void)user; return p.x > 0.1f ? p.x : 0.2f; }
/* From x = -2 along x, with up to two lamps to aim at. */
static void prepare_flight(pti_flight *f, const pt_scene *s, pti_sampler *sampler, uint32_t seed, int aims) {
    memset(f, 0, sizeof *f);
    memset(sampler, 0, sizeof *sampler);
    sampler->pixel_seed = seed;
    sampler->kind = PT_SAMPLER_RANDOM;
    f->volumes = &s->volumes; f->trace = pti_trace_for(s->isa);
    f->org = pt_v3(-2, 0, 0); f->dir = pt_v3(1, 0, 0);
    f->group = PTI_GROUP_FLIGHT; f->sampler = sampler;
    f->seed = 5;
    f->aims[0].at = 2.3f; f->aims[0].distance = 0.1f; f->aims[0].power = 1;
    f->aims[1].at = 4.5f; f->aims[1].distance = 0.4f; f->aims[1].power = 3;
    f->aim_count = aims;
}
/* Number n of them, its hero drawn by q: what it hits before *t, which becomes where, and its weight. */
static const pti_volume *fly_again(pti_flight *f, pti_sampler *sampler, int n, pt_vec3 q, float *t, pt_vec3 *w) {
    float u = ((float)(n % 1000) + 0.5f) / 1000;
    const pti_volume *hit;
    pti_sampler_start(sampler, (uint32_t)n);
    f->index = (uint32_t)n;
    f->hero = u < q.x ? 0 : u < q.x + q.y ? 1 : 2;
    hit = pti_flight_hit(f, t);
    *w = pti_flight_weight(f, *t, hit, q);
    return hit;
}
static void weights_make_up_for_sampling(void) {
    static const weigh_case cases[] = {
        { "grey", 0, 0, 0, { 1, 0, 0 } }, { "grey, aimed", 0, 0, 2, { 1, 0, 0 } }, { "chromatic", 1, 0, 0, { 0.2f, 0.5f, 0.3f } },
        { "chromatic, aimed", 1, 0, 1, { 0.1f, 0.2f, 0.7f } }, { "grid", 1, 1, 0, { 0.4f, 0.3f, 0.3f } }, { "grid, aimed", 1, 1, 2, { 0, 1, 0 } },
        { "function", 1, 2, 0, { 0.4f, 0.3f, 0.3f } }, { "function, aimed", 1, 2, 2, { 0.4f, 0.2f, 0.4f } },
        { "a grid a channel", 0, 3, 0, { 0.4f, 0.3f, 0.3f } }, { "a grid a channel, aimed", 1, 3, 2, { 0.1f, 0.2f, 0.7f } } };
    size_t i;
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        const weigh_case *c = cases + i;
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d[3];
        stats_moments m[5][3];                           /* the last: ratio tracking's transmittance */
        pti_sampler sampler;
        pti_flight f;
        double want[4][3], tau[3] = { 0, 0, 0 };
        int n, k, ch;
        d[0] = grey_medium(0.1f, 0.4f); d[1] = grey_medium(0, 0.3f); d[2] = grey_medium(0.05f, 0.1f);
        if (c->chromatic) {
            d[0].sigma_s = pt_v3(0.2f, 0.6f, 1.2f); d[0].sigma_a = pt_v3(0.5f, 0, 0.1f);
            d[1].sigma_s = pt_v3(0, 0, 0); d[1].sigma_a = pt_v3(0.1f, 0.2f, 0.4f);
            d[2].sigma_s = pt_v3(0.3f, 0.1f, 0.05f);
        }
        if (c->kind == 1) { d[0].grid = weigh_grid; d[0].nx = 2; d[0].ny = d[0].nz = 1; d[0].nearest = 1; }
        if (c->kind == 3) { d[0].grid = weigh_grid; d[0].nx = 2; d[0].ny = d[0].nz = 1; d[0].nearest = 1; d[0].grid_channels = 3; }
        if (c->kind == 2) { d[0].density = weigh_function; d[0].density_max = 1.5f; }
        memset(want, 0, sizeof want);
        memset(m, 0, sizeof m);
        for (n = 0; n < 100000; n++) for (ch = 0; ch < 3; ch++) {
            double dx = 5.0 / 100000, x = -2 + (n + 0.5) * dx, all = 0;
            for (k = 0; k < 3; k++) all += weigh_density(c, k, ch, x) * (double)pti_axis(pti_add(d[k].sigma_a, d[k].sigma_s), ch);
            for (k = 0; k < 3; k++)
                want[k][ch] += weigh_density(c, k, ch, x) * (double)pti_axis(d[k].sigma_s, ch) * exp(-tau[ch] - all * dx / 2) * (1 + x * x) * dx;
            tau[ch] += all * dx;
        }
        for (ch = 0; ch < 3; ch++) want[3][ch] = exp(-tau[ch]);
        fill_box(s, -1, 1, &d[0]);                       /* the one that is everywhere becomes number 0 */
        pt_add_volume(s, pt_add_sphere(s, pt_v3(0, 0, 0), 1.2f, no_material), pt_add_medium(s, &d[1]));
        pt_add_volume(s, everywhere, pt_add_medium(s, &d[2]));
        if (!commit(s)) return;
        prepare_flight(&f, s, &sampler, 3 + (uint32_t)i, c->aims);
        for (n = 0; n < 300000; n++) {
            float t = 5;
            pt_vec3 w;
            const pti_volume *hit = fly_again(&f, &sampler, n, c->q, &t, &w);
            for (k = 0; k < 4; k++) for (ch = 0; ch < 3; ch++) {
                int it = k == 3 ? !hit : hit == s->volumes.all + (k + 1) % 3;
                double x = (double)t - 2;
                stats_push(&m[k][ch], it ? (double)pti_axis(w, ch) * (k < 3 ? 1 + x * x : 1) : 0);
            }
            if (n % 4) continue;
            f.sampler = NULL;
            w = pti_flight_transmittance(&f, 5);
            f.sampler = &sampler;
            for (ch = 0; ch < 3; ch++) stats_push(&m[4][ch], (double)pti_axis(w, ch));
        }
        for (k = 0; k < 5; k++) for (ch = 0; ch < 3; ch++) {
            double w = want[k < 4 ? k : 3][ch];
            test_case("%s, %s, channel %d: %g, should be %g", c->name, k < 3 ? "hits" : k < 4 ? "passing" : "ratio", ch, m[k][ch].mean, w);
            if (k == 4 && stats_variance(&m[k][ch]) < 1e-12) { CHECK_NEAR(m[k][ch].mean, w, 1e-5); continue; }
            if (w > 0) {
                CHECK_P(stats_t_test(&m[k][ch], w));
                CHECK(stats_error(&m[k][ch]) < 0.02 * w);
            } else CHECK(m[k][ch].mean == 0);
        }
        pt_scene_destroy(s);
    }
}

/* Where passing is worth nothing, a flight is drawn from those that hit: as a closed form has it, from thin to thick. */
static void flights_that_must_hit(void) {
    static const pt_vec3 sigma_s[] = { { 0.001f, 0.001f, 0.001f }, { 1, 1, 1 }, { 8, 8, 8 }, { 0.02f, 0.3f, 2 }, { 0, 0.5f, 30 } };
    static const pt_vec3 q = { 0.2f, 0.5f, 0.3f };
    int i, aims, n, ch;
    for (i = 0; i < 5; i++) for (aims = 0; aims < 3; aims += 2) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey_medium(0, 0);
        double want[3] = { 0, 0, 0 };
        stats_moments m[3];
        pti_sampler sampler;
        pti_flight f;
        d.sigma_s = sigma_s[i];
        if (i == 3) d.sigma_a = pt_v3(0.1f, 0, 0.5f);
        memset(m, 0, sizeof m);
        for (ch = 0; ch < 3; ch++) for (n = 0; n < 100000; n++) {
            double x = -1 + (n + 0.5) * 2e-5, sigma = (double)pti_axis(pti_add(d.sigma_a, d.sigma_s), ch);
            want[ch] += (double)pti_axis(d.sigma_s, ch) * exp(-sigma * (x + 1)) * (1 + x * x) * 2e-5;
        }
        fill_box(s, -1, 1, &d);
        if (!commit(s)) return;
        prepare_flight(&f, s, &sampler, 31 + (uint32_t)i, aims);
        f.blind = 1;
        for (n = 0; n < 300000; n++) {
            float t = FLT_MAX;
            pt_vec3 w;
            const pti_volume *hit = fly_again(&f, &sampler, n, q, &t, &w);
            if (!hit) { test_case("%d, %d aims, flight %d passes", i, aims, n); CHECK(hit != NULL); break; }
            for (ch = 0; ch < 3; ch++) stats_push(&m[ch], (double)pti_axis(w, ch) * (1 + ((double)t - 2) * ((double)t - 2)));
        }
        for (ch = 0; ch < 3; ch++) {
            test_case("%d, %d aims, channel %d: %g, should be %g", i, aims, ch, m[ch].mean, want[ch]);
            if (want[ch] > 0) {
                CHECK_P(stats_t_test(&m[ch], want[ch]));
                CHECK(stats_error(&m[ch]) < 0.01 * want[ch]);
            } else CHECK(m[ch].mean == 0);
        }
        pt_scene_destroy(s);
    }
}
/* A void looks as black walls do that are not quite black, before which flights may pass. */
static void a_void_is_like_dark_walls(void) {
    int way, walls;
    for (way = 1; way < 3; way++) {
        stats_moments m[2][BLOCKS];
        memset(m, 0, sizeof m);
        for (walls = 0; walls < 2; walls++) {
            pt_scene *s = pt_scene_create(NULL);
            pt_render_desc d = view(pt_v3(0, 0.3f, 4), pt_v3(0, 0, 0), 30, 8, 32);
            pt_medium_desc fog = grey_medium(0, 0);
            fog.sigma_s = pt_v3(0.03f, 0.5f, 3); fog.sigma_a = pt_v3(0.05f, 0, 0.2f);
            pt_add_sphere(s, pt_v3(0.3f, 0, 0), 0.3f, diffuse(s, 0.6f));
            pt_add_quad(s, pt_v3(-0.5f, 1.3f, -0.5f), pt_v3(1, 0, 0), pt_v3(0, 0, 1), lamp(s, 20, 1));
            fill_box(s, -1, 1, &fog);
            if (walls) pt_add_sphere(s, pt_v3(0, 0, 0), 30, diffuse(s, 1e-6f));
            d.weights = ways[way].weights;
            d.integrator = ways[way].integrator;
            if (!commit(s)) return;
            push_blocks(m[walls], s, &d, 24, (uint64_t)(1000 * (way + 2) + 100 * walls));
            pt_scene_destroy(s);
        }
        compare_blocks(ways[way].name, m[0], m[1]);
    }
}

/* Fog that goes on for ever and is clear for red, or hardly there: nobody hits a particle 1e38 metres away. And a flat box, whose
   walls are in one place, holds nothing. */
static void fog_without_end_and_flat_boxes(void) {
    static const pt_vec3 sigma_s[] = { { 0, 0.3f, 0.6f }, { 1e-20f, 0.3f, 1e-39f }, { 1e-39f, 1e-39f, 1e-39f }, { 1e-14f, 0, 0 } };
    static float rgb[2][16 * 16 * 3];
    pt_stats stats;
    int i, k, flat;
    for (i = 0; i < 4; i++) for (k = 1; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0.3f, 4), pt_v3(0, 0, 0), 30, 16, 16);
        pt_medium_desc fog = grey_medium(0, 0);
        fog.sigma_s = sigma_s[i];
        pt_add_sphere(s, pt_v3(0.3f, 0, 0), 0.5f, lamp(s, 5, 0));
        pt_add_volume(s, everywhere, pt_add_medium(s, &fog));
        d.integrator = ways[k].integrator;
        d.max_depth = 8;
        if (!commit(s) || !render(s, &d, rgb[0], &stats)) return;
        test_case("fog %d, %s", i, ways[k].name);
        CHECK(stats.discarded == 0);
        CHECK(stats.rays < 40 * stats.paths);
        pt_scene_destroy(s);
    }
    for (flat = 0; flat < 2; flat++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0.3f, 4), pt_v3(0, 0, 0), 30, 16, 4);
        pt_medium_desc dark = grey_medium(1, 0);
        pt_add_sphere(s, pt_v3(0.3f, 0, 0), 0.5f, lamp(s, 5, 0));
        if (flat) pt_add_volume(s, pt_add_box(s, pt_v3(-1, -1, 1), pt_v3(1, 1, 1), NULL, no_material), pt_add_medium(s, &dark));
        if (!commit(s) || !render(s, &d, rgb[flat], &stats)) return;
        pt_scene_destroy(s);
    }
    CHECK(!memcmp(rgb[0], rgb[1], sizeof rgb[0]));
}

/* Grids come back from their files as they went; broken ones are refused in words, and no byte less makes one. */
typedef struct bytes { unsigned char data[600]; size_t size; } bytes;
static int keep(void *user, const void *data, size_t size) {
    bytes *b = (bytes *)user;
    if (b->size + size > sizeof b->data) return 1;
    memcpy(b->data + b->size, data, size);
    b->size += size;
    return 0;
}
static void grids_in_files(void) {
    static const struct { int at, value; const char *words; } broken[] = { { 0, 'W', "VOL" }, { 3, 2, "version 3" }, { 4, 3, "byte 4: its values are of kind 3" }, { 20, 3, "byte 20: it has 3 channels" },
                                                                           { 8, 0, "byte 8: its sizes are 0 x 4 x 5" }, { 9, 17, "4355 x 4 x 5" },
                                                                           { 8, 4, "should have" }, { 47, 192, "byte 24: its box" }, { 287, 255, "byte 284: value 60 of 60" } };
    pt_grid g, back;
    float values[60];
    bytes b;
    pt_writer w = { keep, NULL };
    size_t i;
    memset(&g, 0, sizeof g);
    memset(&back, 0, sizeof back);
    memset(&b, 0, sizeof b);
    for (i = 0; i < 60; i++) values[i] = (float)i * 0.37f;
    g.nx = 3; g.ny = 4; g.nz = 5; g.values = values; g.lo = pt_v3(-1, 0, 2); g.hi = pt_v3(1, 4, 2.5f);
    w.user = &b;
    CHECK_EQ_INT(pt_write_grid_to(&w, &g), PT_OK);
    CHECK_EQ_INT(b.size, 48 + 240);
    CHECK(b.data[8] == 3 && b.data[12] == 4 && b.data[16] == 5 && b.data[47] == 0x40);           /* 2.5 is 0x40200000 */
    CHECK_EQ_INT(pt_read_grid_memory(&back, b.data, b.size), PT_OK);
    CHECK(back.nx == 3 && back.ny == 4 && back.nz == 5 && back.lo.z == 2 && back.hi.z == 2.5f && back.lo.x == -1 && back.hi.y == 4);
    CHECK(back.values && !memcmp(values, back.values, sizeof values));
    for (i = 0; i < b.size; i++) CHECK_EQ_INT(pt_read_grid_memory(&back, b.data, i), PT_ERR_FORMAT);
    for (i = 0; i < sizeof broken / sizeof *broken; i++) {
        unsigned char old = b.data[broken[i].at];
        b.data[broken[i].at] = (unsigned char)broken[i].value;
        CHECK_EQ_INT(pt_read_grid_memory(&back, b.data, b.size), PT_ERR_FORMAT);
        if (!strstr(back.error, broken[i].words)) FAIL("case %d says: %s", (int)i, back.error);
        CHECK(!back.values && back.nx == 0);
        b.data[broken[i].at] = old;
    }
    pt_grid_free(&back);
    g.nz = 0;
    CHECK_EQ_INT(pt_write_grid_to(&w, &g), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_grid_to(&w, NULL), PT_ERR_ARG);
    g.nz = 2;
    g.hi.y = g.lo.y - 1;
    CHECK_EQ_INT(pt_write_grid_to(&w, &g), PT_ERR_ARG);
    g.hi.y = g.lo.y;
    CHECK_EQ_INT(pt_write_grid_to(&w, &g), PT_OK);
    values[1] = NAN;
    CHECK_EQ_INT(pt_write_grid_to(&w, &g), PT_ERR_ARG);
}

/* A mesh is filled with one medium, whichever of its materials names it. */
static void a_mesh_has_one_inside(void) {
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 }, both[2] = { 0, 1 }, second[2] = { 1, 1 };
    static const float p[12] = { 0, 0, 0,  1, 0, 0,  1, 1, 0,  0, 1, 0 };
    int k;
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc m = grey_medium(1, 0);
        pt_medium a = pt_add_medium(s, &m), b = pt_add_medium(s, &m);
        pt_material_desc d;
        pt_material two[2];
        pt_mesh_desc mesh;
        memset(&d, 0, sizeof d);
        memset(&mesh, 0, sizeof mesh);
        d.bsdf = PT_BSDF_DIELECTRIC;
        if (k) d.inside = a;
        two[0] = pt_add_material(s, &d);
        d.inside = k >= 2 ? b : a;
        two[1] = pt_add_material(s, &d);
        mesh.positions = p; mesh.vertex_count = 4; mesh.indices = index; mesh.index_count = 6;
        mesh.materials = two; mesh.material_count = 2; mesh.material_ids = k == 3 ? second : both;
        pt_add_mesh(s, &mesh);
        test_case("%d", k);
        CHECK_EQ_INT(pt_scene_commit(s), k == 2 ? PT_ERR_ARG : PT_OK);
        CHECK((strstr(pt_scene_error(s), "different media inside") != NULL) == (k == 2));
        pt_scene_destroy(s);
    }
}

/* A ball or box that is a volume's bounds and nothing else, placed, and filled once more. */
static float through_a_filled_instance(int box, int inner, int outer) {
    pt_scene *of = pt_scene_create(NULL), *s = pt_scene_create(NULL);
    pt_material none = { 0 };
    pt_shape bounds = box ? pt_add_box(of, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, none) : pt_add_sphere(of, pt_v3(0, 0, 0), 1, none);
    pt_medium_desc thin = grey_medium(0.5f, 0), thick = grey_medium(1, 0);
    pt_light_desc sky = { 0 };
    pt_render_desc d = { 0 };
    pt_shape placed;
    pt_render *r;
    float seen;
    if (inner) pt_add_volume(of, bounds, pt_add_medium(of, &thin));
    CHECK_EQ_INT(pt_scene_commit(of), PT_OK);
    placed = pt_add_instance(s, of, NULL);
    if (outer) pt_add_volume(s, placed, pt_add_medium(s, &thick));
    sky.color = pt_v3(1, 1, 1);
    pt_add_light(s, &sky);
    CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
    d.width = d.height = 1; d.spp = 4096; d.threads = 1;
    d.camera.eye = pt_v3(0, 0, 5); d.camera.vfov_deg = 1;
    r = pt_render_create(s, &d);
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    seen = pt_render_pixels(r)[0];
    pt_render_destroy(r);
    pt_scene_destroy(s);
    pt_scene_destroy(of);
    return seen;
}
static void filled_instances_keep_their_volumes(void) {
    int box;
    for (box = 0; box < 2; box++) {
        test_case(box ? "box" : "ball");
        CHECK_NEAR(through_a_filled_instance(box, 1, 0), exp(-1.0), 0.023);        /* 3 sigma */
        CHECK_NEAR(through_a_filled_instance(box, 0, 1), exp(-2.0), 0.016);
        CHECK_NEAR(through_a_filled_instance(box, 1, 1), exp(-3.0), 0.0102);
    }
}
/* Users know a volume by what pt_add_volume returned, in whatever order they are looked at. */
typedef struct asked { uint32_t fog, volume[3], instance[3]; int count[3]; } asked;
static float ask_where(void *user, const pt_vertex *x) {
    asked *a = (asked *)user;
    int k = pti_length(x->p) < 1 ? 0 : pti_length(pti_sub(x->p, pt_v3(3, 0, 0))) < 1 ? 1 : 2;
    int fog = x->volume.id == a->fog && !x->instance.id;
    if (x->volume.id && (k == 2 || !fog)) {              /* which is in the balls, too */
        if (a->count[k]++) CHECK(a->volume[k] == x->volume.id && a->instance[k] == x->instance.id);
        a->volume[k] = x->volume.id;
        a->instance[k] = x->instance.id;
    }
    return 0;
}
static int ask_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    (void)user; (void)x; (void)u; (void)wi;
    return 0;
}
static float ask_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return 0; }
static void particles_know_their_volume(void) {
    pt_xform aside = {{ 1,0,0,3,  0,1,0,0,  0,0,1,0 }};
    pt_material none = { 0 };
    pt_shape nothing = { 0 }, placed;
    pt_scene *of = pt_scene_create(NULL), *s = pt_scene_create(NULL);
    pt_medium_desc dense = grey_medium(0, 50), fog = grey_medium(0.1f, 0.01f), thin = grey_medium(0.1f, 0);
    pt_light_desc sky = { 0 };
    pt_density_desc density = { 0 };
    pt_render_desc d = { 0 };
    pt_render *r;
    pt_volume ball, everywhere, inner;
    asked a;
    memset(&a, 0, sizeof a);
    pt_add_volume(of, pt_add_sphere(of, pt_v3(0, 0, 0), 0.5f, none), pt_add_medium(of, &thin));
    inner = pt_add_volume(of, pt_add_sphere(of, pt_v3(0, 0, 0), 1, none), pt_add_medium(of, &dense));
    CHECK_EQ_INT(pt_scene_commit(of), PT_OK);
    ball = pt_add_volume(s, pt_add_sphere(s, pt_v3(0, 0, 0), 1, none), pt_add_medium(s, &dense));
    everywhere = pt_add_volume(s, nothing, pt_add_medium(s, &fog));
    a.fog = everywhere.id;
    placed = pt_add_instance(s, of, &aside);
    sky.color = pt_v3(1, 1, 1);
    pt_add_light(s, &sky);
    density.sample = ask_sample; density.pdf = ask_pdf; density.importance = ask_where;
    density.weight = 0.1f; density.user = &a;
    pt_add_density(s, &density);
    CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
    d.width = d.height = 16; d.spp = 16; d.threads = 1;
    d.camera.eye = pt_v3(1.5f, 0, 5);
    r = pt_render_create(s, &d);
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    pt_render_destroy(r);
    CHECK(a.count[0] > 100 && a.count[1] > 100 && a.count[2] > 0);
    CHECK(a.volume[0] == ball.id && a.instance[0] == 0);
    CHECK(a.volume[1] == inner.id && a.instance[1] == placed.id);
    CHECK(a.volume[2] == everywhere.id && a.instance[2] == 0);
    pt_scene_destroy(s);
    pt_scene_destroy(of);
}
/* More volumes than are looked at one by one, some of which fill what is empty: they are nowhere. */
static void volumes_in_empty_instances(void) {
    pt_xform turned = {{ 0.7f,-0.7f,0,0,  0.7f,0.7f,0,0,  0,0,1,0 }};
    pt_material none = { 0 };
    pt_scene *inner = pt_scene_create(NULL), *s = pt_scene_create(NULL);
    pt_medium_desc d = { 0 };
    pt_medium m;
    int i;
    CHECK_EQ_INT(pt_scene_commit(inner), PT_OK);
    d.sigma_s = pt_v3(1, 1, 1);
    m = pt_add_medium(s, &d);
    for (i = 0; i < 8; i++)
        pt_add_volume(s, i < 4 ? pt_add_sphere(s, pt_v3((float)i, 0, 0), 1, none) : pt_add_instance(s, inner, &turned), m);
    CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
    CHECK(s->volumes.tree.bvh.bounds.lo.x >= -1.01f && s->volumes.tree.bvh.bounds.hi.x <= 4.01f);
    pt_scene_destroy(s);
    pt_scene_destroy(inner);
}

void test_medium(void) {
    RUN(phases_fit_their_densities); RUN(halos_fit_their_density); RUN(mean_cosines);
    RUN(transmittance_of_a_box); RUN(transmittance_of_a_grid); RUN(majorants_hold); RUN(bounds_of_all_kinds); RUN(overlapping_volumes_add_up);
    RUN(marches_are_as_biased_as_they_say); RUN(weights_make_up_for_sampling);
    RUN(flights_that_must_hit); RUN(fog_without_end_and_flat_boxes); RUN(a_void_is_like_dark_walls);
    RUN(marches_keep_bounds); RUN(furnaces_are_white); RUN(half_space_albedo); RUN(absorption_is_exact); RUN(glow_of_a_slab); RUN(fire_lights_a_floor);
    RUN(many_fires_light_a_floor); RUN(marches_glow_as_far_as_they_come); RUN(far_glow_is_seen); RUN(rims_far_away_do_not_glow); RUN(a_mesh_has_one_inside);
    RUN(filled_instances_keep_their_volumes); RUN(particles_know_their_volume); RUN(lamp_in_fog_deep_for_blue);
    RUN(agrees_on_a_lamp_in_fog); RUN(agrees_on_juice); RUN(agrees_on_a_mesh_in_two_media); RUN(agrees_on_smoke);
    RUN(agrees_on_smoke_a_channel);
    RUN(agrees_inside_a_cloud); RUN(agrees_on_many_bounds); RUN(agrees_on_droplets); RUN(aureoles_fit_their_density);
    RUN(bits_are_the_same); RUN(limits_count_scattering); RUN(too_dense_functions_are_noticed); RUN(bad_input_is_refused);
    RUN(memory_runs_out); RUN(grids_in_files);
    RUN(volumes_in_empty_instances);
}
