/* Pictures: PNG, PPM, PFM, Radiance HDR. */
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

/* most: fails beyond that many bytes; fail_at: fails from that call on; 0 = never */
typedef struct sink { unsigned char *data; size_t size, most; int calls, fail_at; } sink;
static int sink_write(void *user, const void *data, size_t size) {
    sink *s = (sink *)user;
    s->calls++;
    if ((s->most && s->size + size > s->most) || (s->fail_at && s->calls >= s->fail_at)) return 1;
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
static const pt_encoding *encoding(float exposure, pt_curve curve, int bits) {   /* until the next call */
    static pt_encoding e;
    e.exposure_stops = exposure;
    e.curve = curve;
    e.bits = bits;
    return &e;
}
static const pt_encoding *stops(float n) { return encoding(n, PT_CURVE_SRGB, 0); }
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

static void encodings_out_of_range_are_refused(void) {
    static const struct { double exposure; int curve, bits, ok; } c[] = {
        { 100, 0, 0, 1 }, { -100, 1, 8, 1 }, { 0, 2, 16, 1 }, { 100.1, 0, 0, 0 }, { -100.1, 0, 0, 0 }, { HUGE_VAL, 0, 0, 0 },
        { -HUGE_VAL, 0, 0, 0 }, { NAN, 0, 0, 0 }, { 0, 3, 0, 0 }, { 0, -1, 0, 0 }, { 0, 0, 1, 0 }, { 0, 0, 32, 0 },
        { 0, 0, -8, 0 } };
    static const float rgb[3] = { 1, 1, 1 };
    size_t i;
    int png;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) for (png = 0; png < 2; png++) {
        pt_encoding e;
        sink s;
        pt_writer w = writer_to(&s);
        e.exposure_stops = (float)c[i].exposure;
        memcpy(&e.curve, &c[i].curve, sizeof e.curve);
        e.bits = c[i].bits;
        test_case("encoding %d, png %d", (int)i, png);
        CHECK_EQ_INT(png ? pt_write_png_to(&w, rgb, 1, 1, &e) : pt_write_ppm_to(&w, rgb, 1, 1, &e),
                     c[i].ok ? PT_OK : PT_ERR_ARG);
        CHECK((s.calls > 0) == c[i].ok);
        free(s.data);
    }
}
static void srgb_16_rounds_exactly(void) {
    uint32_t k, i, wrong = 0;
    for (k = 1; k < 65536; k++) {                        /* the floats beside each step */
        long double v = (k - 0.5L) / 65535, t = v <= 0.04045L ? v / 12.92L : powl((v + 0.055L) / 1.055L, 2.4L);
        for (i = 0; i < 7; i++) {
            float x = float_of(bits_of((float)t) + i - 3);
            if (pti_srgb_16(x) != k - ((long double)x < t)) { wrong++; test_case("step %u, float %u", k, i); }
        }
    }
    CHECK_EQ_INT(wrong, 0);
    for (i = 0; i < 65535; i++)                          /* read, and written again */
        wrong += pti_srgb_16((float)pti_srgb_to_linear(i / 65535.0)) != i;
    CHECK_EQ_INT(wrong, 0);
    CHECK(pti_srgb_16(0) == 0 && pti_srgb_16(-1) == 0 && pti_srgb_16(-0.0f) == 0 && pti_srgb_16((float)NAN) == 0);
    CHECK(pti_srgb_16(1) == 65535 && pti_srgb_16(0.99999994f) == 65535 && pti_srgb_16((float)INFINITY) == 65535);
    CHECK(pti_srgb_16(float_of(1)) == 0 && pti_srgb_16(-(float)INFINITY) == 0);
}

/* ---- curves ---- */

static void filmic_rises_from_black_to_white(void) {
    float before = 0;
    uint32_t b, falls = 0;
    CHECK(pti_filmic(0) == 0 && pti_filmic(-1) == 0 && pti_filmic((float)NAN) == 0 && pti_filmic(-(float)INFINITY) == 0);
    CHECK_NEAR(pti_filmic(0.18f), 0.18, 1e-6);
    CHECK(pti_filmic(9.9f) < 1 && pti_filmic(9.9f) > 0.999f);
    CHECK(pti_filmic(10.02f) == 1 && pti_filmic(FLT_MAX) == 1 && pti_filmic((float)INFINITY) == 1);
    CHECK(pti_filmic(1) > 0.7f && pti_filmic(1) < 0.8f);
    CHECK_NEAR(pti_filmic(0.02f), 0.02 * 0.7231708 * (2.51 * 0.02 * 0.7231708 + 0.03)
        / (0.02 * 0.7231708 * (2.43 * 0.02 * 0.7231708 + 0.59) + 0.14), 1e-9);
    for (b = 1; b < bits_of(20); b += 499) {
        float f = pti_filmic(float_of(b));
        falls += f < before;
        before = f;
    }
    for (b = bits_of(9); b < bits_of(10.1f); b++)        /* where it is flattest */
        falls += pti_filmic(float_of(b + 1)) < pti_filmic(float_of(b));
    CHECK_EQ_INT(falls, 0);
}
/* The legend that stands beside PT_CURVE_FALSE_COLOR. */
static void false_colors_follow_their_legend(void) {
    static const unsigned char legend[13][3] = { { 0, 0, 0 }, { 56, 0, 88 }, { 112, 0, 200 }, { 0, 0, 255 }, { 0, 112, 255 },
        { 0, 208, 224 }, { 0, 160, 64 }, { 144, 224, 0 }, { 255, 240, 0 }, { 255, 144, 0 }, { 224, 0, 0 }, { 255, 112, 176 },
        { 255, 255, 255 } };
    int stop;
    for (stop = -9; stop <= 9; stop++) {
        const unsigned char *color = legend[stop < -6 ? 0 : stop > 6 ? 12 : stop + 6];
        static const float share[3] = { 0.501f, 1, 1.999f };     /* squares of: from half a stop below to half above */
        int k, c;
        for (k = 0; k < 3; k++) for (c = 0; c < 3; c++) {
            float Y = 0.18f * ldexpf(sqrtf(share[k]), stop), rgb[3] = { 0, 0, 0 };
            sink s, t;
            pt_writer w = writer_to(&s), v = writer_to(&t);
            test_case("%d stops, point %d, channel %d", stop, k, c);
            if (c == 0) rgb[0] = rgb[1] = rgb[2] = Y;
            else if (c == 1) rgb[1] = Y / 0.7152f;
            else { rgb[0] = Y / 2 / 0.2126f; rgb[2] = Y / 2 / 0.0722f; }
            CHECK_EQ_INT(pt_write_ppm_to(&w, rgb, 1, 1, encoding(0, PT_CURVE_FALSE_COLOR, 0)), PT_OK);
            CHECK(!memcmp(s.data + 11, color, 3));
            rgb[0] *= 16; rgb[1] *= 16; rgb[2] *= 16;
            CHECK_EQ_INT(pt_write_ppm_to(&v, rgb, 1, 1, encoding(-4, PT_CURVE_FALSE_COLOR, 0)), PT_OK);
            CHECK(!memcmp(t.data + 11, color, 3));
            free(s.data); free(t.data);
        }
    }
    CHECK(!memcmp(pti_false_color((float)NAN), legend[0], 3) && !memcmp(pti_false_color(-1), legend[0], 3));
    CHECK(!memcmp(pti_false_color((float)INFINITY), legend[12], 3) && !memcmp(pti_false_color(0), legend[0], 3));
}

/* ---- PNG: read back by a decoder that is as plain as it can be, and believes nothing ---- */

typedef struct bits_in { const unsigned char *p; size_t size, at; int failed; } bits_in;    /* at: in bits */
static unsigned take(bits_in *b, int n) {
    unsigned v = 0;
    int i;
    for (i = 0; i < n; i++, b->at++) {
        if (b->at / 8 >= b->size) { b->failed = 1; return 0; }
        v |= (unsigned)(b->p[b->at / 8] >> b->at % 8 & 1) << i;
    }
    return v;
}
/* A code by its lengths: a bit more until it is one of those with that many. */
typedef struct huffman { int count[16], symbol[320]; } huffman;
static void huffman_init(huffman *h, const unsigned char *length, int n) {
    int bits, s, k = 0, left = 1;
    memset(h, 0, sizeof *h);
    for (bits = 1; bits < 16; bits++) {
        left *= 2;
        for (s = 0; s < n; s++) if (length[s] == bits) { h->count[bits]++; h->symbol[k++] = s; left--; }
        CHECK(left >= 0);
    }
    CHECK(left == 0 || (k == 1 && h->count[1] == 1));    /* complete, or the one code that may be alone */
}
static int huffman_take(const huffman *h, bits_in *b) {
    int code = 0, first = 0, index = 0, bits;
    for (bits = 1; bits < 16; bits++) {
        code |= (int)take(b, 1);
        if (code - first < h->count[bits]) return h->symbol[index + code - first];
        index += h->count[bits];
        first = (first + h->count[bits]) * 2;
        code *= 2;
    }
    b->failed = 1;
    return 256;
}
static void read_codes(bits_in *b, huffman *symbols, huffman *distances) {
    static const unsigned char order[19] = { 16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15 };
    unsigned char length[19] = { 0 }, lengths[320] = { 0 };
    huffman h;
    int literals = 257 + (int)take(b, 5), count = literals + 1 + (int)take(b, 5), codes = 4 + (int)take(b, 4), i, n, s;
    for (i = 0; i < codes; i++) length[order[i]] = (unsigned char)take(b, 3);
    huffman_init(&h, length, 19);
    for (i = 0; i < count && !b->failed; i += n) {
        s = huffman_take(&h, b);
        n = s < 16 ? 1 : s == 16 ? 3 + (int)take(b, 2) : s == 17 ? 3 + (int)take(b, 3) : 11 + (int)take(b, 7);
        if (i + n > count || (s == 16 && !i)) { b->failed = 1; return; }
        memset(lengths + i, s < 16 ? s : s == 16 ? lengths[i - 1] : 0, (size_t)n);
    }
    CHECK(lengths[256] > 0);
    huffman_init(symbols, lengths, literals);
    huffman_init(distances, lengths + literals, count - literals);
}
static size_t inflate_block(bits_in *b, unsigned char *out, size_t size, size_t most) {
    static const int base[29] = { 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115,
        131, 163, 195, 227, 258 };
    static const int extra[29] = { 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0 };
    huffman symbols, distances;
    int s, run;
    read_codes(b, &symbols, &distances);
    while (!b->failed && (s = huffman_take(&symbols, b)) != 256) {
        if (s < 256) { if (size == most) b->failed = 1; else out[size++] = (unsigned char)s; continue; }
        run = base[s - 257] + (int)take(b, extra[s - 257]);
        if (huffman_take(&distances, b) != 0 || size < 1 || size + (size_t)run > most) { b->failed = 1; break; }
        memset(out + size, out[size - 1], (size_t)run);
        size += (size_t)run;
    }
    return size;
}
/* Just most bytes from a whole zlib stream, or a check fails. */
static int inflate(const unsigned char *data, size_t size, unsigned char *out, size_t most) {
    bits_in b;
    size_t n = 0, i;
    uint32_t a = 1, c = 0, last = 0;
    b.p = data; b.size = size; b.at = 16; b.failed = 0;
    CHECK(size > 6 && data[0] == 0x78 && (data[0] * 256 + data[1]) % 31 == 0 && !(data[1] & 32));
    while (!last && !b.failed) {
        last = take(&b, 1);
        if (!CHECK_EQ_INT(take(&b, 2), 2)) return 0;     /* our own are all of this kind */
        n = inflate_block(&b, out, n, most);
    }
    for (i = 0; i < n; i++) { a = (a + out[i]) % 65521; c = (c + a) % 65521; }
    b.at = (b.at + 7) / 8 * 8;
    for (i = 4; i-- > 0; ) CHECK_EQ_INT(take(&b, 8), (c << 16 | a) >> 8 * i & 255);
    return CHECK(!b.failed) & CHECK_EQ_INT(n, most) & CHECK_EQ_INT(b.at / 8, size);
}
static uint32_t u32_at(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}
static uint32_t crc_of(const unsigned char *p, size_t n) {
    uint32_t crc = 0xffffffffu;
    int k;
    for (; n; n--) for (crc ^= *p++, k = 0; k < 8; k++) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1)));
    return ~crc;
}
static void unfilter(unsigned char *rows, size_t height, size_t row, size_t bpp) {
    size_t y, i;
    for (y = 0; y < height; y++) {
        unsigned char *p = rows + y * (row + 1) + 1;
        const unsigned char *above = y ? p - (row + 1) : p;
        int filter = p[-1];
        CHECK(filter <= 4);
        for (i = 0; i < row; i++) {
            int a = i < bpp ? 0 : p[i - bpp], b = y ? above[i] : 0, c = y && i >= bpp ? above[i - bpp] : 0;
            int g = a + b - c, da = abs(g - a), db = abs(g - b), dc = abs(g - c);
            int guess = filter == 1 ? a : filter == 2 ? b : filter == 3 ? (a + b) / 2 : filter == 0 ? 0
                : da <= db && da <= dc ? a : db <= dc ? b : c;
            p[i] = (unsigned char)(p[i] + guess);
        }
    }
}
/* The samples of a PNG, rows one after another, or NULL after a failed check. */
static unsigned char *png_samples(const sink *s, int width, int height, int bits) {
    size_t row = (size_t)width * 3 * (size_t)bits / 8, size = ((size_t)row + 1) * (size_t)height, at = 8, packed = 0, n, y;
    unsigned char *idat = (unsigned char *)malloc(s->size), *rows = (unsigned char *)malloc(size);
    const char *expected = "IHDRsRGBgAMAIDATIEND";
    int ok;
    if (!idat || !rows) abort();
    CHECK(!memcmp(s->data, "\x89PNG\r\n\x1a\n", 8));
    while (at + 12 <= s->size && *expected) {
        const unsigned char *p = s->data + at;
        n = u32_at(p);
        if (!CHECK(n <= s->size - at - 12) || !CHECK_EQ_U32(u32_at(p + 8 + n), crc_of(p + 4, n + 4))) break;
        if (at == 8) CHECK(n == 13 && u32_at(p + 8) == (uint32_t)width && u32_at(p + 12) == (uint32_t)height && p[16] == bits
                           && p[17] == 2 && !p[18] && !p[19] && !p[20]);
        if (!memcmp(expected, "sRGB", 4)) CHECK(n == 1 && p[8] <= 3);
        if (!memcmp(expected, "gAMA", 4)) CHECK(n == 4 && u32_at(p + 8) == 45455);
        if (!memcmp(p + 4, "IDAT", 4)) { memcpy(idat + packed, p + 8, n); packed += n; }
        else if (!memcmp(expected, "IDAT", 4) && packed) expected += 4;
        if (!CHECK(!memcmp(p + 4, expected, 4))) break;
        if (memcmp(p + 4, "IDAT", 4)) expected += 4;
        at += n + 12;
    }
    ok = CHECK(!*expected && at == s->size) && inflate(idat, packed, rows, size);
    free(idat);
    if (!ok) { free(rows); return NULL; }
    unfilter(rows, (size_t)height, row, (size_t)bits * 3 / 8);
    for (y = 0; y < (size_t)height; y++) memmove(rows + y * row, rows + y * (row + 1) + 1, row);
    return rows;
}
/* A picture of one of many kinds: noise, flat, a slope, stripes, NaN and infinity, anything at all. */
static float *picture(pt_rng *rng, int width, int height, int kind) {
    float *p = noise(rng, width, height);
    size_t n = (size_t)width * (size_t)height * 3, i;
    for (i = 0; i < n; i++) switch (kind) {
        case 1: p[i] = 0.25f; break;
        case 2: p[i] = (float)(i / 3 % (size_t)width) / (float)width + (float)(i % 3) / 7; break;
        case 3: p[i] = i / 30 % 2 ? 0.01f : 0.9f; break;
        case 4: p[i] = i % 5 == 0 ? (float)NAN : i % 7 == 0 ? (float)INFINITY : i % 11 == 0 ? -(float)INFINITY : p[i]; break;
        case 5: p[i] = float_of(pt_rng_u32(rng)); break;
        case 6: p[i] = pt_rng_float(rng); break;
        default: break;
    }
    return p;
}
static void png_holds_the_bytes_of_ppm(void) {
    static const int sizes[][2] = { { 1, 1 }, { 1, 2 }, { 2, 1 }, { 1, 300 }, { 300, 1 }, { 31, 17 }, { 200, 100 },
        { 5460, 1 }, { 5461, 1 }, { 5461, 2 }, { 5462, 1 }, { 1, 4096 }, { 1, 70000 }, { 70000, 1 } };   /* 5461: a block */
    pt_rng rng;
    size_t i;
    int kind, curve;
    pt_rng_seed(&rng, 11, 1);
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; i++) for (kind = 0; kind < (i < 12 ? 7 : 2); kind++) {
        int width = sizes[i][0], height = sizes[i][1];
        float *p = picture(&rng, width, height, kind);
        for (curve = 0; curve < 3; curve++) {
            sink s, t;
            pt_writer w = writer_to(&s), v = writer_to(&t);
            unsigned char *samples;
            size_t n = (size_t)width * (size_t)height * 3;
            test_case("%d x %d, kind %d, curve %d", width, height, kind, curve);
            CHECK_EQ_INT(pt_write_png_to(&w, p, width, height, encoding(1, (pt_curve)curve, 0)), PT_OK);
            CHECK_EQ_INT(pt_write_ppm_to(&v, p, width, height, encoding(1, (pt_curve)curve, 16)), PT_OK);
            samples = png_samples(&s, width, height, 8);
            if (CHECK(samples != NULL)) CHECK(!memcmp(samples, t.data + t.size - n, n));
            CHECK(s.size < 500 + (size_t)height + n + n / 50);     /* what cannot be packed hardly grows */
            if (kind == 1) CHECK(s.size < 500 + n / 100 + (size_t)height * 2);
            free(samples); free(s.data); free(t.data);
        }
        free(p);
    }
}
static void png_of_16_bits_is_exact(void) {
    pt_rng rng;
    int kind, curve, k, c;
    pt_rng_seed(&rng, 12, 1);
    for (kind = 0; kind < 7; kind++) for (curve = 0; curve < 3; curve++) {
        float *p = picture(&rng, 61, 47, kind);
        sink s;
        pt_writer w = writer_to(&s);
        unsigned char *samples;
        int wrong = 0;
        test_case("kind %d, curve %d", kind, curve);
        CHECK_EQ_INT(pt_write_png_to(&w, p, 61, 47, encoding(-1, (pt_curve)curve, 16)), PT_OK);
        samples = png_samples(&s, 61, 47, 16);
        if (CHECK(samples != NULL)) for (k = 0; k < 61 * 47; k++) {
            const float *q = p + 3 * k;
            const unsigned char *color = pti_false_color(pti_luminance(pt_v3(q[0] / 2, q[1] / 2, q[2] / 2)));
            for (c = 0; c < 3; c++) {
                int got = samples[6 * k + 2 * c] * 256 + samples[6 * k + 2 * c + 1];
                wrong += got != (curve == 2 ? color[c] * 257 : (int)pti_srgb_16(curve ? pti_filmic(q[c] / 2) : q[c] / 2));
            }
        }
        CHECK_EQ_INT(wrong, 0);
        free(samples); free(s.data); free(p);
    }
}
static void png_runs_of_every_length(void) {
    static unsigned char raw[200000], back[200000];
    static pti_png z;
    pti_output o;
    sink s;
    pt_writer w = writer_to(&s);
    size_t n = 0, i, packed = 0;
    int run;
    for (run = 1; run < 600; run++) { memset(raw + n, run & 1 ? 7 : 200 + run % 13, (size_t)run); n += (size_t)run; }
    memset(&z, 0, sizeof z);
    o.to = &w; o.used = 0; o.failed = 0;
    z.out = &o;
    z.adler = 1;
    pti_png_bits(&z, 0x0178, 16);
    for (i = 0; i < n; i++) pti_png_byte(&z, raw[i]);
    pti_png_block(&z, 1);
    pti_png_bits(&z, 0, (8 - z.bit_count) & 7);
    for (i = 0; i < 4; i++) pti_png_packed(&z, z.adler >> (24 - 8 * i) & 255);
    pti_png_flush(&z);
    pti_output_flush(&o);
    for (i = 0; i < s.size; ) {                          /* the chunks' contents, one after another */
        size_t size = u32_at(s.data + i);
        memmove(s.data + packed, s.data + i + 8, size);
        packed += size;
        i += size + 12;
    }
    CHECK(inflate(s.data, packed, back, n));
    CHECK(!memcmp(raw, back, n));
    free(s.data);
}
/* The least cost of a code whose lengths may be as long as they like: the sum of all weights that arise when the two least
   ones are joined again and again. */
static uint64_t huffman_cost(const uint32_t *count, int n, int *deepest) {
    uint64_t weight[PTI_PNG_SYMBOLS], cost = 0;
    int depth[PTI_PNG_SYMBOLS] = { 0 }, i, left = 0;
    for (i = 0; i < n; i++) if (count[i]) weight[left++] = count[i];
    while (left > 1) {
        int k;
        for (k = 0; k < 2; k++) for (i = k + 1; i < left; i++) if (weight[i] < weight[k]) {
            uint64_t t = weight[i]; int d = depth[i];
            weight[i] = weight[k]; weight[k] = t;
            depth[i] = depth[k]; depth[k] = d;
        }
        weight[0] += weight[1];
        depth[0] = 1 + (depth[0] > depth[1] ? depth[0] : depth[1]);
        cost += weight[0];
        weight[1] = weight[--left];
        depth[1] = depth[left];
    }
    *deepest = depth[0];
    return cost;
}
static void png_codes_are_the_best_that_fit(void) {
    static pti_png z;
    pt_rng rng;
    int round, s, limited = 0;
    pt_rng_seed(&rng, 13, 1);
    for (round = 0; round < 300; round++) {
        uint64_t cost = 0, least;
        uint32_t kraft = 0, a = 1, b = 1;
        int longest;
        memset(&z, 0, sizeof z);
        for (s = 0; s < PTI_PNG_SYMBOLS; s++) {
            if (round < 20 && s < 5 + round) { z.count[s] = a; b += a; a = b - a; }      /* Fibonacci: deeper than allowed */
            else if (round >= 20 && pt_rng_u32(&rng) % 3 == 0)
                z.count[s] = pt_rng_u32(&rng) >> ((round & 1 ? 18 : 26) + pt_rng_u32(&rng) % 6);
        }
        z.count[256]++;
        if (!z.count[0]) z.count[0] = 1;
        pti_png_code_lengths(&z);
        for (s = 0; s < PTI_PNG_SYMBOLS; s++) {
            CHECK((z.length[s] > 0) == (z.count[s] > 0));
            if (z.length[s]) kraft += 1u << (PTI_PNG_LONGEST - z.length[s]);
            cost += (uint64_t)z.count[s] * z.length[s];
        }
        test_case("round %d", round);
        least = huffman_cost(z.count, PTI_PNG_SYMBOLS, &longest);
        CHECK_EQ_U32(kraft, 1u << PTI_PNG_LONGEST);
        limited += longest > PTI_PNG_LONGEST;
        CHECK(longest <= PTI_PNG_LONGEST ? cost == least
            : cost >= least && cost <= least + least / (round < 20 ? 50 : 1000));
    }
    CHECK(limited > 10 && limited < 280);
}
static void other_programs_read_our_png(void) {
    static const char *const reader[3] = { "pngcheck", "convert", "oiiotool" };
    static const char *const command[3] = { "pngcheck -q out/test_image.png > /dev/null 2>&1",
        "convert out/test_image.png -depth 8 ppm:out/test_image.tmp > /dev/null 2>&1",
        "oiiotool out/test_image.png -d uint8 -o out/test_image_oiio.ppm > /dev/null 2>&1" };
    static const char *const result[3] = { NULL, "out/test_image.tmp", "out/test_image_oiio.ppm" };
    char find[64];
    pt_rng rng;
    float *p;
    int k, curve, found = 0;
    pt_rng_seed(&rng, 14, 1);
    p = noise(&rng, 200, 150);
    for (k = 0; k < 3; k++) {
        sprintf(find, "command -v %s > /dev/null 2>&1", reader[k]);
        if (system(find) != 0) continue;
        found++;
        for (curve = 0; curve < 3; curve++) {
            sink s;
            pt_writer w = writer_to(&s);
            unsigned char *bytes;
            size_t size = 0;
            test_case("%s, curve %d", reader[k], curve);
            CHECK_EQ_INT(pt_write_png("out/test_image.png", p, 200, 150, encoding(2, (pt_curve)curve, k ? 8 : 16)), PT_OK);
            CHECK_EQ_INT(pt_write_ppm_to(&w, p, 200, 150, encoding(2, (pt_curve)curve, 0)), PT_OK);
            if (CHECK_EQ_INT(system(command[k]), 0) && result[k]) {
                bytes = file_bytes(result[k], &size);
                if (CHECK(bytes && size >= 90000)) CHECK(!memcmp(bytes + size - 90000, s.data + s.size - 90000, 90000));
                free(bytes);
                remove(result[k]);
            }
            free(s.data);
        }
    }
    remove("out/test_image.png");
    free(p);
    if (!found) SKIP("neither pngcheck, convert nor oiiotool");
}

/* ---- PPM and PGM, read ---- */

static void ppm_round_trips_byte_for_byte(void) {
    static float rgb[256 * 3];
    unsigned char bytes[256 * 6 + 40], values[256 * 3];
    sink s;
    pt_writer w = writer_to(&s);
    pt_image im;
    size_t i, n;
    pt_rng rng;
    pt_rng_seed(&rng, 15, 1);
    for (i = 0; i < 256 * 3; i++) values[i] = (unsigned char)(i < 256 ? i : pt_rng_u32(&rng));
    n = join(bytes, "P6\n16 16\n255\n", values, 256 * 3);
    CHECK_EQ_INT(load(&im, bytes, n), PT_OK);
    CHECK(im.width == 16 && im.height == 16 && im.channels == 3);
    if (im.pixels) {
        CHECK(im.pixels[0] == 0 && im.pixels[255] == 1);
        CHECK_NEAR(im.pixels[188], pow((188 / 255.0 + 0.055) / 1.055, 2.4), 1e-7);
        CHECK_EQ_INT(pt_write_ppm_to(&w, im.pixels, 16, 16, NULL), PT_OK);
        CHECK(s.size == n && !memcmp(s.data, bytes, n));
    }
    free(s.data);
    pt_image_free(&im);
    w = writer_to(&s);                                   /* and floats, through bytes, come back as near as bytes are */
    for (i = 0; i < 256 * 3; i++) rgb[i] = pt_rng_float(&rng);
    CHECK_EQ_INT(pt_write_ppm_to(&w, rgb, 16, 16, NULL), PT_OK);
    CHECK_EQ_INT(load(&im, s.data, s.size), PT_OK);
    for (i = 0; im.pixels && i < 256 * 3; i++) CHECK_NEAR(im.pixels[i], rgb[i], 0.0046);   /* half the last step */
    free(s.data);
    pt_image_free(&im);
}
static void ppm_headers_and_kinds_vary(void) {
    static const struct { const char *header, *pixels; size_t size; int channels, max, v[6]; } h[] = {
        { "P6\n2 1\n255\n", "\0\1\2\375\376\377", 6, 3, 255, { 0, 1, 2, 253, 254, 255 } },
        { "P5 2 1 255 ", "\200\12", 2, 1, 255, { 128, 10 } },                      /* 10: a newline as a pixel */
        { "P5\n# GIMP\n2 # two\n1\n#\n9\n", "\0\11", 2, 1, 9, { 0, 9 } },
        { "P6\r\n2 1\r\n1\r\n", "\1\0\1\0\1\0", 6, 3, 1, { 1, 0, 1, 0, 1, 0 } },
        { "P6\n2 1\n65535\n", "\0\1\1\0\377\377\0\0\200\0\1\1", 12, 3, 65535, { 1, 256, 65535, 0, 32768, 257 } },
        { "P5\t2 1\t256\t", "\1\0\0\377", 4, 1, 256, { 256, 255 } },
        { "P3\n2 1\n255\n", "0 1 2\n253 254 255\n", 18, 3, 255, { 0, 1, 2, 253, 254, 255 } },
        { "P3 2 1 65535", "\n# comment 9\n1\t256 #\n 65535\r\n00000000 32768 257", 48, 3, 65535,
          { 1, 256, 65535, 0, 32768, 257 } },
        { "P2\n2 1\n4", "\n\n3 4", 5, 1, 4, { 3, 4 } },
        { "P2\n2 1\n4\n", "3 4 five", 8, 1, 4, { 3, 4 } } };                        /* what follows is not looked at */
    unsigned char bytes[128];
    size_t i;
    int k;
    for (i = 0; i < sizeof h / sizeof h[0]; i++) {
        pt_image im;
        test_case("file %d", (int)i);
        if (!CHECK_EQ_INT(load(&im, bytes, join(bytes, h[i].header, h[i].pixels, h[i].size)), PT_OK)) {
            printf("    %s\n", im.error);
            continue;
        }
        CHECK(im.width == 2 && im.height == 1);
        CHECK_EQ_INT(im.channels, h[i].channels);
        for (k = 0; k < 2 * h[i].channels; k++) {
            double v = (double)h[i].v[k] / h[i].max;
            v = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
            CHECK_NEAR(im.pixels[k], v, 6e-8 * v);
        }
        pt_image_free(&im);
    }
}
static void ppm_of_16_bits_becomes_a_png(void) {
    static unsigned char bytes[65536 * 2 + 40];
    static float rgb[65536 * 3];
    unsigned char *samples;
    sink s;
    pt_writer w = writer_to(&s);
    pt_image im;
    size_t i, n = join(bytes, "P5\n256 256\n65535\n", NULL, 0), wrong = 0;
    for (i = 0; i < 65536; i++) { bytes[n++] = (unsigned char)(i >> 8); bytes[n++] = (unsigned char)(i & 255); }
    if (!CHECK_EQ_INT(load(&im, bytes, n), PT_OK)) return;
    for (i = 0; i < 65536 * 3; i++) rgb[i] = im.pixels[i / 3];
    CHECK_EQ_INT(pt_write_png_to(&w, rgb, 256, 256, encoding(0, PT_CURVE_SRGB, 16)), PT_OK);
    samples = png_samples(&s, 256, 256, 16);
    if (CHECK(samples != NULL))
        for (i = 0; i < 65536 * 3; i++) wrong += samples[2 * i] * 256u + samples[2 * i + 1] != i / 3;
    CHECK_EQ_INT(wrong, 0);
    free(samples); free(s.data);
    pt_image_free(&im);
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
static void hdr_takes_whatever_a_float_is(void) {
    pt_rng rng;
    int kind, bad = 0;
    size_t i;
    pt_rng_seed(&rng, 16, 1);
    for (kind = 4; kind <= 5; kind++) {                  /* NaN and infinity; all bits */
        float *p = picture(&rng, 50, 20, kind);
        sink s;
        pt_writer w = writer_to(&s);
        pt_image im;
        CHECK_EQ_INT(pt_write_hdr_to(&w, p, 50, 20), PT_OK);
        if (!CHECK_EQ_INT(load(&im, s.data, s.size), PT_OK)) { free(p); free(s.data); continue; }
        for (i = 0; i < 3000; i++) {
            const float *q = p + i / 3 * 3;
            float most = 0, x = im.pixels[i];
            int k;
            for (k = 0; k < 3; k++) if (q[k] > most) most = q[k];    /* fmaxf hands signalling NaN on */
            bad += !(x >= 0 && x <= 1.6947657e38f) || (!(p[i] > 0) && x != 0) || (p[i] == most && most > 1e-30f
                && !(x >= fminf(most, 1.69e38f) * 0.99f));
        }
        pt_image_free(&im);
        free(p); free(s.data);
    }
    CHECK_EQ_INT(bad, 0);
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
        { BYTES("P1\n1 1\n1\n"), "memory:1: neither a PFM, a PPM, a PGM nor a Radiance HDR picture" },
        { BYTES("P4\n1 1\nx"), "memory:1: neither a PFM, a PPM, a PGM nor a Radiance HDR picture" },
        { BYTES("P\0\n1 1\nx"), "memory:1: neither a PFM, a PPM, a PGM nor a Radiance HDR picture" },
        { BYTES("P6"), "memory:1: white space is missing" },
        { BYTES("P6\n1\n"), "memory:3: a size is missing" },
        { BYTES("P6\n1 0\n255\n"), "memory:2: a size is 0" },
        { BYTES("P6\n1 1\n-1\n"), "memory:3: the largest value is not a number from 1 to 65535" },
        { BYTES("P6\n1 1\n0\nabc"), "memory:3: the largest value is not a number from 1 to 65535" },
        { BYTES("P6\n1 1\n65536\nabcdef"), "memory:3: the largest value is not a number from 1 to 65535" },
        { BYTES("P6\n1 1\n99999999999999999999999\nabcdef"), "memory:3: the largest value is not a number from 1 to 65535" },
        { BYTES("P6\n1 1\n255"), "memory:3: the largest value does not end in white space" },
        { BYTES("P6\n1 1\n255#\nabc"), "memory:3: the largest value does not end in white space" },
        { BYTES("P6\n1 1\n255\nab"), "memory:byte 11: 1 x 1 pixels cannot come from the 2 bytes that are left" },
        { BYTES("P6\n1 1\n256\nabcde"), "memory:byte 11: 1 x 1 pixels cannot come from the 5 bytes that are left" },
        { BYTES("P6\n1 2\n99\nabcdef"), "memory:byte 13: 100 is above the largest value, 99" },
        { BYTES("P5\n1 2\n258\n\1\2\1\3"), "memory:byte 13: 259 is above the largest value, 258" },
        { BYTES("P3\n1 1\n255\n1 2\n256"), "memory:5: 256 is above the largest value, 255" },
        { BYTES("P3\n1 1\n255\n1 2 # 3\n  "), "memory:5: the file ends within the pixels" },
        { BYTES("P3\n1 1\n255\n1 -2 3\n"), "memory:4: a value is not a whole number" },
        { BYTES("P3\n1 1\n255\n1 2.5 3\n"), "memory:4: white space is missing" },
        { BYTES("P2\n1 1\n255"), "memory:3: 1 x 1 pixels cannot come from the 0 bytes that are left" },
        { BYTES("P2\n4 1\n255\n1 2 3"), "memory:3: 4 x 1 pixels cannot come from the 6 bytes that are left" },
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
        { BYTES("P6\n2147483647 2147483647\n255\nabcdefghijklmnopqrstuvwxyz") },
        { BYTES("P5\n2147483647 2147483647\n65535\nabcdefghijklmnopqrstuvwxyz") },
        { BYTES("P3\n2147483647 2147483647\n255\n1 2 3 4 5 6 7 8 9 10 11 12 13\n") },
        { BYTES("P2\n2147483647 1\n255\n1 2 3 4 5 6 7 8 9 10 11 12 13\n") },
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
#define SAMPLES 11
#define TEXT_SAMPLES 9        /* from here on their last digit may be missing, and nobody can know */
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
        case 7: pt_write_ppm_to(&w, p, 20, 5, NULL); break;
        case 8: w.write(w.user, "P5\n# grey\n3 5\n65535\n", 20); w.write(w.user, p, 30); break;
        case 9: w.write(w.user, "P3\n3 2\n255\n255 0 1 2 3 4 17 18 19\n# half\n20 200 201 202 203 204 205 206 207", 76);
                break;
        case 10: w.write(w.user, "P2 5 2 1000 0 1000 1 999 998\n3 4 5 6 700", 39); break;
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
        if (i < TEXT_SAMPLES || n + 4 < samples[i].size || n == samples[i].size)
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
    for (round = 0; round < 11000; round++) {
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
    CHECK(loaded > 100 && loaded < 10000);                /* both ways are gone */
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

static pt_result write_as(int format, const pt_writer *w, const float *rgb, int width, int height) {
    if (format == 0) return pt_write_ppm_to(w, rgb, width, height, stops(1));
    if (format == 1) return pt_write_pfm_to(w, rgb, width, height);
    if (format == 2) return pt_write_hdr_to(w, rgb, width, height);
    return pt_write_png_to(w, rgb, width, height, encoding(1, PT_CURVE_FILMIC, 16));
}
static void path_twins_write_the_same(void) {
    pt_rng rng;
    float *p;
    int k;
    pt_rng_seed(&rng, 6, 1);
    p = noise(&rng, 33, 21);
    for (k = 0; k < 4; k++) {
        sink s;
        pt_writer w = writer_to(&s);
        unsigned char *bytes;
        size_t size = 0;
        const char *path = "out/test_image.tmp";
        test_case("format %d", k);
        CHECK_EQ_INT(write_as(k, &w, p, 33, 21), PT_OK);
        CHECK_EQ_INT(k == 0 ? pt_write_ppm(path, p, 33, 21, stops(1)) : k == 1 ? pt_write_pfm(path, p, 33, 21)
            : k == 2 ? pt_write_hdr(path, p, 33, 21)
                     : pt_write_png(path, p, 33, 21, encoding(1, PT_CURVE_FILMIC, 16)), PT_OK);
        bytes = file_bytes("out/test_image.tmp", &size);
        CHECK(bytes && size == s.size && !memcmp(bytes, s.data, size));
        CHECK(!file_exists("out/test_image.tmp.part"));
        if (k < 3) {
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
    for (k = 0; k < 4; k++) for (most = 1; ; most++) {   /* the call numbered most fails */
        sink s;
        pt_writer w = writer_to(&s);
        pt_result r;
        s.fail_at = (int)most;
        test_case("format %d, call %d", k, s.fail_at);
        r = write_as(k, &w, p, 60, 60);
        CHECK_EQ_INT(s.calls, r == PT_OK ? s.fail_at - 1 : s.fail_at);       /* not asked again after it failed */
        free(s.data);
        if (r == PT_OK) break;
        CHECK_EQ_INT(r, PT_ERR_IO);
    }
    for (k = 0; k < 4; k++) for (most = 1; most < (k == 3 ? 10000 : 30000); most = most * 3 + 5) {
        sink s;
        pt_writer w = writer_to(&s);
        int calls;
        s.most = most;
        CHECK_EQ_INT(write_as(k, &w, p, 100, 100), PT_ERR_IO);
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
        CHECK_EQ_INT(pt_write_png("out/test_image.tmp", rgb, 64, 64, NULL), PT_ERR_IO);
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
    CHECK_EQ_INT(pt_write_png_to(&w, rgb, 0, 1, NULL), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_png_to(&w, NULL, 1, 1, NULL), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_png_to(NULL, rgb, 1, 1, NULL), PT_ERR_ARG);
    CHECK_EQ_INT(pt_write_png(NULL, rgb, 1, 1, NULL), PT_ERR_ARG);
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
    RUN(encodings_out_of_range_are_refused);
    RUN(srgb_16_rounds_exactly);
    RUN(filmic_rises_from_black_to_white);
    RUN(false_colors_follow_their_legend);
    RUN(png_holds_the_bytes_of_ppm);
    RUN(png_of_16_bits_is_exact);
    RUN(png_runs_of_every_length);
    RUN(png_codes_are_the_best_that_fit);
    RUN(other_programs_read_our_png);
    RUN(ppm_round_trips_byte_for_byte);
    RUN(ppm_headers_and_kinds_vary);
    RUN(ppm_of_16_bits_becomes_a_png);
    RUN(pfm_round_trips_bit_for_bit);
    RUN(pfm_bytes_are_the_same_everywhere);
    RUN(pfm_headers_vary);
    RUN(pfm_after_cr_a_newline_may_be_data);
    RUN(hdr_round_trips_as_rgbe);
    RUN(hdr_rgbe_is_nearest);
    RUN(hdr_takes_whatever_a_float_is);
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
