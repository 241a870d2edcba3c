/* Two controllers and a plant of two versions of FMI in one program, which links their sources: all.c of each is
   compiled with names of its own. Prints the outputs of all three after each of STEPS steps, in hexadecimal. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"
#include "wiring.h"

#define STEP 0.01

/* As -DFMI2_FUNCTION_PREFIX=A_ has named them. */
#define FMI2(prefix) \
    extern fmi2InstantiateTYPE prefix##fmi2Instantiate; \
    extern fmi2SetupExperimentTYPE prefix##fmi2SetupExperiment; \
    extern fmi2EnterInitializationModeTYPE prefix##fmi2EnterInitializationMode; \
    extern fmi2ExitInitializationModeTYPE prefix##fmi2ExitInitializationMode; \
    extern fmi2SetRealTYPE prefix##fmi2SetReal; \
    extern fmi2GetRealTYPE prefix##fmi2GetReal; \
    extern fmi2DoStepTYPE prefix##fmi2DoStep; \
    extern fmi2FreeInstanceTYPE prefix##fmi2FreeInstance

FMI2(A_);
FMI2(B_);
extern fmi3InstantiateCoSimulationTYPE C_fmi3InstantiateCoSimulation;
extern fmi3EnterInitializationModeTYPE C_fmi3EnterInitializationMode;
extern fmi3ExitInitializationModeTYPE C_fmi3ExitInitializationMode;
extern fmi3SetFloat64TYPE C_fmi3SetFloat64;
extern fmi3GetFloat64TYPE C_fmi3GetFloat64;
extern fmi3DoStepTYPE C_fmi3DoStep;
extern fmi3FreeInstanceTYPE C_fmi3FreeInstance;

static void report(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text,
                   ...)
{
    (void)e, (void)category;
    fprintf(stderr, "%s: %d, %s\n", name, (int)status, text);
}

static void ok(int status)
{
    if (status != 0)
        exit(1);
}

int main(void)
{
    static const fmi2CallbackFunctions callbacks = {report, calloc, free, NULL, NULL};
    static const unsigned a_measured[] = A_MEASURED, a_actions[] = A_ACTIONS, b_measured[] = B_MEASURED,
                          b_actions[] = B_ACTIONS;
    static const fmi3ValueReference measures[] = C_MEASURES, actuated[] = C_ACTUATED;
    double x[5], u[2], v[2], reached;
    fmi3Boolean event, end, early;
    fmi2Component a = A_fmi2Instantiate("a", fmi2CoSimulation, A_GUID, "", &callbacks, 0, 0);
    fmi2Component b = B_fmi2Instantiate("b", fmi2CoSimulation, B_GUID, "", &callbacks, 0, 0);
    fmi3Instance c = C_fmi3InstantiateCoSimulation("c", C_GUID, "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    ok(!a || !b || !c);
    ok(A_fmi2SetupExperiment(a, 0, 0, 0, 0, 0) | B_fmi2SetupExperiment(b, 0, 0, 0, 0, 0));
    ok(A_fmi2EnterInitializationMode(a) | B_fmi2EnterInitializationMode(b));
    ok(C_fmi3EnterInitializationMode(c, 0, 0, 0, 0, 0));
    ok(A_fmi2ExitInitializationMode(a) | B_fmi2ExitInitializationMode(b) | C_fmi3ExitInitializationMode(c));
    for (int k = 0; k < STEPS; k++) {
        ok(C_fmi3GetFloat64(c, measures, 5, x, 5));
        ok(A_fmi2SetReal(a, a_measured, 5, x) | B_fmi2SetReal(b, b_measured, 5, x));
        ok(A_fmi2DoStep(a, k * STEP, STEP, 1) | B_fmi2DoStep(b, k * STEP, STEP, 1));
        ok(A_fmi2GetReal(a, a_actions, 2, u) | B_fmi2GetReal(b, b_actions, 2, v));
        ok(C_fmi3SetFloat64(c, actuated, 2, u, 2));
        ok(C_fmi3DoStep(c, k * STEP, STEP, 1, &event, &end, &early, &reached));
        printf("%a %a %a %a %a %a\n", u[0], u[1], v[0], v[1], x[0], x[1]);
    }
    A_fmi2FreeInstance(a);
    B_fmi2FreeInstance(b);
    C_fmi3FreeInstance(c);
    return 0;
}
