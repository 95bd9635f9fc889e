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
        d.weights.bsdf = 1;                              /* so that no paths go ahead */
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

/* ---- projections ---- */

static pt_ray ray_at(const pt_camera *c, int width, int height, float x, float y, float shutter, float wavelength, float *weight) {
    pti_lens l = pti_lens_make(c, width, height);
    pti_lens_point p;
    pt_ray ray;
    memset(&p, 0, sizeof p);
    memset(&ray, 0, sizeof ray);
    p.x = x; p.y = y; p.u = 0.9f; p.v = 0.5f; p.shutter = shutter; p.wavelength = wavelength;
    *weight = pti_lens_ray(&l, &p, &ray);
    return ray;
}
static void orthographic(void) {
    pt_camera c = camera(pt_v3(1, 2, 3), pt_v3(1, 2, -7), 0);
    int i;
    float w;
    c.projection = PT_CAMERA_ORTHOGRAPHIC;
    for (i = 0; i < 2; i++) {
        double h = i ? 10 * tan(20 * STATS_PI / 180) : 1.5;          /* half; by default what 40 degrees see at the target */
        pt_ray r;
        c.height = i ? 0 : 3;
        r = ray_at(&c, 200, 100, 0, 0, 0, 0, &w);
        CHECK(w == 1);
        check_direction(r.dir, 0, 0, -1);
        CHECK_NEAR(r.org.x, 1 - 2 * h, 1e-5); CHECK_NEAR(r.org.y, 2 + h, 1e-5); CHECK_NEAR(r.org.z, 3, 1e-6);
        r = ray_at(&c, 200, 100, 0.75f, 0.5f, 0, 0, &w);
        CHECK_NEAR(r.org.x, 1 + h, 1e-5); CHECK_NEAR(r.org.y, 2, 1e-5);
    }
}
/* Where a map says that a direction lies, the picture of a camera that looks along -z has it. */
static void equirectangular_is_as_maps_are(void) {
    pt_rng rng;
    int i, wrong = 0;
    float w;
    pt_rng_seed(&rng, 11, 1);
    for (i = 0; i < 10000; i++) {
        pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 0);
        float x = pt_rng_float(&rng), y = pt_rng_float(&rng), u, v;
        pt_ray r;
        c.projection = PT_CAMERA_EQUIRECTANGULAR;
        r = ray_at(&c, 3, 2, x, y, 0, 0, &w);
        pti_direction_to_uv(r.dir, &u, &v);
        wrong += !(fabsf(u - x) < 1e-4f / pti_max(sinf(PTI_PI * y), 1e-3f) && fabsf(v - y) < 1e-5f) || w != 1;
    }
    CHECK_EQ_INT(wrong, 0);
}
static void fisheye_angles(void) {
    static const float fov[] = { 0, 90, 180, 360 };
    static const int size[][2] = { { 100, 100 }, { 200, 100 }, { 30, 90 } };
    pt_rng rng;
    int i, j, k;
    pt_rng_seed(&rng, 11, 2);
    for (i = 0; i < 4; i++) for (j = 0; j < 3; j++) for (k = 0; k < 500; k++) {
        pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -1), fov[i]);
        int least = size[j][0] < size[j][1] ? size[j][0] : size[j][1];
        float x = pt_rng_float(&rng), y = pt_rng_float(&rng), w;
        double px = (2 * (double)x - 1) * size[j][0] / least, py = (1 - 2 * (double)y) * size[j][1] / least, r = sqrt(px * px + py * py);
        double angle = r * (fov[i] > 0 ? (double)fov[i] : 180) * STATS_PI / 360;
        pt_ray ray;
        c.projection = PT_CAMERA_FISHEYE;
        ray = ray_at(&c, size[j][0], size[j][1], x, y, 0, 0, &w);
        if (fabs(r - 1) < 1e-6) continue;
        test_case("%g degrees, %d x %d", (double)fov[i], size[j][0], size[j][1]);
        if (!CHECK(w == (r < 1)) || r > 1) continue;
        check_direction(ray.dir, sin(angle) * px / r, sin(angle) * py / r, -cos(angle));
    }
}
static void fisheye_is_black_outside(void) {
    static float rgb[32 * 32 * 3];
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 360, 32, 4);
    pt_stats stats;
    int i, x, y, wrong = 0, lit = 0;
    d.camera.projection = PT_CAMERA_FISHEYE;
    sky(s, 1);
    if (commit(s) && render(s, &d, rgb, &stats)) {
        for (i = 0; i < 32 * 32; i++) {
            double r;
            x = i % 32; y = i / 32;
            r = hypot(x - 15.5, y - 15.5);
            wrong += (r < 15 && rgb[3 * i] != 1) || (r > 17 && rgb[3 * i] != 0);
            lit += (int)floor(4 * rgb[3 * i] + 0.5f);
        }
        CHECK_EQ_INT(wrong, 0);
        CHECK_EQ_INT(stats.rays, lit);                   /* no ray is traced outside */
        CHECK_EQ_INT(stats.discarded, 0);
    }
    pt_scene_destroy(s);
}
/* All rays of a point of the picture meet at the focal distance, from a lens that faces the way the projection says. */
static void all_projections_focus(void) {
    pt_rng rng;
    int kind, i, k;
    pt_rng_seed(&rng, 11, 3);
    for (kind = 0; kind <= PT_CAMERA_FISHEYE; kind++) for (k = 0; k < 20; k++) {
        pt_camera c = camera(random_direction(&rng), pti_scale(random_direction(&rng), 5), 0);
        float px = 0.3f + 0.4f * pt_rng_float(&rng), py = 0.3f + 0.4f * pt_rng_float(&rng), w;
        pt_ray pin;
        pt_vec3 meet, axis, forward = pti_normalize(pti_sub(c.target, c.eye)), sum = pt_v3(0, 0, 0);
        pti_lens l;
        double r2 = 0, off_plane = 0, apart = 0;
        c.projection = (pt_projection)kind;
        c.focus = 3; c.height = 2; c.blades = k & 1 ? 5 : 0;
        pin = ray_at(&c, 3, 2, px, py, 0, 0, &w);
        c.aperture = 0.2f;
        l = pti_lens_make(&c, 3, 2);
        axis = kind <= PT_CAMERA_ORTHOGRAPHIC ? forward : pin.dir;
        meet = pti_madd(pin.dir, 3 / pti_dot(pin.dir, axis), pin.org);
        test_case("projection %d", kind);
        for (i = 0; i < 400; i++) {
            pt_vec3 org, dir, off;
            lens_ray(&l, px, py, (i % 20 + 0.5f) / 20, (i / 20 + 0.5f) / 20, &org, &dir);
            off = pti_sub(org, pin.org);
            sum = pti_add(sum, off);
            r2 += (double)pti_dot(off, off);
            off_plane = fmax(off_plane, fabs((double)pti_dot(off, axis)));
            apart = fmax(apart, (double)pti_length(pti_cross(pti_sub(meet, org), dir)));
            CHECK(pti_dot(dir, axis) > 0.5f);
        }
        CHECK(off_plane < 1e-6);
        CHECK(apart < 1e-5);
        CHECK_NEAR(pti_length(sum) / 400, 0, 1e-4);
        r2 /= 400;
        CHECK_NEAR(r2 / 0.04, k & 1 ? (2 + cos(2 * STATS_PI / 5)) / 6 : 0.5, 0.005);
    }
}

/* ---- apertures ---- */

/* Every stratum's area is its share of the polygon's, and lies inside; the polygon is filled to the corners. */
static void polygons(void) {
    enum { N = 64 };
    int n, i, j;
    for (n = 3; n <= 16; n++) {
        float turn = n % 2 ? 0.3f : 0;
        double area = 0.5 * n * sin(2 * STATS_PI / n), inner = cos(STATS_PI / n), r2 = 0, out = 0, worst = 0, reach = 0, cx = 0, cy = 0;
        test_case("%d blades", n);
        CHECK_NEAR(pti_polygon_area(n), area, 1e-6);
        for (i = 0; i < N; i++) for (j = 0; j < N; j++) {
            const double h = 1e-3;
            float x, y, u[4], v[4];
            double phi, r, jacobian;
            int k;
            for (k = 0; k < 4; k++)
                pti_sample_polygon(n, turn, (float)((i + 0.5) / N + (k == 0 ? h : k == 1 ? -h : 0)), (float)((j + 0.5) / N + (k == 2 ? h : k == 3 ? -h : 0)), &u[k], &v[k]);
            jacobian = fabs(((double)u[0] - u[1]) * ((double)v[2] - v[3]) - ((double)v[0] - v[1]) * ((double)u[2] - u[3])) / (4 * h * h);
            pti_sample_polygon(n, turn, (float)((i + 0.5) / N), (float)((j + 0.5) / N), &x, &y);
            phi = fmod(atan2((double)y, (double)x) - (double)turn + 4 * STATS_PI, 2 * STATS_PI / n) - STATS_PI / n;
            r = hypot((double)x, (double)y);
            out = fmax(out, r * cos(phi) - inner);       /* beyond the nearest side */
            reach = fmax(reach, r);
            if (fabs(phi) < STATS_PI / n - 0.1 && r > 0.1 && fabs(fabs((double)i + 0.5 - N / 2) - fabs(j + 0.5 - N / 2)) > 1) /* not across a kink */
                worst = fmax(worst, fabs(jacobian / area - 1));
            r2 += r * r; cx += (double)x; cy += (double)y;
        }
        CHECK(out < 1e-6);
        CHECK(reach > 0.93);
        CHECK(worst < 0.01);
        CHECK_NEAR(r2 / (N * N), (2 + cos(2 * STATS_PI / n)) / 6, 2e-3);        /* the polygon's second moment */
        CHECK(fabs(cx) < 2e-3 * N * N && fabs(cy) < 2e-3 * N * N);
    }
}
typedef struct polygon_test { int n; float turn; } polygon_test;
static int sample_polygon(void *ctx, pt_rng *rng, float xy[2]) {
    const polygon_test *t = (const polygon_test *)ctx;
    float u = pt_rng_float(rng), v = pt_rng_float(rng);
    pti_sample_polygon(t->n, t->turn, u, v, &xy[0], &xy[1]);
    return 1;
}
static double pdf_square(void *ctx, float x, float y) { (void)ctx; (void)x; (void)y; return 0.5; }
static void four_blades_are_a_square(void) {             /* turned by 45 degrees its sides are upright: a grid fits */
    polygon_test t = { 4, PTI_PI / 4 };
    CHECK_P(chi2_square(&(chi2_square_desc){ .sample = sample_polygon, .pdf = pdf_square, .ctx = &t, .x0 = -0.7071070, .x1 = 0.7071070,
                                             .y0 = -0.7071070, .y1 = 0.7071070 }));
}
static void blades_turn(void) {                          /* the corner is where the angle says */
    pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -4), 40);
    int k;
    for (k = 0; k < 4; k++) {
        pti_lens l;
        pt_rng rng;
        pt_vec3 org, dir, far = pt_v3(0, 0, 0);
        int i;
        double a = (k * 37 - 50) * STATS_PI / 180;
        c.aperture = 1; c.blades = 3; c.blade_rotation_deg = (float)(k * 37 - 50);
        l = pti_lens_make(&c, 1, 1);
        pt_rng_seed(&rng, 12, 1);
        for (i = 0; i < 20000; i++) {
            float u = pt_rng_float(&rng), v = pt_rng_float(&rng);
            lens_ray(&l, 0.5f, 0.5f, u, v, &org, &dir);
            if (cos(a) * (double)org.x + sin(a) * (double)org.y > cos(a) * (double)far.x + sin(a) * (double)far.y) far = org;
        }
        CHECK_NEAR(far.x, cos(a), 0.03); CHECK_NEAR(far.y, sin(a), 0.03);
    }
}

/* ---- what lenses do to the picture ---- */

static void shifted(void) {
    pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 90), e = c;
    int kind;
    float w;
    e.shift_x = 0.25f; e.shift_y = 0.5f;
    for (kind = 0; kind < 2; kind++) {
        pt_ray a, b;
        c.projection = e.projection = (pt_projection)kind;
        a = ray_at(&c, 200, 100, 0.75f, 0.1f, 0, 0, &w);
        b = ray_at(&e, 200, 100, 0.5f, 0.6f, 0, 0, &w);              /* a quarter of the width left, half the height down */
        check_direction(b.dir, a.dir.x, a.dir.y, a.dir.z);
        CHECK_NEAR(a.org.x, b.org.x, 1e-6); CHECK_NEAR(a.org.y, b.org.y, 1e-6);
    }
    e.projection = PT_CAMERA_PERSPECTIVE;
    check_direction(ray_at(&e, 200, 100, 0.5f, 0.5f, 0, 0, &w).dir, 1, 1, -1);
}
static void distorted(void) {
    static const float k1[] = { 0.2f, -0.05f };
    int i, k;
    float w;
    for (i = 0; i < 2; i++) for (k = 0; k <= 10; k++) {
        pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 60);
        double h = tan(30 * STATS_PI / 180), x = (2 * (k / 10.0) - 1) * 2, y = 1 - 2 * 0.2, f = 1 + (double)k1[i] * (x * x + y * y);
        c.distortion = k1[i];
        check_direction(ray_at(&c, 200, 100, (float)k / 10, 0.2f, 0, 0, &w).dir, f * x * h, f * y * h, -1);
    }
}
static void aberrated(void) {                            /* the picture of a point at 700 nm is farther out than that at 400 nm */
    pt_camera c = camera(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 90);
    pt_ray r[3];
    float w;
    c.aberration = 0.02f;
    r[0] = ray_at(&c, 9, 9, 1, 0.5f, 0, 400, &w);
    r[1] = ray_at(&c, 9, 9, 1, 0.5f, 0, 700, &w);
    r[2] = ray_at(&c, 9, 9, 1, 0.5f, 0, 0, &w);
    check_direction(r[0].dir, 1 / 0.99, 0, -1);
    check_direction(r[1].dir, 1 / 1.01, 0, -1);
    check_direction(r[2].dir, 1, 0, -1);
}
static void vignetted(void) {
    static float rgb[64 * 64 * 3];
    static const float amount[] = { 0, 0.5f, 1 };
    int k, x, y;
    for (k = 0; k < 3; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 90, 64, 16);
        double worst = 0;
        d.camera.vignetting = amount[k];
        sky(s, 1);
        if (commit(s) && render(s, &d, rgb, NULL))
            for (y = 0; y < 64; y++) for (x = 0; x < 64; x++) {
                double a = (x + 0.5) / 32 - 1, b = (y + 0.5) / 32 - 1, cos2 = 1 / (1 + a * a + b * b);
                worst = fmax(worst, fabs((double)rgb[3 * (64 * y + x)] - (1 + (double)amount[k] * (cos2 * cos2 - 1))));
            }
        test_case("vignetting %g", (double)amount[k]);
        CHECK(worst < 0.004);
        pt_scene_destroy(s);
    }
}

/* ---- motion ---- */

static void cameras_move(void) {
    int k;
    float w;
    for (k = 0; k <= 4; k++) {
        float f = (float)k / 4;
        pt_camera c = camera(pt_v3(1, 2, 3), pt_v3(1, 2, -7), 50), now;
        pt_ray a, b;
        c.shutter_open = 0.25f; c.shutter_close = 0.75f; c.moving = 1;
        c.eye_end = pt_v3(3, 2, 3); c.target_end = pt_v3(3, 4, -7); c.up_end = pt_v3(0.5f, 0.5f, 0);
        now = camera(pt_v3(1 + 2 * f, 2, 3), pt_v3(1 + 2 * f, 2 + 2 * f, -7), 50);
        now.up = pt_v3(0.5f * f, 1 - 0.5f * f, 0);
        c.aperture = now.aperture = 0.3f;                /* the focus is the target's, wherever that is */
        a = ray_at(&c, 3, 2, 0.3f, 0.9f, f, 0, &w);
        b = ray_at(&now, 3, 2, 0.3f, 0.9f, 0, 0, &w);
        check_direction(a.dir, b.dir.x, b.dir.y, b.dir.z);
        CHECK_NEAR(pti_length(pti_sub(a.org, b.org)), 0, 1e-6);
        CHECK_NEAR(a.time, 0.25 + 0.5 * (double)f, 1e-6);
    }
}
/* A camera that passes a lamp by smears it into a bar of even brightness, whose light is that of the lamp at rest. */
static void motion_smears(void) {
    static float rgb[64 * 64 * 3];
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d = view(pt_v3(0, 0, 10), pt_v3(0, 0, 0), 0, 64, 256);
    double sum = 0, middle = 0;
    int x, y;
    pt_add_quad(s, pt_v3(-0.5f, -0.5f, 0), pt_v3(1, 0, 0), pt_v3(0, 1, 0), lamp(s, 1, 1));
    d.camera.projection = PT_CAMERA_ORTHOGRAPHIC; d.camera.height = 8;       /* the lamp is 8 x 8 pixels */
    d.camera.shutter_close = 1; d.camera.moving = 1;
    d.camera.eye = pt_v3(-2, 0, 10); d.camera.target = pt_v3(-2, 0, 0);
    d.camera.eye_end = pt_v3(2, 0, 10); d.camera.target_end = pt_v3(2, 0, 0);
    if (commit(s) && render(s, &d, rgb, NULL)) {
        for (y = 0; y < 64; y++) for (x = 0; x < 64; x++) sum += (double)rgb[3 * (64 * y + x)];
        for (x = 28; x < 36; x++) middle += (double)rgb[3 * (64 * 32 + x)] / 8;
        CHECK_NEAR(sum, 64, 0.2);
        CHECK_NEAR(middle, 0.25, 0.005);                 /* it takes a quarter of the time to pass by */
        CHECK(rgb[3 * (64 * 32 + 10)] == 0 && rgb[3 * (64 * 32 + 53)] == 0 && rgb[3 * (64 * 27 + 32)] == 0);
    }
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
    RUN(orthographic);
    RUN(equirectangular_is_as_maps_are);
    RUN(fisheye_angles);
    RUN(fisheye_is_black_outside);
    RUN(all_projections_focus);
    RUN(polygons);
    RUN(four_blades_are_a_square);
    RUN(blades_turn);
    RUN(shifted);
    RUN(distorted);
    RUN(aberrated);
    RUN(vignetted);
    RUN(cameras_move);
    RUN(motion_smears);
}
