/* The file readers on whatever the fuzzer finds: the first byte picks the reader. What loads must be sound, what is refused
   must say where, and nothing may leak, read outside, or be freed with another size than it was allocated with.
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
        memcpy(&last, im.pixels + (size_t)im.width * (size_t)im.height * (size_t)im.channels - 1, sizeof last);
    }
    pt_image_free(&im);
}
static void read_obj(const uint8_t *data, size_t size, pt_allocator allocator) {
    pt_mesh m;
    pt_result r;
    size_t i;
    memset(&m, 0, sizeof m);
    m.allocator = allocator;
    r = pt_read_obj_memory(&m, data, size);
    DEMAND(r == PT_OK || r == PT_ERR_FORMAT || r == PT_ERR_MEMORY);
    DEMAND((r == PT_OK) == (m.positions && m.indices) && (r == PT_OK) == (m.error[0] == 0));
    DEMAND(r != PT_OK || (m.index_count >= 3 && m.index_count % 3 == 0));
    for (i = 0; i < m.index_count; i++) {
        const float *p = m.positions + 3 * (size_t)m.indices[i];
        DEMAND(m.indices[i] < m.vertex_count);
        DEMAND(p[0] >= m.lo.x && p[1] >= m.lo.y && p[2] >= m.lo.z && p[0] <= m.hi.x && p[1] <= m.hi.y && p[2] <= m.hi.z);
        DEMAND(!m.normals || pti_finite(m.normals[3 * (size_t)m.indices[i] + 2]));
        DEMAND(!m.uvs || pti_finite(m.uvs[2 * (size_t)m.indices[i] + 1]));
    }
    pt_mesh_free(&m);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    size_t live = 0;
    pt_allocator a;
    a.alloc = fuzz_alloc;
    a.free = fuzz_free;
    a.user = &live;
    if (!size) return 0;
    if (data[0] & 1) read_obj(data + 1, size - 1, a);
    else read_image(data + 1, size - 1, a);
    DEMAND(live == 0);
    return 0;
}
