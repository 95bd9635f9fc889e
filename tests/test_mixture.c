/* >>mixture: the one density against what it draws, its weights, and pictures, which no weights may change. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "agreement.h"

static float senseless(void *user, const pt_vertex *x) { (void)user; return x->p.x > 0.4f ? HUGE_VALF : x->p.z < -0.4f ? -7.0f : (float)NAN; }

/* ---- the density against what it draws ---- */

static const pt_weights automatic = { 0, 0, 0 };

typedef struct mix_test { pti_mixture mix; pti_surface surface; pt_vertex x; } mix_test;
/* The mixture where a ray from above meets the floor. */
static int mix_at(mix_test *t, const pt_scene *s, float x, float z, pt_weights w) {
    pt_ray ray;
    memset(&ray, 0, sizeof ray);
    ray.org = pt_v3(x + 0.05f, 0.1f, z - 0.02f);
    ray.dir = pt_v3(-0.05f, -0.1f, 0.02f);
    if (!CHECK(pt_intersect(s, &ray, &t->x))) return 0;
    pti_surface_at(pti_material_at(s, &t->x), &t->x, &t->surface);
    t->mix = pti_mixture_at(s, &t->surface, &w);
    return 1;
}
static int mix_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    mix_test *t = (mix_test *)ctx;
    uint32_t u = pt_rng_u32(rng), v = pt_rng_u32(rng), choice[2];
    pti_step step;
    choice[0] = choice[1] = pt_rng_u32(rng);
    if (!pti_mixture_sample(&t->mix, u, v, choice, &step) || step.delta) return 0;
    *wi = step.wi;
    return 1;
}
static double mix_pdf(void *ctx, pt_vec3 wi) {           /* what reflects nothing is not drawn */
    mix_test *t = (mix_test *)ctx;
    pt_vec3 f;
    float guided;
    return pti_mixture_pdf(&t->mix, wi, UNKNOWN, &f, &guided);
}
static void chi2_mixture(mix_test *t, double total, uint64_t seed) {
    chi2_directions_desc d;
    memset(&d, 0, sizeof d);
    d.sample = mix_sample; d.pdf = mix_pdf; d.ctx = t;
    d.total = total;
    d.ay = 0.2; d.ax = 0.1; d.az = 1;                    /* the map's poles fall inside of cells */
    d.n = 40000; d.cells_cos = 12; d.cells_phi = 16;
    d.seed = seed;
    chi2_directions(&d);
}
/* Lights that all shine on the middle of the floor: a quad, a sphere before it, triangles, one behind the other. */
static void some_lights(pt_scene *s) {
    quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, lamp(s, 3, 0));
    pt_add_sphere(s, pt_v3(0.3f, 1.4f, 0.2f), 0.4f, lamp(s, 2, 0));
    triangle_of(s, pt_v3(-3, 0.5f, -2), pt_v3(-3, 2.5f, -2), pt_v3(-2, 1, -3), lamp(s, 5, 1));
    triangle_of(s, pt_v3(-4, 0.2f, -3), pt_v3(-4, 3.5f, -2), pt_v3(-3, 1, -4), lamp(s, 9, 1));
}
static void density_of_everything(void) {
    static const float at[4][2] = { { 0, 0 }, { 0.8f, -0.5f }, { -2, -1 }, { 3, 2 } };
    static const pt_weights w[3] = { { 0, 0, 0 }, { 0.2f, 0.3f, 0.5f }, { 0.1f, 3, 0 } };
    int k, i, users;
    for (users = 0; users < 3; users++) {
        pt_scene *s = pt_scene_create(NULL);
        mix_test t;
        floor_of(s, 10, all_round(s));
        some_lights(s);
        sunny(s, 1, 0);
        if (users == 1) { add_lossy(s, 0.2f); add_cone(s, 0.1f); add_sphere(s, 0); }
        if (users == 2) { add_important(s, 0.3f, half_to_the_right); add_cone(s, 0.3f); add_important(s, 0.2f, senseless); }
        if (commit(s)) for (k = 0; k < 4; k++) for (i = 0; i < 3; i++) {
            test_case("vertex %d, weights %d, %s", k, i, users ? "densities" : "no densities");
            if (!users && i == 2) continue;
            if (mix_at(&t, s, at[k][0], at[k][1], w[i])) chi2_mixture(&t, users == 1 ? 0.9 : 1, (uint64_t)(k * 3 + i));
        }
        pt_scene_destroy(s);
    }
}
/* How often the light tree ends at a lamp that shines on the path. */
static double shining(const pti_lights *l, const pti_light_node *n, const pti_receiver *at) {
    float I[PTI_WIDTH];
    double sum = 0, weights;
    uint32_t k;
    if (!n->count) return pti_emitter_faces(l->emitters + n->first, at->p);
    weights = pti_light_weigh(l, n, at, I);
    for (k = 0; k < n->count; k++) if (I[k] > 0) sum += (double)I[k] / weights * shining(l, l->nodes + n->first + k, at);
    return sum;
}
/* How much of what the sky's density draws goes below the horizon: little, since it knows the normal. */
static double below_horizon(const pti_mixture *m) {
    enum { ACROSS = 512, DOWN = 256 };
    double sum = 0;
    int x, y;
    for (y = 0; y < DOWN; y++) for (x = 0; x < ACROSS; x++) {
        double h = (y + 0.5) / DOWN, r = sqrt(1 - h * h), phi = 2 * STATS_PI * (x + 0.5) / ACROSS;
        pt_vec3 wi = pt_v3((float)(r * cos(phi)), (float)-h, (float)(r * sin(phi)));
        sum += pti_environment_pdf(&m->scene->environment, m->sky, wi, NOWHERE) * 2 * STATS_PI / (ACROSS * DOWN);
    }
    return sum;
}
/* Over a diffuse floor some of a symmetric sky is below the horizon, half of a sphere in the floor, half of a density. */
static void density_less_what_is_lost(void) {
    int k;
    for (k = 0; k < 5; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_weights w = { 0.3f, 0.4f, 0.3f };
        mix_test t;
        test_case("what is lost, %d", k);
        floor_of(s, 10, k == 4 ? coat(s) : diffuse(s, 0.5f));
        if (k != 1) sunny(s, 1, 1);
        if (k >= 1) pt_add_sphere(s, pt_v3(1.5f, 0, 0.5f), 0.5f, lamp(s, 2, 0));
        if (k >= 2) add_sphere(s, 0.4f);
        if (k == 3) { add_lossy(s, 0.1f); add_cone(s, 0.1f); }
        if (commit(s) && mix_at(&t, s, 0, 0, w)) {
            const pti_mixture *m = &t.mix;
            double sphere = k == 3 ? m->users * 4 / 6 : m->users, lossy = k == 3 ? m->users / 6 : 0;
            double below = m->environment > 0 ? below_horizon(m) : 0;
            double lost = m->environment * below + m->lights / 2 + sphere / 2 + lossy * 3 / 4 + (k == 4 ? 0.3 * m->bsdf : 0);
            CHECK_NEAR(m->bsdf + m->environment + m->lights + m->users, 1, 1e-6);
            CHECK(below < (k == 4 ? 0.51 : 0.05));             /* a lobe of the user's may let light through */
            chi2_mixture(&t, 1 - lost, (uint64_t)k);
        }
        pt_scene_destroy(s);
    }
    {   /* a crowd of lamps, all of which look away, but every which way: what its branches are given is lost */
        pt_scene *s = pt_scene_create(NULL);
        mix_test t;
        pt_rng rng;
        int i;
        test_case("lamps that look away");
        floor_of(s, 10, all_round(s));
        pt_rng_seed(&rng, 3, 4);
        for (i = 0; i < 40; i++) {
            pt_vec3 c = pti_madd(random_direction(&rng), 1, pt_v3(0, 1.5f, 0)), u = random_direction(&rng), v = random_direction(&rng);
            if (pti_dot(pti_cross(u, v), c) < 0) { pt_vec3 w = u; u = v; v = w; }
            pt_add_quad(s, c, pti_scale(u, 0.2f), pti_scale(v, 0.2f), lamp(s, 2, 0));
        }
        quad(s, 3, 2, 0, 0, 0, -2, 2, 0, 0, lamp(s, 0.1f, 0));         /* downwards */
        if (commit(s) && mix_at(&t, s, 0, 0, automatic)) {
            double lost = t.mix.lights * (1 - shining(&s->lights, s->lights.nodes, &t.mix.receiver));
            CHECK(lost > 0.05);
            chi2_mixture(&t, 1 - lost, 5);
        }
        pt_scene_destroy(s);
    }
}
/* weight = f |cos| / p, over all parts: no sample is worth more than f over the BSDF's share of p. */
static void weights_of_steps(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_rng rng;
    int i, drawn = 0;
    pt_rng_seed(&rng, 1, 2);
    floor_of(s, 10, diffuse(s, 0.5f));
    some_lights(s);
    sunny(s, 1, 0);
    add_cone(s, 0.2f);
    commit(s);
    for (i = 0; i < 20000; i++) {
        static const pt_weights w[3] = { { 0, 0, 0 }, { 0.2f, 0.3f, 0.5f }, { 0.9f, 0.05f, 0.05f } };
        float x = 6 * pt_rng_float(&rng) - 3, z = 6 * pt_rng_float(&rng) - 3;
        uint32_t u = pt_rng_u32(&rng), v = pt_rng_u32(&rng), choice[2];
        pti_step step;
        mix_test t;
        pt_vec3 f;
        float guided;
        choice[0] = choice[1] = pt_rng_u32(&rng);
        if (!mix_at(&t, s, x, z, w[i % 3])) break;
        if (!pti_mixture_sample(&t.mix, u, v, choice, &step)) continue;
        drawn++;
        CHECK(step.weight.x > 0 && step.weight.x <= 0.5f / t.mix.bsdf * 1.0001f);
        CHECK_NEAR(step.weight.x * pti_mixture_pdf(&t.mix, step.wi, UNKNOWN, &f, &guided), 0.5 * step.wi.y / STATS_PI, 1e-5);
        CHECK_NEAR(pti_length(step.wi), 1, 1e-5);
    }
    CHECK(drawn > 10000);
    pt_scene_destroy(s);
}

/* ---- weights ---- */

typedef enum has { LAMP = 1, MAP = 2, CONSTANT = 4, DENSITY = 8, AWAY = 16, GLASS = 32 } has;
static pti_mixture weights_with(int parts, pt_weights w) {
    pt_scene *s = pt_scene_create(NULL);
    mix_test t;
    memset(&t, 0, sizeof t);
    floor_of(s, 10, parts & GLASS ? glass(s, 1.5f) : diffuse(s, 0.5f));
    if (parts & LAMP) quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, lamp(s, 3, 0));
    if (parts & AWAY) quad(s, -1, 2, -1, 0, 0, 2, 2, 0, 0, lamp(s, 3, 0));
    if (parts & MAP) sunny(s, 1, 0);
    if (parts & CONSTANT) sky(s, 1);
    if (parts & DENSITY) add_sphere(s, 0.4f);
    if (commit(s)) mix_at(&t, s, 0, 0, w);
    pt_scene_destroy(s);
    return t.mix;
}
static void check_shares(pti_mixture m, double bsdf, double lights, double environment, double users) {
    CHECK_NEAR(m.bsdf, bsdf, 1e-6); CHECK_NEAR(m.lights, lights, 1e-6);
    CHECK_NEAR(m.environment, environment, 1e-6); CHECK_NEAR(m.users, users, 1e-6);
}
static void shares_that_are_set(void) {
    static const pt_weights w = { 0.2f, 0.3f, 0.5f }, w10 = { 2, 3, 5 }, lights = { 0, 1, 0 }, map = { 0, 0, 7 }, bsdf = { 1, 0, 0 };
    check_shares(weights_with(LAMP | MAP, w), 0.2, 0.3, 0.5, 0);
    check_shares(weights_with(LAMP | MAP, w10), 0.2, 0.3, 0.5, 0);
    check_shares(weights_with(LAMP | MAP | DENSITY, w), 0.12, 0.18, 0.3, 0.4);
    check_shares(weights_with(LAMP, w), 0.4, 0.6, 0, 0);                       /* no environment: its share goes back */
    check_shares(weights_with(LAMP | CONSTANT, w), 0.4, 0.6, 0, 0);            /* a constant one has no density */
    check_shares(weights_with(MAP, w), 0.2 / 0.7, 0, 0.5 / 0.7, 0);
    check_shares(weights_with(MAP | AWAY, w), 0.2 / 0.7, 0, 0.5 / 0.7, 0);     /* a lamp that does not shine here */
    check_shares(weights_with(0, w), 1, 0, 0, 0);
    check_shares(weights_with(DENSITY, w), 0.6, 0, 0, 0.4);
    check_shares(weights_with(LAMP | MAP, lights), 0, 1, 0, 0);
    check_shares(weights_with(LAMP | MAP, map), 0, 0, 1, 0);
    check_shares(weights_with(LAMP | MAP, bsdf), 1, 0, 0, 0);
    check_shares(weights_with(MAP, lights), 1, 0, 0, 0);                       /* nothing left: the BSDF takes it all */
    check_shares(weights_with(LAMP, map), 1, 0, 0, 0);
    check_shares(weights_with(AWAY, lights), 1, 0, 0, 0);
    check_shares(weights_with(LAMP | MAP | DENSITY | GLASS, w), 1, 0, 0, 0);   /* deltas have no use for others */
    check_shares(weights_with(LAMP | MAP | DENSITY | GLASS, automatic), 1, 0, 0, 0);
}
static void shares_that_are_automatic(void) {
    pti_mixture both = weights_with(LAMP | MAP, automatic), one;
    check_shares(weights_with(0, automatic), 1, 0, 0, 0);
    check_shares(weights_with(CONSTANT | AWAY, automatic), 1, 0, 0, 0);
    check_shares(weights_with(LAMP, automatic), 0.5, 0.5, 0, 0);
    check_shares(weights_with(MAP, automatic), 0.5, 0, 0.5, 0);
    check_shares(weights_with(MAP | DENSITY, automatic), 0.3, 0, 0.3, 0.4);
    check_shares(weights_with(DENSITY, automatic), 0.6, 0, 0, 0.4);
    CHECK_NEAR(both.bsdf, 0.5, 1e-6);
    CHECK(both.lights > 0.01f && both.environment > 0.01f);
    CHECK_NEAR(both.lights + both.environment, 0.5, 1e-6);
    one = weights_with(LAMP | MAP | DENSITY, automatic);
    CHECK_NEAR(one.lights, 0.6 * both.lights, 1e-6);
    CHECK_NEAR(one.environment, 0.6 * both.environment, 1e-6);
}
static void lights_nearby_weigh_more(void) {
    pt_scene *s = pt_scene_create(NULL);
    float last = 1;
    int k;
    floor_of(s, 100, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(0, 1, 0), 0.3f, lamp(s, 5, 0));
    sunny(s, 1, 0);
    commit(s);
    for (k = 0; k < 6; k++) {
        mix_test t;
        if (!mix_at(&t, s, 0.5f * (float)(1 << k), 0, automatic)) break;
        CHECK(t.mix.lights > 0 && t.mix.lights < last && t.mix.bsdf >= 0.05f);
        last = t.mix.lights;
    }
    CHECK(last < 0.01f);
    pt_scene_destroy(s);
}
/* Rough metal under a sun right above: who looks at the mirrored sun sends nearly all rays there, who looks from aside does as on
   matte floors, where nothing changes. */
static void suns_glint_in_metal(void) {
    static const float aside[3] = { 0, 0.4f, 2 }, most[3] = { 8.001f, 3, 1.1f }, least[3] = { 7.99f, 1.1f, 1 };
    pt_material_desc metal;
    pt_light_desc sun;
    int k, matte;
    memset(&metal, 0, sizeof metal); memset(&sun, 0, sizeof sun);
    metal.bsdf = PT_BSDF_CONDUCTOR; metal.color = pt_v3(0.9f, 0.9f, 0.9f); metal.roughness = 0.25f;
    sun.kind = PT_LIGHT_SUN; sun.direction = pt_v3(0, -1, 0); sun.color = pt_v3(3, 3, 3);
    for (matte = 0; matte < 2; matte++) {
        pt_scene *s = pt_scene_create(NULL);
        floor_of(s, 10, matte ? diffuse(s, 0.5f) : pt_add_material(s, &metal));
        quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, lamp(s, 1, 0));
        pt_add_light(s, &sun);
        for (k = 0; k < 3 && commit(s); k++) {
            mix_test t;
            pti_mixture before;
            if (!mix_at(&t, s, 0, 0, automatic)) break;
            t.x.wo = pti_normalize(pt_v3(-aside[k], 1, 0));
            pti_surface_at(pti_material_at(s, &t.x), &t.x, &t.surface);
            before = t.mix;
            pti_mixture_glints(&t.mix);
            test_case("%s, %g aside: %g times, shares %g %g %g", matte ? "matte" : "metal", (double)aside[k], (double)t.mix.glint,
                      (double)t.mix.bsdf, (double)t.mix.lights, (double)t.mix.environment);
            if (matte) CHECK(t.mix.glint == 1 && t.mix.environment == before.environment && t.mix.bsdf == before.bsdf);
            else CHECK(t.mix.glint >= least[k] && t.mix.glint <= most[k]);
            check_shares(t.mix, 1 - t.mix.lights - t.mix.environment, t.mix.bsdf * before.lights / before.bsdf,
                         t.mix.bsdf * t.mix.glint * before.environment / before.bsdf, 0);
        }
        pt_scene_destroy(s);
    }
}
static void shares_of_densities(void) {
    static const float w[5][4] = { { 0, 0, 0, 0 }, { 0.1f, 0.2f, 0, 0 }, { 0.9f, 0.9f, 0.9f, 0 }, { 0.95f, 0, 0, 0 },
                                   { 0.5f, 0.3f, 0.1f, 0.4f } };
    static const int n[5] = { 1, 3, 3, 1, 4 };
    int k, i;
    for (k = 0; k < 5; k++) {
        pt_scene *s = pt_scene_create(NULL);
        double sum = 0, scale;
        mix_test t;
        test_case("densities %d", k);
        floor_of(s, 10, diffuse(s, 0.5f));
        for (i = 0; i < n[k]; i++) { add_sphere(s, w[k][i]); sum += w[k][i] > 0 ? (double)w[k][i] : 0.25; }
        scale = sum > 0.95 ? 0.95 / sum : 1;
        if (commit(s) && mix_at(&t, s, 0, 0, automatic)) {
            check_shares(t.mix, 1 - sum * scale, 0, 0, sum * scale);
            for (i = 0; i < n[k]; i++) CHECK_NEAR(s->densities[i].weight, (w[k][i] > 0 ? (double)w[k][i] : 0.25) * scale, 1e-6);
        }
        pt_scene_destroy(s);
    }
    for (k = 0; k < 2; k++) {                            /* what is not wanted goes to the others, and so with no number at all */
        pt_scene *s = pt_scene_create(NULL);
        mix_test t;
        test_case("importance, %d", k);
        floor_of(s, 10, diffuse(s, 0.5f));
        add_important(s, 0.4f, half_to_the_right);
        add_important(s, 0.3f, senseless);
        if (commit(s) && mix_at(&t, s, k ? 2.0f : -2.0f, 0, automatic)) check_shares(t.mix, k ? 0.5 : 1, 0, 0, k ? 0.5 : 0);
        pt_scene_destroy(s);
    }
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_density_desc d = { 0.1f, sphere_sample, sphere_pdf, NULL, NULL };
        test_case("bad density %d", k);
        if (k == 0) d.weight = -0.1f;
        if (k == 1) d.weight = 1;
        if (k == 2) d.sample = NULL;
        if (k == 3) d.pdf = NULL;
        CHECK(pt_add_density(s, &d).id == 0);
        CHECK(pt_scene_commit(s) == PT_ERR_ARG);
        pt_scene_destroy(s);
    }
}

/* ---- shares that are learned ---- */

/* Two parts that never draw the same direction: the best shares are as the roots of their second moments over what a ray of
   each costs, and one step finds them from anywhere (but for the prior). Where nothing was found, and where nobody was, nothing changes. */
static void shares_step_to_the_best(void) {
    static pti_share cells[PTI_SHARE_CELLS];
    static pti_share_sums sums[PTI_SHARE_CELLS];
    pti_shares s = { { 0, 0, 0 }, cells, sums };
    const double w[3] = { 0.3, 0.7, 0 }, moment[2] = { 4, 1 }, n = 1e6;        /* moment: of f L / p_i */
    int k;
    memset(cells, 0, sizeof cells);
    memset(sums, 0, sizeof sums);
    sums[5].count = sums[6].count = n;
    for (k = 0; k < 3; k++) sums[5].share[k] = sums[6].share[k] = n * w[k];
    for (k = 0; k < 2; k++) sums[5].part[k] = n * w[k] * moment[k] / (w[k] * w[k]) / w[k];        /* P(i) v^2 p_i / p */
    pti_shares_step(&s);
    CHECK_NEAR(cells[5].part[0], 2 / 3.0, 1e-4);
    CHECK_NEAR(cells[5].part[1], 1 / 3.0, 1e-4);
    CHECK(cells[5].part[2] == 0);
    CHECK_NEAR(cells[6].part[0], 0.3, 1e-6);
    CHECK(cells[7].part[0] == 0 && sums[5].count == 0);
    sums[5].count = n;                                   /* all from the lights: the BSDF keeps its least */
    sums[5].share[0] = sums[5].share[1] = sums[5].share[2] = n / 3;
    sums[5].part[1] = n;
    pti_shares_step(&s);
    CHECK(cells[5].part[0] > 0.2 && cells[5].part[0] < 0.25 && cells[5].part[2] > 0.08 && cells[5].part[2] < 0.13);
    sums[5].count = n;                                   /* as good as each other, but the BSDF's rays are followed by three */
    for (k = 0; k < 2; k++) {
        sums[5].share[k] = n / 2;
        sums[5].part[k] = sums[5].drawn[k] = n;
        sums[5].cost[k] = k ? n : 4 * n;
    }
    sums[5].share[2] = 0;
    pti_shares_step(&s);
    CHECK_NEAR(cells[5].part[0], 1 / 3.0, 1e-4);
}
/* A lamp in a closed box is drawn in vain, one in the open is not: after the paths that go ahead, shares on the floor say so. */
static void hidden_lamps_lose_their_share(void) {
    int hidden;
    for (hidden = 0; hidden < 2; hidden++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 4, 4), pt_v3(0, 0, 0), 30, 64, 1);
        pt_render *r;
        double lights = 0;
        int i, n = 0;
        floor_of(s, 3, diffuse(s, 0.5f));
        pt_add_sphere(s, pt_v3(0, 4, 0), 0.2f, lamp(s, 400, 0));           /* gives the floor as much as the sky */
        if (hidden) pt_add_box(s, pt_v3(-0.5f, 3.5f, -0.5f), pt_v3(0.5f, 4.5f, 0.5f), NULL, diffuse(s, 0));
        sky(s, 1);
        r = commit(s) ? pt_render_create(s, &d) : NULL;
        if (!CHECK(pt_render_run(r) == PT_OK)) return;
        for (i = 0; i < PTI_SHARE_CELLS; i++) if (r->shares.cells[i].part[0] > 0) { lights += r->shares.cells[i].part[1]; n++; }
        test_case("%s: %.3f in %d cells", hidden ? "hidden" : "in the open", lights / n, n);
        if (CHECK(n > 4)) CHECK(hidden ? lights / n < 0.2 : lights / n > 0.4 && lights / n < 0.55);
        pt_render_destroy(r);
        pt_scene_destroy(s);
    }
}

/* In a room that a lamp lights, a guide soon sees that there is nothing to do for it; behind a wall with a gap there is, unless
   the paths to learn from are few. */
static void guides_step_aside(void) {
    int gap, few;
    for (gap = 0; gap < 2; gap++) for (few = 0; few < 2; few++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 32, 1);
        pt_render *r;
        cornell(s, &d);
        if (gap) {                                       /* the lamp in a hood, open a little to the back wall */
            pt_material white = diffuse(s, 0.73f);
            quad(s, -1, 1.5f, 1, 2, 0, 0, 0, 0, -1.8f, white);
            quad(s, -1, 1.5f, 1, 2, 0, 0, 0, 0.5f, 0, white);
        }
        d.guide = few ? 16 : 64;                         /* 16384 paths, or 65536 */
        r = commit(s) ? pt_render_create(s, &d) : NULL;
        if (!CHECK(pt_render_run(r) == PT_OK)) return;
        test_case("%s%s: windows weigh %.3f", gap ? "gap" : "lamp", few ? ", few paths" : "", r->guide.share);
        CHECK((r->tracer.guide != NULL) == (gap && !few));
        pt_render_destroy(r);
        pt_scene_destroy(s);
    }
}

static pt_vec3 astray;
static int astray_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) { (void)user; (void)x; (void)u; *wi = astray; return 1; }
/* Densities of a user's that are none are counted. */
static float senseless_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)x; (void)wi; return *(const float *)user; }
static void densities_that_are_none(void) {
    static float bad[] = { (float)NAN, HUGE_VALF, -HUGE_VALF, -1 };
    int i;
    for (i = 0; i < 4; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 1, 1), pt_v3(0, 0, 0), 30, 8, 4);
        pt_stats stats;
        float rgb[3 * 8 * 8];
        astray = pt_v3(0, 1, 0);
        floor_of(s, 5, diffuse(s, 0.5f));
        sunny(s, 1, 0);
        pt_add_density(s, &(pt_density_desc){ .sample = astray_sample, .pdf = senseless_pdf, .user = bad + i });
        test_case("density %g", (double)bad[i]);
        if (commit(s) && render(s, &d, rgb, &stats)) CHECK(stats.discarded > 200);
        pt_scene_destroy(s);
    }
}
/* Directions of a user's that are none, where tables wait to be looked up by them: counted, too, and nothing worse. */
static void directions_that_are_none(void) {
    static const float bad[][3] = { { (float)NAN, 0, 0 }, { HUGE_VALF, 0, 0 }, { 0, 1e20f, 0 }, { 0, 0, 0 }, { -1e-20f, 0, 2 }, { 3e38f, 3e38f, 3e38f } };
    static float table[6 * 6 * 3];
    int i, k;
    for (i = 0; i < 6 * 6 * 3; i++) table[i] = 0.2f;
    for (i = 0; i < 6; i++) for (k = 0; k < 2; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 1, 1), pt_v3(0, 0, 0), 30, 8, 4);
        pt_measured m = pt_add_measured(s, &(pt_measured_desc){ .values = table, .cells_h = 6, .cells_d = 6, .cells_p = 1 });
        pt_stats stats;
        float rgb[3 * 8 * 8];
        astray = pt_v3(bad[i][0], bad[i][1], bad[i][2]);
        floor_of(s, 5, k ? pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MEASURED, .measured = m }) : diffuse(s, 0.5f));
        sunny(s, 1, 0);
        pt_add_density(s, &(pt_density_desc){ .sample = astray_sample, .pdf = sphere_pdf });
        test_case("direction %d, %s", i, k ? "measured" : "diffuse");
        if (commit(s) && render(s, &d, rgb, &stats)) CHECK(stats.discarded > 0 && stats.discarded < 200);
        pt_scene_destroy(s);
    }
}

/* A user's density far below what the BSDF is makes weights of 1e24 a bounce: soon throughput is infinite, and every ray
   is worth splitting. That is counted, and comes to an end. */
static float thin_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return 1e-26f; }
static void throughput_without_bound(void) {
    static const pt_bsdf_vtable thin = { round_eval, thin_pdf, round_sample, NULL };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 1, 1.8f), pt_v3(0, 0.5f, 0), 60, 8, 2);
    pt_stats stats;
    float rgb[3 * 8 * 8];
    pt_add_box(s, pt_v3(-2, 0, -2), pt_v3(2, 3, 2), NULL,
               pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_USER, .vtable = &thin }));
    quad(s, -0.7f, 2.9f, -0.7f, 1.4f, 0, 0, 0, 0, 1.4f, lamp(s, 3, 0));
    if (commit(s) && render(s, &d, rgb, &stats)) CHECK(stats.discarded > 0);
    pt_scene_destroy(s);
}

/* ---- agreement: no weights change the mean of a picture ---- */

static void agreement(const char *name, scene_builder *build, scene_builder *plain) {
    static const pt_weights w[] = { { 1, 0, 0 }, { 0.5f, 0.5f, 0 }, { 0.2f, 0.3f, 0.5f }, { 0.9f, 0.05f, 0.05f }, { 0, 0, 0 } };
    stats_moments reference[BLOCKS], m[BLOCKS];
    int k, j;
    memset(reference, 0, sizeof reference);
    for (k = -1; k < 5; k++) {                           /* -1: naive, the reference */
        pt_scene *s = pt_scene_create(NULL), *inner;
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, k < 0 ? 96 : 48);
        char what[100];
        if (k == 0 && plain == build) { pt_scene_destroy(s); continue; }
        inner = (k < 0 ? plain : build)(s, &d);
        d.weights = w[k < 0 ? 0 : k];
        memset(m, 0, sizeof m);
        if (commit(s)) push_blocks(k < 0 ? reference : m, s, &d, k < 0 ? 32 : 16, (uint64_t)(1000 * (k + 2)));
        snprintf(what, sizeof what, "%s, weights %d", name, k);
        if (k >= 0) compare_blocks(what, m, reference);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
        for (j = 0; j < BLOCKS; j++) if (!(reference[j].n > 1)) return;
    }
}
static void agrees_in_cornell_box(void)         { agreement("cornell", cornell, cornell); }
static void agrees_by_the_wall(void)            { agreement("wall", sphere_by_the_wall, sphere_by_the_wall); }
static void agrees_on_hidden_lights(void)       { agreement("hidden", one_behind_the_other, one_behind_the_other); }
static void agrees_on_a_mesh_light(void)        { agreement("torus", glowing_torus, glowing_torus); }
static void agrees_under_the_sun(void)          { agreement("sun", sun_and_mesh, sun_and_mesh); }
static void agrees_on_mirror_and_glass(void)    { agreement("glass", sky_lamps_mirror_glass, sky_lamps_mirror_glass); }
static void agrees_on_instances(void)           { agreement("instances", instanced_lamps, instanced_lamps); }
static void agrees_in_a_closed_room(void)       { agreement("room", closed_room, closed_room); }
static void agrees_with_densities(void)         { agreement("densities", densities, two_by_the_wall); }
static void agrees_through_a_lens(void)         { agreement("lens", lens_and_depth, lens_and_depth); }

static void agrees_in_a_white_room(void) {
    agreement("white room", white_room, white_room);
}

/* The three samplers have one mean. */
static void samplers_agree(void) {
    static scene_builder *const builds[2] = { sky_lamps_mirror_glass, closed_room };
    int k, i;
    for (k = 0; k < 2; k++) {
        stats_moments m[3][BLOCKS];
        memset(m, 0, sizeof m);
        for (i = 0; i < 3; i++) {
            pt_scene *s = pt_scene_create(NULL);
            pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 40, 8, 64);
            builds[k](s, &d);
            d.sampler = i == 0 ? PT_SAMPLER_SOBOL : i == 1 ? PT_SAMPLER_STRATIFIED : PT_SAMPLER_RANDOM;
            if (commit(s)) push_blocks(m[i], s, &d, 16, (uint64_t)(50 + i * 1000));
            pt_scene_destroy(s);
        }
        compare_blocks("sobol and stratified", m[0], m[1]);
        compare_blocks("sobol and random", m[0], m[2]);
        compare_blocks("stratified and random", m[1], m[2]);
    }
}
/* A scene that is its own mirror image, lights and all, has pictures that are, too. */
static void halves_agree(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 1, 3.4f), pt_v3(0, 1, 0), 42, 8, 64);
    stats_moments m[BLOCKS];
    int side;
    memset(m, 0, sizeof m);
    walls(s, diffuse(s, 0.7f), colored(s, 0.6f, 0.2f, 0.1f), colored(s, 0.6f, 0.2f, 0.1f));
    for (side = -1; side <= 1; side += 2) {
        pt_add_sphere(s, pt_v3(0.6f * (float)side, 1.5f, -0.3f), 0.25f, lamp(s, 4, 0));
        triangle_of(s, pt_v3(0.9f * (float)side, 0.2f, 0), pt_v3(0.9f * (float)side, 0.8f, 0), pt_v3(0.6f * (float)side, 0.4f, -0.5f),
                    lamp(s, 3, 1));
        pt_add_sphere(s, pt_v3(0.4f * (float)side, 0.3f, 0.2f), 0.3f, glass(s, 1.5f));
    }
    if (commit(s)) push_blocks(m, s, &d, 48, 9);
    for (side = 0; side < 2; side++) {                   /* upper, then lower half */
        test_case("halves: %g and %g", m[2 * side].mean, m[2 * side + 1].mean);
        CHECK_P(stats_welch_test(&m[2 * side], &m[2 * side + 1]));
        CHECK(stats_error(&m[2 * side]) < 0.01 * m[2 * side].mean);
    }
    pt_scene_destroy(s);
}

void test_mixture(void) {
    RUN(density_of_everything); RUN(density_less_what_is_lost); RUN(weights_of_steps);
    RUN(shares_that_are_set); RUN(shares_that_are_automatic); RUN(lights_nearby_weigh_more); RUN(suns_glint_in_metal); RUN(shares_of_densities);
    RUN(directions_that_are_none); RUN(densities_that_are_none); RUN(throughput_without_bound); RUN(shares_step_to_the_best); RUN(hidden_lamps_lose_their_share);
    RUN(guides_step_aside);
    RUN(agrees_in_cornell_box); RUN(agrees_by_the_wall); RUN(agrees_on_hidden_lights); RUN(agrees_on_a_mesh_light);
    RUN(agrees_under_the_sun); RUN(agrees_on_mirror_and_glass); RUN(agrees_on_instances); RUN(agrees_in_a_closed_room);
    RUN(agrees_with_densities); RUN(agrees_through_a_lens); RUN(agrees_in_a_white_room);
    RUN(samplers_agree); RUN(halves_agree);
}
