/* >>camera: rays against the closed forms of a pinhole and of a thin lens, and pictures that show which way is up. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

static pt_camera camera(pt_vec3 eye, pt_vec3 target, float vfov_deg) {
    pt_camera c;
    memset(&c, 0, sizeof c);
    c.eye = eye; c.target = target; c.vfov_deg = vfov_deg;
    return c;
}
/* A white ray at the opening of the shutter, whatever it weighs. */
static float lens_ray(const pti_lens *l, float x, float y, float u, float v, pt_vec3 *org, pt_vec3 *dir) {
    pti_lens_point p;
    pt_ray ray;
    float weight;
    memset(&p, 0, sizeof p);
    memset(&ray, 0, sizeof ray);
    p.x = x; p.y = y; p.u = u; p.v = v;
    weight = pti_lens_ray(l, &p, &ray);
    *org = ray.org; *dir = ray.dir;
    return weight;
}
static pt_vec3 through(const pt_camera *c, int width, int height, double x, double y) {
    pti_lens l = pti_lens_make(c, width, height);
    pt_vec3 org, dir;
    lens_ray(&l, (float)x, (float)y, 0.5f, 0.5f, &org, &dir);
    CHECK_NEAR(pti_length(dir), 1, 1e-6);
    CHECK(org.x == c->eye.x && org.y == c->eye.y && org.z == c->eye.z);
    return dir;
}
static void check_direction(pt_vec3 d, double x, double y, double z) {
    double l = sqrt(x * x + y * y + z * z);
    CHECK_NEAR(d.x, x / l, 1e-6); CHECK_NEAR(d.y, y / l, 1e-6); CHECK_NEAR(d.z, z / l, 1e-6);
}

static void middle_and_corners(void) {
    static const float fov[] = { 1, 20, 40, 90, 150, 179 };
    static const int size[][2] = { { 100, 100 }, { 200, 100 }, { 30, 90 }, { 1, 1 } };
    int i, j;
    for (i = 0; i < 6; i++) for (j = 0; j < 4; j++) {
        pt_camera c = camera(pt_v3(1, 2, 3), pt_v3(1, 2, -7), fov[i]);
        double h = tan(fov[i] * STATS_PI / 360), w = h * size[j][0] / size[j][1];
        test_case("%g degrees, %d x %d", (double)fov[i], size[j][0], size[j][1]);
        check_direction(through(&c, size[j][0], size[j][1], 0.5, 0.5), 0, 0, -1);
        check_direction(through(&c, size[j][0], size[j][1], 0, 0), -w, h, -1);        /* top left */
        check_direction(through(&c, size[j][0], size[j][1], 1, 0), w, h, -1);
        check_direction(through(&c, size[j][0], size[j][1], 0, 1), -w, -h, -1);
        check_direction(through(&c, size[j][0], size[j][1], 1, 1), w, -h, -1);
    }
}
static void defaults(void) {
    pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, 0), 0);         /* no target: along -z; 40 degrees */
    check_direction(through(&c, 9, 9, 0.5, 0), 0, tan(20 * STATS_PI / 180), -1);
}
static void up_vectors(void) {
    pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -5), 90);
    c.up = pt_v3(3, 0, 0);                                           /* the head lies on its left side */
    check_direction(through(&c, 9, 9, 0.5, 0), 1, 0, -1);
    check_direction(through(&c, 9, 9, 1, 0.5), 0, -1, -1);
    c.up = pt_v3(0, -1, 0);
    check_direction(through(&c, 9, 9, 0.5, 0), 0, -1, -1);
    c = camera(pt_v3(0, 0, 0), pt_v3(5, 0, 0), 90);                  /* to the east: north is left */
    check_direction(through(&c, 9, 9, 0, 0.5), 1, 0, -1);
    c = camera(pt_v3(0, 0, 0), pt_v3(0, -3, -4), 90);                /* up need not be perpendicular */
    check_direction(through(&c, 9, 9, 0.5, 0), 0, 0.2, -1.4);
}
static void straight_down_and_up(void) {
    static const float side[] = { -1, 1 };
    int i, k;
    for (i = 0; i < 2; i++) for (k = 0; k < 3; k++) {
        pt_camera c = camera(pt_v3(4, 5, 6), pt_v3(4, 5 + 3 * side[i], 6 + (k == 1 ? 1e-7f : 0)), 90);
        pt_vec3 right, up;
        if (k == 2) c.up = pt_v3(0, -side[i], 0);
        right = pti_sub(through(&c, 9, 9, 1, 0.5), through(&c, 9, 9, 0, 0.5));
        up = pti_sub(through(&c, 9, 9, 0.5, 0), through(&c, 9, 9, 0.5, 1));
        check_direction(through(&c, 9, 9, 0.5, 0.5), 0, side[i], 0);
        CHECK_NEAR(pti_dot(right, up), 0, 1e-5);
        CHECK(pti_dot(pti_cross(right, up), pt_v3(0, side[i], 0)) < -1.9f);            /* not mirrored, not flat */
    }
}
static void no_sharp_turns(void) {                       /* all nearly vertical views are square and not mirrored */
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 3, 3);
    for (i = 0; i < 10000; i++) {
        float e = powf(10, -9 * pt_rng_float(&rng));
        pt_camera c = camera(pt_v3(0, 0, 0), pti_madd(random_direction(&rng), e, pt_v3(0, i & 1 ? 1.0f : -1.0f, 0)), 60);
        pti_lens l = pti_lens_make(&c, 4, 3);
        CHECK(fabsf(pti_dot(l.right, l.up)) < 1e-5f && fabsf(pti_dot(l.right, l.forward)) < 1e-5f && fabsf(pti_dot(l.up, l.forward)) < 1e-5f);
        CHECK(fabsf(pti_length(l.right) - 1) < 1e-5f && fabsf(pti_length(l.up) - 1) < 1e-5f);
        CHECK(pti_dot(pti_cross(l.right, l.up), l.forward) < -0.999f);
    }
}

/* Four lamps, of the radiances 1, 2, 4 and 8, up, down, left and right of where the camera looks. */
static void the_picture_is_upright(void) {
    static float rgb[32 * 32 * 3];
    static const float place[4][2] = { { 0, 1 }, { 0, -1 }, { -1, 0 }, { 1, 0 } };
    static const int pixel[4][2] = { { 16, 8 }, { 16, 24 }, { 8, 16 }, { 24, 16 } };
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 10), pt_v3(0, 0, 0), 22.62f, 32, 1);          /* 4 units high */
    int i;
    for (i = 0; i < 4; i++) pt_add_sphere(s, pt_v3(place[i][0], place[i][1], 0), 0.4f, lamp(s, (float)(1 << i), 0));
    if (commit(s) && render(s, &d, rgb, NULL)) {
        for (i = 0; i < 4; i++) CHECK_NEAR(rgb[3 * (pixel[i][1] * 32 + pixel[i][0])], 1 << i, 1e-6);
        CHECK(rgb[3 * (16 * 32 + 16)] == 0 && rgb[0] == 0);
    }
    pt_scene_destroy(s);
}

static void lenses_focus(void) {
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 5, 5);
    for (k = 0; k < 50; k++) {
        pt_camera c = camera(random_direction(&rng), pti_scale(random_direction(&rng), 5), 50);
        double focus, farthest = 0;
        float px = pt_rng_float(&rng), py = pt_rng_float(&rng);
        pt_vec3 pinhole, forward = pti_normalize(pti_sub(c.target, c.eye)), meet;
        pti_lens l;
        c.focus = k & 1 ? 1 + 4 * pt_rng_float(&rng) : 0;
        focus = c.focus > 0 ? (double)c.focus : (double)pti_length(pti_sub(c.target, c.eye));
        pinhole = through(&c, 3, 2, px, py);
        c.aperture = 0.3f;
        l = pti_lens_make(&c, 3, 2);
        meet = pti_madd(pinhole, (float)(focus / pti_dot(pinhole, forward)), c.eye);
        for (i = 0; i < 200; i++) {
            pt_vec3 org, dir, off;
            lens_ray(&l, px, py, pt_rng_float(&rng), pt_rng_float(&rng), &org, &dir);
            off = pti_sub(org, c.eye);
            farthest = fmax(farthest, (double)pti_length(off));
            CHECK_NEAR(pti_dot(off, forward), 0, 1e-6);                  /* the lens is flat */
            CHECK_NEAR(pti_length(dir), 1, 1e-6);
            off = pti_sub(meet, org);
            CHECK_NEAR(pti_length(pti_cross(off, dir)), 0, 1e-5);         /* all rays meet there */
            CHECK(pti_dot(off, dir) > 0);
        }
        CHECK(farthest <= 0.3 * 1.00001 && farthest > 0.3 * 0.9);
    }
}
/* A point at distance z is smeared over a disk of 2 aperture |z - focus| / z on the plane of focus. */
static void blur_diameter(void) {
    static const float distance[] = { 1, 2.5f, 4, 8, 100 };
    int i, k;
    for (k = 0; k < 5; k++) {
        pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -4), 40);
        double z = (double)distance[k], most = 0, want = 2 * 0.25 * fabs(z - 4) / z, r2 = 0;
        pti_lens l;
        pt_rng rng;
        pt_rng_seed(&rng, 6, 6);
        c.aperture = 0.25f;
        l = pti_lens_make(&c, 1, 1);
        for (i = 0; i < 20000; i++) {                    /* the point on the axis, seen through all of the lens */
            pt_vec3 org, dir;
            double x, y, t = z, px, py;
            lens_ray(&l, 0.5f, 0.5f, pt_rng_float(&rng), pt_rng_float(&rng), &org, &dir);
            x = org.x; y = org.y;                        /* from there through (0, 0, -z) to the plane of focus */
            px = x + (0 - x) * 4 / t; py = y + (0 - y) * 4 / t;
            r2 += px * px + py * py;
            most = fmax(most, 2 * sqrt(px * px + py * py));
        }
        test_case("distance %g", z);
        CHECK_NEAR(most, want, 0.003 * want + 1e-6);
        CHECK_NEAR(r2 / 20000, want * want / 8, 0.02 * want * want / 8 + 1e-9);        /* a full disk */
    }
}
/* And in a picture: a lamp out of focus (on the plane of focus it has the radius `own`) covers the disk that the formula
   says, widened by its own disk, and keeps its light. */
static void blur_in_a_picture(void) {
    static float rgb[64 * 64 * 3];
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, -4), 20, 64, 256);
    double sum = 0, r2 = 0, cx = 0, cy = 0, size = 2 * 4 * tan(10 * STATS_PI / 180) / 64, want = 2 * 0.2 * (8 - 4) / 8, own = 0.05;
    int x, y;
    pt_add_sphere(s, pt_v3(0, 0, -8), 0.1f, lamp(s, 1000, 0));
    d.camera.aperture = 0.2f; d.camera.focus = 4;
    if (commit(s) && render(s, &d, rgb, NULL)) {
        for (y = 0; y < 64; y++) for (x = 0; x < 64; x++) {
            double v = rgb[3 * (y * 64 + x)], dx = (x - 31.5) * size, dy = (y - 31.5) * size;
            sum += v; cx += v * dx; cy += v * dy; r2 += v * (dx * dx + dy * dy);
            if (sqrt(dx * dx + dy * dy) > want / 2 + own + size) CHECK(v == 0);
        }
        CHECK_NEAR(cx / sum, 0, 0.004); CHECK_NEAR(cy / sum, 0, 0.004);
        r2 = r2 / sum - own * own / 2 - size * size / 6;     /* second moments add up: without its own and the pixels' */
        CHECK_NEAR(sqrt(8 * r2), want, 0.02 * want);
        CHECK_NEAR(sum * size * size / 1000, STATS_PI * own * own, 0.03 * STATS_PI * own * own);
    }
    pt_scene_destroy(s);
}

/* The box filter: the samples of a pixel fill it, all of it, and nothing else. The sky tells where each ray went. */
typedef struct footprint { double x0, x1, y0, y1, sx, sy; int n, cells[16]; int width; } footprint;
static pt_vec3 seen(void *user, pt_vec3 d) {
    footprint *f = (footprint *)user;
    double x = (double)d.x / -(double)d.z, y = (double)d.y / -(double)d.z;      /* 90 degrees: [-1, 1] */
    if (f->n < 0 || !(d.z < 0)) return pt_v3(1, 1, 1);
    x = (x + 1) / 2 * f->width; y = (1 - y) / 2 * f->width;
    f->x0 = fmin(f->x0, x); f->x1 = fmax(f->x1, x); f->y0 = fmin(f->y0, y); f->y1 = fmax(f->y1, y);
    f->sx += x; f->sy += y;
    f->n++;
    if (x >= 0 && y >= 0) f->cells[((int)(x * 4) & 3) + 4 * ((int)(y * 4) & 3)]++;
    return pt_v3(1, 1, 1);
}
static void pixels_are_boxes(void) {
    static const pt_sampler kinds[] = { PT_SAMPLER_SOBOL, PT_SAMPLER_STRATIFIED, PT_SAMPLER_RANDOM };
    int k;
    for (k = 0; k < 3; k++) {
        footprint f;
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 90, 1, 16384);
        memset(&f, 0, sizeof f);
        f.n = -1;
        pt_add_light(s, &(pt_light_desc){ .radiance = seen, .user = &f });
        d.sampler = kinds[k];
        if (commit(s)) {
            stats_moments m;
            f.n = 0; f.width = 1; f.x0 = f.y0 = 9; f.x1 = f.y1 = -9;
            m = render_pixels(s, &d);
            test_case("sampler %d", k);
            CHECK(m.mean == 1 && f.n == 16384);
            CHECK(f.x0 > -1e-6 && f.x0 < 1e-3 && f.x1 < 1 + 1e-6 && f.x1 > 1 - 1e-3);
            CHECK(f.y0 > -1e-6 && f.y0 < 1e-3 && f.y1 < 1 + 1e-6 && f.y1 > 1 - 1e-3);
            CHECK_P(stats_z_test(f.sx / f.n, 0.5, sqrt(1 / 12.0), f.n));
            CHECK_P(stats_z_test(f.sy / f.n, 0.5, sqrt(1 / 12.0), f.n));
            CHECK_P(stats_chi2_uniform(f.cells, 16));
        }
        pt_scene_destroy(s);
    }
}
static void pixels_do_not_overlap(void) {                /* in the third pixel of the second row of eight */
    footprint f;
    pt_scene *s = pt_scene_create(NULL);
    pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 90);
    pti_lens l = pti_lens_make(&c, 8, 8);
    int i;
    pt_rng rng;
    pt_rng_seed(&rng, 8, 8);
    memset(&f, 0, sizeof f);
    f.width = 8; f.x0 = f.y0 = 9; f.x1 = f.y1 = -9;
    for (i = 0; i < 10000; i++) {
        pt_vec3 org, dir;
        lens_ray(&l, (2 + pt_rng_float(&rng)) / 8, (1 + pt_rng_float(&rng)) / 8, 0, 0, &org, &dir);
        seen(&f, dir);
    }
    CHECK_NEAR(f.x0, 2, 1e-3); CHECK_NEAR(f.x1, 3, 1e-3); CHECK_NEAR(f.y0, 1, 1e-3); CHECK_NEAR(f.y1, 2, 1e-3);
    pt_scene_destroy(s);
}

void test_camera(void) {
    RUN(middle_and_corners);
    RUN(defaults);
    RUN(up_vectors);
    RUN(straight_down_and_up);
    RUN(no_sharp_turns);
    RUN(the_picture_is_upright);
    RUN(lenses_focus);
    RUN(blur_diameter);
    RUN(blur_in_a_picture);
    RUN(pixels_are_boxes);
    RUN(pixels_do_not_overlap);
}
