/* kernels_scenes.c - the scenes of kernels.c: made by code, but for the bunny. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "kernels.h"
#include "kernels_scenes.h"

static void *room_for(void *p, size_t count, size_t *room, size_t size) {
    if (count <= *room) return p;
    *room = 2 * count + 1000;
    p = realloc(p, *room * size);
    if (!p) { fprintf(stderr, "out of memory\n"); exit(1); }
    return p;
}
static uint32_t vertex(kernel_part *m, double x, double y, double z) {
    float *p;
    m->positions = (float *)room_for(m->positions, m->vertices + 2, &m->vertex_room, 12);   /* Embree reads a float beyond the last */
    p = m->positions + 3 * m->vertices;
    p[0] = (float)x; p[1] = (float)y; p[2] = (float)z; p[3] = 0;
    return (uint32_t)m->vertices++;
}
static void triangle(kernel_part *m, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *i;
    m->indices = (uint32_t *)room_for(m->indices, m->triangles + 1, &m->triangle_room, 12);
    i = m->indices + 3 * m->triangles++;
    i[0] = a; i[1] = b; i[2] = c;
}
static void quad(kernel_part *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d) { triangle(m, a, b, c); triangle(m, a, c, d); }

/* A parallelepiped: centre and half axes. */
static void slanted_box(kernel_part *m, const double c[3], double axis[3][3]) {
    static const int face[6][4] = { {0,4,6,2}, {1,3,7,5}, {0,1,5,4}, {2,6,7,3}, {0,2,3,1}, {4,5,7,6} };
    uint32_t v[8];
    int i, k;
    for (i = 0; i < 8; i++) {
        double p[3];
        for (k = 0; k < 3; k++)
            p[k] = c[k] + (i & 1 ? 1 : -1) * axis[0][k] + (i & 2 ? 1 : -1) * axis[1][k] + (i & 4 ? 1 : -1) * axis[2][k];
        v[i] = vertex(m, p[0], p[1], p[2]);
    }
    for (i = 0; i < 6; i++) quad(m, v[face[i][0]], v[face[i][1]], v[face[i][2]], v[face[i][3]]);
}
static void box(kernel_part *m, double x0, double y0, double z0, double x1, double y1, double z1) {
    double c[3], axis[3][3] = { {0} };
    c[0] = (x0 + x1) / 2; c[1] = (y0 + y1) / 2; c[2] = (z0 + z1) / 2;
    axis[0][0] = (x1 - x0) / 2; axis[1][1] = (y1 - y0) / 2; axis[2][2] = (z1 - z0) / 2;
    slanted_box(m, c, axis);
}
static void lamp(kernel_scene *s, double x0, double z0, double x1, double z1, double y) {
    kernel_part *m = &s->part[0];
    quad(m, vertex(m, x0, y, z0), vertex(m, x1, y, z0), vertex(m, x1, y, z1), vertex(m, x0, y, z1));
    s->light[0][0] = (float)x0; s->light[0][1] = (float)y; s->light[0][2] = (float)z0;
    s->light[1][0] = (float)(x1 - x0); s->light[2][2] = (float)(z1 - z0);
}
static void look(kernel_scene *s, double ex, double ey, double ez, double ax, double ay, double az, double fov) {
    s->eye[0] = (float)ex; s->eye[1] = (float)ey; s->eye[2] = (float)ez;
    s->at[0] = (float)ax; s->at[1] = (float)ay; s->at[2] = (float)az;
    s->fov = (float)fov;
}
static void random_rotation(kernel_random *r, double m[3][3]) {
    double a = 6.2831853 * random_float(r), b = 6.2831853 * random_float(r), u = random_float(r);
    double x = sqrt(1 - u) * sin(a), y = sqrt(1 - u) * cos(a), z = sqrt(u) * sin(b), w = sqrt(u) * cos(b);
    m[0][0] = 1 - 2 * (y * y + z * z); m[0][1] = 2 * (x * y - z * w); m[0][2] = 2 * (x * z + y * w);
    m[1][0] = 2 * (x * y + z * w); m[1][1] = 1 - 2 * (x * x + z * z); m[1][2] = 2 * (y * z - x * w);
    m[2][0] = 2 * (x * z - y * w); m[2][1] = 2 * (y * z + x * w); m[2][2] = 1 - 2 * (x * x + y * y);
}

/* ---- a bumpy ball: a sphere in rings, its points moved by value noise ---- */

static double lattice(int x, int y, int z, uint32_t seed) {
    return random_hash((uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)z * 83492791u ^ seed) / 4294967296.0;
}
static double noise(double x, double y, double z, uint32_t seed) {
    int i = (int)floor(x), j = (int)floor(y), k = (int)floor(z), c;
    double u = x - i, v = y - j, w = z - k, sum = 0;
    u = u * u * (3 - 2 * u); v = v * v * (3 - 2 * v); w = w * w * (3 - 2 * w);
    for (c = 0; c < 8; c++)
        sum += (c & 1 ? u : 1 - u) * (c & 2 ? v : 1 - v) * (c & 4 ? w : 1 - w) * lattice(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2), seed);
    return sum - 0.5;
}
/* A cube of n x n quads a side, blown up: 12 n^2 triangles, corners shared. */
void scene_blob(kernel_part *m, const double c[3], double radius, int n, double bump, uint32_t seed) {
    uint32_t *at = (uint32_t *)calloc((size_t)(n + 1) * (size_t)(n + 1) * (size_t)(n + 1), sizeof *at);
    int f, i, j, k;
#define AT(i, j, k) at[((i) * (n + 1) + (j)) * (n + 1) + (k)]
    for (i = 0; i <= n; i++) for (j = 0; j <= n; j++) for (k = 0; k <= n; k++) {
        double p[3], length, b;
        if (i && j && k && i < n && j < n && k < n) continue;
        p[0] = tan((2.0 * i / n - 1) * 0.785398); p[1] = tan((2.0 * j / n - 1) * 0.785398); p[2] = tan((2.0 * k / n - 1) * 0.785398);
        length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        p[0] /= length; p[1] /= length; p[2] /= length;
        b = noise(p[0] * 3 + 7, p[1] * 3 + 7, p[2] * 3 + 7, seed) + 0.5 * noise(p[0] * 7 + 9, p[1] * 7 + 9, p[2] * 7 + 9, seed + 1)
          + 0.2 * noise(p[0] * 19 + 9, p[1] * 19 + 9, p[2] * 19 + 9, seed + 2);
        b = radius * (1 + bump * b);
        AT(i, j, k) = vertex(m, c[0] + b * p[0], c[1] + b * p[1], c[2] + b * p[2]);
    }
    for (f = 0; f < 6; f++) for (i = 0; i < n; i++) for (j = 0; j < n; j++) {
        uint32_t v[4];
        for (k = 0; k < 4; k++) {
            int q[3];
            q[f / 2] = f % 2 ? n : 0; q[(f / 2 + 1) % 3] = i + (k == 1 || k == 2); q[(f / 2 + 2) % 3] = j + (k >= 2);
            v[f % 2 ? k : 3 - k] = AT(q[0], q[1], q[2]);
        }
        quad(m, v[0], v[1], v[2], v[3]);
    }
#undef AT
    free(at);
}

/* ---- the scenes ---- */

static void cornell(kernel_scene *s) {                   /* 38 triangles */
    double a[3] = { 1.85, 0.825, 1.69 }, x[3][3] = { { .79, 0, .24 }, { 0, .825, 0 }, { -.24, 0, .79 } };
    double b[3] = { 3.68, 1.65, 3.51 }, y[3][3] = { { .78, 0, -.26 }, { 0, 1.65, 0 }, { .26, 0, .78 } };
    kernel_part *m = &s->part[0];
    uint32_t v[8], i;
    for (i = 0; i < 8; i++) v[i] = vertex(m, i & 1 ? 5.5 : 0, i & 2 ? 5.5 : 0, i & 4 ? 5.6 : 0);
    quad(m, v[0], v[4], v[6], v[2]); quad(m, v[1], v[3], v[7], v[5]); quad(m, v[0], v[1], v[5], v[4]);
    quad(m, v[2], v[6], v[7], v[3]); quad(m, v[4], v[5], v[7], v[6]);
    slanted_box(m, a, x);
    slanted_box(m, b, y);
    lamp(s, 2.13, 2.27, 3.43, 3.32, 5.49);
    look(s, 2.78, 2.73, -8, 2.78, 2.73, 2.8, 38);
}
static int bunny(kernel_scene *s) {                      /* 2 m wide, in a room; 70 k triangles */
    kernel_part *m = &s->part[0];
    FILE *f = fopen("../shared/data/meshes/stanford-bunny.obj", "r");
    char line[256];
    float lo[3] = { 1e30f, 1e30f, 1e30f }, hi[3] = { -1e30f, -1e30f, -1e30f }, scale = 0;
    size_t i;
    int k;
    if (!f) return 0;
    while (fgets(line, sizeof line, f)) {
        float x, y, z;
        unsigned v[3];
        if (sscanf(line, "v %f %f %f", &x, &y, &z) == 3) vertex(m, (double)x, (double)y, (double)z);
        else if (sscanf(line, "f %u%*s %u%*s %u", v, v + 1, v + 2) == 3 || sscanf(line, "f %u %u %u", v, v + 1, v + 2) == 3)
            triangle(m, v[0] - 1, v[1] - 1, v[2] - 1);
    }
    fclose(f);
    for (i = 0; i < 3 * m->vertices; i++) {
        float x = m->positions[i];
        k = (int)(i % 3);
        if (x < lo[k]) lo[k] = x;
        if (x > hi[k]) hi[k] = x;
    }
    for (k = 0; k < 3; k++) if (hi[k] - lo[k] > scale) scale = hi[k] - lo[k];
    for (i = 0; i < 3 * m->vertices; i++) {
        k = (int)(i % 3);
        m->positions[i] = (m->positions[i] - (k == 1 ? lo[k] : (lo[k] + hi[k]) / 2)) * 2 / scale;
    }
    box(m, -2, 0, -2, 2, 3, 3);
    lamp(s, -.7, -.7, .7, .7, 2.99);
    look(s, -.3, 1.3, 2.6, 0, .9, 0, 50);
    return 1;
}
/* A hall: paving, fluted columns of triangles as high as the hall, capitals, a roof of thin slanted beams, railings, stairs,
   curtains. */
static void arch(kernel_scene *s) {
    const double L = 40, W = 14, H = 12;
    kernel_part *m = &s->part[0];
    kernel_random r = random_seed(5);
    int i, j, k, side;
    box(m, -L / 2, 0, -W / 2, L / 2, H, W / 2);
    lamp(s, -8, -1.5, 8, 1.5, H - .02);
    for (i = 0; i < 40; i++) for (j = 0; j < 14; j++)
        box(m, -L / 2 + i + .02, 0, -W / 2 + j + .02, -L / 2 + i + .98, .01 + .01 * random_float(&r), -W / 2 + j + .98);
    for (side = -1; side <= 1; side += 2) for (i = 0; i < 14; i++) {
        double x = -L / 2 + 2 + i * 2.75, z = side * 4.2, c[3];
        for (j = 0; j < 64; j++) {
            double a = 6.2831853 * j / 64, b = 6.2831853 * (j + 1) / 64, p = j & 1 ? .42 : .36, q = j & 1 ? .36 : .42;
            quad(m, vertex(m, x + p * cos(a), .5, z + p * sin(a)), vertex(m, x + q * cos(b), .5, z + q * sin(b)),
                 vertex(m, x + .85 * q * cos(b), H - .8, z + .85 * q * sin(b)), vertex(m, x + .85 * p * cos(a), H - .8, z + .85 * p * sin(a)));
        }
        box(m, x - .55, 0, z - .55, x + .55, .5, z + .55);
        box(m, x - .5, H - .8, z - .5, x + .5, H, z + .5);
        c[0] = x; c[1] = H - 1.1; c[2] = z;
        scene_blob(m, c, .5, 21, .5, 900u + (uint32_t)(i + 20 * (side + 1)));
    }
    for (i = 0; i < 3000; i++) {
        double axis[3][3], c[3], length = .6 + 3.2 * random_float(&r), thick = .012 + .03 * random_float(&r);
        random_rotation(&r, axis);
        for (k = 0; k < 9; k++) axis[k / 3][k % 3] *= k < 3 ? length / 2 : thick;
        c[0] = (random_float(&r) - .5) * (L - 5); c[1] = H * (.62 + .3 * random_float(&r)); c[2] = (random_float(&r) - .5) * (W - 4);
        slanted_box(m, c, axis);
    }
    for (side = -1; side <= 1; side += 2) {
        for (i = 0; i < 500; i++) {
            double x = -L / 2 + .04 + i * (L / 500), z = side * 3.2;
            box(m, x, .02, z - .012, x + .024, 1.1, z + .012);
        }
        box(m, -L / 2, 1.1, side * 3.2 - .04, L / 2, 1.16, side * 3.2 + .04);
    }
    for (i = 0; i < 60; i++) box(m, L / 2 - 6 + i * .1, .02 * i, -3, L / 2 - 5.9 + i * .1, .02 * i + .1, 3);
    for (k = 0; k < 3; k++) {
        uint32_t first = (uint32_t)m->vertices, v;
        for (j = 0; j <= 160; j++) for (i = 0; i <= 120; i++)
            vertex(m, -14 + 10.0 * k + i / 30.0, 2 + j / 26.67, 5.6 + .22 * sin(i / 2.4) * (1 - .003 * j) + .05 * sin(j * .056 + i / 6.0));
        for (j = 0; j < 160; j++) for (i = 0; i < 120; i++) {
            v = first + (uint32_t)(j * 121 + i);
            quad(m, v, v + 1, v + 122, v + 121);
        }
    }
    look(s, -L / 2 + 3, 2.2, .4, L / 2, 4.6, -.6, 70);
}
static void hall(kernel_scene *s) {
    box(&s->part[0], -7, 0, -7, 7, 9, 11);
    lamp(s, -2, -2, 2, 2, 8.98);
    look(s, 1.5, 5, 10, 0, 3.6, 0, 55);
}
static void blobs(kernel_scene *s, int count, int n) {   /* balls of 12 n^2 triangles */
    kernel_random r = random_seed(1);
    int i;
    for (i = 0; i < count; i++) {
        double c[3];
        c[0] = -4.5 + 3 * (i % 4) + .8 * (random_float(&r) - .5);
        c[1] = 1.5 + 2.6 * (i / 16) + .6 * (random_float(&r) - .5);
        c[2] = -4.5 + 3 * (i / 4 % 4) + .8 * (random_float(&r) - .5);
        scene_blob(&s->part[0], c, .9 + .5 * random_float(&r), n, .55, 100u + 10 * (uint32_t)i);
    }
    hall(s);
}
static void instances(kernel_scene *s) {                 /* 4000 copies of one ball of 5 k triangles */
    static const double origin[3] = { 0, 0, 0 };
    kernel_random r = random_seed(7);
    kernel_part *p = &s->part[1];
    int i, k;
    hall(s);
    s->parts = 2;
    scene_blob(p, origin, 1, 20, .55, 77);
    p->copies = 4000;
    p->transforms = (float *)malloc(p->copies * 12 * sizeof(float));
    for (i = 0; i < 4000; i++) {
        double axis[3][3], size = .08 + .25 * random_float(&r) * random_float(&r);
        float *t = p->transforms + 12 * i;
        random_rotation(&r, axis);
        for (k = 0; k < 9; k++) t[k / 3 * 4 + k % 3] = (float)(axis[k / 3][k % 3] * size);
        t[3] = (float)(-5 + 10 * random_float(&r)); t[7] = (float)(.5 + 7 * random_float(&r)); t[11] = (float)(-5 + 11 * random_float(&r));
    }
}
int scene_make(kernel_scene *s, const char *name) {
    memset(s, 0, sizeof *s);
    snprintf(s->name, sizeof s->name, "%s", name);
    s->parts = 1;
    if (!strcmp(name, "cornell")) cornell(s);
    else if (!strcmp(name, "bunny")) return bunny(s);
    else if (!strcmp(name, "arch")) arch(s);
    else if (!strcmp(name, "blobs")) blobs(s, 48, 41);
    else if (!strncmp(name, "grow", 4) && atof(name + 4) >= 100) {
        int count = atof(name + 4) < 1000 ? 8 : 48;
        blobs(s, count, (int)(sqrt(atof(name + 4) / 12 / count) + .5));
    }
    else if (!strcmp(name, "instances")) instances(s);
    else return 0;
    return 1;
}
void scene_free(kernel_scene *s) {
    int k;
    for (k = 0; k < 2; k++) { free(s->part[k].positions); free(s->part[k].indices); free(s->part[k].transforms); }
}
