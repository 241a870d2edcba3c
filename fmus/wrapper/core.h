/* The core: what an instance is. It knows no version of FMI; fmi2.c and fmi3.c are the doors through which importers
   reach it. */
#ifndef CORE_H
#define CORE_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status; /* with the numbers that both versions give them */

typedef uint32_t Reference; /* of a variable: a row's number in the table */

typedef enum { INPUT, OUTPUT, CALCULATED_PARAMETER, PARAMETER, STATE, RATE, TIME } Role;

/* One row of the model's table: first the model's own, then continuous states that are no output, then the derivatives
   of all continuous states, then time. Where there is no limit, minimum and maximum are those of a double. */
typedef struct {
    const char *name;
    Role role;
    int boolean, discrete;
    int place; /* in u (inputs), p (parameters), x (states), the rates, or y (all others) */
    int state; /* which continuous state this variable is, or -1 */
    double start, minimum, maximum;
    const char *unit; /* as shown in messages, with `shown` units to one of the variable's */
    double shown;
} Variable;

#include "model.h"

#define LENGTH(n) ((n) > 0 ? (n) : 1) /* C has no arrays of length 0 */

/* A function that is called for each value: its body stands where it is called, and what is constant there decides. */
#ifdef __GNUC__
#define FAST inline __attribute__((always_inline))
#else
#define FAST inline
#endif

typedef enum { MODEL_EXCHANGE, CO_SIMULATION } Kind;

/* After initialisation an instance for co-simulation is STEPPING, one for model exchange in either of the next two. */
typedef enum { INSTANTIATED, INITIALISING, STEPPING, AT_EVENT, IN_CONTINUOUS_TIME, TERMINATED } Phase;

/* Everything that a saved state holds. No pointers and no padding: 8-byte numbers first, then an even number of 4 bytes.
   Of x, the first NS entries are the continuous states; the others are memories. */
typedef struct {
    double time;      /* the last communication point reached; in model exchange, what the importer set */
    double stop_time; /* infinity if none was given */
    double step;      /* the communication step that count, h and c were prepared for; 0 for none */
    double count, h;  /* number and length of its internal steps */
    double x[LENGTH(NX)], u[LENGTH(NU)], p[LENGTH(NP)], y[LENGTH(NY)];
    double k[LENGTH(NK)], c[LENGTH(NC)]; /* what p decides, and what p and h decide */
    double refused[LENGTH(NU)]; /* the inf or nan an input was last set to, 0 for none */
    int64_t step_status; /* what the last step returned */
    int32_t kind, phase;
    int32_t stale; /* x and y, or in model exchange y, are not those of what was set */
    int32_t unused;
} State;

/* What the importer gave an instance to speak and to allocate with; the door that made the instance fills it in. */
typedef struct Host {
    void (*tell)(const struct Host *, const char *name, Status, const char *category, const char *sentence);
    void (*logger)(void); /* the importer's, of the type that `tell` knows; NULL for none */
    void *environment;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
} Host;

typedef struct {
    uint64_t magic; /* the door's, while the instance lives */
    Host host;
    unsigned logged; /* one bit for each log category */
    State state;
    double next_x[2][LENGTH(NX)], next_y[LENGTH(NY)]; /* not taken yet */
    double rates[LENGTH(NS)];
    char name[];
} Instance;

/* Not isfinite(): for some C libraries that is a function of their own. */
static int is_finite(double value)
{
    return value >= -DBL_MAX && value <= DBL_MAX;
}

#endif
