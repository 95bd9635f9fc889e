/* >>film: sums that are exact, whatever the order and the number of samples. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"

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

void test_film(void) {
    RUN(sums_are_exact);
    RUN(single_values);
    RUN(order_does_not_matter);
    RUN(a_million_samples_do_not_drift);
    RUN(unfit_samples_are_black);
}
