/* surfaces.h - materials of all kinds in one table, and the two views of a BSDF that tests take: a sampler with its density,
   and an albedo. Include it after pt.h, test.h, stats.h and scenes.h. */
#ifndef SURFACES_H
#define SURFACES_H

/* Kinds whose roughness the test chooses. */
typedef enum surface_kind {
    LAMBERT, TRANSLUCENT, ROUGH_DIFFUSE, METAL, METAL_ANISO, METAL_TURNED, GOLD, THIN, GLASS, GLASS_LOW, GLASS_INVERSE, GLASS_ANISO,
    PLASTIC, COATED, COATED_METAL, FUZZY, EVERYTHING, MIXED, SURFACE_KINDS
} surface_kind;
static const char *const surface_names[] = {
    "Lambert", "translucent", "rough diffuse", "metal", "anisotropic metal", "turned metal", "gold", "thin", "glass", "glass of 1.1",
    "glass of 1/1.5", "anisotropic glass", "plastic", "coat", "coated metal", "fuzz", "everything", "mix" };

static inline int surface_transmits(int kind) { return (kind >= THIN && kind <= GLASS_ANISO) || kind == EVERYTHING || kind == MIXED || kind == TRANSLUCENT; }
static inline pt_material_desc surface_desc(int kind, float rough) {
    pt_material_desc d;
    memset(&d, 0, sizeof d);
    d.color = pt_v3(0.8f, 0.6f, 0.4f);
    d.roughness = rough;
    d.bsdf = kind <= ROUGH_DIFFUSE ? PT_BSDF_DIFFUSE : kind <= GOLD ? PT_BSDF_CONDUCTOR : kind <= GLASS_ANISO ? PT_BSDF_DIELECTRIC : PT_BSDF_PRINCIPLED;
    switch (kind) {
    case LAMBERT:       d.roughness = 0; break;
    case TRANSLUCENT:   d.translucency = 0.6f; break;
    case METAL_ANISO:   d.roughness_y = 0.5f; break;
    case METAL_TURNED:  d.roughness_y = 0.25f; d.rotation_deg = 30; break;
    case GOLD:          d.eta = pt_v3(0.14f, 0.37f, 1.44f); d.k = pt_v3(3.98f, 2.38f, 1.6f); break;
    case THIN:          d.thin = 1; break;
    case GLASS_LOW:     d.ior = 1.1f; break;
    case GLASS_INVERSE: d.ior = 1 / 1.5f; break;
    case GLASS_ANISO:   d.ior = 2; d.roughness_y = 0.3f; break;
    case COATED:        d.coat = 1; d.coat_roughness = rough; d.roughness = 0.6f; break;
    case COATED_METAL:  d.coat = 0.7f; d.coat_roughness = rough; d.metallic = 1; break;
    case FUZZY:         d.sheen = 0.8f; d.sheen_roughness = rough; d.roughness = 0.5f; break;
    case EVERYTHING:    d.metallic = 0.3f; d.transmission = 0.4f; d.coat = 0.5f; d.coat_roughness = 0.2f; d.sheen = 0.4f; d.translucency = 0.3f;
                        d.transparency = 0.1f; d.specular = 0.8f; d.roughness_y = 0.35f; break;
    default: break;
    }
    return d;
}
static inline pt_material add_surface(pt_scene *s, int kind, float rough) {
    pt_material_desc d = surface_desc(kind, rough);
    if (kind == MIXED) {
        pt_material_desc metal = surface_desc(METAL_TURNED, rough), pane = surface_desc(GLASS, rough);
        memset(&d, 0, sizeof d);
        d.bsdf = PT_BSDF_MIX;
        d.mix = 0.6f; d.transparency = 0.2f;
        d.a = pt_add_material(s, &metal);
        d.b = pt_add_material(s, &pane);
    }
    return pt_add_material(s, &d);
}

/* wo at a cosine to the normal, cosine < 0: from inside. */
static inline pt_vec3 direction_at(double cosine, double phi) {
    double r = sqrt(1 - cosine * cosine);
    return pt_v3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)cosine);
}
static inline pt_vertex vertex_at(double cosine, double phi) {
    pt_vertex x = vertex_of(direction_at(cosine, phi), pt_v3(0, 0, 1), pt_v3(0, 0, 1));
    x.dpdu = pt_v3(1, 0, 0); x.dpdv = pt_v3(0, 1, 0);
    return x;
}

/* A surface as a sampler of directions and their density, deltas left out (as if nothing were drawn). It points at its
   vertex: set one up where it stays. */
typedef struct bounce { pt_vertex x; pti_surface surface; } bounce;
static inline void bounce_at(bounce *b, const pti_material *m, pt_vertex x) { b->x = x; pti_surface_at(m, &b->x, &b->surface); }
static inline int bounce_sample(void *ctx, pt_rng *rng, pt_vec3 *wi) {
    const bounce *b = (const bounce *)ctx;
    uint32_t u = pt_rng_u32(rng), v = pt_rng_u32(rng), w = pt_rng_u32(rng);
    pt_scatter s;
    memset(&s, 0, sizeof s);
    if (!pti_surface_sample(&b->surface, u, v, w, &s) || s.delta) return 0;
    *wi = s.wi;
    return 1;
}
static inline double bounce_pdf(void *ctx, pt_vec3 wi) {
    const bounce *b = (const bounce *)ctx;
    pt_vec3 f;
    return (double)pti_surface_eval(&b->surface, wi, &f);
}

/* What the surface's own samples make of it, by n quasi-random ones. flux counts what goes through glass by eta^2, as
   energy instead of as radiance, which is squeezed inside. */
typedef struct albedo { double radiance, flux, square, deltas, lost, bad; } albedo;      /* square: the mean of radiance^2 */
static inline albedo albedo_of(const bounce *b, double eta, int n) {
    albedo a = { 0, 0, 0, 0, 0, 0 };
    pti_sampler sampler;
    int i;
    memset(&sampler, 0, sizeof sampler);
    sampler.kind = PT_SAMPLER_SOBOL; sampler.pixel_seed = 12345;
    for (i = 0; i < n; i++) {
        uint32_t u[2], c[2];
        pt_scatter s;
        pt_vec3 f;
        double w, p;
        pti_sampler_start(&sampler, (uint32_t)i);
        pti_draw2(&sampler, 1, 0, u);
        pti_draw2(&sampler, 1, 1, c);
        memset(&s, 0, sizeof s);
        if (!pti_surface_sample(&b->surface, u[0], u[1], c[1], &s)) { a.lost++; continue; }
        if (s.delta) { f = s.f; p = (double)s.pdf; a.deltas++; }
        else p = (double)pti_surface_eval(&b->surface, s.wi, &f);
        w = p > 0 ? (double)f.y / p : 0;
        if (!(p > 0) || !(w >= 0) || !(w < 1e6)) a.bad++;
        a.radiance += w;
        a.square += w * w;
        a.flux += pti_same_side(&b->x, b->x.wo, s.wi) ? w : w * eta * eta;
    }
    a.radiance /= n; a.flux /= n; a.square /= n; a.deltas /= n; a.lost /= n; a.bad /= n;
    return a;
}
#endif
