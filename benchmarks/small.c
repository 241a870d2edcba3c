/* A small FMU for tests and measurements of masters: x1' = a11 x1 + a12 x2 + b1 u, x2' = a21 x1 + a22 x2 + b2 u,
   y = c1 x1 + c2 x2 + d u, by Runge and Kutta's fourth-order method in `substeps` steps; whole, truth and text
   inputs that are handed on at each step; and faults on demand. Its twin is small.py: the order of variables. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "fmi2Functions.h"

enum { A11, A12, A21, A22, B1, B2, C1, C2, D, X1, X2, SUBSTEPS, FAULT_TIME, LONGEST, U, Y, Y1, Y2, REALS };
enum { FAULT, WHOLE_IN, WHOLE_OUT, ANSWER, WHOLES };
enum { NONE, DISCARD, ERROR_, FATAL, HANG, CRASH, REFUSE_GET, REFUSE_INIT, HANG_INIT, END, ANSWERS, REFUSE_TEXT, NO_TEXT,
       CRASH_TERMINATE, CRASH_FREE, HANG_TERMINATE, FATAL_TERMINATE, NOT_A_NUMBER, LEAVE, FATAL_INIT, SLOW_INIT,
       REFUSE_FREE, REFUSE_SET };

typedef struct {
    fmi2Real r[REALS], slope, time;
    fmi2Integer i[WHOLES];
    fmi2Boolean truth_in, truth_out;
    char text_in[6000], text_out[6000];
    int stepping, ended;
} State;

typedef struct {
    State s;
    const fmi2CallbackFunctions *callbacks;
    char name[100];
} Instance;

static const State INITIAL = {.r = {[A12] = 1, [A21] = -1, [B2] = 1, [C1] = 1, [SUBSTEPS] = 1, [FAULT_TIME] = 1e9,
                                    [LONGEST] = 1e9}};

int calls_after_fatal; /* of any instance: none is allowed */
static int dead;

static Instance *alive(fmi2Component c)
{
    calls_after_fatal += dead;
    return c;
}

static fmi2Status say(Instance *m, fmi2Status status, const char *why)
{
    dead |= status == fmi2Fatal;
#ifdef FORGETS_ENVIRONMENT
    m->callbacks->logger(m, m->name, status, "logAll", "%s", why);
    return status;
#endif
    m->callbacks->logger(m->callbacks->componentEnvironment, m->name, status, "logAll", "%s", why);
    return status;
}

static void outputs(State *s)
{
    fmi2Real *r = s->r;
    r[Y1] = r[X1];
    r[Y2] = r[X2];
    r[Y] = r[C1] * r[X1] + r[C2] * r[X2] + r[D] * r[U];
    s->i[WHOLE_OUT] = s->i[WHOLE_IN];
    s->truth_out = s->truth_in;
    strcpy(s->text_out, s->text_in);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String folder,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    Instance *m = calloc(1, sizeof *m);
    m->s = INITIAL;
    m->callbacks = callbacks;
    snprintf(m->name, sizeof m->name, "%s", name);
#ifdef REFUSE_INSTANCE
    say(m, fmi2Error, "told not to be made");
    free(m);
    return NULL;
#endif
    return m;
}
void fmi2FreeInstance(fmi2Component c)
{
    if (alive(c)->s.i[FAULT] == CRASH_FREE)
        raise(SIGSEGV);
    free(c);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e)
{
    ((Instance *)c)->s.time = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    Instance *m = alive(c);
    while (m->s.i[FAULT] == HANG_INIT)
        sleep(1);
    if (m->s.i[FAULT] == SLOW_INIT)
        usleep(300000);
    if (m->s.i[FAULT] == FATAL_INIT)
        return say(m, fmi2Fatal, "told never to initialise");
    return m->s.i[FAULT] == REFUSE_INIT ? say(m, fmi2Error, "told not to initialise") : fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    outputs(&alive(c)->s);
    ((Instance *)c)->s.stepping = 1;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c)
{
    switch (alive(c)->s.i[FAULT]) {
    case CRASH_TERMINATE: raise(SIGSEGV);
    case HANG_TERMINATE: while (1) sleep(1);
    case FATAL_TERMINATE: return say(c, fmi2Fatal, "told to fail at the end");
    }
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component c)
{
    alive(c)->s = INITIAL;
    return fmi2OK;
}

#define ACCESS(Type, type, member, count, check)                                                                       \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[])                   \
    {                                                                                                                  \
        Instance *m = alive(c);                                                                                        \
        check;                                                                                                         \
        if (!m->s.stepping)                                                                                            \
            outputs(&m->s);                                                                                            \
        for (size_t k = 0; k < n; k++) {                                                                               \
            if (vr[k] >= count)                                                                                        \
                return say(m, fmi2Error, "no such variable");                                                          \
            value[k] = (member)[vr[k]];                                                                                \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }                                                                                                                  \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[])             \
    {                                                                                                                  \
        Instance *m = alive(c);                                                                                        \
        if (m->s.i[FAULT] == REFUSE_SET && m->s.stepping && m->s.time >= m->s.r[FAULT_TIME])                           \
            return say(m, fmi2Fatal, "told to take nothing");                                                          \
        for (size_t k = 0; k < n; k++) {                                                                               \
            if (vr[k] >= count)                                                                                        \
                return say(m, fmi2Error, "no such variable");                                                          \
            (member)[vr[k]] = value[k];                                                                                \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }

ACCESS(Real, fmi2Real, m->s.r, REALS,
       if (m->s.i[FAULT] == REFUSE_GET && m->s.stepping && m->s.time >= m->s.r[FAULT_TIME])
           return say(m, fmi2Error, "told not to show anything"))
ACCESS(Integer, fmi2Integer, m->s.i, WHOLES, )
ACCESS(Boolean, fmi2Boolean, &m->s.truth_in, 2, )

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[])
{
    State *s = &alive(c)->s;
    if (!s->stepping)
        outputs(s);
    if (s->i[FAULT] == REFUSE_TEXT && s->time >= s->r[FAULT_TIME])
        return say(c, fmi2Error, "told not to show texts");
    for (size_t k = 0; k < n; k++)
        value[k] = s->i[FAULT] == NO_TEXT ? NULL : vr[k] ? s->text_out : s->text_in;
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
{
    for (size_t k = 0; k < n; k++)
        if (!strcmp(value[k], "refused"))
            return say(alive(c), fmi2Error, "this text is refused");
    for (size_t k = 0; k < n; k++)
        snprintf(((Instance *)c)->s.text_in, sizeof ((Instance *)c)->s.text_in, "%s", value[k]);
    return fmi2OK;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    for (size_t k = 0; k < n; k++)
        if (vr[k] == U && order[k] == 1)
            ((Instance *)c)->s.slope = value[k];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean keep)
{
    Instance *m = alive(c);
    State *s = &m->s;
    fmi2Real *r = s->r;
    int ends = s->i[FAULT] == END && time + step > r[FAULT_TIME];
    if (step > r[LONGEST])
        return say(m, fmi2Discard, "the step is longer than I can take");
    if (time + 1e-9 >= r[FAULT_TIME])
        switch (s->i[FAULT]) {
        case DISCARD: return say(m, fmi2Discard, "told to discard");
        case ERROR_: return say(m, fmi2Error, "told to fail");
        case FATAL: return say(m, fmi2Fatal, "told to fail for good");
        case HANG: while (1) sleep(1);
        case CRASH: raise(SIGSEGV);
        case ANSWERS: return say(m, s->i[ANSWER], "told what to answer");
        case NOT_A_NUMBER: r[X1] = 0.0 / 0.0; break;
        case LEAVE: exit(3);
        }
#ifndef END_WITH_STEP
    if (ends) /* as far as it goes */
        step = r[FAULT_TIME] > time ? r[FAULT_TIME] - time : 0;
#endif
#ifdef SHOWS_KEEP /* noSetFMUStatePriorToCurrentPoint, as whole_out */
    s->i[WHOLE_IN] = keep;
#endif
    int count = r[SUBSTEPS] < 1 ? 1 : (int)r[SUBSTEPS];
    double h = step / count, du = s->slope;
    for (int k = 0; k < count; k++) {
        double u0 = r[U] + du * k * h, um = u0 + du * h / 2, u1 = u0 + du * h, x1 = r[X1], x2 = r[X2];
#define F1(p, q, u) (r[A11] * (p) + r[A12] * (q) + r[B1] * (u))
#define F2(p, q, u) (r[A21] * (p) + r[A22] * (q) + r[B2] * (u))
        double k1 = F1(x1, x2, u0), l1 = F2(x1, x2, u0);
        double k2 = F1(x1 + h / 2 * k1, x2 + h / 2 * l1, um), l2 = F2(x1 + h / 2 * k1, x2 + h / 2 * l1, um);
        double k3 = F1(x1 + h / 2 * k2, x2 + h / 2 * l2, um), l3 = F2(x1 + h / 2 * k2, x2 + h / 2 * l2, um);
        double k4 = F1(x1 + h * k3, x2 + h * l3, u1), l4 = F2(x1 + h * k3, x2 + h * l3, u1);
        r[X1] += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        r[X2] += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    r[U] += du * step;
    s->time = time + step;
    outputs(s);
    s->ended = ends;
    return ends ? say(m, fmi2Discard, "told to end") : fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
#ifdef REFUSE_STATUS
    *value = fmi2True;
    return say(alive(c), fmi2Discard, "no word of that");
#endif
    if (kind != fmi2Terminated)
        return say(alive(c), fmi2Discard, "there is no such status");
    *value = alive(c)->s.ended;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
#ifdef NO_TIME
    return fmi2Error;
#endif
    if (kind != fmi2LastSuccessfulTime)
        return say(alive(c), fmi2Discard, "there is no such status");
    *value = alive(c)->s.time;
#ifdef ODD_TIME
    *value = ODD_TIME;
#endif
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    alive(c);
    if (!*state)
        *state = malloc(sizeof(State));
    memcpy(*state, &((Instance *)c)->s, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    memcpy(&alive(c)->s, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    State *s = &alive(c)->s;
    free(*state);
    *state = 0;
    if (s->i[FAULT] == REFUSE_FREE && s->time >= s->r[FAULT_TIME])
        return say(c, fmi2Fatal, "told not to free");
    return fmi2OK;
}
#ifndef LEAN /* functions of capabilities that are not claimed */
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { return fmi2Error; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { return fmi2Error; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) { return fmi2Error; }
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t n,
                                        const fmi2ValueReference k[], size_t m, const fmi2Real du[], fmi2Real dk[])
{
    return fmi2Error;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) { return fmi2Error; }
fmi2Status fmi2CancelStep(fmi2Component c) { return fmi2Error; }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind k, fmi2Status *v) { return fmi2Error; }
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *v) { return fmi2Error; }
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *v) { return fmi2Error; }
#endif
