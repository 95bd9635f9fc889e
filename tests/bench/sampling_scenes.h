/* sampling_scenes.h - a dozen scenes and a few that ask different things of the directions a path draws. Each is made by
   code, in a small unit; some use a mesh or a map of ../shared/data where it is. Include it after pt.h. */
#ifndef SAMPLING_SCENES_H
#define SAMPLING_SCENES_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct sampling_scene {
    const char *name;
    void (*build)(pt_scene *s, pt_render_desc *d);           /* d: the camera, and the depth where it matters */
    int reference;                                           /* samples for one */
} sampling_scene;

static pt_material scene_matte(pt_scene *s, float r, float g, float b) {
    return pt_add_material(s, &(pt_material_desc){ .color = { r, g, b } });
}
static pt_material scene_metal(pt_scene *s, float r, float g, float b, float roughness) {
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { r, g, b }, .roughness = roughness });
}
static pt_material scene_plastic(pt_scene *s, float r, float g, float b, float roughness) {
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { r, g, b }, .roughness = roughness });
}
static pt_material scene_glass(pt_scene *s, float roughness) {
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .roughness = roughness });
}
static pt_material scene_lamp(pt_scene *s, float radiance) {
    return pt_add_material(s, &(pt_material_desc){ .emission = { radiance, radiance, radiance } });
}
static void scene_ground(pt_scene *s, float half, pt_material m) {
    pt_add_quad(s, pt_v3(-half, 0, half), pt_v3(2 * half, 0, 0), pt_v3(0, 0, -2 * half), m);
}
static void scene_look(pt_render_desc *d, float ex, float ey, float ez, float tx, float ty, float tz, float vfov_deg) {
    d->camera.eye = pt_v3(ex, ey, ez);
    d->camera.target = pt_v3(tx, ty, tz);
    d->camera.vfov_deg = vfov_deg;
}
static void scene_map(pt_scene *s, const char *file) {       /* a map of ../shared/data, or the daylight sky */
    char path[256];
    pt_image image;
    memset(&image, 0, sizeof image);
    snprintf(path, sizeof path, "../shared/data/env/%s.hdr", file);
    if (pt_read_image(&image, path) == PT_OK)
        pt_add_light(s, &(pt_light_desc){ .texture = pt_add_texture(s, &(pt_texture_desc){ .width = image.width,
            .height = image.height, .channels = image.channels, .bits = 32, .pixels = image.pixels }) });
    else pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = { -1, -.5f, -.3f }, .color = { .02f, .02f, .02f } });
    pt_image_free(&image);
}
/* The bunny, or without it a knot of spheres, of height about 1 on the ground at the origin. */
static void scene_bunny(pt_scene *s, pt_material m) {
    static const char path[] = "../shared/data/meshes/stanford-bunny.obj";
    pt_mesh mesh;
    size_t i;
    memset(&mesh, 0, sizeof mesh);
    if (pt_read_obj(&mesh, path) == PT_OK) {
        float size = mesh.hi.y - mesh.lo.y, x = (mesh.lo.x + mesh.hi.x) / 2, z = (mesh.lo.z + mesh.hi.z) / 2;
        for (i = 0; i < mesh.vertex_count; i++) {
            float *p = mesh.positions + 3 * i;
            p[0] = (p[0] - x) / size; p[1] = (p[1] - mesh.lo.y) / size; p[2] = (p[2] - z) / size;
        }
        pt_mesh_smooth(&mesh, 180);
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = mesh.positions, .vertex_count = mesh.vertex_count, .indices = mesh.indices,
            .index_count = mesh.index_count, .normals = mesh.normals, .material = m });
    } else
        for (i = 0; i < 40; i++) {
            float a = (float)i * .3f;
            pt_add_sphere(s, pt_v3(.35f * cosf(a), .15f + .018f * (float)i, .35f * sinf(a)), .12f, m);
        }
    pt_mesh_free(&mesh);
}
static void scene_box(pt_scene *s, pt_material white, pt_material left, pt_material right) {     /* [0,1]^3, open to -z */
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,0,1), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(0,1,0), pt_v3(1,0,0), pt_v3(0,0,1), white);
    pt_add_quad(s, pt_v3(0,0,1), pt_v3(0,1,0), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(1,0,0), pt_v3(0,0,1), pt_v3(0,1,0), left);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,1,0), pt_v3(0,0,1), right);
}

static void scene_cornell(pt_scene *s, pt_render_desc *d) {
    pt_material white = scene_matte(s, .73f, .73f, .73f);
    scene_box(s, white, scene_matte(s, .65f, .05f, .05f), scene_matte(s, .12f, .45f, .15f));
    pt_add_quad(s, pt_v3(.35f,.999f,.35f), pt_v3(.3f,0,0), pt_v3(0,0,.3f), scene_lamp(s, 15));
    pt_add_box(s, pt_v3(.15f,0,.15f), pt_v3(.45f,.30f,.45f), NULL, white);
    pt_add_box(s, pt_v3(.55f,0,.50f), pt_v3(.85f,.60f,.80f), NULL, white);
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
    d->max_depth = 8;
}
/* A small lamp, 100 times brighter than the glowing walls round it. */
static void scene_small_lamp(pt_scene *s, pt_render_desc *d) {
    pt_material wall = pt_add_material(s, &(pt_material_desc){ .color = {.6f, .6f, .6f}, .emission = {.2f, .2f, .2f} });
    pt_material white = scene_matte(s, .7f, .7f, .7f);
    scene_box(s, white, wall, wall);
    pt_add_sphere(s, pt_v3(.5f, .8f, .5f), .03f, scene_lamp(s, 20));
    pt_add_sphere(s, pt_v3(.3f, .2f, .4f), .2f, white);
    pt_add_sphere(s, pt_v3(.7f, .2f, .6f), .2f, scene_plastic(s, .3f, .4f, .7f, .3f));
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
}
/* After Veach's plates: rough to smooth, under spheres of equal power. */
static void scene_plates(pt_scene *s, pt_render_desc *d) {
    static const float roughness[4] = { .08f, .16f, .28f, .45f }, radius[4] = { .02f, .07f, .2f, .5f };
    int i;
    scene_ground(s, 10, scene_matte(s, .3f, .3f, .3f));
    for (i = 0; i < 4; i++) {
        float y = .3f + .35f * (float)i * (.5f + .12f * (float)i), z = -.1f - .75f * (float)i, tilt = (18 + 8 * (float)i) * .0174533f;
        pt_add_quad(s, pt_v3(-2, y, z), pt_v3(4, 0, 0), pt_v3(0, .6f * sinf(tilt), -.6f * cosf(tilt)),
                    scene_metal(s, .6f, .6f, .6f, roughness[i]));
        pt_add_sphere(s, pt_v3(-1.8f + 1.15f * (float)i, 3.6f, -3.4f), radius[i], scene_lamp(s, .9f / (radius[i] * radius[i])));
    }
    scene_look(d, 0, 2.6f, 6.5f, 0, 1.4f, -2, 36);
}
static void scene_bunny_sunset(pt_scene *s, pt_render_desc *d) {
    pt_material grey = scene_matte(s, .6f, .6f, .6f);
    scene_ground(s, 6, grey);
    scene_bunny(s, grey);
    scene_map(s, "sunset");
    scene_look(d, 0, 1, 2.6f, 0, .45f, 0, 40);
}
static void scene_metal_bunny(pt_scene *s, pt_render_desc *d) {
    scene_ground(s, 6, scene_matte(s, .6f, .6f, .6f));
    scene_bunny(s, scene_metal(s, .9f, .7f, .4f, .3f));
    scene_map(s, "sunset");
    scene_look(d, 0, 1, 2.6f, 0, .45f, 0, 40);
}
static void scene_white_sky(pt_scene *s, pt_render_desc *d) {
    pt_material grey = scene_matte(s, .6f, .6f, .6f);
    scene_ground(s, 6, grey);
    scene_bunny(s, grey);
    pt_add_light(s, &(pt_light_desc){ .color = { 1, 1, 1 } });
    scene_look(d, 0, 1, 2.6f, 0, .45f, 0, 40);
}
/* A soft map without a sun, on plastic, metal and glass. */
static void scene_forest(pt_scene *s, pt_render_desc *d) {
    scene_ground(s, 8, scene_matte(s, .5f, .45f, .4f));
    pt_add_sphere(s, pt_v3(-1.5f, .5f, 0), .5f, scene_plastic(s, .6f, .1f, .1f, .25f));
    pt_add_sphere(s, pt_v3(-.4f, .5f, .3f), .5f, scene_metal(s, .95f, .93f, .88f, .12f));
    pt_add_sphere(s, pt_v3(.7f, .5f, 0), .5f, scene_glass(s, 0));
    pt_add_sphere(s, pt_v3(1.8f, .5f, .2f), .5f, scene_glass(s, .3f));
    scene_map(s, "forest");
    scene_look(d, 0, 1.6f, 5, 0, .5f, 0, 34);
}
static void scene_daylight(pt_scene *s, pt_render_desc *d) {
    pt_material wall = scene_matte(s, .7f, .65f, .6f);
    scene_ground(s, 20, scene_matte(s, .35f, .4f, .3f));
    pt_add_box(s, pt_v3(-2, 0, -2), pt_v3(-.5f, 1.6f, 0), NULL, wall);
    pt_add_box(s, pt_v3(.3f, 0, -1.5f), pt_v3(1.6f, .7f, .2f), NULL, scene_plastic(s, .2f, .3f, .6f, .3f));
    pt_add_sphere(s, pt_v3(0, .35f, .8f), .35f, scene_metal(s, .9f, .9f, .9f, .2f));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = { -.8f, -.6f, -.5f }, .color = { .02f, .02f, .02f } });
    scene_look(d, .5f, 1.8f, 5.5f, 0, .5f, 0, 36);
}
/* A ceiling that is all lamp: what the BSDF finds anyway. */
static void scene_bright_ceiling(pt_scene *s, pt_render_desc *d) {
    pt_material white = scene_matte(s, .7f, .7f, .7f);
    scene_box(s, white, scene_matte(s, .6f, .3f, .1f), scene_matte(s, .1f, .3f, .6f));
    pt_add_quad(s, pt_v3(.01f,.99f,.01f), pt_v3(.98f,0,0), pt_v3(0,0,.98f), scene_lamp(s, 1));
    pt_add_sphere(s, pt_v3(.3f, .2f, .4f), .2f, scene_metal(s, .9f, .9f, .9f, .2f));
    pt_add_sphere(s, pt_v3(.7f, .2f, .6f), .2f, white);
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
}
static float scene_random(uint32_t *state) { *state = *state * 1664525u + 1013904223u; return (float)(*state >> 8) * (1.0f / 16777216); }
static void scene_many_lamps(pt_scene *s, pt_render_desc *d) {
    uint32_t state = 7;
    int i;
    scene_ground(s, 4, scene_matte(s, .6f, .6f, .6f));
    for (i = 0; i < 6; i++) pt_add_box(s, pt_v3(-1.7f + .6f * (float)i, 0, -.8f + .3f * (float)(i % 3)), pt_v3(-1.4f + .6f * (float)i, .5f,
                                       -.5f + .3f * (float)(i % 3)), NULL, scene_plastic(s, .6f, .5f, .4f, .2f));
    for (i = 0; i < 200; i++) {
        float x = 4 * scene_random(&state) - 2, y = .1f + .8f * scene_random(&state), z = 4 * scene_random(&state) - 3;
        pt_add_sphere(s, pt_v3(x, y, z), .01f, scene_lamp(s, 5 + 60 * scene_random(&state)));
    }
    scene_look(d, 0, 1.2f, 3.5f, 0, .3f, 0, 40);
}
/* Lamps that shine away from what is seen, at walls: all light comes by way of those. */
static void scene_indirect(pt_scene *s, pt_render_desc *d) {
    pt_material white = scene_matte(s, .75f, .75f, .75f), lamp = scene_lamp(s, 12);
    scene_box(s, white, scene_matte(s, .6f, .3f, .1f), scene_matte(s, .1f, .3f, .6f));
    pt_add_quad(s, pt_v3(.4f,.8f,.4f), pt_v3(0,0,.2f), pt_v3(.2f,0,0), lamp);           /* up */
    pt_add_quad(s, pt_v3(.2f,.3f,.95f), pt_v3(0,.3f,0), pt_v3(.6f,0,0), white);
    pt_add_quad(s, pt_v3(.3f,.4f,.97f), pt_v3(0,.1f,0), pt_v3(.4f,0,0), lamp);           /* hidden behind the board: backwards */
    pt_add_sphere(s, pt_v3(.35f, .2f, .4f), .2f, scene_metal(s, .9f, .8f, .7f, .25f));
    pt_add_sphere(s, pt_v3(.75f, .15f, .35f), .15f, white);
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
}
static void scene_glass_lamp(pt_scene *s, pt_render_desc *d) {
    scene_box(s, scene_matte(s, .7f, .7f, .7f), scene_matte(s, .6f, .1f, .1f), scene_matte(s, .1f, .5f, .1f));
    pt_add_quad(s, pt_v3(.3f,.999f,.3f), pt_v3(.4f,0,0), pt_v3(0,0,.4f), scene_lamp(s, 8));
    pt_add_sphere(s, pt_v3(.32f, .25f, .55f), .22f, scene_glass(s, 0));
    pt_add_sphere(s, pt_v3(.7f, .2f, .4f), .18f, scene_glass(s, .25f));
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
}
/* Walls, floor and things all glossy, two lamps and a dim sky. */
static void scene_glossy(pt_scene *s, pt_render_desc *d) {
    scene_box(s, scene_plastic(s, .6f, .6f, .6f, .3f), scene_metal(s, .9f, .5f, .3f, .35f), scene_metal(s, .4f, .6f, .9f, .15f));
    pt_add_quad(s, pt_v3(.2f,.99f,.3f), pt_v3(.2f,0,0), pt_v3(0,0,.2f), scene_lamp(s, 14));
    pt_add_sphere(s, pt_v3(.8f, .75f, .6f), .03f, scene_lamp(s, 120));
    pt_add_sphere(s, pt_v3(.3f, .2f, .4f), .2f, scene_metal(s, .95f, .93f, .88f, .2f));
    pt_add_sphere(s, pt_v3(.7f, .2f, .6f), .2f, scene_plastic(s, .1f, .4f, .2f, .1f));
    pt_add_light(s, &(pt_light_desc){ .color = { .05f, .06f, .08f } });
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
}
/* Lamps indoors, sky and sun through a window. */
static void scene_window(pt_scene *s, pt_render_desc *d) {
    pt_material white = scene_matte(s, .7f, .7f, .7f);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,0,1), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(0,1,0), pt_v3(1,0,0), pt_v3(0,0,1), white);
    pt_add_quad(s, pt_v3(0,0,1), pt_v3(0,1,0), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,1,0), pt_v3(0,0,1), scene_matte(s, .3f, .4f, .6f));
    pt_add_quad(s, pt_v3(0,0,-1.6f), pt_v3(1,0,0), pt_v3(0,1,0), white);
    pt_add_quad(s, pt_v3(1,0,0), pt_v3(0,0,1), pt_v3(0,.4f,0), white);                   /* round the window */
    pt_add_quad(s, pt_v3(1,.8f,0), pt_v3(0,0,1), pt_v3(0,.2f,0), white);
    pt_add_quad(s, pt_v3(1,.4f,0), pt_v3(0,0,.3f), pt_v3(0,.4f,0), white);
    pt_add_quad(s, pt_v3(1,.4f,.7f), pt_v3(0,0,.3f), pt_v3(0,.4f,0), white);
    pt_add_sphere(s, pt_v3(.2f, .85f, .8f), .04f, scene_lamp(s, 10));
    pt_add_sphere(s, pt_v3(.4f, .2f, .5f), .2f, white);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = { -.8f, -.5f, .2f }, .color = { .02f, .02f, .02f } });
    scene_look(d, .5f, .5f, -1.4f, .5f, .5f, 0, 40);
}

static const sampling_scene sampling_scenes[] = {
    { "cornell", scene_cornell, 16384 }, { "small_lamp", scene_small_lamp, 16384 }, { "plates", scene_plates, 16384 },
    { "bunny_sunset", scene_bunny_sunset, 16384 }, { "metal_bunny", scene_metal_bunny, 16384 }, { "white_sky", scene_white_sky, 8192 },
    { "forest", scene_forest, 16384 }, { "daylight", scene_daylight, 16384 }, { "bright_ceiling", scene_bright_ceiling, 16384 },
    { "many_lamps", scene_many_lamps, 16384 }, { "indirect", scene_indirect, 32768 }, { "glass_lamp", scene_glass_lamp, 32768 },
    { "glossy", scene_glossy, 16384 }, { "window", scene_window, 32768 }
};
/* One of them, committed, and a description to render it by. */
static inline pt_scene *scene_of(const sampling_scene *c, pt_render_desc *d, int size, int spp) {
    pt_scene *s = pt_scene_create(NULL);
    memset(d, 0, sizeof *d);
    d->width = d->height = size;
    d->spp = spp;
    d->threads = 2;
    c->build(s, d);
    if (pt_scene_commit(s) != PT_OK) { printf("%s: %s\n", c->name, pt_scene_error(s)); exit(1); }
    return s;
}
enum { SAMPLING_SCENES = sizeof sampling_scenes / sizeof *sampling_scenes };
#endif
