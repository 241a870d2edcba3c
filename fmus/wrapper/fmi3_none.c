/* The door of FMI 3.0, third part: what no model has. All of it is refused. */

#define NONE_OF(type) \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference valueReferences[], \
                             size_t nValueReferences, fmi3##type values[], size_t nValues) \
    { \
        (void)values, (void)nValues; \
        return to3(none_of(of3(instance), valueReferences, nValueReferences, #type)); \
    } \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference valueReferences[], \
                             size_t nValueReferences, const fmi3##type values[], size_t nValues) \
    { \
        (void)values, (void)nValues; \
        return to3(none_of(of3(instance), valueReferences, nValueReferences, #type)); \
    }

NONE_OF(Float32)
NONE_OF(Int8)
NONE_OF(UInt8)
NONE_OF(Int16)
NONE_OF(UInt16)
NONE_OF(Int32)
NONE_OF(UInt32)
NONE_OF(Int64)
NONE_OF(UInt64)
NONE_OF(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)valueSizes, (void)values, (void)nValues;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Binary"));
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)valueSizes, (void)values, (void)nValues;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Binary"));
}

/* --- clocks ----------------------------------------------------------------------------------- */

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[])
{
    (void)values;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[])
{
    (void)values;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)intervals, (void)qualifiers;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[])
{
    (void)counters, (void)resolutions, (void)qualifiers;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[])
{
    (void)shifts;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)counters, (void)resolutions;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[])
{
    (void)intervals;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[])
{
    (void)counters, (void)resolutions;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[])
{
    (void)shifts;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)counters, (void)resolutions;
    return to3(none_of(of3(instance), valueReferences, nValueReferences, "Clock"));
}

/* --- modes and answers ------------------------------------------------------------------------ */

static fmi3Status none3(fmi3Instance instance, const char *sentence)
{
    Instance *c = of3(instance);
    return to3(c ? refuse(c, ERROR, MODEL_NAME " %s", sentence) : ERROR);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime)
{
    (void)clockReference, (void)activationTime;
    return none3(instance, "is not for scheduled execution");
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    return none3(instance, "has no event mode in co-simulation, and so it is in step mode without this call");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return none3(instance, "has no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return none3(instance, "has no structural parameters");
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues)
{
    (void)valueReferences, (void)nValueReferences, (void)orders, (void)values, (void)nValues;
    return to3(no_output_derivatives(of3(instance)));
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference,
                                               size_t *nDependencies)
{
    (void)valueReference, (void)nDependencies;
    return none3(instance, "gives the dependencies of its variables in the model description only");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
                                       size_t nDependencies)
{
    (void)dependent, (void)elementIndicesOfDependent, (void)independents, (void)elementIndicesOfIndependents;
    (void)dependencyKinds, (void)nDependencies;
    return none3(instance, "gives the dependencies of its variables in the model description only");
}
