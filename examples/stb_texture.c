/* PNG, JPEG and other pictures as textures: another library reads them, here stb_image (one header, public domain; Debian
   has it in libstb-dev). The five lines are in picture().
   cc -O2 stb_texture.c -o stb_texture -lm -lpthread && ./stb_texture PICTURE.png [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#include <stdio.h>

static pt_texture picture(pt_scene *s, const char *path, int *width, int *height) {
    unsigned char *pixels = stbi_load(path, width, height, NULL, 4);               /* any file as RGBA, top row first */
    pt_texture t = { 0 };
    if (pixels) t = pt_add_texture(s, &(pt_texture_desc){ .pixels = pixels, .width = *width, .height = *height,
        .channels = 4, .srgb = 1 });
    stbi_image_free(pixels);                               /* the scene has a copy */
    return t;
}

int main(int argc, char **argv) {
    pt_scene *s = pt_scene_create(NULL);
    int width = 1, height = 1;
    if (argc < 2) { fprintf(stderr, "usage: %s PICTURE.png [FILE.png]\n", argv[0]); return 2; }
    pt_texture t = picture(s, argv[1], &width, &height);
    if (!t.id) {
        fprintf(stderr, "%s: %s\n", argv[1], *pt_scene_error(s) ? pt_scene_error(s) : stbi_failure_reason());
        return 1;
    }
    float w = (float)width / (float)height;                /* a print, a metre high, leaning back */
    pt_material print = pt_add_material(s, &(pt_material_desc){ .color_texture = t });
    pt_material floor = pt_add_material(s, &(pt_material_desc){ .color = {.5f, .48f, .45f} });
    pt_add_quad(s, pt_v3(-w / 2, 0, 0), pt_v3(w, 0, 0), pt_v3(0, .98f, -.2f), print);
    pt_add_quad(s, pt_v3(-50, 0, -50), pt_v3(0, 0, 100), pt_v3(100, 0, 0), floor);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {1, 1, 1} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 480, .height = 360, .spp = 64,
        .camera = { .eye = {.6f, .9f, 2.6f}, .target = {0, .45f, 0}, .vfov_deg = 32 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 2 ? argv[2] : "print.png", pt_render_pixels(r), 480, 360, 0);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
