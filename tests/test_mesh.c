/* Wavefront OBJ. */
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
static void assimp_models_load_or_are_refused_in_words(void) {
    static const struct { const char *name, *error; } f[] = {
        { "WusonOBJ", "" }, { "box", "" }, { "box_longline", "" }, { "box_mat_with_spaces", "" },
            { "box_without_lineending", "" },
        { "concave_polygon", "" }, { "cube_mtllib_after_g", "" }, { "cube_usemtl", "" }, { "cube_with_vertexcolors", "" },
        { "cube_with_vertexcolors_uni", "" }, { "empty_mat", "" }, { "multiple_spaces", "" }, { "regr01", "" },
            { "regr_3429812", "" },
        { "space_in_material_name", "" }, { "spider", "" }, { "testmixed", "" },
        { "box_UTF16BE", "this is UTF-16 text or no text at all: OBJ is ASCII or UTF-8" },
        { "number_formats", "\"3.1+e2\" is not a number" },      /* which strtod too reads as 3.1 and garbage */
        { "point_cloud", "no faces" }, { "testline", "no faces" }, { "testpoints", "no faces" } };
    char path[100];
    size_t i;
    int found = 0;
    for (i = 0; i < sizeof f / sizeof f[0]; i++) {
        pt_mesh m;
        sprintf(path, "/usr/share/assimp/models/OBJ/%s.obj", f[i].name);
        if (!file_exists(path)) continue;
        found++;
        memset(&m, 0, sizeof m);
        test_case("%s", path);
        CHECK_EQ_INT(pt_read_obj(&m, path), f[i].error[0] ? PT_ERR_FORMAT : PT_OK);
        if (f[i].error[0]) {
            CHECK(has_place(m.error, path));
            if (strlen(m.error) > strlen(f[i].error)) CHECK_STR(m.error + strlen(m.error) - strlen(f[i].error), f[i].error);
        } else CHECK_STR(m.error, "");
        CHECK(!m.positions || sound(&m));
        pt_mesh_free(&m);
    }
    if (!found) SKIP("no /usr/share/assimp/models/OBJ");
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
    RUN(real_meshes_load);
    RUN(assimp_models_load_or_are_refused_in_words);
}
