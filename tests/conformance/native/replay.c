/* Replays recorded inputs into an FMU and prints how far its outputs are from the recorded ones.

   replay LIBRARY GUID RECORD, where RECORD has the step and the numbers of inputs and outputs, their value references,
   and then a row for each communication point: inputs, and the outputs there. Output is
   "rows difference", the largest difference relative to max(1, |recorded|). */
#include <math.h>

#include "fmu.h"

#define MOST 64

static int read_row(FILE *file, double *values, int n)
{
    for (int i = 0; i < n; i++)
        if (fscanf(file, "%lf", &values[i]) != 1)
            return 0;
    return 1;
}

int main(int argc, char **argv)
{
    fmi2ValueReference in[MOST], out[MOST];
    double u[MOST], y[MOST], found[MOST], step, worst = 0;
    unsigned n_in = 0, n_out = 0;
    long rows = 0;
    FILE *file = argc == 4 ? fopen(argv[3], "r") : NULL;
    if (!file || fscanf(file, "%lf %u %u", &step, &n_in, &n_out) != 3 || n_in > MOST || n_out > MOST)
        fail("replay LIBRARY GUID RECORD", "wrong arguments");
    for (unsigned i = 0; i < n_in + n_out; i++)
        if (fscanf(file, "%u", i < n_in ? &in[i] : &out[i - n_in]) != 1)
            fail("no value references", argv[3]);

    Fmu fmu = load(argv[1], argv[2]);
    fmi2Component c = begin(&fmu, "replayed");
    for (; read_row(file, u, (int)n_in) && read_row(file, y, (int)n_out); rows++) {
        ok(fmu.SetReal(c, in, n_in, u), "SetReal");
        if (rows == 0)
            ok(fmu.ExitInitializationMode(c), "ExitInitializationMode");
        else
            ok(fmu.DoStep(c, (double)(rows - 1) * step, step, fmi2True), "DoStep");
        ok(fmu.GetReal(c, out, n_out, found), "GetReal");
        for (unsigned i = 0; i < n_out; i++)
            worst = fmax(worst, fabs(found[i] - y[i]) / fmax(1, fabs(y[i])));
    }
    ok(fmu.Terminate(c), "Terminate");
    fmu.FreeInstance(c);
    fclose(file);
    printf("%ld %.3g\n", rows, worst);
    return 0;
}
