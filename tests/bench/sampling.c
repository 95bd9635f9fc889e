/* How well are directions drawn? Scenes of many kinds, each with several fixed weights of the BSDF against the lights, and
   with automatic ones: relMSE, processor time, and efficiency relative to the best fixed weight.
   cc -O2 tests/bench/sampling.c -o out/sampling -lm -lpthread && out/sampling [--quick] [--spp N] [--size N] [--renders N]
   [SCENE...] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "sampling_scenes.h"

static int size = 64, spp = 64, renders = 3;
static double log_best, log_half;
static int measured;

static void measure(const sampling_scene *c) {
    static const float weights[] = { .05f, .25f, .5f, .75f, 1 };
    enum { FIXED = sizeof weights / sizeof *weights };
    pt_render_desc d;
    pt_scene *s = scene_of(c, &d, size, spp);
    efficiency e;
    double cost[FIXED + 1], best = 1e30, best_error = 1e30;
    float *r;
    int i;
    r = reference(c->name, s, &d, c->reference);
    printf("%-14s", c->name);
    for (i = 0; i <= FIXED; i++) {
        d.weights.bsdf = i < FIXED ? weights[i] : 0;
        d.weights.lights = d.weights.environment = i < FIXED ? 1 - weights[i] : 0;
        e = efficiency_of(s, &d, r, renders);
        cost[i] = e.error * e.seconds;
        if (i < FIXED && cost[i] < best) best = cost[i];
        if (i < FIXED && e.error < best_error) best_error = e.error;
        printf("  %.2e %5.2f", e.error, e.seconds);
        fflush(stdout);
    }
    printf("   %5.2f x best in relMSE, %5.2f with time, %5.2f x half and half\n", best_error / e.error, best / cost[FIXED], cost[2] / cost[FIXED]);
    fflush(stdout);
    log_best += log(best / cost[FIXED]);
    log_half += log(cost[2] / cost[FIXED]);
    measured++;
    free(r);
    pt_scene_destroy(s);
}
int main(int argc, char **argv) {
    int i, k, some = 0;
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--spp") && i + 1 < argc) spp = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--size") && i + 1 < argc) size = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--renders") && i + 1 < argc) renders = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--quick")) { size = 32; renders = 1; }
        else if (argv[i][0] == '-') { printf("usage: sampling [--quick] [--spp N] [--size N] [--renders N] [SCENE...]\n"); return strcmp(argv[i], "--help") != 0; }
        else some = 1;
    }
    printf("%d x %d pixels, %d samples, mean of %d renders: relMSE and processor seconds\n%-14s  bsdf .05        .25             .5              "
           ".75             1               automatic\n", size, size, spp, renders, "");
    for (k = 0; k < SAMPLING_SCENES; k++) {
        int wanted = !some;
        for (i = 1; i < argc; i++) wanted |= !strcmp(argv[i], sampling_scenes[k].name);
        if (wanted) measure(sampling_scenes + k);
    }
    if (measured) printf("efficiency, geometric mean of %d scenes: %.3f x the best fixed weight, %.3f x half and half\n", measured,
                         exp(log_best / measured), exp(log_half / measured));
    return 0;
}
