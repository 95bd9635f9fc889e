/* A sheet of materials: kinds from top to bottom, roughness from 0 to 1 from left to right. The rows, the far one first:
   clay, gold, turned aluminium (rough across its grooves, smooth along them), glass, a soap bubble's thin wall, plastic,
   car paint under a clear coat that stays smooth, cloth with fuzz.
   cc -O2 11_materials.c -o 11_materials -lm -lpthread && ./11_materials [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"

#define COLUMNS 7

/* A photographer's studio: a large soft light, a strip, and a dim room. */
static pt_vec3 studio(void *user, pt_vec3 d) {
    float soft = d.y > 0.5f && d.x < 0.3f && d.x > -0.7f && d.z > -0.6f && d.z < 0.5f ? 2.2f : 0.0f;
    float strip = d.x > 0.75f && d.y > 0.05f && d.y < 0.6f ? 1.6f : 0.0f, room = 0.16f + 0.12f * d.y;
    (void)user;
    return pt_v3(soft + 0.9f * room + strip, soft + room + 0.8f * strip, soft + 1.2f * room + 0.55f * strip);
}

int main(int argc, char **argv) {
    pt_material_desc kind[] = {
        { .color = {.55f, .17f, .08f} },
        { .bsdf = PT_BSDF_CONDUCTOR },
        { .bsdf = PT_BSDF_CONDUCTOR, .roughness_y = .12f, .rotation_deg = 90 },
        { .bsdf = PT_BSDF_DIELECTRIC },
        { .bsdf = PT_BSDF_DIELECTRIC, .thin = 1, .color = {.45f, .80f, .62f} },
        { .bsdf = PT_BSDF_PRINCIPLED, .color = {.02f, .09f, .38f} },
        { .bsdf = PT_BSDF_PRINCIPLED, .color = {.45f, .01f, .02f}, .coat = 1, .metallic = .6f },
        { .bsdf = PT_BSDF_PRINCIPLED, .color = {.05f, .015f, .09f}, .sheen = 1, .sheen_roughness = .4f,
          .sheen_color = {.75f, .5f, .9f} },
    };
    const int rows = (int)(sizeof kind / sizeof *kind);
    pt_scene *s = pt_scene_create(NULL);
    pt_material ground = pt_add_material(s, &(pt_material_desc){ .color = {.22f, .21f, .20f}, .roughness = 1 });
    int row, column;
    pt_metal("gold", &kind[1].eta, &kind[1].k);
    pt_metal("aluminium", &kind[2].eta, &kind[2].k);
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
