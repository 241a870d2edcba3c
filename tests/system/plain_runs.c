/* Flies an FMU of FMI 2.0 again and again: from each run's inputs on stdin (doubles) to its least output on stdout.
 *
 *     plain_runs LIBRARY GUID RESOURCES STEPS STEP OUTPUT INPUT...      (the last ones are value references)
 */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include "fmi2FunctionTypes.h"

#define MOST 16

static void silent(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {}

#define FUNCTION(name) name##TYPE *name = (name##TYPE *)dlsym(library, #name); if (!name) return 2

int main(int count, char **words) {
    void *library = dlopen(words[1], RTLD_NOW);
    if (!library) return 2;
    FUNCTION(fmi2Instantiate); FUNCTION(fmi2SetupExperiment); FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode); FUNCTION(fmi2SetReal); FUNCTION(fmi2GetReal); FUNCTION(fmi2DoStep);
    FUNCTION(fmi2Terminate); FUNCTION(fmi2Reset);
    fmi2CallbackFunctions callbacks = {silent, calloc, free, NULL, NULL};
    fmi2Component fmu = fmi2Instantiate("plain", fmi2CoSimulation, words[2], words[3], &callbacks, fmi2False, fmi2False);
    if (!fmu || count - 7 > MOST) return 3;
    int steps = atoi(words[4]), inputs = count - 7, wrong = 0;
    double step = atof(words[5]), given[MOST], found, least;
    fmi2ValueReference output = atoi(words[6]), references[MOST];
    for (int i = 0; i < inputs; i++) references[i] = atoi(words[7 + i]);
    while (fread(given, sizeof(double), inputs, stdin) == (size_t)inputs) {
        wrong |= fmi2SetReal(fmu, references, inputs, given);
        wrong |= fmi2SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2True, steps * step);
        wrong |= fmi2EnterInitializationMode(fmu) | fmi2ExitInitializationMode(fmu);
        wrong |= fmi2GetReal(fmu, &output, 1, &least);
        for (int k = 0; k < steps; k++) {
            wrong |= fmi2DoStep(fmu, k * step, step, fmi2True) | fmi2GetReal(fmu, &output, 1, &found);
            if (found < least) least = found;
        }
        wrong |= fmi2Terminate(fmu) | fmi2Reset(fmu);
        fwrite(&least, sizeof least, 1, stdout);
    }
    return wrong != 0;
}
