/* A dahlia of 2000 petals. A petal is a small scene of its own, committed once; each instance is one matrix, and half of
   the matrices mirror. The sunflower's rule places them on a ball: turn by the golden angle, step down.
   cc -O2 03_instances.c -o 03_instances -lm -lpthread && ./03_instances [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

/* A petal grows along +y from the origin, is one unit long, cupped and a little twisted. */
static pt_scene *petal(float r, float g, float b) {
    enum { ROWS = 10, COLUMNS = 5, VERTICES = (ROWS + 1) * COLUMNS, INDICES = ROWS * (COLUMNS - 1) * 6 };
    float positions[VERTICES * 3], *p = positions;
    uint32_t indices[INDICES], *to = indices;
    for (int i = 0; i <= ROWS; i++)
        for (int j = 0; j < COLUMNS; j++) {
            float y = (float)i / ROWS, across = 2 * (float)j / (COLUMNS - 1) - 1, x = across * (.02f + .26f * sinf(3.1f * powf(y, .8f)));
            *p++ = x;
            *p++ = y;
            *p++ = .9f * x * across + .35f * x * y - .2f * y * y;
        }
    for (uint32_t i = 0; i < ROWS; i++)
        for (uint32_t j = 0; j + 1 < COLUMNS; j++) {
            uint32_t a = i * COLUMNS + j, c = a + COLUMNS;
            *to++ = a; *to++ = a + 1; *to++ = c + 1;
            *to++ = a; *to++ = c + 1; *to++ = c;
        }
    pt_scene *s = pt_scene_create(NULL);
    pt_material m = pt_add_material(s, &(pt_material_desc){ .color = {r, g, b} });
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = positions, .vertex_count = VERTICES, .indices = indices, .index_count = INDICES,
        .material = m });
    pt_scene_commit(s);
    return s;
}

int main(int argc, char **argv) {
    enum { PETALS = 2000, COLORS = 4 };
    pt_scene *colors[COLORS] = { petal(.90f,.66f,.12f), petal(.90f,.36f,.08f), petal(.80f,.10f,.14f), petal(.50f,.04f,.26f) };
    pt_scene *s = pt_scene_create(NULL);
    for (int i = 0; i < PETALS; i++) {
        /* A point of the unit ball, n, and where its petal points: outwards, and leaning down the ball by lean. */
        float f = ((float)i + .5f) / PETALS, turn = (float)i * 2.3999632f, down = acosf(1 - 1.5f * f), lean = .35f + .5f * f;
        float size = .09f + .30f * sqrtf(f), mirror = i % 2 ? -1.f : 1.f, c = cosf(turn), n = sinf(turn);
        float up = cosf(down), out = sinf(down), ly = cosf(down + lean), lo = sinf(down + lean);
        /* Its columns: where the petal's x, y and z go (around, along, and across the ball), and where it stands. */
        pt_xform place = { {
            size * mirror * -n,   size * lo * c,   size * ly * c,    out * c,
            0,                    size * ly,       size * -lo,       up,
            size * mirror * c,    size * lo * n,   size * ly * n,    out * n } };
        pt_add_instance(s, colors[i * COLORS / PETALS], &place);
    }
    pt_material ground = pt_add_material(s, &(pt_material_desc){ .color = {.10f, .16f, .12f} });
    pt_material lamp   = pt_add_material(s, &(pt_material_desc){ .emission = {26, 22, 17} });
    pt_material bud    = pt_add_material(s, &(pt_material_desc){ .color = {.30f, .12f, .03f} });
    pt_add_sphere(s, pt_v3(0, 0, 0), .98f, bud);
    pt_add_quad(s, pt_v3(-200, -.75f, -200), pt_v3(0, 0, 400), pt_v3(400, 0, 0), ground);
    pt_add_sphere(s, pt_v3(-4, 6, 3), 1, lamp);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.42f, .50f, .62f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 512, .height = 512, .spp = 16, .max_depth = 6,
        .camera = { .eye = {0, 3.6f, 3.0f}, .target = {0, .15f, .05f}, .vfov_deg = 34 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "instances.png", pt_render_pixels(r), 512, 512, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);                                   /* the petals' scenes outlive the scene that places them */
    for (int i = 0; i < COLORS; i++) pt_scene_destroy(colors[i]);
    return result != PT_OK;
}
