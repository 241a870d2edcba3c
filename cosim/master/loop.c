/* The tick loop: carries out a program on a wiring's arrays. `loop_plain` says the same in Python and is what this is
   compared with, to the last bit; words in capitals are those of program.py. FMU functions are called at their
   addresses. No library of C is needed. */
#include <stdint.h>

#ifdef _WIN32
#define SEEN __declspec(dllexport)
#else
#define SEEN __attribute__((visibility("default")))
#endif
#define DONE(status) ((status) == OK || (status) == WARNING)
#define FAST inline __attribute__((always_inline))

typedef int64_t word;  /* also an address: on all platforms that are served it has 64 bits */
typedef int32_t (*Mode)(word), (*State)(word, word), (*Transfer)(word, word, word, word, word),
    (*Update)(word, word, word, word, word, word, word), (*DoStep)(word, double, double, int32_t, word, word, word, word);

typedef struct { word code, index, period, phase, reach; } Row;
typedef struct { double now, earlier; } Clock;

typedef struct {  /* see `wiring`; in the order of ARRAYS in loop_compiled.py */
    const word (*groups)[GROUP_COLUMNS], (*components)[COMPONENT_COLUMNS], *where;
    const double *factor, *offset;
    word *buffers;
    double *slopes, *signals;
    word *exact;
    double *before;
    Clock *clock;
    const word *holder;
    const uint8_t *smooth;
    char (*texts)[LONGEST_TEXT];
    word *states, (*events)[EVENT_COLUMNS];
    const uint8_t *offers;
    const word *recorded;
} Wiring;

static FAST word transfer(const word *group)
{
    return ((Transfer)group[CALL])(group[POINTER], group[REFERENCES], group[COUNT], group[BUFFER], group[VALUES]);
}

/* --- values ---------------------------------------------------------------------------------------------------- */

#define EACH_WHOLE(X) X(WHOLE, int32_t) X(INT8, int8_t) X(INT16, int16_t) X(INT64, int64_t) X(UINT8, uint8_t) \
    X(UINT16, uint16_t) X(UINT32, uint32_t) X(UINT64, uint64_t)

/* The values of a group into the signals; TOO_LONG for a text that does not fit. */
static FAST word take_in(const Wiring *w, const word *group)
{
    const word *where = w->where + group[FIRST], count = group[VALUES], *values = w->buffers + group[FIRST];
    word status = OK;
    switch (group[KIND]) {
    case REAL: for (word i = 0; i < count; i++) w->signals[where[i]] = ((const double *)values)[i]; break;
    case FLOAT: for (word i = 0; i < count; i++) w->signals[where[i]] = ((const float *)values)[i]; break;
#define TAKE(K, TYPE) case K: for (word i = 0; i < count; i++) { \
        const TYPE value = ((const TYPE *)values)[i]; \
        w->signals[where[i]] = (double)value, w->exact[where[i]] = (word)value; } break;
    EACH_WHOLE(TAKE)
    case TEXT: for (word i = 0; i < count; i++) {  /* a null pointer counts as an empty text */
        const char *text = values[i] ? (const char *)values[i] : "";
        char *place = w->texts[where[i]];
        word n = 0;
        while (n < LONGEST_TEXT - 1 && text[n]) place[n] = text[n], n++;
        if (text[n]) status = TOO_LONG;
        place[n] = 0;
    }
    }
    return status;
}

/* The signals into the values of a group; whether one has changed, which texts always count as. */
static FAST int hand_out(const Wiring *w, const word *group)
{
    const word first = group[FIRST], *where = w->where + first, count = group[VALUES];
    const double *factor = w->factor + first, *offset = w->offset + first;
    word *values = w->buffers + first;
    int changed = 0;
    switch (group[KIND]) {
#define PUT(TYPE, VALUE) for (word i = 0; i < count; i++) { \
        const TYPE value = (TYPE)(VALUE), was = ((TYPE *)values)[i]; \
        ((TYPE *)values)[i] = value, changed |= value != was; } break;
    case REAL: PUT(double, factor[i] * w->signals[where[i]] + offset[i])
    case FLOAT: PUT(float, factor[i] * w->signals[where[i]] + offset[i])
#define GIVE(K, TYPE) case K: PUT(TYPE, w->exact[where[i]])
    EACH_WHOLE(GIVE)
    case TEXT: changed = 1;  /* an input points at its source already */
    }
    return changed;
}

/* The same by the last slope of each signal, as it will be at `time` (s); only real numbers have slopes. */
static void predict(const Wiring *w, const word *group, double time)
{
    if (group[KIND] != REAL && group[KIND] != FLOAT) {
        hand_out(w, group);
        return;
    }
    word *values = w->buffers + group[FIRST];
    for (word i = 0; i < group[VALUES]; i++) {
        const word p = group[FIRST] + i, s = w->where[p];
        const Clock clock = w->clock[w->holder[s]];
        double value = w->signals[s], slope = 0.0;
        if (w->smooth[s] && clock.now > clock.earlier) {
            slope = (value - w->before[s]) / (clock.now - clock.earlier);
            value = value + slope * (time - clock.now);
        }
        w->slopes[p] = w->factor[p] * slope;
        value = w->factor[p] * value + w->offset[p];
        if (group[KIND] == REAL) ((double *)values)[i] = value;
        else ((float *)values)[i] = (float)value;
    }
}

/* --- steps ----------------------------------------------------------------------------------------------------- */

#define FLAG(word_, byte) (((uint8_t *)&events[word_])[byte])
#define TIME(word_) (*(double *)&events[word_])

static FAST word do_step(const Wiring *w, word c, double begun, double length)
{
    const word *own = w->components[c], place = own[ANSWERS];
    return ((DoStep)own[DO_STEP])(own[INSTANCE], begun, length, w->states[c] == 0,  /* else it may be set back yet */
                                  place, place + END_BYTE, place + EARLY_BYTE, place + 8 * REACHED);
}

/* Event mode of the component c at `time` (s): inputs that have been offered, then discrete states; and back. */
static word in_event_mode(const Wiring *w, word c, double time)
{
    const word *own = w->components[c], update = own[ANSWERS] + 8 * UPDATED;
    word *events = w->events[c];
    events[CALLED] = ENTERING;
    word status = ((Mode)own[ENTER_EVENTS])(own[INSTANCE]);
    if (events[CHANGED]) {
        events[CALLED] = GIVING;
        for (word n = own[OFFERS_FROM]; n < own[OFFERS_TO] && DONE(status); n++) status = transfer(w->groups[n]);
        events[CHANGED] = 0;
    }
    for (int round = 0; round < MOST_ROUNDS && DONE(status); round++) {
        events[CALLED] = UPDATING, events[UPDATED] = 0;
        status = ((Update)own[UPDATE])(own[INSTANCE], update, update + 1, update + 2, update + 3, update + 4,
                                       own[ANSWERS] + 8 * NEXT);
        if (DONE(status) && FLAG(UPDATED, END_BYTE)) {
            FLAG(FLAGS, END_BYTE) = 1, TIME(REACHED) = time;
            return DISCARD;
        }
        if (DONE(status) && !FLAG(UPDATED, 0)) {
            events[CALLED] = LEAVING;
            status = ((Mode)own[ENTER_STEPS])(own[INSTANCE]);
            if (DONE(status)) events[CALLED] = IN_STEP;
            return status;
        }
    }
    return DONE(status) ? RESTLESS : status;
}

/* What follows a step of the component c from `begun` to `end` (s) whose answers are not all false: the update of
   discrete states, and the rest of the step after an early return. DISCARD if the FMU ends the simulation: its answers
   tell when. */
static word step_on(const Wiring *w, word c, double begun, double end)
{
    word *events = w->events[c], status = OK;
    for (int rounds = 0; DONE(status) && events[FLAGS];) {
        const int early = FLAG(FLAGS, EARLY_BYTE) != 0;
        const double now = early ? TIME(REACHED) : end;
        if (FLAG(FLAGS, END_BYTE)) {
            TIME(REACHED) = now;
            return DISCARD;
        }
        if (FLAG(FLAGS, EVENT_BYTE) && w->components[c][ENTER_EVENTS]) {
            events[FLAGS] = 0;
            status = in_event_mode(w, c, now);
        }
        events[FLAGS] &= (word)1 << 8 * END_BYTE;
        if (!DONE(status) || !early || now >= end - EARLY * (end - begun)) break;
        rounds = now > begun ? 0 : rounds + 1;
        if (rounds > MOST_ROUNDS) return RESTLESS;
        begun = now > begun ? now : begun;
        status = do_step(w, c, begun, end - begun);
    }
    return status;
}

/* --- the loop -------------------------------------------------------------------------------------------------- */

/* One row of a program in the tick from t (s); its status. */
static FAST word carry_out(const Wiring *w, const Row *row, double t, double reach)
{
    const word index = row->index, *group = w->groups[index], *own = w->components[index];
    word *events = w->events[index], status = OK;
    switch (row->code) {
    case SET:
        hand_out(w, group);
        return transfer(group);
    case PREDICT:
        predict(w, group, t + 0.5 * reach);
        return transfer(group);
    case SLOPE:
        predict(w, group, t + 0.0);
        status = transfer(group);
        return !DONE(status) ? status : ((Transfer)group[SET_SLOPES])(group[POINTER], group[REFERENCES], group[COUNT],
                                                                      group[ORDERS], group[SLOPES]);
    case STEP:
        if (events[CHANGED]) status = in_event_mode(w, index, t);
        if (DONE(status)) status = do_step(w, index, t, reach);
        return DONE(status) && events[FLAGS] ? step_on(w, index, t, t + reach) : status;
    case GET:
        status = transfer(group);
        return !DONE(status) || take_in(w, group) == OK ? status : TOO_LONG;
    case MARK:
        for (word s = own[SLOTS_FROM]; s < own[SLOTS_TO]; s++) w->before[s] = w->signals[s];
        w->clock[index] = (Clock){t + reach, w->clock[index].now};
        return OK;
    case SAVE:
        if (w->states[index]) {
            status = ((State)own[FREE_STATE])(own[INSTANCE], (word)&w->states[index]);
            w->states[index] = 0;
        }
        return !DONE(status) ? status : ((State)own[GET_STATE])(own[INSTANCE], (word)&w->states[index]);
    case RESTORE:
        status = ((State)own[SET_STATE])(own[INSTANCE], w->states[index]);
        events[CHANGED] = w->offers[index];  /* the FMU has the inputs of that time */
        return status;
    default: /* OFFER */
        if (hand_out(w, group)) w->events[group[OWNER]][CHANGED] = 1;
        return OK;
    }
}

/* Ticks first ... first + count - 1 of `step` from `start` (s); a row of the recorded signals (there are `columns`)
   after each tick whose number, counted from 1, `decimate` divides (0: none); a signal that is marked for later shows
   what it was before. Returns 0, or the status of the call that failed; `cursor` tells where it is at any time. */
SEEN word run(const Wiring *w, const Row *program, word length, double *rows, double *times, word *cursor, word columns,
              word first, word count, double start, double step, word decimate)
{
    for (word tick = first; tick < first + count; tick++) {
        const double t = start + (double)tick * step;
        cursor[TICK] = tick;
        for (word i = 0; i < length; i++) {
            const Row *row = program + i;
            if (row->period != 1 && tick % row->period != row->phase) continue;
            cursor[AT] = i, cursor[CODE] = row->code, cursor[INDEX] = row->index, cursor[CALLS]++;
            const word status = carry_out(w, row, t, (double)row->reach * step);
            if (!DONE(status)) return status;
        }
        if (decimate > 0 && (tick + 1) % decimate == 0) {
            const double now = start + (double)(tick + 1) * step;
            double *shown = rows + cursor[ROWS] * columns;
            for (word c = 0; c < columns; c++) {
                const word s = w->recorded[c];
                shown[c] = w->clock[w->holder[s]].now <= now + 0.5 * step ? w->signals[s] : w->before[s];
            }
            times[cursor[ROWS]++] = now;
        }
    }
    return OK;
}

/* --- a table's values ------------------------------------------------------------------------------------------- */

typedef struct {  /* what look_up.py puts together */
    const word *cursor;
    const double *span, *times, *rows;
    const uint8_t *held;
    word length, width;
} Place;

/* What the column c has at the time of the loop's tick, see table.py. */
static FAST double looked_up(const Place *p, uint32_t c, double time, double early)
{
    word low = 0, high = p->length;
    while (low < high) {
        const word middle = (low + high) / 2;
        if (p->times[middle] <= time + early) low = middle + 1;
        else high = middle;
    }
    const word last = low > 0 ? low - 1 : 0;
    const double value = p->rows[last * p->width + c];
    if (low == 0 || low == p->length || p->held[c]) return value;
    const double share = (time - p->times[last]) / (p->times[low] - p->times[last]);
    return share > 0.0 ? value + share * (p->rows[low * p->width + c] - value) : value;
}

#define LOOK_UP(NAME, TYPE) SEEN int32_t NAME(const Place *p, const uint32_t *columns, word count, TYPE *values) \
{ \
    const double time = p->span[0] + (double)p->cursor[TICK] * p->span[1], early = EARLY * p->span[1]; \
    for (word i = 0; i < count; i++) values[i] = (TYPE)looked_up(p, columns[i], time, early); \
    return OK; \
}
LOOK_UP(look_up_reals, double)
LOOK_UP(look_up_wholes, word)
