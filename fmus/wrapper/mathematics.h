/* The mathematical functions that a model may call, of the FMU's own: musl's. Whatever C library an FMU meets, on whatever
   platform, its numbers have the same bits. What is exact everywhere (sqrt, floor, ceil, fabs) is left to the platform.
   The compiler must not contract products and sums: clang and gcc do not with -ffp-contract=off. */
#ifndef MATHEMATICS_H
#define MATHEMATICS_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

/* Long functions that stand apart from a model's straight code, which would have to go around them. */
#ifdef __GNUC__
#define APART __attribute__((noinline))
#define RARELY(condition) __builtin_expect(!!(condition), 0)
#else
#define APART
#define RARELY(condition) (condition)
#endif

static inline uint64_t musl_asuint64(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double musl_asdouble(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#define musl_extract_words(high, low, x) ((high) = (uint32_t)(musl_asuint64(x) >> 32), (low) = (uint32_t)musl_asuint64(x))
#define musl_get_high_word(high, x) ((high) = (uint32_t)(musl_asuint64(x) >> 32))
#define musl_get_low_word(low, x) ((low) = (uint32_t)musl_asuint64(x))
#define musl_insert_words(x, high, low) ((x) = musl_asdouble((uint64_t)(uint32_t)(high) << 32 | (uint32_t)(low)))
#define musl_set_high_word(x, high) musl_insert_words(x, high, musl_asuint64(x))
#define musl_set_low_word(x, low) musl_insert_words(x, musl_asuint64(x) >> 32, low)

/* x times 2 to the power of n, for n within the normal exponents. */
static inline double musl_scale(double x, int n)
{
    return x * musl_asdouble((uint64_t)(0x3ff + n) << 52);
}

/* What is given where a result is too large, too small or none. */
static inline double musl_math_oflow(uint32_t negative)
{
    return negative ? -INFINITY : INFINITY;
}

static inline double musl_math_uflow(uint32_t negative)
{
    return negative ? -0.0 : 0.0;
}

static inline double musl_math_divzero(uint32_t negative)
{
    return negative ? -INFINITY : INFINITY;
}

static inline double musl_math_invalid(double x)
{
    const double nothing = (x - x) / (x - x);
    return x != x ? x : nothing;
}

/* fmin and fmax; some platforms call a function for them. */
static inline double smaller(double a, double b)
{
    return a < b || b != b ? a : b;
}

static inline double larger(double a, double b)
{
    return a > b || b != b ? a : b;
}

#include "musl_tables.c"
#include "musl_powers.c"
#include "musl_angles.c"

#endif
