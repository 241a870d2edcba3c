"""The best flight after a jump of the coefficients, as a nonlinear program: CasADi, Hermite-Simpson, IPOPT.

A flight is cut into windows, one for each jump. In a window the inputs are held over each interval, as a control law
that is sampled holds them; the states at the ends of the intervals are unknowns, tied by Simpson's rule. The largest
altitude error is a slack variable, and is made as small as it can be. The vehicle is the rigid one (five states); its
equations are those of `ahv_plant_fmu`, its limits those of `ahv_ctrl_fmu.ports`.
"""
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from ahv_ctrl_fmu.differentiator import filter_rate, filter_step, filter_transition
from ahv_ctrl_fmu.ports import NOMINAL_VEHICLE, SHARED
from ahv_plant_fmu.equations import derivative
from cosim.vehicle import scenario_model
from fmus import floats, symbols

GROUPS = ("thrust", "lift", "drag", "moment")
STATES = ("V", "h", "gamma", "theta", "Q")
UNIT = np.array([10.0, 1.0, 1e-3, 1e-2, 1e-2])       # of an unknown: ft/s, ft, rad, rad, rad/s
INPUT_UNIT = np.array([0.1, 0.1])                    # fuel ratio, elevator (rad)
TICK = 0.01                                          # s: the references are kept on this grid, all intervals lie on it
# (length of an interval, until this long after the jump), s; before a jump that is known the same, mirrored.
AFTER = ((0.01, 1.0), (0.02, 2.0), (0.05, 3.0), (0.1, 10.0))
BEFORE = ((0.01, 1.0),)
SPEED_ERROR = 50.0                                   # ft/s, the largest that is allowed
SMOOTHING = 1e-5  # ft for a change of an input by INPUT_UNIT: of equally good flights the smooth one
JUST = 1e-7       # s before or after a jump
LIMITS = {name: start for name, _, _, start, *_ in SHARED}
GUESSES = 4       # from which a solution is looked for
SPAN = 0.1        # s between the points from which the slow motion's derivatives are taken

Values = Mapping[str, float]
Spans = tuple[tuple[float, float], ...]


def intervals(spans: Spans) -> np.ndarray:
    """Lengths (s) of the intervals of AFTER or BEFORE, from the jump on; shape (intervals,)."""
    ends = [0.0, *(until for _, until in spans)]
    return np.concatenate([np.full(round((until - since) / length), length)
                           for (length, until), since in zip(spans, ends)])


def places(times: np.ndarray) -> np.ndarray:
    """Where times (s) are on the grid of TICK."""
    return np.rint(times / TICK).astype(int)


def rate(m: Any, x: Any, u: Any, scales: Any) -> list[Any]:
    """dx/dt of the rigid vehicle, five numbers; `u` is (fuel ratio, elevator), `scales` in the order of GROUPS."""
    structure = [0.0] * 4  # decoupled: it does not act on the other states
    factors = SimpleNamespace(**dict(zip(GROUPS, scales)), forces=1.0)
    return derivative(m, [*x, *structure], u[0], u[1], factors, NOMINAL_VEHICLE)[:5]


# --- what is given -----------------------------------------------------------------------------------------------

def scales_at(values: Values, times: np.ndarray) -> np.ndarray:
    """The scales of GROUPS from the scenario's parameters, shape (4, times)."""
    p = SimpleNamespace(**values)
    given = [scenario_model.PARAMETERS_OF[f"scale_{group}"](p) for group in GROUPS]
    return np.array([[scenario_model.signal(floats, t, numbers) for t in times.tolist()] for numbers in given])


def jumps(values: Values, stop: float) -> list[float]:
    """Times (s) before `stop` at which a scale jumps: where the gate of its sinusoid opens or closes."""
    found = set()
    for group in GROUPS:
        start, period, length = (values[f"scale_{group}_sine_gate_{key}"] for key in ("start", "period", "length"))
        if values[f"scale_{group}_sine"]:
            opens = np.arange(start, stop, period)
            found |= {*opens.tolist(), *(opens + length).tolist()}
    return sorted(t for t in found if t < stop)


def references(values: Values, stop: float) -> np.ndarray:
    """V_ref and h_ref, their rates and accelerations just before, at each TICK up to `stop`; (2, 3, ticks + 1)."""
    p = SimpleNamespace(**values)
    omega, zeta = LIMITS["reference_omega"], LIMITS["reference_zeta"]
    transition = filter_transition(floats, omega, zeta, TICK)
    found = []
    for name in ("V_command", "h_command"):
        numbers = scenario_model.PARAMETERS_OF[name](p)
        r, rows = [numbers[0], 0.0], [(numbers[0], 0.0, 0.0)]
        for k in range(round(stop / TICK)):
            command = scenario_model.signal(floats, k * TICK, numbers)
            r = filter_step(transition, r, command, command, TICK, omega, zeta)
            rows.append((*r, filter_rate(r, command, omega, zeta)[1]))
        found.append(np.array(rows).T)
    return np.array(found)


@lru_cache
def balance() -> ca.Function:
    """(guess, given) -> theta (rad), fuel ratio, elevator (rad) with which V, gamma and Q change as given."""
    unknown, given = ca.SX.sym("unknown", 3), ca.SX.sym("given", 10)
    V, h, gamma, V_dot, gamma_dot, Q_dot = (given[i] for i in range(6))
    found = rate(symbols, (V, h, gamma, unknown[0], 0.0), (unknown[1], unknown[2]), ca.vertsplit(given[6:]))
    wrong = ca.vertcat((found[0] - V_dot) / 10, 1e3 * (found[2] - gamma_dot), 1e2 * (found[4] - Q_dot))
    return ca.rootfinder("balance", "newton", {"x": unknown, "p": given, "g": wrong})


def slow_motion(values: Values, reference: np.ndarray, at: float) -> tuple[np.ndarray, np.ndarray]:
    """(state, inputs) just before `at` (s) of the vehicle that has flown the references for long: (5,), (2,).

    At t = 0 it is level trim, where all flights start. Elsewhere theta follows from the forces, and its rate and
    acceleration from theta at five times: scales and references are slow beside the vehicle.
    """
    times = at - SPAN * np.arange(4, -1, -1) if at else np.zeros(1)
    scales = scales_at(values, times - JUST)
    V, h = reference[:, :, places(times)]
    gamma = np.arcsin(h[1] / V[0])
    gamma_dot = (h[2] - V[1] * np.sin(gamma)) / (V[0] * np.cos(gamma))
    Q, Q_dot = np.zeros(len(times)), np.zeros(len(times))
    for _ in range(3 if at else 1):
        given = np.vstack([V[0], h[0], gamma, V[1], gamma_dot, Q_dot, scales])
        found = np.array([balance()([0.03, 0.27, 0.2], column).full().ravel() for column in given.T])
        if at:
            theta = np.polynomial.Polynomial.fit(times - at, found[:, 0], len(times) - 1)
            Q, Q_dot = theta.deriv(1)(times - at), theta.deriv(2)(times - at)
    return np.array([V[0, -1], h[0, -1], gamma[-1], found[-1, 0], Q[-1]]), found[-1, 1:]


@dataclass(frozen=True)
class Window:
    """The time around one jump: what is given of it."""
    jump: float             # s
    times: np.ndarray       # (n + 1,), s: the ends of the intervals
    scales: np.ndarray      # (4, 3 n): at the beginning, middle and end of each interval
    references: np.ndarray  # (2, n + 1): V_ref, h_ref
    start: np.ndarray       # (5,): the state
    inputs: np.ndarray      # (2,): what was sent until then
    blind: float            # s from the beginning: the inputs stay as they were

    @property
    def lengths(self) -> tuple[float, ...]:
        """Of the intervals, s."""
        return tuple(np.round(np.diff(self.times), 6).tolist())

    @property
    def held(self) -> np.ndarray:
        """Which intervals have their inputs given, shape (n,)."""
        return self.times[1:] - self.times[0] < self.blind + TICK / 2


def window(values: Values, reference: np.ndarray, jump: float, blind: float | None, after: Spans = AFTER) -> Window:
    """The window of a jump (s); `blind` is None for a controller that knows of the jump before."""
    before = intervals(BEFORE)[::-1] if blind is None and jump else np.empty(0)
    lengths = np.concatenate([before, intervals(after)])
    times = jump - before.sum() + np.concatenate([[0.0], np.cumsum(lengths)])
    inside = np.stack([times[:-1] + JUST, (times[:-1] + times[1:]) / 2, times[1:] - JUST], 1).ravel()
    state, inputs = slow_motion(values, reference, float(times[0]))
    return Window(jump, times, scales_at(values, inside), reference[:, 0, places(times)], state, inputs,
                  blind or 0.0)


# --- the program -------------------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Best:
    """The best flight of a window."""
    FOUND: ClassVar = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
    bound: float            # ft: its largest altitude error
    states: np.ndarray      # (5, n + 1)
    inputs: np.ndarray      # (2, n)
    status: str             # IPOPT's word
    iterations: int
    seconds: float          # of the processor

    @property
    def found(self) -> bool:
        """Whether IPOPT says that this is an optimum."""
        return self.status in self.FOUND


def defect() -> ca.Function:
    """(x0, x1, u, scales (4, 3), length) -> what Hermite-Simpson leaves of an interval, in units of UNIT."""
    x0, x1, u, scales, h = (ca.SX.sym(n, *size) for n, size in (
        ("x0", (5,)), ("x1", (5,)), ("u", (2,)), ("scales", (4, 3)), ("h", (1,))))

    def slope(x: ca.SX, place: int) -> ca.SX:
        return ca.vertcat(*rate(symbols, ca.vertsplit(x), ca.vertsplit(u), ca.vertsplit(scales[:, place])))

    s0, s1 = slope(x0, 0), slope(x1, 2)
    middle = (x0 + x1) / 2 + h / 8 * (s0 - s1)
    return ca.Function("defect", [x0, x1, u, scales, h], [(x1 - x0 - h / 6 * (s0 + 4 * slope(middle, 1) + s1)) / UNIT])


class Program:
    """The nonlinear program of all windows with the same intervals; built once (seconds), solved for many."""

    def __init__(self, lengths: np.ndarray, smoothing: float, speed_error: float):
        """`lengths` of the intervals (s); `smoothing` (ft) and `speed_error` (ft/s) as SMOOTHING and SPEED_ERROR."""
        n = self.n = len(lengths)
        X, U, worst = ca.SX.sym("X", 5, n + 1), ca.SX.sym("U", 2, n), ca.SX.sym("worst")
        scales, wanted = ca.SX.sym("scales", 4, 3 * n), ca.SX.sym("references", 2, n + 1)
        origin, one = ca.SX.sym("origin", 5), defect()
        x = [origin + UNIT * X[:, i] for i in range(n + 1)]
        defects = [one(x[i], x[i + 1], INPUT_UNIT * U[:, i], scales[:, 3 * i:3 * i + 3], float(lengths[i]))
                   for i in range(n)]
        states = ca.horzcat(*x)
        height, speed = ((states[row, :] - wanted[column, :]).T for row, column in ((1, 1), (0, 0)))
        cost = worst + smoothing * ca.sumsqr(U[:, 1:] - U[:, :-1])
        self.solver = ca.nlpsol("bound", "ipopt", {
            "x": ca.vertcat(ca.vec(X), ca.vec(U), worst), "f": cost,
            "g": ca.vertcat(*defects, worst - height, worst + height, speed),
            "p": ca.vertcat(ca.vec(scales), ca.vec(wanted), origin),
        }, {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-7, "max_iter": 400}})
        free = np.full(n + 1, np.inf)
        self.low_g = np.concatenate([np.zeros(5 * n + 2 * (n + 1)), np.full(n + 1, -speed_error)])
        self.high_g = np.concatenate([np.zeros(5 * n), free, free, np.full(n + 1, speed_error)])

    def solve(self, w: Window, start: int = 0) -> Best:
        """The best flight of the window, looked for from guess number `start` (0: the references, flown at trim)."""
        n, origin = self.n, np.array([w.references[0, 0], w.references[1, 0], 0.0, 0.0, 0.0])
        low = np.full((5, n + 1), -np.inf)
        high = -low
        low[:, 0] = high[:, 0] = (w.start - origin) / UNIT
        limits = np.array([[LIMITS[f"{name}_{end}"] for end in ("min", "max")] for name in ("fuel_ratio", "elevator")])
        low_u, high_u = (np.tile((limits[:, [end]] / INPUT_UNIT[:, None]), n) for end in (0, 1))
        sent = np.clip(w.inputs, *limits.T) / INPUT_UNIT
        low_u[:, w.held] = high_u[:, w.held] = sent[:, None]
        x = np.tile(low[:, [0]], n + 1)
        x[:2] = (w.references - origin[:2, None]) / UNIT[:2, None]
        guess = np.concatenate([x.ravel("F"), np.tile(sent, n), [5.0]])
        guess += np.random.default_rng(start).normal(0.0, 0.3 if start else 0.0, len(guess))
        began = time.process_time()
        found = self.solver(
            x0=guess, p=np.concatenate([w.scales.ravel("F"), w.references.ravel("F"), origin]),
            lbx=np.concatenate([low.ravel("F"), low_u.ravel("F"), [0.0]]),
            ubx=np.concatenate([high.ravel("F"), high_u.ravel("F"), [np.inf]]), lbg=self.low_g, ubg=self.high_g)
        seconds, said = time.process_time() - began, self.solver.stats()
        unknowns = found["x"].full().ravel()
        states = origin[:, None] + UNIT[:, None] * unknowns[:5 * (n + 1)].reshape(n + 1, 5).T
        inputs = INPUT_UNIT[:, None] * unknowns[5 * (n + 1):-1].reshape(n, 2).T
        return Best(float(unknowns[-1]), states, inputs, said["return_status"], said["iter_count"], seconds)


@lru_cache
def program(lengths: tuple[float, ...], smoothing: float = SMOOTHING, speed_error: float = SPEED_ERROR) -> Program:
    """The program of windows with intervals of these lengths (s)."""
    return Program(np.array(lengths), smoothing, speed_error)


def best(w: Window) -> Best:
    """The best flight of a window; from other guesses if the first leads to none."""
    solver = program(w.lengths)
    for start in range(GUESSES):
        found = solver.solve(w, start)
        if found.found:
            break
    return found
