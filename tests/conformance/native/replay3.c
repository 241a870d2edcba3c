/* replay.c for an FMU of FMI 3.0: the same record, the same answer. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef LINKED /* with the FMU's own all.c, where nothing can be loaded at run time */
#include "fmi3Functions.h"
#else
#include "fmi3FunctionTypes.h"
#include "library.h"
#endif

#define MOST 64
#define FUNCTIONS(X) \
    X(InstantiateCoSimulation) X(FreeInstance) X(EnterInitializationMode) X(ExitInitializationMode) X(SetFloat64) \
    X(GetFloat64) X(DoStep) X(Terminate)

#define X(name) static fmi3##name##TYPE *name;
FUNCTIONS(X)
#undef X

static void fail(const char *what, const char *which)
{
    fprintf(stderr, "%s: %s\n", what, which);
    exit(1);
}

static void load(const char *path)
{
#ifdef LINKED
    (void)path;
#define X(name) name = fmi3##name;
    FUNCTIONS(X)
#undef X
#else
    void *library = OPEN(path), *symbol;
    if (!library)
        fail("cannot be loaded", path);
#define X(name) \
    if (!(symbol = SYMBOL(library, "fmi3" #name))) \
        fail("has no fmi3" #name, path); \
    memcpy(&name, &symbol, sizeof symbol);
    FUNCTIONS(X)
#undef X
#endif
}

static void report(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment;
    fprintf(stderr, "status %d, %s: %s\n", (int)status, category, message);
}

static void ok(fmi3Status status, const char *call)
{
    if (status != fmi3OK)
        fail("not OK", call);
}

static int read_row(FILE *file, double *values, unsigned n)
{
    for (unsigned i = 0; i < n; i++)
        if (fscanf(file, "%lf", &values[i]) != 1)
            return 0;
    return 1;
}

int main(int argc, char **argv)
{
    fmi3ValueReference in[MOST], out[MOST];
    double u[MOST], y[MOST], found[MOST], step, reached, worst = 0;
    fmi3Boolean event, terminated, early;
    unsigned n_in = 0, n_out = 0;
    long rows = 0;
    FILE *file = argc == 4 ? fopen(argv[3], "r") : NULL;
    if (!file || fscanf(file, "%lf %u %u", &step, &n_in, &n_out) != 3 || n_in > MOST || n_out > MOST)
        fail("replay3 LIBRARY TOKEN RECORD", "wrong arguments");
    for (unsigned i = 0; i < n_in + n_out; i++)
        if (fscanf(file, "%u", i < n_in ? &in[i] : &out[i - n_in]) != 1)
            fail("no value references", argv[3]);

    load(argv[1]);
    fmi3Instance c = InstantiateCoSimulation("replayed", argv[2], NULL, fmi3False, fmi3True, fmi3False, fmi3False, NULL,
                                             0, NULL, report, NULL);
    if (!c)
        fail("not instantiated", argv[1]);
    ok(EnterInitializationMode(c, fmi3False, 0, 0, fmi3False, 0), "EnterInitializationMode");
    for (; read_row(file, u, n_in) && read_row(file, y, n_out); rows++) {
        ok(SetFloat64(c, in, n_in, u, n_in), "SetFloat64");
        if (rows == 0)
            ok(ExitInitializationMode(c), "ExitInitializationMode");
        else
            ok(DoStep(c, (double)(rows - 1) * step, step, fmi3True, &event, &terminated, &early, &reached), "DoStep");
        ok(GetFloat64(c, out, n_out, found, n_out), "GetFloat64");
        for (unsigned i = 0; i < n_out; i++)
            worst = fmax(worst, fabs(found[i] - y[i]) / fmax(1, fabs(y[i])));
    }
    ok(Terminate(c), "Terminate");
    FreeInstance(c);
    fclose(file);
    printf("%ld %.3g\n", rows, worst);
    return 0;
}
