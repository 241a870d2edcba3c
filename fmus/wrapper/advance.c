/* The model's functions on an instance. */

#define ROUNDING 1e-9 /* of a step: 10 ms in steps of 1 ms are 10, not 11 */
#define MOST_INTERNAL_STEPS 1e7

/* Why no step can be taken from the inputs as they are, written to `reason`; or 0. */
static int input_refused(char reason[SENTENCE], const State *s)
{
    for (int i = 0; i < NU; i++)
        if (s->refused[i] != 0)
            return out_of_range(reason, &TABLE[INPUTS[i]], s->refused[i]);
    return 0;
}

/* The first input that is outside its range, with a question about it in `question`; or NULL. */
static const Variable *first_unwired(char question[SENTENCE], const State *s)
{
    for (int i = 0; i < NU; i++)
        if (unwired(question, &TABLE[INPUTS[i]], s->u[i]))
            return &TABLE[INPUTS[i]];
    return NULL;
}

/* Why the model cannot stand where next_x (at `x`) and next_y would put it, written to `reason`; or 0. */
static int not_acceptable(char reason[SENTENCE], const double *x, const double *y)
{
    int good = 1;
    for (int i = 0; i < NY; i++)
        good &= y[i] >= Y_MINIMUM[i] && y[i] <= Y_MAXIMUM[i];
    for (int i = 0; i < NX; i++)
        good &= x[i] >= -DBL_MAX && x[i] <= DBL_MAX;
    if (good)
        return 0;
    for (int i = 0; i < NY; i++)
        if (!is_finite(y[i]))
            return out_of_range(reason, &TABLE[COMPUTED[i]], y[i]);
    for (int i = 0; i < NX; i++)
        if (!is_finite(x[i])) {
            strcpy(reason, "an internal state is not a finite number");
            return 1;
        }
    for (int i = 0; i < NY; i++)
        if (out_of_range(reason, &TABLE[COMPUTED[i]], y[i]))
            return 1;
    return 0;
}

static void take(State *s, const double *x, const double *y, double time)
{
    memcpy(s->x, x, NX * sizeof *x);
    memcpy(s->y, y, NY * sizeof *y);
    s->time = time;
}

/* The state and outputs that the inputs and parameters set so far lead to. */
static Status initialise(Instance *instance)
{
    State *s = &instance->state;
    char reason[SENTENCE], low[32], high[32];
    const Variable *suspect;
    double *x = instance->next_x[0], *y = instance->next_y, k[LENGTH(NK)];
    if ((suspect = first_unwired(reason, s)))
        return refuse(instance, ERROR,
                      MODEL_NAME " cannot start: %s It starts with %s from %s to %s%s, set before initialisation ends",
                      reason, suspect->name,
                      number(low, suspect->minimum == -DBL_MAX ? -INFINITY : suspect->minimum * suspect->shown),
                      number(high, suspect->maximum == DBL_MAX ? INFINITY : suspect->maximum * suspect->shown),
                      suspect->unit);
    model_constants((const double *[]){s->p}, (double *[]){k});
    model_start((const double *[]){s->u, s->p}, (double *[]){x});
    model_outputs((const double *[]){&s->time, x, s->u, s->p, k}, (double *[]){y});
    if (not_acceptable(reason, x, y))
        return refuse(instance, ERROR, MODEL_NAME " cannot start: %s", reason);
    memcpy(s->k, k, NK * sizeof *k);
    take(s, x, y, s->time);
    s->stale = 0;
    return OK;
}

/* The step is not taken, or the values are not: all stays as it was. */
static Status discard(const Instance *instance, double time, const char *reason)
{
    char text[32];
    return refuse(instance, DISCARD, "%s at t = %s s", reason, number(text, time));
}

/* As `discard`, for a reason that the model gives: an input that is not wired may be behind it. */
static Status model_discards(const Instance *instance, double time, const char *reason)
{
    char question[SENTENCE], text[32];
    if (!first_unwired(question, &instance->state))
        return discard(instance, time, reason);
    return refuse(instance, DISCARD, "%s %s at t = %s s", question, reason, number(text, time));
}

/* The outputs that belong to time, states and inputs as they are set, into next_y. */
static Status evaluate(Instance *instance)
{
    const State *s = &instance->state;
    char reason[SENTENCE];
    if (input_refused(reason, s))
        return discard(instance, s->time, reason);
    model_outputs((const double *[]){&s->time, s->x, s->u, s->p, s->k}, (double *[]){instance->next_y});
    if (not_acceptable(reason, s->x, instance->next_y))
        return model_discards(instance, s->time, reason);
    return OK;
}

/* The state and outputs are brought up to date with what was set. In continuous time, what is discrete stays as the
   last event left it. */
static Status evaluate_anew(Instance *instance)
{
    State *s = &instance->state;
    Status status;
    if (s->phase <= INITIALISING)
        return initialise(instance);
    if ((status = evaluate(instance)) != OK)
        return status;
    for (int i = 0; i < NY; i++)
        if (s->phase != IN_CONTINUOUS_TIME || !TABLE[COMPUTED[i]].discrete)
            s->y[i] = instance->next_y[i];
    s->stale = 0;
    return OK;
}

static FAST Status refresh(Instance *instance)
{
    return instance->state.stale ? evaluate_anew(instance) : OK;
}

/* The derivatives of the continuous states, into `rates`. */
static Status find_rates(Instance *instance)
{
    const State *s = &instance->state;
    char reason[SENTENCE];
    Status status = refresh(instance);
    if (status != OK)
        return status;
    model_derivative((const double *[]){&s->time, s->x, s->u, s->p, s->k}, (double *[]){instance->rates});
    for (int i = 0; i < NS; i++)
        if (out_of_range(reason, &TABLE[FIRST_RATE + i], instance->rates[i]))
            return model_discards(instance, s->time, reason);
    return OK;
}

/* Number and length of internal steps, and the numbers that depend on them; returns 0 if they are too many. */
static int prepare(State *s, double step)
{
    double count = fmax(1, ceil(step / INTERNAL_STEP(s->p) - ROUNDING));
    if (count > MOST_INTERNAL_STEPS)
        return 0;
    s->count = count;
    s->h = step / count;
    model_prepare((const double *[]){s->p, &s->h, s->k}, (double *[]){s->c});
    s->step = step;
    return 1;
}

/* `step` seconds on from `time` with the inputs held, into next_y and the state that is returned. The last internal
   step is taken together with the outputs after it, which have much in common. */
static const double *advance(Instance *instance, double time, double step)
{
    const State *s = &instance->state;
    const double end = time + step;
    const int last = (int)s->count - 1;
    double t = time, w[LENGTH(NW)];
    const double *arg[] = {&t, &s->h, s->x, s->u, s->p, s->k, s->c, w, &end};
    const double **from = &arg[2];
    model_hold((const double *[]){&s->h, s->u, s->p, s->k, s->c}, (double *[]){w});
    for (int i = 0; i < last; i++) {
        model_advance(arg, (double *[]){instance->next_x[i & 1], instance->next_y}); /* next_y may stay as it is */
        *from = instance->next_x[i & 1];
        t = time + (i + 1) * s->h;
    }
    model_finish(arg, (double *[]){instance->next_x[last & 1], instance->next_y});
    return instance->next_x[last & 1];
}
