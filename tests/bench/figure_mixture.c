/* Two figures about how directions are drawn where a map lights rough things.
     mixture      the BSDF alone, the environment alone, three to one, automatic, and the BSDF's share from 0 to 1: things of
                  several BRDFs, a measured one among them, on a ground under a map with a low sun
     anisotropic  highlights that are stretched: metal of three pairs of roughness, under a map and a lamp
   Each prints a table, and writes OUT/figure_NAME.png: panels from the top left as in the first rows of the table.
   cc -O2 tests/bench/figure_mixture.c -o out/figure_mixture -lm -lpthread && out/figure_mixture [--quick] [--out DIR] [FIGURE...] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "sampling_scenes.h"

typedef struct settings { int spp, width, height, reference, renders, panel; const char *out; } settings;

/* Löw, Kronander, Ynnerman and Unger's model for measured gloss (2012), S(x) = A / (1 + B x)^C with x = 1 - cos theta_h, times
   Fresnel's share by theta_d, over a diffuse ground, as a table of cells. */
static pt_measured painted_table(pt_scene *s, pt_vec3 ground, float A, float B, float C) {
    enum { H = 90, D = 90 };
    float *values = (float *)malloc(3 * H * D * sizeof *values), *v = values;
    pt_measured m;
    int h, d;
    for (h = 0; h < H; h++) for (d = 0; d < D; d++) {
        double a = 1.5707963 * (h + .5) / H * (h + .5) / H, F = .04 + .96 * pow(1 - cos(1.5707963 * (d + .5) / D), 5);
        float gloss = (float)(F * (double)A / pow(1 + (double)B * (1 - cos(a)), (double)C));
        *v++ = ground.x / 3.1415927f + gloss; *v++ = ground.y / 3.1415927f + gloss; *v++ = ground.z / 3.1415927f + gloss;
    }
    m = pt_add_measured(s, &(pt_measured_desc){ .values = values, .cells_p = 1 });
    free(values);
    return m;
}
static void mixture_scene(pt_scene *s, pt_render_desc *d) {
    pt_material paint = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MEASURED,
        .measured = painted_table(s, pt_v3(.50f, .10f, .05f), 12, 300, 1.6f) });
    scene_ground(s, 12, scene_matte(s, .45f, .42f, .38f));
    pt_add_sphere(s, pt_v3(-2.2f, .5f, .1f), .5f, scene_matte(s, .25f, .4f, .65f));
    pt_add_sphere(s, pt_v3(-1.1f, .5f, .1f), .5f, scene_plastic(s, .1f, .35f, .15f, .3f));
    scene_bunny(s, paint);
    pt_add_sphere(s, pt_v3(1.1f, .5f, .1f), .5f, scene_metal(s, .95f, .72f, .35f, .45f));
    pt_add_sphere(s, pt_v3(2.2f, .5f, .1f), .5f, scene_metal(s, .92f, .92f, .95f, .3f));
    scene_map(s, "sunset");
    scene_look(d, 0, 1.7f, -5.2f, 0, .45f, 0, 30);
}
/* alpha along the tangent, which runs round each ball as latitudes do, and across: the square of the roughness. */
static void anisotropic_scene(pt_scene *s, pt_render_desc *d) {
    static const float alpha[3][2] = { { .1f, .1f }, { .05f, .4f }, { .4f, .05f } };
    int i;
    scene_ground(s, 12, scene_matte(s, .25f, .25f, .27f));
    for (i = 0; i < 3; i++)
        pt_add_sphere(s, pt_v3(1.2f * (float)(i - 1), .55f, 0), .55f, pt_add_material(s, &(pt_material_desc){
            .bsdf = PT_BSDF_CONDUCTOR, .color = { .93f, .9f, .85f }, .roughness = sqrtf(alpha[i][0]), .roughness_y = sqrtf(alpha[i][1]) }));
    pt_add_quad(s, pt_v3(-.4f, 3, 1.2f), pt_v3(.8f, 0, 0), pt_v3(0, .3f, .7f), scene_lamp(s, 25));
    scene_map(s, "forest");
    scene_look(d, 0, 1.5f, 4.6f, 0, .5f, 0, 30);
}

typedef struct row { const char *name; pt_weights weights; int panel; } row;
static const row mixture_rows[] = {
    { "BSDF only", { 1, 0, 0 }, 1 }, { "environment only", { 0, 1, 1 }, 1 }, { ".75 BSDF, .25 env.", { .75f, .25f, .25f }, 1 },
    { "automatic", { 0, 0, 0 }, 1 }, { "BSDF .1", { .1f, .9f, .9f }, 0 }, { "BSDF .2", { .2f, .8f, .8f }, 0 },
    { "BSDF .3", { .3f, .7f, .7f }, 0 }, { "BSDF .4", { .4f, .6f, .6f }, 0 }, { "BSDF .5", { .5f, .5f, .5f }, 0 },
    { "BSDF .6", { .6f, .4f, .4f }, 0 }, { "BSDF .7", { .7f, .3f, .3f }, 0 }, { "BSDF .8", { .8f, .2f, .2f }, 0 },
    { "BSDF .9", { .9f, .1f, .1f }, 0 }
};
static const row anisotropic_rows[] = { { "BSDF only", { 1, 0, 0 }, 1 }, { "automatic", { 0, 0, 0 }, 1 } };
typedef struct figure {
    const char *name;
    void (*build)(pt_scene *s, pt_render_desc *d);
    const row *rows;
    int count, columns;
} figure;
static const figure figures[] = {
    { "mixture", mixture_scene, mixture_rows, sizeof mixture_rows / sizeof *mixture_rows, 2 },
    { "anisotropic", anisotropic_scene, anisotropic_rows, sizeof anisotropic_rows / sizeof *anisotropic_rows, 1 }
};

static double mean_of(const float *x, size_t n) {
    double sum = 0;
    size_t i;
    for (i = 0; i < n; i++) sum += (double)x[i];
    return sum / (double)n;
}
/* Relative error and time of each row, and how much of the light is there: without the BSDF, what only that finds is not. */
static void print_table(const figure *f, const pt_scene *s, pt_render_desc d, const settings *set) {
    size_t n = (size_t)set->width * (size_t)set->height * 3;
    double first = 0;
    float *r, *x;
    int i;
    d.width = set->width; d.height = set->height;
    r = reference(f->name, s, &d, set->reference);
    printf("%s: %d x %d pixels, %d samples, mean of %d renders; reference of %d samples\n%-20s %10s %10s %12s %10s\n", f->name, d.width, d.height,
           d.spp, set->renders, set->reference, "", "relMSE", "seconds", "efficiency", "light");
    for (i = 0; i < f->count; i++) {
        efficiency e;
        d.weights = f->rows[i].weights;
        e = efficiency_of(s, &d, r, set->renders);
        d.seed++;
        x = render_copy(s, &d, NULL, NULL);
        d.seed--;
        if (i == 0) first = e.error * e.seconds;
        printf("%-20s %10.5f %10.2f %11.2fx %9.2f%%\n", f->rows[i].name, e.error, e.seconds, first / (e.error * e.seconds),
               100 * mean_of(x, n) / mean_of(r, n));
        fflush(stdout);
        free(x);
    }
    free(r);
}
static int draw_panels(const figure *f, const pt_scene *s, pt_render_desc d, const settings *set) {
    int i, y, k = 0, panels = 0, rows, width, fine;
    char path[512];
    float *all, *x;
    d.width = set->panel; d.height = set->panel * set->height / set->width;
    for (i = 0; i < f->count; i++) panels += f->rows[i].panel;
    rows = panels / f->columns;
    width = d.width * f->columns;
    all = (float *)calloc((size_t)width * (size_t)d.height * (size_t)rows * 3, sizeof *all);
    for (i = 0; i < f->count; i++) {
        if (!f->rows[i].panel) continue;
        d.weights = f->rows[i].weights;
        x = render_copy(s, &d, NULL, NULL);
        for (y = 0; y < d.height; y++)
            memcpy(all + 3 * (size_t)((k / f->columns * d.height + y) * width + k % f->columns * d.width), x + 3 * (size_t)(y * d.width),
                   3 * (size_t)d.width * sizeof *x);
        free(x);
        k++;
    }
    snprintf(path, sizeof path, "%s/figure_%s.png", set->out, f->name);
    fine = pt_write_png(path, all, width, rows * d.height, &(pt_encoding){ .curve = PT_CURVE_FILMIC }) == PT_OK;
    printf(fine ? "%s\n" : "cannot write %s\n", path);
    free(all);
    return fine;
}
static int draw(const figure *f, const settings *set) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d;
    int fine;
    memset(&d, 0, sizeof d);
    d.spp = set->spp;
    d.max_depth = 6;
    d.threads = 2;
    f->build(s, &d);
    if (pt_scene_commit(s) != PT_OK) { printf("%s: %s\n", f->name, pt_scene_error(s)); return 0; }
    print_table(f, s, d, set);
    fine = draw_panels(f, s, d, set);
    pt_scene_destroy(s);
    return fine;
}
int main(int argc, char **argv) {
    settings set = { 289, 64, 32, 28900, 8, 480, "out" };
    int i, k, some = 0, fine = 1;
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick")) { set.spp = 17; set.width = 32; set.height = 16; set.reference = 1700; set.renders = 1; set.panel = 320; }
        else if (!strcmp(argv[i], "--out") && i + 1 < argc) set.out = argv[++i];
        else if (argv[i][0] == '-') { printf("usage: figure_mixture [--quick] [--out DIR] [mixture] [anisotropic]\n"); return strcmp(argv[i], "--help") ? 2 : 0; }
        else some = 1;
    }
    for (k = 0; k < 2; k++) {
        int wanted = !some;
        for (i = 1; i < argc; i++) wanted |= !strcmp(argv[i], figures[k].name);
        if (wanted) fine &= draw(figures + k, &set);
    }
    return !fine;
}
