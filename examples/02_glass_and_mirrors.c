/* A mirror ball and a glass ball under a lamp. The glass gathers the lamp's light into a bright spot, a caustic:
   nothing asks for it, paths that leave the floor through the glass simply find the lamp.
   cc -O2 02_glass_and_mirrors.c -o 02_glass_and_mirrors -lm -lpthread && ./02_glass_and_mirrors [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <stdio.h>

int main(int argc, char **argv) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material white  = pt_add_material(s, &(pt_material_desc){ .color = {.75f, .75f, .75f} });
    pt_material blue   = pt_add_material(s, &(pt_material_desc){ .color = {.15f, .30f, .55f} });
    pt_material orange = pt_add_material(s, &(pt_material_desc){ .color = {.70f, .32f, .10f} });
    pt_material mirror = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = {.95f, .93f, .88f} });
    pt_material glass  = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.5f });
    pt_material lamp   = pt_add_material(s, &(pt_material_desc){ .emission = {10, 8.8f, 7.3f} });

    /* A room, seen from its open side. Every quad's normal, edge_u x edge_v, points inwards. */
    pt_add_quad(s, pt_v3(-2,0,-2), pt_v3(0,0,4), pt_v3(4,0,0), white);       /* floor   */
    pt_add_quad(s, pt_v3(-2,3,-2), pt_v3(4,0,0), pt_v3(0,0,4), white);       /* ceiling */
    pt_add_quad(s, pt_v3(-2,0,-2), pt_v3(4,0,0), pt_v3(0,3,0), white);       /* back    */
    pt_add_quad(s, pt_v3(-2,0,-2), pt_v3(0,3,0), pt_v3(0,0,4), blue);        /* left    */
    pt_add_quad(s, pt_v3(2,0,-2),  pt_v3(0,0,4), pt_v3(0,3,0), orange);      /* right   */
    pt_add_quad(s, pt_v3(-.2f,2.99f,-.8f), pt_v3(1.5f,0,0), pt_v3(0,0,1.5f), lamp);

    pt_add_sphere(s, pt_v3(-.85f, .8f, -.8f), .8f, mirror);
    pt_add_sphere(s, pt_v3(.75f, .7f, .45f), .7f, glass);
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    /* Light that has gone into the glass needs some more bounces to come out again: 16 of them. */
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 512, .height = 384, .spp = 48, .max_depth = 16,
        .camera = { .eye = {0, 1.5f, 6.2f}, .target = {0, 1.4f, 0}, .vfov_deg = 36 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "glass.png", pt_render_pixels(r), 512, 384, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
