/* What volumes are for: coloured smoke (a grid a channel), fire, the air at sunset (Rayleigh's and haze, round a planet), a glass
   of juice, god rays through holes. Each until it is clean: until the relative error of its pixels is below 5 %; or as clean as
   512 samples make it. In the air and among god rays, where most ways to the sun are dim or barred, light is found by next-event
   estimation (1.9 and 1.2 times the efficiency of the mixture); in the juice behind its glass by the mixture (2 times that of the
   other), as everywhere else. OUT/figure_volumes_NAME.png.
   cc -O2 tests/bench/figure_volumes.c -o out/figure_volumes -lm -lpthread && out/figure_volumes [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "noise.h"
#include "panels.h"
#include "timing.h"
#include "clean.h"

static const pt_material none = { 0 };
static pt_material matte(pt_scene *s, float r, float g, float b) {
    return pt_add_material(s, &(pt_material_desc){ .color = { r, g, b } });
}
static void ground(pt_scene *s, float half, pt_material m) {
    pt_add_quad(s, pt_v3(-half, 0, half), pt_v3(2 * half, 0, 0), pt_v3(0, 0, -2 * half), m);
}
static void look(pt_render_desc *d, pt_vec3 eye, pt_vec3 target, float vfov_deg) {
    d->camera.eye = eye;
    d->camera.target = target;
    d->camera.vfov_deg = vfov_deg;
}

/* ---- smoke: three plumes that cross, one that takes red out of light, one green, one blue */

enum { SMOKE = 96 };
static float smoke_grid[3 * SMOKE * SMOKE * SMOKE];
static float plume(float x, float y, float z, float foot, float lean, float seed) {
    float wide = .035f + .16f * y, sway = .5f * y * noise_sum(seed, 2.2f * y, 0, 2), r;
    x -= foot + lean * y + sway; z -= .5f + .5f * y * noise_sum(seed, 2.2f * y, 5, 2);
    x += .5f * y * noise_sum(6 * x + seed, 7 * y, 6 * z, 3);
    z += .5f * y * noise_sum(6 * x, 7 * y + seed, 6 * z, 3);
    r = sqrtf(x * x + z * z) / wide;
    return r < 1 ? (1 - r) * (1.1f - y) * pti_clamp(.75f + 2.6f * noise_sum(11 * x + seed, 9 * y, 11 * z, 4), 0, 2) : 0;
}
static void smoke(pt_scene *s, pt_render_desc *d) {
    int i, n = SMOKE * SMOKE * SMOKE;
    for (i = 0; i < n; i++) {
        float x = ((float)(i % SMOKE) + .5f) / SMOKE, y = ((float)(i / SMOKE % SMOKE) + .5f) / SMOKE,
            z = ((float)(i / SMOKE / SMOKE) + .5f) / SMOKE;
        float a = plume(x, y, z, .26f, .25f, 1), b = plume(x, y, z, .5f, 0, 30), c = plume(x, y, z, .74f, -.25f, 60);
        smoke_grid[i] = a + .12f * b + .15f * c;         /* scatters red: what each channel meets */
        smoke_grid[n + i] = .25f * a + b + .2f * c;
        smoke_grid[2 * n + i] = .1f * a + .25f * b + c;
    }
    ground(s, 8, matte(s, .35f, .34f, .33f));
    pt_add_quad(s, pt_v3(-8, 0, -2.5f), pt_v3(16, 0, 0), pt_v3(0, 8, 0), matte(s, .16f, .17f, .19f));
    pt_add_volume(s, pt_add_box(s, pt_v3(-1.2f, 0, -1.2f), pt_v3(1.2f, 2.4f, 1.2f), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_s = { 26, 26, 26 }, .sigma_a = { .3f, .3f, .3f }, .g = .3f, .grid = smoke_grid, .nx = SMOKE, .ny = SMOKE,
        .nz = SMOKE, .grid_channels = 3 }));
    for (i = 0; i < 3; i++) pt_add_sphere(s, pt_v3(-.576f + .576f * (float)i, .03f, 0), .09f, matte(s, .05f, .05f, .05f));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { .8f, -1, -.7f }, .color = { 3.4f, 3.2f, 2.9f },
        .radius_deg = 2 });
    pt_add_light(s, &(pt_light_desc){ .color = { .22f, .26f, .32f } });
    look(d, pt_v3(0, 1.15f, 5.4f), pt_v3(0, 1.12f, 0), 27);
}

/* ---- fire: hot where it is dense, on logs, before a wall */

enum { FIRE = 64, FIRE_Y = 128 };
static float fire_grid[3 * FIRE * FIRE_Y * FIRE];
static float flames(float x, float y, float z) {
    float tongue = .16f * (1 + 2 * y), r, f;
    x += tongue * noise_sum(3 * x, 2.2f * y - 3, 3 * z, 3); z += tongue * noise_sum(3 * x + 9, 2.2f * y, 3 * z, 3);
    r = sqrtf(x * x + z * z) / (.42f - .12f * y);
    f = 1.15f - r - .62f * y + 1.5f * noise_sum(7 * x, 3.2f * y, 7 * z, 4) * (.3f + y);
    return pti_clamp(3 * f, 0, 1) * pti_clamp(1.15f - .35f * y, 0, 1);
}
static void fire(pt_scene *s, pt_render_desc *d) {
    pt_material bark = matte(s, .06f, .04f, .03f), stone = matte(s, .4f, .37f, .34f);
    int i, k, n = FIRE * FIRE_Y * FIRE;
    for (i = 0; i < n; i++) {                            /* cooler, redder above and outside */
        float h = flames(1.4f * ((float)(i % FIRE) + .5f) / FIRE - .7f, 2.28f * ((float)(i / FIRE % FIRE_Y) + .5f) / FIRE_Y,
                         1.4f * ((float)(i / FIRE / FIRE_Y) + .5f) / FIRE - .7f);
        fire_grid[i] = h;
        fire_grid[n + i] = .42f * h * h;
        fire_grid[2 * n + i] = .13f * h * h * h;
    }
    ground(s, 6, matte(s, .3f, .26f, .22f));
    pt_add_quad(s, pt_v3(-6, 0, -1.6f), pt_v3(12, 0, 0), pt_v3(0, 6, 0), matte(s, .4f, .34f, .3f));
    for (i = 0; i < 5; i++) {                            /* logs, of balls */
        float turn = 2.5f * (float)i, c = cosf(turn), n = sinf(turn);
        for (k = 0; k < 40; k++) {
            float out = .62f - .014f * (float)k;
            pt_add_sphere(s, pt_v3(c * out, .07f + .006f * (float)k, n * out), .065f, bark);
        }
    }
    for (i = 0; i < 14; i++)
        pt_add_sphere(s, pt_v3(.85f * cosf(.4488f * (float)i), .06f, .85f * sinf(.4488f * (float)i)),
            .13f + .04f * noise_at(i, 0, 0), stone);
    pt_add_volume(s, pt_add_box(s, pt_v3(-.7f, .02f, -.7f), pt_v3(.7f, 2.3f, .7f), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_a = { 1.2f, 1.2f, 1.2f }, .emission = { 14, 14, 14 }, .grid = fire_grid, .nx = FIRE, .ny = FIRE_Y, .nz = FIRE,
        .grid_channels = 3 }));
    pt_add_light(s, &(pt_light_desc){ .color = { .006f, .009f, .016f } });
    look(d, pt_v3(.4f, 1.1f, 5), pt_v3(0, .95f, 0), 30);
}

/* ---- air: kilometres; a planet of 6360, the sea, the sun a degree above it */

static double altitude(pt_vec3 p) {
    double y = (double)p.y + 6360;
    return sqrt((double)p.x * (double)p.x + (double)p.z * (double)p.z + y * y) - 6360;
}
static float thins(void *user, pt_vec3 p) { return pti_exp(-(float)pti_clamp((float)altitude(p), 0, 100) / *(float *)user); }
/* The lowest point of a box is on its floor, nearest to the axis. */
static float thins_bound(void *user, pt_vec3 lo, pt_vec3 hi) {
    return thins(user, pt_v3(pti_clamp(0, lo.x, hi.x), lo.y, pti_clamp(0, lo.z, hi.z)));
}
static void air(pt_scene *s, pt_render_desc *d) {
    static float heights[2] = { 8, 1.2f };               /* in which molecules and haze thin out by e */
    pt_shape box[2];
    int i;
    pt_add_sphere(s, pt_v3(0, -6360, 0), 6360, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED,
        .color = { .01f, .02f, .03f }, .roughness = .28f, .ior = 1.33f }));
    for (i = 0; i < 2; i++) box[i] = pt_add_box(s, pt_v3(-500, -32, -600), pt_v3(500, i ? 10 : 60, 40), NULL, none);
    pt_add_volume(s, box[0], pt_add_medium(s, &(pt_medium_desc){ .sigma_s = { .0058f, .0135f, .0331f }, .phase = PT_PHASE_RAYLEIGH,
        .density = thins, .density_max = 1, .density_bound = thins_bound, .user = heights }));
    pt_add_volume(s, box[1], pt_add_medium(s, &(pt_medium_desc){ .sigma_s = { .012f, .012f, .012f },
        .sigma_a = { .0012f, .0012f, .0012f }, .g = .76f, .density = thins, .density_max = 1,
        .density_bound = thins_bound, .user = heights + 1 }));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { .1f, -.02f, 1 }, .color = { 40, 40, 40 },
        .radius_deg = .5f });
    look(d, pt_v3(0, .3f, 0), pt_v3(-8, 18, -100), 58);
}

/* ---- juice: each wall of its glass is one surface, between what is on its sides */

static void turned(pt_scene *s, const float (*line)[2], int points, const pt_material *m, const uint32_t *which) {
    enum { SIDES = 256, MOST = 24 };
    static float p[SIDES * MOST * 3];
    static uint32_t index[SIDES * MOST * 6], id[SIDES * MOST * 2];
    size_t at = 0, n = 0;
    int i, k;
    for (k = 0; k < SIDES; k++) for (i = 0; i < points; i++) {
        float a = 2 * PTI_PI * (float)k / SIDES;
        p[n++] = line[i][0] * cosf(a); p[n++] = line[i][1]; p[n++] = line[i][0] * sinf(a);
    }
    for (k = 0; k < SIDES; k++) for (i = 0; i + 1 < points; i++) {
        uint32_t a = (uint32_t)(k * points + i), b = (uint32_t)((k + 1) % SIDES * points + i), quad[6];
        int first = line[i][0] > 0, second = line[i + 1][0] > 0, e;
        quad[0] = a; quad[1] = a + 1; quad[2] = b; quad[3] = a + 1; quad[4] = b + 1; quad[5] = b;
        for (e = 0; e < 2; e++) {
            if (!(e ? second : first)) continue;         /* on the axis there is one point */
            id[at / 3] = which[i];
            memcpy(index + at, quad + 3 * e, 3 * sizeof *index);
            at += 3;
        }
    }
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = p, .vertex_count = n / 3, .indices = index, .index_count = at, .materials = m,
        .material_count = 4,
        .material_ids = id });
}
static void juice(pt_scene *s, pt_render_desc *d) {      /* decimetres */
    static const float wall[][2] = { { 0, 0 }, { .30f, 0 }, { .32f, .015f }, { .40f, 1.28f }, { .395f, 1.295f },
        { .385f, 1.295f }, { .38f, 1.28f },
                                     { .3625f, 1 } };
    static const float body[][2] = { { 0, .09f }, { .28f, .09f }, { .30f, .11f }, { .3625f, 1 }, { 0, 1 } };
    static const uint32_t glass_only[8] = { 0 }, juice_faces[8] = { 1, 1, 1, 2 };
    pt_medium orange = pt_add_medium(s, &(pt_medium_desc){ .sigma_s = { 11, 11, 10 }, .sigma_a = { .02f, .8f, 9 }, .g = .5f });
    pt_material m[4], table = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = { .33f, .2f, .12f },
        .roughness = .35f });
    pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = { 7, 6.8f, 6.4f } });
    m[0] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.5f });
    m[1] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.34f / 1.5f, .inside = orange });
    m[2] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.34f, .inside = orange });
    m[3] = m[0];
    ground(s, 12, table);
    pt_add_quad(s, pt_v3(-12, 0, -6), pt_v3(24, 0, 0), pt_v3(0, 12, 0), matte(s, .32f, .4f, .45f));
    turned(s, wall, 8, m, glass_only);
    turned(s, body, 5, m, juice_faces);
    pt_add_quad(s, pt_v3(-3, 1, -1.5f), pt_v3(0, 0, 2.5f), pt_v3(.7f, 2, 0), lamp);      /* on the left, towards the glass */
    pt_add_quad(s, pt_v3(-.6f, 4, -1), pt_v3(2, 0, 0), pt_v3(0, 0, 2), lamp);                      /* above */
    pt_add_light(s, &(pt_light_desc){ .color = { .3f, .33f, .38f } });
    look(d, pt_v3(0, 1.5f, 4.2f), pt_v3(0, .62f, 0), 25);
}

/* ---- god rays: a hall, sun through a board of holes */

static void rays(pt_scene *s, pt_render_desc *d) {
    pt_material wall = matte(s, .24f, .22f, .2f);
    int i, k;
    ground(s, 6, wall);
    pt_add_quad(s, pt_v3(-3, 0, -3), pt_v3(6, 0, 0), pt_v3(0, 4, 0), wall);
    pt_add_quad(s, pt_v3(-3, 0, 6), pt_v3(0, 0, -9), pt_v3(0, 4, 0), wall);
    pt_add_quad(s, pt_v3(3, 0, -3), pt_v3(0, 0, 9), pt_v3(0, 4, 0), wall);
    for (i = 0; i < 13; i++) for (k = 0; k < 19; k++) {  /* a roof of tiles; every third of every third is missing */
        float x = -3 + 6 * (float)i / 13, z = -3 + 9 * (float)k / 19;
        if (i % 3 == 1 && k % 3 == 1 && z < 2.6f) continue;
        pt_add_quad(s, pt_v3(x, 4, z), pt_v3(6.0f / 13, 0, 0), pt_v3(0, 0, 9.0f / 19), wall);
    }
    for (i = 0; i < 5; i++) {
        pt_material ball = matte(s, .6f, .25f + .07f * (float)i, .12f);
        pt_add_sphere(s, pt_v3(-1.8f + .9f * (float)i, .34f, -.9f + .5f * (float)(i % 2)), .34f, ball);
    }
    pt_add_volume(s, pt_add_box(s, pt_v3(-3.5f, -.1f, -3.5f), pt_v3(3.5f, 6, 8), NULL, none), pt_add_medium(s, &(pt_medium_desc){
        .sigma_s = { .06f, .06f, .06f }, .g = .65f }));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .direction = { .3f, -1, .45f }, .color = { 90, 80, 64 },
        .radius_deg = .4f });
    pt_add_light(s, &(pt_light_desc){ .color = { .15f, .22f, .35f } });
    look(d, pt_v3(0, 1.6f, 6.4f), pt_v3(0, 1.75f, 0), 42);
}

static const struct { const char *name; void (*build)(pt_scene *s, pt_render_desc *d); pt_integrator integrator; float stops; } pictures[] = {
    { "smoke", smoke, PT_INTEGRATOR_MIXTURE, 0 }, { "fire", fire, PT_INTEGRATOR_MIXTURE, 0 }, { "air", air, PT_INTEGRATOR_NEE, -1 },
    { "juice", juice, PT_INTEGRATOR_MIXTURE, 0 }, { "rays", rays, PT_INTEGRATOR_NEE, -1.8f } };

int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "smoke, fire, the air at sunset, juice, god rays");
    size_t i;
    for (i = 0; i < sizeof pictures / sizeof *pictures; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = { .width = set.quick ? 128 : 512, .threads = 2, .max_depth = 512, .integrator = pictures[i].integrator };
        char name[64];
        float *picture;
        d.height = d.width;
        pictures[i].build(s, &d);
        if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); return 1; }
        printf("%s\n", pictures[i].name);
        picture = until_clean(s, d, .05, set.quick ? 32 : 512);
        snprintf(name, sizeof name, "figure_volumes_%s", pictures[i].name);
        write_panels(&set, name, &picture, 1, 1, d.width, d.height, pictures[i].stops);
        free(picture);
        pt_scene_destroy(s);
    }
    return 0;
}
