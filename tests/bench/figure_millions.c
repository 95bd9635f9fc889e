/* Millions of triangles in a medium (the paper's first figure): a wood by a lake, a misty morning. Terrain, spruces, grass and
   stones are more than a million triangles, and as instances hundreds of millions; sun, sky and lanterns light them through
   two overlapping media, thin haze and mist on a grid. How much memory, how long to build, how long until the picture is clean:
   until the relative error of its pixels, sqrt(relMSE), estimated from its two halves, is below 10 %. OUT/figure_millions.png.
   cc -O2 tests/bench/figure_millions.c -o out/figure_millions -lm -lpthread && out/figure_millions [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "noise.h"
#include "panels.h"
#include "timing.h"
#include "clean.h"

enum { KINDS = 6, SIDE = 640, CELLS_X = 128, CELLS_Y = 16, CELLS_Z = 128 };
static int quick;
static uint32_t state = 20;
static float uniform(float lo, float hi) {
    state = state * 1664525u + 1013904223u;
    return lo + (hi - lo) * (float)(state >> 8) / 16777216;
}

/* ---- memory, counted */

static size_t held, peak;
static void *counted_alloc(void *user, size_t size, size_t align) {
    void *p = NULL;
    (void)user;
    if (posix_memalign(&p, align < sizeof(void *) ? sizeof(void *) : align, size ? size : 1)) return NULL;
    held += size;
    if (held > peak) peak = held;
    return p;
}
static void counted_free(void *user, void *p, size_t size) {
    (void)user;
    if (p) held -= size;
    free(p);
}
static pt_scene *empty_scene(void) {
    return pt_scene_create(&(pt_scene_desc){ .allocator = { counted_alloc, counted_free, NULL }, .threads = 2 });
}
static double unique_triangles, shown_triangles;
static pt_scene *scenes[KINDS + 8];
static int scene_count;
static pt_scene *committed(pt_scene *s) {
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); exit(1); }
    return scenes[scene_count++] = s;
}

/* ---- a mesh that grows */

typedef struct growing { float *p; uint32_t *i, *id; size_t vertices, indices, room; } growing;
static void triangle(growing *g, pt_vec3 a, pt_vec3 b, pt_vec3 c, uint32_t id) {
    pt_vec3 v[3];
    int k;
    if (g->vertices + 3 > g->room) {
        g->room = g->room ? 2 * g->room : 3 << 12;
        g->p = (float *)realloc(g->p, g->room * 3 * sizeof *g->p);
        g->i = (uint32_t *)realloc(g->i, g->room * sizeof *g->i);
        g->id = (uint32_t *)realloc(g->id, g->room / 3 * sizeof *g->id);
    }
    v[0] = a; v[1] = b; v[2] = c;
    g->id[g->indices / 3] = id;
    for (k = 0; k < 3; k++) {
        memcpy(g->p + 3 * g->vertices, v + k, sizeof *v);
        g->i[g->indices++] = (uint32_t)g->vertices++;
    }
}
static size_t add_grown(pt_scene *s, growing *g, const pt_material *m, size_t materials) {
    size_t n = g->indices / 3;
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = g->p, .vertex_count = g->vertices, .indices = g->i, .index_count = g->indices,
        .materials = m, .material_count = materials, .material_ids = g->id });
    free(g->p); free(g->i); free(g->id);
    unique_triangles += (double)n;
    return n;
}
static void tube(growing *g, pt_vec3 a, pt_vec3 b, float ra, float rb, int sides, uint32_t id) {
    pt_vec3 axis = pti_normalize(pti_sub(b, a)), u, v, q[4];
    int k, e;
    pti_basis(axis, &u, &v);
    for (k = 0; k < sides; k++) {
        for (e = 0; e < 2; e++) {
            float turn = 2 * PTI_PI * (float)(k + e) / (float)sides;
            pt_vec3 out = pti_add(pti_scale(u, cosf(turn)), pti_scale(v, sinf(turn)));
            q[e] = pti_madd(out, ra, a);
            q[2 + e] = pti_madd(out, rb, b);
        }
        triangle(g, q[0], q[1], q[3], id);
        triangle(g, q[0], q[3], q[2], id);
    }
}

/* ---- what grows */

typedef struct plant { pt_scene *scene; size_t triangles; } plant;

/* A twig and the needles along it, to all sides and forwards. */
static void twig(growing *g, pt_vec3 from, pt_vec3 way, float length, int needles) {
    pt_vec3 d = pti_normalize(way), u, v;
    int k;
    pti_basis(d, &u, &v);
    for (k = 0; k < needles; k++) {
        float t = length * ((float)k + uniform(0, 1)) / (float)needles, turn = uniform(0, 2 * PTI_PI), size = uniform(.07f, .13f);
        pt_vec3 side = pti_add(pti_scale(u, cosf(turn)), pti_scale(v, sinf(turn))), at = pti_madd(d, t, from);
        pt_vec3 out = pti_normalize(pti_madd(d, .8f, side)), wide = pti_scale(pti_cross(out, d), .013f);
        triangle(g, pti_sub(at, wide), pti_add(at, wide), pti_madd(out, size, at), 1);
    }
}
static void branch(growing *g, pt_vec3 root, float turn, float length, float rise) {
    int k, steps = (int)(length * 7) + 2;
    float droop = uniform(.1f, .22f) * length;
    pt_vec3 before = root;
    for (k = 1; k <= steps; k++) {
        float t = (float)k / (float)steps, out = length * t, side = .55f * length * (1 - t) + .2f;
        pt_vec3 at = pti_add(root, pt_v3(out * cosf(turn), rise * out - droop * t * t * (1.6f - t), out * sinf(turn)));
        pt_vec3 along = pti_normalize(pti_sub(at, before));
        pt_vec3 across = pt_v3(-sinf(turn), -.25f, cosf(turn)), other = pt_v3(sinf(turn), -.25f, -cosf(turn));
        int needles = 4 + (int)(side * (quick ? 9 : 22));
        tube(g, before, at, .03f * (1 - t) + .012f, .03f * (1 - t) + .008f, 3, 0);
        twig(g, at, pti_madd(across, uniform(.8f, 1.3f), along), side, needles);
        twig(g, at, pti_madd(other, uniform(.8f, 1.3f), along), side, needles);
        twig(g, before, along, length / (float)steps, 6);
        before = at;
    }
}
static plant spruce(float height) {
    pt_scene *s = empty_scene();
    pt_material m[2];
    growing g = { 0 };
    plant p;
    float y, reach = height * uniform(.17f, .22f);
    m[0] = pt_add_material(s, &(pt_material_desc){ .color = { .11f, .075f, .05f } });
    m[1] = pt_add_material(s, &(pt_material_desc){ .color = { uniform(.05f, .09f), uniform(.11f, .15f), .045f },
        .translucency = .35f });
    for (y = 0; y < height; y += .5f)
        tube(&g, pt_v3(0, y - .3f, 0), pt_v3(0, y + .2f, 0), .016f * (height - y) + .01f, .016f * (height - y) + .003f, 9, 0);
    for (y = .09f * height; y < .985f * height; y += .42f * (1 - .5f * y / height)) {
        float t = y / height, turn = uniform(0, 7);
        int k, n = 5 + (int)(3 * (1 - t));
        for (k = 0; k < n; k++)
            branch(&g, pt_v3(0, y + uniform(-.1f, .1f), 0), turn + 2 * PTI_PI * ((float)k + uniform(-.2f, .2f)) / (float)n,
                   reach * powf(1 - t, .8f) * uniform(.7f, 1.1f) + .12f, .75f * t - .25f + uniform(-.1f, .1f));
    }
    p.triangles = add_grown(s, &g, m, 2);
    p.scene = committed(s);
    return p;
}
static plant tuft(float height, float spread, int blades, pt_vec3 color) {      /* grass, reed */
    pt_scene *s = empty_scene();
    pt_material m = pt_add_material(s, &(pt_material_desc){ .color = color, .translucency = .4f });
    growing g = { 0 };
    plant p;
    int i, k;
    for (i = 0; i < blades; i++) {
        float turn = uniform(0, 2 * PTI_PI), r = spread * sqrtf(uniform(0, 1)), away = uniform(0, 2 * PTI_PI),
            h = height * uniform(.5f, 1);
        float bend = uniform(.1f, .5f) * h;
        pt_vec3 root = pt_v3(r * cosf(turn), 0, r * sinf(turn)), wide = pt_v3(-.006f * sinf(away), 0, .006f * cosf(away)), a[2],
            b[2];
        a[0] = pti_sub(root, wide); a[1] = pti_add(root, wide);
        for (k = 1; k <= 4; k++) {
            float t = (float)k / 4;
            pt_vec3 at = pti_add(root, pt_v3(bend * t * t * cosf(away), h * t * (1 - .2f * t), bend * t * t * sinf(away)));
            b[0] = pti_madd(wide, t - 1, at); b[1] = pti_madd(wide, 1 - t, at);
            triangle(&g, a[0], a[1], b[1], 0);
            if (k < 4) triangle(&g, a[0], b[1], b[0], 0);
            a[0] = b[0]; a[1] = b[1];
        }
    }
    p.triangles = add_grown(s, &g, &m, 1);
    p.scene = committed(s);
    return p;
}
static pt_vec3 lump(float u, float v, float seed) {      /* a point of a stone */
    float a = 2 * PTI_PI * u, b = PTI_PI * v;
    pt_vec3 d = pt_v3(sinf(b) * cosf(a), .7f * cosf(b), sinf(b) * sinf(a));
    return pti_scale(d, 1 + 1.1f * noise_sum(1.6f * d.x + seed, 1.6f * d.y, 1.6f * d.z, 6));
}
static plant stone(float seed) {
    enum { N = 64 };
    pt_scene *s = empty_scene();
    pt_material m = pt_add_material(s, &(pt_material_desc){ .color = { .19f, .18f, .165f }, .roughness = .5f });
    growing g = { 0 };
    plant p;
    int i, k;
    for (i = 0; i < N; i++) for (k = 0; k < N; k++) {
        float u = (float)i / N, v = (float)k / N, d = 1.0f / N;
        pt_vec3 a = lump(u, v, seed), b = lump(u + d, v, seed), c = lump(u, v + d, seed), e = lump(u + d, v + d, seed);
        if (k > 0) triangle(&g, a, b, c, 0);
        if (k < N - 1) triangle(&g, b, e, c, 0);
    }
    p.triangles = add_grown(s, &g, &m, 1);
    p.scene = committed(s);
    return p;
}

/* ---- the land: a lake at height 0, its bank near by, hills behind it; +z is towards the eye */

static float height_at(float x, float z) {
    float shore = -58 + 26 * noise_sum(.021f * x + 3, 0, .5f, 3) + .0016f * x * x, far = shore - z,
        near = z + 9 + 7 * noise_sum(.09f * x + 50, 0, 0, 3);
    float land = far > 0 ? .55f * sqrtf(far) + .00035f * far * far : .09f * far;
    float bank = near > 0 ? .16f * near : .12f * near;
    float side = .12f * (fabsf(x) - 62 - 20 * noise_sum(.03f * z, 2, 0, 3));
    float h = pti_max(pti_max(land, bank), side);
    h = pti_max(h, 1.5f - .16f * sqrtf((x + 15) * (x + 15) * .5f + (z + 27) * (z + 27)));     /* a spit, trees on it */
    h += h > 0 ? pti_min(h, 6) * .9f * noise_sum(.05f * x, 7, .05f * z, 5) : 0;
    return pti_max(h, -2);
}
static void add_land(pt_scene *s) {
    int n = quick ? SIDE / 4 : SIDE, x, z, k;
    size_t vertices = (size_t)(n + 1) * (size_t)(n + 1), at = 0;
    float *p = (float *)malloc(vertices * 3 * sizeof *p);
    uint32_t *i = (uint32_t *)malloc((size_t)n * (size_t)n * 6 * sizeof *i);
    pt_texture moss = pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_FBM, .solid = 1, .frequency = .35f, .octaves = 8,
        .color_a = { .035f, .055f, .02f }, .color_b = { .17f, .13f, .075f } });
    for (z = 0; z <= n; z++) for (x = 0; x <= n; x++, at += 3) {
        float u = 2 * (float)x / (float)n - 1, v = (float)z / (float)n;
        p[at] = 320 * u * (.35f + .65f * fabsf(u));      /* finer in the middle and near by */
        p[at + 2] = 14 - 434 * v * (.12f + .88f * v);
        p[at + 1] = height_at(p[at], p[at + 2]);
    }
    for (z = 0, at = 0; z < n; z++) for (x = 0; x < n; x++, at += 6) {
        uint32_t a = (uint32_t)(z * (n + 1) + x), b = a + (uint32_t)n + 1, quad[6];
        quad[0] = a; quad[1] = a + 1; quad[2] = b + 1; quad[3] = a; quad[4] = b + 1; quad[5] = b;
        for (k = 0; k < 6; k++) i[at + (size_t)k] = quad[k];
    }
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = p, .vertex_count = vertices, .indices = i, .index_count = at,
        .material = pt_add_material(s, &(pt_material_desc){ .color_texture = moss }) });
    unique_triangles += (double)at / 3;
    shown_triangles += (double)at / 3;
    free(p); free(i);
}
static void place(pt_scene *s, const plant *p, float x, float z, float size, float sink, float lean) {
    float a = uniform(0, 2 * PTI_PI), c = size * cosf(a), n = size * sinf(a), up = size * uniform(.9f, 1.1f),
        l = uniform(-lean, lean);
    pt_xform m = { { c, l * up, n, x,   0, up, 0, height_at(x, z) - sink * size,   -n, l * up, c, z } };
    pt_add_instance(s, p->scene, &m);
    shown_triangles += (double)p->triangles;
}
static float mist[CELLS_X * CELLS_Y * CELLS_Z];
static void grow_mist(void) {                            /* lies on the water, in wisps */
    int i;
    for (i = 0; i < CELLS_X * CELLS_Y * CELLS_Z; i++) {
        float x = (float)(i % CELLS_X) / CELLS_X, y = ((float)(i / CELLS_X % CELLS_Y) + .5f) / CELLS_Y,
            z = (float)(i / CELLS_X / CELLS_Y) / CELLS_Z;
        float d = expf(-5 * y) * (.55f + 2.2f * noise_sum(9 * x, 3 * y, 7 * z, 4));
        mist[i] = pti_clamp(d - .02f, 0, 1);
    }
}
static pt_scene *wood(void) {
    pt_scene *s = empty_scene();
    pt_material none = { 0 }, wood_ = pt_add_material(s, &(pt_material_desc){ .color = { .13f, .09f, .06f } });
    pt_material water = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { .004f, .007f, .006f },
        .ior = 1.33f });
    plant trees[KINDS], grass[3], stones[3];
    pt_light_desc lantern = { .kind = PT_LIGHT_POINT, .radius = .14f, .color = { 110, 58, 18 } };
    int i, k;
    for (i = 0; i < KINDS; i++) trees[i] = spruce(11 + 2.2f * (float)i);
    for (i = 0; i < 3; i++) {
        grass[i] = i < 2 ? tuft(.32f, .55f, quick ? 300 : 2000, pt_v3(.13f, .15f, .04f))
                         : tuft(1.7f, .5f, 90, pt_v3(.20f, .17f, .07f));      /* reed */
        stones[i] = stone(10 * (float)i);
    }
    add_land(s);
    pt_add_quad(s, pt_v3(-330, 0, 30), pt_v3(660, 0, 0), pt_v3(0, 0, -460), water);
    for (i = 0; i < 3600; i++) {                         /* the wood: denser away from the water */
        float x = uniform(-230, 230), z = uniform(-300, -20), h = height_at(x, z);
        if (h > .9f && noise_sum(.03f * x, 1, .03f * z, 3) > -.02f - .015f * h)
            place(s, trees + (int)uniform(0, KINDS), x, z, uniform(.55f, 1.15f), .2f, .03f);
    }
    for (i = 0; i < 5; i++) {                             /* a few before the sun, so that it comes in shafts */
        float x = -22 + 2.9f * (float)i, z = -25 - 2.1f * (float)(i * 2 % 5);
        place(s, trees + (i + 1) % KINDS, x, z, uniform(.6f, .85f), .2f, .03f);
    }
    for (i = 0; i < 6000; i++) {
        float x = uniform(-14, 14), z = uniform(-12, 4), h = height_at(x, z);
        if (h > .02f) place(s, grass + (i & 1), x, z, uniform(.5f, 1.2f), .02f, .1f);
    }
    for (i = 0; i < 9000; i++) {                         /* reeds stand in shallow water */
        float x = uniform(-70, 70), z = uniform(-75, -4), h = height_at(x, z);
        if (h > -.25f && h < .25f && noise_sum(.1f * x, 4, .1f * z, 2) > .02f)
            place(s, grass + 2, x, z, uniform(.6f, 1.2f), .1f, .1f);
    }
    for (i = 0; i < 900; i++) {
        float x = uniform(-60, 60), z = uniform(-75, 2), h = height_at(x, z);
        if (h > -.4f && h < 1.2f) place(s, stones + i % 3, x, z, .12f + 1.1f * powf(uniform(0, 1), 6), -.05f, .2f);
    }
    for (i = 0; i < 5; i++) {                            /* a jetty, and lanterns along it */
        float z = -13 - 4.5f * (float)i, x = 3.4f + .25f * (float)i;
        for (k = 0; k < 12; k++) {
            float plank = z + .375f * (float)k;
            pt_add_box(s, pt_v3(x - .8f, .42f, plank), pt_v3(x + .8f, .48f, plank + .34f), NULL, wood_);
        }
        pt_add_box(s, pt_v3(x - .72f, -2, z + .1f), pt_v3(x - .58f, .6f, z + .24f), NULL, wood_);
        pt_add_box(s, pt_v3(x + .58f, -2, z + .1f), pt_v3(x + .72f, 1.9f, z + .24f), NULL, wood_);
        lantern.position = pt_v3(x + .65f, 2.06f, z + .17f);
        pt_add_light(s, &lantern);
    }
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = { .40f, -.34f, .85f }, .color = { .022f, .022f, .022f },
        .turbidity = 3 });
    grow_mist();
    pt_add_volume(s, pt_add_box(s, pt_v3(-340, -3, -440), pt_v3(340, 70, 40), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_s = { .0018f, .0019f, .0021f }, .g = .6f }));
    pt_add_volume(s, pt_add_box(s, pt_v3(-120, 0, -150), pt_v3(120, 11, 0), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_s = { .03f, .03f, .03f }, .g = .7f, .grid = mist, .nx = CELLS_X, .ny = CELLS_Y, .nz = CELLS_Z }));
    return committed(s);
}

int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "millions of triangles in a medium");
    double start = now(), cpu = processor_seconds();
    pt_render_desc d = { .width = 640, .height = 400, .threads = 2, .max_depth = 32,
        .camera = { .eye = { -1.5f, 2.6f, 0 }, .target = { -2, 4.6f, -40 }, .vfov_deg = 36 } };
    float *picture;
    pt_scene *s;
    quick = set.quick;
    s = wood();
    printf("%.2f million triangles, %.0f million with instances\n", unique_triangles / 1e6, shown_triangles / 1e6);
    printf("%.1f MB held (%.1f at most while building), made and built in %.2f s (%.2f of the processor)\n", (double)held / 1e6,
           (double)peak / 1e6, now() - start, processor_seconds() - cpu);
    if (quick) { d.width = 240; d.height = 150; }
    picture = until_clean(s, d, .1, quick ? 16 : 2048);
    write_panels(&set, "figure_millions", &picture, 1, 1, d.width, d.height, -.35f);
    free(picture);
    while (scene_count) pt_scene_destroy(scenes[--scene_count]);
    if (held) printf("%.0f bytes were never freed\n", (double)held);
    return 0;
}
