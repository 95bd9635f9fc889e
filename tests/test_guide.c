/* >>guide: the density against what it draws; that it changes no mean, no bit by threads; and that it finds the gap. */
#define PTI_GUIDE_WORTH 0.0f                             /* always; when it steps aside: see test_mixture.c */
#define PTI_GUIDE_PATHS 1
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "agreement.h"

/* A closed box, in whose other half, behind a wall with a gap, a lamp shines at the ceiling. */
static float edge = 1.8f;                                /* of the wall, where 2 closes the gap */
static pt_scene *gap(pt_scene *s, pt_render_desc *d) {
    pt_material wall = diffuse(s, 0.7f);
    pt_add_box(s, pt_v3(-2, 0, -1), pt_v3(2, 2, 1), NULL, wall);
    quad(s, 0, 0, -1, 0, 2, 0, 0, 0, edge, wall);
    quad(s, 1, 1, -0.2f, 0, 0, 0.4f, 0.4f, 0, 0, lamp(s, 40, 0));
    quad(s, -1.9f, 0.02f, 0.95f, 3.8f, 0, 0, 0, 0, -1.9f, all_round(s));
    pt_add_sphere(s, pt_v3(-1, 0.4f, -0.3f), 0.4f, coat(s));
    pt_add_sphere(s, pt_v3(-0.6f, 0.3f, 0.5f), 0.3f, glass(s, 1.5f));
    d->camera.eye = pt_v3(-1.9f, 1, 0.2f); d->camera.target = pt_v3(0, 0.8f, 0); d->camera.vfov_deg = 70;
    return NULL;
}
static pt_render *guided_render(pt_scene *s, pt_render_desc *d, int size, int spp, int guide) {
    pt_render *r;
    *d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, size, spp);
    gap(s, d);
    d->guide = guide;
    if (!commit(s)) return NULL;
    r = pt_render_create(s, d);
    CHECK(pt_render_run(r) == PT_OK);
    return r;
}

/* ---- the density ---- */

typedef struct guide_test { const pti_guide *guide; const pti_guide_cell *cell; pt_vec3 p; } guide_test;
static int guide_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    const guide_test *t = (const guide_test *)ctx;
    uint32_t u = pt_rng_u32(rng);
    *wi = pti_guide_sample(t->guide, t->cell, t->p, u, pt_rng_u32(rng));
    return 1;
}
static double guide_pdf(void *ctx, pt_vec3 wi) {
    const guide_test *t = (const guide_test *)ctx;
    return (double)pti_guide_pdf(t->guide, t->cell, t->p, wi);
}
/* From places of all kinds: far from the windows, among them, and in the middle of one. */
static void density_of_windows(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d;
    pt_render *r = guided_render(s, &d, 64, 1, 64);
    const pti_guide *g = &r->guide;
    uint32_t i, tested = 0;
    for (i = 0; i < g->cell_count; i += 1 + g->cell_count / 12) {
        const pti_guide_pane *pane;
        chi2_directions_desc chi2;
        guide_test t;
        t.guide = g; t.cell = g->cells + i;
        if (!t.cell->count) continue;
        pane = g->panes + t.cell->first;
        t.p = tested % 3 ? pt_v3(-1.5f + 0.2f * (float)tested, 0.1f * (float)tested, 0) : pt_v3(pane->x[0], pane->y[0], pane->z[0]);
        test_case("cell %u, %u panes", (unsigned)i, (unsigned)t.cell->count);
        memset(&chi2, 0, sizeof chi2);
        chi2.sample = guide_sample; chi2.pdf = guide_pdf; chi2.ctx = &t;
        chi2.ax = 0.3; chi2.ay = 0.1; chi2.az = 1;
        chi2.n = 100000; chi2.cells_cos = 16; chi2.cells_phi = 32;
        chi2.seed = i;
        chi2.zero_allowed = 5;                           /* on the very border */
        chi2_directions(&chi2);
        tested++;
    }
    test_case("%u cells", (unsigned)g->cell_count);
    CHECK(tested >= 5);
    pt_render_destroy(r);
    pt_scene_destroy(s);
}
/* A floor whose records have all come through one far cube, each 1; but in one corner, one of 300, and 1000 times as bright, through
   another. By heart that one, though counted as 200 means at most, would weigh 866 of 1165. */
static void few_records_are_not_believed(void) {
    const pt_vec3 window = { 7.5f, 7.5f, 7.5f }, other = { 0.5f, 7.5f, 7.5f };
    pt_allocator none = { NULL, NULL, NULL }, a = pti_allocator_or_default(none);
    const pti_guide_cell *c;
    pti_guide g;
    uint32_t i, n = 4000, k;
    float known = 0, rare = 0;
    memset(&g, 0, sizeof g);
    CHECK(pti_guide_create(&g, &a, n));
    for (i = 0; i < n; i++) {
        pti_guide_record *r = g.records + i;
        int odd = i == n - 1, corner = i >= n - 300;
        memset(r, 0, sizeof *r);
        r->p = corner ? pt_v3(0.01f * (float)(i % 10), 0, 0.01f * (float)(i % 7)) : pt_v3(1 + 0.9f * (float)(i % 8), 0, 0.0002f * (float)i);
        r->wi = pti_normalize(pti_sub(odd ? other : window, r->p));
        r->distance = pti_length(pti_sub(odd ? other : window, r->p));
        r->value = odd ? 1000.0f : 1.0f;
        r->face = 2;
    }
    g.record_count = n;
    pti_guide_refine(&g, PTI_GUIDE_LEVELS - 1);
    c = pti_guide_find(&g, 2, pt_v3(0.05f, 0, 0.03f));
    CHECK(c->count > 0 && g.cell_count > PTI_GUIDE_FACES);
    for (i = 0; i < c->count; i++) for (k = 0; k < PTI_GUIDE_LANES; k++) {
        const pti_guide_pane *pane = g.panes + c->first + i;
        if (pane->y[k] < 4) continue;
        if (pane->x[k] > 5) known += pane->weight[k]; else rare += pane->weight[k];
    }
    test_case("weights %.3f and %.3f", (double)known, (double)rare);
    CHECK(known > rare);
    pti_guide_free(&g, &a);
}
/* With its share of the mixture, beside BSDF, lights and environment. */
typedef struct mixed_test { pti_mixture mix; pti_surface surface; pt_vertex x; } mixed_test;
static int mixed_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    mixed_test *t = (mixed_test *)ctx;
    uint32_t u = pt_rng_u32(rng), v = pt_rng_u32(rng), choice[2];
    pti_step step;
    choice[0] = choice[1] = pt_rng_u32(rng);
    if (!pti_mixture_sample(&t->mix, u, v, choice, &step) || step.delta) return 0;
    *wi = step.wi;
    return 1;
}
static double mixed_pdf(void *ctx, pt_vec3 wi) {
    mixed_test *t = (mixed_test *)ctx;
    pt_vec3 f;
    float guided;
    return (double)pti_mixture_pdf(&t->mix, wi, UNKNOWN, &f, &guided);
}
static void density_of_the_mixture(void) {
    static const pt_weights set = { 0.4f, 0.6f, 0 }, automatic = { 0, 0, 0 };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d;
    pt_render *r = guided_render(s, &d, 64, 1, 64);
    int k;
    for (k = 0; k < 6; k++) {
        chi2_directions_desc chi2;
        mixed_test t;
        pt_ray ray;
        memset(&ray, 0, sizeof ray);
        ray.org = pt_v3(-0.9f + 0.5f * (float)k, 0.5f, k % 2 ? 0.8f : -0.8f);
        ray.dir = pt_v3(0, -1, 0);
        if (!CHECK(pt_intersect(s, &ray, &t.x))) continue;
        pti_surface_at(pti_material_at(s, &t.x), &t.x, &t.surface);
        t.mix = pti_mixture_at(s, &t.surface, k < 3 ? &automatic : &set);
        pti_mixture_guided(&t.mix, &r->guide, k < 3);
        test_case("vertex %d, shares %.3f %.3f %.3f", k, (double)t.mix.bsdf, (double)t.mix.lights, (double)t.mix.guide);
        CHECK(t.mix.guide > 0.05f);                      /* enough to be noticed */
        CHECK_NEAR(t.mix.bsdf + t.mix.lights + t.mix.environment + t.mix.users + t.mix.guide, 1, 1e-5);
        memset(&chi2, 0, sizeof chi2);
        chi2.sample = mixed_sample; chi2.pdf = mixed_pdf; chi2.ctx = &t;
        chi2.ax = 0.3; chi2.ay = 1; chi2.az = 0.2;
        chi2.n = 60000; chi2.cells_cos = 16; chi2.cells_phi = 16;
        chi2.seed = (uint64_t)k;
        chi2_directions(&chi2);
    }
    pt_render_destroy(r);
    pt_scene_destroy(s);
}

/* ---- pictures ---- */

static void compare_guided(const char *name, scene_builder *build, pt_integrator integrator, pt_weights weights) {
    stats_moments m[2][BLOCKS];
    int k;
    memset(m, 0, sizeof m);
    for (k = 0; k < 2; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, 64);
        inner = build(s, &d);
        d.guide = k ? 64 : 0;
        d.integrator = integrator;
        d.weights = weights;
        if (commit(s)) push_blocks(m[k], s, &d, build == gap ? k ? 40 : 64 : 24, (uint64_t)(3000 * k + 1));
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
    if (m[0][0].n > 1 && m[1][0].n > 1) compare_blocks(name, m[1], m[0]);
}
static const pt_weights automatic = { 0, 0, 0 }, half = { 1, 1, 0 };
static void guided_behind_the_gap(void) {
    edge = 1.4f;
    compare_guided("gap", gap, PT_INTEGRATOR_MIXTURE, automatic);
    edge = 1.8f;
}
static void guided_by_set_weights(void)  { compare_guided("room, half and half", closed_room, PT_INTEGRATOR_MIXTURE, half); }
static void guided_with_shadow_rays(void) { compare_guided("room, shadow rays", closed_room, PT_INTEGRATOR_NEE, automatic); }
static void guided_in_cornell_box(void)  { compare_guided("cornell", cornell, PT_INTEGRATOR_MIXTURE, automatic); }
static void guided_under_the_sun(void)   { compare_guided("sun", sun_and_mesh, PT_INTEGRATOR_MIXTURE, automatic); }
static void guided_on_mirror_and_glass(void) { compare_guided("glass", sky_lamps_mirror_glass, PT_INTEGRATOR_MIXTURE, automatic); }
static void guided_on_instances(void)    { compare_guided("instances", instanced_lamps, PT_INTEGRATOR_MIXTURE, automatic); }
static void guided_with_densities(void)  { compare_guided("densities", densities, PT_INTEGRATOR_MIXTURE, automatic); }

/* Learned by one thread while the others wait: threads, tiles, and in how many goes the samples come change no bit. */
static void guided_by_any_threads(void) {
    static float one[24 * 24 * 3];
    size_t i, size = sizeof one;
    int k;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 24, 4);
        pt_render *r;
        gap(s, &d);
        d.guide = 16;
        d.threads = 1 + k;
        d.tile = k == 2 ? 5 : 16;
        if (!commit(s) || !CHECK((r = pt_render_create(s, &d)) != NULL)) return;
        CHECK(pt_render_run(r) == PT_OK);
        if (k == 0) memcpy(one, pt_render_pixels(r), size);
        test_case("%d threads", k + 1);
        CHECK(!memcmp(one, pt_render_pixels(r), size));
        pt_render_destroy(r);
        pt_scene_destroy(s);
    }
    for (i = 0; i < size / sizeof *one; i++) if (one[i] > 0) return;
    FAIL("all black");
}
/* What it is for: with it, the same number of samples has three quarters of the variance at most, relative to each pixel's square. */
static void guided_paths_find_the_gap(void) {
    double variance[2] = { 0, 0 };
    enum { SIZE = 32, RENDERS = 4, N = SIZE * SIZE * 3 };
    static float rgb[RENDERS][N];
    static double square[N];                             /* without; for both */
    int k, i, j;
    for (k = 0; k < 2; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, SIZE, 32);
        gap(s, &d);
        d.guide = k ? 128 : 0;
        if (!commit(s)) return;
        for (i = 0; i < RENDERS; i++) { d.seed = (uint64_t)(7 + i); if (!render(s, &d, rgb[i], NULL)) return; }
        for (j = 0; j < N; j++) {
            stats_moments m = { 0, 0, 0 };
            for (i = 0; i < RENDERS; i++) stats_push(&m, rgb[i][j]);
            if (k == 0) square[j] = m.mean * m.mean + 1e-4;
            variance[k] += stats_variance(&m) / square[j] / N;
        }
        pt_scene_destroy(s);
    }
    test_case("relative variance %g without, %g with", variance[0], variance[1]);
    CHECK(variance[1] < 0.75 * variance[0]);
}
static void guides_that_are_refused(void) {
    static const int bad[] = { -1, 65537, 2147483647 };
    pt_scene *s = pt_scene_create(NULL);
    int i;
    floor_of(s, 1, diffuse(s, 0.5f));
    commit(s);
    for (i = 0; i < 3; i++) {
        pt_render_desc d = view(pt_v3(0, 1, 1), pt_v3(0, 0, 0), 40, 8, 1);
        pt_render *r;
        d.guide = bad[i];
        r = pt_render_create(s, &d);
        test_case("guide %d", bad[i]);
        CHECK(pt_render_run(r) == PT_ERR_ARG && strstr(pt_render_error(r), "guide"));
        pt_render_destroy(r);
    }
    pt_scene_destroy(s);
}
/* Nothing to learn from: black scenes, and no scene at all. */
static void guides_of_nothing(void) {
    int k;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 1, 1), pt_v3(0, 0, 0), 40, 8, 4);
        float rgb[3 * 8 * 8];
        int i;
        d.guide = 8;
        if (k) floor_of(s, 1, k == 1 ? diffuse(s, 0.5f) : mirror(s, 0.9f));
        if (k == 2) sky(s, 1);
        test_case("scene %d", k);
        if (commit(s) && render(s, &d, rgb, NULL)) for (i = 0; i < 3 * 8 * 8; i++) CHECK(k == 2 ? rgb[i] > 0.8f : rgb[i] == 0);
        pt_scene_destroy(s);
    }
}

/* From so few paths a guide learns those, and not the room; potentials then grow from vertex to vertex. */
static void few_paths_do_not_multiply(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 1, 0.9f), pt_v3(0, 0.8f, 0), 60, 32, 4);
    pt_material wall = diffuse(s, 0.8f);
    pt_stats stats;
    pt_render *r;
    pt_add_box(s, pt_v3(-1, 0, -1), pt_v3(1, 2, 1), NULL, wall);
    quad(s, -0.25f, 1.99f, -0.25f, 0.5f, 0, 0, 0, 0, 0.5f, lamp(s, 2, 0));
    pt_add_sphere(s, pt_v3(0.4f, 0.3f, 0), 0.3f, wall);
    d.guide = 2;
    r = commit(s) ? pt_render_create(s, &d) : NULL;
    if (CHECK(pt_render_run(r) == PT_OK)) {
        stats = pt_render_stats(r);
        test_case("%.1f rays a path", (double)stats.rays / (double)stats.paths);
        CHECK(r->tracer.guide != NULL);
        CHECK(stats.rays < 150 * stats.paths);
    }
    pt_render_destroy(r);
    pt_scene_destroy(s);
}

void test_guide(void) {
    RUN(density_of_windows); RUN(few_records_are_not_believed); RUN(density_of_the_mixture);
    RUN(guided_behind_the_gap); RUN(guided_by_set_weights); RUN(guided_with_shadow_rays); RUN(guided_in_cornell_box);
    RUN(guided_under_the_sun); RUN(guided_on_mirror_and_glass); RUN(guided_on_instances); RUN(guided_with_densities);
    RUN(guided_by_any_threads); RUN(guided_paths_find_the_gap); RUN(guides_that_are_refused); RUN(guides_of_nothing); RUN(few_paths_do_not_multiply);
}
