/* agreement.h - scenes whose pictures are compared, by t-test: for the tests of what draws directions. Include it after
   pt.h, test.h, stats.h and scenes.h. */
#ifndef AGREEMENT_H
#define AGREEMENT_H

/* ---- parts of scenes ---- */

static inline pt_material colored(pt_scene *s, float r, float g, float b) {
    return pt_add_material(s, &(pt_material_desc){ .color = { r, g, b } });
}
static inline void quad(pt_scene *s, float x, float y, float z, float ux, float uy, float uz, float vx, float vy, float vz, pt_material m) {
    pt_add_quad(s, pt_v3(x, y, z), pt_v3(ux, uy, uz), pt_v3(vx, vy, vz), m);
}
static inline void floor_of(pt_scene *s, float half, pt_material m) { quad(s, -half, 0, half, 2 * half, 0, 0, 0, 0, -2 * half, m); }
/* Scatters all round: nothing that the mixture draws is lost. */
static inline pt_vec3 round_eval(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return pt_v3(0.05f, 0.05f, 0.05f); }
static inline float   round_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return pti_pdf_sphere(); }
static inline int round_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    (void)user; (void)x;
    out->wi = pti_sample_sphere(u[0], u[1]);
    return 1;
}
static inline pt_material all_round(pt_scene *s) {
    static const pt_bsdf_vtable v = { round_eval, round_pdf, round_sample, NULL };
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_USER, .vtable = &v });
}
static inline pt_vec3 facing_normal(const pt_vertex *x) { return pti_dot(x->ns, x->wo) < 0 ? pti_neg(x->ns) : x->ns; }
/* A coat: a mirror's delta with probability 0.3, else diffuse. */
static inline pt_vec3 coat_eval(void *user, const pt_vertex *x, pt_vec3 wi) {
    float f = pti_same_side(x, x->wo, wi) ? 0.6f * pti_pdf_cosine(pti_dot(facing_normal(x), wi)) : 0.0f;
    (void)user;
    return pt_v3(f, f, f);
}
static inline float coat_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { return coat_eval(user, x, wi).x * (0.7f / 0.6f); }
static inline int coat_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    pt_vec3 n = facing_normal(x), t, b;
    (void)user;
    if (u[2] < 0.3f) {
        out->wi = pti_mirrored(x->wo, n);
        out->f = pt_v3(0.25f, 0.25f, 0.25f); out->pdf = 0.3f; out->delta = 1;
        return 1;
    }
    pti_basis(n, &t, &b);
    out->wi = pti_to_world(t, b, n, pti_sample_cosine(u[0], u[1]));
    return 1;
}
static inline float coat_delta(void *user, const pt_vertex *x) { (void)user; (void)x; return 0.3f; }
static inline pt_material coat(pt_scene *s) {
    static const pt_bsdf_vtable v = { coat_eval, coat_pdf, coat_sample, coat_delta };
    return pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_USER, .vtable = &v });
}
/* Densities: all directions; all of them, but every second time none; a cone about +y. */
static inline int sphere_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    (void)user; (void)x;
    *wi = pti_sample_sphere(u[0], u[1]);
    return 1;
}
static inline float sphere_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return pti_pdf_sphere(); }
static inline int lossy_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    (void)user; (void)x;
    if (u[0] < 0.5f) return 0;
    *wi = pti_sample_sphere(2 * u[0] - 1, u[1]);
    return 1;
}
static inline float lossy_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { return sphere_pdf(user, x, wi) / 2; }
static inline int cone_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    pt_vec3 c = pti_sample_cone(*(float *)user, u[0], u[1]);
    (void)x;
    *wi = pt_v3(c.x, c.z, c.y);
    return 1;
}
static inline float cone_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    pt_vec3 d = pti_sub(wi, pt_v3(0, 1, 0));
    (void)x;
    return pti_dot(d, d) <= 2 * *(float *)user ? pti_pdf_cone(*(float *)user) : 0;
}
static inline void add_sphere(pt_scene *s, float w) {
    pt_add_density(s, &(pt_density_desc){ .weight = w, .sample = sphere_sample, .pdf = sphere_pdf });
}
static inline float half_to_the_right(void *user, const pt_vertex *x) { (void)user; return x->p.x > 0.4f ? 0.5f : 0.0f; }
static inline void add_important(pt_scene *s, float w, float (*importance)(void *user, const pt_vertex *x)) {
    pt_add_density(s, &(pt_density_desc){ .weight = w, .sample = sphere_sample, .pdf = sphere_pdf, .importance = importance });
}
static inline void add_lossy(pt_scene *s, float w) {
    pt_add_density(s, &(pt_density_desc){ .weight = w, .sample = lossy_sample, .pdf = lossy_pdf });
}
static inline void add_cone(pt_scene *s, float w) {
    static float size = 0.3f;                            /* 1 - cos */
    pt_add_density(s, &(pt_density_desc){ .weight = w, .sample = cone_sample, .pdf = cone_pdf, .user = &size });
}
/* A dim sky with a sun of some ten degrees, 30 times as bright; even: the same above and below. */
#define SKY_W 16
#define SKY_H 8
static inline void sunny(pt_scene *s, float scale, int even) {
    static float map[SKY_W * SKY_H];
    int i;
    for (i = 0; i < SKY_W * SKY_H; i++) map[i] = 0.3f + 0.02f * (float)(i % SKY_W);
    map[2 * SKY_W + 5] = map[2 * SKY_W + 6] = 9;
    if (even) map[5 * SKY_W + 5] = map[5 * SKY_W + 6] = 9;
    pt_add_light(s, &(pt_light_desc){ .texture = grey_map(s, map, SKY_W, SKY_H), .rotate_deg = 20,
                                      .color = { scale, scale, scale * 0.8f } });
}

/* ---- scenes whose pictures are compared ---- */

/* Each fills a scene and the camera, and returns a scene that it places instances of, or NULL. */
typedef pt_scene *scene_builder(pt_scene *s, pt_render_desc *d);

static inline void walls(pt_scene *s, pt_material m, pt_material left, pt_material right) {   /* [-1,1] x [0,2] x [-1,1], open to +z */
    quad(s, -1, 0, 1, 2, 0, 0, 0, 0, -2, m);
    quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, m);
    quad(s, -1, 0, -1, 2, 0, 0, 0, 2, 0, m);
    quad(s, -1, 0, 1, 0, 0, -2, 0, 2, 0, left);
    quad(s, 1, 0, -1, 0, 0, 2, 0, 2, 0, right);
}
static inline pt_scene *cornell(pt_scene *s, pt_render_desc *d) {
    pt_material white = diffuse(s, 0.73f);
    walls(s, white, colored(s, 0.65f, 0.05f, 0.05f), colored(s, 0.12f, 0.45f, 0.15f));
    pt_add_box(s, pt_v3(-0.6f, 0, -0.6f), pt_v3(-0.1f, 1.1f, -0.1f), NULL, white);
    pt_add_box(s, pt_v3(0.2f, 0, 0), pt_v3(0.7f, 0.6f, 0.5f), NULL, white);
    quad(s, -0.5f, 1.99f, -0.5f, 1, 0, 0, 0, 0, 1, lamp(s, 4, 0));
    d->camera.eye = pt_v3(0, 1, 3.5f); d->camera.target = pt_v3(0, 1, 0); d->camera.vfov_deg = 42;
    return NULL;
}
static inline pt_scene *sphere_by_the_wall(pt_scene *s, pt_render_desc *d) {
    floor_of(s, 5, diffuse(s, 0.5f));
    quad(s, -5, 0, 0, 10, 0, 0, 0, 5, 0, colored(s, 0.7f, 0.6f, 0.2f));
    pt_add_sphere(s, pt_v3(0, 0.7f, 0.45f), 0.4f, lamp(s, 3, 0));
    d->camera.eye = pt_v3(1, 2, 3); d->camera.target = pt_v3(0, 0.5f, 0); d->camera.vfov_deg = 50;
    return NULL;
}
static inline pt_scene *one_behind_the_other(pt_scene *s, pt_render_desc *d) {
    floor_of(s, 5, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(0, 1.5f, 0), 0.7f, lamp(s, 1, 0));
    quad(s, -1, 2.5f, -1, 2, 0, 0, 0, 0, 2, lamp(s, 6, 0));          /* hidden from below, and brighter */
    quad(s, -0.8f, 3, -0.8f, 1.6f, 0, 0, 0, 0, 1.6f, lamp(s, 9, 1));
    pt_add_sphere(s, pt_v3(0.5f, 1.6f, 0.2f), 0.5f, lamp(s, 3, 1));  /* overlaps the first */
    d->camera.eye = pt_v3(0.5f, 2, 4); d->camera.target = pt_v3(0, 0.1f, 0); d->camera.vfov_deg = 50;
    return NULL;
}
static inline pt_scene *glowing_torus(pt_scene *s, pt_render_desc *d) {
    floor_of(s, 5, diffuse(s, 0.6f));
    torus(s, pt_v3(0, 0.8f, 0), 0.8f, 0.3f,
          pt_add_material(s, &(pt_material_desc){ .color = { 0.5f, 0.5f, 0.2f }, .emission = { 2, 1, 1 } }));
    pt_add_sphere(s, pt_v3(0, 0.4f, 0), 0.4f, diffuse(s, 0.8f));
    d->camera.eye = pt_v3(0, 3, 3); d->camera.target = pt_v3(0, 0.5f, 0); d->camera.vfov_deg = 45;
    return NULL;
}
static inline pt_scene *sun_and_mesh(pt_scene *s, pt_render_desc *d) {
    floor_of(s, 5, diffuse(s, 0.5f));
    torus(s, pt_v3(0, 0.5f, 0), 0.8f, 0.3f, colored(s, 0.8f, 0.5f, 0.3f));
    sunny(s, 1, 0);
    d->camera.eye = pt_v3(0, 2, 3); d->camera.target = pt_v3(0, 0.4f, 0); d->camera.vfov_deg = 45;
    return NULL;
}
/* Two wide suns and gloss that mirrors them: metal, plastic, a ball of rough glass. */
static inline pt_scene *suns_in_gloss(pt_scene *s, pt_render_desc *d) {
    pt_light_desc l;
    memset(&l, 0, sizeof l);
    l.kind = PT_LIGHT_SUN; l.radius_deg = 8;
    floor_of(s, 5, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { 0.5f, 0.4f, 0.3f }, .roughness = 0.35f }));
    pt_add_sphere(s, pt_v3(-0.7f, 0.6f, 0), 0.6f,
                  pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { 0.9f, 0.8f, 0.6f }, .roughness = 0.3f }));
    pt_add_sphere(s, pt_v3(0.7f, 0.6f, 0), 0.6f, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .roughness = 0.4f }));
    l.direction = pt_v3(-0.6f, -1, -0.5f); l.color = pt_v3(2, 1.5f, 1);
    pt_add_light(s, &l);
    l.direction = pt_v3(0.9f, -0.6f, -0.3f); l.color = pt_v3(0.5f, 0.5f, 1);
    pt_add_light(s, &l);
    sky(s, 0.2f);
    d->camera.eye = pt_v3(0, 1.2f, 3.5f); d->camera.target = pt_v3(0, 0.6f, 0); d->camera.vfov_deg = 45;
    return NULL;
}
static inline pt_scene *sky_lamps_mirror_glass(pt_scene *s, pt_render_desc *d) {
    floor_of(s, 4, diffuse(s, 0.5f));
    pt_add_sphere(s, pt_v3(-0.7f, 0.6f, 0), 0.6f, mirror(s, 0.8f));
    pt_add_sphere(s, pt_v3(0.7f, 0.6f, 0), 0.6f, glass(s, 1.5f));
    quad(s, -1, 2, -1, 2, 0, 0, 0, 0, 2, lamp(s, 2, 1));
    pt_add_sphere(s, pt_v3(0, 0.8f, -1.5f), 0.5f, lamp(s, 2, 0));
    sunny(s, 0.5f, 0);
    d->camera.eye = pt_v3(0, 1.2f, 3.5f); d->camera.target = pt_v3(0, 0.6f, 0); d->camera.vfov_deg = 45;
    return NULL;
}
static inline pt_scene *instanced_lamps(pt_scene *s, pt_render_desc *d) {
    static const pt_xform at[4] = { { { 1, 0, 0, -1.3f,  0, 1, 0, 0,  0, 0, 1, 0 } },             /* moved */
                                    { { -1, 0, 0, 1.3f,  0, 1, 0, 0,  0, 0, 1, 0 } },             /* mirrored */
                                    { { 0, 0, -1.5f, 0,  0, 1.5f, 0, 0.2f,  1.5f, 0, 0, -1.5f } },       /* scaled and turned */
                                    { { 0.5f, 0, 0, 0,  0.2f, -0.8f, 0, 1.5f,  0, 0, 1.2f, 1.2f } } };   /* sheared, upside down */
    pt_scene *one = pt_scene_create(NULL);
    int i;
    quad(one, -0.4f, 1, -0.4f, 0.8f, 0, 0, 0, 0, 0.8f, lamp(one, 3, 0));
    triangle_of(one, pt_v3(-0.6f, 0.2f, 0), pt_v3(-0.6f, 0.9f, 0), pt_v3(-0.2f, 0.5f, 0.5f), lamp(one, 4, 1));
    pt_add_sphere(one, pt_v3(0.3f, 0.4f, 0), 0.3f, lamp(one, 2, 0));
    pt_add_box(one, pt_v3(-0.2f, 0, 0.3f), pt_v3(0.2f, 0.2f, 0.5f), NULL, diffuse(one, 0.8f));
    commit(one);
    for (i = 0; i < 4; i++) pt_add_instance(s, one, &at[i]);
    floor_of(s, 5, diffuse(s, 0.5f));
    d->camera.eye = pt_v3(0, 2.5f, 3.5f); d->camera.target = pt_v3(0, 0.4f, 0); d->camera.vfov_deg = 50;
    return one;
}
static inline pt_scene *closed_room(pt_scene *s, pt_render_desc *d) {
    pt_add_box(s, pt_v3(-1.5f, 0, -1.5f), pt_v3(1.5f, 2, 1.5f), NULL, colored(s, 0.6f, 0.5f, 0.4f));
    quad(s, -0.9f, 0.5f, -0.5f, 0.3f, 0, 0.8f, 0, 1, 0, lamp(s, 2, 1));
    quad(s, 0.6f, 0.3f, -0.6f, 0, 0, 0.9f, 0, 0.9f, 0, lamp(s, 3, 0));
    pt_add_sphere(s, pt_v3(0, 1.6f, -0.8f), 0.35f, lamp(s, 2, 1));
    d->camera.eye = pt_v3(0.2f, 1, 1.4f); d->camera.target = pt_v3(0, 0.9f, 0); d->camera.vfov_deg = 70;
    return NULL;
}
static inline pt_scene *two_by_the_wall(pt_scene *s, pt_render_desc *d) {
    sphere_by_the_wall(s, d);
    quad(s, -1, 3, 0.2f, 2, 0, 0, 0, 0, 2, lamp(s, 2, 0));
    return NULL;
}
static inline pt_scene *densities(pt_scene *s, pt_render_desc *d) {
    two_by_the_wall(s, d);
    add_cone(s, 0.3f); add_sphere(s, 0.1f); add_lossy(s, 0); add_important(s, 0.1f, half_to_the_right);
    return NULL;
}
static inline pt_scene *lens_and_depth(pt_scene *s, pt_render_desc *d) {
    pt_add_box(s, pt_v3(-2, 0, -2), pt_v3(2, 3, 2), NULL, diffuse(s, 0.6f));
    pt_add_sphere(s, pt_v3(0.5f, 0.5f, -0.5f), 0.5f, coat(s));
    pt_add_sphere(s, pt_v3(-0.8f, 2, -0.7f), 0.4f, lamp(s, 2, 0));
    quad(s, -0.7f, 2.99f, -0.7f, 1.4f, 0, 0, 0, 0, 1.4f, lamp(s, 1, 0));
    d->camera.eye = pt_v3(0.3f, 1.2f, 1.8f); d->camera.target = pt_v3(0, 0.8f, -0.5f); d->camera.vfov_deg = 60;
    d->camera.aperture = 0.15f; d->camera.focus = 2;
    d->max_depth = 500;
    return NULL;
}

/* A white room without a way out. With a share w for the BSDF, throughput grows by albedo / w a bounce along the paths that
   the BSDF draws, and its square in the mean by albedo^2 / w, which must not go on above 1. */
static inline pt_scene *white_room(pt_scene *s, pt_render_desc *d) {
    pt_add_box(s, pt_v3(-2, 0, -2), pt_v3(2, 3, 2), NULL, diffuse(s, 0.9f));
    quad(s, -0.7f, 2.99f, -0.7f, 1.4f, 0, 0, 0, 0, 1.4f, lamp(s, 3, 0));
    d->camera.eye = pt_v3(0.3f, 1.2f, 1.8f); d->camera.target = pt_v3(0, 0.8f, -0.5f); d->camera.vfov_deg = 60;
    return NULL;
}

/* 8 x 8 pixels as 2 x 2 blocks, whose means over independent renders (seeds) and the three channels are pushed into m; the
   fifth is the whole picture's. */
#define BLOCKS 5
static inline void push_blocks(stats_moments m[BLOCKS], const pt_scene *s, pt_render_desc *d, int renders, uint64_t seed) {
    static float rgb[8 * 8 * 3];
    int i, b, x, y;
    for (i = 0; i < renders; i++) {
        double sum[BLOCKS] = { 0, 0, 0, 0, 0 };
        d->seed = seed + (uint64_t)i;
        if (!render(s, d, rgb, NULL)) return;
        for (y = 0; y < 8; y++) for (x = 0; x < 8; x++) {
            const float *p = rgb + 3 * (y * 8 + x);
            sum[y / 4 * 2 + x / 4] += ((double)p[0] + p[1] + p[2]) / 48;
        }
        for (b = 0; b < 4; b++) { stats_push(&m[b], sum[b]); sum[4] += sum[b] / 4; }
        stats_push(&m[4], sum[4]);
    }
}
static inline void compare_blocks(const char *what, const stats_moments a[BLOCKS], const stats_moments b[BLOCKS]) {
    int k;
    for (k = 0; k < BLOCKS; k++) {
        double d = a[k].mean - b[k].mean, e = sqrt(stats_error(&a[k]) * stats_error(&a[k]) + stats_error(&b[k]) * stats_error(&b[k]));
        test_case("%s, block %d: %g and %g, %.2f sigma", what, k, a[k].mean, b[k].mean, d / e);
        CHECK_P(stats_welch_test(&a[k], &b[k]));
        CHECK(a[k].mean > 0.005);
    }
    CHECK(stats_error(&a[4]) < 0.01 * a[4].mean && stats_error(&b[4]) < 0.01 * b[4].mean);     /* the test has teeth */
}
#endif
