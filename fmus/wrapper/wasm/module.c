/* The FMU as a plain WebAssembly module: it exports the FMI functions, `memory`, `malloc` and `free`, and what is here.
   It imports nothing, so there are no callbacks: the last sentence that the FMU said is kept. A prefix of the FMI
   functions is one of all names. */
#define FMI2_Export __attribute__((visibility("default")))
#include <stdlib.h>

#include "all.c"

#define TEXT(name) #name
#define QUOTED(name) TEXT(name)
#define EXPORT(type, name) type __attribute__((export_name(QUOTED(fmi2FullName(name))))) fmi2FullName(wasm_##name)

static char last[SENTENCE];

static void keep(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String message, ...)
{
    (void)environment, (void)instance, (void)status, (void)category;
    snprintf(last, sizeof last, "%s", message);
}

static const fmi2CallbackFunctions CALLBACKS = {keep, calloc, free, NULL, NULL};

EXPORT(fmi2Component, instantiate)(void)
{
    return fmi2Instantiate(MODEL_NAME, fmi2CoSimulation, FMU_GUID, "", &CALLBACKS, fmi2False, fmi2True);
}

EXPORT(const char *, message)(void)
{
    return last;
}

/* The variables by value reference, 0 ... n_variables() - 1. */
EXPORT(unsigned, n_variables)(void)
{
    return NV;
}

EXPORT(const char *, variable_name)(unsigned reference)
{
    return TABLE[reference].name;
}
