/* Calls an FMU's functions of FMI 2.0 in random order with random arguments, right and wrong.

   fuzz SEED CALLS [STATES], with the number of continuous states where there is model exchange; linked with the FMU's
   own all.c under the sanitizers. Checked besides: a status is OK, Warning, Discard or Error; an Error left the instance
   as it was; a value read is a finite number; a message has no format in it. Pointers are NULL, ours, or to memory that
   is not ours but may be read: nothing could tell others. */
#include "fmi2Functions.h"
#include "fuzz.h"

static fmi2Component instances[INSTANCES];
static fmi2FMUstate states[STATES];
static size_t continuous;

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text,
                   ...)
{
    (void)e;
    check(name && status > fmi2OK && status < fmi2Fatal, "logger");
    said(category, text);
}

static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};

static fmi2Component component(void)
{
    unsigned i = pick(20);
    return i == 0 ? NULL : i == 1 ? foreign : instances[i % INSTANCES];
}

static size_t serialise(fmi2Component c, char *bytes)
{
    fmi2FMUstate state = NULL;
    size_t size = 0;
    check(fmi2GetFMUstate(c, &state) == fmi2OK && fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK, "state");
    check(size <= BLOB && fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK, "serialise");
    check(fmi2FreeFMUstate(c, &state) == fmi2OK && !state, "free state");
    return size;
}

static fmi2Status restore(fmi2Component c)
{
    fmi2FMUstate *state = &states[pick(STATES)];
    size_t size = pick(20) ? blob_size : pick(BLOB);
    memcpy(after, blob, BLOB);
    if (pick(2))
        after[pick((unsigned)blob_size + 1)] ^= (char)(1 << pick(8));
    return fmi2DeSerializeFMUstate(c, pick(30) ? after : foreign, size, state);
}

static fmi2Status values(fmi2Component c)
{
    fmi2ValueReference vr[MOST], known[MOST];
    fmi2Real x[MOST], y[MOST];
    fmi2Integer k[MOST];
    fmi2Boolean b[MOST];
    fmi2String s[MOST];
    fmi2Status status;
    size_t n = pick(4) ? 1 : pick(MOST + 1), m = pick(MOST + 1);
    for (int i = 0; i < MOST; i++) {
        vr[i] = pick(50) ? pick(120) : pick(1u << 31);
        known[i] = pick(70);
        x[i] = number(), k[i] = b[i] = (int)pick(3), s[i] = text();
    }
    switch (pick(14)) {
    case 0: case 1: case 2: case 3: return fmi2SetReal(c, pick(50) ? vr : NULL, n, x);
    case 4: return fmi2SetBoolean(c, vr, n, b);
    case 5: return fmi2SetInteger(c, vr, n, k);
    case 6: return fmi2SetString(c, vr, n, s);
    case 7: return fmi2GetBoolean(c, vr, n, pick(50) ? b : NULL);
    case 8: return fmi2GetInteger(c, vr, n, k);
    case 9: return fmi2GetString(c, vr, n, s);
    case 10: return fmi2GetDirectionalDerivative(c, vr, n, known, m, x, y);
    case 11: return fmi2SetRealInputDerivatives(c, vr, n, k, x);
    default:
        status = fmi2GetReal(c, vr, n, y);
        all_finite(y, status == fmi2OK ? n : 0);
        return status;
    }
}

static fmi2Status status_of(fmi2Component c)
{
    fmi2Status status;
    fmi2Real x;
    fmi2Integer k;
    fmi2Boolean b;
    fmi2String s;
    fmi2StatusKind kind = (fmi2StatusKind)pick(5);
    switch (pick(5)) {
    case 0: return fmi2GetStatus(c, kind, pick(9) ? &status : NULL);
    case 1: return fmi2GetRealStatus(c, kind, pick(9) ? &x : NULL);
    case 2: return fmi2GetIntegerStatus(c, kind, &k);
    case 3: return fmi2GetBooleanStatus(c, kind, &b);
    default: return fmi2GetStringStatus(c, kind, &s);
    }
}

static fmi2Status life(fmi2Component c)
{
    fmi2String categories[] = {text(), text()};
    fmi2FMUstate *state = &states[pick(STATES)], strange = foreign;
    size_t size;
    switch (pick(16)) {
    case 0: return fmi2SetupExperiment(c, fmi2True, number(), pick(3) ? 0 : number(), pick(2) != 0, pick(3) ? 1e3 : number());
    case 1: case 2: return fmi2EnterInitializationMode(c);
    case 3: case 4: return fmi2ExitInitializationMode(c);
    case 5: return pick(20) ? fmi2OK : fmi2Terminate(c);
    case 6: return pick(20) ? fmi2OK : fmi2Reset(c);
    case 7: return fmi2GetFMUstate(c, pick(9) ? state : pick(2) ? &strange : NULL);
    case 8: return fmi2SetFMUstate(c, pick(9) ? *state : strange);
    case 9: return fmi2FreeFMUstate(c, pick(9) ? state : pick(2) ? &strange : NULL);
    case 10: return fmi2SerializedFMUstateSize(c, *state, &size);
    case 11: return restore(c);
    case 12: return fmi2SetDebugLogging(c, pick(2) != 0, pick(3), pick(9) ? categories : NULL);
    case 13: return fmi2CancelStep(c);
    case 14: return status_of(c);
    default: return fmi2SerializeFMUstate(c, *state, after, pick(BLOB));
    }
}

static fmi2Status exchange(fmi2Component c)
{
    static fmi2Real last[64];
    fmi2Real x[64] = {0};
    fmi2EventInfo info;
    fmi2Boolean event, ends;
    fmi2Status status;
    size_t n = pick(9) ? continuous : pick(64);
    switch (pick(12)) {
    case 0: return pick(3) ? fmi2OK : fmi2EnterEventMode(c);
    case 1: return fmi2NewDiscreteStates(c, pick(9) ? &info : NULL);
    case 2: case 3: return fmi2EnterContinuousTimeMode(c);
    case 4: return fmi2CompletedIntegratorStep(c, fmi2True, &event, pick(9) ? &ends : NULL);
    case 5: return fmi2SetTime(c, number());
    case 6:
        memcpy(x, last, sizeof x);
        x[pick(64)] += pick(3) ? 0.001 : number();
        return fmi2SetContinuousStates(c, pick(20) ? x : NULL, n);
    case 7:
        status = fmi2GetContinuousStates(c, pick(9) ? x : NULL, n);
        if (status == fmi2OK)
            memcpy(last, x, sizeof last);
        return status;
    case 8: return fmi2GetNominalsOfContinuousStates(c, x, n);
    case 9: return fmi2GetEventIndicators(c, x, pick(2));
    default:
        status = fmi2GetDerivatives(c, pick(20) ? x : NULL, n);
        all_finite(x, status == fmi2OK ? n : 0);
        return status;
    }
}

int main(int argc, char **argv)
{
    seed = argc > 2 ? strtoull(argv[1], NULL, 10) * 2 + 1 : 1;
    long calls = argc > 2 ? atol(argv[2]) : 1000, statuses[6] = {0};
    continuous = argc > 3 ? (size_t)atol(argv[3]) : 0;
    for (long i = 0; i < calls; i++) {
        unsigned slot = pick(INSTANCES);
        if (!instances[slot] || pick(3000) == 0) {
            fmi2FreeInstance(instances[slot]);
            instances[slot] = fmi2Instantiate("fuzzed", continuous && pick(2) ? fmi2ModelExchange : fmi2CoSimulation, FMU_GUID,
                                              NULL, &callbacks, fmi2False, fmi2False);
            check(instances[slot] != NULL, "not instantiated");
            check(!fmi2Instantiate(text(), (fmi2Type)pick(3), "{wrong}", text(), pick(2) ? &callbacks : NULL, 0, 0), "GUID");
            if (pick(4)) {
                fmi2EnterInitializationMode(instances[slot]);
                fmi2ExitInitializationMode(instances[slot]);
            }
            blob_size = serialise(instances[slot], blob);
        }
        fmi2Component c = component();
        int known = c && c != foreign;
        size_t size = known ? serialise(c, before) : 0;
        unsigned kind = pick(5);
        fmi2Status status = kind == 0 ? life(c) : kind == 1 ? fmi2DoStep(c, number(), step(), fmi2True)
                            : kind == 2 ? exchange(c) : values(c);
        check(status >= fmi2OK && status <= fmi2Error, "status");
        check(known || status != fmi2OK || kind == 0 || kind == 2, "no instance");
        statuses[status]++;
        if (known && status == fmi2Error && kind != 1)
            check(serialise(c, after) == size && memcmp(before, after, size) == 0, "an error changed the instance");
    }
    for (int i = 0; i < STATES; i++)
        fmi2FreeFMUstate(instances[0], &states[i]);
    for (int i = 0; i < INSTANCES; i++)
        fmi2FreeInstance(instances[i]);
    printf("%ld calls: %ld OK, %ld discarded, %ld errors; %ld messages\n", calls, statuses[fmi2OK],
           statuses[fmi2Discard], statuses[fmi2Error], refusals);
    return 0;
}
