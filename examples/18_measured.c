/* BRDFs as tables. A measured one comes from a file; here are three that were measured nowhere, and that no other material
   is: a beetle's shell, whose colour goes with the angle, a road sign, which sends light back to where it came from, and satin
   with threads of two colours. A file of the MERL database takes the place of the first.
   cc -O2 18_measured.c -o 18_measured -lm -lpthread && ./18_measured [FILE.png [FILE.binary]] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

/* h is half-way between the directions of light and eye. f may look at the angles between h and the normal, and between h and
   the light; the third, light's azimuth about h, none of these three asks for: one cell has all of it. */
typedef pt_vec3 brdf(float theta_h, float theta_d);
static pt_vec3 gray(float x) { return pt_v3(x, x, x); }
static pt_vec3 mad(pt_vec3 a, float s, pt_vec3 b) { return pt_v3(a.x * s + b.x, a.y * s + b.y, a.z * s + b.z); }

/* A highlight as real ones are, sharp with wide skirts, that reflects about the share k (Löw et al. 2012). */
static float gloss(float theta_h, float sharp, float k) {
    return k * sharp * .7f / 25.1f / powf(1 + sharp * (1 - cosf(theta_h)), 1.7f);
}
/* A film of 350 nm: the wavelengths that its two faces reflect in step are seen. */
static pt_vec3 beetle(float theta_h, float theta_d) {
    float n = 1.6f, s = sinf(theta_d) / n, way = 2 * n * 350 * sqrtf(1 - s * s);
    float r = sinf(3.14159f * way / 610), g = sinf(3.14159f * way / 545), b = sinf(3.14159f * way / 465);
    return mad(pt_v3(r * r, g * g, b * b), gloss(theta_h, 30, .9f), gray(.004f));
}
/* Glass beads: what comes back leaves within a few degrees of theta_d = 0, whatever the normal. */
static pt_vec3 road_sign(float theta_h, float theta_d) {
    float back = expf(-theta_d * theta_d / (.11f * .11f)) * 4;
    return mad(pt_v3(1, .55f, .08f), back, mad(gray(1), gloss(theta_h, 2000, .03f), pt_v3(.13f, .045f, .01f)));
}
/* Threads that lie across one another: a wide highlight of one colour, and a glow of the other when light and eye are apart. */
static pt_vec3 satin(float theta_h, float theta_d) {
    float apart = powf(sinf(theta_d), 3);
    return mad(pt_v3(.95f, .35f, .45f), gloss(theta_h, 7, .45f) * (1 - apart),
               mad(pt_v3(.2f, .35f, .95f), .5f * apart, pt_v3(.03f, .01f, .04f)));
}

static pt_measured tabulate(pt_scene *s, brdf *f) {
    enum { H = 90, D = 90 };
    static pt_vec3 cells[H][D];
    for (int h = 0; h < H; h++) for (int d = 0; d < D; d++) {
        float x = ((float)h + .5f) / H, y = ((float)d + .5f) / D;
        cells[h][d] = f(1.570796f * x * x, 1.570796f * y);         /* narrow cells where highlights are */
    }
    return pt_add_measured(s, &(pt_measured_desc){ .values = &cells[0][0].x, .cells_h = H, .cells_d = D, .cells_p = 1 });
}

int main(int argc, char **argv) {
    brdf *kinds[] = { beetle, road_sign, satin };
    pt_scene *s = pt_scene_create(NULL);
    pt_merl file = {0};
    if (argc > 2 && pt_read_merl(&file, argv[2]) != PT_OK) { fprintf(stderr, "%s\n", file.error); return 1; }
    for (int i = 0; i < 3; i++) {
        pt_measured table = i == 0 && file.values ? pt_add_measured(s, &(pt_measured_desc){ .values = file.values })
                                                  : tabulate(s, kinds[i]);
        pt_material m = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MEASURED, .measured = table });
        pt_add_sphere(s, pt_v3(1.35f * (float)(i - 1), .6f, 0), .6f, m);
    }
    pt_merl_free(&file);                                           /* the scene has its own */
    pt_material floor = pt_add_material(s, &(pt_material_desc){ .color = {.20f, .21f, .23f} });
    pt_material lamp  = pt_add_material(s, &(pt_material_desc){ .emission = {9, 9, 9} });
    pt_material flash = pt_add_material(s, &(pt_material_desc){ .emission = {60, 58, 54} });
    pt_add_quad(s, pt_v3(-20, 0, 20), pt_v3(40, 0, 0), pt_v3(0, 0, -40), floor);
    pt_add_quad(s, pt_v3(-4, 4, -1), pt_v3(3, 1, 0), pt_v3(0, .8f, 2), lamp);
    pt_add_sphere(s, pt_v3(.3f, 2.4f, 7), .22f, flash);            /* beside the camera */
    pt_add_light(s, &(pt_light_desc){ .color = {.5f, .52f, .55f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 640, .height = 360, .spp = 64,
        .camera = { .eye = {0, 2.3f, 7}, .target = {0, .55f, 0}, .vfov_deg = 18 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "measured.png", pt_render_pixels(r), 640, 360, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
