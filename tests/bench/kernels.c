/* kernels.c - how fast are pt.h's ray queries? The same rays for pt.h and, where it is installed, Embree 3 (libembree-dev): one ray
   at a time, in one thread, interleaved; processor time, medians. kernels.sh builds this and passes on what libraries there are.
   --help says what it can do. */
#define _GNU_SOURCE
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "kernels.h"
#include "kernels_scenes.h"
#include "timing.h"

#define ADD(name) extern const kernel_library name;
KERNELS_LIBRARIES(ADD)
#undef ADD
static const kernel_library *const known[] = {
#define ADD(name) &name,
    KERNELS_LIBRARIES(ADD)
#undef ADD
};
enum { KNOWN = sizeof known / sizeof *known, MOST_RUNS = 99, SLICES = 16 };
enum { PRIMARY, DIFFUSE1, DIFFUSE2, SHADOW0, SHADOW1, SETS };
static const char *const set_names[SETS] = { "primary", "diffuse 1", "diffuse 2", "shadow 0", "shadow 1" };
typedef struct ray_set { kernel_ray *rays; size_t count; float *t; } ray_set;

typedef struct options {
    int quick, runs, size, build, threads;
    size_t leaks;
    const char *isa, *scenes, *csv;
    const kernel_library *libraries[KNOWN];
    int library_count;
} options;

static double processor_time(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- rays ---- */

static void sub(const float a[3], const float b[3], float out[3]) { int k; for (k = 0; k < 3; k++) out[k] = a[k] - b[k]; }
static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void cross(const float a[3], const float b[3], float out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1]; out[1] = a[2] * b[0] - a[0] * b[2]; out[2] = a[0] * b[1] - a[1] * b[0];
}
static float normalize(float a[3]) {
    float length = sqrtf(dot(a, a));
    int k;
    for (k = 0; k < 3; k++) a[k] /= length;
    return length;
}
/* The surface is known by its distance alone: three neighbouring rays tell its normal, by which the new origin moves off it. */
static int step_off(const kernel_library *l, void *built, const kernel_ray *r, float t, float size, float p[3], float n[3]) {
    kernel_ray near_by[2];
    float hit[2], q[2][3], a[3] = { 0, 0, 0 }, e[2][3];
    int i, k, axis = fabsf(r->dir[0]) < 0.5f ? 0 : fabsf(r->dir[1]) < 0.5f ? 1 : 2;
    a[axis] = 1;
    cross(r->dir, a, e[0]); normalize(e[0]);
    cross(r->dir, e[0], e[1]);
    for (k = 0; k < 3; k++) p[k] = r->org[k] + t * r->dir[k];
    for (i = 0; i < 2; i++) {
        near_by[i] = *r;
        for (k = 0; k < 3; k++) near_by[i].dir[k] = p[k] + e[i][k] * size * 1e-5f - r->org[k];
        normalize(near_by[i].dir);
    }
    l->closest(built, near_by, 2, hit);
    for (i = 0; i < 2; i++) {
        if (hit[i] > 1e30f) return 0;
        for (k = 0; k < 3; k++) q[i][k] = near_by[i].org[k] + hit[i] * near_by[i].dir[k] - p[k];
    }
    cross(q[0], q[1], n);
    if (!(dot(n, n) > 0)) return 0;
    normalize(n);
    if (dot(n, r->dir) > 0) for (k = 0; k < 3; k++) n[k] = -n[k];
    for (k = 0; k < 3; k++) p[k] += n[k] * size * 1e-4f;
    return 1;
}
static void add_shadow(const kernel_scene *s, kernel_random *r, const float p[3], const float n[3], ray_set *out) {
    kernel_ray *ray = out->rays + out->count;
    float u = random_float(r), v = random_float(r);
    int k;
    for (k = 0; k < 3; k++) {
        ray->org[k] = p[k];
        ray->dir[k] = s->light[0][k] + u * s->light[1][k] + v * s->light[2][k] - p[k];
    }
    if (!(dot(ray->dir, n) > 0)) return;
    ray->tmin = 0;
    ray->tmax = 0.999f * normalize(ray->dir);
    out->count++;
}
static void add_diffuse(kernel_random *r, const float p[3], const float n[3], ray_set *out) {
    kernel_ray *ray = out->rays + out->count;
    float z = 2 * random_float(r) - 1, a = 6.2831853f * random_float(r), x = sqrtf(1 - z * z);
    int k;
    ray->dir[0] = n[0] + x * cosf(a); ray->dir[1] = n[1] + x * sinf(a); ray->dir[2] = n[2] + z;
    if (!(dot(ray->dir, ray->dir) > 1e-6f)) return;
    for (k = 0; k < 3; k++) ray->org[k] = p[k];
    normalize(ray->dir);
    ray->tmin = 0; ray->tmax = 1e30f;
    out->count++;
}
static void make_rays(const kernel_scene *s, const kernel_library *l, void *built, int size, ray_set set[SETS]) {
    size_t n = (size_t)size * (size_t)size, i;
    float f[3], right[3], up[3] = { 0, 1, 0 }, half = tanf(s->fov * 0.5f * 3.14159265f / 180), extent = 10;
    kernel_random r = random_seed(11);
    int k, x, y;
    for (k = 0; k < SETS; k++) {
        set[k].rays = (kernel_ray *)calloc(n + 1, sizeof(kernel_ray));
        set[k].t = (float *)calloc(n + 1, sizeof(float));
        set[k].count = 0;
    }
    sub(s->at, s->eye, f); normalize(f);
    cross(f, up, right); normalize(right);
    cross(right, f, up);
    for (y = 0; y < size; y++) for (x = 0; x < size; x++) {
        kernel_ray *ray = set[PRIMARY].rays + set[PRIMARY].count++;
        float a = (2 * ((float)x + 0.5f) / (float)size - 1) * half, b = (1 - 2 * ((float)y + 0.5f) / (float)size) * half;
        for (k = 0; k < 3; k++) { ray->org[k] = s->eye[k]; ray->dir[k] = f[k] + a * right[k] + b * up[k]; }
        normalize(ray->dir);
        ray->tmin = 0; ray->tmax = 1e30f;
    }
    for (k = PRIMARY; k <= DIFFUSE1; k++) {              /* later rays start at every fourth pixel */
        l->closest(built, set[k].rays, set[k].count, set[k].t);
        for (i = 0; i < set[k].count; i += k == PRIMARY ? 4 : 1) {
            float p[3], normal[3];
            if (set[k].t[i] > 1e30f || !step_off(l, built, set[k].rays + i, set[k].t[i], extent, p, normal)) continue;
            add_shadow(s, &r, p, normal, &set[SHADOW0 + k]);
            add_diffuse(&r, p, normal, &set[k + 1]);
        }
    }
}

/* ---- the races ---- */

typedef struct score { double log_sum; int count; } score;
static void score_add(score *s, double ratio) { s->log_sum += log(ratio); s->count++; }
static double score_mean(const score *s) { return s->count ? exp(s->log_sum / s->count) : 0.0; }
typedef struct scores { score closest, any, build, memory; double worst; } scores;
static void print_score(const char *name, const score *s) {
    if (s->count) printf(" %s %.2f", name, score_mean(s)); else printf(" %s -", name);
}
static void print_scores(const char *ours, const char *theirs, const scores *s) {
    printf("%s %s:", ours, theirs);
    print_score("closest", &s->closest); print_score("any", &s->any); print_score("build", &s->build); print_score("memory", &s->memory);
}

static size_t differences(const ray_set *s, const float *t) {
    size_t i, n = 0;
    for (i = 0; i < s->count; i++) n += !(s->t[i] == t[i] || fabsf(s->t[i] - t[i]) <= 1e-4f * (s->t[i] + 1));
    return n;
}
static void race_rays(const options *o, const kernel_scene *s, void *built[], ray_set set[SETS], scores total[], FILE *csv) {
    double times[KNOWN][MOST_RUNS], speed[KNOWN], base = 0;
    float *t[KNOWN];
    int k, i, run;
    size_t slice, wrong;
    for (i = 0; i < o->library_count; i++) t[i] = (float *)calloc(set[PRIMARY].count + 1, sizeof *t[i]);
    for (k = 0; k < SETS; k++) {
        for (run = -1; run < o->runs; run++) {           /* the first warms up, and says what should be hit */
            for (i = 0; i < o->library_count; i++) times[i][run < 0 ? 0 : run] = 0;
            for (slice = 0; slice < SLICES; slice++) {   /* in turns, so that what else goes on here harms all alike */
                size_t begin = set[k].count * slice / SLICES, n = set[k].count * (slice + 1) / SLICES - begin;
                for (i = 0; i < o->library_count; i++) {
                    const kernel_library *l = o->libraries[i];
                    double start = processor_time(CLOCK_THREAD_CPUTIME_ID);
                    (k < SHADOW0 ? l->closest : l->any)(built[i], set[k].rays + begin, n, t[i] + begin);
                    times[i][run < 0 ? 0 : run] += processor_time(CLOCK_THREAD_CPUTIME_ID) - start;
                }
            }
            if (run < 0) memcpy(set[k].t, t[0], set[k].count * sizeof *t[0]);
        }
        printf("  %-10s", set_names[k]);
        for (i = 0; i < o->library_count; i++) {
            speed[i] = (double)set[k].count / median(times[i], o->runs) * 1e-6;
            if (i == 0) { base = speed[0]; printf(" %7.2f M rays/s", base); continue; }
            printf("   %s %6.2f = %5.3f", o->libraries[i]->name, speed[i], speed[i] / base);
            wrong = differences(&set[k], t[i]);
            if (wrong) printf(" (%.3f %% differ)", 100 * (double)wrong / (double)set[k].count);
            score_add(k < SHADOW0 ? &total[i].closest : &total[i].any, speed[i] / base);
            if (speed[i] / base < total[i].worst) total[i].worst = speed[i] / base;
        }
        printf("   %lu rays\n", (unsigned long)set[k].count);
        if (csv) for (i = 0; i < o->library_count; i++)
            fprintf(csv, "%s,%s,%s,%.4f\n", s->name, set_names[k], o->libraries[i]->name, speed[i]);
        fflush(stdout);
    }
    for (i = 0; i < o->library_count; i++) free(t[i]);
}
static void race_builds(const options *o, const kernel_scene *s, scores total[], FILE *csv) {
    double times[KNOWN][MOST_RUNS], builds[MOST_RUNS], bytes[KNOWN], base = 0, triangles = 0;
    int i, run, threads, runs = o->quick ? 3 : 5;
    for (i = 0; i < s->parts; i++) triangles += (double)s->part[i].triangles;
    for (threads = 1; threads <= 2; threads++) {
        for (run = 0; run < runs; run++)
            for (i = 0; i < o->library_count; i++) {
                clockid_t clock = threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC;
                double start = processor_time(clock);
                void *b = o->libraries[i]->build(s, NULL, threads);
                times[i][run] = processor_time(clock) - start;
                bytes[i] = o->libraries[i]->bytes(b);
                o->libraries[i]->destroy(b);
            }
        printf("  build, %d thread%s", threads, threads == 1 ? " " : "s");
        for (i = 0; i < o->library_count; i++) {
            double t = median(times[i], runs);
            printf("   %s %.0f ns", o->libraries[i]->name, t / triangles * 1e9);
            if (threads == 1) printf(", %.1f bytes a triangle", bytes[i] / triangles);
            if (i == 0) base = t;
            else {
                printf(" = %.2f", base / t);
                score_add(&total[i].build, base / t);
                if (threads == 1) score_add(&total[i].memory, bytes[0] / bytes[i]);
            }
            if (csv)
                fprintf(csv, "%s,build with %d threads,%s,%.1f\n", s->name, threads, o->libraries[i]->name, t / triangles * 1e9);
        }
        printf("\n");
    }
    for (i = 0; i < o->library_count; i++) {             /* per processor second, on one thread */
        double start, t[2];
        void *b;
        if (!o->libraries[i]->refit) continue;
        for (run = 0; run < runs; run++) {
            start = processor_time(CLOCK_PROCESS_CPUTIME_ID);
            b = o->libraries[i]->build(s, NULL, 1);
            t[0] = processor_time(CLOCK_PROCESS_CPUTIME_ID);
            o->libraries[i]->refit(b);
            t[1] = processor_time(CLOCK_PROCESS_CPUTIME_ID);
            times[i][run] = (t[1] - t[0]) / triangles * 1e9;
            builds[run] = (t[0] - start) / triangles * 1e9;
            o->libraries[i]->destroy(b);
        }
        base = median(times[i], runs);
        printf("  refit, %s: %.0f ns a triangle, %.1f times as fast as building\n", o->libraries[i]->name, base,
               median(builds, runs) / base);
        if (csv) fprintf(csv, "%s,refit,%s,%.1f\n", s->name, o->libraries[i]->name, base);
    }
}
static int race(const options *o, const char *name, scores total[], FILE *csv) {
    kernel_scene s;
    ray_set set[SETS];
    void *built[KNOWN];
    double triangles = 0;
    int i;
    if (!scene_make(&s, name)) { printf("%s: its mesh is not in ../shared/data, skipped\n", name); return 0; }
    for (i = 0; i < s.parts; i++) triangles += (double)s.part[i].triangles;
    printf("%s, %.0f triangles\n", name, triangles);
    for (i = 0; i < o->library_count; i++) {
        built[i] = o->libraries[i]->build(&s, o->isa, o->threads);
        if (!built[i]) { printf("%s could not build it, or not for --isa %s\n", o->libraries[i]->name, o->isa ? o->isa : "(the best)"); exit(1); }
    }
    make_rays(&s, o->libraries[o->library_count - 1], built[o->library_count - 1], o->size, set);
    race_rays(o, &s, built, set, total, csv);
    for (i = 0; i < o->library_count; i++) o->libraries[i]->destroy(built[i]);
    if (o->build && triangles > 50000) race_builds(o, &s, total, csv);
    for (i = 0; i < SETS; i++) { free(set[i].rays); free(set[i].t); }
    scene_free(&s);
    return 1;
}

/* ---- leaks: rays aimed at edges and corners of a closed ball, along lines through its middle, so that all must hit ---- */

enum { AIM_BATCH = 4096 };
static float distance(const float a[3], const float b[3]) { float d[3]; sub(a, b, d); return sqrtf(dot(d, d)); }
static void aim(const kernel_part *m, int kind, kernel_random *r, kernel_ray *ray) {
    uint32_t corner = (uint32_t)(random_float(r) * 16777216) % (uint32_t)(3 * m->triangles);
    const float *a = m->positions + 3 * (size_t)m->indices[corner];
    const float *b = m->positions + 3 * (size_t)m->indices[corner - corner % 3 + (corner + 1) % 3];
    float along = random_float(r), p[3], middle[3], away = kind == 1 ? 0.001f + 3 * along : kind == 2 ? 1e6f : 0;
    int k, where = (int)(random_float(r) * 3);
    along = where == 0 ? 0.0f : where == 1 ? 0.5f : random_float(r);
    for (k = 0; k < 3; k++) {
        p[k] = a[k] + along * (b[k] - a[k]);
        middle[k] = 0.05f * (random_float(r) - 0.5f);
        ray->org[k] = kind ? p[k] + away * (p[k] - middle[k]) : middle[k];
        ray->dir[k] = (kind ? middle[k] : p[k]) - ray->org[k];
    }
    normalize(ray->dir);
    ray->tmin = 0;
    ray->tmax = kind ? (kind == 2 ? 1.0f : 0.5f) + away * distance(p, middle) : 1e30f;       /* not the far side */
}
static void count_leaks(const options *o) {
    static const char *const kinds[3] = { "from inside", "from outside", "from 10^6 times its size" };
    static const double center[3] = { 0, 0, 0 };
    kernel_ray rays[AIM_BATCH];
    float t[AIM_BATCH];
    kernel_scene s;
    int i, kind;
    size_t n, k, batch;
    memset(&s, 0, sizeof s);
    s.parts = 1;
    scene_blob(&s.part[0], center, 1, 40, 0.3, 5);
    for (i = 0; i < o->library_count; i++) {
        const kernel_library *l = o->libraries[i];
        void *built = l->build(&s, o->isa, 1);
        if (!built) { printf("%s could not build it, or not for --isa %s\n", l->name, o->isa ? o->isa : "(the best)"); exit(1); }
        printf("%s: rays aimed at edges and corners that hit nothing:", l->name);
        for (kind = 0; kind < 3; kind++) {
            kernel_random r = random_seed((uint32_t)kind);
            size_t leaks = 0;
            for (n = 0; n < o->leaks / 3; n += batch) {
                batch = o->leaks / 3 - n < AIM_BATCH ? o->leaks / 3 - n : AIM_BATCH;
                for (k = 0; k < batch; k++) aim(&s.part[0], kind, &r, rays + k);
                l->any(built, rays, batch, t);
                for (k = 0; k < batch; k++) leaks += t[k] == 0;
            }
            printf(" %lu %s%s", (unsigned long)leaks, kinds[kind], kind < 2 ? "," : "");
        }
        printf(", of %lu each\n", (unsigned long)(o->leaks / 3));
        l->destroy(built);
    }
    scene_free(&s);
}

static const char help[] =
    "usage: kernels [options]\n"
    "  --quick              512 x 512 primary rays, medians of 3\n"
    "  --size N, --runs N   N x N primary rays (1024; 16 to 8192), medians of N (7; 99 at most)\n"
    "  --scenes a,b,...     of cornell, bunny, arch, blobs, instances, and grow with a number of triangles; bunny is read from\n"
    "                       ../shared/data/meshes, and left out where that is not\n"
    "  --grow               scenes of 10^2 to 10^7 triangles, to see what a ray costs\n"
    "  --libraries a,b,...  of those below; the first is what all others are compared with: embree, if it is here\n"
    "  --isa NAME           scalar, sse2, avx2 or neon; Embree has no scalar, and uses AVX2 then\n"
    "  --threads N          for the trees that rays are shot at (2); building is timed with 1 and 2\n"
    "  --no-build           does not time building\n"
    "  --leaks RAYS         so many rays at edges and corners of a closed mesh instead: how many pass?\n"
    "  --csv FILE           keeps the figures\n"
    "libraries: pt, pt_native (-O3 -march=native), pt_best (PT_QUALITY_BEST), embree, embree_robust,\n"
    "           embree_best (RTC_BUILD_QUALITY_HIGH)\n"
    "here:";
static void print_help(void) {
    int k;
    printf("%s", help);
    for (k = 0; k < (int)KNOWN; k++) printf(" %s", known[k]->name);
    printf("\n");
}
static int is_here(const char *library) {
    int k;
    for (k = 0; k < (int)KNOWN; k++) if (!strcmp(known[k]->name, library)) return 1;
    return 0;
}
/* A whole number in its range; 0, after a word about it, if that is none. */
static int number(const char *option, const char *text, double least, double most, double *out) {
    char *end;
    *out = strtod(text, &end);
    if (end != text && !*end && *out >= least && *out <= most && *out == floor(*out)) return 1;
    fprintf(stderr, "kernels: %s is a whole number from %.0f to %.0f, not '%s'\n", option, least, most, text);
    return 0;
}
/* Of names and commas: are they scenes? Those with a number are made to measure. */
static int are_scenes(const char *list) {
    static const char *const names[5] = { "cornell", "bunny", "arch", "blobs", "instances" };
    const char *p = list;
    if (!*list) { fprintf(stderr, "kernels: --scenes names none; see --help\n"); return 0; }
    while (*p) {
        int n = (int)strcspn(p, ","), k;
        for (k = 0; k < 5 && !((int)strlen(names[k]) == n && !strncmp(p, names[k], (size_t)n)); k++) {}
        if (k == 5 && !(n > 4 && !strncmp(p, "grow", 4) && (int)strspn(p + 4, "0123456789") == n - 4 && atof(p + 4) >= 100
                        && atof(p + 4) <= 1e8)) {
            fprintf(stderr, "kernels: there is no scene '%.*s' (grow takes 100 to 100000000); see --help\n", n, p);
            return 0;
        }
        p += n + (p[n] == ',');
    }
    return 1;
}
/* 0: go on, else main's result plus 1 */
static int parse(options *o, int argc, char **argv) {
    double value_of;
    int i, k;
    memset(o, 0, sizeof *o);
    o->runs = 7; o->size = 1024; o->build = 1; o->threads = 2;
    o->scenes = "cornell,bunny,arch,blobs,instances";
    for (i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h")) { print_help(); return 1; }
        if (i + 1 == argc && strcmp(argv[i], "--quick") && strcmp(argv[i], "--no-build") && strcmp(argv[i], "--grow")) {
            fprintf(stderr, "kernels: %s is unknown or needs a value; see --help\n", argv[i]);
            return 3;
        }
        if (!strcmp(argv[i], "--quick")) { o->quick = 1; o->runs = 3; o->size = 512; continue; }
        if (!strcmp(argv[i], "--no-build")) { o->build = 0; continue; }
        if (!strcmp(argv[i], "--grow")) { o->scenes = "grow100,grow1000,grow10000,grow100000,grow1000000,grow10000000"; continue; }
        if (!strcmp(argv[i], "--runs")) {
            if (!number("--runs", value, 1, MOST_RUNS, &value_of)) return 3;
            o->runs = (int)value_of;
        } else if (!strcmp(argv[i], "--leaks")) {
            if (!number("--leaks", value, 3, 1e12, &value_of)) return 3;
            o->leaks = (size_t)value_of;
        } else if (!strcmp(argv[i], "--size")) {
            if (!number("--size", value, 16, 8192, &value_of)) return 3;
            o->size = (int)value_of;
        }
        else if (!strcmp(argv[i], "--isa")) {
            static const char *const names[4] = { "scalar", "sse2", "avx2", "neon" };
            for (k = 0; k < 4 && strcmp(value, names[k]); k++) { }
            if (k == 4) { fprintf(stderr, "kernels: there is no --isa %s\n", value); return 3; }
            o->isa = value;
        }
        else if (!strcmp(argv[i], "--threads")) {
            if (!number("--threads", value, 1, 4096, &value_of)) return 3;
            o->threads = (int)value_of;
        } else if (!strcmp(argv[i], "--scenes")) { if (!are_scenes(o->scenes = value)) return 3; }
        else if (!strcmp(argv[i], "--csv")) o->csv = value;
        else if (!strcmp(argv[i], "--libraries")) {
            char list[256], *name;
            snprintf(list, sizeof list, "%s", value);
            for (name = strtok(list, ","); name; name = strtok(NULL, ",")) {
                for (k = 0; k < (int)KNOWN && strcmp(known[k]->name, name); k++) {}
                if (k == KNOWN) { fprintf(stderr, "kernels: there is no library %s here; see --help\n", name); return 3; }
                if (o->library_count == KNOWN) { fprintf(stderr, "kernels: a library is named twice\n"); return 3; }
                o->libraries[o->library_count++] = known[k];
            }
        } else { fprintf(stderr, "kernels: unknown option '%s'; see --help\n", argv[i]); return 3; }
        i++;
    }
    if (!o->library_count) {
        for (k = 0; k < KNOWN; k++) if (!strcmp(known[k]->name, "embree")) o->libraries[o->library_count++] = known[k];
        for (k = 0; k < KNOWN; k++)
            if (!strncmp(known[k]->name, "pt", 2) && strcmp(known[k]->name, "pt_best")) o->libraries[o->library_count++] = known[k];
    }
    return 0;
}
int main(int argc, char **argv) {
    options o;
    scores total[KNOWN];
    char *list, *name, *rest;
    FILE *csv = NULL;
    int i;
    i = parse(&o, argc, argv);
    if (i) return i - 1;
    memset(total, 0, sizeof total);
    for (i = 0; i < KNOWN; i++) total[i].worst = 1e9;
    if (!is_here("embree")) printf("Embree 3 (libembree-dev) is not here: our figures alone\n");
    if (o.leaks) { count_leaks(&o); return 0; }
    if (o.csv && !(csv = fopen(o.csv, "w"))) { fprintf(stderr, "kernels: cannot write %s\n", o.csv); return 1; }
    rest = list = (char *)malloc(strlen(o.scenes) + 1);
    strcpy(list, o.scenes);
    for (i = 0; (name = strtok_r(rest, ",", &rest)) != NULL; ) i += race(&o, name, total, csv);
    free(list);
    if (csv && (ferror(csv) | fclose(csv))) { fprintf(stderr, "kernels: %s could not be written whole\n", o.csv); return 1; }
    if (!i) return 1;                                    /* nothing was raced */
    for (i = 1; i < o.library_count; i++) {
        const scores *t = &total[i];
        if (i == 1 && !strcmp(o.libraries[0]->name, "embree")) continue;       /* it comes last */
        printf("%s ", o.libraries[i]->name);
        print_scores("against", o.libraries[0]->name, t);
        printf(", worst %.2f\n", t->worst);
    }
    if (o.library_count > 1 && !strcmp(o.libraries[0]->name, "embree")) {
        const scores *t = &total[1];
        printf("the lowest ratio: %.2f\n", t->worst);
        print_scores("geomean vs", "Embree", t);
        printf("\n");
    }
    return 0;
}
