/* One day: the same stones under five suns, from noon to dusk. The sky is integrated through the air, so that one number, where
   the sun is, makes the colours; each strip is exposed as a photographer would, a thousand times longer at the end.
   cc -O2 13_daylight.c -o 13_daylight -lm -lpthread && ./13_daylight [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 150, STRIPS = 5 };

static pt_result draw_strip(float elevation_deg, float stops, float *out) {
    float a = elevation_deg * 3.14159265f / 180;
    pt_vec3 light = {.62f * cosf(a), -sinf(a), .78f * cosf(a)};      /* the way it travels */
    pt_scene *s = pt_scene_create(NULL);
    pt_material field = pt_add_material(s, &(pt_material_desc){ .color = {.22f, .24f, .12f} });
    pt_material stone = pt_add_material(s, &(pt_material_desc){ .color = {.48f, .45f, .41f} });
    pt_material steel = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = {.85f, .85f, .87f} });
    pt_add_quad(s, pt_v3(-3000, 0, -3000), pt_v3(0, 0, 6000), pt_v3(6000, 0, 0), field);
    for (int i = 0; i < 9; i++) {                          /* a ring of stones */
        float turn = .35f + .7f * (float)i, c = cosf(turn), n = sinf(turn);
        pt_xform place = { { c, 0, n, 4.2f * n,   0, 1, 0, 0,   -n, 0, c, 4.2f * c } };
        pt_add_box(s, pt_v3(-.45f, 0, -.3f), pt_v3(.45f, 1.9f + .25f * (float)(i % 3), .3f), &place, stone);
    }
    pt_add_sphere(s, pt_v3(0, .9f, 0), .9f, steel);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = light, .turbidity = 2.5f });

    pt_result result = pt_scene_commit(s);
    if (result != PT_OK) fprintf(stderr, "%s\n", pt_scene_error(s));
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = WIDTH, .height = HEIGHT, .spp = 32, .max_depth = 6,
        .camera = { .eye = {0, 1.7f, 13}, .target = {0, 1.6f, 0}, .vfov_deg = 22 } });
    if (result == PT_OK) result = pt_render_run(r);
    const float *pixels = pt_render_pixels(r);
    for (int i = 0; result == PT_OK && i < 3 * WIDTH * HEIGHT; i++) out[i] = pixels[i] * exp2f(stops);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result;
}

int main(int argc, char **argv) {
    static const struct { float elevation_deg, stops; } hour[STRIPS] = { {55, -6.6f}, {20, -6}, {7, -5}, {1, -2.4f}, {-4, 2.3f} };
    static float picture[3 * WIDTH * HEIGHT * STRIPS];
    pt_result result = PT_OK;
    for (int i = 0; i < STRIPS && result == PT_OK; i++)
        result = draw_strip(hour[i].elevation_deg, hour[i].stops, picture + 3 * WIDTH * HEIGHT * i);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "daylight.png", picture, WIDTH, HEIGHT * STRIPS, 0);
    return result != PT_OK;
}
