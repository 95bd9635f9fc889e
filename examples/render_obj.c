/* Renders a Wavefront OBJ or a PLY with the materials that it names: frames the model by itself, lights it with a Radiance
   map or a built-in sky. Textures are PFM, HDR and PPM; PNG, JPEG and others too, where stb_image.h is found.
   cc -O2 render_obj.c -o render_obj -lm -lpthread && ./render_obj MODEL.obj --env SKY.hdr --out picture.png */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#if defined(__has_include) && !defined(NO_STB)
#if __has_include(<stb/stb_image.h>)
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#endif
#endif

static const char help[] =
    "render_obj - path traces a Wavefront OBJ or a PLY file\n"
    "\n"
    "usage: render_obj MODEL.obj|MODEL.ply [options]\n"
    "\n"
    "picture\n"
    "  --out FILE         .png or .ppm (8 bits, sRGB), .hdr (Radiance) or .pfm\n"
    "                     (exact floats)                                                 [render.png]\n"
    "  --size WxH         pixels, each side 1 to 16384, at most 67108864 in all          [512x512]\n"
    "  --spp N            samples a pixel, 1 to 1000000; four times as many halve the\n"
    "                     noise                                                          [64]\n"
    "  --exposure STOPS   brighter by 2^STOPS, -30 to 30; .png and .ppm only             [0]\n"
    "  --curve NAME       srgb; filmic: bright parts bend off instead of burning out;\n"
    "                     false: a colour for each stop, green at 0.18; .png and .ppm    [srgb]\n"
    "camera\n"
    "  --fov DEG          vertical field of view, 1 to 170; the model stays in view      [30]\n"
    "  --azimuth DEG      walk round the model, -360 to 360; 0 looks at it from +z       [30]\n"
    "  --elevation DEG    look from above, -90 to 90                                     [20]\n"
    "light\n"
    "  --env MAP          Radiance .hdr or .pfm, equirectangular                         [a sky with a soft sun]\n"
    "  --rotate-env DEG   turn the environment about the vertical, -360 to 360           [0]\n"
    "model\n"
    "  --material NAME    instead of the file's: diffuse, mirror, glass, plastic, paint\n"
    "                     (under a clear coat) or a metal: aluminium, brass, chromium,\n"
    "                     copper, gold, iron, mercury, platinum, silver, titanium        [the file's, or diffuse]\n"
    "  --color R,G,B      of that material, linear, each 0 to 1; metals have their own   [mirror 0.9, glass 1, others 0.7]\n"
    "  --roughness R      of that material, 0 to 1                                       [plastic 0.3, others 0]\n"
    "  --patches R,G,B    patches of this color on that material, as cows have them      [none]\n"
    "  --smooth DEG       smooth normals; edges sharper than this stay edges, 1 to 180   [the file's normals]\n"
    "  --ground           put the model on a large grey floor                            [no floor]\n"
    "render\n"
    "  --depth N          bounces of light, 1 to 10000                                   [16]\n"
    "  --seed N           0 to 18446744073709551615; same seed, same picture             [0]\n"
    "  --threads N        1 to 1024                                                      [one a core]\n"
    "  --quiet            print nothing but errors\n"
    "  --help             print this and exit\n"
    "\n"
    "Ctrl-C stops and writes nothing.\n"
    "exit codes: 0 the picture is written; 1 a file could not be read, rendered or written; 2 wrong usage; 130 Ctrl-C\n";

typedef struct options {
    const char *model, *env, *out, *material;
    int width, height, spp, depth, threads, ground, quiet, colored, patched;
    uint64_t seed;
    pt_curve curve;
    double exposure, fov, azimuth, elevation, rotate_env, roughness, smooth;      /* roughness -1: the material's default */
    pt_vec3 color, patches;
} options;

/* ---- one line for every error, then the end ---- */

static void die(int code, const char *format, ...) {
    va_list args;
    va_start(args, format);
    fprintf(stderr, "render_obj: ");
    vfprintf(stderr, format, args);
    fprintf(stderr, "\n");
    va_end(args);
    exit(code);
}

/* ---- numbers, strictly: the whole text must be one number within range ---- */

static int digits_only(const char *text) { return *text && strspn(text, "0123456789") == strlen(text); }

static int parse_int(const char *option, const char *text, int max) {
    long n = digits_only(text) && strlen(text) < 10 ? strtol(text, NULL, 10) : 0;
    if (n < 1 || n > max) die(2, "%s %s: give a whole number from 1 to %d", option, text, max);
    return (int)n;
}
static uint64_t parse_seed(const char *text) {
    uint64_t n = 0;
    const char *c;
    int good = digits_only(text);
    for (c = text; good && *c; c++) {
        uint64_t digit = (uint64_t)(*c - '0');
        good = n <= (UINT64_MAX - digit) / 10;
        n = n * 10 + digit;
    }
    if (!good) die(2, "--seed %s: give a whole number from 0 to 18446744073709551615", text);
    return n;
}
static int read_number(const char *text, size_t length, double lo, double hi, double *out) {
    char copy[64], *end;
    if (!length || length >= sizeof copy) return 0;
    memcpy(copy, text, length);
    copy[length] = 0;
    if (strspn(copy, "+-.0123456789eE") != length) return 0;         /* no hexadecimal, no inf, no nan */
    *out = strtod(copy, &end);
    return !*end && *out >= lo && *out <= hi;
}
static double parse_number(const char *option, const char *text, double lo, double hi) {
    double n;
    if (!read_number(text, strlen(text), lo, hi, &n)) die(2, "%s %s: give a number from %g to %g", option, text, lo, hi);
    return n;
}
static void parse_size(const char *text, options *o) {
    const char *x = strchr(text, 'x');
    double w = 0, h = 0;
    if (!x || strspn(text, "0123456789x") != strlen(text) || !read_number(text, (size_t)(x - text), 1, 16384, &w)
        || !read_number(x + 1, strlen(x + 1), 1, 16384, &h) || w * h > 67108864)
        die(2, "--size %s: give WIDTHxHEIGHT, like 512x512, each from 1 to 16384 and at most 67108864 pixels in all", text);
    o->width = (int)w;
    o->height = (int)h;
}
static pt_vec3 parse_color(const char *option, const char *text) {
    const char *comma = strchr(text, ','), *second = comma ? strchr(comma + 1, ',') : NULL;
    double r = 0, g = 0, b = 0;
    if (!second || !read_number(text, (size_t)(comma - text), 0, 1, &r)
        || !read_number(comma + 1, (size_t)(second - comma - 1), 0, 1, &g) || !read_number(second + 1, strlen(second + 1), 0, 1, &b))
        die(2, "%s %s: give R,G,B, like 0.8,0.5,0.2, each from 0 to 1", option, text);
    return pt_v3((float)r, (float)g, (float)b);
}

static pt_curve parse_curve(const char *text) {
    if (!strcmp(text, "filmic")) return PT_CURVE_FILMIC;
    if (!strcmp(text, "false"))  return PT_CURVE_FALSE_COLOR;
    if (strcmp(text, "srgb")) die(2, "--curve %s: give srgb, filmic or false", text);
    return PT_CURVE_SRGB;
}

/* ---- the command line ---- */

static int has_ending(const char *path, const char *ending) {
    size_t n = strlen(path), m = strlen(ending);
    return n > m && !strcmp(path + n - m, ending);
}
static void set_option(options *o, const char *name, const char *value) {
    if      (!strcmp(name, "--out"))        o->out = value;
    else if (!strcmp(name, "--env"))        o->env = value;
    else if (!strcmp(name, "--material"))   o->material = value;
    else if (!strcmp(name, "--size"))       parse_size(value, o);
    else if (!strcmp(name, "--color"))      { o->color = parse_color(name, value); o->colored = 1; }
    else if (!strcmp(name, "--patches"))    { o->patches = parse_color(name, value); o->patched = 1; }
    else if (!strcmp(name, "--roughness"))  o->roughness = parse_number(name, value, 0, 1);
    else if (!strcmp(name, "--smooth"))     o->smooth = parse_number(name, value, 1, 180);
    else if (!strcmp(name, "--seed"))       o->seed = parse_seed(value);
    else if (!strcmp(name, "--spp"))        o->spp = parse_int(name, value, 1000000);
    else if (!strcmp(name, "--depth"))      o->depth = parse_int(name, value, 10000);
    else if (!strcmp(name, "--threads"))    o->threads = parse_int(name, value, 1024);
    else if (!strcmp(name, "--exposure"))   o->exposure = parse_number(name, value, -30, 30);
    else if (!strcmp(name, "--curve"))      o->curve = parse_curve(value);
    else if (!strcmp(name, "--fov"))        o->fov = parse_number(name, value, 1, 170);
    else if (!strcmp(name, "--azimuth"))    o->azimuth = parse_number(name, value, -360, 360);
    else if (!strcmp(name, "--elevation"))  o->elevation = parse_number(name, value, -90, 90);
    else if (!strcmp(name, "--rotate-env")) o->rotate_env = parse_number(name, value, -360, 360);
}
/* The material that --material, --color and --roughness ask for. */
static pt_material_desc describe_material(const options *o, const char *name) {
    pt_material_desc m = { .bsdf = PT_BSDF_DIFFUSE, .color = { .7f, .7f, .7f } };
    int metal = pt_metal(name, &m.eta, &m.k);
    if (metal)                          { m.bsdf = PT_BSDF_CONDUCTOR;  m.color = pt_v3(1, 1, 1); }
    else if (!strcmp(name, "mirror"))   { m.bsdf = PT_BSDF_CONDUCTOR;  m.color = pt_v3(.9f, .9f, .9f); }
    else if (!strcmp(name, "glass"))    { m.bsdf = PT_BSDF_DIELECTRIC; m.color = pt_v3(1, 1, 1); }
    else if (!strcmp(name, "plastic"))  { m.bsdf = PT_BSDF_PRINCIPLED; m.roughness = .3f; }
    else if (!strcmp(name, "paint"))    { m.bsdf = PT_BSDF_PRINCIPLED; m.roughness = .5f; m.metallic = .3f; m.coat = 1; }
    else if (strcmp(name, "diffuse"))
        die(2, "--material %s: give diffuse, mirror, glass, plastic, paint, or a metal that --help lists", name);
    if (o->colored && metal) die(2, "--color: %s has its own", name);
    if (o->colored) m.color = o->color;
    if (o->roughness >= 0) m.roughness = (float)o->roughness;
    return m;
}
static options parse_options(int argc, char **argv) {
    static const char *const with_value[] = { "--out", "--env", "--material", "--size", "--color", "--seed", "--spp", "--depth",
        "--threads", "--exposure", "--curve", "--fov", "--azimuth", "--elevation", "--rotate-env", "--roughness",
        "--patches", "--smooth" };
    options o = { .out = "render.png", .roughness = -1, .width = 512, .height = 512, .spp = 64, .depth = 16,
        .fov = 30, .azimuth = 30, .elevation = 20 };
    size_t k, count = sizeof with_value / sizeof *with_value;
    int i;
    for (i = 1; i < argc; i++) if (!strcmp(argv[i], "--help")) { fputs(help, stdout); exit(0); }
    for (i = 1; i < argc; i++) {
        if (argv[i][0] != '-') {
            if (o.model) die(2, "two models, %s and %s: give one", o.model, argv[i]);
            o.model = argv[i];
            continue;
        }
        if (!strcmp(argv[i], "--ground")) { o.ground = 1; continue; }
        if (!strcmp(argv[i], "--quiet"))  { o.quiet = 1; continue; }
        for (k = 0; k < count && strcmp(argv[i], with_value[k]); k++) {}
        if (k == count) die(2, "unknown option %s: see render_obj --help", argv[i]);
        if (i + 1 >= argc || !strncmp(argv[i + 1], "--", 2)) die(2, "%s needs a value: see render_obj --help", argv[i]);
        set_option(&o, argv[i], argv[i + 1]);
        i++;
    }
    if (!o.model || !*o.model) die(2, "no model: give an OBJ or PLY file, or see render_obj --help");
    if (!o.material && (o.colored || o.patched || o.roughness >= 0)) o.material = "diffuse";
    if (o.material) describe_material(&o, o.material);
    if (!has_ending(o.out, ".png") && !has_ending(o.out, ".ppm") && !has_ending(o.out, ".hdr") && !has_ending(o.out, ".pfm"))
        die(2, "--out %s: give a name that ends in .png, .ppm, .hdr or .pfm", o.out);
    if (!strcmp(o.out, o.model) || (o.env && !strcmp(o.out, o.env))) die(2, "--out %s: this is an input; give another name", o.out);
    return o;
}

/* Better to fail now than after minutes of rendering. What was there before stays as it was. */
static void check_writable(const char *path) {
    FILE *f = fopen(path, "r+b");
    int existed = f != NULL;
    if (!f && errno == ENOENT) f = fopen(path, "ab");
    if (!f) die(1, "cannot write %s: %s; give another --out", path, strerror(errno));
    fclose(f);
    if (!existed) remove(path);
}

/* ---- the scene ---- */

static pt_vec3 default_sky(void *user, pt_vec3 d) {                    /* blue above, pale at the horizon, a soft sun */
    float up = d.y > 0 ? d.y : 0, haze = (1 - up) * (1 - up) * (1 - up);
    float to_sun = d.x * -.52f + d.y * .60f + d.z * .608f;             /* up, to the left and behind the camera */
    pt_vec3 L = pt_v3(.28f + .55f * haze, .45f + .43f * haze, .85f + .10f * haze);
    (void)user;
    if (d.y < 0) return pt_v3(.30f, .28f, .26f);
    if (to_sun > .9945f) L = pt_v3(80, 72, 60);                        /* 6 degrees from the middle */
    return L;
}
static void add_environment(pt_scene *s, const options *o) {
    pt_light_desc light = { .kind = PT_LIGHT_ENVIRONMENT, .rotate_deg = (float)o->rotate_env };
    pt_image map = { 0 };
    if (!o->env) light.radiance = default_sky;
    else {
        pt_result result = pt_read_image(&map, o->env);
        if (result != PT_OK) die(1, "%s", map.error[0] ? map.error : pt_result_string(result));
        light.texture = pt_add_texture(s, &(pt_texture_desc){ .width = map.width, .height = map.height, .channels = map.channels,
            .bits = 32, .pixels = map.pixels });
    }
    pt_add_light(s, &light);
    pt_image_free(&map);
    if (*pt_scene_error(s)) die(1, "%s: %s", o->env ? o->env : "the default sky", pt_scene_error(s));
}
/* Patches: where noise is above its mean, by a mix of two materials that hardly anywhere is in between. */
static pt_material add_material(pt_scene *s, const options *o, double radius) {
    pt_material_desc m = describe_material(o, o->material ? o->material : "diffuse"), both = { .bsdf = PT_BSDF_MIX };
    pt_material plain = pt_add_material(s, &m);
    if (!o->patched) return plain;
    m.color = o->patches;
    both.a = plain;
    both.b = pt_add_material(s, &m);
    both.mix_texture = pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_FBM, .solid = 1, .octaves = 3,
        .frequency = (float)(2 / radius), .color_a = { -20, -20, -20 }, .color_b = { 21, 21, 21 } });
    return pt_add_material(s, &both);
}

/* ---- the materials of the file, and their pictures ---- */

static float to_srgb(float v) { return v <= .0031308f ? 12.92f * v : 1.055f * powf(v, 1 / 2.4f) - .055f; }

/* What pt.h reads itself. It takes a PPM for colors; where it is none, its numbers are meant as they were. */
static pt_texture add_floats(pt_scene *s, const pt_mtl_map *map, pt_texture_desc *t) {
    pt_image image = { 0 };
    pt_texture handle;
    size_t i, count;
    int undo = !map->srgb && !has_ending(map->file, ".hdr") && !has_ending(map->file, ".pfm");
    if (pt_read_image(&image, map->file) != PT_OK)
        die(1, "%s; with --material, the file's are not needed", image.error[0] ? image.error : map->file);
    count = (size_t)image.width * (size_t)image.height * (size_t)image.channels;
    for (i = 0; i < count; i++) image.pixels[i] = map->base + map->gain * (undo ? to_srgb(image.pixels[i]) : image.pixels[i]);
    t->pixels = image.pixels;
    t->width = image.width;
    t->height = image.height;
    t->channels = image.channels;
    t->bits = 32;
    handle = pt_add_texture(s, t);
    pt_image_free(&image);
    return handle;
}
static pt_texture load_map(pt_scene *s, const pt_mtl_map *map) {
    pt_wrap wrap = map->clamp ? PT_WRAP_CLAMP : PT_WRAP_REPEAT;
    pt_texture_desc t = { .channel = map->channel, .wrap_u = wrap, .wrap_v = wrap,
        .uv_scale = { map->uv_scale[0], map->uv_scale[1] }, .uv_offset = { map->uv_offset[0], map->uv_offset[1] } };
#ifdef STB_IMAGE_IMPLEMENTATION
    if (map->base == 0 && map->gain == 1 && !has_ending(map->file, ".hdr") && !has_ending(map->file, ".pfm")) {
        stbi_uc *pixels = stbi_load(map->file, &t.width, &t.height, &t.channels, 0);
        pt_texture handle;
        if (!pixels) die(1, "%s: %s; with --material, the file's are not needed", map->file, stbi_failure_reason());
        t.pixels = pixels;
        t.srgb = map->srgb;
        handle = pt_add_texture(s, &t);
        stbi_image_free(pixels);
        return handle;
    }
#endif
    return add_floats(s, map, &t);
}
static pt_material *add_materials(pt_scene *s, pt_mesh *mesh) {
    pt_material *list = (pt_material *)calloc(mesh->material_count, sizeof *list);
    size_t i;
    int k;
    if (!list) die(1, "out of memory");
    for (i = 0; i < mesh->material_count; i++) {
        pt_mtl *m = mesh->materials + i;
        for (k = 0; k < PT_MTL_MAPS; k++) if (m->maps[k].file) *pt_mtl_texture(m, k) = load_map(s, m->maps + k);
        list[i] = pt_add_material(s, &m->desc);
    }
    return list;
}
static double bounding_radius(const pt_mesh *m, const double center[3]) {
    double most = 0;
    size_t i;
    for (i = 0; i < m->index_count; i++) {
        const float *p = m->positions + 3 * (size_t)m->indices[i];
        double x = p[0] - center[0], y = p[1] - center[1], z = p[2] - center[2], d = x * x + y * y + z * z;
        if (d > most) most = d;
    }
    return sqrt(most);
}
/* Looks at the bounding sphere from a distance where it just fits into the narrower of the two angles of view. */
static pt_camera frame(const options *o, const double center[3], double radius) {
    const double degree = 3.14159265358979 / 180;
    double half_v = o->fov * degree / 2, half_h = atan(tan(half_v) * o->width / o->height);
    double distance = 1.05 * radius / sin(half_v < half_h ? half_v : half_h);
    double a = o->azimuth * degree, e = o->elevation * degree;
    pt_camera c = { .vfov_deg = (float)o->fov };
    c.target = pt_v3((float)center[0], (float)center[1], (float)center[2]);
    c.eye = pt_v3((float)(center[0] + distance * cos(e) * sin(a)), (float)(center[1] + distance * sin(e)),
                  (float)(center[2] + distance * cos(e) * cos(a)));
    c.up = pt_v3((float)(-sin(e) * sin(a)), (float)cos(e), (float)(-sin(e) * cos(a)));       /* also from straight above */
    return c;
}
static pt_camera add_model(pt_scene *s, const options *o) {
    pt_mesh mesh = { 0 };
    pt_result result = pt_read_mesh(&mesh, o->model);
    pt_material *materials = NULL;
    double center[3], radius;
    if (result != PT_OK) die(1, "%s", mesh.error[0] ? mesh.error : pt_result_string(result));
    if (!mesh.index_count) die(1, "%s: no faces in this file", o->model);
    if (mesh.warning[0] && !o->quiet) fprintf(stderr, "render_obj: warning: %s\n", mesh.warning);
    if (o->smooth > 0 && pt_mesh_smooth(&mesh, (float)o->smooth) != PT_OK) die(1, "%s: %s", o->model, mesh.error);
    center[0] = ((double)mesh.lo.x + mesh.hi.x) / 2;
    center[1] = ((double)mesh.lo.y + mesh.hi.y) / 2;
    center[2] = ((double)mesh.lo.z + mesh.hi.z) / 2;
    radius = bounding_radius(&mesh, center);
    if (!(radius > 0)) die(1, "%s: all vertices are at one point", o->model);
    if (!o->material && mesh.materials) materials = add_materials(s, &mesh);
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = mesh.positions, .vertex_count = mesh.vertex_count, .indices = mesh.indices,
        .index_count = mesh.index_count, .normals = mesh.normals, .uvs = mesh.uvs, .materials = materials,
        .material_count = materials ? mesh.material_count : 0, .material_ids = materials ? mesh.material_ids : NULL,
        .material = materials ? (pt_material){ 0 } : add_material(s, o, radius) });
    free(materials);
    if (o->ground) {
        float size = (float)(500 * radius);
        pt_material grey = pt_add_material(s, &(pt_material_desc){ .color = { .4f, .4f, .4f } });
        pt_add_quad(s, pt_v3((float)center[0] - size / 2, mesh.lo.y, (float)center[2] - size / 2), pt_v3(0, 0, size),
                    pt_v3(size, 0, 0), grey);
    }
    pt_mesh_free(&mesh);
    return frame(o, center, radius);
}

/* ---- progress, and Ctrl-C ---- */

enum { PASS = 16 };                                                     /* samples a pixel */
static volatile sig_atomic_t interrupted;
static void on_interrupt(int sig) { interrupted = 1; signal(sig, SIG_DFL); }      /* a second one ends the program at once */

typedef struct meter {
    int quiet, terminal, shown;                                         /* shown: the last percentage */
    double before, share;                                               /* of the whole: passes that are done, and this one */
    time_t start;
} meter;

static int show_progress(void *user, double done) {
    static const char full[] = "########################################";
    meter *m = (meter *)user;
    int percent, seconds = (int)(time(NULL) - m->start);
    done = m->before + m->share * done;
    percent = (int)(100 * done);
    if (m->quiet) return interrupted;
    if (m->terminal && percent > m->shown) {
        int left = done > 0 ? (int)(seconds * (1 - done) / done + .5) : 0;
        fprintf(stderr, "\r[%-40.*s] %3d %%  %d:%02d left ", percent * 40 / 100, full, percent, left / 60, left % 60);
        m->shown = percent;
    } else if (!m->terminal && percent >= m->shown + 10) {
        fprintf(stderr, "%d %%\n", percent / 10 * 10);
        m->shown = percent / 10 * 10;
    }
    return interrupted;
}
/* In passes of a few samples, so that Ctrl-C is heard soon and the time left is known early. The picture is the same as in
   one pass, bit for bit. */
static pt_result render(pt_render *r, const options *o, meter *m) {
    pt_result result = PT_OK;
    int done = 0;
    m->start = time(NULL);
    while (result == PT_OK && done < o->spp) {
        int pass = o->spp - done < PASS ? o->spp - done : PASS;
        m->before = (double)done / o->spp;
        m->share = (double)pass / o->spp;
        if (done) result = pt_render_add_samples(r, pass);
        if (result == PT_OK) result = pt_render_run(r);
        done += pass;
    }
    if (m->terminal && !m->quiet) fprintf(stderr, "\r%*s\r", 70, "");
    return result;
}
static pt_result write_picture(const options *o, const float *rgb) {
    pt_encoding e = { .exposure_stops = (float)o->exposure, .curve = o->curve };
    if (has_ending(o->out, ".pfm")) return pt_write_pfm(o->out, rgb, o->width, o->height);
    if (has_ending(o->out, ".hdr")) return pt_write_hdr(o->out, rgb, o->width, o->height);
    if (has_ending(o->out, ".png")) return pt_write_png(o->out, rgb, o->width, o->height, &e);
    return pt_write_ppm(o->out, rgb, o->width, o->height, &e);
}

int main(int argc, char **argv) {
    options o = parse_options(argc, argv);
    meter m = { .quiet = o.quiet, .terminal = isatty(2) };
    pt_scene *s = pt_scene_create(NULL);
    pt_render *r;
    pt_result result;
    pt_camera camera;
    pt_stats stats;

    check_writable(o.out);
    if (!s) die(1, "out of memory");
    camera = add_model(s, &o);
    if (*pt_scene_error(s)) die(1, "%s: %s", o.model, pt_scene_error(s));
    add_environment(s, &o);
    if (pt_scene_commit(s) != PT_OK) die(1, "%s: %s", o.model, pt_scene_error(s));
    r = pt_render_create(s, &(pt_render_desc){ .width = o.width, .height = o.height, .spp = o.spp < PASS ? o.spp : PASS,
        .max_depth = o.depth, .seed = o.seed, .threads = o.threads, .camera = camera, .progress = show_progress, .user = &m });
    if (!r) die(1, "out of memory for %d x %d pixels: give a smaller --size", o.width, o.height);
    signal(SIGINT, on_interrupt);
    result = render(r, &o, &m);
    if (result == PT_CANCELLED) die(130, "stopped; nothing was written");
    if (result != PT_OK) die(1, "%s", pt_render_error(r));
    if (write_picture(&o, pt_render_pixels(r)) != PT_OK) die(1, "cannot write %s: %s; give another --out", o.out, strerror(errno));
    stats = pt_render_stats(r);
    if (stats.discarded) fprintf(stderr, "render_obj: %llu of %llu samples could not be used, and count as black\n",
                                 (unsigned long long)stats.discarded, (unsigned long long)stats.paths);
    if (!o.quiet) printf("%s: %d x %d, %d samples a pixel, %.1f s, %.1f million rays a second\n", o.out, o.width, o.height, o.spp,
                         stats.seconds, stats.seconds > 0 ? (double)stats.rays / stats.seconds * 1e-6 : 0.0);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return 0;
}
