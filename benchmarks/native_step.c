/* One communication step of FMUs beside the bare functions of the first one, called in a loop from C.

   native_step LIBRARY GUID [LIBRARY GUID]...: prints microseconds, a line for each of ROUNDS: the FMUs in this order,
   then the bare functions. All step from near the start with the inputs held, STEPS at
   a time, by turns. */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "fmu.h"

#define STEP 0.01
#define STEPS 20
#define BLOCKS 10
#define ROUNDS 500
#define MOST 8

void bare_begin(double step);
void bare_steps(int steps);

static struct {
    Fmu fmu;
    fmi2Component component;
    fmi2FMUstate state;
} flown[MOST];

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void begin_fmu(int i, const char *library, const char *guid)
{
    flown[i].fmu = load(library, guid);
    flown[i].component = begin(&flown[i].fmu, "timed");
    ok(flown[i].fmu.ExitInitializationMode(flown[i].component), "ExitInitializationMode");
    ok(flown[i].fmu.DoStep(flown[i].component, 0, STEP, fmi2True), "DoStep"); /* the first one prepares for others */
    ok(flown[i].fmu.GetFMUstate(flown[i].component, &flown[i].state), "GetFMUstate");
}

static void fmu_steps(int i)
{
    const Fmu *fmu = &flown[i].fmu;
    fmu->SetFMUstate(flown[i].component, flown[i].state);
    for (int k = 1; k <= STEPS; k++)
        ok(fmu->DoStep(flown[i].component, k * STEP, STEP, fmi2True), "DoStep");
}

/* Microseconds for one step of FMU `i`, or of the bare functions where i < 0. */
static double timed(int i)
{
    double began = seconds();
    for (int j = 0; j < BLOCKS; j++)
        if (i < 0)
            bare_steps(STEPS);
        else
            fmu_steps(i);
    return 1e6 * (seconds() - began) / (BLOCKS * STEPS);
}

int main(int argc, char **argv)
{
    int count = (argc - 1) / 2;
    if (argc % 2 == 0 || count < 1 || count > MOST)
        fail("native_step LIBRARY GUID [LIBRARY GUID]...", "wrong arguments");
    for (int i = 0; i < count; i++)
        begin_fmu(i, argv[1 + 2 * i], argv[2 + 2 * i]);
    bare_begin(STEP);
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < count; i++)
            printf("%.5f ", timed(i));
        printf("%.5f\n", timed(-1));
    }
    return 0;
}
