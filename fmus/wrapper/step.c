/* A step of co-simulation. */

static Status try_step(Instance *instance, double time, double step)
{
    State *s = &instance->state;
    char reason[SENTENCE], text[32], other[32];
    const double end = time + step;
    const double *x;
    if (!(is_finite(step) && step > 0)) {
        snprintf(reason, sizeof reason, "communication step %s s is not a positive number", number(text, step));
        return discard(instance, time, reason);
    }
    if (!is_finite(time))
        return discard(instance, time, "the communication point is not a finite number");
    if (input_refused(reason, s))
        return discard(instance, time, reason);
    if (end > s->stop_time + 1e-6 * step) /* the importer may have summed up its steps */
        return refuse(instance, ERROR, "a step to t = %s s would go past the stop time %s s", number(text, end),
                      number(other, s->stop_time));
    if (s->step != step && !prepare(s, step)) {
        snprintf(reason, sizeof reason, "communication step %s s takes too many internal steps", number(text, step));
        return discard(instance, time, reason);
    }
    x = advance(instance, time, step);
    if (not_acceptable(reason, x, instance->next_y))
        return model_discards(instance, end, reason);
    take(s, x, instance->next_y, end);
    return OK;
}

static Status step_to(Instance *instance, double time, double step)
{
    if (!instance)
        return ERROR;
    if (instance->state.kind == MODEL_EXCHANGE)
        return refuse(instance, ERROR, "this instance of " MODEL_NAME " is for model exchange and makes no steps");
    if (instance->state.phase != STEPPING)
        return refuse(instance, ERROR, MODEL_NAME " can step only between initialisation and termination");
    instance->state.step_status = try_step(instance, time, step);
    return (Status)instance->state.step_status;
}
