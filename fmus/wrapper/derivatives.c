/* Derivatives of what is computed: outputs and the rates of states, after initialisation with respect to inputs and
   continuous states; before its end through the initial state, with respect to inputs and parameters. */

typedef struct {
    double x[LENGTH(NX)], u[LENGTH(NU)], p[LENGTH(NP)];
} Direction;

typedef struct {
    double y[LENGTH(NY)], rates[LENGTH(NS)], x[LENGTH(NX)];
} Response;

static void respond(const State *s, Direction *d, Response *response)
{
    double start[LENGTH(NX)];
    const double *x = s->x;
    if (s->phase < STEPPING) {
        model_start((const double *[]){s->u, s->p}, (double *[]){start});
        model_start_tangent((const double *[]){s->u, s->p, d->u, d->p}, (double *[]){d->x});
        x = start;
    }
    memcpy(response->x, d->x, sizeof d->x);
    model_tangent((const double *[]){&s->time, x, s->u, s->p, d->x, d->u, d->p},
                  (double *[]){response->y, response->rates});
}

/* Where the known `v` stands in a direction, or NULL if it is no known now. */
static double *known_place(const State *s, Direction *d, const Variable *v)
{
    int starting = s->phase < STEPPING;
    if (v->role == INPUT)
        return &d->u[v->place];
    if (v->role == PARAMETER && starting)
        return &d->p[v->place];
    return v->state >= 0 && !starting ? &d->x[v->state] : NULL;
}

/* Where the unknown `v` stands in a response, or NULL if it is no unknown now. */
static double *unknown_place(const State *s, Response *r, const Variable *v)
{
    if (v->role == OUTPUT || v->role == CALCULATED_PARAMETER)
        return &r->y[v->place];
    if (v->role == RATE)
        return &r->rates[v->place];
    return v->role == STATE && s->phase < STEPPING ? &r->x[v->place] : NULL;
}

/* Whether all variables are there, of a number type, and are knowns and unknowns now. `a` names the derivative with
   its article. */
static int derivable(const Instance *instance, const Reference unknowns[], size_t n_unknowns, const Reference knowns[],
                     size_t n_knowns, const char *a, const char *type)
{
    Direction direction;
    Response response;
    if (!known(instance, unknowns, n_unknowns, 0, type) || !known(instance, knowns, n_knowns, 0, type))
        return 0;
    for (size_t i = 0; i < n_knowns; i++)
        if (!known_place(&instance->state, &direction, &TABLE[knowns[i]])) {
            refuse(instance, ERROR, "%s is not among the knowns of %s derivative now", TABLE[knowns[i]].name, a);
            return 0;
        }
    for (size_t i = 0; i < n_unknowns; i++)
        if (!unknown_place(&instance->state, &response, &TABLE[unknowns[i]])) {
            refuse(instance, ERROR, "%s is not among the unknowns of %s derivative", TABLE[unknowns[i]].name, a);
            return 0;
        }
    return 1;
}

/* sensitivity = J seed, with a seed for each known and a sensitivity for each unknown. */
static Status directional_derivative(const Instance *instance, const Reference unknowns[], size_t n_unknowns,
                                     const Reference knowns[], size_t n_knowns, const double seed[],
                                     double sensitivity[], const char *type)
{
    Direction direction = {{0}, {0}, {0}};
    Response response;
    if (!instance || !arrays_given(instance, n_unknowns, unknowns, sensitivity) ||
        !arrays_given(instance, n_knowns, knowns, seed) ||
        !derivable(instance, unknowns, n_unknowns, knowns, n_knowns, "a directional", type))
        return ERROR;
    for (size_t i = 0; i < n_knowns; i++)
        *known_place(&instance->state, &direction, &TABLE[knowns[i]]) += seed[i];
    respond(&instance->state, &direction, &response);
    for (size_t i = 0; i < n_unknowns; i++)
        sensitivity[i] = *unknown_place(&instance->state, &response, &TABLE[unknowns[i]]);
    return OK;
}

/* sensitivity = seed J, with a seed for each unknown and a sensitivity for each known: as many directional derivatives
   as there are knowns, which are few. */
static Status adjoint_derivative(const Instance *instance, const Reference unknowns[], size_t n_unknowns,
                                 const Reference knowns[], size_t n_knowns, const double seed[], double sensitivity[],
                                 const char *type)
{
    if (!instance || !arrays_given(instance, n_unknowns, unknowns, seed) ||
        !arrays_given(instance, n_knowns, knowns, sensitivity) ||
        !derivable(instance, unknowns, n_unknowns, knowns, n_knowns, "an adjoint", type))
        return ERROR;
    for (size_t i = 0; i < n_knowns; i++) {
        Direction direction = {{0}, {0}, {0}};
        Response response;
        *known_place(&instance->state, &direction, &TABLE[knowns[i]]) = 1;
        respond(&instance->state, &direction, &response);
        sensitivity[i] = 0;
        for (size_t j = 0; j < n_unknowns; j++)
            sensitivity[i] += seed[j] * *unknown_place(&instance->state, &response, &TABLE[unknowns[j]]);
    }
    return OK;
}
