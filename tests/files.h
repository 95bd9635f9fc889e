/* files.h - what the tests of the file readers share: memory that counts and can run out, whole files, damage. */
#ifndef FILES_H
#define FILES_H
#include "test.h"

/* An allocator that knows each block's size, and fails from the call numbered fail_at on (0 = never). */
typedef struct counter { size_t live, bytes, peak, calls, fail_at, wrong_sizes; } counter;
static void *counter_alloc(void *user, size_t size, size_t align) {
    counter *c = (counter *)user;
    size_t *raw;
    char *p;
    c->calls++;
    if (c->fail_at && c->calls >= c->fail_at) return NULL;
    raw = (size_t *)malloc(size + align + 3 * sizeof(size_t));
    if (!raw) return NULL;
    p = (char *)(raw + 3);
    p += (align - (uintptr_t)p % align) % align;
    memcpy(p - sizeof size, &size, sizeof size);
    memcpy(p - sizeof size - sizeof raw, &raw, sizeof raw);
    memset(p, 0xa5, size);                               /* nobody gets zeros by luck */
    c->live++;
    c->bytes += size;
    if (c->bytes > c->peak) c->peak = c->bytes;
    return p;
}
static void counter_free(void *user, void *p, size_t size) {
    counter *c = (counter *)user;
    size_t was;
    void *raw;
    memcpy(&was, (char *)p - sizeof was, sizeof was);
    memcpy(&raw, (char *)p - sizeof was - sizeof raw, sizeof raw);
    c->wrong_sizes += was != size;
    c->live--;
    c->bytes -= was;
    free(raw);
}
static pt_allocator counted(counter *c) {
    pt_allocator a;
    memset(c, 0, sizeof *c);
    a.alloc = counter_alloc;
    a.free = counter_free;
    a.user = c;
    return a;
}

/* A block of just this size on the heap, so that a sanitizer sees a read behind its end. */
static unsigned char *exact_copy(const void *data, size_t size) {
    unsigned char *p = (unsigned char *)malloc(size ? size : 1);
    if (!p) abort();
    if (size) memcpy(p, data, size);
    return p;
}
static int file_exists(const char *path) {
    FILE *f = fopen(path, "rb");
    if (f) fclose(f);
    return f != NULL;
}
static void file_write(const char *path, const void *data, size_t size) {
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(data, 1, size, f) != size || fclose(f)) { FAIL("cannot write %s", path); }
}
/* "file:12: reason" or "file:byte 12: reason" */
static int has_place(const char *error, const char *file) {
    size_t n = strlen(file);
    const char *p = error + n;
    if (strncmp(error, file, n) || *p++ != ':') return 0;
    if (!strncmp(p, "byte ", 5)) p += 5;
    if (*p < '0' || *p > '9') return 0;
    while (*p >= '0' && *p <= '9') p++;
    return p[0] == ':' && p[1] == ' ' && p[2];
}
/* One to eight changes: a byte anew, a bit flipped, a byte put in or taken out, a piece doubled, the end cut off, a number
   made extreme. Returns the new size; data has room for 64 bytes more. */
static size_t mutate(pt_rng *rng, unsigned char *data, size_t size) {
    static const char *const extreme[] = { "0", "-1", "999999999999", "2147483647", "4294967295", "1e999", "nan", "\\\n",
        "/", "\r" };
    int changes = 1 + (int)(pt_rng_u32(rng) % 8);
    while (changes-- && size > 8) {
        size_t i = pt_rng_u32(rng) % size, n = 1 + pt_rng_u32(rng) % 6;
        const char *word = extreme[pt_rng_u32(rng) % 10];
        switch (pt_rng_u32(rng) % 7) {
        case 0: data[i] = (unsigned char)pt_rng_u32(rng); break;
        case 1: data[i] = (unsigned char)(data[i] ^ 1u << pt_rng_u32(rng) % 8); break;
        case 2: memmove(data + i + 1, data + i, size - i); data[i] = (unsigned char)pt_rng_u32(rng); size++; break;
        case 3: memmove(data + i, data + i + 1, size - i - 1); size--; break;
        case 4: memmove(data + i + n, data + i, size - i); size += n; break;
        case 5: if (pt_rng_u32(rng) % 8 == 0) size = i + 1; break;
        default: n = strlen(word); if (i + n <= size) memcpy(data + i, word, n); break;
        }
    }
    return size;
}
#endif
