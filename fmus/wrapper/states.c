/* Saving, restoring and serialising the state of an instance. A saved state and its serialised form are the same
   bytes; they belong to this very build of the FMU, on processors of one byte order. */

static const char GUID[40] = FMU_GUID; /* a multiple of 8 bytes, so that there is no padding after it */

typedef struct {
    uint64_t magic, size, checksum; /* of the state; only computed where it leaves the process */
    char guid[sizeof GUID];
    State state;
} Saved;

#define SAVED_MAGIC UINT64_C(0x3145544154534e21)

/* FNV-1a */
static uint64_t checksum(const State *state)
{
    const unsigned char *bytes = (const unsigned char *)state;
    uint64_t sum = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < sizeof *state; i++)
        sum = (sum ^ bytes[i]) * UINT64_C(1099511628211);
    return sum;
}

static Saved *ours(Saved *saved)
{
    return saved && saved->magic == SAVED_MAGIC && saved->size == sizeof *saved && memcmp(saved->guid, GUID, sizeof GUID) == 0
               ? saved : NULL;
}

static Saved *new_saved(const Instance *instance)
{
    Saved *saved = instance->callbacks.allocateMemory(1, sizeof *saved);
    if (!saved) {
        refuse(instance, fmi2Error, "no memory for a state of " MODEL_NAME);
        return NULL;
    }
    memset(saved, 0, sizeof *saved);
    saved->magic = SAVED_MAGIC;
    saved->size = sizeof *saved;
    memcpy(saved->guid, GUID, sizeof GUID);
    return saved;
}

static fmi2Status foreign(const Instance *instance)
{
    return refuse(instance, fmi2Error, "the state given is none of this " MODEL_NAME ", or was changed or freed");
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    Instance *instance = valid(c);
    Saved *saved;
    if (!instance)
        return fmi2Error;
    if (!FMUstate || (*FMUstate && !ours(*FMUstate)))
        return foreign(instance);
    saved = *FMUstate ? *FMUstate : new_saved(instance);
    if (!saved)
        return fmi2Error;
    saved->state = instance->state;
    *FMUstate = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    Instance *instance = valid(c);
    if (!instance)
        return fmi2Error;
    if (!ours(FMUstate))
        return foreign(instance);
    instance->state = ((const Saved *)FMUstate)->state;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    Instance *instance = valid(c);
    Saved *saved;
    if (!instance)
        return fmi2Error;
    if (!FMUstate || !*FMUstate)
        return fmi2OK;
    saved = ours(*FMUstate);
    if (!saved)
        return foreign(instance);
    saved->magic = 0;
    instance->callbacks.freeMemory(saved);
    *FMUstate = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    Instance *instance = valid(c);
    if (!instance)
        return fmi2Error;
    if (!ours(FMUstate) || !size)
        return foreign(instance);
    *size = sizeof(Saved);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    Instance *instance = valid(c);
    Saved *saved;
    if (!instance)
        return fmi2Error;
    saved = ours(FMUstate);
    if (!saved || !serializedState)
        return foreign(instance);
    if (size < sizeof *saved)
        return refuse(instance, fmi2Error, "a serialised state takes %u bytes, not %u", (unsigned)sizeof *saved,
                      (unsigned)size);
    saved->checksum = checksum(&saved->state);
    memcpy(serializedState, saved, sizeof *saved);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    Instance *instance = valid(c);
    Saved *saved, given;
    if (!instance)
        return fmi2Error;
    if (!serializedState || !FMUstate || size != sizeof given)
        return foreign(instance);
    memcpy(&given, serializedState, sizeof given);
    if (!ours(&given) || given.checksum != checksum(&given.state))
        return foreign(instance);
    if (*FMUstate && !ours(*FMUstate))
        return foreign(instance);
    saved = *FMUstate ? *FMUstate : new_saved(instance);
    if (!saved)
        return fmi2Error;
    saved->state = given.state;
    *FMUstate = saved;
    return fmi2OK;
}
