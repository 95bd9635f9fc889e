/* 12_prism.c - white light through a slit and a prism. Glass with an Abbe number bends blue more than red; a path that
   meets it carries one wavelength from there on. Rays from the floor would hardly ever find the sun through prism and slit
   by chance, so the example adds a density of its own to the mixture: a narrow cone where the light must come from.
   cc -O2 12_prism.c -o 12_prism -lm -lpthread && ./12_prism [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>

#define WIDTH 640
#define HEIGHT 360

/* At the angle of least deviation, the ray inside is horizontal, and it comes in and goes out 30 degrees off. */
static const pt_vec3 to_light = { -0.8660f, 0.5f, 0 };
#define ONE_MINUS_COS 0.009f                             /* of 7.7 degrees */

static int cone_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    float h = u[0] * ONE_MINUS_COS, r = sqrtf(h * (2 - h)), c = 1 - h, up = r * sinf(6.2831853f * u[1]), side = r * cosf(6.2831853f * u[1]);
    (void)user; (void)x;
    *wi = pt_v3(to_light.x * c + 0.5f * up, to_light.y * c + 0.8660f * up, side);
    return 1;
}
static float cone_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    (void)user; (void)x;
    return wi.x * to_light.x + wi.y * to_light.y >= 1 - ONE_MINUS_COS ? 1 / (6.2831853f * ONE_MINUS_COS) : 0.0f;
}

int main(int argc, char **argv) {
    static const float corner[] = { -.5f,-.289f,-.7f,  .5f,-.289f,-.7f,  0,.577f,-.7f,  -.5f,-.289f,.7f,  .5f,-.289f,.7f,  0,.577f,.7f };
    static const unsigned face[] = { 0,2,1, 3,4,5, 0,1,4, 0,4,3, 1,2,5, 1,5,4, 2,0,3, 2,3,5 };
    pt_scene *s = pt_scene_create(NULL);
    pt_material glass = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.73f, .abbe = 28 });
    pt_material sun = pt_add_material(s, &(pt_material_desc){ .emission = {30000, 30000, 30000} });
    pt_material paper = pt_add_material(s, &(pt_material_desc){ .color = {.8f, .8f, .8f} });
    pt_material black = pt_add_material(s, &(pt_material_desc){ .color = {.02f, .02f, .02f} });
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = corner, .vertex_count = 6, .indices = face, .index_count = 24, .material = glass });
    pt_add_quad(s, pt_v3(-1.2f, -1, -3), pt_v3(0, 0, 6), pt_v3(6, 0, 0), paper);
    pt_add_quad(s, pt_v3(-1.2f, -1, -3), pt_v3(0, .575f, 0), pt_v3(0, 0, 6), black);     /* the slit: 5 cm */
    pt_add_quad(s, pt_v3(-1.2f, -.375f, -3), pt_v3(0, 1.4f, 0), pt_v3(0, 0, 6), black);
    pt_add_sphere(s, pt_v3(-173.2f, -100, 0), 1.0f, sun);
    pt_add_light(s, &(pt_light_desc){ .color = {.02f, .02f, .022f} });
    pt_add_density(s, &(pt_density_desc){ .weight = .6f, .sample = cone_sample, .pdf = cone_pdf });
    pt_scene_commit(s);
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = WIDTH, .height = HEIGHT, .spp = 256,
        .camera = { .eye = {2.2f, 1.6f, 5}, .target = {.8f, -.5f, 0}, .vfov_deg = 33 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "prism.png", pt_render_pixels(r), WIDTH, HEIGHT, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
