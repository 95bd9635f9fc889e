/* >>film: sums that are exact, whatever the order and the number of samples. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"

/* The same sum, bit by bit: a number in units of 2^-64, 32 bits a limb. */
#define LIMBS 6
typedef struct big { uint32_t limb[LIMBS]; } big;
static void big_add_bit(big *b, int bit) {
    int i = bit / 32;
    uint64_t carry = (uint64_t)1 << bit % 32;
    for (; carry && i < LIMBS; i++) {
        carry += b->limb[i];
        b->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
}
static void big_add_float(big *b, float x) {             /* rounded down to a whole unit */
    int e, k;
    double m = frexp((double)x, &e);                     /* x = m 2^e, m in [1/2, 1) */
    for (k = 1; k <= 24; k++) {
        m *= 2;
        if (m < 1) continue;
        m -= 1;
        if (e - k + 64 >= 0) big_add_bit(b, e - k + 64);
    }
}
static int big_is(const big *b, pti_sum s) {
    return b->limb[0] == (uint32_t)s.lo && b->limb[1] == s.lo >> 32 && b->limb[2] == (uint32_t)s.hi && b->limb[3] == s.hi >> 32
        && b->limb[4] == 0 && b->limb[5] == 0;
}
static double big_value(const big *b) {
    double v = 0;
    int i;
    for (i = LIMBS - 1; i >= 0; i--) v += ldexp((double)b->limb[i], 32 * i - 64);
    return v;
}

static float random_float(pt_rng *r, int kind) {
    double u = pt_rng_u32(r) * (1.0 / 4294967296.0);
    float x;
    uint32_t bits;
    if (kind == 0) return (float)u;
    if (kind == 1) return (float)pow(10, 24 * u - 12);   /* to the largest there is */
    do {                                                 /* any float from 0 to it */
        bits = pt_rng_u32(r) >> 1;
        memcpy(&x, &bits, sizeof x);
    } while (!(x >= 0 && x <= PTI_MAX_RADIANCE));
    return x;
}
static int same_pixel(const pti_pixel *a, const pti_pixel *b) { return !memcmp(a->rgb, b->rgb, sizeof a->rgb) && a->count == b->count; }

static void sums_are_exact(void) {
    pt_rng r;
    int kind, i, k;
    pt_rng_seed(&r, 1, 1);
    for (kind = 0; kind < 3; kind++) {
        pti_pixel p;
        big b[3];
        int wrong = 0, far = 0;
        memset(&p, 0, sizeof p);
        memset(b, 0, sizeof b);
        for (i = 0; i < 100000; i++) {
            float c[3];
            for (k = 0; k < 3; k++) { c[k] = random_float(&r, kind); big_add_float(&b[k], c[k]); }
            CHECK(pti_pixel_add(&p, pt_v3(c[0], c[1], c[2]), 1));
            for (k = 0; k < 3; k++) {
                double want = big_value(&b[k]) / (i + 1), got = (double)pti_sum_mean(p.rgb[k], p.count);
                wrong += !big_is(&b[k], p.rgb[k]);
                far += fabs(got - want) > want * 0.50001 / 8388608;    /* half a float's last place */
            }
        }
        test_case("kind %d", kind);
        CHECK_EQ_INT(wrong, 0);
        CHECK_EQ_INT(far, 0);
        CHECK_EQ_INT(p.count, 100000);
    }
}
static void single_values(void) {                        /* each alone: powers of two, their neighbours, the ends of the range */
    int e, k, wrong = 0, inexact = 0;
    for (e = -149; e <= 39; e++)
        for (k = -1; k <= 1; k++) {
            float x = (float)ldexp(1, e);
            pti_pixel p;
            big b;
            x = k < 0 ? nextafterf(x, 0) : k > 0 ? nextafterf(x, 1e30f) : x;
            memset(&p, 0, sizeof p);
            memset(&b, 0, sizeof b);
            big_add_float(&b, x);
            if (pti_pixel_add(&p, pt_v3(x, 0, x), 1) != 1) wrong++;
            wrong += !big_is(&b, p.rgb[0]) || !big_is(&b, p.rgb[2]) || p.rgb[1].hi || p.rgb[1].lo;
            if (e >= -40) inexact += pti_sum_mean(p.rgb[0], 1) != x;   /* 24 bits above 2^-64 */
        }
    CHECK_EQ_INT(wrong, 0);
    CHECK_EQ_INT(inexact, 0);
    CHECK(pti_sum_mean(pti_sum_of(0), 0) == 0);
}
static void order_does_not_matter(void) {
    enum { N = 5000 };
    static pt_vec3 c[N];
    pti_pixel forth, back, parts[3], merged;
    pt_rng r;
    int i, k;
    memset(&forth, 0, sizeof forth);
    back = forth; parts[0] = parts[1] = parts[2] = merged = forth;
    pt_rng_seed(&r, 2, 1);
    for (i = 0; i < N; i++) c[i] = pt_v3(random_float(&r, 1), random_float(&r, 2), random_float(&r, 0));
    for (i = 0; i < N; i++) { pti_pixel_add(&forth, c[i], 1); pti_pixel_add(&back, c[N - 1 - i], 1); pti_pixel_add(&parts[i * 7 % 3], c[i], 1); }
    for (i = 2; i >= 0; i--) {
        for (k = 0; k < 3; k++) pti_sum_add(&merged.rgb[k], parts[i].rgb[k]);
        merged.count += parts[i].count;
    }
    CHECK(same_pixel(&forth, &back));
    CHECK(same_pixel(&forth, &merged));
}
static void a_million_samples_do_not_drift(void) {
    static const float value[3] = { 0.1f, 16777216.0f * 3, 1e-6f };
    pti_pixel p;
    int i;
    memset(&p, 0, sizeof p);
    for (i = 0; i < 1000000; i++) pti_pixel_add(&p, pt_v3(value[0], value[1], value[2]), 1);
    CHECK(pti_sum_mean(p.rgb[0], p.count) == value[0]);
    CHECK(pti_sum_mean(p.rgb[1], p.count) == value[1]);
    CHECK(pti_sum_mean(p.rgb[2], p.count) == value[2]);
    for (i = 0; i < 1000000; i++) pti_pixel_add(&p, pt_v3(0, 0, PTI_MAX_RADIANCE), 1);        /* no overflow either */
    CHECK(pti_sum_mean(p.rgb[0], p.count) == value[0] / 2);
    CHECK_NEAR(pti_sum_mean(p.rgb[2], p.count) / (PTI_MAX_RADIANCE / 2), 1, 1e-7);
}
static void unfit_samples_are_black(void) {
    volatile float zero = 0;
    const float nan = zero / zero, inf = 1 / zero;
    const float bad[] = { nan, -nan, inf, -inf, -1, -1e-45f, 1.0000001e12f, 3e38f };
    pti_pixel p;
    int i, k, n = 0;
    memset(&p, 0, sizeof p);
    for (i = 0; i < (int)(sizeof bad / sizeof bad[0]); i++)
        for (k = 0; k < 3; k++) {
            CHECK_EQ_INT(pti_pixel_add(&p, pt_v3(k == 0 ? bad[i] : 1, k == 1 ? bad[i] : 1, k == 2 ? bad[i] : 1), 1), 0);
            n++;
        }
    CHECK_EQ_INT(p.count, n);
    for (k = 0; k < 3; k++) CHECK(p.rgb[k].hi == 0 && p.rgb[k].lo == 0);
    CHECK_EQ_INT(pti_pixel_add(&p, pt_v3(1e12f, 1e-45f, -0.0f), 1), 1);   /* the ends: all of them fit */
    CHECK(p.rgb[0].hi == (uint64_t)1e12f && p.rgb[0].lo == 0);
    CHECK(p.rgb[1].hi == 0 && p.rgb[1].lo == 0);
    CHECK(p.rgb[2].hi == 0 && p.rgb[2].lo == 0);
    CHECK(pti_sum_mean(p.rgb[0], (uint32_t)(n + 1)) == (float)((double)1e12f / (n + 1)));
}

/* ---- negative samples ---- */

static void negative_samples_cancel_exactly(void) {      /* in any order, down to the last bit */
    enum { N = 3000 };
    static pt_vec3 c[N];
    pti_pixel p, q, zero;
    pt_rng r;
    int i, k, wrong = 0;
    memset(&zero, 0, sizeof zero);
    p = q = zero;
    pt_rng_seed(&r, 3, 1);
    for (i = 0; i < N; i++) c[i] = pt_v3(random_float(&r, 1), random_float(&r, 2), random_float(&r, 0));
    for (i = 0; i < N; i++) CHECK_EQ_INT(pti_pixel_add(&p, c[i], -1), 1);
    for (k = 0; k < 3; k++) CHECK(p.rgb[k].hi >> 63 == 1 && pti_sum_mean(p.rgb[k], p.count) < 0);
    for (i = 0; i < N; i++) pti_pixel_add(&q, c[i], 1);
    for (k = 0; k < 3; k++) CHECK(pti_sum_mean(q.rgb[k], N) == -pti_sum_mean(p.rgb[k], N));
    for (i = N - 1; i >= 0; i--) pti_pixel_add(&p, c[i], 1);
    CHECK_EQ_INT(memcmp(p.rgb, zero.rgb, sizeof p.rgb), 0);
    for (i = 0; i < N; i++) {                            /* each alone, and weighed */
        float w = 1.5f - 3 * random_float(&r, 0), want = c[i].x * fabsf(w);
        p = zero;
        pti_pixel_add(&p, c[i], w);
        wrong += want > 1e-10f && fabsf(pti_sum_mean(p.rgb[0], 1) - (w < 0 ? -want : want)) > want * 1e-6f;
    }
    CHECK_EQ_INT(wrong, 0);
    CHECK_EQ_INT(pti_pixel_add(&p, pt_v3(-1, 1, 1), -1), 0);          /* radiance must still be positive */
    p = zero;
    for (i = 0; i < 1000000; i++) pti_pixel_add(&p, pt_v3(PTI_MAX_RADIANCE, 0, 0), -1.2f);
    CHECK_NEAR(pti_sum_mean(p.rgb[0], p.count) / -1.2e12f, 1, 1e-6);
}

/* ---- filters ---- */

static const char *const filter_names[] = { "default", "box", "tent", "gaussian", "mitchell", "blackman-harris" };
/* What the comments promise, by the definitions. */
static double filter_by_definition(pt_filter kind, double x, double r) {
    double a = fabs(x), t;
    if (a >= r) return 0;
    switch (kind) {
    case PT_FILTER_TENT: return 1 - a / r;
    case PT_FILTER_GAUSSIAN: t = r / 3; return exp(-x * x / (2 * t * t)) - exp(-r * r / (2 * t * t));
    case PT_FILTER_MITCHELL: {
        const double B = 1 / 3.0, C = 1 / 3.0;
        t = 2 * a / r;
        if (t < 1) return ((12 - 9 * B - 6 * C) * t * t * t + (-18 + 12 * B + 6 * C) * t * t + 6 - 2 * B) / 6;
        return ((-B - 6 * C) * t * t * t + (6 * B + 30 * C) * t * t + (-12 * B - 48 * C) * t + 8 * B + 24 * C) / 6;
    }
    case PT_FILTER_BLACKMAN_HARRIS:
        t = (x / r + 1) / 2;
        return 0.35875 - 0.48829 * cos(2 * STATS_PI * t) + 0.14128 * cos(4 * STATS_PI * t) - 0.01168 * cos(6 * STATS_PI * t);
    default: return 1;
    }
}
#define EACH_FILTER(kind) for (kind = 0; kind <= PT_FILTER_BLACKMAN_HARRIS; kind++)

typedef struct filter_totals { double area, absolute, variance; } filter_totals;       /* variance: of |f| as a density */
static filter_totals totals_of(pt_filter kind, double r) {
    enum { N = 200000 };
    filter_totals t = { 0, 0, 0 };
    int i;
    for (i = 0; i < N; i++) {
        double x = (2 * (i + 0.5) / N - 1) * r, f = filter_by_definition(kind, x, r);
        t.area += f * 2 * r / N;
        t.absolute += fabs(f) * 2 * r / N;
        t.variance += x * x * fabs(f) * 2 * r / N;
    }
    t.variance /= t.absolute;
    return t;
}
/* Offsets against |f| by chi-squared in 100 cells, with the sign that f has there and a weight that makes up for it. */
static void offsets_follow_the_filter(void) {
    static const float radius[] = { 0, 0.75f, 3 };
    enum { CELLS = 100, N = 200000 };
    int kind, k, i, j;
    EACH_FILTER(kind) for (k = 0; k < 3; k++) {
        static pti_filter f;
        stats_cell cells[CELLS];
        filter_totals t;
        double sum = 0, r;
        int outside = 0, wrong_sign = 0;
        pt_rng rng;
        pti_filter_make(&f, (pt_filter)kind, radius[k]);
        r = (double)f.radius;
        t = totals_of((pt_filter)kind, r);
        test_case("%s, radius %g", filter_names[kind], r);
        if (k) CHECK(f.radius == radius[k]);
        CHECK_NEAR(f.weight, t.absolute * t.absolute / (t.area * t.area), 2e-3);
        CHECK((f.weight == 1) == (kind != PT_FILTER_MITCHELL));
        memset(cells, 0, sizeof cells);
        for (i = 0; i < CELLS; i++)
            for (j = 0; j < 100; j++) {
                double x = (2 * (i + (j + 0.5) / 100) / CELLS - 1) * r;
                cells[i].expected += fabs(filter_by_definition((pt_filter)kind, x, r)) * 2 * r / (100 * CELLS) * N / t.absolute;
            }
        pt_rng_seed(&rng, 4, (uint64_t)(10 * kind + k));
        for (i = 0; i < N; i++) {
            float w = 1, x = pti_filter_sample(&f, pt_rng_float(&rng), &w);
            double value = filter_by_definition((pt_filter)kind, (double)x, r);
            int cell = (int)(((double)x / r + 1) / 2 * CELLS);
            outside += !(fabs((double)x) <= r * (1 + 1e-6));
            wrong_sign += fabs(value) > 2e-3 && (value < 0) != (w < 0);
            cells[cell < 0 ? 0 : cell >= CELLS ? CELLS - 1 : cell].observed++;
            sum += (double)x;
        }
        CHECK_EQ_INT(outside, 0);
        CHECK_EQ_INT(wrong_sign, 0);
        CHECK_P(stats_chi2(cells, CELLS));
        CHECK_P(stats_z_test(sum / N, 0, sqrt(t.variance), N));
    }
}
static double pdf_integral(const pti_filter *f, double a, double b) {
    double sum = 0;
    int i;
    for (i = 0; i < 100; i++) sum += (double)pti_pdf_filter(f, (float)(a + (i + 0.5) / 100 * (b - a))) * (b - a) / 100;
    return sum;
}
/* The numbers of [0,1) keep their order, so strata stay strata; what lies below u is u; both sides are alike. */
static void filters_are_inversions(void) {
    int kind, i;
    EACH_FILTER(kind) {
        static pti_filter f;
        double below = 0;
        float last = -100, w = 1;
        int unordered = 0, uneven = 0;
        pti_filter_make(&f, (pt_filter)kind, 0);
        test_case("%s", filter_names[kind]);
        for (i = 1; i < 1 << 12; i++) {
            float u = (float)i / 4096, x = pti_filter_sample(&f, u, &w), mirrored = pti_filter_sample(&f, 1 - u, &w);
            unordered += x < last;
            uneven += fabsf(x + mirrored) > 0;           /* the first moment is 0 to the bit */
            if (i > 1) below += pdf_integral(&f, (double)last, (double)x);
            else below = (double)u;
            if (!(fabs(below - (double)u) < 2e-3)) { FAIL("%g lies below %g", below, (double)u); break; }
            last = x;
        }
        CHECK_EQ_INT(unordered, 0);
        CHECK_EQ_INT(uneven, 0);
    }
    {   /* the box is the pixel, to the bit */
        static pti_filter f;
        float w = 1;
        int wrong = 0;
        pti_filter_make(&f, PT_FILTER_DEFAULT, 0);
        for (i = 0; i < 1 << 24; i += 97) { float u = (float)i / 16777216; wrong += 0.5f + pti_filter_sample(&f, u, &w) != u; }
        CHECK_EQ_INT(wrong, 0);
        CHECK(w == 1);
    }
}
static void mitchell_integrates_to_one(void) {           /* the mean weight of a sample, in both axes */
    static pti_filter f;
    double sum = 0, sums = 0;
    int i;
    pti_filter_make(&f, PT_FILTER_MITCHELL, 0);
    for (i = 0; i < 1 << 16; i++) {
        float w = 1;
        pti_filter_sample(&f, ((float)i + 0.5f) / 65536, &w);
        sum += (double)w / 65536;
    }
    sums = sum * sum * (double)f.weight;
    CHECK_NEAR(sums, 1, 1e-4);
    CHECK(f.weight > 1.1f && f.weight < 1.5f);
}

/* ---- pictures through filters ---- */

static void constants_stay(void) {
    static float rgb[16 * 16 * 3];
    int kind;
    EACH_FILTER(kind) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 0), pt_v3(0, 0, -1), 40, 16, 256);
        stats_moments m = { 0, 0, 0 };
        int i, wrong = 0;
        sky(s, 0.7f);
        d.filter = (pt_filter)kind; d.filter_radius = kind == PT_FILTER_TENT ? 2.5f : 0;
        d.sampler = PT_SAMPLER_RANDOM;
        test_case("%s", filter_names[kind]);
        if (commit(s) && render(s, &d, rgb, NULL)) {
            for (i = 0; i < 16 * 16; i++) { stats_push(&m, (double)rgb[3 * i]); wrong += rgb[3 * i] != 0.7f; }
            if (kind != PT_FILTER_MITCHELL) CHECK_EQ_INT(wrong, 0);
            else { CHECK(wrong > 200); CHECK_P(stats_t_test(&m, (double)0.7f)); CHECK(stats_error(&m) < 0.005); }
        }
        pt_scene_destroy(s);
    }
}
/* A lamp fills the half plane x < 0, an 0.4 of a pixel right of the middle of a column: each column shows the integral of
   the filter up to the edge. Mitchell overshoots, and goes below zero in the dark. */
static void a_step_edge_is_the_filters_integral(void) {
    static float rgb[16 * 16 * 3];
    int kind, x, y, i;
    EACH_FILTER(kind) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 0, 5), pt_v3(0, 0, 0), 0, 16, 1024);
        double least = 1, most = 0, r;
        static pti_filter f;
        d.camera.projection = PT_CAMERA_ORTHOGRAPHIC; d.camera.height = 16;      /* a pixel is a metre */
        d.camera.eye.x = d.camera.target.x = 0.1f;       /* column 7, from -0.9 to 0.1, has its middle at -0.4 */
        d.filter = (pt_filter)kind;
        pt_add_quad(s, pt_v3(-100, -100, 0), pt_v3(100, 0, 0), pt_v3(0, 200, 0), lamp(s, 1, 1));
        pti_filter_make(&f, (pt_filter)kind, 0);
        r = (double)f.radius;
        test_case("%s", filter_names[kind]);
        if (commit(s) && render(s, &d, rgb, NULL))
            for (x = 0; x < 16; x++) {
                double want = 0, all = 0, got = 0, edge = 7.4 - x;
                for (i = 0; i < 20000; i++) {
                    double at = (2 * (i + 0.5) / 20000 - 1) * r, v = filter_by_definition((pt_filter)kind, at, r);
                    all += v;
                    if (at < edge) want += v;
                }
                for (y = 0; y < 16; y++) got += (double)rgb[3 * (16 * y + x)] / 16;
                CHECK_NEAR(got, want / all, kind == PT_FILTER_MITCHELL ? 0.006 : 0.002);
                least = fmin(least, got); most = fmax(most, got);
            }
        if (kind == PT_FILTER_MITCHELL) CHECK(least < -0.004 && most > 1.007);
        else CHECK(least == 0 && most == 1);
        pt_scene_destroy(s);
    }
}
/* Filtered pictures, too, are one sum: whole, merged from ranges in any order, or grown sample by sample. */
static void filtered_ranges_merge(void) {
    static float whole[3 * 16 * 16], grown[3 * 16 * 16];
    int kind, k;
    EACH_FILTER(kind) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(0, 1, 5), pt_v3(0, 0, 0), 40, 16, 11);
        pt_render *r[3];
        d.filter = (pt_filter)kind;
        pt_add_sphere(s, pt_v3(0, 0, 0), 1, diffuse(s, 0.7f));
        sky(s, 1);
        test_case("%s", filter_names[kind]);
        if (commit(s) && render(s, &d, whole, NULL)) {
            static const int begin[4] = { 0, 2, 7, 11 };
            for (k = 0; k < 3; k++) {
                d.first_sample = begin[k]; d.spp = begin[k + 1] - begin[k];
                r[k] = pt_render_create(s, &d);
                CHECK_EQ_INT(pt_render_run(r[k]), PT_OK);
            }
            CHECK_EQ_INT(pt_render_merge(r[2], r[0]), PT_OK);
            CHECK_EQ_INT(pt_render_merge(r[2], r[1]), PT_OK);
            CHECK_EQ_INT(memcmp(pt_render_pixels(r[2]), whole, sizeof whole), 0);
            for (k = 0; k < 3; k++) pt_render_destroy(r[k]);
            d.first_sample = 0; d.spp = 4;
            r[0] = pt_render_create(s, &d);
            CHECK_EQ_INT(pt_render_run(r[0]), PT_OK);
            CHECK_EQ_INT(pt_render_add_samples(r[0], 7), PT_OK);
            CHECK_EQ_INT(pt_render_run(r[0]), PT_OK);
            memcpy(grown, pt_render_pixels(r[0]), sizeof grown);
            CHECK_EQ_INT(memcmp(grown, whole, sizeof whole), 0);
            pt_render_destroy(r[0]);
        }
        pt_scene_destroy(s);
    }
}

void test_film(void) {
    RUN(sums_are_exact);
    RUN(single_values);
    RUN(order_does_not_matter);
    RUN(a_million_samples_do_not_drift);
    RUN(unfit_samples_are_black);
    RUN(negative_samples_cancel_exactly);
    RUN(offsets_follow_the_filter);
    RUN(filters_are_inversions);
    RUN(mitchell_integrates_to_one);
    RUN(constants_stay);
    RUN(a_step_edge_is_the_filters_integral);
    RUN(filtered_ranges_merge);
}
