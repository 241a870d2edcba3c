"""One FMU with model exchange, linearised where it starts, where it is after a while, or at given values."""
import os
import sys
from collections.abc import Iterable
from math import isfinite, nan
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from ..errors import RunError, UsageError
from ..master.fmi2 import take_messages
from ..master.fmu import FmuFile
from ..master.quantities import in_unit_of
from ..master.system import Value
from .equations import Found, Point, linearised, rate_variables, state_variables
from .statespace import poles, roots, zeros_of_all

TOLERANCE = 1e-12  # relative, of the flight to the point
QUIET = "SUNLOGGER_ERROR_FILENAME", "SUNLOGGER_WARNING_FILENAME"  # where the solver writes what it raises as well
ROWS = 1000        # of that flight; FMPy's solver takes at most 500 steps to each
SAME = 1e-4        # relative: rates at the point that are those of the flight's end


def linearize_fmu(path: Path, words: Iterable[str] = (), time: float = 0.0) -> dict[str, Any]:
    """The equations of the FMU at `path` about the point that it reaches after `time` (s) with its inputs held.

    `words` are VARIABLE=VALUE: parameters, inputs, and continuous states of the start. All its continuous Real inputs
    and outputs take part. Returns a dictionary:
        file, fmi_version, time_s
        derivatives    "directional" (the FMU's own) or "differences"
        states, rates  values of the continuous states and of their derivatives at the point, by the states' names
        system         states, inputs, outputs, step_s (0: continuous), A, B, C, D, poles and zeros (by "input to
                       output"), both in 1/s

    Raises UsageError if it has no model-exchange interface, or for a word that does not fit; RunError if it refuses a
    call, or has a kink at the point.
    """
    if time < 0 or not isfinite(time):
        raise UsageError(f"--time {time:g} is not allowed: it must be 0 or a positive number of seconds.")
    with FmuFile.open(path, exchange=True) as file:
        names = [v.name for v in state_variables(file)]
        values, states = given(file, words, names)
        inputs, outputs = ([n for n in file.names(kind) if file.variables[n].smooth] for kind in ("input", "output"))
        ended: dict[str, float] = {}
        if time > 0:
            states, ended = flown(file, values, states, time)
        found = linearised(file, Point(values, states, time), inputs, outputs)
        check_rates(file, found, ended, time)
        version = file.description.version
    system = found.system
    return {"file": str(path), "fmi_version": version, "time_s": time,
            "derivatives": "directional" if found.directional else "differences",
            "states": dict(zip(names, found.states.tolist())), "rates": dict(zip(names, found.rates.tolist())),
            "system": {**system.as_dict(), "poles": roots(poles(system)), "zeros": zeros_of_all(system, outputs)}}


def given(file: FmuFile, words: Iterable[str], states: list[str]) -> tuple[dict[str, Value], dict[str, float]]:
    """The values of VARIABLE=VALUE words: those that are set before the start, and those of continuous states."""
    values: dict[str, Value] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or not name:
            raise UsageError(f"--set {word} is not of the form VARIABLE=VALUE.")
        values[name] = value
    own = {name: state(file, name, str(values.pop(name))) for name in states if name in values}
    return {name: file.checked(name, value, file.path.stem) for name, value in values.items()}, own


def state(file: FmuFile, name: str, word: str) -> float:
    """The value of a state, with a unit if wanted. Raises UsageError."""
    value = in_unit_of(file.variables[name], file.description, word, name)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = nan
    if not isfinite(number):
        raise UsageError(f"{name} = {word} is not allowed: it must be a number.")
    return number


def flown(file: FmuFile, values: dict[str, Value], states: dict[str, float], time: float
          ) -> tuple[dict[str, float], dict[str, float]]:
    """The states after `time` (s), and their derivatives, by FMPy's solver with its events. Raises RunError."""
    rates = [v for rate in rate_variables(file) for v in rate.elements()]
    names = [v.name for v in state_variables(file)]
    arrays = {file.variables[n].array for n in (*values, *states)} - {""}
    if arrays:
        raise UsageError(f"Elements of the array {arrays.pop()} cannot be set here for a flight to --time {time:g} s.")
    shown = list(dict.fromkeys(file.variables[n].array or n for n in (*names, *(v.name for v in rates))))
    messages: list[str] = []

    def hear(*words: Any) -> None:
        messages.append(words[-1].decode("utf-8", "replace"))

    os.environ.update(dict.fromkeys(QUIET, os.devnull))
    usual, sys.unraisablehook = sys.unraisablehook, lambda _: None  # a refused call is raised in the solver's callback
    try:
        rows = fmpy.simulate_fmu(str(file.folder), fmi_type="ModelExchange", start_time=0.0, stop_time=time,
                                 relative_tolerance=TOLERANCE, output_interval=time / ROWS, output=shown,
                                 start_values={**values, **states}, logger=hear)
    except Exception as error:  # FMPy raises many kinds
        said = messages[-1] if messages else str(error).rpartition(".c: ")[2]  # without a place in the solver's source
        raise RunError(f"{file.path} cannot be flown to t = {time:g} s: {said.strip().rstrip('.')}.") from None
    finally:
        sys.unraisablehook = usual
        take_messages()
    if not len(rows) or not np.isclose(rows[-1]["time"], time):
        raise RunError(f"{file.path} ends before t = {time:g} s.")
    last = {name: np.ravel(rows[-1][name]).tolist() for name in shown}
    return ({n: last[v.array or n][v.place] for n in names for v in [file.variables[n]]},
            {v.name: last[v.array or v.name][v.place] for v in rates})


def check_rates(file: FmuFile, found: Found, ended: dict[str, float], time: float) -> None:
    """Raise RunError if the flight ended with other derivatives than the FMU has when it is put there: what an event
    has changed on the way cannot be given."""
    for rate, (name, value) in zip(found.rates, ended.items()):
        if abs(rate - value) > SAME * max(abs(value), np.abs(found.rates).max(), 1e-12):
            raise RunError(f"{file.path} cannot be linearised at t = {time:g} s: an event on the way has changed more "
                           f"than its states ({name} is {value:.6g} there, not {rate:.6g}).")
