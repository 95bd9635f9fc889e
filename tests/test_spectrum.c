/* >>spectrum: the colours of wavelengths and dispersion. */
#define PT_IMPLEMENTATION
#define PT_STATIC
#include "../pt.h"
#include "test.h"
#include "stats.h"
#include "scenes.h"
#include "surfaces.h"

/* The mean of c / p is white, no c is negative, wavelengths are in range and fall where p says. */
static void colors_of_wavelengths(void) {
    static pti_spectrum s;
    static double count[PTI_WAVELENGTHS];
    stats_cell cells[PTI_WAVELENGTHS];
    double mean[2][3] = { { 0, 0, 0 }, { 0, 0, 0 } };
    int i, n = 1 << 18, cell;
    pti_spectrum_build(&s);
    for (i = 0; i < PTI_WAVELENGTHS; i++) {
        CHECK(s.color[i].x >= 0 && s.color[i].y >= 0 && s.color[i].z >= 0 && pti_largest(s.color[i]) > 0);
        mean[0][0] += (double)s.color[i].x / PTI_WAVELENGTHS; mean[0][1] += (double)s.color[i].y / PTI_WAVELENGTHS; mean[0][2] += (double)s.color[i].z / PTI_WAVELENGTHS;
    }
    for (i = 0; i < n; i++) {
        pt_vec3 w;
        float nm = pti_sample_wavelength(&s, ((float)i + 0.5f) / (float)n, &w);
        cell = (int)((nm - PTI_SHORTEST) / (PTI_LONGEST - PTI_SHORTEST) * PTI_WAVELENGTHS);
        if (!(nm >= PTI_SHORTEST && nm < PTI_LONGEST && w.x >= 0 && w.y >= 0 && w.z >= 0)) { FAIL("%g nm, %g %g %g", (double)nm, (double)w.x, (double)w.y, (double)w.z); return; }
        count[cell]++;
        mean[1][0] += (double)w.x / n; mean[1][1] += (double)w.y / n; mean[1][2] += (double)w.z / n;
        CHECK_NEAR(w.x + w.y + w.z, 3, 1e-3);            /* p is in proportion to r + g + b */
    }
    for (i = 0; i < 2; i++) {
        test_case(i ? "samples" : "table");
        CHECK_NEAR(mean[i][0], 1, i ? 1e-3 : 1e-5); CHECK_NEAR(mean[i][1], 1, i ? 1e-3 : 1e-5); CHECK_NEAR(mean[i][2], 1, i ? 1e-3 : 1e-5);
    }
    for (i = 0; i < PTI_WAVELENGTHS; i++) {
        cells[i].observed = count[i];
        cells[i].expected = (double)n / PTI_WAVELENGTHS * (double)(s.color[i].x + s.color[i].y + s.color[i].z) / 3;
    }
    CHECK(stats_chi2(cells, PTI_WAVELENGTHS) > 0.5);     /* better than chance: the numbers were even */
    CHECK(pti_wavelength_color(450).z > pti_wavelength_color(450).x && pti_wavelength_color(540).y > pti_wavelength_color(540).x);
    CHECK(pti_wavelength_color(620).x > pti_wavelength_color(620).y && pti_wavelength_color(620).z < 0.05f);
}
static void index_of_wavelengths(void) {                 /* ior at the line d, and Abbe's number */
    static const float ior[] = { 1.5168f, 1.7f, 2.4f, 0.8f }, abbe[] = { 64.2f, 25, 10, 200 };
    pt_material_desc d;
    int i;
    memset(&d, 0, sizeof d);
    for (i = 0; i < 4; i++) {
        double nd, nf, nc;
        d.ior = ior[i]; d.abbe = abbe[i];
        nd = (double)pti_index_at(&d, 587.56f); nf = (double)pti_index_at(&d, 486.13f); nc = (double)pti_index_at(&d, 656.27f);
        test_case("ior %g, abbe %g", (double)ior[i], (double)abbe[i]);
        CHECK_NEAR(nd, ior[i], 1e-6);
        CHECK_NEAR((nd - 1) / (nf - nc), abbe[i], 2e-3 * (double)abbe[i]);
        CHECK((nf - nc) * (nd - 1) > 0);
        CHECK(pti_index_at(&d, 0) == ior[i]);
        d.abbe = 0;
        CHECK(pti_index_at(&d, 450) == ior[i]);
    }
}
/* No index that may be asked for becomes senseless. */
static void index_stays_an_index(void) {
    static const float ior[] = { 0.01f, 0.3f, 0.7f, 1, 1.01f, 1.5f, 100 }, abbe[] = { 1, 3, 20 };
    pt_material_desc d;
    int i, k, w;
    memset(&d, 0, sizeof d);
    for (i = 0; i < 7; i++) for (k = 0; k < 3; k++) for (w = 390; w <= 710; w += 20) {
        float n;
        d.ior = ior[i]; d.abbe = abbe[k];
        n = pti_index_at(&d, (float)w);
        test_case("ior %g, abbe %g, %d nm: %g", (double)ior[i], (double)abbe[k], w, (double)n);
        CHECK(n > 0 && n < 1000);
    }
}
static void snell_by_wavelength(void) {
    pt_scene *s = pt_scene_create(NULL);
    pt_material id = pt_add_material(s, &(pt_material_desc){ .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.6f, .abbe = 20 });
    double last = 0;
    int nm, side;
    if (commit(s)) for (side = 1; side >= -1; side -= 2) for (last = 0, nm = 400; nm <= 700; nm += 20) {
        pt_vertex x = vertex_at(0.8 * side, 0.3);
        pt_scatter out;
        double B = 0.6 / (20 * (1 / (486.13 * 486.13) - 1 / (656.27 * 656.27))), n = 1.6 + B * (1 / ((double)nm * nm) - 1 / (587.56 * 587.56)), r;
        x.wavelength = (float)nm;
        test_case("%d nm, side %d", nm, side);
        if (side < 0) n = 1 / n;
        if (!CHECK(sample_of(s->materials + id.id, &x, 0.99999994f, 0.5f, 0.5f, &out) && out.delta)) continue;
        r = sqrt((double)(out.wi.x * out.wi.x + out.wi.y * out.wi.y));
        if (0.6 / n >= 1) { CHECK(pti_same_side(&x, x.wo, out.wi)); continue; }      /* totally reflected */
        CHECK(!pti_same_side(&x, x.wo, out.wi));
        CHECK_NEAR(r, 0.6 / n, 2e-6);
        CHECK(last == 0 || (r - last) * side > 0);       /* blue is bent most */
        last = r;
    }
    CHECK(s->materials[id.id].disperses);
    pt_scene_destroy(s);
}
/* A plate between parallel faces under a white sky is white; so are a ball, and a mix of it. Channels alone, for c / p is noise. */
static void white_stays_white(void) {
    static float rgb[24 * 24 * 3];
    int k, i, c;
    for (k = 0; k < 4; k++) {
        pt_scene *s = pt_scene_create(NULL);
        pt_render_desc d = view(pt_v3(1, 3, 2), pt_v3(0, 0, 0), 10, 24, 256);
        pt_material_desc glassy = { .bsdf = PT_BSDF_DIELECTRIC, .ior = 1.5f, .abbe = 15 }, mixed = { .bsdf = PT_BSDF_MIX, .mix = 0.5f };
        pt_material m;
        stats_moments mean[3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
        if (k == 2) { glassy.bsdf = PT_BSDF_PRINCIPLED; glassy.transmission = 1; glassy.color = pt_v3(1, 1, 1); }
        m = pt_add_material(s, &glassy);
        mixed.a = m; mixed.b = diffuse(s, 1);
        if (k == 3) m = pt_add_material(s, &mixed);
        if (k == 0) pt_add_box(s, pt_v3(-5, -0.5f, -5), pt_v3(5, 0, 5), NULL, m);
        else pt_add_sphere(s, pt_v3(0, 0, 0), 1, m);
        sky(s, 1);
        d.max_depth = 1000;
        if (commit(s) && render(s, &d, rgb, NULL)) {
            for (i = 0; i < 24 * 24; i++) for (c = 0; c < 3; c++) stats_push(mean + c, (double)rgb[3 * i + c]);
            for (c = 0; c < 3; c++) {
                test_case("scene %d, channel %d", k, c);
                CHECK(stats_error(mean + c) > 1e-6);     /* wavelengths were drawn */
                CHECK(stats_error(mean + c) < 4e-3);
                CHECK_P(stats_t_test(mean + c, 1));
            }
        }
        pt_scene_destroy(s);
    }
}

void test_spectrum(void) {
    RUN(colors_of_wavelengths);
    RUN(index_of_wavelengths);
    RUN(index_stays_an_index);
    RUN(snell_by_wavelength);
    RUN(white_stays_white);
}
