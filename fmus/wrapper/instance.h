/* What an instance is: its state in one flat block, scratch beside it, and the importer's callbacks. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "fmi2Functions.h"

typedef enum { INPUT, OUTPUT, CALCULATED_PARAMETER, PARAMETER } Causality;

/* One row of the model's table; a value reference is a row's number.
   Where there is no limit, minimum and maximum are those of a double. */
typedef struct {
    const char *name;
    Causality causality;
    int boolean;
    int place; /* in u (inputs), p (parameters) or y (all others) */
    double start, minimum, maximum;
    const char *unit; /* as shown in messages, with `shown` units to one of the variable's */
    double shown;
} Variable;

#include "model.h"

#define LENGTH(n) ((n) > 0 ? (n) : 1) /* C has no arrays of length 0 */

typedef enum { INSTANTIATED, INITIALISING, STEPPING, TERMINATED } Phase;

/* Everything that fmi2GetFMUstate saves. No pointers and no padding: 8-byte numbers first, then two of 4 bytes. */
typedef struct {
    double time;      /* the last communication point reached */
    double stop_time; /* infinity if none was given */
    double step;      /* the communication step that count, h and c were prepared for; 0 for none */
    double count, h;  /* number and length of its internal steps */
    double x[LENGTH(NX)], u[LENGTH(NU)], p[LENGTH(NP)], y[LENGTH(NY)], c[LENGTH(NC)];
    double refused[LENGTH(NU)]; /* the inf or nan an input was last set to, 0 for none */
    int64_t step_status; /* what the last fmi2DoStep returned */
    int32_t phase;
    int32_t stale; /* inputs or parameters were set since x and y were initialised */
} State;

typedef struct {
    uint64_t magic;
    fmi2CallbackFunctions callbacks;
    unsigned logged; /* one bit for each log category */
    State state;
    double next_x[2][LENGTH(NX)], next_y[LENGTH(NY)]; /* not taken yet */
    char name[];
} Instance;

/* Not isfinite(): for some C libraries that is a function of their own. */
static int is_finite(double value)
{
    return value >= -DBL_MAX && value <= DBL_MAX;
}

#define INSTANCE_MAGIC UINT64_C(0x31534e4955484121)

#endif
