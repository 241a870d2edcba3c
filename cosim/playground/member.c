/* An FMU as one of several in a module, which its names are prefixed for: what module.c has, and the functions that the
   master's loop (loop.c) calls. The loop has one type for all FMUs, whose words have 64 bits and hold addresses too;
   WebAssembly calls no function by another type than its own. */
#include "module.c"

#define AT(address) ((void *)(uintptr_t)(address))

typedef int64_t Word;

static int32_t set_reals(Word c, Word references, Word n, Word values, Word n_values)
{
    (void)n_values;
    return fmi2SetReal(AT(c), AT(references), (size_t)n, AT(values));
}

static int32_t get_reals(Word c, Word references, Word n, Word values, Word n_values)
{
    (void)n_values;
    return fmi2GetReal(AT(c), AT(references), (size_t)n, AT(values));
}

static int32_t do_step(Word c, double time, double step, int32_t fixed, Word event, Word end, Word early, Word reached)
{
    (void)event, (void)end, (void)early, (void)reached;
    return fmi2DoStep(AT(c), time, step, fixed);
}

/* Where the loop calls the FMU. */
EXPORT(void *, set_reals_at)(void) { return (void *)set_reals; }
EXPORT(void *, get_reals_at)(void) { return (void *)get_reals; }
EXPORT(void *, do_step_at)(void) { return (void *)do_step; }
