/* flights.h - many flights along one ray, and densities whose depths are known, and a half space
   whose albedo is: for the tests and the figures of media. Include it after pt.h and stats.h. */
#ifndef FLIGHTS_H
#define FLIGHTS_H

/* What flights along a ray do, by internal calls: how many pass, where hits are, and the mean of ratio tracking (of
   every 16th). wrong: a hit where none can be, or a density above its maximum. */
typedef struct flown { double n, passed, hits[4], sum_t; stats_moments T; int wrong; } flown;
static float fly_time;
static inline void fly(const pt_scene *s, pt_vec3 org, pt_vec3 dir, float tmax, int n, flown *out) {
    pti_sampler sampler;
    pti_flight f;
    int i;
    memset(out, 0, sizeof *out);
    memset(&f, 0, sizeof f);
    memset(&sampler, 0, sizeof sampler);
    sampler.kind = PT_SAMPLER_RANDOM;
    sampler.pixel_seed = 77;
    f.volumes = &s->volumes; f.trace = pti_trace_for(s->isa);
    f.org = org; f.dir = pti_normalize(dir);
    f.group = PTI_GROUP_FLIGHT;
    f.time = fly_time;
    for (i = 0; i < n; i++) {
        const pti_volume *hit;
        float t = tmax;
        pti_sampler_start(&sampler, (uint32_t)i);
        f.sampler = &sampler; f.seed = 5; f.index = (uint32_t)i;
        hit = pti_flight_hit(&f, &t);
        out->n++;
        if (!hit) { out->passed++; out->wrong |= t != tmax; }
        else { out->wrong |= !(t >= 0 && t < tmax); out->hits[hit - s->volumes.all < 4 ? hit - s->volumes.all : 3]++; out->sum_t += (double)t; }
        if (i % 16) continue;
        f.sampler = NULL; f.seed = 6;
        stats_push(&out->T, (double)pti_flight_transmittance(&f, tmax).y);
    }
    out->wrong |= f.exceeded;
}

static inline float ramp(void *user, pt_vec3 p) { (void)user; return p.x; }
static inline float ramp_bound(void *user, pt_vec3 lo, pt_vec3 hi) { (void)user; (void)lo; return pti_min(hi.x, 1.01f); }
static inline float bumps(void *user, pt_vec3 p) {                          /* sin^2 of 2 pi x, where that is above 0.3 */
    float s, c;
    (void)user;
    pti_sincos(2 * PTI_PI * p.x, &s, &c);
    return s * s > 0.3f ? s * s : 0;
}
static inline double bumps_tau(void) {
    double sum = 0;
    int i;
    for (i = 0; i < 1000000; i++) { double s = sin(2 * STATS_PI * (i + 0.5) / 1e6); sum += s * s > 0.3 ? s * s : 0; }
    return sum / 1e6;
}
/* A half space of isotropic scatterers under a white sky: seen at the cosine mu, its radiance is the plane albedo
       1 - sqrt(1 - a) H(mu),    H(mu) = 1 + a / 2 mu H(mu) integral of H(x) / (mu + x) over [0,1],
   a the albedo of one scattering (Chandrasekhar 1950). The equation in the better conditioned form
       1 / H(mu) = sqrt(1 - a) + a / 2 integral of x H(x) / (mu + x). */
static inline double chandrasekhar_h(double a, double mu) {
    enum { N = 400 };
    double h[N], x[N], sum = 0, next;
    int i, j, k;
    for (i = 0; i < N; i++) { h[i] = 1; x[i] = (i + 0.5) / N; }
    for (k = 0; k < 200; k++)
        for (i = 0; i < N; i++) {
            for (next = 0, j = 0; j < N; j++) next += x[j] * h[j] / (x[i] + x[j]) / N;
            next = 1 / (sqrt(1 - a) + a / 2 * next);
            h[i] = 0.5 * (h[i] + next);
        }
    for (j = 0; j < N; j++) sum += x[j] * h[j] / (mu + x[j]) / N;
    return 1 / (sqrt(1 - a) + a / 2 * sum);
}
#endif
