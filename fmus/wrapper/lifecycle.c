/* From the making of an instance to its end. */

static void reset(State *s, Kind kind)
{
    memset(s, 0, sizeof *s);
    s->stop_time = INFINITY;
    s->kind = (int32_t)kind;
    s->phase = INSTANTIATED;
    s->stale = 1;
    for (int i = 0; i < NV; i++) {
        if (TABLE[i].role == INPUT)
            s->u[TABLE[i].place] = TABLE[i].start;
        if (TABLE[i].role == PARAMETER)
            s->p[TABLE[i].place] = TABLE[i].start;
    }
}

static Instance *not_instantiated(const Host *host, const char *name, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    say(host, ALL_CATEGORIES, name ? name : MODEL_NAME, ERROR, format, arguments);
    va_end(arguments);
    return NULL;
}

/* An instance of the door whose magic this is, or NULL; `token` has to be this build's, and is named `token_name`. */
static Instance *instantiate(const Host *host, uint64_t magic, Kind kind, const char *name, const char *token,
                             const char *token_name)
{
    Instance *instance;
    if (!name || !name[0])
        return not_instantiated(host, name, "an instance of " MODEL_NAME " needs a name");
    if (kind == MODEL_EXCHANGE && !HAS_DERIVATIVE)
        return not_instantiated(host, name, MODEL_NAME " is for co-simulation only");
    if (!token || strcmp(token, FMU_GUID) != 0)
        return not_instantiated(host, name, "the %s %s is not that of this " MODEL_NAME ", " FMU_GUID, token_name,
                                token ? token : "NULL");
    instance = host->allocate(1, sizeof(Instance) + strlen(name) + 1);
    if (!instance)
        return not_instantiated(host, name, "no memory for an instance of " MODEL_NAME);
    memset(instance, 0, sizeof *instance);
    instance->host = *host;
    instance->logged = ALL_CATEGORIES;
    strcpy(instance->name, name);
    reset(&instance->state, kind);
    instance->magic = magic;
    return instance;
}

static void free_instance(Instance *instance)
{
    if (!instance)
        return;
    instance->magic = 0; /* a second call with the same pointer finds no instance, while the memory is not reused */
    instance->host.release(instance);
}

static Status choose_log_categories(Instance *instance, int on, size_t n, const char *const categories[])
{
    unsigned logged = 0;
    if (!instance || (n && !categories))
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        int is_known = 0;
        for (int j = 0; j < N_CATEGORIES; j++)
            if (categories[i] && strcmp(categories[i], CATEGORIES[j]) == 0) {
                logged |= j == N_CATEGORIES - 1 ? ALL_CATEGORIES : 1u << j;
                is_known = 1;
            }
        if (!is_known)
            return refuse(instance, ERROR, MODEL_NAME " has no log category %s",
                          categories[i] ? categories[i] : "NULL");
    }
    instance->logged = on && n ? logged : ALL_CATEGORIES;
    return OK;
}

/* The tolerance that importers also give is of no use to steps that are fixed. */
static Status set_up_experiment(Instance *instance, double start_time, int stop_time_defined, double stop_time)
{
    char text[32], start[32];
    if (!instance)
        return ERROR;
    if (instance->state.phase != INSTANTIATED)
        return refuse(instance, ERROR, "the experiment can be set up before initialisation only");
    if (!is_finite(start_time))
        return refuse(instance, ERROR, "start time %s s is not a finite number", number(text, start_time));
    if (stop_time_defined && !(stop_time >= start_time))
        return refuse(instance, ERROR, "stop time %s s is not after start time %s s", number(text, stop_time),
                      number(start, start_time));
    instance->state.time = start_time;
    instance->state.stop_time = stop_time_defined ? stop_time : INFINITY;
    instance->state.stale = 1;
    return OK;
}

static Status enter_initialisation(Instance *instance)
{
    if (!instance)
        return ERROR;
    if (instance->state.phase != INSTANTIATED)
        return refuse(instance, ERROR, "initialisation can begin once, after instantiation or reset");
    instance->state.phase = INITIALISING;
    return OK;
}

static Status exit_initialisation(Instance *instance)
{
    char reason[SENTENCE];
    if (!instance)
        return ERROR;
    if (instance->state.phase != INITIALISING)
        return refuse(instance, ERROR, "initialisation cannot end, it has not begun");
    if (input_refused(reason, &instance->state))
        return refuse(instance, ERROR, "%s", reason);
    if (refresh(instance) != OK)
        return ERROR;
    instance->state.phase = instance->state.kind == MODEL_EXCHANGE ? AT_EVENT : STEPPING;
    return OK;
}

static Status terminate(Instance *instance)
{
    if (!instance)
        return ERROR;
    if (instance->state.phase <= INITIALISING || instance->state.phase == TERMINATED)
        return refuse(instance, ERROR, MODEL_NAME " can be terminated only after initialisation, and once");
    instance->state.phase = TERMINATED;
    return OK;
}

static Status begin_again(Instance *instance)
{
    if (!instance)
        return ERROR;
    reset(&instance->state, (Kind)instance->state.kind);
    return OK;
}
