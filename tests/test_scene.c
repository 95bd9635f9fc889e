/* >>scene: what is refused, in which words, and that nothing crashes or leaks when memory runs out anywhere. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include <stddef.h>

/* ---- errors ---- */

static const float tri[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
typedef struct heard { int count; pt_result code; char text[256]; } heard;
static void hear(void *user, pt_result code, const char *message) {
    heard *h = (heard *)user;
    h->count++;
    h->code = code;
    snprintf(h->text, sizeof h->text, "%s", message);
}
static float not_a_number(void) { volatile float zero = 0; return zero / zero; }
static float infinite(void) { return (float)HUGE_VAL; }

static void bounds_fine(void *user, pt_vec3 *lo, pt_vec3 *hi) { (void)user; *lo = pt_v3(-1, -1, -1); *hi = pt_v3(1, 1, 1); }
static void bounds_nan(void *user, pt_vec3 *lo, pt_vec3 *hi) { (void)user; *lo = pt_v3(-1, not_a_number(), -1); *hi = pt_v3(1, 1, 1); }
static void bounds_inside_out(void *user, pt_vec3 *lo, pt_vec3 *hi) { (void)user; *lo = pt_v3(1, 1, 1); *hi = pt_v3(-1, -1, -1); }
static int never_hit(void *user, const pt_ray *ray, pt_vertex *x) { (void)user; (void)ray; (void)x; return 0; }
static int density_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    (void)user; (void)x;
    *wi = pti_sample_sphere(u[0], u[1]);
    return 1;
}
static float density_pdf(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return 1 / (4 * PTI_PI); }
static pt_vec3 grey_eval(void *user, const pt_vertex *x) { (void)user; (void)x; return pt_v3(0.5f, 0.5f, 0.5f); }
static pt_vec3 sky_radiance(void *user, pt_vec3 dir) { (void)user; return pt_v3(1 + dir.y, 1, 1); }
static pt_vec3 user_eval(void *user, const pt_vertex *x, pt_vec3 wi) { (void)user; (void)x; (void)wi; return pt_v3(0, 0, 0); }
static int user_sample(void *user, const pt_vertex *x, const float u[3], pt_scatter *out) { (void)user; (void)x; (void)u; (void)out; return 0; }

typedef struct fixture { pt_scene *s, *committed, *open, *nested; heard heard; } fixture;
static fixture fixture_make(void) {
    fixture f;
    memset(&f, 0, sizeof f);
    f.committed = pt_scene_create(NULL);
    pt_scene_commit(f.committed);
    f.open = pt_scene_create(NULL);
    f.nested = pt_scene_create(NULL);
    pt_add_instance(f.nested, f.committed, NULL);
    pt_scene_commit(f.nested);
    return f;
}
static void fixture_free(fixture *f) { pt_scene_destroy(f->nested); pt_scene_destroy(f->committed); pt_scene_destroy(f->open); }

/* One bad call each. want: parts of the message, separated by '|'. */
typedef struct bad_call { const char *name, *want; uint32_t (*call)(fixture *f); } bad_call;
static pt_material none_material = { 0 }, far_material = { 7 };
static pt_texture far_texture = { 9 };
#define MESH(...) pt_add_mesh(f->s, &(pt_mesh_desc){ __VA_ARGS__ }).id
#define BAD(name, expression) static uint32_t bad_##name(fixture *f) { return (expression); }
static uint32_t bad_index(fixture *f) { static const uint32_t i[6] = { 0, 1, 2, 0, 5, 2 }; return MESH(.positions = tri, .vertex_count = 3, .indices = i, .index_count = 6); }
static uint32_t bad_position(fixture *f) { float p[9]; memcpy(p, tri, sizeof p); p[4] = not_a_number(); return MESH(.positions = p, .vertex_count = 3); }
static uint32_t bad_position_inf(fixture *f) { float p[9]; memcpy(p, tri, sizeof p); p[7] = infinite(); return MESH(.positions = p, .vertex_count = 3, .borrow = 1); }
static uint32_t bad_position_huge(fixture *f) { float p[9]; memcpy(p, tri, sizeof p); p[7] = -2e12f; return MESH(.positions = p, .vertex_count = 3); }
static uint32_t bad_normal(fixture *f) { float p[9]; memcpy(p, tri, sizeof p); p[8] = not_a_number(); return MESH(.positions = tri, .normals = p, .vertex_count = 3); }
static uint32_t bad_uv(fixture *f) { float p[6] = { 0, 0, 1, 0, 0, 0 }; p[5] = -infinite(); return MESH(.positions = tri, .uvs = p, .vertex_count = 3); }
static uint32_t bad_float_texture(fixture *f) { float p[3] = { 1, 1, 1 }; p[1] = not_a_number(); return pt_add_texture(f->s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 3, .bits = 32, .pixels = p }).id; }
static uint32_t bad_map(fixture *f, float value) {
    float p[3] = { 1, 1, 1 };
    pt_texture t;
    p[2] = value;
    t = pt_add_texture(f->s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 3, .bits = 32, .pixels = p });
    return pt_add_light(f->s, &(pt_light_desc){ .texture = t }).id;
}
static uint32_t bad_map_negative(fixture *f) { return bad_map(f, -1); }
static uint32_t bad_map_bright(fixture *f) { return bad_map(f, 3e38f); }
BAD(emission_bright, pt_add_material(f->s, &(pt_material_desc){ .emission = { 1e30f, 0, 0 } }).id)
BAD(light_bright, pt_add_light(f->s, &(pt_light_desc){ .color = { 1, 2e12f, 1 } }).id)
BAD(endless_indices, MESH(.positions = tri, .vertex_count = 3, .indices = (const uint32_t[]){ 0, 1, 2 }, .index_count = SIZE_MAX))
BAD(no_positions, MESH(.vertex_count = 3))
BAD(stride, MESH(.positions = tri, .vertex_count = 3, .vertex_stride = 8))
BAD(stride_odd, MESH(.positions = tri, .vertex_count = 2, .vertex_stride = 14))
BAD(vertex_count, MESH(.positions = tri, .vertex_count = SIZE_MAX / 4, .vertex_stride = 12))
BAD(corners, MESH(.positions = tri, .vertex_count = 2))
BAD(index_count, MESH(.positions = tri, .vertex_count = 3, .index_count = 6))
BAD(mesh_material, MESH(.positions = tri, .vertex_count = 3, .material = far_material))
BAD(mesh_null, pt_add_mesh(f->s, NULL).id)
BAD(sphere_center, pt_add_sphere(f->s, pt_v3(0, not_a_number(), 0), 1, none_material).id)
BAD(sphere_radius, pt_add_sphere(f->s, pt_v3(0, 0, 0), 0, none_material).id)
BAD(sphere_negative, pt_add_sphere(f->s, pt_v3(0, 0, 0), -2, none_material).id)
BAD(sphere_nan, pt_add_sphere(f->s, pt_v3(0, 0, 0), not_a_number(), none_material).id)
BAD(sphere_material, pt_add_sphere(f->s, pt_v3(0, 0, 0), 1, far_material).id)
BAD(quad_corner, pt_add_quad(f->s, pt_v3(infinite(), 0, 0), pt_v3(1, 0, 0), pt_v3(0, 1, 0), none_material).id)
BAD(quad_edge_u, pt_add_quad(f->s, pt_v3(0, 0, 0), pt_v3(not_a_number(), 0, 0), pt_v3(0, 1, 0), none_material).id)
BAD(quad_edge_v, pt_add_quad(f->s, pt_v3(0, 0, 0), pt_v3(1, 0, 0), pt_v3(0, 2e12f, 0), none_material).id)
BAD(quad_sum, pt_add_quad(f->s, pt_v3(9e11f, 0, 0), pt_v3(9e11f, 0, 0), pt_v3(0, 1, 0), none_material).id)
BAD(quad_material, pt_add_quad(f->s, pt_v3(0, 0, 0), pt_v3(1, 0, 0), pt_v3(0, 1, 0), far_material).id)
BAD(box_lo, pt_add_box(f->s, pt_v3(not_a_number(), 0, 0), pt_v3(1, 1, 1), NULL, none_material).id)
BAD(box_hi, pt_add_box(f->s, pt_v3(0, 0, 0), pt_v3(1, infinite(), 1), NULL, none_material).id)
BAD(box_order, pt_add_box(f->s, pt_v3(2, 0, 0), pt_v3(1, 1, 1), NULL, none_material).id)
BAD(box_material, pt_add_box(f->s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), NULL, far_material).id)
static uint32_t bad_box_xform(fixture *f) { pt_xform x = pti_xform_or_identity(NULL); x.m[5] = not_a_number(); return pt_add_box(f->s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), &x, none_material).id; }
static uint32_t bad_instance_xform(fixture *f) { pt_xform x = pti_xform_or_identity(NULL); x.m[7] = infinite(); return pt_add_instance(f->s, f->committed, &x).id; }
static uint32_t bad_singular(fixture *f) { pt_xform x = pti_xform_or_identity(NULL); x.m[5] = 0; return pt_add_instance(f->s, f->committed, &x).id; }
BAD(instance_null, pt_add_instance(f->s, NULL, NULL).id)
BAD(instance_self, pt_add_instance(f->s, f->s, NULL).id)
BAD(instance_open, pt_add_instance(f->s, f->open, NULL).id)
BAD(instance_nested, pt_add_instance(f->s, f->nested, NULL).id)
BAD(user_null, pt_add_user_shape(f->s, NULL, NULL, none_material).id)
BAD(user_no_bounds, pt_add_user_shape(f->s, &(pt_shape_vtable){ .intersect = never_hit }, NULL, none_material).id)
BAD(user_no_intersect, pt_add_user_shape(f->s, &(pt_shape_vtable){ .bounds = bounds_fine }, NULL, none_material).id)
BAD(user_nan, pt_add_user_shape(f->s, &(pt_shape_vtable){ bounds_nan, never_hit }, NULL, none_material).id)
BAD(user_order, pt_add_user_shape(f->s, &(pt_shape_vtable){ bounds_inside_out, never_hit }, NULL, none_material).id)
BAD(user_material, pt_add_user_shape(f->s, &(pt_shape_vtable){ bounds_fine, never_hit }, NULL, far_material).id)
BAD(material_null, pt_add_material(f->s, NULL).id)
BAD(material_bsdf, pt_add_material(f->s, &(pt_material_desc){ .bsdf = (pt_bsdf)17 }).id)
BAD(material_color, pt_add_material(f->s, &(pt_material_desc){ .color = { 0.5f, 1.25f, 0 } }).id)
BAD(material_color_nan, pt_add_material(f->s, &(pt_material_desc){ .color = { 0.5f, not_a_number(), 0 } }).id)
BAD(material_emission, pt_add_material(f->s, &(pt_material_desc){ .emission = { -1, 0, 0 } }).id)
BAD(material_emission_inf, pt_add_material(f->s, &(pt_material_desc){ .emission = { 0, 0, infinite() } }).id)
BAD(material_ior, pt_add_material(f->s, &(pt_material_desc){ .ior = -1.5f }).id)
BAD(material_ior_nan, pt_add_material(f->s, &(pt_material_desc){ .ior = not_a_number() }).id)
BAD(material_texture, pt_add_material(f->s, &(pt_material_desc){ .color_texture = far_texture }).id)
BAD(material_vtable, pt_add_material(f->s, &(pt_material_desc){ .bsdf = PT_BSDF_USER }).id)
BAD(texture_null, pt_add_texture(f->s, NULL).id)
BAD(texture_pixels, pt_add_texture(f->s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 3 }).id)
BAD(texture_width, pt_add_texture(f->s, &(pt_texture_desc){ .width = 0, .height = 1, .channels = 3, .pixels = tri }).id)
BAD(texture_height, pt_add_texture(f->s, &(pt_texture_desc){ .width = 1, .height = -5, .channels = 3, .pixels = tri }).id)
BAD(texture_channels, pt_add_texture(f->s, &(pt_texture_desc){ .width = 1, .height = 1, .channels = 5, .pixels = tri }).id)
BAD(density_null, pt_add_density(f->s, NULL).id)
BAD(density_functions, pt_add_density(f->s, &(pt_density_desc){ .sample = density_sample }).id)
BAD(density_weight, pt_add_density(f->s, &(pt_density_desc){ .sample = density_sample, .pdf = density_pdf, .weight = 1.5f }).id)
BAD(density_nan, pt_add_density(f->s, &(pt_density_desc){ .sample = density_sample, .pdf = density_pdf, .weight = not_a_number() }).id)
BAD(light_null, pt_add_light(f->s, NULL).id)
BAD(light_kind, pt_add_light(f->s, &(pt_light_desc){ .kind = (pt_light_kind)5 }).id)
BAD(light_color, pt_add_light(f->s, &(pt_light_desc){ .color = { 1, -1, 1 } }).id)
BAD(light_color_inf, pt_add_light(f->s, &(pt_light_desc){ .color = { 1, infinite(), 1 } }).id)
BAD(light_rotate, pt_add_light(f->s, &(pt_light_desc){ .rotate_deg = not_a_number() }).id)
BAD(light_texture, pt_add_light(f->s, &(pt_light_desc){ .texture = far_texture }).id)
static uint32_t bad_light_second(fixture *f) { pt_add_light(f->s, &(pt_light_desc){ .color = { 1, 1, 1 } }); return pt_add_light(f->s, &(pt_light_desc){ .color = { 1, 1, 1 } }).id; }
static uint32_t bad_light_eval(fixture *f) { pt_texture t = pt_add_texture(f->s, &(pt_texture_desc){ .eval = grey_eval }); return pt_add_light(f->s, &(pt_light_desc){ .texture = t }).id; }

#define LIGHT(...) pt_add_light(f->s, &(pt_light_desc){ __VA_ARGS__ }).id
BAD(sun_direction, LIGHT(.kind = PT_LIGHT_SUN, .color = { 1, 1, 1 }, .direction = { 0, not_a_number(), 0 }))
BAD(sun_radius, LIGHT(.kind = PT_LIGHT_SUN, .color = { 1, 1, 1 }, .radius_deg = 91))
BAD(sun_small, LIGHT(.kind = PT_LIGHT_SUN, .color = { 1, 1, 1 }, .radius_deg = 1e-4f))
BAD(sun_nan, LIGHT(.kind = PT_LIGHT_SUN, .color = { 1, 1, 1 }, .radius_deg = not_a_number()))
BAD(sun_bright, LIGHT(.kind = PT_LIGHT_SUN, .color = { 1, 1e11f, 1 }))
BAD(point_position, LIGHT(.kind = PT_LIGHT_POINT, .color = { 1, 1, 1 }, .position = { 0, 0, infinite() }))
BAD(point_radius, LIGHT(.kind = PT_LIGHT_POINT, .color = { 1, 1, 1 }, .radius = -1))
BAD(point_nan, LIGHT(.kind = PT_LIGHT_POINT, .color = { 1, 1, 1 }, .radius = not_a_number()))
BAD(point_bright, LIGHT(.kind = PT_LIGHT_POINT, .color = { 1, 1, 1 }, .radius = 1e-15f))
BAD(spot_direction, LIGHT(.kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 }, .direction = { 0, infinite(), 0 }))
BAD(spot_cone, LIGHT(.kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 }, .cone_deg = 100))
BAD(spot_cone_negative, LIGHT(.kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 }, .cone_deg = -5))
BAD(spot_cone_nan, LIGHT(.kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 }, .cone_deg = not_a_number()))
BAD(spot_blend, LIGHT(.kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 }, .blend = 1.5f))
BAD(spot_blend_nan, LIGHT(.kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 }, .blend = not_a_number()))
BAD(sky_turbidity, LIGHT(.kind = PT_LIGHT_SKY, .turbidity = 1))
BAD(sky_turbidity_nan, LIGHT(.kind = PT_LIGHT_SKY, .turbidity = not_a_number()))
BAD(sky_direction, LIGHT(.kind = PT_LIGHT_SKY, .direction = { not_a_number(), 0, 0 }))
static uint32_t bad_sky_second(fixture *f) { pt_add_light(f->s, &(pt_light_desc){ .kind = PT_LIGHT_SKY }); return LIGHT(.color = { 1, 1, 1 }); }
static uint32_t bad_spot_placed(fixture *f) {
    pt_scene *inner = pt_scene_create(NULL);
    uint32_t id;
    pt_add_light(inner, &(pt_light_desc){ .kind = PT_LIGHT_SPOT, .color = { 1, 1, 1 } });
    pt_scene_commit(inner);
    id = pt_add_instance(f->s, inner, NULL).id;
    pt_scene_destroy(inner);
    return id;
}
#define MATERIAL(...) pt_add_material(f->s, &(pt_material_desc){ __VA_ARGS__ }).id
static uint32_t bad_lobes(fixture *f) {
    pt_material_desc d = { .bsdf = PT_BSDF_PRINCIPLED, .coat = 1, .sheen = 1, .translucency = 0.5f, .transmission = 0.5f, .transparency = 0.1f };
    int i;
    d.a = d.b = pt_add_material(f->s, &d);
    d.bsdf = PT_BSDF_MIX;
    for (i = 0; i < 4; i++) if (!(d.a = pt_add_material(f->s, &d)).id) return 0;
    return 1;
}
BAD(material_a, MATERIAL(.bsdf = PT_BSDF_MIX, .a = far_material))
BAD(material_b, MATERIAL(.bsdf = PT_BSDF_MIX, .b = far_material))

static const bad_call bad_calls[] = {
    { "sun direction", "pt_add_light|direction|nan", bad_sun_direction }, { "sun radius", "pt_add_light|radius_deg|91", bad_sun_radius },
    { "small sun", "pt_add_light|radius_deg|0.0001", bad_sun_small }, { "sun nan", "pt_add_light|radius_deg|nan", bad_sun_nan },
    { "bright sun", "pt_add_light|color is too bright", bad_sun_bright }, { "point position", "pt_add_light|position|inf", bad_point_position },
    { "point radius", "pt_add_light|radius|-1", bad_point_radius }, { "point nan", "pt_add_light|radius|nan", bad_point_nan },
    { "bright point", "pt_add_light|color is too bright", bad_point_bright }, { "spot direction", "pt_add_light|direction|inf", bad_spot_direction },
    { "spot cone", "pt_add_light|cone_deg|100", bad_spot_cone }, { "spot cone nan", "pt_add_light|cone_deg|nan", bad_spot_cone_nan },
    { "spot cone negative", "pt_add_light|cone_deg|-5", bad_spot_cone_negative }, { "spot blend", "pt_add_light|blend|1.5", bad_spot_blend },
    { "spot blend nan", "pt_add_light|blend|nan", bad_spot_blend_nan }, { "turbidity", "pt_add_light|turbidity|is 1", bad_sky_turbidity },
    { "turbidity nan", "pt_add_light|turbidity|nan", bad_sky_turbidity_nan }, { "sky direction", "pt_add_light|direction|nan", bad_sky_direction },
    { "sky and environment", "pt_add_light|environment already", bad_sky_second }, { "spot placed", "pt_add_instance|spots", bad_spot_placed },
    { "index", "pt_add_mesh|index 4 is 5|3 vertices", bad_index }, { "position", "pt_add_mesh|vertex 1|nan", bad_position },
    { "infinite position", "pt_add_mesh|vertex 2|inf", bad_position_inf }, { "huge position", "pt_add_mesh|vertex 2|-2e+12", bad_position_huge },
    { "normal", "pt_add_mesh|normal 2|nan", bad_normal }, { "uv", "pt_add_mesh|uv 2|inf", bad_uv },
    { "no positions", "pt_add_mesh|positions is NULL", bad_no_positions }, { "stride", "pt_add_mesh|vertex_stride is 8", bad_stride },
    { "odd stride", "pt_add_mesh|vertex_stride is 14", bad_stride_odd }, { "vertex_count", "pt_add_mesh", bad_vertex_count },
    { "negative map", "pt_add_light|pixel (0, 0)|-1", bad_map_negative }, { "bright map", "pt_add_light|pixel (0, 0)|3e+38", bad_map_bright },
    { "bright emission", "pt_add_material|emission|1e+30", bad_emission_bright }, { "bright light", "pt_add_light|color|2e+12", bad_light_bright },
    { "endless indices", "pt_add_mesh|index_count", bad_endless_indices },
    { "corners", "pt_add_mesh|2 indices", bad_corners }, { "index_count", "pt_add_mesh|index 3 is 3|3 vertices", bad_index_count },
    { "mesh material", "pt_add_mesh|material 7 does not exist", bad_mesh_material }, { "mesh NULL", "pt_add_mesh|NULL", bad_mesh_null },
    { "sphere center", "pt_add_sphere|center|nan", bad_sphere_center }, { "sphere radius", "pt_add_sphere|radius|is 0", bad_sphere_radius },
    { "sphere negative", "pt_add_sphere|radius|is -2", bad_sphere_negative }, { "sphere nan", "pt_add_sphere|radius|nan", bad_sphere_nan },
    { "sphere material", "pt_add_sphere|material 7", bad_sphere_material }, { "quad corner", "pt_add_quad|corner|inf", bad_quad_corner },
    { "quad edge_u", "pt_add_quad|edge_u|nan", bad_quad_edge_u }, { "quad edge_v", "pt_add_quad|edge_v|2e+12", bad_quad_edge_v },
    { "quad sum", "1.8e+12", bad_quad_sum }, { "quad material", "pt_add_quad|material 7", bad_quad_material },
    { "box lo", "pt_add_box|lo|nan", bad_box_lo }, { "box hi", "pt_add_box|hi|inf", bad_box_hi }, { "box order", "pt_add_box|lo|2 0 0", bad_box_order },
    { "box material", "pt_add_box|material 7", bad_box_material }, { "box xform", "pt_add_box|xform|nan", bad_box_xform },
    { "instance xform", "pt_add_instance|xform|inf", bad_instance_xform }, { "singular", "pt_add_instance|xform|no inverse", bad_singular },
    { "instance NULL", "pt_add_instance|NULL", bad_instance_null }, { "instance of itself", "pt_add_instance|itself", bad_instance_self },
    { "instance of open", "pt_add_instance|commit", bad_instance_open }, { "nested instance", "pt_add_instance|nest", bad_instance_nested },
    { "user NULL", "pt_add_user_shape|NULL", bad_user_null }, { "user bounds", "pt_add_user_shape|bounds or intersect is NULL", bad_user_no_bounds },
    { "user intersect", "pt_add_user_shape|NULL", bad_user_no_intersect }, { "user nan", "pt_add_user_shape|lo|nan", bad_user_nan },
    { "user order", "pt_add_user_shape|lo|1 1 1", bad_user_order }, { "user material", "pt_add_user_shape|material 7", bad_user_material },
    { "material NULL", "pt_add_material|NULL", bad_material_null }, { "bsdf", "pt_add_material|bsdf|17", bad_material_bsdf },
    { "color", "pt_add_material|color|1.25 0)", bad_material_color }, { "color nan", "pt_add_material|color|nan", bad_material_color_nan },
    { "emission", "pt_add_material|emission|-1", bad_material_emission }, { "emission inf", "pt_add_material|emission|inf", bad_material_emission_inf },
    { "ior", "pt_add_material|ior|-1.5", bad_material_ior }, { "ior nan", "pt_add_material|ior|nan", bad_material_ior_nan },
    { "color_texture", "pt_add_material|color_texture 9 does not exist", bad_material_texture }, { "vtable", "pt_add_material|vtable", bad_material_vtable },
    { "mix of a", "pt_add_material|a, a material|7 does not exist", bad_material_a }, { "mix of b", "pt_add_material|b, a material|7 does not exist", bad_material_b },
    { "lobes", "pt_add_material|too many lobes|16", bad_lobes },
    { "texture NULL", "pt_add_texture|NULL", bad_texture_null }, { "pixels", "pt_add_texture|pixels is NULL", bad_texture_pixels },
    { "texture width", "pt_add_texture|width|is 0", bad_texture_width }, { "texture height", "pt_add_texture|height|-5", bad_texture_height },
    { "channels", "pt_add_texture|channels|is 5", bad_texture_channels }, { "texture pixel", "pt_add_texture|nan", bad_float_texture },
    { "density NULL", "pt_add_density|NULL", bad_density_null }, { "density functions", "pt_add_density|sample or pdf is NULL", bad_density_functions },
    { "density weight", "pt_add_density|weight|1.5", bad_density_weight }, { "density nan", "pt_add_density|weight|nan", bad_density_nan },
    { "light NULL", "pt_add_light|NULL", bad_light_null }, { "light kind", "pt_add_light|kind|5", bad_light_kind },
    { "light color", "pt_add_light|color|1 -1 1", bad_light_color }, { "light inf", "pt_add_light|color|inf", bad_light_color_inf },
    { "rotate_deg", "pt_add_light|rotate_deg|nan", bad_light_rotate }, { "light texture", "pt_add_light|texture 9 does not exist", bad_light_texture },
    { "second environment", "pt_add_light|environment already", bad_light_second }, { "environment eval", "pt_add_light|pixels", bad_light_eval } };
#define BAD_CALLS ((int)(sizeof bad_calls / sizeof bad_calls[0]))

static int has_parts(const char *text, const char *want) {
    while (*want) {
        char part[128];
        size_t n = strcspn(want, "|");
        memcpy(part, want, n);
        part[n] = 0;
        if (!strstr(text, part)) return FAIL("\"%s\" does not say \"%s\"", text, part);
        want += n + (want[n] == '|');
    }
    return 1;
}
static void refused(const char *want, pt_material_desc *d) {
    pt_scene *s = pt_scene_create(NULL);
    test_case("%s", want);
    CHECK_EQ_INT(pt_add_material(s, d).id, 0);
    has_parts(pt_scene_error(s), want);
    CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_ARG);
    pt_scene_destroy(s);
}
/* Every number of a material: beyond either end, NaN, infinite, and two that are fine; every texture: one that does not exist. */
static void bad_numbers_of_materials(void) {
    static const struct { const char *name; size_t at; float bad[2], good[2]; } numbers[] = {
#define NUMBER(name, low, high, good) { #name, offsetof(pt_material_desc, name), { low, high }, { 0, good } },
#define UNIT(name) NUMBER(name, -0.01f, 1.01f, 1)
        PTI_NUMBERS(UNIT) UNIT(sheen_roughness) UNIT(transparency) UNIT(color.x) UNIT(color.y) UNIT(color.z) UNIT(sheen_color.x) UNIT(sheen_color.z)
        NUMBER(ior, -1, 101, 0.01f) NUMBER(coat_ior, 0.99f, 101, 1) NUMBER(abbe, 0.9f, 2e6f, 1) NUMBER(rotation_deg, -36001, 36001, -360)
        NUMBER(eta.x, -0.1f, 1001, 1000) NUMBER(eta.z, -0.1f, 1001, 1000) NUMBER(k.y, -0.1f, 1001, 1000) NUMBER(emission.y, -1, 2e12f, 1e11f) NUMBER(bump, -2e12f, 2e12f, -5)
#undef UNIT
#undef NUMBER
    };
    static const struct { const char *name; size_t at; } textures[] = {
#define TEXTURE(name) { #name "_texture", offsetof(pt_material_desc, name##_texture) },
        PTI_TEXTURES(TEXTURE)
#undef TEXTURE
    };
    size_t i;
    int k;
    for (i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        float bad[4];
        bad[0] = numbers[i].bad[0]; bad[1] = numbers[i].bad[1]; bad[2] = not_a_number(); bad[3] = infinite();
        for (k = 0; k < 4; k++) {
            pt_material_desc d;
            char want[128];
            memset(&d, 0, sizeof d);
            memcpy((char *)&d + numbers[i].at, &bad[k], sizeof bad[k]);
            snprintf(want, sizeof want, "pt_add_material|%.*s|%s", (int)strcspn(numbers[i].name, "."), numbers[i].name, k == 2 ? "nan" : k == 3 ? "inf" : "");
            refused(want, &d);
        }
        for (k = 0; k < 2; k++) {
            pt_scene *s = pt_scene_create(NULL);
            pt_material_desc d;
            memset(&d, 0, sizeof d);
            memcpy((char *)&d + numbers[i].at, &numbers[i].good[k], sizeof numbers[i].good[k]);
            test_case("%s %g", numbers[i].name, (double)numbers[i].good[k]);
            CHECK(pt_add_material(s, &d).id != 0);
            CHECK_STR(pt_scene_error(s), "");
            pt_scene_destroy(s);
        }
    }
    for (i = 0; i < sizeof textures / sizeof textures[0]; i++) {
        pt_material_desc d;
        char want[128];
        memset(&d, 0, sizeof d);
        memcpy((char *)&d + textures[i].at, &far_texture, sizeof far_texture);
        snprintf(want, sizeof want, "pt_add_material|%s|9 does not exist", textures[i].name);
        refused(want, &d);
    }
    CHECK_EQ_INT(sizeof textures / sizeof textures[0], 17);
}
static void bad_arguments(void) {
    int i;
    for (i = 0; i < BAD_CALLS; i++) {
        fixture f = fixture_make();
        pt_scene_desc d;
        char first[256];
        test_case("%s", bad_calls[i].name);
        memset(&d, 0, sizeof d);
        d.logger.log = hear; d.logger.user = &f.heard;
        f.s = pt_scene_create(&d);
        CHECK_STR(pt_scene_error(f.s), "");
        CHECK_EQ_INT(bad_calls[i].call(&f), 0);
        snprintf(first, sizeof first, "%s", pt_scene_error(f.s));
        if (CHECK(f.heard.count == 1)) { CHECK_STR(f.heard.text, first); CHECK_EQ_INT(f.heard.code, PT_ERR_ARG); }
        has_parts(first, bad_calls[i].want);
        CHECK_EQ_INT(pt_add_sphere(f.s, pt_v3(0, 0, 0), 1, none_material).id, 0);               /* sticky, and silent */
        bad_index(&f);
        CHECK_STR(pt_scene_error(f.s), first);
        CHECK_EQ_INT(pt_scene_commit(f.s), PT_ERR_ARG);
        CHECK_EQ_INT(pt_scene_commit(f.s), PT_ERR_ARG);
        CHECK(f.heard.count == 1);
        {
            pt_render *r = pt_render_create(f.s, &(pt_render_desc){ .width = 4, .height = 4 });
            pt_ray ray = { { 0, 0, 5 }, { 0, 0, -1 }, 0, 0, 0 };
            pt_vertex x;
            CHECK_EQ_INT(pt_render_run(r), PT_ERR_STATE);
            has_parts(pt_render_error(r), "not committed");
            CHECK(strncmp(strstr(pt_render_error(r), ": the scene is") ? strstr(pt_render_error(r), "committed: ") + 11 : "", first, 40) == 0);
            CHECK(pt_render_pixels(r) == NULL);
            CHECK(!pt_intersect(f.s, &ray, &x) && !pt_occluded(f.s, &ray));
            pt_render_destroy(r);
        }
        pt_scene_destroy(f.s);
        fixture_free(&f);
    }
}
/* On a committed scene nothing can be added, and what was there still renders. */
static void committed_scenes_refuse(void) {
    int i;
    for (i = 0; i < 9; i++) {
        heard h = { 0, PT_OK, "" };
        pt_scene_desc d = { { NULL, NULL, NULL }, { hear, NULL } };
        pt_scene *s;
        uint32_t id = 1;
        const char *call = "";
        d.logger.user = &h;
        s = pt_scene_create(&d);
        pt_add_sphere(s, pt_v3(0, 0, 0), 1, none_material);
        CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
        CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
        switch (i) {
        case 0: id = pt_add_mesh(s, &(pt_mesh_desc){ .positions = tri, .vertex_count = 3 }).id; call = "pt_add_mesh"; break;
        case 1: id = pt_add_sphere(s, pt_v3(0, 0, 0), 1, none_material).id; call = "pt_add_sphere"; break;
        case 2: id = pt_add_quad(s, pt_v3(0, 0, 0), pt_v3(1, 0, 0), pt_v3(0, 1, 0), none_material).id; call = "pt_add_quad"; break;
        case 3: id = pt_add_box(s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), NULL, none_material).id; call = "pt_add_box"; break;
        case 4: id = pt_add_instance(s, s, NULL).id; call = "pt_add_instance"; break;
        case 5: id = pt_add_material(s, &(pt_material_desc){ .ior = 1 }).id; call = "pt_add_material"; break;
        case 6: id = pt_add_texture(s, &(pt_texture_desc){ .eval = grey_eval }).id; call = "pt_add_texture"; break;
        case 7: id = pt_add_light(s, &(pt_light_desc){ .rotate_deg = 1 }).id; call = "pt_add_light"; break;
        case 8: id = pt_add_density(s, &(pt_density_desc){ .sample = density_sample, .pdf = density_pdf }).id; call = "pt_add_density"; break;
        }
        test_case("%s", call);
        CHECK_EQ_INT(id, 0);
        CHECK_EQ_INT(h.count, 1);
        CHECK_EQ_INT(h.code, PT_ERR_STATE);
        has_parts(h.text, "committed");
        has_parts(h.text, call);
        {
            pt_ray ray = { { 0, 0, 5 }, { 0, 0, -1 }, 0, 0, 0 };
            CHECK(pt_occluded(s, &ray));
        }
        pt_scene_destroy(s);
    }
}
static void null_handles(void) {
    pt_ray ray = { { 0, 0, 5 }, { 0, 0, -1 }, 0, 0, 0 };
    pt_vertex x;
    pt_scene *s = pt_scene_create(NULL);
    pt_scene_destroy(NULL);
    CHECK(pt_scene_commit(NULL) < 0);
    CHECK(pt_scene_error(NULL)[0] != 0);
    CHECK_EQ_INT(pt_add_mesh(NULL, NULL).id, 0);
    CHECK_EQ_INT(pt_add_mesh(NULL, &(pt_mesh_desc){ .positions = tri, .vertex_count = 3 }).id, 0);
    CHECK_EQ_INT(pt_add_sphere(NULL, pt_v3(0, 0, 0), 1, none_material).id, 0);
    CHECK_EQ_INT(pt_add_quad(NULL, pt_v3(0, 0, 0), pt_v3(1, 0, 0), pt_v3(0, 1, 0), none_material).id, 0);
    CHECK_EQ_INT(pt_add_box(NULL, pt_v3(0, 0, 0), pt_v3(1, 1, 1), NULL, none_material).id, 0);
    CHECK_EQ_INT(pt_add_instance(NULL, NULL, NULL).id, 0);
    CHECK_EQ_INT(pt_add_instance(NULL, s, NULL).id, 0);
    CHECK_EQ_INT(pt_add_user_shape(NULL, NULL, NULL, none_material).id, 0);
    CHECK_EQ_INT(pt_add_material(NULL, NULL).id, 0);
    CHECK_EQ_INT(pt_add_texture(NULL, NULL).id, 0);
    CHECK_EQ_INT(pt_add_density(NULL, NULL).id, 0);
    CHECK_EQ_INT(pt_add_light(NULL, NULL).id, 0);
    CHECK(!pt_intersect(NULL, &ray, &x) && !pt_occluded(NULL, &ray));
    CHECK(!pt_intersect(s, &ray, &x) && !pt_occluded(s, &ray));        /* not committed */
    pt_scene_commit(s);
    CHECK(!pt_intersect(s, &ray, NULL) && !pt_occluded(s, &ray));      /* empty */
    pt_scene_destroy(s);
    for (int r = -20; r < 20; r++) CHECK(pt_result_string((pt_result)r)[0] != 0);
    pt_render_destroy(NULL);
    pt_render_cancel(NULL);
    CHECK(pt_render_error(NULL)[0] != 0);
    CHECK(pt_render_work(NULL) < 0 && pt_render_run(NULL) < 0 && pt_render_add_samples(NULL, 1) < 0 && pt_render_merge(NULL, NULL) < 0);
    CHECK(pt_render_pixels(NULL) == NULL);
    CHECK(pt_render_stats(NULL).rays == 0);
}

/* ---- memory ---- */

typedef struct counter { long calls, fail_at, live, bad; size_t bytes; } counter;
typedef struct block { size_t size, align; } block;      /* kept 64 bytes below what the caller gets */
static void *counted_alloc(void *user, size_t size, size_t align) {
    counter *c = (counter *)user;
    char *raw, *p;
    block b;
    if (++c->calls == c->fail_at) return NULL;
    raw = (char *)malloc(size + 192);
    if (!raw) return NULL;
    p = raw + 128 - (uintptr_t)raw % 64;
    if (align > 64 || (align & (align - 1))) c->bad++;
    b.size = size; b.align = (size_t)(p - raw);
    memcpy(p - 64, &b, sizeof b);
    memset(p, 0xa5, size);                               /* nothing comes zeroed */
    c->live++;
    c->bytes += size;
    return p;
}
static void counted_free(void *user, void *ptr, size_t size) {
    counter *c = (counter *)user;
    block b;
    if (!ptr) { c->bad++; return; }
    memcpy(&b, (char *)ptr - 64, sizeof b);
    if (b.size != size) c->bad++;
    c->live--;
    c->bytes -= b.size;
    memset(ptr, 0x5a, b.size);
    free((char *)ptr - b.align);
}
static void box_bounds(void *user, pt_vec3 *lo, pt_vec3 *hi) { bounds_fine(user, lo, hi); lo->y += 3; hi->y += 3; }

/* Everything there is, twenty times over so that all arrays have to grow. */
static pt_result build_all(pt_scene *s, const pt_scene *inner) {
    static const float normals[9] = { 0, 0, 1, 0, 0, 1, 0, 0, 1 }, uvs[6] = { 0, 0, 1, 0, 0, 1 }, texels[12] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1 };
    static const uint32_t indices[3] = { 0, 1, 2 };
    static const pt_shape_vtable user_shape = { box_bounds, never_hit };
    static const pt_bsdf_vtable user_bsdf = { user_eval, density_pdf, user_sample, NULL };
    static const uint16_t words[4] = { 65535, 0, 30000, 5 };
    static const unsigned char bytes[8] = { 255, 0, 128, 64, 5, 99, 1, 254 };
    static const uint32_t ids[2] = { 1, 0 }, there_and_back[6] = { 0, 1, 2, 2, 1, 0 };
    int i;
    for (i = 0; i < 20; i++) {
        pt_texture t = pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 2, .channels = 3, .bits = 32, .pixels = texels });
        pt_material m = pt_add_material(s, &(pt_material_desc){ .color_texture = t });
        pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = { 1, 1, 1 }, .two_sided = i % 2 });
        pt_material user = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_USER, .vtable = &user_bsdf });
        pt_xform x = pti_xform_or_identity(NULL), y;
        x.m[3] = (float)i;
        y = x; y.m[7] = 2;
        if (i == 0) {                                    /* textures of every depth, and several materials a mesh */
            pt_texture w = pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 2, .channels = 1, .bits = 16, .srgb = 1, .pixels = words });
            pt_texture b = pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 1, .channels = 4, .srgb = 1, .pixels = bytes });
            pt_texture view = pt_add_texture(s, &(pt_texture_desc){ .of = b, .channel = 4 });
            pt_texture noise = pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_FBM, .solid = 1 });
            pt_material some[2], mix;
            some[0] = pt_add_material(s, &(pt_material_desc){ .color_texture = b, .roughness_texture = w, .bump_texture = noise, .opacity_texture = view });
            some[1] = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .abbe = 30 });
            mix = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_MIX, .a = some[0], .b = some[1], .mix = 0.5f });
            pt_add_mesh(s, &(pt_mesh_desc){ .positions = tri, .vertex_count = 3, .indices = there_and_back, .index_count = 6,
                .materials = some, .material_count = 2, .material_ids = ids });
            pt_add_sphere(s, pt_v3(0, 4, 1), 0.25f, mix);
            pt_add_quad(s, pt_v3(0, 6, 0), pt_v3(1, 0, 0), pt_v3(0, 0, 1), pt_add_material(s, &(pt_material_desc){ .emission_texture = b }));
        }
        if (i < 3) pt_add_moving_instance(s, inner, &x, &y);
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = tri, .vertex_count = 3, .indices = indices, .index_count = 3, .normals = normals, .uvs = uvs, .material = m });
        pt_add_mesh(s, &(pt_mesh_desc){ .positions = tri, .vertex_count = 3, .borrow = 1, .material = lamp });
        pt_add_sphere(s, pt_v3((float)i, 1, 1), 0.25f, i % 2 ? lamp : user);
        pt_add_quad(s, pt_v3(0, (float)i, 0), pt_v3(1, 0, 0), pt_v3(0, 0, 1), lamp);
        pt_add_box(s, pt_v3(0, 0, 0), pt_v3(1, 1, 1), &x, m);
        pt_add_user_shape(s, &user_shape, NULL, m);
        if (i < 3) pt_add_density(s, &(pt_density_desc){ .sample = density_sample, .pdf = density_pdf, .weight = 0.1f });
        pt_add_instance(s, inner, &x);
        if (i == 0) pt_add_light(s, &(pt_light_desc){ .radiance = sky_radiance });
        pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_SUN, .color = { 1, 1, 1 } });
        pt_add_light(s, &(pt_light_desc){ .kind = i % 2 ? PT_LIGHT_SPOT : PT_LIGHT_POINT, .color = { 1, 1, 1 } });
    }
    return pt_scene_commit(s);
}
static pt_scene *inner_scene(const pt_scene_desc *d) {
    pt_scene *s = pt_scene_create(d);
    pt_material lamp = pt_add_material(s, &(pt_material_desc){ .emission = { 1, 1, 1 } });
    pt_add_box(s, pt_v3(-1, -1, -1), pt_v3(0, 0, 0), NULL, lamp);
    return s;
}
static void every_allocation_fails(void) {
    counter c = { 0, 0, 0, 0, 0 };
    pt_scene *inner = inner_scene(NULL);
    long n, total = 0, no_scene = 0, scene_errors = 0, no_render = 0, fine = 0;
    pt_scene_commit(inner);
    for (n = 1; fine == 0 && n < 10000; n++) {
        pt_scene_desc d = { { counted_alloc, counted_free, NULL }, { hear, NULL } };
        heard h = { 0, PT_OK, "" };
        pt_scene *s;
        pt_render *r;
        d.allocator.user = &c; d.logger.user = &h;
        memset(&c, 0, sizeof c);
        c.fail_at = n;
        test_case("allocation %ld", n);
        s = pt_scene_create(&d);
        if (!s) no_scene++;
        else if (build_all(s, inner) != PT_OK) {
            scene_errors++;
            CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_MEMORY);
            CHECK(strstr(pt_scene_error(s), "out of memory") != NULL);
            CHECK(h.count >= 1 && h.code == PT_ERR_MEMORY);
        } else {
            long before = c.calls;
            r = pt_render_create(s, &(pt_render_desc){ .width = 8, .height = 8, .spp = 1, .threads = 2, .camera = { .eye = { 5, 5, 9 } } });
            if (!r) no_render++;
            else {
                long calls = c.calls;
                CHECK_STR(pt_render_error(r), "");
                CHECK_EQ_INT(pt_render_run(r), PT_OK);
                CHECK(pt_render_pixels(r) != NULL);
                CHECK_EQ_INT(c.calls, calls);            /* rendering never allocates */
                CHECK(calls > before);
                fine++;
            }
            pt_render_destroy(r);
        }
        pt_scene_destroy(s);
        total = c.calls;
        if (!CHECK(c.live == 0 && c.bytes == 0)) break;
        if (!CHECK(c.bad == 0)) break;
    }
    pt_scene_destroy(inner);
    CHECK(no_scene == 2 && scene_errors > 50 && no_render == 5 && fine == 1 && total > 60);
}
/* The tables of albedos, which are made at commit: by themselves, since each takes long. */
typedef struct table_counter { counter all; long tables, fail_at; } table_counter;
static void *table_alloc(void *user, size_t size, size_t align) {
    table_counter *c = (table_counter *)user;
    if (size == sizeof(pti_albedo_list) && ++c->tables == c->fail_at) return NULL;
    return counted_alloc(&c->all, size, align);
}
static void table_free(void *user, void *ptr, size_t size) { counted_free(&((table_counter *)user)->all, ptr, size); }
static void every_table_fails(void) {
    table_counter c;
    long n, failed = 0;
    for (n = 1; n <= 5; n++) {
        pt_scene_desc d = { { table_alloc, table_free, NULL }, { NULL, NULL } };
        pt_scene *s;
        memset(&c, 0, sizeof c);
        d.allocator.user = &c;
        c.fail_at = n;
        s = pt_scene_create(&d);
        pt_add_sphere(s, pt_v3(0, 0, 0), 1, pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 }, .roughness = 1 }));
        pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_CONDUCTOR, .color = { 1, 1, 1 }, .roughness = 0.3f, .roughness_y = 0.5f });
        pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_PRINCIPLED, .coat = 1, .sheen = 1 });
        test_case("table %ld", n);
        if (pt_scene_commit(s) == PT_OK) { CHECK_EQ_INT(c.tables, 4); CHECK_EQ_INT(n, 5); }
        else { CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_MEMORY); failed++; }
        pt_scene_destroy(s);
        CHECK(c.all.live == 0 && c.all.bad == 0);
    }
    CHECK_EQ_INT(failed, 4);
}
/* An inner scene's commit that runs out of memory leaves a scene that can not be placed. */
static void failed_scenes_can_not_be_placed(void) {
    counter c = { 0, 0, 0, 0, 0 };
    long n;
    for (n = 3; n < 12; n++) {
        pt_scene_desc d = { { counted_alloc, counted_free, NULL }, { NULL, NULL } };
        pt_scene *inner, *s = pt_scene_create(NULL);
        int ok;
        d.allocator.user = &c;
        memset(&c, 0, sizeof c);
        c.fail_at = n;
        inner = inner_scene(&d);
        ok = pt_scene_commit(inner) == PT_OK;
        CHECK((pt_add_instance(s, inner, NULL).id != 0) == ok);
        CHECK((pt_scene_commit(s) == PT_OK) == ok);
        pt_scene_destroy(s);
        pt_scene_destroy(inner);
        CHECK(c.live == 0 && c.bad == 0);
    }
}
typedef struct arena { char *memory; size_t used, size; long frees; } arena;
static void *arena_alloc(void *user, size_t size, size_t align) {
    arena *a = (arena *)user;
    size_t at = a->used + (align - ((uintptr_t)a->memory + a->used) % align) % align;
    if (at > a->size || size > a->size - at) return NULL;
    a->used = at + size;
    return a->memory + at;
}
static void arena_free(void *user, void *ptr, size_t size) { (void)ptr; (void)size; ((arena *)user)->frees++; }
static void arena_allocator(void) {
    arena a = { NULL, 0, 1 << 22, 0 };
    pt_scene_desc d = { { arena_alloc, arena_free, NULL }, { NULL, NULL } };
    pt_scene *s, *inner;
    pt_render *r;
    a.memory = (char *)malloc(a.size);
    if (!CHECK(a.memory != NULL)) return;
    d.allocator.user = &a;
    inner = inner_scene(&d);
    CHECK_EQ_INT(pt_scene_commit(inner), PT_OK);
    s = pt_scene_create(&d);
    CHECK_EQ_INT(build_all(s, inner), PT_OK);
    r = pt_render_create(s, &(pt_render_desc){ .width = 16, .height = 16, .spp = 1 });
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    CHECK(pt_render_pixels(r) != NULL && (const char *)pt_render_pixels(r) > a.memory && (const char *)pt_render_pixels(r) < a.memory + a.size);
    free(a.memory);                                      /* all is gone with the arena, nothing needs destroying */
}

/* ---- numbers of all kinds, everywhere ---- */

/* The fields of a description, and what they may be changed to. */
typedef struct field { const char *name; size_t at; int count, kind; } field;      /* kind: 'f'loat, 'i'nt, 't'exture, 'm'aterial */
#define FLOATS(type, name) { #name, offsetof(type, name), (int)(sizeof ((type *)0)->name / sizeof(float)), 'f' }
#define INT(type, name) { #name, offsetof(type, name), 1, 'i' }
#define TEXTURE(type, name) { #name, offsetof(type, name), 1, 't' }
#define NUMBER(name) { #name, offsetof(pt_material_desc, name), 1, 'm' }
#define M(name) FLOATS(pt_material_desc, name)
#define MT(name) TEXTURE(pt_material_desc, name##_texture)
static const field material_fields[] = {
    M(color), M(roughness), M(roughness_y), M(rotation_deg), M(ior), M(abbe), M(eta), M(k), M(metallic), M(transmission), M(specular),
    M(coat), M(coat_roughness), M(coat_ior), M(sheen), M(sheen_roughness), M(sheen_color), M(translucency), M(transparency), M(emission),
    M(mix), M(bump), MT(color), MT(roughness), MT(roughness_y), MT(rotation), MT(metallic), MT(transmission), MT(specular), MT(coat),
    MT(coat_roughness), MT(sheen), MT(sheen_color), MT(translucency), MT(emission), MT(mix), MT(opacity), MT(normal), MT(bump),
    NUMBER(a), NUMBER(b), INT(pt_material_desc, bsdf), INT(pt_material_desc, thin), INT(pt_material_desc, two_sided)
};
#define T(name) FLOATS(pt_texture_desc, name)
#define TI(name) INT(pt_texture_desc, name)
static const field texture_fields[] = {
    T(uv_scale), T(uv_rotate_deg), T(uv_offset), T(frequency), T(color_a), T(color_b), TI(width), TI(height), TI(channels), TI(bits),
    TI(srgb), TI(channel), TI(wrap_u), TI(wrap_v), TI(nearest), TI(pattern), TI(solid), TI(octaves), TEXTURE(pt_texture_desc, of)
};
#define L(name) FLOATS(pt_light_desc, name)
static const field light_fields[] = {
    L(color), L(position), L(direction), L(radius), L(radius_deg), L(cone_deg), L(blend), L(turbidity), L(rotate_deg),
    TEXTURE(pt_light_desc, texture), INT(pt_light_desc, kind)
};
#define C(name) { #name, offsetof(pt_render_desc, camera.name), (int)(sizeof ((pt_render_desc *)0)->camera.name / sizeof(float)), 'f' }
#define CI(name) { #name, offsetof(pt_render_desc, camera.name), 1, 'i' }
static const field camera_fields[] = {
    C(eye), C(target), C(up), C(vfov_deg), C(aperture), C(focus), C(height), C(blade_rotation_deg), C(shift_x), C(shift_y), C(distortion),
    C(aberration), C(vignetting), C(shutter_open), C(shutter_close), C(eye_end), C(target_end), C(up_end), CI(projection), CI(blades),
    CI(moving), INT(pt_render_desc, filter), FLOATS(pt_render_desc, filter_radius), INT(pt_render_desc, sampler),
    FLOATS(pt_render_desc, weights)
};
typedef struct mesh_numbers { float position[12], normal[12], uv[8]; uint32_t index[6], id[2], count, stride; } mesh_numbers;
#define N(name, message, count, kind) { message, offsetof(mesh_numbers, name), count, kind }
static const field mesh_fields[] = {
    N(position, "vertex", 12, 'f'), N(normal, "normal", 12, 'f'), N(uv, "uv", 8, 'f'), N(index, "index", 6, 'i'), N(id, "material id", 2, 'i'),
    N(count, "ind", 1, 'i'), N(stride, "vertex_stride", 1, 'i')
};
#define COUNT(array) ((int)(sizeof array / sizeof array[0]))

static float any_float(pt_rng *rng) {
    static const float values[] = { 0, -0.0f, 1e-45f, 1e-38f, 1e-20f, 1e-6f, 0.001f, 0.3f, 0.5f, 0.999999f, 1, 1.0000001f, 1.5f, 2, 10, 45, 89, 90,
        180, 360, 1000, 36000, 1e6f, 1e11f, 1e12f, 1e13f, 1e30f, 3e38f };
    uint32_t i = pt_rng_u32(rng) % (COUNT(values) + 6);
    if (i == 0) return not_a_number();
    if (i == 1) return infinite();
    if (i < 6) return pt_rng_float(rng);
    return pt_rng_u32(rng) % 4 ? values[i - 6] : -values[i - 6];
}
static int any_int(pt_rng *rng) {
    static const int values[] = { 0, 1, 2, 3, 4, 5, 7, 8, 9, 16, 17, 32, -1, -2, 65537, 0x7fffffff, -0x7fffffff - 1 };
    return values[pt_rng_u32(rng) % (uint32_t)COUNT(values)];
}
/* Changes one to three fields, or parts of them; their names go to names. */
static int spoil(pt_rng *rng, const field *fields, int count, void *desc, const char **names, int textures, int materials) {
    int n = 1 + (int)(pt_rng_u32(rng) % 3), i;
    for (i = 0; i < n; i++) {
        const field *f = fields + pt_rng_u32(rng) % (uint32_t)count;
        char *at = (char *)desc + f->at;
        float x = any_float(rng);
        int k = any_int(rng);
        uint32_t id;
        if (f->kind == 'f') memcpy(at + pt_rng_u32(rng) % (uint32_t)f->count * sizeof x, &x, sizeof x);
        else if (f->kind == 'i') memcpy(at + pt_rng_u32(rng) % (uint32_t)f->count * sizeof k, &k, sizeof k);
        else {
            id = pt_rng_u32(rng) % (uint32_t)((f->kind == 't' ? textures : materials) + 2);
            if (pt_rng_u32(rng) % 50 == 0) id = 0xffffffffu;
            memcpy(at, &id, sizeof id);
        }
        names[i] = f->name;
    }
    return n;
}
static int names_one(const char *error, const char **names, int n) {     /* or says what came of it */
    static const char *const others[] = { "color is too bright", "of the environment must be", "too many lobes" };
    int i;
    for (i = 0; i < COUNT(others); i++) if (strstr(error, others[i])) return 1;
    for (i = 0; i < n; i++) if (strstr(error, names[i])) return 1;
    return 0;
}
/* A scene with a texture of each depth, and patterns; returns how many textures there are. */
static int add_some_textures(pt_scene *s) {
    static const float p32[16] = { 0, 1, 0.5f, 0.2f, 3, 0.1f, 0.7f, 1e-30f, 1, 1, 0, 0, -1, 0.3f, 0.6f, 0.9f };
    static const unsigned char p8[16] = { 255, 0, 128, 64, 5, 99, 1, 254, 200, 180, 77, 66, 55, 250, 0, 0 };
    static const uint16_t p16[16] = { 65535, 0, 300, 20000, 40000, 1, 2, 3, 60000, 9, 8, 7 };
    pt_add_texture(s, &(pt_texture_desc){ .width = 2, .height = 2, .channels = 4, .pixels = p8, .srgb = 1 });
    pt_add_texture(s, &(pt_texture_desc){ .width = 4, .height = 2, .channels = 2, .bits = 16, .pixels = p16 });
    pt_add_texture(s, &(pt_texture_desc){ .width = 5, .height = 1, .channels = 3, .bits = 32, .pixels = p32 });
    pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_FBM, .solid = 1 });
    return (int)pt_add_texture(s, &(pt_texture_desc){ .pattern = PT_PATTERN_CHECKER }).id;
}
static pt_texture_desc any_picture(pt_rng *rng) {
    static float pixels[1024];
    pt_texture_desc d;
    memset(&d, 0, sizeof d);
    if (pt_rng_u32(rng) % 2) { d.pattern = (pt_pattern)(1 + pt_rng_u32(rng) % 3); return d; }
    d.pixels = pixels; d.width = 3; d.height = 2; d.channels = 1 + (int)(pt_rng_u32(rng) % 4); d.bits = 8 << pt_rng_u32(rng) % 3;
    return d;
}
/* Each call is refused, naming what was wrong, or taken; and what is taken is drawn without a single sample that is unfit. */
static void draw_it(pt_scene *s, const pt_material *m, int count, pt_rng *rng, long *drawn, long *refused) {
    const char *names[3];
    pt_render_desc d;
    pt_render *r;
    const float *q;
    int i, bad = 0, k;
    memset(&d, 0, sizeof d);
    for (i = 0; i < count; i++) pt_add_sphere(s, pt_v3((float)i - 1, 0.5f, 0.3f), 0.5f, m[i]);
    if (!CHECK_EQ_INT(pt_scene_commit(s), PT_OK)) { FAIL("%s", pt_scene_error(s)); return; }
    d.width = 8; d.height = 6; d.spp = 2; d.threads = 1; d.max_depth = 8; d.camera.eye = pt_v3(0.1f, 2, 3);
    k = pt_rng_u32(rng) % 2 ? spoil(rng, camera_fields, COUNT(camera_fields), &d, names, 0, 0) : 0;
    r = pt_render_create(s, &d);
    if (pt_render_error(r)[0]) {
        ++*refused;
        if (!names_one(pt_render_error(r), names, k)) FAIL("\"%s\" names neither of %d fields, %s first", pt_render_error(r), k, names[0]);
    } else {
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        if (!CHECK_EQ_INT(pt_render_stats(r).discarded, 0)) for (i = 0; i < k; i++) FAIL("camera: %s", names[i]);
        q = pt_render_pixels(r);
        for (i = 0; i < 8 * 6 * 3; i++) bad += !(q && pti_finite(q[i]) && fabsf(q[i]) <= 1e12f);
        CHECK_EQ_INT(bad, 0);
        ++*drawn;
    }
    pt_render_destroy(r);
}
/* Was the last call refused? Then the refusal is checked, and forgotten. */
static int was_refused(pt_scene *s, const char **names, int n, long *refused) {
    if (!pt_scene_error(s)[0]) return 0;
    if (!names_one(pt_scene_error(s), names, n)) FAIL("\"%s\" names none of %d fields, %s first", pt_scene_error(s), n, names[0]);
    CHECK_EQ_INT(s->error.code, PT_ERR_ARG);
    s->error.code = PT_OK; s->error.text[0] = 0;
    ++*refused;
    return 1;
}
static pt_material_desc any_material(pt_rng *rng, int materials) {
    pt_material_desc m;
    memset(&m, 0, sizeof m);
    m.bsdf = (pt_bsdf)(pt_rng_u32(rng) % PT_BSDF_USER);
    m.color = pt_v3(pt_rng_float(rng), 0.5f, 1);
    if (pt_rng_u32(rng) % 2) m.metallic = m.transmission = m.coat = m.sheen = m.mix = m.transparency = 0.3f;
    m.roughness = pt_rng_u32(rng) % 2 ? 0.3f : 0;
    m.a.id = pt_rng_u32(rng) % (uint32_t)(materials + 1);
    m.b.id = pt_rng_u32(rng) % (uint32_t)(materials + 1);
    return m;
}
static void numbers_of_all_kinds(void) {
    pt_rng rng;
    long trial, drawn = 0, refused = 0;
    pt_rng_seed(&rng, 11, 7);
    for (trial = 0; trial < 1500; trial++) {
        pt_scene *s = pt_scene_create(NULL);
        int textures = add_some_textures(s), materials = 0, n, done;
        const char *names[3];
        pt_material taken[3];
        test_case("trial %ld", trial);
        for (done = 0; done < 2;) {
            pt_texture_desc t = any_picture(&rng);
            n = spoil(&rng, texture_fields, COUNT(texture_fields), &t, names, textures, 0);
            textures += pt_add_texture(s, &t).id != 0;
            done += !was_refused(s, names, n, &refused);
        }
        while (materials < 3) {
            pt_material_desc m = any_material(&rng, materials);
            n = spoil(&rng, material_fields, COUNT(material_fields), &m, names, textures, materials);
            if (m.bsdf == PT_BSDF_USER) continue;
            if (pti_largest(m.emission) > 1e6f && pti_largest(m.emission) <= 1e12f) continue;       /* textures might make it too bright */
            taken[materials] = pt_add_material(s, &m);
            if (!was_refused(s, names, n, &refused)) materials++;
        }
        for (done = 0; done < 1;) {
            pt_light_desc l;
            memset(&l, 0, sizeof l);
            l.kind = (pt_light_kind)(pt_rng_u32(&rng) % PT_LIGHT_SKY);
            l.color = pt_v3(1, 2, 3); l.position = pt_v3(0, 3, 0);
            n = spoil(&rng, light_fields, COUNT(light_fields), &l, names, textures, 0);
            if (l.kind == PT_LIGHT_SKY) continue;        /* takes long */
            pt_add_light(s, &l);
            done += !was_refused(s, names, n, &refused);
        }
        for (done = 0; done < 1;) {
            mesh_numbers m = { { -1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0.5f, -1 }, { 0, 1, 0, 0.5f, 1, 0, 0, 0, 0, 0, 1, -1 },
                { 0, 0, 3, 0, 3, 2, 0, 2 }, { 0, 1, 2, 0, 2, 3 }, { 0, 2 }, 6, 12 };
            n = spoil(&rng, mesh_fields, COUNT(mesh_fields), &m, names, 0, 0);
            if ((m.count > 6 && m.count % 3 == 0) || (m.stride > 12 && m.stride % 4 == 0)) continue;    /* would read on */
            pt_add_mesh(s, &(pt_mesh_desc){ .positions = m.position, .vertex_count = 4, .vertex_stride = m.stride, .normals = m.normal, .uvs = m.uv,
                .indices = m.index, .index_count = m.count, .materials = taken, .material_count = 3, .material_ids = m.id });
            done += !was_refused(s, names, n, &refused);
        }
        if (trial % 75 == 0) draw_it(s, taken, 3, &rng, &drawn, &refused);
        pt_scene_destroy(s);
    }
    CHECK(drawn > 0 && refused > 100);
}

/* ---- scenes that are fine ---- */

static void empty_scene(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_render *r;
    const float *p;
    int i;
    CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
    r = pt_render_create(s, &(pt_render_desc){ .width = 5, .height = 3, .spp = 2 });
    CHECK_EQ_INT(pt_render_run(r), PT_OK);
    p = pt_render_pixels(r);
    for (i = 0; i < 45; i++) CHECK(p && p[i] == 0);
    CHECK_EQ_INT(pt_render_stats(r).paths, 30);
    pt_render_destroy(r);
    pt_scene_destroy(s);
    s = pt_scene_create(NULL);                           /* with a sky, a mesh of no triangles, an instance of nothing */
    {
        pt_scene *nothing = pt_scene_create(NULL), *t;
        pt_ray ray = { { 0, 0, 5 }, { 0, 0, -1 }, 0, 0, 0 };
        pt_scene_commit(nothing);
        pt_add_light(s, &(pt_light_desc){ .color = { 1, 2, 3 } });
        CHECK(pt_add_mesh(s, &(pt_mesh_desc){ .vertex_count = 0 }).id != 0);
        CHECK(pt_add_instance(s, nothing, NULL).id != 0);
        CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
        CHECK(!pt_occluded(s, &ray));
        r = pt_render_create(s, &(pt_render_desc){ .width = 5, .height = 3, .spp = 2 });
        CHECK_EQ_INT(pt_render_run(r), PT_OK);
        p = pt_render_pixels(r);
        for (i = 0; i < 45; i++) CHECK(p && p[i] == (float)(1 + i % 3));
        pt_render_destroy(r);
        t = pt_scene_create(NULL);                       /* an instance of it has no sky */
        pt_add_instance(t, nothing, NULL);
        CHECK_EQ_INT(pt_scene_commit(t), PT_OK);
        CHECK(!pt_occluded(t, &ray));
        pt_scene_destroy(t);
        pt_scene_destroy(nothing);
    }
    pt_scene_destroy(s);
}
static void borrowed_meshes(void) {
    enum { STRIDE = 7 };
    float padded[3 * STRIDE], tight[9] = { -1, -1, 0, 1, -1, 0, 0, 1, 0 }, normals[9] = { 0, 0, 1, 0, 0, 1, 0, 0, 1 }, uvs[6] = { 0, 0, 1, 0, 0, 1 };
    pt_scene *s[3];
    pt_vertex x[3];
    pt_ray ray = { { 0.1f, 0.2f, 5 }, { 0, 0, -1 }, 0, 0, 0 };
    int i, k;
    for (i = 0; i < 3 * STRIDE; i++) padded[i] = 1e30f;  /* never looked at */
    for (i = 0; i < 3; i++) for (k = 0; k < 3; k++) padded[i * STRIDE + k] = tight[3 * i + k];
    for (i = 0; i < 3; i++) {
        pt_mesh_desc d;
        memset(&d, 0, sizeof d);
        d.positions = i ? padded : tight; d.vertex_stride = i ? STRIDE * sizeof(float) : 0; d.borrow = i == 2;
        d.vertex_count = 3; d.normals = normals; d.uvs = uvs;
        s[i] = pt_scene_create(NULL);
        pt_add_mesh(s[i], &d);
        CHECK_EQ_INT(pt_scene_commit(s[i]), PT_OK);
        CHECK(pt_intersect(s[i], &ray, &x[i]));
        CHECK(!memcmp(&x[i], &x[0], sizeof x[0]));
    }
    memset(padded, 0, sizeof padded);                    /* what was copied does not care */
    CHECK(pt_intersect(s[1], &ray, &x[1]) && !memcmp(&x[1], &x[0], sizeof x[0]));
    for (i = 0; i < 3; i++) pt_scene_destroy(s[i]);
}
static void boxes_face_outwards(void) {
    pt_rng rng;
    int i, k;
    pt_rng_seed(&rng, 3, 3);
    for (i = 0; i < 200; i++) {
        pt_xform x;
        pt_scene *s = pt_scene_create(NULL);
        pt_vec3 center;
        for (k = 0; k < 12; k++) x.m[k] = 2 * pt_rng_float(&rng) - 1;
        if (fabs(pti_xform_det(&x)) < 0.05) { pt_scene_destroy(s); continue; }
        pt_add_box(s, pt_v3(-1, -2, -3), pt_v3(2, 3, 4), i ? &x : NULL, none_material);
        CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
        x = i ? x : pti_xform_or_identity(NULL);
        center = pti_xform_point(&x, pt_v3(0.5f, 0.5f, 0.5f));
        for (k = 0; k < 50; k++) {
            pt_vec3 d = pti_sample_sphere(pt_rng_float(&rng), pt_rng_float(&rng));
            pt_ray ray = { center, d, 0, 0, 0 };
            pt_vertex v;
            if (!CHECK(pt_intersect(s, &ray, &v))) break;
            CHECK(pti_dot(v.ng, d) > 0);                 /* seen from inside, normals look away */
            CHECK(v.u >= 0 && v.u <= 1 && v.v >= 0 && v.v <= 1);
        }
        pt_scene_destroy(s);
    }
}

void test_scene(void) {
    RUN(bad_arguments);
    RUN(bad_numbers_of_materials);
    RUN(committed_scenes_refuse);
    RUN(null_handles);
    RUN(every_allocation_fails);
    RUN(every_table_fails);
    RUN(failed_scenes_can_not_be_placed);
    RUN(numbers_of_all_kinds);
    RUN(arena_allocator);
    RUN(empty_scene);
    RUN(borrowed_meshes);
    RUN(boxes_face_outwards);
}
