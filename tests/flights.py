"""Flights made of arrays, for what is computed from a flight."""
import numpy as np

from cosim.master.flight import Flight
from cosim.master.wiring import Signal


def made(time, signals, periods=None) -> Flight:
    """A finished flight with rows at `time` (s) and `signals`: component.variable -> a value for each row, or one."""
    time = np.asarray(time, float)
    columns = [Signal(name, "", "") for name in signals]
    rows = np.column_stack([np.broadcast_to(np.asarray(values, float), time.shape) for values in signals.values()])
    return Flight(time, rows, columns, True, "", 0.0, 0.0, {}, {}, len(time) - 1, float(time[-1]),
                  periods=periods or {})
