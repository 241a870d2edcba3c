"""The paper's claims as computations, shared by the tests and by the script that draws docs/evidence.md's pictures."""
from itertools import product
from types import SimpleNamespace

import casadi
import numpy as np
from evidence import fly
from exact_linear import NoTrim, linear_loop, linear_vehicle

from ahv_ctrl_fmu import backstepping_model, neural, neural_model
from ahv_plant_fmu import model as plant
from fmus import symbols
from fmus.hoist import hoisted
from fmus.interface import internal_steps, names, variables
from fmus.native_code import rates
from fmus.trace import symbol_namespace, trace_model

SPEEDS, ALTITUDES = np.linspace(7500, 9500, 9), np.linspace(80000, 100000, 9)  # ft/s, ft
ENVELOPE = list(product(SPEEDS, ALTITUDES))
EFFECTS = {"V' by fuel ratio": ("B", 0, 0), "gamma' by theta": ("A", 2, 3), "Q' by elevator": ("B", 4, 1)}


def effects(V, h, scale=None):
    """The derivatives of Assumptions 1 and 2 in level flight: ft/s2, 1/s, 1/s2."""
    system = linear_vehicle(plant, V, h, scale)
    return {name: float(getattr(system, matrix)[i, j]) for name, (matrix, i, j) in EFFECTS.items()}


def gamma_zeros(V, h):
    """(unstable pole, right-half-plane zero) of elevator -> flight-path angle, rigid body, 1/s."""
    system = linear_vehicle(plant, V, h)
    zeros = system.zeros("elevator", "gamma")
    return float(system.poles.real.max()), float(zeros.real.max())


def growth(model, gains, V=7700.0, h=85000.0, scale=None):
    """Largest real part (1/s) of the closed loop's poles but the reference filters'; NaN without an equilibrium."""
    try:
        loop = linear_loop(plant, model, gains, V, h, scale=scale)
    except (NoTrim, np.linalg.LinAlgError):
        return np.nan
    poles = loop.cut().poles
    reference = np.roots([1, 0.18, 0.01])
    return max(p.real for p in poles if np.abs(p - reference).min() > 1e-3)


def differentiator_poles(gains):
    """Poles of (13) over R, from its characteristic polynomial."""
    return np.roots([1.0, gains["a4"], gains["a3"], gains["a2"], gains["a1"]])


def operations(model, step=0.01):
    """Elementary operations (+, exp, ...) of one communication step of the native FMU: in the functions it calls."""
    traced = trace_model(model)
    flown = hoisted(traced, rates(traced))
    internal = next((v.start for v in variables(model.VARIABLES) if v.name == "internal_step"), step)
    moves = (casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST)
    called = flown.hold, flown.advance if flown.advances_apart else flown.finish, flown.finish
    hold, advance, finish = (sum(f.instruction_id(i) not in moves for i in range(f.n_instructions())) for f in called)
    return hold + (internal_steps(step, internal) - 1) * advance + finish


def adapted_states():
    """Places in the neural law's state whose rate depends on lambda_1 or lambda_2: what learns."""
    members = names(variables(neural_model.VARIABLES), "parameter")
    inputs = names(variables(neural_model.VARIABLES), "input")
    x, u, p = casadi.SX.sym("x", 19), casadi.SX.sym("u", len(inputs)), casadi.SX.sym("p", len(members))
    rate = neural.derivative(symbols, casadi.SX(0), [x[i] for i in range(19)], symbol_namespace(u, inputs),
                             symbol_namespace(p, members))
    gains = casadi.vertcat(*(p[members.index(n)] for n in ("lambda_1", "lambda_2")))
    by = casadi.jacobian(casadi.vertcat(*rate), gains)
    return sorted(set(by.sparsity().row()))


def nodes(inputs, gains, net, keys):
    """h_j of (11) for every row of `inputs` (rows, len(keys)): shape (rows, NODES)."""
    squared = 0.0
    for column, key in zip(inputs.T, keys):
        low, high, width = (gains[f"net{net}_{key}_{end}"] for end in ("min", "max", "width"))
        centres = np.linspace(low, high, neural.NODES)
        squared = squared + ((column[:, None] - centres) / width) ** 2
    return np.exp(-squared / 2)


def bounds(case, preset):
    """(35) and (64) on a flight: for each channel what the networks should learn (F), how well they could
    (iota), and the sets that follow beside what was flown.

    F is measured: V' - kV Phi, and E' + kh1 E + delta_e1, from the flight's samples.
    """
    gains = neural_model.PRESETS[preset]
    flight = fly(case, preset=preset, step=0.005)
    t = flight.time
    error = flight["plant.V"] - flight["controller.V_reference"]
    integral = np.concatenate([[0], np.cumsum(0.5 * (error[1:] + error[:-1]) * np.diff(t))])
    integral -= gains["kV"] * flight["controller.fuel_ratio"][0] / gains["kV2"]
    phi_0 = -gains["kV1"] * error - gains["kV2"] * integral + np.gradient(flight["controller.V_reference"], t)
    F_1 = np.gradient(flight["plant.V"], t) - gains["kV"] * flight["controller.fuel_ratio"]
    active_1 = nodes(np.column_stack([flight["plant.V"], phi_0]), gains, 1, ("V", "Phi0"))

    E = flight["controller.error_function"]
    F_2 = np.gradient(E, t) + gains["kh1"] * E + flight["controller.network_2"]
    delta_0 = gains["direction"] * gains["kh"] * flight["controller.elevator"] + flight["controller.network_2"]
    active_2 = nodes(np.column_stack([*(flight[f"plant.{n}"] for n in ("gamma", "theta", "Q")),
                                      gains["direction"] * delta_0]), gains, 2, ("gamma", "theta", "Q", "delta0"))
    return SimpleNamespace(
        velocity=sets(t, error, flight["controller.phi_hat_1"], F_1, active_1, gains["kV1"], gains["lambda_1"]),
        altitude=sets(t, E, flight["controller.phi_hat_2"], F_2, active_2, gains["kh1"], gains["lambda_2"]))


def sets(t, error, phi_hat, F, active, gain, rate):
    """The sets (35) or (64) for a channel's error, gain (kV1 or kh1) and adaptation rate.

    Weights of zero (phi = 0) leave all of F to iota; the best weights (least squares on this flight) leave the least.
    """
    middle = slice(5, -5)  # the ends of difference quotients are worse
    F, active, error, phi_hat = F[middle], active[middle], error[middle], phi_hat[middle]
    weights = np.linalg.lstsq(active, F, rcond=1e-6)[0]
    left = float(np.abs(F - active @ weights).max())
    iota = float(np.abs(F).max())
    slack = gain - iota**2 / 2
    return SimpleNamespace(
        iota=iota, iota_best=min(iota, left), iota_allowed=float(np.sqrt(2 * gain)), error=float(np.abs(error).max()),
        radius=float(np.sqrt(1 / slack)) if slack > 0 else None, smallest=float(np.sqrt(1 / gain)),
        phi_hat=float(np.abs(phi_hat).max()), phi_radius=float(np.sqrt(rate)))


LAW_MODELS = {"neural": neural_model, "backstepping": backstepping_model}
