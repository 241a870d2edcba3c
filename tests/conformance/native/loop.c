/* Flies scenario, controller and plant in a loop, for valgrind and the sanitizers, and to time them.

   loop SCENARIO CONTROLLER PLANT SECONDS CYCLES: three libraries; CYCLES times instantiate, fly, use every state call,
   free. wiring.h, written from the model descriptions, has the GUIDs and value references.
   Output is "velocity altitude", the cost of one step of controller and of plant in microseconds, and the largest
   memory used in KB. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <time.h>

#include "fmu.h"
#include "wiring.h"

#define STEP 0.01
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

enum { SCENARIO, CONTROLLER, PLANT, MEMBERS };

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void move(const Fmu *from, fmi2Component c, const fmi2ValueReference *out, const Fmu *to, fmi2Component d,
                 const fmi2ValueReference *in, size_t n)
{
    double values[16];
    ok(from->GetReal(c, out, n, values), "GetReal");
    ok(to->SetReal(d, in, n, values), "SetReal");
}

/* Largest memory in use so far, KB; 0 where the system does not say. */
static long peak_memory(void)
{
    char line[256];
    long peak = 0;
    FILE *status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (strncmp(line, "VmHWM:", 6) == 0)
            peak = atol(line + 6);
    if (status)
        fclose(status);
    return peak;
}

/* Saves, serialises, restores: the state afterwards is the state before. */
static void there_and_back(const Fmu *fmu, fmi2Component c)
{
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size;
    ok(fmu->GetFMUstate(c, &state), "GetFMUstate");
    ok(fmu->SerializedFMUstateSize(c, state, &size), "SerializedFMUstateSize");
    char *bytes = malloc(size), *again = malloc(size);
    ok(fmu->SerializeFMUstate(c, state, bytes, size), "SerializeFMUstate");
    ok(fmu->DoStep(c, 1, STEP, fmi2False), "DoStep");
    ok(fmu->DeSerializeFMUstate(c, bytes, size, &copy), "DeSerializeFMUstate");
    ok(fmu->SetFMUstate(c, copy), "SetFMUstate");
    ok(fmu->GetFMUstate(c, &state), "GetFMUstate");
    ok(fmu->SerializeFMUstate(c, state, again, size), "SerializeFMUstate");
    if (memcmp(bytes, again, size) != 0)
        fail("not bit-exact", "state");
    ok(fmu->FreeFMUstate(c, &state), "FreeFMUstate");
    ok(fmu->FreeFMUstate(c, &copy), "FreeFMUstate");
    free(bytes);
    free(again);
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"scenario", "controller", "plant"};
    static const char *const guids[] = {SCENARIO_GUID, CONTROLLER_GUID, PLANT_GUID};
    static const fmi2ValueReference commands[] = COMMANDS, commanded[] = COMMANDED, scales[] = SCALES,
                                    scaled[] = SCALED, measures[] = MEASURES, measured[] = MEASURED,
                                    actions[] = ACTIONS, actuated[] = ACTUATED;
    double cost[MEMBERS] = {0}, result[2];
    Fmu fmu[MEMBERS];
    fmi2Component c[MEMBERS];
    if (argc != 6)
        fail("loop SCENARIO CONTROLLER PLANT SECONDS CYCLES", "wrong arguments");
    long ticks = lround(atof(argv[4]) / STEP);
    for (int i = 0; i < MEMBERS; i++)
        fmu[i] = load(argv[1 + i], guids[i]);
    for (int cycle = atoi(argv[5]); cycle > 0; cycle--) {
        for (int i = 0; i < MEMBERS; i++)
            c[i] = begin(&fmu[i], names[i]);
        move(&fmu[SCENARIO], c[SCENARIO], scales, &fmu[PLANT], c[PLANT], scaled, COUNT(scales));
        move(&fmu[SCENARIO], c[SCENARIO], commands, &fmu[CONTROLLER], c[CONTROLLER], commanded, COUNT(commands));
        move(&fmu[PLANT], c[PLANT], measures, &fmu[CONTROLLER], c[CONTROLLER], measured, COUNT(measures));
        move(&fmu[CONTROLLER], c[CONTROLLER], actions, &fmu[PLANT], c[PLANT], actuated, COUNT(actions));
        for (int i = 0; i < MEMBERS; i++)
            ok(fmu[i].ExitInitializationMode(c[i]), "ExitInitializationMode");
        for (long k = 0; k < ticks; k++)
            for (int i = 0; i < MEMBERS; i++) {
                double began = seconds();
                ok(fmu[i].DoStep(c[i], (double)k * STEP, STEP, fmi2True), "DoStep");
                cost[i] += seconds() - began;
                if (i == SCENARIO) {
                    move(&fmu[i], c[i], scales, &fmu[PLANT], c[PLANT], scaled, COUNT(scales));
                    move(&fmu[i], c[i], commands, &fmu[CONTROLLER], c[CONTROLLER], commanded, COUNT(commands));
                } else if (i == CONTROLLER)
                    move(&fmu[i], c[i], actions, &fmu[PLANT], c[PLANT], actuated, COUNT(actions));
                else
                    move(&fmu[i], c[i], measures, &fmu[CONTROLLER], c[CONTROLLER], measured, COUNT(measures));
            }
        ok(fmu[PLANT].GetReal(c[PLANT], measures, 2, result), "GetReal");
        for (int i = 0; i < MEMBERS; i++) {
            there_and_back(&fmu[i], c[i]);
            ok(fmu[i].Terminate(c[i]), "Terminate");
            ok(fmu[i].Reset(c[i]), "Reset");
            fmu[i].FreeInstance(c[i]);
        }
    }
    double steps = (double)ticks * atof(argv[5]);
    printf("%.17g %.17g %.4f %.4f %ld\n", result[0], result[1], 1e6 * cost[CONTROLLER] / steps,
           1e6 * cost[PLANT] / steps, peak_memory());
    return 0;
}
