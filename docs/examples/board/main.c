/* A controller FMU's own C on a board: no operating system, no heap, one call for each tick.

   wiring.h has the value references, see board.md; plant.h is what the board brings: sensors, actuators and a clock. */
#include <stdio.h>

#include "fmi2Functions.h"
#include "guid.h"
#include "plant.h"

/* Memory for the instance, taken once. After initialisation there is none. */
static double arena[ARENA_BYTES / sizeof(double)];
static size_t taken;
static int closed;

static void *take(size_t n, size_t size)
{
    size_t doubles = (n * size + sizeof *arena - 1) / sizeof *arena;
    if (closed || doubles > sizeof arena / sizeof *arena - taken)
        return NULL;
    taken += doubles;
    return &arena[taken - doubles];
}

static void give_back(void *memory)
{
    (void)memory;
}

/* A board without a console writes the sentence where its engineer finds it. */
static void report(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment, (void)status, (void)category;
    printf("%s: %s\n", instance, message);
}

int main(void)
{
    static const fmi2CallbackFunctions callbacks = {report, take, give_back, NULL, NULL};
    static const fmi2ValueReference inputs[N_INPUTS] = INPUTS, outputs[N_OUTPUTS] = OUTPUTS;
    fmi2Real u[N_INPUTS], y[N_OUTPUTS];
    fmi2Status status;
    fmi2Component controller =
        fmi2Instantiate("controller", fmi2CoSimulation, FMU_GUID, "", &callbacks, fmi2False, fmi2True);
    if (!controller || fmi2SetupExperiment(controller, fmi2False, 0, 0, fmi2False, 0) != fmi2OK ||
        fmi2EnterInitializationMode(controller) != fmi2OK)
        return 1;
    for (long tick = 0; measure(u); tick++) {
        status = fmi2SetReal(controller, inputs, N_INPUTS, u);
        if (status == fmi2OK && tick == 0) {
            status = fmi2ExitInitializationMode(controller);
            closed = 1;
        } else if (status == fmi2OK) {
            status = fmi2DoStep(controller, (double)(tick - 1) * STEP, STEP, fmi2True);
        }
        if (status != fmi2OK || fmi2GetReal(controller, outputs, N_OUTPUTS, y) != fmi2OK)
            return 1; /* a real board would hold the last action or hand over to another law */
        actuate(y);
    }
    return finish(taken * sizeof *arena);
}
