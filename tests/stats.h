/* stats.h - statistics for tests: chi-squared, z- and t-tests, and samplers held against their densities. Include it after
   pt.h and test.h. All seeds are fixed. p-values are for CHECK_P of test.h, which corrects for their number. Everything is
   static inline, since no compiler minds when such a function goes unused. */
#ifndef STATS_H
#define STATS_H
#define STATS_PI 3.14159265358979323846

/* Three numbers in [0,1), and a uniform direction. (Never draw twice among the arguments of one call: compilers differ in
   which of them comes first, and a fixed seed then is none.) */
static inline pt_vec3 stats_uniform3(pt_rng *rng) {
    float x = pt_rng_float(rng), y = pt_rng_float(rng), z = pt_rng_float(rng);
    return pt_v3(x, y, z);
}
static inline pt_vec3 stats_direction(pt_rng *rng) {
    pt_vec3 u = stats_uniform3(rng);
    return pti_sample_sphere(u.x, u.y);
}

/* ---- distributions ---- */

/* Q(a, x), the regularised upper incomplete gamma function: by its series below a + 1, by a continued fraction above. */
static inline double stats_gamma_q(double a, double x) {
    double front, sum, term, b, c, d, h;
    int i;
    if (!(x > 0)) return 1;
    front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        for (sum = term = 1 / a, i = 1; i < 10000 && term > sum * 1e-16; i++) sum += term *= x / (a + i);
        return 1 - front * sum;
    }
    b = x + 1 - a; c = 1e300; d = h = 1 / b;             /* Lentz */
    for (i = 1; i < 10000; i++) {
        double an = -i * (i - a), step;
        b += 2;
        d = an * d + b; d = 1 / (d != 0 ? d : 1e-300);
        c = b + an / c; c = c != 0 ? c : 1e-300;
        h *= step = d * c;
        if (fabs(step - 1) < 1e-15) break;
    }
    return front * h;
}
/* I_x(a, b), the regularised incomplete beta function. */
static inline double stats_beta_i(double a, double b, double x) {
    double front, c, d, h;
    int i;
    if (!(x > 0)) return 0;
    if (x >= 1) return 1;
    if (x > (a + 1) / (a + b + 2)) return 1 - stats_beta_i(b, a, 1 - x);
    front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x)) / a;
    c = 1; d = h = 1 / (1 - (a + b) * x / (a + 1));
    for (i = 1; i < 10000; i++) {
        double m = i, even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)), step;
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / (1 + even * d); c = 1 + even / c; h *= d * c;
        d = 1 / (1 + odd * d);  c = 1 + odd / c;  h *= step = d * c;
        if (fabs(step - 1) < 1e-15) break;
    }
    return front * h;
}
static inline double stats_chi2_p(double chi2, double dof) { return stats_gamma_q(dof / 2, chi2 / 2); }
static inline double stats_normal_p(double z) { return erfc(fabs(z) / sqrt(2.0)); }                  /* two-sided */
static inline double stats_student_p(double t, double dof) { return stats_beta_i(dof / 2, 0.5, dof / (dof + t * t)); }
/* The level for each of n independent tests, that gives `overall` for all of them together. */
static inline double stats_sidak(double overall, double n) { return -expm1(log1p(-overall) / n); }

/* ---- means ---- */

typedef struct stats_moments { double n, mean, m2; } stats_moments;    /* start from zero; Welford */
static inline void stats_push(stats_moments *s, double x) {
    double d = x - s->mean;
    s->mean += d / ++s->n;
    s->m2 += d * (x - s->mean);
}
static inline double stats_variance(const stats_moments *s) { return s->n > 1 ? s->m2 / (s->n - 1) : 0; }
static inline double stats_error(const stats_moments *s) { return sqrt(stats_variance(s) / s->n); }    /* of the mean */
/* Is the mean what it should be? Samples that are all the same must hit it, but for rounding. */
static inline double stats_t_test(const stats_moments *s, double expected) {
    double d = s->mean - expected, e = stats_error(s);
    if (fabs(d) <= 1e-12 * fabs(expected)) return 1;
    return e > 0 ? stats_student_p(d / e, s->n - 1) : 0;
}
/* Are two means the same? Welch: variances and numbers may differ. */
static inline double stats_welch_test(const stats_moments *a, const stats_moments *b) {
    double va = stats_variance(a) / a->n, vb = stats_variance(b) / b->n, d = a->mean - b->mean, v = va + vb;
    if (fabs(d) <= 1e-12 * fabs(a->mean)) return 1;
    return v > 0 ? stats_student_p(d / sqrt(v), v * v / (va * va / (a->n - 1) + vb * vb / (b->n - 1))) : 0;
}
/* Is a mean of n, whose single values have a known standard deviation, what it should be? */
static inline double stats_z_test(double mean, double expected, double deviation, double n) {
    return stats_normal_p((mean - expected) / (deviation / sqrt(n)));
}
/* Is a count of n tries with probability p what it should be? */
static inline double stats_count_test(double count, double n, double p) {
    if (p <= 0 || p >= 1) return count == n * p ? 1 : 0;
    return stats_normal_p((count - n * p) / sqrt(n * p * (1 - p)));
}

/* ---- chi-squared goodness of fit ---- */

/* p-value of counts against their expectations. Cells that expect less than 5 are pooled, the least first. Anything in
   cells that expect nothing at all, and that no pool takes up, gives 0. */
typedef struct stats_cell { double observed, expected; } stats_cell;
static inline int stats_by_expected(const void *a, const void *b) {
    double x = ((const stats_cell *)a)->expected, y = ((const stats_cell *)b)->expected;
    return (x > y) - (x < y);
}
static inline double stats_chi2(stats_cell *cells, int n) {            /* sorts them */
    stats_cell pool = { 0, 0 };
    double chi2 = 0;
    int i, used = 0;
    qsort(cells, (size_t)n, sizeof *cells, stats_by_expected);
    for (i = 0; i < n; i++) {
        pool.observed += cells[i].observed;
        pool.expected += cells[i].expected;
        if (pool.expected < 5 || (i + 1 < n && cells[i + 1].expected < 5)) continue;
        chi2 += (pool.observed - pool.expected) * (pool.observed - pool.expected) / pool.expected;
        pool.observed = pool.expected = 0;
        used++;
    }
    if (pool.expected == 0 && pool.observed > 0) return 0;
    return used > 1 ? stats_chi2_p(chi2, used - 1) : 1;
}
static inline double stats_chi2_uniform(const int *counts, int n) {    /* at most 4096 cells */
    stats_cell cells[4096];
    double sum = 0;
    int i;
    for (i = 0; i < n; i++) sum += counts[i];
    for (i = 0; i < n; i++) { cells[i].observed = counts[i]; cells[i].expected = sum / n; }
    return stats_chi2(cells, n);
}

/* ---- a sampler against its density ----
   Both tests draw n samples into a grid over [a0,a1] x [b0,b1] and integrate the density over each cell; both check that
   it integrates to `total`, that it is positive and finite wherever something was drawn, and never negative; a sampler
   that returns 0 ("none drawn") must do so with probability 1 - total. Members that are zero have the default that
   stands beside them. */
typedef struct stats_point { double a, b, density; } stats_point;
typedef struct stats_grid {
    int na, nb;                                          /* cells */
    double a0, a1, b0, b1;
    double (*density)(const void *test, double a, double b);           /* per da db */
    const void *test;
    int n;                                               /* samples, which set how fine the quadrature must be */
    stats_point *points;                                 /* those within the grid, with the density there */
    int count;
    pt_rng jitter;
    long work;                                           /* boxes looked at, lest a senseless density take for ever */
    double *observed;                                    /* na * nb cells, those outside the grid, "none drawn" */
} stats_grid;

/* Moves the points below `at` to the front; how many. */
static inline int stats_part(stats_point *p, int n, int by_b, double at) {
    int i, low = 0;
    for (i = 0; i < n; i++)
        if ((by_b ? p[i].b : p[i].a) < at) { stats_point t = p[i]; p[i] = p[low]; p[low++] = t; }
    return low;
}
/* Midpoint rule with 16 points, halved until 4 points say the same to a tenth of a sample. Where the density jumps (it
   differs much between the points, or did so one level above) that may be chance: there it goes on until one sample is
   all there is, with jittered points, so that no error repeats. The n samples p that fell here only show where to look
   closely, lest something thin be missed. */
static inline double stats_integrate(stats_grid *g, double a, double b, double da, double db, int depth, int jump,
                                     stats_point *p, int n) {
    double fine = 0, coarse = 0, area = da * db, least = HUGE_VAL, most = 0;
    int i, j, jumps, cut[3];
    for (i = 0; i < 4; i++) for (j = 0; j < 4; j++) {
        double x = jump ? pt_rng_float(&g->jitter) : 0.5, y = jump ? pt_rng_float(&g->jitter) : 0.5;
        double f = g->density(g->test, a + da * (i + x) / 4, b + db * (j + y) / 4);
        fine += f;
        least = f < least ? f : least;
        most = f > most ? f : most;
    }
    for (i = 0; i < 2; i++) for (j = 0; j < 2; j++) {    /* a straight edge that cuts in somewhere cuts off a corner */
        double f = g->density(g->test, a + i * da, b + j * db);
        least = f < least ? f : least;
        most = f > most ? f : most;
    }
    for (i = 0; i < n; i++) most = p[i].density > most ? p[i].density : most;
    jumps = least < 0.5 * most;
    fine *= area / 16;
    if (depth >= 2) {                                    /* at least 16 x 16 points a cell */
        if (depth >= 16 || g->work++ > 2000000 || (most > 0 && most * area * g->n < 1)) return fine;
        if (!jumps && !jump) {
            for (i = 0; i < 2; i++) for (j = 0; j < 2; j++)
                coarse += g->density(g->test, a + da * (i + 0.5) / 2, b + db * (j + 0.5) / 2);
            if (fabs(fine - coarse * area / 4) * g->n < 0.1) return fine;
        }
    }
    da /= 2; db /= 2;
    cut[1] = stats_part(p, n, 0, a + da);
    cut[0] = stats_part(p, cut[1], 1, b + db);
    cut[2] = cut[1] + stats_part(p + cut[1], n - cut[1], 1, b + db);
    return stats_integrate(g, a, b, da, db, depth + 1, jumps, p, cut[0])
         + stats_integrate(g, a, b + db, da, db, depth + 1, jumps, p + cut[0], cut[1] - cut[0])
         + stats_integrate(g, a + da, b, da, db, depth + 1, jumps, p + cut[1], cut[2] - cut[1])
         + stats_integrate(g, a + da, b + db, da, db, depth + 1, jumps, p + cut[2], n - cut[2]);
}
static inline int stats_grid_start(stats_grid *g) {
    g->observed = (double *)calloc((size_t)g->na * (size_t)g->nb + 2, sizeof *g->observed);
    g->points = (stats_point *)calloc((size_t)g->n, sizeof *g->points);
    pt_rng_seed(&g->jitter, 1, 1);
    return (g->observed && g->points) || FAIL("out of memory");
}
static inline void stats_grid_add(stats_grid *g, double a, double b, int row, int column) {
    stats_point *p = &g->points[g->count++];
    g->observed[row * g->nb + column]++;
    p->a = a; p->b = b; p->density = g->density(g->test, a, b);
}

/* The checks at the end, and the p-value; frees what start allocated. */
static inline double stats_grid_test(stats_grid *g, double total, double tolerance, int partial) {
    int i, j, cells = g->na * g->nb, worst_i = 0, worst_j = 0, row, column, used = 0;
    double da = (g->a1 - g->a0) / g->na, db = (g->b1 - g->b0) / g->nb, integral = 0, none = 1 - total, p, worst_chi2 = 0;
    double outside = g->observed[cells], undrawn = g->observed[cells + 1];
    stats_cell *cell = (stats_cell *)calloc((size_t)cells + 2, sizeof *cell), worst = { 0, 0 };
    if (!cell) return FAIL("out of memory");
    for (i = 0; i < g->na; i++) {
        row = i + 1 < g->na ? stats_part(g->points + used, g->count - used, 0, g->a0 + (i + 1) * da) : g->count - used;
        for (j = 0; j < g->nb; j++) {
            stats_cell *c = &cell[i * g->nb + j];
            double mass, d;
            column = j + 1 < g->nb ? stats_part(g->points + used, row, 1, g->b0 + (j + 1) * db) : row;
            mass = stats_integrate(g, g->a0 + i * da, g->b0 + j * db, da, db, 0, 0, g->points + used, column);
            used += column;
            row -= column;
            integral += mass;
            c->observed = g->observed[i * g->nb + j];
            c->expected = mass * g->n;
            d = c->observed - c->expected;
            if (d * d / (c->expected + 1) <= worst_chi2) continue;
            worst_chi2 = d * d / (c->expected + 1);
            worst = *c; worst_i = i; worst_j = j;
        }
    }
    cell[cells].observed = outside;
    cell[cells].expected = partial && total > integral ? (total - integral) * g->n : 0;
    cell[cells + 1].observed = undrawn;
    cell[cells + 1].expected = none > 1e-9 ? none * g->n : 0;
    if (partial) CHECK(integral <= total + tolerance);
    else         test_near(integral, total, tolerance, __FILE__, __LINE__, "the density's integral");
    if (!partial && outside > 0) FAIL("%g samples were drawn outside of where all of them should be", outside);
    if (none <= 1e-9 && undrawn > 0) FAIL("%g times none was drawn, but the total is 1", undrawn);
    p = stats_chi2(cell, cells + 2);
    free(cell); free(g->points); free(g->observed);
    if (!CHECK_P(p))
        FAIL("worst cell [%.4g,%.4g] x [%.4g,%.4g]: %.0f drawn, %.1f expected", g->a0 + worst_i * da,
             g->a0 + (worst_i + 1) * da, g->b0 + worst_j * db, g->b0 + (worst_j + 1) * db, worst.observed, worst.expected);
    return p;
}

/* What the densities said at the samples. */
typedef struct stats_bad { int zero, infinite, n; } stats_bad;
static inline void stats_judge(stats_bad *bad, double pdf) {
    bad->n++;
    if (!(pdf > 0)) bad->zero++;
    else if (!(pdf < 1e30)) bad->infinite++;
}
static inline void stats_report(const stats_bad *bad, int zero_allowed) {
    if (bad->zero > zero_allowed) FAIL("%d of %d samples were drawn where the pdf is 0", bad->zero, bad->n);
    if (bad->infinite) FAIL("%d of %d samples have an infinite pdf", bad->infinite, bad->n);
}

/* Unit directions. The grid is over (1 - cos theta, phi) about axis, the cap 1 - cos theta < zoom of it; so that small
   features can be looked at closely (zoom), or fall inside of cells rather than on the pole (axis). */
typedef struct chi2_directions_desc {
    int    (*sample)(void *ctx, pt_rng *rng, pt_vec3 *wi);             /* 0 = none drawn */
    double (*pdf)(void *ctx, pt_vec3 wi);                              /* per steradian */
    void *ctx;
    double total;                                        /* 0 = 1; what the pdf integrates to over the sphere */
    double tolerance;                                    /* of that integral; 0 = 0.002 */
    double ax, ay, az;                                   /* axis; all 0 = +z */
    double zoom;                                         /* 1 - cos of the cap; 0 = 2, the whole sphere */
    int partial;                                         /* the density reaches beyond the cap (else that is an error) */
    int n, cells_cos, cells_phi;                         /* samples, cells; 0 = 100000, 10, 20 */
    int zero_allowed;                                    /* samples whose pdf may be 0: edges of tiny things, by rounding */
    uint64_t seed;
} chi2_directions_desc;

typedef struct stats_frame { double t[3], b[3], n[3]; const chi2_directions_desc *d; } stats_frame;
static inline stats_frame stats_frame_about(double x, double y, double z) {
    stats_frame f;
    double l = sqrt(x * x + y * y + z * z), s, a;
    memset(&f, 0, sizeof f);
    if (l > 0) { x /= l; y /= l; z /= l; } else z = 1;
    s = z >= 0 ? 1 : -1; a = -1 / (s + z);               /* Duff et al. 2017 */
    f.t[0] = 1 + s * x * x * a; f.t[1] = s * x * y * a;  f.t[2] = -s * x;
    f.b[0] = x * y * a;         f.b[1] = s + y * y * a;  f.b[2] = -y;
    f.n[0] = x;                 f.n[1] = y;              f.n[2] = z;
    return f;
}
static inline double stats_direction_density(const void *test, double h, double phi) {
    const stats_frame *f = (const stats_frame *)test;
    double r = sqrt(h * (2 - h) > 0 ? h * (2 - h) : 0), x = r * cos(phi), y = r * sin(phi), z = 1 - h, w[3], pdf;
    int k;
    for (k = 0; k < 3; k++) w[k] = x * f->t[k] + y * f->b[k] + z * f->n[k];
    pdf = f->d->pdf(f->d->ctx, pt_v3((float)w[0], (float)w[1], (float)w[2]));
    if (pdf >= 0 && pdf < 1e30) return pdf;              /* dh dphi is the solid angle itself */
    FAIL("the pdf of (%g, %g, %g) is %g", w[0], w[1], w[2], pdf);
    return 0;
}
/* Runs the test and all its checks; returns the p-value. */
static inline double chi2_directions(const chi2_directions_desc *d) {
    stats_frame f = stats_frame_about(d->ax, d->ay, d->az);
    stats_grid g;
    stats_bad bad = { 0, 0, 0 };
    double total = d->total > 0 ? d->total : 1, longest = 0;
    pt_rng rng;
    int i, cells;
    f.d = d;
    memset(&g, 0, sizeof g);
    g.na = d->cells_cos ? d->cells_cos : 10;
    g.nb = d->cells_phi ? d->cells_phi : 20;
    g.n = d->n ? d->n : 100000;
    g.a1 = d->zoom > 0 ? d->zoom : 2;
    g.b0 = -STATS_PI; g.b1 = STATS_PI;
    g.density = stats_direction_density;
    g.test = &f;
    cells = g.na * g.nb;
    if (!stats_grid_start(&g)) return 0;
    pt_rng_seed(&rng, d->seed + 1, 0x5eed);
    for (i = 0; i < g.n; i++) {
        pt_vec3 w = { 0, 0, 0 };
        double l, x, y, z, dx, dy, dz, h, phi;
        int row, column;
        if (!d->sample(d->ctx, &rng, &w)) { g.observed[cells + 1]++; continue; }
        l = sqrt((double)w.x * w.x + (double)w.y * w.y + (double)w.z * w.z);
        if (!(fabs(l - 1) <= longest)) longest = fabs(l - 1);
        if (!(l > 0)) { g.observed[cells]++; continue; }
        stats_judge(&bad, d->pdf(d->ctx, w));
        dx = w.x / l - f.n[0]; dy = w.y / l - f.n[1]; dz = w.z / l - f.n[2];
        h = (dx * dx + dy * dy + dz * dz) / 2;           /* 1 - cos, exact near the axis */
        x = w.x * f.t[0] + w.y * f.t[1] + w.z * f.t[2];
        y = w.x * f.b[0] + w.y * f.b[1] + w.z * f.b[2];
        z = h / g.a1 * g.na;
        phi = atan2(y, x);
        row = (int)z; column = (int)((phi + STATS_PI) / (2 * STATS_PI) * g.nb);
        if (z >= g.na && z < g.na * (1 + 1e-3)) row = g.na - 1;        /* rounding on the rim */
        if (column >= g.nb) column = g.nb - 1;
        if (row < g.na) stats_grid_add(&g, h, phi, row, column);
        else g.observed[cells]++;
    }
    if (!(longest < 2e-6)) FAIL("a direction's length is wrong by %g", longest);
    stats_report(&bad, d->zero_allowed);
    return stats_grid_test(&g, total, d->tolerance > 0 ? d->tolerance : 0.002, d->partial);
}

/* Points of a rectangle, [0,1]^2 unless x0 .. y1 say otherwise. */
typedef struct chi2_square_desc {
    int    (*sample)(void *ctx, pt_rng *rng, float xy[2]);             /* 0 = none drawn */
    double (*pdf)(void *ctx, float x, float y);                        /* per unit area */
    void *ctx;
    double x0, x1, y0, y1;                               /* all 0 = [0,1]^2 */
    double total, tolerance;                             /* 0 = 1; of that integral, 0 = 0.002 */
    int n, cells_x, cells_y;                             /* samples, cells; 0 = 100000, 20, 20 */
    int zero_allowed;
    uint64_t seed;
} chi2_square_desc;

static inline double stats_square_density(const void *test, double x, double y) {
    const chi2_square_desc *d = (const chi2_square_desc *)test;
    double pdf = d->pdf(d->ctx, (float)x, (float)y);
    if (pdf >= 0 && pdf < 1e30) return pdf;
    FAIL("the pdf of (%g, %g) is %g", x, y, pdf);
    return 0;
}
static inline double chi2_square(const chi2_square_desc *d) {
    stats_grid g;
    stats_bad bad = { 0, 0, 0 };
    pt_rng rng;
    int i, cells, given = d->x0 != 0 || d->x1 != 0 || d->y0 != 0 || d->y1 != 0;
    memset(&g, 0, sizeof g);
    g.na = d->cells_x ? d->cells_x : 20;
    g.nb = d->cells_y ? d->cells_y : 20;
    g.n = d->n ? d->n : 100000;
    g.a0 = given ? d->x0 : 0; g.a1 = given ? d->x1 : 1;
    g.b0 = given ? d->y0 : 0; g.b1 = given ? d->y1 : 1;
    g.density = stats_square_density;
    g.test = d;
    cells = g.na * g.nb;
    if (!stats_grid_start(&g)) return 0;
    pt_rng_seed(&rng, d->seed + 1, 0x5eed);
    for (i = 0; i < g.n; i++) {
        float xy[2] = { 0, 0 };
        double x, y;
        if (!d->sample(d->ctx, &rng, xy)) { g.observed[cells + 1]++; continue; }
        x = (xy[0] - g.a0) / (g.a1 - g.a0) * g.na;
        y = (xy[1] - g.b0) / (g.b1 - g.b0) * g.nb;
        if (!(x >= 0 && x < g.na && y >= 0 && y < g.nb)) { g.observed[cells]++; continue; }
        stats_judge(&bad, d->pdf(d->ctx, xy[0], xy[1]));
        stats_grid_add(&g, xy[0], xy[1], (int)x, (int)y);
    }
    stats_report(&bad, d->zero_allowed);
    return stats_grid_test(&g, d->total > 0 ? d->total : 1, d->tolerance > 0 ? d->tolerance : 0.002, 0);
}
#endif
