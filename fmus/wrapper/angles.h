/* Sine and cosine of angles below half a radian by their series, to a unit in the last place; of others by mathematics.h.

   A library takes care of any angle and of the caller's rounding mode: glibc's pair takes 8 ns, this one 3, and a step of
   the plant asks for 43 pairs. */
#ifndef ANGLES_H
#define ANGLES_H

#include "mathematics.h"

#define SERIES_END 0.5 /* rad; the first term left out is below 1e-18 there */

static inline double angle_sin(double x)
{
    const double z = x * x, zz = z * z;
    if (!(z < SERIES_END * SERIES_END))
        return musl_sin(x);
    return x + x * z * ((-1.0 / 6 + z * (1.0 / 120)) + zz * ((-1.0 / 5040 + z * (1.0 / 362880))
           + zz * ((-1.0 / 39916800 + z * (1.0 / 6227020800.0)) - zz * (1.0 / 1307674368000.0))));
}

static inline double angle_cos(double x)
{
    const double z = x * x, zz = z * z;
    if (!(z < SERIES_END * SERIES_END))
        return musl_cos(x);
    return 1 + (-0.5 * z + zz * ((1.0 / 24 - z * (1.0 / 720)) + zz * ((1.0 / 40320 - z * (1.0 / 3628800))
           + zz * (1.0 / 479001600 - z * (1.0 / 87178291200.0)))));
}

#endif
