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
        double tiny = k ? (double)PTI_TINY_RECT : (double)PTI_TINY_TRIANGLE, cosine = 0.8, distance = sqrt(e.area * cosine / (tiny * ratio[i]));
        pt_vec3 middle = pti_madd(pti_add(e.e1, e.e2), k ? 0.5f : 1 / 3.0f, e.p), c[3];
        pt_vec3 p = pti_madd(pt_v3(0.6f, 0, 0.8f), (float)distance, middle);
        pti_rect r = pti_rect_seen_from(&e.frame, pti_sub(e.p, p));
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

typedef struct forest { const pti_lights *l; pt_vec3 p; double total; int lost; } forest;
static int forest_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    forest *f = (forest *)ctx;
    int tries;
    for (tries = 0; tries < 100; tries++) {
        uint32_t choice = pt_rng_u32(rng);
        float u = pt_rng_float(rng), v = pt_rng_float(rng);
        if (pti_lights_sample(f->l, f->p, choice, u, v, wi)) return 1;
        f->lost++;
        if (f->total < 1 - 1e-9) return 0;               /* this was no loss on a rim */
    }
    return 0;
}
static double forest_pdf(void *ctx, pt_vec3 wi) {
    const forest *f = (const forest *)ctx;
    return pti_lights_pdf(f->l, f->p, wi);
}
/* All leaves, no boxes: sum of P(leaf) p_leaf(wi), or with wi NULL the sum of P(leaf) over those that shine. */
static double all_leaves(const pti_lights *l, uint32_t node, pt_vec3 p, const pt_vec3 *wi) {
    const pti_light_node *n = l->nodes + node;
    float w;
    if (n->left == n->right) {
        const pti_emitter *e = l->emitters + n->left;
        return wi ? pti_emitter_pdf(e, p, *wi) : pti_emitter_faces(e, p);
    }
    w = pti_light_weight(l, n, p);
    if (w < 0) return 0;
    return (double)w * all_leaves(l, n->left, p, wi) + (1 - (double)w) * all_leaves(l, n->right, p, wi);
}
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
            f.l = &s->lights; f.p = pt_v3(from[k][0], from[k][1], from[k][2]); f.lost = 0;
            f.total = all_leaves(f.l, 0, f.p, NULL);
            test_case("%d lights, side %d, place %d, total %g", count[i], side, k, f.total);
            if (f.total <= 0) { CHECK(pti_lights_pdf(f.l, f.p, pt_v3(0, 0, 1)) == 0); continue; }
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
            double want;
            size_t j;
            int here = 0;
            if (k & 1 && !pti_lights_sample(&s->lights, p, pt_rng_u32(&rng), u, v, &wi)) continue;
            want = all_leaves(&s->lights, 0, p, &wi);
            for (j = 0; j < s->lights.count; j++) here += pti_emitter_pdf(s->lights.emitters + j, p, wi) > 0;
            several += here > 1;
            none += here == 0;
            test_case("%d lights, case %d", count[i], k);
            CHECK_NEAR(pti_lights_pdf(&s->lights, p, wi), want, 1e-5 * want);
        }
        pt_scene_destroy(s);
    }
    CHECK(several > 1000 && none > 500);
}

/* ---- the environment ---- */

/* On the map itself, where the texels' borders are those of cells: u and v by our own words for the promise, that the middle
   is towards -z, its right towards +x, the top +y, and all turned counter-clockwise. */
typedef struct turned_sky { const pti_environment *e; double turn; } turned_sky;
static pt_vec3 direction_at(double turn_deg, double u, double v) {
    double a = turn_deg * STATS_PI / 180, theta = v * STATS_PI, phi = (u - 0.5) * 2 * STATS_PI;
    double x = sin(theta) * sin(phi), z = -sin(theta) * cos(phi);
    return pt_v3((float)(x * cos(a) + z * sin(a)), (float)cos(theta), (float)(z * cos(a) - x * sin(a)));
}
static int environment_sample(void *ctx, pt_rng *rng, float uv[2]) {
    const turned_sky *s = (const turned_sky *)ctx;
    float u = pt_rng_float(rng), v = pt_rng_float(rng);
    double a = s->turn * STATS_PI / 180, x, z, b;
    pt_vec3 wi;
    if (!pti_environment_sample(s->e, u, v, &wi)) return 0;
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
    return pti_environment_pdf(s->e, direction_at(s->turn, u, v)) * 2 * STATS_PI * STATS_PI * sin(v * STATS_PI);
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
        t.e = &s->environment; t.turn = turn[k];
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
            double L = pti_luminance(pti_environment_radiance(&s->environment, d)), p = pti_environment_pdf(&s->environment, d);
            if (L > 0 && !CHECK(p > 0)) break;
            if (L > 0) worst = fmax(worst, L / p / (4 * STATS_PI * (double)s->environment.mean));
        }
        test_case("map %d", kind);
        CHECK(worst < 35);                               /* a tent's corner is 16 times its mean; half the sine, at a pole */
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
            CHECK_NEAR(pti_environment_radiance(&s->environment, d).x, 1 + y * 8 + x, 2e-4);
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
static void irradiance(void) {
    static const pt_weights weights[] = { { 0, 0, 0 }, { 0.1f, 0.9f, 0 } };
    int kind, k;
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
            double d2 = pti_dot(at, at);
            pt_add_sphere(s, at, 0.75f, lamp(s, 2, 0));
            E = STATS_PI * 2 * (0.75 * 0.75 / d2) * at.y / sqrt(d2);
        } else if (kind < 6) {
            pt_vec3 at = kind == 2 ? pt_v3(-0.5f, 1, -0.75f) : kind == 3 ? pt_v3(2, 1.5f, 0.5f) : kind == 4 ? pt_v3(0.5f, 0.1f, -1) : pt_v3(-2, 0.3f, -2);
            pt_vec3 u = kind == 4 ? pt_v3(0, 0, 2) : kind == 5 ? pt_v3(4, 0, 0) : pt_v3(1, 0, 0);
            pt_vec3 v = kind == 4 ? pt_v3(0, 1, 0) : kind == 5 ? pt_v3(0, 0, 4) : pt_v3(0, 0, 1.5f);
            if (kind == 4) { c[0] = u; u = v; v = c[0]; }                         /* a wall, its front towards the origin */
            if (kind == 4) { at.z += 2; v = pti_neg(v); }
            pt_add_quad(s, at, u, v, lamp(s, 2, kind == 4));
            c[0] = at; c[1] = pti_add(at, u); c[2] = pti_add(c[1], v); c[3] = pti_add(at, v);
            E = 2 * polygon_irradiance(c, 4);
        } else {
            c[0] = kind == 6 ? pt_v3(-1, 1, -1) : pt_v3(1, 0.2f, -1);
            c[1] = kind == 6 ? pt_v3(2, 1.5f, -0.5f) : pt_v3(3, 2, -0.5f);
            c[2] = kind == 6 ? pt_v3(0, 1.2f, 1.5f) : pt_v3(1.5f, 0.4f, 2);
            triangle_of(s, c[0], c[1], c[2], lamp(s, 2, 1));
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

static void check_agreement(const pt_scene *s) {
    pt_render_desc d = view_down(pt_v3(0, 0, 0), 8, 512);
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
        if (commit(s)) { CHECK_EQ_INT(s->lights.count, count[i]); check_agreement(s); }
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
                } else if (want) check_agreement(s);
            }
        }
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
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
    RUN(environments);
    RUN(bright_is_likely);
    RUN(texel_directions);
    RUN(the_sky_in_pictures);
    RUN(bright_pole);
    RUN(irradiance);
    RUN(distant_lamps);
    RUN(many_lamps);
    RUN(lamps_in_instances);
}
