/* Textures: a checker that fills space and shows where the floor cuts it, marble and clay out of noise, wallpaper of a few
   bytes repeated, and a picture on the wall: your own, if you name one (PFM or Radiance HDR).
   cc -O2 10_textures.c -o 10_textures -lm -lpthread && ./10_textures [FILE.png [PICTURE.hdr]] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <stdio.h>
#include <stdlib.h>

static pt_material matte(pt_scene *s, pt_texture t) {
    return pt_add_material(s, &(pt_material_desc){ .color_texture = t });
}
/* Six by four squares of sRGB bytes, as a painter might put them, top row first. */
static const unsigned char squares[4 * 6 * 3] = {
    226,60,44,  226,60,44,  240,236,224, 240,236,224, 240,236,224, 34,62,140,
    226,60,44,  226,60,44,  240,236,224, 246,200,48,  240,236,224, 34,62,140,
    240,236,224, 28,28,30,  240,236,224, 240,236,224, 28,28,30,   240,236,224,
    246,200,48, 240,236,224, 34,62,140,  240,236,224, 226,60,44,  226,60,44 };
static pt_texture painting(pt_scene *s, const char *path) {
    pt_image image = { 0 };
    pt_texture t;
    if (!path)
        return pt_add_texture(s, &(pt_texture_desc){ .pixels = squares, .width = 6, .height = 4, .channels = 3, .srgb = 1,
            .nearest = 1 });
    if (pt_read_image(&image, path) != PT_OK) { fprintf(stderr, "%s\n", image.error); exit(1); }
    t = pt_add_texture(s, &(pt_texture_desc){ .pixels = image.pixels, .width = image.width, .height = image.height,
        .channels = image.channels, .bits = 32, .wrap_u = PT_WRAP_CLAMP, .wrap_v = PT_WRAP_CLAMP });
    pt_image_free(&image);                                 /* the scene has a copy */
    return t;
}

int main(int argc, char **argv) {
    static const unsigned char stripes[8 * 3] = { 118,134,128, 124,139,133, 118,134,128, 124,139,133,
                                                  150,158,146, 156,163,151, 150,158,146, 156,163,151 };
    pt_scene *s = pt_scene_create(NULL);
    pt_texture checker = pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_CHECKER, .solid = 1, .frequency = 2,
        .color_a = {.66f, .64f, .58f}, .color_b = {.07f, .08f, .10f} });
    pt_texture marble = pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_FBM, .solid = 1, .frequency = 2.5f,
        .octaves = 8, .color_a = {.001f, .002f, .01f}, .color_b = {1, .96f, .90f} });
    pt_texture clay = pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_NOISE, .solid = 1, .frequency = 9,
        .color_a = {.72f, .16f, .04f}, .color_b = {.95f, .62f, .28f} });
    pt_texture paper = pt_add_texture(s, &(pt_texture_desc){ .pixels = stripes, .width = 8, .height = 1, .channels = 3,
        .srgb = 1, .uv_scale = {14, 14}, .uv_rotate_deg = 0 });
    pt_material frame = pt_add_material(s, &(pt_material_desc){ .color = {.09f, .05f, .03f} });
    pt_material lamp  = pt_add_material(s, &(pt_material_desc){ .emission = {17, 15.5f, 13} });
    pt_add_quad(s, pt_v3(-8, 0, -1.5f), pt_v3(0, 0, 12), pt_v3(16, 0, 0), matte(s, checker));
    pt_add_quad(s, pt_v3(-8, 0, -1.5f), pt_v3(16, 0, 0), pt_v3(0, 10, 0), matte(s, paper));
    pt_add_box(s, pt_v3(-1.1f, 1.15f, -1.5f), pt_v3(1.1f, 2.65f, -1.44f), NULL, frame);
    pt_add_quad(s, pt_v3(-1.02f, 1.23f, -1.43f), pt_v3(2.04f, 0, 0), pt_v3(0, 1.34f, 0),
                matte(s, painting(s, argc > 2 ? argv[2] : NULL)));
    pt_add_sphere(s, pt_v3(-.85f, .7f, .1f), .7f, matte(s, marble));
    pt_add_sphere(s, pt_v3(.85f, .55f, .5f), .55f, matte(s, clay));
    pt_add_quad(s, pt_v3(-3, 5, 1), pt_v3(2, 0, 0), pt_v3(0, -.6f, 1.6f), lamp);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.35f, .38f, .42f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 480, .height = 480, .spp = 64, .max_depth = 8,
        .camera = { .eye = {.5f, 1.6f, 6.2f}, .target = {0, 1.25f, 0}, .vfov_deg = 32 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "textures.png", pt_render_pixels(r), 480, 480, 0);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
