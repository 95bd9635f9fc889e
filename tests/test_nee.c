/* >>path, the integrators and the limits: next-event estimation has the mean that all others have, limits cut where they say. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "agreement.h"

/* ---- agreement: naive = mixture = NEE = NEE to all ---- */

static const struct { const char *name; pt_integrator integrator; pt_weights weights; } ways[] = {
    { "naive",   PT_INTEGRATOR_MIXTURE, { 1, 0, 0 } },
    { "mixture", PT_INTEGRATOR_MIXTURE, { 0, 0, 0 } },
    { "nee",     PT_INTEGRATOR_NEE,     { 0, 0, 0 } },
    { "nee all", PT_INTEGRATOR_NEE_ALL, { 0, 0, 0 } },
};
/* The naive one, which may have no densities (plain), gets more samples. */
static void integrators_agree(const char *name, scene_builder *build, scene_builder *plain, int naive_spp) {
    stats_moments reference[BLOCKS], m[BLOCKS];
    int k;
    memset(reference, 0, sizeof reference);
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, k ? 32 : naive_spp);
        char what[100];
        inner = (k ? build : plain)(s, &d);
        d.weights = ways[k].weights;
        d.integrator = ways[k].integrator;
        memset(m, 0, sizeof m);
        if (!commit(s)) return;
        push_blocks(k ? m : reference, s, &d, k ? 16 : 32, (uint64_t)(1000 * (k + 2)));
        snprintf(what, sizeof what, "%s, naive and %s", name, ways[k].name);
        if (k) compare_blocks(what, m, reference);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
static void agrees_in_cornell_box(void)         { integrators_agree("cornell", cornell, cornell, 96); }
static void agrees_on_hidden_lights(void)       { integrators_agree("hidden", one_behind_the_other, one_behind_the_other, 96); }
static void agrees_on_mirror_and_glass(void)    { integrators_agree("glass", sky_lamps_mirror_glass, sky_lamps_mirror_glass, 96); }
static void agrees_with_densities(void)         { integrators_agree("densities", densities, two_by_the_wall, 96); }
static void agrees_on_instances(void)           { integrators_agree("instances", instanced_lamps, instanced_lamps, 96); }

void test_nee(void) {
    RUN(agrees_in_cornell_box); RUN(agrees_on_hidden_lights); RUN(agrees_on_mirror_and_glass); RUN(agrees_with_densities);
    RUN(agrees_on_instances);
}
