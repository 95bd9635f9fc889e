/* Meshes: OBJ and MTL, PLY, smooth normals, and several materials a mesh. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "files.h"

/* ---- helpers ---- */

static pt_result load_bytes(pt_mesh *m, const void *data, size_t size) {
    unsigned char *copy = exact_copy(data, size);
    pt_result r;
    memset(m, 0, sizeof *m);
    r = pt_read_obj_memory(m, copy, size);
    free(copy);
    if (r == PT_OK) CHECK(m->positions && m->indices && m->index_count >= 3 && m->index_count % 3 == 0 && !m->error[0]);
    else CHECK(!m->positions && !m->normals && !m->uvs && !m->indices && !m->vertex_count && !m->index_count && m->error[0]);
    return r;
}
static pt_result load(pt_mesh *m, const char *text) { return load_bytes(m, text, strlen(text)); }
static int loads(pt_mesh *m, const char *text) {
    if (CHECK_EQ_INT(load(m, text), PT_OK)) return 1;
    printf("    %s\n", m->error);
    return 0;
}
static int sound(const pt_mesh *m) {                     /* what a renderer relies on */
    size_t i;
    for (i = 0; i < m->index_count; i++) {
        const float *p = m->positions + 3 * (size_t)m->indices[i];
        if (m->indices[i] >= m->vertex_count) return 0;
        if (!(p[0] >= m->lo.x && p[0] <= m->hi.x && p[1] >= m->lo.y && p[1] <= m->hi.y && p[2] >= m->lo.z
            && p[2] <= m->hi.z)) return 0;
    }
    for (i = 0; i < m->vertex_count * 3; i++) if (!isfinite(m->positions[i]) || (m->normals && !isfinite(m->normals[i])))
        return 0;
    return 1;
}
static void cross(const pt_mesh *m, size_t triangle, double out[3]) {    /* twice the area, along the normal */
    const float *a = m->positions + 3 * (size_t)m->indices[3 * triangle],
        *b = m->positions + 3 * (size_t)m->indices[3 * triangle + 1],
                *c = m->positions + 3 * (size_t)m->indices[3 * triangle + 2];
    double u[3], v[3];
    int k;
    for (k = 0; k < 3; k++) { u[k] = (double)b[k] - (double)a[k]; v[k] = (double)c[k] - (double)a[k]; }
    for (k = 0; k < 3; k++) out[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
}
/* The sum of all areas, and the area of the sum: they are equal if no triangle is turned over, so if none overlap. */
static void areas(const pt_mesh *m, double *sum, double *net) {
    double total[3] = { 0, 0, 0 }, n[3];
    size_t i;
    *sum = 0;
    for (i = 0; i < m->index_count / 3; i++) {
        cross(m, i, n);
        *sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        total[0] += 0.5 * n[0]; total[1] += 0.5 * n[1]; total[2] += 0.5 * n[2];
    }
    *net = sqrt(total[0] * total[0] + total[1] * total[1] + total[2] * total[2]);
}
static int indices_are(const pt_mesh *m, const char *digits) {    /* "012 023" */
    size_t i = 0;
    for (; *digits; digits++)
        if (*digits != ' ' && (i >= m->index_count || m->indices[i++] != (uint32_t)(*digits - '0'))) return 0;
    return i == m->index_count;
}

/* ---- reading ---- */

static void a_triangle(void) {
    pt_mesh m;
    if (!loads(&m, "v 1 2 3\nv 4 5 6\nv -7 8.5 9e-1\nf 1 2 3\n")) return;
    CHECK_EQ_INT(m.vertex_count, 3);
    CHECK(indices_are(&m, "012") && !m.normals && !m.uvs);
    CHECK(m.positions[0] == 1 && m.positions[5] == 6 && m.positions[6] == -7 && m.positions[7] == 8.5f
        && m.positions[8] == 0.9f);
    CHECK(m.lo.x == -7 && m.lo.y == 2 && m.lo.z == 0.9f && m.hi.x == 4 && m.hi.y == 8.5f && m.hi.z == 6);
    pt_mesh_free(&m);
    CHECK(!m.positions && !m.indices && m.vertex_count == 0 && m.index_count == 0);
}
static void numbers_in_every_form(void) {
    static const struct { const char *text; float value; } n[] = {
        { "1e-3", 1e-3f }, { "1E+05", 1e5f }, { ".5", 0.5f }, { "5.", 5 }, { "+1", 1 }, { "-0", -0.0f }, { "-.25e1", -2.5f },
        { "0.1", 0.1f }, { "3.14159274", 3.14159274f }, { "340282346638528859811704183484516925440", FLT_MAX },
        { "-3.4028234e38", -3.4028234e38f }, { "1e-45", 1.4e-45f }, { "1e-400", 0 }, { "0e999999999999999999", 0 },
        { "0.000000000000000000000000000000000000000000000000001e50", 0.1f }, { "16777217", 16777216 },
        { "16777219", 16777220 },
        { "123456789012345678901234567890", 1.2345679e29f }, { "00000000000000000000000000000000000001.5", 1.5f },
        { "1000000000000000000000000000000000000000000e-42", 1 }, { "1.17549435e-38", FLT_MIN },
        { "0.30000001192092896", 0.3f } };
    char text[300];
    size_t i;
    for (i = 0; i < sizeof n / sizeof n[0]; i++) {
        pt_mesh m;
        test_case("%s", n[i].text);
        sprintf(text, "v %s 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3", n[i].text);
        if (!loads(&m, text)) continue;
        CHECK_NEAR(m.positions[0], n[i].value, 0);
        CHECK(signbit(m.positions[0]) == signbit(n[i].value));
        pt_mesh_free(&m);
    }
}
static void numbers_round_as_strtof_does(void) {
    pt_rng rng;
    int i, wrong = 0;
    pt_rng_seed(&rng, 1, 2);
    for (i = 0; i < 200000; i++) {
        char text[40];
        double x;
        pti_input in;
        snprintf(text, sizeof text, "%.*g", 3 + (int)(pt_rng_u32(&rng) % 7),
            ldexp((double)pt_rng_u32(&rng) - 2147483648.0, (int)(pt_rng_u32(&rng) % 80) - 60));
        in = pti_input_of("", text, strlen(text), NULL);
        wrong += !pti_parse_number(&in, &x) || in.at != in.end || (float)x != strtof(text, NULL);
    }
    CHECK_EQ_INT(wrong, 0);
}
static void text_in_every_form(void) {
    static const char *const t[] = {
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",                                /* no end of line at the end */
        "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
        "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "\n\r\n\r\r\n\nv 0 0 0\n\rv 1 0 0\nv 0 1 0\n\n\nf 1 2 3\n\n",
        "\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "  v\t0  0\t\t0 \n\tv 1 0 0\t\nv 0 1 0\n  f  1\t2  3  \n",
        "v 0 \\\n0 0\nv 1 0 0\nv \\\r\n0 1\\\n 0\nf 1 \\\r2 3\\\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 \\",
        "# v 9 9 9\\\nv 0 0 0 # v\nv 1 0 0#\nv 0 1 0\n#f 1 2 2\nf 1 2 3# 4\n",
        ("mtllib C:\\models\\\nv 0 0 0\no x\ng a b\nv 1 0 0\nv 0 1 0\ns off\n"
            "usemtl \xc3\xa4\nvp 1\nl 1 2\np 1\nf 1 2 3\ncurv2 1 2\nend"),
        "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 0 0 what ever\nf 1 2 3\n",
        "vt\t0 1\nvn 0 0 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvv 1\nface 1 2\nf 1 2 3\nfo 9 9\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/ 2// 3/\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf +1 -2 -1\n" };
    size_t i;
    for (i = 0; i < sizeof t / sizeof t[0]; i++) {
        pt_mesh m;
        test_case("text %d", (int)i);
        if (!loads(&m, t[i])) continue;
        CHECK(m.vertex_count == 3 && indices_are(&m, "012") && !m.uvs && !m.normals);
        CHECK(m.hi.x == 1 && m.hi.y == 1 && m.lo.x == 0 && m.lo.y == 0 && m.positions[3] == 1 && m.positions[7] == 1);
        pt_mesh_free(&m);
    }
}
static void very_long_lines(void) {
    size_t n = 0, i;
    char *text = (char *)malloc(3000000);
    pt_mesh m;
    if (!text) abort();
    n += (size_t)sprintf(text, "#");
    memset(text + n, '#', 1000000); n += 1000000;
    n += (size_t)sprintf(text + n, "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv");
    memset(text + n, ' ', 1000000); n += 1000000;
    n += (size_t)sprintf(text + n, "1 1 0\nf 1 2 4 3\nf");
    for (i = 0; i < 20000; i++) n += (size_t)sprintf(text + n, " %d", 1 + (int)(i % 4));
    /* more than 1024: a fan */
    if (CHECK_EQ_INT(load_bytes(&m, text, n), PT_OK)) CHECK_EQ_INT(m.index_count, 3 * (2 + 19998));
    pt_mesh_free(&m);
    free(text);
}
static void indices_from_the_end(void) {
    pt_mesh m;
    if (!loads(&m,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 2 2 2\nf -4 -1 -2\n"
        "vt 0 0\nvt 1 0\nvn 0 0 1\nf -4/-1/-1 2/-2/-1 3/1/1\n")) return;
    CHECK(m.vertex_count >= 4 && m.index_count == 9 && m.indices[0] == 0 && m.indices[1] == 1 && m.indices[2] == 2);
    CHECK(m.indices[3] == 0 && m.indices[4] == 3 && m.indices[5] == 2);
    CHECK_EQ_INT(m.vertex_count, 4 + 3);                 /* the corners of the third face are new combinations */
    if (m.index_count == 9 && m.uvs) CHECK(m.uvs[2 * m.indices[6]] == 1 && m.uvs[2 * m.indices[7]] == 0);
    CHECK(sound(&m));
    pt_mesh_free(&m);
}
static void combinations_become_vertices(void) {
    pt_mesh m;
    const char *text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvt 1 0 5\nvt 0.5\nvn 0 0 1\nvn 0 1 0\n"
        "f 1/1/1 2/2/1 3/3/1\n"       /* first seen: they keep their places */
        "f 1/1/1 3/3/1 4//2\n"        /* no texture coordinate at the last */
        "f 1/1/2 3/3/1 4\n"           /* vertex 1 and vertex 4 anew */
        "f 4 2/2/1 1/1/2\n";          /* both found again */
    if (!loads(&m, text)) return;
    CHECK_EQ_INT(m.vertex_count, 5 + 2);
    CHECK_EQ_INT(m.index_count, 12);
    CHECK(m.indices[0] == 0 && m.indices[1] == 1 && m.indices[2] == 2 && m.indices[5] == 3);
    CHECK(m.indices[6] == 5 && m.indices[7] == 2 && m.indices[8] == 6);
    CHECK(m.indices[9] == 6 && m.indices[10] == 1 && m.indices[11] == 5);
    if (CHECK(m.normals && m.uvs)) {
        CHECK(m.uvs[2] == 1 && m.uvs[3] == 0 && m.uvs[4] == 0.5f && m.uvs[5] == 0);
        CHECK(m.uvs[6] == 0 && m.normals[9] == 0 && m.normals[10] == 1);             /* vertex 4: //2 */
        CHECK(m.normals[12] == 0 && m.normals[13] == 0 && m.normals[14] == 0);       /* nobody uses vertex 5 */
        CHECK(m.normals[2] == 1 && m.normals[15 + 1] == 1);                          /* vertex 1 with the other normal */
        CHECK(m.normals[18] == 0 && m.normals[19] == 0 && m.normals[20] == 0);       /* vertex 4 with none */
    }
    CHECK(m.positions[15] == 0 && m.positions[18] == 0 && m.positions[19] == 1);
    CHECK(m.hi.x == 1 && m.hi.y == 1);                   /* the unused one is outside */
    CHECK(sound(&m));
    pt_mesh_free(&m);
}
static void many_combinations_are_told_apart(void) {
    /* a grid of v and vt, each pair twice: the mesh must have each once */
    enum { N = 60 };
    char *text = (char *)malloc(4000000);
    size_t n = 0, distinct = 0;
    int i, j, k;
    pt_mesh m;
    if (!text) abort();
    for (i = 0; i < N; i++) n += (size_t)sprintf(text + n, "v %d 0 %d\nvt %d 0\nvn 0 %d 1\n", i, i * i, i, i);
    for (k = 0; k < 2; k++) for (i = 1; i <= N; i++) for (j = 1; j + 2 <= N; j++)
        n += (size_t)sprintf(text + n, "f %d/%d/%d %d/%d %d//%d\n", i, j, j + 2, i, j + 1, i, j + 2);
    if (CHECK_EQ_INT(load_bytes(&m, text, n), PT_OK)) {
        distinct = (size_t)N * (N - 2) * 3;
        CHECK_EQ_INT(m.vertex_count, distinct);
        CHECK(sound(&m));
        n = 0;
        for (k = 0; k < 2; k++) for (i = 0; i < N; i++) for (j = 1; j + 2 <= N; j++) {
            int wrong = 0, c;
            for (c = 0; c < 3; c++, n++) {
                uint32_t v = m.indices[n];
                wrong += m.positions[3 * v] != (float)i || m.uvs[2 * v] != (float)(c == 0 ? j - 1 : c == 1 ? j : 0)
                      || m.normals[3 * v + 2] != (float)(c != 1) || m.normals[3 * v + 1] != (float)(c != 1 ? j + 1 : 0);
            }
            if (!CHECK_EQ_INT(wrong, 0)) break;
        }
    }
    pt_mesh_free(&m);
    free(text);
}

/* ---- polygons ---- */

/* A face of n points in the plane z = z0 + slant x. */
static void polygon_text(char *text, const double *xy, int n, double slant, int reversed) {
    int i;
    for (i = 0; i < n; i++) text += sprintf(text, "v %.9g %.9g %.9g\n", xy[2 * i], xy[2 * i + 1], 3 + slant * xy[2 * i]);
    text += sprintf(text, "f");
    for (i = 0; i < n; i++) text += sprintf(text, " %d", reversed ? n - i : i + 1);
    sprintf(text, "\n");
}
static double shoelace(const double *xy, int n) {        /* the area, negative if clockwise */
    double a = 0;
    int i, j;
    for (i = 0; i < n; i++) { j = (i + 1) % n; a += xy[2 * i] * xy[2 * j + 1] - xy[2 * j] * xy[2 * i + 1]; }
    return a / 2;
}
static void check_polygon(const char *name, const double *xy, int n) {
    static char text[200000];
    static double turned[2200];
    int start, reversed, i;
    for (start = 0; start < n; start += n > 40 ? 37 : 1) for (reversed = 0; reversed < 2; reversed++) {
        pt_mesh m;
        double sum, net, slant = 0.75, area = fabs(shoelace(xy, n)) * sqrt(1 + slant * slant);
        for (i = 0; i < 2 * n; i++) turned[i] = xy[(i + 2 * start) % (2 * n)];
        polygon_text(text, turned, n, slant, reversed);
        test_case("%s from corner %d%s", name, start, reversed ? ", reversed" : "");
        if (!loads(&m, text)) return;
        CHECK_EQ_INT(m.index_count, 3 * (n - 2));
        areas(&m, &sum, &net);
        CHECK_NEAR(sum, area, area * 1e-6);              /* covers it, and nothing twice */
        CHECK_NEAR(net, area, area * 1e-6);
        for (i = 0; i < n - 2; i++) {                    /* on the side that the winding tells */
            double c[3];
            cross(&m, (size_t)i, c);
            CHECK((reversed ? -c[2] : c[2]) * shoelace(xy, n) >= -1e-6);
        }
        pt_mesh_free(&m);
    }
}
static void polygons_are_covered_once(void) {
    static const double square[] = { 0, 0, 1, 0, 1, 1, 0, 1 };
    static const double arrow[] = { 0, 0, 2, 1, 0, 2, 0.5, 1 };
    static const double l[] = { 0, 0, 2, 0, 2, 1, 1, 1, 1, 3, 0, 3 };
    static const double comb[] = { 0, 0, 7, 0, 7, 3, 6, 3, 6, 1, 5, 1, 5, 3, 4, 3, 4, 1, 3, 1, 3, 3, 2, 3, 2, 1, 1, 1, 1,
        3, 0, 3 };
    static const double midpoints[] = { 0, 0, 1, 0, 2, 0, 2, 1, 2, 2, 1, 2, 0, 2, 0, 1 };
    /* a bridge to a hole, and back */
    static const double hole[] = { 0, 0, 4, 0, 4, 4, 0, 4, 0, 0, 1, 1, 1, 3, 3, 3, 3, 1, 1, 1 };
    static const double spike[] = { 0, 0, 10, 0, 10, 10, 5, 0.001, 0, 10 };
    double star[2 * 40], spiral[2 * 400], round[2 * 1024];
    int i;
    for (i = 0; i < 40; i++) {
        double r = i % 2 ? 1 : 3, a = 6.283185307179586 * i / 40;
        star[2 * i] = r * cos(a); star[2 * i + 1] = r * sin(a);
    }
    for (i = 0; i < 200; i++) {                          /* there and back, five turns */
        double a = 6.283185307179586 * i / 40;
        spiral[2 * i] = (1 + a) * cos(a); spiral[2 * i + 1] = (1 + a) * sin(a);
        spiral[2 * (399 - i)] = (2 + a) * cos(a); spiral[2 * (399 - i) + 1] = (2 + a) * sin(a);
    }
    for (i = 0; i < 1024; i++) {
        double r = i % 3 ? 1 : 0.9, a = 6.283185307179586 * i / 1024;
        round[2 * i] = r * cos(a); round[2 * i + 1] = r * sin(a);
    }
    check_polygon("square", square, 4);
    check_polygon("arrow", arrow, 4);
    check_polygon("L", l, 6);
    check_polygon("comb", comb, 16);
    check_polygon("midpoints", midpoints, 8);
    check_polygon("hole", hole, 10);
    check_polygon("spike", spike, 5);
    check_polygon("star", star, 40);
    check_polygon("spiral", spiral, 400);
    check_polygon("toothed wheel", round, 1024);
}
static void convex_polygons_are_fans(void) {
    pt_mesh m;
    if (!loads(&m, "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\n")) return;
    CHECK(indices_are(&m, "012 023 034"));
    pt_mesh_free(&m);
}
static void degenerate_polygons_do_not_hang(void) {
    static const char *const t[] = {
        "v 0 0 0\nf 1 1 1\n", "v 0 0 0\nf 1 1 1 1 1 1\n",
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3 4\nf 1 3 2 4\nf 1 2 1 2 1 2 1\n",
        "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n",                    /* a bow tie */
        "v 0 3 0\nv 2 -3 0\nv -3 1 0\nv 3 1 0\nv -2 -3 0\nf 1 2 3 4 5\nf 5 4 3 2 1\n",       /* a pentagram */
        ("v 3e38 3e38 3e38\nv -3e38 3e38 -3e38\nv 3e38 -3e38 3e38\nv -3e38 -3e38 -3e38\n"
            "v 1e-40 0 0\nf 1 2 3 4 5\nf 1 5 3 2 4\n") };
    size_t i;
    for (i = 0; i < sizeof t / sizeof t[0]; i++) {
        pt_mesh m;
        test_case("text %d", (int)i);
        if (!loads(&m, t[i])) continue;
        CHECK(sound(&m));
        pt_mesh_free(&m);
    }
}
static void random_polygons_do_not_hang(void) {         /* they cross themselves as they like */
    static char text[200000];
    pt_rng rng;
    int round, i;
    pt_rng_seed(&rng, 3, 2);
    for (round = 0; round < 60; round++) {
        int n = round < 50 ? 4 + (int)(pt_rng_u32(&rng) % 60) : 1024;
        static double xy[2048];
        pt_mesh m;
        for (i = 0; i < 2 * n; i++) xy[i] = round % 2 ? (double)pt_rng_float(&rng) : (double)(pt_rng_u32(&rng) % 4);
        polygon_text(text, xy, n, 0.1, 0);
        if (!loads(&m, text)) return;
        CHECK(m.index_count == 3 * (size_t)(n - 2) && sound(&m));
        pt_mesh_free(&m);
    }
}

/* ---- what is malformed ---- */

static void malformed_meshes_are_refused_in_words(void) {
#define V3 "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    static const struct { const char *text, *error; } c[] = {
        { "", "memory:1: no faces" },
        { V3, "memory:4: no faces" },
        { V3 "l 1 2", "memory:4: no faces" },
        { V3 "f 1 2 901\n", "memory:4: face refers to vertex 901, but there are 3 so far" },
        { V3 "f 1 2 -4\n", "memory:4: face refers to vertex -4, but there are 3 so far" },
        { V3 "f 1 2 4\nv 0 0 0\n", "memory:4: face refers to vertex 4, but there are 3 so far" },
        { V3 "f 1 2 99999999999999999999999\n", "memory:4: face refers to vertex 9999999999999, but there are 3 so far" },
        { V3 "f 0 1 2\n", "memory:4: face refers to vertex 0, but they count from 1" },
        { V3 "f 1 2 -0\n", "memory:4: face refers to vertex 0, but they count from 1" },
        { V3 "\r\n\r\nvt 0 0\rf 1/1 2/1 3/2\n", "memory:7: face refers to texture coordinate 2, but there are 1 so far" },
        { V3 "vn 0 0 1\nf 1//1 2//1 3//7\n", "memory:5: face refers to normal 7, but there are 1 so far" },
        { V3 "f 1/1/1 2 3\n", "memory:4: face refers to texture coordinate 1, but there are 0 so far" },
        { V3 "f 1 2 x\n", "memory:4: \"x\" is not an index" },
        { V3 "f 1 2 3.5\n", "memory:4: \"3.5\" is not a corner: v, v/vt, v//vn or v/vt/vn" },
        { V3 "vt 0\nvn 0 0 1\nf 1 2 3/1/1/1\n", "memory:6: \"3/1/1/1\" is not a corner: v, v/vt, v//vn or v/vt/vn" },
        { V3 "f 1 2 3/x\n", "memory:4: \"x\" is not an index" },
        { V3 "f 1 2 /3\n", "memory:4: \"/3\" is not an index" },
        { V3 "f 1 2 -\n", "memory:4: \"-\" is not an index" },
        { V3 "f 1 2\n", "memory:4: a face needs three corners, this has 2" },
        { V3 "f\n", "memory:4: a face needs three corners, this has 0" },
        { V3 "f", "memory:4: a face needs three corners, this has 0" },
        { "v 1 2\n", "memory:1: v has 2 numbers, but needs 3" },
        { "v", "memory:1: v has 0 numbers, but needs 3" },
        { "\nvt \n", "memory:2: vt has 0 numbers, but needs 1" },
        { "vn 1 # 2 3", "memory:1: vn has 1 numbers, but needs 3" },
        { "v 1 2 nan\n", "memory:1: \"nan\" is not a number" },
        { "v 1 inf 0\n", "memory:1: \"inf\" is not a number" },
        { "v 1 -infinity 0\n", "memory:1: \"-infinity\" is not a number" },
        { "v 1 2 0x10\n", "memory:1: \"0x10\" is not a number" },
        { "v 1,5 2 0\n", "memory:1: \"1,5\" is not a number" },
        { "v . 2 0\n", "memory:1: \".\" is not a number" },
        { "v + 2 0\n", "memory:1: \"+\" is not a number" },
        { "v -.e5 2 0\n", "memory:1: \"-.e5\" is not a number" },
        { "v 1e 2 0\n", "memory:1: \"1e\" is not a number" },
        { "v 1e+ 2 0\n", "memory:1: \"1e+\" is not a number" },
        { "v 1.2.3 2 0\n", "memory:1: \"1.2.3\" is not a number" },
        { "v --1 2 0\n", "memory:1: \"--1\" is not a number" },
        { "v 1 \x01 0\n", "memory:1: \"\" is not a number" },
        { "v 1 \xff\xfe\x80 0\n", "memory:1: \"\?\?\?\" is not a number" },
        { "v 1 2 3.5e38\n", "memory:1: \"3.5e38\" is too large for a float" },
        { "v 1 2 -1e39\n", "memory:1: \"-1e39\" is too large for a float" },
        { "vt 1e999999999999999999999\n", "memory:1: \"1e999999999999999999999\" is too large for a float" },
        { "v 1 2 123456789012345678901234567890123456789012345678901234567890\n",
          "memory:1: \"12345678901234567890123456789012\" is too large for a float" },
        { "v \\\n\\\r\n1 2 \\\nx\n", "memory:4: \"x\" is not a number" },
        { "#\r#\r\n#\n\n\rv 1 1 a", "memory:6: \"a\" is not a number" } };
    static const unsigned char utf16[2][8] = { { 0xff, 0xfe, 'v', 0, ' ', 0, '1', 0 },
        { 0xfe, 0xff, 0, 'v', 0, ' ', 0, '1' } };
    pt_mesh m;
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        test_case("text %d", (int)i);
        CHECK_EQ_INT(load(&m, c[i].text), PT_ERR_FORMAT);
        CHECK_STR(m.error, c[i].error);
        CHECK(has_place(m.error, "memory"));
        pt_mesh_free(&m);
    }
    for (i = 0; i < 4; i++) {                            /* with and without the mark */
        test_case("UTF-16, %d", (int)i);
        CHECK_EQ_INT(load_bytes(&m, utf16[i / 2] + 2 * (i % 2), 6), PT_ERR_FORMAT);
        CHECK_STR(m.error, "memory:1: this is UTF-16 text or no text at all: OBJ is ASCII or UTF-8");
    }
}
static void unreadable_files_are_told(void) {
    pt_mesh m;
    memset(&m, 0, sizeof m);
    CHECK_EQ_INT(pt_read_obj(&m, "out/missing.obj"), PT_ERR_IO);
    CHECK_STR(m.error, "out/missing.obj: cannot open");
    if (file_exists(".")) {
        CHECK_EQ_INT(pt_read_obj(&m, "out"), PT_ERR_IO);
        CHECK_STR(m.error, "out: cannot read");
    }
    file_write("out/test_mesh.tmp", "v 0 0 0\nf 1 1 2\n", 16);
    CHECK_EQ_INT(pt_read_obj(&m, "out/test_mesh.tmp"), PT_ERR_FORMAT);
    CHECK_STR(m.error, "out/test_mesh.tmp:2: face refers to vertex 2, but there are 1 so far");
    file_write("out/test_mesh.tmp", "v 0 0 0\nf 1 1 1\n", 16);
    CHECK_EQ_INT(pt_read_obj(&m, "out/test_mesh.tmp"), PT_OK);
    CHECK(m.index_count == 3 && !m.error[0]);
    pt_mesh_free(&m);
    remove("out/test_mesh.tmp");
    CHECK_EQ_INT(pt_read_obj(&m, NULL), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_obj(NULL, "x"), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_obj_memory(NULL, "x", 1), PT_ERR_ARG);
    CHECK_EQ_INT(pt_read_obj_memory(&m, NULL, 1), PT_ERR_ARG);
    pt_mesh_free(NULL);
}

/* All that the reader does, in one file. */
static const char sample[] =
    "# sample\r\nmtllib x.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 0.5 0\nv 1e0 -5.5E-1 3 1 0 0\n"
    "\tvt 0 0\nvt 1 0 0\nvt .5\nvn 0 0 1\nvn 0 1 0\no a\ng b\nusemtl c\ns 1\nf 1/1/1 2/2/1 \\\n3/3/1 4/1/1 5/2/2\n"
    "f 1//2 2//1 3//2\nf -1 -2 -3\nf 1/1 2/2 6/3\nl 1 2\n"
    "f 1/2/1 5/2/1 3/1/2 4/1/2\nf 6 5 4 3 2 1";
static void every_truncation_does_no_harm(void) {
    size_t n, ok = 0;
    for (n = 0; n < sizeof sample; n++) {
        pt_mesh m;
        pt_result r = load_bytes(&m, sample, n);
        test_case("%d bytes: %s", (int)n, m.error);
        ok += r == PT_OK;
        CHECK(r == PT_OK ? sound(&m) : r == PT_ERR_FORMAT && has_place(m.error, "memory"));
        if (n == sizeof sample - 1) CHECK_EQ_INT(r, PT_OK);
        pt_mesh_free(&m);
    }
    CHECK(ok > 20 && ok < 200);
}
static void damaged_meshes_do_no_harm(void) {
    pt_rng rng;
    int round, loaded = 0;
    pt_rng_seed(&rng, 5, 2);
    for (round = 0; round < 6000; round++) {
        unsigned char *data = (unsigned char *)malloc(sizeof sample + 64), *copy;
        pt_mesh m;
        counter n;
        size_t size;
        if (!data) abort();
        memcpy(data, sample, sizeof sample - 1);
        size = mutate(&rng, data, sizeof sample - 1);
        copy = exact_copy(data, size);
        memset(&m, 0, sizeof m);
        m.allocator = counted(&n);
        if (pt_read_obj_memory(&m, copy, size) == PT_OK) { loaded++; CHECK(sound(&m)); }
        else CHECK(!m.positions && !m.indices && !m.normals && !m.uvs && n.live == 0 && has_place(m.error, "memory"));
        test_case("round %d: %s", round, m.error);
        CHECK(n.peak < 1000000);
        pt_mesh_free(&m);
        CHECK(n.live == 0 && n.wrong_sizes == 0);
        free(data); free(copy);
    }
    CHECK(loaded > 100 && loaded < 5000);                /* both ways are gone */
}
static void memory_may_run_out(void) {
    size_t size = 0, fail;
    unsigned char *data = (unsigned char *)malloc(400000);
    int i, file;
    if (!data) abort();
    memcpy(data, sample, sizeof sample - 1);
    size = sizeof sample - 1;
    size += (size_t)sprintf((char *)data + size, "\n");
    /* lists that grow, as the line ends hide their number from the glance */
    for (i = 0; i < 300; i++)
        size += (size_t)sprintf((char *)data + size, "v %d 0 0\rvt %d 0\rvn 1 0 0\rf -1/-1/-1 1/-1/-1 2/-1/1 3/-1\r", i, i);
    file_write("out/test_mesh.tmp", data, size);
    for (file = 0; file < 2; file++) for (fail = 1; fail < 300; fail++) {
        pt_mesh m;
        counter n;
        pt_result r;
        memset(&m, 0, sizeof m);
        m.allocator = counted(&n);
        n.fail_at = fail;
        test_case("allocation %d", (int)fail);
        r = file ? pt_read_obj(&m, "out/test_mesh.tmp") : pt_read_obj_memory(&m, data, size);
        if (r == PT_OK) CHECK(sound(&m));
        else {
            CHECK_EQ_INT(r, PT_ERR_MEMORY);
            CHECK(!m.positions && !m.indices && !m.normals && !m.uvs && m.vertex_count == 0 && m.index_count == 0
                && n.live == 0);
            CHECK_STR(m.error, file ? "out/test_mesh.tmp: out of memory" : "memory: out of memory");
        }
        pt_mesh_free(&m);
        CHECK(n.live == 0 && n.wrong_sizes == 0);
        if (r == PT_OK) break;
    }
    CHECK(fail > 20 && fail < 300);
    remove("out/test_mesh.tmp");
    free(data);
}

/* ---- materials ---- */

static void faces_tell_their_material(void) {
    pt_mesh m;
    if (!loads(&m, "v 0 0 0\nv 1 0 0\nv 0 1 0\ng one two\nusemtl wood\nf 1 2 3\no x\nusemtl dark \t red \nf 1 2 3\nf 1 2 3 2\n"
        "s 1\nusemtl nobody\nusemtl wood \r\nf 1 2 3\n")) return;
    CHECK_EQ_INT(m.material_count, 2);
    CHECK_EQ_INT(m.index_count, 15);
    if (m.material_count == 2 && CHECK(m.material_ids != NULL)) {
        CHECK_STR(m.materials[0].name, "wood");
        CHECK_STR(m.materials[1].name, "dark \t red");
        CHECK(m.material_ids[0] == 0 && m.material_ids[1] == 1 && m.material_ids[2] == 1 && m.material_ids[3] == 1
            && m.material_ids[4] == 0);
        CHECK(!m.materials[0].defined && m.materials[0].desc.color.y == 0.5f && m.materials[0].desc.bsdf == PT_BSDF_DIFFUSE);
    }
    CHECK_STR(m.warning, "");
    pt_mesh_free(&m);
    CHECK(!m.materials && !m.material_ids && !m.material_count);
    if (!loads(&m, "v 0 0 0\nf 1 1 1\nusemtl a\nf 1 1 1\n")) return;        /* the first face has none: a grey one of no name */
    CHECK(m.material_count == 2 && m.material_ids && m.material_ids[0] == 0 && m.material_ids[1] == 1);
    if (m.material_count == 2) CHECK_STR(m.materials[0].name, "");
    pt_mesh_free(&m);
    if (!loads(&m, "v 0 0 0\nusemtl Material #25\nf 1 1 1\nusemtl Material #26\nf 1 1 1\n")) return;
    CHECK(m.material_count == 2 && !strcmp(m.materials[1].name, "Material #26"));
    pt_mesh_free(&m);
    if (!loads(&m, "v 0 0 0\nusemtl a\nf 1 1 1\nusemtl a\nf 1 1 1\n")) return;
    CHECK(m.material_count == 1 && !m.material_ids);
    pt_mesh_free(&m);
    if (!loads(&m, "v 0 0 0\nf 1 1 1\nusemtl a\n")) return;
    CHECK(m.material_count == 0 && !m.materials);
    pt_mesh_free(&m);
}
/* A mesh whose one material is what the text says of m. */
static pt_mtl *material_of(pt_mesh *m, const char *mtl) {
    unsigned char *copy = exact_copy(mtl, strlen(mtl));
    if (!loads(m, "v 0 0 0\nusemtl m\nf 1 1 1\n")) { free(copy); return NULL; }
    CHECK_EQ_INT(pt_read_mtl_memory(m, copy, strlen(mtl)), PT_OK);
    free(copy);
    return m->material_count == 1 ? m->materials : NULL;
}
typedef struct mtl_case {
    const char *text;
    pt_bsdf bsdf;
    float r, g, b, roughness, metallic, specular, ior, transmission, transparency;
} mtl_case;
static void materials_mean_what_phong_meant(void) {
    static const mtl_case c[] = {
        { "newmtl m\nKd 0.2 0.4 0.6", PT_BSDF_DIFFUSE, 0.2f, 0.4f, 0.6f, 0, 0, 0, 0, 0, 0 },
        { "newmtl m\n", PT_BSDF_DIFFUSE, 0.5f, 0.5f, 0.5f, 0, 0, 0, 0, 0, 0 },
        { "newmtl m\nKd 0.3", PT_BSDF_DIFFUSE, 0.3f, 0.3f, 0.3f, 0, 0, 0, 0, 0, 0 },
        { "newmtl m\nKd 2 -1 .5\nKs 0 0 0\nNs 100", PT_BSDF_DIFFUSE, 1, 0, 0.5f, 0, 0, 0, 0, 0, 0 },
        { "NEWMTL m\nkd .2 .4 .6\nks .25 .25 .25\nns 30\nni 1", PT_BSDF_PRINCIPLED, 0.2f, 0.4f, 0.6f, 0.5f, 0, 0.5f, 0, 0, 0 },
        { "newmtl m\nKd 0.2 0.4 0.6\nKs 1 1 1\nNs 1000\nNi 1.4", PT_BSDF_PRINCIPLED, 0.2f, 0.4f, 0.6f, 0, 0, 1, 1.4f, 0, 0 },
        { "newmtl m\nKd 0.2 0.4 0.6\nKs 1 1 1\nillum 1", PT_BSDF_DIFFUSE, 0.2f, 0.4f, 0.6f, 0, 0, 0, 0, 0, 0 },
        { "newmtl m\nKs .9 .7 .2", PT_BSDF_PRINCIPLED, 0.9f, 0.7f, 0.2f, 0, 1, 0, 0, 0, 0 },
        { "newmtl m\nKd 0 0 0\nKs .9 .7 .2\nNs 30", PT_BSDF_PRINCIPLED, 0.9f, 0.7f, 0.2f, 0.5f, 1, 0, 0, 0, 0 },
        { "newmtl m\nKd 0 0 0\nKs .5 .5 .5\nNs 30", PT_BSDF_PRINCIPLED, 0, 0, 0, 0.5f, 0, 1, 0, 0, 0 },    /* black plastic */
        { "newmtl m\nKd .2 .2 .2\nKs .6 .6 .6\nillum 3", PT_BSDF_PRINCIPLED, 0.8f, 0.8f, 0.8f, 0, 0.75f, 0, 0, 0, 0 },
        { "newmtl m\nKd .5 .5 .5\nd .25", PT_BSDF_DIFFUSE, 0.5f, 0.5f, 0.5f, 0, 0, 0, 0, 0, 0.75f },
        { "newmtl m\nKd .5 .5 .5\nTr .25", PT_BSDF_DIFFUSE, 0.5f, 0.5f, 0.5f, 0, 0, 0, 0, 0, 0.25f },
        { "newmtl m\nKd .5 .5 .5\nd -halo .5\nTr .9", PT_BSDF_DIFFUSE, 0.5f, 0.5f, 0.5f, 0, 0, 0, 0, 0, 0.5f },  /* d holds */
        { "newmtl m\nKd 0 0 0\nKs 1 1 1\nNi 1.5\nillum 7", PT_BSDF_PRINCIPLED, 1, 1, 1, 0, 0, 0, 1.5f, 1, 0 },
        { "newmtl m\nKd .5 1 .5\nNi 1.3\nillum 4\nd .25", PT_BSDF_PRINCIPLED, 0.5f, 1, 0.5f, 0, 0, 0, 1.3f, 0.75f, 0 },
        { "newmtl m\nKd .5 1 .5\nNi 1.5\nTf 1 .5 .5\nd .25", PT_BSDF_PRINCIPLED, 1, 0.5f, 0.5f, 0, 0, 0, 1.5f, 0.75f, 0 },
        { "newmtl m\nKd .5 1 .5\nNi 1\nillum 4\nd .25", PT_BSDF_DIFFUSE, 0.5f, 1, 0.5f, 0, 0, 0, 0, 0, 0.75f },
        { "newmtl m\nKd .5 1 .5\nNi 1.5\nTf 0 0 0\nillum 4\nd .25", PT_BSDF_DIFFUSE, 0.5f, 1, 0.5f, 0, 0, 0, 1.5f, 0, 0.75f },
        { "newmtl m\nKd .5 1 .5\nNi 1.5\nTf 1 1 1\nd 1", PT_BSDF_DIFFUSE, 0.5f, 1, 0.5f, 0, 0, 0, 1.5f, 0, 0 },
        { "newmtl m\nKd .5 .5 .5\nKs 1 1 1\nPr .25\nPm 1", PT_BSDF_PRINCIPLED, 0.5f, 0.5f, 0.5f, 0.25f, 1, 0, 0, 0, 0 },
        { "newmtl m\nKd .5 .5 .5\nNs 30\nPm 0", PT_BSDF_PRINCIPLED, 0.5f, 0.5f, 0.5f, 0.5f, 0, 0, 0, 0, 0 },
        { "newmtl x\nKd 1 0 0\nnewmtl m\nKd .1 .2 .3\nnewmtl m\nKd 1 1 1\nnewmtl y\nKd 0 1 0", PT_BSDF_DIFFUSE, 0.1f, 0.2f, 0.3f, 0,
            0, 0, 0, 0, 0 },                                                                              /* the first holds */
        { "\xef\xbb\xbf# x\r\n\r\nnewmtl  m \r\n\tKd .1 \\\r\n .2 .3 # y\r\nKx 1\r\nillum 2", PT_BSDF_DIFFUSE, 0.1f, 0.2f, 0.3f, 0,
            0, 0, 0, 0, 0 } };
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pt_mesh m;
        pt_mtl *t = material_of(&m, c[i].text);
        test_case("%s", c[i].text);
        if (!CHECK(t != NULL)) continue;
        CHECK(t->defined);
        CHECK_STR(m.warning, "");
        CHECK_EQ_INT(t->desc.bsdf, c[i].bsdf);
        CHECK_NEAR(t->desc.color.x, c[i].r, 1e-6); CHECK_NEAR(t->desc.color.y, c[i].g, 1e-6);
        CHECK_NEAR(t->desc.color.z, c[i].b, 1e-6);
        CHECK_NEAR(t->desc.roughness, c[i].roughness, 1e-6); CHECK_NEAR(t->desc.metallic, c[i].metallic, 1e-6);
        CHECK_NEAR(t->desc.specular, c[i].specular, 1e-6); CHECK_NEAR(t->desc.ior, c[i].ior, 1e-6);
        CHECK_NEAR(t->desc.transmission, c[i].transmission, 1e-6);
        CHECK_NEAR(t->desc.transparency, c[i].transparency, 1e-6);
        pt_mesh_free(&m);
    }
}
static void other_numbers_of_a_material(void) {
    pt_mesh m;
    pt_mtl *t = material_of(&m, "newmtl m\nKe 1 20 3e30\nPs .25\nPc .5\nPcr .1\nPr .4\naniso .8\nanisor .25\n");
    float ax, ay;
    if (!CHECK(t != NULL)) return;
    CHECK(t->desc.emission.x == 1 && t->desc.emission.y == 20 && t->desc.emission.z == 1e12f);
    CHECK(t->desc.sheen == 0.25f && t->desc.coat == 0.5f && t->desc.coat_roughness == 0.1f && t->desc.rotation_deg == 90);
    ax = t->desc.roughness * t->desc.roughness; ay = t->desc.roughness_y * t->desc.roughness_y;
    CHECK_NEAR(ax * ay, 0.4 * 0.4 * 0.4 * 0.4, 1e-6);    /* Burley's aspect: sqrt(1 - 0.9 aniso) */
    CHECK_NEAR(ay / ax, 1 - 0.9 * 0.8, 1e-5);
    pt_mesh_free(&m);
}
static void maps_of_a_material(void) {
    pt_mesh m;
    pt_material_desc d;
    int k;
    pt_mtl *t = material_of(&m,
        "newmtl m\nmap_Kd -s 2 3 4 -o .5 .25 -clamp on a b\\c.png  # the wood\n"
        "map_Ks -blendu on -blendv off -boost 2 -cc on -texres 512 -type sphere -t 1 1 1 -clamp off -mm .1 .8 ks.png\n"
        "map_d -imfchan m -s 2 d.png\nmap_Ke \"e e.png\"\nbump -bm 3 2.png\nnorm n.png\nmap_Ps s.png\nmap_Pm -imfchan b orm.png\n"
        "map_Ns gloss.png\nmap_Pr -imfchan g orm.png\nmap_Ns gloss.png\nmap_Ka x\ndisp x\nrefl -type sphere x\ndecal x\n");
    if (!CHECK(t != NULL)) return;
    CHECK_STR(m.warning, "");
    CHECK_STR(t->maps[PT_MTL_COLOR].file, "a b/c.png");
    CHECK(t->maps[PT_MTL_COLOR].uv_scale[0] == 2 && t->maps[PT_MTL_COLOR].uv_scale[1] == 3 && t->maps[PT_MTL_COLOR].srgb);
    CHECK(t->maps[PT_MTL_COLOR].uv_offset[0] == 0.5f && t->maps[PT_MTL_COLOR].clamp);
    CHECK(t->maps[PT_MTL_COLOR].uv_offset[1] == -2.25f);   /* v = 1 is at 1 - (3 + 0.25) from the top */
    CHECK(t->desc.color.x == 1 && t->desc.bsdf == PT_BSDF_PRINCIPLED && t->desc.roughness == 0 && t->desc.sheen == 1);
    CHECK_STR(t->maps[PT_MTL_SPECULAR].file, "ks.png");
    CHECK(t->maps[PT_MTL_SPECULAR].base == 0.1f && t->maps[PT_MTL_SPECULAR].gain == 0.8f && !t->maps[PT_MTL_SPECULAR].clamp);
    CHECK(t->maps[PT_MTL_SPECULAR].uv_offset[1] == 0 && t->maps[PT_MTL_SPECULAR].uv_scale[0] == 1 && t->maps[PT_MTL_SPECULAR].uv_scale[1] == 1);
    CHECK_STR(t->maps[PT_MTL_OPACITY].file, "d.png");
    CHECK(t->maps[PT_MTL_OPACITY].channel == 4 && t->maps[PT_MTL_OPACITY].uv_scale[0] == 2 && !t->maps[PT_MTL_OPACITY].srgb);
    CHECK_STR(t->maps[PT_MTL_EMISSION].file, "e e.png");
    CHECK_STR(t->maps[PT_MTL_BUMP].file, "2.png");
    CHECK_NEAR(t->desc.bump, 0.03, 1e-7);
    CHECK_STR(t->maps[PT_MTL_NORMAL].file, "n.png");
    CHECK_STR(t->maps[PT_MTL_SHEEN].file, "s.png");
    CHECK_STR(t->maps[PT_MTL_METALLIC].file, "orm.png");
    CHECK(t->maps[PT_MTL_METALLIC].channel == 3 && t->maps[PT_MTL_ROUGHNESS].channel == 2);
    CHECK_STR(t->maps[PT_MTL_ROUGHNESS].file, "orm.png");       /* Pr before Ns */
    CHECK(t->maps[PT_MTL_ROUGHNESS].base == 0 && t->maps[PT_MTL_ROUGHNESS].gain == 1);
    for (k = 0; k < PT_MTL_MAPS; k++) if (CHECK(pt_mtl_texture(t, k) != NULL)) pt_mtl_texture(t, k)->id = (uint32_t)k + 1;
    d = t->desc;
    CHECK(d.color_texture.id == PT_MTL_COLOR + 1 && d.specular_texture.id == PT_MTL_SPECULAR + 1 && d.roughness_texture.id
        == PT_MTL_ROUGHNESS + 1 && d.metallic_texture.id == PT_MTL_METALLIC + 1 && d.sheen_texture.id == PT_MTL_SHEEN + 1);
    CHECK(d.emission_texture.id == PT_MTL_EMISSION + 1 && d.opacity_texture.id == PT_MTL_OPACITY + 1
        && d.normal_texture.id == PT_MTL_NORMAL + 1 && d.bump_texture.id == PT_MTL_BUMP + 1);
    CHECK(!pt_mtl_texture(t, PT_MTL_MAPS) && !pt_mtl_texture(t, -1) && !pt_mtl_texture(NULL, 0));
    pt_mesh_free(&m);
    t = material_of(&m, "newmtl m\nmap_Ns g.png\nmap_Tr t.png\nKs 1 1 1\nillum 3\nmap_Ks c.png\n");
    if (!CHECK(t != NULL)) return;
    CHECK(t->maps[PT_MTL_ROUGHNESS].base == 1 && t->maps[PT_MTL_ROUGHNESS].gain == -1 && t->maps[PT_MTL_OPACITY].gain == -1);
    CHECK_STR(t->maps[PT_MTL_COLOR].file, "c.png");      /* of a metal, Ks is the color */
    CHECK(!t->maps[PT_MTL_SPECULAR].file && t->desc.metallic == 1);
    pt_mesh_free(&m);
}
static void malformed_materials_are_warned_of(void) {
    static const struct { const char *text, *warning; } c[] = {
        { "newmtl m\nKd 1 x 1\nNi 1.5", "memory:2: \"x\" is not a number" },
        { "newmtl m\nKd 1 1\nNi 1.5", "memory:2: Kd has 1 numbers, but needs 2" },
        { "newmtl m\nNi 1.5\nNs\n", "memory:3: Ns has 0 numbers, but needs 1" },
        { "newmtl m\n\nKd spectral x.rfl 1\nNi 1.5\nKd z", "memory:3: \"spectral\" is not a number" },
        { "newmtl m\nmap_Kd -s 1 1\nNi 1.5\n", "memory:2: a map without a file" },
        { "newmtl m\nNi 1.5\nKe 1e39 0 0", "memory:3: \"1e39\" is too large for a float" } };
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pt_mesh m;
        pt_mtl *t = material_of(&m, c[i].text);
        test_case("%s", c[i].text);
        if (!CHECK(t != NULL)) continue;
        CHECK_STR(m.warning, c[i].warning);
        CHECK(t->desc.ior == 1.5f && t->desc.color.x == 0.5f);       /* the rest is read, the broken line has no effect */
        pt_mesh_free(&m);
    }
    CHECK_EQ_INT(pt_read_mtl_memory(NULL, "", 0), PT_ERR_ARG);
}
static void libraries_are_found(void) {
    static const char *const text = "v 0 0 0\nmtllib %s\nusemtl a\nf 1 1 1\nusemtl b\nf 1 1 1\n";
    static const struct { const char *library, *warning; int a, b; } c[] = {
        { "test_mesh_1.mtl", "out/test_mesh.tmp:5: no library defines b: it is grey", 1, 0 },
        { "test_mesh_1.mtl test_mesh 2.mtl", "out/test_mesh.tmp:2: cannot open test_mesh: its materials are grey", 1, 0 },
        { "test_mesh 2.mtl", "out/test_mesh.tmp:3: no library defines a: it is grey", 0, 1 },
        { "test_mesh_1.mtl  test_mesh_3.mtl", "", 1, 1 }, { "C:\\there\\test_mesh_3.mtl", "", 1, 1 },
        { "/nowhere/test_mesh_3.mtl\nmtllib\nmtllib test_mesh_1.mtl # y", "", 1, 1 },
        { "gone.mtl test_mesh_1.mtl", "out/test_mesh.tmp:2: cannot open gone.mtl: its materials are grey", 1, 0 },
        { "test_mesh_4.mtl", "out/test_mesh_4.mtl:2: \"y\" is not a number", 1, 0 } };
    char obj[300];
    size_t i;
    file_write("out/test_mesh_1.mtl", "newmtl a\nKd 1 0 0\nmap_Kd sub\\wood.png\n", 39);
    file_write("out/test_mesh 2.mtl", "newmtl b\nKd 0 1 0\n", 18);
    file_write("out/test_mesh_3.mtl", "newmtl b\nKd 0 1 0\nnewmtl a\n", 27);
    file_write("out/test_mesh_4.mtl", "newmtl a\nKd y\nKd 1 0 0", 22);
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pt_mesh m;
        memset(&m, 0, sizeof m);
        snprintf(obj, sizeof obj, text, c[i].library);
        file_write("out/test_mesh.tmp", obj, strlen(obj));
        test_case("%s", c[i].library);
        if (!CHECK_EQ_INT(pt_read_obj(&m, "out/test_mesh.tmp"), PT_OK) || !CHECK_EQ_INT(m.material_count, 2)) continue;
        CHECK_STR(m.warning, c[i].warning);
        CHECK(m.materials[0].defined == c[i].a);
        if (c[i].a && i != 4 && i != 5)      /* there the first is a bare one */
            CHECK(m.materials[0].desc.color.x == 1 && m.materials[0].desc.color.y == 0);
        if (i == 0) CHECK_STR(m.materials[0].maps[PT_MTL_COLOR].file, "out/sub/wood.png");
        CHECK(m.materials[1].defined == c[i].b && m.materials[1].desc.color.x == (c[i].b ? 0 : 0.5f));
        pt_mesh_free(&m);
    }
    remove("out/test_mesh_1.mtl"); remove("out/test_mesh 2.mtl"); remove("out/test_mesh_3.mtl"); remove("out/test_mesh_4.mtl");
    remove("out/test_mesh.tmp");
}

/* ---- PLY ---- */

static const char ply_sample[] =
    "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement odd 2\nproperty list uchar float a\nproperty double b\n"
    "element vertex 5\nproperty float nx\nproperty uchar red\nproperty float z\nproperty list int int more\nproperty double x\n"
    "property float y\nproperty float t\nproperty float s\nproperty float ny\nproperty float nz\nelement nothing 7\n"
    "element face 2\nproperty int flags\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
    "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    "2 .5 .5 1\n0 7\n"
    "0 255 0 2 1 2 0 0 .1 .2 0 1\n0 255 0 0 4 0 .3 .4 0 1\n0 255 0 1 9 4 4 .5 .6 0 1\n\n0 255 0 0 0 4 .7 .8 0 1\n1 0 3 0 1 1 0 0 0 0\n"
    "0 4 0 1 2 3 0\n5 3 4 1 2 6 0 0 0 0 0 0\n"
    "8 0 1 2 3 -1 2 3 4\n";
/* The same in bytes: its words are told by the types in its header. */
static size_t ply_bytes(unsigned char *out, const char *text, int big_endian, const char *line_end) {
    static const char *const name[8] = { "char", "uchar", "short", "ushort", "int", "uint", "float", "double" };
    static const size_t size[8] = { 1, 1, 2, 2, 4, 4, 4, 8 };
    struct { int count, first, end; } element[8];
    struct { int type, count_type; } property[32];
    int elements = 0, properties = 0, e, row, q;
    size_t n = 0;
    const char *p = text;
    while (1) {                                          /* the header */
        char line[100], a[20], b[20], c[20], d[20];
        size_t k = strcspn(p, "\n");
        memcpy(line, p, k);
        line[k] = 0;
        p += k + 1;
        if (!strncmp(line, "format", 6)) sprintf(line, "format binary_%s_endian 1.0", big_endian ? "big" : "little");
        n += (size_t)sprintf((char *)out + n, "%s%s", line, line_end);
        if (sscanf(line, "element %19s %19s", a, b) == 2) {
            element[elements].count = atoi(b);
            element[elements].first = element[elements].end = properties;
            elements++;
        } else if (sscanf(line, "property %19s %19s %19s %19s", a, b, c, d) >= 2) {
            int list = !strcmp(a, "list"), t;
            for (t = 0; t < 8; t++) {
                if (!strcmp(name[t], list ? c : a)) property[properties].type = t;
                if (list && !strcmp(name[t], b)) property[properties].count_type = t;
            }
            if (!list) property[properties].count_type = -1;
            element[elements - 1].end = ++properties;
        }
        if (!strcmp(line, "end_header")) break;
    }
    for (e = 0; e < elements; e++) for (row = 0; row < element[e].count; row++)
        for (q = element[e].first; q < element[e].end; q++) {
            int count = 1, type = property[q].count_type, i, k;
            for (i = type < 0; i <= count; i++) {
                char *end;
                double x = strtod(p, &end);
                float f = (float)x;
                uint64_t bits;
                uint32_t half;
                p = end;
                if (i > 0) type = property[q].type;
                else count = (int)x;
                memcpy(&half, &f, 4);
                if (type == 7) memcpy(&bits, &x, 8);
                else bits = type == 6 ? half : (uint64_t)(int64_t)x;
                for (k = 0; k < (int)size[type]; k++)
                    out[n++] = (unsigned char)(bits >> 8 * (big_endian ? (int)size[type] - 1 - k : k));
            }
        }
    return n;
}
static pt_result load_ply(pt_mesh *m, const void *data, size_t size) {
    unsigned char *copy = exact_copy(data, size);
    pt_result r;
    memset(m, 0, sizeof *m);
    r = pt_read_ply_memory(m, copy, size);
    free(copy);
    if (r == PT_OK) CHECK(m->positions && m->indices && m->index_count >= 3 && m->index_count % 3 == 0 && !m->error[0]);
    else CHECK(!m->positions && !m->normals && !m->uvs && !m->indices && !m->vertex_count && !m->index_count && m->error[0]);
    return r;
}
static void ply_in_every_form(void) {
    static const char *const ends[3] = { "\n", "\r\n", "\r" };
    unsigned char data[4000];
    int form, end;
    for (form = 0; form < 3; form++) for (end = 0; end < 3; end++) {
        size_t n = 0;
        pt_mesh m;
        const char *p;
        test_case("form %d, line end %d", form, end);
        if (form) n = ply_bytes(data, ply_sample, form == 2, ends[end]);
        else for (p = ply_sample; *p; p++) {
            if (*p != '\n') data[n++] = (unsigned char)*p;
            else n += (size_t)sprintf((char *)data + n, "%s", ends[end]);
        }
        if (!CHECK_EQ_INT(load_ply(&m, data, n), PT_OK)) { printf("    %s\n", m.error); continue; }
        CHECK_STR(m.warning, "");
        CHECK_EQ_INT(m.vertex_count, 5);
        CHECK(indices_are(&m, "012 023 412  012 213 234"));    /* a quad, a triangle, and a strip that begins anew */
        CHECK(m.normals && m.uvs && sound(&m));
        CHECK(m.positions[3] == 4 && m.positions[4] == 0 && m.positions[6] == 4 && m.positions[7] == 4 && m.positions[14] == 3);
        if (m.normals && m.uvs) CHECK(m.normals[2] == 1 && m.normals[12] == 1 && m.uvs[0] == 0.2f && m.uvs[1] == 0.1f && m.uvs[7] == 0.7f);
        CHECK(m.lo.x == 0 && m.hi.x == 4 && m.hi.z == 3);
        pt_mesh_free(&m);
    }
}
static void malformed_ply_is_refused_in_words(void) {
#define HEAD "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACE "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
#define LITTLE "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n" FACE
    static const struct { const char *text, *error; } c[] = {
        { "", "memory:1: \"\" is not ply" }, { "plx\n", "memory:1: \"plx\" is not ply" },
        { "ply", "memory:1: the file ends within its header" }, { HEAD, "memory:7: the file ends within its header" },
        { "ply\nformat ascii1.0\nend_header\n", "memory:2: \"ascii1.0\" is no format: ascii, binary_little_endian or binary_big_endian" },
        { "ply\nelement vertex 1\nproperty int x\nend_header\n", "memory:4: the header tells no format" },
        { "ply\nproperty int x\n", "memory:2: a property of no element" },
        { "ply\nelement vertex\n", "memory:2: an element without a count" },
        { "ply\nelement vertex -3\n", "memory:2: \"-3\" is no count" },
        { "ply\nelement vertex 1234567890123456789\n", "memory:2: \"1234567890123456789\" is no count" },
        { HEAD "element vertex 3\n", "memory:7: a second element vertex" },
        { HEAD "property flot a\n", "memory:7: \"flot\" is no type of a property" },
        { HEAD "property list float int a\n", "memory:7: \"float\" is no type of a list's count" },
        { HEAD "end_header\n", "memory:7: no faces" },
        { "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n" FACE, "memory:8: no vertices with x, y and z" },
        { HEAD FACE "0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "memory:11: the row ends too early" },
        { HEAD FACE "0 0 0\n1 0 a\n0 1 0\n3 0 1 2\n", "memory:11: \"a\" is not a number" },
        { HEAD FACE "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "memory:11: \"nan\" is not a number" },
        { HEAD FACE "0 0 0\n1 0 4e38\n0 1 0\n3 0 1 2\n", "memory:11: 4e+38 is no number for a vertex" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n\n3 0 1 3\n", "memory:14: a face refers to vertex 3, but there are 3, from 0" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n3 0 1 -1\n", "memory:13: a face refers to vertex -1, but there are 3, from 0" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n2 0 1 2\n", "memory:13: a face needs three corners, this has 2" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n3 0 1 1.5\n", "memory:13: a face refers to vertex 1.5, but there are 3, from 0" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n-1\n", "memory:13: a list of -1 does not fit into the file" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n200 0 1 2\n", "memory:13: a list of 200 does not fit into the file" },
        { HEAD FACE "0 0 0\n1 0 1\n0 1 0\n", "memory:13: the row ends too early" },
        { "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n" FACE "0 0 0\n",
            "memory:10: element vertex should have 4000000000 rows, but the file is too short" },
        { "ply\nformat ascii 1.0\n" FACE "3 0 1 2\n", "memory:5: no vertices with x, y and z" },
        { "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\nproperty float x\n"
          "property float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n",
            "memory:10: a face refers to vertex 0, but there are 0, from 0" },
        { LITTLE "12345678901", "memory:byte 169: element vertex should have 1 rows, but the file is too short" },
        { LITTLE "123412341234", "memory:byte 181: element face should have 1 rows, but the file is too short" },
        { LITTLE "123412341234\3\1\1\1\1", "memory:byte 182: a list of 3 does not fit into the file" },
        { LITTLE "123412341234\1\1\1\1\1", "memory:byte 186: a face refers to vertex 1.6843e+7, but there are 1, from 0" },
        { LITTLE "\xff\xff\xff\xff""12341234\1\1\1\1\1", "memory:byte 173: nan is no number for a vertex" } };
    static const char created[] = HEAD "Created by x\n" FACE "0 0 0 7 7\n 1 0 1\n0 1 0\n3 0 1 2";
    pt_mesh m;
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        test_case("text %d", (int)i);
        CHECK_EQ_INT(load_ply(&m, c[i].text, strlen(c[i].text)), PT_ERR_FORMAT);
        CHECK_STR(m.error, c[i].error);
        CHECK(has_place(m.error, "memory"));
    }
    memset(&m, 0, sizeof m);
    if (CHECK_EQ_INT(load_ply(&m, created, sizeof created - 1), PT_OK)) {
        CHECK_STR(m.warning, "memory:7: \"Created\" is no word of a header: the line is skipped");
        CHECK(indices_are(&m, "012") && m.positions[5] == 1);
    }
    pt_mesh_free(&m);
}
static void damaged_ply_does_no_harm(void) {
    unsigned char data[4000];
    pt_rng rng;
    int form, loaded = 0;
    pt_rng_seed(&rng, 7, 2);
    for (form = 0; form < 3; form++) {
        size_t n = form ? ply_bytes(data, ply_sample, form == 2, "\n") : sizeof ply_sample - 1, k, round;
        if (!form) memcpy(data, ply_sample, n);
        for (k = 0; k <= n; k++) {                       /* cut off anywhere */
            pt_mesh m;
            pt_result r = load_ply(&m, data, k);
            test_case("form %d, %d bytes: %s", form, (int)k, m.error);
            CHECK(r == PT_OK ? sound(&m) && k + 2 >= n : r == PT_ERR_FORMAT && has_place(m.error, "memory"));
            if (k == n) CHECK_EQ_INT(r, PT_OK);
            pt_mesh_free(&m);
        }
        for (round = 0; round < 2000; round++) {
            unsigned char *bytes = (unsigned char *)malloc(n + 64), *copy;
            pt_mesh m;
            counter c;
            size_t size;
            if (!bytes) abort();
            memcpy(bytes, data, n);
            size = mutate(&rng, bytes, n);
            copy = exact_copy(bytes, size);
            memset(&m, 0, sizeof m);
            m.allocator = counted(&c);
            if (pt_read_ply_memory(&m, copy, size) == PT_OK) { loaded++; CHECK(sound(&m)); }
            else CHECK(!m.positions && c.live == 0 && has_place(m.error, "memory"));
            CHECK(c.peak < 1000000);
            pt_mesh_free(&m);
            CHECK(c.live == 0 && c.wrong_sizes == 0);
            free(bytes); free(copy);
        }
    }
    CHECK(loaded > 300 && loaded < 5000);
}
static void damaged_materials_do_no_harm(void) {
    static const char obj[] = "v 0 0 0\nusemtl a\nf 1 1 1\nusemtl b\nf 1 1 1\n", mtl[] =
        "newmtl a\nKd .1 .2 .3\nKs 1 1 1\nNs 30\nillum 4\nTf 1 1 1\nd .5\nNi 1.5\nmap_Kd -s 1 2 3 -o 1 1 -mm 0 1 a b.png\nKe 1 2 3\n"
        "newmtl b\nPr .5\nPm 1\nPs .1\nPc .2\nPcr .3\naniso .5\nanisor .5\nmap_bump -bm 2 x.png\nmap_d -imfchan m y\nTr 1\nnorm z\n";
    pt_rng rng;
    int round;
    pt_rng_seed(&rng, 9, 2);
    for (round = 0; round < 4000; round++) {
        unsigned char data[sizeof mtl + 64], *copy;
        pt_mesh m;
        counter c;
        pt_scene *s = NULL;
        size_t size, i;
        memcpy(data, mtl, sizeof mtl - 1);
        size = mutate(&rng, data, sizeof mtl - 1);
        copy = exact_copy(data, size);
        memset(&m, 0, sizeof m);
        m.allocator = counted(&c);
        CHECK_EQ_INT(pt_read_obj_memory(&m, obj, sizeof obj - 1), PT_OK);
        CHECK_EQ_INT(pt_read_mtl_memory(&m, copy, size), PT_OK);
        if (round % 8 == 0) {                            /* whatever comes out, a scene takes it */
            s = pt_scene_create(NULL);
            for (i = 0; i < m.material_count; i++) pt_add_material(s, &m.materials[i].desc);
            CHECK_STR(pt_scene_error(s), "");
            pt_scene_destroy(s);
        }
        pt_mesh_free(&m);
        CHECK(c.live == 0 && c.wrong_sizes == 0);
        free(copy);
    }
}
static void memory_may_run_out_elsewhere(void) {
    static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nmtllib gone.mtl test_mesh_1.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n";
    static const char mtl[] = "newmtl a\nmap_Kd x\nmap_Kd y\nnewmtl b\nmap_Ks z\n";
    int what;
    size_t fail;
    file_write("out/test_mesh_1.mtl", mtl, sizeof mtl - 1);
    file_write("out/test_mesh.tmp", obj, sizeof obj - 1);
    for (what = 0; what < 3; what++) for (fail = 1; fail < 300; fail++) {
        pt_mesh m;
        counter c;
        pt_result r;
        memset(&m, 0, sizeof m);
        m.allocator = counted(&c);
        test_case("%d, allocation %d", what, (int)fail);
        if (what == 2) {
            CHECK_EQ_INT(pt_read_ply_memory(&m, ply_sample, sizeof ply_sample - 1), PT_OK);
            c.fail_at = c.calls + fail;
            r = pt_mesh_smooth(&m, 30);
            CHECK(sound(&m) && m.index_count == 18 && (r == PT_OK || m.vertex_count == 5));
        } else {
            c.fail_at = fail;
            r = what ? pt_read_mesh_memory(&m, ply_sample, sizeof ply_sample - 1) : pt_read_obj(&m, "out/test_mesh.tmp");
            if (r != PT_OK) CHECK(!m.positions && !m.materials && c.live == 0);
        }
        if (r != PT_OK) CHECK(r == PT_ERR_MEMORY && strstr(m.error, "out of memory"));
        pt_mesh_free(&m);
        CHECK(c.live == 0 && c.wrong_sizes == 0);
        if (r == PT_OK) break;
    }
    CHECK(fail > 5 && fail < 300);
    remove("out/test_mesh_1.mtl"); remove("out/test_mesh.tmp");
}
static void the_content_decides(void) {
    pt_mesh m;
    memset(&m, 0, sizeof m);
    file_write("out/test_mesh.tmp", ply_sample, sizeof ply_sample - 1);
    CHECK(pt_read_mesh(&m, "out/test_mesh.tmp") == PT_OK && m.index_count == 18);
    CHECK(pt_read_ply(&m, "out/test_mesh.tmp") == PT_OK && m.index_count == 18);
    CHECK_EQ_INT(pt_read_obj(&m, "out/test_mesh.tmp"), PT_ERR_FORMAT);
    file_write("out/test_mesh.tmp", "v 0 0 0\nf 1 1 1", 15);
    CHECK(pt_read_mesh(&m, "out/test_mesh.tmp") == PT_OK && m.index_count == 3);
    CHECK_EQ_INT(pt_read_ply(&m, "out/test_mesh.tmp"), PT_ERR_FORMAT);
    CHECK_STR(m.error, "out/test_mesh.tmp:1: \"v\" is not ply");
    remove("out/test_mesh.tmp");
    CHECK(pt_read_mesh_memory(&m, "v 0 0 0\nf 1 1 1", 15) == PT_OK && m.index_count == 3);
    CHECK(pt_read_mesh_memory(&m, ply_sample, sizeof ply_sample - 1) == PT_OK && m.index_count == 18);
    CHECK_EQ_INT(pt_read_mesh_memory(&m, "ply\r", 4), PT_ERR_FORMAT);
    CHECK_STR(m.error, "memory:2: the file ends within its header");
    CHECK(pt_read_ply(NULL, "x") == PT_ERR_ARG && pt_read_mesh(&m, NULL) == PT_ERR_ARG);
}

/* ---- smooth normals ---- */

/* A cube whose faces are cut along one diagonal or the other, with the vertices of a face shared (uv) or not. */
static const char cube_text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nvt 0 0\nvt 1 1\n"
    "f 1 3 4 2\nf 6 8 7 5\nf 1/1 2/2 6/1 5/2\nf 7/1 8/1 4/2 3/2\nf 1/2 5/1 7/1 3/1\nf 8/2 6/2 2/1 4/1\n";
static double normal_length(const pt_mesh *m, size_t v) {
    const float *n = m->normals + 3 * v;
    return sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2]);
}
static void a_cube_gets_smooth(void) {
    pt_mesh m;
    size_t i, before;
    int k;
    if (!loads(&m, cube_text)) return;
    before = m.vertex_count;
    CHECK_EQ_INT(pt_mesh_smooth(&m, 0), PT_OK);
    CHECK_EQ_INT(m.vertex_count, before);                /* copies of a corner have all the same normal */
    for (i = 0; i < m.vertex_count && m.normals; i++) for (k = 0; k < 3; k++)     /* by angles, the diagonals do not count */
        CHECK_NEAR(m.normals[3 * i + (size_t)k], (m.positions[3 * i + (size_t)k] > 0.5f ? 1 : -1) / sqrt(3), 1e-6);
    CHECK_EQ_INT(pt_mesh_smooth(&m, 90), PT_OK);         /* just as sharp as allowed */
    CHECK_EQ_INT(m.vertex_count, before);
    CHECK_EQ_INT(pt_mesh_smooth(&m, 89), PT_OK);
    for (i = 0; i < m.index_count; i++) {                /* now each corner has the normal of its face */
        double n[3], l;
        cross(&m, i / 3, n);
        l = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (k = 0; k < 3; k++) CHECK_NEAR(m.normals[3 * (size_t)m.indices[i] + (size_t)k], n[k] / l, 1e-6);
    }
    CHECK(sound(&m) && m.uvs);
    pt_mesh_free(&m);
    if (!loads(&m, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nv 5 5 5\n"
        "f 1 3 4 2\nf 6 8 7 5\nf 1 2 6 5\nf 7 8 4 3\nf 1 5 7 3\nf 8 6 2 4\n")) return;
    CHECK_EQ_INT(pt_mesh_smooth(&m, 30), PT_OK);
    CHECK_EQ_INT(m.vertex_count, 25);                    /* and one that nobody uses */
    CHECK(normal_length(&m, 8) == 0 && sound(&m));
    pt_mesh_free(&m);
}
static void a_sphere_gets_smooth(void) {                 /* in stripes with a seam, its vertices not shared: a soup */
    enum { N = 24 };
    static float p[N * N * 18];
    uint32_t index[N * N * 6], vertices = 0;
    pt_mesh m;
    counter c;
    double worst = 0;
    int i, j, k;
    size_t v;
    for (i = 0; i < N; i++) for (j = 0; j < N; j++) for (k = 0; k < 6; k++) {
        static const int du[6] = { 0, 0, 1, 0, 1, 1 }, dv[6] = { 0, 1, 1, 0, 1, 0 };
        int a = (i + du[k]) % N, b = j + dv[k];
        double st = b == 0 || b == N ? 0 : sin(3.14159265358979 * b / N);
        p[3 * vertices] = (float)(st * cos(6.28318530717959 * a / N));
        p[3 * vertices + 1] = b == 0 ? 1 : b == N ? -1 : (float)cos(3.14159265358979 * b / N);
        p[3 * vertices + 2] = (float)(-st * sin(6.28318530717959 * a / N));
        index[vertices] = vertices;
        vertices++;
    }
    memset(&m, 0, sizeof m);
    m.allocator = counted(&c);
    m.vertex_count = m.index_count = vertices;
    m.positions = (float *)m.allocator.alloc(&c, vertices * 12, 4);
    m.indices = (uint32_t *)m.allocator.alloc(&c, vertices * 4, 4);
    memcpy(m.positions, p, vertices * 12);
    memcpy(m.indices, index, vertices * 4);
    CHECK_EQ_INT(pt_mesh_smooth(&m, 40), PT_OK);
    CHECK_EQ_INT(m.vertex_count, vertices);
    for (v = 0; v < vertices; v++) {
        const float *n = m.normals + 3 * v, *q = m.positions + 3 * v;
        double d = (double)n[0] * (double)q[0] + (double)n[1] * (double)q[1] + (double)n[2] * (double)q[2];
        if (normal_length(&m, v) < 0.5) continue;        /* at the poles one triangle of a square has no area: its corners */
        if (1 - d > worst) worst = 1 - d;
    }
    CHECK(worst < 1e-3);
    pt_mesh_free(&m);
    CHECK(c.live == 0 && c.wrong_sizes == 0);
}
static void smoothing_checks_its_arguments(void) {
    pt_mesh m;
    size_t n;
    CHECK_EQ_INT(pt_mesh_smooth(NULL, 30), PT_ERR_ARG);
    memset(&m, 0, sizeof m);
    CHECK_EQ_INT(pt_mesh_smooth(&m, 30), PT_ERR_ARG);
    CHECK_STR(m.error, "pt_mesh_smooth: a mesh has positions, and three indices a triangle");
    if (!loads(&m, cube_text)) return;
    n = m.vertex_count;
    CHECK(pt_mesh_smooth(&m, -1) == PT_ERR_ARG && pt_mesh_smooth(&m, 181) == PT_ERR_ARG && pt_mesh_smooth(&m, (float)NAN) == PT_ERR_ARG);
    CHECK_STR(m.error, "pt_mesh_smooth: angle_deg must be between 0 and 180");
    m.indices[3] = 1000;
    CHECK_EQ_INT(pt_mesh_smooth(&m, 30), PT_ERR_ARG);
    CHECK(m.vertex_count == n && !m.normals);
    pt_mesh_free(&m);
    if (!loads(&m, "v 3e38 3e38 0\nv -3e38 3e38 0\nv 3e38 -3e38 0\nv 1 1 1\nf 1 2 3\nf 1 2 4\nf 4 4 4\nf 1 2 3 4 1 2\n")) return;
    CHECK_EQ_INT(pt_mesh_smooth(&m, 30), PT_OK);
    CHECK(sound(&m));
    pt_mesh_free(&m);
}

/* ---- several materials in a scene ---- */

static pt_mesh_desc four_triangles(const uint32_t *ids, const pt_material *materials, size_t count) {
    static const float p[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0,  2, 0, 0, 3, 0, 0, 2, 1, 0,  4, 0, 0, 5, 0, 0, 4, 1, 0,
        6, 0, 0, 7, 0, 0, 6, 1, 0 };
    pt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = p; d.vertex_count = 12;
    d.materials = materials; d.material_count = count; d.material_ids = ids;
    return d;
}
static uint32_t material_at(const pt_scene *s, float x) {
    pt_ray r;
    pt_vertex v;
    memset(&r, 0, sizeof r);
    r.org = pt_v3(x + 0.25f, 0.25f, 1); r.dir = pt_v3(0, 0, -1);
    return pt_intersect(s, &r, &v) ? v.material.id : 999;
}
static void triangles_have_their_own_material(void) {
    static const uint32_t ids[4] = { 2, 0, 1, 2 };
    pt_material m[4];
    pt_material_desc d;
    counter c;
    pt_scene_desc sd;
    pt_scene *s, *outer;
    pt_mesh_desc mesh;
    size_t fail;
    int borrow, fine;
    memset(&sd, 0, sizeof sd);
    sd.allocator = counted(&c);
    for (borrow = 0; borrow < 2; borrow++) {
        s = pt_scene_create(&sd);
        memset(&d, 0, sizeof d);
        m[3] = pt_add_material(s, &d);                   /* not of the mesh */
        m[0] = pt_add_material(s, &d);
        d.emission = pt_v3(1, 1, 1);
        m[1] = pt_add_material(s, &d);
        m[2].id = 0;                                     /* none: the default */
        mesh = four_triangles(ids, m, 3);
        mesh.borrow = borrow;
        mesh.material = m[3];
        pt_add_mesh(s, &mesh);
        mesh = four_triangles(NULL, m, 3);
        CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
        CHECK(material_at(s, 0) == 0 && material_at(s, 2) == m[0].id && material_at(s, 4) == m[1].id && material_at(s, 6) == 0);
        CHECK_EQ_INT(s->lights.count, 1);                /* the one triangle that emits */
        if (s->lights.count == 1) CHECK(s->lights.emitters[0].p.x == 4);
        outer = pt_scene_create(&sd);
        pt_add_instance(outer, s, NULL);
        CHECK_EQ_INT(pt_scene_commit(outer), PT_OK);
        CHECK(material_at(outer, 2) == m[0].id && material_at(outer, 4) == m[1].id && outer->lights.count == 1);
        pt_scene_destroy(outer);
        pt_scene_destroy(s);
        CHECK(c.live == 0 && c.wrong_sizes == 0);
    }
    for (fail = 1; fail < 100; fail++) {                 /* memory may run out */
        sd.allocator = counted(&c);
        c.fail_at = fail;
        s = pt_scene_create(&sd);
        d.emission = pt_v3(1, 1, 1);
        m[0] = m[1] = m[2] = pt_add_material(s, &d);
        mesh = four_triangles(ids, m, 3);
        pt_add_mesh(s, &mesh);
        fine = pt_scene_commit(s) == PT_OK;
        pt_scene_destroy(s);
        CHECK(c.live == 0 && c.wrong_sizes == 0);
        if (fine) break;
    }
    CHECK(fail > 6 && fail < 100);
    sd.allocator = counted(&c);
    s = pt_scene_create(&sd);
    memset(&d, 0, sizeof d);
    m[0] = pt_add_material(s, &d);
    mesh = four_triangles(NULL, m, 1);                   /* no ids: the first, unless a material is told */
    pt_add_mesh(s, &mesh);
    CHECK_EQ_INT(pt_scene_commit(s), PT_OK);
    CHECK_EQ_INT(material_at(s, 2), m[0].id);
    pt_scene_destroy(s);
    CHECK(c.live == 0 && c.wrong_sizes == 0);
}
static void wrong_material_ids_are_refused(void) {
    static const uint32_t far_id[4] = { 0, 1, 3, 0 }, fine[4] = { 0, 1, 0, 1 };
    static const pt_material none[3] = { { 0 }, { 0 }, { 0 } }, unknown[2] = { { 0 }, { 7 } };
    const struct { pt_mesh_desc d; const char *error; } c[] = {
        { four_triangles(far_id, none, 3), "pt_add_mesh: material id of triangle 2 is 3, but there are 3 materials" },
        { four_triangles(fine, unknown, 2), "pt_add_mesh: material 7 does not exist, there are 0" },
        { four_triangles(fine, NULL, 2), "pt_add_mesh: materials is NULL" },
        { four_triangles(fine, none, 0), "pt_add_mesh: material_ids without materials" } };
    size_t i;
    for (i = 0; i < sizeof c / sizeof c[0]; i++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_add_mesh(s, &c[i].d);
        CHECK_EQ_INT(pt_scene_commit(s), PT_ERR_ARG);
        CHECK_STR(pt_scene_error(s), c[i].error);
        pt_scene_destroy(s);
    }
}

/* ---- real files ---- */

static void real_meshes_load(void) {
    static const struct { const char *name; size_t vertices, triangles; int normals, uvs; } f[] = {
        { "stanford-bunny", 35947, 69451, 0, 0 }, { "spot", 3225, 5856, 0, 1 }, { "teapot", 3644, 6320, 0, 0 },
        { "suzanne", 507, 968, 1, 0 }, { "rocker-arm", 10044, 20088, 0, 0 } };
    char path[100];
    size_t i;
    int found = 0;
    for (i = 0; i < sizeof f / sizeof f[0]; i++) {
        pt_mesh m;
        counter n;
        sprintf(path, "../shared/data/meshes/%s.obj", f[i].name);
        if (!file_exists(path)) continue;
        found++;
        memset(&m, 0, sizeof m);
        m.allocator = counted(&n);
        test_case("%s", path);
        if (!CHECK_EQ_INT(pt_read_obj(&m, path), PT_OK)) { printf("    %s\n", m.error); continue; }
        CHECK_EQ_INT(m.vertex_count, f[i].vertices);
        CHECK_EQ_INT(m.index_count, 3 * f[i].triangles);
        CHECK(!!m.normals == f[i].normals && !!m.uvs == f[i].uvs && sound(&m));
        pt_mesh_free(&m);
        CHECK(n.live == 0 && n.wrong_sizes == 0);
    }
    if (!found) SKIP("no ../shared/data");
}
/* A file of Debian's assimp-testmodels: loads, or is refused for this reason, in a place that is told. 0: it is not there. */
static int loads_or_is_refused(const char *file, const char *error, size_t *vertices, size_t *triangles) {
    char path[120];
    pt_mesh m;
    sprintf(path, "/usr/share/assimp/models/%s", file);
    if (!file_exists(path)) return 0;
    memset(&m, 0, sizeof m);
    test_case("%s", path);
    CHECK_EQ_INT(strstr(file, ".ply") ? pt_read_ply(&m, path) : pt_read_obj(&m, path), *error ? PT_ERR_FORMAT : PT_OK);
    if (*error) {
        size_t n = strlen(error);
        CHECK(has_place(m.error, path));
        if (strlen(m.error) > n) CHECK_STR(m.error + strlen(m.error) - n, error);
        else FAIL("%s", m.error);
    } else CHECK_STR(m.error, "");
    CHECK(!m.positions || sound(&m));
    *vertices = m.vertex_count; *triangles = m.index_count / 3;
    pt_mesh_free(&m);
    return 1;
}
static void assimp_models_load_or_are_refused_in_words(void) {
    static const struct { const char *name, *error; } f[] = {
        { "WusonOBJ", "" }, { "box", "" }, { "box_longline", "" }, { "box_mat_with_spaces", "" }, { "box_without_lineending", "" },
        { "concave_polygon", "" }, { "cube_mtllib_after_g", "" }, { "cube_usemtl", "" }, { "cube_with_vertexcolors", "" },
        { "cube_with_vertexcolors_uni", "" }, { "empty_mat", "" }, { "multiple_spaces", "" }, { "regr01", "" },
        { "regr_3429812", "" }, { "space_in_material_name", "" }, { "spider", "" }, { "testmixed", "" },
        { "box_UTF16BE", "this is UTF-16 text or no text at all: OBJ is ASCII or UTF-8" },
        { "number_formats", "\"3.1+e2\" is not a number" },      /* which strtod too reads as 3.1 and garbage */
        { "point_cloud", "no faces" }, { "testline", "no faces" }, { "testpoints", "no faces" } };
    char file[60];
    size_t i, vertices, triangles;
    int found = 0;
    for (i = 0; i < sizeof f / sizeof f[0]; i++) {
        sprintf(file, "OBJ/%s.obj", f[i].name);
        found += loads_or_is_refused(file, f[i].error, &vertices, &triangles);
    }
    if (!found) SKIP("no /usr/share/assimp/models/OBJ");
}
static void assimp_ply_models_too(void) {
    static const struct { const char *name; size_t vertices, triangles; const char *error; } f[] = {
        { "PLY/Wuson", 11184, 3732, "" }, { "PLY/cube", 8, 12, "" }, { "PLY/cube_binary", 8, 12, "" }, { "PLY/cube_uv", 24, 12, "" },
        { "PLY/float-color", 3, 1, "" }, { "PLY/issue623", 0, 0, "12: no faces" }, { "PLY/points", 0, 0, "13: no faces" },
        { "PLY/pond.0", 0, 0, "14: no faces" }, { "invalid/empty", 0, 0, "1: \"\" is not ply" } };
    char file[60];
    size_t i, vertices, triangles;
    int found = 0;
    for (i = 0; i < sizeof f / sizeof f[0]; i++) {
        sprintf(file, "%s.ply", f[i].name);
        if (!loads_or_is_refused(file, f[i].error, &vertices, &triangles)) continue;
        found++;
        CHECK(vertices == f[i].vertices && triangles == f[i].triangles);
    }
    if (!found) SKIP("no /usr/share/assimp/models/PLY");
}

void test_mesh(void) {
    RUN(a_triangle);
    RUN(numbers_in_every_form);
    RUN(numbers_round_as_strtof_does);
    RUN(text_in_every_form);
    RUN(very_long_lines);
    RUN(indices_from_the_end);
    RUN(combinations_become_vertices);
    RUN(many_combinations_are_told_apart);
    RUN(polygons_are_covered_once);
    RUN(convex_polygons_are_fans);
    RUN(degenerate_polygons_do_not_hang);
    RUN(random_polygons_do_not_hang);
    RUN(malformed_meshes_are_refused_in_words);
    RUN(unreadable_files_are_told);
    RUN(every_truncation_does_no_harm);
    RUN(damaged_meshes_do_no_harm);
    RUN(memory_may_run_out);
    RUN(faces_tell_their_material);
    RUN(materials_mean_what_phong_meant);
    RUN(other_numbers_of_a_material);
    RUN(maps_of_a_material);
    RUN(malformed_materials_are_warned_of);
    RUN(damaged_materials_do_no_harm);
    RUN(libraries_are_found);
    RUN(ply_in_every_form);
    RUN(malformed_ply_is_refused_in_words);
    RUN(damaged_ply_does_no_harm);
    RUN(memory_may_run_out_elsewhere);
    RUN(the_content_decides);
    RUN(a_cube_gets_smooth);
    RUN(a_sphere_gets_smooth);
    RUN(smoothing_checks_its_arguments);
    RUN(triangles_have_their_own_material);
    RUN(wrong_material_ids_are_refused);
    RUN(real_meshes_load);
    RUN(assimp_models_load_or_are_refused_in_words);
    RUN(assimp_ply_models_too);
}
