"""The pythonfmu side of a model: a generic co-simulation slave around its pure functions.

Travels inside every FMU of the Python flavour.
"""
from math import ceil, degrees, inf, isfinite
from types import ModuleType, SimpleNamespace

from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from . import floats
from .interface import names, variables

MOST_INTERNAL_STEPS = 1e7
ROUNDING = 1e-9  # of a step: 10 ms in steps of 1 ms are 10, not 11


def shown(v, value):
    """A value with its unit, angles in degrees."""
    if v.display_unit:
        return f"{degrees(value):.6g} {v.display_unit}"
    return f"{value:.6g}" + ("" if v.unit in ("1", "") else f" {v.unit}")


def out_of_range(v, value):
    """Why `value` may not stand for `v`, or None."""
    if not isfinite(value):
        return f"{v.name} = {value} is not a finite number"
    if v.minimum is not None and value < v.minimum:
        return f"{v.name} = {shown(v, value)} is below its minimum {shown(v, v.minimum)}"
    if v.maximum is not None and value > v.maximum:
        return f"{v.name} = {shown(v, value)} is above its maximum {shown(v, v.maximum)}"
    return None


class ModelSlave(Fmi2Slave):
    """Steps `model` (see `fmus.interface`). A subclass names the model, and that is all."""

    model: ModuleType

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        table = variables(self.model.VARIABLES)
        self.table = table
        self.u = SimpleNamespace(**{v.name: v.start for v in table if v.causality == "input"})
        self.p = SimpleNamespace(**{v.name: v.start for v in table if v.causality == "parameter"})
        self.values = {v.value_reference: v.start for v in table}
        self.real = {v.value_reference for v in table if v.type == "Real"}
        self.inputs = {v.value_reference: v for v in table if v.causality == "input"}
        self.parameters = {v.value_reference: v for v in table if v.causality == "parameter"}
        self.computed = [v for v in table if v.causality in ("output", "calculatedParameter")]
        self.bounded = [v for v in self.computed if v.minimum is not None or v.maximum is not None]
        self.has_internal_step = "internal_step" in names(table, "parameter")
        self.x = []
        self.time, self.stop_time = 0.0, inf
        self.phase = "instantiated"
        self.stale = True
        self.refused = {}
        self.prepared = None

    # --- values -----------------------------------------------------------------------------------

    def get_real(self, vrs):
        if self.stale:
            self.initialise()
        values, real = self.values, self.real
        for vr in vrs:
            if vr not in real:
                raise KeyError(f"value reference {vr} is no Real of {self.model.NAME}")
        return [values[vr] for vr in vrs]

    def get_boolean(self, vrs):
        if self.stale:
            self.initialise()
        for vr in vrs:
            if vr in self.real or vr not in self.values:
                raise KeyError(f"value reference {vr} is no Boolean of {self.model.NAME}")
        return [bool(self.values[vr]) for vr in vrs]

    def get_integer(self, vrs):
        return self.no_such(vrs, "Integer")

    def get_string(self, vrs):
        return self.no_such(vrs, "String")

    def set_real(self, vrs, values):
        for vr, value in zip(vrs, values):
            if vr in self.inputs:
                self.set_input(self.inputs[vr], value)
            elif vr in self.real:
                self.set_parameter(vr, value)
            else:
                raise KeyError(f"value reference {vr} is no Real of {self.model.NAME}")

    def set_boolean(self, vrs, values):
        for vr, value in zip(vrs, values):
            if vr in self.real or vr not in self.values:
                raise KeyError(f"value reference {vr} is no Boolean of {self.model.NAME}")
            self.set_parameter(vr, bool(value))

    def set_integer(self, vrs, values):
        self.no_such(vrs, "Integer")

    def set_string(self, vrs, values):
        self.no_such(vrs, "String")

    def no_such(self, vrs, kind):
        if vrs:
            raise KeyError(f"{self.model.NAME} has no {kind} variables")
        return []

    def set_input(self, v, value):
        """An input that is not a finite number is refused: the old value stays and the next step is not taken."""
        if isfinite(value):
            setattr(self.u, v.name, value)
            self.values[v.value_reference] = value
            self.refused.pop(v.name, None)
            self.stale = self.phase != "stepping"
        else:
            self.refused[v.name] = f"{v.name} = {value} is not a finite number"
            self.log(f"{self.refused[v.name]} and was refused at t = {self.time:.6g} s", Fmi2Status.discard)

    def set_parameter(self, vr, value):
        v = self.parameters.get(vr)
        if v is None:
            raise PermissionError(f"{self.table[vr].name} is an {self.table[vr].causality} and may not be set")
        if self.phase == "stepping":
            raise PermissionError(f"{v.name} is fixed: it may be set before the end of initialisation only")
        reason = out_of_range(v, value)
        if reason:
            raise ValueError(reason)
        setattr(self.p, v.name, value)
        self.values[vr] = value
        self.stale = True

    # --- life cycle -------------------------------------------------------------------------------

    def allow(self, call, phase):
        if self.phase != phase:
            raise RuntimeError(f"{call} is not allowed while {self.model.NAME} is {self.phase}")

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):
        self.allow("fmi2SetupExperiment", "instantiated")
        self.time = start_time
        self.stop_time = inf if stop_time is None else stop_time

    def enter_initialization_mode(self):
        self.allow("fmi2EnterInitializationMode", "instantiated")
        self.phase = "initialising"

    def exit_initialization_mode(self):
        self.allow("fmi2ExitInitializationMode", "initialising")
        if self.refused:
            raise ValueError(next(iter(self.refused.values())))
        self.initialise()
        self.phase = "stepping"

    def terminate(self):
        self.phase = "terminated"

    def initialise(self):
        """The state and outputs that the inputs and parameters set so far lead to."""
        x = self.model.start(floats, self.u, self.p)
        reason = self.accept(x, self.time)
        if reason:
            raise ValueError(f"{self.model.NAME} cannot start: {reason}")
        self.stale = False
        self.prepared = None

    def accept(self, x, time):
        """Take `x` and the outputs it gives as the state at `time`, or return why not."""
        y = self.model.outputs(floats, time, x, self.u, self.p)
        if not isfinite(sum(y.values()) + sum(x)):
            return next((f"{name} = {value} is not a finite number" for name, value in y.items()
                         if not isfinite(value)), "an internal state is not a finite number")
        for v in self.bounded:
            reason = out_of_range(v, y[v.name])
            if reason:
                return reason
        values = self.values
        for v in self.computed:
            values[v.value_reference] = y[v.name]
        self.x, self.time = x, time
        return None

    def prepare(self, step):
        """(step, number and length of internal steps, prepared numbers) for communication steps of `step`;
        None if they are too many."""
        count = max(1, ceil(step / self.p.internal_step - ROUNDING)) if self.has_internal_step else 1
        if count > MOST_INTERNAL_STEPS:
            return None
        h = step / count
        c = self.model.prepare(floats, self.p, h) if hasattr(self.model, "prepare") else ()
        self.prepared = step, count, h, c
        return self.prepared

    def do_step(self, current_time, step_size):
        if self.phase != "stepping":
            raise RuntimeError(f"{self.model.NAME} can step only between initialisation and termination")
        if not (isfinite(step_size) and step_size > 0):
            return self.discard(f"communication step {step_size} s is not a positive number", current_time)
        if self.refused:
            return self.discard(next(iter(self.refused.values())), current_time)
        if current_time + step_size > self.stop_time + 1e-6 * step_size:  # steps may be summed up
            return self.discard(f"a step of {step_size:.6g} s would go past the stop time {self.stop_time:.6g} s",
                                current_time)
        prepared = self.prepared
        if prepared is None or prepared[0] != step_size:
            prepared = self.prepare(step_size)
        if prepared is None:
            return self.discard(f"communication step {step_size} s takes too many internal steps", current_time)
        _, count, h, c = prepared
        x, u, p, advance = self.x, self.u, self.p, self.model.advance
        try:
            for i in range(count):
                x = advance(floats, current_time + i * h, h, x, u, p, c)
            reason = self.accept(x, current_time + step_size)
        except (ArithmeticError, ValueError) as error:
            reason = f"the state cannot be computed ({error})"
        return True if reason is None else self.discard(reason, current_time + step_size)

    def discard(self, reason, time):
        self.log(f"{reason} at t = {time:.6g} s", Fmi2Status.discard)
        return False

    # --- state ------------------------------------------------------------------------------------

    def _get_fmu_state(self):
        return {"x": list(self.x), "u": dict(vars(self.u)), "p": dict(vars(self.p)), "time": self.time,
                "stop_time": self.stop_time, "values": list(self.values.values()), "phase": self.phase,
                "stale": self.stale, "refused": dict(self.refused)}

    def _set_fmu_state(self, state):
        self.x = list(state["x"])
        self.u, self.p = SimpleNamespace(**state["u"]), SimpleNamespace(**state["p"])
        self.values = dict(enumerate(state["values"]))
        self.time, self.stop_time = state["time"], state["stop_time"]
        self.phase, self.stale = state["phase"], state["stale"]
        self.refused = dict(state["refused"])
        self.prepared = None
