/* >>platform (texts, memory, the floating-point mode) and >>math (vectors, transforms, elementary functions). */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"

/* ---- the elementary functions, against libm in double ---- */

#define BOUND 0.50001                                    /* ulp: the chapter's opening comment says 0.500003 at most */

static float float_of(uint32_t bits) { float x; memcpy(&x, &bits, sizeof x); return x; }
/* |got - want| in units of the last place that a float near want has; huge where only one of them is NaN or infinite. */
static double ulps(float got, double want) {
    int e;
    if (got != got || want != want) return (got != got) == (want != want) ? 0 : 1e9;
    if (isinf(got) || isinf((float)want)) return got == (float)want ? 0 : 1e9;
    frexp(want, &e);
    return fabs((double)got - want) / ldexp(1, e - 24 < -149 ? -149 : e - 24);
}
typedef struct worst { double ulps; float x, y; } worst;
static void note(worst *w, float got, double want, float x, float y) {
    double u = ulps(got, want);
    if (u > w->ulps) { w->ulps = u; w->x = x; w->y = y; }
}
#define CHECK_WORST(w) do { if ((w).ulps > BOUND) FAIL("%.9g ulp at %.9g, %.9g", (w).ulps, (double)(w).x, (double)(w).y); \
                            else CHECK((w).ulps > 0.4); } while (0)    /* less would mean that nothing was measured */

static const float special[] = { 0, -0.0f, 1e-45f, -1e-45f, 1.17549435e-38f, -1.17549435e-38f, 1.1754942e-38f, 5.9604645e-8f,
    0.25f, 0.5f, 0.70710678f, 0.70710677f, 0.99999994f, 1, 1.0000001f, 1.4142135f, 1.4142137f, 2, 2.7182817f, 3.1415927f,
    6.2831855f, 10, 16777216, 88.72283f, 88.72284f, -87.33655f, -103.27893f, -103.97208f, -104, -105, 3.4028235e38f,
    -0.5f, -1, -2, -1e10f, -3.4028235e38f };
#define SPECIAL ((int)(sizeof special / sizeof special[0]))
/* Every 1021st float in bit space (a prime), then the special values, the infinities and NaN. */
#define EACH_FLOAT(i, x) for (i = 0; (x = sweep(i)), i < 0x100000000u / 1021 + SPECIAL + 3; i++)
static float sweep(uint32_t i) {
    uint32_t count = (uint32_t)(0x100000000u / 1021);
    if (i < count) return float_of(i * 1021u);
    i -= count;
    if (i < SPECIAL) return special[i];
    return i == SPECIAL ? (float)HUGE_VAL : i == SPECIAL + 1 ? -(float)HUGE_VAL : float_of(0x7fc00000u);
}

static void sine_and_cosine(void) {
    worst w = { 0, 0, 0 };
    uint32_t i;
    int k, j;
    float x, s, c;
    EACH_FLOAT(i, x) {
        if (!(fabsf(x) <= 1048576)) continue;
        pti_sincos(x, &s, &c);
        note(&w, s, sin((double)x), x, 0);
        note(&w, c, cos((double)x), x, 1);
    }
    for (k = 0; k < 667544; k++)                         /* where one of the two is nearly 0: about k pi/2, up to 2^20 */
        for (j = -1; j <= 1; j++) {
            x = (float)(k * 1.5707963267948966);
            x = j < 0 ? nextafterf(x, -1) : j > 0 ? nextafterf(x, 1e9f) : x;
            if (x > 1048576) continue;
            pti_sincos(x, &s, &c);
            note(&w, s, sin((double)x), x, 0);
            note(&w, c, cos((double)x), x, 1);
        }
    CHECK_WORST(w);
    pti_sincos(-0.0f, &s, &c);
    CHECK(s == 0 && signbit(s) && c == 1);
}
static void exponential(void) {
    worst w = { 0, 0, 0 };
    uint32_t i;
    float x;
    EACH_FLOAT(i, x) note(&w, pti_exp(x), exp((double)x), x, 0);
    CHECK_WORST(w);
    CHECK(pti_exp(0) == 1 && pti_exp(-0.0f) == 1);
    CHECK(pti_exp(88.72284f) == HUGE_VAL && pti_exp(88.72283f) < HUGE_VAL);
    CHECK(pti_exp(-103.97207f) > 0 && pti_exp(-104.0f) == 0);          /* the least denormal */
}
static void logarithm(void) {
    worst w = { 0, 0, 0 };
    uint32_t i;
    float x;
    EACH_FLOAT(i, x) note(&w, pti_log(x), log((double)x), x, 0);       /* NaN below 0 */
    for (i = 0; i < 400000; i++) {                       /* about 1, where it is nearly 0 */
        x = float_of(0x3f800000u - 200000 + i);
        note(&w, pti_log(x), log((double)x), x, 0);
    }
    CHECK_WORST(w);
    CHECK(pti_log(1) == 0);
    CHECK(pti_log(0) == -HUGE_VAL && pti_log(-0.0f) == -HUGE_VAL);
}
static void power(void) {
    worst w = { 0, 0, 0 };
    pt_rng rng;
    uint32_t i;
    int j;
    float x, y;
    pt_rng_seed(&rng, 1, 1);
    for (i = 0; i < 1500000; i++) {
        x = float_of(pt_rng_u32(&rng) & 0x7fffffffu);
        switch (i & 3) {
        case 0: y = float_of(pt_rng_u32(&rng)); break;                /* anything: mostly 0 and infinity */
        case 1: y = (float)((pt_rng_float(&rng) * 192 - 103) / log((double)x)); break;    /* results of all sizes */
        case 2: y = pt_rng_float(&rng) * 8 - 4; break;
        default: x = float_of(0x3f800000u - 50000 + pt_rng_u32(&rng) % 100000);           /* close to 1, huge y */
                 y = (pt_rng_float(&rng) * 2 - 1) * 1e6f;
        }
        if (x == x) note(&w, pti_pow(x, y), x == 0 && y != y ? (double)y : pow((double)x, (double)y), x, y);
    }
    for (i = 0; i < SPECIAL + 2; i++) for (j = 0; j < SPECIAL + 2; j++) {
        x = i < SPECIAL ? special[i] : i == SPECIAL ? PTI_INF : PTI_INF - PTI_INF;
        y = j < SPECIAL ? special[j] : j == SPECIAL ? PTI_INF : -PTI_INF;
        if (!(x < 0) && !(signbit(x) && x == 0)) note(&w, pti_pow(x, y), pow((double)x, (double)y), x, y);
    }
    CHECK_WORST(w);
    CHECK(pti_pow(0, 0) == 1 && pti_pow(0, 2) == 0 && pti_pow(0, -1) == HUGE_VAL);
    CHECK(pti_pow(3, 1) == 3 && pti_pow(2, -149) == 1e-45f && pti_pow(2, 127) == 1.70141183e38f);
}
static void arctangent(void) {
    worst w = { 0, 0, 0 };
    pt_rng rng;
    uint32_t i;
    int j;
    float x, y;
    pt_rng_seed(&rng, 2, 1);
    for (i = 0; i < 2000000; i++) {
        y = float_of(pt_rng_u32(&rng));
        x = i & 1 ? float_of(pt_rng_u32(&rng)) : y * (pt_rng_float(&rng) * 2 - 1) * (i & 2 ? 1 : 8);
        if (y != 0 || x > 0) note(&w, pti_atan2(y, x), atan2((double)y, (double)x), y, x);
    }
    for (i = 0; i < SPECIAL + 3; i++) for (j = 0; j < SPECIAL + 3; j++) {
        y = i < SPECIAL ? special[i] : i == SPECIAL ? PTI_INF : i == SPECIAL + 1 ? -PTI_INF : PTI_INF - PTI_INF;
        x = j < SPECIAL ? special[j] : j == SPECIAL ? PTI_INF : j == SPECIAL + 1 ? -PTI_INF : PTI_INF - PTI_INF;
        if (y == 0 && !(x > 0)) continue;                /* ours knows no -0: below */
        note(&w, pti_atan2(y, x), atan2((double)y, (double)x), y, x);
    }
    CHECK_WORST(w);
    CHECK(pti_atan2(0, 0) == 0 && pti_atan2(0, -0.0f) == 0 && pti_atan2(0, 1) == 0);
    CHECK(pti_atan2(0, -1) == (float)STATS_PI && pti_atan2(-0.0f, -1) == (float)STATS_PI);      /* (-pi, pi] */
    CHECK(pti_atan2(1, 0) == (float)(STATS_PI / 2) && pti_atan2(-1, 0) == -(float)(STATS_PI / 2));
}
static void arccosine(void) {
    worst w = { 0, 0, 0 };
    uint32_t i;
    float x;
    EACH_FLOAT(i, x) if (!(fabsf(x) > 1)) note(&w, pti_acos(x), acos((double)x), x, 0);    /* NaN too */
    for (i = 0; i < 200000; i++) {
        x = float_of(0x3f800000u - i);
        note(&w, pti_acos(x), acos((double)x), x, 0);
        note(&w, pti_acos(-x), acos((double)-x), -x, 0);
    }
    CHECK_WORST(w);
    CHECK(pti_acos(1) == 0 && pti_acos(-1) == (float)STATS_PI && pti_acos(0) == (float)(STATS_PI / 2));
    CHECK(pti_acos(1.0000001f) == 0 && pti_acos(PTI_INF) == 0 && pti_acos(-7) == (float)STATS_PI);     /* the nearer end */
    CHECK(pti_safe_sqrt(-1e-9f) == 0 && pti_safe_sqrt(4) == 2 && pti_safe_sqrt(PTI_INF - PTI_INF) == 0);
}

/* ---- vectors ---- */

static const float nan_ = 0;                             /* quiet NaN, made at run time */
static float make_nan(void) { volatile float zero = nan_; return zero / zero; }

static void scalars(void) {
    float nan = make_nan();
    CHECK(pti_min(1, 2) == 1 && pti_min(2, 1) == 1 && pti_max(1, 2) == 2 && pti_max(2, 1) == 2);
    CHECK(pti_min(nan, 1) == 1 && pti_max(nan, 1) == 1);               /* NaN on the left loses */
    CHECK(pti_clamp(-1, 0, 1) == 0 && pti_clamp(2, 0, 1) == 1 && pti_clamp(0.5f, 0, 1) == 0.5f);
    CHECK(pti_finite(0) && pti_finite(-3.4028235e38f) && !pti_finite(nan) && !pti_finite(PTI_INF) && !pti_finite(-PTI_INF));
    CHECK(PTI_PI == (float)STATS_PI);
}
static void vectors(void) {
    pt_vec3 a = pt_v3(1, -2, 3), b = pt_v3(4, 5, -6), c = pti_cross(a, b), m;
    CHECK(c.x == -3 && c.y == 18 && c.z == 13);
    CHECK(pti_dot(a, b) == -24 && pti_dot(a, c) == 0 && pti_dot(b, c) == 0);
    m = pti_madd(a, 2, b);
    CHECK(m.x == 6 && m.y == 1 && m.z == 0);
    m = pti_sub(pti_neg(a), pti_mul(a, b));
    CHECK(m.x == -5 && m.y == 12 && m.z == 15);
    m = pti_min3(a, b);
    CHECK(m.x == 1 && m.y == -2 && m.z == -6);
    m = pti_max3(a, b);
    CHECK(m.x == 4 && m.y == 5 && m.z == 3);
    CHECK(pti_length(pt_v3(2, 3, 6)) == 7 && pti_largest(b) == 5 && pti_largest_abs(b) == 6);
    CHECK(pti_axis(a, 0) == 1 && pti_axis(a, 1) == -2 && pti_axis(a, 2) == 3);
    CHECK(pti_is_zero3(pt_v3(0, -0.0f, 0)) && !pti_is_zero3(pt_v3(0, 0, 1e-45f)));
    CHECK(pti_finite3(a) && !pti_finite3(pt_v3(0, make_nan(), 0)) && !pti_finite3(pt_v3(0, 0, PTI_INF)));
    CHECK_NEAR(pti_luminance(pt_v3(1, 1, 1)), 1, 1e-6);
    CHECK(pti_luminance(pt_v3(0, 1, 0)) > pti_luminance(pt_v3(1, 0, 0)));
}
static void normalize_everything(void) {
    pt_rng rng;
    int i, e;
    double off_length = 0, off_direction = 0;
    pt_rng_seed(&rng, 3, 1);
    for (i = 0; i < 200000; i++) {                       /* lengths from the least denormal to the largest float */
        double f[3], l, d[3];
        pt_vec3 v, n;
        int k;
        for (k = 0; k < 3; k++) {
            e = (int)(pt_rng_u32(&rng) % 277) - 149;
            f[k] = (double)(float)ldexp(pt_rng_float(&rng) * 2.0 - 1, i & 1 ? e : (int)(i / 2 % 277) - 149);
        }
        v = pt_v3((float)f[0], (float)f[1], (float)f[2]);
        n = pti_normalize(v);
        l = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
        if (l == 0) { CHECK(n.x == 0 && n.y == 0 && n.z == 0); continue; }
        d[0] = n.x - f[0] / l; d[1] = n.y - f[1] / l; d[2] = n.z - f[2] / l;
        off_length = fmax(off_length, fabs(sqrt((double)n.x * n.x + (double)n.y * n.y + (double)n.z * n.z) - 1));
        off_direction = fmax(off_direction, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        if (n.x != n.x) off_length = 9;
    }
    CHECK_NEAR(off_length, 0, 3e-7);
    CHECK_NEAR(off_direction, 0, 3e-7);
    for (i = 0; i < SPECIAL; i++) {
        pt_vec3 n = pti_normalize(pt_v3(0, special[i], 0));
        CHECK(n.x == 0 && n.z == 0);
        CHECK_NEAR(n.y, special[i] > 0 ? 1 : special[i] < 0 ? -1 : 0, 1e-7);
    }
}
static void bases_are_orthonormal(void) {
    static const float zs[] = { 0, -0.0f, 1e-45f, -1e-45f, -1e-8f, 1, -1, 0.99999994f, -0.99999994f, -0.9999f };
    pt_rng rng;
    int i;
    pt_rng_seed(&rng, 4, 1);
    for (i = 0; i < 100000; i++) {
        pt_vec3 n = stats_direction(&rng), t, b, c;
        double worst_of = 0;
        if (i < 1000) {                                  /* at the equator and at both poles */
            float z = zs[i % 10], r = (float)sqrt(fmax(1 - (double)z * z, 0)), s, co;
            pti_sincos(i * 0.1f, &s, &co);
            n = pt_v3(r * co, r * s, z);
        }
        n = pti_normalize(n);
        pti_basis(n, &t, &b);
        c = pti_sub(pti_cross(t, b), n);                 /* right-handed: t x b = n */
        worst_of = fmax(worst_of, fabs(pti_dot(t, t) - 1.0));
        worst_of = fmax(worst_of, fabs(pti_dot(b, b) - 1.0));
        worst_of = fmax(worst_of, fabs((double)pti_dot(t, b)));
        worst_of = fmax(worst_of, fabs((double)pti_dot(t, n)));
        worst_of = fmax(worst_of, fabs((double)pti_dot(b, n)));
        worst_of = fmax(worst_of, (double)pti_length(c));
        if (!(worst_of < 2e-6)) FAIL("off by %g for n = (%.9g, %.9g, %.9g)", worst_of, n.x, n.y, n.z);
        if (i % 100 == 0) {
            c = pti_to_world(t, b, n, pt_v3(0.25f, -0.5f, 2));
            CHECK_NEAR(pti_dot(c, t), 0.25, 4e-6);
            CHECK_NEAR(pti_dot(c, b), -0.5, 4e-6);
            CHECK_NEAR(pti_dot(c, n), 2, 4e-6);
        }
    }
}

/* ---- transforms ---- */

static pt_xform random_xform(pt_rng *rng, double scale) {
    pt_xform x;
    int i;
    for (i = 0; i < 12; i++) x.m[i] = (float)((pt_rng_float(rng) * 2 - 1) * (i % 4 == 3 ? 10 : scale));
    return x;
}
static void identity_transform(void) {
    pt_xform zero = { { 0 } }, one = pti_xform_or_identity(NULL), inverse, other = zero;
    pt_vec3 p = pt_v3(1, 2, 3), q = pti_xform_point(&one, p);
    int i;
    CHECK(q.x == 1 && q.y == 2 && q.z == 3 && pti_xform_det(&one) == 1);
    zero = pti_xform_or_identity(&zero);
    for (i = 0; i < 12; i++) CHECK(zero.m[i] == one.m[i] && one.m[i] == (i % 5 == 0 ? 1.0f : 0.0f));
    CHECK(pti_xform_invert(&one, &inverse));
    for (i = 0; i < 12; i++) CHECK(inverse.m[i] == one.m[i]);
    other.m[3] = 5;                                      /* not zero: taken as it is */
    CHECK(pti_xform_or_identity(&other).m[0] == 0 && pti_xform_or_identity(&other).m[3] == 5);
    q = pti_xform_point(&other, p);
    CHECK(q.x == 5 && q.y == 0 && q.z == 0);
}
static void inverse_transform(void) {
    static const double scales[] = { 1, 1e-6, 1e6, 1e-12, 1e9 };
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 5, 1);
    for (i = 0; i < 5000; i++) {
        double scale = scales[i % 5];
        pt_xform x = random_xform(&rng, scale), inverse;
        pt_vec3 p = stats_uniform3(&rng), v, w;
        double condition, norm = 0, inorm = 0;
        if (!CHECK(pti_xform_invert(&x, &inverse))) continue;
        for (k = 0; k < 12; k++) {
            if (k % 4 == 3) continue;
            norm = fmax(norm, fabs((double)x.m[k]));
            inorm = fmax(inorm, fabs((double)inverse.m[k]));
        }
        condition = norm * inorm;
        v = pti_xform_vector(&inverse, pti_xform_vector(&x, p));
        CHECK_NEAR(pti_length(pti_sub(v, p)), 0, 2e-6 * condition);
        w = pti_xform_point(&inverse, pti_xform_point(&x, p));
        CHECK_NEAR(pti_length(pti_sub(w, p)), 0, 2e-6 * (condition + 10 * inorm));
        v = pti_sub(pti_xform_point(&x, p), pti_xform_vector(&x, p));
        CHECK(fabsf(v.x - x.m[3]) <= 1e-5f * (10 + (float)norm) && fabsf(v.z - x.m[11]) <= 1e-5f * (10 + (float)norm));
    }
}
static void no_inverse(void) {
    pt_xform x = pti_xform_or_identity(NULL), out;
    int i;
    x.m[10] = 0;
    CHECK(!pti_xform_invert(&x, &out));                  /* flat */
    for (i = 0; i < 12; i++) x.m[i] = (float)(i % 4 + 1);
    CHECK(!pti_xform_invert(&x, &out));                  /* three equal rows */
    for (i = 0; i < 12; i++) {
        x = pti_xform_or_identity(NULL);
        x.m[i] = make_nan();
        CHECK(!pti_xform_invert(&x, &out));
        x.m[i] = PTI_INF;
        CHECK(!pti_xform_invert(&x, &out));
    }
    x = pti_xform_or_identity(NULL);
    x.m[0] = 1e-35f;                                     /* its inverse is beyond what floats can work with */
    CHECK(!pti_xform_invert(&x, &out));
    x.m[0] = 1e-20f; x.m[5] = 1e-20f; x.m[10] = 1e-20f;  /* but a determinant of 1e-60 alone is no reason */
    CHECK(pti_xform_invert(&x, &out));
    CHECK_NEAR(out.m[5], 1e20, 1e14);
}
/* A normal stays perpendicular to what it stood on, and on the side on which it was: also when mirrored. */
static void normals_follow(void) {
    static const float cases[6][9] = {
        { -1, 0, 0,  0, 1, 0,  0, 0, 1 },                /* mirrored */
        { 1, 2, 0,   0, 1, 0,  0, 0, 1 },                /* sheared */
        { 1, 0, 0,   0, 10, 0, 0, 0, 0.1f },             /* squashed */
        { -1, 3, 0,  0, 1, 0,  2, 0, -0.5f },
        { 0, 0, 2,   0, -1, 0, 1, 0.5f, 0 },
        { -1, 0, 0,  0, -1, 0, 0, 0, -1 } };             /* turned inside out */
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 6, 1);
    for (i = 0; i < 3000; i++) {
        pt_xform x = random_xform(&rng, 1), inverse;
        pt_vec3 n = stats_direction(&rng), t, b, m, up;
        if (i < 600) for (k = 0; k < 9; k++) x.m[k / 3 * 4 + k % 3] = cases[i % 6][k];
        if (fabs(pti_xform_det(&x)) < 0.05) continue;
        CHECK(pti_xform_invert(&x, &inverse));
        pti_basis(n, &t, &b);
        m = pti_normalize(pti_xform_normal(&inverse, n));
        up = pti_xform_vector(&x, n);
        t = pti_normalize(pti_xform_vector(&x, t));
        b = pti_normalize(pti_xform_vector(&x, b));
        CHECK_NEAR(pti_dot(m, t), 0, 2e-5);
        CHECK_NEAR(pti_dot(m, b), 0, 2e-5);
        CHECK(pti_dot(m, up) > 0);
    }
}
/* The bound on a transformed point's rounding: it must hold, and it must not be silly. */
static void transform_magnitude(void) {
    pt_rng rng;
    double largest = 0;
    int i;
    pt_rng_seed(&rng, 7, 1);
    for (i = 0; i < 100000; i++) {
        pt_xform x = random_xform(&rng, i & 1 ? 1 : 100);
        pt_vec3 p = pti_mul(stats_uniform3(&rng), pt_v3(9, 1, -1)), q = pti_xform_point(&x, p);
        double exact = (double)x.m[4] * p.x + (double)x.m[5] * p.y + (double)x.m[6] * p.z + x.m[7];
        largest = fmax(largest, fabs(q.y - exact) / pti_xform_magnitude(&x, p));
    }
    CHECK(largest < 4 * 5.97e-8 && largest > 5.97e-8);   /* a product and three sums, each rounded by 2^-24 at most */
}

/* ---- texts ---- */

static const char *formatted(const char *format, ...) {
    static char out[128];
    va_list args;
    va_start(args, format);
    pti_vformat(out, sizeof out, format, args);
    va_end(args);
    return out;
}
static void format_words(void) {
    CHECK_STR(formatted("plain"), "plain");
    CHECK_STR(formatted(""), "");
    CHECK_STR(formatted("%s: index %u is %d, but", "f", (uint64_t)17, -901), "f: index 17 is -901, but");
    CHECK_STR(formatted("%s%s", "", "a%sb"), "a%sb");
    CHECK_STR(formatted("%u", (uint64_t)0), "0");
    CHECK_STR(formatted("%u", UINT64_MAX), "18446744073709551615");
    CHECK_STR(formatted("%d %d %d", 0, 2147483647, -2147483647 - 1), "0 2147483647 -2147483648");
}
static void format_numbers(void) {
    static const struct { double value; const char *text; } exact[] = {
        { 0, "0" }, { 1, "1" }, { -1, "-1" }, { 2.5, "2.5" }, { 10, "10" }, { 100, "100" }, { 123456, "123456" },
        { 99999.9, "99999.9" }, { 3.14159265, "3.14159" }, { 2.0000001, "2" }, { -42.125, "-42.125" },
        { 1.00001, "1.00001" },
        { 9.9999999, "10" }, { 999999.7, "1e+6" }, { 1234567, "1.23457e+6" }, { 1e30, "1e+30" }, { -2.5e100, "-2.5e+100" },
        { 1e-30, "1e-30" }, { 1.5e-8, "1.5e-8" }, { 120000, "120000" }, { 100000.4, "100000" }, { 20.5, "20.5" } };
    double inf = HUGE_VAL, nan = (double)make_nan();
    pt_rng rng;
    int i;
    for (i = 0; i < (int)(sizeof exact / sizeof exact[0]); i++) CHECK_STR(formatted("%g", exact[i].value), exact[i].text);
    CHECK_STR(formatted("%g %g %g", inf, -inf, nan), "inf -inf nan");
    pt_rng_seed(&rng, 8, 1);
    for (i = 0; i < 20000; i++) {                        /* read back: right to half a unit of the sixth digit */
        int e = (int)(pt_rng_u32(&rng) % (i & 1 ? 600 : 16)) - (i & 1 ? 300 : 8);
        double v = (1 + 9.0 * pt_rng_float(&rng)) * pow(10, e);
        const char *s = formatted("%g", i & 2 ? -v : v);
        if (!(fabs(fabs(strtod(s, NULL)) - v) <= 5.00001e-6 * pow(10, floor(log10(v)))) || (s[0] == '-') != !!(i & 2)
            || strlen(s) > 13) FAIL("%.17g becomes \"%s\"", v, s);
    }
    CHECK_NEAR(strtod(formatted("%g", DBL_MAX), NULL) / DBL_MAX, 1, 1e-5);
    CHECK_NEAR(strtod(formatted("%g", DBL_MIN), NULL) / DBL_MIN, 1, 1e-5);
    CHECK(strtod(formatted("%g", 5e-324), NULL) > 0);
}
static void format_into(char *out, size_t size, const char *format, ...) {
    va_list args;
    va_start(args, format);
    pti_vformat(out, size, format, args);
    va_end(args);
}
static void format_never_overruns(void) {                /* cut at every length */
    const char *whole = "name 12345 -678 1.5 end";
    char out[40];
    size_t size, i;
    for (size = 1; size < sizeof out; size++) {
        memset(out, '#', sizeof out);
        format_into(out, size, "%s %u %d %g %s", "name", (uint64_t)12345, -678, 1.5, "end");
        CHECK_EQ_INT(strlen(out), strlen(whole) < size ? strlen(whole) : size - 1);
        CHECK(!strncmp(out, whole, strlen(out)));
        for (i = size; i < sizeof out; i++) CHECK(out[i] == '#');
    }
}
static struct { int calls; pt_result code; char text[300]; } heard;
static void hear(void *user, pt_result code, const char *message) {
    CHECK(user == &heard);
    heard.calls++;
    heard.code = code;
    CHECK(strlen(message) < sizeof heard.text);
    strncpy(heard.text, message, sizeof heard.text - 1);
}
static void first_error_sticks(void) {
    pti_error e;
    char name[600];
    int r;
    memset(&e, 0, sizeof e);
    memset(&heard, 0, sizeof heard);
    pti_fail(&e, PT_ERR_ARG, "no %s", "logger");         /* none is fine */
    CHECK_STR(e.text, "no logger");
    memset(&e, 0, sizeof e);
    e.logger.log = hear; e.logger.user = &heard;
    pti_fail(&e, PT_ERR_ARG, "first %d", 1);
    pti_fail(&e, PT_ERR_MEMORY, "second %d", 2);
    CHECK(e.code == PT_ERR_ARG && heard.calls == 2 && heard.code == PT_ERR_MEMORY);
    CHECK_STR(e.text, "first 1");
    CHECK_STR(heard.text, "second 2");
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = 0;
    e.code = PT_OK;
    pti_fail(&e, PT_ERR_IO, "%s", name);                 /* longer than there is room */
    CHECK_EQ_INT(strlen(e.text), sizeof e.text - 1);
    for (r = -7; r < 5; r++) CHECK(pt_result_string((pt_result)r) && pt_result_string((pt_result)r)[0]);
    CHECK_STR(pt_result_string(PT_OK), "ok");
    CHECK_STR(pt_result_string((pt_result)99), "unknown result");
}

/* ---- memory ---- */

typedef struct counting { size_t calls, live, bytes, fail_at; } counting;
static void *counted_alloc(void *user, size_t size, size_t align) {
    counting *c = (counting *)user;
    void *p;
    CHECK(align == PTI_ALIGN && size > 0);
    if (++c->calls == c->fail_at) return NULL;
    p = pti_default_alloc(NULL, size, align);
    if (p) { memset(p, 0xcd, size); c->live++; c->bytes += size; }     /* not zeroed: that is pti_alloc's job */
    return p;
}
static void counted_free(void *user, void *p, size_t size) {
    counting *c = (counting *)user;
    c->live--;
    c->bytes -= size;                                    /* back to 0 only if free hears the size that alloc heard */
    pti_default_free(NULL, p, size);
}
static pt_allocator counted(counting *c) {
    pt_allocator a;
    memset(c, 0, sizeof *c);
    a.alloc = counted_alloc; a.free = counted_free; a.user = c;
    return a;
}
static void allocation(void) {
    counting c;
    pt_allocator a = counted(&c);
    size_t size, i;
    for (size = 1; size < 300; size++) {                 /* aligned, zeroed, all of it usable */
        size_t count = size % 5;
        unsigned char *p = (unsigned char *)pti_alloc(&a, count, size);
        if (!CHECK(p != NULL)) return;
        CHECK((uintptr_t)p % PTI_ALIGN == 0);
        for (i = 0; i < count * size; i++) if (p[i]) { FAIL("byte %d is not zero", (int)i); break; }
        memset(p, 0xff, count * size);
        pti_free(&a, p, count, size);
        CHECK(c.live == 0 && c.bytes == 0);
    }
    pti_free(&a, NULL, 1, 1);                            /* NULL is fine */
    CHECK(c.live == 0);
    for (i = 1; i <= 1024; i *= 2) {
        void *p = pti_default_alloc(NULL, 100, i <= 64 ? i : 64);
        CHECK(p && (uintptr_t)p % (i <= 64 ? i : 64) == 0);
        pti_default_free(NULL, p, 100);
    }
}
static void allocation_overflow(void) {
    static const size_t sizes[] = { 1, 2, 3, 12, 64, 1000, SIZE_MAX / 2, SIZE_MAX / 2 + 1, SIZE_MAX - 128, SIZE_MAX };
    counting c;
    pt_allocator a = counted(&c);
    size_t i, j;
    for (i = 0; i < 10; i++)                             /* any product beyond SIZE_MAX, and what leaves no room to align */
        for (j = 0; j < 10; j++) {
            if (sizes[j] <= (SIZE_MAX - 127) / sizes[i]) continue;
            CHECK(pti_alloc(&a, sizes[j], sizes[i]) == NULL);
        }
    CHECK_EQ_INT(c.calls, 0);                            /* refused before the allocator is asked */
    c.fail_at = 1;
    CHECK(pti_alloc(&a, 10, 10) == NULL && c.live == 0);
}
static void growing(void) {
    counting c;
    pt_allocator a = counted(&c);
    uint32_t *array = NULL, *before;
    size_t count = 0, capacity = 0, i;
    while (count < 10000) {
        if (!CHECK(pti_grow(&a, (void **)&array, count, &capacity, sizeof *array))) return;
        CHECK(capacity > count);
        array[count] = (uint32_t)count * 7;
        count++;
    }
    for (i = 0; i < count; i++) if (array[i] != i * 7) { FAIL("element %d was lost", (int)i); break; }
    CHECK(c.live == 1 && c.bytes == capacity * sizeof *array && c.calls < 20 && capacity < 4 * count);
    before = array;
    count = i = capacity;
    c.fail_at = c.calls + 1;                             /* out of memory: all stays as it was */
    CHECK(!pti_grow(&a, (void **)&array, count, &capacity, sizeof *array));
    CHECK(array == before && capacity == i && array[9999] == 9999 * 7);
    pti_free(&a, array, capacity, sizeof *array);
    CHECK(c.live == 0 && c.bytes == 0);
    capacity = count = SIZE_MAX / 2 + 1;                 /* would overflow when doubled */
    i = c.calls;
    CHECK(!pti_grow(&a, (void **)&array, count, &capacity, sizeof *array));
    CHECK(c.calls == i && capacity == SIZE_MAX / 2 + 1);
}

/* ---- machine ---- */

static void denormals_stay(void) {
    volatile float tiny = 1.17549435e-38f, half;
    pti_fpmode host = pti_fpmode_enter();
#ifdef PTI_X86
    pti_fpmode_leave(host | 0x8040);                     /* a host that flushes denormals to zero */
    half = tiny * 0.5f;
    CHECK(half == 0);
    {
        pti_fpmode flushing = pti_fpmode_enter();
        half = tiny * 0.5f;
        CHECK(half > 0);
        pti_fpmode_leave(flushing);                      /* gets its mode back */
    }
    half = tiny * 0.5f;
    CHECK(half == 0);
#endif
    pti_fpmode_leave(host);
    half = tiny * 0.5f;
    CHECK(half > 0);
}
static void instruction_sets(void) {
    CHECK(pti_isa_supported(PTI_SCALAR_ISA) && pti_isa_supported(pti_isa_best()));
    CHECK(!pti_isa_supported(PTI_ISA_COUNT) && !pti_isa_supported(-1));
    CHECK_EQ_INT(pti_isa_by_name("scalar"), PTI_SCALAR_ISA);
    CHECK_EQ_INT(pti_isa_by_name("avx2"), PTI_AVX2_ISA);
    CHECK_EQ_INT(pti_isa_by_name("avx"), -1);
    CHECK_EQ_INT(pti_isa_by_name(""), -1);
    CHECK(pti_cores() >= 1);
}

void test_math(void) {
    RUN(sine_and_cosine); RUN(exponential); RUN(logarithm); RUN(power); RUN(arctangent); RUN(arccosine);
    RUN(scalars); RUN(vectors); RUN(normalize_everything); RUN(bases_are_orthonormal);
    RUN(identity_transform); RUN(inverse_transform); RUN(no_inverse); RUN(normals_follow); RUN(transform_magnitude);
    RUN(format_words); RUN(format_numbers); RUN(format_never_overruns); RUN(first_error_sticks);
    RUN(allocation); RUN(allocation_overflow); RUN(growing); RUN(denormals_stay); RUN(instruction_sets);
}
