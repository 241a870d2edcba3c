/* The same FMU for FMI 3.0: the functions of fixture.c, with its defects, behind those of FMI 3.0. */
#define READABLE (INSTANTIATED | INITIALIZING | STEPPING | TERMINATED | FAILED | IN_EVENT | CONFIGURING)
#define SETTABLE (INSTANTIATED | INITIALIZING | STEPPING | IN_EVENT)
#define IN_EVENT 32
#define CONFIGURING 64
#include "fixture.c"

#include "fmi3Functions.h"

#define CALL(EXPRESSION) \
    do { \
        fmi3Status told = (fmi3Status)(EXPRESSION); \
        if (told > fmi3Warning) return told; \
    } while (0)

/* Value references are unique in FMI 3.0. */
enum { COUNT3 = 20, MODE3, ON3 = 30, LABEL3 = 40, MESSAGE3, TABLE3 = 50, SIZE3 = 60, BLOB3 = 70 };

const char *fmi3GetVersion(void) { return BUG(VERSION) ? "3.1" : "3.0"; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference needed[], size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    fmi2CallbackFunctions functions = {NULL, calloc, free, NULL, environment};
    Fmu *f = fmi2Instantiate(name, fmi2CoSimulation, token, resources, &functions, visible, logging);
    (void)early, (void)needed, (void)n, (void)update;
    if (f) f->logger3 = (void *)log, f->events = events;
    return f;
}
void fmi3FreeInstance(fmi3Instance c) { fmi2FreeInstance(c); }
fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    return (fmi3Status)fmi2SetDebugLogging(c, on, n, categories);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    CALL(fmi2SetupExperiment(c, has_tolerance, tolerance, start, has_stop, stop));
    return (fmi3Status)fmi2EnterInitializationMode(c);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    Fmu *f = c;
    CALL(fmi2ExitInitializationMode(c));
    if (f->events) f->mode = IN_EVENT;
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    Fmu *f = c;
    ALLOW(STEPPING);
    if (!f->events) return (fmi3Status)refuse(f, "event mode is not used");
    if (BUG(EVENT_REFUSED)) return (fmi3Status)refuse(f, "defect");
    f->mode = IN_EVENT;
    return fmi3OK;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    Fmu *f = c;
    ALLOW(IN_EVENT);
    *again = BUG(EVENT_RESTLESS), *ends = *nominals = *values = *defined = 0, *next = 0.0;
    return BUG(EVENT_FAILS) ? (fmi3Status)refuse(f, "defect") : fmi3OK;
}
fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    Fmu *f = c;
    ALLOW(IN_EVENT);
    f->mode = STEPPING;
    return fmi3OK;
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    Fmu *f = c;
    ALLOW(INSTANTIATED);
    if (BUG(CONFIGURE_FAILS)) return (fmi3Status)refuse(f, "defect");
    f->mode = CONFIGURING;
    return fmi3OK;
}
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    Fmu *f = c;
    ALLOW(CONFIGURING);
    f->mode = INSTANTIATED;
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return (fmi3Status)fmi2Terminate(c); }
fmi3Status fmi3Reset(fmi3Instance c) { return (fmi3Status)fmi2Reset(c); }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 h, fmi3Boolean no_set_state, fmi3Boolean *event,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *reached) {
    fmi3Status status = (fmi3Status)fmi2DoStep(c, time, h, no_set_state);
    *event = BUG(EVENT_UNASKED), *ends = 0, *early = BUG(EARLY_UNASKED);
    *reached = BUG(LAST_TIME) ? NAN : time + h;
    return status;
}

/* Types that no variable has refuse every value reference. */
#define UNUSED(TYPE) \
    fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##TYPE v[], size_t m) { \
        return (void)vr, (void)n, (void)v, (void)m, BUG(UNKNOWN_REFERENCE) ? fmi3OK : (fmi3Status)refuse(c, "unknown"); \
    } \
    fmi3Status fmi3Set##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##TYPE v[], size_t m) { \
        return (void)vr, (void)n, (void)v, (void)m, BUG(UNKNOWN_REFERENCE) ? fmi3OK : (fmi3Status)refuse(c, "unknown"); \
    }
UNUSED(Float32) UNUSED(Int8) UNUSED(UInt8) UNUSED(Int16) UNUSED(UInt16) UNUSED(UInt32)

/* Types that variables of fixture.c have: VR3 of FMI 3.0 is VR2 there. */
#define USED(TYPE, OLD, OLD_TYPE, INDEX) \
    fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##TYPE v[], size_t m) { \
        (void)m; \
        for (size_t i = 0; i < n; i++) { \
            fmi2ValueReference k = INDEX(vr[i]); \
            OLD_TYPE x = 0; \
            CALL(fmi2Get##OLD(c, &k, 1, &x)); \
            v[i] = (fmi3##TYPE)x; \
        } \
        return fmi3OK; \
    } \
    fmi3Status fmi3Set##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##TYPE v[], size_t m) { \
        (void)m; \
        for (size_t i = 0; i < n; i++) { \
            fmi2ValueReference k = INDEX(vr[i]); \
            OLD_TYPE x = (OLD_TYPE)v[i]; \
            CALL(fmi2Set##OLD(c, &k, 1, &x)); \
        } \
        return fmi3OK; \
    }
#define NOWHERE 999
#define COUNT_OF(VR) ((VR) == COUNT3 ? COUNT : NOWHERE)
#define MODE_OF(VR) ((VR) == MODE3 ? MODE : NOWHERE)
#define TEXT_OF(VR) ((VR) == LABEL3 ? LABEL : (VR) == MESSAGE3 ? MESSAGE : NOWHERE)
USED(Int32, Integer, fmi2Integer, COUNT_OF)
USED(Int64, Integer, fmi2Integer, MODE_OF)
USED(String, String, fmi2String, TEXT_OF)

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean v[], size_t m) {
    (void)m;
    for (size_t i = 0; i < n; i++) {
        fmi2ValueReference k = vr[i] == ON3 ? ON : NOWHERE;
        fmi2Boolean x = 0;
        CALL(fmi2GetBoolean(c, &k, 1, &x));
        ((unsigned char *)v)[i] = (unsigned char)x; /* 2 for the defect BOOLEAN */
    }
    return fmi3OK;
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean v[], size_t m) {
    (void)m;
    for (size_t i = 0; i < n; i++) {
        fmi2ValueReference k = vr[i] == ON3 ? ON : NOWHERE;
        fmi2Boolean x = v[i];
        CALL(fmi2SetBoolean(c, &k, 1, &x));
    }
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t m) {
    Fmu *f = c;
    fmi3Float64 *at = v;
    (void)m;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == TABLE3) {
            memcpy(at, f->d.table, sizeof f->d.table), at += 3;
            continue;
        }
        CALL(fmi2GetReal(c, &vr[i], 1, at));
        at++;
    }
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t m) {
    Fmu *f = c;
    const fmi3Float64 *at = v;
    (void)m;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == TABLE3) {
            ALLOW(SETTABLE);
            if (!BUG(ARRAY_IGNORED)) memcpy(f->d.table, at, sizeof f->d.table);
            at += 3;
            continue;
        }
        CALL(fmi2SetReal(c, &vr[i], 1, at));
        at++;
    }
    return fmi3OK;
}
fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 v[], size_t m) {
    Fmu *f = c;
    (void)m;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != SIZE3 && !BUG(UNKNOWN_REFERENCE)) return (fmi3Status)refuse(f, "unknown");
        v[i] = f->d.size;
    }
    return fmi3OK;
}
fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 v[], size_t m) {
    Fmu *f = c;
    (void)m;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != SIZE3 && !BUG(UNKNOWN_REFERENCE)) return (fmi3Status)refuse(f, "unknown");
        if (f->mode != CONFIGURING && !BUG(FORBIDDEN_WRITE)) return (fmi3Status)refuse(f, "in configuration mode only");
        if (v[i] != 3) return (fmi3Status)refuse(f, "the size is 3");
    }
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary v[], size_t m) {
    Fmu *f = c;
    (void)m;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != BLOB3 && !BUG(UNKNOWN_REFERENCE)) return (fmi3Status)refuse(f, "unknown");
        v[i] = f->d.blob, sizes[i] = sizeof f->d.blob;
    }
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary v[],
                         size_t m) {
    Fmu *f = c;
    (void)m;
    ALLOW(SETTABLE);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != BLOB3 && !BUG(UNKNOWN_REFERENCE)) return (fmi3Status)refuse(f, "unknown");
        if (vr[i] != BLOB3) continue;
        if (sizes[i] != sizeof f->d.blob) return (fmi3Status)refuse(f, "two bytes");
        memcpy(f->d.blob, v[i], sizeof f->d.blob);
    }
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { return (fmi3Status)fmi2GetFMUstate(c, state); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return (fmi3Status)fmi2SetFMUstate(c, state); }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { return (fmi3Status)fmi2FreeFMUstate(c, state); }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    return (fmi3Status)fmi2SerializedFMUstateSize(c, state, size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte data[], size_t size) {
    return (fmi3Status)fmi2SerializeFMUstate(c, state, (fmi2Byte *)data, size);
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte data[], size_t size, fmi3FMUState *state) {
    return (fmi3Status)fmi2DeSerializeFMUstate(c, (const fmi2Byte *)data, size, state);
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t m,
                                        const fmi3ValueReference known[], size_t n, const fmi3Float64 seed[], size_t s,
                                        fmi3Float64 result[], size_t r) {
    return (void)s, (void)r, (fmi3Status)fmi2GetDirectionalDerivative(c, unknown, m, known, n, seed, result);
}
fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 order[],
                                    fmi3Float64 v[], size_t m) {
    return (void)m, (fmi3Status)fmi2GetRealOutputDerivatives(c, vr, n, order, v);
}
