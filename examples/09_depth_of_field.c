/* Depth of field: a lens with an opening, focused on the red ball. Far lamps become disks, as in a photograph.
   cc -O2 09_depth_of_field.c -o 09_depth_of_field -lm -lpthread && ./09_depth_of_field [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <stdio.h>

int main(int argc, char **argv) {
    pt_scene *s = pt_scene_create(NULL);
    pt_rng random;
    pt_rng_seed(&random, 7, 0);
    pt_material table  = pt_add_material(s, &(pt_material_desc){ .color = {.20f, .15f, .12f} });
    pt_material red    = pt_add_material(s, &(pt_material_desc){ .color = {.75f, .06f, .05f} });
    pt_material white  = pt_add_material(s, &(pt_material_desc){ .color = {.70f, .68f, .64f} });
    pt_material window = pt_add_material(s, &(pt_material_desc){ .emission = {14, 13, 12} });
    pt_add_quad(s, pt_v3(-60, 0, -60), pt_v3(0, 0, 80), pt_v3(120, 0, 0), table);
    pt_add_quad(s, pt_v3(-6, 3, -1), pt_v3(2, 2, 0), pt_v3(0, 0, 5), window);

    for (int i = 0; i < 11; i++)                           /* balls in a row, the fourth is in focus */
        pt_add_sphere(s, pt_v3(-1.9f + .62f * (float)i, .5f, 2.8f - 1.35f * (float)i), .5f, i == 3 ? red : white);

    for (int i = 0; i < 60; i++) {                         /* a town's lights in the distance */
        float x = 40 * pt_rng_float(&random) - 20, y = .5f + 9 * pt_rng_float(&random), warmth = pt_rng_float(&random);
        pt_material light = pt_add_material(s, &(pt_material_desc){ .emission = {40, 16 + 20 * warmth, 4 + 26 * warmth * warmth} });
        pt_add_sphere(s, pt_v3(x, y, -34), .09f, light);
    }
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.012f, .018f, .035f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    /* aperture is the lens's radius in metres; focus would be the distance to the target anyway, if left zero. */
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 640, .height = 360, .spp = 96, .max_depth = 8,
        .camera = { .eye = {-.9f, 1.35f, 7}, .target = {-.04f, .5f, -1.25f}, .vfov_deg = 30, .aperture = .14f } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "focus.png", pt_render_pixels(r), 640, 360, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
