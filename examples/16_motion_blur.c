/* Pool balls while the shutter is open: the white one and the 8 move fast, the 9 slowly, 1 and 4 lie still. Shadows and
   highlights smear as they should, for every path has its own time. After Thomas Porter's picture "1984" (Cook, Porter and
   Carpenter, "Distributed Ray Tracing", 1984).
   cc -O2 16_motion_blur.c -o 16_motion_blur -lm -lpthread && ./16_motion_blur [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

typedef struct ball {
    int number, stripe;
    pt_vec3 paint, from, way;                              /* where it starts, and how far it gets; the radius is 1 */
    float roll;                                            /* the angle by which it turns meanwhile */
    pt_scene *scene;
} ball;

/* Paint over longitude and latitude: a white field with a number of 3 x 5 squares, at the ball's -z. */
static pt_vec3 painted(void *user, const pt_vertex *x) {
    static const unsigned short digit[10] = { 075557, 026227, 071747, 071717, 055711, 074717, 074757, 071111, 075757, 075717 };
    const ball *b = (const ball *)user;
    const pt_vec3 white = {.80f, .78f, .70f}, black = {.02f, .02f, .02f};
    float up = (x->v - .5f) * 3.14159265f, right = (.5f - x->u) * 6.2831853f * cosf(up);
    int column = (int)floorf(right / .12f + 1.5f), row = (int)floorf(2.5f - up / .12f);
    if (!b->number) return white;
    if (right * right + up * up > .22f) return b->stripe && fabsf(up) > .62f ? white : b->paint;
    if (column < 0 || column > 2 || row < 0 || row > 4) return white;
    return digit[b->number] >> (3 * (4 - row) + 2 - column) & 1 ? black : white;
}
/* Rodrigues: turns the three columns about a unit axis. */
static void turn(pt_xform *x, pt_vec3 axis, float angle) {
    float c = cosf(angle), s = sinf(angle);
    for (int i = 0; i < 3; i++) {
        float *m = x->m + i, a = m[0], b = m[4], d = m[8], along = (axis.x * a + axis.y * b + axis.z * d) * (1 - c);
        m[0] = c * a + s * (axis.y * d - axis.z * b) + along * axis.x;
        m[4] = c * b + s * (axis.z * a - axis.x * d) + along * axis.y;
        m[8] = c * d + s * (axis.x * b - axis.y * a) + along * axis.z;
    }
}
static void add_ball(pt_scene *s, ball *b) {
    b->scene = pt_scene_create(NULL);
    pt_texture paint = pt_add_texture(b->scene, &(pt_texture_desc){ .eval = painted, .user = b });
    pt_material resin = pt_add_material(b->scene, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color_texture = paint,
        .roughness = .5f, .coat = 1, .coat_roughness = .25f });
    pt_add_sphere(b->scene, pt_v3(0, 0, 0), 1, resin);
    pt_scene_commit(b->scene);

    pt_xform open = {{ -1, 0, 0, b->from.x,  0, 1, 0, b->from.y,  0, 0, -1, b->from.z }}, closed;   /* its -z to the viewer */
    turn(&open, pt_v3(1, 0, 0), -.75f);                    /* and up */
    turn(&open, pt_v3(0, 1, 0), .12f * (float)(b->number % 5) - .3f);
    closed = open;
    float far = sqrtf(b->way.x * b->way.x + b->way.z * b->way.z);
    if (far > 0) turn(&closed, pt_v3(b->way.z / far, 0, -b->way.x / far), b->roll);
    closed.m[3] += b->way.x;
    closed.m[11] += b->way.z;
    pt_add_moving_instance(s, b->scene, &open, &closed);
}

int main(int argc, char **argv) {
    ball balls[5] = {
        { .number = 1, .paint = {.85f, .55f, .02f}, .from = {-3.1f, 1, 1.3f} },
        { .number = 4, .paint = {.17f, .03f, .30f}, .from = {3.1f, 1, .9f} },
        { .number = 9, .paint = {.85f, .55f, .02f}, .stripe = 1, .from = {-.9f, 1, -.4f}, .way = {-.35f, 0, -.25f}, .roll = .4f },
        { .number = 8, .paint = {.02f, .02f, .02f}, .from = {1.3f, 1, -1.9f}, .way = {.8f, 0, -.4f}, .roll = .5f },
        { .number = 0, .from = {-.2f, 1, 2.3f}, .way = {.95f, 0, -.8f} } };
    pt_scene *s = pt_scene_create(NULL);
    pt_material cloth = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .color = {.015f, .20f, .085f},
        .roughness = 1, .specular = .2f, .sheen = .3f, .sheen_color = {.3f, .7f, .4f} });
    pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = {14, 12.5f, 10.5f} });
    pt_material window = pt_add_material(s, &(pt_material_desc){ .emission = {5, 6, 8} });
    for (int i = 0; i < 5; i++) add_ball(s, balls + i);
    pt_add_quad(s, pt_v3(-60, 0, -60), pt_v3(0, 0, 120), pt_v3(120, 0, 0), cloth);
    pt_add_quad(s, pt_v3(-6.5f, 9, -2.5f), pt_v3(5, 0, 0), pt_v3(0, 0, 3.2f), lamp);
    pt_add_quad(s, pt_v3(1.5f, 9, -2.5f), pt_v3(5, 0, 0), pt_v3(0, 0, 3.2f), lamp);
    pt_add_quad(s, pt_v3(-14, 3, 4), pt_v3(0, 5, 0), pt_v3(0, 0, 5), window);
    pt_add_light(s, &(pt_light_desc){ .color = {.05f, .05f, .06f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 480, .height = 320, .spp = 64, .max_depth = 8,
        .camera = { .eye = {0, 9, 12}, .target = {.1f, .5f, .1f}, .vfov_deg = 28, .shutter_close = 1 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "motion.png", pt_render_pixels(r), 480, 320, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    for (int i = 0; i < 5; i++) pt_scene_destroy(balls[i].scene);
    return result != PT_OK;
}
