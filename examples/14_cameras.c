/* One scene, six cameras: perspective, a five-bladed aperture, orthographic, fisheye, the whole sphere, and a long exposure.
   cc -O2 14_cameras.c -o 14_cameras -lm -lpthread && ./14_cameras [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <stdio.h>
#include <string.h>

enum { W = 320, H = 240 };

int main(int argc, char **argv) {
    static float sheet[2 * H][3 * W][3];
    pt_scene *rotor = pt_scene_create(NULL), *s = pt_scene_create(NULL);

    pt_material red = pt_add_material(rotor, &(pt_material_desc){ .color = {.8f, .1f, .05f} });
    pt_add_box(rotor, pt_v3(-.5f, -.5f, -.5f), pt_v3(.5f, .5f, .5f), NULL, red);
    pt_scene_commit(rotor);

    pt_material pale = pt_add_material(s, &(pt_material_desc){ .color = {.7f, .68f, .62f} });
    pt_material dark = pt_add_material(s, &(pt_material_desc){ .color = {.08f, .09f, .12f} });
    for (int i = 0; i < 144; i++)                          /* a chessboard */
        pt_add_quad(s, pt_v3((float)(i % 12 - 6), 0, (float)(i / 12 - 5)), pt_v3(0, 0, -1), pt_v3(-1, 0, 0),
                    (i + i / 12) % 2 ? pale : dark);
    for (int i = 0; i < 8; i++)
        pt_add_box(s, pt_v3(i % 2 ? 1.6f : -2, 0, 2 - 2 * (float)(i / 2)),
                   pt_v3(i % 2 ? 2 : -1.6f, 2.2f, 2.4f - 2 * (float)(i / 2)), NULL, pale);
    for (int i = 0; i < 24; i++) {                         /* small lamps far behind */
        pt_material lamp = pt_add_material(s, &(pt_material_desc){
            .emission = {60, (float)(20 + i * 7 % 20), (float)(i * 5 % 24)} });
        pt_add_sphere(s, pt_v3((float)(i * 11 % 24 - 12), .5f + (float)(i * 7 % 10) * .6f, -14), .06f, lamp);
    }
    /* While the shutter is open, from time 0 to 1, the cube slides to the right. */
    pt_add_moving_instance(s, rotor, &(pt_xform){{ 1, 0, 0, -.4f,  0, 1, 0, .5f,  0, 0, 1, 0 }},
                                     &(pt_xform){{ 1, 0, 0, .6f,  0, 1, 0, .5f,  0, 0, 1, 0 }});
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.16f, .20f, .32f} });
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = {-1, -.7f, -.9f}, .radius_deg = 2,
        .color = {2.6f, 1.8f, 1.1f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_camera plain = { .eye = {0, 1.2f, 5}, .target = {0, .8f, 0}, .vfov_deg = 45 };
    pt_camera camera[6] = { plain, plain, plain, plain, plain, plain };
    camera[1].aperture = .25f; camera[1].blades = 5; camera[1].vignetting = 1;
    camera[2].projection = PT_CAMERA_ORTHOGRAPHIC; camera[2].height = 5; camera[2].eye = pt_v3(5, 5, 8);
    camera[3].projection = PT_CAMERA_FISHEYE; camera[3].eye = pt_v3(.9f, 1.3f, 2.2f);
    camera[4].projection = PT_CAMERA_EQUIRECTANGULAR; camera[4].eye = pt_v3(0, 1.2f, 2.2f);
    camera[5].shutter_close = 1;

    pt_result result = PT_OK;
    for (int i = 0; i < 6 && result == PT_OK; i++) {
        pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = W, .height = H, .spp = 64, .max_depth = 6,
            .camera = camera[i], .filter = PT_FILTER_BLACKMAN_HARRIS });
        result = pt_render_run(r);
        const float *pixels = pt_render_pixels(r);
        for (int y = 0; y < H && result == PT_OK; y++)
            memcpy(sheet[i / 3 * H + y][i % 3 * W], pixels + 3 * W * y, 3 * W * sizeof *pixels);
        pt_render_destroy(r);
    }
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "cameras.png", &sheet[0][0][0], 3 * W, 2 * H, 0);
    pt_scene_destroy(s);
    pt_scene_destroy(rotor);
    return result != PT_OK;
}
