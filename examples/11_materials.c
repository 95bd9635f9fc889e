/* 11_materials.c - a sheet of materials: kinds from top to bottom, roughness from left to right.
   cc -O2 11_materials.c -o 11_materials -lm -lpthread && ./11_materials [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"

#define COLUMNS 7

/* A photographer's studio: a large soft light, a strip, and a dim room. */
static pt_vec3 studio(void *user, pt_vec3 d) {
    float soft = d.y > 0.5f && d.x < 0.3f && d.x > -0.7f && d.z > -0.6f && d.z < 0.5f ? 6.0f : 0.0f;
    float strip = d.x > 0.75f && d.y > -0.2f && d.y < 0.6f ? 3.0f : 0.0f, room = 0.12f + 0.1f * d.y;
    (void)user;
    return pt_v3(soft + room + strip, soft + room + 0.9f * strip, soft + 1.1f * room + 0.75f * strip);
}

int main(int argc, char **argv) {
    pt_material_desc kind[] = {
        { .color = {.8f, .3f, .15f} },
        { .bsdf = PT_BSDF_CONDUCTOR },                                                          /* gold */
        { .bsdf = PT_BSDF_CONDUCTOR, .color = {.9f, .9f, .92f}, .roughness_y = .8f },           /* brushed */
        { .bsdf = PT_BSDF_DIELECTRIC },
        { .bsdf = PT_BSDF_DIELECTRIC, .thin = 1, .color = {.75f, .95f, .85f} },
        { .bsdf = PT_BSDF_PRINCIPLED, .color = {.05f, .2f, .6f} },
        { .bsdf = PT_BSDF_PRINCIPLED, .color = {.6f, .02f, .04f}, .coat = 1, .metallic = .6f },
        { .bsdf = PT_BSDF_PRINCIPLED, .color = {.15f, .03f, .2f}, .sheen = 1, .sheen_roughness = .4f, .sheen_color = {.9f, .7f, 1} },
    };
    const int rows = (int)(sizeof kind / sizeof *kind);
    pt_scene *s = pt_scene_create(NULL);
    pt_material ground = pt_add_material(s, &(pt_material_desc){ .color = {.35f, .35f, .36f}, .roughness = 1 });
    int row, column;
    pt_metal("gold", &kind[1].eta, &kind[1].k);
    for (row = 0; row < rows; row++) for (column = 0; column < COLUMNS; column++) {
        pt_material_desc m = kind[row];
        m.roughness = (float)column / (COLUMNS - 1);
        pt_add_sphere(s, pt_v3((float)column - (COLUMNS - 1) / 2.0f, 0.45f, 1.08f * (float)row), 0.45f, pt_add_material(s, &m));
    }
    pt_add_quad(s, pt_v3(-20, 0, -20), pt_v3(0, 0, 50), pt_v3(50, 0, 0), ground);
    pt_add_light(s, &(pt_light_desc){ .radiance = studio });
    pt_scene_commit(s);
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 640, .height = 640, .spp = 64,
        .camera = { .eye = {0, 13.5f, 15}, .target = {0, 0, 3.6f}, .vfov_deg = 27 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "materials.png", pt_render_pixels(r), 640, 640, 0);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
