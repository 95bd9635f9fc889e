/* Path guiding, on and off. A room that is lit through the gap of a door only, at several numbers of samples, an eighth of them
   to learn from; a glass ball's caustic under a lamp; then the scenes that need no guide, where it should do little harm.
   Learning is in the seconds. Efficiency = 1 / (relMSE x processor seconds). OUT/figure_guide.png: the door without and with a
   guide, the caustic without and with.
   cc -O2 tests/bench/figure_guide.c -o out/figure_guide -lm -lpthread && out/figure_guide [--quick] [--out DIR] */
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include "efficiency.h"
#include "panels.h"
#include "sampling_scenes.h"

/* After Veach's picture of 1997: the lamp shines up at the ceiling of the room behind the door. */
static void scene_door_ajar(pt_scene *s, pt_render_desc *d) {
    pt_material wall = scene_matte(s, .72f, .7f, .65f), floor = scene_matte(s, .6f, .45f, .3f);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,0,2), pt_v3(4,0,0), floor);
    pt_add_quad(s, pt_v3(0,1.2f,0), pt_v3(4,0,0), pt_v3(0,0,2), wall);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(4,0,0), pt_v3(0,1.2f,0), wall);
    pt_add_quad(s, pt_v3(0,0,2), pt_v3(0,1.2f,0), pt_v3(4,0,0), wall);
    pt_add_quad(s, pt_v3(0,0,0), pt_v3(0,1.2f,0), pt_v3(0,0,2), wall);
    pt_add_quad(s, pt_v3(4,0,0), pt_v3(0,0,2), pt_v3(0,1.2f,0), wall);
    pt_add_box(s, pt_v3(1.98f,0,0), pt_v3(2.02f,1.2f,1), NULL, wall);                    /* round the door */
    pt_add_box(s, pt_v3(1.98f,0,1.5f), pt_v3(2.02f,1.2f,2), NULL, wall);
    pt_add_box(s, pt_v3(1.98f,.95f,1), pt_v3(2.02f,1.2f,1.5f), NULL, wall);
    pt_add_quad(s, pt_v3(1.98f,0,1.5f), pt_v3(-.06f,0,-.46f), pt_v3(0,.95f,0), scene_matte(s, .5f, .3f, .15f));
    pt_add_quad(s, pt_v3(3.2f,.7f,.3f), pt_v3(0,0,.2f), pt_v3(.2f,0,0), scene_lamp(s, 30000));
    pt_add_sphere(s, pt_v3(1.1f,.2f,1.5f), .2f, scene_metal(s, .9f, .85f, .7f, .2f));
    pt_add_sphere(s, pt_v3(1.5f,.17f,.9f), .17f, scene_plastic(s, .2f, .3f, .6f, .2f));
    pt_add_sphere(s, pt_v3(.8f,.15f,.9f), .15f, scene_glass(s, 0));
    pt_add_box(s, pt_v3(.9f,0,.3f), pt_v3(1.3f,.4f,.6f), NULL, wall);
    scene_look(d, .1f, .7f, 1.2f, 2, .35f, 1, 55);
    d->max_depth = 32;
}
static void scene_caustic(pt_scene *s, pt_render_desc *d) {
    scene_ground(s, 3, scene_matte(s, .6f, .6f, .6f));
    pt_add_sphere(s, pt_v3(0, .45f, 0), .4f, scene_glass(s, 0));
    pt_add_sphere(s, pt_v3(-1.5f, 2.2f, -.8f), .12f, scene_lamp(s, 60));
    scene_look(d, .3f, 1.6f, 2.6f, .2f, .2f, 0, 36);
}
static const sampling_scene door = { "door_ajar", scene_door_ajar, 32768 }, caustic = { "ball_caustic", scene_caustic, 8192 };

/* One scene, without and with; the pictures are returned where they are wanted. How many times as efficient it is. */
static double compare(const sampling_scene *c, int size, int spp, int many, int renders, float *panels[2]) {
    pt_render_desc d;
    pt_scene *s = scene_of(c, &d, size, spp);
    efficiency e[2];
    double better;
    float *r;
    int i;
    d.guide = many < 512 ? many : 512;
    r = reference(c->name, s, &d, many);
    for (i = 0; i < 2; i++) {
        d.guide = i ? (spp + 7) / 8 : 0;
        e[i] = efficiency_of(s, &d, r, renders);
        if (panels) panels[i] = render_copy(s, &d, NULL, NULL);
    }
    better = e[0].error * e[0].seconds / (e[1].error * e[1].seconds);
    printf("%-14s %5d  %10.3e %8.3f %6.2f  %10.3e %8.3f %6.2f  %8.2f x\n", c->name, spp, e[0].error, e[0].seconds,
           e[0].rays / size / size / spp, e[1].error, e[1].seconds, e[1].rays / size / size / spp, better);
    fflush(stdout);
    free(r);
    pt_scene_destroy(s);
    return better;
}
int main(int argc, char **argv) {
    settings set = settings_of(argc, argv, "path guiding: a door ajar, a caustic, scenes that need none");
    int size = set.quick ? 32 : 64, renders = set.quick ? 1 : 3, many = set.quick ? 1024 : door.reference, k;
    float *panels[4];
    double sum = 0, least = 1e30;
    printf("%d x %d pixels, mean of %d renders: relMSE, seconds, rays a path\n%-20s  without%21s with\n", size, size, renders, "", "");
    compare(&door, size, 64, many, renders, NULL);
    if (!set.quick) compare(&door, size, 256, many, renders, NULL);
    compare(&door, size, set.quick ? 512 : 1024, many, renders, panels);
    compare(&caustic, size, set.quick ? 512 : 1024, set.quick ? 1024 : caustic.reference, renders, panels + 2);
    write_panels(&set, "figure_guide", panels, 4, 2, size, size, 0);
    for (k = 0; k < 4; k++) free(panels[k]);
    for (k = 0; k < SAMPLING_SCENES; k++) {
        double b = compare(sampling_scenes + k, size, set.quick ? 16 : 64, set.quick ? 512 : sampling_scenes[k].reference, renders, NULL);
        sum += log(b);
        if (b < least) least = b;
    }
    printf("scenes that need none: geometric mean %.2f x, least %.2f x\n", exp(sum / SAMPLING_SCENES), least);
    return 0;
}
