/* Media: a lamp and sunbeams in fog, a cloud on a grid, jelly, fire. A ray hits a particle, or passes; all else is as ever.
   cc -O2 19_media.c -o 19_media -lm -lpthread && ./19_media [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"

enum { N = 96 };
static float cloud[N * N * N];

static float bumpy(float x, float y, float z) {          /* about -1 to 1 */
    float s = 0, weight = .5f;
    int k;
    for (k = 0; k < 4; k++, weight *= .5f, x = 1.9f * x + 1, y = 2 * y + 2, z = 2.1f * z + 3)
        s += weight * (float)(sin(x) * sin(1.1f * y + .5f) * sin(.9f * z + 1));
    return s;
}
static void grow(void) {                                 /* a ball, its border ragged */
    int i;
    for (i = 0; i < N * N * N; i++) {
        float x = (float)(i % N) / N - .5f, y = (float)(i / N % N) / N - .5f, z = (float)(i / N / N) / N - .5f;
        float d = 5 * (.38f - sqrtf(x * x + 2 * y * y + z * z)) + 1.6f * bumpy(13 * x, 13 * y, 13 * z);
        cloud[i] = d < 0 ? 0 : d > 1 ? 1 : d;
    }
}
static float flame(void *user, pt_vec3 p) {              /* a cone that flickers */
    float x = p.x - 1.05f, z = p.z - .2f, r = sqrtf(x * x + z * z) + .05f * bumpy(9 * p.x, 5 * p.y, 9 * p.z);
    (void)user;
    return r < .28f * (1 - p.y) ? 1.0f : 0.0f;
}
static pt_vec3 heat(void *user, pt_vec3 p) { (void)user; return pt_v3(1, .45f * (1 - .6f * p.y), .12f * (1 - p.y)); }

int main(int argc, char **argv) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material none = { 0 }, wall = pt_add_material(s, &(pt_material_desc){ .color = {.3f, .3f, .3f} });
    pt_medium jelly = pt_add_medium(s, &(pt_medium_desc){ .sigma_a = {.3f, 2.5f, 9}, .sigma_s = {3, 3, 3}, .g = .6f });
    pt_material skin = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_NONE, .inside = jelly });     /* with PT_BSDF_DIELECTRIC: in glass */
    pt_shape everything;
    int k;
    pt_add_quad(s, pt_v3(-4, 0, 3), pt_v3(8, 0, 0), pt_v3(0, 0, -6), wall);              /* floor and back */
    pt_add_quad(s, pt_v3(-4, 0, -2), pt_v3(8, 0, 0), pt_v3(0, 4, 0), wall);
    for (k = 0; k < 5; k++)                                                             /* slats that cut the sun into beams */
        pt_add_quad(s, pt_v3(-2.6f, .9f + .5f * (float)k, -2), pt_v3(0, .3f, 0), pt_v3(0, 0, 4), wall);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = {1, -.55f, -.1f}, .color = {6, 5, 4}, .radius_deg = 1 });
    pt_add_light(s, &(pt_light_desc){ .color = {.04f, .06f, .1f} });
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_POINT, .position = {.5f, 2.35f, -.6f}, .radius = .04f, .color = {25, 22, 18} });

    grow();
    pt_add_volume(s, pt_add_box(s, pt_v3(-1.5f, .9f, -1.4f), pt_v3(.1f, 2.1f, .2f), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_s = {25, 25, 25}, .g = .8f, .grid = cloud, .nx = N, .ny = N, .nz = N }));
    pt_add_volume(s, pt_add_box(s, pt_v3(.6f, 0, -.3f), pt_v3(1.5f, 1, .7f), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_a = {1, 1, 1}, .emission = {9, 9, 9}, .density = flame, .density_max = 1, .glow = heat }));
    pt_add_sphere(s, pt_v3(-.45f, .36f, .6f), .35f, skin);
    everything = pt_add_box(s, pt_v3(-4, 0, -2), pt_v3(4, 4, 3), NULL, none);
    pt_add_volume(s, everything, pt_add_medium(s, &(pt_medium_desc){ .sigma_s = {.05f, .05f, .05f}, .g = .4f }));

    pt_scene_commit(s);
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 640, .height = 400, .spp = 40, .max_depth = 256,
        .camera = { .eye = {0, 1.3f, 5.5f}, .target = {0, 1.1f, 0}, .vfov_deg = 34 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "media.png", pt_render_pixels(r), 640, 400,
                                               &(pt_encoding){ .curve = PT_CURVE_FILMIC });
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
