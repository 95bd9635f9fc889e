/* A cloud of 256^3 voxels, albedo .999, droplets of 20 micrometres, under a sun: paths a second, scatterings a path, efficiency
   = 1 / (relMSE x seconds); with the grid of local majorants, and with one majorant for all, which flies through empty and thin
   air as if it were the densest. How much that matters goes as the ratio of that one to what local ones are on the average of
   particles: the same cloud with cores denser and denser, its mean kept. OUT/figure_cloud.png has the cloud whose cores are some
   fifty times denser than the mean.
   cc -O2 tests/bench/figure_cloud.c -o out/figure_cloud -lm -lpthread && out/figure_cloud [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "noise.h"
#include "panels.h"

static float *voxels;
static int N;
static float core;                                       /* how much denser the cores are than at first */

/* Billows: three balls, their borders worn by noise; dense cores, thin rims. */
static void grow(void) {
    static const float balls[5][4] = { { .5f, .38f, .5f, .22f }, { .3f, .34f, .5f, .16f }, { .7f, .34f, .55f, .17f }, { .45f, .52f, .45f, .17f },
                                       { .6f, .5f, .6f, .13f } };
    size_t i;
    for (i = 0; i < (size_t)N * (size_t)N * (size_t)N; i++) {
        float x = ((float)(i % (size_t)N) + .5f) / (float)N, y = ((float)(i / (size_t)N % (size_t)N) + .5f) / (float)N;
        float z = ((float)(i / (size_t)N / (size_t)N) + .5f) / (float)N, inside = -1, f = 0, size = .5f, scale = 7;
        int k;
        for (k = 0; k < 5; k++) {
            float a = x - balls[k][0], b = y - balls[k][1], c = z - balls[k][2];
            inside = pti_max(inside, 1 - sqrtf(a * a + b * b + c * c) / balls[k][3]);
        }
        voxels[i] = 0;
        if (inside < -.5f) continue;
        for (k = 0; k < 5; k++, size *= .5f, scale *= 2.1f) f += size * fabsf(2 * noise(x * scale, y * scale, z * scale + (float)k) - 1);
        f = inside + .9f * (f - .35f);
        if (f > 0) voxels[i] = pti_min(f * f * 6 + .02f, 1);
        if (f > .75f) voxels[i] = 1 + core * 8 * (f - .75f);
    }
}
static const pti_medium *stored;
static float looked_up(void *user, pt_vec3 p) { (void)user; return pti_grid_density(stored, 0, p); }

static float sigma;                                      /* 1 / side of the box, at density 1 */
static pt_scene *cloud(int local, float most) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material none = { 0 };
    pt_medium_desc d = { .sigma_s = { .999f * sigma, .999f * sigma, .999f * sigma }, .sigma_a = { .001f * sigma, .001f * sigma, .001f * sigma },
        .phase = PT_PHASE_DROPLETS };
    if (local) { d.grid = voxels; d.nx = d.ny = d.nz = N; d.borrow = 1; }
    else { d.density = looked_up; d.density_max = most; }
    pt_add_volume(s, pt_add_box(s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), NULL, none), pt_add_medium(s, &d));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { 1, -1.2f, -.6f }, .color = { 9, 8.4f, 7.6f }, .radius_deg = .5f });
    pt_add_light(s, &(pt_light_desc){ .color = { .25f, .4f, .7f } });
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); exit(1); }
    return s;
}
/* Walks without light: from places of one face inwards, turning to any side at each particle, till they leave. What the way to
   track costs by itself, in microseconds a hit, the least of three times; *mean: of the local majorants along the way. */
static double walk_alone(const pt_scene *s, int walks, double *mean) {
    const pti_volume *v = s->volumes.all;
    pti_flight f;
    pt_rng rng;
    double best = 1e30, start, hits, sum, way;
    float at, most;
    int i, k;
    for (k = mean ? 0 : 1; k < 4; k++) {                 /* first, without a clock, where it flies */
        memset(&f, 0, sizeof f);
        f.volumes = &s->volumes;
        pt_rng_seed(&rng, 5, 6);
        start = processor_seconds();
        hits = sum = way = 0;
        for (i = 0; i < walks; i++) {
            f.org = pt_v3(0, .3f + .3f * pt_rng_float(&rng), .3f + .4f * pt_rng_float(&rng));
            f.dir = pt_v3(1, 0, 0);
            f.seed = (uint32_t)i;
            for (f.index = 0; f.index < 4096; f.index++) {
                float t = FLT_MAX;
                const pti_volume *hit = pti_flight_hit(&f, &t);
                if (!k) {
                    sum += (double)pti_majorant_integral(&f, v, t, FLT_MAX, &at, &most);
                    way += (double)pti_span_length(&f, v, t);
                }
                if (!hit) break;
                f.org = pti_madd(f.dir, t, f.org);
                f.dir = pti_sample_sphere(pt_rng_float(&rng), pt_rng_float(&rng));
                hits++;
            }
        }
        if (k) best = fmin(best, 1e6 * (processor_seconds() - start) / hits);
        else *mean = sum / way;
    }
    return best;
}
/* The densest voxel; *mean: of all, *empty: the share of those that are. */
static double densest(double *mean, double *empty) {
    size_t i, count = (size_t)N * (size_t)N * (size_t)N;
    double most = 0;
    *mean = *empty = 0;
    for (i = 0; i < count; i++) {
        most = fmax(most, (double)voxels[i]);
        *empty += (voxels[i] <= 0) / (double)count;
        *mean += (double)voxels[i] / (double)count;
    }
    return most;
}
static void cores(int quick) {
    static const float much[] = { 0, 1, 4, 16, 64 };
    double first = 0;
    int k, i;
    printf("cores denser: extinction of the densest, of the mean voxel that is not empty; one majorant over local ones along the way;\n"
           "us a hit, walks alone, local, one, times as fast; paths with light, times as fast\n");
    for (k = 0; k < (quick ? 4 : 5); k++) {
        pt_render_desc d = { .width = 48, .height = 48, .spp = quick ? 2 : 8, .threads = 1, .max_depth = 4096,
            .camera = { .eye = { .5f, .35f, 2.6f }, .target = { .5f, .42f, .5f }, .vfov_deg = 24 } };
        pt_scene *s[2];
        double mean, empty, most, local, alone[2], seconds[2];
        core = much[k];
        grow();
        most = densest(&mean, &empty);
        if (!k) first = mean;
        sigma = (float)(220 * first / mean);
        s[0] = cloud(1, 0);
        stored = s[0]->media;
        s[1] = cloud(0, (float)most);
        for (i = 0; i < 2; i++) {
            alone[i] = walk_alone(s[i], i ? 300 : 3000, i ? NULL : &local);
            free(render_copy(s[i], &d, NULL, seconds + i));
        }
        printf("%7.0f %7.0f  %7.1f  %8.3f %8.3f %6.1f  %6.1f\n", most * (double)sigma, mean * (double)sigma / (1 - empty), most / local, alone[0],
               alone[1], alone[1] / alone[0], seconds[1] / seconds[0]);
        fflush(stdout);
        for (i = 0; i < 2; i++) pt_scene_destroy(s[i]);
    }
}
int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "a cloud: the grid of majorants against one for all");
    int size = set.quick ? 48 : 96, spp = set.quick ? 16 : 64, k, rounds = 2;
    pt_render_desc d = { .width = size, .height = size, .spp = spp, .threads = 1, .max_depth = 4096,
        .camera = { .eye = { .5f, .35f, 2.6f }, .target = { .5f, .42f, .5f }, .vfov_deg = 24 } };
    pt_scene *scenes[2];
    efficiency e[3];
    double start, first, empty, mean, most;
    float *r, *picture;
    N = set.quick ? 128 : 256;
    voxels = (float *)malloc((size_t)N * (size_t)N * (size_t)N * sizeof *voxels);
    grow();
    densest(&first, &empty);
    core = 16;
    grow();
    most = densest(&mean, &empty);
    sigma = (float)(220 * first / mean);
    start = processor_seconds();
    scenes[0] = cloud(1, 0);
    stored = scenes[0]->media;
    printf("%d^3 voxels, %.0f %% of them empty, densest %.2f; committed in %.3f s\n", N, 100 * empty, most, processor_seconds() - start);
    scenes[1] = cloud(0, (float)most);
    r = reference(set.quick ? "cloud_cores_quick" : "cloud_cores", scenes[0], &d, set.quick ? 256 : 1024);
    printf("%d x %d pixels: samples, relMSE, seconds, paths/s, scatterings a path, us a scattering, efficiency\n", size, size);
    for (k = 0; k < 3; k++) {                            /* the two compare at few samples; one majorant takes its time */
        double n = (double)size * size * (d.spp = k ? spp / 8 : spp);
        e[k] = efficiency_of(scenes[k == 2], &d, r, rounds);
        printf("%-16s %4d %9.2e %8.2f %9.0f %7.1f %7.3f %9.3g\n", k == 2 ? "one majorant" : "local majorants", d.spp, e[k].error,
               e[k].seconds, n / e[k].seconds, e[k].rays / n - 1, 1e6 * e[k].seconds / e[k].rays, 1 / (e[k].error * e[k].seconds));
        fflush(stdout);
    }
    printf("local ones are %.1f times as fast, and %.1f times as efficient\n", e[2].seconds / e[1].seconds,
           e[2].error * e[2].seconds / (e[1].error * e[1].seconds));
    d.width = d.height = size * 2;
    d.spp = set.quick ? 8 : 64;
    d.threads = 2;
    picture = render_copy(scenes[0], &d, NULL, NULL);
    write_panels(&set, "figure_cloud", &picture, 1, 1, size * 2, size * 2, 0);
    free(picture);
    free(r);
    for (k = 0; k < 2; k++) pt_scene_destroy(scenes[k]);
    cores(set.quick);
    free(voxels);
    return 0;
}
