/* Lens flare without a trick: the camera looks at a low sun through two lenses and an iris. Their faces are silvered, a third of
   the light is mirrored, as no maker would allow; what is mirrored twice goes forwards again and makes one ghost of the sun for
   each pair of faces, in the product of their colours, cut where the iris or a rim is in the way.
   cc -O2 15_lens_flare.c -o 15_lens_flare -lm -lpthread && ./15_lens_flare [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

/* A lens about the z axis: two spherical caps through z[0] and z[1], and a rim. 1 / curvature
   is a cap's radius, above 0 where its middle lies towards +z. */
typedef struct lens { float z[2], curvature[2], radius; } lens;

static float sag(const lens *l, int side, float rr) {      /* where the cap is, rr = distance from the axis, squared */
    float c = l->curvature[side];
    return l->z[side] + c * rr / (1 + sqrtf(1 - c * c * rr));
}
static void lens_bounds(void *user, pt_vec3 *lo, pt_vec3 *hi) {
    const lens *l = (const lens *)user;
    float rr = l->radius * l->radius;
    *lo = pt_v3(-l->radius, -l->radius, fminf(l->z[0], sag(l, 0, rr)));
    *hi = pt_v3(l->radius, l->radius, fmaxf(l->z[1], sag(l, 1, rr)));
}
static pt_vec3 along(const pt_ray *ray, float t) {
    return pt_v3(ray->org.x + t * ray->dir.x, ray->org.y + t * ray->dir.y, ray->org.z + t * ray->dir.z);
}
static int hit(const pt_ray *ray, pt_vertex *x, float t, pt_vec3 n) {
    if (!(t > ray->tmin && t < ray->tmax && t < x->t)) return 0;
    x->t = t;
    x->ng = n;
    return 1;
}
static int lens_intersect(void *user, const pt_ray *ray, pt_vertex *x) {
    const lens *l = (const lens *)user;
    pt_vec3 o = ray->org, d = ray->dir;
    float dd = d.x * d.x + d.y * d.y + d.z * d.z, d2 = d.x * d.x + d.y * d.y, rr = l->radius * l->radius;
    int found = 0;
    x->t = INFINITY;
    for (int side = 0; side < 2; side++) {                 /* c (x^2 + y^2 + w^2) = 2 w, where w = z - z[side] */
        float c = l->curvature[side], w = o.z - l->z[side];
        float a = c * dd, b = d.z - c * (o.x * d.x + o.y * d.y + w * d.z), k = c * (o.x * o.x + o.y * o.y + w * w) - 2 * w;
        float root = sqrtf(fmaxf(b * b - a * k, 0)), q = b + (b < 0 ? -root : root), t[2] = { k / q, q / a };
        if (b * b < a * k) continue;
        for (int i = 0; i < 2; i++) {                      /* of the whole sphere, only the cap */
            pt_vec3 p = along(ray, t[i]);
            float outwards = side ? 1.0f : -1.0f;
            if (p.x * p.x + p.y * p.y > rr || c * (p.z - l->z[side]) > 1) continue;
            found |= hit(ray, x, t[i], pt_v3(-outwards * c * p.x, -outwards * c * p.y,
                                             outwards * (1 - c * (p.z - l->z[side]))));
        }
    }
    if (d2 > 0) {                                          /* the rim */
        float b = o.x * d.x + o.y * d.y, root = sqrtf(fmaxf(b * b - d2 * (o.x * o.x + o.y * o.y - rr), 0));
        for (int i = 0; i < 2; i++) {
            float t = (-b + (i ? root : -root)) / d2;
            pt_vec3 p = along(ray, t);
            if (root > 0 && p.z > sag(l, 0, rr) && p.z < sag(l, 1, rr)) found |= hit(ray, x, t, pt_v3(p.x, p.y, 0));
        }
    }
    return found;
}

/* A plate with a hexagonal hole: two triangles for each of its sides. */
static void add_iris(pt_scene *s, float z, float hole, pt_material m) {
    float p[12][3];
    uint32_t index[36];
    for (int i = 0; i < 6; i++) {
        float a = 3.14159265f * ((float)i / 3 + .1f), r[2] = { hole, 3 };
        for (int j = 0; j < 2; j++) {
            p[2 * i + j][0] = r[j] * cosf(a);
            p[2 * i + j][1] = r[j] * sinf(a);
            p[2 * i + j][2] = z;
        }
        uint32_t k = 2 * (uint32_t)i, next = (k + 2) % 12, corners[6] = { k, k + 1, next + 1, k, next + 1, next };
        memcpy(index + 6 * i, corners, sizeof corners);
    }
    pt_add_mesh(s, &(pt_mesh_desc){ .positions = &p[0][0], .vertex_count = 12, .indices = index, .index_count = 36,
        .material = m });
}

static pt_vec3 sky(void *user, pt_vec3 d) {
    float up = d.y > 0 ? d.y : 0, haze = (1 - up) * (1 - up) * (1 - up) * (1 - up);
    (void)user;
    if (d.z < 0) return pt_v3(0, 0, 0);                    /* inside the camera */
    return d.y < 0 ? pt_v3(.02f, .017f, .02f) : pt_v3(.04f + .55f * haze, .06f + .20f * haze, .14f + .04f * haze);
}

int main(int argc, char **argv) {
    static const pt_shape_vtable lens_shape = { lens_bounds, lens_intersect };
    static lens rear = { {2.312f, 2.837f}, {-.338f, -.276f}, 1 }, front = { {3.369f, 3.649f}, {-.107f, -.197f}, 1.1f };
    pt_scene *s = pt_scene_create(NULL);
    pt_material clear  = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.85f });
    pt_material purple = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = {.95f, .35f, .75f} });
    pt_material green  = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = {.35f, .95f, .60f} });
    pt_material rear_glass = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .mix = .25f,
        .a = clear, .b = purple });
    pt_material front_glass = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .mix = .25f,
        .a = clear, .b = green });
    pt_material black = pt_add_material(s, &(pt_material_desc){ .color = {.001f, .001f, .001f} });
    pt_material sun = pt_add_material(s, &(pt_material_desc){ .emission = {70, 56, 38} });
    pt_add_user_shape(s, &lens_shape, &rear, rear_glass);
    pt_add_user_shape(s, &lens_shape, &front, front_glass);
    add_iris(s, 3.103f, .6f, black);
    pt_add_sphere(s, pt_v3(42, 26, 1000), 20, sun);
    pt_add_light(s, &(pt_light_desc){ .radiance = sky });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }
    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 320, .height = 240, .spp = 256, .max_depth = 12,
        .camera = { .eye = {0, 0, 0}, .target = {0, 0, 1}, .vfov_deg = 21 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "flare.png", pt_render_pixels(r), 320, 240, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
