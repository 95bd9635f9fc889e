/* >>material: white furnaces, limits in which one material is another, textures on every number, callbacks. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "surfaces.h"

#define WHITE .color = { 1, 1, 1 }
static const pt_vec3 white = { 1, 1, 1 };

/* ---- white furnaces: what absorbs nothing sends on all that comes ---- */

/* Roughness may vary as far as the renderer knows, so no table knows it. */
static void leave_it(void *user, const pt_vertex *x, pt_material_desc *m) { (void)user; (void)x; (void)m; }
/* eta: the index that flux is counted with. each: how much a single direction may be off; mean: the average over eight. */
typedef struct furnace { const char *name; double mean, each, eta; int inside; pt_material_desc d; } furnace;
#define OF(...) { __VA_ARGS__ }
#define DIELECTRIC(n) { "glass of " #n, 0.005, 0.0125, n, 1, OF(.bsdf = PT_BSDF_DIELECTRIC, .ior = (float)(n)) }
#define GLOSSY(n) { "plastic of " #n, 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .ior = (float)(n)) }
static const furnace furnaces[] = {
    { "diffuse", 0.005, 0.01, 1, 0, OF(WHITE) },
    { "rough translucent", 0.005, 0.01, 1, 0, OF(WHITE, .translucency = 0.5f) },
    { "metal", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_CONDUCTOR, WHITE) },
    { "metal across 0.4", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_CONDUCTOR, WHITE, .roughness_y = 0.4f, .rotation_deg = 20) },
    { "metal across 1", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_CONDUCTOR, WHITE, .roughness_y = 1) },
    DIELECTRIC(1.01), DIELECTRIC(1.1), DIELECTRIC(1.33), DIELECTRIC(1.5), DIELECTRIC(2.0), DIELECTRIC(4.0),
    DIELECTRIC(1 / 1.01), DIELECTRIC(1 / 1.1), DIELECTRIC(1 / 1.33), DIELECTRIC(1 / 1.5), DIELECTRIC(1 / 2.0), DIELECTRIC(1 / 4.0),
    { "glass across 0.4", 0.005, 0.01, 1.5, 1, OF(.bsdf = PT_BSDF_DIELECTRIC, .roughness_y = 0.4f) },
    { "thin", 0.005, 0.01, 1, 1, OF(.bsdf = PT_BSDF_DIELECTRIC, .thin = 1) },
    { "thin of 4", 0.005, 0.01, 1, 1, OF(.bsdf = PT_BSDF_DIELECTRIC, .thin = 1, .ior = 4) },
    GLOSSY(1.01), GLOSSY(1.1), GLOSSY(1.33), GLOSSY(1.5), GLOSSY(2.0), GLOSSY(4.0),
    GLOSSY(1 / 1.01), GLOSSY(1 / 1.1), GLOSSY(1 / 1.33), GLOSSY(1 / 1.5), GLOSSY(1 / 2.0), GLOSSY(1 / 4.0),
    { "plastic across 0.9", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .roughness_y = 0.9f) },
    { "plastic of 2.5 across 1", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .roughness_y = 1, .ior = 2.5f) },
    { "principled glass across 0.9", 0.005, 0.01, 1.5, 1, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .transmission = 1, .roughness_y = 0.9f) },
    { "varied metal across 0.9", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_CONDUCTOR, WHITE, .roughness_y = 0.9f, .shade = leave_it) },
    { "varied glass across 0.9", 0.005, 0.0125, 1.5, 1, OF(.bsdf = PT_BSDF_DIELECTRIC, .roughness_y = 0.9f, .shade = leave_it) },
    { "varied thin across 1", 0.005, 0.01, 1, 1, OF(.bsdf = PT_BSDF_DIELECTRIC, .thin = 1, .roughness_y = 1, .shade = leave_it) },
    { "varied plastic across 1", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .roughness_y = 1, .shade = leave_it) },
    { "half metal", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .metallic = 0.5f) },
    { "principled glass", 0.005, 0.01, 1.5, 1, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .transmission = 1) },
    { "principled thin", 0.005, 0.01, 1, 1, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .transmission = 1, .thin = 1) },
    { "smooth coat", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .coat = 1) },
    { "rough coat", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .coat = 0.8f, .coat_roughness = 0.7f) },
    { "coated metal", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .coat = 1, .coat_roughness = 0.4f, .coat_ior = 2, .metallic = 1) },
    { "fuzz", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .sheen = 1) },
    { "soft fuzz", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .sheen = 1, .sheen_roughness = 0.1f) },
    { "stiff fuzz", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .sheen = 1, .sheen_roughness = 1) },
    { "translucent", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .translucency = 0.5f) },
    { "transparent", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .translucency = 0.2f, .transparency = 0.3f) },
    { "everything", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_PRINCIPLED, WHITE, .metallic = 0.3f, .coat = 0.5f, .coat_roughness = 0.3f, .sheen = 0.5f,
                                          .translucency = 0.5f, .transparency = 0.2f, .specular = 0.5f) },
    { "mix", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_MIX, .mix = 0.4f) },
    { "mix of rough diffuse", 0.005, 0.01, 1, 0, OF(.bsdf = PT_BSDF_MIX, .mix = 0.5f) },
};
#define FURNACES ((int)(sizeof furnaces / sizeof furnaces[0]))
static pt_material add_furnace(pt_scene *s, const furnace *f, float rough) {
    pt_material_desc d = f->d, part = { .bsdf = PT_BSDF_CONDUCTOR, WHITE };
    d.roughness = rough;
    if (d.bsdf == PT_BSDF_MIX) {
        part.roughness = rough;
        d.a = pt_add_material(s, &part);
        part.bsdf = PT_BSDF_PRINCIPLED;
        d.b = pt_add_material(s, &part);
        if (strstr(f->name, "diffuse")) { part.bsdf = PT_BSDF_DIFFUSE; d.a = d.b = pt_add_material(s, &part); }
    }
    return pt_add_material(s, &d);
}
static void white_furnaces(void) {
    static const double cosine[] = { 0.05, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1 };
    static pt_material id[FURNACES][17];
    pt_scene *s = pt_scene_create(NULL);                 /* one for all: they share tables */
    const char *verbose = getenv("FURNACES");
    int i, r, k, n, side;
    for (i = 0; i < FURNACES; i++) for (r = 0; r <= 16; r += furnaces[i].d.roughness_y > 0 ? 4 : 1)
        id[i][r] = add_furnace(s, furnaces + i, (float)r / 16);
    if (commit(s)) for (i = 0; i < FURNACES; i++) {
        const furnace *f = furnaces + i;
        double worst = 0, worst_mean = 0, at[3] = { 0, 0, 0 }, at_mean[2] = { 0, 0 };
        for (side = 1; side >= -f->inside; side -= 2) for (r = 0; r <= 16; r++) {
            double sum = 0;
            if (!id[i][r].id) continue;
            for (k = 0; k < 8; k++) {
                bounce b;
                albedo a = { 0, 0, 0, 0, 0, 0 };
                bounce_at(&b, s->materials + id[i][r].id, vertex_at(side * cosine[k], 0.7));
                for (n = 512; n <= 8192; n *= 4) {       /* more samples only for those that look bad */
                    a = albedo_of(&b, side > 0 ? f->eta : 1 / f->eta, n);
                    if (fabs(a.flux - 1) < f->each / 3) break;
                }
                sum += a.flux / 8;
                if (fabs(a.flux - 1) > fabs(worst)) { worst = a.flux - 1; at[0] = r / 16.0; at[1] = side * cosine[k]; }
                test_case("%s of roughness %g, cosine %g", f->name, r / 16.0, side * cosine[k]);
                CHECK_NEAR(a.flux, 1, f->each);
                CHECK(a.bad == 0);
            }
            if (fabs(sum - 1) > fabs(worst_mean)) { worst_mean = sum - 1; at_mean[0] = r / 16.0; at_mean[1] = side; }
            test_case("%s of roughness %g, side %d", f->name, r / 16.0, side);
            CHECK_NEAR(sum, 1, f->mean);
        }
        if (verbose) printf("    %-24s each %+.4f (roughness %.4f, cosine %+.2f)   mean %+.4f (roughness %.4f, side %+g)\n", f->name, worst, at[0], at[1],
                            worst_mean, at_mean[0], at_mean[1]);
    }
    pt_scene_destroy(s);
}

/* ---- the same material in two ways ---- */

static int close3(pt_vec3 a, pt_vec3 b, double tolerance) {
    double most = fmax((double)pti_largest_abs(a), (double)pti_largest_abs(b));
    return (double)pti_largest_abs(pti_sub(a, b)) <= tolerance * (1 + most);
}
/* Equal f, p and samples from both sides: over random directions, at vertices whose shading normal is turned as given; b may
   be asked at another shading normal. */
typedef struct same_desc { double tolerance, tilt; int n, outside_only; pt_vec3 ns_of_b; } same_desc;
static void check_same(const pti_material *a, const pti_material *b, same_desc d) {
    static pti_surface sa, sb;
    pt_rng rng;
    int i, drawn = 0, n = d.n ? d.n : 2000;
    pt_rng_seed(&rng, 11, 3);
    for (i = 0; i < n; i++) {
        pt_vec3 wo = stats_direction(&rng), wi = stats_direction(&rng), u = stats_uniform3(&rng), fa, fb, ns = direction_at(cos(d.tilt), 2);
        uint32_t k = pt_rng_u32(&rng), l = pt_rng_u32(&rng), m = pt_rng_u32(&rng);
        pt_vertex x, y;
        pt_scatter oa, ob;
        float pa, pb;
        int ra, rb;
        if (d.outside_only) wo.z = fabsf(wo.z);
        if (fabsf(wo.z) < 1e-2f) continue;
        x = vertex_of(wo, pt_v3(0, 0, 1), ns);
        x.dpdu = pt_v3(2, 0, 0); x.dpdv = pt_v3(0, 3, 0); x.u = u.x; x.v = u.y; x.t = 1;
        y = x;
        if (!pti_is_zero3(d.ns_of_b)) { y.ns = d.ns_of_b; pti_vertex_orient(&y); }
        memset(&oa, 0, sizeof oa); memset(&ob, 0, sizeof ob);
        pti_surface_at(a, &x, &sa);
        pti_surface_at(b, &y, &sb);
        ra = pti_surface_sample(&sa, k, l, m, &oa);
        rb = pti_surface_sample(&sb, k, l, m, &ob);
        if (i & 1 && ra && !oa.delta) wi = oa.wi;        /* where f is large */
        pa = pti_surface_eval(&sa, wi, &fa);
        pb = pti_surface_eval(&sb, wi, &fb);
        if (!close3(fa, fb, d.tolerance) || !(fabs((double)pa - (double)pb) <= d.tolerance * (1 + (double)pa)))
            FAIL("wo %g %g %g, wi %g %g %g: f %g %g %g, not %g %g %g; p %g, not %g", (double)wo.x, (double)wo.y, (double)wo.z, (double)wi.x, (double)wi.y,
                 (double)wi.z, (double)fa.x, (double)fa.y, (double)fa.z, (double)fb.x, (double)fb.y, (double)fb.z, (double)pa, (double)pb);
        /* wi: the cells of a table stretch the rounding of a share */
        if (ra != rb || (ra && (oa.delta != ob.delta || !close3(oa.wi, ob.wi, fmax(d.tolerance, 1e-3)) || (oa.delta && (!close3(oa.f, ob.f, d.tolerance) ||
            !(fabs((double)(oa.pdf - ob.pdf)) <= d.tolerance))))))
            FAIL("wo %g %g %g: drawn %d %d, delta %d %d, wi %g %g %g, not %g %g %g; f %g, not %g, pdf %g, not %g", (double)wo.x, (double)wo.y, (double)wo.z, ra, rb,
                 oa.delta, ob.delta, (double)oa.wi.x, (double)oa.wi.y, (double)oa.wi.z, (double)ob.wi.x, (double)ob.wi.y, (double)ob.wi.z, (double)oa.f.y,
                 (double)ob.f.y, (double)oa.pdf, (double)ob.pdf);
        drawn += ra;
    }
    CHECK(drawn > n / 4);
}

#define CONDUCTOR .bsdf = PT_BSDF_CONDUCTOR
#define GLASSY .bsdf = PT_BSDF_DIELECTRIC
#define PRINCIPLED .bsdf = PT_BSDF_PRINCIPLED
#define TINT .color = { 0.8f, 0.6f, 0.4f }
static const struct { const char *name; double tolerance; pt_material_desc a, b; } limits[] = {
    { "nearly smooth metal", 1e-6, OF(CONDUCTOR, TINT), OF(CONDUCTOR, TINT, .roughness = 0.0099f) },
    { "nearly smooth glass", 1e-6, OF(GLASSY), OF(GLASSY, .roughness = 0.0099f) },
    { "nearly smooth pane", 1e-6, OF(GLASSY, .thin = 1), OF(GLASSY, .thin = 1, .roughness = 0.0099f) },
    { "principled metal", 1e-6, OF(CONDUCTOR, TINT, .roughness = 0.3f), OF(PRINCIPLED, TINT, .roughness = 0.3f, .metallic = 1) },
    { "smooth principled metal", 1e-6, OF(CONDUCTOR, TINT), OF(PRINCIPLED, TINT, .metallic = 1) },
    { "turned principled metal", 1e-6, OF(CONDUCTOR, TINT, .roughness = 0.3f, .roughness_y = 0.7f, .rotation_deg = 20),
      OF(PRINCIPLED, TINT, .roughness = 0.3f, .roughness_y = 0.7f, .rotation_deg = 20, .metallic = 1) },
    { "principled glass", 1e-6, OF(GLASSY, .roughness = 0.3f), OF(PRINCIPLED, WHITE, .roughness = 0.3f, .transmission = 1) },
    { "smooth principled glass", 1e-6, OF(GLASSY, .ior = 1.2f), OF(PRINCIPLED, WHITE, .ior = 1.2f, .transmission = 1) },
    { "principled pane", 1e-6, OF(GLASSY, .roughness = 0.3f, .thin = 1), OF(PRINCIPLED, WHITE, .roughness = 0.3f, .transmission = 1, .thin = 1) },
    { "glass of index 1", 1e-6, OF(.bsdf = PT_BSDF_NONE), OF(GLASSY, .ior = 1) },
    { "rough glass of index 1", 1e-6, OF(.bsdf = PT_BSDF_NONE), OF(GLASSY, .ior = 1, .roughness = 1) },
    { "rough principled glass of index 1", 1e-6, OF(.bsdf = PT_BSDF_NONE), OF(PRINCIPLED, WHITE, .ior = 1, .roughness = 0.5f, .transmission = 1) },
    { "pane of index 1", 1e-6, OF(.bsdf = PT_BSDF_NONE), OF(GLASSY, .ior = 1, .thin = 1) },
    { "transparent", 1e-6, OF(.bsdf = PT_BSDF_NONE), OF(TINT, .transparency = 1) },
    { "transparent principled", 1e-6, OF(.bsdf = PT_BSDF_NONE), OF(PRINCIPLED, TINT, .transparency = 1, .coat = 1, .sheen = 1) },
    { "EON towards Lambert", 1e-3, OF(TINT), OF(TINT, .roughness = 1e-4f) },
    { "no gloss", 1e-4, OF(TINT), OF(PRINCIPLED, TINT, .roughness = 0.6f, .specular = 1e-6f) },
    { "no gloss of index 1", 1e-6, OF(TINT), OF(PRINCIPLED, TINT, .roughness = 0.6f, .ior = 1) },
    { "across as along", 1e-6, OF(CONDUCTOR, TINT, .roughness = 0.4f), OF(CONDUCTOR, TINT, .roughness = 0.4f, .roughness_y = 0.4f, .rotation_deg = 50) },
    { "half a turn", 2e-4, OF(CONDUCTOR, TINT, .roughness = 0.3f, .roughness_y = 0.7f), OF(CONDUCTOR, TINT, .roughness = 0.3f, .roughness_y = 0.7f, .rotation_deg = 360) },
    { "unasked dispersion", 1e-6, OF(GLASSY, .roughness = 0.3f), OF(GLASSY, .roughness = 0.3f, .abbe = 30) },
    { "fuzz of none", 1e-4, OF(PRINCIPLED, TINT, .roughness = 0.5f), OF(PRINCIPLED, TINT, .roughness = 0.5f, .sheen = 1e-6f) },
    { "coat of none", 1e-4, OF(PRINCIPLED, TINT, .roughness = 0.5f), OF(PRINCIPLED, TINT, .roughness = 0.5f, .coat = 1e-6f) },
    { "coat of index 1", 1e-6, OF(PRINCIPLED, TINT, .roughness = 0.5f), OF(PRINCIPLED, TINT, .roughness = 0.5f, .coat = 1, .coat_ior = 1) },
};
#define LIMITS ((int)(sizeof limits / sizeof limits[0]))
static void limits_are_met(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material id[LIMITS][2];
    int i;
    for (i = 0; i < LIMITS; i++) { id[i][0] = pt_add_material(s, &limits[i].a); id[i][1] = pt_add_material(s, &limits[i].b); }
    if (commit(s)) for (i = 0; i < LIMITS; i++) {
        test_case("%s", limits[i].name);
        check_same(s->materials + id[i][0].id, s->materials + id[i][1].id, (same_desc){ .tolerance = limits[i].tolerance });
    }
    pt_scene_destroy(s);
}
static void transmission_is_tinted_below(void) {         /* principled glass: white above, its colour through */
    pt_scene *s = pt_scene_create(NULL);
    pt_material clear = pt_add_material(s, &(pt_material_desc){ GLASSY, .roughness = 0.4f });
    pt_material tinted = pt_add_material(s, &(pt_material_desc){ PRINCIPLED, TINT, .roughness = 0.4f, .transmission = 1 });
    pt_rng rng;
    int i, n[2] = { 0, 0 };
    pt_rng_seed(&rng, 1, 8);
    if (commit(s)) for (i = 0; i < 2000; i++) {
        pt_vec3 wo = stats_direction(&rng), wi = stats_direction(&rng), f, g;
        pt_vertex x = vertex_of(wo, pt_v3(0, 0, 1), pt_v3(0, 0, 1));
        int through = !pti_same_side(&x, wo, wi);
        f = eval_of(s->materials + clear.id, &x, wi); g = eval_of(s->materials + tinted.id, &x, wi);
        n[through] += f.x > 0;
        CHECK(close3(through ? pti_mul(f, pt_v3(0.8f, 0.6f, 0.4f)) : f, g, 1e-6));
    }
    CHECK(n[0] > 500 && n[1] > 300);
    pt_scene_destroy(s);
}
static void mixes(void) {                                /* of 0 and 1 are their parts; of the same twice, that; else linear */
    pt_scene *s = pt_scene_create(NULL);
    pt_material part[SURFACE_KINDS], mix[SURFACE_KINDS][3];
    pti_surface x1, x2, x3;
    pt_rng rng;
    int i, k;
    for (i = 0; i < SURFACE_KINDS; i++) part[i] = add_surface(s, i, 0.4f);
    for (i = 0; i < MIXED; i++) {
        pt_material other = part[(i + 5) % (EVERYTHING)];
        mix[i][0] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = part[i], .b = other });
        mix[i][1] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = other, .b = part[i], .mix = 1 });
        mix[i][2] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = part[i], .b = other, .mix = 0.3f });
    }
    if (commit(s)) for (i = 0; i < MIXED; i++) {
        const pti_material *m = s->materials;
        test_case("%s, mix 0", surface_names[i]);
        check_same(m + part[i].id, m + mix[i][0].id, (same_desc){ .tolerance = 1e-6 });
        test_case("%s, mix 1", surface_names[i]);
        check_same(m + part[i].id, m + mix[i][1].id, (same_desc){ .tolerance = 1e-6 });
        test_case("%s, mix 0.3", surface_names[i]);
        pt_rng_seed(&rng, 5, 5);
        for (k = 0; k < 500; k++) {
            pt_vec3 wo = stats_direction(&rng), wi = stats_direction(&rng), a, b, c;
            pt_vertex x = vertex_of(wo, pt_v3(0, 0, 1), pt_v3(0, 0, 1));
            pti_surface_at(m + part[i].id, &x, &x1);
            pti_surface_at(m + part[(i + 5) % EVERYTHING].id, &x, &x2);
            pti_surface_at(m + mix[i][2].id, &x, &x3);
            pti_surface_eval(&x1, wi, &a); pti_surface_eval(&x2, wi, &b); pti_surface_eval(&x3, wi, &c);
            if (!close3(c, pti_madd(a, 0.7f, pti_scale(b, 0.3f)), 1e-5)) FAIL("wo.z %g, wi.z %g: %g of %g and %g", (double)wo.z, (double)wi.z, (double)c.x, (double)a.x, (double)b.x);
        }
    }
    pt_scene_destroy(s);
}

/* ---- textures ---- */

static pt_texture texture_of(pt_scene *s, float r, float g, float b) {
    float p[3];
    p[0] = r; p[1] = g; p[2] = b;
    return pt_add_texture(s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 3, .bits = 32, .pixels = p });
}
/* A texture of v beside the number n is the number n v; beside 0 it is v. What the texture's green and blue hold is not to be seen. */
static void textures_of_numbers(void) {
    enum { NUMBERS = 10 };
    static const float n[] = { 0.8f, 0 }, v[] = { 0.6f, 0.25f };
    pt_scene *s = pt_scene_create(NULL);
    pt_material id[2][NUMBERS][2][2], parts[2];
    static const char *names[NUMBERS];
    int i, k;
    parts[0] = add_surface(s, METAL, 0.5f); parts[1] = add_surface(s, GLASS, 0.4f);
    for (k = 0; k < 2; k++) {
        pt_material_desc base = surface_desc(EVERYTHING, 0.5f), a, b;
        base.roughness_y = 0;
        base.a = parts[0]; base.b = parts[1];
        i = 0;
#define TEST_NUMBER(name) \
        a = b = base; \
        names[i] = #name; \
        if (!strcmp(#name, "mix")) a.bsdf = b.bsdf = PT_BSDF_MIX; \
        if (!strcmp(#name, "roughness_y")) b.shade = leave_it;      /* E of both as where it varies */ \
        a.name = n[k]; a.name##_texture = texture_of(s, v[k], 0.9f, 0.1f); \
        b.name = n[k] != 0 ? n[k] * v[k] : v[k]; \
        id[k][i][0][0] = pt_add_material(s, &a); id[k][i][1][0] = pt_add_material(s, &b); \
        i++;
        PTI_NUMBERS(TEST_NUMBER)
#undef TEST_NUMBER
        CHECK_EQ_INT(i, NUMBERS);
    }
    if (commit(s)) for (k = 0; k < 2; k++) for (i = 0; i < NUMBERS; i++) {
        const pti_material *a = s->materials + id[k][i][0][0].id, *b = s->materials + id[k][i][1][0].id;
        test_case("%s %g times %g", names[i], (double)n[k], (double)v[k]);
        check_same(a, b, (same_desc){ .tolerance = 1e-5, .n = 500 });
        CHECK(a->varies && a->wants_coordinates && b->varies == (b->desc.shade != NULL));
    }
    pt_scene_destroy(s);
}
static void textures_of_colors(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc a[8], b[8];
    pt_texture t = texture_of(s, 0.5f, 0.25f, 1);
    pt_material id[8][2];
    int i;
    for (i = 0; i < 8; i++) a[i] = b[i] = surface_desc(i == 6 ? METAL_TURNED : EVERYTHING, 0.5f);
    a[0].color_texture = t;       b[0].color = pt_v3(0.4f, 0.15f, 0.4f);
    a[1].color_texture = t;       b[1].color = pt_v3(0.5f, 0.25f, 1); a[1].color = pt_v3(0, 0, 0);
    a[2].sheen_color_texture = t; b[2].sheen_color = pt_v3(0.5f, 0.25f, 1);
    a[3].sheen_color_texture = t; b[3].sheen_color = pt_v3(0.25f, 0.25f, 0.5f); a[3].sheen_color = pt_v3(0.5f, 1, 0.5f);
    a[4].opacity_texture = t;     b[4].transparency = 0.75f; a[4].transparency = 0.5f;
    a[5].opacity_texture = t;     b[5].transparency = 0.5f; a[5].transparency = 0;
    a[6].rotation_texture = t;    b[6].rotation_deg = a[6].rotation_deg + 180;
    a[7].rotation_texture = t;    b[7].rotation_deg = 180;
    a[7].roughness_y = b[7].roughness_y = 0.5f;
    for (i = 0; i < 8; i++) { id[i][0] = pt_add_material(s, &a[i]); id[i][1] = pt_add_material(s, &b[i]); }
    if (commit(s)) for (i = 0; i < 8; i++) {
        test_case("texture %d", i);
        check_same(s->materials + id[i][0].id, s->materials + id[i][1].id, (same_desc){ .tolerance = i >= 6 ? 1e-4 : 1e-5, .n = 500 });
    }
    pt_scene_destroy(s);
}
/* A flat map changes nothing, on a flat triangle and where the shading normal is interpolated. A map of one normal is a
   shading normal. */
static void maps_of_normals(void) {
    static const surface_kind kind[] = { LAMBERT, METAL, GLASS, PLASTIC, EVERYTHING };
    pt_scene *s = pt_scene_create(NULL);
    pt_texture flat = texture_of(s, 0.5f, 0.5f, 1), grey = texture_of(s, 0.3f, 0.3f, 0.3f), leaning = texture_of(s, 0.65f, 0.45f, 0.95f);
    pt_material id[5][4];
    int i, k;
    for (i = 0; i < 5; i++) {
        pt_material_desc d = surface_desc(kind[i], 0.4f);
        id[i][0] = pt_add_material(s, &d);
        d.normal_texture = flat; id[i][1] = pt_add_material(s, &d); d.normal_texture.id = 0;
        d.bump_texture = grey; d.bump = 3; id[i][2] = pt_add_material(s, &d); d.bump_texture.id = 0;
        d.normal_texture = leaning; id[i][3] = pt_add_material(s, &d);
    }
    if (commit(s)) for (i = 0; i < 5; i++) for (k = 0; k < 3; k++) {
        const pti_material *m = s->materials + id[i][0].id;
        double tilt = k * 0.15;
        test_case("%s, normal leaning by %g, flat normal map", surface_names[kind[i]], tilt);
        check_same(s->materials + id[i][1].id, m, (same_desc){ .tolerance = 1e-4, .tilt = tilt, .n = 500 });
        test_case("%s, normal leaning by %g, even bump map", surface_names[kind[i]], tilt);
        check_same(s->materials + id[i][2].id, m, (same_desc){ .tolerance = 1e-4, .tilt = tilt, .n = 500 });
    }
    pt_scene_destroy(s);
}
static void normals_from_maps(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_texture leaning = texture_of(s, 0.65f, 0.45f, 0.95f), slope = { 0 };
    float ramp[64 * 64];
    pt_material_desc d = surface_desc(LAMBERT, 0);
    pt_material mapped, bumped;
    pt_vec3 n;
    int i, j;
    for (i = 0; i < 64; i++) for (j = 0; j < 64; j++) ramp[64 * i + j] = (float)j / 64 + 0.5f * (float)(63 - i) / 64;      /* u + v / 2 */
    slope = grey_map(s, ramp, 64, 64);
    d.normal_texture = leaning;
    mapped = pt_add_material(s, &d);
    d.normal_texture.id = 0; d.bump_texture = slope; d.bump = 0.6f;
    bumped = pt_add_material(s, &d);
    if (commit(s)) for (i = 0; i < 4; i++) {
        pt_vertex x = vertex_at(i & 1 ? -1 : 1, 1);
        double side = i & 1 ? -1 : 1;
        if (i & 2) x.dpdv = pti_neg(x.dpdv);             /* mirrored uvs */
        x.u = 0.4f; x.v = 0.6f;
        test_case("side %g, mirrored %d", side, i & 2);
        n = pti_shading_normal(s->materials + mapped.id, &x);
        CHECK(close3(n, pti_scale(pti_normalize(pt_v3(0.3f, i & 2 ? 0.1f : -0.1f, 0.9f)), (float)side), 1e-5));
        n = pti_shading_normal(s->materials + bumped.id, &x);                     /* z = 0.6 u + 0.3 v */
        if (!close3(n, pti_scale(pti_normalize(pt_v3(-0.6f, i & 2 ? 0.3f : -0.3f, 1)), (float)side), 1e-3)) FAIL("the bumped normal is %g %g %g", (double)n.x, (double)n.y, (double)n.z);
    }
    pt_scene_destroy(s);
}

/* ---- callbacks ---- */

static pt_material_desc seen;
static void look(void *user, const pt_vertex *x, pt_material_desc *m) { (void)user; (void)x; seen = *m; }
static void change(void *user, const pt_vertex *x, pt_material_desc *m) {
    const pt_material_desc *to = (const pt_material_desc *)user;
    (void)x;
#define SET(name) m->name = to->name;
    PTI_NUMBERS(SET) SET(color) SET(sheen_color) SET(rotation_deg) SET(transparency) SET(sheen_roughness) SET(eta) SET(k)
#undef SET
}
static void callbacks(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_texture t = texture_of(s, 0.5f, 0.25f, 1);
    pt_material_desc d = { .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.8f, 0.8f, 0.8f }, .color_texture = t, .roughness = 0.8f, .roughness_texture = t, .metallic_texture = t,
                           .specular_texture = t, .sheen = 0.4f, .opacity_texture = t, .transparency = 0.2f, .rotation_texture = t, .rotation_deg = 10, .shade = look };
    pt_material watched = pt_add_material(s, &d), id[SURFACE_KINDS][3];
    pt_vertex x = vertex_at(0.7, 1);
    static pt_material_desc to[SURFACE_KINDS], wild[SURFACE_KINDS];
    pti_surface surface;
    int i;
    for (i = 0; i < SURFACE_KINDS; i++) {
        pt_material_desc blank, wilder;
        if (i == MIXED) continue;
        to[i] = wild[i] = surface_desc(i, 0.5f);
        if (i == EVERYTHING) to[i].roughness_y = wild[i].roughness_y = 0;
        if (i == METAL_ANISO || i == METAL_TURNED || i == GLASS_ANISO) continue;      /* one table for all where they vary */
        blank = to[i];
#define CLEAR(name) blank.name = 0;
        PTI_NUMBERS(CLEAR)
#undef CLEAR
        blank.color = blank.sheen_color = pt_v3(0.1f, 0.2f, 0.3f);
        blank.shade = change; blank.user = &to[i];
        if (to[i].specular == 0) to[i].specular = 1;
        if (pti_is_zero3(to[i].sheen_color)) to[i].sheen_color = white;
        if (to[i].sheen_roughness == 0) to[i].sheen_roughness = 0.5f;
        id[i][0] = pt_add_material(s, &to[i]);
        id[i][1] = pt_add_material(s, &blank);
        wilder = to[i];                                  /* out of range counts as the nearest number, NaN as 0 */
        wild[i] = to[i];
        wild[i].roughness = 3; wild[i].color = pt_v3(2, -1, (float)nan("")); wild[i].metallic = (float)nan(""); wild[i].coat = -4; wild[i].sheen_roughness = 5;
        wilder.roughness = 1;  wilder.color = pt_v3(1, 0, 0); wilder.metallic = 0; wilder.coat = 0; wilder.sheen_roughness = 1;
        blank.user = &wild[i];
        blank.sheen_roughness = 1;
        id[i][2] = pt_add_material(s, &wilder);
        id[i][0].id |= pt_add_material(s, &blank).id << 16;
    }
    if (commit(s)) {
        pti_surface_at(s->materials + watched.id, &x, &surface);
        CHECK_NEAR(seen.color.x, 0.4, 1e-6); CHECK_NEAR(seen.color.y, 0.2, 1e-6); CHECK_NEAR(seen.color.z, 0.8, 1e-6);
        CHECK_NEAR(seen.roughness, 0.4, 1e-6); CHECK_NEAR(seen.metallic, 0.5, 1e-6); CHECK_NEAR(seen.specular, 0.5, 1e-6);
        CHECK_NEAR(seen.transparency, 1 - 0.8 * 0.5, 1e-6); CHECK_NEAR(seen.rotation_deg, 190, 1e-4);
        CHECK_NEAR(seen.sheen, 0.4, 1e-6); CHECK_NEAR(seen.sheen_roughness, 0.5, 1e-6); CHECK_NEAR(seen.ior, 1.5, 1e-6); CHECK_NEAR(seen.coat_ior, 1.5, 1e-6);
        CHECK_NEAR(seen.sheen_color.y, 1, 1e-6);
        for (i = 0; i < MIXED; i++) {
            const pti_material *m = s->materials;
            if (i == METAL_ANISO || i == METAL_TURNED || i == GLASS_ANISO) continue;
            test_case("%s", surface_names[i]);
            check_same(m + (id[i][0].id & 0xffff), m + id[i][1].id, (same_desc){ .tolerance = 1e-5, .n = 500 });
            test_case("%s, out of range", surface_names[i]);
            check_same(m + id[i][2].id, m + (id[i][0].id >> 16), (same_desc){ .tolerance = 1e-5, .n = 500 });
        }
    }
    pt_scene_destroy(s);
}

/* ---- emission ---- */

static void dim(void *user, const pt_vertex *x, pt_material_desc *m) { (void)user; (void)x; m->emission = pti_scale(m->emission, 0.5f); m->transparency = 0.5f; }
static void emission(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_texture t = texture_of(s, 0.5f, 0.25f, 1);
    pt_material_desc d = { .emission = { 2, 4, 8 } };
    pt_material id[9];
    pt_vertex x = vertex_at(0.7, 1), below = vertex_at(-0.7, 1);
    static const float want[9][3] = { { 2, 4, 8 }, { 2, 4, 8 }, { 1, 1, 8 }, { 0.5f, 0.25f, 1 }, { 0.5f, 1, 2 }, { 1.25f, 2.5f, 5 }, { 0.75f, 1.5f, 3 }, { 1, 2, 4 }, { 0.5f, 1, 2 } };
    int i;
    id[0] = pt_add_material(s, &d);
    d.two_sided = 1;                   id[1] = pt_add_material(s, &d);
    d.emission_texture = t;            id[2] = pt_add_material(s, &d);
    d.emission = pt_v3(0, 0, 0);       id[3] = pt_add_material(s, &d);
    d = (pt_material_desc){ .emission = { 2, 4, 8 }, .transparency = 0.5f, .opacity_texture = t }; id[4] = pt_add_material(s, &d);     /* 1/4 is there */
    d = (pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = id[0], .b = id[4], .mix = 0.5f };             id[5] = pt_add_material(s, &d);
    d.transparency = 0.4f;                                                                          id[6] = pt_add_material(s, &d);
    d = (pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = id[0], .b = pt_add_material(s, &(pt_material_desc){ .color = { 1, 1, 1 } }), .mix_texture = t }; id[7] = pt_add_material(s, &d);
    d = (pt_material_desc){ .emission = { 2, 4, 8 }, .shade = dim };                                id[8] = pt_add_material(s, &d);
    if (commit(s)) for (i = 0; i < 9; i++) {
        const pti_material *m = s->materials + id[i].id;
        pt_vec3 e = pti_material_emission(m, &x);
        test_case("material %d", i);
        CHECK(m->emits);
        if (!close3(e, pt_v3(want[i][0], want[i][1], want[i][2]), 1e-6)) FAIL("emits %g %g %g, not %g %g %g", (double)e.x, (double)e.y, (double)e.z, (double)want[i][0], (double)want[i][1], (double)want[i][2]);
        e = pti_material_emission(m, &below);
        CHECK(pti_is_zero3(e) == !m->desc.two_sided);
    }
    pt_scene_destroy(s);
}

/* A picture's alpha cuts out, also where the rest of it is grey; a channel that was picked is what it is. */
static void alpha_cuts_out(void) {
    static const unsigned char grey_alpha[2] = { 191, 64 }, rgba[4] = { 191, 20, 30, 64 };
    pt_scene *s = pt_scene_create(NULL);
    pt_texture two = pt_add_texture(s, &(pt_texture_desc){ .pixels = grey_alpha, .width = 1, .height = 1, .channels = 2 });
    pt_texture four = pt_add_texture(s, &(pt_texture_desc){ .pixels = rgba, .width = 1, .height = 1, .channels = 4 });
    pt_texture first = pt_add_texture(s, &(pt_texture_desc){ .of = two, .channel = 1 });
    const struct { pt_texture t; double opacity; } all[] = { { two, 64 / 255.0 }, { four, 64 / 255.0 }, { first, 191 / 255.0 } };
    pt_material id[3];
    int i;
    for (i = 0; i < 3; i++) id[i] = pt_add_material(s, &(pt_material_desc){ WHITE, .opacity_texture = all[i].t });
    if (commit(s)) for (i = 0; i < 3; i++) {
        pt_vertex x = vertex_at(0.5, 0);
        pti_surface surface;
        test_case("texture %d", i);
        pti_surface_at(s->materials + id[i].id, &x, &surface);
        CHECK_NEAR(surface.delta, 1 - all[i].opacity, 1e-6);       /* the share that passes */
    }
    pt_scene_destroy(s);
}
/* eta alone is an index too, whose reflectance head-on is ((eta - 1) / (eta + 1))^2; and bad names and pointers are refused. */
static void index_without_k(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_vec3 eta, k;
    pt_material m = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .eta = { 0.2f, 1.5f, 3 } });
    pt_vertex x = vertex_at(1, 0);
    pt_scatter out;
    if (commit(s) && CHECK(sample_of(s->materials + m.id, &x, 0.5f, 0.5f, 0.5f, &out))) {
        CHECK_NEAR(out.f.x / out.pdf, 4.0 / 9, 1e-6);
        CHECK_NEAR(out.f.y / out.pdf, 0.04, 1e-6);
        CHECK_NEAR(out.f.z / out.pdf, 0.25, 1e-6);
    }
    CHECK(pt_metal("gold", &eta, &k) && k.x > 3 && !pt_metal("gold", NULL, &k) && !pt_metal("gold", &eta, NULL));
    CHECK(!pt_metal("lead", &eta, &k) && !pt_metal(NULL, &eta, &k));
    pt_scene_destroy(s);
}
/* Glass squeezes radiance by eta^2 and lets it out again. Roulette that took that for darkness would give each sample of a
   ball in white surroundings a deviation above 1: here pixels of 64 samples, and hardly any. */
static void squeezed_light_is_not_dim(void) {
    static const float ior[] = { 1.5f, 3 };
    int i;
    for (i = 0; i < 2; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 8), pt_v3(0, 0, 0), 8, 16, 64);
        stats_moments m;
        pt_add_sphere(s, pt_v3(0, 0, 0), 1, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = ior[i], .roughness = 0.05f }));
        sky(s, 1);
        test_case("ior %g", (double)ior[i]);
        if (commit(s)) {
            m = render_pixels(s, &d);
            CHECK_NEAR(m.mean, 1, 1e-3);
            CHECK(stats_error(&m) * 16 < 0.02);
        }
        pt_scene_destroy(s);
    }
}

void test_material(void) {
    RUN(white_furnaces);
    RUN(limits_are_met);
    RUN(transmission_is_tinted_below);
    RUN(mixes);
    RUN(textures_of_numbers);
    RUN(textures_of_colors);
    RUN(maps_of_normals);
    RUN(normals_from_maps);
    RUN(callbacks);
    RUN(emission);
    RUN(alpha_cuts_out);
    RUN(index_without_k);
    RUN(squeezed_light_is_not_dim);
}
