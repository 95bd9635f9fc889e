/* The caustic of examples/17_caustic.c: how much do densities of the user's own help? One aims at the ball, by its solid angle,
   as "A Simplified Path Tracing Architecture" suggests; the example's own at where light was seen to leave the glass.
   relMSE in the ball's shadow, where its caustic is, and over the picture; efficiency, 1 / (relMSE x processor seconds),
   relative to none. Writes out/caustic_*.png.
   cc -O2 tests/bench/figure_caustic.c -o out/figure_caustic -lm -lpthread && out/figure_caustic [--quick | SAMPLES] */
#define main example
#include "../../examples/17_caustic.c"
#undef main
#include "efficiency.h"

enum { W = 120, H = 90, REFERENCE = 6400, RENDERS = 3 };

static int ball_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    (void)user;
    *wi = aim(x->p, ball, ball_radius, u[0], u[1]);
    return 1;
}
static float ball_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    float size = cone(x->p, ball, ball_radius);
    (void)user;
    return dot(unit(madd(x->p, -1, ball)), wi) > 1 - size ? 1 / (6.2831853f * size) : 0.0f;
}
static float ball_importance(void *user, const pt_vertex *x) {         /* on the table, not too far from it */
    (void)user;
    return x->p.y < .01f && fabsf(x->p.x) < 1.5f && fabsf(x->p.z) < 1.5f ? 1.0f : 0.0f;
}

typedef enum aims { NOTHING, BALL, LEAVES } aims;
static pt_scene *scene(aims at, float weight) {
    pt_scene *s = pt_scene_create(NULL);
    pt_density_desc d;
    pt_rng rng;
    int i;
    memset(&d, 0, sizeof d);
    build(s);
    d.weight = weight;
    d.sample = at == BALL ? ball_sample : sample;
    d.pdf = at == BALL ? ball_pdf : pdf;
    d.importance = at == BALL ? ball_importance : importance;
    if (at != NOTHING) pt_add_density(s, &d);
    if (pt_scene_commit(s) != PT_OK) { printf("%s\n", pt_scene_error(s)); exit(1); }
    memset(table, 0, sizeof table);
    pt_rng_seed(&rng, 1, 1);
    for (i = 0; at == LEAVES && i < 300000; i++) shine(s, &rng);
    return s;
}
/* Does the ball hide the lamp from what the pixel's middle shows of the table? */
static int in_shadow(const pt_camera *c, int x, int y) {
    float h = tanf(c->vfov_deg * 3.14159265f / 360), t;
    pt_vec3 f = unit(madd(c->eye, -1, c->target)), right = unit(pt_v3(-f.z, 0, f.x)), d, p;
    pt_vec3 up = pt_v3(right.y * f.z - right.z * f.y, right.z * f.x - right.x * f.z, right.x * f.y - right.y * f.x);
    d = madd(right, h * (2 * ((float)x + .5f) / W - 1) * W / H, madd(up, h * (1 - 2 * ((float)y + .5f) / H), f));
    t = -c->eye.y / d.y;
    p = madd(d, t, c->eye);
    if (!(t > 0) || dot(unit(madd(p, -1, ball)), unit(madd(p, -1, lamp))) <= 1 - cone(p, ball, ball_radius)) return 0;
    return dot(unit(madd(c->eye, -1, ball)), unit(d)) <= 1 - cone(c->eye, ball, ball_radius);    /* not behind the ball */
}
static double error_where(const float *x, const float *r, const char *mask) {
    double sum = 0;
    int i, n = 0;
    for (i = 0; i < W * H; i++)
        if (!mask || mask[i]) { sum += relative_error(x + 3 * i, r + 3 * i, 3); n++; }
    return sum / n;
}
int main(int argc, char **argv) {
    static const struct { const char *name; aims at; float weight; } row[] = {
        { "none", NOTHING, 0 }, { "the ball", BALL, .1f }, { "the ball", BALL, .25f }, { "the ball", BALL, .5f },
        { "the ball", BALL, .75f }, { "where light leaves", LEAVES, .1f }, { "where light leaves", LEAVES, .25f },
        { "where light leaves", LEAVES, .5f }, { "where light leaves", LEAVES, .75f } };
    static char mask[W * H];
    double none[2] = { 0, 0 };
    int i, k, n = 0;
    float *r;
    pt_scene *s;
    pt_render_desc d;
    (void)efficiency_of;
    memset(&d, 0, sizeof d);
    d.width = W; d.height = H; d.max_depth = 8; d.threads = 2;
    d.spp = argc > 1 ? strcmp(argv[1], "--quick") ? atoi(argv[1]) : 16 : 64;
    d.camera.eye = pt_v3(.5f, 1.5f, 2.4f); d.camera.target = pt_v3(.2f, .22f, 0); d.camera.vfov_deg = 30;
    s = scene(LEAVES, .5f);
    if (!(r = reference("caustic", s, &d, REFERENCE))) return 1;
    pt_scene_destroy(s);
    pt_write_png("out/caustic_reference.png", r, W, H, NULL);
    for (i = 0; i < W * H; i++) n += mask[i] = (char)in_shadow(&d.camera, i % W, i / W);
    printf("%d x %d pixels, %d of them in the ball's shadow, %d samples, mean of %d renders\n"
           "%-18s  weight  seconds  relMSE in it  efficiency  relMSE of all  efficiency\n", W, H, n, d.spp, RENDERS, "aimed at");
    for (i = 0; i < (int)(sizeof row / sizeof *row); i++) {
        double error[2] = { 0, 0 }, seconds = 0, once, better[2];
        s = scene(row[i].at, row[i].weight);
        for (k = 0; k < RENDERS; k++) {
            char path[64];
            float *x;
            d.seed = (unsigned)k + 1;
            x = render_copy(s, &d, NULL, &once);
            seconds += once / RENDERS;
            error[0] += error_where(x, r, mask) / RENDERS;
            error[1] += error_where(x, r, NULL) / RENDERS;
            snprintf(path, sizeof path, "out/caustic_%d.png", i);
            if (k == 0) pt_write_png(path, x, W, H, NULL);
            free(x);
        }
        for (k = 0; k < 2; k++) {
            if (i == 0) none[k] = error[k] * seconds;
            better[k] = none[k] / (error[k] * seconds);
        }
        printf("%-18s  %6.2f  %7.2f  %12.2e  %8.1f x  %13.2e  %8.1f x\n", row[i].name, (double)row[i].weight, seconds, error[0],
               better[0], error[1], better[1]);
        fflush(stdout);
        pt_scene_destroy(s);
    }
    free(r);
    return 0;
}
