/* A correct FMI 2.0 co-simulation FMU in one file, and its single defects.
 *
 *     der(x) = gain*u - k*x  (only while `on`),   y = gain*x + u
 *
 * -DDEFECT_NAME builds it with one defect; tests/conformance/check/defects_dynamic.py lists them. BUG(NAME) is 1 in the
 * build with that defect and 0 in all others.
 */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "fmi2Functions.h"
#include "defect.h" /* written by the tests: one macro of each defect, 0 or 1 */

#ifdef PREFIXED /* as it should be in source code, and must not be in a shared library (2.3) */
#undef fmi2DoStep
#define fmi2DoStep Fixture_fmi2DoStep
#endif

#define BUG(NAME) DEFECT_##NAME
#define GUID "{8c4e810f-3df3-4a00-8276-176fa3c9f001}"

typedef enum { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16 } Mode;

/* Value references, as in modelDescription.xml. */
enum { TIME, X, DER_X, U, K, GAIN, TAU, G, Y, REALS };
enum { COUNT, MODE, INTEGERS };
enum { ON, BOOLEANS };
enum { LABEL, MESSAGE, STRINGS };

typedef struct {
    double r[REALS];
    int i[INTEGERS];
    int b[BOOLEANS];
    char label[64];
    double table[3]; /* this and the next two in FMI 3.0 only, see fixture3.c */
    unsigned long size;
    unsigned char blob[2];
    double hidden; /* integrates x, enters y with weight 1e-3: part of the state without being a variable */
} Data;

typedef struct {
    Data d;
    Mode mode;
    double start, stop;
    int logging, stop_defined, from_bytes, events;
    fmi2CallbackLogger logger;
    void (*logger3)(void *environment, int status, const char *category, const char *text);
    fmi2ComponentEnvironment environment;
    void *heap;
    char name[64];
} Fmu;

static void *last_stepped;
static double sticky;
static int instances;

static void log_message(Fmu *f, fmi2Status status, const char *category, const char *text) {
    if (!f->logging && status == fmi2OK && !BUG(LOG_OFF)) return;
    if (f->logger3)
        f->logger3(BUG(LOG_ENVIRONMENT) ? f : f->environment, status, category, text);
    else
        f->logger(BUG(LOG_ENVIRONMENT) ? f : f->environment, BUG(LOG_NAME) ? "fixture" : f->name, status, category, "%s", text);
}

static fmi2Status refuse(Fmu *f, const char *text) {
    log_message(f, fmi2Error, "logStatusError", text);
    return fmi2Error;
}

#define ALLOW(MODES) \
    if (BUG(CRASH_ON_ORDER) && !(f->mode & (MODES))) abort(); \
    if (!BUG(ORDER) && !(f->mode & (MODES))) return refuse(f, "not allowed in this mode")

static void start_values(Fmu *f) {
    double keep = f->d.r[X];
    memset(&f->d, 0, sizeof f->d);
    f->d.r[X] = BUG(RESET_FORGETS) && f->mode ? keep : 1.0;
    f->d.r[K] = BUG(START_VALUE) ? 0.6 : 0.5;
    f->d.r[U] = BUG(ZERO_INPUT) ? 1.0 : 0.0;
    f->d.r[GAIN] = 2.0;
    f->d.r[G] = 9.81;
    f->d.b[ON] = 1;
    strcpy(f->d.label, "tank");
    f->d.size = 3, f->d.table[0] = 1.0, f->d.table[1] = 2.0, f->d.table[2] = 3.0, f->d.blob[1] = 255;
    f->mode = INSTANTIATED;
}

static void calculate(Fmu *f) {
    double *r = f->d.r;
    r[TAU] = 1.0 / r[K];
    r[DER_X] = f->d.b[ON] ? r[GAIN] * r[U] - r[K] * r[X] : 0.0;
    r[Y] = r[GAIN] * r[X] + r[U] + 1e-3 * f->d.hidden + (BUG(NAN_STICKS) ? sticky : 0.0);
    if (BUG(NOT_FINITE)) r[Y] = NAN;
    if (BUG(RANDOM)) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        r[Y] += 1e-9 * now.tv_nsec;
    }
    f->d.i[MODE] = BUG(ENUMERATION) ? 7 : (r[U] > 0.0 ? 2 : 1);
}

const char *fmi2GetTypesPlatform(void) { return BUG(TYPES_PLATFORM) ? "other" : fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return BUG(VERSION) ? "2.1" : fmi2Version; }

#if DEFECT_UNRESOLVED
extern int function_that_nobody_has(void);
#else
#define function_that_nobody_has() 0
#endif

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources, (void)visible;
    if (type != fmi2CoSimulation || (strcmp(guid, GUID) && !BUG(ANY_GUID))) return NULL;
    if (BUG(NO_INSTANCE) || (BUG(ONE_INSTANCE) && instances > 0)) return NULL;
    if (BUG(NO_LICENCE)) {
        functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError", "no %s: %d", "licence", 7);
        return NULL;
    }
    Fmu *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    instances++;
    f->logger = functions->logger;
    snprintf(f->name, sizeof f->name, "%s", name);
    f->environment = functions->componentEnvironment;
    f->logging = logging;
    f->heap = malloc(20000);
    if (f->heap) memset(f->heap, 1, 20000);
    if (BUG(HANDLE_LEAK)) (void)!open("/dev/null", O_RDONLY);
    start_values(f);
    f->d.hidden += function_that_nobody_has();
    return f;
}

void fmi2FreeInstance(fmi2Component c) {
    Fmu *f = c;
    if (!f) {
        if (BUG(FREE_NULL)) abort();
        return;
    }
    instances--;
    if (!BUG(LEAK)) free(f->heap);
    if (BUG(SMALL_LEAK)) memset(malloc(32), 1, 32);
    if (!BUG(KEEPS_INSTANCE)) free(f);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    Fmu *f = c;
    (void)n, (void)categories;
    if (BUG(DEBUG_LOGGING)) return fmi2Error;
    f->logging = on;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop) {
    Fmu *f = c;
    (void)has_tolerance, (void)tolerance;
    ALLOW(INSTANTIATED);
    f->start = f->d.r[TIME] = start;
    f->stop_defined = stop_defined;
    f->stop = stop;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Fmu *f = c;
    ALLOW(INSTANTIATED);
    f->mode = INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Fmu *f = c;
    ALLOW(INITIALIZING);
    if (BUG(EXIT_FAILS) || (BUG(ZERO_INPUT) && f->d.r[U] == 0.0)) return fmi2Error;
    calculate(f);
    f->mode = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    Fmu *f = c;
    ALLOW(STEPPING);
    if (BUG(TERMINATE_FAILS)) return fmi2Error;
    f->mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    if (BUG(RESET_FAILS)) return fmi2Error;
    start_values(c);
    return fmi2OK;
}

#ifndef READABLE
#define READABLE (INITIALIZING | STEPPING | TERMINATED | FAILED)
#define SETTABLE (INSTANTIATED | INITIALIZING | STEPPING)
#endif
#define KNOWN(LIMIT) \
    if (!BUG(UNKNOWN_REFERENCE) && vr[k] >= LIMIT) return refuse(f, "unknown value reference"); \
    if (vr[k] >= LIMIT) continue

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Fmu *f = c;
    ALLOW(READABLE);
    if (f->mode == INITIALIZING) calculate(f);
    for (size_t k = 0; k < n; k++) {
        KNOWN(REALS);
        if (BUG(READ_FAILS) && vr[k] == K) return fmi2Error;
        value[k] = f->d.r[vr[k]];
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    Fmu *f = c;
    ALLOW(READABLE);
    if (f->mode == INITIALIZING) calculate(f);
    for (size_t k = 0; k < n; k++) {
        KNOWN(INTEGERS);
        value[k] = f->d.i[vr[k]];
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    Fmu *f = c;
    ALLOW(READABLE);
    for (size_t k = 0; k < n; k++) {
        KNOWN(BOOLEANS);
        value[k] = f->d.b[vr[k]];
    }
    return fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    Fmu *f = c;
    ALLOW(READABLE);
    for (size_t k = 0; k < n; k++) {
        KNOWN(STRINGS);
        value[k] = vr[k] == LABEL ? f->d.label : f->d.i[MODE] == 2 ? "filling" : "idle";
        if (BUG(STRING_NULL) && vr[k] == MESSAGE) value[k] = NULL;
        if (BUG(STRING_LATIN1) && vr[k] == MESSAGE) value[k] = "Beh\xe4lter";
    }
    return fmi2OK;
}

/* What may be set in the present mode (section 4.2.4). */
static int settable(Fmu *f, int is_input, int is_tunable, int is_exact) {
    if (BUG(FORBIDDEN_WRITE)) return 1;
    if (f->mode == STEPPING) return (is_input && !BUG(WRITE_FAILS)) || is_tunable;
    return is_input || is_tunable || is_exact;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Fmu *f = c;
    ALLOW(SETTABLE);
    for (size_t k = 0; k < n; k++) {
        KNOWN(REALS);
        if (!settable(f, vr[k] == U, vr[k] == GAIN, vr[k] == K || vr[k] == X)) return refuse(f, "not settable now");
        if (!isfinite(value[k]) && BUG(NAN_STICKS)) sticky = 1.0;
        if (!isfinite(value[k]) && !BUG(NAN_SILENT)) return refuse(f, "not finite");
        if (BUG(WRITE_IGNORED) && vr[k] == K) continue;
        f->d.r[vr[k]] = value[k];
    }
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    Fmu *f = c;
    ALLOW(SETTABLE);
    for (size_t k = 0; k < n; k++) {
        KNOWN(INTEGERS);
        if (!settable(f, 0, 0, vr[k] == COUNT)) return refuse(f, "not settable now");
        f->d.i[vr[k]] = value[k];
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    Fmu *f = c;
    ALLOW(SETTABLE);
    for (size_t k = 0; k < n; k++) {
        KNOWN(BOOLEANS);
        if (!settable(f, 1, 0, 0)) return refuse(f, "not settable now");
        f->d.b[vr[k]] = value[k];
    }
    return fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    Fmu *f = c;
    ALLOW(SETTABLE);
    for (size_t k = 0; k < n; k++) {
        KNOWN(STRINGS);
        if (!settable(f, 0, 0, vr[k] == LABEL)) return refuse(f, "not settable now");
        snprintf(f->d.label, sizeof f->d.label, "%s", value[k]);
    }
    return fmi2OK;
}

#ifndef NO_STATE_FUNCTIONS
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Fmu *copy = malloc(sizeof(Fmu));
    *copy = *(Fmu *)c;
    if (BUG(STATE_FAILS)) return fmi2Error;
    *state = copy;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Fmu *f = c, *from = state;
    double hidden = f->d.hidden;
    Data now = f->d;
    f->d = from->d;
    if (BUG(STATE_INPUTS)) f->d.r[U] = now.r[U], f->d.r[GAIN] = now.r[GAIN], f->d.b[ON] = now.b[ON];
    f->mode = from->mode;
    if (BUG(STATE_FORGETS) && !from->from_bytes) f->d.hidden = hidden;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (BUG(STATE_DANGLES) && *state) return fmi2OK;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(Fmu);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte data[], size_t size) {
    (void)c;
    memcpy(data, state, size);
    if (BUG(SERIALIZE_FORGETS)) ((Fmu *)data)->d.hidden = 0.0;
    if (BUG(SERIALIZE_ROUNDS)) ((Fmu *)data)->d.r[X] = (float)((Fmu *)data)->d.r[X];
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte data[], size_t size, fmi2FMUstate *state) {
    (void)c;
    if (BUG(DESERIALIZE_FAILS)) return fmi2Error;
    *state = malloc(size);
    memcpy(*state, data, size);
    ((Fmu *)*state)->from_bytes = 1;
    return fmi2OK;
}

#endif

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t m,
                                        const fmi2ValueReference known[], size_t n, const fmi2Real dk[],
                                        fmi2Real du[]) {
    (void)c;
    if (BUG(DIRECTIONAL)) return fmi2Error;
    for (size_t i = 0; i < m; i++) {
        du[i] = 0.0;
        for (size_t k = 0; k < n; k++)
            if (unknown[i] == Y && known[k] == U) du[i] += dk[k];
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[],
                                       const fmi2Real value[]) {
    (void)c, (void)vr, (void)n, (void)o, (void)value;
    return BUG(INPUT_DERIVATIVES) ? fmi2Error : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[],
                                        fmi2Real value[]) {
    Fmu *f = c;
    (void)o;
    for (size_t k = 0; k < n; k++) value[k] = vr[k] == X ? f->d.r[DER_X] : 0.0;
    return BUG(OUTPUT_DERIVATIVES) ? fmi2Error : fmi2OK;
}

/* What a hostile FMU does with the machine. `sleep 98765.4` is how the tests find what it left behind. */
static void misbehave(void) {
    static int spoilt;
    if (BUG(SPOILS) && !spoilt++)
        for (int i = 3; i < 16; i++) dprintf(i, "{\"end\": \"everything\"}\nnot an answer\n");
    if (BUG(HOGS)) {
        char *taken = malloc(32 << 20);
        if (taken) memset(taken, 1, 32 << 20);
        usleep(20000);
    }
    if (BUG(BIG_FILE)) {
        static char block[1 << 20];
        FILE *file = fopen("big", "a");
        if (file) fwrite(block, 1, sizeof block, file), fclose(file);
    }
    if (BUG(FORKS) && fork() == 0) pause(), _exit(0);
    if (BUG(ESCAPES) && fork() == 0) {
        setsid();
        if (fork() == 0) execlp("sleep", "sleep", "98765.4", NULL);
        _exit(0);
    }
    if (BUG(WRITES)) {
        FILE *file = fopen(getenv("AHV_TEST_WRITES"), "w");
        if (file) fputs("written", file), fclose(file);
    }
    if (BUG(PRINTS)) printf("{\"rule\": \"dynamic.crash\"}\n"), fflush(stdout);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_set_state) {
    Fmu *f = c;
    (void)no_set_state;
    ALLOW(STEPPING);
    if (h < 0.0 || isnan(h)) {
        if (BUG(CRASH_ON_BAD_STEP)) abort();
        if (BUG(SILENT_REFUSAL)) return fmi2Error;
        if (BUG(BAD_STEP)) return fmi2OK;
        refuse(f, "the step must be above 0");
        return BUG(FATAL_REFUSAL) ? fmi2Fatal : fmi2Error;
    }
    if (isnan(time) && !BUG(BAD_TIME)) return refuse(f, "the time must be a number");
    if (h == 0.0) return BUG(ZERO_STEP) ? fmi2OK : refuse(f, "the step must be above 0");
    double stop = BUG(STOP_EARLY) ? f->stop - 0.5 * h : f->stop + 1e-9 * h;
    if (f->stop_defined && !BUG(PAST_STOP) && time + h > stop) {
        refuse(f, "beyond the stop time");
        return BUG(STOP_DISCARDS) ? fmi2Discard : fmi2Error;
    }
    if (BUG(FIXED_STEP) && fabs(h - 0.01) > 1e-9) return refuse(f, "only steps of 0.01");
    if (BUG(STEP_CRASHES) && f->d.i[COUNT] == 3) abort();
    if (BUG(SLOW)) usleep(5000);
    if (BUG(STEP_HANGS) && f->d.i[COUNT] == 3) sleep(1000);
    if (BUG(STEP_FAILS) && f->d.i[COUNT] == 3) return refuse(f, "defect");
    if ((BUG(STEP_DISCARDS) || BUG(DISCARD_STATUS)) && f->d.i[COUNT] == 3) return fmi2Discard;
    if (BUG(STEP_PENDING) && f->d.i[COUNT] == 3) return fmi2Pending;
    misbehave();
    if (BUG(SHARED) && instances > 1 && last_stepped != f) f->d.hidden += 1.0;
    last_stepped = f;
    if (BUG(STEP_LEAK)) memset(malloc(1000), 1, 1000);
    calculate(f);
    f->d.hidden += h * f->d.r[X];
    f->d.r[X] += h * f->d.r[DER_X];
    f->d.r[TIME] = BUG(TIME_LAGS) ? time : time + h;
    f->d.i[COUNT]++;
    calculate(f);
    if (BUG(FIXED_DRIFTS)) f->d.r[TAU] += h;
    if (BUG(BOOLEAN)) f->d.b[ON] = 2;
    log_message(f, fmi2OK, BUG(LOG_CATEGORY) ? "unheardOf" : "logAll", "a step");
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(c, "no step is under way"); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind k, fmi2Status *v) { return (void)k, (void)v, refuse(c, "-"); }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    Fmu *f = c;
    if (BUG(DISCARD_STATUS) || k != fmi2LastSuccessfulTime) return refuse(f, "-");
    *v = f->d.r[TIME];
    return fmi2OK;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *v) {
    return (void)k, (void)v, refuse(c, "-");
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    return (void)k, (void)v, refuse(c, "-");
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *v) {
    return (void)k, (void)v, refuse(c, "-");
}
