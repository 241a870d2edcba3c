"""The pythonfmu side of a model: a generic co-simulation slave around its pure functions.

Travels inside every FMU of the Python flavour. What it refuses it refuses with an exception (see `refusal`).
"""
from math import inf, isfinite
from types import ModuleType, SimpleNamespace

from pythonfmu.fmi2slave import Fmi2Slave

from . import floats
from .functions import functions
from .interface import GIVEN, Variable, internal_steps, longest_step, variables
from .refusal import Refused, out_of_range, refusing, startable, unwired

MOST_INTERNAL_STEPS = 1e7


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
        self.longest_step = longest_step(table)
        self.does = functions(self.model)
        self.x: list[float] = []
        self.time, self.stop_time = 0.0, inf
        self.phase = "instantiated"
        self.stale = True
        self.refused: dict[str, str] = {}
        self.prepared: tuple[float, int, float, list[float]] | None = None

    # --- values -----------------------------------------------------------------------------------

    @refusing
    def get_real(self, vrs: list[int]) -> list[float | bool | None]:
        """fmi2GetReal. Raises Refused as `get_values` does."""
        return self.get_values(vrs, "Real")

    @refusing
    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """fmi2GetBoolean. Raises Refused as `get_values` does."""
        return [bool(value) for value in self.get_values(vrs, "Boolean")]

    @refusing
    def get_integer(self, vrs: list[int]) -> list[int]:
        """fmi2GetInteger. Raises Refused for any variable."""
        self.none_of(vrs, "Integer")
        return []

    @refusing
    def get_string(self, vrs: list[int]) -> list[str]:
        """fmi2GetString. Raises Refused for any variable."""
        self.none_of(vrs, "String")
        return []

    def get_values(self, vrs: list[int], kind: str) -> list[float | bool | None]:
        """Values of variables of this type. Raises Refused for a variable of another, and where the model cannot
        start."""
        values, known = self.values, self.of_type[kind]
        for vr in vrs:
            if vr not in known:
                raise Refused(f"value reference {vr} is no {kind} of {self.model.NAME}")
        if self.stale and any(self.table[vr].causality not in GIVEN for vr in vrs):
            self.initialise()
        return [values[vr] for vr in vrs]

    @refusing
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """fmi2SetReal. Raises Refused as `set_values` does."""
        self.set_values(vrs, values, "Real")

    @refusing
    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """fmi2SetBoolean. Raises Refused as `set_values` does."""
        self.set_values(vrs, [bool(value) for value in values], "Boolean")

    @refusing
    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """fmi2SetInteger. Raises Refused for any variable."""
        self.none_of(vrs, "Integer")

    @refusing
    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """fmi2SetString. Raises Refused for any variable."""
        self.none_of(vrs, "String")

    def set_values(self, vrs: list[int], values: list[float] | list[bool], kind: str) -> None:
        """Set inputs and parameters of this type, all or none. Raises Refused as `settable` and `set_inputs` do."""
        for vr, value in zip(vrs, values):
            self.settable(vr, value, kind)
        bad = {}
        for vr, value in zip(vrs, values):
            name = self.table[vr].name
            if vr in self.parameters:
                setattr(self.p, name, value)
            elif isfinite(value):
                setattr(self.u, name, value)
                self.refused.pop(name, None)
            else:
                bad[name] = f"{name} = {value} is not a finite number"
                continue
            self.values[vr] = value
            self.stale = self.phase != "stepping"
        self.refused |= bad
        for reason in bad.values():
            raise Refused(f"{reason} and was refused at t = {self.time:.6g} s")

    def settable(self, vr: int, value: float, kind: str) -> None:
        """Raises Refused where a variable may not be set (now), or is a parameter and `value` out of its range."""
        if vr not in self.of_type[kind]:
            raise Refused(f"value reference {vr} is no {kind} of {self.model.NAME}")
        v = self.table[vr]
        if v.causality not in GIVEN:
            what = "an output" if v.causality == "output" else "a calculated parameter"
            raise Refused(f"{v.name} is {what} and may not be set")
        if v.causality == "parameter" and self.phase in ("stepping", "terminated"):
            raise Refused(f"{v.name} is fixed: it may be set before the end of initialisation only")
        if self.phase == "terminated":
            raise Refused(f"{v.name} may not be set after termination")
        reason = out_of_range(v, value) if v.causality == "parameter" else None
        if reason:
            raise Refused(reason)

    def none_of(self, vrs: list[int], kind: str) -> None:
        """Raises Refused where there are `vrs`: no model has variables of this type."""
        if vrs:
            raise Refused(f"value reference {vrs[0]} is no {kind} of {self.model.NAME}")

    # --- life cycle -------------------------------------------------------------------------------

    def allow(self, phase: str, otherwise: str) -> None:
        """Raises Refused with the sentence `otherwise` in another phase than this."""
        if self.phase != phase:
            raise Refused(otherwise)

    @refusing
    def setup_experiment(self, start_time: float, stop_time: float | None = None,
                         tolerance: float | None = None) -> None:
        """fmi2SetupExperiment, times in s. Raises Refused as `allow` does, and for times that are none."""
        self.allow("instantiated", "the experiment can be set up before initialisation only")
        if not isfinite(start_time):
            raise Refused(f"start time {start_time} s is not a finite number")
        if stop_time is not None and not stop_time >= start_time:
            raise Refused(f"stop time {stop_time:.6g} s is not after start time {start_time:.6g} s")
        self.time = start_time
        self.stop_time = inf if stop_time is None else stop_time
        self.stale = True

    @refusing
    def enter_initialization_mode(self) -> None:
        """fmi2EnterInitializationMode. Raises Refused as `allow` does."""
        self.allow("instantiated", "initialisation can begin once, after instantiation or reset")
        self.phase = "initialising"

    @refusing
    def exit_initialization_mode(self) -> None:
        """fmi2ExitInitializationMode. Raises Refused as `allow` does, and where the model cannot start."""
        self.allow("initialising", "initialisation cannot end, it has not begun")
        for reason in self.refused.values():
            raise Refused(reason)
        if self.stale:
            self.initialise()
        self.phase = "stepping"

    @refusing
    def terminate(self) -> None:
        """fmi2Terminate. Raises Refused as `allow` does."""
        self.allow("stepping", f"{self.model.NAME} can be terminated only after initialisation, and once")
        self.phase = "terminated"

    def initialise(self) -> None:
        """Take the state and outputs that the inputs and parameters set so far lead to.

        Raises Refused where the model cannot have them.
        """
        suspect = self.unwired()
        reason = f"{suspect[1]} {startable(suspect[0])}" if suspect else None
        try:
            reason = reason or self.accept(self.does.start(floats, self.u, self.p), self.time)
        except (ArithmeticError, ValueError) as error:
            reason = f"the state cannot be computed ({error})"
        if reason:
            raise Refused(f"{self.model.NAME} cannot start: {reason}")
        self.stale = False

    def unwired(self) -> tuple[Variable, str] | None:
        """The first input that is outside its range, and a question about it."""
        for v in self.inputs.values():
            question = unwired(v, getattr(self.u, v.name))
            if question:
                return v, question
        return None

    def accept(self, x: list[float], time: float) -> str | None:
        """Take `x` and the outputs it gives as the state at `time`, or return why not."""
        y = self.does.outputs(floats, time, x, self.u, self.p)
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
        count = internal_steps(step, getattr(self.p, self.longest_step)) if self.longest_step else 1
        if count > MOST_INTERNAL_STEPS:
            return None
        h = step / count
        c = self.does.prepare(floats, self.p, h)
        self.prepared = step, count, h, c
        return self.prepared

    @refusing
    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step the model. Raises Refused with the reason where that cannot be done, and then stays where it is."""
        self.allow("stepping", f"{self.model.NAME} can step only between initialisation and termination")
        at = f" at t = {current_time:.6g} s"
        if not (isfinite(step_size) and step_size > 0):
            raise Refused(f"communication step {step_size} s is not a positive number{at}")
        if not isfinite(current_time):
            raise Refused(f"the communication point is not a finite number{at}")
        for wrong in self.refused.values():
            raise Refused(wrong + at)
        end = current_time + step_size
        if end > self.stop_time + 1e-6 * step_size:  # steps may be summed up
            raise Refused(f"a step to t = {end:.6g} s would go past the stop time {self.stop_time:.6g} s")
        prepared = self.prepared
        if prepared is None or prepared[0] != step_size:
            prepared = self.prepare(step_size)
        if prepared is None:
            raise Refused(f"communication step {step_size} s takes too many internal steps{at}")
        reason = self.advance(current_time, *prepared)
        if reason:
            suspect = self.unwired()
            raise Refused(f"{suspect[1] + ' ' if suspect else ''}{reason} at t = {end:.6g} s")
        return True

    def advance(self, time: float, step: float, count: int, h: float, c: list[float]) -> str | None:
        """Take the state `step` seconds after `time`, in `count` steps of `h`, or return why not."""
        x, u, p, advance = self.x, self.u, self.p, self.does.advance
        try:
            for i in range(count):
                x = advance(floats, time + i * h, h, x, u, p, c)
            return self.accept(x, time + step)
        except (ArithmeticError, ValueError) as error:
            return f"the state cannot be computed ({error})"

    # --- state ------------------------------------------------------------------------------------

    @refusing
    def _get_fmu_state(self) -> dict[str, object]:
        """All that changes while the FMU runs, as pythonfmu keeps and pickles it."""
        return {"of": type(self).__module__, "x": list(self.x), "u": dict(vars(self.u)), "p": dict(vars(self.p)),
                "time": self.time, "stop_time": self.stop_time, "values": list(self.values.values()),
                "phase": self.phase, "stale": self.stale, "refused": dict(self.refused)}

    @refusing
    def _set_fmu_state(self, state: dict) -> None:  # type: ignore[type-arg]
        """Go back to a state of `_get_fmu_state`. Raises Refused for a state of another FMU."""
        if state.get("of") != type(self).__module__:
            raise Refused(f"the state given is none of this {self.model.NAME}, or was changed")
        self.x = list(state["x"])
        self.u, self.p = SimpleNamespace(**state["u"]), SimpleNamespace(**state["p"])
        self.values = dict(enumerate(state["values"]))
        self.time, self.stop_time = state["time"], state["stop_time"]
        self.phase, self.stale = state["phase"], state["stale"]
        self.refused = dict(state["refused"])
        self.prepared = None

    @staticmethod
    def _fmu_state_from_bytes(data: bytes) -> dict:  # type: ignore[type-arg]
        """A serialised state. What is none becomes a state that `_set_fmu_state` refuses: here no exception is safe."""
        try:
            state = Fmi2Slave._fmu_state_from_bytes(data)
        except ValueError:
            state = None
        return state if isinstance(state, dict) else {}
