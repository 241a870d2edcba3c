/* What the programs that call at random share: what they draw, and what they check. */
#ifndef FUZZ_H
#define FUZZ_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guid.h"

#define INSTANCES 3
#define STATES 4
#define MOST 8
#define BLOB 8192

static uint64_t seed;
static long refusals;
static char foreign[BLOB], blob[BLOB], before[BLOB], after[BLOB];
static size_t blob_size;

static unsigned pick(unsigned n) /* xorshift64* */
{
    seed ^= seed >> 12, seed ^= seed << 25, seed ^= seed >> 27;
    return (unsigned)((seed * UINT64_C(2685821657736338717)) >> 33) % n;
}

static void check(int good, const char *what)
{
    if (!good) {
        fprintf(stderr, "%s\n", what);
        abort();
    }
}

static double number(void)
{
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0, -0.0, 1e300, -1e300, 1e-300, 4.9e-324};
    switch (pick(4)) {
    case 0: return odd[pick(sizeof odd / sizeof *odd)];
    case 1: return pick(2000) - 1000.0;
    case 2: return (pick(2) ? 1 : -1) * pow(10, pick(16) - 8.0);
    default: return pick(1000) / 1000.0;
    }
}

static double step(void)
{
    static const double some[] = {0.01, 0.01, 0.01, 0.001, 0.02, 1e-9, 0, -0.01, NAN, INFINITY, 1e300};
    return some[pick(sizeof some / sizeof *some)];
}

static const char *text(void)
{
    static const char *const some[] = {"", "x", "logStatusError", "logAll", FMU_GUID, "%s%n", NULL};
    return some[pick(sizeof some / sizeof *some)];
}

static void said(const char *category, const char *sentence)
{
    check(category && strlen(sentence) > 5 && !strchr(sentence, '%') && !strchr(sentence, '#'), sentence);
    refusals++;
}

static void all_finite(const double x[], size_t n)
{
    for (size_t i = 0; i < n; i++)
        check(isfinite(x[i]), "not finite");
}

#endif
