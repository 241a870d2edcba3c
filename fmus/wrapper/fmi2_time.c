/* The door of FMI 2.0, second part: how time goes on, in co-simulation and in model exchange. */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    return to2(step_to(of2(c), currentCommunicationPoint, communicationStepSize));
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    Instance *instance = of2(c);
    return to2(instance ? refuse(instance, ERROR, "there is no step to cancel: " MODEL_NAME
                                                  " does not step asynchronously") : ERROR);
}

static fmi2Status no_status(const Instance *instance)
{
    return to2(instance ? refuse(instance, DISCARD, MODEL_NAME " has no such status") : ERROR);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    Instance *instance = of2(c);
    if (!instance || !value || s != fmi2DoStepStatus)
        return no_status(instance);
    *value = (fmi2Status)instance->state.step_status;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    Instance *instance = of2(c);
    if (!instance || !value || s != fmi2LastSuccessfulTime)
        return no_status(instance);
    *value = instance->state.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    Instance *instance = of2(c);
    if (!instance || !value || s != fmi2Terminated)
        return no_status(instance);
    *value = fmi2False; /* a discarded step is a failure: no model ends the simulation */
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)s, (void)value;
    return no_status(of2(c));
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)s, (void)value;
    return no_status(of2(c));
}

/* --- model exchange --------------------------------------------------------------------------- */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    return to2(enter_event(of2(c)));
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    static const fmi2EventInfo nothing; /* needed, changed or due */
    Status status = update_discrete(of2(c), eventInfo != NULL);
    if (status == OK)
        *eventInfo = nothing;
    return to2(status);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    return to2(enter_continuous_time(of2(c)));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    int event = 0;
    Status status = completed_step(of2(c), enterEventMode && terminateSimulation, &event);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (status == OK) {
        *enterEventMode = event ? fmi2True : fmi2False;
        *terminateSimulation = fmi2False;
    }
    return to2(status);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    return to2(set_time(of2(c), time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    return to2(set_states(of2(c), x, nx));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    return to2(get_states(of2(c), x, nx));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    return to2(get_rates(of2(c), derivatives, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    return to2(get_nominals(of2(c), x_nominal, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    return to2(get_event_indicators(of2(c), eventIndicators, ni));
}
