/* The FMU as a plain WebAssembly module: it exports the FMI functions, `memory`, `malloc` and `free`, and what is here.
   It imports nothing, so there are no callbacks: the last sentence that the FMU said is kept. */
#include <stdlib.h>

#include "all.c"

#define EXPORT(name) __attribute__((export_name(#name))) wasm_##name

static char last[SENTENCE];

static void keep(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String message, ...)
{
    (void)environment, (void)instance, (void)status, (void)category;
    snprintf(last, sizeof last, "%s", message);
}

static const fmi2CallbackFunctions CALLBACKS = {keep, calloc, free, NULL, NULL};

fmi2Component EXPORT(instantiate)(void)
{
    return fmi2Instantiate(MODEL_NAME, fmi2CoSimulation, FMU_GUID, "", &CALLBACKS, fmi2False, fmi2True);
}

const char *EXPORT(message)(void)
{
    return last;
}

/* The variables by value reference, 0 ... n_variables() - 1. */
unsigned EXPORT(n_variables)(void)
{
    return NV;
}

const char *EXPORT(variable_name)(unsigned reference)
{
    return TABLE[reference].name;
}
