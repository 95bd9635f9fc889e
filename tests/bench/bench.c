/* How fast is it? Seconds are the median of three. What is missing is skipped.
   cc -O2 tests/bench/bench.c -o out/bench -lm -lpthread && out/bench        (make bench does this) */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "timing.h"

enum { SIZE = 512, SPP = 64, DEPTH = 8, THREADS = 2, RUNS = 3 };

static void time_render(const char *name, const pt_scene *s, pt_camera camera, const char *picture) {
    double seconds[RUNS];
    pt_stats stats = { 0 };
    int i;
    for (i = 0; i < RUNS; i++) {
        pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = SIZE, .height = SIZE, .spp = SPP, .max_depth = DEPTH,
            .threads = THREADS, .camera = camera });
        double start = now();
        if (pt_render_run(r) != PT_OK) { printf("%s: %s\n", name, pt_render_error(r)); pt_render_destroy(r); return; }
        seconds[i] = now() - start;
        stats = pt_render_stats(r);
        if (i == 0) pt_write_ppm(picture, pt_render_pixels(r), SIZE, SIZE, NULL);
        pt_render_destroy(r);
    }
    printf("%-34s %7.2f s %8.2f M rays/s %7.2f M paths/s   %.1f rays a path\n", name, median(seconds, RUNS),
           (double)stats.rays / seconds[RUNS / 2] * 1e-6, (double)stats.paths / seconds[RUNS / 2] * 1e-6,
           (double)stats.rays / (double)stats.paths);
    fflush(stdout);
}

static void bench_cornell(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material white = pt_add_material(s, &(pt_material_desc){ .color = {.73f, .73f, .73f} });
    pt_material red   = pt_add_material(s, &(pt_material_desc){ .color = {.65f, .05f, .05f} });
    pt_material green = pt_add_material(s, &(pt_material_desc){ .color = {.12f, .45f, .15f} });
    pt_material lamp  = pt_add_material(s, &(pt_material_desc){ .emission = {15, 15, 15} });
    pt_camera camera  = { .eye = {.5f, .5f, -1.4f}, .target = {.5f, .5f, 0} };
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,0,1), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(0,1,0), pt_v3(1,0,0), pt_v3(0,0,1), white);
    pt_add_quad(s, pt_v3(0,0,1), pt_v3(0,1,0), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(1,0,0), pt_v3(0,0,1), pt_v3(0,1,0), red);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,1,0), pt_v3(0,0,1), green);
    pt_add_quad(s, pt_v3(.35f,.999f,.35f), pt_v3(.3f,0,0), pt_v3(0,0,.3f), lamp);
    pt_add_box(s, pt_v3(.15f,0,.15f), pt_v3(.45f,.30f,.45f), NULL, white);
    pt_add_box(s, pt_v3(.55f,0,.50f), pt_v3(.85f,.60f,.80f), NULL, white);
    if (pt_scene_commit(s) == PT_OK) time_render("Cornell box", s, camera, "out/bench_cornell.ppm");
    else printf("Cornell box: %s\n", pt_scene_error(s));
    pt_scene_destroy(s);
}

static double file_megabytes(const char *path) {
    FILE *f = fopen(path, "rb");
    long size = -1;
    if (f && fseek(f, 0, SEEK_END) == 0) size = ftell(f);
    if (f) fclose(f);
    return (double)size * 1e-6;
}
/* The mesh alone, or (with a map) on a ground quad under it. */
static pt_scene *mesh_scene(const pt_mesh *mesh, const pt_image *map) {
    float size = mesh->hi.x - mesh->lo.x, x = mesh->lo.x - 5 * size, z = mesh->lo.z - 5 * size;
    pt_scene *s = pt_scene_create(NULL);
    pt_material grey = pt_add_material(s, &(pt_material_desc){ .color = {.6f, .6f, .6f} });
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = mesh->positions, .vertex_count = mesh->vertex_count, .indices = mesh->indices,
        .index_count = mesh->index_count, .normals = mesh->normals, .material = grey, .borrow = 1 });
    if (map) {
        pt_add_quad(s, pt_v3(x, mesh->lo.y, z), pt_v3(0, 0, 11 * size), pt_v3(11 * size, 0, 0), grey);
        pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .texture = pt_add_texture(s, &(pt_texture_desc){
            .width = map->width, .height = map->height, .channels = map->channels, .bits = 32, .pixels = map->pixels }) });
    }
    return s;
}
static void bench_mesh(const char *name, const char *obj, const char *hdr, const char *picture) {
    double reads[RUNS], builds[RUNS], start, megabytes = file_megabytes(obj);
    pt_mesh mesh = { 0 };
    pt_image map = { 0 };
    pt_scene *s;
    pt_camera camera = { 0 };
    float size;
    int i;
    if (megabytes < 0 || file_megabytes(hdr) < 0) { printf("%-34s skipped: %s is not here\n", name, megabytes < 0 ? obj : hdr); return; }
    for (i = 0; i < RUNS; i++) {
        pt_mesh_free(&mesh);
        memset(&mesh, 0, sizeof mesh);
        start = now();
        if (pt_read_obj(&mesh, obj) != PT_OK) { printf("%s: %s\n", name, mesh.error); return; }
        reads[i] = now() - start;
    }
    if (pt_read_image(&map, hdr) != PT_OK) { printf("%s: %s\n", name, map.error); return; }
    for (i = 0; i < RUNS; i++) {
        start = now();
        s = mesh_scene(&mesh, NULL);
        if (pt_scene_commit(s) != PT_OK) { printf("%s: %s\n", name, pt_scene_error(s)); return; }
        builds[i] = now() - start;
        pt_scene_destroy(s);
    }
    size = mesh.hi.x - mesh.lo.x;
    camera.target = pt_v3((mesh.lo.x + mesh.hi.x) / 2, (mesh.lo.y + mesh.hi.y) / 2, (mesh.lo.z + mesh.hi.z) / 2);
    camera.eye = pt_v3(camera.target.x, camera.target.y + .5f * size, camera.target.z + 2.2f * size);
    s = mesh_scene(&mesh, &map);
    if (pt_scene_commit(s) == PT_OK) time_render(name, s, camera, picture);
    else printf("%s: %s\n", name, pt_scene_error(s));
    printf("%-34s %7.3f s %8.1f MB/s\n", "  OBJ reading", median(reads, RUNS), megabytes / reads[RUNS / 2]);
    printf("%-34s %7.3f s %8.0f ns a triangle, one thread (%lu triangles)\n", "  tree building", median(builds, RUNS),
           builds[RUNS / 2] / (double)(mesh.index_count / 3) * 1e9, (unsigned long)(mesh.index_count / 3));
    pt_scene_destroy(s);
    pt_mesh_free(&mesh);
    pt_image_free(&map);
}

int main(void) {
    printf("%d x %d pixels, %d samples a pixel, depth %d, %d threads, median of %d\n", SIZE, SIZE, SPP, DEPTH, THREADS, RUNS);
    bench_cornell();
    bench_mesh("bunny, sunset, ground", "../shared/data/meshes/stanford-bunny.obj", "../shared/data/env/sunset.hdr", "out/bench_bunny.ppm");
    bench_mesh("knot, sky, ground", "out/knot.obj", "out/sky.hdr", "out/bench_knot.ppm");
    return 0;
}
