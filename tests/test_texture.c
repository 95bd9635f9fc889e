/* >>texture: what a texture shows where, against a bilinear filter in double. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

static float grey_at(const pti_texture *t, float u, float v) {
    pt_vertex x;
    memset(&x, 0, sizeof x);
    x.u = u; x.v = v;
    return pti_texture_grey(t, &x);
}
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
    return scene_with((pt_texture_desc){ .width = width, .height = height, .channels = channels, .bits = 32, .pixels = pixels });
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
        memset(ramp, 99, sizeof ramp);
        for (i = 0; i < 256; i++) {
            ramp[i * channels] = (unsigned char)i;
            if (channels > 2) { ramp[i * channels + 1] = (unsigned char)(255 - i); ramp[i * channels + 2] = (unsigned char)(i ^ 85); }
        }
        s = scene_with((pt_texture_desc){ .width = 256, .height = 1, .channels = channels, .srgb = srgb, .pixels = ramp });
        memset(ramp, 0, sizeof ramp);                    /* pixels are copied */
        for (i = 0; i < 256; i++) {
            pt_vec3 c = look(s, (i + 0.5) / 256, 0.5);
            double want[3];
            int k;
            want[0] = i; want[1] = channels > 2 ? 255 - i : i; want[2] = channels > 2 ? i ^ 85 : i;
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
    pt_scene *s = scene_with((pt_texture_desc){ .width = 1, .height = 1, .channels = 1, .bits = 32, .pixels = &one });
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

/* ---- all settings, against a reference in double */

static pt_vertex at_uv(double u, double v) {
    pt_vertex x;
    memset(&x, 0, sizeof x);
    x.u = (float)u; x.v = (float)v;
    return x;
}
static double decoded(double s) { return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4); }
static double channel_of(const pt_texture_desc *d, long long x, long long y, int c) {
    size_t i = (size_t)((y * d->width + x) * d->channels + c);
    double value = d->bits == 32 ? (double)((const float *)d->pixels)[i]
                 : d->bits == 16 ? ((const uint16_t *)d->pixels)[i] / 65535.0 : ((const unsigned char *)d->pixels)[i] / 255.0;
    return d->srgb && !(d->channels % 2 == 0 && c == d->channels - 1) ? decoded(value) : value;
}
static long long wrapped(long long i, int n, pt_wrap wrap) {
    if (wrap == PT_WRAP_CLAMP) return i < 0 ? 0 : i >= n ? n - 1 : i;
    if (wrap == PT_WRAP_REPEAT) return ((i % n) + n) % n;
    i = ((i % (2 * n)) + 2 * n) % (2 * n);
    return i < n ? i : 2 * n - 1 - i;
}
static double clamped(double x, pt_wrap wrap) { return wrap != PT_WRAP_CLAMP ? x : x < -1 ? -1 : x > 2 ? 2 : x; }
static double want(const pt_texture_desc *d, double u, double v, int c) {
    double a = d->uv_rotate_deg * STATS_PI / 180, x = u * (d->uv_scale[0] != 0 ? d->uv_scale[0] : 1);
    double y = (1 - v) * (d->uv_scale[1] != 0 ? d->uv_scale[1] : 1), s, t, fx, fy, sum = 0;
    int i, j;
    s = clamped(d->uv_offset[0] + cos(a) * x + sin(a) * y, d->wrap_u) * d->width;
    t = clamped(d->uv_offset[1] - sin(a) * x + cos(a) * y, d->wrap_v) * d->height;
    if (d->nearest) return channel_of(d, wrapped((long long)floor(s), d->width, d->wrap_u), wrapped((long long)floor(t), d->height, d->wrap_v), c);
    s -= 0.5; t -= 0.5;
    fx = s - floor(s); fy = t - floor(t);
    for (j = 0; j < 2; j++) for (i = 0; i < 2; i++)
        sum += (i ? fx : 1 - fx) * (j ? fy : 1 - fy) * channel_of(d, wrapped((long long)floor(s) + i, d->width, d->wrap_u),
                                                                  wrapped((long long)floor(t) + j, d->height, d->wrap_v), c);
    return sum;
}
static union { unsigned char b[5 * 7 * 4]; uint16_t s[5 * 7 * 4]; float f[5 * 7 * 4]; } store;
static pt_texture_desc picture(int bits, int channels, int srgb) {
    pt_texture_desc d;
    pt_rng rng;
    int i;
    memset(&d, 0, sizeof d);
    d.width = 5; d.height = 7; d.channels = channels; d.bits = bits; d.srgb = srgb; d.pixels = &store;
    pt_rng_seed(&rng, 11, (uint64_t)bits);
    for (i = 0; i < 5 * 7 * channels; i++) {
        uint32_t r = pt_rng_u32(&rng);
        if (bits == 8) store.b[i] = (unsigned char)r;
        else if (bits == 16) store.s[i] = (uint16_t)r;
        else store.f[i] = pti_u01(r);
    }
    return d;
}
/* Colour, grey and alpha at (u, v), all three against the reference. */
static void check_all(const pti_texture *t, const pt_texture_desc *d, double u, double v, double tolerance) {
    pt_vertex x = at_uv(u, v);
    pt_vec3 c = pti_texture_eval(t, &x);
    int grey = d->channels < 3 || d->channel, first = d->channel ? d->channel - 1 : 0, k;
    u = (double)x.u; v = (double)x.v;
    for (k = 0; k < 3; k++) CHECK_NEAR(pti_axis(c, k), want(d, u, v, grey ? first : k), tolerance);
    CHECK_NEAR(pti_texture_grey(t, &x), want(d, u, v, first), tolerance);
    CHECK_NEAR(grey_at(t, x.u, x.v), want(d, u, v, first), tolerance);
    if (d->channels % 2) CHECK(pti_texture_alpha(t, &x) == 1);
    else CHECK_NEAR(pti_texture_alpha(t, &x), want(d, u, v, d->channels - 1), tolerance);
}
static void every_depth_and_channel(void) {
    static const int depths[] = { 8, 16, 32 };
    pt_rng rng;
    int b, channels, srgb, pick, i;
    pt_rng_seed(&rng, 5, 5);
    for (b = 0; b < 3; b++) for (channels = 1; channels <= 4; channels++) for (srgb = 0; srgb < (b < 2 ? 2 : 1); srgb++)
        for (pick = 0; pick <= channels; pick++) {
            pt_texture_desc d = picture(depths[b], channels, srgb);
            pt_scene *s;
            d.channel = pick;
            s = scene_with(d);
            test_case("%d bits, %d channels, channel %d, %s", d.bits, channels, pick, srgb ? "sRGB" : "linear");
            for (i = 0; i < 50; i++) {
                float u = 4 * pt_rng_float(&rng) - 2, v = 4 * pt_rng_float(&rng) - 2;
                check_all(s->textures, &d, (double)u, (double)v, 1e-5);
            }
            pt_scene_destroy(s);
        }
}
static void all_16_bit_values(void) {                    /* in 65536 texels, asked in their middles */
    static uint16_t ramp[65536];
    pt_scene *s;
    int i;
    for (i = 0; i < 65536; i++) ramp[i] = (uint16_t)i;
    s = scene_with((pt_texture_desc){ .width = 256, .height = 256, .channels = 1, .bits = 16, .srgb = 1, .nearest = 1, .pixels = ramp });
    for (i = 0; i < 65536; i++) {
        pt_vertex x = at_uv((i % 256 + 0.5) / 256, 1 - (i / 256 + 0.5) / 256);
        float got = pti_texture_grey(s->textures, &x);
        test_case("value %d", i);
        if (got != pti_srgb_decode((float)i / 65535) || fabs((double)got - decoded(i / 65535.0)) > 3e-7) { CHECK_NEAR(got, decoded(i / 65535.0), 3e-7); break; }
    }
    CHECK_EQ_INT(i, 65536);
    pt_scene_destroy(s);
}
static void every_wrap(void) {
    static const double places[] = { -3.7, -1, -0.0, 0, 0.03, 0.5, 0.97, 1, 1.4, 2, 5.25, -1e-9, 1e6, -1e6, 1e6 + 0.25 };
    int u, v, nearest, i, j;
    for (u = 0; u < 3; u++) for (v = 0; v < 3; v++) for (nearest = 0; nearest < 2; nearest++) {
        pt_texture_desc d = picture(32, 3, 0);
        pt_scene *s;
        d.wrap_u = (pt_wrap)u; d.wrap_v = (pt_wrap)v; d.nearest = nearest;
        s = scene_with(d);
        for (i = 0; i < 15; i++) for (j = 0; j < 15; j++) {
            if (nearest && (places[i] == -1e-9 || places[j] == -1e-9)) continue;      /* too near a border for 1 - v */
            test_case("wraps %d %d, u %g, v %g, %s", u, v, places[i], places[j], nearest ? "nearest" : "bilinear");
            check_all(s->textures, &d, places[i], places[j], 1e-5);
        }
        pt_scene_destroy(s);
    }
}
static void at_the_ends_of_the_floats(void) {            /* no pixel outside, no index that is no number */
    static const float far_off[] = { 3e38f, -3e38f, 1e30f, 16777217.f, -2147483648.f, 1e-45f, -1e-45f };
    float odd[10];
    int i, j, k, nearest;
    memcpy(odd, far_off, sizeof far_off);
    odd[7] = (float)HUGE_VAL; odd[8] = -odd[7]; odd[9] = odd[7] - odd[7];
    for (k = 0; k < 3; k++) for (nearest = 0; nearest < 2; nearest++) {
        pt_texture_desc d = picture(8, 3, 1);
        pt_scene *s;
        d.wrap_u = d.wrap_v = (pt_wrap)k; d.nearest = nearest; d.uv_rotate_deg = 30; d.uv_scale[0] = 1e3f;
        s = scene_with(d);
        for (i = 0; i < 10; i++) for (j = 0; j < 10; j++) {
            pt_vertex x = at_uv(0, 0);
            pt_vec3 c;
            x.u = odd[i]; x.v = odd[j];
            c = pti_texture_eval(s->textures, &x);
            CHECK(c.x >= 0 && c.x <= 1.00001f && c.y >= 0 && c.y <= 1.00001f && c.z >= 0 && c.z <= 1.00001f);
        }
        pt_scene_destroy(s);
    }
}
static void transforms(void) {
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 3, 9);
    for (i = 0; i < 60; i++) {
        pt_texture_desc d = picture(16, 3, 0);
        pt_scene *s;
        for (k = 0; k < 2; k++) {
            d.uv_scale[k] = i % 3 == k ? 0 : 6 * pt_rng_float(&rng) - 3;
            d.uv_offset[k] = i % 4 == k ? 0 : 6 * pt_rng_float(&rng) - 3;
        }
        d.uv_rotate_deg = i % 5 == 0 ? 0 : 720 * pt_rng_float(&rng) - 360;
        d.wrap_u = (pt_wrap)(i % 3); d.wrap_v = (pt_wrap)(i / 3 % 3);
        s = scene_with(d);
        test_case("scale %g %g, %g degrees, offset %g %g", (double)d.uv_scale[0], (double)d.uv_scale[1], (double)d.uv_rotate_deg,
                  (double)d.uv_offset[0], (double)d.uv_offset[1]);
        for (k = 0; k < 50; k++) {
            float u = 2 * pt_rng_float(&rng) - 0.5f, v = 2 * pt_rng_float(&rng) - 0.5f;
            check_all(s->textures, &d, (double)u, (double)v, 1e-4);
        }
        pt_scene_destroy(s);
    }
}
/* The example of KHR_texture_transform: offset 0 1, a quarter turn, scale 0.5 show the lower left quadrant, turned
   clockwise. Its v points down. */
static void as_gltf_says(void) {
    static const unsigned char letters[16] = { 1, 2, 3, 4,  5, 6, 7, 8,  9, 10, 11, 12,  13, 14, 15, 16 };
    pt_scene *s = scene_with((pt_texture_desc){ .width = 4, .height = 4, .channels = 1, .pixels = letters, .nearest = 1,
        .uv_offset = { 0, 1 }, .uv_rotate_deg = 90, .uv_scale = { 0.5f, 0.5f } });
    static const int turned[4] = { 13, 9, 14, 10 };      /* the quadrant is 9 10 / 13 14 */
    int i;
    for (i = 0; i < 4; i++) {
        pt_vertex x = at_uv(i % 2 ? 0.75 : 0.25, i / 2 ? 0.25 : 0.75);
        CHECK_NEAR(pti_texture_grey(s->textures, &x) * 255, turned[i], 1e-4);
    }
    pt_scene_destroy(s);
}
static void texel_steps(void) {
    pt_texture_desc d = picture(8, 1, 0);
    pt_scene *s;
    float du, dv;
    d.uv_scale[0] = 2; d.uv_scale[1] = -4; d.uv_rotate_deg = 90;    /* s = scaled v, t = minus scaled u */
    s = scene_with(d);
    pti_texture_texel(s->textures, &du, &dv);
    CHECK_NEAR(du, 1 / (2.0 * 7), 1e-6);
    CHECK_NEAR(dv, 1 / (4.0 * 5), 1e-6);
    pt_scene_destroy(s);
    s = scene_with((pt_texture_desc){ .pattern = PT_PATTERN_NOISE, .solid = 1, .frequency = 10 });
    pti_texture_texel(s->textures, &du, &dv);
    CHECK_NEAR(du, 1 / 160.0, 1e-7);
    CHECK(du == dv);
    pt_scene_destroy(s);
}
/* The same pixels, seen otherwise, and not copied. */
static void views(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_texture_desc d = picture(8, 4, 1), e;
    pt_texture base = pt_add_texture(s, &d), view, of_view;
    pt_rng rng;
    int i;
    memset(&e, 0, sizeof e);
    e.of = base; e.channel = 4; e.nearest = 1; e.wrap_u = PT_WRAP_MIRROR; e.uv_scale[0] = 3;
    view = pt_add_texture(s, &e);
    e.of = view; e.channel = 2; e.nearest = 0;
    of_view = pt_add_texture(s, &e);
    for (i = 0; i < 100; i++) grey_map(s, pixels, 1, 1);            /* the array of textures moves */
    if (!commit(s)) return;
    CHECK(s->textures[0].pixels == s->textures[1].pixels && s->textures[0].pixels == s->textures[2].pixels);
    e = d; e.channel = 4; e.nearest = 1; e.wrap_u = PT_WRAP_MIRROR; e.uv_scale[0] = 3; e.srgb = 0;
    pt_rng_seed(&rng, 9, 9);
    for (i = 0; i < 100; i++) {
        float u = 4 * pt_rng_float(&rng) - 2, v = pt_rng_float(&rng);
        check_all(s->textures + (base.id - 1), &d, (double)u, (double)v, 1e-5);
        e.channel = 4; e.nearest = 1;
        check_all(s->textures + (view.id - 1), &e, (double)u, (double)v, 1e-5);
        e.channel = 2; e.nearest = 0;
        check_all(s->textures + (of_view.id - 1), &e, (double)u, (double)v, 1e-5);
    }
    pt_scene_destroy(s);
}
static void channels_of_callbacks(void) {
    float blue = 0.75f;
    pt_scene *s = scene_with((pt_texture_desc){ .eval = asked, .user = &blue, .channel = 2 });
    pt_vec3 c = look(s, 0.25, 0.5);
    pt_vertex x = at_uv(0.25, 0.5);
    CHECK(c.x == 0.5f && c.y == 0.5f && c.z == 0.5f);
    CHECK(pti_texture_grey(s->textures, &x) == 0.5f);
    CHECK(grey_at(s->textures, 0.25f, 0.5f) == 0.5f);
    CHECK(pti_texture_alpha(s->textures, &x) == 1);
    pt_scene_destroy(s);
}

/* ---- means over triangles */

static pt_vec3 brute_mean(const pti_texture *t, const float a[2], const float b[2], const float c[2], int n) {
    double sum[3] = { 0, 0, 0 };
    int i, j, k;
    for (i = 0; i < n; i++) for (j = 0; j < n; j++) {               /* a square folded to the triangle */
        double x = (i + 0.5) / n, y = (j + 0.5) / n;
        pt_vec3 got;
        if (x + y > 1) { x = 1 - x; y = 1 - y; }
        got = pti_texture_eval_at(t, (float)(a[0] + x * (b[0] - a[0]) + y * (c[0] - a[0])), (float)(a[1] + x * (b[1] - a[1]) + y * (c[1] - a[1])));
        for (k = 0; k < 3; k++) sum[k] += (double)pti_axis(got, k);
    }
    return pt_v3((float)(sum[0] / n / n), (float)(sum[1] / n / n), (float)(sum[2] / n / n));
}
static void means_on_triangles(void) {
    pt_texture_desc d = picture(32, 3, 0);
    pt_scene *s = scene_with(d);
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 4, 2);
    for (i = 0; i < 40; i++) {
        float corner[6];
        pt_vec3 got, brute;
        double scale = i < 10 ? 0.1 : i < 30 ? 1 : 4;
        for (k = 0; k < 6; k++) corner[k] = (float)(scale * (double)pt_rng_float(&rng));
        got = pti_texture_mean_on_triangle(s->textures, corner, corner + 2, corner + 4);
        brute = brute_mean(s->textures, corner, corner + 2, corner + 4, 400);
        test_case("triangle %d", i);
        for (k = 0; k < 3; k++) CHECK_NEAR(pti_axis(got, k), pti_axis(brute, k), 0.01);
        brute = pti_texture_mean_on_triangle(s->textures, corner, corner + 2, corner + 4);
        CHECK(got.x == brute.x && got.y == brute.y && got.z == brute.z);
    }
    pt_scene_destroy(s);
}
static void mean_of_fine_stripes(void) {                 /* with a period that would fool a grid of 64 */
    static unsigned char stripes[1024];
    static const float a[2] = { 0, 0 }, b[2] = { 1, 0 }, c[2] = { 0, 1 };
    pt_scene *s;
    int i;
    for (i = 0; i < 1024; i++) stripes[i] = i % 16 < 4 ? 255 : 0;
    s = scene_with((pt_texture_desc){ .width = 1024, .height = 1, .channels = 1, .pixels = stripes });
    CHECK_NEAR(pti_texture_mean_on_triangle(s->textures, a, b, c).x, 0.25, 0.02);      /* 0.0068 is one sigma */
    CHECK_NEAR(pti_texture_mean_on_triangle(s->textures, a, a, a).x, 0.5, 0.5);        /* no area: still a number */
    pt_scene_destroy(s);
}

/* ---- patterns */

static pt_texture_desc solid(pt_pattern kind) { pt_texture_desc d; memset(&d, 0, sizeof d); d.pattern = kind; d.solid = 1; return d; }
static float at_p(const pt_scene *s, double x, double y, double z) {
    pt_vertex v;
    memset(&v, 0, sizeof v);
    v.p = pt_v3((float)x, (float)y, (float)z);
    return pti_texture_grey(s->textures, &v);
}
static void checkers(void) {
    pt_scene *s = scene_with(solid(PT_PATTERN_CHECKER));
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 1, 7);
    for (i = 0; i < 2000; i++) {
        double p[3], f;
        int sum = 0, edge = 0;
        for (k = 0; k < 3; k++) {
            p[k] = (double)(float)(40 * ((double)pt_rng_float(&rng) - 0.5));
            f = p[k] - floor(p[k]);
            edge |= f > 0.995;
            sum += (int)floor(p[k]);
        }
        if (!edge) CHECK(at_p(s, p[0], p[1], p[2]) == (float)(sum & 1));
    }
    /* a wall at a whole coordinate, hit a little before or behind it, is of one colour */
    for (i = -3; i <= 3; i++) CHECK(at_p(s, 0.5, i * (1 - 1e-6), 0.5) == at_p(s, 0.5, i * (1 + 1e-6), 0.5));
    for (i = -3; i <= 3; i++) CHECK(at_p(s, 0.5, i, 0.5) == (float)(i & 1));
    CHECK(at_p(s, 0.5, -1e-7, 0.5) == at_p(s, 0.5, 1e-7, 0.5));
    pt_scene_destroy(s);
    s = scene_with((pt_texture_desc){ .pattern = PT_PATTERN_CHECKER, .uv_scale = { 8, 4 }, .color_a = { 1, 0, 0 }, .color_b = { 0, 0, 2 } });
    for (i = 0; i < 32; i++) {
        pt_vec3 c = look(s, (i % 8 + 0.5) / 8, 1 - (i / 8 + 0.5) / 4);
        CHECK(c.y == 0 && c.x == ((i + i / 8) % 2 ? 0 : 1) && c.z == ((i + i / 8) % 2 ? 2 : 0));
    }
    pt_scene_destroy(s);
}
static const pt_pattern noises[2] = { PT_PATTERN_NOISE, PT_PATTERN_FBM };
static void noise_stays_in_range(void) {
    static const double scales[] = { 1, 100, 1e5, 1e8, 1e20, 1e38 };
    int k, j, i;
    for (k = 0; k < 2; k++) {
        pt_texture_desc d = solid(noises[k]);
        pt_scene *s;
        pt_rng rng;
        float lo = 1, hi = 0;
        d.octaves = k ? 16 : 0;
        s = scene_with(d);
        pt_rng_seed(&rng, 21, 3);
        for (j = 0; j < 6; j++) for (i = 0; i < 20000; i++) {
            float x = 2 * pt_rng_float(&rng) - 1, y = 2 * pt_rng_float(&rng) - 1, z = 2 * pt_rng_float(&rng) - 1;
            float n = at_p(s, (double)x * scales[j], (double)y * scales[j], (double)z * scales[j]);
            if (!(n >= 0 && n <= 1)) { CHECK_NEAR(n, 0.5, 0.5); return; }
            lo = pti_min(lo, n); hi = pti_max(hi, n);
        }
        CHECK(lo < 0.1f && hi > 0.9f);
        for (i = 0; i < 3; i++) {                        /* a place that is none has a value all the same */
            double odd = i == 0 ? HUGE_VAL : i == 1 ? -HUGE_VAL : HUGE_VAL - HUGE_VAL;
            CHECK_NEAR(at_p(s, odd, 0.3, odd), 0.5, 0.5);
            CHECK_NEAR(at_p(s, 0.7, odd, 0.2), 0.5, 0.5);
        }
        pt_scene_destroy(s);
    }
    {   /* a colour is a mix of the two ends, never outside */
        pt_texture_desc d = solid(PT_PATTERN_FBM);
        pt_scene *s;
        d.color_a = pt_v3(0.2f, 0.9f, 0.5f); d.color_b = pt_v3(0.8f, 0.1f, 0.5f);
        s = scene_with(d);
        for (i = 0; i < 2000; i++) {
            pt_vertex x = at_uv(0, 0);
            pt_vec3 c;
            x.p = pt_v3((float)i * 0.137f, (float)i * 0.071f, 3);
            c = pti_texture_eval(s->textures, &x);
            CHECK(c.x >= 0.1999f && c.x <= 0.8001f && c.y >= 0.0999f && c.y <= 0.9001f);
            CHECK_NEAR(c.z, 0.5, 1e-6);
        }
        pt_scene_destroy(s);
    }
}
/* Means over many far points against 0.5 by z-test; the spread is what is documented. */
static void noise_statistics(void) {
    int k, i;
    for (k = 0; k < 2; k++) {
        pt_scene *s = scene_with(solid(noises[k]));
        stats_moments m = { 0, 0, 0 };
        int clipped = 0;
        pt_rng rng;
        pt_rng_seed(&rng, 77, (uint64_t)k);
        for (i = 0; i < 40000; i++) {
            pt_vec3 p = stats_uniform3(&rng);
            double n = (double)at_p(s, p.x * 1e4, p.y * 1e4, p.z * 1e4);
            stats_push(&m, n);
            clipped += n <= 0 || n >= 1;
        }
        test_case(k ? "fBm" : "noise");
        CHECK_P(stats_normal_p((m.mean - 0.5) / sqrt(m.m2 / m.n / m.n)));
        CHECK_NEAR(sqrt(m.m2 / m.n), k ? 0.155 : 0.134, 0.02);
        CHECK(clipped < 40000 / 200);
        pt_scene_destroy(s);
    }
}
static void octaves_do_not_correlate(void) {             /* nor does noise at neighbouring cells, nor along the axes */
    double sum[16][16], n = 20000;
    pt_rng rng;
    int i, j, k;
    memset(sum, 0, sizeof sum);
    pt_rng_seed(&rng, 78, 1);
    for (k = 0; k < (int)n; k++) {
        pt_vec3 r = stats_uniform3(&rng);
        double p[3], value[12];
        p[0] = r.x * 1000.0; p[1] = r.y * 1000.0; p[2] = r.z * 1000.0;
        for (i = 0; i < 5; i++) {                        /* the octaves of fBm, each as the step from i to i + 1 of them */
            value[i] = (double)pti_fbm(p, i + 1, 0) - (i ? (double)pti_fbm(p, i, 0) : 0);
        }
        for (i = 0; i < 4; i++) {                        /* in the plane */
            double flat[3] = { p[0], p[1], 0 };
            value[8 + i] = (double)pti_fbm(flat, i + 1, 1) - (i ? (double)pti_fbm(flat, i, 1) : 0);
        }
        p[0] += 1; value[5] = (double)pti_fbm(p, 1, 0);
        p[1] += 1; value[6] = (double)pti_fbm(p, 1, 0);
        p[2] += 1; value[7] = (double)pti_fbm(p, 1, 0);
        for (i = 0; i < 12; i++) for (j = 0; j <= i; j++) sum[i][j] += value[i] * value[j];
    }
    for (i = 0; i < 5; i++) for (j = 0; j < i; j++) {
        test_case("octaves %d and %d", i, j);
        CHECK_P(stats_normal_p(sum[i][j] / sqrt(sum[i][i] * sum[j][j]) * sqrt(n)));
    }
    for (i = 8; i < 12; i++) for (j = 8; j < i; j++) {
        test_case("flat octaves %d and %d", i - 8, j - 8);
        CHECK_P(stats_normal_p(sum[i][j] / sqrt(sum[i][i] * sum[j][j]) * sqrt(n)));
    }
    for (i = 5; i < 8; i++) {                            /* neighbours share a face, so a little is right */
        test_case("neighbour %d", i);
        CHECK_NEAR(sum[i][0] / sqrt(sum[i][i] * sum[0][0]), 0, 0.2);
    }
}
/* No seam: across every cell border, at negative coordinates and far out, a step of h changes the value by at most a slope
   times h. Six is above any slope of the first octave; each octave of fBm is half as high and twice as steep. */
static void noise_is_continuous(void) {
    static const double bases[] = { 0, 1, -1, -7, 255, 256, -256, 65535, -65536, 2147483647.0, 2147483648.0, 4294967296.0, -4294967296.0, 1e12 };
    pt_rng rng;
    int b, i, axis, side;
    const double h = 1e-3;
    pt_rng_seed(&rng, 31, 1);
    for (b = 0; b < 14; b++) for (axis = 0; axis < 3; axis++) for (i = 0; i < 50; i++) {
        double p[3], q[3];
        float near_by[3];
        pt_vec3 r = stats_uniform3(&rng);
        p[0] = 20.0 * r.x - 10; p[1] = 20.0 * r.y - 10; p[2] = 20.0 * r.z - 10;
        p[axis] = bases[b];
        for (side = -1; side <= 1; side++) {
            memcpy(q, p, sizeof q);
            q[axis] += side * h;
            near_by[side + 1] = pti_noise(q, 5);
        }
        test_case("axis %d at %g", axis, bases[b]);
        CHECK_NEAR(near_by[0], near_by[1], 6 * h);
        CHECK_NEAR(near_by[2], near_by[1], 6 * h);
        CHECK_NEAR(near_by[0] + near_by[2], 2 * near_by[1], 30 * h * h);    /* smooth too: no crease */
    }
    {
        double last = 0, p[3] = { -3.3, 0.7, 1.9 };
        for (i = 0; i < 8000; i++, last = (double)pti_fbm(p, 5, 0), p[0] += 1e-3)
            if (i) CHECK_NEAR(pti_fbm(p, 5, 0), last, 5 * 6e-3);
    }
}
static void patterns_have_fixed_bits(void) {             /* the same on every machine: a checksum of bits */
    int k, i, j;
    static const uint32_t sums[2] = { 0x752745f9u, 0x504165c7u };
    for (k = 0; k < 2; k++) {
        pt_scene *s = scene_with(solid(noises[k]));
        uint32_t sum = 0, bits;
        for (i = 0; i < 1000; i++) {
            float n = at_p(s, i * 0.171 - 70, i * -0.377 + 12, i * 1.77 - 300);
            memcpy(&bits, &n, sizeof bits);
            sum = pti_hash2(sum, bits);
        }
        pt_scene_destroy(s);
        s = scene_with((pt_texture_desc){ .pattern = noises[k] });
        for (j = 0; j < 100; j++) {
            float n = look(s, j * 0.37, j * 0.11).x;
            memcpy(&bits, &n, sizeof bits);
            sum = pti_hash2(sum, bits);
        }
        CHECK_EQ_U32(sum, sums[k]);
        pt_scene_destroy(s);
    }
}

/* ---- refusals */

static void refused(pt_texture_desc d, const char *word) {
    pt_scene *s = pt_scene_create(NULL);
    static const float one[4] = { 1, 1, 1, 1 };
    pt_add_texture(s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 4, .bits = 32, .pixels = one });
    pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_NOISE });
    test_case("%s", word);
    CHECK_STR(pt_scene_error(s), "");
    CHECK_EQ_INT(pt_add_texture(s, &d).id, 0);
    CHECK(strstr(pt_scene_error(s), "pt_add_texture") != NULL);
    if (!strstr(pt_scene_error(s), word)) FAIL("'%s' is not in: %s", word, pt_scene_error(s));
    CHECK(pt_scene_commit(s) == PT_ERR_ARG);
    pt_scene_destroy(s);
}
static void refusals(void) {
    static const unsigned char p[64] = { 0 };
    float nan = (float)(HUGE_VAL - HUGE_VAL);
    pt_texture none = { 0 }, base = { 1 }, noise = { 2 }, far_one = { 9 };
    pt_texture_desc d = { .width = 2, .height = 2, .channels = 4, .pixels = p }, e;
#define REFUSED(change, word) e = d; change; refused(e, word)
    REFUSED(e.bits = 12, "bits must be 8, 16 or 32, or 0 for 8 (it is 12)");
    REFUSED(e.bits = -8, "bits");
    REFUSED(e.channels = 5, "channels must be 1 to 4 (it is 5)");
    REFUSED(e.channels = 0, "channels");
    REFUSED(e.channel = 5, "channel");
    REFUSED(e.channel = -1, "channel");
    REFUSED(e.width = 65537, "width");
    REFUSED(e.height = 0, "height");
    REFUSED(e.uv_scale[0] = nan, "uv_scale[0]");
    REFUSED(e.uv_scale[1] = -2e12f, "uv_scale[1]");
    REFUSED(e.uv_offset[0] = (float)HUGE_VAL, "uv_offset[0]");
    REFUSED(e.uv_offset[1] = nan, "uv_offset[1]");
    REFUSED(e.uv_rotate_deg = nan, "uv_rotate_deg");
    REFUSED(e.uv_rotate_deg = 36001, "uv_rotate_deg");
    REFUSED(e.wrap_u = (pt_wrap)3, "wrap_u");
    REFUSED(e.wrap_v = (pt_wrap)-1, "wrap_v");
    REFUSED(e.pixels = NULL, "pixels is NULL");
    REFUSED(e.of = base, "only one");
    REFUSED(e.pattern = PT_PATTERN_FBM, "only one");
    REFUSED(e.eval = asked, "only one");
    REFUSED((e.srgb = 1, e.bits = 32), "srgb");
    REFUSED((e.pixels = NULL, e.of = base), "leave them 0");
    memset(&d, 0, sizeof d);
    REFUSED(e.of = none, "pixels is NULL");
    REFUSED(e.of = far_one, "texture 9 does not exist, there are 2");
    REFUSED(e.of = noise, "no pixels");
    REFUSED((e.of = base, e.srgb = 1), "srgb");
    REFUSED((e.of = base, e.channel = 5), "channel");
    REFUSED(e.pattern = (pt_pattern)4, "pattern");
    d.pattern = PT_PATTERN_FBM;
    REFUSED(e.octaves = 17, "octaves");
    REFUSED(e.octaves = -1, "octaves");
    REFUSED(e.frequency = nan, "frequency");
    REFUSED(e.frequency = -1, "frequency");
    REFUSED(e.color_a.y = nan, "color_a");
    REFUSED(e.color_b.z = (float)HUGE_VAL, "color_b");
    REFUSED(e.channel = 4, "channel");
}
/* An allocator with little memory: the largest picture is refused in words, and so is the sRGB table that finds no room. */
static void *modest_alloc(void *user, size_t size, size_t align) {
    if (size > *(const size_t *)user) return NULL;
    return malloc(size + 0 * align);
}
static void modest_free(void *user, void *p, size_t size) { (void)user; (void)size; free(p); }
static void too_large(void) {
    size_t limit = 1 << 16;
    static uint16_t p[4];
    pt_scene_desc desc = { { modest_alloc, modest_free, NULL }, { NULL, NULL } };
    pt_scene *s;
    desc.allocator.user = &limit;
    s = pt_scene_create(&desc);
    CHECK_EQ_INT(pt_add_texture(s, &(pt_texture_desc){ .width = 65536, .height = 65536, .channels = 4, .bits = 16, .pixels = p }).id, 0);
    CHECK(strstr(pt_scene_error(s), "65536 x 65536") || strstr(pt_scene_error(s), "memory"));
    pt_scene_destroy(s);
    s = pt_scene_create(&desc);
    CHECK(pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 2, .channels = 1, .bits = 16, .pixels = p }).id);
    CHECK_EQ_INT(pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 2, .channels = 1, .bits = 16, .srgb = 1, .pixels = p }).id, 0);
    CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_MEMORY);
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
    RUN(every_depth_and_channel);
    RUN(all_16_bit_values);
    RUN(every_wrap);
    RUN(at_the_ends_of_the_floats);
    RUN(transforms);
    RUN(as_gltf_says);
    RUN(texel_steps);
    RUN(views);
    RUN(channels_of_callbacks);
    RUN(means_on_triangles);
    RUN(mean_of_fine_stripes);
    RUN(checkers);
    RUN(noise_stays_in_range);
    RUN(noise_statistics);
    RUN(octaves_do_not_correlate);
    RUN(noise_is_continuous);
    RUN(patterns_have_fixed_bits);
    RUN(refusals);
    RUN(too_large);
}
