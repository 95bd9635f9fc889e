/* >>path: the estimator against closed forms: emissive boxes, furnaces, series cut short, direct light, counts of rays. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

static const pt_weights naive = { 1, 0, 0 };

static pt_material glowing(pt_scene *s, float r, float g, float b, float radiance) {
    return pt_add_material(s, &(pt_material_desc){ .color = { r, g, b }, .emission = { radiance, radiance, radiance }, .two_sided = 1 });
}
/* The cube [-1,1]^3, all of it albedo a and emission Le. */
static pt_scene *glowing_box(float r, float g, float b, float radiance) {
    pt_scene *s = pt_scene_create(NULL);
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, glowing(s, r, g, b, radiance));
    commit(s);
    return s;
}
/* Moments over the pixels of one channel, at most 64 x 64. */
static stats_moments channel(const float *rgb, int pixels, int c) {
    stats_moments m = { 0, 0, 0 };
    int i;
    for (i = 0; i < pixels; i++) stats_push(&m, rgb[3 * i + c]);
    return m;
}
static float rgb[64 * 64 * 3], other[64 * 64 * 3];

/* A t-test, and the mean within a part of what it should be. */
static void check_within(const stats_moments *m, double expected, double part) {
    CHECK_P(fabs(m->mean - expected) <= 2e-5 * expected ? 1.0 : stats_t_test(m, expected));
    CHECK_NEAR(m->mean, expected, part * expected);
    CHECK(stats_error(m) <= 1.2 * part * expected);      /* that was no luck */
}
/* All pixels, one by one. */
static void check_all(const float *p, int pixels, double r, double g, double b, double part) {
    int i;
    for (i = 0; i < pixels; i++) {
        CHECK_NEAR(p[3 * i], r, part * r); CHECK_NEAR(p[3 * i + 1], g, part * g); CHECK_NEAR(p[3 * i + 2], b, part * b);
    }
}

/* ---- emissive boxes: L = Le (1 + a + a^2 + ...) everywhere ---- */

static void emissive_box(void) {
    static const float eyes[4][3] = { { 0, 0, 0 }, { 0.9f, -0.8f, 0.7f }, { -0.99f, 0.99f, -0.99f }, { 0.2f, -0.999f, 0.1f } };
    pt_scene *s = glowing_box(0.3f, 0.5f, 0.9f, 2);
    stats_moments all[3];
    int k, c, i;
    memset(all, 0, sizeof all);
    for (k = 0; k < 4; k++) {                            /* the brightest channel is the noisiest: each path lives for it */
        pt_render_desc d = view(pt_v3(eyes[k][0], eyes[k][1], eyes[k][2]), pt_v3(0.1f, 0.3f, -0.2f), 100, 64, 56);
        d.max_depth = 4000;
        d.weights = naive;
        d.seed = (uint64_t)k;
        if (!render(s, &d, rgb, NULL)) break;
        for (i = 0; i < 64 * 64; i++) for (c = 0; c < 3; c++) stats_push(&all[c], rgb[3 * i + c]);
    }
    check_within(&all[0], 2 / (1 - 0.3), 1e-3);
    check_within(&all[1], 2 / (1 - 0.5), 1e-3);
    check_within(&all[2], 2 / (1 - 0.9), 1e-3);
    pt_scene_destroy(s);
}
/* Grey, so that roulette looks at the channel itself; with lights drawn, and without. */
static void emissive_box_grey(void) {
    static const float albedo[] = { 0.3f, 0.5f, 0.9f };
    int k, w;
    for (k = 0; k < 3; k++) for (w = 0; w < 2; w++) {
        pt_scene *s = glowing_box(albedo[k], albedo[k], albedo[k], 1);
        pt_render_desc d = view(pt_v3(0.3f, 0.2f, 0.4f), pt_v3(1, -1, -1), 90, 64, w ? 32 : 24);
        stats_moments m;
        test_case("albedo %g, %s", (double)albedo[k], w ? "mixture" : "naive");
        d.max_depth = 4000;
        d.seed = 101;
        if (!w) d.weights = naive;
        m = render_pixels(s, &d);
        check_within(&m, 1 / (1 - (double)albedo[k]), 6e-3);
        pt_scene_destroy(s);
    }
}
static void emissive_box_cut_short(void) {
    static const float albedo[] = { 0.3f, 0.5f, 0.9f };
    static const int depth[] = { 1, 2, 5 };
    int k, n, w;
    for (k = 0; k < 3; k++) for (n = 0; n < 3; n++) for (w = 0; w < 2; w++) {
        double a = albedo[k];
        pt_scene *s = glowing_box(albedo[k], albedo[k], albedo[k], 1);
        pt_render_desc d = view(pt_v3(-0.3f, 0.2f, 0.4f), pt_v3(1, -1, -1), 90, 64, w ? 6 : 16);
        stats_moments m;
        test_case("albedo %g, depth %d, %s", a, depth[n], w ? "mixture" : "naive");
        d.max_depth = depth[n];
        if (!w) d.weights = naive;
        m = render_pixels(s, &d);
        check_within(&m, (1 - pow(a, depth[n] + 1)) / (1 - a), 6e-3);
        if (depth[n] == 1 && !w) CHECK_NEAR(m.mean, 1 + a, 1e-5);      /* no roulette yet, no noise */
        pt_scene_destroy(s);
    }
}
/* Where albedos are below the least q, where they are just above, and where only one channel is bright. */
static void roulette_in_the_dark(void) {
    static const float albedo[][3] = { { 0.01f, 0.03f, 0.02f }, { 0.05f, 0.04f, 0.001f }, { 0.06f, 0.2f, 0.02f }, { 0.02f, 0.1f, 0.8f } };
    int k, c;
    for (k = 0; k < 4; k++) {
        pt_scene *s = glowing_box(albedo[k][0], albedo[k][1], albedo[k][2], 1);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(1, -1, -1), 90, 64, 32);
        test_case("albedos %d", k);
        d.max_depth = 4000;
        d.weights = naive;
        d.seed = 7;
        if (!render(s, &d, rgb, NULL)) break;
        for (c = 0; c < 3; c++) {
            stats_moments m = channel(rgb, 64 * 64, c);
            check_within(&m, 1 / (1 - (double)albedo[k][c]), 4e-3);
        }
        pt_scene_destroy(s);
    }
}
/* The same for roulette alone: over all u, what comes through is what came in. */
static void roulette_keeps_the_mean(void) {
    static const float p[][3] = { { 0.5f, 0.2f, 0.1f }, { 0.001f, 0.002f, 0 }, { 0.999f, 0.5f, 0.3f }, { 0.05f, 0.05f, 0.05f },
                                  { 2, 0.1f, 0.1f } };
    int k, i, n = 20000;
    for (k = 0; k < 5; k++) {
        double sum = 0, potential = 0, most = 0;
        test_case("potential %d", k);
        for (i = 0; i < n; i++) {
            pt_vec3 beta = pt_v3(3, 2, 1), q = pt_v3(p[k][0], p[k][1], p[k][2]);
            if (!pti_roulette(pti_largest(q), &beta, &q, (uint32_t)((i + 0.5) / n * 4294967296.0))) continue;
            sum += beta.y; potential += q.x; most = fmax(most, (double)pti_largest(q));
        }
        CHECK_NEAR(sum / n, 2, 2e-3);
        CHECK_NEAR(potential / n, p[k][0], 1e-3 * p[k][0] + 1e-9);
        CHECK(most <= (p[k][0] > 1 ? 2 : 1 + 1e-6));
    }
}
/* A white box whose bulk of light comes by way of many walls, a lamp in it: however many rays a vertex may send on, the mean
   is that of one, and more rays are less noise. */
static void splitting_keeps_the_mean(void) {
    static const int most[4] = { 1, 2, 3, 0 };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, -0.9f), pt_v3(0, 0.2f, 1), 80, 32, 16);
    stats_moments one = { 0, 0, 0 };
    double errors[4], rays[4];
    int k;
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, diffuse(s, 0.8f));
    pt_add_quad(s, pt_v3(-0.3f, 0.99f, -0.3f), pt_v3(0.6f, 0, 0), pt_v3(0, 0, 0.6f), lamp(s, 5, 0));
    commit(s);
    for (k = 0; k < 4; k++) {
        stats_moments m = { 0, 0, 0 };
        pt_stats stats;
        int i, seed;
        test_case("up to %d", most[k]);
        d.max_split = most[k];
        rays[k] = 0;
        for (seed = 0; seed < 12; seed++) {              /* pictures' means, since pixels differ */
            double sum = 0;
            d.seed = (uint64_t)(100 * k + seed);
            if (!render(s, &d, rgb, &stats)) return;
            for (i = 0; i < 32 * 32; i++) sum += (double)rgb[3 * i] / (32 * 32);
            stats_push(&m, sum);
            rays[k] += (double)stats.rays;
        }
        errors[k] = stats_error(&m);
        if (!k) one = m;
        CHECK_P(k ? stats_welch_test(&m, &one) : 1.0);
        CHECK(!k || errors[k] < errors[0]);
        CHECK(errors[k] < 1e-2 * m.mean);                /* that was no luck */
        CHECK(!k || rays[k] > 1.5 * rays[0]);
    }
    pt_scene_destroy(s);
}
static void inside_an_emissive_sphere(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0.5f, 0.3f, 0.6f), pt_v3(-1, 0.2f, 0), 100, 64, 32);
    int c, n;
    pt_add_sphere(s, pt_v3(0, 0, 0), 1, glowing(s, 0.5f, 0.25f, 0, 3));
    commit(s);
    for (n = 1; n < 8; n = n == 1 ? 3 : 4000) {
        test_case("sphere, depth %d", n);
        d.max_depth = n;
        if (!render(s, &d, rgb, NULL)) break;
        for (c = 0; c < 3; c++) {
            double a = c == 0 ? 0.5 : c == 1 ? 0.25 : 0;
            stats_moments m = channel(rgb, 64 * 64, c);
            check_within(&m, 3 * (1 - pow(a, n + 1)) / (1 - a), 5e-3);
        }
    }
    pt_scene_destroy(s);
    test_case("a one-sided lamp from within");
    s = pt_scene_create(NULL);
    pt_add_sphere(s, pt_v3(0, 0, 0), 1, lamp(s, 3, 0));
    commit(s);
    if (render(s, &d, rgb, NULL)) check_all(rgb, 64 * 64, 0, 0, 0, 0);
    pt_scene_destroy(s);
}

/* ---- glass ---- */

/* A shell is glass without, air within; eight of them, one in the other, round the camera or before it. */
static void nested_shells_in_a_furnace(void) {
    static const float eyes[3][3] = { { 0, 0, 20 }, { 0.1f, 0.2f, 0 }, { 0, 4.7f, 0.1f } };
    pt_scene *s = pt_scene_create(NULL);
    pt_material in = glass(s, 1.5f), out = glass(s, 1 / 1.5f);
    int k;
    for (k = 1; k <= 8; k++) {
        pt_add_sphere(s, pt_v3(0, 0, 0), (float)k, in);
        pt_add_sphere(s, pt_v3(0, 0, 0), (float)k - 0.1f, out);
    }
    sky(s, 1);
    commit(s);
    for (k = 0; k < 3; k++) {
        pt_render_desc d = view(pt_v3(eyes[k][0], eyes[k][1], eyes[k][2]), pt_v3(0, 0.1f, 0), 50, 32, 4);
        stats_moments m;
        test_case("eye %d", k);
        d.max_depth = 5000;
        if (!render(s, &d, rgb, NULL)) break;
        m = channel(rgb, 32 * 32, 1);
        CHECK_NEAR(m.mean, 1, 1e-4);
        check_all(rgb, 32 * 32, 1, 1, 1, 3e-3);          /* eta^2 in and 1 / eta^2 out, rounded hundreds of times */
    }
    pt_scene_destroy(s);
}
/* Within glass, all is n^2 as bright; within balls in balls, by the product. */
static void radiance_within_glass(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 1), 90, 16, 4);
    pt_add_sphere(s, pt_v3(0, 0, 0), 2, glass(s, 1.2f));
    pt_add_sphere(s, pt_v3(0, 0, 0), 1, glass(s, 1.5f));
    sky(s, 1);
    commit(s);
    d.max_depth = 1000;
    if (render(s, &d, rgb, NULL)) check_all(rgb, 256, 2.25 * 1.44, 2.25 * 1.44, 2.25 * 1.44, 1e-4);
    d.camera.eye = pt_v3(0, 1.01f, 0.1f);
    d.camera.target = pt_v3(0, 5, 0.1f);
    d.camera.vfov_deg = 10;
    if (render(s, &d, rgb, NULL)) check_all(rgb, 256, 1.44, 1.44, 1.44, 1e-4);
    pt_scene_destroy(s);
}
/* A slab seen head on, R = 0.04, each lobe tinted c. Inside: I = c (1-R) + c R I; outside: L = c R + c (1-R) I. */
static void tinted_slab(void) {
    static const double tint[] = { 0.9, 0.5, 0.2 };
    pt_scene *s = pt_scene_create(NULL);
    pt_material m = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.5f, .color = { 0.9f, 0.5f, 0.2f } });
    pt_render_desc d = view(pt_v3(0, 0, 5), pt_v3(0, 0, 0), 0.1f, 64, 64);
    int c;
    pt_add_box(s, pt_v3(-1000, -1000, -1), pt_v3(1000, 1000, 1), NULL, m);
    sky(s, 2);
    commit(s);
    if (render(s, &d, rgb, NULL)) for (c = 0; c < 3; c++) {
        double R = 0.04, I = tint[c] * (1 - R) / (1 - tint[c] * R);
        stats_moments got = channel(rgb, 64 * 64, c);
        check_within(&got, 2 * (tint[c] * R + tint[c] * (1 - R) * I), 2e-3);
    }
    pt_scene_destroy(s);
}
/* Ten tinted panes that do not bend light: L = c^20 in all pixels, since roulette does not mind what a delta takes. */
static void roulette_passes_tinted_glass(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material m = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1, .color = { 0.5f, 0.6f, 0.4f } });
    pt_render_desc d = view(pt_v3(0, 0, 15), pt_v3(0, 0, 0), 20, 16, 4);
    pt_stats stats;
    int k;
    for (k = 0; k < 10; k++) pt_add_box(s, pt_v3(-50, -50, (float)k), pt_v3(50, 50, (float)k + 0.5f), NULL, m);
    sky(s, 1e6f);
    commit(s);
    if (render(s, &d, rgb, &stats)) {
        check_all(rgb, 256, 1e6 * pow(0.5, 20), 1e6 * pow(0.6, 20), 1e6 * pow(0.4, 20), 1e-5);
        CHECK_EQ_INT(stats.rays, 21 * stats.paths);
    }
    pt_scene_destroy(s);
}

/* ---- direct light ---- */

static void floor_of(pt_scene *s, float half, pt_material m) {
    pt_add_quad(s, pt_v3(-half, 0, half), pt_v3(2 * half, 0, 0), pt_v3(0, 0, -2 * half), m);
}
/* Under a uniform hemisphere L = albedo x Le: from the sky, and from a lamp that is a sphere all round. */
static void direct_light_of_a_hemisphere(void) {
    int k, n;
    for (k = 0; k < 3; k++) for (n = 1; n <= 3; n += 2) {
        pt_scene *s = pt_scene_create(NULL);
        pt_material white = pt_add_material(s, &(pt_material_desc){ .color = { 0.8f, 0.4f, 0.1f } });
        pt_render_desc d = view_down(pt_v3(0.2f, 0, -0.1f), 32, 16);
        test_case("light %d, depth %d", k, n);
        floor_of(s, 1, white);
        if (k == 0) sky(s, 2);
        else pt_add_sphere(s, pt_v3(0, 0, 0), 10, k == 1 ? lamp(s, 2, 1) : glowing(s, 0.5f, 0.5f, 0.5f, 2));
        commit(s);
        d.max_depth = n;
        if (k) d.weights = naive;
        if (render(s, &d, rgb, NULL) && (k < 2 || n == 1)) check_all(rgb, 32 * 32, 1.6, 0.8, 0.2, 2e-5);
        else if (k == 2) CHECK(rgb[1] > 0.8f * 1.2f);    /* more than direct light */
        pt_scene_destroy(s);
    }
}
/* A square lamp above, in a white room: depth 1 sees albedo Le F, F its closed form, and nothing of the room. */
static void direct_light_of_a_square(void) {
    double a = 0.5 / 1.5, r = sqrt(1 + a * a), F = 4 / (2 * STATS_PI) * 2 * (a / r * atan(a / r));
    int k;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 64, k == 2 ? 400 : 16);
        stats_moments m;
        test_case(k ? "walls" : "no walls");
        floor_of(s, 2, diffuse(s, 0.6f));
        if (k) pt_add_box(s, pt_v3(-2, -0.5f, -2), pt_v3(2, 3, 2), NULL, diffuse(s, 0.9f));
        pt_add_quad(s, pt_v3(-0.5f, 1.5f, -0.5f), pt_v3(1, 0, 0), pt_v3(0, 0, 1), lamp(s, 5, 0));    /* down */
        commit(s);
        if (k == 2) d.weights = naive;
        m = render_pixels(s, &d);
        check_within(&m, 0.6 * 5 * F, 3e-3);
        pt_scene_destroy(s);
    }
}
/* Two rays from a floor under a lamp and a dim sky: each keeps to its part of the mixture, so that all samples together are as
   even there as those of next-event estimation, which has numbers of its own for each. (Errors are 1.06 of its; did rays and
   parts take turns, 1.44.) */
static void rays_of_a_split_keep_to_their_parts(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view_down(pt_v3(0.3f, 0, 0.2f), 32, 64);
    stats_moments mixture, nee;
    floor_of(s, 4, diffuse(s, 0.8f));
    pt_add_quad(s, pt_v3(-0.5f, 1, -0.5f), pt_v3(1, 0, 0), pt_v3(0, 0, 1), lamp(s, 1, 0));
    sky(s, 0.1f);
    commit(s);
    mixture = render_pixels(s, &d);
    d.integrator = PT_INTEGRATOR_NEE;
    nee = render_pixels(s, &d);
    CHECK_P(stats_welch_test(&mixture, &nee));
    CHECK(stats_error(&mixture) < 1.2 * stats_error(&nee));
    pt_scene_destroy(s);
}

/* ---- nothing much ---- */

static void environment_only(void) {
    static const float map[8] = { 1, 2, 3, 4, 5, 6, 7, 8 };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(1, 2, 3), pt_v3(0, 0, 0), 60, 16, 4);
    pt_stats stats;
    pt_vec3 want;
    sky(s, 0.75f);
    commit(s);
    if (render(s, &d, rgb, &stats)) {
        check_all(rgb, 256, 0.75, 0.75, 0.75, 1e-7);
        CHECK_EQ_INT(stats.paths, 16 * 16 * 4);
        CHECK_EQ_INT(stats.rays, stats.paths);
        CHECK_EQ_INT(stats.discarded, 0);
    }
    pt_scene_destroy(s);
    s = pt_scene_create(NULL);
    pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map, 4, 2), .color = { 1, 0.5f, 0 }, .rotate_deg = 30 });
    commit(s);
    d = view(pt_v3(0, 0, 0), pt_v3(0.3f, 0.2f, -0.9f), 0.01f, 4, 1);
    want = pti_environment_radiance(&s->environment, pti_normalize(pt_v3(0.3f, 0.2f, -0.9f)), NOWHERE);
    if (render(s, &d, rgb, NULL)) check_all(rgb, 16, want.x, want.y, want.z, 1e-3);
    CHECK(want.x > 1 && want.z == 0);
    pt_scene_destroy(s);
    s = pt_scene_create(NULL);                           /* not even that */
    commit(s);
    if (render(s, &d, rgb, NULL)) check_all(rgb, 16, 0, 0, 0, 0);
    pt_scene_destroy(s);
}
static void black_surfaces(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 1, 3), pt_v3(0, 0, 0), 40, 16, 4);
    pt_stats stats;
    floor_of(s, 100, diffuse(s, 0));
    pt_add_sphere(s, pt_v3(0, 5, 0), 1, lamp(s, 10, 0));
    commit(s);
    if (render(s, &d, rgb, &stats)) {
        check_all(rgb, 256, 0, 0, 0, 0);
        CHECK_EQ_INT(stats.rays, stats.paths);
    }
    d = view(pt_v3(0, 1, 3), pt_v3(0, 5, 0), 5, 16, 4);
    if (render(s, &d, rgb, &stats)) {
        check_all(rgb, 256, 10, 10, 10, 1e-7);
        CHECK_EQ_INT(stats.rays, stats.paths);
    }
    pt_scene_destroy(s);
    s = pt_scene_create(NULL);                           /* black mirrors and black glass take all, too */
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL,
               pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .color = { 0, 0, 1e-30f } }));
    sky(s, 1);
    commit(s);
    d = view(pt_v3(0, 0, 3), pt_v3(0, 0, 0), 20, 16, 4);
    if (render(s, &d, rgb, NULL)) { CHECK(rgb[0] == 0 && rgb[1] == 0); CHECK_NEAR(rgb[2], 0, 1e-29); }
    pt_scene_destroy(s);
}
static void rays_are_counted(void) {
    static const int depth[] = { 1, 2, 5, 20 };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0.1f, 0.2f, 0.3f), pt_v3(1, 1, 1), 90, 16, 8);
    pt_stats stats;
    int k;
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, diffuse(s, 1));
    commit(s);
    for (k = 0; k < 4; k++) {                            /* white and closed: all paths go on to the limit */
        test_case("depth %d", depth[k]);
        d.max_depth = depth[k];
        if (!render(s, &d, rgb, &stats)) break;
        CHECK_EQ_INT(stats.paths, 16 * 16 * 8);
        CHECK_EQ_INT(stats.discarded, 0);
        CHECK_NEAR((double)stats.rays, (double)stats.paths * (depth[k] + 1), 2e-3 * (double)stats.rays);  /* albedo 1 - 1e-7 */
        check_all(rgb, 256, 0, 0, 0, 0);
    }
    pt_scene_destroy(s);
    s = glowing_box(0.75f, 0.75f, 0.75f, 1);             /* grey: roulette begins where a^n < 1/4, n = 5, with odds of 4 a^n */
    d.max_depth = 1000; d.spp = 256; d.weights = naive;
    if (render(s, &d, rgb, &stats)) CHECK_NEAR((double)stats.rays / (double)stats.paths, 1 + 5 + 4 * pow(0.75, 5) / 0.25, 0.05);
    d.roulette = PT_ROULETTE_NONE; d.max_depth = 30; d.spp = 4;
    if (render(s, &d, rgb, &stats)) CHECK_EQ_INT(stats.rays, 31 * stats.paths);
    pt_scene_destroy(s);
}
static void depth_does_not_matter_once_large(void) {
    static const int depth[] = { 0, 64, 200, 100000 };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0.1f, 0.2f, 0.3f), pt_v3(1, -1, 1), 90, 16, 16);
    int k;
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(0.3f, 0.6f, 0), 0.2f, lamp(s, 4, 0));
    pt_add_sphere(s, pt_v3(-0.5f, -0.6f, 0), 0.3f, mirror(s, 0.8f));
    commit(s);
    if (render(s, &d, rgb, NULL)) for (k = 0; k < 4; k++) {
        test_case("depth %d", depth[k]);
        d.max_depth = depth[k];
        if (render(s, &d, other, NULL)) CHECK(!memcmp(rgb, other, 16 * 16 * 3 * sizeof *rgb));
    }
    test_case("depth 2");
    d.max_depth = 2;
    if (render(s, &d, other, NULL)) CHECK(memcmp(rgb, other, 16 * 16 * 3 * sizeof *rgb));
    pt_scene_destroy(s);
}

void test_path(void) {
    RUN(emissive_box); RUN(emissive_box_grey); RUN(emissive_box_cut_short); RUN(roulette_in_the_dark);
    RUN(roulette_keeps_the_mean); RUN(splitting_keeps_the_mean); RUN(inside_an_emissive_sphere);
    RUN(nested_shells_in_a_furnace); RUN(radiance_within_glass); RUN(tinted_slab); RUN(roulette_passes_tinted_glass);
    RUN(direct_light_of_a_hemisphere); RUN(direct_light_of_a_square); RUN(rays_of_a_split_keep_to_their_parts);
    RUN(environment_only); RUN(black_surfaces); RUN(rays_are_counted); RUN(depth_does_not_matter_once_large);
}
