/* Runs the tests, all or those named. The last line is "N passed, N failed", with ", N skipped" if there were any. */
#include "test.h"
#include <stdarg.h>
#include <time.h>

/* A chapter a line, in the order of pt.h: to add one, write test_<chapter>.c, which defines void test_<chapter>(void),
   and move its name from the comment to the list. */
#ifdef TEST_THREADS                                      /* those alone that start threads */
#define CHAPTERS(X) X(bvh) X(scene) X(render)
#else
#define CHAPTERS(X) \
    X(math) X(random) X(warp) X(spectrum) X(shape) X(bvh) X(kernel) X(texture) X(medium) X(microfacet) X(measured) X(bsdf) X(material) X(light) X(scene) X(guide) \
    X(mixture) X(path) X(nee) X(camera) X(film) X(render) X(image) X(mesh)
#endif

#define DECLARE(name) void test_##name(void);
CHAPTERS(DECLARE)
#define ENTRY(name) { #name, test_##name },
static const struct { const char *name; void (*run)(void); } chapters[] = { CHAPTERS(ENTRY) };
#define CHAPTER_COUNT ((int)(sizeof chapters / sizeof chapters[0]))
#define SHOWN 5                                          /* failures a test, in words */

static enum { LISTING, MATCHING, RUNNING } mode;
static int passed, failed, skipped, p_values, verbose;
static const char *chapter;
static char **names;                                     /* the command line's, none = all */
static int name_count, named[64];                        /* how often each was found */
static struct { const char *name, *skipped; int checks, failures; char in[200]; } test;    /* the running one */

static int wanted(const char *name) {
    int i, found = name_count == 0;
    for (i = 0; i < name_count; i++)
        if (!strcmp(names[i], name) || !strcmp(names[i], chapter)) { found = 1; named[i]++; }
    return found;
}

void test_run(const char *name, void (*f)(void)) {
    clock_t start = clock();
    if (mode == LISTING) { printf("    %s\n", name); return; }
    if (!wanted(name) || mode == MATCHING) return;
    memset(&test, 0, sizeof test);
    test.name = name;
    if (verbose) { printf("  %s ...", name); fflush(stdout); }
    f();
    if (!test.checks && !test.skipped) FAIL("the test checked nothing");
    if (test.failures > SHOWN) printf("    ... %d more like it\n", test.failures - SHOWN);
    if (test.failures) failed++;
    else if (test.skipped) skipped++;
    else passed++;
    if (test.skipped) printf("  %s skipped: %s\n", name, test.skipped);
    else if (verbose) printf("%s %.2f s\n", test.failures ? "  failed," : "", (double)(clock() - start) / CLOCKS_PER_SEC);
    fflush(stdout);
}

static int fails(const char *file, int line) {           /* counts a failure; 1 if it shall be shown */
    test.checks++;
    if (test.failures++ == 0) printf("%s  FAIL %s\n", verbose ? "\n" : "", test.name);
    if (test.failures > SHOWN) return 0;
    printf("    %s:%d: %s%s%s", file, line, test.in[0] ? "in " : "", test.in, test.in[0] ? ": " : "");
    return 1;
}
int test_check(int ok, const char *file, int line, const char *what) {
    test.checks++;
    if (!ok && fails(file, line)) printf("%s\n", what);
    return ok;
}
int test_int(long long a, long long b, const char *file, int line, const char *what) {
    test.checks++;
    if (a != b && fails(file, line)) printf("%s: %lld, not %lld\n", what, a, b);
    return a == b;
}
int test_u32(uint32_t a, uint32_t b, const char *file, int line, const char *what) {
    test.checks++;
    if (a != b && fails(file, line)) printf("%s: 0x%08lx, not 0x%08lx\n", what, (unsigned long)a, (unsigned long)b);
    return a == b;
}
int test_str(const char *a, const char *b, const char *file, int line, const char *what) {
    int ok = a && b ? !strcmp(a, b) : a == b;
    test.checks++;
    if (!ok && fails(file, line)) printf("%s: \"%s\", not \"%s\"\n", what, a ? a : "(null)", b ? b : "(null)");
    return ok;
}
int test_near(double a, double b, double tolerance, const char *file, int line, const char *what) {
    int ok = a == b || fabs(a - b) <= tolerance;
    test.checks++;
    if (!ok && fails(file, line)) printf("%s: %.9g, not %.9g (by %.3g, %.3g allowed)\n", what, a, b, a - b, tolerance);
    return ok;
}
int test_p(double p, const char *file, int line, const char *what) {
    double level = -expm1(log1p(-0.01) / TEST_P_VALUES);
    test.checks++;
    p_values++;
    if (!(p >= level) && fails(file, line)) printf("%s is %.3g, significant at %.3g\n", what, p, level);
    return p >= level;
}
int test_fail(const char *file, int line, const char *format, ...) {
    va_list args;
    if (!fails(file, line)) return 0;
    va_start(args, format);
    vprintf(format, args);
    va_end(args);
    printf("\n");
    return 0;
}
void test_skip(const char *reason) { test.skipped = reason; }
void test_case(const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(test.in, sizeof test.in, format, args);
    va_end(args);
}

static void all_chapters(void) {
    int i;
    for (i = 0; i < CHAPTER_COUNT; i++) {
        int before[3];
        clock_t start = clock();
        before[0] = passed; before[1] = failed; before[2] = skipped;
        chapter = chapters[i].name;
        if (mode == LISTING) printf("%s\n", chapter);
        chapters[i].run();
        if (mode != RUNNING || passed + failed + skipped == before[0] + before[1] + before[2]) continue;
        printf("%-8s %3d passed", chapter, passed - before[0]);
        if (failed > before[1]) printf(", %d FAILED", failed - before[1]);
        if (skipped > before[2]) printf(", %d skipped", skipped - before[2]);
        printf("  %.2f s\n", (double)(clock() - start) / CLOCKS_PER_SEC);      /* of processor time */
        fflush(stdout);
    }
}

static int usage(FILE *to, const char *program) {
    fprintf(to, "usage: %s [-v] [chapter or test ...]\n"
                "Runs the tests of the chapters of pt.h: all, or those named. The last line is \"N passed, N failed\",\n"
                "with \", N skipped\" if there were any. Exit code: 0 none failed, 1 some did, 2 a bad argument.\n"
                "  --list      the names of all chapters and tests\n"
                "  -v          a line a test, before it runs\n"
                "  -h, --help  this text\n", program);
    return to == stdout ? 0 : 2;
}

int main(int argc, char **argv) {
    int i;
    names = argv + 1;
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h")) return usage(stdout, argv[0]);
        if (!strcmp(argv[i], "--list")) { mode = LISTING; all_chapters(); return 0; }
        if (!strcmp(argv[i], "-v")) verbose = 1;
        else if (argv[i][0] == '-') {
            fprintf(stderr, "%s: unknown option '%s' (try --help)\n", argv[0], argv[i]);
            return 2;
        } else if (name_count < 64) names[name_count++] = argv[i];
        else { fprintf(stderr, "%s: more than 64 names\n", argv[0]); return 2; }
    }
    mode = MATCHING;
    all_chapters();
    for (i = 0; i < name_count; i++)
        if (!named[i]) {
            fprintf(stderr, "%s: no chapter or test is called '%s' (--list shows them)\n", argv[0], names[i]);
            return 2;
        }
    mode = RUNNING;
    all_chapters();
    if (p_values > TEST_P_VALUES) {                      /* the level is no longer what it claims */
        printf("FAIL: %d statistical tests, but TEST_P_VALUES in test.h is %d\n", p_values, TEST_P_VALUES);
        failed++;
    }
    printf("%d passed, %d failed", passed, failed);
    if (skipped) printf(", %d skipped", skipped);
    printf("\n");
    return failed != 0;
}
