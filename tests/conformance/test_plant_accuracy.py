"""One step of the plant FMU against scipy's DOP853, from random valid states with held inputs."""
import ctypes
from math import log2, radians
from types import SimpleNamespace

import numpy as np
import pytest
from flying import running
from scipy.integrate import solve_ivp

import ahv_plant_fmu.model as plant
from ahv_plant_fmu.equations import derivative
from fmus import floats

STATES = plant.STATES
STRUCTURES = [plant.PRESETS["decoupled"], plant.PRESETS["estimated-coupling"]]


def random_case(rng):
    """Initial values, inputs and structure within the model's admissible range."""
    start = {"V_start": rng.uniform(7500, 11000), "h_start": rng.uniform(70e3, 135e3),
             "gamma_start": radians(rng.uniform(-5, 5)), "theta_start": radians(rng.uniform(-10, 10)),
             "Q_start": radians(rng.uniform(-10, 10)), "eta1_start": rng.uniform(-2, 2),
             "eta1_dot_start": rng.uniform(-20, 20), "eta2_start": rng.uniform(-2, 2),
             "eta2_dot_start": rng.uniform(-20, 20)}
    inputs = {"fuel_ratio": rng.uniform(0.05, 1.5), "elevator": radians(rng.uniform(-20, 20)),
              **{name: rng.uniform(0.6, 1.4) for name, *_ in plant.VARIABLES if name.startswith("scale")}}
    return start, inputs, STRUCTURES[rng.integers(2)]


def exact(start, inputs, structure, h):
    parameters = {name: value for name, kind, _, value, *_ in plant.VARIABLES if kind == "parameter"}
    p = SimpleNamespace(**{**parameters, **structure})
    u = SimpleNamespace(**{name: value for name, kind, _, value, *_ in plant.VARIABLES if kind == "input"})
    vars(u).update(inputs)
    rate = lambda t, x: derivative(floats, list(x), u.fuel_ratio, u.elevator, plant.scales(u), p)  # noqa: E731
    return solve_ivp(rate, (0, h), list(start.values()), method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


def flown(instance, start, inputs, structure, h, **more):
    instance.simple("fmi2Reset")
    instance.set({"start_at_trim": False, **start, **structure, **more})
    instance.setup(0.0, 1.0)
    instance.simple("fmi2EnterInitializationMode")
    instance.set(inputs)
    instance.simple("fmi2ExitInitializationMode")
    arguments = ctypes.c_double(0.0), ctypes.c_double(h), ctypes.c_int(1)
    instance.check(instance.call("fmi2DoStep", *arguments), "fmi2DoStep", 0.0)
    return np.array(instance.get(STATES))


@pytest.fixture(params=["python", "native"])
def instance(request, python_fmus, native_fmus):
    with running({"python": python_fmus, "native": native_fmus}[request.param]["AhvPlant"]) as instance:
        yield instance


def nominals(instance):
    return np.array([float(instance.file.variables[name].nominal) for name in STATES])


def test_one_step_of_10_ms_is_right_to_1e_9_of_nominal(instance):
    rng, nominal, worst = np.random.default_rng(1), nominals(instance), np.zeros(9)
    for _ in range(1000):
        case = random_case(rng)
        worst = np.maximum(worst, np.abs(flown(instance, *case, 0.01) - exact(*case, 0.01)) / nominal)
    print("largest error / nominal:", dict(zip(STATES, worst)))
    assert worst.max() <= 1e-9


def test_error_shrinks_with_at_least_the_fourth_power_of_the_internal_step(instance):
    rng, nominal, slopes = np.random.default_rng(2), nominals(instance), []
    for _ in range(20):
        case = random_case(rng)
        reference = exact(*case, 0.04)
        errors = [np.max(np.abs(flown(instance, *case, 0.04, internal_step=s) - reference) / nominal)
                  for s in (0.02, 0.01, 0.005)]
        slopes += [log2(errors[0] / errors[1]), log2(errors[1] / errors[2])]
    print("orders:", np.round(sorted(slopes), 2))
    assert np.median(slopes) > 5.5  # the method is of order six
    assert min(slopes) >= 4
