/* A BSDF of one's own: a glossy lobe round the mirror direction (Phong), or round the direction back to the viewer (a
   retro-reflector, like a road sign). Above: Phong, sharper from left to right. Below: retro, lit from the camera.
   cc -O2 04_user_bsdf.c -o 04_user_bsdf -lm -lpthread && ./04_user_bsdf [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

typedef struct lobe { pt_vec3 color; float exponent; int retro; } lobe;

static float   dot(pt_vec3 a, pt_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static pt_vec3 scale(pt_vec3 a, float k) { return pt_v3(a.x * k, a.y * k, a.z * k); }
static pt_vec3 add(pt_vec3 a, pt_vec3 b) { return pt_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static pt_vec3 cross(pt_vec3 a, pt_vec3 b) { return pt_v3(a.y*b.z - a.z*b.y, a.z*b.x - a.x*b.z, a.x*b.y - a.y*b.x); }

static pt_vec3 axis(const lobe *l, const pt_vertex *x) {
    return l->retro ? x->wo : add(scale(x->ns, 2 * dot(x->ns, x->wo)), scale(x->wo, -1));
}
static int above(const pt_vertex *x, pt_vec3 wi) { return dot(x->ns, wi) * dot(x->ns, x->wo) > 0; }

/* The density: (n + 1) / (2 pi) cos^n round the axis integrates to 1 over the sphere. */
static float lobe_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const lobe *l = (const lobe *)user;
    float c = dot(axis(l, x), wi);
    return c > 0 ? (l->exponent + 1) / 6.2831853f * powf(c, l->exponent) : 0;
}
/* f |cos| = color * the same lobe, cut off at the horizon: so the albedo is at most color, and energy is conserved. */
static pt_vec3 lobe_eval(void *user, const pt_vertex *x, pt_vec3 wi) {
    return above(x, wi) ? scale(((const lobe *)user)->color, lobe_pdf(user, x, wi)) : pt_v3(0, 0, 0);
}
static int lobe_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    const lobe *l = (const lobe *)user;
    pt_vec3 w = axis(l, x), a = fabsf(w.x) < .7f ? pt_v3(1, 0, 0) : pt_v3(0, 1, 0), s = cross(a, w), t;
    float c = powf(1 - u[0], 1 / (l->exponent + 1)), r = sqrtf(fmaxf(0, 1 - c * c)), phi = 6.2831853f * u[1];
    s = scale(s, 1 / sqrtf(dot(s, s)));
    t = cross(w, s);
    out->wi = add(scale(w, c), add(scale(s, r * cosf(phi)), scale(t, r * sinf(phi))));
    return above(x, out->wi);                              /* 0: absorbed; eval is black there, so nothing is lost */
}
static const pt_bsdf_vtable lobe_bsdf = { lobe_eval, lobe_pdf, lobe_sample, NULL };

int main(int argc, char **argv) {
    lobe lobes[10];                                        /* kept until the render is done: materials point to them */
    pt_scene *s = pt_scene_create(NULL);
    for (int i = 0; i < 10; i++) {
        int column = i % 5, retro = i / 5;
        lobes[i].color = retro ? pt_v3(.9f, .25f + .1f * (float)column, .08f) : pt_v3(.85f, .75f, .55f);
        lobes[i].exponent = retro ? powf(2, (float)column + 3) : powf(4, (float)column + 1);
        lobes[i].retro = retro;
        pt_material m = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_USER, .vtable = &lobe_bsdf, .user = &lobes[i] });
        pt_add_sphere(s, pt_v3(1.1f * (float)(column - 2), retro ? .5f : 1.7f, retro ? .4f : -.4f), .5f, m);
    }
    pt_material grey = pt_add_material(s, &(pt_material_desc){ .color = {.30f, .33f, .38f} });
    pt_add_quad(s, pt_v3(-9, 0, -3), pt_v3(0, 0, 12), pt_v3(18, 0, 0), grey);
    pt_add_quad(s, pt_v3(-9, 0, -3), pt_v3(18, 0, 0), pt_v3(0, 9, 0), grey);
    pt_material lamp  = pt_add_material(s, &(pt_material_desc){ .emission = {12, 12, 12} });
    pt_material flash = pt_add_material(s, &(pt_material_desc){ .emission = {7, 7, 7} });
    pt_add_quad(s, pt_v3(-3, 5, 0), pt_v3(2, 0, 0), pt_v3(0, -.6f, 2), lamp);
    pt_add_sphere(s, pt_v3(0, 1.75f, 8.6f), .35f, flash);   /* just above and behind the camera */
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 640, .height = 360, .spp = 64, .max_depth = 8,
        .camera = { .eye = {0, 1.3f, 8}, .target = {0, 1.1f, 0}, .vfov_deg = 26 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "bsdf.png", pt_render_pixels(r), 640, 360, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
