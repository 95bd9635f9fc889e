/* clean.h - renders until a picture is clean: until the relative error of a pixel, sqrt(relMSE), is below what is asked for. It
   is estimated from two halves, a and b, of other seeds each: that of their mean is near (a - b) / 2. Include it after pt.h,
   efficiency.h and timing.h. */
#ifndef CLEAN_H
#define CLEAN_H
#include <math.h>

static double error_of_halves(const float *a, const float *b, size_t n) {      /* relMSE of (a + b) / 2 */
    double sum = 0;
    size_t i;
    for (i = 0; i < n; i++) {
        double d = ((double)a[i] - (double)b[i]) / 2, m = ((double)a[i] + (double)b[i]) / 2;
        sum += d * d / (m * m + 0.01);
    }
    return sum / (double)n;
}
/* Seconds are the clock's and the processor's. The pixels are the caller's to free. At most so many samples; d.spp is ignored. */
static float *until_clean(const pt_scene *s, pt_render_desc d, double clean, int most) {
    size_t i, n = (size_t)d.width * (size_t)d.height * 3;
    float *picture = (float *)malloc(n * sizeof *picture);
    double start = now(), cpu = processor_seconds(), error = 1;
    pt_render *half[2];
    const float *a, *b;
    int k, spp, more;
    d.spp = 4;
    for (k = 0; k < 2; k++) { d.seed = (uint64_t)k; half[k] = pt_render_create(s, &d); }
    printf("%d x %d pixels: samples, seconds, of the processor, relative error of a pixel\n", d.width, d.height);
    for (spp = 8; ; spp += more) {
        for (k = 0; k < 2; k++) if (pt_render_run(half[k]) != PT_OK) { printf("%s\n", pt_render_error(half[k])); exit(1); }
        a = pt_render_pixels(half[0]); b = pt_render_pixels(half[1]);
        error = sqrt(error_of_halves(a, b, n));
        printf("%6d %8.1f %8.1f %9.4f\n", spp, now() - start, processor_seconds() - cpu, error);
        fflush(stdout);
        if (error < clean || spp >= most) break;
        more = spp < 128 ? spp : 128;
        for (k = 0; k < 2; k++) pt_render_add_samples(half[k], more / 2);
    }
    for (i = 0; i < n; i++) picture[i] = (a[i] + b[i]) / 2;
    for (k = 0; k < 2; k++) pt_render_destroy(half[k]);
    printf("%s after %.1f s, %.1f of the processor\n", error < clean ? "clean" : "not yet clean", now() - start,
           processor_seconds() - cpu);
    return picture;
}
#endif
