/* The host's own threads do the work: each calls pt_render_work until no tile is left. No thread is started by pt.h, and
   the picture is the same, bit for bit, for any number of them.
   cc -O2 08_own_threads.c -o 08_own_threads -lm -lpthread && ./08_own_threads [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <pthread.h>
#include <stdio.h>

/* What a thread of a game's or an editor's pool would do, between its other jobs. */
static void *worker(void *user) {
    pt_render *r = (pt_render *)user;
    while (pt_render_work(r) == PT_MORE) {}
    return NULL;
}

/* Menger's sponge: of 27 parts of a cube, keep the 20 that touch an edge. */
static void sponge(pt_scene *s, pt_vec3 lo, float size, int depth, pt_material m) {
    if (!depth) { pt_add_box(s, lo, pt_v3(lo.x + size, lo.y + size, lo.z + size), NULL, m); return; }
    for (int i = 0; i < 27; i++) {
        int x = i % 3, y = i / 3 % 3, z = i / 9, middles = (x == 1) + (y == 1) + (z == 1);
        float part = size / 3;
        if (middles < 2)
            sponge(s, pt_v3(lo.x + (float)x * part, lo.y + (float)y * part, lo.z + (float)z * part), part, depth - 1, m);
    }
}

int main(int argc, char **argv) {
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    pt_scene *s = pt_scene_create(NULL);
    pt_material chalk = pt_add_material(s, &(pt_material_desc){ .color = {.80f, .78f, .74f} });
    pt_material table = pt_add_material(s, &(pt_material_desc){ .color = {.30f, .36f, .42f} });
    pt_material warm  = pt_add_material(s, &(pt_material_desc){ .emission = {9, 4.4f, 1.5f} });
    pt_material cold  = pt_add_material(s, &(pt_material_desc){ .emission = {7, 8, 10} });
    sponge(s, pt_v3(-1, -1, -1), 2, 3, chalk);
    pt_add_quad(s, pt_v3(-30, -1, -30), pt_v3(0, 0, 60), pt_v3(60, 0, 0), table);
    pt_add_sphere(s, pt_v3(0, 0, 0), .32f, warm);           /* in the hollow middle */
    pt_add_quad(s, pt_v3(-4, 4, 0), pt_v3(2, 1, 0), pt_v3(0, -1, 2), cold);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.20f, .24f, .30f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 480, .height = 480, .spp = 48, .max_depth = 8,
        .camera = { .eye = {2.6f, 1.9f, 4.3f}, .target = {0, -.15f, 0}, .vfov_deg = 34 } });
    int started = 0;
    while (started < THREADS && pthread_create(&threads[started], NULL, worker, r) == 0) started++;
    worker(r);                                             /* the main thread lends a hand */
    while (started > 0) pthread_join(threads[--started], NULL);

    /* All have come back: the picture is whole, or pt_render_work goes on returning what went wrong. */
    pt_result result = pt_render_work(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "threads.png", pt_render_pixels(r), 480, 480, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
