/* >>random: PCG32, Sobol, its scramble, the three samplers, permutations, coins that can be tossed again. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"

static const pt_sampler kinds[] = { PT_SAMPLER_SOBOL, PT_SAMPLER_STRATIFIED, PT_SAMPLER_RANDOM };
static const char *const kind_names[] = { "sobol", "stratified", "random" };

/* Sample `index` of pixel x in the row y, as >>render makes it; strata of a pass of a x b. */
static pti_sampler sampler_at(pt_sampler kind, uint32_t x, uint32_t y, uint32_t index, uint32_t a, uint32_t b) {
    pti_sampler s;
    s.kind = kind; s.strata_x = a; s.strata_y = b;
    pti_sampler_start(&s, index);
    s.pixel_seed = pti_hash2(x, pti_hash2(y, 12345));
    return s;
}
static double fraction(uint32_t u) { return u / 4294967296.0; }

/* ---- generators and mixers ---- */

static void pcg32(void) {
    static const uint32_t expected[6] = { 0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u, 0xbfa4784bu, 0xcbed606eu };
    pt_rng rng, other;
    int i, equal = 0, counts[256] = { 0 };
    pt_rng_seed(&rng, 42, 54);                           /* the demo of O'Neill's own code */
    for (i = 0; i < 6; i++) CHECK_EQ_U32(pt_rng_u32(&rng), expected[i]);
    pt_rng_seed(&rng, 42, 54);
    CHECK(pt_rng_float(&rng) == (float)(0xa15c02b7u >> 8) / 16777216);
    CHECK(pti_u01(0) == 0 && pti_u01(1u << 31) == 0.5f && pti_u01(0xffffffffu) == 1 - 1.0f / 16777216);
    pt_rng_seed(&other, 42, 55);                         /* another stream */
    for (i = 0; i < 1000; i++) equal += pt_rng_u32(&rng) == pt_rng_u32(&other);
    CHECK(equal < 2);
    for (i = 0; i < 100000; i++) counts[(int)(pt_rng_float(&rng) * 256)]++;
    CHECK_P(stats_chi2_uniform(counts, 256));
}
static uint32_t unhash(uint32_t x) {                     /* Wellons gives the inverse as well */
    x = (x ^ x >> 16) * 0x43021123u;
    x = (x ^ x >> 15 ^ x >> 30) * 0x1d69e2a5u;
    return x ^ x >> 16;
}
static void hashes(void) {
    pt_rng rng;
    int i, bit, out, flips[32][32] = { { 0 } }, flips2[2][32] = { { 0 } };
    pt_rng_seed(&rng, 1, 2);
    for (i = 0; i < 20000; i++) {                        /* a bijection; each bit of the input flips half of the output's */
        uint32_t x = i < 4 ? (uint32_t)i - 2 : pt_rng_u32(&rng), y = pt_rng_u32(&rng), d;
        CHECK_EQ_U32(unhash(pti_hash(x)), x);
        for (bit = 0; bit < 32; bit++) {
            d = pti_hash(x) ^ pti_hash(x ^ 1u << bit);
            for (out = 0; out < 32; out++) flips[bit][out] += d >> out & 1;
        }
        d = pti_hash2(x, y) ^ pti_hash2(x ^ 1u << (i & 31), y);
        for (out = 0; out < 32; out++) flips2[0][out] += d >> out & 1;
        d = pti_hash2(x, y) ^ pti_hash2(x, y ^ 1u << (i & 31));
        for (out = 0; out < 32; out++) flips2[1][out] += d >> out & 1;
    }
    for (bit = 0; bit < 32; bit++)
        for (out = 0; out < 32; out++)
            if (abs(flips[bit][out] - 10000) > 1200) FAIL("bit %d flips bit %d: %d of 20000", bit, out, flips[bit][out]);
    for (out = 0; out < 32; out++) CHECK(abs(flips2[0][out] - 10000) < 500 && abs(flips2[1][out] - 10000) < 500);
    CHECK(pti_hash2(1, 2) != pti_hash2(2, 1) && pti_hash2(0, 0) != 0);
}
static void reversed_bits(void) {
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 2, 2);
    for (i = 0; i < 1000; i++) {
        uint32_t x = i < 32 ? 1u << i : pt_rng_u32(&rng), r = 0;
        for (k = 0; k < 32; k++) r |= (x >> k & 1) << (31 - k);
        CHECK_EQ_U32(pti_reverse_bits(x), r);
    }
}

/* ---- Sobol ---- */

/* From the definition: Joe and Kuo's polynomials x + 1, x^2 + x + 1, x^3 + x + 1 and first direction numbers. */
static uint32_t sobol_from_definition(uint32_t index, int dimension) {
    static const struct { int s; uint32_t a, m[3]; } joe_kuo[3] = { { 1, 0, { 1, 0, 0 } }, { 2, 1, { 1, 3, 0 } },
                                                                    { 3, 1, { 1, 3, 1 } } };
    uint32_t v[32], x = 0;
    int k, j, s = dimension ? joe_kuo[dimension - 1].s : 0;
    for (k = 0; k < 32; k++) {
        if (dimension == 0) { v[k] = 1u << (31 - k); continue; }
        if (k < s) { v[k] = joe_kuo[dimension - 1].m[k] << (31 - k); continue; }
        v[k] = v[k - s] ^ v[k - s] >> s;
        for (j = 1; j < s; j++) if (joe_kuo[dimension - 1].a >> (s - 1 - j) & 1) v[k] ^= v[k - j];
    }
    for (k = 0; k < 32; k++) if (index >> k & 1) x ^= v[k];
    return x;
}
static void sobol_is_sobol(void) {
    pt_rng rng;
    int i, d;
    pt_rng_seed(&rng, 3, 2);
    for (i = 0; i < 3000; i++) {
        uint32_t index = i < 1000 ? (uint32_t)i : i < 1032 ? 1u << (i - 1000) : pt_rng_u32(&rng);
        for (d = 0; d < 4; d++)
            CHECK_EQ_U32(pti_reverse_bits(pti_sobol_reversed(index, d)), sobol_from_definition(index, d));
    }
}
/* The coin that flips a bit depends on nothing but the bits above it (below it, reversed); each prefix has its own coin. */
static void scramble_is_owens(void) {
    enum { SEEDS = 4000, DEPTH = 5, NODES = 1 << DEPTH };
    static int heads[NODES], both[NODES][NODES];
    static unsigned char seen[1 << 12];
    pt_rng rng;
    int i, j, level, low_p = 0, pairs = 0, counts[64] = { 0 };
    pt_rng_seed(&rng, 4, 2);
    for (i = 0; i < 40; i++) {
        uint32_t seed = i < 4 ? (uint32_t)i - 2 : pt_rng_u32(&rng), x, bits;
        for (bits = 1; bits <= 12; bits++) {             /* a bijection of the low bits, which the high ones cannot touch */
            uint32_t mask = (1u << bits) - 1;
            memset(seen, 0, sizeof seen);
            for (x = 0; x <= mask; x++) {
                uint32_t y = pti_scramble_reversed(x, seed) & mask;
                CHECK(!seen[y]);
                seen[y] = 1;
                if (bits == 12) CHECK((pti_scramble_reversed(x | (pt_rng_u32(&rng) & ~mask), seed) & mask) == y);
            }
        }
    }
    for (level = 0; level <= DEPTH; level++) {           /* coins are fair, and those of a level independent in pairs */
        int nodes = 1 << level;
        memset(heads, 0, sizeof heads);
        memset(both, 0, sizeof both);
        for (i = 0; i < SEEDS; i++) {
            uint32_t seed = pti_hash2((uint32_t)i, (uint32_t)level);
            unsigned char coin[NODES];
            for (j = 0; j < nodes; j++) {
                coin[j] = pti_scramble_reversed((uint32_t)j, seed) >> level & 1;
                heads[j] += coin[j];
            }
            for (j = 0; j < nodes; j++) {
                int k;
                for (k = 0; k < j; k++) both[j][k] += coin[j] == coin[k];
            }
        }
        for (j = 0; j < nodes; j++) {
            int k;
            test_case("level %d, node %d", level, j);
            CHECK_P(stats_count_test(heads[j], SEEDS, 0.5));
            for (k = 0; k < j; k++, pairs++) low_p += stats_count_test(both[j][k], SEEDS, 0.5) < 0.01;
        }
    }
    test_case("pairs");                                  /* a hash is not Owen's tree: some pairs are related. Few may be */
    if (low_p > pairs * 0.05) FAIL("%d of %d pairs of coins are related", low_p, pairs);
    for (i = 0; i < 64000; i++) counts[pti_reverse_bits(pti_scramble_reversed(0, pti_hash((uint32_t)i))) >> 26]++;
    CHECK_P(stats_chi2_uniform(counts, 64));             /* so the first point of all is uniform too */
}

/* ---- nets ---- */

static uint32_t points[1024][4];
static void draw_group(pt_sampler kind, uint32_t pixel, uint32_t group, uint32_t first, uint32_t n) {
    uint32_t i;
    for (i = 0; i < n; i++) {
        pti_sampler s = sampler_at(kind, pixel, 7, first + i, 1, 1);
        pti_draw2(&s, group, 0, points[i]);
        pti_draw2(&s, group, 1, points[i] + 2);
    }
}
/* Do all elementary intervals of volume 2^(t-m), whose sides are 2^-q[d], hold 2^t of the 2^m points? For all shapes q of
   the dimensions from .. to - 1. */
static int is_net(int t, int m, int from, int to, int q[4], int d, int left) {
    static int count[1024];
    int i, k;
    if (d < to - 1) {
        for (k = 0; k <= left; k++) { q[d] = k; if (!is_net(t, m, from, to, q, d + 1, left - k)) return 0; }
        return 1;
    }
    q[d] = left;
    memset(count, 0, sizeof count);
    for (i = 0; i < 1 << m; i++) {
        uint32_t cell = 0;
        for (k = from; k < to; k++) cell = q[k] ? cell << q[k] | points[i][k] >> (32 - q[k]) : cell;
        if (++count[cell] > 1 << t) return 0;            /* none may have more, so all have the same */
    }
    return 1;
}
static int has_t(int t, int m, int from, int to) {
    int q[4] = { 0 };
    return m < t || is_net(t, m, from, to, q, from, m - t);
}
static void prefixes_are_nets(void) {
    /* Sobol's t is the sum of (degree of the polynomial - 1) over the dimensions: 0, 0, 1, 2. Scrambling must keep it, and
       so must shuffling, which maps aligned blocks of 2^m samples to such blocks. */
    static const struct { uint32_t pixel, group, block; } cases[] = {
        { 0, 0, 0 }, { 1, 0, 0 }, { 2, 3, 0 }, { 3, 1, 1 }, { 4, 2, 5 }, { 5, 9, 1000 }, { 900, 0, 3 }, { 6, 63, 0xfffff } };
    int i, m, d;
    for (i = 0; i < 8; i++)
        for (m = 0; m <= 10; m++) {
            test_case("pixel %u, group %u, block %u of 2^%d", (unsigned)cases[i].pixel, (unsigned)cases[i].group,
                      (unsigned)cases[i].block, m);
            draw_group(PT_SAMPLER_SOBOL, cases[i].pixel, cases[i].group, cases[i].block << m, 1u << m);
            for (d = 0; d < 4; d++) CHECK(has_t(0, m, d, d + 1));
            CHECK(has_t(0, m, 0, 2));
            CHECK(has_t(1, m, 1, 3) && has_t(1, m, 0, 3));
            CHECK(has_t(3, m, 2, 4));
            CHECK(has_t(3, m, 0, 4));
        }
    test_case("random points");                          /* the test itself can fail */
    draw_group(PT_SAMPLER_RANDOM, 0, 0, 0, 1024);
    CHECK(!has_t(0, 10, 0, 2) && !has_t(3, 10, 0, 4));
    test_case("a block off its place");
    draw_group(PT_SAMPLER_SOBOL, 0, 0, 100, 1024);
    CHECK(!has_t(0, 10, 0, 2));
}

/* ---- samplers ---- */

/* A sample is a function of (seed, pixel, sample, group, pair) and of no order or state; each of them matters. */
static void draws_have_no_memory(void) {
    uint32_t first[500][2], u[2];
    int k, i;
    for (k = 0; k < 3; k++) {
        int equal = 0;
        test_case("%s", kind_names[k]);
        for (i = 0; i < 500; i++) {
            pti_sampler s = sampler_at(kinds[k], (uint32_t)i % 7, (uint32_t)i % 3, (uint32_t)i / 4, 4, 4);
            pti_draw2(&s, (uint32_t)i % 5, i & 1, first[i]);
        }
        for (i = 499; i >= 0; i--) {                     /* in reverse, with others between */
            pti_sampler s = sampler_at(kinds[k], (uint32_t)i % 7, (uint32_t)i % 3, (uint32_t)i / 4, 4, 4), copy = s;
            pti_draw2(&s, 99, 0, u);
            pti_draw2(&s, (uint32_t)i % 5, i & 1, u);
            CHECK(u[0] == first[i][0] && u[1] == first[i][1]);
            pti_draw2(&s, (uint32_t)i, 0, u);
            CHECK(pti_draw1(&s, (uint32_t)i) == u[0]);
            CHECK(!memcmp(&s, &copy, sizeof s));
            pti_draw2(&s, (uint32_t)i % 5 + 1, i & 1, u);              equal += u[0] == first[i][0];
            pti_draw2(&s, (uint32_t)i % 5, !(i & 1), u);               equal += u[0] == first[i][0];
            pti_sampler_start(&s, s.index + 1); pti_draw2(&s, (uint32_t)i % 5, i & 1, u);       equal += u[0] == first[i][0];
            s = copy;
            s.pixel_seed++; pti_draw2(&s, (uint32_t)i % 5, i & 1, u);  equal += u[0] == first[i][0];
        }
        CHECK(equal < 2);
    }
}
/* Over pixels, every single number of every sampler is uniform, and so are pairs of numbers from anywhere: other
   dimensions, other groups, the neighbouring pixel. */
static void draws_are_independent(void) {
    enum { PIXELS = 40000, NUMBERS = 10 };
    static uint32_t u[PIXELS + 1][NUMBERS];
    int k, index, i, a, b;
    for (k = 0; k < 3; k++)
        for (index = 0; index < 100; index = index * 7 + 3) {
            for (i = 0; i <= PIXELS; i++) {
                pti_sampler s = sampler_at(kinds[k], (uint32_t)i, 7, (uint32_t)index, 4, 4);
                pti_draw2(&s, 0, 0, u[i]);     pti_draw2(&s, 0, 1, u[i] + 2);
                pti_draw2(&s, 1, 0, u[i] + 4); pti_draw2(&s, 1, 1, u[i] + 6);
                pti_draw2(&s, 17, 0, u[i] + 8);
            }
            for (a = 0; a < NUMBERS; a++)
                for (b = a; b < NUMBERS; b++) {          /* b == a: against the pixel to the right */
                    int counts[256] = { 0 };
                    double sum = 0;
                    test_case("%s, sample %d, numbers %d and %d", kind_names[k], index, a, b);
                    for (i = 0; i < PIXELS; i++) {
                        uint32_t x = u[i][a], y = a == b ? u[i + 1][a] : u[i][b];
                        counts[(x >> 28) * 16 + (y >> 28)]++;
                        sum += (fraction(x) - 0.5) * (fraction(y) - 0.5);
                    }
                    CHECK_P(stats_chi2_uniform(counts, 256));
                    CHECK_P(stats_z_test(sum / PIXELS, 0, 1.0 / 12, PIXELS));      /* correlation */
                }
        }
}
/* Within one pixel, over its samples: groups are padded, that is, independent of each other by their shuffles. */
static void groups_are_padded(void) {
    enum { SAMPLES = 4096, PIXELS = 16 };
    int k, i, p, a;
    for (k = 0; k < 3; k++)
        for (a = 0; a < 4; a++) {
            int counts[64] = { 0 };
            test_case("%s, numbers %d of groups 1 and 2", kind_names[k], a);
            for (p = 0; p < PIXELS; p++)
                for (i = 0; i < SAMPLES; i++) {
                    uint32_t x[2], y[2];
                    pti_sampler s = sampler_at(kinds[k], (uint32_t)p, 8, (uint32_t)i, 8, 8);
                    pti_draw2(&s, 1, a / 2, x);
                    pti_draw2(&s, 2, a / 2, y);
                    counts[(x[a % 2] >> 29) * 8 + (y[a % 2] >> 29)]++;
                }
            CHECK_P(stats_chi2_uniform(counts, 64));
        }
}
/* A sample and the next one of the same pixel, over pixels: what is random in them is independent. */
static void successive_samples(void) {
    enum { PIXELS = 15000 };
    static uint32_t now[PIXELS][4], next[PIXELS][4];
    int k, p, i, a, b;
    for (k = 1; k < 3; k++)
        for (i = 0; i < 8; i += 5) {
            for (p = 0; p < PIXELS; p++) {
                pti_sampler s = sampler_at(kinds[k], (uint32_t)p, 9, (uint32_t)i, 4, 4);
                pti_draw2(&s, 1, 0, now[p]);  pti_draw2(&s, 1, 1, now[p] + 2);
                pti_sampler_start(&s, s.index + 1);
                pti_draw2(&s, 1, 0, next[p]); pti_draw2(&s, 1, 1, next[p] + 2);
            }
            for (a = 0; a < 4; a++) for (b = 0; b < 4; b++) {
                int counts[256] = { 0 }, shift = kinds[k] == PT_SAMPLER_STRATIFIED ? 26 : 28;    /* the place in the cell */
                test_case("%s, number %d of sample %d, then number %d", kind_names[k], a, i, b);
                for (p = 0; p < PIXELS; p++) counts[(now[p][a] >> shift & 15) * 16 + (next[p][b] >> shift & 15)]++;
                CHECK_P(stats_chi2_uniform(counts, 256));
            }
        }
}
/* One pass hits every cell once, in both pairs, whatever the shape; the next pass again, shuffled otherwise. */
static void strata_are_hit_once(void) {
    static const uint32_t shapes[][2] = { { 1, 1 }, { 2, 2 }, { 3, 3 }, { 4, 4 }, { 3, 4 }, { 5, 3 }, { 7, 1 }, { 1, 7 }, 
                                          { 8, 8 }, { 16, 16 }, { 13, 17 }, { 32, 32 } };
    static int last[1024];
    int k, pass, pair, inside[16] = { 0 };
    uint32_t i;
    for (k = 0; k < (int)(sizeof shapes / sizeof shapes[0]); k++) {
        uint32_t a = shapes[k][0], b = shapes[k][1], n = a * b;
        for (pair = 0; pair < 2; pair++)
            for (pass = 0; pass < 5; pass++) {
                int hits[1024] = { 0 }, same = 0;
                test_case("%u x %u, pass %d, pair %d", (unsigned)a, (unsigned)b, pass, pair);
                for (i = 0; i < n; i++) {
                    pti_sampler s = sampler_at(PT_SAMPLER_STRATIFIED, 3, 4, (uint32_t)pass * n + i, a, b);
                    uint32_t u[2], cell;
                    pti_draw2(&s, 2, pair, u);
                    cell = (uint32_t)(((uint64_t)u[1] * b) >> 32) * a + (uint32_t)(((uint64_t)u[0] * a) >> 32);
                    hits[cell]++;
                    if (pass) same += last[i] == (int)cell;
                    last[i] = (int)cell;
                    inside[(uint32_t)(u[0] * a) >> 30 | (uint32_t)(u[1] * b) >> 30 << 2]++;   /* the product's fraction */
                }
                for (i = 0; i < n; i++) CHECK_EQ_INT(hits[i], 1);
                if (pass && n >= 16) CHECK(same < 10);
            }
    }
    CHECK_P(stats_chi2_uniform(inside, 16));             /* and the place in the cell is uniform */
}

/* ---- integration ---- */

static double smooth2(const uint32_t *u) { return exp(-fraction(u[0])) * sin(2 * fraction(u[1]) + 1) / 0.59823; }
static double smooth4(const uint32_t *u) {
    return smooth2(u) * (0.5 + fraction(u[2])) * (1 + fraction(u[2]) * fraction(u[3]));
}
/* The slope of log(rms error) against log n, for n = 16 .. 1024, over 60 pixels. `exact` is the mean. */
static double convergence(pt_sampler kind, int from, int dims, double exact) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    int m, p, i, n = 0;
    for (m = 4; m <= 10; m++, n++) {
        double square = 0, x = m * log(2), y;
        for (p = 0; p < 60; p++) {
            double sum = 0;
            draw_group(kind, (uint32_t)p + 1000u * (uint32_t)m, 1, 0, 1u << m);
            for (i = 0; i < 1 << m; i++) sum += dims == 4 ? smooth4(points[i]) : smooth2(points[i] + from);
            square += (sum / (1 << m) - exact) * (sum / (1 << m) - exact);
        }
        y = 0.5 * log(square / 60);
        sx += x; sy += y; sxx += x * x; sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}
static double exact_mean(int dims) {
    double two = (1 - exp(-1)) * (cos(1) - cos(3)) / 2 / 0.59823;
    return dims == 4 ? two * 31 / 24 : two;
}
static void errors_fall(void) {
    double two = exact_mean(2), four = exact_mean(4), slope;
    slope = convergence(PT_SAMPLER_SOBOL, 0, 2, two);    /* -1.5 for Owen's scramble */
    if (!CHECK(slope < -1.2)) FAIL("pair 0: n^%g", slope);
    slope = convergence(PT_SAMPLER_SOBOL, 2, 2, two);
    if (!CHECK(slope < -1.1)) FAIL("pair 1: n^%g", slope);
    slope = convergence(PT_SAMPLER_SOBOL, 0, 4, four);
    if (!CHECK(slope < -0.9)) FAIL("four dimensions: n^%g", slope);
    slope = convergence(PT_SAMPLER_RANDOM, 0, 2, two);
    if (!CHECK(slope < -0.4 && slope > -0.6)) FAIL("random: n^%g", slope);
}
static void means_are_unbiased(void) {
    double two = exact_mean(2), four = exact_mean(4);
    int k, p, i;
    for (k = 0; k < 3; k++) {
        stats_moments a = { 0, 0, 0 }, b = { 0, 0, 0 };
        test_case("%s", kind_names[k]);
        for (p = 0; p < 4000; p++) {
            double x = 0, y = 0;
            draw_group(kinds[k], (uint32_t)p, 5, 0, 12);               /* not a power of two */
            for (i = 0; i < 12; i++) { x += smooth2(points[i] + 2); y += smooth4(points[i]); }
            stats_push(&a, x / 12);
            stats_push(&b, y / 12);
        }
        CHECK_P(stats_t_test(&a, two));
        CHECK_P(stats_t_test(&b, four));
    }
}

/* ---- permutations ---- */

static void permutations(void) {
    static unsigned char seen[70000];
    uint32_t n, i, seed, step;
    for (n = 1; n <= 65537; n = n < 300 ? n + 1 : n * 3 / 2 + (n & 7))
        for (seed = 0; seed < (n < 300 ? 8u : 2u); seed++) {
            int bad = 0;
            test_case("n %u, seed %u", (unsigned)n, (unsigned)seed);
            memset(seen, 0, n);
            for (i = 0; i < n; i++) {
                uint32_t j = pti_permute(i, n, seed * 77777);
                if (j >= n || seen[j]) bad++;
                else seen[j] = 1;
            }
            CHECK_EQ_INT(bad, 0);
        }
    for (n = 0xffffffffu, step = 0; step < 3; n = step == 0 ? 0x80000001u : 0x80000000u, step++)
        for (i = 0; i < 100; i++) CHECK(pti_permute(n - 1 - i, n, 5) < n);         /* large, but it ends */
}
/* Each element goes everywhere equally often, and two of them (almost) independently of each other. */
static void permutations_are_uniform(void) {
    static const uint32_t sizes[] = { 2, 3, 4, 5, 6, 7, 8, 9, 12, 16, 25, 33, 64 };
    int k, i, a;
    for (k = 0; k < (int)(sizeof sizes / sizeof sizes[0]); k++) {
        int n = (int)sizes[k];
        for (a = 0; a < n; a += 1 + n / 5) {
            int counts[64] = { 0 }, together[64] = { 0 };
            test_case("element %d of %d", a, n);
            for (i = 0; i < 8000; i++) {
                uint32_t x = pti_permute((uint32_t)a, sizes[k], pti_hash((uint32_t)i));
                uint32_t y = pti_permute((uint32_t)(a + 1) % sizes[k], sizes[k], pti_hash((uint32_t)i));
                counts[x]++;
                together[(y + sizes[k] - x) % sizes[k]]++;
            }
            CHECK_P(stats_chi2_uniform(counts, n));
            CHECK_EQ_INT(together[0], 0);
            for (i = 1; i < n; i++)                      /* a cheap hash: the distance is only roughly uniform */
                if (fabs(together[i] * (n - 1) / 8000.0 - 1) > 0.3 + 4 * sqrt((n - 1) / 8000.0))
                    FAIL("distance %d: %d of 8000", i, together[i]);
        }
    }
}

/* ---- coins ---- */

static void coins_are_fair(void) {
    static const float weights[] = { 1e-3f, 0.05f, 0.3f, 0.5f, 0.77f, 0.95f, 0.999f };
    pt_rng rng;
    int k, i, j;
    pt_rng_seed(&rng, 6, 2);
    for (k = 0; k < 7; k++) {                            /* the right probability; what is left is uniform on either side */
        static int high[2][256], low[2][256];
        int heads = 0;
        test_case("w = %g", (double)weights[k]);
        memset(high, 0, sizeof high);
        memset(low, 0, sizeof low);
        for (i = 0; i < 300000; i++) {
            uint32_t u = pt_rng_u32(&rng);
            int coin = pti_split(&u, weights[k]);
            heads += coin;
            high[coin][u >> 24]++;
            low[coin][u & 255]++;
        }
        CHECK_P(stats_count_test(heads, 300000, weights[k]));
        for (j = 0; j < 2; j++) {
            CHECK_P(stats_chi2_uniform(high[j], 256));
            CHECK_P(stats_chi2_uniform(low[j], 256));
        }
    }
    for (k = 0; k < 7; k++) {                            /* order is kept on either side: strata stay strata */
        uint32_t last[2] = { 0, 0 };
        double expected;
        int broken = 0, count[2] = { 0, 0 };
        for (i = 0; i < 20000; i++) {
            uint32_t u = (uint32_t)i * 214748u, v = u;
            int coin = pti_split(&u, weights[k]);
            if (count[coin]++ && u < last[coin]) broken++;
            last[coin] = u;
            expected = coin ? fraction(v) / weights[k] : (fraction(v) - weights[k]) / (1 - (double)weights[k]);
            CHECK_NEAR(fraction(u), expected, 1e-6);
        }
        CHECK_EQ_INT(broken, 0);
    }
}
static void coins_at_the_ends(void) {
    static const uint32_t us[] = { 0, 1, 2, 3, 255, 256, 0x7fffffffu, 0x80000000u, 0xffffff00u, 0xfffffffeu, 0xffffffffu };
    float nan = PTI_INF - PTI_INF;
    int i;
    uint32_t u, k;
    for (i = 0; i < 11; i++) {
        u = us[i]; CHECK(pti_split(&u, 0) == 0 && u == us[i]);         /* sure things cost nothing */
        u = us[i]; CHECK(pti_split(&u, 1) == 1 && u == us[i]);
        u = us[i]; CHECK(pti_split(&u, -1) == 0 && u == us[i]);
        u = us[i]; CHECK(pti_split(&u, 2) == 1 && u == us[i]);
        u = us[i]; CHECK(pti_split(&u, nan) == 0 && u == us[i]);
        u = us[i]; CHECK(pti_split(&u, 1e-20f) == 0 && u == us[i]);    /* less than one in 2^32 is never */
        u = us[i]; CHECK(pti_split(&u, 0.99999994f) == (us[i] < 0xffffff00u));
        u = us[i]; CHECK(pti_split(&u, 2.3283064e-10f) == (us[i] == 0));           /* 2^-32 */
        u = us[i]; CHECK(pti_split(&u, 1e-9f) == (us[i] < 4));
    }
    {                                                    /* few values on one side spread over all of [0,1) */
        int counts[8] = { 0 };
        for (k = 0; k < 256; k++) {
            u = 0xffffff00u + k;
            CHECK_EQ_INT(pti_split(&u, 0.99999994f), 0);
            counts[u >> 29]++;
        }
        for (k = 0; k < 8; k++) CHECK_EQ_INT(counts[k], 32);
    }
}
/* Ten choices in a row from one number, as in a mixture of mixtures: what is left is still uniform, whatever was chosen. */
static void coins_nest(void) {
    static int counts[256], low[256], sides[11];
    pt_rng rng;
    int i, k, w;
    pt_rng_seed(&rng, 7, 2);
    for (w = 0; w < 2; w++) {
        float weight = w ? 0.95f : 0.05f;
        double p = pow(0.95, 10), q;
        stats_cell cells[11];
        memset(counts, 0, sizeof counts);
        memset(low, 0, sizeof low);
        memset(sides, 0, sizeof sides);
        for (i = 0; i < 300000; i++) {
            uint32_t u = pt_rng_u32(&rng);
            int rare = 0;
            for (k = 0; k < 10; k++) rare += pti_split(&u, weight) != w;
            sides[rare]++;
            counts[u >> 24]++;
            low[u & 255]++;
        }
        test_case("w = %g", (double)weight);
        CHECK_P(stats_chi2_uniform(counts, 256));
        CHECK_P(stats_chi2_uniform(low, 256));
        for (q = p, k = 0; k < 11; k++) {                /* binomial */
            cells[k].observed = sides[k];
            cells[k].expected = 300000 * q;
            q *= (10.0 - k) / (k + 1) * 0.05 / 0.95;
        }
        CHECK_P(stats_chi2(cells, 11));
    }
    /* The rare side each time, from all the numbers that lead there: 2^22 of them after ten halvings, 1342 after five
       choices with w = 0.05. Each result must be hit equally often, low bits included, although few numbers were left. */
    memset(counts, 0, sizeof counts);
    memset(low, 0, sizeof low);
    for (i = 0; i < 1 << 22; i += 37) {
        uint32_t u = (uint32_t)i;
        for (k = 0; k < 10; k++) if (!pti_split(&u, 0.5f)) break;
        CHECK_EQ_INT(k, 10);
        counts[u >> 24]++;
        low[u & 255]++;
    }
    test_case("ten halvings");
    CHECK_P(stats_chi2_uniform(counts, 256));
    CHECK_P(stats_chi2_uniform(low, 256));
    memset(counts, 0, sizeof counts);
    memset(low, 0, sizeof low);
    for (i = 0; i < 1342; i++) {
        uint32_t u = (uint32_t)i;
        for (k = 0; k < 5; k++) if (!pti_split(&u, 0.05f)) break;
        CHECK(k == 5 || i > 1338);
        if (k == 5) { counts[u >> 28]++; low[u & 15]++; }
    }
    test_case("five choices of one in twenty");
    CHECK_P(stats_chi2_uniform(counts, 16));
    CHECK_P(stats_chi2_uniform(low, 16));
}

void test_random(void) {
    RUN(pcg32); RUN(hashes); RUN(reversed_bits); RUN(sobol_is_sobol); RUN(scramble_is_owens); RUN(prefixes_are_nets);
    RUN(draws_have_no_memory); RUN(draws_are_independent); RUN(groups_are_padded); RUN(successive_samples);
    RUN(strata_are_hit_once); RUN(errors_fall); RUN(means_are_unbiased); RUN(permutations); RUN(permutations_are_uniform);
    RUN(coins_are_fair); RUN(coins_at_the_ends); RUN(coins_nest);
}
