/* Makes a mesh and a sky to render: DIR/knot.obj, a trefoil knot with winding ridges, and DIR/sky.hdr, a clear sky with
   the sun in it, half a degree wide and a hundred thousand times as bright as the blue.
   cc -O2 make_assets.c -o make_assets -lm -lpthread && ./make_assets [DIR] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979

typedef struct vec { double x, y, z; } vec;
static vec    mul(vec a, double s)         { vec r = { a.x * s, a.y * s, a.z * s }; return r; }
static vec    mad(vec a, double s, vec b)  { vec r = { a.x * s + b.x, a.y * s + b.y, a.z * s + b.z }; return r; }
static vec    cross(vec a, vec b) { vec r = { a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x }; return r; }
static double dot(vec a, vec b)   { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec    unit(vec a)         { return mul(a, 1 / sqrt(dot(a, a))); }

/* ---- the knot: a tube round a curve that winds twice round a torus while it goes three times through it ---- */

static vec curve(double t) {
    double r = 1 + .42 * cos(3 * t);
    vec p = { r * cos(2 * t), .42 * sin(3 * t), r * sin(2 * t) };
    return p;
}
static vec knot(double t, double a) {
    vec p = curve(t), along = unit(mad(curve(t - 1e-4), -1, curve(t + 1e-4)));
    vec hub = { cos(2 * t), 0, sin(2 * t) };                       /* the torus's own circle: p - hub points outwards */
    vec out = mad(hub, -1, p), side, radial;
    double ridge = cos(6 * a + 26 * t), bead = cos(150 * t);
    double radius = .20 + .035 * ridge + .006 * bead * (.5 + .5 * ridge);
    out = unit(mad(along, -dot(along, out), out));
    side = cross(along, out);
    radial = mad(out, cos(a), mul(side, sin(a)));
    return mad(radial, radius, p);
}
static int write_knot(const char *path) {
    enum { AROUND = 96, ALONG = 1200 };                            /* 2 * 96 * 1200 = 230 400 triangles */
    FILE *f = fopen(path, "w");
    int i, j, good;
    if (!f) return 0;
    fprintf(f, "# a trefoil knot with ridges\n");
    for (i = 0; i < ALONG; i++)
        for (j = 0; j < AROUND; j++) {
            double t = 2 * PI * i / ALONG, a = 2 * PI * j / AROUND, h = 1e-4;
            vec p = knot(t, a), dt = mad(knot(t - h, a), -1, knot(t + h, a)), da = mad(knot(t, a - h), -1, knot(t, a + h));
            vec n = unit(cross(dt, da));
            fprintf(f, "v %.6f %.6f %.6f\nvn %.4f %.4f %.4f\n", p.x, p.y, p.z, n.x, n.y, n.z);
        }
    for (i = 0; i < ALONG; i++)
        for (j = 0; j < AROUND; j++) {
            int i1 = (i + 1) % ALONG, j1 = (j + 1) % AROUND;
            int a = i * AROUND + j + 1, b = i1 * AROUND + j + 1, c = i1 * AROUND + j1 + 1, d = i * AROUND + j1 + 1;
            fprintf(f, "f %d//%d %d//%d %d//%d %d//%d\n", a, a, b, b, c, c, d, d);
        }
    good = !ferror(f);
    return fclose(f) == 0 && good;
}

/* ---- the sky: blue above, pale at the horizon, a glow round the sun, and brown earth below ---- */

static const double sun_height = 32 * PI / 180, sun_azimuth = -50 * PI / 180, sun_radius = .2665 * PI / 180;

static vec sky(vec d, vec sun) {
    double haze = exp(-6 * (d.y > 0 ? d.y : 0)), c = dot(d, sun), angle = acos(c > 1 ? 1 : c);
    double glow = .8 * exp(-angle * 22) + .18 * exp(-angle * 4);
    vec blue = { .16, .28, .56 }, pale = { .62, .72, .84 }, warm = { 1, .84, .62 }, earth = { .16, .13, .10 };
    vec L = d.y < 0 ? earth : mad(pale, haze, mul(blue, 1 - haze));
    if (d.y >= 0) L = mad(warm, glow, L);
    if (angle < sun_radius) L = mad(warm, 60000, L);
    return L;
}
static pt_result write_sky(const char *path) {
    enum { W = 1024, H = 512 };
    float *rgb = (float *)malloc(sizeof *rgb * 3 * W * H), *out = rgb;
    vec sun = { cos(sun_height) * sin(sun_azimuth), sin(sun_height), -cos(sun_height) * cos(sun_azimuth) };
    pt_result result;
    int x, y, k, n = 8;                                            /* n * n points a pixel, so that the disk has its true size */
    if (!rgb) return PT_ERR_MEMORY;
    for (y = 0; y < H; y++)
        for (x = 0; x < W; x++, out += 3) {
            vec sum = { 0, 0, 0 };
            for (k = 0; k < n * n; k++) {
                double theta = PI * (y + (k / n + .5) / n) / H, phi = 2 * PI * (x + (k % n + .5) / n - W / 2) / W;
                vec d = { sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi) };      /* the middle is towards -z */
                sum = mad(sky(d, sun), 1. / (n * n), sum);
            }
            out[0] = (float)sum.x; out[1] = (float)sum.y; out[2] = (float)sum.z;
        }
    result = pt_write_hdr(path, rgb, W, H);
    free(rgb);
    return result;
}

int main(int argc, char **argv) {
    const char *dir = argc > 1 ? argv[1] : ".";
    char obj[1024], hdr[1024];
    if (strlen(dir) > 1000) { fprintf(stderr, "make_assets: the directory's name is longer than 1000 characters\n"); return 2; }
    sprintf(obj, "%s/knot.obj", dir);
    sprintf(hdr, "%s/sky.hdr", dir);
    if (!write_knot(obj)) { fprintf(stderr, "make_assets: cannot write %s: %s\n", obj, strerror(errno)); return 1; }
    if (write_sky(hdr) != PT_OK) { fprintf(stderr, "make_assets: cannot write %s\n", hdr); return 1; }
    printf("wrote %s and %s\n", obj, hdr);
    return 0;
}
