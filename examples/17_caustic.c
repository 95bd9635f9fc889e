/* A density of one's own. From the table, a path would have to guess where in the glass the small lamp shows. So the lamp shines
   through the glass beforehand, and each field of the table remembers some points where light left the glass towards it. A
   path that stands there aims at those points half of the time. It need not be exact: what is aimed at too seldom is noisy,
   never wrong.
   cc -O2 17_caustic.c -o 17_caustic -lm -lpthread && ./17_caustic [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

enum { CELLS = 96, POINTS = 12 };                         /* of the table, 3 m wide; remembered in each */
static const pt_vec3 ball = {0, .5f, 0}, lamp = {-1.1f, 2.4f, .6f};
static const float ball_radius = .25f, lamp_radius = .04f, spot = .02f;
typedef struct cell { int seen; pt_vec3 p[POINTS]; } cell;
static cell table[CELLS][CELLS];

static pt_vec3 madd(pt_vec3 d, float t, pt_vec3 p) { return pt_v3(p.x + t * d.x, p.y + t * d.y, p.z + t * d.z); }
static float dot(pt_vec3 a, pt_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static pt_vec3 unit(pt_vec3 v) { return madd(v, 1 / sqrtf(dot(v, v)), pt_v3(0, 0, 0)); }

/* Directions from x to a sphere: a cone. 1 - cos of its half angle; and one of them. */
static float cone(pt_vec3 x, pt_vec3 center, float radius) {
    pt_vec3 d = madd(x, -1, center);
    return 1 - sqrtf(fmaxf(1 - radius * radius / dot(d, d), 0));
}
static pt_vec3 aim(pt_vec3 x, pt_vec3 center, float radius, float u, float v) {
    pt_vec3 d = unit(madd(x, -1, center)), t, b;
    float h = u * cone(x, center, radius), s = sqrtf(h * (2 - h)), phi = 6.2831853f * v;
    t = unit(fabsf(d.x) < .6f ? pt_v3(0, d.z, -d.y) : pt_v3(-d.z, 0, d.x));
    b = pt_v3(d.y * t.z - d.z * t.y, d.z * t.x - d.x * t.z, d.x * t.y - d.y * t.x);
    return unit(madd(t, s * cosf(phi), madd(b, s * sinf(phi), madd(d, -h, d))));
}

/* The density: sample draws, pdf tells how likely, importance where there is anything to draw. */
static cell *cell_at(pt_vec3 p) {
    int x = (int)((p.x + 1.5f) / 3 * CELLS), z = (int)((p.z + 1.5f) / 3 * CELLS);
    return p.y < .01f && p.x >= -1.5f && p.z >= -1.5f && x < CELLS && z < CELLS ? &table[z][x] : NULL;
}
static int count(const cell *c) { return !c ? 0 : c->seen < POINTS ? c->seen : POINTS; }
static int sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    const cell *c = cell_at(x->p);
    int n = count(c), i = (int)(u[0] * (float)n);
    (void)user;
    if (n) *wi = aim(x->p, c->p[i], spot, u[0] * (float)n - (float)i, u[1]);
    return n > 0;
}
static float pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const cell *c = cell_at(x->p);
    float sum = 0;
    (void)user;
    for (int i = 0; i < count(c); i++) {
        float size = cone(x->p, c->p[i], spot);
        if (dot(unit(madd(x->p, -1, c->p[i])), wi) > 1 - size) sum += 1 / (6.2831853f * size * (float)count(c));
    }
    return sum;
}
static float importance(void *user, const pt_vertex *x) { (void)user; return count(cell_at(x->p)) > 0; }

/* One ray from the lamp, which the glass reflects or refracts at random, until it meets the table. */
static void shine(const pt_scene *s, pt_rng *rng) {
    pt_vec3 last = ball;
    pt_vertex x;
    pt_ray ray = { .tmin = 2 * lamp_radius };             /* out of the lamp */
    float u[5];
    for (int i = 0; i < 5; i++) u[i] = pt_rng_float(rng);
    ray.org = madd(pt_v3(2 * u[2] - 1, 2 * u[3] - 1, 2 * u[4] - 1), .6f * lamp_radius, lamp);
    ray.dir = aim(ray.org, ball, ball_radius, u[0], u[1]);
    for (int k = 0; k < 5 && pt_intersect(s, &ray, &x); k++) {
        cell *c = cell_at(x.p);
        if (c) {                                          /* keep any POINTS of all that come, with equal odds */
            int i = c->seen++;
            if (i >= POINTS) i = (int)(pt_rng_float(rng) * (float)c->seen);
            if (i < POINTS) c->p[i] = last;
            return;
        }
        float side = dot(ray.dir, x.ng) < 0 ? 1.0f : -1.0f, eta = side > 0 ? 1 / 1.5f : 1.5f;
        float cosine = -side * dot(ray.dir, x.ng), root = 1 - eta * eta * (1 - cosine * cosine);
        if (root < 0 || pt_rng_float(rng) < .1f) ray.dir = madd(x.ng, 2 * side * cosine, ray.dir);
        else ray.dir = madd(x.ng, side * (eta * cosine - sqrtf(root)), madd(ray.dir, eta, pt_v3(0, 0, 0)));
        ray.org = last = x.p;
        ray.tmin = 1e-4f;
    }
}

static void build(pt_scene *s) {
    pt_material wood  = pt_add_material(s, &(pt_material_desc){ .color = {.6f, .52f, .45f} });
    pt_material glass = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.5f });
    pt_add_quad(s, pt_v3(-40, 0, -40), pt_v3(0, 0, 80), pt_v3(80, 0, 0), wood);
    pt_add_sphere(s, ball, ball_radius, glass);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_POINT, .position = lamp, .radius = lamp_radius,
        .color = {190, 180, 160} });
    pt_add_light(s, &(pt_light_desc){ .color = {.08f, .10f, .13f} });
}
int main(int argc, char **argv) {
    pt_scene *s = pt_scene_create(NULL);
    pt_rng rng;
    build(s);
    pt_add_density(s, &(pt_density_desc){ .weight = .5f, .sample = sample, .pdf = pdf, .importance = importance });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }
    pt_rng_seed(&rng, 1, 1);
    for (int i = 0; i < 300000; i++) shine(s, &rng);

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 480, .height = 360, .spp = 128, .max_depth = 8,
        .camera = { .eye = {.5f, 1.5f, 2.4f}, .target = {.2f, .22f, 0}, .vfov_deg = 30 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "caustic.png", pt_render_pixels(r), 480, 360, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
