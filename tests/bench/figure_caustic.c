/* A glass ball throws the light of a small lamp on a table. How much do densities of the user's own help there? One aims at
   the ball's solid angle, as "A Simplified Path Tracing Architecture" suggests; one at where light was seen to leave the
   glass, for which a few thousand rays go from the lamp through it beforehand. Efficiency, 1 / (relMSE x processor seconds),
   inside the caustic and over the picture, for several weights, relative to none. Writes out/caustic_*.png.
   cc -O2 tests/bench/figure_caustic.c -o out/figure_caustic -lm -lpthread && out/figure_caustic [--spp N] [--renders N] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include <math.h>

enum { W = 160, H = 120, REFERENCE = 8192 };
static const pt_vec3 ball = { 0, .5f, 0 }, lamp = { -1.1f, 2.4f, .6f };
static const float radius = .25f, lamp_radius = .04f;

static pt_vec3 to(pt_vec3 a, pt_vec3 b) { return pt_v3(b.x - a.x, b.y - a.y, b.z - a.z); }
static pt_vec3 along(pt_vec3 p, float t, pt_vec3 d) { return pt_v3(p.x + t * d.x, p.y + t * d.y, p.z + t * d.z); }
static float dot(pt_vec3 a, pt_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* ---- a cone from x that a sphere fills */

static int cone_sample(pt_vec3 x, pt_vec3 center, float r, const float u[2], pt_vec3 *wi) {
    pt_vec3 d = to(x, center), t, b;
    float d2 = dot(d, d), s2 = r * r / d2, h, s, phi = 6.2831853f * u[1];
    if (s2 >= 1) return 0;
    h = u[0] * s2 / (1 + sqrtf(1 - s2));                  /* 1 - cos */
    s = sqrtf(h * (2 - h));
    d = along(pt_v3(0, 0, 0), 1 / sqrtf(d2), d);
    t = fabsf(d.x) < .6f ? pt_v3(0, d.z, -d.y) : pt_v3(-d.z, 0, d.x);
    t = along(pt_v3(0, 0, 0), 1 / sqrtf(dot(t, t)), t);
    b = pt_v3(d.y * t.z - d.z * t.y, d.z * t.x - d.x * t.z, d.x * t.y - d.y * t.x);
    *wi = along(along(along(pt_v3(0, 0, 0), 1 - h, d), s * cosf(phi), t), s * sinf(phi), b);
    return 1;
}
static float cone_pdf(pt_vec3 x, pt_vec3 center, float r, pt_vec3 wi) {
    pt_vec3 d = to(x, center);
    float d2 = dot(d, d), s2 = r * r / d2, c = dot(d, wi) / sqrtf(d2), root;
    if (s2 >= 1) return 0;
    root = sqrtf(1 - s2);
    return c >= root ? (1 + root) / (6.2831853f * s2) : 0.0f;
}
static int ball_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) { (void)user; return cone_sample(x->p, ball, radius, u, wi); }
static float ball_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; return cone_pdf(x->p, ball, radius, wi); }
static float near_ball(void *user, const pt_vertex *x) {  /* on the table, as far as the caustic may be */
    (void)user;
    return x->p.y < .01f && x->p.x > -.4f && x->p.x < 1.2f && fabsf(x->p.z) < .9f ? 1.0f : 0.0f;
}

/* ---- where light leaves the glass: up to LEAVES points for each of CELLS x CELLS fields of the table */

enum { CELLS = 64, LEAVES = 12 };
static const float field = 2.4f / CELLS;
static float leaf_radius = .02f;
typedef struct leaves { int seen, count; pt_vec3 p[LEAVES]; } leaves;
static leaves table[CELLS][CELLS];

static leaves *leaves_at(pt_vec3 p) {
    int x = (int)((p.x + 1.2f) / field), z = (int)((p.z + 1.2f) / field);
    return p.y < .01f && p.x > -1.2f && p.z > -1.2f && x < CELLS && z < CELLS ? &table[z][x] : NULL;
}
static int leaves_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    const leaves *l = leaves_at(x->p);
    float v[2], n;
    int i;
    (void)user;
    if (!l || !l->count) return 0;
    n = u[0] * (float)l->count;
    i = (int)n < l->count ? (int)n : l->count - 1;
    v[0] = n - (float)i; v[1] = u[1];
    return cone_sample(x->p, l->p[i], leaf_radius, v, wi);
}
static float leaves_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const leaves *l = leaves_at(x->p);
    float sum = 0;
    int i;
    (void)user;
    for (i = 0; l && i < l->count; i++) sum += cone_pdf(x->p, l->p[i], leaf_radius, wi);
    return l && l->count ? sum / (float)l->count : 0.0f;
}
static float leaves_here(void *user, const pt_vertex *x) { const leaves *l = leaves_at(x->p); (void)user; return l && l->count ? 1.0f : 0.0f; }

/* Snell; 0 where all is reflected. n is the normal on the side that d comes from. */
static int refracted(pt_vec3 d, pt_vec3 n, float eta, pt_vec3 *out) {
    float c = -dot(d, n), k = 1 - eta * eta * (1 - c * c);
    if (k < 0) return 0;
    *out = along(along(pt_v3(0, 0, 0), eta, d), eta * c - sqrtf(k), n);
    return 1;
}
static void shine(const pt_scene *s, int rays) {          /* from the lamp through the glass to the table */
    pt_rng rng;
    pt_rng_seed(&rng, 1, 1);
    while (rays--) {
        float u[2], c[3];
        pt_ray ray;
        pt_vertex x;
        pt_vec3 last = ball;
        int k, inside = 0;
        for (k = 0; k < 3; k++) c[k] = pt_rng_float(&rng) * 2 - 1;
        u[0] = pt_rng_float(&rng); u[1] = pt_rng_float(&rng);
        if (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] > 1) continue;
        memset(&ray, 0, sizeof ray);
        ray.org = along(lamp, lamp_radius, pt_v3(c[0], c[1], c[2]));
        if (!cone_sample(ray.org, ball, radius, u, &ray.dir)) continue;
        ray.tmin = 2 * lamp_radius;                       /* out of the lamp */
        for (k = 0; k < 4 && pt_intersect(s, &ray, &x); k++) {
            leaves *l = leaves_at(x.p);
            if (l) {
                int at = l->seen++;                       /* any LEAVES of all that come, with equal odds */
                if (k < 2) break;
                if (at >= LEAVES) at = (int)(pt_rng_float(&rng) * (float)l->seen);
                if (at < LEAVES) l->p[at] = last;
                if (l->count < LEAVES) l->count++;
                break;
            }
            if (!refracted(ray.dir, inside ? to(x.ng, pt_v3(0, 0, 0)) : x.ng, inside ? 1.5f : 1 / 1.5f, &ray.dir)) break;
            inside = !inside;
            last = ray.org = x.p;
            ray.tmin = 1e-4f;
        }
    }
}

/* ---- the scene, and what is measured */

typedef enum how { NONE, BALL, SHINE } how;
static pt_scene *scene(how kind, float weight) {
    pt_scene *s = pt_scene_create(NULL);
    pt_density_desc d;
    memset(&d, 0, sizeof d);
    pt_add_quad(s, pt_v3(-40, 0, -40), pt_v3(0, 0, 80), pt_v3(80, 0, 0), pt_add_material(s, &(pt_material_desc){ .color = {.6f, .55f, .5f} }));
    pt_add_sphere(s, ball, radius, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.5f }));
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_POINT, .position = lamp, .radius = lamp_radius, .color = {60, 60, 60} });
    pt_add_light(s, &(pt_light_desc){ .color = {.02f, .025f, .03f} });
    d.weight = weight;
    if (kind == BALL) { d.sample = ball_sample; d.pdf = ball_pdf; d.importance = near_ball; }
    if (kind == SHINE) { d.sample = leaves_sample; d.pdf = leaves_pdf; d.importance = leaves_here; }
    if (kind != NONE) pt_add_density(s, &d);
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); exit(1); }
    memset(table, 0, sizeof table);
    if (kind == SHINE) shine(s, 200000);
    return s;
}
static double error_where(const float *x, const float *r, const char *mask) {
    double sum = 0;
    int i, k, n = 0;
    for (i = 0; i < W * H; i++) {
        if (mask && !mask[i]) continue;
        n++;
        for (k = 0; k < 3; k++) {
            double d = (double)x[3 * i + k] - (double)r[3 * i + k];
            sum += d * d / ((double)r[3 * i + k] * (double)r[3 * i + k] + 0.01) / 3;
        }
    }
    return sum / n;
}
int main(int argc, char **argv) {
    static const struct { const char *name; how kind; float weight; } row[] = {
        { "none", NONE, 0 }, { "the ball", BALL, .1f }, { "the ball", BALL, .25f }, { "the ball", BALL, .5f }, { "the ball", BALL, .75f },
        { "where light leaves", SHINE, .1f }, { "where light leaves", SHINE, .25f }, { "where light leaves", SHINE, .5f }, { "where light leaves", SHINE, .75f } };
    static char mask[W * H];
    double first[2] = { 0, 0 };
    int spp = 256, renders = 2, i, k, n = 0;
    float *r;
    pt_scene *s;
    pt_render_desc d;
    for (i = 1; i + 1 < argc; i += 2) { if (!strcmp(argv[i], "--spp")) spp = atoi(argv[i + 1]); else if (!strcmp(argv[i], "--renders")) renders = atoi(argv[i + 1]); }
    memset(&d, 0, sizeof d);
    d.width = W; d.height = H; d.spp = spp; d.max_depth = 8; d.threads = 2;
    d.camera.eye = pt_v3(.5f, 1.6f, 2.6f); d.camera.target = pt_v3(.2f, .2f, 0); d.camera.vfov_deg = 32;
    s = scene(SHINE, .5f);
    r = reference("caustic", s, &d, REFERENCE);
    pt_scene_destroy(s);
    pt_write_png("out/caustic_reference.png", r, W, H, NULL);
    for (i = 0; i < W * H; i++) n += mask[i] = r[3 * i + 1] > 1.3f * r[3 * (W * H - W / 2) + 1] && i > W * H / 3;   /* brighter than the front of the table */
    printf("%d x %d pixels, %d of them in the caustic, %d samples: relMSE and efficiency\n%-18s weight   seconds   inside             over all\n", W, H, n, spp, "density");
    for (i = 0; i < (int)(sizeof row / sizeof *row); i++) {
        double error[2] = { 0, 0 }, seconds = 0, once;
        char path[64];
        s = scene(row[i].kind, row[i].weight);
        for (k = 0; k < renders; k++) {
            float *x;
            d.seed = (unsigned)k + 1;
            x = render_copy(s, &d, NULL, &once);
            seconds += once / renders;
            error[0] += error_where(x, r, mask) / renders;
            error[1] += error_where(x, r, NULL) / renders;
            snprintf(path, sizeof path, "out/caustic_%d.png", i);
            if (k == 0) pt_write_png(path, x, W, H, NULL);
            free(x);
        }
        for (k = 0; k < 2; k++) { error[k] = 1 / (error[k] * seconds); if (i == 0) first[k] = error[k]; }
        printf("%-18s %5.2f  %8.2f   %.2e %6.1f x  %.2e %6.1f x\n", row[i].name, row[i].weight, seconds, 1 / (error[0] * seconds), error[0] / first[0],
               1 / (error[1] * seconds), error[1] / first[1]);
        fflush(stdout);
        pt_scene_destroy(s);
    }
    free(r);
    return 0;
}
