/* test.h - a small test harness. A chapter of pt.h has a file of tests:

       #define PT_IMPLEMENTATION
       #define PT_STATIC
       #include "../pt.h"
       #include "test.h"

       static void addition(void) { CHECK(1 + 1 == 2); CHECK_NEAR(0.1 + 0.2, 0.3, 1e-15); }
       void test_math(void) { RUN(addition); }

   and a line in the list of chapters in test_main.c, which also holds the code behind these macros. A failing check says
   where, what and the values, and the test goes on; each check is 1 if it held, so if (!CHECK(p)) return; leaves early.
   A test that never checks anything fails. */
#ifndef TEST_H
#define TEST_H
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RUN(name)             test_run(#name, name)
#define CHECK(condition)      test_check(!!(condition), __FILE__, __LINE__, #condition)
#define CHECK_EQ_INT(a, b)    test_int((long long)(a), (long long)(b), __FILE__, __LINE__, #a " == " #b)
#define CHECK_EQ_U32(a, b)    test_u32((uint32_t)(a), (uint32_t)(b), __FILE__, __LINE__, #a " == " #b)
#define CHECK_STR(a, b)       test_str(a, b, __FILE__, __LINE__, #a " is " #b)
/* |a - b| <= tolerance; NaN is near nothing, an infinity only to itself. */
#define CHECK_NEAR(a, b, tol) test_near((double)(a), (double)(b), (double)(tol), __FILE__, __LINE__, #a " near " #b)
/* A statistical test gave the p-value p. It fails below a level at which the whole suite, were the seeds not fixed, would
   fail by chance once in a hundred runs: 0.01 overall, Sidak-corrected for TEST_P_VALUES tests. test_main.c counts them. */
#define CHECK_P(p)            test_p((double)(p), __FILE__, __LINE__, #p)
#define TEST_P_VALUES 4000
#define FAIL(...)             test_fail(__FILE__, __LINE__, __VA_ARGS__)    /* FAIL("row %d is %g", i, x) */
#define SKIP(reason)          do { test_skip(reason); return; } while (0)   /* this test cannot run here */

void test_run(const char *name, void (*f)(void));
int  test_check(int ok, const char *file, int line, const char *what);
int  test_int(long long a, long long b, const char *file, int line, const char *what);
int  test_u32(uint32_t a, uint32_t b, const char *file, int line, const char *what);
int  test_str(const char *a, const char *b, const char *file, int line, const char *what);
int  test_near(double a, double b, double tolerance, const char *file, int line, const char *what);
int  test_p(double p, const char *file, int line, const char *what);
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
int  test_fail(const char *file, int line, const char *format, ...);
void test_skip(const char *reason);
/* "in ..." is added to failures from here on in this test: which case of a loop it was. */
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
void test_case(const char *format, ...);
#endif
