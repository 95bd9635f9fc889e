/* >>guide: what it draws is what its density says, after training; the same bits on any threads and tiles; the same mean with it
   as without; and what may go wrong on the way. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

enum { W = 24, H = 16, FLOATS = 3 * W * H };

/* Two rooms with a slit between them, a lamp in the far one; diffuse, glossy and glass things in the near one. */
static pt_scene *rooms(float size) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material white = diffuse(s, 0.7f);
    pt_material metal = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { .9f, .8f, .6f }, .roughness = .4f });
    float a = size;
    pt_add_quad(s, pt_v3(-a, 0, a), pt_v3(2 * a, 0, 0), pt_v3(0, 0, -4 * a), white);
    pt_add_quad(s, pt_v3(-a, 2 * a, a), pt_v3(0, 0, -4 * a), pt_v3(2 * a, 0, 0), white);
    pt_add_quad(s, pt_v3(-a, 0, a), pt_v3(0, 0, -4 * a), pt_v3(0, 2 * a, 0), white);
    pt_add_quad(s, pt_v3(a, 0, a), pt_v3(0, 2 * a, 0), pt_v3(0, 0, -4 * a), white);
    pt_add_quad(s, pt_v3(-a, 0, -3 * a), pt_v3(2 * a, 0, 0), pt_v3(0, 2 * a, 0), white);
    pt_add_quad(s, pt_v3(-a, 0, a), pt_v3(0, 2 * a, 0), pt_v3(2 * a, 0, 0), white);
    pt_add_quad(s, pt_v3(-a, 0, -a), pt_v3(1.4f * a, 0, 0), pt_v3(0, 2 * a, 0), white);
    pt_add_quad(s, pt_v3(-.5f * a, 1.9f * a, -2 * a), pt_v3(a, 0, 0), pt_v3(0, 0, .5f * a), lamp(s, 30, 0));
    pt_add_sphere(s, pt_v3(-.4f * a, .35f * a, -.3f * a), .35f * a, metal);
    pt_add_sphere(s, pt_v3(.4f * a, .3f * a, 0), .3f * a, glass(s, 1.5f));
    commit(s);
    return s;
}
/* Outdoors: a sun, a sky, a mirror. */
static pt_scene *outdoors(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_add_quad(s, pt_v3(-2, 0, 2), pt_v3(4, 0, 0), pt_v3(0, 0, -4), diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(-.5f, .5f, -1), .5f, diffuse(s, 0.8f));
    pt_add_sphere(s, pt_v3(.6f, .5f, -.8f), .5f, mirror(s, 0.9f));
    sky(s, 0.3f);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { -1, -2, -1 }, .color = { 3, 3, 3 }, .radius_deg = 3 });
    commit(s);
    return s;
}
/* A room that a lamp in an instance lights. */
static pt_scene *inner;
static pt_scene *with_instance(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_xform x = { { .7f, .2f, 0, .3f, -.1f, .9f, .3f, 1.2f, 0, -.3f, .8f, -.4f } };
    inner = pt_scene_create(NULL);
    pt_add_box(inner, pt_v3(-.3f, -.3f, -.3f), pt_v3(.3f, .3f, .3f), NULL, diffuse(inner, 0.5f));
    pt_add_sphere(inner, pt_v3(0, .5f, 0), .1f, lamp(inner, 20, 0));
    commit(inner);
    pt_add_box(s, pt_v3(-1, 0, -1), pt_v3(1, 2, 1), NULL, diffuse(s, 0.6f));
    pt_add_instance(s, inner, &x);
    commit(s);
    return s;
}
static pt_scene *closed_room(void) {                     /* walls that glow: all light is everywhere */
    pt_scene *s = pt_scene_create(NULL);
    pt_material m = pt_add_material(s, &(pt_material_desc){ .color = { .5f, .5f, .5f }, .emission = { 1, 1, 1 }, .two_sided = 1 });
    pt_add_box(s, pt_v3(-1, 0, -1), pt_v3(1, 2, 1), NULL, m);
    pt_add_sphere(s, pt_v3(0, .4f, 0), .4f, diffuse(s, 0.8f));
    commit(s);
    return s;
}
static pt_render_desc desc(float size, int spp, int training) {
    pt_render_desc d = view(pt_v3(0, size, .9f * size), pt_v3(0, .8f * size, -size), 60, W, spp);
    d.height = H;
    d.guide.spp = training;
    d.guide.megabytes = 2;
    d.tile = 8;
    return d;
}

/* ---- the density ---- */

static void directions_on_the_square(void) {
    pt_rng rng;
    int i, j, n = 512;
    double all = 0;
    pt_rng_seed(&rng, 1, 1);
    for (i = 0; i < 10000; i++) {
        pt_vec3 d = i < 6 ? pt_v3((float)(i == 0) - (float)(i == 1), (float)(i == 2) - (float)(i == 3), (float)(i == 4) - (float)(i == 5))
                          : stats_direction(&rng), e;
        float uv[2];
        pti_direction_to_square(d, uv);
        CHECK(uv[0] >= 0 && uv[0] <= 1 && uv[1] >= 0 && uv[1] <= 1);
        e = pti_square_to_direction(uv[0], uv[1]);
        CHECK_NEAR(pti_dot(d, e), 1, 1e-6);
    }
    for (i = 0; i < n; i++) for (j = 0; j < n; j++)
        all += (double)pti_square_angle(pti_square_to_direction(((float)i + .5f) / (float)n, ((float)j + .5f) / (float)n)) / n / n;
    CHECK_NEAR(all, 4 * STATS_PI, 1e-3);
}

typedef struct there { const pti_guide *g; const pti_guide_cell *c; } there;
static int draw(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    const there *t = (const there *)ctx;
    uint32_t u = pt_rng_u32(rng), v = pt_rng_u32(rng);
    *wi = pti_guide_sample(t->g, t->c, u, v);
    return 1;
}
static double density(void *ctx, pt_vec3 wi) { const there *t = (const there *)ctx; return (double)pti_guide_pdf(t->g, t->c, wi); }
static void what_is_drawn_is_what_the_density_says(void) {
    pt_scene *s = rooms(1);
    pt_render_desc d = desc(1, 1, 16);
    pt_render *r = pt_render_create(s, &d);
    uint32_t i, learned = 0;
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    for (i = 0; i < r->guide.cell_count; i++) {
        there t;
        t.g = &r->guide; t.c = r->guide.cells + i;
        if (t.c->child || !(t.c->share[PTI_PART_GUIDE] > 0) || learned++ % 4) continue;
        test_case("cell %u", i);
        chi2_directions(&(chi2_directions_desc){ .sample = draw, .pdf = density, .ctx = &t, .seed = i, .n = 40000, .tolerance = .01 });
    }
    CHECK(learned > 12);
    pt_render_destroy(r);
    pt_scene_destroy(s);
}
static void shares_are_shares(void) {
    pt_scene *s = rooms(1);
    pt_render_desc d = desc(1, 1, 16);
    pt_render *r = pt_render_create(s, &d);
    const pti_guide *g = &r->guide;
    uint32_t i;
    int k;
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    CHECK(g->cell_count <= g->cell_capacity && g->node_count <= g->node_capacity);
    for (i = 0; i < g->cell_count; i++) {
        const float *w = g->cells[i].share;
        float sum = 0;
        if (g->cells[i].child) { CHECK(g->cells[i].child > i && g->cells[i].child + 1 < g->cell_count); continue; }
        for (k = 0; k < PTI_PARTS; k++) { CHECK(w[k] >= 0 && w[k] <= 1); sum += w[k]; }
        if (w[PTI_PART_GUIDE] > 0) CHECK_NEAR(sum, 1, 1e-5);
    }
    for (i = 1; i < g->node_count; i++) {
        const pti_guide_node *n = g->nodes + i;
        CHECK_NEAR(n->share[0] + n->share[1] + n->share[2] + n->share[3], 1, 1e-5);
        for (k = 0; k < 4; k++) CHECK(n->child[k] == 0 || (n->child[k] > i && n->child[k] < g->node_count));
    }
    pt_render_destroy(r);
    pt_scene_destroy(s);
}

/* ---- the same bits ---- */

static void picture(const pt_scene *s, const pt_render_desc *d, float *out) {
    pt_render *r = pt_render_create(s, d);
    if (!CHECK_EQ_INT(pt_render_run(r), PT_OK)) FAIL("%s", pt_render_error(r));
    memcpy(out, pt_render_pixels(r), FLOATS * sizeof *out);
    pt_render_destroy(r);
}
static void same_bits_for_any_threads_and_tiles(void) {
    static const int threads[] = { 1, 2, 5 }, tiles[] = { 8, 32, 64, 5 };
    static float all[FLOATS], p[FLOATS], plain[FLOATS];
    pt_scene *s = rooms(1);
    pt_render_desc d = desc(1, 3, 7);
    int i, j;
    picture(s, &d, all);
    for (i = 0; i < 3; i++) for (j = 0; j < 4; j++) {
        d.threads = threads[i]; d.tile = tiles[j];
        picture(s, &d, p);
        test_case("%d threads, tiles of %d", threads[i], tiles[j]);
        CHECK_EQ_INT(memcmp(all, p, sizeof p), 0);
    }
    d.guide.spp = 0;
    picture(s, &d, plain);
    CHECK(memcmp(all, plain, sizeof plain) != 0);
    pt_scene_destroy(s);
}
static void ranges_and_crops_equal_the_whole(void) {
    static float all[FLOATS];
    pt_scene *s = rooms(1);
    pt_render_desc d = desc(1, 6, 4), part;
    pt_render *a, *b;
    int x, y;
    picture(s, &d, all);
    part = d;
    part.spp = 2;
    a = pt_render_create(s, &part);
    part.spp = 4; part.first_sample = 2;
    b = pt_render_create(s, &part);
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    CHECK_EQ_INT(pt_render_run(b), PT_OK);
    CHECK_EQ_INT(pt_render_merge(a, b), PT_OK);
    CHECK_EQ_INT(memcmp(pt_render_pixels(a), all, sizeof all), 0);
    pt_render_destroy(a); pt_render_destroy(b);
    part = d;
    part.spp = 3;
    a = pt_render_create(s, &part);                      /* more samples on top */
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    CHECK_EQ_INT(pt_render_add_samples(a, 3), PT_OK);
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    CHECK_EQ_INT(memcmp(pt_render_pixels(a), all, sizeof all), 0);
    pt_render_destroy(a);
    part = d;
    part.crop_x = 5; part.crop_y = 3; part.crop_width = 7; part.crop_height = 6;
    a = pt_render_create(s, &part);
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    for (y = 0; y < 6; y++) for (x = 0; x < 7; x++)
        CHECK(!memcmp(pt_render_pixels(a) + 3 * (7 * y + x), all + 3 * (W * (y + 3) + x + 5), 3 * sizeof *all));
    pt_render_destroy(a);
    pt_scene_destroy(s);
}

/* ---- training that is looked at, cancelled, gone on with ---- */

typedef struct watcher { pt_render *r; double last; int calls, backwards, cancel_at, lit; } watcher;
static int watch(void *user, double done) {
    watcher *w = (watcher *)user;
    const float *p = pt_render_pixels(w->r);
    int i;
    if (!(done >= w->last && done <= 1)) w->backwards++;
    w->last = done;
    if (w->r->training.spp) for (i = 0; i < FLOATS; i++) w->lit += p[i] != 0;
    return ++w->calls == w->cancel_at;
}
static void cancelled_in_training_and_gone_on_with(void) {
    static float all[FLOATS];
    pt_scene *s = rooms(1);
    pt_render_desc d = desc(1, 2, 7);
    int at, threads;
    picture(s, &d, all);
    for (threads = 1; threads <= 3; threads += 2) for (at = 1; at < 30; at += 4) {
        watcher w = { NULL, 0, 0, 0, 0, 0 };
        w.cancel_at = at;
        d.threads = threads;
        d.progress = watch; d.user = &w;
        w.r = pt_render_create(s, &d);
        test_case("%d threads, cancelled at %d", threads, at);
        CHECK_EQ_INT(pt_render_run(w.r), PT_CANCELLED);
        CHECK_EQ_INT(pt_render_work(w.r), PT_CANCELLED);
        w.last = 0;
        CHECK_EQ_INT(pt_render_add_samples(w.r, 0), PT_OK);
        CHECK_EQ_INT(pt_render_run(w.r), PT_OK);
        CHECK(w.last == 1);
        CHECK_EQ_INT(w.backwards, 0);
        CHECK_EQ_INT(w.lit, 0);
        CHECK_EQ_INT(memcmp(pt_render_pixels(w.r), all, sizeof all), 0);
        pt_render_destroy(w.r);
    }
    pt_scene_destroy(s);
}
static void added_samples_wait_for_the_training(void) {
    pt_scene *s = rooms(1);
    pt_render_desc d = desc(1, 2, 2);
    pt_render *r = pt_render_create(s, &d);
    CHECK_EQ_INT(pt_render_work(r), PT_MORE);
    CHECK_EQ_INT(pt_render_add_samples(r, 1), PT_ERR_STATE);
    pt_render_cancel(r);
    CHECK_EQ_INT(pt_render_add_samples(r, 1), PT_OK);
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    pt_render_destroy(r);
    pt_scene_destroy(s);
}

/* ---- the same mean ---- */

static void same_mean(pt_scene *s, float size, const char *name) {
    pt_render_desc d = desc(size, 4, 8);
    stats_moments off = { 0, 0, 0 }, on = { 0, 0, 0 };
    static float p[FLOATS];
    int i, k;
    for (i = 0; i < 32; i++) for (k = 0; k < 2; k++) {
        double sum = 0;
        int j;
        d.seed = (uint64_t)(2 * i + k);
        d.guide.spp = k ? 8 : 0;
        picture(s, &d, p);
        for (j = 0; j < FLOATS; j++) sum += (double)p[j] / FLOATS;
        CHECK(sum < 1e30);
        stats_push(k ? &on : &off, sum);
    }
    test_case("%s: %g +- %g, guided %g +- %g", name, off.mean, stats_error(&off), on.mean, stats_error(&on));
    CHECK_P(stats_welch_test(&off, &on));
    CHECK(off.mean > 0);
    pt_scene_destroy(s);
}
static void the_same_mean_with_and_without(void) {
    same_mean(rooms(1), 1, "rooms");
    same_mean(outdoors(), 1, "outdoors");
    same_mean(with_instance(), 1, "instance");
    pt_scene_destroy(inner);
    same_mean(closed_room(), 1, "closed room");
}

/* ---- what may go wrong ---- */

static void no_light_and_far_away(void) {
    static float p[FLOATS];
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = desc(1, 1, 4);
    float size;
    int i;
    pt_add_box(s, pt_v3(-1, 0, -1), pt_v3(1, 2, 1), NULL, diffuse(s, 0.6f));
    commit(s);
    picture(s, &d, p);
    for (i = 0; i < FLOATS; i++) CHECK(p[i] == 0);
    pt_scene_destroy(s);
    s = pt_scene_create(NULL);                           /* nothing at all */
    commit(s);
    picture(s, &d, p);
    for (i = 0; i < FLOATS; i++) CHECK(p[i] == 0);
    pt_scene_destroy(s);
    for (size = 1e-8f; size < 1e9f; size *= 1e4f) {
        pt_render *r;
        s = rooms(size);
        d = desc(size, 4, 8);
        test_case("size %g", (double)size);
        r = pt_render_create(s, &d);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        CHECK_EQ_INT(pt_render_stats(r).discarded, 0);
        CHECK(r->guide.cell_count > 20);
        pt_render_destroy(r);
        pt_scene_destroy(s);
    }
}

typedef struct arena { size_t used, most; int left; } arena;
static void *arena_alloc(void *user, size_t size, size_t align) {
    arena *a = (arena *)user;
    if (a->left-- <= 0) return NULL;
    a->used += size;
    if (a->used > a->most) a->most = a->used;
    return pti_default_alloc(NULL, size, align);
}
static void arena_free(void *user, void *p, size_t size) { ((arena *)user)->used -= size; pti_default_free(NULL, p, size); }
static void memory_is_bounded_and_may_run_out(void) {
    arena a = { 0, 0, 1000000 };
    pt_scene *s = pt_scene_create(&(pt_scene_desc){ .allocator = { arena_alloc, arena_free, &a } });
    pt_render_desc d = desc(1, 1, 8);
    size_t before;
    int n;
    pt_render *r;
    pt_add_box(s, pt_v3(-1, 0, -1), pt_v3(1, 2, 1), NULL, diffuse(s, 0.6f));
    sky(s, 1);
    commit(s);
    before = a.used;
    for (n = 0; ; n++) {
        a.left = n;
        r = pt_render_create(s, &d);
        if (r) break;
        CHECK(a.used == before);
    }
    CHECK(n > 9);
    CHECK(a.used - before > 1800000 && a.used - before < (2u << 20) + 200000);
    a.left = 0;                                          /* rendering never allocates */
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    pt_render_destroy(r);
    CHECK(a.used == before);
    a.left = 1000000;
    d.guide.spp = -1;
    r = pt_render_create(s, &d);
    CHECK(strstr(pt_render_error(r), "guide.spp") != NULL);
    pt_render_destroy(r);
    d.guide.spp = 1; d.guide.megabytes = 65537;
    r = pt_render_create(s, &d);
    CHECK(strstr(pt_render_error(r), "guide.megabytes") != NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
}

void test_guide(void) {
    RUN(directions_on_the_square); RUN(what_is_drawn_is_what_the_density_says); RUN(shares_are_shares);
    RUN(same_bits_for_any_threads_and_tiles); RUN(ranges_and_crops_equal_the_whole);
    RUN(cancelled_in_training_and_gone_on_with); RUN(added_samples_wait_for_the_training);
    RUN(the_same_mean_with_and_without); RUN(no_light_and_far_away); RUN(memory_is_bounded_and_may_run_out);
}
