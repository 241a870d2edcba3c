"""An FMU's equations linearised about a point, through its model-exchange interface.

    dx/dt = A x + B u,   y = C x + D u

By directional derivatives where the FMU has them, else by differences of what it answers beside the point.
"""
import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from ..master.declared import Variable
from ..master.fmu import FmuFile
from ..master.instance import ADDRESS, SIZE, Instance
from ..master.system import System, Value
from .statespace import StateSpace

Array = np.ndarray
SIZES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of a difference, relative to the variable's scale
KINK, KEPT, NOISE = 1e-2, 0.5, 1e-14    # relative: slopes that differ; what is left of that nearer by; of the answers


@dataclass(frozen=True)
class Point:
    """Where an FMU is linearised: at `time` (s), with all it is given before it starts (parameters, inputs) and the
    values of its continuous states by name; of states that are not named, what they start with."""
    values: Mapping[str, Value]
    states: Mapping[str, float]
    time: float = 0.0


@dataclass(frozen=True)
class Found:
    """An FMU linearised: the `system` (continuous), the states and their rates at the point, and whether the FMU's own
    directional derivatives were taken."""
    system: StateSpace
    states: Array
    rates: Array
    directional: bool


def linearised(file: FmuFile, point: Point, inputs: Sequence[str], outputs: Sequence[str],
               own: bool = True) -> Found:
    """The equations of `file`, which has a model-exchange interface, about a point; `own` allows the FMU's own
    directional derivatives.

    Raises UsageError for a library's name that is none, RunError if the FMU refuses a call or its answers have a kink.
    """
    with closing(Equations(file.for_exchange(), point, own)) as equations:
        x, rates = equations.get("GetContinuousStates"), equations.rates()
        return Found(equations.linear(inputs, outputs), x, rates, equations.own)


def given(system: System, file: FmuFile, component: str, signals: Mapping[str, float]) -> dict[str, Value]:
    """The values that a component is given before it starts: its own, and its connected inputs from `signals`."""
    values: dict[str, Value] = dict(next(c.values for c in system.components if c.name == component))
    for link in system.connections:
        if link.target.partition(".")[0] == component and link.source in signals:
            variable = file.variable(link.target.partition(".")[2])
            value = link.factor * signals[link.source] + link.offset
            values[variable.name] = value if variable.family == "Real" else round(value)
    return values


def state_variables(file: FmuFile) -> list[Variable]:
    """The continuous states of an FMU, in the order of its model structure, arrays as their elements."""
    found = [file.description.variable(rate.derivative) for rate in rate_variables(file)]
    return [element for v in found if v for element in v.elements()]


def rate_variables(file: FmuFile) -> list[Variable]:
    """The derivatives of the states, arrays as a whole."""
    listed = (file.description.variable(unknown.index) for unknown in file.description.derivatives)
    return [v for v in listed if v and v.derivative]


class Equations:
    """An instance for model exchange, at a point."""

    def __init__(self, file: FmuFile, point: Point, own: bool = True):
        """Start `file` and go to `point`; `own` allows its directional derivatives. Raises RunError if the FMU
        refuses."""
        self.file, self.states = file, state_variables(file)
        self.instance = Instance(file, file.path.stem)
        self.own = own and self.instance.claims("providesDirectionalDerivative")
        try:
            self.instance.set({n: file.checked(n, x, file.path.stem) for n, x in point.values.items()})
            self.instance.enter(0.0, None)
            self.instance.leave(0.0)
            self.call("SetTime", ctypes.c_double(point.time))
            x = self.get("GetContinuousStates")
            for i, v in enumerate(self.states):
                x[i] = point.states.get(v.name, x[i])
            self.put(x)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Free the instance."""
        self.instance.close()

    def call(self, name: str, *arguments: ctypes._SimpleCData) -> None:
        """A call that fills what it is given. Raises RunError if the FMU refuses."""
        name = self.instance.standard.PREFIX + name
        self.instance.check(self.instance.call(name, *arguments), name)

    def get(self, name: str) -> Array:
        """What a call answers with a number for each state."""
        found = np.zeros(len(self.states))
        self.call(name, ADDRESS(found.ctypes.data), SIZE(len(found)))
        return found

    def put(self, x: Array) -> None:
        """Set the states."""
        if len(x):
            self.call("SetContinuousStates", ADDRESS(x.ctypes.data), SIZE(len(x)))

    def rates(self) -> Array:
        """The states' derivatives."""
        return self.get("GetContinuousStateDerivatives" if self.file.description.flat else "GetDerivatives")

    def linear(self, inputs: Sequence[str], outputs: Sequence[str]) -> StateSpace:
        """The equations about where they are. Raises RunError for a kink, or if the FMU refuses."""
        J, n = (self.directional if self.own else self.differences)(inputs, outputs), len(self.states)
        return StateSpace(J[:n, :n], J[:n, n:], J[n:, :n], J[n:, n:], [v.name for v in self.states], list(inputs),
                          list(outputs), 0.0)

    def directional(self, inputs: Sequence[str], outputs: Sequence[str]) -> Array:
        """The Jacobian of rates and outputs by states and inputs, by the FMU's own derivatives."""
        of, rates = self.file.variables, rate_variables(self.file)
        shown = self.file.together(outputs)
        unknowns = np.array([*(v.reference for v in rates), *self.file.references(shown)], np.uint32)
        rows = [*range(len(self.states)), *(len(self.states) + shown.index(name) for name in outputs)]
        height, columns = len(self.states) + len(shown), []
        for variable in (*self.states, *(of[name] for name in inputs)):
            known = np.array([variable.reference], np.uint32)
            seed = np.eye(1, len(self.file.arrays.get(variable.array, [""])), variable.place)[0]
            found = np.zeros(height)
            places = [ADDRESS(a.ctypes.data) for a in (unknowns, known, seed, found)]
            counts = [SIZE(len(a)) for a in (unknowns, known, seed, found)]
            sizes = counts if self.file.description.flat else [*counts[:2], None, None]
            if height:  # of no unknowns some FMUs answer that they have no memory for them
                self.call("GetDirectionalDerivative",
                          *(part for pair in zip(places, sizes) for part in pair if part is not None))
            columns.append(found[rows])
        J = np.array(columns).reshape(len(columns), len(rows)).T
        state_at = {v.reference: i for i, v in enumerate(self.states) if not v.array}
        for row, name in enumerate(outputs, len(self.states)):  # a state that is an output: some answer 0 to that
            if of[name].reference in state_at:
                J[row] = np.eye(1, J.shape[1], state_at[of[name].reference])[0]
        return J

    def differences(self, inputs: Sequence[str], outputs: Sequence[str]) -> Array:
        """The same by differences. Raises RunError for a kink."""
        start, n = np.array([*self.get("GetContinuousStates"), *self.instance.get(inputs)]), len(self.states)
        names = [*(v.name for v in self.states), *inputs]
        nominal = [self.file.variables[name].nominal for name in names]
        columns = []

        def answer(v: Array) -> Array:
            self.put(v[:n])
            self.instance.set(dict(zip(inputs, v[n:].tolist())))
            shown = self.instance.get(outputs)  # first: OpenModelica's are left behind when rates are computed
            return np.array([*self.rates(), *shown])

        for i, name in enumerate(names):
            unit = np.eye(1, len(start), i)[0] * max(abs(start[i]), abs(nominal[i] or 1.0))
            slopes, kink = slopes_along(answer, start, unit)
            if kink.any():
                row = [*(f"der({v.name})" for v in self.states), *outputs][int(np.argmax(kink))]
                raise RunError(f"{self.instance.label} cannot be linearised at {name} = {start[i]:.6g}: {row} has "
                               f"another slope on either side.")
            columns.append(slopes)
        answer(start)
        return np.array(columns).reshape(len(columns), n + len(outputs)).T


def slopes_along(answer: Callable[[Array], Array], start: Array, unit: Array) -> tuple[Array, Array]:
    """The derivatives of all answers along `unit`, per unit of that direction's variable, and which have a kink there.

    Central differences of several sizes, each without its third-order part (Richardson). Of each answer that size is
    taken with which the next smaller one agrees best: errors grow with the size by curvature, against it by rounding.
    """
    middle, length = answer(start), np.abs(unit).max()
    found, bends = [], []
    for size in SIZES:
        up, down, half_up, half_down = (answer(start + part * size * unit) for part in (1.0, -1.0, 0.5, -0.5))
        whole, half = (up - down) / 2, half_up - half_down
        found.append((half + (half - whole) / 3) / (size * length))
        bends.append(np.abs(up - 2 * middle + down) / (size * length))
    values = np.array(found)
    best = np.argmin(np.abs(np.diff(values, axis=0)), axis=0)
    slopes = values[best, np.arange(values.shape[1])]
    near, far = bends[3], bends[2]
    noise = NOISE * np.abs(middle) / (SIZES[3] * length)
    return slopes, (near > KEPT * far) & (near > KINK * np.abs(slopes)) & (near > noise)
