/* efficiency.h - how good is an estimator? Its efficiency is 1 / (relMSE x seconds), where
       relMSE = mean over pixels and channels of (x - r)^2 / (r^2 + 0.01),
   r a reference of many more samples, and seconds of the processor (of all threads together: it matters less what else the
   machine does). Include it after pt.h. References stay in out/reference/, by name: remove that folder when a scene changes. */
#ifndef EFFICIENCY_H
#define EFFICIENCY_H
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

static double processor_seconds(void) {
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) + 1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}
static double relative_error(const float *x, const float *r, size_t n) {
    double sum = 0;
    size_t i;
    for (i = 0; i < n; i++) {
        double d = (double)x[i] - (double)r[i];
        sum += d * d / ((double)r[i] * (double)r[i] + 0.01);
    }
    return sum / (double)n;
}
/* Renders; the pixels are the caller's to free. NULL and a message if that does not work. */
static float *render_copy(const pt_scene *s, const pt_render_desc *d, pt_stats *stats, double *seconds) {
    double start = processor_seconds();
    pt_render *r = pt_render_create(s, d);
    size_t n = (size_t)d->width * (size_t)d->height * 3 * sizeof(float);
    float *copy = NULL;
    if (pt_render_run(r) == PT_OK) {
        copy = (float *)malloc(n);
        memcpy(copy, pt_render_pixels(r), n);
        if (stats) *stats = pt_render_stats(r);
        if (seconds) *seconds = processor_seconds() - start;
    } else printf("%s\n", pt_render_error(r));
    pt_render_destroy(r);
    return copy;
}
/* Of that many samples, which other renders of the scene do not share. */
static inline float *reference(const char *name, const pt_scene *s, const pt_render_desc *d, int spp) {
    pt_render_desc many = *d;
    char path[512];
    pt_image image;
    float *rgb = NULL;
    size_t n = (size_t)d->width * (size_t)d->height * 3 * sizeof(float);
    memset(&image, 0, sizeof image);
    mkdir("out", 0777);
    mkdir("out/reference", 0777);
    snprintf(path, sizeof path, "out/reference/%s_%dx%d_%d.pfm", name, d->width, d->height, spp);
    if (pt_read_image(&image, path) == PT_OK && image.width == d->width && image.height == d->height && image.channels == 3) {
        rgb = (float *)malloc(n);
        memcpy(rgb, image.pixels, n);
    }
    pt_image_free(&image);
    if (rgb) return rgb;
    many.spp = spp;
    many.seed = 0x5eed;
    rgb = render_copy(s, &many, NULL, NULL);
    if (rgb) pt_write_pfm(path, rgb, d->width, d->height);
    return rgb;
}
typedef struct efficiency { double error, seconds, rays; } efficiency;     /* relMSE; of a render */
/* The mean over renders with other seeds, so that one lucky picture decides nothing. */
static inline efficiency efficiency_of(const pt_scene *s, const pt_render_desc *d, const float *r, int renders) {
    efficiency e = { 0, 0, 0 };
    pt_render_desc other = *d;
    int i;
    for (i = 0; i < renders; i++) {
        pt_stats stats;
        double seconds;
        float *x;
        other.seed = d->seed + 1 + (unsigned)i;
        x = render_copy(s, &other, &stats, &seconds);
        if (!x) exit(1);
        e.error += relative_error(x, r, (size_t)d->width * (size_t)d->height * 3) / renders;
        e.seconds += seconds / renders;
        e.rays += (double)stats.rays / renders;
        free(x);
    }
    return e;
}
#endif
