/* One communication step of an FMU beside its bare traced functions, called in a loop from C.

   native_step LIBRARY: prints both costs in microseconds. kernel.c is what CasADi generates, untouched; kernel.h has
   sizes, start values and the GUID. Both step from the start values with the inputs held, STEPS at a time. */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "fmu.h"
#include "kernel.h"

#define STEPS 20
#define BLOCKS 500
#define REPEATS 15

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static const double u[] = U, p[] = P;
static double x0[NX + 1], c[NC + 1], y[NY + 1];

static void kernel_steps(void)
{
    double x[2][NX + 1], t = 0, h = STEP / COUNT;
    memcpy(x[0], x0, sizeof x0);
    for (int k = 0, from = 0; k < STEPS; k++) {
        for (int i = 0; i < COUNT; i++, from = !from) {
            const double *arg[] = {&t, &h, x[from], u, p, c};
            double *res[] = {x[!from]};
            advance(arg, res, NULL, NULL, 0);
        }
        const double *arg[] = {&t, x[from], u, p};
        double *res[] = {y};
        outputs(arg, res, NULL, NULL, 0);
    }
}

static Fmu fmu;
static fmi2Component component;
static fmi2FMUstate state;

static void fmu_steps(void)
{
    fmu.SetFMUstate(component, state);
    for (int k = 0; k < STEPS; k++)
        ok(fmu.DoStep(component, k * STEP, STEP, fmi2True), "DoStep");
}

/* Best of several, for what disturbs a machine only ever adds. */
static double microseconds(void (*steps)(void))
{
    double best = 1e300;
    for (int i = 0; i < REPEATS; i++) {
        double began = seconds();
        for (int j = 0; j < BLOCKS; j++)
            steps();
        double spent = 1e6 * (seconds() - began) / (BLOCKS * STEPS);
        best = spent < best ? spent : best;
    }
    return best;
}

int main(int argc, char **argv)
{
    double h = STEP / COUNT;
    const double *start_arg[] = {u, p}, *prepare_arg[] = {p, &h};
    double *start_res[] = {x0}, *prepare_res[] = {c};
    if (argc != 2)
        fail("native_step LIBRARY", "wrong arguments");
    start(start_arg, start_res, NULL, NULL, 0);
    prepare(prepare_arg, prepare_res, NULL, NULL, 0);
    fmu = load(argv[1], GUID);
    component = begin(&fmu, "timed");
    ok(fmu.ExitInitializationMode(component), "ExitInitializationMode");
    ok(fmu.GetFMUstate(component, &state), "GetFMUstate");
    printf("%.4f %.4f\n", microseconds(fmu_steps), microseconds(kernel_steps));
    return 0;
}
