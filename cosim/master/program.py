"""A schedule as data: rows of whole numbers that both tick loops (`loop_plain`, `loop_compiled`) carry out.

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
"""
from collections.abc import Iterable

import numpy as np

SET, PREDICT, SLOPE, STEP, GET, MARK, SAVE, RESTORE = range(8)

# Columns of the tables `groups` and `components`, and kinds of groups, see `wiring`.
CALL, POINTER, REFERENCES, COUNT, BUFFER, FIRST, KIND, OWNER, SET_SLOPES, SLOPES, ORDERS = range(11)
REAL, WHOLE, TEXT = range(3)
INSTANCE, DO_STEP, GET_STATE, SET_STATE, FREE_STATE, SLOTS_FROM, SLOTS_TO = range(7)
TOO_LONG = 1 << 32  # a status of our own, which no FMU can answer: a text that does not fit its place

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
