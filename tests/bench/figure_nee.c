/* Next-event estimation against one ray a vertex. First a small lamp, 100 times as bright as the glowing walls round it: the
   BSDF's directions alone, the mixture, a ray to the lights (NEE), a ray to each light, at equal samples; the picture
   OUT/figure_nee.png has them in this order. Then the mixture and NEE over many scenes: efficiency = 1 / (relMSE x seconds).
   cc -O2 tests/bench/figure_nee.c -o out/figure_nee -lm -lpthread && out/figure_nee [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "panels.h"
#include "sampling_scenes.h"

static const struct { const char *name; pt_integrator integrator; pt_weights weights; } ways[] = {
    { "BSDF only",       PT_INTEGRATOR_MIXTURE, { 1, 0, 0 } }, { "mixture",         PT_INTEGRATOR_MIXTURE, { 0, 0, 0 } },
    { "NEE",             PT_INTEGRATOR_NEE,     { 0, 0, 0 } }, { "NEE, each light", PT_INTEGRATOR_NEE_ALL, { 0, 0, 0 } }
};
enum { WAYS = sizeof ways / sizeof *ways };

static void small_lamp(const settings *set) {
    const sampling_scene *c = sampling_scenes + 1;
    int size = set->quick ? 64 : 128, spp = set->quick ? 16 : 64, i;
    pt_render_desc d;
    pt_scene *s = scene_of(c, &d, size, spp);
    float *r = reference(c->name, s, &d, set->quick ? 4096 : c->reference), *panels[WAYS];
    double naive = 0;
    printf("a small lamp: %d x %d pixels, %d samples\n%-16s %10s %10s %10s %12s\n", size, size, spp, "", "relMSE", "rays/path", "seconds",
           "efficiency");
    for (i = 0; i < WAYS; i++) {
        efficiency e;
        d.integrator = ways[i].integrator;
        d.weights = ways[i].weights;
        e = efficiency_of(s, &d, r, set->quick ? 2 : 4);
        if (!i) naive = e.error * e.seconds;
        printf("%-16s %10.3e %10.2f %10.3f %12.2f\n", ways[i].name, e.error, e.rays / (size * size * spp), e.seconds,
               naive / (e.error * e.seconds));
        fflush(stdout);
        panels[i] = render_copy(s, &d, NULL, NULL);
    }
    write_panels(set, "figure_nee", panels, WAYS, 2, size, size, 0);
    for (i = 0; i < WAYS; i++) free(panels[i]);
    free(r);
    pt_scene_destroy(s);
}
/* relMSE, seconds, rays a path; of the mixture, then of NEE, and what the mixture's efficiency is to NEE's. */
static void many_scenes(const settings *set) {
    int size = set->quick ? 32 : 64, spp = set->quick ? 16 : 64, k, way, n = 0;
    double sum = 0;
    printf("%d x %d pixels, %d samples: relMSE, seconds, rays a path\n%-16s %-32s %-32s %s\n", size, size, spp, "", "mixture", "NEE",
           "mixture : NEE");
    for (k = 0; k < SAMPLING_SCENES; k++) {
        const sampling_scene *c = sampling_scenes + k;
        pt_render_desc d;
        pt_scene *s = scene_of(c, &d, size, spp);
        float *r = reference(c->name, s, &d, set->quick ? 1024 : c->reference);
        double cost[2];
        printf("%-16s", c->name);
        fflush(stdout);
        for (way = 0; way < 2; way++) {
            efficiency e;
            d.integrator = ways[1 + way].integrator;
            e = efficiency_of(s, &d, r, 3);
            cost[way] = e.error * e.seconds;
            printf(" %10.3e %8.3f %8.2f    ", e.error, e.seconds, e.rays / (size * size * spp));
        }
        printf("%6.2f\n", cost[1] / cost[0]);
        fflush(stdout);
        sum += log(cost[1] / cost[0]);
        n++;
        free(r);
        pt_scene_destroy(s);
    }
    printf("%-16s geometric mean of %d scenes: the mixture is %.2f times as efficient as NEE\n", "", n, exp(sum / n));
}
int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "next-event estimation against one ray a vertex");
    small_lamp(&set);
    many_scenes(&set);
    return 0;
}
