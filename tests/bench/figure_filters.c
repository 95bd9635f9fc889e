/* Filters and strata: a star of bright wedges on black, whose edges run in all directions. The error at its edges (root mean
   square over the pixels that an edge crosses, against the same filter with many samples) of two filters and three samplers.
   OUT/figure_filters.png: box above, tent below; random, stratified, Sobol, at 16 samples.
   cc -O2 tests/bench/figure_filters.c -o out/figure_filters -lm -lpthread && out/figure_filters [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "panels.h"
#include <math.h>

static const struct { const char *name; pt_filter filter; } filters[] = { { "box", PT_FILTER_BOX }, { "tent", PT_FILTER_TENT } };
static const struct { const char *name; pt_sampler sampler; } samplers[] = {
    { "random", PT_SAMPLER_RANDOM }, { "stratified", PT_SAMPLER_STRATIFIED }, { "sobol", PT_SAMPLER_SOBOL }
};
static const int counts[] = { 16, 32, 64, 128, 256 };
enum { FILTERS = 2, SAMPLERS = 3, COUNTS = sizeof counts / sizeof *counts };

static pt_scene *star(pt_render_desc *d, int size) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material white = pt_add_material(s, &(pt_material_desc){ .emission = { 1, 1, 1 }, .two_sided = 1 });
    float v[9] = { 0 };
    int i;
    for (i = 0; i < 17; i++) {
        float a = 6.2831853f * (float)i / 17 + .1f, b = a + 6.2831853f / 34;
        v[3] = cosf(a); v[4] = sinf(a); v[6] = cosf(b); v[7] = sinf(b);
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = v, .vertex_count = 3, .material = white });
    }
    memset(d, 0, sizeof *d);
    d->width = d->height = size;
    d->threads = 2;
    d->max_depth = 1;
    d->camera.eye = pt_v3(0, 0, 10);
    d->camera.projection = PT_CAMERA_ORTHOGRAPHIC;
    d->camera.height = 2.2f;
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); exit(1); }
    return s;
}
/* Over pixels that edges cross: those that box has neither black nor white. */
static double edge_error(const float *x, const float *r, const float *box, size_t n) {
    double sum = 0;
    size_t i, count = 0;
    for (i = 0; i < n; i++)
        if (box[i] > .01f && box[i] < .99f) { sum += ((double)x[i] - (double)r[i]) * ((double)x[i] - (double)r[i]); count++; }
    return sqrt(sum / (double)count);
}
int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "filters and strata");
    int size = set.quick ? 48 : 128, renders = set.quick ? 2 : 8, f, k, i, j;
    size_t n = (size_t)size * (size_t)size * 3;
    float *r[FILTERS], *panels[FILTERS * SAMPLERS];
    pt_render_desc d;
    pt_scene *s = star(&d, size);
    (void)efficiency_of;                                 /* time says nothing here */
    for (f = 0; f < FILTERS; f++) {
        char name[32];
        snprintf(name, sizeof name, "star_%s", filters[f].name);
        d.filter = filters[f].filter;
        r[f] = reference(name, s, &d, set.quick ? 16384 : 65536);
    }
    printf("%d x %d pixels, edge RMSE at so many samples\n%-20s", size, size, "");
    for (i = 0; i < COUNTS; i++) printf(" %8d", counts[i]);
    printf("   falls as n^\n");
    for (f = 0; f < FILTERS; f++) for (k = 0; k < SAMPLERS; k++) {
        double first = 0, last = 0;
        printf("%-5s x %-12s", filters[f].name, samplers[k].name);
        d.filter = filters[f].filter;
        d.sampler = samplers[k].sampler;
        for (i = 0; i < COUNTS; i++) {
            double square = 0;
            d.spp = counts[i];
            for (j = 0; j < renders; j++) {
                float *x;
                d.seed = (uint64_t)j + 1;
                x = render_copy(s, &d, NULL, NULL);
                square += pow(edge_error(x, r[f], r[0], n), 2) / renders;
                if (i == 0 && j == 0) panels[f * SAMPLERS + k] = x;
                else free(x);
            }
            last = sqrt(square);
            if (!i) first = last;
            printf(" %8.4f", last);
        }
        printf("   %5.2f\n", log(last / first) / log((double)counts[COUNTS - 1] / counts[0]));
    }
    write_panels(&set, "figure_filters", panels, FILTERS * SAMPLERS, SAMPLERS, size, size, 0);
    for (i = 0; i < FILTERS * SAMPLERS; i++) free(panels[i]);
    for (f = 0; f < FILTERS; f++) free(r[f]);
    pt_scene_destroy(s);
    return 0;
}
