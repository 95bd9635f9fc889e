/* panels.h - what the figures share: settings from the command line, and pictures beside each other in one PNG. Include it
   after pt.h and efficiency.h. */
#ifndef PANELS_H
#define PANELS_H

typedef struct settings { int quick; const char *out; } settings;   /* quick: seconds, for a look; out: the folder */

static settings settings_of(int argc, char **argv, const char *what) {
    settings s = { 0, "out" };
    int i;
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick")) s.quick = 1;
        else if (!strcmp(argv[i], "--out") && i + 1 < argc) s.out = argv[++i];
        else { printf("usage: %s [--quick] [--out DIR]\n%s\n", argv[0], what); exit(strcmp(argv[i], "--help") != 0); }
    }
    return s;
}
/* count pictures of the same size, from the top left, in rows. */
static void write_panels(const settings *s, const char *name, float *const *panels, int count, int columns, int width, int height,
                         float stops) {
    int rows = (count + columns - 1) / columns, i, y, w = columns * width + (columns - 1) * 2, h = rows * height + (rows - 1) * 2;
    float *all = (float *)calloc((size_t)w * (size_t)h * 3, sizeof *all);
    pt_encoding e = { 0, PT_CURVE_FILMIC, 0 };
    char path[512];
    e.exposure_stops = stops;
    for (i = 0; i < count; i++)
        for (y = 0; y < height; y++) {
            size_t row = (size_t)(i / columns * (height + 2) + y), at = row * (size_t)w + (size_t)(i % columns * (width + 2));
            memcpy(all + 3 * at, panels[i] + (size_t)y * (size_t)width * 3, (size_t)width * 3 * sizeof *all);
        }
    snprintf(path, sizeof path, "%s/%s.png", s->out, name);
    if (pt_write_png(path, all, w, h, &e) == PT_OK) printf("%s\n\n", path);
    else printf("%s cannot be written\n", path);
    free(all);
}
#endif
