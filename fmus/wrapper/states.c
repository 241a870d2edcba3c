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

static int ours(const Saved *saved)
{
    return saved && saved->magic == SAVED_MAGIC && saved->size == sizeof *saved &&
           memcmp(saved->guid, GUID, sizeof GUID) == 0;
}

static Saved *new_saved(const Instance *instance)
{
    Saved *saved = instance->host.allocate(1, sizeof *saved);
    if (!saved) {
        refuse(instance, ERROR, "no memory for a state of " MODEL_NAME);
        return NULL;
    }
    memset(saved, 0, sizeof *saved);
    saved->magic = SAVED_MAGIC;
    saved->size = sizeof *saved;
    memcpy(saved->guid, GUID, sizeof GUID);
    return saved;
}

static Status foreign(const Instance *instance)
{
    return refuse(instance, ERROR, "the state given is none of this " MODEL_NAME ", or was changed or freed");
}

static Status save_state(const Instance *instance, void **place)
{
    Saved *saved;
    if (!instance)
        return ERROR;
    if (!place || (*place && !ours(*place)))
        return foreign(instance);
    saved = *place ? *place : new_saved(instance);
    if (!saved)
        return ERROR;
    saved->state = instance->state;
    *place = saved;
    return OK;
}

static Status restore_state(Instance *instance, const Saved *saved)
{
    if (!instance)
        return ERROR;
    if (!ours(saved) || saved->state.kind != instance->state.kind)
        return foreign(instance);
    instance->state = saved->state;
    return OK;
}

static Status free_state(const Instance *instance, void **place)
{
    if (!instance)
        return ERROR;
    if (!place || !*place)
        return OK;
    if (!ours(*place))
        return foreign(instance);
    ((Saved *)*place)->magic = 0;
    instance->host.release(*place);
    *place = NULL;
    return OK;
}

static Status serialised_size(const Instance *instance, const Saved *saved, size_t *size)
{
    if (!instance)
        return ERROR;
    if (!ours(saved) || !size)
        return foreign(instance);
    *size = sizeof *saved;
    return OK;
}

static Status serialise(const Instance *instance, Saved *saved, void *bytes, size_t size)
{
    if (!instance)
        return ERROR;
    if (!ours(saved) || !bytes)
        return foreign(instance);
    if (size < sizeof *saved)
        return refuse(instance, ERROR, "a serialised state takes %u bytes, not %u", (unsigned)sizeof *saved,
                      (unsigned)size);
    saved->checksum = checksum(&saved->state);
    memcpy(bytes, saved, sizeof *saved);
    return OK;
}

static Status deserialise(const Instance *instance, const void *bytes, size_t size, void **place)
{
    Saved *saved, given;
    if (!instance)
        return ERROR;
    if (!bytes || !place || size != sizeof given)
        return foreign(instance);
    memcpy(&given, bytes, sizeof given);
    if (!ours(&given) || given.checksum != checksum(&given.state))
        return foreign(instance);
    if (*place && !ours(*place))
        return foreign(instance);
    saved = *place ? *place : new_saved(instance);
    if (!saved)
        return ERROR;
    saved->state = given.state;
    *place = saved;
    return OK;
}
