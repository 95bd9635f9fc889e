/* Materials beside Blender's Cycles: a sphere under a map, 20 settings, means over the same pixels. compare_materials.py
   makes Cycles' side, and says how to run both. Without that side, only ours is printed.
     compare_materials MAP.hdr [FOLDER [SETTING...]]
   FOLDER is where the script has put cycles.csv and its pictures; SETTING.png there becomes Cycles' and ours, side by side.
   A row is a channel's mean of Cycles, of ours, the difference in percent, and that difference's standard error. */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE = 128, SEEDS = 8, SPP = 64, REGIONS = 6 };
static const pt_camera camera = { .eye = {4, 2, 4}, .vfov_deg = 20.5f };
static const char *const regions[REGIONS] = { "sphere", "top_left", "top_right", "bottom_left", "bottom_right", "background" };

/* What both mean the same by, and where they differ by design. Cycles' Principled is that of Blender 3.4. */
typedef struct setting { const char *name; pt_material_desc m; const char *remark; } setting;
#define METAL   {.9f, .6f, .3f}
#define PLASTIC {.2f, .4f, .8f}
#define NO_GLOSS 1e-9f                                    /* of specular, since 0 means 1 */
static const setting settings[] = {
    { "mirror",             { .bsdf = PT_BSDF_CONDUCTOR, .color = {1, 1, 1} },
      "same: the camera and the map" },
    { "diffuse",            { .color = {.8f, .8f, .8f} },
      "same: Lambert" },
    { "rough_diffuse",      { .color = {.8f, .8f, .8f}, .roughness = 1 },
      "differs: one bounce of Fujii's Oren-Nayar there, EON gives back what it loses" },
    { "rough_diffuse_dark", { .color = {.01f, .01f, .01f}, .roughness = 1 },
      "same but for 0.2 %: an albedo of .01 has next to no second bounce" },
    { "metal_0",            { .bsdf = PT_BSDF_CONDUCTOR, .color = METAL },
      "same: Schlick's Fresnel as nodes there" },
    { "metal_3",            { .bsdf = PT_BSDF_CONDUCTOR, .color = METAL, .roughness = .3f },
      "same: Principled metal, Fresnel's curve chosen next to Schlick's" },
    { "metal_7",            { .bsdf = PT_BSDF_CONDUCTOR, .color = METAL, .roughness = .7f },
      "same, but later bounces walk at random there and are spread like Kulla's and Conty's here" },
    { "white_metal_3",      { .bsdf = PT_BSDF_CONDUCTOR, .color = {1, 1, 1}, .roughness = .3f },
      "same: no Fresnel" },
    { "white_metal_7",      { .bsdf = PT_BSDF_CONDUCTOR, .color = {1, 1, 1}, .roughness = .7f },
      "same: no Fresnel, all light comes back; its later bounces as above" },
    { "glass_0",            { .bsdf = PT_BSDF_DIELECTRIC },
      "same" },
    { "glass_3",            { .bsdf = PT_BSDF_DIELECTRIC, .roughness = .3f },
      "same but for where later bounces go; noisy on both sides" },
    { "plastic",            { .bsdf = PT_BSDF_PRINCIPLED, .color = PLASTIC, .roughness = .4f },
      "differs: gloss lies on top of all of Disney's diffuse there, on what it lets through of Lambert's here" },
    { "half_metal",         { .bsdf = PT_BSDF_PRINCIPLED, .color = PLASTIC, .roughness = .4f, .metallic = .5f },
      "differs: as plastic" },
    { "coat",               { .bsdf = PT_BSDF_PRINCIPLED, .color = PLASTIC, .roughness = .4f, .coat = 1, .coat_roughness = .1f },
      "differs: a quarter of a GTR1 coat there that takes nothing from below; all of one here" },
    { "coat_on_diffuse",    { .bsdf = PT_BSDF_PRINCIPLED, .color = {.8f, .8f, .8f}, .specular = NO_GLOSS, .coat = 1 },
      "same: smooth coat over Lambert, mixed by a Fresnel node there" },
    { "coat_on_metal",      { .bsdf = PT_BSDF_PRINCIPLED, .color = METAL, .roughness = .4f, .metallic = 1, .coat = 1 },
      "same: smooth coat over metal, mixed by a Fresnel node there" },
    { "sheen",              { .bsdf = PT_BSDF_PRINCIPLED, .color = PLASTIC, .roughness = .4f, .sheen = 1 },
      "differs: Schlick's curve on top there, a layer of fibres here" },
    { "transmission",       { .bsdf = PT_BSDF_PRINCIPLED, .color = {1, 1, 1}, .roughness = .2f, .transmission = 1 },
      "same as glass" },
    { "tinted",             { .bsdf = PT_BSDF_PRINCIPLED, .color = METAL, .roughness = .2f, .transmission = 1 },
      "same: each passage through the surface is tinted, reflections are not" },
    { "emission",           { .color = {.5f, .5f, .5f}, .emission = {2, 1, .5f} },
      "same: a lamp that is Lambert's too" },
};
enum { SETTINGS = sizeof settings / sizeof *settings };

typedef struct statistic { double mean[3], error[3]; } statistic;

/* Which of the regions hold pixel (x, y): a pixel more than one inside the sphere's outline, or more than one outside. */
static int within(int region, int x, int y) {
    double dx = x + .5 - SIZE / 2, dy = y + .5 - SIZE / 2, r = sqrt(dx * dx + dy * dy);
    double distance2 = (double)pti_dot(camera.eye, camera.eye);
    double outline = SIZE / 2 / sqrt(distance2 - 1) / tan((double)camera.vfov_deg * 3.14159265358979 / 360);
    if (region == 5) return r > outline + 1;
    return r < outline - 1 && (region == 0 || region == 1 + (dx > 0) + 2 * (dy > 0));
}
static void region_means(const float *picture, double mean[REGIONS][3]) {
    int region, x, y, c;
    for (region = 0; region < REGIONS; region++) {
        double sum[3] = { 0 }, n = 0;
        for (y = 0; y < SIZE; y++) for (x = 0; x < SIZE; x++) if (within(region, x, y)) {
            for (c = 0; c < 3; c++) sum[c] += (double)picture[3 * (SIZE * y + x) + c];
            n++;
        }
        for (c = 0; c < 3; c++) mean[region][c] = sum[c] / n;
    }
}

/* The mean picture of all seeds; its regions' means, with standard errors from how the seeds differ. */
static int render(const setting *t, const pt_image *map, float *picture, statistic out[REGIONS]) {
    static double mean[SEEDS][REGIONS][3];
    pt_scene *s = pt_scene_create(NULL);
    pt_texture sky = pt_add_texture(s, &(pt_texture_desc){ .pixels = map->pixels, .width = map->width, .height = map->height,
        .channels = 3, .bits = 32 });
    int i, region, c, fine = 1;
    pt_add_sphere(s, pt_v3(0, 0, 0), 1, pt_add_material(s, &t->m));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .texture = sky });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s: %s\n", t->name, pt_scene_error(s)); fine = 0; }
    memset(picture, 0, 3 * SIZE * SIZE * sizeof *picture);
    for (i = 0; i < SEEDS && fine; i++) {
        pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = SIZE, .height = SIZE, .spp = SPP, .threads = 1,
            .seed = 1 + (uint64_t)i, .camera = camera });
        if (pt_render_run(r) != PT_OK) { fprintf(stderr, "%s: %s\n", t->name, pt_render_error(r)); fine = 0; }
        else {
            const float *pixels = pt_render_pixels(r);
            region_means(pixels, mean[i]);
            for (c = 0; c < 3 * SIZE * SIZE; c++) picture[c] += pixels[c] / SEEDS;
        }
        pt_render_destroy(r);
    }
    pt_scene_destroy(s);
    for (region = 0; region < REGIONS && fine; region++) for (c = 0; c < 3; c++) {
        double sum = 0, squares = 0;
        for (i = 0; i < SEEDS; i++) sum += mean[i][region][c];
        sum /= SEEDS;
        for (i = 0; i < SEEDS; i++) squares += (mean[i][region][c] - sum) * (mean[i][region][c] - sum);
        out[region].mean[c] = sum;
        out[region].error[c] = sqrt(squares / (SEEDS - 1) / SEEDS);
    }
    return fine;
}

/* A row of the script's CSV: setting,region,r,g,b,se_r,se_g,se_b. */
static int read_row(const char *path, const char *name, const char *region, statistic *out) {
    char line[512], a[64], b[64];
    int found = 0;
    FILE *f = fopen(path, "r");
    if (!f) return 0;
    while (!found && fgets(line, sizeof line, f))
        found = sscanf(line, "%63[^,],%63[^,],%lf,%lf,%lf,%lf,%lf,%lf", a, b, out->mean, out->mean + 1, out->mean + 2, out->error,
                       out->error + 1, out->error + 2) == 8 && !strcmp(a, name) && !strcmp(b, region);
    fclose(f);
    return found;
}
static void print_row(const char *name, const char *region, const statistic *theirs, const statistic *ours, const char *remark) {
    int c;
    printf("| %s | %s |", name, region);
    for (c = 0; c < 3 && theirs; c++) printf("%s %.5f", c ? "," : "", theirs->mean[c]);
    printf(" |");
    for (c = 0; c < 3; c++) printf("%s %.5f", c ? "," : "", ours->mean[c]);
    printf(" |");
    for (c = 0; c < 3 && theirs; c++) printf("%s %+.2f", c ? "," : "", 100 * (ours->mean[c] / theirs->mean[c] - 1));
    printf(" |");
    for (c = 0; c < 3; c++)
        printf("%s %.2f", c ? "," : "", 100 * hypot(ours->error[c] / ours->mean[c], theirs ? theirs->error[c] / theirs->mean[c] : 0));
    printf(" | %s |\n", remark);
    fflush(stdout);
}
static void write_pair(const char *folder, const char *name, const float *ours) {
    static float both[3 * 2 * SIZE * SIZE];
    char path[1024];
    pt_image theirs = { 0 };
    int y;
    snprintf(path, sizeof path, "%s/%s.pfm", folder, name);
    if (pt_read_image(&theirs, path) == PT_OK && theirs.width == SIZE && theirs.height == SIZE && theirs.channels == 3) {
        for (y = 0; y < SIZE; y++) {
            memcpy(both + 6 * SIZE * y, theirs.pixels + 3 * SIZE * y, 3 * SIZE * sizeof *both);
            memcpy(both + 6 * SIZE * y + 3 * SIZE, ours + 3 * SIZE * y, 3 * SIZE * sizeof *both);
        }
        snprintf(path, sizeof path, "%s/%s.png", folder, name);
        if (pt_write_png(path, both, 2 * SIZE, SIZE, NULL) != PT_OK) fprintf(stderr, "%s: cannot write it\n", path);
    }
    pt_image_free(&theirs);
}
static int wanted(const char *name, int argc, char **argv) {
    int i;
    for (i = 3; i < argc; i++) if (!strcmp(argv[i], name)) return 1;
    return argc <= 3;
}

int main(int argc, char **argv) {
    static float picture[3 * SIZE * SIZE];
    char csv[1024];
    pt_image map = { 0 };
    statistic ours[REGIONS], theirs;
    int i, region;
    if (argc < 2) { fprintf(stderr, "usage: compare_materials MAP.hdr [FOLDER [SETTING...]]\n"); return 1; }
    if (pt_read_image(&map, argv[1]) != PT_OK || map.channels != 3) { fprintf(stderr, "%s\n", map.error); pt_image_free(&map); return 1; }
    snprintf(csv, sizeof csv, "%s/cycles.csv", argc > 2 ? argv[2] : ".");
    printf("| setting | where | Cycles r, g, b | pt.h r, g, b | difference %% | standard error %% | remark |\n|---|---|---|---|---|---|---|\n");
    for (i = 0; i < SETTINGS; i++) {
        int last = i == 0 ? REGIONS : 1;                 /* the first one tells whether camera and map agree: all regions */
        if (!wanted(settings[i].name, argc, argv)) continue;
        if (!render(settings + i, &map, picture, ours)) { pt_image_free(&map); return 1; }
        for (region = 0; region < last; region++) {
            int found = argc > 2 && read_row(csv, settings[i].name, regions[region], &theirs);
            print_row(settings[i].name, regions[region], found ? &theirs : NULL, ours + region, region ? "" : settings[i].remark);
        }
        if (argc > 2) write_pair(argv[2], settings[i].name, picture);
    }
    pt_image_free(&map);
    return 0;
}
