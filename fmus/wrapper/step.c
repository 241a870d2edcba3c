/* fmi2DoStep and what can be asked about it. */

/* The step is not taken: all stays as it was at the last communication point. */
static fmi2Status discard(const Instance *instance, double time, const char *reason)
{
    char text[32];
    return refuse(instance, fmi2Discard, "%s at t = %s s", reason, number(text, time));
}

static fmi2Status do_step(Instance *instance, double time, double step)
{
    State *s = &instance->state;
    char reason[SENTENCE], question[SENTENCE], text[32], other[32];
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
        return refuse(instance, fmi2Error, "a step to t = %s s would go past the stop time %s s", number(text, end),
                      number(other, s->stop_time));
    if (s->step != step && !prepare(s, step)) {
        snprintf(reason, sizeof reason, "communication step %s s takes too many internal steps", number(text, step));
        return discard(instance, time, reason);
    }
    x = advance(instance, time, step);
    if (not_acceptable(reason, x, instance->next_y)) {
        if (!first_unwired(question, s))
            return discard(instance, end, reason);
        return refuse(instance, fmi2Discard, "%s %s at t = %s s", question, reason, number(text, end));
    }
    take(s, x, instance->next_y, end);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    Instance *instance = valid(c);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!instance)
        return fmi2Error;
    if (instance->state.phase != STEPPING)
        return refuse(instance, fmi2Error, MODEL_NAME " can step only between initialisation and termination");
    instance->state.step_status = do_step(instance, currentCommunicationPoint, communicationStepSize);
    return (fmi2Status)instance->state.step_status;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    Instance *instance = valid(c);
    return instance ? refuse(instance, fmi2Error, "there is no step to cancel: " MODEL_NAME " does not step asynchronously")
                    : fmi2Error;
}

static fmi2Status no_status(const Instance *instance)
{
    return instance ? refuse(instance, fmi2Discard, MODEL_NAME " has no such status") : fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    Instance *instance = valid(c);
    if (!instance || !value || s != fmi2DoStepStatus)
        return no_status(instance);
    *value = (fmi2Status)instance->state.step_status;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    Instance *instance = valid(c);
    if (!instance || !value || s != fmi2LastSuccessfulTime)
        return no_status(instance);
    *value = instance->state.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    Instance *instance = valid(c);
    if (!instance || !value || s != fmi2Terminated)
        return no_status(instance);
    *value = fmi2False; /* a discarded step is a failure: no model ends the simulation */
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)s, (void)value;
    return no_status(valid(c));
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)s, (void)value;
    return no_status(valid(c));
}
