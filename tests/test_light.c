/* >>light: emitters, the light tree and the environment against their densities, and pictures against closed forms. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

/* ---- emitters ---- */

typedef struct spot { const pti_emitter *e; pt_vec3 p; int lost; } spot;
static int spot_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    spot *s = (spot *)ctx;
    int tries;
    for (tries = 0; tries < 100; tries++) {              /* on the rim, rounding loses some: counted, and drawn again */
        float u = pt_rng_float(rng), v = pt_rng_float(rng);
        if (pti_emitter_sample(s->e, s->p, u, v, wi)) return 1;
        s->lost++;
    }
    return 0;
}
static double spot_pdf(void *ctx, pt_vec3 wi) {
    const spot *s = (const spot *)ctx;
    return pti_emitter_pdf(s->e, s->p, wi);
}
static double one_minus_cos(pt_vec3 a, pt_vec3 b) {
    pt_vec3 d = pti_sub(pti_normalize(a), pti_normalize(b));
    return 0.5 * pti_dot(d, d);
}
/* Looks at e from p, through a cap that just holds it; at most `lost` of all samples may be lost on the rim. */
static void check_emitter(const char *name, pti_emitter e, pt_vec3 p, double lost, double tolerance) {
    chi2_directions_desc d;
    spot s;
    pt_vec3 corner[4], axis = pti_sub(e.p, p);
    int k;
    memset(&d, 0, sizeof d);
    s.e = &e; s.p = p; s.lost = 0;
    if (e.kind == PTI_SPHERE_LIGHT) d.zoom = pti_emitter_cone(&e, axis);
    else {
        corner[0] = axis;
        corner[1] = pti_add(axis, e.e1);
        corner[2] = pti_add(axis, e.e2);
        corner[3] = e.kind == PTI_RECT_LIGHT ? pti_add(corner[1], e.e2) : axis;
        axis = e.kind == PTI_RECT_LIGHT ? pti_scale(pti_add(corner[0], corner[3]), 0.5f)
                                        : pti_scale(pti_add(corner[0], pti_add(corner[1], corner[2])), 1 / 3.0f);
        for (k = 0; k < 4; k++) d.zoom = fmax(d.zoom, one_minus_cos(axis, corner[k]));
    }
    d.zoom = d.zoom > 0.8 ? 2 : d.zoom * 1.05;
    d.ax = axis.x; d.ay = axis.y; d.az = axis.z;
    d.sample = spot_sample; d.pdf = spot_pdf; d.ctx = &s;
    d.n = 10000;
    d.tolerance = tolerance;
    test_case("%s, from (%g %g %g)", name, (double)p.x, (double)p.y, (double)p.z);
    chi2_directions(&d);
    CHECK(s.lost <= lost * d.n);
}
static pti_emitter some_triangle(int two_sided) {        /* in the plane z = 0, the front towards +z; inside the unit square */
    return pti_emitter_flat(PTI_TRIANGLE_LIGHT, pt_v3(0, 0, 0), pt_v3(1, 0.2f, 0), pt_v3(0.1f, 0.7f, 0), 1, two_sided);
}
static pti_emitter some_rect(int two_sided) {
    return pti_emitter_flat(PTI_RECT_LIGHT, pt_v3(0, 0, 0), pt_v3(0.9f, 0.3f, 0), pt_v3(-0.2f, 0.6f, 0), 1, two_sided);
}
static void flat_emitters(void) {
    static const struct { float x, y, z; double lost; } from[] = {
        { 0.3f, 0.3f, 1, 1e-3 }, { 0.3f, 0.3f, 0.01f, 1e-3 }, { 0.2f, 0.3f, 0.0005f, 1e-3 },         /* before, near */
        { 3, 2, 4, 1e-3 }, { 12, -9, 20, 1e-3 },                                                     /* far */
        { -1, 0.2f, 0.05f, 2e-3 }, { 1.5f, 0.4f, 0.02f, 2e-3 },         /* grazing */
        { 0, 0, 0.5f, 2e-3 },                                                                        /* above a corner */
    };
    int i;
    for (i = 0; i < (int)(sizeof from / sizeof *from); i++) {
        pt_vec3 p = pt_v3(from[i].x, from[i].y, from[i].z), q = pt_v3(p.x, p.y, -p.z);
        check_emitter("triangle", some_triangle(0), p, from[i].lost, 0.004);
        check_emitter("rectangle", some_rect(0), p, from[i].lost, 0.004);
        if (i % 3) continue;
        check_emitter("two-sided triangle, back", some_triangle(1), q, from[i].lost, 0.004);
        check_emitter("two-sided rectangle, back", some_rect(1), q, from[i].lost, 0.004);
    }
}
/* On either side of where area sampling takes over. */
static void tiny_flat_emitters(void) {
    static const double ratio[] = { 0.01, 0.95, 1.05 };
    int i, k;
    for (i = 0; i < 3; i++) for (k = 0; k < 2; k++) {
        pti_emitter e = k ? some_rect(0) : some_triangle(0);
        double tiny = k ? (double)PTI_TINY_RECT : (double)PTI_TINY_TRIANGLE, cosine = 0.8, distance = sqrt(pti_emitter_area(&e) * cosine / (tiny * ratio[i]));
        pt_vec3 middle = pti_madd(pti_add(e.e1, e.e2), k ? 0.5f : 1 / 3.0f, e.p), c[3];
        pt_vec3 p = pti_madd(pt_v3(0.6f, 0, 0.8f), (float)distance, middle);
        pti_rect_frame frame = pti_rect_frame_of(e.e1, e.e2);
        pti_rect r = pti_rect_seen_from(&frame, pti_sub(e.p, p));
        double S = k ? pti_rect_solid_angle(&r) : pti_emitter_triangle_angle(&e, p, c);
        CHECK((S < tiny) == (ratio[i] < 1));
        check_emitter(k ? "tiny rectangle" : "tiny triangle", e, p, 0.02, k ? 0.01 : 0.004);
    }
}
static void spheres(void) {
    static const float from[][3] = { { 1, 2, 1.2f }, { 0.5f, 3, -0.4f }, { 7, 2, -30 }, { 1000, 30, 200 }, { 0.9f, 2.6f, 0.4f } };
    pti_emitter e = pti_emitter_sphere(pt_v3(1, 2, 0), 0.7f, 1, 0), inside = pti_emitter_sphere(pt_v3(1, 2, 0), 0.7f, 1, 1);
    int i;
    for (i = 0; i < 5; i++) {
        pt_vec3 p = pt_v3(from[i][0], from[i][1], from[i][2]);
        if (i < 4) check_emitter("sphere", e, p, 2e-3, 0);
        check_emitter("two-sided sphere", inside, p, 2e-3, 0);
    }
    check_emitter("sphere, a hair above it", e, pt_v3(1, 2, 0.70001f), 2e-3, 0);
    check_emitter("two-sided sphere, a hair inside", inside, pt_v3(1, 2, 0.69999f), 0, 0);
    check_emitter("two-sided sphere, at its centre's side", inside, pt_v3(1, 2, 0.0001f), 0, 0);
}
/* No light falls on the back, in the plane itself, or from the inside of a one-sided sphere. */
static void behind(void) {
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 2, 2);
    for (i = 0; i < 3000; i++) {
        pti_emitter e = i % 3 == 0 ? some_triangle(0) : i % 3 == 1 ? some_rect(0) : pti_emitter_sphere(pt_v3(0, 0, -1), 1, 1, 0);
        pt_vec3 u = stats_uniform3(&rng), p = pt_v3(4 * u.x - 2, 4 * u.y - 2, i % 7 ? -3 * u.z : 0.0f), wi;
        if (i % 3 == 2) p = pti_madd(stats_direction(&rng), 0.99f * u.x, e.p);
        wi = pti_normalize(pti_sub(pti_madd(pti_add(e.e1, e.e2), 0.3f, e.p), p));
        CHECK(pti_emitter_pdf(&e, p, wi) == 0);
        CHECK(pti_emitter_pdf(&e, p, stats_direction(&rng)) == 0);
        CHECK(!pti_emitter_sample(&e, p, u.x, u.y, &wi));
    }
}
/* The density is 1 / S, S in double by Van Oosterom and Strackee; 0 beside it. */
static double angle_of(const double a[3], const double b[3], const double c[3]) {
    double l[3], ab = 0, bc = 0, ca = 0, det;
    int k;
    l[0] = l[1] = l[2] = 0;
    for (k = 0; k < 3; k++) {
        l[0] += a[k] * a[k]; l[1] += b[k] * b[k]; l[2] += c[k] * c[k];
        ab += a[k] * b[k]; bc += b[k] * c[k]; ca += c[k] * a[k];
    }
    for (k = 0; k < 3; k++) l[k] = sqrt(l[k]);
    det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    return 2 * atan2(fabs(det), l[0] * l[1] * l[2] + ab * l[2] + bc * l[0] + ca * l[1]);
}
static void densities_in_double(void) {
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 3, 3);
    for (i = 0; i < 5000; i++) {
        pt_vec3 u = stats_uniform3(&rng), p = pti_scale(stats_direction(&rng), powf(10, 2 * u.z - 0.5f)), wi, beside;
        pti_emitter t = some_triangle(1), r = some_rect(1);
        double v[4][3], S;
        if (fabsf(p.z) < 0.02f * pti_length(p) || fabsf(p.z) < 0.05f) continue;
        for (k = 0; k < 2; k++) {
            const pti_emitter *e = k ? &r : &t;
            int c;
            for (c = 0; c < 4; c++) {
                v[c][0] = (double)e->p.x + (c & 1) * (double)e->e1.x + (c >> 1) * (double)e->e2.x - (double)p.x;
                v[c][1] = (double)e->p.y + (c & 1) * (double)e->e1.y + (c >> 1) * (double)e->e2.y - (double)p.y;
                v[c][2] = (double)e->p.z + (c & 1) * (double)e->e1.z + (c >> 1) * (double)e->e2.z - (double)p.z;
            }
            S = angle_of(v[0], v[1], v[2]) + (k ? angle_of(v[3], v[1], v[2]) : 0);
            if (!pti_emitter_sample(e, p, u.x, u.y, &wi)) continue;
            test_case("from (%g %g %g), S %g", (double)p.x, (double)p.y, (double)p.z, S);
            if (S > (k ? 1.1 * (double)PTI_TINY_RECT : 1.1 * (double)PTI_TINY_TRIANGLE)) CHECK_NEAR(pti_emitter_pdf(e, p, wi) * S, 1, 1e-3);
            beside = pti_normalize(pti_sub(pti_madd(pti_add(e->e1, e->e2), k ? 1.01f : 0.52f, e->p), p));
            CHECK(pti_emitter_pdf(e, p, beside) == 0);
            CHECK(pti_emitter_pdf(e, p, pti_neg(wi)) == 0);
        }
    }
}

/* ---- the light tree ---- */

typedef struct forest { const pti_lights *l; pti_receiver at; double total; int lost; } forest;
static int forest_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    forest *f = (forest *)ctx;
    int tries;
    for (tries = 0; tries < 100; tries++) {
        uint32_t choice = pt_rng_u32(rng);
        float u = pt_rng_float(rng), v = pt_rng_float(rng);
        pti_drawn drawn;
        if (pti_lights_sample(f->l, &f->at, choice, u, v, wi, &drawn)) return 1;
        f->lost++;
        if (f->total < 1 - 1e-9) return 0;               /* this was no loss on a rim */
    }
    return 0;
}
static double forest_pdf(void *ctx, pt_vec3 wi) {
    const forest *f = (const forest *)ctx;
    return pti_lights_pdf(f->l, &f->at, wi, NULL);
}
/* All leaves, no boxes: sum of P(leaf) p_leaf(wi), or with wi NULL the sum of P(leaf) over those that shine. */
static double all_leaves(const pti_lights *l, const pti_light_node *n, const pti_receiver *at, const pt_vec3 *wi) {
    float I[PTI_WIDTH];
    double sum = 0, weights;
    uint32_t k;
    if (!n->count) {
        const pti_emitter *e = l->emitters + n->first;
        return wi ? pti_emitter_pdf(e, at->p, *wi) : pti_emitter_faces(e, at->p);
    }
    weights = pti_light_weigh(l, n, at, I);
    for (k = 0; k < n->count; k++) if (I[k] > 0) sum += (double)I[k] / weights * all_leaves(l, l->nodes + n->first + k, at, wi);
    return sum;
}
static pti_receiver receiver_at(pt_vec3 p, pt_vec3 n) { pti_receiver r; r.p = p; r.n = n; return r; }
static pti_receiver anywhere(pt_vec3 p) { return receiver_at(p, pt_v3(0, 0, 0)); }
/* n lamps of all kinds, some behind each other, some within each other. */
static pt_scene *lamps(int n, int two_sided) {
    pt_scene *s = pt_scene_create(NULL);
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 11, (uint64_t)n);
    for (i = 0; i < n; i++) {
        pt_vec3 c = pti_scale(stats_direction(&rng), 2 + 2 * pt_rng_float(&rng)), u = stats_direction(&rng), v = stats_direction(&rng);
        pt_material m = lamp(s, 0.1f + pt_rng_float(&rng) * 3, two_sided);
        if (i == 4) c = pti_scale(pt_v3(3, 0, 0), 1);
        if (i == 5) c = pti_scale(pt_v3(6, 0, 0), 1);    /* hidden by the one before */
        if (i % 3 == 0) pt_add_sphere(s, c, 0.6f, m);
        else if (i % 3 == 1) pt_add_quad(s, c, u, pti_normalize(pti_cross(u, v)), m);
        else triangle_of(s, c, pti_add(c, u), pti_add(c, v), m);
    }
    commit(s);
    return s;
}
static void light_tree(void) {
    static const int count[] = { 1, 2, 7, 100 };
    static const float from[][3] = { { 0.1f, 0.2f, -0.1f }, { 8, 1, 2 }, { -3, 0.5f, 0.7f } };
    int i, k, side;
    for (i = 0; i < 4; i++) for (side = 0; side < 2; side++) {
        pt_scene *s = lamps(count[i], side);
        CHECK_EQ_INT(s->lights.count, count[i]);
        for (k = 0; k < (count[i] == 100 ? 1 : 3); k++) {
            chi2_directions_desc d;
            forest f;
            memset(&d, 0, sizeof d);
            f.l = &s->lights; f.at = anywhere(pt_v3(from[k][0], from[k][1], from[k][2])); f.lost = 0;
            f.total = all_leaves(f.l, f.l->nodes, &f.at, NULL);
            test_case("%d lights, side %d, place %d, total %g", count[i], side, k, f.total);
            if (f.total <= 0) { CHECK(pti_lights_pdf(f.l, &f.at, pt_v3(0, 0, 1), NULL) == 0); continue; }
            d.sample = forest_sample; d.pdf = forest_pdf; d.ctx = &f;
            d.total = f.total; d.n = count[i] == 100 ? 4000 : 10000; d.tolerance = 0.006;
            d.ax = 0.3; d.ay = 0.9; d.az = 0.2;
            chi2_directions(&d);
            if (f.total >= 1 - 1e-9) CHECK(f.lost < 20);
        }
        pt_scene_destroy(s);
    }
}
static void every_emitter_counts(void) {
    static const int count[] = { 2, 7, 100 };
    int i, k, several = 0, none = 0;
    for (i = 0; i < 3; i++) {
        pt_scene *s = lamps(count[i], 1);
        pt_rng rng;
        pt_rng_seed(&rng, 12, 12);
        for (k = 0; k < 3000; k++) {
            pt_vec3 p = pti_scale(stats_direction(&rng), 8 * pt_rng_float(&rng)), wi = stats_direction(&rng);
            float u = pt_rng_float(&rng), v = pt_rng_float(&rng);
            pti_receiver at = anywhere(p);
            pti_drawn drawn;
            double want;
            size_t j;
            int here = 0;
            if (k & 1 && !pti_lights_sample(&s->lights, &at, pt_rng_u32(&rng), u, v, &wi, &drawn)) continue;
            want = all_leaves(&s->lights, s->lights.nodes, &at, &wi);
            for (j = 0; j < s->lights.count; j++) here += pti_emitter_pdf(s->lights.emitters + j, p, wi) > 0;
            several += here > 1;
            none += here == 0;
            test_case("%d lights, case %d", count[i], k);
            CHECK_NEAR(pti_lights_pdf(&s->lights, &at, wi, NULL), want, 1e-5 * want);
        }
        pt_scene_destroy(s);
    }
    CHECK(several > 1000 && none > 500);
}

/* Random places, near, far and within, with a horizon or without. */
static pti_receiver some_receiver(pt_rng *rng, float size) {
    pt_vec3 p = pti_scale(stats_direction(rng), size * pt_rng_float(rng)), n = stats_direction(rng);
    return pt_rng_u32(rng) % 4 ? receiver_at(p, n) : anywhere(p);
}
/* Lamps of every kind, small and large, one-sided, two-sided and spots, in crowds and alone. */
static pt_scene *medley(int n, pt_light_choice choose) {
    pt_scene *s = pt_scene_create(&(pt_scene_desc){ .choose = choose });
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 21, (uint64_t)n);
    for (i = 0; i < n; i++) {
        float size = 0.03f + 0.6f * (float)(i % 17 == 0), radiance = 0.1f + 3 * pt_rng_float(&rng);
        pt_vec3 c = pti_scale(stats_direction(&rng), 4 * pt_rng_float(&rng)), u = stats_direction(&rng), v = stats_direction(&rng);
        pt_material m = lamp(s, radiance, i % 5 == 0);
        if (i % 3 == 0) c = pti_madd(u, 0.3f, pt_v3(2, 0, 1));         /* a crowd that looks outwards */
        if (i % 7 == 6) pt_add_light(s, &(pt_light_desc){ .kind = i % 2 ? PT_LIGHT_SPOT : PT_LIGHT_POINT, .position = c, .direction = u,
            .radius = size, .cone_deg = 5 + 85 * pt_rng_float(&rng), .color = { 1, 1, 1 } });
        else if (i % 7 == 5) pt_add_sphere(s, c, size, m);
        else if (i % 2) pt_add_quad(s, c, pti_scale(u, size), pti_scale(pti_normalize(pti_cross(u, v)), size), m);
        else triangle_of(s, c, pti_madd(pti_normalize(pti_cross(u, v)), size, c), pti_madd(pti_normalize(pti_cross(u, pti_cross(u, v))), size, c), m);
    }
    commit(s);
    return s;
}
/* Does the lamp send anything to the upper side of r? Looked for by directions. */
static int shines_on(const pti_emitter *e, const pti_receiver *r, pt_rng *rng) {
    int i;
    for (i = 0; i < 20; i++) {
        float u = pt_rng_float(rng), v = pt_rng_float(rng);
        pt_vec3 wi, from;
        if (!pti_emitter_sample(e, r->p, u, v, &wi)) continue;
        from = pti_sub(pti_neg(wi), e->n);
        if (e->spot > 0 && 0.5f * pti_dot(from, from) > e->spot) continue;
        if (pti_is_zero3(r->n) || pti_dot(r->n, wi) > 1e-4f) return 1;
    }
    return 0;
}
/* The probability of each lamp; -1 for one that was never reached. */
static void leaf_probabilities(const pti_lights *l, const pti_light_node *n, const pti_receiver *at, double p, double *out) {
    float I[PTI_WIDTH];
    double sum;
    uint32_t k;
    if (!n->count) { out[n->first] = p; return; }
    sum = pti_light_weigh(l, n, at, I);
    for (k = 0; k < n->count; k++) leaf_probabilities(l, l->nodes + n->first + k, at, sum > 0 ? p * (double)I[k] / sum : 0.0, out);
}
static void no_lamp_is_forgotten(void) {
    static const int count[] = { 1, 3, 30, 300, 2000 };
    static double p[4000];                               /* a skew quad is two lamps */
    int i, k, seen = 0, dark = 0;
    for (i = 0; i < 5; i++) {
        pt_scene *s = medley(count[i], PT_CHOOSE_TREE);
        pt_rng rng;
        pt_rng_seed(&rng, 22, 22);
        for (k = 0; k < (count[i] == 2000 ? 60 : 300); k++) {
            pti_receiver r = some_receiver(&rng, k % 3 ? 5.0f : 50.0f);
            double all = 0;
            size_t j;
            int any = 0;
            if (k % 5 == 0) r.p = pti_madd(r.n, 0.01f, s->lights.emitters[(size_t)k % s->lights.count].p);
            for (j = 0; j < s->lights.count; j++) p[j] = -1;
            leaf_probabilities(&s->lights, s->lights.nodes, &r, 1, p);
            test_case("%d lamps, place %d", count[i], k);
            for (j = 0; j < s->lights.count; j++) {
                int shines = shines_on(s->lights.emitters + j, &r, &rng);
                CHECK(p[j] >= 0);                        /* each is in the tree */
                if (shines && s->lights.count > 1 && !CHECK(p[j] > 0)) break;
                if (shines && !CHECK(pti_lights_irradiance(&s->lights, &r) > 0)) break;
                all += p[j];
                any |= shines;
            }
            CHECK(all < 1 + 1e-5);
            if (any && s->lights.count < 8) CHECK_NEAR(all, 1, 1e-5);          /* one node: nothing can be lost */
            seen += any;
            dark += !any;
        }
        pt_scene_destroy(s);
    }
    CHECK(seen > 500 && dark > 20);
}
/* sample against pdf, and pdf against all leaves, for receivers everywhere and each way to choose. */
static void receivers(void) {
    int n, choose, k;
    for (n = 5; n <= 500; n *= 10) for (choose = 0; choose < 3; choose++) {
        pt_scene *s = medley(n, (pt_light_choice)choose);
        pt_rng rng;
        pt_rng_seed(&rng, 23, 23);
        for (k = 0; k < 6; k++) {
            pti_receiver r = some_receiver(&rng, k % 2 ? 4.0f : 12.0f);
            chi2_directions_desc d;
            forest f;
            int i;
            memset(&d, 0, sizeof d);
            f.l = &s->lights; f.at = r; f.lost = 0;
            f.total = all_leaves(f.l, f.l->nodes, &r, NULL);
            test_case("%d lamps, choice %d, place %d, total %g", n, choose, k, f.total);
            for (i = 0; i < 300; i++) {
                pt_vec3 wi = stats_direction(&rng);
                float u = pt_rng_float(&rng), v = pt_rng_float(&rng);
                pti_drawn drawn = *UNKNOWN;
                double want;
                if (i & 1 && !pti_lights_sample(f.l, &r, pt_rng_u32(&rng), u, v, &wi, &drawn)) continue;
                want = all_leaves(f.l, f.l->nodes, &r, &wi);
                if (!CHECK_NEAR(pti_lights_pdf(f.l, &r, wi, NULL), want, 2e-6 * want)) break;
                CHECK(pti_lights_pdf(f.l, &r, wi, &drawn) == pti_lights_pdf(f.l, &r, wi, NULL));    /* to the bit */
            }
            if (f.total < 1e-9 || n == 500) continue;
            d.sample = forest_sample; d.pdf = forest_pdf; d.ctx = &f;
            d.total = f.total < 1 - 1e-6 ? f.total : 1;
            d.n = 4000; d.tolerance = 0.02; d.zero_allowed = 3;
            d.ax = 0.3; d.ay = 0.9; d.az = 0.2;
            if (f.total < 1 - 1e-9) f.total = 0;         /* each draw once */
            chi2_directions(&d);
        }
        pt_scene_destroy(s);
    }
}
/* By power and uniformly: what the words say. */
static void simple_choices(void) {
    static double p[200];
    int choose, k, n;
    for (choose = PT_CHOOSE_POWER; choose <= PT_CHOOSE_UNIFORM; choose++) {
        pt_scene *s = medley(100, (pt_light_choice)choose);
        pti_receiver r = anywhere(pt_v3(1, 2, 3));
        double power = 0;
        n = (int)s->lights.count;
        if (!CHECK(n >= 100 && n <= 200)) return;
        for (k = 0; k < n; k++) power += (double)pti_light_leaf(s->lights.emitters + k, 0).power;
        leaf_probabilities(&s->lights, s->lights.nodes, &r, 1, p);
        for (k = 0; k < n; k++) {
            test_case("choice %d, lamp %d", choose, k);
            CHECK_NEAR(p[k] / (choose == PT_CHOOSE_UNIFORM ? 1.0 / n : (double)pti_light_leaf(s->lights.emitters + k, 0).power / power), 1, 1e-5);
        }
        pt_scene_destroy(s);
    }
    {
        pt_scene *s = pt_scene_create(&(pt_scene_desc){ .choose = (pt_light_choice)7 });
        CHECK(pt_scene_commit(s) == PT_ERR_ARG && strstr(pt_scene_error(s), "choose"));
        pt_scene_destroy(s);
    }
}
static void many_lamps_at_once(void) {                   /* crowds, copies in one place, and a line: built at once, no deeper than allowed */
    enum { N = 60000 };
    static float v[9 * N];
    int kind, i, k;
    for (kind = 0; kind < 3; kind++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_rng rng;
        size_t leaves = 0, j;
        pt_rng_seed(&rng, 24, 24);
        for (i = 0; i < N; i++) {
            pt_vec3 c = kind == 0 ? stats_uniform3(&rng) : kind == 1 ? pt_v3(1, 2, 3) : pt_v3((float)exp(-(double)i / 900), 0, 0);
            for (k = 0; k < 9; k++) v[9 * i + k] = pti_axis(c, k % 3) + (k == 3 || k == 7 ? 1e-3f : 0.0f);
        }
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = v, .vertex_count = 3 * N, .material = lamp(s, 1, 1), .borrow = 1 });
        test_case("kind %d", kind);
        if (commit(s)) {
            pti_receiver r = anywhere(pt_v3(0.5f, 0.2f, 0.7f));
            pt_vec3 wi;
            CHECK_EQ_INT(s->lights.count, N);
            CHECK(s->lights.node_count == s->lights.node_capacity && s->lights.node_count < (kind == 1 ? 2 * N : N * 3 / 2));
            for (j = 0; j < s->lights.node_count; j++) leaves += !s->lights.nodes[j].count;
            CHECK_EQ_INT(leaves, N);
            for (i = 0; i < 100; i++) {
                pti_drawn drawn;
                double want;
                if (!pti_lights_sample(&s->lights, &r, pt_rng_u32(&rng), 0.4f, 0.3f, &wi, &drawn)) continue;
                want = kind == 1 && i > 2 ? 0 : all_leaves(&s->lights, s->lights.nodes, &r, &wi);
                if (want > 0) CHECK_NEAR(pti_lights_pdf(&s->lights, &r, wi, NULL), want, 1e-4 * want);
            }
        }
        pt_scene_destroy(s);
    }
}
typedef struct stingy { long calls, fail_at, live; } stingy;
static void *stingy_alloc(void *user, size_t size, size_t align) {
    stingy *m = (stingy *)user;
    void *p = NULL;
    if (++m->calls == m->fail_at) return NULL;
    if (posix_memalign(&p, align < sizeof p ? sizeof p : align, size)) return NULL;
    m->live++;
    return p;
}
static void stingy_free(void *user, void *p, size_t size) { (void)size; ((stingy *)user)->live--; free(p); }
static void lamps_without_memory(void) {
    long n, failed = 0;
    for (n = 1; n < 1000; n++) {
        stingy m = { 0, 0, 0 };
        pt_scene_desc d;
        pt_scene *s;
        pt_result r;
        int i;
        m.fail_at = n;
        memset(&d, 0, sizeof d);
        d.allocator.alloc = stingy_alloc; d.allocator.free = stingy_free; d.allocator.user = &m;
        s = pt_scene_create(&d);
        for (i = 0; s && i < 20; i++) pt_add_sphere(s, pt_v3((float)i, 0, 0), 0.1f, i ? (pt_material){ 1 } : lamp(s, 1, 0));
        r = pt_scene_commit(s);
        pt_scene_destroy(s);
        CHECK_EQ_INT(m.live, 0);
        if (r == PT_OK) break;
        CHECK(r == PT_ERR_MEMORY);
        failed++;
    }
    CHECK(failed > 8 && failed < 900);
}
/* A picture of 4096 x 4 that is black but for one texel: its triangle is a lamp, and the black one beside it is none. */
static void a_hidden_texel_counts(void) {
    static float pixels[4096 * 4];
    int bright;
    for (bright = 0; bright < 2; bright++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_vec3 v[3];
        float uv[6] = { 0, 0, 1, 0, 0, 1 };
        pt_texture t;
        memset(pixels, 0, sizeof pixels);
        pixels[2 * 4096 + 11] = bright ? 1000.0f : 0.0f;
        t = pt_add_texture(s, &(pt_texture_desc){ .width = 4096, .height = 4, .channels = 1, .bits = 32, .pixels = pixels, .nearest = 1 });
        v[0] = pt_v3(0, 0, 0); v[1] = pt_v3(1, 0, 0); v[2] = pt_v3(0, 1, 0);
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = &v[0].x, .vertex_count = 3, .uvs = uv, .material =
            pt_add_material(s, &(pt_material_desc){ .emission_texture = t }) });
        test_case("bright %d", bright);
        if (commit(s)) CHECK_EQ_INT(s->lights.count, bright);
        pt_scene_destroy(s);
    }
}

/* ---- the environment ---- */

/* On the map itself, where the texels' borders are those of cells: u and v by our own words for the promise, that the middle
   is towards -z, its right towards +x, the top +y, and all turned counter-clockwise. */
typedef struct turned_sky { const pti_environment *e; double turn; int receiver; } turned_sky;
static pt_vec3 direction_at(double turn_deg, double u, double v) {
    double a = turn_deg * STATS_PI / 180, theta = v * STATS_PI, phi = (u - 0.5) * 2 * STATS_PI;
    double x = sin(theta) * sin(phi), z = -sin(theta) * cos(phi);
    return pt_v3((float)(x * cos(a) + z * sin(a)), (float)cos(theta), (float)(z * cos(a) - x * sin(a)));
}
static int environment_sample(void *ctx, pt_rng *rng, float uv[2]) {
    const turned_sky *s = (const turned_sky *)ctx;
    uint32_t u = pt_rng_u32(rng);
    float v = pt_rng_float(rng);
    double a = s->turn * STATS_PI / 180, x, z, b;
    pt_vec3 wi;
    if (!pti_environment_sample(s->e, s->receiver, u, v, &wi, NOWHERE)) return 0;
    x = wi.x * cos(a) - wi.z * sin(a);                   /* turned back */
    z = wi.z * cos(a) + wi.x * sin(a);
    b = 0.5 + atan2(x, -z) / (2 * STATS_PI);
    uv[0] = (float)(b < 0.9999999 ? b : 0.9999999);
    uv[1] = (float)(atan2(sqrt(x * x + z * z), wi.y) / STATS_PI);
    if (uv[1] > 0.9999999f) uv[1] = 0.9999999f;
    CHECK(fabs(pti_length(wi) - 1) < 1e-6);
    return 1;
}
static double environment_pdf(void *ctx, float u, float v) {           /* per du dv */
    const turned_sky *s = (const turned_sky *)ctx;
    return pti_environment_pdf(s->e, s->receiver, direction_at(s->turn, u, v), NOWHERE) * 2 * STATS_PI * STATS_PI * sin(v * STATS_PI);
}
static pt_vec3 smooth_sky(void *user, pt_vec3 d) { (void)user; return pt_v3(1, 1 + d.y, 0.5f + (d.x > 0.7f ? 5.0f : 0.0f)); }

static float map_pixels[64 * 128];
enum { EVEN, SUN, BLACK_ROWS, BLACK, POLE, CALLBACK, MAPS };
static pt_scene *sky_with(int kind, float rotate) {
    pt_scene *s = pt_scene_create(NULL);
    pt_light_desc l;
    int i;
    memset(&l, 0, sizeof l);
    l.rotate_deg = rotate;
    for (i = 0; i < 16 * 8; i++) {
        int y = i / 16;
        map_pixels[i] = kind == EVEN ? 1.0f : kind == SUN ? (i == 16 * 2 + 5 ? 1000 : 0.1f)
                      : kind == BLACK_ROWS ? (y >= 1 && y <= 5 ? 0.0f : 1 + (float)(i % 16)) : kind == POLE ? (y == 0 ? 10.0f : 0.0f) : 0.0f;
    }
    if (kind == CALLBACK) l.radiance = smooth_sky;
    else l.texture = grey_map(s, map_pixels, 16, 8);
    pt_add_light(s, &l);
    commit(s);
    return s;
}
static void environments(void) {
    static const float turn[] = { 0, 77, -190 };
    int kind, k;
    for (kind = 0; kind < MAPS; kind++) for (k = 0; k < (kind == CALLBACK ? 1 : 3); k++) {
        pt_scene *s = sky_with(kind, turn[k]);
        turned_sky t;
        t.e = &s->environment; t.turn = turn[k]; t.receiver = k == 1 ? 77 : PTI_RECEIVER_ALL;
        test_case("map %d, turned by %g", kind, (double)turn[k]);
        CHECK((kind == BLACK) == (s->environment.mean == 0));
        chi2_square(&(chi2_square_desc){ .sample = environment_sample, .pdf = environment_pdf, .ctx = &t, .cells_x = 32, .cells_y = 16,
                                         .n = 10000, .zero_allowed = 3, .tolerance = 0.004 });
        pt_scene_destroy(s);
    }
}
/* Wherever the map is bright, the density is not 0, nor small. */
static void bright_is_likely(void) {
    int kind, i;
    for (kind = 0; kind < MAPS; kind++) {
        pt_scene *s = sky_with(kind, 30);
        pt_rng rng;
        double worst = 0;
        pt_rng_seed(&rng, 4, 4);
        for (i = 0; i < 30000; i++) {
            pt_vec3 d = stats_direction(&rng);
            double L = pti_luminance(pti_environment_radiance(&s->environment, d, NOWHERE)), p = pti_environment_pdf(&s->environment, PTI_RECEIVER_ALL, d, NOWHERE);
            if (L > 0 && !CHECK(p > 0)) break;
            if (L > 0) worst = fmax(worst, L / p / (4 * STATS_PI * (double)s->environment.mean));
        }
        test_case("map %d", kind);
        CHECK(worst < 35);                               /* a tent's corner is 16 times its mean; half the sine, at a pole */
        pt_scene_destroy(s);
    }
}
/* Maps whose texels are no multiple of the table's cells, and nearly black ones; for receivers of several normals. */
static const struct { int width, height, spots; float ground, bright; } odd_map[] = {
    { 1, 1, 0, 1, 0 }, { 1, 37, 9, 0, 3 }, { 41, 1, 7, 0, 3 }, { 7, 3, 2, 0.1f, 5 }, { 100, 50, 1, 0, 1 }, { 100, 50, 1, 0.3f, 1e6f },
    { 33, 64, 3, 0, 1e6f } };
#define ODD_MAPS ((int)(sizeof odd_map / sizeof *odd_map))
static pt_scene *odd_sky(int k, pt_scene *s) {
    int i, n = odd_map[k].width * odd_map[k].height;
    if (!s) s = pt_scene_create(NULL);
    for (i = 0; i < n; i++) map_pixels[i] = odd_map[k].ground;
    for (i = 0; i < odd_map[k].spots; i++) map_pixels[(i * 29 + n / 3) % n] = odd_map[k].bright;
    pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map_pixels, odd_map[k].width, odd_map[k].height), .rotate_deg = 31 });
    commit(s);
    return s;
}
static void odd_maps(void) {
    static const float normal[][3] = { { 0, 0, 0 }, { 0, 1, 0 }, { 0.3f, -0.5f, 0.8f } };
    int k, i;
    for (k = 0; k < ODD_MAPS; k++) {
        pt_scene *s = odd_sky(k, NULL);
        pt_rng rng;
        for (i = 0; i < 3; i++) {
            turned_sky t;
            if (i == k % 3) continue;
            t.e = &s->environment; t.turn = 31;
            t.receiver = pti_environment_receiver(pt_v3(normal[i][0], normal[i][1], normal[i][2]));
            test_case("map %d, normal %d", k, i);
            CHECK((t.receiver == PTI_RECEIVER_ALL) == (i == 0));
            chi2_square(&(chi2_square_desc){ .sample = environment_sample, .pdf = environment_pdf, .ctx = &t, .cells_x = 64, .cells_y = 32,
                                             .n = 10000, .zero_allowed = 3, .tolerance = 0.006 });
        }
        pt_rng_seed(&rng, 5, (uint64_t)k);
        for (i = 0; i < 20000; i++) {                    /* never 0 where the map is not */
            pt_vec3 d = stats_direction(&rng);
            if (pti_luminance(pti_environment_radiance(&s->environment, d, NOWHERE)) > 1e-4f * odd_map[k].bright
                && !CHECK(pti_environment_pdf(&s->environment, i % PTI_RECEIVERS, d, NOWHERE) > 0)) break;
        }
        pt_scene_destroy(s);
    }
}
/* The floor under them is as bright as the map says, by quadrature; one hot texel in thousands is found at once. */
static void odd_maps_light_the_floor(void) {
    int k, x, y, n = 512;
    for (k = 0; k < ODD_MAPS; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, 2048);
        stats_moments m;
        double E = 0;
        pt_add_quad(s, pt_v3(-5, 0, -5), pt_v3(0, 0, 10), pt_v3(10, 0, 0), diffuse(s, 1));
        odd_sky(k, s);
        for (y = 0; y < n; y++) for (x = 0; x < 2 * n; x++) {
            double theta = (y + 0.5) / n * STATS_PI / 2;
            pt_vec3 w = direction_at(0, (x + 0.5) / (2 * n), (y + 0.5) / (2 * n));
            E += (double)pti_environment_radiance(&s->environment, w, NOWHERE).y * cos(theta) * sin(theta) * STATS_PI * STATS_PI / (2.0 * n * n);
        }
        test_case("map %d", k);
        m = render_pixels(s, &d);
        CHECK_NEAR(m.mean * STATS_PI / E, 1, 5e-3);
        CHECK(stats_error(&m) < 2e-3 * m.mean);
        CHECK_NEAR(pti_environment_irradiance(&s->environment, pt_v3(0, 1, 0)) / E, 1, 0.35);
        pt_scene_destroy(s);
    }
}
/* What a receiver is told of its light, by brute force; from all around it is the whole fluence. */
static void irradiance_of_receivers(void) {
    static const int kinds[] = { EVEN, SUN, BLACK_ROWS, POLE, CALLBACK };
    int k, i, j;
    for (k = 0; k < 5; k++) {
        pt_scene *s = sky_with(kinds[k], 30);
        const pti_environment *e = &s->environment;
        pt_rng rng;
        pt_rng_seed(&rng, 6, 6);
        if (k == 2) CHECK_NEAR(pti_environment_irradiance(e, pt_v3(0, 0, 0)) / (4 * STATS_PI * (double)e->mean), 1, 1e-4);
        for (i = 0; i < 12; i++) {
            pt_vec3 n = stats_direction(&rng);
            double E = 0, most = 4 * STATS_PI * (double)e->mean;
            for (j = 0; j < 20000; j++) {
                pt_vec3 d = pti_sample_sphere(((float)j + 0.5f) / 20000, (float)fmod(j * 0.6180339887, 1));
                E += (double)pti_luminance(pti_environment_radiance(e, d, NOWHERE)) * fmax(pti_dot(d, n), 0) * 4 * STATS_PI / 20000;
            }
            test_case("map %d, normal %d", kinds[k], i);
            CHECK_NEAR(pti_environment_irradiance(e, n), E, 0.15 * E + 0.08 * most);
        }
        pt_scene_destroy(s);
    }
    {
        pt_scene *s = sky_with(BLACK, 0);
        CHECK(pti_environment_irradiance(&s->environment, pt_v3(0, 1, 0)) == 0);
        pt_scene_destroy(s);
    }
}
/* Each class of normals holds its own middle. */
static void classes_of_normals(void) {
    int i;
    for (i = 0; i < PTI_RECEIVER_ALL; i++) CHECK_EQ_INT(pti_environment_receiver(pti_environment_normal(i)), i);
    CHECK_EQ_INT(pti_environment_receiver(pt_v3(0, 0, 0)), PTI_RECEIVER_ALL);
    for (i = 0; i < 6; i++) {                            /* axes, with zeros of either sign */
        pt_vec3 n = pt_v3(i == 0 ? 1.0f : i == 1 ? -1.0f : -0.0f, i == 2 ? 1.0f : i == 3 ? -1.0f : 0.0f, i == 4 ? 1.0f : i == 5 ? -1.0f : -0.0f);
        CHECK(pti_dot(n, pti_environment_normal(pti_environment_receiver(n))) > 0.95f);
    }
}
/* Whoever draws a direction from the map says where on it that is: where it would be found. */
static void places_are_where_they_are_found(void) {
    int k, i;
    for (k = 0; k < ODD_MAPS; k++) {
        pt_scene *s = odd_sky(k, NULL);
        pt_rng rng;
        test_case("map %d", k);
        pt_rng_seed(&rng, 4, 9);
        for (i = 0; s->environment.field_count && i < 20000; i++) {
            uint32_t u = pt_rng_u32(&rng);
            pti_on_map drawn = *NOWHERE, found = *NOWHERE;
            pt_vec3 wi;
            double across, r;
            if (!pti_environment_sample(&s->environment, i % PTI_RECEIVERS, u, pt_rng_float(&rng), &wi, &drawn)) continue;
            pti_environment_place(&s->environment, wi, &found);
            across = fabs((double)drawn.u - found.u);
            r = sin(drawn.v * STATS_PI);                 /* near the poles u means little */
            if (!CHECK(drawn.known && fmin(across, 1 - across) * r < 1e-6 && fabs((double)drawn.v - found.v) < 1e-6)) break;
        }
        pt_scene_destroy(s);
    }
}
static void texel_directions(void) {
    static const float turn[] = { 0, 90, -45, 123, 360 };
    int i, x, y;
    for (i = 0; i < 8 * 4; i++) map_pixels[i] = 1 + (float)i;
    for (i = 0; i < 5; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map_pixels, 8, 4), .rotate_deg = turn[i] });
        if (commit(s)) for (y = 0; y < 4; y++) for (x = 0; x < 8; x++) {
            pt_vec3 d = direction_at(turn[i], (x + 0.5) / 8, (y + 0.5) / 4);
            test_case("texel %d %d, turned by %g", x, y, (double)turn[i]);
            CHECK_NEAR(pti_environment_radiance(&s->environment, d, NOWHERE).x, 1 + y * 8 + x, 2e-4);
        }
        pt_scene_destroy(s);
    }
}
/* Through a camera: the quarter of the map that is bright, in each of the views. */
static void the_sky_in_pictures(void) {
    static const float to[4][3] = { { 0, 0, -1 }, { 1, 0, 0 }, { 0, 0, 1 }, { -1, 0, 0 } };
    static const int column[] = { 4, 6, 0, 2 };          /* of the left one of its two middle texels, but for +z */
    int turn, i, k;
    for (turn = 0; turn < 2; turn++) for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        int bright = (column[k] - 2 * turn + 8) % 8;     /* a quarter turn to the left shows what is left of it... */
        for (i = 0; i < 8 * 4; i++) map_pixels[i] = i % 8 == bright || i % 8 == (bright + 7) % 8 ? 1.0f : 0.0f;
        pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map_pixels, 8, 4), .rotate_deg = turn ? -90.0f : 0.0f });
        if (commit(s)) for (i = 0; i < 4; i++) {         /* ... here to the right, so that it stays in place */
            pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(to[i][0], to[i][1], to[i][2]), 2, 2, 16);
            stats_moments m = render_pixels(s, &d);
            test_case("turn %d, bright %d, view %d", turn, k, i);
            CHECK_NEAR(m.mean, i == k ? 1 : 0, 1e-4);
        }
        pt_scene_destroy(s);
    }
}
/* A map that is bright in its top row only: L(theta) = 1000 to half a row, then straight down to 0 at one row and a half. */
static void bright_pole(void) {
    static const pt_weights weights[] = { { 0, 0, 0 }, { 0.5f, 0, 0.5f }, { 0.1f, 0, 0.9f } };
    int h, k, i;
    for (h = 32; h <= 64; h *= 2) for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, 2048);
        double E = 0, t0 = STATS_PI / (2 * h);
        stats_moments m;
        for (i = 0; i < 2 * h * h; i++) map_pixels[i] = i < 2 * h ? 1000.0f : 0.0f;
        pt_add_quad(s, pt_v3(-5, 0, -5), pt_v3(0, 0, 10), pt_v3(10, 0, 0), diffuse(s, 1));
        pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map_pixels, 2 * h, h) });
        for (i = 0; i < 100000; i++) {
            double t = 3 * t0 * (i + 0.5) / 100000, L = t < t0 ? 1000 : 1000 * (3 * t0 - t) / (2 * t0);
            E += L * cos(t) * sin(t) * 2 * 3 * t0 / 100000;
        }
        d.weights = weights[k];
        if (commit(s)) {
            m = render_pixels(s, &d);
            test_case("height %d, weights %d", h, k);
            check_mean(&m, E);
        }
        pt_scene_destroy(s);
    }
}

/* ---- irradiance in closed form ---- */

/* Lambert 1760: E = L/2 sum over the edges of angle x (normal of the edge's plane . n), seen from the origin, n = +y. */
static double polygon_irradiance(const pt_vec3 *corner, int n) {
    double sum = 0;
    int i;
    for (i = 0; i < n; i++) {
        const pt_vec3 *p = corner + i, *q = corner + (i + 1) % n;
        double a[3], b[3], c[3], dot, length;
        a[0] = p->x; a[1] = p->y; a[2] = p->z; b[0] = q->x; b[1] = q->y; b[2] = q->z;
        c[0] = a[1] * b[2] - a[2] * b[1]; c[1] = a[2] * b[0] - a[0] * b[2]; c[2] = a[0] * b[1] - a[1] * b[0];
        dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        sum += atan2(length, dot) * c[1] / length;
    }
    return fabs(sum) / 2;
}
static pt_scene *floor_scene(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_add_quad(s, pt_v3(-50, 0, -50), pt_v3(0, 0, 100), pt_v3(100, 0, 0), diffuse(s, 1));
    return s;
}
/* How far above the floor's origin a ray starts: what it sees, it sees from there. */
static float lift(void) {
    pt_scene *s = floor_scene();
    pt_vertex x;
    pt_ray ray;
    memset(&ray, 0, sizeof ray);
    memset(&x, 0, sizeof x);
    ray.org.y = 1; ray.dir.y = -1;
    CHECK(commit(s) && pt_intersect(s, &ray, &x));
    pt_scene_destroy(s);
    return x.error;
}
static void irradiance(void) {
    static const pt_weights weights[] = { { 0, 0, 0 }, { 0.1f, 0.9f, 0 } };
    float up = lift();
    int kind, k, i;
    for (kind = 0; kind < 8; kind++) for (k = 0; k < 2; k++) {
        pt_scene *s = floor_scene();
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, k ? 1024 : 2048);
        pt_vec3 c[4];
        double E = 0;
        stats_moments m;
        test_case("kind %d, weights %d", kind, k);
        d.weights = weights[k];
        if (kind < 2) {                                  /* a sphere: pi L sin^2 a cos t */
            pt_vec3 at = kind ? pt_v3(2, 1.5f, 1) : pt_v3(0, 2, 0);
            double d2;
            pt_add_sphere(s, at, 0.75f, lamp(s, 2, 0));
            at.y -= up;
            d2 = pti_dot(at, at);
            E = STATS_PI * 2 * (0.75 * 0.75 / d2) * at.y / sqrt(d2);
        } else if (kind < 6) {
            pt_vec3 at = kind == 2 ? pt_v3(-0.5f, 1, -0.75f) : kind == 3 ? pt_v3(2, 1.5f, 0.5f) : kind == 4 ? pt_v3(0.5f, 0.1f, -1) : pt_v3(-2, 0.3f, -2);
            pt_vec3 u = kind == 4 ? pt_v3(0, 0, 2) : kind == 5 ? pt_v3(4, 0, 0) : pt_v3(1, 0, 0);
            pt_vec3 v = kind == 4 ? pt_v3(0, 1, 0) : kind == 5 ? pt_v3(0, 0, 4) : pt_v3(0, 0, 1.5f);
            if (kind == 4) { c[0] = u; u = v; v = c[0]; }                         /* a wall, its front towards the origin */
            if (kind == 4) { at.z += 2; v = pti_neg(v); }
            pt_add_quad(s, at, u, v, lamp(s, 2, kind == 4));
            c[0] = at; c[1] = pti_add(at, u); c[2] = pti_add(c[1], v); c[3] = pti_add(at, v);
            for (i = 0; i < 4; i++) c[i].y -= up;
            E = 2 * polygon_irradiance(c, 4);
        } else {
            c[0] = kind == 6 ? pt_v3(-1, 1, -1) : pt_v3(1, 0.2f, -1);
            c[1] = kind == 6 ? pt_v3(2, 1.5f, -0.5f) : pt_v3(3, 2, -0.5f);
            c[2] = kind == 6 ? pt_v3(0, 1.2f, 1.5f) : pt_v3(1.5f, 0.4f, 2);
            triangle_of(s, c[0], c[1], c[2], lamp(s, 2, 1));
            for (i = 0; i < 3; i++) c[i].y -= up;
            E = 2 * polygon_irradiance(c, 3);
        }
        if (commit(s)) {
            m = render_pixels(s, &d);
            check_mean(&m, E / STATS_PI);
        }
        pt_scene_destroy(s);
    }
}
/* Lamps of 1 m, 100 m and 1 km away: known to a thousandth, no pixel far off. */
static void distant_lamps(void) {
    int kind, k, i;
    for (kind = 0; kind < 4; kind++) for (k = 0; k < 2; k++) {
        pt_scene *s = floor_scene();
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 16, 256);
        static float rgb[16 * 16 * 3];
        double distance = k ? 1000 : 100, E, most = 0;
        pt_vec3 dir = pt_v3(0.48f, 0.64f, 0.6f), c = pti_scale(dir, (float)distance), u, v, p[3];
        stats_moments m = { 0, 0, 0 };
        pt_material light = lamp(s, 1, 1);
        u = pti_normalize(pti_cross(dir, pt_v3(0, 1, 0)));
        v = pti_cross(u, dir);
        p[0] = pti_madd(u, -0.5f, c); p[1] = pti_madd(u, 0.5f, c); p[2] = pti_add(c, v);
        if (kind == 2) for (i = 0; i < 3; i++) p[i] = pti_madd(v, -1 / 3.0f, p[i]);
        if (kind == 0) pt_add_sphere(s, c, 0.5f, light);
        if (kind == 1) pt_add_quad(s, pti_madd(pti_add(u, v), -0.5f, c), u, v, light);
        if (kind == 2) triangle_of(s, p[0], p[1], p[2], light);
        if (kind == 3) for (i = 0; i < 4; i++) pt_add_sphere(s, pti_madd(u, 1.5f * (float)i, c), 0.5f, light);
        E = 0.64 / (distance * distance) * (kind == 0 ? 0.25 : kind == 1 ? 1 / STATS_PI : kind == 2 ? 0.5 / STATS_PI : 1);
        test_case("kind %d, at %g", kind, distance);
        if (commit(s) && render(s, &d, rgb, NULL)) {
            for (i = 0; i < 16 * 16; i++) { stats_push(&m, rgb[3 * i + 1]); most = fmax(most, rgb[3 * i + 1]); }
            CHECK_NEAR(m.mean / E, 1, 1.5e-3);
            CHECK(most < 1.25 * E);
            CHECK(3 * stats_error(&m) < 1e-3 * E);
        }
        pt_scene_destroy(s);
    }
}

/* ---- agreement with sampling that knows of no lights ---- */

static void check_agreement(const pt_scene *s, int spp) {
    pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, spp);
    stats_moments a, b;
    a = render_pixels(s, &d);
    d.weights.bsdf = 1; d.seed = 1;
    b = render_pixels(s, &d);
    CHECK(a.mean > 0.01);
    CHECK(stats_error(&a) < 0.01 * a.mean && stats_error(&b) < 0.03 * b.mean);
    CHECK_P(stats_welch_test(&a, &b));
}
static void many_lamps(void) {
    static const int count[] = { 2, 7, 100 };
    int i, side;
    for (i = 0; i < 3; i++) for (side = 0; side < 2; side++) {
        pt_scene *inner = lamps(count[i], side), *s = floor_scene();
        pt_xform up = { { 1, 0, 0, 0.3f, 0, 1, 0, 2.5f, 0, 0, 1, 0 } };
        pt_add_instance(s, inner, &up);
        test_case("%d lamps, side %d", count[i], side);
        if (commit(s)) { CHECK_EQ_INT(s->lights.count, count[i]); check_agreement(s, 512); }
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
/* Lamps on all sides of a floor that lets light through, or whose normals lean over, by each way to choose. */
static void lamps_all_around(void) {
    static const float normals[] = { 0.9f, 0.4f, 0, 0.9f, 0.4f, 0, 0.9f, 0.4f, 0 };
    static const char *const names[] = { "plain", "translucent", "leaning", "glass" };
    int kind, choose;
    for (kind = 0; kind < 4; kind++) for (choose = 0; choose < 3; choose++) {
        pt_scene *inner = lamps(30, choose == 1), *s = pt_scene_create(&(pt_scene_desc){ .choose = (pt_light_choice)choose });
        pt_vec3 v[3];
        pt_material m = pt_add_material(s, &(pt_material_desc){ .color = { 0.8f, 0.8f, 0.8f }, .translucency = kind == 1 ? 0.6f : 0.0f,
            .bsdf = kind == 3 ? PT_BSDF_DIELECTRIC : PT_BSDF_DIFFUSE, .roughness = kind == 3 ? 0.7f : 0.0f });
        v[0] = pt_v3(-1, 0, -1); v[1] = pt_v3(0, 0, 1.5f); v[2] = pt_v3(1, 0, -1);
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = &v[0].x, .vertex_count = 3, .normals = kind == 2 ? normals : NULL, .material = m });
        pt_add_instance(s, inner, &(pt_xform){ { 1, 0, 0, 0.1f, 0, 1, 0, 0.2f, 0, 0, 1, 0.1f } });
        test_case("%s, choice %d", names[kind], choose);
        if (commit(s)) check_agreement(s, kind == 3 ? 1024 : 512);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}
static void lamps_in_instances(void) {
    static const struct { const char *name; float m[12]; int spheres; } place[] = {
        { "moved", { 1, 0, 0, 0.5f, 0, 1, 0, 1.5f, 0, 0, 1, -0.3f }, 1 },
        { "mirrored", { -1, 0, 0, 0.5f, 0, 1, 0, 1.5f, 0, 0, 1, -0.3f }, 1 },
        { "upside down by mirror", { 1, 0, 0, 0.5f, 0, -1, 0, 1.5f, 0, 0, 1, -0.3f }, 1 },
        { "scaled", { 2, 0, 0, 0.5f, 0, 2, 0, 2.5f, 0, 0, 2, -0.3f }, 1 },
        { "scaled, turned and mirrored", { 0, 0, 1.5f, 0.5f, 0, 1.5f, 0, 2, 1.5f, 0, 0, -0.3f }, 1 },
        { "sheared", { 1, 0.5f, 0.7f, 0.5f, 0.2f, 1, 0.1f, 1.5f, 0, 0.3f, 1, -0.3f }, 0 },
        { "stretched", { 2, 0, 0, 0.5f, 0, 1, 0, 1.5f, 0, 0, 1, -0.3f }, 0 },
    };
    int i, kind, two_sided;
    for (i = 0; i < 7; i++) for (kind = 0; kind < 3; kind++) for (two_sided = 0; two_sided < 2; two_sided++) {
        pt_scene *inner = pt_scene_create(NULL), *s = floor_scene();
        pt_xform x;
        size_t want = 1;
        pt_material m = lamp(inner, 2, two_sided);
        memcpy(x.m, place[i].m, sizeof x.m);
        if (kind == 0) pt_add_quad(inner, pt_v3(-0.5f, 0, -0.5f), pt_v3(1, 0, 0), pt_v3(0, 0, 1), m);      /* faces down */
        if (kind == 1) triangle_of(inner, pt_v3(-0.5f, 0, -0.5f), pt_v3(1, 0.2f, 0), pt_v3(0, 0, 1), m);
        if (kind == 2) pt_add_sphere(inner, pt_v3(0, 0.2f, 0), 0.5f, m);
        if (kind == 0 && strcmp(place[i].name, "sheared") == 0) want = 2;
        if (kind == 2 && !place[i].spheres) want = 0;
        test_case("%s, kind %d, two-sided %d", place[i].name, kind, two_sided);
        if (commit(inner)) {
            pt_add_instance(s, inner, &x);
            if (commit(s)) {
                CHECK_EQ_INT(s->lights.count, want);
                if (i == 2 && kind < 2 && !two_sided) {  /* its back */
                    pt_render_desc d = view_down(pt_v3(0, 0, 0), 4, 64);
                    stats_moments a = render_pixels(s, &d);
                    CHECK(a.mean == 0);
                } else if (want) check_agreement(s, 512);
            }
        }
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
    }
}

/* ---- suns ---- */

static void add_sun(pt_scene *s, pt_vec3 from, float E, float radius_deg) {
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .color = { E, E, E }, .direction = pti_neg(from), .radius_deg = radius_deg });
}
static void add_even_map(pt_scene *s, float radiance) {  /* by picture, so that it has a density */
    int i;
    for (i = 0; i < 16 * 8; i++) map_pixels[i] = radiance;
    pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map_pixels, 16, 8) });
}
/* On level ground E sin(elevation), as long as all of the disk is above the horizon; suns and maps add up. */
static void sun_irradiance(void) {
    static const struct { float elevation, radius, elevation2, radius2, map; } c[] = {
        { 90, 0, 0, 0, 0 }, { 35, 0, 0, 0, 0 }, { 2, 0, 0, 0, 0 }, { 35, 0.001f, 0, 0, 0 }, { 35, 5, 0, 0, 0 }, { 55, 34, 0, 0, 0 },
        { 90, 90, 0, 0, 0 }, { 35, 0, 70, 3, 0 }, { 35, 0, 35.1f, 0, 0 }, { 50, 4, 52, 8, 2 }, { 35, 0, 70, 3, 0.5f }, { 20, 0, -30, 0, 1 },
        { -20, 0, 0, 0, 1 } };
    static const pt_weights weights[] = { { 0, 0, 0 }, { 0.3f, 0, 0.7f } };
    int i, k;
    for (i = 0; i < (int)(sizeof c / sizeof *c); i++) for (k = 0; k < 2; k++) {
        pt_scene *s = floor_scene();
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, 1024);
        double a = c[i].elevation * STATS_PI / 180, b = c[i].elevation2 * STATS_PI / 180, E;
        stats_moments m;
        add_sun(s, pt_v3((float)cos(a), (float)sin(a), 0), 10, c[i].radius);
        if (c[i].elevation2 != 0) add_sun(s, pt_v3(0, (float)(3 * sin(b)), (float)(3 * cos(b))), 4, c[i].radius2);
        if (c[i].map > 0) add_even_map(s, c[i].map);
        E = 10 * fmax(sin(a), 0) + (c[i].elevation2 != 0 ? 4 * fmax(sin(b), 0) : 0) + STATS_PI * c[i].map;
        d.weights = weights[k];
        test_case("case %d, weights %d", i, k);
        if (commit(s)) {
            m = render_pixels(s, &d);
            CHECK_NEAR(m.mean * STATS_PI / E, 1, 5e-3);
            CHECK_P(fabs(m.mean - E / STATS_PI) <= (c[i].radius == 0.001f ? 5e-3 : 1e-4) * E ? 1.0 : stats_t_test(&m, E / STATS_PI));
        }
        pt_scene_destroy(s);
    }
}
/* What a camera sees: E / (pi sin^2 r) inside the disk, none outside of it; the default points straight down. */
static void sun_in_the_sky(void) {
    static const float radius[] = { 0, 0.01f, 1, 30, 90 };
    int i, k;
    for (i = 0; i < 5; i++) {
        pt_scene *s = pt_scene_create(NULL);
        double r = (radius[i] > 0 ? (double)radius[i] : 0.2665) * STATS_PI / 180, L = 3 / (STATS_PI * sin(r) * sin(r));
        pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .color = { 3, 3, 3 }, .radius_deg = radius[i] });
        test_case("radius %g", (double)radius[i]);
        if (commit(s)) for (k = 0; k < 2; k++) {
            double a = r * (k ? 1.01 : 0.99);
            pt_vec3 d = pt_v3((float)sin(a), (float)cos(a), 0), got = pti_environment_radiance(&s->environment, d, NOWHERE);
            CHECK_NEAR(got.y, k ? 0 : L, 1e-5 * L);
            CHECK((pti_environment_pdf(&s->environment, PTI_RECEIVER_ALL, d, NOWHERE) > 0) == !k);
        }
        pt_scene_destroy(s);
    }
}
/* 16 x 16 pixels, and the same with BSDF sampling alone: the differences are 0 on average, by t-test. */
static void check_pictures_agree(const pt_scene *s, pt_render_desc d, int naive_spp) {
    static float a[16 * 16 * 3], b[16 * 16 * 3];
    stats_moments m = { 0, 0, 0 };
    double mean = 0;
    int i;
    if (!render(s, &d, a, NULL)) return;
    d.weights.bsdf = 1; d.seed = 1; d.spp = naive_spp;
    if (!render(s, &d, b, NULL)) return;
    for (i = 0; i < 16 * 16; i++) { stats_push(&m, a[3 * i + 1] - b[3 * i + 1]); mean += a[3 * i + 1] / 256; }
    CHECK_P(stats_t_test(&m, 0));
    CHECK(mean > 0.05);
    CHECK_NEAR(stats_error(&m) / mean, 0, 0.03);
}
/* One that the BSDF alone finds now and then, over a slope and a mirror's picture of it. */
static void big_sun_agrees(void) {
    int with_map;
    for (with_map = 0; with_map < 2; with_map++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 2, 3), pt_v3(0, 0, 0), 20, 16, 256);
        pt_add_quad(s, pt_v3(-5, -0.5f, -5), pt_v3(0, 0, 10), pt_v3(10, 1, 0), diffuse(s, 0.6f));
        pt_add_sphere(s, pt_v3(0.1f, 0.3f, 0), 0.3f, mirror(s, 0.8f));
        add_sun(s, pt_v3(0.5f, 1, 0.4f), 5, 5);
        add_sun(s, pt_v3(-0.5f, 1, 0.3f), 2, 6);
        if (with_map) add_even_map(s, 0.3f);
        test_case("map %d", with_map);
        if (commit(s)) check_pictures_agree(s, d, 2048);
        pt_scene_destroy(s);
    }
}
typedef struct far_light { const pti_environment *e; int receiver, lost; } far_light;
static int far_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    far_light *f = (far_light *)ctx;
    int tries;
    for (tries = 0; tries < 100; tries++) {
        uint32_t u = pt_rng_u32(rng);
        float v = pt_rng_float(rng);
        if (pti_environment_sample(f->e, f->receiver, u, v, wi, NOWHERE)) return 1;
        f->lost++;
    }
    return 0;
}
static double far_pdf(void *ctx, pt_vec3 wi) { const far_light *f = (const far_light *)ctx; return pti_environment_pdf(f->e, f->receiver, wi, NOWHERE); }
static void suns_and_map_densities(void) {
    enum { ONE, TINY, TWO, OVERLAP, NESTED_MAP, DARK_MAP, SKY, KINDS };
    int kind;
    for (kind = 0; kind < KINDS; kind++) {
        pt_scene *s = pt_scene_create(NULL);
        chi2_directions_desc d;
        far_light f;
        memset(&d, 0, sizeof d);
        d.ax = 0.5; d.ay = 1; d.az = 0.4;
        if (kind == SKY) pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = { -0.5f, -1, -0.4f }, .radius_deg = 6 });
        else add_sun(s, pt_v3(0.5f, 1, 0.4f), 5, kind == TINY ? 0 : 5);
        if (kind == ONE || kind == TINY) d.zoom = kind == TINY ? 1.2e-5 : 0.005;
        if (kind == TWO) add_sun(s, pt_v3(-0.5f, 0.2f, 0.1f), 7, 20);
        if (kind == OVERLAP || kind == NESTED_MAP) { add_sun(s, pt_v3(0.5f, 1, 0.5f), 7, 20); add_sun(s, pt_v3(0.5f, 1, 0.4f), 2, 5); }
        if (kind == NESTED_MAP) add_even_map(s, 1);
        if (kind == DARK_MAP) add_even_map(s, 0);
        d.sample = far_sample; d.pdf = far_pdf; d.ctx = &f;
        d.n = 20000; d.tolerance = 0.004; d.zero_allowed = 2;
        f.e = &s->environment; f.lost = 0; f.receiver = kind % 2 ? PTI_RECEIVER_ALL : 40;
        test_case("kind %d", kind);
        if (commit(s)) {
            chi2_directions(&d);
            CHECK(f.lost < 20);
            CHECK_EQ_INT(f.e->part_count, f.e->sun_count + (kind >= NESTED_MAP ? 512 : 0));
        }
        pt_scene_destroy(s);
    }
}
static void suns_are_in_the_mixture(void) {              /* also where there is nothing else */
    int k;
    for (k = 0; k < 3; k++) {
        pt_scene *s = floor_scene();
        pt_vertex x = vertex_of(pt_v3(0, 1, 0), pt_v3(0, 1, 0), pt_v3(0, 1, 0));
        pt_weights automatic = { 0, 0, 0 };
        if (k < 2) add_sun(s, pt_v3(0, 1, 1), 5, 0);
        if (k != 1) sky(s, 1);
        if (commit(s)) {
            pti_surface surface;
            pti_mixture m;
            pti_surface_at(s->materials + 1, &x, &surface);
            m = pti_mixture_at(s, &surface, &automatic);
            CHECK_NEAR(m.environment, k < 2 ? 0.5 : 0, 1e-6);
            CHECK_NEAR(pti_environment_irradiance(&s->environment, x.ns), k < 2 ? 5 * sqrt(0.5) : 0, 0.4);
            CHECK_NEAR(pti_environment_irradiance(&s->environment, pt_v3(0, 0, 0)), k < 2 ? 5 : 0, 1e-4);
        }
        pt_scene_destroy(s);
    }
}

/* ---- points and spots ---- */

static void points_are_spheres(void) {
    static float rgb[2][16 * 16 * 3];
    pt_render_desc d = view(pt_v3(0, 2, 4), pt_v3(0, 0.6f, 0), 50, 16, 32);
    int k;
    for (k = 0; k < 2; k++) {
        pt_scene *s = floor_scene();
        float L = 7 * (1 / (4 * PTI_PI * PTI_PI * 0.3f * 0.3f));
        pt_material m = { 0 };
        if (k) m = pt_add_material(s, &(pt_material_desc){ .emission = { L, L, L } });
        if (k) pt_add_sphere(s, pt_v3(0.1f, 1, 0), 0.3f, m);
        else pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_POINT, .position = { 0.1f, 1, 0 }, .radius = 0.3f, .color = { 7, 7, 7 } });
        if (commit(s)) { CHECK_EQ_INT(s->lights.count, 1); render(s, &d, rgb[k], NULL); }
        pt_scene_destroy(s);
    }
    CHECK(memcmp(rgb[0], rgb[1], sizeof rgb[0]) == 0);
    CHECK(rgb[0][3 * (16 * 8 + 8)] > 0);
}
/* Irradiance on the floor, along a line: P cos / (4 pi d^2), and what of it the cone lets pass. The floor is a small patch at
   the origin, over which the lamp moves: rays start a little above it, in proportion to its coordinates, and a lamp of 1 mm
   would notice that. It is smaller still, or the mean over it where a narrow cone fades would not be what is at its centre. */
static void spots_on_a_line(void) {
    static const struct { float cone, blend, tilt; } c[] = { { 0, 0, 0 }, { 30, 0.5f, 20 }, { 20, 1, 0 }, { 90, 0.3f, 60 }, { 3, 0.2f, 30 },
                                                             { -1, 0, 0 } };       /* none: a point */
    int i, k;
    for (i = 0; i < (int)(sizeof c / sizeof *c); i++) for (k = 0; k < 9; k++) {
        pt_scene *s = pt_scene_create(NULL);
        double cone = c[i].cone > 0 ? (double)c[i].cone : 45, blend = c[i].blend > 0 ? (double)c[i].blend : 0.15, tilt = c[i].tilt * STATS_PI / 180;
        double off = (k - 4) / 3.5 * cone * STATS_PI / 180, angle = tilt + off, x, d2, outer, inner, g = 1, E;
        pt_render_desc d;
        stats_moments m;
        if (fabs(angle) > 1.3) { pt_scene_destroy(s); continue; }
        x = 2 * tan(angle);
        d2 = 4 + x * x;
        outer = cos(cone * STATS_PI / 180); inner = cos(cone * (1 - blend) * STATS_PI / 180);
        if (i < 5) { g = fmin(fmax((cos(off) - outer) / (inner - outer), 0), 1); g = g * g * (3 - 2 * g); }
        E = 50 * g * 2 / sqrt(d2) / (4 * STATS_PI * d2);
        pt_add_quad(s, pt_v3(-0.05f, 0, -0.05f), pt_v3(0, 0, 0.1f), pt_v3(0.1f, 0, 0), diffuse(s, 1));
        pt_add_light(s, &(pt_light_desc){ .kind = i < 5 ? PT_LIGHT_SPOT : PT_LIGHT_POINT, .position = { (float)-x, 2, 0 }, .radius = 0.0004f,
            .direction = { (float)(3 * sin(tilt)), (float)(-3 * cos(tilt)), 0 }, .color = { 50, 50, 50 }, .cone_deg = c[i].cone, .blend = c[i].blend });
        d = view_down(pt_v3(0, 0, 0), 8, 256);
        d.weights.bsdf = 0.05f; d.weights.lights = 0.95f;
        d.camera.vfov_deg = 0.02f;
        test_case("spot %d, place %d", i, k);
        if (commit(s)) {
            m = render_pixels(s, &d);
            CHECK_NEAR(m.mean * STATS_PI, E, 5e-3 * E + 2e-5);
            if (g > 0) CHECK_P(fabs(m.mean * STATS_PI - E) < 5e-4 * E + 2e-5 ? 1.0 : stats_t_test(&m, E / STATS_PI));
        }
        pt_scene_destroy(s);
    }
}
/* Where any of a spot's light comes, its emitter may be drawn; and it is drawn there alone, or nearly. */
static void spots_shine_where_they_are_drawn(void) {
    static const float cones[] = { 0.1f, 5, 45, 90 };
    pt_rng rng;
    int i, k, near = 0;
    pt_rng_seed(&rng, 5, 5);
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        const pti_emitter *e;
        const pti_profile *profile;
        pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SPOT, .position = { 0.2f, 0.1f, 0.3f }, .radius = 0.4f, .direction = { 1, 2, -3 },
                                          .color = { 9, 9, 9 }, .cone_deg = cones[k] });
        if (!commit(s)) { pt_scene_destroy(s); continue; }
        e = s->lights.emitters;
        profile = &s->materials[1].profile;
        test_case("cone %g", (double)cones[k]);
        for (i = 0; i < 20000; i++) {
            pt_vec3 n = stats_direction(&rng), w, t, b, q, p;
            float u = pt_rng_float(&rng), v = pt_rng_float(&rng), far = 5 * pt_rng_float(&rng);
            pti_basis(profile->axis, &t, &b);
            w = pti_normalize(pti_to_world(t, b, profile->axis, pti_sample_cone(profile->outer, u, v)));
            q = pti_madd(n, 0.4f, e->p);
            p = pti_madd(w, far, q);
            if (pti_dot(n, w) > 1e-3f && far > 1e-3f && pti_profile_at(profile, w) > 1e-4f && !CHECK(pti_emitter_faces(e, p))) break;
            p = pti_madd(stats_direction(&rng), 5, e->p);
            near += pti_emitter_faces(e, p);
        }
        CHECK(!pti_emitter_faces(e, pti_madd(profile->axis, -5, e->p)));
        CHECK(near < (k < 3 ? 20000 * 0.25 : 20000));
        near = 0;
        pt_scene_destroy(s);
    }
}
static void spots_agree(void) {                          /* wide ones, which the BSDF finds, too; seen, and in a mirror */
    pt_scene *s = floor_scene();
    pt_render_desc d = view(pt_v3(0, 2, 6), pt_v3(0, 0.5f, 0), 40, 16, 512);
    pt_add_sphere(s, pt_v3(-1, 0.5f, 0), 0.5f, mirror(s, 0.8f));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SPOT, .position = { 0, 1.5f, 0 }, .radius = 0.4f, .direction = { 0.3f, -1, 0 },
                                      .color = { 90, 90, 90 }, .cone_deg = 40, .blend = 0.6f });
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SPOT, .position = { 1, 1.2f, 0 }, .radius = 0.3f, .direction = { -1, -0.2f, 0.4f },
                                      .color = { 50, 50, 50 }, .cone_deg = 60 });
    if (commit(s)) check_pictures_agree(s, d, 4096);
    pt_scene_destroy(s);
}

/* ---- the sky ---- */

static pt_vec3 towards(double elevation, double azimuth) {             /* degrees; azimuth from +x */
    double e = elevation * STATS_PI / 180, a = azimuth * STATS_PI / 180;
    return pt_v3((float)(cos(e) * cos(a)), (float)sin(e), (float)(cos(e) * sin(a)));
}
static pt_scene *clear_sky(double elevation, float turbidity) {
    pt_scene *s = pt_scene_create(NULL);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = pti_neg(towards(elevation, 40)), .turbidity = turbidity });
    commit(s);
    return s;
}
static pt_vec3 sky_at(const pt_scene *s, pt_vec3 d) {     /* without the disk */
    return pti_environment_map(&s->environment, d, NOWHERE);
}
/* Of level ground under the sky's dome, and of a surface that faces the sun, in W/m^2. */
static pt_vec3 dome_irradiance(const pt_scene *s) {
    pt_vec3 sum = { 0, 0, 0 };
    int i, n = 64;
    for (i = 0; i < n * n; i++) {
        pt_vec3 d = pti_sample_cosine(((float)(i % n) + 0.5f) / (float)n, ((float)(i / n) + 0.5f) / (float)n);
        sum = pti_add(sum, sky_at(s, pt_v3(d.x, d.z, d.y)));
    }
    return pti_scale(sum, (float)(STATS_PI / (n * n)));
}
static pt_vec3 disk_irradiance(const pt_scene *s) {
    const pti_sun *sun = s->environment.suns;
    if (!s->environment.sun_count) return pt_v3(0, 0, 0);
    return pti_scale(sun->radiance, (float)STATS_PI * sun->one_minus_cos * (2 - sun->one_minus_cos));
}
static void sky_is_finite_and_symmetric(void) {
    static const float turbidity[] = { 1.8f, 10 };
    int k, e, i;
    for (k = 0; k < 2; k++) for (e = -90; e <= 90; e += e < -10 ? 40 : e < 10 ? 5 : 40) {
        pt_scene *s = clear_sky(e, turbidity[k]);
        test_case("turbidity %g, sun at %d degrees", (double)turbidity[k], e);
        for (i = 0; i < 600; i++) {
            double elevation = i < 100 ? (i - 50) * 0.02 : i < 200 ? 90 - 0.1 * (i - 100) : -90 + 0.45 * (i - 200), off = (i * 37) % 180;
            pt_vec3 a = sky_at(s, towards(elevation, 40 + off)), b = sky_at(s, towards(elevation, 40 - off));
            if (!CHECK(pti_finite3(a) && a.x >= 0 && a.y >= 0 && a.z >= 0)) break;
            if (!CHECK(pti_luminance(a) > 0 || e < -10)) break;
            if (!CHECK_NEAR(a.x, b.x, 2e-3 * a.x) || !CHECK_NEAR(a.y, b.y, 2e-3 * a.y) || !CHECK_NEAR(a.z, b.z, 2e-3 * a.z)) break;
        }
        CHECK(pti_finite3(sky_at(s, pt_v3(0, 1, 0))) && pti_finite3(sky_at(s, pt_v3(0, -1, 0))));
        pt_scene_destroy(s);
    }
}
/* No step at the horizon, nor elsewhere but at the sun. */
static void sky_has_no_seams(void) {
    static const double suns[] = { 60, 15, 2, -3, -8 };
    int i, k;
    for (k = 0; k < 5; k++) {
        pt_scene *s = clear_sky(suns[k], 3);
        double last = 0;
        test_case("sun at %g degrees", suns[k]);
        for (i = 0; i <= 7200; i++) {                    /* from nadir to zenith, away from the sun */
            double L = pti_luminance(sky_at(s, towards(-90 + i * 0.025, 160)));
            if (i && !CHECK_NEAR(L / last, 1, 0.02)) break;
            last = L;
        }
        pt_scene_destroy(s);
    }
}
static void sky_looks_as_it_should(void) {
    pt_scene *noon = clear_sky(60, 2), *evening = clear_sky(3, 2), *set = clear_sky(-0.5, 2), *dusk = clear_sky(-5, 2), *hazy = clear_sky(60, 8);
    pt_vec3 sun = disk_irradiance(noon), low = disk_irradiance(evening), dome = dome_irradiance(noon), L, H;
    double lux;
    CHECK(sun.x > sun.y && sun.y > sun.z && low.y / low.x < 0.7 * (sun.y / sun.x) && low.z / low.x < 0.3 * (sun.z / sun.x));  /* redder */
    lux = pti_luminance(sun) * 179;
    CHECK(lux > 80000 && lux < 110000);                  /* a clear noon: direct 100 klx, diffuse 8 to 25 */
    lux = pti_luminance(dome) * 179;
    CHECK(lux > 8000 && lux < 35000);
    CHECK(dome.z > 1.3f * dome.x);                       /* blue */
    L = sky_at(noon, pt_v3(0, 1, 0));
    H = sky_at(noon, towards(1, 160));
    CHECK(pti_luminance(H) > 1.5f * pti_luminance(L));
    CHECK(L.z / L.x > 1.3f * H.z / H.x);                 /* the horizon is paler */
    CHECK(pti_luminance(disk_irradiance(hazy)) < 0.7f * pti_luminance(sun));
    CHECK(set->environment.sun_count == 0 && dusk->environment.sun_count == 0);
    L = dome_irradiance(evening);
    CHECK(L.x / L.z > dome.x / dome.z);                  /* the evening's sky is redder than the noon's */
    lux = pti_luminance(dome_irradiance(set)) * 179;     /* the tables of twilight: 400 to 800 lx at sunset, 3.4 at 6 degrees */
    CHECK(lux > 300 && lux < 1200);
    L = dome_irradiance(dusk);
    lux = pti_luminance(L) * 179;
    CHECK(lux > 5 && lux < 40 && L.z > 1.5f * L.x);      /* the blue hour */
    L = sky_at(set, towards(2, 40));
    CHECK(L.x > 1.5f * L.y && L.y > 1.5f * L.z);         /* red, where the sun has gone */
    pt_scene_destroy(noon); pt_scene_destroy(evening); pt_scene_destroy(set); pt_scene_destroy(dusk); pt_scene_destroy(hazy);
}
/* Straight up, one atmosphere of each optical depth; low, as many as tables say (Kasten and Young 1989). */
static void sunlight_through_air(void) {
    static const double wavelength[] = { 0.636, 0.544, 0.442 }, ozone[] = { 0.11, 0.08, 0.005 };
    static const double height[] = { 90, 60, 30, 10, 5, 2 }, airs[] = { 1, 1.154, 1.995, 5.58, 10.31, 19.5 };
    int i, k;
    for (i = 0; i < 6; i++) {
        pti_air air = pti_air_of(2);
        pt_vec3 got = pti_air_sunlight(&air, 0, (float)sin(height[i] * STATS_PI / 180));
        for (k = 0; k < 3; k++) {
            double depth = 0.008735 * pow(wavelength[k], -4.08) + (0.04608 * 2 - 0.04586) * pow(wavelength[k], -1.3) + 0.35 * ozone[k];
            test_case("channel %d, sun at %g degrees", k, height[i]);
            CHECK_NEAR(-log(pti_axis(got, k) / pti_axis(air.sun, k)) / (depth * airs[i]), 1, i < 4 ? 0.02 : i < 5 ? 0.06 : 0.1);
        }
    }
}
/* A picture of level ground gets the dome's irradiance and the disk's, and color multiplies both. */
static void sky_lights_the_ground(void) {
    int k;
    for (k = 0; k < 2; k++) {
        pt_scene *s = floor_scene();
        pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, 1024);
        pt_vec3 color = k ? pt_v3(0.5f, 0.25f, 0.125f) : pt_v3(0, 0, 0);
        pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SKY, .direction = pti_neg(towards(30, 40)), .color = color });
        if (commit(s)) {
            double E = dome_irradiance(s).y + 0.5 * (double)disk_irradiance(s).y, one;
            pt_scene *plain = clear_sky(30, 0);
            stats_moments m = render_pixels(s, &d);
            CHECK_NEAR(m.mean * STATS_PI / E, 1, 5e-3);
            one = dome_irradiance(plain).y + 0.5 * (double)disk_irradiance(plain).y;
            CHECK_NEAR(E / one, k ? 0.25 : 1, 1e-4);
            pt_scene_destroy(plain);
        }
        pt_scene_destroy(s);
    }
}

void test_light(void) {
    RUN(flat_emitters);
    RUN(tiny_flat_emitters);
    RUN(spheres);
    RUN(behind);
    RUN(densities_in_double);
    RUN(light_tree);
    RUN(every_emitter_counts);
    RUN(no_lamp_is_forgotten);
    RUN(receivers);
    RUN(simple_choices);
    RUN(many_lamps_at_once);
    RUN(lamps_without_memory);
    RUN(a_hidden_texel_counts);
    RUN(environments);
    RUN(bright_is_likely);
    RUN(odd_maps);
    RUN(odd_maps_light_the_floor);
    RUN(irradiance_of_receivers);
    RUN(classes_of_normals);
    RUN(texel_directions); RUN(places_are_where_they_are_found);
    RUN(the_sky_in_pictures);
    RUN(bright_pole);
    RUN(irradiance);
    RUN(distant_lamps);
    RUN(many_lamps);
    RUN(lamps_all_around);
    RUN(lamps_in_instances);
    RUN(sun_irradiance);
    RUN(sun_in_the_sky);
    RUN(big_sun_agrees);
    RUN(suns_and_map_densities);
    RUN(suns_are_in_the_mixture);
    RUN(points_are_spheres);
    RUN(spots_on_a_line);
    RUN(spots_shine_where_they_are_drawn);
    RUN(spots_agree);
    RUN(sunlight_through_air);
    RUN(sky_is_finite_and_symmetric);
    RUN(sky_has_no_seams);
    RUN(sky_looks_as_it_should);
    RUN(sky_lights_the_ground);
}
