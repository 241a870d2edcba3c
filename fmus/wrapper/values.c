/* Reading and setting variables, and the derivatives of outputs. */

static int arrays_given(const Instance *instance, size_t n, const void *a, const void *b)
{
    if (n == 0 || (a && b))
        return 1;
    refuse(instance, fmi2Error, "%u variables were announced, but no array of them was given", (unsigned)n);
    return 0;
}

/* Whether every one of `vr` is a variable of the type asked for. */
static int known(const Instance *instance, const fmi2ValueReference vr[], size_t nvr, int boolean)
{
    for (size_t i = 0; i < nvr; i++)
        if (vr[i] >= NV || TABLE[vr[i]].boolean != boolean) {
            refuse(instance, fmi2Error, "value reference %u is no %s of " MODEL_NAME, (unsigned)vr[i],
                   boolean ? "Boolean" : "Real");
            return 0;
        }
    return 1;
}

/* Where the value of `v` is kept, or NULL where it cannot be computed. */
static const double *current(Instance *instance, const Variable *v)
{
    State *s = &instance->state;
    if (v->causality == INPUT)
        return &s->u[v->place];
    if (v->causality == PARAMETER)
        return &s->p[v->place];
    return initialise(instance) == fmi2OK ? &s->y[v->place] : NULL;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    Instance *instance = valid(c);
    if (!instance || !arrays_given(instance, nvr, vr, value) || !known(instance, vr, nvr, 0))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        const double *at = current(instance, &TABLE[vr[i]]);
        if (!at)
            return fmi2Error;
        value[i] = *at;
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    Instance *instance = valid(c);
    if (!instance || !arrays_given(instance, nvr, vr, value) || !known(instance, vr, nvr, 1))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        const double *at = current(instance, &TABLE[vr[i]]);
        if (!at)
            return fmi2Error;
        value[i] = *at != 0 ? fmi2True : fmi2False;
    }
    return fmi2OK;
}

/* Whether `v` may be set now, and to `value`. A value outside a parameter's range is discarded: FMI 2.0 section 2.2.7. */
static fmi2Status settable(const Instance *instance, const Variable *v, double value)
{
    char reason[SENTENCE];
    int phase = instance->state.phase;
    if (v->causality == OUTPUT || v->causality == CALCULATED_PARAMETER)
        return refuse(instance, fmi2Error, "%s is %s and may not be set", v->name,
                      v->causality == OUTPUT ? "an output" : "a calculated parameter");
    if (v->causality == PARAMETER && phase >= STEPPING)
        return refuse(instance, fmi2Error, "%s is fixed: it may be set before the end of initialisation only", v->name);
    if (phase == TERMINATED)
        return refuse(instance, fmi2Error, "%s may not be set after termination", v->name);
    if (v->causality == PARAMETER && out_of_range(reason, v, value))
        return refuse(instance, fmi2Discard, "%s", reason);
    return fmi2OK;
}

/* An input that is not a finite number is refused: the old value stays and the next step is not taken. */
static fmi2Status set(Instance *instance, const Variable *v, double value)
{
    State *s = &instance->state;
    char text[32], time[32];
    if (v->causality == INPUT && !is_finite(value)) {
        s->refused[v->place] = value;
        return refuse(instance, fmi2Discard, "%s = %s is not a finite number and was refused at t = %s s", v->name,
                      number(text, value), number(time, s->time));
    }
    if (v->causality == INPUT) {
        s->refused[v->place] = 0;
        s->u[v->place] = value;
        s->stale = s->phase != STEPPING;
    } else {
        s->p[v->place] = value;
        s->stale = 1;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    Instance *instance = valid(c);
    fmi2Status status = fmi2OK;
    if (!instance || !arrays_given(instance, nvr, vr, value) || !known(instance, vr, nvr, 0))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) { /* all or nothing */
        fmi2Status s = settable(instance, &TABLE[vr[i]], value[i]);
        if (s != fmi2OK)
            return s;
    }
    for (size_t i = 0; i < nvr; i++)
        if (set(instance, &TABLE[vr[i]], value[i]) != fmi2OK)
            status = fmi2Discard;
    return status;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    Instance *instance = valid(c);
    if (!instance || !arrays_given(instance, nvr, vr, value) || !known(instance, vr, nvr, 1))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        fmi2Status s = settable(instance, &TABLE[vr[i]], value[i] != fmi2False);
        if (s != fmi2OK)
            return s;
    }
    for (size_t i = 0; i < nvr; i++)
        set(instance, &TABLE[vr[i]], value[i] != fmi2False);
    return fmi2OK;
}

/* All variables are Real or Boolean. */
static fmi2Status no_such(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const char *type)
{
    Instance *instance = valid(c);
    if (!instance || !arrays_given(instance, nvr, vr, vr))
        return fmi2Error;
    if (nvr == 0)
        return fmi2OK;
    return refuse(instance, fmi2Error, "value reference %u is no %s of " MODEL_NAME, (unsigned)vr[0], type);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    (void)value;
    return no_such(c, vr, nvr, "Integer");
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)value;
    return no_such(c, vr, nvr, "String");
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    (void)value;
    return no_such(c, vr, nvr, "Integer");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)value;
    return no_such(c, vr, nvr, "String");
}

/* The model description promises neither input nor output derivatives in time. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    Instance *instance = valid(c);
    (void)vr, (void)nvr, (void)order, (void)value;
    return instance ? refuse(instance, fmi2Error, MODEL_NAME " does not interpolate inputs") : fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    Instance *instance = valid(c);
    (void)vr, (void)nvr, (void)order, (void)value;
    return instance ? refuse(instance, fmi2Error, MODEL_NAME " has no output derivatives in time") : fmi2Error;
}

/* Of outputs, with respect to inputs; until the end of initialisation through the initial state, and also with
   respect to parameters. */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    Instance *instance = valid(c);
    double du[LENGTH(NU)] = {0}, dp[LENGTH(NP)] = {0}, dy[LENGTH(NY)];
    const State *s;
    int starting;
    if (!instance || !arrays_given(instance, nUnknown, vUnknown_ref, dvUnknown) ||
        !arrays_given(instance, nKnown, vKnown_ref, dvKnown) || !known(instance, vUnknown_ref, nUnknown, 0) ||
        !known(instance, vKnown_ref, nKnown, 0))
        return fmi2Error;
    s = &instance->state;
    starting = s->phase < STEPPING;
    for (size_t i = 0; i < nKnown; i++) {
        const Variable *v = &TABLE[vKnown_ref[i]];
        if (v->causality != INPUT && !(starting && v->causality == PARAMETER))
            return refuse(instance, fmi2Error, "%s is not among the knowns of a directional derivative now", v->name);
        *(v->causality == INPUT ? &du[v->place] : &dp[v->place]) += dvKnown[i];
    }
    if (starting)
        model_start_tangent((const double *[]){&s->time, s->u, s->p, du, dp}, (double *[]){dy});
    else
        model_tangent((const double *[]){&s->time, s->x, s->u, s->p, du}, (double *[]){dy});
    for (size_t i = 0; i < nUnknown; i++) {
        const Variable *v = &TABLE[vUnknown_ref[i]];
        if (v->causality == INPUT || v->causality == PARAMETER)
            return refuse(instance, fmi2Error, "%s is not among the unknowns of a directional derivative", v->name);
        dvUnknown[i] = dy[v->place];
    }
    return fmi2OK;
}
