/* The door of FMI 3.0, second part: how time goes on, in co-simulation and in model exchange. */

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    Instance *c = of3(instance);
    Status status;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!c || !answerable(c, eventHandlingNeeded && terminateSimulation && earlyReturn && lastSuccessfulTime))
        return fmi3Error;
    status = step_to(c, currentCommunicationPoint, communicationStepSize);
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = fmi3False;
    *lastSuccessfulTime = c->state.time;
    return to3(status);
}

/* --- model exchange --------------------------------------------------------------------------- */

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    return to3(enter_event(of3(instance)));
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    return to3(update_discrete(of3(instance), 1));
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    Status status = update_discrete(of3(instance), discreteStatesNeedUpdate && terminateSimulation &&
                                                       nominalsOfContinuousStatesChanged &&
                                                       valuesOfContinuousStatesChanged && nextEventTimeDefined &&
                                                       nextEventTime);
    if (status == OK) {
        *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = fmi3False;
        *valuesOfContinuousStatesChanged = *nextEventTimeDefined = fmi3False;
        *nextEventTime = 0;
    }
    return to3(status);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    return to3(enter_continuous_time(of3(instance)));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    int event = 0;
    Status status = completed_step(of3(instance), enterEventMode && terminateSimulation, &event);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (status == OK) {
        *enterEventMode = event != 0;
        *terminateSimulation = fmi3False;
    }
    return to3(status);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    return to3(set_time(of3(instance), time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    return to3(set_states(of3(instance), continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    return to3(get_states(of3(instance), continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates)
{
    return to3(get_rates(of3(instance), derivatives, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    return to3(get_nominals(of3(instance), nominals, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    return to3(get_event_indicators(of3(instance), eventIndicators, nEventIndicators));
}

static fmi3Status number_of(fmi3Instance instance, size_t number, size_t *answer)
{
    Instance *c = of3(instance);
    if (!c || !answerable(c, answer != NULL))
        return fmi3Error;
    *answer = number;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    return number_of(instance, NS, nContinuousStates);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    return number_of(instance, 0, nEventIndicators);
}
