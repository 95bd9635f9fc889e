/* timing.h - the clock and the median that all benchmarks use. C and C++. */
#ifndef TIMING_H
#define TIMING_H
#include <stdlib.h>
#include <sys/time.h>

static double now(void) {
    struct timeval t;
    gettimeofday(&t, NULL);
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}
static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
/* Of n, an odd number. They come out sorted. */
static inline double median(double *t, int n) {
    qsort(t, (size_t)n, sizeof *t, ascending);
    return t[n / 2];
}
#endif
