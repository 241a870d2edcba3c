/* The door of FMI 3.0, for co-simulation and model exchange: without event mode in co-simulation, intermediate update,
   clocks, or arrays. */

#include "fmi3Functions.h"

#define FMI3_MAGIC UINT64_C(0x31534e4955484133)

static Instance *of3(fmi3Instance c)
{
    Instance *instance = c;
    return instance && instance->magic == FMI3_MAGIC ? instance : NULL;
}

static fmi3Status to3(Status status)
{
    return (fmi3Status)status;
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

/* --- life cycle ------------------------------------------------------------------------------- */

static void tell3(const Host *host, const char *name, Status status, const char *category, const char *sentence)
{
    (void)name;
    ((fmi3LogMessageCallback)host->logger)(host->environment, to3(status), category, sentence);
}

static Host host3(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logMessage)
{
    return (Host){tell3, (void (*)(void))logMessage, environment, calloc, free};
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    const Host host = host3(instanceEnvironment, logMessage);
    (void)resourcePath, (void)visible, (void)loggingOn; /* see messages.c */
    return instantiate(&host, FMI3_MAGIC, MODEL_EXCHANGE, instanceName, instantiationToken, "instantiation token");
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    const Host host = host3(instanceEnvironment, logMessage);
    (void)resourcePath, (void)visible, (void)loggingOn, (void)earlyReturnAllowed, (void)requiredIntermediateVariables;
    (void)intermediateUpdate;
    if (eventModeUsed)
        return not_instantiated(&host, instanceName, MODEL_NAME " has no event mode in co-simulation");
    if (nRequiredIntermediateVariables)
        return not_instantiated(&host, instanceName, MODEL_NAME " has no intermediate update of variables");
    return instantiate(&host, FMI3_MAGIC, CO_SIMULATION, instanceName, instantiationToken, "instantiation token");
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    const Host host = host3(instanceEnvironment, logMessage);
    (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    return not_instantiated(&host, instanceName, MODEL_NAME " is not for scheduled execution");
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free_instance(of3(instance));
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    return to3(choose_log_categories(of3(instance), loggingOn, nCategories, categories));
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    Instance *c = of3(instance);
    (void)toleranceDefined, (void)tolerance;
    if (c && c->state.phase == INSTANTIATED) {
        Status status = set_up_experiment(c, startTime, stopTimeDefined, stopTime);
        if (status != OK)
            return to3(status);
    }
    return to3(enter_initialisation(c));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    return to3(exit_initialisation(of3(instance)));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return to3(terminate(of3(instance)));
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    return to3(begin_again(of3(instance)));
}

/* --- values ----------------------------------------------------------------------------------- */

static void write_bool(void *values, size_t i, double value)
{
    ((fmi3Boolean *)values)[i] = value != 0;
}

static double read_bool(const void *values, size_t i)
{
    return ((const fmi3Boolean *)values)[i];
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues)
{
    Instance *c = of3(instance);
    if (!one_each(c, nValueReferences, nValues))
        return fmi3Error;
    return to3(get(c, valueReferences, nValueReferences, values, write_real, 0, "Float64"));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues)
{
    Instance *c = of3(instance);
    if (!one_each(c, nValueReferences, nValues))
        return fmi3Error;
    return to3(set(c, valueReferences, nValueReferences, values, read_real, 0, "Float64"));
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues)
{
    Instance *c = of3(instance);
    if (!one_each(c, nValueReferences, nValues))
        return fmi3Error;
    return to3(get(c, valueReferences, nValueReferences, values, write_bool, 1, "Boolean"));
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues)
{
    Instance *c = of3(instance);
    if (!one_each(c, nValueReferences, nValues))
        return fmi3Error;
    return to3(set(c, valueReferences, nValueReferences, values, read_bool, 1, "Boolean"));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    Instance *c = of3(instance);
    if (!one_each(c, nKnowns, nSeed) || !one_each(c, nUnknowns, nSensitivity))
        return fmi3Error;
    return to3(directional_derivative(c, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity, "Float64"));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    Instance *c = of3(instance);
    if (!one_each(c, nUnknowns, nSeed) || !one_each(c, nKnowns, nSensitivity))
        return fmi3Error;
    return to3(adjoint_derivative(c, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity, "Float64"));
}

/* --- states ----------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    return to3(save_state(of3(instance), FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    return to3(restore_state(of3(instance), FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    return to3(free_state(of3(instance), FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    return to3(serialised_size(of3(instance), FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    return to3(serialise(of3(instance), FMUState, serializedState, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState)
{
    return to3(deserialise(of3(instance), serializedState, size, FMUState));
}
