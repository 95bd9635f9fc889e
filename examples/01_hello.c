/* The Cornell box in 25 lines.
   cc -O2 01_hello.c -o 01_hello -lm -lpthread && ./01_hello [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"

int main(int argc, char **argv) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material white = pt_add_material(s, &(pt_material_desc){ .color = {.73f, .73f, .73f} });
    pt_material red   = pt_add_material(s, &(pt_material_desc){ .color = {.65f, .05f, .05f} });
    pt_material green = pt_add_material(s, &(pt_material_desc){ .color = {.12f, .45f, .15f} });
    pt_material lamp  = pt_add_material(s, &(pt_material_desc){ .emission = {15, 15, 15} });
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,0,1), pt_v3(1,0,0), white);            /* floor   */
    pt_add_quad(s, pt_v3(0,1,0), pt_v3(1,0,0), pt_v3(0,0,1), white);            /* ceiling */
    pt_add_quad(s, pt_v3(0,0,1), pt_v3(0,1,0), pt_v3(1,0,0), white);            /* back    */
    pt_add_quad(s, pt_v3(1,0,0), pt_v3(0,0,1), pt_v3(0,1,0), red);              /* left    */
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,1,0), pt_v3(0,0,1), green);            /* right   */
    pt_add_quad(s, pt_v3(.35f,.999f,.35f), pt_v3(.3f,0,0), pt_v3(0,0,.3f), lamp);
    pt_add_box(s, pt_v3(.15f,0,.15f), pt_v3(.45f,.30f,.45f), NULL, white);
    pt_add_box(s, pt_v3(.55f,0,.50f), pt_v3(.85f,.60f,.80f), NULL, white);
    pt_scene_commit(s);
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 512, .height = 512, .spp = 32,
        .camera = { .eye = {.5f, .5f, -1.37f}, .target = {.5f, .5f, 0} } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "hello.png", pt_render_pixels(r), 512, 512, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
