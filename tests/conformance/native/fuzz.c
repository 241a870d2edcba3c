/* Calls an FMU's functions in random order with random arguments, right and wrong.

   fuzz SEED CALLS, linked with the FMU's own all.c under the sanitizers. Checked besides: a status is OK, Warning,
   Discard or Error; an Error left the instance as it was; a value read is a finite number; a message has no format in
   it. Pointers are NULL, ours, or to memory that is not ours but may be read: nothing could tell others. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "guid.h"

#define INSTANCES 3
#define STATES 4
#define MOST 8
#define BLOB 8192

static uint64_t seed;
static long refusals;
static char foreign[BLOB], blob[BLOB], before[BLOB], after[BLOB];
static size_t blob_size;
static fmi2Component instances[INSTANCES];
static fmi2FMUstate states[STATES];

static unsigned pick(unsigned n) /* xorshift64* */
{
    seed ^= seed >> 12, seed ^= seed << 25, seed ^= seed >> 27;
    return (unsigned)((seed * UINT64_C(2685821657736338717)) >> 33) % n;
}

static void check(int good, const char *what)
{
    if (!good) {
        fprintf(stderr, "%s\n", what);
        abort();
    }
}

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text,
                   ...)
{
    (void)e;
    check(name && category && status > fmi2OK && status < fmi2Fatal, "logger");
    check(strlen(text) > 5 && !strchr(text, '%') && !strchr(text, '#'), text);
    refusals++;
}

static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};

static double number(void)
{
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0, -0.0, 1e300, -1e300, 1e-300, 4.9e-324};
    switch (pick(4)) {
    case 0: return odd[pick(sizeof odd / sizeof *odd)];
    case 1: return pick(2000) - 1000.0;
    case 2: return (pick(2) ? 1 : -1) * pow(10, pick(16) - 8.0);
    default: return pick(1000) / 1000.0;
    }
}

static double step(void)
{
    static const double some[] = {0.01, 0.01, 0.01, 0.001, 0.02, 1e-9, 0, -0.01, NAN, INFINITY, 1e300};
    return some[pick(sizeof some / sizeof *some)];
}

static const char *text(void)
{
    static const char *const some[] = {"", "x", "logStatusError", "logAll", FMU_GUID, "%s%n", NULL};
    return some[pick(sizeof some / sizeof *some)];
}

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
        for (size_t i = 0; status == fmi2OK && i < n; i++)
            check(isfinite(y[i]), "not finite");
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

int main(int argc, char **argv)
{
    seed = argc == 3 ? strtoull(argv[1], NULL, 10) * 2 + 1 : 1;
    long calls = argc == 3 ? atol(argv[2]) : 1000, statuses[6] = {0};
    for (long i = 0; i < calls; i++) {
        unsigned slot = pick(INSTANCES);
        if (!instances[slot] || pick(3000) == 0) {
            fmi2FreeInstance(instances[slot]);
            instances[slot] = fmi2Instantiate("fuzzed", fmi2CoSimulation, FMU_GUID, NULL, &callbacks, fmi2False, fmi2False);
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
        unsigned kind = pick(4);
        fmi2Status status = kind == 0 ? life(c) : kind == 1 ? fmi2DoStep(c, number(), step(), fmi2True) : values(c);
        check(status >= fmi2OK && status <= fmi2Error, "status");
        check(known || status != fmi2OK || kind == 0, "no instance");
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
