"""A schedule as data: rows of whole numbers that both tick loops (`loop_plain`, `loop_compiled`) carry out. loop.c is
compiled with the names in capitals.

A row is (code, index, period, phase, reach). It is carried out on ticks k with k % period == phase;
`index` is a group of variables or a component; `reach` is how many base steps an FMU's step spans.
With t the time at the start of the tick and h the base step:

    SET      give a group its inputs, as the signals are now
    PREDICT  give a group its inputs as they will be, by their last slope, halfway through the step to come
    SLOPE    give a group its inputs at t, and their slopes (fmi2SetRealInputDerivatives)
    STEP     fmi2DoStep from t over reach * h
    GET      read a group's variables into the signals
    MARK     remember a component's signals and their time as the last ones; those to come hold at t + reach * h,
             and are recorded from then on
    SAVE     fmi2GetFMUstate of a component, in place of the one saved before
    RESTORE  fmi2SetFMUstate of the saved one
    OFFER    look whether a group's inputs have changed, which the component is then given at its next STEP, in event
             mode (FMI 3.0)

A STEP of FMI 3.0 goes on after an early return, and updates discrete states where the FMU asks for it.
"""
from collections.abc import Iterable

import numpy as np

SET, PREDICT, SLOPE, STEP, GET, MARK, SAVE, RESTORE, OFFER = range(9)

# Columns of the tables `groups` and `components`, and how many there are, see `wiring`.
CALL, POINTER, REFERENCES, COUNT, BUFFER, FIRST, KIND, OWNER, SET_SLOPES, SLOPES, ORDERS, VALUES = range(12)
(INSTANCE, DO_STEP, GET_STATE, SET_STATE, FREE_STATE, SLOTS_FROM, SLOTS_TO, ENTER_EVENTS, UPDATE, ENTER_STEPS, ANSWERS,
 OFFERS_FROM, OFFERS_TO) = range(13)
GROUP_COLUMNS, COMPONENT_COLUMNS = VALUES + 1, OFFERS_TO + 1

# Kinds of groups: how a value lies in memory. A truth value is WHOLE in FMI 2.0, UINT8 in FMI 3.0.
REAL, WHOLE, TEXT, FLOAT, INT8, INT16, INT64, UINT8, UINT16, UINT32, UINT64 = range(11)
DTYPES = {REAL: np.float64, WHOLE: np.int32, TEXT: np.int64, FLOAT: np.float32, INT8: np.int8, INT16: np.int16,
          INT64: np.int64, UINT8: np.uint8, UINT16: np.uint16, UINT32: np.uint32, UINT64: np.uint64}

# Columns of the table `events`: what fmi3DoStep and fmi3UpdateDiscreteStates have answered, as bytes (in a step: event,
# end of the simulation, early return; in an update: again, end, two of no use here, next event known) and a time; then
# whether inputs are to be given in event mode, and which of IN_EVENTS is under way.
FLAGS, REACHED, UPDATED, NEXT, CHANGED, CALLED = range(6)
EVENT_COLUMNS = CALLED + 1
EVENT_BYTE, END_BYTE, EARLY_BYTE = range(3)
IN_STEP, ENTERING, GIVING, UPDATING, LEAVING = range(5)
MOST_ROUNDS = 1000  # without going on in time: updates of discrete states, or early returns
EARLY = 1e-9        # of a step: what is due at its end is not missed by a rounding of the clock

LONGEST_TEXT = 4096  # bytes, with the zero at the end

# The statuses of FMI calls.
OK, WARNING, DISCARD, ERROR, FATAL = range(5)

# Statuses of our own, which no FMU can answer: a text that does not fit its place, and events without end.
TOO_LONG, RESTLESS = 1 << 32, 1 << 33

# Places of the loops' cursor, which tells where they are at any time: the tick; the row of the program; the number of
# rows recorded; code and index of the program's row; the number of FMU calls; the steps of an algorithm whose ticks are
# none (else -1).
TICK, AT, ROWS, CODE, INDEX, CALLS, STEPS = range(7)


def cursor() -> np.ndarray:
    """A new cursor."""
    return np.array([0, 0, 0, 0, 0, 0, -1], np.int64)

Row = tuple[int, int, int, int, int]


def row(code: int, index: int, period: int = 1, phase: int = 0, reach: int = 1) -> Row:
    """One row, by default of every tick and over one base step."""
    return (code, index, period, phase, reach)


def program(rows: Iterable[Row]) -> np.ndarray:
    """The rows as an array of whole numbers, shape (rows, 5)."""
    return np.array(list(rows), dtype=np.int64).reshape(-1, 5)
