/* Path guiding on and off: a room that gets its light through a door ajar (after Veach 1997, 8.3), the caustic of a glass ball, and
   scenes that need no guide. relMSE, processor time (learning included), and efficiency, 1 / (relMSE x seconds), against
   that without a guide. Pictures go to out/guide_*.png.
   cc -O2 tests/bench/figure_guide.c -o out/figure_guide -lm -lpthread && out/figure_guide [--quick] [SCENE...] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "sampling_scenes.h"

static int width = 96, height = 64, spp = 64, training = 16, renders = 3, more = 128;

/* Two rooms. The lamp hangs in the far one, out of sight of the door's gap. */
static void scene_door_ajar(pt_scene *s, pt_render_desc *d) {
    pt_material white = scene_matte(s, .7f, .7f, .7f), wood = scene_matte(s, .4f, .25f, .12f), floor = scene_plastic(s, .3f, .25f, .2f, .4f);
    float c = .940f, n = .342f;                          /* the door is open by 20 degrees, away from us */
    pt_xform hinge = { { c, 0, n, .4f,  0, 1, 0, 0,  -n, 0, c, -2.1f } };
    pt_add_quad(s, pt_v3(-2,0,2), pt_v3(4,0,0), pt_v3(0,0,-8), floor);
    pt_add_quad(s, pt_v3(-2,2.5f,2), pt_v3(0,0,-8), pt_v3(4,0,0), white);
    pt_add_quad(s, pt_v3(-2,0,2), pt_v3(0,0,-8), pt_v3(0,2.5f,0), scene_matte(s, .6f, .3f, .2f));
    pt_add_quad(s, pt_v3(2,0,2), pt_v3(0,2.5f,0), pt_v3(0,0,-8), scene_matte(s, .25f, .4f, .6f));
    pt_add_quad(s, pt_v3(-2,0,2), pt_v3(0,2.5f,0), pt_v3(4,0,0), white);
    pt_add_quad(s, pt_v3(-2,0,-6), pt_v3(4,0,0), pt_v3(0,2.5f,0), white);
    pt_add_box(s, pt_v3(-2,0,-2.1f), pt_v3(.4f,2.5f,-2), NULL, white);                  /* the wall between them */
    pt_add_box(s, pt_v3(1.3f,0,-2.1f), pt_v3(2,2.5f,-2), NULL, white);
    pt_add_box(s, pt_v3(.4f,2,-2.1f), pt_v3(1.3f,2.5f,-2), NULL, white);
    pt_add_box(s, pt_v3(0,.005f,0), pt_v3(.9f,1.995f,.04f), &hinge, wood);
    pt_add_quad(s, pt_v3(-1.2f,2.4f,-4.5f), pt_v3(.8f,0,0), pt_v3(0,0,.8f), scene_lamp(s, 15000));
    pt_add_box(s, pt_v3(-1.4f,.55f,-1.2f), pt_v3(.2f,.62f,-.2f), NULL, wood);           /* a table with things */
    pt_add_box(s, pt_v3(-1.3f,0,-1.1f), pt_v3(-1.2f,.55f,-1), NULL, wood);
    pt_add_box(s, pt_v3(0,0,-1.1f), pt_v3(.1f,.55f,-1), NULL, wood);
    pt_add_sphere(s, pt_v3(-1.1f,.82f,-.7f), .2f, scene_metal(s, .9f, .8f, .6f, .3f));
    pt_add_sphere(s, pt_v3(-.6f,.82f,-.6f), .2f, scene_matte(s, .7f, .7f, .7f));
    pt_add_sphere(s, pt_v3(-.1f,.82f,-.7f), .2f, scene_glass(s, 0));
    pt_add_sphere(s, pt_v3(1,.3f,-.3f), .3f, scene_plastic(s, .1f, .4f, .15f, .2f));
    scene_look(d, -.4f, 1.3f, 1.9f, 0, .95f, -2, 60);
}
static void scene_caustic(pt_scene *s, pt_render_desc *d) {
    scene_ground(s, 3, scene_matte(s, .6f, .6f, .6f));
    pt_add_sphere(s, pt_v3(0,.5f,0), .3f, scene_glass(s, 0));
    pt_add_sphere(s, pt_v3(-1.2f,1.8f,-.6f), .05f, scene_lamp(s, 400));
    pt_add_sphere(s, pt_v3(-.6f,.15f,.5f), .15f, scene_metal(s, .9f, .7f, .4f, .2f));
    pt_add_light(s, &(pt_light_desc){ .color = { .05f, .06f, .08f } });
    scene_look(d, .3f, 1.3f, 2.5f, .2f, .2f, 0, 40);
}
static const sampling_scene own[] = { { "door_ajar", scene_door_ajar, 1 }, { "glass_caustic", scene_caustic, 1 } };

static void show(const char *name, const char *kind, const float *rgb, int w, int h) {
    char path[256];
    snprintf(path, sizeof path, "out/guide_%s_%s.png", name, kind);
    pt_write_png(path, rgb, w, h, &(pt_encoding){ .curve = PT_CURVE_FILMIC });
}
static void measure(const sampling_scene *c) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render_desc d, many;
    efficiency off, on;
    float *r, *x;
    int mine = c->reference == 1;
    memset(&d, 0, sizeof d);
    d.width = mine ? width : 64; d.height = mine ? height : 64;
    d.spp = spp;
    d.threads = 1;
    c->build(s, &d);
    if (pt_scene_commit(s) != PT_OK) { printf("%s: %s\n", c->name, pt_scene_error(s)); exit(1); }
    many = d;                                            /* the reference: guided, after a training of its own */
    if (mine) many.guide.spp = 256;
    r = reference(c->name, s, &many, mine ? (spp + training) * more : c->reference);
    off = efficiency_of(s, &d, r, renders);
    x = render_copy(s, &d, NULL, NULL);
    show(c->name, "off", x, d.width, d.height);
    free(x);
    d.guide.spp = training;
    on = efficiency_of(s, &d, r, renders);
    x = render_copy(s, &d, NULL, NULL);
    show(c->name, "on", x, d.width, d.height);
    show(c->name, "reference", r, d.width, d.height);
    free(x);
    printf("%-14s  %.3e %6.2f s %5.1f   %.3e %6.2f s %5.1f   %6.2f\n", c->name, off.error, off.seconds, off.rays / off.seconds * 1e-6,
           on.error, on.seconds, on.rays / on.seconds * 1e-6, off.error * off.seconds / (on.error * on.seconds));
    fflush(stdout);
    free(r);
    pt_scene_destroy(s);
}
static int wanted(int argc, char **argv, const char *name) {
    int i, some = 0;
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], name)) return 1;
        if (argv[i][0] == '-') i += strcmp(argv[i], "--quick") != 0;
        else some = 1;
    }
    return !some;
}
int main(int argc, char **argv) {
    int i;
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick")) { width = 48; height = 32; spp = 32; training = 8; renders = 1; more = 16; }
        else if (!strcmp(argv[i], "--spp") && i + 1 < argc) spp = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--training") && i + 1 < argc) training = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--renders") && i + 1 < argc) renders = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--width") && i + 1 < argc) height = (width = atoi(argv[++i])) * 2 / 3;
        else if (!strcmp(argv[i], "--more") && i + 1 < argc) more = atoi(argv[++i]);
        else if (argv[i][0] == '-') { printf("usage: figure_guide [--quick] [--spp N] [--training N] [--renders N] [SCENE...]\n"); return 1; }
    }
    printf("%d samples, %d of training: relMSE, processor seconds, Mrays/s\n%-14s  without guide                 with it                      "
           "  efficiency\n", spp, training, "");
    for (i = 0; i < 2; i++) if (wanted(argc, argv, own[i].name)) measure(own + i);
    for (i = 0; i < SAMPLING_SCENES; i++) if (wanted(argc, argv, sampling_scenes[i].name)) measure(sampling_scenes + i);
    return 0;
}
