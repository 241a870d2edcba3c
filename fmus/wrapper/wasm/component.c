/* The FMU as a WebAssembly component of FMI-LS-WASM (working draft): one more door, onto the functions of FMI 3.0.

   What is exported has the names and signatures to which the Component Model's canonical ABI lowers the draft's
   interfaces: a list is its address and length, an option is a tag and a value, a result lies where the returned
   address points. Arguments come in memory from cabi_realloc and are freed here; an answer stays until the next one. */
#define WITHOUT_FMI2
#include <stdlib.h>

#include "all.c"

#define PACKAGE(interface) "fmi:fmi3/" interface "@3.0.0"

typedef uint32_t Answer; /* fmi3Status, where it comes alone */

typedef struct {
    fmi3Instance fmu;
    char *name;
} Resource;

/* result<list<T>, status> and option<own<T>> */
typedef struct {
    uint8_t tag;
    union {
        struct {
            const void *at;
            uint32_t n;
        } list;
        uint32_t handle;
        uint8_t status;
    } is;
} Listed;

/* result<T, status>, T with numbers of 8 bytes */
typedef struct {
    uint8_t tag;
    union {
        uint64_t number;
        struct {
            double time;
            uint8_t truths[3];
        } step;
        struct {
            uint8_t truths[5];
            double time;
        } events;
        uint8_t status;
    } is;
} Counted;

typedef struct {
    uint8_t tag;
    uint8_t truths[2]; /* or the status in the first */
} Truths;

static Listed listed;
static Counted counted;
static Truths truths;
static void *answer; /* what `listed` points to */

void *__attribute__((export_name("cabi_realloc")))
given(void *old, size_t old_size, size_t alignment, size_t size)
{
    void *memory = size ? realloc(old, size) : (void *)alignment;
    (void)old_size;
    if (!memory)
        __builtin_trap();
    return memory;
}

static void release(const void *list, uint32_t n)
{
    if (n)
        free((void *)list);
}

/* A string as C has it, in place of the one given. */
static char *text(char *at, uint32_t n)
{
    char *copy = n ? realloc(at, (size_t)n + 1) : malloc(1);
    if (!copy)
        __builtin_trap();
    copy[n] = 0;
    return copy;
}

static void *room(size_t n, size_t size)
{
    free(answer);
    answer = calloc(n + 1, size);
    if (!answer)
        __builtin_trap();
    return answer;
}

static const Listed *list_of(uint32_t n, fmi3Status status)
{
    listed.tag = status > fmi3Warning;
    if (listed.tag)
        listed.is.status = (uint8_t)status;
    else
        listed.is.list.at = answer, listed.is.list.n = n;
    return &listed;
}

static const Counted *count_of(size_t n, fmi3Status status)
{
    counted.tag = status > fmi3Warning;
    if (counted.tag)
        counted.is.status = (uint8_t)status;
    else
        counted.is.number = n;
    return &counted;
}

__attribute__((import_module(PACKAGE("callbacks")), import_name("log-message")))
void log_message(const char *name, size_t name_length, uint32_t status, const char *category, size_t category_length,
                 const char *message, size_t message_length);

static void logged(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    const char *name = ((const Resource *)environment)->name;
    log_message(name, strlen(name), status, category, strlen(category), message, strlen(message));
}

const Listed *__attribute__((export_name(PACKAGE("common") "#get-version"))) get_version(void)
{
    static struct {
        const char *at;
        uint32_t n;
    } version;
    version.at = fmi3GetVersion();
    version.n = (uint32_t)strlen(version.at);
    return (const Listed *)&version;
}

static Resource *new_resource(char *name, uint32_t name_length)
{
    Resource *resource = malloc(sizeof *resource);
    if (!resource)
        __builtin_trap();
    resource->name = text(name, name_length);
    return resource;
}

static void drop(Resource *resource)
{
    if (resource->fmu)
        fmi3FreeInstance(resource->fmu);
    free(resource->name);
    free(resource);
}

/* --- co-simulation ---------------------------------------------------------------------------- */

#define KIND "co-simulation"
#define OF(name) cs_##name
#include "component_instance.c"

const Listed *EXPORTED("[static]", ".instantiate-co-simulation", instantiate)(
    char *name, uint32_t name_length, char *token, uint32_t token_length, char *path, uint32_t path_length,
    uint32_t visible, uint32_t logging, uint32_t event_mode, uint32_t early_return, uint32_t *intermediate, uint32_t n)
{
    Resource *r = new_resource(name, name_length);
    token = text(token, token_length);
    path = text(path, path_length);
    r->fmu = fmi3InstantiateCoSimulation(r->name, token, path, visible != 0, logging != 0, event_mode != 0,
                                         early_return != 0, intermediate, n, r, logged, NULL);
    free(token);
    free(path);
    release(intermediate, n);
    return cs_made(r);
}

const Counted *METHOD("do-step", do_step)(Resource *r, double time, double step, uint32_t no_set_state)
{
    fmi3Boolean event = 0, terminated = 0, early = 0;
    fmi3Status status = fmi3DoStep(r->fmu, time, step, no_set_state != 0, &event, &terminated, &early, &time);
    counted.tag = status > fmi3Warning;
    if (counted.tag) {
        counted.is.status = (uint8_t)status;
    } else {
        counted.is.step.time = time;
        counted.is.step.truths[0] = event;
        counted.is.step.truths[1] = terminated;
        counted.is.step.truths[2] = early;
    }
    return &counted;
}

/* FMI 3.0 has no function of this name. */
Answer METHOD("set-input-derivatives", set_input_derivatives)(Resource *r, uint32_t *requests, uint32_t n,
                                                              double *values, uint32_t n_values)
{
    (void)r;
    release(requests, n);
    release(values, n_values);
    return fmi3Error;
}

/* --- model exchange --------------------------------------------------------------------------- */

#undef KIND
#undef OF
#define KIND "model-exchange"
#define OF(name) me_##name
#include "component_instance.c"

const Listed *EXPORTED("[static]", ".instantiate-model-exchange", instantiate)(
    char *name, uint32_t name_length, char *token, uint32_t token_length, char *path, uint32_t path_length,
    uint32_t visible, uint32_t logging)
{
    Resource *r = new_resource(name, name_length);
    token = text(token, token_length);
    path = text(path, path_length);
    r->fmu = fmi3InstantiateModelExchange(r->name, token, path, visible != 0, logging != 0, r, logged);
    free(token);
    free(path);
    return me_made(r);
}

CALLED("enter-continuous-time-mode", enter_continuous_time, fmi3EnterContinuousTimeMode)

Answer METHOD("set-time", set_time)(Resource *r, double time)
{
    return fmi3SetTime(r->fmu, time);
}

Answer METHOD("set-continuous-states", set_states)(Resource *r, double *states, uint32_t n)
{
    Answer status = fmi3SetContinuousStates(r->fmu, states, n);
    release(states, n);
    return status;
}

#define STATES(name, as, function, n) \
    const Listed *METHOD(name, as)(Resource *r) \
    { \
        double *values = room(n, sizeof *values); \
        return list_of(n, function(r->fmu, values, n)); \
    }

STATES("get-continuous-states", get_states, fmi3GetContinuousStates, NS)
STATES("get-continuous-state-derivatives", get_rates, fmi3GetContinuousStateDerivatives, NS)
STATES("get-nominals-of-continuous-states", get_nominals, fmi3GetNominalsOfContinuousStates, NS)
STATES("get-event-indicators", get_indicators, fmi3GetEventIndicators, 0)

#define NUMBER(name, as, function) \
    const Counted *METHOD(name, as)(Resource *r) \
    { \
        size_t n = 0; \
        fmi3Status status = function(r->fmu, &n); \
        return count_of(n, status); \
    }

NUMBER("get-number-of-continuous-states", n_states, fmi3GetNumberOfContinuousStates)
NUMBER("get-number-of-event-indicators", n_indicators, fmi3GetNumberOfEventIndicators)

const Truths *METHOD("completed-integrator-step", completed_step)(Resource *r, uint32_t no_set_state)
{
    fmi3Boolean event = 0, terminated = 0;
    fmi3Status status = fmi3CompletedIntegratorStep(r->fmu, no_set_state != 0, &event, &terminated);
    truths.tag = status > fmi3Warning;
    truths.truths[0] = truths.tag ? (uint8_t)status : event;
    truths.truths[1] = terminated;
    return &truths;
}
