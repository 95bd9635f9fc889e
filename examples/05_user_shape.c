/* A shape of one's own: a gyroid, a surface without a single straight line that halves space, cut out of a ball. It is
   found by marching along the ray until the function that defines it changes its sign, then bisecting.
   cc -O2 05_user_shape.c -o 05_user_shape -lm -lpthread && ./05_user_shape [FILE.png] */
#define PT_IMPLEMENTATION
#include "../pt.h"
#include <math.h>
#include <stdio.h>

static pt_vec3 along(const pt_ray *ray, float t) {
    return pt_v3(ray->org.x + t * ray->dir.x, ray->org.y + t * ray->dir.y, ray->org.z + t * ray->dir.z);
}
/* Negative inside, positive outside, and never larger than the distance to the surface. */
static float distance(pt_vec3 p) {
    const float k = 8, thickness = .04f;
    float g = sinf(k*p.x) * cosf(k*p.y) + sinf(k*p.y) * cosf(k*p.z) + sinf(k*p.z) * cosf(k*p.x);
    float gyroid = fabsf(g) / (1.7320508f * k) - thickness, ball = sqrtf(p.x*p.x + p.y*p.y + p.z*p.z) - 1;
    return fmaxf(gyroid, ball);
}
static pt_vec3 gradient(pt_vec3 p) {
    const float h = 1e-3f;
    pt_vec3 n = pt_v3(distance(pt_v3(p.x + h, p.y, p.z)) - distance(pt_v3(p.x - h, p.y, p.z)),
                      distance(pt_v3(p.x, p.y + h, p.z)) - distance(pt_v3(p.x, p.y - h, p.z)),
                      distance(pt_v3(p.x, p.y, p.z + h)) - distance(pt_v3(p.x, p.y, p.z - h)));
    float length = sqrtf(n.x * n.x + n.y * n.y + n.z * n.z);
    return pt_v3(n.x / length, n.y / length, n.z / length);
}
static void bounds(void *user, pt_vec3 *lo, pt_vec3 *hi) {
    (void)user;
    *lo = pt_v3(-1, -1, -1);
    *hi = pt_v3(1, 1, 1);
}
static int intersect(void *user, const pt_ray *ray, pt_vertex *x) {
    const float step = 4e-3f;                              /* the shortest; starting with it, a ray leaves its own surface */
    pt_vec3 o = ray->org, d = ray->dir;
    float a = d.x*d.x + d.y*d.y + d.z*d.z, b = o.x*d.x + o.y*d.y + o.z*d.z, c = o.x*o.x + o.y*o.y + o.z*o.z - 1.02f;
    float root = b * b - a * c, speed = sqrtf(a), t, t_end, f;
    (void)user;
    if (root < 0) return 0;                                /* t_end: where the ray leaves the ball */
    t = fmaxf(ray->tmin + step / speed, (-b - sqrtf(root)) / a);
    t_end = fminf(ray->tmax, (-b + sqrtf(root)) / a);
    for (f = t < t_end ? distance(along(ray, t)) : 0; t < t_end; ) {
        float t1 = t + fmaxf(fabsf(f), step) / speed, f1 = distance(along(ray, t1));
        if ((f1 > 0) != (f > 0)) {                         /* the surface lies between t and t1 */
            for (int i = 0; i < 12; i++) {
                float middle = .5f * (t + t1);
                if ((distance(along(ray, middle)) > 0) == (f > 0)) t = middle; else t1 = middle;
            }
            if (t <= ray->tmin || t >= ray->tmax) return 0;
            x->t = t;                                      /* the near end: on the side that the ray comes from */
            x->ng = gradient(along(ray, t));
            return 1;
        }
        t = t1;
        f = f1;
    }
    return 0;
}

int main(int argc, char **argv) {
    static const pt_shape_vtable gyroid = { bounds, intersect };
    pt_scene *s = pt_scene_create(NULL);
    pt_material china = pt_add_material(s, &(pt_material_desc){ .color = {.78f, .77f, .74f} });
    pt_material table = pt_add_material(s, &(pt_material_desc){ .color = {.16f, .22f, .30f} });
    pt_material lamp  = pt_add_material(s, &(pt_material_desc){ .emission = {34, 29, 22} });
    pt_material core  = pt_add_material(s, &(pt_material_desc){ .emission = {5, 1.6f, .35f} });
    pt_add_user_shape(s, &gyroid, NULL, china);
    pt_add_sphere(s, pt_v3(0, 0, 0), .30f, core);          /* a glowing heart */
    pt_add_quad(s, pt_v3(-200, -1, -200), pt_v3(0, 0, 400), pt_v3(400, 0, 0), table);
    pt_add_quad(s, pt_v3(-3, 4, -1), pt_v3(1.5f, 0, 0), pt_v3(0, -.7f, 1.2f), lamp);
    pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {.16f, .20f, .27f} });
    if (pt_scene_commit(s) != PT_OK) { fprintf(stderr, "%s\n", pt_scene_error(s)); return 1; }

    pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 480, .height = 480, .spp = 32, .max_depth = 8,
        .camera = { .eye = {1.6f, 1.4f, 4.2f}, .target = {0, -.08f, 0}, .vfov_deg = 32 } });
    pt_result result = pt_render_run(r);
    if (result == PT_OK) result = pt_write_png(argc > 1 ? argv[1] : "shape.png", pt_render_pixels(r), 480, 480, NULL);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    return result != PT_OK;
}
