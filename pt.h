/* pt.h - v0.1.0 - a path tracer in one C99 header.  MIT licence, at the end of the file.

   HOW TO USE
     In one source file, and only there:      Everywhere else:
         #define PT_IMPLEMENTATION                #include "pt.h"
         #include "pt.h"
     Then build a scene, commit it, render it, and look:
         pt_scene *s = pt_scene_create(NULL);
         pt_material white = pt_add_material(s, &(pt_material_desc){ .color = {.8f, .8f, .8f} });
         pt_add_sphere(s, pt_v3(0, 0, 0), 1, white);
         pt_add_light(s, &(pt_light_desc){ .kind = PT_LIGHT_ENVIRONMENT, .color = {1, 1, 1} });
         pt_scene_commit(s);
         pt_render *r = pt_render_create(s, &(pt_render_desc){ .width = 512, .height = 512, .spp = 32,
             .camera = { .eye = {0, 1, 5}, .target = {0, 0, 0} } });
         if (pt_render_run(r) == PT_OK) pt_write_png("sphere.png", pt_render_pixels(r), 512, 512, NULL);
         pt_render_destroy(r);
         pt_scene_destroy(s);
     cc -O2 main.c -lm -lpthread.  No more flags are needed for speed: the AVX2 code is chosen at run time.

   OPTIONS  (define before the #include that has PT_IMPLEMENTATION)
     PT_STATIC          every function static: the whole path tracer inside one source file
     PT_NO_THREADS      no pthreads: pt_render_run renders on the calling thread, and there is no clock
     PT_NO_STDIO        no files: the functions that take a path are left out, their memory twins stay
     PT_NO_SIMD         plain C only
     PT_ALLOW_FAST_MATH compile under -ffast-math or x87 all the same, and give up equal bits

   WHAT HOLDS EVERYWHERE
     Zero in a desc means the default that stands beside it. Units are metres, seconds, degrees where a name ends in
     _deg, and radiance in W/(sr m^2). Colours are linear RGB with Rec. 709 primaries. Coordinates are right-handed and
     +y is up. Every handle that a failed call returned may be passed on: the scene keeps the first error and says it
     at commit. Nothing prints, exits or keeps a global; two scenes never share anything, and any number of threads may
     read one committed scene.

   The same scene, seed and version give the same bits: for any number of threads, any tile size, any compiler flag
   (but -ffast-math), any instruction set, on any machine with IEEE floats.

   TABLE OF CONTENTS  (search for >>name)
     the public face, then:
     >>platform   what differs between machines: SIMD, threads, memory, error texts, the floating-point mode
     >>math       vectors, transforms, our own sin cos exp log pow atan2 acos
     >>random     PCG32, Owen-scrambled Sobol, stratified: numbers as a function of (seed, pixel, sample, dimension)
     >>warp       from the unit square to disks, hemispheres, cones, triangles, rectangles, tables; each with its density
     >>spectrum   the colours of single wavelengths
     >>shape      triangles, spheres, instances, users' shapes: bounds and intersection
     >>bvh        the binned SAH build, spatial splits, the collapse into eight-wide nodes, refit
     >>kernel     ray against boxes and triangles for each instruction set; the traversal
     >>texture    pictures, patterns and callbacks
     >>medium     phase functions, free flights through volumes, the glow round lamps in fog
     >>microfacet Fresnel, GGX, fuzz, and how much light rough surfaces send on
     >>measured   tables of measured BRDFs, and the density fitted to each
     >>bsdf       lobes: diffuse, metal, glass, panes, coats, users' BSDFs
     >>material   from numbers and textures to lobes
     >>light      emitters by solid angle, the light tree, suns, the sky, environments
     >>scene      adding, checking, committing; fires and the aureole of a sun, as densities
     >>guide      a density that learns where light comes from
     >>mixture    the one density that a path draws its next direction from
     >>path       the estimator
     >>camera     projections, the lens, the shutter
     >>film       exact sums, filters
     >>render     tiles, threads, progress
     >>image      PNG, PPM, PFM, Radiance HDR
     >>merl       files of measured BRDFs
     >>grid       files of densities
     >>mesh       Wavefront OBJ and MTL, PLY; smooth normals
     >>license */
#ifndef PT_PATHTRACER_H_INCLUDED /* not PT_H: another well-known library on embedded systems ships a pt.h too */
#define PT_PATHTRACER_H_INCLUDED

#define PT_VERSION_MAJOR 0
#define PT_VERSION_MINOR 1
#define PT_VERSION_PATCH 0

#include <stddef.h>
#include <stdint.h>

#ifdef PT_STATIC
#if defined(__GNUC__)
#define PT_DEF __attribute__((unused)) static
#else
#define PT_DEF static
#endif
#elif !defined(PT_DEF)
#define PT_DEF extern
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* ---- basic types -------------------------------------------------------------------------------------- */

typedef struct pt_vec3  { float x, y, z; } pt_vec3;       /* points, directions, and linear RGB */
typedef struct pt_xform { float m[12]; } pt_xform;        /* affine, 3 rows of 4: x' = m0 x + m1 y + m2 z + m3; all zero
                                                             means identity */
typedef struct pt_ray {
    pt_vec3 org, dir;                                     /* dir of any length but zero; t counts in its units */
    float tmin, tmax, time;                               /* hits have tmin < t < tmax; tmax 0 = no limit */
} pt_ray;

typedef struct pt_scene  pt_scene;                        /* opaque; read-only once committed */
typedef struct pt_render pt_render;                       /* opaque; one image in progress */

typedef struct pt_material { uint32_t id; } pt_material;  /* typed handles: 0 is "none" */
typedef struct pt_texture  { uint32_t id; } pt_texture;
typedef struct pt_measured { uint32_t id; } pt_measured;
typedef struct pt_medium   { uint32_t id; } pt_medium;
typedef struct pt_volume   { uint32_t id; } pt_volume;
typedef struct pt_shape    { uint32_t id; } pt_shape;
typedef struct pt_light    { uint32_t id; } pt_light;
typedef struct pt_density  { uint32_t id; } pt_density;

typedef enum pt_result {
    PT_OK = 0, PT_MORE = 1, PT_CANCELLED = 2,             /* >= 0: no error */
    PT_ERR_ARG = -1, PT_ERR_STATE = -2, PT_ERR_MEMORY = -3, PT_ERR_IO = -4, PT_ERR_FORMAT = -5
} pt_result;
PT_DEF const char *pt_result_string(pt_result r);         /* "ok", "out of memory", ...; never NULL */

/* ---- host services: every member optional, zero = built-in -------------------------------------------- */

/* Either both functions or none. alloc returns memory aligned to align (a power of two up to 64), or NULL; free gets the
   size that alloc got. Called from the thread that calls the header, never while a tile is rendered. */
typedef struct pt_allocator {
    void *(*alloc)(void *user, size_t size, size_t align);
    void  (*free)(void *user, void *ptr, size_t size);
    void  *user;
} pt_allocator;
/* Hears each error once, with the text that pt_scene_error or pt_render_error returns. */
typedef struct pt_logger { void (*log)(void *user, pt_result code, const char *message); void *user; } pt_logger;

/* ---- scene: errors are sticky; every call accepts what a failed call returned; check once, at commit --- */

/* How a path chooses among many lamps. The two others are for comparison. */
typedef enum pt_light_choice {
    PT_CHOOSE_TREE,                                       /* by what each is likely to send to where the path stands */
    PT_CHOOSE_POWER,                                      /* by power alone */
    PT_CHOOSE_UNIFORM                                     /* all alike */
} pt_light_choice;
/* How much care the trees that rays go through are built with. Pictures are the same, to the bit. */
typedef enum pt_quality {
    PT_QUALITY_DEFAULT,                                   /* triangles that stick out are cut in pieces, up to 1/8 more */
    PT_QUALITY_FAST,                                      /* for scenes that are built again and again */
    PT_QUALITY_BEST                                       /* for long renders: where many do, space is split, up to 1/2 more */
} pt_quality;
typedef struct pt_scene_desc {
    pt_allocator allocator;
    pt_logger logger;
    pt_light_choice choose;
    int threads;                                          /* of pt_scene_commit, up to 4096; 0 = one a core */
    pt_quality quality;
} pt_scene_desc;

PT_DEF pt_scene   *pt_scene_create(const pt_scene_desc *desc);   /* NULL desc = defaults; NULL when out of memory */
PT_DEF void        pt_scene_destroy(pt_scene *s);                /* NULL is fine. Renders and instances of s go first */
PT_DEF pt_result   pt_scene_commit(pt_scene *s);                 /* builds the trees; the scene is read-only from then on */
/* After the positions or normals of borrowed meshes have changed (not how many, nor the indices), or a scene that instances
   show was refitted: makes the boxes and lamps of the trees anew and leaves their shape, which takes about a tenth of the time (a
   fifth where there are many instances; but all of it where a triangle had no area at commit, or a placed scene nothing in it).
   Rays are the slower the farther things have moved from their old neighbours; then commit a new scene. Nobody may be reading the
   scene; renders of it hold old samples, so make new ones. PT_ERR_STATE before commit, where there are media, and where a placed
   scene could not be refitted; PT_ERR_ARG where a vertex is not finite; as everywhere, the first error stays, and such a scene is
   good for nothing but what it was before. */
PT_DEF pt_result   pt_scene_refit(pt_scene *s);
PT_DEF const char *pt_scene_error(const pt_scene *s);            /* first error, in words, or "" */

/* Where a path stands: a point on a surface, or at a particle of a medium, where all normals are zero; all that a callback may
   look at. */
typedef struct pt_vertex {
    pt_vec3 p, wo;                                        /* position; unit direction back along the path */
    pt_vec3 ng, ns, tangent;                              /* unit: geometric normal, on the side from which the winding is
                                                             counter-clockwise; shading normal, on the same side as ng, not
                                                             perpendicular to wo; along growing u, perpendicular to ns */
    pt_vec3 dpdu, dpdv;                                   /* how p moves with u and v; zero where nothing is known */
    float u, v, t, time;                                  /* texture coordinates; distance in the ray's units; ray time */
    float wavelength;                                     /* nm, of a path that has met dispersion; 0 = all colours */
    uint32_t prim;                                        /* triangle within its mesh; 0 elsewhere */
    pt_shape shape, instance;                             /* instance: none outside one */
    pt_material material;                                 /* of the scene that owns the shape */
    pt_volume volume;                                     /* at a particle: which one it is in, of the instance's scene, if
                                                             there is one; those that materials fill come after those of
                                                             pt_add_volume. None on surfaces */
    float error;                                          /* bound on p's distance from the surface; a next ray starts
                                                             that much above it */
} pt_vertex;

/* A density over directions: what the path tracer's mixture is made of. BSDF lobes, lights, the environment and whatever
   a user adds are all this one thing. sample returns 0 if it can draw none (that share of the mixture is then lost,
   not biased); pdf returns what sample draws with, per steradian, for every unit wi: 0 where sample never goes, and the
   integral over all wi is how often sample does not return 0. Mirrors and clear glass have no use for densities and do not
   ask. A density that has nothing to offer at some vertices says so in importance, and its share there goes to the
   others. Called from all render threads. */
typedef struct pt_density_desc {
    float weight;                                         /* share in every mixture, up to 0.95; 0 = 0.25. What the users'
                                                             densities leave is for the built-in parts: where they ask for
                                                             more than 0.95 together, each gets less in proportion */
    int   (*sample)(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi);
    float (*pdf)(void *user, const pt_vertex *x, pt_vec3 wi);
    void  *user;
    float (*importance)(void *user, const pt_vertex *x);  /* how much of weight it wants at x, 0 to 1: the same whenever
                                                             it is asked. NULL = all */
} pt_density_desc;
PT_DEF pt_density pt_add_density(pt_scene *s, const pt_density_desc *d);

/* A texture: pixels, the pixels of an earlier one, a pattern, or a callback: one of the four. Where on it a point lies:
   (s, t) = uv_offset + R uv_scale (u, 1 - v), R = [cos sin; -sin cos] of uv_rotate_deg: the order, the signs and the axes
   (from the top left corner, t down) of glTF's KHR_texture_transform. v = 0 is the bottom. (An environment has its own
   way to look at pixels: it minds srgb and channel alone.) */
typedef enum pt_wrap { PT_WRAP_REPEAT, PT_WRAP_CLAMP, PT_WRAP_MIRROR } pt_wrap;
typedef enum pt_pattern { PT_PATTERN_NONE, PT_PATTERN_CHECKER, PT_PATTERN_NOISE, PT_PATTERN_FBM } pt_pattern;
typedef struct pt_texture_desc {
    const void *pixels;                                   /* top row first, tight, copied; floats must be finite */
    int width, height, channels;                          /* up to 65536; 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA */
    int bits;                                             /* a channel: 8 (0 = 8), 16 (uint16_t), 32 (float) */
    pt_texture of;                                        /* instead of pixels and the three above: shares another's */
    int srgb;                                             /* 8 and 16 bits: 1 = sRGB-encoded, but alpha; 0 = linear */
    int channel;                                          /* 0 = all; 1 to 4 = this one alone, as grey */
    pt_wrap wrap_u, wrap_v;                               /* beyond the border; of s and t */
    int nearest;                                          /* 1 = the nearest pixel, 0 = bilinear */
    float uv_scale[2], uv_rotate_deg, uv_offset[2];       /* uv_scale: 0 = 1; -36000 to 36000 degrees */
    pt_pattern pattern;                                   /* over (s, t), in cells of side 1 */
    int solid;                                            /* 1 = over the position in world space instead: */
    float frequency;                                      /* cells a metre; 0 = 1 */
    int octaves;                                          /* of PT_PATTERN_FBM, up to 16; 0 = 5 */
    pt_vec3 color_a, color_b;                             /* where the pattern is 0 and 1; both zero = black and white */
    pt_vec3 (*eval)(void *user, const pt_vertex *x);      /* the callback. Called from all render threads */
    void *user;
} pt_texture_desc;
PT_DEF pt_texture pt_add_texture(pt_scene *s, const pt_texture_desc *d);

/* A measured BRDF: f per steradian, as a table over the angles of the half vector h = (wo + wi) / |wo + wi| and of wi seen from
   it (Rusinkiewicz 1998): theta_h from the normal to h; theta_d from h to wi; phi_d of wi about h, 0 where wi leans away from
   the normal. Surfaces that look the same however they are turned need no more angles, and phi_d only up to 180 degrees, as
   light goes both ways alike. Linear between the middles of cells, level beyond the outer ones. Energy is the table's own:
   some measured ones send on more than they get at grazing angles. Adding one takes a tenth of a second. */
typedef struct pt_measured_desc {
    const float *values;                                  /* RGB of cell (h, d, p) at values + 3 ((h cells_d + d) cells_p + p);
                                                             copied; finite, up to 1e12; below 0 = not measured: black */
    int cells_h, cells_d, cells_p;                        /* 1 to 512; 0 = 90, 90, 180. The middles are at theta_h =
                                                             90 ((h + 1/2) / cells_h)^2 degrees, theta_d =
                                                             90 (d + 1/2) / cells_d, phi_d = 180 (p + 1/2) / cells_p.
                                                             Cells beyond the horizon should go on as before it */
} pt_measured_desc;
PT_DEF pt_measured pt_add_measured(pt_scene *s, const pt_measured_desc *d);

/* A medium: what fills a volume. Rays are absorbed and scattered with the probabilities sigma_a and sigma_s a metre and channel,
   times a density where there is one. A medium that scatters nothing only darkens, without noise if it is constant. */
typedef enum pt_phase {                                   /* whereto particles scatter */
    PT_PHASE_HENYEY_GREENSTEIN,                           /* g */
    PT_PHASE_RAYLEIGH,                                    /* air */
    PT_PHASE_TWO_LOBES,                                   /* Henyey and Greenstein's twice: (1 - mix) of g, mix of g2 */
    PT_PHASE_DRAINE,                                      /* g, alpha: dust (Draine 2003) */
    PT_PHASE_DROPLETS,                                    /* droplet_um: fog and cloud (Jendersie and d'Eon 2023) */
    PT_PHASE_USER                                         /* phase_pdf, phase_sample */
} pt_phase;
typedef enum pt_tracking {                                /* how a hit is found */
    PT_TRACK_EXACT,
    PT_TRACK_MARCH,                                       /* for teaching: a coin a step, which comes up with sigma_t step. */
    PT_TRACK_MARCH_CDF                                    /* the same by one number: P += (1 - P) sigma_t step, until above it.
                                                             Both are biased: of the light through optical depth 1 in ten
                                                             steps, 5.2 % are missing, of that through 3, 43 % */
} pt_tracking;
typedef struct pt_medium_desc {
    pt_vec3 sigma_a, sigma_s;                             /* 1/m, 0 to 1e12. Paths start a few millionths of the coordinates'
                                                             size off a wall; where a mean free path is not far longer, light
                                                             is lost there: at 10 m from the origin, 2 % of what a glass ball
                                                             sends back whose free paths are 0.1 mm */
    pt_vec3 emission;                                     /* radiance a metre, 0 to 1e12 */
    pt_phase phase;
    float g, g2;                                          /* mean cosines, -0.99 to 0.99: 0 = all round alike, above: forwards */
    float mix, alpha;                                     /* 0 to 1; 0 to 1e4 */
    float droplet_um;                                     /* diameter, 5 to 50 micrometres; 0 = 20 */
    float (*phase_pdf)(void *user, const pt_vertex *x, pt_vec3 wi);        /* per steradian, its integral 1; it is the phase
                                                             function, and what phase_sample draws with, which may not
                                                             fail. x->wo points back along the path */
    int   (*phase_sample)(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi);
    const float *grid;                                    /* densities, 0 to 1e12, of the voxel (x, y, z) at
                                                             grid + (z ny + y) nx + x, over the box that just holds the
                                                             volume's bounds: turned with it, if that was a turned
                                                             pt_add_box, placed, if an instance */
    int nx, ny, nz;                                       /* voxels, 1 to 4096 each */
    int grid_channels;                                    /* 0 = 1; 3 = densities for red, green and blue: three grids, one after
                                                             the other in memory. They also multiply emission */
    int nearest;                                          /* 1 = as voxels, 0 = trilinear between their middles */
    int borrow;                                           /* the caller keeps the grid alive, and as it is; it is not copied */
    float (*density)(void *user, pt_vec3 p);              /* instead: a function of the place in the scene that the volume
                                                             was added to; if its bounds are an instance, in the scene
                                                             that this places. Called from all render threads */
    float density_max;                                    /* which is never above this, 0 to 1e12. Where it is, the sample is
                                                             discarded and counted: see pt_stats */
    float (*density_bound)(void *user, pt_vec3 lo, pt_vec3 hi);    /* NULL, or the most that density may be in a box, 0 to
                                                             density_max; asked at commit, for 32 x 32 x 32 boxes. Where
                                                             there is little, paths then go fast; where it is 0, density
                                                             is not asked at all, and a wrong 0 is not noticed */
    pt_vec3 (*glow)(void *user, pt_vec3 p);               /* NULL, or multiplies emission; p as density's; NaN and what is below
                                                             0 is 0 */
    pt_tracking tracking;
    float step;                                           /* of marches: metres, above 0. Where it is longer than a mean free
                                                             path, each is hit: use a third of one, or less */
    void *user;
} pt_medium_desc;
PT_DEF pt_medium pt_add_medium(pt_scene *s, const pt_medium_desc *d);

typedef enum pt_bsdf {
    PT_BSDF_DIFFUSE, PT_BSDF_CONDUCTOR, PT_BSDF_DIELECTRIC, PT_BSDF_PRINCIPLED, PT_BSDF_MEASURED, PT_BSDF_MIX, PT_BSDF_NONE,
    PT_BSDF_USER
} pt_bsdf;

/* What a BSDF says when asked for a direction. delta: wi is the only direction of its lobe (a mirror's), pdf is the
   probability of having chosen that lobe, and f the lobe's whole weight. Else pdf and f are ignored: the mixture asks
   eval and pdf itself, since it may draw directions from elsewhere too. */
typedef struct pt_scatter { pt_vec3 wi, f; float pdf; int delta; } pt_scatter;

/* A BSDF of the user's own: a lobe like the built-in ones, which may be mixed with others, be seen through, emit. Directions
   are unit vectors that point away from the surface. Called from all render threads. */
typedef struct pt_bsdf_vtable {
    pt_vec3 (*eval)(void *user, const pt_vertex *x, pt_vec3 wi);        /* f(wo, wi) |cos|, without delta lobes */
    float   (*pdf)(void *user, const pt_vertex *x, pt_vec3 wi);         /* per steradian, without delta lobes */
    int     (*sample)(void *user, const pt_vertex *x, const float u[3], pt_scatter *out);    /* 0: absorbed */
    float   (*delta)(void *user, const pt_vertex *x);                   /* probability that sample yields a delta; the pdf
                                                                           integrates to the rest. NULL = never */
} pt_bsdf_vtable;
/* A material. Textures multiply the number beside them; where that is zero, they stand alone. A texture of a number is read
   as grey: its red channel, or the one that its desc picks. */
typedef struct pt_material_desc {
    pt_bsdf    bsdf;
    pt_vec3    color;                                     /* diffuse, principled: albedo (zero = black, which also tints
                                                             transmission). Conductor: reflectance at normal
                                                             incidence. Dielectric, measured: tint, zero = white. In
                                                             [0,1] */
    float      roughness, roughness_y;                    /* 0 smooth to 1; alpha of GGX is its square. Along the tangent, and
                                                             across it: 0 = as along it (where the two differ, textures
                                                             on them are slow). Diffuse: EON's, 0 = Lambert */
    float      rotation_deg;                              /* turns the tangent, counter-clockwise seen from outside; 1 in its
                                                             texture is 360 degrees */
    float      ior;                                       /* inside over outside, 0.01 to 100; 0 = 1.5. Tables for each ior of
                                                             rough glass or principled materials take the commit a tenth
                                                             of a second; so does each roughness_y of its own */
    float      abbe;                                      /* dispersion: Abbe's number; 0 = none */
    pt_vec3    eta, k;                                    /* conductor: complex index eta + i k a channel; both zero = by
                                                             color */
    float      metallic, transmission;                    /* principled: 0 to 1, like all that follow */
    float      specular;                                  /* principled: scales the gloss of what is no metal; 0 = 1. For
                                                             none, set ior to 1 */
    float      coat, coat_roughness, coat_ior;            /* principled: clear coat; coat_ior 0 = 1.5 */
    float      sheen, sheen_roughness;                    /* principled: fuzz; sheen_roughness 0 = 0.5, at least 0.28 */
    pt_vec3    sheen_color;                               /* zero = white */
    float      translucency;                              /* diffuse, principled: share of diffuse light that goes through */
    float      transparency;                              /* passes straight through; 0 = opaque */
    int        thin;                                      /* dielectric, principled: a wall without an inside */
    pt_vec3    emission;                                  /* radiance. Lamps a millionth as wide as they are far lose percents
                                                             of their light, and more the farther */
    int        two_sided;                                 /* emit to both sides; 0 = to the side of the normal */
    pt_measured measured;                                 /* PT_BSDF_MEASURED */
    pt_medium  inside;                                    /* fills the shapes that bear the material, as pt_add_volume does: a
                                                             mesh of several materials whole, so they cannot differ in it;
                                                             of PT_BSDF_MIX its own, not that of its parts */
    pt_material a, b;                                     /* PT_BSDF_MIX: (1 - mix) a + mix b. Glass with glass of another
                                                             ior gains or loses light */
    float      mix;
    float      bump;                                      /* metres from black to white of bump_texture; 0 = 0.01 */
    pt_texture color_texture, roughness_texture, roughness_y_texture, rotation_texture, metallic_texture,
               transmission_texture, specular_texture, coat_texture, coat_roughness_texture, sheen_texture,
               sheen_color_texture, translucency_texture, emission_texture, mix_texture;
    pt_texture opacity_texture;                           /* multiplies 1 - transparency: alpha if it has one, or grey */
    pt_texture normal_texture;                            /* linear; (r, g, b) 2 - 1 is the normal in tangent space, +y up */
    pt_texture bump_texture;                              /* height */
    void     (*shade)(void *user, const pt_vertex *x, struct pt_material_desc *m);   /* after the textures: may change every
                                                             number of m, but not bsdf, ior, the handles and whether it
                                                             emits; NaN and what is below 0 count as 0 in emission.
                                                             Called from all render threads */
    const pt_bsdf_vtable *vtable;                         /* PT_BSDF_USER; copied */
    void      *user;
} pt_material_desc;
PT_DEF pt_material pt_add_material(pt_scene *s, const pt_material_desc *d);
/* eta and k of aluminium, brass, chromium, copper, gold, iron, mercury, platinum, silver, titanium; 0: no such name. */
PT_DEF int pt_metal(const char *name, pt_vec3 *eta, pt_vec3 *k);

typedef struct pt_mesh_desc {
    const float    *positions;                            /* x y z ... in metres, finite, below 1e12. What is smaller than
                                                             1e-12 may not be hit: scale it up */
    size_t          vertex_count, vertex_stride;          /* stride in bytes, a multiple of 4; 0 = 12 */
    const uint32_t *indices;                              /* three a triangle; NULL = 0 1 2, 3 4 5, ... */
    size_t          index_count;                          /* with NULL indices: 0 = vertex_count; else 0 is an empty mesh,
                                                             and no error */
    const float    *normals, *uvs;                        /* 3 and 2 floats a vertex, tight; NULL = none. A zero normal
                                                             stands for the triangle's own */
    pt_material     material;                             /* of all triangles, unless there are ids: */
    const pt_material *materials;                         /* what material_ids count in */
    size_t          material_count;
    const uint32_t *material_ids;                         /* one a triangle, from 0; NULL = all material, or materials[0]
                                                             where that is none and this is there */
    int             borrow;                               /* the caller keeps the arrays alive; nothing is copied but the
                                                             materials */
} pt_mesh_desc;

/* A shape of the user's own. bounds is asked once, when it is added. intersect returns nonzero and fills t (tmin < t <
   tmax), ng, and as it likes u and v, for the nearest hit; the rest of x is the renderer's. Called from all render
   threads. As bounds of a volume it is asked for one wall after the other, each from where the last one was. */
typedef struct pt_shape_vtable {
    void (*bounds)(void *user, pt_vec3 *lo, pt_vec3 *hi);
    int  (*intersect)(void *user, const pt_ray *ray, pt_vertex *x);
} pt_shape_vtable;

PT_DEF pt_shape pt_add_mesh(pt_scene *s, const pt_mesh_desc *d);
PT_DEF pt_shape pt_add_sphere(pt_scene *s, pt_vec3 center, float radius, pt_material m);
/* A parallelogram; its normal is edge_u x edge_v, (u, v) = (0, 0) at corner. */
PT_DEF pt_shape pt_add_quad(pt_scene *s, pt_vec3 corner, pt_vec3 edge_u, pt_vec3 edge_v, pt_material m);
/* Six quads facing outwards; xform NULL = identity. */
PT_DEF pt_shape pt_add_box(pt_scene *s, pt_vec3 lo, pt_vec3 hi, const pt_xform *xform, pt_material m);
/* Places a committed scene, which must outlive s and have no instances of its own. Its environment does not come along;
   its emitters do (a sphere's light is found by chance only, where xform makes it an ellipsoid). */
PT_DEF pt_shape pt_add_instance(pt_scene *s, const pt_scene *of, const pt_xform *xform);
/* The same, in motion: at ray time t in [0,1] each coefficient of its transform is (1 - t) from + t to, and it stands still
   before and after (see pt_camera's shutter). Points so move on straight lines: a turn by the angle a shrinks to cos(a/2)
   half way, and one whose determinant reaches zero is refused. Its emitters are found by chance only. */
PT_DEF pt_shape pt_add_moving_instance(pt_scene *s, const pt_scene *of, const pt_xform *from, const pt_xform *to);
PT_DEF pt_shape pt_add_user_shape(pt_scene *s, const pt_shape_vtable *v, void *user, pt_material m);
/* Fills a shape with a medium. The shape must be closed, its normals all pointing outwards (a mesh's may all point inwards), and
   may not cross itself; it may be concave, hollow, in several pieces that do not touch, an instance. (Nothing checks that: of an
   open one, what lies before a face seen from behind is inside.) Volumes may overlap each other and anything else, and the camera
   may be inside.
   Bounds of none: everywhere, then without a density or a march; such fog does not come along with an instance. It goes on
   for 10^15 m, so that no sky and no sun is seen through it, however thin it is; where rays can leave, what glows there must also
   absorb, else it is infinitely bright, and samples are discarded; and where it absorbs nothing, paths go on and on: a box that is
   large enough spares them that.
   A shape whose material is none, or PT_BSDF_NONE without emission, is the medium's bounds and nothing else from then on: no ray
   stops there, pt_intersect does not see it.
   The least noise about small lamps has fog that does not vary, with bounds that are a box, a sphere or none: its particles are
   looked for near lamps. */
PT_DEF pt_volume pt_add_volume(pt_scene *s, pt_shape bounds, pt_medium m);

/* Lights that have no shape. (Every shape whose material emits is a light too.) Each kind reads what stands in its line, and
   ignores the rest. A scene has one environment or sky, and any number of the others.
     ENVIRONMENT  texture or radiance, rotate_deg; color is radiance: multiplies the texture and the callback, there zero = 1.
                  Either keeps 0.5 to 9 MB of tables, however large the texture
     SUN          direction, radius_deg; color is irradiance in W/m^2 on a surface that faces it. A disk of even radiance,
                  infinitely far away
     POINT        position, radius; color is power in W. A real sphere, seen and hit, black but for its light
     SPOT         position, radius, direction, cone_deg, blend; color is the power of the POINT that is seen through the cone
     SKY          direction, radius_deg, turbidity; color multiplies, zero = 1. Cloudless daylight or dusk, and the sun; takes
                  a tenth of a second. Radiance is near 100 by day (expose a picture by -6 stops, or color it .02); below
                  the horizon is ground of albedo 0.2. Its watts are those that eyes see, 179 lm each: half of what a
                  pyranometer reads */
typedef enum pt_light_kind {
    PT_LIGHT_ENVIRONMENT, PT_LIGHT_SUN, PT_LIGHT_POINT, PT_LIGHT_SPOT, PT_LIGHT_SKY
} pt_light_kind;
typedef struct pt_light_desc {
    pt_light_kind kind;
    pt_vec3 color;                                        /* between 0 and 1e12, as is any radiance that comes of it */
    pt_vec3 position;                                     /* metres */
    pt_vec3 direction;                                    /* in which the light goes, of any length; zero = straight down */
    float radius;                                         /* metres; 0 = 0.01 */
    float radius_deg;                                     /* angular radius, 0.001 to 90; 0 = 0.2665, the sun's */
    float cone_deg;                                       /* half angle at which a spot is dark, 0.1 to 90; 0 = 45 */
    float blend;                                          /* share of that angle in which it fades, 0.001 to 1; 0 = 0.15 */
    float turbidity;                                      /* haze, 1.8 (very clear) to 10; 0 = 3 */
    pt_texture texture;                                   /* equirectangular: its middle is towards -z, its right
                                                             towards +x */
    float rotate_deg;                                     /* -36000 to 36000, about +y, counter-clockwise seen from above */
    pt_vec3 (*radiance)(void *user, pt_vec3 dir);         /* instead of a texture; sampled after a table of
                                                             256 x 128 cells. Called at commit, and from all render
                                                             threads */
    void *user;
} pt_light_desc;
PT_DEF pt_light pt_add_light(pt_scene *s, const pt_light_desc *d);

/* ---- render: a bag of tiles. Any number of the caller's threads may call pt_render_work() ------------- */

typedef enum pt_projection {
    PT_CAMERA_PERSPECTIVE,
    PT_CAMERA_ORTHOGRAPHIC,                               /* parallel rays, from the plane of the eye */
    PT_CAMERA_EQUIRECTANGULAR,                            /* 360 x 180 degrees: the middle is towards the target, as an
                                                             environment's is towards -z */
    PT_CAMERA_FISHEYE                                     /* equidistant: the angle to the axis grows as the distance from
                                                             the middle. The circle that just fits; black around it */
} pt_projection;
typedef struct pt_camera {
    pt_vec3 eye, target, up;                              /* up: zero = +y */
    float vfov_deg;                                       /* 0 = 40; below 180. Fisheye: across the circle, 0 = 180; up to
                                                             360 */
    float aperture, focus;                                /* lens radius, 0 = pinhole; focal distance, 0 = to the target.
                                                             Along the axis; equirectangular, fisheye: along the ray */
    pt_projection projection;
    float height;                                         /* orthographic: metres from the top of the picture to the
                                                             bottom; 0 = what vfov_deg sees at the target */
    int   blades;                                         /* the aperture is a regular polygon, corners on the lens's rim:
                                                             3 to 16; 0 = round */
    float blade_rotation_deg;                             /* 0 = a corner towards the right; counter-clockwise as the camera
                                                             looks; -36000 to 36000 */
    float shift_x, shift_y;                               /* perspective, orthographic: the picture shows what lies so far
                                                             to the right, in widths, and above, in heights; -10 to 10 */
    float distortion;                                     /* perspective, orthographic: k1 of r' = r (1 + k1 r^2), r on the
                                                             picture, r' where the ray goes, both from the axis in half
                                                             heights: above 0 barrel, below 0 pincushion; r' must grow
                                                             with r all over the picture */
    float aberration;                                     /* perspective, orthographic: magnification at 700 nm less that at
                                                             400 nm, relative to that at 550 nm, -0.5 to 0.5; light of one
                                                             wavelength shows it */
    float vignetting;                                     /* perspective: 0 = none, to 1 = cos^4 of the angle to the axis */
    float shutter_open, shutter_close;                    /* ray times, drawn uniformly; both 0 = no motion */
    int   moving;                                         /* 1 = from eye, target, up when the shutter opens, linearly to
                                                             the next three when it closes */
    pt_vec3 eye_end, target_end, up_end;                  /* up_end: zero = +y */
} pt_camera;
/* A pixel is the mean of the picture under one of these, middle at the pixel's; each is a product of two of one variable.
   x below is in pixels, r the radius. Samples are drawn from |f|, each for one pixel (Ernst, Stamminger and Greiner 2006).
   Where Mitchell's is negative, a sample counts negative: pixels at sharp edges may be below 0, and need more samples. */
typedef enum pt_filter {
    PT_FILTER_DEFAULT,                                    /* BOX */
    PT_FILTER_BOX,                                        /* r: 0 = 0.5, the pixel itself */
    PT_FILTER_TENT,                                       /* 1 - |x| / r; r: 0 = 1 */
    PT_FILTER_GAUSSIAN,                                   /* deviation r / 3, lowered to reach 0 at r; r: 0 = 1.5 */
    PT_FILTER_MITCHELL,                                   /* B = C = 1/3 (Mitchell and Netravali 1988); r: 0 = 2 */
    PT_FILTER_BLACKMAN_HARRIS                             /* four terms (Harris 1978); r: 0 = 1.5 */
} pt_filter;
typedef enum pt_sampler { PT_SAMPLER_SOBOL, PT_SAMPLER_STRATIFIED, PT_SAMPLER_RANDOM } pt_sampler;

/* Shares of the mixture's parts. All zero = automatic: a fair share for the BSDF, the rest for lights and environment by how much
   light they seem to send, and, place by place, what each was seen to bring by up to 65536 paths that go ahead of the picture
   (one thread's work while the others wait, mostly below 0.1 s; they call callbacks, too, but count in no pt_stats, and take
   280 KB; previews of a pass or two are quicker with weights that are set). Else relative, 0 to 1e6; a part that a vertex
   lacks gives its share back.
   Any weights with bsdf > 0 have the same mean; without it, light that only the BSDF finds is left out: for comparisons. */
typedef struct pt_weights { float bsdf, lights, environment; } pt_weights;

/* How a path finds light. All have the same mean, and differ in noise and time. */
typedef enum pt_integrator {
    PT_INTEGRATOR_MIXTURE,                                /* rays from one density that knows lights: see max_split */
    PT_INTEGRATOR_NEE,                                    /* next-event estimation: two rays a vertex, one drawn from the
                                                             lights, for what they send here, one from the BSDF and the
                                                             users' densities, to go on; both find emission, weighted
                                                             (Veach and Guibas 1995, power heuristic) */
    PT_INTEGRATOR_NEE_ALL                                 /* the same with a ray to each emitter, each sun and the
                                                             environment: for a few lights */
} pt_integrator;
/* When a path ends early, by chance. Where what this looks at is below 1/4, four times that is the chance to go on (but no
   less than 0.05). */
typedef enum pt_roulette {
    PT_ROULETTE_POTENTIAL,                                /* throughput, without what mirrors and panes have taken */
    PT_ROULETTE_THROUGHPUT,                               /* throughput as it is: worse behind tinted glass */
    PT_ROULETTE_NONE                                      /* never: all go on to max_depth, or until they are lost */
} pt_roulette;

typedef struct pt_render_desc {
    int width, height, spp;                               /* pixels, up to 65536 each; samples a pixel, 0 = 64 */
    int max_depth;                                        /* scattering events, black beyond, up to 2^27 - 1; 0 = 64. 1 is
                                                             direct light */
    int max_diffuse;                                      /* of them by diffuse lobes: diffuse, translucent, fuzz, users';
                                                             in media, all. 1 is for outdoors: direct light alone, and
                                                             that in mirrors, in gloss and through glass; 0 = no limit
                                                             but max_depth */
    int max_split;                                        /* a path that is worth much goes on along up to so many rays,
                                                             strata of one density: 1 to 8, 0 = 8. 1 is the paper's one
                                                             ray a vertex; next-event estimation never splits */
    int tile, threads;                                    /* up to 65536, 0 = 32 pixels; up to 4096, 0 = one a core */
    uint64_t seed;
    int first_sample;                                     /* of a larger render that several machines share */
    int crop_x, crop_y, crop_width, crop_height;          /* pixels of the full picture from its top left: only these are
                                                             rendered, as in the full picture bit for bit, and are all
                                                             that pt_render_pixels has. Width or height 0 = all the rest */
    pt_camera camera;
    pt_sampler sampler;
    pt_filter filter;
    float filter_radius;                                  /* pixels, up to 64; 0 = the filter's own */
    pt_weights weights;                                   /* NEE: lights to environment as here; none with bsdf alone */
    pt_integrator integrator;
    pt_roulette roulette;
    int guide;                                            /* samples a pixel, up to 65536, that path guiding learns from before
                                                             the picture, and that are thrown away; 0 = no guiding. For
                                                             light that comes through a gap: an eighth of spp, and spp in
                                                             the hundreds. Of less than 32768 samples in all it learns
                                                             nothing; and where it sees soon that BSDF, lights and
                                                             environment do as well, it leaves it to them. One thread
                                                             learns, while the others wait. Up to 30 MB */
    const char *isa;                                      /* NULL = best; "scalar", "sse2", "avx2", "neon" */
    int (*progress)(void *user, double done);             /* 0..1, after each tile, one call at a time, from the thread that
                                                             finished it; nonzero cancels. It may call pt_render_pixels,
                                                             _stats and _cancel, but not _work or _run */
    void *user;
} pt_render_desc;
typedef struct pt_stats {
    uint64_t rays, paths;
    uint64_t discarded;                                   /* samples not finite, negative or above 1e12, and those that
                                                             follow: counted as black */
    uint64_t exceeded;                                    /* samples that met a density above its density_max or NaN, or so far
                                                             below it, or marched through in such small steps, that a flight
                                                             of 2^18 looks did not end; the scene's logger hears of the
                                                             first. (Shadow rays do not tell.) */
    double seconds;                                       /* inside pt_render_run; 0 with PT_NO_THREADS */
} pt_stats;

/* The scene must be committed and outlive the render. NULL only when out of memory: bad arguments make a render whose
   calls return PT_ERR_ARG and whose pt_render_error says why. Everything a render needs is allocated here. */
PT_DEF pt_render   *pt_render_create(const pt_scene *s, const pt_render_desc *d);
PT_DEF void         pt_render_destroy(pt_render *r);      /* when no thread is inside it; NULL is fine */
PT_DEF const char  *pt_render_error(const pt_render *r);  /* in words, or "" */
PT_DEF pt_result    pt_render_work(pt_render *r);         /* one tile: PT_MORE, PT_OK when none was left to take,
                                                             PT_CANCELLED, or an error; any number of threads */
PT_DEF pt_result    pt_render_run(pt_render *r);          /* blocks: desc.threads threads calling pt_render_work */
PT_DEF pt_result    pt_render_add_samples(pt_render *r, int spp);   /* when all is done, or cancelled and left: makes work
                                                             for spp more, and for what is missing. Else
                                                             PT_ERR_STATE */
PT_DEF pt_result    pt_render_merge(pt_render *into, pt_render *from);   /* adds the samples of a render of the same size
                                                             and crop, both finished: ranges merged equal the whole, bit
                                                             for bit (stratified: if every range is a multiple of spp) */
PT_DEF void         pt_render_cancel(pt_render *r);       /* from any thread; finished pixels stay */
PT_DEF const float *pt_render_pixels(pt_render *r);       /* mean so far: linear RGB, top row first, width * height * 3 of
                                                             the crop; black where no sample is finished, never negative
                                                             but with PT_FILTER_MITCHELL. One thread at a time, valid
                                                             until the next call or destroy */
PT_DEF pt_stats     pt_render_stats(pt_render *r);        /* any thread */

/* ---- files --------------------------------------------------------------------------------------------- */
/* Pictures are linear RGB, top row first. What takes a path has a twin for memory or a callback. A file that could not
   be written whole is not left behind, and one that was there before stays as it was. A PNG takes 40 KB of the stack. */

typedef struct pt_writer {
    int (*write)(void *user, const void *data, size_t size);     /* 0 = fine; anything else stops with PT_ERR_IO */
    void *user;
} pt_writer;

/* How radiance becomes the numbers of a picture that is looked at: PNG and PPM. Each curve ends in sRGB; NaN and what is
   negative is black. NULL instead of an encoding means all zero; what is out of range is PT_ERR_ARG. */
typedef enum pt_curve {
    PT_CURVE_SRGB,                                        /* as it is: 1 and above is white */
    PT_CURVE_FILMIC,                                      /* highlights bend off: 10 is white, 0.18 stays 0.18. A channel
                                                             by itself. Narkowicz 2015 */
    PT_CURVE_FALSE_COLOR                                  /* a colour for each stop of luminance, counted from 0.18: -6 and
                                                             below black, -5 purple, -4 violet, -3 blue, -2 azure,
                                                             -1 cyan, 0 green, 1 lime, 2 yellow, 3 orange, 4 red,
                                                             5 pink, 6 and above white; each +- 1/2 */
} pt_curve;
typedef struct pt_encoding {
    float exposure_stops;                                 /* brighter by 2^stops, before the curve; -100 to 100 */
    pt_curve curve;
    int bits;                                             /* a channel, 8 or 16; 0 = 8. PNG only: a PPM has 8 */
} pt_encoding;

PT_DEF pt_result pt_write_png_to(const pt_writer *w, const float *rgb, int width, int height, const pt_encoding *e);
PT_DEF pt_result pt_write_ppm_to(const pt_writer *w, const float *rgb, int width, int height, const pt_encoding *e);
PT_DEF pt_result pt_write_pfm_to(const pt_writer *w, const float *rgb, int width, int height);
PT_DEF pt_result pt_write_hdr_to(const pt_writer *w, const float *rgb, int width, int height);
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_write_png(const char *path, const float *rgb, int width, int height, const pt_encoding *e);
PT_DEF pt_result pt_write_ppm(const char *path, const float *rgb, int width, int height, const pt_encoding *e);
PT_DEF pt_result pt_write_pfm(const char *path, const float *rgb, int width, int height);   /* exact */
PT_DEF pt_result pt_write_hdr(const char *path, const float *rgb, int width, int height);   /* 8 bits a channel and a
                                                                                                shared exponent; NaN and
                                                                                                below 0 become 0 */
#endif

/* A picture read from a file. Start from zero, or with an allocator set; free with pt_image_free, also after an error. */
typedef struct pt_image {
    int width, height, channels;                          /* 3, or 1 for a grey PFM or PGM */
    float *pixels;                                        /* linear, top row first */
    pt_allocator allocator;
    char error[256];                                      /* "file:line: reason", or "" */
} pt_image;
/* PFM, Radiance HDR, or PPM and PGM (P2, P3, P5, P6; taken for sRGB, as pt_write_ppm writes them), by content. */
PT_DEF pt_result pt_read_image_memory(pt_image *out, const void *data, size_t size);
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_read_image(pt_image *out, const char *path);
#endif
PT_DEF void      pt_image_free(pt_image *image);

/* A measured BRDF read from a file of the MERL database (Matusik et al. 2003), for pt_measured_desc. Start from zero, or with
   an allocator set; free with pt_merl_free, also after an error, and as soon as it has been added: it takes 17 MB. */
typedef struct pt_merl {
    float *values;                                        /* 90 x 90 x 180 RGB, what was not measured 0 */
    pt_allocator allocator;
    char error[256];                                      /* "file:byte N: reason", or "" */
} pt_merl;
PT_DEF pt_result pt_read_merl_memory(pt_merl *out, const void *data, size_t size);
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_read_merl(pt_merl *out, const char *path);
#endif
PT_DEF void      pt_merl_free(pt_merl *merl);

/* Densities on a grid, read from a file or to be written to one: Mitsuba's VOL files of one channel of floats, 48 bytes and the
   values, which fit pt_medium_desc. Start from zero, or with an allocator set; free with pt_grid_free what was read, also after
   an error. Writing looks at what stands before the allocator; what is not finite is refused, as in reading. */
typedef struct pt_grid {
    int nx, ny, nz;                                       /* 1 to 4096 each */
    float *values;                                        /* of (x, y, z) at values + (z ny + y) nx + x */
    pt_vec3 lo, hi;                                       /* the box that it fills, as the file has it */
    pt_allocator allocator;
    char error[256];                                      /* "file:byte N: reason", or "" */
} pt_grid;
PT_DEF pt_result pt_read_grid_memory(pt_grid *out, const void *data, size_t size);
PT_DEF pt_result pt_write_grid_to(const pt_writer *w, const pt_grid *grid);
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_read_grid(pt_grid *out, const char *path);
PT_DEF pt_result pt_write_grid(const char *path, const pt_grid *grid);
#endif
PT_DEF void      pt_grid_free(pt_grid *grid);

/* A material that came with a mesh: its numbers are in desc. Its pictures are for the caller to load, with any library:
       for (k = 0; k < PT_MTL_MAPS; k++)
           if (m->maps[k].file) *pt_mtl_texture(m, k) = load(scene, m->maps + k);     (load: picture, then pt_add_texture)
       materials[i] = pt_add_material(scene, &m->desc);
   Then pt_mesh_desc takes materials, and material_count and material_ids as they are in pt_mesh. */
enum { PT_MTL_COLOR, PT_MTL_SPECULAR, PT_MTL_ROUGHNESS, PT_MTL_METALLIC, PT_MTL_SHEEN, PT_MTL_EMISSION, PT_MTL_OPACITY,
       PT_MTL_NORMAL, PT_MTL_BUMP, PT_MTL_MAPS };
typedef struct pt_mtl_map {
    const char *file;                                     /* with the folder of the MTL file before it; NULL = no map */
    float uv_scale[2], uv_offset[2];                      /* looked up at offset + scale (u, 1 - v), (0, 0) the top left */
    int channel;                                          /* 0 = all; 1 to 4 = red, green, blue, alpha alone */
    int srgb;                                             /* a color: its pixels are sRGB-encoded */
    int clamp;                                            /* at the border, instead of repeating */
    float base, gain;                                     /* the pixels are to become base + gain pixel; mostly 0 and 1 */
} pt_mtl_map;
typedef struct pt_mtl {
    const char *name;
    int defined;                                          /* 0 = no file said what it is: grey */
    pt_material_desc desc;
    pt_mtl_map maps[PT_MTL_MAPS];
} pt_mtl;
PT_DEF pt_texture *pt_mtl_texture(pt_mtl *m, int map);    /* the texture in desc that the map is for */

/* A mesh read from a file; its arrays fit pt_mesh_desc. Start from zero, or with an allocator set; free also after an
   error. */
typedef struct pt_mesh {
    float *positions, *normals, *uvs;                     /* normals and uvs: NULL if the file has none */
    uint32_t *indices;
    size_t vertex_count, index_count;
    pt_mtl *materials;                                    /* those that faces use; NULL if the file names none */
    size_t material_count;
    uint32_t *material_ids;                               /* one a triangle, into materials; NULL if there is but one */
    pt_vec3 lo, hi;                                       /* bounds of what the indices use */
    pt_allocator allocator;
    char error[256];                                      /* "file:line: reason", or "" */
    char warning[256];                                    /* the first thing that was passed over, in the same form */
} pt_mesh;
PT_DEF pt_result pt_read_obj_memory(pt_mesh *out, const void *data, size_t size);
PT_DEF pt_result pt_read_mtl_memory(pt_mesh *mesh, const void *data, size_t size);    /* fills in materials by name */
PT_DEF pt_result pt_read_ply_memory(pt_mesh *out, const void *data, size_t size);
PT_DEF pt_result pt_read_mesh_memory(pt_mesh *out, const void *data, size_t size);    /* PLY or OBJ, by content */
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_read_obj(pt_mesh *out, const char *path);     /* and the MTL files that it names, if they are there */
PT_DEF pt_result pt_read_ply(pt_mesh *out, const char *path);
PT_DEF pt_result pt_read_mesh(pt_mesh *out, const char *path);
#endif
/* Smooth normals, in place of those that were there: of the triangles round a point, weighted by their angles. An edge
   where they meet at more than angle_deg stays sharp, its vertices become two; 0 = 180: none does. On an error, the mesh
   stays as it was. */
PT_DEF pt_result pt_mesh_smooth(pt_mesh *mesh, float angle_deg);
PT_DEF void      pt_mesh_free(pt_mesh *mesh);

/* ---- the toolbox: the parts the integrator is made of, for teaching, tests and other uses ------------- */

/* Ray queries. The scene must be committed; any number of threads. A ray that can not be (all of dir below 1e-37, org or
   dir NaN or infinite) hits nothing, nor does one where d^3 / |dir| leaves the floats, d being how far the triangle's corners are
   (1e12 at length 1, 1e9 at 1e-10); a tmin below 0 or NaN is 0; a tmax not above 0, infinite or NaN is no end. A hit's t is in
   units of |dir|; where two are equally near, what was added first is hit. */
PT_DEF int      pt_intersect(const pt_scene *s, const pt_ray *ray, pt_vertex *x);     /* nearest hit; 0 = none, and x stays */
PT_DEF int      pt_occluded(const pt_scene *s, const pt_ray *ray);                    /* any hit */
/* The same for many rays at once, one after the other, and of a hit only what costs next to nothing: no normals, no texture
   coordinates. Both return how many rays hit something. Without a committed scene, or where rays is NULL, none does, and the
   results say so; where the results are NULL, nothing is done, and that is 0. */
typedef struct pt_hit {
    float t;                                              /* infinite where nothing is hit; the rest is zero then */
    float u, v;                                           /* on triangles: p = (1 - u - v) a + u b + v c; 0 on spheres */
    uint32_t prim;                                        /* triangle within its mesh; 0 elsewhere */
    pt_shape shape, instance;                             /* as in pt_vertex: shape.id is never 0 where something is hit */
} pt_hit;
PT_DEF size_t   pt_intersect_all(const pt_scene *s, const pt_ray *rays, size_t count, pt_hit *hits);
PT_DEF size_t   pt_occluded_all(const pt_scene *s, const pt_ray *rays, size_t count, unsigned char *occluded);   /* 0 or 1 */
typedef struct pt_rng { uint64_t state, inc; } pt_rng;    /* PCG32 */
PT_DEF void     pt_rng_seed(pt_rng *r, uint64_t seed, uint64_t stream);
PT_DEF uint32_t pt_rng_u32(pt_rng *r);
PT_DEF float    pt_rng_float(pt_rng *r);                  /* [0,1) */

static inline pt_vec3 pt_v3(float x, float y, float z) { pt_vec3 v; v.x = x; v.y = y; v.z = z; return v; }

#ifdef __cplusplus
}
#endif
#endif /* PT_PATHTRACER_H_INCLUDED */

/* ======================================================================================================= *
 *  Implementation                                                                                         *
 * ======================================================================================================= */
#if defined(PT_IMPLEMENTATION) && !defined(PTI_IMPLEMENTED)
#define PTI_IMPLEMENTED

/* ---- >>platform ----------------------------------------------------------------------------------------
   All that differs between machines and compilers, so that no later chapter needs an #if. Floats must mean the same
   everywhere: no x87 excess precision, no fast-math, no fusing of a * b + c, no flushing of denormals. */

#include <float.h>
#include <math.h>    /* sqrt, sqrtf, floor, floorf, fabsf: those that IEEE 754 fixes to the bit */
#include <stdarg.h>
#include <stdlib.h>  /* malloc, free */
#include <string.h>
#ifndef PT_NO_STDIO
#include <stdio.h>
#endif
#ifndef PT_NO_THREADS
#include <pthread.h>
#include <sys/time.h>
#include <unistd.h>
#endif

#ifndef PT_ALLOW_FAST_MATH
#if defined(__FAST_MATH__)
#error "pt.h promises equal bits everywhere, and -ffast-math breaks that: compile without it, or define PT_ALLOW_FAST_MATH"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16    /* 16: halves as halves, floats as floats */
#error "pt.h needs floats that are computed as floats: add -msse2 -mfpmath=sse, or define PT_ALLOW_FAST_MATH"
#endif
#endif

#if !defined(PT_NO_SIMD) && (defined(__x86_64__) || (defined(__i386__) && defined(__SSE2__))) && defined(__GNUC__)
#define PTI_X86
#include <immintrin.h>
#include <cpuid.h>
#elif !defined(PT_NO_SIMD) && defined(__aarch64__) && defined(__GNUC__)   /* 32-bit NEON flushes denormals: not for us */
#define PTI_NEON
#include <arm_neon.h>
#endif

#if defined(__GNUC__)
#define PTI_INLINE static inline __attribute__((always_inline))
#define PTI_AVX2   __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define PTI_NOINLINE static __attribute__((noinline))
#define PTI_FETCH(p) __builtin_prefetch(p)               /* into the cache, for later */
#else
#define PTI_INLINE static inline
#define PTI_NOINLINE static
#define PTI_FETCH(p) ((void)(p))
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize ("fp-contract=off", "no-ipa-ra")  /* with ipa-ra, gcc forgets vzeroupper before calls from AVX2 code, and
                                                           Intel's processors are three times slower there */
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The index of the lowest set bit of x, which is not 0. */
PTI_INLINE int pti_lowest_bit(uint32_t x) {
#if defined(__GNUC__)
    return __builtin_ctz(x);
#else
    int k = 0;
    while (!(x >> k & 1)) k++;
    return k;
#endif
}
PTI_INLINE uint32_t pti_highest_bit(uint32_t x) {        /* and of the highest */
#if defined(__GNUC__)
    return 31u - (uint32_t)__builtin_clz(x);
#else
    uint32_t k = 31;
    while (!(x >> k & 1)) k--;
    return k;
#endif
}

PTI_INLINE uint32_t pti_reverse_bytes(uint32_t x) {
#if defined(__GNUC__)
    return __builtin_bswap32(x);
#else
    return x >> 24 | (x >> 8 & 0xff00u) | (x << 8 & 0xff0000u) | x << 24;
#endif
}

/* Denormals kept, rounding to nearest, whatever the host's thread has set. */
typedef uint64_t pti_fpmode;
static pti_fpmode pti_fpmode_enter(void) {
#if defined(PTI_X86)
    pti_fpmode old = _mm_getcsr();
    _mm_setcsr(0x1f80);
    return old;
#elif defined(PTI_NEON)
    pti_fpmode old, ieee = 0;
    __asm__ volatile("mrs %0, fpcr" : "=r"(old));
    __asm__ volatile("msr fpcr, %0" : : "r"(ieee));
    return old;
#else
    return 0;
#endif
}
static void pti_fpmode_leave(pti_fpmode old) {
#if defined(PTI_X86)
    _mm_setcsr((unsigned)old);
#elif defined(PTI_NEON)
    __asm__ volatile("msr fpcr, %0" : : "r"(old));
#else
    (void)old;
#endif
}

/* Was a b + c fused after all? Only clang's -ffp-contract=fast, which overrides the pragma above, does that. */
PTI_NOINLINE int pti_fuses(void) {
    volatile float one_and_a_bit = 1 + 1.0f / 4096, minus_square = -(1 + 1.0f / 2048);      /* rounded */
    float a = one_and_a_bit, c = minus_square;
    return a * a + c != 0;
}

/* The instruction sets that kernels exist for, best last. */
#define PTI_ISAS(X) X(scalar, SCALAR) X(sse2, SSE2) X(avx2, AVX2) X(neon, NEON)
typedef enum pti_isa {
#define PTI_ISA_ENUM(name, NAME) PTI_##NAME##_ISA,
    PTI_ISAS(PTI_ISA_ENUM)
#undef PTI_ISA_ENUM
    PTI_ISA_COUNT
} pti_isa;

static int pti_isa_supported(int isa) {
    if (isa == PTI_SCALAR_ISA) return 1;
#if defined(PTI_X86)
    if (isa == PTI_SSE2_ISA) return 1;
    if (isa == PTI_AVX2_ISA) {
        unsigned a, b, c, d, lo, hi;
        if (!__get_cpuid(1, &a, &b, &c, &d)) return 0;
        if (!(c & (1u << 12)) || !(c & (1u << 23)) || !(c & (1u << 27))) return 0;      /* FMA; POPCNT; the OS uses XSAVE */
        __asm__ volatile("xgetbv" : "=a"(lo), "=d"(hi) : "c"(0));
        if ((lo & 6) != 6) return 0;                                           /* and saves the wide registers */
        if (!__get_cpuid(0x80000001u, &a, &b, &c, &d) || !(c & (1u << 5))) return 0;      /* LZCNT */
        return __get_cpuid_count(7, 0, &a, &b, &c, &d) && !(~b & (1u << 3 | 1u << 5 | 1u << 8));       /* BMI1; AVX2; BMI2 */
    }
#elif defined(PTI_NEON)
    if (isa == PTI_NEON_ISA) return 1;
#endif
    return 0;
}
static int pti_isa_best(void) {
    int isa = PTI_ISA_COUNT - 1;
    while (!pti_isa_supported(isa)) isa--;
    return isa;
}
static int pti_isa_by_name(const char *name) {           /* -1: no such name */
#define PTI_ISA_NAME(n, N) if (!strcmp(name, #n)) return PTI_##N##_ISA;
    PTI_ISAS(PTI_ISA_NAME)
#undef PTI_ISA_NAME
    return -1;
}

/* Threads. Without them, locks are nothing and one thread is all there is. */
#ifndef PT_NO_THREADS
typedef pthread_mutex_t pti_mutex;
typedef pthread_t pti_thread;
static int  pti_mutex_init(pti_mutex *m) { return pthread_mutex_init(m, NULL) == 0; }
static void pti_mutex_free(pti_mutex *m) { pthread_mutex_destroy(m); }
static void pti_lock(pti_mutex *m)       { pthread_mutex_lock(m); }
static void pti_unlock(pti_mutex *m)     { pthread_mutex_unlock(m); }
static int  pti_thread_start(pti_thread *t, void *(*f)(void *), void *arg) { return pthread_create(t, NULL, f, arg) == 0; }
static void pti_thread_join(pti_thread t) { pthread_join(t, NULL); }
static int  pti_cores(void) { long n = sysconf(_SC_NPROCESSORS_ONLN); return n < 1 ? 1 : n > 1024 ? 1024 : (int)n; }
static double pti_seconds(void) {        /* not clock_gettime: strict C99 hides it */
    struct timeval t;
    gettimeofday(&t, NULL);
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}
#else
typedef int pti_mutex;
typedef int pti_thread;
static int  pti_mutex_init(pti_mutex *m) { *m = 0; return 1; }
static void pti_mutex_free(pti_mutex *m) { (void)m; }
static void pti_lock(pti_mutex *m)       { (void)m; }
static void pti_unlock(pti_mutex *m)     { (void)m; }
static int  pti_thread_start(pti_thread *t, void *(*f)(void *), void *arg) { (void)t; (void)f; (void)arg; return 0; }
static void pti_thread_join(pti_thread t) { (void)t; }
static int  pti_cores(void) { return 1; }
static double pti_seconds(void) { return 0; }
#endif

/* Memory. The built-in allocator aligns by itself and keeps malloc's own pointer just below the block. Where Linux lends pages
   of 2 MB to those who ask, large blocks ask: rays jump about in trees, and each new page costs them a look into the page
   tables. (Strict C99 hides the declaration, and C++ would mind one of our own, hence the other name.) */
#define PTI_ALIGN 64
#if defined(__linux__) && defined(__GNUC__) && !defined(PT_NO_THREADS)
#define PTI_HUGE ((size_t)2 << 20)
extern int pti_madvise(void *at, size_t size, int advice) __asm__("madvise");
static void pti_ask_for_huge_pages(void *p, size_t size) { (void)pti_madvise(p, size, 14); }     /* MADV_HUGEPAGE */
#else
#define PTI_HUGE SIZE_MAX
static void pti_ask_for_huge_pages(void *p, size_t size) { (void)p; (void)size; }
#endif
static void *pti_default_alloc(void *user, size_t size, size_t align) {
    int huge = size / 2 > PTI_HUGE;
    char *raw, *p;
    (void)user;
    if (huge) align = PTI_HUGE;
    raw = (char *)malloc(size + align + sizeof raw);
    if (!raw) return NULL;
    p = raw + sizeof raw;
    p += (align - (uintptr_t)p % align) % align;
    memcpy(p - sizeof raw, &raw, sizeof raw);
    if (huge) pti_ask_for_huge_pages(p, size / PTI_HUGE * PTI_HUGE);
    return p;
}
static void pti_default_free(void *user, void *ptr, size_t size) {
    void *raw;
    (void)user; (void)size;
    memcpy(&raw, (char *)ptr - sizeof raw, sizeof raw);
    free(raw);
}
static pt_allocator pti_allocator_or_default(pt_allocator a) {
    if (!a.alloc || !a.free) { a.alloc = pti_default_alloc; a.free = pti_default_free; a.user = NULL; }
    return a;
}
static void *pti_alloc_unset(const pt_allocator *a, size_t count, size_t size) {         /* NULL on overflow too */
    if (count > (SIZE_MAX / 2 - 2 * PTI_ALIGN) / size) return NULL;
    return a->alloc(a->user, (count ? count : 1) * size, PTI_ALIGN);
}
static void *pti_alloc(const pt_allocator *a, size_t count, size_t size) {               /* zeroed */
    void *p = pti_alloc_unset(a, count, size);
    if (p) memset(p, 0, (count ? count : 1) * size);
    return p;
}
static void pti_free(const pt_allocator *a, void *p, size_t count, size_t size) {
    if (p) a->free(a->user, p, (count ? count : 1) * size);
}
/* Makes room for one more at the end of *array, doubling. The array may have moved; 0 when out of memory. */
static int pti_grow(const pt_allocator *a, void **array, size_t count, size_t *capacity, size_t size) {
    size_t more;
    void *p;
    if (count < *capacity) return 1;
    if (*capacity > SIZE_MAX / 2) return 0;
    more = *capacity ? *capacity * 2 : 16;
    p = pti_alloc(a, more, size);
    if (!p) return 0;
    if (count) memcpy(p, *array, count * size);
    pti_free(a, *array, *capacity, size);
    *array = p;
    *capacity = more;
    return 1;
}

/* Calls work(user, i) for each i below count, on up to `threads` threads of which the caller's is one. Which thread does what
   is left to chance, so the calls must not care. */
typedef void pti_work(void *user, size_t i);
typedef struct pti_team { pti_mutex lock; pti_work *work; void *user; size_t next, count; } pti_team;
static void *pti_team_member(void *p) {
    pti_team *t = (pti_team *)p;
    pti_fpmode mode = pti_fpmode_enter();
    for (;;) {
        size_t i;
        pti_lock(&t->lock);
        i = t->next++;
        pti_unlock(&t->lock);
        if (i >= t->count) break;
        t->work(t->user, i);
    }
    pti_fpmode_leave(mode);
    return NULL;
}
#define PTI_TEAM 64
static void pti_parallel(int threads, pti_work *work, void *user, size_t count) {
    pti_thread others[PTI_TEAM];
    pti_team t;
    size_t i;
    int n = 0;
    memset(&t, 0, sizeof t);
    t.work = work; t.user = user; t.count = count;
    if (threads > PTI_TEAM) threads = PTI_TEAM;
    if (threads < 2 || count < 2 || !pti_mutex_init(&t.lock)) {
        for (i = 0; i < count; i++) work(user, i);
        return;
    }
    while (n + 1 < threads && (size_t)n + 1 < count && pti_thread_start(&others[n], pti_team_member, &t)) n++;
    pti_team_member(&t);
    while (n > 0) pti_thread_join(others[--n]);
    pti_mutex_free(&t.lock);
}

/* Four floats side by side, for rays and for the boxes of a tree that is being built. The smaller, the larger: b where a is NaN.
   What pti_f4_if makes of a is NaN unless k, which is 0 or 1. pti_f4_negative: bit k, is the k-th below 0? (-0 and NaN are not.) */
#if defined(PTI_X86)
typedef __m128 pti_f4;
PTI_INLINE pti_f4 pti_f4_load(const void *p) { return _mm_loadu_ps((const float *)p); }
PTI_INLINE void pti_f4_store(void *p, pti_f4 a) { _mm_storeu_ps((float *)p, a); }
PTI_INLINE pti_f4 pti_f4_set(float a) { return _mm_set1_ps(a); }
PTI_INLINE pti_f4 pti_f4_of(float a, float b, float c, float d) { return _mm_setr_ps(a, b, c, d); }
PTI_INLINE pti_f4 pti_f4_add(pti_f4 a, pti_f4 b) { return _mm_add_ps(a, b); }
PTI_INLINE pti_f4 pti_f4_sub(pti_f4 a, pti_f4 b) { return _mm_sub_ps(a, b); }
PTI_INLINE pti_f4 pti_f4_mul(pti_f4 a, pti_f4 b) { return _mm_mul_ps(a, b); }
PTI_INLINE pti_f4 pti_f4_div(pti_f4 a, pti_f4 b) { return _mm_div_ps(a, b); }
PTI_INLINE pti_f4 pti_f4_min(pti_f4 a, pti_f4 b) { return _mm_min_ps(a, b); }
PTI_INLINE pti_f4 pti_f4_max(pti_f4 a, pti_f4 b) { return _mm_max_ps(a, b); }
PTI_INLINE pti_f4 pti_f4_if(uint32_t k, pti_f4 a) {     /* or-ing four words read: quicker than to make them from k */
    static const int32_t unless[8] = { -1, -1, -1, -1, 0, 0, 0, 0 };
    return _mm_or_ps(a, _mm_loadu_ps((const float *)(const void *)(unless + 4 * k)));
}
PTI_INLINE void pti_f4_store_whole(int32_t *p, pti_f4 a) { _mm_storeu_si128((__m128i *)(void *)p, _mm_cvttps_epi32(a)); }
PTI_INLINE size_t pti_f4_negative(pti_f4 a) { return (size_t)_mm_movemask_ps(_mm_cmplt_ps(a, _mm_setzero_ps())); }
#elif defined(PTI_NEON)
typedef float32x4_t pti_f4;
PTI_INLINE pti_f4 pti_f4_load(const void *p) { return vld1q_f32((const float *)p); }
PTI_INLINE void pti_f4_store(void *p, pti_f4 a) { vst1q_f32((float *)p, a); }
PTI_INLINE pti_f4 pti_f4_set(float a) { return vdupq_n_f32(a); }
PTI_INLINE pti_f4 pti_f4_of(float a, float b, float c, float d) { float v[4] = { a, b, c, d }; return vld1q_f32(v); }
PTI_INLINE pti_f4 pti_f4_add(pti_f4 a, pti_f4 b) { return vaddq_f32(a, b); }
PTI_INLINE pti_f4 pti_f4_sub(pti_f4 a, pti_f4 b) { return vsubq_f32(a, b); }
PTI_INLINE pti_f4 pti_f4_mul(pti_f4 a, pti_f4 b) { return vmulq_f32(a, b); }
PTI_INLINE pti_f4 pti_f4_div(pti_f4 a, pti_f4 b) { return vdivq_f32(a, b); }
PTI_INLINE pti_f4 pti_f4_min(pti_f4 a, pti_f4 b) { return vminnmq_f32(a, b); }
PTI_INLINE pti_f4 pti_f4_max(pti_f4 a, pti_f4 b) { return vmaxnmq_f32(a, b); }
PTI_INLINE pti_f4 pti_f4_if(uint32_t k, pti_f4 a) {
    return vreinterpretq_f32_u32(vorrq_u32(vreinterpretq_u32_f32(a), vdupq_n_u32(k - 1)));
}
PTI_INLINE void pti_f4_store_whole(int32_t *p, pti_f4 a) { vst1q_s32(p, vcvtq_s32_f32(a)); }
PTI_INLINE uint32_t pti_mask_neon(uint32x4_t m) {
    static const uint32_t bits[4] = { 1, 2, 4, 8 };
    return vaddvq_u32(vandq_u32(m, vld1q_u32(bits)));
}
PTI_INLINE size_t pti_f4_negative(pti_f4 a) { return pti_mask_neon(vcltzq_f32(a)); }
#else
typedef struct pti_f4 { float v[4]; } pti_f4;
PTI_INLINE pti_f4 pti_f4_load(const void *p) { pti_f4 r; memcpy(r.v, p, sizeof r.v); return r; }
PTI_INLINE void pti_f4_store(void *p, pti_f4 a) { memcpy(p, a.v, sizeof a.v); }
PTI_INLINE pti_f4 pti_f4_of(float a, float b, float c, float d) {
    pti_f4 r;
    r.v[0] = a; r.v[1] = b; r.v[2] = c; r.v[3] = d;
    return r;
}
PTI_INLINE pti_f4 pti_f4_set(float a) { return pti_f4_of(a, a, a, a); }
#define PTI_F4_EACH(name, expression) \
    PTI_INLINE pti_f4 name(pti_f4 a, pti_f4 b) { int k; for (k = 0; k < 4; k++) a.v[k] = expression; return a; }
PTI_F4_EACH(pti_f4_add, a.v[k] + b.v[k])
PTI_F4_EACH(pti_f4_sub, a.v[k] - b.v[k])
PTI_F4_EACH(pti_f4_mul, a.v[k] * b.v[k])
PTI_F4_EACH(pti_f4_div, a.v[k] / b.v[k])
PTI_F4_EACH(pti_f4_min, a.v[k] < b.v[k] ? a.v[k] : b.v[k])
PTI_F4_EACH(pti_f4_max, a.v[k] > b.v[k] ? a.v[k] : b.v[k])
PTI_INLINE pti_f4 pti_f4_if(uint32_t k, pti_f4 a) {
    if (!k) memset(a.v, 0xff, sizeof a.v);
    return a;
}
PTI_INLINE void pti_f4_store_whole(int32_t *p, pti_f4 a) { int k; for (k = 0; k < 4; k++) p[k] = (int32_t)a.v[k]; }
PTI_INLINE size_t pti_f4_negative(pti_f4 a) {
    return (size_t)(a.v[0] < 0) | (size_t)(a.v[1] < 0) << 1 | (size_t)(a.v[2] < 0) << 2 | (size_t)(a.v[3] < 0) << 3;
}
#endif

/* Texts, without stdio. pti_format knows %s (string), %u (uint64_t), %d (int) and %g (double, six digits). */
typedef struct pti_text { char *at; size_t left; } pti_text;
static void pti_put(pti_text *t, const char *s) {
    while (*s && t->left > 1) { *t->at++ = *s++; t->left--; }
    *t->at = 0;
}
static void pti_put_uint(pti_text *t, uint64_t v) {
    char digits[24], *p = digits + sizeof digits;
    *--p = 0;
    do { *--p = (char)('0' + v % 10); v /= 10; } while (v);
    pti_put(t, p);
}
static void pti_put_double(pti_text *t, double v) {
    int e = 0, i;
    uint64_t n;
    char digits[8], one[2] = { 0, 0 };
    if (v != v) { pti_put(t, "nan"); return; }
    if (v < 0) { pti_put(t, "-"); v = -v; }
    if (v > DBL_MAX) { pti_put(t, "inf"); return; }
    if (v == 0) { pti_put(t, "0"); return; }
    while (v >= 10) { v /= 10; e++; }
    while (v < 1) { v *= 10; e--; }
    n = (uint64_t)(v * 100000 + 0.5);
    if (n >= 1000000) { n /= 10; e++; }
    for (i = 5; i >= 0; i--) { digits[i] = (char)('0' + n % 10); n /= 10; }
    for (i = 5; i > 0 && digits[i] == '0'; i--) {}
    digits[i + 1] = 0;                                   /* trailing zeros go */
    if (e >= 0 && e < 6) {                               /* 123.45 */
        int k;
        for (k = 0; k <= e; k++) { one[0] = k <= i ? digits[k] : '0'; pti_put(t, one); }
        if (i > e) { pti_put(t, "."); pti_put(t, digits + e + 1); }
        return;
    }
    if (e < 0 && e >= -4) {                              /* 0.0123 */
        pti_put(t, "0.");
        for (; e < -1; e++) pti_put(t, "0");
        pti_put(t, digits);
        return;
    }
    one[0] = digits[0];
    pti_put(t, one);
    if (i > 0) { pti_put(t, "."); pti_put(t, digits + 1); }
    pti_put(t, e < 0 ? "e-" : "e+");
    pti_put_uint(t, (uint64_t)(e < 0 ? -e : e));
}
static void pti_vformat(char *out, size_t size, const char *format, va_list args) {
    pti_text t;
    char one[2] = { 0, 0 };
    t.at = out; t.left = size;
    *out = 0;
    for (; *format; format++) {
        if (*format != '%') { one[0] = *format; pti_put(&t, one); continue; }
        switch (*++format) {
        case 0: return;
        case 's': pti_put(&t, va_arg(args, const char *)); break;
        case 'u': pti_put_uint(&t, va_arg(args, uint64_t)); break;
        case 'g': pti_put_double(&t, va_arg(args, double)); break;
        default: {                                       /* d */
            int d = va_arg(args, int);
            if (d < 0) pti_put(&t, "-");
            pti_put_uint(&t, d < 0 ? (uint64_t)-(int64_t)d : (uint64_t)d);
        }
        }
    }
}

/* The first error sticks; the logger hears every one. */
typedef struct pti_error { pt_result code; char text[256]; pt_logger logger; } pti_error;
static void pti_fail(pti_error *e, pt_result code, const char *format, ...) {
    char text[sizeof e->text];
    va_list args;
    va_start(args, format);
    pti_vformat(text, sizeof text, format, args);
    va_end(args);
    if (e->code == PT_OK) { e->code = code; memcpy(e->text, text, sizeof text); }
    if (e->logger.log) (*e->logger.log)(e->logger.user, code, text);         /* so written, tgmath.h does no harm */
}

PT_DEF const char *pt_result_string(pt_result r) {
    switch (r) {
    case PT_OK:         return "ok";
    case PT_MORE:       return "more to do";
    case PT_CANCELLED:  return "cancelled";
    case PT_ERR_ARG:    return "bad argument";
    case PT_ERR_STATE:  return "called at the wrong time";
    case PT_ERR_MEMORY: return "out of memory";
    case PT_ERR_IO:     return "input or output failed";
    case PT_ERR_FORMAT: return "malformed file";
    }
    return "unknown result";
}

/* ---- >>math --------------------------------------------------------------------------------------------
   Vectors, transforms, and elementary functions of our own: libm's differ from machine to machine in the last bit. Each is
   a Taylor series in double after a range reduction, rounded to float once, so its error is hardly more than the half
   ulp of that rounding. Largest errors, over all floats of the range (over 4e8 pairs of them: pow, atan2):
       sin, cos   0.500001 ulp  |x| <= 2^20     exp    0.500003 ulp  all x        log    0.500001 ulp  all x
       pow        0.500003 ulp  x >= 0          atan2  0.500001 ulp  all x, y     acos   0.500001 ulp  [-1, 1]
   NaN gives NaN. tests/test_math.c holds them to 0.50001. */

#define PTI_PI 3.14159265358979f
#define PTI_INF ((float)HUGE_VAL)

PTI_INLINE float pti_min(float a, float b) { return a < b ? a : b; }
PTI_INLINE float pti_max(float a, float b) { return a > b ? a : b; }
static float pti_clamp(float x, float lo, float hi) { return x < lo ? lo : x > hi ? hi : x; }
static int   pti_finite(float x) { return x - x == 0; }
/* A density of the user's: what is negative or endless becomes NaN, which the film counts. */
static float pti_density_of(float p) { return p >= 0 && pti_finite(p) ? p : (float)(PTI_INF - PTI_INF); }

static pt_vec3 pti_add(pt_vec3 a, pt_vec3 b) { return pt_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static pt_vec3 pti_sub(pt_vec3 a, pt_vec3 b) { return pt_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static pt_vec3 pti_mul(pt_vec3 a, pt_vec3 b) { return pt_v3(a.x * b.x, a.y * b.y, a.z * b.z); }
static pt_vec3 pti_scale(pt_vec3 a, float s) { return pt_v3(a.x * s, a.y * s, a.z * s); }
static pt_vec3 pti_neg(pt_vec3 a)            { return pt_v3(-a.x, -a.y, -a.z); }
static pt_vec3 pti_madd(pt_vec3 a, float s, pt_vec3 b) { return pti_add(pti_scale(a, s), b); }     /* a s + b */
static pt_vec3 pti_min3(pt_vec3 a, pt_vec3 b) { return pt_v3(pti_min(a.x, b.x), pti_min(a.y, b.y), pti_min(a.z, b.z)); }
static pt_vec3 pti_max3(pt_vec3 a, pt_vec3 b) { return pt_v3(pti_max(a.x, b.x), pti_max(a.y, b.y), pti_max(a.z, b.z)); }
static float   pti_dot(pt_vec3 a, pt_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static pt_vec3 pti_cross(pt_vec3 a, pt_vec3 b) {
    return pt_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static float   pti_length(pt_vec3 a) { return sqrtf(pti_dot(a, a)); }
static float   pti_largest(pt_vec3 a) { return pti_max(a.x, pti_max(a.y, a.z)); }
PTI_INLINE float pti_largest_abs(pt_vec3 a) { return pti_max(fabsf(a.x), pti_max(fabsf(a.y), fabsf(a.z))); }
static int     pti_finite3(pt_vec3 a) { return pti_finite(a.x) && pti_finite(a.y) && pti_finite(a.z); }
static int     pti_is_zero3(pt_vec3 a) { return a.x == 0 && a.y == 0 && a.z == 0; }
static float   pti_axis(pt_vec3 a, int k) { return k == 0 ? a.x : k == 1 ? a.y : a.z; }
static float   pti_luminance(pt_vec3 c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

/* Unit length, for vectors of any length but zero: very long and very short ones are scaled first, lest their squares
   overflow or vanish. Zero stays zero. */
PTI_NOINLINE pt_vec3 pti_normalize_extreme(pt_vec3 a) {
    float m = pti_largest_abs(a);
    if (!(m > 0)) return pt_v3(0, 0, 0);
    a = pt_v3(a.x / m, a.y / m, a.z / m);
    return pti_scale(a, 1 / sqrtf(pti_dot(a, a)));
}
static inline pt_vec3 pti_normalize(pt_vec3 a) {
    float l2 = pti_dot(a, a);
    return l2 > 1e-30f && l2 < 1e30f ? pti_scale(a, 1 / sqrtf(l2)) : pti_normalize_extreme(a);
}

/* Two vectors that complete the unit vector n to a right-handed orthonormal basis (t, b, n). Duff et al. 2017. */
static void pti_basis(pt_vec3 n, pt_vec3 *t, pt_vec3 *b) {
    float s = n.z >= 0 ? 1.0f : -1.0f, a = -1 / (s + n.z), c = n.x * n.y * a;
    *t = pt_v3(1 + s * n.x * n.x * a, s * c, -s * n.x);
    *b = pt_v3(c, s + n.y * n.y * a, -n.y);
}
static pt_vec3 pti_to_world(pt_vec3 t, pt_vec3 b, pt_vec3 n, pt_vec3 v) {
    return pti_madd(t, v.x, pti_madd(b, v.y, pti_scale(n, v.z)));
}

/* Affine transforms. */
static pt_xform pti_xform_or_identity(const pt_xform *x) {
    pt_xform id;
    int i, zero = 1;
    if (x) for (i = 0; i < 12; i++) zero = zero && x->m[i] == 0;
    if (!zero) return *x;
    for (i = 0; i < 12; i++) id.m[i] = i % 5 == 0 ? 1.0f : 0.0f;
    return id;
}
PTI_INLINE pt_vec3 pti_xform_vector(const pt_xform *x, pt_vec3 v) {
    const float *m = x->m;
    return pt_v3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
                 m[8] * v.x + m[9] * v.y + m[10] * v.z);
}
PTI_INLINE pt_vec3 pti_xform_point(const pt_xform *x, pt_vec3 p) {
    return pti_add(pti_xform_vector(x, p), pt_v3(x->m[3], x->m[7], x->m[11]));
}
/* Normals go by the transposed inverse, so that they stay perpendicular to what they stood on. */
static pt_vec3 pti_xform_normal(const pt_xform *inverse, pt_vec3 n) {
    const float *m = inverse->m;
    return pt_v3(m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
                 m[2] * n.x + m[6] * n.y + m[10] * n.z);
}
/* Each row of |M|, times |p|, plus |translation|: the size of the terms whose rounding makes a transformed point wrong. */
static float pti_xform_magnitude(const pt_xform *x, pt_vec3 p) {
    float r = 0;
    int i;
    for (i = 0; i < 12; i += 4)
        r = pti_max(r, fabsf(x->m[i] * p.x) + fabsf(x->m[i + 1] * p.y) + fabsf(x->m[i + 2] * p.z) + fabsf(x->m[i + 3]));
    return r;
}
static double pti_xform_det(const pt_xform *x) {
    double a[12];
    int i;
    for (i = 0; i < 12; i++) a[i] = (double)x->m[i];
    return a[0] * (a[5] * a[10] - a[6] * a[9]) - a[1] * (a[4] * a[10] - a[6] * a[8]) + a[2] * (a[4] * a[9] - a[5] * a[8]);
}
static int pti_xform_invert(const pt_xform *x, pt_xform *out) {    /* Cramer, in double; 0 if there is no inverse */
    double a[12], r[12], det = pti_xform_det(x);
    int i;
    for (i = 0; i < 12; i++) a[i] = (double)x->m[i];
    if (!(det < 0 || det > 0)) return 0;
    r[0] = a[5] * a[10] - a[6] * a[9]; r[1] = a[2] * a[9] - a[1] * a[10]; r[2] = a[1] * a[6] - a[2] * a[5];
    r[4] = a[6] * a[8] - a[4] * a[10]; r[5] = a[0] * a[10] - a[2] * a[8]; r[6] = a[2] * a[4] - a[0] * a[6];
    r[8] = a[4] * a[9] - a[5] * a[8];  r[9] = a[1] * a[8] - a[0] * a[9];  r[10] = a[0] * a[5] - a[1] * a[4];
    for (i = 0; i < 12; i++) if (i % 4 < 3) r[i] /= det;
    for (i = 0; i < 12; i += 4) r[i + 3] = -(r[i] * a[3] + r[i + 1] * a[7] + r[i + 2] * a[11]);
    for (i = 0; i < 12; i++) {
        if (!(r[i] > -1e30 && r[i] < 1e30)) return 0;
        out->m[i] = (float)r[i];
    }
    return 1;
}

/* The nearest whole number, and the one below, of what is less than 2^31: C's floor is a call. */
static int pti_nearest(double x) { return (int)(x < 0 ? x - 0.5 : x + 0.5); }
static int pti_below(float x) {
    int i = (int)x;
    return i - (x < (float)i);
}

/* sin x and cos x, |x| <= 2^20. x = k pi/2 + r with |r| <= pi/4: k picks the quadrant, r goes into the series. pi/2 is
   split in two (Cody and Waite), so that k times the first part is exact. */
static void pti_sincos_double(double x, double *sine, double *cosine) {
    int quadrant = pti_nearest(x * 0.6366197723675814);
    double k = (double)quadrant, r = (x - k * 1.5707963267341256) - k * 6.077100506506192e-11, z = r * r;
    double w = z * z;                                    /* half of each series at a time: shorter chains */
    double s = (1 + w * (1.0 / 120 + w * (1.0 / 362880 + w * (1.0 / 6227020800.0))))
             - z * (1.0 / 6 + w * (1.0 / 5040 + w * (1.0 / 39916800)));
    double c = (1 + w * (1.0 / 24 + w * (1.0 / 40320 + w * (1.0 / 479001600))))
             - z * (1.0 / 2 + w * (1.0 / 720 + w * (1.0 / 3628800 + w * (1.0 / 87178291200.0))));
    s *= r;
    switch (quadrant & 3) {
    case 0:  *sine = s;  *cosine = c;  break;
    case 1:  *sine = c;  *cosine = -s; break;
    case 2:  *sine = -s; *cosine = -c; break;
    default: *sine = -c; *cosine = s;  break;
    }
}
static void pti_sincos(float x, float *sine, float *cosine) {
    double s, c;
    pti_sincos_double((double)x, &s, &c);
    *sine = (float)s;
    *cosine = (float)c;
}

/* e^x = 2^k e^r with |r| <= ln 2 / 2. Even and odd powers wait for each other less than one long chain. */
static float pti_exp_double(double x) {
    double r, z, even, odd;
    uint64_t bits;
    int k;
    if (!(x >= -104)) return x != x ? (float)x : 0.0f;
    if (x > 88.7228391) return PTI_INF;                  /* ln of the largest float, and a half ulp */
    k = pti_nearest(x * 1.4426950408889634);
    r = x - (double)k * 0.6931471805599453;
    z = r * r;
    even = 1 + z * (1.0 / 2 + z * (1.0 / 24 + z * (1.0 / 720 + z * (1.0 / 40320 + z * (1.0 / 3628800)))));
    odd = 1 + z * (1.0 / 6 + z * (1.0 / 120 + z * (1.0 / 5040 + z * (1.0 / 362880))));
    bits = (uint64_t)(1023 + k) << 52;                   /* 2^k */
    memcpy(&z, &bits, sizeof z);
    return (float)((even + r * odd) * z);
}
static inline float pti_exp(float x) { return pti_exp_double((double)x); }

/* ln x = k ln 2 + 2 atanh((m - 1) / (m + 1)) for x = 2^k m, m in [sqrt(1/2), sqrt(2)). */
static double pti_log_double(float x) {
    double m = (double)x, s, z;
    uint64_t bits;
    int k;
    if (x < 0 || x != x) return (double)(PTI_INF - PTI_INF);
    if (x == 0 || x == PTI_INF) return x == 0 ? -HUGE_VAL : HUGE_VAL;
    memcpy(&bits, &m, sizeof bits);
    k = (int)(bits >> 52) - 1023;
    bits = (bits & 0xfffffffffffffu) | ((uint64_t)1023 << 52);
    memcpy(&m, &bits, sizeof m);
    if (m > 1.4142135623730951) { m *= 0.5; k++; }
    s = (m - 1) / (m + 1);
    z = s * s;
    return (double)k * 0.6931471805599453 + 2 * s * (1 + z * (1.0 / 3 + z * (1.0 / 5 + z * (1.0 / 7 + z * (1.0 / 9
         + z * (1.0 / 11 + z * (1.0 / 13 + z * (1.0 / 15 + z / 17))))))));
}
static inline float pti_log(float x) { return (float)pti_log_double(x); }

/* x^y for x >= 0, and 0^0 = 1. */
static float pti_pow(float x, float y) {
    if (y == 0 || x == 1) return 1;
    if (x == 0) return y > 0 ? 0.0f : PTI_INF;
    return pti_exp_double((double)y * pti_log_double(x));
}

/* The angle of the point (x, y), in (-pi, pi]. The octant is folded away, then the nearest eighth c:
   atan t = atan c + atan((t - c) / (1 + t c)). */
static double pti_atan2_double(double y, double x) {
    static const double eighth[9] = { 0, 0.12435499454676144, 0.24497866312686414, 0.35877067027057225, 0.4636476090008061,
        0.5585993153435624, 0.6435011087932844, 0.7188299996216245, 0.7853981633974483 };
    double ax = x < 0 ? -x : x, ay = y < 0 ? -y : y, t, c, z, a;
    if (x != x || y != y) return x + y;                  /* NaN */
    if (!(ax > 0 || ay > 0)) { ax = 1; ay = 0; }         /* (0, 0) looks along +x */
    t = ay < ax ? ay / ax : ax / ay;
    if (t != t) t = 1;                                   /* both infinite */
    c = (double)pti_nearest(t * 8);
    z = (t - c / 8) / (1 + t * (c / 8));
    a = eighth[(int)c] + z * (1 - z * z * (1.0 / 3 - z * z * (1.0 / 5 - z * z * (1.0 / 7 - z * z * (1.0 / 9)))));
    if (!(ay < ax)) a = 1.5707963267948966 - a;
    if (x < 0) a = 3.141592653589793 - a;
    return y < 0 ? -a : a;
}
static float pti_atan2(float y, float x) { return (float)pti_atan2_double((double)y, (double)x); }
/* acos x = 2 atan(sqrt(1 - x) / sqrt(1 + x)): no cancellation anywhere. x outside [-1, 1] counts as the nearer end. */
static double pti_acos_double(double x) {
    x = x < -1 ? -1 : x > 1 ? 1 : x;
    return 2 * pti_atan2_double(sqrt(1 - x), sqrt(1 + x));
}
static float pti_acos(float x) { return (float)pti_acos_double((double)x); }
static float pti_safe_sqrt(float x) { return x > 0 ? sqrtf(x) : 0.0f; }

/* ---- >>random ------------------------------------------------------------------------------------------
   Numbers that are a function of (seed, pixel, sample, dimension) and of nothing else. They live as 32-bit fractions
   (u32 / 2^32) until the last moment, so that one number can make several choices without running out of bits.

   Dimensions come in groups of four: one group for the pixel and the lens, one for each vertex of a path. Within a
   group the four are Sobol's first four, stratified together; between groups the order of the samples is shuffled, so
   that they are independent (padding). Every prefix of 2^k samples is stratified: progressive rendering needs no
   total. Sobol 1967; Owen 1995; hashed scrambling: Laine and Karras 2011; all of it together: Burley 2020. */

/* PCG32, O'Neill 2014: an LCG whose output is permuted by a rotation that the state's own top bits choose. */
PT_DEF uint32_t pt_rng_u32(pt_rng *r) {
    uint64_t old = r->state;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), rot = (uint32_t)(old >> 59);
    r->state = old * 6364136223846793005u + r->inc;
    return (x >> rot) | (x << ((32 - rot) & 31));
}
PT_DEF void pt_rng_seed(pt_rng *r, uint64_t seed, uint64_t stream) {
    r->state = 0;
    r->inc = stream << 1 | 1;
    pt_rng_u32(r);
    r->state += seed;
    pt_rng_u32(r);
}
static float pti_u01(uint32_t u) { return (float)(u >> 8) * (1.0f / 16777216); }     /* [0,1), exact */
PT_DEF float pt_rng_float(pt_rng *r) { return pti_u01(pt_rng_u32(r)); }

/* A bijective mixer of 32 bits (Wellons 2018, "lowbias32"), and a hash of two numbers by it. */
static uint32_t pti_hash(uint32_t x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}
static uint32_t pti_hash2(uint32_t a, uint32_t b) { return pti_hash(a ^ (pti_hash(b) + 0x9e3779b9u)); }

static uint32_t pti_reverse_bits(uint32_t x) {
    x = pti_reverse_bytes(x);
    x = (x & 0x0f0f0f0fu) << 4 | (x & 0xf0f0f0f0u) >> 4;
    x = (x & 0x33333333u) << 2 | (x & 0xccccccccu) >> 2;
    return (x & 0x55555555u) << 1 | (x & 0xaaaaaaaau) >> 1;
}
/* Owen's scramble flips every bit of a fraction at random, by a coin that depends on all the bits above it. With the bits
   reversed, "above" becomes "below", and that is how carries run in additions and multiplications: these five steps
   (Laine and Karras's idea, Vegdahl's 2021 constants) are such a scramble. */
static uint32_t pti_scramble_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Sobol's first four dimensions of the index, bits reversed (bit 0 is the half, bit 1 the quarter ...). The generator
   matrix of dimension 0 is the identity; that of 1 is Pascal's triangle mod 2, which is the substitution of x + 1 for x
   in a polynomial over GF(2), done by halves; 2 and 3 are tables (primitive polynomials x^2+x+1 and x^3+x+1, Joe and
   Kuo 2008). */
static uint32_t pti_sobol_reversed(uint32_t i, int dimension) {
    static const uint32_t matrix[2][32] = {
        { 0x00000001u, 0x00000003u, 0x00000006u, 0x00000009u, 0x00000017u, 0x0000003au, 0x00000071u, 0x000000a3u,
          0x00000116u, 0x00000339u, 0x00000677u, 0x000009aau, 0x00001601u, 0x00003903u, 0x00007706u, 0x0000aa09u,
          0x00010117u, 0x0003033au, 0x00060671u, 0x000909a3u, 0x00171616u, 0x003a3939u, 0x00717777u, 0x00a3aaaau,
          0x01170001u, 0x033a0003u, 0x06710006u, 0x09a30009u, 0x16160017u, 0x3939003au, 0x77770071u, 0xaaaa00a3u },
        { 0x00000001u, 0x00000003u, 0x00000004u, 0x0000000au, 0x0000001fu, 0x0000002eu, 0x00000045u, 0x000000c9u,
          0x0000011bu, 0x000002a4u, 0x0000079au, 0x00000b67u, 0x0000101eu, 0x0000302du, 0x00004041u, 0x0000a0c3u,
          0x0001f104u, 0x0002e28au, 0x000457dfu, 0x000c9baeu, 0x0011a105u, 0x002a7289u, 0x0079e7dbu, 0x00b6dba4u,
          0x0100011au, 0x030002a7u, 0x0400079eu, 0x0a000b6du, 0x1f001001u, 0x2e003003u, 0x45004004u, 0xc900a00au } };
    uint32_t r = 0;
    int k;
    if (dimension == 0) return i;
    if (dimension == 1) {
        i ^= i >> 16;
        i ^= i >> 8 & 0x00ff00ffu;
        i ^= i >> 4 & 0x0f0f0f0fu;
        i ^= i >> 2 & 0x33333333u;
        return i ^ (i >> 1 & 0x55555555u);
    }
    for (k = 0; k < 32; k++) r ^= matrix[dimension - 2][k] & (0u - (i >> k & 1));
    return r;
}

/* A permutation of 0 .. n-1, chosen by seed: mix reversibly within the next power of two, again until the result is below
   n (cycle walking, Black and Rogaway 2002; for sampling: Kensler 2013). */
static uint32_t pti_permute(uint32_t i, uint32_t n, uint32_t seed) {
    uint32_t mask = n - 1, half;
    int k, bits = 0;
    for (k = 16; k > 0; k >>= 1) if (mask >> bits >> k) bits += k;
    bits++;                                              /* 1 + log2 of n - 1 */
    mask = bits == 32 ? 0xffffffffu : (1u << bits) - 1;
    half = (uint32_t)(bits + 1) / 2;
    do {
        for (k = 0; k < 6; k++) {                        /* fewer rounds, or one factor for all, show in small n */
            uint32_t h = pti_hash2(seed, (uint32_t)k);
            i = ((i + h) * (h >> 16 | 1)) & mask;
            i ^= i >> half;
        }
    } while (i >= n);
    return i;
}

/* One sample of one pixel. */
typedef struct pti_sampler {
    pt_sampler kind;
    uint32_t pixel_seed, index, reversed;                /* reversed: the index's bits */
    uint32_t strata_x, strata_y;                         /* PT_SAMPLER_STRATIFIED: cells of one pass */
} pti_sampler;

/* A generator for one sample. Hashed, since PCG32's streams next to each other are related: neither pair nor index may be
   the stream as it is. */
static pt_rng pti_sample_rng(uint32_t seed, uint32_t index) {
    pt_rng rng;
    pt_rng_seed(&rng, (uint64_t)seed << 32 | pti_hash2(seed, index), 0);
    return rng;
}
static void pti_sampler_start(pti_sampler *s, uint32_t index) {
    s->index = index;
    s->reversed = pti_reverse_bits(index);
}
/* Sobol's number of a dimension for the shuffled index, scrambled. */
static uint32_t pti_sobol_number(uint32_t index, int dimension, uint32_t seed) {
    static const uint32_t inner[4] = { 0x9e3779b9u, 0x06c10a79u, 0x6f4a9b3au, 0xf2296396u };     /* pti_hash2's part of k */
    uint32_t x = pti_sobol_reversed(index, dimension);
    return pti_reverse_bits(pti_scramble_reversed(x, pti_hash(seed ^ inner[dimension])));
}
/* Two numbers of a group of four: pair 0 or pair 1. */
static void pti_draw2(const pti_sampler *s, uint32_t group, int pair, uint32_t u[2]) {
    uint32_t seed = pti_hash2(s->pixel_seed, group), index, cells;
    pt_rng rng;
    switch (s->kind) {
    case PT_SAMPLER_SOBOL:
        index = pti_reverse_bits(pti_scramble_reversed(s->reversed, seed));      /* shuffled */
        u[0] = pti_sobol_number(index, 2 * pair, seed);
        u[1] = pti_sobol_number(index, 2 * pair + 1, seed);
        break;
    case PT_SAMPLER_STRATIFIED:
        cells = s->strata_x * s->strata_y;
        seed = pti_hash2(pti_hash2(seed, (uint32_t)pair), s->index / cells);                   /* a pass has its own */
        index = pti_permute(s->index % cells, cells, seed);
        rng = pti_sample_rng(seed, s->index);
        u[0] = (uint32_t)(((uint64_t)(index % s->strata_x) << 32 | pt_rng_u32(&rng)) / s->strata_x);
        u[1] = (uint32_t)(((uint64_t)(index / s->strata_x) << 32 | pt_rng_u32(&rng)) / s->strata_y);
        break;
    default:
        rng = pti_sample_rng(pti_hash2(seed, (uint32_t)pair), s->index);
        u[0] = pt_rng_u32(&rng);
        u[1] = pt_rng_u32(&rng);
    }
}

/* The first of pair 0, where the other is not wanted. */
static uint32_t pti_draw1(const pti_sampler *s, uint32_t group) {
    uint32_t seed = pti_hash2(s->pixel_seed, group), u[2];
    if (s->kind == PT_SAMPLER_SOBOL)
        return pti_sobol_number(pti_reverse_bits(pti_scramble_reversed(s->reversed, seed)), 0, seed);
    pti_draw2(s, group, 0, u);
    return u[0];
}

/* A coin with P(1) = w that leaves *u uniform again, for the next choice: R < w ? R / w : (R - w) / (1 - w), in integers.
   The bits that the division would leave empty are filled with fresh ones. */
static int pti_split(uint32_t *u, float w) {
    uint64_t cut = w >= 1 ? (uint64_t)1 << 32 : w > 0 ? (uint64_t)((double)w * 4294967296.0) : 0;
    uint64_t low = pti_hash(*u ^ 0x5bd1e995u);
    if (*u < cut) {
        if (cut >> 32 == 0) *u = (uint32_t)(((uint64_t)*u << 32 | low) / cut);
        return 1;
    }
    if (cut) *u = (uint32_t)(((uint64_t)(*u - (uint32_t)cut) << 32 | low) / (((uint64_t)1 << 32) - cut));
    return 0;
}

/* ---- >>warp --------------------------------------------------------------------------------------------
   Maps from the unit square to the places a path may go, each with the density of where it lands beside it. Directions
   are about +z unless a normal is given; densities are per steradian (per unit area for the disk). */

/* Unit disk, concentric (Shirley and Chiu 1997): squares about the middle become circles, so strata keep their shape. */
static void pti_sample_disk(float u, float v, float *x, float *y) {
    float a = 2 * u - 1, b = 2 * v - 1, r, phi, s, c;
    if (a == 0 && b == 0) { *x = *y = 0; return; }
    if (a * a > b * b) { r = a; phi = (PTI_PI / 4) * (b / a); }
    else               { r = b; phi = (PTI_PI / 2) - (PTI_PI / 4) * (a / b); }
    pti_sincos(phi, &s, &c);
    *x = r * c;
    *y = r * s;
}
static inline float pti_pdf_disk(void) { return 1 / PTI_PI; }

/* Hemisphere, p = cos / pi: a disk lifted up (Malley). */
static pt_vec3 pti_sample_cosine(float u, float v) {
    float x, y;
    pti_sample_disk(u, v, &x, &y);
    return pt_v3(x, y, pti_safe_sqrt(1 - x * x - y * y));
}
static float pti_pdf_cosine(float cosine) { return cosine > 0 ? cosine * (1 / PTI_PI) : 0.0f; }

/* Cone about +z with 1 - cos of its half angle given (as such, since for narrow cones the cosine is all rounding); the
   whole sphere is 2, the hemisphere 1. The cap's height is uniform in area (Archimedes). */
static pt_vec3 pti_sample_cone(float one_minus_cos, float u, float v) {
    float h = u * one_minus_cos, r = pti_safe_sqrt(h * (2 - h)), s, c;    /* h = 1 - cos, r = sin */
    pti_sincos(2 * PTI_PI * v, &s, &c);
    return pt_v3(r * c, r * s, 1 - h);
}
/* About any axis; by |wi - axis|^2 = 2 (1 - cos), which does not cancel. */
static pt_vec3 pti_sample_cone_about(pt_vec3 axis, float one_minus_cos, float u, float v) {
    pt_vec3 t, b;
    pti_basis(axis, &t, &b);
    return pti_normalize(pti_to_world(t, b, axis, pti_sample_cone(one_minus_cos, u, v)));
}
static int pti_in_cone(pt_vec3 axis, float one_minus_cos, pt_vec3 wi) {
    pt_vec3 d = pti_sub(wi, axis);
    return one_minus_cos >= 2 || pti_dot(d, d) <= 2 * one_minus_cos;
}
static float pti_pdf_cone(float one_minus_cos) { return 1 / (2 * PTI_PI * one_minus_cos); }

static inline pt_vec3 pti_sample_hemisphere(float u, float v) { return pti_sample_cone(1, u, v); }
static inline float pti_pdf_hemisphere(float cosine) { return cosine > 0 ? 1 / (2 * PTI_PI) : 0.0f; }
static inline pt_vec3 pti_sample_sphere(float u, float v) { return pti_sample_cone(2, u, v); }
static inline float pti_pdf_sphere(void) { return 1 / (4 * PTI_PI); }

/* A spherical triangle: a, b, c are unit directions to its corners. Its solid angle (Van Oosterom and Strackee 1983):
   tan(S/2) = |a . b x c| / (1 + a.b + b.c + c.a). The determinant is taken from edges, which keeps small ones exact. */
static float pti_triangle_solid_angle(pt_vec3 a, pt_vec3 b, pt_vec3 c) {
    float det = fabsf(pti_dot(a, pti_cross(pti_sub(b, a), pti_sub(c, a))));
    return 2 * pti_atan2(det, 1 + pti_dot(a, b) + pti_dot(b, c) + pti_dot(c, a));
}
/* Uniform over it, S its solid angle (Arvo 1995): u cuts off a sub-triangle of area A = u S by an arc from b, v goes along
   that arc. The arc meets the side a c where, alpha being the angle at a,
       tan(A/2) = t t' sin alpha / (1 + t t' cos alpha)  for the tangents t, t' of the half sides:
       t' = sin(A/2) / (t sin(alpha - A/2)).
   In half angles and from edges (b - a is exact when they are close), nothing cancels in small triangles. */
static pt_vec3 pti_perpendicular(pt_vec3 n, pt_vec3 d) {           /* of the unit vector n + d, what is perpendicular to n */
    d = pti_madd(n, 0.5f * pti_dot(d, d), d);
    return pti_madd(n, -pti_dot(n, d), d);               /* again, where n + d is nearly -n */
}
static pt_vec3 pti_sample_triangle(pt_vec3 a, pt_vec3 b, pt_vec3 c, float S, float u, float v) {
    pt_vec3 ab = pti_sub(b, a), ac = pti_sub(c, a), side_b = pti_perpendicular(a, ab), side_c = pti_perpendicular(a, ac), d;
    float y = fabsf(pti_dot(a, pti_cross(ab, ac))), x = pti_dot(side_b, side_c), r = sqrtf(x * x + y * y);
    float s, t, h, sine, cosine;
    pti_sincos(0.5f * u * S, &sine, &cosine);
    s = sine * r * pti_length(pti_add(a, b));            /* t' = s / t; both times r, and t = |b - a| / |a + b| */
    t = pti_max(y * cosine - x * sine, 0) * pti_length(ab);
    h = s * s + t * t;
    d = pti_sub(pti_scale(pti_normalize(side_c), t), pti_scale(a, s));
    d = pti_sub(pti_scale(d, h > 0 ? 2 * s / h : 0.0f), ab);       /* from b to the end of the arc */
    h = 0.5f * v * pti_dot(d, d);                        /* 1 - cos of the angle from b */
    d = pti_scale(pti_normalize(pti_perpendicular(b, d)), pti_safe_sqrt(h * (2 - h)));
    return pti_madd(b, 1 - h, d);
}
static float pti_pdf_triangle(float S) { return 1 / S; }

/* A rectangle as seen from the origin of a frame whose x and y run along its edges: it spans [x0, x1] x [y0, y1] in the
   plane z = z0 < 0. In double: the solid angle of a small one is a difference of large angles. */
typedef struct pti_rect_frame { pt_vec3 x, y, z; float width, height; } pti_rect_frame;
typedef struct pti_rect { const pti_rect_frame *frame; double x0, x1, y0, y1, z0, flip; } pti_rect;

static pti_rect_frame pti_rect_frame_of(pt_vec3 edge_x, pt_vec3 edge_y) {
    pti_rect_frame f;
    f.width = pti_length(edge_x);
    f.height = pti_length(edge_y);
    f.x = pti_scale(edge_x, 1 / pti_max(f.width, 1e-30f));
    f.y = pti_scale(edge_y, 1 / pti_max(f.height, 1e-30f));
    f.z = pti_cross(f.x, f.y);
    return f;
}
static pti_rect pti_rect_seen_from(const pti_rect_frame *f, pt_vec3 to_corner) {
    pti_rect r;
    r.frame = f;
    r.x0 = (double)pti_dot(to_corner, f->x); r.x1 = r.x0 + (double)f->width;
    r.y0 = (double)pti_dot(to_corner, f->y); r.y1 = r.y0 + (double)f->height;
    r.z0 = (double)pti_dot(to_corner, f->z);
    r.flip = r.z0 > 0 ? -1 : 1;
    r.z0 *= r.flip;
    return r;
}
/* The quarter plane beyond a corner (x, y) has the solid angle atan2(x y, -z |corner|), up to what cancels between the four
   corners. Angles add up when complex numbers are multiplied, so one atan2 does for all. */
static float pti_rect_solid_angle(const pti_rect *r) {
    double re = 1, im = 0;
    int k;
    for (k = 0; k < 4; k++) {
        double x = k & 1 ? r->x1 : r->x0, y = k & 2 ? r->y1 : r->y0, sign = k == 1 || k == 2 ? -1 : 1;
        double a = -r->z0 * sqrt(x * x + y * y + r->z0 * r->z0), b = sign * x * y, t = re * a - im * b;
        im = re * b + im * a;
        re = t;
    }
    re = pti_atan2_double(im, re);
    return (float)(re < -1e-12 ? re + 6.283185307179586 : re > 0 ? re : 0);    /* a far rectangle may be 0 less a rounding */
}
/* Uniform over it, S its solid angle (Urena, Fajardo and King 2013): u fixes x, so that the strip from x0 to it has area
   u S; v goes along y. b0, b1 and bx are the z of the normals of the planes through the eye and the edges y0, y1 and x0;
   g2 and g3 are the angles between those planes, which enter only through the sine and cosine of their sum. The
   direction is not normalised. */
static pt_vec3 pti_sample_rect(const pti_rect *r, float S, float u, float v) {
    double x0 = r->x0, y0 = r->y0, y1 = r->y1, z2 = r->z0 * r->z0;
    double lx = sqrt(x0 * x0 + z2), l0 = sqrt(y0 * y0 + z2), l1 = sqrt(y1 * y1 + z2);
    double b0 = -y0 / l0, b1 = y1 / l1, bx = -x0 / lx;
    double c2 = -b1 * bx, s2 = -r->z0 * sqrt(x0 * x0 + y1 * y1 + z2) / (lx * l1);
    double c3 = -bx * b0, s3 = -r->z0 * sqrt(x0 * x0 + y0 * y0 + z2) / (lx * l0);
    double cg = c2 * c3 - s2 * s3, sg = s2 * c3 + c2 * s3, s, c, f, cu, x, d, h0, h1, h, y;
    pti_sincos_double((double)u * (double)S, &s, &c);
    f = s * cg - c * sg;                                 /* sin(u S - g2 - g3) */
    c = c * cg + s * sg;
    f = f != 0 ? (c * b0 - b1) / f : 0.0;
    cu = 1 / sqrt(f * f + b0 * b0);
    if (f < 0) cu = -cu;
    cu = cu > 1 ? 1 : cu < -1 ? -1 : cu;
    x = -(cu * r->z0) / sqrt(1 - cu * cu > 1e-15 ? 1 - cu * cu : 1e-15);
    x = x < x0 ? x0 : x > r->x1 ? r->x1 : x;
    d = sqrt(x * x + z2);
    h0 = y0 / sqrt(d * d + y0 * y0);
    h1 = y1 / sqrt(d * d + y1 * y1);
    h = h0 + (double)v * (h1 - h0);
    y = h * h < 1 - 1e-12 ? h * d / sqrt(1 - h * h) : y1;
    return pti_to_world(r->frame->x, r->frame->y, r->frame->z, pt_v3((float)x, (float)y, (float)(r->z0 * r->flip)));
}
static float pti_pdf_rect(float S) { return 1 / S; }


/* Piecewise-constant densities on [0,1] and [0,1]^2, by inversion of the running sum (never alias tables, which would tear
   the strata apart). A table of n cells has n + 1 entries from 0 to 1. A density is read off the same table that draws,
   so the two agree to the bit. */
static void pti_table_build(float *table, const float *value, int n) {
    double sum = 0, run = 0;
    int i;
    for (i = 0; i < n; i++) sum += (double)value[i];
    for (i = 0; i < n; i++) {
        table[i] = (float)(sum > 0 ? run / sum : (double)i / n);
        run += (double)value[i];
    }
    table[n] = 1;
}
static int pti_table_find(const float *table, int n, float u) {      /* the cell with table[i] <= u < table[i + 1] */
    int lo = 0, hi = n;
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (table[mid] <= u) lo = mid; else hi = mid;
    }
    return lo;
}
static float pti_sample_table(const float *table, int n, float u, int *cell) {         /* in [0,1) */
    int i = pti_table_find(table, n, u);
    float x = ((float)i + (u - table[i]) / (table[i + 1] - table[i])) / (float)n;
    *cell = i;
    if (!(x < 1) || (int)(x * (float)n) != i) x = ((float)i + 0.5f) / (float)n;    /* rounded into a neighbour: the middle */
    return x;
}
static float pti_pdf_table(const float *table, int n, int cell) { return (table[cell + 1] - table[cell]) * (float)n; }

/* In two dimensions: a table of rows, and one of cells for each row. */
typedef struct pti_table2 { float *rows, *cells; int width, height; } pti_table2;
static const float *pti_table2_row(const pti_table2 *t, int y) {
    return t->cells + (size_t)y * ((size_t)t->width + 1);
}
static void pti_sample_table2(const pti_table2 *t, float u, float v, float *x, float *y) {
    int cell, row;
    *y = pti_sample_table(t->rows, t->height, v, &row);
    *x = pti_sample_table(pti_table2_row(t, row), t->width, u, &cell);
}
static float pti_pdf_table2(const pti_table2 *t, float x, float y) {
    int cell = (int)(x * (float)t->width), row = (int)(y * (float)t->height);
    cell = cell < 0 ? 0 : cell >= t->width ? t->width - 1 : cell;
    row = row < 0 ? 0 : row >= t->height ? t->height - 1 : row;
    return pti_pdf_table(t->rows, t->height, row) * pti_pdf_table(pti_table2_row(t, row), t->width, cell);
}

/* ---- >>spectrum ----------------------------------------------------------------------------------------
   A path that meets glass whose index depends on the wavelength draws one wavelength, takes its colour c / p, and keeps to
   it: the mean of c / p is white, so a rainbow costs only those who look at it. c(lambda) are the CIE 1931 functions (the fits of
   Wyman, Sloan and Shirley 2013) as linear RGB; what is negative there, since no screen shows a pure spectral green, is cut
   off, and each channel is scaled to have the mean 1. p is in proportion to r + g + b. */
#define PTI_WAVELENGTHS 64
#define PTI_SHORTEST 390.0f                              /* nm */
#define PTI_LONGEST 710.0f
typedef struct pti_spectrum { float table[PTI_WAVELENGTHS + 1]; pt_vec3 color[PTI_WAVELENGTHS]; } pti_spectrum;

static float pti_bell(float x, float middle, float left, float right) {
    float t = (x - middle) / (x < middle ? left : right);
    return pti_exp(-0.5f * t * t);
}
/* XYZ to linear RGB with Rec. 709 primaries and a D65 white. */
static void pti_rgb_of_xyz(double v[3]) {
    double x = v[0], y = v[1], z = v[2];
    v[0] =  3.2404541621141054 * x - 1.5371385127977166 * y - 0.4985314095560162 * z;
    v[1] = -0.9692660305051868 * x + 1.8760108454466942 * y + 0.0415560175303498 * z;
    v[2] =  0.0556434309591147 * x - 0.2040259135167538 * y + 1.0572251882231791 * z;
}
static pt_vec3 pti_wavelength_color(float nm) {
    double v[3];
    v[0] = (double)(1.056f * pti_bell(nm, 599.8f, 37.9f, 31.0f) + 0.362f * pti_bell(nm, 442.0f, 16.0f, 26.7f)
                  - 0.065f * pti_bell(nm, 501.1f, 20.4f, 26.2f));
    v[1] = (double)(0.821f * pti_bell(nm, 568.8f, 46.9f, 40.5f) + 0.286f * pti_bell(nm, 530.9f, 16.3f, 31.1f));
    v[2] = (double)(1.217f * pti_bell(nm, 437.0f, 11.8f, 36.0f) + 0.681f * pti_bell(nm, 459.0f, 26.0f, 13.8f));
    pti_rgb_of_xyz(v);
    return pti_max3(pt_v3((float)v[0], (float)v[1], (float)v[2]), pt_v3(0, 0, 0));
}
static void pti_spectrum_build(pti_spectrum *s) {
    pt_vec3 sum = pt_v3(0, 0, 0);
    float p[PTI_WAVELENGTHS];
    int i;
    for (i = 0; i < PTI_WAVELENGTHS; i++) {
        s->color[i] = pti_wavelength_color(PTI_SHORTEST + (PTI_LONGEST - PTI_SHORTEST) * ((float)i + 0.5f) / PTI_WAVELENGTHS);
        sum = pti_add(sum, pti_scale(s->color[i], 1.0f / PTI_WAVELENGTHS));
    }
    for (i = 0; i < PTI_WAVELENGTHS; i++) {
        s->color[i] = pt_v3(s->color[i].x / sum.x, s->color[i].y / sum.y, s->color[i].z / sum.z);
        p[i] = s->color[i].x + s->color[i].y + s->color[i].z;
    }
    pti_table_build(s->table, p, PTI_WAVELENGTHS);
}
/* A wavelength in nm, and c / p. */
static float pti_sample_wavelength(const pti_spectrum *s, float u, pt_vec3 *weight) {
    int cell;
    float x = pti_sample_table(s->table, PTI_WAVELENGTHS, u, &cell);
    *weight = pti_scale(s->color[cell], 1 / pti_pdf_table(s->table, PTI_WAVELENGTHS, cell));
    return PTI_SHORTEST + (PTI_LONGEST - PTI_SHORTEST) * x;
}

/* ---- >>shape -------------------------------------------------------------------------------------------
   What a ray can hit. Meshes are rows of triangles (quads and boxes are small meshes); spheres, instances and users'
   shapes are single objects. Each primitive has an id: the shapes number theirs one after the other, and where two hits
   have the same t, the lower id wins, so that the order of visits never shows. */

typedef enum pti_shape_kind { PTI_MESH, PTI_SPHERE, PTI_INSTANCE, PTI_USER } pti_shape_kind;

typedef struct pti_mesh {
    const float *positions, *normals, *uvs;
    const uint32_t *indices;                             /* or NULL */
    uint32_t *materials;                                 /* of the scene, one a triangle; or NULL: all the shape's */
    size_t stride, vertex_count;
    int owned, quads;                                    /* quads: triangles 2k and 2k + 1 are a parallelogram */
    int box;                                             /* pt_add_box made it; -1: mirrored */
} pti_mesh;
typedef struct pti_sphere { pt_vec3 center; float radius; } pti_sphere;
typedef struct pti_instance {
    const struct pti_geometry *of;
    const pt_scene *scene;
    pt_xform to_world, to_local;                         /* of a moving one: at time 0 */
    pt_xform *to_world_end;                              /* at time 1; NULL = it stands still */
} pti_instance;
typedef struct pti_user { pt_shape_vtable vtable; void *user; pt_vec3 lo, hi; } pti_user;

typedef struct pti_shape {
    pti_shape_kind kind;
    uint32_t first, count;                               /* ids of its primitives: first ... first + count - 1 */
    uint32_t material;
    int bounds_only;                                     /* of a volume: rays do not meet it */
    union { pti_mesh mesh; pti_sphere sphere; pti_instance instance; pti_user user; } as;
} pti_shape;
static uint32_t pti_shape_material(const pti_shape *s, uint32_t prim) {
    return s->kind == PTI_MESH && s->as.mesh.materials ? s->as.mesh.materials[prim] : s->material;
}

/* All floats that a hit's position is made of carry relative errors of 2^-24 each. Eight of them, a bound that
   tests/test_shape.c holds, tell how far a hit may lie from its surface, and how far above it the next ray starts: the
   idea of Waechter and Binder 2019, with the ulps taken at the largest number that went into the hit, since 256 ulps of
   the position itself are too few near the origin of a large triangle and too many elsewhere. */
#define PTI_ULPS_8 (8.0f / 16777216)

typedef struct pti_bounds { pt_vec3 lo, hi; } pti_bounds;
static pti_bounds pti_bounds_empty(void) {
    pti_bounds b;
    b.lo = pt_v3(FLT_MAX, FLT_MAX, FLT_MAX);
    b.hi = pti_neg(b.lo);
    return b;
}
static void pti_bounds_point(pti_bounds *b, pt_vec3 p) { b->lo = pti_min3(b->lo, p); b->hi = pti_max3(b->hi, p); }
static void pti_bounds_merge(pti_bounds *b, const pti_bounds *c) {
    b->lo = pti_min3(b->lo, c->lo);
    b->hi = pti_max3(b->hi, c->hi);
}
static void pti_bounds_pad(pti_bounds *b, float d) {
    b->lo = pti_sub(b->lo, pt_v3(d, d, d));
    b->hi = pti_add(b->hi, pt_v3(d, d, d));
}
static float pti_bounds_area(const pti_bounds *b) {      /* half of it: all that the surface area heuristic needs */
    pt_vec3 d = pti_sub(b->hi, b->lo);
    return d.x >= 0 ? d.x * d.y + d.y * d.z + d.z * d.x : 0.0f;
}

/* A moving instance at a time: the transform is interpolated, then inverted as that of one that stands still. */
static pt_xform pti_xform_between(const pt_xform *a, const pt_xform *b, float t) {
    pt_xform x;
    int i;
    t = t > 0 ? pti_min(t, 1) : 0.0f;                    /* NaN is 0 */
    for (i = 0; i < 12; i++) x.m[i] = (1 - t) * a->m[i] + t * b->m[i];
    return x;
}
PTI_NOINLINE int pti_instance_move(const pti_instance *in, float time, pti_instance *out) {        /* 0: no inverse */
    *out = *in;
    out->to_world = pti_xform_between(&in->to_world, in->to_world_end, time);
    return pti_xform_invert(&out->to_world, &out->to_local);
}
/* The instance as it is at a time; *moved is room for one. */
static const pti_instance *pti_instance_at(const pti_instance *in, float time, pti_instance *moved) {
    if (!in->to_world_end) return in;
    pti_instance_move(in, time, moved);
    return moved;
}

/* A ray, prepared once for all its tests. */
#define PTI_WIDTH 8                                      /* children of a node */
#define PTI_ROW (PTI_WIDTH * sizeof(float))              /* of its planes: low x of all, high x, low y ... */
#define PTI_LANES 4                                      /* triangles in a packet */
#define PTI_WIDEN (1 + 2 * PTI_ULPS_8)
/* Where a node's nearer and farther planes along x, y and z are, in bytes, for rays of each octant (1: x falls, 2: y, 4: z; where a
   ray does not move, it does not fall). */
typedef struct pti_rows { size_t near_at[3], far_at[3]; } pti_rows;
#define PTI_ROWS(x, y, z) { { x * PTI_ROW, (2 + y) * PTI_ROW, (4 + z) * PTI_ROW }, \
                            { (1 - x) * PTI_ROW, (3 - y) * PTI_ROW, (5 - z) * PTI_ROW } }
static const pti_rows pti_octants[8] = { PTI_ROWS(0, 0, 0), PTI_ROWS(1, 0, 0), PTI_ROWS(0, 1, 0), PTI_ROWS(1, 1, 0),
                                         PTI_ROWS(0, 0, 1), PTI_ROWS(1, 0, 1), PTI_ROWS(0, 1, 1), PTI_ROWS(1, 1, 1) };
typedef struct pti_ray {                                 /* fours first: compilers put it at a multiple of 16, and none then lies
                                                            across two lines of the cache */
    float near_inverse[4], near_add[4];                  /* boxes: t = plane * inverse + add; four for arithmetic on all at once */
    float far_inverse[4], far_add[4];
    float org[4], dir[4];
    const pti_rows *rows;
    size_t octant;
    size_t kx, ky, kz;                                   /* triangles: rows of a packet such that |dir| along kz is largest */
    float ox, oy, oz, sx, sy, sz;                        /* the origin along them, and the shear that makes the ray +z */
    float tmin, time;
} pti_ray;

/* Boxes: (plane - org) / dir, turned into one multiply-add. Every rounding on the way is at most a few 2^-24 of |t| or of
   |org / dir|; adding eight of the latter here, and widening t where the ray leaves a box or ends, makes the test conservative
   (Ize 2013): it never misses a box where the ray meets the triangle (that rounding may move t is pti_bvh_slack's). They are those
   of the largest |org|: in an instance that is turned, all its coordinates round together. Along an axis where the ray does not
   move, all is decided by a slope so steep that the box is met everywhere or nowhere, but for boxes within 1e-8 m, or that
   rounding, of the origin. Boxes are left later still, by `later`: a length along the ray's longest axis to pti_ray_prepare, then a
   t. */
static void pti_ray_slow_axis(pti_ray *r, int k, float largest, float later) {
    float d = r->dir[k], offset, pad, inverse, farthest = pti_largest_abs(pt_v3(r->org[0], r->org[1], r->org[2]));
    int moves = fabsf(d) > largest * 1e-21f;             /* by 1e-8 m on a way of 1e13, the longest there is */
    inverse = 1 / (moves ? d : largest * 1e-26f);        /* else as if by 1e-13 m */
    offset = r->org[k] * inverse;
    pad = PTI_ULPS_8 * farthest * fabsf(inverse) + (moves ? 0.0f : inverse * 1e-8f);
    r->near_inverse[k] = inverse;
    r->near_add[k] = -offset - pad;
    r->far_inverse[k] = inverse * PTI_WIDEN;
    r->far_add[k] = (-offset + pad) * PTI_WIDEN + later;
    r->octant = (r->octant & ~((size_t)1 << k)) | (size_t)(inverse < 0) << k;
    if (fabsf(offset) < 1e38f && fabsf(inverse) < 1e38f && pad < 1e38f) return;
    r->near_inverse[k] = r->far_inverse[k] = 0;          /* next to infinity: all slabs are met */
    r->near_add[k] = -FLT_MAX;
    r->far_add[k] = FLT_MAX;
}
PTI_INLINE void pti_ray_prepare(pti_ray *r, pt_vec3 org, pt_vec3 dir, float tmin, float time, float later) {
    static const size_t steepest[4] = { 0, 1, 0, 2 };    /* bit 0: |x| is below the largest; bit 1: |y| is */
    static const size_t axes[5] = { 0, 1, 2, 0, 1 };
    float ax = fabsf(dir.x), ay = fabsf(dir.y), az = fabsf(dir.z), far_off = pti_largest_abs(org);
    float largest = pti_max(ax, pti_max(ay, az)), least = pti_min(ax, pti_min(ay, az));
    pti_f4 from = pti_f4_of(org.x, org.y, org.z, 0), to = pti_f4_of(dir.x, dir.y, dir.z, 1), zero = pti_f4_set(0);
    pti_f4 less = pti_f4_sub(pti_f4_max(to, pti_f4_sub(zero, to)), pti_f4_set(largest));
    size_t z = steepest[pti_f4_negative(less) & 3], x = axes[z + 1], y = axes[z + 2];
    pti_f4 inverse = pti_f4_div(pti_f4_set(1), to), minus = pti_f4_sub(zero, pti_f4_mul(from, inverse));
    pti_f4 pad = pti_f4_mul(pti_f4_max(inverse, pti_f4_sub(zero, inverse)), pti_f4_set(PTI_ULPS_8 * far_off));
    pti_f4 widen = pti_f4_set(PTI_WIDEN);
    int k;
    pti_f4_store(r->org, from);
    pti_f4_store(r->dir, to);
    pti_f4_store(r->near_inverse, inverse);
    pti_f4_store(r->near_add, pti_f4_sub(minus, pad));
    pti_f4_store(r->far_inverse, pti_f4_mul(inverse, widen));
    r->kx = x * PTI_LANES; r->ky = y * PTI_LANES; r->kz = z * PTI_LANES;
    r->ox = r->org[x]; r->oy = r->org[y]; r->oz = r->org[z];
    r->sz = r->near_inverse[z];
    r->sx = r->dir[x] * r->sz; r->sy = r->dir[y] * r->sz;
    later *= fabsf(r->sz);
    pti_f4_store(r->far_add, pti_f4_add(pti_f4_mul(pti_f4_add(minus, pad), widen), pti_f4_set(later)));
    r->octant = pti_f4_negative(to);
    r->tmin = pti_max(tmin, 0);
    r->time = time;
    if (!(least > largest * 1e-21f && least * 1e37f > pti_max(far_off, 1)))
        for (k = 0; k < 3; k++) pti_ray_slow_axis(r, k, largest, later);
    r->rows = pti_octants + r->octant;
}

/* A hit on its way to becoming a pt_vertex. Ties in t are decided by the ids in the outer, then in the inner scene. */
typedef struct pti_hit {
    float t;
    int found;                                           /* between t and u, so that compilers do not join their stores: t is needed
                                                            at once, u only after a division */
    float u, v;                                          /* barycentric on a triangle; the user's own on his shapes */
    uint32_t outer, prim;                                /* ids; outer = prim outside instances */
    uint32_t shape, instance;                            /* 1 + index. shape is 0 on triangles until it is looked up */
    pt_vec3 ng;                                          /* user shapes only */
} pti_hit;
static int pti_closer(const pti_hit *h, float t, uint32_t outer, uint32_t prim) {
    if (t != h->t) return t < h->t;
    return h->found && (outer < h->outer || (outer == h->outer && prim < h->prim));
}

/* Four triangles side by side: v[corner][axis][lane]. Unused lanes are NaN, which nothing hits. */
typedef struct pti_packet { float v[3][3][PTI_LANES]; uint32_t prim[PTI_LANES]; } pti_packet;
PTI_INLINE const float *pti_packet_row(const pti_packet *p, int corner, size_t row) {
    return (const float *)(const void *)p + 3 * PTI_LANES * corner + row;
}

/* Watertight ray-triangle test (Woop, Benthin and Wald 2013). The corners are moved and sheared so that the ray becomes
   the z axis; then the signs of
       U = cx by - cy bx,   V = ax cy - ay cx,   W = bx ay - by ax
   tell on which side of each edge it passes. Two triangles that share an edge compute the same number for it but for the
   sign, since each product is rounded alone: no ray falls between them. A zero may be nothing but rounding, all three of
   them where a triangle is tiny: it is computed again in double, where products of floats are exact. A true zero counts
   for both sides. Then
       t = (U az + V bz + W cz) / (U + V + W) sz
   lies between the corners, hence in their box, unless so much underflows that t means nothing: no hit. */
#define PTI_LEAST 7.5e-37f                               /* 2^-120, 2^29 times the least denormal */
static float pti_edge(float ax, float ay, float bx, float by) {
    float e = ax * by - ay * bx;
    return e != 0 ? e : (float)((double)ax * (double)by - (double)ay * (double)bx);
}
/* For each of four; u = V / det, v = W / det. */
typedef struct pti_lanes { float t[PTI_LANES], V[PTI_LANES], W[PTI_LANES], det[PTI_LANES]; } pti_lanes;
static int pti_triangle(const pti_packet *p, int lane, const pti_ray *r, pti_lanes *out) {
    float az = pti_packet_row(p, 0, r->kz)[lane] - r->oz, ax = (pti_packet_row(p, 0, r->kx)[lane] - r->ox) - r->sx * az;
    float bz = pti_packet_row(p, 1, r->kz)[lane] - r->oz, bx = (pti_packet_row(p, 1, r->kx)[lane] - r->ox) - r->sx * bz;
    float cz = pti_packet_row(p, 2, r->kz)[lane] - r->oz, cx = (pti_packet_row(p, 2, r->kx)[lane] - r->ox) - r->sx * cz;
    float ay = (pti_packet_row(p, 0, r->ky)[lane] - r->oy) - r->sy * az;
    float by = (pti_packet_row(p, 1, r->ky)[lane] - r->oy) - r->sy * bz;
    float cy = (pti_packet_row(p, 2, r->ky)[lane] - r->oy) - r->sy * cz;
    float U = pti_edge(cx, cy, bx, by), V = pti_edge(ax, ay, cx, cy), W = pti_edge(bx, by, ax, ay);
    float det = U + V + W, T = U * az + V * bz + W * cz;
    if ((U < 0 || V < 0 || W < 0) && (U > 0 || V > 0 || W > 0)) return 0;
    if (!(fabsf(T) > PTI_LEAST)) return 0;
    out->t[lane] = r->sz * T / det;
    out->V[lane] = V; out->W[lane] = W; out->det[lane] = det;
    return out->t[lane] > r->tmin;
}

/* |o + t d|^2 = r^2. The discriminant is taken from the point nearest to the centre, which does not cancel for small or
   distant spheres (Haines et al. 2019), and in double, so that only the last rounding shows. */
static int pti_sphere_hit(const pti_sphere *s, const pti_ray *r, float tmax, float *t) {
    double o[3], d[3], a, b, c, q, disc, n[3], near_t, far_t;
    o[0] = (double)r->org[0] - (double)s->center.x; d[0] = (double)r->dir[0];
    o[1] = (double)r->org[1] - (double)s->center.y; d[1] = (double)r->dir[1];
    o[2] = (double)r->org[2] - (double)s->center.z; d[2] = (double)r->dir[2];
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    b = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]);
    n[0] = o[0] + b / a * d[0]; n[1] = o[1] + b / a * d[1]; n[2] = o[2] + b / a * d[2];
    disc = (double)s->radius * (double)s->radius - (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(disc >= 0)) return 0;
    c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - (double)s->radius * (double)s->radius;
    q = b + (b < 0 ? -sqrt(a * disc) : sqrt(a * disc));
    near_t = q != 0 ? c / q : 0.0;
    far_t = q / a;
    if (near_t > far_t) { q = near_t; near_t = far_t; far_t = q; }
    *t = (float)near_t;
    if (!(*t > r->tmin)) *t = (float)far_t;
    return *t > r->tmin && *t <= tmax;
}

PTI_INLINE const float *pti_mesh_vertex(const pti_mesh *m, uint32_t vertex) {
    return (const float *)(const void *)((const char *)m->positions + (size_t)vertex * m->stride);
}
PTI_INLINE pt_vec3 pti_mesh_position(const pti_mesh *m, uint32_t vertex) {
    const float *p = pti_mesh_vertex(m, vertex);
    return pt_v3(p[0], p[1], p[2]);
}
static pt_vec3 pti_vec3_at(const float *array, uint32_t i) {
    const float *p = array + 3 * (size_t)i;
    return pt_v3(p[0], p[1], p[2]);
}
PTI_INLINE uint32_t pti_mesh_index(const pti_mesh *m, uint32_t triangle, int corner) {
    size_t i = (size_t)triangle * 3 + (size_t)corner;
    return m->indices ? m->indices[i] : (uint32_t)i;
}
PTI_INLINE void pti_mesh_triangle(const pti_mesh *m, uint32_t triangle, pt_vec3 v[3]) {
    int k;
    for (k = 0; k < 3; k++) v[k] = pti_mesh_position(m, pti_mesh_index(m, triangle, k));
}
/* Bounds of primitive i of a shape that is no instance, wide enough for the rounding of whatever tests it. */
static pti_bounds pti_shape_bounds(const pti_shape *s, uint32_t i) {
    pti_bounds b = pti_bounds_empty();
    pt_vec3 v[3];
    int k;
    switch (s->kind) {
    case PTI_MESH:
        pti_mesh_triangle(&s->as.mesh, i, v);
        for (k = 0; k < 3; k++) pti_bounds_point(&b, v[k]);
        return b;
    case PTI_SPHERE:
        b.lo = b.hi = s->as.sphere.center;
        pti_bounds_pad(&b, s->as.sphere.radius);
        break;
    case PTI_INSTANCE: return b;                         /* see pti_object_bounds */
    case PTI_USER:
        b.lo = s->as.user.lo;
        b.hi = s->as.user.hi;
        break;
    }
    pti_bounds_pad(&b, PTI_ULPS_8 * pti_max(pti_largest_abs(b.lo), pti_largest_abs(b.hi)));
    return b;
}

/* ---- >>bvh ---------------------------------------------------------------------------------------------
   A tree of boxes with up to eight children a node. First a tree of two children a node is built from the top: a range of
   primitives is split where the surface area heuristic says that random rays will meet least,
       cost = area(left) packets(left) + area(right) packets(right)
   over bins along the three axes (Wald 2007). Then nodes of the two are put together to nodes of up to eight, those that rays will
   meet least. Leaves hold one packet of triangles, or one other object. Triangles that fill little of their
   boxes are cut in pieces, before the tree grows or, for the best quality, as it does. At the end: how far placed scenes reach, and
   refitting.
   Threads share the work, in an order that chance decides, but what each of them does depends on nothing but the range: the
   tree is the same for any number of them. */

#define PTI_BINS 16
#define PTI_MOST_BINS 32
#define PTI_MAX_DEPTH 62                                 /* of splits, hence also of nodes */
#define PTI_STACK (PTI_MAX_DEPTH * (PTI_WIDTH - 1) + 2)  /* all that one descent can leave to be visited */

/* What a child is, in the top two bits, and below where: nodes and packets in blocks, objects among the shapes. */
#define PTI_INNER  0x00000000u
#define PTI_LEAF   0x40000000u                           /* a packet */
#define PTI_OBJECT 0x80000000u                           /* a shape that is not a mesh */
#define PTI_NONE   0xffffffffu
#define PTI_BACK   0xfffffffeu                           /* on a traversal's stack only: out of an instance */
#define PTI_KIND(child)  ((child) & 0xc0000000u)
#define PTI_INDEX(child) ((child) & 0x3fffffffu)

typedef struct pti_node {
    float plane[6][PTI_WIDTH];                           /* x low, x high, y low, y high, z low, z high, of each child */
    uint32_t child[PTI_WIDTH];                           /* unused ones: PTI_NONE, with an inside-out box */
    uint32_t order[8];                                   /* for each octant of directions (1: x < 0, 2: y < 0, 4: z < 0) the
                                                            children from near to far, four bits each, the first lowest */
} pti_node;
/* A node is followed by the packets of its leaves, then by its inner children and all that is theirs. */
typedef struct pti_block { float f[8]; } pti_block;
#define PTI_NODE_BLOCKS   (sizeof(pti_node) / sizeof(pti_block))
#define PTI_PACKET_BLOCKS (sizeof(pti_packet) / sizeof(pti_block))
typedef struct pti_bvh {
    pti_block *blocks; size_t block_count;
    uint32_t root, left_out;                             /* of the primitives, those that nothing can hit */
    pti_bounds bounds;
    float slack;                                         /* see pti_bvh_slack */
} pti_bvh;
PTI_INLINE pti_node *pti_node_at(const pti_bvh *b, uint32_t child) { return (pti_node *)(void *)(b->blocks + child); }
PTI_INLINE pti_packet *pti_packet_at(const pti_bvh *b, uint32_t child) {
    return (pti_packet *)(void *)(b->blocks + PTI_INDEX(child));
}

typedef struct pti_geometry {
    pti_shape *shapes;   size_t shape_count, shape_capacity;
    uint32_t prim_count;
    pti_bvh bvh;
} pti_geometry;

/* While it is built. A primitive: what sits beside the corners of its box reads as floats of middling size, so that arithmetic on
   all four is quick. A range of primitives, and up to `room` space for those that come when some are cut in two; link: where its
   split's index is awaited. A split: left and right are the indices of the splits of its halves, 0 where one is a leaf. There are
   fewer of them than primitives and space; tasks take them by sixteens, and pages of the array that nobody takes cost nothing. */
typedef struct pti_box { pti_f4 lo, hi; } pti_box;
typedef struct pti_ref { float lo[3]; uint32_t shape; float hi[3]; uint32_t prim; } pti_ref;       /* prim within its shape */
#define PTI_MIDDLING 0x40000000u                         /* the bits of 2.0f: combined with shape and prim, so that what pti_f4_load
                                                            gets beside lo and hi is an ordinary float */
typedef struct pti_range { size_t begin, end, room; pti_box box, centers; int depth; uint32_t *link; } pti_range;
typedef struct pti_halves {
    float lo[3]; uint32_t left;
    float hi[3]; uint32_t right, middle;
    float cost[PTI_WIDTH - 1];                           /* see pti_halves_weigh; cost[0] < 0: not yet known */
} pti_halves;
typedef struct pti_builder {
    pti_geometry *g;
    int threads, spare, bins, cuts;                      /* spare: that one large range may have; cuts: may space be split? */
    float area;                                          /* half of that of all */
    pti_ref *refs;       size_t count, room;             /* room for cut triangles too */
    pti_halves *splits;  size_t split_count;
    size_t left_out;                                     /* of the primitives, those that nothing can hit */
    pti_mutex lock;                                      /* of split_count, left_out and the boxes of all */
    int wastes;                                          /* are triangles' wastes wanted? see pti_waste */
    uint32_t *places;                                    /* those; then at a leaf's first primitive, how many it has; then
                                                            pti_place_packet */
    pti_range all;                                       /* after cuts its centers are wider than they need be */
    pti_range *tasks;    size_t task_count;
    uint32_t top;                                        /* the split of all */
} pti_builder;

static pti_box pti_box_empty(void) {
    pti_box b;
    b.lo = pti_f4_set(FLT_MAX);
    b.hi = pti_f4_set(-FLT_MAX);
    return b;
}
PTI_INLINE void pti_box_merge(pti_box *b, pti_f4 lo, pti_f4 hi) { b->lo = pti_f4_min(lo, b->lo); b->hi = pti_f4_max(hi, b->hi); }
PTI_INLINE void pti_box_add(pti_box *b, pti_f4 point) { pti_box_merge(b, point, point); }          /* unless NaN */
static float pti_box_area(const pti_box *b) {            /* half of it */
    float d[4];
    pti_f4_store(d, pti_f4_sub(b->hi, b->lo));
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}
PTI_INLINE pti_f4 pti_ref_center(const pti_ref *r) { return pti_f4_add(pti_f4_load(r), pti_f4_load(r->hi)); }  /* twice it */
static uint32_t pti_ref_index(const pti_ref *r) { return r->shape ^ PTI_MIDDLING; }
static uint32_t pti_ref_prim(const pti_ref *r) { return r->prim ^ PTI_MIDDLING; }
static const pti_shape *pti_ref_shape(const pti_builder *b, const pti_ref *r) { return b->g->shapes + pti_ref_index(r); }

static pti_range pti_range_make(const pti_builder *b, size_t begin, size_t end, size_t room, int depth) {
    pti_range r;
    size_t i;
    r.begin = begin; r.end = end; r.room = room; r.depth = depth; r.link = NULL;
    r.box = r.centers = pti_box_empty();
    for (i = begin; i < end; i++) {
        pti_f4 c = pti_ref_center(b->refs + i);
        pti_box_merge(&r.box, pti_f4_load(b->refs[i].lo), pti_f4_load(b->refs[i].hi));
        pti_box_add(&r.centers, c);
    }
    return r;
}
static int pti_is_leaf(const pti_builder *b, size_t begin, size_t end) {
    size_t i;
    if (end - begin == 1) return 1;
    if (end - begin > PTI_LANES) return 0;
    for (i = begin; i < end; i++) if (pti_ref_shape(b, b->refs + i)->kind != PTI_MESH) return 0;
    return 1;
}

/* Bins along the three axes at once. They are a hair wider than the centres' extent, so that no index leaves them. */
typedef struct pti_bins { pti_box box[3][PTI_MOST_BINS]; uint32_t count[3][PTI_MOST_BINS]; int size; pti_f4 lo, scale; } pti_bins;
static void pti_bins_layout(pti_bins *bins, const pti_range *r, int size) {
    float extent[4];
    int k;
    bins->size = r->end - r->begin < 4 * (size_t)size ? (int)(4 + (r->end - r->begin) / 4) : size;     /* few for few */
    if (bins->size > size) bins->size = size;
    bins->lo = r->centers.lo;
    pti_f4_store(extent, pti_f4_sub(r->centers.hi, r->centers.lo));
    for (k = 0; k < 3; k++) extent[k] = extent[k] > 1e-36f ? (float)bins->size * 0.9999f / extent[k] : 0.0f;
    extent[3] = 0;
    bins->scale = pti_f4_load(extent);
}
PTI_INLINE pti_f4 pti_bins_of(const pti_bins *bins, pti_f4 center) {       /* to be rounded down */
    return pti_f4_mul(pti_f4_sub(center, bins->lo), bins->scale);
}
PTI_INLINE void pti_bin_put(pti_bins *bins, int axis, int at, pti_f4 lo, pti_f4 hi) {
    pti_box_merge(&bins->box[axis][at], lo, hi);
    bins->count[axis][at]++;
}
PTI_INLINE void pti_bins_put(pti_bins *bins, const pti_ref *ref) {         /* no loop: plain -O2 leaves it one, half as fast */
    pti_f4 lo = pti_f4_load(ref->lo), hi = pti_f4_load(ref->hi);
    int32_t at[4];
    pti_f4_store_whole(at, pti_bins_of(bins, pti_f4_add(lo, hi)));
    pti_bin_put(bins, 0, at[0], lo, hi);
    pti_bin_put(bins, 1, at[1], lo, hi);
    pti_bin_put(bins, 2, at[2], lo, hi);
}
/* Neighbours often share a bin, and each waits for the one before; so two halves go side by side. */
static void pti_bins_fill(pti_bins *bins, const pti_ref *ref, size_t count) {
    size_t half = count / 2, i;
    int axis, k;
    for (axis = 0; axis < 3; axis++)
        for (k = 0; k < bins->size; k++) { bins->box[axis][k] = pti_box_empty(); bins->count[axis][k] = 0; }
    for (i = 0; i < half; i++) {
        pti_bins_put(bins, ref + i);
        pti_bins_put(bins, ref + half + i);
    }
    if (count & 1) pti_bins_put(bins, ref + count - 1);
}
static float pti_packets_for(uint32_t count) { return (float)((count + PTI_LANES - 1) / PTI_LANES); }

/* The cheapest border between bins of an axis: the number of bins to its left, or 0. */
static int pti_bins_sweep(const pti_bins *bins, int axis, float *best) {
    const pti_box *box = bins->box[axis];
    const uint32_t *count = bins->count[axis];
    float right[PTI_MOST_BINS], cost;
    pti_box sum = pti_box_empty();
    uint32_t n = 0;
    int k, last = bins->size - 1, at = 0;
    for (k = last; k > 0; k--) {
        pti_box_merge(&sum, box[k].lo, box[k].hi);
        n += count[k];
        if (!n) { last--; continue; }
        right[k] = pti_box_area(&sum) * pti_packets_for(n);
    }
    sum = pti_box_empty();
    for (k = 1, n = 0; k <= last; k++) {
        if (!count[k - 1]) continue;                     /* as good as the border before */
        pti_box_merge(&sum, box[k - 1].lo, box[k - 1].hi);
        n += count[k - 1];
        cost = pti_box_area(&sum) * pti_packets_for(n) + right[k];
        if (cost < *best) { *best = cost; at = k; }
    }
    return at;
}
/* What is left of room goes to both halves, as they are large; the right half moves up for the left one's. */
static void pti_share_room(pti_builder *b, const pti_range *r, size_t middle, size_t end, pti_range *left, pti_range *right) {
    size_t gift = (size_t)((uint64_t)(r->room - end) * (middle - r->begin) / (end - r->begin));
    if (gift) memmove(b->refs + middle + gift, b->refs + middle, (end - middle) * sizeof *b->refs);
    left->begin = r->begin; left->end = middle; left->room = right->begin = middle + gift; right->end = end + gift;
    right->room = r->room;
    left->depth = right->depth = r->depth + 1;
}
static void pti_bins_halves(const pti_bins *bins, int axis, int at, pti_box *left, pti_box *right) {
    int k;
    *left = *right = pti_box_empty();
    for (k = 0; k < bins->size; k++) {
        const pti_box *box = &bins->box[axis][k];
        pti_box_merge(k < at ? left : right, box->lo, box->hi);
    }
}
/* Moves what belongs to the left of border `at` to the front, without a branch for chance to mislead. Returns how many do; ours and
   theirs: the centres, on the left and on the right. */
static size_t pti_partition(pti_ref *refs, size_t count, const pti_bins *bins, int axis, int at, pti_box *ours, pti_box *theirs) {
    pti_box left = pti_box_empty(), right = left;
    float from[4], scale[4];
    size_t i, middle = 0;
    pti_f4_store(from, bins->lo);
    pti_f4_store(scale, bins->scale);
    for (i = 0; i < count; i++) {
        pti_ref *here = refs + i, *there = refs + middle;
        pti_f4 lo = pti_f4_load(here->lo), hi = pti_f4_load(here->hi), c = pti_f4_add(lo, hi);
        uint32_t goes_left = (here->lo[axis] + here->hi[axis] - from[axis]) * scale[axis] < (float)at;   /* as pti_bins_of */
        pti_box_add(&left, pti_f4_if(goes_left, c));
        pti_box_add(&right, pti_f4_if(!goes_left, c));
        *here = *there;
        pti_f4_store(there, lo);
        pti_f4_store(there->hi, hi);
        middle += goes_left;
    }
    *ours = left; *theirs = right;
    return middle;
}
/* A large range is binned and partitioned in two halves, by a thread each where there are more threads than ranges. */
#define PTI_LARGE_RANGE 65536
typedef struct pti_range_half { pti_ref *refs; size_t count, middle; pti_bins bins; pti_box ours, theirs; } pti_range_half;
typedef struct pti_range_pair { pti_range_half half[2]; const pti_bins *bins; int axis, at; } pti_range_pair;
static void pti_range_pair_make(pti_range_pair *p, const pti_builder *b, const pti_range *r, const pti_bins *bins) {
    p->bins = bins;
    p->half[0].refs = b->refs + r->begin;
    p->half[0].count = (r->end - r->begin) / 2;
    p->half[1].refs = p->half[0].refs + p->half[0].count;
    p->half[1].count = (r->end - r->begin) - p->half[0].count;
}
static void pti_range_half_fill(void *user, size_t i) {
    pti_range_half *h = ((pti_range_pair *)user)->half + i;
    h->bins = *((pti_range_pair *)user)->bins;
    pti_bins_fill(&h->bins, h->refs, h->count);
}
static void pti_range_half_partition(void *user, size_t i) {
    const pti_range_pair *p = (pti_range_pair *)user;
    pti_range_half *h = ((pti_range_pair *)user)->half + i;
    h->middle = pti_partition(h->refs, h->count, p->bins, p->axis, p->at, &h->ours, &h->theirs);
}
static void pti_range_fill(const pti_builder *b, const pti_range *r, pti_bins *bins) {
    pti_range_pair p;
    int axis, k;
    if (r->end - r->begin < PTI_LARGE_RANGE) { pti_bins_fill(bins, b->refs + r->begin, r->end - r->begin); return; }
    pti_range_pair_make(&p, b, r, bins);
    pti_parallel(b->spare, pti_range_half_fill, &p, 2);
    *bins = p.half[0].bins;
    for (axis = 0; axis < 3; axis++)
        for (k = 0; k < bins->size; k++) {
            pti_box_merge(&bins->box[axis][k], p.half[1].bins.box[axis][k].lo, p.half[1].bins.box[axis][k].hi);
            bins->count[axis][k] += p.half[1].bins.count[axis][k];
        }
}
static void pti_range_partition(pti_builder *b, const pti_range *r, const pti_bins *bins, int axis, int at, pti_range *left,
                                pti_range *right) {
    size_t count = r->end - r->begin, middle;
    pti_bins_halves(bins, axis, at, &left->box, &right->box);
    if (count < PTI_LARGE_RANGE)
        middle = pti_partition(b->refs + r->begin, count, bins, axis, at, &left->centers, &right->centers);
    else {
        pti_range_pair p;
        pti_ref *to, *from;
        pti_range_pair_make(&p, b, r, bins);
        p.axis = axis; p.at = at;
        pti_parallel(b->spare, pti_range_half_partition, &p, 2);
        left->centers = p.half[0].ours; pti_box_merge(&left->centers, p.half[1].ours.lo, p.half[1].ours.hi);
        right->centers = p.half[0].theirs; pti_box_merge(&right->centers, p.half[1].theirs.lo, p.half[1].theirs.hi);
        middle = p.half[0].middle + p.half[1].middle;
        to = p.half[0].refs + p.half[0].middle;          /* what goes right at the end of the first half is swapped with what goes
                                                            left in the second, as many as both have */
        from = p.half[1].refs + p.half[1].middle;
        for (; to < p.half[1].refs && from > p.half[1].refs; to++) {
            pti_ref other = *--from;
            *from = *to;
            *to = other;
        }
    }
    pti_share_room(b, r, r->begin + middle, r->end, left, right);
}
static void pti_ref_triangle(const pti_builder *b, const pti_ref *r, pt_vec3 v[3]) {
    pti_mesh_triangle(&pti_ref_shape(b, r)->as.mesh, pti_ref_prim(r), v);
}
/* Makes the box of a piece smaller: what of the triangle lies between two planes across an axis. The roundings here are less
   than the pads: some of the triangle's size, some of its coordinates'. */
static void pti_ref_clip(pti_ref *r, const pt_vec3 v[3], int axis, float lo, float hi) {
    pti_bounds box = pti_bounds_empty(), whole = pti_bounds_empty();
    float corner[6], size[3], pad;
    int i, k;
    for (i = 0; i < 3; i++) {
        pt_vec3 p = v[i], q = v[(i + 1) % 3];
        float a = pti_axis(p, axis), d = pti_axis(q, axis) - a;
        pti_bounds_point(&whole, p);
        if (a >= lo && a <= hi) pti_bounds_point(&box, p);
        for (k = 0; k < 2; k++) {
            float t = ((k ? hi : lo) - a) / d;           /* no crossing if d is 0 */
            if (t >= 0 && t <= 1) pti_bounds_point(&box, pti_madd(pti_sub(q, p), t, p));
        }
    }
    corner[0] = box.lo.x; corner[1] = box.lo.y; corner[2] = box.lo.z;
    corner[3] = box.hi.x; corner[4] = box.hi.y; corner[5] = box.hi.z;
    size[0] = whole.hi.x - whole.lo.x; size[1] = whole.hi.y - whole.lo.y; size[2] = whole.hi.z - whole.lo.z;
    for (k = 0; k < 3; k++) {
        pad = size[k] * (1.0f / 16384) + PTI_ULPS_8 * pti_max(fabsf(r->lo[k]), fabsf(r->hi[k]));
        r->lo[k] = pti_max(r->lo[k], corner[k] - pad);
        r->hi[k] = pti_min(r->hi[k], corner[k + 3] + pad);
    }
}

/* While the tree grows, spatial splits (Stich, Friedrich and Dietrich 2009): where the boxes of an object split would overlap
   much, a plane may part the triangles better, which are cut in two where it meets them: each piece has a box of its own, and
   still means the whole triangle. Bins lie along the range's box, and hold what of each triangle is in them; `first` and `last`
   count where triangles begin and end. Other objects are not cut: each is where its centre is. */
#define PTI_CUTS 16
#define PTI_OVERLAP 1e-3f                                /* of the area of all: where there is less, trees get no better */
typedef struct pti_cuts {
    pti_box box[PTI_CUTS];
    uint32_t first[PTI_CUTS], last[PTI_CUTS];
    int axis;
    float lo, step, scale;
} pti_cuts;
static void pti_cuts_layout(pti_cuts *c, const pti_range *r, int axis) {
    float lo[4], hi[4];
    int k;
    pti_f4_store(lo, r->box.lo);
    pti_f4_store(hi, r->box.hi);
    c->axis = axis; c->lo = lo[axis]; c->step = (hi[axis] - lo[axis]) / PTI_CUTS;
    c->scale = c->step > 1e-36f ? 1 / c->step : 0.0f;
    for (k = 0; k < PTI_CUTS; k++) { c->box[k] = pti_box_empty(); c->first[k] = c->last[k] = 0; }
}
static float pti_cuts_plane(const pti_cuts *c, int k) { return c->lo + c->step * (float)k; }
static int pti_cuts_of(const pti_cuts *c, float x) {
    float k = (x - c->lo) * c->scale;
    return k > 0 ? k < PTI_CUTS - 1 ? (int)k : PTI_CUTS - 1 : 0;
}
static void pti_cuts_span(const pti_cuts *c, const pti_builder *b, const pti_ref *r, int *first, int *last) {
    if (pti_ref_shape(b, r)->kind == PTI_MESH) {
        *first = pti_cuts_of(c, r->lo[c->axis]);
        *last = pti_cuts_of(c, r->hi[c->axis]);
    } else *first = *last = pti_cuts_of(c, r->lo[c->axis] * 0.5f + r->hi[c->axis] * 0.5f);
}
static int pti_ref_is_empty(const pti_ref *r) { return !(r->lo[0] <= r->hi[0] && r->lo[1] <= r->hi[1] && r->lo[2] <= r->hi[2]); }
static void pti_cuts_fill(pti_cuts *c, const pti_builder *b, const pti_range *r) {
    size_t i;
    for (i = r->begin; i < r->end; i++) {
        const pti_ref *ref = b->refs + i;
        pt_vec3 v[3];
        int first, last, k;
        pti_cuts_span(c, b, ref, &first, &last);
        c->first[first]++;
        c->last[last]++;
        if (first == last) { pti_box_merge(&c->box[first], pti_f4_load(ref->lo), pti_f4_load(ref->hi)); continue; }
        pti_ref_triangle(b, ref, v);
        for (k = first; k <= last; k++) {
            float from = k > first ? pti_cuts_plane(c, k) : -FLT_MAX, to = k < last ? pti_cuts_plane(c, k + 1) : FLT_MAX;
            pti_ref piece = *ref;
            pti_ref_clip(&piece, v, c->axis, from, to);
            if (!pti_ref_is_empty(&piece)) pti_box_merge(&c->box[k], pti_f4_load(piece.lo), pti_f4_load(piece.hi));
        }
    }
}
/* The cheapest plane between bins that leaves fewer triangles on both sides, and for whose pieces there is room; or 0. */
static int pti_cuts_sweep(const pti_cuts *c, const pti_range *r, float *best) {
    float right[PTI_CUTS], cost;
    uint32_t count[PTI_CUTS], n = 0, all = (uint32_t)(r->end - r->begin);
    pti_box sum = pti_box_empty();
    int k, at = 0;
    for (k = PTI_CUTS - 1; k > 0; k--) {
        pti_box_merge(&sum, c->box[k].lo, c->box[k].hi);
        n += c->last[k];
        count[k] = n;
        right[k] = n ? pti_box_area(&sum) * pti_packets_for(n) : 0.0f;
    }
    sum = pti_box_empty();
    for (k = 1, n = 0; k < PTI_CUTS; k++) {
        pti_box_merge(&sum, c->box[k - 1].lo, c->box[k - 1].hi);
        n += c->first[k - 1];
        if (!n || !count[k] || n >= all || count[k] >= all || n + count[k] - all > r->room - r->end) continue;
        cost = pti_box_area(&sum) * pti_packets_for(n) + right[k];
        if (cost < *best) { *best = cost; at = k; }
    }
    return at;
}
/* Those on the left first, then those on the right, then the right pieces of the others. 0 if one side came out empty. */
static int pti_partition_space(pti_builder *b, const pti_range *r, const pti_cuts *c, int at, pti_range *left, pti_range *right) {
    size_t i = r->begin, middle = r->end, end = r->end;
    float plane = pti_cuts_plane(c, at);
    while (i < middle) {
        pti_ref *ref = b->refs + i, piece = *ref, other;
        int first, last;
        pti_cuts_span(c, b, ref, &first, &last);
        if (last < at) { i++; continue; }
        if (first < at) {
            pt_vec3 v[3];
            pti_ref_triangle(b, ref, v);
            other = piece;
            pti_ref_clip(&piece, v, c->axis, -FLT_MAX, plane);
            pti_ref_clip(&other, v, c->axis, plane, FLT_MAX);
            if (!pti_ref_is_empty(&piece) && (pti_ref_is_empty(&other) || end < r->room)) {
                *ref = piece;
                i++;
                if (!pti_ref_is_empty(&other)) b->refs[end++] = other;
                continue;
            }
            piece = pti_ref_is_empty(&piece) && !pti_ref_is_empty(&other) ? other : *ref;      /* else whole: it is hardly there */
        }
        *ref = b->refs[--middle];
        b->refs[middle] = piece;
    }
    if (middle == r->begin || middle == end) return 0;
    *left = pti_range_make(b, r->begin, middle, middle, 0);        /* depths are pti_share_room's to set */
    *right = pti_range_make(b, middle, end, end, 0);
    pti_share_room(b, r, middle, end, left, right);
    return 1;
}
/* The best plane, if it is cheaper than `best` and the halves of the best object split overlap. */
static int pti_find_cut(const pti_builder *b, const pti_range *r, const pti_bins *bins, int axis, int at, float best,
                        pti_cuts *out) {
    pti_box left, right;
    pti_cuts c;
    int k, cut = 0;
    if (!b->cuts || r->room == r->end) return 0;
    if (axis >= 0) {
        float size[4];
        pti_bins_halves(bins, axis, at, &left, &right);
        left.lo = pti_f4_max(left.lo, right.lo);
        left.hi = pti_f4_min(left.hi, right.hi);
        pti_f4_store(size, pti_f4_sub(left.hi, left.lo));
        if (size[0] < 0 || size[1] < 0 || size[2] < 0 || pti_box_area(&left) < PTI_OVERLAP * b->area) return 0;
    }
    for (k = 0; k < 3; k++) {
        pti_cuts_layout(&c, r, k);
        if (c.scale == 0) continue;
        pti_cuts_fill(&c, b, r);
        at = pti_cuts_sweep(&c, r, &best);
        if (at) { cut = at; *out = c; }
    }
    return cut;
}
static int pti_log2_ceil(size_t n) {
    int k = 0;
    while (n > 1) { n = (n + 1) / 2; k++; }
    return k;
}
static int pti_bin_of(float center, float lo, float scale) {         /* for lights, which have bins of their own */
    int i = (int)((center - lo) * scale);
    return i < PTI_BINS - 1 ? i : PTI_BINS - 1;
}
/* Where all centres coincide, the tree grows too deep, or a spatial split leaves one side empty, half goes left, and all room
   right. */
static void pti_split_range(pti_builder *b, const pti_range *r, pti_range *left, pti_range *right) {
    pti_bins bins;
    pti_cuts cuts;
    float best = FLT_MAX;
    int axis, at, best_axis = -1, best_at = 0, cut = 0;
    if (r->depth + 1 + pti_log2_ceil(r->end - r->begin) < PTI_MAX_DEPTH) {
        pti_bins_layout(&bins, r, b->bins);
        pti_range_fill(b, r, &bins);
        for (axis = 0; axis < 3; axis++) {
            at = pti_bins_sweep(&bins, axis, &best);
            if (at) { best_axis = axis; best_at = at; }
        }
        cut = pti_find_cut(b, r, &bins, best_axis, best_at, best, &cuts);
        if (cut && pti_partition_space(b, r, &cuts, cut, left, right)) return;
    }
    if (best_axis >= 0 && !cut) pti_range_partition(b, r, &bins, best_axis, best_at, left, right);
    else {
        size_t middle = r->begin + (r->end - r->begin) / 2;
        *left = pti_range_make(b, r->begin, middle, middle, r->depth + 1);
        *right = pti_range_make(b, middle, r->end, r->room, r->depth + 1);
    }
}
/* Splits are numbered; 0, which none has, stands for a leaf. The upper levels number theirs from 1 on; below, each task takes a lot
   of so many numbers at a time, the first of them a multiple of that: there, and at 0, it needs another lot. */
#define PTI_FEW_SPLITS 16
static size_t pti_next_split(pti_builder *b, size_t *next) {       /* *next: 0 at first */
    if (*next % PTI_FEW_SPLITS == 0) {
        pti_lock(&b->lock);
        *next = b->split_count;
        b->split_count += PTI_FEW_SPLITS;
        pti_unlock(&b->lock);
    }
    return (*next)++;
}
static void pti_keep_split(pti_builder *b, size_t index, const pti_range *r, pti_range *left, pti_range *right) {
    pti_halves *split = b->splits + index;
    float corner[4];
    pti_f4_store(corner, r->box.lo); memcpy(split->lo, corner, sizeof split->lo);
    pti_f4_store(corner, r->box.hi); memcpy(split->hi, corner, sizeof split->hi);
    split->left = split->right = 0;
    split->middle = (uint32_t)right->begin;
    split->cost[0] = -1;
    left->link = &split->left; right->link = &split->right;
    *r->link = (uint32_t)index;
}

/* Which splits become one wide node? C(n, i), the least area of all wide nodes at and below a split n that takes up to i places
   in a node above, is
       C(n, 1) = area(n) + min_k C(left, k) + C(right, 8 - k),
       C(n, i) = min(C(n, 1), min_k C(left, k) + C(right, i - k)),       k from 1 to i - 1,
   and 0 for leaves (Ylitie, Karras and Laine 2017): all is known from below. cost[i - 1] of a split keeps C(n, i). */
static const float *pti_costs(const pti_builder *b, uint32_t split) {
    static const float none[PTI_WIDTH - 1] = { 0, 0, 0, 0, 0, 0, 0 };
    return split ? b->splits[split].cost : none;
}
PTI_INLINE int pti_halves_share(const pti_builder *b, const pti_halves *s, int places, float *cost) {     /* k: the left half's */
    const float *left = pti_costs(b, s->left), *right = pti_costs(b, s->right);
    int k, best = 1;
    *cost = left[0] + right[places - 2];
    for (k = 2; k < places; k++) {
        float c = left[k - 1] + right[places - k - 1];
        best = c < *cost ? k : best;                     /* no branch: chance would decide it */
        *cost = pti_min(c, *cost);
    }
    return best;
}
static void pti_halves_weigh(pti_builder *b, uint32_t split) {
    pti_halves *s = b->splits + split;
    float x, y, z, cost;
    int places;
    if (!split || s->cost[0] >= 0) return;
    pti_halves_weigh(b, s->left);
    pti_halves_weigh(b, s->right);
    pti_halves_share(b, s, PTI_WIDTH, &cost);
    x = s->hi[0] - s->lo[0]; y = s->hi[1] - s->lo[1]; z = s->hi[2] - s->lo[2];
    s->cost[0] = x * y + y * z + z * x + cost;
    for (places = 2; places < PTI_WIDTH; places++) {
        pti_halves_share(b, s, places, &cost);
        s->cost[places - 1] = pti_min(s->cost[0], cost);
    }
}
static void pti_build_range(pti_builder *b, const pti_range *r, size_t *next) {
    pti_range left, right;
    size_t split;
    if (pti_is_leaf(b, r->begin, r->end)) { b->places[r->begin] = (uint32_t)(r->end - r->begin); return; }
    pti_split_range(b, r, &left, &right);
    split = pti_next_split(b, next);
    pti_keep_split(b, split, r, &left, &right);
    pti_build_range(b, &left, next);
    pti_build_range(b, &right, next);
    pti_halves_weigh(b, (uint32_t)split);
}

/* The upper levels: all ranges of a level side by side, until they are small enough for one thread each. */
#define PTI_TASKS 64
#define PTI_SMALL_TASK 1000
/* Each of up to 2 PTI_TASKS - 2 tasks may leave some of its last lot unused. */
static size_t pti_most_splits(size_t room) {
    size_t lots = room > PTI_SMALL_TASK ? 2 * PTI_TASKS : 1;
    return room + PTI_FEW_SPLITS * lots;
}
static void pti_split_task(void *user, size_t i) {
    pti_builder *b = (pti_builder *)user;
    pti_range whole = b->tasks[i], *left = &b->tasks[i], *right = &b->tasks[b->task_count + i];
    pti_split_range(b, &whole, left, right);
    pti_keep_split(b, b->task_count + i, &whole, left, right);
}
static void pti_build_task(void *user, size_t i) {
    pti_builder *b = (pti_builder *)user;
    size_t next = 0;
    pti_build_range(b, &b->tasks[i], &next);
}
static void pti_build_splits(pti_builder *b) {
    pti_range tasks[2 * PTI_TASKS];
    size_t enough = b->count / PTI_TASKS > PTI_SMALL_TASK ? b->count / PTI_TASKS : PTI_SMALL_TASK, large, i;
    b->tasks = tasks;
    tasks[0] = b->all;
    b->task_count = 1;
    while (b->task_count < PTI_TASKS) {                  /* those to be split come first */
        for (i = 0, large = 0; i < b->task_count; i++) {
            pti_range r = tasks[i];
            if (r.end - r.begin <= enough) continue;
            tasks[i] = tasks[large];
            tasks[large++] = r;
        }
        if (!large) break;
        b->spare = large < (size_t)b->threads ? b->threads : 1;
        pti_parallel(b->threads, pti_split_task, b, large);
        b->task_count += large;
    }
    b->split_count = (b->task_count + PTI_FEW_SPLITS - 1) / PTI_FEW_SPLITS * PTI_FEW_SPLITS;
    b->spare = 1;
    pti_parallel(b->threads, pti_build_task, b, b->task_count);
    pti_halves_weigh(b, b->top);
}

/* What becomes a child of a wide node. */
typedef struct pti_branch { size_t begin, end; uint32_t split; float area; } pti_branch;
static pti_branch pti_branch_make(size_t begin, size_t end, uint32_t split) {
    pti_branch p;
    p.begin = begin; p.end = end; p.split = split; p.area = 0;
    return p;
}
/* The children of a node, or what takes up to so many places in one. Returns how many they are. */
static int pti_open_branch(const pti_builder *b, const pti_branch *p, int places, int is_node, pti_branch *part) {
    const pti_halves *s = b->splits + p->split;
    pti_branch left, right;
    float cost;
    int k, count;
    *part = *p;
    if (!p->split || places == 1) return 1;
    k = pti_halves_share(b, s, places, &cost);
    if (!is_node && s->cost[0] <= cost) return 1;
    PTI_FETCH(b->splits + b->splits[s->left].left); PTI_FETCH(b->splits + b->splits[s->left].right);
    PTI_FETCH(b->splits + b->splits[s->right].left); PTI_FETCH(b->splits + b->splits[s->right].right);
    left = pti_branch_make(p->begin, s->middle, s->left);
    right = pti_branch_make(s->middle, p->end, s->right);
    count = pti_open_branch(b, &left, k, 0, part);
    return count + pti_open_branch(b, &right, places - k, 0, part + count);
}
static void pti_branch_box(const pti_builder *b, const pti_branch *p, pti_bounds *box) {
    size_t i;
    *box = pti_bounds_empty();
    if (p->split) {
        const pti_halves *s = b->splits + p->split;
        box->lo = pt_v3(s->lo[0], s->lo[1], s->lo[2]);
        box->hi = pt_v3(s->hi[0], s->hi[1], s->hi[2]);
        return;
    }
    for (i = p->begin; i < p->begin + b->places[p->begin]; i++) {
        const pti_ref *r = b->refs + i;
        pti_bounds_point(box, pt_v3(r->lo[0], r->lo[1], r->lo[2]));
        pti_bounds_point(box, pt_v3(r->hi[0], r->hi[1], r->hi[2]));
    }
}

static void pti_node_set(pti_node *n, int k, const pti_bounds *box, uint32_t child) {
    n->plane[0][k] = box->lo.x; n->plane[1][k] = box->hi.x;
    n->plane[2][k] = box->lo.y; n->plane[3][k] = box->hi.y;
    n->plane[4][k] = box->lo.z; n->plane[5][k] = box->hi.z;
    n->child[k] = child;
}
/* By where the centres lie along the middle of an octant: an order that needs no distances, and is as good as theirs. Looking
   the other way, it is the other way round. */
static void pti_node_order(pti_node *n) {
    int octant, i, j;
    for (octant = 0; octant < 4; octant++) {
        float sx = octant & 1 ? -1.0f : 1.0f, sy = octant & 2 ? -1.0f : 1.0f, key[PTI_WIDTH];
        uint32_t order = 0, other = 0, farther = 0;      /* how many are, four bits each */
        for (i = 0; i < PTI_WIDTH; i++)
            key[i] = sx * (n->plane[0][i] + n->plane[1][i]) + sy * (n->plane[2][i] + n->plane[3][i])
                   + (n->plane[4][i] + n->plane[5][i]);
        for (i = 1; i < PTI_WIDTH; i++)
            for (j = 0; j < i; j++) farther += 1u << 4 * (key[j] >= key[i] ? i : j);
        for (i = 0; i < PTI_WIDTH; i++, farther >>= 4) {
            order |= (uint32_t)i << 4 * (farther & 7);
            other |= (uint32_t)i << 4 * (PTI_WIDTH - 1 - (farther & 7));
        }
        n->order[octant] = other;
        n->order[7 - octant] = order;
    }
}
/* The smallest first: any hit, for which near and far are all one, looks in this order, since in small boxes there is a hit or
   there soon is none. */
static void pti_order_branches(const pti_builder *b, pti_branch part[PTI_WIDTH], pti_bounds box[PTI_WIDTH], int count) {
    int i, k;
    for (k = 0; k < count; k++) {
        pti_branch p = part[k];
        pti_bounds whole;
        pti_branch_box(b, &p, &whole);
        p.area = pti_bounds_area(&whole);
        for (i = k; i > 0 && part[i - 1].area > p.area; i--) { part[i] = part[i - 1]; box[i] = box[i - 1]; }
        part[i] = p;
        box[i] = whole;
    }
    for (; k < PTI_WIDTH; k++) box[k] = pti_bounds_empty();
}
/* Lays out a child and all that is below it, from block *used on. Without blocks it only counts; with them, nodes are written,
   and of packets where they will be. A node and what follows fill whole cache lines, in whatever order. Subtrees that are small
   enough are left to threads: the first pass over what is above finds them, the second knows where they begin. */
static uint32_t pti_place_packet(uint32_t at, uint32_t count) { return (at << 2 | (count - 1)) + 1; }      /* 0: there is none */
#define PTI_PLACES 1024
typedef struct pti_place { pti_branch whole; size_t at, size; } pti_place;
typedef struct pti_places {
    pti_builder *builder;
    pti_place place[PTI_PLACES];
    size_t count, next, most;                            /* how many; which the second pass meets next; primitives in one */
} pti_places;

static uint32_t pti_lay_out(pti_builder *b, const pti_branch *p, size_t *used, pti_places *rest) {
    pti_branch part[PTI_WIDTH];
    pti_bounds box[PTI_WIDTH];
    pti_node *n = NULL;
    uint32_t at = (uint32_t)*used, child;
    int count, k, inner;
    if (!p->split) {
        const pti_ref *ref = b->refs + p->begin;
        int object = pti_ref_shape(b, ref)->kind != PTI_MESH;
        if (b->g->bvh.blocks) b->places[p->begin] = object ? 0 : pti_place_packet(at, b->places[p->begin]);
        if (object) return PTI_OBJECT | pti_ref_index(ref);
        *used += PTI_PACKET_BLOCKS;
        return PTI_LEAF | at;
    }
    if (rest && p->end - p->begin <= rest->most) {
        if (b->g->bvh.blocks) { if (rest->next < rest->count) return PTI_INNER | (uint32_t)rest->place[rest->next++].at; }
        else if (rest->count < PTI_PLACES) { rest->place[rest->count++].whole = *p; return PTI_NONE; }
    }
    *used += PTI_NODE_BLOCKS;
    count = pti_open_branch(b, p, PTI_WIDTH, 1, part);
    if (b->g->bvh.blocks || rest) pti_order_branches(b, part, box, count);     /* both passes find places in one order */
    if (b->g->bvh.blocks) {
        n = pti_node_at(&b->g->bvh, at);
        for (k = 0; k < PTI_WIDTH; k++) pti_node_set(n, k, &box[k], PTI_NONE);
        pti_node_order(n);
    }
    for (inner = 0; inner < 2; inner++) {                /* leaves first, then what is visited most */
        for (k = count - 1; k >= 0; k--) {
            if ((part[k].split != 0) != inner) continue;
            child = pti_lay_out(b, &part[k], used, rest);
            if (n) n->child[k] = child;
        }
        if (!inner && *used & 1) {
            if (n) memset(b->g->bvh.blocks + *used, 0, sizeof(pti_block));
            ++*used;
        }
    }
    return PTI_INNER | at;
}
static void pti_lay_out_task(void *user, size_t i) {
    pti_places *rest = (pti_places *)user;
    pti_place *place = rest->place + i;
    size_t used = place->at;
    pti_lay_out(rest->builder, &place->whole, &used, NULL);
    place->size = used - place->at;
}

/* The packets that begin among a slice of the primitives. */
#define PTI_SLICE 8192
static void pti_packet_fill(const pti_builder *b, pti_packet *p, size_t begin, size_t end) {
    size_t i;
    int corner;
    memset(p, 0xff, sizeof *p);                          /* NaN, and ids that do not exist */
    for (i = begin; i < end; i++) {
        const pti_shape *shape = pti_ref_shape(b, b->refs + i);
        uint32_t prim = pti_ref_prim(b->refs + i);
        pt_vec3 v[3];
        pti_mesh_triangle(&shape->as.mesh, prim, v);
        for (corner = 0; corner < 3; corner++) {
            p->v[corner][0][i - begin] = v[corner].x;
            p->v[corner][1][i - begin] = v[corner].y;
            p->v[corner][2][i - begin] = v[corner].z;
        }
        p->prim[i - begin] = shape->first + prim;
    }
}
static void pti_pack_slice(void *user, size_t slice) {
    const pti_builder *b = (const pti_builder *)user;
    size_t i = slice * PTI_SLICE, end = i + PTI_SLICE < b->room ? i + PTI_SLICE : b->room;
    for (; i < end; i++) {
        uint32_t place = b->places[i] - 1;
        if (b->places[i]) pti_packet_fill(b, pti_packet_at(&b->g->bvh, place >> 2), i, i + (place & 3) + 1);
    }
}

static uint32_t pti_find_shape(const pti_geometry *g, uint32_t prim) {
    size_t lo = 0, n = g->shape_count, half;
    for (; n > 1; n -= half) {                           /* without a branch for chance to mislead */
        half = n / 2;
        lo += g->shapes[lo + half].first <= prim ? half : 0;
    }
    return (uint32_t)lo;
}
/* How far a placed scene reaches along an axis of the world: the most of d . p over its points p, d being a row of the transform.
   Its tree is searched for that point, the boxes that reach farthest first. `found`: the farthest corner of a triangle that was
   seen; `most`: a bound on what was not opened; `enough`: how much farther than `found` a box may reach unopened. (The box around
   a turned ball is half as large as the box around the ball's turned box, and rays enter what is in it half as often.) */
#define PTI_REACH_ENOUGH 0.02f                           /* of the scene's own size along the axis */
#define PTI_REACH_REFIT  0.25f                           /* looser, but refitting shall be quick */
typedef struct pti_reach { const pti_bvh *bvh; float d[3], enough, found, most; } pti_reach;

PTI_INLINE pti_f4 pti_reach_four(const pti_reach *r, const float *x, const float *y, const float *z) {
    pti_f4 xy = pti_f4_add(pti_f4_mul(pti_f4_set(r->d[0]), pti_f4_load(x)), pti_f4_mul(pti_f4_set(r->d[1]), pti_f4_load(y)));
    return pti_f4_add(xy, pti_f4_mul(pti_f4_set(r->d[2]), pti_f4_load(z)));
}
static void pti_reach_packet(pti_reach *r, const pti_packet *p) {
    pti_f4 most = pti_f4_set(r->found);
    float reach[4];
    int k;
    for (k = 0; k < 3; k++) most = pti_f4_max(pti_reach_four(r, p->v[k][0], p->v[k][1], p->v[k][2]), most);  /* but for NaN */
    pti_f4_store(reach, most);
    r->found = pti_max(pti_max(reach[0], reach[1]), pti_max(reach[2], reach[3]));
}
static void pti_reach_node(pti_reach *r, const pti_node *n) {
    const float *x = n->plane[r->d[0] > 0], *y = n->plane[2 + (r->d[1] > 0)], *z = n->plane[4 + (r->d[2] > 0)];
    float reach[PTI_WIDTH];
    int k, next;
    for (k = 0; k < PTI_WIDTH; k += 4) pti_f4_store(reach + k, pti_reach_four(r, x + k, y + k, z + k));
    for (;;) {
        for (k = 1, next = 0; k < PTI_WIDTH; k++) if (reach[k] > reach[next]) next = k;
        if (!(reach[next] > pti_max(r->found + r->enough, r->most))) break;
        if (PTI_KIND(n->child[next]) == PTI_LEAF) pti_reach_packet(r, pti_packet_at(r->bvh, n->child[next]));
        else if (PTI_KIND(n->child[next]) == PTI_INNER) pti_reach_node(r, pti_node_at(r->bvh, n->child[next]));
        else break;
        reach[next] = -FLT_MAX;
    }
    r->most = pti_max(r->most, reach[next]);
}
static float pti_reach_along(const pti_bvh *bvh, float enough, float dx, float dy, float dz) {
    pt_vec3 lo = bvh->bounds.lo, hi = bvh->bounds.hi;
    pti_reach r;
    r.bvh = bvh;
    r.d[0] = dx; r.d[1] = dy; r.d[2] = dz;
    r.enough = enough * (fabsf(dx) * (hi.x - lo.x) + fabsf(dy) * (hi.y - lo.y) + fabsf(dz) * (hi.z - lo.z));
    r.found = r.most = -FLT_MAX;
    if ((dx != 0) + (dy != 0) + (dz != 0) > 1 && PTI_KIND(bvh->root) == PTI_INNER)
        pti_reach_node(&r, pti_node_at(bvh, bvh->root));
    else if (PTI_KIND(bvh->root) == PTI_LEAF) pti_reach_packet(&r, pti_packet_at(bvh, bvh->root));
    else r.most = dx * (dx > 0 ? hi.x : lo.x) + dy * (dy > 0 ? hi.y : lo.y) + dz * (dz > 0 ? hi.z : lo.z);
    return pti_max(r.most, r.found);
}
/* Where coefficients move linearly, so does every point, on a straight line that both ends' bounds hold. */
static void pti_scene_placed(pti_bounds *b, const pti_bvh *bvh, const pt_xform *to_world, float enough) {
    const float *m = to_world->m;
    pt_vec3 farthest = pti_max3(pti_neg(bvh->bounds.lo), bvh->bounds.hi), move = pt_v3(m[3], m[7], m[11]);
    pti_bounds placed;
    if (bvh->bounds.lo.x > bvh->bounds.hi.x) return;     /* empty, or all of it is flat for now */
    placed.hi = pti_add(move, pt_v3(pti_reach_along(bvh, enough, m[0], m[1], m[2]),
                                    pti_reach_along(bvh, enough, m[4], m[5], m[6]),
                                    pti_reach_along(bvh, enough, m[8], m[9], m[10])));
    placed.lo = pti_sub(move, pt_v3(pti_reach_along(bvh, enough, -m[0], -m[1], -m[2]),
                                    pti_reach_along(bvh, enough, -m[4], -m[5], -m[6]),
                                    pti_reach_along(bvh, enough, -m[8], -m[9], -m[10])));
    pti_bounds_pad(&placed, PTI_ULPS_8 * pti_xform_magnitude(to_world, farthest));
    pti_bounds_merge(b, &placed);
}
/* Of an object that is a shape by itself. */
static pti_bounds pti_object_bounds(const pti_shape *s, float enough) {
    const pti_instance *in = &s->as.instance;
    pti_bounds b = pti_bounds_empty();
    if (s->kind != PTI_INSTANCE) return pti_shape_bounds(s, 0);
    pti_scene_placed(&b, &in->of->bvh, &in->to_world, enough);
    if (in->to_world_end) pti_scene_placed(&b, &in->of->bvh, in->to_world_end, enough);
    return b;
}

/* Large slanted triangles fill little of their boxes. Where no spatial splits will cut them (see pti_find_cut), they are cut
   into pieces with boxes of their own before the tree is built (Ernst and Greiner 2007): each piece still means the whole
   triangle. What a box of half area A wastes around edges e1 and e2,
       w = A - |e1 x e2|_1    (0 for a parallelogram's half that lies along the axes),
   k pieces make w / k; for a given number of pieces in all, the sum is least with k proportional to sqrt(w). Only what stands
   out is worth it: k = sqrt(w) / reach, rounded down, and reach is twice the mean of sqrt(w), more if room is scarce. So
   meshes of like triangles stay whole. */
static float pti_waste(const pti_bounds *box, pt_vec3 c) {           /* sqrt(w); c = e1 x e2 */
    float waste = pti_bounds_area(box) - (fabsf(c.x) + fabsf(c.y) + fabsf(c.z));
    return waste > 0 && waste <= FLT_MAX ? sqrtf(waste) : 0.0f;
}
/* A slice of all primitives, and what it has in their box. What can not be hit, triangles without area and mere bounds of volumes,
   gets an empty box. */
static void pti_collect_slice(void *user, size_t slice) {
    pti_builder *b = (pti_builder *)user;
    const pti_geometry *g = b->g;
    uint32_t i = (uint32_t)slice * PTI_SLICE, end = g->prim_count - i < PTI_SLICE ? g->prim_count : i + PTI_SLICE;
    const pti_shape *s = g->shapes + pti_find_shape(g, i);
    pti_box boxes = pti_box_empty(), centers = boxes;
    size_t left_out = 0;
    for (; i < end; i++) {
        pti_bounds box;
        pti_f4 lo, hi;
        pti_ref *r = b->refs + i;
        while (i - s->first >= s->count) s++;
        if (s->bounds_only) box = pti_bounds_empty();
        else if (s->kind == PTI_MESH) {
            pt_vec3 v[3], c;
            pti_mesh_triangle(&s->as.mesh, i - s->first, v);
            box = pti_bounds_empty();
            c = pti_cross(pti_sub(v[1], v[0]), pti_sub(v[2], v[0]));
            if (!pti_is_zero3(c)) {
                box.lo = pti_min3(v[0], pti_min3(v[1], v[2]));
                box.hi = pti_max3(v[0], pti_max3(v[1], v[2]));
                if (b->wastes) ((float *)(void *)b->places)[i] = pti_waste(&box, c);
            }
        } else box = pti_object_bounds(s, PTI_REACH_ENOUGH);
        r->lo[0] = box.lo.x; r->lo[1] = box.lo.y; r->lo[2] = box.lo.z; r->shape = (uint32_t)(s - g->shapes) ^ PTI_MIDDLING;
        r->hi[0] = box.hi.x; r->hi[1] = box.hi.y; r->hi[2] = box.hi.z; r->prim = (i - s->first) ^ PTI_MIDDLING;
        if (!(box.lo.x <= box.hi.x)) { left_out++; continue; }
        lo = pti_f4_of(box.lo.x, box.lo.y, box.lo.z, 0);
        hi = pti_f4_of(box.hi.x, box.hi.y, box.hi.z, 0);
        pti_box_merge(&boxes, lo, hi);
        pti_box_add(&centers, pti_f4_add(lo, hi));
    }
    pti_lock(&b->lock);
    b->left_out += left_out;
    pti_box_merge(&b->all.box, boxes.lo, boxes.hi);
    pti_box_merge(&b->all.centers, centers.lo, centers.hi);
    pti_unlock(&b->lock);
}
static void pti_collect(pti_builder *b) {
    size_t i, slices = ((size_t)b->g->prim_count + PTI_SLICE - 1) / PTI_SLICE;
    pti_f4 zero = pti_f4_set(0);
    b->all.box = b->all.centers = pti_box_empty();
    pti_parallel(b->threads, pti_collect_slice, b, slices);
    b->all.box.lo = pti_f4_add(b->all.box.lo, zero);     /* -0 becomes +0: which of the two came first, only threads know */
    b->all.box.hi = pti_f4_add(b->all.box.hi, zero);
    if (!b->left_out) b->count = b->g->prim_count;
    for (i = 0; i < b->g->prim_count && b->left_out; i++) {
        if (!(b->refs[i].lo[0] <= b->refs[i].hi[0])) continue;
        if (b->count < i) { b->refs[b->count] = b->refs[i]; b->places[b->count] = b->places[i]; }
        b->count++;
    }
}

static float pti_ref_axis(const pti_ref *r, int k) { return r->hi[k] - r->lo[k]; }
static void pti_ref_cut(pti_builder *b, size_t at, int pieces, const pt_vec3 v[3]) {
    pti_ref *r = b->refs + at, *other = b->refs + b->count;
    int axis = pti_ref_axis(r, 1) > pti_ref_axis(r, 0) ? 1 : 0, left = pieces / 2;
    float cut, lo, hi;
    if (pieces < 2 || b->count == b->room) { pti_box_add(&b->all.centers, pti_ref_center(r)); return; }
    if (pti_ref_axis(r, 2) > pti_ref_axis(r, axis)) axis = 2;
    lo = r->lo[axis]; hi = r->hi[axis];
    cut = lo + (hi - lo) * ((float)left / (float)pieces);
    *other = *r;
    pti_ref_clip(r, v, axis, lo, cut);
    pti_ref_clip(other, v, axis, cut, hi);
    b->count++;
    pti_ref_cut(b, at, left, v);
    pti_ref_cut(b, (size_t)(other - b->refs), pieces - left, v);
}
#define PTI_PIECES 64                                    /* that a triangle is cut into at most */
static int pti_pieces(float waste, float reach) { return waste < PTI_PIECES * reach ? (int)(waste / reach) : PTI_PIECES; }
static size_t pti_pieces_more(const pti_builder *b, const float *waste, float reach) {
    size_t i, more = 0;
    for (i = 0; i < b->count; i++) if (waste[i] > 2 * reach) more += (size_t)pti_pieces(waste[i], reach) - 1;
    return more;
}
/* Where many stand out and space may be split, that is done instead: it cuts only where it helps. */
#define PTI_STAND_OUT 64                                 /* more than one piece for so many triangles */
static void pti_cut_refs(pti_builder *b) {
    const float *waste = (const float *)(const void *)b->places;
    size_t i, whole = b->count;
    double sum = 0;
    float reach;
    for (i = 0; i < whole; i++) sum += (double)waste[i];
    reach = (float)(sum / (double)whole) * 2;
    b->cuts = b->cuts && reach > 0 && pti_pieces_more(b, waste, reach) > whole / PTI_STAND_OUT;
    if (reach > 0 && !b->cuts) {
        while (pti_pieces_more(b, waste, reach) > b->room - b->g->prim_count) reach *= 1.3f;
        for (i = 0; i < whole; i++) {
            pt_vec3 v[3];
            if (!(waste[i] > 2 * reach)) continue;
            pti_ref_triangle(b, b->refs + i, v);
            pti_ref_cut(b, i, pti_pieces(waste[i], reach), v);
        }
    }
    memset(b->places, 0, b->g->prim_count * sizeof *b->places);
}
static int pti_shrink(const pt_allocator *a, void **array, size_t count, size_t *capacity, size_t size) {
    void *p;
    if (count == *capacity) return 1;
    p = count ? pti_alloc(a, count, size) : NULL;
    if (count && !p) return 0;
    if (count) memcpy(p, *array, count * size);
    pti_free(a, *array, *capacity, size);
    *array = p;
    *capacity = count;
    return 1;
}
static void pti_bvh_free(pti_bvh *bvh, const pt_allocator *a) {
    pti_free(a, bvh->blocks, bvh->block_count, sizeof *bvh->blocks);
    memset(bvh, 0, sizeof *bvh);
}
/* The t of a hit lies between those of the triangle's corners; rounding moves it by a part of what is between them, which may be
   much more than a part of t: a floor of a kilometre is hit at one metre. A box that is no farther behind a hit than that may
   still hold what comes before it, and is looked into, lest the order of visits decide. (Needles can be worse: the thinner, the
   less t means.) */
static void pti_bvh_slack(pti_bvh *bvh) {
    bvh->slack = pti_largest_abs(pti_sub(bvh->bounds.hi, bvh->bounds.lo)) * (1.0f / 65536);
}
static int pti_bvh_place(pti_builder *b, const pt_allocator *a) {
    pti_bvh *bvh = &b->g->bvh;
    pti_branch whole = pti_branch_make(0, b->room, b->top);
    pti_places *rest = (pti_places *)pti_alloc(a, 1, sizeof *rest);
    size_t used = 0, i;
    if (!rest) return 0;
    rest->builder = b;
    rest->most = b->room / PTI_TASKS;
    pti_lay_out(b, &whole, &used, rest);                 /* how much room is needed */
    pti_parallel(b->threads, pti_lay_out_task, rest, rest->count);
    for (i = 0; i < rest->count; i++) { rest->place[i].at = used; used += rest->place[i].size; }
    bvh->block_count = used;
    bvh->blocks = (pti_block *)pti_alloc_unset(a, used, sizeof *bvh->blocks);
    if (bvh->blocks) {
        used = 0;
        pti_branch_box(b, &whole, &bvh->bounds);
        pti_bvh_slack(bvh);
        bvh->root = pti_lay_out(b, &whole, &used, rest);
        pti_parallel(b->threads, pti_lay_out_task, rest, rest->count);
        pti_parallel(b->threads, pti_pack_slice, b, (b->room + PTI_SLICE - 1) / PTI_SLICE);
    }
    pti_free(a, rest, 1, sizeof *rest);
    return bvh->blocks != NULL;
}
/* Refit: the boxes of a tree of the same shape over vertices that have moved, from the leaves up. Pieces of cut triangles get the
   whole triangle's box. Threads take the subtrees two levels down; pti_refit_find and pti_refit_child walk alike, so that the
   k-th box found is the k-th asked for. */
typedef struct pti_refit {
    pti_geometry *g;
    uint32_t child[PTI_WIDTH * PTI_WIDTH];
    pti_bounds box[PTI_WIDTH * PTI_WIDTH];
    size_t count, next;
} pti_refit;

/* A packet's triangles side by side. Lanes without one borrow the first one's, and are NaN again afterwards; so are those of
   triangles that are flat for now, lest rounding, seen from elsewhere, let rays hit them. */
typedef struct pti_f4_point { pti_f4 x, y, z; } pti_f4_point;
PTI_INLINE pti_f4_point pti_refit_corner(const float *const p[PTI_LANES], float row[3][PTI_LANES]) {
    pti_f4_point v;
    v.x = pti_f4_of(p[0][0], p[1][0], p[2][0], p[3][0]);
    v.y = pti_f4_of(p[0][1], p[1][1], p[2][1], p[3][1]);
    v.z = pti_f4_of(p[0][2], p[1][2], p[2][2], p[3][2]);
    pti_f4_store(row[0], v.x); pti_f4_store(row[1], v.y); pti_f4_store(row[2], v.z);
    return v;
}
PTI_INLINE pti_f4_point pti_f4_edge(const pti_f4_point *a, const pti_f4_point *b) {
    pti_f4_point e;
    e.x = pti_f4_sub(b->x, a->x); e.y = pti_f4_sub(b->y, a->y); e.z = pti_f4_sub(b->z, a->z);
    return e;
}
PTI_INLINE pti_f4 pti_f4_less_abs(pti_f4 a) { return pti_f4_min(a, pti_f4_sub(pti_f4_set(0), a)); }      /* -|a| */
PTI_INLINE uint32_t pti_refit_flat(const pti_f4_point v[3]) {        /* bit k: (b - a) x (c - a) of the k-th is 0, or NaN */
    pti_f4_point a = pti_f4_edge(v, v + 1), b = pti_f4_edge(v, v + 2);
    pti_f4 x = pti_f4_less_abs(pti_f4_sub(pti_f4_mul(a.y, b.z), pti_f4_mul(a.z, b.y)));
    pti_f4 y = pti_f4_less_abs(pti_f4_sub(pti_f4_mul(a.z, b.x), pti_f4_mul(a.x, b.z)));
    pti_f4 z = pti_f4_less_abs(pti_f4_sub(pti_f4_mul(a.x, b.y), pti_f4_mul(a.y, b.x)));
    return (uint32_t)pti_f4_negative(pti_f4_min(x, pti_f4_min(y, z))) ^ 15u;
}
static void pti_refit_unset(pti_packet *p, uint32_t lanes) {
    int corner, axis;
    for (; lanes; lanes &= lanes - 1)
        for (corner = 0; corner < 3; corner++)
            for (axis = 0; axis < 3; axis++) memset(&p->v[corner][axis][pti_lowest_bit(lanes)], 0xff, sizeof(float));
}
PTI_INLINE void pti_refit_span(const pti_f4 *a, const pti_f4 *b, const pti_f4 *c, uint32_t flat, float *least, float *most) {
    float lo[4], hi[4];
    int k;
    pti_f4_store(lo, pti_f4_min(*a, pti_f4_min(*b, *c)));
    pti_f4_store(hi, pti_f4_max(*a, pti_f4_max(*b, *c)));
    for (k = 0; flat; k++, flat >>= 1) if (flat & 1) { lo[k] = FLT_MAX; hi[k] = -FLT_MAX; }
    *least = pti_min(pti_min(lo[0], lo[1]), pti_min(lo[2], lo[3]));
    *most = pti_max(pti_max(hi[0], hi[1]), pti_max(hi[2], hi[3]));
}
static pti_bounds pti_refit_packet(const pti_geometry *g, pti_packet *p) {
    const pti_shape *s = g->shapes + pti_find_shape(g, p->prim[0]);
    const float *at[3][PTI_LANES];
    pti_f4_point v[3];
    pti_bounds bounds;
    uint32_t flat, empty = 0;
    int lane;
    for (lane = 0; lane < PTI_LANES; lane++) {
        const pti_mesh *m;
        uint32_t prim = p->prim[lane];
        if (prim == PTI_NONE) { empty |= 1u << lane; prim = p->prim[0]; }
        if (prim - s->first >= s->count) s = g->shapes + pti_find_shape(g, prim);
        m = &s->as.mesh;
        at[0][lane] = pti_mesh_vertex(m, pti_mesh_index(m, prim - s->first, 0));
        at[1][lane] = pti_mesh_vertex(m, pti_mesh_index(m, prim - s->first, 1));
        at[2][lane] = pti_mesh_vertex(m, pti_mesh_index(m, prim - s->first, 2));
    }
    v[0] = pti_refit_corner(at[0], p->v[0]);
    v[1] = pti_refit_corner(at[1], p->v[1]);
    v[2] = pti_refit_corner(at[2], p->v[2]);
    flat = pti_refit_flat(v);
    if (flat | empty) pti_refit_unset(p, flat | empty);
    pti_refit_span(&v[0].x, &v[1].x, &v[2].x, flat, &bounds.lo.x, &bounds.hi.x);
    pti_refit_span(&v[0].y, &v[1].y, &v[2].y, flat, &bounds.lo.y, &bounds.hi.y);
    pti_refit_span(&v[0].z, &v[1].z, &v[2].z, flat, &bounds.lo.z, &bounds.hi.z);
    return bounds;
}
/* Where a packet's triangles lie in memory is anyone's guess: so the places are told before any is waited for. */
static void pti_refit_fetch(const pti_geometry *g, uint32_t child) {
    const pti_packet *p = pti_packet_at(&g->bvh, child);
    const pti_shape *s = g->shapes + pti_find_shape(g, p->prim[0]);
    int lane;
    for (lane = 0; lane < PTI_LANES && s->as.mesh.indices; lane++)
        if (p->prim[lane] - s->first < s->count) PTI_FETCH(s->as.mesh.indices + 3 * (size_t)(p->prim[lane] - s->first));
}
static pti_bounds pti_refit_child(pti_refit *r, uint32_t child, int above) {      /* above: levels that no thread has done */
    const pti_geometry *g = r->g;
    pti_bounds whole = pti_bounds_empty(), box;
    pti_node *n;
    int k;
    if (PTI_KIND(child) == PTI_LEAF) return pti_refit_packet(g, pti_packet_at(&g->bvh, child));
    if (PTI_KIND(child) == PTI_OBJECT) {
        const pti_shape *s = g->shapes + PTI_INDEX(child);
        return pti_object_bounds(s, PTI_REACH_REFIT);
    }
    if (above == 1) return r->box[r->next++];
    n = pti_node_at(&g->bvh, child);
    for (k = 0; k < PTI_WIDTH; k++) if (PTI_KIND(n->child[k]) == PTI_LEAF) pti_refit_fetch(g, n->child[k]);
    for (k = 0; k < PTI_WIDTH; k++) {
        if (n->child[k] == PTI_NONE) continue;
        box = pti_refit_child(r, n->child[k], above - 1);
        pti_node_set(n, k, &box, n->child[k]);
        pti_bounds_merge(&whole, &box);
    }
    return whole;
}
static void pti_refit_task(void *user, size_t i) {
    pti_refit *r = (pti_refit *)user;
    r->box[i] = pti_refit_child(r, r->child[i], 0);
}
static void pti_refit_find(pti_refit *r, uint32_t child, int above) {
    const pti_node *n = pti_node_at(&r->g->bvh, child);
    int k;
    if (PTI_KIND(child) != PTI_INNER) return;
    if (above == 1) { r->child[r->count++] = child; return; }
    for (k = 0; k < PTI_WIDTH; k++) pti_refit_find(r, n->child[k], above - 1);
}
static void pti_bvh_refit(pti_geometry *g, int threads) {
    pti_refit r;
    if (g->bvh.root == PTI_NONE) return;
    r.g = g;
    r.count = r.next = 0;
    pti_refit_find(&r, g->bvh.root, 3);
    pti_parallel(threads, pti_refit_task, &r, r.count);
    g->bvh.bounds = pti_refit_child(&r, g->bvh.root, 3);
    pti_bvh_slack(&g->bvh);
}
/* How many bins; how many pieces more than triangles at most (one for so many); whether space may be split. */
static const struct { int bins; uint32_t per_piece; int cuts; } pti_qualities[] = { { 16, 8, 0 }, { 8, 0, 0 }, { 32, 2, 1 } };

static int pti_bvh_build(pti_geometry *g, const pt_allocator *a, pt_quality quality, int threads) {  /* 0 when out of memory */
    uint32_t per_piece = pti_qualities[quality].per_piece;
    pti_builder b;
    int fine, locked;
    memset(&b, 0, sizeof b);
    b.g = g;
    b.threads = threads;
    b.bins = pti_qualities[quality].bins;
    b.room = (size_t)g->prim_count + (per_piece ? g->prim_count / per_piece : 0);
    b.refs = (pti_ref *)pti_alloc_unset(a, b.room, sizeof *b.refs);
    b.splits = (pti_halves *)pti_alloc_unset(a, pti_most_splits(b.room), sizeof *b.splits);
    b.places = (uint32_t *)pti_alloc(a, b.room, sizeof *b.places);
    locked = pti_mutex_init(&b.lock);
    fine = b.refs && b.splits && b.places && locked;
    if (fine) memset(b.splits, 0, sizeof *b.splits);     /* what leaves have instead of a split; looked at, but not used */
    g->bvh.root = PTI_NONE;
    g->bvh.bounds = pti_bounds_empty();
    b.wastes = per_piece > 0;
    if (fine) pti_collect(&b);
    g->bvh.left_out = (uint32_t)b.left_out;
    b.cuts = pti_qualities[quality].cuts;
    if (b.count && per_piece) pti_cut_refs(&b);
    if (b.count) {
        b.all.end = b.count;
        b.all.room = b.cuts ? b.room : b.count;
        b.all.link = &b.top;
        b.area = pti_box_area(&b.all.box);
        pti_build_splits(&b);
        fine = pti_bvh_place(&b, a);
    }
    pti_free(a, b.refs, b.room, sizeof *b.refs);
    pti_free(a, b.splits, pti_most_splits(b.room), sizeof *b.splits);
    pti_free(a, b.places, b.room, sizeof *b.places);
    if (locked) pti_mutex_free(&b.lock);
    return fine;
}

/* ---- >>kernel ------------------------------------------------------------------------------------------
   The two kernels that have instructions of their own, ray x eight boxes and ray x four triangles, and the traversal that
   they are put into. The triangle kernels do the very operations of pti_triangle, in its order, so that all give the same
   bits. The box kernels may differ in the last bits, as they only choose what is looked at; all look a little farther than they
   must. */

/* Bit k: the ray enters child k between tmin and limit, the widened tmax; enter[k] is where. */
typedef uint32_t pti_boxes_kernel(const pti_node *n, const pti_ray *r, float limit, float enter[PTI_WIDTH]);
/* Bit k: the ray hits triangle k between tmin and tmax, there. The wide kernels leave the rare zeros of pti_edge to it. */
typedef uint32_t pti_triangles_kernel(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out);

PTI_INLINE const float *pti_planes(const pti_node *n, size_t at) {
    return (const float *)(const void *)((const char *)n->plane + at);
}
/* The triangles of `which`, one after the other; bits of mask are set and cleared. */
static uint32_t pti_triangles_again(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out, uint32_t which,
                                    uint32_t mask) {
    mask &= ~which;
    for (; which; which &= which - 1) {
        int k = pti_lowest_bit(which);
        if (pti_triangle(p, k, r, out) && out->t[k] <= tmax) mask |= 1u << k;
    }
    return mask;
}

static inline uint32_t pti_boxes_scalar(const pti_node *n, const pti_ray *r, float limit, float enter[PTI_WIDTH]) {
    const float *x0 = pti_planes(n, r->rows->near_at[0]), *x1 = pti_planes(n, r->rows->far_at[0]);
    const float *y0 = pti_planes(n, r->rows->near_at[1]), *y1 = pti_planes(n, r->rows->far_at[1]);
    const float *z0 = pti_planes(n, r->rows->near_at[2]), *z1 = pti_planes(n, r->rows->far_at[2]);
    uint32_t mask = 0;
    int k;
    for (k = 0; k < PTI_WIDTH; k++) {
        float t0 = pti_max(x0[k] * r->near_inverse[0] + r->near_add[0], y0[k] * r->near_inverse[1] + r->near_add[1]);
        float t1 = pti_min(x1[k] * r->far_inverse[0] + r->far_add[0], y1[k] * r->far_inverse[1] + r->far_add[1]);
        t0 = pti_max(pti_max(t0, z0[k] * r->near_inverse[2] + r->near_add[2]), r->tmin);
        t1 = pti_min(pti_min(t1, z1[k] * r->far_inverse[2] + r->far_add[2]), limit);
        enter[k] = t0;
        mask |= (uint32_t)(t0 <= t1) << k;
    }
    return mask;
}
static inline uint32_t pti_triangles_scalar(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out) {
    return pti_triangles_again(p, r, tmax, out, (1u << PTI_LANES) - 1, 0);
}

#if defined(PTI_X86)
PTI_INLINE __m128 pti_slab_sse2(const float *row, float inverse, float add) {
    return _mm_add_ps(_mm_mul_ps(_mm_loadu_ps(row), _mm_set1_ps(inverse)), _mm_set1_ps(add));
}
static inline uint32_t pti_boxes_sse2(const pti_node *n, const pti_ray *r, float limit, float enter[PTI_WIDTH]) {
    uint32_t mask = 0;
    int h;
    for (h = 0; h < PTI_WIDTH; h += 4) {
        __m128 t0 = _mm_max_ps(pti_slab_sse2(pti_planes(n, r->rows->near_at[0]) + h, r->near_inverse[0], r->near_add[0]),
                               pti_slab_sse2(pti_planes(n, r->rows->near_at[1]) + h, r->near_inverse[1], r->near_add[1]));
        __m128 t1 = _mm_min_ps(pti_slab_sse2(pti_planes(n, r->rows->far_at[0]) + h, r->far_inverse[0], r->far_add[0]),
                               pti_slab_sse2(pti_planes(n, r->rows->far_at[1]) + h, r->far_inverse[1], r->far_add[1]));
        t0 = _mm_max_ps(t0, pti_slab_sse2(pti_planes(n, r->rows->near_at[2]) + h, r->near_inverse[2], r->near_add[2]));
        t1 = _mm_min_ps(t1, pti_slab_sse2(pti_planes(n, r->rows->far_at[2]) + h, r->far_inverse[2], r->far_add[2]));
        t0 = _mm_max_ps(t0, _mm_set1_ps(r->tmin));
        t1 = _mm_min_ps(t1, _mm_set1_ps(limit));
        _mm_storeu_ps(enter + h, t0);
        mask |= (uint32_t)_mm_movemask_ps(_mm_cmple_ps(t0, t1)) << h;
    }
    return mask;
}
PTI_INLINE __m128 pti_row_sse2(const pti_packet *p, int corner, size_t row, float origin) {
    return _mm_sub_ps(_mm_loadu_ps(pti_packet_row(p, corner, row)), _mm_set1_ps(origin));
}
PTI_INLINE __m128 pti_difference_sse2(__m128 a, __m128 b, __m128 c, __m128 d) {      /* a b - c d */
    return _mm_sub_ps(_mm_mul_ps(a, b), _mm_mul_ps(c, d));
}
PTI_INLINE uint32_t pti_triangles_x86(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out) {
    __m128 sx = _mm_set1_ps(r->sx), sy = _mm_set1_ps(r->sy), zero = _mm_setzero_ps();
    __m128 az = pti_row_sse2(p, 0, r->kz, r->oz), bz = pti_row_sse2(p, 1, r->kz, r->oz), cz = pti_row_sse2(p, 2, r->kz, r->oz);
    __m128 ax = _mm_sub_ps(pti_row_sse2(p, 0, r->kx, r->ox), _mm_mul_ps(sx, az));
    __m128 ay = _mm_sub_ps(pti_row_sse2(p, 0, r->ky, r->oy), _mm_mul_ps(sy, az));
    __m128 bx = _mm_sub_ps(pti_row_sse2(p, 1, r->kx, r->ox), _mm_mul_ps(sx, bz));
    __m128 by = _mm_sub_ps(pti_row_sse2(p, 1, r->ky, r->oy), _mm_mul_ps(sy, bz));
    __m128 cx = _mm_sub_ps(pti_row_sse2(p, 2, r->kx, r->ox), _mm_mul_ps(sx, cz));
    __m128 cy = _mm_sub_ps(pti_row_sse2(p, 2, r->ky, r->oy), _mm_mul_ps(sy, cz));
    __m128 U = pti_difference_sse2(cx, by, cy, bx), V = pti_difference_sse2(ax, cy, ay, cx);
    __m128 W = pti_difference_sse2(bx, ay, by, ax), det, t;
    __m128 least = _mm_min_ps(_mm_min_ps(U, V), W), most = _mm_max_ps(_mm_max_ps(U, V), W);
    __m128 hit = _mm_or_ps(_mm_cmpge_ps(least, zero), _mm_cmple_ps(most, zero));
    uint32_t zeros;
    if (!_mm_movemask_ps(hit)) return 0;
    zeros = (uint32_t)_mm_movemask_ps(_mm_and_ps(hit, _mm_or_ps(_mm_cmpeq_ps(least, zero), _mm_cmpeq_ps(most, zero))));
    det = _mm_add_ps(_mm_add_ps(U, V), W);
    t = _mm_add_ps(_mm_add_ps(_mm_mul_ps(U, az), _mm_mul_ps(V, bz)), _mm_mul_ps(W, cz));
    hit = _mm_and_ps(hit, _mm_cmpgt_ps(_mm_andnot_ps(_mm_set1_ps(-0.0f), t), _mm_set1_ps(PTI_LEAST)));
    t = _mm_div_ps(_mm_mul_ps(_mm_set1_ps(r->sz), t), det);
    hit = _mm_and_ps(hit, _mm_cmpgt_ps(t, _mm_set1_ps(r->tmin)));
    hit = _mm_and_ps(hit, _mm_cmple_ps(t, _mm_set1_ps(tmax)));
    _mm_storeu_ps(out->t, t);
    _mm_storeu_ps(out->V, V);
    _mm_storeu_ps(out->W, W);
    _mm_storeu_ps(out->det, det);
    if (zeros) return pti_triangles_again(p, r, tmax, out, zeros, (uint32_t)_mm_movemask_ps(hit));
    return (uint32_t)_mm_movemask_ps(hit);
}
static inline uint32_t pti_triangles_sse2(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out) {
    return pti_triangles_x86(p, r, tmax, out);
}
PTI_AVX2 PTI_INLINE uint32_t pti_triangles_avx2(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out) {
    return pti_triangles_x86(p, r, tmax, out);           /* the same, in the shorter encoding */
}
/* The other way round: which are missed. As integers, floats compare in a quarter of the time, and the same way unless both are
   negative. The entry is not, since tmin is not; and of exits that are, it is enough that they are below it. */
PTI_AVX2 PTI_INLINE __m256 pti_boxes_avx2(const pti_node *n, const pti_ray *r, float limit, __m256 *enter) {
#define PTI_SLAB(which, k) _mm256_castps_si256(_mm256_fmadd_ps(_mm256_loadu_ps(pti_planes(n, r->rows->which##_at[k])), \
    _mm256_broadcast_ss(&r->which##_inverse[k]), _mm256_broadcast_ss(&r->which##_add[k])))
    __m256i x0 = PTI_SLAB(near, 0), y0 = PTI_SLAB(near, 1), z0 = PTI_SLAB(near, 2);
    __m256i x1 = PTI_SLAB(far, 0), y1 = PTI_SLAB(far, 1), z1 = PTI_SLAB(far, 2), t0, t1;
#undef PTI_SLAB
    t0 = _mm256_max_epi32(_mm256_max_epi32(x0, y0), _mm256_max_epi32(z0, _mm256_castps_si256(_mm256_broadcast_ss(&r->tmin))));
    t1 = _mm256_min_epi32(_mm256_min_epi32(x1, y1), _mm256_min_epi32(z1, _mm256_castps_si256(_mm256_set1_ps(limit))));
    *enter = _mm256_castsi256_ps(t0);
    return _mm256_castsi256_ps(_mm256_cmpgt_epi32(t0, t1));
}
#endif

#if defined(PTI_NEON)
PTI_INLINE float32x4_t pti_slab_neon(const float *row, float inverse, float add) {
    return vfmaq_n_f32(vdupq_n_f32(add), vld1q_f32(row), inverse);
}
static inline uint32_t pti_boxes_neon(const pti_node *n, const pti_ray *r, float limit, float enter[PTI_WIDTH]) {
    uint32_t mask = 0;
    int h;
    for (h = 0; h < PTI_WIDTH; h += 4) {
        float32x4_t t0 = vmaxq_f32(pti_slab_neon(pti_planes(n, r->rows->near_at[0]) + h, r->near_inverse[0], r->near_add[0]),
                                   pti_slab_neon(pti_planes(n, r->rows->near_at[1]) + h, r->near_inverse[1], r->near_add[1]));
        float32x4_t t1 = vminq_f32(pti_slab_neon(pti_planes(n, r->rows->far_at[0]) + h, r->far_inverse[0], r->far_add[0]),
                                   pti_slab_neon(pti_planes(n, r->rows->far_at[1]) + h, r->far_inverse[1], r->far_add[1]));
        t0 = vmaxq_f32(t0, pti_slab_neon(pti_planes(n, r->rows->near_at[2]) + h, r->near_inverse[2], r->near_add[2]));
        t1 = vminq_f32(t1, pti_slab_neon(pti_planes(n, r->rows->far_at[2]) + h, r->far_inverse[2], r->far_add[2]));
        t0 = vmaxq_f32(t0, vdupq_n_f32(r->tmin));
        t1 = vminq_f32(t1, vdupq_n_f32(limit));
        vst1q_f32(enter + h, t0);
        mask |= pti_mask_neon(vcleq_f32(t0, t1)) << h;
    }
    return mask;
}
PTI_INLINE float32x4_t pti_row_neon(const pti_packet *p, int corner, size_t row, float origin) {
    return vsubq_f32(vld1q_f32(pti_packet_row(p, corner, row)), vdupq_n_f32(origin));
}
/* a b - c d */
PTI_INLINE float32x4_t pti_difference_neon(float32x4_t a, float32x4_t b, float32x4_t c, float32x4_t d) {
    return vsubq_f32(vmulq_f32(a, b), vmulq_f32(c, d));
}
static inline uint32_t pti_triangles_neon(const pti_packet *p, const pti_ray *r, float tmax, pti_lanes *out) {
    float32x4_t sx = vdupq_n_f32(r->sx), sy = vdupq_n_f32(r->sy), zero = vdupq_n_f32(0);
    float32x4_t az = pti_row_neon(p, 0, r->kz, r->oz), bz = pti_row_neon(p, 1, r->kz, r->oz), cz = pti_row_neon(p, 2, r->kz, r->oz);
    float32x4_t ax = vsubq_f32(pti_row_neon(p, 0, r->kx, r->ox), vmulq_f32(sx, az));
    float32x4_t ay = vsubq_f32(pti_row_neon(p, 0, r->ky, r->oy), vmulq_f32(sy, az));
    float32x4_t bx = vsubq_f32(pti_row_neon(p, 1, r->kx, r->ox), vmulq_f32(sx, bz));
    float32x4_t by = vsubq_f32(pti_row_neon(p, 1, r->ky, r->oy), vmulq_f32(sy, bz));
    float32x4_t cx = vsubq_f32(pti_row_neon(p, 2, r->kx, r->ox), vmulq_f32(sx, cz));
    float32x4_t cy = vsubq_f32(pti_row_neon(p, 2, r->ky, r->oy), vmulq_f32(sy, cz));
    float32x4_t U = pti_difference_neon(cx, by, cy, bx), V = pti_difference_neon(ax, cy, ay, cx);
    float32x4_t W = pti_difference_neon(bx, ay, by, ax);
    float32x4_t det, t, least = vminq_f32(vminq_f32(U, V), W), most = vmaxq_f32(vmaxq_f32(U, V), W);
    uint32x4_t hit = vorrq_u32(vcgeq_f32(least, zero), vcleq_f32(most, zero));
    uint32_t zeros;
    if (!vmaxvq_u32(hit)) return 0;
    zeros = pti_mask_neon(vandq_u32(hit, vorrq_u32(vceqq_f32(least, zero), vceqq_f32(most, zero))));
    det = vaddq_f32(vaddq_f32(U, V), W);
    t = vaddq_f32(vaddq_f32(vmulq_f32(U, az), vmulq_f32(V, bz)), vmulq_f32(W, cz));
    hit = vandq_u32(hit, vcagtq_f32(t, vdupq_n_f32(PTI_LEAST)));
    t = vdivq_f32(vmulq_n_f32(t, r->sz), det);
    hit = vandq_u32(hit, vcgtq_f32(t, vdupq_n_f32(r->tmin)));
    hit = vandq_u32(hit, vcleq_f32(t, vdupq_n_f32(tmax)));
    vst1q_f32(out->t, t);
    vst1q_f32(out->V, V);
    vst1q_f32(out->W, W);
    vst1q_f32(out->det, det);
    if (zeros) return pti_triangles_again(p, r, tmax, out, zeros, pti_mask_neon(hit));
    return pti_mask_neon(hit);
}
#endif

/* One shape that is not a mesh, nor an instance. */
static int pti_object_hit(const pti_shape *s, uint32_t index, const pti_ray *r, pti_hit *hit, uint32_t outer) {
    pt_vertex x;
    float limit = hit->t < FLT_MAX / 2 ? hit->t * PTI_WIDEN : hit->t;          /* so that ties are seen, and decided here */
    memset(&x, 0, sizeof x);
    if (s->kind == PTI_SPHERE) {
        if (!pti_sphere_hit(&s->as.sphere, r, limit, &x.t)) return 0;
    } else {
        pt_ray ray;
        ray.org = pt_v3(r->org[0], r->org[1], r->org[2]);
        ray.dir = pt_v3(r->dir[0], r->dir[1], r->dir[2]);
        ray.tmin = r->tmin; ray.tmax = limit; ray.time = r->time;
        if (!s->as.user.vtable.intersect(s->as.user.user, &ray, &x) || !(x.t > r->tmin) || !(x.t <= limit)) return 0;
    }
    if (!pti_closer(hit, x.t, outer, s->first)) return 0;
    hit->found = 1; hit->t = x.t; hit->u = x.u; hit->v = x.v; hit->ng = x.ng;
    hit->outer = outer; hit->prim = s->first; hit->shape = index + 1;
    return 1;
}
static inline int pti_packet_hit(const pti_packet *p, uint32_t mask, const pti_lanes *at, pti_hit *hit,
                                 uint32_t instance_prim, int any) {
    int found = 0;
    for (; mask; mask &= mask - 1) {
        int k = pti_lowest_bit(mask);
        uint32_t outer = instance_prim != PTI_NONE ? instance_prim : p->prim[k];
        if (!pti_closer(hit, at->t[k], outer, p->prim[k])) continue;
        hit->found = 1; hit->t = at->t[k];
        if (any) return 1;                               /* nothing else will be asked */
        hit->u = at->V[k] / at->det[k]; hit->v = at->W[k] / at->det[k];
        hit->outer = outer; hit->prim = p->prim[k]; hit->shape = 0;
        found = 1;
    }
    return found;
}

/* A place that will be visited soon: branches before that are often mispredicted, and then it is on its way already. (Objects are
   elsewhere, marks nowhere; an idle fetch does no harm.) */
PTI_INLINE void pti_prefetch(const pti_bvh *b, uint32_t child) {
    const char *p = (const char *)((uintptr_t)b->blocks + (uintptr_t)PTI_INDEX(child) * sizeof(pti_block));
    PTI_FETCH(p); PTI_FETCH(p + 64); PTI_FETCH(p + 128); PTI_FETCH(p + 192);
}

/* What is still to be visited, the next on top, and where the ray enters it. There is room for a whole vector above. */
typedef struct pti_stack { uint32_t child[2 * PTI_STACK + PTI_WIDTH]; float enter[2 * PTI_STACK + PTI_WIDTH]; } pti_stack;

/* Looks into a node. Returns the child that the ray enters first, or PTI_NONE, and pushes the others, the farthest first (with
   AVX2, near and far as the node's order for the ray's octant has it: quicker than to sort, and as good nearly always). Any hit
   does not care which comes first, nor where they are entered. */
typedef uint32_t pti_visit_kernel(const pti_bvh *b, const pti_node *n, const pti_ray *r, float limit, int any, pti_stack *s,
                                  int *top);

PTI_INLINE uint32_t pti_push_sorted(const pti_node *n, uint32_t mask, const float enter[PTI_WIDTH], int any, pti_stack *s,
                                    int *top) {
    int first = *top, i, k = pti_lowest_bit(mask);
    if (!(mask & (mask - 1))) return n->child[k];
    for (; mask; mask &= mask - 1) {
        k = pti_lowest_bit(mask);
        i = (*top)++;
        if (!any) {
            for (; i > first && s->enter[i - 1] < enter[k]; i--) { s->child[i] = s->child[i - 1]; s->enter[i] = s->enter[i - 1]; }
            s->enter[i] = enter[k];
        }
        s->child[i] = n->child[k];
    }
    return s->child[--*top];
}
#define PTI_VISIT(isa) \
    PTI_INLINE uint32_t pti_visit_##isa(const pti_bvh *b, const pti_node *n, const pti_ray *r, float limit, int any, \
                                        pti_stack *s, int *top) { \
        float enter[PTI_WIDTH]; \
        uint32_t mask = pti_boxes_##isa(n, r, limit, enter); \
        (void)b; \
        return mask ? pti_push_sorted(n, mask, enter, any, s, top) : PTI_NONE; \
    }
PTI_VISIT(scalar)
#if defined(PTI_X86)
PTI_VISIT(sse2)
#elif defined(PTI_NEON)
PTI_VISIT(neon)
#endif

#if defined(PTI_X86)
/* Which bits of m are set, four bits each, the last lowest. */
#define PTI_BIT(m, k) ((uint32_t)(m) >> (k) & 1u)
#define PTI_PUT(m, k, at) (PTI_BIT(m, k) * (k##u << 4 * (at)))
#define PTI_BITS(m) PTI_PUT(m, 6, PTI_BIT(m, 7)) + PTI_PUT(m, 5, PTI_BIT(m, 7) + PTI_BIT(m, 6)) \
    + PTI_PUT(m, 4, PTI_BIT(m, 7) + PTI_BIT(m, 6) + PTI_BIT(m, 5)) \
    + PTI_PUT(m, 3, PTI_BIT(m, 7) + PTI_BIT(m, 6) + PTI_BIT(m, 5) + PTI_BIT(m, 4)) \
    + PTI_PUT(m, 2, PTI_BIT(m, 7) + PTI_BIT(m, 6) + PTI_BIT(m, 5) + PTI_BIT(m, 4) + PTI_BIT(m, 3)) \
    + PTI_PUT(m, 1, PTI_BIT(m, 7) + PTI_BIT(m, 6) + PTI_BIT(m, 5) + PTI_BIT(m, 4) + PTI_BIT(m, 3) + PTI_BIT(m, 2)) \
    + PTI_PUT(m, 7, 0)
#define PTI_BITS4(m) PTI_BITS(m), PTI_BITS(m + 1), PTI_BITS(m + 2), PTI_BITS(m + 3)
#define PTI_BITS16(m) PTI_BITS4(m), PTI_BITS4(m + 4), PTI_BITS4(m + 8), PTI_BITS4(m + 12)
#define PTI_BITS64(m) PTI_BITS16(m), PTI_BITS16(m + 16), PTI_BITS16(m + 32), PTI_BITS16(m + 48)
static const uint32_t pti_set_bits[256] = { PTI_BITS64(0), PTI_BITS64(64), PTI_BITS64(128), PTI_BITS64(192) };

/* Lane k: the k-th of eight times four bits (and what is above them, which permutations ignore). */
PTI_AVX2 PTI_INLINE __m256i pti_spread_avx2(uint32_t fours) {
    return _mm256_srlv_epi32(_mm256_set1_epi32((int)fours), _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
}
/* The child of the lowest bit of mask, which is in the node's order for an octant or, for any hit, as the node has them. Where none
   is left, the last: it is only fetched. */
PTI_INLINE uint32_t pti_child_avx2(const pti_node *n, uint32_t fours, uint32_t mask, int any) {
    uint32_t k = (uint32_t)pti_lowest_bit(mask | 0x80);
    return n->child[any ? k : fours >> 4 * k & 7];
}
/* In the second of eight numbers of sixteen bits: which child is entered first, the smaller one if two are. Half of a float that is
   not negative orders them well enough; those that are missed count as 0xffff, which no float does. */
PTI_AVX2 PTI_INLINE __m128i pti_first_avx2(__m256 enter, __m256 missed) {
    __m256i high = _mm256_srli_epi32(_mm256_castps_si256(_mm256_or_ps(enter, missed)), 16);
    return _mm_minpos_epu16(_mm_packus_epi32(_mm256_castsi256_si128(high), _mm256_extracti128_si256(high, 1)));
}
/* Where that child is. */
PTI_AVX2 PTI_INLINE __m256 pti_lane_avx2(__m128i first) {
    __m256i lane = _mm256_broadcastd_epi32(_mm_srli_epi32(first, 16));
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(lane, _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)));
}
/* Most often one child is met. Else the one entered first is found and taken out, and the others are pushed in the node's order for
   this octant, which is good enough for them: all without a loop. Any hit takes them as the node has them, and does not ask whether
   there is but one: its rays are not alike, and chance would decide that branch. */
PTI_AVX2 PTI_INLINE uint32_t pti_visit_avx2(const pti_bvh *b, const pti_node *n, const pti_ray *r, float limit, int any,
                                            pti_stack *s, int *top) {
    __m256 enter, missed = pti_boxes_avx2(n, r, limit, &enter);
    __m256i *push = (__m256i *)(void *)(s->child + *top), children = _mm256_loadu_si256((const __m256i *)(const void *)n->child);
    uint32_t fours = n->order[r->octant], mask = (uint32_t)_mm256_movemask_ps(missed) ^ 0xffu, next;
    __m256i order = pti_spread_avx2(fours), pick;
    __m128i first;
    if (!mask) return PTI_NONE;
    if (!any && !(mask & (mask - 1))) {
        next = n->child[pti_lowest_bit(mask)];
        pti_prefetch(b, next);
        return next;
    }
    if (any) {
        next = pti_child_avx2(n, fours, mask, any);
        pti_prefetch(b, next);
        mask &= mask - 1;
    } else {
        first = pti_first_avx2(enter, missed);
        next = n->child[_mm_extract_epi16(first, 1)];
        pti_prefetch(b, next);
        missed = _mm256_permutevar8x32_ps(_mm256_or_ps(missed, pti_lane_avx2(first)), order);
        mask = (uint32_t)_mm256_movemask_ps(missed) ^ 0xffu;
    }
    pti_prefetch(b, pti_child_avx2(n, fours, mask, any));
    if (any) pti_prefetch(b, pti_child_avx2(n, fours, mask & (mask - 1), any));
    pick = pti_spread_avx2(pti_set_bits[mask]);
    if (!any) {
        pick = _mm256_permutevar8x32_epi32(order, pick);
        _mm256_storeu_ps(s->enter + *top, _mm256_permutevar8x32_ps(enter, pick));
    }
    _mm256_storeu_si256(push, _mm256_permutevar8x32_epi32(children, pick));
    *top += __builtin_popcount(mask);
    return next;
}
#endif

/* A ray prepared for a tree. At its far end the tree's slack is added as it goes; at its start, a triangle that it lies on, or
   within rounding of, may be hit a little later than the start, though the ray leaves the triangle's box at or before it. So boxes
   are left a little later, eight ulps of the tree's size, lest it be decided by what else is in the box. (Pads know the origin's
   rounding, which is none at zero, but not the triangle's.) */
PTI_INLINE void pti_ray_enter(pti_ray *r, const pti_bvh *b, pt_vec3 org, pt_vec3 dir, float tmin, float time) {
    pti_ray_prepare(r, org, dir, tmin, time, b->slack * (65536 * PTI_ULPS_8));
}

/* Nearest hit, or any. One loop over both levels: at an instance the ray is moved into its scene, and a mark on the stack
   brings it back. The kernels are constants wherever this is used, so that they are inlined. */
PTI_INLINE int pti_traverse(const pti_geometry *scene, const pti_ray *world, pti_hit *hit, int any, pti_visit_kernel *visit,
                            pti_triangles_kernel *triangles) {
    pti_stack stack;
    pti_lanes lanes;
    const pti_geometry *g = scene;
    const pti_ray *r = world;
    pti_ray local;
    pti_instance moved;
    pti_bvh bvh = g->bvh;                                /* a copy: for all that compilers know, pushing changes *g */
    float slack = bvh.slack * fabsf(r->sz), limit = hit->t * PTI_WIDEN + slack;
    uint32_t child = bvh.root, instance = 0, instance_prim = PTI_NONE, mask;
    int top = 0, found;
    for (;;) {
        while (PTI_KIND(child) == PTI_INNER)
            child = visit(&bvh, pti_node_at(&bvh, child), r, limit, any, &stack, &top);
        found = 0;
        if (PTI_KIND(child) == PTI_LEAF) {
            const pti_packet *p = pti_packet_at(&bvh, child);
            mask = triangles(p, r, hit->t, &lanes);
            found = mask && pti_packet_hit(p, mask, &lanes, hit, instance_prim, any);
        } else if (child != PTI_NONE) {
            const pti_shape *s = g->shapes + PTI_INDEX(child);
            const pti_instance *in = &s->as.instance;
            if (s->kind != PTI_INSTANCE)
                found = pti_object_hit(s, PTI_INDEX(child), r, hit, instance_prim != PTI_NONE ? instance_prim : s->first);
            else if (!in->to_world_end || pti_instance_move(in, r->time, &moved)) {
                if (in->to_world_end) in = &moved;
                pti_ray_enter(&local, &in->of->bvh, pti_xform_point(&in->to_local, pt_v3(r->org[0], r->org[1], r->org[2])),
                              pti_xform_vector(&in->to_local, pt_v3(r->dir[0], r->dir[1], r->dir[2])), r->tmin, r->time);
                instance = PTI_INDEX(child) + 1;
                instance_prim = s->first;
                stack.child[top] = PTI_BACK;
                stack.enter[top++] = -1;
                g = in->of; r = &local; bvh = g->bvh; child = bvh.root;
                slack = bvh.slack * fabsf(r->sz);
                limit = hit->t * PTI_WIDEN + slack;
                continue;
            }
        }
        if (found) {
            hit->instance = instance;
            if (any) return 1;
            limit = hit->t * PTI_WIDEN + slack;
        }
        for (;;) {
            if (!top) return hit->found;
            child = stack.child[--top];
            if (child != PTI_BACK) {
                if (any) break;
                if (stack.enter[top] > limit) continue;  /* it lies behind what has been hit since */
                if (top) pti_prefetch(&bvh, stack.child[top - 1]);
                break;
            }
            g = scene; r = world; bvh = g->bvh;
            slack = bvh.slack * fabsf(r->sz);
            limit = hit->t * PTI_WIDEN + slack;
            instance = 0; instance_prim = PTI_NONE;
        }
    }
}

typedef int pti_trace_function(const pti_geometry *g, const pti_ray *r, pti_hit *hit, int any);
#define PTI_TRACE(isa) \
    static int pti_trace_##isa(const pti_geometry *g, const pti_ray *r, pti_hit *hit, int any) { \
        return any ? pti_traverse(g, r, hit, 1, pti_visit_##isa, pti_triangles_##isa) \
                   : pti_traverse(g, r, hit, 0, pti_visit_##isa, pti_triangles_##isa); \
    }
PTI_TRACE(scalar)
#if defined(PTI_X86)
PTI_TRACE(sse2)
PTI_AVX2 PTI_TRACE(avx2)
#elif defined(PTI_NEON)
PTI_TRACE(neon)
#endif
static pti_trace_function *pti_trace_for(int isa) {
#if defined(PTI_X86)
    if (isa == PTI_AVX2_ISA) return pti_trace_avx2;
    if (isa == PTI_SSE2_ISA) return pti_trace_sse2;
#elif defined(PTI_NEON)
    if (isa == PTI_NEON_ISA) return pti_trace_neon;
#endif
    (void)isa;
    return pti_trace_scalar;
}
PTI_INLINE void pti_hit_init(pti_hit *hit, float tmax) {
    memset(hit, 0, sizeof *hit);
    hit->t = tmax > 0 ? tmax : FLT_MAX;
}

/* From a hit to a vertex: all in the space of the hit's own scene, then out of its instance. */
static void pti_vertex_on_triangle(const pti_mesh *m, uint32_t triangle, const pti_hit *hit, pt_vertex *x) {
    pt_vec3 a, b, c, n;
    float w = 1 - hit->u - hit->v, size;
    uint32_t i = pti_mesh_index(m, triangle, 0), j = pti_mesh_index(m, triangle, 1), k = pti_mesh_index(m, triangle, 2);
    a = pti_mesh_position(m, i); b = pti_mesh_position(m, j); c = pti_mesh_position(m, k);
    x->p = pti_madd(a, w, pti_madd(b, hit->u, pti_scale(c, hit->v)));
    size = pti_max(pti_largest_abs(pti_sub(b, a)), pti_largest_abs(pti_sub(c, a)));
    x->error = PTI_ULPS_8 * (size + pti_largest_abs(x->p));
    x->ng = x->ns = pti_normalize(pti_cross(pti_sub(b, a), pti_sub(c, a)));
    if (!m->normals) return;
    n = pti_madd(pti_vec3_at(m->normals, i), w,
                 pti_madd(pti_vec3_at(m->normals, j), hit->u, pti_scale(pti_vec3_at(m->normals, k), hit->v)));
    if (!pti_is_zero3(n)) x->ns = pti_normalize(n);
}
static void pti_vertex_on_sphere(const pti_sphere *s, pt_vec3 p, pt_vertex *x) {
    x->ng = x->ns = pti_normalize(pti_sub(p, s->center));
    x->p = pti_madd(x->ng, s->radius, s->center);        /* back onto the sphere */
    x->error = PTI_ULPS_8 * (pti_largest_abs(s->center) + s->radius);
}
/* Rounding inside the instance, seen along the normal from outside, and that of the way there and back. */
static float pti_instance_error(const pti_instance *in, const pt_vertex *local, pt_vec3 p) {
    float shrink = pti_length(pti_xform_normal(&in->to_local, local->ng));     /* of distances from the surface, inwards */
    float inside = local->error + PTI_ULPS_8 * pti_xform_magnitude(&in->to_local, p);
    return inside / shrink + PTI_ULPS_8 * pti_xform_magnitude(&in->to_world, local->p);
}
/* Shading normals: on ng's side, and never seen from behind, else a surface that faces the eye would be black. */
static void pti_vertex_orient(pt_vertex *x) {
    float side = pti_dot(x->ng, x->wo) < 0 ? -1.0f : 1.0f, facing;
    if (pti_dot(x->ns, x->ng) < 0) x->ns = pti_neg(x->ns);
    facing = side * pti_dot(x->ns, x->wo);
    if (facing < 1e-3f) x->ns = pti_normalize(pti_madd(x->wo, side * (1e-3f - facing), x->ns));
}
static void pti_vertex_fill(const pti_geometry *g, const pti_ray *ray, pti_hit *hit, pt_vertex *x) {
    const pti_instance *in = hit->instance ? &g->shapes[hit->instance - 1].as.instance : NULL;
    pti_instance moved;
    const pti_shape *s;
    pt_vec3 org = pt_v3(ray->org[0], ray->org[1], ray->org[2]), dir = pt_v3(ray->dir[0], ray->dir[1], ray->dir[2]), p;
    if (in) { in = pti_instance_at(in, ray->time, &moved); g = in->of; }
    if (!hit->shape) hit->shape = pti_find_shape(g, hit->prim) + 1;
    s = g->shapes + (hit->shape - 1);
    x->t = hit->t;
    x->time = ray->time;
    x->wavelength = 0;
    x->volume.id = 0;
    x->tangent = x->dpdu = x->dpdv = pt_v3(0, 0, 0);
    x->wo = pti_neg(fabsf(pti_dot(dir, dir) - 1) < 1e-6f ? dir : pti_normalize(dir));
    x->u = hit->u;
    x->v = hit->v;
    x->prim = hit->prim - s->first;
    x->shape.id = hit->shape;
    x->instance.id = hit->instance;
    x->material.id = pti_shape_material(s, x->prim);
    if (in) {
        org = pti_xform_point(&in->to_local, org);
        dir = pti_xform_vector(&in->to_local, dir);
    }
    p = pti_madd(dir, hit->t, org);
    if (s->kind == PTI_MESH) pti_vertex_on_triangle(&s->as.mesh, x->prim, hit, x);
    else if (s->kind == PTI_SPHERE) pti_vertex_on_sphere(&s->as.sphere, p, x);
    else {
        x->p = p;
        x->ng = x->ns = pti_normalize(hit->ng);
        x->error = 4 * PTI_ULPS_8 * (pti_largest_abs(org) + hit->t * pti_largest_abs(dir));      /* as users compute */
    }
    if (in) {
        p = pti_xform_point(&in->to_world, x->p);
        x->error = pti_instance_error(in, x, p);
        x->p = p;
        x->ng = pti_normalize(pti_xform_normal(&in->to_local, x->ng));
        x->ns = pti_normalize(pti_xform_normal(&in->to_local, x->ns));
    }
    pti_vertex_orient(x);
}

/* Texture coordinates and the tangent, for those who ask: u and v come in as on the hit. */
static void pti_coordinates_on_triangle(const pti_mesh *m, pt_vertex *x) {
    pt_vec3 p[3], e1, e2;
    float w = 1 - x->u - x->v, u = x->u, v = x->v, du1, du2, dv1, dv2, det;
    const float *a, *b, *c;
    pti_mesh_triangle(m, x->prim, p);
    x->tangent = x->dpdu = e1 = pti_sub(p[1], p[0]);
    x->dpdv = e2 = pti_sub(p[2], p[0]);
    if (!m->uvs) return;
    a = m->uvs + 2 * (size_t)pti_mesh_index(m, x->prim, 0);
    b = m->uvs + 2 * (size_t)pti_mesh_index(m, x->prim, 1);
    c = m->uvs + 2 * (size_t)pti_mesh_index(m, x->prim, 2);
    x->u = a[0] * w + b[0] * u + c[0] * v;
    x->v = a[1] * w + b[1] * u + c[1] * v;
    du1 = b[0] - a[0]; dv1 = b[1] - a[1]; du2 = c[0] - a[0]; dv2 = c[1] - a[1];
    det = du1 * dv2 - dv1 * du2;                         /* dp/du = (e1 dv2 - e2 dv1) / det; its length does not matter */
    if (det == 0) { x->dpdu = x->dpdv = pt_v3(0, 0, 0); return; }
    x->dpdu = pti_scale(pti_sub(pti_scale(e1, dv2), pti_scale(e2, dv1)), 1 / det);
    x->dpdv = pti_scale(pti_sub(pti_scale(e2, du1), pti_scale(e1, du2)), 1 / det);
    x->tangent = pti_scale(pti_sub(pti_scale(e1, dv2), pti_scale(e2, dv1)), det > 0 ? 1.0f : -1.0f);
}
static void pti_vertex_coordinates(const pti_geometry *g, pt_vertex *x) {
    const pti_instance *in = x->instance.id ? &g->shapes[x->instance.id - 1].as.instance : NULL;
    const pti_shape *s = (in ? in->of : g)->shapes + (x->shape.id - 1);
    pti_instance moved;
    pt_vec3 n = x->ng, b;
    float r;
    if (in) in = pti_instance_at(in, x->time, &moved);
    if (s->kind == PTI_MESH) pti_coordinates_on_triangle(&s->as.mesh, x);
    else if (s->kind == PTI_SPHERE) {
        if (in) n = pti_normalize(pti_sub(pti_xform_point(&in->to_local, x->p), s->as.sphere.center));
        x->u = 0.5f + pti_atan2(n.x, -n.z) / (2 * PTI_PI);
        x->v = 1 - pti_acos(n.y) / PTI_PI;
        r = sqrtf(n.x * n.x + n.z * n.z);
        x->tangent = pt_v3(-n.z, 0, n.x);
        x->dpdu = pti_scale(x->tangent, 2 * PTI_PI * s->as.sphere.radius);
        if (r > 0) x->dpdv = pti_scale(pt_v3(-n.y * n.x / r, r, -n.y * n.z / r), PTI_PI * s->as.sphere.radius);
    }
    if (in) {
        x->tangent = pti_xform_vector(&in->to_world, x->tangent);
        x->dpdu = pti_xform_vector(&in->to_world, x->dpdu);
        x->dpdv = pti_xform_vector(&in->to_world, x->dpdv);
    }
    x->tangent = pti_normalize(pti_madd(x->ns, -pti_dot(x->ns, x->tangent), x->tangent));
    if (pti_is_zero3(x->tangent)) pti_basis(x->ns, &x->tangent, &b);
}
/* Where a ray towards wi starts: above the surface, on wi's side. */
PTI_INLINE pt_vec3 pti_spawn(const pt_vertex *x, pt_vec3 wi) {
    return pti_madd(x->ng, pti_dot(x->ng, wi) < 0 ? -x->error : x->error, x->p);
}

/* ---- >>texture -----------------------------------------------------------------------------------------
   Colours and numbers that vary over a surface: pixels, patterns that are computed, or the user's function. Pixels are
   filtered bilinearly: with f the distance from the left and upper of the four texels whose middles lie around a point,
   c = (c00 (1 - fx) + c10 fx) (1 - fy) + (c01 (1 - fx) + c11 fx) fy. (A path tracer takes many samples a pixel, which
   does what smaller copies of a picture do elsewhere.) */

typedef struct pti_texture {
    const void *pixels;                                  /* NULL: a pattern or a callback */
    int owned, width, height, channels, bits;
    int first, grey, picked;                             /* channel to begin with; only that one; by the desc */
    const float *decode, *decode_alpha;                  /* what 8 or 16 bits mean; NULL (not for 8) = over the largest */
    pt_wrap wrap_u, wrap_v;
    int nearest;
    float m[6];                                          /* s = m0 u + m1 (1 - v) + m2, t = m3 u + m4 (1 - v) + m5 */
    pt_pattern pattern;
    int solid, octaves;
    float frequency;
    pt_vec3 color_a, color_b;
    pt_vec3 (*eval)(void *user, const pt_vertex *x);
    void *user;
} pti_texture;

static size_t pti_texture_size(const pti_texture *t) { return (size_t)t->bits / 8; }
static size_t pti_texture_count(const pti_texture *t) {
    return (size_t)t->width * (size_t)t->height * (size_t)t->channels;
}
static float pti_srgb_decode(float s) { return s <= 0.04045f ? s / 12.92f : pti_pow((s + 0.055f) / 1.055f, 2.4f); }

/* (s, t) from (u, v): once for all, R S and the offset as a matrix. */
static void pti_texture_place(pti_texture *t, const float scale[2], float rotate_deg, const float offset[2]) {
    float su = scale[0] < 0 || scale[0] > 0 ? scale[0] : 1.0f, sv = scale[1] < 0 || scale[1] > 0 ? scale[1] : 1.0f, s, c;
    pti_sincos(rotate_deg * (PTI_PI / 180), &s, &c);
    t->m[0] = c * su;  t->m[1] = s * sv; t->m[2] = offset[0];
    t->m[3] = -s * su; t->m[4] = c * sv; t->m[5] = offset[1];
}
static void pti_texture_st(const pti_texture *t, float u, float v, float *s, float *w) {
    v = 1 - v;
    *s = t->m[0] * u + t->m[1] * v + t->m[2];
    *w = t->m[3] * u + t->m[4] * v + t->m[5];
}

/* ---- pixels */

PTI_INLINE float pti_texel_channel(const pti_texture *t, size_t i, const float *decode) {
    if (t->bits == 32) return ((const float *)t->pixels)[i];
    if (t->bits == 8) return decode[((const unsigned char *)t->pixels)[i]];
    return decode ? decode[((const uint16_t *)t->pixels)[i]] : (float)((const uint16_t *)t->pixels)[i] / 65535;
}
PTI_INLINE pt_vec3 pti_texel_at(const pti_texture *t, size_t i) {  /* i: where the pixel's channels begin */
    const unsigned char *b = (const unsigned char *)t->pixels;
    const float *f = (const float *)t->pixels;
    i += (size_t)t->first;
    if (t->grey) { float c = pti_texel_channel(t, i, t->decode); return pt_v3(c, c, c); }
    if (t->bits == 8) return pt_v3(t->decode[b[i]], t->decode[b[i + 1]], t->decode[b[i + 2]]);
    if (t->bits == 32) return pt_v3(f[i], f[i + 1], f[i + 2]);
    return pt_v3(pti_texel_channel(t, i, t->decode), pti_texel_channel(t, i + 1, t->decode),
                 pti_texel_channel(t, i + 2, t->decode));
}
static size_t pti_texel_index(const pti_texture *t, int x, int y) {
    return ((size_t)y * (size_t)t->width + (size_t)x) * (size_t)t->channels;
}
static pt_vec3 pti_texel(const pti_texture *t, int x, int y) { return pti_texel_at(t, pti_texel_index(t, x, y)); }

/* A coordinate folded into [0,1]. What is no number (infinity times 0 somewhere) becomes 0. */
PTI_INLINE float pti_wrap(float x, pt_wrap wrap) {
    if (wrap == PT_WRAP_CLAMP) return x > 0 ? pti_min(x, 1) : 0.0f;
    if (wrap == PT_WRAP_REPEAT) x -= floorf(x);
    else {                                               /* there and back: period 2 */
        x -= 2 * floorf(x * 0.5f);
        x = x > 1 ? 2 - x : x;
    }
    return x >= 0 ? x : 0.0f;
}
/* The two of n texels next to a coordinate in [0,1], and how far it is from the middle of the one to the other's. A
   mirrored border is its own neighbour, like a clamped one. */
PTI_INLINE float pti_texel_pair(float x, int n, pt_wrap wrap, int *first, int *second) {
    int i;
    x = x * (float)n - 0.5f;
    i = pti_below(x);
    *first = i >= 0 ? i : wrap == PT_WRAP_REPEAT ? n - 1 : 0;
    *second = i + 1 < n ? i + 1 : wrap == PT_WRAP_REPEAT ? 0 : n - 1;
    return x - (float)i;
}
static int pti_texel_nearest(float x, int n) {
    int i = (int)(x * (float)n);
    return i < n ? i : n - 1;
}
/* The four texels round a point, c00 c10 c01 c11, and the way from the first. */
typedef struct pti_texels { size_t at[4]; float fx, fy; } pti_texels;
PTI_INLINE pti_texels pti_texels_at(const pti_texture *t, float s, float w, pt_wrap wrap_u, pt_wrap wrap_v, int nearest) {
    pti_texels q;
    int x0, x1, y0, y1;
    s = pti_wrap(s, wrap_u);
    w = pti_wrap(w, wrap_v);
    if (nearest) {
        x0 = x1 = pti_texel_nearest(s, t->width);
        y0 = y1 = pti_texel_nearest(w, t->height);
        q.fx = q.fy = 0;
    } else {
        q.fx = pti_texel_pair(s, t->width, wrap_u, &x0, &x1);
        q.fy = pti_texel_pair(w, t->height, wrap_v, &y0, &y1);
    }
    q.at[0] = pti_texel_index(t, x0, y0); q.at[1] = pti_texel_index(t, x1, y0);
    q.at[2] = pti_texel_index(t, x0, y1); q.at[3] = pti_texel_index(t, x1, y1);
    return q;
}
PTI_INLINE pt_vec3 pti_texels_color(const pti_texture *t, const pti_texels *q) {
    pt_vec3 c00 = pti_texel_at(t, q->at[0]), c10 = pti_texel_at(t, q->at[1]);
    pt_vec3 c01 = pti_texel_at(t, q->at[2]), c11 = pti_texel_at(t, q->at[3]);
    return pti_add(pti_scale(pti_madd(c00, 1 - q->fx, pti_scale(c10, q->fx)), 1 - q->fy),
                   pti_scale(pti_madd(c01, 1 - q->fx, pti_scale(c11, q->fx)), q->fy));
}
static float pti_texels_channel(const pti_texture *t, const pti_texels *q, int channel, const float *decode) {
    float c[4];
    int k;
    for (k = 0; k < 4; k++) c[k] = pti_texel_channel(t, q->at[k] + (size_t)channel, decode);
    return (c[0] * (1 - q->fx) + c[1] * q->fx) * (1 - q->fy) + (c[2] * (1 - q->fx) + c[3] * q->fx) * q->fy;
}
/* As a map of the sky, whatever its desc says of borders and places: u to the right, v down from the top; u wraps round,
   and v too, or it stops at the poles. */
static pt_vec3 pti_texture_bilinear(const pti_texture *t, float u, float v, int clamp_v) {
    pti_texels q = pti_texels_at(t, u, v, PT_WRAP_REPEAT, clamp_v ? PT_WRAP_CLAMP : PT_WRAP_REPEAT, 0);
    return pti_texels_color(t, &q);
}

/* ---- patterns: functions of the place, hashed from integers, with values in [0,1] */

/* A lattice cell and the place in it. Cells are counted modulo 2^32, whose seam nobody sees: where a float is that large,
   neighbouring floats are many cells apart. */
static uint32_t pti_lattice(double x, float *f) {
    double whole = floor(x);
    if (!(x > -1e18 && x < 1e18)) { *f = 0; return 0; }
    *f = (float)(x - whole);
    return (uint32_t)(int64_t)whole;
}
/* The borders lie a little before the whole numbers, so that a wall at a whole coordinate is of one colour. */
static float pti_checker(const double p[3]) {
    float f;
    const double shift = 1.0 / 1024;
    uint32_t sum = pti_lattice(p[0] + shift, &f) + pti_lattice(p[1] + shift, &f) + pti_lattice(p[2] + shift, &f);
    return (float)(sum & 1);
}
/* Gradient noise (Perlin 2002, with a hash for its table): each lattice point has one of twelve slopes, and they are
   blended by 6 f^5 - 15 f^4 + 10 f^3, whose first two derivatives vanish at both ends. 0 on the lattice, and hardly ever
   beyond -1 and 1. */
static float pti_slope(uint32_t hash, float x, float y, float z) {     /* of sixteen, four come twice: no division by 12 */
    static const float slopes[16][3] = { {1,1,0}, {-1,1,0}, {1,-1,0}, {-1,-1,0}, {1,0,1}, {-1,0,1}, {1,0,-1}, {-1,0,-1},
        {0,1,1}, {0,-1,1}, {0,1,-1}, {0,-1,-1}, {1,1,0}, {-1,1,0}, {0,-1,1}, {0,-1,-1} };
    const float *g = slopes[hash >> 28];
    return g[0] * x + g[1] * y + g[2] * z;
}
static float pti_fade(float f) { return f * f * f * (f * (f * 6 - 15) + 10); }
static float pti_noise(const double p[3], uint32_t seed) {
    float f[3], wx, wy, wz, sum = 0;
    uint32_t x = pti_lattice(p[0], f), y = pti_lattice(p[1], f + 1), z = pti_lattice(p[2], f + 2), i, j, k;
    wx = pti_fade(f[0]); wy = pti_fade(f[1]); wz = pti_fade(f[2]);
    for (k = 0; k < (f[2] > 0 ? 2u : 1u); k++) {         /* in the plane, the upper four count nothing */
        uint32_t hz = pti_hash(seed ^ (z + k));
        for (j = 0; j < 2; j++) {
            uint32_t hy = pti_hash(hz ^ (y + j));
            float w = (k ? wz : 1 - wz) * (j ? wy : 1 - wy);
            for (i = 0; i < 2; i++)
                sum += w * (i ? wx : 1 - wx)
                     * pti_slope(pti_hash(hy ^ (x + i)), f[0] - (float)i, f[1] - (float)j, f[2] - (float)k);
        }
    }
    return sum;
}
/* Fractional Brownian motion: sum 2^-i noise_i(2^i p), each octave with slopes of its own, and moved by a step off the
   others' lattice, where it would be 0 together with them; flat: within the plane. */
static float pti_fbm(const double p[3], int octaves, int flat) {
    float sum = 0, gain = 1;
    double q[3], lacunarity = 1, step = flat ? 0 : 0.19;
    int i;
    for (i = 0; i < octaves; i++, gain *= 0.5f, lacunarity *= 2) {
        q[0] = p[0] * lacunarity + 0.37 * i; q[1] = p[1] * lacunarity + 0.73 * i; q[2] = p[2] * lacunarity + step * i;
        sum += gain * pti_noise(q, pti_hash((uint32_t)i));
    }
    return sum;
}
static float pti_pattern_value(const pti_texture *t, const double p[3]) {
    if (t->pattern == PT_PATTERN_CHECKER) return pti_checker(p);
    return pti_clamp(0.5f + 0.5f * pti_fbm(p, t->pattern == PT_PATTERN_NOISE ? 1 : t->octaves, !t->solid), 0, 1);
}
static pt_vec3 pti_texture_pattern(const pti_texture *t, const pt_vertex *x) {
    double p[3];
    float s, w, k;
    if (t->solid) {
        double f = (double)t->frequency;
        p[0] = (double)x->p.x * f; p[1] = (double)x->p.y * f; p[2] = (double)x->p.z * f;
    } else {
        pti_texture_st(t, x->u, x->v, &s, &w);
        p[0] = (double)s; p[1] = (double)w; p[2] = 0;
    }
    k = pti_pattern_value(t, p);
    return pti_madd(t->color_a, 1 - k, pti_scale(t->color_b, k));
}

/* ---- what a texture shows: its colour, its grey, its alpha */

static pti_texels pti_texture_texels(const pti_texture *t, float u, float v) {
    float s, w;
    pti_texture_st(t, u, v, &s, &w);
    return pti_texels_at(t, s, w, t->wrap_u, t->wrap_v, t->nearest);
}
static pt_vec3 pti_texture_eval(const pti_texture *t, const pt_vertex *x) {
    pt_vec3 c;
    if (t->pixels) {
        pti_texels q = pti_texture_texels(t, x->u, x->v);
        return pti_texels_color(t, &q);
    }
    c = t->eval ? t->eval(t->user, x) : pti_texture_pattern(t, x);
    if (t->grey) c.x = c.y = c.z = pti_axis(c, t->first);
    return c;
}
static float pti_texture_grey(const pti_texture *t, const pt_vertex *x) {      /* the first channel, or the desc's */
    pti_texels q;
    if (!t->pixels) return pti_texture_eval(t, x).x;
    q = pti_texture_texels(t, x->u, x->v);
    return pti_texels_channel(t, &q, t->first, t->decode);
}
static float pti_texture_alpha(const pti_texture *t, const pt_vertex *x) {     /* 1 if there is none */
    pti_texels q;
    if (!t->pixels || t->channels % 2) return 1;
    q = pti_texture_texels(t, x->u, x->v);
    return pti_texels_channel(t, &q, t->channels - 1, t->decode_alpha);
}

/* For heights and means: elsewhere on the texture. Callbacks and solid patterns meet a vertex that has u and v alone. */
static pt_vec3 pti_texture_eval_at(const pti_texture *t, float u, float v) {
    pt_vertex x;
    memset(&x, 0, sizeof x);
    x.u = u; x.v = v;
    return pti_texture_eval(t, &x);
}
/* The steps in u and in v that cross a texel, and a sixteenth of a pattern's smallest cell. Solid patterns: in metres. */
static void pti_texture_texel(const pti_texture *t, float *du, float *dv) {
    float w = 1024, h = 1024;
    if (t->pixels) { w = (float)t->width; h = (float)t->height; }
    else if (t->pattern) w = h = 16.0f * (t->pattern == PT_PATTERN_FBM ? (float)(1 << (t->octaves - 1)) : 1.0f);
    if (t->solid) { *du = *dv = 1 / (w * t->frequency); return; }
    *du = 1 / sqrtf(pti_max(t->m[0] * t->m[0] * w * w + t->m[3] * t->m[3] * h * h, 1e-30f));
    *dv = 1 / sqrtf(pti_max(t->m[1] * t->m[1] * w * w + t->m[4] * t->m[4] * h * h, 1e-30f));
}
/* A triangle cut into n^2 equal ones: row i, counted from a corner, has i + 1 that stand and i that hang between them. A
   point of the k-th, in edges of the whole: its middle, or any, by a hash. */
static void pti_point_in_part(int i, int k, int n, int any, float *x, float *y) {
    uint32_t h = 2 * (uint32_t)(i * i + k);
    int hangs = k % 2;
    *x = any ? pti_u01(pti_hash(h + 1)) : 1 / 3.0f;
    *y = any ? pti_u01(pti_hash(h + 2)) : 1 / 3.0f;
    if (*x + *y > 1) { *x = 1 - *x; *y = 1 - *y; }
    if (hangs) { *x = 1 - *x; *y = 1 - *y; }
    *x = ((float)(k / 2) + *x) / (float)n;
    *y = ((float)(i - k / 2 - hangs) + *y) / (float)n;
}
/* The mean colour over a triangle of (u, v), from n^2 points, one or two a texel but not above 64^2 (of a callback 16^2).
   Where a picture is too fine for that, they lie at random, lest a regular picture fool a regular grid. */
static pt_vec3 pti_texture_mean_on_triangle(const pti_texture *t, const float a[2], const float b[2], const float c[2]) {
    float e[4], du, dv, x, y, longest;
    pt_vec3 sum = pt_v3(0, 0, 0);
    int i, k, n, rough, most = t->eval ? 16 : 64;
    if (t->solid) return pti_scale(pti_add(t->color_a, t->color_b), 0.5f);
    e[0] = b[0] - a[0]; e[1] = b[1] - a[1]; e[2] = c[0] - a[0]; e[3] = c[1] - a[1];
    pti_texture_texel(t, &du, &dv);
    longest = pti_max(pti_max(fabsf(e[0]), pti_max(fabsf(e[2]), fabsf(e[2] - e[0]))) / du,
                      pti_max(fabsf(e[1]), pti_max(fabsf(e[3]), fabsf(e[3] - e[1]))) / dv);
    rough = !(longest < (float)(most - 3));
    n = rough ? most : 3 + (int)longest;
    for (i = 0; i < n; i++) {
        pt_vec3 row = pt_v3(0, 0, 0);
        for (k = 0; k < 2 * i + 1; k++) {
            pti_point_in_part(i, k, n, rough, &x, &y);
            row = pti_add(row, pti_texture_eval_at(t, a[0] + x * e[0] + y * e[2], a[1] + x * e[1] + y * e[3]));
        }
        sum = pti_add(sum, row);
    }
    return pti_scale(sum, 1 / ((float)n * (float)n));
}

/* ---- >>medium ------------------------------------------------------------------------------------------
   A medium is a probabilistic surface: a ray hits a particle in it, or passes. In one of extinction sigma_t = sigma_a + sigma_s
   a ray comes as far as t with the probability, and hits there with the density,
       T(t) = exp(-tau(t)),   p(t) = sigma_t(t) T(t),   tau(t) = integral of sigma_t from 0 to t,
   so t is where tau(t) = -ln(1 - R). Free flights in all volumes are independent; the nearest hit, over volumes and surfaces
   alike, is where the path scatters, since prod T_k is the transmittance of all of them together: volumes overlap without a
   stack or an order. Where densities vary, virtual particles fill up what a cell of a coarse grid lacks of the largest
   extinction in it, mu; a hit is a real one with probability sigma_t / mu, else the flight goes on (Woodcock et al. 1965; a
   cell at a time: Szirmay-Kalos, Toth and Magdics 2011).

   Where channels differ, one of them, the hero, decides; each could have been it, with the probability q_c, so the weight of
   channel i is the balance heuristic over all (Wilkie et al. 2014; Miller, Georgiev and Jarosz 2019),
       at a hit in volume k:  sigma_s,k,i F_i / sum_c q_c sigma_t,k,c P_c,       where all pass:  F_i / sum_c q_c P_c.
   F_i is the channel's transmittance, and P_c the probability that c as the hero would have come that far, both products over all
   volumes. Where there were virtual hits on the way, both are the product of their 1 - sigma_t / mu, of the channel. These hits
   are found by flying again, in pti_volume_weigh, with the same random numbers and so to the same places. (A march's steps
   are such hits, too, with 1 / step for mu.) q goes as the throughput so far, so the channels' sum never grows. The same holds
   where each channel has a grid of its own: then mu bounds all three. A medium that only absorbs is never hit: its P is 1, and
   light fades. What glows, epsilon a metre, is gathered along the way to where the path got: epsilon F / sum_c q_c P_c at a few
   places, over their density.

   Distances have a mixture, too. Near a small lamp light goes as 1 / r^2, which free flights do not know: bright specks. So in
   constant media that fill a box, a ball or everything, some flights are drawn, with the share w, by
       e(t) = sum_k Phi_k / (D_k^2 + (t - t_k)^2) / integral of that,
   lamp k being nearest to the ray at t_k, D_k away (equiangular sampling, Kulla and Fajardo 2012), and Phi_k its power, dimmed
   by the way to the volume's place nearest to t_k. What stands under q_c for that volume is then, at a hit (in place of
   sigma_t,k,c P_c), and where it passes,
       (1 - w) sigma_t,c T_c + w e(t),       (1 - w) T_c + w (1 - E(t)),       E(t) = integral of e up to t.
   And where passing is worth nothing, since behind the one volume all is black, or its light was added already, a flight need not
   pass: then the other share, 1 - w, is drawn from those that hit, sigma_t T / (1 - T(end)) in place of sigma_t T, or evenly, 1
   over the length, where the stretch is thin, and T(end) near 1. Paths by the BSDF alone do neither: they are to compare with. */

/* Phase functions: densities over directions, per steradian, that are their own sampling. Draine's (2003),
       D(u) = 1 / (4 pi)  (1 - g^2) / (1 + g^2 - 2 g u)^(3/2)  (1 + alpha u^2) / (1 + alpha (1 + 2 g^2) / 3),
   u the cosine between the ways in and out, is Henyey and Greenstein's for alpha 0 and Rayleigh's for g 0, alpha 1. The
   built-in ones are all (1 - mix) D(g, 0) + mix D(g2, alpha). Forward and backward are alike but for the sign of u, so all is
   written with h = |g| and v = 1 - u (1 + u where g < 0), which keeps its digits where D has its peak. */
typedef struct pti_phase {
    float g, g2, mix, alpha;
    float (*pdf)(void *user, const pt_vertex *x, pt_vec3 wi);       /* NULL: none of the user's */
    int   (*sample)(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi);
    void  *user;
} pti_phase;

static float pti_draine(float h, float alpha, float v) {
    float d = (1 - h) * (1 - h) + 2 * h * v, u = 1 - v;
    return (1 - h * h) * (1 + alpha * u * u) / (4 * PTI_PI * d * sqrtf(d) * (1 + alpha * (1 + 2 * h * h) / 3));
}
/* The integral of (1 + alpha u^2) / s^3 over v, s^2 = (1 - h)^2 + 2 h v, and the integrand. With s as the variable, u =
   (1 + h^2 - s^2) / (2 h), it is a polynomial over s. */
static double pti_draine_integral(double h, double alpha, double v, double *slope) {
    double s = sqrt((1 - h) * (1 - h) + 2 * h * v), least = 1 - h, a = 1 + h * h, b, u = 1 - v;
    *slope = (1 + alpha * u * u) / (s * s * s);
    if (h <= 0) return v + alpha * (1 - u * u * u) / 3;
    b = alpha / (4 * h * h);
    return ((1 + b * a * a) * (1 / least - 1 / s) - b * (2 * a * (s - least) - (s * s * s - least * least * least) / 3)) / h;
}
/* v from a number in [0,1): HG's inverse, and if that is not all, Newton's steps from there, halving where they would leave. */
static float pti_sample_draine(float h, float alpha, float r) {
    double q = 1 - (double)h, x = 1 - (double)r, s = (1 - (double)h * (double)h) / (q + 2 * (double)h * x);
    double v = q * (double)r * (s + q) / (q + 2 * (double)h * x), lo = 0, hi = 2, slope, want, miss;
    int i;
    if (!(alpha > 0)) return (float)v;
    want = (double)r * pti_draine_integral((double)h, (double)alpha, 2, &slope);
    for (i = 0; i < 40; i++) {
        miss = pti_draine_integral((double)h, (double)alpha, v, &slope) - want;
        if (miss < 1e-12 * want && -miss < 1e-12 * want) break;
        if (miss > 0) hi = v; else lo = v;
        v -= miss / slope;
        if (!(v > lo && v < hi)) v = (lo + hi) / 2;
    }
    return (float)v;
}
static float pti_draine_towards(float g, float alpha, pt_vec3 wo, pt_vec3 wi) {
    pt_vec3 d = g < 0 ? pti_sub(wo, wi) : pti_add(wo, wi);         /* |d|^2 = 2 v */
    return pti_draine(fabsf(g), alpha, pti_min(0.5f * pti_dot(d, d), 2));
}
static float pti_phase_pdf(const pti_phase *p, const pt_vertex *x, pt_vec3 wi) {
    float f = 0;
    if (p->pdf) return pti_density_of(p->pdf(p->user, x, wi));
    if (p->mix < 1) f = (1 - p->mix) * pti_draine_towards(p->g, 0, x->wo, wi);
    return p->mix > 0 ? f + p->mix * pti_draine_towards(p->g2, p->alpha, x->wo, wi) : f;
}
static int pti_phase_sample(const pti_phase *p, const pt_vertex *x, uint32_t a, uint32_t b, pt_vec3 *wi) {
    int second = p->mix > 0 && pti_split(&a, p->mix);
    float g = second ? p->g2 : p->g, v, r, uv[2];
    pt_vec3 axis = g < 0 ? x->wo : pti_neg(x->wo), t, bt, local;
    uv[0] = pti_u01(a); uv[1] = pti_u01(b);
    if (p->pdf) return p->sample(p->user, x, uv, wi);
    v = pti_sample_draine(fabsf(g), second ? p->alpha : 0.0f, uv[0]);
    r = pti_safe_sqrt(v * (2 - v));
    pti_sincos(2 * PTI_PI * uv[1], &local.y, &local.x);
    pti_basis(axis, &t, &bt);
    *wi = pti_normalize(pti_to_world(t, bt, axis, pt_v3(local.x * r, local.y * r, 1 - v)));
    return 1;
}
static void pti_phase_init(pti_phase *p, const pt_medium_desc *d) {
    float um = d->droplet_um > 0 ? d->droplet_um : 20.0f;
    memset(p, 0, sizeof *p);
    p->g = d->g;
    switch (d->phase) {
    case PT_PHASE_RAYLEIGH:  p->mix = 1; p->alpha = 1; break;
    case PT_PHASE_TWO_LOBES: p->mix = d->mix; p->g2 = d->g2; break;
    case PT_PHASE_DRAINE:    p->mix = 1; p->g2 = d->g; p->alpha = d->alpha; break;
    case PT_PHASE_DROPLETS:                              /* Jendersie and d'Eon 2023, equations 4 to 7 */
        p->g = pti_exp(-0.0990567f / (um - 1.67154f));
        p->g2 = pti_exp(-2.20679f / (um + 3.91029f) - 0.428934f);
        p->alpha = pti_exp(3.62489f - 8.29288f / (um + 5.52825f));
        p->mix = pti_exp(-0.599085f / (um - 0.641583f) - 0.665888f);
        break;
    case PT_PHASE_USER: p->pdf = d->phase_pdf; p->sample = d->phase_sample; p->user = d->user; break;
    default: break;
    }
    if (fabsf(p->g2) < 1e-3f) p->g2 = 0;                 /* below, the integral above has too few digits left */
}

/* ---- what a volume is filled with: numbers, times a density */

#define PTI_MEDIUM_BLOCK 8                               /* voxels along the side of a cell of the majorants' grid */
typedef struct pti_medium {
    pt_vec3 sigma_t, sigma_s, albedo, emission;          /* at density 1 */
    float largest;                                       /* channel of sigma_t */
    int chromatic, scatters, emits;
    int varies;                                          /* has a grid or a callback */
    pti_phase phase;
    const float *grid;  int n[3], channels, owned, nearest;
    float (*density)(void *user, pt_vec3 p);
    float density_max;
    pt_vec3 (*glow)(void *user, pt_vec3 p);
    void *user;
    float (*density_bound)(void *user, pt_vec3 lo, pt_vec3 hi);
    float *majorants;  int cells[3];                     /* of the grid */
    pt_tracking tracking;
    float step;
} pti_medium;

static int pti_medium_tracked(const pti_medium *m) { return m->varies || m->tracking != PT_TRACK_EXACT; }
/* Must its passing be weighed, or does it go as often as it should? */
static int pti_medium_weighs(const pti_medium *m) { return m->chromatic || !m->scatters; }
static float pti_channel(pt_vec3 v, int c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

static size_t pti_count3(const int n[3]) { return (size_t)n[0] * (size_t)n[1] * (size_t)n[2]; }
static float pti_voxel(const pti_medium *m, const float *grid, int x, int y, int z) {
    return grid[((size_t)z * (size_t)m->n[1] + (size_t)y) * (size_t)m->n[0] + (size_t)x];
}
static int pti_voxel_index(float x, int n) { return x > 0 ? (x < (float)n ? (int)x : n - 1) : 0; }
static float pti_lerp(float a, float b, float t) { return a + (b - a) * t; }
/* Of one channel's grid; p in the unit cube of the bounds. */
static float pti_grid_density(const pti_medium *m, int channel, pt_vec3 p) {
    const float *g = channel ? m->grid + (size_t)channel * pti_count3(m->n) : m->grid;
    float x = p.x * (float)m->n[0], y = p.y * (float)m->n[1], z = p.z * (float)m->n[2];
    int i, j, k, i1, j1, k1;
    if (m->nearest) return pti_voxel(m, g, pti_voxel_index(x, m->n[0]), pti_voxel_index(y, m->n[1]), pti_voxel_index(z, m->n[2]));
    x = pti_clamp(x - 0.5f, 0, (float)(m->n[0] - 1));
    y = pti_clamp(y - 0.5f, 0, (float)(m->n[1] - 1));
    z = pti_clamp(z - 0.5f, 0, (float)(m->n[2] - 1));
    i = (int)x; j = (int)y; k = (int)z;
    i1 = i + 1 < m->n[0] ? i + 1 : i; j1 = j + 1 < m->n[1] ? j + 1 : j; k1 = k + 1 < m->n[2] ? k + 1 : k;
    x -= (float)i; y -= (float)j; z -= (float)k;
    return pti_lerp(pti_lerp(pti_lerp(pti_voxel(m, g, i, j, k), pti_voxel(m, g, i1, j, k), x),
                             pti_lerp(pti_voxel(m, g, i, j1, k), pti_voxel(m, g, i1, j1, k), x), y),
                    pti_lerp(pti_lerp(pti_voxel(m, g, i, j, k1), pti_voxel(m, g, i1, j, k1), x),
                             pti_lerp(pti_voxel(m, g, i, j1, k1), pti_voxel(m, g, i1, j1, k1), x), y), z);
}
static pt_vec3 pti_grid_densities(const pti_medium *m, pt_vec3 p) {
    float d = pti_grid_density(m, 0, p);
    return m->channels == 1 ? pt_v3(d, d, d) : pt_v3(d, pti_grid_density(m, 1, p), pti_grid_density(m, 2, p));
}
/* The largest density in a cell, of all channels: of the voxels in it, and of those next to it that are blended in. */
static float pti_grid_majorant(const pti_medium *m, int cx, int cy, int cz) {
    int lo[3], hi[3], cell[3], x, y, z, k;
    const float *g = m->grid;
    float most = 0;
    cell[0] = cx; cell[1] = cy; cell[2] = cz;
    for (k = 0; k < 3; k++) {
        float width = (float)m->n[k] / (float)m->cells[k];
        lo[k] = pti_voxel_index((float)cell[k] * width - 1, m->n[k]);
        hi[k] = pti_voxel_index((float)(cell[k] + 1) * width + 1, m->n[k]);
    }
    for (k = 0; k < m->channels; k++, g += pti_count3(m->n))
        for (z = lo[2]; z <= hi[2]; z++) for (y = lo[1]; y <= hi[1]; y++) for (x = lo[0]; x <= hi[0]; x++)
            most = pti_max(most, pti_voxel(m, g, x, y, z));
    return most;
}

/* ---- where volumes are */

typedef enum pti_volume_kind { PTI_EVERYWHERE, PTI_IN_BOX, PTI_IN_BALL, PTI_IN_CLOSED } pti_volume_kind;
typedef struct pti_volume {
    const pti_medium *medium;
    const struct pti_material *scatterer;                /* how a path sees a particle */
    pti_volume_kind kind;
    const pti_instance *in;                              /* NULL, or what places the bounds */
    pti_bounds box;                                      /* of the bounds, in their space */
    pt_xform to_unit;                                    /* from there to the unit cube: the grid's */
    pti_sphere ball;
    const pti_geometry *bounds;                          /* PTI_IN_CLOSED */
    float outwards;                                      /* -1: its normals point inwards */
    const float *majorants;  int cells[3];               /* of density, over the unit cube; NULL: density_max everywhere */
    int owns_bounds, owns_majorants;
    uint32_t id, instance;                               /* for users: the filling's number in its scene; what places it */
} pti_volume;
#define PTI_HALOS 4                                      /* with five lamps and more, they cost more time than they save noise */
#define PTI_HALO_SHARE 0.4f                              /* of the mixture, at most */
typedef struct pti_halo { pt_vec3 p; float power, sigma; } pti_halo;     /* a lamp in a medium: see pti_halo_pdf */
typedef struct pti_halos { int count; pti_halo lamp[PTI_HALOS]; } pti_halos;
#define PTI_AIMS 4                                       /* lamps that a flight is aimed at */
typedef struct pti_lamp { pt_vec3 p; float radius, power; } pti_lamp;    /* its middle, half its diagonal, Phi / pi */
typedef struct pti_volumes {
    pti_volume *all;  size_t count, capacity, unbounded; /* those everywhere come first */
    pti_geometry tree;                                   /* of the others' boxes in the world */
    int weigh, chromatic, emit, aim;                     /* does any of them? */
    float least;                                         /* extinction of those that aim */
    pti_lamp lamps[PTI_AIMS];                            /* all there are, if they are so few */
    pti_halos halos;
} pti_volumes;

#define PTI_FOG_END 1e15f                                /* so far does everywhere go, that squares of distances are finite */
/* Stretches of a ray inside of a volume, one after the other, up to tmax. Bounds that are closed and do not cross themselves
   are left where a ray meets them from behind; so of where it starts nothing need be known but whether that is far away: at the
   rim of what is, rounding may swap the wall that is entered and that which is left, and the latter then ends nothing. */
typedef struct pti_span {
    const pti_volume *volume;
    pti_trace_function *trace;
    pt_vec3 org, dir;                                    /* in the space of the bounds */
    float time, tmax;
    float from, to;                                      /* the present one; before the first: 0, 0 */
    int last;                                            /* no more to come */
    int outside;                                         /* closed bounds are farther away than half their size */
} pti_span;
#define PTI_AIM_SHARE 0.35f                              /* w, at most: on four scenes 0.25 to 0.5 were hardly worse */
typedef struct pti_aim { float at, distance, power; } pti_aim;       /* a lamp: t_k, D_k, Phi_k / (4 pi) */
/* e in one volume, on the one stretch there is. */
typedef struct pti_aimed {
    float share, from, to;                               /* w; the stretch, empty if there is none */
    pt_vec3 T;                                           /* of all of it */
    double sum, angle[PTI_AIMS];                         /* the integral; the angle at which each lamp sees the stretch */
    float weight[PTI_AIMS];                              /* Phi_k, dimmed by the way to where it is nearest */
} pti_aimed;
typedef struct pti_flight {                              /* a ray of unit length through all volumes */
    const pti_volumes *volumes;
    pti_trace_function *trace;
    pt_vec3 org, dir;
    float time;
    uint32_t seed, index;                                /* of its random numbers */
    const pti_sampler *sampler;                          /* NULL: all of them are plain ones */
    uint32_t group;
    int hero;
    int aim_count;                                       /* lamps to aim at */
    pti_aim aims[PTI_AIMS];
    float end, sky;                                      /* the nearest surface; fluence from the sky */
    int weigh;                                           /* are there weights? */
    const struct pti_volume *stretch_of;                 /* the volume asked last that lies in a box, a ball or everywhere and does
                                                            not vary: the ray has but one stretch there */
    pti_aimed stretch;                                   /* which is this, up to `end` */
    int is_aimed;                                        /* is w > 0 there? */
    int blind;                                           /* there is one volume, and behind it nothing to be seen: who passes
                                                            brings nothing, so no flight shall */
    int exceeded;                                        /* a density was above its maximum, or the looks ran out */
} pti_flight;

static int pti_span_is_outside(const pti_bounds *b, pt_vec3 p) {
    pt_vec3 away = pti_max3(pti_sub(b->lo, p), pti_sub(p, b->hi));
    return pti_largest(away) > 0.5f * pti_largest(pti_sub(b->hi, b->lo));
}
static void pti_span_begin(pti_span *s, const pti_flight *f, const pti_volume *v, float tmax) {
    pti_instance moved;
    s->volume = v;
    s->trace = f->trace;
    s->org = f->org; s->dir = f->dir;
    s->time = f->time; s->tmax = tmax;
    s->from = s->to = 0;
    s->last = 0;
    if (v->in) {
        const pti_instance *in = pti_instance_at(v->in, f->time, &moved);
        s->org = pti_xform_point(&in->to_local, f->org);
        s->dir = pti_xform_vector(&in->to_local, f->dir);
    }
    s->outside = v->kind == PTI_IN_CLOSED && pti_span_is_outside(&v->bounds->bvh.bounds, s->org);
}
static void pti_span_slab(float org, float dir, float *from, float *to) {      /* 0 <= org + t dir <= 1 */
    float a, b;
    if (dir == 0) {
        if (!(org >= 0 && org <= 1)) *to = -1;
        return;
    }
    a = (dir > 0 ? -org : 1 - org) / dir;
    b = (dir > 0 ? 1 - org : -org) / dir;
    *from = pti_max(*from, a);
    *to = pti_min(*to, b);
}
static void pti_span_box(pti_span *s) {
    pt_vec3 o = pti_xform_point(&s->volume->to_unit, s->org), d = pti_xform_vector(&s->volume->to_unit, s->dir);
    s->to = s->tmax;
    pti_span_slab(o.x, d.x, &s->from, &s->to);
    pti_span_slab(o.y, d.y, &s->from, &s->to);
    pti_span_slab(o.z, d.z, &s->from, &s->to);
}
static void pti_span_ball(pti_span *s) {                 /* as pti_sphere_hit */
    pt_vec3 c = s->volume->ball.center;
    double o[3], d[3], a, b, n[3], r = (double)s->volume->ball.radius, disc, root;
    s->to = -1;
    o[0] = (double)s->org.x - (double)c.x; d[0] = (double)s->dir.x;
    o[1] = (double)s->org.y - (double)c.y; d[1] = (double)s->dir.y;
    o[2] = (double)s->org.z - (double)c.z; d[2] = (double)s->dir.z;
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    b = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / a;
    n[0] = o[0] + b * d[0]; n[1] = o[1] + b * d[1]; n[2] = o[2] + b * d[2];
    disc = r * r - (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(disc > 0)) return;
    root = sqrt(disc / a);
    s->from = pti_max((float)(b - root), 0);
    s->to = pti_min((float)(b + root), s->tmax);
}
static int pti_span_wall(pti_span *s, float after, float *t) {       /* the next one: 1 from outside, -1 from inside, 0 none */
    pti_ray ray;
    pti_hit hit;
    pt_vertex x;
    pti_ray_enter(&ray, &s->volume->bounds->bvh, s->org, s->dir, after, s->time);
    pti_hit_init(&hit, 0);
    if (!s->trace(s->volume->bounds, &ray, &hit, 0)) return 0;
    pti_vertex_fill(s->volume->bounds, &ray, &hit, &x);
    *t = hit.t;
    return pti_dot(x.ng, s->dir) * s->volume->outwards > 0 ? -1 : 1;
}
static int pti_span_closed(pti_span *s) {
    float t = s->to;
    int wall;
    for (;;) {
        s->from = t;
        wall = pti_span_wall(s, s->from, &t);
        if (!wall || s->from >= s->tmax) return 0;
        if (wall < 0 && !s->outside) break;
        s->outside = 0;
    }
    s->to = pti_min(t, s->tmax);
    return s->to > s->from;
}
/* The next stretch; 0: there is none. */
static int pti_span_next(pti_span *s) {
    if (s->volume->kind == PTI_IN_CLOSED) return pti_span_closed(s);
    if (s->last) return 0;
    s->last = 1;
    switch (s->volume->kind) {
    case PTI_IN_BOX:  pti_span_box(s); break;
    case PTI_IN_BALL: pti_span_ball(s); break;
    default:          s->to = pti_min(s->tmax, PTI_FOG_END);
    }
    return s->to > s->from;
}
/* How much of the ray up to t is inside. */
static float pti_span_length(const pti_flight *f, const pti_volume *v, float t) {
    pti_span s;
    float sum = 0;
    if (f->stretch_of == v) return pti_max(pti_min(f->stretch.to, t) - f->stretch.from, 0);
    pti_span_begin(&s, f, v, t);
    while (pti_span_next(&s)) sum += s.to - s.from;
    return sum;
}

/* ---- a flight in one volume */

/* Its first random number: a stratified one of the volume's own, since all volumes' flights are independent. */
static uint32_t pti_flight_draw(const pti_flight *f, const pti_volume *v) {
    uint32_t which = (uint32_t)(v - f->volumes->all);
    pt_rng rng;
    if (!f->sampler) { rng = pti_sample_rng(pti_hash2(f->seed, which), f->index); return pt_rng_u32(&rng); }
    return pti_draw1(f->sampler, which ? f->group ^ (pti_hash(which) & 0xfffffffu) : f->group);
}
static float pti_exponential(float u) { return -pti_log(1 - u); }
static pt_vec3 pti_exp3(pt_vec3 x) {                     /* of greys, once; of 0, not at all */
    float e = x.x == 0 ? 1.0f : pti_exp(x.x);
    return pt_v3(e, x.y == x.x ? e : pti_exp(x.y), x.z == x.x ? e : pti_exp(x.z));
}

/* The angle at which a lamp sees the ray from s to t: that between two vectors (distance, s - at) and (distance, t - at). */
static double pti_aim_angle(const pti_aim *aim, float s, float t) {
    double d = (double)aim->distance, x = (double)s - (double)aim->at, y = (double)t - (double)aim->at;
    return pti_atan2_double(d * (y - x), d * d + x * y);
}
/* 0: w is 0. It is the lamps' part of what light is there, less where they are so far off the ray, in mean free paths, that
   1 / r^2 hardly changes within one. */
static int pti_aimed_weigh(const pti_flight *f, const pti_volume *v, pti_aimed *a) {
    float sigma = pti_luminance(v->medium->sigma_t), length, near_t, r, sky;
    double part, keen = 0;
    int k;
    a->sum = 0;
    for (k = 0; k < f->aim_count; k++) {
        const pti_aim *aim = f->aims + k;
        near_t = pti_clamp(aim->at, a->from, a->to);
        r = (near_t - aim->at) * (near_t - aim->at) + aim->distance * aim->distance;
        a->weight[k] = aim->power * pti_exp(-sigma * (near_t - a->from));
        a->angle[k] = pti_aim_angle(aim, a->from, a->to);
        part = (double)a->weight[k] * a->angle[k] / (double)aim->distance;
        a->sum += part;
        keen += part / (double)(1 + sigma * sigma * r);
    }
    length = a->to - a->from;
    sky = f->sky * (sigma > 0 ? (1 - pti_luminance(a->T)) / sigma : length);
    if (!(a->sum > 1e-30 && a->sum < 1e30)) return 0;
    a->share = PTI_AIM_SHARE * (float)(keen / (a->sum + (double)sky));
    if (!(a->share > 0.02f)) a->share = 0;
    return a->share > 0;
}
/* Sets f->stretch, where there is one at most; of another volume, anew: f->end is the same for all. */
static void pti_flight_aim(pti_flight *f, const pti_volume *v) {
    pti_span s;
    if (f->stretch_of == v || v->kind == PTI_IN_CLOSED || pti_medium_tracked(v->medium)) return;
    f->stretch_of = v;
    f->is_aimed = 0;
    f->stretch.from = f->stretch.to = f->stretch.share = 0;
    f->stretch.T = pt_v3(1, 1, 1);
    pti_span_begin(&s, f, v, f->end);
    if (!pti_span_next(&s)) return;
    f->stretch.from = s.from; f->stretch.to = s.to;
    f->stretch.T = pti_exp3(pti_scale(v->medium->sigma_t, s.from - s.to));
    f->is_aimed = f->aim_count && v->medium->scatters && pti_aimed_weigh(f, v, &f->stretch);
}
static float pti_aimed_pdf(const pti_flight *f, const pti_aimed *a, float t) {
    double sum = 0;
    int k;
    if (t < a->from || t > a->to) return 0;
    for (k = 0; k < f->aim_count; k++) {
        double d = (double)f->aims[k].distance, x = (double)t - (double)f->aims[k].at;
        sum += (double)a->weight[k] / (d * d + x * x);
    }
    return (float)(sum / a->sum);
}
static float pti_aimed_beyond(const pti_flight *f, const pti_aimed *a, float t) {      /* 1 - E(t) */
    double sum = 0;
    int k;
    if (t <= a->from || t >= a->to) return t <= a->from ? 1.0f : 0.0f;
    for (k = 0; k < f->aim_count; k++)
        sum += (double)a->weight[k] * pti_aim_angle(f->aims + k, t, a->to) / (double)f->aims[k].distance;
    return pti_clamp((float)(sum / a->sum), 0, 1);
}
static float pti_aimed_sample(const pti_flight *f, const pti_aimed *a, uint32_t u) {
    double left = a->sum, part, sine, cosine, d, x;
    int k, last = f->aim_count - 1;
    for (k = 0; k < last; k++) {
        part = (double)a->weight[k] * a->angle[k] / (double)f->aims[k].distance;
        if (pti_split(&u, (float)(part / left))) break;
        left -= part;
    }
    d = (double)f->aims[k].distance;
    x = (double)a->from - (double)f->aims[k].at;
    pti_sincos_double(a->angle[k] * (double)pti_u01(u), &sine, &cosine);
    return pti_clamp((float)((double)f->aims[k].at + d * (x * cosine + d * sine) / (d * cosine - x * sine)), a->from, a->to);
}
/* Where to hit in [0, length], given that something is hit: sigma e^(-sigma t) / (1 - T), T = e^(-sigma length); evenly, where
   that is thin. */
#define PTI_FORCED_THIN 0.1f
static float pti_forced_sample(float sigma, float length, float T, float u) {
    return sigma * length < PTI_FORCED_THIN ? u * length : -pti_log(1 - u * (1 - T)) / sigma;
}
/* Its density, over a T(t) which is 1 / inverse; r: the channel's T(t) over that. */
static float pti_forced_pdf(float sigma, float length, float T, float r, float inverse) {
    return sigma * length < PTI_FORCED_THIN ? inverse / length : sigma * r / (1 - T);
}
static int pti_flight_forced(const pti_flight *f, const pti_volume *v) {      /* not in fog without end: what can hit, will */
    return f->blind && f->stretch_of == v && f->stretch.to > f->stretch.from && f->stretch.to < PTI_FOG_END;
}

/* Hits, virtual ones too, one after the other: mu is the majorant along the way, tau the optical depth left to the next. A
   march makes one in the middle of each step, and calls 1 / step mu. */
#define PTI_FLIGHT_LOOKS 262144                          /* a majorant far above all densities would take years: given up */
typedef struct pti_tracker {
    const pti_medium *medium;
    pti_span span;
    pt_vec3 org, dir;                                    /* in the unit cube */
    float t, tau, mu;
    float most;                                          /* what the density may be there */
    float coin;                                          /* a real hit, if below sigma_t / mu */
    pt_rng rng;
    pt_vec3 density;                                     /* at the hit, a channel */
    int looks;                                           /* how many more there may be */
    int exceeded;                                        /* the callback did, or there were too many looks */
    int axis, plane[3], left[3], step[3];                /* which way it leaves the cell; the next planes; how many cells are
                                                            behind them; where the next one is in memory */
    const float *majorant;                               /* the cell's */
    float leave, next[3], scale[3], first[3];            /* planes are at t = plane * scale + first */
    float until;                                         /* hits are before */
    float marched, steps;                                /* up to where; how many on this stretch */
} pti_tracker;

PTI_INLINE void pti_tracker_look(pti_tracker *k) {           /* into the cell that it is in */
    k->axis = k->next[0] <= k->next[1] ? (k->next[0] <= k->next[2] ? 0 : 2) : k->next[1] <= k->next[2] ? 1 : 2;
    k->leave = k->next[k->axis];
    k->most = *k->majorant;
    k->mu = k->medium->largest * k->most;
}
static void pti_tracker_enter(pti_tracker *k) {          /* the cell at t */
    const int *cells = k->span.volume->cells;
    int i;
    if (!k->span.volume->majorants) {
        k->most = k->medium->varies ? k->medium->density_max : 1.0f;
        k->mu = k->medium->largest * k->most;
        k->leave = FLT_MAX;
        return;
    }
    k->majorant = k->span.volume->majorants;
    for (i = 2; i >= 0; i--) {
        float n = (float)cells[i], d = pti_axis(k->dir, i) * n, o = pti_axis(k->org, i) * n;
        int cell = pti_voxel_index(o + k->t * d, cells[i]), stride = i == 0 ? 1 : i == 1 ? cells[0] : cells[0] * cells[1];
        k->majorant += cell * stride;
        k->plane[i] = cell + (d > 0);
        k->left[i] = d > 0 ? cells[i] - 1 - cell : cell;
        k->step[i] = d > 0 ? stride : -stride;
        k->scale[i] = d != 0 ? 1 / d : 0.0f;
        k->first[i] = -o * k->scale[i];
        k->next[i] = d != 0 ? (float)k->plane[i] * k->scale[i] + k->first[i] : FLT_MAX;
    }
    pti_tracker_look(k);
}
PTI_INLINE void pti_tracker_advance(pti_tracker *k) {        /* into the next cell, or out of the grid */
    int i = k->axis;
    if (k->left[i]-- <= 0) k->next[i] = FLT_MAX;
    else {
        k->majorant += k->step[i];
        k->plane[i] += k->step[i] > 0 ? 1 : -1;
        k->next[i] = (float)k->plane[i] * k->scale[i] + k->first[i];
    }
    pti_tracker_look(k);
}
static void pti_tracker_begin(pti_tracker *k, const pti_flight *f, const pti_volume *v, float tmax) {
    uint32_t u = pti_flight_draw(f, v);
    k->medium = v->medium;
    k->until = tmax;
    pti_span_begin(&k->span, f, v, k->medium->tracking != PT_TRACK_EXACT ? pti_max(tmax, f->end) : tmax);
    k->org = pti_xform_point(&v->to_unit, k->span.org);
    k->dir = pti_xform_vector(&v->to_unit, k->span.dir);
    k->rng = pti_sample_rng(pti_hash2(f->seed, u), f->index);
    k->tau = pti_exponential(pti_u01(u));
    k->coin = pti_u01(u);                                /* of PT_TRACK_MARCH_CDF */
    k->t = k->marched = k->steps = 0;
    k->mu = 0;
    k->leave = 0;
    k->looks = PTI_FLIGHT_LOOKS;
    k->exceeded = 0;
}
static pt_vec3 pti_tracker_density(pti_tracker *k) {
    const pti_medium *m = k->medium;
    float d;
    if (!m->varies) return pt_v3(1, 1, 1);
    if (m->grid) return pti_grid_densities(m, pti_madd(k->dir, k->t, k->org));
    if (!(k->most > 0)) return pt_v3(0, 0, 0);
    d = m->density(m->user, pti_madd(k->span.dir, k->t, k->span.org));
    if (!(d <= k->most * 1.0001f)) k->exceeded = 1;      /* NaN, too */
    d = d > 0 ? d : 0.0f;
    return pt_v3(d, d, d);
}
/* The next step, if its middle, where it hits, is before tmax. However far is asked, steps are those of the whole flight: it is
   weighed by the very steps that it took. */
static int pti_tracker_march(pti_tracker *k) {
    float step, next;
    if (k->marched >= k->span.to) {
        if (!pti_span_next(&k->span)) return 0;
        k->marched = k->span.from;
        k->steps = 0;
    }
    step = pti_min(k->medium->step, k->span.to - k->marched);
    k->t = k->marched + 0.5f * step;
    next = k->span.from + ++k->steps * step;             /* not marched + step: far away, that errs alike each time */
    if (step == k->medium->step && !(next > k->marched)) k->exceeded = 1;      /* too small a step for floats so far away */
    k->marched = step < k->medium->step || !(next > k->marched) ? k->span.to : next;
    if (k->medium->density) pti_tracker_enter(k);        /* for the bound */
    k->density = pti_tracker_density(k);
    k->mu = 1 / step;
    if (k->medium->tracking == PT_TRACK_MARCH) k->coin = pt_rng_float(&k->rng);
    return k->t < k->until;
}
/* The next hit before tmax, or 0. */
static int pti_tracker_next(pti_tracker *k) {
    if (k->looks-- <= 0) { k->exceeded = 1; return 0; }
    if (k->medium->tracking != PT_TRACK_EXACT) return pti_tracker_march(k);
    for (;;) {
        float end, tau;
        while (!(k->mu > 0) && k->leave < k->span.to) { k->t = pti_max(k->t, k->leave); pti_tracker_advance(k); }
        end = pti_min(k->leave, k->span.to);
        tau = k->mu * pti_max(end - k->t, 0);
        if (tau > k->tau) {
            k->t = pti_min(k->t + k->tau / k->mu, end);
            if (k->t >= k->until) return 0;
            k->coin = pt_rng_float(&k->rng);
            k->tau = pti_exponential(pt_rng_float(&k->rng));
            k->density = pti_tracker_density(k);
            return 1;
        }
        k->tau -= tau;
        k->t = pti_max(k->t, end);
        if (k->t >= k->until) return 0;
        if (k->t < k->span.to) { pti_tracker_advance(k); continue; }
        if (!pti_span_next(&k->span)) return 0;
        k->t = k->span.from;
        pti_tracker_enter(k);
    }
}
/* It was a virtual one, whose probability of being real was p. */
static void pti_tracker_pass(pti_tracker *k, float p) {
    if (k->medium->tracking == PT_TRACK_MARCH_CDF) k->coin = p < 1 ? (k->coin - p) / (1 - p) : 1.0f;
}
static float pti_tracker_real(const pti_tracker *k, pt_vec3 sigma, int channel) {
    return pti_min(pti_channel(k->density, channel) * pti_channel(sigma, channel) / k->mu, 1);
}
static pt_vec3 pti_tracker_virtual(const pti_tracker *k) {      /* the probabilities of being none */
    pt_vec3 s = k->medium->sigma_t;
    return pt_v3(1 - pti_tracker_real(k, s, 0), 1 - pti_tracker_real(k, s, 1), 1 - pti_tracker_real(k, s, 2));
}

/* Where the hero hits, or tmax. */
static float pti_volume_hit(pti_flight *f, const pti_volume *v, float tmax) {
    const pti_medium *m = v->medium;
    float sigma = pti_channel(m->sigma_t, f->hero), tau, p;
    pti_tracker k;
    pti_span s;
    uint32_t u;
    if (!m->scatters) return tmax;
    if (!pti_medium_tracked(m)) {
        u = pti_flight_draw(f, v);
        pti_flight_aim(f, v);
        if (f->stretch_of == v && f->is_aimed) {
            f->weigh = 1;
            if (pti_split(&u, f->stretch.share)) return pti_min(pti_aimed_sample(f, &f->stretch, u), tmax);
        }
        if (pti_flight_forced(f, v)) {
            f->weigh = 1;
            return pti_min(f->stretch.from + pti_forced_sample(sigma, f->stretch.to - f->stretch.from,
                                                             pti_channel(f->stretch.T, f->hero), pti_u01(u)), f->stretch.to);
        }
        if (!(sigma > 0)) return tmax;
        tau = pti_exponential(pti_u01(u)) / sigma;
        if (f->stretch_of == v) return tau < pti_span_length(f, v, tmax) ? pti_min(f->stretch.from + tau, tmax) : tmax;
        pti_span_begin(&s, f, v, tmax);
        for (; pti_span_next(&s); tau -= s.to - s.from)
            if (tau < s.to - s.from) return pti_min(s.from + tau, tmax);
        return tmax;
    }
    pti_tracker_begin(&k, f, v, tmax);
    while (pti_tracker_next(&k)) {
        p = pti_tracker_real(&k, m->sigma_t, f->hero);
        if (k.coin < p) { tmax = k.t; break; }
        pti_tracker_pass(&k, p);
    }
    f->exceeded |= k.exceeded;
    return tmax;
}
/* What a volume whose distances are aimed, or forced to hit, has under q_c, over the T of its clearest channel: r is T_c over that,
   and inverse is 1 over that. (Where even that one is below e^-80, what comes of the place is nothing to anyone.) */
static pt_vec3 pti_aimed_density(const pti_flight *f, const pti_volume *v, float t, int hit, pt_vec3 r, float inverse) {
    const pti_aimed *a = &f->stretch;
    pt_vec3 s = v->medium->sigma_t;
    float w = a->share, e = w > 0 ? w * inverse * (hit ? pti_aimed_pdf(f, a, t) : pti_aimed_beyond(f, a, t)) : 0.0f;
    float length = a->to - a->from;
    if (hit && pti_flight_forced(f, v))
        r = pt_v3(pti_forced_pdf(s.x, length, a->T.x, r.x, inverse), pti_forced_pdf(s.y, length, a->T.y, r.y, inverse),
                  pti_forced_pdf(s.z, length, a->T.z, r.z, inverse));
    else if (hit) r = pti_mul(r, s);
    return pt_v3((1 - w) * r.x + e, (1 - w) * r.y + e, (1 - w) * r.z + e);
}
static pt_vec3 pti_density_at(const pti_flight *f, const pti_volume *v, float t) {
    pti_tracker k;
    pti_tracker_begin(&k, f, v, t);
    k.t = t;
    k.most = FLT_MAX;                                    /* nothing is above that */
    return pti_tracker_density(&k);
}
/* *F and *P are multiplied by F_i and P_c up to t, or of a hit at t. Deep in a medium both are too small for a float, but only
   F / P is wanted: so both are divided by a number that is at least as large as any channel's, the transmittance of the clearest
   channel, or in what is tracked the hero's, which got there. */
static void pti_volume_weigh(pti_flight *f, const pti_volume *v, float t, int hit, pt_vec3 *F, pt_vec3 *P) {
    const pti_medium *m = v->medium;
    float length, least, p;
    pti_tracker k;
    pt_vec3 r;
    int aims;
    pti_flight_aim(f, v);
    aims = f->stretch_of == v && (f->is_aimed || f->blind);
    if (hit) *F = pti_mul(*F, m->sigma_s);
    if (hit && !aims) *P = pti_mul(*P, m->sigma_t);
    if (hit && m->channels == 3) {                       /* else the density is in both alike */
        r = pti_density_at(f, v, t);
        *F = pti_mul(*F, r);
        *P = pti_mul(*P, r);
    }
    if (!pti_medium_weighs(m) && !aims) return;
    if (!pti_medium_tracked(m)) {
        length = pti_span_length(f, v, t);
        least = m->scatters ? pti_min(m->sigma_t.x, pti_min(m->sigma_t.y, m->sigma_t.z)) : 0.0f;
        r = pti_exp3(pt_v3((least - m->sigma_t.x) * length, (least - m->sigma_t.y) * length, (least - m->sigma_t.z) * length));
        *F = pti_mul(*F, r);
        if (aims) *P = pti_mul(*P, pti_aimed_density(f, v, t, hit, r, pti_exp(pti_min(least * length, 80))));
        else if (m->scatters) *P = pti_mul(*P, r);
        return;
    }
    pti_tracker_begin(&k, f, v, t);
    while (pti_tracker_next(&k) && pti_largest(*F) > 0) {
        p = m->scatters ? pti_tracker_real(&k, m->sigma_t, f->hero) : 0.0f;
        if (p >= 1) break;
        r = pti_tracker_virtual(&k);
        r = pt_v3(r.x / (1 - p), r.y / (1 - p), r.z / (1 - p));
        *F = pti_mul(*F, r);
        if (m->scatters) *P = pti_mul(*P, r);
        pti_tracker_pass(&k, p);
    }
    f->exceeded |= k.exceeded;
    if (hit && m->tracking != PT_TRACK_EXACT) {          /* where it stands; no channel hits more than once in a step */
        r = pti_mul(m->sigma_t, k.density);
        r = pt_v3(pti_min(k.mu / r.x, 1), pti_min(k.mu / r.y, 1), pti_min(k.mu / r.z, 1));
        *F = pti_mul(*F, r);
        *P = pti_mul(*P, r);
    }
}
/* Transmittance, for rays that nothing else is asked of: by ratio tracking where it varies, in the mean (Novak et al. 2014). */
static pt_vec3 pti_volume_transmittance(pti_flight *f, const pti_volume *v, float t) {
    const pti_medium *m = v->medium;
    pt_vec3 T = pt_v3(1, 1, 1);
    pti_tracker k;
    float length;
    if (!pti_medium_tracked(m)) {
        if (t == f->end && f->volumes->count == 1) pti_flight_aim(f, v);       /* which will be asked anyway */
        if (t == f->end && f->stretch_of == v) return f->stretch.T;
        length = pti_span_length(f, v, t);
        return pti_exp3(pti_scale(m->sigma_t, -length));
    }
    pti_tracker_begin(&k, f, v, t);
    while (pti_tracker_next(&k) && pti_largest(T) > 0)
        T = pti_mul(T, pti_tracker_virtual(&k));
    return T;
}

/* ---- a flight through all of them */

/* Visits the volumes that a ray may meet before tmax: all of a few, else by their tree. */
#define PTI_FEW_VOLUMES 4
typedef struct pti_visit {
    const pti_volumes *volumes;
    size_t next, few;                                    /* so many are visited one by one; then those of the tree */
    pti_ray ray;
    uint32_t stack[PTI_STACK];
    int top;
} pti_visit;
static void pti_visit_begin(pti_visit *v, const pti_flight *f) {
    v->volumes = f->volumes;
    v->next = 0;
    v->few = f->volumes->count;
    v->top = 0;
    if (f->volumes->count <= PTI_FEW_VOLUMES) return;
    v->few = f->volumes->unbounded;
    pti_ray_prepare(&v->ray, f->org, f->dir, 0, f->time, 0);
    v->stack[v->top++] = f->volumes->tree.bvh.root;
}
PTI_NOINLINE const pti_volume *pti_visit_tree(pti_visit *v, float tmax) {
    const pti_volumes *all = v->volumes;
    const pti_node *n;
    float enter[PTI_WIDTH];
    uint32_t child, mask;
    while (v->top) {
        child = v->stack[--v->top];
        if (child == PTI_NONE) continue;
        if (PTI_KIND(child) == PTI_OBJECT) return all->all + all->unbounded + PTI_INDEX(child);
        n = pti_node_at(&all->tree.bvh, child);
        mask = pti_boxes_scalar(n, &v->ray, tmax * PTI_WIDEN, enter);
        for (; mask; mask ^= 1u << pti_highest_bit(mask)) v->stack[v->top++] = n->child[pti_highest_bit(mask)];
    }
    return NULL;
}
PTI_INLINE const pti_volume *pti_visit_next(pti_visit *v, float tmax) {
    if (v->next < v->few) return v->volumes->all + v->next++;
    return v->top ? pti_visit_tree(v, tmax) : NULL;
}
/* The nearest hit before *t, which becomes where it is; NULL: all pass. */
static const pti_volume *pti_flight_hit(pti_flight *f, float *t) {
    const pti_volume *v, *hit = NULL;
    pti_visit visit;
    f->end = *t;
    f->weigh = f->volumes->weigh;
    pti_visit_begin(&visit, f);
    while ((v = pti_visit_next(&visit, *t)) != NULL) {
        float at = pti_volume_hit(f, v, *t);
        if (!(at < *t)) continue;
        *t = at;
        hit = v;
    }
    return hit;
}
/* The weight of having come to t, where `hit` was hit, or NULL. q: of the channels, by which the hero was chosen. */
static pt_vec3 pti_flight_weight(pti_flight *f, float t, const pti_volume *hit, pt_vec3 q) {
    pt_vec3 F = pt_v3(1, 1, 1), P = F;
    const pti_volume *v;
    pti_visit visit;
    float p;
    if (!f->weigh) return hit ? pti_scale(hit->medium->sigma_s, 1 / hit->medium->sigma_t.x) : F;
    pti_visit_begin(&visit, f);
    while ((v = pti_visit_next(&visit, t)) != NULL) pti_volume_weigh(f, v, t, v == hit, &F, &P);
    p = pti_dot(q, P);
    return p > 0 ? pti_scale(F, 1 / p) : pt_v3(0, 0, 0);
}
/* Is all that it meets on its way to t constant, so that the transmittance is known at once? */
static int pti_flight_is_plain(const pti_flight *f, float t) {
    const pti_volume *v;
    pti_visit visit;
    pti_visit_begin(&visit, f);
    while ((v = pti_visit_next(&visit, t)) != NULL) if (pti_medium_tracked(v->medium)) return 0;
    return 1;
}
static pt_vec3 pti_flight_transmittance(pti_flight *f, float t) {
    pt_vec3 T = pt_v3(1, 1, 1);
    const pti_volume *v;
    pti_visit visit;
    pti_visit_begin(&visit, f);
    while (!pti_is_zero3(T) && (v = pti_visit_next(&visit, t)) != NULL) T = pti_mul(T, pti_volume_transmittance(f, v, t));
    return T;
}
/* What glows along the way up to t, where the path got by chance: epsilon at two places, over the density that they were drawn
   with, times the weight of having come there. Places are drawn as majorants go, so none from where nothing is. (Measured in two
   fires: two places are 1.4 and 1.7 times as efficient as one; four and eight gain no more than they cost.) */
#define PTI_GLOWS 2
/* The integral of majorants up to tmax; *at and *most are the place where it reaches target, or the last one, and what stands
   there. */
static float pti_majorant_integral(const pti_flight *f, const pti_volume *v, float tmax, float target, float *at, float *most) {
    pti_tracker k;
    float sum = 0, end, part;
    pti_tracker_begin(&k, f, v, tmax);
    pti_span_begin(&k.span, f, v, tmax);                 /* that of a march goes on to the flight's end */
    while (pti_span_next(&k.span)) {
        for (k.t = k.span.from, pti_tracker_enter(&k); ; pti_tracker_advance(&k)) {
            end = pti_min(k.leave, k.span.to);
            *most = k.most;
            *at = end;
            part = *most * pti_max(end - k.t, 0);
            if (sum + part > target) {
                *at = pti_min(k.t + (target - sum) / *most, end);
                return target;
            }
            sum += part;
            k.t = pti_max(k.t, end);
            if (k.t >= k.span.to) break;
        }
    }
    return sum;
}
/* What stands for all of it at one place, where the integral of majorants is so much. */
static pt_vec3 pti_glow_at(pti_flight *f, const pti_volume *v, float t, float integral, pt_vec3 q) {
    const pti_medium *m = v->medium;
    pt_vec3 e = m->emission;
    float most, at = -1;
    pti_tracker k;
    pti_majorant_integral(f, v, t, integral, &at, &most);
    pti_tracker_begin(&k, f, v, t);
    k.t = at;
    k.most = FLT_MAX;
    if (!(most > 0)) return pt_v3(0, 0, 0);              /* the very end */
    if (m->varies) {
        pt_vec3 d = pti_tracker_density(&k);
        f->exceeded |= k.exceeded;                       /* NaN */
        e = pti_mul(e, pt_v3(d.x / most, d.y / most, d.z / most));
    }
    if (pti_is_zero3(e)) return e;
    if (m->glow) e = pti_mul(e, pti_max3(m->glow(m->user, pti_madd(k.span.dir, at, k.span.org)), pt_v3(0, 0, 0)));
    return f->weigh ? pti_mul(e, pti_flight_weight(f, at, NULL, q)) : e;
}
/* A path goes on as far as chance lets it, or where nothing scatters as far as it can; but light fades, by what is weighed: here,
   and in fog everywhere. So a quarter of the places are drawn evenly, and one as each channel fades,
       p(s) = 1/4 (1 / S + sum_c sigma_c e^(-sigma_c s) / (1 - e^(-sigma_c S))),      0 <= s <= S.
   Where densities vary, majorants fade faster than light does: so where those are deep, half of the places are drawn evenly, and
   half by 1 / (1 + sigma s) over its integral, which gives each power of two the same. */
#define PTI_GLOW_DEEP 16.0f                              /* optical depth */
static pt_vec3 pti_glow_fading(const pti_flight *f, const pti_volume *v) {       /* sigma_c */
    const pti_volume *all = f->volumes->all;
    pt_vec3 sigma = pti_medium_weighs(v->medium) ? v->medium->sigma_t : pt_v3(0, 0, 0);
    size_t i;
    for (i = 0; i < f->volumes->unbounded; i++)
        if (all + i != v && pti_medium_weighs(all[i].medium)) sigma = pti_add(sigma, all[i].medium->sigma_t);
    return sigma;
}
/* From u in [0, 1) to a place in [0, all]; *over is 1 / density. */
static float pti_glow_fade(pt_vec3 sigma, float all, uint32_t strategy, float u, float *over) {
    float s = strategy < 3 ? pti_channel(sigma, (int)strategy) : 0.0f, pdf = 1 / all, at;
    int c;
    at = pti_min(pti_forced_sample(s, all, pti_exp(-s * all), u), all);
    for (c = 0; c < 3; c++) {
        s = pti_channel(sigma, c);
        pdf += pti_forced_pdf(s, all, pti_exp(-s * all), pti_exp(-s * at), 1);
    }
    *over = 4 / pdf;
    return at;
}
static float pti_glow_slow(float sigma, float all, uint32_t strategy, float u, float *over) {
    float range = pti_log(1 + sigma * all), at = u * all;
    if (strategy < 2) at = pti_min((pti_exp(u * range) - 1) / sigma, all);
    *over = 2 / (1 / all + sigma / (range * (1 + sigma * at)));
    return at;
}
static pt_vec3 pti_volume_glow(pti_flight *f, const pti_volume *v, float t, pt_vec3 q) {
    const pti_medium *m = v->medium;
    float most, at, all = pti_majorant_integral(f, v, t, FLT_MAX, &at, &most), u, over;
    pt_vec3 sum = pt_v3(0, 0, 0), sigma;
    uint32_t draw, i, strategy;
    if (!(all > 0) || (!m->varies && !m->glow && !f->weigh)) return pti_scale(m->emission, all);
    sigma = pti_glow_fading(f, v);
    draw = pti_hash2(pti_flight_draw(f, v), 0x91e10da5u);
    for (i = 0; i < PTI_GLOWS; i++) {
        u = ((float)i + pti_u01(draw)) / PTI_GLOWS;
        strategy = (pti_hash(draw) + 2 * i) & 3;         /* of each place another */
        at = u * all; over = all;
        if (!m->varies) at = pti_glow_fade(sigma, all, strategy, u, &over);
        else if (pti_largest(sigma) * all > PTI_GLOW_DEEP) at = pti_glow_slow(pti_largest(sigma), all, strategy, u, &over);
        sum = pti_add(sum, pti_scale(pti_glow_at(f, v, t, at, q), over / PTI_GLOWS));
    }
    return sum;
}
static pt_vec3 pti_flight_glow(pti_flight *f, float t, pt_vec3 q) {
    pt_vec3 sum = pt_v3(0, 0, 0);
    const pti_volume *v;
    pti_visit visit;
    if (!f->volumes->emit) return sum;
    pti_visit_begin(&visit, f);
    while ((v = pti_visit_next(&visit, t)) != NULL) if (v->medium->emits) sum = pti_add(sum, pti_volume_glow(f, v, t, q));
    return sum;
}

/* ---- the glow round lamps, a density in the mixture

   Distances are only half of it: which way does light come that a lamp in a medium sends by way of one particle? From an angle
   theta off the lamp, d away, in thin fog, as
       L(theta) ~ sigma_s Phi / d  (pi - theta) / sin(theta)
   (airlight: the integral of 1 / r^2 along the ray; Sun, Ramamoorthi, Narasimhan and Nayar 2005), so
       p(theta) = (pi - theta) / (pi^3 sin(theta)),     theta = pi (1 - sqrt(1 - u)).
   With distances that go as 1 / r^2 along such a ray, particles come to be where light does, and no lamp is too small. */
static float pti_halo_weight(const pti_halo *h, const pt_vertex *x) {
    float d = pti_length(pti_sub(h->p, x->p));
    return d > 1e-12f ? h->power / d * pti_exp(-pti_min(h->sigma * d, 60)) : 0.0f;
}
static float pti_halo_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const pti_halos *halos = (const pti_halos *)user;
    float all = 0, sum = 0, w, sine;
    int k;
    for (k = 0; k < halos->count; k++) {
        pt_vec3 d = pti_normalize(pti_sub(halos->lamp[k].p, x->p));
        w = pti_halo_weight(halos->lamp + k, x);
        if (!(w > 0)) continue;
        sine = pti_max(pti_length(pti_cross(d, wi)), 1e-7f);
        all += w;
        sum += w * (PTI_PI - pti_atan2(sine, pti_dot(d, wi))) / sine;
    }
    return all > 0 ? sum / (all * PTI_PI * PTI_PI * PTI_PI) : 0.0f;
}
static int pti_halo_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    const pti_halos *halos = (const pti_halos *)user;
    float w[PTI_HALOS], all = 0, r, sine, cosine;
    pt_vec3 axis, t, b, local;
    int k;
    for (k = 0; k < halos->count; k++) all += w[k] = pti_halo_weight(halos->lamp + k, x);
    if (!(all > 0)) return 0;
    r = u[0] * all;
    for (k = 0; k < halos->count - 1 && r >= w[k]; k++) r -= w[k];
    if (!(w[k] > 0)) return 0;
    axis = pti_normalize(pti_sub(halos->lamp[k].p, x->p));
    pti_sincos(PTI_PI * (1 - pti_safe_sqrt(1 - pti_min(r / w[k], 1))), &sine, &cosine);
    pti_sincos(2 * PTI_PI * u[1], &local.y, &local.x);
    pti_basis(axis, &t, &b);
    *wi = pti_normalize(pti_to_world(t, b, axis, pt_v3(local.x * sine, local.y * sine, cosine)));
    return 1;
}
/* What is scattered once to what comes straight: about sigma d pi^2 / 4. */
static float pti_halo_importance(void *user, const pt_vertex *x) {
    const pti_halos *halos = (const pti_halos *)user;
    float all = 0, sum = 0, w, s;
    int k;
    for (k = 0; k < halos->count; k++) {
        w = pti_halo_weight(halos->lamp + k, x);
        s = halos->lamp[k].sigma * pti_length(pti_sub(halos->lamp[k].p, x->p)) * (PTI_PI * PTI_PI / 4);
        all += w;
        sum += w * s / (1 + s);
    }
    return all > 0 ? sum / all : 0.0f;
}

/* ---- >>microfacet --------------------------------------------------------------------------------------
   Rough surfaces as tiny mirrors (Torrance and Sparrow 1967; tiny panes of glass: Walter et al. 2007). In a frame whose z is
   the normal, on wo's side, their normals m have the GGX distribution, and they hide one another by Smith's functions:
       D(m)      = 1 / (pi ax ay (mx^2/ax^2 + my^2/ay^2 + mz^2)^2),        alpha = roughness^2 along x and along y
       Lambda(w) = (sqrt(1 + (ax^2 wx^2 + ay^2 wy^2) / wz^2) - 1) / 2
       G1(w)     = 1 / (1 + Lambda(w)),    G2(wo, wi) = 1 / (1 + Lambda(wo) + Lambda(wi))             (Heitz 2014)
       f cos     = F D G2 / (4 wo.z)                                                                   (reflection)
   A direction is drawn by a normal that wo sees, D_v(m) = G1(wo) (wo.m) D(m) / wo.z, so that f cos / p is F G2 / G1. */

/* Fresnel's share of reflected light between dielectrics; eta = index behind the surface over index before it. Snell:
   sin t = sin i / eta; where that exceeds 1, all is reflected. *cos_t gets the refracted cosine. */
static float pti_fresnel(float cos_i, float eta, float *cos_t) {
    float c2 = (eta - 1) * (eta + 1) + cos_i * cos_i, s, p;    /* (eta cos t)^2; exact where eta is 1 */
    if (c2 <= 0) { *cos_t = 0; return 1; }
    *cos_t = sqrtf(c2) / eta;
    s = (cos_i - eta * *cos_t) / (cos_i + eta * *cos_t);
    p = (eta * cos_i - *cos_t) / (eta * cos_i + *cos_t);
    return pti_min((s * s + p * p) / 2, 1);
}
/* On a metal of complex index eta + i k (Born and Wolf, 14.2). */
static float pti_fresnel_metal(float cos_i, float eta, float k) {
    float c2 = cos_i * cos_i, s2 = 1 - c2, e = eta * eta - k * k - s2, ab = sqrtf(e * e + 4 * eta * eta * k * k);
    float a = 2 * cos_i * sqrtf(pti_max((ab + e) / 2, 0)), s = (ab + c2 - a) / (ab + c2 + a);
    float p = s * (c2 * ab + s2 * s2 - a * s2) / (c2 * ab + s2 * s2 + a * s2);
    return pti_max(pti_min((s + p) / 2, 1), 0);         /* 0 / 0, where eta and k are 0: 1 */
}
/* Measured indices, averaged over the bands of red, green and blue: those that come with Mitsuba, which has them from SOPRA's
   database. */
#define PTI_METALS(X) \
    X(aluminium, 1.657f, 0.880f, 0.521f, 9.224f, 6.270f, 4.837f) X(brass, 0.444f, 0.527f, 1.094f, 3.695f, 2.765f, 1.829f) \
    X(chromium, 4.370f, 2.917f, 1.655f, 5.206f, 4.231f, 3.755f)  X(copper, 0.200f, 0.924f, 1.102f, 3.913f, 2.453f, 2.142f) \
    X(gold, 0.143f, 0.375f, 1.442f, 3.983f, 2.386f, 1.603f)      X(iron, 2.911f, 2.950f, 2.585f, 3.089f, 2.932f, 2.767f) \
    X(mercury, 2.073f, 1.552f, 1.061f, 5.338f, 4.651f, 3.863f)   X(platinum, 2.376f, 2.085f, 1.845f, 4.266f, 3.715f, 3.137f) \
    X(silver, 0.155f, 0.117f, 0.138f, 4.828f, 3.122f, 2.147f)    X(titanium, 2.741f, 2.542f, 2.237f, 3.814f, 3.435f, 3.039f)
PT_DEF int pt_metal(const char *name, pt_vec3 *eta, pt_vec3 *k) {
#define PTI_METAL_ROW(n, er, eg, eb, kr, kg, kb) \
    if (name && eta && k && !strcmp(name, #n)) { *eta = pt_v3(er, eg, eb); *k = pt_v3(kr, kg, kb); return 1; }
    PTI_METALS(PTI_METAL_ROW)
#undef PTI_METAL_ROW
    return 0;
}
/* Schlick 1994: r0 at normal incidence, 1 at grazing. */
static pt_vec3 pti_fresnel_schlick(float cos_i, pt_vec3 r0) {
    float k = pti_max(1 - cos_i, 0);
    k = k * k * k * k * k;
    return pti_madd(r0, 1 - k, pt_v3(k, k, k));
}

static float pti_ggx_lambda(pt_vec3 w, float ax, float ay) {
    float x = ax * w.x, y = ay * w.y;
    return (sqrtf(1 + (x * x + y * y) / pti_max(w.z * w.z, 1e-30f)) - 1) / 2;
}
static float pti_ggx_d(pt_vec3 m, float ax, float ay) {
    float x = m.x / ax, y = m.y / ay, q = x * x + y * y + m.z * m.z;
    return 1 / (PTI_PI * ax * ay * q * q);
}
/* A normal that wo sees (Dupuy and Benyoub 2023): stretched to a hemisphere, GGX's mirrors turn directions wo into a
   spherical cap, uniformly; the normal is half-way. */
static pt_vec3 pti_sample_ggx(pt_vec3 wo, float ax, float ay, float u, float v) {
    pt_vec3 w = pti_normalize(pt_v3(wo.x * ax, wo.y * ay, wo.z));
    float z = (1 - v) * (1 + w.z) - w.z, r = pti_safe_sqrt(1 - z * z), s, c;
    pti_sincos(2 * PTI_PI * u, &s, &c);
    return pti_normalize(pt_v3((w.x + r * c) * ax, (w.y + r * s) * ay, pti_max(w.z + z, 0)));
}
static inline float pti_pdf_ggx(pt_vec3 wo, pt_vec3 m, float ax, float ay) {
    float d = pti_dot(wo, m);
    return d > 0 ? d * pti_ggx_d(m, ax, ay) / (wo.z * (1 + pti_ggx_lambda(wo, ax, ay))) : 0.0f;
}
static pt_vec3 pti_mirrored(pt_vec3 wo, pt_vec3 m) { return pti_normalize(pti_sub(pti_scale(m, 2 * pti_dot(m, wo)), wo)); }
static pt_vec3 pti_refracted(pt_vec3 wo, pt_vec3 m, float eta, float cos_t) {
    return pti_normalize(pti_sub(pti_scale(m, pti_dot(m, wo) / eta - cos_t), pti_scale(wo, 1 / eta)));
}

/* Fuzz, after Estevez and Kulla 2017: fibres stand up, so what shines is what leans away,
       D(m) = (2 + 1/a) sin(m)^(1/a) / (2 pi),    f cos = D / (4 wo.z (1 + Lambda(wo) + Lambda(wi))),
   with their fit for the logarithm of Smith's Lambda, L(z) = A / (1 + B z^C) + D z + E below z = 1/2, and 2 L(1/2) - L(1 - z)
   above. */
static float pti_sheen_l(float z, float t) {             /* t from 1, smooth, to 0 */
    float A = 21.5473f + t * 3.7772f, B = 3.82987f - t * 0.50552f, C = 0.19823f - t * 0.03022f;
    float D = -1.97760f + t * 0.70367f, E = -4.32054f - t * 0.53913f;
    return A / (1 + B * pti_pow(z, C)) + D * z + E;
}
static float pti_sheen_lambda(float z, float t) {
    return pti_exp(z < 0.5f ? pti_sheen_l(z, t) : 2 * pti_sheen_l(0.5f, t) - pti_sheen_l(pti_max(1 - z, 0), t));
}
static float pti_sheen(pt_vec3 wo, pt_vec3 wi, float alpha) {
    pt_vec3 m = pti_normalize(pti_add(wo, wi));
    float s2 = pti_max(1 - m.z * m.z, 0), d = (2 + 1 / alpha) * pti_pow(s2, 0.5f / alpha) / (2 * PTI_PI), t = 1 - alpha;
    return d / (4 * wo.z * (1 + pti_sheen_lambda(wo.z, t * t) + pti_sheen_lambda(wi.z, t * t)));
}

/* How much of the light a rough surface sends on, seen from wo: E = the integral of f cos over wi. A mirror's E falls to 0.4
   at roughness 1, since one bounce is counted and the light that meets a second mirror is lost; the lobes below give it back
   (Kulla and Conty 2017), and layers leave to what is under them 1 - E. There is no closed form, so at commit E goes into
   tables over x = sqrt(mu), mu = wo.z, and over the roughness or, where it differs along x and y, over the angle around z. */
#define PTI_ALBEDO 32
typedef struct pti_albedo_table {
    float e[PTI_ALBEDO][PTI_ALBEDO], mean[PTI_ALBEDO];   /* e[row][column]: columns go by x from 0 to 1; rows by roughness from
                                                            0 to 1, or by the angle from 0 to 90 degrees */
    float lost[PTI_ALBEDO][PTI_ALBEDO];                  /* running sums of (1 - E) mu dmu over x, to draw x with */
} pti_albedo_table;
typedef struct pti_albedo {
    float eta, ax, ay;                                   /* of what: eta 0 a perfect mirror, -1 fuzz; ax 0: rows are
                                                            roughness, else angles, for this ax and ay */
    float fresnel_mean;                                  /* of the smooth surface, seen from outside */
    pti_albedo_table total[2], reflected;                /* all light, from outside and from inside; reflected outside */
} pti_albedo;

/* E from wo, by the midpoint rule over the numbers that D_v is drawn with (v by its square: near 1 it changes fast). Without
   eta, of a perfect mirror. n x rows points; sum[0] reflected, sum[1] all. */
#define PTI_ALBEDO_U 16
#define PTI_ALBEDO_V 32
static void pti_albedo_integrate(pt_vec3 wo, float ax, float ay, float eta, int n, int rows, float sum[2]) {
    float lambda = 1 + pti_ggx_lambda(wo, ax, ay), around = 1;
    int i, j;
    if (ax == ay) {                                      /* about the z axis all is alike, so turned, half of it will do */
        wo = pt_v3(pti_safe_sqrt(1 - wo.z * wo.z), 0, wo.z);
        around = 0.5f;
    }
    sum[0] = sum[1] = 0;
    for (j = 0; j < rows; j++) for (i = 0; i < n; i++) {
        float s = 1 - ((float)j + 0.5f) / (float)rows, u = around * ((float)i + 0.5f) / (float)n, cos_t = 0, F = 1;
        pt_vec3 m = pti_sample_ggx(wo, ax, ay, u, 1 - s * s), wi = pti_mirrored(wo, m);
        float g = wi.z > 0 ? 2 * s * lambda / (lambda + pti_ggx_lambda(wi, ax, ay)) : 0.0f;
        if (eta > 0) F = pti_fresnel(pti_min(pti_dot(wo, m), 1), eta, &cos_t);
        sum[0] += F * g;
        if (F >= 1) continue;
        wi = pti_refracted(wo, m, eta, cos_t);
        if (wi.z < 0) sum[1] += (1 - F) * 2 * s * lambda / (lambda + pti_ggx_lambda(wi, ax, ay));
    }
    sum[0] = pti_min(sum[0] / (float)(n * rows), 1);
    sum[1] = pti_min(sum[0] + sum[1] / (float)(n * rows), 1);
}
static float pti_sheen_integrate(pt_vec3 wo, float alpha) {
    float sum = 0;
    int i, j;
    for (j = 0; j < PTI_ALBEDO_V; j++) for (i = 0; i < PTI_ALBEDO_U; i++) {
        float z = ((float)j + 0.5f) / PTI_ALBEDO_V, r = pti_safe_sqrt(1 - z * z), s, c;
        pti_sincos(PTI_PI * ((float)i + 0.5f) / PTI_ALBEDO_U, &s, &c);
        sum += pti_sheen(wo, pt_v3(r * c, r * s, z), alpha);
    }
    return pti_min(sum * (2 * PTI_PI) / (PTI_ALBEDO_U * PTI_ALBEDO_V), 1);
}
/* The mean over all wo, the integral of E 2 mu dmu, of what the table below makes of E: linear in x between its entries, so
   that the integral of (f0 + s (x - x0)) 4 x^3 dx has a closed form. */
static float pti_albedo_mean(const float *e) {
    double sum = 0;
    int i;
    for (i = 0; i + 1 < PTI_ALBEDO; i++) {
        double x0 = (double)i / (PTI_ALBEDO - 1), x1 = (double)(i + 1) / (PTI_ALBEDO - 1);
        double a = x0 * x0 * x0 * x0, b = x1 * x1 * x1 * x1;
        double slope = ((double)e[i + 1] - (double)e[i]) * (PTI_ALBEDO - 1);
        sum += ((double)e[i] - slope * x0) * (b - a) + slope * 0.8 * (b * x1 - a * x0);
    }
    return (float)sum;
}
static void pti_albedo_finish(pti_albedo_table *t, int row) {
    float value[PTI_ALBEDO - 1];
    int i;
    t->mean[row] = pti_albedo_mean(t->e[row]);
    for (i = 0; i + 1 < PTI_ALBEDO; i++) {
        float x = (float)i + 0.5f, e = (t->e[row][i] + t->e[row][i + 1]) / 2;
        value[i] = pti_max(1 - e, 1e-4f) * x * x * x;
    }
    pti_table_build(t->lost[row], value, PTI_ALBEDO - 1);
}
#define PTI_LEAST_ALPHA 1e-4f                            /* smoother than that is smooth */
#define PTI_LEAST_FUZZ 0.08f                              /* below, fuzz would reflect more than there is */
static float pti_alpha(float roughness) { return pti_max(roughness * roughness, PTI_LEAST_ALPHA); }
/* Rows are angles around z: they have one mean. */
static void pti_albedo_mean_around(pti_albedo_table *t) {
    float sum = 0;
    int i;
    for (i = 0; i < PTI_ALBEDO; i++) sum += t->mean[i] * (i == 0 || i == PTI_ALBEDO - 1 ? 0.5f : 1.0f);
    for (i = 0; i < PTI_ALBEDO; i++) t->mean[i] = sum / (PTI_ALBEDO - 1);
}
static float pti_fresnel_mean(float eta) {               /* the integral of F 2 mu dmu */
    float sum = 0, cos_t;
    int i;
    for (i = 0; i < 64; i++) sum += pti_fresnel(((float)i + 0.5f) / 64, eta, &cos_t) * ((float)i + 0.5f) * (2.0f / 64 / 64);
    return sum;
}
static void pti_albedo_build(pti_albedo *a) {
    int row, i, n = a->ax == a->ay ? PTI_ALBEDO_U : 2 * PTI_ALBEDO_U;
    for (row = 0; row < PTI_ALBEDO; row++) {
        float y = (float)row / (PTI_ALBEDO - 1), ax = a->ax, ay = a->ay, s = 0, c = 1;
        if (ax > 0) pti_sincos(y * (PTI_PI / 2), &s, &c);
        else ax = ay = pti_alpha(y);
        for (i = 0; i < PTI_ALBEDO; i++) {
            float x = (float)i / (PTI_ALBEDO - 1), mu = pti_max(x * x, 1e-4f), r = sqrtf(1 - mu * mu), sum[2];
            pt_vec3 wo = pt_v3(r * c, r * s, mu);
            if (a->eta < 0) { a->reflected.e[row][i] = pti_sheen_integrate(wo, pti_max(ax, PTI_LEAST_FUZZ)); continue; }
            pti_albedo_integrate(wo, ax, ay, a->eta, n, PTI_ALBEDO_V, sum);
            a->reflected.e[row][i] = sum[0];
            a->total[0].e[row][i] = sum[1];
            if (a->eta > 0) pti_albedo_integrate(wo, ax, ay, 1 / a->eta, n, PTI_ALBEDO_V, sum);
            a->total[1].e[row][i] = sum[1];
        }
        pti_albedo_finish(&a->reflected, row);
        pti_albedo_finish(&a->total[0], row);
        pti_albedo_finish(&a->total[1], row);
    }
    if (a->ax > 0) {
        pti_albedo_mean_around(&a->reflected);
        pti_albedo_mean_around(&a->total[0]);
        pti_albedo_mean_around(&a->total[1]);
    }
    a->fresnel_mean = a->eta > 0 ? pti_fresnel_mean(a->eta) : 1.0f;
}
/* row: where between the table's rows, 0 to PTI_ALBEDO - 1. */
static float pti_albedo_at(const pti_albedo_table *t, float mu, float row) {
    float x = sqrtf(pti_clamp(mu, 0, 1)) * (PTI_ALBEDO - 1), fx, fy;
    int i = (int)x, j = (int)row;
    if (i > PTI_ALBEDO - 2) i = PTI_ALBEDO - 2;
    if (j > PTI_ALBEDO - 2) j = PTI_ALBEDO - 2;
    fx = x - (float)i; fy = row - (float)j;
    return (t->e[j][i] * (1 - fx) + t->e[j][i + 1] * fx) * (1 - fy)
         + (t->e[j + 1][i] * (1 - fx) + t->e[j + 1][i + 1] * fx) * fy;
}
static float pti_albedo_mean_at(const pti_albedo_table *t, float roughness) {       /* where rows are angles, all are one */
    float row = roughness * (PTI_ALBEDO - 1);
    int j = (int)row;
    if (j > PTI_ALBEDO - 2) j = PTI_ALBEDO - 2;
    return t->mean[j] + (t->mean[j + 1] - t->mean[j]) * (row - (float)j);
}
/* The row for w: that of a roughness, or of the angle around z. */
static float pti_albedo_row(const pti_albedo *a, float roughness, pt_vec3 w) {
    return (a->ax > 0 ? pti_atan2(fabsf(w.y), fabsf(w.x)) * (2 / PTI_PI) : roughness) * (PTI_ALBEDO - 1);
}
/* mu with about the density of lost light (from the nearest row), and that density per steradian: x = sqrt(mu) has
   dw = 2 pi dmu = 4 pi x dx. */
static float pti_sample_lost(const pti_albedo_table *t, float row, float u) {
    int cell;
    float x = pti_sample_table(t->lost[(int)(row + 0.5f)], PTI_ALBEDO - 1, u, &cell);
    return x * x;
}
static float pti_pdf_lost(const pti_albedo_table *t, float row, float mu) {
    float x = sqrtf(pti_clamp(mu, 1e-12f, 1));
    int cell = (int)(x * (PTI_ALBEDO - 1));
    if (cell > PTI_ALBEDO - 2) cell = PTI_ALBEDO - 2;
    return pti_pdf_table(t->lost[(int)(row + 0.5f)], PTI_ALBEDO - 1, cell) / (4 * PTI_PI * x);
}

/* ---- >>measured ----------------------------------------------------------------------------------------
   BRDFs as tables over half and difference angles (Rusinkiewicz 1998; Matusik et al. 2003). With s = wo + wi, d = wi - wo,
       tan theta_h = |(sx, sy)| / sz,    tan theta_d = |d| / |s|,    tan phi_d = (sx dy - sy dx) / (-dz |s|):
   the last since x about h is (hz hx / r, hz hy / r, -r), y is (-hy, hx, 0) / r with r = |(hx, hy)|, and d is perpendicular
   to h. Exchanging wo and wi turns d round, which phi_d, known up to 180 degrees, does not see: reciprocity is exact. Cells go
   by sqrt(theta_h), as highlights want it. The database's own reader takes the nearest cell; we go linearly between the
   middles of the eight around, lest highlights look like stairs and normal maps sparkle.

   A direction is drawn by its half vector, like a mirror's, from a density fitted to the table: for each of 32 ranges of
   theta_o, bins over h hold the luminance that goes that way,
       P(bin) ~ the integral of f cos(wi) dw_i = f cos(wi) 4 (wo.h) dw_h,    p(wi) = P / (solid angle of the bin) / (4 wo.h),
   and one of ten is drawn like a diffuse surface's, so that f cos / p never exceeds 10 pi f, wherever bins are too coarse
   to know. */
#define PTI_MEASURED_ROWS 32
#define PTI_MEASURED_AROUND 32                           /* bins of h's azimuth, dense towards wo's: there light comes back */
#define PTI_MEASURED_BINS 90                             /* of theta_h, at least; where the table has more cells, as many */
#define PTI_MEASURED_DIFFUSE 0.1f
#define PTI_MEASURED_CELLS 512                           /* at most, an axis */
#define PTI_MEASURED_BELOW 0.05f                         /* so far below the horizon wi may be, for a bin to hold something */
#define PTI_MEASURED_LEAST 0.02f                         /* and what cos(wi) counts there */

typedef struct pti_measured_row {                        /* what is known for a range of theta_o */
    const struct pti_measured *of;
    pti_table2 density;                                  /* x: azimuth; y: sqrt(theta_h) */
    pt_vec3 albedo;
} pti_measured_row;
typedef struct pti_measured {
    int cells_h, cells_d, cells_p, bins;
    float *values, *edges, *tables;                      /* edges: 1 - cos theta_h between bins; tables: all rows' densities */
    pti_measured_row rows[PTI_MEASURED_ROWS];
} pti_measured;

static size_t pti_measured_values(const pti_measured *m) {
    return 3 * (size_t)m->cells_h * (size_t)m->cells_d * (size_t)m->cells_p;
}
static size_t pti_measured_table(const pti_measured *m) {              /* floats of one row's density */
    return (size_t)m->bins * (PTI_MEASURED_AROUND + 2) + 1;
}

/* The angles, from 0 to 1: of sqrt(theta_h), of theta_d and of phi_d; s itself, and cos theta_d. */
typedef struct pti_half { pt_vec3 s; float h, d, p, cosine; } pti_half;
static pti_half pti_half_of(pt_vec3 wo, pt_vec3 wi) {
    pti_half a;
    pt_vec3 d = pti_sub(wi, wo);
    float length, y, x;
    a.s = pti_add(wo, wi);
    length = pti_length(a.s);
    y = a.s.x * d.y - a.s.y * d.x;
    x = -d.z * length;
    if (y < 0 || (y == 0 && x < 0)) { y = -y; x = -x; }
    a.h = sqrtf(pti_atan2(sqrtf(a.s.x * a.s.x + a.s.y * a.s.y), a.s.z) * (2 / PTI_PI));
    a.d = pti_atan2(pti_length(d), length) * (2 / PTI_PI);
    a.p = pti_atan2(y, x) * (1 / PTI_PI);
    a.cosine = 0.5f * length;
    return a;
}
/* The two cells about x, and how far it is from the middle of the first. */
static float pti_measured_between(float x, int cells, int *first, int *second) {
    x = pti_clamp(x * (float)cells - 0.5f, 0, (float)(cells - 1));
    *first = (int)x;
    *second = *first + 1 < cells ? *first + 1 : *first;
    return x - (float)*first;
}
static float pti_measured_around(float x, int cells, int *first, int *second) {        /* the last one's next is the first */
    x = x * (float)cells - 0.5f;
    if (x < 0) x += (float)cells;
    *first = (int)x < cells ? (int)x : cells - 1;
    *second = *first + 1 < cells ? *first + 1 : 0;
    return pti_min(x - (float)*first, 1);
}
static pt_vec3 pti_measured_at(const pti_measured *m, const pti_half *a) {
    pt_vec3 sum = pt_v3(0, 0, 0);
    int h[2], d[2], p[2], i;
    float fh = pti_measured_between(a->h, m->cells_h, &h[0], &h[1]), fd = pti_measured_between(a->d, m->cells_d, &d[0], &d[1]);
    float fp = pti_measured_around(a->p, m->cells_p, &p[0], &p[1]);
    for (i = 0; i < 4; i++) {
        const float *row = m->values + 3 * ((size_t)h[i >> 1] * (size_t)m->cells_d + (size_t)d[i & 1]) * (size_t)m->cells_p;
        const float *v = row + 3 * p[0], *w = row + 3 * p[1];
        float share = (i >> 1 ? fh : 1 - fh) * (i & 1 ? fd : 1 - fd), next = share * fp;
        share -= next;
        sum = pti_add(sum, pt_v3(v[0] * share + w[0] * next, v[1] * share + w[1] * next, v[2] * share + w[2] * next));
    }
    return sum;
}

/* Bins: of azimuth, by the square of the distance from the middle, which is wo's; of theta_h, as cells are. */
typedef struct pti_measured_bin { float phi, phi_width, c, c_width; } pti_measured_bin;        /* c = 1 - cos theta_h */
static float pti_measured_azimuth(int i) {               /* where bin i begins */
    float x = (float)i * (2.0f / PTI_MEASURED_AROUND) - 1;
    return PTI_PI * x * fabsf(x);
}
static pti_measured_bin pti_measured_bin_at(const pti_measured *m, int around, int h) {
    pti_measured_bin b;
    b.phi = pti_measured_azimuth(around);
    b.phi_width = pti_measured_azimuth(around + 1) - b.phi;
    b.c = m->edges[h];
    b.c_width = m->edges[h + 1] - b.c;
    return b;
}
static float pti_measured_solid_angle(const pti_measured_bin *b) { return b->phi_width * b->c_width; }
static pt_vec3 pti_measured_h(const pti_measured_bin *b, float x, float y) {           /* uniform, x and y from 0 to 1 */
    float c = b->c + y * b->c_width, r = pti_safe_sqrt(c * (2 - c)), sine, cosine;
    pti_sincos(b->phi + x * b->phi_width, &sine, &cosine);
    return pt_v3(r * cosine, r * sine, 1 - c);
}
static pt_vec3 pti_measured_mirrored(pt_vec3 wo, pt_vec3 h) { return pti_sub(pti_scale(h, 2 * pti_dot(h, wo)), wo); }

/* The integral of f cos(wi) dw_i over a bin, averaged over a row's theta_o, by a few points; *luminance is the same, but
   for grazing wi, and some below the horizon: those count as if higher, lest a bin be missed that reaches above it. */
static pt_vec3 pti_measured_flux(const pti_measured *m, int row, int around, int h, float *luminance) {
    static const float at[4][2] = { { 0.125f, 0.375f }, { 0.625f, 0.125f }, { 0.375f, 0.875f }, { 0.875f, 0.625f } };
    pti_measured_bin bin = pti_measured_bin_at(m, around, h);
    float area = pti_measured_solid_angle(&bin);
    pt_vec3 sum = pt_v3(0, 0, 0), wo = sum, n, wi, f;
    int k;
    *luminance = 0;
    for (k = 0; k < 4; k++) {
        pti_half a;
        pti_sincos(((float)row + ((float)k + 0.5f) / 4) * (PTI_PI / 2 / PTI_MEASURED_ROWS), &wo.x, &wo.z);
        n = pti_measured_h(&bin, at[k][0], at[k][1]);
        wi = pti_measured_mirrored(wo, n);
        if (!(wi.z > -PTI_MEASURED_BELOW) || !(pti_dot(wo, n) > 0)) continue;
        a = pti_half_of(wo, wi);
        f = pti_scale(pti_measured_at(m, &a), pti_dot(wo, n) * area);
        sum = pti_madd(f, pti_max(wi.z, 0), sum);
        *luminance += pti_luminance(f) * pti_max(wi.z, PTI_MEASURED_LEAST);
    }
    return sum;
}
static void pti_measured_fit_row(pti_measured *m, int row) {
    pti_measured_row *r = m->rows + row;
    float value[PTI_MEASURED_AROUND], sum[PTI_MEASURED_CELLS];     /* bins are no more */
    int h, i;
    r->density.width = PTI_MEASURED_AROUND;
    r->density.height = m->bins;
    r->density.rows = m->tables + (size_t)row * pti_measured_table(m);
    r->density.cells = r->density.rows + m->bins + 1;
    for (h = 0; h < m->bins; h++) {
        sum[h] = 0;
        for (i = 0; i < PTI_MEASURED_AROUND; i++) {
            r->albedo = pti_add(r->albedo, pti_measured_flux(m, row, i, h, &value[i]));
            sum[h] += value[i];
        }
        pti_table_build(r->density.cells + (size_t)h * (PTI_MEASURED_AROUND + 1), value, PTI_MEASURED_AROUND);
    }
    pti_table_build(r->density.rows, sum, m->bins);
}
static void pti_measured_fit(pti_measured *m) {
    int i;
    for (i = 0; i <= m->bins; i++) {
        float x = (float)i / (float)m->bins, s, c;
        pti_sincos(x * x * (PTI_PI / 4), &s, &c);
        m->edges[i] = 2 * s * s;                         /* 1 - cos, without its cancellation */
    }
    for (i = 0; i < PTI_MEASURED_ROWS; i++) pti_measured_fit_row(m, i);
}

/* The row for wo. In what follows, wo is in the x z plane, x >= 0. */
static const pti_measured_row *pti_measured_row_of(const pti_measured *m, float cosine) {
    int row = (int)(pti_acos(cosine) * (2 * PTI_MEASURED_ROWS / PTI_PI));
    return m->rows + (row < PTI_MEASURED_ROWS ? row : PTI_MEASURED_ROWS - 1);
}
static pt_vec3 pti_sample_measured(const pti_measured_row *r, pt_vec3 wo, float u, float v) {
    pti_measured_bin bin;
    float x, y;
    pti_sample_table2(&r->density, u, v, &x, &y);
    x *= PTI_MEASURED_AROUND;
    y *= (float)r->of->bins;
    bin = pti_measured_bin_at(r->of, (int)x, (int)y);
    return pti_measured_mirrored(wo, pti_measured_h(&bin, x - floorf(x), y - floorf(y)));
}
static float pti_pdf_measured(const pti_measured_row *r, const pti_half *a) {
    float phi = pti_atan2(a->s.y, a->s.x), x = sqrtf(fabsf(phi) * (1 / PTI_PI));
    int around = (int)((phi < 0 ? 1 - x : 1 + x) * (0.5f * PTI_MEASURED_AROUND)), h = (int)(a->h * (float)r->of->bins);
    pti_measured_bin bin;
    if (around > PTI_MEASURED_AROUND - 1) around = PTI_MEASURED_AROUND - 1;
    if (h > r->of->bins - 1) h = r->of->bins - 1;
    bin = pti_measured_bin_at(r->of, around, h);
    return (r->density.rows[h + 1] - r->density.rows[h]) * pti_pdf_table(pti_table2_row(&r->density, h), 1, around)
         / (pti_measured_solid_angle(&bin) * 4 * a->cosine);
}

/* ---- >>bsdf --------------------------------------------------------------------------------------------
   How surfaces scatter. What a material yields at a vertex is a list of lobes, and its BSDF is their sum:
       f = sum_i f_i,    p = sum_i share_i p_i.
   Lobes are smooth (eval tells f and p for any wi) or deltas (mirrors, panes: one direction each, and a probability instead
   of a density). Each has a frame of its own whose z is the normal on wo's side, since materials that are mixed may have
   different normal maps. Colours of lobes already hold the shares of what lies above them. */

typedef enum pti_lobe_kind {
    PTI_LAMBERT, PTI_DIFFUSE, PTI_THROUGH, PTI_FUZZ, PTI_METAL, PTI_COAT, PTI_THIN, PTI_GLASS, PTI_MEASURED, PTI_USER_LOBE,
    PTI_PARTICLE,                                        /* of a medium: all its phase function */
    PTI_PASS, PTI_MIRROR, PTI_GLOSS, PTI_THIN_PANE, PTI_PANE         /* deltas, from here on */
} pti_lobe_kind;

typedef struct pti_lobe {
    pti_lobe_kind kind;
    float share;                                         /* how often it is drawn: about the luminance that it sends on */
    pt_vec3 color, through;                              /* factors of what is reflected and of what goes through */
    pt_vec3 t, b, n, wo;                                 /* the frame, and wo in it */
    float ax, ay, eta;                                   /* eta: index behind over index before */
    int inside;                                          /* wo is where the normal does not point */
    pt_vec3 r0, k;                                       /* metal: r0 or, if indexed, eta + i k; EON: r0 its albedo */
    int indexed;
    pt_vec3 more;                                        /* metal: colour of what comes back after more than one bounce */
    const pti_albedo *albedo;                            /* NULL for smooth lobes */
    float table_roughness, e, e_mean;                    /* where in it; E(wo); the mean of E, or under a layer of 1 - E */
    float fresnel_mean;                                  /* of one smooth face: PTI_THIN, and smooth gloss on PTI_DIFFUSE */
    float cover, rough;                                  /* PTI_DIFFUSE: how much of albedo lies on it; EON's roughness */
    const pti_measured_row *measured;                    /* PTI_MEASURED; t is in the plane of n and wo */
    const pt_bsdf_vtable *vtable;                        /* PTI_USER_LOBE */
    const pti_phase *phase;                              /* PTI_PARTICLE */
    void *user;
} pti_lobe;

#define PTI_LOBES 16
typedef struct pti_surface {
    const pt_vertex *x;
    int count;
    float delta;                                         /* the deltas' part of the shares */
    float squeeze;                                       /* eta^2 of rough glass: what its 1 / eta^2 takes going through */
    pti_lobe lobes[PTI_LOBES];
} pti_surface;

static pt_vec3 pti_to_local(const pti_lobe *l, pt_vec3 w) {
    return pt_v3(pti_dot(l->t, w), pti_dot(l->b, w), pti_dot(l->n, w));
}
static int pti_same_side(const pt_vertex *x, pt_vec3 a, pt_vec3 b) { return pti_dot(x->ng, a) * pti_dot(x->ng, b) > 0; }

/* The colour of what a surface of reflectance F per bounce sends on after more than one, if mean is how much gets out at each:
   F^2 mean + F^3 (1 - mean) mean + ... */
static float pti_more_bounces(float F, float mean) { return F * F * mean / (1 - F * (1 - mean)); }

/* Diffuse: Lambert's f = albedo / pi, or EON (Portsmouth, Kutz and Hill 2025), Oren and Nayar's rough diffuse surface in
   Fujii's form, with the light that its first bounce loses given back as Kulla and Conty do. E has a closed form. */
static float pti_eon_albedo(float mu, float rough) {
    float s = pti_safe_sqrt(1 - mu * mu), a = 1 / (1 + (0.5f - 2 / (3 * PTI_PI)) * rough);
    float g = s * (pti_acos(mu) - s * mu) + 2.0f / 3 * (s / pti_max(mu, 1e-6f) * (1 - s * s * s) - s);
    return a + rough * a / PTI_PI * g;
}
static pt_vec3 pti_eon(pt_vec3 albedo, float rough, pt_vec3 wo, pt_vec3 wi) {
    float s = wo.x * wi.x + wo.y * wi.y, a = 1 / (1 + (0.5f - 2 / (3 * PTI_PI)) * rough), mean, ms, single;
    mean = a * (1 + (2.0f / 3 - 28 / (15 * PTI_PI)) * rough);
    single = a * (1 + rough * (s > 0 ? s / pti_max(wo.z, wi.z) : s)) / PTI_PI;
    ms = (1 - pti_eon_albedo(wo.z, rough)) * (1 - pti_eon_albedo(wi.z, rough)) / (PTI_PI * pti_max(1 - mean, 1e-7f));
    return pti_madd(albedo, single, pti_scale(pt_v3(pti_more_bounces(albedo.x, mean), pti_more_bounces(albedo.y, mean),
                                                    pti_more_bounces(albedo.z, mean)), ms));
}
/* Under a layer that reflects E, light goes in and out again: (1 - E(wo)) (1 - E(wi)) / mean(1 - E), which keeps a white
   surface white, and is the same both ways. */
static float pti_diffuse_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    float p = pti_pdf_cosine(wi.z), under, cos_t;
    if (!(p > 0)) return 0;
    *f = l->rough > 0 ? pti_mul(l->color, pti_scale(pti_eon(l->r0, l->rough, l->wo, wi), wi.z)) : pti_scale(l->color, p);
    if (l->albedo) {
        under = l->fresnel_mean > 0 ? pti_fresnel(pti_min(wi.z, 1), l->eta, &cos_t)
                                    : pti_albedo_at(&l->albedo->reflected, wi.z,
                                                    pti_albedo_row(l->albedo, l->table_roughness, wi));
        under = 1 - l->cover * under;
        *f = pti_scale(*f, under / l->e_mean);           /* 1 - E(wo) is in the colour */
    }
    return p;
}

/* The rough lobes. What one bounce loses comes back as (1 - E(wo)) (1 - E(wi)) / (pi (1 - mean E)), drawn like a diffuse
   lobe with probability 1 - E(wo), more often where E(wi) is small. Colour is lost at each of the further bounces, with F the
   mean of Fresnel's over the hemisphere. */
/* (1 - E(wi)) cos / (pi (1 - mean E)), and a density like it: smooth surfaces lose light at grazing angles only. */
static float pti_lost_eval(const pti_lobe *l, const pti_albedo_table *t, float mean, pt_vec3 wi, float *p) {
    float row = pti_albedo_row(l->albedo, l->table_roughness, wi), mu = fabsf(wi.z);
    *p = pti_pdf_lost(t, row, mu);
    return (1 - pti_albedo_at(t, mu, row)) * mu / (PTI_PI * pti_max(1 - mean, 1e-6f));
}
static pt_vec3 pti_lost_sample(const pti_lobe *l, const pti_albedo_table *t, float u, float v) {
    pt_vec3 wi;
    float mu, r;
    pti_sincos(2 * PTI_PI * u, &wi.y, &wi.x);
    wi.z = 0;
    mu = pti_sample_lost(t, pti_albedo_row(l->albedo, l->table_roughness, wi), v);
    r = sqrtf(1 - mu * mu);
    return pt_v3(wi.x * r, wi.y * r, mu);
}
static pt_vec3 pti_lobe_fresnel(const pti_lobe *l, float cos_i) {
    float cos_t, F;
    if (l->kind == PTI_METAL || l->kind == PTI_MIRROR) {
        if (!l->indexed) return pti_fresnel_schlick(cos_i, l->r0);
        return pt_v3(pti_fresnel_metal(cos_i, l->r0.x, l->k.x), pti_fresnel_metal(cos_i, l->r0.y, l->k.y),
                     pti_fresnel_metal(cos_i, l->r0.z, l->k.z));
    }
    F = pti_fresnel(cos_i, l->eta, &cos_t);
    return pt_v3(F, F, F);
}
/* One bounce towards wi, wi.z > 0, without Fresnel: f cos and p. */
static float pti_bounce(const pti_lobe *l, pt_vec3 wi, pt_vec3 *m, float *f) {
    float d, lambda = 1 + pti_ggx_lambda(l->wo, l->ax, l->ay);
    *m = pti_normalize(pti_add(l->wo, wi));
    d = pti_ggx_d(*m, l->ax, l->ay) / (4 * l->wo.z);
    *f = d / (lambda + pti_ggx_lambda(wi, l->ax, l->ay));
    return d / lambda;
}
static pt_vec3 pti_metal_mean(const pti_lobe *l) {       /* of Fresnel's; Schlick's is (20 r0 + 1) / 21 */
    pt_vec3 sum = pt_v3(0, 0, 0);
    int i;
    if (!l->indexed) return pti_scale(pti_madd(l->r0, 20, pt_v3(1, 1, 1)), 1.0f / 21);
    for (i = 0; i < 4; i++) {
        float mu = sqrtf(((float)i + 0.5f) / 4);
        sum = pti_add(sum, pti_scale(pti_lobe_fresnel(l, mu), 0.25f));
    }
    return sum;
}
static float pti_metal_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    pt_vec3 m;
    float one, p, lost = 1 - l->e, ms, q;
    if (!(wi.z > 0)) return 0;
    p = pti_bounce(l, wi, &m, &one);
    *f = pti_mul(l->color, pti_scale(pti_lobe_fresnel(l, pti_min(pti_dot(l->wo, m), 1)), one));
    if (l->kind == PTI_COAT) return p;                   /* what it loses, the layers below have got */
    ms = lost * pti_lost_eval(l, &l->albedo->total[0], l->e_mean, wi, &q);
    *f = pti_madd(pti_mul(l->color, l->more), ms, *f);
    return p + lost * (q - p);
}
static void pti_metal_sample(const pti_lobe *l, float u, float v, uint32_t choice, pt_vec3 *wi) {
    if (l->kind == PTI_METAL && pti_split(&choice, 1 - l->e)) *wi = pti_lost_sample(l, &l->albedo->total[0], u, v);
    else {
        *wi = pti_mirrored(l->wo, pti_sample_ggx(l->wo, l->ax, l->ay, u, v));
        wi->z = pti_max(wi->z, 0);                       /* below the surface: lost */
    }
}

/* A rough pane of glass without thickness: between its two faces light goes to and fro, so R = 2 F / (1 + F) comes back, and
   the rest leaves on the other side as if mirrored by the pane's own plane. */
static float pti_to_and_fro(float F) { return 2 * F / (1 + F); }
static float pti_pane_fresnel(float cos_i, float eta) {
    float cos_t;
    return pti_to_and_fro(pti_fresnel(cos_i, eta, &cos_t));
}
static float pti_thin_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    int back = wi.z > 0;
    pt_vec3 m, up = pt_v3(wi.x, wi.y, fabsf(wi.z));
    float one, p, q, lost = 1 - l->e, ms, F, mean;
    if (wi.z == 0) return 0;
    p = pti_bounce(l, up, &m, &one);
    F = pti_pane_fresnel(pti_min(pti_dot(l->wo, m), 1), l->eta);
    mean = pti_to_and_fro(l->fresnel_mean);
    if (!back) { F = 1 - F; mean = 1 - mean; }
    ms = lost * pti_lost_eval(l, &l->albedo->total[0], l->e_mean, up, &q);
    *f = pti_scale(back ? l->color : l->through, F * one + mean * ms);
    return (1 - lost) * F * p + lost * mean * q;
}
static void pti_thin_sample(const pti_lobe *l, float u, float v, uint32_t choice, pt_vec3 *wi) {
    float mean = pti_to_and_fro(l->fresnel_mean), F;
    if (pti_split(&choice, 1 - l->e)) { *wi = pti_lost_sample(l, &l->albedo->total[0], u, v); F = mean; }
    else {
        pt_vec3 m = pti_sample_ggx(l->wo, l->ax, l->ay, u, v);
        *wi = pti_mirrored(l->wo, m);
        F = pti_pane_fresnel(pti_min(pti_dot(l->wo, m), 1), l->eta);
        if (!(wi->z > 0)) { wi->z = 0; return; }         /* lost, on either side */
    }
    if (!pti_split(&choice, F)) wi->z = -wi->z;
}

/* Rough glass (Walter et al. 2007): through a pane whose normal is m ~ -(wo + eta wi),
       f cos = (1 - F) D G2 |wo.m| |wi.m| eta^2 / (wo.z (wo.m + eta wi.m)^2) / eta^2,
   the last because radiance is squeezed into a narrower cone inside (Veach 1997, 5.2), and let out again at the exit. Lost
   light comes back on both sides; of what is seen from outside the share
       t = x (1 - F(eta)) (1 - mean E inside),    x = 1 / max(1 - mean E outside, 1 - mean E inside)
   goes in, and the same with sides exchanged goes out, so that both ways are the same (Kulla and Conty 2017). */
static float pti_glass_share_through(const pti_lobe *l) {
    const pti_albedo *a = l->albedo;
    float out = pti_max(1 - pti_albedo_mean_at(&a->total[0], l->table_roughness), 1e-6f);
    float in = pti_max(1 - pti_albedo_mean_at(&a->total[1], l->table_roughness), 1e-6f);
    float F = 1 - a->fresnel_mean;
    return (l->inside ? F / (a->eta * a->eta) * out : F * in) / pti_max(out, in);    /* 1 - F(1/eta) = (1 - F(eta)) / eta^2 */
}
static float pti_glass_through_eval(const pti_lobe *l, pt_vec3 wi, float *f) {
    pt_vec3 m = pti_normalize(pti_madd(wi, l->eta, l->wo));
    float o, i, F, cos_t, q, d, lambda = 1 + pti_ggx_lambda(l->wo, l->ax, l->ay);
    if (m.z < 0) m = pti_neg(m);
    o = pti_dot(l->wo, m); i = pti_dot(wi, m);
    if (!(o > 0 && i < 0)) { *f = 0; return 0; }
    F = 1 - pti_fresnel(pti_min(o, 1), l->eta, &cos_t);
    q = l->eta / (o + l->eta * i);
    d = F * pti_ggx_d(m, l->ax, l->ay) * o * -i * q * q / l->wo.z;
    *f = d / (lambda + pti_ggx_lambda(wi, l->ax, l->ay));
    return d / lambda;
}
static float pti_glass_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    int back = wi.z > 0, there = back ? l->inside : !l->inside;
    const pti_albedo_table *table = &l->albedo->total[there];
    float one, p, q, lost = 1 - l->e, ms, part = pti_glass_share_through(l);
    if (wi.z == 0) return 0;
    if (back) {
        pt_vec3 m;
        float cos_t, F;
        p = pti_bounce(l, wi, &m, &one);
        F = pti_fresnel(pti_min(pti_dot(l->wo, m), 1), l->eta, &cos_t);
        p *= F; one *= F;
        part = 1 - part;
    } else p = pti_glass_through_eval(l, wi, &one);
    ms = lost * pti_lost_eval(l, table, pti_albedo_mean_at(table, l->table_roughness), wi, &q);
    *f = pti_scale(back ? l->color : l->through, (one + part * ms) * (back ? 1 : 1 / (l->eta * l->eta)));
    return (1 - lost) * p + lost * part * q;
}
static void pti_glass_sample(const pti_lobe *l, float u, float v, uint32_t choice, pt_vec3 *wi) {
    pt_vec3 m;
    float F, cos_t;
    if (pti_split(&choice, 1 - l->e)) {
        int through = pti_split(&choice, pti_glass_share_through(l));
        *wi = pti_lost_sample(l, &l->albedo->total[through ? !l->inside : l->inside], u, v);
        if (through) wi->z = -wi->z;
        return;
    }
    m = pti_sample_ggx(l->wo, l->ax, l->ay, u, v);
    F = pti_fresnel(pti_min(pti_dot(l->wo, m), 1), l->eta, &cos_t);
    if (pti_split(&choice, F)) {
        *wi = pti_mirrored(l->wo, m);
        wi->z = pti_max(wi->z, 0);
    } else {
        *wi = pti_refracted(l->wo, m, l->eta, cos_t);
        wi->z = pti_min(wi->z, 0);
    }
}

static float pti_measured_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    pti_half a;
    if (!(wi.z > 0)) return 0;
    a = pti_half_of(l->wo, wi);
    *f = pti_mul(l->color, pti_scale(pti_measured_at(l->measured->of, &a), wi.z));
    return PTI_MEASURED_DIFFUSE * pti_pdf_cosine(wi.z) + (1 - PTI_MEASURED_DIFFUSE) * pti_pdf_measured(l->measured, &a);
}
static void pti_measured_sample(const pti_lobe *l, float u, float v, uint32_t choice, pt_vec3 *wi) {
    *wi = pti_split(&choice, PTI_MEASURED_DIFFUSE) ? pti_sample_cosine(u, v) : pti_sample_measured(l->measured, l->wo, u, v);
    wi->z = pti_max(wi->z, 0);                           /* below the surface: lost */
}

static float pti_fuzz_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    if (!(wi.z > 0)) return 0;
    *f = pti_scale(l->color, pti_sheen(l->wo, wi, l->ax));
    return pti_pdf_hemisphere(wi.z);
}
static float pti_through_eval(const pti_lobe *l, pt_vec3 wi, pt_vec3 *f) {
    float p = pti_pdf_cosine(-wi.z);
    *f = pti_scale(l->through, p);
    return p;
}

/* f cos and p of one lobe, towards a wi of the world. */
static float pti_lobe_eval(const pti_lobe *l, const pt_vertex *x, int same_side, pt_vec3 wi, pt_vec3 *f) {
    if (l->kind == PTI_LAMBERT) {                        /* needs no frame */
        float p = same_side ? pti_pdf_cosine(pti_dot(l->n, wi)) : 0.0f;
        *f = pti_scale(l->color, p);
        return p;
    }
    *f = pt_v3(0, 0, 0);
    if (l->kind == PTI_USER_LOBE) {
        *f = pti_mul(l->color, l->vtable->eval(l->user, x, wi));
        return pti_density_of(l->vtable->pdf(l->user, x, wi));
    }
    if (l->kind == PTI_PARTICLE) {
        float p = pti_phase_pdf(l->phase, x, wi);
        *f = pt_v3(p, p, p);
        return p;
    }
    if (l->kind >= PTI_PASS) return 0;
    wi = pti_to_local(l, wi);
    if (same_side ? !(wi.z > 0) : !(wi.z < 0)) return 0;         /* the shading normal disagrees with the surface */
    switch (l->kind) {
    case PTI_DIFFUSE: return same_side ? pti_diffuse_eval(l, wi, f) : 0.0f;
    case PTI_THROUGH: return same_side ? 0.0f : pti_through_eval(l, wi, f);
    case PTI_FUZZ:    return pti_fuzz_eval(l, wi, f);
    case PTI_THIN:    return pti_thin_eval(l, wi, f);
    case PTI_GLASS:   return pti_glass_eval(l, wi, f);
    case PTI_MEASURED: return pti_measured_eval(l, wi, f);
    default:          return pti_metal_eval(l, wi, f);
    }
}

/* The delta lobes: out->f is the lobe's whole weight, out->pdf the probability that it was chosen. Where the shading normal
   would bend the ray to the wrong side of the surface, the surface's own is taken. */
static int pti_mirror_sample(const pti_lobe *l, const pt_vertex *x, pt_vec3 n, pt_scatter *out) {
    out->wi = pti_mirrored(x->wo, n);
    out->f = pti_mul(l->color, pti_lobe_fresnel(l, pti_min(pti_dot(n, x->wo), 1)));
    out->pdf = 1;
    return pti_same_side(x, x->wo, out->wi);
}
static int pti_pane_sample(const pti_lobe *l, const pt_vertex *x, pt_vec3 n, uint32_t u, pt_scatter *out) {
    float cos_i = pti_min(pti_dot(n, x->wo), 1), cos_t, F = pti_fresnel(cos_i, l->eta, &cos_t), eta2 = l->eta * l->eta;
    if (l->kind == PTI_THIN_PANE) { F = pti_to_and_fro(F); eta2 = 1; }
    if (pti_split(&u, F)) {
        out->wi = pti_mirrored(x->wo, n);
        out->f = pti_scale(l->color, F);
        out->pdf = F;
        return pti_same_side(x, x->wo, out->wi);
    }
    out->wi = l->kind == PTI_THIN_PANE ? pti_neg(x->wo) : pti_refracted(x->wo, n, l->eta, cos_t);
    out->f = pti_scale(l->through, (1 - F) / eta2);
    out->pdf = 1 - F;
    return !pti_same_side(x, x->wo, out->wi);
}
static int pti_delta_sample(const pti_lobe *l, const pt_vertex *x, uint32_t u, pt_scatter *out) {
    pt_vec3 ng = pti_dot(x->ng, x->wo) < 0 ? pti_neg(x->ng) : x->ng;
    out->delta = 1;
    switch (l->kind) {
    case PTI_PASS:
        out->wi = pti_neg(x->wo);
        out->f = l->through;
        out->pdf = 1;
        return 1;
    case PTI_MIRROR: case PTI_GLOSS:
        return pti_mirror_sample(l, x, l->n, out) || pti_mirror_sample(l, x, ng, out);
    default:
        return pti_pane_sample(l, x, l->n, u, out) || pti_pane_sample(l, x, ng, u, out);
    }
}
/* u and v become a direction; choice decides what else there is to decide. 0: the light is lost. */
static int pti_lobe_sample(const pti_lobe *l, const pt_vertex *x, uint32_t u, uint32_t v, uint32_t choice, pt_scatter *out) {
    float uv[3], a = pti_u01(u), b = pti_u01(v);
    pt_vec3 wi, t, bt;
    if (l->kind >= PTI_PASS) return pti_delta_sample(l, x, u, out);
    switch (l->kind) {
    case PTI_USER_LOBE:
        uv[0] = a; uv[1] = b; uv[2] = pti_u01(choice);
        if (!l->vtable->sample(l->user, x, uv, out)) return 0;
        out->f = pti_mul(l->color, out->f);
        return 1;
    case PTI_PARTICLE: return pti_phase_sample(l->phase, x, u, v, &out->wi);
    case PTI_LAMBERT:                                    /* has no frame yet */
        pti_basis(l->n, &t, &bt);
        out->wi = pti_to_world(t, bt, l->n, pti_sample_cosine(a, b));
        return pti_same_side(x, x->wo, out->wi);
    case PTI_DIFFUSE: wi = pti_sample_cosine(a, b); break;
    case PTI_THROUGH: wi = pti_sample_cosine(a, b); wi.z = -wi.z; break;
    case PTI_FUZZ:    wi = pti_sample_hemisphere(a, b); break;
    case PTI_THIN:    pti_thin_sample(l, a, b, choice, &wi); break;
    case PTI_GLASS:   pti_glass_sample(l, a, b, choice, &wi); break;
    case PTI_MEASURED: pti_measured_sample(l, a, b, choice, &wi); break;
    default:          pti_metal_sample(l, a, b, choice, &wi);
    }
    out->wi = pti_to_world(l->t, l->b, l->n, wi);
    return wi.z != 0 && pti_same_side(x, x->wo, out->wi) == (wi.z > 0);
}

/* The whole surface: p is returned, f cos added up. */
static float pti_surface_eval(const pti_surface *s, pt_vec3 wi, pt_vec3 *f) {
    int same_side = pti_same_side(s->x, s->x->wo, wi), i;
    float p = 0;
    pt_vec3 one;
    if (s->count == 1) return pti_lobe_eval(s->lobes, s->x, same_side, wi, f);
    *f = pt_v3(0, 0, 0);
    for (i = 0; i < s->count; i++) {
        p += s->lobes[i].share * pti_lobe_eval(s->lobes + i, s->x, same_side, wi, &one);
        *f = pti_add(*f, one);
    }
    return p;
}
static int pti_surface_sample(const pti_surface *s, uint32_t u, uint32_t v, uint32_t choice, pt_scatter *out) {
    float left = 1;
    int i;
    for (i = 0; i + 1 < s->count && !pti_split(&u, s->lobes[i].share / left); i++) left -= s->lobes[i].share;
    if (i >= s->count || !pti_lobe_sample(s->lobes + i, s->x, u, v, choice, out)) return 0;
    out->pdf *= s->lobes[i].share;
    return 1;
}

/* ---- >>material ----------------------------------------------------------------------------------------
   A material is a shader: its numbers, times their textures, then as the user's callback changes them, become lobes. Layers
   are worked off from the outside, and each leaves to the next what it does not reflect: fuzz, coat, then metal or not, then
   glass or not, then the gloss over the diffuse ground. A path draws one of the lobes, so it decides in turn whether it
   passes (opacity), whether it meets metal, whether it is reflected at the surface or goes below: a roulette over
   transparency, then metalness, then roughness, each with the material's own odds. */

#define PTI_NUMBERS(X) X(roughness) X(roughness_y) X(metallic) X(transmission) X(specular) X(coat) X(coat_roughness) \
                       X(sheen) X(translucency) X(mix)
#define PTI_TEXTURES(X) PTI_NUMBERS(X) X(color) X(rotation) X(sheen_color) X(emission) X(opacity) X(normal) X(bump)

/* Which way a material emits: all of it within the inner cone about the axis, none beyond the outer one, smoothstep between
   them. Cones by 1 - cos; outer 0 = every way alike. */
typedef struct pti_profile { pt_vec3 axis; float inner, outer; } pti_profile;
static float pti_profile_at(const pti_profile *p, pt_vec3 w) {
    pt_vec3 d = pti_sub(w, p->axis);                     /* |d|^2 = 2 (1 - cos) */
    float k = pti_clamp((p->outer - 0.5f * pti_dot(d, d)) / (p->outer - p->inner), 0, 1);
    return k * k * (3 - 2 * k);
}

typedef struct pti_material {
    pt_material_desc desc;
    pt_bsdf_vtable vtable;                               /* PT_BSDF_USER */
    const struct pti_material *all;                      /* the scene's, set at commit like all that follow */
    const pti_texture *textures;
    const pti_albedo *mirror, *dielectric, *coat, *fuzz; /* NULL where nothing asks them */
    const pti_measured *measured;
    float fresnel_mean;                                  /* of a smooth face of index ior */
    int emits, two_sided;                                /* of a mix: if one of its parts does, or is */
    int glows;                                           /* emits one colour, and does nothing else that matters there */
    pti_profile profile;                                 /* of the emission */
    int varies;                                          /* has textures, or a callback */
    int plain;                                           /* Lambert's and nothing else */
    int wants_coordinates;                               /* somebody may look at u, v and tangent */
    int disperses;
    int wants_choice;                                    /* some lobe decides with a third number */
    const pti_phase *phase;                              /* a particle's; NULL of a surface */
    int lobes;                                           /* at most */
} pti_material;

static const pti_texture *pti_material_texture(const pti_material *m, pt_texture t) { return m->textures + (t.id - 1); }
static float pti_unit(float x) { return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f; }           /* NaN: 0 */
static pt_vec3 pti_unit3(pt_vec3 c) { return pt_v3(pti_unit(c.x), pti_unit(c.y), pti_unit(c.z)); }

static float pti_vary(const pti_material *m, const pt_vertex *x, float number, pt_texture t) {
    float grey;
    if (!t.id) return number;
    grey = pti_texture_grey(pti_material_texture(m, t), x);
    return number != 0 ? number * grey : grey;
}
static pt_vec3 pti_vary3(const pti_material *m, const pt_vertex *x, pt_vec3 color, pt_texture t) {
    pt_vec3 c;
    if (!t.id) return color;
    c = pti_texture_eval(pti_material_texture(m, t), x);
    return pti_is_zero3(color) ? c : pti_mul(color, c);
}
static float pti_material_opacity(const pti_material *m, const pt_vertex *x) {          /* of the texture alone */
    const pti_texture *t = m->desc.opacity_texture.id ? pti_material_texture(m, m->desc.opacity_texture) : NULL;
    return !t ? 1.0f : t->pixels && t->channels % 2 == 0 && !t->picked ? pti_texture_alpha(t, x) : pti_texture_grey(t, x);
}
static void pti_material_vary(const pti_material *m, const pt_vertex *x, pt_material_desc *d) {
    *d = m->desc;
#define PTI_VARY(name) d->name = pti_vary(m, x, d->name, d->name##_texture);
    PTI_NUMBERS(PTI_VARY)
#undef PTI_VARY
    if (d->rotation_texture.id) d->rotation_deg += 360 * pti_texture_grey(pti_material_texture(m, d->rotation_texture), x);
    d->color = pti_vary3(m, x, d->color, d->color_texture);
    d->sheen_color = pti_vary3(m, x, d->sheen_color, d->sheen_color_texture);
    d->emission = pti_vary3(m, x, d->emission, d->emission_texture);
    d->transparency = 1 - (1 - d->transparency) * pti_material_opacity(m, x);
    if (d->shade) d->shade(d->user, x, d);
    d->transparency = pti_unit(d->transparency);
    d->sheen_roughness = pti_unit(d->sheen_roughness);
#define PTI_VARY(name) d->name = pti_unit(d->name);
    PTI_NUMBERS(PTI_VARY)
#undef PTI_VARY
    d->color = pti_unit3(d->color);
    d->sheen_color = pti_unit3(d->sheen_color);
}

/* Radiance towards wo. A mix emits what its parts do. */
static pt_vec3 pti_material_emission(const pti_material *m, const pt_vertex *x) {
    pt_vec3 e = pt_v3(0, 0, 0);
    const pt_material_desc *d = &m->desc;
    pt_material_desc varied;
    float passes;
    if (m->glows) return d->two_sided || pti_dot(x->ng, x->wo) > 0 ? d->emission : e;
    if (!m->emits) return e;
    if (m->varies) { pti_material_vary(m, x, &varied); d = &varied; }
    if (d->bsdf == PT_BSDF_MIX)
        e = pti_madd(pti_material_emission(m->all + d->a.id, x), 1 - d->mix,
                     pti_scale(pti_material_emission(m->all + d->b.id, x), d->mix));
    if (d->two_sided || pti_dot(x->ng, x->wo) > 0) e = pti_add(e, pti_max3(d->emission, pt_v3(0, 0, 0)));
    passes = m->profile.outer > 0 ? pti_profile_at(&m->profile, x->wo) : 1.0f;
    return pti_scale(e, (1 - d->transparency) * passes);
}

/* Normal maps hold normals in the tangent's frame. Bump maps hold heights: the surface p + h n has the tangents
   dp/du + dh/du n and dp/dv + dh/dv n (Blinn 1978). */
static pt_vec3 pti_bumped(const pti_material *m, const pt_vertex *x, pt_vec3 n) {
    const pti_texture *t = pti_material_texture(m, m->desc.bump_texture);
    float metres = m->desc.bump != 0 ? m->desc.bump : 0.01f, du, dv, h = pti_texture_grey(t, x), hu, hv;
    pt_vertex y = *x;
    pt_vec3 bent;
    pti_texture_texel(t, &du, &dv);
    if (t->solid) { du /= pti_max(pti_length(x->dpdu), 1e-30f); dv /= pti_max(pti_length(x->dpdv), 1e-30f); }
    y.u = x->u + du; y.p = pti_madd(x->dpdu, du, x->p);
    hu = metres * (pti_texture_grey(t, &y) - h) / du;
    y = *x;
    y.v = x->v + dv; y.p = pti_madd(x->dpdv, dv, x->p);
    hv = metres * (pti_texture_grey(t, &y) - h) / dv;
    bent = pti_cross(pti_madd(n, hu - pti_dot(n, x->dpdu), x->dpdu), pti_madd(n, hv - pti_dot(n, x->dpdv), x->dpdv));
    if (!(pti_dot(bent, bent) > 0)) return n;
    return pti_normalize(pti_dot(bent, n) < 0 ? pti_neg(bent) : bent);
}
static pt_vec3 pti_mapped(const pti_material *m, const pt_vertex *x, pt_vec3 n) {
    pt_vec3 c = pti_texture_eval(pti_material_texture(m, m->desc.normal_texture), x), b = pti_cross(n, x->tangent);
    c = pti_sub(pti_scale(c, 2), pt_v3(1, 1, 1));
    if (pti_dot(b, x->dpdv) < 0) b = pti_neg(b);         /* mirrored uvs */
    c = pti_to_world(x->tangent, b, n, c);
    return pti_dot(c, c) > 0 ? pti_normalize(c) : n;
}
/* The shading normal on wo's side. Where the mirror direction about it would be below the surface, where all is black, that
   is lifted just above the horizon, and the normal is half-way to there. A diffuse surface has no mirror direction. */
static pt_vec3 pti_shading_normal(const pti_material *m, const pt_vertex *x) {
    float side = pti_dot(x->ng, x->wo) < 0 ? -1.0f : 1.0f, c, least, height;
    pt_vec3 n = x->ns, up = pti_scale(x->ng, side), r;
    if (m->desc.normal_texture.id) n = pti_mapped(m, x, n);
    if (m->desc.bump_texture.id) n = pti_bumped(m, x, n);
    n = pti_scale(n, side);
    c = pti_dot(n, x->wo);
    if (c < 1e-3f) n = pti_normalize(pti_madd(x->wo, 1e-3f - c, n));         /* as pti_vertex_orient does */
    if (m->desc.bsdf == PT_BSDF_DIFFUSE) return n;
    r = pti_mirrored(x->wo, n);
    height = pti_dot(r, up);
    least = pti_min(0.01f, 0.9f * pti_dot(up, x->wo));
    if (height >= least) return n;
    r = pti_add(x->wo, pti_normalize(pti_madd(up, least - height, r)));
    return pti_dot(r, r) > 1e-10f ? pti_normalize(r) : up;         /* wo itself is at the horizon */
}

/* One material's work on a surface: where its lobes go, and what it knows for all of them. */
typedef struct pti_shading {
    pti_surface *surface;
    const pti_material *m;
    const pt_material_desc *d;
    pti_lobe frame;                                      /* what lobes have in common */
    pt_vec3 weight;                                      /* of what comes next, below the layers so far */
} pti_shading;

static pti_lobe *pti_add_lobe(pti_shading *s, pti_lobe_kind kind, pt_vec3 color, float share) {
    pti_lobe *l;
    if (!(share > 0) || s->surface->count == PTI_LOBES) return NULL;
    l = s->surface->lobes + s->surface->count++;
    *l = s->frame;
    l->kind = kind;
    l->color = l->through = color;
    l->share = share;
    return l;
}
/* The table of a rough lobe, and what it tells for wo. */
static void pti_lobe_rough(pti_lobe *l, const pti_albedo *a, float roughness) {
    int side = l->kind == PTI_GLASS && l->inside;
    float sum[2];
    l->albedo = a;
    l->table_roughness = roughness;
    l->e = pti_albedo_at(&a->total[side], l->wo.z, pti_albedo_row(a, roughness, l->wo));
    l->e_mean = pti_albedo_mean_at(&a->total[side], roughness);
    if (l->ax == l->ay || a->ax > 0) return;             /* else texture or callback made the roughness: no table has E */
    pti_albedo_integrate(l->wo, l->ax, l->ay, l->kind == PTI_GLASS ? l->eta : 0.0f, 24, 16, sum);
    l->e = sum[1];
}
static int pti_smooth(float roughness) { return roughness * roughness < PTI_LEAST_ALPHA; }
static float pti_roughest(const pt_material_desc *d) { return pti_max(d->roughness, d->roughness_y); }
/* The isotropic roughness that stands for one that differs along x and y, where no table knows that one: alpha^2 is the mean
   of both. Lost light then comes back in that one's shape; how much is known better, see pti_lobe_rough. */
static float pti_mean_roughness(float rx, float ry) {
    float x = rx * rx, y = ry * ry;
    return ry > 0 && ry != rx ? sqrtf(sqrtf((x * x + y * y) / 2)) : rx;
}

static void pti_shade_diffuse(pti_shading *s, float rough) {
    pt_vec3 color = pti_mul(s->weight, s->d->color);
    float through = s->d->translucency, share = pti_luminance(color);
    pti_lobe *l = pti_add_lobe(s, rough > 0 || s->frame.albedo ? PTI_DIFFUSE : PTI_LAMBERT,
                               pti_scale(rough > 0 ? s->weight : color, 1 - through), share * (1 - through));
    if (l) { l->rough = rough; l->r0 = s->d->color; }
    pti_add_lobe(s, PTI_THROUGH, pti_scale(color, through), share * through);
}
static void pti_shade_metal(pti_shading *s, pt_vec3 weight, pt_vec3 r0, pt_vec3 k, int indexed) {
    int smooth = pti_smooth(pti_roughest(s->d));
    pti_lobe *l = pti_add_lobe(s, smooth ? PTI_MIRROR : PTI_METAL, weight, pti_luminance(weight));
    pt_vec3 F;
    if (!l) return;
    l->r0 = r0; l->k = k; l->indexed = indexed;
    l->share *= pti_max(pti_luminance(pti_lobe_fresnel(l, pti_min(l->wo.z, 1))), 0.02f);      /* never 0: it grows at grazing */
    if (smooth) return;
    pti_lobe_rough(l, s->m->mirror, pti_mean_roughness(s->d->roughness, s->d->roughness_y));
    F = pti_metal_mean(l);
    l->more = pt_v3(pti_more_bounces(F.x, l->e_mean), pti_more_bounces(F.y, l->e_mean), pti_more_bounces(F.z, l->e_mean));
}
static void pti_shade_glass(pti_shading *s, pt_vec3 weight, pt_vec3 reflected, pt_vec3 through) {
    const pt_material_desc *d = s->d;
    float alpha = pti_roughest(d) * pti_roughest(d), bend = d->thin ? 1.0f : pti_min(fabsf(s->frame.eta - 1), 1);
    int smooth = alpha * bend < PTI_LEAST_ALPHA;         /* an index near 1 bends next to nothing, however rough */
    pti_lobe_kind kind = d->thin ? (smooth ? PTI_THIN_PANE : PTI_THIN) : smooth ? PTI_PANE : PTI_GLASS;
    pti_lobe *l = pti_add_lobe(s, kind, pti_mul(weight, reflected), pti_luminance(weight));
    if (!l) return;
    l->through = pti_mul(weight, through);
    if (kind == PTI_GLASS) s->surface->squeeze = l->eta * l->eta;
    if (!smooth) pti_lobe_rough(l, d->thin ? s->m->mirror : s->m->dielectric, pti_mean_roughness(d->roughness, d->roughness_y));
    if (kind == PTI_THIN) l->fresnel_mean = s->m->fresnel_mean;
}
/* What a clear layer reflects, seen from wo. Below an index of 1 there is a step, at the critical angle, that a table blurs. */
static float pti_layer_albedo(const pti_albedo *a, pt_vec3 wo, float eta, float rx, float ry) {
    float ax = pti_alpha(rx), ay = ry > 0 ? pti_alpha(ry) : ax, sum[2], cos_t;
    if (pti_smooth(pti_max(rx, ry))) return pti_fresnel(pti_min(wo.z, 1), eta, &cos_t);
    if (eta > 1 && (ax == ay || a->ax > 0))
        return pti_albedo_at(&a->reflected, wo.z, pti_albedo_row(a, rx, wo));
    pti_albedo_integrate(wo, ax, ay, eta, eta > 1 ? 16 : 32, eta > 1 ? 16 : 64, sum);
    return sum[0];
}
static void pti_shade_measured(pti_shading *s, const pt_vertex *x) {
    const pti_measured_row *row = pti_measured_row_of(s->m->measured, s->frame.wo.z);
    pt_vec3 color = pti_mul(s->weight, s->d->color), t = pti_madd(s->frame.n, -pti_dot(s->frame.n, x->wo), x->wo);
    pt_vec3 albedo = pti_add(row->albedo, pt_v3(1e-3f, 1e-3f, 1e-3f));   /* never 0: the row was fitted by a few points */
    pti_lobe *l = pti_add_lobe(s, PTI_MEASURED, color, pti_luminance(pti_mul(color, albedo)));
    if (!l) return;
    l->measured = row;
    if (pti_dot(t, t) > 1e-8f) { l->t = pti_normalize(t); l->b = pti_cross(l->n, l->t); }
    l->wo = pt_v3(pti_safe_sqrt(1 - l->wo.z * l->wo.z), 0, l->wo.z);
}
/* A clear layer: the coat, or the gloss of a dielectric. Returns how much of the light it keeps from what lies below. */
static float pti_shade_layer(pti_shading *s, float amount, float eta, const pti_albedo *a, float rx, float ry) {
    pti_lobe *l;
    float e;
    if (!(amount > 0) || eta == 1 || !a) return 0;
    e = amount * pti_layer_albedo(a, s->frame.wo, eta, rx, ry);
    l = pti_add_lobe(s, pti_smooth(pti_max(rx, ry)) ? PTI_GLOSS : PTI_COAT, pti_scale(s->weight, amount),
                     pti_luminance(s->weight) * e);
    if (!l) return e;
    l->eta = eta;
    l->ax = pti_alpha(rx);
    l->ay = ry > 0 ? pti_alpha(ry) : l->ax;
    return e;
}
static void pti_shade_fuzz(pti_shading *s) {
    const pt_material_desc *d = s->d;
    float e;
    pti_lobe *l;
    if (!(d->sheen > 0) || !s->m->fuzz) return;
    e = d->sheen * pti_albedo_at(&s->m->fuzz->reflected, s->frame.wo.z,
                                 pti_albedo_row(s->m->fuzz, d->sheen_roughness, s->frame.wo));
    l = pti_add_lobe(s, PTI_FUZZ, pti_scale(pti_mul(s->weight, d->sheen_color), d->sheen), pti_luminance(s->weight) * e);
    if (l) l->ax = pti_max(pti_alpha(d->sheen_roughness), PTI_LEAST_FUZZ);
    s->weight = pti_scale(s->weight, 1 - e * pti_largest(d->sheen_color));
}
/* What the ground has to know of the gloss above it, to let light out as it was let in. */
static void pti_shade_below_gloss(pti_shading *s) {
    const pt_material_desc *d = s->d;
    pti_lobe *l = &s->frame;
    float mean;
    l->albedo = s->m->dielectric;
    l->table_roughness = pti_mean_roughness(d->roughness, d->roughness_y);
    l->cover = d->specular;
    l->eta = d->ior;
    l->fresnel_mean = pti_smooth(pti_roughest(d)) ? s->m->fresnel_mean : 0.0f;
    mean = l->fresnel_mean > 0 ? l->fresnel_mean : pti_albedo_mean_at(&l->albedo->reflected, l->table_roughness);
    l->e_mean = pti_max(1 - d->specular * mean, 1e-6f);
}
static void pti_shade_principled(pti_shading *s) {
    const pt_material_desc *d = s->d;
    pt_vec3 white = pt_v3(1, 1, 1), none = pt_v3(0, 0, 0);
    int within = s->frame.inside && d->transmission > 0 && !d->thin;     /* fuzz and coat are outside */
    float e;
    if (!within) {
        pti_shade_fuzz(s);
        e = pti_shade_layer(s, d->coat, d->coat_ior, s->m->coat, d->coat_roughness, 0);
        s->weight = pti_scale(s->weight, 1 - e);
    }
    pti_shade_metal(s, pti_scale(s->weight, d->metallic), d->color, none, 0);
    s->weight = pti_scale(s->weight, 1 - d->metallic);
    pti_shade_glass(s, pti_scale(s->weight, d->transmission), white, d->color);
    s->weight = pti_scale(s->weight, 1 - d->transmission);
    e = pti_shade_layer(s, d->specular, d->ior, s->m->dielectric, d->roughness, d->roughness_y);
    if (e > 0) pti_shade_below_gloss(s);
    s->weight = pti_scale(s->weight, 1 - e);
    pti_shade_diffuse(s, 0);
}

/* Cauchy's n = A + B / lambda^2, with the index at the helium line d and Abbe's number (n_d - 1) / (n_F - n_C) between the
   hydrogen lines F and C: 587.56, 486.13 and 656.27 nm. */
static float pti_index_at(const pt_material_desc *d, float wavelength) {
    float B;
    if (!(d->abbe > 0) || !(wavelength > 0)) return d->ior;
    B = (d->ior - 1) / (d->abbe * (1 / (486.13f * 486.13f) - 1 / (656.27f * 656.27f)));
    return pti_max(d->ior + B * (1 / (wavelength * wavelength) - 1 / (587.56f * 587.56f)), 0.01f);   /* as ior */
}
/* The frame: about the tangent where the roughness along it differs from that across, else about any. */
static void pti_shade_frame(pti_shading *s, const pt_vertex *x) {
    const pt_material_desc *d = s->d;
    pti_lobe *l = &s->frame;
    float sine, cosine;
    l->inside = pti_dot(x->ng, x->wo) < 0;
    l->n = pti_shading_normal(s->m, x);
    l->ax = pti_alpha(d->roughness);
    l->ay = d->roughness_y > 0 ? pti_alpha(d->roughness_y) : l->ax;
    l->eta = pti_index_at(d, x->wavelength);
    if (l->inside && !d->thin) l->eta = 1 / l->eta;       /* a thin wall is the same from both sides */
    if (d->bsdf != PT_BSDF_DIFFUSE && !s->m->wants_choice) {       /* deltas alone: they need no frame */
        l->wo = pt_v3(0, 0, pti_max(pti_dot(l->n, x->wo), 1e-5f));
        return;
    }
    l->t = pti_normalize(pti_madd(l->n, -pti_dot(l->n, x->tangent), x->tangent));
    l->t = pti_normalize(pti_madd(l->n, -pti_dot(l->n, l->t), l->t));      /* again, where little was left of it */
    if (l->ax == l->ay || pti_is_zero3(l->t)) pti_basis(l->n, &l->t, &l->b);
    else {
        l->b = pti_cross(l->n, l->t);
        if (d->rotation_deg != 0) {
            pti_sincos(d->rotation_deg * (l->inside ? -PTI_PI / 180 : PTI_PI / 180), &sine, &cosine);
            l->t = pti_normalize(pti_madd(l->t, cosine, pti_scale(l->b, sine)));
            l->b = pti_cross(l->n, l->t);
        }
    }
    l->wo = pti_to_local(l, x->wo);
    l->wo.z = pti_max(l->wo.z, 1e-5f);
}
static void pti_material_lobes(const pti_material *m, const pt_vertex *x, pt_vec3 weight, pti_surface *out) {
    pt_material_desc varied;
    pti_shading s;
    pti_lobe *l;
    int indexed;
    memset(&s.frame, 0, sizeof s.frame);
    s.surface = out; s.m = m; s.d = &m->desc;
    if (m->varies) { pti_material_vary(m, x, &varied); s.d = &varied; }
    s.weight = pti_scale(weight, 1 - s.d->transparency);
    pti_add_lobe(&s, PTI_PASS, pti_scale(weight, s.d->transparency), pti_luminance(weight) * s.d->transparency);
    if (s.d->bsdf == PT_BSDF_MIX) {
        pti_material_lobes(m->all + s.d->a.id, x, pti_scale(s.weight, 1 - s.d->mix), out);
        pti_material_lobes(m->all + s.d->b.id, x, pti_scale(s.weight, s.d->mix), out);
        return;
    }
    pti_shade_frame(&s, x);
    switch (s.d->bsdf) {
    case PT_BSDF_CONDUCTOR:
        indexed = !pti_is_zero3(s.d->eta) || !pti_is_zero3(s.d->k);
        pti_shade_metal(&s, s.weight, indexed ? s.d->eta : s.d->color, s.d->k, indexed);
        break;
    case PT_BSDF_DIELECTRIC: pti_shade_glass(&s, s.weight, s.d->color, s.d->color); break;
    case PT_BSDF_PRINCIPLED: pti_shade_principled(&s); break;
    case PT_BSDF_MEASURED:   pti_shade_measured(&s, x); break;
    case PT_BSDF_NONE:       pti_add_lobe(&s, PTI_PASS, s.weight, pti_luminance(s.weight)); break;
    case PT_BSDF_USER:
        l = pti_add_lobe(&s, PTI_USER_LOBE, s.weight, pti_luminance(s.weight));
        if (l) { l->vtable = &m->vtable; l->user = m->desc.user; }
        break;
    default: pti_shade_diffuse(&s, s.d->roughness);
    }
}
/* All of it, shares adding up to 1. */
static void pti_surface_at(const pti_material *m, const pt_vertex *x, pti_surface *s) {
    float sum = 0;
    int i;
    s->x = x;
    s->count = 0;
    s->delta = 0;
    s->squeeze = 1;
    if (m->plain) {
        s->count = !pti_is_zero3(m->desc.color);
        s->lobes[0].kind = PTI_LAMBERT;
        s->lobes[0].share = 1;
        s->lobes[0].color = m->desc.color;
        s->lobes[0].n = pti_dot(x->ns, x->wo) < 0 ? pti_neg(x->ns) : x->ns;
        return;
    }
    if (m->phase) {
        s->count = 1;
        s->lobes[0].kind = PTI_PARTICLE;
        s->lobes[0].share = 1;
        s->lobes[0].phase = m->phase;
        return;
    }
    pti_material_lobes(m, x, pt_v3(1, 1, 1), s);
    for (i = 0; i < s->count; i++) sum += s->lobes[i].share;
    if (!(sum > 0)) s->count = 0;                        /* black */
    for (i = 0; i < s->count; i++) {
        pti_lobe *l = s->lobes + i;
        l->share /= sum;
        if (l->kind >= PTI_PASS) s->delta += l->share;
        else if (l->kind == PTI_USER_LOBE && l->vtable->delta) s->delta += l->share * pti_unit(l->vtable->delta(l->user, x));
    }
}

/* ---- >>light -------------------------------------------------------------------------------------------
   Where light comes from, as densities over directions. Seen from p, an emitter is drawn uniformly over its solid angle S,
   with p = 1 / S: of the noise, that leaves what the BSDF, the cosine and the shadows make. */

typedef enum pti_emitter_kind { PTI_TRIANGLE_LIGHT, PTI_RECT_LIGHT, PTI_SPHERE_LIGHT } pti_emitter_kind;
typedef struct pti_emitter {                             /* 64 bytes: one line of the cache */
    uint16_t kind, two_sided;
    float luminance;                                     /* of its radiance */
    pt_vec3 p, e1, e2, n;                                /* corner and edges, unit normal; or centre, and a spot's axis */
    float radius;                                        /* spheres only, like: */
    float spot;                                          /* 1 - cos of the cone that all light stays in, or 0 */
} pti_emitter;

static pti_emitter pti_emitter_flat(pti_emitter_kind kind, pt_vec3 p, pt_vec3 e1, pt_vec3 e2, float luminance,
                                    int two_sided) {
    pti_emitter e;
    e.kind = (uint16_t)kind; e.two_sided = two_sided != 0; e.luminance = luminance;
    e.p = p; e.e1 = e1; e.e2 = e2; e.n = pti_normalize(pti_cross(e1, e2));
    e.radius = e.spot = 0;
    return e;
}
static pti_emitter pti_emitter_sphere(pt_vec3 center, float radius, float luminance, int two_sided) {
    pti_emitter e;
    memset(&e, 0, sizeof e);
    e.kind = PTI_SPHERE_LIGHT; e.two_sided = two_sided != 0; e.luminance = luminance;
    e.p = center; e.radius = radius;
    return e;
}
static float pti_emitter_area(const pti_emitter *e) {
    if (e->kind == PTI_SPHERE_LIGHT) return 4 * PTI_PI * e->radius * e->radius;
    return pti_length(pti_cross(e->e1, e->e2)) * (e->kind == PTI_RECT_LIGHT ? 1.0f : 0.5f);
}
static int pti_emitter_all_round(const pti_emitter *e) {             /* does it shine every way alike? */
    return e->kind == PTI_SPHERE_LIGHT ? !(e->spot > 0) : e->two_sided;
}
static pti_bounds pti_emitter_bounds(const pti_emitter *e) {
    pti_bounds b;
    b.lo = b.hi = e->p;
    if (e->kind == PTI_SPHERE_LIGHT) { pti_bounds_pad(&b, e->radius); return b; }
    pti_bounds_point(&b, pti_add(e->p, e->e1));
    pti_bounds_point(&b, pti_add(e->p, e->e2));
    if (e->kind == PTI_RECT_LIGHT) pti_bounds_point(&b, pti_add(pti_add(e->p, e->e1), e->e2));
    return b;
}
/* Is p where a spot's light may come, d from its centre? All cones about its axis whose tips lie in the sphere, together:
   nowhere behind it, and no further off their side than the radius. A little more, for rounding. */
static int pti_emitter_spot_meets(const pti_emitter *e, pt_vec3 d) {
    float along = pti_dot(d, e->n), off = pti_length(pti_madd(e->n, -along, d)), sine = sqrtf(e->spot * (2 - e->spot));
    float room = e->radius + 1e-6f * (fabsf(along) + off);
    return along >= -room && off * (1 - e->spot) - along * sine <= room;
}
/* Does it shine on p at all? */
static int pti_emitter_faces(const pti_emitter *e, pt_vec3 p) {
    pt_vec3 d = pti_sub(p, e->p);
    float side = e->kind == PTI_SPHERE_LIGHT ? pti_dot(d, d) - e->radius * e->radius : pti_dot(d, e->n);
    if (e->spot > 0 && !pti_emitter_spot_meets(e, d)) return 0;
    return side > 0 || (e->two_sided && side < 0);
}

/* Below this solid angle the maps lose their digits, and area sampling takes over: p = d^2 / (A cos), which varies little
   over something that small. */
#define PTI_TINY_TRIANGLE 1e-6f
#define PTI_TINY_RECT 1e-7f

static float pti_emitter_triangle_angle(const pti_emitter *e, pt_vec3 p, pt_vec3 v[3]) {
    v[0] = pti_sub(e->p, p);
    v[1] = pti_normalize(pti_add(v[0], e->e1));
    v[2] = pti_normalize(pti_add(v[0], e->e2));
    v[0] = pti_normalize(v[0]);
    return pti_triangle_solid_angle(v[0], v[1], v[2]);
}
static pt_vec3 pti_emitter_sample_area(const pti_emitter *e, pt_vec3 p, float u, float v) {
    if (e->kind == PTI_TRIANGLE_LIGHT) { float s = sqrtf(u); u = 1 - s; v = v * s; }
    return pti_normalize(pti_sub(pti_madd(e->e1, u, pti_madd(e->e2, v, e->p)), p));
}
/* 1 - cos of the cone that a sphere fills, without cancellation; 2, all around, from within. */
static float pti_emitter_cone(const pti_emitter *e, pt_vec3 axis) {
    float s2 = e->radius * e->radius / pti_dot(axis, axis);
    return s2 < 1 ? s2 / (1 + sqrtf(1 - s2)) : 2.0f;
}
/* Where the ray from p along wi pierces a flat emitter: its distance, or 0. */
static float pti_emitter_distance(const pti_emitter *e, pt_vec3 p, pt_vec3 wi) {
    pt_vec3 h = pti_cross(wi, e->e2), s = pti_sub(p, e->p), q = pti_cross(s, e->e1);
    float det = pti_dot(e->e1, h), u, v;
    if (det == 0) return 0;
    u = pti_dot(s, h) / det;
    v = pti_dot(wi, q) / det;
    if (u < 0 || v < 0) return 0;
    if (e->kind == PTI_RECT_LIGHT ? u > 1 || v > 1 : u + v > 1) return 0;
    return pti_max(pti_dot(e->e2, q) / det, 0);
}
static int pti_emitter_in_cone(const pti_emitter *e, pt_vec3 p, pt_vec3 wi, float *one_minus_cos) {
    pt_vec3 axis = pti_sub(e->p, p);
    *one_minus_cos = pti_emitter_cone(e, axis);
    return pti_in_cone(pti_normalize(axis), *one_minus_cos, wi);
}
static float pti_emitter_pdf_area(const pti_emitter *e, pt_vec3 wi, float d) {
    return d * d / (pti_emitter_area(e) * fabsf(pti_dot(wi, e->n)) + 1e-30f);
}
/* Draws wi, and returns its density, or 0. A direction is made of floats: on the rim, rounding takes some to where the density
   is 0. Those are lost; were they kept, what they find would count 1 / p_bsdf instead of S. That is a bias, and the price of
   floats: nothing to see on most emitters, percents of the light of one thinner than 1e-6 rad, half of it at 1e-7. */
static float pti_emitter_sample(const pti_emitter *e, pt_vec3 p, float u, float v, pt_vec3 *wi) {
    pt_vec3 c[3], axis;
    pti_rect_frame frame;
    pti_rect r;
    float S, d;
    if (!pti_emitter_faces(e, p)) return 0;
    if (e->kind == PTI_SPHERE_LIGHT) {
        axis = pti_sub(e->p, p);
        *wi = pti_sample_cone_about(pti_normalize(axis), pti_emitter_cone(e, axis), u, v);
        return pti_emitter_in_cone(e, p, *wi, &S) ? pti_pdf_cone(S) : 0.0f;
    }
    if (e->kind == PTI_TRIANGLE_LIGHT) {
        S = pti_emitter_triangle_angle(e, p, c);
        if (S < PTI_TINY_TRIANGLE) S = 0;
        *wi = S > 0 ? pti_normalize(pti_sample_triangle(c[0], c[1], c[2], S, u, v)) : pti_emitter_sample_area(e, p, u, v);
    } else {
        frame = pti_rect_frame_of(e->e1, e->e2);
        r = pti_rect_seen_from(&frame, pti_sub(e->p, p));
        S = pti_rect_solid_angle(&r);
        if (S < PTI_TINY_RECT) S = 0;
        *wi = S > 0 ? pti_normalize(pti_sample_rect(&r, S, u, v)) : pti_emitter_sample_area(e, p, u, v);
    }
    d = pti_emitter_distance(e, p, *wi);
    return !(d > 0) ? 0.0f : S > 0 ? 1 / S : pti_emitter_pdf_area(e, *wi, d);
}
static float pti_emitter_pdf(const pti_emitter *e, pt_vec3 p, pt_vec3 wi) {
    pt_vec3 c[3];
    pti_rect_frame frame;
    pti_rect r;
    float S, d;
    if (!pti_emitter_faces(e, p)) return 0;
    if (e->kind == PTI_SPHERE_LIGHT) return pti_emitter_in_cone(e, p, wi, &S) ? pti_pdf_cone(S) : 0.0f;
    d = pti_emitter_distance(e, p, wi);
    if (!(d > 0)) return 0;
    if (e->kind == PTI_RECT_LIGHT) {
        frame = pti_rect_frame_of(e->e1, e->e2);
        r = pti_rect_seen_from(&frame, pti_sub(e->p, p));
        S = pti_rect_solid_angle(&r);
        if (S >= PTI_TINY_RECT) return pti_pdf_rect(S);
    } else {
        S = pti_emitter_triangle_angle(e, p, c);
        if (S >= PTI_TINY_TRIANGLE) return pti_pdf_triangle(S);
    }
    return pti_emitter_pdf_area(e, wi, d);
}

/* The light tree: a mixture of mixtures, whose weights depend on where the path stands. A node is split in two again and
   again until it has eight children, and
       p(wi) = sum_k w_k p_k(wi),   w_k = I_k / sum_j I_j,
   I being an estimate of the irradiance from a child (after Conty Estevez and Kulla 2018; by comparing eight small boxes
   instead of two large ones three times, a choice knows three times as far ahead). For a box with centre c whose diagonal is
   two radii long, with lamps of power Phi in it, seen from p, where the surface has the normal n,
       I = Phi / pi  e r / D^2,   D^2 = max(|c - p|^2, radius^2 / 4).
   r is the cosine at p, that of the middle of what of the box is above p's horizon; e that at the lamps,
       e = (1 - |m|) / 4 + |m| cos,
   m being the mean of their normals, and cos the angle's to it, as above: what shines every way alike sends a quarter of
   Phi / pi each way. I = 0 where the whole box is below the horizon of p, where all its lamps face away, by the cone that
   holds their normals, and for a single lamp that does not face p.
   sample walks down one way. pdf walks down all boxes that the ray meets and adds up what it finds in the leaves: all
   emitters along the direction, hidden ones too. It asks for weights on the way back, above what has been found: boxes are
   cheap, and most that a ray meets hold nothing on it. */
typedef struct pti_receiver { pt_vec3 p, n; } pti_receiver;        /* n: of an opaque surface, on the side that is looked
                                                                      at; or zero, where light from every side matters */
typedef struct pti_light_node {                          /* 64 bytes: one line of the cache */
    pt_vec3 center, half;                                /* of the box, half its diagonal: radius long */
    float radius;
    float power;                                         /* by which it is chosen: Phi / pi, or the number of lamps */
    pt_vec3 axis;                                        /* mean direction of the lamps' normals, m / |m| */
    float focus;                                         /* |m| */
    float cos_reach;                                     /* of the largest angle to axis at which any lamp shines; -1: all
                                                            round */
    uint32_t first, count;                               /* of its children, side by side. Leaf: its emitter, and 0 */
    uint32_t unused;                                     /* makes a node 64 bytes: a cache line */
} pti_light_node;
typedef struct pti_lights {
    pti_emitter *emitters;  size_t count, capacity;
    pti_light_node *nodes;  size_t node_count, node_capacity;      /* the root is 0 */
    pt_light_choice choose;
    float power;                                         /* Phi / pi of all */
} pti_lights;

/* ---- building: binned, by the surface area orientation heuristic */

static pti_light_node pti_light_leaf(const pti_emitter *e, uint32_t index) {
    pti_bounds b = pti_emitter_bounds(e);
    int all_round = pti_emitter_all_round(e);
    pti_light_node n;
    n.center = pti_scale(pti_add(b.lo, b.hi), 0.5f);
    n.half = pti_max3(pti_sub(b.hi, n.center), pti_sub(n.center, b.lo));
    n.radius = pti_length(n.half);
    n.power = pti_min(e->luminance * pti_emitter_area(e) * (e->kind != PTI_SPHERE_LIGHT && e->two_sided ? 2.0f : 1.0f), 1e27f);
    n.axis = all_round ? pt_v3(0, 0, 1) : e->n;
    n.focus = all_round || e->spot > 0 ? 0.0f : 1.0f;
    n.cos_reach = all_round ? -1.0f : e->spot > 0 ? 1 - e->spot : 0.0f;
    n.first = index;
    n.count = n.unused = 0;
    return n;
}
static pti_bounds pti_light_box(const pti_light_node *n) {
    pti_bounds b;
    b.lo = pti_sub(n->center, n->half);
    b.hi = pti_add(n->center, n->half);
    return b;
}
/* A node over many leaves: sums, then the cone about the mean normal that holds all of them. */
static pti_light_node pti_light_node_of(const pti_light_node *leaf, size_t count) {
    pti_bounds box = pti_bounds_empty(), b;
    pt_vec3 sum = pt_v3(0, 0, 0);
    float spread = 1, emits = 1, angle, sine;
    pti_light_node n;
    size_t i;
    n.power = 0;
    for (i = 0; i < count; i++) {
        b = pti_light_box(leaf + i);
        pti_bounds_merge(&box, &b);
        n.power += leaf[i].power;
        sum = pti_madd(leaf[i].axis, leaf[i].power * leaf[i].focus, sum);
        emits = pti_min(emits, leaf[i].cos_reach);
    }
    n.center = pti_scale(pti_add(box.lo, box.hi), 0.5f);
    n.half = pti_max3(pti_sub(box.hi, n.center), pti_sub(n.center, box.lo));
    n.half = pti_madd(n.half, 1e-6f, n.half);
    n.radius = pti_length(n.half);
    n.focus = n.power > 0 ? pti_min(pti_length(sum) / n.power, 0.999f) : 0.0f;
    n.axis = pti_is_zero3(sum) ? leaf[0].axis : pti_normalize(sum);
    n.cos_reach = -1;
    n.first = n.count = n.unused = 0;
    if (emits <= -1) return n;
    for (i = 0; i < count; i++) spread = pti_min(spread, pti_dot(n.axis, leaf[i].axis));
    angle = pti_acos(pti_clamp(spread, -1, 1)) + pti_acos(pti_min(emits, 1)) + 1e-3f;      /* acos is steep at 1 */
    if (angle < PTI_PI) pti_sincos(angle, &sine, &n.cos_reach);
    return n;
}

/* Where to split: power x area x orientation of both sides, the longest extent over that along the axis as a penalty for
   thin slices (Conty Estevez and Kulla). The solid angle into which light goes is 1 for one normal and 4 for all of
   them, linear in |m| between. */
typedef struct pti_light_bin { pti_bounds box; pt_vec3 sum; float power; } pti_light_bin;
static void pti_light_bin_clear(pti_light_bin *b) {
    b->box = pti_bounds_empty();
    b->sum = pt_v3(0, 0, 0);
    b->power = 0;
}
static void pti_light_bin_merge(pti_light_bin *b, const pti_light_bin *c) {
    pti_bounds_merge(&b->box, &c->box);
    b->sum = pti_add(b->sum, c->sum);
    b->power += c->power;
}
static float pti_light_bin_cost(const pti_light_bin *b) {
    return b->power > 0 ? pti_bounds_area(&b->box) * (4 * b->power - 3 * pti_length(b->sum)) : 0.0f;
}
static int pti_light_sweep(const pti_light_bin bins[PTI_BINS], float penalty, float *best) {
    float right[PTI_BINS], cost;
    pti_light_bin b;
    int k, at = 0;
    pti_light_bin_clear(&b);
    for (k = PTI_BINS - 1; k > 0; k--) {
        pti_light_bin_merge(&b, bins + k);
        right[k] = b.power > 0 ? pti_light_bin_cost(&b) : -1.0f;
    }
    pti_light_bin_clear(&b);
    for (k = 1; k < PTI_BINS; k++) {
        pti_light_bin_merge(&b, bins + k - 1);
        if (!(b.power > 0) || right[k] < 0) continue;
        cost = penalty * (pti_light_bin_cost(&b) + right[k]);
        if (cost < *best) { *best = cost; at = k; }
    }
    return at;
}
static float pti_light_bin_scale(const pti_bounds *centers, int axis) {
    float extent = pti_axis(centers->hi, axis) - pti_axis(centers->lo, axis);
    return extent > 1e-37f ? PTI_BINS / extent : 0.0f;
}
static void pti_light_fill(const pti_light_node *leaf, size_t count, const pti_bounds *centers, int axis,
                           pti_light_bin bins[PTI_BINS]) {
    float lo = pti_axis(centers->lo, axis), scale = pti_light_bin_scale(centers, axis);
    size_t i;
    int k;
    for (k = 0; k < PTI_BINS; k++) pti_light_bin_clear(bins + k);
    for (i = 0; i < count; i++) {
        const pti_light_node *n = leaf + i;
        pti_bounds box = pti_light_box(n);
        k = pti_bin_of(pti_axis(n->center, axis), lo, scale);
        pti_bounds_merge(&bins[k].box, &box);
        bins[k].sum = pti_madd(n->axis, n->power * n->focus, bins[k].sum);
        bins[k].power += n->power;
    }
}
#define PTI_LIGHT_DEPTH 60
/* Moves what goes left to the front; returns how many. Where no border is better than none, or the tree gets deep: half. */
static size_t pti_light_split(pti_light_node *leaf, size_t count, int depth) {
    pti_bounds centers = pti_bounds_empty();
    pti_light_bin bins[PTI_BINS];
    float best = FLT_MAX, longest, lo, scale;
    size_t i, j = 0;
    int axis, at, best_axis = -1, best_at = 0;
    if (depth + pti_log2_ceil(count) >= PTI_LIGHT_DEPTH) return count / 2;
    for (i = 0; i < count; i++) pti_bounds_point(&centers, leaf[i].center);
    longest = pti_largest(pti_sub(centers.hi, centers.lo));
    for (axis = 0; axis < 3; axis++) {
        scale = pti_light_bin_scale(&centers, axis);
        if (!(scale > 0)) continue;
        pti_light_fill(leaf, count, &centers, axis, bins);
        at = pti_light_sweep(bins, longest * scale, &best);
        if (at) { best_axis = axis; best_at = at; }
    }
    if (best_axis < 0) return count / 2;
    lo = pti_axis(centers.lo, best_axis);
    scale = pti_light_bin_scale(&centers, best_axis);
    for (i = 0; i < count; i++)
        if (pti_bin_of(pti_axis(leaf[i].center, best_axis), lo, scale) < best_at) {
            pti_light_node moved = leaf[i];
            leaf[i] = leaf[j];
            leaf[j++] = moved;
        }
    return j;
}
/* A range of leaves, while the tree is built. The one with most power x area is split first. */
typedef struct pti_light_range { pti_light_node *leaf; size_t count; pti_light_node node; float size; int depth; } pti_light_range;
static pti_light_range pti_light_range_of(pti_light_node *leaf, size_t count, int depth) {
    pti_light_range r;
    pti_bounds box;
    r.leaf = leaf; r.count = count; r.depth = depth;
    r.node = count > 1 ? pti_light_node_of(leaf, count) : *leaf;
    box = pti_light_box(&r.node);
    r.size = count > 1 ? pti_bounds_area(&box) * r.node.power : -1.0f;
    return r;
}
static uint32_t pti_light_open(const pti_light_range *all, pti_light_range child[PTI_WIDTH]) {
    uint32_t count = 1, k, pick;
    child[0] = *all;
    while (count < PTI_WIDTH) {
        pti_light_range whole;
        size_t left;
        for (k = 1, pick = 0; k < count; k++) if (child[k].size > child[pick].size) pick = k;
        whole = child[pick];
        if (whole.count == 1) break;
        left = pti_light_split(whole.leaf, whole.count, whole.depth);
        child[pick] = pti_light_range_of(whole.leaf, left, whole.depth + 1);
        child[count++] = pti_light_range_of(whole.leaf + left, whole.count - left, whole.depth + 1);
    }
    return count;
}
static void pti_light_build(pti_lights *l, size_t self, const pti_light_range *all) {
    pti_light_range child[PTI_WIDTH];
    pti_light_node *n = l->nodes + self;
    uint32_t k;
    *n = all->node;
    if (l->choose == PT_CHOOSE_UNIFORM) n->power = (float)all->count;
    if (all->count == 1) return;
    n->count = pti_light_open(all, child);
    n->first = (uint32_t)l->node_count;
    l->node_count += n->count;
    for (k = 0; k < n->count; k++) pti_light_build(l, (size_t)n->first + k, child + k);
}
static int pti_lights_build(pti_lights *l, const pt_allocator *a) {            /* 0 when out of memory */
    pti_light_node *leaves;
    pti_light_range all;
    void *nodes;
    size_t i;
    if (!l->count) return 1;
    leaves = (pti_light_node *)pti_alloc(a, l->count, sizeof *leaves);
    if (!leaves) return 0;
    l->nodes = (pti_light_node *)pti_alloc(a, 2 * l->count, sizeof *l->nodes);
    if (!l->nodes) { pti_free(a, leaves, l->count, sizeof *leaves); return 0; }
    l->node_capacity = 2 * l->count;
    for (i = 0; i < l->count; i++) leaves[i] = pti_light_leaf(l->emitters + i, (uint32_t)i);
    all = pti_light_range_of(leaves, l->count, 0);
    l->power = all.node.power;
    l->node_count = 1;
    pti_light_build(l, 0, &all);
    pti_free(a, leaves, l->count, sizeof *leaves);
    nodes = l->nodes;
    i = (size_t)pti_shrink(a, &nodes, l->node_count, &l->node_capacity, sizeof *l->nodes);
    l->nodes = (pti_light_node *)nodes;
    return i != 0;
}

/* ---- walking */

/* Something spread over [middle - reach, middle + reach]: the middle of what of it is above 0. */
static float pti_middle_above(float middle, float reach) {
    return middle >= reach ? middle : pti_max(middle + reach, 0) * 0.5f;
}
static float pti_box_reach(pt_vec3 half, pt_vec3 d) {    /* how far a box reaches from its centre along d, or against it */
    return half.x * fabsf(d.x) + half.y * fabsf(d.y) + half.z * fabsf(d.z);
}
/* I / (Phi / pi). Zeros leave a little room for rounding. */
static float pti_light_geometry(const pti_light_node *n, const pti_receiver *r) {
    pt_vec3 d = pti_sub(n->center, r->p);
    float d2 = pti_dot(d, d), D2 = pti_max(d2, 0.25f * n->radius * n->radius) + 1e-30f, inverse = 1 / sqrtf(D2);
    float distance = d2 * inverse, e = 0.25f, at_p = 1, above, reach;
    float room = 1e-6f * (distance + n->radius);
    if (n->count && n->cos_reach > -1) {                 /* a lamp itself is asked later, by pti_emitter_faces */
        above = -pti_dot(n->axis, d);
        reach = pti_box_reach(n->half, n->axis);
        if (n->cos_reach <= 0 ? above + reach + room <= n->cos_reach * (distance + n->radius)
                              : above + reach + room <= n->cos_reach * (distance - n->radius)) return 0;
    }
    if (n->focus > 0) {
        above = pti_middle_above(-pti_dot(n->axis, d), pti_box_reach(n->half, n->axis));
        e = 0.25f * (1 - n->focus) + n->focus * pti_min(above * inverse, 1);
    }
    if (!pti_is_zero3(r->n)) {
        at_p = pti_middle_above(pti_dot(r->n, d), pti_box_reach(n->half, r->n) + room);
        at_p = pti_min(at_p * inverse, 1);
    }
    return e * at_p / D2;
}
static float pti_light_importance(const pti_lights *l, const pti_light_node *n, const pti_receiver *r) {
    float g;
    if (l->choose != PT_CHOOSE_TREE) return n->power;
    g = pti_light_geometry(n, r);
    if (!n->count && g > 0 && !pti_emitter_faces(l->emitters + n->first, r->p)) return 0;
    return pti_min(n->power * g, 1e36f);
}
/* imp: I of a node's children (<complex.h> owns the letter); returns the sum. */
static double pti_light_weigh(const pti_lights *l, const pti_light_node *n, const pti_receiver *r, float imp[PTI_WIDTH]) {
    double sum = 0;
    uint32_t k;
    for (k = 0; k < n->count; k++) sum += (double)(imp[k] = pti_light_importance(l, l->nodes + n->first + k, r));
    return sum;
}
/* Draws k with probability imp[k] / sum, and leaves *u uniform again: pti_split for many. sum > 0 is that of all, in order. */
static uint32_t pti_light_pick(const float imp[PTI_WIDTH], uint32_t count, double sum, uint32_t *u) {
    uint64_t from = 0, to = 0, low = pti_hash(*u ^ 0x5bd1e995u);
    double run = 0;
    uint32_t k;
    for (k = 0; k < count; k++) {
        from = to;
        run += (double)imp[k];
        to = (uint64_t)(run / sum * 4294967296.0);
        if (*u < to) break;
    }
    *u = (uint32_t)(((uint64_t)(*u - (uint32_t)from) << 32 | low) / (to - from));
    return k;
}
static const pti_emitter *pti_lights_choose(const pti_lights *l, const pti_receiver *r, uint32_t choice) {
    const pti_light_node *n = l->nodes;
    float imp[PTI_WIDTH];
    while (n->count) {
        double sum = pti_light_weigh(l, n, r, imp);
        if (!(sum > 0)) return NULL;                     /* no child shines on p */
        n = l->nodes + n->first + pti_light_pick(imp, n->count, sum, &choice);
    }
    return l->emitters + n->first;
}
typedef struct pti_on_map { int known; float u, v; } pti_on_map;
/* What is known of a direction, and need not be computed again: the emitter that drew it, if one did, and its density there; and
   where on the environment's map it is. */
typedef struct pti_drawn { const pti_emitter *by; float pdf; pti_on_map sky; } pti_drawn;
static pti_drawn pti_drawn_nothing(void) {
    pti_drawn d;
    d.by = NULL;
    d.pdf = 0;
    d.sky.known = 0;
    return d;
}
static int pti_lights_sample(const pti_lights *l, const pti_receiver *r, uint32_t choice, float u, float v, pt_vec3 *wi,
                             pti_drawn *drawn) {
    drawn->by = pti_lights_choose(l, r, choice);
    drawn->pdf = drawn->by ? pti_emitter_sample(drawn->by, r->p, u, v, wi) : 0.0f;
    return drawn->pdf > 0;
}

/* A ray on its way through the tree. Boxes are widened by what the rounding of wi is at their distance, so that the tree
   never misses what a leaf counts. */
typedef struct pti_light_ray {
    const pti_lights *lights;
    const pti_receiver *receiver;
    const pti_drawn *drawn;
    pt_vec3 wi, inverse;
} pti_light_ray;
static float pti_light_slope(float d) { return fabsf(d) > 1e-16f ? 1 / d : 1e16f; }
static int pti_light_met(const pti_light_node *n, const pti_light_ray *r) {
    pt_vec3 d = pti_sub(n->center, r->receiver->p), v = r->inverse;
    float pad = 1e-6f * (fabsf(d.x) + fabsf(d.y) + fabsf(d.z) + n->radius);
    float x = d.x * v.x, y = d.y * v.y, z = d.z * v.z;
    float a = (n->half.x + pad) * fabsf(v.x), b = (n->half.y + pad) * fabsf(v.y), c = (n->half.z + pad) * fabsf(v.z);
    float t0 = pti_max(pti_max(x - a, y - b), pti_max(z - c, 0)), t1 = pti_min(pti_min(x + a, y + b), z + c);
    return t0 <= t1;
}
static float pti_drawn_pdf(const pti_drawn *drawn, const pti_emitter *e, pt_vec3 p, pt_vec3 wi) {
    return drawn && drawn->by == e ? drawn->pdf : pti_emitter_pdf(e, p, wi);
}
static float pti_light_pdf(const pti_light_ray *r, const pti_light_node *n) {
    const pti_lights *l = r->lights;
    const pti_light_node *child = l->nodes + n->first;
    float p[PTI_WIDTH], imp[PTI_WIDTH], most = 0;
    double sum, weighted = 0;
    uint32_t k;
    if (!n->count) return pti_drawn_pdf(r->drawn, l->emitters + n->first, r->receiver->p, r->wi);
    for (k = 0; k < n->count; k++) {
        p[k] = pti_light_met(child + k, r) ? pti_light_pdf(r, child + k) : 0.0f;
        most = pti_max(most, p[k]);
    }
    if (!(most > 0)) return 0;
    sum = pti_light_weigh(l, n, r->receiver, imp);
    if (!(sum > 0)) return 0;
    for (k = 0; k < n->count; k++) weighted += (double)imp[k] * (double)p[k];
    return (float)(weighted / sum);
}
static float pti_lights_pdf(const pti_lights *l, const pti_receiver *receiver, pt_vec3 wi, const pti_drawn *drawn) {   /* or NULL */
    pti_light_ray r;
    if (l->count == 1) return pti_drawn_pdf(drawn, l->emitters, receiver->p, wi);
    r.lights = l; r.receiver = receiver; r.wi = wi; r.drawn = drawn;
    r.inverse = pt_v3(pti_light_slope(wi.x), pti_light_slope(wi.y), pti_light_slope(wi.z));
    return pti_light_pdf(&r, l->nodes);
}
/* An estimate of the irradiance from all emitters, of which there is one at least; 0 if all face away. */
static float pti_lights_irradiance(const pti_lights *l, const pti_receiver *r) {
    const pti_light_node *root = l->nodes;
    if (!root->count && !pti_emitter_faces(l->emitters + root->first, r->p)) return 0;
    return pti_min(l->power * pti_light_geometry(root, r), 1e36f);
}

/* A sun: a disk at infinity, of even radiance L. A surface that faces it gets, for the angular radius r,
       E = pi sin^2 r L,
   and the disk is drawn as a cone, p = 1 / (2 pi (1 - cos r)). */
typedef struct pti_sun {
    pt_vec3 axis, radiance;                              /* axis: towards it */
    float one_minus_cos;
} pti_sun;

static pti_sun pti_sun_of(pt_vec3 axis, float radius_deg, pt_vec3 irradiance) {
    pti_sun s;
    float sine, cosine;
    pti_sincos(radius_deg * (PTI_PI / 360), &sine, &cosine);
    s.one_minus_cos = 2 * sine * sine;                   /* 1 - cos r = 2 sin^2(r/2), sin r = 2 sin(r/2) cos(r/2) */
    sine *= 2 * cosine;
    s.radiance = pti_scale(irradiance, 1 / (PTI_PI * sine * sine));
    s.axis = axis;
    return s;
}
static int pti_sun_holds(const pti_sun *s, pt_vec3 wi) { return pti_in_cone(s->axis, s->one_minus_cos, wi); }
static int pti_sun_sample(const pti_sun *s, float u, float v, pt_vec3 *wi) {   /* 0: rounded out of the disk */
    *wi = pti_sample_cone_about(s->axis, s->one_minus_cos, u, v);
    return pti_sun_holds(s, *wi);
}
static float pti_sun_pdf(const pti_sun *s, pt_vec3 wi) {
    return pti_sun_holds(s, wi) ? pti_pdf_cone(s->one_minus_cos) : 0.0f;
}

/* The sky, as the air makes it: sunlight that molecules and haze scatter, and ozone absorbs, integrated along each direction,
       L(w) = integral T(t) (s_R p_R + s_H p_H) E_sun T_sun  +  T(t) (s_R + s_H) M  dt,
   T = exp(-optical depth) from the eye to t, T_sun from there to the sun, s and p the scattering coefficients and the phase
   functions of molecules (Rayleigh) and haze (Henyey and Greenstein). Light that was scattered more than once has forgotten
   where it came from: M = L2 / (1 - f), a geometric series, L2 being what comes from all around after two scatterings and f
   the share of light that is scattered here again (Hillaire 2020, "A Scalable and Production Ready Sky and Atmosphere
   Rendering Technique"). Unlike formulas fitted to the day (Preetham 1999), this also knows dusk.

   Optical depths of air straight up (Preetham, Shirley and Smits 1999, appendix; wavelength l in micrometres, turbidity T):
       molecules 0.008735 l^-4.08,   haze (0.04608 T - 0.04586) l^-1.3,   ozone 0.35 k_o,
   at one wavelength a channel, the one that comes closest to the sun's spectrum behind one to five airs, to 1 %. Molecules
   thin out by e every 8 km, haze every 1.2 km, and ozone lies between 10 and 40 km. Beyond the air, the sun gives 133.1 klx
   of a black body at 5772 K. 179 lm are a watt: the efficacy of white light over the wavelengths that eyes see. The infrared,
   half of the sun's watts, has no channel. (683 lm/W would be right for 555 nm alone.) Lengths are kilometres. */
#define PTI_EARTH 6360.0f
#define PTI_AIR_TOP 100.0f
#define PTI_GROUND_ALBEDO 0.2f
typedef struct pti_air { pt_vec3 molecules, haze, ozone, sun; } pti_air;       /* extinction per km, at the ground or at its
                                                                                  peak; irradiance beyond the air */
static pti_air pti_air_of(float turbidity) {
    static const float wavelength[3] = { 0.636f, 0.544f, 0.442f };
    float m[3], h[3];
    pti_air a;
    int k;
    for (k = 0; k < 3; k++) {
        m[k] = 0.008735f * pti_pow(wavelength[k], -4.08f) / 8;
        h[k] = (0.04608f * turbidity - 0.04586f) * pti_pow(wavelength[k], -1.3f) / 1.2f;
    }
    a.molecules = pt_v3(m[0], m[1], m[2]);
    a.haze = pt_v3(h[0], h[1], h[2]);
    a.ozone = pti_scale(pt_v3(0.11f, 0.08f, 0.005f), 0.35f / 15);      /* a tent: half of 30 km */
    a.sun = pti_scale(pt_v3(1.108f, 0.977f, 0.911f), 133100.0f / 179);
    return a;
}
/* A ray from altitude h, mu the cosine of its angle from straight up: its altitude at t, and where it leaves the air. */
static float pti_air_altitude(float h, float mu, float t) {
    float above = h * (2 * PTI_EARTH + h) + t * (2 * (PTI_EARTH + h) * mu + t);            /* r^2 - earth^2 */
    return above / (PTI_EARTH + sqrtf(pti_max(above + PTI_EARTH * PTI_EARTH, 0)));
}
static float pti_air_length(float h, float mu, float top) {
    float b = (PTI_EARTH + h) * mu;
    return sqrtf(pti_max(b * b + (top - h) * (2 * PTI_EARTH + top + h), 0)) - b;
}
static pt_vec3 pti_air_densities(float h) {              /* of molecules, haze and ozone; more and more below the ground */
    h = pti_max(h, -10);
    return pt_v3(pti_exp(-h / 8), pti_exp(-h / 1.2f), pti_max(1 - fabsf(h - 25) / 15, 0));
}
static pt_vec3 pti_air_extinction(const pti_air *a, pt_vec3 d) {
    return pti_madd(a->molecules, d.x, pti_madd(a->haze, d.y, pti_scale(a->ozone, d.z)));
}
static pt_vec3 pti_air_transmittance(pt_vec3 depth) {
    return pt_v3(pti_exp(-depth.x), pti_exp(-depth.y), pti_exp(-depth.z));
}
/* Of the sun's light, as it comes to altitude h. The ground needs no test: the air in its place is thick enough. */
static pt_vec3 pti_air_sunlight(const pti_air *a, float h, float mu) {
    float length = pti_air_length(h, mu, PTI_AIR_TOP);
    pt_vec3 sum = pt_v3(0, 0, 0);
    int i, n = 16;
    for (i = 0; i < n; i++) {                            /* steps grow with t */
        float s = ((float)i + 0.5f) / (float)n;
        sum = pti_madd(pti_air_densities(pti_air_altitude(h, mu, length * s * s)), 2 * s * length / (float)n, sum);
    }
    return pti_mul(a->sun, pti_air_transmittance(pti_air_extinction(a, sum)));
}

/* M, over altitude and the sun's height, near the height that it has where the eye is. */
#define PTI_SKY_ALTITUDES 8
#define PTI_SKY_HEIGHTS 9
typedef struct pti_sky { pti_air air; pt_vec3 sun; pt_vec3 many[PTI_SKY_ALTITUDES][PTI_SKY_HEIGHTS]; } pti_sky;

static pt_vec3 pti_sky_many(const pti_sky *k, float h, float mu_sun) {
    float y = sqrtf(pti_clamp(h / 60, 0, 0.9999f)) * (PTI_SKY_ALTITUDES - 1), x = (mu_sun - k->sun.y) * 20 + 4;
    int i, j;
    x = pti_clamp(x, 0, PTI_SKY_HEIGHTS - 1.001f);
    i = (int)x; j = (int)y;
    x -= (float)i; y -= (float)j;
    return pti_madd(pti_madd(k->many[j][i], 1 - x, pti_scale(k->many[j][i + 1], x)), 1 - y,
                    pti_scale(pti_madd(k->many[j + 1][i], 1 - x, pti_scale(k->many[j + 1][i + 1], x)), y));
}
/* Along a ray of this length: what is scattered into it, with nu = cos of the angle to the sun, or with all phase functions
   1 / (4 pi), for M itself; *through gets T at its end, *again (f) the integral of T s, if asked for. */
static pt_vec3 pti_sky_march(const pti_sky *k, float h, float mu, float mu_sun, float nu, float length, int n,
                             pt_vec3 *through, pt_vec3 *again) {
    const float g = 0.76f, g2 = g * g, even = 1 / (4 * PTI_PI);
    float x = 1 + g2 - 2 * g * nu, p_molecules = 0.75f * even * (1 + nu * nu), p_haze = even * (1 - g2) / (x * sqrtf(x));
    pt_vec3 L = pt_v3(0, 0, 0), T = pt_v3(1, 1, 1);
    int i;
    if (again) { p_molecules = p_haze = even; *again = L; }
    for (i = 0; i < n; i++) {
        float s = ((float)i + 0.5f) / (float)n, t = length * s * s, dt = 2 * s * length / (float)n;
        float at = pti_air_altitude(h, mu, t);
        float mu_there = ((PTI_EARTH + h) * mu_sun + t * nu) / (PTI_EARTH + at);
        pt_vec3 d = pti_air_densities(at), extinction = pti_air_extinction(&k->air, d), sunlight, step, gain;
        pt_vec3 molecules = pti_scale(k->air.molecules, d.x), haze = pti_scale(k->air.haze, 0.95f * d.y);      /* scattered */
        step = pti_air_transmittance(pti_scale(extinction, dt));
        gain = pti_mul(T, pt_v3((1 - step.x) / extinction.x, (1 - step.y) / extinction.y, (1 - step.z) / extinction.z));
        sunlight = pti_air_sunlight(&k->air, at, mu_there);
        L = pti_add(L, pti_mul(gain, pti_mul(sunlight, pti_madd(molecules, p_molecules, pti_scale(haze, p_haze)))));
        molecules = pti_mul(gain, pti_add(molecules, haze));
        if (again) *again = pti_add(*again, molecules);
        else L = pti_add(L, pti_mul(molecules, pti_sky_many(k, at, mu_there)));
        T = pti_mul(T, step);
    }
    if (through) *through = T;
    return L;
}
static pt_vec3 pti_sky_many_at(const pti_sky *k, float h, float mu_sun) {
    pt_vec3 L = pt_v3(0, 0, 0), f = L, through, again;
    float sine = pti_safe_sqrt(1 - mu_sun * mu_sun);
    int i, n = 32;
    for (i = 0; i < n; i++) {                            /* directions all around (golden angle) */
        pt_vec3 d = pti_sample_sphere(((float)i + 0.5f) / (float)n, 0.618034f * (float)i), one;
        float dip = (PTI_EARTH + h) * (PTI_EARTH + h) * (1 - d.z * d.z), length = pti_air_length(h, d.z, PTI_AIR_TOP);
        int down = d.z < 0 && dip < PTI_EARTH * PTI_EARTH;
        if (down) length = -(PTI_EARTH + h) * d.z - sqrtf(PTI_EARTH * PTI_EARTH - dip);
        one = pti_sky_march(k, h, d.z, mu_sun, mu_sun * d.z + sine * d.x, length, 12, &through, &again);
        if (down) one = pti_madd(pti_mul(through, pti_air_sunlight(&k->air, 0, mu_sun)),
                                 pti_max(mu_sun, 0) * PTI_GROUND_ALBEDO / PTI_PI, one);
        L = pti_madd(one, 1 / (float)n, L);
        f = pti_madd(again, 1 / (float)n, f);
    }
    return pt_v3(L.x / (1 - f.x), L.y / (1 - f.y), L.z / (1 - f.z));
}
static void pti_sky_build(pti_sky *k, pt_vec3 sun, float turbidity) {
    int i, j;
    k->air = pti_air_of(turbidity);
    k->sun = sun;
    for (j = 0; j < PTI_SKY_ALTITUDES; j++)
        for (i = 0; i < PTI_SKY_HEIGHTS; i++) {
            float y = (float)j / (PTI_SKY_ALTITUDES - 1);
            k->many[j][i] = pti_sky_many_at(k, 60 * y * y, pti_clamp(sun.y + (float)(i - 4) * 0.05f, -1, 1));
        }
}
/* A map whose middle is below the sun, so that its right half mirrors the left one. Below the horizon there is ground, lit by
   the sky and the sun; it comes out of the horizon's haze within 6 degrees, so that a floor that ends before the horizon
   shows no edge there. */
static void pti_sky_map(const pti_sky *k, pt_vec3 *map, int width, int height) {
    pt_vec3 ground = pti_scale(pti_air_sunlight(&k->air, 0, k->sun.y), pti_max(k->sun.y, 0)), L, *row;
    float across = pti_safe_sqrt(1 - k->sun.y * k->sun.y), up, side, s, c, haze;
    int x, y, half = height / 2;
    for (y = 0; y < half; y++) {
        row = map + y * width;
        pti_sincos(((float)y + 0.5f) / (float)height * PTI_PI, &side, &up);
        for (x = 0; x < width / 2; x++) {
            pti_sincos((((float)x + 0.5f) / (float)width - 0.5f) * (2 * PTI_PI), &s, &c);
            L = pti_sky_march(k, 0, up, k->sun.y, up * k->sun.y + side * c * across, pti_air_length(0, up, PTI_AIR_TOP), 32,
                              NULL, NULL);
            row[x] = row[width - 1 - x] = L;
            ground = pti_madd(L, up * side * (4 * PTI_PI * PTI_PI) / (float)(width * height), ground);     /* for both */
        }
    }
    row = map + (half - 1) * width;
    for (y = half; y < height; y++)
        for (x = 0; x < width; x++) {
            haze = pti_max(1 - ((float)(y - half) + 0.5f) / (float)height * 30, 0);
            haze = haze * haze * (3 - 2 * haze);
            map[y * width + x] = pti_madd(row[x], haze, pti_scale(ground, (1 - haze) * (PTI_GROUND_ALBEDO / PTI_PI)));
        }
}

/* The environment: radiance from infinity; suns stand before the map and add to it. It is drawn in two steps. Parts come
   first, 32 x 16 fields of the map and the suns, with probabilities that depend on the normal n of what receives the light;
   then within a field a table of its luminance, or the sun's disk. A constant map has no density: the BSDF's is better.

   One sample of w p_bsdf + (1 - w) p_env has no variance where that is in proportion to f cos L. On a diffuse surface
   without shadows, for p_bsdf = cos / pi,
       p_env ~ cos max(0, L - w E / pi),   E the irradiance on the surface:
   what BSDF sampling finds often enough anyway is taken off (MIS compensation, Karlik et al. 2019, for one sample of a
   mixture and a known normal). w is taken for one half. Some of L stays, since there are shadows and gloss; and cos is
       (c + sqrt(c^2 + s^2)) / 2,   c = n . d,   d the part's mean direction by its light,
   which is positive everywhere: s^2 = 1 - |d|^2 + PTI_RECEIVER_SPREAD says how far directions of the part and normals of
   the same receiver differ. Receivers are 16 x 16 classes of normals, and one more: from all around. */
#define PTI_ENVIRONMENT_ACROSS 32
#define PTI_ENVIRONMENT_DOWN 16
#define PTI_FIELD_CELLS 64                               /* along each side of a field, at most */
#define PTI_RECEIVER_GRID 16
#define PTI_RECEIVERS (PTI_RECEIVER_GRID * PTI_RECEIVER_GRID + 1)
#define PTI_RECEIVER_ALL (PTI_RECEIVERS - 1)
#define PTI_RECEIVER_SPREAD 0.02f
#define PTI_COMPENSATION 0.5f                            /* w */
#define PTI_COMPENSATION_LEAST 0.5f                      /* of L stays */

typedef struct pti_environment {
    int present, textured;                               /* textured: by picture or by callback */
    pt_vec3 color;
    const pti_texture *texture;
    pt_vec3 (*radiance)(void *user, pt_vec3 dir);
    void *user;
    float sine, cosine;                                  /* of the rotation */
    float mean;                                          /* luminance of the map over the sphere */
    int across, down;                                    /* cells of a field's table, 1 to 64 */
    float *fields;                                       /* the tables: rows, then cells of each row */
    int field_count, part_count;                         /* fields come first; 0 of a constant map */
    float *receivers;                                    /* for each a table of parts: part_count + 1 numbers */
    float *irradiance;                                   /* of each receiver; NULL where there is no part */
    pti_sun *suns;  size_t sun_count, sun_capacity;
} pti_environment;

/* Direction and place on the map: u to the right from the left border (+z, seen from the middle, -z), v down from +y. */
static void pti_direction_to_uv(pt_vec3 d, float *u, float *v) {
    *u = 0.5f + pti_atan2(d.x, -d.z) * (0.5f / PTI_PI);
    *v = pti_atan2(sqrtf(d.x * d.x + d.z * d.z), d.y) / PTI_PI;        /* acos(y) would lose the poles */
}
static pt_vec3 pti_uv_to_direction(float u, float v) {
    float st, ct, sp, cp;
    pti_sincos(v * PTI_PI, &st, &ct);
    pti_sincos((u - 0.5f) * (2 * PTI_PI), &sp, &cp);
    return pt_v3(st * sp, ct, -st * cp);
}
static pt_vec3 pti_environment_turn(const pti_environment *e, pt_vec3 d, float direction) {     /* -1: world to map */
    float s = e->sine * direction;
    return pt_v3(e->cosine * d.x + s * d.z, d.y, e->cosine * d.z - s * d.x);
}
static void pti_environment_place(const pti_environment *e, pt_vec3 wi, pti_on_map *at) {
    if (!at->known) pti_direction_to_uv(pti_environment_turn(e, wi, -1), &at->u, &at->v);
    at->known = 1;
}
static pt_vec3 pti_environment_map(const pti_environment *e, pt_vec3 wi, pti_on_map *at) {
    if (e->radiance) return pti_mul(e->color, e->radiance(e->user, pti_environment_turn(e, wi, -1)));
    if (!e->texture) return e->color;
    pti_environment_place(e, wi, at);
    return pti_mul(e->color, pti_texture_bilinear(e->texture, at->u, at->v, 1));
}
/* at: where wi is on the map, if that is known; else it will be. */
static pt_vec3 pti_environment_radiance(const pti_environment *e, pt_vec3 wi, pti_on_map *at) {
    pt_vec3 L = e->present ? pti_environment_map(e, wi, at) : pt_v3(0, 0, 0);
    size_t i;
    for (i = 0; i < e->sun_count; i++) if (pti_sun_holds(e->suns + i, wi)) L = pti_add(L, e->suns[i].radiance);
    return L;
}
/* Unit vectors on a square: the octahedron's faces folded flat (Praun and Hoppe 2003). */
static int pti_environment_receiver(pt_vec3 n) {
    float l = fabsf(n.x) + fabsf(n.y) + fabsf(n.z), x = n.x, y = n.z;
    if (!(l > 0)) return PTI_RECEIVER_ALL;
    if (n.y < 0) {
        x = (l - fabsf(n.z)) * (n.x < 0 ? -1.0f : 1.0f);
        y = (l - fabsf(n.x)) * (n.z < 0 ? -1.0f : 1.0f);
    }
    x = (x / l + 1) * (PTI_RECEIVER_GRID / 2);
    y = (y / l + 1) * (PTI_RECEIVER_GRID / 2);
    return (int)pti_clamp(y, 0, PTI_RECEIVER_GRID - 1) * PTI_RECEIVER_GRID + (int)pti_clamp(x, 0, PTI_RECEIVER_GRID - 1);
}
static pt_vec3 pti_environment_normal(int receiver) {    /* the middle one; zero: from all around */
    float x = ((float)(receiver % PTI_RECEIVER_GRID) + 0.5f) / (PTI_RECEIVER_GRID / 2) - 1;
    float z = ((float)(receiver / PTI_RECEIVER_GRID) + 0.5f) / (PTI_RECEIVER_GRID / 2) - 1, y = 1 - fabsf(x) - fabsf(z);
    float fold = pti_max(-y, 0);
    if (receiver == PTI_RECEIVER_ALL) return pt_v3(0, 0, 0);
    return pti_normalize(pt_v3(x < 0 ? x + fold : x - fold, y, z < 0 ? z + fold : z - fold));
}
/* Luminance of what falls on a surface with the normal n that nothing shades; n zero: from all around, without a cosine.
   0 of a constant environment, whose density has nothing to draw. */
static float pti_environment_irradiance(const pti_environment *e, pt_vec3 n) {
    return e->irradiance ? e->irradiance[pti_environment_receiver(n)] : 0.0f;
}
static const float *pti_environment_parts(const pti_environment *e, int receiver) {
    return e->receivers + (size_t)receiver * ((size_t)e->part_count + 1);
}
static size_t pti_environment_field_size(const pti_environment *e) {   /* in numbers */
    return (size_t)e->down + 1 + (size_t)e->down * ((size_t)e->across + 1);
}
static pti_table2 pti_environment_field(const pti_environment *e, int field) {
    pti_table2 t;
    t.width = e->across; t.height = e->down;
    t.rows = e->fields + (size_t)field * pti_environment_field_size(e);
    t.cells = t.rows + e->down + 1;
    return t;
}
/* Which of n parts u in [0,1) draws, or groups of `step` parts; *u becomes the place within it. */
static int pti_parts_find(const float *parts, int n, int step, float *u) {
    double begin = (double)parts[0], t = begin + ((double)parts[n * step] - begin) * (double)*u, width;
    int lo = 0, hi = n;
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if ((double)parts[mid * step] <= t) lo = mid; else hi = mid;
    }
    width = (double)parts[(lo + 1) * step] - (double)parts[lo * step];
    *u = width > 0 ? pti_clamp((float)((t - (double)parts[lo * step]) / width), 0, 1 - FLT_EPSILON / 2) : 0.5f;
    return lo;
}
/* u decides between map and suns first; then v draws a row of fields and one of the cells in it, u the columns. */
static int pti_environment_sample(const pti_environment *e, int receiver, uint32_t u, float v, pt_vec3 *wi, pti_on_map *at) {
    const float *parts = pti_environment_parts(e, receiver);
    pti_table2 field;
    float x, y;
    int row, column;
    if (e->sun_count && !pti_split(&u, parts[e->field_count])) {
        x = pti_u01(u);
        column = pti_parts_find(parts + e->field_count, (int)e->sun_count, 1, &x);
        return pti_sun_sample(e->suns + column, x, v, wi);
    }
    x = pti_u01(u);
    row = pti_parts_find(parts, PTI_ENVIRONMENT_DOWN, PTI_ENVIRONMENT_ACROSS, &v);
    column = pti_parts_find(parts + row * PTI_ENVIRONMENT_ACROSS, PTI_ENVIRONMENT_ACROSS, 1, &x);
    field = pti_environment_field(e, row * PTI_ENVIRONMENT_ACROSS + column);
    pti_sample_table2(&field, x, v, &x, &y);
    x = (x + (float)column) / PTI_ENVIRONMENT_ACROSS;
    y = (y + (float)row) / PTI_ENVIRONMENT_DOWN;
    *wi = pti_normalize(pti_environment_turn(e, pti_uv_to_direction(x, y), 1));
    at->known = 1; at->u = x; at->v = y;
    return 1;
}
static float pti_environment_pdf_map(const pti_environment *e, const float *parts, pt_vec3 wi, pti_on_map *at) {
    float u, v, sine = pti_max(sqrtf(wi.x * wi.x + wi.z * wi.z), 1e-10f), p;
    pti_table2 field;
    int x, y, i;
    pti_environment_place(e, wi, at);
    u = at->u * PTI_ENVIRONMENT_ACROSS;
    v = at->v * PTI_ENVIRONMENT_DOWN;
    x = (int)pti_clamp(u, 0, PTI_ENVIRONMENT_ACROSS - 1);
    y = (int)pti_clamp(v, 0, PTI_ENVIRONMENT_DOWN - 1);
    i = y * PTI_ENVIRONMENT_ACROSS + x;
    field = pti_environment_field(e, i);
    p = pti_pdf_table2(&field, u - (float)x, v - (float)y) * (parts[i + 1] - parts[i]);
    return p * (PTI_ENVIRONMENT_ACROSS * PTI_ENVIRONMENT_DOWN) / (2 * PTI_PI * PTI_PI * sine);   /* over |d wi / d(u,v)| */
}
static float pti_environment_pdf(const pti_environment *e, int receiver, pt_vec3 wi, pti_on_map *at) {
    const float *parts = pti_environment_parts(e, receiver);
    float p = e->field_count ? pti_environment_pdf_map(e, parts, wi, at) : 0.0f;
    size_t i;
    parts += e->field_count;
    for (i = 0; i < e->sun_count; i++) p += (parts[i + 1] - parts[i]) * pti_sun_pdf(e->suns + i, wi);
    return p;
}

static void pti_environment_free(pti_environment *e, const pt_allocator *a) {
    size_t parts = (size_t)e->part_count + 1;
    pti_free(a, e->fields, (size_t)e->field_count * pti_environment_field_size(e), sizeof(float));
    pti_free(a, e->receivers, PTI_RECEIVERS * parts, sizeof(float));
    pti_free(a, e->irradiance, PTI_RECEIVERS, sizeof(float));
    e->fields = e->receivers = e->irradiance = NULL;
    pti_free(a, e->suns, e->sun_capacity, sizeof *e->suns);
}

/* How light comes from a part, for the receivers' tables: all its radiance, its mean direction by that, its solid angle. */
typedef struct pti_part { float power, angle; pt_vec3 axis; } pti_part;

/* The table of a field's cells holds integrals over the bilinear map, as it will be looked up, so it is 0 only where the
   map is. That map is a sum of tents, one texel wide to each side; a tent's integral up to x: */
static float pti_tent_integral(float x) {
    if (x <= -1 || x >= 1) return x < 0 ? 0.0f : 1.0f;
    return x < 0 ? 0.5f * (1 + x) * (1 + x) : 1 - 0.5f * (1 - x) * (1 - x);
}
/* A callback is looked at in the middles of 512 x 256 texels. */
static float pti_environment_texel(const pti_environment *e, int x, int y, int width, int height) {
    float l, u = ((float)x + 0.5f) / (float)width, v = ((float)y + 0.5f) / (float)height;
    l = pti_luminance(e->texture ? pti_mul(e->color, pti_texel(e->texture, x, y))
                                 : pti_mul(e->color, e->radiance(e->user, pti_uv_to_direction(u, v))));
    return l > 0 && l < FLT_MAX ? l : 0.0f;
}
/* Adds one row of texels to a row of n cells. */
static void pti_environment_add_row(const pti_environment *e, int y, int width, int height, float weight, float *cells,
                                    int n) {
    int i, j, first, last, at;
    float a, b, w;
    for (j = 0; j < n; j++) {
        a = (float)((double)j * width / n);
        b = (float)((double)(j + 1) * width / n);
        first = (int)floorf(a - 0.5f);
        last = (int)floorf(b + 0.5f);
        for (i = first; i <= last; i++) {
            w = pti_tent_integral(b - 0.5f - (float)i) - pti_tent_integral(a - 0.5f - (float)i);
            at = i < 0 ? i + width : i >= width ? i - width : i;
            if (w > 0) cells[j] += weight * w * pti_environment_texel(e, at, y, width, height);
        }
    }
}
/* Row r of n rows of cells: mean luminances. */
static void pti_environment_row(const pti_environment *e, int width, int height, int r, float *cells, int across,
                                int down) {
    float a = (float)((double)r * height / down), b = (float)((double)(r + 1) * height / down), w;
    int i, j, first = (int)floorf(a - 0.5f), last = (int)floorf(b + 0.5f);
    memset(cells, 0, (size_t)across * sizeof *cells);
    for (i = first; i <= last; i++) {
        w = pti_tent_integral(b - 0.5f - (float)i) - pti_tent_integral(a - 0.5f - (float)i);
        j = i < 0 ? 0 : i >= height ? height - 1 : i;
        if (w > 0)
            pti_environment_add_row(e, j, width, height, w * (float)across / ((float)width * (b - a)), cells, across);
    }
}
/* The tables of the fields in one row of them, from the luminances of their cells. */
static void pti_environment_field_row(pti_environment *e, int y, const float *cells, pti_part *part) {
    int i, j, x, n = PTI_ENVIRONMENT_ACROSS * e->across, all = PTI_ENVIRONMENT_DOWN * e->down;
    float sum[PTI_FIELD_CELLS], s, above, below;
    for (x = 0; x < PTI_ENVIRONMENT_ACROSS; x++, part++) {
        pti_table2 t = pti_environment_field(e, y * PTI_ENVIRONMENT_ACROSS + x);
        memset(part, 0, sizeof *part);
        pti_sincos((float)(y * e->down) / (float)all * PTI_PI, &s, &above);
        for (i = 0; i < e->down; i++, above = below) {
            const float *row = cells + i * n + x * e->across;
            float angle, u, v = ((float)(y * e->down + i) + 0.5f) / (float)all;
            pti_sincos((float)(y * e->down + i + 1) / (float)all * PTI_PI, &s, &below);
            angle = (above - below) * 2 * PTI_PI / (float)n;
            for (sum[i] = 0, j = 0; j < e->across; j++) {
                float power = row[j] * angle;
                sum[i] += power;
                u = ((float)(x * e->across + j) + 0.5f) / (float)n;
                if (power > 0) part->axis = pti_madd(pti_uv_to_direction(u, v), power, part->axis);
            }
            part->power += sum[i];
            part->angle += angle * (float)e->across;
            pti_table_build(t.cells + i * (e->across + 1), row, e->across);
        }
        pti_table_build(t.rows, sum, e->down);
        if (part->power > 0) part->axis = pti_environment_turn(e, pti_scale(part->axis, 1 / part->power), 1);
    }
}
static pti_part pti_sun_part(const pti_sun *s) {
    pti_part p;
    p.angle = 2 * PTI_PI * s->one_minus_cos;
    p.power = p.angle * pti_luminance(s->radiance);
    p.axis = pti_scale(s->axis, 1 - 0.5f * s->one_minus_cos);
    return p;
}
static float pti_part_cosine(const pti_part *p, pt_vec3 n) {
    float c = pti_dot(p->axis, n), spread = 1 - pti_dot(p->axis, p->axis) + PTI_RECEIVER_SPREAD;
    return pti_is_zero3(n) ? 1.0f : 0.5f * (c + sqrtf(c * c + pti_max(spread, 0)));
}
/* The table of a receiver; value is room for as many numbers as there are parts. */
static void pti_environment_receive(pti_environment *e, int receiver, const pti_part *part, float *value) {
    pt_vec3 n = pti_environment_normal(receiver);
    float sum = 0, most;
    int i;
    for (i = 0; i < e->part_count; i++) sum += value[i] = part[i].power * pti_part_cosine(part + i, n);
    e->irradiance[receiver] = sum;
    most = PTI_COMPENSATION * sum / (pti_is_zero3(n) ? 4 * PTI_PI : PTI_PI);
    for (i = 0; i < e->part_count; i++)
        if (part[i].power > 0) value[i] *= pti_max(1 - most * part[i].angle / part[i].power, PTI_COMPENSATION_LEAST);
    pti_table_build(e->receivers + (size_t)receiver * ((size_t)e->part_count + 1), value, e->part_count);
}
static int pti_environment_cells(int pixels, int fields) {
    int n = 1;
    while (n < PTI_FIELD_CELLS && n * fields < pixels) n *= 2;
    return n;
}
/* Fields, band after band of them; cells is room for the luminances of one. */
static void pti_environment_build_fields(pti_environment *e, int width, int height, float *cells, pti_part *part) {
    int i, r, n = PTI_ENVIRONMENT_ACROSS * e->across;
    double sum = 0;
    for (i = 0; i < PTI_ENVIRONMENT_DOWN; i++) {
        for (r = 0; r < e->down; r++)
            pti_environment_row(e, width, height, i * e->down + r, cells + r * n, n, PTI_ENVIRONMENT_DOWN * e->down);
        pti_environment_field_row(e, i, cells, part + i * PTI_ENVIRONMENT_ACROSS);
    }
    for (i = 0; i < e->field_count; i++) sum += (double)part[i].power;
    e->mean = (float)(sum / (4 * 3.141592653589793));
}
static int pti_environment_build(pti_environment *e, const pt_allocator *a) {      /* 0 when out of memory */
    int width = e->texture ? e->texture->width : 512, height = e->texture ? e->texture->height : 256, i, fine;
    size_t cells;
    pti_part *part;
    float *cell, *value;
    e->mean = pti_luminance(e->color);
    e->across = pti_environment_cells(e->texture ? width : width / 2, PTI_ENVIRONMENT_ACROSS);
    e->down = pti_environment_cells(e->texture ? height : height / 2, PTI_ENVIRONMENT_DOWN);
    e->field_count = e->textured ? PTI_ENVIRONMENT_ACROSS * PTI_ENVIRONMENT_DOWN : 0;
    e->part_count = e->field_count + (int)e->sun_count;
    if (!e->part_count) return 1;
    cells = (size_t)PTI_ENVIRONMENT_ACROSS * (size_t)e->across * (size_t)e->down;
    e->fields = (float *)pti_alloc(a, (size_t)e->field_count * pti_environment_field_size(e), sizeof(float));
    e->receivers = (float *)pti_alloc(a, PTI_RECEIVERS * ((size_t)e->part_count + 1), sizeof(float));
    e->irradiance = (float *)pti_alloc(a, PTI_RECEIVERS, sizeof(float));
    part = (pti_part *)pti_alloc(a, (size_t)e->part_count, sizeof *part);
    value = (float *)pti_alloc(a, (size_t)e->part_count, sizeof *value);
    cell = (float *)pti_alloc(a, cells, sizeof *cell);
    fine = (e->fields || !e->field_count) && e->receivers && e->irradiance && part && value && cell;
    if (fine) {
        if (e->field_count) pti_environment_build_fields(e, width, height, cell, part);
        for (i = 0; i < (int)e->sun_count; i++) part[e->field_count + i] = pti_sun_part(e->suns + i);
        for (i = 0; i < PTI_RECEIVERS; i++) pti_environment_receive(e, i, part, value);
    }
    pti_free(a, part, (size_t)e->part_count, sizeof *part);
    pti_free(a, value, (size_t)e->part_count, sizeof *value);
    pti_free(a, cell, cells, sizeof *cell);
    return fine;
}

/* ---- >>scene -------------------------------------------------------------------------------------------
   Where all that comes in is checked and kept. Nothing below this chapter meets an index out of range, nor a
   NaN but what a callback returns. */

typedef struct pti_albedo_list { pti_albedo albedo; struct pti_albedo_list *next; } pti_albedo_list;

#define PTI_FIRES 16
#define PTI_FIRE_SHARE 0.4f                              /* of the mixture, at most */
typedef struct pti_fire { pt_vec3 p; float radius, power; } pti_fire;    /* what glows in a volume, and a ball about it */
typedef struct pti_fires { const struct pt_scene *scene; int count; pti_fire all[PTI_FIRES + 1]; } pti_fires;
typedef struct pti_filling { uint32_t shape, medium; } pti_filling;        /* ids; shape 0 = everywhere */

struct pt_scene {
    pt_allocator allocator;
    pti_error error;
    int committed, isa, threads;
    pt_quality quality;
    pti_geometry geometry;
    pti_material *materials;    size_t material_count, material_capacity;
    pti_texture *textures;      size_t texture_count, texture_capacity;
    pti_measured *measured;     size_t measured_count, measured_capacity;
    float *decode[3];                                    /* what 256 values mean, linear and sRGB, and 65536 sRGB ones; each
                                                            NULL until a texture uses it */
    pti_medium *media;          size_t medium_count, medium_capacity;
    pti_material *particles;                             /* one of each medium */
    pti_filling *fillings;      size_t filling_count, filling_capacity;
    pti_volumes volumes;
    pti_fires fires;
    pt_density_desc *densities; size_t density_count, density_capacity;
    float density_weight;                                /* sum over densities, at most 0.95 */
    pti_albedo_list *albedos;
    pti_spectrum spectrum;
    pti_lights lights;
    pti_environment environment;
    pt_texture environment_texture;
    uint32_t light_count;                                /* added by pt_add_light */
    int has_spots;
};

#define PTI_MAX_COORDINATE 1e12f
#define PTI_DEFAULT_MATERIAL 0u                          /* slot 0: grey, for shapes whose material is none */

static int pti_in_range(float x) { return fabsf(x) <= PTI_MAX_COORDINATE; }   /* false for NaN */
static int pti_in_range3(pt_vec3 v) { return pti_in_range(v.x) && pti_in_range(v.y) && pti_in_range(v.z); }

/* May this call change the scene? */
static int pti_scene_open(pt_scene *s, const char *call, const void *argument) {
    if (!s) return 0;
    if (s->committed) {
        pti_fail(&s->error, PT_ERR_STATE, "%s: the scene is committed, and read-only from then on", call);
        return 0;
    }
    if (!argument) { pti_fail(&s->error, PT_ERR_ARG, "%s: NULL instead of a description", call); return 0; }
    return s->error.code == PT_OK;
}
static int pti_check(pt_scene *s, int fine, const char *call, const char *what, float value) {
    if (!fine) pti_fail(&s->error, PT_ERR_ARG, "%s: %s (it is %g)", call, what, (double)value);
    return fine;
}
static int pti_require(pt_scene *s, int fine, const char *call, const char *else_why) {
    if (!fine) pti_fail(&s->error, PT_ERR_ARG, "%s: %s", call, else_why);
    return fine;
}
static int pti_check3(pt_scene *s, int fine, const char *call, const char *what, pt_vec3 v) {
    if (!fine)
        pti_fail(&s->error, PT_ERR_ARG, "%s: %s (it is %g %g %g)", call, what, (double)v.x, (double)v.y, (double)v.z);
    return fine;
}
static int pti_check_id(pt_scene *s, uint32_t id, size_t count, const char *call, const char *what) {
    if (id <= count) return 1;
    pti_fail(&s->error, PT_ERR_ARG, "%s: %s %u does not exist, there are %u", call, what, (uint64_t)id, (uint64_t)count);
    return 0;
}
/* A new zeroed slot at the end of one of the scene's arrays, or NULL. */
static void *pti_scene_slot(pt_scene *s, void **array, size_t *count, size_t *capacity, size_t size) {
    if (*count >= PTI_INDEX(PTI_NONE) || !pti_grow(&s->allocator, array, *count, capacity, size)) {
        pti_fail(&s->error, PT_ERR_MEMORY, "out of memory for the scene");
        return NULL;
    }
    return (char *)*array + (*count)++ * size;
}

static void pti_measured_free(pti_measured *m, const pt_allocator *a) {
    pti_free(a, m->values, pti_measured_values(m), sizeof(float));
    pti_free(a, m->edges, (size_t)m->bins + 1, sizeof(float));
    pti_free(a, m->tables, PTI_MEASURED_ROWS * pti_measured_table(m), sizeof(float));
}
static void pti_volumes_free(pti_volumes *v, const pt_allocator *a) {
    pti_geometry *g;
    size_t i;
    for (i = 0; i < v->count; i++) {
        pti_volume *one = v->all + i;
        if (one->owns_majorants)
            pti_free(a, (void *)(uintptr_t)one->majorants, pti_count3(one->cells), sizeof(float));
        if (!one->owns_bounds) continue;
        g = (pti_geometry *)(uintptr_t)one->bounds;
        pti_bvh_free(&g->bvh, a);
        pti_free(a, g->shapes, g->shape_capacity, sizeof(pti_shape));
        pti_free(a, g, 1, sizeof *g);
    }
    pti_bvh_free(&v->tree.bvh, a);
    pti_free(a, v->tree.shapes, v->tree.shape_capacity, sizeof(pti_shape));
    pti_free(a, v->all, v->capacity, sizeof(pti_volume));
}
static void pti_media_free(pt_scene *s) {
    const pt_allocator *a = &s->allocator;
    size_t i;
    for (i = 0; i < s->medium_count; i++) {
        pti_medium *m = s->media + i;
        if (m->owned) pti_free(a, (void *)(uintptr_t)m->grid, (size_t)m->channels * pti_count3(m->n), sizeof(float));
        pti_free(a, m->majorants, pti_count3(m->cells), sizeof(float));
    }
    pti_free(a, s->particles, s->medium_count, sizeof(pti_material));
    pti_free(a, s->media, s->medium_capacity, sizeof(pti_medium));
    pti_free(a, s->fillings, s->filling_capacity, sizeof(pti_filling));
}
PT_DEF void pt_scene_destroy(pt_scene *s) {
    pt_allocator a;
    size_t i;
    if (!s) return;
    a = s->allocator;
    for (i = 0; i < s->geometry.shape_count; i++) {
        pti_shape *shape = s->geometry.shapes + i;
        pti_mesh *m = &shape->as.mesh;
        if (shape->kind == PTI_INSTANCE) pti_free(&a, shape->as.instance.to_world_end, 1, sizeof(pt_xform));
        if (shape->kind != PTI_MESH) continue;
        pti_free(&a, m->materials, shape->count, sizeof(uint32_t));
        if (!m->owned) continue;
        pti_free(&a, (void *)(uintptr_t)m->positions, m->vertex_count, 3 * sizeof(float));
        pti_free(&a, (void *)(uintptr_t)m->normals, m->vertex_count, 3 * sizeof(float));
        pti_free(&a, (void *)(uintptr_t)m->uvs, m->vertex_count, 2 * sizeof(float));
        pti_free(&a, (void *)(uintptr_t)m->indices, (size_t)shape->count * 3, sizeof(uint32_t));
    }
    for (i = 0; i < s->texture_count; i++) {
        pti_texture *t = s->textures + i;
        if (t->owned) pti_free(&a, (void *)(uintptr_t)t->pixels, pti_texture_count(t), pti_texture_size(t));
    }
    for (i = 0; i < s->measured_count; i++) pti_measured_free(s->measured + i, &a);
    while (s->albedos) {
        pti_albedo_list *next = s->albedos->next;
        pti_free(&a, s->albedos, 1, sizeof *next);
        s->albedos = next;
    }
    for (i = 0; i < 3; i++) pti_free(&a, s->decode[i], i < 2 ? 256 : 65536, sizeof(float));
    pti_bvh_free(&s->geometry.bvh, &a);
    pti_environment_free(&s->environment, &a);
    pti_volumes_free(&s->volumes, &a);
    pti_media_free(s);
    pti_free(&a, s->geometry.shapes, s->geometry.shape_capacity, sizeof(pti_shape));
    pti_free(&a, s->materials, s->material_capacity, sizeof(pti_material));
    pti_free(&a, s->textures, s->texture_capacity, sizeof(pti_texture));
    pti_free(&a, s->measured, s->measured_capacity, sizeof(pti_measured));
    pti_free(&a, s->densities, s->density_capacity, sizeof(pt_density_desc));
    pti_free(&a, s->lights.emitters, s->lights.capacity, sizeof(pti_emitter));
    pti_free(&a, s->lights.nodes, s->lights.node_capacity, sizeof(pti_light_node));
    pti_free(&a, s, 1, sizeof *s);
}
PT_DEF const char *pt_scene_error(const pt_scene *s) { return s ? s->error.text : "out of memory for the scene"; }

/* ---- materials, textures, densities */

static pti_material *pti_material_slot(pt_scene *s) {
    void *array = s->materials;
    pti_material *m = (pti_material *)pti_scene_slot(s, &array, &s->material_count, &s->material_capacity, sizeof *m);
    s->materials = (pti_material *)array;
    return m;
}
static int pti_is_unit(float x) { return x >= 0 && x <= 1; }         /* false for NaN */
static int pti_is_unit3(pt_vec3 c) { return pti_is_unit(c.x) && pti_is_unit(c.y) && pti_is_unit(c.z); }
static int pti_check_material_textures(pt_scene *s, const pt_material_desc *d) {
    const char *call = "pt_add_material";
#define PTI_CHECK(name) if (!pti_check_id(s, d->name##_texture.id, s->texture_count, call, #name "_texture")) return 0;
    PTI_TEXTURES(PTI_CHECK)
#undef PTI_CHECK
    return 1;
}
static int pti_check_material_numbers(pt_scene *s, const pt_material_desc *d) {
    const char *call = "pt_add_material";
#define PTI_CHECK(name) if (!pti_check(s, pti_is_unit(d->name), call, #name " must be between 0 and 1", d->name)) return 0;
    PTI_NUMBERS(PTI_CHECK)
    PTI_CHECK(sheen_roughness)
    PTI_CHECK(transparency)
#undef PTI_CHECK
    return pti_check(s, d->ior == 0 || (d->ior >= 0.01f && d->ior <= 100), call, "ior must be 0.01 to 100, or 0 for 1.5", d->ior)
        && pti_check(s, d->coat_ior == 0 || (d->coat_ior >= 1 && d->coat_ior <= 100), call,
                     "coat_ior must be 1 to 100, or 0 for 1.5", d->coat_ior)
        && pti_check(s, d->abbe == 0 || (d->abbe >= 1 && d->abbe <= 1e6f), call,
                     "abbe must be 1 to 1e6, or 0 for none", d->abbe)
        && pti_check(s, fabsf(d->rotation_deg) <= 36000, call, "rotation_deg must be within 36000", d->rotation_deg)
        && pti_check(s, pti_in_range(d->bump), call, "bump must be finite and below 1e12", d->bump)
        && pti_check3(s, d->eta.x >= 0 && d->eta.y >= 0 && d->eta.z >= 0 && pti_largest(d->eta) <= 1000, call,
                      "eta must be between 0 and 1000", d->eta)
        && pti_check3(s, d->k.x >= 0 && d->k.y >= 0 && d->k.z >= 0 && pti_largest(d->k) <= 1000, call,
                      "k must be between 0 and 1000", d->k);
}
static int pti_check_material(pt_scene *s, const pt_material_desc *d) {
    const char *call = "pt_add_material";
    pt_vec3 e = d->emission;
    return pti_check(s, d->bsdf >= PT_BSDF_DIFFUSE && d->bsdf <= PT_BSDF_USER, call, "bsdf is no pt_bsdf", (float)(int)d->bsdf)
        && pti_check3(s, pti_is_unit3(d->color), call, "color must be between 0 and 1", d->color)
        && pti_check3(s, pti_is_unit3(d->sheen_color), call, "sheen_color must be between 0 and 1", d->sheen_color)
        && pti_check3(s, e.x >= 0 && e.y >= 0 && e.z >= 0 && pti_in_range3(e), call,
                      "emission must be between 0 and 1e12", e)
        && pti_check_material_numbers(s, d) && pti_check_material_textures(s, d)
        && pti_check_id(s, d->a.id, s->material_count - 1, call, "a, a material,")
        && pti_check_id(s, d->b.id, s->material_count - 1, call, "b, a material,")
        && pti_check_id(s, d->measured.id, s->measured_count, call, "measured")
        && pti_check_id(s, d->inside.id, s->medium_count, call, "inside, a medium,")
        && pti_require(s, d->bsdf != PT_BSDF_MEASURED || d->measured.id, call, "PT_BSDF_MEASURED needs measured")
        && pti_require(s, d->bsdf != PT_BSDF_USER || (d->vtable && d->vtable->eval && d->vtable->pdf && d->vtable->sample),
                       call, "PT_BSDF_USER needs a vtable with eval, pdf and sample");
}
/* Zeros become what they stand for, so that textures and callbacks meet plain numbers. */
static void pti_material_defaults(pt_material_desc *d) {
    pt_vec3 white = pt_v3(1, 1, 1);
    if (d->ior == 0) d->ior = 1.5f;
    if (d->coat_ior == 0) d->coat_ior = 1.5f;
    if (d->specular == 0 && !d->specular_texture.id) d->specular = 1;
    if (d->sheen_roughness == 0) d->sheen_roughness = 0.5f;
    if (pti_is_zero3(d->sheen_color) && !d->sheen_color_texture.id) d->sheen_color = white;
    if ((d->bsdf == PT_BSDF_DIELECTRIC || d->bsdf == PT_BSDF_MEASURED) && pti_is_zero3(d->color) && !d->color_texture.id)
        d->color = white;
}
/* What the renderer asks before it looks at numbers. A mix is what its parts are. */
static void pti_material_flags(pti_material *m, const pti_material *all) {
    const pt_material_desc *d = &m->desc;
    const pti_material *a = all + d->a.id, *b = all + d->b.id;
    int opaque = d->transparency == 0 && !d->opacity_texture.id && !d->shade, mix = d->bsdf == PT_BSDF_MIX;
#define PTI_ANY(name) || d->name##_texture.id
    m->varies = d->shade != NULL PTI_TEXTURES(PTI_ANY);
#undef PTI_ANY
    m->emits = d->emission.x > 0 || d->emission.y > 0 || d->emission.z > 0 || d->emission_texture.id
        || (mix && (a->emits || b->emits));
    m->glows = m->emits && !m->varies && opaque && !mix;
    m->two_sided = d->two_sided || (mix && (a->two_sided || b->two_sided));
    m->plain = d->bsdf == PT_BSDF_DIFFUSE && !m->varies && opaque && d->roughness == 0 && d->translucency == 0;
    m->disperses = (d->abbe > 0 && (d->bsdf == PT_BSDF_DIELECTRIC || d->bsdf == PT_BSDF_PRINCIPLED))
        || (mix && (a->disperses || b->disperses));
    m->wants_coordinates = m->varies || d->bsdf == PT_BSDF_USER || d->roughness_y > 0
        || (mix && (a->wants_coordinates || b->wants_coordinates));
    m->wants_choice = mix ? a->wants_choice || b->wants_choice : d->bsdf == PT_BSDF_USER || d->bsdf == PT_BSDF_PRINCIPLED
        || d->bsdf == PT_BSDF_MEASURED || ((d->bsdf == PT_BSDF_CONDUCTOR || d->bsdf == PT_BSDF_DIELECTRIC)
                                           && (m->varies || !pti_smooth(pti_roughest(d))));
    m->lobes = (opaque ? 0 : 1) + (mix ? a->lobes + b->lobes : d->bsdf == PT_BSDF_PRINCIPLED ? 7
        : d->bsdf == PT_BSDF_DIFFUSE ? 2 : 1);
    if (d->bsdf == PT_BSDF_PRINCIPLED && !d->shade) {    /* fuzz, coat, glass and what shines through are often not there */
        m->lobes -= (d->sheen == 0 && !d->sheen_texture.id) + (d->coat == 0 && !d->coat_texture.id)
            + (d->transmission == 0 && !d->transmission_texture.id) + (d->translucency == 0 && !d->translucency_texture.id);
    }
}
PT_DEF pt_material pt_add_material(pt_scene *s, const pt_material_desc *d) {
    pt_material id = { 0 };
    pti_material *m;
    if (!pti_scene_open(s, "pt_add_material", d) || !pti_check_material(s, d)) return id;
    m = pti_material_slot(s);
    if (!m) return id;
    m->desc = *d;
    if (d->bsdf == PT_BSDF_USER) m->vtable = *d->vtable;
    pti_material_defaults(&m->desc);
    pti_material_flags(m, s->materials);
    if (!pti_require(s, m->lobes <= PTI_LOBES, "pt_add_material",
                     "too many lobes: a mix has room for 16 (two or three principled materials)")) return id;
    id.id = (uint32_t)(s->material_count - 1);           /* slot 0 is taken, so ids begin at 1 */
    return id;
}

PT_DEF pt_scene *pt_scene_create(const pt_scene_desc *desc) {
    pt_allocator a = { NULL, NULL, NULL };
    pti_material *grey;
    pt_scene *s;
#ifndef PT_ALLOW_FAST_MATH
    pti_fpmode mode;
    int fuses;
#endif
    if (desc) a = desc->allocator;
    a = pti_allocator_or_default(a);
    s = (pt_scene *)pti_alloc(&a, 1, sizeof *s);
    if (!s) return NULL;
    s->allocator = a;
    if (desc) {
        s->error.logger = desc->logger; s->lights.choose = desc->choose;
        s->threads = desc->threads; s->quality = desc->quality;
    }
    grey = pti_material_slot(s);
    if (!grey) { pt_scene_destroy(s); return NULL; }
    grey->desc.color = pt_v3(0.5f, 0.5f, 0.5f);
    pti_material_flags(grey, s->materials);
    pti_check(s, s->lights.choose >= PT_CHOOSE_TREE && s->lights.choose <= PT_CHOOSE_UNIFORM, "pt_scene_create",
              "choose is no pt_light_choice", (float)(int)s->lights.choose);
    pti_check(s, s->quality >= PT_QUALITY_DEFAULT && s->quality <= PT_QUALITY_BEST, "pt_scene_create", "quality is no pt_quality",
              (float)(int)s->quality);
    pti_check(s, s->threads >= 0 && s->threads <= 4096, "pt_scene_create", "threads must be 0 to 4096", (float)s->threads);
#ifndef PT_ALLOW_FAST_MATH
    mode = pti_fpmode_enter();
    fuses = pti_fuses();
    pti_fpmode_leave(mode);
    if (fuses)
        pti_fail(&s->error, PT_ERR_STATE, "pt.h was compiled with -ffp-contract=fast, which breaks equal bits and tight "
                 "meshes: compile it without, or define PT_ALLOW_FAST_MATH");
#endif
    return s;
}

/* ---- textures */

static int pti_check_pixels(pt_scene *s, const pt_texture_desc *d) {
    size_t i, row = (size_t)d->width * (size_t)d->channels, n = row * (size_t)d->height;
    const float *p = (const float *)d->pixels;
    if (d->bits != 32) return 1;
    for (i = 0; i < n; i++) {
        if (pti_finite(p[i])) continue;
        pti_fail(&s->error, PT_ERR_ARG, "pt_add_texture: pixel (%u, %u) is not finite: %g",
                 (uint64_t)(i % row / (size_t)d->channels), (uint64_t)(i / row), (double)p[i]);
        return 0;
    }
    return 1;
}
static int pti_check_picture(pt_scene *s, const pt_texture_desc *d, const char *call) {
    return pti_check(s, d->bits == 0 || d->bits == 8 || d->bits == 16 || d->bits == 32, call,
                     "bits must be 8, 16 or 32, or 0 for 8", (float)d->bits)
        && pti_check(s, d->width > 0 && d->width <= 65536, call, "width must be 1 to 65536", (float)d->width)
        && pti_check(s, d->height > 0 && d->height <= 65536, call, "height must be 1 to 65536", (float)d->height)
        && pti_check(s, d->channels >= 1 && d->channels <= 4, call, "channels must be 1 to 4", (float)d->channels)
        && pti_require(s, (uint64_t)d->width * (uint64_t)d->height <= SIZE_MAX / 16, call,
                       "more pixels than memory can hold")
        && pti_check_pixels(s, d);
}
static int pti_check_view(pt_scene *s, const pt_texture_desc *d, const char *call) {
    return pti_check_id(s, d->of.id, s->texture_count, call, "of: texture")
        && pti_check(s, s->textures[d->of.id - 1].pixels != NULL, call, "of: that texture has no pixels", (float)d->of.id)
        && pti_require(s, !d->width && !d->height && !d->channels && !d->bits, call,
                       "width, height, channels and bits come along with of: leave them 0");
}
static int pti_check_pattern(pt_scene *s, const pt_texture_desc *d, const char *call) {
    return pti_check(s, d->octaves >= 0 && d->octaves <= 16, call, "octaves must be 1 to 16, or 0 for 5", (float)d->octaves)
        && pti_check(s, d->frequency >= 0 && pti_in_range(d->frequency), call,
                     "frequency must be between 0 and 1e12", d->frequency)
        && pti_check3(s, pti_in_range3(d->color_a), call, "color_a must be finite and below 1e12", d->color_a)
        && pti_check3(s, pti_in_range3(d->color_b), call, "color_b must be finite and below 1e12", d->color_b);
}
/* What all kinds have; channels and bits as they come out. */
static int pti_check_look(pt_scene *s, const pt_texture_desc *d, int channels, int bits, const char *call) {
    const float *scale = d->uv_scale, *offset = d->uv_offset;
    pt_wrap u = d->wrap_u, v = d->wrap_v;
    return pti_check(s, d->channel >= 0 && d->channel <= channels, call, "channel: there is no such one", (float)d->channel)
        && pti_check(s, !d->srgb || bits != 32, call, "srgb is for 8 and 16 bits", (float)d->srgb)
        && pti_check(s, u >= PT_WRAP_REPEAT && u <= PT_WRAP_MIRROR, call, "wrap_u is no pt_wrap", (float)u)
        && pti_check(s, v >= PT_WRAP_REPEAT && v <= PT_WRAP_MIRROR, call, "wrap_v is no pt_wrap", (float)v)
        && pti_check(s, pti_in_range(scale[0]), call, "uv_scale[0] must be finite and below 1e12", scale[0])
        && pti_check(s, pti_in_range(scale[1]), call, "uv_scale[1] must be finite and below 1e12", scale[1])
        && pti_check(s, pti_in_range(offset[0]), call, "uv_offset[0] must be finite and below 1e12", offset[0])
        && pti_check(s, pti_in_range(offset[1]), call, "uv_offset[1] must be finite and below 1e12", offset[1])
        && pti_check(s, fabsf(d->uv_rotate_deg) <= 36000, call, "uv_rotate_deg must be within 36000", d->uv_rotate_deg);
}
static int pti_check_texture(pt_scene *s, const pt_texture_desc *d) {
    const char *call = "pt_add_texture";
    const pti_texture *base;
    int kinds = (d->pixels != NULL) + (d->of.id != 0) + (d->pattern != PT_PATTERN_NONE) + (d->eval != NULL);
    if (!pti_require(s, kinds > 0, call, "pixels is NULL, and there is no of, pattern or eval")
        || !pti_require(s, kinds == 1, call, "pixels, of, pattern and eval: only one of them")
        || !pti_check(s, d->pattern >= PT_PATTERN_NONE && d->pattern <= PT_PATTERN_FBM, call, "pattern is no pt_pattern",
                      (float)d->pattern)) return 0;
    if (d->pixels) return pti_check_picture(s, d, call) && pti_check_look(s, d, d->channels, d->bits, call);
    if (!d->of.id) return pti_check_pattern(s, d, call) && pti_check_look(s, d, 3, 0, call);
    if (!pti_check_view(s, d, call)) return 0;
    base = s->textures + (d->of.id - 1);
    return pti_check_look(s, d, base->channels, base->bits, call);
}
/* The scene's table of what integers of 8 or 16 bits mean, made when it is first wanted. (The one for 16 bits is a quarter
   of a megabyte, and spares 12 powers a look, each of which would take as long as the rest of it.) 0 when out of memory. */
static int pti_decode_table(pt_scene *s, int bits, int srgb, const float **out) {
    int i, n = bits == 16 ? 65536 : 256, k = bits == 16 ? 2 : srgb;
    float *table = s->decode[k];
    if (bits == 32 || (bits == 16 && !srgb)) return 1;
    if (!table) {
        table = s->decode[k] = (float *)pti_alloc(&s->allocator, (size_t)n, sizeof(float));
        if (!table) return 0;
        for (i = 0; i < n; i++) {
            float x = (float)i / (float)(n - 1);
            table[i] = srgb ? pti_srgb_decode(x) : x;
        }
    }
    *out = table;
    return 1;
}
static int pti_texture_take_pixels(pt_scene *s, pti_texture *t, const pt_texture_desc *d) {     /* 0 when out of memory */
    int is_alpha;
    if (d->of.id) {
        const pti_texture *base = s->textures + (d->of.id - 1);
        t->width = base->width; t->height = base->height; t->channels = base->channels; t->bits = base->bits;
        t->pixels = base->pixels;
    } else {
        void *copy;
        t->width = d->width; t->height = d->height; t->channels = d->channels; t->bits = d->bits ? d->bits : 8;
        copy = pti_alloc(&s->allocator, pti_texture_count(t), pti_texture_size(t));
        if (!copy) return 0;
        memcpy(copy, d->pixels, pti_texture_count(t) * pti_texture_size(t));
        t->pixels = copy;
        t->owned = 1;
    }
    t->picked = t->grey;
    t->grey = t->grey || t->channels < 3;
    is_alpha = t->channels % 2 == 0 && t->first == t->channels - 1;            /* which is linear */
    return pti_decode_table(s, t->bits, 0, &t->decode_alpha)
        && pti_decode_table(s, t->bits, d->srgb && !is_alpha, &t->decode);
}
static void pti_texture_init(pti_texture *t, const pt_texture_desc *d) {       /* all but the pixels */
    t->eval = d->eval; t->user = d->user;
    t->first = d->channel ? d->channel - 1 : 0;
    t->grey = d->channel != 0;
    t->wrap_u = d->wrap_u; t->wrap_v = d->wrap_v; t->nearest = d->nearest;
    pti_texture_place(t, d->uv_scale, d->uv_rotate_deg, d->uv_offset);
    t->pattern = d->pattern; t->solid = d->pattern && d->solid;
    t->frequency = d->frequency > 0 ? d->frequency : 1.0f;
    t->octaves = d->octaves ? d->octaves : 5;
    t->color_a = d->color_a; t->color_b = d->color_b;
    if (pti_is_zero3(d->color_a) && pti_is_zero3(d->color_b)) t->color_b = pt_v3(1, 1, 1);
}
PTI_NOINLINE pt_texture pti_add_texture_ieee(pt_scene *s, const pt_texture_desc *d) {
    pt_texture id = { 0 };
    pti_texture *t;
    void *array;
    if (!pti_scene_open(s, "pt_add_texture", d) || !pti_check_texture(s, d)) return id;
    array = s->textures;
    t = (pti_texture *)pti_scene_slot(s, &array, &s->texture_count, &s->texture_capacity, sizeof *t);
    s->textures = (pti_texture *)array;
    if (!t) return id;
    pti_texture_init(t, d);
    if ((d->pixels || d->of.id) && !pti_texture_take_pixels(s, t, d)) {
        pti_fail(&s->error, PT_ERR_MEMORY, "pt_add_texture: out of memory for %d x %d pixels", t->width, t->height);
        return id;
    }
    id.id = (uint32_t)s->texture_count;
    return id;
}
PT_DEF pt_texture pt_add_texture(pt_scene *s, const pt_texture_desc *d) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_texture id = pti_add_texture_ieee(s, d);
    pti_fpmode_leave(mode);
    return id;
}

static int pti_check_measured(pt_scene *s, const pt_measured_desc *d, const pti_measured *m) {
    const char *call = "pt_add_measured";
    size_t i;
    if (!pti_require(s, d->values != NULL, call, "values is NULL")
        || !pti_check(s, m->cells_h >= 1 && m->cells_h <= PTI_MEASURED_CELLS, call, "cells_h must be 1 to 512, or 0 for 90",
                      (float)m->cells_h)
        || !pti_check(s, m->cells_d >= 1 && m->cells_d <= PTI_MEASURED_CELLS, call, "cells_d must be 1 to 512, or 0 for 90",
                      (float)m->cells_d)
        || !pti_check(s, m->cells_p >= 1 && m->cells_p <= PTI_MEASURED_CELLS, call, "cells_p must be 1 to 512, or 0 for 180",
                      (float)m->cells_p)) return 0;
    for (i = 0; i < pti_measured_values(m); i++) {
        size_t cell = i / 3, p = (size_t)m->cells_p, dp = p * (size_t)m->cells_d;
        if (pti_in_range(d->values[i])) continue;
        pti_fail(&s->error, PT_ERR_ARG, "%s: cell (%u, %u, %u) must be finite and below 1e12 (a channel is %g)", call,
                 (uint64_t)(cell / dp), (uint64_t)(cell % dp / p), (uint64_t)(cell % p), (double)d->values[i]);
        return 0;
    }
    return 1;
}
/* Copies the values and fits the density; 0 when out of memory. */
static int pti_measured_take(pti_measured *m, const pt_measured_desc *d, const pt_allocator *a) {
    size_t i, n = pti_measured_values(m);
    m->values = (float *)pti_alloc(a, n, sizeof(float));
    m->edges = (float *)pti_alloc(a, (size_t)m->bins + 1, sizeof(float));
    m->tables = (float *)pti_alloc(a, PTI_MEASURED_ROWS * pti_measured_table(m), sizeof(float));
    if (!m->values || !m->edges || !m->tables) return 0;
    for (i = 0; i < n; i++) m->values[i] = pti_max(d->values[i], 0);
    pti_measured_fit(m);
    return 1;
}
PT_DEF pt_measured pt_add_measured(pt_scene *s, const pt_measured_desc *d) {
    pt_measured id = { 0 };
    pti_measured m, *slot;
    pti_fpmode mode;
    void *array;
    int taken;
    if (!pti_scene_open(s, "pt_add_measured", d)) return id;
    memset(&m, 0, sizeof m);
    m.cells_h = d->cells_h ? d->cells_h : 90;
    m.cells_d = d->cells_d ? d->cells_d : 90;
    m.cells_p = d->cells_p ? d->cells_p : 180;
    m.bins = m.cells_h > PTI_MEASURED_BINS ? m.cells_h : PTI_MEASURED_BINS;
    if (!pti_check_measured(s, d, &m)) return id;
    array = s->measured;
    slot = (pti_measured *)pti_scene_slot(s, &array, &s->measured_count, &s->measured_capacity, sizeof *slot);
    s->measured = (pti_measured *)array;
    if (!slot) return id;
    mode = pti_fpmode_enter();
    taken = pti_measured_take(&m, d, &s->allocator);
    pti_fpmode_leave(mode);
    *slot = m;
    if (!taken) pti_fail(&s->error, PT_ERR_MEMORY, "pt_add_measured: out of memory for %d x %d x %d cells", m.cells_h, m.cells_d,
                         m.cells_p);
    else id.id = (uint32_t)s->measured_count;
    return id;
}

static int pti_check_extinction(pt_scene *s, pt_vec3 v, const char *what) {
    return pti_check3(s, v.x >= 0 && v.y >= 0 && v.z >= 0 && pti_in_range3(v), "pt_add_medium", what, v);
}
static int pti_check_phase(pt_scene *s, const pt_medium_desc *d) {
    const char *call = "pt_add_medium";
    return pti_check(s, d->phase >= PT_PHASE_HENYEY_GREENSTEIN && d->phase <= PT_PHASE_USER, call, "phase is no pt_phase",
                     (float)(int)d->phase)
        && pti_check(s, fabsf(d->g) <= 0.99f, call, "g must be within 0.99", d->g)
        && pti_check(s, fabsf(d->g2) <= 0.99f, call, "g2 must be within 0.99", d->g2)
        && pti_check(s, pti_is_unit(d->mix), call, "mix must be between 0 and 1", d->mix)
        && pti_check(s, d->alpha >= 0 && d->alpha <= 1e4f, call, "alpha must be between 0 and 1e4", d->alpha)
        && pti_check(s, d->droplet_um == 0 || (d->droplet_um >= 5 && d->droplet_um <= 50), call,
                     "droplet_um must be 5 to 50, or 0 for 20", d->droplet_um)
        && pti_require(s, d->phase != PT_PHASE_USER || (d->phase_pdf && d->phase_sample), call,
                       "PT_PHASE_USER needs phase_pdf and phase_sample")
        && pti_require(s, d->phase == PT_PHASE_USER || (!d->phase_pdf && !d->phase_sample), call,
                       "phase_pdf and phase_sample are for PT_PHASE_USER");
}
static int pti_check_grid(pt_scene *s, const pt_medium_desc *d) {
    const char *call = "pt_add_medium";
    size_t i, nx = (size_t)d->nx, ny = (size_t)d->ny, nz = (size_t)d->nz, n;
    if (!pti_check(s, d->nx >= 1 && d->nx <= 4096, call, "nx must be 1 to 4096", (float)d->nx)
        || !pti_check(s, d->ny >= 1 && d->ny <= 4096, call, "ny must be 1 to 4096", (float)d->ny)
        || !pti_check(s, d->nz >= 1 && d->nz <= 4096, call, "nz must be 1 to 4096", (float)d->nz)
        || !pti_check(s, d->grid_channels == 0 || d->grid_channels == 1 || d->grid_channels == 3, call,
                      "grid_channels must be 1 or 3", (float)d->grid_channels)
        || !pti_require(s, (uint64_t)d->nx * (uint64_t)d->ny * (uint64_t)d->nz <= SIZE_MAX / 16, call,
                        "more voxels than memory can hold")) return 0;
    n = nx * ny * nz * (d->grid_channels == 3 ? 3 : 1);
    for (i = 0; i < n; i++) {
        if (d->grid[i] >= 0 && pti_in_range(d->grid[i])) continue;
        pti_fail(&s->error, PT_ERR_ARG, "%s: voxel (%u, %u, %u) must be between 0 and 1e12 (it is %g)", call, (uint64_t)(i % nx),
                 (uint64_t)(i / nx % ny), (uint64_t)(i / nx / ny % nz), (double)d->grid[i]);
        return 0;
    }
    return 1;
}
static int pti_check_medium(pt_scene *s, const pt_medium_desc *d) {
    const char *call = "pt_add_medium";
    int marches = d->tracking != PT_TRACK_EXACT;
    return pti_check_extinction(s, d->sigma_a, "sigma_a must be between 0 and 1e12")
        && pti_check_extinction(s, d->sigma_s, "sigma_s must be between 0 and 1e12")
        && pti_check_extinction(s, d->emission, "emission must be between 0 and 1e12")
        && pti_check_phase(s, d)
        && pti_require(s, !d->grid || !d->density, call, "grid and density: only one of them")
        && pti_check(s, !d->density || (d->density_max > 0 && pti_in_range(d->density_max)), call,
                     "density needs a density_max above 0 and below 1e12", d->density_max)
        && pti_require(s, d->density || (!d->density_bound && d->density_max == 0), call,
                       "density_max or density_bound without a density")
        && pti_require(s, !d->glow || !pti_is_zero3(d->emission), call, "glow multiplies emission, which is zero")
        && pti_require(s, d->grid || (d->nx == 0 && d->ny == 0 && d->nz == 0 && d->grid_channels == 0), call,
                       "nx, ny, nz or grid_channels, but grid is NULL")
        && (!d->grid || pti_check_grid(s, d))
        && pti_check(s, d->tracking >= PT_TRACK_EXACT && d->tracking <= PT_TRACK_MARCH_CDF, call, "tracking is no pt_tracking",
                     (float)(int)d->tracking)
        && pti_check(s, !marches || (d->step > 0 && pti_in_range(d->step)), call, "marches need a step above 0 and below 1e12",
                     d->step);
}
static void pti_medium_init(pti_medium *m, const pt_medium_desc *d) {      /* all but the grid */
    pt_vec3 t = pti_add(d->sigma_a, d->sigma_s);
    m->sigma_t = t;
    m->sigma_s = d->sigma_s;
    m->emission = d->emission;
    m->largest = pti_largest(t);
    m->channels = d->grid && d->grid_channels == 3 ? 3 : 1;
    m->chromatic = m->channels == 3 || t.x != t.y || t.y != t.z;
    m->scatters = !pti_is_zero3(d->sigma_s);
    m->emits = !pti_is_zero3(d->emission);
    m->varies = d->grid || d->density;
    pti_phase_init(&m->phase, d);
    m->nearest = d->nearest;
    m->density = d->density; m->density_max = d->density_max; m->density_bound = d->density_bound;
    m->glow = d->glow; m->user = d->user;
    m->tracking = d->tracking; m->step = d->step;
}
static int pti_medium_take_grid(pti_medium *m, const pt_medium_desc *d, const pt_allocator *a) {       /* 0 when out of memory */
    int k;
    void *copy;
    m->n[0] = d->nx; m->n[1] = d->ny; m->n[2] = d->nz;
    for (k = 0; k < 3; k++) m->cells[k] = (m->n[k] + PTI_MEDIUM_BLOCK - 1) / PTI_MEDIUM_BLOCK;
    m->grid = d->grid;
    if (d->borrow) return 1;
    m->grid = NULL;
    copy = pti_alloc(a, (size_t)m->channels * pti_count3(m->n), sizeof(float));
    if (!copy) return 0;
    memcpy(copy, d->grid, (size_t)m->channels * pti_count3(m->n) * sizeof(float));
    m->grid = (const float *)copy;
    m->owned = 1;
    return 1;
}
PTI_NOINLINE pt_medium pti_add_medium_ieee(pt_scene *s, const pt_medium_desc *d) {
    pt_medium id = { 0 };
    pti_medium *m;
    void *array;
    if (!pti_scene_open(s, "pt_add_medium", d) || !pti_check_medium(s, d)) return id;
    array = s->media;
    m = (pti_medium *)pti_scene_slot(s, &array, &s->medium_count, &s->medium_capacity, sizeof *m);
    s->media = (pti_medium *)array;
    if (!m) return id;
    pti_medium_init(m, d);
    if (d->grid && !pti_medium_take_grid(m, d, &s->allocator)) {
        pti_fail(&s->error, PT_ERR_MEMORY, "pt_add_medium: out of memory for %d x %d x %d voxels", d->nx, d->ny, d->nz);
        return id;
    }
    id.id = (uint32_t)s->medium_count;
    return id;
}
PT_DEF pt_medium pt_add_medium(pt_scene *s, const pt_medium_desc *d) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_medium id = pti_add_medium_ieee(s, d);
    pti_fpmode_leave(mode);
    return id;
}

PT_DEF pt_density pt_add_density(pt_scene *s, const pt_density_desc *d) {
    const char *call = "pt_add_density";
    pt_density id = { 0 };
    pt_density_desc *slot;
    void *array;
    if (!pti_scene_open(s, call, d)
        || !pti_require(s, d->sample && d->pdf, call, "sample or pdf is NULL")
        || !pti_check(s, d->weight >= 0 && d->weight <= 0.95f, call, "weight must be between 0 and 0.95", d->weight))
        return id;
    array = s->densities;
    slot = (pt_density_desc *)pti_scene_slot(s, &array, &s->density_count, &s->density_capacity, sizeof *slot);
    s->densities = (pt_density_desc *)array;
    if (!slot) return id;
    *slot = *d;
    if (!(slot->weight > 0)) slot->weight = 0.25f;
    id.id = (uint32_t)s->density_count;
    return id;
}

/* ---- shapes */

static pti_shape *pti_shape_slot(pt_scene *s, pti_shape_kind kind, size_t prims, pt_material m) {
    pti_shape *shape;
    void *array = s->geometry.shapes;
    if (prims > PTI_INDEX(PTI_NONE) - s->geometry.prim_count) {
        pti_fail(&s->error, PT_ERR_ARG, "a scene has room for %u triangles and other shapes, not more",
                 (uint64_t)PTI_INDEX(PTI_NONE));
        return NULL;
    }
    shape = (pti_shape *)pti_scene_slot(s, &array, &s->geometry.shape_count, &s->geometry.shape_capacity, sizeof *shape);
    s->geometry.shapes = (pti_shape *)array;
    if (!shape) return NULL;
    shape->kind = kind;
    shape->first = s->geometry.prim_count;
    shape->count = (uint32_t)prims;
    shape->material = m.id;
    s->geometry.prim_count += (uint32_t)prims;
    return shape;
}
static pt_shape pti_last_shape(const pt_scene *s) { pt_shape id; id.id = (uint32_t)s->geometry.shape_count; return id; }
static int pti_check_shape(pt_scene *s, const char *call, const void *argument, pt_material m) {
    return pti_scene_open(s, call, argument) && pti_check_id(s, m.id, s->material_count - 1, call, "material");
}

static int pti_check_floats(pt_scene *s, const char *call, const char *what, const float *p, size_t count, size_t size) {
    size_t i;
    for (i = 0; p && i < count * size; i++) {
        if (pti_in_range(p[i])) continue;
        pti_fail(&s->error, PT_ERR_ARG, "%s: %s %u must be finite and below 1e12 (a component is %g)", call, what,
                 (uint64_t)(i / size), (double)p[i]);
        return 0;
    }
    return 1;
}
static int pti_check_vertex(pt_scene *s, const char *call, size_t i, pt_vec3 p) {
    if (pti_in_range3(p)) return 1;
    pti_fail(&s->error, PT_ERR_ARG, "%s: vertex %u must be finite and below 1e12 (it is %g %g %g)", call, (uint64_t)i,
             (double)p.x, (double)p.y, (double)p.z);
    return 0;
}
static int pti_check_mesh(pt_scene *s, const pt_mesh_desc *d, size_t stride, size_t corners) {
    const char *call = "pt_add_mesh";
    size_t i;
    if (!pti_require(s, d->positions || !d->vertex_count, call, "positions is NULL")
        || !pti_require(s, corners / 3 <= PTI_INDEX(PTI_NONE), call, "index_count is more than a scene has room for"))
        return 0;
    if (stride < 12 || stride % 4 || d->vertex_count > UINT32_MAX || d->vertex_count > SIZE_MAX / stride) {
        pti_fail(&s->error, PT_ERR_ARG, "%s: vertex_stride is %u, it must be a multiple of 4 from 12 on, and the array "
                 "must fit into memory", call, (uint64_t)stride);
        return 0;
    }
    if (corners % 3) {
        pti_fail(&s->error, PT_ERR_ARG, "%s: %u indices do not make triangles", call, (uint64_t)corners);
        return 0;
    }
    for (i = 0; i < corners; i++) {
        size_t index = d->indices ? d->indices[i] : i;
        if (index < d->vertex_count) continue;
        pti_fail(&s->error, PT_ERR_ARG, "%s: index %u is %u, but there are %u vertices", call, (uint64_t)i, (uint64_t)index,
                 (uint64_t)d->vertex_count);
        return 0;
    }
    for (i = 0; i < d->vertex_count; i++) {
        const float *p = (const float *)(const void *)((const char *)d->positions + i * stride);
        if (!pti_check_vertex(s, call, i, pt_v3(p[0], p[1], p[2]))) return 0;
    }
    return pti_check_floats(s, call, "normal", d->normals, d->vertex_count, 3)
        && pti_check_floats(s, call, "uv", d->uvs, d->vertex_count, 2);
}
static int pti_check_mesh_materials(pt_scene *s, const pt_mesh_desc *d, size_t triangles) {
    const char *call = "pt_add_mesh";
    size_t i;
    if (!pti_require(s, d->materials || !d->material_count, call, "materials is NULL")
        || !pti_require(s, d->material_count || !d->material_ids || !triangles, call, "material_ids without materials"))
        return 0;
    for (i = 0; i < d->material_count; i++)
        if (!pti_check_id(s, d->materials[i].id, s->material_count - 1, call, "material")) return 0;
    for (i = 0; d->material_ids && i < triangles; i++) {
        if (d->material_ids[i] < d->material_count) continue;
        pti_fail(&s->error, PT_ERR_ARG, "%s: material id of triangle %u is %u, but there are %u materials", call,
                 (uint64_t)i, (uint64_t)d->material_ids[i], (uint64_t)d->material_count);
        return 0;
    }
    return 1;
}
/* The ids, turned into the scene's own. */
static uint32_t *pti_mesh_materials(pt_scene *s, const pt_mesh_desc *d, size_t triangles) {
    uint32_t *p;
    size_t i;
    if (!d->material_ids) return NULL;
    p = (uint32_t *)pti_alloc(&s->allocator, triangles, sizeof *p);
    if (!p) { pti_fail(&s->error, PT_ERR_MEMORY, "out of memory for a mesh"); return NULL; }
    for (i = 0; i < triangles; i++) p[i] = d->materials[d->material_ids[i]].id;
    return p;
}
static const void *pti_copy(pt_scene *s, const void *from, size_t count, size_t size) {
    void *p;
    if (!from) return NULL;
    p = pti_alloc(&s->allocator, count, size);
    if (!p) pti_fail(&s->error, PT_ERR_MEMORY, "out of memory for a mesh");
    else memcpy(p, from, count * size);
    return p;
}
static const float *pti_copy_positions(pt_scene *s, const float *from, size_t count, size_t stride) {
    float *p = (float *)pti_alloc(&s->allocator, count, 3 * sizeof(float));
    size_t i;
    if (!p) { pti_fail(&s->error, PT_ERR_MEMORY, "out of memory for a mesh"); return NULL; }
    for (i = 0; i < count; i++) memcpy(p + 3 * i, (const char *)from + i * stride, 3 * sizeof(float));
    return p;
}
static pt_shape pti_add_mesh(pt_scene *s, const pt_mesh_desc *d, int quads) {
    pt_shape none = { 0 };
    size_t stride, corners;
    pti_shape *shape;
    pti_mesh *m;
    if (!pti_check_shape(s, "pt_add_mesh", d, d->material)) return none;
    stride = d->vertex_stride ? d->vertex_stride : 12;
    corners = d->indices || d->index_count ? d->index_count : d->vertex_count;
    if (!pti_check_mesh(s, d, stride, corners) || !pti_check_mesh_materials(s, d, corners / 3)) return none;
    shape = pti_shape_slot(s, PTI_MESH, corners / 3, d->material.id || !d->material_count ? d->material : d->materials[0]);
    if (!shape) return none;
    m = &shape->as.mesh;
    m->materials = pti_mesh_materials(s, d, corners / 3);
    m->quads = quads;
    m->owned = !d->borrow;
    m->stride = d->borrow ? stride : 12;
    m->vertex_count = d->vertex_count;
    m->positions = d->borrow ? d->positions : pti_copy_positions(s, d->positions, d->vertex_count, stride);
    m->normals = d->borrow ? d->normals : (const float *)pti_copy(s, d->normals, d->vertex_count, 3 * sizeof(float));
    m->uvs = d->borrow ? d->uvs : (const float *)pti_copy(s, d->uvs, d->vertex_count, 2 * sizeof(float));
    m->indices = d->borrow ? d->indices : (const uint32_t *)pti_copy(s, d->indices, corners, sizeof(uint32_t));
    return s->error.code == PT_OK ? pti_last_shape(s) : none;
}
PTI_NOINLINE pt_shape pti_add_mesh_ieee(pt_scene *s, const pt_mesh_desc *d) {
    pt_shape none = { 0 };
    return pti_scene_open(s, "pt_add_mesh", d) ? pti_add_mesh(s, d, 0) : none;
}
PT_DEF pt_shape pt_add_mesh(pt_scene *s, const pt_mesh_desc *d) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_shape id = pti_add_mesh_ieee(s, d);
    pti_fpmode_leave(mode);
    return id;
}

/* n parallelograms, each by four corners in turn. */
static pt_shape pti_add_quads(pt_scene *s, const pt_vec3 *corner, int n, pt_material m) {
    static const float uv[48] = { 0, 0, 1, 0, 1, 1, 0, 1,  0, 0, 1, 0, 1, 1, 0, 1,  0, 0, 1, 0, 1, 1, 0, 1,
                                  0, 0, 1, 0, 1, 1, 0, 1,  0, 0, 1, 0, 1, 1, 0, 1,  0, 0, 1, 0, 1, 1, 0, 1 };
    uint32_t index[36];
    pt_mesh_desc d;
    int i;
    for (i = 0; i < 6 * n; i++) {
        static const uint32_t order[6] = { 0, 1, 2, 0, 2, 3 };
        index[i] = 4 * (uint32_t)(i / 6) + order[i % 6];
    }
    memset(&d, 0, sizeof d);
    d.positions = &corner[0].x;
    d.vertex_count = 4 * (size_t)n;
    d.vertex_stride = sizeof *corner;
    d.indices = index;
    d.index_count = 6 * (size_t)n;
    d.uvs = uv;
    d.material = m;
    return pti_add_mesh(s, &d, 1);
}
PTI_NOINLINE pt_shape pti_add_quad_ieee(pt_scene *s, pt_vec3 corner, pt_vec3 edge_u, pt_vec3 edge_v, pt_material m) {
    pt_shape none = { 0 };
    pt_vec3 c[4];
    if (!pti_check_shape(s, "pt_add_quad", s, m)
        || !pti_check3(s, pti_in_range3(corner), "pt_add_quad", "corner must be finite and below 1e12", corner)
        || !pti_check3(s, pti_in_range3(edge_u), "pt_add_quad", "edge_u must be finite and below 1e12", edge_u)
        || !pti_check3(s, pti_in_range3(edge_v), "pt_add_quad", "edge_v must be finite and below 1e12", edge_v)) return none;
    c[0] = corner;
    c[1] = pti_add(corner, edge_u);
    c[2] = pti_add(c[1], edge_v);
    c[3] = pti_add(corner, edge_v);
    return pti_add_quads(s, c, 1, m);
}
PT_DEF pt_shape pt_add_quad(pt_scene *s, pt_vec3 corner, pt_vec3 edge_u, pt_vec3 edge_v, pt_material m) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_shape id = pti_add_quad_ieee(s, corner, edge_u, edge_v, m);
    pti_fpmode_leave(mode);
    return id;
}
PTI_NOINLINE pt_shape pti_add_box_ieee(pt_scene *s, pt_vec3 lo, pt_vec3 hi, const pt_xform *xform, pt_material m) {
    static const int face[24] = { 0, 4, 6, 2,  1, 3, 7, 5,  0, 1, 5, 4,  2, 6, 7, 3,  0, 2, 3, 1,  4, 5, 7, 6 };
    pt_shape none = { 0 }, id;
    pt_vec3 c[24];
    pt_xform x = pti_xform_or_identity(xform);
    int i, mirrored;
    if (!pti_check_shape(s, "pt_add_box", s, m)
        || !pti_check3(s, pti_in_range3(lo) && lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z, "pt_add_box",
                       "lo must be finite and not above hi", lo)
        || !pti_check3(s, pti_in_range3(hi), "pt_add_box", "hi must be finite and below 1e12", hi)) return none;
    for (i = 0; i < 12; i++)
        if (!pti_check(s, pti_in_range(x.m[i]), "pt_add_box", "xform must be finite and below 1e12", x.m[i])) return none;
    mirrored = pti_xform_det(&x) < 0;                    /* then the corners go round the other way */
    for (i = 0; i < 24; i++) {
        int k = face[mirrored ? i / 4 * 4 + (4 - i % 4) % 4 : i];
        c[i] = pti_xform_point(&x, pt_v3(k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z));
    }
    id = pti_add_quads(s, c, 6, m);
    if (id.id) s->geometry.shapes[id.id - 1].as.mesh.box = mirrored ? -1 : 1;
    return id;
}
PT_DEF pt_shape pt_add_box(pt_scene *s, pt_vec3 lo, pt_vec3 hi, const pt_xform *xform, pt_material m) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_shape id = pti_add_box_ieee(s, lo, hi, xform, m);
    pti_fpmode_leave(mode);
    return id;
}
PT_DEF pt_shape pt_add_sphere(pt_scene *s, pt_vec3 center, float radius, pt_material m) {
    pt_shape none = { 0 };
    pti_shape *shape;
    if (!pti_check_shape(s, "pt_add_sphere", s, m)
        || !pti_check3(s, pti_in_range3(center), "pt_add_sphere", "center must be finite and below 1e12", center)
        || !pti_check(s, radius > 0 && pti_in_range(radius), "pt_add_sphere",
                      "radius must be above 0 and below 1e12", radius))
        return none;
    shape = pti_shape_slot(s, PTI_SPHERE, 1, m);
    if (!shape) return none;
    shape->as.sphere.center = center;
    shape->as.sphere.radius = radius;
    return pti_last_shape(s);
}
static int pti_has_instances(const pt_scene *s) {
    size_t i;
    for (i = 0; i < s->geometry.shape_count; i++) if (s->geometry.shapes[i].kind == PTI_INSTANCE) return 1;
    return 0;
}
static int pti_check_xform(pt_scene *s, const char *call, const char *name, const pt_xform *x, pt_xform *inverse) {
    int i;
    for (i = 0; i < 12; i++)
        if (!pti_in_range(x->m[i])) {
            pti_fail(&s->error, PT_ERR_ARG, "%s: %s must be finite and below 1e12 (it is %g)", call, name, (double)x->m[i]);
            return 0;
        }
    if (pti_xform_invert(x, inverse)) return 1;
    pti_fail(&s->error, PT_ERR_ARG, "%s: %s has no inverse (its determinant is %g)", call, name, pti_xform_det(x));
    return 0;
}
/* Is there an inverse all along? The determinant of (1 - t) A + t B is linear in each row, so it is the cubic
       sum_k d_k (1 - t)^(3-k) t^k,   d_k = sum of the determinants that have k rows of B and the others of A.
   It is smallest at an end or where its slope is zero; there it must be more than what rounding leaves of its terms.
   Returns the time at which it is not, or -1. */
static double pti_flat_time(const pt_xform *a, const pt_xform *b) {
    double d[4] = { 0, 0, 0, 0 }, c1, c2, c3, root, t[4] = { 0, 1, 0, 0 };
    int mask, row, k;
    for (mask = 0; mask < 8; mask++) {
        pt_xform x = *a;
        for (row = k = 0; row < 3; row++)
            if (mask >> row & 1) { memcpy(x.m + 4 * row, b->m + 4 * row, 4 * sizeof(float)); k++; }
        d[k] += pti_xform_det(&x);
    }
    c1 = d[1] - 3 * d[0]; c2 = 3 * d[0] - 2 * d[1] + d[2]; c3 = d[3] - d[2] + d[1] - d[0];   /* of t, t^2, t^3 */
    root = c2 * c2 - 3 * c1 * c3;                        /* slope: c1 + 2 c2 t + 3 c3 t^2 */
    root = c2 < 0 ? -c2 + sqrt(root > 0 ? root : 0) : -c2 - sqrt(root > 0 ? root : 0);
    if (c3 < 0 || c3 > 0) t[2] = root / (3 * c3);
    if (root < 0 || root > 0) t[3] = c1 / root;
    for (k = 0; k < 4; k++) {
        double u = 1 - t[k], w[4], det = 0, terms = 0;
        if (!(t[k] >= 0 && t[k] <= 1)) continue;
        w[0] = u * u * u; w[1] = u * u * t[k]; w[2] = u * t[k] * t[k]; w[3] = t[k] * t[k] * t[k];
        for (row = 0; row < 4; row++) { det += w[row] * d[row]; terms += w[row] * (d[row] < 0 ? -d[row] : d[row]); }
        if (!((d[0] < 0 ? -det : det) > 1e-6 * terms)) return t[k];
    }
    return -1;
}
PTI_NOINLINE pt_shape pti_add_placed(pt_scene *s, const char *call, const pt_scene *of, const pt_xform *from,
                                     const pt_xform *to) {
    pt_shape none = { 0 };
    pt_material no_material = { 0 };
    pti_shape *shape;
    pt_xform inverse, unused;
    double flat;
    if (!pti_scene_open(s, call, s)
        || !pti_require(s, of != NULL, call, "there is no scene to place: it is NULL")
        || !pti_require(s, of != s, call, "a scene can not contain itself")
        || !pti_require(s, of->committed, call, "commit the scene before you place it")
        || !pti_require(s, !pti_has_instances(of), call, "instances nest one level deep, and this scene has some itself")
        || !pti_require(s, !of->has_spots, call, "a scene with spots can not be placed: their axes would not turn")
        || !pti_check_xform(s, call, to ? "from" : "xform", from, &inverse)
        || (to && !pti_check_xform(s, call, "to", to, &unused))) return none;
    flat = to ? pti_flat_time(from, to) : -1.0;
    if (!pti_check(s, flat < 0, call, "on the way from one transform to the other, a time by when it has been without an inverse",
                   (float)flat)) return none;
    shape = pti_shape_slot(s, PTI_INSTANCE, 1, no_material);
    if (!shape) return none;
    shape->as.instance.of = &of->geometry;
    shape->as.instance.scene = of;
    shape->as.instance.to_world = *from;
    shape->as.instance.to_local = inverse;
    if (to) {
        shape->as.instance.to_world_end = (pt_xform *)pti_alloc(&s->allocator, 1, sizeof *to);
        if (!shape->as.instance.to_world_end) {
            pti_fail(&s->error, PT_ERR_MEMORY, "out of memory for the scene");
            return none;
        }
        *shape->as.instance.to_world_end = *to;
    }
    return pti_last_shape(s);
}
PT_DEF pt_shape pt_add_instance(pt_scene *s, const pt_scene *of, const pt_xform *xform) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_xform x = pti_xform_or_identity(xform);
    pt_shape id = pti_add_placed(s, "pt_add_instance", of, &x, NULL);
    pti_fpmode_leave(mode);
    return id;
}
PT_DEF pt_shape pt_add_moving_instance(pt_scene *s, const pt_scene *of, const pt_xform *from, const pt_xform *to) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_xform a = pti_xform_or_identity(from), b = pti_xform_or_identity(to);
    pt_shape id = pti_add_placed(s, "pt_add_moving_instance", of, &a, &b);
    pti_fpmode_leave(mode);
    return id;
}
PT_DEF pt_shape pt_add_user_shape(pt_scene *s, const pt_shape_vtable *v, void *user, pt_material m) {
    const char *call = "pt_add_user_shape";
    pt_shape none = { 0 };
    pti_shape *shape;
    pt_vec3 lo = { 0, 0, 0 }, hi = { 0, 0, 0 };
    if (!pti_check_shape(s, call, v, m)
        || !pti_require(s, v->bounds && v->intersect, call, "bounds or intersect is NULL")) return none;
    v->bounds(user, &lo, &hi);
    if (!pti_check3(s, pti_in_range3(lo) && lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z, call,
                    "lo must be finite and not above hi", lo)
        || !pti_check3(s, pti_in_range3(hi), call, "hi must be finite and below 1e12", hi)) return none;
    shape = pti_shape_slot(s, PTI_USER, 1, m);
    if (!shape) return none;
    shape->as.user.vtable = *v;
    shape->as.user.user = user;
    shape->as.user.lo = lo;
    shape->as.user.hi = hi;
    return pti_last_shape(s);
}

static int pti_filling_add(pt_scene *s, uint32_t shape, uint32_t medium) {
    void *array = s->fillings;
    pti_filling *f = (pti_filling *)pti_scene_slot(s, &array, &s->filling_count, &s->filling_capacity, sizeof *f);
    s->fillings = (pti_filling *)array;
    if (!f) return 0;
    f->shape = shape;
    f->medium = medium;
    return 1;
}
PT_DEF pt_volume pt_add_volume(pt_scene *s, pt_shape bounds, pt_medium m) {
    const char *call = "pt_add_volume";
    pt_volume id = { 0 };
    if (!pti_scene_open(s, call, s)
        || !pti_check_id(s, bounds.id, s->geometry.shape_count, call, "bounds, a shape,")
        || !pti_check_id(s, m.id, s->medium_count, call, "medium")
        || !pti_require(s, m.id > 0, call, "there is no medium to fill it with")
        || !pti_require(s, bounds.id || !pti_medium_tracked(s->media + (m.id - 1)), call,
                        "a medium with a density, or one to be marched through, needs bounds")
        || !pti_filling_add(s, bounds.id, m.id)) return id;
    id.id = (uint32_t)s->filling_count;
    return id;
}

/* ---- lights without a shape */

/* A sky that the film could not take would come out black. */
static int pti_check_map(pt_scene *s, const pti_texture *t) {
    int x, y;
    for (y = 0; y < t->height; y++)
        for (x = 0; x < t->width; x++) {
            pt_vec3 c = pti_texel(t, x, y);
            if (c.x >= 0 && c.y >= 0 && c.z >= 0 && pti_in_range3(c)) continue;
            pti_fail(&s->error, PT_ERR_ARG, "pt_add_light: pixel (%d, %d) of the environment must be between 0 and 1e12 "
                     "(it is %g %g %g)", x, y, (double)c.x, (double)c.y, (double)c.z);
            return 0;
        }
    return 1;
}
static int pti_add_environment(pt_scene *s, const pt_light_desc *d) {
    const char *call = "pt_add_light";
    pti_environment *e = &s->environment;
    if (!pti_check(s, fabsf(d->rotate_deg) <= 36000, call, "rotate_deg must be within 36000", d->rotate_deg)
        || !pti_check_id(s, d->texture.id, s->texture_count, call, "texture")
        || !pti_check(s, !d->texture.id || s->textures[d->texture.id - 1].pixels, call,
                      "an environment's texture must have pixels; for a callback, see radiance", (float)d->texture.id)
        || (d->texture.id && !pti_check_map(s, s->textures + (d->texture.id - 1)))) return 0;
    e->radiance = d->radiance; e->user = d->user;
    e->textured = d->texture.id || d->radiance;
    s->environment_texture = d->texture;
    pti_sincos(d->rotate_deg * (PTI_PI / 180), &e->sine, &e->cosine);
    return 1;
}
static pt_vec3 pti_light_direction(const pt_light_desc *d) {
    return pti_is_zero3(d->direction) ? pt_v3(0, -1, 0) : pti_normalize(d->direction);
}
static int pti_add_sun(pt_scene *s, const pt_light_desc *d, pt_vec3 irradiance) {
    const char *call = "pt_add_light";
    void *array = s->environment.suns;
    pti_sun sun, *slot;
    if (!pti_check(s, d->radius_deg == 0 || (d->radius_deg >= 0.001f && d->radius_deg <= 90), call,
                   "radius_deg must be 0.001 to 90, or 0 for the sun's 0.2665", d->radius_deg)) return 0;
    sun = pti_sun_of(pti_neg(pti_light_direction(d)), d->radius_deg > 0 ? d->radius_deg : 0.2665f, irradiance);
    if (!pti_check3(s, pti_in_range3(sun.radiance), call, "color is too bright for so small a disk: its radiance must be "
                    "below 1e12", sun.radiance)) return 0;
    if (pti_is_zero3(irradiance)) return 1;              /* below the horizon, or black */
    slot = (pti_sun *)pti_scene_slot(s, &array, &s->environment.sun_count, &s->environment.sun_capacity, sizeof *slot);
    s->environment.suns = (pti_sun *)array;
    if (!slot) return 0;
    *slot = sun;
    return 1;
}
static int pti_add_sky(pt_scene *s, const pt_light_desc *d) {
    enum { WIDTH = 128, HEIGHT = 128 };                  /* across, the sky is smoother */
    pti_environment *e = &s->environment;
    pt_vec3 sun = pti_neg(pti_light_direction(d));
    float across = sqrtf(sun.x * sun.x + sun.z * sun.z);
    pt_texture_desc t;
    pt_vec3 *map;
    pti_sky sky;
    if (!pti_check(s, d->turbidity == 0 || (d->turbidity >= 1.8f && d->turbidity <= 10), "pt_add_light",
                   "turbidity must be 1.8 to 10, or 0 for 3", d->turbidity)) return 0;
    pti_sky_build(&sky, sun, d->turbidity > 0 ? d->turbidity : 3.0f);
    map = (pt_vec3 *)pti_alloc(&s->allocator, WIDTH * HEIGHT, sizeof *map);
    if (!map) { pti_fail(&s->error, PT_ERR_MEMORY, "out of memory for the scene"); return 0; }
    pti_sky_map(&sky, map, WIDTH, HEIGHT);
    memset(&t, 0, sizeof t);
    t.width = WIDTH; t.height = HEIGHT; t.channels = 3; t.bits = 32; t.pixels = map;
    s->environment_texture = pt_add_texture(s, &t);
    pti_free(&s->allocator, map, WIDTH * HEIGHT, sizeof *map);
    if (!s->environment_texture.id) return 0;
    e->textured = 1;
    e->sine = across > 0 ? -sun.x / across : 0.0f;       /* the map's middle, -z, is turned to below the sun */
    e->cosine = across > 0 ? -sun.z / across : 1.0f;
    return pti_add_sun(s, d, sun.y > 0 ? pti_mul(e->color, pti_air_sunlight(&sky.air, 0, sun.y)) : pt_v3(0, 0, 0));
}
/* A sphere of radiance L has the power 4 pi r^2 pi L. */
static int pti_add_bulb(pt_scene *s, const pt_light_desc *d, int spot) {
    const char *call = "pt_add_light";
    float radius = d->radius > 0 ? d->radius : 0.01f, cone = d->cone_deg > 0 ? d->cone_deg : 45.0f;
    float blend = d->blend > 0 ? d->blend : 0.15f, sine, cosine;
    pt_material_desc black;
    pt_material id;
    pti_profile *profile;
    memset(&black, 0, sizeof black);
    black.emission = pti_scale(d->color, 1 / (4 * PTI_PI * PTI_PI * radius * radius));
    if (!pti_check3(s, pti_in_range3(d->position), call, "position must be finite and below 1e12", d->position)
        || !pti_check(s, d->radius >= 0 && pti_in_range(d->radius), call, "radius must be between 0 and 1e12", d->radius)
        || !pti_check3(s, pti_in_range3(black.emission), call, "color is too bright for so small a sphere: its radiance must "
                       "be below 1e12", black.emission)
        || (spot && !(pti_check(s, cone >= 0.1f && cone <= 90 && d->cone_deg >= 0, call,
                                "cone_deg must be 0.1 to 90, or 0 for 45", d->cone_deg)
                      && pti_check(s, d->blend == 0 || (d->blend >= 0.001f && d->blend <= 1), call,
                                   "blend must be 0.001 to 1, or 0 for 0.15", d->blend))))
        return 0;
    id = pt_add_material(s, &black);
    if (!id.id) return 0;
    if (spot) {
        s->has_spots = 1;
        s->materials[id.id].glows = 0;
        profile = &s->materials[id.id].profile;
        profile->axis = pti_light_direction(d);
        pti_sincos(cone * (PTI_PI / 360), &sine, &cosine);
        profile->outer = 2 * sine * sine;
        pti_sincos(cone * (1 - blend) * (PTI_PI / 360), &sine, &cosine);
        profile->inner = 2 * sine * sine;
    }
    return pt_add_sphere(s, d->position, radius, id).id != 0;
}
PTI_NOINLINE pt_light pti_add_light_ieee(pt_scene *s, const pt_light_desc *d) {
    const char *call = "pt_add_light";
    pt_light id = { 0 };
    int sky, fine;
    if (!pti_scene_open(s, call, d)
        || !pti_check(s, d->kind >= PT_LIGHT_ENVIRONMENT && d->kind <= PT_LIGHT_SKY, call, "kind is no pt_light_kind",
                      (float)d->kind)
        || !pti_check3(s, d->color.x >= 0 && d->color.y >= 0 && d->color.z >= 0 && pti_in_range3(d->color), call,
                       "color must be between 0 and 1e12", d->color)) return id;
    sky = d->kind == PT_LIGHT_ENVIRONMENT || d->kind == PT_LIGHT_SKY;
    if ((sky && !pti_require(s, !s->environment.present, call, "the scene has an environment already"))
        || (d->kind != PT_LIGHT_ENVIRONMENT && d->kind != PT_LIGHT_POINT
            && !pti_check3(s, pti_in_range3(d->direction), call, "direction must be finite and below 1e12", d->direction)))
        return id;
    if (sky) {
        int multiplies = d->kind == PT_LIGHT_SKY || d->texture.id || d->radiance;
        s->environment.color = multiplies && pti_is_zero3(d->color) ? pt_v3(1, 1, 1) : d->color;
    }
    switch (d->kind) {
    case PT_LIGHT_ENVIRONMENT: fine = pti_add_environment(s, d); break;
    case PT_LIGHT_SUN:         fine = pti_add_sun(s, d, d->color); break;
    case PT_LIGHT_SKY:         fine = pti_add_sky(s, d); break;
    default:                   fine = pti_add_bulb(s, d, d->kind == PT_LIGHT_SPOT); break;
    }
    s->environment.present |= sky && fine;
    if (fine) id.id = ++s->light_count;
    return id;
}
PT_DEF pt_light pt_add_light(pt_scene *s, const pt_light_desc *d) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_light id = pti_add_light_ieee(s, d);
    pti_fpmode_leave(mode);
    return id;
}

/* ---- commit: emitters are found, then the trees are built */

static int pti_emitter_add(pt_scene *s, pti_emitter e) {
    void *array = s->lights.emitters;
    pti_emitter *slot;
    if (!(pti_emitter_area(&e) > 0) || !(e.luminance > 0)) return 1;
    slot = (pti_emitter *)pti_scene_slot(s, &array, &s->lights.count, &s->lights.capacity, sizeof *slot);
    s->lights.emitters = (pti_emitter *)array;
    if (!slot) return 0;
    *slot = e;
    return 1;
}
/* A parallelogram is sampled as a rectangle if it is one, else as two triangles. n: the front, which mirroring turns. */
static int pti_emitter_add_quad(pt_scene *s, pt_vec3 p, pt_vec3 u, pt_vec3 v, pt_vec3 n, float luminance, int two_sided) {
    float skew = fabsf(pti_dot(u, v));
    pti_emitter e = pti_emitter_flat(PTI_RECT_LIGHT, p, u, v, luminance, two_sided);
    e.n = n;
    if (skew <= 1e-6f * pti_length(u) * pti_length(v)) return pti_emitter_add(s, e);
    e.kind = PTI_TRIANGLE_LIGHT;
    if (!pti_emitter_add(s, e)) return 0;
    e.p = pti_add(pti_add(p, u), v); e.e1 = pti_neg(u); e.e2 = pti_neg(v);
    return pti_emitter_add(s, e);
}
/* What a texture may hide from the points that its mean on a triangle is made of, where all of them are black: a little of the
   brightest of the texels around; where those are too many to look at, or a function, of 1. 0: surely black. */
static float pti_texture_hides(const pti_texture *t, float uv[3][2]) {
    float s[3], w[3], found = 0, size[2];
    int k, x, y, x0, x1, y0, y1;
    if (!t->pixels) return t->eval || !pti_is_zero3(t->color_a) || !pti_is_zero3(t->color_b) ? 1.0f / 4096 : 0.0f;
    size[0] = (float)t->width; size[1] = (float)t->height;
    for (k = 0; k < 3; k++) {
        pti_texture_st(t, uv[k][0], uv[k][1], s + k, w + k);
        s[k] *= size[0]; w[k] *= size[1];
        if (!(fabsf(s[k]) < 1e6f && fabsf(w[k]) < 1e6f)) return 1.0f / 4096;
    }
    x0 = (int)floorf(pti_min(s[0], pti_min(s[1], s[2]))) - 1; x1 = (int)floorf(pti_max(s[0], pti_max(s[1], s[2]))) + 1;
    y0 = (int)floorf(pti_min(w[0], pti_min(w[1], w[2]))) - 1; y1 = (int)floorf(pti_max(w[0], pti_max(w[1], w[2]))) + 1;
    if ((double)(x1 - x0 + 1) * (double)(y1 - y0 + 1) > 65536) return 1.0f / 4096;
    for (y = y0; y <= y1; y++) for (x = x0; x <= x1; x++)
        found = pti_max(found, pti_largest(pti_texel(t,
            pti_texel_nearest(pti_wrap(((float)x + 0.5f) / size[0], t->wrap_u), t->width),
            pti_texel_nearest(pti_wrap(((float)y + 0.5f) / size[1], t->wrap_v), t->height))));
    return found / 4096;
}
/* Mean luminance of what a material emits on a triangle with these texture coordinates: how often it is sampled, no more. */
static float pti_emission_luminance(const pti_material *m, float uv[3][2]) {
    const pt_material_desc *d = &m->desc;
    float mix = d->mix_texture.id ? 0.5f : d->mix, sum = 0;
    pt_vec3 c = d->emission;
    if (d->bsdf == PT_BSDF_MIX)
        sum = (1 - mix) * pti_emission_luminance(m->all + d->a.id, uv) + mix * pti_emission_luminance(m->all + d->b.id, uv);
    if (d->emission_texture.id) {
        const pti_texture *t = pti_material_texture(m, d->emission_texture);
        pt_vec3 mean = pti_texture_mean_on_triangle(t, uv[0], uv[1], uv[2]);
        if (!(pti_luminance(mean) > 0)) { float hidden = pti_texture_hides(t, uv); mean = pt_v3(hidden, hidden, hidden); }
        c = pti_is_zero3(c) ? mean : pti_mul(c, mean);
    }
    return (sum + pti_luminance(c)) * (1 - d->transparency);
}
static float pti_triangle_luminance(const pti_mesh *mesh, uint32_t triangle, const pti_material *m) {
    float uv[3][2] = { { 0, 0 }, { 1, 0 }, { 0, 1 } };   /* without any: barycentric, as a hit has them */
    int k;
    if (!m->varies && m->desc.bsdf != PT_BSDF_MIX) return pti_luminance(m->desc.emission) * (1 - m->desc.transparency);
    for (k = 0; k < 3 && mesh->uvs; k++)
        memcpy(uv[k], mesh->uvs + 2 * (size_t)pti_mesh_index(mesh, triangle, k), sizeof uv[k]);
    return pti_emission_luminance(m, uv);
}
static int pti_emitters_of_mesh(pt_scene *s, const pti_shape *shape, const pti_material *materials,
                                const pti_instance *in) {
    uint32_t i, step = shape->as.mesh.quads ? 2 : 1;
    for (i = 0; i < shape->count; i += step) {
        const pti_material *m = materials + pti_shape_material(shape, i);
        float luminance;
        int two_sided = m->two_sided, k;
        pt_vec3 v[3], n;
        pti_emitter e;
        if (!m->emits) continue;
        luminance = pti_triangle_luminance(&shape->as.mesh, i, m);
        if (step == 2) luminance = (luminance + pti_triangle_luminance(&shape->as.mesh, i + 1, m)) / 2;
        pti_mesh_triangle(&shape->as.mesh, i, v);
        n = pti_normalize(pti_cross(pti_sub(v[1], v[0]), pti_sub(v[2], v[0])));
        if (in) {
            for (k = 0; k < 3; k++) v[k] = pti_xform_point(&in->to_world, v[k]);
            n = pti_normalize(pti_xform_normal(&in->to_local, n));
        }
        e = pti_emitter_flat(PTI_TRIANGLE_LIGHT, v[0], pti_sub(v[1], v[0]), pti_sub(v[2], v[0]), luminance, two_sided);
        e.n = n;
        if (step == 2 ? !pti_emitter_add_quad(s, v[0], e.e1, pti_sub(v[2], v[1]), n, luminance, two_sided)
                      : !pti_emitter_add(s, e)) return 0;
    }
    return 1;
}
/* The factor by which a transform scales every length alike, or 0 if it does not. */
static float pti_xform_uniform_scale(const pt_xform *x) {
    const float *m = x->m;
    pt_vec3 a = pt_v3(m[0], m[4], m[8]), b = pt_v3(m[1], m[5], m[9]), c = pt_v3(m[2], m[6], m[10]);
    float l = pti_dot(a, a), tolerance = 1e-5f * l;
    if (fabsf(pti_dot(b, b) - l) > tolerance || fabsf(pti_dot(c, c) - l) > tolerance || fabsf(pti_dot(a, b)) > tolerance
        || fabsf(pti_dot(b, c)) > tolerance || fabsf(pti_dot(c, a)) > tolerance) return 0;
    return sqrtf(l);
}
static int pti_collect_emitters(pt_scene *s, const pt_scene *from, const pti_instance *in) {
    size_t i;
    for (i = 0; i < from->geometry.shape_count; i++) {
        const pti_shape *shape = from->geometry.shapes + i;
        const pti_material *m = from->materials + shape->material;
        float scale = 1;
        if (shape->kind == PTI_INSTANCE) {
            if (shape->as.instance.to_world_end) continue;         /* no one place in the light tree is right */
            if (!pti_collect_emitters(s, shape->as.instance.scene, &shape->as.instance)) return 0;
        } else if (shape->kind == PTI_MESH && (m->emits || shape->as.mesh.materials)) {
            if (!pti_emitters_of_mesh(s, shape, from->materials, in)) return 0;
        } else if (shape->kind == PTI_SPHERE && m->emits) {
            pt_vec3 c = shape->as.sphere.center;
            float uv[3][2] = { { 0, 0.5f }, { 2, 0.5f }, { 1, 1 } };         /* all round its upper half, as good as any */
            pti_emitter e;
            if (in) { c = pti_xform_point(&in->to_world, c); scale = pti_xform_uniform_scale(&in->to_world); }
            e = pti_emitter_sphere(c, shape->as.sphere.radius * scale, pti_emission_luminance(m, uv), m->two_sided);
            e.n = m->profile.axis;
            e.spot = m->profile.outer;
            if (!pti_emitter_add(s, e)) return 0;
        }
    }
    return 1;
}
/* A table of albedos, made once for each index and each roughness that differs along x and y. NULL: out of memory. */
static const pti_albedo *pti_scene_albedo(pt_scene *s, float eta, float ax, float ay) {
    pti_albedo_list *l;
    for (l = s->albedos; l; l = l->next)
        if (l->albedo.eta == eta && l->albedo.ax == ax && l->albedo.ay == ay) return &l->albedo;
    l = (pti_albedo_list *)pti_alloc(&s->allocator, 1, sizeof *l);
    if (!l) return NULL;
    l->albedo.eta = eta; l->albedo.ax = ax; l->albedo.ay = ay;
    pti_albedo_build(&l->albedo);
    l->next = s->albedos;
    s->albedos = l;
    return &l->albedo;
}
static int pti_material_tables(pt_scene *s, pti_material *m) {
    const pt_material_desc *d = &m->desc;
    int any = d->shade != NULL, varied = any || d->roughness_texture.id || d->roughness_y_texture.id;
    int rough = varied || !pti_smooth(pti_roughest(d)), principled = d->bsdf == PT_BSDF_PRINCIPLED;
    int dielectric = d->bsdf == PT_BSDF_DIELECTRIC;
    int glass = dielectric && (any || !d->thin);
    int metal = d->bsdf == PT_BSDF_CONDUCTOR || (dielectric && (any || d->thin)) || (principled && (any || d->metallic > 0
        || d->metallic_texture.id || d->thin));
    float ax = 0, ay = 0;
    if (!varied && d->roughness_y > 0 && d->roughness_y != d->roughness) {
        ax = pti_alpha(d->roughness);
        ay = pti_alpha(d->roughness_y);
    }
    m->fresnel_mean = pti_fresnel_mean(d->ior);
    if (metal && rough && !(m->mirror = pti_scene_albedo(s, 0, ax, ay))) return 0;
    if ((principled || (glass && rough)) && !(m->dielectric = pti_scene_albedo(s, d->ior, ax, ay))) return 0;
    if (principled && (any || d->coat > 0 || d->coat_texture.id) && !(m->coat = pti_scene_albedo(s, d->coat_ior, 0, 0)))
        return 0;
    if (principled && (any || d->sheen > 0 || d->sheen_texture.id) && !(m->fuzz = pti_scene_albedo(s, -1, 0, 0))) return 0;
    return 1;
}
static int pti_scene_link(pt_scene *s) {                 /* arrays do not move any more: pointers; 0: out of memory */
    size_t i;
    int row;
    pti_spectrum_build(&s->spectrum);
    for (i = 0; i < s->measured_count; i++)
        for (row = 0; row < PTI_MEASURED_ROWS; row++) s->measured[i].rows[row].of = s->measured + i;
    for (i = 0; i < s->material_count; i++) {
        pti_material *m = s->materials + i;
        m->all = s->materials;
        m->textures = s->textures;
        if (m->desc.measured.id) m->measured = s->measured + (m->desc.measured.id - 1);
        if (!pti_material_tables(s, m)) return 0;
    }
    if (s->environment_texture.id) s->environment.texture = s->textures + (s->environment_texture.id - 1);
    for (i = 0; i < s->density_count; i++) s->density_weight += s->densities[i].weight;
    for (i = 0; i < s->density_count && s->density_weight > 0.95f; i++) s->densities[i].weight *= 0.95f / s->density_weight;
    s->density_weight = pti_min(s->density_weight, 0.95f);
    return 1;
}
/* ---- commit, volumes: bounds in a form that flights can use, majorants, and a tree over all of them */

static int pti_material_is_nothing(const pti_material *m, uint32_t id) {
    return id == PTI_DEFAULT_MATERIAL || (m->desc.bsdf == PT_BSDF_NONE && !m->emits);
}
static int pti_shape_is_nothing(const pt_scene *s, const pti_shape *shape) {   /* but bounds */
    const pt_scene *of = shape->kind == PTI_INSTANCE ? shape->as.instance.scene : s;
    const pti_mesh *mesh = &shape->as.mesh;
    uint32_t i;
    if (of != s) {
        for (i = 0; i < of->geometry.shape_count; i++) if (!pti_shape_is_nothing(of, of->geometry.shapes + i)) return 0;
        return 1;
    }
    if (shape->kind != PTI_MESH || !mesh->materials)
        return pti_material_is_nothing(s->materials + shape->material, shape->material);
    for (i = 0; i < shape->count; i++)
        if (!pti_material_is_nothing(s->materials + mesh->materials[i], mesh->materials[i])) return 0;
    return 1;
}
static pt_xform pti_unit_of_box(const pti_bounds *b) {
    pt_vec3 d = pti_max3(pti_sub(b->hi, b->lo), pt_v3(1e-30f, 1e-30f, 1e-30f));
    pt_xform x;
    memset(&x, 0, sizeof x);
    x.m[0] = 1 / d.x; x.m[5] = 1 / d.y; x.m[10] = 1 / d.z;
    x.m[3] = -b->lo.x / d.x; x.m[7] = -b->lo.y / d.y; x.m[11] = -b->lo.z / d.z;
    return x;
}
/* The frame of what pt_add_box made: its corners are at 0, 1, 3 and 4 (see there). 0: it is flat. */
static int pti_unit_of_mesh_box(const pti_mesh *m, pt_xform *out) {
    pt_vec3 o = pti_mesh_position(m, 0), x = pti_sub(pti_mesh_position(m, 4), o), y, z;
    pt_xform box;
    y = pti_sub(pti_mesh_position(m, m->box < 0 ? 1 : 3), o);
    z = pti_sub(pti_mesh_position(m, m->box < 0 ? 3 : 1), o);
    box.m[0] = x.x; box.m[1] = y.x; box.m[2] = z.x;  box.m[3] = o.x;
    box.m[4] = x.y; box.m[5] = y.y; box.m[6] = z.y;  box.m[7] = o.y;
    box.m[8] = x.z; box.m[9] = y.z; box.m[10] = z.z; box.m[11] = o.z;
    return pti_xform_invert(&box, out);
}
/* Six times the volume inside of all meshes; below 0 if their normals point inwards. */
static double pti_geometry_volume(const pti_geometry *g) {
    double sum = 0;
    size_t i;
    uint32_t k;
    for (i = 0; i < g->shape_count; i++)
        for (k = 0; g->shapes[i].kind == PTI_MESH && k < g->shapes[i].count; k++) {
            pt_vec3 v[3];
            pti_mesh_triangle(&g->shapes[i].as.mesh, k, v);
            sum += (double)pti_dot(pti_sub(v[0], g->bvh.bounds.lo), pti_cross(pti_sub(v[1], v[0]), pti_sub(v[2], v[0])));
        }
    return sum;
}
/* A tree of the volume's own over such shapes, whether rays meet them or not. */
static int pti_volume_take(pti_volume *v, const pti_shape *shapes, size_t count, const pt_allocator *a) {    /* 0: out of memory */
    pti_geometry *g = (pti_geometry *)pti_alloc(a, 1, sizeof *g);
    size_t i;
    if (!g) return 0;
    v->bounds = g;
    v->owns_bounds = 1;
    g->shapes = (pti_shape *)pti_alloc(a, count, sizeof *shapes);
    if (!g->shapes) return 0;
    g->shape_count = g->shape_capacity = count;
    for (i = 0; i < count; i++) {
        g->shapes[i] = shapes[i];
        g->shapes[i].first = g->prim_count;
        g->shapes[i].bounds_only = 0;
        g->prim_count += shapes[i].count;
    }
    return pti_bvh_build(g, a, PT_QUALITY_DEFAULT, 1);
}
static int pti_geometry_hides(const pti_geometry *g) {   /* bounds of volumes from rays */
    size_t i;
    for (i = 0; i < g->shape_count; i++) if (g->shapes[i].bounds_only) return 1;
    return 0;
}
static int pti_volume_bound(pti_volume *v, const pti_shape *shape, const pt_allocator *a) {    /* 0 when out of memory */
    pti_bounds b;
    uint32_t i;
    v->outwards = 1;
    v->box = pti_bounds_empty();
    for (i = 0; i < shape->count && shape->kind != PTI_INSTANCE; i++) {
        b = pti_shape_bounds(shape, i);
        pti_bounds_merge(&v->box, &b);
    }
    if (shape->kind == PTI_SPHERE) {
        v->kind = PTI_IN_BALL;
        v->ball = shape->as.sphere;
    } else if (shape->kind == PTI_MESH && shape->as.mesh.box && pti_unit_of_mesh_box(&shape->as.mesh, &v->to_unit)) {
        v->kind = PTI_IN_BOX;
        return 1;
    } else if (shape->kind == PTI_MESH && shape->as.mesh.box) {
        v->kind = PTI_IN_BALL;                           /* a flat box has no inside */
        memset(&v->ball, 0, sizeof v->ball);
    } else {
        v->kind = PTI_IN_CLOSED;
        if (shape->kind == PTI_INSTANCE) {
            v->in = &shape->as.instance;
            v->bounds = v->in->of;
            if (pti_geometry_hides(v->in->of) && !pti_volume_take(v, v->in->of->shapes, v->in->of->shape_count, a)) return 0;
            v->box = v->bounds->bvh.bounds;
        } else if (!pti_volume_take(v, shape, 1, a)) return 0;
        if (pti_geometry_volume(v->bounds) < 0) v->outwards = -1;
    }
    v->to_unit = pti_unit_of_box(&v->box);
    return 1;
}
/* A callback's majorants: 32 x 32 x 32 boxes, a little wider than the cells, for rounding. */
static int pti_volume_ask_bounds(pt_scene *s, pti_volume *v, const pti_medium *m) {
    const int n = 32;
    pt_xform from_unit;
    float *most;
    int i, k, cell[3];
    if (!pti_xform_invert(&v->to_unit, &from_unit)) return 1;
    most = (float *)pti_alloc(&s->allocator, (size_t)n * (size_t)n * (size_t)n, sizeof *most);
    if (!most) return 0;
    v->majorants = most;
    v->owns_majorants = 1;
    v->cells[0] = v->cells[1] = v->cells[2] = n;
    for (i = 0; i < n * n * n; i++) {
        pti_bounds unit, box = pti_bounds_empty();
        cell[0] = i % n; cell[1] = i / n % n; cell[2] = i / n / n;
        unit.lo = pti_scale(pt_v3((float)cell[0], (float)cell[1], (float)cell[2]), 1.0f / 32);
        unit.hi = pti_add(unit.lo, pt_v3(1.0f / 32, 1.0f / 32, 1.0f / 32));
        pti_bounds_pad(&unit, 1e-5f);
        for (k = 0; k < 8; k++)
            pti_bounds_point(&box, pti_xform_point(&from_unit, pt_v3(k & 1 ? unit.hi.x : unit.lo.x, k & 2 ? unit.hi.y : unit.lo.y,
                                                                     k & 4 ? unit.hi.z : unit.lo.z)));
        most[i] = m->density_bound(m->user, box.lo, box.hi);
        if (!pti_check(s, most[i] >= 0 && most[i] <= m->density_max, "pt_scene_commit",
                       "density_bound must be at least 0 and at most density_max", most[i])) return 0;      /* no NaN, either */
    }
    return 1;
}
static pti_volume *pti_volume_slot(pt_scene *s) {
    void *array = s->volumes.all;
    pti_volume *v = (pti_volume *)pti_scene_slot(s, &array, &s->volumes.count, &s->volumes.capacity, sizeof *v);
    s->volumes.all = (pti_volume *)array;
    return v;
}
static int pti_volume_add(pt_scene *s, const pti_filling *f) {       /* 0: an error, or out of memory */
    pti_shape *shape = f->shape ? s->geometry.shapes + (f->shape - 1) : NULL;
    const pti_medium *m = s->media + (f->medium - 1);
    pti_volume *v = pti_volume_slot(s);
    if (!v) return 0;
    v->medium = m;
    v->scatterer = s->particles + (f->medium - 1);
    v->id = (uint32_t)(f - s->fillings) + 1;
    v->to_unit = pti_xform_or_identity(NULL);
    if (!shape) return 1;
    if (!pti_volume_bound(v, shape, &s->allocator)) return 0;
    v->majorants = m->majorants;
    memcpy(v->cells, m->cells, sizeof v->cells);
    shape->bounds_only = shape->bounds_only || pti_shape_is_nothing(s, shape);
    return !m->density_bound || pti_volume_ask_bounds(s, v, m);
}
/* Those of placed scenes; fog that is everywhere in them does not come along. */
static int pti_volumes_place(pt_scene *s, uint32_t shape) {
    const pti_instance *in = &s->geometry.shapes[shape].as.instance;
    const pti_volumes *of = &in->scene->volumes;
    size_t i;
    for (i = of->unbounded; i < of->count; i++) {
        pti_volume *v = pti_volume_slot(s);
        if (!v) return 0;
        *v = of->all[i];
        v->owns_bounds = v->owns_majorants = 0;
        v->in = in;
        v->instance = shape + 1;
    }
    return 1;
}
static int pti_media_build(pt_scene *s) {                /* 0 when out of memory */
    size_t i;
    int x, y, z;
    s->particles = (pti_material *)pti_alloc(&s->allocator, s->medium_count, sizeof *s->particles);
    if (!s->particles) return 0;
    for (i = 0; i < s->medium_count; i++) {
        pti_medium *m = s->media + i;
        float *out;
        s->particles[i].phase = &m->phase;
        if (!m->grid) continue;
        m->majorants = out = (float *)pti_alloc(&s->allocator, pti_count3(m->cells), sizeof(float));
        if (!out) return 0;
        for (z = 0; z < m->cells[2]; z++) for (y = 0; y < m->cells[1]; y++) for (x = 0; x < m->cells[0]; x++)
            *out++ = pti_grid_majorant(m, x, y, z);
    }
    return 1;
}
/* What materials say is inside of shapes. */
static int pti_collect_fillings(pt_scene *s) {
    size_t i;
    uint32_t k, medium;
    for (i = 0; i < s->geometry.shape_count; i++) {
        const pti_shape *shape = s->geometry.shapes + i;
        const uint32_t *ids = shape->kind == PTI_MESH ? shape->as.mesh.materials : NULL;
        medium = ids ? 0 : s->materials[shape->material].desc.inside.id;
        for (k = 0; ids && k < shape->count; k++) {
            uint32_t inside = s->materials[ids[k]].desc.inside.id;
            if (inside && medium && inside != medium)
                return pti_require(s, 0, "pt_scene_commit", "a mesh has materials with different media inside: it is filled with "
                                                            "one, so make it several meshes");
            if (inside) medium = inside;
        }
        if (medium && !pti_filling_add(s, (uint32_t)i + 1, medium)) return 0;
    }
    return 1;
}
/* Bounds of a volume in an instance: of its turned box, at both ends if it moves (see pti_scene_placed). */
static void pti_bounds_placed(pti_bounds *b, const pti_bounds *inner, const pt_xform *to_world) {
    int k;
    for (k = 0; k < 8; k++)
        pti_bounds_point(b, pti_xform_point(to_world, pt_v3(k & 1 ? inner->hi.x : inner->lo.x,
                         k & 2 ? inner->hi.y : inner->lo.y, k & 4 ? inner->hi.z : inner->lo.z)));
}
static void pti_volume_world(const pti_volume *v, pti_bounds *b) {
    *b = v->in ? pti_bounds_empty() : v->box;
    if (v->box.lo.x > v->box.hi.x) return;               /* it fills an empty scene */
    if (v->in) pti_bounds_placed(b, &v->box, &v->in->to_world);
    if (v->in && v->in->to_world_end) pti_bounds_placed(b, &v->box, v->in->to_world_end);
    pti_bounds_pad(b, PTI_ULPS_8 * pti_max(pti_largest_abs(b->lo), pti_largest_abs(b->hi)));
}
static int pti_volumes_tree(pt_scene *s) {               /* 0 when out of memory */
    pti_volumes *v = &s->volumes;
    size_t i, n = v->count - v->unbounded;
    if (v->count <= PTI_FEW_VOLUMES) return 1;
    v->tree.shapes = (pti_shape *)pti_alloc(&s->allocator, n, sizeof(pti_shape));
    if (!v->tree.shapes) return 0;
    v->tree.shape_count = v->tree.shape_capacity = n;
    v->tree.prim_count = (uint32_t)n;
    for (i = 0; i < n; i++) {
        pti_shape *shape = v->tree.shapes + i;
        pti_bounds b;
        pti_volume_world(v->all + v->unbounded + i, &b);
        shape->kind = PTI_USER;
        shape->first = (uint32_t)i;
        shape->count = 1;
        shape->as.user.lo = b.lo;
        shape->as.user.hi = b.hi;
    }
    return pti_bvh_build(&v->tree, &s->allocator, PT_QUALITY_DEFAULT, 1);
}
static int pti_volumes_build(pt_scene *s) {              /* 0: an error, or out of memory */
    pti_volumes *v = &s->volumes;
    size_t i;
    if (!pti_media_build(s) || !pti_collect_fillings(s)) return 0;
    for (i = 0; i < s->filling_count; i++) if (!s->fillings[i].shape && !pti_volume_add(s, s->fillings + i)) return 0;
    v->unbounded = v->count;
    for (i = 0; i < s->filling_count; i++) if (s->fillings[i].shape && !pti_volume_add(s, s->fillings + i)) return 0;
    for (i = 0; i < s->geometry.shape_count; i++)
        if (s->geometry.shapes[i].kind == PTI_INSTANCE && !pti_volumes_place(s, (uint32_t)i)) return 0;
    for (i = 0; i < v->count; i++) {
        const pti_medium *m = v->all[i].medium;
        v->weigh |= pti_medium_weighs(m);
        v->chromatic |= m->chromatic;
        v->emit |= m->emits;
        if (!m->scatters || pti_medium_tracked(m)) continue;
        v->least = v->aim ? pti_min(v->least, m->largest) : m->largest;
        v->aim = 1;
    }
    return pti_volumes_tree(s);
}
/* A density that a scene adds to its mixture by itself. It leaves the users' theirs. */
static int pti_density_own(pt_scene *s, float share, int (*sample)(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi),
                           float (*pdf)(void *user, const pt_vertex *x, pt_vec3 wi),
                           float (*importance)(void *user, const pt_vertex *x), void *user) {        /* 0 when out of memory */
    void *array = s->densities;
    pt_density_desc *d = (pt_density_desc *)pti_scene_slot(s, &array, &s->density_count, &s->density_capacity, sizeof *d);
    s->densities = (pt_density_desc *)array;
    if (!d) return 0;
    d->weight = share * (1 - pti_min(s->density_weight, 0.95f));
    s->density_weight += d->weight;
    d->sample = sample; d->pdf = pdf; d->importance = importance;
    d->user = user;
    return 1;
}
/* Of places in meshes, 0. */
static int pti_volume_holds(const pti_volume *v, pt_vec3 p) {
    if (v->in) p = pti_xform_point(&v->in->to_local, p);
    if (v->kind == PTI_IN_BALL) return pti_length(pti_sub(p, v->ball.center)) < v->ball.radius;
    p = pti_xform_point(&v->to_unit, p);
    return v->kind == PTI_EVERYWHERE
        || (v->kind == PTI_IN_BOX && p.x > 0 && p.x < 1 && p.y > 0 && p.y < 1 && p.z > 0 && p.z < 1);
}
static pti_lamp pti_lamp_of(const pti_emitter *e) {
    pti_bounds b = pti_emitter_bounds(e);
    pti_lamp l;
    l.p = pti_scale(pti_add(b.lo, b.hi), 0.5f);
    l.radius = 0.5f * pti_length(pti_sub(b.hi, b.lo));
    l.power = e->luminance * pti_emitter_area(e);
    return l;
}
/* Lamps in constant media that scatter get a halo, if they are few; the users' densities leave it a share. */
static int pti_halos_build(pt_scene *s) {                /* 0 when out of memory */
    pti_halos *h = &s->volumes.halos;
    size_t i, k;
    for (i = 0; i < s->lights.count && i < PTI_AIMS; i++) s->volumes.lamps[i] = pti_lamp_of(s->lights.emitters + i);
    for (i = 0; s->volumes.aim && i < s->lights.count; i++) {
        pti_lamp l = pti_lamp_of(s->lights.emitters + i);
        pti_halo lamp;
        lamp.p = l.p;
        lamp.power = l.power;
        lamp.sigma = 0;
        for (k = 0; k < s->volumes.count; k++) {
            const pti_volume *v = s->volumes.all + k;
            if (v->medium->scatters && !pti_medium_tracked(v->medium) && pti_volume_holds(v, lamp.p))
                lamp.sigma += v->medium->largest;
        }
        if (!(lamp.sigma > 0)) continue;
        if (h->count == PTI_HALOS) { h->count = 0; return 1; }
        h->lamp[h->count++] = lamp;
    }
    if (!h->count) return 1;
    return pti_density_own(s, PTI_HALO_SHARE, pti_halo_sample, pti_halo_pdf, pti_halo_importance, h);
}

/* What glows in media is aimed at as a ball about it, a cone from outside: p = 1 / (2 pi (1 - cos)). Along the ray its light is
   then gathered where it is. Power: the integral of epsilon over the volume, as well as it is known. */
static float pti_fire_weight(const pti_fire *f, const pt_vertex *x, pt_vec3 *axis, float *one_minus_cos) {   /* fluence; 0 within */
    float d = pti_length(pti_sub(f->p, x->p)), sine = f->radius / d;
    if (!(sine < 0.999f)) return 0;
    *axis = pti_scale(pti_sub(f->p, x->p), 1 / d);
    *one_minus_cos = sine * sine / (1 + pti_safe_sqrt(1 - sine * sine));
    return f->power / (d * d);
}
static float pti_fires_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const pti_fires *f = (const pti_fires *)user;
    float all = 0, sum = 0, w, cone;
    pt_vec3 axis;
    int k;
    for (k = 0; k < f->count; k++) {
        w = pti_fire_weight(f->all + k, x, &axis, &cone);
        if (!(w > 0)) continue;
        all += w;
        if (pti_in_cone(axis, cone, wi)) sum += w * pti_pdf_cone(cone);
    }
    return all > 0 ? sum / all : 0.0f;
}
static int pti_fires_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    const pti_fires *f = (const pti_fires *)user;
    float w[PTI_FIRES], cone[PTI_FIRES], all = 0, r;
    pt_vec3 axis[PTI_FIRES];
    int k;
    for (k = 0; k < f->count; k++) all += w[k] = pti_fire_weight(f->all + k, x, axis + k, cone + k);
    if (!(all > 0)) return 0;
    r = u[0] * all;
    for (k = 0; k < f->count - 1 && r >= w[k]; k++) r -= w[k];
    if (!(w[k] > 0)) return 0;
    *wi = pti_sample_cone_about(axis[k], cone[k], pti_min(r / w[k], 1), u[1]);
    return 1;
}
static float pti_fires_importance(void *user, const pt_vertex *x) {
    const pti_fires *f = (const pti_fires *)user;
    float fire = 0, cone, others = 0;
    pt_vec3 axis;
    pti_receiver r;
    int k;
    for (k = 0; k < f->count; k++) fire += pti_fire_weight(f->all + k, x, &axis, &cone);
    r.p = x->p; r.n = pt_v3(0, 0, 0);
    if (f->scene->lights.count) others = pti_lights_irradiance(&f->scene->lights, &r);
    if (f->scene->environment.irradiance) others += pti_environment_irradiance(&f->scene->environment, r.n);
    return fire > 0 ? fire / (fire + others) : 0.0f;
}
/* The box of the cells where there is something, and the integral of what there may be. */
static float pti_fire_bounds(const pti_volume *v, pti_bounds *b) {
    const int *n = v->cells;
    float sum = 0, size;
    pt_xform from_unit;
    int i, k;
    *b = pti_bounds_empty();
    if (!pti_xform_invert(&v->to_unit, &from_unit)) return 0;
    size = fabsf((float)pti_xform_det(&from_unit));
    if (v->in || !v->majorants) {
        pti_volume_world(v, b);
        return size * (v->medium->varies ? v->medium->density_max : 1.0f);
    }
    for (i = 0; i < n[0] * n[1] * n[2]; i++) {
        if (!(v->majorants[i] > 0)) continue;
        sum += v->majorants[i];
        for (k = 0; k < 8; k++)
            pti_bounds_point(b, pti_xform_point(&from_unit, pt_v3((float)(i % n[0] + (k & 1)) / (float)n[0],
                (float)(i / n[0] % n[1] + (k >> 1 & 1)) / (float)n[1], (float)(i / n[0] / n[1] + (k >> 2)) / (float)n[2])));
    }
    return sum * size / (float)(n[0] * n[1] * n[2]);
}
/* The least ball about two. */
static pti_fire pti_fire_join(const pti_fire *a, const pti_fire *b) {
    pt_vec3 way = pti_sub(b->p, a->p);
    float d = pti_length(way);
    pti_fire both = a->radius > b->radius ? *a : *b;
    both.power = a->power + b->power;
    if (d + pti_min(a->radius, b->radius) <= both.radius) return both;
    both.radius = 0.5f * (d + a->radius + b->radius);
    both.p = pti_madd(way, (both.radius - a->radius) / d, a->p);
    return both;
}
/* When there are too many, the two that fit into the smallest ball are one from then on. */
static void pti_fires_add(pti_fires *f, const pti_fire *fire) {
    pti_fire both, best = { { 0, 0, 0 }, FLT_MAX, 0 };
    int i, k, a = 0, b = 1;
    f->all[f->count++] = *fire;
    if (f->count <= PTI_FIRES) return;
    for (i = 0; i < f->count; i++)
        for (k = i + 1; k < f->count; k++) {
            both = pti_fire_join(f->all + i, f->all + k);
            if (both.radius < best.radius) { best = both; a = i; b = k; }
        }
    f->all[a] = best;
    f->all[b] = f->all[--f->count];
}
static int pti_fires_build(pt_scene *s) {                /* 0 when out of memory */
    pti_fires *f = &s->fires;
    pti_fire fire;
    size_t i;
    f->scene = s;
    f->count = 0;
    for (i = s->volumes.unbounded; i < s->volumes.count; i++) {
        const pti_volume *v = s->volumes.all + i;
        pti_bounds b;
        float amount;
        if (!v->medium->emits || !((amount = pti_fire_bounds(v, &b)) > 0)) continue;
        fire.p = pti_scale(pti_add(b.lo, b.hi), 0.5f);
        fire.radius = 0.5f * pti_length(pti_sub(b.hi, b.lo));
        fire.power = amount * pti_luminance(v->medium->emission);
        pti_fires_add(f, &fire);
    }
    return !f->count || pti_density_own(s, PTI_FIRE_SHARE, pti_fires_sample, pti_fires_pdf, pti_fires_importance, f);
}

/* The aureole. Droplets scatter nearly straight on, so round the sun the sky of a cloud is bright, as far as its phase function
   is wide: a particle draws some directions by that function about the sun, and the next one finds the sun itself. */
#define PTI_AUREOLE_SHARE 0.25f                          /* of the mixture, at most */
static const pti_phase *pti_aureole_at(const pt_scene *s, const pt_vertex *x) {         /* NULL: none here */
    const pt_scene *of = x->instance.id ? s->geometry.shapes[x->instance.id - 1].as.instance.scene : s;
    const pti_phase *p = x->volume.id ? &of->media[of->fillings[x->volume.id - 1].medium - 1].phase : NULL;
    return p && !p->pdf && (p->g > 0.5f || (p->mix > 0 && p->g2 > 0.5f)) ? p : NULL;
}
static float pti_aureole_pdf(void *user, const pt_vertex *x, pt_vec3 wi) {
    const pt_scene *s = (const pt_scene *)user;
    const pti_phase *p = pti_aureole_at(s, x);
    pt_vertex about = *x;
    float sum = 0;
    uint32_t k;
    if (!p) return 0;
    for (k = 0; k < s->environment.sun_count; k++) {
        about.wo = pti_neg(s->environment.suns[k].axis);
        sum += pti_phase_pdf(p, &about, wi);
    }
    return sum / (float)s->environment.sun_count;
}
static int pti_aureole_sample(void *user, const pt_vertex *x, const float u[2], pt_vec3 *wi) {
    const pt_scene *s = (const pt_scene *)user;
    const pti_phase *p = pti_aureole_at(s, x);
    pt_vertex about = *x;
    float which = u[0] * (float)s->environment.sun_count;
    uint32_t k = (uint32_t)which < (uint32_t)s->environment.sun_count ? (uint32_t)which : (uint32_t)s->environment.sun_count - 1;
    if (!p) return 0;
    about.wo = pti_neg(s->environment.suns[k].axis);
    return pti_phase_sample(p, &about, (uint32_t)(pti_clamp(which - (float)k, 0, 0.9999999f) * 4294967296.0f),
                            (uint32_t)(u[1] * 4294967296.0f), wi);
}
static float pti_aureole_importance(void *user, const pt_vertex *x) {
    return pti_aureole_at((const pt_scene *)user, x) ? 1.0f : 0.0f;
}
static int pti_aureole_build(pt_scene *s) {              /* 0 when out of memory */
    int any = 0;
    size_t i;
    for (i = 0; i < s->volumes.count; i++) {
        const pti_medium *m = s->volumes.all[i].medium;
        any |= m->scatters && (m->phase.g > 0.5f || (m->phase.mix > 0 && m->phase.g2 > 0.5f));
    }
    return !any || !s->environment.sun_count
        || pti_density_own(s, PTI_AUREOLE_SHARE, pti_aureole_sample, pti_aureole_pdf, pti_aureole_importance, s);
}
PT_DEF pt_result pt_scene_commit(pt_scene *s) {
    pti_fpmode mode;
    int fine;
    if (!s) return PT_ERR_MEMORY;
    if (s->error.code != PT_OK) return s->error.code;
    if (s->committed) return PT_OK;
    mode = pti_fpmode_enter();
    fine = pti_scene_link(s) && pti_volumes_build(s)
        && pti_bvh_build(&s->geometry, &s->allocator, s->quality, s->threads > 0 ? s->threads : pti_cores())
        && pti_environment_build(&s->environment, &s->allocator)
        && pti_collect_emitters(s, s, NULL) && pti_lights_build(&s->lights, &s->allocator)
        && pti_halos_build(s) && pti_fires_build(s) && pti_aureole_build(s);
    pti_fpmode_leave(mode);
    if (!fine && s->error.code == PT_OK) pti_fail(&s->error, PT_ERR_MEMORY, "pt_scene_commit: out of memory");
    if (!fine) return s->error.code;
    s->isa = pti_isa_best();
    s->committed = 1;
    return PT_OK;
}

/* Trees keep their shape; but what was left out of one, and may have area now, needs a new one. Lamps are found anew. */
static int pti_scene_refit(pt_scene *s, int threads) {
    const pti_geometry *g = &s->geometry;
    size_t i, k;
    for (i = 0; i < g->shape_count; i++) {
        const pti_mesh *m = &g->shapes[i].as.mesh;
        if (g->shapes[i].kind == PTI_INSTANCE && !g->shapes[i].as.instance.scene->committed) {
            pti_fail(&s->error, PT_ERR_STATE, "pt_scene_refit: a scene that is placed could not be refitted");
            return 0;
        }
        if (g->shapes[i].kind != PTI_MESH || m->owned) continue;
        for (k = 0; k < m->vertex_count; k++)
            if (!pti_check_vertex(s, "pt_scene_refit", k, pti_mesh_position(m, (uint32_t)k))) return 0;
        if (!pti_check_floats(s, "pt_scene_refit", "normal", m->normals, m->vertex_count, 3)) return 0;
    }
    if (g->bvh.left_out) {
        pti_bvh_free(&s->geometry.bvh, &s->allocator);
        if (!pti_bvh_build(&s->geometry, &s->allocator, s->quality, threads)) return 0;
    } else pti_bvh_refit(&s->geometry, threads);
    pti_free(&s->allocator, s->lights.nodes, s->lights.node_capacity, sizeof(pti_light_node));
    s->lights.nodes = NULL;
    s->lights.count = s->lights.node_count = s->lights.node_capacity = 0;
    return pti_collect_emitters(s, s, NULL) && pti_lights_build(&s->lights, &s->allocator);
}
PT_DEF pt_result pt_scene_refit(pt_scene *s) {
    pti_fpmode mode;
    int fine;
    if (!s) return PT_ERR_MEMORY;
    if (s->error.code != PT_OK) return s->error.code;
    if (!s->committed || s->volumes.count) {
        pti_fail(&s->error, PT_ERR_STATE, s->committed ? "pt_scene_refit: the scene has media: build it anew"
                                                       : "pt_scene_refit: the scene is not committed");
        return s->error.code;
    }
    mode = pti_fpmode_enter();
    fine = pti_scene_refit(s, s->threads > 0 ? s->threads : pti_cores());
    pti_fpmode_leave(mode);
    if (!fine && s->error.code == PT_OK) {
        pti_fail(&s->error, PT_ERR_MEMORY, "pt_scene_refit: out of memory");
        s->committed = 0;
    }
    return s->error.code;
}

static const pti_material *pti_material_at(const pt_scene *s, const pt_vertex *x) {
    if (x->instance.id) s = s->geometry.shapes[x->instance.id - 1].as.instance.scene;
    return s->materials + x->material.id;
}

/* One ray, in the mode that pti_fpmode_enter sets. */
static int pti_query(const pt_scene *s, const pt_ray *ray, pti_trace_function *trace, int any, pti_ray *r, pti_hit *hit) {
    if (!pti_finite3(ray->org) || !pti_finite3(ray->dir) || !(pti_largest_abs(ray->dir) >= 1e-37f)) return 0;
    pti_ray_enter(r, &s->geometry.bvh, ray->org, ray->dir, ray->tmin, ray->time);
    pti_hit_init(hit, ray->tmax);
    return trace(&s->geometry, r, hit, any);
}
static int pti_intersect(const pt_scene *s, const pt_ray *ray, pt_vertex *x, int any) {
    pti_ray r;
    pti_hit hit;
    pti_fpmode mode;
    int found;
    if (!s || !ray || !s->committed) return 0;
    mode = pti_fpmode_enter();
    found = pti_query(s, ray, pti_trace_for(s->isa), any, &r, &hit);
    if (found && x) {
        pti_vertex_fill(&s->geometry, &r, &hit, x);
        pti_vertex_coordinates(&s->geometry, x);
    }
    pti_fpmode_leave(mode);
    return found;
}
PT_DEF int pt_intersect(const pt_scene *s, const pt_ray *ray, pt_vertex *x) { return pti_intersect(s, ray, x, 0); }
PT_DEF int pt_occluded(const pt_scene *s, const pt_ray *ray) { return pti_intersect(s, ray, NULL, 1); }

static void pti_hit_tell(const pt_scene *s, const pti_hit *hit, pt_hit *out) {
    const pti_geometry *g = hit->instance ? s->geometry.shapes[hit->instance - 1].as.instance.of : &s->geometry;
    uint32_t shape = hit->shape ? hit->shape - 1 : pti_find_shape(g, hit->prim);
    out->t = hit->t; out->u = hit->u; out->v = hit->v;
    out->prim = hit->prim - g->shapes[shape].first;
    out->shape.id = shape + 1;
    out->instance.id = hit->instance;
}
PT_DEF size_t pt_intersect_all(const pt_scene *s, const pt_ray *rays, size_t count, pt_hit *hits) {
    int there = s && s->committed && rays;
    pti_trace_function *trace = there ? pti_trace_for(s->isa) : NULL;
    pti_fpmode mode = pti_fpmode_enter();
    size_t i, found = 0;
    pti_ray r;
    pti_hit hit;
    for (i = 0; hits && i < count; i++) {
        memset(&hits[i], 0, sizeof hits[i]);
        hits[i].t = HUGE_VALF;
        if (!there || !pti_query(s, rays + i, trace, 0, &r, &hit)) continue;
        pti_hit_tell(s, &hit, hits + i);
        found++;
    }
    pti_fpmode_leave(mode);
    return found;
}
PT_DEF size_t pt_occluded_all(const pt_scene *s, const pt_ray *rays, size_t count, unsigned char *occluded) {
    int there = s && s->committed && rays;
    pti_trace_function *trace = there ? pti_trace_for(s->isa) : NULL;
    pti_fpmode mode = pti_fpmode_enter();
    size_t i, found = 0;
    pti_ray r;
    pti_hit hit;
    for (i = 0; occluded && i < count; i++) {
        occluded[i] = (unsigned char)(there && pti_query(s, rays + i, trace, 1, &r, &hit));
        found += occluded[i];
    }
    pti_fpmode_leave(mode);
    return found;
}

/* ---- >>guide -------------------------------------------------------------------------------------------
   A density that learns where light comes from: through which window. Paths that go ahead of the picture leave a record at
   each vertex x: the direction wi that they took, how far it went, and what came of it, v = f L |cos| / p. Space is cut into
   cubes, and each cube k, seen from x, is a window: a cone of directions round the one to its middle, at distance d_k, with
       tan(a_k / 2) = r / d_k:    cos a_k = (d_k^2 - r^2) / (d_k^2 + r^2),
       p_k(wi) = 1 / (2 pi (1 - cos a_k)) = (d_k^2 + r^2) / (4 pi r^2) inside, 0 outside:
   from afar, as wide as the ball of radius 2 r round the cube; from its middle, all directions; without a root or a division.
   The guide is a mixture of those, sum_k w_k p_k, with weights that hold for all surfaces of a cell that look the same way.
   What lies behind a door's gap, or under a glass ball, is seen through few such windows, and from wherever one stands they are
   aimed at just so: a cell can be as large as a wall, and learns from few records. (Trees over directions, Mueller et
   al. 2017, need small cells, since directions to what is near change with x: on a door ajar, twenty times the records did
   worse. That parallax matters is Ruppert et al.'s point, 2020.) The cubes along a record's way are the windows that it
   may have come through; weights are found by expectation maximisation (Dempster, Laird and Rubin 1977),
       r_k = w_k p_k(wi) / sum_j w_j p_j(wi),    w_k  <-  sum v r_k / sum v,
   where the sum goes over the windows and the other parts of the mixture, BSDF, lights and environment, too: so windows are
   left with what those do not find, and each cell learns its shares of the mixture, as well.
   A cell is half of a larger one, and so on up to all that looks one way. It begins with what the larger one has learned, and
   takes that for the word of m more records than its own n (a Dirichlet prior):
       w_k  <-  (n sum v r_k / sum v + m w'_k) / (n + m).
   Else few records of very different v are learned by heart: on a door ajar that cost two to three times the variance. */
#define PTI_GUIDE_FACES 6                                /* main directions that surfaces look along */
#define PTI_GUIDE_GRID 16                                /* cubes along the longest side of what was seen */
#define PTI_GUIDE_CUBES (PTI_GUIDE_GRID * PTI_GUIDE_GRID * PTI_GUIDE_GRID)
#define PTI_GUIDE_WINDOWS 48                             /* of a cell, at most: those that weigh most */
#define PTI_GUIDE_LANES 8                                /* side by side, for compilers that use them so */
#define PTI_GUIDE_PANES (PTI_GUIDE_WINDOWS / PTI_GUIDE_LANES)
#define PTI_GUIDE_LIGHTEST 0.0005f                       /* what weighs less is noise */
#define PTI_GUIDE_LEAST 0.02f                            /* a cell whose windows weigh less in all has none */
#ifndef PTI_GUIDE_WORTH                                  /* tests guide where it is worth nothing */
#define PTI_GUIDE_WORTH 0.15f                            /* windows that weigh less in the whole scene are not worth their cost */
#endif
#ifndef PTI_GUIDE_PATHS
#define PTI_GUIDE_PATHS 32768                            /* of fewer paths, the guide would learn what they are, not the scene */
#endif
#define PTI_GUIDE_CELL 256                               /* records, for it to be divided when it has twice as many */
#define PTI_GUIDE_LEVELS 16                              /* of cells in cells */
#define PTI_GUIDE_PRIOR 1024                             /* m */
#define PTI_GUIDE_FEW 32                                 /* too few records to learn from */
#define PTI_GUIDE_STEPS 8                                /* of expectation maximisation */
#define PTI_GUIDE_WAYS 4096                              /* records that a cell learns from; of more, only every so many-th */
#define PTI_GUIDE_BRIGHT 200                             /* v counts for up to so many times its mean */
#define PTI_GUIDE_RECORDS 524288                         /* that are kept at a time; each has come to light */
enum { PTI_PART_BSDF, PTI_PART_LIGHTS, PTI_PART_ENVIRONMENT, PTI_PARTS };

typedef struct pti_guide_window { pt_vec3 center; float weight; } pti_guide_window;
typedef struct pti_guide_pane { float x[PTI_GUIDE_LANES], y[PTI_GUIDE_LANES], z[PTI_GUIDE_LANES], weight[PTI_GUIDE_LANES]; }
    pti_guide_pane;
/* Space, divided at split; next: four times the fork that is below it, above it being the one after, and the axis; or, where it is
   divided no more, four times the cell, and 3. Small, since each vertex goes down a dozen of them. */
typedef struct pti_guide_fork { float split; uint32_t next; } pti_guide_fork;
/* count panes of windows, the guide's share of the mixture, and the other parts'. */
typedef struct pti_guide_cell { uint32_t first, count; float share, part[PTI_PARTS]; } pti_guide_cell;
typedef struct pti_guide_record {
    pt_vec3 p, wi;
    float distance, value, part[PTI_PARTS];              /* value: v; part: the other parts' densities of wi */
    uint32_t face;
} pti_guide_record;
typedef struct pti_guide_weights { float cube[PTI_GUIDE_CUBES]; double part[PTI_PARTS]; } pti_guide_weights;
/* The cubes along a record's way, and p_k of each. */
typedef struct pti_guide_way { int count; uint16_t cube[3 * PTI_GUIDE_GRID]; float pdf[3 * PTI_GUIDE_GRID]; } pti_guide_way;
typedef struct pti_guide {
    pti_guide_fork *forks;                               /* the first six: one a face */
    pti_guide_cell *cells;                               /* the first one is empty */
    pti_guide_pane *panes;
    pti_guide_record *records;
    pti_guide_weights *weights;                          /* while cells learn: of the one at each level */
    float *sums;                                         /* of cubes, in a step */
    pti_guide_way *ways;                                 /* of the records that a cell learns from */
    uint32_t fork_count, fork_capacity, cell_count, cell_capacity, pane_count, pane_capacity, record_count, record_capacity;
    pt_vec3 origin;                                      /* of the cubes */
    float size, radius2, narrow;                         /* a cube's side; r^2; 1 / (2 r^2) */
    double share;                                        /* of windows, in the mean over all records */
} pti_guide;

/* Which of +-x, +-y, +-z the side of the surface that wo is on looks along. */
static uint32_t pti_guide_face(const pt_vertex *x) {
    pt_vec3 n = pti_dot(x->ng, x->wo) < 0 ? pti_neg(x->ng) : x->ng;
    float ax = fabsf(n.x), ay = fabsf(n.y), az = fabsf(n.z);
    return ax >= ay && ax >= az ? n.x < 0 : ay >= az ? 2u + (n.y < 0) : 4u + (n.z < 0);
}
static const pti_guide_cell *pti_guide_find(const pti_guide *g, uint32_t face, pt_vec3 p) {
    const pti_guide_fork *f = g->forks + face;
    float at[3], beyond;
    uint32_t bits;
    at[0] = p.x; at[1] = p.y; at[2] = p.z;
    for (; (f->next & 3) != 3; f = g->forks + (f->next >> 2) + (~bits >> 31)) {
        beyond = at[f->next & 3] - f->split;             /* its sign decides: chance would mislead a branch */
        memcpy(&bits, &beyond, sizeof bits);
    }
    return g->cells + (f->next >> 2);
}
/* 1 / (1 - cos a), d2 being the square of the distance. */
static float pti_guide_narrow(const pti_guide *g, float d2) { return 0.5f + d2 * g->narrow; }
static pt_vec3 pti_guide_sample(const pti_guide *g, const pti_guide_cell *c, pt_vec3 p, uint32_t u, uint32_t v) {
    const pti_guide_pane *pane = g->panes + c->first;
    uint32_t k = 0, last = c->count * PTI_GUIDE_LANES - 1;
    double left = (double)u * (1.0 / 4294967296.0), weight;
    float one_minus_cos;
    pt_vec3 d;
    while ((weight = (double)pane[k / PTI_GUIDE_LANES].weight[k % PTI_GUIDE_LANES]) <= left && k < last) {
        left -= weight;
        k++;
    }
    pane += k / PTI_GUIDE_LANES;
    k %= PTI_GUIDE_LANES;
    d = pti_sub(pt_v3(pane->x[k], pane->y[k], pane->z[k]), p);
    one_minus_cos = 1 / pti_guide_narrow(g, pti_dot(d, d));
    u = left < weight ? (uint32_t)(left / weight * 4294967296.0) : 0xffffffffu;               /* whole again */
    d = pti_is_zero3(d) ? pt_v3(0, 0, 1) : pti_normalize(d);
    return pti_sample_cone_about(d, one_minus_cos, pti_u01(u), pti_u01(v));
}
/* Inside is d . wi / |d| >= cos a; squared, with the signs kept. Each lane on its own, without a branch, in this order. */
static float pti_guide_pdf(const pti_guide *g, const pti_guide_cell *c, pt_vec3 p, pt_vec3 wi) {
    const pti_guide_pane *w = g->panes + c->first, *end = w + c->count;
    float sum[PTI_GUIDE_LANES] = { 0, 0, 0, 0, 0, 0, 0, 0 }, r2 = g->radius2;
    int k;
    for (; w < end; w++)
        for (k = 0; k < PTI_GUIDE_LANES; k++) {
            float x = w->x[k] - p.x, y = w->y[k] - p.y, z = w->z[k] - p.z, d2 = x * x + y * y + z * z;
            float along = (x * wi.x + y * wi.y + z * wi.z) * (d2 + r2), far = d2 - r2;
            sum[k] += w->weight[k] * (d2 + r2) * (0.5f + copysignf(0.5f, along * fabsf(along) - d2 * far * fabsf(far)));
        }
    return (((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]))) / (4 * PTI_PI * r2);
}

/* ---- learning ---- */

static pt_vec3 pti_guide_center(const pti_guide *g, int x, int y, int z) {
    return pti_madd(pt_v3((float)x + 0.5f, (float)y + 0.5f, (float)z + 0.5f), g->size, g->origin);
}
/* From one cube to the next (Amanatides and Woo 1987). */
static void pti_guide_walk(const pti_guide *g, const pti_guide_record *r, pti_guide_way *way) {
    int v[3], step[3], k;
    float next[3], delta[3];
    way->count = 0;
    for (k = 0; k < 3; k++) {
        float o = (pti_axis(r->p, k) - pti_axis(g->origin, k)) / g->size, d = pti_axis(r->wi, k) / g->size;
        v[k] = pti_below(pti_clamp(o, -1, PTI_GUIDE_GRID));
        if (v[k] < 0 || v[k] >= PTI_GUIDE_GRID) return;
        step[k] = d < 0 ? -1 : 1;
        delta[k] = fabsf(d) > 1e-30f ? 1 / fabsf(d) : 1e30f;
        next[k] = fabsf(d) > 1e-30f ? ((float)(v[k] + (d > 0)) - o) / d : 1e30f;
    }
    for (;;) {
        pt_vec3 d = pti_sub(pti_guide_center(g, v[0], v[1], v[2]), r->p);
        k = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : next[1] < next[2] ? 1 : 2;
        way->cube[way->count] = (uint16_t)(v[0] + PTI_GUIDE_GRID * (v[1] + PTI_GUIDE_GRID * v[2]));
        way->pdf[way->count++] = 0.5f / PTI_PI * pti_guide_narrow(g, pti_dot(d, d));
        v[k] += step[k];
        if (next[k] > r->distance || v[k] < 0 || v[k] >= PTI_GUIDE_GRID) return;
        next[k] += delta[k];
    }
}
/* A step of expectation maximisation on the weights of a cell, from every stride-th record. 0: there was nothing to learn. */
static int pti_guide_step(pti_guide *g, int level, const pti_guide_record *records, uint32_t n, uint32_t stride, double most) {
    pti_guide_weights *w = g->weights + level;
    const pti_guide_weights *prior = level ? w - 1 : w;
    double total = 0, sum[PTI_PARTS] = { 0, 0, 0 }, r[PTI_PARTS];
    double believed = level ? PTI_GUIDE_PRIOR / (PTI_GUIDE_PRIOR + (double)n) : 0.0;
    const pti_guide_way *way = g->ways;
    uint32_t i;
    int k;
    memset(g->sums, 0, PTI_GUIDE_CUBES * sizeof *g->sums);
    for (i = 0; i < n; i += stride, way++) {
        double v = (double)records[i].value < most ? (double)records[i].value : most, p = 0;
        for (k = 0; k < PTI_PARTS; k++) p += r[k] = w->part[k] * (double)records[i].part[k];
        for (k = 0; k < way->count; k++) p += (double)(way->pdf[k] * w->cube[way->cube[k]]);
        if (!(p > 0)) continue;
        for (k = 0; k < PTI_PARTS; k++) sum[k] += v / p * r[k];
        for (k = 0; k < way->count; k++)
            g->sums[way->cube[k]] += (float)(v / p * (double)(way->pdf[k] * w->cube[way->cube[k]]));
        total += v;
    }
    if (!(total > 0)) return 0;
    for (k = 0; k < PTI_PARTS; k++) w->part[k] = (1 - believed) * (sum[k] / total) + believed * prior->part[k];
    for (k = 0; k < PTI_GUIDE_CUBES; k++)
        w->cube[k] = (float)((1 - believed) * ((double)g->sums[k] / total) + believed * (double)prior->cube[k]);
    return 1;
}
/* At first every cube that was passed weighs the same. */
static void pti_guide_begin(pti_guide_weights *w, const pti_guide_way *way, uint32_t count) {
    const pti_guide_way *end = way + count;
    uint32_t used = 0;
    int k;
    memset(w->cube, 0, sizeof w->cube);
    for (; way < end; way++)
        for (k = 0; k < way->count; k++) { used += !(w->cube[way->cube[k]] > 0); w->cube[way->cube[k]] = 1; }
    for (k = 0; k < PTI_GUIDE_CUBES; k++) w->cube[k] *= used ? 0.5f / (float)used : 0.0f;
    for (k = 0; k < PTI_PARTS; k++) w->part[k] = 0.5 / (double)PTI_PARTS;
}
/* The weights of a cell at that level, from its records and the level's above. */
static void pti_guide_weigh(pti_guide *g, int level, const pti_guide_record *r, uint32_t n) {
    double mean = 0;
    uint32_t i, stride = (n + PTI_GUIDE_WAYS - 1) / PTI_GUIDE_WAYS, count = 0;
    int k;
    for (i = 0; i < n; i++) mean += (double)r[i].value / n;
    for (i = 0; i < n; i += stride) pti_guide_walk(g, r + i, g->ways + count++);
    if (level) g->weights[level] = g->weights[level - 1];
    else pti_guide_begin(g->weights, g->ways, count);
    for (k = 0; k < PTI_GUIDE_STEPS; k++) if (!pti_guide_step(g, level, r, n, stride, PTI_GUIDE_BRIGHT * mean)) return;
}
/* The cubes that weigh most, the first the heaviest; how many. */
static uint32_t pti_guide_heaviest(const pti_guide *g, const pti_guide_weights *weights, pti_guide_window top[PTI_GUIDE_WINDOWS]) {
    int x, y, z;
    uint32_t n = 0, at;
    for (z = 0; z < PTI_GUIDE_GRID; z++) for (y = 0; y < PTI_GUIDE_GRID; y++) for (x = 0; x < PTI_GUIDE_GRID; x++) {
        float w = weights->cube[x + PTI_GUIDE_GRID * (y + PTI_GUIDE_GRID * z)];
        if (!(w > PTI_GUIDE_LIGHTEST) || (n == PTI_GUIDE_WINDOWS && w <= top[n - 1].weight)) continue;
        for (at = n < PTI_GUIDE_WINDOWS ? n++ : n - 1; at > 0 && top[at - 1].weight < w; at--) top[at] = top[at - 1];
        top[at].weight = w;
        top[at].center = pti_guide_center(g, x, y, z);
    }
    return n;
}
static void pti_guide_leaf(pti_guide *g, uint32_t fork, const pti_guide_weights *w, uint32_t n) {
    pti_guide_window top[PTI_GUIDE_WINDOWS];
    pti_guide_cell *c = g->cells + g->cell_count;
    uint32_t i, count;
    int k;
    if (g->cell_count == g->cell_capacity || g->pane_capacity - g->pane_count < PTI_GUIDE_PANES) return;
    memset(c, 0, sizeof *c);
    g->forks[fork].next = g->cell_count++ << 2 | 3;
    count = pti_guide_heaviest(g, w, top);
    for (i = 0; i < count; i++) c->share += top[i].weight;
    g->share += (double)c->share * n / g->record_count;
    if (c->share < PTI_GUIDE_LEAST) return;
    for (k = 0; k < PTI_PARTS; k++) c->part[k] = (float)w->part[k];
    c->first = g->pane_count;
    c->count = (count + PTI_GUIDE_LANES - 1) / PTI_GUIDE_LANES;
    g->pane_count += c->count;
    for (i = 0; i < c->count * PTI_GUIDE_LANES; i++) {
        pti_guide_pane *pane = g->panes + c->first + i / PTI_GUIDE_LANES;
        const pti_guide_window *from = top + (i < count ? i : count - 1);
        k = (int)(i % PTI_GUIDE_LANES);
        pane->x[k] = from->center.x; pane->y[k] = from->center.y; pane->z[k] = from->center.z;
        pane->weight[k] = i < count ? from->weight / c->share : 0.0f;
    }
}
/* Those below split first, along axis (3: the face); how many. */
static uint32_t pti_guide_part(pti_guide_record *r, uint32_t n, int axis, float split) {
    uint32_t i, k = 0;
    for (i = 0; i < n; i++)
        if ((axis < 3 ? pti_axis(r[i].p, axis) : (float)r[i].face) < split) {
            pti_guide_record t = r[i];
            r[i] = r[k];
            r[k++] = t;
        }
    return k;
}
/* The cell of those records: divided along its longest side at their mean, as long as it has many, and is above the last level. */
static void pti_guide_build(pti_guide *g, uint32_t fork, pti_guide_record *r, uint32_t n, int level, int last) {
    pti_bounds b = pti_bounds_empty();
    pti_guide_fork *f = g->forks + fork;
    pt_vec3 d;
    double mean = 0;
    uint32_t i, below, axis;
    f->next = 3;                                         /* the empty cell */
    if (!level && n < PTI_GUIDE_FEW) return;
    pti_guide_weigh(g, level, r, n);
    if (n < 2 * PTI_GUIDE_CELL || level == last || g->fork_capacity - g->fork_count < 2) {
        pti_guide_leaf(g, fork, g->weights + level, n);
        return;
    }
    for (i = 0; i < n; i++) pti_bounds_point(&b, r[i].p);
    d = pti_sub(b.hi, b.lo);
    axis = d.x > d.y && d.x > d.z ? 0u : d.y > d.z ? 1u : 2u;
    for (i = 0; i < n; i++) mean += (double)pti_axis(r[i].p, (int)axis) / n;
    f->split = (float)mean;
    below = pti_guide_part(r, n, (int)axis, f->split);
    if (below == 0 || below == n) { pti_guide_leaf(g, fork, g->weights + level, n); return; }
    i = g->fork_count;
    f->next = i << 2 | axis;
    g->fork_count += 2;
    pti_guide_build(g, i, r, below, level + 1, last);
    pti_guide_build(g, i + 1, r + below, n - below, level + 1, last);
}
/* The cubes that hold all records' ways. What ends in the sky ends nowhere. */
static void pti_guide_place(pti_guide *g) {
    pti_bounds b = pti_bounds_empty();
    pt_vec3 d;
    uint32_t i;
    float half;
    for (i = 0; i < g->record_count; i++) {
        const pti_guide_record *r = g->records + i;
        pti_bounds_point(&b, r->p);
        if (r->distance < 1e12f) pti_bounds_point(&b, pti_madd(r->wi, r->distance, r->p));
    }
    d = pti_sub(b.hi, b.lo);
    half = pti_max(pti_max(d.x, pti_max(d.y, d.z)) * 0.505f, 1e-20f);
    g->size = 2 * half / PTI_GUIDE_GRID;
    g->radius2 = 0.1875f * g->size * g->size;
    g->narrow = 0.5f / g->radius2;
    g->origin = pti_sub(pti_scale(pti_add(b.lo, b.hi), 0.5f), pt_v3(half, half, half));
}
/* Everything anew, from the records. */
static void pti_guide_refine(pti_guide *g, int last) {
    pti_guide_record *r = g->records, *end = r + g->record_count;
    uint32_t face, n;
    g->fork_count = PTI_GUIDE_FACES;
    g->cell_count = 1;
    g->pane_count = 0;
    g->share = 0;
    if (r < end) pti_guide_place(g);
    for (face = 0; face < PTI_GUIDE_FACES; face++, r += n) {
        n = pti_guide_part(r, (uint32_t)(end - r), 3, (float)face + 0.5f);
        pti_guide_build(g, face, r, n, 0, last);
    }
}
static void pti_guide_free(pti_guide *g, const pt_allocator *a) {
    pti_free(a, g->forks, g->fork_capacity, sizeof *g->forks);
    pti_free(a, g->cells, g->cell_capacity, sizeof *g->cells);
    pti_free(a, g->panes, g->pane_capacity, sizeof *g->panes);
    pti_free(a, g->records, g->record_capacity, sizeof *g->records);
    pti_free(a, g->weights, PTI_GUIDE_LEVELS, sizeof *g->weights);
    pti_free(a, g->sums, PTI_GUIDE_CUBES, sizeof *g->sums);
    pti_free(a, g->ways, PTI_GUIDE_WAYS, sizeof *g->ways);
}
/* All that a guide ever has, for up to so many records; with them all, 30 MB. 0 when out of memory. */
static int pti_guide_create(pti_guide *g, const pt_allocator *a, uint32_t records) {
    g->record_capacity = records;
    g->fork_capacity = PTI_GUIDE_FACES + records / PTI_GUIDE_CELL * 4;
    g->cell_capacity = 1 + PTI_GUIDE_FACES + records / PTI_GUIDE_CELL * 2;
    g->pane_capacity = (PTI_GUIDE_FACES + records / PTI_GUIDE_CELL * 2) * PTI_GUIDE_PANES;
    g->forks = (pti_guide_fork *)pti_alloc(a, g->fork_capacity, sizeof *g->forks);
    g->cells = (pti_guide_cell *)pti_alloc(a, g->cell_capacity, sizeof *g->cells);
    g->panes = (pti_guide_pane *)pti_alloc(a, g->pane_capacity, sizeof *g->panes);
    g->records = (pti_guide_record *)pti_alloc(a, records, sizeof *g->records);
    g->weights = (pti_guide_weights *)pti_alloc(a, PTI_GUIDE_LEVELS, sizeof *g->weights);
    g->sums = (float *)pti_alloc(a, PTI_GUIDE_CUBES, sizeof *g->sums);
    g->ways = (pti_guide_way *)pti_alloc(a, PTI_GUIDE_WAYS, sizeof *g->ways);
    return g->forks && g->cells && g->panes && g->records && g->weights && g->sums && g->ways;
}

/* ---- >>mixture -----------------------------------------------------------------------------------------
   The one density that a path's next direction is drawn from:
       p(wi) = sum_i w_i p_i(wi),    sum_i w_i = 1,
   over the BSDF, the lights, the environment, the guide and the user's densities. Whichever part draws wi, p is evaluated over
   all of them, so f |cos| / p is the whole weight, and an emitter that the path then finds counts in full: no second estimator,
   no shadow ray, no weight of multiple importance sampling. ("A Simplified Path Tracing Architecture"; as one sample of a
   mixture it is Veach's balance heuristic, 1997, 9.2.4.) Delta lobes stand outside p: they are taken with a probability,
   and p integrates to the rest. */

typedef struct pti_mixture {
    const pt_scene *scene;
    const pt_vertex *x;
    const pti_surface *surface;
    pti_receiver receiver;                               /* where rays on wo's side start: lamps are aimed at from there */
    int sky;                                             /* which of the environment's tables */
    float bsdf, lights, environment, users;              /* w_i; users: of all the user's densities together */
    float asked;                                         /* sum of their weight x importance; users is less once calmed */
    float guide;                                         /* w_i of the guide, */
    const pti_guide *guided;                             /* if there is one, and x's cell in it */
    const pti_guide_cell *cell;
    float glint;                                         /* how much brighter than usual a sun is in x's gloss: 1 or more */
} pti_mixture;

/* Does all scattering stay on wo's side? */
static int pti_surface_opaque(const pti_surface *s) {
    int i;
    for (i = 0; i < s->count; i++) {
        pti_lobe_kind k = s->lobes[i].kind;
        if (k == PTI_THROUGH || k == PTI_THIN || k == PTI_GLASS || k == PTI_USER_LOBE || k == PTI_PARTICLE) return 0;
    }
    return 1;
}
/* What the light tree is to know of a surface. An opaque one sees nothing below its horizon, the true one, however its shading
   normal bends; through others, and with users' BSDFs, light may come from anywhere. */
static pti_receiver pti_receiver_at(const pti_surface *surface, int opaque) {
    const pt_vertex *x = surface->x;
    pti_receiver r;
    float side = !opaque ? 0.0f : pti_dot(x->ng, x->wo) < 0 ? -1.0f : 1.0f;
    r.p = pti_spawn(x, x->wo);
    r.n = pti_scale(x->ng, side);
    return r;
}
/* What the environment is to know: the normal that light is scattered about, or zero. */
static pt_vec3 pti_surface_normal(const pti_surface *s, int opaque) {
    int i = s->count;
    while (opaque && i-- > 0) if (s->lobes[i].kind < PTI_PASS) return s->lobes[i].n;
    return pt_v3(0, 0, 0);
}

static float pti_density_share(const pt_density_desc *d, const pt_vertex *x) {
    return d->importance ? d->weight * pti_unit(d->importance(d->user, x)) : d->weight;
}
static pti_mixture pti_mixture_at(const pt_scene *s, const pti_surface *surface, const pt_weights *w) {
    pti_mixture mix;
    pt_vec3 normal;
    float from_lights, from_sky, rest;
    size_t i;
    int opaque, automatic = !(w->bsdf > 0 || w->lights > 0 || w->environment > 0);
    mix.scene = s; mix.x = surface->x; mix.surface = surface;
    mix.bsdf = 1; mix.lights = mix.environment = mix.users = mix.asked = mix.guide = 0;
    mix.guided = NULL; mix.cell = NULL;
    mix.glint = 1;
    mix.receiver.p = surface->x->p;
    mix.receiver.n = pt_v3(0, 0, 0);
    mix.sky = PTI_RECEIVER_ALL;
    if (surface->delta > 0.999f) return mix;             /* deltas only */
    from_lights = from_sky = 0;
    opaque = pti_surface_opaque(surface);
    if (s->lights.count) {
        mix.receiver = pti_receiver_at(surface, opaque);
        from_lights = pti_lights_irradiance(&s->lights, &mix.receiver);
    }
    if (s->environment.irradiance) {
        normal = pti_surface_normal(surface, opaque);
        mix.sky = pti_environment_receiver(normal);
        from_sky = pti_environment_irradiance(&s->environment, normal);
    }
    if (automatic) {                                     /* half for the BSDF, which bounds f / p; half for the light */
        rest = from_lights + from_sky;
        if (rest > 0) { mix.lights = 0.5f * from_lights / rest; mix.environment = 0.5f * from_sky / rest; }
    } else {
        float l = from_lights > 0 ? w->lights : 0.0f, e = from_sky > 0 ? w->environment : 0.0f, all = w->bsdf + l + e;
        if (all > 0) { mix.lights = l / all; mix.environment = e / all; mix.bsdf = w->bsdf / all; }
    }
    if (automatic) mix.bsdf = 1 - mix.lights - mix.environment;
    for (i = 0; i < s->density_count; i++) mix.users += pti_density_share(s->densities + i, surface->x);
    mix.asked = mix.users;
    mix.lights *= 1 - mix.users;
    mix.environment *= 1 - mix.users;
    mix.bsdf *= 1 - mix.users;
    return mix;
}
/* Nobody knows beforehand what a part will bring: lamps hide, the sky is behind a roof. So some thousand paths go ahead of the
   picture (see >>render) and look. The second moment of what a vertex sends on, v = f L |cos| / p, and what it costs, the c
   rays from there on, have the derivatives
       dM/dw_i = -E[v^2 p_i / p] = -G_i,    dC/dw_i = E[c p_i / p] = C_i.
   M C is least where all G_i / C_i are equal: a ray to a lamp ends there, one from the BSDF is the first of several. The step
       w_i  <-  w_i sqrt(G_i / C_i) / sum,
   stands still just there, and gets there at once where no direction is drawn by two parts, since G_i = c_i / w_i^2 there.
   But some thousand paths do not see what is rare, such as light from the floor by way of metal to the sun, and it weighs
   1 / w: so each part keeps some. Shares are learned in cells: a hash of the place, in cubes an eighth to a quarter of the
   distance to the camera wide, of the main direction of the normal, and the material. Two that share a cell share weights:
   no harm. */
#define PTI_SHARE_CELLS 4096
#define PTI_SHARE_PRIOR 4                                /* as many records say that all is well as it is */
#define PTI_SHARE_TRAIL 16                               /* vertices of a path that are remembered */
typedef struct pti_share { float part[PTI_PARTS]; } pti_share;           /* all 0: nobody was here */
/* Of records: of the shares that they found, of v^2 p_i / p, of p_i / p, and of c p_i / p. */
typedef struct pti_share_sums { double count, share[PTI_PARTS], part[PTI_PARTS], drawn[PTI_PARTS], cost[PTI_PARTS]; }
    pti_share_sums;
typedef struct pti_shares {
    pt_vec3 eye;
    pti_share *cells;
    pti_share_sums *sums;                                /* of each cell, since the last step */
} pti_shares;
typedef struct pti_share_record {                        /* a vertex; rays: so far */
    uint32_t cell;
    uint64_t rays;
    pt_vec3 L, beta;
    float share[PTI_PARTS], part[PTI_PARTS];
    pti_guide_record guide;                              /* where a guide learns, too; without value and distance */
} pti_share_record;
typedef struct pti_share_trail { int count; pti_share_record records[PTI_SHARE_TRAIL]; } pti_share_trail;

/* 4 / 2^k, with 2^k the power of two below x; exact, and so are products with it. */
static float pti_share_scale(float x) {
    uint32_t bits;
    x = pti_clamp(x, 1e-30f, 1e30f);
    memcpy(&bits, &x, sizeof bits);
    bits &= 0x7f800000u;
    memcpy(&x, &bits, sizeof x);
    return 4 / x;
}
static uint32_t pti_share_coordinate(float x) { return (uint32_t)pti_below(pti_clamp(x, -1e9f, 1e9f)); }
static uint32_t pti_share_cell(const pti_shares *s, const pt_vertex *x) {
    float scale = pti_share_scale(pti_length(pti_sub(x->p, s->eye))), ax = fabsf(x->ns.x), ay = fabsf(x->ns.y), az = fabsf(x->ns.z);
    uint32_t face = ax > ay && ax > az ? x->ns.x > 0 : ay > az ? 2 + (x->ns.y > 0) : 4 + (x->ns.z > 0);
    if (pti_dot(x->ng, x->wo) < 0) face += 6;
    return pti_hash(pti_share_coordinate(x->p.x * scale) * 73856093u + pti_share_coordinate(x->p.y * scale) * 19349663u
                    + pti_share_coordinate(x->p.z * scale) * 83492791u + (x->material.id * 12 + face) * 0x9e3779b1u)
           % PTI_SHARE_CELLS;                            /* primes: Teschner et al. 2003; not their XOR, to which -x -y is x y */
}
static void pti_mixture_learned(pti_mixture *m, const pti_shares *s) {
    float free_share = 1 - m->users, sum;
    const float *w = s->cells[pti_share_cell(s, m->x)].part;
    float lights = m->lights > 0 ? w[PTI_PART_LIGHTS] : 0.0f, environment = m->environment > 0 ? w[PTI_PART_ENVIRONMENT] : 0.0f;
    sum = w[PTI_PART_BSDF] + lights + environment;
    if (!(sum > 0)) return;
    m->lights = free_share * lights / sum;
    m->environment = free_share * environment / sum;
    m->bsdf = free_share - m->lights - m->environment;
}
/* Where the guide has windows, it has learned the shares, too: from many more paths. Weights of the user's own stay; the guide
   then takes from the BSDF. */
#define PTI_GUIDE_LEAST_BSDF 0.25f
#define PTI_GUIDE_LEAST_LIGHT 0.1f
static void pti_mixture_guided(pti_mixture *m, const pti_guide *g, int automatic) {
    const pti_guide_cell *c;
    float l, e, b, each, rest = 1 - m->users;
    if (m->surface->delta > 0.999f) return;
    m->guided = g;
    m->cell = c = pti_guide_find(g, pti_guide_face(m->x), m->x->p);
    if (!c->count) return;
    b = pti_max(c->part[PTI_PART_BSDF], PTI_GUIDE_LEAST_BSDF);
    if (!automatic) {
        m->guide = m->bsdf * c->share / (c->share + b);
    } else {
        l = m->lights > 0 ? pti_max(c->part[PTI_PART_LIGHTS], PTI_GUIDE_LEAST_LIGHT) : 0.0f;
        e = m->environment > 0 ? pti_max(c->part[PTI_PART_ENVIRONMENT], PTI_GUIDE_LEAST_LIGHT) : 0.0f;
        each = rest / (l + e + b + c->share);
        m->lights = l * each;
        m->environment = e * each;
        m->guide = c->share * each;
    }
    m->bsdf = rest - m->lights - m->environment - m->guide;
}
/* A sun in gloss. Shares are learned for a place; but whether rough metal shows a sun there depends on where from it is looked
   at, and light from the floor by way of metal to the sun is what makes the brightest specks. A sun is one direction, so this is
   known before one is drawn: the glossy lobes send on S, where a white matte surface would send on E / pi of all the sky,
       S = sum_suns f(wi) |cos| E_sun.
   The environment's odds against the other parts grow by 1 + S / (E / pi); not endlessly, since something may be in the sun's
   way. Paths that go ahead do without, and learn the odds that this starts from. (The same for lamps, where they are few, brought
   6 % less variance in 7 % more time.) */
#define PTI_GLINT_SUNS 4                                 /* of the first so many */
#define PTI_GLINT_MOST 8.0f
static float pti_surface_glint(const pti_surface *s, const pti_sun *sun) {
    float power = pti_luminance(sun->radiance) * (2 * PTI_PI) * sun->one_minus_cos, sum = 0;
    int same_side = pti_same_side(s->x, s->x->wo, sun->axis), i;
    pt_vec3 f;
    for (i = 0; i < s->count; i++)
        if (s->lobes[i].kind >= PTI_METAL && s->lobes[i].kind <= PTI_MEASURED) {
            pti_lobe_eval(s->lobes + i, s->x, same_side, sun->axis, &f);
            sum += pti_luminance(f);
        }
    return sum * power;
}
static void pti_mixture_glints(pti_mixture *m) {
    const pti_environment *e = &m->scene->environment;
    float sum = 0, all;
    size_t i;
    if (!(m->environment > 0)) return;
    for (i = 0; i < e->sun_count && i < PTI_GLINT_SUNS; i++) sum += pti_surface_glint(m->surface, e->suns + i);
    if (!(sum > 0)) return;
    m->glint = pti_min(1 + PTI_PI * sum / e->irradiance[m->sky], PTI_GLINT_MOST);
    all = 1 + (m->glint - 1) * m->environment;
    m->lights /= all;
    m->users /= all;
    m->guide /= all;
    m->environment *= m->glint / all;
    m->bsdf = 1 - m->lights - m->environment - m->users - m->guide;
}
/* A path that chose the BSDF again and again weighs up to (albedo / share)^depth, without bound in bright rooms: its second
   moment diverges. So a path whose potential (see >>path: its throughput, deltas left out) has grown above 1 gives the other
   parts but the guide w / potential only, and the BSDF the rest. Shares may depend on the path's past. */
static float pti_mixture_calm(pti_mixture *m, float potential) {       /* by how much */
    float calm = potential > 1 ? 1 / potential : 1.0f;
    m->lights *= calm;
    m->environment *= calm;
    m->users *= calm;
    m->bsdf = 1 - m->lights - m->environment - m->users - m->guide;
    return calm;
}
/* Splitting, the other half of roulette (Arvo and Kirk 1990; by what a path can still bring: Vorba and Krivanek 2016). Where
   the potential is above 1, the path goes on along so many rays that none's is (if there may be so many: see pti_path_split); and
   while it is above a third, along so many that the BSDF has one of them, and the lights and the environment have another,
   whatever their shares; where a sun glints, the potential may be less. n rays from p are Veach's balance heuristic with several
   samples, and all that next-event estimation has; but a ray that does not reach the lamp that it was aimed at goes on as well.
   A million at most: infinity times no share is no number. */
#define PTI_SPLIT_LEAST 0.35f
static float pti_mixture_split(pti_mixture *m, float potential) {      /* how many rays */
    float n = pti_min(pti_max(potential, 1), 1e6f), far = m->lights + m->environment, more;
    if (potential * m->glint < PTI_SPLIT_LEAST || !(far > 0) || !(m->bsdf > 0)) return n;
    m->bsdf = pti_max(n * m->bsdf, 1);
    more = pti_max(n * far, 1) / far;
    m->lights *= more; m->environment *= more; m->users *= n; m->guide *= n;
    n = m->bsdf + m->lights + m->environment + m->users + m->guide;
    m->bsdf /= n; m->lights /= n; m->environment /= n; m->users /= n; m->guide /= n;
    return n;
}
/* What the lights' densities have in it. */
static float pti_mixture_pdf_lights(const pti_mixture *m, pt_vec3 wi, pti_drawn *drawn) {
    float p = m->lights > 0 ? m->lights * pti_lights_pdf(&m->scene->lights, &m->receiver, wi, drawn) : 0.0f;
    return m->environment > 0 ? p + m->environment * pti_environment_pdf(&m->scene->environment, m->sky, wi, &drawn->sky) : p;
}
/* The density of wi under the smooth part, by whichever part it was drawn, and *f, the BSDF there times the cosine. Where
   that is 0, nobody wants to know p. *guided: what the guide has in it. */
static float pti_mixture_pdf(const pti_mixture *m, pt_vec3 wi, pti_drawn *drawn, pt_vec3 *f, float *guided) {
    const pt_scene *s = m->scene;
    float p, share;
    size_t i;
    *guided = 0;
    p = m->bsdf * pti_surface_eval(m->surface, wi, f);
    if (pti_is_zero3(*f)) return 0;
    p += pti_mixture_pdf_lights(m, wi, drawn);
    if (m->guide > 0) p += *guided = m->guide * pti_guide_pdf(m->guided, m->cell, m->x->p, wi);
    for (i = 0; m->users > 0 && i < s->density_count; i++) {
        share = pti_density_share(s->densities + i, m->x);
        if (share > 0) p += m->users / m->asked * share * pti_density_of(s->densities[i].pdf(s->densities[i].user, m->x, wi));
    }
    return p;
}
static int pti_mixture_sample_user(const pti_mixture *m, uint32_t *choice, const float u[2], pt_vec3 *wi) {
    const pt_density_desc *d = m->scene->densities, *last = d + m->scene->density_count, *drawn = d;
    float left = m->asked, share;
    for (; d < last; d++) {
        share = pti_density_share(d, m->x);
        if (!(share > 0)) continue;
        drawn = d;
        if (pti_split(choice, share / left)) break;
        left -= share;
    }
    return drawn->sample(drawn->user, m->x, u, wi);
}

/* From the lights' densities alone, which must have all the shares. */
static int pti_mixture_sample_lights(const pti_mixture *m, uint32_t u, uint32_t v, uint32_t choice[2], pt_vec3 *wi,
                                     pti_drawn *drawn) {
    const pt_scene *s = m->scene;
    drawn->by = NULL;
    if (m->environment <= 0 || (m->lights > 0 && pti_split(choice, m->lights)))
        return pti_lights_sample(&s->lights, &m->receiver, choice[0], pti_u01(u), pti_u01(v), wi, drawn);
    return pti_environment_sample(&s->environment, m->sky, u, pti_u01(v), wi, &drawn->sky);
}

static int pti_is_direction(pt_vec3 d) { return fabsf(pti_dot(d, d) - 1) < 1e-3f; }         /* not with NaN */

/* A next direction: weight = f |cos| / p. p: 0 of a delta. plain: p over what it would be without the guide, for roulette and
   splitting: through a window, weights are small just because light is there. */
typedef struct pti_step { pt_vec3 wi, weight; int delta; float p, plain; pti_on_map sky; } pti_step;

/* u and v become the direction; which part draws it is decided by u first, which is then stretched to fill that part. choice
   picks among lights or the user's densities, its second number what a lobe has to decide; where neither is, it may be anything.
   0: the path ends here. */
static int pti_mixture_sample(const pti_mixture *m, uint32_t u, uint32_t v, const uint32_t choice[2], pti_step *step) {
    const pt_scene *s = m->scene;
    float others = 1 - m->bsdf, uv[2], p, guided;
    uint32_t among = choice[0];
    pt_vec3 f;
    pt_scatter scatter;
    pti_drawn known = pti_drawn_nothing();
    int drawn;
    memset(&scatter, 0, sizeof scatter);
    step->delta = 0;
    step->sky.known = 0;
    step->p = 0;
    step->plain = 1;
    if (others <= 0 || pti_split(&u, m->bsdf)) {
        drawn = pti_surface_sample(m->surface, u, v, choice[1], &scatter);
        step->wi = scatter.wi;
    } else if (m->guide > 0 && pti_split(&u, m->guide / others)) {
        step->wi = pti_guide_sample(m->guided, m->cell, m->x->p, u, v);
        drawn = 1;
    } else if (m->lights > 0 && pti_split(&u, m->lights / (others - m->guide))) {
        drawn = pti_lights_sample(&s->lights, &m->receiver, among, pti_u01(u), pti_u01(v), &step->wi, &known);
    } else if (m->users <= 0 || (m->environment > 0 && pti_split(&u, m->environment / (m->environment + m->users)))) {
        drawn = m->environment > 0 && pti_environment_sample(&s->environment, m->sky, u, pti_u01(v), &step->wi, &known.sky);
    } else {
        uv[0] = pti_u01(u); uv[1] = pti_u01(v);
        drawn = pti_mixture_sample_user(m, &among, uv, &step->wi);
    }
    if (!drawn) return 0;
    step->delta = scatter.delta;
    if (scatter.delta) {
        if (scatter.pdf <= 0 || pti_is_zero3(scatter.f)) return 0;
        step->weight = pti_scale(scatter.f, 1 / (m->bsdf * scatter.pdf));
        return 1;
    }
    step->weight = pt_v3(-1, -1, -1);                    /* a user's NaN, or no unit vector: the path will see it */
    if (!pti_is_direction(step->wi)) return 1;
    p = pti_mixture_pdf(m, step->wi, &known, &f, &guided);
    step->sky = known.sky;
    if (pti_is_zero3(f) || p <= 0) return 0;             /* NaN goes on: the film will count it */
    step->p = p;
    step->weight = pti_scale(f, 1 / p);
    if (guided > 0) step->plain = (1 - m->guide) / pti_max(1 - guided / p, 1e-3f);
    return 1;
}

/* For the shares and the guide: where that was, and what each part had to do with wi. L and beta are the path's, before its
   weight. s: NULL where no shares are learned. */
static void pti_mixture_note(const pti_mixture *m, float calm, const pti_step *step, const pti_shares *s, pt_vec3 L,
                             pt_vec3 beta, uint64_t rays, pti_share_trail *trail) {
    pti_share_record *r = trail->records + trail->count;
    pti_on_map sky = step->sky;
    pt_vec3 f;
    int k;
    if (trail->count == PTI_SHARE_TRAIL || step->delta) return;
    if (m->bsdf + m->users >= 1 && !m->guided) return;   /* nothing is shared there */
    trail->count++;
    r->cell = s ? pti_share_cell(s, m->x) : 0;
    r->L = L;
    r->beta = beta;
    r->rays = rays;
    r->share[PTI_PART_LIGHTS] = m->lights / calm;        /* as it was; of calm there is time enough later */
    r->share[PTI_PART_ENVIRONMENT] = m->environment / calm;
    r->share[PTI_PART_BSDF] = pti_max(1 - (m->users + m->lights + m->environment) / calm, 0);
    r->part[PTI_PART_BSDF] = step->p > 0 ? pti_surface_eval(m->surface, step->wi, &f) / step->p : 0.0f;
    r->part[PTI_PART_LIGHTS] = step->p > 0 && m->lights > 0
        ? pti_lights_pdf(&m->scene->lights, &m->receiver, step->wi, NULL) / step->p : 0.0f;
    r->part[PTI_PART_ENVIRONMENT] = step->p > 0 && m->environment > 0
        ? pti_environment_pdf(&m->scene->environment, m->sky, step->wi, &sky) / step->p : 0.0f;
    r->guide.p = m->x->p;
    r->guide.wi = step->wi;
    r->guide.face = pti_guide_face(m->x);
    for (k = 0; k < PTI_PARTS; k++) r->guide.part[k] = r->part[k] * step->p;
}
static float pti_share_ratio(float L, float beta) { return L > 0 && beta > 0 ? L / beta : 0.0f; }
/* v: what the record's step brought, on a path with radiance L in all. */
static float pti_share_value(const pti_share_record *r, pt_vec3 L) {
    pt_vec3 d = pti_sub(L, r->L);
    return pti_luminance(pt_v3(pti_share_ratio(d.x, r->beta.x), pti_share_ratio(d.y, r->beta.y), pti_share_ratio(d.z, r->beta.z)));
}
/* A path has ended, with radiance L in all. A step that ended on a mirror or glass, or in the sky, has no next record: then it
   went on until further notice. */
static void pti_guide_learn(pti_guide *g, const pti_share_trail *trail, pt_vec3 L) {
    int i;
    if (!pti_finite3(L)) return;
    for (i = 0; i < trail->count && g->record_count < g->record_capacity; i++) {
        pti_guide_record *r = g->records + g->record_count;
        pt_vec3 to;
        *r = trail->records[i].guide;
        r->value = pti_share_value(trail->records + i, L);
        r->distance = 1e30f;
        if (i + 1 < trail->count) {
            to = pti_sub(trail->records[i + 1].guide.p, r->p);
            if (pti_dot(to, r->wi) > 0.9999f * pti_length(to)) r->distance = pti_length(to);
        }
        g->record_count += r->value > 0 && r->value < 1e20f;
    }
}
/* A path has ended, with radiance L in all. */
static void pti_shares_learn(pti_shares *s, const pti_share_trail *trail, pt_vec3 L, uint64_t rays) {
    int i, k;
    if (!pti_finite3(L)) return;
    for (i = 0; i < trail->count; i++) {
        const pti_share_record *r = trail->records + i;
        pti_share_sums *sums = s->sums + r->cell;
        double v = (double)pti_share_value(r, L);
        sums->count++;
        for (k = 0; k < PTI_PARTS; k++) {
            sums->share[k] += (double)r->share[k];
            sums->part[k] += v * v * (double)r->part[k];
            sums->drawn[k] += (double)r->part[k];
            sums->cost[k] += (double)r->part[k] * ((double)(rays - r->rays) + 1);
        }
    }
}
/* The step, for all cells that were visited. */
static void pti_shares_step(pti_shares *s) {
    static const double least[PTI_PARTS] = { 0.3, 0.15, 0.15 };
    const double prior = PTI_SHARE_PRIOR;
    int i, k;
    for (i = 0; i < PTI_SHARE_CELLS; i++) {
        const pti_share_sums *sums = s->sums + i;
        double w[PTI_PARTS], mean = 0, sum = 0;
        for (k = 0; k < PTI_PARTS; k++) mean += sums->share[k] * sums->part[k] / (sums->count * sums->count + 1e-30);
        for (k = 0; k < PTI_PARTS; k++) {
            double g = mean > 0 ? (sums->part[k] / mean + prior) / (sums->count + prior) : 1.0;
            sum += w[k] = sums->share[k] * sqrt(g * (sums->drawn[k] + prior) / (sums->cost[k] + 2 * prior));
        }
        if (!(sum > 0)) continue;
        for (mean = 0, k = 0; k < PTI_PARTS; k++) {
            w[k] = w[k] > 0 ? (w[k] / sum > least[k] ? w[k] / sum : least[k]) : 0.0;
            mean += w[k];
        }
        for (k = 0; k < PTI_PARTS; k++) s->cells[i].part[k] = (float)(w[k] / mean);
    }
    memset(s->sums, 0, PTI_SHARE_CELLS * sizeof *s->sums);
}

/* ---- >>path --------------------------------------------------------------------------------------------
   The estimator, one ray a vertex, or n strata of p:
       L += beta Le;   wi ~ p;   beta *= f |cos| / (n p)
   Dimensions: group 0 is the pixel's, group 1 + k that of vertex k, unless the path came from a split; the moment and the
   wavelength have their own. */
#define PTI_GROUP_SHUTTER 0xffffffffu                    /* no path has so many vertices */
#define PTI_GROUP_WAVELENGTH 0xfffffffeu
#define PTI_GROUP_SHADOW 0x80000000u                     /* half of all groups */
#define PTI_GROUP_FLIGHT 0x40000000u                     /* a quarter; below it, depth has 28 bits */
#define PTI_GROUP_MASK 0x3fffffffu                       /* the rest */

typedef struct pti_tracer {                              /* what all paths of a render share */
    const pt_scene *scene;
    pti_trace_function *trace;
    pt_weights weights;
    pt_integrator integrator;
    pt_roulette roulette;
    int max_depth, max_diffuse, max_split;
    const pti_shares *shares;                            /* NULL: none were learned */
    const pti_guide *guide;                              /* NULL: there is none, or not yet */
} pti_tracer;

/* Roulette looks at what a path can still bring, its potential: the throughput without the weights of deltas, since behind
   tinted glass all paths are dim and none is worth less for it. It plays after the emission at a vertex has been added, not
   before the ray there is traced: a path that aims at a lamp has a small f / p just because the lamp is bright. For the same
   reason it does not play at mirrors and panes, behind which the lamp may be. And radiance that glass has squeezed is no
   less: it comes out again. And it begins late: a path that ends at its second vertex saves few rays, since most would soon
   be lost anyway, and costs much noise. With a start of 1, relMSE x rays was worse than without roulette on 10 of 14 scenes
   (tests/bench/figure_roulette.c), with 1/4 on none. */
#define PTI_ROULETTE_START 0.25f
#define PTI_ROULETTE_LEAST 0.05f
static int pti_roulette(float by, pt_vec3 *beta, pt_vec3 *potential, uint32_t u) {
    float q = pti_max(by * (1 / PTI_ROULETTE_START), PTI_ROULETTE_LEAST);
    if (q >= 1) return 1;
    if (!pti_split(&u, q)) return 0;
    *beta = pti_scale(*beta, 1 / q);
    *potential = pti_scale(*potential, 1 / q);
    return 1;
}
static int pti_path_goes_on(const pti_tracer *t, const pti_surface *surface, pt_vec3 *beta, pt_vec3 *potential,
                            uint32_t u) {
    float by = pti_largest(t->roulette == PT_ROULETTE_POTENTIAL ? *potential : *beta);
    if (t->roulette == PT_ROULETTE_NONE) return 1;
    if (t->roulette == PT_ROULETTE_POTENTIAL && (!(by < PTI_ROULETTE_START) || surface->delta >= 0.999f)) return 1;
    return pti_roulette(by, beta, potential, u);
}
/* A limit on diffuse scattering is one on light, not on vertices: what leaves a surface is a sum over lobes, each term of
   which counts or does not, however wi was drawn. So a path draws lots for who scattered it, with odds as the terms, and at
   the limit surfaces have no diffuse lobes left. A floor with gloss then still shows the room, lit as the limit has it. */
static int pti_lobe_is_diffuse(const pti_lobe *l) {
    return l->kind <= PTI_FUZZ || l->kind == PTI_USER_LOBE || l->kind == PTI_PARTICLE;
}
static int pti_surface_drop_diffuse(pti_surface *s) {    /* 0 if nothing is left */
    float sum = 0, delta = 0;
    int i, n = 0;
    for (i = 0; i < s->count; i++) {
        if (pti_lobe_is_diffuse(s->lobes + i)) continue;
        sum += s->lobes[i].share;
        if (s->lobes[i].kind >= PTI_PASS) delta += s->lobes[i].share;
        if (n < i) s->lobes[n] = s->lobes[i];
        n++;
    }
    for (i = 0; i < n; i++) s->lobes[i].share /= sum;
    s->count = n;
    s->delta = n ? delta / sum : 0.0f;
    return n;
}
static float pti_part_over(float part, float whole) { return whole > 0 ? part / whole : 0.0f; }
/* 1 if it was a diffuse lobe; the step's weight becomes that of the term. */
static int pti_step_is_diffuse(const pti_surface *s, pti_step *step, uint32_t u) {
    int same_side = pti_same_side(s->x, s->x->wo, step->wi), diffuse = 0, others = 0, was, i;
    pt_vec3 f[2], one, all;
    float q;
    for (i = 0; i < s->count; i++)
        if (pti_lobe_is_diffuse(s->lobes + i)) diffuse++;
        else if (s->lobes[i].kind < PTI_PASS) others++;
    if (step->delta || !diffuse || !others) return !step->delta && diffuse;
    f[0] = f[1] = pt_v3(0, 0, 0);
    for (i = 0; i < s->count; i++) {
        was = pti_lobe_is_diffuse(s->lobes + i);
        pti_lobe_eval(s->lobes + i, s->x, same_side, step->wi, &one);
        f[was] = pti_add(f[was], one);
    }
    all = pti_add(f[0], f[1]);
    q = pti_part_over(pti_luminance(f[1]), pti_luminance(all));
    was = pti_split(&u, q);
    one = pt_v3(pti_part_over(f[was].x, all.x), pti_part_over(f[was].y, all.y), pti_part_over(f[was].z, all.z));
    step->weight = pti_mul(step->weight, pti_scale(one, 1 / (was ? q : 1 - q)));
    return was;
}
/* The next vertex of a path, and its material; NULL: none, the sky. */
static const pti_material *pti_path_trace(const pti_tracer *t, pt_vec3 org, pt_vec3 dir, float time, pt_vertex *x,
                                          uint64_t *rays) {
    const pt_scene *s = t->scene;
    const pti_material *m;
    pti_ray ray;
    pti_hit hit;
    pti_ray_enter(&ray, &s->geometry.bvh, org, dir, 0, time);
    pti_hit_init(&hit, 0);
    ++*rays;
    if (!t->trace(&s->geometry, &ray, &hit, 0)) return NULL;
    pti_vertex_fill(&s->geometry, &ray, &hit, x);
    m = pti_material_at(s, x);
    if (m->wants_coordinates || s->density_count) pti_vertex_coordinates(&s->geometry, x);
    return m;
}
/* The path's one wavelength, and in *beta its colour. */
static float pti_path_wavelength(const pti_tracer *t, const pti_sampler *sampler, pt_vec3 *beta) {
    float u = pti_u01(pti_draw1(sampler, PTI_GROUP_WAVELENGTH)), wavelength;
    pt_vec3 color;
    wavelength = pti_sample_wavelength(&t->scene->spectrum, u, &color);
    *beta = pti_mul(*beta, color);
    return wavelength;
}
static float pti_sky_mean(const pti_environment *sky) {
    return sky->irradiance ? sky->irradiance[PTI_RECEIVER_ALL] / (4 * PTI_PI) : sky->present ? sky->mean : 0.0f;
}
/* Paths by the BSDF alone are there to compare with: their flights just hit or pass. */
static int pti_path_is_naive(const pti_tracer *t) {
    const pt_weights *w = &t->weights;
    return w->bsdf > 0 && !(w->lights > 0) && !(w->environment > 0);
}
/* Lamps that the flight's distances are aimed at: all if they are few, else those that the tree chooses for two places on the
   way. */
static void pti_path_aim_at(pti_flight *f, const pti_lamp *l) {
    pti_aim *aim = f->aims + f->aim_count++;
    pt_vec3 d = pti_sub(l->p, f->org);
    aim->at = pti_dot(d, f->dir);
    d = pti_madd(f->dir, -aim->at, d);
    aim->distance = pti_max(pti_max(pti_length(d), 0.5f * l->radius), 1e-6f);
    aim->power = l->power * 0.25f;
}
static void pti_path_aim(const pti_tracer *t, pti_flight *f, float end) {
    const pti_lights *l = &t->scene->lights;
    pti_receiver r;
    uint32_t k;
    f->sky = 4 * PTI_PI * pti_sky_mean(&t->scene->environment);
    if (l->count <= PTI_AIMS) {
        for (k = 0; k < l->count; k++) pti_path_aim_at(f, f->volumes->lamps + k);
        return;
    }
    end = pti_min(end, 2 / pti_max(f->volumes->least, 1e-30f));
    r.n = pt_v3(0, 0, 0);
    for (k = 0; k < 2; k++) {
        uint32_t u = pti_hash2(f->seed, f->index ^ (k + 1) * 0x9e3779b9u);
        const pti_emitter *e;
        pti_lamp lamp;
        r.p = pti_madd(f->dir, end * 0.5f * ((float)k + pti_u01(u)), f->org);
        e = pti_lights_choose(l, &r, pti_hash(u));
        if (!e) continue;
        lamp = pti_lamp_of(e);
        pti_path_aim_at(f, &lamp);
    }
}
/* How much brighter it is at a particle than the path thinks. Who aims at a lamp has a small f / p, but who then hits a particle
   right before it will bring much; so will who flies nearly towards a sun and is scattered nearly straight on. They are no
   victims for roulette. */
static float pti_path_brightening(const pt_scene *s, pt_vec3 from, pt_vec3 dir, const pt_vertex *x) {
    const pti_lights *l = &s->lights;
    float bright = 1, before;
    pti_receiver r;
    r.n = pt_v3(0, 0, 0);
    r.p = from;
    if (l->count) {
        before = pti_lights_irradiance(l, &r);
        r.p = x->p;
        bright = pti_max(1, pti_lights_irradiance(l, &r) / pti_max(before, 1e-30f));
    }
    if (s->environment.sun_count) bright = pti_max(bright, 4 * PTI_PI * pti_aureole_pdf((void *)(uintptr_t)s, x, dir));
    return bright;
}
/* What a flight changes of a path. Le: what the ray's end emits, to be added if it gets there. */
typedef struct pti_carried { pt_vec3 L, beta, potential, Le; int exceeded; } pti_carried;
/* What a ray's end emits is worth Le if the flight gets there, or T Le in any case: the same in the mean. The latter is better for
   lamps, since rays are aimed at them; the former for an even sky, since paths end there sooner or later, wherever they leave. So
   T Le it is for a part of Le, that above the sky's mean, where T is known without trying. */
static void pti_path_see(const pti_tracer *t, pti_flight *f, float end, int lamp, pti_carried *c) {
    float l = pti_luminance(c->Le), part = lamp ? 1.0f : l > 0 ? 1 - pti_sky_mean(&t->scene->environment) / l : 0.0f;
    pt_vec3 seen = pti_scale(c->Le, part);
    if (!(l > 0) || part < 0.01f || !pti_flight_is_plain(f, end)) return;
    c->L = pti_add(c->L, pti_mul(pti_mul(c->beta, seen), pti_flight_transmittance(f, end)));
    c->Le = lamp ? pt_v3(0, 0, 0) : pti_sub(c->Le, seen);
}

static void pti_path_hero(const pti_sampler *sampler, uint32_t group, pt_vec3 beta, pt_vec3 *q, int *hero) {
    float sum = beta.x + beta.y + beta.z, u;
    uint32_t v[2];
    *q = sum > 0 && pti_finite(sum) ? pti_scale(beta, 1 / sum) : pt_v3(1.0f / 3, 1.0f / 3, 1.0f / 3);
    pti_draw2(sampler, group, 1, v);
    u = pti_u01(v[0]);
    *hero = u < q->x ? 0 : u < q->x + q->y || !(q->z > 0) ? (q->y > 0 ? 1 : 0) : 2;
}
/* The path's ray, whose nearest surface was x, of material m, or NULL, flies through the volumes. If it hits a particle, x
   becomes that, and its material, which is all a phase function, is returned instead of m: the rest of the path need not know. */
PTI_NOINLINE const pti_material *pti_path_fly(const pti_tracer *t, const pti_sampler *sampler, uint32_t group, pt_vec3 org,
                                              pt_vec3 dir, float time, pt_vertex *x, const pti_material *m, pti_carried *c) {
    const pti_volumes *volumes = &t->scene->volumes;
    const pti_volume *hit;
    pt_vec3 q = pt_v3(1, 0, 0), w;
    float at = m ? x->t : FLT_MAX;
    pti_flight f;
    f.volumes = volumes; f.trace = t->trace;
    f.org = org; f.dir = dir; f.time = time;
    f.group = PTI_GROUP_FLIGHT | group;
    f.sampler = sampler;
    f.seed = pti_hash2(sampler->pixel_seed, f.group);
    f.index = sampler->index;
    f.hero = 0;
    f.end = at;
    f.sky = 0;
    f.aim_count = 0;
    f.stretch_of = NULL;
    f.blind = f.exceeded = 0;
    if (!pti_path_is_naive(t)) {
        if (volumes->aim && t->scene->lights.count) pti_path_aim(t, &f, at);
        pti_path_see(t, &f, at, m != NULL, c);
        f.blind = volumes->count == 1 && !volumes->emit && pti_is_zero3(c->Le)
               && (!m || (m->plain && pti_is_zero3(m->desc.color)));
    }
    if (volumes->chromatic) pti_path_hero(sampler, f.group, c->beta, &q, &f.hero);
    hit = pti_flight_hit(&f, &at);
    if (volumes->emit && !f.exceeded) c->L = pti_add(c->L, pti_mul(c->beta, pti_flight_glow(&f, at, q)));
    w = pti_flight_weight(&f, at, hit, q);
    c->exceeded = f.exceeded;
    c->beta = pti_mul(c->beta, w);
    c->potential = pti_mul(c->potential, w);
    if (!hit) return m;
    memset(x, 0, sizeof *x);
    x->p = pti_madd(dir, at, org);
    x->wo = pti_neg(dir);
    x->t = at;
    x->time = time;
    x->volume.id = hit->id;
    x->instance.id = hit->instance;
    return hit->scatterer;
}
/* How much of the light comes through. No sampler has numbers for it: they are hashed from where it goes. */
static uint32_t pti_hash_float(float x, uint32_t h) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return pti_hash2(bits, h);
}
static pt_vec3 pti_path_transmittance(const pti_tracer *t, pt_vec3 org, pt_vec3 dir, float time, float end) {
    pti_flight f;
    memset(&f, 0, sizeof f);
    f.volumes = &t->scene->volumes; f.trace = t->trace;
    f.org = org; f.dir = dir; f.time = time;
    f.seed = pti_hash_float(org.x, pti_hash_float(org.y, pti_hash_float(org.z, 1)));
    f.index = pti_hash_float(dir.x, pti_hash_float(dir.y, pti_hash_float(dir.z, f.seed)));
    return pti_flight_transmittance(&f, end);
}
/* Next-event estimation, the other integrator. Two densities share a vertex: p_b of the mixture without its lights, from
   which the path goes on, and p_l of the lights alone, from which one more ray is drawn. Both find emission,
       L += beta (f |cos| Le w_l / p_l + f |cos| Le w_b / p_b),    w_l = p_l^2 / (p_l^2 + p_b^2),    w_b = 1 - w_l,
   one Le along wi_l, one along wi_b (Veach and Guibas 1995, power heuristic). Both are densities over directions, so Le is
   that of the nearest surface, whichever emitter was aimed at, and p_l counts all emitters along wi. What a delta shows,
   p_l does not draw: it counts in full. So does what is behind something that lets light straight through, since the
   ray that is drawn from the lights ends there.
   To each light: one ray from each emitter's density, and from the environment's as many as it has suns and a map, which
   are strata of its u; then p_l is the sum. */
typedef struct pti_nee {
    pti_mixture lights;                                  /* of nothing else; *x and *surface are gone at the next vertex */
    float each;                                          /* 0, or how many rays the environment gets */
    float p;                                             /* p_b of the path's own next ray; 0: it counts in full */
} pti_nee;

/* Takes the lights out of the mixture. 0: there are none. */
static int pti_nee_split(pti_mixture *m, int each, pti_nee *n) {
    const pti_environment *e = &m->scene->environment;
    float sum = m->lights + m->environment;
    n->lights = *m;
    n->p = 0;
    n->each = each ? (float)(e->sun_count + (e->textured ? 1u : 0u)) : 0.0f;
    n->lights.bsdf = n->lights.users = n->lights.guide = 0;
    m->lights = m->environment = 0;
    m->bsdf = 1 - m->users - m->guide;
    if (!(sum > 0)) return 0;
    n->lights.lights /= sum;
    n->lights.environment /= sum;
    return 1;
}
static float pti_nee_pdf(const pti_nee *n, pt_vec3 wi, pti_drawn *drawn, int each) {
    const pti_mixture *m = &n->lights;
    const pti_lights *l = &m->scene->lights;
    float p = 0;
    size_t i;
    if (!each) return pti_mixture_pdf_lights(m, wi, drawn);
    for (i = 0; m->lights > 0 && i < l->count; i++) p += pti_drawn_pdf(drawn, l->emitters + i, m->receiver.p, wi);
    return m->environment > 0 ? p + n->each * pti_environment_pdf(&m->scene->environment, m->sky, wi, &drawn->sky) : p;
}
static float pti_power_heuristic(float p, float other) {
    float r = p > 0 ? other / p : 0.0f;
    return p > 0 ? 1 / (1 + r * r) : 0.0f;
}
/* The weight of emission that the path's own ray along wi found. */
static float pti_nee_found(const pti_tracer *t, const pti_nee *n, pt_vec3 wi, const pti_on_map *sky) {
    pti_drawn known = pti_drawn_nothing();
    if (!(n->p > 0)) return 1;
    known.sky = *sky;
    return pti_power_heuristic(n->p, pti_nee_pdf(n, wi, &known, t->integrator == PT_INTEGRATOR_NEE_ALL));
}
/* What the nearest surface emits, or the sky. */
static pt_vec3 pti_path_emission(const pti_tracer *t, const pt_vertex *from, pt_vec3 wi, pti_on_map *sky, uint64_t *rays) {
    pt_vertex x;
    pt_vec3 L, org = pti_spawn(from, wi);
    const pti_material *m = pti_path_trace(t, org, wi, from->time, &x, rays);
    if (!m) L = pti_environment_radiance(&t->scene->environment, wi, sky);
    else {
        if (!m->emits) return pt_v3(0, 0, 0);
        x.wavelength = from->wavelength;
        L = pti_material_emission(m, &x);
    }
    if (!t->scene->volumes.count) return L;
    return pti_mul(L, pti_path_transmittance(t, org, wi, from->time, m ? x.t : FLT_MAX));
}
/* f |cos| Le w_l / p_l for a wi that was drawn from the lights. */
static pt_vec3 pti_nee_gather(const pti_tracer *t, const pti_nee *n, const pti_mixture *m, pt_vec3 wi, pti_drawn *drawn,
                              uint64_t *rays) {
    pt_vec3 f, L;
    float guided, q = pti_mixture_pdf(m, wi, drawn, &f, &guided), p;
    if (pti_is_zero3(f)) return f;
    L = pti_mul(f, pti_path_emission(t, m->x, wi, &drawn->sky, rays));
    if (pti_is_zero3(L)) return L;
    p = pti_nee_pdf(n, wi, drawn, t->integrator == PT_INTEGRATOR_NEE_ALL);
    return p > 0 ? pti_scale(L, pti_power_heuristic(p, q) / p) : pt_v3(0, 0, 0);
}
static pt_vec3 pti_nee_one(const pti_tracer *t, const pti_nee *n, const pti_mixture *m, const pti_sampler *sampler,
                           uint32_t group, uint64_t *rays) {
    const pti_mixture *l = &n->lights;
    uint32_t u[2], choice[2] = { 0, 0 };
    pti_drawn drawn = pti_drawn_nothing();
    pt_vec3 wi;
    pti_draw2(sampler, group, 0, u);
    if (t->scene->lights.count > 1 || l->environment > 0) pti_draw2(sampler, group, 1, choice);
    if (!pti_mixture_sample_lights(l, u[0], u[1], choice, &wi, &drawn)) return pt_v3(0, 0, 0);
    return pti_nee_gather(t, n, m, wi, &drawn, rays);
}
static pt_vec3 pti_nee_each(const pti_tracer *t, const pti_nee *n, const pti_mixture *m, const pti_sampler *sampler,
                            uint32_t group, uint64_t *rays) {
    const pti_lights *l = &t->scene->lights;
    uint32_t count = n->lights.lights > 0 ? (uint32_t)l->count : 0, k, u[2];
    uint32_t sky = n->lights.environment > 0 ? (uint32_t)n->each : 0;
    pt_vec3 L = pt_v3(0, 0, 0), wi;
    pti_drawn drawn;
    int is_drawn;
    for (k = 0; k < count + sky; k++) {
        pti_draw2(sampler, PTI_GROUP_SHADOW | pti_hash2(group, k), 0, u);
        if (k >= count) u[0] = (uint32_t)(((uint64_t)(k - count) << 32 | u[0]) / sky);
        drawn = pti_drawn_nothing();
        drawn.by = k < count ? l->emitters + k : NULL;
        if (k < count) {
            drawn.pdf = pti_emitter_sample(drawn.by, m->receiver.p, pti_u01(u[0]), pti_u01(u[1]), &wi);
            is_drawn = drawn.pdf > 0;
        } else is_drawn = pti_environment_sample(&t->scene->environment, m->sky, u[0], pti_u01(u[1]), &wi, &drawn.sky);
        if (is_drawn) L = pti_add(L, pti_nee_gather(t, n, m, wi, &drawn, rays));
    }
    return L;
}
/* What the lights send to the vertex where m stands; m goes on without them. */
static pt_vec3 pti_nee_at(const pti_tracer *t, pti_mixture *m, const pti_sampler *sampler, uint32_t depth, pti_nee *n,
                          uint64_t *rays) {
    int each = t->integrator == PT_INTEGRATOR_NEE_ALL;
    if (!pti_nee_split(m, each, n)) return pt_v3(0, 0, 0);
    return each ? pti_nee_each(t, n, m, sampler, depth, rays)
                : pti_nee_one(t, n, m, sampler, PTI_GROUP_SHADOW | depth, rays);
}

#define PTI_EXCEEDED -2.0f                               /* radiance of a path that met too high a density */
/* A path that is to go on along a ray. */
typedef struct pti_path {
    pt_vec3 org, dir, beta, potential;
    pti_on_map sky;                                      /* where dir is on it */
    float wavelength;                                    /* 0: all of them */
    uint32_t group;                                      /* of numbers, for its next vertex */
    int depth, diffuse;                                  /* scatterings so far, and those by diffuse lobes */
} pti_path;
/* One sample: its paths that are still to be followed, the last one first, and what they have brought. */
#define PTI_PATHS 24
typedef struct pti_walk {
    const pti_tracer *tracer;
    const pti_sampler *sampler;
    pti_path path[PTI_PATHS];
    int count;
    float time;
    pt_vec3 L;
    pti_nee nee;
    uint64_t *rays, first_ray;                           /* so many so far, and before this sample */
    pti_share_trail *trail;                              /* NULL but for paths that go ahead */
} pti_walk;

/* After so many rays a sample splits no more: where a user's BSDF gains energy, it would for ever. So it would with a guide: a
   path's potential is what it would be without one, and that shrinks in the mean over the directions that are drawn without one
   only. In small rooms it grew from 14 rays a path to ten thousand. */
#define PTI_SPLIT_RAYS 16384
#define PTI_SPLIT_RAYS_GUIDED 32
/* How many rays go on from mix, whose shares become the parts' shares of them. */
static int pti_path_split(const pti_walk *w, const pti_path *path, pti_mixture *mix, uint32_t u) {
    float n;
    int room = PTI_PATHS - w->count, most = room < w->tracer->max_split ? room : w->tracer->max_split;
    uint64_t rays = *w->rays - w->first_ray;
    if (most < 2 || w->trail || mix->surface->delta >= 0.999f) return 1;
    if (rays > (w->tracer->guide ? PTI_SPLIT_RAYS_GUIDED : PTI_SPLIT_RAYS)) return 1;
    n = pti_mixture_split(mix, pti_largest(path->potential));
    if (!(n > 1)) return 1;                              /* nor with NaN */
    return n < (float)most ? (int)n + pti_split(&u, n - (float)(int)n) : most;
}
/* Ray k of n, from mix, where *path stands. The rays are strata: ray k has (k + u) / n; where all n w_i are whole, it has a part of
   the mixture to itself, the same in each sample, with all of u to choose a direction. (u + k/n (mod 1) would be as right; but
   then two rays take turns at two parts, and each part has half of the u: up to an eighth more variance in a picture.) The other
   numbers are XORed with a constant, which leaves them stratified over the samples. */
static void pti_path_send(pti_walk *w, const pti_path *path, const pti_mixture *mix, float calm, int k, int n, const uint32_t u[2],
                          const uint32_t choice[2]) {
    const pti_tracer *t = w->tracer;
    const pti_surface *surface = mix->surface;
    const pt_vertex *x = surface->x;
    uint32_t shift = k ? pti_hash2(path->group, (uint32_t)k) : 0, picks[2];
    uint32_t stratum = (uint32_t)(((uint64_t)(uint32_t)k << 32 | u[0]) / (uint32_t)n);
    pti_path *next = w->path + w->count;
    pti_step step;
    int drawn;
    picks[0] = choice[0] ^ shift; picks[1] = choice[1] ^ shift;
    drawn = pti_mixture_sample(mix, stratum, u[1] ^ shift, picks, &step);
    if (w->trail) pti_mixture_note(mix, calm, &step, t->shares, w->L, path->beta, *w->rays, w->trail);
    if (!drawn || w->L.x < 0) return;
    if (!pti_is_direction(step.wi) || !pti_finite3(step.weight)) {
        w->L = pt_v3(-1, -1, -1);                        /* a user's NaN, or no unit vector: the film will discard it */
        w->count = 0;
        return;
    }
    next->wavelength = path->wavelength;
    next->group = ((k ? shift : path->group) + 1) & PTI_GROUP_MASK;
    next->depth = path->depth + 1;
    next->diffuse = path->diffuse;
    if (t->max_diffuse) next->diffuse += pti_step_is_diffuse(surface, &step, pti_hash2(~next->group, u[1]));
    next->beta = pti_mul(path->beta, step.weight);
    next->potential = step.delta ? path->potential : pti_mul(path->potential, pti_scale(step.weight, step.plain));
    if (!step.delta && surface->squeeze != 1 && !pti_same_side(x, x->wo, step.wi))
        next->potential = pti_scale(next->potential, surface->squeeze);
    next->org = pti_spawn(x, step.wi);
    next->dir = step.wi;
    next->sky = step.sky;
    if (t->integrator) w->nee.p = step.p;
    w->count++;
}
/* Those that have just been sent come in such an order that the weakest is followed first. It ends soon, as most rays to lamps do;
   were it kept for later, a long walk would fill up all the room with such, and could split no more. */
static void pti_walk_order(pti_walk *w, int first) {
    int i, k;
    for (i = first + 1; i < w->count; i++)
        for (k = i; k > first && pti_largest(w->path[k].potential) > pti_largest(w->path[k - 1].potential); k--) {
            pti_path weaker = w->path[k - 1];
            w->path[k - 1] = w->path[k];
            w->path[k] = weaker;
        }
}
/* Follows the last path to its next vertex, and sends it on from there. */
static void pti_path_follow(pti_walk *w) {
    const pti_tracer *t = w->tracer;
    const pt_scene *s = t->scene;
    const pti_path *top = w->path + --w->count;
    pti_path path;
    pt_vertex x;
    const pti_material *m = pti_path_trace(t, top->org, top->dir, w->time, &x, w->rays), *hit;
    pt_vec3 Le = { 0, 0, 0 };
    pti_surface surface;
    pti_mixture mix;
    uint32_t u[2], choice[2] = { 0, 0 };
    float calm, bright = 1;
    int n, k, first;
    path = *top;
    x.wavelength = path.wavelength;
    if (!m || m->emits) {
        Le = m ? pti_material_emission(m, &x) : pti_environment_radiance(&s->environment, path.dir, &path.sky);
        Le = pti_scale(Le, pti_nee_found(t, &w->nee, path.dir, &path.sky));
    }
    if (s->volumes.count) {
        pti_carried c;
        c.L = w->L; c.beta = path.beta; c.potential = path.potential; c.Le = Le;
        hit = pti_path_fly(t, w->sampler, path.group, path.org, path.dir, w->time, &x, m, &c);
        w->L = c.L; path.beta = c.beta; path.potential = c.potential;
        Le = hit == m ? c.Le : pt_v3(0, 0, 0);
        m = hit;
        if (c.exceeded) {
            w->L = pt_v3(PTI_EXCEEDED, PTI_EXCEEDED, PTI_EXCEEDED);
            w->count = 0;
            return;
        }
    }
    if (m && m->disperses && !(path.wavelength > 0)) path.wavelength = pti_path_wavelength(t, w->sampler, &path.beta);
    w->L = pti_add(w->L, pti_mul(path.beta, Le));
    if (!m) return;
    x.wavelength = path.wavelength;
    if (path.depth == t->max_depth) return;
    pti_surface_at(m, &x, &surface);
    if (t->max_diffuse && path.diffuse == t->max_diffuse) pti_surface_drop_diffuse(&surface);
    if (!surface.count) return;                          /* black, as lamps are */
    pti_draw2(w->sampler, path.group, 0, u);
    if (s->lights.count > 1 || s->density_count || m->wants_choice) pti_draw2(w->sampler, path.group, 1, choice);
    if (x.volume.id && pti_largest(path.potential) < PTI_ROULETTE_START)       /* else roulette does not ask */
        bright = pti_path_brightening(s, path.org, path.dir, &x);
    path.potential = pti_scale(path.potential, bright);
    /* Hashed, here and below: a number that decides anything by itself is no longer even where that was decided. */
    if (!pti_path_goes_on(t, &surface, &path.beta, &path.potential, pti_hash2(w->sampler->index, u[0]))) return;
    path.potential = pti_scale(path.potential, 1 / bright);
    mix = pti_mixture_at(s, &surface, &t->weights);
    if (t->shares && mix.bsdf < 1) pti_mixture_learned(&mix, t->shares);
    if (t->guide) pti_mixture_guided(&mix, t->guide, t->shares != NULL);
    if (t->shares && !w->trail) pti_mixture_glints(&mix);
    n = pti_path_split(w, &path, &mix, pti_hash2(w->sampler->index, u[1]));
    path.beta = pti_scale(path.beta, 1 / (float)n);
    path.potential = pti_scale(path.potential, 1 / (float)n);
    calm = pti_mixture_calm(&mix, pti_largest(path.potential));
    if (t->integrator)
        w->L = pti_add(w->L, pti_mul(path.beta, pti_nee_at(t, &mix, w->sampler, path.group, &w->nee, w->rays)));
    first = w->count;
    for (k = 0; k < n; k++) pti_path_send(w, &path, &mix, calm, k, n, u, choice);
    pti_walk_order(w, first);
}
/* wavelength: 0 where the camera let all of them through. trail: NULL but for paths that go ahead. */
static pt_vec3 pti_path_radiance(const pti_tracer *t, const pti_sampler *sampler, const pt_ray *start, float wavelength,
                                 uint64_t *rays, pti_share_trail *trail) {
    pti_walk w;
    pti_path *first = w.path;
    w.tracer = t; w.sampler = sampler; w.rays = rays; w.first_ray = *rays; w.trail = trail;
    w.time = start->time;
    w.L = pt_v3(0, 0, 0);
    w.nee.p = 0;
    w.count = 1;
    first->org = start->org; first->dir = start->dir;
    first->sky.known = 0;
    first->beta = first->potential = pt_v3(1, 1, 1);
    first->wavelength = wavelength;
    first->group = 1;
    first->depth = first->diffuse = 0;
    while (w.count) pti_path_follow(&w);
    return w.L;
}

/* ---- >>camera ------------------------------------------------------------------------------------------
   From a point of the picture, one of the lens and one of the shutter's time to a ray. A thin lens: rays from all over the
   aperture that meet in the plane of focus. Blur of a point at distance z:
       diameter on the plane of focus = 2 aperture |z - focus| / z  (perspective),  2 aperture |z - focus| / focus
   (orthographic, telecentric). Wide pictures have no one plane: there the lens faces each ray, and the focus is a sphere. */

typedef struct pti_lens {
    pt_camera camera;
    pt_vec3 eye, right, up, forward;
    float half_width, half_height, aspect, slope, aperture, focus;   /* sizes at distance 1; orthographic: in metres */
} pti_lens;
typedef struct pti_lens_point {
    float x, y;                                          /* [0,1] across the picture, y downwards; filters reach beyond */
    float u, v;                                          /* choose a point of the lens */
    float shutter;                                       /* 0 opens to 1 closes */
    float wavelength;                                    /* nm; 0 = white, which aberration leaves alone */
} pti_lens_point;

static pt_vec3 pti_up_or_y(pt_vec3 up) { return pti_is_zero3(up) ? pt_v3(0, 1, 0) : up; }
static void pti_lens_place(pti_lens *l, pt_vec3 eye, pt_vec3 target, pt_vec3 up) {
    pt_vec3 view = pti_sub(target, eye);
    up = pti_normalize(pti_up_or_y(up));
    l->eye = eye;
    l->forward = pti_is_zero3(view) ? pt_v3(0, 0, -1) : pti_normalize(view);
    l->right = pti_normalize(pti_cross(l->forward, up));
    if (pti_largest_abs(pti_cross(l->forward, up)) < 1e-6f) pti_basis(l->forward, &l->right, &up);   /* straight up, down */
    l->up = pti_cross(l->right, l->forward);
    l->focus = l->camera.focus > 0 ? l->camera.focus : pti_max(pti_length(view), 1e-30f);
    if (l->camera.projection == PT_CAMERA_ORTHOGRAPHIC) {
        l->half_height = l->slope * (pti_is_zero3(view) ? 1.0f : pti_length(view));
        if (l->camera.height > 0) l->half_height = 0.5f * l->camera.height;
        l->half_width = l->half_height * l->aspect;
    }
}
static pti_lens pti_lens_make(const pt_camera *c, int width, int height) {
    pti_lens l;
    float sine, cosine, angle = (c->vfov_deg > 0 ? c->vfov_deg : 40.0f) * (PTI_PI / 360);
    memset(&l, 0, sizeof l);
    l.camera = *c;
    l.aperture = c->aperture;
    l.aspect = (float)width / (float)height;
    pti_sincos(angle, &sine, &cosine);
    l.half_height = l.slope = sine / cosine;
    l.half_width = l.half_height * l.aspect;
    if (c->projection == PT_CAMERA_FISHEYE) {            /* the circle's radius is 1 */
        l.half_width = pti_max(l.aspect, 1);
        l.half_height = pti_max(1 / l.aspect, 1);
    }
    pti_lens_place(&l, c->eye, c->target, c->up);
    return l;
}
static pt_vec3 pti_between(pt_vec3 a, pt_vec3 b, float t) { return pti_madd(a, 1 - t, pti_scale(b, t)); }
static pti_lens pti_lens_at(const pti_lens *l, float shutter) {      /* of a moving camera */
    const pt_camera *c = &l->camera;
    pti_lens at = *l;
    pti_lens_place(&at, pti_between(c->eye, c->eye_end, shutter), pti_between(c->target, c->target_end, shutter),
                   pti_between(pti_up_or_y(c->up), pti_up_or_y(c->up_end), shutter));
    return at;
}

/* Uniform over the regular polygon with n corners at distance 1, the first at the angle `turn`. As Shirley and Chiu's map
   makes circles of the squares about the middle, this makes polygons of them: r is the square's size, s in [0,1) the way
   along its rim. Both rims have area elements in proportion to r dr ds, so areas keep their ratio, and strata their
   neighbours. */
static void pti_sample_polygon(int n, float turn, float u, float v, float *x, float *y) {
    float a = 2 * u - 1, b = 2 * v - 1, r, s, f, s0, c0, s1, c1;
    int k;
    if (a == 0 && b == 0) { *x = *y = 0; return; }
    if (a * a > b * b) { r = a; s = b / a / 8; }
    else               { r = b; s = 0.25f - a / b / 8; }
    if (r < 0) { r = -r; s += 0.5f; }
    if (s < 0) s += 1;
    f = s * (float)n;
    k = (int)f < n ? (int)f : n - 1;
    f -= (float)k;
    pti_sincos(turn + 2 * PTI_PI * (float)k / (float)n, &s0, &c0);
    pti_sincos(turn + 2 * PTI_PI * (float)(k + 1) / (float)n, &s1, &c1);
    *x = r * (c0 + f * (c1 - c0));
    *y = r * (s0 + f * (s1 - s0));
}
static inline float pti_polygon_area(int n) {            /* its density is 1 / area */
    float s, c;
    pti_sincos(2 * PTI_PI / (float)n, &s, &c);
    return 0.5f * (float)n * s;
}
static pt_vec3 pti_lens_offset(const pti_lens *l, float u, float v, pt_vec3 right, pt_vec3 up) {
    float x, y;
    if (l->camera.blades) pti_sample_polygon(l->camera.blades, l->camera.blade_rotation_deg * (PTI_PI / 180), u, v, &x, &y);
    else pti_sample_disk(u, v, &x, &y);
    return pti_scale(pti_madd(right, x, pti_scale(up, y)), l->aperture);
}

/* What distortion and aberration multiply the distance from the axis with. */
PTI_NOINLINE float pti_lens_bend(const pti_lens *l, float a, float b, float wavelength) {
    float k = 1 + l->camera.distortion * ((a * a + b * b) / (l->half_height * l->half_height));
    return wavelength > 0 ? k / (1 + l->camera.aberration * ((wavelength - 550) / 300)) : k;
}
/* Where the axis is the origin and half the height is half_height. */
PTI_INLINE void pti_lens_plane(const pti_lens *l, const pti_lens_point *p, float *a, float *b) {
    float k;
    *a = (2 * p->x - 1 + 2 * l->camera.shift_x) * l->half_width;
    *b = (1 - 2 * p->y + 2 * l->camera.shift_y) * l->half_height;
    if (!(l->camera.distortion != 0 || p->wavelength > 0)) return;
    k = pti_lens_bend(l, *a, *b, p->wavelength);
    *a *= k;
    *b *= k;
}
/* The direction of a point of a wide picture, and what is right and up of it, in coordinates right, up, forward of the
   camera. 0: outside the picture. */
static int pti_lens_wide(const pti_lens *l, const pti_lens_point *p, pt_vec3 *right, pt_vec3 *up, pt_vec3 *dir) {
    float s, c, x, y, r;
    if (l->camera.projection == PT_CAMERA_EQUIRECTANGULAR) {
        pti_sincos((2 * p->x - 1) * PTI_PI, &x, &y);     /* longitude */
        pti_sincos((0.5f - p->y) * PTI_PI, &s, &c);      /* latitude */
        *dir = pt_v3(x * c, s, y * c);
        *right = pt_v3(y, 0, -x);
        *up = pt_v3(-x * s, c, -y * s);
        return 1;
    }
    x = (2 * p->x - 1) * l->half_width;
    y = (1 - 2 * p->y) * l->half_height;
    r = sqrtf(x * x + y * y);
    if (!(r <= 1)) return 0;
    pti_sincos(r * (l->camera.vfov_deg > 0 ? l->camera.vfov_deg : 180.0f) * (PTI_PI / 360), &s, &c);
    if (r > 0) { x /= r; y /= r; } else { x = 1; y = 0; }
    *dir = pt_v3(x * s, y * s, c);                       /* the frame is turned with it, the shortest way */
    *right = pt_v3(x * x * c + y * y, x * y * c - x * y, -x * s);
    *up = pt_v3(x * y * c - x * y, y * y * c + x * x, -y * s);
    return 1;
}
/* The ray, and what its radiance counts: 0 = outside the picture, black, and there is no ray. */
static float pti_lens_ray(const pti_lens *l, const pti_lens_point *p, pt_ray *ray) {
    const pt_camera *c = &l->camera;
    pti_lens moved;
    pt_vec3 org, d, right, up, shift;
    float a, b, weight = 1;
    if (c->moving) { moved = pti_lens_at(l, p->shutter); l = &moved; }
    org = l->eye; d = l->forward; right = l->right; up = l->up;
    if (c->projection == PT_CAMERA_PERSPECTIVE) {
        pti_lens_plane(l, p, &a, &b);
        d = pti_madd(right, a, pti_madd(up, b, d));
        if (c->vignetting > 0) {
            b = 1 / pti_dot(d, d);                       /* cos^2 */
            weight += c->vignetting * (b * b - 1);
        }
    } else if (c->projection == PT_CAMERA_ORTHOGRAPHIC) {
        pti_lens_plane(l, p, &a, &b);
        org = pti_madd(right, a, pti_madd(up, b, org));
    } else {
        if (!pti_lens_wide(l, p, &right, &up, &d)) return 0;
        right = pti_to_world(l->right, l->up, l->forward, right);
        up = pti_to_world(l->right, l->up, l->forward, up);
        d = pti_to_world(l->right, l->up, l->forward, d);
    }
    if (l->aperture > 0) {
        shift = pti_lens_offset(l, p->u, p->v, right, up);
        org = pti_add(org, shift);
        d = pti_madd(shift, -1 / l->focus, d);           /* both rays pass the same point of the plane of focus */
    }
    ray->org = org;
    ray->dir = pti_normalize(d);
    ray->tmin = ray->tmax = 0;
    ray->time = c->shutter_open + p->shutter * (c->shutter_close - c->shutter_open);
    return weight;
}

/* ---- >>film --------------------------------------------------------------------------------------------
   Sums that are exact: each sample is cut to a multiple of 2^-64 and added as a 128-bit integer. So they never drift, not at
   a million samples a pixel, and do not depend on the order: ranges of samples merged equal the whole, bit for bit. There is
   room for 9e6 samples of the largest radiance allowed. */

typedef struct pti_sum { uint64_t hi, lo; } pti_sum;     /* hi + lo 2^-64, two's complement */
typedef struct pti_pixel { pti_sum rgb[3]; uint32_t count; } pti_pixel;

#define PTI_MAX_RADIANCE 1e12f

static void pti_sum_add(pti_sum *a, pti_sum b) {
    a->lo += b.lo;
    a->hi += b.hi + (a->lo < b.lo);
}
static pti_sum pti_sum_negate(pti_sum a) {
    a.lo = ~a.lo + 1;
    a.hi = ~a.hi + (a.lo == 0);
    return a;
}
PTI_INLINE pti_sum pti_sum_of(float x) {                     /* 0 <= x, not much above PTI_MAX_RADIANCE */
    pti_sum s = { 0, 0 };
    uint32_t bits;
    uint64_t mantissa;
    int shift;                                           /* x = mantissa 2^(shift - 64) */
    memcpy(&bits, &x, sizeof bits);
    mantissa = (bits & 0x7fffffu) | 0x800000u;
    shift = (int)(bits >> 23) - 150 + 64;
    if (!(x > 0) || bits >> 23 == 0 || shift <= -24) return s;
    if (shift < 0) s.lo = mantissa >> -shift;
    else if (shift < 64) { s.lo = mantissa << shift; s.hi = shift ? mantissa >> (64 - shift) : 0; }
    else s.hi = mantissa << (shift - 64);
    return s;
}
static float pti_sum_mean(pti_sum s, uint32_t count) {
    int negative = s.hi >> 63 != 0;
    double sum;
    if (!count) return 0;
    if (negative) s = pti_sum_negate(s);
    sum = (double)s.hi + (double)s.lo * (1.0 / 18446744073709551616.0);
    return (float)((negative ? -sum : sum) / (double)count);
}
PTI_NOINLINE void pti_pixel_subtract(pti_pixel *p, pt_vec3 c) {
    pti_sum_add(&p->rgb[0], pti_sum_negate(pti_sum_of(c.x)));
    pti_sum_add(&p->rgb[1], pti_sum_negate(pti_sum_of(c.y)));
    pti_sum_add(&p->rgb[2], pti_sum_negate(pti_sum_of(c.z)));
}
/* weight: the filter's. 0 if the sample was unfit and counts as black. */
static int pti_pixel_add(pti_pixel *p, pt_vec3 c, float weight) {
    int fine = c.x >= 0 && c.y >= 0 && c.z >= 0 && pti_largest(c) <= PTI_MAX_RADIANCE;           /* false for NaN */
    p->count++;
    if (!fine) return 0;
    c = pti_scale(c, fabsf(weight));
    if (weight < 0) { pti_pixel_subtract(p, c); return 1; }
    pti_sum_add(&p->rgb[0], pti_sum_of(c.x));
    pti_sum_add(&p->rgb[1], pti_sum_of(c.y));
    pti_sum_add(&p->rgb[2], pti_sum_of(c.z));
    return 1;
}

/* Filters. The value of a pixel at the origin is
       integral f(x) f(y) L(x, y) dx dy / (integral f)^2,
   estimated by points drawn from |f|: with A = integral |f|, each weighs sign f(x) sign f(y) (A / integral f)^2, so that a
   sample belongs to one pixel alone, and an f that is nowhere negative has weights of 1 (Ernst, Stamminger, Greiner 2006).
   f is even: the upper and the lower half of [0,1) go to the two sides, from the middle outwards, and strata stay. Box and
   tent are inverted in closed form; the others are steps of a table, and drawn from that very table. */
#define PTI_FILTER_CELLS 512
typedef struct pti_filter {
    pt_filter kind;
    float radius, weight;                                /* (A / integral f)^2 */
    int positive;                                        /* f >= 0 in the first so many cells, < 0 in the others */
    float table[PTI_FILTER_CELLS + 1];
} pti_filter;

static double pti_filter_value(pt_filter kind, double x) {           /* up to a factor; x in [0,1] of the radius */
    double s, c;
    switch (kind) {
    case PT_FILTER_TENT:
        return 1 - x;
    case PT_FILTER_GAUSSIAN:
        return (double)pti_exp_double(-4.5 * x * x) - 0.011108996538242306;      /* e^-4.5 */
    case PT_FILTER_MITCHELL:
        x *= 2;
        return x < 1 ? (7 * x - 12) * x * x + 16.0 / 3 : ((-7.0 / 3 * x + 12) * x - 20) * x + 32.0 / 3;
    case PT_FILTER_BLACKMAN_HARRIS:
        pti_sincos_double(3.141592653589793 * x, &s, &c);
        return 0.35875 + 0.48829 * c + 0.14128 * (2 * c * c - 1) + 0.01168 * (4 * c * c - 3) * c;
    default:
        return 1;
    }
}
static void pti_filter_make(pti_filter *f, pt_filter kind, float radius) {
    static const float own[] = { 0.5f, 0.5f, 1, 1.5f, 2, 1.5f };
    float value[PTI_FILTER_CELLS];
    double sum = 0, absolute = 0;
    int i;
    f->kind = kind;
    f->radius = radius > 0 ? radius : own[kind];
    f->positive = 0;
    for (i = 0; i < PTI_FILTER_CELLS; i++) {
        double v = pti_filter_value(kind, (i + 0.5) / PTI_FILTER_CELLS);
        f->positive += v >= 0;
        value[i] = (float)(v < 0 ? -v : v);
        absolute += (double)value[i];
        sum += v < 0 ? -(double)value[i] : (double)value[i];
    }
    f->weight = (float)(absolute / sum * (absolute / sum));
    pti_table_build(f->table, value, PTI_FILTER_CELLS);
}
PTI_NOINLINE float pti_filter_invert(const pti_filter *f, float u, float *weight) {
    float a = fabsf(2 * u - 1), x;
    int cell;
    if (f->kind == PT_FILTER_TENT) x = a / (1 + sqrtf(1 - a));       /* 1 - (1 - x)^2 = a */
    else {
        x = pti_sample_table(f->table, PTI_FILTER_CELLS, a, &cell);
        if (cell >= f->positive) *weight = -*weight;
    }
    x *= f->radius;
    return u < 0.5f ? -x : x;
}
/* In pixels, from the middle of the pixel. *weight changes its sign where f is negative. */
PTI_INLINE float pti_filter_sample(const pti_filter *f, float u, float *weight) {
    return f->kind <= PT_FILTER_BOX ? (2 * u - 1) * f->radius : pti_filter_invert(f, u, weight);
}
static inline float pti_pdf_filter(const pti_filter *f, float x) {   /* per pixel */
    float a = fabsf(x) / f->radius;
    int cell = (int)(a * PTI_FILTER_CELLS);
    if (!(a < 1)) return 0;
    if (f->kind <= PT_FILTER_BOX) return 0.5f / f->radius;
    if (f->kind == PT_FILTER_TENT) return (1 - a) / f->radius;
    return 0.5f / f->radius * pti_pdf_table(f->table, PTI_FILTER_CELLS, cell);
}

/* ---- >>render ------------------------------------------------------------------------------------------
   A bag of tiles that any thread may take from. A tile's work is to bring each of its pixels to the wanted number of
   samples, counting from where it stands; so a cancelled render can go on, and more samples are just a higher aim. One
   lock guards the bag, the counters and who is in which tile; pixels belong to whoever is in their tile. */

struct pt_render {
    const pt_scene *scene;
    pt_allocator allocator;
    pti_error error;
    pt_render_desc desc;
    pti_tracer tracer;
    pti_lens lens;
    pti_filter filter;
    int width, height;                                   /* of the film: the crop's, 0 until there is one */
    uint32_t seed, strata_x, strata_y;
    uint32_t aim;                                        /* samples a pixel */
    int tiles_x, tiles_y, tile_count, next_tile, tiles_done, inside, cancelled;   /* inside: how many tiles are busy */
    pti_shares shares;
    pti_guide guide;
    int learned;                                         /* both are */
    int has_lock, has_progress_lock, has_learn_lock;
    pti_mutex lock, progress_lock, learn_lock;           /* the others are taken first */
    pti_pixel *film;
    float *pixels;
    unsigned char *busy;                                 /* a tile: somebody is in it */
    pti_thread *threads;
    int thread_count;
    pt_stats stats;
};

PT_DEF void pt_render_destroy(pt_render *r) {
    pt_allocator a;
    size_t n;
    if (!r) return;
    a = r->allocator;
    n = (size_t)r->width * (size_t)r->height;
    if (r->has_lock) pti_mutex_free(&r->lock);
    if (r->has_progress_lock) pti_mutex_free(&r->progress_lock);
    if (r->has_learn_lock) pti_mutex_free(&r->learn_lock);
    pti_guide_free(&r->guide, &a);
    pti_free(&a, r->shares.cells, PTI_SHARE_CELLS, sizeof *r->shares.cells);
    pti_free(&a, r->shares.sums, PTI_SHARE_CELLS, sizeof *r->shares.sums);
    pti_free(&a, r->film, n, sizeof *r->film);
    pti_free(&a, r->pixels, n, 3 * sizeof *r->pixels);
    pti_free(&a, r->busy, (size_t)r->tile_count, 1);
    pti_free(&a, r->threads, (size_t)r->thread_count, sizeof *r->threads);
    pti_free(&a, r, 1, sizeof *r);
}
PT_DEF const char *pt_render_error(const pt_render *r) { return r ? r->error.text : "out of memory for the render"; }

static int pti_check_range(pt_render *r, int value, int lo, int hi, const char *what) {
    if (value >= lo && value <= hi) return 1;
    pti_fail(&r->error, PT_ERR_ARG, "pt_render_create: %s is %d, it must be %d to %d", what, value, lo, hi);
    return 0;
}
static int pti_check_float(pt_render *r, int fine, float value, const char *what) {
    if (!fine) pti_fail(&r->error, PT_ERR_ARG, "pt_render_create: %s (it is %g)", what, (double)value);
    return fine;
}
static int pti_check_point(pt_render *r, pt_vec3 v, const char *what) {
    if (pti_in_range3(v)) return 1;
    pti_fail(&r->error, PT_ERR_ARG, "pt_render_create: %s must be finite and below 1e12 (it is %g %g %g)", what, (double)v.x,
             (double)v.y, (double)v.z);
    return 0;
}
/* Does r (1 + k1 r^2) grow all the way to the farthest corner? */
static int pti_distortion_grows(const pt_camera *c, float aspect) {
    float x = (1 + 2 * fabsf(c->shift_x)) * aspect, y = 1 + 2 * fabsf(c->shift_y);
    return fabsf(c->distortion) <= 100 && 1 + 3 * c->distortion * (x * x + y * y) > 0;
}
static int pti_check_lens(pt_render *r, const pt_camera *c) {
    float aspect = (float)r->desc.width / (float)r->desc.height;
    int flat = c->projection == PT_CAMERA_PERSPECTIVE || c->projection == PT_CAMERA_ORTHOGRAPHIC;
    return pti_check_float(r, c->aperture >= 0 && pti_in_range(c->aperture), c->aperture,
                           "camera.aperture must be finite and >= 0")
        && pti_check_float(r, c->focus >= 0 && pti_in_range(c->focus), c->focus,
                           "camera.focus must be finite and > 0, or 0 for the target")
        && pti_check_range(r, c->blades, c->blades ? 3 : 0, 16, "camera.blades")
        && pti_check_float(r, fabsf(c->blade_rotation_deg) <= 36000, c->blade_rotation_deg,
                           "camera.blade_rotation_deg must be within 36000")
        && pti_check_float(r, fabsf(c->shift_x) <= (flat ? 10.0f : 0.0f), c->shift_x, flat
                           ? "camera.shift_x must be within 10" : "camera.shift_x must be 0 with this projection")
        && pti_check_float(r, fabsf(c->shift_y) <= (flat ? 10.0f : 0.0f), c->shift_y, flat
                           ? "camera.shift_y must be within 10" : "camera.shift_y must be 0 with this projection")
        && pti_check_float(r, flat ? pti_distortion_grows(c, aspect) : c->distortion == 0, c->distortion, flat
                           ? "camera.distortion must be within 100, and 1 + 3 k1 r^2 above 0 in the corners"
                           : "camera.distortion must be 0 with this projection")
        && pti_check_float(r, fabsf(c->aberration) <= (flat ? 0.5f : 0.0f), c->aberration, flat
                           ? "camera.aberration must be within 0.5" : "camera.aberration must be 0 with this projection")
        && pti_check_float(r, c->vignetting >= 0 && c->vignetting <= (c->projection ? 0.0f : 1.0f), c->vignetting,
                           c->projection ? "camera.vignetting must be 0 with this projection"
                           : "camera.vignetting must be between 0 and 1");
}
static int pti_check_shutter(pt_render *r, const pt_camera *c) {
    return pti_check_float(r, pti_in_range(c->shutter_open), c->shutter_open,
                           "camera.shutter_open must be finite and below 1e12")
        && pti_check_float(r, pti_in_range(c->shutter_close) && c->shutter_close >= c->shutter_open, c->shutter_close,
                           "camera.shutter_close must be finite and not before shutter_open")
        && pti_check_range(r, c->moving, 0, 1, "camera.moving")
        && pti_check_float(r, !c->moving || c->shutter_close > c->shutter_open, c->shutter_close,
                           "camera.moving needs a shutter_close after shutter_open")
        && pti_check_point(r, c->eye_end, "camera.eye_end") && pti_check_point(r, c->target_end, "camera.target_end")
        && pti_check_point(r, c->up_end, "camera.up_end");
}
static int pti_check_camera(pt_render *r, const pt_camera *c) {
    int fisheye = c->projection == PT_CAMERA_FISHEYE;
    return pti_check_point(r, c->eye, "camera.eye") && pti_check_point(r, c->target, "camera.target")
        && pti_check_point(r, c->up, "camera.up")
        && pti_check_range(r, (int)c->projection, PT_CAMERA_PERSPECTIVE, PT_CAMERA_FISHEYE, "camera.projection")
        && pti_check_float(r, c->vfov_deg >= 0 && (fisheye ? c->vfov_deg <= 360 : c->vfov_deg < 180), c->vfov_deg, fisheye
                           ? "camera.vfov_deg must be up to 360, or 0 for 180"
                           : "camera.vfov_deg must be below 180, or 0 for 40")
        && pti_check_float(r, c->height >= 0 && pti_in_range(c->height), c->height,
                           "camera.height must be finite and > 0, or 0 for what vfov_deg sees")
        && pti_check_lens(r, c) && pti_check_shutter(r, c);
}
static int pti_check_crop(pt_render *r, pt_render_desc *d) {         /* zeros become all the rest */
    if (!pti_check_range(r, d->crop_x, 0, d->width - 1, "crop_x")
        || !pti_check_range(r, d->crop_y, 0, d->height - 1, "crop_y")) return 0;
    if (!d->crop_width) d->crop_width = d->width - d->crop_x;
    if (!d->crop_height) d->crop_height = d->height - d->crop_y;
    return pti_check_range(r, d->crop_width, 1, d->width - d->crop_x, "crop_width")
        && pti_check_range(r, d->crop_height, 1, d->height - d->crop_y, "crop_height");
}
static int pti_check_isa(pt_render *r, const char *name, int *isa) {
    *isa = name ? pti_isa_by_name(name) : pti_isa_best();
    if (*isa >= 0 && pti_isa_supported(*isa)) return 1;
    pti_fail(&r->error, PT_ERR_ARG, "pt_render_create: isa \"%s\" is %s", name, *isa < 0 ? "none of scalar, sse2, avx2, neon"
             : "not there on this machine, or not compiled in");
    return 0;
}
static int pti_check_render(pt_render *r, int *isa) {
    const pt_render_desc *d = &r->desc;
    const pt_weights *w = &d->weights;
    return pti_check_range(r, d->width, 1, 65536, "width") && pti_check_range(r, d->height, 1, 65536, "height")
        && pti_check_crop(r, &r->desc)
        && pti_check_range(r, d->spp, 1, 0x7fffffff, "spp") && pti_check_range(r, d->max_depth, 1, 0x7ffffff, "max_depth")
        && pti_check_range(r, d->tile, 1, 65536, "tile") && pti_check_range(r, d->threads, 1, 4096, "threads")
        && pti_check_range(r, d->first_sample, 0, 0x7fffffff - d->spp, "first_sample")
        && pti_check_range(r, (int)d->sampler, PT_SAMPLER_SOBOL, PT_SAMPLER_RANDOM, "sampler")
        && pti_check_range(r, d->guide, 0, 65536, "guide")
        && pti_check_range(r, d->max_diffuse, 0, 0x7ffffff, "max_diffuse")
        && pti_check_range(r, d->max_split, 0, 8, "max_split")
        && pti_check_range(r, (int)d->integrator, PT_INTEGRATOR_MIXTURE, PT_INTEGRATOR_NEE_ALL, "integrator")
        && pti_check_range(r, (int)d->roulette, PT_ROULETTE_POTENTIAL, PT_ROULETTE_NONE, "roulette")
        && pti_check_range(r, (int)d->filter, PT_FILTER_DEFAULT, PT_FILTER_BLACKMAN_HARRIS, "filter")
        && pti_check_float(r, d->filter_radius >= 0 && d->filter_radius <= 64, d->filter_radius,
                           "filter_radius must be up to 64, or 0 for the filter's own")
        && pti_check_camera(r, &d->camera) && pti_check_isa(r, d->isa, isa)
        && pti_check_float(r, w->bsdf >= 0 && w->bsdf <= 1e6f, w->bsdf, "weights.bsdf must be 0 to 1e6")
        && pti_check_float(r, w->lights >= 0 && w->lights <= 1e6f, w->lights, "weights.lights must be 0 to 1e6")
        && pti_check_float(r, w->environment >= 0 && w->environment <= 1e6f, w->environment,
                           "weights.environment must be 0 to 1e6");
}
static int pti_render_learns(const pt_render *r) {       /* is there anything to share? */
    const pt_weights *w = &r->desc.weights;
    int automatic = !(w->bsdf > 0 || w->lights > 0 || w->environment > 0);
    return automatic && r->desc.integrator == PT_INTEGRATOR_MIXTURE
        && (r->scene->lights.count > 0 || r->scene->environment.irradiance);
}
/* Paths that the guide learns from; and how many records are kept of them, for the last pass, which has half of them. */
static uint32_t pti_render_pupils(const pt_render *r) {
    double n = (double)r->desc.width * (double)r->desc.height * (double)r->desc.guide;
    return n < 2147483648.0 ? (uint32_t)n : 2147483648u;
}
static uint32_t pti_render_records(const pt_render *r) {
    uint32_t n = pti_render_pupils(r);
    return n < PTI_GUIDE_RECORDS ? n : PTI_GUIDE_RECORDS;
}
static int pti_render_allocate(pt_render *r) {
    size_t n = (size_t)r->desc.crop_width * (size_t)r->desc.crop_height;
    const pt_allocator *a = &r->allocator;
    r->width = r->desc.crop_width;
    r->height = r->desc.crop_height;
    r->tiles_x = (r->width + r->desc.tile - 1) / r->desc.tile;
    r->tiles_y = (r->height + r->desc.tile - 1) / r->desc.tile;
    if (r->tiles_x > 0x7fffffff / r->tiles_y) return 0;
    r->tile_count = r->tiles_x * r->tiles_y;
    r->thread_count = r->desc.threads < r->tile_count ? r->desc.threads : r->tile_count;
    r->film = (pti_pixel *)pti_alloc(a, n, sizeof *r->film);
    r->pixels = (float *)pti_alloc(a, n, 3 * sizeof *r->pixels);
    r->busy = (unsigned char *)pti_alloc(a, (size_t)r->tile_count, 1);
    r->threads = (pti_thread *)pti_alloc(a, (size_t)r->thread_count, sizeof *r->threads);
    r->has_lock = pti_mutex_init(&r->lock);
    r->has_progress_lock = pti_mutex_init(&r->progress_lock);
    r->has_learn_lock = pti_mutex_init(&r->learn_lock);
    if (pti_render_learns(r)) {
        r->shares.cells = (pti_share *)pti_alloc(a, PTI_SHARE_CELLS, sizeof *r->shares.cells);
        r->shares.sums = (pti_share_sums *)pti_alloc(a, PTI_SHARE_CELLS, sizeof *r->shares.sums);
        if (!r->shares.cells || !r->shares.sums) return 0;
        r->shares.eye = r->desc.camera.eye;
        r->tracer.shares = &r->shares;
    }
    if (r->desc.guide && !pti_guide_create(&r->guide, a, pti_render_records(r))) return 0;
    return r->film && r->pixels && r->busy && r->threads && r->has_lock && r->has_progress_lock && r->has_learn_lock;
}
/* Cells of the stratified sampler: as square as can be, and at least spp of them. */
static void pti_render_strata(pt_render *r) {
    uint32_t spp = (uint32_t)r->desc.spp;
    r->strata_x = (uint32_t)sqrt((double)spp);
    r->strata_y = (spp + r->strata_x - 1) / r->strata_x;
}
PTI_NOINLINE pt_render *pti_render_create(const pt_scene *s, const pt_render_desc *d) {
    pt_allocator a = { NULL, NULL, NULL };
    pt_render *r;
    int isa;
    if (s) a = s->allocator;
    a = pti_allocator_or_default(a);
    r = (pt_render *)pti_alloc(&a, 1, sizeof *r);
    if (!r) return NULL;
    r->allocator = a;
    if (s) r->error.logger = s->error.logger;
    if (!s || !d) {
        pti_fail(&r->error, PT_ERR_ARG, "pt_render_create: the %s is NULL", s ? "description" : "scene");
        return r;
    }
    if (!s->committed) {
        pti_fail(&r->error, PT_ERR_STATE, "pt_render_create: the scene is not committed%s%s", *s->error.text ? ": " : "",
                 s->error.text);
        return r;
    }
    r->scene = s;
    r->desc = *d;
    if (!d->spp) r->desc.spp = 64;
    if (!d->max_depth) r->desc.max_depth = 64;
    if (!d->tile) r->desc.tile = 32;
    if (!d->threads) r->desc.threads = pti_cores();
    if (!pti_check_render(r, &isa)) return r;
    if (!pti_render_allocate(r)) { pt_render_destroy(r); return NULL; }
    pti_render_strata(r);
    r->aim = (uint32_t)r->desc.spp;
    r->seed = pti_hash2((uint32_t)d->seed, (uint32_t)(d->seed >> 32));
    r->lens = pti_lens_make(&d->camera, d->width, d->height);
    pti_filter_make(&r->filter, d->filter, d->filter_radius);
    r->tracer.scene = s;
    r->tracer.trace = pti_trace_for(isa);
    r->tracer.weights = d->weights;
    r->tracer.max_depth = r->desc.max_depth;
    r->tracer.max_diffuse = r->desc.max_diffuse;
    r->tracer.max_split = r->desc.integrator ? 1 : r->desc.max_split ? r->desc.max_split : 8;
    r->tracer.integrator = d->integrator;
    r->tracer.roulette = d->roulette;
    return r;
}
PT_DEF pt_render *pt_render_create(const pt_scene *s, const pt_render_desc *d) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_render *r = pti_render_create(s, d);
    pti_fpmode_leave(mode);
    return r;
}

/* The ray of a sample at (at->x, at->y), and what it brings. */
static pt_vec3 pti_render_sample(pt_render *r, const pti_sampler *sampler, pti_lens_point *at, pt_stats *stats,
                                 pti_share_trail *trail) {
    int exposes = r->desc.camera.shutter_close > r->desc.camera.shutter_open;
    uint32_t v[2] = { 0, 0 };
    pt_vec3 c, color = pt_v3(1, 1, 1);
    float seen;
    pt_ray ray;
    if (r->lens.aperture > 0) pti_draw2(sampler, 0, 1, v);
    at->u = pti_u01(v[0]); at->v = pti_u01(v[1]);
    at->shutter = exposes ? pti_u01(pti_draw1(sampler, PTI_GROUP_SHUTTER)) : 0.0f;
    at->wavelength = r->lens.camera.aberration != 0 ? pti_path_wavelength(&r->tracer, sampler, &color) : 0.0f;
    seen = pti_lens_ray(&r->lens, at, &ray);
    if (!(seen > 0)) return pt_v3(0, 0, 0);
    stats->paths++;
    c = pti_path_radiance(&r->tracer, sampler, &ray, at->wavelength, &stats->rays, trail);
    if (c.x == PTI_EXCEEDED) stats->exceeded++;
    if (trail && r->tracer.guide) pti_guide_learn(&r->guide, trail, c);
    else if (trail) pti_shares_learn(&r->shares, trail, c, stats->rays);
    return pti_mul(c, pti_scale(color, seen));
}
/* x and y: in the full picture, which alone the numbers depend on. */
static void pti_render_pixel(pt_render *r, pti_pixel *p, int x, int y, pt_stats *stats) {
    pti_sampler sampler;
    sampler.kind = r->desc.sampler;
    sampler.pixel_seed = pti_hash2((uint32_t)x, pti_hash2((uint32_t)y, r->seed));
    sampler.strata_x = r->strata_x;
    sampler.strata_y = r->strata_y;
    while (p->count < r->aim) {
        uint32_t u[2];
        float weight = r->filter.weight;
        pti_lens_point at;
        pti_sampler_start(&sampler, (uint32_t)r->desc.first_sample + p->count);
        pti_draw2(&sampler, 0, 0, u);
        at.x = ((float)x + (0.5f + pti_filter_sample(&r->filter, pti_u01(u[0]), &weight))) / (float)r->desc.width;
        at.y = ((float)y + (0.5f + pti_filter_sample(&r->filter, pti_u01(u[1]), &weight))) / (float)r->desc.height;
        if (!pti_pixel_add(p, pti_render_sample(r, &sampler, &at, stats, NULL), weight)) stats->discarded++;
    }
}
static int pti_is_cancelled(pt_render *r) {
    int c;
    pti_lock(&r->lock);
    c = r->cancelled;
    pti_unlock(&r->lock);
    return c;
}
/* n paths that go ahead, all over the picture as if it were one pixel. What they carry is thrown away. 0: cancelled. */
static int pti_render_ahead(pt_render *r, uint32_t seed, uint32_t first, uint32_t n) {
    pti_sampler sampler;
    pt_stats stats = { 0, 0, 0, 0, 0 };
    uint32_t i;
    sampler.kind = PT_SAMPLER_SOBOL;
    sampler.pixel_seed = pti_hash2(r->seed, seed);
    for (i = first; i < first + n; i++) {
        uint32_t u[2];
        pti_lens_point at;
        pti_share_trail trail;
        trail.count = 0;
        if (i % 64 == 0 && pti_is_cancelled(r)) return 0;
        if (r->tracer.guide && r->guide.record_count == r->guide.record_capacity) return 1;
        pti_sampler_start(&sampler, i);
        pti_draw2(&sampler, 0, 0, u);
        at.x = pti_u01(u[0]); at.y = pti_u01(u[1]);
        pti_render_sample(r, &sampler, &at, &stats, &trail);
    }
    return 1;
}
/* First the mixture learns its shares, in two passes, the second with what the first has learned. One thread does it while
   the others wait. The number of paths depends on nothing but the picture's size: one a pixel in all, but for small pictures,
   which take some for themselves, and large ones, which need no more. 0: cancelled. */
#define PTI_AHEAD_LEAST 8192
#define PTI_AHEAD_MOST 65536
#define PTI_AHEAD_SEED 0x0a4eadu
static int pti_render_shares(pt_render *r) {
    double pixels = (double)r->desc.width * (double)r->desc.height;
    double paths = pixels < PTI_AHEAD_LEAST ? pixels * 4 < PTI_AHEAD_LEAST ? pixels * 4 : PTI_AHEAD_LEAST : pixels;
    uint32_t n = (uint32_t)(paths < PTI_AHEAD_MOST ? paths : PTI_AHEAD_MOST) / 2, pass;
    memset(r->shares.cells, 0, PTI_SHARE_CELLS * sizeof *r->shares.cells);
    memset(r->shares.sums, 0, PTI_SHARE_CELLS * sizeof *r->shares.sums);
    for (pass = 0; pass < 2; pass++) {
        if (!pti_render_ahead(r, PTI_AHEAD_SEED, pass * n, n)) return 0;
        pti_shares_step(&r->shares);
    }
    return 1;
}
/* Then the guide, in passes, each of twice as many paths, which draw with what the last one has learned; unless there is little
   that the other parts do not find as well: then there is no guide. (In rooms and under skies windows weigh up to 0.13, and
   cost up to half of the efficiency; behind a door ajar 0.18 to 0.33.) It does not depend on spp: ranges of samples have the same
   guide. */
#define PTI_GUIDE_PASSES 3
static int pti_render_guide(pt_render *r) {
    pti_guide *g = &r->guide;
    uint32_t n = pti_render_pupils(r), pass;
    if (n < PTI_GUIDE_PATHS) return 1;
    g->record_count = 0;
    pti_guide_refine(g, 0);                              /* empty: a cancelled render begins anew */
    r->tracer.guide = g;
    for (pass = 0; pass < PTI_GUIDE_PASSES && r->tracer.guide; pass++) {
        g->record_count = 0;
        if (!pti_render_ahead(r, PTI_AHEAD_SEED + 1 + pass, 0, n >> (PTI_GUIDE_PASSES - pass))) return 0;
        if (!pass) pti_guide_refine(g, 0);               /* a quick look, without dividing: it finds half of that at least */
        if (pass || g->share >= 0.5 * (double)PTI_GUIDE_WORTH) pti_guide_refine(g, PTI_GUIDE_LEVELS - 1);
        if (g->share < (double)PTI_GUIDE_WORTH) r->tracer.guide = NULL;
    }
    return 1;
}
static void pti_tile_rect(const pt_render *r, int tile, int *x0, int *y0, int *x1, int *y1) {        /* of the film */
    *x0 = tile % r->tiles_x * r->desc.tile;
    *y0 = tile / r->tiles_x * r->desc.tile;
    *x1 = r->width - *x0 < r->desc.tile ? r->width : *x0 + r->desc.tile;
    *y1 = r->height - *y0 < r->desc.tile ? r->height : *y0 + r->desc.tile;
}
static int pti_render_learn(pt_render *r) {              /* 0: cancelled */
    int learned = 1;
    if (!r->shares.cells && !r->desc.guide) return 1;
    pti_lock(&r->learn_lock);
    if (!r->learned) {
        pti_fpmode mode = pti_fpmode_enter();
        r->tracer.guide = NULL;
        learned = (!r->shares.cells || pti_render_shares(r)) && (!r->desc.guide || pti_render_guide(r));
        r->learned = learned;
        pti_fpmode_leave(mode);
    }
    pti_unlock(&r->learn_lock);
    return learned;
}
/* 0 if it was cancelled on the way, which is looked for at every row. */
static int pti_render_tile(pt_render *r, int tile, pt_stats *stats) {
    int x0, y0, x1, y1, x, y;
    pti_fpmode mode = pti_fpmode_enter();
    pti_tile_rect(r, tile, &x0, &y0, &x1, &y1);
    for (y = y0; y < y1 && !pti_is_cancelled(r); y++)
        for (x = x0; x < x1; x++)
            pti_render_pixel(r, r->film + (size_t)y * (size_t)r->width + (size_t)x, r->desc.crop_x + x, r->desc.crop_y + y,
                             stats);
    pti_fpmode_leave(mode);
    return y == y1;
}
static void pti_report_progress(pt_render *r) {
    double done;
    if (!r->desc.progress) return;
    pti_lock(&r->progress_lock);
    pti_lock(&r->lock);
    done = (double)r->tiles_done / (double)r->tile_count;
    pti_unlock(&r->lock);
    if (r->desc.progress(r->desc.user, done)) pt_render_cancel(r);
    pti_unlock(&r->progress_lock);
}
PT_DEF void pt_render_cancel(pt_render *r) {
    if (!r || !r->has_lock) return;
    pti_lock(&r->lock);
    r->cancelled = 1;
    pti_unlock(&r->lock);
}
/* Not an error, since the picture is there; but nobody shall say it was silent. */
static void pti_render_warn(pt_render *r, uint64_t exceeded) {
    const pt_logger *l = &r->error.logger;
    if (exceeded && !r->stats.exceeded && l->log)
        (*l->log)(l->user, PT_ERR_ARG, "pt_render: a medium's density is NaN, or above its density_max or density_bound; or it is "
                                       "so far below, or marched through in such small steps, that flights do not end; such "
                                       "samples are discarded");
    r->stats.exceeded += exceeded;
}
PT_DEF pt_result pt_render_work(pt_render *r) {
    pt_stats stats = { 0, 0, 0, 0, 0 };
    int tile = -1, finished;
    if (!r) return PT_ERR_MEMORY;
    if (r->error.code != PT_OK) return r->error.code;
    pti_lock(&r->lock);
    if (!r->cancelled && r->next_tile < r->tile_count) {
        tile = r->next_tile++;
        r->busy[tile] = 1;
        r->inside++;
    }
    finished = !r->cancelled;
    pti_unlock(&r->lock);
    if (tile < 0) return finished ? PT_OK : PT_CANCELLED;
    finished = pti_render_learn(r) && pti_render_tile(r, tile, &stats);
    pti_lock(&r->lock);
    r->busy[tile] = 0;
    r->inside--;
    r->tiles_done += finished;
    r->stats.rays += stats.rays;
    r->stats.paths += stats.paths;
    r->stats.discarded += stats.discarded;
    pti_render_warn(r, stats.exceeded);
    pti_unlock(&r->lock);
    if (!finished) return PT_CANCELLED;
    pti_report_progress(r);
    return PT_MORE;
}
static void *pti_render_thread(void *arg) {
    pt_render *r = (pt_render *)arg;
    while (pt_render_work(r) == PT_MORE) {}
    return NULL;
}
PT_DEF pt_result pt_render_run(pt_render *r) {           /* a thread that can not be had is done without */
    double start = pti_seconds();
    int started = 0, i;
    if (!r) return PT_ERR_MEMORY;
    if (r->error.code != PT_OK) return r->error.code;
    while (started < r->thread_count - 1 && pti_thread_start(&r->threads[started], pti_render_thread, r)) started++;
    pti_render_thread(r);
    for (i = 0; i < started; i++) pti_thread_join(r->threads[i]);
    pti_lock(&r->lock);
    r->stats.seconds += pti_seconds() - start;
    i = r->cancelled;
    pti_unlock(&r->lock);
    return i ? PT_CANCELLED : PT_OK;
}
PT_DEF pt_result pt_render_add_samples(pt_render *r, int spp) {
    pt_result result = PT_OK;
    if (!r) return PT_ERR_MEMORY;
    if (r->error.code != PT_OK) return r->error.code;
    pti_lock(&r->lock);
    if (spp < 0 || (int64_t)r->aim + spp + r->desc.first_sample > 0x7fffffff) result = PT_ERR_ARG;
    else if (r->inside || (!r->cancelled && r->tiles_done < r->tile_count)) result = PT_ERR_STATE;
    else {
        r->aim += (uint32_t)spp;
        r->next_tile = r->tiles_done = r->cancelled = 0;
    }
    pti_unlock(&r->lock);
    return result;
}
static int pti_is_finished(pt_render *r) {
    int finished;
    pti_lock(&r->lock);
    finished = !r->cancelled && r->tiles_done == r->tile_count;
    pti_unlock(&r->lock);
    return finished;
}
PT_DEF pt_result pt_render_merge(pt_render *into, pt_render *from) {
    size_t i, n;
    int k;
    if (!into || !from) return PT_ERR_MEMORY;
    if (into->error.code != PT_OK) return into->error.code;
    if (from->error.code != PT_OK) return from->error.code;
    if (into == from || into->desc.width != from->desc.width || into->desc.height != from->desc.height
        || into->desc.crop_x != from->desc.crop_x || into->desc.crop_y != from->desc.crop_y
        || into->width != from->width || into->height != from->height) return PT_ERR_ARG;
    if (!pti_is_finished(into) || !pti_is_finished(from)) return PT_ERR_STATE;
    if (into->aim + from->aim > 0x7fffffffu) return PT_ERR_ARG;
    n = (size_t)into->width * (size_t)into->height;
    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) pti_sum_add(&into->film[i].rgb[k], from->film[i].rgb[k]);
        into->film[i].count += from->film[i].count;
    }
    into->aim += from->aim;
    into->stats.rays += from->stats.rays;
    into->stats.paths += from->stats.paths;
    into->stats.discarded += from->stats.discarded;
    into->stats.exceeded += from->stats.exceeded;
    into->stats.seconds += from->stats.seconds;
    return PT_OK;
}
PTI_NOINLINE void pti_resolve_tile(pt_render *r, int tile) {
    int x0, y0, x1, y1, x, y, k;
    pti_tile_rect(r, tile, &x0, &y0, &x1, &y1);
    for (y = y0; y < y1; y++)
        for (x = x0; x < x1; x++) {
            size_t i = (size_t)y * (size_t)r->width + (size_t)x;
            for (k = 0; k < 3; k++) r->pixels[3 * i + (size_t)k] = pti_sum_mean(r->film[i].rgb[k], r->film[i].count);
        }
}
PT_DEF const float *pt_render_pixels(pt_render *r) {     /* a tile that somebody is in keeps what it showed last */
    pti_fpmode mode;
    int tile;
    if (!r || r->error.code != PT_OK) return NULL;
    mode = pti_fpmode_enter();
    for (tile = 0; tile < r->tile_count; tile++) {
        pti_lock(&r->lock);
        if (!r->busy[tile]) pti_resolve_tile(r, tile);
        pti_unlock(&r->lock);
    }
    pti_fpmode_leave(mode);
    return r->pixels;
}
PT_DEF pt_stats pt_render_stats(pt_render *r) {
    pt_stats stats = { 0, 0, 0, 0, 0 };
    if (!r || !r->has_lock) return stats;
    pti_lock(&r->lock);
    stats = r->stats;
    pti_unlock(&r->lock);
    return stats;
}

/* ---- >>image -------------------------------------------------------------------------------------------
   Pictures to and from files, as linear RGB.
     PNG   8 or 16 bits a channel, compressed; written only
     PPM   8 bits a channel; read as text too, with 16 bits, and as grey PGM
           Both hold sRGB (IEC 61966-2-1): V = 12.92 L up to 0.0031308, above it 1.055 L^(1/2.4) - 0.055
     PFM   the floats themselves (Debevec; netpbm's pfm(5)), bottom row first, in the byte order that the sign of its
           scale tells
     HDR   Radiance RGBE (Ward, "Real Pixels", Graphics Gems II, 1991): three mantissas share an exponent, value =
           m 2^(e - 136). Scanlines are flat, or in the old run-length code (the pixel 1 1 1 n repeats the one before),
           or in the new one (the four bytes of all pixels one after the other, each in runs and literals)
   A reader trusts nothing that the file says: what cannot be there is refused before memory is asked for. */

/* What a reader reads, and where it says what is wrong. */
typedef struct pti_input {
    const uint8_t *start, *at, *end;
    const char *name;
    uint64_t line;                                       /* from 1; 0 = in a binary part, where the byte is told instead */
    char *error;                                         /* 256 characters of the caller's struct */
} pti_input;

/* Of a long path, the end: the reason must fit too. */
static const char *pti_short_name(const char *path) {
    size_t n = strlen(path);
    return n > 100 ? path + (n - 100) : path;
}
static pt_result pti_report(char *error, pt_result code, const char *name, const char *reason) {
    pti_text t;
    t.at = error; t.left = 256;
    pti_put(&t, pti_short_name(name));
    pti_put(&t, ": ");
    pti_put(&t, reason);
    return code;
}
/* "file:line: reason". Returns 0, for the caller to hand on. */
static int pti_refuse(const pti_input *in, const char *format, ...) {
    char reason[160];
    pti_text t;
    va_list args;
    va_start(args, format);
    pti_vformat(reason, sizeof reason, format, args);
    va_end(args);
    t.at = in->error; t.left = 256;
    pti_put(&t, in->name);
    pti_put(&t, in->line ? ":" : ":byte ");
    pti_put_uint(&t, in->line ? in->line : (uint64_t)(in->at - in->start));
    pti_put(&t, ": ");
    pti_put(&t, reason);
    return 0;
}
static pti_input pti_input_of(const char *name, const void *data, size_t size, char *error) {
    static const uint8_t nothing[1] = { 0 };
    pti_input in;
    in.start = in.at = data ? (const uint8_t *)data : nothing;
    in.end = in.start + (data ? size : 0);
    in.name = pti_short_name(name);
    in.line = 1;
    in.error = error;
    return in;
}
static size_t pti_input_left(const pti_input *in) { return (size_t)(in->end - in->at); }
/* The next character, or 0 behind the last. */
static int pti_peek(const pti_input *in) { return in->at < in->end ? *in->at : 0; }
static int pti_is_digit(int c) { return c >= '0' && c <= '9'; }

#ifndef PT_NO_STDIO
/* A whole file, in chunks that double: a pipe does not know its size beforehand. */
typedef struct pti_file { uint8_t *data; size_t size, capacity; } pti_file;
static void pti_file_free(const pt_allocator *a, pti_file *f) { pti_free(a, f->data, f->capacity, 1); }
static int pti_file_grow(const pt_allocator *a, pti_file *f) {
    size_t more = f->capacity ? f->capacity * 2 : 65536;
    uint8_t *p = more > f->capacity ? (uint8_t *)a->alloc(a->user, more, PTI_ALIGN) : NULL;    /* no need of zeros */
    if (!p) return 0;
    if (f->size) memcpy(p, f->data, f->size);
    pti_file_free(a, f);
    f->data = p;
    f->capacity = more;
    return 1;
}
static pt_result pti_file_read(const pt_allocator *a, const char *path, char *error, pti_file *f) {
    FILE *in = fopen(path, "rb");
    size_t n = 1;
    int failed = 0, memory = 1;
    f->data = NULL;
    f->size = f->capacity = 0;
    if (!in) return pti_report(error, PT_ERR_IO, path, "cannot open");
    while (n) {
        if (f->size == f->capacity) memory = pti_file_grow(a, f);
        if (!memory) break;
        n = fread(f->data + f->size, 1, f->capacity - f->size, in);
        f->size += n;
    }
    failed = ferror(in);                                 /* a directory opens, but does not read */
    fclose(in);
    if (memory && !failed) return PT_OK;
    pti_file_free(a, f);
    f->data = NULL;
    if (!memory) return pti_report(error, PT_ERR_MEMORY, path, "out of memory");
    return pti_report(error, PT_ERR_IO, path, "cannot read");
}
#endif

/* Numbers as text: digits go into an integer, which is exact up to 19 of them, then a power of ten puts the point where
   it belongs. Up to 15 digits and powers up to 22 that is the nearest double. */
static double pti_scale10(double x, int64_t e) {
    static const double power[23] = { 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
        1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    if (e > 400 || e < -400) e = e > 0 ? 400 : -400;     /* all doubles are within */
    for (; e > 22; e -= 22) x *= 1e22;
    for (; e < -22; e += 22) x /= 1e22;
    return e < 0 ? x / power[-e] : x * power[e];
}
/* The exponent at p ("e-3"), added to *e. Without digits it is no exponent, and p stays. */
static const uint8_t *pti_parse_exponent(const uint8_t *p, const uint8_t *end, int64_t *e) {
    const uint8_t *q = p + 1;
    int64_t n = 0;
    int negative = 0;
    if (q < end && (*q == '-' || *q == '+')) negative = *q++ == '-';
    if (q == end || !pti_is_digit(*q)) return p;
    for (; q < end && pti_is_digit(*q); q++) if (n < 100000000) n = n * 10 + (*q - '0');
    *e += negative ? -n : n;
    return q;
}
static int pti_parse_number(pti_input *in, double *out) {    /* 0, and nothing is read: no number */
    const uint8_t *p = in->at, *end = in->end, *first, *point;
    const uint64_t most = 1000000000000000000u;          /* another digit still fits */
    uint64_t m = 0;
    int64_t e = 0;
    int negative = 0;
    if (p < end && (*p == '-' || *p == '+')) negative = *p++ == '-';
    for (first = p; p < end && pti_is_digit(*p); p++) {
        if (m < most) m = m * 10 + (uint64_t)(*p - '0');
        else e++;
    }
    point = p;
    if (p < end && *p == '.') {
        for (p++; p < end && pti_is_digit(*p); p++) if (m < most) { m = m * 10 + (uint64_t)(*p - '0'); e--; }
        if (p == point + 1 && point == first) return 0;  /* a point alone */
    } else if (p == first) return 0;
    if (p < end && (*p == 'e' || *p == 'E')) p = pti_parse_exponent(p, end, &e);
    *out = pti_scale10((double)m, e);
    if (negative) *out = -*out;
    in->at = p;
    return 1;
}

/* 2^e, -1022 <= e <= 1023. */
static double pti_power_of_2(int e) {
    uint64_t bits = (uint64_t)(1023 + e) << 52;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Writing goes through a small buffer on the stack, so that writers need no memory of their own. */
typedef struct pti_output {
    const pt_writer *to;
    size_t used;
    int failed;
    uint8_t bytes[4096];
} pti_output;
static void pti_output_flush(pti_output *o) {
    if (o->used && !o->failed) o->failed = o->to->write(o->to->user, o->bytes, o->used) != 0;
    o->used = 0;
}
static void pti_output_byte(pti_output *o, unsigned b) {
    if (o->used == sizeof o->bytes) pti_output_flush(o);
    o->bytes[o->used++] = (uint8_t)b;
}
static void pti_output_text(pti_output *o, const char *s) { while (*s) pti_output_byte(o, (unsigned char)*s++); }
static void pti_output_size(pti_output *o, const char *before, int n) {
    char digits[24];
    pti_text t;
    t.at = digits; t.left = sizeof digits;
    pti_put_uint(&t, (uint64_t)n);
    pti_output_text(o, before);
    pti_output_text(o, digits);
}
static int pti_output_begin(pti_output *o, const pt_writer *to, const float *rgb, int width, int height) {
    o->to = to;
    o->used = 0;
    o->failed = 0;
    return to && to->write && rgb && width > 0 && height > 0;
}
static pt_result pti_output_end(pti_output *o) {
    pti_output_flush(o);
    return o->failed ? PT_ERR_IO : PT_OK;
}
static const float *pti_row(const float *rgb, int width, int y) { return rgb + (size_t)y * (size_t)width * 3; }

/* sRGB bytes, rounded exactly: edge[k] is the least linear float whose byte is k, that is, whose V is at least
   (k - 1/2) / 255. A byte is found by steps up from the one that its 32nd of an octave begins with: none or one mostly. */
#define PTI_SRGB_OCTAVES 13                              /* below 2^-13 all is 0 */
typedef struct pti_srgb {
    float edge[256];
    uint8_t first[PTI_SRGB_OCTAVES * 32];
} pti_srgb;
/* V to L, in double: x^2.4 = x^2 (x^2)^(1/5), the root by Newton's method, which falls towards it from 1. */
static double pti_srgb_to_linear(double v) {
    double a, r = 1;
    int i;
    if (v <= 0.04045) return v / 12.92;
    a = (v + 0.055) / 1.055;
    a *= a;
    for (i = 0; i < 16; i++) r -= (r - a / (r * r * r * r)) / 5;
    return a * r;
}
static void pti_srgb_init(pti_srgb *s) {
    uint32_t bits, k, i;
    float f;
    s->edge[0] = 0;
    for (k = 1; k < 256; k++) {
        double least = pti_srgb_to_linear(((double)k - 0.5) / 255);
        f = (float)least;
        memcpy(&bits, &f, sizeof f);
        if ((double)f < least) bits++;                   /* rounded down: the next float is the first inside */
        memcpy(&s->edge[k], &bits, sizeof bits);
    }
    for (i = k = 0; i < PTI_SRGB_OCTAVES * 32; i++) {
        bits = (((127 - PTI_SRGB_OCTAVES) << 5) + i) << 18;
        memcpy(&f, &bits, sizeof f);
        while (k < 255 && f >= s->edge[k + 1]) k++;
        s->first[i] = (uint8_t)k;
    }
}
static unsigned pti_srgb_byte(const pti_srgb *s, float x) {
    uint32_t bits;
    unsigned k;
    if (!(x >= s->edge[1])) return 0;                    /* NaN too */
    if (x >= s->edge[255]) return 255;
    memcpy(&bits, &x, sizeof bits);
    k = s->first[(bits >> 18) - ((127 - PTI_SRGB_OCTAVES) << 5)];
    while (x >= s->edge[k + 1]) k++;
    return k;
}

/* 16 bits, rounded exactly too. V from our log and exp is within 0.005 of a step; so what lies nearer than 1/64 to the
   middle between two steps, and only that, is held against the linear value of this middle. */
static unsigned pti_srgb_16(float x) {
    double v, below;
    if (!(x > 0)) return 0;
    if (x >= 1) return 65535;
    v = (double)x <= 0.0031308 ? 12.92 * (double)x : 1.055 * (double)pti_exp_double(pti_log_double(x) / 2.4) - 0.055;
    v *= 65535;
    below = floor(v);
    v -= below + 0.5;
    if (v > -1.0 / 64 && v < 1.0 / 64) v = (double)x - pti_srgb_to_linear((below + 0.5) / 65535);
    return (unsigned)below + (v >= 0);
}

/* The filmic curve: a rational fit to the ACES reference rendering (Narkowicz 2015, "ACES Filmic Tone Mapping Curve"),
       f(x) = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14),   x = 0.7231708 L,
   where the factor is the root that makes f(0.18) = 0.18. f rises everywhere, from f(0) = 0, and passes 1 at L = 10.01.
   In double, since rounded to float it then rises still. */
static float pti_filmic(float L) {
    double x, f;
    if (!(L > 0)) return 0;
    x = 0.7231708 * (double)pti_min(L, 16);
    f = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    return f < 1 ? (float)f : 1.0f;
}
/* The colour of a luminance, in sRGB bytes: see pt_curve. */
static const uint8_t *pti_false_color(float luminance) {
    static const uint8_t color[13][3] = {
        { 0, 0, 0 }, { 56, 0, 88 }, { 112, 0, 200 }, { 0, 0, 255 }, { 0, 112, 255 }, { 0, 208, 224 },     /* -6 to -1 */
        { 0, 160, 64 },
        { 144, 224, 0 }, { 255, 240, 0 }, { 255, 144, 0 }, { 224, 0, 0 }, { 255, 112, 176 }, { 255, 255, 255 } };
    float least = 0.18f * 0.022097087f;                  /* 0.18 2^-5.5 */
    int k;
    for (k = 0; k < 12 && luminance >= least; k++) least *= 2;
    return color[k];
}

/* A pixel's way to bytes: exposure, curve, sRGB. */
typedef struct pti_encoder { float scale; pt_curve curve; int bytes; pti_srgb srgb; } pti_encoder;   /* bytes a channel */
static int pti_encoder_init(pti_encoder *c, const pt_encoding *e) {    /* 0: out of range */
    pt_encoding zero;
    memset(&zero, 0, sizeof zero);
    if (!e) e = &zero;
    if (!(fabsf(e->exposure_stops) <= 100) || (e->bits != 0 && e->bits != 8 && e->bits != 16)) return 0;
    if (e->curve != PT_CURVE_SRGB && e->curve != PT_CURVE_FILMIC && e->curve != PT_CURVE_FALSE_COLOR) return 0;
    c->scale = pti_pow(2, e->exposure_stops);
    c->curve = e->curve;
    c->bytes = e->bits == 16 ? 2 : 1;
    pti_srgb_init(&c->srgb);
    return 1;
}
static void pti_encode_false_color(const pti_encoder *c, const float *rgb, uint8_t *out) {
    const uint8_t *color = pti_false_color(pti_luminance(pti_scale(pt_v3(rgb[0], rgb[1], rgb[2]), c->scale)));
    int i;
    for (i = 0; i < 3 * c->bytes; i++) out[i] = color[i / c->bytes];   /* 257 k is to 16 bits what k is to 8 */
}
static void pti_encode(const pti_encoder *c, const float *rgb, uint8_t *out) {
    unsigned v;
    float x;
    int i;
    if (c->curve == PT_CURVE_FALSE_COLOR) { pti_encode_false_color(c, rgb, out); return; }
    for (i = 0; i < 3; i++) {
        x = rgb[i] * c->scale;
        if (c->curve == PT_CURVE_FILMIC) x = pti_filmic(x);
        if (c->bytes == 1) { out[i] = (uint8_t)pti_srgb_byte(&c->srgb, x); continue; }
        v = pti_srgb_16(x);
        out[2 * i] = (uint8_t)(v >> 8);
        out[2 * i + 1] = (uint8_t)(v & 255);
    }
}

PT_DEF pt_result pt_write_ppm_to(const pt_writer *w, const float *rgb, int width, int height, const pt_encoding *e) {
    pti_output o;
    pti_encoder c;
    pti_fpmode mode = pti_fpmode_enter();
    int x, y, ok = pti_output_begin(&o, w, rgb, width, height) && pti_encoder_init(&c, e);
    if (ok) {
        c.bytes = 1;
        pti_output_size(&o, "P6\n", width);
        pti_output_size(&o, " ", height);
        pti_output_text(&o, "\n255\n");
        for (y = 0; y < height && !o.failed; y++) {
            const float *row = pti_row(rgb, width, y);
            for (x = 0; x < width; x++) {
                uint8_t pixel[3];
                pti_encode(&c, row + 3 * (size_t)x, pixel);
                pti_output_byte(&o, pixel[0]);
                pti_output_byte(&o, pixel[1]);
                pti_output_byte(&o, pixel[2]);
            }
        }
    }
    pti_fpmode_leave(mode);
    return ok ? pti_output_end(&o) : PT_ERR_ARG;
}

/* PNG (ISO/IEC 15948): the rows, each as its difference from a guess by the left, upper and upper left neighbours, in one
   deflate stream (RFC 1951) in zlib's wrapping (RFC 1950), cut into chunks. What a path tracer leaves in the differences is
   noise, in which nothing repeats; where nothing happens they are zeros. So the only matches that are looked for are runs
   of one byte, and the rest is up to Huffman's code, made anew for each block of 16 KiB. With noise that is as small as
   what zlib finds in the last 32 KiB, on clean pictures up to 10 % larger, and it takes no memory but the block. */
#define PTI_PNG_BLOCK 16384
#define PTI_PNG_SYMBOLS 286                              /* 256 literals, the end of the block, 29 lengths of runs */
#define PTI_PNG_LONGEST 14                               /* bits of a code; deflate allows 15 */
typedef struct pti_png {
    pti_output *out;
    uint32_t adler;                                      /* Adler-32: b << 16 | a; a sums the bytes up, b the a's */
    uint32_t bits;                                       /* what makes no byte yet, the first bit lowest */
    int bit_count, filter;
    size_t used, packed_used;
    uint32_t count[PTI_PNG_SYMBOLS];                     /* how often the block has each symbol */
    uint16_t code[PTI_PNG_SYMBOLS];                      /* the first bit lowest */
    uint8_t length[PTI_PNG_SYMBOLS];                     /* bits of the code; 0 = not in the block */
    uint8_t block[PTI_PNG_BLOCK], packed[8192];          /* bytes to compress; bytes of the next IDAT chunk */
} pti_png;

static uint32_t pti_crc32(uint32_t crc, const uint8_t *p, size_t n) {
    static const uint32_t nibble[16] = { 0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158,
        0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c };
    for (; n; n--) {
        crc ^= *p++;
        crc = nibble[crc & 15] ^ crc >> 4;
        crc = nibble[crc & 15] ^ crc >> 4;
    }
    return crc;
}
static void pti_big_endian(uint8_t *p, uint32_t v) {
    p[0] = (uint8_t)(v >> 24); p[1] = (uint8_t)(v >> 16 & 255); p[2] = (uint8_t)(v >> 8 & 255); p[3] = (uint8_t)(v & 255);
}
static void pti_png_chunk(pti_output *o, const char *type, const uint8_t *data, size_t n) {
    uint8_t head[8], tail[4];
    size_t i;
    pti_big_endian(head, (uint32_t)n);
    memcpy(head + 4, type, 4);
    pti_big_endian(tail, ~pti_crc32(pti_crc32(0xffffffffu, head + 4, 4), data, n));
    for (i = 0; i < 8; i++) pti_output_byte(o, head[i]);
    for (i = 0; i < n; i++) pti_output_byte(o, data[i]);
    for (i = 0; i < 4; i++) pti_output_byte(o, tail[i]);
}
static void pti_png_flush(pti_png *z) {
    if (z->packed_used) pti_png_chunk(z->out, "IDAT", z->packed, z->packed_used);
    z->packed_used = 0;
}
static void pti_png_packed(pti_png *z, unsigned byte) {
    if (z->packed_used == sizeof z->packed) pti_png_flush(z);
    z->packed[z->packed_used++] = (uint8_t)byte;
}
static void pti_png_bits(pti_png *z, uint32_t v, int n) {    /* n <= 16 */
    z->bits |= v << z->bit_count;
    for (z->bit_count += n; z->bit_count >= 8; z->bit_count -= 8, z->bits >>= 8) pti_png_packed(z, z->bits & 255);
}

/* Huffman 1952: the two rarest nodes become one, again and again, until one is left. The symbols, sorted, are one queue,
   and the nodes made of them come out as another, so the rarest is always first in one of the two. */
static int pti_png_sort(const pti_png *z, uint16_t *order, uint32_t *weight) {    /* the symbols that occur, rarest first */
    int n = 0, s, i;
    for (s = 0; s < PTI_PNG_SYMBOLS; s++) {
        if (!z->count[s]) continue;
        for (i = n++; i > 0 && weight[i - 1] > z->count[s]; i--) {
            weight[i] = weight[i - 1];
            order[i] = order[i - 1];
        }
        weight[i] = z->count[s];
        order[i] = (uint16_t)s;
    }
    return n;
}
static void pti_png_depths(uint32_t *weight, int n, uint8_t *depth) {
    uint16_t parent[2 * PTI_PNG_SYMBOLS];
    int leaf = 0, node = n, made, i;
    for (made = n; made < 2 * n - 1; made++) {
        weight[made] = 0;
        for (i = 0; i < 2; i++) {
            int rarest = leaf < n && (node == made || weight[leaf] <= weight[node]) ? leaf++ : node++;
            weight[made] += weight[rarest];
            parent[rarest] = (uint16_t)made;
        }
    }
    depth[2 * n - 2] = 0;                                /* the root */
    for (i = 2 * n - 3; i >= 0; i--) depth[i] = (uint8_t)(depth[parent[i]] + 1);
}
static void pti_png_code_lengths(pti_png *z) {
    uint32_t weight[2 * PTI_PNG_SYMBOLS];
    uint16_t order[PTI_PNG_SYMBOLS];
    uint8_t depth[2 * PTI_PNG_SYMBOLS];
    int n = pti_png_sort(z, order, weight), i;
    pti_png_depths(weight, n, depth);
    while (depth[0] > PTI_PNG_LONGEST) {                 /* too deep, even for the rarest: make the counts more alike */
        for (i = 0; i < n; i++) weight[i] = (weight[i] + 1) / 2;
        pti_png_depths(weight, n, depth);
    }
    memset(z->length, 0, sizeof z->length);
    for (i = 0; i < n; i++) z->length[order[i]] = depth[i];
}
/* The code that follows from the lengths: shorter ones first, among equals by symbol (RFC 1951, 3.2.2). */
static uint16_t pti_png_reverse(uint32_t code, int length) { return (uint16_t)(pti_reverse_bits(code) >> (32 - length)); }
static void pti_png_codes(pti_png *z) {
    uint32_t next = 0;
    int length, s;
    for (length = 1; length <= PTI_PNG_LONGEST; length++) {
        next <<= 1;
        for (s = 0; s < PTI_PNG_SYMBOLS; s++) if (z->length[s] == length) z->code[s] = pti_png_reverse(next++, length);
    }
}
/* A block's head. The lengths of the code are written in a code themselves: four bits each, where 15 stands for the symbol
   18, "a run of 11 to 138 zeros, their number in seven bits more". One distance is all there is, in one bit. */
static void pti_png_block_head(pti_png *z, int last) {
    static const uint8_t order[19] = { 16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15 };
    int i, run;
    pti_png_bits(z, last ? 5 : 4, 3);                    /* BFINAL, BTYPE = 2 */
    pti_png_bits(z, PTI_PNG_SYMBOLS - 257, 5);           /* HLIT */
    pti_png_bits(z, 0, 5);                               /* HDIST: one */
    pti_png_bits(z, 19 - 4, 4);                          /* HCLEN */
    for (i = 0; i < 19; i++) pti_png_bits(z, order[i] < 15 || order[i] == 18 ? 4 : 0, 3);
    for (i = 0; i < PTI_PNG_SYMBOLS; i += run) {
        for (run = 0; run < 138 && i + run < PTI_PNG_SYMBOLS && z->length[i + run] == 0; run++) {}
        if (run < 11) { run = 1; pti_png_bits(z, pti_png_reverse(z->length[i], 4), 4); }
        else { pti_png_bits(z, 15, 4); pti_png_bits(z, (uint32_t)run - 11, 7); }
    }
    pti_png_bits(z, pti_png_reverse(1, 4), 4);
}
/* How many bytes from i on are like the one before, up to 258. */
static unsigned pti_png_run(const pti_png *z, size_t i) {
    size_t end = z->used - i < 258 ? z->used : i + 258, k = i;
    if (i) while (k < end && z->block[k] == z->block[i - 1]) k++;
    return (unsigned)(k - i);
}
/* The block's symbols, counted or written. A run from 3 on is a length and the distance 1: of length - 3 the symbol tells
   the three highest bits, extra ones the rest; 258 has a symbol of its own. */
static void pti_png_symbols(pti_png *z, int write) {
    size_t i = 0;
    while (i < z->used) {
        unsigned run = pti_png_run(z, i), rest = run - 3;
        int s = z->block[i], extra = 0;
        if (run >= 3) {
            while (rest >> extra >= 8) extra++;
            s = 257 + 4 * extra + (int)(rest >> extra);
        }
        if (run == 258) { s = 285; extra = 0; }
        if (write) pti_png_bits(z, z->code[s], z->length[s]);
        else z->count[s]++;
        if (write && run >= 3) pti_png_bits(z, rest & ((1u << extra) - 1), extra + 1);   /* the last bit is the distance */
        i += run >= 3 ? run : 1;
    }
}
static void pti_png_checksum(pti_png *z) {
    uint32_t a = z->adler & 0xffff, b = z->adler >> 16;
    size_t i;
    for (i = 0; i < z->used; i++) {
        a = (a + z->block[i]) % 65521;
        b = (b + a) % 65521;
    }
    z->adler = b << 16 | a;
}
static void pti_png_block(pti_png *z, int last) {
    pti_png_checksum(z);
    memset(z->count, 0, sizeof z->count);
    z->count[256] = 1;                                   /* the end */
    pti_png_symbols(z, 0);
    pti_png_code_lengths(z);
    pti_png_codes(z);
    pti_png_block_head(z, last);
    pti_png_symbols(z, 1);
    pti_png_bits(z, z->code[256], z->length[256]);
    z->used = 0;
}
static void pti_png_byte(pti_png *z, int byte) {
    if (z->used == sizeof z->block) pti_png_block(z, 0);
    z->block[z->used++] = (uint8_t)(byte & 255);
}
/* The neighbour, a left, b above, c above a, that is nearest to a + b - c. Paeth 1991. */
static int pti_paeth(int a, int b, int c) {
    int da = b - c, db = a - c, dc = da + db;
    if (da < 0) da = -da;
    if (db < 0) db = -db;
    if (dc < 0) dc = -dc;
    return da <= db && da <= dc ? a : db <= dc ? b : c;
}
/* A row in the filter that would have been the best one, by the sum of absolute differences, for the row before: a row is
   seen but once then, and rows are much alike. (Choosing after two looks saves 0.2 %.) above: NULL in the first row. */
static void pti_png_row(pti_png *z, const pti_encoder *c, const float *row, const float *above, int width) {
    uint8_t now[6] = { 0 }, left[6] = { 0 }, up[6] = { 0 }, corner[6] = { 0 };
    uint64_t sum[5] = { 0 };
    int x, i, f, d[5];
    pti_png_byte(z, z->filter);
    for (x = 0; x < width; x++) {
        pti_encode(c, row + 3 * (size_t)x, now);
        if (above) pti_encode(c, above + 3 * (size_t)x, up);
        for (i = 0; i < 3 * c->bytes; i++) {
            d[1] = now[i] - left[i];
            d[2] = now[i] - up[i];
            d[3] = now[i] - (left[i] + up[i]) / 2;
            d[4] = now[i] - pti_paeth(left[i], up[i], corner[i]);
            for (f = 1; f < 5; f++) { int m = d[f] & 255; sum[f] += (unsigned)(m < 128 ? m : 256 - m); }
            pti_png_byte(z, d[z->filter]);
        }
        memcpy(left, now, 6);
        memcpy(corner, up, 6);
    }
    for (f = 1; f < 5; f++) if (sum[f] < sum[z->filter]) z->filter = f;
}
static void pti_png_head(pti_output *o, int width, int height, int bytes) {
    static const uint8_t signature[8] = { 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n' }, srgb[1] = { 0 };
    uint8_t header[13] = { 0 }, gamma[4];
    int i;
    for (i = 0; i < 8; i++) pti_output_byte(o, signature[i]);
    pti_big_endian(header, (uint32_t)width);
    pti_big_endian(header + 4, (uint32_t)height);
    header[8] = (uint8_t)(8 * bytes);
    header[9] = 2;                                       /* RGB */
    pti_png_chunk(o, "IHDR", header, 13);
    pti_big_endian(gamma, 45455);                        /* 1 / 2.2, for those that do not know sRGB */
    pti_png_chunk(o, "sRGB", srgb, 1);
    pti_png_chunk(o, "gAMA", gamma, 4);
}
static void pti_png_write(pti_output *o, const pti_encoder *c, const float *rgb, int width, int height) {
    pti_png z;
    uint8_t sum[4];
    int y;
    z.out = o;
    z.bits = 0; z.adler = 1;
    z.bit_count = 0; z.filter = 1;
    z.used = z.packed_used = 0;
    pti_png_head(o, width, height, c->bytes);
    pti_png_bits(&z, 0x0178, 16);                        /* zlib: deflate, a window of 32 KiB */
    for (y = 0; y < height && !o->failed; y++)
        pti_png_row(&z, c, pti_row(rgb, width, y), y ? pti_row(rgb, width, y - 1) : NULL, width);
    pti_png_block(&z, 1);
    pti_png_bits(&z, 0, (8 - z.bit_count) & 7);
    pti_big_endian(sum, z.adler);
    for (y = 0; y < 4; y++) pti_png_packed(&z, sum[y]);
    pti_png_flush(&z);
    pti_png_chunk(o, "IEND", sum, 0);
}
PT_DEF pt_result pt_write_png_to(const pt_writer *w, const float *rgb, int width, int height, const pt_encoding *e) {
    pti_output o;
    pti_encoder c;
    pti_fpmode mode = pti_fpmode_enter();
    int ok = pti_output_begin(&o, w, rgb, width, height) && pti_encoder_init(&c, e);
    if (ok) pti_png_write(&o, &c, rgb, width, height);
    pti_fpmode_leave(mode);
    return ok ? pti_output_end(&o) : PT_ERR_ARG;
}

PT_DEF pt_result pt_write_pfm_to(const pt_writer *w, const float *rgb, int width, int height) {
    pti_output o;
    uint32_t bits;
    size_t i;
    int y;
    if (!pti_output_begin(&o, w, rgb, width, height)) return PT_ERR_ARG;
    pti_output_size(&o, "PF\n", width);
    pti_output_size(&o, " ", height);
    pti_output_text(&o, "\n-1.0\n");                     /* minus: little-endian, whatever this machine is */
    for (y = height - 1; y >= 0 && !o.failed; y--) {
        const float *row = pti_row(rgb, width, y);
        for (i = 0; i < (size_t)width * 3; i++) {
            memcpy(&bits, row + i, sizeof bits);
            pti_output_byte(&o, bits & 255);
            pti_output_byte(&o, bits >> 8 & 255);
            pti_output_byte(&o, bits >> 16 & 255);
            pti_output_byte(&o, bits >> 24);
        }
    }
    return pti_output_end(&o);
}

/* RGBE of a pixel, to nearest. The largest mantissa is 128 or more (what would be less is black), so a pixel is never
   taken for the old code's 1 1 1 n, nor for the new one's 2 2 at the head of a scanline. */
#define PTI_RGBE_MAX 1.6947657e38f                       /* 255 2^119 */
static void pti_rgbe(const float *rgb, uint8_t out[4]) {
    float v[3], most = 0;
    double d;
    uint64_t bits;
    int i, e;
    for (i = 0; i < 3; i++) {
        v[i] = rgb[i] > 0 ? pti_min(rgb[i], PTI_RGBE_MAX) : 0;    /* NaN and below: 0 */
        most = pti_max(most, v[i]);
    }
    memset(out, 0, 4);
    d = (double)most;
    memcpy(&bits, &d, sizeof bits);
    e = (int)(bits >> 52) - 1022;                        /* most = f 2^e, f in [1/2, 1) */
    if (e < -127) return;
    if (d * pti_power_of_2(8 - e) >= 255.5) e++;         /* 256 does not fit in a byte */
    for (i = 0; i < 3; i++) out[i] = (uint8_t)((double)v[i] * pti_power_of_2(8 - e) + 0.5);
    out[3] = (uint8_t)(e + 128);
}
static void pti_rle_literals(pti_output *o, const uint8_t *b, int n) {
    int i;
    if (!n) return;
    pti_output_byte(o, (unsigned)n);
    for (i = 0; i < n; i++) pti_output_byte(o, b[i]);
}
/* Runs of 3 to 127 as 128 + length, value; the rest in literals of up to 128, after their number. */
static void pti_rle(pti_output *o, const uint8_t *b, int n) {
    int i = 0, literals = 0, run;
    while (i < n) {
        for (run = 1; run < 127 && i + run < n && b[i + run] == b[i]; run++) {}
        if (run < 3) { run = 1; literals++; }
        if (run > 1 || literals == 128) {
            pti_rle_literals(o, b + i + (run > 1 ? 0 : 1) - literals, literals);
            literals = 0;
        }
        if (run > 1) { pti_output_byte(o, 128u + (unsigned)run); pti_output_byte(o, b[i]); }
        i += run;
    }
    pti_rle_literals(o, b + n - literals, literals);
}
/* A scanline in the new code, by pieces: the whole of it may be too much for a stack. */
static void pti_rle_scanline(pti_output *o, const float *row, int width) {
    uint8_t piece[1024], rgbe[4];
    int c, x, n = 0;
    pti_output_byte(o, 2);
    pti_output_byte(o, 2);
    pti_output_byte(o, (unsigned)width >> 8);
    pti_output_byte(o, (unsigned)width & 255);
    for (c = 0; c < 4; c++) {
        for (x = 0; x < width; x++) {
            pti_rgbe(row + 3 * x, rgbe);
            piece[n++] = rgbe[c];
            if (n == (int)sizeof piece || x == width - 1) { pti_rle(o, piece, n); n = 0; }
        }
    }
}
static void pti_flat_scanline(pti_output *o, const float *row, int width) {
    uint8_t rgbe[4];
    int c, x;
    for (x = 0; x < width; x++) {
        pti_rgbe(row + 3 * (size_t)x, rgbe);
        for (c = 0; c < 4; c++) pti_output_byte(o, rgbe[c]);
    }
}
PT_DEF pt_result pt_write_hdr_to(const pt_writer *w, const float *rgb, int width, int height) {
    pti_output o;
    pti_fpmode mode;
    int y;
    if (!pti_output_begin(&o, w, rgb, width, height)) return PT_ERR_ARG;
    mode = pti_fpmode_enter();
    pti_output_text(&o, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n");
    pti_output_size(&o, "-Y ", height);
    pti_output_size(&o, " +X ", width);
    pti_output_text(&o, "\n");
    for (y = 0; y < height && !o.failed; y++) {
        const float *row = pti_row(rgb, width, y);
        if (width >= 8 && width <= 32767) pti_rle_scanline(&o, row, width);
        else pti_flat_scanline(&o, row, width);
    }
    pti_fpmode_leave(mode);
    return pti_output_end(&o);
}

#ifndef PT_NO_STDIO
/* A file is written beside its place, and moved there when it is whole. A device is no file that one could replace. */
typedef struct pti_save {
    const char *path;
    char *part;
    FILE *file;
    pt_allocator allocator;
    pt_writer writer;
} pti_save;
static int pti_save_write(void *user, const void *data, size_t size) { return fwrite(data, 1, size, (FILE *)user) != size; }
static int pti_save_in_place(const pti_save *s) { return !strncmp(s->path, "/dev/", 5); }
static size_t pti_save_part_size(const pti_save *s) { return strlen(s->path) + sizeof ".part"; }
static pt_result pti_save_open(pti_save *s, const char *path) {
    memset(s, 0, sizeof *s);
    s->allocator = pti_allocator_or_default(s->allocator);
    s->path = path;
    if (!path) return PT_ERR_ARG;
    s->part = (char *)pti_alloc(&s->allocator, pti_save_part_size(s), 1);
    if (!s->part) return PT_ERR_MEMORY;
    memcpy(s->part, path, strlen(path));
    if (!pti_save_in_place(s)) memcpy(s->part + strlen(path), ".part", sizeof ".part");
    s->file = fopen(s->part, "wb");
    s->writer.write = pti_save_write;
    s->writer.user = s->file;
    if (s->file) return PT_OK;
    pti_free(&s->allocator, s->part, pti_save_part_size(s), 1);
    return PT_ERR_IO;
}
/* r: how the writing went. */
static pt_result pti_save_close(pti_save *s, pt_result r) {
    if (fclose(s->file) != 0 && r == PT_OK) r = PT_ERR_IO;      /* a full disk may show only now */
    if (!pti_save_in_place(s)) {
#ifdef _WIN32
        if (r == PT_OK) remove(s->path);                 /* rename does not replace there */
#endif
        if (r == PT_OK && rename(s->part, s->path) != 0) r = PT_ERR_IO;
        if (r != PT_OK) remove(s->part);
    }
    pti_free(&s->allocator, s->part, pti_save_part_size(s), 1);
    return r;
}
PT_DEF pt_result pt_write_png(const char *path, const float *rgb, int width, int height, const pt_encoding *e) {
    pti_save s;
    pt_result r = pti_save_open(&s, path);
    return r != PT_OK ? r : pti_save_close(&s, pt_write_png_to(&s.writer, rgb, width, height, e));
}
PT_DEF pt_result pt_write_ppm(const char *path, const float *rgb, int width, int height, const pt_encoding *e) {
    pti_save s;
    pt_result r = pti_save_open(&s, path);
    return r != PT_OK ? r : pti_save_close(&s, pt_write_ppm_to(&s.writer, rgb, width, height, e));
}
PT_DEF pt_result pt_write_pfm(const char *path, const float *rgb, int width, int height) {
    pti_save s;
    pt_result r = pti_save_open(&s, path);
    return r != PT_OK ? r : pti_save_close(&s, pt_write_pfm_to(&s.writer, rgb, width, height));
}
PT_DEF pt_result pt_write_hdr(const char *path, const float *rgb, int width, int height) {
    pti_save s;
    pt_result r = pti_save_open(&s, path);
    return r != PT_OK ? r : pti_save_close(&s, pt_write_hdr_to(&s.writer, rgb, width, height));
}
#endif

/* Pixels of a picture whose sizes are in it. */
static size_t pti_image_count(const pt_image *image) {
    return (size_t)image->width * (size_t)image->height * (size_t)image->channels;
}
static pt_result pti_image_alloc(pt_image *image, const char *name, size_t width, size_t height, int channels) {
    pt_allocator a = pti_allocator_or_default(image->allocator);
    if (height <= SIZE_MAX / width / (size_t)channels)
        image->pixels = (float *)pti_alloc(&a, width * height * (size_t)channels, sizeof(float));
    if (!image->pixels) return pti_report(image->error, PT_ERR_MEMORY, name, "out of memory");
    image->width = (int)width;
    image->height = (int)height;
    image->channels = channels;
    return PT_OK;
}
PT_DEF void pt_image_free(pt_image *image) {
    pt_allocator a;
    if (!image) return;
    a = pti_allocator_or_default(image->allocator);
    pti_free(&a, image->pixels, image->pixels ? pti_image_count(image) : 0, sizeof(float));
    image->pixels = NULL;
    image->width = image->height = image->channels = 0;
}
/* A width or a height: digits, 1 to 2^31 - 1. */
static int pti_parse_size(pti_input *in, size_t *out) {
    uint64_t n = 0;
    if (!pti_is_digit(pti_peek(in))) return pti_refuse(in, "a size is missing");
    for (; pti_is_digit(pti_peek(in)); in->at++) if (n <= 0x7fffffff) n = n * 10 + (uint64_t)(*in->at - '0');
    if (n < 1 || n > 0x7fffffff) return pti_refuse(in, "a size is %s", n ? "above 2147483647" : "0");
    *out = (size_t)n;
    return 1;
}
static int pti_refuse_size(const pti_input *in, size_t width, size_t height) {
    return pti_refuse(in, "%u x %u pixels cannot come from the %u bytes that are left", (uint64_t)width, (uint64_t)height,
                      (uint64_t)pti_input_left(in));
}

/* PFM, PPM and PGM begin alike: P and a letter or digit, the width, the height, and one number more, the scale or the
   largest value. Between these words stand white space and comments; after the last, one white space only. */
typedef struct pti_pnm {
    size_t width, height, max;                           /* max: the largest value; 0 in a PFM */
    int channels, big_endian, bytes;                     /* bytes a value; 0: text */
} pti_pnm;
static int pti_pnm_space(pti_input *in) {
    const uint8_t *from = in->at;
    for (; in->at < in->end; in->at++) {
        if (*in->at == '#') while (in->at < in->end && *in->at != '\n') in->at++;
        if (in->at == in->end) break;
        if (*in->at == '\n') in->line++;
        else if (*in->at != ' ' && *in->at != '\t' && *in->at != '\r') break;
    }
    return in->at > from ? 1 : pti_refuse(in, "white space is missing");
}
static int pti_pnm_sizes(pti_input *in, pti_pnm *h) {
    in->at += 2;
    if (!pti_pnm_space(in) || !pti_parse_size(in, &h->width)) return 0;
    if (!pti_pnm_space(in) || !pti_parse_size(in, &h->height)) return 0;
    return pti_pnm_space(in);
}
static int pti_pnm_begin_pixels(pti_input *in, const pti_pnm *h, const char *last_word) {
    size_t left, row = (size_t)h->bytes * (size_t)h->channels * h->width;
    int c = pti_peek(in);
    if (c != '\n' && c != ' ' && c != '\t' && c != '\r')
        return pti_refuse(in, "the %s does not end in white space", last_word);
    in->at++;
    in->line = 0;
    left = pti_input_left(in);
    if (left / (size_t)h->bytes / (size_t)h->channels / h->width < h->height)
        return pti_refuse_size(in, h->width, h->height);
    if (c == '\r' && pti_peek(in) == '\n' && left > h->height * row) in->at++;       /* a line that ends in both */
    return 1;
}

static int pti_pfm_header(pti_input *in, pti_pnm *h) {
    double scale;
    h->channels = in->at[1] == 'F' ? 3 : 1;
    h->bytes = 4;
    h->max = 0;
    if (!pti_pnm_sizes(in, h)) return 0;
    if (!pti_parse_number(in, &scale)) return pti_refuse(in, "the scale is not a number");
    if (scale == 0) return pti_refuse(in, "the scale is 0: its sign should tell the byte order");
    h->big_endian = scale > 0;
    return pti_pnm_begin_pixels(in, h, "scale");
}
static uint64_t pti_bits_of_bytes(const uint8_t *p, int n, int big_endian) {
    uint64_t bits = 0;
    int i;
    for (i = 0; i < n; i++) bits = bits << 8 | p[big_endian ? i : n - 1 - i];
    return bits;
}
static float pti_float_of_bytes(const uint8_t *p, int big_endian) {
    uint32_t bits = (uint32_t)pti_bits_of_bytes(p, 4, big_endian);
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
static pt_result pti_read_pfm(pt_image *out, pti_input *in) {
    pti_pnm h;
    size_t row, i, y;
    pt_result r;
    if (!pti_pfm_header(in, &h)) return PT_ERR_FORMAT;
    r = pti_image_alloc(out, in->name, h.width, h.height, h.channels);
    if (r != PT_OK) return r;
    row = h.width * (size_t)h.channels;
    for (y = h.height; y-- > 0; )
        for (i = 0; i < row; i++, in->at += 4) out->pixels[y * row + i] = pti_float_of_bytes(in->at, h.big_endian);
    return PT_OK;
}

/* PPM and PGM, as netpbm defines them: P2 (grey) and P3 are text, P5 (grey) and P6 one byte a value, or two, the higher one
   first, where the largest value is above 255. */
static int pti_ppm_header(pti_input *in, pti_pnm *h) {
    int kind = in->at[1];
    h->channels = kind == '3' || kind == '6' ? 3 : 1;
    h->max = 0;
    if (!pti_pnm_sizes(in, h)) return 0;
    for (; pti_is_digit(pti_peek(in)); in->at++) if (h->max <= 65535) h->max = h->max * 10 + (size_t)(*in->at - '0');
    if (h->max < 1 || h->max > 65535) return pti_refuse(in, "the largest value is not a number from 1 to 65535");
    h->big_endian = 1;
    h->bytes = kind < '4' ? 0 : h->max > 255 ? 2 : 1;
    if (h->bytes) return pti_pnm_begin_pixels(in, h, "largest value");
    if ((pti_input_left(in) + 1) / 2 / (size_t)h->channels / h->width < h->height)   /* a digit and a space a value */
        return pti_refuse_size(in, h->width, h->height);
    return 1;
}
static int pti_ppm_value(pti_input *in, const pti_pnm *h, size_t *out) {
    size_t v = 0;
    if (!h->bytes) {
        if (!pti_pnm_space(in)) return 0;
        if (in->at == in->end) return pti_refuse(in, "the file ends within the pixels");
        if (!pti_is_digit(*in->at)) return pti_refuse(in, "a value is not a whole number");
        for (; pti_is_digit(pti_peek(in)); in->at++) if (v <= h->max) v = v * 10 + (size_t)(*in->at - '0');
    } else {
        v = h->bytes == 1 ? in->at[0] : in->at[0] * 256u + in->at[1];
    }
    if (v > h->max) return pti_refuse(in, "%u is above the largest value, %u", (uint64_t)v, (uint64_t)h->max);
    in->at += h->bytes;
    *out = v;
    return 1;
}
static pt_result pti_read_ppm(pt_image *out, pti_input *in) {
    float linear[256];
    pti_pnm h;
    size_t i, v = 0, count;
    pt_result r;
    if (!pti_ppm_header(in, &h)) return PT_ERR_FORMAT;
    r = pti_image_alloc(out, in->name, h.width, h.height, h.channels);
    if (r != PT_OK) return r;
    count = pti_image_count(out);
    for (i = 0; i < 256; i++) linear[i] = i <= h.max ? (float)pti_srgb_to_linear((double)i / (double)h.max) : 0;
    for (i = 0; i < count; i++) {
        if (!pti_ppm_value(in, &h, &v)) { pt_image_free(out); return PT_ERR_FORMAT; }
        out->pixels[i] = v < 256 ? linear[v] : (float)pti_srgb_to_linear((double)v / (double)h.max);
    }
    return PT_OK;
}

/* Radiance HDR. Scanlines follow one another along the first axis that the resolution line tells, pixels within them
   along the second: "-Y 512 +X 1024" is top to bottom, left to right. */
typedef struct pti_hdr {
    size_t lines, length;                                /* scanlines, and pixels in each */
    int x_first, x_down, y_down;
    int xyz, plain;                                      /* plain: RGB, and nothing to divide by */
    double divide[3];                                    /* EXPOSURE times COLORCORR: what the pixels were multiplied by */
} pti_hdr;

/* Puts line's [at, end) around the next line, without its end, and in->at behind it. */
static int pti_hdr_line(pti_input *in, pti_input *line) {
    const uint8_t *nl = (const uint8_t *)memchr(in->at, '\n', pti_input_left(in));
    in->line++;
    if (!nl) return pti_refuse(in, "the header ends early");
    *line = *in;
    line->end = nl > in->at && nl[-1] == '\r' ? nl - 1 : nl;
    in->at = nl + 1;
    return 1;
}
static int pti_skip_word(pti_input *in, const char *word) {
    size_t n = strlen(word);
    if (pti_input_left(in) < n || memcmp(in->at, word, n)) return 0;
    in->at += n;
    return 1;
}
static void pti_skip_blanks(pti_input *in) { while (pti_peek(in) == ' ' || pti_peek(in) == '\t') in->at++; }
/* Multiplies n factors into divide; a single one counts for all three. */
static int pti_hdr_factors(pti_input *line, pti_hdr *h, int n) {
    double f = 1;
    int i;
    for (i = 0; i < 3; i++) {
        pti_skip_blanks(line);
        if (i < n && !pti_parse_number(line, &f)) return pti_refuse(line, "%d numbers are expected", n);
        h->divide[i] *= f;
        if (!(h->divide[i] > 1e-30 && h->divide[i] < 1e30)) return pti_refuse(line, "%g is no exposure", f);
        h->plain = h->plain && h->divide[i] == 1;
    }
    pti_skip_blanks(line);
    return line->at == line->end ? 1 : pti_refuse(line, "the number does not end where it should");
}
static int pti_hdr_format(pti_input *line, pti_hdr *h) {
    pti_skip_blanks(line);
    h->xyz = pti_skip_word(line, "32-bit_rle_xyze");
    h->plain = h->plain && !h->xyz;
    if (h->xyz || pti_skip_word(line, "32-bit_rle_rgbe")) pti_skip_blanks(line);
    else line->end = NULL;
    return line->at == line->end ? 1 : pti_refuse(line, "FORMAT is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze");
}
/* One of the resolution line's two halves, such as "-Y 512". */
static int pti_hdr_axis(pti_input *line, int *axis, int *minus, size_t *size) {
    pti_skip_blanks(line);
    *minus = pti_peek(line) == '-';
    if (!*minus && pti_peek(line) != '+') return pti_refuse(line, "expected a size, such as -Y 512 +X 1024");
    line->at++;
    *axis = pti_peek(line);
    if (*axis != 'X' && *axis != 'Y') return pti_refuse(line, "expected a size, such as -Y 512 +X 1024");
    line->at++;
    pti_skip_blanks(line);
    return pti_parse_size(line, size);
}
static int pti_hdr_resolution(pti_input *line, pti_hdr *h) {
    int axis[2], minus[2];
    if (!pti_hdr_axis(line, &axis[0], &minus[0], &h->lines)) return 0;
    if (!pti_hdr_axis(line, &axis[1], &minus[1], &h->length)) return 0;
    if (axis[0] == axis[1]) return pti_refuse(line, "the size has one axis twice");
    pti_skip_blanks(line);
    if (line->at != line->end) return pti_refuse(line, "something follows the size");
    h->x_first = axis[0] == 'X';
    h->x_down = minus[h->x_first ? 0 : 1];
    h->y_down = minus[h->x_first ? 1 : 0];
    return 1;
}
static int pti_hdr_header(pti_input *in, pti_hdr *h) {
    pti_input line;
    int ok;
    h->xyz = 0;
    h->plain = 1;
    h->divide[0] = h->divide[1] = h->divide[2] = 1;
    in->line = 0;
    for (;;) {
        if (!pti_hdr_line(in, &line)) return 0;
        if (line.at == line.end) break;                  /* an empty line ends the header */
        if (pti_skip_word(&line, "FORMAT=")) ok = pti_hdr_format(&line, h);
        else if (pti_skip_word(&line, "EXPOSURE=")) ok = pti_hdr_factors(&line, h, 1);
        else if (pti_skip_word(&line, "COLORCORR=")) ok = pti_hdr_factors(&line, h, 3);
        else ok = 1;
        if (!ok) return 0;
    }
    ok = pti_hdr_line(in, &line) && pti_hdr_resolution(&line, h);
    in->line = 0;
    return ok;
}

/* A scanline into four planes, red green blue exponent, n bytes each; without planes it is only checked. */
static int pti_hdr_new_scanline(pti_input *in, uint8_t *planes, size_t n) {
    size_t c, x, run = in->at[2] * 256u + in->at[3];
    if (run != n) return pti_refuse(in, "a scanline is %u pixels long instead of %u", (uint64_t)run, (uint64_t)n);
    in->at += 4;
    for (c = 0; c < 4; c++) for (x = 0; x < n; x += run) {
        int same = pti_peek(in) > 128;
        if (pti_input_left(in) < 2) return pti_refuse(in, "the file ends within a scanline");
        run = same ? *in->at - 128u : *in->at;
        if (run == 0 || run > n - x)
            return pti_refuse(in, "a run of %u where a scanline lacks %u", (uint64_t)run, (uint64_t)(n - x));
        if (pti_input_left(in) < (same ? 2 : 1 + run)) return pti_refuse(in, "the file ends within a scanline");
        if (planes && same) memset(planes + c * n + x, in->at[1], run);
        if (planes && !same) memcpy(planes + c * n + x, in->at + 1, run);
        in->at += same ? 2 : 1 + run;
    }
    return 1;
}
static int pti_hdr_old_scanline(pti_input *in, uint8_t *planes, size_t n) {
    size_t c, x = 0;
    int shift = 0;                                       /* repeats in a row are the digits of one number, lowest first */
    for (; x < n; in->at += 4) {
        const uint8_t *p = in->at;
        uint64_t run = 1;
        if (pti_input_left(in) < 4) return pti_refuse(in, "the file ends within a scanline");
        if (p[0] == 1 && p[1] == 1 && p[2] == 1) {
            run = (uint64_t)p[3] << shift;
            if (x == 0 || run > n - x)
                return pti_refuse(in, "a repeat of %u where a scanline has %u pixels and lacks %u", run, (uint64_t)x,
                                  (uint64_t)(n - x));
            for (c = 0; planes && c < 4; c++) memset(planes + c * n + x, planes[c * n + x - 1], (size_t)run);
            if (shift < 32) shift += 8;
        } else {
            for (c = 0; planes && c < 4; c++) planes[c * n + x] = p[c];
            shift = 0;
        }
        x += (size_t)run;
    }
    return 1;
}
static int pti_hdr_scanline(pti_input *in, uint8_t *planes, size_t n) {
    const uint8_t *p = in->at;
    if (n >= 8 && n <= 32767 && pti_input_left(in) >= 4 && p[0] == 2 && p[1] == 2 && p[2] < 128)
        return pti_hdr_new_scanline(in, planes, n);
    return pti_hdr_old_scanline(in, planes, n);
}
/* Are all scanlines there? Asked before memory for them is. The old code packs a row of one colour into a few bytes: past
   4096 pixels a byte that is no picture but a trap. */
static int pti_hdr_check(pti_input in, const pti_hdr *h) {
    size_t i;
    if ((uint64_t)h->lines * h->length / 4096 > pti_input_left(&in)) return pti_refuse_size(&in, h->length, h->lines);
    for (i = 0; i < h->lines; i++) if (!pti_hdr_scanline(&in, NULL, h->length)) return 0;
    return 1;
}
static void pti_hdr_pixel(const pti_hdr *h, const uint8_t *p, size_t n, float *out) {
    const double most = (double)FLT_MAX;
    double scale, v[3];
    size_t i;
    if (!p[3 * n]) { out[0] = out[1] = out[2] = 0; return; }
    scale = pti_power_of_2(p[3 * n] - 136);
    for (i = 0; i < 3; i++) v[i] = p[i * n] * scale;
    if (!h->plain) {
        for (i = 0; i < 3; i++) v[i] /= h->divide[i];
        if (h->xyz) pti_rgb_of_xyz(v);
        for (i = 0; i < 3; i++) v[i] = v[i] > most ? most : v[i] < -most ? -most : v[i];
    }
    for (i = 0; i < 3; i++) out[i] = (float)v[i];
}
/* Scanline i into its row or column. */
static void pti_hdr_place(const pti_hdr *h, const pt_image *out, const uint8_t *planes, size_t i) {
    size_t w = (size_t)out->width, last_x = w - 1, last_y = (size_t)out->height - 1, j, x, y;
    for (j = 0; j < h->length; j++) {
        x = h->x_first ? i : j;
        y = h->x_first ? j : i;
        if (h->x_down) x = last_x - x;
        if (!h->y_down) y = last_y - y;                  /* y counts upwards in the file, downwards here */
        pti_hdr_pixel(h, planes + j, h->length, out->pixels + (y * w + x) * 3);
    }
}
static pt_result pti_read_hdr(pt_image *out, pti_input *in) {
    pt_allocator a = pti_allocator_or_default(out->allocator);
    pti_hdr h;
    uint8_t *planes;
    pt_result r;
    size_t i;
    if (!pti_hdr_header(in, &h) || !pti_hdr_check(*in, &h)) return PT_ERR_FORMAT;
    planes = (uint8_t *)pti_alloc(&a, h.length, 4);
    if (!planes) return pti_report(out->error, PT_ERR_MEMORY, in->name, "out of memory");
    r = pti_image_alloc(out, in->name, h.x_first ? h.lines : h.length, h.x_first ? h.length : h.lines, 3);
    for (i = 0; r == PT_OK && i < h.lines; i++) {
        pti_hdr_scanline(in, planes, h.length);
        pti_hdr_place(&h, out, planes, i);
    }
    pti_free(&a, planes, h.length, 4);
    return r;
}

static pt_result pti_read_image(pt_image *out, const char *name, const void *data, size_t size) {
    pti_input in = pti_input_of(name, data, size, out->error);
    pti_fpmode mode = pti_fpmode_enter();
    pt_result r = PT_ERR_FORMAT;
    if (pti_input_left(&in) < 2) pti_refuse(&in, "the file is empty");
    else if (in.at[0] == 'P' && (in.at[1] == 'F' || in.at[1] == 'f')) r = pti_read_pfm(out, &in);
    else if (in.at[0] == 'P' && strchr("2356", in.at[1]) && in.at[1]) r = pti_read_ppm(out, &in);
    else if (in.at[0] == '#' && in.at[1] == '?') r = pti_read_hdr(out, &in);
    else pti_refuse(&in, "neither a PFM, a PPM, a PGM nor a Radiance HDR picture");
    pti_fpmode_leave(mode);
    return r;
}
PT_DEF pt_result pt_read_image_memory(pt_image *out, const void *data, size_t size) {
    if (!out || (!data && size)) return PT_ERR_ARG;
    pt_image_free(out);
    out->error[0] = 0;
    return pti_read_image(out, "memory", data, size);
}
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_read_image(pt_image *out, const char *path) {
    pt_allocator a;
    pti_file f;
    pt_result r;
    if (!out || !path) return PT_ERR_ARG;
    pt_image_free(out);
    out->error[0] = 0;
    a = pti_allocator_or_default(out->allocator);
    r = pti_file_read(&a, path, out->error, &f);
    if (r != PT_OK) return r;
    r = pti_read_image(out, path, f.data, f.size);
    pti_file_free(&a, &f);
    return r;
}
#endif

/* ---- >>merl --------------------------------------------------------------------------------------------
   Measured BRDFs of the MERL database (Matusik, Pfister, Brand and McMillan 2003): three int32, 90 90 180, then a plane of
   doubles for each of red, green and blue, theta_h slowest and phi_d fastest, all little-endian; reflectance is the number
   times 1/1500, 1.15/1500, 1.66/1500. What could not be measured is negative. */
#define PTI_MERL_H 90
#define PTI_MERL_D 90
#define PTI_MERL_P 180
#define PTI_MERL_CELLS ((size_t)PTI_MERL_H * PTI_MERL_D * PTI_MERL_P)
#define PTI_MERL_HEADER 12

static uint32_t pti_little32(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}
static double pti_little_double(const uint8_t *p) {
    uint64_t bits = (uint64_t)pti_little32(p) | (uint64_t)pti_little32(p + 4) << 32;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
static int pti_merl_check(pti_input *in) {
    uint32_t dims[3];
    size_t i, size = PTI_MERL_HEADER + 3 * 8 * PTI_MERL_CELLS;
    if (pti_input_left(in) < PTI_MERL_HEADER) return pti_refuse(in, "the file ends in its header");
    for (i = 0; i < 3; i++) dims[i] = pti_little32(in->at + 4 * i);
    if (dims[0] != PTI_MERL_H || dims[1] != PTI_MERL_D || dims[2] != PTI_MERL_P)
        return pti_refuse(in, "no measured BRDF: it begins with %u %u %u, not with 90 90 180", (uint64_t)dims[0],
                          (uint64_t)dims[1], (uint64_t)dims[2]);
    if (pti_input_left(in) == size) return 1;
    return pti_refuse(in, "the file has %u bytes, and should have %u", (uint64_t)pti_input_left(in), (uint64_t)size);
}
static int pti_merl_values(pti_input *in, float *values) {
    static const double scale[3] = { 1 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0 };
    size_t channel, i;
    in->at += PTI_MERL_HEADER;
    for (channel = 0; channel < 3; channel++) for (i = 0; i < PTI_MERL_CELLS; i++, in->at += 8) {
        double v = pti_little_double(in->at) * scale[channel];
        if (!(v >= -1e12 && v <= 1e12)) return pti_refuse(in, "%g is no reflectance", v);
        values[3 * i + channel] = (float)(v > 0 ? v : 0);
    }
    return 1;
}
static pt_result pti_read_merl(pt_merl *out, const char *name, const void *data, size_t size) {
    pt_allocator a = pti_allocator_or_default(out->allocator);
    pti_input in = pti_input_of(name, data, size, out->error);
    pti_fpmode mode;
    int fine;
    in.line = 0;
    if (!pti_merl_check(&in)) return PT_ERR_FORMAT;
    out->values = (float *)pti_alloc(&a, 3 * PTI_MERL_CELLS, sizeof(float));
    if (!out->values) return pti_report(out->error, PT_ERR_MEMORY, name, "out of memory");
    mode = pti_fpmode_enter();
    fine = pti_merl_values(&in, out->values);
    pti_fpmode_leave(mode);
    if (!fine) pt_merl_free(out);
    return fine ? PT_OK : PT_ERR_FORMAT;
}
PT_DEF pt_result pt_read_merl_memory(pt_merl *out, const void *data, size_t size) {
    if (!out || (!data && size)) return PT_ERR_ARG;
    pt_merl_free(out);
    out->error[0] = 0;
    return pti_read_merl(out, "memory", data, size);
}
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_read_merl(pt_merl *out, const char *path) {
    pt_allocator a;
    pti_file f;
    pt_result r;
    if (!out || !path) return PT_ERR_ARG;
    pt_merl_free(out);
    out->error[0] = 0;
    a = pti_allocator_or_default(out->allocator);
    r = pti_file_read(&a, path, out->error, &f);
    if (r != PT_OK) return r;
    r = pti_read_merl(out, path, f.data, f.size);
    pti_file_free(&a, &f);
    return r;
}
#endif
PT_DEF void pt_merl_free(pt_merl *merl) {
    pt_allocator a;
    if (!merl) return;
    a = pti_allocator_or_default(merl->allocator);
    pti_free(&a, merl->values, 3 * PTI_MERL_CELLS, sizeof(float));
    merl->values = NULL;
}

/* ---- >>grid --------------------------------------------------------------------------------------------
   Mitsuba's VOL files, version 3 (its manual, "Grid-based volume data source"), all little-endian: the letters VOL and a byte 3;
   int32 1, for floats; int32 sizes along x, y, z and int32 number of channels, here 1; six floats, the least and the largest
   corner of a box; then the values, x fastest, z slowest. */
#define PTI_VOL_HEADER 48
#define PTI_VOL_SIZE 4096                                /* along each axis, as pt_add_medium has it */

static float pti_little_float(const uint8_t *p) {
    uint32_t bits = pti_little32(p);
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
static size_t pti_grid_count(const pt_grid *g) { return (size_t)g->nx * (size_t)g->ny * (size_t)g->nz; }
static int pti_grid_fits(uint32_t x, uint32_t y, uint32_t z) {
    return x - 1 < PTI_VOL_SIZE && y - 1 < PTI_VOL_SIZE && z - 1 < PTI_VOL_SIZE && (uint64_t)x * y * z <= SIZE_MAX / 8;
}
static int pti_grid_boxed(const pt_grid *g) {
    return pti_finite3(g->lo) && pti_finite3(g->hi) && g->lo.x <= g->hi.x && g->lo.y <= g->hi.y && g->lo.z <= g->hi.z;
}
static int pti_grid_header(pti_input *in, pt_grid *out) {
    const uint8_t *p = in->at;
    uint32_t kind, x, y, z, channels;
    uint64_t size;
    if (pti_input_left(in) < PTI_VOL_HEADER) return pti_refuse(in, "the file ends in its header");
    if (memcmp(p, "VOL\3", 4)) return pti_refuse(in, "no grid: it does not begin with VOL and version 3");
    kind = pti_little32(p + 4);
    x = pti_little32(p + 8); y = pti_little32(p + 12); z = pti_little32(p + 16);
    channels = pti_little32(p + 20);
    in->at = p + 4;
    if (kind != 1) return pti_refuse(in, "its values are of kind %u, and should be of kind 1, floats", (uint64_t)kind);
    in->at = p + 20;
    if (channels != 1) return pti_refuse(in, "it has %u channels, and should have 1", (uint64_t)channels);
    in->at = p + 8;
    if (!pti_grid_fits(x, y, z))
        return pti_refuse(in, "its sizes are %u x %u x %u, and should be 1 to 4096", (uint64_t)x, (uint64_t)y, (uint64_t)z);
    in->at = p;
    size = PTI_VOL_HEADER + 4 * (uint64_t)x * y * z;
    if (pti_input_left(in) != size)
        return pti_refuse(in, "the file has %u bytes, and should have %u", (uint64_t)pti_input_left(in), size);
    out->lo = pt_v3(pti_little_float(p + 24), pti_little_float(p + 28), pti_little_float(p + 32));
    out->hi = pt_v3(pti_little_float(p + 36), pti_little_float(p + 40), pti_little_float(p + 44));
    in->at = p + 24;
    if (!pti_grid_boxed(out)) return pti_refuse(in, "its box is not finite, or lo is above hi");
    in->at = p;
    out->nx = (int)x; out->ny = (int)y; out->nz = (int)z;
    return 1;
}
static pt_result pti_read_grid(pt_grid *out, const char *name, const void *data, size_t size) {
    pt_allocator a = pti_allocator_or_default(out->allocator);
    pti_input in = pti_input_of(name, data, size, out->error);
    size_t i, n;
    in.line = 0;
    if (!pti_grid_header(&in, out)) return PT_ERR_FORMAT;
    n = pti_grid_count(out);
    out->values = (float *)pti_alloc(&a, n, sizeof(float));
    if (!out->values) return pti_report(out->error, PT_ERR_MEMORY, name, "out of memory");
    in.at += PTI_VOL_HEADER;
    for (i = 0; i < n; i++, in.at += 4) {
        out->values[i] = pti_little_float(in.at);
        if (pti_finite(out->values[i])) continue;
        pt_grid_free(out);
        pti_refuse(&in, "value %u of %u is not a finite number", (uint64_t)i + 1, (uint64_t)n);
        return PT_ERR_FORMAT;
    }
    return PT_OK;
}
PT_DEF pt_result pt_read_grid_memory(pt_grid *out, const void *data, size_t size) {
    if (!out || (!data && size)) return PT_ERR_ARG;
    pt_grid_free(out);
    out->error[0] = 0;
    return pti_read_grid(out, "memory", data, size);
}
static void pti_output_little32(pti_output *o, uint32_t v) {
    int k;
    for (k = 0; k < 32; k += 8) pti_output_byte(o, v >> k & 255);
}
static void pti_output_floats(pti_output *o, const float *x, size_t n) {
    uint32_t bits;
    for (; n && !o->failed; n--, x++) {
        memcpy(&bits, x, sizeof bits);
        pti_output_little32(o, bits);
    }
}
PT_DEF pt_result pt_write_grid_to(const pt_writer *w, const pt_grid *grid) {
    float box[6];
    size_t i, n;
    pti_output o;
    if (!grid || !pti_output_begin(&o, w, grid->values, grid->nx, grid->ny) || grid->nz < 1
        || !pti_grid_fits((uint32_t)grid->nx, (uint32_t)grid->ny, (uint32_t)grid->nz) || !pti_grid_boxed(grid)) return PT_ERR_ARG;
    n = pti_grid_count(grid);
    for (i = 0; i < n; i++) if (!pti_finite(grid->values[i])) return PT_ERR_ARG;
    box[0] = grid->lo.x; box[1] = grid->lo.y; box[2] = grid->lo.z;
    box[3] = grid->hi.x; box[4] = grid->hi.y; box[5] = grid->hi.z;
    pti_output_text(&o, "VOL\3");
    pti_output_little32(&o, 1);
    pti_output_little32(&o, (uint32_t)grid->nx);
    pti_output_little32(&o, (uint32_t)grid->ny);
    pti_output_little32(&o, (uint32_t)grid->nz);
    pti_output_little32(&o, 1);
    pti_output_floats(&o, box, 6);
    pti_output_floats(&o, grid->values, n);
    return pti_output_end(&o);
}
#ifndef PT_NO_STDIO
PT_DEF pt_result pt_write_grid(const char *path, const pt_grid *grid) {
    pti_save s;
    pt_result r = pti_save_open(&s, path);
    return r != PT_OK ? r : pti_save_close(&s, pt_write_grid_to(&s.writer, grid));
}
PT_DEF pt_result pt_read_grid(pt_grid *out, const char *path) {
    pt_allocator a;
    pti_file f;
    pt_result r;
    if (!out || !path) return PT_ERR_ARG;
    pt_grid_free(out);
    out->error[0] = 0;
    a = pti_allocator_or_default(out->allocator);
    r = pti_file_read(&a, path, out->error, &f);
    if (r != PT_OK) return r;
    r = pti_read_grid(out, path, f.data, f.size);
    pti_file_free(&a, &f);
    return r;
}
#endif
PT_DEF void pt_grid_free(pt_grid *grid) {
    pt_allocator a;
    if (!grid) return;
    a = pti_allocator_or_default(grid->allocator);
    pti_free(&a, grid->values, pti_grid_count(grid), sizeof(float));
    grid->values = NULL;
    grid->nx = grid->ny = grid->nz = 0;
}

/* ---- >>mesh --------------------------------------------------------------------------------------------
   Meshes from files: Wavefront OBJ and its materials, MTL (the "Advanced Visualizer" manual's appendix B1; the format's own
   page), and PLY (Turk 1994). All is read into a soup of vertices and triangles: polygons are cut up on the way. */

typedef struct pti_list { void *items; size_t count, capacity, size; } pti_list;
typedef struct pti_float3 { float x[3]; } pti_float3;
typedef struct pti_float2 { float x[2]; } pti_float2;
typedef struct pti_soup_triangle { uint32_t i[3]; } pti_soup_triangle;
typedef struct pti_soup_point {                          /* a corner of the polygon at hand */
    uint32_t index, vertex;                              /* in the mesh; in the file, from 0 */
    uint32_t prev, next;
    int ear;
    double x, y;                                         /* in a plane */
} pti_soup_point;
typedef struct pti_soup {
    pti_input in;
    pt_allocator allocator;
    pt_result result;
    pti_list vertices, triangles, polygon;
} pti_soup;

static pti_list pti_list_of(size_t size) {
    pti_list l;
    l.items = NULL; l.count = l.capacity = 0; l.size = size;
    return l;
}
static pti_soup pti_soup_of(const pt_mesh *mesh, pti_input in) {
    pti_soup s;
    s.in = in;
    s.allocator = pti_allocator_or_default(mesh->allocator);
    s.result = PT_ERR_FORMAT;                            /* unless it turns out otherwise */
    s.vertices = pti_list_of(sizeof(pti_float3));
    s.triangles = pti_list_of(sizeof(pti_soup_triangle));
    s.polygon = pti_list_of(sizeof(pti_soup_point));
    return s;
}
static int pti_soup_memory(pti_soup *s) {
    s->result = pti_report(s->in.error, PT_ERR_MEMORY, s->in.name, "out of memory");
    return 0;
}
static void *pti_soup_add(pti_soup *s, pti_list *l) {  /* NULL: out of memory */
    if (!pti_grow(&s->allocator, &l->items, l->count, &l->capacity, l->size)) { pti_soup_memory(s); return NULL; }
    return (char *)l->items + l->size * l->count++;
}
static void pti_soup_drop(pti_soup *s, pti_list *l) { pti_free(&s->allocator, l->items, l->capacity, l->size); }

static int pti_soup_reserve(pti_soup *s, pti_list *l, size_t count) {
    if (!count) return 1;
    l->items = pti_alloc(&s->allocator, count, l->size);
    if (!l->items) return pti_soup_memory(s);
    l->capacity = count;
    return 1;
}

static int pti_soup_emit(pti_soup *s, uint32_t a, uint32_t b, uint32_t c) {
    const pti_soup_point *p = (const pti_soup_point *)s->polygon.items;
    pti_soup_triangle *t = (pti_soup_triangle *)pti_soup_add(s, &s->triangles);
    if (!t) return 0;
    t->i[0] = p[a].index;
    t->i[1] = p[b].index;
    t->i[2] = p[c].index;
    return 1;
}
static int pti_soup_fan(pti_soup *s, uint32_t n) {
    uint32_t i;
    for (i = 2; i < n; i++) if (!pti_soup_emit(s, 0, i - 1, i)) return 0;
    return 1;
}
/* Lays the polygon flat, counter-clockwise: along the axis that its normal is nearest to. Newell's normal, the sum of
   p_i x p_(i+1), is right for concave and for slightly bent polygons too. */
static void pti_soup_flatten(const pti_soup *s, pti_soup_point *p, uint32_t n) {
    const pti_float3 *v = (const pti_float3 *)s->vertices.items;
    double normal[3] = { 0, 0, 0 };
    uint32_t i, j;
    int k, axis = 0, x, y;
    for (j = n - 1, i = 0; i < n; j = i++) {
        const float *a = v[p[j].vertex].x, *b = v[p[i].vertex].x;
        for (k = 0; k < 3; k++) {
            x = (k + 1) % 3; y = (k + 2) % 3;
            normal[k] += ((double)a[x] - (double)b[x]) * ((double)a[y] + (double)b[y]);
        }
    }
    for (k = 1; k < 3; k++) if (normal[k] * normal[k] > normal[axis] * normal[axis]) axis = k;
    x = (axis + (normal[axis] < 0 ? 2 : 1)) % 3;
    y = 3 - axis - x;
    for (i = 0; i < n; i++) { p[i].x = (double)v[p[i].vertex].x[x]; p[i].y = (double)v[p[i].vertex].x[y]; }
}
/* Twice the area of a b c, positive when counter-clockwise. */
static double pti_soup_area(const pti_soup_point *a, const pti_soup_point *b, const pti_soup_point *c) {
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}
static int pti_soup_same(const pti_soup_point *a, const pti_soup_point *b) { return a->x == b->x && a->y == b->y; }
/* Can the corner i be cut off? It must be convex, and no other corner may lie in the triangle. (One that coincides with
   the triangle's own may: so holes are cut in, by a bridge that goes there and back.) */
static int pti_soup_is_ear(const pti_soup_point *p, uint32_t i) {
    const pti_soup_point *a = p + p[i].prev, *b = p + i, *c = p + p[i].next, *q;
    if (!(pti_soup_area(a, b, c) > 0)) return 0;
    for (q = p + c->next; q != a; q = p + q->next) {
        if (pti_soup_area(a, b, q) < 0 || pti_soup_area(b, c, q) < 0 || pti_soup_area(c, a, q) < 0) continue;
        if (!pti_soup_same(a, q) && !pti_soup_same(b, q) && !pti_soup_same(c, q)) return 0;
    }
    return 1;
}
/* Ear clipping (Meisters 1975; after each cut only the two neighbours are asked anew, so n^2 in all). Where there is no ear,
   in a polygon that crosses itself or has no area, any corner goes. */
static int pti_soup_clip(pti_soup *s, pti_soup_point *p, uint32_t n) {
    uint32_t i, tries;
    for (i = 0; i < n; i++) { p[i].prev = (i + n - 1) % n; p[i].next = (i + 1) % n; }
    for (i = 0; i < n; i++) p[i].ear = pti_soup_is_ear(p, i);
    for (i = 0; n > 3; n--) {
        for (tries = 0; tries < n && !p[i].ear; tries++) i = p[i].next;
        if (!pti_soup_emit(s, p[i].prev, i, p[i].next)) return 0;
        p[p[i].prev].next = p[i].next;
        p[p[i].next].prev = p[i].prev;
        p[p[i].prev].ear = pti_soup_is_ear(p, p[i].prev);
        p[p[i].next].ear = pti_soup_is_ear(p, p[i].next);
        i = p[p[i].next].next;                           /* not the neighbour: that makes slivers */
    }
    return pti_soup_emit(s, p[i].prev, i, p[i].next);
}
/* A fan from corner 0 is right for convex polygons, and for all others that can be seen whole from there. */
static int pti_soup_triangulate(pti_soup *s) {
    pti_soup_point *p = (pti_soup_point *)s->polygon.items;
    uint32_t n = (uint32_t)s->polygon.count, i;
    if (n == 3 || n > 1024) return pti_soup_fan(s, n);
    pti_soup_flatten(s, p, n);
    for (i = 2; i < n; i++) if (pti_soup_area(p, p + i - 1, p + i) < 0) return pti_soup_clip(s, p, n);
    return pti_soup_fan(s, n);
}

/* The arrays of the mesh have just the size that its counts tell, since that is how they are freed: here those of a list,
   with room for others after its own. */
static void *pti_soup_take(pti_soup *s, pti_list *l, size_t others) {
    size_t count = l->count + others;
    void *p = l->items;
    if (count != l->capacity) {
        p = pti_alloc(&s->allocator, count, l->size);
        if (!p) { pti_soup_memory(s); return NULL; }
        memcpy(p, l->items, l->count * l->size);
        pti_soup_drop(s, l);
    }
    l->items = NULL;                                     /* the count stays: it is still asked */
    return p;
}
static void pti_soup_free(pti_soup *s) {
    pti_soup_drop(s, &s->vertices);
    pti_soup_drop(s, &s->triangles);
    pti_soup_drop(s, &s->polygon);
}

static void pti_string_free(const pt_allocator *a, const char *s) {
    if (s) pti_free(a, (void *)(uintptr_t)s, strlen(s) + 1, 1);
}
PT_DEF void pt_mesh_free(pt_mesh *mesh) {
    pt_allocator a;
    size_t i;
    int k;
    if (!mesh) return;
    a = pti_allocator_or_default(mesh->allocator);
    pti_free(&a, mesh->positions, mesh->vertex_count, 3 * sizeof(float));
    pti_free(&a, mesh->normals, mesh->vertex_count, 3 * sizeof(float));
    pti_free(&a, mesh->uvs, mesh->vertex_count, 2 * sizeof(float));
    pti_free(&a, mesh->indices, mesh->index_count / 3, 3 * sizeof(uint32_t));
    pti_free(&a, mesh->material_ids, mesh->index_count / 3, sizeof(uint32_t));
    for (i = 0; i < mesh->material_count; i++) {
        pti_string_free(&a, mesh->materials[i].name);
        for (k = 0; k < PT_MTL_MAPS; k++) pti_string_free(&a, mesh->materials[i].maps[k].file);
    }
    pti_free(&a, mesh->materials, mesh->material_count, sizeof(pt_mtl));
    mesh->positions = mesh->normals = mesh->uvs = NULL;
    mesh->indices = mesh->material_ids = NULL;
    mesh->materials = NULL;
    mesh->vertex_count = mesh->index_count = mesh->material_count = 0;
    mesh->lo = mesh->hi = pt_v3(0, 0, 0);
}
static void pti_mesh_warn(pt_mesh *mesh, const char *text) {    /* the first is kept */
    if (!mesh->warning[0]) memcpy(mesh->warning, text, sizeof mesh->warning);
}

typedef struct pti_obj_name { const uint8_t *at; size_t size; uint64_t line; uint32_t hash; } pti_obj_name;   /* in a text */

/* Text. A statement ends with its line; a backslash before the end takes the next line along. */
static int pti_is_line_end(int c) { return c == '\n' || c == '\r'; }
static void pti_obj_skip_line_end(pti_input *in) {       /* LF, CR LF, or CR alone */
    int c = *in->at++;
    if (c == '\r' && pti_peek(in) == '\n') in->at++;
    in->line++;
}
static void pti_obj_skip_blanks(pti_input *in) {
    for (;;) {
        const uint8_t *p = in->at;
        while (p < in->end && (*p == ' ' || *p == '\t')) p++;
        in->at = p;
        if (p == in->end || *p != '\\' || !(p + 1 == in->end || pti_is_line_end(p[1]))) return;
        in->at++;
        if (in->at < in->end) pti_obj_skip_line_end(in);
    }
}
static void pti_obj_skip_line(pti_input *in) {
    const uint8_t *p = in->at;
    while (p < in->end && !pti_is_line_end(*p)) p++;
    in->at = p;
    if (p < in->end) pti_obj_skip_line_end(in);
}
static int pti_obj_at_end(const pti_input *in) {         /* of a statement */
    return in->at == in->end || pti_is_line_end(*in->at) || *in->at == '#';
}
static int pti_obj_at_gap(const pti_input *in) {         /* between two words */
    return in->at == in->end || *in->at <= ' ' || *in->at == '\\' || *in->at == '#';
}
/* Is this statement the word? Then steps behind it. */
static int pti_obj_is(pti_input *in, const char *word, size_t n) {
    const uint8_t *start = in->at;
    if (pti_input_left(in) < n || memcmp(start, word, n)) return 0;
    in->at += n;
    if (pti_obj_at_gap(in)) return 1;
    in->at = start;
    return 0;
}
/* Refuses the word that starts at word: "... is not a number". */
static int pti_obj_refuse_word(const pti_input *from, const uint8_t *word, const char *what) {
    char shown[33];
    size_t n = 0;
    pti_input in = *from;
    in.at = word;
    for (; n < sizeof shown - 1 && !pti_obj_at_gap(&in); in.at++) shown[n++] = *in.at < 127 ? (char)*in.at : '?';
    shown[n] = 0;
    return pti_refuse(from, "\"%s\" %s", shown, what);
}
/* Up to n numbers; at least so many. What the statement has beyond them is skipped with its line. */
static int pti_obj_numbers(pti_input *in, const char *statement, float *x, int least, int n) {
    const double most = (double)FLT_MAX;
    double d;
    int i;
    for (i = 0; i < n; i++) {
        const uint8_t *word;
        pti_obj_skip_blanks(in);
        word = in->at;
        if (pti_obj_at_end(in)) {
            if (i >= least) break;
            return pti_refuse(in, "%s has %d numbers, but needs %d", statement, i, least);
        }
        if (!pti_parse_number(in, &d) || !pti_obj_at_gap(in)) return pti_obj_refuse_word(in, word, "is not a number");
        if (!(d >= -most && d <= most)) return pti_obj_refuse_word(in, word, "is too large for a float");
        x[i] = (float)d;
    }
    return 1;
}
static int pti_obj_begin_text(pti_input *in, const char *format) {
    const uint8_t *p = in->at;
    size_t n = pti_input_left(in);
    if (n >= 2 && ((p[0] == 0xff && p[1] == 0xfe) || (p[0] == 0xfe && p[1] == 0xff) || !p[0] || !p[1]))
        return pti_refuse(in, "this is UTF-16 text or no text at all: %s is ASCII or UTF-8", format);
    if (n >= 3 && p[0] == 0xef && p[1] == 0xbb && p[2] == 0xbf) in->at += 3;
    return 1;
}

/* MTL, the materials of an OBJ file. What was meant for Phong's highlights becomes a physical material so:
     Kd        color, taken as linear like all numbers; without one, white under a map_Kd, else black beside
               Ks, else grey
     Ks        a plastic: specular = 2 luminance(Ks), at most 1, since the usual 0.5 goes with an index of 1.5. No Ks, or
               illum 0 or 1: PT_BSDF_DIFFUSE
     mirrors   with illum 3, 5 or 8 (which trace reflections), with no Kd at all, or with a Ks above 0.5 beside a black one:
               color = Kd + Ks, and metallic = the share of Ks in its luminance, so that both keep their albedo
     Ns        roughness = sqrt(alpha), alpha^2 = 2 / (Ns + 2), the lobe as wide as Phong's (Walter et al. 2007); from 1000
               on, the end of the scale, smooth. Without one 0.3, and 0 for a mirror
     Ni        ior, if above 1: many programs write 1 on everything
     d, 1 - Tr glass, if Ni is above 1 and light is refracted: by illum 4, 6, 7 or 9 and a Tf not black, or by a Tf not black
               and a d below 1. Then transmission = 1 - d (all, if d is 1), color = Tf, else Kd, else white; and smooth,
               unless there is a Pr. Otherwise transparency = 1 - d
     Ke        emission
     Pr Pm Ps Pc Pcr aniso anisor
               roughness (without one by Ns, else 0.5), metallic, sheen, coat, coat_roughness; alpha divided and multiplied by
               sqrt(1 - 0.9 aniso) along and across the tangent (Burley 2012), which anisor turns, 1 = 360 degrees. Where any
               of them is, Ks is no mirror
     map_*     multiply what they belong to, and stand alone where that is not given. map_Ns and map_Tr are turned over, 1 -
               value. -bm: bump = 0.01 m of it
   Ka, sharpness, disp, decal and refl are ignored, and so are the options -blendu -blendv -boost -cc -t -texres -type. */

typedef enum pti_mtl_key {
    PTI_MTL_KD, PTI_MTL_KS, PTI_MTL_KE, PTI_MTL_TF, PTI_MTL_NS, PTI_MTL_NI, PTI_MTL_D, PTI_MTL_TR, PTI_MTL_ILLUM,
    PTI_MTL_PR, PTI_MTL_PM, PTI_MTL_PS, PTI_MTL_PC, PTI_MTL_PCR, PTI_MTL_ANISO, PTI_MTL_ANISOR, PTI_MTL_KEYS
} pti_mtl_key;
typedef struct pti_mtl {
    pti_input in;
    const char *path;                                    /* of the MTL file, or NULL */
    pt_allocator allocator;
    pt_mesh *mesh;
    pt_mtl *material;                                    /* at hand; NULL = one that the mesh does not use */
    unsigned has;                                        /* bits by key */
    int pbr, out_of_memory;
    pt_vec3 value[PTI_MTL_KEYS];
} pti_mtl;

/* Upper and lower case are the same: programs differ. */
static int pti_mtl_is(pti_input *in, const char *word) {
    const uint8_t *start = in->at;
    for (; *word && in->at < in->end; word++, in->at++) {
        int c = *in->at, w = (unsigned char)*word;
        if (c >= 'A' && c <= 'Z') c += 'a' - 'A';
        if (w >= 'A' && w <= 'Z') w += 'a' - 'A';
        if (c != w) break;
    }
    if (!*word && pti_obj_at_gap(in)) return 1;
    in->at = start;
    return 0;
}
/* The rest of a line, blanks inside and all, but not those around, or quotes. It may end with a comment where that can not
   be part of it: "Material #25" is a name. */
static pti_obj_name pti_obj_rest(const pti_input *in, int comments) {
    pti_obj_name n;
    const uint8_t *p = in->at, *end;
    size_t i;
    while (p < in->end && (*p == ' ' || *p == '\t')) p++;
    for (end = p; end < in->end && !pti_is_line_end(*end); end++)
        if (comments && *end == '#' && (end == p || end[-1] == ' ' || end[-1] == '\t')) break;
    while (end > p && (end[-1] <= ' ')) end--;
    if (end - p >= 2 && *p == '"' && end[-1] == '"') { p++; end--; }
    n.at = p;
    n.size = (size_t)(end - p);
    n.line = in->line;
    n.hash = 2166136261u;                                /* FNV-1a */
    for (i = 0; i < n.size; i++) n.hash = (n.hash ^ p[i]) * 16777619u;
    return n;
}
static char *pti_string_of(const pt_allocator *a, const uint8_t *at, size_t size) {    /* NULL: out of memory */
    char *s;
    size_t n = 0;
    while (n < size && at[n]) n++;                       /* it ends at a zero */
    s = (char *)pti_alloc(a, n + 1, 1);
    if (s && n) memcpy(s, at, n);
    return s;
}
/* folder of beside (or nothing) + name, with slashes that every system takes. NULL: out of memory. */
static const char *pti_path_join(const pt_allocator *a, const char *beside, const uint8_t *name, size_t size) {
    size_t n = 0, i;
    int absolute = size && (name[0] == '/' || name[0] == '\\' || (size > 1 && name[1] == ':'));
    char *path;
    for (i = 0; beside && !absolute && beside[i]; i++) if (beside[i] == '/' || beside[i] == '\\') n = i + 1;
    for (i = 0; i < size && name[i]; i++) {}
    size = i;                                            /* a path ends at a zero */
    path = (char *)pti_alloc(a, n + size + 1, 1);
    if (!path) return NULL;
    if (n) memcpy(path, beside, n);
    for (i = 0; i < size; i++) path[n + i] = name[i] == '\\' ? '/' : (char)name[i];
    return path;
}

static int pti_mtl_has(const pti_mtl *t, pti_mtl_key k) { return t->has >> k & 1; }
static float pti_mtl_number(const pti_mtl *t, pti_mtl_key k, float otherwise) {
    return pti_mtl_has(t, k) ? t->value[k].x : otherwise;
}
static pt_vec3 pti_mtl_color(const pti_mtl *t, pti_mtl_key k, float otherwise) {
    pt_vec3 white = pt_v3(1, 1, 1), c = pt_v3(otherwise, otherwise, otherwise);
    return pti_max3(pti_min3(pti_mtl_has(t, k) ? t->value[k] : c, white), pt_v3(0, 0, 0));
}
static float pti_mtl_share(const pti_mtl *t, pti_mtl_key k, float otherwise) {
    return pti_clamp(pti_mtl_number(t, k, otherwise), 0, 1);
}
static float pti_mtl_roughness(const pti_mtl *t, float otherwise) {
    float ns = pti_max(pti_mtl_number(t, PTI_MTL_NS, 0), 0);
    if (pti_mtl_has(t, PTI_MTL_PR)) return pti_mtl_share(t, PTI_MTL_PR, 0);
    if (t->material->maps[PT_MTL_ROUGHNESS].file) return 0;
    if (!pti_mtl_has(t, PTI_MTL_NS)) return otherwise;
    return ns < 1000 ? sqrtf(sqrtf(2 / (ns + 2))) : 0.0f;
}
static void pti_mtl_physical(const pti_mtl *t, pt_material_desc *d) {
    float aniso = pti_mtl_share(t, PTI_MTL_ANISO, 0), aspect;
    d->bsdf = PT_BSDF_PRINCIPLED;
    d->roughness = pti_mtl_roughness(t, 0.5f);
    d->metallic = pti_mtl_share(t, PTI_MTL_PM, 0);
    d->sheen = pti_mtl_share(t, PTI_MTL_PS, t->material->maps[PT_MTL_SHEEN].file ? 1.0f : 0.0f);
    d->coat = pti_mtl_share(t, PTI_MTL_PC, 0);
    d->coat_roughness = pti_mtl_share(t, PTI_MTL_PCR, 0);
    if (!(aniso > 0)) return;
    aspect = sqrtf(sqrtf(1 - 0.9f * aniso));             /* of roughness, the root of alpha */
    d->roughness_y = d->roughness * aspect;
    d->roughness = pti_min(d->roughness / aspect, 1);
    d->rotation_deg = 360 * pti_mtl_share(t, PTI_MTL_ANISOR, 0);
}
static int pti_mtl_mirrors(const pti_mtl *t, pt_vec3 kd, pt_vec3 ks, int illum) {
    if (pti_is_zero3(ks)) return 0;
    return illum == 3 || illum == 5 || illum == 8 || (!pti_mtl_has(t, PTI_MTL_KD) && !t->material->maps[PT_MTL_COLOR].file)
        || (pti_is_zero3(kd) && !t->material->maps[PT_MTL_COLOR].file && pti_largest_abs(ks) > 0.5f);
}
static void pti_mtl_mirror(const pti_mtl *t, pt_material_desc *d, pt_vec3 kd, pt_vec3 ks) {
    pt_mtl_map *maps = t->material->maps;
    pt_vec3 sum = pti_add(kd, ks);
    d->bsdf = PT_BSDF_PRINCIPLED;
    d->color = pti_scale(sum, 1 / pti_max(pti_largest_abs(sum), 1));
    d->metallic = pti_min(pti_luminance(ks) / pti_luminance(sum), 1);
    d->roughness = pti_mtl_roughness(t, 0);
    if (maps[PT_MTL_COLOR].file || !maps[PT_MTL_SPECULAR].file) return;
    maps[PT_MTL_COLOR] = maps[PT_MTL_SPECULAR];          /* of a metal, map_Ks is the color */
    maps[PT_MTL_SPECULAR].file = NULL;
}
static void pti_mtl_see_through(const pti_mtl *t, pt_material_desc *d, pt_vec3 kd, int illum) {
    float opaque = pti_mtl_share(t, PTI_MTL_D, 1 - pti_mtl_share(t, PTI_MTL_TR, 0));
    pt_vec3 tf = pti_mtl_color(t, PTI_MTL_TF, 1);
    int traced = illum == 4 || illum == 6 || illum == 7 || illum == 9;
    if (pti_is_zero3(tf) || !(d->ior > 1) || !(traced || (pti_mtl_has(t, PTI_MTL_TF) && opaque < 1))) {
        d->transparency = opaque > 0 || !t->material->maps[PT_MTL_OPACITY].file ? 1 - opaque : 0.0f;
        return;
    }
    d->bsdf = PT_BSDF_PRINCIPLED;
    d->transmission = opaque < 1 ? 1 - opaque : 1.0f;
    d->metallic = d->specular = 0;
    d->color = pti_mtl_has(t, PTI_MTL_TF) ? tf : pti_is_zero3(kd) ? pt_v3(1, 1, 1) : kd;
    d->roughness = t->pbr ? d->roughness : 0.0f;
}
/* What the statements since newmtl say, as a material. */
static void pti_mtl_finish(pti_mtl *t) {
    pt_material_desc *d;
    pt_vec3 kd, ks = pti_mtl_color(t, PTI_MTL_KS, 0), zero = pt_v3(0, 0, 0), bright = pt_v3(1e12f, 1e12f, 1e12f);
    int illum = (int)pti_clamp(pti_mtl_number(t, PTI_MTL_ILLUM, 2), 0, 10);
    if (!t->material) return;
    d = &t->material->desc;
    if (illum < 2) ks = zero;
    kd = pti_mtl_color(t, PTI_MTL_KD, t->material->maps[PT_MTL_COLOR].file ? 1.0f : pti_is_zero3(ks) ? 0.5f : 0.0f);
    d->color = kd;
    d->emission = pti_max3(pti_min3(pti_mtl_has(t, PTI_MTL_KE) ? t->value[PTI_MTL_KE] : zero, bright), zero);
    d->ior = pti_mtl_number(t, PTI_MTL_NI, 0) > 1 ? pti_min(t->value[PTI_MTL_NI].x, 10) : 0.0f;
    if (t->pbr) pti_mtl_physical(t, d);
    else if (pti_mtl_mirrors(t, kd, ks, illum)) pti_mtl_mirror(t, d, kd, ks);
    else if (!pti_is_zero3(ks) || (illum >= 2 && !pti_mtl_has(t, PTI_MTL_KS) && t->material->maps[PT_MTL_SPECULAR].file)) {
        d->bsdf = PT_BSDF_PRINCIPLED;
        d->roughness = pti_mtl_roughness(t, 0.3f);
        d->specular = pti_min(2 * pti_luminance(ks), 1);
    }
    pti_mtl_see_through(t, d, kd, illum);
    t->material = NULL;
}

static int pti_mtl_new(pti_mtl *t) {
    pti_obj_name n = pti_obj_rest(&t->in, 0);
    size_t i;
    pti_mtl_finish(t);
    t->has = 0;
    t->pbr = 0;
    for (i = 0; i < t->mesh->material_count; i++) {
        pt_mtl *m = t->mesh->materials + i;
        if (strlen(m->name) != n.size || memcmp(m->name, n.at, n.size) || m->defined) continue;     /* the first holds */
        m->defined = 1;
        t->material = m;
        break;
    }
    return 1;
}
static int pti_mtl_channel(int c) {
    switch (c) {
    case 'r': return 1;
    case 'g': return 2;
    case 'b': return 3;
    case 'm': return 4;
    default:  return 0;                                  /* l, luminance, and z, depth */
    }
}
/* Up to three numbers: fewer where a word is no number, which then is the name of the file. */
static int pti_mtl_option_numbers(pti_input *in, float *x, int most) {
    int n = 0;
    double d;
    for (; n < most; n++) {
        const uint8_t *word;
        pti_obj_skip_blanks(in);
        word = in->at;
        if (!pti_parse_number(in, &d) || !pti_obj_at_gap(in) || !(d >= -1e6 && d <= 1e6)) { in->at = word; break; }
        x[n] = (float)d;
    }
    return n;
}
static void pti_mtl_skip_word(pti_input *in) {
    pti_obj_skip_blanks(in);
    while (!pti_obj_at_gap(in)) in->at++;
}
static int pti_mtl_option(pti_mtl *t, pt_mtl_map *map, pt_material_desc *d) {      /* 0: no option any more */
    static const char *const skipped[] = { "-blendu", "-blendv", "-boost", "-cc", "-texres", "-type" };
    pti_input *in = &t->in;
    float x[3] = { 0, 0, 0 };
    size_t i;
    if (pti_mtl_is(in, "-s")) {
        int n = pti_mtl_option_numbers(in, x, 3);
        if (n > 0) map->uv_scale[0] = x[0];
        if (n > 1) map->uv_scale[1] = x[1];
    } else if (pti_mtl_is(in, "-o")) {
        pti_mtl_option_numbers(in, x, 3);
        map->uv_offset[0] = x[0]; map->uv_offset[1] = x[1];
    } else if (pti_mtl_is(in, "-t")) pti_mtl_option_numbers(in, x, 3);        /* turbulence */
    else if (pti_mtl_is(in, "-mm")) {
        int n = pti_mtl_option_numbers(in, x, 2);
        if (n > 0) map->base = x[0];
        if (n > 1) map->gain = x[1];
    } else if (pti_mtl_is(in, "-bm")) {
        if (!pti_mtl_option_numbers(in, x, 1) || map != t->material->maps + PT_MTL_BUMP) return 1;
        d->bump = x[0] != 0 ? 0.01f * x[0] : 1e-9f;      /* 0 would be the default */
    } else if (pti_mtl_is(in, "-clamp")) {
        pti_obj_skip_blanks(in);
        map->clamp = pti_mtl_is(in, "on");
        if (!map->clamp) pti_mtl_skip_word(in);
    } else if (pti_mtl_is(in, "-imfchan")) {
        pti_obj_skip_blanks(in);
        map->channel = pti_mtl_channel(pti_peek(in));
        pti_mtl_skip_word(in);
    } else {
        for (i = 0; i < sizeof skipped / sizeof skipped[0]; i++)
            if (pti_mtl_is(in, skipped[i])) { pti_mtl_skip_word(in); return 1; }
        return 0;
    }
    return 1;
}
static int pti_mtl_read_map(pti_mtl *t, int use, int srgb, int turned) {
    pt_mtl_map map, *m;
    pti_obj_name n;
    if (!t->material) return 1;
    m = t->material->maps + use;
    map = *m;
    memset(m, 0, sizeof *m);
    m->uv_scale[0] = m->uv_scale[1] = 1;
    m->gain = 1;
    m->srgb = srgb;
    do pti_obj_skip_blanks(&t->in); while (pti_mtl_option(t, m, &t->material->desc));
    if (turned) { m->base = 1 - m->base; m->gain = -m->gain; }
    m->uv_offset[1] = 1 - m->uv_scale[1] - m->uv_offset[1];      /* in MTL, v' = scale v + offset, from the bottom */
    n = pti_obj_rest(&t->in, 1);
    if (n.size) m->file = pti_path_join(&t->allocator, t->path, n.at, n.size);
    if (n.size && m->file) { pti_string_free(&t->allocator, map.file); return 1; }
    *m = map;
    t->out_of_memory = n.size != 0;
    return n.size ? 0 : pti_refuse(&t->in, "a map without a file");
}
static int pti_mtl_read_numbers(pti_mtl *t, pti_mtl_key key, const char *word) {
    int color = key <= PTI_MTL_TF;
    float x[3];
    pti_obj_skip_blanks(&t->in);
    if (key == PTI_MTL_D) (void)pti_mtl_is(&t->in, "-halo");     /* less where it is seen from the side: not here */
    if (!pti_obj_numbers(&t->in, word, x, 1, 1)) return 0;
    x[1] = x[2] = x[0];                                  /* r alone: grey */
    pti_obj_skip_blanks(&t->in);
    if (color && !pti_obj_at_end(&t->in) && !pti_obj_numbers(&t->in, word, x + 1, 2, 2)) return 0;
    t->value[key] = pt_v3(x[0], x[1], x[2]);
    t->has |= 1u << key;
    t->pbr |= key >= PTI_MTL_PR;
    return 1;
}
static int pti_mtl_read_statement(pti_mtl *t) {          /* 0: refused, in words, or out of memory */
    static const char *const keys[PTI_MTL_KEYS] = { "Kd", "Ks", "Ke", "Tf", "Ns", "Ni", "d", "Tr", "illum",
        "Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor" };
    static const struct { const char *word; int use, srgb, turned, pbr; } maps[] = {
        { "map_Kd", PT_MTL_COLOR, 1, 0, 0 }, { "map_Ks", PT_MTL_SPECULAR, 1, 0, 0 }, { "map_Ke", PT_MTL_EMISSION, 1, 0, 0 },
        { "map_d", PT_MTL_OPACITY, 0, 0, 0 }, { "map_Tr", PT_MTL_OPACITY, 0, 1, 0 },
        { "map_Ns", PT_MTL_ROUGHNESS, 0, 1, 0 }, { "map_Pr", PT_MTL_ROUGHNESS, 0, 0, 1 },
        { "map_Pm", PT_MTL_METALLIC, 0, 0, 1 }, { "map_Ps", PT_MTL_SHEEN, 0, 0, 1 },
        { "map_bump", PT_MTL_BUMP, 0, 0, 0 }, { "bump", PT_MTL_BUMP, 0, 0, 0 }, { "norm", PT_MTL_NORMAL, 0, 0, 0 },
        { "map_Kn", PT_MTL_NORMAL, 0, 0, 0 } };
    size_t i;
    pti_obj_skip_blanks(&t->in);
    if (pti_obj_at_end(&t->in)) return 1;
    if (pti_mtl_is(&t->in, "newmtl")) return pti_mtl_new(t);
    for (i = 0; i < PTI_MTL_KEYS; i++)
        if (pti_mtl_is(&t->in, keys[i])) return pti_mtl_read_numbers(t, (pti_mtl_key)i, keys[i]);
    for (i = 0; i < sizeof maps / sizeof maps[0]; i++) {
        if (!pti_mtl_is(&t->in, maps[i].word)) continue;
        if (maps[i].turned && t->material && t->material->maps[maps[i].use].file) return 1;
        t->pbr |= maps[i].pbr;
        return pti_mtl_read_map(t, maps[i].use, maps[i].srgb, maps[i].turned);
    }
    return 1;
}
/* Fills in the mesh's materials that it defines. What is malformed is skipped with its line, and warned of. */
static pt_result pti_mtl_read(pt_mesh *mesh, const char *name, const char *path, const void *data, size_t size) {
    char refused[256] = { 0 };
    pti_mtl t;
    memset(&t, 0, sizeof t);
    t.in = pti_input_of(name, data, size, refused);
    t.path = path;
    t.allocator = pti_allocator_or_default(mesh->allocator);
    t.mesh = mesh;
    if (!pti_obj_begin_text(&t.in, "MTL")) { pti_mesh_warn(mesh, refused); return PT_OK; }
    while (t.in.at < t.in.end && !t.out_of_memory) {
        if (!pti_mtl_read_statement(&t)) pti_mesh_warn(mesh, refused);
        pti_obj_skip_line(&t.in);
    }
    pti_mtl_finish(&t);
    return t.out_of_memory ? pti_report(mesh->error, PT_ERR_MEMORY, name, "out of memory") : PT_OK;
}
PT_DEF pt_result pt_read_mtl_memory(pt_mesh *mesh, const void *data, size_t size) {
    pti_fpmode mode;
    pt_result r;
    if (!mesh || (!data && size)) return PT_ERR_ARG;
    mode = pti_fpmode_enter();
    r = pti_mtl_read(mesh, "memory", NULL, data, size);
    pti_fpmode_leave(mode);
    return r;
}
PT_DEF pt_texture *pt_mtl_texture(pt_mtl *m, int map) {
    pt_material_desc *d;
    if (!m) return NULL;
    d = &m->desc;
    switch (map) {
    case PT_MTL_COLOR:     return &d->color_texture;
    case PT_MTL_SPECULAR:  return &d->specular_texture;
    case PT_MTL_ROUGHNESS: return &d->roughness_texture;
    case PT_MTL_METALLIC:  return &d->metallic_texture;
    case PT_MTL_SHEEN:     return &d->sheen_texture;
    case PT_MTL_EMISSION:  return &d->emission_texture;
    case PT_MTL_OPACITY:   return &d->opacity_texture;
    case PT_MTL_NORMAL:    return &d->normal_texture;
    case PT_MTL_BUMP:      return &d->bump_texture;
    default:               return NULL;
    }
}

/* Wavefront OBJ: v, vt, vn, f, usemtl and mtllib; groups, lines and the rest are skipped. A corner of a face names three
   numbers, position, texture coordinate and normal, where a mesh has one index; so vertex i of the file becomes vertex i of
   the mesh, with the vt and vn that a face first gives it, and each other combination becomes one more vertex at the end. A
   glance at how the lines begin tells how many there are, so that the lists seldom grow, and mostly are the mesh's arrays in
   the end. */

#define PTI_OBJ_UNUSED UINT32_MAX
typedef struct pti_obj_corner { uint32_t vertex, uv, normal; } pti_obj_corner;        /* from 1; 0 = none */
typedef struct pti_obj_first { uint32_t uv, normal; } pti_obj_first;                  /* what a vertex was first seen with */
typedef struct pti_obj_run { size_t first; uint32_t name; } pti_obj_run;              /* triangles of one material */
typedef struct pti_obj {
    pti_soup soup;
    pti_list firsts, uvs, normals;
    pti_list more;                                       /* the further combinations, pti_obj_corner */
    pti_list names, libraries, runs;                     /* materials in use; mtllib lines; pti_obj_run */
    pti_obj_name material;                               /* of the faces that follow; at NULL: of the last run still */
    uint32_t *table;                                     /* finds them: open addressing, number + 1 */
    size_t table_size;                                   /* a power of two */
    int has_uv, has_normal;
} pti_obj;

/* Indices are 32 bits, and their last value has a meaning of its own. */
static int pti_obj_room(pti_obj *o, const pti_list *l, size_t others) {
    return l->count + others < UINT32_MAX - 1 ? 1 : pti_refuse(&o->soup.in, "more than 4294967294 vertices");
}
static int pti_obj_read_vertex(pti_obj *o) {
    pti_float3 *v;
    pti_obj_first *first;
    if (!pti_obj_room(o, &o->soup.vertices, o->more.count)) return 0;
    v = (pti_float3 *)pti_soup_add(&o->soup, &o->soup.vertices);
    first = (pti_obj_first *)pti_soup_add(&o->soup, &o->firsts);
    if (!v || !first) return 0;
    first->uv = PTI_OBJ_UNUSED;
    return pti_obj_numbers(&o->soup.in, "v", v->x, 3, 3);
}
static int pti_obj_read_uv(pti_obj *o) {
    pti_float2 *t;
    if (!pti_obj_room(o, &o->uvs, 0)) return 0;
    t = (pti_float2 *)pti_soup_add(&o->soup, &o->uvs);
    return t && pti_obj_numbers(&o->soup.in, "vt", t->x, 1, 2);    /* v is 0 where it is missing: memory comes zeroed */
}
static int pti_obj_read_normal(pti_obj *o) {
    pti_float3 *n;
    if (!pti_obj_room(o, &o->normals, 0)) return 0;
    n = (pti_float3 *)pti_soup_add(&o->soup, &o->normals);
    return n && pti_obj_numbers(&o->soup.in, "vn", n->x, 3, 3);
}

/* The number of the combination c among the further ones; it is added if it is new. */
static size_t pti_obj_slot(const pti_obj *o, const pti_obj_corner *c) {
    const pti_obj_corner *more = (const pti_obj_corner *)o->more.items;
    uint64_t h = ((uint64_t)c->vertex << 32 | c->uv) * 0x9e3779b97f4a7c15u;
    size_t slot;
    h = ((h ^ h >> 32) + c->normal) * 0xd6e8feb86659fd93u;
    slot = (size_t)(h ^ h >> 32) & (o->table_size - 1);
    while (o->table[slot] && memcmp(more + (o->table[slot] - 1), c, sizeof *c)) slot = (slot + 1) & (o->table_size - 1);
    return slot;
}
static int pti_obj_table_grow(pti_obj *o) {              /* at most half full */
    const pti_obj_corner *more = (const pti_obj_corner *)o->more.items;
    size_t bigger = o->table_size ? o->table_size * 2 : 64, i;
    uint32_t *table;
    if (o->more.count < o->table_size / 2) return 1;
    table = (uint32_t *)pti_alloc(&o->soup.allocator, bigger, sizeof *table);
    if (!table) return pti_soup_memory(&o->soup);
    pti_free(&o->soup.allocator, o->table, o->table_size, sizeof *table);
    o->table = table;
    o->table_size = bigger;
    for (i = 0; i < o->more.count; i++) table[pti_obj_slot(o, more + i)] = (uint32_t)(i + 1);
    return 1;
}
static int pti_obj_find(pti_obj *o, const pti_obj_corner *c, size_t *number) {
    pti_obj_corner *added;
    size_t slot;
    if (!pti_obj_table_grow(o)) return 0;
    slot = pti_obj_slot(o, c);
    if (!o->table[slot]) {
        if (!pti_obj_room(o, &o->more, o->soup.vertices.count)) return 0;
        added = (pti_obj_corner *)pti_soup_add(&o->soup, &o->more);
        if (!added) return 0;
        *added = *c;
        o->table[slot] = (uint32_t)o->more.count;
    }
    *number = o->table[slot] - 1;
    return 1;
}
/* The mesh's index for c. How many vertices the file has is not known yet, so the further combinations count from the top
   downwards: -1 - number. */
static int pti_obj_index(pti_obj *o, const pti_obj_corner *c, uint32_t *index) {
    pti_obj_first *first = (pti_obj_first *)o->firsts.items + (c->vertex - 1);
    size_t number;
    if (first->uv == PTI_OBJ_UNUSED) { first->uv = c->uv; first->normal = c->normal; }
    *index = c->vertex - 1;
    if (first->uv == c->uv && first->normal == c->normal) return 1;
    if (!pti_obj_find(o, c, &number)) return 0;
    *index = UINT32_MAX - (uint32_t)number;
    return 1;
}

/* An index: from 1, or from the end if negative; of what is there so far. */
static int pti_obj_read_index(pti_obj *o, const pti_list *l, const char *what, uint32_t *index) {
    pti_input *in = &o->soup.in;
    const uint8_t *p = in->at, *word;
    uint64_t n = 0;
    int negative = p < in->end && *p == '-';
    if (p < in->end && (*p == '-' || *p == '+')) p++;
    word = p;
    for (; p < in->end && pti_is_digit(*p); p++) if (n < 1000000000000u) n = n * 10 + (uint64_t)(*p - '0');
    if (p == word) return pti_obj_refuse_word(&o->soup.in, in->at, "is not an index");
    if (n == 0) return pti_refuse(in, "face refers to %s 0, but they count from 1", what);
    if (n > l->count)
        return pti_refuse(in, "face refers to %s %s%u, but there are %u so far", what, negative ? "-" : "", n,
                          (uint64_t)l->count);
    *index = negative ? (uint32_t)(l->count + 1 - n) : (uint32_t)n;
    in->at = p;
    return 1;
}
/* v, v/t, v//n, v/t/n. Nothing behind a slash is nothing: some programs write 1// */
static int pti_obj_read_part(pti_obj *o, const pti_list *l, const char *what, uint32_t *index) {
    if (pti_peek(&o->soup.in) != '/') return 1;
    o->soup.in.at++;
    return pti_peek(&o->soup.in) == '/' || pti_obj_at_gap(&o->soup.in) || pti_obj_read_index(o, l, what, index);
}
static int pti_obj_read_corner(pti_obj *o, pti_obj_corner *c) {
    pti_input *in = &o->soup.in;
    const uint8_t *word = in->at;
    c->uv = c->normal = 0;
    if (!pti_obj_read_index(o, &o->soup.vertices, "vertex", &c->vertex)) return 0;
    if (!pti_obj_read_part(o, &o->uvs, "texture coordinate", &c->uv)) return 0;
    if (!pti_obj_read_part(o, &o->normals, "normal", &c->normal)) return 0;
    o->has_uv |= c->uv != 0;
    o->has_normal |= c->normal != 0;
    return pti_obj_at_gap(in) ? 1 : pti_obj_refuse_word(&o->soup.in, word, "is not a corner: v, v/vt, v//vn or v/vt/vn");
}
/* The material that was named last is in use from here on. */
static int pti_obj_use_material(pti_obj *o) {
    const pti_obj_name *names = (const pti_obj_name *)o->names.items, *n = &o->material;
    pti_obj_name *added;
    pti_obj_run *run;
    size_t i;
    for (i = 0; i < o->names.count; i++)
        if (names[i].hash == n->hash && names[i].size == n->size && !memcmp(names[i].at, n->at, n->size)) break;
    if (i == o->names.count) {
        added = (pti_obj_name *)pti_soup_add(&o->soup, &o->names);
        if (!added) return 0;
        *added = *n;
    }
    run = (pti_obj_run *)pti_soup_add(&o->soup, &o->runs);
    if (!run) return 0;
    run->first = o->soup.triangles.count;
    run->name = (uint32_t)i;
    o->material.at = NULL;
    return 1;
}
static int pti_obj_add_library(pti_obj *o) {
    pti_obj_name *n = (pti_obj_name *)pti_soup_add(&o->soup, &o->libraries);
    if (n) *n = pti_obj_rest(&o->soup.in, 1);
    return n != NULL;
}
static int pti_obj_read_face(pti_obj *o) {
    pti_obj_corner c;
    pti_soup_point *p;
    if (o->material.at && !pti_obj_use_material(o)) return 0;
    o->soup.polygon.count = 0;
    for (;;) {
        pti_obj_skip_blanks(&o->soup.in);
        if (pti_obj_at_end(&o->soup.in)) break;
        if (!pti_obj_read_corner(o, &c)) return 0;
        p = (pti_soup_point *)pti_soup_add(&o->soup, &o->soup.polygon);
        if (!p || !pti_obj_index(o, &c, &p->index)) return 0;
        p->vertex = c.vertex - 1;
    }
    if (o->soup.polygon.count >= 3) return pti_soup_triangulate(&o->soup);
    return pti_refuse(&o->soup.in, "a face needs three corners, this has %u", (uint64_t)o->soup.polygon.count);
}

static int pti_obj_read_statement(pti_obj *o) {
    pti_input *in = &o->soup.in;
    int ok = 1;
    pti_obj_skip_blanks(in);
    switch (pti_peek(in)) {
    case 'v':
        if (pti_obj_is(in, "v", 1)) ok = pti_obj_read_vertex(o);
        else if (pti_obj_is(in, "vn", 2)) ok = pti_obj_read_normal(o);
        else if (pti_obj_is(in, "vt", 2)) ok = pti_obj_read_uv(o);
        break;
    case 'f':
        if (pti_obj_is(in, "f", 1)) ok = pti_obj_read_face(o);
        break;
    case 'u':
        if (pti_obj_is(in, "usemtl", 6)) o->material = pti_obj_rest(in, 0);
        break;
    case 'm':
        if (pti_obj_is(in, "mtllib", 6)) ok = pti_obj_add_library(o);
        break;
    default: break;
    }
    if (ok) pti_obj_skip_line(in);
    return ok;
}
/* Counts lines by how they begin, without a look at what they hold: a hint only. */
static int pti_obj_reserve(pti_obj *o) {
    const uint8_t *p = o->soup.in.at, *end = o->soup.in.end;
    size_t vertices = 0, uvs = 0, normals = 0, faces = 0;
    while (end - p > 1) {
        faces += *p == 'f';
        vertices += *p == 'v' && p[1] == ' ';
        uvs += *p == 'v' && p[1] == 't';
        normals += *p == 'v' && p[1] == 'n';
        p = (const uint8_t *)memchr(p, '\n', (size_t)(end - p));
        if (!p) break;
        p++;
    }
    return pti_soup_reserve(&o->soup, &o->soup.vertices, vertices) && pti_soup_reserve(&o->soup, &o->firsts, vertices)
        && pti_soup_reserve(&o->soup, &o->uvs, uvs) && pti_soup_reserve(&o->soup, &o->normals, normals)
        && pti_soup_reserve(&o->soup, &o->soup.triangles, faces);
}
static int pti_obj_read_text(pti_obj *o) {
    pti_input *in = &o->soup.in;
    if (!pti_obj_begin_text(in, "OBJ") || !pti_obj_reserve(o)) return 0;
    o->material.at = in->at;                             /* of faces before the first usemtl: "" */
    while (in->at < in->end) if (!pti_obj_read_statement(o)) return 0;
    return o->soup.triangles.count ? 1 : pti_refuse(in, "no faces");
}

static int pti_obj_give_positions(pti_obj *o, pt_mesh *mesh) {
    const pti_obj_corner *more = (const pti_obj_corner *)o->more.items;
    size_t n = o->soup.vertices.count, i;
    mesh->positions = (float *)pti_soup_take(&o->soup, &o->soup.vertices, o->more.count);
    mesh->vertex_count = n + o->more.count;
    if (!mesh->positions) return 0;
    for (i = n; i < mesh->vertex_count; i++)
        memcpy(mesh->positions + 3 * i, mesh->positions + 3 * (size_t)(more[i - n].vertex - 1), 3 * sizeof(float));
    return 1;
}
/* Texture coordinates and normals; where a vertex has none, they are 0. */
static int pti_obj_give_attributes(pti_obj *o, pt_mesh *mesh) {
    const pti_obj_first *first = (const pti_obj_first *)o->firsts.items;
    const pti_obj_corner *more = (const pti_obj_corner *)o->more.items;
    const pti_float2 *uvs = (const pti_float2 *)o->uvs.items;
    const pti_float3 *normals = (const pti_float3 *)o->normals.items;
    size_t n = mesh->vertex_count, i;
    if (o->has_uv) mesh->uvs = (float *)pti_alloc(&o->soup.allocator, n, sizeof *uvs);
    if (o->has_normal) mesh->normals = (float *)pti_alloc(&o->soup.allocator, n, sizeof *normals);
    if ((o->has_uv && !mesh->uvs) || (o->has_normal && !mesh->normals)) return pti_soup_memory(&o->soup);
    if (!o->has_uv && !o->has_normal) return 1;
    for (i = 0; i < n; i++) {
        size_t k = i - o->firsts.count;
        uint32_t uv = i < o->firsts.count ? first[i].uv : more[k].uv;
        uint32_t normal = i < o->firsts.count ? first[i].normal : more[k].normal;
        if (uv && uv != PTI_OBJ_UNUSED) memcpy(mesh->uvs + 2 * i, uvs + (uv - 1), sizeof *uvs);
        if (normal) memcpy(mesh->normals + 3 * i, normals + (normal - 1), sizeof *normals);
    }
    return 1;
}
static int pti_obj_give_indices(pti_obj *o, pt_mesh *mesh) {
    uint32_t n = (uint32_t)o->soup.vertices.count, *p = (uint32_t *)pti_soup_take(&o->soup, &o->soup.triangles, 0);
    size_t i;
    if (!p) return 0;
    mesh->indices = p;
    mesh->index_count = o->soup.triangles.count * 3;
    for (i = 0; i < mesh->index_count && o->more.count; i++) if (p[i] >= n) p[i] = n + (UINT32_MAX - p[i]);
    return 1;
}
static void pti_obj_give_bounds(const pti_obj *o, pt_mesh *mesh) {
    const pti_obj_first *first = (const pti_obj_first *)o->firsts.items;
    const float *p = mesh->positions;
    size_t i;
    mesh->lo = pt_v3(PTI_INF, PTI_INF, PTI_INF);
    mesh->hi = pti_neg(mesh->lo);
    for (i = 0; i < o->firsts.count; i++, p += 3) {
        if (first[i].uv == PTI_OBJ_UNUSED) continue;
        mesh->lo = pti_min3(mesh->lo, pt_v3(p[0], p[1], p[2]));
        mesh->hi = pti_max3(mesh->hi, pt_v3(p[0], p[1], p[2]));
    }
}

/* Grey, until a library says more. */
static int pti_obj_give_materials(pti_obj *o, pt_mesh *mesh) {
    const pti_obj_name *names = (const pti_obj_name *)o->names.items;
    const pti_obj_run *run = (const pti_obj_run *)o->runs.items;
    size_t i, r = 0, n = o->names.count;
    if (n == 1 && names[0].size == 0) return 1;
    mesh->materials = (pt_mtl *)pti_alloc(&o->soup.allocator, n, sizeof *mesh->materials);
    if (!mesh->materials) return pti_soup_memory(&o->soup);
    mesh->material_count = n;
    for (i = 0; i < n; i++) {
        mesh->materials[i].desc.color = pt_v3(0.5f, 0.5f, 0.5f);
        mesh->materials[i].name = pti_string_of(&o->soup.allocator, names[i].at, names[i].size);
        if (!mesh->materials[i].name) return pti_soup_memory(&o->soup);
    }
    if (n == 1) return 1;
    mesh->material_ids = (uint32_t *)pti_alloc(&o->soup.allocator, o->soup.triangles.count, sizeof *mesh->material_ids);
    if (!mesh->material_ids) return pti_soup_memory(&o->soup);
    for (i = 0; i < o->soup.triangles.count; i++) {
        while (r + 1 < o->runs.count && run[r + 1].first <= i) r++;
        mesh->material_ids[i] = run[r].name;
    }
    return 1;
}

#ifndef PT_NO_STDIO
static pt_result pti_mtl_open(const pti_obj *o, pt_mesh *mesh, const char *path, const uint8_t *name, size_t size) {
    const pt_allocator *a = &o->soup.allocator;
    const char *file = pti_path_join(a, path, name, size);
    char refused[256];
    pti_file f;
    pt_result r;
    if (!file) return pti_report(mesh->error, PT_ERR_MEMORY, path, "out of memory");
    r = pti_file_read(a, file, refused, &f);
    if (r == PT_OK) {
        r = pti_mtl_read(mesh, file, file, f.data, f.size);
        pti_file_free(a, &f);
    } else if (r == PT_ERR_MEMORY) pti_report(mesh->error, r, path, "out of memory");
    pti_string_free(a, file);
    return r;
}
/* As it is named; or, from somebody else's machine, beside the OBJ file without its folder. PT_ERR_IO: nowhere. */
static pt_result pti_mtl_find(const pti_obj *o, pt_mesh *mesh, const char *path, const uint8_t *name, size_t size) {
    pt_result r = pti_mtl_open(o, mesh, path, name, size);
    size_t i = size;
    while (i > 0 && name[i - 1] != '/' && name[i - 1] != '\\') i--;
    return r == PT_ERR_IO && i ? pti_mtl_open(o, mesh, path, name + i, size - i) : r;
}
static void pti_mtl_warn_missing(const pti_obj *o, pt_mesh *mesh, uint64_t line, const char *format, const uint8_t *name,
                                 size_t size) {
    char warning[256], shown[64];
    pti_input in = o->soup.in;
    size_t i;
    for (i = 0; i < size && i < sizeof shown - 1; i++) shown[i] = (char)name[i];
    shown[i] = 0;
    in.line = line;
    in.error = warning;
    pti_refuse(&in, format, shown);
    pti_mesh_warn(mesh, warning);
}
/* One name with blanks, or several names. */
static pt_result pti_obj_read_library(const pti_obj *o, pt_mesh *mesh, const char *path, const pti_obj_name *n) {
    pt_result r = pti_mtl_find(o, mesh, path, n->at, n->size);
    size_t begin, end;
    if (r != PT_ERR_IO) return r;
    for (begin = 0; begin < n->size; begin = end) {
        while (begin < n->size && n->at[begin] <= ' ') begin++;
        for (end = begin; end < n->size && n->at[end] > ' '; ) end++;
        if (end - begin < n->size) r = pti_mtl_find(o, mesh, path, n->at + begin, end - begin);
        if (r == PT_ERR_IO)
            pti_mtl_warn_missing(o, mesh, n->line, "cannot open %s: its materials are grey", n->at + begin, end - begin);
        else if (r != PT_OK) return r;
    }
    return PT_OK;
}
static pt_result pti_obj_read_libraries(const pti_obj *o, pt_mesh *mesh, const char *path) {
    const pti_obj_name *n = (const pti_obj_name *)o->libraries.items;
    size_t i;
    pt_result r = PT_OK;
    for (i = 0; i < o->libraries.count && r == PT_OK; i++) if (n[i].size) r = pti_obj_read_library(o, mesh, path, n + i);
    n = (const pti_obj_name *)o->names.items;
    for (i = 0; o->libraries.count && i < mesh->material_count; i++)
        if (!mesh->materials[i].defined && n[i].size)
            pti_mtl_warn_missing(o, mesh, n[i].line, "no library defines %s: it is grey", n[i].at, n[i].size);
    return r;
}
#endif

static void pti_obj_free(pti_obj *o) {
    pti_soup_free(&o->soup);
    pti_soup_drop(&o->soup, &o->firsts);
    pti_soup_drop(&o->soup, &o->uvs);
    pti_soup_drop(&o->soup, &o->normals);
    pti_soup_drop(&o->soup, &o->more);
    pti_soup_drop(&o->soup, &o->names);
    pti_soup_drop(&o->soup, &o->libraries);
    pti_soup_drop(&o->soup, &o->runs);
    pti_free(&o->soup.allocator, o->table, o->table_size, sizeof *o->table);
}
static pt_result pti_read_obj(pt_mesh *out, const char *path, pti_input in) {      /* path: NULL in memory */
    pti_obj o;
    memset(&o, 0, sizeof o);
    o.soup = pti_soup_of(out, in);
    o.firsts = pti_list_of(sizeof(pti_obj_first));
    o.uvs = pti_list_of(sizeof(pti_float2));
    o.normals = pti_list_of(sizeof(pti_float3));
    o.more = pti_list_of(sizeof(pti_obj_corner));
    o.names = o.libraries = pti_list_of(sizeof(pti_obj_name));
    o.runs = pti_list_of(sizeof(pti_obj_run));
    if (pti_obj_read_text(&o) && pti_obj_give_positions(&o, out) && pti_obj_give_attributes(&o, out)
        && pti_obj_give_indices(&o, out) && pti_obj_give_materials(&o, out)) {
        pti_obj_give_bounds(&o, out);
        o.soup.result = PT_OK;
#ifndef PT_NO_STDIO
        if (path) o.soup.result = pti_obj_read_libraries(&o, out, path);
#endif
    }
    (void)path;
    pti_obj_free(&o);
    return o.soup.result;
}

/* PLY (Turk, "The PLY Polygon File Format", 1994): a header in words, "element vertex 8", "property list uchar int
   vertex_indices", tells what the rows are made of, which follow as text, one a line, or as bytes in either order. Of
   vertices x y z, nx ny nz and s t (or u v, texture_u texture_v, texture_s texture_t) are used, of faces and tristrips the
   list vertex_indices (or vertex_index); all else is stepped over. */

typedef enum pti_ply_type {
    PTI_PLY_I8, PTI_PLY_U8, PTI_PLY_I16, PTI_PLY_U16, PTI_PLY_I32, PTI_PLY_U32, PTI_PLY_F32, PTI_PLY_F64, PTI_PLY_NONE
} pti_ply_type;
static const int pti_ply_size[8] = { 1, 1, 2, 2, 4, 4, 4, 8 };
typedef enum pti_ply_kind { PTI_PLY_OTHER, PTI_PLY_VERTEX, PTI_PLY_FACE, PTI_PLY_STRIP } pti_ply_kind;
typedef enum pti_ply_use { PTI_PLY_X, PTI_PLY_NX = 3, PTI_PLY_S = 6, PTI_PLY_INDICES = 8, PTI_PLY_UNUSED } pti_ply_use;
typedef struct pti_ply_property { int type, count_type, use; } pti_ply_property;      /* count_type: of a list, else NONE */
typedef struct pti_ply_element {
    pti_ply_kind kind;
    uint64_t count;
    size_t first, end;                                   /* its properties */
    unsigned has;                                        /* bits by use */
} pti_ply_element;
typedef struct pti_ply {
    pti_soup soup;
    pt_mesh *mesh;
    pti_list elements, properties;
    int binary, big_endian, crlf;
    float value[PTI_PLY_UNUSED];                         /* of the row at hand, by use */
} pti_ply;
#define PTI_PLY_HAS(first, n) (((1u << (n)) - 1) << (first))

/* The header. */
/* The next word, a long one cut. Its length, 0 at the end of the line. */
static size_t pti_ply_word(pti_input *in, char word[40]) {
    size_t n = 0, all = 0;
    while (in->at < in->end && (*in->at == ' ' || *in->at == '\t')) in->at++;
    for (; in->at < in->end && *in->at > ' '; in->at++, all++) if (n < 39) word[n++] = *in->at < 127 ? (char)*in->at : '?';
    word[n] = 0;
    return all;
}
static int pti_ply_type_of(const char *word) {
    static const char *const names[16] = { "char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16",
        "int", "int32", "uint", "uint32", "float", "float32", "double", "float64" };
    int i;
    for (i = 0; i < 16; i++) if (!strcmp(word, names[i])) return i / 2;
    return PTI_PLY_NONE;
}
static int pti_ply_use_of(pti_ply_kind kind, int is_list, const char *word) {
    static const struct { const char *word; int use; } names[] = { { "x", PTI_PLY_X }, { "y", PTI_PLY_X + 1 },
        { "z", PTI_PLY_X + 2 }, { "nx", PTI_PLY_NX }, { "ny", PTI_PLY_NX + 1 }, { "nz", PTI_PLY_NX + 2 }, { "s", PTI_PLY_S },
        { "t", PTI_PLY_S + 1 }, { "u", PTI_PLY_S }, { "v", PTI_PLY_S + 1 }, { "texture_u", PTI_PLY_S },
        { "texture_v", PTI_PLY_S + 1 }, { "texture_s", PTI_PLY_S }, { "texture_t", PTI_PLY_S + 1 } };
    int indices = !strcmp(word, "vertex_indices") || !strcmp(word, "vertex_index");
    size_t i;
    if (kind == PTI_PLY_FACE || kind == PTI_PLY_STRIP) return is_list && indices ? PTI_PLY_INDICES : PTI_PLY_UNUSED;
    if (kind == PTI_PLY_VERTEX && !is_list)
        for (i = 0; i < sizeof names / sizeof names[0]; i++) if (!strcmp(word, names[i].word)) return names[i].use;
    return PTI_PLY_UNUSED;
}
static int pti_ply_read_format(pti_ply *p) {
    char word[40];
    pti_ply_word(&p->soup.in, word);
    p->binary = strcmp(word, "ascii") != 0;
    p->big_endian = !strcmp(word, "binary_big_endian");
    if (!p->binary || p->big_endian || !strcmp(word, "binary_little_endian")) return 1;
    return pti_refuse(&p->soup.in, "\"%s\" is no format: ascii, binary_little_endian or binary_big_endian", word);
}
static int pti_ply_read_element(pti_ply *p) {
    pti_ply_element *e = (pti_ply_element *)pti_soup_add(&p->soup, &p->elements), *all;
    pti_input *in = &p->soup.in;
    char word[40];
    size_t i;
    if (!e) return 0;
    e->first = e->end = p->properties.count;
    pti_ply_word(in, word);
    e->kind = !strcmp(word, "vertex") ? PTI_PLY_VERTEX : !strcmp(word, "face") ? PTI_PLY_FACE
            : !strcmp(word, "tristrips") ? PTI_PLY_STRIP : PTI_PLY_OTHER;
    all = (pti_ply_element *)p->elements.items;
    for (i = 0; all + i < e; i++)
        if (e->kind != PTI_PLY_OTHER && all[i].kind == e->kind) return pti_refuse(in, "a second element %s", word);
    if (!pti_ply_word(in, word)) return pti_refuse(in, "an element without a count");
    for (i = 0; word[i]; i++) {
        if (!pti_is_digit((unsigned char)word[i]) || i > 17) return pti_refuse(in, "\"%s\" is no count", word);
        e->count = e->count * 10 + (uint64_t)(word[i] - '0');
    }
    return 1;
}
static int pti_ply_read_property(pti_ply *p) {
    pti_ply_property *q;
    pti_ply_element *e;
    pti_input *in = &p->soup.in;
    char word[40];
    if (!p->elements.count) return pti_refuse(in, "a property of no element");
    e = (pti_ply_element *)p->elements.items + (p->elements.count - 1);
    q = (pti_ply_property *)pti_soup_add(&p->soup, &p->properties);
    if (!q) return 0;
    e->end = p->properties.count;
    pti_ply_word(in, word);
    q->count_type = PTI_PLY_NONE;
    if (!strcmp(word, "list")) {
        pti_ply_word(in, word);
        q->count_type = pti_ply_type_of(word);
        if (q->count_type >= PTI_PLY_F32) return pti_refuse(in, "\"%s\" is no type of a list's count", word);
        pti_ply_word(in, word);
    }
    q->type = pti_ply_type_of(word);
    if (q->type == PTI_PLY_NONE) return pti_refuse(in, "\"%s\" is no type of a property", word);
    pti_ply_word(in, word);
    q->use = pti_ply_use_of(e->kind, q->count_type != PTI_PLY_NONE, word);
    if (q->use < PTI_PLY_UNUSED && e->has >> q->use & 1) q->use = PTI_PLY_UNUSED;      /* a second one */
    if (q->use < PTI_PLY_UNUSED) e->has |= 1u << q->use;
    return 1;
}
static int pti_ply_check_header(pti_ply *p, int has_format) {
    const pti_ply_element *e = (const pti_ply_element *)p->elements.items;
    size_t i;
    int vertices = 0, faces = 0;
    if (!has_format) return pti_refuse(&p->soup.in, "the header tells no format");
    for (i = 0; i < p->elements.count; i++) {
        vertices |= e[i].kind == PTI_PLY_VERTEX && (e[i].has & PTI_PLY_HAS(PTI_PLY_X, 3)) == PTI_PLY_HAS(PTI_PLY_X, 3);
        faces |= e[i].count > 0 && (e[i].has >> PTI_PLY_INDICES & 1);
    }
    if (!vertices) return pti_refuse(&p->soup.in, "no vertices with x, y and z");
    return faces ? 1 : pti_refuse(&p->soup.in, "no faces");
}
static int pti_ply_skip_unknown(pti_ply *p, const char *word) {  /* some programs forget the word comment */
    char warning[256];
    pti_input in = p->soup.in;
    in.error = warning;
    pti_refuse(&in, "\"%s\" is no word of a header: the line is skipped", word);
    pti_mesh_warn(p->mesh, warning);
    return 1;
}
static int pti_ply_read_header(pti_ply *p) {
    pti_input *in = &p->soup.in;
    char word[40];
    int ok = 1, format = 0;
    pti_ply_word(in, word);
    if (strcmp(word, "ply")) return pti_refuse(in, "\"%s\" is not ply", word);
    p->crlf = pti_input_left(in) > 1 && in->at[0] == '\r' && in->at[1] == '\n';
    while (ok) {
        pti_obj_skip_line(in);
        if (in->at == in->end) return pti_refuse(in, "the file ends within its header");
        if (!pti_ply_word(in, word) || !strcmp(word, "comment") || !strcmp(word, "obj_info")) continue;
        if (!strcmp(word, "end_header")) break;
        if (!strcmp(word, "format")) { ok = pti_ply_read_format(p); format = 1; }
        else if (!strcmp(word, "element")) ok = pti_ply_read_element(p);
        else if (!strcmp(word, "property")) ok = pti_ply_read_property(p);
        else ok = pti_ply_skip_unknown(p, word);
    }
    return ok && pti_ply_check_header(p, format);
}
/* Behind the header's last line: a CR alone ends it only where it ended the first, since what follows may be any byte. */
static void pti_ply_begin_rows(pti_ply *p) {
    pti_input *in = &p->soup.in;
    while (in->at < in->end && !pti_is_line_end(*in->at)) in->at++;
    if (!p->binary) { if (in->at < in->end) pti_obj_skip_line_end(in); return; }
    if (pti_peek(in) == '\r' && p->crlf) in->at++;
    if (in->at < in->end) in->at++;
    in->line = 0;
}

/* The rows. */
static const char *pti_ply_name(pti_ply_kind kind) {
    return kind == PTI_PLY_VERTEX ? "vertex" : kind == PTI_PLY_FACE ? "face" : kind == PTI_PLY_STRIP ? "strip" : "row";
}
static double pti_ply_number(const uint8_t *p, int type, int big_endian) {
    int n = pti_ply_size[type];
    uint64_t bits = pti_bits_of_bytes(p, n, big_endian);
    double d;
    switch (type) {
    case PTI_PLY_F32: return (double)pti_float_of_bytes(p, big_endian);
    case PTI_PLY_F64: memcpy(&d, &bits, sizeof d); return d;
    case PTI_PLY_I8: case PTI_PLY_I16: case PTI_PLY_I32:
        return (double)bits - (bits >> (8 * n - 1) ? (double)((uint64_t)1 << 8 * n) : 0);
    default: return (double)bits;
    }
}
static int pti_ply_read_scalar(pti_ply *p, int type, double *x) {
    pti_input *in = &p->soup.in;
    const uint8_t *word;
    if (p->binary) {
        if (pti_input_left(in) < (size_t)pti_ply_size[type]) return pti_refuse(in, "the file ends within a row");
        *x = pti_ply_number(in->at, type, p->big_endian);
        in->at += pti_ply_size[type];
        return 1;
    }
    while (in->at < in->end && (*in->at == ' ' || *in->at == '\t')) in->at++;
    word = in->at;
    if (in->at == in->end || pti_is_line_end(*in->at)) return pti_refuse(in, "the row ends too early");
    return pti_parse_number(in, x) && pti_obj_at_gap(in) ? 1 : pti_obj_refuse_word(in, word, "is not a number");
}
static int pti_ply_is_below(double x, double end) {      /* a whole number, from 0 */
    return x >= 0 && x < end && (double)(uint64_t)x == x;
}
static int pti_ply_read_list(pti_ply *p, const pti_ply_property *q) {     /* into the polygon, or nowhere */
    pti_input *in = &p->soup.in;
    size_t left = pti_input_left(in), least = p->binary ? (size_t)pti_ply_size[q->type] : 2, i, n;
    double count, x;
    if (!pti_ply_read_scalar(p, q->count_type, &count)) return 0;
    if (!pti_ply_is_below(count, (double)(left / least) + 1))
        return pti_refuse(in, "a list of %g does not fit into the file", count);
    n = (size_t)count;
    if (p->binary && q->use == PTI_PLY_UNUSED && pti_input_left(in) >= n * least) { in->at += n * least; return 1; }
    for (i = 0; i < n; i++) {
        pti_soup_point *point;
        if (!pti_ply_read_scalar(p, q->type, &x)) return 0;
        if (q->use == PTI_PLY_UNUSED) continue;
        point = (pti_soup_point *)pti_soup_add(&p->soup, &p->soup.polygon);
        if (!point) return 0;
        point->index = pti_ply_is_below(x, (double)p->soup.vertices.count) ? (uint32_t)x : UINT32_MAX;
        point->vertex = point->index;
        point->x = x;
    }
    return 1;
}
static int pti_ply_read_row(pti_ply *p, const pti_ply_element *e) {
    const pti_ply_property *q = (const pti_ply_property *)p->properties.items + e->first;
    const pti_ply_property *end = (const pti_ply_property *)p->properties.items + e->end;
    pti_input *in = &p->soup.in;
    double x;
    while (!p->binary && in->at < in->end && *in->at <= ' ') {
        if (pti_is_line_end(*in->at)) pti_obj_skip_line_end(in);
        else in->at++;
    }
    p->soup.polygon.count = 0;
    for (; q < end; q++) {
        if (q->count_type != PTI_PLY_NONE) {
            if (!pti_ply_read_list(p, q)) return 0;
            continue;
        }
        if (!pti_ply_read_scalar(p, q->type, &x)) return 0;
        if (q->use == PTI_PLY_UNUSED) continue;
        if (!(x >= -(double)FLT_MAX && x <= (double)FLT_MAX)) return pti_refuse(in, "%g is no number for a vertex", x);
        p->value[q->use] = (float)x;
    }
    if (!p->binary) while (in->at < in->end && !pti_is_line_end(*in->at)) in->at++;       /* what is too many on its line */
    return 1;
}
static int pti_ply_put_vertex(pti_ply *p, size_t i) {
    memcpy((pti_float3 *)p->soup.vertices.items + i, p->value + PTI_PLY_X, sizeof(pti_float3));
    if (p->mesh->normals) memcpy(p->mesh->normals + 3 * i, p->value + PTI_PLY_NX, sizeof(pti_float3));
    if (p->mesh->uvs) memcpy(p->mesh->uvs + 2 * i, p->value + PTI_PLY_S, sizeof(pti_float2));
    p->soup.vertices.count = i + 1;
    return 1;
}
static int pti_ply_refuse_index(const pti_ply *p, double x) {
    return pti_refuse(&p->soup.in, "a face refers to vertex %g, but there are %u, from 0", x,
                      (uint64_t)p->soup.vertices.count);
}
static int pti_ply_put_face(pti_ply *p) {
    const pti_soup_point *c = (const pti_soup_point *)p->soup.polygon.items;
    size_t i, n = p->soup.polygon.count;
    for (i = 0; i < n; i++) if (c[i].index == UINT32_MAX) return pti_ply_refuse_index(p, c[i].x);
    if (n < 3) return pti_refuse(&p->soup.in, "a face needs three corners, this has %u", (uint64_t)n);
    return pti_soup_triangulate(&p->soup);
}
/* Each three neighbours are a triangle, every other one the other way round; -1 begins anew. */
static int pti_ply_put_strip(pti_ply *p) {
    const pti_soup_point *c = (const pti_soup_point *)p->soup.polygon.items;
    uint32_t i, n = (uint32_t)p->soup.polygon.count, begin = 0;
    for (i = 0; i < n; i++) {
        uint32_t odd = (i - begin) % 2;
        if (c[i].index == UINT32_MAX) {
            if (c[i].x != -1) return pti_ply_refuse_index(p, c[i].x);
            begin = i + 1;
        } else if (i - begin >= 2 && !pti_soup_emit(&p->soup, i - 2 + odd, i - 1 - odd, i)) return 0;
    }
    return 1;
}
/* Do so many rows fit into what is left of the file, at their least? */
static int pti_ply_check_size(pti_ply *p, const pti_ply_element *e) {
    const pti_ply_property *q = (const pti_ply_property *)p->properties.items;
    size_t row = 0, i, left = pti_input_left(&p->soup.in);
    for (i = e->first; i < e->end; i++)
        row += p->binary ? (size_t)pti_ply_size[q[i].count_type != PTI_PLY_NONE ? q[i].count_type : q[i].type] : 2;
    if (e->count <= (left + !p->binary) / row && e->count < UINT32_MAX - 1) return 1;
    return pti_refuse(&p->soup.in, "element %s should have %u rows, but the file is too short", pti_ply_name(e->kind),
                      e->count);
}
static int pti_ply_reserve(pti_ply *p, const pti_ply_element *e) {
    pt_mesh *m = p->mesh;
    size_t n = (size_t)e->count;
    if (e->kind == PTI_PLY_FACE) return p->soup.triangles.capacity || pti_soup_reserve(&p->soup, &p->soup.triangles, n);
    if (e->kind != PTI_PLY_VERTEX) return 1;
    if (!pti_soup_reserve(&p->soup, &p->soup.vertices, n)) return 0;
    m->vertex_count = n;
    if ((e->has & PTI_PLY_HAS(PTI_PLY_NX, 3)) == PTI_PLY_HAS(PTI_PLY_NX, 3)) {
        m->normals = (float *)pti_alloc(&p->soup.allocator, n, sizeof(pti_float3));
        if (!m->normals) return pti_soup_memory(&p->soup);
    }
    if ((e->has & PTI_PLY_HAS(PTI_PLY_S, 2)) == PTI_PLY_HAS(PTI_PLY_S, 2)) {
        m->uvs = (float *)pti_alloc(&p->soup.allocator, n, sizeof(pti_float2));
        if (!m->uvs) return pti_soup_memory(&p->soup);
    }
    return 1;
}
static int pti_ply_read_rows(pti_ply *p, const pti_ply_element *e) {
    size_t i;
    int ok = 1;
    if (e->first == e->end) return 1;                    /* rows of nothing */
    if (!pti_ply_check_size(p, e) || !pti_ply_reserve(p, e)) return 0;
    for (i = 0; i < e->count && ok; i++) {
        ok = pti_ply_read_row(p, e);
        if (!ok) break;
        switch (e->kind) {
        case PTI_PLY_VERTEX: ok = pti_ply_put_vertex(p, i); break;
        case PTI_PLY_FACE:   ok = !(e->has >> PTI_PLY_INDICES & 1) || pti_ply_put_face(p); break;
        case PTI_PLY_STRIP:  ok = pti_ply_put_strip(p); break;
        case PTI_PLY_OTHER:  break;
        }
    }
    return ok;
}
static int pti_ply_read_body(pti_ply *p) {
    const pti_ply_element *e = (const pti_ply_element *)p->elements.items;
    size_t i;
    pti_ply_begin_rows(p);
    for (i = 0; i < p->elements.count; i++) if (!pti_ply_read_rows(p, e + i)) return 0;
    return p->soup.triangles.count ? 1 : pti_refuse(&p->soup.in, "no faces");
}
static int pti_ply_give(pti_ply *p) {
    pt_mesh *m = p->mesh;
    size_t i;
    m->lo = pt_v3(PTI_INF, PTI_INF, PTI_INF);
    m->hi = pti_neg(m->lo);
    m->positions = (float *)pti_soup_take(&p->soup, &p->soup.vertices, 0);
    if (!m->positions) return 0;
    m->indices = (uint32_t *)pti_soup_take(&p->soup, &p->soup.triangles, 0);
    if (!m->indices) return 0;
    m->index_count = 3 * p->soup.triangles.count;
    for (i = 0; i < m->index_count; i++) {
        m->lo = pti_min3(m->lo, pti_vec3_at(m->positions, m->indices[i]));
        m->hi = pti_max3(m->hi, pti_vec3_at(m->positions, m->indices[i]));
    }
    return 1;
}
static pt_result pti_read_ply(pt_mesh *out, const char *path, pti_input in) {
    pti_ply p;
    (void)path;
    memset(&p, 0, sizeof p);
    p.mesh = out;
    p.soup = pti_soup_of(out, in);
    p.elements = pti_list_of(sizeof(pti_ply_element));
    p.properties = pti_list_of(sizeof(pti_ply_property));
    if (pti_ply_read_header(&p) && pti_ply_read_body(&p) && pti_ply_give(&p)) p.soup.result = PT_OK;
    pti_soup_free(&p.soup);
    pti_soup_drop(&p.soup, &p.elements);
    pti_soup_drop(&p.soup, &p.properties);
    return p.soup.result;
}

/* The doors. */
typedef pt_result (*pti_mesh_reader)(pt_mesh *out, const char *path, pti_input in);
static pt_result pti_read_any_mesh(pt_mesh *out, const char *path, pti_input in) {
    int ply = pti_input_left(&in) >= 4 && !memcmp(in.at, "ply", 3) && in.at[3] <= ' ';
    return ply ? pti_read_ply(out, path, in) : pti_read_obj(out, path, in);
}
static pt_result pti_read_mesh(pti_mesh_reader reader, pt_mesh *out, const char *path, const void *data, size_t size) {
    pti_fpmode mode = pti_fpmode_enter();
    pt_result r = reader(out, path, pti_input_of(path ? path : "memory", data, size, out->error));
    if (r != PT_OK) pt_mesh_free(out);
    pti_fpmode_leave(mode);
    return r;
}
static pt_result pti_read_mesh_memory(pti_mesh_reader reader, pt_mesh *out, const void *data, size_t size) {
    if (!out || (!data && size)) return PT_ERR_ARG;
    pt_mesh_free(out);
    out->error[0] = out->warning[0] = 0;
    return pti_read_mesh(reader, out, NULL, data, size);
}
PT_DEF pt_result pt_read_obj_memory(pt_mesh *out, const void *data, size_t size) {
    return pti_read_mesh_memory(pti_read_obj, out, data, size);
}
PT_DEF pt_result pt_read_ply_memory(pt_mesh *out, const void *data, size_t size) {
    return pti_read_mesh_memory(pti_read_ply, out, data, size);
}
PT_DEF pt_result pt_read_mesh_memory(pt_mesh *out, const void *data, size_t size) {
    return pti_read_mesh_memory(pti_read_any_mesh, out, data, size);
}
#ifndef PT_NO_STDIO
static pt_result pti_read_mesh_file(pti_mesh_reader reader, pt_mesh *out, const char *path) {
    pt_allocator a;
    pti_file f;
    pt_result r;
    if (!out || !path) return PT_ERR_ARG;
    pt_mesh_free(out);
    out->error[0] = out->warning[0] = 0;
    a = pti_allocator_or_default(out->allocator);
    r = pti_file_read(&a, path, out->error, &f);
    if (r != PT_OK) return r;
    r = pti_read_mesh(reader, out, path, f.data, f.size);
    pti_file_free(&a, &f);
    return r;
}
PT_DEF pt_result pt_read_obj(pt_mesh *out, const char *path) { return pti_read_mesh_file(pti_read_obj, out, path); }
PT_DEF pt_result pt_read_ply(pt_mesh *out, const char *path) { return pti_read_mesh_file(pti_read_ply, out, path); }
PT_DEF pt_result pt_read_mesh(pt_mesh *out, const char *path) { return pti_read_mesh_file(pti_read_any_mesh, out, path); }
#endif

/* Smooth normals: n = sum of angle_i n_i over the triangles i that meet at a point, normalized (Thuermer and Wuethrich
   1998). Points are where positions are equal, whatever the other attributes. Of the corners that meet there, those hold
   together whose triangles share an edge that is not sharp, and each such group has a normal of its own. */
typedef struct pti_smooth_state {
    pt_mesh *mesh;
    pt_allocator allocator;
    size_t corners;                                      /* three a triangle */
    float cosine;                                        /* of the angle from which an edge is sharp */
    uint32_t *table;                                     /* open addressing, number + 1 */
    size_t table_size;                                   /* a power of two */
    uint32_t *point;                                     /* by vertex: the first one at its position */
    uint32_t *group;                                     /* by corner: another one of its group; the last is its own */
    pt_vec3 *face;                                       /* by triangle: unit normal, or zero */
    pt_vec3 *normal;                                     /* by corner: the sum, at the group's last one */
    uint32_t *first;                                     /* by vertex: the list of those that it becomes, from 1 */
    uint32_t *next, *owner, *origin;                     /* by new vertex, from 1: the list; its group + 1; what it was */
    uint32_t *index;                                     /* by corner, new */
    size_t count, most;                                  /* of new vertices */
} pti_smooth_state;

static size_t pti_smooth_hash(const pti_smooth_state *s, uint64_t a, uint64_t b) {
    uint64_t h = (a * 0x9e3779b97f4a7c15u ^ b) * 0xd6e8feb86659fd93u;
    return (size_t)(h ^ h >> 32) & (s->table_size - 1);
}
static void pti_smooth_find_points(pti_smooth_state *s) {
    const float *p = s->mesh->positions;
    size_t i, slot;
    memset(s->table, 0, s->table_size * sizeof *s->table);
    for (i = 0; i < s->mesh->vertex_count; i++) {
        float x[3];
        uint32_t bits[3];
        int k;
        for (k = 0; k < 3; k++) x[k] = p[3 * i + (size_t)k] + 0.0f;          /* -0 becomes 0 */
        memcpy(bits, x, sizeof bits);
        slot = pti_smooth_hash(s, (uint64_t)bits[0] << 32 | bits[1], bits[2]);
        for (; s->table[slot]; slot = (slot + 1) & (s->table_size - 1)) {
            const float *q = p + 3 * (size_t)(s->table[slot] - 1);
            if (q[0] == x[0] && q[1] == x[1] && q[2] == x[2]) break;
        }
        if (!s->table[slot]) s->table[slot] = (uint32_t)(i + 1);
        s->point[i] = s->table[slot] - 1;
    }
}
/* From one corner to another: unit, or zero where they are one; scaled first where a difference would be infinite. */
static pt_vec3 pti_smooth_side(const pti_smooth_state *s, size_t from, size_t to) {
    const uint32_t *index = s->mesh->indices;
    pt_vec3 a = pti_vec3_at(s->mesh->positions, index[from]), b = pti_vec3_at(s->mesh->positions, index[to]), d;
    float scale = pti_max(pti_largest_abs(a), pti_largest_abs(b)) > 1e30f ? 1e-10f : 1.0f;
    d = pti_sub(pti_scale(b, scale), pti_scale(a, scale));
    return pti_is_zero3(d) ? d : pti_normalize(d);
}
static void pti_smooth_find_faces(pti_smooth_state *s) {
    size_t i, c;
    for (i = 0; i < s->corners / 3; i++) {
        pt_vec3 a = pti_smooth_side(s, 3 * i, 3 * i + 1), b = pti_smooth_side(s, 3 * i, 3 * i + 2), n = pti_cross(a, b);
        s->face[i] = pti_is_zero3(n) ? n : pti_normalize(n);
    }
    for (c = 0; c < s->corners; c++) s->group[c] = (uint32_t)c;
}
static uint32_t pti_smooth_group(pti_smooth_state *s, uint32_t corner) {
    while (s->group[corner] != corner) {
        s->group[corner] = s->group[s->group[corner]];   /* halves the path */
        corner = s->group[corner];
    }
    return corner;
}
static void pti_smooth_join(pti_smooth_state *s, size_t a, size_t b) {
    uint32_t x = pti_smooth_group(s, (uint32_t)a), y = pti_smooth_group(s, (uint32_t)b);
    if (x < y) s->group[y] = x;
    else s->group[x] = y;
}
/* Corner c and the next of its triangle are an edge. Where more than two triangles share one, each is compared with the one
   before it. */
static void pti_smooth_edge(pti_smooth_state *s, size_t c) {
    size_t d = c % 3 == 2 ? c - 2 : c + 1, slot, e, f;
    const uint32_t *index = s->mesh->indices;
    uint32_t a = s->point[index[c]], b = s->point[index[d]], lo = a < b ? a : b, hi = a < b ? b : a;
    if (a == b || pti_is_zero3(s->face[c / 3])) return;
    slot = pti_smooth_hash(s, lo, hi);
    for (; s->table[slot]; slot = (slot + 1) & (s->table_size - 1)) {
        e = s->table[slot] - 1;
        f = e % 3 == 2 ? e - 2 : e + 1;
        if (s->point[index[e]] == a && s->point[index[f]] == b) { size_t t = e; e = f; f = t; break; }
        if (s->point[index[e]] == b && s->point[index[f]] == a) break;
    }
    if (s->table[slot]) {
        e = s->table[slot] - 1;
        f = e % 3 == 2 ? e - 2 : e + 1;
        if (pti_dot(s->face[c / 3], s->face[e / 3]) >= s->cosine) {
            int along = s->point[index[e]] == a;         /* both triangles in the same sense: one is turned over */
            pti_smooth_join(s, c, along ? e : f);
            pti_smooth_join(s, d, along ? f : e);
        }
    }
    s->table[slot] = (uint32_t)(c + 1);
}
static void pti_smooth_sum(pti_smooth_state *s) {
    size_t c, i, k;
    for (i = 0; i < s->corners; i += 3) {
        pt_vec3 side[3], n = s->face[i / 3];
        if (pti_is_zero3(n)) continue;
        for (k = 0; k < 3; k++) side[k] = pti_smooth_side(s, i + k, i + (k + 1) % 3);
        for (k = 0; k < 3; k++) {
            float angle = pti_acos(pti_clamp(-pti_dot(side[k], side[(k + 2) % 3]), -1, 1));
            uint32_t g = pti_smooth_group(s, (uint32_t)(i + k));
            s->normal[g] = pti_madd(n, angle, s->normal[g]);
        }
    }
    for (c = 0; c < s->corners; c++)
        if (!pti_is_zero3(s->normal[c])) s->normal[c] = pti_normalize(s->normal[c]);
}
/* Corner c's new vertex: the old one, or a copy of it where another group has that. */
static uint32_t pti_smooth_vertex(pti_smooth_state *s, size_t c) {
    uint32_t old = s->mesh->indices[c], owner = pti_smooth_group(s, (uint32_t)c) + 1, v;
    for (v = s->first[old]; v; v = s->next[v]) if (s->owner[v] == owner) return v - 1;
    v = s->first[old] ? (uint32_t)++s->count : old + 1;
    s->owner[v] = owner;
    s->origin[v] = old;
    s->next[v] = s->first[old];
    s->first[old] = v;
    return v - 1;
}
static int pti_smooth_alloc(pti_smooth_state *s) {
    const pt_allocator *a = &s->allocator;
    size_t n = s->mesh->vertex_count;
    for (s->table_size = 64; s->table_size < 2 * s->most; ) s->table_size *= 2;
    s->table = (uint32_t *)pti_alloc(a, s->table_size, sizeof *s->table);
    s->point = (uint32_t *)pti_alloc(a, n, sizeof *s->point);
    s->first = (uint32_t *)pti_alloc(a, n, sizeof *s->first);
    s->group = (uint32_t *)pti_alloc(a, s->corners, sizeof *s->group);
    s->index = (uint32_t *)pti_alloc(a, s->corners, sizeof *s->index);
    s->face = (pt_vec3 *)pti_alloc(a, s->corners / 3, sizeof *s->face);
    s->normal = (pt_vec3 *)pti_alloc(a, s->corners, sizeof *s->normal);
    s->next = (uint32_t *)pti_alloc(a, s->most, sizeof *s->next);
    s->owner = (uint32_t *)pti_alloc(a, s->most, sizeof *s->owner);
    s->origin = (uint32_t *)pti_alloc(a, s->most, sizeof *s->origin);
    return s->table && s->point && s->first && s->group && s->index && s->face && s->normal && s->next && s->owner
        && s->origin;
}
static void pti_smooth_free(pti_smooth_state *s) {
    const pt_allocator *a = &s->allocator;
    size_t n = s->mesh->vertex_count;
    pti_free(a, s->table, s->table_size, sizeof *s->table);
    pti_free(a, s->point, n, sizeof *s->point);
    pti_free(a, s->first, n, sizeof *s->first);
    pti_free(a, s->group, s->corners, sizeof *s->group);
    pti_free(a, s->index, s->corners, sizeof *s->index);
    pti_free(a, s->face, s->corners / 3, sizeof *s->face);
    pti_free(a, s->normal, s->corners, sizeof *s->normal);
    pti_free(a, s->next, s->most, sizeof *s->next);
    pti_free(a, s->owner, s->most, sizeof *s->owner);
    pti_free(a, s->origin, s->most, sizeof *s->origin);
}
/* The mesh's arrays anew. Nothing of it changes before all memory is there. */
static int pti_smooth_rewrite(pti_smooth_state *s, float *positions, float *normals, float *uvs) {
    pt_mesh *m = s->mesh;
    size_t v;
    if (!positions || !normals || (m->uvs && !uvs)) return 0;
    for (v = 0; v < s->count; v++) {
        size_t old = v < m->vertex_count ? v : s->origin[v + 1];
        memcpy(positions + 3 * v, m->positions + 3 * old, 3 * sizeof(float));
        if (s->owner[v + 1]) memcpy(normals + 3 * v, s->normal + (s->owner[v + 1] - 1), 3 * sizeof(float));
        if (uvs) memcpy(uvs + 2 * v, m->uvs + 2 * old, 2 * sizeof(float));
    }
    memcpy(m->indices, s->index, s->corners * sizeof *s->index);
    return 1;
}
static int pti_smooth_give(pti_smooth_state *s) {
    const pt_allocator *a = &s->allocator;
    pt_mesh *m = s->mesh;
    float *positions = (float *)pti_alloc(a, s->count, sizeof(pti_float3)), *old_positions = m->positions;
    float *normals = (float *)pti_alloc(a, s->count, sizeof(pti_float3)), *old_normals = m->normals;
    float *uvs = m->uvs ? (float *)pti_alloc(a, s->count, sizeof(pti_float2)) : NULL, *old_uvs = m->uvs;
    size_t n = m->vertex_count;
    int ok = pti_smooth_rewrite(s, positions, normals, uvs);
    if (ok) { m->positions = positions; m->normals = normals; m->uvs = uvs; }
    else { old_positions = positions; old_normals = normals; old_uvs = uvs; n = s->count; }
    pti_free(a, old_positions, n, sizeof(pti_float3));
    pti_free(a, old_normals, n, sizeof(pti_float3));
    pti_free(a, old_uvs, n, sizeof(pti_float2));
    return ok;
}
static int pti_smooth_check(const pt_mesh *m, float angle_deg, char *error) {
    size_t i;
    if (!(angle_deg >= 0 && angle_deg <= 180))
        return !pti_report(error, PT_ERR_ARG, "pt_mesh_smooth", "angle_deg must be between 0 and 180");
    if (!m->positions || !m->indices || m->index_count % 3)
        return !pti_report(error, PT_ERR_ARG, "pt_mesh_smooth", "a mesh has positions, and three indices a triangle");
    for (i = 0; i < m->index_count; i++)
        if (m->indices[i] >= m->vertex_count)
            return !pti_report(error, PT_ERR_ARG, "pt_mesh_smooth", "an index is not below vertex_count");
    return m->vertex_count + m->index_count < UINT32_MAX / 2
        || !pti_report(error, PT_ERR_ARG, "pt_mesh_smooth", "more than 2147483647 vertices and corners");
}
static int pti_smooth_mesh(pt_mesh *mesh, float angle_deg) {  /* 0: out of memory */
    pti_smooth_state s;
    float sine;
    size_t c;
    int ok;
    memset(&s, 0, sizeof s);
    s.mesh = mesh;
    s.allocator = pti_allocator_or_default(mesh->allocator);
    s.corners = mesh->index_count;
    s.count = mesh->vertex_count;
    s.most = s.count + s.corners + 1;
    pti_sincos(angle_deg * (PTI_PI / 180), &sine, &s.cosine);
    s.cosine = angle_deg > 0 && angle_deg < 180 ? s.cosine - 1e-6f : -2.0f;
    ok = pti_smooth_alloc(&s);
    if (ok) {
        pti_smooth_find_points(&s);
        pti_smooth_find_faces(&s);
        memset(s.table, 0, s.table_size * sizeof *s.table);
        for (c = 0; c < s.corners; c++) pti_smooth_edge(&s, c);
        pti_smooth_sum(&s);
        for (c = 0; c < s.corners; c++) s.index[c] = pti_smooth_vertex(&s, c);
        ok = pti_smooth_give(&s);
    }
    pti_smooth_free(&s);
    if (ok) mesh->vertex_count = s.count;
    return ok;
}
PT_DEF pt_result pt_mesh_smooth(pt_mesh *mesh, float angle_deg) {
    pti_fpmode mode;
    pt_result r = PT_OK;
    if (!mesh) return PT_ERR_ARG;
    mode = pti_fpmode_enter();
    mesh->error[0] = 0;
    if (!pti_smooth_check(mesh, angle_deg, mesh->error)) r = PT_ERR_ARG;
    else if (!pti_smooth_mesh(mesh, angle_deg)) r = pti_report(mesh->error, PT_ERR_MEMORY, "pt_mesh_smooth", "out of memory");
    pti_fpmode_leave(mode);
    return r;
}

#ifdef __cplusplus
}
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif
#endif /* PT_IMPLEMENTATION */

/* ---- >>license -----------------------------------------------------------------------------------------
   MIT License

   Copyright (c) 2026 the pt.h authors

   Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
   documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
   rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
   persons to whom the Software is furnished to do so, subject to the following conditions:

   The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
   Software.

   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
   WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
   COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
   OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. */
