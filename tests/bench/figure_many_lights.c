/* Many lights: a city at night under 1, 100, 10 000 and 1 000 000 emissive triangles, their total power the same. Some are
   locked into houses, some face a wall. How a path chooses among them: all alike, by power, by the light tree.
   cc -O2 tests/bench/figure_many_lights.c -o out/figure_many_lights -lm -lpthread && out/figure_many_lights [--quick]
   relMSE = mean((x - r)^2 / (r^2 + 0.01)) over pixels and channels, against 100 times the samples, by the tree, with another
   seed. Times are the processor's. Pictures go to out/many_lights_*.png. */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"

enum { COLORS = 6, LEVELS = 8, HOUSES = 13 };
#define BLOCK 9.0f                                       /* metres from house to house */

typedef struct settings { int width, height, spp, reference, picture; } settings;

/* ---- the city */

static float house_height(int i, int k) {
    pt_rng rng;
    float near_middle;
    pt_rng_seed(&rng, (uint64_t)(i * HOUSES + k), 3);
    near_middle = 1 - 0.14f * (float)(abs(i - HOUSES / 2) + abs(k - HOUSES / 2));
    return 1.5f + (near_middle > 0 ? near_middle : 0) * 8 + 4 * pt_rng_float(&rng) * pt_rng_float(&rng);
}
static float house_middle(int i) { return ((float)i - HOUSES / 2) * BLOCK; }

static void triangle(float *out, pt_vec3 c, pt_vec3 n, float size, float turn) {
    pt_vec3 t = { n.y, n.z, n.x }, b;
    float along = t.x * n.x + t.y * n.y + t.z * n.z, length;
    int k;
    t = pt_v3(t.x - along * n.x, t.y - along * n.y, t.z - along * n.z);
    length = sqrtf(t.x * t.x + t.y * t.y + t.z * t.z);
    t = pt_v3(t.x / length, t.y / length, t.z / length);
    b = pt_v3(n.y * t.z - n.z * t.y, n.z * t.x - n.x * t.z, n.x * t.y - n.y * t.x);
    for (k = 0; k < 3; k++) {
        float a = turn + (float)k * 2.0943951f, x = size * cosf(a), y = size * sinf(a);
        out[3 * k] = c.x + x * t.x + y * b.x;
        out[3 * k + 1] = c.y + x * t.y + y * b.y;
        out[3 * k + 2] = c.z + x * t.z + y * b.z;
    }
}
static pt_vec3 unit(float x, float y, float z) {
    float l = sqrtf(x * x + y * y + z * z);
    return pt_v3(x / l, y / l, z / l);
}
/* Most hang over the streets and shine down, more or less; some face a wall from a hand's breadth; some are inside. */
static void place(pt_rng *rng, pt_vec3 *p, pt_vec3 *n) {
    int i = (int)(HOUSES * pt_rng_float(rng)), k = (int)(HOUSES * pt_rng_float(rng));
    float x = house_middle(i), z = house_middle(k), h = house_height(i, k), along = BLOCK * (pt_rng_float(rng) - 0.5f);
    float kind = pt_rng_float(rng), side = pt_rng_float(rng) < 0.5f ? -1.0f : 1.0f, off, height = pt_rng_float(rng);
    int turned = pt_rng_float(rng) < 0.5f;
    if (kind < 0.6f) {                                   /* over a street */
        off = side * (BLOCK / 2 - 1.2f * pt_rng_float(rng));
        *p = turned ? pt_v3(x + along, 1 + 2.5f * height, z + off) : pt_v3(x + off, 1 + 2.5f * height, z + along);
        *n = unit(0.5f * (pt_rng_float(rng) - 0.5f), -1, 0.5f * (pt_rng_float(rng) - 0.5f));
    } else if (kind < 0.9f) {                            /* before a wall, 5 m wide, well below the roof */
        off = side * (2.5f + 0.3f);
        along *= 5 / BLOCK;
        *p = turned ? pt_v3(x + along, 0.3f + (h - 1.2f) * height, z + off) : pt_v3(x + off, 0.3f + (h - 1.2f) * height, z + along);
        *n = turned ? unit(0, -0.8f, -side) : unit(-side, -0.8f, 0);
    } else {                                             /* inside */
        *p = pt_v3(x + 4 * (pt_rng_float(rng) - 0.5f), h * (0.1f + 0.8f * height), z + 0.5f * along);
        *n = unit(pt_rng_float(rng) - 0.5f, pt_rng_float(rng) - 0.5f, pt_rng_float(rng) + 0.1f);
    }
}
static void add_lamps(pt_scene *s, size_t count) {
    static const float colors[COLORS][3] = { { 1, .55f, .2f }, { 1, .8f, .5f }, { .5f, .75f, 1 }, { 1, .2f, .35f }, { .2f, 1, .7f }, { .6f, .3f, 1 } };
    pt_material lamp[COLORS * LEVELS];
    float *v = (float *)malloc(count * 9 * sizeof *v), size = count > 1 ? 9 / sqrtf((float)count) : 4.0f, level = 1;
    uint32_t *ids = (uint32_t *)malloc(count * sizeof *ids);
    pt_rng rng;
    size_t i;
    int k, c;
    if (!v || !ids) { free(v); free(ids); return; }
    for (k = 0; k < LEVELS; k++, level *= 2) for (c = 0; c < COLORS; c++)
        lamp[k * COLORS + c] = pt_add_material(s, &(pt_material_desc){ .emission = { 30 * level * colors[c][0], 30 * level * colors[c][1], 30 * level * colors[c][2] } });
    pt_rng_seed(&rng, 5, 5);
    for (i = 0; i < count; i++) {
        pt_vec3 p = { 0, 4, 4 }, n = { 0, -1, 0 };
        float turn = 6.2831853f * pt_rng_float(&rng), scale = 0.3f + 1.4f * pt_rng_float(&rng), bright = pt_rng_float(&rng);
        if (count > 1) place(&rng, &p, &n); else { scale = 1; bright = 0.9f; }
        triangle(v + 9 * i, p, n, size * scale, turn);
        ids[i] = (uint32_t)(LEVELS * bright * bright * bright) * COLORS + (count > 1 ? (uint32_t)(COLORS * pt_rng_float(&rng) * pt_rng_float(&rng)) : 1);
    }
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = v, .vertex_count = 3 * count, .materials = lamp, .material_count = COLORS * LEVELS, .material_ids = ids });
    free(v); free(ids);
}
static pt_scene *city(size_t lamps, pt_light_choice choose) {
    pt_scene *s = pt_scene_create(&(pt_scene_desc){ .choose = choose });
    pt_material ground = pt_add_material(s, &(pt_material_desc){ .color = {.35f, .35f, .38f} });
    pt_material wall[2];
    int i, k;
    wall[0] = pt_add_material(s, &(pt_material_desc){ .color = {.6f, .57f, .52f} });
    wall[1] = pt_add_material(s, &(pt_material_desc){ .color = {.45f, .48f, .55f} });
    pt_add_quad(s, pt_v3(-200, 0, -200), pt_v3(0, 0, 400), pt_v3(400, 0, 0), ground);
    for (i = 0; i < HOUSES; i++) for (k = 0; k < HOUSES; k++) {
        float x = house_middle(i), z = house_middle(k);
        pt_add_box(s, pt_v3(x - 2.5f, -0.1f, z - 2.5f), pt_v3(x + 2.5f, house_height(i, k), z + 2.5f), NULL, wall[(i * 7 + k * 3) % 5 < 2]);
    }
    add_lamps(s, lamps);
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); exit(1); }
    return s;
}

/* ---- measuring */

typedef struct run { double time; pt_stats stats; float *rgb; } run;
static run render(const pt_scene *s, int width, int height, int spp, uint64_t seed) {
    pt_render_desc d = { .width = width, .height = height, .spp = spp, .max_depth = 2, .seed = seed,
        .camera = { .eye = {-14, 34, 44}, .target = {1, 0, 2}, .vfov_deg = 40 } };
    run out = { 0, { 0, 0, 0, 0 }, NULL };
    out.rgb = render_copy(s, &d, &out.stats, &out.time);
    if (!out.rgb) exit(1);
    return out;
}
static void compare(size_t lamps, const settings *q) {
    static const char *const names[] = { "tree", "power", "uniform" };
    size_t n = (size_t)q->width * (size_t)q->height * 3;
    double start = processor_seconds(), cost[3], build;
    pt_scene *s = city(lamps, PT_CHOOSE_TREE);
    run truth, it;
    char path[64];
    int k;
    build = processor_seconds() - start;
    truth = render(s, q->width, q->height, q->reference, 99);
    if (q->picture) {
        it = render(s, 6 * q->width, 6 * q->height, q->picture, 1);
        snprintf(path, sizeof path, "out/many_lights_%lu.png", (unsigned long)lamps);
        pt_write_png(path, it.rgb, 6 * q->width, 6 * q->height, &(pt_encoding){ .curve = PT_CURVE_FILMIC, .exposure_stops = -1.5f });
        free(it.rgb);
    }
    pt_scene_destroy(s);
    printf("%8lu lamps, %.2f s to build\n", (unsigned long)lamps, build);
    for (k = 2; k >= 0; k--) {
        double error;
        s = city(lamps, (pt_light_choice)k);
        it = render(s, q->width, q->height, q->spp, 1);
        pt_scene_destroy(s);
        error = relative_error(it.rgb, truth.rgb, n);
        cost[k] = error * it.time;
        printf("    %-8s %7.1f ns a ray   relMSE %10.5f   relMSE x s %10.5f   efficiency %7.1f times uniform's\n", names[k],
               it.time / (double)it.stats.rays * 1e9, error, cost[k], cost[2] / cost[k]);
        fflush(stdout);
        snprintf(path, sizeof path, "out/many_lights_%lu_%s.png", (unsigned long)lamps, names[k]);
        pt_write_png(path, it.rgb, q->width, q->height, &(pt_encoding){ .curve = PT_CURVE_FILMIC, .exposure_stops = -1.5f });
        free(it.rgb);
    }
    free(truth.rgb);
}

/* ---- what the tree itself costs: to build, to draw from, and to ask for a density, from random places in random directions */

static pt_scene *crowd(size_t count, int wall) {         /* in the unit cube, turned every which way, or on its side z = 0 */
    pt_scene *s = pt_scene_create(NULL);
    pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = { 1, 1, 1 } });
    float *v = (float *)malloc(count * 9 * sizeof *v), size = 0.5f / sqrtf((float)count);
    pt_rng rng;
    size_t i;
    if (!v) exit(1);
    pt_rng_seed(&rng, 6, 6);
    for (i = 0; i < count; i++) {
        float x = pt_rng_float(&rng), y = pt_rng_float(&rng), z = pt_rng_float(&rng), a = pt_rng_float(&rng), b = pt_rng_float(&rng), turn = 6.2831853f * pt_rng_float(&rng);
        triangle(v + 9 * i, pt_v3(x, y, wall ? 0 : z), wall ? pt_v3(0, 0, 1) : unit(a - 0.5f, b - 0.5f, pt_rng_float(&rng) - 0.51f), size, turn);
    }
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = v, .vertex_count = 3 * count, .material = lamp });
    free(v);
    return s;
}
static void walks(size_t most) {
    size_t count, i, n = 100000;
    int wall;
    printf("\nthe tree itself: ns an evaluation, directions and places at random\n"
           "                    in a cube, every which way            on a wall\n"
           "        lamps    density    draw    build/lamp       density    draw    build/lamp   bytes/lamp\n");
    for (count = 1; count <= most; count *= 10) {
        printf("   %10lu", (unsigned long)count);
        for (wall = 0; wall < 2; wall++) {
            pt_scene *s = crowd(count, wall);
            pti_lights *l = &s->lights;
            pt_rng rng;
            double start, spent[3];
            float sum = 0;
            int pass;
            if (pt_scene_commit(s) != PT_OK) exit(1);
            for (pass = 0; pass < 2; pass++) {
                pt_rng_seed(&rng, 9, 9);
                start = processor_seconds();
                for (i = 0; i < n; i++) {
                    pti_receiver r;
                    pti_drawn drawn;
                    pt_vec3 wi, other;
                    uint32_t choice = pt_rng_u32(&rng);
                    float u = pt_rng_float(&rng), v = pt_rng_float(&rng);
                    wi = pti_sample_sphere(u, v);
                    r.p = pt_v3(pt_rng_float(&rng), pt_rng_float(&rng), pt_rng_float(&rng));
                    r.n = pti_sample_sphere(v, u);
                    if (pti_dot(r.n, wi) < 0) r.n = pti_neg(r.n);
                    if (pass) sum += (float)pti_lights_sample(l, &r, choice, u, v, &other, &drawn);
                    else sum += pti_lights_pdf(l, &r, wi, NULL);
                }
                spent[pass] = (processor_seconds() - start) / (double)n;
            }
            i = l->node_capacity;
            pti_free(&s->allocator, l->nodes, l->node_capacity, sizeof *l->nodes);
            l->nodes = NULL;
            start = processor_seconds();
            if (!pti_lights_build(l, &s->allocator)) exit(1);
            spent[2] = (processor_seconds() - start) / (double)count;
            printf("   %8.0f %8.0f %10.0f   ", spent[0] * 1e9, spent[1] * 1e9, count < 1000 ? 0 : spent[2] * 1e9);
            if (wall) printf("%9.0f", (double)(i * sizeof *l->nodes + count * sizeof *l->emitters) / (double)count);
            if (sum < 0) printf("?");
            pt_scene_destroy(s);
        }
        printf("\n");
        fflush(stdout);
    }
}
int main(int argc, char **argv) {
    static const size_t counts[] = { 1, 100, 10000, 1000000 };
    int quick = argc > 1 && !strcmp(argv[1], "--quick"), i;
    settings q = { 96, 54, 16, 1600, 32 };
    if (quick) { q.width = 64; q.height = 36; q.spp = 4; q.reference = 400; q.picture = 0; }
    printf("%d x %d pixels, %d samples a pixel, reference %d, direct light and one bounce; processor time\n", q.width, q.height, q.spp, q.reference);
    for (i = 0; i < (quick ? 3 : 4); i++) compare(counts[i], &q);
    walks(quick ? 10000 : 1000000);
    return 0;
}
