/* Quadratic against linear. A traditional renderer marches through a medium, and at each of its n steps marches again, towards
   the lamp: its cost grows as n^2. A ray that hits a particle or passes marches once and again from there, as 2 n, and exactly
   not at all. A ball and its shadow in fog, one scattering: steps from 10 to 1000, and the slopes of cost. Then, in
   thin, smooth fog and in ragged smoke, how biased each is, and relMSE x seconds: where nothing is rough, a march of few steps
   is hard to beat. In OUT/figure_march.png, smoke at equal time: the march's 4 samples of 100 steps, the hits, a reference, and
   4 times what they miss.
   cc -O2 tests/bench/figure_march.c -o out/figure_march -lm -lpthread && out/figure_march [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "panels.h"

/* ---- the scene: a grid of uneven fog, or of smoke, over a floor, a ball in it, a lamp above */

enum { N = 128 };
static const pt_vec3 lo = { -1, 0, -1 }, hi = { 1, 2, 1 }, corner = { -.4f, 2.6f, -.4f };
static const float side = .8f, radiance = 20, albedo = .5f;          /* of the lamp; of all surfaces */
static int smoke;                                        /* or fog */
static float sigma, grid[N * N * N];                     /* extinction at density 1 */

static pt_scene *fog(pt_tracking tracking, float step) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material none = { 0 }, white = pt_add_material(s, &(pt_material_desc){ .color = { albedo, albedo, albedo } });
    pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = { radiance, radiance, radiance } });
    int i;
    for (i = 0; i < N * N * N; i++) {
        float x = (float)(i % N) / N, y = (float)(i / N % N) / N, z = (float)(i / N / N) / N;
        float a = (float)(sin(9 * x + 2) * sin(8 * y + 3 * x) * sin(7 * z - 4 * y)), b;
        b = (float)(sin(31 * x + 9 * y) * sin(37 * y + 7 * z) * sin(29 * z + 11 * x));
        grid[i] = smoke ? pti_clamp(4 * (a + .6f * b - .15f), 0, 1) : .6f + .4f * a;
    }
    sigma = smoke ? 30 : 1.5f;
    pt_add_quad(s, pt_v3(-3, 0, 3), pt_v3(6, 0, 0), pt_v3(0, 0, -6), white);
    pt_add_sphere(s, pt_v3(0, 1.2f, 0), .35f, white);
    pt_add_quad(s, corner, pt_v3(side, 0, 0), pt_v3(0, 0, side), lamp);
    pt_add_volume(s, pt_add_box(s, lo, hi, NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_a = { .1f * sigma, .1f * sigma, .1f * sigma }, .sigma_s = { .9f * sigma, .9f * sigma, .9f * sigma }, .grid = grid,
        .nx = N, .ny = N, .nz = N, .tracking = tracking, .step = step }));
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); exit(1); }
    return s;
}
static pt_render_desc look(int size, int spp) {
    return (pt_render_desc){ .width = size, .height = size, .spp = spp, .threads = 1, .max_depth = 1,
        .camera = { .eye = { 0, 1.3f, 6 }, .target = { 0, 1, 0 }, .vfov_deg = 26 } };
}

/* ---- the traditional way */

typedef struct march { const pt_scene *scene; float step; int jitter; double lookups; pt_rng rng; } march;
static float extinction(march *m, pt_vec3 p) {
    m->lookups++;
    return sigma * pti_grid_density(m->scene->media, 0, pti_xform_point(&m->scene->volumes.all->to_unit, p));
}
/* Where a ray is inside of the fog: from *from to *to. */
static void inside(pt_vec3 o, pt_vec3 d, float *from, float *to) {
    int k;
    for (k = 0; k < 3; k++) {
        float a = (pti_axis(lo, k) - pti_axis(o, k)) / pti_axis(d, k), b = (pti_axis(hi, k) - pti_axis(o, k)) / pti_axis(d, k);
        *from = pti_max(*from, pti_min(a, b));
        *to = pti_min(*to, pti_max(a, b));
    }
}
static float offset(march *m) { return m->jitter ? pt_rng_float(&m->rng) : .5f; }
static float transmittance(march *m, pt_vec3 o, pt_vec3 d, float t) {
    float from = 0, at, sum = 0;
    inside(o, d, &from, &t);
    for (at = from + offset(m) * m->step; at < t; at += m->step) sum += extinction(m, pti_madd(d, at, o)) * m->step;
    return pti_exp(-sum);
}
/* From a random point of the lamp: radiance x cosine there x solid angle, dimmed; *wi: towards it. */
static float from_lamp(march *m, pt_vec3 p, pt_vec3 *wi) {
    float u = pt_rng_float(&m->rng), v = pt_rng_float(&m->rng), r, far;
    pt_vec3 d = pti_sub(pti_add(corner, pt_v3(u * side, 0, v * side)), p);
    pt_ray ray;
    r = pti_length(d);
    *wi = pti_scale(d, 1 / r);
    if (wi->y <= 0) return 0;
    memset(&ray, 0, sizeof ray);
    ray.org = p; ray.dir = *wi; ray.tmin = 1e-4f; ray.tmax = r * .9999f;
    if (pt_occluded(m->scene, &ray)) return 0;
    far = transmittance(m, p, *wi, r);
    return radiance * wi->y * side * side / (r * r) * far;
}
static float march_ray(march *m, pt_vec3 o, pt_vec3 d) {
    pt_ray ray;
    pt_vertex x;
    pt_vec3 wi;
    float from = 0, to = 1e3f, at, T = 1, L = 0, s;
    int surface;
    memset(&ray, 0, sizeof ray);
    ray.org = o; ray.dir = d;
    surface = pt_intersect(m->scene, &ray, &x);
    if (surface) to = x.t;
    inside(o, d, &from, &to);
    for (at = from + offset(m) * m->step; at < to; at += m->step) {
        pt_vec3 p = pti_madd(d, at, o);
        s = extinction(m, p) * m->step;
        L += T * .9f * (1 - pti_exp(-s)) * from_lamp(m, p, &wi) / (4 * PTI_PI);
        T *= pti_exp(-s);
    }
    if (!surface) return L;
    if (x.p.y > 2.5f) return L + T * (d.y > 0 ? radiance : 0);
    s = from_lamp(m, x.p, &wi);
    return L + T * albedo / PTI_PI * s * pti_max(pti_dot(wi, x.ns), 0);
}
static float *march_picture(const pt_scene *s, int size, int spp, int steps, int jitter, uint64_t seed, double *seconds, double *lookups) {
    pt_render_desc v = look(size, 1);
    pti_lens lens = pti_lens_make(&v.camera, size, size);
    march m = { s, 2 / (float)steps * 1.00001f, jitter, 0, { 0, 0 } };
    float *rgb = (float *)malloc((size_t)size * (size_t)size * 3 * sizeof *rgb);
    double start = processor_seconds();
    int i, k;
    for (i = 0; i < size * size; i++) {
        float sum = 0;
        pt_rng_seed(&m.rng, seed, (uint64_t)i);
        for (k = 0; k < spp; k++) {
            float x = ((float)(i % size) + pt_rng_float(&m.rng)) / (float)size * 2 - 1, y = 1 - ((float)(i / size) + pt_rng_float(&m.rng)) / (float)size * 2;
            pt_vec3 d = pti_madd(lens.right, x * lens.half_width, pti_madd(lens.up, y * lens.half_height, lens.forward));
            sum += march_ray(&m, lens.eye, pti_normalize(d));
        }
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = sum / (float)spp;
    }
    *seconds = processor_seconds() - start;
    if (lookups) *lookups = m.lookups;
    return rgb;
}

/* ---- how cost grows */

static double slope_of(const double *x, const double *y, int n) {      /* of log y over log x, least squares */
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    int i;
    for (i = 0; i < n; i++) { double a = log(x[i]), b = log(y[i]); sx += a; sy += b; sxx += a * a; sxy += a * b; }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}
static void costs(const settings *set) {
    enum { COUNT = 5 };
    static const double steps[COUNT] = { 10, 30, 100, 300, 1000 };
    double t[3][COUNT], lookups[COUNT];
    int size = 32, i, count = set->quick ? 4 : COUNT;
    printf("microseconds a sample, by steps along the box\n%8s %12s %16s %12s %12s\n", "steps", "march", "lookups/sample", "CDF hits", "exact hits");
    for (i = 0; i < count; i++) {
        pt_scene *cdf = fog(PT_TRACK_MARCH_CDF, 2 / (float)steps[i] * 1.00001f), *exact = fog(PT_TRACK_EXACT, 0);
        pt_render_desc d = look(size, 256);
        double n = size * size, best[2] = { 1e9, 1e9 }, seconds;
        int k;
        free(march_picture(exact, size, steps[i] < 50 ? 16 : 1, (int)steps[i], 0, 1, &t[0][i], &lookups[i]));
        if (steps[i] < 50) { t[0][i] /= 16; lookups[i] /= 16; }
        for (k = 0; k < 3; k++) {
            free(render_copy(cdf, &d, NULL, &seconds));
            best[0] = fmin(best[0], seconds);
            free(render_copy(exact, &d, NULL, &seconds));
            best[1] = fmin(best[1], seconds);
        }
        t[1][i] = best[0] / 256; t[2][i] = best[1] / 256;
        printf("%8g %12.3f %16.0f %12.3f %12.3f\n", steps[i], 1e6 * t[0][i] / n, lookups[i] / n, 1e6 * t[1][i] / n, 1e6 * t[2][i] / n);
        fflush(stdout);
        pt_scene_destroy(cdf);
        pt_scene_destroy(exact);
    }
    printf("slopes of the cost over the steps: march %.2f (of its lookups %.2f), CDF hits %.2f, exact hits %.2f\n\n", slope_of(steps, t[0], count),
           slope_of(steps, lookups, count), slope_of(steps, t[1], count), slope_of(steps, t[2], count));
}

/* ---- how good they are: bias from the mean of many pictures, over the fog */

static double bias_of(const float *x, const float *r, size_t n) {      /* mean of x over that of r */
    double a = 0, b = 0;
    size_t i;
    for (i = 0; i < n; i++) { a += (double)x[i]; b += (double)r[i]; }
    return a / b - 1;
}
static void quality(const settings *set, int which) {
    static const int steps[] = { 10, 30, 100, 200, 400 };
    int size = 64, i, k, jitter, spp = set->quick ? 16 : 64, rounds = 4, count = set->quick ? 3 : 5;
    pt_scene *s = (smoke = which, fog(PT_TRACK_EXACT, 0));
    pt_render_desc d = look(size, spp);
    float *r = reference(smoke ? "march_smoke" : "march_fog", s, &d, set->quick ? 2048 : 32768);
    size_t n = (size_t)size * (size_t)size * 3;
    efficiency e;
    double ours;
    e = efficiency_of(s, &d, r, rounds);
    ours = e.error * e.seconds;
    printf("%s, %d x %d pixels: relMSE, seconds, and how many times better the exact hits do, by relMSE x seconds\n", smoke ? "smoke" : "fog", size, size);
    printf("%-26s %9s %10s %8s %8s\n%-26s %9s %10.2e %8.3f %8.2f\n", "", "bias", "relMSE", "seconds", "ratio", "exact hits", "0", e.error, e.seconds, 1.0);
    for (i = 0; i < count; i++) {
        pt_scene *cdf = fog(PT_TRACK_MARCH_CDF, 2 / (float)steps[i] * 1.00001f);
        pt_render_desc many = look(size, set->quick ? 512 : 4096);
        float *x = render_copy(cdf, &many, NULL, NULL);
        e = efficiency_of(cdf, &d, r, rounds);
        printf("CDF hits  %4d steps         %+6.2f %% %10.2e %8.3f %8.2f\n", steps[i], 100 * bias_of(x, r, n), e.error, e.seconds, e.error * e.seconds / ours);
        fflush(stdout);
        free(x);
        pt_scene_destroy(cdf);
    }
    for (jitter = 0; jitter < 2; jitter++) for (i = 0; i < count; i++) {
        float *mean = (float *)calloc(n, sizeof *mean);
        double error = 0, seconds, all = 0;
        size_t j;
        int times = steps[i] > 50 ? 1 : rounds, samples = steps[i] > 50 ? 4 : 16;
        for (k = 0; k < times; k++) {
            float *x = march_picture(s, size, samples, steps[i], jitter, (uint64_t)k + 7, &seconds, NULL);
            error += relative_error(x, r, n) / times;
            all += seconds / times;
            for (j = 0; j < n; j++) mean[j] += x[j] / (float)times;
            free(x);
        }
        printf("%-10s%4d steps, %2d spp %+7.2f %% %10.2e %8.3f %8.2f\n", jitter ? "jittered" : "march", steps[i], samples,
               100 * bias_of(mean, r, n), error, all, error * all / ours);
        fflush(stdout);
        free(mean);
    }
    free(r);
    pt_scene_destroy(s);
}

static void pictures(const settings *set) {
    int size = set->quick ? 64 : 192, i;
    pt_scene *s = fog(PT_TRACK_EXACT, 0);
    pt_render_desc d = look(size, 16);
    size_t n = (size_t)size * (size_t)size * 3, j;
    float *panels[6], *r = reference(smoke ? "march_smoke" : "march_fog", s, &d, set->quick ? 2048 : 8192);
    double seconds, ours;
    panels[0] = march_picture(s, size, 4, 100, 0, 1, &seconds, NULL);
    free(render_copy(s, &d, NULL, &ours));
    d.spp = (int)fmax(1, 16 * seconds / ours);
    panels[1] = render_copy(s, &d, NULL, &ours);
    panels[2] = r;
    for (i = 0; i < 3; i++) {
        panels[3 + i] = (float *)malloc(n * sizeof(float));
        for (j = 0; j < n; j++) panels[3 + i][j] = 4 * fabsf(panels[i][j] - r[j]);
    }
    printf("\nequal time: march, 4 samples of 100 steps, %.2f s, relMSE %.2e; exact hits, %d samples, %.2f s, relMSE %.2e\n", seconds,
           relative_error(panels[0], r, n), d.spp, ours, relative_error(panels[1], r, n));
    write_panels(set, "figure_march", panels, 6, 3, size, size, 1);
    for (i = 0; i < 6; i++) free(panels[i]);
    pt_scene_destroy(s);
}

int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "ray marching with marched shadow rays against probabilistic hits");
    costs(&set);
    quality(&set, 0);
    quality(&set, 1);
    pictures(&set);
    return 0;
}
