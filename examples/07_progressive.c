/* Progressive rendering: 1 sample a pixel, then 2, 4, 8 and so on, the picture rewritten after every pass. Ctrl-C stops at
   the next tile; the passes that are finished, and the tiles of the one that is not, are kept and written.
   cc -O2 07_progressive.c -o 07_progressive -lm -lpthread && ./07_progressive [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <signal.h>
#include <stdio.h>

static volatile sig_atomic_t stop;
static void on_interrupt(int sig) { (void)sig; stop = 1; }
static int  should_stop(void *user, double done) { (void)user; (void)done; return stop; }    /* after every tile */

/* A ball with nine smaller balls on it, each with nine still smaller ones: up is the way from the parent's middle. */
static void sphereflake(pt_scene *s, const pt_material *m, pt_vec3 p, pt_vec3 up, float radius, int depth) {
    pt_vec3 a = fabsf(up.y) < .9f ? pt_v3(0, 1, 0) : pt_v3(1, 0, 0);
    pt_vec3 e = pt_v3(a.y * up.z - a.z * up.y, a.z * up.x - a.x * up.z, a.x * up.y - a.y * up.x), f;
    float length = sqrtf(e.x * e.x + e.y * e.y + e.z * e.z);
    e = pt_v3(e.x / length, e.y / length, e.z / length);
    f = pt_v3(up.y * e.z - up.z * e.y, up.z * e.x - up.x * e.z, up.x * e.y - up.y * e.x);
    pt_add_sphere(s, p, radius, m[depth]);
    for (int i = 0; i < 9 && depth; i++) {
        float turn = 1.0471976f * (float)(i < 6 ? i : 2 * (i - 6)) + (i < 6 ? 0 : .5235988f), tilt = i < 6 ? 1.57f : .72f;
        float x = sinf(tilt) * cosf(turn), y = cosf(tilt), z = sinf(tilt) * sinf(turn), far = radius * 1.3333f;
        pt_vec3 d = pt_v3(x*e.x + y*up.x + z*f.x, x*e.y + y*up.y + z*f.y, x*e.z + y*up.z + z*f.z);
        sphereflake(s, m, pt_v3(p.x + far * d.x, p.y + far * d.y, p.z + far * d.z), d, radius / 3, depth - 1);
    }
}

int main(int argc, char **argv) {
    const char *file = argc > 1 ? argv[1] : "progressive.png";
    pt_scene *s = pt_scene_create(NULL);
    const pt_vec3 colors[5] = {{.85f, .80f, .70f}, {.85f, .52f, .15f}, {.70f, .16f, .10f}, {0, 0, 0}, {.10f, .20f, .38f}};
    pt_material m[5];
    for (int i = 0; i < 5; i++)
        m[i] = pt_add_material(s, &(pt_material_desc){ .color = colors[i] });
    m[3] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = {.90f, .88f, .85f} });
    pt_material ground = pt_add_material(s, &(pt_material_desc){ .color = {.25f, .28f, .33f} });
    pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = {12, 11, 9.5f} });
    sphereflake(s, m, pt_v3(0, 0, 0), pt_v3(0, 1, 0), 1, 4);
    pt_add_quad(s, pt_v3(-50, -1, -50), pt_v3(0, 0, 100), pt_v3(100, 0, 0), ground);
    pt_add_sphere(s, pt_v3(-6, 8, 5), 2.2f, lamp);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.30f, .40f, .55f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 512, .height = 384, .spp = 1, .max_depth = 8,
        .camera = { .eye = {1.5f, 3.4f, 5.4f}, .target = {0, .25f, 0}, .vfov_deg = 32 }, .progress = should_stop });
    pt_result result = PT_OK;
    signal(SIGINT, on_interrupt);
    for (int total = 1; result == PT_OK && !stop; total *= 2) {
        result = pt_render_run(r);
        if (result < 0 || pt_write_png(file, pt_render_pixels(r), 512, 384, NULL) != PT_OK) { result = PT_ERR_IO; break; }
        printf("%s: %d samples a pixel%s\n", file, total, result == PT_CANCELLED ? ", the last pass in part" : "");
        fflush(stdout);
        if (total == 32) break;
        if (result == PT_OK) result = pt_render_add_samples(r, total);
    }
    if (result < 0) fprintf(stderr, "%s: %s\n", file, pt_render_error(r)[0] ? pt_render_error(r) : pt_result_string(result));
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result < 0;
}
