/* Reading and setting variables. */

static int arrays_given(const Instance *instance, size_t n, const void *a, const void *b)
{
    if (n == 0 || (a && b))
        return 1;
    refuse(instance, ERROR, "%u variables were announced, but no array of them was given", (unsigned)n);
    return 0;
}

static Status no_such(const Instance *instance, Reference reference, const char *type)
{
    return refuse(instance, ERROR, "value reference %u is no %s of " MODEL_NAME, (unsigned)reference, type);
}

/* Whether every one of `vr` is a variable of the type asked for, which the version of the importer calls `type`. */
static FAST int known(const Instance *instance, const Reference vr[], size_t n, int boolean, const char *type)
{
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= NV || TABLE[vr[i]].boolean != boolean) {
            no_such(instance, vr[i], type);
            return 0;
        }
    return 1;
}

/* Where the value of `v` is kept, if what it depends on is up to date. */
static FAST const double *place_of(const Instance *instance, const Variable *v)
{
    const State *s = &instance->state;
    switch (v->role) {
    case INPUT: return &s->u[v->place];
    case PARAMETER: return &s->p[v->place];
    case STATE: return &s->x[v->place];
    case RATE: return &instance->rates[v->place];
    case TIME: return &s->time;
    default: return &s->y[v->place];
    }
}

/* The values of variables; `write` puts the i-th into `values`. */
static FAST Status get(Instance *instance, const Reference vr[], size_t n, void *values,
                         void (*write)(void *values, size_t i, double value), int boolean, const char *type)
{
    int have_rates = 0;
    if (!instance || !arrays_given(instance, n, vr, values) || !known(instance, vr, n, boolean, type))
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        const Variable *v = &TABLE[vr[i]];
        Status status = OK;
        if (v->role == OUTPUT || v->role == CALCULATED_PARAMETER || v->role == STATE)
            status = refresh(instance);
        else if (v->role == RATE && !have_rates)
            have_rates = (status = find_rates(instance)) == OK;
        if (status != OK)
            return status;
        write(values, i, *place_of(instance, v));
    }
    return OK;
}

/* Whether `v` may be set now, and to `value`. A value outside a parameter's range is discarded: FMI 2.0 section 2.2.7. */
static FAST Status settable(const Instance *instance, const Variable *v, double value)
{
    char reason[SENTENCE];
    int phase = instance->state.phase;
    if (v->role != INPUT && v->role != PARAMETER)
        return refuse(instance, ERROR, "%s is %s and may not be set", v->name,
                      v->role == OUTPUT ? "an output" : v->role == CALCULATED_PARAMETER ? "a calculated parameter"
                      : v->role == RATE ? "a derivative" : v->role == TIME ? "the time" : "a state");
    if (v->role == PARAMETER && phase >= STEPPING)
        return refuse(instance, ERROR, "%s is fixed: it may be set before the end of initialisation only", v->name);
    if (phase == TERMINATED)
        return refuse(instance, ERROR, "%s may not be set after termination", v->name);
    if (phase == IN_CONTINUOUS_TIME && v->discrete)
        return refuse(instance, ERROR, "%s is discrete: it may be set at events only", v->name);
    if (v->role == PARAMETER && out_of_range(reason, v, value))
        return refuse(instance, DISCARD, "%s", reason);
    return OK;
}

/* An input that is not a finite number is refused: the old value stays and the next step is not taken. */
static FAST Status set_one(Instance *instance, const Variable *v, double value)
{
    State *s = &instance->state;
    char text[32], time[32];
    if (v->role == INPUT && !is_finite(value)) {
        s->refused[v->place] = value;
        if (s->phase > STEPPING)
            s->stale = 1;
        return refuse(instance, DISCARD, "%s = %s is not a finite number and was refused at t = %s s", v->name,
                      number(text, value), number(time, s->time));
    }
    if (v->role == INPUT) {
        s->refused[v->place] = 0;
        s->u[v->place] = value;
        s->stale = s->phase != STEPPING;
    } else {
        s->p[v->place] = value;
        s->stale = 1;
    }
    return OK;
}

/* Sets variables, all or, where one may not be set, none; `read` takes the i-th value out of `values`. */
static FAST Status set(Instance *instance, const Reference vr[], size_t n, const void *values,
                         double (*read)(const void *values, size_t i), int boolean, const char *type)
{
    Status status = OK;
    if (!instance || !arrays_given(instance, n, vr, values) || !known(instance, vr, n, boolean, type))
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        Status answer = settable(instance, &TABLE[vr[i]], read(values, i));
        if (answer != OK)
            return answer;
    }
    for (size_t i = 0; i < n; i++)
        if (set_one(instance, &TABLE[vr[i]], read(values, i)) != OK)
            status = DISCARD;
    return status;
}

static void write_real(void *values, size_t i, double value)
{
    ((double *)values)[i] = value;
}

static double read_real(const void *values, size_t i)
{
    return ((const double *)values)[i];
}

/* All variables are floating-point numbers of 64 bits or Booleans: there are none of another type. */
static Status none_of(const Instance *instance, const Reference vr[], size_t n, const char *type)
{
    if (!instance || !arrays_given(instance, n, vr, vr))
        return ERROR;
    return n == 0 ? OK : no_such(instance, vr[0], type);
}

static int answerable(const Instance *instance, int places_given)
{
    if (!places_given)
        refuse(instance, ERROR, "no place was given for an answer of this call");
    return places_given;
}

static Status no_interpolation(const Instance *instance)
{
    return instance ? refuse(instance, ERROR, MODEL_NAME " does not interpolate inputs") : ERROR;
}

static Status no_output_derivatives(const Instance *instance)
{
    return instance ? refuse(instance, ERROR, MODEL_NAME " has no output derivatives in time") : ERROR;
}

/* No variable is an array: FMI 3.0 counts values and variables, and there are as many of both. */
static int one_each(const Instance *instance, size_t variables, size_t values)
{
    if (!instance || variables == values)
        return instance != NULL;
    refuse(instance, ERROR, "%u values were announced for %u variables, which have one each", (unsigned)values,
           (unsigned)variables);
    return 0;
}
