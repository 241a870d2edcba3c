/* Many instances at once, through either door: many VERSION COUNT, linked with the FMU's own all.c. Each is initialised
   and stepped. Prints the largest memory used, in KB, before and with all of them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "guid.h"

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

static void *second(void)
{
    static const fmi2CallbackFunctions callbacks = {NULL, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate("one of many", fmi2CoSimulation, FMU_GUID, "", &callbacks, 0, 0);
    if (!c || fmi2EnterInitializationMode(c) || fmi2ExitInitializationMode(c) || fmi2DoStep(c, 0, 0.01, 1))
        exit(1);
    return c;
}

static void *third(void)
{
    fmi3Boolean event, ends, early;
    fmi3Float64 reached;
    fmi3Instance c = fmi3InstantiateCoSimulation("one of many", FMU_GUID, "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    if (!c || fmi3EnterInitializationMode(c, 0, 0, 0, 0, 0) || fmi3ExitInitializationMode(c) ||
        fmi3DoStep(c, 0, 0.01, 1, &event, &ends, &early, &reached))
        exit(1);
    return c;
}

int main(int argc, char **argv)
{
    int version = argc == 3 ? atoi(argv[1]) : 2, count = argc == 3 ? atoi(argv[2]) : 1;
    void **instances = calloc((size_t)count, sizeof *instances);
    memset(instances, 1, (size_t)count * sizeof *instances); /* in use now */
    long before = peak_memory();
    for (int i = 0; i < count; i++)
        instances[i] = version == 2 ? second() : third();
    printf("%ld %ld\n", before, peak_memory());
    for (int i = 0; i < count; i++)
        version == 2 ? fmi2FreeInstance(instances[i]) : fmi3FreeInstance(instances[i]);
    free(instances);
    return 0;
}
