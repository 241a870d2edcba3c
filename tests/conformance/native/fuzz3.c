/* Calls an FMU's functions of FMI 3.0 in random order with random arguments; otherwise as fuzz.c. */
#include "fmi3Functions.h"
#include "fuzz.h"

static fmi3Instance instances[INSTANCES];
static fmi3FMUState states[STATES];
static size_t continuous;

static void logger(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String sentence)
{
    (void)e;
    check(status > fmi3OK && status < fmi3Fatal, "logger");
    said(category, sentence);
}

static fmi3Instance instance(void)
{
    unsigned i = pick(20);
    return i == 0 ? NULL : i == 1 ? foreign : instances[i % INSTANCES];
}

static size_t serialise(fmi3Instance c, char *bytes)
{
    fmi3FMUState state = NULL;
    size_t size = 0;
    check(fmi3GetFMUState(c, &state) == fmi3OK && fmi3SerializedFMUStateSize(c, state, &size) == fmi3OK, "state");
    check(size <= BLOB && fmi3SerializeFMUState(c, state, (fmi3Byte *)bytes, size) == fmi3OK, "serialise");
    check(fmi3FreeFMUState(c, &state) == fmi3OK && !state, "free state");
    return size;
}

static fmi3Status restore(fmi3Instance c)
{
    fmi3FMUState *state = &states[pick(STATES)];
    size_t size = pick(20) ? blob_size : pick(BLOB);
    memcpy(after, blob, BLOB);
    if (pick(2))
        after[pick((unsigned)blob_size + 1)] ^= (char)(1 << pick(8));
    return fmi3DeserializeFMUState(c, (const fmi3Byte *)(pick(30) ? after : foreign), size, state);
}

static fmi3Status values(fmi3Instance c)
{
    fmi3ValueReference vr[MOST], known[MOST];
    fmi3Float64 x[MOST], y[MOST];
    fmi3Float32 f[MOST] = {0};
    fmi3Int64 k[MOST] = {0};
    fmi3Boolean b[MOST];
    fmi3String s[MOST];
    fmi3Binary bytes[MOST] = {NULL};
    fmi3Clock clocks[MOST] = {0};
    size_t sizes[MOST] = {0}, n = pick(4) ? 1 : pick(MOST + 1), m = pick(MOST + 1), values = pick(30) ? n : pick(MOST);
    fmi3Status status;
    for (int i = 0; i < MOST; i++) {
        vr[i] = pick(50) ? pick(120) : pick(1u << 31);
        known[i] = pick(100);
        x[i] = number(), b[i] = pick(2) != 0, s[i] = text();
    }
    switch (pick(16)) {
    case 0: case 1: case 2: case 3: return fmi3SetFloat64(c, pick(50) ? vr : NULL, n, x, values);
    case 4: return fmi3SetBoolean(c, vr, n, b, values);
    case 5: return fmi3SetInt64(c, vr, n, k, values);
    case 6: return fmi3SetString(c, vr, n, s, values);
    case 7: return fmi3GetBoolean(c, vr, n, pick(50) ? b : NULL, values);
    case 8: return fmi3GetFloat32(c, vr, n, f, values);
    case 9: return fmi3GetBinary(c, vr, n, sizes, bytes, values);
    case 10: return fmi3GetClock(c, vr, n, clocks);
    case 11: return fmi3GetDirectionalDerivative(c, vr, n, known, m, x, pick(9) ? m : n, y, n);
    case 12: return fmi3GetAdjointDerivative(c, vr, n, known, m, x, n, y, pick(9) ? m : n);
    default:
        status = fmi3GetFloat64(c, vr, n, y, values);
        all_finite(y, status == fmi3OK ? n : 0);
        return status;
    }
}

static fmi3Status life(fmi3Instance c)
{
    fmi3String categories[] = {text(), text()};
    fmi3FMUState *state = &states[pick(STATES)], strange = foreign;
    size_t size;
    switch (pick(16)) {
    case 0: case 1: case 2:
        return fmi3EnterInitializationMode(c, 1, number(), pick(3) ? 0 : number(), pick(2) != 0, pick(3) ? 1e3 : number());
    case 3: case 4: return fmi3ExitInitializationMode(c);
    case 5: return pick(20) ? fmi3OK : fmi3Terminate(c);
    case 6: return pick(20) ? fmi3OK : fmi3Reset(c);
    case 7: return fmi3GetFMUState(c, pick(9) ? state : pick(2) ? &strange : NULL);
    case 8: return fmi3SetFMUState(c, pick(9) ? *state : strange);
    case 9: return fmi3FreeFMUState(c, pick(9) ? state : pick(2) ? &strange : NULL);
    case 10: return fmi3SerializedFMUStateSize(c, *state, &size);
    case 11: return restore(c);
    case 12: return fmi3SetDebugLogging(c, pick(2) != 0, pick(3), pick(9) ? categories : NULL);
    case 13: return pick(2) ? fmi3EnterConfigurationMode(c) : fmi3ExitConfigurationMode(c);
    case 14: return pick(2) ? fmi3EnterStepMode(c) : fmi3GetNumberOfVariableDependencies(c, pick(100), &size);
    default: return fmi3SerializeFMUState(c, *state, (fmi3Byte *)after, pick(BLOB));
    }
}

static fmi3Status exchange(fmi3Instance c)
{
    static fmi3Float64 last[64];
    fmi3Float64 x[64] = {0}, next;
    fmi3Boolean flag[5];
    fmi3Status status;
    size_t n = pick(9) ? continuous : pick(64);
    switch (pick(12)) {
    case 0: return pick(3) ? fmi3OK : fmi3EnterEventMode(c);
    case 1: return fmi3UpdateDiscreteStates(c, flag, flag + 1, flag + 2, flag + 3, flag + 4, pick(9) ? &next : NULL);
    case 2: case 3: return fmi3EnterContinuousTimeMode(c);
    case 4: return fmi3CompletedIntegratorStep(c, 1, flag, pick(9) ? flag + 1 : NULL);
    case 5: return pick(9) ? fmi3SetTime(c, number()) : fmi3GetNumberOfContinuousStates(c, pick(9) ? &n : NULL);
    case 6:
        memcpy(x, last, sizeof x);
        x[pick(64)] += pick(3) ? 0.001 : number();
        return fmi3SetContinuousStates(c, pick(20) ? x : NULL, n);
    case 7:
        status = fmi3GetContinuousStates(c, pick(9) ? x : NULL, n);
        if (status == fmi3OK)
            memcpy(last, x, sizeof last);
        return status;
    case 8: return fmi3GetNominalsOfContinuousStates(c, x, n);
    case 9: return fmi3GetEventIndicators(c, x, pick(2));
    default:
        status = fmi3GetContinuousStateDerivatives(c, pick(20) ? x : NULL, n);
        all_finite(x, status == fmi3OK ? n : 0);
        return status;
    }
}

static fmi3Status step_by(fmi3Instance c)
{
    fmi3Boolean event, ends, early;
    fmi3Float64 reached;
    return fmi3DoStep(c, number(), step(), 1, &event, &ends, &early, pick(20) ? &reached : NULL);
}

static fmi3Instance make(const char *name, const char *token)
{
    fmi3LogMessageCallback log = pick(9) ? logger : NULL;
    if (continuous && pick(2))
        return fmi3InstantiateModelExchange(name, token, text(), 0, 0, NULL, log);
    return fmi3InstantiateCoSimulation(name, token, text(), 0, 0, 0, pick(2) != 0, NULL, 0, NULL, log, NULL);
}

int main(int argc, char **argv)
{
    seed = argc > 2 ? strtoull(argv[1], NULL, 10) * 2 + 1 : 1;
    long calls = argc > 2 ? atol(argv[2]) : 1000, statuses[5] = {0};
    continuous = argc > 3 ? (size_t)atol(argv[3]) : 0;
    for (long i = 0; i < calls; i++) {
        unsigned slot = pick(INSTANCES);
        if (!instances[slot] || pick(3000) == 0) {
            fmi3FreeInstance(instances[slot]);
            instances[slot] = make("fuzzed", FMU_GUID);
            check(instances[slot] != NULL, "not instantiated");
            check(!make(text(), "{wrong}"), "token");
            check(!fmi3InstantiateCoSimulation("x", FMU_GUID, "", 0, 0, pick(2) != 0, 0, NULL, 1, NULL, logger, NULL),
                  "intermediate");
            if (pick(4)) {
                fmi3EnterInitializationMode(instances[slot], 0, 0, 0, 0, 0);
                fmi3ExitInitializationMode(instances[slot]);
            }
            blob_size = serialise(instances[slot], blob);
        }
        fmi3Instance c = instance();
        int known = c && c != foreign;
        size_t size = known ? serialise(c, before) : 0;
        unsigned kind = pick(5);
        fmi3Status status = kind == 0 ? life(c) : kind == 1 ? step_by(c) : kind == 2 ? exchange(c) : values(c);
        check(status >= fmi3OK && status <= fmi3Error, "status");
        check(known || status != fmi3OK || kind == 0 || kind == 2, "no instance");
        statuses[status]++;
        if (known && status == fmi3Error && kind != 1)
            check(serialise(c, after) == size && memcmp(before, after, size) == 0, "an error changed the instance");
    }
    for (int i = 0; i < STATES; i++)
        fmi3FreeFMUState(instances[0], &states[i]);
    for (int i = 0; i < INSTANCES; i++)
        fmi3FreeInstance(instances[i]);
    printf("%ld calls: %ld OK, %ld discarded, %ld errors; %ld messages\n", calls, statuses[fmi3OK],
           statuses[fmi3Discard], statuses[fmi3Error], refusals);
    return 0;
}
