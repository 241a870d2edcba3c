/* Model exchange: the importer's solver sets time and states, and asks for their derivatives.

   There are no event indicators and no events in time. An output that is discrete keeps its value in continuous time;
   where a completed step of the solver would change it, an event is asked for. */

/* Whether the instance is for model exchange, and in one of the two phases. */
static int exchanges(const Instance *instance, Phase one, Phase other, const char *when)
{
    if (instance->state.kind != MODEL_EXCHANGE)
        refuse(instance, ERROR, "this instance of " MODEL_NAME " is for co-simulation, not for model exchange");
    else if (instance->state.phase != (int32_t)one && instance->state.phase != (int32_t)other)
        refuse(instance, ERROR, "this call is for %s only", when);
    else
        return 1;
    return 0;
}

/* Whether an array of `n` numbers, one for each of `count`, may be read or written. */
static int array_fits(const Instance *instance, const void *array, size_t n, int count, const char *of_what)
{
    if (n == (size_t)count && (array || n == 0))
        return 1;
    refuse(instance, ERROR, MODEL_NAME " has %d %s, and an array of %u numbers was given", count, of_what,
           array ? (unsigned)n : 0);
    return 0;
}

static Status set_time(Instance *instance, double time)
{
    if (!instance || !exchanges(instance, AT_EVENT, IN_CONTINUOUS_TIME, "events and continuous time"))
        return ERROR;
    if (!is_finite(time))
        return refuse(instance, ERROR, "the time is not a finite number");
    instance->state.time = time;
    instance->state.stale = 1;
    return OK;
}

static Status set_states(Instance *instance, const double x[], size_t n)
{
    if (!instance || !exchanges(instance, IN_CONTINUOUS_TIME, IN_CONTINUOUS_TIME, "continuous time") ||
        !array_fits(instance, x, n, NS, "continuous states"))
        return ERROR;
    for (int i = 0; i < NS; i++) /* a number that is none is refused where anything is computed from it */
        instance->state.x[i] = x[i];
    instance->state.stale = 1;
    return OK;
}

static int may_ask(const Instance *instance, const void *array, size_t n, int count, const char *of_what)
{
    if (instance && instance->state.kind != MODEL_EXCHANGE)
        refuse(instance, ERROR, "this instance of " MODEL_NAME " is for co-simulation, not for model exchange");
    else if (instance)
        return array_fits(instance, array, n, count, of_what);
    return 0;
}

static Status get_states(Instance *instance, double x[], size_t n)
{
    Status status = OK;
    if (!may_ask(instance, x, n, NS, "continuous states"))
        return ERROR;
    if (instance->state.phase <= INITIALISING && (status = refresh(instance)) != OK)
        return status;
    for (int i = 0; i < NS; i++)
        x[i] = instance->state.x[i];
    return OK;
}

static Status get_rates(Instance *instance, double rates[], size_t n)
{
    Status status;
    if (!may_ask(instance, rates, n, NS, "derivatives of continuous states"))
        return ERROR;
    if ((status = find_rates(instance)) != OK)
        return status;
    for (int i = 0; i < NS; i++)
        rates[i] = instance->rates[i];
    return OK;
}

static Status get_nominals(Instance *instance, double nominals[], size_t n)
{
    if (!may_ask(instance, nominals, n, NS, "continuous states"))
        return ERROR;
    for (int i = 0; i < NS; i++)
        nominals[i] = NOMINALS[i];
    return OK;
}

static Status get_event_indicators(const Instance *instance, const double indicators[], size_t n)
{
    return may_ask(instance, indicators, n, 0, "event indicators") ? OK : ERROR;
}

static Status enter_event(Instance *instance)
{
    if (!instance || !exchanges(instance, IN_CONTINUOUS_TIME, IN_CONTINUOUS_TIME, "continuous time"))
        return ERROR;
    instance->state.phase = AT_EVENT;
    instance->state.stale = 1;
    return OK;
}

/* At an event: there is nothing to iterate. `places_given` says whether the importer gave places for all answers. */
static Status update_discrete(Instance *instance, int places_given)
{
    return instance && exchanges(instance, AT_EVENT, AT_EVENT, "events") && answerable(instance, places_given) ? OK
                                                                                                             : ERROR;
}

static Status enter_continuous_time(Instance *instance)
{
    Status status;
    if (!instance || !exchanges(instance, AT_EVENT, AT_EVENT, "events"))
        return ERROR;
    if ((status = refresh(instance)) != OK)
        return status;
    instance->state.phase = IN_CONTINUOUS_TIME;
    return OK;
}

/* A solver may look past the stop time within its last step, but not complete a step there. */
static Status completed_step(Instance *instance, int places_given, int *event)
{
    const State *s;
    Status status;
    char text[32], other[32];
    if (!instance || !exchanges(instance, IN_CONTINUOUS_TIME, IN_CONTINUOUS_TIME, "continuous time") ||
        !answerable(instance, places_given))
        return ERROR;
    s = &instance->state;
    if (s->time > s->stop_time + 1e-6 * fmax(1, fabs(s->stop_time)))
        return refuse(instance, ERROR, "a step to t = %s s is past the stop time %s s", number(text, s->time),
                      number(other, s->stop_time));
    *event = 0;
    if (!HAS_DISCRETE_OUTPUTS)
        return OK;
    if ((status = evaluate(instance)) != OK)
        return status;
    for (int i = 0; i < NY; i++)
        *event |= TABLE[COMPUTED[i]].discrete && instance->next_y[i] != s->y[i];
    return OK;
}
