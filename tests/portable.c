/* Renders small scenes that between them touch everything, and prints a 64-bit FNV-1a hash of each picture's PFM, HDR and,
   in all curves, PNG and PPM. Every compiler, flag and machine must print the same (tests/portable.sh compares).  usage: portable [ISA] */
#define PTI_GUIDE_WORTH 0.0f                             /* a guide, where one is asked for, does not step aside */
#define PTI_GUIDE_PATHS 1
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
        ok = pt_write_png_to(&w, rgb, W, H, &e) == PT_OK && pt_write_ppm_to(&w, rgb, W, H, &e) == PT_OK;
    }
    ok = ok && pt_write_hdr_to(&w, rgb, W, H) == PT_OK;
    if (!ok) { printf("%-15s failed\n", name); return; }
    printf("%-15s %08lx%08lx\n", name, (unsigned long)(hash >> 32), (unsigned long)(hash & 0xffffffffu));
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
    if (pt_scene_commit(s) < 0) { printf("%-15s %s\n", name, pt_scene_error(s)); return; }
    r = pt_render_create(s, d);
    if (pt_render_run(r) != PT_OK) printf("%-15s %s\n", name, pt_render_error(r));
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
/* ---- what materials, textures, lights and cameras can do; a material's desc is changed and used again ---- */
static void light(pt_scene *s, pt_light_kind kind, pt_vec3 color, pt_vec3 position, pt_vec3 direction) {
    pt_light_desc l;
    memset(&l, 0, sizeof l);
    l.kind = kind; l.color = color; l.position = position; l.direction = direction;
    l.radius = .1f; l.radius_deg = 2; l.cone_deg = 30; l.blend = .4f; l.turbidity = 4;
    pt_add_light(s, &l);
}
static void floor_of(pt_scene *s, pt_material m) { pt_add_quad(s, pt_v3(-4, 0, -4), pt_v3(0, 0, 8), pt_v3(8, 0, 0), m); }
static int spheres_in;                                   /* in four columns and rows */
static void ball(pt_scene *s, const pt_material_desc *m) {
    int i = spheres_in++;
    pt_add_sphere(s, pt_v3((float)(i % 4) * 1.5f - 2.25f, .6f, (float)(i / 4) * 1.5f - 2), .6f, pt_add_material(s, m));
}
static pt_measured measured(pt_scene *s) {                /* rough in all angles, and here and there not measured */
    static float values[3 * 20 * 10 * 6];
    pt_measured_desc d;
    int i;
    for (i = 0; i < 3 * 20 * 10 * 6; i++) values[i] = (float)(i * 7919 % 1009 - 9) / 1000 * (i < 180 ? 30 : .5f);
    memset(&d, 0, sizeof d);
    d.values = values; d.cells_h = 20; d.cells_d = 10; d.cells_p = 6;
    return pt_add_measured(s, &d);
}
static pt_scene *metals(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc m;
    spheres_in = 0;
    floor_of(s, matte(s, .5f, .6f, .7f));
    memset(&m, 0, sizeof m);
    m.bsdf = PT_BSDF_CONDUCTOR; m.color = pt_v3(.9f, .7f, .5f);
    m.roughness = .1f; ball(s, &m);
    m.roughness = .5f; ball(s, &m);
    m.roughness = 1;   ball(s, &m);
    m.roughness = .2f; m.roughness_y = .6f; m.rotation_deg = 30; ball(s, &m);
    pt_metal("gold", &m.eta, &m.k);
    ball(s, &m);
    m.roughness_y = 0; m.rotation_deg = 0; ball(s, &m);
    m.roughness = 0;   ball(s, &m);
    m.bsdf = PT_BSDF_MEASURED; m.measured = measured(s); ball(s, &m);
    light(s, PT_LIGHT_SUN, pt_v3(3, 3, 2), pt_v3(0, 0, 0), pt_v3(1, -2, -1));
    add_sky(s);
    return s;
}
static pt_scene *glasses(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc m;
    spheres_in = 0;
    floor_of(s, matte(s, .5f, .6f, .7f));
    memset(&m, 0, sizeof m);
    m.bsdf = PT_BSDF_DIELECTRIC;
    m.roughness = .2f; ball(s, &m);
    m.roughness = .8f; m.color = pt_v3(.9f, 1, .8f); ball(s, &m);
    m.roughness = .3f; m.roughness_y = .1f; ball(s, &m);
    m.abbe = 20; ball(s, &m);
    m.roughness = m.roughness_y = 0; ball(s, &m);
    m.thin = 1; m.abbe = 0; ball(s, &m);
    m.roughness = .4f; ball(s, &m);
    m.roughness = 0; m.ior = .7f; m.thin = 0; ball(s, &m);
    light(s, PT_LIGHT_POINT, pt_v3(90, 80, 70), pt_v3(1, 4, 2), pt_v3(0, 0, 0));
    light(s, PT_LIGHT_SPOT, pt_v3(500, 600, 900), pt_v3(-3, 4, 3), pt_v3(2, -4, -3));
    return s;
}
static pt_scene *principled(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc m, mix;
    spheres_in = 0;
    memset(&m, 0, sizeof m);
    memset(&mix, 0, sizeof mix);
    m.color = pt_v3(.8f, .7f, .6f); m.roughness = .7f;
    floor_of(s, pt_add_material(s, &m));                 /* diffuse, rough */
    m.translucency = .5f; ball(s, &m);
    m.transparency = .4f; ball(s, &m);
    m.bsdf = PT_BSDF_PRINCIPLED; m.transparency = 0; ball(s, &m);
    m.coat = .8f; m.coat_roughness = .1f; m.coat_ior = 1.7f; ball(s, &m);
    m.sheen = .9f; m.sheen_color = pt_v3(.2f, .5f, 1); ball(s, &m);
    m.metallic = .5f; m.roughness_y = .3f; ball(s, &m);
    mix.a = pt_add_material(s, &m);
    m.metallic = 0; m.transmission = .7f; m.sheen = 0; m.coat_roughness = 0; ball(s, &m);
    m.specular = .3f; m.thin = 1; ball(s, &m);
    m.roughness = m.roughness_y = m.coat = 0; m.specular = 1; m.thin = 0; m.transmission = 1; ball(s, &m);
    mix.b = pt_add_material(s, &m);
    mix.bsdf = PT_BSDF_MIX; mix.mix = .4f; ball(s, &mix);
    mix.transparency = .3f; ball(s, &mix);
    m.bsdf = PT_BSDF_NONE; m.emission = pt_v3(.1f, .2f, .3f); ball(s, &m);
    light(s, PT_LIGHT_SKY, pt_v3(.02f, .02f, .02f), pt_v3(0, 0, 0), pt_v3(1, -1, -2));
    return s;
}
/* Pixels of every depth, patterns, maps of every number. Each texture is on a ball of its own. */
static pt_texture pixels(pt_scene *s, int bits, int channels, int turn) {
    static unsigned char p8[8 * 4 * 4];
    static uint16_t p16[8 * 4 * 4];
    static float p32[8 * 4 * 4];
    pt_texture_desc t;
    int i;
    for (i = 0; i < 8 * 4 * 4; i++) {
        p8[i] = (unsigned char)(i * 89 % 256);
        p16[i] = (uint16_t)(i * 4099 % 65536);
        p32[i] = (float)(i * 7 % 17) / 16;
    }
    memset(&t, 0, sizeof t);
    t.width = 8; t.height = 4; t.channels = channels; t.bits = bits;
    t.pixels = bits == 16 ? (const void *)p16 : bits == 32 ? (const void *)p32 : (const void *)p8;
    t.srgb = bits != 32 && turn % 2; t.nearest = turn == 3; t.wrap_u = (pt_wrap)(turn % 3); t.wrap_v = (pt_wrap)((turn + 1) % 3);
    t.uv_scale[0] = 2.5f; t.uv_scale[1] = -1.5f; t.uv_rotate_deg = (float)(20 * turn); t.uv_offset[0] = .3f;
    return pt_add_texture(s, &t);
}
static pt_texture pattern(pt_scene *s, pt_pattern kind, int solid) {
    pt_texture_desc t;
    memset(&t, 0, sizeof t);
    t.pattern = kind; t.solid = solid; t.frequency = 3; t.octaves = 4; t.uv_scale[0] = 8; t.uv_scale[1] = 4;
    t.color_a = pt_v3(.1f, .2f, .3f); t.color_b = pt_v3(.9f, .8f, .5f);
    return pt_add_texture(s, &t);
}
static pt_texture alpha_of(pt_scene *s, pt_texture of) {
    pt_texture_desc t;
    memset(&t, 0, sizeof t);
    t.of = of; t.channel = 4;
    return pt_add_texture(s, &t);
}
static pt_scene *textures(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc m;
    int i;
    spheres_in = 0;
    memset(&m, 0, sizeof m);
    m.color_texture = pattern(s, PT_PATTERN_CHECKER, 1);
    floor_of(s, pt_add_material(s, &m));
    for (i = 0; i < 5; i++) {
        m.color_texture = pixels(s, i % 3 == 0 ? 8 : i % 3 == 1 ? 16 : 32, i % 4 + 1, i);
        m.opacity_texture.id = 0;
        if (i == 3) m.opacity_texture = alpha_of(s, m.color_texture);
        ball(s, &m);
    }
    memset(&m, 0, sizeof m);
    m.color_texture = pattern(s, PT_PATTERN_NOISE, 1); m.normal_texture = pixels(s, 8, 3, 0); ball(s, &m);
    m.color_texture = pattern(s, PT_PATTERN_FBM, 0);   m.bump_texture = pattern(s, PT_PATTERN_FBM, 1); m.bump = .05f; ball(s, &m);
    m.normal_texture.id = 0; m.bump_texture = pixels(s, 16, 1, 2); ball(s, &m);
    m.bsdf = PT_BSDF_PRINCIPLED;
    m.roughness_texture = m.metallic_texture = m.rotation_texture = pixels(s, 8, 1, 0);
    m.roughness_y_texture = m.coat_texture = pattern(s, PT_PATTERN_NOISE, 0);
    ball(s, &m);
    memset(&m, 0, sizeof m);
    m.emission_texture = pixels(s, 32, 3, 1); m.emission = pt_v3(2, 3, 4); ball(s, &m);
    light(s, PT_LIGHT_POINT, pt_v3(90, 80, 70), pt_v3(1, 4, 2), pt_v3(0, 0, 0));
    return s;
}
static pt_scene *outdoors(void) {
    pt_scene *s = sheet();
    pt_light_desc l;
    memset(&l, 0, sizeof l);
    l.kind = PT_LIGHT_SKY; l.color = pt_v3(.03f, .03f, .04f); l.direction = pt_v3(1, -.3f, .5f); l.turbidity = 7;
    pt_add_light(s, &l);
    return s;
}

/* Through the other readers: an OBJ with an MTL, which is smoothed; PLY of all three kinds. */
static void add_read(pt_scene *s, pt_mesh *mesh, float lift) {
    pt_material all[8];
    pt_mesh_desc d;
    size_t i;
    memset(&d, 0, sizeof d);
    for (i = 0; i < mesh->material_count && i < 8; i++) all[i] = pt_add_material(s, &mesh->materials[i].desc);
    for (i = 0; i < mesh->vertex_count; i++) mesh->positions[3 * i + 1] += lift;
    d.positions = mesh->positions; d.vertex_count = mesh->vertex_count; d.indices = mesh->indices; d.index_count = mesh->index_count;
    d.normals = mesh->normals; d.uvs = mesh->uvs; d.materials = mesh->material_count ? all : NULL; d.material_count = mesh->material_count;
    d.material_ids = mesh->material_ids;
    if (!mesh->material_count) d.material = matte(s, .7f, .7f, .2f);
    pt_add_mesh(s, &d);
    pt_mesh_free(mesh);
}
static size_t put_float(unsigned char *out, size_t at, float f, int big) {
    uint32_t u;
    int i;
    memcpy(&u, &f, sizeof u);
    for (i = 0; i < 4; i++) out[at + (size_t)i] = (unsigned char)(u >> (big ? 24 - 8 * i : 8 * i));
    return at + 4;
}
static size_t ply_tetrahedron(unsigned char *out, int big) {
    static const float v[4][3] = { { -1, 0, -1 }, { 1, 0, -1 }, { 0, 0, 1.3f }, { .1f, 1.7f, -.1f } };
    static const unsigned char face[4][3] = { { 0, 1, 2 }, { 0, 3, 1 }, { 1, 3, 2 }, { 2, 3, 0 } };
    size_t at = (size_t)sprintf((char *)out, "ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 4\nproperty list uchar uchar vertex_indices\nend_header\n", big ? "big" : "little");
    int i, k;
    for (i = 0; i < 4; i++) for (k = 0; k < 3; k++) at = put_float(out, at, v[i][k] + (k == 0 ? (big ? 2.f : -2.f) : 0.f), big);
    for (i = 0; i < 4; i++) { out[at++] = 3; for (k = 0; k < 3; k++) out[at++] = face[i][k]; }
    return at;
}
static pt_scene *files(void) {
    static const char obj[] = "v -3 0 -3\nv 0 1.25 -3\nv 3 0 -3\nv -3 0 0\nv 0 1.5 0\nv 3 0 0\nv -3 0 3\nv 0 1.25e0 3\nv 3 0 3\n"
        "usemtl red\nf 1 4 5 2\nf 2 5 6 3\nusemtl shiny\nf 4 7 8 5\nusemtl glow\nf 5 8 9 6\n";
    static const char mtl[] = "newmtl red\nKd 0.75 0.1 0.2\nKs 0.3 0.3 0.3\nNs 90\nnewmtl shiny\nKd 0.2 0.2 0.9\nPm 0.9\nPr 0.35\n"
        "newmtl glow\nKd 0.5 0.5 0.5\nKe 1.5 2.25 .3\nd 0.8\n";
    static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "-4 -1 -4 0 1 0.1\n4 -1 -4 .1 1 0\n4 -1 4 0 1 -1e-1\n-4 -1 4 0 1 0\n4 0 3 2 1\n";
    unsigned char binary[1000];
    pt_scene *s = pt_scene_create(NULL);
    pt_mesh mesh;
    int big;
    memset(&mesh, 0, sizeof mesh);
    if (pt_read_obj_memory(&mesh, obj, sizeof obj - 1) || pt_read_mtl_memory(&mesh, mtl, sizeof mtl - 1) || pt_mesh_smooth(&mesh, 40))
        printf("files: %s\n", mesh.error);
    add_read(s, &mesh, 0);
    memset(&mesh, 0, sizeof mesh);
    if (pt_read_mesh_memory(&mesh, ply, sizeof ply - 1)) printf("files: %s\n", mesh.error);
    add_read(s, &mesh, 0);
    for (big = 0; big < 2; big++) {
        memset(&mesh, 0, sizeof mesh);
        if (pt_read_ply_memory(&mesh, binary, ply_tetrahedron(binary, big)) || pt_mesh_smooth(&mesh, 0)) printf("files: %s\n", mesh.error);
        add_read(s, &mesh, 1.3f);
    }
    add_map(s);
    return s;
}

/* In motion, before every camera. */
static pt_scene *moving(const pt_scene *of) {
    pt_scene *s = instances(of);
    pt_xform from = { { 1, 0, 0, -2, 0, 1, 0, 1, 0, 0, 1, 0 } }, to = { { .8f, 0, .6f, 1, 0, 1, 0, 1.5f, -.6f, 0, .8f, 1 } };
    pt_add_moving_instance(s, of, &from, &to);
    return s;
}
static void cameras(const pt_scene *of) {
    static const char *const names[] = { "perspective", "orthographic", "equirectangular", "fisheye" };
    pt_scene *s = moving(of);
    int i;
    for (i = 0; i < 4; i++) {
        pt_render_desc d = settings(0, 4, 6, 0, 0, 0);
        pt_camera *c = &d.camera;
        c->projection = (pt_projection)i;
        c->aperture = .2f; c->blades = 3 + 2 * i; c->blade_rotation_deg = 20;
        c->shutter_close = 1; c->moving = 1; c->eye_end = pt_v3(.5f, 4, 6); c->target_end = pt_v3(0, .2f, 0); c->up_end = pt_v3(.1f, 1, 0);
        if (i < 2) { c->shift_x = .1f; c->shift_y = -.2f; c->distortion = .1f; c->aberration = .05f; }
        if (i == 0) c->vignetting = .7f;
        if (i == 1) c->height = 6;
        d.spp = 4;
        d.filter = (pt_filter)(PT_FILTER_TENT + i);
        run(names[i], s, &d);
    }
    pt_scene_destroy(s);
}
/* Media of all kinds, in bounds of all kinds, with a lamp to aim at. */
static float layers(void *user, pt_vec3 p) { (void)user; return p.y > .5f ? .25f : product(p.y, p.y); }
static float layers_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; return hi.y > .5f ? 1 : .3f; }
static pt_vec3 warm(void *user, pt_vec3 p) { (void)user; return pt_v3(1, product(p.x, p.x), .1f); }
static pt_volume fill(pt_scene *s, pt_shape bounds, pt_medium_desc *m, float r, float g, float b, float absorbed) {
    m->sigma_s = pt_v3(r, g, b);
    m->sigma_a = pt_v3(absorbed, absorbed, absorbed);
    return pt_add_volume(s, bounds, pt_add_medium(s, m));
}
static pt_scene *media(void) {
    static const float corners[12] = { 0, 0, 0,  1, 0, 0,  0, 1, 0,  0, 0, 1 };
    static const uint32_t faces[12] = { 0, 2, 1,  0, 1, 3,  0, 3, 2,  1, 2, 3 };
    static const pt_xform turned = { { .8f, 0, .6f, -1.5f,  0, 1, 0, .6f,  -.6f, 0, .8f, .5f } };
    static float grid[5 * 6 * 7];
    pt_material none = { 0 };
    pt_shape everywhere = { 0 };
    pt_scene *s = pt_scene_create(NULL);
    pt_material_desc lamp;
    pt_mesh_desc mesh;
    pt_medium_desc m[6];
    int i;
    memset(m, 0, sizeof m);
    memset(&lamp, 0, sizeof lamp);
    memset(&mesh, 0, sizeof mesh);
    for (i = 0; i < 5 * 6 * 7; i++) grid[i] = (float)(i * 7 % 11) * .1f;
    pt_add_quad(s, pt_v3(-5, 0, 5), pt_v3(10, 0, 0), pt_v3(0, 0, -10), matte(s, .5f, .5f, .5f));
    lamp.emission = pt_v3(9, 8, 7);
    pt_add_sphere(s, pt_v3(0, 1.5f, 0), .2f, pt_add_material(s, &lamp));
    m[0].g = .4f;
    fill(s, everywhere, &m[0], .02f, .03f, .05f, .01f);
    m[1].phase = PT_PHASE_DROPLETS; m[1].grid = grid; m[1].nx = 5; m[1].ny = 6; m[1].nz = 7;
    fill(s, pt_add_box(s, pt_v3(-.6f, -.5f, -.6f), pt_v3(.6f, .5f, .6f), &turned, none), &m[1], 4, 3, 2, .1f);
    m[2].phase = PT_PHASE_TWO_LOBES; m[2].g = .7f; m[2].g2 = -.3f; m[2].mix = .4f;
    m[2].density = layers; m[2].density_max = 1; m[2].density_bound = layers_bound; m[2].emission = pt_v3(.3f, .3f, .3f); m[2].glow = warm;
    fill(s, pt_add_sphere(s, pt_v3(.5f, .6f, 1), .6f, none), &m[2], 2, 2, 2, .2f);
    mesh.positions = corners; mesh.vertex_count = 4; mesh.indices = faces; mesh.index_count = 12;
    m[3].phase = PT_PHASE_RAYLEIGH; m[3].tracking = PT_TRACK_MARCH_CDF; m[3].step = .05f;
    fill(s, pt_add_mesh(s, &mesh), &m[3], 1, 2, 3, 0);
    m[4].phase = PT_PHASE_DRAINE; m[4].g = .5f; m[4].alpha = 10;
    fill(s, pt_add_sphere(s, pt_v3(1.2f, .5f, .2f), .5f, none), &m[4], 1, 2, 3, .1f);
    lamp.emission = pt_v3(0, 0, 0); lamp.bsdf = PT_BSDF_DIELECTRIC; lamp.ior = 1.3f;
    m[5].sigma_a = pt_v3(.2f, 1, 3);
    lamp.inside = pt_add_medium(s, &m[5]);
    pt_add_sphere(s, pt_v3(-.5f, .5f, 1.5f), .4f, pt_add_material(s, &lamp));
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
    else printf("merged          failed\n");
    pt_render_destroy(a);
    pt_render_destroy(b);
}

static pt_scene *gap(void) {                              /* a lamp behind a wall */
    pt_scene *s = pt_scene_create(NULL);
    pt_material white = matte(s, .7f, .7f, .7f);
    pt_add_box(s, pt_v3(-2, 0, -1), pt_v3(2, 2, 1), NULL, white);
    pt_add_quad(s, pt_v3(0, 0, -1), pt_v3(0, 2, 0), pt_v3(0, 0, 1.6f), matte(s, .7f, .5f, .3f));
    pt_add_quad(s, pt_v3(1, 1, -.2f), pt_v3(0, 0, .4f), pt_v3(.4f, 0, 0), lamp(s, 40, 40, 30));
    return s;
}

#define SCENES 7
static const struct { const char *name; pt_scene *(*make)(void); } scenes[SCENES] = {
    { "metals", metals }, { "glasses", glasses }, { "principled", principled }, { "textures", textures }, { "outdoors", outdoors },
    { "files", files }, { "media", media }
};

int main(int argc, char **argv) {
    pt_scene *s = cornell(), *part;
    int i;
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

    s = gap();
    d = settings(-1.9f, 1, .2f, 0, .8f, 0);
    d.camera.vfov_deg = 70; d.guide = 64;
    run("guide", s, &d);
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
    cameras(part);
    pt_scene_destroy(part);

    s = user_scene();
    d = settings(2, 2, 3, 0, .5f, 0);
    run("user", s, &d);
    pt_scene_destroy(s);

    for (i = 0; i < SCENES; i++) {
        s = scenes[i].make();
        d = settings(0, 4, 6, 0, .4f, 0);
        d.spp = 4; d.camera.vfov_deg = 50; d.filter = i % 2 ? PT_FILTER_MITCHELL : PT_FILTER_GAUSSIAN;
        run(scenes[i].name, s, &d);
        pt_scene_destroy(s);
    }
    return 0;
}
