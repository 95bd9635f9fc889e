/* When may a path end by chance? By potential (the throughput without what mirrors and panes took), by throughput as it is, or
   never. First eight nested shells of tinted glass, with the light within them, then without; OUT/figure_roulette.png has
   the former, in this order. Then many scenes, where efficiency = 1 / (relMSE x seconds) is compared with that of none.
   cc -O2 tests/bench/figure_roulette.c -o out/figure_roulette -lm -lpthread && out/figure_roulette [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "panels.h"
#include "sampling_scenes.h"

static const char *const names[] = { "by potential", "by throughput", "none" };
enum { WAYS = sizeof names / sizeof *names };

/* A shell is glass without and air within; of light that passes one surface 70 to 90 % are left, after all sixteen a fifth
   to a three-hundredth. The light is within, where a lamp and a ball are, or all without. */
static void shells(pt_scene *s, pt_render_desc *d) {
    pt_vec3 tint = { .9f, .8f, .7f };
    pt_material out = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .color = tint, .ior = 1.2f });
    pt_material in = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .color = tint, .ior = 1 / 1.2f });
    int k;
    for (k = 0; k < 8; k++) {
        pt_add_sphere(s, pt_v3(0, 0, 0), 1 + .1f * (float)k, in);
        pt_add_sphere(s, pt_v3(0, 0, 0), 1.05f + .1f * (float)k, out);
    }
    pt_add_sphere(s, pt_v3(0, -.2f, 0), .5f, scene_matte(s, .6f, .6f, .6f));
    scene_look(d, 0, 1, 5, 0, 0, 0, 20);
    d->max_depth = 200;
}
static void light_within(pt_scene *s, pt_render_desc *d) {
    shells(s, d);
    pt_add_sphere(s, pt_v3(.2f, .65f, .1f), .15f, pt_add_material(s, &(pt_material_desc){ .emission = { 200, 400, 800 } }));
}
static void light_without(pt_scene *s, pt_render_desc *d) {
    shells(s, d);
    pt_add_light(s, &(pt_light_desc){ .color = { 10, 20, 40 } });
}
static const sampling_scene nested[2] = { { "light_within", light_within, 16384 }, { "light_without", light_without, 16384 } };

/* One scene, all ways: what is printed for each, and the efficiencies of the first two to that of none. */
static void compare(const settings *set, const sampling_scene *c, int picture, double *sum, int renders) {
    int size = set->quick ? 32 : 64, spp = set->quick ? 16 : 64, i;
    pt_render_desc d;
    pt_scene *s = scene_of(c, &d, size, spp);
    float *r, *panels[WAYS];
    double cost[WAYS];
    r = reference(c->name, s, &d, set->quick ? 1024 : c->reference);
    printf("%-16s", c->name);
    for (i = 0; i < WAYS; i++) {
        efficiency e;
        d.roulette = (pt_roulette)i;
        e = efficiency_of(s, &d, r, renders);
        cost[i] = e.error * e.seconds;
        printf(" %10.3e %7.3f %6.2f ", e.error, e.seconds, e.rays / (size * size * spp));
        panels[i] = render_copy(s, &d, NULL, NULL);
    }
    printf(" %8.2f %8.2f\n", cost[2] / cost[0], cost[2] / cost[1]);
    fflush(stdout);
    if (picture) write_panels(set, "figure_roulette", panels, WAYS, 3, size, size, 0);
    for (i = 0; i < 2; i++) sum[i] += log(cost[2] / cost[i]);
    for (i = 0; i < WAYS; i++) free(panels[i]);
    free(r);
    pt_scene_destroy(s);
}
int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "Russian roulette by potential, by throughput, none");
    double sum[2] = { 0, 0 };
    int k;
    printf("relMSE, seconds, rays a path; efficiency of the first two to none\n%-16s %-27s%-27s%-27s\n", "", names[0], names[1], names[2]);
    compare(&set, nested, 1, sum, 4);
    compare(&set, nested + 1, 0, sum, 4);
    sum[0] = sum[1] = 0;
    for (k = 0; k < SAMPLING_SCENES; k++) compare(&set, sampling_scenes + k, 0, sum, set.quick ? 6 : 3);
    printf("geometric mean of %d scenes: %.2f by potential, %.2f by throughput\n", SAMPLING_SCENES, exp(sum[0] / SAMPLING_SCENES),
           exp(sum[1] / SAMPLING_SCENES));
    return 0;
}
