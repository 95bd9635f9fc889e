/* The file readers and the picture writers on whatever the fuzzer finds: the first byte picks one. What loads must be sound,
   what is refused must say where, what is bytes must come back as bytes, and nothing may leak, read outside, or be freed with
   another size than it was allocated with.
       clang -g -O1 -fsanitize=fuzzer,address,undefined -I. tests/fuzz/fuzz_files.c -o fuzz_files -lm -lpthread */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../../pt.h"

#define DEMAND(x) do { if (!(x)) __builtin_trap(); } while (0)

/* malloc hands out what sanitizers watch; the size stands in front. */
static void *fuzz_alloc(void *user, size_t size, size_t align) {
    size_t *live = (size_t *)user;
    char *p;
    (void)align;                                         /* 16 is enough: nothing here is loaded aligned */
    if (size > 400000000) return NULL;
    p = (char *)malloc(size + 16);
    if (!p) return NULL;
    memcpy(p, &size, sizeof size);
    memset(p + 16, 0xa5, size < 4096 ? size : 4096);
    ++*live;
    return p + 16;
}
static void fuzz_free(void *user, void *ptr, size_t size) {
    size_t *live = (size_t *)user, was;
    char *p = (char *)ptr - 16;
    memcpy(&was, p, sizeof was);
    DEMAND(was == size);
    --*live;
    free(p);
}

/* Any floats, in any encoding: written, or refused before a byte is. */
typedef struct written { size_t size; const uint8_t *expected; size_t expected_size; int same; } written;
static int count_bytes(void *user, const void *data, size_t size) {
    written *w = (written *)user;
    DEMAND(size > 0);
    if (w->expected && (w->size + size > w->expected_size || memcmp(w->expected + w->size, data, size))) w->same = 0;
    w->size += size;
    return 0;
}
static void write_image(const uint8_t *data, size_t size) {
    float pixels[3 * 1024];
    pt_encoding e;
    pt_writer w;
    written n;
    int width, height, curve, ok;
    if (size < sizeof e + 2 + 12) return;
    memcpy(&e.exposure_stops, data, 4);
    curve = data[4] % 5 - 1;
    memcpy(&e.curve, &curve, sizeof e.curve);
    e.bits = data[5] % 4 * 8;                            /* 24 is none */
    data += 6; size -= 6;
    if (size > sizeof pixels) size = sizeof pixels;
    memcpy(pixels, data, size);
    width = 1 + data[0] % (int)(size / 12);
    height = (int)(size / 12) / width;
    ok = e.exposure_stops >= -100 && e.exposure_stops <= 100 && curve >= 0 && curve <= 2 && e.bits != 24;
    memset(&n, 0, sizeof n);
    w.write = count_bytes;
    w.user = &n;
    DEMAND(pt_write_png_to(&w, pixels, width, height, &e) == (ok ? PT_OK : PT_ERR_ARG) && (n.size > 0) == ok);
    DEMAND(pt_write_ppm_to(&w, pixels, width, height, &e) == (ok ? PT_OK : PT_ERR_ARG) && (n.size > 0) == ok);
    DEMAND(pt_write_hdr_to(&w, pixels, width, height) == PT_OK);
}
/* A PPM of bytes with the header that we write too must be written again as it was. */
static void write_again(const pt_image *im, const uint8_t *data, size_t size) {
    char header[64];
    pt_writer w;
    written n;
    int length = snprintf(header, sizeof header, "P6\n%d %d\n255\n", im->width, im->height);
    if (size < (size_t)length || memcmp(data, header, (size_t)length)) return;
    memset(&n, 0, sizeof n);
    n.expected = data;
    n.expected_size = (size_t)length + (size_t)im->width * (size_t)im->height * 3;
    n.same = 1;
    w.write = count_bytes;
    w.user = &n;
    DEMAND(pt_write_ppm_to(&w, im->pixels, im->width, im->height, NULL) == PT_OK && n.same && n.size == n.expected_size);
}
static void read_image(const uint8_t *data, size_t size, pt_allocator allocator) {
    pt_image im;
    pt_result r;
    float last;
    memset(&im, 0, sizeof im);
    im.allocator = allocator;
    r = pt_read_image_memory(&im, data, size);
    DEMAND(r == PT_OK || r == PT_ERR_FORMAT || r == PT_ERR_MEMORY);
    DEMAND((r == PT_OK) == (im.pixels != NULL) && (r == PT_OK) == (im.error[0] == 0));
    if (r == PT_OK) {
        DEMAND(im.width > 0 && im.height > 0 && (im.channels == 1 || im.channels == 3));
        write_again(&im, data, size);
        memcpy(&last, im.pixels + (size_t)im.width * (size_t)im.height * (size_t)im.channels - 1, sizeof last);
    }
    pt_image_free(&im);
}
static void demand_sound(const pt_mesh *m) {
    size_t i;
    DEMAND(m->index_count % 3 == 0 && (m->material_ids != NULL) == (m->material_count > 1));
    for (i = 0; i < m->index_count; i++) {
        const float *p = m->positions + 3 * (size_t)m->indices[i];
        DEMAND(m->indices[i] < m->vertex_count);
        DEMAND(!m->material_ids || m->material_ids[i / 3] < m->material_count);
        DEMAND(p[0] >= m->lo.x && p[1] >= m->lo.y && p[2] >= m->lo.z);
        DEMAND(p[0] <= m->hi.x && p[1] <= m->hi.y && p[2] <= m->hi.z);
        DEMAND(!m->normals || pti_finite(m->normals[3 * (size_t)m->indices[i] + 2]));
        DEMAND(!m->uvs || pti_finite(m->uvs[2 * (size_t)m->indices[i] + 1]));
    }
}
/* OBJ or PLY, as the content says; smoothed afterwards. */
static void read_mesh(const uint8_t *data, size_t size, pt_allocator allocator) {
    pt_mesh m;
    pt_result r;
    memset(&m, 0, sizeof m);
    m.allocator = allocator;
    r = pt_read_mesh_memory(&m, data, size);
    DEMAND(r == PT_OK || r == PT_ERR_FORMAT || r == PT_ERR_MEMORY);
    DEMAND((r == PT_OK) == (m.positions && m.indices) && (r == PT_OK) == (m.error[0] == 0));
    DEMAND(r != PT_OK || m.index_count >= 3);
    demand_sound(&m);
    if (r == PT_OK) {
        r = pt_mesh_smooth(&m, (float)(size % 181));
        DEMAND(r == PT_OK || r == PT_ERR_MEMORY);
        demand_sound(&m);
    }
    pt_mesh_free(&m);
}
/* A material library. Whatever it says, a scene takes what comes out. */
static void read_mtl(const uint8_t *data, size_t size, pt_allocator allocator) {
    static const char obj[] = "v 0 0 0\nusemtl a\nf 1 1 1\nusemtl b\nf 1 1 1\n";
    pt_mesh m;
    pt_scene *s;
    size_t i;
    memset(&m, 0, sizeof m);
    m.allocator = allocator;
    DEMAND(pt_read_obj_memory(&m, obj, sizeof obj - 1) == PT_OK && m.material_count == 2);
    DEMAND(pt_read_mtl_memory(&m, data, size) == PT_OK);
    s = pt_scene_create(NULL);
    for (i = 0; i < m.material_count; i++) pt_add_material(s, &m.materials[i].desc);
    DEMAND(!pt_scene_error(s)[0]);
    pt_scene_destroy(s);
    pt_mesh_free(&m);
}
/* A measured BRDF. No fuzzer finds 35 MB: now and then (it takes a tenth of a second), what it has stands in a file
   of zeros with the right header. */
static void read_merl(const uint8_t *data, size_t size, pt_allocator allocator) {
    static const uint8_t header[12] = { 90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0 };
    static uint8_t file[12 + 8 * 3 * 90 * 90 * 180];
    size_t at = 0, i;
    pt_merl m;
    pt_result r;
    memset(&m, 0, sizeof m);
    m.allocator = allocator;
    r = pt_read_merl_memory(&m, data, size);
    DEMAND(r == PT_ERR_FORMAT && m.error[0] && !m.values);
    if (size < 5 || data[0] % 32) return;
    memcpy(file, header, sizeof header);
    if (data[0] & 32) { memcpy(&at, data + 1, 4); at %= sizeof file; }
    if (size > sizeof file - at) size = sizeof file - at;
    memcpy(file + at, data, size);
    r = pt_read_merl_memory(&m, file, sizeof file - data[size - 1] % 2);
    DEMAND(r == PT_OK || r == PT_ERR_FORMAT || r == PT_ERR_MEMORY);
    DEMAND((r == PT_OK) == (m.values != NULL) && (r == PT_OK) == (m.error[0] == 0));
    for (i = 0; r == PT_OK && i < 64; i++) DEMAND(m.values[at / 8 + i < 3 * PTI_MERL_CELLS ? at / 8 + i : 0] >= 0);
    pt_merl_free(&m);
    memset(file + at, 0, size);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    size_t live = 0;
    pt_allocator a;
    a.alloc = fuzz_alloc;
    a.free = fuzz_free;
    a.user = &live;
    if (!size) return 0;
    switch (data[0] % 6) {
    case 0: read_image(data + 1, size - 1, a); break;
    case 2: read_mtl(data + 1, size - 1, a); break;
    case 4: write_image(data + 1, size - 1); break;
    case 5: read_merl(data + 1, size - 1, a); break;
    default: read_mesh(data + 1, size - 1, a); break;
    }
    DEMAND(live == 0);
    return 0;
}
