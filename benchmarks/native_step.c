/* One communication step of an FMU beside its bare traced functions, called in a loop from C.

   native_step LIBRARY: prints both costs in microseconds. kernel.c is what CasADi generates, untouched; kernel.h has
   sizes, start values and the GUID. Both step from the start values with the inputs held, STEPS at a time. */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "fmu.h"
#include "kernel.h"

#define STEPS 20
#define BLOCKS 100
#define REPEATS 60

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

static double microseconds(void (*steps)(void))
{
    double began = seconds();
    for (int j = 0; j < BLOCKS; j++)
        steps();
    return 1e6 * (seconds() - began) / (BLOCKS * STEPS);
}

int main(int argc, char **argv)
{
    double h = STEP / COUNT, with_fmu = 1e300, bare = 1e300;
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
    for (int i = 0; i < REPEATS; i++) { /* in turn, and the best of each: what disturbs a machine only ever adds */
        double a = microseconds(fmu_steps), b = microseconds(kernel_steps);
        with_fmu = a < with_fmu ? a : with_fmu;
        bare = b < bare ? b : bare;
    }
    printf("%.4f %.4f\n", with_fmu, bare);
    return 0;
}
