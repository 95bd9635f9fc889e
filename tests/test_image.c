/* Pictures: PPM, PFM, Radiance HDR. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "files.h"
#if defined(__linux__)
#include <signal.h>
#include <sys/resource.h>
#endif

/* ---- helpers ---- */

typedef struct sink { unsigned char *data; size_t size, most; int calls; } sink;    /* most: fails beyond; 0 = never */
static int sink_write(void *user, const void *data, size_t size) {
    sink *s = (sink *)user;
    s->calls++;
    if (s->most && s->size + size > s->most) return 1;
    s->data = (unsigned char *)realloc(s->data, s->size + size + 64);
    if (!s->data) abort();
    memcpy(s->data + s->size, data, size);
    s->size += size;
    return 0;
}
static pt_writer writer_to(sink *s) {
    pt_writer w;
    memset(s, 0, sizeof *s);
    w.write = sink_write;
    w.user = s;
    return w;
}
static pt_result load(pt_image *im, const void *data, size_t size) {
    unsigned char *copy = exact_copy(data, size);
    pt_result r;
    memset(im, 0, sizeof *im);
    r = pt_read_image_memory(im, copy, size);
    free(copy);
    if (r != PT_OK) CHECK(!im->pixels && im->width == 0 && im->height == 0 && im->error[0]);
    else CHECK(im->pixels && !im->error[0]);
    return r;
}
static uint32_t bits_of(float x) { uint32_t b; memcpy(&b, &x, sizeof b); return b; }
static float float_of(uint32_t b) { float x; memcpy(&x, &b, sizeof x); return x; }
static float *noise(pt_rng *rng, int width, int height) {    /* over 20 octaves, with runs of equal pixels */
    size_t n = (size_t)width * (size_t)height * 3, i;
    float *p = (float *)malloc(n * sizeof *p);
    if (!p) abort();
    for (i = 0; i < n; i++)
        p[i] = i >= 3 && pt_rng_u32(rng) % 3 ? p[i - 3] : ldexpf(pt_rng_float(rng), (int)(pt_rng_u32(rng) % 20) - 10);
    return p;
}
static const pt_encoding *stops(float n) {               /* of exposure; until the next call */
    static pt_encoding e;
    memset(&e, 0, sizeof e);
    e.exposure_stops = n;
    return &e;
}
/* Text, then bytes. */
static size_t join(unsigned char *out, const char *header, const void *data, size_t size) {
    size_t n = strlen(header);
    memcpy(out, header, n);
    if (size) memcpy(out + n, data, size);
    return n + size;
}
#define HDR "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"

/* ---- PPM ---- */

static int srgb_reference(double x) {
    double v = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return !(x > 0) ? 0 : v >= 1 ? 255 : (int)floor(255 * v + 0.5);
}
static void ppm_rounds_srgb_exactly(void) {
    pti_srgb s;
    uint32_t b, wrong = 0, k, i;
    pti_srgb_init(&s);
    for (b = 0; b < bits_of(1.1f); b += 1013)
        wrong += pti_srgb_byte(&s, float_of(b)) != (unsigned)srgb_reference((double)float_of(b));
    CHECK_EQ_INT(wrong, 0);
    for (k = 1; k < 256; k++) {                          /* the floats beside each step */
        double t = k <= 10 ? (k - 0.5) / 255 / 12.92 : pow(((k - 0.5) / 255 + 0.055) / 1.055, 2.4);
        for (i = 0; i < 7; i++) {
            float x = float_of(bits_of((float)t) + i - 3);
            test_case("step %u, float %u", k, i);
            CHECK_EQ_INT(pti_srgb_byte(&s, x), srgb_reference((double)x));
        }
    }
}
static void ppm_is_what_it_should_be(void) {
    const float rgb[12] = { 0, 1, 0.5f, -1, 2, 1e-9f, 0.25f, 0.18f, 0.0031308f, 0.9999f, 1e30f, -0.0f };
    const unsigned char expected[12] = { 0, 255, 188, 0, 255, 0, 137, 118, 10, 255, 255, 0 };
    float odd[3];
    sink s;
    pt_writer w = writer_to(&s);
    CHECK_EQ_INT(pt_write_ppm_to(&w, rgb, 2, 2, 0), PT_OK);
    CHECK_EQ_INT(s.size, 11 + 12);
    CHECK(!memcmp(s.data, "P6\n2 2\n255\n", 11));
    CHECK(!memcmp(s.data + 11, expected, 12));
    free(s.data);
    odd[0] = (float)NAN; odd[1] = (float)INFINITY; odd[2] = -(float)INFINITY;
    w = writer_to(&s);
    CHECK_EQ_INT(pt_write_ppm_to(&w, odd, 1, 1, stops(-100)), PT_OK);
    CHECK(s.data[11] == 0 && s.data[12] == 255 && s.data[13] == 0);
    free(s.data);
    w = writer_to(&s);
    CHECK_EQ_INT(pt_write_ppm_to(&w, odd, 1, 1, 0), PT_OK);
    CHECK(s.data[11] == 0 && s.data[12] == 255 && s.data[13] == 0);
    free(s.data);
}
static void ppm_exposure_counts_in_stops(void) {
    pt_rng rng;
    float *a, *b;
    sink s, t;
    pt_writer w = writer_to(&s), v = writer_to(&t);
    int i;
    pt_rng_seed(&rng, 1, 1);
    a = noise(&rng, 31, 17);
    b = noise(&rng, 31, 17);
    for (i = 0; i < 31 * 17 * 3; i++) b[i] = a[i] * 8;
    CHECK_EQ_INT(pt_write_ppm_to(&w, a, 31, 17, stops(3)), PT_OK);
    CHECK_EQ_INT(pt_write_ppm_to(&v, b, 31, 17, 0), PT_OK);
    CHECK(s.size == t.size && !memcmp(s.data, t.data, s.size));
    free(a); free(b); free(s.data); free(t.data);
}

/* ---- PFM ---- */

static void pfm_round_trips_bit_for_bit(void) {
    pt_rng rng;
    int width, height, i;
    pt_rng_seed(&rng, 2, 1);
    for (width = 1; width < 60; width += 13) for (height = 1; height < 40; height += 19) {
        size_t n = (size_t)width * (size_t)height * 3;
        float *p = noise(&rng, width, height);
        sink s;
        pt_writer w = writer_to(&s);
        pt_image im;
        for (i = 0; i < (int)n; i++) p[i] = float_of(pt_rng_u32(&rng));       /* NaN, infinity, denormals too */
        CHECK_EQ_INT(pt_write_pfm_to(&w, p, width, height), PT_OK);
        CHECK_EQ_INT(load(&im, s.data, s.size), PT_OK);
        CHECK(im.width == width && im.height == height && im.channels == 3);
        CHECK(!memcmp(im.pixels, p, n * sizeof *p));
        pt_image_free(&im);
        free(p); free(s.data);
    }
}
static void pfm_bytes_are_the_same_everywhere(void) {
    const float rgb[6] = { 1, 2, 3, -4, 0.5f, 1.5f };    /* two rows */
    const unsigned char rows[24] = { 0,0,0x80,0xc0, 0,0,0,0x3f, 0,0,0xc0,0x3f,  0,0,0x80,0x3f, 0,0,0,0x40, 0,0,0x40,0x40 };
    sink s;
    pt_writer w = writer_to(&s);
    CHECK_EQ_INT(pt_write_pfm_to(&w, rgb, 1, 2), PT_OK);
    CHECK_EQ_INT(s.size, 12 + 24);
    CHECK(!memcmp(s.data, "PF\n1 2\n-1.0\n", 12) && !memcmp(s.data + 12, rows, 24));
    free(s.data);
}
static void pfm_headers_vary(void) {
    static const struct { const char *header; int channels, big_endian; } h[] = {
        { "PF\n2 1\n-1.0\n", 3, 0 },       { "PF\n2 1\n1.0\n", 3, 1 },            { "Pf\n2 1\n-1\n", 1, 0 },
        { "Pf 2 1 +2.5e-3 ", 1, 1 },       { "PF\r\n2 1\r\n-1.0\r\n", 3, 0 },     { "PF\n# a comment\n2 1\n-17\n", 3, 0 },
        { "PF # b\n \t2\n\n# c\n#\n1\n-.5\t", 3, 0 }, { "PF\n2 1\n-1.000000\r", 3, 0 },
        { "PF#x\n00002 01\n3.\n", 3, 1 },
        { "PF\n#?RADIANCE\n2 1\n1.0\n", 3, 1 } };        /* ImageMagick's way */
    unsigned char bytes[128], pixels[24];
    size_t i, k, n;
    for (i = 0; i < sizeof h / sizeof h[0]; i++) {
        pt_image im;
        n = 8 * (size_t)h[i].channels;
        test_case("header %d", (int)i);
        memset(pixels, 0, sizeof pixels);
        for (k = 0; k < n; k += 4) { pixels[k + (h[i].big_endian ? 0 : 3)] = 0x40; pixels[k + 1] = (unsigned char)(k + 10); }
        n = join(bytes, h[i].header, pixels, n);
        if (!CHECK_EQ_INT(load(&im, bytes, n), PT_OK)) { printf("    %s\n", im.error); continue; }
        CHECK(im.width == 2 && im.height == 1);
        CHECK_EQ_INT(im.channels, h[i].channels);
        for (k = 0; k < 2 * (size_t)h[i].channels; k++)
            CHECK_EQ_U32(bits_of(im.pixels[k]), h[i].big_endian ? 0x40000000u + ((uint32_t)k * 4 + 10) * 65536u
                                                                : 0x40000000u + ((uint32_t)k * 4 + 10) * 256u);
        pt_image_free(&im);
        memset(&im, 0, sizeof im);
        if (i != 4) CHECK_EQ_INT(load(&im, bytes, n - 1), PT_ERR_FORMAT);    /* after \r, the \n would be taken for data */
        pt_image_free(&im);
    }
}
static void pfm_after_cr_a_newline_may_be_data(void) {
    static const unsigned char file[] = "Pf\n1 1\n-1\r\n\0\x80\x3f";    /* 4 bytes are left after \r: they are the pixel */
    pt_image im;
    CHECK_EQ_INT(load(&im, file, 14), PT_OK);
    if (im.pixels) CHECK_EQ_U32(bits_of(im.pixels[0]), 0x3f80000au);
    pt_image_free(&im);
}

/* ---- Radiance HDR ---- */

static void hdr_round_trips_as_rgbe(void) {
    static const int widths[] = { 1, 7, 8, 9, 127, 128, 129, 300, 1024, 1025, 2050, 32767, 32768, 40000 };
    pt_rng rng;
    size_t i, k;
    pt_rng_seed(&rng, 3, 1);
    for (i = 0; i < sizeof widths / sizeof widths[0]; i++) {
        int width = widths[i], height = width > 5000 ? 2 : 5, bad = 0;
        float *p = noise(&rng, width, height);
        sink s, t;
        pt_writer w = writer_to(&s), v = writer_to(&t);
        pt_image im;
        test_case("width %d", width);
        CHECK_EQ_INT(pt_write_hdr_to(&w, p, width, height), PT_OK);
        if (!CHECK_EQ_INT(load(&im, s.data, s.size), PT_OK)) { printf("    %s\n", im.error); continue; }
        CHECK(im.width == width && im.height == height && im.channels == 3);
        for (k = 0; k < (size_t)width * (size_t)height * 3; k += 3) {
            float most = fmaxf(p[k], fmaxf(p[k + 1], p[k + 2]));
            size_t c;
            for (c = k; c < k + 3; c++) bad += !(fabsf(im.pixels[c] - p[c]) <= most / 255);    /* half of the least step */
        }
        CHECK_EQ_INT(bad, 0);
        CHECK_EQ_INT(pt_write_hdr_to(&v, im.pixels, width, height), PT_OK);   /* what was quantised stays as it is */
        CHECK(s.size == t.size && !memcmp(s.data, t.data, s.size));
        pt_image_free(&im);
        free(p); free(s.data); free(t.data);
    }
}
static void hdr_rgbe_is_nearest(void) {
    static const struct { float in[3]; unsigned char out[4]; } c[] = {
        { { 1, 1, 1 }, { 128, 128, 128, 129 } },
        { { 1, 0.5f, 0.25f }, { 128, 64, 32, 129 } },
        { { 0.999f, 0, 0 }, { 128, 0, 0, 129 } },        /* 255.744 does not fit in a byte */
        { { 0.997f, 0, 0 }, { 255, 0, 0, 128 } },
        { { 0, 0, 0 }, { 0, 0, 0, 0 } },
        { { -1, 3, 0.01f }, { 0, 192, 1, 130 } },
        { { 1.7014118e38f, 1, 0 }, { 255, 0, 0, 255 } },
        { { FLT_MAX, FLT_MAX, 0 }, { 255, 255, 0, 255 } },
        { { 1.7e38f, 0, 0 }, { 255, 0, 0, 255 } },
        { { 2.938736e-39f, 0, 0 }, { 128, 0, 0, 1 } },   /* 2^-128, the least */
        { { 1.4e-39f, 0, 0 }, { 0, 0, 0, 0 } } };
    unsigned char out[4];
    float odd[3];
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pti_rgbe(c[i].in, out);
        test_case("case %d: %d %d %d %d", (int)i, out[0], out[1], out[2], out[3]);
        CHECK(!memcmp(out, c[i].out, 4));
    }
    odd[0] = (float)NAN; odd[1] = (float)INFINITY; odd[2] = -(float)INFINITY;
    pti_rgbe(odd, out);
    CHECK(out[0] == 0 && out[1] == 255 && out[2] == 0 && out[3] == 255);
}
static void hdr_new_rle_packs_runs(void) {
    static float rgb[3000];
    sink s;
    pt_writer w = writer_to(&s);
    size_t i, at = strlen(HDR) + strlen("-Y 1 +X 1000\n");
    pt_image im;
    for (i = 0; i < 3000; i++) rgb[i] = 1;
    CHECK_EQ_INT(pt_write_hdr_to(&w, rgb, 1000, 1), PT_OK);
    CHECK_EQ_INT(s.size, at + 4 + 4 * 2 * 8);            /* 7 runs of 127 and one of 111, for each of the four */
    CHECK(s.data[at] == 2 && s.data[at + 1] == 2 && s.data[at + 2] == 3 && s.data[at + 3] == 232);
    CHECK(s.data[at + 4] == 255 && s.data[at + 5] == 128);
    CHECK_EQ_INT(load(&im, s.data, s.size), PT_OK);
    if (im.pixels) CHECK(!memcmp(im.pixels, rgb, sizeof rgb));
    pt_image_free(&im);
    free(s.data);
}

static void hdr_all_eight_orientations(void) {
    /* the picture is 1 2 3 over 4 5 6; the digits are the order of the pixels in the file */
    static const char *const o[8][2] = {
        { "-Y 2 +X 3", "123456" }, { "-Y 2 -X 3", "321654" }, { "+Y 2 +X 3", "456123" }, { "+Y 2 -X 3", "654321" },
        { "+X 3 -Y 2", "142536" }, { "+X 3 +Y 2", "415263" }, { "-X 3 -Y 2", "362514" }, { "-X 3 +Y 2", "635241" } };
    unsigned char bytes[128], pixels[24];
    char header[80];
    size_t i, k;
    for (i = 0; i < 8; i++) {
        pt_image im;
        test_case("%s", o[i][0]);
        sprintf(header, HDR "%s\n", o[i][0]);
        for (k = 0; k < 6; k++) {
            pixels[4 * k] = (unsigned char)(16 * (o[i][1][k] - '0'));
            pixels[4 * k + 1] = 128;
            pixels[4 * k + 2] = 0;
            pixels[4 * k + 3] = 132;                     /* red is m 2^-4 */
        }
        if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, header, pixels, 24)), PT_OK)) continue;
        CHECK(im.width == 3 && im.height == 2);
        for (k = 0; k < 6; k++) {
            CHECK_NEAR(im.pixels[3 * k], k + 1, 0);
            CHECK_NEAR(im.pixels[3 * k + 1], 8, 0);
        }
        pt_image_free(&im);
    }
}
static void hdr_columns_with_new_rle(void) {             /* X first: a scanline is a column, 9 long, of 2 */
    static const unsigned char data[] = { 2, 2, 0, 9,  137, 128,  9, 0, 1, 2, 3, 4, 5, 6, 7, 8,  137, 0,  137, 129,
                                          2, 2, 0, 9,  137, 64,   9, 8, 7, 6, 5, 4, 3, 2, 1, 0,  137, 0,  137, 129 };
    unsigned char bytes[128];
    pt_image im;
    int y;
    if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, HDR "-X 2 +Y 9\n", data, sizeof data)), PT_OK)) return;
    CHECK(im.width == 2 && im.height == 9);
    for (y = 0; y < 9; y++) {
        CHECK_NEAR(im.pixels[6 * y + 3], 1, 0);          /* the first column is the right one */
        CHECK_NEAR(im.pixels[6 * y], 0.5, 0);
        CHECK_NEAR(im.pixels[6 * y + 4], (8 - y) / 128.0, 0);
        CHECK_NEAR(im.pixels[6 * y + 1], y / 128.0, 0);
    }
    pt_image_free(&im);
}
static void hdr_old_rle_repeats(void) {
    static const unsigned char data[] = { 128, 0, 0, 129,  1, 1, 1, 3,  0, 128, 0, 129,  1, 1, 1, 4,  1, 1, 1, 1,  0, 0,
        128, 129 };
    unsigned char bytes[128];
    pt_image im;
    int x;
    /* 1 + 3 red, 1 + 4 + 256 green, 1 blue */
    if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, HDR "-Y 1 +X 266\n", data, sizeof data)), PT_OK)) return;
    for (x = 0; x < 266; x++) {
        const float *p = im.pixels + 3 * x;
        CHECK(p[0] == (x < 4) && p[1] == (x >= 4 && x < 265) && p[2] == (x == 265));
    }
    pt_image_free(&im);
    CHECK_EQ_INT(load(&im, bytes, join(bytes, HDR "-Y 1 +X 264\n", data, sizeof data)), PT_ERR_FORMAT);
}
static void hdr_scanlines_of_all_kinds_mix(void) {
    unsigned char data[256], bytes[512];
    size_t n = 0;
    int i;
    pt_image im;
    static const unsigned char rle[] = { 2, 2, 0, 8,  136, 128,  8, 0, 1, 2, 3, 4, 5, 6, 7,  136, 0,  136, 129 };
    static const unsigned char old[] = { 128, 0, 0, 129, 1, 1, 1, 7 };
    memcpy(data, old, sizeof old); n += sizeof old;
    memcpy(data + n, rle, sizeof rle); n += sizeof rle;
    for (i = 0; i < 8; i++) { data[n++] = 128; data[n++] = (unsigned char)i; data[n++] = 0; data[n++] = 129; }
    if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, HDR "-Y 3 +X 8\n", data, n)), PT_OK)) return;
    for (i = 0; i < 24; i++) {
        CHECK_NEAR(im.pixels[3 * i], 1, 0);
        CHECK_NEAR(im.pixels[3 * i + 1], i < 8 ? 0 : (i & 7) / 128.0, 0);
    }
    pt_image_free(&im);
}
static void hdr_header_lines_count(void) {
    static const struct { const char *header; double r, g, b; } h[] = {
        { HDR "-Y 1 +X 1\n", 1, 0.5, 0.25 },
        { "#?RGBE\n\n-Y 1 +X 1\n", 1, 0.5, 0.25 },
        { "#?RADIANCE\r\n# made by hand\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n", 1, 0.5, 0.25 },
        { "#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n EXPOSURE=7\nEXPOSURE= 4.0\n\n-Y 1 +X 1\n",
          0.125, 0.0625, 0.03125 },
        { "#?RADIANCE\nCOLORCORR=2 1 0.5\nCOLORCORR= 2 2 2\nEXPOSURE=.5\n\n-Y 1 +X 1\n", 0.5, 0.5, 0.5 },
        { "#?RADIANCE\nGAMMA=1\nVIEW=-vtv -vp 0 0 1\nPRIMARIES=0 0 0 0\nFORMAT= 32-bit_rle_rgbe \n\n -Y  1  +X\t1 \n",
          1, 0.5, 0.25 } };
    static const unsigned char pixel[4] = { 128, 64, 32, 129 };
    unsigned char bytes[256];
    pt_image im;
    size_t i;
    for (i = 0; i < sizeof h / sizeof h[0]; i++) {
        test_case("header %d", (int)i);
        if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, h[i].header, pixel, 4)), PT_OK)) continue;
        CHECK_NEAR(im.pixels[0], h[i].r, 0);
        CHECK_NEAR(im.pixels[1], h[i].g, 0);
        CHECK_NEAR(im.pixels[2], h[i].b, 0);
        pt_image_free(&im);
    }
}
static void hdr_xyz_becomes_rgb(void) {
    /* D65 white is X 0.9505 Y 1 Z 1.089: with e = 129 the mantissas 121.66 128 139.4 */
    static const unsigned char white[4] = { 122, 128, 139, 129 }, red[4] = { 211, 109, 10, 127 };
    unsigned char bytes[128];
    pt_image im;
    const char *header = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n";
    if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, header, white, 4)), PT_OK)) return;
    CHECK_NEAR(im.pixels[0], 1, 0.02);
    CHECK_NEAR(im.pixels[1], 1, 0.02);
    CHECK_NEAR(im.pixels[2], 1, 0.02);
    pt_image_free(&im);
    if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, header, red, 4)), PT_OK)) return;
    CHECK_NEAR(im.pixels[0], 1, 0.01);                   /* red is X 0.4124 Y 0.2126 Z 0.0193 */
    CHECK_NEAR(im.pixels[1], 0, 0.01);
    CHECK_NEAR(im.pixels[2], 0, 0.01);
    pt_image_free(&im);
}

/* ---- what is malformed ---- */

static void malformed_pictures_are_refused_in_words(void) {
#define BYTES(s) s, sizeof(s) - 1
    static const struct { const char *file; size_t size; const char *error; } c[] = {
        { BYTES(""), "memory:1: the file is empty" },
        { BYTES("P"), "memory:1: the file is empty" },
        { BYTES("\x89PNG\r\n"), "memory:1: neither a PFM, a PPM, a PGM nor a Radiance HDR picture" },
        { BYTES("PF"), "memory:1: white space is missing" },
        { BYTES("PF4 4\n-1\n"), "memory:1: white space is missing" },
        { BYTES("PF\n"), "memory:2: a size is missing" },
        { BYTES("PF\n-1 4\n-1\n"), "memory:2: a size is missing" },
        { BYTES("PF\n1\n# no more"), "memory:3: a size is missing" },
        { BYTES("PF\n0 4\n-1\n"), "memory:2: a size is 0" },
        { BYTES("PF\n4 2147483648\n-1\n"), "memory:2: a size is above 2147483647" },
        { BYTES("PF\n4 99999999999999999999999\n-1\n"), "memory:2: a size is above 2147483647" },
        { BYTES("PF\n1 1\nbig\n"), "memory:3: the scale is not a number" },
        { BYTES("PF\n1 1\n."), "memory:3: the scale is not a number" },
        { BYTES("PF\n1 1\n0.0\n"), "memory:3: the scale is 0: its sign should tell the byte order" },
        { BYTES("PF\n1 1\n-1x\n"), "memory:3: the scale does not end in white space" },
        { BYTES("PF\n1 1\n-1"), "memory:3: the scale does not end in white space" },
        { BYTES("PF\n1 1\n-1\n01234567890"), "memory:byte 10: 1 x 1 pixels cannot come from the 11 bytes that are left" },
        { BYTES("PF\n2147483647 2147483647\n-1\n"),
          "memory:byte 28: 2147483647 x 2147483647 pixels cannot come from the 0 bytes that are left" },
        { BYTES("#?"), "memory:1: the header ends early" },
        { BYTES("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"), "memory:3: the header ends early" },
        { BYTES("#?RADIANCE\n\n"), "memory:3: the header ends early" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 1"), "memory:3: the header ends early" },
        { BYTES("#?RADIANCE\n\n\n"), "memory:3: expected a size, such as -Y 512 +X 1024" },
        { BYTES("#?RADIANCE\n\n-Z 1 +X 1\n"), "memory:3: expected a size, such as -Y 512 +X 1024" },
        { BYTES("#?RADIANCE\n\n-Y 1 X 1\n"), "memory:3: expected a size, such as -Y 512 +X 1024" },
        { BYTES("#?RADIANCE\n\n-Y 1 +Y 1\n"), "memory:3: the size has one axis twice" },
        { BYTES("#?RADIANCE\n\n-Y 0 +X 1\n"), "memory:3: a size is 0" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X -1\n"), "memory:3: a size is missing" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 4294967297\n"), "memory:3: a size is above 2147483647" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 1 1\n"), "memory:3: something follows the size" },
        { BYTES("#?RADIANCE\nFORMAT=32-bit_rle_rgb\n\n"),
            "memory:2: FORMAT is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze" },
        { BYTES("#?RADIANCE\nFORMAT=32-bit_rle_rgbef\n\n"),
            "memory:2: FORMAT is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze" },
        { BYTES("#?RADIANCE\nEXPOSURE=\n\n"), "memory:2: 1 numbers are expected" },
        { BYTES("#?RADIANCE\nEXPOSURE=0\n\n"), "memory:2: 0 is no exposure" },
        { BYTES("#?RADIANCE\nEXPOSURE=-2\n\n"), "memory:2: -2 is no exposure" },
        { BYTES("#?RADIANCE\nEXPOSURE=1e999\n\n"), "memory:2: inf is no exposure" },
        { BYTES("#?RADIANCE\nEXPOSURE=1 2\n\n"), "memory:2: the number does not end where it should" },
        { BYTES("#?RADIANCE\nCOLORCORR=1 2\n\n"), "memory:2: 3 numbers are expected" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 1\nabc"), "memory:byte 22: the file ends within a scanline" },
        { BYTES("#?RADIANCE\n\n-Y 2 +X 1\nabcd"), "memory:byte 26: the file ends within a scanline" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 2\n\1\1\1\1abcd"),
            "memory:byte 22: a repeat of 1 where a scanline has 0 pixels and lacks 2" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 3\nabcd\1\1\1\3"),
            "memory:byte 26: a repeat of 3 where a scanline has 1 pixels and lacks 2" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\11abcd"), "memory:byte 22: a scanline is 9 pixels long instead of 8" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\10\211x"), "memory:byte 26: a run of 9 where a scanline lacks 8" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\10\0x"), "memory:byte 26: a run of 0 where a scanline lacks 8" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\10\11xxxxxxxxxx"), "memory:byte 26: a run of 9 where a scanline lacks 8" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\10\210"), "memory:byte 26: the file ends within a scanline" },
        { BYTES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\10\10abc"), "memory:byte 26: the file ends within a scanline" },
        { BYTES("#?RADIANCE\n\n-Y 2147483647 +X 2147483647\nabcdefgh"),
          "memory:byte 40: 2147483647 x 2147483647 pixels cannot come from the 8 bytes that are left" } };
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pt_image im;
        test_case("file %d", (int)i);
        CHECK_EQ_INT(load(&im, c[i].file, c[i].size), PT_ERR_FORMAT);
        CHECK_STR(im.error, c[i].error);
        CHECK(has_place(im.error, "memory"));
        pt_image_free(&im);
    }
}
static void sizes_that_cannot_be_cost_no_memory(void) {
    static const struct { const char *file; size_t size; } c[] = {
        { BYTES("PF\n2147483647 2147483647\n-1\nabcdefghijklmnopqrstuvwxyz") },
        { BYTES("PF\n1431655766 3\n-1\nabcdefghijklmnopqrstuvwxyz") },
        { BYTES("#?RADIANCE\n\n-Y 2147483647 +X 1\nabcdefghijklmnopqrstuvwxyz") },
        /* all of it repeats */
        { BYTES("#?RADIANCE\n\n-Y 1 +X 2147483647\nabcd\1\1\1\xfe\1\1\1\xff\1\1\1\xff\1\1\1\x7f") },
        { BYTES("#?RADIANCE\n\n-Y 65536 +X 65536\n\2\2\2\2\2\2\2\2\2\2\2\2\2") } };
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pt_image im;
        counter n;
        memset(&im, 0, sizeof im);
        im.allocator = counted(&n);
        test_case("file %d", (int)i);
        CHECK_EQ_INT(pt_read_image_memory(&im, c[i].file, c[i].size), PT_ERR_FORMAT);
        CHECK(n.peak < 65536 && n.live == 0);
        pt_image_free(&im);
    }
}

/* Files of all kinds, small. */
#define SAMPLES 7
static sink samples[SAMPLES];
static void make_samples(void) {
    static const unsigned char old[] = { 128, 0, 0, 129, 1, 1, 1, 3, 0, 128, 0, 129, 1, 1, 1, 4, 0, 0, 128, 129 };
    static float grey[20 * 5 * 3];
    pt_rng rng;
    float *p;
    pt_writer w;
    size_t i;
    pt_rng_seed(&rng, 4, 1);
    p = noise(&rng, 20, 5);
    for (i = 0; i < 300; i++) grey[i] = i % 90 < 45 ? 0.5f : 7.0f;
    for (i = 0; i < SAMPLES; i++) {
        w = writer_to(&samples[i]);
        switch (i) {
        case 0: pt_write_pfm_to(&w, p, 20, 5); break;
        case 1: pt_write_hdr_to(&w, p, 20, 5); break;
        case 2: pt_write_hdr_to(&w, p, 5, 20); break;    /* flat */
        case 3: pt_write_hdr_to(&w, grey, 20, 5); break;
        case 4: w.write(w.user, HDR "+X 1 -Y 10\n", strlen(HDR "+X 1 -Y 10\n")); w.write(w.user, old, sizeof old); break;
        case 5: w.write(w.user, "Pf\n3 5\n2.0\n", 11); w.write(w.user, p, 60); break;
        default: w.write(w.user, "#?RADIANCE\nEXPOSURE=2\nCOLORCORR=1 2 3\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 2\n", 72);
                 w.write(w.user, old, 4); w.write(w.user, old, 4); w.write(w.user, old + 8, 4); w.write(w.user, old + 16, 4);
        }
    }
    free(p);
}
static void drop_samples(void) {
    size_t i;
    for (i = 0; i < SAMPLES; i++) free(samples[i].data);
}
static void every_truncation_is_refused(void) {
    size_t i, n;
    make_samples();
    for (i = 0; i < SAMPLES; i++) for (n = 0; n <= samples[i].size; n++) {
        pt_image im;
        pt_result r = load(&im, samples[i].data, n);
        test_case("sample %d, %d of %d bytes: %s", (int)i, (int)n, (int)samples[i].size, im.error);
        CHECK_EQ_INT(r, n == samples[i].size ? PT_OK : PT_ERR_FORMAT);
        CHECK(r == PT_OK || has_place(im.error, "memory"));
        pt_image_free(&im);
    }
    drop_samples();
}
static void damaged_pictures_do_no_harm(void) {
    pt_rng rng;
    int round, loaded = 0;
    pt_rng_seed(&rng, 5, 1);
    make_samples();
    for (round = 0; round < 7000; round++) {
        const sink *s = &samples[round % SAMPLES];
        unsigned char *data = (unsigned char *)malloc(s->size + 64), *copy;
        pt_image im;
        counter n;
        size_t size;
        if (!data) abort();
        memcpy(data, s->data, s->size);
        size = mutate(&rng, data, s->size);
        copy = exact_copy(data, size);
        memset(&im, 0, sizeof im);
        im.allocator = counted(&n);
        test_case("round %d: %s", round, im.error);
        if (pt_read_image_memory(&im, copy, size) == PT_OK) loaded++;
        else CHECK(!im.pixels && n.live == 0 && has_place(im.error, "memory"));
        CHECK(n.peak < 16000000);
        pt_image_free(&im);
        CHECK(n.live == 0 && n.wrong_sizes == 0);
        free(data); free(copy);
    }
    CHECK(loaded > 100 && loaded < 6500);                /* both ways are gone */
    drop_samples();
}
static void memory_may_run_out(void) {
    size_t i, fail, files = 0;
    make_samples();
    for (i = 0; i < SAMPLES * 2; i++) for (fail = 1; ; fail++) {
        const sink *s = &samples[i / 2];
        pt_image im;
        counter n;
        pt_result r;
        memset(&im, 0, sizeof im);
        im.allocator = counted(&n);
        n.fail_at = fail;
        test_case("sample %d, allocation %d", (int)i, (int)fail);
        if (i % 2) {
            file_write("out/test_image.tmp", s->data, s->size);
            r = pt_read_image(&im, "out/test_image.tmp");
        } else r = pt_read_image_memory(&im, s->data, s->size);
        CHECK(r == PT_OK || r == PT_ERR_MEMORY);
        if (r == PT_ERR_MEMORY) {
            CHECK(!im.pixels && n.live == 0);
            CHECK_STR(im.error, i % 2 ? "out/test_image.tmp: out of memory" : "memory: out of memory");
        }
        pt_image_free(&im);
        CHECK(n.live == 0 && n.wrong_sizes == 0);
        files += r == PT_OK;
        if (r == PT_OK || !CHECK(fail < 10)) break;
    }
    CHECK_EQ_INT(files, SAMPLES * 2);
    remove("out/test_image.tmp");
    drop_samples();
}

/* ---- files ---- */

static unsigned char *file_bytes(const char *path, size_t *size) {    /* NULL: no such file */
    FILE *f = fopen(path, "rb");
    unsigned char *p;
    long n;
    if (!f) return NULL;
    fseek(f, 0, SEEK_END);
    n = ftell(f);
    rewind(f);
    p = (unsigned char *)malloc((size_t)n + 1);
    if (!p) abort();
    *size = fread(p, 1, (size_t)n, f);
    fclose(f);
    return p;
}
static void path_twins_write_the_same(void) {
    pt_rng rng;
    float *p;
    int k;
    pt_rng_seed(&rng, 6, 1);
    p = noise(&rng, 33, 21);
    for (k = 0; k < 3; k++) {
        sink s;
        pt_writer w = writer_to(&s);
        unsigned char *bytes;
        size_t size = 0;
        test_case("format %d", k);
        CHECK_EQ_INT(k == 0 ? pt_write_ppm_to(&w, p, 33, 21, stops(1)) : k == 1 ? pt_write_pfm_to(&w, p, 33, 21)
            : pt_write_hdr_to(&w, p, 33, 21), PT_OK);
        CHECK_EQ_INT(k == 0 ? pt_write_ppm("out/test_image.tmp", p, 33, 21, stops(1)) : k == 1
            ? pt_write_pfm("out/test_image.tmp", p, 33, 21)
                            : pt_write_hdr("out/test_image.tmp", p, 33, 21), PT_OK);
        bytes = file_bytes("out/test_image.tmp", &size);
        CHECK(bytes && size == s.size && !memcmp(bytes, s.data, size));
        CHECK(!file_exists("out/test_image.tmp.part"));
        if (k) {
            pt_image a, b;
            memset(&a, 0, sizeof a);
            CHECK_EQ_INT(pt_read_image(&a, "out/test_image.tmp"), PT_OK);
            CHECK_EQ_INT(load(&b, s.data, s.size), PT_OK);
            CHECK(a.pixels && b.pixels && !memcmp(a.pixels, b.pixels, 33 * 21 * 3 * sizeof(float)));
            pt_image_free(&a);
            pt_image_free(&b);
        }
        free(bytes); free(s.data);
    }
    remove("out/test_image.tmp");
    free(p);
}
static void failing_writers_are_heard(void) {
    pt_rng rng;
    float *p;
    size_t most;
    int k;
    pt_rng_seed(&rng, 7, 1);
    p = noise(&rng, 100, 100);
    for (k = 0; k < 3; k++) for (most = 1; most < 30000; most = most * 3 + 5) {
        sink s;
        pt_writer w = writer_to(&s);
        int calls;
        s.most = most;
        CHECK_EQ_INT(k == 0 ? pt_write_ppm_to(&w, p, 100, 100, stops(1)) : k == 1 ? pt_write_pfm_to(&w, p, 100, 100)
            : pt_write_hdr_to(&w, p, 100, 100),
                     PT_ERR_IO);
        calls = s.calls;
        CHECK(s.size <= most && calls <= 1 + (int)(most / 4096) + 1);    /* not asked again after it failed */
        free(s.data);
    }
    free(p);
}
static void a_failed_file_leaves_the_old_one(void) {
    static const char old[] = "this stays";
    static float rgb[64 * 64 * 3];
    unsigned char *bytes;
    size_t size = 0;
    CHECK_EQ_INT(pt_write_ppm("out/no/such/directory.ppm", rgb, 64, 64, 0), PT_ERR_IO);
    CHECK_EQ_INT(pt_write_ppm("out", rgb, 64, 64, 0), PT_ERR_IO);        /* a directory does not give way */
    CHECK(!file_exists("out.part"));
    file_write("out/test_image.tmp", old, sizeof old);
    CHECK_EQ_INT(pt_write_pfm("out/test_image.tmp", rgb, 0, 64), PT_ERR_ARG);
#if defined(__linux__)
    {   /* a disk that is full after 10000 bytes */
        struct rlimit was, small;
        void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
        getrlimit(RLIMIT_FSIZE, &was);
        small = was;
        small.rlim_cur = 10000;
        setrlimit(RLIMIT_FSIZE, &small);
        CHECK_EQ_INT(pt_write_pfm("out/test_image.tmp", rgb, 64, 64), PT_ERR_IO);
        small.rlim_cur = 100;                            /* less than stdio's buffer: only fclose can tell */
        setrlimit(RLIMIT_FSIZE, &small);
        CHECK_EQ_INT(pt_write_pfm("out/test_image.tmp", rgb, 4, 4), PT_ERR_IO);
        setrlimit(RLIMIT_FSIZE, &was);
        signal(SIGXFSZ, handler);
    }
#endif
    CHECK(!file_exists("out/test_image.tmp.part"));
    bytes = file_bytes("out/test_image.tmp", &size);
    CHECK(bytes && size == sizeof old && !memcmp(bytes, old, size));
    free(bytes);
    CHECK_EQ_INT(pt_write_pfm("out/test_image.tmp", rgb, 64, 64), PT_OK);     /* and now it is replaced */
    bytes = file_bytes("out/test_image.tmp", &size);
    CHECK_EQ_INT(size, 14 + 64 * 64 * 12);
    free(bytes);
    remove("out/test_image.tmp");
}
static void devices_are_written_straight(void) {
    static float rgb[64 * 64 * 3];
    if (!file_exists("/dev/full")) SKIP("no /dev/full");
    CHECK_EQ_INT(pt_write_pfm("/dev/full", rgb, 64, 64), PT_ERR_IO);
    CHECK_EQ_INT(pt_write_pfm("/dev/full", rgb, 2, 2), PT_ERR_IO);
    CHECK_EQ_INT(pt_write_pfm("/dev/null", rgb, 64, 64), PT_OK);
    CHECK(file_exists("/dev/full") && file_exists("/dev/null") && !file_exists("/dev/null.part"));
}
static void unreadable_files_are_told(void) {
    char path[400];
    pt_image im;
    memset(&im, 0, sizeof im);
    CHECK_EQ_INT(pt_read_image(&im, "out/missing.hdr"), PT_ERR_IO);
    CHECK_STR(im.error, "out/missing.hdr: cannot open");
    CHECK(!im.pixels);
    if (file_exists(".")) {                              /* where directories can be opened */
        CHECK_EQ_INT(pt_read_image(&im, "out"), PT_ERR_IO);
        CHECK_STR(im.error, "out: cannot read");
    }
    file_write("out/test_image.tmp", "#?RADIANCE\nEXPOSURE=no\n", 23);
    CHECK_EQ_INT(pt_read_image(&im, "out/test_image.tmp"), PT_ERR_FORMAT);
    CHECK_STR(im.error, "out/test_image.tmp:2: 1 numbers are expected");
    remove("out/test_image.tmp");
    memset(path, 'x', sizeof path);
    path[sizeof path - 1] = 0;
    CHECK_EQ_INT(pt_read_image(&im, path), PT_ERR_IO);
    CHECK_STR(im.error + strlen(im.error) - 13, ": cannot open");     /* however long the path is */
    pt_image_free(&im);
}
static void bad_arguments_are_refused(void) {
    static const float rgb[3] = { 1, 1, 1 };
    sink s;
    pt_writer w = writer_to(&s), none;
    pt_image im;
    memset(&none, 0, sizeof none);
    memset(&im, 0, sizeof im);
    CHECK_EQ_INT(pt_write_ppm_to(NULL, rgb, 1, 1, 0), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_ppm_to(&none, rgb, 1, 1, 0), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_ppm_to(&w, NULL, 1, 1, 0), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_ppm_to(&w, rgb, 1, 1, stops((float)NAN)), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_pfm_to(&w, rgb, 0, 1), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_hdr_to(&w, rgb, 1, -1), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_ppm(NULL, rgb, 1, 1, 0), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_image_memory(NULL, "PF", 2), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_image_memory(&im, NULL, 2), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_image(&im, NULL), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_image_memory(&im, NULL, 0), PT_ERR_FORMAT);
    CHECK_EQ_INT(s.calls, 0);
    pt_image_free(&im);
    pt_image_free(NULL);
}
static void an_image_can_be_read_into_again(void) {
    counter n;
    pt_image im;
    memset(&im, 0, sizeof im);
    im.allocator = counted(&n);
    CHECK_EQ_INT(pt_read_image_memory(&im, "Pf\n1 1\n-1\nabcd", 14), PT_OK);
    CHECK_EQ_INT(pt_read_image_memory(&im, "Pf\n1 2\n-1\nabcdefgh", 18), PT_OK);
    CHECK(im.height == 2 && n.live == 1);
    CHECK_EQ_INT(pt_read_image_memory(&im, "Pf\n1 2\n-1\nabcdefg", 17), PT_ERR_FORMAT);
    CHECK(!im.pixels && im.height == 0 && n.live == 0);
    pt_image_free(&im);
}

static void real_environments_load(void) {
    static const struct { const char *path; double brightest; } f[] = {
        { "../shared/data/env/forest.hdr", 1008 }, { "../shared/data/env/sunset.hdr", 6496 },
            { "../shared/data/env/studio.hdr", 0 } };
    size_t i, k;
    int found = 0;
    for (i = 0; i < 3; i++) {
        pt_image im, again;
        float most = 0;
        sink s;
        pt_writer w = writer_to(&s);
        if (!file_exists(f[i].path)) continue;
        found++;
        memset(&im, 0, sizeof im);
        if (!CHECK_EQ_INT(pt_read_image(&im, f[i].path), PT_OK)) { printf("    %s\n", im.error); continue; }
        CHECK(im.width == 1024 && im.height == 512 && im.channels == 3);
        for (k = 0; k < 1024 * 512 * 3; k++) most = fmaxf(most, im.pixels[k]);
        if (f[i].brightest > 0) CHECK_NEAR(most, f[i].brightest, f[i].brightest * 0.005);
        CHECK_EQ_INT(pt_write_hdr_to(&w, im.pixels, 1024, 512), PT_OK);
        CHECK_EQ_INT(load(&again, s.data, s.size), PT_OK);
        CHECK(again.pixels && !memcmp(again.pixels, im.pixels, 1024 * 512 * 3 * sizeof(float)));    /* all of it is RGBE */
        pt_image_free(&again);
        pt_image_free(&im);
        free(s.data);
    }
    if (!found) SKIP("no ../shared/data");
}

void test_image(void) {
    RUN(ppm_rounds_srgb_exactly);
    RUN(ppm_is_what_it_should_be);
    RUN(ppm_exposure_counts_in_stops);
    RUN(pfm_round_trips_bit_for_bit);
    RUN(pfm_bytes_are_the_same_everywhere);
    RUN(pfm_headers_vary);
    RUN(pfm_after_cr_a_newline_may_be_data);
    RUN(hdr_round_trips_as_rgbe);
    RUN(hdr_rgbe_is_nearest);
    RUN(hdr_new_rle_packs_runs);
    RUN(hdr_all_eight_orientations);
    RUN(hdr_columns_with_new_rle);
    RUN(hdr_old_rle_repeats);
    RUN(hdr_scanlines_of_all_kinds_mix);
    RUN(hdr_header_lines_count);
    RUN(hdr_xyz_becomes_rgb);
    RUN(malformed_pictures_are_refused_in_words);
    RUN(sizes_that_cannot_be_cost_no_memory);
    RUN(every_truncation_is_refused);
    RUN(damaged_pictures_do_no_harm);
    RUN(memory_may_run_out);
    RUN(path_twins_write_the_same);
    RUN(failing_writers_are_heard);
    RUN(a_failed_file_leaves_the_old_one);
    RUN(devices_are_written_straight);
    RUN(unreadable_files_are_told);
    RUN(bad_arguments_are_refused);
    RUN(an_image_can_be_read_into_again);
    RUN(real_environments_load);
}
