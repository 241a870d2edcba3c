"""The oracle of `ahv linearize`: vehicle and closed loop as linear systems, from CasADi's Jacobians of the models.

The vehicle alone is linearised in continuous time, from (1)-(9). The closed loop is linearised as it flies:
sampled, the controller stepped first with the measurements held, then the plant with the controller's outputs
held (Gauss-Seidel), each in its internal steps.

Plants and control laws are model modules (see `fmus.interface`). A plant that is linearised has the inputs of
`ahv_plant_fmu.model`, begins its state with STATES, and has, besides,
    level_trim(m, V, h, p)                              level flight: theta, eta1, eta2, fuel_ratio, elevator
A law has the inputs V, h, gamma, theta, Q, V_command, h_command, the outputs fuel_ratio and elevator, and their limits
as parameters.
"""
from dataclasses import dataclass, replace
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any

import casadi
import numpy as np
import numpy.typing as npt
import scipy.linalg

from fmus import floats, symbols
from fmus.interface import computed, internal_steps, names, variables
from fmus.trace import symbol_namespace, trace_model

Array = npt.NDArray[Any]
DEAD = 1e-5  # a sampled pole below this is one at 0, as accurately as eigenvalues of a deadbeat can be had
STATES = ["V", "h", "gamma", "theta", "Q", "eta1", "eta1_dot", "eta2", "eta2_dot"]
ACTUATORS = ["fuel_ratio", "elevator"]
SENSORS = ["V", "h", "gamma", "theta", "Q"]
COMMANDS = ["V_command", "h_command"]
GROUPS = ["thrust", "lift", "drag", "moment", "forces"]
NEWTON_STEPS, STAGES, ARRIVED = 40, 4, 1e-9  # stages on the way to scaled coefficients
STILL = 1e-5  # a state that changes by less than this of anything in a step is a memory: ARRIVED leaves so much
SCALE = np.array([1e3, 1e3, .01, .01, .01, 1, 20, 1, 20])  # of the plant's states, for the residual


class NoTrim(ValueError):
    """There is no equilibrium to linearise about."""


@dataclass(frozen=True)
class Linear:
    """x' = A x + B u, y = C x + D u with names; `step` 0 means continuous time, else x' is one step later."""
    A: Array
    B: Array
    C: Array
    D: Array
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    step: float = 0.0

    @property
    def poles(self) -> Array:
        """A vector in 1/s, slowest first; of a sampled system those of the continuous one with the same samples."""
        values = np.linalg.eigvals(self.A).astype(complex)
        if self.step:
            values = np.log(np.where(np.abs(values) < DEAD, 1e-300, values)) / self.step
        return by_magnitude(values)

    def zeros(self, source: str, target: str) -> Array:
        """Transmission zeros from one input to one output of a continuous system, 1/s, smallest first: a vector.

        Raises ValueError for a name that is no input or output.
        """
        i, o = self.inputs.index(source), self.outputs.index(target)
        n = len(self.A)
        pencil = np.block([[self.A, self.B[:, [i]]], [self.C[[o]], self.D[[o]][:, [i]]]])
        mass = np.diag([1.0] * n + [0.0])
        values = scipy.linalg.eigvals(pencil, mass)
        return by_magnitude(values[np.isfinite(values) & (np.abs(values) < 1e6)])


def by_magnitude(values: Array) -> Array:
    """`values`, a vector, smallest first."""
    ordered: Array = values[np.argsort(np.abs(values))]
    return ordered


def damping(poles: Array) -> list[float]:
    """Damping ratio of each pole; 1 for one at the origin."""
    return [1.0 if p == 0 else float(-p.real / abs(p)) for p in poles]


@cache
def vehicle_jacobian(plant: ModuleType) -> casadi.Function:
    """(x, u, scale, p) -> (dx/dt, its Jacobian by x, by u), with 9 states, 2 inputs and a factor per group."""
    members = names(variables(plant.VARIABLES), "parameter")
    x, u = casadi.SX.sym("x", 9), casadi.SX.sym("u", 2)
    s, p = casadi.SX.sym("s", len(GROUPS)), casadi.SX.sym("p", len(members))
    inputs = symbol_namespace(casadi.vertcat(u, s), [*ACTUATORS, *(f"scale_{group}" for group in GROUPS)])
    rate = casadi.vertcat(*plant.derivative(symbols, casadi.SX(0), [x[i] for i in range(9)], inputs,
                                            symbol_namespace(p, members)))
    return casadi.Function("vehicle", [x, u, s, p], [rate, casadi.jacobian(rate, x), casadi.jacobian(rate, u)])


def values_of(model: ModuleType, given: dict[str, Any]) -> SimpleNamespace:
    """A model's parameters, those in `given` changed. Raises ValueError for a name that is no parameter."""
    defaults = {v.name: v.start for v in variables(model.VARIABLES) if v.causality == "parameter"}
    unknown = set(given) - set(defaults)
    if unknown:
        raise ValueError(f"{model.NAME} has no parameter {unknown.pop()}.")
    return SimpleNamespace(**{**defaults, **given})


def in_table_order(values: SimpleNamespace) -> list[float]:
    """The values alone, in the order of the table."""
    return [float(v) for v in vars(values).values()]


def linear_vehicle(plant: ModuleType, V: float, h: float, scale: dict[str, float] | None = None,
                   **parameters: float) -> Linear:
    """The vehicle alone about level flight at V (ft/s), h (ft): inputs fuel ratio and elevator, outputs all
    states and the angle of attack. Coefficient groups named in `scale` are multiplied by it.

    Raises NoTrim where level flight cannot be found, ValueError for an unknown parameter.
    """
    p = values_of(plant, parameters)
    s = [1.0 * (scale or {}).get(g, 1.0) for g in GROUPS]
    x, u = vehicle_trim(plant, V, h, s, p)
    _, A, B = (np.array(m) for m in vehicle_jacobian(plant)(x, u, s, in_table_order(p)))
    C = np.vstack([np.eye(9), [0, 0, -1, 1, 0, 0, 0, 0, 0]])
    return Linear(A, B, C, np.zeros((10, 2)), STATES, ACTUATORS, [*STATES, "alpha"])


def nominal_trim(plant: ModuleType, V: float, h: float, p: SimpleNamespace) -> tuple[Array, SimpleNamespace]:
    """The nine states of level flight without any scaling, and all that the plant says of it."""
    nominal = plant.level_trim(floats, V, h, p)
    return np.array([V, h, 0.0, nominal.theta, 0.0, nominal.eta1, 0.0, nominal.eta2, 0.0]), nominal


def vehicle_trim(plant: ModuleType, V: float, h: float, s: list[float], p: SimpleNamespace) -> tuple[Array, Array]:
    """States (9) and inputs (2) of level flight with the groups scaled by `s`: Newton from the nominal trim on theta,
    eta1, eta2, the fuel ratio and the elevator. Raises NoTrim where it does not arrive."""
    x, nominal = nominal_trim(plant, V, h, p)
    u = np.array([nominal.fuel_ratio, nominal.elevator])
    jacobian = vehicle_jacobian(plant)
    free = [3, 5, 7]
    for _ in range(NEWTON_STEPS):
        rate, A, B = (np.array(m) for m in jacobian(x, u, s, in_table_order(p)))
        change = np.linalg.lstsq(np.hstack([A[:, free], B]), -rate.ravel(), rcond=None)[0]
        x[free] += change[:3]
        u += change[3:]
        if np.abs(rate).max() < ARRIVED:
            return x, u
    raise NoTrim(f"No level flight was found at V = {V:g} ft/s, h = {h:g} ft.")


# --- the closed loop, sampled -----------------------------------------------------------------------------

class Sampled:
    """A traced model that is advanced over one communication step, with Jacobians."""

    def __init__(self, model: ModuleType):
        """Trace `model` and differentiate what was traced."""
        self.model = model
        table = variables(self.model.VARIABLES)
        self.inputs, self.parameters, self.outputs = (
            names(table, "input"), names(table, "parameter"), computed(table))
        self.trace = trace_model(self.model)
        n = self.trace.sizes
        t, h = casadi.SX.sym("t"), casadi.SX.sym("h")
        x, u, p, c = (casadi.SX.sym(k, n[k]) for k in "xupc")
        later, y = self.trace.advance(t, h, x, u, p, c), self.trace.outputs(t, x, u, p)
        self.advance = casadi.Function("advance", [h, x, u, p, c],
                                       [later, casadi.jacobian(later, x), casadi.jacobian(later, u)])
        self.shown = casadi.Function("shown", [x, u, p], [y, casadi.jacobian(y, x), casadi.jacobian(y, u)])

    def stepped(self, step: float, x: Array, u: Array, p: SimpleNamespace) -> tuple[Array, Array, Array]:
        """The state after `step` seconds with its Jacobians by x and by u."""
        count = internal_steps(step, p.internal_step) if "internal_step" in self.parameters else 1
        h, numbers = step / count, in_table_order(p)
        c = self.trace.prepare(numbers, h)
        A, B = np.eye(len(x)), np.zeros((len(x), len(u)))
        for _ in range(count):
            later, a, b = (np.array(m) for m in self.advance(h, x, u, numbers, c))
            x, A, B = later.ravel(), a @ A, a @ B + b
        return x, A, B


@cache
def sampled(model: ModuleType) -> Sampled:
    """`model` ready to be stepped; made once."""
    return Sampled(model)


@dataclass(frozen=True)
class Loop:
    """Plant and controller about an equilibrium, ready to be closed or cut anywhere.

    x' = Ap x + Bp v,  z' = Az z + Bz [m, r],  y = Cy z + Dy [m, r]
    with measurements m = x[:5], actuators v = y, commands r; y is what the controller shows after its step.
    """
    x: Array
    z: Array
    y: Array
    Ap: Array
    Bp: Array
    Az: Array
    Bz: Array
    Cy: Array
    Dy: Array
    step: float

    def cut(self, actuator: int | None = None, sensor: int | None = None) -> Linear:
        """The loop with one actuator or sensor cut: from what is put in after the cut to what arrives before it.
        Without a cut: the closed loop, from the two commands to the five measurements and two actuators."""
        nx, nz = len(self.Ap), len(self.Az)
        M = np.eye(5, nx)
        Bm, Br, Dy, Dr = self.Bz[:, :5], self.Bz[:, 5:7], self.Dy[:, :5], self.Dy[:, 5:7]
        Cy = self.Cy
        through_v, through_m = np.ones(2), np.ones(5)
        B = np.vstack([self.Bp @ Dr, Br])
        inputs = COMMANDS
        if actuator is not None:
            through_v[actuator] = 0
            B = np.vstack([self.Bp[:, [actuator]], np.zeros((nz, 1))])
            inputs = [ACTUATORS[actuator]]
        if sensor is not None:
            through_m[sensor] = 0
            B = np.vstack([self.Bp @ Dy[:, [sensor]], Bm[:, [sensor]]])
            inputs = [SENSORS[sensor]]
        seen = np.diag(through_m) @ M
        A = np.block([[self.Ap + self.Bp @ np.diag(through_v) @ Dy @ seen, self.Bp @ np.diag(through_v) @ Cy],
                      [Bm @ seen, self.Az]])
        C = np.block([[M, np.zeros((5, nz))], [Dy @ seen, Cy]])
        D = np.vstack([np.zeros((5, B.shape[1])), Dr if inputs is COMMANDS else np.zeros((2, 1))])
        outputs = [*SENSORS, *ACTUATORS]
        if inputs is not COMMANDS:
            rows = [outputs.index(inputs[0])]
            C, D, outputs = C[rows], D[rows], inputs
        states = [*STATES, *(f"controller[{i}]" for i in range(nz))]
        return Linear(A, B, C, D, states, inputs, outputs, self.step)

    def cuts(self) -> dict[str, Linear]:
        """The loop cut at each actuator and sensor in turn, all other channels closed."""
        return {**{name: self.cut(actuator=i) for i, name in enumerate(ACTUATORS)},
                **{name: self.cut(sensor=i) for i, name in enumerate(SENSORS)}}


def linear_loop(plant: ModuleType, law: ModuleType, gains: dict[str, Any], V: float, h: float, step: float = 0.01,
                scale: dict[str, float] | None = None, parameters: dict[str, float] | None = None) -> Loop:
    """The closed loop that holds V (ft/s), h (ft), about its own equilibrium, with a sample every `step` seconds:
    `gains` are parameters of the law, `parameters` of the plant, `scale` a factor per coefficient group.

    States that take no part (memories, records) are left out. Raises NoTrim where the loop has no equilibrium, or one
    only with an actuator at its limit, and ValueError for an unknown parameter.
    """
    vehicle_model, law_model = sampled(plant), sampled(law)
    pp, pc = values_of(plant, parameters or {}), values_of(law, gains)
    x, nominal = nominal_trim(plant, V, h, pp)
    z = np.array(law_model.trace.start([V, h, 0.0, nominal.theta, 0.0, V, h], in_table_order(pc))).ravel()
    wanted = np.array([float((scale or {}).get(g, 1.0)) for g in GROUPS])
    for part in (np.linspace(0, 1, STAGES + 1)[1:] if np.any(wanted != 1) else [1.0]):
        loop = equilibrium(vehicle_model, law_model, pp, pc, 1 + part * (wanted - 1), x, z, step, np.array([V, h]))
        x, z = loop.x, loop.z
    fuel_ratio, elevator = loop.y
    if not (pc.fuel_ratio_min < fuel_ratio < pc.fuel_ratio_max and pc.elevator_min < elevator < pc.elevator_max):
        raise NoTrim(f"At V = {V:g} ft/s, h = {h:g} ft an actuator is at its limit: fuel ratio {fuel_ratio:.3f}, "
                     f"elevator {np.degrees(elevator):.2f} deg.")
    return without_memory(loop)


def equilibrium(vehicle_model: Sampled, law: Sampled, pp: SimpleNamespace, pc: SimpleNamespace, scale: Array,
                x: Array, z: Array, step: float, commands: Array) -> Loop:
    """The loop about the state that one communication step does not change: Newton from x, z.

    Raises NoTrim where it does not arrive.
    """
    memory = np.zeros(vehicle_model.trace.sizes["x"] - 9)
    actuators = [law.outputs.index(name) for name in ACTUATORS]
    for _ in range(NEWTON_STEPS):
        m = np.array([*x[:5], *commands])
        z1, Az, Bz = law.stepped(step, z, m, pc)
        y, Cz, Dz = (np.array(a)[actuators] for a in law.shown(z1, m, in_table_order(pc)))
        x1, Ap, Bp = vehicle_model.stepped(step, np.array([*x, *memory]), np.array([*y.ravel(), *scale]), pp)
        loop = Loop(x, z, y.ravel(), Ap[:9, :9], Bp[:9, :2], Az, Bz, Cz @ Az, Dz + Cz @ Bz, step)
        residual = np.concatenate([(x1[:9] - x), z1 - z])
        if np.abs(residual[:9] / SCALE).max() < ARRIVED and np.abs(residual[9:]).max() < ARRIVED:
            return loop
        J = loop.cut().A - np.eye(len(residual))
        live = np.abs(J).max(axis=1) > 0
        change = np.zeros(len(residual))
        change[live] = np.linalg.lstsq(J[np.ix_(live, live)], -residual[live], rcond=None)[0]
        x, z = x + change[:9], z + change[9:]
        if not np.isfinite(change).all() or np.abs(x[2:5]).max() > 1:
            break
    raise NoTrim(f"No equilibrium of the loop was found at V = {commands[0]:g} ft/s, h = {commands[1]:g} ft.")


def without_memory(loop: Loop) -> Loop:
    """The loop without states of the law that no step changes, and without those that no later step reads, such as what
    was sent: neither takes part in the motion."""
    J = np.hstack([loop.Az - np.eye(len(loop.Az)), loop.Bz])
    live = np.abs(J).max(axis=1) > STILL
    while True:
        read = live & (np.abs(np.vstack([loop.Az[live], loop.Cy])).max(axis=0) > 0)
        if read.sum() == live.sum():
            break
        live = read
    return replace(loop, z=loop.z[live], Az=loop.Az[np.ix_(live, live)], Bz=loop.Bz[live], Cy=loop.Cy[:, live])
