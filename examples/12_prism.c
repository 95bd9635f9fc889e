/* White light through a slit and a prism, grazing a board that shows its way. Glass with an Abbe number bends blue more than
   red: a path that meets it carries one wavelength from there on. From the board, hardly any ray would find the sun through
   the prism by chance, so the example adds a density of its own to the mixture: fans of directions that the light comes from.
   cc -O2 12_prism.c -o 12_prism -lm -lpthread && ./12_prism [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

/* The prism's sides stand on the board, so that none of them changes a direction's z: it is the sun's, within the sun's own
   size. In the plane, coming in 30 degrees upwards is the angle of least deviation, and colours leave 30 degrees downwards.
   A ring with z as its height has the area of its map (Archimedes): the density is 1 / (2 width 2 SUN). */
#define SUN 0.016f                                        /* angular radius */
static const float tilt = 0.07f, degree = 3.14159265f / 180;
static const struct { float middle_deg, width_deg, share; } fan[4] = {
    {148, 4.6f, .72f},                                    /* through the prism, from violet to red */
    {-90, 1, .08f}, {30, 7, .10f},                        /* mirrored by its first side, and inside by its second */
    {0, 180, .10f} };                                     /* all round: whatever else */

static int fans_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    float choice = u[0], z = tilt + SUN * (2 * u[1] - 1), r = sqrtf(1 - z * z), angle;
    int i = 0;
    (void)user; (void)x;
    while (i < 3 && choice >= fan[i].share) choice -= fan[i++].share;
    angle = degree * (fan[i].middle_deg + fan[i].width_deg * (2 * choice / fan[i].share - 1));
    *wi = pt_v3(r * cosf(angle), r * sinf(angle), z);
    return 1;
}
static float fans_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    float angle = atan2f(wi.y, wi.x) / degree, pdf = 0;
    (void)user; (void)x;
    if (fabsf(wi.z - tilt) > SUN) return 0;
    for (int i = 0; i < 4; i++)
        if (fabsf(angle - fan[i].middle_deg) <= fan[i].width_deg) pdf += fan[i].share / (4 * SUN * fan[i].width_deg * degree);
    return pdf;
}

/* Dark, but for a panel that the prism's top shows. */
static pt_vec3 room(void *user, pt_vec3 d) {
    (void)user;
    return .98f * d.z + .18f * d.y - .07f * d.x > .985f ? pt_v3(.30f, .32f, .38f) : pt_v3(.009f, .009f, .012f);
}

int main(int argc, char **argv) {
    static const float corner[] = { -.5f,-.289f,.001f, .5f,-.289f,.001f, 0,.577f,.001f,
                                    -.5f,-.289f,.4f,   .5f,-.289f,.4f,   0,.577f,.4f };
    static const uint32_t face[] = { 0,2,1, 3,4,5, 0,1,4, 0,4,3, 1,2,5, 1,5,4, 2,0,3, 2,3,5 };
    pt_scene *s = pt_scene_create(NULL);
    pt_material glass = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.73f, .abbe = 26 });
    pt_material sun   = pt_add_material(s, &(pt_material_desc){ .emission = {3.5e5f, 3.5e5f, 3.5e5f} });
    pt_material board = pt_add_material(s, &(pt_material_desc){ .color = {.75f, .75f, .75f} });
    pt_material black = pt_add_material(s, &(pt_material_desc){ .color = {.001f, .001f, .001f} });
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = corner, .vertex_count = 6, .indices = face, .index_count = 24,
        .material = glass });
    pt_add_quad(s, pt_v3(-9, -9, 0), pt_v3(18, 0, 0), pt_v3(0, 18, 0), board);
    pt_add_quad(s, pt_v3(-2.6f, -9, 0), pt_v3(0, 7.760f, 0), pt_v3(0, 0, 2), black);      /* two plates, 6 cm apart, */
    pt_add_quad(s, pt_v3(-2.6f, -1.18f, 0), pt_v3(0, 10, 0), pt_v3(0, 0, 2), black);
    pt_add_quad(s, pt_v3(-2.6f, -1.3f, .36f), pt_v3(0, .2f, 0), pt_v3(0, 0, 2), black);   /* and one above the slit */
    pt_add_sphere(s, pt_v3(-173, -99.6f, 14.2f), 200 * SUN, sun);
    pt_add_light(s, &(pt_light_desc){ .radiance = room });
    pt_add_density(s, &(pt_density_desc){ .weight = .8f, .sample = fans_sample, .pdf = fans_pdf });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 640, .height = 360, .spp = 192, .max_depth = 12,
        .camera = { .eye = {.5f, -1.2f, 6}, .target = {.1f, -.12f, 0}, .vfov_deg = 24 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "prism.png", pt_render_pixels(r), 640, 360, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
