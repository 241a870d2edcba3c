/* A tank with an outlet: area dlevel/dt = inflow - leak - outlet sqrt(level), by Euler's method in steps of 10 ms at most.
   An FMU for co-simulation, FMI 2.0, without any tool: this file, modelDescription.xml and build.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"

enum { INFLOW, LEAK, LEVEL, OUTFLOW, AREA, OUTLET, LEVEL_START, REALS }; /* value references */
typedef struct { fmi2Real r[REALS]; } Tank;
static const Tank START = {{[AREA] = 2.0, [OUTLET] = 0.5, [LEVEL_START] = 1.0}};

static void show(fmi2Real *r) { r[OUTFLOW] = r[OUTLET] * sqrt(r[LEVEL]); }

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log)
{
    Tank *tank = strcmp(guid, "{tank-1}") ? NULL : malloc(sizeof *tank);
    if (tank) *tank = START;
    return tank;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) { return fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends,
                               fmi2Real stop) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    fmi2Real *r = ((Tank *)c)->r;
    r[LEVEL] = r[LEVEL_START];
    show(r);
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmi2EnterInitializationMode(c); }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { *(Tank *)c = START; return fmi2OK; }

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Real value[])
{
    fmi2Real *r = ((Tank *)c)->r;
    for (size_t i = 0; i < n; i++) {
        if (v[i] >= REALS) return fmi2Error;
        r[v[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Real value[])
{
    fmi2Real *r = ((Tank *)c)->r;
    for (size_t i = 0; i < n; i++) {
        if (v[i] >= REALS) return fmi2Error;
        value[i] = r[v[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_before)
{
    fmi2Real *r = ((Tank *)c)->r;
    int count = (int)ceil(step / 0.01 - 1e-9);
    for (int i = 0; i < count; i++) {
        r[LEVEL] += step / count * (r[INFLOW] - r[LEAK] - r[OUTLET] * sqrt(r[LEVEL])) / r[AREA];
        if (r[LEVEL] < 0) r[LEVEL] = 0;
    }
    show(r);
    return fmi2OK;
}

/* What the standard wants as well: variables of other types, of which there are none, and what is asked of other FMUs. */
#define NO_VARIABLES(type) \
    fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2##type value[]) \
    { return n ? fmi2Error : fmi2OK; } \
    fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2##type value[]) \
    { return n ? fmi2Error : fmi2OK; }
#define NO_STATUS(name, type) \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2StatusKind kind, type *value) { return fmi2Discard; }
NO_VARIABLES(Integer)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)
NO_STATUS(Status, fmi2Status)
NO_STATUS(RealStatus, fmi2Real)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(BooleanStatus, fmi2Boolean)
NO_STATUS(StringStatus, fmi2String)
fmi2Status fmi2CancelStep(fmi2Component c) { return fmi2Error; }
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) { return fmi2Error; }
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference v[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) { return fmi2Error; }
