/* >>texture: what a texture shows where, against a bilinear filter in double. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

static pt_vec3 look(const pt_scene *s, double u, double v) {       /* at the first texture */
    pt_vertex x;
    memset(&x, 0, sizeof x);
    x.u = (float)u; x.v = (float)v;
    return pti_texture_eval(s->textures, &x);
}
static pt_scene *scene_with(pt_texture_desc d) {
    pt_scene *s = pt_scene_create(NULL);
    pt_add_texture(s, &d);
    commit(s);
    return s;
}
static float pixels[5 * 4 * 3];
static pt_scene *random_picture(int width, int height, int channels) {
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 7, 1);
    for (i = 0; i < width * height * channels; i++) pixels[i] = pt_rng_float(&rng);
    return scene_with((pt_texture_desc){ .width = width, .height = height, .channels = channels, .is_float = 1, .pixels = pixels });
}
static int modulo(long long a, int n) { return (int)((a % n + n) % n); }
static double bilinear(double u, double v, int width, int height, int channels, int c) {
    double x = u * width - 0.5, y = (1 - v) * height - 0.5, fx = x - floor(x), fy = y - floor(y), sum = 0;
    int i, j;
    for (j = 0; j < 2; j++) for (i = 0; i < 2; i++)
        sum += (i ? fx : 1 - fx) * (j ? fy : 1 - fy)
             * pixels[(modulo((long long)floor(y) + j, height) * width + modulo((long long)floor(x) + i, width)) * channels + c];
    return sum;
}
static void check_look(const pt_scene *s, double u, double v, int w, int h, int channels, double tolerance) {
    pt_vec3 c = look(s, u, v);
    test_case("u %g, v %g", u, v);
    CHECK_NEAR(c.x, bilinear((float)u, (float)v, w, h, channels, 0), tolerance);
    CHECK_NEAR(c.z, bilinear((float)u, (float)v, w, h, channels, channels == 1 ? 0 : 2), tolerance);
}

static void texel_centres(void) {
    pt_scene *s = random_picture(5, 4, 3);
    int x, y;
    for (y = 0; y < 4; y++) for (x = 0; x < 5; x++) {
        pt_vec3 c = look(s, (x + 0.5) / 5, 1 - (y + 0.5) / 4);       /* the top row first, v = 0 at the bottom */
        CHECK_NEAR(c.x, pixels[(y * 5 + x) * 3], 1e-5);
        CHECK_NEAR(c.y, pixels[(y * 5 + x) * 3 + 1], 1e-5);
        CHECK_NEAR(c.z, pixels[(y * 5 + x) * 3 + 2], 1e-5);
    }
    pt_scene_destroy(s);
}
static void between_texels(void) {
    static const int channels[] = { 1, 3 };
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 1, 1);
    for (k = 0; k < 2; k++) {
        pt_scene *s = random_picture(5, 4, channels[k]);
        for (i = 0; i < 2000; i++) check_look(s, pt_rng_float(&rng), pt_rng_float(&rng), 5, 4, channels[k], 1e-5);
        check_look(s, 0, 0, 5, 4, channels[k], 1e-6);
        check_look(s, 1, 1, 5, 4, channels[k], 1e-6);
        pt_scene_destroy(s);
    }
}
static void wraps_round(void) {
    pt_scene *s = random_picture(5, 4, 3);
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 2, 1);
    for (i = 0; i < 2000; i++)
        check_look(s, 8 * pt_rng_float(&rng) - 4, 8 * pt_rng_float(&rng) - 4, 5, 4, 3, 2e-5);
    for (i = 0; i < 500; i++)
        check_look(s, 2000 * pt_rng_float(&rng) - 1000, 2000 * pt_rng_float(&rng) - 1000, 5, 4, 3, 3e-3);
    pt_scene_destroy(s);
}
static void huge_coordinates(void) {
    static const float far_off[] = { 1e7f, -1e7f, 16777216.f, 2147483648.f, -2147483648.f, 1e12f, -1e12f, 1e30f, 3e38f, -3e38f, -1e-30f, 1e-45f };
    pt_scene *s = random_picture(5, 4, 3);
    int i, j;
    for (i = 0; i < 12; i++) for (j = 0; j < 12; j++) {
        pt_vec3 c = look(s, (double)far_off[i], (double)far_off[j]);
        CHECK(c.x >= 0 && c.x <= 1.00001f && c.y >= 0 && c.y <= 1.00001f && c.z >= 0 && c.z <= 1.00001f);
    }
    pt_scene_destroy(s);
}
static void bytes(void) {
    static unsigned char ramp[256 * 4];
    int i, srgb, channels;
    for (channels = 1; channels <= 4; channels++) for (srgb = 0; srgb < 2; srgb++) {
        pt_scene *s;
        if (channels == 2) continue;
        memset(ramp, 99, sizeof ramp);
        for (i = 0; i < 256; i++) {
            ramp[i * channels] = (unsigned char)i;
            if (channels > 1) { ramp[i * channels + 1] = (unsigned char)(255 - i); ramp[i * channels + 2] = (unsigned char)(i ^ 85); }
        }
        s = scene_with((pt_texture_desc){ .width = 256, .height = 1, .channels = channels, .srgb = srgb, .pixels = ramp });
        memset(ramp, 0, sizeof ramp);                    /* pixels are copied */
        for (i = 0; i < 256; i++) {
            pt_vec3 c = look(s, (i + 0.5) / 256, 0.5);
            double want[3];
            int k;
            want[0] = i; want[1] = channels > 1 ? 255 - i : i; want[2] = channels > 1 ? i ^ 85 : i;
            for (k = 0; k < 3; k++) {
                want[k] /= 255;
                if (srgb) want[k] = want[k] <= 0.04045 ? want[k] / 12.92 : pow((want[k] + 0.055) / 1.055, 2.4);
            }
            test_case("byte %d, %d channels, %s", i, channels, srgb ? "sRGB" : "linear");
            CHECK_NEAR(c.x, want[0], 2e-6); CHECK_NEAR(c.y, want[1], 2e-6); CHECK_NEAR(c.z, want[2], 2e-6);
        }
        pt_scene_destroy(s);
    }
}
static pt_vec3 asked(void *user, const pt_vertex *x) { return pt_v3(x->u, x->v, *(float *)user); }
static void callbacks(void) {
    float blue = 0.75f;
    pt_scene *s = pt_scene_create(NULL);
    pt_texture t = pt_add_texture(s, &(pt_texture_desc){ .eval = asked, .user = &blue });
    pt_material plain = pt_add_material(s, &(pt_material_desc){ .color_texture = t });
    pt_material half = pt_add_material(s, &(pt_material_desc){ .color_texture = t, .color = { 0.5f, 0.25f, 1 } });
    pt_vertex x;
    pt_material_desc d;
    pt_vec3 c;
    if (!commit(s)) return;
    memset(&x, 0, sizeof x);
    x.u = 0.25f; x.v = 0.5f;
    pti_material_vary(s->materials + plain.id, &x, &d);
    c = d.color;
    CHECK(c.x == 0.25f && c.y == 0.5f && c.z == 0.75f);
    pti_material_vary(s->materials + half.id, &x, &d);
    c = d.color;
    CHECK(c.x == 0.125f && c.y == 0.125f && c.z == 0.75f);
    pt_scene_destroy(s);
}
/* On a quad, with (u, v) = (0, 0) at its corner, the picture stands upright: left is small u, the top is v = 1. */
static void on_a_quad(void) {
    static const float corners[4] = { 0.1f, 0.4f, 0.7f, 1.0f };    /* top left, top right, bottom left, bottom right */
    static float rgb[16 * 16 * 3];
    pt_scene *s = pt_scene_create(NULL);
    pt_material m = pt_add_material(s, &(pt_material_desc){ .color_texture = grey_map(s, corners, 2, 2) });
    pt_render_desc d = view(pt_v3(0, 0, 10), pt_v3(0, 0, 0), 11.4f, 16, 4);
    pt_add_quad(s, pt_v3(-1, -1, 0), pt_v3(2, 0, 0), pt_v3(0, 2, 0), m);
    sky(s, 1);
    d.max_depth = 1;
    if (commit(s) && render(s, &d, rgb, NULL)) {
        CHECK_NEAR(rgb[3 * (4 * 16 + 4)], 0.1, 0.08);
        CHECK_NEAR(rgb[3 * (4 * 16 + 11)], 0.4, 0.08);
        CHECK_NEAR(rgb[3 * (11 * 16 + 4)], 0.7, 0.08);
        CHECK_NEAR(rgb[3 * (11 * 16 + 11)], 1.0, 0.08);
    }
    pt_scene_destroy(s);
}
static void a_single_texel(void) {
    static const float one = 0.375f;
    pt_scene *s = scene_with((pt_texture_desc){ .width = 1, .height = 1, .channels = 1, .is_float = 1, .pixels = &one });
    CHECK_NEAR(look(s, 0.3, -7.9).y, 0.375, 1e-7);
    pt_scene_destroy(s);
}
/* As a map of the sky, v stops at the poles. */
static void poles_do_not_wrap(void) {
    pt_scene *s = random_picture(5, 4, 3);
    pt_vec3 top = pti_texture_bilinear(s->textures, 0.5f, 0, 1), bottom = pti_texture_bilinear(s->textures, 0.5f, 1, 1);
    CHECK_NEAR(top.x, pixels[2 * 3], 1e-6);
    CHECK_NEAR(bottom.x, pixels[(3 * 5 + 2) * 3], 1e-6);
    pt_scene_destroy(s);
}

void test_texture(void) {
    RUN(texel_centres);
    RUN(between_texels);
    RUN(wraps_round);
    RUN(huge_coordinates);
    RUN(bytes);
    RUN(callbacks);
    RUN(on_a_quad);
    RUN(a_single_texel);
    RUN(poles_do_not_wrap);
}
