/* Renders small scenes that between them touch everything, and prints a 64-bit FNV-1a hash of each picture's PFM and, in
   all curves, PNG. Every compiler, flag and machine must print the same (tests/portable.sh compares).  usage: portable [ISA] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <stdio.h>

enum { W = 20, H = 15 };
static const char *isa;

/* The callbacks here are compiled with any flags at all, so that a compiler may fuse a * b + c in them: rounding the
   product by hand keeps their bits equal too. */
static float product(float a, float b) { volatile float p = a * b; return p; }

/* ---- hashing ---- */
static int fnv(void *user, const void *data, size_t size) {
    uint64_t *hash = (uint64_t *)user;
    const unsigned char *p = (const unsigned char *)data;
    while (size--) *hash = (*hash ^ *p++) * 1099511628211u;
    return 0;
}
static void print_hash(const char *name, const float *rgb) {
    uint64_t hash = 14695981039346656037u;
    static const pt_curve curves[3] = { PT_CURVE_SRGB, PT_CURVE_FILMIC, PT_CURVE_FALSE_COLOR };
    pt_encoding e;
    pt_writer w;
    int i, ok;
    w.write = fnv; w.user = &hash;
    ok = rgb && pt_write_pfm_to(&w, rgb, W, H) == PT_OK;
    for (i = 0; ok && i < 6; i++) {
        e.exposure_stops = .3f; e.curve = curves[i % 3]; e.bits = i < 3 ? 8 : 16;
        ok = pt_write_png_to(&w, rgb, W, H, &e) == PT_OK;
    }
    if (!ok) { printf("%-12s failed\n", name); return; }
    printf("%-12s %08lx%08lx\n", name, (unsigned long)(hash >> 32), (unsigned long)(hash & 0xffffffffu));
    fflush(stdout);
}
static pt_render_desc settings(float ex, float ey, float ez, float tx, float ty, float tz) {
    pt_render_desc d;
    memset(&d, 0, sizeof d);
    d.width = W; d.height = H; d.spp = 8; d.max_depth = 12; d.tile = 8; d.threads = 2; d.seed = 12345; d.isa = isa;
    d.camera.eye = pt_v3(ex, ey, ez);
    d.camera.target = pt_v3(tx, ty, tz);
    return d;
}
static void run(const char *name, pt_scene *s, const pt_render_desc *d) {
    pt_render *r;
    if (pt_scene_commit(s) < 0) { printf("%-12s %s\n", name, pt_scene_error(s)); return; }
    r = pt_render_create(s, d);
    if (pt_render_run(r) != PT_OK) printf("%-12s %s\n", name, pt_render_error(r));
    else print_hash(name, pt_render_pixels(r));
    pt_render_destroy(r);
}

/* ---- scenes ---- */
static pt_material matte(pt_scene *s, float r, float g, float b) {
    pt_material_desc d;
    memset(&d, 0, sizeof d);
    d.color = pt_v3(r, g, b);
    return pt_add_material(s, &d);
}
static pt_material lamp(pt_scene *s, float r, float g, float b) {
    pt_material_desc d;
    memset(&d, 0, sizeof d);
    d.emission = pt_v3(r, g, b);
    return pt_add_material(s, &d);
}
static pt_material smooth(pt_scene *s, pt_bsdf bsdf, float r, float g, float b) {
    pt_material_desc d;
    memset(&d, 0, sizeof d);
    d.bsdf = bsdf;
    d.color = pt_v3(r, g, b);
    return pt_add_material(s, &d);
}
static pt_scene *cornell(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material white = matte(s, .73f, .73f, .73f), red = matte(s, .65f, .05f, .05f), green = matte(s, .12f, .45f, .15f);
    pt_xform turned = { { .8f, 0, .6f, .45f, 0, 1, 0, 0, -.6f, 0, .8f, .55f } };
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,0,1), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(0,1,0), pt_v3(1,0,0), pt_v3(0,0,1), white);
    pt_add_quad(s, pt_v3(0,0,1), pt_v3(0,1,0), pt_v3(1,0,0), white);
    pt_add_quad(s, pt_v3(1,0,0), pt_v3(0,0,1), pt_v3(0,1,0), red);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,1,0), pt_v3(0,0,1), green);
    pt_add_quad(s, pt_v3(.35f,.999f,.35f), pt_v3(.3f,0,0), pt_v3(0,0,.3f), lamp(s, 15, 15, 15));
    pt_add_box(s, pt_v3(.15f,0,.15f), pt_v3(.45f,.30f,.45f), NULL, white);
    pt_add_box(s, pt_v3(0, 0, 0), pt_v3(.3f, .6f, .3f), &turned, white);
    return s;
}
static pt_scene *spheres(void) {
    static const unsigned char checker[] = { 200, 40, 10,  20, 90, 240,  255, 255, 255,  60, 60, 60 };
    pt_scene *s = pt_scene_create(NULL);
    pt_texture_desc t;
    pt_material_desc m;
    memset(&t, 0, sizeof t);
    memset(&m, 0, sizeof m);
    t.width = 2; t.height = 2; t.channels = 3; t.srgb = 1; t.pixels = checker;
    m.color_texture = pt_add_texture(s, &t);
    pt_add_quad(s, pt_v3(-4, 0, -4), pt_v3(0, 0, 8), pt_v3(8, 0, 0), pt_add_material(s, &m));
    pt_add_sphere(s, pt_v3(-.9f, 1, 0), 1, smooth(s, PT_BSDF_CONDUCTOR, .9f, .8f, .6f));
    pt_add_sphere(s, pt_v3(1, .8f, .7f), .8f, smooth(s, PT_BSDF_DIELECTRIC, 1, 1, 1));
    pt_add_sphere(s, pt_v3(0, 4, 1), .3f, lamp(s, 60, 50, 40));
    pt_add_sphere(s, pt_v3(3, 1, -2), .2f, lamp(s, 5, 20, 60));
    return s;
}

/* A small rippled sheet, through the OBJ reader. Its text is made of integers, so that it is the same everywhere. */
static size_t obj_text(char *out) {
    char *at = out;
    int i, j, n = 12;
    for (i = 0; i <= n; i++)
        for (j = 0; j <= n; j++) at += sprintf(at, "v %d.5 %d.%d25 %d.5e0\nvn 0.%d 1 0.%d\n", i - n / 2, (i * j) % 3, (i * 7 + j) % 10,
                                               j - n / 2, i % 5, j % 5);
    for (i = 0; i < n; i++)
        for (j = 0; j < n; j++) {
            int a = i * (n + 1) + j + 1;
            at += sprintf(at, "f %d//%d %d//%d %d//%d %d//%d\n", a, a, a + 1, a + 1, a + n + 2, a + n + 2, a + n + 1, a + n + 1);
        }
    return (size_t)(at - out);
}
static pt_scene *sheet(void) {
    static char text[40000];
    pt_scene *s = pt_scene_create(NULL);
    pt_mesh mesh;
    pt_mesh_desc d;
    memset(&mesh, 0, sizeof mesh);
    memset(&d, 0, sizeof d);
    if (pt_read_obj_memory(&mesh, text, obj_text(text)) != PT_OK) printf("sheet: %s\n", mesh.error);
    d.positions = mesh.positions; d.vertex_count = mesh.vertex_count; d.indices = mesh.indices; d.index_count = mesh.index_count;
    d.normals = mesh.normals; d.material = matte(s, .6f, .7f, .5f);
    pt_add_mesh(s, &d);
    pt_mesh_free(&mesh);
    return s;
}
static void add_map(pt_scene *s) {                        /* a map with a few bright pixels, through the HDR writer's twin */
    static float map[16 * 8 * 3];
    pt_texture_desc t;
    pt_light_desc l;
    int i;
    for (i = 0; i < 16 * 8 * 3; i++) map[i] = (float)(i * 37 % 11) / 16 + (i / 3 == 37 ? 200 : i / 3 == 90 ? 20 : 0);
    memset(&t, 0, sizeof t);
    memset(&l, 0, sizeof l);
    t.width = 16; t.height = 8; t.channels = 3; t.bits = 32; t.pixels = map;
    l.kind = PT_LIGHT_ENVIRONMENT; l.texture = pt_add_texture(s, &t); l.rotate_deg = 33;
    pt_add_light(s, &l);
}
static pt_vec3 sky(void *user, pt_vec3 d) {
    (void)user;
    if (d.y > .8f && d.x > .1f) return pt_v3(30, 25, 20);
    return d.y > 0 ? pt_v3(.3f, .5f, product(.9f, d.y)) : pt_v3(.1f, .1f, .1f);
}
static void add_sky(pt_scene *s) {
    pt_light_desc l;
    memset(&l, 0, sizeof l);
    l.kind = PT_LIGHT_ENVIRONMENT; l.radiance = sky;
    pt_add_light(s, &l);
}

/* A user's shape: the square |x|, |z| < 1 at height .5. A user's BSDF: half black, half a perfect mirror's delta lobe. */
static void plate_bounds(void *user, pt_vec3 *lo, pt_vec3 *hi) {
    (void)user;
    *lo = pt_v3(-1, .5f, -1);
    *hi = pt_v3(1, .5f, 1);
}
static int plate_intersect(void *user, const pt_ray *ray, pt_vertex *x) {
    float t = (.5f - ray->org.y) / ray->dir.y, px = product(t, ray->dir.x) + ray->org.x, pz = product(t, ray->dir.z) + ray->org.z;
    (void)user;
    if (!(t > ray->tmin && t < ray->tmax) || px < -1 || px > 1 || pz < -1 || pz > 1) return 0;
    x->t = t;
    x->ng = pt_v3(0, 1, 0);
    return 1;
}
static pt_vec3 half_eval(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return pt_v3(0, 0, 0); }
static float half_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return 0; }
static int half_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) {
    (void)user;
    if (u[2] < .5f) return 0;
    out->wi = pt_v3(-x->wo.x, x->wo.y, -x->wo.z);          /* the plate is horizontal */
    out->f = pt_v3(.4f, .3f, .45f);
    out->pdf = .5f;
    out->delta = 1;
    return 1;
}
static float half_delta(void *user, const pt_vertex *x) { (void)user; (void)x; return 1; }
static const pt_shape_vtable plate = { plate_bounds, plate_intersect };
static const pt_bsdf_vtable half_mirror = { half_eval, half_pdf, half_sample, half_delta };

static pt_scene *user_scene(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc m;
    memset(&m, 0, sizeof m);
    m.bsdf = PT_BSDF_USER; m.vtable = &half_mirror;
    pt_add_user_shape(s, &plate, NULL, pt_add_material(s, &m));
    pt_add_box(s, pt_v3(-.3f, .6f, -.3f), pt_v3(.3f, 1.2f, .3f), NULL, matte(s, .7f, .4f, .2f));
    add_sky(s);
    return s;
}
static pt_scene *instances(const pt_scene *of) {
    pt_scene *s = pt_scene_create(NULL);
    int i;
    for (i = 0; i < 9; i++) {
        float c = i % 2 ? .8f : -1.f, n = i % 2 ? .6f : 0.f;     /* turned, or turned and mirrored */
        pt_xform m = { { .2f, 0, 0, 0, 0, .3f, 0, 0, 0, 0, .2f, 0 } };
        m.m[0] = product(.2f, c); m.m[2] = product(.2f, n); m.m[8] = product(-.2f, n); m.m[10] = product(.2f, i % 2 ? .8f : 1.f);
        m.m[3] = (float)(i % 3 - 1) * 2.5f; m.m[11] = (float)(i / 3 - 1) * 2.5f;
        pt_add_instance(s, of, &m);
    }
    add_sky(s);
    return s;
}
/* Halves of the samples, by two renders, merged: must equal the whole. */
static void merged(pt_scene *s, pt_render_desc d) {
    pt_render *a, *b;
    d.spp /= 2;
    a = pt_render_create(s, &d);
    d.first_sample = d.spp;
    b = pt_render_create(s, &d);
    if (pt_render_run(a) == PT_OK && pt_render_run(b) == PT_OK && pt_render_merge(a, b) == PT_OK) print_hash("merged", pt_render_pixels(a));
    else printf("merged       failed\n");
    pt_render_destroy(a);
    pt_render_destroy(b);
}

int main(int argc, char **argv) {
    pt_scene *s = cornell(), *part;
    pt_render_desc d = settings(.5f, .5f, -1.4f, .5f, .5f, 0);
    isa = argc > 1 ? argv[1] : NULL;
    d.isa = isa;
    run("cornell", s, &d);
    merged(s, d);
    d.sampler = PT_SAMPLER_STRATIFIED; run("stratified", s, &d);
    d.sampler = PT_SAMPLER_RANDOM;     run("random", s, &d);
    d.sampler = PT_SAMPLER_SOBOL;
    d.weights.bsdf = 1;                run("naive", s, &d);
    pt_scene_destroy(s);

    s = spheres();
    d = settings(0, 2, 7, 0, 1, 0);
    d.camera.aperture = .1f;
    run("spheres", s, &d);
    pt_scene_destroy(s);

    s = sheet();
    add_map(s);
    d = settings(3, 9, 14, 0, 1, 0);
    run("map", s, &d);
    pt_scene_destroy(s);

    part = cornell();
    pt_scene_commit(part);
    s = instances(part);
    d = settings(0, 5, 9, 0, 0, 0);
    run("instances", s, &d);
    pt_scene_destroy(s);
    pt_scene_destroy(part);

    s = user_scene();
    d = settings(2, 2, 3, 0, .5f, 0);
    run("user", s, &d);
    pt_scene_destroy(s);
    return 0;
}
