/* scenes.h - short words for the tests that render: materials, shapes, views, means over pictures. Include it after pt.h,
   test.h and stats.h. */
#ifndef SCENES_H
#define SCENES_H
#define NOWHERE (&(pti_on_map){ 0, 0, 0 })               /* a place on the map that is not known */
#define UNKNOWN (&(pti_drawn){ NULL, 0, { 0, 0, 0 } })   /* a direction of which nothing is */

static inline pt_material diffuse(pt_scene *s, float albedo) {
    return pt_add_material(s, &(pt_material_desc){ .color = { albedo, albedo, albedo } });
}
static inline pt_material mirror(pt_scene *s, float reflectance) {
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { reflectance, reflectance, reflectance } });
}
static inline pt_material glass(pt_scene *s, float ior) {
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = ior });
}
static inline pt_material lamp(pt_scene *s, float radiance, int two_sided) {             /* black, but for its light */
    return pt_add_material(s, &(pt_material_desc){ .emission = { radiance, radiance, radiance }, .two_sided = two_sided });
}
static inline void sky(pt_scene *s, float radiance) {
    pt_add_light(s, &(pt_light_desc){ .color = { radiance, radiance, radiance } });
}
static inline pt_texture grey_map(pt_scene *s, const float *pixels, int width, int height) {
    return pt_add_texture(s, &(pt_texture_desc){ .width = width, .height = height, .channels = 1, .bits = 32, .pixels = pixels });
}
static inline void triangle_of(pt_scene *s, pt_vec3 a, pt_vec3 b, pt_vec3 c, pt_material m) {
    pt_vec3 v[3];
    v[0] = a; v[1] = b; v[2] = c;
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = &v[0].x, .vertex_count = 3, .material = m });
}
/* A torus about the y axis, without normals: closed, and not convex. */
#define TORUS_U 24
#define TORUS_V 12
static inline void torus(pt_scene *s, pt_vec3 center, float major, float minor, pt_material m) {
    static pt_vec3 v[TORUS_U * TORUS_V];
    static uint32_t index[6 * TORUS_U * TORUS_V];
    int i, j, n = 0;
    for (i = 0; i < TORUS_U; i++) for (j = 0; j < TORUS_V; j++) {
        double a = 2 * STATS_PI * i / TORUS_U, b = 2 * STATS_PI * j / TORUS_V, r = major + minor * cos(b);
        uint32_t i1 = (uint32_t)((i + 1) % TORUS_U * TORUS_V), j1 = (uint32_t)((j + 1) % TORUS_V), i0 = (uint32_t)(i * TORUS_V), j0 = (uint32_t)j;
        v[i * TORUS_V + j] = pt_v3(center.x + (float)(r * cos(a)), center.y + (float)(minor * sin(b)), center.z + (float)(r * sin(a)));
        index[n++] = i0 + j0; index[n++] = i0 + j1; index[n++] = i1 + j1;
        index[n++] = i0 + j0; index[n++] = i1 + j1; index[n++] = i1 + j0;
    }
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = &v[0].x, .vertex_count = TORUS_U * TORUS_V, .indices = index,
                                    .index_count = (size_t)n, .material = m });
}
/* A committed scene, or a failure that says why not. */
static inline int commit(pt_scene *s) {
    if (pt_scene_commit(s) == PT_OK) return 1;
    return FAIL("%s", pt_scene_error(s));
}

static inline pt_render_desc view(pt_vec3 eye, pt_vec3 target, float vfov_deg, int size, int spp) {
    pt_render_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = size;
    d.spp = spp;
    d.threads = 1;
    d.camera.eye = eye; d.camera.target = target; d.camera.vfov_deg = vfov_deg;
    return d;
}
/* Straight down on a point of a floor, from a hair's breadth: all pixels see the same. */
static inline pt_render_desc view_down(pt_vec3 at, int size, int spp) {
    pt_vec3 eye = at;
    pt_render_desc d;
    eye.y += 0.01f;
    d = view(eye, at, 0.1f, size, spp);
    d.max_depth = 1;
    return d;
}
/* Renders into out, width * height * 3; 0 and a failure if that does not work. */
static inline int render(const pt_scene *s, const pt_render_desc *d, float *out, pt_stats *stats) {
    pt_render *r = pt_render_create(s, d);
    int fine = pt_render_run(r) == PT_OK;
    if (fine) memcpy(out, pt_render_pixels(r), (size_t)d->width * (size_t)d->height * 3 * sizeof *out);
    else FAIL("%s", pt_render_error(r));
    if (stats) *stats = pt_render_stats(r);
    pt_render_destroy(r);
    return fine;
}
/* Moments over the pixels' green, which are independent of each other; at most 64 x 64. */
static inline stats_moments render_pixels(const pt_scene *s, const pt_render_desc *d) {
    static float rgb[64 * 64 * 3];
    stats_moments m = { 0, 0, 0 };
    int i;
    if (render(s, d, rgb, NULL)) for (i = 0; i < d->width * d->height; i++) stats_push(&m, rgb[3 * i + 1]);
    return m;
}
/* Is the mean of what the pixels show what it should be: by t-test, and is that known to a thousandth? */
static inline void check_mean(const stats_moments *m, double expected) {
    CHECK_P(fabs(m->mean - expected) <= 2e-5 * expected ? 1.0 : stats_t_test(m, expected));      /* floats' own error */
    CHECK(3 * stats_error(m) <= 1e-3 * expected || expected == 0);
}

/* A vertex that did not come from a scene: on the side of ng that wo is on, with the rest in order. */
static inline pt_vertex vertex_of(pt_vec3 wo, pt_vec3 ng, pt_vec3 ns) {
    pt_vertex x;
    memset(&x, 0, sizeof x);
    x.wo = pti_normalize(wo);
    x.ng = pti_normalize(ng);
    x.ns = pti_normalize(ns);
    x.tangent = pt_v3(1, 0, 0);
    pti_vertex_orient(&x);
    return x;
}
/* One material's BSDF at a vertex. */
static inline pt_vec3 eval_of(const pti_material *m, const pt_vertex *x, pt_vec3 wi) {
    pti_surface s;
    pt_vec3 f;
    pti_surface_at(m, x, &s);
    pti_surface_eval(&s, wi, &f);
    return f;
}
static inline float pdf_of(const pti_material *m, const pt_vertex *x, pt_vec3 wi) {
    pti_surface s;
    pt_vec3 f;
    pti_surface_at(m, x, &s);
    return pti_surface_eval(&s, wi, &f);
}
static inline int sample_of(const pti_material *m, const pt_vertex *x, float a, float b, float c, pt_scatter *out) {
    pti_surface s;
    memset(out, 0, sizeof *out);
    pti_surface_at(m, x, &s);
    return pti_surface_sample(&s, (uint32_t)((double)a * 4294967296.0), (uint32_t)((double)b * 4294967296.0), (uint32_t)((double)c * 4294967296.0), out);
}
static inline pt_vec3 random_direction(pt_rng *rng) {
    float u = pt_rng_float(rng), v = pt_rng_float(rng);
    return pti_sample_sphere(u, v);
}
#endif
