/* Every single communication step of a controller timed: fmi2SetReal, fmi2DoStep, fmi2GetReal, as a real-time task calls.

   worst_step LIBRARY STEPS: the cost of each step in nanoseconds, as STEPS 4-byte integers on stdout; on stderr the
   allocations that the FMU asked for before and after initialisation ended. step.h has the value references, start
   values and GUID. The inputs wander around their start, far enough for both actuators to reach their limits. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdint.h>
#include <time.h>

#include "fmu.h"
#include "step.h"

static unsigned allocations;

static void *counted(size_t count, size_t size)
{
    allocations++;
    return calloc(count, size);
}

static int64_t nanoseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

int main(int argc, char **argv)
{
    static const fmi2ValueReference inputs[] = INPUTS, outputs[] = OUTPUTS;
    static const double start[] = START, swing[] = SWING;
    enum { N = sizeof start / sizeof *start, M = sizeof outputs / sizeof *outputs };
    fmi2CallbackFunctions callbacks = {report, counted, free, NULL, NULL};
    double u[N], y[M];
    if (argc != 3)
        fail("worst_step LIBRARY STEPS", "wrong arguments");
    long steps = atol(argv[2]);
    int32_t *cost = malloc((size_t)steps * sizeof *cost);
    Fmu fmu = load(argv[1], GUID);
    fmi2Component c = fmu.Instantiate("timed", fmi2CoSimulation, GUID, "", &callbacks, fmi2False, fmi2False);
    if (!c || !cost)
        fail("no memory for", "the measurement");
    memset(cost, 0, (size_t)steps * sizeof *cost); /* the pages are there before the clock runs */
    ok(fmu.SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0), "SetupExperiment");
    ok(fmu.EnterInitializationMode(c), "EnterInitializationMode");
    ok(fmu.SetReal(c, inputs, N, start), "SetReal");
    ok(fmu.ExitInitializationMode(c), "ExitInitializationMode");
    unsigned before = allocations;
    for (long k = 0; k < steps; k++) {
        for (int i = 0; i < N; i++)
            u[i] = start[i] + swing[i] * sin(1e-3 * (i + 1) * (double)k);
        int64_t began = nanoseconds();
        fmi2Status set = fmu.SetReal(c, inputs, N, u), done = fmu.DoStep(c, (double)k * STEP, STEP, fmi2True),
                   got = fmu.GetReal(c, outputs, M, y);
        cost[k] = (int32_t)(nanoseconds() - began);
        ok(set, "SetReal"), ok(done, "DoStep"), ok(got, "GetReal");
    }
    fprintf(stderr, "%u %u\n", before, allocations - before);
    fwrite(cost, sizeof *cost, (size_t)steps, stdout);
    fmu.FreeInstance(c);
    return 0;
}
