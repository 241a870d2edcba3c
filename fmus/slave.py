"""The pythonfmu side of a model: a generic co-simulation slave around its pure functions.

Travels inside every FMU of the Python flavour.
"""
from math import inf, isfinite
from types import ModuleType, SimpleNamespace

from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from . import floats
from .interface import Variable, internal_steps, names, variables

MOST_INTERNAL_STEPS = 1e7


def with_unit(v: Variable, value: float) -> str:
    """A value with its unit, angles in degrees."""
    return f"{v.displayed(value):.6g}{v.unit_suffix}"


def out_of_range(v: Variable, value: float) -> str | None:
    """Why `value` may not stand for `v`, or None."""
    if not isfinite(value):
        return f"{v.name} = {value} is not a finite number"
    if v.minimum is not None and value < v.minimum:
        return f"{v.name} = {with_unit(v, value)} is below its minimum {with_unit(v, v.minimum)}"
    if v.maximum is not None and value > v.maximum:
        return f"{v.name} = {with_unit(v, value)} is above its maximum {with_unit(v, v.maximum)}"
    return None


class ModelSlave(Fmi2Slave):  # type: ignore[misc]
    """Steps `model` (see `fmus.interface`). A subclass names the model, and that is all."""

    model: ModuleType

    def __init__(self, **kwargs: object) -> None:
        """`kwargs` are pythonfmu's own."""
        super().__init__(**kwargs)
        table = variables(self.model.VARIABLES)
        self.table = table
        self.u = SimpleNamespace(**{v.name: v.start for v in table if v.causality == "input"})
        self.p = SimpleNamespace(**{v.name: v.start for v in table if v.causality == "parameter"})
        self.values: dict[int, float | bool | None] = {v.value_reference: v.start for v in table}
        self.of_type = {kind: {v.value_reference for v in table if v.type == kind} for kind in ("Real", "Boolean")}
        self.inputs = {v.value_reference: v for v in table if v.causality == "input"}
        self.parameters = {v.value_reference: v for v in table if v.causality == "parameter"}
        self.computed = [v for v in table if v.causality in ("output", "calculatedParameter")]
        self.bounded = [v for v in self.computed if v.minimum is not None or v.maximum is not None]
        self.has_internal_step = "internal_step" in names(table, "parameter")
        self.x: list[float] = []
        self.time, self.stop_time = 0.0, inf
        self.phase = "instantiated"
        self.stale = True
        self.refused: dict[str, str] = {}
        self.prepared: tuple[float, int, float, list[float]] | None = None

    # --- values -----------------------------------------------------------------------------------

    def get_real(self, vrs: list[int]) -> list[float | bool | None]:
        """fmi2GetReal. Raises KeyError as `get_values` does."""
        return self.get_values(vrs, "Real")

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """fmi2GetBoolean. Raises KeyError as `get_values` does."""
        return [bool(value) for value in self.get_values(vrs, "Boolean")]

    def get_integer(self, vrs: list[int]) -> list[int]:
        """fmi2GetInteger. Raises KeyError for any variable."""
        self.none_of(vrs, "Integer")
        return []

    def get_string(self, vrs: list[int]) -> list[str]:
        """fmi2GetString. Raises KeyError for any variable."""
        self.none_of(vrs, "String")
        return []

    def get_values(self, vrs: list[int], kind: str) -> list[float | bool | None]:
        """Values of variables of this type. Raises KeyError for a variable of another."""
        if self.stale:
            self.initialise()
        values, known = self.values, self.of_type[kind]
        for vr in vrs:
            if vr not in known:
                raise KeyError(f"value reference {vr} is no {kind} of {self.model.NAME}")
        return [values[vr] for vr in vrs]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """fmi2SetReal. Raises as `set_values` does."""
        self.set_values(vrs, values, "Real")

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """fmi2SetBoolean. Raises as `set_values` does."""
        self.set_values(vrs, [bool(value) for value in values], "Boolean")

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """fmi2SetInteger. Raises KeyError for any variable."""
        self.none_of(vrs, "Integer")

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """fmi2SetString. Raises KeyError for any variable."""
        self.none_of(vrs, "String")

    def set_values(self, vrs: list[int], values: list[float] | list[bool], kind: str) -> None:
        """Set inputs and parameters of this type. Raises KeyError for a variable of another, and as `set_parameter`
        does."""
        for vr, value in zip(vrs, values):
            if vr not in self.of_type[kind]:
                raise KeyError(f"value reference {vr} is no {kind} of {self.model.NAME}")
            if vr in self.inputs:
                self.set_input(self.inputs[vr], value)
            else:
                self.set_parameter(vr, value)

    def none_of(self, vrs: list[int], kind: str) -> None:
        """Raises KeyError where there are `vrs`: no model has variables of this type."""
        if vrs:
            raise KeyError(f"{self.model.NAME} has no {kind} variables")

    def set_input(self, v: Variable, value: float) -> None:
        """An input that is not a finite number is refused: the old value stays and the next step is not taken."""
        if isfinite(value):
            setattr(self.u, v.name, value)
            self.values[v.value_reference] = value
            self.refused.pop(v.name, None)
            self.stale = self.phase != "stepping"
        else:
            self.refused[v.name] = f"{v.name} = {value} is not a finite number"
            self.log(f"{self.refused[v.name]} and was refused at t = {self.time:.6g} s", Fmi2Status.discard)

    def set_parameter(self, vr: int, value: float) -> None:
        """Raises PermissionError where the variable may not be set (now), ValueError for a value out of range."""
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

    def allow(self, call: str, phase: str) -> None:
        """Raises RuntimeError where `call` comes in another phase than this."""
        if self.phase != phase:
            raise RuntimeError(f"{call} is not allowed while {self.model.NAME} is {self.phase}")

    def setup_experiment(self, start_time: float, stop_time: float | None = None,
                         tolerance: float | None = None) -> None:
        """fmi2SetupExperiment, times in s. Raises RuntimeError as `allow` does."""
        self.allow("fmi2SetupExperiment", "instantiated")
        self.time = start_time
        self.stop_time = inf if stop_time is None else stop_time

    def enter_initialization_mode(self) -> None:
        """fmi2EnterInitializationMode. Raises RuntimeError as `allow` does."""
        self.allow("fmi2EnterInitializationMode", "instantiated")
        self.phase = "initialising"

    def exit_initialization_mode(self) -> None:
        """fmi2ExitInitializationMode. Raises RuntimeError as `allow` does, ValueError where the model cannot start."""
        self.allow("fmi2ExitInitializationMode", "initialising")
        if self.refused:
            raise ValueError(next(iter(self.refused.values())))
        self.initialise()
        self.phase = "stepping"

    def terminate(self) -> None:
        """fmi2Terminate."""
        self.phase = "terminated"

    def initialise(self) -> None:
        """Take the state and outputs that the inputs and parameters set so far lead to.

        Raises ValueError where the model cannot have them.
        """
        x = self.model.start(floats, self.u, self.p)
        reason = self.accept(x, self.time)
        if reason:
            raise ValueError(f"{self.model.NAME} cannot start: {reason}")
        self.stale = False
        self.prepared = None

    def accept(self, x: list[float], time: float) -> str | None:
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

    def prepare(self, step: float) -> tuple[float, int, float, list[float]] | None:
        """(step, number and length of internal steps, prepared numbers) for communication steps of `step`;
        None if they are too many."""
        count = internal_steps(step, self.p.internal_step) if self.has_internal_step else 1
        if count > MOST_INTERNAL_STEPS:
            return None
        h = step / count
        c = self.model.prepare(floats, self.p, h) if hasattr(self.model, "prepare") else []
        self.prepared = step, count, h, c
        return self.prepared

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step the model, or say why not and stay. Raises RuntimeError outside of the stepping phase."""
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

    def discard(self, reason: str, time: float) -> bool:
        """Say why a step is not taken."""
        self.log(f"{reason} at t = {time:.6g} s", Fmi2Status.discard)
        return False

    # --- state ------------------------------------------------------------------------------------

    def _get_fmu_state(self) -> dict[str, object]:
        """All that changes while the FMU runs, as pythonfmu keeps and pickles it."""
        return {"x": list(self.x), "u": dict(vars(self.u)), "p": dict(vars(self.p)), "time": self.time,
                "stop_time": self.stop_time, "values": list(self.values.values()), "phase": self.phase,
                "stale": self.stale, "refused": dict(self.refused)}

    def _set_fmu_state(self, state: dict) -> None:  # type: ignore[type-arg]
        """Go back to a state of `_get_fmu_state`."""
        self.x = list(state["x"])
        self.u, self.p = SimpleNamespace(**state["u"]), SimpleNamespace(**state["p"])
        self.values = dict(enumerate(state["values"]))
        self.time, self.stop_time = state["time"], state["stop_time"]
        self.phase, self.stale = state["phase"], state["stale"]
        self.refused = dict(state["refused"])
        self.prepared = None
