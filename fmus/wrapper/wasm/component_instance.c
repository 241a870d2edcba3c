/* A resource of component.c and its methods, which are nearly the same for both kinds of FMU. KIND is the kind as the
   draft writes it, OF makes a name in C of its own. */

#define EXPORTED(before, name, as) __attribute__((export_name(PACKAGE(KIND) "#" before KIND "-instance" name))) OF(as)
#define METHOD(name, as) EXPORTED("[method]", "." name, as)

__attribute__((import_module("[export]" PACKAGE(KIND)), import_name("[resource-new]" KIND "-instance")))
uint32_t OF(handle)(Resource *);

void EXPORTED("[dtor]", "", drop)(Resource *r)
{
    drop(r);
}

static const Listed *OF(made)(Resource *r)
{
    listed.tag = r->fmu != NULL;
    if (r->fmu)
        listed.is.handle = OF(handle)(r);
    else
        drop(r);
    return &listed;
}

/* --- life cycle ------------------------------------------------------------------------------- */

Answer METHOD("set-debug-logging", set_debug_logging)(Resource *r, uint32_t on, Listed *given_categories, uint32_t n)
{
    struct {
        char *at;
        uint32_t n;
    } *categories = (void *)given_categories;
    fmi3String *names = room(n, sizeof *names);
    Answer status;
    for (uint32_t i = 0; i < n; i++)
        names[i] = text(categories[i].at, categories[i].n);
    status = fmi3SetDebugLogging(r->fmu, on != 0, n, names);
    for (uint32_t i = 0; i < n; i++)
        free((void *)names[i]);
    release(categories, n);
    return status;
}

Answer METHOD("enter-initialization-mode", enter_initialization)(Resource *r, uint32_t tolerance_given, double tolerance,
                                                                 double start, uint32_t stop_given, double stop)
{
    return fmi3EnterInitializationMode(r->fmu, tolerance_given != 0, tolerance, start, stop_given != 0, stop);
}

#define CALLED(name, as, function) \
    Answer METHOD(name, as)(Resource *r) \
    { \
        return function(r->fmu); \
    }

CALLED("exit-initialization-mode", exit_initialization, fmi3ExitInitializationMode)
CALLED("enter-event-mode", enter_event, fmi3EnterEventMode)
CALLED("terminate", terminate, fmi3Terminate)
CALLED("reset", reset, fmi3Reset)
CALLED("enter-configuration-mode", enter_configuration, fmi3EnterConfigurationMode)
CALLED("exit-configuration-mode", exit_configuration, fmi3ExitConfigurationMode)
CALLED("evaluate-discrete-states", evaluate_discrete, fmi3EvaluateDiscreteStates)
CALLED("enter-step-mode", enter_step, fmi3EnterStepMode)

const Counted *METHOD("update-discrete-states", update_discrete)(Resource *r)
{
    fmi3Boolean t[5] = {0};
    double next = 0;
    fmi3Status status = fmi3UpdateDiscreteStates(r->fmu, &t[0], &t[1], &t[2], &t[3], &t[4], &next);
    counted.tag = status > fmi3Warning;
    if (counted.tag)
        counted.is.status = (uint8_t)status;
    else {
        for (int i = 0; i < 5; i++)
            counted.is.events.truths[i] = t[i];
        counted.is.events.time = next;
    }
    return &counted;
}

/* --- values ----------------------------------------------------------------------------------- */

#define VARIABLES(name, type) \
    const Listed *METHOD("get-" name, get_##type)(Resource *r, uint32_t *vr, uint32_t n) \
    { \
        fmi3##type *values = room(n, sizeof *values); \
        fmi3Status status = fmi3Get##type(r->fmu, vr, n, values, n); \
        release(vr, n); \
        return list_of(n, status); \
    } \
    Answer METHOD("set-" name, set_##type)(Resource *r, uint32_t *vr, uint32_t n, fmi3##type *values, uint32_t n_values) \
    { \
        Answer status = fmi3Set##type(r->fmu, vr, n, values, n_values); \
        release(vr, n); \
        release(values, n_values); \
        return status; \
    }

VARIABLES("float32", Float32)
VARIABLES("float64", Float64)
VARIABLES("int8", Int8)
VARIABLES("int16", Int16)
VARIABLES("int32", Int32)
VARIABLES("int64", Int64)
VARIABLES("uint8", UInt8)
VARIABLES("uint16", UInt16)
VARIABLES("uint32", UInt32)
VARIABLES("uint64", UInt64)
VARIABLES("boolean", Boolean)

/* What no model has: the FMU's sentence says so, and only an empty list comes back. `values` are lists of 0 or more
   lists, each of which the host allocated. */
#define NONE(name, as, ...) \
    const Listed *METHOD("get-" name, get_##as)(Resource *r, uint32_t *vr, uint32_t n) \
    { \
        fmi3Status status = fmi3Get##as(r->fmu, vr, n, __VA_ARGS__); \
        release(vr, n); \
        return list_of(0, status); \
    }

#define NONE_SET(name, as, lists, ...) \
    Answer METHOD("set-" name, set_##as)(Resource *r, uint32_t *vr, uint32_t n, void **values, uint32_t n_values) \
    { \
        Answer status = fmi3Set##as(r->fmu, vr, n, __VA_ARGS__); \
        for (uint32_t i = 0; lists && i < n_values; i++) \
            release(values[2 * i], (uint32_t)(size_t)values[2 * i + 1]); \
        release(vr, n); \
        release(values, n_values); \
        return status; \
    }

NONE("string", String, NULL, n)
NONE("binary", Binary, NULL, NULL, n)
NONE("clock", Clock, NULL)
NONE("interval-decimal", IntervalDecimal, NULL, NULL)
NONE("interval-fraction", IntervalFraction, NULL, NULL, NULL)
NONE("shift-decimal", ShiftDecimal, NULL)
NONE("shift-fraction", ShiftFraction, NULL, NULL)
NONE_SET("string", String, 1, NULL, n_values)
NONE_SET("binary", Binary, 1, NULL, NULL, n_values)
NONE_SET("clock", Clock, 0, NULL)
NONE_SET("interval-decimal", IntervalDecimal, 0, NULL)
NONE_SET("interval-fraction", IntervalFraction, 0, NULL, NULL)
NONE_SET("shift-decimal", ShiftDecimal, 0, NULL)
NONE_SET("shift-fraction", ShiftFraction, 0, NULL, NULL)

const Listed *METHOD("get-output-derivatives", get_output_derivatives)(Resource *r, uint32_t *requests, uint32_t n)
{
    fmi3Status status = fmi3GetOutputDerivatives(r->fmu, requests, n, NULL, NULL, n);
    release(requests, n);
    return list_of(0, status);
}

const Counted *METHOD("get-number-of-variable-dependencies", n_dependencies)(Resource *r, uint32_t vr)
{
    size_t n = 0;
    fmi3Status status = fmi3GetNumberOfVariableDependencies(r->fmu, vr, &n);
    return count_of(n, status);
}

const Listed *METHOD("get-variable-dependencies", dependencies)(Resource *r, uint32_t vr)
{
    return list_of(0, fmi3GetVariableDependencies(r->fmu, vr, NULL, NULL, NULL, NULL, 0));
}

#define DERIVATIVE(name, as, answers) \
    const Listed *METHOD(name, as)(Resource *r, uint32_t *unknowns, uint32_t n_unknowns, uint32_t *knowns, \
                                   uint32_t n_knowns, double *seed, uint32_t n_seed) \
    { \
        double *values = room(answers, sizeof *values); \
        fmi3Status status = \
            fmi3Get##as(r->fmu, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, values, answers); \
        release(unknowns, n_unknowns); \
        release(knowns, n_knowns); \
        release(seed, n_seed); \
        return list_of(answers, status); \
    }

DERIVATIVE("get-directional-derivative", DirectionalDerivative, n_unknowns)
DERIVATIVE("get-adjoint-derivative", AdjointDerivative, n_knowns)

/* --- states ----------------------------------------------------------------------------------- */

const Listed *METHOD("get-fmu-state", get_state)(Resource *r)
{
    fmi3FMUState state = NULL;
    size_t size = 0;
    fmi3Status status = fmi3GetFMUState(r->fmu, &state);
    if (status == fmi3OK)
        status = fmi3SerializedFMUStateSize(r->fmu, state, &size);
    if (status == fmi3OK)
        status = fmi3SerializeFMUState(r->fmu, state, room(size, 1), size);
    fmi3FreeFMUState(r->fmu, &state);
    return list_of((uint32_t)size, status);
}

Answer METHOD("set-fmu-state", set_state)(Resource *r, uint8_t *bytes, uint32_t n)
{
    fmi3FMUState state = NULL;
    fmi3Status status = fmi3DeserializeFMUState(r->fmu, bytes, n, &state);
    if (status == fmi3OK)
        status = fmi3SetFMUState(r->fmu, state);
    fmi3FreeFMUState(r->fmu, &state);
    release(bytes, n);
    return status;
}
