/* Free flights against what is known of them. OUT/figure_media.png: two slices of media over a ground, with one sample a pixel
   and with many. With one, a pixel is all medium or all ground; with many, it is what compositing makes of them. Tables: that;
   what passes, of 10^7 flights, by every exact method; the albedo of a half space; what the two marches do wrong.
   cc -O2 tests/bench/figure_media.c -o out/figure_media -lm -lpthread && out/figure_media [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "../test.h"
#include "../stats.h"
#include "../flights.h"
#include "efficiency.h"
#include "panels.h"

static const pt_material no_material = { 0 };
static void must_commit(pt_scene *s) {
    if (pt_scene_commit(s) == PT_OK) return;
    printf("%s\n", pt_scene_error(s));
    exit(1);
}
static pt_medium_desc grey(float sigma_a, float sigma_s) {
    return (pt_medium_desc){ .sigma_a = { sigma_a, sigma_a, sigma_a }, .sigma_s = { sigma_s, sigma_s, sigma_s } };
}
static void fill(pt_scene *s, pt_vec3 lo, pt_vec3 hi, const pt_medium_desc *d) {
    pt_add_volume(s, pt_add_box(s, lo, hi, NULL, no_material), pt_add_medium(s, d));
}

/* ---- two slices: C = a1 C1 + (1 - a1) (a2 C2 + (1 - a2) C0) ----
   A particle's colour is the sky's there where its phase function sends all: the near slice up and back to the camera, the far
   one down and onwards, so that neither sees the other. Straight on there is the ground. */
typedef struct slice { float up, on; } slice;
static const slice near_slice = { 1, -1 }, far_slice = { -1, 1 };
static float slice_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const slice *s = (const slice *)user;
    (void)x;
    return s->up * wi.y > 0 && -s->on * wi.z > 0 ? 1 / PTI_PI : 0.0f;
}
static int slice_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    const slice *s = (const slice *)user;
    (void)x;
    *wi = pti_sample_sphere(u[0], u[1]);
    wi->y = s->up * fabsf(wi->y);
    wi->z = -s->on * fabsf(wi->z);
    return 1;
}
static const float colors[3][3] = { { .05f, .4f, .1f }, { .9f, .6f, .1f }, { .1f, .2f, .8f } };     /* ground, near, far */
static pt_vec3 slice_sky(void *user, pt_vec3 d) {
    const float *c = colors[d.z < -0.99999f ? 0 : d.y > 0 ? 1 : 2];
    (void)user;
    return pt_v3(c[0], c[1], c[2]);
}
static void two_slices(const settings *set) {
    enum { SIZE = 192 };
    static const double alpha[2] = { 0.6, 0.7 };
    pt_scene *s = pt_scene_create(NULL);
    pt_medium_desc d = grey(0, (float)-log(1 - alpha[0]) / 0.1f);
    pt_render_desc v = { .width = SIZE, .height = SIZE, .weights = { .bsdf = 1 }, .max_depth = 100000, .sampler = PT_SAMPLER_RANDOM,
        .camera = { .projection = PT_CAMERA_ORTHOGRAPHIC, .eye = { 0, 0, 5 }, .height = 4 } };
    float *panels[2];
    double sum[4][3], count[4], all = 0, worst = 0;
    int k, i, c, mixed = 0;
    d.phase = PT_PHASE_USER; d.phase_pdf = slice_pdf; d.phase_sample = slice_sample;
    d.user = (void *)(uintptr_t)&near_slice;
    fill(s, pt_v3(-1.5f, -1.5f, 1), pt_v3(0.5f, 0.5f, 1.1f), &d);
    d.sigma_s = grey(0, (float)-log(1 - alpha[1]) / 0.1f).sigma_s;
    d.user = (void *)(uintptr_t)&far_slice;
    fill(s, pt_v3(-0.5f, -0.5f, 0), pt_v3(1.5f, 1.5f, 0.1f), &d);
    pt_add_light(s, &(pt_light_desc){ .radiance = slice_sky, .color = { 1, 1, 1 } });
    must_commit(s);
    for (k = 0; k < 2; k++) {
        v.spp = k ? set->quick ? 256 : 4096 : 1;
        panels[k] = render_copy(s, &v, NULL, NULL);
        if (!panels[k]) exit(1);
    }
    for (i = 0; i < SIZE * SIZE; i++) {                  /* one sample: is it one of the three? */
        const float *p = panels[0] + 3 * i;
        for (c = 0; c < 3 && memcmp(p, colors[c], sizeof colors[c]); c++) {}
        mixed += c == 3;
    }
    memset(sum, 0, sizeof sum);
    memset(count, 0, sizeof count);
    for (i = 0; i < SIZE * SIZE; i++) {                  /* many: by what is there, borders left out */
        double x = (i % SIZE + 0.5) / SIZE * 4 - 2, y = 2 - (i / SIZE + 0.5) / SIZE * 4;
        int first = x > -1.5 && x < 0.5 && y > -1.5 && y < 0.5, second = x > -0.5 && x < 1.5 && y > -0.5 && y < 1.5;
        if (fabs(fabs(x) - 0.5) < 0.04 || fabs(fabs(y) - 0.5) < 0.04 || fabs(fabs(x) - 1.5) < 0.04 || fabs(fabs(y) - 1.5) < 0.04) continue;
        k = first + 2 * second;
        count[k]++;
        for (c = 0; c < 3; c++) sum[k][c] += (double)panels[1][3 * i + c];
    }
    printf("two slices, opacities %g and %g: with one sample a pixel, %d of %d pixels are neither a medium nor the ground;\n"
           "with %d samples, the mean, and what compositing makes of them:\n", alpha[0], alpha[1], mixed, SIZE * SIZE, v.spp);
    for (k = 0; k < 4; k++) {
        static const char *const where[] = { "the ground", "near one", "far one", "both" };
        double a1 = k & 1 ? alpha[0] : 0, a2 = k & 2 ? alpha[1] : 0, w[3], n = count[k] * v.spp;
        w[1] = a1; w[2] = (1 - a1) * a2; w[0] = (1 - a1) * (1 - a2);
        printf("    %-12s", where[k]);
        for (c = 0; c < 3; c++) {
            double want = 0, square = 0, got = sum[k][c] / count[k], z;
            for (i = 0; i < 3; i++) { want += w[i] * (double)colors[i][c]; square += w[i] * (double)colors[i][c] * (double)colors[i][c]; }
            z = fabs(got - want) > 1e-6 ? (got - want) / sqrt((square - want * want) / n) : 0;
            printf("  %.5f %.5f (%+.1f sigma)", got, want, z);
            worst = fmax(worst, fabs(z));
            all++;
        }
        printf("\n");
    }
    printf("    the worst of %g: %.1f sigma\n", all, worst);
    write_panels(set, "figure_media", panels, 2, 2, SIZE, SIZE, 0.5f);
    for (k = 0; k < 2; k++) free(panels[k]);
    pt_scene_destroy(s);
}

/* ---- what passes ---- */

static float cloudy(void *user, pt_vec3 p) {             /* 0 in a third of all places, else up to 1 */
    float a, b, c, d, unused, sum;
    (void)user;
    pti_sincos(19 * p.x + 1, &a, &unused); pti_sincos(7 * p.y + 11 * p.x, &b, &unused);
    pti_sincos(9 * p.z - 5 * p.x, &c, &unused); pti_sincos(41 * p.x + 3 * p.y, &d, &unused);
    sum = (2 * a * b + c + 0.5f * d) / 3.5f + 0.2f;
    return sum > 0 ? pti_min(sum, 1) : 0.0f;
}
static float cloudy_bound(void *user, pt_vec3 lo, pt_vec3 hi) {      /* |slope| <= 40 along x, 8, 3 */
    pt_vec3 d = pti_scale(pti_sub(hi, lo), 0.5f);
    return pti_clamp(cloudy(user, pti_scale(pti_add(lo, hi), 0.5f)) + 40 * d.x + 8 * d.y + 3 * d.z, 0, 1);
}
static float slope(void *user, pt_vec3 p) { (void)user; return p.x; }
static float slope_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; return pti_clamp(hi.x, 0, 1); }
static float even(void *user, pt_vec3 p) { (void)user; (void)p; return 1; }

enum { GRID = 64 };
static float grid_of[GRID * GRID * GRID];
static double worst_z;
static void passes(const char *density, const char *method, const pt_scene *s, double tau, int n) {
    flown f;
    double T = exp(-tau), z, zt, start = processor_seconds();
    fly(s, pt_v3(-1, 0.3f, 0.6f), pt_v3(1, 0, 0), 100, n, &f);
    z = (f.passed / f.n - T) / sqrt(T * (1 - T) / f.n);
    zt = fabs(f.T.mean - T) < 2e-6 ? 0 : (f.T.mean - T) / stats_error(&f.T);
    printf("    %-9s %-22s %.6f %.6f (%+.1f sigma)   %.6f (%+.1f sigma) %7.0f ns%s\n", density, method, T, f.passed / f.n, z, f.T.mean, zt,
           1e9 * (processor_seconds() - start) / n, f.wrong ? "  WRONG" : "");
    fflush(stdout);
    worst_z = fmax(worst_z, fmax(fabs(z), fabs(zt)));
}
static void transmittances(const settings *set) {
    static const char *const densities[] = { "constant", "linear", "cloud" };
    static float (*const functions[])(void *, pt_vec3) = { even, slope, cloudy };
    static float (*const bounds[])(void *, pt_vec3, pt_vec3) = { NULL, slope_bound, cloudy_bound };
    static const char *const methods[] = { "analytic", "grid, nearest", "grid, trilinear", "function", "function with bounds", "two that overlap" };
    int n = set->quick ? 100000 : 10000000, k, method, i;
    printf("what passes through 1.5 x the density, of %d flights; closed form or quadrature, flights, ratio tracking\n", n);
    for (k = 0; k < 3; k++) for (method = k ? 1 : 0; method < 6; method++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey(0.5f, 1), half = grey(0.25f, 0.5f);
        double tau = 0;
        if (method == 4 && !bounds[k]) continue;
        if (method == 1 || method == 2) {
            for (i = 0; i < GRID * GRID * GRID; i++)
                grid_of[i] = functions[k](NULL, pti_scale(pt_v3((float)(i % GRID) + .5f, (float)(i / GRID % GRID) + .5f,
                                                                 (float)(i / GRID / GRID) + .5f), 1.0f / GRID));
            d.grid = grid_of; d.nx = d.ny = d.nz = GRID; d.nearest = method == 1;
        }
        if (method >= 3) { d.density = functions[k]; d.density_max = 1; }
        if (method == 4) d.density_bound = bounds[k];
        if (method == 5) {                               /* half as a function, half of it constant or on a grid */
            d.sigma_a = half.sigma_a; d.sigma_s = half.sigma_s;
            if (k == 1) { half.grid = grid_of; half.nx = half.ny = half.nz = GRID; }
            fill(s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), &half);
        }
        fill(s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), &d);
        must_commit(s);
        for (i = 0; i < 1000000; i++) {
            pt_vec3 p = pt_v3(((float)i + 0.5f) * 1e-6f, 0.3f, 0.6f);
            double density = (double)(d.grid ? pti_grid_density(s->media, 0, p) : functions[k](NULL, p));
            if (method == 5) density = 0.5 * density + 0.5 * (double)(k == 1 ? pti_grid_density(s->media, 0, p) : 1.0f);
            tau += 1.5e-6 * density;
        }
        if (!d.grid && k < 2 && method < 5) tau = k ? 0.75 : 1.5;
        passes(densities[k], methods[method], s, tau, n);
        pt_scene_destroy(s);
    }
    printf("    the worst: %.1f sigma\n\n", worst_z);
}

/* ---- the albedo of a half space, seen at the cosine mu ---- */

static stats_moments look_down(const pt_scene *s, float mu, int spp, int size) {
    float sine = sqrtf(1 - mu * mu);
    pt_render_desc v = { .width = size, .height = size, .spp = spp, .max_depth = 1000000,
        .camera = { .eye = { sine * 1000, mu * 1000, 0 }, .up = { 0, 0, 1 }, .vfov_deg = .01f } };
    stats_moments m = { 0, 0, 0 };
    float *rgb = render_copy(s, &v, NULL, NULL);
    int i;
    for (i = 0; rgb && i < size * size; i++) stats_push(&m, (double)rgb[3 * i + 1]);
    free(rgb);
    return m;
}
static void half_space(const settings *set) {
    static const float albedo[] = { .5f, .6f, .7f, .8f, .9f, .95f, .99f }, mu[] = { 1, .4f, .1f };
    int i, k;
    double worst = 0;
    printf("albedo of a half space, isotropic: Chandrasekhar's (1 - sqrt(1 - a) H(mu)), ours, off by\n%8s", "a");
    for (k = 0; k < 3; k++) printf("   mu = %-28g", (double)mu[k]);
    printf("\n");
    for (i = 0; i < 7; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_medium_desc d = grey(1 - albedo[i], albedo[i]);
        fill(s, pt_v3(-10000, -10000, -10000), pt_v3(10000, 0, 10000), &d);
        pt_add_light(s, &(pt_light_desc){ .color = { 1, 1, 1 } });
        must_commit(s);
        printf("%8g", (double)albedo[i]);
        for (k = 0; k < 3; k++) {
            double want = 1 - sqrt(1 - (double)albedo[i]) * chandrasekhar_h((double)albedo[i], (double)mu[k]), off;
            stats_moments m = look_down(s, mu[k], set->quick ? 16 : 256, 64);
            off = m.mean / want - 1;
            printf("   %.5f  %.5f  %+.3f %% +-%.3f ", want, m.mean, 100 * off, 100 * stats_error(&m) / want);
            fflush(stdout);
            worst = fmax(worst, fabs(off));
        }
        printf("\n");
        pt_scene_destroy(s);
    }
    printf("    the worst is off by %.3f %%\n\n", 100 * worst);
}

/* ---- what the marches do wrong: a lossless slab of depth 1, black below, a white sky above ---- */

static pt_vec3 white_above(void *user, pt_vec3 d) { (void)user; return d.y > 0 ? pt_v3(1, 1, 1) : pt_v3(0, 0, 0); }
static pt_scene *slab(double tau, int way, int steps) {
    static const float one[1] = { 1 };
    pt_scene *s = pt_scene_create(NULL);
    pt_medium_desc d = grey(0, (float)tau);
    if (way == 1) { d.grid = one; d.nx = d.ny = d.nz = 1; }
    if (way == 2) { d.density = even; d.density_max = 1.5f; }
    if (way >= 3) { d.tracking = way == 3 ? PT_TRACK_MARCH : PT_TRACK_MARCH_CDF; d.step = 1 / (float)steps * 1.000001f; }
    fill(s, pt_v3(-100, -1, -100), pt_v3(100, 0, 100), &d);
    pt_add_light(s, &(pt_light_desc){ .radiance = white_above, .color = { 1, 1, 1 } });
    must_commit(s);
    return s;
}
static void marches(const settings *set) {
    static const double taus[] = { .1, .3, 1, 3, 10 };
    static const int steps[] = { 0, 0, 0, 10, 30, 100, 1000 };
    static const char *const names[] = { "analytic", "delta, grid", "delta, function", "coin", "CDF" };
    int i, k, way, n = set->quick ? 100000 : 1000000;
    double truth[5][2];
    printf("a slab of depth 1, looked down on: transmittance, reflectance, and how much too high; the errors are one sigma\n%-18s %5s", "", "steps");
    for (i = 0; i < 5; i++) printf("   tau = %-28g", taus[i]);
    printf("\n");
    for (way = 0; way < 5; way++) for (k = way < 3 ? way : 3; k < (way < 3 ? way + 1 : 7); k++) {
        printf("%-18s %5d", names[way], steps[k]);
        for (i = 0; i < 5; i++) {
            pt_scene *s = slab(taus[i], way, steps[k]);
            flown f;
            stats_moments m;
            fly(s, pt_v3(0, 1, 0), pt_v3(0, -1, 0), 100, n, &f);
            m = look_down(s, 1, set->quick ? 4 : taus[i] > 5 || steps[k] > 100 ? 16 : 64, 64);
            if (!way) { truth[i][0] = exp(-taus[i]); truth[i][1] = m.mean; }
            printf("   %.5f %+6.1f %%  %.4f %+5.1f+-%.1f %%", f.passed / f.n, 100 * (f.passed / f.n / truth[i][0] - 1), m.mean,
                   100 * (m.mean / truth[i][1] - 1), 100 * stats_error(&m) / m.mean);
            fflush(stdout);
            pt_scene_destroy(s);
        }
        printf("\n");
    }
}

int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "free flights in media against what is known of them");
    two_slices(&set);
    transmittances(&set);
    half_space(&set);
    marches(&set);
    return 0;
}
