// How fast are meshes read? One mesh as OBJ, PLY in words and PLY in bytes, from files that the system has in its cache,
// beside tinyobjloader and assimp where they are installed. Seconds are the median of five. In C++, since tinyobjloader is.
//     sh tests/bench/bench_mesh.sh OUT [mesh.obj]
#define PT_IMPLEMENTATION
#include "../../pt.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "timing.h"
#ifdef BENCH_TINYOBJ
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>
#endif
#ifdef BENCH_ASSIMP
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#endif

enum { RUNS = 5 };

// Each reader returns the number of triangles that it found.
static size_t read_ours(const char *path) {
    pt_mesh m = {};
    size_t n;
    if (pt_read_mesh(&m, path) != PT_OK) printf("%s\n", m.error);
    n = m.index_count / 3;
    pt_mesh_free(&m);
    return n;
}
static size_t read_ours_smooth(const char *path) {
    pt_mesh m = {};
    size_t n;
    if (pt_read_mesh(&m, path) != PT_OK || pt_mesh_smooth(&m, 30) != PT_OK) printf("%s\n", m.error);
    n = m.index_count / 3;
    pt_mesh_free(&m);
    return n;
}
#ifdef BENCH_TINYOBJ
static size_t read_tinyobj(const char *path) {
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warnings, errors;
    size_t n = 0;
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &errors, path)) printf("%s\n", errors.c_str());
    for (size_t i = 0; i < shapes.size(); i++) n += shapes[i].mesh.num_face_vertices.size();
    return n;
}
#endif
#ifdef BENCH_ASSIMP
static size_t read_assimp(const char *path, unsigned flags) {
    const aiScene *s = aiImportFile(path, flags);
    size_t n = 0;
    if (!s) { printf("%s\n", aiGetErrorString()); return 0; }
    for (unsigned i = 0; i < s->mNumMeshes; i++) n += s->mMeshes[i]->mNumFaces;
    aiReleaseImport(s);
    return n;
}
static size_t read_assimp_raw(const char *path) { return read_assimp(path, 0); }
static size_t read_assimp_indexed(const char *path) {
    return read_assimp(path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
}
#endif

static void time_reader(const char *name, const char *path, size_t (*reader)(const char *)) {
    double seconds[RUNS], start;
    size_t triangles = 0;
    FILE *f = fopen(path, "rb");
    long size = f && fseek(f, 0, SEEK_END) == 0 ? ftell(f) : 0;
    if (f) fclose(f);
    for (int i = 0; i < RUNS; i++) {
        start = now();
        triangles = reader(path);
        seconds[i] = now() - start;
    }
    start = median(seconds, RUNS);
    printf("  %-44s %8.4f s %8.1f MB/s   %lu triangles\n", name, start, (double)size * 1e-6 / start,
           (unsigned long)triangles);
    fflush(stdout);
}

// Nine digits bring each float back; on a little-endian machine, bytes are as they are.
static void write_ply(const char *path, const pt_mesh *m, int binary) {
    FILE *f = fopen(path, "wb");
    if (!f) { printf("cannot write %s\n", path); exit(1); }
    fprintf(f, "ply\nformat %s 1.0\nelement vertex %lu\nproperty float x\nproperty float y\nproperty float z\n"
            "element face %lu\nproperty list uchar int vertex_indices\nend_header\n", binary ? "binary_little_endian" : "ascii",
            (unsigned long)m->vertex_count, (unsigned long)(m->index_count / 3));
    for (size_t i = 0; i < m->vertex_count; i++) {
        const float *p = m->positions + 3 * i;
        if (binary) fwrite(p, 4, 3, f);
        else fprintf(f, "%.9g %.9g %.9g\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (size_t i = 0; i < m->index_count; i += 3) {
        const uint32_t *p = m->indices + i;
        if (binary) { fputc(3, f); fwrite(p, 4, 3, f); }
        else fprintf(f, "3 %u %u %u\n", p[0], p[1], p[2]);
    }
    fclose(f);
}
static void time_file(const char *path, int obj) {
    printf("%s\n", path);
    time_reader("pt.h", path, read_ours);
    if (obj) time_reader("pt.h, and smooth normals", path, read_ours_smooth);
#ifdef BENCH_TINYOBJ
    if (obj) time_reader("tinyobjloader", path, read_tinyobj);
#endif
#ifdef BENCH_ASSIMP
    time_reader("assimp, no post-processing", path, read_assimp_raw);
    time_reader("assimp, triangulated, vertices shared", path, read_assimp_indexed);
#endif
}
int main(int argc, char **argv) {
    char ascii[500], binary[500];
    pt_mesh m = {};
    if (argc != 3) { printf("usage: bench_mesh OUT mesh.obj\n"); return 1; }
    if (pt_read_obj(&m, argv[2]) != PT_OK) { printf("skipped: %s\n", m.error); return 0; }
    snprintf(ascii, sizeof ascii, "%s/bench_ascii.ply", argv[1]);
    snprintf(binary, sizeof binary, "%s/bench_binary.ply", argv[1]);
    write_ply(ascii, &m, 0);
    write_ply(binary, &m, 1);
    pt_mesh_free(&m);
    time_file(argv[2], 1);
    time_file(ascii, 0);
    time_file(binary, 0);
    return 0;
}
