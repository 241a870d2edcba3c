"""Model exchange integrated by a solver of others, fmpy's CVode, against scipy's DOP853 on the models' own equations."""
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from oracle import ClosedLoop
from scipy.integrate import solve_ivp
from solved import Member, solve
from test_plant_accuracy import exact, random_case

import ahv_plant_fmu.model as plant

ACTIONS = ("fuel_ratio", "elevator")
MANY = pytest.param(1000, marks=pytest.mark.slow)


@pytest.fixture(params=["native_fmus", "native_fmi3_fmus"])
def fmus(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def vehicle(fmus):
    member = Member(fmus["AhvPlant"])
    yield member
    member.close()


@pytest.fixture
def law(fmus):
    member = Member(fmus["AhvController"])
    yield member
    member.close()


@pytest.mark.parametrize("count", [5, MANY])
def test_the_plant_with_held_inputs_for_a_second(vehicle, count):
    """It is unstable by itself, so that the solver's error grows: at a relative tolerance of 1e-10 up to about 1e-6
    of nominal in a second, which is why the solver gets 1e-13 here. Where it leaves the model's range it says so."""
    rng, worst, left = np.random.default_rng(1), 0.0, 0
    for _ in range(count):
        start, inputs, structure = random_case(rng)
        vehicle.begin([("start_at_trim", False)], inputs.items(), **start, **structure)
        try:
            reached = solve([vehicle], 1.0, 1e-13)
        except FMICallException as refusal:
            assert refusal.status == 2
            left += 1
            continue
        worst = max(worst, np.max(np.abs(reached - exact(start, inputs, structure, 1.0)) / vehicle.nominal))
    print(f"{count} states, {left} left the model's range: largest error / nominal {worst:.2g}")
    assert worst <= 1e-8 and left < 0.2 * count


@pytest.mark.parametrize("count", [5, MANY])
def test_plant_and_controller_for_a_second_of_closed_loop(vehicle, law, count):
    """From states of Case 1, moved at random, with commands and scales held: both FMUs in one solver at 1e-10."""
    loop, rng, worst = ClosedLoop("case1"), np.random.default_rng(3), 0.0
    times = np.linspace(0.0, 100.0, 1000)
    states = loop.solve(times, rtol=1e-9)
    rate, n = loop.traced_rate(), 9 + law.n
    nominal = np.concatenate([vehicle.nominal, law.nominal])
    for k in rng.permutation(1000)[:count]:
        x = states[k].copy()
        x[:9] += rng.normal(size=9) * 0.05 * vehicle.nominal
        held = vars(loop.inputs(times[k], x[:9]))
        commands = {name: held[name] for name in ("V_command", "h_command")}
        scales = {name: value for name, value in held.items() if name.startswith("scale")}
        law.begin(at_start={"V": loop.x0[0], "h": loop.x0[1], **dict(zip(("gamma", "theta", "Q"), loop.x0[2:5])),
                            **{name: vars(loop.inputs(0.0, loop.x0))[name] for name in commands}}.items())
        vehicle.begin()
        law.set(**commands)
        vehicle.set(**scales)
        vehicle.put(x[:9])
        law.put(x[9:n])

        def wire():
            law.set(**dict(zip(("V", "h", "gamma", "theta", "Q"), vehicle.x[:5])))
            vehicle.set(**dict(zip(ACTIONS, law.get(*ACTIONS))))

        reached = solve([vehicle, law], 1.0, 1e-10, wire)
        right = solve_ivp(lambda _t, y, at=times[k]: rate(at, y), (0.0, 1.0), x, method="DOP853", rtol=1e-13,
                          atol=1e-13 * np.concatenate([nominal, np.ones(len(x) - n)])).y[:n, -1]
        worst = max(worst, np.max(np.abs(reached - right)[:9] / vehicle.nominal))
    print(f"{count} states of the closed loop: largest error / nominal {worst:.2g}")
    assert worst <= 1e-8


def test_co_simulation_is_the_limit(vehicle, python_fmus):
    """The states of both kinds are the same ones, in the same order."""
    assert vehicle.states == plant.STATES
