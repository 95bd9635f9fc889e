/* Veach's plates (Veach and Guibas 1995): four plates from smooth to rough under five spheres of equal power and rising size.
   Directions from the BSDF alone, from the lights alone, from the mixture, and two rays a vertex (NEE), direct light only:
   at equal rays (the mixture's) and at equal time. The light that the lights' directions do not find in lamps, which are
   black, is none. OUT/figure_plates.png: the four at equal rays, in this order; figure_plates_time.png: at equal time.
   cc -O2 tests/bench/figure_plates.c -o out/figure_plates -lm -lpthread && out/figure_plates [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "panels.h"
#include "sampling_scenes.h"

static const struct { const char *name; pt_integrator integrator; pt_weights weights; } ways[] = {
    { "BSDF only",   PT_INTEGRATOR_MIXTURE, { 1, 0, 0 } }, { "lights only", PT_INTEGRATOR_MIXTURE, { 0, 1, 0 } },
    { "mixture",     PT_INTEGRATOR_MIXTURE, { 0, 0, 0 } }, { "NEE",         PT_INTEGRATOR_NEE,     { 0, 0, 0 } }
};
enum { WAYS = sizeof ways / sizeof *ways, MIXTURE = 2 };

/* Each plate is tilted so that its middle mirrors the middle lamp to the eye. */
static void plates(pt_scene *s, pt_render_desc *d) {
    static const float roughness[4] = { .08f, .16f, .26f, .4f }, radius[5] = { .03f, .08f, .2f, .45f, .9f };
    pt_vec3 eye = { 0, 2, 15 }, lamps = { 0, 6, -2 };
    int i;
    pt_add_quad(s, pt_v3(-12, -5, 6), pt_v3(24, 0, 0), pt_v3(0, 0, -14), scene_matte(s, .2f, .2f, .2f));
    pt_add_quad(s, pt_v3(-12, -5, -5), pt_v3(24, 0, 0), pt_v3(0, 16, 0), scene_matte(s, .2f, .2f, .2f));
    for (i = 0; i < 4; i++) {
        pt_vec3 p = { 0, 1.2f - 1.25f * (float)i, -1.5f + 1.9f * (float)i }, n, up;
        n = pti_normalize(pti_add(pti_normalize(pti_sub(eye, p)), pti_normalize(pti_sub(lamps, p))));
        up = pt_v3(0, .55f * n.z, -.55f * n.y);          /* across the plate, away from the eye */
        pt_add_quad(s, pt_v3(-5.5f, p.y - up.y, p.z - up.z), pt_v3(11, 0, 0), pti_scale(up, 2), scene_metal(s, .6f, .6f, .6f, roughness[i]));
    }
    for (i = 0; i < 5; i++)
        pt_add_sphere(s, pt_v3(-4.4f + 2.2f * (float)i, lamps.y, lamps.z), radius[i], scene_lamp(s, .8f / (radius[i] * radius[i])));
    d->camera.eye = eye;
    d->camera.target = pt_v3(0, .95f, 0);
    d->camera.vfov_deg = 44;
    d->max_depth = 1;
}
static void table(const settings *set, const char *name, const pt_scene *s, pt_render_desc d, const int spp[WAYS], const float *r, const char *file) {
    float *panels[WAYS];
    double best = 0;
    int i;
    printf("%s\n%-12s %8s %10s %10s %10s %12s\n", name, "", "samples", "rays", "seconds", "relMSE", "efficiency");
    for (i = 0; i < WAYS; i++) {
        efficiency e;
        d.integrator = ways[i].integrator;
        d.weights = ways[i].weights;
        d.spp = spp[i];
        e = efficiency_of(s, &d, r, 3);
        if (!i) best = e.error * e.seconds;
        printf("%-12s %8d %10.0f %10.3f %10.3e %12.2f\n", ways[i].name, spp[i], e.rays, e.seconds, e.error, best / (e.error * e.seconds));
        panels[i] = render_copy(s, &d, NULL, NULL);
    }
    write_panels(set, file, panels, WAYS, 2, d.width, d.height, 0);
    for (i = 0; i < WAYS; i++) free(panels[i]);
}
static int at_least_one(double x) { return x < 1 ? 1 : (int)(x + .5); }
int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "Veach's plates");
    int spp[WAYS], base = set.quick ? 16 : 32, i;
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d;
    double rays[WAYS], seconds[WAYS];
    float *r;
    memset(&d, 0, sizeof d);
    d.width = set.quick ? 96 : 192;
    d.height = d.width * 2 / 3;
    d.threads = 2;
    plates(s, &d);
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); return 1; }
    d.integrator = PT_INTEGRATOR_NEE;                    /* for the reference */
    r = reference("veach_plates", s, &d, set.quick ? 2048 : 4096);
    for (i = 0; i < WAYS; i++) {
        efficiency e;
        d.integrator = ways[i].integrator;
        d.weights = ways[i].weights;
        d.spp = base;
        e = efficiency_of(s, &d, r, 3);
        rays[i] = e.rays;
        seconds[i] = e.seconds;
    }
    for (i = 0; i < WAYS; i++) spp[i] = at_least_one(base * rays[MIXTURE] / rays[i]);
    table(&set, "equal rays", s, d, spp, r, "figure_plates");
    for (i = 0; i < WAYS; i++) spp[i] = at_least_one(base * seconds[MIXTURE] / seconds[i]);
    table(&set, "equal time", s, d, spp, r, "figure_plates_time");
    free(r);
    pt_scene_destroy(s);
    return 0;
}
