/* A sky by callback, with a low sun in it: a spiral staircase in the evening. The renderer makes a table of the sky's
   brightness when the scene is committed, so it looks for the sun where the sun is.
   cc -O2 06_sky.c -o 06_sky -lm -lpthread && ./06_sky [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

static pt_vec3 mix(pt_vec3 a, pt_vec3 b, float k) {
    return pt_v3(a.x + k * (b.x - a.x), a.y + k * (b.y - a.y), a.z + k * (b.z - a.z));
}
/* Radiance that arrives from the unit direction d. */
static pt_vec3 sky(void *user, pt_vec3 d) {
    const pt_vec3 *sun = (const pt_vec3 *)user;
    const pt_vec3 zenith = {.10f, .22f, .55f}, horizon = {.75f, .62f, .50f}, earth = {.22f, .18f, .15f}, glow = {1, .55f, .25f};
    float cosine = d.x * sun->x + d.y * sun->y + d.z * sun->z;
    pt_vec3 L;
    if (d.y < 0) return earth;
    if (cosine > .9996f) return pt_v3(2600, 1800, 1000);   /* the disk, 3.2 degrees wide: larger than life */
    L = mix(horizon, zenith, powf(d.y, .45f));
    return mix(L, glow, .7f * expf(-12 * (1 - cosine)));
}

int main(int argc, char **argv) {
    pt_vec3 sun = {-.75f, .34f, .567f};
    pt_scene *s = pt_scene_create(NULL);
    pt_material stone = pt_add_material(s, &(pt_material_desc){ .color = {.72f, .66f, .58f} });
    pt_material sand  = pt_add_material(s, &(pt_material_desc){ .color = {.55f, .45f, .34f} });
    float length = sqrtf(sun.x * sun.x + sun.y * sun.y + sun.z * sun.z);
    sun = pt_v3(sun.x / length, sun.y / length, sun.z / length);

    for (int i = 0; i < 44; i++) {                         /* a step: a flat box, turned and lifted */
        float angle = .24f * (float)i, c = cosf(angle), n = sinf(angle);
        pt_xform place = { { c, 0, n, 0,   0, 1, 0, .09f * (float)i,   -n, 0, c, 0 } };
        pt_add_box(s, pt_v3(.12f, .02f, -.16f), pt_v3(1.1f, .09f, .16f), &place, stone);
        pt_add_box(s, pt_v3(1.06f, .09f, -.02f), pt_v3(1.09f, .5f, .01f), &place, stone);      /* a baluster on it */
    }
    pt_add_box(s, pt_v3(-.12f, 0, -.12f), pt_v3(.12f, 4.4f, .12f), NULL, stone);
    pt_add_quad(s, pt_v3(-400, 0, -400), pt_v3(0, 0, 800), pt_v3(800, 0, 0), sand);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .radiance = sky, .user = &sun });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 400, .height = 540, .spp = 32, .max_depth = 8,
        .camera = { .eye = {2.6f, 1.5f, 8.5f}, .target = {.15f, 2.1f, 0}, .vfov_deg = 34 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "sky.png", pt_render_pixels(r), 400, 540, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
