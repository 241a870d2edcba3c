/* The door of FMI 2.0, for co-simulation and model exchange. */

#include "fmi2Functions.h"

#define FMI2_MAGIC UINT64_C(0x31534e4955484121)

static Instance *of2(fmi2Component c)
{
    Instance *instance = c;
    return instance && instance->magic == FMI2_MAGIC ? instance : NULL;
}

static fmi2Status to2(Status status)
{
    return (fmi2Status)status;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

/* --- life cycle ------------------------------------------------------------------------------- */

static void tell2(const Host *host, const char *name, Status status, const char *category, const char *sentence)
{
    ((fmi2CallbackLogger)host->logger)(host->environment, name, to2(status), category, sentence);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    Host host = {tell2, NULL, NULL, NULL, NULL};
    (void)fmuResourceLocation;
    (void)visible;
    (void)loggingOn; /* see messages.c */
    if (functions) {
        host.logger = (void (*)(void))functions->logger;
        host.environment = functions->componentEnvironment;
        host.allocate = functions->allocateMemory;
        host.release = functions->freeMemory;
    }
    if (!host.allocate || !host.release)
        return not_instantiated(&host, instanceName, MODEL_NAME " needs the callbacks allocateMemory and freeMemory");
    if (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation)
        return not_instantiated(&host, instanceName, MODEL_NAME " is for model exchange or co-simulation, not type %d",
                                (int)fmuType);
    return instantiate(&host, FMI2_MAGIC, fmuType == fmi2ModelExchange ? MODEL_EXCHANGE : CO_SIMULATION, instanceName,
                       fmuGUID, "GUID");
}

void fmi2FreeInstance(fmi2Component c)
{
    free_instance(of2(c));
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    return to2(choose_log_categories(of2(c), loggingOn, nCategories, categories));
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    return to2(set_up_experiment(of2(c), startTime, stopTimeDefined, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return to2(enter_initialisation(of2(c)));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return to2(exit_initialisation(of2(c)));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    return to2(terminate(of2(c)));
}

fmi2Status fmi2Reset(fmi2Component c)
{
    return to2(begin_again(of2(c)));
}

/* --- values ----------------------------------------------------------------------------------- */

static void write_int(void *values, size_t i, double value)
{
    ((fmi2Boolean *)values)[i] = value != 0 ? fmi2True : fmi2False;
}

static double read_int(const void *values, size_t i)
{
    return ((const fmi2Boolean *)values)[i] != fmi2False;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    return to2(get(of2(c), vr, nvr, value, write_real, 0, "Real"));
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    return to2(get(of2(c), vr, nvr, value, write_int, 1, "Boolean"));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    return to2(set(of2(c), vr, nvr, value, read_real, 0, "Real"));
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    return to2(set(of2(c), vr, nvr, value, read_int, 1, "Boolean"));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    (void)value;
    return to2(none_of(of2(c), vr, nvr, "Integer"));
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)value;
    return to2(none_of(of2(c), vr, nvr, "String"));
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    (void)value;
    return to2(none_of(of2(c), vr, nvr, "Integer"));
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)value;
    return to2(none_of(of2(c), vr, nvr, "String"));
}

/* The model description promises neither input nor output derivatives in time. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return to2(no_interpolation(of2(c)));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return to2(no_output_derivatives(of2(c)));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    return to2(directional_derivative(of2(c), vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown, "Real"));
}

/* --- states ----------------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return to2(save_state(of2(c), FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    return to2(restore_state(of2(c), FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return to2(free_state(of2(c), FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    return to2(serialised_size(of2(c), FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    return to2(serialise(of2(c), FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    return to2(deserialise(of2(c), serializedState, size, FMUstate));
}
