/* An FMI 2.0 co-simulation FMU's library, loaded at run time: what a plain C importer does. */
#ifndef FMU_H
#define FMU_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#ifdef LINKED /* with the FMU's own all.c, where nothing can be loaded at run time */
#include "fmi2Functions.h"
#else
#include "library.h"
#endif

#define FUNCTIONS(X) \
    X(Instantiate) X(FreeInstance) X(SetDebugLogging) X(SetupExperiment) X(EnterInitializationMode) \
    X(ExitInitializationMode) X(Terminate) X(Reset) X(GetReal) X(GetInteger) X(GetBoolean) X(GetString) X(SetReal) \
    X(SetInteger) X(SetBoolean) X(SetString) X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate) X(SerializedFMUstateSize) \
    X(SerializeFMUstate) X(DeSerializeFMUstate) X(GetDirectionalDerivative) X(SetRealInputDerivatives) \
    X(GetRealOutputDerivatives) X(DoStep) X(CancelStep) X(GetStatus) X(GetRealStatus) X(GetIntegerStatus) \
    X(GetBooleanStatus) X(GetStringStatus)

typedef struct {
#define X(name) fmi2##name##TYPE *name;
    FUNCTIONS(X)
#undef X
    const char *guid;
} Fmu;

static void fail(const char *what, const char *which)
{
    fprintf(stderr, "%s: %s\n", what, which);
    exit(1);
}

static Fmu load(const char *library, const char *guid)
{
    Fmu fmu;
#ifdef LINKED
    (void)library;
#define X(name) fmu.name = fmi2##name;
    FUNCTIONS(X)
#undef X
#else
    void *handle = OPEN(library), *symbol;
    if (!handle)
        fail("cannot be loaded", library);
#define X(name) \
    if (!(symbol = SYMBOL(handle, "fmi2" #name))) \
        fail("has no fmi2" #name, library); \
    memcpy(&fmu.name, &symbol, sizeof symbol);
    FUNCTIONS(X)
#undef X
#endif
    fmu.guid = guid;
    return fmu;
}

static void report(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment;
    fprintf(stderr, "%s: status %d, %s: %s\n", instance, (int)status, category, message);
}

static const fmi2CallbackFunctions CALLBACKS = {report, calloc, free, NULL, NULL};

static void ok(fmi2Status status, const char *call)
{
    if (status != fmi2OK)
        fail("not OK", call);
}

static fmi2Component begin(const Fmu *fmu, const char *name)
{
    fmi2Component c = fmu->Instantiate(name, fmi2CoSimulation, fmu->guid, "", &CALLBACKS, fmi2False, fmi2True);
    if (!c)
        fail("not instantiated", name);
    ok(fmu->SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0), "SetupExperiment");
    ok(fmu->EnterInitializationMode(c), "EnterInitializationMode");
    return c;
}

#endif
