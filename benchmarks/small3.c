/* A small FMU of FMI 3.0 for tests and measurements of masters: the oscillator of small.c, by the same steps; a variable
   of each type, and arrays, whose inputs are handed on; events, early returns and faults on demand. Functions that a
   master has no reason to call are not there. Its twin is small3.py: the numbers of variables. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi3Functions.h"

enum { TIME, A21, A22, X1, X2, SUBSTEPS, FAULT_TIME, PERIOD, EARLY, U, Y, Y1, Y2, REALS };
enum { VECTOR_IN = 20, VECTOR_OUT, MATRIX, SIZE };
enum { TYPED = 30, TEXT = 60, TEXTS = 62, BYTES = 64, TABLE = 66, LEVEL_IN = 80, LEVEL_OUT, COUNT, ENTERED, FAULT = 90 };
enum { NONE, DISCARD, ERROR_, FATAL, END, END_IN_EVENT, RESTLESS, STUCK, REFUSE_EVENT, REFUSE_UPDATE };
enum { F64, F32, I8, U8, I16, U16, I32, U32, I64, U64, TRUTH, ENUMERATION, KINDS };
enum { MADE, INITIALISING, STEPPING, IN_EVENT };

typedef struct {
    double r[REALS], vector_in[3], vector_out[2], matrix[6];
    union { double f64; float f32; int64_t i64; } in[KINDS], out[KINDS];
    char text[6][200]; /* in, out, two in, two out */
    unsigned char bytes[2][100];
    size_t lengths[2];
    int32_t table[2][4], level_in, level_out, count, entered, fault;
    uint64_t size;
    int mode, pending;
} State;

typedef struct {
    State s;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    int events, early;
} Instance;

static const State INITIAL = {.r = {[A21] = -4, [A22] = -0.3, [X1] = 1, [SUBSTEPS] = 1, [FAULT_TIME] = 1e9},
                              .vector_in = {0.5, 0.5, 0.5}, .matrix = {1, 2, 3, 4, 5, 6}, .size = 3,
                              .in = {[ENUMERATION] = {.i64 = 1}}, .text = {[0] = "start", [2] = "one", [3] = "two"},
                              .bytes = {{0x00, 0xff}}, .lengths = {2}};

static fmi3Status say(Instance *m, fmi3Status status, const char *why)
{
    m->log(m->environment, status, "all", why);
    return status;
}

static void outputs(State *s)
{
    double *r = s->r;
    r[Y] = r[Y1] = r[X1];
    r[Y2] = r[X2];
    for (int i = 0; i < 2; i++)
        s->vector_out[i] = s->matrix[3 * i] * s->vector_in[0] + s->matrix[3 * i + 1] * s->vector_in[1]
                           + s->matrix[3 * i + 2] * s->vector_in[2];
    memcpy(s->out, s->in, sizeof s->in);
    memcpy(s->text[1], s->text[0], sizeof s->text[0]);
    memcpy(s->text[4], s->text[2], 2 * sizeof s->text[0]);
    memcpy(s->bytes[1], s->bytes[0], sizeof s->bytes[0]);
    s->lengths[1] = s->lengths[0];
    memcpy(s->table[1], s->table[0], sizeof s->table[0]);
    s->level_out = s->level_in;
}

/* Where a variable is kept, and how many values it has; NULL if there is none of this type. */
static void *place(State *s, unsigned vr, int kind, size_t *n)
{
    *n = 1;
    if (kind == F64 && vr < REALS)
        return s->r + vr;
    if (kind == F64 && vr >= VECTOR_IN && vr <= MATRIX) {
        *n = vr == VECTOR_IN ? 3 : vr == VECTOR_OUT ? 2 : 6;
        return vr == VECTOR_IN ? s->vector_in : vr == VECTOR_OUT ? s->vector_out : s->matrix;
    }
    if (kind == U64 && vr == SIZE)
        return &s->size;
    if (vr >= TYPED && vr < TYPED + 2 * KINDS && ((vr - TYPED) / 2 == kind || (kind == I64 && (vr - TYPED) / 2 == ENUMERATION)))
        return (vr - TYPED) % 2 ? s->out + (vr - TYPED) / 2 : s->in + (vr - TYPED) / 2;
    if (kind == I32 && vr >= TABLE && vr < TABLE + 2) {
        *n = 4;
        return s->table[vr - TABLE];
    }
    if (kind == I32 && vr >= LEVEL_IN && vr <= ENTERED)
        return &s->level_in + (vr - LEVEL_IN);
    return kind == I32 && vr == FAULT ? &s->fault : NULL;
}

/* Discrete inputs are given in event mode, where there is one. */
static int refused(Instance *m, unsigned vr)
{
    int continuous = vr < REALS || vr == VECTOR_IN || (vr >= TYPED && vr < TYPED + 2 * I8);
    return m->s.mode == STEPPING && m->events && !continuous;
}

#define ACCESS(Name, type, kind)                                                                                       \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t values)     \
    {                                                                                                                  \
        Instance *m = c;                                                                                               \
        size_t at = 0, count;                                                                                          \
        if (m->s.mode < STEPPING)                                                                                      \
            outputs(&m->s);                                                                                            \
        for (size_t k = 0; k < n; k++, at += count) {                                                                  \
            type *found = place(&m->s, vr[k], kind, &count);                                                           \
            if (!found || at + count > values)                                                                         \
                return say(m, fmi3Error, "no such variable, or no room for it");                                       \
            memcpy(value + at, found, count * sizeof(type));                                                           \
        }                                                                                                              \
        return at == values ? fmi3OK : say(m, fmi3Error, "room for more values than there are");                       \
    }                                                                                                                  \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[],              \
                             size_t values)                                                                            \
    {                                                                                                                  \
        Instance *m = c;                                                                                               \
        size_t at = 0, count;                                                                                          \
        for (size_t k = 0; k < n; k++, at += count) {                                                                  \
            type *found = place(&m->s, vr[k], kind, &count);                                                           \
            if (!found || at + count > values)                                                                         \
                return say(m, fmi3Error, "no such variable, or no values for it");                                     \
            if (refused(m, vr[k]))                                                                                     \
                return say(m, fmi3Error, "discrete inputs are given in event mode");                                   \
            memcpy(found, value + at, count * sizeof(type));                                                           \
        }                                                                                                              \
        return at == values ? fmi3OK : say(m, fmi3Error, "more values than variables");                                \
    }

ACCESS(Float64, fmi3Float64, F64)
ACCESS(Float32, fmi3Float32, F32)
ACCESS(Int8, fmi3Int8, I8)
ACCESS(UInt8, fmi3UInt8, U8)
ACCESS(Int16, fmi3Int16, I16)
ACCESS(UInt16, fmi3UInt16, U16)
ACCESS(Int32, fmi3Int32, I32)
ACCESS(UInt32, fmi3UInt32, U32)
ACCESS(Int64, fmi3Int64, I64)
ACCESS(UInt64, fmi3UInt64, U64)
ACCESS(Boolean, fmi3Boolean, TRUTH)

fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t values)
{
    State *s = &((Instance *)c)->s;
    size_t at = 0;
    if (s->mode < STEPPING)
        outputs(s);
    for (size_t k = 0; k < n; k++) {
        value[at++] = s->text[vr[k] < TEXTS ? vr[k] - TEXT : 2 + 2 * (vr[k] - TEXTS)];
        if (vr[k] >= TEXTS)
            value[at++] = s->text[3 + 2 * (vr[k] - TEXTS)];
    }
    return at == values ? fmi3OK : say(c, fmi3Error, "another number of values");
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t values)
{
    State *s = &((Instance *)c)->s;
    size_t at = 0;
    for (size_t k = 0; k < n; k++) {
        if (refused(c, vr[k]))
            return say(c, fmi3Error, "discrete inputs are given in event mode");
        strcpy(s->text[vr[k] < TEXTS ? vr[k] - TEXT : 2 + 2 * (vr[k] - TEXTS)], value[at++]);
        if (vr[k] >= TEXTS)
            strcpy(s->text[3 + 2 * (vr[k] - TEXTS)], value[at++]);
    }
    return at == values ? fmi3OK : say(c, fmi3Error, "another number of values");
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference needed[], size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    Instance *m = calloc(1, sizeof *m);
    *m = (Instance){INITIAL, environment, log, events, early};
#ifdef EVENTS /* only with event mode, or only without */
    if (events != EVENTS) {
        say(m, fmi3Error, "not with this event mode");
        free(m);
        return NULL;
    }
#endif
    return m;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }

static fmi3Status enter(Instance *m, int from, int mode)
{
    if (m->s.mode != from)
        return say(m, fmi3Error, "a call out of order");
    m->s.mode = mode;
    return fmi3OK;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean given, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stops, fmi3Float64 stop)
{
    ((Instance *)c)->s.r[TIME] = start;
    if (given && tolerance == 0.125)
        return say(c, fmi3Error, "such a tolerance");
    return enter(c, MADE, INITIALISING);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    outputs(&((Instance *)c)->s);
    return enter(c, INITIALISING, ((Instance *)c)->events ? IN_EVENT : STEPPING);
}
fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    Instance *m = c;
    m->s.entered++;
    if (m->s.fault == REFUSE_EVENT && m->s.r[TIME] >= m->s.r[FAULT_TIME])
        return say(m, fmi3Error, "told not to enter event mode");
    return enter(m, STEPPING, IN_EVENT);
}
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return enter(c, IN_EVENT, STEPPING); }
fmi3Status fmi3Terminate(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c)
{
    ((Instance *)c)->s = INITIAL;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *known, fmi3Float64 *next)
{
    Instance *m = c;
    State *s = &m->s;
    int faulty = s->r[TIME] >= s->r[FAULT_TIME] - 1e-9;
    if (s->mode != IN_EVENT)
        return say(m, fmi3Error, "not in event mode");
    if (faulty && s->fault == REFUSE_UPDATE)
        return say(m, fmi3Error, "told not to update");
    if (s->pending && !--s->pending)
        s->count++;
    outputs(s);
    *again = s->pending || (faulty && s->fault == RESTLESS);
    *end = faulty && s->fault == END_IN_EVENT;
    *nominals = *values = *known = fmi3False;
    *next = 0;
    return fmi3OK;
}

static void advance(State *s, double until, double step)
{
    double *r = s->r;
    int count = r[SUBSTEPS] < 1 ? 1 : (int)r[SUBSTEPS];
    double h = step / count;
    for (int k = 0; k < count; k++) {
        double x1 = r[X1], x2 = r[X2], u = r[U];
#define F1(p, q) (q)
#define F2(p, q) (r[A21] * (p) + r[A22] * (q) + u)
        double k1 = F1(x1, x2), l1 = F2(x1, x2);
        double k2 = F1(x1 + h / 2 * k1, x2 + h / 2 * l1), l2 = F2(x1 + h / 2 * k1, x2 + h / 2 * l1);
        double k3 = F1(x1 + h / 2 * k2, x2 + h / 2 * l2), l3 = F2(x1 + h / 2 * k2, x2 + h / 2 * l2);
        double k4 = F1(x1 + h * k3, x2 + h * l3), l4 = F2(x1 + h * k3, x2 + h * l3);
        r[X1] += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        r[X2] += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    r[TIME] = until;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *reached)
{
    Instance *m = c;
    State *s = &m->s;
    double *r = s->r, until = time + step, next;
    *event = *end = *early = fmi3False;
    *reached = until;
    if (s->mode != STEPPING)
        return say(m, fmi3Error, "not in step mode");
    if (fabs(time - r[TIME]) > 1e-9)
        return say(m, fmi3Error, "a step from another time than I am at");
    r[TIME] = time;
    if (time + 1e-9 >= r[FAULT_TIME])
        switch (s->fault) {
        case DISCARD: return say(m, fmi3Discard, "told to discard");
        case ERROR_: return say(m, fmi3Error, "told to fail");
        case FATAL: return say(m, fmi3Fatal, "told to fail for good");
        case STUCK: *early = fmi3True; *reached = time; return fmi3OK;
        }
    if (s->fault == END && until > r[FAULT_TIME] - 1e-9) {
        *end = fmi3True;
        *early = until > r[FAULT_TIME] + 1e-9;
        until = *reached = *early ? r[FAULT_TIME] : until;
    } else if (m->early && r[EARLY] > 0 && step > 1.001 * r[EARLY]) {
        *early = fmi3True;
        until = *reached = time + r[EARLY];
    }
    while (r[PERIOD] > 0 && (next = (floor(r[TIME] / r[PERIOD] + 1e-9) + 1) * r[PERIOD]) <= until + 1e-12) {
        if (m->events) {
            *event = fmi3True;
            *early = next < time + step - 1e-12;
            until = *reached = *early ? next : time + step;
            s->pending = 2;
            break;
        }
        next = next < until ? next : until;
        advance(s, next, next - r[TIME]);
        s->count++;
    }
    if (until > r[TIME])
        advance(s, until, r[TIME] == time && until == time + step ? step : until - r[TIME]);
    outputs(s);
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    *state = *state ? *state : malloc(sizeof(State));
    memcpy(*state, &((Instance *)c)->s, sizeof(State));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    memcpy(&((Instance *)c)->s, state, sizeof(State));
    return fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    *size = sizeof(State);
    return fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    memcpy(bytes, state, size);
    return fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (size != sizeof(State))
        return say(c, fmi3Error, "not a state of mine");
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    free(*state);
    *state = NULL;
    return fmi3OK;
}
