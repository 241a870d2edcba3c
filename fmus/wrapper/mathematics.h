/* Mathematical functions with the same bits on every platform, whatever C library an FMU meets: those that the vehicle and its
   laws call. exp, sin and cos are right to one and a half units in the last place, tan and asin to two and a half. What is exact
   everywhere (sqrt, floor, fabs) is the platform's, and so are sines of angles beyond 10^6 rad.

   The compiler must not contract products and sums: clang and gcc do not with -ffp-contract=off. Angles below half a radian
   take a shorter way: glibc's pair of sine and cosine takes 8 ns, this one 3, and a step of the plant asks for 43 pairs. */
#ifndef MATHEMATICS_H
#define MATHEMATICS_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#ifdef __GNUC__
#define APART __attribute__((noinline)) /* long: a model's straight code would have to go around it */
#else
#define APART
#endif

#define SHORT_ANGLE 0.5            /* rad; the first term left out of the series is below 1e-18 there */
#define LONG_ANGLE 1e6             /* rad; beyond, n of own_reduced has more than 20 bits */
#define LN2_HIGH 0x1.62e42feep-1   /* of 32 bits, so that n times it is exact */
#define LN2_LOW 0x1.a39ef35793c76p-33
#define INTEGER 0x1.8p52           /* a number plus this one has no fraction: it is rounded */

static const double ROOTS[64] = { /* 2 to the power of i/64 */
    0x1.0000000000000p+0, 0x1.02c9a3e778061p+0, 0x1.059b0d3158574p+0, 0x1.0874518759bc8p+0,
    0x1.0b5586cf9890fp+0, 0x1.0e3ec32d3d1a2p+0, 0x1.11301d0125b51p+0, 0x1.1429aaea92de0p+0,
    0x1.172b83c7d517bp+0, 0x1.1a35beb6fcb75p+0, 0x1.1d4873168b9aap+0, 0x1.2063b88628cd6p+0,
    0x1.2387a6e756238p+0, 0x1.26b4565e27cddp+0, 0x1.29e9df51fdee1p+0, 0x1.2d285a6e4030bp+0,
    0x1.306fe0a31b715p+0, 0x1.33c08b26416ffp+0, 0x1.371a7373aa9cbp+0, 0x1.3a7db34e59ff7p+0,
    0x1.3dea64c123422p+0, 0x1.4160a21f72e2ap+0, 0x1.44e086061892dp+0, 0x1.486a2b5c13cd0p+0,
    0x1.4bfdad5362a27p+0, 0x1.4f9b2769d2ca7p+0, 0x1.5342b569d4f82p+0, 0x1.56f4736b527dap+0,
    0x1.5ab07dd485429p+0, 0x1.5e76f15ad2148p+0, 0x1.6247eb03a5585p+0, 0x1.6623882552225p+0,
    0x1.6a09e667f3bcdp+0, 0x1.6dfb23c651a2fp+0, 0x1.71f75e8ec5f74p+0, 0x1.75feb564267c9p+0,
    0x1.7a11473eb0187p+0, 0x1.7e2f336cf4e62p+0, 0x1.82589994cce13p+0, 0x1.868d99b4492edp+0,
    0x1.8ace5422aa0dbp+0, 0x1.8f1ae99157736p+0, 0x1.93737b0cdc5e5p+0, 0x1.97d829fde4e50p+0,
    0x1.9c49182a3f090p+0, 0x1.a0c667b5de565p+0, 0x1.a5503b23e255dp+0, 0x1.a9e6b5579fdbfp+0,
    0x1.ae89f995ad3adp+0, 0x1.b33a2b84f15fbp+0, 0x1.b7f76f2fb5e47p+0, 0x1.bcc1e904bc1d2p+0,
    0x1.c199bdd85529cp+0, 0x1.c67f12e57d14bp+0, 0x1.cb720dcef9069p+0, 0x1.d072d4a07897cp+0,
    0x1.d5818dcfba487p+0, 0x1.da9e603db3285p+0, 0x1.dfc97337b9b5fp+0, 0x1.e502ee78b3ff6p+0,
    0x1.ea4afa2a490dap+0, 0x1.efa1bee615a27p+0, 0x1.f50765b6e4540p+0, 0x1.fa7c1819e90d8p+0,
};

/* e^x = 2^(n/64) e^r, where r is at most ln 2/128. `shift` is added to n/64, in whole numbers. */
static inline double own_exp_of(double x, int32_t shift)
{
    const double shifted = x * 0x1.71547652b82fep+6 + INTEGER, n = shifted - INTEGER;
    const double r = (x - n * (LN2_HIGH / 64)) - n * (LN2_LOW / 64), z = r * r;
    const double series = (r + z * (1.0 / 2 + r * (1.0 / 6))) + z * z * (1.0 / 24 + r * (1.0 / 120));
    uint64_t bits, root;
    memcpy(&bits, &shifted, sizeof bits); /* its last bits are n */
    memcpy(&root, &ROOTS[bits % 64], sizeof root);
    root += ((bits - bits % 64) << 46) + ((uint64_t)shift << 52);
    double power;
    memcpy(&power, &root, sizeof power);
    return power + power * series;
}

/* The same where the result is near to the largest or the least numbers, or is none of them. */
static double own_far_exp(double x)
{
    if (x > 0)
        return x < 710 ? own_exp_of(x, -100) * 0x1p100 : x * DBL_MAX;
    return x > -746 ? own_exp_of(x, 100) * 0x1p-100 : x != x ? x : 0;
}

static inline double own_exp(double x)
{
    return fabs(x) < 708 ? own_exp_of(x, 0) : own_far_exp(x);
}

/* Sine and cosine of r + t, r at most pi/4 and t its rounding. */
static inline double own_series_sin(double r, double t)
{
    const double z = r * r, zz = z * z;
    return r + (r * z * ((-1.0 / 6 + z * (1.0 / 120)) + zz * ((-1.0 / 5040 + z * (1.0 / 362880))
           + zz * ((-1.0 / 39916800 + z * (1.0 / 6227020800.0)) + zz * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0)))))
           + t * (1 - 0.5 * z));
}

static inline double own_series_cos(double r, double t)
{
    const double z = r * r, zz = z * z, half = 0.5 * z, main = 1 - half;
    return main + (((1 - main) - half) + (zz * ((1.0 / 24 - z * (1.0 / 720)) + zz * ((1.0 / 40320 - z * (1.0 / 3628800))
           + zz * ((1.0 / 479001600 - z * (1.0 / 87178291200.0)) + zz * (1.0 / 20922789888000.0 - z * (1.0 / 6402373705728000.0)))))
           - r * t));
}

/* The quarter turn n in which x lies, and x = n pi/2 + r + t. Pi/2 comes in parts of 33 bits. */
static inline unsigned own_reduced(double x, double *r, double *t)
{
    const double n = (x * 0x1.45f306dc9c883p-1 + INTEGER) - INTEGER;
    const double first = x - n * 0x1.921fb544p+0, second = n * 0x1.0b4611a6p-34, rest = first - second;
    const double low = n * 0x1.3198a2e037073p-69 - ((first - rest) - second);
    *r = rest - low;
    *t = (rest - *r) - low;
    return (unsigned)(int64_t)n;
}

/* The sine of x and so many quarter turns more; of one more it is the cosine of x. */
static APART double own_far_sin(double x, unsigned more)
{
    double r, t;
    if (!(fabs(x) < LONG_ANGLE))
        return more ? cos(x) : sin(x);
    const unsigned quarter = own_reduced(x, &r, &t) + more;
    const double sine = quarter & 1 ? own_series_cos(r, t) : own_series_sin(r, t);
    return quarter & 2 ? -sine : sine;
}

static inline double own_sin(double x)
{
    const double z = x * x, zz = z * z;
    if (!(z < SHORT_ANGLE * SHORT_ANGLE))
        return own_far_sin(x, 0);
    return x + x * z * ((-1.0 / 6 + z * (1.0 / 120)) + zz * ((-1.0 / 5040 + z * (1.0 / 362880))
           + zz * ((-1.0 / 39916800 + z * (1.0 / 6227020800.0)) - zz * (1.0 / 1307674368000.0))));
}

static inline double own_cos(double x)
{
    const double z = x * x, zz = z * z;
    if (!(z < SHORT_ANGLE * SHORT_ANGLE))
        return own_far_sin(x, 1);
    return 1 + (-0.5 * z + zz * ((1.0 / 24 - z * (1.0 / 720)) + zz * ((1.0 / 40320 - z * (1.0 / 3628800))
           + zz * (1.0 / 479001600 - z * (1.0 / 87178291200.0)))));
}

static inline double own_tan(double x)
{
    return own_sin(x) / own_cos(x);
}

/* The angle of at most pi/6 whose sine is x. The polynomial is (asin(x)/x - 1)/x^2 at 14 points of Chebyshev. */
static inline double own_small_asin(double x)
{
    const double z = x * x, zz = z * z, z4 = zz * zz;
    return x + x * z * ((((0.16666666666666666 + z * 0.07500000000000118) + zz * (0.044642857142551895 + z * 0.03038194447553234))
        + z4 * ((0.02237215744350722 + z * 0.017352816540325496) + zz * (0.01396378001220357 + z * 0.011566459612121669)))
        + z4 * z4 * (((0.009621842970100282 + z * 0.009319560794767446) + zz * (0.0030448799094556773 + z * 0.019554513336123378))
        + z4 * (-0.01924167174674304 + z * 0.02961201126495512)));
}

/* asin x = pi/2 - 2 asin(sqrt((1 - x)/2)); not a number beyond 1. */
static APART double own_large_asin(double x)
{
    const double y = 0x1.921fb54442d18p+0 - (2 * own_small_asin(sqrt(0.5 * (1 - fabs(x)))) - 0x1.1a62633145c07p-54);
    return x < 0 ? -y : y;
}

static inline double own_asin(double x)
{
    return fabs(x) <= 0.5 ? own_small_asin(x) : own_large_asin(x);
}

/* fmin and fmax; some platforms call a function for them. */
static inline double own_fmin(double a, double b)
{
    const double least = a < b ? a : b;
    return b != b ? a : least;
}

static inline double own_fmax(double a, double b)
{
    const double largest = a > b ? a : b;
    return b != b ? a : largest;
}

#endif
