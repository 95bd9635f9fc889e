/* A race with Blender's Cycles: efficiency (efficiency.h says what that is) on scenes that both render, each against
   a reference of its own. race_cycles.sh runs this and race_cycles.py by turns, and says how.
     race_cycles render OUT SIZE SPP REFERENCE SEED SCENE   to OUT/SCENE_pt.h_SEED.pfm, and a row to OUT/seconds.csv;
                                                            SEED 0 makes the reference
     race_cycles table OUT SIZE SPP REFERENCE [wall]        of all that is in OUT/seconds.csv; the processor's seconds, or
                                                            the clock's */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "sampling_scenes.h"
#include "timing.h"

enum { THREADS = 2 };
static const char *const names[] = { "cornell", "bunny_sunset", "metal_bunny", "fog", "fog_lamp" }, *const sides[] = { "pt.h", "nee", "cycles" };
enum { SCENES = sizeof names / sizeof *names, SIDES = 3, CYCLES = 2 };       /* ours: the mixture, and next-event estimation */

/* A ball in a box of fog, which is even; a lamp above it, or a small one in it. */
static void fog_box(pt_scene *s, pt_render_desc *d, float size, float y) {
    pt_material white = scene_matte(s, .6f, .6f, .6f), none = { 0 };
    scene_ground(s, 3, white);
    pt_add_sphere(s, pt_v3(.1f, .5f, 0), .35f, white);
    pt_add_quad(s, pt_v3(-.3f - size / 2, y, -size / 2), pt_v3(size, 0, 0), pt_v3(0, 0, size), scene_lamp(s, 8 / (size * size)));
    pt_add_volume(s, pt_add_box(s, pt_v3(-1, .001f, -1), pt_v3(1, 2, 1), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_a = { .1f, .1f, .1f }, .sigma_s = { .9f, .9f, .9f }, .g = .3f }));
    scene_look(d, 0, 1.4f, 6, 0, .9f, 0, 26);
    d->max_depth = 64;
}
static void fog(pt_scene *s, pt_render_desc *d) { fog_box(s, d, .6f, 2.6f); }
static void fog_lamp(pt_scene *s, pt_render_desc *d) { fog_box(s, d, .06f, 1.4f); }
static const sampling_scene fogs[2] = { { "fog", fog, 0 }, { "fog_lamp", fog_lamp, 0 } };

typedef struct race { const char *out; int size, spp, reference, seed, wall; } race;

static size_t numbers(const race *g) { return 3 * (size_t)g->size * (size_t)g->size; }

static int run(const race *g, const pt_scene *s, const pt_render_desc *d, const char *name, const char *side) {
    char path[1024];
    double seconds, wall = now();
    float *rgb = render_copy(s, d, NULL, &seconds);
    FILE *f = NULL;
    wall = now() - wall;
    snprintf(path, sizeof path, "%s/%s_%s_%d.pfm", g->out, name, side, g->seed);
    if (rgb && pt_write_pfm(path, rgb, g->size, g->size) == PT_OK) {
        snprintf(path, sizeof path, "%s/seconds.csv", g->out);
        f = fopen(path, "a");
    }
    if (f) fprintf(f, "%s,%s,%d,%.6f,%.6f\n", name, side, g->seed, seconds, wall);
    free(rgb);
    return f && !fclose(f);
}
static int render(const race *g, const char *name) {
    const sampling_scene *c = NULL;
    int k, fine;
    pt_render_desc d;
    pt_scene *s;
    for (k = 0; k < SAMPLING_SCENES; k++) if (!strcmp(name, sampling_scenes[k].name)) c = sampling_scenes + k;
    for (k = 0; k < 2; k++) if (!strcmp(name, fogs[k].name)) c = fogs + k;
    if (!c) { printf("race_cycles: there is no scene %s\n", name); return 0; }
    s = scene_of(c, &d, g->size, g->spp);
    d.seed = (uint64_t)g->seed;
    d.threads = THREADS;
    if (g->seed == 0) {
        float *rgb = reference(name, s, &d, g->reference);
        fine = rgb != NULL;
        free(rgb);
    } else for (fine = 1, k = 0; fine && k < CYCLES; k++) {
        d.integrator = k ? PT_INTEGRATOR_NEE : PT_INTEGRATOR_MIXTURE;
        fine = run(g, s, &d, name, sides[k]);
    }
    pt_scene_destroy(s);
    return fine;
}

/* NULL if there is no picture of that size. */
static float *picture(const race *g, const char *path) {
    pt_image image;
    float *rgb = NULL;
    memset(&image, 0, sizeof image);
    if (pt_read_image(&image, path) == PT_OK && image.width == g->size && image.height == g->size && image.channels == 3) {
        rgb = (float *)malloc(numbers(g) * sizeof *rgb);
        memcpy(rgb, image.pixels, numbers(g) * sizeof *rgb);
    } else printf("%s: no picture of %d x %d\n", path, g->size, g->size);
    pt_image_free(&image);
    return rgb;
}
static double mean_of(const float *rgb, size_t n) {
    double sum = 0;
    size_t i;
    for (i = 0; i < n; i++) sum += (double)rgb[i];
    return sum / (double)n;
}
typedef struct result { double error, spread, seconds; } result;    /* relMSE, and its standard error relative to it */
/* One side's means over its rounds of a scene. Where rare paths are bright, few rounds say little, which the spread shows
   (but for one round). The reference is the caller's to free. */
static float *results(const race *g, const char *name, int side, result *e) {
    char path[1024], line[256], a[64], b[64];
    float *r = NULL, *x;
    double cpu, wall, error, squares = 0;
    int seed, rounds = 0;
    FILE *f;
    memset(e, 0, sizeof *e);
    snprintf(path, sizeof path, "%s/seconds.csv", g->out);
    f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f)) {
        if (sscanf(line, "%63[^,],%63[^,],%d,%lf,%lf", a, b, &seed, &cpu, &wall) != 5) continue;
        if (strcmp(a, name) || strcmp(b, sides[side])) continue;
        snprintf(path, sizeof path, "out/reference/%s%s_%dx%d_%d.pfm", name, side == CYCLES ? "_cycles" : "", g->size, g->size, g->reference);
        if (!r && !(r = picture(g, path))) break;
        snprintf(path, sizeof path, "%s/%s_%s_%d.pfm", g->out, name, sides[side], seed);
        x = picture(g, path);
        if (!x) continue;
        error = relative_error(x, r, numbers(g));
        e->error += error;
        squares += error * error;
        e->seconds += g->wall ? wall : cpu;
        rounds++;
        free(x);
    }
    if (f) fclose(f);
    if (rounds) {
        e->error /= rounds;
        e->seconds /= rounds;
        if (rounds > 1) e->spread = sqrt(fmax(0, squares / rounds - e->error * e->error) / (rounds - 1)) / e->error;
        return r;
    }
    free(r);
    return NULL;
}
/* Ours, Cycles', and four times how they differ, about grey. */
static void write_pictures(const race *g, const char *name, const float *ours, const float *theirs) {
    size_t row = 3 * (size_t)g->size, y, i;
    float *all = (float *)malloc(3 * numbers(g) * sizeof *all);
    char path[1024];
    for (y = 0; y < (size_t)g->size; y++) for (i = 0; i < row; i++) {
        float a = ours[y * row + i], b = theirs[y * row + i];
        all[3 * y * row + i] = a;
        all[(3 * y + 1) * row + i] = b;
        all[(3 * y + 2) * row + i] = .2f * (1 + 4 * (a - b) / (.1f + b));
    }
    snprintf(path, sizeof path, "%s/%s.png", g->out, name);
    if (pt_write_png(path, all, 3 * g->size, g->size, NULL) != PT_OK) printf("%s: cannot write it\n", path);
    free(all);
}
static int table(const race *g) {
    double logs[SIDES] = { 0 };
    int k, i, n = 0;
    printf("%d x %d pixels, %d samples, %d threads; seconds of the %s; references of %d samples; ratio: efficiency over Cycles'\n",
           g->size, g->size, g->spp, THREADS, g->wall ? "clock" : "processor", g->reference);
    printf("%-12s %-14s %8s %14s %10s %6s  %s\n", "", "", "seconds", "relMSE", "efficiency", "ratio", "mean differs");
    for (k = 0; k < SCENES; k++) {
        result r[SIDES];
        float *rgb[SIDES];
        for (i = 0; i < SIDES; i++) rgb[i] = results(g, names[k], i, r + i);
        for (i = 0; i < SIDES && rgb[0] && rgb[1] && rgb[CYCLES]; i++) {
            static const char *const what[SIDES] = { "pt.h", "pt.h with NEE", "Cycles" };
            double ratio = r[CYCLES].error * r[CYCLES].seconds / (r[i].error * r[i].seconds);
            printf("%-12s %-14s %7.2fs %8.2e+-%2.0f%% %10.3g", i ? "" : names[k], what[i], r[i].seconds, r[i].error,
                   100 * r[i].spread, 1 / (r[i].error * r[i].seconds));
            if (i < CYCLES)
                printf(" %6.2f  %+.2f %%", ratio, 100 * (mean_of(rgb[i], numbers(g)) / mean_of(rgb[CYCLES], numbers(g)) - 1));
            printf("\n");
            logs[i] += log(ratio);
            n += i == 0;
        }
        if (rgb[0] && rgb[CYCLES]) write_pictures(g, names[k], rgb[0], rgb[CYCLES]);
        for (i = 0; i < SIDES; i++) free(rgb[i]);
    }
    if (n) printf("geometric mean of the ratios: %.2f, with NEE %.2f\n", exp(logs[0] / n), exp(logs[1] / n));
    return n > 0;
}

int main(int argc, char **argv) {
    race g = { 0 };
    int rendering = argc == 8 && !strcmp(argv[1], "render"), fine = 0;
    if (rendering || ((argc == 6 || argc == 7) && !strcmp(argv[1], "table"))) {
        g.out = argv[2];
        g.size = atoi(argv[3]);
        g.spp = atoi(argv[4]);
        g.reference = atoi(argv[5]);
        g.seed = rendering ? atoi(argv[6]) : 0;
        g.wall = !rendering && argc == 7;
        fine = g.size > 0 && g.spp > 0 && g.reference > 0 && g.seed >= 0;
    }
    if (!fine) {
        printf("usage: race_cycles render OUT SIZE SPP REFERENCE SEED SCENE | table OUT SIZE SPP REFERENCE [wall]\n");
        return 1;
    }
    return rendering ? !render(&g, argv[7]) : !table(&g);
}
