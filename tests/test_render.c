/* >>render: the same bits however the work is cut, interrupted and spread; and what is refused. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#if defined(PTI_X86)
#include <xmmintrin.h>
#endif

/* A box with a lamp, a mirror, glass, a skewed triangle light, an instance, and a sky that comes in from the front: all parts
   of the mixture at work. */
static pt_scene *inner, *room;
static pt_vec3 sky_radiance(void *user, pt_vec3 d) { (void)user; return pt_v3(0.5f + 0.5f * d.y, 0.6f, 0.7f + 0.2f * d.x); }
static void scenes_make(void) {
    static const float tri[9] = { -0.9f, 1.5f, -0.9f, -0.9f, 1.9f, -0.2f, -0.9f, 1.1f, -0.3f };
    pt_material white, red, mirror, glass, lamp, glow;
    pt_xform x = { { 0.7f, 0.2f, 0, 0.3f, -0.1f, 0.9f, 0.3f, 0.5f, 0, -0.3f, 0.8f, -0.4f } };
    inner = pt_scene_create(NULL);
    red = pt_add_material(inner, &(pt_material_desc){ .color = { 0.8f, 0.2f, 0.1f } });
    pt_add_box(inner, pt_v3(-0.3f, -0.3f, -0.3f), pt_v3(0.3f, 0.3f, 0.3f), NULL, red);
    glow = pt_add_material(inner, &(pt_material_desc){ .emission = { 2, 3, 4 } });
    pt_add_sphere(inner, pt_v3(0, 0.5f, 0), 0.1f, glow);
    pt_scene_commit(inner);
    room = pt_scene_create(NULL);
    white = pt_add_material(room, &(pt_material_desc){ .color = { 0.75f, 0.75f, 0.75f } });
    mirror = pt_add_material(room, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { 0.9f, 0.9f, 0.9f } });
    glass = pt_add_material(room, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC });
    lamp = pt_add_material(room, &(pt_material_desc){ .emission = { 8, 8, 7 } });
    glow = pt_add_material(room, &(pt_material_desc){ .emission = { 1, 5, 1 }, .two_sided = 1 });
    pt_add_quad(room, pt_v3(-1, 0, 1), pt_v3(2, 0, 0), pt_v3(0, 0, -2), white);
    pt_add_quad(room, pt_v3(-1, 0, -1), pt_v3(2, 0, 0), pt_v3(0, 2, 0), white);
    pt_add_quad(room, pt_v3(-0.3f, 1.98f, -0.3f), pt_v3(0.6f, 0, 0), pt_v3(0, 0, 0.6f), lamp);
    pt_add_mesh(room, &(pt_mesh_desc){ .positions = tri, .vertex_count = 3, .material = glow });
    pt_add_sphere(room, pt_v3(-0.5f, 0.35f, -0.3f), 0.35f, mirror);
    pt_add_sphere(room, pt_v3(0.5f, 0.3f, 0.5f), 0.3f, glass);
    pt_add_instance(room, inner, &x);
    pt_add_light(room, &(pt_light_desc){ .radiance = sky_radiance, .color = { 0.3f, 0.3f, 0.3f } });
    if (pt_scene_commit(room) != PT_OK) FAIL("%s", pt_scene_error(room));
}
static void scenes_free(void) { pt_scene_destroy(room); pt_scene_destroy(inner); }

#define W 50
#define H 37
#define SPP 6
#define FLOATS (3 * W * H)
static pt_render_desc desc(void) {
    return (pt_render_desc){ .width = W, .height = H, .spp = SPP, .seed = 7, .tile = 16, .threads = 2,
                             .camera = { .eye = { 0.2f, 1.1f, 4 }, .target = { 0, 0.9f, 0 }, .vfov_deg = 35, .aperture = 0.02f } };
}
static float whole[FLOATS];
static void copy_pixels(pt_render *r, float *out) {
    const float *p = pt_render_pixels(r);
    if (CHECK(p != NULL)) memcpy(out, p, sizeof whole);
}
static void render(const pt_render_desc *d, float *out) {
    pt_render *r = pt_render_create(room, d);
    if (!CHECK(pt_render_run(r) == PT_OK)) FAIL("%s", pt_render_error(r));
    copy_pixels(r, out);
    pt_render_destroy(r);
}
static int same(const float *a, const float *b) {
    int i, n = 0;
    for (i = 0; i < FLOATS; i++) n += memcmp(a + i, b + i, sizeof *a) != 0;
    return n ? FAIL("%d of %d numbers differ", n, FLOATS) : CHECK(1);
}

/* ---- the same bits ---- */

static void same_bits_for_any_threads_and_tiles(void) {
    static const int threads[] = { 1, 2, 7 }, tiles[] = { 8, 32, 100, 1 };
    static float p[FLOATS];
    double sum = 0;
    int i, j;
    pt_render_desc d = desc();
    render(&d, whole);
    for (i = 0; i < FLOATS; i++) sum += (double)whole[i];
    CHECK(sum / FLOATS > 0.1 && sum / FLOATS < 1);       /* there is something to see */
    for (i = 0; i < 3; i++) for (j = 0; j < 4; j++) {
        if (tiles[j] == 1 && threads[i] != 7) continue;
        d.threads = threads[i]; d.tile = tiles[j];
        test_case("threads %d, tile %d", d.threads, d.tile);
        render(&d, p);
        same(p, whole);
    }
    d.seed++;
    render(&d, p);
    CHECK(memcmp(p, whole, sizeof p) != 0);
}
static void same_bits_for_any_isa(void) {
    static float p[FLOATS];
    int isa, tried = 0;
    static const char *names[] = {
#define NAME(name, NAME) #name,
        PTI_ISAS(NAME)
#undef NAME
    };
    pt_render_desc d = desc();
    for (isa = 0; isa < PTI_ISA_COUNT; isa++) {
        if (!pti_isa_supported(isa)) continue;
        d.isa = names[isa];
        test_case("%s", d.isa);
        render(&d, p);
        same(p, whole);
        tried++;
    }
    CHECK(tried >= 1);
}
static const pt_sampler samplers[] = { PT_SAMPLER_SOBOL, PT_SAMPLER_RANDOM, PT_SAMPLER_STRATIFIED };
static void merged_ranges_equal_the_whole(void) {
    static const int order[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
    static const int begin[3] = { 0, 1, 4 }, end[3] = { 1, 4, SPP };
    static float p[FLOATS], all[FLOATS];
    int i, k, kind;
    for (kind = 0; kind < 2; kind++) {
        pt_render_desc d = desc();
        d.sampler = samplers[kind];
        test_case("sampler %d", kind);
        render(&d, all);
        for (i = 0; i < 6; i += kind ? 5 : 1) {
            pt_render *r[3];
            pt_stats stats;
            for (k = 0; k < 3; k++) {
                pt_render_desc part = d;
                part.first_sample = begin[order[i][k]]; part.spp = end[order[i][k]] - begin[order[i][k]];
                r[k] = pt_render_create(room, &part);
                CHECK_EQ_INT(pt_render_run(r[k]), PT_OK);
            }
            CHECK_EQ_INT(pt_render_merge(r[0], r[1]), PT_OK);
            CHECK_EQ_INT(pt_render_merge(r[0], r[2]), PT_OK);
            copy_pixels(r[0], p);
            same(p, all);
            stats = pt_render_stats(r[0]);
            CHECK_EQ_INT(stats.paths, W * H * SPP);
            for (k = 0; k < 3; k++) pt_render_destroy(r[k]);
        }
    }
}
/* The stratified sampler's cells follow from spp, so its ranges must all be of one length. */
static void stratified_ranges_of_one_length(void) {
    static float p[FLOATS], all[FLOATS];
    pt_render_desc d = desc();
    pt_render *a, *b;
    d.sampler = PT_SAMPLER_STRATIFIED;
    a = pt_render_create(room, &d);
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    CHECK_EQ_INT(pt_render_add_samples(a, SPP), PT_OK);
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    copy_pixels(a, all);
    pt_render_destroy(a);
    a = pt_render_create(room, &d);
    d.first_sample = SPP;
    b = pt_render_create(room, &d);
    CHECK_EQ_INT(pt_render_run(a), PT_OK);
    CHECK_EQ_INT(pt_render_run(b), PT_OK);
    CHECK_EQ_INT(pt_render_merge(b, a), PT_OK);
    copy_pixels(b, p);
    same(p, all);
    pt_render_destroy(a); pt_render_destroy(b);
}
static void added_samples_equal_the_whole(void) {
    static float p[FLOATS], all[FLOATS];
    int kind;
    for (kind = 0; kind < 2; kind++) {
        pt_render_desc d = desc();
        pt_render *r;
        d.sampler = samplers[kind];
        test_case("sampler %d", kind);
        render(&d, all);
        d.spp = 1;
        r = pt_render_create(room, &d);
        CHECK_EQ_INT(pt_render_add_samples(r, 1), PT_ERR_STATE);      /* not done yet */
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        CHECK_EQ_INT(pt_render_add_samples(r, 2), PT_OK);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        CHECK_EQ_INT(pt_render_add_samples(r, 0), PT_OK);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        CHECK_EQ_INT(pt_render_add_samples(r, SPP - 3), PT_OK);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        copy_pixels(r, p);
        same(p, all);
        CHECK_EQ_INT(pt_render_stats(r).paths, W * H * SPP);
        CHECK_EQ_INT(pt_render_add_samples(r, -1), PT_ERR_ARG);
        CHECK_EQ_INT(pt_render_add_samples(r, 0x7fffffff), PT_ERR_ARG);
        pt_render_destroy(r);
    }
}

/* Any part of the picture, by itself: its pixels are those of the whole. With every sampler, and a filter that reaches out. */
static void crops_are_parts_of_the_whole(void) {
    static const int crop[][4] = { { 0, 0, 0, 0 }, { 7, 3, 20, 17 }, { 49, 36, 1, 1 }, { 0, 30, 0, 0 }, { 40, 0, 0, 5 }, { 0, 0, 50, 37 } };
    static float all[FLOATS];
    int kind, i, x, y;
    for (kind = 0; kind < 3; kind++) {
        pt_render_desc d = desc();
        d.spp = 2; d.sampler = samplers[kind];
        d.filter = kind == 1 ? PT_FILTER_MITCHELL : PT_FILTER_BOX;
        d.camera.shutter_close = 1;
        render(&d, all);
        for (i = 0; i < 6; i++) {
            int w = crop[i][2] ? crop[i][2] : W - crop[i][0], h = crop[i][3] ? crop[i][3] : H - crop[i][1], wrong = 0;
            pt_render_desc part = d;
            pt_render *r;
            const float *p;
            part.crop_x = crop[i][0]; part.crop_y = crop[i][1]; part.crop_width = crop[i][2]; part.crop_height = crop[i][3];
            part.tile = 8 + i;
            r = pt_render_create(room, &part);
            CHECK_EQ_INT(pt_render_run(r), PT_OK);
            CHECK_EQ_INT(pt_render_stats(r).paths, w * h * 2);
            p = pt_render_pixels(r);
            test_case("sampler %d, crop %d", kind, i);
            for (y = 0; y < h; y++) for (x = 0; x < w; x++)
                wrong += memcmp(p + 3 * (y * w + x), all + 3 * ((y + crop[i][1]) * W + x + crop[i][0]), 3 * sizeof *p) != 0;
            CHECK_EQ_INT(wrong, 0);
            pt_render_destroy(r);
        }
    }
}
/* All that a camera can do, at once: still the same bits on any threads and tiles, and for any instruction set. */
static void same_bits_with_every_feature(void) {
    static float p[FLOATS], all[FLOATS];
    int kind, isa;
    for (kind = 0; kind <= PT_CAMERA_FISHEYE; kind++) {
        pt_render_desc d = desc();
        d.spp = 2; d.filter = (pt_filter)(PT_FILTER_TENT + kind);
        d.camera.projection = (pt_projection)kind; d.camera.aperture = 0.1f; d.camera.blades = 5 + kind;
        d.camera.shutter_close = 1; d.camera.moving = 1;
        d.camera.eye_end = pt_v3(0.3f, 1, 4); d.camera.target_end = pt_v3(0, 1, 0);
        if (kind < 2) { d.camera.shift_x = 0.1f; d.camera.distortion = 0.1f; }
        render(&d, all);
        test_case("projection %d", kind);
        for (isa = 0; isa < PTI_ISA_COUNT; isa++) {
            static const char *const names[] = { "scalar", "sse2", "avx2", "neon" };
            if (!pti_isa_supported(isa)) continue;
            d.isa = names[isa]; d.threads = 1 + isa; d.tile = 5 + isa;
            render(&d, p);
            same(p, all);
        }
    }
}

/* ---- progress, cancelling ---- */

typedef struct watcher { pt_render *r; double last; int calls, backwards, cancel_at, look, dark; } watcher;
static int watch(void *user, double done) {
    watcher *w = (watcher *)user;
    w->calls++;
    if (!(done >= w->last) || !(done <= 1)) w->backwards++;
    w->last = done;
    if (w->look) {                                       /* a viewer draws from here */
        const float *p = pt_render_pixels(w->r);
        int i, lit = 0;
        for (i = 0; p && i < FLOATS; i++) lit += p[i] > 0;
        w->dark += lit == 0;
        pt_render_stats(w->r);
    }
    return w->cancel_at && w->calls >= w->cancel_at;
}
static void progress_rises_to_one(void) {
    static float p[FLOATS];
    int threads;
    for (threads = 1; threads <= 7; threads += 3) {
        pt_render_desc d = desc();
        watcher w = { NULL, 0, 0, 0, 0, 1, 0 };
        pt_render *r;
        d.threads = threads; d.tile = 8; d.progress = watch; d.user = &w;
        w.r = r = pt_render_create(room, &d);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        CHECK(w.last == 1);
        CHECK_EQ_INT(w.calls, ((W + 7) / 8) * ((H + 7) / 8));
        CHECK_EQ_INT(w.backwards, 0);
        CHECK_EQ_INT(w.dark, 0);
        copy_pixels(r, p);
        same(p, whole);
        CHECK_EQ_INT(pt_render_work(r), PT_OK);
        pt_render_destroy(r);
    }
}
static void cancelled_and_taken_up_again(void) {
    static float p[FLOATS], half[FLOATS];
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 5, 5);
    for (i = 0; i < 8; i++) {
        pt_render_desc d = desc();
        watcher w = { NULL, 0, 0, 0, 0, 0, 0 };
        pt_render *r;
        int k, rounds = 0, untouched = 0;
        d.tile = 8; d.threads = 1 + i % 3; d.progress = watch; d.user = &w;
        w.cancel_at = 1 + (int)(pt_rng_u32(&rng) % 30);
        r = pt_render_create(room, &d);
        CHECK_EQ_INT(pt_render_run(r), PT_CANCELLED);
        CHECK_EQ_INT(pt_render_work(r), PT_CANCELLED);
        copy_pixels(r, half);
        for (k = 0; k < FLOATS; k += 3) untouched += half[k] == 0 && half[k + 1] == 0 && half[k + 2] == 0;
        CHECK(untouched < W * H && untouched > 0);
        while (rounds++ < 50) {                          /* stopped again and again */
            w.last = 0; w.calls = 0; w.cancel_at = rounds < 3 ? 3 : 0;
            CHECK_EQ_INT(pt_render_add_samples(r, 0), PT_OK);
            if (pt_render_run(r) == PT_OK) break;
        }
        CHECK(rounds == 3);
        copy_pixels(r, p);
        same(p, whole);
        CHECK_EQ_INT(pt_render_stats(r).paths, W * H * SPP);
        pt_render_destroy(r);
    }
}

#ifndef PT_NO_THREADS
/* ---- with threads of the host's ---- */

/* The sky's callback cancels while paths go ahead of the picture; they start again, and the picture is as it would have been. */
static struct { pt_render *r; int calls; } stopper;
static pt_vec3 stopping_sky(void *user, pt_vec3 d) {
    (void)user;
    if (stopper.r && ++stopper.calls == 300) pt_render_cancel(stopper.r);
    return pt_v3(d.x > 0.8f ? 5.0f : 0.5f, 1, 1);
}
static void cancelled_while_it_learns(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = desc();
    float p[2][3 * 16 * 16];
    int k;
    d.width = d.height = 16; d.threads = 1;
    pt_add_box(s, pt_v3(-1, 0, -1), pt_v3(1, 1, 1), NULL, pt_add_material(s, &(pt_material_desc){ .color = { .5f, .5f, .5f } }));
    pt_add_light(s, &(pt_light_desc){ .radiance = stopping_sky });
    if (!CHECK(pt_scene_commit(s) == PT_OK)) return;
    for (k = 0; k < 2; k++) {
        pt_render *r = pt_render_create(s, &d);
        stopper.r = k ? r : NULL;
        stopper.calls = 0;
        if (k) {
            CHECK_EQ_INT(pt_render_run(r), PT_CANCELLED);
            CHECK_EQ_INT(pt_render_stats(r).paths, 0);   /* so that was before the picture */
            CHECK_EQ_INT(pt_render_add_samples(r, 0), PT_OK);
        }
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        memcpy(p[k], pt_render_pixels(r), sizeof p[k]);
        stopper.r = NULL;
        pt_render_destroy(r);
    }
    CHECK(!memcmp(p[0], p[1], sizeof p[0]));
    pt_scene_destroy(s);
}
static void *host_thread(void *arg) {
    pt_render *r = (pt_render *)arg;
    pt_result result;
    while ((result = pt_render_work(r)) == PT_MORE) {}
    return result == PT_OK || result == PT_CANCELLED ? arg : NULL;
}
static void hosts_own_threads(void) {
    static float p[FLOATS];
    pthread_t t[5];
    void *result;
    pt_render_desc d = desc();
    pt_render *r;
    int i;
    d.tile = 8;
    r = pt_render_create(room, &d);
    for (i = 0; i < 5; i++) CHECK(pthread_create(&t[i], NULL, host_thread, r) == 0);
    for (i = 0; i < 20; i++) { pt_render_pixels(r); pt_render_stats(r); }        /* a viewer */
    for (i = 0; i < 5; i++) { pthread_join(t[i], &result); CHECK(result == r); }
    copy_pixels(r, p);
    same(p, whole);
    pt_render_destroy(r);
}
static void *run_thread(void *arg) { return pt_render_run((pt_render *)arg) == PT_CANCELLED ? arg : NULL; }
static void nap(double seconds) {
    double end = pti_seconds() + seconds;
    while (pti_seconds() < end) {}
}
static void cancel_from_another_thread(void) {
    pthread_t t;
    void *result = NULL;
    pt_render_desc d = desc();
    pt_render *r;
    double start;
    const float *p;
    int i, lit = 0;
    d.width = 4; d.height = 1000; d.spp = 5000; d.tile = 1000; d.threads = 1;          /* one tile of 20 million paths: it is a row that ends */
    r = pt_render_create(room, &d);
    CHECK(pthread_create(&t, NULL, run_thread, r) == 0);
    nap(0.02);
    start = pti_seconds();
    pt_render_cancel(r);
    pthread_join(t, &result);
    CHECK(pti_seconds() - start < 2);
    CHECK(result == r);
    pt_render_destroy(r);
    d = desc();
    d.spp = 2000; d.tile = 4;
    r = pt_render_create(room, &d);
    CHECK(pthread_create(&t, NULL, run_thread, r) == 0);
    for (i = 0; i < 200 && pt_render_stats(r).paths < 4 * 4 * 2000; i++) nap(0.01);
    start = pti_seconds();
    pt_render_cancel(r);
    pthread_join(t, &result);
    CHECK(pti_seconds() - start < 2);
    CHECK(result == r);
    p = pt_render_pixels(r);
    for (lit = i = 0; i < FLOATS; i++) lit += p[i] > 0;
    CHECK(lit >= 16);                                    /* what was finished stays */
    pt_render_destroy(r);
}
/* A thread that is still in a tile when its render was cancelled must not meet another one there. */
static void no_more_samples_while_somebody_renders(void) {
    pthread_t t;
    void *result;
    int i, refused = 0;
    for (i = 0; i < 20; i++) {
        pt_render_desc d = desc();
        pt_render *r;
        pt_result got;
        d.width = 4; d.height = 4; d.spp = 3000; d.tile = 4; d.max_depth = 4;            /* one tile, rows of some ms */
        r = pt_render_create(room, &d);
        CHECK(pthread_create(&t, NULL, host_thread, r) == 0);
        nap(0.003);
        pt_render_cancel(r);
        got = pt_render_add_samples(r, 0);               /* here the thread is in the tile's second or third row */
        refused += got == PT_ERR_STATE;
        if (got == PT_OK) while (pt_render_work(r) == PT_MORE) {}
        pthread_join(t, &result);
        if (got == PT_OK) CHECK(pt_render_stats(r).paths <= 4 * 4 * 3000);
        pt_render_destroy(r);
    }
    CHECK(refused > 0);
}
static void two_renders_at_once(void) {
    static float p[2][FLOATS], alone[FLOATS];
    pthread_t t[2];
    pt_render *r[2];
    pt_render_desc d = desc();
    int i;
    d.seed = 99;
    render(&d, alone);
    r[0] = pt_render_create(room, &d);
    d.seed = 7;
    r[1] = pt_render_create(room, &d);
    for (i = 0; i < 2; i++) CHECK(pthread_create(&t[i], NULL, run_thread, r[i]) == 0);
    for (i = 0; i < 2; i++) pthread_join(t[i], NULL);
    for (i = 0; i < 2; i++) { copy_pixels(r[i], p[i]); pt_render_destroy(r[i]); }
    same(p[0], alone);
    same(p[1], whole);
}
#endif

/* ---- the host's floating-point mode ---- */

static void host_flushes_denormals(void) {
#if defined(PTI_X86)
    static float p[FLOATS];
    static const unsigned modes[] = { 0x8040, 0x6000, 0x2000, 0x4000, 0xe040 };  /* FTZ and DAZ; towards 0, down, up; all */
    unsigned old = _mm_getcsr(), k;
    for (k = 0; k < sizeof modes / sizeof modes[0]; k++) {
        unsigned mode = 0x1f80 | modes[k];
        pt_scene *in = inner, *out = room;
        pt_render_desc d = desc();
        test_case("mxcsr %04x", mode);
        _mm_setcsr(mode);
        scenes_make();
        render(&d, p);
        CHECK((_mm_getcsr() & 0xffc0) == mode);
        scenes_free();
        _mm_setcsr(old);
        inner = in; room = out;
        same(p, whole);
    }
#else
    SKIP("no MXCSR here");
#endif
}

/* ---- what is refused ---- */

typedef struct heard { int count; char text[256]; } heard;
static void hear(void *user, pt_result code, const char *message) {
    heard *h = (heard *)user;
    if (code < 0) h->count++;
    snprintf(h->text, sizeof h->text, "%s", message);
}
static void bad_descriptions(void) {
    static const char *const want[] = { "width is 0", "width is -5", "height is 65537", "spp is -1", "max_depth is -3", "tile is -32", "threads is -1",
        "threads is 5000", "first_sample is -1", "first_sample is", "sampler is 9", "camera.eye", "camera.target", "camera.up", "vfov_deg", "vfov_deg",
        "aperture", "aperture", "focus", "\"avx9\" is none of", "\"neon\" is not there", "weights.bsdf", "weights.lights", "weights.environment",
        "crop_x is -1", "crop_x is 50", "crop_y is 37", "crop_width is 41, it must be 1 to 40", "crop_height is -1", "filter is 6", "filter_radius",
        "filter_radius", "camera.projection is 4", "camera.height", "camera.blades is 2, it must be 3 to 16", "camera.blades is 17", "blade_rotation_deg",
        "shift_x must be within", "shift_y must be 0", "distortion must be within", "distortion", "distortion must be 0", "aberration", "vignetting must be between",
        "vignetting must be 0", "shutter_open", "shutter_close", "shutter_close", "camera.moving is 2", "camera.moving needs", "eye_end", "target_end", "up_end",
        "vfov_deg must be up to 360", "vfov_deg must be below 180" };
    volatile float zero = 0;
    heard h = { 0, "" };
    pt_scene_desc sd = { { NULL, NULL, NULL }, { hear, NULL } };
    pt_scene *s;
    pt_render *r;
    int i, n = (int)(sizeof want / sizeof want[0]);
    sd.logger.user = &h;
    s = pt_scene_create(&sd);
    pt_scene_commit(s);
    for (i = 0; i < n; i++) {
        pt_render_desc d = desc();
        float nan = zero / zero;
        switch (i) {
        case 0: d.width = 0; break;
        case 1: d.width = -5; break;
        case 2: d.height = 65537; break;
        case 3: d.spp = -1; break;
        case 4: d.max_depth = -3; break;
        case 5: d.tile = -32; break;
        case 6: d.threads = -1; break;
        case 7: d.threads = 5000; break;
        case 8: d.first_sample = -1; break;
        case 9: d.first_sample = 0x7fffffff; break;
        case 10: d.sampler = (pt_sampler)9; break;
        case 11: d.camera.eye.y = nan; break;
        case 12: d.camera.target.z = (float)HUGE_VAL; break;
        case 13: d.camera.up.x = nan; break;
        case 14: d.camera.vfov_deg = 180; break;
        case 15: d.camera.vfov_deg = nan; break;
        case 16: d.camera.aperture = -1; break;
        case 17: d.camera.aperture = nan; break;
        case 18: d.camera.focus = nan; break;
        case 19: d.isa = "avx9"; break;
        case 20: d.isa = "neon"; if (pti_isa_supported(PTI_NEON_ISA)) continue; break;
        case 21: d.weights.bsdf = -1; break;
        case 22: d.weights.lights = nan; break;
        case 23: d.weights.environment = (float)HUGE_VAL; break;
        case 24: d.crop_x = -1; break;
        case 25: d.crop_x = W; break;
        case 26: d.crop_y = H; break;
        case 27: d.crop_x = 10; d.crop_width = W - 9; break;
        case 28: d.crop_height = -1; break;
        case 29: d.filter = (pt_filter)6; break;
        case 30: d.filter_radius = nan; break;
        case 31: d.filter_radius = 65; break;
        case 32: d.camera.projection = (pt_projection)4; break;
        case 33: d.camera.height = nan; break;
        case 34: d.camera.blades = 2; break;
        case 35: d.camera.blades = 17; break;
        case 36: d.camera.blade_rotation_deg = nan; break;
        case 37: d.camera.shift_x = nan; break;
        case 38: d.camera.shift_y = 0.1f; d.camera.projection = PT_CAMERA_FISHEYE; break;
        case 39: d.camera.distortion = nan; break;
        case 40: d.camera.distortion = -0.2f; break;                 /* folds back in the corners */
        case 41: d.camera.distortion = 0.1f; d.camera.projection = PT_CAMERA_EQUIRECTANGULAR; break;
        case 42: d.camera.aberration = 1; break;
        case 43: d.camera.vignetting = 2; break;
        case 44: d.camera.vignetting = 1; d.camera.projection = PT_CAMERA_ORTHOGRAPHIC; break;
        case 45: d.camera.shutter_open = nan; break;
        case 46: d.camera.shutter_open = 1; break;
        case 47: d.camera.shutter_close = nan; break;
        case 48: d.camera.moving = 2; break;
        case 49: d.camera.moving = 1; break;
        case 50: d.camera.eye_end.x = nan; break;
        case 51: d.camera.target_end.y = (float)HUGE_VAL; break;
        case 52: d.camera.up_end.z = nan; break;
        case 53: d.camera.projection = PT_CAMERA_FISHEYE; d.camera.vfov_deg = 361; break;
        case 54: d.camera.projection = PT_CAMERA_ORTHOGRAPHIC; d.camera.vfov_deg = 180; break;
        }
        test_case("%s", want[i]);
        h.count = 0;
        r = pt_render_create(s, &d);
        if (!CHECK(r != NULL)) continue;
        if (!CHECK(strstr(pt_render_error(r), want[i]) != NULL)) FAIL("it says \"%s\"", pt_render_error(r));
        CHECK(h.count == 1);
        CHECK_STR(h.text, pt_render_error(r));
        CHECK_EQ_INT(pt_render_run(r), PT_ERR_ARG);
        CHECK_EQ_INT(pt_render_work(r), PT_ERR_ARG);
        CHECK_EQ_INT(pt_render_add_samples(r, 1), PT_ERR_ARG);
        CHECK(pt_render_pixels(r) == NULL);
        CHECK(pt_render_stats(r).paths == 0);
        pt_render_cancel(r);
        pt_render_destroy(r);
    }
    test_case("NULL");
    r = pt_render_create(NULL, NULL);
    CHECK(r && pt_render_run(r) == PT_ERR_ARG && strstr(pt_render_error(r), "scene"));
    pt_render_destroy(r);
    r = pt_render_create(s, NULL);
    CHECK(r && pt_render_run(r) == PT_ERR_ARG && strstr(pt_render_error(r), "description"));
    pt_render_destroy(r);
    pt_scene_destroy(s);
}
static void bad_merges(void) {
    pt_render_desc d = desc(), e = d, bad = d;
    pt_render *a, *b, *c, *f;
    e.width++;
    bad.spp = -1;
    {   /* crops must be the same too */
        pt_render_desc left = d, right = d;
        pt_render *l, *q;
        left.crop_width = right.crop_width = 10; right.crop_x = 20;
        left.spp = right.spp = 1;
        l = pt_render_create(room, &left); q = pt_render_create(room, &right);
        CHECK_EQ_INT(pt_render_run(l), PT_OK);
        CHECK_EQ_INT(pt_render_run(q), PT_OK);
        CHECK_EQ_INT(pt_render_merge(l, q), PT_ERR_ARG);
        pt_render_destroy(l); pt_render_destroy(q);
    }
    a = pt_render_create(room, &d); b = pt_render_create(room, &d); c = pt_render_create(room, &e); f = pt_render_create(room, &bad);
    CHECK(pt_render_merge(a, NULL) < 0 && pt_render_merge(NULL, a) < 0);
    CHECK_EQ_INT(pt_render_merge(a, a), PT_ERR_ARG);
    CHECK_EQ_INT(pt_render_merge(a, c), PT_ERR_ARG);
    CHECK_EQ_INT(pt_render_merge(a, f), PT_ERR_ARG);
    CHECK_EQ_INT(pt_render_merge(f, a), PT_ERR_ARG);
    pt_render_destroy(a); pt_render_destroy(b); pt_render_destroy(c); pt_render_destroy(f);
}
static void extreme_shapes_of_pictures(void) {           /* one pixel, one row, one column; more tiles and threads than pixels */
    static const int size[][2] = { { 1, 1 }, { 300, 1 }, { 1, 300 }, { 33, 2 } };
    int i;
    for (i = 0; i < 4; i++) {
        pt_render_desc d = desc();
        pt_render *r;
        int k, bad = 0;
        d.width = size[i][0]; d.height = size[i][1]; d.threads = 9; d.tile = i % 2 ? 65536 : 1; d.spp = 1;
        r = pt_render_create(room, &d);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        for (k = 0; k < 3 * d.width * d.height; k++) bad += !(pt_render_pixels(r)[k] >= 0);
        CHECK_EQ_INT(bad, 0);
        CHECK_EQ_INT(pt_render_stats(r).paths, d.width * d.height);
        CHECK_EQ_INT(pt_render_stats(r).discarded, 0);
        pt_render_destroy(r);
    }
}
static int light_is_bad(void *user) { return *(int *)user; }
static pt_vec3 bad_radiance(void *user, pt_vec3 d) {
    volatile float zero = 0;
    (void)d;
    switch (light_is_bad(user)) {
    case 0: return pt_v3(1, zero / zero, 1);
    case 1: return pt_v3((float)HUGE_VAL, 1, 1);
    case 2: return pt_v3(1, 1, -1);
    case 3: return pt_v3(1e13f, 1, 1);
    default: return pt_v3(1, 2, 3);
    }
}
static void unfit_samples_are_counted(void) {
    int kind, i;
    for (kind = 0; kind < 5; kind++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render *r;
        pt_render_desc d = desc();
        const float *p;
        pt_add_light(s, &(pt_light_desc){ .radiance = bad_radiance, .user = &kind });
        CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
        d.spp = 2;
        r = pt_render_create(s, &d);
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        CHECK_EQ_INT(pt_render_stats(r).discarded, kind < 4 ? 2 * W * H : 0);
        p = pt_render_pixels(r);
        for (i = 0; i < FLOATS; i++) if (p[i] != (kind < 4 ? 0 : (float)(1 + i % 3))) { FAIL("a pixel is %g", (double)p[i]); break; }
        pt_render_destroy(r);
        pt_scene_destroy(s);
    }
}

/* ---- the samplers agree ---- */

#define BLOCKS 9
static void samplers_agree(void) {                       /* means over 3 x 3 blocks of the picture, of independent seeds, by t-tests */
    static float p[FLOATS];
    stats_moments m[3][BLOCKS];
    int kind, i, k, x, y;
    memset(m, 0, sizeof m);
    for (kind = 0; kind < 3; kind++)
        for (i = 0; i < 30; i++) {
            double sum[BLOCKS] = { 0 }, n[BLOCKS] = { 0 };
            pt_render_desc d = desc();
            d.sampler = samplers[kind]; d.seed = (uint64_t)(1000 * kind + i); d.spp = 4;
            render(&d, p);
            for (y = 0; y < H; y++) for (x = 0; x < W; x++) for (k = 0; k < 3; k++) {
                sum[3 * (3 * y / H) + 3 * x / W] += (double)p[3 * (y * W + x) + k];
                n[3 * (3 * y / H) + 3 * x / W]++;
            }
            for (k = 0; k < BLOCKS; k++) stats_push(&m[kind][k], sum[k] / n[k]);
        }
    for (k = 0; k < BLOCKS; k++) {
        test_case("block %d", k);
        CHECK_P(stats_welch_test(&m[0][k], &m[1][k]));
        CHECK_P(stats_welch_test(&m[0][k], &m[2][k]));
        CHECK_P(stats_welch_test(&m[1][k], &m[2][k]));
        CHECK(stats_error(&m[0][k]) / m[0][k].mean < 0.02);
    }
}

void test_render(void) {
    scenes_make();
    { pt_render_desc d = desc(); pt_render *r = pt_render_create(room, &d); if (pt_render_run(r) == PT_OK) memcpy(whole, pt_render_pixels(r), sizeof whole); pt_render_destroy(r); }
    RUN(same_bits_for_any_threads_and_tiles);
    RUN(same_bits_for_any_isa);
    RUN(merged_ranges_equal_the_whole);
    RUN(stratified_ranges_of_one_length);
    RUN(added_samples_equal_the_whole);
    RUN(crops_are_parts_of_the_whole);
    RUN(same_bits_with_every_feature);
    RUN(progress_rises_to_one);
    RUN(cancelled_and_taken_up_again); RUN(cancelled_while_it_learns);
#ifndef PT_NO_THREADS
    RUN(hosts_own_threads);
    RUN(cancel_from_another_thread);
    RUN(no_more_samples_while_somebody_renders);
    RUN(two_renders_at_once);
#endif
    RUN(host_flushes_denormals);
    RUN(bad_descriptions);
    RUN(bad_merges);
    RUN(extreme_shapes_of_pictures);
    RUN(unfit_samples_are_counted);
    RUN(samplers_agree);
    scenes_free();
}
