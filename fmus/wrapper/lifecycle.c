/* From fmi2Instantiate to fmi2FreeInstance. */

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

static void reset(State *s)
{
    memset(s, 0, sizeof *s);
    s->stop_time = INFINITY;
    s->phase = INSTANTIATED;
    s->stale = 1;
    for (int i = 0; i < NV; i++) {
        if (TABLE[i].causality == INPUT)
            s->u[TABLE[i].place] = TABLE[i].start;
        if (TABLE[i].causality == PARAMETER)
            s->p[TABLE[i].place] = TABLE[i].start;
    }
}

static fmi2Component not_instantiated(const fmi2CallbackFunctions *callbacks, const char *name, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    say(callbacks, ALL_CATEGORIES, name ? name : MODEL_NAME, fmi2Error, format, arguments);
    va_end(arguments);
    return NULL;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    Instance *instance;
    (void)fmuResourceLocation;
    (void)visible;
    (void)loggingOn; /* see messages.c */
    if (!functions || !functions->allocateMemory || !functions->freeMemory)
        return not_instantiated(functions, instanceName, MODEL_NAME " needs the callbacks allocateMemory and freeMemory");
    if (!instanceName || !instanceName[0])
        return not_instantiated(functions, instanceName, "an instance of " MODEL_NAME " needs a name");
    if (fmuType != fmi2CoSimulation)
        return not_instantiated(functions, instanceName, MODEL_NAME " is for co-simulation only");
    if (!fmuGUID || strcmp(fmuGUID, FMU_GUID) != 0)
        return not_instantiated(functions, instanceName, "the GUID %s is not that of this " MODEL_NAME ", " FMU_GUID,
                                fmuGUID ? fmuGUID : "NULL");
    instance = functions->allocateMemory(1, sizeof(Instance) + strlen(instanceName) + 1);
    if (!instance)
        return not_instantiated(functions, instanceName, "no memory for an instance of " MODEL_NAME);
    memset(instance, 0, sizeof *instance);
    instance->callbacks = *functions;
    instance->logged = ALL_CATEGORIES;
    strcpy(instance->name, instanceName);
    reset(&instance->state);
    instance->magic = INSTANCE_MAGIC;
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *instance = valid(c);
    if (!instance)
        return;
    instance->magic = 0; /* a second call with the same pointer finds no instance, while the memory is not reused */
    instance->callbacks.freeMemory(instance);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    Instance *instance = valid(c);
    unsigned logged = 0;
    if (!instance || (nCategories && !categories))
        return fmi2Error;
    for (size_t i = 0; i < nCategories; i++) {
        int known = 0;
        for (int j = 0; j < N_CATEGORIES; j++)
            if (categories[i] && strcmp(categories[i], CATEGORIES[j]) == 0) {
                logged |= j == N_CATEGORIES - 1 ? ALL_CATEGORIES : 1u << j;
                known = 1;
            }
        if (!known)
            return refuse(instance, fmi2Error, MODEL_NAME " has no log category %s",
                          categories[i] ? categories[i] : "NULL");
    }
    instance->logged = loggingOn && nCategories ? logged : ALL_CATEGORIES;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    Instance *instance = valid(c);
    char text[32], start[32];
    (void)toleranceDefined;
    (void)tolerance; /* the steps are fixed */
    if (!instance)
        return fmi2Error;
    if (instance->state.phase != INSTANTIATED)
        return refuse(instance, fmi2Error, "the experiment can be set up before initialisation only");
    if (!is_finite(startTime))
        return refuse(instance, fmi2Error, "start time %s s is not a finite number", number(text, startTime));
    if (stopTimeDefined && !(stopTime >= startTime))
        return refuse(instance, fmi2Error, "stop time %s s is not after start time %s s", number(text, stopTime),
                      number(start, startTime));
    instance->state.time = startTime;
    instance->state.stop_time = stopTimeDefined ? stopTime : INFINITY;
    instance->state.stale = 1;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    Instance *instance = valid(c);
    if (!instance)
        return fmi2Error;
    if (instance->state.phase != INSTANTIATED)
        return refuse(instance, fmi2Error, "initialisation can begin once, after instantiation or reset");
    instance->state.phase = INITIALISING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *instance = valid(c);
    char reason[SENTENCE];
    if (!instance)
        return fmi2Error;
    if (instance->state.phase != INITIALISING)
        return refuse(instance, fmi2Error, "initialisation cannot end, it has not begun");
    if (input_refused(reason, &instance->state))
        return refuse(instance, fmi2Error, "%s", reason);
    if (initialise(instance) != fmi2OK)
        return fmi2Error;
    instance->state.phase = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    Instance *instance = valid(c);
    if (!instance)
        return fmi2Error;
    if (instance->state.phase != STEPPING)
        return refuse(instance, fmi2Error, MODEL_NAME " can be terminated only after initialisation, and once");
    instance->state.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    Instance *instance = valid(c);
    if (!instance)
        return fmi2Error;
    reset(&instance->state);
    return fmi2OK;
}
