/* >>path, the integrators and the limits: next-event estimation has the mean that all others have, limits cut where they say. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "agreement.h"

/* ---- agreement: naive = mixture = NEE = NEE to all ---- */

static const struct { const char *name; pt_integrator integrator; pt_weights weights; } ways[] = {
    { "naive",   PT_INTEGRATOR_MIXTURE, { 1, 0, 0 } },
    { "mixture", PT_INTEGRATOR_MIXTURE, { 0, 0, 0 } },
    { "nee",     PT_INTEGRATOR_NEE,     { 0, 0, 0 } },
    { "nee all", PT_INTEGRATOR_NEE_ALL, { 0, 0, 0 } },
};
/* The naive one, which may have no densities (plain), gets more samples. */
static void integrators_agree(const char *name, scene_builder *build, scene_builder *plain, int naive_spp, int last) {
    stats_moments reference[BLOCKS], m[BLOCKS];
    int k;
    memset(reference, 0, sizeof reference);
    for (k = 0; k <= last; k++) {
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, k ? 32 : naive_spp);
        char what[100];
        inner = (k ? build : plain)(s, &d);
        d.weights = ways[k].weights;
        d.integrator = ways[k].integrator;
        memset(m, 0, sizeof m);
        if (!commit(s)) return;
        push_blocks(k ? m : reference, s, &d, k ? 16 : 32, (uint64_t)(1000 * (k + 2)));
        snprintf(what, sizeof what, "%s, naive and %s", name, ways[k].name);
        if (k) compare_blocks(what, m, reference);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
/* A lamp in a glass ball, one in a box of rough glass, seen by a glossy floor. */
static pt_scene *lamps_behind_glass(pt_scene *s, pt_render_desc *d) {
    floor_of(s, 5, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.5f, 0.4f, 0.3f }, .roughness = 0.4f }));
    pt_add_sphere(s, pt_v3(-0.8f, 0.8f, 0), 0.7f, glass(s, 1.5f));
    pt_add_sphere(s, pt_v3(-0.8f, 0.8f, 0), 0.4f, lamp(s, 3, 0));
    pt_add_box(s, pt_v3(0.3f, 0.1f, -0.6f), pt_v3(1.5f, 1.3f, 0.6f), NULL,
               pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.3f, .roughness = 0.5f }));
    pt_add_sphere(s, pt_v3(0.9f, 0.7f, 0), 0.4f, lamp(s, 3, 0));
    d->camera.eye = pt_v3(0, 2, 3.5f); d->camera.target = pt_v3(0, 0.5f, 0); d->camera.vfov_deg = 45;
    return NULL;
}
/* What lets light straight through stops the rays that are drawn from lights: lamps in boxes of nothing, behind a screen with
   holes, behind a thin pane and a half-transparent one that glows itself, before a lamp that is nowhere hidden. */
static pt_scene *lamps_behind_nothing(pt_scene *s, pt_render_desc *d) {
    static const float holes[4] = { 1, 0, 0, 1 };
    pt_material none = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_NONE });
    pt_texture cut = pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 2, .channels = 1, .bits = 32, .pixels = holes,
                                                           .nearest = 1, .uv_scale = { 3, 3 } });
    floor_of(s, 5, diffuse(s, 0.6f));
    pt_add_box(s, pt_v3(-1.6f, 0.1f, -0.5f), pt_v3(-0.6f, 1.1f, 0.5f), NULL, none);
    pt_add_sphere(s, pt_v3(-1.1f, 0.6f, 0), 0.4f, lamp(s, 3, 0));
    quad(s, -0.5f, 1, -0.5f, 1, 0, 0, 0, 0, 1, pt_add_material(s, &(pt_material_desc){ .color = { 0.5f, 0.5f, 0.5f }, .opacity_texture = cut }));
    quad(s, -0.4f, 1.4f, -0.4f, 0.8f, 0, 0, 0, 0, 0.8f, lamp(s, 5, 0));
    quad(s, 0.6f, 0.8f, -0.5f, 1, 0, 0, 0, 0, 1,
         pt_add_material(s, &(pt_material_desc){ .color = { 0.4f, 0.3f, 0.2f }, .transparency = 0.5f, .emission = { 1, 2, 1 } }));
    quad(s, 0.7f, 1.3f, -0.4f, 0.8f, 0, 0, 0, 0, 0.8f, lamp(s, 6, 0));
    pt_add_sphere(s, pt_v3(0, 0.4f, 0.8f), 0.3f, lamp(s, 1, 0));
    d->camera.eye = pt_v3(0, 2.5f, 3.5f); d->camera.target = pt_v3(0, 0.2f, 0); d->camera.vfov_deg = 50;
    return NULL;
}
/* Sun, sky, lamps, a spot, one in motion that no density knows: on rough metal, too. */
static pt_scene *all_that_shines(pt_scene *s, pt_render_desc *d) {
    static const pt_xform from = { { 1, 0, 0, -1.5f,  0, 1, 0, 0.8f,  0, 0, 1, 0.5f } }, to = { { 1, 0, 0, -1,  0, 1, 0, 1,  0, 0, 1, 0.5f } };
    pt_scene *one = pt_scene_create(NULL);
    pt_add_sphere(one, pt_v3(0, 0, 0), 0.4f, lamp(one, 2, 0));
    commit(one);
    pt_add_moving_instance(s, one, &from, &to);
    floor_of(s, 5, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(0, 0.5f, 0), 0.5f, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { 0.9f, 0.7f, 0.5f },
                                                                                      .roughness = 0.4f }));
    quad(s, 0.8f, 1.2f, -0.5f, 0.8f, 0, 0, 0, 0, 0.8f, lamp(s, 3, 1));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SPOT, .position = { 0, 2, 0.6f }, .radius = 0.4f, .cone_deg = 60, .blend = 0.5f,
                                      .color = { 20, 20, 20 }, .direction = { 0.2f, -1, 0 } });
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { -1, -1, 0.5f }, .radius_deg = 25, .color = { 1, 1, 0.8f } });
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { -0.8f, -1, 0.2f }, .radius_deg = 15, .color = { 0.3f, 0.3f, 0.8f } });
    sunny(s, 0.3f, 0);
    d->camera.eye = pt_v3(0, 2, 3.5f); d->camera.target = pt_v3(0, 0.4f, 0); d->camera.vfov_deg = 45;
    d->camera.shutter_close = 1;
    return one;
}
/* Lamps with pictures, one a mix of two lamps, and a glow on what scatters, before mirrors. */
static pt_scene *textured_lamps(pt_scene *s, pt_render_desc *d) {
    static const float pixels[8] = { 0, 4, 1, 2, 3, 0, 0, 5 };
    pt_texture t = grey_map(s, pixels, 4, 2);
    pt_material shown = pt_add_material(s, &(pt_material_desc){ .emission_texture = t }), both;
    both = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = shown, .b = lamp(s, 1, 0), .mix = 0.3f });
    floor_of(s, 5, pt_add_material(s, &(pt_material_desc){ .color = { 0.5f, 0.5f, 0.5f }, .roughness = 1 }));
    quad(s, -1.5f, 1.5f, -0.5f, 1.3f, 0, 0, 0, 0, 1, shown);
    quad(s, -1, 0, -1.2f, 2, 0, 0, 0, 1.5f, 0, mirror(s, 0.9f));
    pt_add_sphere(s, pt_v3(0.7f, 1, 0), 0.5f, both);
    pt_add_sphere(s, pt_v3(-0.3f, 0.4f, 0.3f), 0.4f,
                  pt_add_material(s, &(pt_material_desc){ .color = { 0.5f, 0.2f, 0.2f }, .emission = { 0.5f, 0.2f, 0.2f }, .emission_texture = t }));
    d->camera.eye = pt_v3(0.5f, 2, 3.5f); d->camera.target = pt_v3(0, 0.5f, 0); d->camera.vfov_deg = 45;
    return NULL;
}
#define AGREES(name, build, plain, spp) static void name(void) { integrators_agree(#build, build, plain, spp, 3); }
AGREES(agrees_in_cornell_box, cornell, cornell, 96)
AGREES(agrees_by_the_wall, sphere_by_the_wall, sphere_by_the_wall, 64)
AGREES(agrees_on_hidden_lights, one_behind_the_other, one_behind_the_other, 96)
static void agrees_on_a_mesh_light(void) { integrators_agree("torus", glowing_torus, glowing_torus, 64, 2); }     /* 576 lamps */
AGREES(agrees_under_the_sun, sun_and_mesh, sun_and_mesh, 64)
AGREES(agrees_on_suns_in_gloss, suns_in_gloss, suns_in_gloss, 96)
AGREES(agrees_on_mirror_and_glass, sky_lamps_mirror_glass, sky_lamps_mirror_glass, 96)
AGREES(agrees_on_instances, instanced_lamps, instanced_lamps, 96)
AGREES(agrees_in_a_closed_room, closed_room, closed_room, 64)
AGREES(agrees_with_densities, densities, two_by_the_wall, 96)
AGREES(agrees_through_a_lens, lens_and_depth, lens_and_depth, 64)
AGREES(agrees_in_a_white_room, white_room, white_room, 64)
AGREES(agrees_behind_glass, lamps_behind_glass, lamps_behind_glass, 96)
AGREES(agrees_behind_nothing, lamps_behind_nothing, lamps_behind_nothing, 96)
AGREES(agrees_on_all_that_shines, all_that_shines, all_that_shines, 96)
AGREES(agrees_on_textured_lamps, textured_lamps, textured_lamps, 96)

/* ---- samplers, and what NEE does not draw ---- */

static void samplers_agree(void) {
    stats_moments m[3][BLOCKS];
    int i;
    memset(m, 0, sizeof m);
    for (i = 0; i < 3; i++) {
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, 64);
        inner = all_that_shines(s, &d);
        d.integrator = i == 2 ? PT_INTEGRATOR_NEE_ALL : PT_INTEGRATOR_NEE;
        d.sampler = i == 0 ? PT_SAMPLER_SOBOL : i == 1 ? PT_SAMPLER_STRATIFIED : PT_SAMPLER_RANDOM;
        if (commit(s)) push_blocks(m[i], s, &d, 16, (uint64_t)(50 + i * 1000));
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
    compare_blocks("sobol and stratified", m[0], m[1]);
    compare_blocks("sobol and random, all", m[0], m[2]);
}
static float small[8 * 8 * 3], again[8 * 8 * 3];
/* Without lights to draw from, by weights or by scene, it is the mixture, bit for bit; and rays are counted. */
static void nothing_to_draw(void) {
    int k, way;
    for (k = 0; k < 3; k++) for (way = 1; way <= 2; way++) {
        pt_scene *s = pt_scene_create(NULL), *inner = NULL;
        pt_render_desc d = view(pt_v3(0, 1, 3), pt_v3(0, 0.5f, 0), 40, 8, 4);
        pt_stats stats, other;
        test_case("nothing %d, integrator %d", k, way);
        if (k == 0) inner = all_that_shines(s, &d);
        else { floor_of(s, 3, diffuse(s, 0.5f)); sky(s, 1); }
        if (k == 2) pt_add_sphere(s, pt_v3(0, 1, 0), 0.2f, lamp(s, 1, 0));
        if (k != 1) d.weights.bsdf = 1;
        if (!commit(s) || !render(s, &d, small, &stats)) return;
        d.integrator = (pt_integrator)way;
        if (render(s, &d, again, &other)) CHECK(!memcmp(small, again, sizeof small));
        CHECK_EQ_INT(stats.rays, other.rays);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
/* A floor that sees three lamps, the sky and a sun: 1 ray from the eye, 1 onwards, or 2 where paths are split, and 1 or 5 to
   lights; wi below the floor, that no ray is traced for, are few. */
static void rays_are_counted(void) {
    static const double most[4] = { 2, 3, 7, 3 };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, 256);
    pt_stats stats;
    int way, i;
    floor_of(s, 3, diffuse(s, 0.5f));
    for (i = 0; i < 3; i++) pt_add_sphere(s, pt_v3((float)i, 2, 0), 0.3f, lamp(s, 1, 0));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .color = { 1, 1, 1 } });
    sunny(s, 0.1f, 0);
    commit(s);
    for (way = 0; way < 4; way++) {
        test_case("way %d", way);
        d.integrator = way < 3 ? (pt_integrator)way : PT_INTEGRATOR_MIXTURE;
        d.max_split = way == 0;
        if (!render(s, &d, small, &stats)) break;
        CHECK((double)stats.rays <= most[way] * (double)stats.paths);
        CHECK((double)stats.rays > (most[way] - 0.5) * (double)stats.paths);
    }
    pt_scene_destroy(s);
}

/* ---- limits: L = Le (1 + a + a^2 + ...), cut ---- */

/* [-1,1]^3: albedo a on five sides, m on the sixth (+x), all emit 1. */
static pt_scene *box_with(pt_scene *s, float a, const pt_material_desc *sixth) {
    pt_material wall = pt_add_material(s, &(pt_material_desc){ .color = { a, a, a }, .emission = { 1, 1, 1 }, .two_sided = 1 });
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(1, 1, 1), NULL, wall);
    if (sixth) quad(s, 0.99f, -1, -1, 0, 0, 2, 0, 2, 0, pt_add_material(s, sixth));
    commit(s);
    return s;
}
static void limits_cut_the_series(void) {
    static const int limit[] = { 1, 2, 3, 5 };
    static const float albedo[] = { 0.3f, 0.7f, 0.9f };
    int k, n, way, diffuse_only;
    for (k = 0; k < 3; k++) for (n = 0; n < 4; n++) for (way = 0; way < 3; way++) for (diffuse_only = 0; diffuse_only < 2; diffuse_only++) {
        double a = albedo[k];
        pt_scene *s = box_with(pt_scene_create(NULL), albedo[k], NULL);
        pt_render_desc d = view(pt_v3(-0.3f, 0.2f, 0.4f), pt_v3(1, -1, -1), 90, 32, 4);
        stats_moments m;
        test_case("albedo %g, %s %d, %s", a, diffuse_only ? "max_diffuse" : "max_depth", limit[n], ways[way + 1].name);
        if (diffuse_only) d.max_diffuse = limit[n];
        else d.max_depth = limit[n];
        d.integrator = (pt_integrator)way;
        m = render_pixels(s, &d);
        CHECK_P(stats_t_test(&m, (1 - pow(a, limit[n] + 1)) / (1 - a)));
        CHECK(stats_error(&m) < 0.01 * m.mean);
        pt_scene_destroy(s);
    }
}
/* A mirror shows the box with the same limit, whose light it does not count: the series is that of the wall, once more. In an
   infinite corridor of one mirror, each wall's light is L_N = 1 + a L_(N-1), be it seen directly or not. */
static void mirrors_do_not_count(void) {
    pt_material_desc metal = { .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 } };
    static const float roughness[] = { 0, 0.3f };
    int n, k;
    for (n = 1; n <= 3; n++) for (k = 0; k < 2; k++) {
        pt_scene *s;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(1, 0, 0), 40, 32, 32);
        double a = 0.6;
        stats_moments m;
        test_case("mirror of roughness %g, limit %d", (double)roughness[k], n);
        metal.roughness = roughness[k];
        s = box_with(pt_scene_create(NULL), 0.6f, &metal);
        d.max_diffuse = n;
        m = render_pixels(s, &d);
        CHECK_P(stats_t_test(&m, (1 - pow(a, n + 1)) / (1 - a)));
        CHECK(stats_error(&m) < 0.005 * m.mean);
        pt_scene_destroy(s);
    }
}
/* Gloss over a diffuse ground, all of it emitting 1, in a box of albedo a that does, too. Of the box's light the gloss sends on R,
   the ground D. With limit 1 the ground has had its scattering, but what the gloss shows has not:
       L = 1 + D + R (1 + a),   at depth 1 for both 1 + D + R,   and over black ground 1 + R. */
static void gloss_shows_what_the_limit_leaves(void) {
    static const float roughness[] = { 0, 0.5f };
    int k, i;
    for (k = 0; k < 2; k++) {
        double a = 0.5, difference, error;
        stats_moments m[3];
        for (i = 0; i < 3; i++) {                        /* limit 1 and depth 2; depth 1; depth 1 over black */
            pt_scene *s = pt_scene_create(NULL);
            pt_material_desc ground = { .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.8f, 0.5f, 0.2f }, .roughness = roughness[k], .ior = 3,
                                        .emission = { 1, 1, 1 } };
            pt_render_desc d = view_down(pt_v3(0.3f, 0, 0.2f), 32, 96);
            if (i == 2) ground.color = pt_v3(0, 0, 0);
            floor_of(s, 3, pt_add_material(s, &ground));
            pt_add_box(s, pt_v3(-3, -1, -3), pt_v3(3, 3, 3), NULL,
                       pt_add_material(s, &(pt_material_desc){ .color = { 0.5f, 0.5f, 0.5f }, .emission = { 1, 1, 1 }, .two_sided = 1 }));
            commit(s);
            d.max_depth = i == 0 ? 2 : 1;
            d.max_diffuse = i == 0;
            m[i] = render_pixels(s, &d);
            pt_scene_destroy(s);
        }
        difference = m[0].mean - m[1].mean - a * (m[2].mean - 1);
        error = sqrt(pow(stats_error(&m[0]), 2) + pow(stats_error(&m[1]), 2) + pow(a * stats_error(&m[2]), 2));
        test_case("gloss of roughness %g: %g, %g, %g", (double)roughness[k], m[0].mean, m[1].mean, m[2].mean);
        CHECK_P(stats_normal_p(difference / error));
        CHECK(error < 0.05 * a * (m[2].mean - 1));
    }
}
/* A density of the user's makes 2 or 3 rays of 2.5. Whose part was it, and are there 2 or 3? Neither may know of the other, in no
   sample: else gloss, beyond which the walls still scatter, brings more light in the third sample than in others (.009 of .83). */
static void lots_of_their_own(void) {
    static float rgb[64 * 64 * 3];
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view_down(pt_v3(0.3f, 0, 0.2f), 64, 1);
    stats_moments third = { 0, 0, 0 }, others;
    int i;
    floor_of(s, 3, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.5f, 0.5f, 0.5f },
                                                           .roughness = 0.5f, .ior = 4 }));
    pt_add_box(s, pt_v3(-3, -1, -3), pt_v3(3, 3, 3), NULL,
               pt_add_material(s, &(pt_material_desc){ .color = { 0.9f, 0.9f, 0.9f }, .emission = { 1, 1, 1 }, .two_sided = 1 }));
    pt_add_density(s, &(pt_density_desc){ 0.5f, sphere_sample, sphere_pdf, NULL, NULL });
    commit(s);
    d.max_depth = 2; d.max_diffuse = 1;
    d.first_sample = 2;
    for (d.seed = 0; d.seed < 16; d.seed++) {
        if (!render(s, &d, rgb, NULL)) break;
        for (i = 0; i < 64 * 64; i++) stats_push(&third, rgb[3 * i]);
    }
    d.first_sample = 64; d.spp = 64;
    others = render_pixels(s, &d);
    test_case("%g, %g", third.mean, others.mean);
    CHECK_P(stats_welch_test(&third, &others));
    pt_scene_destroy(s);
}
/* Whose part was it? Over many lots, both parts have the weight that they should, in each channel. */
static void parts_of_a_step(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_rng rng;
    int i, k, n = 20000;
    pt_rng_seed(&rng, 3, 4);
    floor_of(s, 5, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.8f, 0.5f, 0.1f }, .roughness = 0.4f,
                                                           .metallic = 0.3f, .sheen = 0.5f, .coat = 0.5f }));
    commit(s);
    for (k = 0; k < 5; k++) {
        pt_ray ray = { { 0, 1, 0 }, { 0.3f, -1, 0.2f }, 0, 0, 0 };
        pt_vec3 wi = pti_normalize(pt_v3(0.2f * (float)k, 1, 0.1f)), want[2], one;
        double sum[2][3] = { { 0, 0, 0 }, { 0, 0, 0 } };
        pt_vertex x;
        pti_surface surface, rest;
        if (!CHECK(pt_intersect(s, &ray, &x))) break;
        pti_surface_at(pti_material_at(s, &x), &x, &surface);
        rest = surface;
        CHECK(pti_surface_drop_diffuse(&rest) > 0 && rest.count < surface.count);
        pti_surface_eval(&surface, wi, &one);
        pti_surface_eval(&rest, wi, &want[0]);
        want[1] = pti_sub(one, want[0]);
        for (i = 0; i < n; i++) {
            pti_step step;
            int was;
            step.wi = wi; step.delta = 0; step.p = 1; step.weight = one;
            was = pti_step_is_diffuse(&surface, &step, pt_rng_u32(&rng));
            sum[was][0] += step.weight.x; sum[was][1] += step.weight.y; sum[was][2] += step.weight.z;
        }
        test_case("direction %d", k);
        for (i = 0; i < 2; i++) {
            CHECK_NEAR(sum[i][0] / n, want[i].x, 0.04 * want[i].x);
            CHECK_NEAR(sum[i][1] / n, want[i].y, 0.04 * want[i].y);
            CHECK_NEAR(sum[i][2] / n, want[i].z, 0.04 * want[i].z);
        }
    }
    pt_scene_destroy(s);
}

/* ---- roulette ---- */

/* A lamp in eight shells of tinted glass that does not bend light: c^16 of it come out. By potential roulette does not look at
   what the glass takes, as if there were none; by throughput it is right in the mean, and noisy. */
static void roulette_in_nested_shells(void) {
    stats_moments m[3];
    pt_scene *s = pt_scene_create(NULL);
    pt_material tinted = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1, .color = { 0.7f, 0.75f, 0.8f } });
    pt_render_desc d = view(pt_v3(0, 0, 9), pt_v3(0, 0, 0), 4, 32, 64);
    double want = pow(0.75, 16) * 1000;
    int k;
    for (k = 0; k < 16; k++) pt_add_sphere(s, pt_v3(0, 0, 0), 1 + 0.1f * (float)k, tinted);
    pt_add_sphere(s, pt_v3(0, 0, 0), 0.9f, lamp(s, 1000, 0));
    commit(s);
    for (k = 0; k < 3; k++) {
        d.roulette = (pt_roulette)k;
        m[k] = render_pixels(s, &d);
        test_case("roulette %d", k);
        if (k == PT_ROULETTE_THROUGHPUT) { CHECK_P(stats_t_test(&m[k], want)); CHECK(stats_variance(&m[k]) > 0.01 * want * want); }
        else { CHECK_NEAR(m[k].mean, want, 1e-4 * want); CHECK(stats_variance(&m[k]) < 1e-8 * want * want); }
    }
    pt_scene_destroy(s);
}
/* All ways have one mean, where potentials fall below the start and where they are reset often. */
static void roulettes_agree(void) {
    stats_moments m[3][BLOCKS];
    int k;
    memset(m, 0, sizeof m);
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, 64);
        lamps_behind_glass(s, &d);
        d.roulette = (pt_roulette)k;
        if (commit(s)) push_blocks(m[k], s, &d, 16, (uint64_t)(k * 100 + 7));
        pt_scene_destroy(s);
    }
    compare_blocks("potential and none", m[0], m[2]);
    compare_blocks("throughput and none", m[1], m[2]);
}
/* Bad values are refused. */
static void settings_are_checked(void) {
    pt_scene *s = pt_scene_create(NULL);
    int k;
    commit(s);
    static const char *const said[5] = { "integrator is 3", "roulette is 3", "max_diffuse is -1", "max_split is 9", "" };
    for (k = 0; k < 5; k++) {
        pt_render_desc d = view(pt_v3(0, 0, 1), pt_v3(0, 0, 0), 40, 8, 1);
        pt_render *r;
        if (k == 0) d.integrator = (pt_integrator)3;
        if (k == 1) d.roulette = (pt_roulette)3;
        if (k == 2) d.max_diffuse = -1;
        if (k == 3) d.max_split = 9;
        r = pt_render_create(s, &d);
        CHECK((pt_render_run(r) == PT_ERR_ARG) == (k < 4));
        CHECK(strstr(pt_render_error(r), said[k]));
        pt_render_destroy(r);
    }
    pt_scene_destroy(s);
}

void test_nee(void) {
    RUN(agrees_in_cornell_box); RUN(agrees_by_the_wall); RUN(agrees_on_hidden_lights); RUN(agrees_on_a_mesh_light);
    RUN(agrees_under_the_sun); RUN(agrees_on_mirror_and_glass); RUN(agrees_on_instances); RUN(agrees_in_a_closed_room);
    RUN(agrees_with_densities); RUN(agrees_through_a_lens); RUN(agrees_in_a_white_room); RUN(agrees_behind_glass);
    RUN(agrees_behind_nothing); RUN(agrees_on_all_that_shines); RUN(agrees_on_textured_lamps); RUN(agrees_on_suns_in_gloss);
    RUN(samplers_agree); RUN(nothing_to_draw); RUN(rays_are_counted);
    RUN(limits_cut_the_series); RUN(mirrors_do_not_count); RUN(gloss_shows_what_the_limit_leaves);
    RUN(lots_of_their_own); RUN(parts_of_a_step); RUN(roulette_in_nested_shells); RUN(roulettes_agree); RUN(settings_are_checked);
}
